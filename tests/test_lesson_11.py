"""Lesson 11, its own lines: three builds of an MPC, what each part of it wins, and failures."""

from dataclasses import replace
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from lessons import definitions

import freeseg as fs

STEM = "11_build_an_mpc_tracker"
#: Of the lesson's own lines: nothing that drives many robots.
NAMES = [
    "robot",
    "dt",
    "slow",
    "fast",
    "a_max",
    "plan",
    "world",
    "arc",
    "rms_of",
    "drive",
    "LAWS",
    "f",
    "by_opti",
    "by_nlpsol",
    "by_qp",
    "programme",
    "by_two",
    "values",
    "preview",
    "solved",
    "rescued",
    "safe",
    "LookAhead",
    "offset",
    "mpc",
    "unaware",
    "barred",
    "line",
    "growth",
    "radii",
    "quick",
]


@pytest.fixture(scope="module")
def own():
    """What the lesson defines."""
    return SimpleNamespace(**definitions(STEM, *NAMES))


@pytest.fixture(scope="module")
def sliding(own):
    """The sliding-mode law on the fast reference."""
    return own.drive(fs.SlidingMode())


def distance_of(run):
    return np.hypot(*run.error[:2])


# --- the three builds ----------------------------------------------------------------------------


def test_all_three_drive_the_same(own):
    first = own.drive(own.LookAhead(own.by_opti), own.slow, own.offset)
    runs = {
        name: own.drive(tracker, own.slow, own.offset)
        for name, tracker in (
            ("nlpsol", own.LookAhead(own.by_nlpsol)),
            ("qp", own.LookAhead(own.by_qp)),
            ("package", own.mpc),
        )
    }
    for run in runs.values():
        apart = 1000 * np.hypot(*(run.pose - first.pose)[:2])
        assert apart.max() < 0.01
        assert apart[-1] < 1e-4
        rms, best = (np.sqrt((one.error[1] ** 2).mean()) for one in (run, first))
        assert abs(rms / best - 1) < 0.002
    assert np.abs(runs["qp"].pose - runs["package"].pose).max() < 1e-6


def test_the_model_is_the_robots(own):
    rng = np.random.default_rng(11)
    states = np.concatenate([rng.uniform(-1, 1, (3, 500)), rng.uniform(-1, 1, (2, 500))])
    states[4, :100] = states[3, :100]  # some straight on
    inputs = rng.uniform(-2, 2, (2, 500)) * (np.arange(500) >= 100)
    after = np.array(own.f.map(500)(states, inputs))
    by_numpy = own.robot.move(states[:3], states[3:] + own.dt * inputs, own.dt)
    assert np.abs(after[:3] - by_numpy).max() < 1e-14


# --- the corner ----------------------------------------------------------------------------------


def test_it_is_speed_and_jumps_together_that_are_hard(own, sliding):
    ramps = {"smoothing": 0.03, "world": own.world}
    off = {
        "slow, steps": fs.make_reference(own.plan.path, own.robot, 0.1),
        "slow, ramps": own.slow,
        "fast, ramps": fs.make_reference(own.plan.path, own.robot, 0.5, 0.5, **ramps),
    }
    off = {name: distance_of(own.drive(fs.SlidingMode(), one)).max() for name, one in off.items()}
    assert distance_of(sliding).max() > 0.01 > 0.001 > max(off.values())


def test_the_mpc_turns_before_the_arc_and_the_sliding_mode_law_does_not(own, sliding):
    turned = []
    for run in (own.drive(own.mpc), sliding):
        earlier = (run.t > own.arc - 0.3) & (run.t + own.dt < own.arc)
        wanted = own.fast.at(run.t + own.dt / 2).omega
        turned.append(np.abs(own.robot.to_body(run.wheels)[1] - wanted)[earlier].max())
    assert turned[0] > 0.5
    assert turned[1] < 0.01


def test_a_preview_does_for_every_law_what_the_mpc_does(own):
    corner = {
        name: [own.rms_of(law(preview=span)) for span in (0, 0.1)] for name, law in own.LAWS.items()
    }
    for name, (before, after) in corner.items():
        assert after < 1
        assert name == "pure pursuit" or after < before / 5
    # Among other spans, the one that the wheels need is the best of the PID.
    spans = {span: own.rms_of(fs.Pid(preview=span)) for span in (0.05, 0.075, 0.1, 0.125, 0.15)}
    assert min(spans, key=spans.get) == 0.1
    found = {n: own.rms_of(replace(own.mpc, horizon=n)) for n in (1, 2, 3, 4, 6, 10, 20, 30)}
    enough = [value for n, value in found.items() if n > 1]
    # The ranges overlap.
    after = [both[1] for both in corner.values()]
    assert min(enough) < max(after)
    assert min(after) < max(enough)
    reacting = corner["sliding mode"][0]
    assert max(enough) < 0.5 < reacting / 5
    assert min(enough) > 0.2
    assert min(found, key=found.get) == 3
    assert found[1] > 5 * reacting
    heavier = own.rms_of(replace(own.mpc, horizon=1, heading=10 * own.mpc.heading))
    assert heavier < 2
    # A dear price makes it worse than all laws.
    assert own.rms_of(replace(own.mpc, acceleration=1e-4)) > max(after)


