"""Reactive laws, part by part, against what can be counted or computed by other means."""

import dataclasses

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose
from worlds import transformed

import freeseg as fs
from freeseg.geometry import unit, wrap_angle
from freeseg.reactive.dynamic_window import free_distances, reachable
from freeseg.reactive.sensing import BEAMS, nearest_points, outlines_of, scan

ROBOT = fs.KheperaIV()
LAWS = [fs.PotentialField, fs.VectorFieldHistogram, fs.DynamicWindow]
#: Discs, a polygon that is not convex, and one with a hole.
WORLD = fs.World(
    [
        fs.Disc((0.5, 0.1), 0.05),
        fs.Polygon([(0.2, 0.4), (0.4, 0.4), (0.4, 0.6), (0.3, 0.45), (0.2, 0.6)]),
        fs.Disc((0.8, 0.5), 0.03),
        fs.Polygon(
            [(0.7, 0.7), (1, 0.7), (1, 1), (0.7, 1)], [[(0.8, 0.8), (0.9, 0.8), (0.9, 0.9)]]
        ),
    ]
)
BOUNDED = fs.World(WORLD.obstacles, boundary=[(-0.3, -0.3), (1.3, -0.3), (1.3, 1.3), (-0.3, 1.3)])
GOAL = (0.05, 0.95)


def free_points(world, count=200, seed=0, clearance=0.0):
    points = np.random.default_rng(seed).uniform(-0.2, 1.2, (count, 2))
    return points[world.distances(shapely.points(points)[:, None]).min(-1) > clearance]


# What they see.


@pytest.mark.parametrize("world", [WORLD, BOUNDED], ids=["open", "bounded"])
def test_nearest_points_are_those_of_shapely(world):
    points = free_points(world)
    distance, away = nearest_points(outlines_of(world)(0.0), points)
    assert_allclose(distance, world.distances(shapely.points(points)[:, None]), atol=1e-12)
    # Back along it by the distance lies a point of the obstacle.
    feet = points[:, None] - distance[..., None] * away
    own = shapely.distance(world.cores, shapely.points(feet)) - world.radii
    assert_allclose(own, 0, atol=1e-9)


@pytest.mark.parametrize("world", [WORLD, BOUNDED], ids=["open", "bounded"])
def test_rays_end_where_shapely_says(world):
    shapes = [disc.core.buffer(disc.radius, 512) for disc in world]
    for point in free_points(world, 12):
        bearing, distance = scan(outlines_of(world)(0.0), np.array([*point, 0.3]), 0.5)
        assert_allclose(np.diff(bearing), 2 * np.pi / BEAMS)
        for angle, found in zip(bearing[::7], distance[::7], strict=True):
            ray = shapely.LineString([point, point + 0.5 * unit(angle)])
            met = [shapely.Point(point).distance(ray.intersection(shape)) for shape in shapes]
            met = [length for length in met if not np.isnan(length)]
            if np.isinf(found):
                assert min(met, default=0.5) > 0.4999
            else:
                assert found == pytest.approx(min(met), abs=1e-5)


def test_a_scan_of_many_robots_is_that_of_each():
    points = free_points(WORLD, 8)
    poses = np.vstack([points.T, np.linspace(-4, 4, len(points))])
    outlines = outlines_of(WORLD)(0.0)
    bearing, distance = scan(outlines, poses, 0.6)
    for index, pose in enumerate(poses.T):
        assert_allclose((bearing[:, index], distance[:, index]), scan(outlines, pose, 0.6))


def test_a_ray_along_an_edge_ends_at_its_corner():
    square = fs.World([fs.Polygon([(1, 1), (2, 2), (3, 1)])])
    for angle, shift in ((45, 0), (45, 0.3), (225, 4)):
        _, distance = scan(outlines_of(square)(0.0), np.array([shift, shift, np.radians(angle)]), 5)
        to_corner = min(np.abs(np.array([1, 2]) - shift)) * np.sqrt(2)
        assert distance[0] == pytest.approx(to_corner)


def test_a_robot_inside_a_disc_reads_zero():
    _, distance = scan(outlines_of(WORLD)(0.0), np.array([0.5, 0.1, 0.0]), 0.5)
    assert (distance == 0).all()


