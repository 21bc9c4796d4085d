from itertools import pairwise

import numpy as np
import oracle
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from worlds import transformed

import freeseg as fs
from freeseg.path import Line, taut_path
from freeseg.plan import turning_radius
from freeseg.planners.tangent_graph import TangentGraph
from freeseg.segments import MARGIN

CASES = sorted(fs.load_cases())
TABLE_1_CASES = [name for name in CASES if name[2] in "ab"]

#: A U, open to the top, whose pocket is 0.3 m wide and 0.4 m deep.
U_SHAPE = fs.Polygon(
    [(0, 0), (0.5, 0), (0.5, 0.5), (0.4, 0.5), (0.4, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)]
)


@pytest.fixture(scope="session")
def plans(cases, tables):
    return {
        name: fs.plan(tables[case.table], case.start, case.goal) for name, case in cases.items()
    }


@pytest.fixture(scope="session")
def optima(cases, tables, robot):
    """Length and way of the shortest paths at the planner's margin, by exhaustion."""
    reach = turning_radius(robot, MARGIN)
    return {
        name: oracle.shortest(
            case.start,
            case.goal,
            [disc.center for disc in tables[case.table].obstacles],
            tables[case.table].radii + reach,
        )
        for name, case in cases.items()
    }


def shortest_length(world, start, goal, reach):
    """Length of the path through the tangent graph of all obstacles; infinite if none."""
    corners = [len(corners) for corners in world.corners]
    centers, radii = np.concatenate(world.corners), np.repeat(world.radii + reach, corners)
    graph = TangentGraph(start, goal)
    graph.add(centers, radii, world.edges, np.repeat(world.radii + reach, world.edge_counts))
    way = graph.shortest()
    if way is None:
        return np.inf
    circles = [(centers[index], sense * radii[index]) for index, sense in way]
    return taut_path(start, circles, goal)[0].length


def moved(world, turn, shift=(0, 0)):
    """The world rotated by an angle (rad) about the origin, then shifted; and the map."""
    if turn == np.pi / 2:
        matrix = np.array([[0.0, -1.0], [1.0, 0.0]])
    else:
        matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    return transformed(world, matrix, shift)


