"""Notebook 18: margins close the doors that they should, and tolerances open no wall."""

import numpy as np
import shapely
from lessons import lesson
from matplotlib.figure import Figure
from numpy.testing import assert_allclose

STEM = "18_plan_in_your_own_map"
#: Widths of the meeting room's own door and of all others (m), as data/README.md gives them.
OWN_DOOR, OTHER_DOORS = 0.7, 0.9


def test_a_margin_closes_the_doors_that_are_narrower():
    world, ways, robot = lesson(STEM, "world", "ways", "robot")
    own_door = shapely.box(10.0, 3.6, 10.7, 3.8)
    assert {None} < set(ways.values())
    for margin, way in ways.items():
        gap = robot.diameter + margin
        assert (way is None) == (gap > OTHER_DOORS)
        if way:
            line = shapely.LineString(way.sample(0.01))
            assert line.intersects(own_door) == (gap <= OWN_DOOR)
            # Kept to half the margin on either side.
            assert way.clearance(world) >= robot.radius + margin / 2 - 1e-6
    lengths = [way.length for way in ways.values() if way]
    assert lengths == sorted(lengths)


def test_no_page_shows_a_way_where_there_is_none():
    draw, ways = lesson(STEM, "draw_way", "world", "ways")[::2]
    labels = {}
    for margin, way in ways.items():
        draw(figure := Figure(), margin)
        labels[way is None] = set(figure.axes[0].get_legend_handles_labels()[1])
    assert labels[True] < labels[False]


def test_tolerances_only_ever_add_rock():
    caves, crossings = lesson(STEM, "cave", "caves", "crossings", "dig_cave")[1:3]
    exact, *simpler = (shapely.union_all(cave.cores) for cave in caves.values())
    assert len(simpler) == 3
    for rock in simpler:
        assert exact.difference(rock).area < 1e-6
    corners = [sum(map(len, cave.corners)) for cave in caves.values()]
    assert corners == sorted(corners, reverse=True)
    lengths = [crossing.length for crossing in crossings.values()]
    assert min(lengths) == crossings[0].length


def test_the_commands_handed_over_drive_the_robot_to_the_goal():
    commands, way_points, handed, own, robot, goal, origin = lesson(
        STEM, "commands", "way_points", "handed", "own", "robot", "goal", "origin"
    )
    t, x, y, yaw, v, omega = commands.T
    pose = np.array([x[0], y[0], yaw[0]])
    assert_allclose(pose[:2], 0, atol=1e-9)
    # As a robot would drive them: each pair until the next one.
    for step, command in zip(np.diff(t), zip(v, omega, strict=True), strict=False):
        pose = robot.move(pose, robot.to_wheels(*command), step)
    assert_allclose(pose[:2], goal + origin, atol=0.1)
    assert np.abs(robot.to_wheels(v, omega)).max() <= robot.max_wheel_speed
    assert np.hypot(*np.diff(way_points, axis=0).T).max() <= 0.5 + 1e-9
    assert_allclose(way_points[[0, -1]], [(0, 0), goal + origin])
    assert handed.path.clearance(own) >= robot.radius
