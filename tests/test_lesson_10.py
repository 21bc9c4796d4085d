"""Lesson 10, its own lines: two loops, their margins, gating, preview, and noise."""

from dataclasses import replace

import control as ct
import numpy as np
import pytest
from lessons import definitions, lesson
from scipy.optimize import brentq

import freeseg as fs

STEM = "10_tune_a_pid_baseline"
NAMES = ["robot", "speed", "dt", "lag", "delay", "gains", "designed", "L", "loops", "lateness"]
NAMES += ["controller", "phase_margin", "line", "linear", "s"]


@pytest.fixture(scope="module")
def own():
    """What the lesson designs."""
    return definitions(STEM, *NAMES)


def test_the_linear_plants_are_those_of_the_text(own):
    linear, at = own["linear"], 1j * np.logspace(-1, 2, 50)
    assert np.allclose(-linear["x_e", "v"](at), 1 / at, rtol=1e-6)
    assert np.allclose(-linear["y_e", "w"](at), own["speed"] / at**2, rtol=1e-6)
    for error, command in (("y_e", "v"), ("x_e", "w")):
        assert np.allclose(linear[error, command](at), 0, atol=1e-5)


def test_the_defaults_are_the_designed_gains_rounded(own):
    for name, value in own["designed"].items():
        assert float(f"{value:.2g}") == getattr(own["gains"], name)


def sampled_loops(own, gains, v_r):
    """L_x and L as the robot's computer closes them, exactly."""
    dt, lag = own["dt"], own["lag"]
    one_step_late = ct.tf([1], [1, 0], dt)
    x_plant = ct.ss([[0, 1], [0, -1 / lag]], [[0], [1 / lag]], [[1, 0]], 0)
    rows = [[0, v_r, 0], [0, 0, 1], [0, 0, -1 / lag]]
    y_plant = ct.ss(rows, [[0], [0], [1 / lag]], np.eye(2, 3), 0)
    pi = ct.ss([[1]], [[dt]], [[gains.ki_x]], [[gains.kp_x]], dt)
    direct = [[v_r * gains.kp_y, v_r * gains.kd_y]]
    pid = ct.ss([[1]], [[dt * v_r, 0]], [[v_r * gains.ki_y]], direct, dt)
    return pi * ct.c2d(x_plant, dt) * one_step_late, pid * ct.c2d(y_plant, dt) * one_step_late


def test_the_margins_hold_for_the_sampled_loops(own):
    omega = np.logspace(-1.5, np.log10(0.99 * np.pi / own["dt"]), 800)
    sampled = sampled_loops(own, own["gains"], own["speed"])
    for continuous, exact in zip(own["loops"].values(), sampled, strict=True):
        found = []
        for loop, s in ((continuous, 1j * omega), (exact, np.exp(1j * omega * own["dt"]))):
            sensitivity = 1 / (1 + loop(s))
            disk = 1 / np.abs(sensitivity - 0.5).max()
            gain, phase, _, at_one = ct.margin(loop)
            found.append([gain, phase, at_one, 1 / np.abs(sensitivity).max(), disk])
            assert disk == pytest.approx(ct.disk_margins(loop, omega)[0])
        assert np.allclose(*found, rtol=0.05)
        assert min(found[1]) > 0.7
        assert found[1][1] > own["phase_margin"] - 1


def grows(own, position, heading):
    """How fast the sampled lateral loop grows where sensors read so many times too much."""
    gains = own["gains"]
    lateral = {"kp_y": position * gains.kp_y, "ki_y": position * gains.ki_y}
    wrong = replace(gains, **lateral, kd_y=heading * gains.kd_y)
    return np.abs(ct.feedback(sampled_loops(own, wrong, own["speed"])[1], 1).poles()).max() - 1


def test_a_sensors_gain_is_borne_up_to_the_margins(own):
    exact = sampled_loops(own, own["gains"], own["speed"])[1]
    factors, *_, crossings, _, _ = ct.stability_margins(exact, returnall=True)
    few = max(factors[(factors < 1) & (crossings > 0.03)])
    both = [brentq(lambda k: grows(own, k, k), *span) for span in ((0.05, 0.5), (2, 9))]
    assert np.allclose(both, [few, ct.margin(exact)[0]], rtol=1e-4)
    assert grows(own, 0.01, 1) < 0  # too little of the position: slow, but stable
    assert grows(own, 1, 0.1) > 0  # too little of the heading: no damping


@pytest.mark.parametrize(("share", "grown"), [(0.93, False), (1.07, True)])
def test_the_simulated_robot_grows_beyond_the_margin(own, share, grown):
    margin = share * ct.margin(sampled_loops(own, own["gains"], own["speed"])[1])[0]
    gains = own["gains"]
    lateral = {name: margin * getattr(gains, name) for name in ("kp_y", "ki_y", "kd_y")}
    late = fs.Disturbance(lag=own["lag"], delay=own["delay"])
    start = (0, 1e-6, 0)
    run = fs.simulate(replace(gains, **lateral), own["line"], own["robot"], own["dt"], start, late)
    early, end = (np.ptp(run.error[1, (run.t > t) & (run.t < t + 3)]) for t in (3, 9))
    assert (end > 1.25 * early) if grown else (end < 0.8 * early)