# --- limits --------------------------------------------------------------------------------------


def test_the_mpc_asks_for_what_it_gets_and_the_sliding_mode_law_does_not(own):
    beyond = {}
    for name, tracker in (("MPC", own.LookAhead(own.by_qp)), ("sliding mode", fs.SlidingMode())):
        commands = []

        def start(*how, tracker=tracker, commands=commands):
            law = tracker.start(*how)
            return lambda t, pose: commands.append(law(t, pose)) or commands[-1]

        run = own.drive(SimpleNamespace(start=start), own.fast, (0.0, -0.15, np.radians(170)))
        asked = own.robot.to_wheels(*np.transpose(commands))
        beyond[name] = np.abs(asked - run.wheels[:, :-1]).max()
        rates = np.diff(run.wheels[:, :-1], axis=1, prepend=0) / own.dt
        # Both go to the limit.
        assert (np.abs(rates) > own.a_max - 1e-6).any()
        if name == "MPC":
            # What it planned, too.
            planned = np.array([plan[5:, 0] for plan in tracker.plans]).T
            assert np.abs(planned - run.wheels[:, :-1]).max() < 1e-9
    assert beyond["MPC"] < 1e-9
    assert beyond["sliding mode"] > 1


def test_not_knowing_the_limits_hurts_only_where_accelerations_are_cheap(own):
    starts = [(0.05, 0.08, 2.5), (-0.08, 0.03, -1.5), (0.0, -0.09, 3.0)]

    def settling(tracker):
        runs = [own.drive(tracker, own.slow, start) for start in starts]
        return np.array([fs.metrics.tracking(run)["settling_time_s"] for run in runs])

    knows, does_not = (settling(one) for one in (fs.Mpc(), own.unaware(fs.Mpc())))
    assert (does_not < 1.5 * knows + 0.2).all()
    assert (settling(own.mpc) < 1).all()
    assert np.isinf(settling(own.unaware(own.mpc))).any()


# --- what is told --------------------------------------------------------------------------------


def test_told_of_delay_and_lag_every_law_stays_within_a_millimetre(own):
    late = {"delay": 0.1, "lag": 0.03}
    pairs = [(law(), fs.Predicting(law(), **late)) for law in own.LAWS.values()]
    pairs += [(fs.Mpc(), fs.Mpc(**late)), (own.mpc, replace(own.mpc, **late))]
    for both in pairs:
        untold, told = (
            own.rms_of(one, own.slow, disturbance=fs.Disturbance(**late)) for one in both
        )
        assert told < 1 < untold
    # Of the last, the cheap MPC.
    assert untold > 50


def test_a_wrong_delay_is_worse_the_more_it_is_wrong(own):
    late = fs.Disturbance(delay=0.1, lag=0.03)
    found = [
        own.rms_of(fs.Mpc(delay=told, lag=0.03), own.slow, disturbance=late)
        for told in (0, 0.05, 0.1, 0.15, 0.2)
    ]
    assert found[0] > found[1] > found[2] < found[3] < found[4]
    assert 0.8 < found[1] / found[3] < 1.25


def test_only_the_observer_is_rid_of_slip_for_good(own):
    slip = fs.Disturbance(slip=0.05)
    left = []
    for law in (fs.Mpc(observer=4), fs.SlidingMode(), fs.Pid(), fs.Mpc()):
        run = own.drive(law, own.slow, disturbance=slip)
        left.append(distance_of(run)[(run.t > 2) & (run.t < 11)].max())
    assert left[0] < 1e-4 < 5e-4 < min(left[1:])


# --- discs, horizons, failures -------------------------------------------------------------------


def test_a_dear_slack_keeps_out_exactly_and_a_cheap_one_does_not(own):
    entered = []
    for price in (0.003, 0.03, 100.0):
        run = own.drive(replace(own.mpc, obstacles=own.barred, keep_out=price), own.line)
        clearance = fs.metrics.tracking(run, own.barred)["clearance_m"]
        entered.append(1000 * max(0, own.robot.radius - clearance))
    assert entered[0] > entered[1] > 1e-3 > entered[2]


