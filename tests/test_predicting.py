"""Prediction over delay and lag, and the estimate of slip."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.trackers.predictor import CREEP, SlipObserver

DT = 0.05
#: What the laws are told of: two steps late, and sluggish.
LATE = fs.Disturbance(delay=2 * DT, lag=0.03)
TOLD = {"delay": LATE.delay, "lag": LATE.lag}
#: A lookahead so short that pure pursuit hardly cuts corners.
TRACKERS = [
    fs.FeedbackLinearisation(),
    fs.Fuzzy(),
    fs.Kanayama(),
    fs.Lqr(),
    fs.Pid(),
    fs.PurePursuit(lookahead=0.04),
    fs.SlidingMode(),
    fs.Stanley(),
    fs.SuperTwisting(),
]
every_tracker = pytest.mark.parametrize(
    "tracker", TRACKERS, ids=lambda tracker: type(tracker).__name__
)
LINE = fs.make_reference(fs.Path([Line((0, 0), (3, 0))]))
BENDS = fs.make_reference(
    fs.Path([Line((0, 0), (0.2, 0)), Arc((0.2, 0.2), 0.2, -np.pi / 2, 1.2)]), speed=0.3
)
#: All that may disturb a robot, and late commands.
ALL = replace(
    LATE,
    position_noise=0.001,
    heading_noise=np.radians(0.5),
    slip=0.05,
    slip_fluctuation=0.02,
    wheel_base_error=0.03,
)


@pytest.fixture(scope="module")
def smooth():
    """The paper's case 15(a) with ramps of the curvature."""
    plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    return fs.make_reference(plan, smoothing=0.03)


class Wild:
    """A tracker of random commands, often beyond the limits, that keeps what it sees."""

    def __init__(self, seed, robots=()):
        self.seed, self.robots, self.seen = seed, robots, []

    def start(self, reference, robot, dt):
        rng = np.random.default_rng(self.seed)

        def law(t, pose):
            self.seen.append((t, pose))
            return 0.3 + rng.normal(0, 0.5, self.robots), rng.normal(0, 8, self.robots)

        return law


# --- where the robot will be ---------------------------------------------------------------------


@pytest.mark.parametrize("late", [0, 1, 4])
@pytest.mark.parametrize("robots", [(), (3,)])
def test_without_lag_the_law_sees_the_pose_at_which_its_command_arrives(robot, late, robots):
    wild, delay = Wild(1, robots), late * DT
    run = fs.simulate(
        fs.Predicting(wild, delay),
        LINE,
        robot,
        DT,
        np.zeros((3, *robots)),
        fs.Disturbance(delay=delay),
    )
    times, poses = zip(*wild.seen, strict=True)
    assert_allclose(times, run.t[:-1] + delay)
    # The limits bound what it is about.
    assert np.abs(np.diff(run.wheels)).max() == pytest.approx(robot.max_wheel_acceleration * DT)
    steps = len(run.t) - 1 - late
    assert_allclose(
        np.stack(poses, -1)[..., :steps], run.pose[..., late : late + steps], rtol=0, atol=1e-9
    )


def test_with_lag_it_is_where_a_brute_force_simulation_comes_to(robot):
    # Euler steps of a tenth of a millisecond: speeds decay towards what is asked for, the pose
    # follows; after the delay, the robot goes on at the speed that it has for the lag's time.
    wild, tau, late = Wild(2), 0.08, 2
    disturbance = fs.Disturbance(delay=late * DT, lag=tau)
    run = fs.simulate(
        fs.Predicting(wild, disturbance.delay, tau), BENDS, robot, DT, disturbance=disturbance
    )
    h = 1e-4
    for now in (0, 1, 5, 12, 20):
        speed, pose = np.zeros(2), run.pose[:, now].copy()
        for step, asked in enumerate(run.asked[:, : now + late].T):
            for _ in range(round(DT / h)):
                speed = speed + h * (asked - speed) / tau
                if step >= now:
                    v, omega = robot.to_body(speed)
                    pose += h * np.array([v * np.cos(pose[2]), v * np.sin(pose[2]), omega])
        _, seen = wild.seen[now]
        # The arcs of a step, as those of the loop, have the right length and turn, not the shape.
        assert_allclose(seen, robot.move(pose, speed, tau), rtol=0, atol=2e-3)
        assert seen[2] == pytest.approx(robot.move(pose, speed, tau)[2], abs=0.01)


