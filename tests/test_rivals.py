"""How rivals are judged, and what is stored of them."""

import math

import numba
import numpy as np
import pytest
import shapely
from test_benchmarks import load

import freeseg as fs
from freeseg.data import read_csv
from freeseg.path import Arc, Line
from freeseg.plan import turning_radius
from freeseg.studies import reacting, rivals

DISC = fs.World([fs.Disc((0, 0), 0.1)])
ENDS = (-1.0, 0.3), (1.0, 0.3)


@pytest.fixture(scope="module")
def script():
    """The benchmark as it stands: to compile it takes longer than all that is asked here."""
    compiles, numba.config.DISABLE_JIT = numba.config.DISABLE_JIT, True
    try:
        return load("rivals")
    finally:
        numba.config.DISABLE_JIT = compiles


def test_points_are_judged_by_hand(robot):
    track = [(-1, 0.3), (0, 0.3), (0, 0.6), (1, 0.3)]
    judged = rivals.judge_track(track, DISC, *ENDS)
    down = math.atan2(0.3, 1)
    assert judged["arrives"]
    assert not judged["collides"]
    assert judged["length_m"] == pytest.approx(1.3 + math.hypot(1, 0.3))
    assert judged["clearance_m"] == pytest.approx(0.2)
    # A quarter turn left, and right by a quarter and the slope.
    assert judged["turning_rad"] == pytest.approx(math.pi + down)


def test_a_path_is_judged_as_its_points_are():
    path = fs.Path([Line((-1, 0), (0, 0)), Arc((0, 0.5), 0.5, -math.pi / 2, math.pi / 2)])
    world = fs.World([fs.Disc((0, -0.5), 0.1)])
    ends = (-1, 0), (0.5, 0.5)
    exact = rivals.judge_track(path, world, *ends)
    sampled = rivals.judge_track(path.sample(0.0005), world, *ends)
    assert exact["length_m"] == pytest.approx(1 + math.pi / 4)
    assert exact["clearance_m"] == pytest.approx(0.4)
    assert exact["turning_rad"] == pytest.approx(math.pi / 2, abs=0.003)
    for name, value in exact.items():
        assert sampled[name] == pytest.approx(value, abs=2e-3)


def test_collisions_and_wrong_ends_are_found_whatever_a_planner_says(robot):
    radius = robot.radius
    touching = [(-1, 0.1 + radius - 1e-3), (1, 0.1 + radius - 1e-3)]
    assert rivals.judge_track(touching, DISC, *touching)["collides"]
    beside = [(-1, 0.1 + radius), (1, 0.1 + radius)]
    assert not rivals.judge_track(beside, DISC, *beside)["collides"]
    # Between the points, too.
    assert rivals.judge_track([(-1, 0), (1, 0)], DISC, (-1, 0), (1, 0))["clearance_m"] == -0.1
    short = [ENDS[0], (0.99, 0.3)]
    assert not rivals.judge_track(short, DISC, *ENDS)["arrives"]
    assert rivals.judge_track(short, DISC, *ENDS, within=0.02)["arrives"]
    assert not rivals.judge_track(short[::-1], DISC, *ENDS, within=0.02)["arrives"]


def test_a_track_may_stand_still_and_a_world_be_empty():
    judged = rivals.judge_track([(0, 0)], fs.World([]), (0, 0), (0, 0))
    assert (judged["length_m"], judged["turning_rad"]) == (0, 0)
    assert judged["clearance_m"] == math.inf
    again = rivals.judge_track([(0, 0), (0, 0), (1, 0), (1, 0)], DISC, (0, 0), (1, 0))
    assert again["turning_rad"] == 0
    for bad in ([], [(0, 0, 0)], [(math.nan, 0)], "path", None):
        with pytest.raises(fs.InvalidParameter, match="track"):
            rivals.judge_track(bad, DISC, *ENDS)


class Law:
    """Drive at a constant speed and turn rate."""

    def __init__(self, *command):
        self.command = command

    def start(self, scene, goal, robot, dt):
        return lambda t, pose: self.command


