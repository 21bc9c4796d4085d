"""What `NoPath` says would pass: worlds of known doors, and the planner as its own oracle."""

import pickle
import re

import numpy as np
import pytest

import freeseg as fs
from freeseg.maps import from_grid
from freeseg.planners import route

ROOM = [(0, 0), (6, 0), (6, 4), (0, 4)]
START, GOAL = (1, 2), (5, 2)


def robot_of(diameter):
    return fs.Robot(0.8 * diameter, diameter, 0.05, 10, 20)


def walls(door=0.26, turned=0.0, scale=1.0, shift=(0, 0)):
    """A room in two with a door of a width (m), turned, scaled and moved."""
    matrix = scale * np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])

    def move(points):
        return np.asarray(points) @ matrix.T + shift

    pieces = [
        fs.Polygon(move([(2.9, low), (3.1, low), (3.1, high), (2.9, high)]))
        for low, high in ((0, 2 - door / 2), (2 + door / 2, 4))
    ]
    return fs.World(pieces, move(ROOM)), move


def refused(planner, *question):
    with pytest.raises(fs.NoPath, match="leave no way") as caught:
        planner(*question)
    return str(caught.value)


def said(message):
    """The largest diameter that a message promises a way to (m), and where it is narrow (m)."""
    diameter, place = re.search(
        r"at most (\S+) m with that margin would pass, between .* near \[(.*)\]$", message
    ).groups()
    return float(diameter), np.array([float(part) for part in place.split(",")])


@pytest.mark.parametrize("planner", [fs.shortest_path, fs.plan])
def test_a_door_of_known_width(planner):
    world, _ = walls(0.26)
    message = refused(planner, world, START, GOAL, robot_of(0.3), 0.05)
    diameter, place = said(message)
    assert diameter == 0.21
    assert "between obstacle 1 and obstacle 2 near" in message
    np.testing.assert_allclose(place, (3, 2), atol=0.101)
    # It keeps its promise, and none that is larger passes.
    fs.shortest_path(world, START, GOAL, robot_of(diameter), 0.05)
    refused(fs.shortest_path, world, START, GOAL, robot_of(diameter + 1e-4), 0.05)


@pytest.mark.parametrize(
    ("turned", "scale", "shift"), [(0.7, 1, (0, 0)), (2, 50, (-3e3, 4e3)), (-1, 0.01, (0, 0.1))]
)
def test_the_same_door_in_any_frame_and_scale(turned, scale, shift):
    world, move = walls(0.26, turned, scale, shift)
    robot, margin = robot_of(0.3 * scale), 0.05 * scale
    diameter, place = said(refused(fs.shortest_path, world, move(START), move(GOAL), robot, margin))
    assert diameter == pytest.approx(0.21 * scale, rel=1e-3)
    np.testing.assert_allclose(place, move((3, 2)), atol=0.12 * scale)


def test_a_closed_room_lets_nobody_out():
    closed = refused(fs.shortest_path, walls(0.0)[0], START, GOAL, robot_of(0.3), 0.05)
    assert closed.endswith("move the start or the goal: no robot would pass, however small")


def test_a_door_narrower_than_the_margin_names_both():
    world, _ = walls(0.04)
    message = refused(fs.shortest_path, world, START, GOAL, robot_of(0.3), 0.05)
    assert "with that one no robot would pass, however small" in message
    assert "may be 0.04 m together at most, between obstacle 1 and obstacle 2" in message
    fs.shortest_path(world, START, GOAL, robot_of(0.035), 0.005)


