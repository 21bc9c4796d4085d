import control as ct
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.reference import Reference

#: Where a robot may start: 2 cm behind, 3 cm to the left and 20 degrees off.
OFFSET = (-0.02, 0.03, np.radians(20))
STRAIGHT = fs.Path([Line((0, 0), (2, 0))])
BEND = fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 2.5)])
DT = 0.05
#: What the default gains are designed for: speed (m/s), lag and delay (s).
SPEED, LAG, DELAY = 0.1, 0.03, 0.05


@pytest.fixture(scope="module")
def references(cases, tables):
    """References of Figs 15(a) and 16(b)."""
    plans = {n: fs.plan(tables[1], cases[n].start, cases[n].goal) for n in ("15a", "16b")}
    return {name: fs.make_reference(plan.path) for name, plan in plans.items()}


# --- the law -------------------------------------------------------------------------------------


def test_without_error_the_law_commands_the_velocities_of_the_reference(references, robot):
    for reference in references.values():
        law = fs.Pid().start(reference, robot, 0.0)
        for t in np.linspace(0, reference.duration, 50):
            target = reference.at(t)
            assert law(t, target.pose) == (target.v, target.omega)


def test_a_held_command_takes_the_velocities_at_the_middle_of_the_hold(robot):
    reference = fs.make_reference(BEND)
    for t in (0.1, 0.25, 3.0):
        v, omega = fs.Pid().start(reference, robot, DT)(t, reference.at(t).pose)
        middle = reference.at(t + DT / 2)
        assert (v, omega) == (middle.v, middle.omega)
    assert v == pytest.approx(0.1)
    assert omega == pytest.approx(0.1 / 0.3)


def test_the_command_by_hand():
    pid = fs.Pid(kp_x=2, ki_x=0.5, kp_y=100, ki_y=300, kd_y=20, approach=np.radians(30))
    error, integrals = (0.01, 0.02, np.pi / 6), (0.004, 0.001)
    v, omega, cut = pid.command(error, integrals, 0.1, 0.3)
    assert v == pytest.approx(0.1 * np.sqrt(3) / 2 + 2 * 0.01 + 0.5 * 0.004)
    # P + I = 2.0 + 0.3 is below 20 sin 30 degrees = 10: nothing is cut off.
    assert omega == pytest.approx(0.3 + 0.1 * (2.3 + 20 * 0.5))
    assert cut == 0
    # 200 mm beside: P + I = 20.3, of which 10 are used.
    _, omega, cut = pid.command((0, 0.2, 0), integrals, 0.1, 0)
    assert omega == pytest.approx(0.1 * 10)
    assert cut == pytest.approx(0.1 * 10.3)
    assert pid.command((0, -0.2, 0), (0, 0), 0.1, 0)[1:] == pytest.approx((-1, -1))


def test_without_integrals_the_law_is_kanayamas(robot):
    # The first command of a run; from near by, so that the approach does not bound it.
    reference, kanayama = fs.make_reference(BEND), fs.Kanayama(3, 340, 29)
    poses = reference.at(2).pose[:, None] + np.random.default_rng(105).normal(0, 0.02, (3, 500))
    assert_allclose(
        fs.Pid().start(reference, robot, DT)(2, poses),
        kanayama.start(reference, robot, DT)(2, poses),
        rtol=1e-12,
    )


def test_the_integrals_are_sums_over_time_and_over_the_way(robot):
    # The pose keeps 1 mm behind and 2 mm to the left of a reference that cruises.
    reference = fs.make_reference(STRAIGHT)
    pid, law = fs.Pid(), fs.Pid().start(reference, robot, DT)
    for step, t in enumerate(1 + DT * np.arange(20)):
        pose = reference.at(t).pose + np.array([-0.001, 0.002, 0])
        sums = step * DT * 0.001, step * DT * 0.1 * -0.002
        v, omega, _ = pid.command((0.001, -0.002, 0), sums, 0.1, 0)
        assert_allclose(law(t, pose), (v, omega), rtol=1e-9)


def test_the_law_for_a_batch_is_bit_for_bit_that_for_one(references, robot):
    # Thousands of poses, for what differs may do so in one of a thousand; twice, for the sums.
    reference = references["15a"]
    poses = np.random.default_rng(102).normal(0, [[0.3], [0.3], [2]], (3, 2000))
    poses += reference.at(0.4).pose[:, None]
    law = fs.Pid().start(reference, robot, DT)
    law(0.4, poses)
    batch = np.array(law(0.45, poses))
    singles = []
    for pose in poses.T:
        law = fs.Pid().start(reference, robot, DT)
        law(0.4, pose)
        singles.append(law(0.45, pose))
    assert_array_equal(batch, np.transpose(singles))


