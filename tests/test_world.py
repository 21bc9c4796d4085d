import re

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc

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
        ([(0, 0), (1, 0), (1, 0)], "has under three different corners"),
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
        fs.Polygon(SQUARE),  # a copy
    ],
)
def test_obstacles_may_meet(other):
    far = fs.Disc((20, 20), 1)
    world = fs.World([fs.Polygon(SQUARE), far, other])
    first, second = world.close_pairs(1e-9)
    assert (first.tolist(), second.tolist()) == ([0], [2])
    for planner in (fs.plan, fs.plan_rooms):
        path = planner(world, (-12, -11), (12, 11)).path
        assert world.distances(shapely.LineString(path.sample(0.01))).min() > 0.07


def test_discs_may_touch():
    world = fs.World([fs.Disc((0, 0), 1), fs.Disc((3, 4), 4)])
    assert len(world) == 2
    assert len(world.close_pairs(0)[0]) == 1


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
    assert repr(fs.World(obstacles[:1])) == "World of 1 obstacle"
    bounded = fs.World(obstacles[:1], [(-20, -20), (20, -20), (0, 40)])
    assert repr(bounded) == "World of 2 obstacles, the last of them what is outside the boundary"
    alone = fs.World([], bounded.boundary)
    assert repr(alone) == "World of 1 obstacle, which is what is outside the boundary"


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


# --- outlines as people have them ----------------------------------------------------------------


def test_corners_given_several_times_in_a_row_are_kept_once():
    repeated = [corner for corner in SQUARE for _ in range(3)]
    for given in (repeated, [*repeated, SQUARE[0]], [*repeated, SQUARE[0], SQUARE[0]]):
        assert_array_equal(fs.Polygon(given).vertices, SQUARE)


def test_a_long_outline_that_crosses_itself_has_a_short_message():
    angle = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    outline = np.column_stack([np.cos(angle), np.sin(angle)])
    outline[[100, 101]] = outline[[101, 100]]
    with pytest.raises(fs.InvalidWorld) as caught:
        fs.Polygon(outline)
    text = str(caught.value)
    assert len(text) < 500
    assert re.match(r"polygon crosses or touches itself \(Self-intersection\[0\.99", text)
    assert text.index("give a simple outline") < 120


COURT = [(0.2, 0.2), (0.8, 0.2), (0.8, 0.5), (0.5, 0.5), (0.5, 0.8), (0.2, 0.8)]


@pytest.mark.parametrize("hole", [COURT, COURT[::-1], [*COURT, COURT[0]]])
def test_holes_are_kept_clockwise_and_are_free(hole):
    polygon = fs.Polygon(SQUARE, [hole])
    (kept,) = polygon.holes
    assert not shapely.is_ccw(shapely.LinearRing(kept))
    assert sorted(map(tuple, kept.tolist())) == sorted(COURT)
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 0
    world = fs.World([fs.Disc((5, 5), 1), polygon, fs.Disc((9, 9), 1)])
    assert_allclose(world.distances(shapely.Point(0.3, 0.4))[1], 0.1)
    assert_allclose(world.distances(shapely.Point(0.1, 0.4))[1], 0)
    # Each outline is closed on itself, and one obstacle's edges follow on another's.
    assert_array_equal(world.edge_counts, [1, 10, 1])
    assert_array_equal(world.first_edge, [0, 1, 11])
    lengths = np.hypot(*(world.edges[:, 1] - world.edges[:, 0]).T)
    assert lengths[1:11].sum() == pytest.approx(polygon.core.length)


def test_corners_of_a_hole_that_can_be_turned_round_are_where_the_material_is_convex():
    polygon = fs.Polygon(SQUARE, [COURT])
    assert sorted(map(tuple, polygon.corners.tolist())) == sorted([*SQUARE, (0.5, 0.5)])
    for corner, outward in zip(polygon.corners, polygon.outward, strict=True):
        assert polygon.core.distance(shapely.Point(corner + 1e-3 * outward)) > 0.9e-3


def test_a_path_in_a_hole_is_as_far_from_the_obstacle_as_its_points():
    world = fs.World([fs.Polygon(np.multiply(SQUARE, 4), [np.multiply(COURT, 4)])])
    plan = fs.plan(world, (3, 1.2), (1.2, 3))
    assert plan.turning_points[0].center.tolist() == [2, 2]
    for path in (plan.path, fs.Path([Arc((1.4, 1.4), 0.4, 0, 6)])):
        points = shapely.points(path.sample(1e-4))
        sampled = shapely.distance(points, world.cores[0]).min()
        assert path.clearance(world) == pytest.approx(sampled, abs=1e-6)
    # In the material, also where no outline is near.
    solid = fs.Path([Arc((0.4, 0.4), 0.1, 0, 6)])
    assert solid.clearance(world) == 0
    assert solid.near(world, 0.01)[2].tolist() == [0]


@pytest.mark.parametrize(
    ("holes", "message"),
    [
        ([np.add(COURT, 2)], "holes do not fit into the polygon (Hole lies outside shell"),
        ([np.add(COURT, 0.5)], "holes do not fit into the polygon (Self-intersection"),
        ([COURT, COURT], "holes do not fit into the polygon"),
        ([[(0.2, 0.2), (0.4, 0.4)]], "holes[0] [[0.2, 0.2], [0.4, 0.4]] has under three"),
        ([COURT, [(0.6, 0.6), (0.7, 0.7), (0.7, 0.6), (0.6, 0.7)]], "holes[1] "),
        (COURT, "holes[0] has shape (2,)"),
        (3, "holes is 3"),
        ("ab", "holes is 'ab'"),
    ],
)
def test_invalid_holes(holes, message):
    with pytest.raises(fs.InvalidWorld, match=re.escape(message)):
        fs.Polygon(SQUARE, holes)