def test_a_run_is_judged_by_the_arcs_driven(robot):
    world = fs.World([fs.Disc((0.5, 0.2), 0.05)])
    run = fs.react(Law(0.2, 0.0), world, (0, 0), (1, 0))
    short = 1 - run.pose[0, -1]
    assert 1e-3 < short < 0.01
    judged = rivals.judge_track(run, world, (0, 0), (1, 0), within=0.01)
    # Who stops short of the goal gains nothing by it.
    assert judged["length_m"] == pytest.approx(1, abs=1e-9)
    assert judged["clearance_m"] == pytest.approx(run.clearance, abs=1e-6)
    assert judged["turning_rad"] == pytest.approx(0, abs=1e-6)
    assert not rivals.judge_track(run, world, (0, 0), (1, 0))["arrives"]
    # On the spot it goes nowhere, and turns no corner.
    spin = fs.drive(lambda t, pose: (0.0, 2.0), (0, 0, 0), 0.05, 100)
    judged = rivals.judge_track(spin, world, (0, 0), (1, 0))
    assert judged["length_m"] == pytest.approx(0, abs=1e-9)
    assert judged["turning_rad"] == 0
    # Each full circle turns by a full turn.
    circle = fs.drive(lambda t, pose: (0.1, 1.0), (0, 0, 0), 0.05, 300)
    turned = rivals.judge_track(circle, world, (0, 0), (1, 0))["turning_rad"]
    assert turned == pytest.approx(circle.pose[2, -1], rel=0.01)


def test_a_law_that_is_trapped_has_a_row_with_its_track(robot):
    def spins(world, start, goal, robot, margin):
        return fs.react(Law(0.0, 1.0), world, start, goal, robot, patience=1)

    def hits(world, start, goal, robot, margin):
        return fs.react(Law(0.2, 0.0), world, start, goal, robot)

    made = {"exact": fs.shortest_path, "spins": spins, "hits": hits}
    rows = {row["rival"]: row for row in rivals.try_rivals(("paper", "16c"), made)}
    assert (rows["spins"]["outcome"], rows["spins"]["arrives"]) == ("Trapped", False)
    assert rows["spins"]["length_m"] == pytest.approx(0, abs=1e-9)
    assert math.isnan(rows["spins"]["equal_m"])
    assert rows["hits"]["outcome"] == "path"
    assert rows["hits"]["collides"]
    found = {
        one["rival"]: one for one in rivals.summarise([{"question": 1} | r for r in rows.values()])
    }
    assert [found[name]["wrong"] for name in made] == [0, 0, 0]


def test_a_track_with_less_clearance_has_an_optimum_of_its_own(robot):
    def near(world, start, goal, robot, margin):
        return fs.shortest_path(world, start, goal, robot, 0.0)

    made = {"exact": fs.shortest_path, "near": near}
    exact, nearer = rivals.try_rivals(("paper", "16c"), made)
    assert exact["equal_m"] == exact["optimum_m"] == exact["length_m"]
    assert nearer["length_m"] < nearer["optimum_m"] - 1e-4
    assert nearer["equal_m"] == pytest.approx(nearer["length_m"], abs=1e-5)
    rows = [{"question": "16c"} | row for row in (exact, nearer)]
    assert rivals.summarise(rows)[1]["equal_ratio"] == pytest.approx(1, abs=1e-5)


def straight(world, start, goal, robot, margin):
    return [start, goal]


def silent(world, start, goal, robot, margin):
    return None


def trapped(world, start, goal, robot, margin):
    raise fs.Trapped("no way on", ())


def test_every_outcome_has_its_row(robot):
    made = {"exact": fs.shortest_path, "line": straight, "none": silent, "stuck": trapped}
    rows = {row["rival"]: row for row in rivals.try_rivals(("paper", "16c"), made)}
    outcomes = {name: row["outcome"] for name, row in rows.items()}
    assert outcomes == {"exact": "path", "line": "path", "none": "no path", "stuck": "Trapped"}
    assert rows["exact"]["length_m"] == rows["exact"]["optimum_m"]
    assert rows["exact"]["keeps_m"] == turning_radius(robot, 0.005)
    assert rows["line"]["collides"]
    assert rows["line"]["arrives"]
    assert math.isnan(rows["stuck"]["length_m"])
    found = {
        row["rival"]: row for row in rivals.summarise(rivals.compare([("paper", "16c")], made))
    }
    assert [found[name]["solved"] for name in made] == [1, 0, 0, 0]
    assert [found[name]["collisions"] for name in made] == [0, 1, 0, 0]
    assert math.isnan(found["line"]["max_ratio"])


