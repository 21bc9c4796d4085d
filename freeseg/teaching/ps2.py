"""Tests of problem set 2: tangents, the turning point, a planner, and how it fails."""

from functools import cache
from typing import Any

import numpy as np

from freeseg.errors import FreesegError, InvalidQuery
from freeseg.paper import load_cases, load_table
from freeseg.path import Path, taut_path
from freeseg.plan import turning_radius
from freeseg.planners import plan, shortest_path
from freeseg.random_worlds import random_query, random_world
from freeseg.robot import KheperaIV
from freeseg.segments import MARGIN, free_segments
from freeseg.teaching.answered import numbers
from freeseg.teaching.check import Ask
from freeseg.world import Disc, World

__all__ = ["break_it", "planner", "tangent", "turning"]

#: How much longer than that of `plan` a path may be.
ALLOWED = 1.05
#: How much longer than the shortest a path is that counts as broken.
BROKEN = 1.03
#: Between points of a path (m), far less than any turn's radius.
SAMPLED_AT = 0.005
#: Discs of a world that breaks a planner.
MOST_DISCS = 6
#: How many worlds there are whose nearest endpoint is a trap.
TRICKY = 12


def tangent(ask: Ask, rng: np.random.Generator) -> None:
    """The straight piece between two dangerous circles."""
    for _ in range(25):
        centers, senses = rng.uniform(-1, 1, (2, 2)), rng.choice([-1, 1], 2)
        apart = np.hypot(*(centers[1] - centers[0]))
        # Apart from each other, so that every pair of senses has its tangent.
        radii = senses * apart * rng.uniform(0.1, 0.45, 2)
        mine = numbers(
            ask("tangent", centers[0], radii[0], centers[1], radii[1]),
            (2, 2),
            "give back where the robot leaves the first circle and where it joins the second",
        )
        way = mine[1] - mine[0]
        length = np.hypot(*way)
        assert length > 0, "both of your points are the same"
        for name, center, radius, end in zip(
            ("first", "second"), centers, radii, mine, strict=True
        ):
            spoke = end - center
            assert np.isclose(np.hypot(*spoke), abs(radius)), (
                f"your point is {np.hypot(*spoke):.3f} m from the {name} centre; the circle's "
                f"radius is {abs(radius):.3f} m"
            )
            assert abs(spoke @ way) < 1e-7 * length, (
                f"your line cuts the {name} circle: a tangent is perpendicular to the radius"
            )
            left = way[0] * -spoke[1] - way[1] * -spoke[0] > 0
            assert left == (radius > 0), (
                f"the {name} circle is on the wrong side: driven counter-clockwise, a positive "
                "radius, its centre is on the robot's left"
            )


def turning(ask: Ask, rng: np.random.Generator) -> None:
    """The turning point and the sense of the turn."""
    for number in range(40):
        ends, centers = rng.uniform(0, 1, (2, 5, 2, 2))
        start, goal = rng.uniform(-0.5, 1.5, (2, 2))
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=-1)
        detours = sum(np.linalg.norm(ends - point, axis=-1) for point in (start, goal))
        # The nearest endpoint of all ends a danger segment, every time that one can.
        needed = lengths[np.argmin(detours.min(1))] + 1e-3 if number else lengths.max() + 0.1
        mine = ask("turning_point", start, goal, ends, centers, needed)
        if needed > lengths.max():
            assert mine is None, (
                "where every segment is danger there is no turning point: give None"
            )
            continue
        mine = numbers(mine, (3,), "give back x, y and the sense, or None where all are danger")
        here = (ends == mine[:2]).all(-1)
        assert here.any(), "a turning point is one of the given endpoints"
        safe = lengths >= needed
        assert here[safe].any(), (
            "your turning point ends a danger segment, shorter than D_r + delta: the robot does "
            "not fit through"
        )
        least = detours[safe].min()
        assert np.isclose(detours[here][0], least), (
            f"your detour is {detours[here][0]:.3f} m; over the end of another safe segment it is "
            f"{least:.3f} m"
        )
        ahead, aside = goal - start, centers[here][0] - mine[:2]
        sense = np.sign(ahead[0] * aside[1] - ahead[1] * aside[0])
        assert mine[2] == sense, (
            f"your sense is {mine[2]:g}: seen from start to goal, a disc to the left of the "
            "endpoint is driven round counter-clockwise (1), one to the right clockwise (-1)"
        )


def moved(
    world: World, places: list[Any], angle: float, shift: np.ndarray
) -> tuple[World, list[np.ndarray]]:
    """A world of discs and some places, turned by an angle (rad) and then shifted (m)."""
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    discs = [Disc(rotation @ disc.corners[0] + shift, disc.radius) for disc in world]
    return World(discs), [rotation @ np.array(place, float) + shift for place in places]


