import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

import freeseg as fs
from freeseg.data import DATA, read_csv

DT = 0.05
speeds = st.floats(-1, 1)


def random_motions(rng, n):
    """Poses (3, n) and wheel speeds (2, n)."""
    return rng.uniform(-3, 3, (3, n)), rng.uniform(-1, 1, (2, n))


def test_defaults_stand_in_the_data_file(robot):
    published = {
        row["parameter"]: row["value"]
        for row in read_csv(DATA / "khepera4.csv", {"parameter": str, "value": float})
    }
    for name in ("wheel_base", "diameter", "wheel_radius"):
        assert getattr(robot, name) == pytest.approx(published.pop(name) / 1000)
    for name, value in published.items():
        assert getattr(robot, name) == value


def test_defaults_are_the_published_numbers(robot):
    assert robot.wheel_base == pytest.approx(0.1054)
    assert robot.diameter == pytest.approx(0.1408)
    assert robot.radius == pytest.approx(0.0704)
    assert robot.max_wheel_speed == pytest.approx(1.0, abs=0.005)
    assert robot.max_wheel_acceleration == pytest.approx(2.74, abs=0.005)


@pytest.mark.parametrize(
    "name",
    ["wheel_base", "diameter", "wheel_radius", "max_wheel_rate", "max_wheel_rate_change"],
)
@pytest.mark.parametrize("value", [0, -0.1, np.nan, np.inf, None, "wide", (1, 2)])
def test_invalid_parameter(name, value):
    with pytest.raises(fs.InvalidParameter, match=f"robot.{name} is "):
        fs.KheperaIV(**{name: value})


@pytest.mark.parametrize(
    ("wheel_base", "diameter"), [(0.34, 0.3), (24, 0.3), (0.3001, 0.3), (np.float64(2), 1)]
)
def test_wheels_outside_the_disc_are_refused(wheel_base, diameter):
    named = (
        rf"robot\.wheel_base is {wheel_base:g} m, .*{diameter:g} m.*covers the wheels.*from_foot"
    )
    for make in (fs.Robot, fs.KheperaIV):
        with pytest.raises(fs.InvalidParameter, match=named):
            make(wheel_base, diameter, 0.07, 10, 20)
    square = diameter / np.sqrt(8) * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    with pytest.raises(fs.InvalidParameter, match=named):
        fs.Robot.from_footprint(
            square,
            wheel_base=wheel_base,
            wheel_radius=0.07,
            max_wheel_rate=10,
            max_wheel_rate_change=20,
        )


def test_wheels_may_stand_on_the_rim():
    # But for round-off: 0.1 + 0.2 is a little more than 0.3.
    for wheel_base in (0.3, 0.1 + 0.2):
        assert fs.Robot(wheel_base, 0.3, 0.07, 10, 20).wheel_base == wheel_base


def test_a_robot_that_turns_as_if_its_wheels_stood_outside_may_drive(robot):
    # The error stands for all that makes it turn more slowly; its body stays as it is.
    error = 2 * robot.diameter / robot.wheel_base - 1
    plant = fs.Disturbance(wheel_base_error=error).plant(robot)
    assert plant.wheel_base == pytest.approx(2 * robot.diameter)
    assert plant.diameter == robot.diameter
    assert_allclose(plant.to_body((0.1, 0))[1], 0.1 / (2 * robot.diameter))


def test_a_number_as_text_is_refused_or_understood():
    # Accepted as it stands, it would only fail later, in the first calculation.
    try:
        radius = fs.KheperaIV(diameter="0.14").radius
    except fs.InvalidParameter:
        return
    assert radius == pytest.approx(0.07)


def test_wheels_by_hand():
    robot = fs.KheperaIV(wheel_base=0.1)
    assert_allclose(robot.to_wheels(0.2, 0), (0.2, 0.2))
    assert_allclose(robot.to_wheels(0, 2), (0.1, -0.1))  # to the left: the right wheel forward
    assert_allclose(robot.to_body((0.3, 0.1)), (0.2, 2))


