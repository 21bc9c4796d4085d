from itertools import product

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.reference import SMOOTHING, Reference, Sample
from freeseg.trackers.sliding_mode import SWITCHING

#: Where a robot may start: 2 cm behind, 3 cm to the left and 20 degrees off.
OFFSET = (-0.02, 0.03, np.radians(20))
BEND = fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 2.5)])


@pytest.fixture(scope="module")
def path(cases, tables):
    """The planned path of Fig. 15(a)."""
    return fs.plan(tables[1], cases["15a"].start, cases["15a"].goal).path


@pytest.fixture(scope="module")
def reference(path):
    return fs.make_reference(path)


def assert_within_limits(run, robot, dt):
    """The wheels are driven from rest and keep the robot's limits at every step."""
    changes = np.diff(run.wheels, axis=-1, prepend=0.0)
    assert np.abs(run.wheels).max() <= robot.max_wheel_speed + 1e-12
    assert np.abs(changes).max() <= robot.max_wheel_acceleration * dt + 1e-12


# --- reference -----------------------------------------------------------------------------------


def test_reference_goes_from_rest_to_rest_along_the_path(path, reference):
    assert_allclose(reference.v[[0, -1]], 0, atol=1e-12)
    assert_allclose(reference.omega[[0, -1]], 0, atol=1e-12)
    assert_allclose(reference.pose[:2, 0], path.start, atol=1e-12)
    assert_allclose(reference.pose[:2, -1], path.end, atol=1e-12)
    assert np.diff(reference.t).max() <= 0.001 + 1e-12


def test_speed_is_the_rate_of_the_way_and_adds_up_to_the_length(path, reference):
    assert np.trapezoid(reference.v, reference.t) == pytest.approx(path.length, rel=1e-6)
    steps = np.hypot(*np.diff(reference.pose[:2], axis=1))
    middle = (reference.v[1:] + reference.v[:-1]) / 2
    assert_allclose(steps, middle * np.diff(reference.t), rtol=0, atol=1e-7)
    # The rate of v is v_dot, within one step of the grid at the corners of the trapezium.
    slope = np.diff(reference.v) / np.diff(reference.t)
    assert_allclose(np.median(slope - reference.v_dot[:-1]), 0, atol=1e-9)
    assert np.mean(np.abs(slope - reference.v_dot[:-1]) > 1e-6) < 0.001


def test_speed_is_trapezoidal_by_hand():
    # 2 m at 0.2 m/s with ramps of 0.4 m/s^2: 0.5 s of ramp at either end, 10.5 s in all.
    reference = fs.make_reference(fs.Path([Line((0, 0), (2, 0))]), speed=0.2, acceleration=0.4)
    assert reference.duration == pytest.approx(10.5)
    sample = reference.at([0.25, 0.5, 5, 10.25])
    assert_allclose(sample.pose[0], [0.0125, 0.05, 0.95, 1.9875], atol=1e-6)
    assert_allclose(sample.v, [0.1, 0.2, 0.2, 0.1], atol=1e-3)
    assert_allclose(reference.at([0.25, 5, 10.25]).v_dot, [0.4, 0, -0.4])


def test_a_short_path_is_left_before_the_cruising_speed_is_reached():
    # 1 cm with 0.2 m/s^2: half of it takes sqrt(0.01 / 0.2) s.
    reference = fs.make_reference(fs.Path([Line((0, 0), (0.01, 0))]), speed=0.5, acceleration=0.2)
    assert reference.duration == pytest.approx(2 * np.sqrt(0.05))
    assert reference.v.max() == pytest.approx(0.2 * np.sqrt(0.05), rel=1e-2)
    assert reference.pose[0, -1] == pytest.approx(0.01)


def test_a_slow_reference_has_a_coarser_grid(path):
    # At 0.1 mm/s a grid of 1 ms would have eleven million points.
    reference = fs.make_reference(path, speed=1e-4)
    assert len(reference.t) <= 200_000
    assert reference.duration == pytest.approx(path.length / 1e-4, rel=1e-6)
    assert_allclose(reference.pose[:2, -1], path.end, atol=1e-12)


def test_turn_rate_is_speed_times_curvature(path, reference):
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(reference.pose[:2], axis=1)))])
    _, _, theta, curvature = path.at(s * path.length / s[-1])
    # Away from the joints, where the curvature jumps within a step of the grid.
    away = np.abs(s[:, None] - path.joints).min(1) > 1e-3
    assert away.mean() > 0.9
    assert_allclose(reference.omega[away], (reference.v * curvature)[away], atol=1e-12)
    assert_allclose(reference.omega_dot[away], (reference.v_dot * curvature)[away], atol=1e-12)
    assert_allclose(reference.pose[2], theta, atol=1e-4)


def test_reference_is_at_rest_beyond_its_ends(reference):
    ends = reference.at([-1, reference.duration + 1])
    assert_array_equal(ends.pose, reference.pose[:, [0, -1]])
    for rate in (ends.v, ends.omega, ends.v_dot, ends.omega_dot):
        assert_array_equal(rate, [0, 0])


