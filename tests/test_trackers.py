from dataclasses import fields, replace

import control
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.reference import Reference
from freeseg.trackers.feedback import watch
from freeseg.trackers.fuzzy import SETS, memberships

TRACKERS = [
    fs.FeedbackLinearisation,
    fs.Fuzzy,
    fs.Kanayama,
    fs.Lqr,
    fs.Pid,
    fs.PurePursuit,
    fs.SlidingMode,
    fs.Stanley,
    fs.SuperTwisting,
]
every_tracker = pytest.mark.parametrize("tracker", TRACKERS)

DT = 0.05
#: 5 m eastwards, and a left-hand circle; at 0.1 m/s.
LINE = fs.make_reference(fs.Path([Line((0, 0), (5, 0))]))
CIRCLE = fs.make_reference(fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 6.0)]))
#: A line and an arc to the left, faster.
BENDS = fs.make_reference(
    fs.Path([Line((0, 0), (0.2, 0)), Arc((0.2, 0.2), 0.2, -np.pi / 2, 1.2)]), speed=0.3
)
#: Where a robot may start: 2 cm behind, 3 cm to the left and 20 degrees off.
OFFSET = (-0.02, 0.03, np.radians(20))
#: 1 mm, 0.5 degrees, 5 % and 2 % of slip, 3 % of wheel base, 30 ms of lag and a late sample.
ALL = fs.Disturbance(
    position_noise=0.001,
    heading_noise=np.radians(0.5),
    slip=0.05,
    slip_fluctuation=0.02,
    wheel_base_error=0.03,
    lag=0.03,
    delay=DT,
)


def many(n, scale=(0.05, 0.05, 0.4), seed=81):
    """Offsets of n robots."""
    return np.random.default_rng(seed).normal(0, np.reshape(scale, (3, 1)), (3, n))


def pose_with(error, target):
    """The pose whose tracking error (7) is this one."""
    x_e, y_e, alpha_e = error
    x, y, theta = target
    cos, sin = np.cos(theta - alpha_e), np.sin(theta - alpha_e)
    return np.array([x - cos * x_e + sin * y_e, y - sin * x_e - cos * y_e, theta - alpha_e])


def command(tracker, error, reference=LINE, t=10.0, dt=DT):
    """What a tracker commands at an error, by default at 0.1 m/s on a straight line."""
    law = tracker.start(reference, fs.KheperaIV(), dt)
    return np.array(law(t, pose_with(error, reference.at(t).pose)))


@pytest.fixture(scope="module", params=["15a", "16b"])
def planned(request, cases, tables):
    """References on the planned paths of Figs 15(a) and 16(b)."""
    case = cases[request.param]
    return fs.make_reference(fs.plan(tables[case.table], case.start, case.goal).path)


# --- all alike -----------------------------------------------------------------------------------


@every_tracker
@pytest.mark.parametrize("reference", [LINE, CIRCLE], ids=["line", "circle"])
def test_on_the_reference_the_velocities_are_those_of_the_middle_of_the_hold(tracker, reference):
    # Not to the end, before which pure pursuit sees its goal go on straight.
    for t in np.linspace(0, 0.95 * reference.duration, 40):
        middle = reference.at(t + DT / 2)
        v, omega = command(tracker(), (0, 0, 0), reference, t)
        assert_allclose((v, omega), (middle.v, middle.omega), rtol=0, atol=1e-6)


@every_tracker
def test_each_error_is_countered(tracker):
    # A reference ahead: faster. To the left, or turned to the left: turn left.
    assert command(tracker(), (0.01, 0, 0))[0] > 0.1 > command(tracker(), (-0.01, 0, 0))[0]
    assert command(tracker(), (0, 0.01, 0))[1] > 1e-3
    assert command(tracker(), (0, 0, 0.1))[1] > 1e-3


@every_tracker
def test_a_batch_is_bit_for_bit_its_single_runs(tracker, robot):
    offsets = many(50)
    batch = fs.simulate(tracker(), BENDS, robot, DT, offsets, ALL, seed=9)
    for number, offset in enumerate(offsets.T):
        single = fs.simulate(tracker(), BENDS, robot, DT, offset, ALL, seed=(9, number))
        for name in ("pose", "error", "wheels", "measured"):
            assert_array_equal(getattr(batch, name)[:, number], getattr(single, name))