def test_the_wider_of_two_doors_counts_and_the_narrower_of_two_in_a_row():
    def wall(x, *doors):
        low, parts = 0.0, []
        for begin, end in (*doors, (4, 4)):
            parts.append(fs.Polygon([(x, low), (x + 0.1, low), (x + 0.1, begin), (x, begin)]))
            low = end
        return parts

    two = fs.World([*wall(2, (1, 1.2), (3, 3.25)), *wall(4, (2, 2.23))], ROOM)
    diameter, place = said(refused(fs.shortest_path, two, START, GOAL, robot_of(0.3), 0.0))
    assert diameter == 0.23
    np.testing.assert_allclose(place, (4.05, 2.115), atol=0.06)
    two = fs.World([*wall(2, (1, 1.2), (3, 3.22)), *wall(4, (2, 2.23))], ROOM)
    diameter, place = said(refused(fs.shortest_path, two, START, GOAL, robot_of(0.3), 0.0))
    assert diameter == 0.22
    np.testing.assert_allclose(place, (2.05, 3.11), atol=0.06)


def test_discs_and_one_joined_wall():
    discs = fs.World([fs.Disc((3, y), 0.4) for y in (0, 1.02, 2.0, 3.1, 4)], ROOM)
    diameter, place = said(refused(fs.shortest_path, discs, START, GOAL, robot_of(0.5), 0.1))
    assert diameter == 0.2
    np.testing.assert_allclose(place, (3, 2.55), atol=1e-2)
    cells = np.zeros((40, 60), bool)
    cells[[0, -1], :] = cells[:, [0, -1]] = cells[:, 30] = True
    cells[18:21, 30] = False
    grid = from_grid(cells, 0.1, boundary=False)
    message = refused(fs.shortest_path, grid, START, GOAL, robot_of(0.5), 0.05)
    assert "between two parts of obstacle 1 near" in message
    assert said(message)[0] == 0.25


@pytest.mark.parametrize("seed", range(6))
def test_the_planner_agrees_in_random_worlds(seed):
    rng = np.random.default_rng(seed)
    discs = [fs.Disc(rng.uniform((1.2, 0), (4.8, 4)), rng.uniform(0.1, 0.4)) for _ in range(25)]
    corners = np.array([(0, 0), (0.5, 0.1), (0.3, 0.6)])
    block = fs.Polygon(rng.uniform((1.5, 0.5), (4, 3)) + corners)
    world, ends = fs.World([*discs, block], ROOM), ((0.5, 2), (5.5, 2))
    message = refused(fs.shortest_path, world, *ends, robot_of(0.9), 0.1)
    found = re.search(r"at most (\S+) m with that margin", message)
    most = float(found[1]) if found else 0.0
    if found:
        fs.shortest_path(world, *ends, robot_of(most), 0.1)
    refused(fs.shortest_path, world, *ends, robot_of(1.001 * most + 1e-3), 0.1)


def test_a_start_close_to_one_side_of_the_door():
    # Round the wall that it stands at, the robot keeps no more than it does there.
    world, _ = walls(0.4)
    start = (2.7, 1.0)  # 0.2 m from the lower wall
    message = refused(fs.shortest_path, world, start, GOAL, robot_of(0.38), 0.3)
    diameter, _ = said(message)
    fs.shortest_path(world, start, GOAL, robot_of(diameter), 0.3)
    refused(fs.shortest_path, world, start, GOAL, robot_of(diameter + 1e-3), 0.3)


def test_the_search_for_it_waits_until_the_message_is_read(monkeypatch):
    asked = []
    monkeypatch.setattr(route, "_remedy", lambda *of: asked.append(of) or "go round")
    with pytest.raises(fs.NoPath) as caught:
        fs.shortest_path(walls()[0], START, GOAL, robot_of(0.3), 0.05)
    assert not asked
    assert str(caught.value).endswith("margin of 0.05 m; go round")
    assert str(caught.value) == str(pickle.loads(pickle.dumps(caught.value)))
    assert len(asked) == 1


def test_in_a_huge_world_the_message_does_not_search(monkeypatch):
    for name in ("SEARCHED", "PLAIN"):
        monkeypatch.setattr(route, name, 5)
    message = refused(fs.shortest_path, walls()[0], START, GOAL, robot_of(0.3), 0.05)
    assert message.endswith(
        "margin of 0.05 m; move the start or the goal, or plan for a smaller robot or margin"
    )