# The field.


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize("world", [WORLD, BOUNDED], ids=["open", "bounded"])
def test_the_force_is_minus_the_gradient(world, order):
    field = fs.PotentialField(order=order, influence=0.3, repulsion=1e-3)
    potential, force = field.potential(world, GOAL), field.force(world, GOAL)
    points = free_points(world, clearance=ROBOT.radius + 0.005)
    step = 1e-6 * np.eye(2)
    gradient = np.stack([(potential(points + d) - potential(points - d)) / 2e-6 for d in step], -1)
    assert len(points) > 50
    assert_allclose(force(points), -gradient, rtol=1e-4, atol=1e-6)


def test_the_field_of_one_disc_by_hand():
    world, goal = fs.World([fs.Disc((0, 0), 0.1)]), (0.9, 0)
    field = fs.PotentialField(attraction=2, repulsion=0.01, influence=0.2, order=2)
    # The body is 0.1 m from the disc, the centre 0.6 m from the goal.
    point = (0.2 + ROBOT.radius, 0)
    distance, steep = 0.7 - ROBOT.radius, 1 / 0.1 - 1 / 0.2
    assert field.potential(world, goal)(point) == pytest.approx(
        distance**2 + 0.005 * steep**2 * distance**2
    )
    push = 0.01 * steep * 100 * distance**2
    assert_allclose(field.force(world, goal)(point), [2 * distance + push + 0.25 * distance, 0])


def test_a_goal_near_an_obstacle_is_where_only_the_corrected_field_rests():
    world, goal = fs.World([fs.Disc((1.12, 0), 0.03)]), np.array([1.0, 0.0])
    khatib, corrected = (
        fs.PotentialField(order=order, influence=0.1, repulsion=repulsion)
        for order, repulsion in ((0, 1e-4), (2, 1e-3))
    )
    points = np.stack([np.linspace(0.5, 1.01, 2001), np.zeros(2001)], -1)
    lowest = [
        points[np.argmin(law.potential(world, goal)(points)), 0] for law in (khatib, corrected)
    ]
    assert lowest[0] < 0.99
    assert lowest[1] == pytest.approx(1, abs=3e-4)
    assert not corrected.force(world, goal)(goal).any()
    run = fs.react(corrected, world, (0, 0.01), goal)
    assert run.collision is None
    with pytest.raises(fs.Trapped) as caught:
        fs.react(khatib, world, (0, 0.01), goal)
    # It rests where its potential is lowest.
    assert caught.value.run.pose[0, -1] == pytest.approx(lowest[0], abs=2e-3)


# The histogram.


def one_reading(law, bearing, distance):
    return law.histogram(np.array([bearing]), np.array([distance]), ROBOT)


def test_one_reading_fills_the_sectors_that_can_be_counted():
    # Of 72 sectors of five degrees; the body and the margin are seen under 30 degrees either way.
    law = fs.VectorFieldHistogram(reach=0.5, margin=0.2 * np.sin(np.radians(31)) - ROBOT.radius)
    height = one_reading(law, np.radians(90), 0.2)
    assert np.flatnonzero(height).tolist() == list(range(12, 25))
    assert_allclose(height[12:25], 1 - 0.4**2)
    # Round the x-axis, from 329 to 31 degrees.
    assert np.flatnonzero(one_reading(law, 0.0, 0.2)).tolist() == [*range(7), *range(66, 72)]
    # What is closer than the robot is wide fills half of the circle.
    near = one_reading(law, np.radians(90), 0.01)
    assert np.flatnonzero(near).tolist() == list(range(37))


def test_heights_add_up():
    law = fs.VectorFieldHistogram()
    bearing, distance = np.array([0.3, 0.4, 2.0]), np.array([0.2, 0.3, 0.45])
    alone = [one_reading(law, *reading) for reading in zip(bearing, distance, strict=True)]
    assert_allclose(law.histogram(bearing, distance, ROBOT), sum(alone))
    assert not law.histogram(np.empty(0), np.empty(0), ROBOT).any()