@every_tracker
def test_the_law_for_a_batch_is_bit_for_bit_that_for_one(tracker, robot):
    # Far more poses, for what differs may do so in one of a thousand.
    poses = BENDS.at(0.4).pose[:, None] + many(2000, (0.3, 0.3, 2))
    batch = np.array(tracker().start(BENDS, robot, DT)(0.4, poses))
    single = [tracker().start(BENDS, robot, DT)(0.4, pose) for pose in poses.T]
    assert_array_equal(batch, np.transpose(single))


@every_tracker
def test_a_run_does_not_see_another(tracker, robot):
    shared = tracker()
    first, second = (
        fs.simulate(shared, BENDS, robot, DT, offset) for offset in ((0.05, -0.1, 1), OFFSET)
    )
    alone = fs.simulate(tracker(), BENDS, robot, DT, OFFSET)
    assert_array_equal(second.wheels, alone.wheels)
    assert (first.wheels != second.wheels).any()
    # Nor one that goes on at the same time.
    law, other = (shared.start(BENDS, robot, DT) for _ in range(2))
    for t, pose in zip(alone.t[:-1], alone.pose.T, strict=False):
        other(t, pose + 0.1)
        again = np.array(law(t, pose))
    fresh = shared.start(BENDS, robot, DT)
    for t, pose in zip(alone.t[:-1], alone.pose.T, strict=False):
        once = np.array(fresh(t, pose))
    assert_array_equal(again, once)


@every_tracker
def test_wheels_keep_the_limits_under_disturbance_whatever_the_gains(tracker, robot):
    rng = np.random.default_rng(82)
    default = tracker()
    for number in range(6):
        gains = {
            gain.name: getattr(default, gain.name) * 10 ** rng.uniform(-1, 1)
            for gain in fields(default)
            if gain.type is float and gain.name != "approach"  # an angle below 90 degrees
        }
        scale = (0.3, 0.3, 1.5)
        run = fs.simulate(
            replace(default, **gains), BENDS, robot, DT, many(50, scale, number), ALL, number
        )
        assert np.isfinite(run.pose).all()
        changes = np.diff(run.wheels, axis=-1, prepend=0.0)
        assert np.abs(run.wheels).max() <= robot.max_wheel_speed + 1e-12
        assert np.abs(changes).max() <= robot.max_wheel_acceleration * DT + 1e-12


@every_tracker
def test_from_beside_the_planned_paths_the_errors_vanish(tracker, planned, robot):
    run = fs.simulate(tracker(), planned, robot, DT, OFFSET)
    assert_allclose(run.error[:, 0], fs.tracking_error((0, 0, 0), OFFSET), atol=1e-12)
    numbers = fs.metrics.tracking(run)
    assert numbers["settling_time_s"] < 4
    # What an integral has summed up at the start goes slowly.
    assert numbers["position_final_m"] < (0.003 if tracker is fs.Pid else 0.002)
    assert numbers["heading_final_rad"] < np.radians(1)


@every_tracker
def test_from_any_heading_the_errors_vanish(tracker, robot):
    offsets = np.random.default_rng(83).uniform(-1, 1, (3, 100)) * [[0.05], [0.05], [np.pi]]
    run = fs.simulate(tracker(), LINE, robot, DT, offsets)
    position = np.hypot(*run.error[:2])
    assert position.max() < 0.3
    assert position[:, -1].max() < 1e-6
    assert np.abs(run.error[2, :, -1]).max() < 1e-6


@every_tracker
def test_on_the_planned_paths_the_robot_stays(tracker, planned, robot):
    numbers = fs.metrics.tracking(fs.simulate(tracker(), planned, robot, DT))
    # Pure pursuit cuts the corners between lines and arcs.
    bound = 0.005 if tracker is fs.PurePursuit else 0.002
    assert numbers["position_max_m"] < bound


@every_tracker
def test_noise_and_slip_leave_the_error_small(tracker, planned, robot):
    run = fs.simulate(tracker(), planned, robot, DT, many(20, (0.01, 0.01, 0.2)), ALL)
    late = np.hypot(*run.error[:2])[:, run.t > 5]
    assert np.sqrt((late**2).mean()) < 0.01
    assert late.max() < 0.03