def test_reference_at_agrees_with_its_grid(reference):
    sample = reference.at(reference.t)
    assert_array_equal(sample.pose, reference.pose)
    assert_array_equal(sample.v, reference.v)
    assert reference.at(1.0).pose.shape == (3,)
    assert reference.at(np.ones((2, 5))).pose.shape == (3, 2, 5)


@pytest.mark.parametrize("dt", [0.05, 0.013, 0])
def test_a_sampler_is_the_reference_now_and_half_a_step_later(reference, dt):
    look = reference.sampler(dt)
    between = np.random.default_rng(55).uniform(-1, reference.duration + 1, 20)
    for t in [*(reference.steps(dt) if dt else ()), *between]:
        for read, asked in zip(look(t), reference.at([t, t + dt / 2]), strict=True):
            assert_array_equal(read, asked)


@pytest.mark.parametrize("name", ["speed", "acceleration"])
@pytest.mark.parametrize("value", [0, -0.1, np.nan, np.inf, None, "fast", (0.1, 0.2)])
def test_invalid_speed_and_acceleration(path, name, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is "):
        fs.make_reference(path, **{name: value})


def test_speed_is_limited_by_the_outer_wheel(robot):
    # On an arc of radius R the outer wheel is (1 + L / 2R) times as fast as the robot.
    limit = robot.max_wheel_speed / (1 + robot.wheel_base / 0.6)
    reference = fs.make_reference(BEND, speed=0.999 * limit, acceleration=2)
    wheels = robot.to_wheels(reference.v, reference.omega)
    assert 0.99 * robot.max_wheel_speed < wheels.max() <= robot.max_wheel_speed
    # Asked for more, the robot is as fast as the wheel lets it.
    reference = fs.make_reference(BEND, speed=robot.max_wheel_speed, acceleration=2)
    assert reference.v.max() == pytest.approx(limit, rel=1e-12)
    straight = fs.Path([Line((0, 0), (9, 0))])
    with pytest.raises(fs.InvalidParameter, match=r"speed is 1\.1"):
        fs.make_reference(straight, speed=1.1)
    with pytest.raises(fs.InvalidParameter, match="acceleration is 3"):
        fs.make_reference(straight, acceleration=3)


def test_smoothing_turns_the_steps_of_the_curvature_into_ramps(path, tables, robot):
    reference = fs.make_reference(path, smoothing=SMOOTHING, world=tables[1])
    # The way is a few tenths of a millimetre shorter, and the path is moved by about as much.
    assert np.trapezoid(reference.v, reference.t) == pytest.approx(path.length, abs=1e-3)
    widest = max(abs(piece.curvature) for piece in path.pieces) * SMOOTHING**2 / 24
    assert 0.9 * widest < reference.shift <= widest
    assert_allclose(reference.pose[:2, [0, -1]].T, [path.start, path.end], atol=1e-12)
    assert_allclose(np.diff(reference.omega), 0, atol=0.01)
    assert np.abs(np.diff(fs.make_reference(path).omega)).max() > 0.5


@pytest.mark.parametrize("speed", [0.1, 0.5, 0.99])
@pytest.mark.parametrize("acceleration", [0.2, 2.7])
def test_smoothed_references_keep_the_limits_of_the_wheels(
    cases, tables, robot, speed, acceleration
):
    for case in cases.values():
        world = tables[case.table]
        path = fs.plan(world, case.start, case.goal).path
        reference = fs.make_reference(path, robot, speed, acceleration, SMOOTHING, world)
        assert reference.shift <= 0.0007
        assert reference.v.max() <= speed + 1e-12
        assert np.abs(reference.v_dot).max() <= acceleration + 1e-9
        wheels = robot.to_wheels(reference.v, reference.omega)
        rates = robot.to_wheels(reference.v_dot, reference.omega_dot)
        assert np.abs(wheels).max() <= robot.max_wheel_speed * (1 + 1e-6)
        assert np.abs(rates).max() <= robot.max_wheel_acceleration * (1 + 1e-6)
        # What the wheels do between the points of the grid, and not only what is said of it.
        slopes = np.diff(wheels) / np.diff(reference.t)
        assert np.abs(slopes).max() <= robot.max_wheel_acceleration * (1 + 1e-6)
        # Position, speed and their rates belong together.
        ways = np.hypot(*np.diff(reference.pose[:2]))
        assert_allclose(
            # But for corners of v between two points.
            ways,
            np.diff(reference.t) * (reference.v[1:] + reference.v[:-1]) / 2,
            atol=acceleration * 1e-6 / 2,
        )
        turns = np.diff(reference.t) * (reference.omega[1:] + reference.omega[:-1]) / 2
        assert_allclose(np.diff(reference.pose[2]), turns, atol=2e-5)
        # Smoothing leaves the robot's disc free.
        points = shapely.points(reference.pose[:2, ::10].T)
        assert world.distances(points[:, None]).min() >= robot.radius


def test_the_speed_is_as_large_as_the_limits_let_it(path, tables, robot):
    # Somewhere on the way, one of them is reached, and nearly everywhere speed or acceleration.
    reference = fs.make_reference(path, robot, 0.99, 2.7, SMOOTHING, tables[1])
    wheels = robot.to_wheels(reference.v, reference.omega)
    rates = np.abs(robot.to_wheels(reference.v_dot, reference.omega_dot)).max(0)
    busy = (np.abs(wheels).max(0) > 0.999 * robot.max_wheel_speed) | (
        rates > 0.49 * robot.max_wheel_acceleration
    )
    assert busy.mean() > 0.95
    # The acceleration of the wheels is not left unused on ramps of the curvature.
    assert rates.max() > 0.98 * robot.max_wheel_acceleration


def test_given_speeds_at_the_ends_by_hand():
    # From 0.3 to 0.1 m/s over 1 m, 0.2 m/s^2, cruising at 0.4 m/s: ramps of 0.175 and 0.375 m.
    straight = fs.Path([Line((0, 0), (1, 0))])
    reference = fs.make_reference(straight, speed=0.4, start_speed=0.3, end_speed=0.1)
    assert_allclose(reference.v[[0, -1]], [0.3, 0.1], atol=1e-12)
    assert reference.duration == pytest.approx(0.5 + 0.45 / 0.4 + 1.5, rel=1e-5)
    assert reference.v.max() == pytest.approx(0.4)


def test_ends_that_the_path_does_not_allow(path, robot):
    short = fs.Path([Line((0, 0), (0.1, 0))])
    # From 0.1 m at 0.2 m/s^2, the robot stops from sqrt(2 * 0.2 * 0.1) = 0.2 m/s at most.
    with pytest.raises(
        fs.InvalidParameter, match=r"start_speed is 0\.3 .* 0\.1000 m .* 0\.2000 m/s"
    ):
        fs.make_reference(short, speed=0.5, start_speed=0.3)
    with pytest.raises(fs.InvalidParameter, match=r"end_speed is 0\.3 .* 0\.0000 m .* 0\.2000 m/s"):
        fs.make_reference(short, speed=0.5, end_speed=0.3)
    assert fs.make_reference(short, speed=0.5, start_speed=0.2).v[0] == pytest.approx(0.2)
    # On an arc, the outer wheel is the limit, and the arc the place.
    limit = robot.max_wheel_speed / (1 + robot.wheel_base / 0.6)
    with pytest.raises(fs.InvalidParameter, match=f"start_speed is .* {limit:.4f} m/s at this end"):
        fs.make_reference(BEND, speed=0.9, acceleration=2, start_speed=limit + 0.01)
    for name in ("start_speed", "end_speed"):
        for value in (-0.1, np.nan, "fast", 0.11):
            with pytest.raises(fs.InvalidParameter, match=f"{name} is "):
                fs.make_reference(path, speed=0.1, **{name: value})


def test_smoothing_of_a_path_shorter_than_its_window(robot):
    bend = fs.Path([Line((0, 0), (0.01, 0)), Arc((0.01, 0.1), 0.1, -np.pi / 2, 0.1)])
    reference = fs.make_reference(bend, smoothing=SMOOTHING, world=fs.World([]))
    assert_allclose(reference.pose[:2, [0, -1]].T, [bend.start, bend.end], atol=1e-12)
    assert 0 < reference.shift <= 10 * bend.length**2 / 24
    rates = robot.to_wheels(reference.v_dot, reference.omega_dot)
    assert np.abs(rates).max() <= robot.max_wheel_acceleration * (1 + 1e-6)


def test_smoothing_that_makes_no_sense(path, tables):
    with pytest.raises(fs.InvalidParameter, match="give the world"):
        fs.make_reference(path, smoothing=SMOOTHING)
    with pytest.raises(fs.InvalidQuery, match="give a World"):
        fs.make_reference(path, smoothing=SMOOTHING, world=[])
    for value in (-0.01, np.nan, np.inf, "wide"):
        with pytest.raises(fs.InvalidParameter, match="smoothing is "):
            fs.make_reference(path, smoothing=value, world=tables[1])
    with pytest.raises(fs.InvalidParameter, match=r"radius 0\.0\d+ m of the arc .* 0\.\d+ m"):
        fs.make_reference(path, smoothing=0.2, world=tables[1])


def test_smoothing_never_costs_the_clearance(robot):
    # The path just passes the obstacle inside its bend; moved inwards, it would not.
    world = fs.World([fs.Disc((0, 0.3), 0.3 - robot.radius - 0.0001)])
    fs.make_reference(BEND, smoothing=0.02, world=world)
    with pytest.raises(fs.InvalidParameter, match=r"70\.\d\d mm from obstacle 1 at 0\.\d+ m"):
        fs.make_reference(BEND, smoothing=0.03, world=world)


@pytest.mark.parametrize("path", [None, [(0, 0), (1, 1)], Line((0, 0), (1, 0))])
def test_reference_of_what_is_no_path(path):
    with pytest.raises(fs.InvalidParameter, match="give a Plan, or a Path"):
        fs.make_reference(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("t", [0.0]),
        ("t", [1.0, 2.0, 3.0]),
        ("t", [0.0, 2.0, 1.0]),
        ("t", [0.0, np.nan, 1.0]),
        ("pose", np.zeros((2, 3))),
        ("v", np.zeros(2)),
        ("omega", [0.0, np.inf, 0.0]),
        ("v_dot", [np.nan, 0.0, 0.0]),
        ("omega_dot", 0.0),
    ],
)
def test_invalid_reference(name, value):
    zero = np.zeros(3)
    arrays = {"t": np.arange(3.0), "pose": np.zeros((3, 3)), "v": zero, "omega": zero}
    arrays |= {"v_dot": zero, "omega_dot": zero}
    assert Reference(**arrays).duration == 2
    with pytest.raises(fs.InvalidParameter, match="reference"):
        Reference(**arrays | {name: np.asarray(value)})


