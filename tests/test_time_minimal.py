import casadi as ca
import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import ellipeinc
from worlds import crowded_question

import freeseg as fs
from freeseg.planners.timed_query import meeting
from freeseg.studies import crossings
from freeseg.timed_path import Ride, Slide, Straight, TimedPath

SPEED = 0.3
ROBOT = fs.KheperaIV()
KEEP = ROBOT.radius + 0.005 / 2
EMPTY = fs.World([])
ENDS = (0, 0), (2, 0.5)


def crossing(seed, movers=4, ratio=0.8):
    """A scene of discs that cross the way from one end to the other."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < movers:
        center, radius = rng.uniform((-0.2, -1), (2.2, 1.5)), rng.uniform(0.05, 0.25)
        heading, pace = rng.uniform(-np.pi, np.pi), rng.uniform(0, ratio * SPEED)
        if np.hypot(*center) > radius + 0.12:
            velocity = pace * np.cos(heading), pace * np.sin(heading)
            found.append(fs.Mover(fs.Disc(center, radius), velocity))
    return fs.Scene(EMPTY, found)


def moved(scene, change, speedup=1.0, scale=1.0):
    """The scene as a linear change of the plane has it, and a change of the clock."""
    return fs.Scene(
        EMPTY,
        [
            fs.Mover(
                fs.Disc(change(mover.obstacle.center), scale * mover.obstacle.radius),
                speedup * (change(mover.velocity) - change((0, 0))),
            )
            for mover in scene.movers
        ],
    )


@pytest.mark.parametrize("seed", range(30))
def test_where_nothing_moves_it_is_the_shortest_path(seed):
    world, start, goal, margin = crowded_question(seed, most=12)
    standing = fs.Scene(
        fs.World(world.obstacles[::2]), [fs.Mover(obstacle) for obstacle in world.obstacles[1::2]]
    )
    try:
        shortest = fs.shortest_path(world, start, goal, margin=margin).path.length
    except fs.NoPath:
        for scene in (world, standing):
            with pytest.raises(fs.NoPath):
                fs.time_minimal_plan(scene, start, goal, SPEED, margin=margin)
        return
    for scene in (world, standing):
        plan = fs.time_minimal_plan(scene, start, goal, SPEED, margin=margin)
        assert plan.proved
        assert plan.arrival * SPEED == pytest.approx(shortest, abs=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_arrival_does_not_depend_on_where_one_stands(seed):
    scene, rng = crossing(seed), np.random.default_rng(seed)
    arrival = fs.time_minimal_plan(scene, *ENDS, SPEED).arrival
    turn, shift = rng.uniform(-np.pi, np.pi), rng.uniform(-100, 100, 2)
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    mirror = np.diag([1, -1])
    for change in (lambda p: matrix @ p, lambda p: p + shift, lambda p: mirror @ p):
        ends = map(change, np.asarray(ENDS, float))
        found = fs.time_minimal_plan(moved(scene, change), *ends, SPEED).arrival
        assert found == pytest.approx(arrival, rel=1e-9)
    faster = fs.time_minimal_plan(moved(scene, np.array, speedup=2), *ENDS, 2 * SPEED)
    assert faster.arrival == pytest.approx(arrival / 2, rel=1e-9)
    larger = fs.Robot(0.2, 3 * ROBOT.diameter, 0.05, 100, 100)
    ends = 3 * np.array(ENDS)
    thrice = moved(scene, lambda p: 3 * np.asarray(p), scale=3)
    plan = fs.time_minimal_plan(thrice, *ends, 3 * SPEED, larger, margin=0.015)
    assert plan.arrival == pytest.approx(arrival, rel=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_time_reversal(seed):
    scene = crossing(seed)
    plan = fs.time_minimal_plan(scene, *ENDS, SPEED)
    if not plan.proved or (scene.distances(ENDS[1], plan.arrival) < KEEP + 1e-6).any():
        pytest.skip("it arrives on a rim, or nothing is proved")
    back = fs.Scene(
        EMPTY,
        [fs.Mover(mover.at(plan.arrival), -np.asarray(mover.velocity)) for mover in scene.movers],
    )
    assert fs.time_minimal_plan(back, *ENDS[::-1], SPEED).arrival == pytest.approx(
        plan.arrival, rel=1e-9
    )


@pytest.mark.parametrize(
    ("growth", "far", "between"), [(0.01, 2.5, 2.8), (0.1, 2.5, 2.8), (0.25, 6.0, 2.3)]
)
def test_one_growing_disc_has_a_closed_form(growth, far, between):
    # Tangent, logarithmic spiral, tangent; all as seen from the disc's centre.
    first, near = 0.1 + KEEP, 0.7
    s = np.sqrt(SPEED**2 - growth**2)
    touch = np.sqrt(near**2 - first**2) / s

    def leave(turned):
        radius = (first + growth * touch) * np.exp(growth * turned / s)
        # The last line, until it is as far from the centre as the goal.
        square, half, rest = growth**2 + s**2, radius * growth, radius**2 - far**2
        last = (-half + np.sqrt(half**2 - square * rest)) / square
        angle = np.arccos(first / near) + turned + np.arctan2(s * last, radius + growth * last)
        return angle, (radius - first) / growth + last

    # Where the spiral is as far out as the goal, it has turned too far.
    most = s / growth * np.log(far / (first + growth * touch))
    turned = brentq(lambda turned: leave(turned)[0] - between, 0, min(2, most), xtol=1e-14)
    scene = fs.Scene(EMPTY, [fs.Mover(fs.Disc((0, 0), 0.1), growth=growth)])
    goal = far * np.cos(between), far * np.sin(between)
    plan = fs.time_minimal_plan(scene, (near, 0), goal, SPEED)
    assert plan.arrival == pytest.approx(leave(turned)[1], rel=1e-9)
    assert plan.turns == ((0, 1),)
    assert plan.proved


@pytest.mark.parametrize("velocity", [(0.1, 0.05), (-0.25, 0.1), (0, -0.2997)])
@pytest.mark.parametrize("sweep", [0.3, -2.0, 4.0])
def test_a_slide_on_a_moving_disc_takes_an_elliptic_integral(velocity, sweep):
    # In the disc's frame the rim is driven at w = sqrt(V^2 - u^2 sin^2) - u cos.
    slide = Slide(np.zeros(2), np.array(velocity), 0.4, 0.0, 0.7, sweep, 2.0, SPEED)
    u, sense = np.hypot(*velocity), np.sign(sweep)

    def integral(angle):
        # From the direction of the rim to that of the motion on it, relative to the velocity.
        along = sense * (angle - np.arctan2(velocity[1], velocity[0])) + np.pi / 2
        slow = u * np.sin(along) + SPEED * ellipeinc(along, (u / SPEED) ** 2)
        return 0.4 * slow / (SPEED**2 - u**2)

    wanted = integral(0.7 + sweep) - integral(0.7)
    assert slide.end - 2 == pytest.approx(wanted, rel=1e-9)
    t = np.linspace(2, slide.end, 400)
    place, driven = slide.at(t)
    assert_allclose(np.hypot(*(place - t[:, None] * velocity).T), 0.4, atol=1e-12)
    assert_allclose(np.hypot(*driven.T), SPEED, rtol=1e-9)
    # A slide that begins where another has come to ends with it.
    middle = slide.at(np.array([t[200]]))[0][0] - t[200] * np.array(velocity)
    half = np.arctan2(middle[1], middle[0])
    rest = sense * ((sense * (0.7 + sweep - half)) % (2 * np.pi))
    later = Slide(np.zeros(2), np.array(velocity), 0.4, 0.0, half, rest, t[200], SPEED)
    assert later.end == pytest.approx(slide.end, rel=1e-9)


def solve(scene, bend, steps=80):
    """Arrival of a polyline, by a nonlinear programme that keeps all of it free; or infinity."""
    start, goal = np.array(ENDS, float)
    points, arrival = ca.MX.sym("points", 2, steps + 1), ca.MX.sym("arrival")
    t = arrival * ca.DM(np.linspace(0, 1, steps + 1)).T
    constraints = [ca.sum1(ca.diff(points, 1, 1) ** 2) - (SPEED * arrival / steps) ** 2]
    for mover in scene.movers:
        gap = points - mover.obstacle.center - ca.DM(np.asarray(mover.velocity)) @ t
        # Two points this far off have the segment between them outside of the circle.
        half = (SPEED + np.hypot(*mover.velocity)) * arrival / steps / 2
        constraints.append((mover.obstacle.radius + KEEP) ** 2 + half**2 - ca.sum1(gap**2))
    g = ca.horzcat(*constraints, (points[:, 0] - start).T, (points[:, -1] - goal).T)
    problem = {"x": ca.vertcat(ca.vec(points), arrival), "f": arrival, "g": g}
    quiet = {"print_time": False, "calc_lam_p": False}
    options = quiet | {"ipopt": {"print_level": 0, "sb": "yes", "max_iter": 100}}
    solver = ca.nlpsol("solver", "ipopt", problem, options)
    share = np.linspace(0, 1, steps + 1)[:, None]
    guess = start + share * (goal - start) + bend * np.sin(np.pi * share) * [-0.24, 0.97]
    low = np.append(np.full(g.numel() - 4, -np.inf), np.zeros(4))
    x0 = np.append(guess.ravel(), 1.2 * np.hypot(*(goal - start)) / SPEED)
    found = solver(x0=x0, lbg=low, ubg=0)
    return float(found["f"]) if solver.stats()["success"] else np.inf


@pytest.mark.parametrize("seed", range(24))
def test_no_nonlinear_programme_arrives_earlier(seed):
    scene = crossing(seed, movers=6)
    plan = fs.time_minimal_plan(scene, *ENDS, SPEED)
    if plan.arrival > np.hypot(*ENDS[1]) / SPEED * (1 + 1e-9):
        best = min(solve(scene, bend) for bend in (0, 0.6, -0.6))
        assert plan.arrival <= best * (1 + 1e-4)


@pytest.mark.parametrize("seed", range(100, 110))
def test_paths_are_free_at_each_time(seed):
    scene = crossing(seed, movers=7)
    plan = fs.time_minimal_plan(scene, *ENDS, SPEED)
    assert_allclose(plan.path.pose[:2, [0, -1]].T, ENDS, atol=1e-9)
    assert scene.clearance(plan.path) >= min(KEEP, scene.distances((0, 0), 0).min()) - 1e-7
    t = np.linspace(0, plan.arrival, 5000)
    pose, velocity = plan.path.at(t)
    steps = np.hypot(*np.diff(pose[:2])) / np.diff(t)
    assert steps.max() <= SPEED * (1 + 1e-9)
    assert_allclose(np.hypot(*velocity).max(), SPEED, rtol=1e-9)


def test_static_polygons_stand_in_the_way_of_slides_and_lines():
    wall = fs.Polygon([(0.9, -0.3), (1.1, -0.3), (1.1, 1.2), (0.9, 1.2)])
    for seed in range(6):
        scene = fs.Scene(fs.World([wall]), crossing(seed, movers=3).movers)
        plan = fs.time_minimal_plan(scene, *ENDS, SPEED)
        points = shapely.points(plan.path.pose[:2].T)
        assert scene.world.distances(points[:, None]).min() >= KEEP - 1e-7
        alone = fs.shortest_path(scene.world, *ENDS).path.length
        assert plan.arrival * SPEED >= alone - 1e-9


def test_it_waits_for_what_covers_the_goal():
    # It is slow, and drives over the goal from the right to the left.
    mover = fs.Mover(fs.Disc((2, 0), 0.5), velocity=(-0.1, 0))
    plan = fs.time_minimal_plan(fs.Scene(EMPTY, [mover]), (0, 0), (1.2, 0), SPEED)
    release = (0.8 + 0.5 + KEEP) / 0.1
    assert plan.arrival == pytest.approx(release, rel=1e-9)
    assert isinstance(plan.path.pieces[-1], Straight)
    assert_allclose(plan.path.pieces[-1].velocity, mover.velocity, atol=1e-9)


@pytest.mark.parametrize(
    ("seed", "grid"),
    # At a gap about to open, at a goal about to be left, at corners that lead to those, on a rim
    # until such a corner comes by; slowly on the way there, straight or from a rim; and on an edge
    # that ends, from where its corner leads on.
    [
        (25, 8.19457),
        (40, 6.99998),
        (43, 8.81766),
        (51, 8.02295),
        (697, 9.36394),
        (770, 9.34390),
        (347, 9.49751),
        (1522, 7.41990),
        (1580, 7.74300),
        (1668, 8.12517),
        (1833, 7.85859),
        (2649, 8.28994),
    ],
)
def test_waiting_pays_where_a_grid_in_space_and_time_found_that_it_does(seed, grid):
    plan = crossings.plan_crossing(seed)
    assert plan.arrival <= grid
    assert_allclose(plan.path.at(plan.arrival)[0][:2], crossings.CROSSING_GOAL, atol=1e-7)
    t = np.linspace(0, plan.arrival, 5000)
    assert np.hypot(*plan.path.at(t)[1]).max() <= crossings.CROSSING_SPEED * (1 + 1e-6)
    assert plan.scene.clearance(plan.path) >= crossings.CROSSING_KEEP - 1e-7


@pytest.mark.parametrize("seed", [745, 968])
def test_a_ride_to_another_wait_ends_before_it_is_faster_than_the_robot(seed):
    # Where three discs meet, corners of two of them part, and one may part in a leap.
    plan = crossings.plan_crossing(seed)
    t = np.linspace(0, plan.arrival, 5000)
    assert np.hypot(*plan.path.at(t)[1]).max() <= crossings.CROSSING_SPEED * (1 + 1e-6)


def test_a_place_where_a_mover_will_leave_the_goal_is_not_yet_the_goal():
    # Another disc covers the rim for a while: what waits there has not arrived.
    plan = crossings.plan_crossing(137)
    assert_allclose(plan.path.at(plan.arrival)[0][:2], crossings.CROSSING_GOAL, atol=1e-7)


def test_a_corner_of_two_that_part_is_ridden_until_it_is_too_fast():
    parting = [fs.Mover(fs.Disc((0.6, 0.42 * s), 0.4), (0, 0.012 * s)) for s in (1, -1)]
    plan = fs.time_minimal_plan(fs.Scene(EMPTY, parting), (0, 0), (1.2, 0), SPEED)
    (ride,) = (piece for piece in plan.path.pieces if isinstance(piece, Ride))
    # By hand: on the axis, at half = sqrt(R^2 - y^2) from the gap, at the speed y' y / half.
    y, radius = 0.42 + 0.012 * ride.end, 0.4 + KEEP
    half = np.sqrt(radius**2 - y**2)
    assert 0.012 * y / half == pytest.approx(SPEED, rel=1e-6)
    place, velocity = ride.at(np.array([ride.end]))
    assert_allclose(place[0], (0.6 - half, 0), atol=1e-9)
    assert plan.arrival == pytest.approx(ride.end + (0.6 + half) / SPEED, rel=1e-6)
    assert_allclose(velocity[0], (SPEED, 0), atol=1e-6)


@pytest.mark.parametrize("seed", [37, 40, 122, 173, 373])
def test_a_slide_that_ends_in_a_notch_is_left_before(seed):
    # Small discs reach a few millimetres out of a large one, and nothing else matters.
    rng = np.random.default_rng(seed)
    size, center = rng.uniform(0.2, 0.5), np.array([1.0, rng.normal(0, 0.1)])
    discs = [fs.Disc(center, size)]
    for _ in range(6):
        radius = rng.uniform(0.02, 0.15)
        heading = rng.uniform(-np.pi, np.pi)
        off = size - radius + rng.uniform(0.0005, 0.01)
        discs.append(fs.Disc(center + off * np.array([np.cos(heading), np.sin(heading)]), radius))
    far = fs.Mover(fs.Disc((8, 8), 0.1), (0, 0.1))
    shortest = fs.shortest_path(fs.World(discs), (0, 0), (2, 0)).path.length
    plan = fs.time_minimal_plan(fs.Scene(fs.World(discs), [far]), (0, 0), (2, 0), SPEED)
    assert plan.proved
    assert plan.arrival * SPEED == pytest.approx(shortest, rel=1e-9)


@pytest.mark.parametrize(("off", "wider"), [(0, 0), (1e-9, 0), (1e-6, 0), (1e-5, 0), (0, 1e-6)])
@pytest.mark.parametrize("others", [0, 8])
def test_a_corner_of_two_that_pass_through_each_other_changes_sides(off, wider, others):
    # Two doors on one lane part before a gap. Many others are far away, for what is compiled.
    walls = [fs.Polygon([(0.98, s * 0.15), (1.02, s * 0.15), (1.02, s * 1.5), (0.98, s * 1.5)])
             for s in (1, -1)]  # fmt: skip
    doors = [
        fs.Mover(fs.Disc((1, -0.24), 0.25), (0, 0.08)),
        fs.Mover(fs.Disc((1 + off, 0.24), 0.25 + wider), (0, -0.08)),
    ]
    far = [fs.Mover(fs.Disc((5 + k, 5), 0.1), (0, 0.1)) for k in range(others)]
    plan = fs.time_minimal_plan(fs.Scene(fs.World(walls), [*doors, *far]), (0, 0), (2, 0), 0.3)
    # They are apart, but for the robot, when their centres are twice that; it waits close by.
    opens = 3 + (0.25 + KEEP) / 0.08
    assert opens < plan.arrival - 1 / 0.3 < opens + 0.2


def test_waits_are_looked_for_without_a_limit_where_there_is_no_way_without_them():
    # One slow mover passes the only gap, and the robot behind it.
    x, wide = 0.631, 0.2106
    boxes = [fs.Polygon([(x, s * wide), (x + 0.08, s * wide), (x + 0.08, s * 0.8), (x, s * 0.8)])
             for s in (1, -1)]  # fmt: skip
    world = fs.World(boxes, boundary=[(-0.4, -0.8), (2.4, -0.8), (2.4, 0.8), (-0.4, 0.8)])
    mover = fs.Mover(fs.Disc((0.3938, -0.0255), 0.1891), (0.0336, 0.0029))
    plan = fs.time_minimal_plan(fs.Scene(world, [mover]), (0, 0), (2, 0), 0.3)
    assert plan.arrival < 20.98


def test_what_is_not_proved_is_named():
    apart = [fs.Mover(fs.Disc((1, s), 0.3), velocity=(0, -0.1 * s)) for s in (-1.5, 1.5)]
    plan = fs.time_minimal_plan(fs.Scene(EMPTY, apart), (0, 0), (2.5, 0), SPEED)
    assert plan.proved
    # They close the gap between them before the robot is there.
    closing = [fs.Mover(fs.Disc((1, s), 0.3), velocity=(0, -0.1 * s)) for s in (-0.6, 0.6)]
    plan = fs.time_minimal_plan(fs.Scene(EMPTY, closing), (0, 0), (2.5, 0), SPEED)
    assert plan.doubts == ((0, 1),)
    assert "not proved" in repr(plan)


@pytest.mark.parametrize(
    ("mover", "speed", "error", "named"),
    [
        (fs.Mover(fs.Disc((1, 1), 0.1), (0.2, 0)), 0.2, fs.InvalidParameter, "mover 1"),
        (fs.Mover(fs.Disc((1, 1), 0.1), growth=0.3), 0.2, fs.InvalidParameter, "mover 1"),
        (fs.Mover(fs.Disc((1, 1), 0.1), shift=lambda t: 0 * t[:, None] * [[1, 1]]), 0.2,
         fs.InvalidWorld, "function of time"),
        (fs.Mover(fs.Polygon([(1, 1), (2, 1), (2, 2)]), (0.1, 0)), 0.2, fs.InvalidWorld, "Polygon"),
        (fs.Mover(fs.Disc((0.1, 0), 0.1), (0.1, 0)), 0.2, fs.InvalidQuery, "mover 1"),
        (fs.Mover(fs.Disc((1, 1), 0.1), (0.1, 0)), 100, fs.InvalidParameter, "wheels"),
        (fs.Mover(fs.Disc((1, 1), 0.1), (0.1, 0)), 0, fs.InvalidParameter, "speed"),
    ],
)  # fmt: skip
def test_what_is_refused(mover, speed, error, named):
    with pytest.raises(error, match=named):
        fs.time_minimal_plan(fs.Scene(EMPTY, [mover]), *ENDS, speed)


def test_no_path_is_a_proof():
    # It grows over the goal before the robot can be there, and never leaves it.
    growing = fs.Mover(fs.Disc((2, 1.2), 0.1), growth=0.2)
    with pytest.raises(fs.NoPath, match="movers leave no way"):
        fs.time_minimal_plan(fs.Scene(EMPTY, [growing]), *ENDS, SPEED)
    square = shapely.Point(ENDS[1]).buffer(0.4, cap_style="square").exterior.buffer(0.05)
    outline = np.array(square.exterior.coords)
    box = [fs.Polygon(outline, [np.array(square.interiors[0].coords)])]
    with pytest.raises(fs.NoPath):
        fs.time_minimal_plan(fs.Scene(fs.World(box), crossing(1).movers), *ENDS, SPEED)


def test_a_gap_in_a_timed_path_is_refused():
    one = Straight(np.zeros(2), np.array([1.0, 0]), 0.0, 1.0)
    for start, begin in (((1.1, 0), 1.0), ((1, 0), 1.1)):
        with pytest.raises(fs.InvalidParameter, match="go on"):
            TimedPath([one, Straight(np.array(start), np.array([1.0, 0]), begin, 2.0)])


def test_meeting_times_by_sampling():
    rng, t = np.random.default_rng(0), np.linspace(0, 30, 30_001)
    for _ in range(200):
        offset, velocity = rng.uniform(-2, 2, 2), rng.uniform(-0.2, 0.2, 2) * rng.integers(2)
        radius, growth = rng.uniform(0, 1), rng.choice([0, 0.1, 0.4, -0.4])
        first, last = meeting(offset, velocity, np.array(radius), np.array(growth))
        gap = np.hypot(*(offset[:, None] + velocity[:, None] * t)) - radius - growth * t
        inside = (t >= first) & (t < last)
        assert (gap[inside] < 1e-6).all()
        assert (gap[~inside] > -2e-3).all()