def with_rests(reference, rest):
    """The same reference with a rest (s) at either end."""
    end = rest + reference.duration
    # A microsecond apart, so that rates are zero all through the rests.
    t = np.concatenate([[0, rest - 1e-6], rest + reference.t, [end + 1e-6, end + rest]])
    rates = (reference.v, reference.omega, reference.v_dot, reference.omega_dot)
    pose = np.pad(reference.pose, ((0, 0), (2, 2)), "edge")
    return Reference(t, pose, *(np.pad(rate, 2) for rate in rates))


@every_tracker
def test_nothing_diverges_at_rest(tracker, robot):
    run = fs.simulate(tracker(), with_rests(CIRCLE, 30), robot, DT, many(30))
    position, heading = np.hypot(*run.error[:2]), np.abs(run.error[2])
    # While it rests at the start, no further off than by the point that some laws drive.
    assert (position[:, run.t < 30].max(1) < position[:, 0] + 0.07).all()
    # At the end, all stand still, and near the goal.
    assert np.abs(run.wheels[..., -200:]).max() < 1e-4
    assert position[:, -1].max() < 0.002
    assert heading[:, -1].max() < np.radians(3)


@every_tracker
def test_left_and_right_are_alike(tracker, robot):
    mirror = np.array([[1], [-1], [-1]])
    mirrored = replace(
        BENDS, pose=mirror * BENDS.pose, omega=-BENDS.omega, omega_dot=-BENDS.omega_dot
    )
    offsets = many(20)
    run = fs.simulate(tracker(), BENDS, robot, DT, offsets)
    other = fs.simulate(tracker(), mirrored, robot, DT, mirror * offsets)
    assert_allclose(other.pose, mirror[..., None] * run.pose, rtol=0, atol=1e-9)
    assert_allclose(other.wheels, run.wheels[::-1], rtol=0, atol=1e-9)


@every_tracker
def test_the_law_does_not_depend_on_the_frame(tracker, robot):
    turn, shift = 2.1, np.array([[3.0], [-2.0], [2.1]])
    cos, sin = np.cos(turn), np.sin(turn)
    matrix = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    moved = replace(BENDS, pose=matrix @ BENDS.pose + shift)
    offsets = many(20)
    run = fs.simulate(tracker(), BENDS, robot, DT, offsets)
    other = fs.simulate(tracker(), moved, robot, DT, offsets)
    assert_allclose(other.wheels, run.wheels, rtol=0, atol=1e-7)


#: Gains that may be zero, for then their term is off.
SWITCHES = {
    "FeedbackLinearisation": ("k1", "k2"),
    "Fuzzy": ("v_range", "omega_range"),
    "Kanayama": ("k_x", "k_y", "k_alpha"),
    "Lqr": ("q_x", "q_y"),
    "Pid": ("kp_x", "ki_x", "kp_y", "ki_y"),
    "PurePursuit": ("k_x",),
    "SlidingMode": ("k1", "k2"),
    "Stanley": ("k", "k_x"),
    "SuperTwisting": ("lambda1", "lambda2", "w1", "w2"),
}


@pytest.mark.parametrize(
    ("tracker", "name"),
    [
        pytest.param(tracker, gain.name, id=f"{tracker.__name__}-{gain.name}")
        for tracker in TRACKERS
        for gain in fields(tracker)
        if gain.type is float
    ],
)
def test_invalid_gain(tracker, name):
    assert getattr(tracker(**{name: np.float32(0.5)}), name) == 0.5
    if name in (*SWITCHES[tracker.__name__], "preview"):
        assert getattr(tracker(**{name: 0}), name) == 0
        remedy, wrong = "finite number, zero or more", ()
    else:
        remedy, wrong = "positive finite", (0,)
    for value in (*wrong, -1, np.nan, np.inf, None, "0.1", True, (1, 2), 1 + 1j):
        with pytest.raises(fs.InvalidParameter, match=f"^{name} is .*{remedy}"):
            tracker(**{name: value})


@pytest.mark.parametrize("tracker", [fs.Lqr, fs.SuperTwisting])
@pytest.mark.parametrize("dt", [0, -0.05, np.nan, None])
def test_a_law_in_discrete_time_needs_a_time_step(tracker, dt, robot):
    with pytest.raises(fs.InvalidParameter, match="dt is "):
        tracker().start(LINE, robot, dt)


# --- each by hand --------------------------------------------------------------------------------