def test_a_summary_of_rows_made_up():
    def row(question, rival, length, clearance, ms):
        given = {"set": "a", "question": question, "rival": rival, "length_m": length}
        given |= {"clearance_m": clearance, "ms": ms, "arrives": True, "collides": clearance < 0.1}
        given |= {"outcome": "path", "optimum_m": 1.0, "equal_m": 1.0}
        return given | {"turning_rad": 0.0, "keeps_m": 0.12}

    rows = [row(k, "exact", 1.0, 0.12, 2.0) for k in range(4)]
    rows += [
        row(0, "other", 0.9, 0.12, 1.0),  # shorter, and keeps its distance
        row(1, "other", 0.9, 0.11, 3.0),  # shorter, by coming nearer
        row(2, "other", 0.5, 0.05, 1.0),  # through an obstacle
        row(3, "other", 1.02, 0.12, 1.0),  # faster, but not near the optimum
    ]
    exact, other = rivals.summarise(rows)
    assert (exact["shorter"], exact["faster"], exact["near"]) == (0, 0, 1)
    assert (other["solved"], other["collisions"], other["keeps"]) == (3, 1, 2)
    assert (other["shorter"], other["faster"]) == (1, 1)
    assert other["near"] == pytest.approx(2 / 3)
    assert (other["median_ratio"], other["max_ratio"]) == (0.9, 1.02)


def test_planners_are_compared_on_all_sets():
    cases = [("paper", "13a"), ("sparse", 0), ("medium", 1), ("dense", 2)]
    rows = rivals.compare(cases)
    assert len(rows) == len(cases) * len(rivals.OF_FREESEG)
    assert {row["set"] for row in rows} == {"paper", "sparse", "medium", "dense"}
    for row in rivals.summarise(rows):
        assert row["collisions"] == row["wrong"] == row["shorter"] == 0
        if row["rival"] == "exact":
            assert (row["solved"], row["keeps"], row["max_ratio"]) == (1, 1, 1)
    # What one world had prepared does not serve the next rival.
    again = rivals.compare(cases)
    assert [row["length_m"] for row in again] == pytest.approx(
        [row["length_m"] for row in rows], nan_ok=True
    )


@pytest.mark.parametrize(
    "case", ["13a", ("paper", "17a"), ("crowded", 1), ("sparse", -1), ("sparse", "a"), (1, 2, 3)]
)
def test_what_is_no_case_is_refused(case):
    with pytest.raises(fs.InvalidParameter, match="case is"):
        rivals.pose_question(case)


def test_what_are_no_rivals_or_rows_is_refused():
    for bad in ({"x": 1}, [fs.plan], "plan"):
        with pytest.raises(fs.InvalidParameter, match="rivals"):
            rivals.compare([("paper", "13a")], bad)
    for bad in ([], [{"set": 1}], 3):
        with pytest.raises(fs.InvalidParameter, match="rows is"):
            rivals.summarise(bad)


def test_the_grid_search_finds_paths_of_any_angle(script, robot):
    # Round one disc: longer than the optimum by under a percent, and never too near.
    query = (DISC, (-1.0, 0.02), (1.0, 0.05), robot, 0.005)
    best = fs.shortest_path(*query)
    judged = rivals.judge_track(script.theta_star(*query), *query[:3])
    assert judged["arrives"]
    assert judged["clearance_m"] >= turning_radius(robot, 0.005) - 1e-9
    assert best.path.length <= judged["length_m"] < 1.01 * best.path.length
    # Where the way is free it is straight.
    free = script.theta_star(DISC, (-1.0, 0.5), (1.0, 0.61), robot, 0.005)
    assert len(free) == 2
    # Where a wall of discs leaves no way, there is none.
    angles = np.arange(12) * np.pi / 6
    ring = fs.World([fs.Disc((0.3 * np.cos(angle), 0.3 * np.sin(angle)), 0.08) for angle in angles])
    assert script.theta_star(ring, (0.0, 0.0), (1.0, 1.0), robot, 0.005) is None


def test_the_check_of_lines_is_shapelys(script):
    rng = np.random.default_rng(1)
    world = fs.random_world(20, 3, ("disc", "polygon"))
    edge, keep = world.edges.reshape(-1, 4), np.repeat(world.radii + 0.05, world.edge_counts)
    lines = rng.uniform(0, 1.4, (300, 2, 2))
    found = [script.is_clear(*line.ravel(), edge, keep) for line in lines]
    inside = [shapely.intersects(world.cores, shapely.Point(line[0])).any() for line in lines]
    wanted = [world.distances(shapely.LineString(line)).min() >= 0.05 for line in lines]
    # A line wholly inside of a polygon meets no edge.
    assert [f for f, i in zip(found, inside, strict=True) if not i] == [
        w for w, i in zip(wanted, inside, strict=True) if not i
    ]
    assert 30 < sum(wanted) < 270


def test_benchmark(script, capsys, monkeypatch):
    # The packages that are no part of the environment are left out.
    monkeypatch.setattr(script, "ELSEWHERE", {"grid": (straight, "numba")})
    script.main(["--quick"])
    printed = capsys.readouterr().out
    for line in ("paper: 2 questions, 2 with a path", "dense: 1 questions", "exact  ", "grid  "):
        assert line in printed