# --- the paper's 16 cases ------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_path_leads_from_start_to_goal(cases, plans, name):
    path = plans[name].path
    assert path.start == pytest.approx(cases[name].start, abs=1e-12)
    assert path.end == pytest.approx(cases[name].goal, abs=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_the_robots_disc_is_clear_of_every_obstacle(cases, tables, robot, plans, name):
    points = plans[name].path.sample(0.001)
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 0.001 + 1e-12
    for disc in tables[cases[name].table].obstacles:
        distance = shapely.distance(shapely.points(points), shapely.Point(disc.center))
        assert distance.min() - disc.radius >= robot.radius - 1e-9


@pytest.mark.parametrize("name", TABLE_1_CASES)
def test_all_segments_of_table_1_are_safe_and_none_needs_a_group(plans, name):
    assert all(segment.safe for segment in plans[name].segments)
    assert "local minimum" not in [step.kind for step in plans[name].steps]


@pytest.mark.parametrize("name", CASES)
def test_length_is_within_6_percent_of_the_optimum(cases, tables, plans, optima, robot, name):
    optimum, _ = optima[name]
    plan, case = plans[name], cases[name]
    assert plan.path.length <= 1.06 * optimum
    world = tables[case.table]
    if plan.path.clearance(world) < plan.turning_radius - 1e-9:
        # A straight piece passes at less than R_D: no path that keeps R_r may be shorter.
        centers = [disc.center for disc in world.obstacles]
        optimum, _ = oracle.shortest(case.start, case.goal, centers, world.radii + robot.radius)
    assert optimum * (1 - 1e-9) <= plan.path.length


@pytest.mark.parametrize("name", CASES)
def test_tangent_graph_finds_the_optimum(cases, tables, robot, optima, name):
    case = cases[name]
    length = shortest_length(
        tables[case.table], case.start, case.goal, turning_radius(robot, MARGIN)
    )
    assert length == pytest.approx(optima[name][0], rel=1e-9)


def test_16b_turns_right_at_obstacle_1_then_left_at_obstacle_2(plans):
    turns = [(turn.obstacle + 1, turn.sense) for turn in plans["16b"].turning_points]
    assert turns == [(1, -1), (2, 1)]


def test_a_clear_way_is_taken_straight(tables):
    # By hand: from (400, 0) to (200, 750) mm, obstacle 4 is the nearest. The line passes its centre
    # (400, 500) at 200 * 500 / sqrt(200^2 + 750^2) = 128.8 mm, and 128.8 - 39 is more than 70.4.
    start, goal = (0.4, 0.0), (0.2, 0.75)
    plan = fs.plan(tables[1], start, goal)
    assert plan.path.clearance(tables[1]) == pytest.approx(0.1 / np.hypot(0.2, 0.75) - 0.039)
    assert plan.turning_points == ()
    (piece,) = plan.path.pieces
    assert isinstance(piece, Line)
    assert (piece.start, piece.end) == (start, goal)
    assert [step.kind for step in plan.steps] == ["straight"]


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize(("turn", "shift"), [(np.pi / 2, (0, 0)), (0, (1.25, -0.7)), (1, (3, 2))])
def test_length_does_not_depend_on_the_frame(cases, tables, plans, name, turn, shift):
    case = cases[name]
    world, move = moved(tables[case.table], turn, shift)
    plan = fs.plan(world, move(case.start), move(case.goal))
    assert plan.path.length == pytest.approx(plans[name].path.length, rel=1e-9)
    assert [step.kind for step in plan.steps] == [step.kind for step in plans[name].steps]


def test_dangerous_circles_are_concentric_and_leave_the_safe_segments_open(
    cases, tables, plans, robot
):
    for name, plan in plans.items():
        assert plan.turning_radius == pytest.approx(robot.radius + MARGIN / 2)
        assert 2 * plan.turning_radius <= plan.segments[0].required + 1e-15
        for turn in plan.turning_points:
            disc = tables[cases[name].table].obstacles[turn.obstacle]
            assert turn.radius == pytest.approx(disc.radius + plan.turning_radius)
            assert_allclose(turn.center, disc.center)


# --- the trace -----------------------------------------------------------------------------------


def check_trace(world, plan, start, goal):
    """Everything that the trace of any plan promises."""
    straight = plan.steps[0]
    assert straight.kind == "straight"
    assert [type(piece) for piece in straight.path.pieces] == [Line]
    assert plan.steps[-1].path is plan.path
    for before, step in pairwise(plan.steps):
        assert step.kind in {
            "turning point",
            "case 1",
            "case 2",
            "needless turn",
            "local minimum",
        }
        assert step.blocking is not None
        assert step.path.start == pytest.approx(start, abs=1e-9)
        assert step.path.end == pytest.approx(goal, abs=1e-9)
        check_candidates(step)
        if step.kind in {"turning point", "case 1", "case 2"}:
            # It solves what the path before met first: the obstacle itself, or too near to it.
            distances = before.path.distances(world)
            too_near = distances < plan.robot.radius - 1e-9
            distance = distances[np.argmax(too_near.any(1)), step.blocking]
            assert distance < plan.robot.radius
            assert step.kind == "turning point" or (step.kind == "case 1") == (distance <= 0)
        if step.kind == "local minimum":
            assert step.blocking in step.group or len(step.group) > 1
            # The group is gone round: no candidate was chosen.
            assert step.group
            assert step.chosen is None
        else:
            assert step.group == ()
            assert (step.chosen is None) == (step.kind == "needless turn")


def check_candidates(step):
    """Their detours are (5)-(6), and all but the chosen one say why not."""
    detours = [candidate.detour for candidate in step.candidates]
    assert detours == sorted(detours)
    for candidate in step.candidates:
        to, fro = (np.hypot(*(candidate.endpoint.point - end)) for end in step.leg)
        assert candidate.detour == pytest.approx(to + fro)
    accepted = [candidate for candidate in step.candidates if not candidate.rejected]
    assert len(accepted) <= 1
    if accepted:
        assert accepted[0] is step.chosen
        assert step.chosen.detour == min(candidate.detour for candidate in accepted)
        assert step.chosen.sense in (1, -1)
    # Only what is longer than an accepted detour may be left unexamined.
    for candidate in step.candidates:
        if "shorter detour" in candidate.rejected:
            assert candidate.detour >= min(
                other.detour
                for other in step.candidates
                if not other.rejected or "alike" in other.rejected or "back" in other.rejected
            )


@pytest.mark.parametrize("name", CASES)
def test_trace_of_the_cases(cases, tables, plans, name):
    case = cases[name]
    check_trace(tables[case.table], plans[name], case.start, case.goal)


def test_the_cases_show_every_kind_of_step(plans):
    kinds = {step.kind for plan in plans.values() for step in plan.steps}
    assert kinds == {
        "straight",
        "turning point",
        "case 1",
        "case 2",
        "needless turn",
        "local minimum",
    }


@pytest.mark.parametrize("name", CASES)
def test_the_first_search_is_over_all_endpoints_from_start_to_goal(cases, plans, name):
    searches = [step for step in plans[name].steps if step.candidates]
    if not searches:
        # The straight way is free, or meets an obstacle all of whose segments are danger.
        assert [step.kind for step in plans[name].steps[1:]] in ([], ["local minimum"])
        return
    assert_allclose(searches[0].leg, [cases[name].start, cases[name].goal])
    assert {candidate.endpoint.obstacle for candidate in searches[0].candidates} > {0, 6}
    # Repairs search at the blocking obstacle only (3.3.1).
    for step in plans[name].steps:
        if step.kind in {"case 1", "case 2"}:
            assert {candidate.endpoint.obstacle for candidate in step.candidates} == {step.blocking}


# --- random worlds -------------------------------------------------------------------------------


def random_world(rng, n, size):
    """At most n discs and polygons, convex or not, that do not meet, on a square map."""
    obstacles = []
    for center in rng.uniform(0, size, (n, 2)):
        if rng.random() < 0.5:
            obstacle = fs.Disc(center, rng.uniform(0.01, 0.12))
        else:
            # One corner in each of equal sectors: a simple outline, seldom convex.
            corners = rng.integers(3, 8)
            angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.9, corners)) / corners
            spokes = rng.uniform(0.03, 0.2, corners)[:, None]
            obstacle = fs.Polygon(center + spokes * np.column_stack([np.cos(angle), np.sin(angle)]))
        try:
            obstacles = list(fs.World([*obstacles, obstacle]).obstacles)
        except fs.InvalidWorld:
            continue
    return fs.World(obstacles)