def test_kanayama_by_hand():
    # v = 0.1 cos 0.3 + 2 * 0.01 and w = 0.1 (100 * 0.02 + 20 sin 0.3).
    v, omega = command(fs.Kanayama(k_x=2, k_y=100, k_alpha=20), (0.01, 0.02, 0.3))
    assert v == pytest.approx(0.1 * np.cos(0.3) + 0.02)
    assert omega == pytest.approx(0.2 + 2 * np.sin(0.3))


@pytest.mark.parametrize("dt", [0.01, 0.05, 0.5])
@pytest.mark.parametrize("v_r", [0.001, 0.1, 0.8])
@pytest.mark.parametrize("weights", [(4, 100, 2), (0.1, 1e4, 0.01), (30, 1, 50)])
def test_lqr_gains_solve_the_riccati_equation(weights, v_r, dt):
    # Commands held for dt, with w_r = 0: exact, for the powers of dt end with the second.
    a = np.array([[1, 0, 0], [0, 1, v_r * dt], [0, 0, 1]])
    b = -np.array([[dt, 0], [0, v_r * dt * dt / 2], [0, dt]])
    oracle, _, eigenvalues = control.dlqr(a, b, np.diag(weights), np.eye(2))
    assert np.abs(eigenvalues).max() < 1
    k_x, k_y, k_alpha = fs.Lqr(*weights).gains(v_r, dt)
    assert_allclose([[k_x, 0, 0], [0, k_y, k_alpha]], -oracle, rtol=1e-6, atol=1e-9)


def test_lqr_gains_in_continuous_time_by_hand():
    # k_alpha^2 = 3 + 2 * 0.2 * 10.
    k_x, k_y, k_alpha = fs.Lqr(q_x=4, q_y=100, q_alpha=3).gains(0.2, 1e-6)
    assert_allclose((k_x, k_y, k_alpha), (2, 10, np.sqrt(7)), rtol=1e-5)


def test_lqr_gains_have_a_limit_at_rest():
    k_x, k_y, k_alpha = fs.Lqr().gains([0, 1e-7, 1e-5, 1e-3], DT)
    assert np.isfinite(k_x)
    assert_allclose(k_y, k_y[0], rtol=2e-3)
    assert_allclose(k_alpha, k_alpha[0], rtol=6e-3)
    # There k_alpha is the gain of a single integrator: q = k^2 / (1 - k dt) for a held command.
    assert k_alpha[0] ** 2 / (1 - k_alpha[0] * DT) == pytest.approx(fs.Lqr().q_alpha)


@pytest.mark.parametrize("t", [0.13, 0.401, 10])
def test_lqr_commands_with_the_gains_of_the_present_speed(t):
    tracker, error = fs.Lqr(), np.array([0.01, -0.02, 0.3])
    v_r = LINE.at(t + DT / 2).v
    k_x, k_y, k_alpha = tracker.gains(v_r, DT)
    v, omega = command(tracker, error, t=t)
    assert v == pytest.approx(v_r * np.cos(0.3) + k_x * 0.01, rel=1e-9)
    # Gains are interpolated between speeds.
    assert omega == pytest.approx(k_y * -0.02 + k_alpha * 0.3, rel=1e-4)


def test_feedback_linearisation_makes_two_integrators_of_the_point_ahead(robot):
    # The error of B, as the robot sees it, falls with k1 along its axis and k2 across it.
    tracker = fs.FeedbackLinearisation(k1=2, k2=3, ahead=0.05)
    law = tracker.start(CIRCLE, robot, 0.0)

    def point(pose):
        return pose[:2] + 0.05 * np.array([np.cos(pose[2]), np.sin(pose[2])])

    h = 1e-3
    for t, offset in zip(np.arange(1, 16, 0.5), many(30, (0.1, 0.1, 1)).T, strict=True):
        pose = CIRCLE.at(t).pose + offset
        v, omega = law(t, pose)
        rate = np.array([v * np.cos(pose[2]), v * np.sin(pose[2]), omega])
        before, here, after = (
            point(CIRCLE.at(t + step).pose) - point(pose + step * rate) for step in (-h, 0, h)
        )
        axes = np.array([[np.cos(pose[2]), np.sin(pose[2])], [-np.sin(pose[2]), np.cos(pose[2])]])
        assert_allclose(axes @ (after - before) / (2 * h), -(axes @ here) * (2, 3), atol=1e-4)


