import numpy as np
import pytest
import shapely
from numpy.testing import assert_array_equal

import freeseg as fs
from freeseg.studies import planning


def test_random_cases_repeat_and_their_ends_are_free(robot):
    sizes = set()
    for seed in range(40):
        world, start, goal = planning.random_case(seed)
        again, *ends = planning.random_case(seed)
        assert_array_equal(world.edges, again.edges)
        assert_array_equal([start, goal], ends)
        assert 1 <= len(world) <= 60
        for end in (start, goal):
            assert world.distances(shapely.Point(end)).min() > robot.radius
        sizes.add(len(world))
    assert len(sizes) > 20


def test_rules_are_compared_with_the_optimum(robot):
    seeds = range(100, 130)
    rows = {row["rule"]: row for row in planning.compare_rules(seeds)}
    assert list(rows) == list(planning.RULES)
    lengths = [planning.try_rules(seed) for seed in seeds]
    for rule, row in rows.items():
        assert row["worlds"] == 30
        assert row["min_clearance_m"] >= robot.radius - 1e-9
        found = [case[rule][0] for case in lengths if np.isfinite(case["exact"][0])]
        assert row["solved"] == np.isfinite(found).sum()
        assert 1 - 1e-3 <= row["median_ratio"] <= row["p95_ratio"] <= row["max_ratio"]
    assert rows["exact"]["solved"] == rows["exact"]["solvable"] > 25
    assert rows["exact"]["max_ratio"] == 1
    assert rows["exact"]["tighter"] == 0
    assert rows["completed"]["solved"] == rows["completed"]["solvable"]
    assert rows["literal"]["solved"] < rows["completed"]["solved"]
    worst = max(
        case["rooms"][0] / case["exact"][0] for case in lengths if np.isfinite(case["rooms"][0])
    )
    assert rows["rooms"]["max_ratio"] == worst


def test_cores_do_not_matter():
    assert planning.compare_rules(range(6), jobs=2) == planning.compare_rules(range(6))


def test_rules_that_solve_nothing_have_no_ratios():
    rows = {row["rule"]: row for row in planning.compare_rules([3])}
    assert rows["literal"]["solved"] == 0
    assert np.isnan(rows["literal"]["max_ratio"])
    with pytest.raises(fs.InvalidParameter, match="seeds is"):
        planning.compare_rules([])
