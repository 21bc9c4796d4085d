"""What lesson 01 shows, against the package and against what it says of it."""

import nbformat
import numpy as np
import pytest
from lessons import lesson
from refresh_notebooks import NOTEBOOKS

STEM = "01_model_the_robot"


@pytest.fixture(scope="module")
def wheels():
    return np.random.default_rng(1).uniform(-1, 1, (2, 1000))  # m/s


def test_equations_1_and_8_are_the_packages_and_undo_each_other(robot, wheels):
    to_body, to_wheels = lesson(STEM, "to_body", "to_wheels")
    v, omega = to_body(*wheels, robot.wheel_base)
    assert np.array_equal(robot.to_body(wheels), (v, omega))
    back = to_wheels(v, omega, robot.wheel_base)
    assert np.array_equal(robot.to_wheels(v, omega), back)
    assert np.allclose(back, wheels, rtol=0, atol=1e-15)


def test_the_exact_step_is_the_packages(robot, wheels):
    move, to_body = lesson(STEM, "move", "to_body")
    poses = np.random.default_rng(2).normal(size=(3, wheels.shape[1]))
    bodies = np.transpose(to_body(*wheels, robot.wheel_base))
    one_by_one = [move(pose, *body, 0.05) for pose, body in zip(poses.T, bodies, strict=True)]
    assert np.allclose(
        robot.move(poses, wheels, 0.05), np.transpose(one_by_one), rtol=0, atol=1e-14
    )
    # Straight on is no special case.
    assert np.array_equal(move((0, 0, 0), 0.1, 0, 2), (0.2, 0, 0))


def test_orders_of_the_methods_are_what_the_text_says():
    errors, orders = lesson(STEM, "errors", "orders", "euler", "drive")[:2]
    assert orders["Euler"] == pytest.approx(1, abs=0.05)
    assert orders["midpoint"] == pytest.approx(2, abs=0.05)
    assert max(errors["exact arc"]) < 1e-12
    assert min(errors["midpoint"]) > 1e-9


def test_euler_ends_outside_and_the_exact_steps_on_the_arc():
    drive, methods, bend = lesson(STEM, "drive", "methods", "bend", "euler")[:3]
    center = (0, bend)
    distances = {
        name: np.hypot(*(drive(method, 4)[:2].T - center).T) for name, method in methods.items()
    }
    assert (distances["Euler"][1:] > bend + 1e-3).all()
    assert np.allclose(distances["exact arc"], bend, rtol=0, atol=1e-15)


def test_pages_of_the_flipbook_say_what_equation_1_says(robot):
    pairs, describe = lesson(STEM, "pairs", "describe", "to_body")[:2]
    assert len(pairs) == len(set(pairs)) == 17
    assert describe(*pairs[8]).endswith("100 mm/s straight on")
    assert describe(*pairs[0]).endswith("round a point 0 mm to the left")
    # A wheel that stands still is the centre of the turn.
    assert describe(*pairs[4]).endswith(
        f"round a point {500 * robot.wheel_base:.0f} mm to the left"
    )


def test_scaling_keeps_the_circle_and_cutting_does_not(robot):
    commands = lesson(STEM, "commands")
    radii = {name: v / omega for name, (v, omega) in commands.items()}
    assert radii["scaled"] == pytest.approx(radii["asked for"])
    assert radii["each wheel cut"] > 1.1 * radii["asked for"]
    fastest = {name: np.abs(robot.to_wheels(*body)).max() for name, body in commands.items()}
    assert fastest["asked for"] > robot.max_wheel_speed
    assert fastest["scaled"] == pytest.approx(robot.max_wheel_speed)
    assert fastest["each wheel cut"] == pytest.approx(robot.max_wheel_speed)


def test_one_step_is_enough_for_the_speed_of_the_later_lessons(robot):
    steps_to, speed = lesson(STEM, "steps_to", "speed", "limit")[:2]
    assert steps_to(speed) == 1
    assert steps_to(robot.max_wheel_speed) > 1


def test_each_symbol_is_named_before_an_equation_uses_it():
    cells = nbformat.read(NOTEBOOKS / f"{STEM}.ipynb", as_version=4).cells
    text = "\n".join(cell.source for cell in cells)
    equations = {number: text.index(rf"\tag{{{number}}}") for number in (1, 8)}
    for sketch, number in (("sketch_pose(", 1), ("sketch_turn(", 1), ("sketch_sum(", 8)):
        assert text.index(sketch) < equations[number]
    for name in ("*pose*", "*heading*", "*wheel base*", "*forward speed*", "*turn rate*"):
        assert text.index(name) < equations[1]