def test_feedback_linearisation_by_hand():
    # At rest, B 0.05 m ahead of a robot turned by 90 degrees to the right of the reference is at
    # (-0.05, 0.05) from where it should be: backwards, and to the left.
    v, omega = command(fs.FeedbackLinearisation(2, 3, 0.05), (0, 0, np.pi / 2), t=LINE.duration)
    assert_allclose((v, omega), (-2 * 0.05, 3 * 0.05 / 0.05))


def test_pure_pursuit_by_hand():
    # The goal is 0.12 m ahead and 0.05 m to the left, 0.13 m away: a curvature of 2 y / d^2.
    tracker = fs.PurePursuit(lookahead=0.11, k_x=2)
    v, omega = command(tracker, (0.01, 0.05, 0))
    assert v == pytest.approx(0.12)
    assert omega == pytest.approx(0.12 * 2 * 0.05 / 0.13**2)


def test_pure_pursuit_drives_the_arc_through_its_goal(robot):
    tracker = fs.PurePursuit(lookahead=0.15)
    for error in many(20, (0.01, 0.03, 0.4)).T:
        v, omega = command(tracker, error)
        start = pose_with(error, LINE.at(10.0).pose)
        goal = LINE.at(10.0).pose[:2] + np.array([0.15, 0])
        way = np.linspace(0, 0.4, 4001)
        arc = robot.move(start[:, None], np.tile(robot.to_wheels(1, omega / v)[:, None], 4001), way)
        assert np.hypot(*(arc[:2] - goal[:, None])).min() < 1e-4


def test_pure_pursuit_goes_on_straight_beyond_the_end_and_does_not_turn_backwards():
    tracker = fs.PurePursuit(lookahead=0.1, k_x=2)
    v, omega = command(tracker, (0.02, 0.05, 0), t=LINE.duration)
    assert_allclose((v, omega), (0.04, 0.04 * 2 * 0.05 / (0.12**2 + 0.05**2)))
    v, omega = command(tracker, (-0.2, 0.05, 0))
    assert_allclose((v, omega), (-0.3, 0), atol=1e-12)


def test_pure_pursuit_turns_round_to_a_goal_behind():
    # Turned by 180 degrees and 0.05 m ahead: the goal is 0.05 m behind, and 0.01 m to the right.
    v, omega = command(fs.PurePursuit(lookahead=0.1, k_x=1), (0.05, -0.01, np.pi))
    assert v == pytest.approx(0.1 - 0.05)
    assert omega == pytest.approx(-0.05 * 2 / np.hypot(0.05, 0.01))


def test_pure_pursuit_has_a_bounded_curvature():
    # The goal is 0.01 m to the left, but no less than half the lookahead is reckoned with.
    v, omega = command(fs.PurePursuit(lookahead=0.1, k_x=0.1), (-0.1, 0.01, 0))
    assert v == pytest.approx(0.09)
    assert omega == pytest.approx(0.09 * 2 * 0.01 / 0.05**2)


def test_stanley_by_hand():
    # The wheel is 0.03 m to the right of the path: arctan(4 * 0.03 / (0.02 + 0.1)) is 45 degrees.
    tracker = fs.Stanley(k=4, k_x=2, softening=0.02, ahead=0.05)
    v, omega = command(tracker, (0, 0.03, 0))
    assert_allclose((v, omega), (0.1 * np.sqrt(0.5), 0.1 * np.sqrt(0.5) / 0.05))
    # Backwards, it keeps its heading.
    v, omega = command(tracker, (-0.2, 0.03, 0))
    assert_allclose((v, omega), (-0.3, 0), atol=1e-12)


@pytest.mark.parametrize("tracker", [fs.PurePursuit, fs.Stanley])
def test_too_far_ahead_the_robot_comes_back_whatever_its_heading(tracker):
    for alpha in np.linspace(-3, 3, 30):
        # The reference is 0.3 m behind, along the path.
        v, omega = command(tracker(), (-0.3 * np.cos(alpha), -0.3 * np.sin(alpha), alpha))
        assert v * np.cos(alpha) < 0
        assert omega == 0


