import re

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
#: A U, open to the top, counter-clockwise; its two reflex corners are (2, 1) and (1, 1).
U_SHAPE = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]


# --- obstacles -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("center", "radius", "message"),
    [
        ((0, np.nan), 1, "disc centre is [0.0, nan]"),
        ((np.inf, 0), 1, "disc centre is [inf, 0.0]"),
        ((0, 0, 0), 1, "disc centre has shape (3,)"),
        (0, 1, "disc centre has shape ()"),
        ([(0, 0)], 1, "disc centre has shape (1, 2)"),
        ("ab", 1, "disc centre is 'ab'"),
        ((0, (1, 2)), 1, "disc centre is (0, (1, 2))"),
        ((2, 3), 0, "radius of the disc at [2.0, 3.0] is 0; give a positive"),
        ((2, 3), -0.5, "radius of the disc at [2.0, 3.0] is -0.5; give a positive"),
        ((2, 3), np.nan, "radius of the disc at [2.0, 3.0] is nan"),
        ((2, 3), np.inf, "radius of the disc at [2.0, 3.0] is inf"),
        ((2, 3), (1, 2), "radius of the disc at [2.0, 3.0] is (1, 2)"),
        ((2, 3), "wide", "radius of the disc at [2.0, 3.0] is 'wide'"),
    ],
)
def test_invalid_disc(center, radius, message):
    with pytest.raises(fs.InvalidWorld, match=re.escape(message)):
        fs.Disc(center, radius)


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ([], "polygon has shape (0,)"),
        ([(0, 0)], "[[0.0, 0.0]] has under three"),
        ([(0, 0), (1, 0)], "[[0.0, 0.0], [1.0, 0.0]] has under three"),
        ([(0, 0), (1, 0), (0, 0)], "[[0.0, 0.0], [1.0, 0.0]] has under three"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "repeats a corner"),
        ([(0, 0), (1, 1), (2, 2)], "[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]] is degenerate (its area"),
        ([(0, 0), (2, 2), (2, 0), (0, 1)], "Self-intersection"),
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], "Self-intersection"),  # touches itself
        ([(0, 0), (1, 0), (np.nan, 1)], "nan"),
        ([(0, 0), (1, 0), (np.inf, 1)], "inf"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "polygon has shape (3, 3)"),
        ([(0, 0), (1, 0), (1,)], "polygon is [(0, 0), (1, 0), (1,)]"),
        (5, "polygon has shape ()"),
        ("abc", "polygon is 'abc'"),
    ],
)
def test_invalid_polygon(vertices, message):
    with pytest.raises(fs.InvalidWorld, match=re.escape(message)):
        fs.Polygon(vertices)


def test_polygon_is_kept_counter_clockwise():
    polygon = fs.Polygon(U_SHAPE[::-1])
    assert shapely.is_ccw(shapely.LinearRing(polygon.vertices))
    assert_array_equal(polygon.vertices, U_SHAPE)
    assert_array_equal(fs.Polygon(U_SHAPE).vertices, U_SHAPE)


def test_closing_corner_is_dropped():
    assert_array_equal(fs.Polygon([*SQUARE, SQUARE[0]]).vertices, SQUARE)


def test_obstacles_keep_a_copy_that_cannot_be_changed():
    center, vertices = np.array([1.0, 2.0]), np.array(SQUARE, float)
    disc, polygon = fs.Disc(center, 1), fs.Polygon(vertices)
    center[:], vertices[:] = 9, 9
    assert_array_equal(disc.center, (1, 2))
    assert_array_equal(polygon.vertices, SQUARE)
    with pytest.raises(ValueError, match="read-only"):
        disc.center[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        polygon.vertices[0] = 0


# --- worlds --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("obstacles", "message"),
    [
        (None, "obstacles is None"),
        (7, "obstacles is 7"),
        (fs.Disc((0, 0), 1), "obstacles is Disc("),
        ([fs.Disc((0, 0), 1), None], "obstacle 2 is None"),
        ([(0, 0, 1)], "obstacle 1 is (0, 0, 1)"),
        ([shapely.Point(0, 0)], "obstacle 1 is <POINT (0 0)>"),
    ],
)
def test_invalid_world(obstacles, message):
    with pytest.raises(fs.InvalidWorld, match=re.escape(message)):
        fs.World(obstacles)


@pytest.mark.parametrize(
    "other",
    [
        fs.Disc((2.5, 0.5), 1.6),  # overlaps
        fs.Disc((2.5, 0.5), 1.5),  # touches
        fs.Disc((0.5, 0.5), 0.1),  # inside
        fs.Disc((0.5, 0.5), 9),  # all round
        fs.Polygon([(0.5, 0.5), (3, 0), (3, 1)]),  # overlaps
        fs.Polygon([(1, 0.5), (3, 0), (3, 1)]),  # touches
        fs.Polygon([(0.2, 0.2), (0.8, 0.2), (0.2, 0.8)]),  # inside
    ],
)
def test_obstacles_must_not_meet(other):
    far = fs.Disc((20, 20), 1)
    with pytest.raises(fs.InvalidWorld, match=r"obstacles 1 .* and 3 .* touch"):
        fs.World([fs.Polygon(SQUARE), far, other])
    with pytest.raises(fs.InvalidWorld, match=r"obstacles 2 .* and 3 .* touch"):
        fs.World([far, other, fs.Polygon(SQUARE)])