def test_a_lag_is_in_the_end_one_delay_more(robot):
    # Whatever constant speed is asked for next, the robot ends where the prediction, driven at
    # that speed from its own time on, ends: exactly, on a straight line.
    lag, last = 0.08, 0.15

    class Push:
        seen = None

        def start(self, reference, robot, dt):
            def law(t, pose):
                if self.seen is None and t >= 0.5 + lag:
                    self.seen = t, pose
                return (0.05 if self.seen is None else last), 0.0

            return law

    push = Push()
    disturbance = fs.Disturbance(lag=lag)
    run = fs.simulate(fs.Predicting(push, 0, lag), LINE, robot, DT, disturbance=disturbance)
    t, pose = push.seen
    # Ten seconds on, nothing of the change is left. It takes one step, so no limit acts.
    later = np.searchsorted(run.t, 10.5 - 1e-9)
    expected = pose[0] + last * (run.t[later] - t)
    assert run.pose[0, later] == pytest.approx(expected, abs=1e-9)


@every_tracker
def test_told_of_delay_and_lag_every_law_stays_within_a_millimetre(tracker, smooth, robot):
    told, untold = (
        fs.metrics.tracking(fs.simulate(one, smooth, robot, DT, disturbance=LATE))["position_rms_m"]
        for one in (fs.Predicting(tracker, **TOLD), tracker)
    )
    assert told < 0.001 < untold


def test_a_constant_delay_no_longer_makes_a_steep_gain_unstable(smooth, robot):
    steep = fs.Kanayama(k_x=12, k_y=1000, k_alpha=100)
    told, untold = (
        fs.metrics.tracking(fs.simulate(one, smooth, robot, DT, disturbance=LATE))["position_rms_m"]
        for one in (fs.Predicting(steep, **TOLD), steep)
    )
    assert told < 0.001
    assert untold > 0.01


# --- a wrapper for every law ---------------------------------------------------------------------


@every_tracker
def test_with_nothing_to_predict_it_is_the_tracker(tracker, smooth, robot):
    offset = (-0.02, 0.03, 0.3)
    wrapped, bare = (
        fs.simulate(one, smooth, robot, DT, offset, ALL, 3)
        for one in (fs.Predicting(tracker, 0, 0), tracker)
    )
    assert_array_equal(wrapped.pose, bare.pose)


@every_tracker
def test_a_batch_is_bit_for_bit_its_single_runs(tracker, robot):
    offsets = np.random.default_rng(4).normal(0, [[0.05], [0.05], [0.4]], (3, 12))
    told = fs.Predicting(tracker, **TOLD)
    batch = fs.simulate(told, BENDS, robot, DT, offsets, ALL, seed=9)
    for number, offset in enumerate(offsets.T):
        single = fs.simulate(told, BENDS, robot, DT, offset, ALL, seed=(9, number))
        assert_array_equal(batch.pose[:, number], single.pose)
        assert_array_equal(batch.wheels[:, number], single.wheels)


@pytest.mark.parametrize("robots", [1, 2, 5])
def test_a_batch_may_get_one_command_for_all(robot, robots):
    alone = fs.simulate(fs.Predicting(Wild(5), **TOLD), LINE, robot, DT, disturbance=LATE)
    batch = fs.simulate(
        fs.Predicting(Wild(5), **TOLD), LINE, robot, DT, np.zeros((3, robots)), LATE
    )
    assert_array_equal(batch.pose, np.stack([alone.pose] * robots, 1))


def test_a_run_does_not_see_another(smooth, robot):
    told = fs.Predicting(fs.Pid(), **TOLD)
    law, other = told.start(smooth, robot, DT), told.start(smooth, robot, DT)
    pose = smooth.pose[:, 0]
    for step in range(5):
        other(step * DT, pose + 0.1)
        again = law(step * DT, pose)
    fresh = told.start(smooth, robot, DT)
    for step in range(5):
        once = fresh(step * DT, pose)
    assert_array_equal(again, once)


@pytest.mark.parametrize("bad", [None, (1, 2, 3), (np.nan, 0), "ab"])
def test_what_is_no_command_is_refused_by_the_loop(smooth, robot, bad):
    class Broken:
        def start(self, reference, robot, dt):
            return lambda t, pose: bad

    with pytest.raises(fs.InvalidParameter, match=r"returned .* at 0\.000 s"):
        fs.simulate(fs.Predicting(Broken(), **TOLD), smooth, robot)