def test_growth(script, capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(script, "triangulation", straight)
    monkeypatch.setattr(script, "warm_up", lambda rivals: None)
    script.grow((3, 6), 2, tmp_path / "growth.csv")
    assert "3: " in capsys.readouterr().out
    rows = read_csv(tmp_path / "growth.csv", {"n": int, "seed": int, "rival": str, "ms": float})
    assert [(row["n"], row["seed"]) for row in rows[::2]] == [(3, 0), (6, 0), (3, 1), (6, 1)]
    assert {row["rival"] for row in rows} == {"exact", "triangulation"}


@pytest.fixture(scope="module")
def stored():
    return rivals.load_rivals()


def test_what_is_stored_is_what_was_compared(tmp_path):
    rows = rivals.compare(
        [("paper", "13a"), ("dense", 3)], {"exact": fs.shortest_path, "x": silent}
    )
    file = tmp_path / "rivals.npz"
    rivals.save_rivals(rows, file)
    found = rivals.load_rivals(file)
    assert [(row["set"], row["question"]) for row in found[::2]] == [("paper", "13a"), ("dense", 3)]
    for row, again in zip(rows, found, strict=True):
        for name, kind in rivals.STORED.items():
            if kind in (str, bool):
                assert again[name] == row[name]
            else:
                assert again[name] == pytest.approx(row[name], rel=1e-6, nan_ok=True)
    assert found[0]["length_m"] == rows[0]["length_m"]


def test_other_files_are_refused(tmp_path, stored):
    file = tmp_path / "rivals.npz"
    with pytest.raises(fs.InvalidData, match="cannot be read"):
        rivals.load_rivals(file)
    for content in (b"", b"PK", b"set,rival"):
        file.write_bytes(content)
        with pytest.raises(fs.InvalidData, match="cannot be read"):
            rivals.load_rivals(file)
    np.savez(file, set=np.array(["a"]))
    with pytest.raises(fs.InvalidData, match="cannot be read"):
        rivals.load_rivals(file)
    columns = {
        name: np.array([row[name] for row in stored[:2]], kind)
        for name, kind in rivals.STORED.items()
    }
    for bad in ({"ms": columns["ms"][:1]}, {"ms": columns["set"]}, {"arrives": columns["ms"]}):
        np.savez(file, **columns | bad)
        with pytest.raises(fs.InvalidData, match="holds no such"):
            rivals.load_rivals(file)
    np.savez(file, **columns | {"rival": columns["rival"][[0, 0]]})
    with pytest.raises(fs.InvalidData, match="twice"):
        rivals.load_rivals(file)
    with pytest.raises(fs.InvalidData, match="cannot be written"):
        rivals.save_rivals(stored[:2], tmp_path / "nowhere" / "rivals.npz")


def test_all_rivals_were_asked_the_same_questions(stored):
    asked = {}
    for row in stored:
        asked.setdefault(row["rival"], []).append((row["set"], row["question"]))
    assert rivals.OF_FREESEG.keys() | reacting.REACTIVE.keys() <= asked.keys()
    questions = set(asked[rivals.EXACT])
    assert all(set(some) == questions for some in asked.values())
    assert {kind for kind, _ in questions} == {"paper", "barn", *rivals.DENSITIES}
    assert sum(kind == "paper" for kind, _ in questions) == 16


def test_stored_rows_are_those_of_legal_planners(stored):
    rows = rivals.summarise(stored)
    for row in rows:
        assert row["shorter"] == 0
        if row["rival"] == rivals.EXACT:
            assert row["solved"] == row["keeps"] == row["solvable"]
        if row["rival"] in rivals.OF_FREESEG:
            assert row["collisions"] == row["wrong"] == 0
    by_name = {(row["set"], row["rival"]): row for row in rows}
    # As test_literal.py finds.
    assert by_name["paper", "paper, its words"]["solved"] == 13


def test_laws_that_do_not_arrive_say_so(stored):
    for row in stored:
        if row["rival"] in reacting.REACTIVE:
            assert row["outcome"] == ("path" if row["arrives"] else "Trapped")
            assert row["length_m"] >= 0


def test_some_stored_rows_are_found_again(stored):
    known = {(row["set"], row["question"], row["rival"]): row for row in stored}
    asked = [("paper", "16c"), ("sparse", 2), ("dense", 5)]
    for row in rivals.compare(asked, rivals.OF_FREESEG | reacting.reactive_rivals()):
        before = known[row["set"], row["question"], row["rival"]]
        for name in ("outcome", "arrives", "collides"):
            assert row[name] == before[name]
        for name in ("length_m", "optimum_m", "equal_m", "clearance_m"):
            assert row[name] == pytest.approx(before[name], rel=1e-6, nan_ok=True)