def test_between_the_thresholds_a_sector_stays_as_it_was():
    law = fs.VectorFieldHistogram(low=1, high=2, sectors=8)
    height = np.array([0.5, 1.5, 2.5, 1, 2, 0.5, 1.5, 2.5])
    free, blocked = np.zeros(8, bool), np.ones(8, bool)
    assert law.binary(height, free).astype(int).tolist() == [0, 0, 1, 0, 0, 0, 0, 1]
    assert law.binary(height, blocked).astype(int).tolist() == [0, 1, 1, 1, 1, 0, 1, 1]


def test_what_the_robot_cannot_turn_to_is_masked():
    law, free = fs.VectorFieldHistogram(margin=0), np.zeros(72, bool)
    # On its left at 60 degrees from the heading of 30; both ways round it is nearer to the left
    # centre of an arc of 0.2 m than this and the body.
    bearing, distance = np.radians([90.0]), np.array([0.25])
    heading = np.radians(30)
    masked = law.masked(free, bearing, distance, heading, 0.2, ROBOT)
    assert np.flatnonzero(masked).tolist() == list(range(19, 43))
    # On the spot it can turn anywhere, on a narrow arc before a reading that is farther away.
    assert not law.masked(free, bearing, distance, heading, 0.0, ROBOT).any()
    assert not law.masked(free, bearing, distance + 0.2, heading, 0.1, ROBOT).any()
    # Mirrored, it masks the other side.
    other = law.masked(free, 2 * heading - bearing, distance, heading, 0.2, ROBOT)
    assert np.flatnonzero(other).tolist() == list(range(43, 66))


def test_narrow_openings_are_passed_in_the_middle_and_wide_ones_near_their_borders():
    law = fs.VectorFieldHistogram(wide=np.radians(80))
    blocked = np.ones(72, bool)
    assert law.select(blocked, 0.0, 0.0, 0.0) is None
    blocked[10:15] = False
    assert np.degrees(law.select(blocked, 0.0, 0.0, 0.0)) == pytest.approx(60)
    # From 50 to 200 degrees: to the goal, if that is 40 degrees inside, else along the border.
    blocked[10:41] = False
    for goal, chosen in ((100, 100), (95, 95), (60, 90), (190, 160), (300, 90)):
        goal = np.radians(goal)
        found = law.select(blocked, goal, np.radians(90), np.radians(90))
        assert np.degrees(found) == pytest.approx(chosen)
    # An opening across the x-axis is one.
    blocked[:] = True
    blocked[[70, 71, 0, 1, 2]] = False
    assert np.degrees(wrap_angle(law.select(blocked, 1.0, 1.0, 1.0))) == pytest.approx(0)
    assert law.select(np.zeros(72, bool), 1.2345, 0.0, 0.0) == 1.2345


def test_the_weights_choose_between_two_openings():
    blocked = np.ones(72, bool)
    blocked[[8, 9, 10, 62, 63, 64]] = False
    # At 45 and at -45 degrees. The goal is to the right; heading and last choice to the left.
    angles = np.radians([-10, 30, 30])
    for weights, chosen in (
        ((5, 2, 2), 45),
        ((5, 0.5, 0.5), -45),
        ((5, 0, 0), -45),
        ((0, 1, 0), 45),
    ):
        costs = [np.dot(weights, np.abs(np.radians(angle) - angles)) for angle in (45, -45)]
        assert (45, -45)[np.argmin(costs)] == chosen
        names = "to_goal", "to_heading", "to_previous"
        law = fs.VectorFieldHistogram(**dict(zip(names, weights, strict=True)))
        assert np.degrees(wrap_angle(law.select(blocked, *angles))) == pytest.approx(chosen)


# The window.


def test_arcs_end_where_a_fine_search_says():
    rng = np.random.default_rng(0)
    v, omega = rng.uniform(0.02, 0.3, 60), rng.uniform(-3, 3, 60)
    omega[:5] = 0
    x, y = rng.uniform(-0.5, 0.5, (2, 4))
    s = np.arange(0, 4, 2e-4)
    for one_v, one_omega in zip(v, omega, strict=True):
        turned = one_omega / one_v * s
        chord, middle = s * np.sinc(turned / (2 * np.pi)), turned / 2
        apart = np.hypot(chord * np.cos(middle) - x[:, None], chord * np.sin(middle) - y[:, None])
        met = (apart < 0.07).any(0)
        found = float(free_distances(np.array([one_v]), np.array([one_omega]), x, y, 0.07)[0])
        if met.any():
            assert found == pytest.approx(s[np.argmax(met)], abs=3e-4)
        else:
            assert np.isinf(found) or found > 4