def test_stanley_steers_the_wheel_along_the_path_and_towards_it(robot):
    # On a circle of radius 0.3 m, a wheel 0.4 m ahead of the axle runs on one of 0.5 m.
    tracker = fs.Stanley(k=2, softening=0.02, ahead=0.4)
    t, aside = 10.0, 0.01
    target = CIRCLE.at(t).pose
    outwards = np.array(
        [np.cos(target[2] + np.arctan(4 / 3)), np.sin(target[2] + np.arctan(4 / 3))]
    )
    across = np.array([-outwards[1], outwards[0]])
    law = tracker.start(CIRCLE, robot, 0.0)
    v, omega = law(t, target - [*(aside * across), 0])
    wheel = v * np.array([np.cos(target[2]), np.sin(target[2])])
    wheel += 0.4 * omega * np.array([-np.sin(target[2]), np.cos(target[2])])
    speed = 0.1 * 0.5 / 0.3
    towards = np.arctan(2 * aside / (0.02 + speed))
    assert_allclose(
        wheel @ np.array([outwards, across]).T,
        speed * np.array([np.cos(towards), np.sin(towards)]),
        rtol=1e-5,
    )


def test_super_twisting_by_hand():
    # s' = 0.04 after the step: s = 0.04 + 0.05 (0.3 sqrt(0.04) + 0.05 * 0.02) = 0.04305.
    tracker = fs.SuperTwisting(lambda1=0.3, w1=0.02)
    assert command(tracker, (0.04305, 0, 0))[0] == pytest.approx(0.1 + 0.06 + 0.001 + 0.001)
    # So near that one step reaches the surface: s / dt, and as much for the integral.
    assert command(tracker, (4e-5, 0, 0))[0] == pytest.approx(0.1 + 2 * 4e-5 / 0.05)
    # The integral stands in the next step.
    tireless = fs.KheperaIV(max_wheel_rate_change=1e9)
    law = tracker.start(LINE, tireless, DT)
    law(10.0, pose_with((0.04305, 0, 0), LINE.at(10.0).pose))
    v, _ = law(10.05, pose_with((0.04305, 0, 0), LINE.at(10.05).pose))
    assert v == pytest.approx(0.1 + 0.06 + 0.001 + 0.002)


def test_super_twisting_learns_a_constant_disturbance(robot):
    # Wheels that are 10 % too small leave the sliding mode behind: 0.9 (v + k1 x_e / phi1) = v.
    small = fs.Disturbance(wheel_radius_error=-0.1)
    late = {}
    for tracker in (fs.SlidingMode, fs.SuperTwisting):
        run = fs.simulate(tracker(), LINE, robot, DT, disturbance=small)
        late[tracker] = np.abs(run.error[0, (run.t > 30) & (run.t < 50)]).max()
    behind = (1 / 0.9 - 1) * 0.1 * fs.SlidingMode().phi1 / fs.SlidingMode().k1
    assert late[fs.SlidingMode] == pytest.approx(behind, rel=1e-6)
    assert late[fs.SuperTwisting] < 1e-6


def test_super_twisting_does_not_chatter(robot):
    run = fs.simulate(fs.SuperTwisting(), LINE, robot, DT, OFFSET)
    cruise = run.wheels[:, (run.t > 30) & (run.t < 50)]
    assert np.abs(np.diff(cruise)).max() < 1e-9
    assert_allclose(cruise, 0.1, atol=1e-9)


def test_fuzzy_sets_add_up_to_one():
    values = np.linspace(-3, 3, 601)
    belongs = memberships(values)
    assert belongs.shape == (5, 601)
    assert belongs.min() == 0
    assert_allclose(belongs.sum(0), 1)
    assert_array_equal(memberships(SETS), np.eye(5))


def test_fuzzy_rules_by_hand():
    tracker = fs.Fuzzy(x_range=0.1, y_range=0.2, alpha_range=1, v_range=0.2, omega_range=2)
    # x_e is positive small, y_e positive big and alpha_e negative small: turn left, small.
    v, omega = command(tracker, (0.05, 0.2, -0.5))
    assert_allclose((v, omega), (0.1 * np.cos(0.5) + 0.5 * 0.2, 0.5 * 2))
    # Half way between four rules, with zero, small twice, and big: their mean.
    _, omega = command(tracker, (0, 0.05, 0.25))
    assert omega == pytest.approx(2 * (0 + 0.5 + 0.5 + 1) / 4)
    # Beyond its range an error is as big as at its end.
    assert_allclose(command(tracker, (0, 5, 0)), command(tracker, (0, 0.2, 0)))


