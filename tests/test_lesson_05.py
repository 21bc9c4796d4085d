"""Lesson 05, its own lines: the marble, groups, both ways round, and the door."""

from itertools import groupby

import numpy as np
import pytest
import shapely
from lessons import definitions

import freeseg as fs
from freeseg.path import taut_path
from freeseg.plan import StepKind
from freeseg.segments import find_endpoints, group_labels

STEM = "05_escape_local_minima"
NAMES = [
    "robot",
    "margin",
    "required",
    "R_r",
    "R_D",
    "cases",
    "worlds",
    "queries",
    "plans",
    "trap",
    "goal",
    "outside",
    "inside",
    "height",
    "roll",
    "greedy",
    "n_d",
    "segments",
    "joined_pairs",
    "group_of",
    "strings_round",
    "tried",
    "rank",
    "ring",
    "leave",
    "world",
]


@pytest.fixture(scope="module")
def own():
    """What the lesson defines."""
    return definitions(STEM, *NAMES)


def starts(own):
    return own["outside"], own["inside"]


def test_the_marble_ends_in_a_local_minimum_and_not_at_the_goal(own):
    way = own["roll"](own["outside"])
    last, height = way[-1], own["height"]
    angles = np.linspace(0, 2 * np.pi, 60)
    for radius in (0.001, 0.005, 0.01):
        around = last + radius * np.column_stack([np.cos(angles), np.sin(angles)])
        assert (height(around) > height(last[None])).all()
    assert height(last[None])[0] > height(np.array([own["goal"]]))[0]
    assert np.hypot(*(last - own["goal"])) > 0.3
    # It only ever rolled down, and its body never touched anything.
    assert (np.diff(height(way)) < 0).all()
    assert own["trap"].distances(shapely.LineString(way)).min() > own["R_r"]


@pytest.mark.parametrize("k", [1e-5, 1e-3])
def test_other_hills_have_valleys_too(own, k):
    height = own["roll"].__globals__["height"]
    own["roll"].__globals__["height"] = lambda points: height(points, k=k)
    try:
        last = own["roll"](own["outside"])[-1]
    finally:
        own["roll"].__globals__["height"] = height
    assert np.hypot(*(last - own["goal"])) > 0.3


def test_no_greedy_reading_gets_out_of_the_trap(own):
    for reading in ({}, {"outer_endpoints": True}, {"outer_endpoints": True, "concentric": True}):
        for start in starts(own):
            query = own["trap"], start, own["goal"], own["robot"], own["margin"]
            with pytest.raises(fs.Trapped) as trapped:
                fs.literal_plan(*query, **reading)
            steps = trapped.value.steps
            assert all(step.path.clearance(own["trap"]) < own["R_r"] for step in steps)
            assert own["greedy"](start, **reading)[0] == len(steps) - 1


def test_table_5_has_no_safe_segment(own):
    segments = own["segments"]
    assert own["n_d"] == len(segments) == 6
    assert not any(segment.safe for segment in segments)
    ends = find_endpoints(own["worlds"][5], segments)
    assert not [end for end in ends if end.segment is not None]


def test_its_groups_are_those_of_the_package(own):
    for number, world in own["worlds"].items():
        joined, label = own["joined_pairs"](world), group_labels(world, own["required"])
        groups = {tuple(sorted(own["group_of"](k, joined))) for k in range(len(world))}
        assert groups == {tuple(np.flatnonzero(label == k).tolist()) for k in set(label.tolist())}
        if number == 5:
            assert groups == {tuple(range(7))}


def both_ways(own, query):
    """Exact paths along the lesson's strings: sense -> path."""
    world, start, goal = query
    radii, ways = world.radii + own["R_D"], {}
    for sense, string in zip((1, -1), own["strings_round"](range(7), *query), strict=True):
        np.testing.assert_allclose(string[[0, -1]], [start, goal])
        off = [
            [
                abs(np.hypot(*(point - disc.center)) - r)
                for disc, r in zip(world, radii, strict=True)
            ]
            for point in string[1:-1]
        ]
        touched = [k for k, _ in groupby(np.argmin(off, axis=1).tolist())]
        turns = [(world[k].center, sense * radii[k]) for k in touched]
        ways[sense], _ = taut_path(start, turns, goal)
        chords = np.hypot(*np.diff(string, axis=0).T).sum()
        assert ways[sense].length == pytest.approx(chords, abs=1e-5)
    return ways


