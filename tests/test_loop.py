"""The closed loop beside laws that misbehave: they harm nothing, or are refused by name."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Arc, Line
from freeseg.reference import Reference

DRIVEN = fs.Path([Line((0, 0), (0.2, 0)), Arc((0.2, 0.1), 0.1, -np.pi / 2, 1.0)])


@pytest.fixture(scope="module")
def reference():
    return fs.make_reference(DRIVEN)


class By:
    """A tracker whose law is a function of time and pose."""

    def __init__(self, law):
        self.law = law

    def start(self, reference, robot, dt):
        return self.law


def test_a_law_that_writes_into_its_pose_moves_no_robot(reference):
    def carries(t, pose):
        pose[0] += 0.01
        return 0.0, 0.0

    for offset in ((0, 0, 0), np.zeros((3, 2))):
        run = fs.simulate(By(carries), reference, initial_offset=offset)
        assert_array_equal(run.pose, np.broadcast_to(run.pose[..., :1], run.pose.shape))
        assert_array_equal(run.measured, run.pose)


def test_a_pose_that_was_kept_does_not_change_later(reference):
    kept = []

    def keeps(t, pose):
        kept.append((pose, pose.copy()))
        return 0.05, 0.1

    fs.simulate(By(keeps), reference)
    for pose, copy in kept:
        assert_array_equal(pose, copy)


def test_a_tracker_cannot_write_into_its_reference(reference):
    class Spoils:
        def start(self, reference, robot, dt):
            reference.pose[:] = 0

    before = reference.pose.copy()
    with pytest.raises(ValueError, match="read-only"):
        fs.simulate(Spoils(), reference)
    assert_array_equal(reference.pose, before)
    for name in ("t", "pose", "v", "omega", "v_dot", "omega_dot"):
        assert not getattr(reference, name).flags.writeable


def test_a_reference_leaves_the_arrays_that_it_was_made_of_alone():
    t, zeros = np.array([0.0, 1.0]), np.zeros(2)
    made = Reference(t, np.zeros((3, 2)), zeros, zeros, zeros, zeros)
    t[1] = 7
    assert t.flags.writeable
    assert made.duration == 1


def test_the_arrays_of_a_run_are_read_only(reference):
    for offset in ((0, 0, 0), np.zeros((3, 2))):
        noisy = fs.Disturbance(position_noise=0.001, lag=0.03)
        for disturbance in (None, noisy):
            run = fs.simulate(
                fs.SlidingMode(), reference, initial_offset=offset, disturbance=disturbance
            )
            for name in ("t", "pose", "reference", "error", "wheels", "measured", "asked"):
                assert not getattr(run, name).flags.writeable, name


@pytest.mark.parametrize(
    "command",
    [
        (np.nan, 0.0),
        (0.0, np.inf),
        (0.1, None),
        None,
        0.1,
        (0.1,),
        (0.1, 0.1, 0.1),
        "v",
        ("0.1", "0.1"),
        (0.1 + 1j, 0.0),
        ([0.1, 0.1], [0.0, 0.0]),
        {"v": 0.1, "omega": 0.0},
        (10**400, 0),
    ],
    ids=str,
)
def test_what_is_no_command_is_refused_with_its_time(reference, command):
    def breaks(t, pose):
        return command if t > 0.12 else (0.1, 0.0)

    with pytest.raises(fs.InvalidParameter, match=r"at 0\.150 s.*give v and omega") as caught:
        fs.simulate(By(breaks), reference)
    assert "breaks" in str(caught.value)
    with pytest.raises(fs.InvalidParameter, match=r"at 0\.150 s.*give v and omega"):
        fs.simulate(By(breaks), reference, initial_offset=np.zeros((3, 3)))


@pytest.mark.parametrize(
    "command", [(np.zeros(2), 0.0), (0.0, np.zeros(4)), (np.zeros((2, 3)), 0), (0, [0, 0, np.nan])]
)
def test_commands_for_another_batch_are_refused(reference, command):
    with pytest.raises(fs.InvalidParameter, match=r"at 0\.000 s"):
        fs.simulate(By(lambda t, pose: command), reference, initial_offset=np.zeros((3, 3)))


@pytest.mark.parametrize("command", [(0.1, 0.2), [np.float32(0.1), 0.2], np.array([0.1, 0.2])])
def test_commands_in_another_dress_are_taken(reference, command):
    one = fs.simulate(By(lambda t, pose: command), reference)
    three = fs.simulate(By(lambda t, pose: command), reference, initial_offset=np.zeros((3, 3)))
    assert_allclose(
        one.wheels[:, 1:-1], fs.KheperaIV().to_wheels(0.1, 0.2)[:, None] + one.t[1:-1] * 0
    )
    for k in range(3):
        assert_array_equal(three.pose[:, k], one.pose)


@pytest.mark.parametrize("law", [None, 3, "law", (0.1, 0.0)])
def test_what_is_no_law_is_refused(reference, law):
    with pytest.raises(fs.InvalidParameter, match="law is"):
        fs.simulate(By(law), reference)
    with pytest.raises(fs.InvalidParameter, match="law is"):
        fs.drive(law, (0, 0, 0), 0.05, 3)


def test_an_error_of_the_law_s_own_comes_through(reference):
    def fails(t, pose):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        fs.simulate(By(fails), reference)


def test_driving_needs_no_reference(robot):
    run = fs.drive(lambda t, pose: (0.1, 0.5), (1, 2, 0), 0.1, 20)
    assert run.reference is None
    assert run.error is None
    assert_allclose(run.wheels, np.tile(robot.to_wheels(0.1, 0.5)[:, None], len(run.t)))
    assert_allclose(np.hypot(run.pose[0] - 1, run.pose[1] - 2.2), 0.2)
    two = fs.drive(lambda t, pose: (0.1, [0.5, -0.5]), np.ones((3, 2)), 0.1, 20)
    assert two.pose.shape == (3, 2, 21)
    with pytest.raises(fs.InvalidParameter, match="reference"):
        fs.metrics.tracking(run)


@pytest.mark.parametrize("steps", [0, -1, 2.5, None, True, 10**8])
def test_steps_that_make_no_sense(steps):
    with pytest.raises(fs.InvalidParameter, match="steps is"):
        fs.drive(lambda t, pose: (0, 0), (0, 0, 0), 0.05, steps)


def test_a_delay_longer_than_the_run_is_rest(robot):
    late = fs.Disturbance(delay=1e6)
    run = fs.drive(lambda t, pose: (0.1, 0.5), (1, 2, 0), 0.1, 20, disturbance=late)
    assert_array_equal(run.wheels, 0)


def test_a_time_step_in_single_precision_with_a_delay(reference):
    run = fs.simulate(
        fs.SlidingMode(), reference, dt=np.float32(0.05), disturbance=fs.Disturbance(delay=0.05)
    )
    assert run.t[1] == pytest.approx(0.05)


def test_what_is_no_tracker_is_told_what_it_seems_to_be(reference):
    tuned = fs.studies.tuning.load_gains()["Pid"][0]
    for tracker, remedy in (
        (tuned, "give its .tracker"),
        (lambda t, pose: (0, 0), r"fs\.drive\(law, pose, dt, steps\)"),
        (fs.Pid, r"give one, such as SlidingMode\(\)"),
    ):
        with pytest.raises(fs.InvalidParameter, match=f"^tracker is .*{remedy}"):
            fs.simulate(tracker, reference)


def test_a_tracker_that_cannot_start_is_told_what_start_takes(reference):
    class Short:
        def start(self, reference):
            return lambda t, pose: (0, 0)

    class Fails:
        def start(self, reference, robot, dt):
            return None + dt

    for tracker in (Short(), Fails()):
        with pytest.raises(fs.InvalidParameter, match=r"start\(reference, robot, dt\)") as caught:
            fs.simulate(tracker, reference)
        # Where it happened is still there.
        assert isinstance(caught.value.__cause__, TypeError)


def test_laws_of_other_arguments_are_refused_before_they_are_asked(reference):
    with pytest.raises(fs.InvalidParameter, match=r"law is .* give law"):
        fs.drive(lambda t: (0, 0), (0, 0, 0), 0.05, 3)
    with pytest.raises(fs.InvalidParameter, match="stop is"):
        fs.drive(lambda t, pose: (0, 0), (0, 0, 0), 0.05, 3, stop=lambda t: True)


@pytest.mark.parametrize("bad", [{"reference": "there"}, {"dt": -1}])
@pytest.mark.parametrize("name", fs.trackers.__all__)
def test_trackers_started_by_hand_check_what_they_follow(reference, name, bad):
    given = {"reference": reference, "robot": None, "dt": 0.05} | bad
    with pytest.raises(fs.InvalidParameter, match=f"{next(iter(bad))} is"):
        getattr(fs, name)().start(**given)