def test_what_is_too_close_stops_only_who_drives_towards_it():
    ahead, behind = (np.array([0.05]), np.zeros(1)), (np.array([-0.05]), np.zeros(1))
    v, omega = np.array([0.1, 0.1, 0.0]), np.array([0.0, 1.0, 1.0])
    assert free_distances(v, omega, *ahead, 0.07).tolist() == [0, 0, 0]
    # Who turns on the spot until it is behind can leave.
    assert free_distances(v, omega, *ahead, 0.07, 2.0).tolist() == [0, 0, np.inf]
    assert free_distances(v, omega, *behind, 0.07).tolist() == [np.inf] * 3


@pytest.mark.parametrize("dist", [0.0, 0.01, 0.05, 0.3])
def test_admissible_speeds_are_those_that_stop_in_time(dist):
    law, dt, slow = fs.DynamicWindow(), 0.05, fs.Robot(0.1, 0.14, 0.02, 40, 10)
    v = np.linspace(0, 0.5, 2001)
    allowed = law.admissible(v, np.zeros_like(v), np.full_like(v, dist), slow, dt)
    # Held for a step, and braked from then on: at most this far. At rest, it stays.
    stops = v * dt + v**2 / (2 * slow.max_wheel_acceleration) <= dist
    assert allowed.tolist() == stops.tolist()
    fastest = v[allowed].max()
    run = fs.drive(lambda t, pose: (fastest * (t < 0.5), 0), (0, 0, 0), 0.001, 4000, slow)
    # By the wheels' own braking, from the time on at which it begins.
    assert (
        run.pose[0, -1] - run.pose[0, 500] <= fastest**2 / (2 * slow.max_wheel_acceleration) + 1e-3
    )


def test_a_turn_rate_that_cannot_be_braked_is_not_admissible():
    law, slow = fs.DynamicWindow(), fs.Robot(0.1, 0.14, 0.02, 40, 10)
    omega = np.linspace(-3, 3, 601)
    v, dist = np.full_like(omega, 1e-6), np.full_like(omega, 0.2)
    allowed = law.admissible(v, omega, dist, slow, 0.05)
    braking = 2 * slow.max_wheel_acceleration / slow.wheel_base
    assert np.abs(omega[allowed]).max() == pytest.approx(np.sqrt(2 * 0.2 * braking), abs=0.011)
    assert law.admissible(0 * v, omega, np.full_like(omega, np.inf), slow, 0.05).all()


def test_the_window_keeps_to_its_limits():
    slow = fs.Robot(0.1, 0.14, 0.02, 40, 10)
    law, dt = fs.DynamicWindow(speed=0.2, turn_rate=2, approach=1), 0.05
    v, omega = law.window(0.1, 0.5, slow, dt, 10.0)
    within = reachable(v, omega, 0.1, 0.5, slow, dt)
    reached = slow.saturate(slow.to_wheels(v, omega), slow.to_wheels(0.1, 0.5)[:, None, None], dt)
    kept = np.abs(reached - slow.to_wheels(v, omega)).max(0) < 1e-12
    assert (within == kept).all()
    assert within.any()
    assert not within.all()
    # Speeds up to the top, less near the goal; and none backwards.
    assert v.max() == pytest.approx(0.11)
    assert law.window(0.0, 0.0, slow, dt, 0.004)[0].max() == pytest.approx(0.004)
    assert law.window(0.0, 0.0, slow, dt, 10.0)[0].min() == 0
    assert np.abs(law.window(0.1, 1.95, slow, dt, 10.0)[1]).max() <= 2
    # Straight on is among them wherever it can be reached.
    assert (law.window(0.1, 0.02, slow, dt, 10.0)[1] == 0).any()


