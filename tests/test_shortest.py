import json
import re

import numpy as np
import oracle
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from worlds import crowded_question, rooms_first, transformed

import freeseg as fs
from freeseg.planners import tangent_search
from freeseg.planners.compilation import compiled
from freeseg.planners.query import ask
from freeseg.planners.route import shortest_route
from freeseg.segments import MARGIN

#: A square round the origin.
SQUARE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


def turn_by(angle):
    """Matrix of a rotation."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def sampled_clearance(path, world, step=0.001):
    """Least distance of samples of a path from the obstacles, by Shapely."""
    return world.distances(shapely.multipoints(path.sample(step))).min(initial=np.inf)


def length_or_inf(world, start, goal, robot=None, margin=MARGIN):
    """Length of the shortest path; infinite where there is none."""
    try:
        return fs.shortest_path(world, start, goal, robot, margin).path.length
    except fs.NoPath:
        return np.inf


def check_optimum(world, start, goal, robot, margin=MARGIN):
    """The shortest path is as long as that of all tangents, and keeps its distance."""
    keep = np.full(len(world), robot.radius + margin / 2)
    for end in (start, goal):
        keep = np.minimum(keep, world.distances(shapely.Point(end)) * (1 - 1e-9))
    optimum = oracle.shortest_way(world, start, goal, keep)
    if np.isinf(optimum):
        with pytest.raises(fs.NoPath):
            fs.shortest_path(world, start, goal, robot, margin)
        return optimum
    path = fs.shortest_path(world, start, goal, robot, margin).path
    assert path.length == pytest.approx(optimum, rel=1e-9)
    assert sampled_clearance(path, world, robot.radius / 50) >= keep.min() - 1e-9
    return optimum


def optimum_round_all(world, start, goal, robot):
    """Length of the shortest way round all obstacles at once; infinite where there is none."""
    query = ask(world, start, goal, robot, MARGIN)
    try:
        return shortest_route(query).path.length
    except fs.NoPath:
        return np.inf


@pytest.mark.parametrize("name", fs.load_cases())
def test_published_cases_against_exhaustion(name, cases, tables, robot):
    case, world = cases[name], tables[cases[name].table]
    centers = np.array([disc.center for disc in world.obstacles])
    radii = world.radii + robot.radius + MARGIN / 2
    optimum, _ = oracle.shortest(case.start, case.goal, centers, radii)
    plan = fs.shortest_path(world, case.start, case.goal)
    assert plan.path.length == pytest.approx(optimum, rel=1e-9)
    assert plan.path.clearance(world) >= robot.radius + MARGIN / 2 - 1e-9


def test_obstacles_met_decide_for_the_whole_world(robot):
    # The loop leaves obstacles out; the optimum must be that of all of them.
    rng, found, spared = np.random.default_rng(51), 0, 0
    for _ in range(100):
        obstacles = []
        for center, size in zip(
            rng.uniform(0, 1.5, (14, 2)), rng.uniform(0.02, 0.15, 14), strict=True
        ):
            corners = center + size * np.array([(-1, -1), (1, -0.5), (0.2, 1)])
            obstacle = fs.Disc(center, size) if rng.random() < 0.5 else fs.Polygon(corners)
            if not len(fs.World([*obstacles, obstacle]).close_pairs(0)[0]):
                obstacles.append(obstacle)
        world = fs.World(obstacles)
        start, goal = (-0.3, rng.uniform(0, 1.5)), (1.8, rng.uniform(0, 1.5))
        plan = fs.shortest_path(world, start, goal)
        expected = optimum_round_all(world, start, goal, robot)
        assert plan.path.length == pytest.approx(expected, rel=1e-9)
        back = fs.shortest_path(world, goal, start)
        assert back.path.length == pytest.approx(expected, rel=1e-9)
        found += len(plan.turning_points) > 1
        spared += len(plan.steps[-1].group) < len(world)
    assert found > 50
    assert spared > 90


def test_no_path_out_of_a_ring():
    angles = 2 * np.pi * np.arange(8) / 8
    ring = fs.World([fs.Disc((0.3 * np.cos(a), 0.3 * np.sin(a)), 0.08) for a in angles])
    with pytest.raises(fs.NoPath, match="leave no way"):
        fs.shortest_path(ring, (0, 0), (1, 1))


def test_no_obstacle_and_invalid_input():
    plan = fs.shortest_path(fs.World([]), (0, 0), (3, 4))
    assert plan.path.length == pytest.approx(5)
    with pytest.raises(fs.InvalidQuery, match="finite"):
        fs.shortest_path(fs.World([]), (0, np.nan), (3, 4))
    with pytest.raises(fs.InvalidParameter, match="margin"):
        fs.shortest_path(fs.World([]), (0, 0), (3, 4), margin=-1)


# --- complete and optimal ------------------------------------------------------------------------


def test_discs_and_polygons_against_all_tangents(robot):
    longer = impossible = 0
    for seed in range(90):
        world, start, goal, margin = crowded_question(seed, most=9)
        optimum = check_optimum(world, start, goal, robot, margin)
        impossible += np.isinf(optimum)
        longer += np.hypot(*(goal - start)) * (1 + 1e-6) < optimum < np.inf
    assert longer > 20
    assert impossible > 0


def test_a_path_exists_just_where_a_grid_has_one(robot):
    undecided, answers = 0, []
    for seed in range(300):
        world, start, goal, margin = crowded_question(seed, most=45)
        reach = robot.radius + margin / 2
        may, must = oracle.may_and_must_connect(world, start, goal, reach, cell=0.004)
        length = length_or_inf(world, start, goal, margin=margin)
        if may == must:
            assert np.isfinite(length) == may
            answers.append(may)
        else:
            undecided += 1
    # Where one and a half cells decide, the grid cannot tell.
    assert undecided < 90
    assert answers.count(False) > 10


@st.composite
def city_blocks(draw):
    """Blocks of unit squares, seldom convex, turned by any angle; and two crossings of lanes."""
    size = draw(st.integers(2, 5))
    built = np.zeros((size + 2, size + 2), bool)
    cells = draw(st.lists(st.booleans(), min_size=size**2, max_size=size**2))
    built[1:-1, 1:-1] = np.reshape(cells, (size, size))
    built[1, 1] = True
    # Blocks that touch at a corner only are joined.
    while True:
        a, b, c, d = built[:-1, :-1], built[:-1, 1:], built[1:, :-1], built[1:, 1:]
        touch = np.argwhere(((a & d) & ~(b | c)) | ((b & c) & ~(a | d)))
        if not len(touch):
            break
        row, column = touch[0]
        built[row : row + 2, column : column + 2] = True
        built[[0, -1]] = built[:, [0, -1]] = False
    squares = [shapely.box(*cell, *(cell + 1)) for cell in np.argwhere(built)]
    blocks = shapely.get_parts(shapely.union_all(squares))
    # A block with a yard is filled, whatever stands in it.
    filled = shapely.get_parts(shapely.union_all([shapely.Polygon(b.exterior) for b in blocks]))
    world = fs.World([fs.Polygon(block.exterior.coords) for block in filled])
    lanes = [cell + 0.5 for cell in np.argwhere(~built)]
    lanes = [place for place in lanes if world.distances(shapely.Point(place)).min(initial=1) > 0]
    places = st.integers(0, len(lanes) - 1)
    ends = draw(st.lists(places, min_size=2, max_size=2, unique=True))
    world, move = transformed(world, turn_by(draw(st.sampled_from([0, np.pi / 4, 1.0]))))
    return world, *move([lanes[end] for end in ends])


@given(question=city_blocks(), diameter=st.sampled_from([0.3, 0.9, 0.99]))
@settings(max_examples=60, derandomize=True, deadline=None)
def test_non_convex_polygons_against_all_tangents(question, diameter):
    # Lanes are 1 m wide: with its margin the widest robot does not fit.
    check_optimum(*question, fs.KheperaIV(diameter=diameter), margin=0.04)


MOTIONS = {
    "turned": (turn_by(1.1), (0, 0)),
    "turned by a quarter": (turn_by(np.pi / 2), (0, 0)),
    "shifted": (np.eye(2), (-37.1, 58.3)),
    "mirrored": (np.diag([1, -1]), (0, 0)),
    "larger": (7.3 * np.eye(2), (0, 0)),
    "smaller": (0.02 * np.eye(2), (0, 0)),
    "all of it": (3 * turn_by(-2) @ np.diag([-1, 1]), (5, 9)),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_optimum_does_not_depend_on_the_frame_nor_on_the_scale(robot, motion):
    matrix, shift = MOTIONS[motion]
    scale = np.sqrt(abs(np.linalg.det(matrix)))
    scaled = fs.KheperaIV(scale * robot.wheel_base, scale * robot.diameter)
    lengths = []
    for seed in range(40):
        world, start, goal, margin = crowded_question(seed, most=30)
        moved, move = transformed(world, matrix, shift)
        length = length_or_inf(world, start, goal, robot, margin)
        there = length_or_inf(moved, move(start), move(goal), scaled, scale * margin)
        back = length_or_inf(moved, move(goal), move(start), scaled, scale * margin)
        assert there == pytest.approx(scale * length, rel=1e-9)
        assert back == pytest.approx(there, rel=1e-9)
        lengths.append(length)
    assert 1 <= np.isinf(lengths).sum() < 20


@pytest.mark.parametrize(
    "planner",
    [
        fs.plan,
        rooms_first,
        fs.plan_rooms,
        fs.shortest_path,
        fs.literal_plan,
        lambda *ask, **more: fs.literal_plan(*ask, **more, concentric=True),
    ],
    ids=["chain", "rooms", "rooms only", "shortest", "literal", "literal, concentric"],
)
def test_no_planner_returns_a_path_that_is_too_close(robot, planner):
    found = 0
    for seed in range(500, 560):
        world, start, goal, margin = crowded_question(seed)
        try:
            path = planner(world, start, goal, margin=margin).path
        except (fs.NoPath, fs.Trapped):
            continue
        found += 1
        assert sampled_clearance(path, world) >= robot.radius - 1e-9
        assert path.start == pytest.approx(tuple(start), abs=1e-9)
        assert path.end == pytest.approx(tuple(goal), abs=1e-9)
    assert found > 15


# --- nasty worlds --------------------------------------------------------------------------------


def comb(teeth):
    """Walls 1 m apart and 4 m high between a floor and a ceiling, open by turns above and below."""
    walls = [(x, 0.5 * (x % 2), x + 0.1, 0.5 * (x % 2) + 4) for x in range(teeth)]
    boxes = [*walls, (-30, -0.2, 30, -0.1), (-30, 4.6, 30, 4.7)]
    return fs.World([fs.Polygon(shapely.box(*box).exterior.coords) for box in boxes])


def spiral(turns):
    """One wall that winds round the origin in squares 1 m apart."""
    headings = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    points = [np.array([0.0, 0.0])]
    for leg in range(4 * turns):
        points.append(points[-1] + (leg // 2 + 1) * headings[leg % 4])
    line = shapely.LineString(points)
    wall = line.buffer(0.05, cap_style="square", join_style="mitre")
    return fs.World([fs.Polygon(wall.exterior.coords)])


@pytest.mark.parametrize("planner", [None, fs.plan, rooms_first])
def test_the_path_winds_through_a_comb(robot, planner):
    world, start, goal = comb(5), (-1, 2), (5, 2)
    optimum = check_optimum(world, start, goal, robot)
    # Up from 2 m to over 4 m, down to under 0.5 m and so on, and in the end down to 2 m.
    assert 2 + 4 * 3.5 + 2 < optimum < 2 + 4 * 3.5 + 2 + 6
    if planner:
        path = planner(world, start, goal).path
        assert optimum * 0.98 < path.length < 1.3 * optimum
        assert sampled_clearance(path, world) >= robot.radius - 1e-9


@pytest.mark.parametrize("planner", [None, fs.plan, rooms_first])
def test_the_path_unwinds_a_spiral(robot, planner):
    world, start, goal = spiral(3), (0.5, 0.5), (20, 0.5)
    optimum = check_optimum(world, start, goal, robot)
    # Almost as long as the wall between them, which is 42 m: the lane is 1 m wide.
    assert 28 < optimum < 60
    if planner:
        path = planner(world, start, goal).path
        assert optimum * 0.98 < path.length < 1.3 * optimum
        assert sampled_clearance(path, world) >= robot.radius - 1e-9


def test_slivers_and_spikes(robot):
    # A needle 1 m long and 1 um thick, and a star with spikes of 4 degrees.
    needle = fs.Polygon([(0, -0.5), (1e-6, -0.5), (0, 0.5)])
    angles = np.arange(16) * np.pi / 8
    spikes = np.where(np.arange(16) % 2, 0.05, 0.6)[:, None]
    star = fs.Polygon((1.5, 0) + spikes * np.column_stack([np.cos(angles), np.sin(angles)]))
    for start, goal in [((-0.5, 0.1), (3, 0)), ((0.4, 0.4), (1.3, 0.7)), ((0.8, 0.1), (2.5, -0.6))]:
        check_optimum(fs.World([needle, star]), start, goal, robot)


@pytest.mark.parametrize("shape", ["disc", "square"])
@pytest.mark.parametrize("where", ["touching", "at R_D"])
@pytest.mark.parametrize("scale", [1, 100])
def test_start_just_on_the_boundary(robot, shape, where, scale):
    robot, margin = fs.KheperaIV(diameter=scale * 0.125), scale * 2**-6
    half = scale * 0.25
    obstacle = fs.Disc((0, 0), half) if shape == "disc" else fs.Polygon(half * SQUARE)
    # All of these are sums of powers of two, so that the distances are exact.
    away = half + robot.radius + (margin / 2 if where == "at R_D" else 0)
    world = fs.World([obstacle])
    for start in [(-away, 0), (0, away)]:
        assert check_optimum(world, start, (scale, scale / 64), robot, margin) < 2 * scale
        for planner in (fs.plan, rooms_first):
            path = planner(world, start, (scale, 0), robot, margin).path
            assert sampled_clearance(path, world, scale / 1000) >= robot.radius - 1e-9
        with pytest.raises(fs.InvalidQuery, match="from obstacle 1"):
            fs.shortest_path(world, start, (scale, 0), fs.KheperaIV(diameter=2.001 * away), margin)


@pytest.mark.parametrize("shape", ["disc", "square"])
def test_grids_of_equal_obstacles_whose_dangerous_circles_touch(shape):
    # Tangents coincide in every row, column and diagonal. Gaps of 1 m are D_r + delta, exactly.
    side = 22 if shape == "disc" else 9
    robot, margin = fs.KheperaIV(diameter=0.75), 0.25
    places = np.array([divmod(number, side) for number in range(side**2)]) * 1.5
    world = fs.World(
        [
            fs.Disc(place, 0.25) if shape == "disc" else fs.Polygon(place + 0.25 * SQUARE)
            for place in places
        ]
    )
    along = fs.shortest_path(world, (-2, 0.75), (1.5 * side + 1, 0.75), robot, margin)
    assert along.path.length == 1.5 * side + 3
    start, goal = (-1.25, -1.25), (1.5 * side - 0.25, 1.5 * side - 0.25)
    plan = fs.shortest_path(world, start, goal, robot, margin)
    mirrored = fs.shortest_path(world, goal, start, robot, margin)
    assert mirrored.path.length == pytest.approx(plan.path.length, rel=1e-9)
    assert np.hypot(*np.subtract(goal, start)) < plan.path.length < 2 * (1.5 * side + 1)
    assert sampled_clearance(plan.path, world, 0.01) >= 0.5 - 1e-9


@pytest.mark.parametrize("shift", [(0, 0), (-93.77475438, -24.42787843), (3000, -2000)])
@pytest.mark.parametrize("angle", [0, np.pi / 2, 0.7])
def test_obstacles_in_a_line_whose_dangerous_circles_touch(shift, angle):
    # Neighbours touch but for round-off, which far from the origin is larger.
    robot, margin = fs.KheperaIV(diameter=0.96), 0.04
    row = fs.World([fs.Disc((1.2 * number, 0), 0.1) for number in range(8)])
    world, move = transformed(row, turn_by(angle), shift)
    for start, goal, optimum in [
        # Along the row at 0.6 m, tangent to all circles, then down to the line of centres.
        ((0, 0.6), (8.4, 0.6), 8.4),
        ((-2, 0), (10.4, 0), 8.4 + 2 * (np.sqrt(4 - 0.36) + 0.6 * np.arcsin(0.6 / 2))),
    ]:
        plan = fs.shortest_path(world, move(start), move(goal), robot, margin)
        assert plan.path.length == pytest.approx(optimum, rel=1e-9)
    # Round-off decides whether the circles leave a way between them; if not, it is round the row.
    across = fs.shortest_path(world, *move([(3, -1.5), (3, 1.5)]), robot, margin).path.length
    assert across == pytest.approx(3, rel=1e-9) or 6 < across < 8


def test_short_lines_far_from_the_origin():
    # Both circles have a radius of 0.55 m and touch but for round-off: their inner tangent is some
    # 100 nm long, and its ends, so far out, tell its direction badly.
    robot, middle = fs.KheperaIV(diameter=0.86), np.array([0.55, 0])
    # By hand: a tangent to the first, an arc up to where they touch, and the same again.
    away, up = np.hypot(0.1, 0.9), np.arctan2(0.9, 0.1)
    expected = 2 * (np.sqrt(away**2 - 0.55**2) + 0.55 * (up - np.arccos(0.55 / away)))
    for shift in np.random.default_rng(52).uniform(-1000, 1000, (60, 2)):
        places = [(0, 0), (1.1, 0), (0.1, -0.9), (1, 0.9)] - middle
        first, second, start, goal = shift + places
        world = fs.World([fs.Disc(first, 0.1), fs.Disc(second, 0.1)])
        plan = fs.shortest_path(world, start, goal, robot, margin=0.04)
        assert [turn.sense for turn in plan.turning_points] == [1, -1]
        assert plan.path.length == pytest.approx(expected, abs=1e-5)


def test_obstacles_far_away_change_nothing(robot, tables):
    far = [fs.Disc((1000 * x, 1000 * y), 50) for x, y in [(1, 0), (-1, 1), (0, -1), (3, 3)]]
    near = tables[1].obstacles
    for world in (fs.World([*near, *far]), fs.World([*far, *near])):
        for planner in (None, fs.plan, rooms_first):
            if planner is None:
                plan = fs.shortest_path(world, (0, 0), (0.75, 0.75))
                expected = fs.shortest_path(tables[1], (0, 0), (0.75, 0.75))
                assert plan.path.length == pytest.approx(expected.path.length, rel=1e-9)
            else:
                plan = planner(world, (0, 0), (0.75, 0.75))
                assert plan.path.length < 1.5
                assert sampled_clearance(plan.path, world) >= robot.radius - 1e-9


def test_a_disc_of_50_m_beside_discs_of_1_mm(robot):
    angles = np.linspace(2.8, 3.5, 15)
    pebbles = [fs.Disc((50.3 * np.cos(a), 50.3 * np.sin(a)), 0.001) for a in angles]
    world = fs.World([fs.Disc((0, 0), 50), *pebbles])
    start, goal = (-50.13 * np.cos(0.3), 50.13 * np.sin(0.3)), (-52, -16)
    optimum = check_optimum(world, start, goal, robot)
    assert optimum > 20
    for planner in (fs.plan, rooms_first):
        path = planner(world, start, goal).path
        assert path.length < 1.1 * optimum
        assert sampled_clearance(path, world) >= robot.radius - 1e-9


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("radius", [1.9, 2.1, 40])
def test_a_large_disc_by_hand(robot, radius):
    # It must not even warn of an overflow.
    reach, far = radius + robot.radius + MARGIN / 2, 3 * radius
    plan = fs.shortest_path(fs.World([fs.Disc((0, 0), radius)]), (-far, 0), (far, 0))
    expected = 2 * np.sqrt(far**2 - reach**2) + 2 * reach * np.arcsin(reach / far)
    assert plan.path.length == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("size", [1e-4, 1, 1e4])
@pytest.mark.parametrize("margin", [0, 0.05])
def test_the_free_position_in_a_message_is_short_and_free(size, margin):
    robot = fs.KheperaIV(0.2 * size, 0.3 * size)
    disc = fs.World([fs.Disc((0.1 * size, 0), size)])
    square = fs.World([fs.Polygon(size * SQUARE)])
    for world, start in (
        (disc, (0.9, 0)),
        (disc, (0.5, 0.7)),
        (square, (1.05, 0)),
        (square, (0, 1.1)),
    ):
        with pytest.raises(fs.InvalidQuery, match="nearest_free gives") as caught:
            fs.shortest_path(world, size * np.array(start), (9 * size, 0), robot, margin * size)
        named = json.loads(str(caught.value).split("nearest_free gives ")[1])
        digits = 3 if size >= 1 else 7
        assert [round(part, digits + 6) for part in named] == named
        if margin:
            assert [round(part, digits) for part in named] == named
            assert "e-" not in str(named) or size < 1
        assert "-0.0" not in re.findall(r"[^\[\], ]+", str(named))
        fs.shortest_path(world, named, (9 * size, 0), robot, margin * size)


@pytest.mark.parametrize("size", [1e-3, 1e-6, 1e-7])
@pytest.mark.parametrize("unit", [fs.Disc((0, 0), 1), fs.Polygon(SQUARE)], ids=["disc", "square"])
def test_tiny_robots_in_tiny_worlds(size, unit):
    start, goal = np.array([(-3, 0.3), (3, 0)])
    optimum = check_optimum(fs.World([unit]), start, goal, fs.KheperaIV(diameter=1), 0.1)
    world, move = transformed(fs.World([unit]), size * np.eye(2))
    ask = world, move(start), move(goal), fs.KheperaIV(0.8 * size, size), 0.1 * size
    assert fs.shortest_path(*ask).path.length == pytest.approx(size * optimum, rel=1e-6)
    for planner in (fs.plan, rooms_first):
        path = planner(*ask).path
        assert path.length < 1.2 * size * optimum
        assert sampled_clearance(path, world, size / 50) >= size / 2 - 1e-9


@pytest.mark.parametrize(("away", "open_corners"), [(0.11, True), (0.09, False)])
def test_walls_that_only_the_robots_size_closes(robot, away, open_corners):
    # A room of four walls, open at its corners by 156 or 127 mm: the robot needs 145.8 mm.
    low, high = 0.5 + away, 0.6 + away
    wall = np.array([(-0.5, low), (0.5, low), (0.5, high), (-0.5, high)])
    room = fs.World([fs.Polygon(wall @ turn_by(quarter * np.pi / 2)) for quarter in range(4)])
    for ends in [((0, 0), (2, 2)), ((2, 2), (0, 0))]:
        assert np.isfinite(check_optimum(room, *np.array(ends), robot)) == open_corners


def test_coordinates_have_a_limit():
    with pytest.raises(fs.InvalidWorld, match=r"beyond 1e\+08 m"):
        fs.World([fs.Disc((2e8, 0), 1)])
    with pytest.raises(fs.InvalidWorld, match=r"beyond 1e\+08 m"):
        fs.World([fs.Polygon(2e8 * SQUARE)])
    with pytest.raises(fs.InvalidQuery, match=r"beyond 1e\+08 m"):
        fs.shortest_path(fs.World([]), (0, 0), (2e8, 0))


@pytest.mark.parametrize("planner", [fs.shortest_path, fs.plan, fs.literal_plan])
def test_every_planner_refuses_the_same_questions(planner):
    world = fs.World([fs.Disc((0, 0), 0.2), fs.Polygon((1, 0) + 0.2 * SQUARE)])
    for start, goal, message in [
        ((-1, 0), (0.1, 0), "goal .* is inside obstacle 1"),
        ((1.1, 0.1), (-1, 0), "start .* is inside obstacle 2"),
        ((-1, 0), (0.5, 0.75), None),
        ((2, 0), (2, 0), "same point"),
        ((-0.27, 0), (2, 0), "0.0700 m from obstacle 1"),
    ]:
        if message is None:
            assert planner(world, start, goal).path.length == pytest.approx(np.hypot(1.5, 0.75))
        else:
            with pytest.raises(fs.InvalidQuery, match=message):
                planner(world, start, goal)


@pytest.mark.parametrize(
    "second",
    [
        fs.Disc((0, 0), 0.1),  # a copy
        fs.Disc((0.25, 0), 0.15),  # it touches
        fs.Disc((0.1, 0), 0.01),  # inside
        fs.Polygon((0.2, 0) + 0.1 * SQUARE),  # an edge touches
        fs.Polygon(0.01 * SQUARE),  # inside
    ],
)
def test_obstacles_that_meet_are_gone_round_together(robot, second):
    world = fs.World([fs.Disc((0, 0), 0.1), second])
    for margin in (0, MARGIN):
        assert np.isfinite(check_optimum(world, (-1, 0.02), (1, 0), robot, margin))


@pytest.mark.parametrize("planner", [fs.shortest_path, fs.plan, fs.literal_plan])
@pytest.mark.parametrize("size", [1e-8, 2e-9, 1e-9])
def test_no_robot_is_so_small_that_it_drives_through_a_wall(planner, size):
    # Below 2 nm, what round-off may take from a clearance is all of it.
    world = fs.World([fs.Polygon(size * SQUARE)])
    robot = fs.KheperaIV(0.8 * size, size)
    try:
        path = planner(world, (-3 * size, 0), (3 * size, 0), robot, 0.1 * size).path
    except (fs.InvalidParameter, fs.InvalidQuery, fs.Trapped):
        return
    assert not shapely.LineString(path.sample(size / 50)).intersects(world.cores[0])


def test_a_listener_is_told_once_why_the_first_plan_takes_longer(caplog, capsys):
    pytest.importorskip("numba")
    compiled.__wrapped__(tangent_search)
    assert not caplog.records
    with caplog.at_level("INFO", "freeseg"):
        compiled.__wrapped__(tangent_search)
        compiled(tangent_search)
        compiled(tangent_search)
    told = [record.getMessage() for record in caplog.records]
    # The second loading is of this process, where it did not plan before.
    assert 1 <= len(told) <= 2
    assert "compiled, which may take a minute" in told[0]
    assert capsys.readouterr() == ("", "")