def _first_turn(world: World, start: np.ndarray, goal: np.ndarray) -> tuple[Any, bool]:
    """The endpoint of least detour of a safe segment, and whether one of a danger one is nearer."""
    segments = free_segments(world, KheperaIV(), MARGIN)
    ranked = [
        (np.hypot(*(end - start)) + np.hypot(*(goal - end)), segment.safe, end)
        for segment in segments
        for end in segment.ends
    ]
    ranked.sort(key=lambda one: one[0])
    safe = [end for _, fits, end in ranked if fits]
    return (safe[0] if safe else None), bool(ranked) and not ranked[0][1]


def _is_free(world: World, path: Path | None) -> bool:
    return path is not None and path.clearance(world) >= KheperaIV().radius - 1e-9


@cache
def _tricky(number: int) -> tuple[World, np.ndarray, np.ndarray]:
    """A random world whose nearest endpoint ends a danger segment, and a query in it."""
    for seed in range(100 * number, 100 * number + 100):
        world = random_world(6, seed, area=0.06)
        start, goal = random_query(world, seed)
        first, near_danger = _first_turn(world, start, goal)
        if first is None or not near_danger or _is_free(world, taut_path(start, [], goal)[0]):
            continue
        try:
            plan(world, start, goal)
        except FreesegError:
            continue
        return world, start, goal
    raise RuntimeError(f"no tricky world number {number}")


def _queries(rng: np.random.Generator) -> list[tuple[str, World, np.ndarray, np.ndarray]]:
    """Cases of the paper and tricky worlds, in a turned and moved frame."""
    queries: list[tuple[str, World, Any, Any]] = [
        (f"case {case.name}", load_table(case.table), case.start, case.goal)
        for case in load_cases().values()
    ]
    for number in rng.choice(TRICKY, 4, replace=False):
        queries.append((f"a world of six discs, {number}", *_tricky(int(number))))
    angle, shift = rng.uniform(-np.pi, np.pi), rng.uniform(-1, 1, 2)
    found = []
    for name, world, *ends in queries:
        there, (start, goal) = moved(world, list(ends), angle, shift)
        found.append((name, there, start, goal))
    return found


def turns_of(answer: Any) -> list[tuple[np.ndarray, float]]:
    """Turns of a planner's answer."""
    try:
        turns = [(np.array(center, float).reshape(2), float(radius)) for center, radius in answer]
    except (TypeError, ValueError):
        raise AssertionError(
            f"turns are a list of (center, signed_radius); yours is {answer!r:.150}"
        ) from None
    assert np.isfinite([[*center, radius] for center, radius in turns]).all(), (
        "the numbers of your turns have to be finite"
    )
    return turns


def _planned(ask: Ask, world: World, start: np.ndarray, goal: np.ndarray) -> tuple[Any, Any, Any]:
    """First turning point, turns, and the path round them, of a student's planner."""
    answer = ask("plan_turns", world, start, goal)
    if not isinstance(answer, list) or len(answer) != 2:
        raise AssertionError("give back the first turning point (or None) and the turns")
    turns = turns_of(answer[1])
    return answer[0], turns, taut_path(start, turns, goal)[0]


def _solved(ask: Ask, world: World, start: np.ndarray, goal: np.ndarray) -> None:
    """Raise an `AssertionError` that says what is wrong with a student's plan."""
    first, _, path = _planned(ask, world, start, goal)
    wanted, _ = _first_turn(world, start, goal)
    if wanted is None:
        assert first is None, "all segments are danger: the first turning point is None"
    else:
        found = numbers(first, (2,), "a segment is safe: give x and y of the first turning point")
        assert np.allclose(found, wanted, atol=1e-6), (
            "the first turning point is the end of a safe segment with the least detour, (5), (6)"
        )
    assert path is not None, (
        "there is no way round your turns: is each (center, ±(r + R_D)), and do circles that "
        "cross have the same sense?"
    )
    clearance = path.clearance(world)
    assert _is_free(world, path), (
        f"your path comes to {1000 * clearance:.0f} mm from an obstacle, the robot's radius is "
        f"{1000 * KheperaIV().radius:.1f} mm"
    )
    best = plan(world, start, goal).path.length
    assert path.length <= ALLOWED * best, (
        f"your path is {path.length:.3f} m long, that of fs.plan {best:.3f} m"
    )


def planner(ask: Ask, rng: np.random.Generator) -> tuple[float, str]:
    """A planner for the sixteen cases, and for worlds whose nearest endpoint is a trap."""
    wrong = []
    queries = _queries(rng)
    for name, world, start, goal in queries:
        try:
            _solved(ask, world, start, goal)
        except AssertionError as error:
            wrong.append(f"{name}: {error}")
            if "your code takes over" in str(error):
                break
    if len(wrong) == len(queries) or (wrong and "your code takes over" in wrong[-1]):
        raise AssertionError(wrong[-1])
    share = 1 - len(wrong) / len(queries)
    return share, "\n".join([f"{len(queries) - len(wrong)} of {len(queries)} solved", *wrong[:3]])