def test_a_reference_that_reverses_is_followed_as_one_that_does_not(robot):
    # With x, heading and both speeds of the other sign, the model (1) stays the same.
    forth = fs.make_reference(STRAIGHT)
    mirror = np.array([[-1], [1], [-1]])
    back = Reference(
        forth.t, mirror * forth.pose, -forth.v, -forth.omega, -forth.v_dot, -forth.omega_dot
    )
    # Some of them far enough for the limits to act.
    offsets = np.random.default_rng(104).normal(0, [[0.1], [0.2], [0.5]], (3, 50))
    forwards, backwards = (
        fs.simulate(fs.Pid(), reference, robot, initial_offset=offset)
        for reference, offset in ((forth, offsets), (back, mirror * offsets))
    )
    assert_allclose(backwards.pose, mirror[..., None] * forwards.pose, rtol=0, atol=1e-12)


# --- what it reaches -----------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["15a", "16b"])
def test_from_on_the_path_the_robot_stays_on_it(references, robot, case):
    run = fs.simulate(fs.Pid(), references[case], robot)
    numbers = fs.metrics.tracking(run)
    assert numbers["position_rms_m"] < 0.0005
    assert numbers["position_max_m"] < 0.001
    assert numbers["position_final_m"] < 0.0002


@pytest.mark.parametrize("case", ["15a", "16b"])
def test_from_beside_the_path_the_errors_vanish(references, robot, case):
    numbers = fs.metrics.tracking(
        fs.simulate(fs.Pid(), references[case], robot, initial_offset=OFFSET)
    )
    assert numbers["settling_time_s"] < 2
    assert numbers["position_final_m"] < 0.003


@pytest.mark.parametrize("case", ["15a", "16b"])
def test_disturbed_as_it_is_designed_for_the_robot_stays_near(references, robot, case):
    disturbance = fs.Disturbance(
        position_noise=0.001, heading_noise=np.radians(0.5), lag=LAG, delay=DELAY
    )
    offsets = np.zeros((3, 50))
    run = fs.simulate(
        fs.Pid(), references[case], robot, initial_offset=offsets, disturbance=disturbance
    )
    # A delay shifts the robot back by the way of 50 ms at least.
    assert fs.metrics.tracking(run)["position_rms_m"].max() < 0.006


@pytest.mark.parametrize("acceleration", [2.7, 0.3])
def test_the_integrals_take_off_what_a_wrong_wheel_would_leave(robot, acceleration):
    # Sluggish wheels hold the integrals up at the start only.
    robot = fs.KheperaIV(max_wheel_rate_change=acceleration / robot.wheel_radius)
    # The right wheel is 3 % larger than known: P and D alone rest beside the path.
    reference = fs.make_reference(fs.Path([Line((0, 0), (4, 0))]))
    disturbance = fs.Disturbance(wheel_radius_error=(0.03, 0))
    errors = {}
    for name, tracker in {"PD": fs.Kanayama(3, 340, 29), "PID": fs.Pid()}.items():
        run = fs.simulate(tracker, reference, robot, disturbance=disturbance)
        errors[name] = np.abs(run.error[:2, np.searchsorted(run.t, 35)])
    # By hand: the wheels turn the robot by 0.03 v_r / L, of which D takes off nothing, and both
    # wheels' mean is 1.5 % too fast.
    assert_allclose(errors["PD"][0], 0.015 * 0.1 / 1.015 / 3, rtol=0.02)
    assert_allclose(errors["PD"][1], 0.03 / robot.wheel_base / 340, rtol=0.05)
    assert (errors["PID"] < errors["PD"] / 50).all()


def test_from_far_beside_the_robot_heads_for_the_path_at_no_more_than_the_approach(robot):
    reference = fs.make_reference(fs.Path([Line((0, 0), (6, 0))]))
    offsets = np.array([[0.0] * 6, [-1, -0.5, -0.2, 0.2, 0.5, 1], [0.0] * 6])
    run = fs.simulate(fs.Pid(), reference, robot, initial_offset=offsets)
    assert np.abs(run.pose[2]).max() < np.radians(61)
    assert np.abs(run.pose[2]).max() > np.radians(55)
    assert np.abs(run.error[1, :, -1]).max() < 0.001
    # With the bound near 90 degrees the robot turns on until it is across, and overshoots it.
    steep = fs.simulate(fs.Pid(approach=1.5), reference, robot, initial_offset=offsets)
    assert np.abs(steep.pose[2]).max() > np.radians(80)