def test_any_differential_drive_plans_and_drives():
    world = fs.load_table(1)
    outline = np.array([(0.05, 0.04), (-0.03, 0.04), (-0.03, -0.04), (0.05, -0.04)])
    sizes = {"wheel_base": 0.07, "wheel_radius": 0.02, "max_wheel_rate": 30}
    robot = fs.Robot.from_footprint(outline, max_wheel_rate_change=100, **sizes)
    assert robot.radius == pytest.approx(np.hypot(0.05, 0.04))
    plan = fs.plan(world, (0, 0), (0.75, 0.75), robot)
    run = fs.simulate(fs.SlidingMode(), fs.make_reference(plan, speed=0.1))
    assert run.robot is plan.robot is robot
    # Turned by any heading on the way, the body stays off the obstacles.
    for x, y, heading in run.pose.T[::10]:
        turned = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        body = shapely.Polygon(outline @ turned.T + np.array([x, y]))
        assert world.distances(body).min() > 0


def test_a_footprint_that_is_none_is_refused():
    for outline in [(), [(0, 0)], "box", [(1, np.nan)], [1, 2, 3]]:
        with pytest.raises(fs.InvalidParameter):
            fs.Robot.from_footprint(
                outline,
                wheel_base=0.1,
                wheel_radius=0.1,
                max_wheel_rate=1,
                max_wheel_rate_change=1,
            )


@given(v=speeds, omega=st.floats(-20, 20))
@settings(derandomize=True, deadline=None)
def test_body_to_wheels_and_back(robot, v, omega):
    assert_allclose(robot.to_body(robot.to_wheels(v, omega)), (v, omega), rtol=0, atol=1e-13)


@given(right=speeds, left=speeds)
@settings(derandomize=True, deadline=None)
def test_wheels_to_body_and_back(robot, right, left):
    back = robot.to_wheels(*robot.to_body(np.array([right, left])))
    assert_allclose(back, (right, left), rtol=0, atol=1e-13)


def test_move_solves_equation_1(robot):
    poses, wheels = random_motions(np.random.default_rng(11), 20)
    for pose, (right, left) in zip(poses.T, wheels.T, strict=True):

        def model(t, state, right=right, left=left):
            v = (right + left) / 2
            return v * np.cos(state[2]), v * np.sin(state[2]), (right - left) / robot.wheel_base

        solution = solve_ivp(model, (0, 0.7), pose, method="DOP853", rtol=1e-12, atol=1e-13)
        moved = robot.move(pose, (right, left), 0.7)
        assert_allclose(moved, solution.y[:, -1], rtol=0, atol=1e-9)


def test_move_by_hand():
    robot = fs.KheperaIV(wheel_base=0.1)
    # A quarter turn to the left on a circle of radius 1 m, starting eastwards.
    wheels, time = robot.to_wheels(0.5, 0.5), np.pi
    assert_allclose(robot.move((0, 0, 0), wheels, time), (1, 1, np.pi / 2), atol=1e-14)
    # A turn on the spot, and more than a whole one: the heading is not wrapped.
    assert_allclose(robot.move((1, 2, 0), (0.2, -0.2), 2), (1, 2, 8), atol=1e-14)
    assert_allclose(robot.move((1, 2, np.pi / 2), (0.3, 0.3), 2), (1, 2.6, np.pi / 2))


@pytest.mark.parametrize("omega", [0.0, 1e-300, -1e-16, 1e-12, -1e-9])
def test_move_goes_over_into_a_straight_line(robot, omega):
    moved = robot.move((0.1, 0.2, 0.3), robot.to_wheels(0.5, omega), 2.0)
    straight = (0.1 + np.cos(0.3), 0.2 + np.sin(0.3), 0.3)
    assert_allclose(moved, straight, rtol=0, atol=1e-14 + 2 * abs(omega))


def test_moving_twice_is_moving_for_twice_as_long(robot):
    pose, wheels = random_motions(np.random.default_rng(12), 1000)
    twice = robot.move(robot.move(pose, wheels, DT), wheels, DT)
    assert_allclose(twice, robot.move(pose, wheels, 2 * DT), rtol=0, atol=1e-13)


def test_a_batch_moves_and_saturates_bit_for_bit_as_its_robots(robot):
    rng = np.random.default_rng(13)
    pose, wheels = random_motions(rng, 101)
    previous = rng.uniform(-1, 1, wheels.shape)
    moved, reached = robot.move(pose, wheels, DT), robot.saturate(2 * wheels, previous, DT)
    for n in range(101):
        assert_array_equal(moved[:, n], robot.move(pose[:, n], wheels[:, n], DT))
        assert_array_equal(reached[:, n], robot.saturate(2 * wheels[:, n], previous[:, n], DT))