@pytest.mark.parametrize("horizon", [2, 4])
def test_the_eigenvalues_are_the_growth_of_a_small_error(own, horizon):
    # Far below all limits, on a straight line at the speed that the lesson takes.
    path = fs.Path([fs.Line((0, 0), (3.0, 0))])
    straight = fs.make_reference(path, own.robot, 0.5, 2.0)
    radius = own.radii["$q_N=10$"][horizon - 1]
    assert (radius > 1) == (horizon == 2)
    tracker = fs.Mpc(horizon)
    plain, moved = (
        own.drive(tracker, straight, (0, side, 0)).pose[1, 20:100] for side in (0, 1e-7)
    )
    apart = np.abs(moved - plain)
    steps = 40
    grown = (apart[steps : steps + 20].max() / apart[:20].max()) ** (1 / steps)
    assert grown == pytest.approx(radius, rel=0.05)


def test_all_horizons_are_stable_before_the_endless_rest(own):
    endless = own.radii["the endless rest"]
    assert np.ptp(endless) < 1e-6
    assert max(endless) < 1
    for radii in own.radii.values():
        assert radii[0] > 1 or radii is endless
        assert radii[-1] == pytest.approx(endless[-1], rel=0.02)


def test_the_active_set_method_gives_up_and_the_other_one_does_not(own):
    failures = own.solved.count(False)
    # About one in a hundred; none of so many would be a wonder.
    assert 1 <= failures < len(own.solved) / 10
    assert len(own.rescued) == failures
    assert all(own.rescued)


def test_a_rescued_plan_is_the_best_one(own):
    # Where both solvers find one, it is the same: the rescue is no other problem.
    rows = own.preview(own.fast, own.robot, own.dt, 0.5, 20).T
    state = rows[2:, 0] + [-0.005, 0.005, 0.1, 0, 0]
    task = own.programme(state, rows, rows)
    quick = own.quick(x0=ca.vec(ca.DM(rows)), **task)
    safe = own.safe(**task)
    assert own.quick.stats()["success"]
    assert np.abs(np.array(quick["x"] - safe["x"])).max() < 1e-5


def test_too_few_iterations_raise_or_brake(own):
    hasty = replace(own.mpc, solver="piqp", iterations=5)
    with pytest.raises(fs.SolverFailed):
        own.drive(hasty, own.slow, own.offset)
    brake = replace(own.mpc, solver="piqp", iterations=11, on_failure="brake")
    with pytest.warns(RuntimeWarning, match="braking") as caught:
        stopped = own.drive(brake)
    speeds = np.abs(stopped.wheels[:, :-1])
    last = speeds.shape[1] - len(caught)  # it fails from here on
    assert last > 0
    assert speeds[:, last - 1].min() > 0.1
    slower = np.maximum(speeds[:, last - 1 : -1] - own.a_max * own.dt, 0)
    np.testing.assert_allclose(speeds[:, last:], slower, rtol=0, atol=1e-12)
    assert speeds[:, -1].max() == 0


# --- solutions -----------------------------------------------------------------------------------


def test_heading_hardly_matters_for_arriving_and_calms_the_wheels(own):
    with_it, without = (
        fs.metrics.tracking(own.drive(replace(own.mpc, heading=weight), own.slow, own.offset))
        for weight in (own.mpc.heading, 1e-6)
    )
    assert abs(without["settling_time_s"] - with_it["settling_time_s"]) < 2 * own.dt
    assert without["wheel_variation_m_s"] > 1.05 * with_it["wheel_variation_m_s"]


def test_slip_leaves_the_predicted_error(own):
    gains, slip = fs.SlidingMode(), fs.Disturbance(slip=0.05)
    predicted = 0.1 * (1 / (1 - 0.05) - 1) * gains.phi1 / gains.k1
    rms, behind = [], []
    for tracker in (gains, own.mpc):
        run = own.drive(tracker, own.slow, disturbance=slip)
        behind.append(run.error[0, (run.t > 4) & (run.t < 6)].mean())
        rms.append(fs.metrics.tracking(run)["position_rms_m"])
    assert behind[0] == pytest.approx(predicted, rel=0.02)
    assert rms[1] < rms[0] / 2
    assert behind[1] > 1e-4


def test_between_the_steps_it_enters_less_than_the_bound():
    solved = definitions(f"solutions/{STEM}", "depths", "bound", "ends", "swings", "clear")
    assert solved["depths"][0] < 1e-6
    assert 0 < max(solved["depths"]) < solved["bound"]
    # Dead ahead it stops in front; a centimetre aside it swings round.
    radius = fs.KheperaIV().radius
    assert solved["ends"] == pytest.approx([0.6 - 0.1 - radius, 1.2], abs=1e-4)
    assert solved["swings"][0] < 1e-9
    assert solved["swings"][1] > 0.1
    assert min(solved["clear"]) > -1e-6
