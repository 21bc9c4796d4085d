"""What lesson 00 claims, of its run and of the package."""

import re

import nbformat
import numpy as np
import pytest
from lessons import definitions, lesson
from refresh_notebooks import NOTEBOOKS

import freeseg as fs

STEM = "00_start_here"


@pytest.fixture(scope="module")
def shown():
    names = ("world", "plan", "run", "planned", "tracked")
    return definitions(STEM, *names)


def test_nothing_is_touched_and_the_goal_is_reached(robot, shown):
    planned, tracked = shown["planned"], shown["tracked"]
    assert min(planned["clearance_m"], tracked["clearance_m"]) >= robot.radius
    assert tracked["position_final_m"] < 0.001
    assert tracked["settling_time_s"] < 3
    # Well below, or the limit would have cut what the law asked for.
    assert tracked["wheel_speed_max_m_s"] < 0.9 * robot.max_wheel_speed


def test_the_left_wheel_is_the_faster_one_at_first(shown):
    run = shown["run"]
    right, left = run.wheels[:, run.t < 0.5 - 1e-9].mean(1)
    assert left > right
    # Left of the path and turned away from it: the path lies to the right.
    assert run.error[1, 0] < 0
    assert run.error[2, 0] < 0


def test_a_dangerous_circle_is_as_much_larger_than_its_disc_as_the_table_says(shown):
    plan, world = shown["plan"], shown["world"]
    for turn in plan.turning_points:
        beyond = turn.radius - world.radii[turn.obstacle]
        assert beyond == pytest.approx(plan.turning_radius)


def test_the_students_own_world_is_driven_without_a_collision(robot):
    mine, my_plan, my_run = lesson(STEM, "mine", "my_plan", "my_run")
    assert my_plan.path.clearance(mine) >= robot.radius
    assert fs.metrics.tracking(my_run, mine)["clearance_m"] >= robot.radius - 1e-4


def test_the_package_is_about_as_long_as_it_says():
    text = "".join(
        cell.source for cell in nbformat.read(NOTEBOOKS / f"{STEM}.ipynb", as_version=4).cells
    )
    assert re.search(r"some thirty thousand\s+lines", text)
    files = (NOTEBOOKS.parent / "freeseg").rglob("*.py")
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    assert np.isclose(lines, 30_000, rtol=0.15)
