import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.path import Line
from freeseg.simulate import Run

T = np.array([0.0, 0.5, 1.0, 1.5])


def make_run(x_e, y_e=0.0, alpha_e=0.0, wheels=0.0):
    """A run with these errors, one robot or a batch; its poses do not matter here."""
    x_e = np.asarray(x_e, float)
    error = np.stack(np.broadcast_arrays(x_e, y_e, alpha_e))
    wheels = np.broadcast_to(wheels, (2, *x_e.shape))
    pose = np.zeros_like(error)
    wanted = np.zeros((3, len(T)))
    return Run(T, pose, wheels, fs.KheperaIV(), pose, wheels, wanted, error)


def test_planning_of_case_16b(tables):
    world = tables[1]
    plan = fs.plan(world, (0.4, 0), (0.8, 0.5))
    numbers = fs.metrics.planning(world, plan)
    assert numbers["length_m"] == plan.path.length
    # The path touches its dangerous circles: R_D = 70.4 mm + 5 mm / 2 off the discs.
    assert numbers["clearance_m"] == pytest.approx(0.0729)
    assert numbers["turns"] == 2
    assert (numbers["safe_segments"], numbers["danger_segments"]) == (6, 0)
    assert numbers["repairs"] == 1


def test_planning_of_a_straight_way():
    # By hand: two discs 120 mm apart, too close to pass between, and a line beside them.
    world = fs.World([fs.Disc((0, 0), 0.04), fs.Disc((0.2, 0), 0.04)])
    numbers = fs.metrics.planning(world, fs.plan(world, (-0.5, 0.3), (0.5, 0.3)))
    assert numbers == {
        "length_m": pytest.approx(1),
        "clearance_m": pytest.approx(0.26),
        "turns": 0,
        "safe_segments": 0,
        "danger_segments": 1,
        "repairs": 0,
    }


def test_repairs_are_the_steps_after_the_first_search(cases, tables):
    for case in cases.values():
        plan = fs.plan(tables[case.table], case.start, case.goal)
        repairs = fs.metrics.planning(tables[case.table], plan)["repairs"]
        assert repairs == sum(step.kind not in {"straight", "turning point"} for step in plan.steps)


def test_tracking_errors_by_hand():
    numbers = fs.metrics.tracking(
        make_run([0.03, 0, 0, -0.003], [-0.04, 0.005, 0, 0.004], [0.3, -0.4, 0, 0])
    )
    assert numbers["position_rms_m"] == pytest.approx(np.sqrt(0.05**2 + 2 * 0.005**2) / 2)
    assert numbers["position_max_m"] == pytest.approx(0.05)
    assert numbers["position_final_m"] == pytest.approx(0.005)
    assert numbers["heading_rms_rad"] == pytest.approx(0.25)
    assert numbers["heading_final_rad"] == 0
    assert numbers["settling_time_s"] == 0.5
    assert all(isinstance(value, float) for value in numbers.values())


def test_the_final_heading_error_is_an_amount():
    numbers = fs.metrics.tracking(make_run(np.zeros(4), alpha_e=[0, 0, 0, -0.2]))
    assert numbers["heading_final_rad"] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("x_e", "settling"),
    [
        ([0, 0, 0, 0], 0),
        ([0.009, -0.009, 0.009, -0.009], 0),
        ([0.02, 0.009, 0.009, 0.009], 0.5),
        ([0.02, 0.009, 0.011, 0.009], 1.5),  # it counts from when it stays
        ([0.009, 0.009, -0.011, 0.009], 1.5),
        ([0.02, 0.02, 0.02, 0.02], np.inf),
        ([0.009, 0.009, 0.009, 0.02], np.inf),  # leaves at the end
        ([0.02, 0.02, 0.02, 0.01], np.inf),  # 10 mm is not below 10 mm
    ],
)
def test_settling_time(x_e, settling):
    assert fs.metrics.tracking(make_run(x_e))["settling_time_s"] == settling


def test_wheel_numbers_by_hand():
    wheels = [[0.1, 0.3, 0.3, 0.2], [0.2, 0.2, -0.4, -0.4]]
    numbers = fs.metrics.tracking(make_run(np.zeros(4), wheels=wheels))
    assert numbers["wheel_speed_max_m_s"] == pytest.approx(0.4)
    assert numbers["wheel_acceleration_max_m_s2"] == pytest.approx(0.6 / 0.5)
    # From rest: right 0.1 + 0.2 + 0 + 0.1, left 0.2 + 0 + 0.6 + 0.
    assert numbers["wheel_variation_m_s"] == pytest.approx(0.8)