def certainly_apart(world, start, goal, robot, margin):
    """Whether obstacles grown by the turning radius part start from goal, by Shapely."""
    ends = [shapely.Point(start), shapely.Point(goal)]
    reach = np.minimum(turning_radius(robot, margin), world.distances(ends[0]))
    reach = np.minimum(reach, world.distances(ends[1]))
    # Shapely's circles are inscribed polygons: grown so as to cover the true ones.
    grown = shapely.buffer(
        world.cores, (world.radii + reach) / np.cos(np.pi / 128) + 1e-9, quad_segs=32
    )
    room = shapely.box(*np.add(shapely.total_bounds(grown), (-1, -1, 1, 1)))
    free = shapely.get_parts(shapely.difference(room, shapely.union_all(grown)))
    return not any(part.intersects(ends[0]) and part.intersects(ends[1]) for part in free)


def plan_and_check(world, start, goal, robot, margin=MARGIN):
    """Plan, check what came of it by other means, and return what it was."""
    try:
        plan = fs.plan(world, start, goal, robot, margin)
    except fs.InvalidQuery:
        ends = shapely.points([start, goal])
        assert min(world.distances(end).min() for end in ends) < robot.radius
        return "InvalidQuery"
    except fs.NoPath:
        assert certainly_apart(world, start, goal, robot, margin)
        return "NoPath"
    assert plan.path.start == pytest.approx(tuple(start), abs=1e-9)
    assert plan.path.end == pytest.approx(tuple(goal), abs=1e-9)
    assert plan.path.clearance(world) >= robot.radius - 1e-9
    way = shapely.LineString(plan.path.sample(0.005))
    # Chords of 5 mm leave the arcs by far less than 0.1 mm.
    assert world.distances(way).min(initial=np.inf) >= robot.radius - 1e-4
    check_trace(world, plan, tuple(start), tuple(goal))
    return "plan"


def test_plans_in_random_worlds_are_safe(robot):
    rng = np.random.default_rng(41)
    results = []
    for number in range(300):
        size = rng.uniform(0.5, 1.5)
        world = random_world(rng, 1 + number % 12, size)
        for start, goal in rng.uniform(-0.3, size + 0.3, (3, 2, 2)):
            results.append(plan_and_check(world, start, goal, robot))
    assert results.count("plan") > 400
    assert results.count("InvalidQuery") > 100