# --- limits and windup ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def weak():
    """A Khepera IV whose wheels reach 0.12 m/s only."""
    robot = fs.KheperaIV()
    return fs.KheperaIV(max_wheel_rate=0.12 / robot.wheel_radius)


@pytest.mark.parametrize("axis", [0, 1])
def test_anti_windup_shortens_the_overshoot(robot, weak, axis):
    # 0.2 m behind, the weak wheels limit for seconds; 0.4 m to the left, the approach does.
    reference = fs.make_reference(fs.Path([Line((0, 0), (4, 0))]))
    offset = np.zeros(3)
    offset[axis] = (-0.2, 0.4)[axis]
    overshoot, settled = [], []
    for anti_windup in (True, False):
        pid = fs.Pid(anti_windup=anti_windup)
        run = fs.simulate(pid, reference, (weak, robot)[axis], initial_offset=offset)
        error = run.error[axis] * np.sign(run.error[axis, 0])
        overshoot.append(-error.min())
        settled.append(fs.metrics.tracking(run)["settling_time_s"])
    assert overshoot[0] < 0.2 * overshoot[1]
    assert settled[0] < 0.5 * settled[1]


def test_without_limits_anti_windup_changes_nothing(references):
    free = fs.KheperaIV(max_wheel_rate=1e9, max_wheel_rate_change=1e9)
    with_it, without = (
        fs.simulate(fs.Pid(anti_windup=anti_windup), references["15a"], free, initial_offset=OFFSET)
        for anti_windup in (True, False)
    )
    assert_array_equal(with_it.pose, without.pose)


def test_an_integral_stops_at_a_limit_and_comes_back_at_once(weak):
    # Held 1 m behind, the robot is asked for more than its wheels give: the sum stays where it is.
    reference = fs.make_reference(STRAIGHT)
    pid, law = fs.Pid(), fs.Pid().start(reference, weak, DT)
    behind = np.array([-1.0, 0, 0])
    for t in 1 + DT * np.arange(100):
        v, _ = law(t, reference.at(t).pose + behind)
    assert v == pytest.approx(0.1 + pid.kp_x * 1.0)
    t += DT
    assert law(t, reference.at(t).pose)[0] == pytest.approx(0.1)


# --- the gate ------------------------------------------------------------------------------------


def test_the_integrals_take_in_what_is_within_the_gate_only(robot):
    # 1 mm behind for good; 9 mm to the left, and 2 mm from the tenth step on.
    reference = fs.make_reference(STRAIGHT)
    pid = fs.Pid(gate=0.008)
    law = pid.start(reference, robot, DT)
    for step, t in enumerate(1 + DT * np.arange(20)):
        aside = 0.009 if step < 10 else 0.002
        pose = reference.at(t).pose + np.array([-0.001, aside, 0])
        sums = step * DT * 0.001, max(step - 10, 0) * DT * 0.1 * -0.002
        v, omega, _ = pid.command((0.001, -aside, 0), sums, 0.1, 0)
        assert_allclose(law(t, pose), (v, omega), rtol=1e-9)


def test_the_gate_limits_the_overshoot_and_leaves_no_error_of_slip():
    reference = fs.make_reference(fs.Path([Line((0, 0), (4, 0))]))
    late = fs.Disturbance(lag=LAG, delay=DELAY)
    overshoot = {}
    for gate in (None, 0.008):
        error = fs.simulate(
            fs.Pid(gate=gate), reference, initial_offset=OFFSET, disturbance=late
        ).error[1]
        overshoot[gate] = -(error * np.sign(error[0])).min()
    assert overshoot[None] > 0.006
    assert overshoot[0.008] < 0.001
    slipping = fs.Disturbance(slip=(0.05, 0))
    run = fs.simulate(fs.Pid(gate=0.008), reference, disturbance=slipping)
    assert np.abs(run.error[:2, (run.t > 30) & (run.t < 39)]).max() < 1e-6


def test_a_wide_gate_is_none_and_a_closed_one_leaves_p_and_d(references):
    offsets = np.random.default_rng(106).normal(0, [[0.02], [0.02], [0.3]], (3, 20))
    runs = {
        name: fs.simulate(tracker, references["15a"], initial_offset=offsets).pose
        for name, tracker in {
            "none": fs.Pid(),
            "wide": fs.Pid(gate=1e9),
            "closed": fs.Pid(gate=0),
            "without": fs.Pid(ki_x=0, ki_y=0),
        }.items()
    }
    assert_array_equal(runs["wide"], runs["none"])
    assert_array_equal(runs["closed"], runs["without"])