# --- tracking error ------------------------------------------------------------------------------


def test_tracking_error_by_hand():
    # The robot looks north: a reference to the north-west is ahead and to the left.
    error = fs.tracking_error((-1, 2, np.pi), (0, 0, np.pi / 2))
    assert_allclose(error, (2, 1, np.pi / 2), atol=1e-15)
    # Headings that differ by nearly a whole turn are close.
    error = fs.tracking_error((0, 0, 3), (0, 0, -3))
    assert_allclose(error, (0, 0, 6 - 2 * np.pi))


def test_tracking_error_does_not_depend_on_the_frame():
    rng = np.random.default_rng(51)
    wanted, pose = rng.uniform(-3, 3, (2, 3, 100))
    turn, shift = 0.7, np.array([[4], [-2], [0.7]])
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0] * 3])
    matrix[2, 2] = 1
    moved = fs.tracking_error(matrix @ wanted + shift, matrix @ pose + shift)
    error = fs.tracking_error(wanted, pose)
    assert_allclose(moved[:2], error[:2], atol=1e-13)
    assert_allclose(np.exp(1j * moved[2]), np.exp(1j * error[2]), atol=1e-13)


# --- sliding mode --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def on_path(reference, robot):
    return fs.simulate(fs.SlidingMode(), reference, robot)


