"""Rivals in pairs: who solves what another does not, and whose tracks are shorter."""

import numpy as np
import pytest
from scipy.stats import binomtest

import freeseg as fs
from freeseg.studies import duels, rivals

BASE = {"outcome": "path", "clearance_m": 0.1, "turning_rad": 0.0, "keeps_m": 0.07, "ms": 1.0}


def row(question, rival, length, optimum=1.0, kind="one"):
    """A row by hand; a length of None is no answer."""
    solved = length is not None
    numbers = {"length_m": length if solved else np.nan, "optimum_m": optimum}
    numbers["equal_m"] = optimum if solved else np.nan
    return (
        BASE
        | {"set": kind, "question": question, "rival": rival, "arrives": solved}
        | {"collides": False}
        | numbers
    )


@pytest.fixture(scope="module")
def rows():
    """Rival a solves all 40, b the first 30, c the last 12 and the first two."""
    found = []
    for k in range(40):
        found.append(row(k, "a", 1.0))
        found.append(row(k, "b", 1.1 if k < 30 else None))
        found.append(row(k, "c", 0.9 if k >= 28 or k < 2 else None))
    return found


def test_questions_of_two_sets_are_kept_apart(rows):
    both = rows + [one | {"set": "other"} for one in rows]
    found = duels.pool(both, ["one", "other"])
    assert found["a"]["questions"] == 80
    assert found["b"]["solved"] == 60
    assert duels.pool(both, ["other"])["b"]["solved"] == 30
    with pytest.raises(fs.InvalidParameter, match="other"):
        duels.pool(both, ["third"])


def test_mcnemar_by_hand(rows):
    found = duels.duel(rows, ["one"])
    assert found.names == ("b", "c")
    assert found.alone.tolist() == [[0, 26], [10, 0]]
    assert found.decided[0, 1] == (binomtest(26, 36).pvalue < 0.05)
    assert (found.decided == found.decided.T).all()
    assert not found.decided.diagonal().any()


def test_a_pair_and_a_share_are_said_in_words(rows):
    found = duels.duel(rows, ["one"])
    said = found.between("c", "b")
    assert said == "c alone solves 10, b alone 26: more than chance"
    with pytest.raises(fs.InvalidParameter, match="rival"):
        found.between("a", "b")  # a fails nowhere
    assert duels.percent(duels.pool(rows, ["one"])["b"]) == "75.0 %"
    with pytest.raises(fs.InvalidParameter, match="pool"):
        duels.percent({})


def test_span_is_over_the_sets(rows):
    by_set = {"one": duels.pool(rows, ["one"])}
    by_set["slow"] = {name: one | {"median_ms": 3.0} for name, one in by_set["one"].items()}
    by_set["slow"]["b"]["median_ms"] = 6.0
    assert duels.span(by_set, "b", "median_ms") == (1.0, 6.0)
    assert duels.span(by_set, "b", "median_ms", over="a") == (1.0, 2.0)
    for some, name, key in ((by_set, "z", "near"), (by_set, "a", "z"), ({}, "a", "near")):
        with pytest.raises(fs.InvalidParameter, match="by_set"):
            duels.span(some, name, key)


@pytest.mark.parametrize("tests", [1, 10])
@pytest.mark.parametrize("counts", [(0, 0), (0, 5), (0, 6), (9, 1), (12, 2), (30, 12), (40, 41)])
def test_a_difference_is_one_where_the_exact_test_says_so(counts, tests):
    # The interval of Clopper and Pearson is that of twice the smaller tail.
    tail = binomtest(min(counts), sum(counts), alternative="less").pvalue if any(counts) else 1
    assert duels.differs(*counts, tests) == (2 * tail < 0.05 / tests)
    assert duels.differs(*counts, tests) == duels.differs(*counts[::-1], tests)


