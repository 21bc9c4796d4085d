"""The MPC: its model, its programme, its limits, its discs and its failures."""

import pickle
import warnings
from dataclasses import fields, replace

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.studies import courses, tracking
from freeseg.studies.tracking import DISTURBANCE, disturbed
from freeseg.trackers import mpc
from freeseg.trackers.mpc import linearisation, motion

DT = 0.05
#: Where a robot may start: 2 cm behind, 3 cm to the left and 20 degrees off.
OFFSET = (-0.02, 0.03, np.radians(20))
#: Weight of accelerations for robots that nothing disturbs: they are followed most closely.
EXACT = 1e-6


@pytest.fixture(scope="module")
def references(cases, tables):
    """Of the paper's Figs 15(a) and 16(b)."""
    plans = {
        name: fs.plan(tables[cases[name].table], cases[name].start, cases[name].goal)
        for name in ("15a", "16b")
    }
    return {name: fs.make_reference(plan.path) for name, plan in plans.items()}


def straight(length, speed, acceleration=1.0):
    return fs.make_reference(fs.Path([Line((0, 0), (length, 0))]), None, speed, acceleration)


def row_of_discs(sides, spacing, depth, robot, radius=0.03):
    """Seven discs beside the x axis, by which a robot on it is barred by `depth`."""
    y = robot.radius + radius - depth
    return fs.World(
        [fs.Disc((0.3 + spacing * k, side * y), radius) for k, side in enumerate(sides)]
    )


# --- the model -----------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1, 1e-2, 1e-6, 0])
def test_the_casadi_and_the_numpy_model_are_the_same(robot, scale):
    # Straight on, nearly so, and as tightly as the wheels can, across both branches of sinc.
    rng = np.random.default_rng(61)
    mean, half = robot.max_wheel_speed * rng.uniform(-1, 1, (2, 300))
    wheels = np.stack([mean + scale * half, mean - scale * half])
    u = robot.max_wheel_acceleration * rng.uniform(-1, 1, (2, 300)) * scale
    pose = rng.uniform(-3, 3, (3, 300))
    after = np.array(motion(robot, DT).map(300)(np.concatenate([pose, wheels]), u))
    assert_allclose(after[:3], robot.move(pose, wheels + DT * u, DT), rtol=0, atol=1e-14)
    assert_allclose(after[3:], wheels + DT * u, rtol=0, atol=1e-15)


def test_the_model_has_derivatives_straight_on(robot):
    # The exact one of the end of an arc: a turn rate moves it aside by v dt^2 / 2.
    z, u = ca.SX.sym("z", 5), ca.SX.sym("u", 2)
    step = motion(robot, DT)
    rates = ca.Function("rates", [z, u], [ca.jacobian(step(z, u), z)])
    at_rest, driving = (np.array(rates([1, 2, 0.0, v, v], 0)) for v in (0, 0.2))
    turn = np.array([1, -1]) / robot.wheel_base
    assert_allclose(driving[1, 3:], turn * 0.2 * DT**2 / 2, atol=1e-15)
    assert_allclose(driving[1, 2], 0.2 * DT)
    assert_allclose(at_rest[0, 3:], DT / 2)
    assert_allclose(at_rest[2, 3:], turn * DT)


def test_the_linearisation_is_the_models_first_order(robot):
    # A plan off by h misses the rows of its own linearisation by the order of h^2.
    n, discs, rng = 5, 2, np.random.default_rng(62)
    rows = linearisation(motion(robot, DT), n, discs)
    near = np.array([[0.5, 0.6, 0.1], [-0.4, 0.3, 0.2]]).T
    state, rolled = [0, 0, 0.3, 0.2, 0.1], [0.95, 0.9]
    plan, change = rng.normal(0, 0.2, (2, 8, n))
    ca_plan = plan.ravel(order="F")

    def gaps(plan):
        a, lower, _ = rows(plan, state, near, rolled)
        return np.array(a @ ca.vec(ca.DM(plan)) - lower).ravel()

    a, lower, upper = (np.array(ca.DM(part)) for part in rows(plan, state, near, rolled))
    errors = []
    for h in (1e-3, 1e-4):
        moved = plan + h * change
        linear = a @ moved.ravel(order="F") - lower.ravel()
        errors.append(np.abs(gaps(moved) - linear).max())
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 50
    # The rows of the model are equations, those of the discs are not.
    equations = (np.arange(n * (5 + discs)) % (5 + discs)) < 5
    assert_array_equal((upper == lower).ravel(), equations)
    assert np.isinf(upper.ravel()[~equations]).all()
    # By hand: a disc's row is the distance from its circle, and the slack.
    clearance = np.hypot(*(plan[2:4, 0] - near[:2, 0])) - near[2, 0] + plan[7, 0]
    assert (a @ ca_plan - lower.ravel())[5] == pytest.approx(clearance)