@pytest.mark.parametrize("name", ["16c", "16d"])
def test_the_planner_takes_the_shorter_way_round(own, name):
    ways, plan = both_ways(own, own["queries"][name]), own["plans"][name]
    assert plan.steps[1].kind == StepKind.LOCAL_MINIMUM
    assert plan.steps[1].group == tuple(range(7))
    shorter = min(path.length for path in ways.values())
    assert plan.path.length == pytest.approx(shorter, abs=1e-12)
    for path in ways.values():
        assert path.clearance(plan.world) >= own["R_D"] - 1e-9


def test_a_wall_across_the_shorter_way_leaves_the_longer(own):
    world, start, goal = own["queries"]["16c"]
    wall = fs.Polygon([(0.545, 0.18), (0.555, 0.18), (0.555, -3.0), (0.545, -3.0)])
    plan = fs.plan(fs.World([*world, wall]), start, goal, own["robot"], own["margin"])
    longer = both_ways(own, own["queries"]["16c"])[-1]
    assert plan.path.length == pytest.approx(longer.length, abs=1e-12)


def test_trying_all_ways_finds_the_shortest(own):
    best, query = own["tried"][own["rank"]].length, own["queries"]["16c"]
    assert best == pytest.approx(own["plans"]["16c"].path.length, abs=1e-12)
    shortest = fs.shortest_path(*query, own["robot"], own["margin"])
    assert best == pytest.approx(shortest.path.length, abs=1e-12)
    assert all(path.clearance(query[0]) < own["R_D"] for path in own["tried"][: own["rank"]])


def test_six_cases_end_at_a_group_four_of_them_for_the_same_reason(own):
    found = {}
    for name, plan in own["plans"].items():
        minima = [step for step in plan.steps if step.kind == StepKind.LOCAL_MINIMUM]
        if minima:
            (found[name],) = minima
    assert list(found) == ["13c", "13d", "14c", "15c", "16c", "16d"]
    for name, step in found.items():
        plan = own["plans"][name]
        assert set(step.group) == own["group_of"](step.blocking, own["joined_pairs"](plan.world))
        beside = [one for one in plan.segments if step.blocking in one.obstacles]
        assert beside
        assert not any(segment.safe for segment in beside)


def test_the_search_leaves_the_trap_the_shortest_way(own):
    for start in starts(own):
        query = own["trap"], start, own["goal"], own["robot"], own["margin"]
        plan, best = fs.plan(*query), fs.shortest_path(*query)
        assert plan.steps[-1].kind == StepKind.LOCAL_MINIMUM
        assert plan.steps[-1].group == tuple(range(len(own["trap"])))
        assert plan.path.length == pytest.approx(best.path.length, abs=1e-12)


def test_the_door_is_a_way_out_from_the_length_of_a_safe_segment_on(own):
    for change in (-1e-6, 1e-6):
        door = own["required"] + change
        path = own["leave"](door)
        assert (path is not None) == (change > 0)
        # The second opinion: what is left of the map when obstacles grow by R_D.
        world = own["ring"](door)
        grown = [shapely.Point(disc.center).buffer(disc.radius + own["R_D"]) for disc in world]
        free = shapely.box(-0.5, -1, 1.5, 1).difference(shapely.union_all(grown))
        parts = shapely.get_parts(free)
        if change < 0:
            with pytest.raises(fs.NoPath, match="leave no way"):
                fs.plan(world, own["inside"], own["goal"], own["robot"], own["margin"])
        else:
            assert path.clearance(world) >= own["R_D"] - 1e-9
        assert len(parts) == (2 if change < 0 else 1)


def test_a_narrower_robot_splits_the_group_of_table_5(own):
    world = own["worlds"][5]
    gaps = np.array([[shapely.distance(a, b) for b in world.cores] for a in world.cores])
    gaps -= world.radii[:, None] + world.radii
    pairs = np.argwhere(np.triu(np.ones_like(gaps, bool), 1)).tolist()
    for i, j in sorted(pairs, key=lambda pair: -gaps[*pair]):
        just = [group_labels(world, gaps[i, j] + change) for change in (1e-9, -1e-9)]
        n_groups = [len(set(label.tolist())) for label in just]
        if n_groups[1] > 1:
            break
    assert n_groups == [1, 2]
    assert (i, j) == (3, 4)