@pytest.mark.parametrize("value", [-0.008, np.nan, np.inf, "8 mm", True, (0.008,)])
def test_invalid_gate(value):
    with pytest.raises(fs.InvalidParameter, match=r"gate is .*zero or more"):
        fs.Pid(gate=value)


# --- margins -------------------------------------------------------------------------------------


def loops(pid, speed, lag=LAG, delay=DELAY):
    """Both open loops, sampled as `simulate` does: hold, motors' lag, delay of whole steps."""
    late = ct.tf([1], [1] + [0] * round(delay / DT), DT)

    def sampled(a, b, c):
        # A state more: what the motor of first order has reached.
        a = np.block([[np.array(a), np.array(b)], [np.zeros((1, len(a))), -1 / lag]])
        b = np.append(np.zeros(len(a) - 1), 1 / lag)[:, None]
        model = ct.ss(a, b, np.hstack([c, np.zeros((len(c), 1))]), 0)
        return ct.c2d(model, DT, "zoh")

    pi = ct.ss([1], [DT], [pid.ki_x], [pid.kp_x], DT)
    along = pi * sampled([[0.0]], [[1.0]], np.eye(1)) * late
    across = ct.ss(
        [1], [[DT * speed, 0]], [speed * pid.ki_y], speed * np.array([[pid.kp_y, pid.kd_y]]), DT
    )
    return along, across * sampled([[0, speed], [0, 0]], [[0], [1]], np.eye(2)) * late


def test_the_default_gains_have_their_margins(monkeypatch):
    # disk_margins falls back on the frequency response where slycot is missing.
    monkeypatch.setattr(ct.margins, "ab13md", None)
    omega = np.logspace(-2, np.log10(0.99 * np.pi / DT), 2000)
    for loop, phase, gain, modulus in zip(
        loops(fs.Pid(), SPEED), (66, 50), (5, 5), (0.75, 0.7), strict=True
    ):
        gain_margin, phase_margin, _, crossover = ct.margin(loop)
        assert gain_margin > gain
        assert phase_margin == pytest.approx(phase, abs=1)
        assert crossover == pytest.approx(3, rel=0.02)
        assert ct.stability_margins(loop)[2] > modulus
        assert ct.disk_margins(loop, omega)[0] > 0.9


def test_the_lateral_loop_keeps_its_shape_at_every_speed():
    # Over the way, without lag and delay: s scales with the speed.
    pid = fs.Pid()
    s = ct.tf("s")
    margins = []
    for v in (0.01, 0.1, 1):
        loop = v * (pid.kd_y * s**2 + v * pid.kp_y * s + v**2 * pid.ki_y) / s**3
        _, phase_margin, _, crossover = ct.margin(loop)
        margins.append((phase_margin, crossover / v))
    assert_allclose(margins, margins[0] * np.ones((3, 1)), rtol=1e-6)


@pytest.mark.parametrize("which", [0, 1])
def test_the_margins_predict_when_the_simulated_loop_grows(robot, which):
    # The loop's gain times less than its gain margin: decays; times more: grows.
    pid, dimension = fs.Pid(), which
    margin = ct.margin(loops(pid, SPEED)[which])[0]
    reference = fs.make_reference(fs.Path([Line((0, 0), (4, 0))]))
    disturbance = fs.Disturbance(lag=LAG, delay=DELAY)
    names = [("kp_x", "ki_x"), ("kp_y", "ki_y", "kd_y")][which]
    offset = np.zeros(3)
    offset[dimension] = 1e-6
    growth = []
    for share in (0.93, 1.07):
        gains = {name: share * margin * getattr(pid, name) for name in names}
        run = fs.simulate(fs.Pid(**gains), reference, robot, DT, offset, disturbance=disturbance)
        # The delay alone sets the robot back along the path: differences, not values.
        error = np.abs(np.diff(run.error[dimension]))
        early, late = (error[(run.t[1:] > a) & (run.t[1:] < a + 5)].max() for a in (3, 12))
        growth.append(late / early)
    assert growth[0] < 0.5
    assert growth[1] > 2


# --- malformed gains -----------------------------------------------------------------------------


def test_an_approach_of_a_right_angle_is_refused():
    with pytest.raises(fs.InvalidParameter, match=r"approach is 1\.57.* less than pi / 2"):
        fs.Pid(approach=np.pi / 2)


@pytest.mark.parametrize("value", [None, 1, "yes", np.ones(2)])
def test_anti_windup_is_true_or_false(value):
    with pytest.raises(fs.InvalidParameter, match="anti_windup is "):
        fs.Pid(anti_windup=value)
