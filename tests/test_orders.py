"""What safety first and length first compute."""

import numpy as np
import pytest
from test_benchmarks import load

import freeseg as fs
from freeseg.data import DATA, read_csv
from freeseg.studies import orders

COUNTS = [
    f"{order}_{operation}"
    for order in ("safety", "length")
    for operation in ("segments", "endpoints", "retries", "distances")
]
COLUMNS = {"n": int, "share": float, "seed": int, "escaped": int} | dict.fromkeys(COUNTS, int)


@pytest.fixture(scope="module")
def stored():
    # The name may be empty, which a column of texts may not.
    rows = read_csv(DATA / "orders.csv", COLUMNS)
    names = [line.split(",")[0] for line in (DATA / "orders.csv").read_text().splitlines()[1:]]
    return [row | {"name": name} for row, name in zip(rows, names, strict=True)]


@pytest.mark.parametrize(
    ("n", "share", "danger"), [(2, 0, 0), (2, 1, 1), (9, 0.5, 4), (40, 0.1, 4)]
)
def test_a_row_has_the_share_of_danger_that_was_asked_for(n, share, danger, robot):
    for seed in range(10):
        world, start, goal = orders.row_of_discs(n, share, seed)
        segments = fs.free_segments(world)
        assert len(world) == n
        assert sum(not segment.safe for segment in segments) == danger
        assert not len(world.close_pairs(0.0)[0])
        assert start[1] < goal[1]
        again = orders.row_of_discs(n, share, seed)
        assert (again[0].edges == world.edges).all()
        assert (again[1:] == np.array([start, goal])).all()


def test_counts_of_a_case_are_those_of_its_plans(cases, tables):
    row = orders.count_operations("15c")
    query = tables[4], cases["15c"].start, cases["15c"].goal
    for order, planner in (("safety", fs.plan), ("length", fs.length_first_plan)):
        effort = planner(*query).effort
        assert row[f"{order}_segments"] == effort.segments
        assert row[f"{order}_endpoints"] == effort.endpoints
        assert row[f"{order}_distances"] == effort.segments + 2 * effort.endpoints
    assert (row["name"], row["n"], row["share"]) == ("15c", 7, 1 / 3)


def test_safety_first_measures_all_and_length_first_evaluates_all():
    for seed in range(20):
        row = orders.count_operations((12, 0.5, seed))
        assert row["safety_segments"] == 11
        assert row["length_segments"] <= 11
        assert row["length_endpoints"] >= row["safety_endpoints"]
        assert row["length_retries"] >= row["safety_retries"]


def test_the_verdict_on_rows_made_up():
    def row(name, n, share, safety, length, segments=2, endpoints=1):
        given = safety, length, segments, endpoints
        names = "safety_distances", "length_distances", "safety_segments", "length_endpoints"
        return {"name": name, "n": n, "share": share} | dict(zip(names, given, strict=True))

    rows = [row("", 3, 0.0, 12, 10), row("", 3, 0.0, 10, 10), row("", 3, 0.0, 2, 0, endpoints=0)]
    rows += [row("", 3, 0.5, 8, 11), row("a", 7, 0.0, 8, 10), row("b", 7, 0.5, 12, 10)]
    first, second, paper = orders.judge_orders(rows)
    assert (first["cases"], first["searched"], first["cheaper"], first["equal"]) == (3, 2, 0, 1)
    assert (first["ratio"], first["known_cheaper"]) == (1.1, 1)
    assert (second["cheaper"], second["share"]) == (1, 0.5)
    assert (paper["set"], paper["cases"], paper["cheaper"]) == ("paper", 2, 1)
    # From +1 in the mean at no danger to -3 at a half.
    assert orders.turning_share(rows) == {3: pytest.approx(0.125)}
    assert np.isnan(orders.turning_share(rows[:2])[3])


def test_stored_counts_are_computed_again(stored):
    names = [row["name"] for row in stored if row["name"]]
    assert names == list(fs.load_cases())
    cases = orders.row_cases()
    assert len(stored) == 16 + len(cases)
    for index in (*range(16), 20, 300, 700):
        row = stored[index]
        case = row["name"] or cases[index - 16]
        again = orders.count_operations(case)
        assert {name: row[name] for name in COUNTS} == {name: again[name] for name in COUNTS}


def test_safety_first_pays_where_over_a_quarter_is_danger(stored):
    # Of n - 1 segments, d are danger: safety first saves the 2 d detours, of two distances each,
    # over their ends and pays for the n - 1 - m segments that length first does not measure.
    for row in stored:
        if row["name"] or not row["length_endpoints"] or row["length_endpoints"] > 7 * row["n"]:
            continue
        d = round(row["share"] * (row["n"] - 1))
        saved = row["length_distances"] - row["safety_distances"]
        assert saved >= 4 * d - (row["n"] - 1 - row["length_segments"])
    turns = orders.turning_share(stored)
    assert list(turns) == list(orders.NUMBERS)
    assert 0.15 < turns[5] < turns[50] < turns[500] < 0.25


def test_benchmark(capsys):
    script = load("orders")
    script.main([(5, 0.25, 0), (5, 0.25, 1)], [5], jobs=1)
    printed = capsys.readouterr().out
    assert "set paper, n 7" in printed
    assert "time of safety first over length first" in printed


@pytest.mark.parametrize(
    ("arguments", "named"), [((1, 0, 0), "n is 1"), ((5, 1.5, 0), "share"), ((10**5, 0, 0), "n is")]
)
def test_what_is_no_row_is_refused(arguments, named):
    with pytest.raises(fs.InvalidParameter, match=named):
        orders.row_of_discs(*arguments)
    with pytest.raises(fs.InvalidParameter, match=named):
        orders.count_operations(arguments)


def test_what_is_no_case_is_refused():
    for bad in ("17a", 5, (1, 2)):
        with pytest.raises(fs.InvalidParameter, match="case is"):
            orders.count_operations(bad)
    for bad in ([], [{"n": 3}], 5):
        with pytest.raises(fs.InvalidParameter, match="rows is"):
            orders.judge_orders(bad)


def test_the_interval_of_a_turning_share_lies_round_it(stored):
    rows = [row for row in stored if row["n"] in (5, 20)]
    found, ends = orders.turning_share(rows), orders.turning_interval(rows, resamples=60)
    assert ends == orders.turning_interval(rows, resamples=60)
    for n in (5, 20):
        low, high = ends[n]
        assert low <= found[n] <= high
        assert high - low < 0.1
    # Where it turns nowhere, there is no interval either.
    same = [row | {"safety_distances": row["length_distances"] + 1} for row in rows]
    assert np.isnan(list(orders.turning_interval(same, resamples=3).values())).all()
