"""Courses that trackers are compared on: the same for all of them.

All of them are an assumption, for the paper compares no trackers.
"""

from collections.abc import Iterator
from functools import cache
from itertools import count, islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from shapely import Point

from freeseg import checks
from freeseg.errors import InvalidParameter, NoPath
from freeseg.paper import load_cases, load_table
from freeseg.plan import Planner, check_plan
from freeseg.planners import plan, plan_rooms, shortest_path, with_fallback
from freeseg.random_worlds import random_query, random_world
from freeseg.reference import SMOOTHING, SPEED, Reference, make_reference
from freeseg.robot import KheperaIV
from freeseg.world import World

#: Time step of the runs (s).
DT = 0.05

#: Security margin of the plans (m): more than the paper's, for disturbed robots.
WIDE_MARGIN = 0.03

#: How far from the reference a robot begins at most: distance (m) and angle (rad).
OFFSET = 0.01, np.radians(10)

#: Obstacles of a random world, and what makes a plan worth driving: turns and length (m).
OBSTACLES, TURNS, LENGTH = 8, 2, 0.7

#: More of them would not fit into memory, or take days.
MOST_COURSES, MOST_ROBOTS = 10_000, 1_000_000

#: Few random worlds leave more than that round a start (m).
MOST_ROOM = 0.2

#: Planner of the random courses.
ROOMS_FIRST = with_fallback(plan_rooms, shortest_path)


class Course(NamedTuple):
    """A reference among obstacles; ``variation`` is its `needed_variation`."""

    name: str
    world: World
    reference: Reference
    variation: float


def make_course(
    name: str,
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    speed: float = SPEED,
    planner: Planner = ROOMS_FIRST,
    margin: float = WIDE_MARGIN,
) -> tuple[Course, bool]:
    """Plan a path and a timed reference along it.

    Parameters
    ----------
    name : str
        What to call it.
    world : World
        Obstacles.
    start, goal : array_like, shape (2,)
        Positions (m).
    speed : float, optional
        Cruising speed (m/s).
    planner : Planner, optional
        By default from room to room, and the exact one where that fails.
    margin : float, optional
        Security margin of the plan (m).

    Returns
    -------
    course : Course
        With smoothed curvature.
    worth : bool
        Whether it has at least `TURNS` turns and the length `LENGTH`.

    Raises
    ------
    InvalidParameter
        For what is no name, no planner, or no speed; and what the planner
        raises.
    """
    checks.instance("name", name, str, "a text")
    checks.function("planner", planner, "one, such as fs.plan", world, start, goal, margin=0)
    made = check_plan(planner(world, start, goal, margin=margin))
    reference = make_reference(made.path, speed=speed, smoothing=SMOOTHING, world=world)
    worth = len(made.turning_points) >= TURNS and made.path.length >= LENGTH
    return Course(name, world, reference, needed_variation(reference)), worth


def needed_variation(reference: Reference) -> float:
    """Total variation of the faster-changing wheel (m/s) that a reference needs by itself."""
    checks.instance("reference", reference, Reference, "one made by make_reference")
    wanted = reference.at(reference.steps(DT) + DT / 2)
    wheels = KheperaIV().to_wheels(wanted.v, wanted.omega)
    return float(np.abs(np.diff(wheels, prepend=0.0)).sum(-1).max())


def random_courses(
    courses: int, seed: int, speed: float = SPEED, room: float = 0.0
) -> tuple[Course, ...]:
    """Courses through random worlds that take some turning.

    Parameters
    ----------
    courses : int
        How many.
    seed : int
        Seed of the first world; those without a path, or with one that is
        hardly worth driving, are left out.
    speed : float, optional
        Cruising speed (m/s).
    room : float, optional
        How far from every obstacle the robot's rim is at the start (m), for robots
        that begin beside it: worlds where it is nearer are left out.

    Returns
    -------
    tuple of Course

    Raises
    ------
    InvalidParameter
        For less than one course or over `MOST_COURSES`, what is no seed, no
        speed that the robot can drive at, or a room that is negative or more
        than random worlds leave.
    """
    courses, seed = _how_many("courses", courses, MOST_COURSES), checks.whole("seed", seed)
    room = checks.not_negative("room", room)
    if room > MOST_ROOM:
        raise InvalidParameter(f"room is {room:g} m; give at most {MOST_ROOM:g} m")
    return _random_courses(courses, seed, checks.positive("speed", speed), room)


@cache
def _random_courses(courses: int, seed: int, speed: float, room: float) -> tuple[Course, ...]:
    def tries() -> Iterator[Course]:
        for k in count(seed):
            world = random_world(OBSTACLES, k)
            ends = random_query(world, k, margin=WIDE_MARGIN)
            try:
                course, worth = make_course(f"random {k}", world, *ends, speed)
            except NoPath:
                continue
            start = Point(*course.reference.pose[:2, 0])
            free = world.distances(start).min() - KheperaIV().radius
            if worth and free >= room:
                yield course

    return tuple(islice(tries(), courses))


def paper_courses(speed: float = SPEED) -> tuple[Course, ...]:
    """The paper's cases 15(a) and 16(b), a tuple of Course."""
    return _paper_courses(checks.positive("speed", speed))


@cache
def _paper_courses(speed: float) -> tuple[Course, ...]:
    cases = [load_cases()[name] for name in ("15a", "16b")]
    return tuple(
        make_course(case.name, load_table(case.table), case.start, case.goal, speed, plan)[0]
        for case in cases
    )


def _how_many(name: str, value: int, most: int) -> int:
    """`value` as an int; `InvalidParameter` unless from 1 to `most`."""
    found = checks.whole(name, value, 1)
    if found > most:
        raise InvalidParameter(f"{name} is {checks.shown(value)}; give at most {most}")
    return found


def spread_offsets(robots: int, seed: int, offset: tuple[float, float] = OFFSET) -> np.ndarray:
    """Offsets of some robots, spread evenly over a disc and angles.

    Parameters
    ----------
    robots : int
        How many.
    seed : int
        Equal seeds give equal offsets.
    offset : (float, float), optional
        Radius of the disc (m), and the largest angle (rad).

    Returns
    -------
    ndarray, shape (3, robots)
        For `simulate`: a Latin hypercube, so that a few robots do not all
        begin near by.

    Raises
    ------
    InvalidParameter
        For less than one robot or over `MOST_ROBOTS`, what is no seed, or no two
        numbers that are not negative.
    """
    robots, seed = _how_many("robots", robots, MOST_ROBOTS), checks.whole("seed", seed)
    most = [checks.not_negative("offset", end) for end in checks.numbers("offset", offset, 2)]
    from scipy.stats import qmc

    radius, direction, turned = qmc.LatinHypercube(3, rng=seed).random(robots).T
    distance, angle = most[0] * np.sqrt(radius), 2 * np.pi * direction
    turned = most[1] * (2 * turned - 1)
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), turned])
