"""Planners side by side, whoever wrote them: success, safety, length, turning and time.

A rival is a function from a question to a track: a path of freeseg's, or points that are
joined by straight lines, such as another package's answer or where a robot drove. Each
track is judged alike, by the world and not by what its planner says of it.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from os import PathLike
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import FreesegError, InvalidParameter
from freeseg.paper import load_cases, load_table
from freeseg.path import Path
from freeseg.plan import Plan, turning_radius
from freeseg.planners import (
    length_first_plan,
    literal_plan,
    plan,
    plan_rooms,
    shortest_path,
    widest_segment_plan,
)
from freeseg.random_worlds import SPACIOUS, random_query, random_world
from freeseg.robot import Robot, as_robot
from freeseg.segments import MARGIN
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS
from freeseg.world import World, as_position, check_world

#: Square metres per obstacle of random worlds, by the name of their density.
DENSITIES = {"sparse": SPACIOUS, "medium": SPACIOUS / 2, "dense": SPACIOUS / 4}

#: Obstacles of a random world, discs and polygons.
PER_WORLD = 30

#: Lengths and clearances (m) that differ by less are equal: other packages compute in their own
#: ways, some in single precision.
ALIKE = 1e-6

#: Samples of a path (m) are so far apart where its turning is summed up.
SAMPLES = 0.002

#: A track is near the optimum that is at most so much longer.
NEAR_OPTIMUM = 0.01


class Question(NamedTuple):
    """What a rival is asked: as a planner's arguments."""

    world: World
    start: ArrayLike
    goal: ArrayLike
    robot: Robot | None = None
    margin: float = MARGIN


#: A question to a track: a Plan, a Path, points (m) of shape (k, 2), or None for no answer.
Rival: TypeAlias = Callable[..., Any]

#: The planners of this package, and the name of the one that all others are measured by.
EXACT = "exact"
OF_FREESEG: dict[str, Rival] = {
    EXACT: shortest_path,
    "paper, completed": plan,
    "paper, length first": length_first_plan,
    "paper, widest segment": widest_segment_plan,
    "paper, its words": partial(literal_plan, concentric=True),
    "rooms": plan_rooms,
}


def pose_question(case: tuple[str, Any]) -> Question:
    """One of the paper's cases, or a random world with a query.

    Parameters
    ----------
    case : tuple
        ``("paper", name)``, or a density, one of `DENSITIES`, and a seed.

    Returns
    -------
    Question

    Raises
    ------
    InvalidParameter
        For what is no such case.
    """
    kinds = ("paper", *DENSITIES)
    if not isinstance(case, tuple | list) or len(case) != 2:
        raise InvalidParameter(f"case is {checks.shown(case)}; give {kinds}, and a name or seed")
    kind = checks.choice("case", case[0], kinds)
    if kind == "paper":
        cases = load_cases()
        found = cases[checks.choice("case", case[1], tuple(cases))]
        return Question(load_table(found.table), found.start, found.goal)
    seed = checks.whole("case", case[1])
    world = random_world(PER_WORLD, seed, ("disc", "polygon"), DENSITIES[kind])
    return Question(world, *random_query(world, seed))


def judge_track(
    track: Plan | Path | ArrayLike,
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    within: float = ALIKE,
) -> dict[str, Any]:
    """Numbers of a track, by the world alone.

    Parameters
    ----------
    track : Plan, Path or array_like, shape (k, 2)
        Where the robot's centre goes: a path, or points (m) joined by straight
        lines, such as those of a run.
    world : World
        Obstacles.
    start, goal : array_like, shape (2,)
        Where it is to begin and to end (m).
    robot : Robot, optional
        Robot; its disc must not touch an obstacle.
    within : float, optional
        How far from the start and the goal it may begin and end (m); a robot
        that drives needs more than the round-off given here.

    Returns
    -------
    dict
        ``arrives``, whether it leads from the start to the goal; ``collides``;
        ``length_m``, ``clearance_m``, the smallest distance of the robot's
        centre from an obstacle, and ``turning_rad``, the sum of all changes of
        heading, either way.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For what is no track, world, position, robot or length.
    """
    check_world(world)
    robot, within = as_robot(robot), checks.not_negative("within", within)
    track = track.path if isinstance(track, Plan) else track
    if isinstance(track, Path):
        points, length = track.sample(SAMPLES), track.length
        clearance = track.clearance(world)
    else:
        points = checks.array("track", track, (None, 2))
        if not len(points):
            raise InvalidParameter("track has no points; give one or more")
        length = float(np.hypot(*np.diff(points, axis=0).T).sum())
        line = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
        clearance = float(world.distances(line).min(initial=np.inf))
    ends = np.array([as_position(start, "start"), as_position(goal, "goal")])
    return {
        "arrives": bool((np.hypot(*(points[[0, -1]] - ends).T) <= within).all()),
        "collides": clearance < robot.radius - ALIKE,
        "length_m": length,
        "clearance_m": clearance,
        "turning_rad": _turning(points),
    }