def test_labels_of_the_nyquist_plot_count_the_unstable_poles(own):
    factors, unstable = lesson(STEM, "factors", "unstable")
    least, most = 0.088, ct.margin(own["L"])[0]
    expected = [0 if least < factor < most else 2 for factor in factors]
    assert list(unstable) == expected
    assert len(set(expected)) == 2


def test_constant_gains_are_unstable_when_slow_and_gains_per_way_are_not(own):
    speeds, fixed, per_way = (np.array(one) for one in lesson(STEM, "speeds", "fixed", "per_way"))
    slow = speeds <= own["speed"]
    assert (per_way[slow] > 49).all()
    # Routh's criterion, for a loop that is not late.
    gains, speed = own["gains"], own["speed"]
    routh = gains.ki_y * speed**2 / (gains.kp_y * speed) / gains.kd_y
    assert (fixed[speeds < routh] < 0).all()
    assert (fixed[(speeds > 1.2 * routh) & slow] > 0).all()
    fast = speeds > 2 * own["speed"]
    assert (fixed[fast] > per_way[fast]).all()


def test_the_gate_takes_the_overshoot_and_leaves_no_error_of_slip(own):
    beside, room = lesson(STEM, "beside"), own["robot"].radius
    world = lesson(STEM, "world")
    found = {gate: beside(replace(own["gains"], gate=gate)) for gate in (None, 0.001, 0.008)}
    assert found[None][1] > 0.005 > 0.001 > found[0.008][1]
    assert found[None][2] < 1e-5
    assert found[0.008][2] < 1e-5
    assert found[0.001][2] > 0.0005
    clearances = [
        fs.metrics.tracking(found[gate][0], world)["clearance_m"] for gate in (None, 0.008)
    ]
    assert clearances[0] < room < clearances[1]
    for tracker in (fs.SlidingMode(), fs.Kanayama(k_x=3, k_y=340, k_alpha=29)):
        run, _, rest = beside(tracker)
        assert rest > 1e-4
        assert fs.metrics.tracking(run, world)["clearance_m"] > room


def test_feedforward_and_preview_pay(own):
    designs, plan = lesson(STEM, "designs", "plan")
    jumps = fs.make_reference(plan.path, speed=0.5)
    rms = [
        fs.metrics.tracking(fs.simulate(one, jumps, own["robot"], own["dt"]))["position_rms_m"]
        for one in designs.values()
    ]
    assert rms[0] > 5 * rms[1] > 15 * rms[2]


def test_noise_is_passed_on_in_proportion_unless_d_is_a_difference(own):
    lateral_rms, laws = lesson(STEM, "lateral_rms", "laws")
    shares = {}
    for name, tracker in laws.items():
        shares[name] = [1000 * lateral_rms(tracker, multiple) / multiple for multiple in (1, 8)]
    for name in ("PID", "sliding mode"):
        assert shares[name][1] == pytest.approx(shares[name][0], rel=0.1)
        assert 0.2 < shares[name][0] < 0.35
    careless = shares["PID, D by differences"]
    assert careless[0] > 2 * shares["PID"][0]
    assert careless[1] > 2 * careless[0]


def test_python_controls_pid_designer_inverts_the_sign_of_the_derivative(own):
    gains, s = own["gains"], own["s"]
    plant = ct.tf([own["speed"]], [1, 0, 0])
    k_p, k_d, tau = gains.kp_y * own["speed"], gains.kd_y, 0.01
    right = ct.feedback(plant * (k_p + k_d * s / (tau * s + 1)), 1)
    options = {"Kp0": k_p, "Kd0": k_d, "tau": tau, "plot": False}
    wrong = ct.rootlocus_pid_designer(plant, **options, derivative_in_feedback_path=False)

    def slowest(system):
        return max(pole.real for pole in system.poles() if 1e-6 < abs(pole) < 10)

    assert slowest(right) < -1
    assert slowest(wrong) > 1


def test_a_default_tolerance_of_python_control_reports_errors_of_its_own(own):
    """Constant speeds on an arc: the solver is on its own, and off the circle."""

    def rates(t, pose, u, params):
        return np.array([u[0] * np.cos(pose[2]), u[0] * np.sin(pose[2]), u[1]])

    robot = ct.nlsys(rates, None, states=3, inputs=2, outputs=3)
    t = np.linspace(0, 60, 601)
    exact = np.array([0.1 * np.sin(t), 0.1 * (1 - np.cos(t))])
    strict = {"solve_ivp_kwargs": {"rtol": 1e-8, "atol": 1e-11}}
    off = [
        np.hypot(
            *(
                ct.input_output_response(robot, t, np.full((2, 601), [[0.1], [1]]), **how).outputs[
                    :2
                ]
            )
            - exact
        ).max()
        for how in ({}, strict)
    ]
    assert off[0] > 1e-3 > 1e-5 > off[1]
