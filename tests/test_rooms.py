from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay
from worlds import crowded_question, rooms_first

import freeseg as fs
from freeseg.triangulation import RING, triangulate


def ask(seed, planner=rooms_first):
    """What a crowded question leads to: the world and a plan, or the error."""
    world, start, goal, margin = crowded_question(seed)
    try:
        return world, planner(world, start, goal, margin=margin)
    except (fs.NoPath, fs.Trapped) as error:
        return world, error


def pairs_of(world):
    """Obstacles that free segments of the triangulation join."""
    return {segment.obstacles for segment in fs.free_segments(world, neighbours="delaunay")}


# --- the search from room to room ----------------------------------------------------------------


def test_there_is_a_plan_just_where_there_is_a_shortest_path():
    found = []
    for seed in range(700, 850):
        world, start, goal, margin = crowded_question(seed)
        _, plan = ask(seed)
        try:
            best = fs.shortest_path(world, start, goal, margin=margin)
        except fs.NoPath:
            assert isinstance(plan, fs.NoPath)
            found.append(False)
            continue
        assert plan.steps[-1].path is plan.path
        assert plan.steps[0].kind == "straight"
        if plan.path.clearance(world) >= best.turning_radius - 1e-9:
            assert plan.path.length >= best.path.length * (1 - 1e-9)
        found.append(True)
    assert found.count(False) > 5
    assert found.count(True) > 100


def test_the_search_alone_finds_a_path_or_is_trapped():
    trapped = led = 0
    for seed in range(850, 1000):
        world, plan = ask(seed, fs.plan_rooms)
        if isinstance(plan, Exception):
            # It proves nothing, so it never says that there is no path.
            assert isinstance(plan, fs.Trapped)
            assert plan.steps
            assert plan.steps[0].kind == "straight"
            trapped += 1
            continue
        kinds = [step.kind for step in plan.steps]
        # Where the straight way is free, there is nothing to search.
        free = plan.path.length <= np.hypot(*np.subtract(plan.path.end, plan.path.start)) + 1e-9
        assert kinds[:2] == (["straight"] if free else ["straight", "rooms"])
        assert set(kinds[2:]) <= {"case 1", "case 2", "needless turn"}
        assert plan.steps[-1].path is plan.path
        way = shapely.LineString(plan.path.sample(0.001))
        assert world.distances(way).min() >= plan.robot.radius - 1e-4
        assert all(segment.safe for segment in plan.segments)
        if kinds == ["straight", "rooms"]:
            for segment in plan.segments:
                assert way.distance(shapely.LineString(segment.ends)) < 1e-6
            led += len(plan.segments) > 0
    assert trapped > 5
    assert led > 40


def test_turns_are_at_the_ends_of_the_segments_that_the_path_passes():
    turned = outside = 0
    for seed in range(1000, 1080):
        world, plan = ask(seed, fs.plan_rooms)
        if isinstance(plan, Exception):
            continue
        for turn in plan.turning_points:
            assert turn.sense in (1, -1)
            corners = world.corners[turn.obstacle]
            to_corner = np.hypot(*(world.obstacles[turn.obstacle].vertices - turn.center).T)
            reach = plan.turning_radius + world.radii[turn.obstacle]
            assert turn.radius == pytest.approx(reach)
            if turn.endpoint is None:
                # Added where the path was in danger: at a corner.
                assert (turn.center == corners).all(1).any()
                continue
            if turn.endpoint.segment is None:
                # Towards the open space outside, which no segment of the plan leads through.
                outside += 1
                continue
            segment = plan.segments[turn.endpoint.segment]
            end = segment.obstacles.index(turn.obstacle)
            assert segment.ends[end] == pytest.approx(turn.endpoint.point)
            # On the boundary; of a polygon a site may be a point of an edge.
            on = world.cores[turn.obstacle].distance(shapely.Point(turn.endpoint.point))
            assert on == pytest.approx(world.radii[turn.obstacle], abs=1e-9)
            across = np.subtract(segment.ends[1 - end], turn.endpoint.point)
            assert across @ turn.endpoint.outward > 0
            assert to_corner.min() < 0.1
            turned += 1
    assert turned > 40
    assert outside > 5


def test_a_second_question_of_a_world_is_answered_like_the_first_of_a_new_one():
    world, start, goal, margin = crowded_question(10)
    others = [crowded_question(seed) for seed in (11, 12)]
    plans = []
    for _ in range(2):
        plans.append(rooms_first(world, start, goal, margin=margin))
        # Other worlds, and other robots and places in this one, come in between.
        rooms_first(world, goal, start, fs.KheperaIV(0.04, diameter=0.05), 0.01)
        for other in others:
            try:
                rooms_first(*other[:3], margin=other[3])
            except fs.NoPath:
                continue
    fresh = fs.World(world.obstacles)
    plans.append(rooms_first(fresh, start, goal, margin=margin))
    for plan in plans[1:]:
        assert plan.path == plans[0].path
        assert [step.kind for step in plan.steps] == [step.kind for step in plans[0].steps]
        assert [s.obstacles for s in plan.segments] == [s.obstacles for s in plans[0].segments]