def _turning(points: np.ndarray) -> float:
    """Sum of the absolute changes of heading (rad) along points (k, 2)."""
    along = np.diff(points, axis=0)
    along = along[(along != 0).any(1)]
    headings = np.arctan2(along[:, 1], along[:, 0])
    return float(np.abs((np.diff(headings) + np.pi) % (2 * np.pi) - np.pi).sum())


def try_rivals(
    case: Any,
    rivals: Mapping[str, Rival] = OF_FREESEG,
    pose: Callable[[Any], Question] = pose_question,
) -> list[dict[str, Any]]:
    """Ask all rivals one question, one after the other.

    Parameters
    ----------
    case : object
        What `pose` makes a question of; its first item names the set that it is of.
    rivals : dict, optional
        Name to rival; by default this package's planners.
    pose : callable, optional
        Case to `Question`.

    Returns
    -------
    list of dict
        A row a rival: ``set``, ``rival``; ``outcome``, ``"path"`` or the name of the
        error; what `judge_track` says; ``optimum_m``, the length of the shortest
        path that keeps R_D (NaN where there is none) and ``keeps_m``, that distance; and
        ``ms``, processor time with all preparation, in a world new to the rival.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For rivals that are no functions, and for what `pose` or a planner refuses.
    """
    _check_rivals(rivals)
    question = pose(case)
    world, robot = question.world, as_robot(question.robot)
    optimum = math.nan
    try:
        optimum = shortest_path(*question).path.length
    except FreesegError as error:
        if isinstance(error, InvalidParameter):
            raise
    rows = []
    for name, rival in rivals.items():
        fresh = World(world.obstacles, world.boundary)
        outcome, track, begin = "no path", None, time.process_time()
        try:
            track = rival(fresh, *question[1:])
        except FreesegError as error:
            outcome = type(error).__name__
        duration = 1e3 * (time.process_time() - begin)
        judged: dict[str, Any] = {"arrives": False, "collides": False}
        judged |= dict.fromkeys(("length_m", "clearance_m", "turning_rad"), math.nan)
        if track is not None:
            outcome, judged = "path", judge_track(track, world, *question[1:3], robot)
        row = {"set": str(case[0]), "rival": name, "outcome": outcome} | judged
        keeps = turning_radius(robot, question.margin)
        rows.append(row | {"optimum_m": optimum, "keeps_m": keeps, "ms": duration})
    return rows


def _check_rivals(rivals: Mapping[str, Rival]) -> None:
    """Raise `InvalidParameter` for what are no rivals."""
    checks.instance("rivals", rivals, Mapping, "a dict of name to rival")  # type: ignore[type-abstract]
    for name, rival in rivals.items():
        if not callable(rival):
            raise InvalidParameter(f"rivals has {checks.shown(rival)} for {name}; give a function")


def _try_rivals(
    case: Any, _: int, rivals: Mapping[str, Rival], pose: Callable[[Any], Question]
) -> list[dict[str, Any]]:
    """As `try_rivals`; the seed of a world is the case's, not the runner's."""
    return try_rivals(case, rivals, pose)


def compare(
    cases: Iterable[Any],
    rivals: Mapping[str, Rival] = OF_FREESEG,
    pose: Callable[[Any], Question] = pose_question,
    jobs: int | None = 1,
    store: str | PathLike[str] | None = None,
) -> list[dict[str, Any]]:
    """Ask all rivals many questions, see `try_rivals`.

    Parameters
    ----------
    cases, rivals, pose
        As for `try_rivals`.
    jobs, store : optional
        Processes, and where the rows are kept, see `runner.run`. Times are
        comparable where each has a core for itself.

    Returns
    -------
    list of dict
        A row a question and rival, with ``question``, its number.

    Raises
    ------
    InvalidParameter
        For rivals that are no functions, or is no number of processes.
    """
    _check_rivals(rivals)
    found = run(
        partial(_try_rivals, rivals=rivals, pose=pose), cases, store, jobs=jobs, strict=True
    )
    return [
        {"question": row["case"]} | {k: v for k, v in row.items() if k not in COLUMNS}
        for row in found
    ]