@pytest.mark.parametrize("name", ["delay", "lag"])
@pytest.mark.parametrize("value", [-0.05, np.nan, np.inf, None, "0.1", True, (0.1, 0.1)])
def test_invalid_times(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"^{name} is .*zero or more"):
        fs.Predicting(fs.Pid(), **TOLD | {name: value})


@pytest.mark.parametrize("tracker", [None, fs.Pid, "Pid", 3.0, lambda t, pose: (0, 0)])
def test_what_is_no_tracker(tracker):
    with pytest.raises(fs.InvalidParameter, match=r"tracker is .*give one, such as"):
        fs.Predicting(tracker, 0.1)


@pytest.mark.parametrize("tracker", [lambda **told: fs.Predicting(fs.Pid(), **told), fs.Mpc])
def test_times_that_do_not_fit_the_run(tracker, smooth, robot):
    with pytest.raises(fs.InvalidParameter, match=r"delay is 0\.07 s, no whole number of time"):
        tracker(delay=0.07).start(smooth, robot, DT)
    for told in ({"delay": 1e300}, {"delay": 0.1, "lag": 1e300}, {"delay": 11.8, "lag": 1.0}):
        with pytest.raises(fs.InvalidParameter, match=r"the reference lasts 11\.\d+ s; give less"):
            tracker(**told).start(smooth, robot, DT)
    whole = tracker(delay=np.float32(0.5), lag=np.int64(0))
    assert (whole.delay, type(whole.lag)) == (0.5, float)


# --- slip ----------------------------------------------------------------------------------------


def observed(rate, robot, slip, seconds=20.0, noise=0.0, speeds=(0.12, 0.09)):
    """Shares of travel that an observer finds step by step, shape (2, n), and its last pose."""
    observer, rng = SlipObserver(rate, robot, DT), np.random.default_rng(6)
    pose, wheels, found = np.array([1.0, 2.0, 3.0]), np.array(speeds), []
    for _ in range(round(seconds / DT)):
        seen = observer.correct(pose + noise * rng.normal(0, 1, 3), wheels)
        found.append(observer.rolled)
        pose = robot.move(pose, wheels * (1 - np.array(slip)), DT)
    before = robot.move(pose, -wheels * (1 - np.array(slip)), DT)
    return np.transpose(found), seen, before


@pytest.mark.parametrize("slip", [(0.05, 0.05), (0.1, 0.0), (-0.05, 0.2)])
@pytest.mark.parametrize("speeds", [(0.12, 0.09), (-0.2, -0.2), (0.1, -0.1)])
def test_a_constant_slip_is_found(robot, slip, speeds):
    # Forwards in a curve through all headings, backwards, and on the spot.
    found, seen, pose = observed(3, robot, slip, speeds=speeds)
    assert_allclose(found[:, -1], 1 - np.array(slip), atol=1e-6)
    assert_allclose(seen, pose, atol=1e-6)


def test_noise_moves_the_estimate_little_and_a_slow_one_less(robot):
    spread = [observed(rate, robot, (0.05, 0.05), noise=1e-3)[0][:, 200:].std() for rate in (1, 4)]
    assert spread[0] < spread[1] / 3 < 0.01
    assert spread[1] > 0.005


def test_both_poles_lie_at_the_rate(robot):
    # A double pole p at a wrong slip and a right pose leaves (1 + k (1 - p) / p) p^k of the slip
    # after k steps, of which the first brings no difference yet. At a speed well above that at
    # which slip is hardly learned.
    rate, slip = 4.0, 0.1
    found, _, _ = observed(rate, robot, (slip, slip), seconds=3, speeds=(0.5, 0.5))
    left = (found[0] - (1 - slip)) / slip
    k, pole = 1 + np.arange(len(left)), np.exp(-rate * DT)
    assert CREEP < 0.5 / 20
    assert_allclose(left, (1 + k * (1 - pole) / pole) * pole**k, atol=0.01)


def test_standing_wheels_teach_nothing(robot):
    found, _, _ = observed(3, robot, (0, 0), noise=1e-3, speeds=(0, 0))
    assert_array_equal(found, 1)


def test_without_a_rate_poses_are_taken_as_measured(robot):
    observer = SlipObserver(0.0, robot, DT)
    for pose in np.random.default_rng(7).normal(0, 1, (5, 3)):
        assert_array_equal(observer.correct(pose, np.array([0.3, 0.1])), pose)
    assert_array_equal(observer.rolled, 1)