@pytest.fixture(scope="module")
def off_path(reference, robot):
    return fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=OFFSET)


def test_from_on_the_path_the_robot_stays_on_it(reference, on_path):
    position = np.hypot(*on_path.error[:2])
    assert np.sqrt((position**2).mean()) <= 0.0015
    assert_array_equal(on_path.pose[:, 0], reference.pose[:, 0])


def test_from_beside_the_path_the_errors_vanish(off_path):
    assert_allclose(off_path.error[:, 0], fs.tracking_error((0, 0, 0), OFFSET), atol=1e-12)
    position = np.hypot(*off_path.error[:2])
    assert position[0] > 0.03
    assert position[off_path.t >= 4].max() < 0.01
    assert position[-1] < 0.001
    assert abs(off_path.error[2, -1]) < 0.02


def test_wheels_keep_the_limits(on_path, off_path, robot):
    assert_within_limits(on_path, robot, 0.05)
    assert_within_limits(off_path, robot, 0.05)


def test_wheels_keep_the_limits_from_wherever_and_whatever_the_gains(reference, robot):
    rng = np.random.default_rng(52)
    for _ in range(10):
        names = ("k1", "k2", "phi1", "phi2", "length_scale")
        gains = dict(zip(names, 10 ** rng.uniform(-2, 1, len(names)), strict=True))
        offsets = rng.normal(0, [[0.3], [0.3], [1.5]], (3, 20))
        tracker = fs.SlidingMode(**gains, switching=str(rng.choice(sorted(SWITCHING))))
        run = fs.simulate(tracker, reference, robot, dt=0.1, initial_offset=offsets)
        assert np.isfinite(run.pose).all()
        assert_within_limits(run, robot, 0.1)


def test_a_batch_is_bit_for_bit_its_single_runs(reference, robot):
    offsets = np.random.default_rng(53).normal(0, [[0.05], [0.05], [0.4]], (3, 7))
    batch = fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=offsets)
    assert batch.pose.shape == (3, 7, len(batch.t))
    assert batch.reference.shape == (3, len(batch.t))
    for number, offset in enumerate(offsets.T):
        single = fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=offset)
        assert_array_equal(batch.pose[:, number], single.pose)
        assert_array_equal(batch.error[:, number], single.error)
        assert_array_equal(batch.wheels[:, number], single.wheels)


def test_the_law_for_a_batch_is_bit_for_bit_that_for_one(reference, robot):
    # Thousands of poses, for what differs may do so in one of a thousand: x ** 2 does.
    poses = np.random.default_rng(56).normal(0, [[0.3], [0.3], [2]], (3, 20_000))
    poses += reference.at(0.4).pose[:, None]
    law = fs.SlidingMode().start(reference, robot, 0.05)
    batch = np.array(law(0.4, poses))
    assert_array_equal(batch, np.transpose([law(0.4, pose) for pose in poses.T]))


def test_running_again_gives_the_same(reference, robot, off_path):
    tracker = fs.SlidingMode()
    for _ in range(2):
        again = fs.simulate(tracker, reference, robot, initial_offset=OFFSET)
        assert_array_equal(again.pose, off_path.pose)
        assert_array_equal(again.wheels, off_path.wheels)


def test_a_run_hangs_together(reference, robot, off_path):
    run, dt = off_path, 0.05
    assert_allclose(run.t, dt * np.arange(len(run.t)))
    assert reference.duration <= run.t[-1] < reference.duration + dt
    assert_array_equal(run.reference, reference.at(run.t).pose)
    assert_array_equal(run.error, fs.tracking_error(run.reference, run.pose))
    moved = robot.move(run.pose[:, :-1], run.wheels[:, :-1], dt)
    assert_allclose(moved, run.pose[:, 1:], rtol=0, atol=1e-12)


