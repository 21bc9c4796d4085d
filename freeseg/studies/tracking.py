"""Trackers on courses: one score, and one set of disturbances, for all of them.

All of the protocol is an assumption, for the paper compares no trackers.
"""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, metrics
from freeseg.disturbance import Disturbance
from freeseg.errors import InvalidParameter
from freeseg.geometry import read_only
from freeseg.reference import SPEED
from freeseg.simulate import POSE_UNITS, Run, simulate
from freeseg.studies.courses import DT, OFFSET, Course
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS

#: What disturbs every robot.
DISTURBANCE = Disturbance(
    position_noise=0.001,
    heading_noise=np.radians(0.5),
    slip=0.05,
    slip_fluctuation=0.02,
    slip_time=0.5,
    wheel_base_error=0.03,
    lag=0.03,
    delay=0.05,
)

#: From then on, the first offset counts as forgotten (s); on a short course, from half of
#: it on.
STEADY = 4.0

#: What 1 m/s^2 of needless wheel acceleration and what a collision cost (m).
ROUGHNESS, COLLISION = 0.02, 1.0

#: Trackers whose laws drive one robot only.
SINGLE = ("Mpc",)


class Regime(NamedTuple):
    """What trackers are compared under.

    Attributes
    ----------
    speed : float
        Cruising speed (m/s).
    offset : (float, float)
        How far from the reference a robot begins at most (m, rad).
    room : float
        How far from every obstacle a course begins, see `random_courses` (m).
    times : float
        By which `DISTURBANCE` is multiplied.
    """

    speed: float = SPEED
    offset: tuple[float, float] = OFFSET
    room: float = 0.0
    times: float = 1.0


#: More often than that, wheels would lose all of their travel.
MOST_TIMES = 10

#: The regimes by name. At 0.5 m/s the wheels come to their limits. Where all that disturbs is
#: three times as strong, nobody is tuned anew.
REGIMES = {
    "nominal": Regime(),
    "far starts": Regime(offset=(0.05, np.radians(60)), room=0.06),
    "fast": Regime(speed=0.5),
    "disturbed": Regime(times=3.0),
}


def disturbed(times: float) -> Disturbance:
    """`DISTURBANCE`, so many times as strong; its correlation time stays."""
    remedy = f"a number from 0 to {MOST_TIMES}"
    times = checks.number("times", times, lambda found: 0 <= found <= MOST_TIMES, remedy)
    strengths = (one.name for one in fields(Disturbance) if one.name != "slip_time")
    made = {one: times * np.asarray(getattr(DISTURBANCE, one)) for one in strengths}
    return replace(DISTURBANCE, **{one: values.tolist() for one, values in made.items()})


def drive_course(
    tracker: Any,
    course: Course,
    offsets: np.ndarray,
    seed: int | tuple[int, ...],
    disturbance: Disturbance = DISTURBANCE,
) -> Run:
    """Robots that follow a course with one tracker, each with its own noise.

    Parameters
    ----------
    tracker : object
        Tracker; one that drives a single robot drives them one by one.
    course : Course
        What to follow.
    offsets : ndarray, shape (3, n)
        Where they begin.
    seed : int or tuple of int
        Of their noise and slip, see `simulate`.
    disturbance : Disturbance, optional
        What disturbs them.

    Returns
    -------
    Run
        A batch of n.

    Raises
    ------
    InvalidParameter
        As `simulate`, and for what is no course.
    """
    checks.instance("course", course, Course, "a Course, such as one of paper_courses()")
    offsets = checks.array("offsets", offsets, (3, None), unit=POSE_UNITS)
    entropy, first, *again = checks.seed(seed)

    def run(offset: np.ndarray, seed: int | tuple[int, ...]) -> Run:
        return simulate(tracker, course.reference, None, DT, offset, disturbance, seed)

    if type(tracker).__name__ not in SINGLE:
        return run(offsets, seed)
    robots = [k % again[0] if again else k for k in range(offsets.shape[1])]
    runs = [run(offset, (entropy, first + k)) for k, offset in zip(robots, offsets.T, strict=True)]
    names = ("pose", "error", "wheels", "measured", "asked")
    stacked: dict[str, Any] = {
        name: read_only(np.stack([getattr(one, name) for one in runs], 1)) for name in names
    }
    return replace(runs[0], **stacked)


def evaluate(
    tracker: Any,
    courses: Sequence[Course],
    offsets: np.ndarray,
    seed: int | tuple[int, ...],
    disturbance: Disturbance = DISTURBANCE,
    jobs: int | None = 1,
) -> dict[str, np.ndarray]:
    """Numbers of a tracker on courses.

    Parameters
    ----------
    tracker, offsets, seed, disturbance
        As for `drive_course`: the same robots drive on every course.
    courses : sequence of Course
        What to follow.
    jobs : int, optional
        Processes, among which the courses are shared out, see `runner.run`.

    Returns
    -------
    dict
        Name to ndarray, shape (courses, n): those of `metrics.tracking`;
        ``transient_rms_m``, the position's before `STEADY`, and
        ``steady_cross_rms_m``, ``steady_along_rms_m`` and
        ``steady_heading_rms_rad`` from then on; ``roughness_m_s2``, the total
        variation per time that the course does not need; ``hit``, 1 for a robot
        that touches an obstacle and else 0; and ``score_m``.

    Raises
    ------
    InvalidParameter
        As `drive_course`, and for no course.

    Notes
    -----
    The score is the RMS of the position error, plus `ROUGHNESS` times the
    roughness, plus `COLLISION` for a robot that touches an obstacle.
    """
    courses = checks.instances("courses", courses, Course, "a list of Courses")
    if not courses:
        raise InvalidParameter("courses is empty; give one or more")
    drive = partial(_drive, tracker, offsets, seed, disturbance)
    rows = list(run(drive, courses, jobs=jobs, strict=True))
    return {name: np.stack([row[name] for row in rows]) for name in rows[0] if name not in COLUMNS}


def _drive(
    tracker: Any,
    offsets: np.ndarray,
    seed: int | tuple[int, ...],
    disturbance: Disturbance,
    course: Course,
    _: int,
) -> dict[str, Any]:
    """Numbers of a tracker on one course; its robots have the same seed on every one."""
    driven = drive_course(tracker, course, offsets, seed, disturbance)
    row = metrics.tracking(driven, course.world)
    forgotten = min(STEADY, course.reference.duration / 2)
    steady = metrics.tracking(driven, since=forgotten)
    row["transient_rms_m"] = metrics.tracking(driven, until=forgotten)["position_rms_m"]
    row["steady_cross_rms_m"] = steady["cross_track_rms_m"]
    row["steady_along_rms_m"] = steady["along_track_rms_m"]
    row["steady_heading_rms_rad"] = steady["heading_rms_rad"]
    needless = np.maximum(row["wheel_variation_m_s"] - course.variation, 0)
    row["roughness_m_s2"] = needless / course.reference.duration
    row["score_m"] = row["position_rms_m"] + ROUGHNESS * row["roughness_m_s2"]
    row["hit"] = np.asarray(row["clearance_m"] < driven.robot.radius, dtype=float)
    row["score_m"] += COLLISION * row["hit"]
    return row