def test_discs_must_not_touch():
    with pytest.raises(fs.InvalidWorld, match="touch"):
        fs.World([fs.Disc((0, 0), 1), fs.Disc((3, 4), 4)])
    assert len(fs.World([fs.Disc((0, 0), 1), fs.Disc((3, 4), 3.999)])) == 2


def test_obstacle_in_the_pocket_of_another_does_not_touch_it():
    assert len(fs.World([fs.Polygon(U_SHAPE), fs.Disc((1.5, 2), 0.4)])) == 2


def test_world_keeps_the_order_and_takes_any_iterable():
    obstacles = [fs.Disc((x, 0), 0.1) for x in (3, 1, 2)]
    assert fs.World(iter(obstacles)).obstacles == tuple(obstacles)


def random_discs(rng, n, size):
    """Discs that do not meet, as many of n as fit."""
    discs = []
    for center, radius in zip(rng.uniform(0, size, (n, 2)), rng.uniform(0.1, 1, n), strict=True):
        if all(np.hypot(*(disc.center - center)) > disc.radius + radius for disc in discs):
            discs.append(fs.Disc(center, radius))
    return discs


@pytest.mark.parametrize("gap", [0, 0.1, 0.5, 3])
def test_close_pairs_against_all_pairs(gap):
    rng = np.random.default_rng(8)
    polygon = fs.Polygon(np.subtract(U_SHAPE, (6, 0)))
    world = fs.World([*random_discs(rng, 60, 8), polygon])
    apart = {
        (i, j): shapely.distance(a.core, b.core) - a.radius - b.radius
        for j, b in enumerate(world.obstacles)
        for i, a in enumerate(world.obstacles[:j])
    }
    close = {pair for pair, distance in apart.items() if distance <= gap}
    assert bool(close) == bool(gap)
    first, second = world.close_pairs(gap)
    assert len(first) == len(close)
    assert set(zip(first.tolist(), second.tolist(), strict=True)) == close


def test_distances_by_hand():
    world = fs.World([fs.Disc((0, 0), 1), fs.Polygon(np.add(SQUARE, (4, 0)))])
    assert_allclose(world.distances(shapely.Point(2, 0)), [1, 2])
    assert_allclose(world.distances(shapely.Point(8, 4)), [np.hypot(8, 4) - 1, np.hypot(3, 3)])
    assert_allclose(world.distances(shapely.LineString([(-3, 3), (9, 3)])), [2, 2])
    # Below or at zero where the obstacle is met.
    assert_allclose(world.distances(shapely.Point(0.5, 0)), [-0.5, 3.5])
    assert_allclose(world.distances(shapely.Point(4.5, 0.5)), [np.hypot(4.5, 0.5) - 1, 0])


def test_edges_and_their_distances_belong_to_their_obstacles():
    world = fs.World([fs.Disc((9, 9), 1), fs.Polygon(U_SHAPE), fs.Disc((-9, 9), 2)])
    assert world.edges.shape == (10, 2, 2)
    assert_array_equal(world.first_edge, [0, 1, 9])
    assert_array_equal(world.edges[0], [(9, 9), (9, 9)])
    assert_array_equal(world.edges[1], [(0, 0), (3, 0)])
    assert_array_equal(world.edges[8], [(0, 3), (0, 0)])


def test_a_world_is_a_sequence_of_its_obstacles():
    obstacles = [fs.Disc((9, 9), 1), fs.Polygon(U_SHAPE), fs.Disc((-9, 9), 2)]
    world = fs.World(obstacles)
    assert list(world) == obstacles
    assert world[-1] is obstacles[2]
    assert world[:2] == tuple(obstacles[:2])
    assert repr(world) == "World of 3 obstacles"


def test_corners_are_centres_of_discs_and_convex_corners_of_polygons():
    world = fs.World([fs.Disc((9, 9), 1), fs.Polygon(U_SHAPE)])
    disc, polygon = world.corners
    assert_array_equal(disc, [(9, 9)])
    assert_array_equal(polygon, [corner for corner in U_SHAPE if corner not in ((2, 1), (1, 1))])


def test_empty_world():
    world = fs.World([])
    assert len(world) == 0
    assert world.edges.shape == (0, 2, 2)
    assert world.corners == ()
    assert world.distances(shapely.Point(0, 0)).shape == (0,)
    assert [len(index) for index in world.close_pairs(1)] == [0, 0]