def test_what_is_no_path_is_walled_in(robot):
    # Rings of obstacles round the start, with gaps about as wide as the robot.
    rng = np.random.default_rng(42)
    diamond = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])
    results = []
    for _ in range(80):
        angles = 2 * np.pi * (np.arange(9) + rng.uniform(0, 0.1, 9)) / 9
        world = fs.World(
            [
                fs.Disc(center, rng.uniform(0.07, 0.09))
                if rng.random() < 0.5
                else fs.Polygon(center + rng.uniform(0.07, 0.1) * diamond)
                for center in 0.4 * np.column_stack([np.cos(angles), np.sin(angles)])
            ]
        )
        results.append(plan_and_check(world, (0, 0), (1, 0.2), robot))
    assert results.count("NoPath") > 20
    assert results.count("plan") > 20


positions = st.tuples(st.integers(-4, 24), st.integers(-4, 24))


@st.composite
def grid_worlds(draw):
    """Discs and rectangles on a grid of 50 mm: aligned, as people lay them out."""
    obstacles = []
    for column, row in draw(st.lists(positions, min_size=1, max_size=8, unique=True)):
        center = np.array([column, row]) * 0.05
        half = np.array(draw(st.tuples(st.integers(1, 4), st.integers(1, 4)))) * 0.0249
        if draw(st.booleans()):
            obstacle = fs.Disc(center, half[0])
        else:
            obstacle = fs.Polygon(center + half * [(-1, -1), (1, -1), (1, 1), (-1, 1)])
        try:
            obstacles = list(fs.World([*obstacles, obstacle]).obstacles)
        except fs.InvalidWorld:
            continue
    return fs.World(obstacles)


@given(world=grid_worlds(), start=positions, goal=positions)
@settings(max_examples=150, derandomize=True, deadline=None)
def test_plans_on_grids_are_safe(robot, world, start, goal):
    assume(start != goal)
    # R_D is 75 mm here, so that tangents of aligned obstacles coincide.
    margin = 2 * (0.075 - robot.radius)
    result = plan_and_check(world, np.multiply(start, 0.05), np.multiply(goal, 0.05), robot, margin)
    assert result in {"plan", "NoPath", "InvalidQuery"}


# --- the tangent graph ---------------------------------------------------------------------------


def test_tangent_graph_against_exhaustion():
    rng = np.random.default_rng(43)
    blocked = 0
    for _ in range(150):
        centers, radii = rng.uniform(0, 1, (5, 2)), rng.uniform(0.01, 0.05, 5)
        try:
            world = fs.World([fs.Disc(*disc) for disc in zip(centers, radii, strict=True)])
        except fs.InvalidWorld:
            continue
        start, goal = (-0.2, rng.uniform(0, 1)), (1.2, rng.uniform(0, 1))
        optimum, way = oracle.shortest(start, goal, centers, radii + 0.07)
        blocked += len(way) > 0
        assert shortest_length(world, start, goal, 0.07) == pytest.approx(optimum, rel=1e-9)
    assert blocked > 50


#: A rectangle and a disc whose dangerous circles touch the line y = 7 from below.
RECTANGLE = fs.Polygon([(5.25, 5.5), (6.75, 5.5), (6.75, 6.5), (5.25, 6.5)])
ALIGNED = [RECTANGLE, fs.Disc((4, 6), 0.5)]


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("turn", [0, *np.random.default_rng(44).uniform(0, 2 * np.pi, 10)])
def test_shortest_way_past_aligned_obstacles_by_hand(order, turn):
    # Tangent, arc to the line y = 7, along it, arc, tangent; turned, it is as long.
    length = 9 / 4 + np.arctan(2 / 9) + 11 / 4 + np.pi / 6 + np.sqrt(3)
    world, move = moved(fs.World(ALIGNED[::order]), turn)
    assert shortest_length(world, move((9, 6)), move((2, 6)), 0.5) == pytest.approx(length)


def test_shortest_way_past_aligned_rectangles_at_any_angle():
    # Their four corners make tangents coincide, but for round-off that differs by the angle.
    rectangles = [
        [(3.75, 1.5), (4.25, 1.5), (4.25, 2.5), (3.75, 2.5)],
        [(-0.5, 1.5), (0.5, 1.5), (0.5, 2.5), (-0.5, 2.5)],
    ]
    # Tangent, arc to the line y = 1, and along it.
    length = 7 / 4 + np.arctan(2 / 7) + 5 / 4
    for turn in np.random.default_rng(46).uniform(0, 2 * np.pi, 200):
        world, move = moved(fs.World([fs.Polygon(corners) for corners in rectangles]), turn)
        assert shortest_length(world, move((6, 2)), move((3, 1)), 0.5) == pytest.approx(length)


