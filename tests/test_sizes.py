"""Sizes that fit the paper: measured in the worlds themselves, and drawn evenly."""

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal
from scipy.stats import ks_2samp

import freeseg as fs
from freeseg.data import DATA, read_csv
from freeseg.segments import MARGIN
from freeseg.studies.sizes import (
    LEAST_SIZE,
    Statements,
    by_group,
    make_tables,
    random_sizes,
    senses,
    try_sizes,
)

ROBOT = fs.KheperaIV()


def measured(sizes, shape, margin=MARGIN):
    """The least length (m) by which a statement is true, by segments and distances of worlds."""
    worlds, found = make_tables(sizes, shape), [min(sizes) - LEAST_SIZE]
    for k, sign in ((1, 1), (5, -1)):
        segments = fs.free_segments(worlds[k], ROBOT, margin)
        found += [sign * (segment.length - segment.required) for segment in segments]
    for case in fs.load_cases().values():
        for end in (case.start, case.goal):
            away = worlds[case.table].distances(shapely.Point(end)).min()
            found.append(away - ROBOT.radius - margin / 2)
    for world in worlds.values():
        for i in range(7):
            apart = shapely.distance(world.cores[i], world.cores[:i]) - world.radii[:i]
            found += (apart - world.radii[i]).tolist()
    return min(found)


@pytest.mark.parametrize("shape", ["disc", "square"])
@pytest.mark.parametrize("margin", [0.001, MARGIN, 0.02])
def test_statements_are_those_of_the_worlds(shape, margin):
    for sizes in random_sizes(5, shape, 3, margin):
        slack = Statements(shape, margin).slack(sizes)
        assert slack >= 0
        assert_allclose(slack, measured(sizes, shape, margin), atol=1e-12)


@pytest.mark.parametrize("shape", ["disc", "square"])
def test_statements_that_fail(shape):
    rng = np.random.default_rng(5)
    failed = 0
    for sizes in rng.uniform(0.005, 0.05, (20, 7)):
        slack = Statements(shape).slack(sizes)
        failed += slack < 0
        assert_allclose(slack, measured(sizes, shape), atol=1e-12)
    assert failed > 10


def test_no_equal_sizes_fit():
    for shape in ("disc", "square"):
        assert max(Statements(shape).slack(np.full(7, r)) for r in np.arange(5, 99) / 1000) < 0


def test_sets_are_drawn_evenly():
    # Of a box round all that fit, an even sample is thrown, and what fits is kept.
    walk = random_sizes(400, seed=1)
    statements, rng = Statements("disc"), np.random.default_rng(2)
    low, high = walk.min(0) - 0.002, walk.max(0) + 0.002
    thrown = rng.uniform(np.maximum(low, LEAST_SIZE), high, (400_000, 7))
    sums = thrown[:, :-1] + thrown[:, 1:]
    gaps = np.array(
        [[statements.offsets[k, statements.first == i][0] for i in range(6)] for k in (0, 4)]
    )
    between = np.hypot(*np.moveaxis(gaps, -1, 0))
    fits = (between[0] - sums >= statements.required).all(1)
    fits &= (between[1] - sums <= statements.required).all(1)
    kept = [sizes for sizes in thrown[fits] if statements.slack(sizes) >= 0]
    assert len(kept) > 200
    # Seven tests: at this level, a sound sampler fails one of them once in 1400 runs.
    for obstacle in range(7):
        assert ks_2samp(walk[:, obstacle], np.array(kept)[:, obstacle]).pvalue > 1e-4


def test_equal_seeds_give_equal_sets_and_a_smaller_count_the_first():
    assert_array_equal(random_sizes(3), random_sizes(6)[:3])
    assert not np.array_equal(random_sizes(3), random_sizes(3, seed=1))
    assert_array_equal(random_sizes(2), np.round(random_sizes(2), 5))


def test_sizes_of_the_file():
    counts = try_sizes(fs.load_table(1).radii)
    assert counts["solved"] == counts["possible"] == 16
    assert (counts["greedy"], counts["optimal"], counts["greedy_optimal"]) == (10, 14, 8)
    assert counts["literal"] == counts["as_told"] == 0


def test_a_route_is_told_by_its_senses():
    cases = fs.load_cases()
    plan = fs.plan(fs.load_table(1), cases["16b"].start, cases["16b"].goal)
    assert senses(plan) == (-1, 1)
    assert not by_group(plan)
    assert by_group(fs.plan(fs.load_table(5), cases["16c"].start, cases["16c"].goal))
    # Two corners of one square are one obstacle to turn at.
    world = fs.World([fs.Polygon([(0.3, -0.1), (0.5, -0.1), (0.5, 0.1), (0.3, 0.1)])])
    square = fs.shortest_path(world, (0, 0), (0.8, 0))
    assert len(square.turning_points) == 2
    assert len(senses(square)) == 1


def test_the_study_is_what_it_computes():
    types = {"shape": str, "margin_mm": float, "set": int, "worst_ratio": float}
    counts = ["solved", "greedy", "optimal", "greedy_optimal", "literal", "possible", "as_told"]
    rows = read_csv(DATA / "sizes.csv", types | dict.fromkeys(counts, int))
    assert len(rows) == 2600
    for row in (rows[7], rows[1003], rows[2005], rows[2302]):
        margin = row["margin_mm"] / 1000
        sizes = random_sizes(row["set"] + 1, row["shape"], margin=margin)[-1]
        found = try_sizes(sizes, row["shape"], margin)
        assert {name: row[name] for name in counts} == {name: found[name] for name in counts}
        assert_allclose(row["worst_ratio"], found["worst_ratio"], atol=1e-6)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Statements("ring"), "shape is 'ring'; choose one of"),
        (lambda: Statements("disc", -1), "margin is -1"),
        (lambda: Statements("disc").slack([1, 2]), r"sizes has shape \(2,\)"),
        (lambda: random_sizes(0), "count is 0"),
        (lambda: random_sizes(1, margin=0.06), "margin is 0.06; give one that the sizes"),
        (lambda: make_tables([0.01] * 6 + [0]), "give seven positive lengths"),
        (lambda: by_group(3), "plan is 3"),
        (lambda: senses(None), "plan is None"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(fs.InvalidParameter, match=message):
        call()