def test_the_first_step_from_rest_is_an_acceleration():
    numbers = fs.metrics.tracking(make_run(np.zeros(4), wheels=0.5))
    assert numbers["wheel_acceleration_max_m_s2"] == pytest.approx(1)
    assert numbers["wheel_variation_m_s"] == pytest.approx(0.5)


def test_a_batch_gives_the_numbers_of_its_runs():
    rng = np.random.default_rng(61)
    error, wheels = rng.normal(0, 0.01, (3, 5, 4)), rng.normal(0, 1, (2, 5, 4))
    error[:2, 0] = 0.02
    error[:2, 1] = 0.001
    batch = fs.metrics.tracking(make_run(*error, wheels=wheels))
    assert batch["settling_time_s"][0] == np.inf
    assert batch["settling_time_s"][1] == 0
    for name, values in batch.items():
        assert values.shape == (5,)
        single = [
            fs.metrics.tracking(make_run(*error[:, number], wheels=wheels[:, number]))[name]
            for number in range(5)
        ]
        assert_array_equal(values, single)


def test_clearance_by_hand():
    # Along the x axis past a disc to the left, and a second robot 1 m further to the right.
    pose = np.zeros((3, 2, 4))
    pose[0] = [0, 1, 2, 3]
    pose[1, 1] = -1
    wheels, error = np.zeros((2, 2, 4)), np.zeros((3, 2, 4))
    run = Run(T, pose, wheels, fs.KheperaIV(), pose, wheels, np.zeros((3, 4)), error)
    world = fs.World([fs.Disc((2, 1), 0.25), fs.Disc((9, 9), 1)])
    assert_allclose(fs.metrics.tracking(run, world)["clearance_m"], [0.75, 1.75])
    assert_array_equal(fs.metrics.tracking(run, fs.World([]))["clearance_m"], [np.inf, np.inf])
    assert "clearance_m" not in fs.metrics.tracking(run)


def test_clearance_below_zero_tells_a_collision():
    run = make_run(np.zeros(4))
    clearance = fs.metrics.tracking(run, fs.World([fs.Disc((0.1, 0), 0.3)]))["clearance_m"]
    assert clearance == pytest.approx(-0.2)
    assert isinstance(clearance, float)


def test_tracking_of_a_simulated_run(tables, cases, robot):
    plan = fs.plan(tables[1], cases["15a"].start, cases["15a"].goal)
    reference = fs.make_reference(plan.path, robot)
    run = fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=(-0.02, 0.03, 0.3))
    numbers = fs.metrics.tracking(run)
    assert numbers["position_max_m"] >= np.hypot(0.02, 0.03)
    assert 0 < numbers["settling_time_s"] < reference.duration
    assert numbers["wheel_speed_max_m_s"] <= robot.max_wheel_speed
    assert numbers["wheel_acceleration_max_m_s2"] <= robot.max_wheel_acceleration * (1 + 1e-12)
    assert_allclose(numbers["position_final_m"], np.hypot(*run.error[:2, -1]))


def test_errors_along_and_across_by_hand():
    # The robot looks 90 degrees to the right of the reference: what is ahead of it is to the
    # right of the reference's heading, what is to its left is ahead of the reference's robot.
    run = make_run([0.03] * 4, [0.04] * 4, np.pi / 2)
    numbers = fs.metrics.tracking(run)
    assert numbers["along_track_rms_m"] == pytest.approx(0.04)
    assert numbers["cross_track_rms_m"] == pytest.approx(0.03)


def test_along_and_across_make_the_position():
    error = np.random.default_rng(62).normal(0, 1, (3, 5, 4))
    numbers = fs.metrics.tracking(make_run(*error))
    squares = numbers["along_track_rms_m"] ** 2 + numbers["cross_track_rms_m"] ** 2
    assert_allclose(squares, numbers["position_rms_m"] ** 2, rtol=1e-12)