def summarise(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """One row for each set and rival, of the rows of `compare`.

    Parameters
    ----------
    rows : iterable of dict
        From `compare`.

    Returns
    -------
    list of dict
        ``set``, ``rival``; ``questions`` and, of these, ``solvable`` (some path keeps
        R_D) and ``solved``, where the track arrives and touches nothing;
        ``collisions``; ``wrong``, tracks that do not arrive; ``keeps``, those solved
        that keep R_D. Of the questions that are solvable and solved: ``near``, the
        share within 1 % of the optimum; ``median_ratio``, ``p95_ratio`` and
        ``max_ratio`` of the length to the optimum. Of all solved: ``clearance_m``,
        the smallest, and ``turning_rad``, the median. Of all questions:
        ``median_ms`` and ``p95_ms``. ``shorter``, on how many questions it keeps R_D
        and is shorter than the optimum by more than round-off; ``faster``, on how
        many it is within 1 % and took less time than the exact planner, which
        was asked it, too. NaN where there is none.

    Raises
    ------
    InvalidParameter
        For what are no such rows.
    """
    ordered = _checked(rows)
    exact = {row["question"]: row["ms"] for row in ordered if row["rival"] == EXACT}
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in ordered:
        groups.setdefault((row["set"], row["rival"]), []).append(row)
    return [
        {"set": kind, "rival": rival} | _summary(group, exact)
        for (kind, rival), group in groups.items()
    ]


def _summary(group: list[Mapping[str, Any]], exact: Mapping[Any, float]) -> dict[str, Any]:
    """Numbers of one rival's rows, given the exact planner's time (ms) by question."""
    arrives, collides = (np.array([row[name] for row in group], bool) for name in _FLAGS)
    length, optimum, clearance, turning, keeps, ms = (
        np.array([row[name] for row in group], float) for name in _NUMBERS
    )
    exact_ms = np.array([exact.get(row["question"], math.nan) for row in group])
    solvable, solved = np.isfinite(optimum), arrives & ~collides
    keeping = solved & (clearance >= keeps - ALIKE)
    near = solved & (length <= optimum * (1 + NEAR_OPTIMUM))
    ratio = (length / optimum)[solvable & solved]
    return {
        "questions": len(group),
        "solvable": int(solvable.sum()),
        "solved": int(solved.sum()),
        "collisions": int(collides.sum()),
        "wrong": int((~arrives & np.isfinite(length)).sum()),
        "keeps": int(keeping.sum()),
        "near": _of(np.mean, near[solvable & solved]),
        "median_ratio": _of(np.median, ratio),
        "p95_ratio": _of(np.quantile, ratio, 0.95),
        "max_ratio": _of(np.max, ratio),
        "clearance_m": _of(np.min, clearance[solved]),
        "turning_rad": _of(np.median, turning[solved]),
        "median_ms": _of(np.median, ms),
        "p95_ms": _of(np.quantile, ms, 0.95),
        "shorter": int((keeping & (length < optimum - ALIKE)).sum()),
        "faster": int((near & (ms < exact_ms)).sum()),
    }


_FLAGS = "arrives", "collides"
_NUMBERS = "length_m", "optimum_m", "clearance_m", "turning_rad", "keeps_m", "ms"


def _of(number: Callable[..., Any], values: np.ndarray, *more: float) -> float:
    """A number of some values; NaN where there is none."""
    return float(number(values, *more)) if len(values) else math.nan


def _checked(rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows of `compare` as a list, or `InvalidParameter`."""
    remedy = "rows of compare, one or more"
    found: list[Mapping[str, Any]] = checks.instances("rows", rows, Mapping, remedy)
    wanted = {"question", "set", "rival", *_FLAGS, *_NUMBERS}
    if not found or any(wanted - row.keys() for row in found):
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give {remedy}")
    return found