def test_a_world_where_the_way_comes_back_to_an_obstacle():
    world = fs.random_world(35, 102084, ("disc",), 0.051019844073802625)
    start, goal = (
        (1.1031225751961689, 0.2986672153930692),
        (-0.0850045706372765, 0.5335192247572271),
    )
    plan = rooms_first(world, start, goal)
    assert plan.path.length < 1.2 * fs.shortest_path(world, start, goal).path.length


def test_in_one_room_no_segment_is_passed():
    world = fs.World([fs.Disc((0, 0), 0.1), fs.Disc((3, 0), 0.1), fs.Disc((1.5, 3), 0.1)])
    plan = fs.plan_rooms(world, (1.3, 0.8), (1.7, 1.2))
    assert plan.segments == ()
    assert plan.turning_points == ()
    assert plan.path.length == pytest.approx(np.hypot(0.4, 0.4))


def test_from_outside_the_triangulation_the_exact_planner_decides():
    world, start, goal = fs.World([fs.Disc((0, 0), 0.1)]), (-100, 0.1), (100, 0.1)
    with pytest.raises(fs.Trapped, match="no safe segments"):
        fs.plan_rooms(world, start, goal)
    plan = rooms_first(world, start, goal)
    assert plan.path.length == fs.shortest_path(world, start, goal).path.length
    assert plan.steps[-1].path is plan.path
    assert [step.kind for step in plan.steps] == ["straight", "shortest"]


def test_a_free_straight_way_needs_no_search():
    world, start, goal = fs.World([fs.Disc((0, 0), 0.1)]), (-100, 1), (100, 1)
    plan = fs.plan_rooms(world, start, goal)
    assert plan.path.length == 200
    assert [step.kind for step in plan.steps] == ["straight"]
    assert plan.segments == plan.turning_points == ()


@pytest.mark.parametrize("count", [0, 1, 2])
def test_worlds_of_hardly_any_obstacle(robot, count):
    obstacles = [fs.Disc((0, 0), 0.2), fs.Polygon([(1, -0.2), (1.4, -0.2), (1.2, 0.3)])]
    world = fs.World(obstacles[:count])
    assert len(fs.free_segments(world, neighbours="delaunay")) == count // 2
    for start, goal in [((-1, 0.01), (2, 0.02)), ((0.6, -2), (0.6, 2)), ((-500, 3), (700, 0))]:
        plan = rooms_first(world, start, goal)
        best = fs.shortest_path(world, start, goal)
        assert best.path.length * (1 - 1e-9) <= plan.path.length < 1.1 * best.path.length
        assert plan.path.clearance(world) >= robot.radius - 1e-9


@pytest.mark.parametrize("neighbours", ["voronoi", None, 3, ["chain"], {}])
def test_unknown_neighbours(neighbours):
    world = fs.World([fs.Disc((0, 0), 0.2)])
    with pytest.raises(fs.InvalidParameter, match=r"choose one of \['chain', 'delaunay'\]"):
        fs.free_segments(world, neighbours=neighbours)


# --- the triangulation ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_equal_discs_are_triangulated_like_their_centres(seed):
    rng = np.random.default_rng(seed)
    centers = rng.permutation(400)[:80, None] // [20, 1] % 20 * 0.5 + rng.uniform(0, 0.3, (80, 2))
    world = fs.World([fs.Disc(center, 0.05) for center in centers])
    expected, certain = set(), set()
    for triangle in Delaunay(centers).simplices.tolist():
        a, b, c = centers[triangle]
        sides = [np.hypot(*(p - q)) for p, q in ((a, b), (b, c), (c, a))]
        area = abs(np.cross([*(b - a), 0], [*(c - a), 0])[2]) / 2
        edges = {tuple(sorted(edge)) for edge in pairwise([*triangle, triangle[0]])}
        expected |= edges
        # A slim triangle at the rim has a circle so large that it holds points of the ring.
        if np.prod(sides) / (4 * area) < 1.5 * np.ptp(centers, axis=0).max():
            certain |= edges
    assert certain <= pairs_of(world) <= expected
    assert len(certain) > 0.95 * len(expected)