def test_lengths_are_compared_where_both_arrive(rows):
    found = {one["rival"]: one for one in duels.length_ratios(rows, ["one"], "a")}
    assert (found["b"]["both"], found["b"]["shorter"], found["b"]["longer"]) == (30, 0, 30)
    assert found["b"]["decided"]
    for key in ("mean", "low", "high"):
        assert found["b"][key] == pytest.approx(1.1)
    assert (found["c"]["both"], found["c"]["shorter"]) == (14, 14)
    noisy = [one | {"length_m": one["length_m"] * (1 + one["question"] / 100)} for one in rows]
    noisy = [one for one in noisy if one["rival"] != "a"] + rows[::3]
    (other, _) = duels.length_ratios(noisy, ["one"], "a")
    logs = np.log(1.1 * (1 + np.arange(30) / 100))
    half = (np.log(other["high"]) - np.log(other["low"])) / 2
    # About that of a normal mean, at a level for two intervals.
    assert half == pytest.approx(2.24 * logs.std() / np.sqrt(30), rel=0.1)
    assert other["low"] < np.exp(logs.mean()) < other["high"]
    alone = [one for one in rows if one["rival"] == "a" or one["question"] > 39]
    assert duels.length_ratios(alone, ["one"], "a") == []


def test_the_fastest_is_sought_among_those_that_fail_nowhere(rows):
    quick = [one | {"ms": {"a": 3.0, "b": 1.0, "c": 2.0}[one["rival"]]} for one in rows]
    found = duels.pool(quick, ["one"])
    assert duels.fastest(found) == "a"
    whole = duels.pool([one for one in quick if one["question"] in (0, 1)], ["one"])
    assert duels.fastest(whole) == "b"
    assert duels.fastest(whole, 0.5) == "c"
    with pytest.raises(fs.InvalidParameter, match="no rival"):
        duels.fastest(found, 1.5)


def test_the_shortest_is_sought_among_those_that_keep_their_distance(rows):
    some = [one for one in rows if one["rival"] != "c"]
    whole = duels.pool([one for one in some if one["question"] < 30], ["one"])
    assert duels.shortest(whole) == "a"
    close = [one | {"clearance_m": 0.06 + 0.04 * (one["rival"] == "b")} for one in some]
    assert duels.shortest(duels.pool([r for r in close if r["question"] < 30], ["one"])) == "b"
    with pytest.raises(fs.InvalidParameter, match="no rival"):
        duels.shortest({"b": duels.pool(rows, ["one"])["b"]})


def test_scores_of_barn_by_hand():
    lengths = {0: 10.0, 1: 8.0}
    some = [row(0, "a", 9.0, kind="barn"), row(1, "a", 16.0, kind="barn")]
    some += [row(0, "b", 100.0, kind="barn"), row(1, "b", None, kind="barn")]
    # T_0 is 5 s and 4 s: 9 s are too short to count, 16 s are four times as long.
    found = duels.barn_scores(some, lengths)
    assert found["a"] == (pytest.approx((0.5 + 0.25) / 2), 1)
    # The least is an eighth, but for a run that does not arrive.
    assert found["b"] == (pytest.approx(0.125 / 2), 0)
    assert duels.barn_scores(some, lengths, speed=2.0)["a"] == (pytest.approx(0.5), 2)
    with pytest.raises(fs.InvalidParameter, match="world 1"):
        duels.barn_scores(some, {0: 10.0})


def test_tracks_are_those_of_the_rivals(cases):
    question = rivals.pose_question(("paper", "16c"))
    law = fs.VectorFieldHistogram()
    some = {
        "exact": fs.shortest_path,
        "trapped": lambda *asked: fs.react(law, *asked[:4], patience=2),
        "words": fs.literal_plan,
        "none": lambda *asked: None,
    }
    found = duels.tracks_of(some, question)
    assert list(found) == ["exact", "trapped"]
    assert found["exact"].path.length == fs.shortest_path(*question).path.length
    assert isinstance(found["trapped"], fs.Run)


def test_stored_tracks_keep_their_distance_and_arrive():
    found = duels.load_tracks()
    assert list(found) == [("paper", "16c"), ("sparse", 11)]
    for case, tracks in found.items():
        question = rivals.pose_question(case)
        assert len(tracks) == 5
        for points in tracks.values():
            # Stored to a hundredth of a millimetre.
            said = rivals.judge_track(points, *question[:3], within=2e-5)
            assert said["arrives"]
            assert said["clearance_m"] > fs.plan(*question).turning_radius - 2e-5