def _given(answer: Any) -> tuple[World, np.ndarray, np.ndarray, int, int, str]:
    """The world, query, wrong turn and planner that a student names."""
    remedy = (
        "give back discs [(x, y, r), ...], start (x, y), goal (x, y), the wrong turn (number of "
        'the disc from 1 on, sense), and "mine" or "fs.plan"'
    )
    if not isinstance(answer, list) or len(answer) != 5:
        raise AssertionError(remedy)
    discs, start, goal, wrong, whose = answer
    count = np.shape(discs)[0] if np.ndim(discs) == 2 else 0
    assert 1 <= count <= MOST_DISCS, f"give one to {MOST_DISCS} discs (x, y, r); you have {count}"
    table = numbers(discs, (count, 3), remedy)
    number, sense = numbers(wrong, (2,), remedy)
    assert (number in range(1, count + 1), sense in (1, -1)) == (True, True), (
        f"your wrong turn is {number:g}, {sense:g}: give the disc's number and 1 or -1"
    )
    assert whose in ("mine", "fs.plan"), remedy
    world = World([Disc(row[:2], row[2]) for row in table])
    ends = numbers(start, (2,), remedy), numbers(goal, (2,), remedy)
    return world, *ends, int(number), int(sense), whose


def _turned(world: World, turns: Any) -> set[tuple[int, int]]:
    """Numbers of the discs that turns go round, and their senses."""
    return {
        (number, int(np.sign(radius)))
        for center, radius in turns
        for number, disc in enumerate(world, 1)
        if np.hypot(*(disc.corners[0] - center)) < 1e-6
        and abs(abs(radius) - disc.radius - turning_radius(KheperaIV(), MARGIN)) < 1e-6
    }


def _sense(path: Path, center: np.ndarray) -> int:
    """1 where a path passes a place on its left, as a counter-clockwise turn does, else -1."""
    seen = path.sample(SAMPLED_AT) - center
    swept = np.unwrap(np.arctan2(seen[:, 1], seen[:, 0]))
    return int(np.sign(swept[-1] - swept[0]))


def _plan_of(ask: Ask, whose: str, query: tuple[Any, Any, Any]) -> tuple[Any, Any]:
    """Turns and path of the planner that is to fail."""
    if whose == "mine":
        return _planned(ask, *query)[1:]
    try:
        found = plan(*query)
    except FreesegError as error:
        raise AssertionError(
            f"fs.plan raises {type(error).__name__} there, and so has no wrong turn to name; find "
            "a world on which its path is too long"
        ) from None
    return [(one.center, one.sense * one.radius) for one in found.turning_points], found.path


def break_it(ask: Ask, rng: np.random.Generator) -> None:
    """A world that breaks a planner, and its wrong turn."""
    world, *ends, number, sense, whose = _given(ask("hard_case"))
    if whose == "mine":
        case = load_cases()["15a"]
        try:
            _solved(ask, load_table(1), np.array(case.start), np.array(case.goal))
        except AssertionError as error:
            raise AssertionError(f"first solve case 15a, then break it: {error}") from None
    for angle in (0.0, float(rng.uniform(-np.pi, np.pi))):
        there, (start, goal) = moved(world, ends, angle, rng.uniform(-1, 1, 2) * (angle != 0))
        try:
            best = shortest_path(there, start, goal)
        except InvalidQuery as error:
            raise AssertionError(f"this start or goal is none: {error}") from None
        except FreesegError as error:
            raise AssertionError(f"a fair world has a path; here: {error}") from None
        turns, path = _plan_of(ask, whose, (there, start, goal))
        frame = f", turned by {np.degrees(angle):.0f}°: it was luck" if angle else ""
        fails = not _is_free(there, path) or path.length > BROKEN * best.path.length
        assert fails, (
            f"the planner solves your world{frame}: its path is {path.length:.3f} m long, the "
            f"shortest {best.path.length:.3f} m"
        )
        assert (number, sense) in _turned(there, turns), (
            f"the planner does not turn round disc {number} in the sense {sense:+d}{frame}; its "
            f"turns are {sorted(_turned(there, turns))}"
        )
        right = [(one.center, one.sense * one.radius) for one in best.turning_points]
        assert (number, sense) not in _turned(there, right), (
            f"the shortest path turns round disc {number} in the sense {sense:+d}, too: that turn "
            "is not the wrong one"
        )
        assert _sense(best.path, there[number - 1].corners[0]) != sense, (
            f"the shortest path passes disc {number} on the same side as that turn, and only does "
            "not touch it: that turn is not the wrong one"
        )