@pytest.mark.parametrize("order", [1, -1])
def test_there_is_a_path_past_aligned_obstacles(order):
    # The group of both is gone round; no path would be a false proof.
    plan = fs.plan(
        fs.World(ALIGNED[::order]), (9, 6), (2, 6), fs.KheperaIV(diameter=0.5), margin=0.5
    )
    assert plan.path.length == pytest.approx(7.474318529, abs=1e-6)


def test_tangent_graph_does_not_mind_aligned_obstacles():
    # Moved by a ten millionth, no two tangents coincide, and the optimum hardly changes.
    rng = np.random.default_rng(45)
    for _ in range(200):
        columns, rows = np.divmod(rng.permutation(16)[: rng.integers(2, 6)], 4)
        halves = rng.choice([0.25, 0.5, 0.75], (len(rows), 2))
        aligned, shaken = [], []
        for center, half in zip(2 * np.column_stack([columns, rows]), halves, strict=True):
            shake = 1e-7 * rng.uniform(-1, 1, 2)
            if rng.random() < 0.5:
                aligned.append(fs.Disc(center, half[0]))
                shaken.append(fs.Disc(center + shake, half[0]))
            else:
                corners = center + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
                aligned.append(fs.Polygon(corners))
                shaken.append(fs.Polygon(corners + shake + 1e-7 * rng.uniform(-1, 1, (4, 2))))
        ends = (-2, 2 * rng.integers(4)), (8, 2 * rng.integers(4))
        # No gap is just 0.9 m wide, where a shake would open or close it.
        lengths = [shortest_length(fs.World(world), *ends, 0.45) for world in (aligned, shaken)]
        assert lengths[0] == pytest.approx(lengths[1], abs=1e-5)


# --- tight spots ---------------------------------------------------------------------------------


def ring(gap, n=8, radius=0.1):
    """Discs in a ring round the origin, neighbours `gap` apart."""
    distance = (gap / 2 + radius) / np.sin(np.pi / n)
    angles = 2 * np.pi * np.arange(n) / n
    return fs.World([fs.Disc((distance * np.cos(a), distance * np.sin(a)), radius) for a in angles])


@pytest.mark.parametrize("ends", [((0, 0), (2, 0.1)), ((2, 0.1), (0, 0))])
def test_no_path_out_of_or_into_a_ring_of_danger_gaps(robot, ends):
    for gap in (0.05, robot.diameter, robot.diameter + MARGIN - 1e-6):
        with pytest.raises(fs.NoPath, match=r"obstacles \[1, 2, 3, 4, 5, 6, 7, 8\] leave no way"):
            fs.plan(ring(gap), *ends)


@pytest.mark.parametrize("ends", [((0, 0), (2, 0.1)), ((2, 0.1), (0, 0))])
def test_a_path_leads_through_a_ring_of_safe_gaps(robot, ends):
    world = ring(robot.diameter + MARGIN + 1e-6)
    assert plan_and_check(world, *ends, robot) == "plan"


def test_a_smaller_margin_opens_a_ring(robot):
    world, ends = ring(robot.diameter + 0.004), ((0, 0), (2, 0.1))
    assert plan_and_check(world, *ends, robot) == "NoPath"
    assert plan_and_check(world, *ends, robot, margin=0.003) == "plan"


@pytest.mark.parametrize("start", [(0.25, -0.4), (-0.4, 0.25), (0.9, 0.25), (0.25, 1), (-0.3, 0.6)])
def test_goal_in_the_pocket_of_a_u(robot, start):
    world = fs.World([U_SHAPE])
    assert plan_and_check(world, start, (0.25, 0.25), robot) == "plan"
    assert plan_and_check(world, (0.25, 0.25), start, robot) == "plan"


@pytest.mark.parametrize(("neck", "result"), [(0.144, "NoPath"), (0.148, "plan")])
def test_goal_in_a_flask(robot, neck, result):
    # The robot needs 145.8 mm, and the bulb is wide enough.
    left, right = 0.25 - neck / 2, 0.25 + neck / 2
    inside = [(right, 0.5), (0.4, 0.5), (0.4, 0.1), (0.1, 0.1), (0.1, 0.5), (left, 0.5)]
    flask = fs.Polygon([(0, 0), (0.5, 0), (0.5, 0.6), (right, 0.6), *inside, (left, 0.6), (0, 0.6)])
    assert plan_and_check(fs.World([flask]), (0.25, -0.4), (0.25, 0.3), robot) == result