def test_across_is_the_distance_from_a_straight_path(robot):
    # Along the x axis the distance from the path is y, however the robot is turned.
    path = fs.plan(fs.World([]), (0, 0), (1, 0)).path
    run = fs.simulate(fs.SlidingMode(), fs.make_reference(path), initial_offset=(-0.02, 0.03, 1.0))
    numbers = fs.metrics.tracking(run)
    assert numbers["cross_track_rms_m"] == pytest.approx(np.sqrt((run.pose[1] ** 2).mean()))


def test_effort_by_hand():
    wheels = [[0.1, 0.3, 0.3, 0.2], [0.2, 0.2, -0.4, -0.4]]
    numbers = fs.metrics.tracking(make_run(np.zeros(4), wheels=wheels))
    squares = [0.1**2, 0.2**2, 0, 0.1**2, 0.2**2, 0, 0.6**2, 0]
    effort = np.sqrt(np.mean(squares)) / 0.5
    assert numbers["wheel_acceleration_rms_m_s2"] == pytest.approx(effort)


def test_share_at_a_limit_by_hand(robot):
    most, fastest = robot.max_wheel_acceleration * 0.5, robot.max_wheel_speed
    # As fast as it gets for one time (one wheel), then braked as hard as it gets for another.
    asked = np.array([[0.1, fastest, fastest - most, 0], [0.1, 0.1, 0.1, 0.1]])
    assert np.all(np.abs(np.diff(asked)) < most * 1.0001)
    run = make_run(np.zeros(4), wheels=asked)
    assert fs.metrics.tracking(run)["limited_share"] == 0.5
    assert fs.metrics.tracking(make_run(np.zeros(4), wheels=0.1))["limited_share"] == 0


def test_share_at_a_limit_of_a_run_with_lag(tables, robot):
    # What counts is what the motors are asked for: with lag they change less than they may.
    reference = fs.make_reference(fs.plan(tables[1], (0, 0), (0.75, 0.75)).path)
    tracker = fs.SlidingMode(switching="sign", k2=40.0)
    for lag in (0.0, 0.05):
        run = fs.simulate(tracker, reference, disturbance=fs.Disturbance(lag=lag))
        assert fs.metrics.tracking(run)["limited_share"] > 0.5
        assert (run.asked is run.wheels) == (lag == 0)
    run = fs.simulate(fs.SlidingMode(), reference)
    assert fs.metrics.tracking(run)["limited_share"] == 0


def test_a_part_of_a_run_by_hand():
    run = make_run([0.03, 0, 0, -0.02], wheels=[[0.1, 0.3, 0.3, 0.2], [0.2, 0.2, -0.4, -0.4]])
    late = fs.metrics.tracking(run, fs.World([]), since=1.0)
    assert late["position_rms_m"] == pytest.approx(np.sqrt(0.02**2 / 2))
    assert late["wheel_variation_m_s"] == pytest.approx(0.6)  # the step to that time counts
    early = fs.metrics.tracking(run, until=1.0)
    assert early["position_max_m"] == 0.03
    assert early["wheel_variation_m_s"] == pytest.approx(0.3)
    assert early["settling_time_s"] == late["settling_time_s"] == np.inf


@pytest.mark.parametrize(
    ("since", "until"), [(2, np.inf), (0, 0), (1, 1), (1.5, 1), (np.nan, 1), (0, np.nan)]
)
def test_a_part_without_times_is_refused(since, until):
    with pytest.raises(fs.InvalidParameter, match="give times"):
        fs.metrics.tracking(make_run(np.zeros(4)), since=since, until=until)


def test_a_run_after_no_reference_has_no_tracking_numbers():
    run = fs.drive(lambda t, pose: (0.1, 0.0), (0, 0, 0), 0.05, 10)
    with pytest.raises(fs.InvalidParameter, match="followed no reference"):
        fs.metrics.tracking(run)


def test_settled_can_ask_for_the_heading_too(robot):
    reference = fs.make_reference(fs.Path([Line((0, 0), (1, 0))]))
    run = fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=(0, 0, 1.0))
    any_heading = fs.metrics.tracking(run)["settling_time_s"]
    near = fs.metrics.tracking(run, settled_heading=0.05)["settling_time_s"]
    assert any_heading < near < np.inf
    heading = np.abs(run.error[2])
    assert heading[run.t >= near].max() <= 0.05 < heading[run.t < near][-1]
    for wrong in (0, -1, None, "0.1", np.nan):
        with pytest.raises(fs.InvalidParameter, match="settled_heading is"):
            fs.metrics.tracking(run, settled_heading=wrong)
