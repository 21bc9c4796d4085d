"""Planners side by side, whoever wrote them: success, safety, length, turning and time.

A rival is a function from a question to a track: a path of freeseg's, points that are joined
by straight lines, such as another package's answer, or what a robot drove by a reactive law.
Each track is judged alike, by the world and not by what its planner says of it. What was
found is kept row by row, `load_rivals`; all that is said of it is computed from the rows.
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
from freeseg.data import DATA, read_rows, write_rows
from freeseg.errors import FreesegError, InvalidData, InvalidParameter
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
from freeseg.react import ARRIVED, arc_points
from freeseg.robot import Robot, as_robot
from freeseg.segments import MARGIN
from freeseg.simulate import Run
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


#: What is kept of each question and rival, by name, and how.
STORED: dict[str, type] = {
    "set": str,
    "question": str,
    "rival": str,
    "outcome": str,
    "arrives": bool,
    "collides": bool,
    "length_m": float,
    "clearance_m": np.float32,
    "turning_rad": np.float32,
    "optimum_m": float,
    "equal_m": float,
    "keeps_m": np.float32,
    "ms": np.float32,
}

#: A question to a track: a Plan, a Path, a Run, points (m) of shape (k, 2), or None for no answer.
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
    track: Plan | Path | Run | ArrayLike,
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    within: float = ALIKE,
) -> dict[str, Any]:
    """Numbers of a track, by the world alone.

    Parameters
    ----------
    track : Plan, Path, Run or array_like, shape (k, 2)
        Where the robot's centre goes: a path, the run of a robot, or points (m)
        joined by straight lines.
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
        ``length_m``, with what is missing at both ends where it arrives, so that
        who stops short gains nothing; ``clearance_m``, the smallest distance of
        the robot's centre from an obstacle; and ``turning_rad``, the sum of all
        changes of direction, either way.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For what is no track, world, position, robot or length.
    """
    check_world(world)
    robot, within = as_robot(robot), checks.not_negative("within", within)
    track = track.path if isinstance(track, Plan) else track
    if isinstance(track, Run):
        if track.pose.ndim != 2:
            raise InvalidParameter("track is a run of many robots; give that of one")
        track = arc_points(track)[0]
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
    missing = np.hypot(*(points[[0, -1]] - ends).T)
    arrives = bool((missing <= within).all())
    return {
        "arrives": arrives,
        "collides": clearance < robot.radius - ALIKE,
        "length_m": length + arrives * float(missing.sum()),
        "clearance_m": clearance,
        "turning_rad": _turning(points),
    }


def _turning(points: np.ndarray) -> float:
    """Sum of the absolute changes of direction (rad) along points (k, 2)."""
    along = np.diff(points, axis=0)
    # Where a robot turns on the spot, round-off would have it go anywhere.
    along = along[np.hypot(along[:, 0], along[:, 1]) > ALIKE]
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
        error; what `judge_track` says, also of the track of a law that was trapped;
        ``optimum_m``, the length of the shortest path that keeps R_D (NaN where there
        is none), and ``equal_m``, that of the one that keeps no more than the track
        does (NaN where it fails); ``keeps_m``, R_D; and ``ms``, processor time with all
        preparation, in a world new to the rival.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For rivals that are no functions, and for what `pose` or a planner refuses.
    """
    check_rivals(rivals)
    question = pose(case)
    # Whoever is timed just after the optimum was computed finds its code and data at hand.
    answers = {name: _ask(rival, question) for name, rival in rivals.items()}
    optimum = _shortest(question)
    return [
        {"set": str(case[0]), "rival": name} | _judge(*answer, question, optimum)
        for name, answer in answers.items()
    ]


def _shortest(question: Question) -> float:
    """Length (m) of the shortest path that answers a question; NaN where there is none."""
    try:
        return shortest_path(*question).path.length
    except FreesegError as error:
        if isinstance(error, InvalidParameter):
            raise
        return math.nan


def _ask(rival: Rival, question: Question) -> tuple[str, Any, float]:
    """What a rival answers: its outcome, its track or None, and the time (ms)."""
    fresh = World(question.world.obstacles, question.world.boundary)
    outcome, track, begin = "no path", None, time.process_time()
    try:
        track = rival(fresh, *question[1:])
    except FreesegError as error:
        outcome, track = type(error).__name__, getattr(error, "run", None)
    else:
        outcome = outcome if track is None else "path"
    return outcome, track, 1e3 * (time.process_time() - begin)


def _judge(
    outcome: str, track: Any, duration: float, question: Question, optimum: float
) -> dict[str, Any]:
    """The row of an answer, given the length of the shortest path (m)."""
    world, robot = question.world, as_robot(question.robot)
    judged: dict[str, Any] = {"arrives": False, "collides": False}
    judged |= dict.fromkeys(("length_m", "clearance_m", "turning_rad"), math.nan)
    if track is not None:
        within = ARRIVED if isinstance(track, Run) else ALIKE
        judged = judge_track(track, world, *question[1:3], robot, within)
    equal, keeps = math.nan, turning_radius(robot, question.margin)
    if judged["arrives"] and not judged["collides"]:
        equal = optimum
        if judged["clearance_m"] < keeps - ALIKE:
            left = max(judged["clearance_m"] - ALIKE - robot.radius, 0.0)
            equal = _shortest(question._replace(margin=2 * left))
    found = {"optimum_m": optimum, "equal_m": equal, "keeps_m": keeps, "ms": duration}
    return {"outcome": outcome} | judged | found