def test_fuzzy_output_is_odd_and_monotone(robot):
    y, alpha = np.meshgrid(np.linspace(-0.3, 0.3, 61), np.linspace(-1.5, 1.5, 61), indexing="ij")
    error = np.stack([0.1 * y, y, alpha]).reshape(3, -1)
    v, omega = command(fs.Fuzzy(), error).reshape(2, 61, 61)
    assert_allclose(omega, -omega[::-1, ::-1], atol=1e-12)
    assert (np.diff(omega, axis=0) >= -1e-12).all()
    assert (np.diff(omega, axis=1) >= -1e-12).all()
    speed = v - 0.1 * np.cos(alpha)
    assert_allclose(speed, -speed[::-1], atol=1e-12)
    assert (np.diff(speed, axis=0) > 0).all()
    assert np.ptp(omega) == pytest.approx(2 * fs.Fuzzy().omega_range)


@pytest.mark.parametrize(
    "tracker", [fs.SlidingMode(), fs.SuperTwisting()], ids=lambda t: type(t).__name__
)
def test_a_sliding_mode_needs_a_reference_that_moves(tracker):
    zero = np.zeros(3)
    still = Reference(np.arange(3.0), np.zeros((3, 3)), zero, zero, zero, zero)
    with pytest.raises(fs.InvalidParameter, match="give a reference that moves"):
        fs.simulate(tracker, still)


@pytest.mark.parametrize("kind", SWITCHES)
def test_a_gain_of_zero_switches_its_term_off(kind, reference_15a, robot):
    tracker = getattr(fs, kind)
    for gain in SWITCHES[kind]:
        off, slight = (tracker(**{gain: value}) for value in (0, 1e-9))
        runs = [
            fs.simulate(one, reference_15a, robot, DT, (0, 0.005, 0.05)) for one in (off, slight)
        ]
        assert np.isfinite(runs[0].pose).all()
        assert_allclose(runs[0].pose, runs[1].pose, atol=1e-4)
    off = tracker(**dict.fromkeys(SWITCHES[kind], 0))
    assert np.isfinite(fs.simulate(off, reference_15a, robot, DT).pose).all()


# --- preview -------------------------------------------------------------------------------------


@every_tracker
def test_at_constant_velocities_a_preview_changes_nothing(tracker):
    for reference in (LINE, CIRCLE):
        for error in many(5, (0.02, 0.02, 0.3)).T:
            plain = command(tracker(), error, reference)
            assert_allclose(command(tracker(preview=0.2), error, reference), plain, atol=1e-9)


@pytest.mark.parametrize("preview", [1e-300, 0.01, 0.1, 0.37])
@pytest.mark.parametrize("t", [0.0, 0.4, 0.8, 1.234])
def test_previewed_velocities_are_means_about_the_middle_of_the_hold(preview, t):
    look = watch(BENDS, DT, preview)
    _, wanted = look(t, BENDS.at(t).pose)
    # Over less than the reference's own millisecond, it makes no difference.
    half = max(preview, 1e-3) / 2
    middle = t + DT / 2
    about = BENDS.at(np.linspace(middle - half, middle + half, 200_001))
    assert_allclose(wanted.v, about.v.mean(), atol=1e-5)
    assert_allclose(wanted.omega, about.omega.mean(), atol=2e-3)
    for rate, value in (("v_dot", BENDS.v), ("omega_dot", BENDS.omega)):
        ends = np.interp([middle - half, middle + half], BENDS.t, value)
        assert_allclose(getattr(wanted, rate), np.diff(ends)[0] / half / 2, atol=1e-9)
    assert_array_equal(wanted.pose, BENDS.at(middle).pose)


@pytest.mark.parametrize("kind", [fs.Fuzzy, fs.Kanayama, fs.Lqr, fs.Pid, fs.SlidingMode])
def test_where_the_turn_rate_jumps_and_wheels_saturate_a_preview_pays(kind, robot):
    # At 0.5 m/s, the wheels need two steps for what the reference turns at once.
    plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    fast = fs.make_reference(plan, speed=0.5, acceleration=0.5)
    plain, previewed = (
        fs.metrics.tracking(fs.simulate(tracker, fast, robot, DT))["position_rms_m"]
        for tracker in (kind(), kind(preview=0.1))
    )
    assert previewed < 0.0015 < plain / 3