# --- the programme -------------------------------------------------------------------------------


def converged(tracker, reference, robot, t, pose, wheels):
    """The non-linear programme, solved by ipopt: the wheel speeds of its first step."""
    n, opti = tracker.horizon, ca.Opti()
    z, u = opti.variable(5, n + 1), opti.variable(2, n)
    times = t + DT * np.arange(-1, n)
    middle = reference.at(times + DT / 2)
    wanted_wheels = robot.to_wheels(middle.v, middle.omega)
    wanted = reference.at(times[1:] + DT).pose
    step = motion(robot, DT)
    cost = tracker.acceleration * ca.sumsqr(u - np.diff(wanted_wheels) / DT)
    for k in range(n):
        factor = tracker.terminal if k == n - 1 else 1
        off = z[:3, k + 1] - wanted[:, k]
        cost += factor * (ca.sumsqr(off[:2]) + tracker.heading * off[2] ** 2)
        opti.subject_to(z[:, k + 1] == step(z[:, k], u[:, k]))
    opti.minimize(1e4 * cost)
    opti.subject_to(z[:, 0] == ca.vertcat(*pose, *wheels))
    opti.subject_to(opti.bounded(-robot.max_wheel_speed, z[3:, 1:], robot.max_wheel_speed))
    fastest = robot.max_wheel_acceleration
    opti.subject_to(opti.bounded(-fastest, u, fastest))
    opti.set_initial(z[:3, 1:], wanted)
    opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "tol": 1e-10})
    return np.array(opti.solve().value(z[3:, 1])).ravel()


@pytest.mark.parametrize("solver", ["piqp", "qrqp"])
def test_one_programme_a_step_commands_what_the_converged_one_does(references, robot, solver):
    tracker, reference = fs.Mpc(acceleration=EXACT, solver=solver), references["15a"]
    law = tracker.start(reference, robot, DT)
    x, y, theta = reference.pose[:, 0]
    pose = np.array([x, y + 0.02, theta])
    wheels = np.zeros(2)
    worst = []
    for step in range(10):
        t = step * DT
        best = converged(tracker, reference, robot, t, pose, wheels)
        wheels = robot.to_wheels(*law(t, pose))
        worst.append(np.abs(wheels - best).max())
        pose = robot.move(pose, wheels, DT)
    # Not all of the way at first, when there is no prediction; soon the two are one.
    assert 1e-4 < max(worst[:2]) < 0.01
    assert max(worst[2:]) < 2e-4
    assert max(worst[6:]) < 1e-5