def sliding_surface(tracker, reference, t, pose):
    """s of equation (10), with the scale of the code's gamma."""
    target = reference.at(t)
    x_e, y_e, alpha_e = fs.tracking_error(target.pose, pose)
    scale = reference.v.max() * tracker.length_scale
    return np.array([x_e, alpha_e + np.arctan(target.v * y_e / scale)])


@pytest.mark.parametrize("switching", sorted(SWITCHING))
def test_the_law_reaches_the_surface_as_equations_11_and_12_say(robot, switching):
    # ds/dt = -k sat(s / phi) along the closed loop: no limits, commands not held (dt = 0).
    tracker = fs.SlidingMode(switching=switching)
    reference = fs.make_reference(BEND, speed=0.2, acceleration=0.1)
    law = tracker.start(reference, robot, 0.0)
    rng = np.random.default_rng(54)
    # Grid points of the reference while it speeds up, cruises and brakes.
    at = np.linspace(0.05, 0.95, 30) * len(reference.t)
    h = reference.t[1]
    for index in at.astype(int):
        t, pose = reference.t[index], reference.pose[:, index] + rng.normal(0, [0.02, 0.02, 0.3])
        v, omega = law(t, pose)
        rate = np.array([v * np.cos(pose[2]), v * np.sin(pose[2]), omega])
        before, here, after = (
            sliding_surface(tracker, reference, t + step, pose + step * rate) for step in (-h, 0, h)
        )
        x_e = fs.tracking_error(reference.pose[:, index], pose)[0]
        # So that the denominator is off its floor:
        assert x_e > -(1 - tracker.floor) * tracker.length_scale
        reaching = SWITCHING[switching](here / (tracker.phi1, tracker.phi2))
        assert_allclose((after - before) / (2 * h), -reaching * (tracker.k1, tracker.k2), atol=2e-4)


def test_the_denominator_of_the_turn_rate_is_guarded(robot):
    # The reference is 0.2 m straight behind: with dgamma/dy_e = 10 / m it would be 1 - 2 = -1.
    reference = fs.make_reference(fs.Path([Line((0, 0), (5, 0))]))
    t, tracker = 10.0, fs.SlidingMode(length_scale=0.1, floor=0.25, k2=2.0, phi2=0.5)
    pose = reference.at(t).pose + np.array([0.2 * np.cos(0.1), -0.2 * np.sin(0.1), -0.1])
    error = fs.tracking_error(reference.at(t).pose, pose)
    assert_allclose(error, (-0.2, 0, 0.1), atol=1e-12)
    _, omega = tracker.start(reference, robot, 0.0)(t, pose)
    # (12) by hand: alpha_e = 0.1 = s2 and v_r = 0.1 m/s.
    assert omega == pytest.approx((10 * 0.1 * np.sin(0.1) + 2 * 0.1 / 0.5) / 0.25)


def test_on_the_reference_the_law_commands_its_velocities(reference, robot):
    law = fs.SlidingMode().start(reference, robot, 0.0)
    for t in np.linspace(0, reference.duration, 50):
        target = reference.at(t)
        assert_allclose(law(t, target.pose), (target.v, target.omega), atol=1e-14)


def test_switching_functions_by_hand():
    s = np.array([-3, -0.5, 0, 0.5, 3])
    assert_array_equal(SWITCHING["sat"](s), [-1, -0.5, 0, 0.5, 1])
    assert_array_equal(SWITCHING["sign"](s), [-1, -1, 0, 1, 1])
    assert_allclose(SWITCHING["tanh"](s), np.tanh(s))


def test_switching_functions_drive_differently(reference, robot, off_path):
    runs = [off_path.pose]
    for switching in ("sign", "tanh"):
        tracker = fs.SlidingMode(switching=switching)
        run = fs.simulate(tracker, reference, robot, initial_offset=OFFSET)
        runs.append(run.pose)
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert np.abs(runs[one] - runs[other]).max() > 1e-3