@pytest.mark.parametrize("side", [2, 3, 10, 22])
@pytest.mark.parametrize("shape", ["disc", "square"])
def test_grids_have_all_their_short_segments(side, shape):
    square = 0.1 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    places = np.array([divmod(number, side) for number in range(side**2)]) * 0.5
    obstacles = [fs.Disc(p, 0.1) if shape == "disc" else fs.Polygon(p + square) for p in places]
    lengths = [s.length for s in fs.free_segments(fs.World(obstacles), neighbours="delaunay")]
    # Neighbours in rows and columns, and one diagonal in every cell at most: squares' corners may
    # be joined to one another instead, or across both ways.
    short = np.isclose(lengths, 0.3)
    assert short.sum() == 2 * side * (side - 1)
    diagonal = 0.5 * np.sqrt(2) - 0.2 if shape == "disc" else 0.3 * np.sqrt(2)
    assert np.allclose(np.array(lengths)[~short], diagonal)
    assert (~short).sum() == (side - 1) ** 2


@pytest.mark.parametrize("shapes", [("disc",), ("disc", "polygon")])
def test_every_site_is_in_it_and_no_two_edges_cross(shapes):
    for seed in range(20):
        world = fs.random_world(40, seed, shapes, area=0.03)
        rooms = triangulate(world)
        assert set(rooms.triangles.ravel().tolist()) == set(range(len(rooms.points)))
        assert set(rooms.obstacle.tolist()) == set(range(-1, len(world)))
        edges = shapely.linestrings(rooms.points[rooms.edges])
        crossing = shapely.STRtree(edges).query(edges, predicate="crosses")
        assert crossing.size == 0
        # Euler: of the triangles between s sites of which h are on the hull.
        assert len(rooms.triangles) == 2 * len(rooms.points) - 2 - 8


def test_rooms_are_found_by_place():
    world = fs.random_world(30, 1, ("disc", "polygon"))
    rooms = triangulate(world)
    for number, middle in enumerate(rooms.points[rooms.triangles].mean(1)):
        assert rooms.find(middle) == number
    assert rooms.find(np.array([1e3, 0])) is None


def test_more_sites_than_a_product_in_32_bits_can_name():
    # 48 000 discs on a shaken grid, 1 m apart: neighbours are at most a diagonal apart inside.
    side = np.array([240, 200])
    places = np.stack(np.unravel_index(np.arange(48_000), side), axis=-1)
    centers = places + np.random.default_rng(1).uniform(-0.1, 0.1, places.shape)
    world = fs.World([fs.Disc(center, 0.1) for center in centers])
    pairs = triangulate(world).neighbours
    assert (np.unique(pairs) == np.arange(48_000)).all()
    inside = ((places > 2) & (places < side - 3)).all(1)
    apart = np.hypot(*(centers[pairs[:, 0]] - centers[pairs[:, 1]]).T)
    assert apart[inside[pairs].all(1)].max() < 2.2


@given(
    places=st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=12, unique=True),
    start=st.tuples(st.integers(-1, 6), st.integers(-1, 6)),
    goal=st.tuples(st.integers(-1, 6), st.integers(-1, 6)),
    radius=st.sampled_from([0.125, 0.1875, 0.25]),
)
@settings(max_examples=60, derandomize=True, deadline=None)
def test_grids_are_planned_like_the_shortest_path(places, start, goal, radius):
    # Many tangents coincide, many sites lie on one circle; the largest discs leave no way.
    robot, margin = fs.KheperaIV(diameter=0.5), 0.125
    world = fs.World([fs.Disc(place, radius) for place in places])
    ends = np.add([start, goal], 0.5)
    if start == goal:
        return
    try:
        best = fs.shortest_path(world, *ends, robot, margin)
    except fs.NoPath:
        with pytest.raises(fs.NoPath):
            rooms_first(world, *ends, robot, margin)
        return
    plan = rooms_first(world, *ends, robot, margin)
    assert best.path.length * 0.98 <= plan.path.length < 2 * best.path.length
    assert plan.path.clearance(world) >= robot.radius - 1e-9


def test_outlines_that_cross_are_cut_there_once():
    # A noughts-and-crosses board: four bars, which cross in four places of four points each.
    bars = [[(0, y), (3, y), (3, y + 0.1), (0, y + 0.1)] for y in (1, 2)]
    bars += [[(y, x) for x, y in bar] for bar in bars]
    world = fs.World(list(map(fs.Polygon, bars)))
    found = triangulate(world)
    assert len(found.points) == 4 * 4 + 4 * 4 + RING
    crossed = {
        (x + dx, y + dy) for x in (1, 2) for y in (1, 2) for dx in (0, 0.1) for dy in (0, 0.1)
    }
    for place in crossed:
        assert np.hypot(*(found.points - place).T).min() < 1e-9
    # Through the middle room leads no way.
    with pytest.raises((fs.NoPath, fs.Trapped)):
        fs.plan_rooms(world, (1.5, 1.5), (5, 5))
    assert fs.plan_rooms(world, (0.5, 0.5), (0.5, -1)).path.length == pytest.approx(1.5)