def test_both_solvers_drive_alike(references):
    piqp, qrqp = (
        fs.simulate(fs.Mpc(solver=solver), references["16b"], initial_offset=OFFSET)
        for solver in ("piqp", "qrqp")
    )
    assert_allclose(piqp.pose, qrqp.pose, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_on_the_papers_paths_it_stays_closer_than_sliding_mode(references, name):
    ours, sliding = (
        fs.metrics.tracking(fs.simulate(tracker, references[name]))
        for tracker in (fs.Mpc(acceleration=EXACT), fs.SlidingMode())
    )
    assert ours["position_rms_m"] < 2e-5
    assert ours["position_rms_m"] < sliding["position_rms_m"] / 5
    assert ours["position_final_m"] < 5e-5


@pytest.mark.parametrize("name", ["15a", "16b"])
def test_from_beside_the_path_the_errors_vanish(references, name):
    run = fs.simulate(fs.Mpc(), references[name], initial_offset=OFFSET)
    position = np.hypot(*run.error[:2])
    assert position[0] > 0.03
    assert position[run.t >= 3].max() < 1e-3
    assert position[-1] < 5e-5


def test_it_turns_the_shorter_way_whatever_the_winding(references, robot):
    law, wound = (fs.Mpc().start(references["15a"], robot, DT) for _ in range(2))
    pose = references["15a"].pose[:, 0] + (0.01, 0.02, 0.1)
    for step in range(5):
        plain = law(step * DT, pose)
        turned = wound(step * DT, pose + np.array([0, 0, 2 * np.pi * (-1) ** step]))
        assert_allclose(turned, plain, rtol=0, atol=1e-9)


def test_between_the_steps_it_reads_the_reference_too(references, robot):
    on, between, beyond = (fs.Mpc().start(references["15a"], robot, DT) for _ in range(3))
    pose = references["15a"].pose[:, 0]
    assert_allclose(between(1e-9, pose), on(0.0, pose), rtol=0, atol=1e-6)
    # Beyond the end it stays at the goal.
    end = references["15a"].duration + 10
    assert_allclose(beyond(end, references["15a"].pose[:, -1]), 0, atol=1e-9)


# --- limits --------------------------------------------------------------------------------------


def test_limits_are_never_exceeded_and_bind(robot):
    # From far off, both limits of the wheels bind; the law itself commands nothing beyond them.
    reference = straight(2.0, 0.9, 2.0)
    commands = []

    class Recorded:
        def start(self, *run):
            law = fs.Mpc().start(*run)

            def record(t, pose):
                command = law(t, pose)
                commands.append(robot.to_wheels(*command))
                return command

            return record

    run = fs.simulate(Recorded(), reference, robot, DT, (-0.3, 0.1, 1.0))
    asked = np.array(commands).T
    reach = robot.max_wheel_acceleration * DT
    for wheels in (asked, run.wheels):
        changes = np.diff(wheels, axis=1, prepend=0.0)
        assert np.abs(wheels).max() <= robot.max_wheel_speed + 1e-12
        assert np.abs(changes).max() <= reach + 1e-12
    changes = np.diff(asked, axis=1, prepend=0.0)
    assert np.abs(asked).max() > robot.max_wheel_speed - 1e-6
    assert np.abs(changes).max() > reach - 1e-6
    # What it commands is what the simulated wheels do.
    assert_allclose(run.wheels[:, :-1], asked, rtol=0, atol=1e-12)


def test_from_wherever_it_starts_limits_hold_and_it_arrives(references, robot):
    offsets = np.random.default_rng(63).normal(0, [[0.1], [0.1], [1.0]], (3, 4)).T
    for offset in offsets:
        run = fs.simulate(fs.Mpc(), references["16b"], robot, DT, offset)
        changes = np.diff(run.wheels, axis=1, prepend=0.0)
        assert np.abs(run.wheels).max() <= robot.max_wheel_speed + 1e-12
        assert np.abs(changes).max() <= robot.max_wheel_acceleration * DT + 1e-12
        assert np.hypot(*run.error[:2, -1]) < 1e-3


def test_a_second_run_does_not_see_the_first(references, robot):
    tracker = fs.Mpc(obstacles=fs.load_table(1))
    runs = [fs.simulate(tracker, references["15a"], initial_offset=OFFSET) for _ in range(2)]
    assert_array_equal(runs[0].pose, runs[1].pose)
    # Nor do two that are under way at once.
    alone = fs.Mpc().start(references["15a"], robot, DT)
    one, other = (fs.Mpc().start(references["15a"], robot, DT) for _ in range(2))
    pose = references["15a"].pose[:, 0]
    for step in range(4):
        expected = alone(step * DT, pose)
        assert_array_equal(one(step * DT, pose), expected)
        other(step * DT, pose + 0.05)


# --- discs ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("sides", [(1,) * 7, (1, -1) * 3 + (1,)], ids=["wall", "slalom"])
@pytest.mark.parametrize("speed", [0.1, 0.6])
def test_it_keeps_out_of_seven_discs(robot, sides, speed):
    world = row_of_discs(sides, 0.15, 0.015, robot)
    reference = straight(1.5, speed)
    through, round_them = (
        fs.simulate(tracker, reference, robot) for tracker in (fs.Mpc(), fs.Mpc(obstacles=world))
    )
    assert fs.metrics.tracking(through, world)["clearance_m"] < robot.radius - 0.014
    x, y = round_them.pose[:2]
    clearances = np.array(
        [np.hypot(x - disc.center[0], y - disc.center[1]) - disc.radius for disc in world.obstacles]
    )
    # Every one of the seven bars the way, and is entered by less than a millimetre.
    closest = clearances.min(1) - robot.radius
    assert closest.min() > -1e-3
    assert closest.max() < 2e-3
    assert np.hypot(*round_them.error[:2, -1]) < 1e-3


def test_it_knows_the_discs_that_are_near(robot):
    # First in the list are a hundred far away: three of these would leave the seven in the way.
    seven = row_of_discs((1, -1) * 3 + (1,), 0.15, 0.015, robot).obstacles
    far = [fs.Disc((5 + 0.1 * k, 5), 0.02) for k in range(100)]
    world = fs.World([*far, *seven])
    run = fs.simulate(fs.Mpc(obstacles=world, nearest=3), straight(1.5, 0.1), robot)
    assert fs.metrics.tracking(run, world)["clearance_m"] > robot.radius - 1e-3
    assert np.hypot(*run.error[:2, -1]) < 1e-3


def test_where_there_is_no_other_way_it_stops_in_front(robot):
    world = fs.World([fs.Disc((0.6, 0), 0.1)])
    run = fs.simulate(fs.Mpc(obstacles=world), straight(1.2, 0.2), robot)
    assert fs.metrics.tracking(run, world)["clearance_m"] > robot.radius - 1e-3
    # The reference has long passed by; dead ahead, neither side is the better one.
    assert run.pose[0, 80] == pytest.approx(0.5 - robot.radius, abs=1e-3)
    assert_allclose(run.wheels[:, 80], 0, atol=1e-3)


def test_discs_out_of_reach_change_nothing(references):
    world = fs.World([fs.Disc((5, 5), 0.1)])
    free, beside = (
        fs.simulate(tracker, references["16b"]) for tracker in (fs.Mpc(), fs.Mpc(obstacles=world))
    )
    assert_allclose(free.pose, beside.pose, rtol=0, atol=1e-6)
    empty = fs.simulate(fs.Mpc(obstacles=fs.World([])), references["16b"])
    assert_allclose(empty.pose, free.pose, rtol=0, atol=1e-6)


# --- what it is told -----------------------------------------------------------------------------


def rms_of(tracker, reference, disturbance):
    run = fs.simulate(tracker, reference, disturbance=disturbance)
    return fs.metrics.tracking(run)["position_rms_m"]


@pytest.fixture(scope="module")
def smooth():
    """Case 15(a) with ramps of the curvature."""
    plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    return fs.make_reference(plan, smoothing=0.03)


@pytest.mark.parametrize("acceleration", [fs.Mpc().acceleration, EXACT])
def test_told_of_delay_and_lag_it_stays_within_a_millimetre(smooth, acceleration):
    late = fs.Disturbance(delay=0.1, lag=0.03)
    untold = fs.Mpc(acceleration=acceleration)
    told = replace(untold, delay=late.delay, lag=late.lag)
    assert rms_of(told, smooth, late) < 0.001 < rms_of(untold, smooth, late)


def test_told_of_nothing_its_default_weights_are_stable_with_delay_and_lag(smooth):
    late = fs.Disturbance(delay=0.05, lag=0.03)
    assert rms_of(fs.Mpc(), smooth, late) < 0.003
    assert rms_of(fs.Mpc(acceleration=EXACT), smooth, late) > 0.01


@pytest.mark.parametrize("slip", [(0.06, 0.06), (0.1, 0.0), (0.0, 0.05)])
@pytest.mark.parametrize("late", [{}, {"delay": 0.1, "lag": 0.03}], ids=["at once", "late"])
def test_a_constant_slip_leaves_no_steady_error(slip, late):
    reference, disturbance = straight(2.5, 0.1), fs.Disturbance(slip=slip, **late)
    errors = []
    for observer in (0, 4):
        run = fs.simulate(fs.Mpc(observer=observer, **late), reference, disturbance=disturbance)
        errors.append(np.abs(run.error[:, (run.t > 15) & (run.t < 24)]).max(1))
    with_offset, offset_free = errors
    assert np.hypot(*with_offset[:2]) > 4e-4
    assert (offset_free < 1e-6).all()


def test_in_steady_turns_a_constant_slip_leaves_no_error_either():
    circle = fs.make_reference(fs.Path([Arc((0, 0.3), 0.3, -np.pi / 2, 6.0)]))
    disturbance = fs.Disturbance(slip=(0.08, 0.02), wheel_base_error=0.03)
    run = fs.simulate(fs.Mpc(observer=4), circle, disturbance=disturbance)
    assert np.abs(run.error[:2, (run.t > 12) & (run.t < 17)]).max() < 1e-5


def test_slip_takes_nothing_from_the_limits(robot):
    # Wheels that lose a third have to turn at more than their limit: they turn at it.
    reference, slip = straight(2.5, 0.75 * robot.max_wheel_speed), fs.Disturbance(slip=0.33)
    run = fs.simulate(fs.Mpc(observer=4), reference, disturbance=slip)
    assert np.abs(run.wheels).max() == pytest.approx(robot.max_wheel_speed, abs=1e-9)
    assert np.abs(run.wheels).max() <= robot.max_wheel_speed + 1e-12


def test_told_of_all_both_solvers_drive_alike(smooth):
    piqp, qrqp = (
        fs.simulate(
            fs.Mpc(solver=solver, delay=0.05, lag=0.03, observer=3),
            smooth,
            initial_offset=OFFSET,
            disturbance=DISTURBANCE,
            seed=1,
        )
        for solver in ("piqp", "qrqp")
    )
    assert_allclose(piqp.pose, qrqp.pose, rtol=0, atol=1e-5)


def test_on_a_course_it_is_closer_and_calmer_by_what_it_is_told():
    course = courses.paper_courses()[:1]
    offsets = courses.spread_offsets(3, 1)
    plain, told = (
        tracking.evaluate(tracker, course, offsets, 1)
        for tracker in (fs.Mpc(), fs.Mpc(delay=0.05, lag=0.03, observer=3))
    )
    for number in ("position_rms_m", "roughness_m_s2"):
        assert told[number].mean() < 0.8 * plain[number].mean()


def test_three_times_the_disturbances_do_not_drive_it_into_an_obstacle(robot):
    values = {field.name: getattr(DISTURBANCE, field.name) for field in fields(DISTURBANCE)}
    # All but the correlation time of the slip, which makes it no larger.
    larger = {name: 3 * np.array(value) for name, value in values.items() if name != "slip_time"}
    worse = replace(DISTURBANCE, **larger)
    told = fs.Mpc(delay=worse.delay, lag=worse.lag, observer=3)
    found = tracking.evaluate(
        told, courses.paper_courses()[:1], courses.spread_offsets(3, 1), 1, worse
    )
    assert found["clearance_m"].min() > robot.radius
    assert found["position_rms_m"].max() < 0.01


# --- failures ------------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["piqp", "qrqp"])
def test_a_failed_solve_raises_with_time_and_status(references, robot, solver):
    tracker = fs.Mpc(acceleration=EXACT, solver=solver, iterations=1)
    with pytest.raises(
        fs.SolverFailed, match=rf"{solver}( and piqp)? found no command at 0\.000 s"
    ) as caught:
        fs.simulate(tracker, references["15a"], robot, initial_offset=OFFSET)
    assert caught.value.time == 0
    assert "iterations" in caught.value.status
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.time, again.status) == (
        str(caught.value),
        0,
        caught.value.status,
    )