def check_rivals(rivals: Mapping[str, Rival]) -> None:
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
        A row a question and rival, as `try_rivals` gives it, with ``question``, the
        second item of its case.

    Raises
    ------
    InvalidParameter
        For what are no cases, rivals that are no functions, or is no number of
        processes.
    """
    check_rivals(rivals)
    cases = checks.sequence("cases", cases, "questions, such as ('paper', '13a')")
    found = run(
        partial(_try_rivals, rivals=rivals, pose=pose), cases, store, jobs=jobs, strict=True
    )
    return [
        {"question": cases[row["case"]][1]} | {k: v for k, v in row.items() if k not in COLUMNS}
        for row in found
    ]


def save_rivals(
    rows: Iterable[Mapping[str, Any]], file: str | PathLike[str] = DATA / "rivals.npz"
) -> None:
    """Store rows of `compare`, over what was there, for `load_rivals`.

    Parameters
    ----------
    rows : iterable of dict
        From `compare`. Lengths are kept in double precision, for they are
        compared with each other to round-off.
    file : path-like, optional
        Where to.

    Raises
    ------
    InvalidParameter
        For what are no such rows.
    InvalidData
        For a file that cannot be written.
    """
    write_rows(file, check_rows(rows), STORED)


def load_rivals(file: str | PathLike[str] = DATA / "rivals.npz") -> list[dict[str, Any]]:
    """Stored rows of `compare`, one a question and rival.

    Parameters
    ----------
    file : path-like, optional
        Written by ``tests/benchmarks/rivals.py``.

    Returns
    -------
    list of dict
        What `STORED` names. ``(row["set"], row["question"])`` is the case that
        `pose_question` makes a question of, but for BARN's worlds, which are no part of
        this collection.

    Raises
    ------
    InvalidData
        For a file that cannot be read, holds anything else, or two rows of the same
        question and rival.
    """
    again = "compare the rivals again"
    rows = read_rows(file, STORED, again)
    for row in rows:
        # The paper's cases have names, random worlds and BARN's a number.
        if row["question"].isdecimal():
            row["question"] = int(row["question"])
    if not rows or len({(row["set"], row["question"], row["rival"]) for row in rows}) < len(rows):
        raise InvalidData(f"{file} holds no rows, or one twice; {again}")
    return rows


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
        ``collisions``; ``wrong``, tracks that do not arrive without saying so;
        ``keeps``, those solved that keep R_D. Of the questions that are solvable and
        solved: ``near``, the share within 1 % of the optimum; ``median_ratio``,
        ``p95_ratio`` and ``max_ratio`` of the length to the optimum. Of all solved:
        ``equal_ratio``, the median of the length to the optimum of who keeps no more
        than that track does; ``clearance_m``,
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
    ordered = check_rows(rows)
    exact = {(row["set"], row["question"]): row["ms"] for row in ordered if row["rival"] == EXACT}
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
    named = np.array([row["outcome"] != "path" for row in group])
    length, optimum, equal, clearance, turning, keeps, ms = (
        np.array([row[name] for row in group], float) for name in _NUMBERS
    )
    exact_ms = np.array([exact.get((row["set"], row["question"]), math.nan) for row in group])
    solvable, solved = np.isfinite(optimum), arrives & ~collides
    keeping = solved & (clearance >= keeps - ALIKE)
    near = solved & (length <= optimum * (1 + NEAR_OPTIMUM))
    ratio = (length / optimum)[solvable & solved]
    return {
        "questions": len(group),
        "solvable": int(solvable.sum()),
        "solved": int(solved.sum()),
        "collisions": int(collides.sum()),
        "wrong": int((~arrives & ~named).sum()),
        "keeps": int(keeping.sum()),
        "near": _of(np.mean, near[solvable & solved]),
        "median_ratio": _of(np.median, ratio),
        "p95_ratio": _of(np.quantile, ratio, 0.95),
        "max_ratio": _of(np.max, ratio),
        "equal_ratio": _of(np.median, (length / equal)[solved & np.isfinite(equal)]),
        "clearance_m": _of(np.min, clearance[solved]),
        "turning_rad": _of(np.median, turning[solved]),
        "median_ms": _of(np.median, ms),
        "p95_ms": _of(np.quantile, ms, 0.95),
        "shorter": int((keeping & (length < optimum - ALIKE)).sum()),
        "faster": int((near & (ms < exact_ms)).sum()),
    }


_FLAGS = "arrives", "collides"
_NUMBERS = "length_m", "optimum_m", "equal_m", "clearance_m", "turning_rad", "keeps_m", "ms"


def _of(number: Callable[..., Any], values: np.ndarray, *more: float) -> float:
    """A number of some values; NaN where there is none."""
    return float(number(values, *more)) if len(values) else math.nan


def check_rows(rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows of `compare` as a list, or `InvalidParameter`."""
    remedy = "rows of compare, one or more"
    found: list[Mapping[str, Any]] = checks.instances("rows", rows, Mapping, remedy)
    if not found or any(STORED.keys() - row.keys() for row in found):
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give {remedy}")
    return found