def test_saturate_keeps_speed_and_acceleration_within_the_limits(robot):
    rng = np.random.default_rng(14)
    driven = np.zeros((2, 500))
    for dt in rng.uniform(0.001, 0.5, 200):
        command = rng.normal(0, 10 ** rng.uniform(-2, 2), driven.shape)
        reached = robot.saturate(command, driven, dt)
        assert np.abs(reached).max() <= robot.max_wheel_speed + 1e-12
        assert np.abs(reached - driven).max() <= robot.max_wheel_acceleration * dt + 1e-12
        driven = reached


def test_saturate_keeps_the_curvature_where_only_the_speed_is_limited(robot):
    command = np.random.default_rng(15).uniform(-50, 50, (2, 1000))
    # In 1 s the motors reach any speed: the acceleration does not matter.
    reached = robot.saturate(command, np.zeros_like(command), 1.0)
    scale = np.abs(command).max(0) / robot.max_wheel_speed
    assert (scale > 1).mean() > 0.9
    assert_allclose(reached, command / np.maximum(scale, 1), rtol=1e-12)


def test_saturate_leaves_what_is_within_the_limits(robot):
    previous = np.random.default_rng(16).uniform(-0.8, 0.8, (2, 1000))
    command = previous + 0.99 * robot.max_wheel_acceleration * DT * np.array([[1], [-1]])
    assert_allclose(robot.saturate(command, previous, DT), command, rtol=0, atol=1e-15)


def test_a_pair_of_wheels_saturates_beside_a_batch(robot):
    # Also beside two robots, where a pair of wheels could be taken for one speed of each.
    for n in (2, 3):
        wheels, previous = np.array([0.3, 0.1]), np.zeros((2, n))
        reached = robot.saturate(wheels, previous, DT)
        assert_array_equal(reached, robot.saturate(np.tile(wheels[:, None], n), previous, DT))
        assert_array_equal(robot.saturate(previous, wheels, DT).shape, (2, n))


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda robot: robot.move((0, 0), (0.1, 0.1), DT), "pose is"),
        (lambda robot: robot.move((0, 0, np.nan), (0.1, 0.1), DT), "pose is"),
        (lambda robot: robot.move((0, 0, 0), (0.1, 0.1), -DT), "dt is -0.05"),
        (
            lambda robot: robot.move(np.zeros((3, 4)), np.zeros((2, 3)), DT),
            r"pose \(4,\) and wheels",
        ),
        (lambda robot: robot.to_body(0.1), "wheels is"),
        (lambda robot: robot.to_body([[1, 2], [3]]), "wheels is"),
        (lambda robot: robot.to_wheels("fast", 0), "v is 'fast'"),
        (lambda robot: robot.to_wheels(0.1, np.inf), "omega is inf"),
        (lambda robot: robot.to_wheels([1, 2], [1, 2, 3]), r"v \(2,\) and omega \(3,\)"),
        (lambda robot: robot.saturate((0.1, 0.1), (0, 0, 0), DT), "previous is"),
        (lambda robot: robot.saturate((0.1, 0.1), (0, 0), -1), "dt is -1"),
    ],
)
def test_what_a_robot_cannot_do_is_named(robot, call, named):
    with pytest.raises(fs.InvalidParameter, match=named):
        call(robot)


def test_a_number_in_place_of_a_robot_is_told_what_it_may_be():
    with pytest.raises(fs.InvalidParameter, match=r"robot is 0.005; .*such as margin=0.005"):
        fs.free_segments(fs.load_table(1), 0.005)


def test_two_robots_are_told_apart_by_what_differs(robot):
    plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    with pytest.raises(fs.InvalidParameter) as caught:
        fs.make_reference(plan, fs.KheperaIV(diameter=0.12))
    assert str(caught.value) == (
        "robot is KheperaIV(diameter=0.12), but the plan is for KheperaIV(diameter=0.1408); "
        "give the same one"
    )
    # Anywhere else, a robot is shown in short.
    with pytest.raises(
        fs.InvalidQuery, match=r"^world is <KheperaIV, 0\.1408 m wide>; give a World"
    ):
        fs.free_segments(robot)


def test_times_may_be_many(robot):
    times, wheels = np.linspace(0, 0.4, 5), (0.3, 0.1)
    moved, reached = robot.move((0, 0, 0), wheels, times), robot.saturate(wheels, (0, 0), times)
    for k, time in enumerate(times):
        assert_array_equal(moved[:, k], robot.move((0, 0, 0), wheels, time))
        assert_array_equal(reached[:, k], robot.saturate(wheels, (0, 0), time))