def test_a_failed_solve_brakes_and_says_so_where_it_is_to(robot):
    # At 0.5 m/s on its path, few iterations will do; thrown far aside, they will not.
    reference, most = straight(3.0, 0.5), 10
    law = fs.Mpc(solver="piqp", iterations=most, on_failure="brake").start(reference, robot, DT)
    pose, wheels = np.zeros(3), np.zeros(2)

    def drive(steps):
        nonlocal pose, wheels
        for step in steps:
            wheels = robot.to_wheels(*law(step * DT, pose))
            pose = robot.move(pose, wheels, DT)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drive(range(20))
    assert wheels.min() > 0.4
    before, pose = wheels, pose + np.array([0, 0.5, 2.5])
    with pytest.warns(RuntimeWarning, match=r"piqp found no command at 1\.000 s: .*; braking"):
        drive([20])
    assert_allclose(wheels, before - robot.max_wheel_acceleration * DT, atol=1e-12)
    # Put back, it goes on.
    pose = reference.at(21 * DT).pose
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drive(range(21, 40))
    assert np.hypot(*fs.tracking_error(reference.at(40 * DT).pose, pose)[:2]) < 0.01


@pytest.mark.parametrize("pose", [np.zeros((3, 4)), np.zeros((3, 1))])
def test_a_batch_is_refused(references, robot, pose):
    law = fs.Mpc().start(references["15a"], robot, DT)
    with pytest.raises(fs.InvalidParameter, match=r"pose has shape \(3, .* one robot"):
        law(0.0, pose)
    with pytest.raises(fs.InvalidParameter, match="one robot"):
        fs.simulate(fs.Mpc(), references["15a"], initial_offset=pose)