@pytest.mark.parametrize("name", ["k1", "k2", "phi1", "phi2", "length_scale", "floor"])
@pytest.mark.parametrize("value", [True, -1, np.nan, np.inf, None, "high"])
def test_invalid_gain(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is "):
        fs.SlidingMode(**{name: value})


@pytest.mark.parametrize("switching", ["", "SAT", "relay", None, 1, ["sat"]])
def test_invalid_switching(switching):
    with pytest.raises(fs.InvalidParameter, match=r"switching is .*'sat', 'sign', 'tanh'"):
        fs.SlidingMode(switching=switching)


@pytest.mark.parametrize(
    "run",
    [
        lambda number: fs.make_reference(BEND, speed=number),
        lambda number: fs.make_reference(BEND, acceleration=number),
        lambda number: fs.simulate(fs.SlidingMode(), fs.make_reference(BEND), dt=number),
        lambda number: fs.simulate(fs.SlidingMode(k1=number), fs.make_reference(BEND)),
    ],
    ids=["speed", "acceleration", "dt", "gain"],
)
def test_a_number_as_text_is_refused_or_understood(run):
    # Accepted as it stands, it would only fail later, in the first calculation.
    try:
        from_text = run("0.1")
    except fs.InvalidParameter:
        return
    assert_array_equal(from_text.pose, run(0.1).pose)


# --- simulation ----------------------------------------------------------------------------------


@pytest.mark.parametrize("dt", [0, -0.05, np.nan, np.inf, None, "short", 1000])
def test_invalid_time_step(reference, dt):
    with pytest.raises(fs.InvalidParameter, match="dt is "):
        fs.simulate(fs.SlidingMode(), reference, dt=dt)


@pytest.mark.parametrize(
    "offset",
    [
        (0, 0),
        (0, 0, 0, 0),
        0,
        (0, np.nan, 0),
        (0, 0, np.inf),
        np.zeros((2, 3)),
        np.zeros((3, 2, 2)),
        [(0, 0), (0,), (0, 0)],
        "left",
        None,
    ],
)
def test_invalid_offset(reference, offset):
    with pytest.raises(fs.InvalidParameter, match=r"initial_offset (is|has shape) "):
        fs.simulate(fs.SlidingMode(), reference, initial_offset=offset)


def test_initial_offset_is_seen_from_the_first_pose():
    # The reference starts northwards: ahead is north, left is west.
    reference = fs.make_reference(fs.Path([Line((1, 1), (1, 2))]))
    run = fs.simulate(fs.SlidingMode(), reference, initial_offset=(0.3, 0.2, 0.1))
    assert_allclose(run.pose[:, 0], (0.8, 1.3, np.pi / 2 + 0.1))


def test_any_object_with_a_law_can_be_driven(robot):
    class Circle:
        """Commands one velocity, whatever happens."""

        def start(self, reference, robot, dt):
            return lambda t, pose: (0.1, 0.5)

    reference = fs.make_reference(fs.Path([Line((0, 0), (1, 0))]))
    run = fs.simulate(Circle(), reference, robot, dt=0.1)
    assert_allclose(run.wheels, np.tile(robot.to_wheels(0.1, 0.5)[:, None], len(run.t)))
    # All of it on a circle of radius 0.2 m round a point to the left of the start.
    assert_allclose(np.hypot(run.pose[0], run.pose[1] - 0.2), 0.2)


# --- the paper's two tracked cases ---------------------------------------------------------------

#: A start 10 mm behind or ahead, 10 mm to either side, turned by 10 degrees either way.
CORNERS = np.transpose([*product((-0.01, 0.01), (-0.01, 0.01), np.radians([-10, 10]))])
DISTURBED = {
    "position_noise": 0.001,
    "heading_noise": np.radians(0.5),
    "wheel_base_error": 0.03,
    "lag": 0.03,
    "delay": 0.05,
}


@pytest.fixture(scope="module", params=["15a", "16b"])
def tracked(request, cases, tables):
    """World and smoothed reference of Fig. 17(a) and of Fig. 17(b)."""
    case = cases[request.param]
    world = tables[case.table]
    path = fs.plan(world, case.start, case.goal).path
    return world, fs.make_reference(path, smoothing=SMOOTHING, world=world)


def variation(reference, robot):
    """Total variation of the wheel speeds of a reference (m/s)."""
    return np.abs(np.diff(robot.to_wheels(reference.v, reference.omega))).sum(1).max()


def test_nominal_tracking_of_the_papers_cases(tracked, robot):
    world, reference = tracked
    numbers = fs.metrics.tracking(fs.simulate(fs.SlidingMode(), reference, robot), world)
    assert numbers["position_rms_m"] <= 0.0012
    assert numbers["position_max_m"] <= 0.0005
    assert numbers["wheel_variation_m_s"] <= 1.3 * variation(reference, robot)
    assert numbers["clearance_m"] > robot.radius


@pytest.mark.parametrize(
    "slip",
    [{"slip": 0.05, "slip_fluctuation": 0.02}, {"slip": (0.05, 0.02)}, {"slip": (0.02, 0.05)}],
)
def test_disturbed_tracking_of_the_papers_cases(tracked, robot, slip):
    world, reference = tracked
    for seed in (0, 1, 12):  # 12: the hardest of many
        run = fs.simulate(
            fs.SlidingMode(),
            reference,
            robot,
            initial_offset=np.repeat(CORNERS, 50, axis=1),
            disturbance=fs.Disturbance(**DISTURBED, **slip),
            seed=seed,
        )
        numbers = fs.metrics.tracking(run, world)
        assert numbers["position_rms_m"].max() <= 0.006
        assert numbers["clearance_m"].min() > robot.radius
        # All of it is felt: none of these robots is as good as an undisturbed one.
        assert numbers["position_rms_m"].min() > 0.001


def test_sat_varies_the_wheels_much_less_than_sign(tracked, robot):
    _, reference = tracked
    sat, sign = (
        fs.metrics.tracking(
            fs.simulate(fs.SlidingMode(switching=switching), reference, robot, dt=0.01)
        )["wheel_variation_m_s"]
        for switching in ("sat", "sign")
    )
    assert sign >= 30 * sat


def test_wheels_keep_the_limits_in_ten_thousand_random_runs(cases, tables, robot):
    rng = np.random.default_rng(57)
    names = ("k1", "k2", "phi1", "phi2", "length_scale")
    for number, case in enumerate([*cases.values()] * 5):
        world, dt = tables[case.table], float(rng.choice([0.02, 0.05, 0.1]))
        reference = fs.make_reference(
            fs.plan(world, case.start, case.goal).path,
            robot,
            speed=rng.uniform(0.3, 0.99),
            acceleration=rng.uniform(0.3, 2.7),
            smoothing=float(rng.choice([0, SMOOTHING])),
            world=world,
        )
        gains = dict(zip(names, 10 ** rng.uniform(-2, 1, len(names)), strict=True))
        disturbance = fs.Disturbance(
            position_noise=rng.uniform(0, 0.05),
            heading_noise=rng.uniform(0, 0.5),
            slip=rng.uniform(-0.3, 0.3, 2),
            slip_fluctuation=rng.uniform(0, 0.3),
            wheel_base_error=rng.uniform(-0.2, 0.2),
            wheel_radius_error=rng.uniform(-0.2, 0.2, 2),
            lag=rng.uniform(0, 0.3),
            delay=dt * int(rng.integers(0, 4)),
        )
        run = fs.simulate(
            fs.SlidingMode(**gains, switching=str(rng.choice(sorted(SWITCHING)))),
            reference,
            robot,
            dt,
            rng.normal(0, [[0.3], [0.3], [1.5]], (3, 125)),
            disturbance,
            number,
        )
        assert np.isfinite(run.pose).all()
        assert_within_limits(run, robot, dt)


def test_a_reference_that_is_empty_or_has_one_point():
    for count in (0, 1):
        none = np.zeros(count)
        with pytest.raises(fs.InvalidParameter, match=r"reference (t has shape|has times)"):
            Reference(none, np.zeros((3, count)), none, none, none, none)


# --- one robot and one world ---------------------------------------------------------------------


def test_a_reference_of_a_plan_drives_its_robot_in_its_world(tables):
    small = fs.KheperaIV(diameter=0.1, wheel_base=0.08)
    plan = fs.plan(tables[1], (0, 0), (0.75, 0.75), small)
    reference = fs.make_reference(plan, smoothing=SMOOTHING)
    by_hand = fs.make_reference(plan.path, small, smoothing=SMOOTHING, world=tables[1])
    assert_array_equal(reference.pose, by_hand.pose)
    assert reference.robot == by_hand.robot == small
    assert fs.simulate(fs.SlidingMode(), reference).robot == small
    assert fs.simulate(fs.SlidingMode(), reference, small).robot == small


def test_two_robots_are_refused(tables):
    small = fs.KheperaIV(diameter=0.1, wheel_base=0.08)
    plan = fs.plan(tables[1], (0, 0), (0.75, 0.75), small)
    with pytest.raises(fs.InvalidParameter, match="but the plan is for"):
        fs.make_reference(plan, fs.KheperaIV())
    reference = fs.make_reference(plan)
    with pytest.raises(fs.InvalidParameter, match="but the reference is for"):
        fs.simulate(fs.SlidingMode(), reference, fs.KheperaIV())
    # A path belongs to nobody.
    anybody = fs.make_reference(plan.path)
    assert fs.simulate(fs.SlidingMode(), anybody, small).robot == small


# --- references of one's own ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def round_trip():
    """Arrays of a reference that turns to the left for more than a whole turn."""
    made = fs.make_reference(fs.Path([Arc((0, 0.2), 0.2, -np.pi / 2, 7.0)]))
    return {name: getattr(made, name) for name in ("t", *Sample._fields)}


def test_wrapped_headings_are_unwrapped(round_trip):
    x, y, theta = round_trip["pose"]
    wrapped = np.arctan2(np.sin(theta), np.cos(theta))
    assert np.abs(np.diff(wrapped)).max() > 6
    made = Reference(**round_trip | {"pose": [x, y, wrapped]})
    assert_allclose(made.pose[2], theta, atol=1e-12)


@pytest.mark.parametrize(
    ("signal", "change", "match"),
    [
        ("v", lambda v: 2 * v, "reference v is"),
        ("v", lambda v: -v, "reference v is"),
        ("v", lambda v: 0 * v, "reference v is"),
        ("omega", lambda omega: -omega, "reference omega is"),
        ("omega", lambda omega: 0 * omega, "reference omega is"),
        ("pose", lambda pose: pose + np.transpose([[0, 0, 0.2]]), "sideways speed"),
        ("pose", lambda pose: pose * [[1000], [1000], [1]], "reference v is"),
        ("pose", lambda pose: pose * [[1], [1], [180 / np.pi]], "reference (v|omega) is"),
    ],
)
def test_velocities_that_the_poses_contradict_are_refused_with_the_place(
    round_trip, signal, change, match
):
    with pytest.raises(fs.InvalidParameter, match=match + r".* s, but there its poses make"):
        Reference(**round_trip | {signal: change(round_trip[signal])})


@pytest.mark.parametrize("step", [1, 10, 50, 200])
def test_coarse_references_are_taken(round_trip, step):
    coarse = {name: values[..., ::step] for name, values in round_trip.items()}
    assert len(Reference(**coarse).t) == len(coarse["t"])


@pytest.mark.parametrize("slow", [{"speed": 1e-9}, {"acceleration": 1e-13}, {"speed": 1e-300}])
def test_a_reference_that_would_take_for_ever_is_refused(slow):
    with pytest.raises(fs.InvalidParameter, match="give more speed and acceleration"):
        fs.make_reference(fs.Path([Line((0, 0), (1, 0))]), **slow)


# --- going on after the reference ----------------------------------------------------------------


@pytest.fixture(scope="module")
def short():
    """A reference that ends before a robot from beside it has come near."""
    return fs.make_reference(fs.Path([Line((0, 0), (0.2, 0))]))


def test_a_run_goes_on_until_the_robot_has_arrived(short, robot):
    far = -0.2, 0, 0
    plain = fs.simulate(fs.Pid(), short, robot, initial_offset=far)
    longer = fs.simulate(fs.Pid(), short, robot, initial_offset=far, settle=20, tolerance=0.01)
    steps = len(plain.t)
    assert_array_equal(longer.pose[:, :steps], plain.pose)
    assert steps < len(longer.t) < steps + 400
    late = np.hypot(*longer.error[:2, steps - 1 :])
    assert late[-1] < 0.01
    assert (late[:-1] >= 0.01).all()
    # There at once, or never.
    on_path = fs.simulate(fs.Pid(), short, robot, settle=5)
    assert len(on_path.t) == len(fs.simulate(fs.Pid(), short, robot).t)
    never = fs.simulate(fs.Pid(), short, robot, initial_offset=far, settle=1, tolerance=1e-9)
    assert len(never.t) == steps + 20


def test_a_batch_goes_on_until_the_last_has_arrived(short, robot):
    offsets = np.transpose([(-0.2, 0, 0), (0, 0, 0)])
    batch = fs.simulate(fs.Pid(), short, robot, initial_offset=offsets, settle=5)
    slow = fs.simulate(fs.Pid(), short, robot, initial_offset=offsets[:, 0], settle=5)
    assert_array_equal(batch.t, slow.t)
    assert_array_equal(batch.pose[:, 0], slow.pose)


@pytest.mark.parametrize("wrong", [{"settle": -1}, {"settle": "5"}, {"tolerance": 0}])
def test_settling_that_makes_no_sense(reference, wrong):
    with pytest.raises(fs.InvalidParameter, match=f"{next(iter(wrong))} is"):
        fs.simulate(fs.Pid(), reference, **wrong)


def test_an_arc_shorter_than_a_step_of_the_grid_is_driven():
    for sweep in (1e-5, 3e-4, 1e-3):
        arc = Arc((0.5, 0.0729), 0.0729, -np.pi / 2, sweep)
        x, y, theta = arc.at(arc.length)
        line = Line((x, y), (x + 0.5 * np.cos(theta), y + 0.5 * np.sin(theta)))
        reference = fs.make_reference(fs.Path([Line((0, 0), (0.5, 0)), arc, line]))
        assert reference.pose[2, -1] == pytest.approx(sweep)


def test_what_cannot_end_or_settle_is_refused(short):
    for settle in (1e308, 1e6):
        with pytest.raises(fs.InvalidParameter, match="settle is"):
            fs.simulate(fs.Pid(), short, settle=settle)
    with pytest.raises(fs.InvalidParameter, match="stop is"):
        fs.drive(lambda t, pose: (0, 0), (0, 0, 0), 0.05, 3, stop=True)


def test_the_sliding_mode_returns_from_where_its_docstring_says():
    straight = fs.make_reference(fs.Path([Line((0, 0), (4, 0))]))
    rng = np.random.default_rng(0)
    offsets = rng.uniform([[-0.5], [-0.5], [-np.pi]], [[0.5], [0.5], [np.pi]], (3, 4000))

    def lost(tracker):
        run = fs.simulate(tracker, straight, initial_offset=offsets)
        return np.hypot(*run.error[:2, :, -1]) > 0.05

    away = lost(fs.SlidingMode())
    assert 0.01 < away.mean() < 0.05
    assert np.hypot(*offsets[:2, away]).min() > 0.35
    assert offsets[0, away].min() > 0
    assert not lost(fs.SlidingMode(k2=1)).any()


def test_headings_in_degrees_are_called_so(round_trip):
    x, y, heading = round_trip["pose"]
    for degrees in (np.degrees(heading), np.degrees(heading) % 360):
        with pytest.raises(fs.InvalidParameter, match="headings look like degrees, give radians"):
            Reference(**round_trip | {"pose": [x, y, degrees]})
    with pytest.raises(fs.InvalidParameter, match="give the velocities of these poses"):
        Reference(**round_trip | {"v": 2 * round_trip["v"]})


@pytest.mark.parametrize("t", ["a", None, np.nan, [0, np.nan], 1j])
def test_a_reference_is_asked_for_times(t):
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]))
    with pytest.raises(fs.InvalidParameter, match="t is"):
        reference.at(t)


@pytest.mark.parametrize("dt", [0, -1, 1e-9, None, np.inf])
def test_the_steps_of_a_reference_take_time(dt):
    reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]))
    with pytest.raises(fs.InvalidParameter, match="dt is"):
        reference.steps(dt)