@pytest.mark.parametrize("share", [0, 0.3, 0.9])
def test_start_and_goal_between_the_robots_radius_and_the_turning_radius(robot, share):
    near = robot.radius + 1e-9 + share * MARGIN / 2
    world = fs.World([fs.Disc((0, 0), 0.1), fs.Polygon([(1, -0.2), (1.2, -0.2), (1.2, 0.2)])])
    for start in [(-0.1 - near, 0), (0, 0.1 + near), (0.1 + near, 0)]:
        for goal in [(1.2 + near, 0), (1.2 + near, 0.1), (1.1, -0.2 - near)]:
            assert plan_and_check(world, start, goal, robot) == "plan"
            assert plan_and_check(world, goal, start, robot) == "plan"


def test_worlds_of_no_and_of_one_obstacle(robot):
    empty = fs.plan(fs.World([]), (0, 0), (3, 4))
    assert empty.path.length == 5
    assert empty.segments == ()
    # Tangents of a circle of radius r + R_D, its centre half way: by hand.
    radius = 0.2 + turning_radius(robot, MARGIN)
    plan = fs.plan(fs.World([fs.Disc((0, 0), 0.2)]), (-1, 0), (1, 0))
    length = 2 * np.sqrt(1 - radius**2) + radius * (np.pi - 2 * np.arccos(radius))
    assert plan.path.length == pytest.approx(length)
    assert [turn.obstacle for turn in plan.turning_points] == [0]


# --- what cannot be asked ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "goal", "message"),
    [
        ((0, np.nan), (1, 1), r"start is \[0.0, nan\]"),
        ((0, 0), (np.inf, 1), r"goal is \[inf, 1.0\]"),
        ((0, 0, 0), (1, 1), r"start has shape \(3,\)"),
        ((0, 0), 1, r"goal has shape \(\)"),
        ((0, 0), [(1, 1)], r"goal has shape \(1, 2\)"),
        ("ab", (1, 1), "start is 'ab'"),
        (None, (1, 1), "start "),
        ((0.55, 0.1), (1, 1), r"start \[0.55, 0.1\] is inside obstacle 1"),
        ((0, 0), (0.55, 0.18), r"goal \[0.55, 0.18\] is 0.0620 m from obstacle 1"),
        ((0.1, 0.2), (0.1, 0.2), r"same point \[0.1, 0.2\]"),
        ((0.3, 0.2), (0.3, 0.2 + 1e-10), "start and goal"),  # the same but for round-off
    ],
)
def test_invalid_query(tables, start, goal, message):
    with pytest.raises(fs.InvalidQuery, match=message):
        fs.plan(tables[1], start, goal)


def test_start_inside_a_polygon():
    with pytest.raises(fs.InvalidQuery, match="is inside obstacle 1"):
        fs.plan(fs.World([RECTANGLE]), (6, 6), (0, 0))


@pytest.mark.parametrize("world", [None, [], [fs.Disc((1, 1), 0.1)], "table 1"])
def test_what_is_no_world(world):
    with pytest.raises(fs.InvalidQuery, match="give a World"):
        fs.plan(world, (0, 0), (2, 2))


@pytest.mark.parametrize("margin", [True, -0.005, np.nan, np.inf, "wide", "0.005", (1, 2)])
def test_invalid_margin(tables, margin):
    with pytest.raises(fs.InvalidParameter, match="margin is"):
        fs.plan(tables[1], (0, 0), (0.25, 0.75), margin=margin)


@pytest.mark.parametrize("planner", [fs.plan, fs.plan_rooms, fs.shortest_path, fs.literal_plan])
def test_a_margin_of_zero_is_a_margin(tables, planner):
    found = planner(tables[1], (0, 0), (0.3, 0.02), margin=0)
    assert found.margin == 0
    assert found.turning_radius == found.robot.radius


def test_a_margin_in_mm_is_refused(tables):
    with pytest.raises(
        fs.InvalidParameter, match=r"margin is 5 m.*give at most 0\.\d+ m"
    ) as caught:
        fs.plan(tables[1], (0, 0), (0.25, 0.75), margin=5)
    most = float(str(caught.value).split()[-2])
    assert fs.plan(tables[1], (0, 0), (0.25, 0.75), margin=0.99 * most).margin == 0.99 * most


def test_a_plan_says_what_it_was_made_for(tables):
    robot = fs.KheperaIV(0.08, diameter=0.1)
    found = fs.plan(tables[1], (0, 0), (0.25, 0.75), robot, 0.01)
    assert (found.world, found.robot, found.margin) == (tables[1], robot, 0.01)