@pytest.mark.parametrize("pose", [(0, 0), (0, 0, np.nan), (0, np.inf, 0), "here", None, 0.0])
def test_invalid_pose(references, robot, pose):
    law = fs.Mpc().start(references["15a"], robot, DT)
    with pytest.raises(fs.InvalidParameter, match="pose is "):
        law(0.0, pose)


@pytest.mark.parametrize("name", ["heading", "acceleration", "terminal", "keep_out"])
@pytest.mark.parametrize("value", [-1, np.nan, np.inf, None, "high", True, 1e300])
def test_invalid_weight(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is "):
        fs.Mpc(**{name: value})


@pytest.mark.parametrize("name", ["heading", "acceleration", "terminal", "keep_out"])
def test_a_weight_of_zero_switches_its_term_off(references, robot, name):
    if name == "acceleration":
        with pytest.raises(fs.InvalidParameter, match="acceleration is "):
            fs.Mpc(acceleration=0)
        return
    run = fs.simulate(fs.Mpc(**{name: 0}), references["15a"], robot, DT)
    assert np.hypot(*run.error[:2]).max() < 0.005


@pytest.mark.parametrize("what", ["gives up", "breaks the model", "breaks a limit", "is no number"])
@pytest.mark.parametrize("solver", ["qrqp", "piqp"])
def test_where_the_solver_fails_another_finds_the_same_command(
    references, robot, monkeypatch, solver, what
):
    # A solver that fails at every tenth step, or calls a success what is none; standing still is
    # always a plan.
    spoilt = {
        "breaks the model": (3, 2, 1e-6),
        "breaks a limit": (3, 5, robot.max_wheel_speed),
        "is no number": (3, 2, np.nan),
    }
    bind, calls = mpc._bind, []

    class GivesUp:
        def stats(self):
            return {"success": False, "return_status": "gave up"}

    def unreliable(function, **arrays):
        solve = bind(function, **arrays)
        if function.name() != "programme" or calls:
            return solve
        calls.append(0)

        def sometimes():
            calls[0] += 1
            if calls[0] % 10:
                return solve()
            if what not in spoilt:
                return GivesUp()
            told, (step, column, more) = solve(), spoilt[what]
            arrays["x"][step, column] += more
            return told

        return sometimes

    smooth = fs.simulate(fs.Mpc(solver=solver), references["15a"], robot, DT)
    monkeypatch.setattr(mpc, "_bind", unreliable)
    rescued = fs.simulate(fs.Mpc(solver=solver), references["15a"], robot, DT)
    assert calls[0] > 100
    assert_allclose(rescued.pose, smooth.pose, atol=1e-4)


@pytest.mark.parametrize(
    ("x", "broken"),
    [
        ((1, 2), 0),
        ((1, 2 + 1e-9), 0),  # within what solvers leave
        ((1, 2.5), 1),  # the sum is to be 3
        ((-1, 4), 1),  # the first is to be positive
        ((-1, 5), 2),
        ((1, np.nan), 2),
    ],
)
def test_broken_constraints_are_counted(x, broken):
    count = mpc._constraints_broken(ca.Sparsity.dense(1, 2))
    limits = {"lba": 3, "uba": 3, "lbx": [0, -np.inf], "ubx": [np.inf, np.inf]}
    assert float(count(a=ca.DM([[1, 1]]), x=x, **limits)["broken"]) == broken


@pytest.mark.parametrize("solver", ["qrqp", "piqp"])
def test_far_from_the_origin_solvers_may_leave_more(robot, solver):
    # Coordinates as surveyors have them (m), of which an interior-point method leaves a share.
    far = 5e6
    reference = fs.make_reference(fs.Path([Line((far, far), (far + 1, far))]))
    run = fs.simulate(fs.Mpc(solver=solver), reference, robot, DT, OFFSET)
    assert np.hypot(*run.error[:2, -1]) < 0.001


def test_every_plan_obeys_the_model_and_the_limits(references, robot, monkeypatch):
    # Thrown from bound to bound, qrqp calls plans a success that break both by far.
    worst, solve = [], mpc._Programme.solve

    def solve_and_measure(self):
        status, found = solve(self), self.arrays
        a, x = ca.DM(self.structure["a"], found["a"]).full(), found["x"].ravel()
        for values, least, most in ((a @ x, "lba", "uba"), (x, "lbx", "ubx")):
            worst.append((found[least].ravel() - values).max())
            worst.append((values - found[most].ravel()).max())
        assert self.solved
        return status

    monkeypatch.setattr(mpc._Programme, "solve", solve_and_measure)
    for seed in range(4):
        fs.simulate(fs.Mpc(), references["15a"], robot, DT, (0.02, 0.02, 0.5), disturbed(3), seed)
    assert max(worst) < 1e-6


@pytest.mark.parametrize("name", ["delay", "lag", "observer"])
@pytest.mark.parametrize("value", [-0.05, np.nan, np.inf, None, "0.1", True, (0.1, 0.1)])
def test_invalid_times_and_rates(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is .*zero or more"):
        fs.Mpc(**{name: value})


@pytest.mark.parametrize("name", ["horizon", "nearest", "iterations"])
@pytest.mark.parametrize("value", [0, -1, 2.5, np.nan, True, None, "20"])
def test_invalid_number(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is .* whole number"):
        fs.Mpc(**{name: value})


@pytest.mark.parametrize(("name", "choices"), [("solver", "piqp"), ("on_failure", "brake")])
@pytest.mark.parametrize("value", ["", "ipopt", 1, ["piqp"]])
def test_invalid_choice(name, choices, value):
    with pytest.raises(fs.InvalidParameter, match=f"{name} is .*{choices}"):
        fs.Mpc(**{name: value})


@pytest.mark.parametrize("obstacles", [[fs.Disc((1, 1), 0.1)], "world", 7])
def test_obstacles_that_are_no_world(obstacles):
    with pytest.raises(fs.InvalidParameter, match=r"obstacles is .* give a World"):
        fs.Mpc(obstacles=obstacles)


def test_the_solver_follows_the_obstacles(robot):
    # Set later, obstacles still get the solver that is for them.
    world = row_of_discs((1,) * 7, 0.1, 0.015, robot)
    later = replace(fs.Mpc(), obstacles=world)
    runs = [fs.simulate(t, straight(1.0, 0.5)) for t in (later, fs.Mpc(obstacles=world))]
    assert_array_equal(runs[0].pose, runs[1].pose)
    assert later.solver is None


def test_polygons_are_refused():
    square = fs.Polygon([(1, 1), (2, 1), (2, 2), (1, 2)])
    with pytest.raises(fs.InvalidParameter, match="obstacle 2 is a Polygon"):
        fs.Mpc(obstacles=fs.World([fs.Disc((0, 0), 0.1), square]))


@pytest.mark.parametrize("dt", [0, -1, np.nan, None])
def test_invalid_time_step(references, robot, dt):
    with pytest.raises(fs.InvalidParameter, match="dt is "):
        fs.Mpc().start(references["15a"], robot, dt)