def test_heading_is_judged_where_the_robot_would_rest():
    slow = fs.Robot(0.1, 0.14, 0.02, 40, 10)
    law = fs.DynamicWindow(to_clear=0, to_speed=0, to_goal=1, interval=0.5)
    # By the loop itself: up to the turn rate, and from 1 s on the interval and the brakes.
    turn = fs.drive(lambda t, pose: (0, 1.5 * (t < 1.5)), (0, 0, 0), 0.001, 4000, slow)
    goal = unit(turn.pose[2, -1] - turn.pose[2, 1000])
    here, free = np.zeros(1), np.ones(1)
    best = law.objective(here, np.array([1.5]), free, *goal, slow)
    assert best == pytest.approx(1, abs=1e-3)
    for other in (1.4, 1.6):
        assert law.objective(here, np.array([other]), free, *goal, slow) < best - 0.01


def test_the_objective_by_hand():
    law = fs.DynamicWindow(to_goal=2, to_clear=0.3, to_speed=0.5, reach=0.4, speed=0.2)
    # Straight to a goal beyond the reach, half of which is free, at half of the top speed.
    worth = law.objective(np.array([0.1]), np.zeros(1), np.array([0.2]), 1.0, 0.0, ROBOT)
    assert worth == pytest.approx(2 + 0.15 + 0.25)
    # The goal behind: nothing for the heading; a goal nearer than the reach counts for it.
    worth = law.objective(np.zeros(1), np.zeros(1), np.array([0.05]), -0.1, 0.0, ROBOT)
    assert worth == pytest.approx(0.15)


# All of them.


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("angle", [np.pi / 2, np.radians(35)])
def test_a_turned_and_shifted_world_is_driven_alike(kind, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    world = fs.World(WORLD.obstacles)
    there, move = transformed(world, [[cos, -sin], [sin, cos]], (0.3, -0.2))
    start, goal = np.array([0.0, 0.0]), np.array([0.62, 0.62])
    one = fs.react(kind(), world, start, goal)
    other = fs.react(kind(), there, move(start), move(goal))
    shared = min(one.pose.shape[-1], other.pose.shape[-1], 100)
    assert_allclose(move(one.pose[:2, :shared].T), other.pose[:2, :shared].T, atol=1e-6)


@pytest.mark.parametrize("kind", LAWS)
def test_a_batch_is_many_robots(kind):
    law = kind().start(WORLD, GOAL, ROBOT, 0.05)
    poses = np.array([[0, 0.65, 0], [0, 0.2, 1], [0.3, -3, 2]])
    run = fs.drive(law, poses, 0.05, 40, disturbance=fs.Disturbance(position_noise=1e-4), seed=3)
    for index in range(3):
        alone = kind().start(WORLD, GOAL, ROBOT, 0.05)
        single = fs.drive(
            alone,
            poses[:, index],
            0.05,
            40,
            disturbance=fs.Disturbance(position_noise=1e-4),
            seed=(3, index),
        )
        assert_allclose(run.pose[:, index], single.pose, atol=1e-9)


@pytest.mark.parametrize("kind", LAWS)
def test_a_law_forgets_the_drive_before(kind):
    gains = kind()
    first, again = (fs.react(gains, WORLD, (0, 0), (0.62, 0.3)) for _ in range(2))
    assert (first.pose == again.pose).all()


@pytest.mark.parametrize("kind", LAWS)
def test_wrong_gains_are_named(kind):
    for field in dataclasses.fields(kind):
        for value in (-1, np.nan, "1", None):
            with pytest.raises(fs.InvalidParameter, match=field.name):
                kind(**{field.name: value})
    with pytest.raises(fs.InvalidQuery, match="goal"):
        kind().start(WORLD, (0.5, 0.1), ROBOT, 0.05)
    with pytest.raises(fs.InvalidQuery, match="scene"):
        kind().start(fs.plan, GOAL, ROBOT, 0.05)


def test_gains_that_do_not_belong_together_are_refused():
    with pytest.raises(fs.InvalidParameter, match="low is 3"):
        fs.VectorFieldHistogram(low=3, high=2)
    with pytest.raises(fs.InvalidParameter, match=r"order is 0\.5"):
        fs.PotentialField(order=0.5)
