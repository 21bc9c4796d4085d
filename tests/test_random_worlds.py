import os
import subprocess
import sys

import numpy as np
import pytest
import shapely

import freeseg as fs

SHAPES = [("disc",), ("polygon",), ("disc", "polygon")]


def outlines(world):
    """Everything that makes a world, to be compared."""
    return [(type(one).__name__, one.radius, one.vertices.tolist()) for one in world.obstacles]


@pytest.mark.parametrize("shapes", SHAPES)
def test_equal_seeds_give_equal_worlds_and_questions(shapes):
    worlds = [fs.random_world(25, seed, shapes) for seed in (7, 7, np.int64(7), 8)]
    assert outlines(worlds[0]) == outlines(worlds[1]) == outlines(worlds[2])
    assert outlines(worlds[0]) != outlines(worlds[3])
    questions = [np.array(fs.random_query(worlds[0], seed)).tolist() for seed in (7, 7, 8)]
    assert questions[0] == questions[1] != questions[2]


def test_the_order_of_the_shapes_does_not_matter():
    expected = outlines(fs.random_world(20, 1, ("disc", "polygon")))
    for shapes in (["polygon", "disc"], np.array(["disc", "polygon"]), {"disc", "polygon"}):
        assert outlines(fs.random_world(20, 1, shapes)) == expected
    # A set's own order changes from run to run.
    code = "import freeseg as fs; print(fs.random_world(9, 1, {'disc', 'polygon'}).radii.tolist())"
    printed = {
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in "012"
    }
    assert len(printed) == 1


@pytest.mark.parametrize("shapes", SHAPES)
@pytest.mark.parametrize(("n", "area"), [(0, 0.1), (1, 0.1), (2, 0.05), (60, 0.02), (300, 1.0)])
def test_obstacles_are_inside_the_square_and_apart(shapes, n, area):
    world = fs.random_world(n, 3, shapes, area)
    assert len(world) == n
    kinds = {"disc": fs.Disc, "polygon": fs.Polygon}
    assert {type(one) for one in world.obstacles} <= {kinds[shape] for shape in shapes}
    if n >= 60:
        assert {type(one) for one in world.obstacles} == {kinds[shape] for shape in shapes}
    side = np.sqrt(n * area)
    for one in world.obstacles:
        # Polygons lie in circles of such radii, which have their centres in the square.
        assert (one.vertices - one.radius).min() >= -0.06
        assert (one.vertices + one.radius).max() <= side + 0.06
        if isinstance(one, fs.Disc):
            assert 0.015 <= one.radius <= 0.06
            assert (one.center >= 0).all()
            assert (one.center <= side).all()
        else:
            assert 3 <= len(one.vertices) <= 7
            assert shapely.minimum_bounding_radius(one.core) <= 0.06 + 1e-12
    first, second = np.triu_indices(n, 1)
    apart = shapely.distance(world.cores[first], world.cores[second])
    assert (apart > world.radii[first] + world.radii[second]).all()


def test_obstacles_fill_the_whole_square():
    centers = np.array([one.center for one in fs.random_world(400, 5, area=0.1).obstacles])
    side = np.sqrt(40)
    quarters = np.unique((centers > side / 2) @ [1, 2], return_counts=True)[1]
    assert len(quarters) == 4
    assert quarters.min() > 70


@pytest.mark.parametrize("seed", range(20))
def test_start_and_goal_are_free_with_the_margin(seed, robot):
    world = fs.random_world(30, seed, ("disc", "polygon"), area=0.03)
    for asked, margin in [(robot, 0.005), (robot, 0.05), (fs.KheperaIV(0.04, 0.05), 0.001)]:
        ends = np.array(fs.random_query(world, seed, asked, margin))
        assert world.distances(shapely.points(ends)[:, None]).min() > asked.radius + margin / 2
        low, high = world.edges.min((0, 1)), world.edges.max((0, 1))
        assert (ends >= low - asked.diameter).all()
        assert (ends <= high + asked.diameter).all()
        assert (ends[0] != ends[1]).any()


def test_question_in_an_empty_world(robot):
    start, goal = fs.random_query(fs.World([]), 1)
    assert 0 < np.hypot(*(goal - start)) <= 2 * np.sqrt(2) * robot.diameter


def test_question_where_nothing_is_free():
    # A polygon that leaves nothing free in its own bounding box, nor beside it.
    frame = fs.World([fs.Polygon([(0, 0), (9, 0), (9, 9), (0, 9)])])
    with pytest.raises(fs.InvalidWorld, match="less crowded"):
        fs.random_query(frame, 1, margin=0.3)


@pytest.mark.parametrize("n", [-1, 2.0, 1.5, True, "3", None, [1], np.nan])
def test_wrong_number(n):
    with pytest.raises(fs.InvalidParameter, match="n is"):
        fs.random_world(n, 1)


@pytest.mark.parametrize("seed", [-1, 1.5, None, "1", True, [1, 2]])
def test_wrong_seed(seed):
    with pytest.raises(fs.InvalidParameter, match="seed is"):
        fs.random_world(3, seed)
    with pytest.raises(fs.InvalidParameter, match="seed is"):
        fs.random_query(fs.World([]), seed)


@pytest.mark.parametrize(
    "shapes", ["disc", "", (), None, 5, ["box"], ["disc", "box"], [["disc"]], [1, "disc"], [None]]
)
def test_wrong_shapes(shapes):
    with pytest.raises(fs.InvalidParameter, match="shapes is"):
        fs.random_world(3, 1, shapes)


@pytest.mark.parametrize("area", [0, -0.1, np.nan, np.inf, "wide", None, (1, 2)])
def test_wrong_area(area):
    with pytest.raises(fs.InvalidParameter, match="area is"):
        fs.random_world(3, 1, area=area)


@pytest.mark.parametrize("area", [1e-9, 0.001, 0.004])
def test_too_crowded(area):
    with pytest.raises(fs.InvalidWorld, match="20 obstacles do not fit on"):
        fs.random_world(20, 1, area=area)


def test_wrong_question():
    with pytest.raises(fs.InvalidQuery, match="give a World"):
        fs.random_query(None, 1)
    with pytest.raises(fs.InvalidParameter, match="margin is"):
        fs.random_query(fs.World([]), 1, margin=-1)
    with pytest.raises(fs.InvalidParameter, match="robot is"):
        fs.random_query(fs.World([]), 1, robot=3)


def test_worlds_without_end_are_refused():
    with pytest.raises(fs.InvalidParameter, match="n is 1000000000; give at most"):
        fs.random_world(10**9, 0)
    with pytest.raises(fs.InvalidParameter, match="area is 1e"):
        fs.random_world(3, 0, area=1e12)