@every_tracker
def test_a_preview_serves_a_batch_as_it_does_one(tracker, robot):
    offsets = many(10)
    batch = fs.simulate(tracker(preview=0.1), BENDS, robot, DT, offsets, ALL, seed=9)
    for number, offset in enumerate(offsets.T):
        single = fs.simulate(tracker(preview=0.1), BENDS, robot, DT, offset, ALL, seed=(9, number))
        assert_array_equal(batch.pose[:, number], single.pose)


# --- references that reverse, or turn on the spot ------------------------------------------------


@pytest.fixture(scope="module")
def reference_15a():
    plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    return fs.make_reference(plan, smoothing=0.03)


@pytest.fixture(scope="module")
def reversing(reference_15a):
    """Case 15(a), driven backwards: the robot looks the other way all the time."""
    made = reference_15a
    pose = made.pose + np.transpose([[0, 0, np.pi]])
    return Reference(made.t, pose, -made.v, made.omega, -made.v_dot, made.omega_dot)


@pytest.fixture(scope="module")
def turning():
    """A straight line, half a turn on the spot in 4 s, and back along the line."""
    line = fs.make_reference(fs.Path([Line((0, 0), (0.5, 0))]))
    t = np.linspace(0, 4, 401)
    shape = 2 * np.pi * t / 4
    theta, omega = (shape - np.sin(shape)) / 2, np.pi / 4 * (1 - np.cos(shape))
    omega_dot = np.pi**2 / 8 * np.sin(shape)
    still = 0 * t
    spot = [np.stack([still + 0.5, still, theta]), still, omega, still, omega_dot]
    x, y, heading = line.pose
    back = [np.stack([0.5 - x, y, heading + np.pi]), line.v, line.omega, line.v_dot, line.omega_dot]
    there = [line.pose, line.v, line.omega, line.v_dot, line.omega_dot]
    times = [line.t, line.t[-1] + 1e-3 + t, line.t[-1] + 4.002 + line.t]
    joined = [np.concatenate(parts, axis=-1) for parts in zip(there, spot, back, strict=True)]
    return Reference(np.concatenate(times), *joined)


@pytest.mark.parametrize("tracker", [*TRACKERS, fs.Mpc], ids=lambda tracker: tracker.__name__)
def test_a_law_reverses_or_says_that_it_cannot(tracker, reversing, robot):
    if tracker in (fs.PurePursuit, fs.Stanley):
        with pytest.raises(fs.InvalidParameter, match=r"reverses at 0\.\d+ s.*cannot follow"):
            tracker().start(reversing, robot, DT)
        return
    for offset in (0.01, -0.01):
        run = fs.simulate(tracker(), reversing, robot, DT, (0, offset, np.radians(3)))
        assert np.hypot(*run.error[:2, -1]) < 0.002
        assert np.hypot(*run.error[:2]).max() < 0.03


@pytest.mark.parametrize("tracker", [*TRACKERS, fs.Mpc], ids=lambda tracker: tracker.__name__)
def test_a_law_turns_on_the_spot_or_says_that_it_cannot(tracker, turning, robot):
    if tracker is fs.PurePursuit:
        with pytest.raises(fs.InvalidParameter, match="turns on the spot at"):
            tracker().start(turning, robot, DT)
        return
    run = fs.simulate(tracker(), turning, robot, DT, (0, 0.005, np.radians(3)))
    assert np.hypot(*run.error[:2, -1]) < 0.005
    assert np.hypot(*run.error[:2]).max() < 0.03


def test_the_super_twisting_integrals_stand_still_at_a_limit(robot):
    # 0.3 m behind, the wheels are at their limit for a second; the integral would grow all along.
    slow = fs.KheperaIV(max_wheel_rate=6)
    law, free = (fs.SuperTwisting(w1=0.5).start(LINE, one, DT) for one in (slow, robot))
    for step in range(40):
        pose = pose_with((0.3, 0, 0), LINE.at(step * DT).pose)
        limited, unlimited = law(step * DT, pose)[0], free(step * DT, pose)[0]
    assert unlimited - limited > 0.5
    # Once in front, the one goes back at once and the other still pushes on.
    ahead = pose_with((-0.01, 0, 0), LINE.at(2.0).pose)
    assert law(2.0, ahead)[0] < 0.1 < free(2.0, ahead)[0]