# --- boundaries ----------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", [U_SHAPE, U_SHAPE[::-1], fs.Polygon(U_SHAPE)])
def test_a_boundary_is_the_last_obstacle(boundary):
    disc = fs.Disc((0.5, 2), 0.1)
    world = fs.World([disc], boundary)
    assert_array_equal(world.boundary, U_SHAPE)
    assert (len(world), world.frame) == (2, 1)
    assert "boundary" in repr(world)
    assert [world.name_of(index) for index in (0, 1)] == ["obstacle 1", "the boundary"]
    for point in ([0.5, 0.3], [1.5, 0.5], [2.2, 2.9], [0.1, 0.1]):
        inside = shapely.Polygon(U_SHAPE).exterior.distance(shapely.Point(point))
        assert world.distances(shapely.Point(point))[1] == pytest.approx(inside)
    # Only where it is convex for who is inside can one turn round it.
    assert sorted(map(tuple, world.corners[1].tolist())) == [(1, 1), (2, 1)]
    assert fs.free_segments(world) == ()
    # Handed on, the boundary comes along, once and last.
    again = fs.World([*world, fs.Disc((2.5, 2), 0.1)])
    assert (len(again), again.frame) == (3, 2)
    assert_array_equal(again.boundary, U_SHAPE)


def test_without_a_boundary_there_is_no_frame():
    world = fs.World([fs.Disc((0, 0), 1)])
    assert (world.boundary, world.frame) == (None, None)


@pytest.mark.parametrize(
    ("boundary", "message"),
    [
        ([(0, 0), (1, 1)], "boundary [[0.0, 0.0], [1.0, 1.0]] has under three"),
        ([(0, 0), (2, 2), (2, 0), (0, 1)], "boundary crosses or touches itself"),
        (fs.Polygon(SQUARE, [COURT]), "boundary has 1 holes; give its outer outline"),
        ("abc", "boundary is 'abc'"),
        (fs.Disc((0, 0), 1), "boundary is Disc("),
    ],
)
def test_invalid_boundary(boundary, message):
    with pytest.raises(fs.InvalidWorld, match=re.escape(message)):
        fs.World([], boundary)


@pytest.mark.parametrize("planner", [fs.plan, fs.plan_rooms, fs.shortest_path])
def test_who_is_outside_the_boundary_is_refused_as_such(planner):
    world = fs.World([fs.Disc((0.5, 2), 0.1)], U_SHAPE)
    for outside in ((-0.1, 1), (50, 50), (1.5, 2), (3.2, 1)):
        with pytest.raises(
            fs.InvalidQuery, match=r"goal .* is outside the boundary; .*nearest_free"
        ):
            planner(world, (0.5, 0.5), outside)
    with pytest.raises(fs.InvalidQuery, match="is on the edge of the boundary"):
        planner(world, (0, 0.5), (0.5, 0.5))
    with pytest.raises(fs.InvalidQuery, match=r"is 0\.0300 m from the boundary"):
        planner(world, (0.03, 0.5), (0.5, 0.5))


@pytest.mark.parametrize("planner", [fs.plan, fs.plan_rooms, fs.shortest_path])
def test_a_path_turns_inside_a_boundary(planner):
    plan = planner(fs.World([], U_SHAPE), (0.5, 2.5), (2.5, 2.5))
    assert plan.path.length > 3.5
    inner = shapely.Polygon(U_SHAPE).buffer(-plan.robot.radius + 1e-6)
    assert inner.covers(shapely.LineString(plan.path.sample(0.001)))


# --- coordinates anywhere ------------------------------------------------------------------------


def test_round_off_grows_with_coordinates_only_far_out():
    near = fs.World([fs.Disc((1e5, -1e5), 1)])
    far = fs.World([fs.Disc((5e5, 5.2e6), 1)])
    assert near.round_off == 1e-9
    assert 1e-8 < far.round_off < 1e-7
    assert fs.World([]).round_off == 1e-9


def test_positions_beyond_any_map_are_refused():
    for make in (
        lambda: fs.Disc((2e8, 0), 1),
        lambda: fs.Disc((0, 0), 2e8),
        lambda: fs.Polygon(np.multiply(SQUARE, 2e8)),
    ):
        with pytest.raises(fs.InvalidWorld, match=r"beyond 1e\+08 m"):
            make()
    assert len(fs.World([fs.Disc((1e8, 0), 1)])) == 1


@pytest.mark.parametrize("planner", [fs.plan, fs.plan_rooms])
def test_the_paper_s_cases_are_the_same_on_a_projected_map(planner):
    shift = np.array([5e5, 5.2e6])
    for case in fs.load_cases().values():
        world = fs.load_table(case.table)
        moved = fs.World([fs.Disc(disc.center + shift, disc.radius) for disc in world])
        ends = np.array([case.start, case.goal])
        lengths = []
        for obstacles, (start, goal) in ((world, ends), (moved, ends + shift)):
            try:
                plan = planner(obstacles, start, goal)
            except fs.Trapped:
                lengths.append(np.inf)
                continue
            lengths.append(plan.path.length)
            assert plan.path.clearance(obstacles) > plan.robot.radius - 1e-6
        assert lengths[1] == lengths[0] or lengths[1] == pytest.approx(lengths[0], abs=1e-6)
