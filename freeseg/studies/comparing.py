"""Tuned laws on courses that no search has seen: what is stored, and what it says."""

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks
from freeseg.data import DATA, read_arrays
from freeseg.errors import InvalidData
from freeseg.path import Line, Path
from freeseg.reference import SPEED, make_reference
from freeseg.robot import KheperaIV
from freeseg.studies.courses import DT, random_courses, spread_offsets
from freeseg.studies.statistics import differences, verdict
from freeseg.studies.tracking import DISTURBANCE, REGIMES, ROUGHNESS, SINGLE, disturbed, evaluate
from freeseg.studies.tuning import PRICES, REPLICATES
from freeseg.trackers.feedback import check_tracker
from freeseg.trackers.predictor import Predicting

#: What the laws are judged on: courses, robots and noise that nothing before has touched.
JUDGED = {"courses": 16, "robots": 8, "seed": 20_000}

#: A smaller difference of position errors is called none (m): a tenth of the noise of a
#: measured position. It was stated before the runs that are judged were made.
NO_DIFFERENCE = 1e-4

#: What is kept of a run.
KEPT = ("position_rms_m", "roughness_m_s2", "settling_time_s", "hit")


#: What the laws are called, in the order of `tuning.RANGES`.
LAWS = {
    "SlidingMode": "sliding mode",
    "SuperTwisting": "super-twisting",
    "Kanayama": "Kanayama",
    "Lqr": "LQR",
    "FeedbackLinearisation": "linearisation",
    "PurePursuit": "pure pursuit",
    "Stanley": "Stanley",
    "Fuzzy": "fuzzy",
    "Pid": "PID",
    "Mpc": "MPC",
}


class Cell(NamedTuple):
    """A way in which all laws are tuned and judged.

    Attributes
    ----------
    form : str
        One of `tuning.FORMS`.
    regime : str
        One of `tracking.REGIMES`.
    price : float
        Of roughness, that the gains are tuned for (s^2).
    told : float
        Times the delay and the lag of `tracking.DISTURBANCE` that a law is told.
    """

    form: str
    regime: str
    price: float = ROUGHNESS
    told: float = 1.0


#: All of them. Where all that disturbs is three times as strong, gains are those of the
#: nominal regime.
COMPARED = (
    Cell("plain", "nominal"),
    Cell("told", "nominal"),
    *(Cell("observed", "nominal", price) for price in PRICES),
    *(Cell(form, regime) for regime in ("far starts", "fast") for form in ("plain", "observed")),
    Cell("plain", "disturbed"),
    Cell("observed", "disturbed"),
    Cell("observed", "disturbed", told=REGIMES["disturbed"].times),
)


def judge(tracker: Any, regime: str, courses: int = JUDGED["courses"]) -> dict[str, np.ndarray]:
    """Numbers of a law on the courses that all laws are judged on.

    Parameters
    ----------
    tracker : Tracker
        As `tuning.make_tracker` makes it.
    regime : str
        One of `tracking.REGIMES`.
    courses : int, optional
        Only the first of them.

    Returns
    -------
    dict
        As `tracking.evaluate`, shape (courses, robots).

    Raises
    ------
    InvalidParameter
        For an unknown regime, and as `evaluate`.
    """
    under, seed = REGIMES[checks.choice("regime", regime, REGIMES)], JUDGED["seed"]
    found = random_courses(JUDGED["courses"], seed, under.speed, under.room)
    courses = checks.whole("courses", courses, 1)
    offsets = spread_offsets(JUDGED["robots"], seed, under.offset)
    return evaluate(tracker, found[:courses], offsets, seed, disturbed(under.times))


def load_comparison(
    file: str | PathLike[str] = DATA / "comparison.npz",
) -> dict[Cell, dict[str, dict[str, np.ndarray]]]:
    """Stored runs of all laws.

    Parameters
    ----------
    file : path-like, optional
        Written by ``tests/benchmarks/compare_trackers.py``.

    Returns
    -------
    dict
        Cell to name of number, one of `KEPT`, to name of law to ndarray, shape
        (courses, robots, replicates).

    Raises
    ------
    InvalidData
        For a file that cannot be read or holds another study.
    """
    again = "compare the trackers again"
    shape = len(COMPARED), len(LAWS), JUDGED["courses"], JUDGED["robots"], REPLICATES
    arrays = {one: values.astype(float) for one, values in read_arrays(file, KEPT, again).items()}
    if any(values.shape != shape for values in arrays.values()):
        raise InvalidData(f"{file} holds no study of shape {shape}; {again}")
    return {
        cell: {
            one: dict(zip(LAWS.values(), values[number], strict=True))
            for one, values in arrays.items()
        }
        for number, cell in enumerate(COMPARED)
    }


def against(values: Mapping[str, np.ndarray], law: str) -> dict[str, tuple[float, float, float]]:
    """How far a law is from each other one, with simultaneous intervals of all pairs.

    Parameters
    ----------
    values : dict
        As for `statistics.differences`.
    law : str
        One of its names.

    Returns
    -------
    dict
        Name of each other law to mean, low and high of `law` minus the other.

    Raises
    ------
    InvalidParameter
        For an unknown law, and as `differences`.
    """
    checks.instance("values", values, Mapping, "a dict of name to numbers")  # type: ignore[type-abstract]
    checks.choice("law", law, values)
    found = {}
    for one in differences(values):
        if one.first == law:
            found[one.second] = one.mean, one.low, one.high
        elif one.second == law:
            found[one.first] = -one.mean, -one.high, -one.low
    return found


def in_words(
    found: Mapping[str, tuple[float, float, float]], margin: float, unit: str, factor: float = 1
) -> str:
    """One sentence on how a law stands to the others, where small is good.

    Parameters
    ----------
    found : dict
        As `against` returns it.
    margin : float
        Differences that count as none.
    unit : str
        What the differences are told in.
    factor : float, optional
        Of that unit in one of `found`.

    Returns
    -------
    str

    Raises
    ------
    InvalidParameter
        For what are no intervals, no margin, no factor or no text.
    """
    checks.instance("found", found, Mapping, "what `against` returns")  # type: ignore[type-abstract]
    checks.instance("unit", unit, str, "a text"), checks.positive("factor", factor)
    said = [verdict(low, high, margin) for _, low, high in found.values()]
    ends = [
        f"{factor * mean:+.2f} [{factor * low:.2f}, {factor * high:.2f}]"
        for mean, low, high in sorted(found.values())
    ]
    return (
        f"better than {said.count('smaller')} of {len(said)}, equivalent to "
        f"{said.count('equivalent')}, worse than {said.count('larger')}, undecided "
        f"{said.count('undecided')}; differences from {ends[0]} to {ends[-1]} {unit}"
    )


def local_gains(tracker: Any, speed: float = SPEED) -> dict[str, float]:
    """How the command of a law answers small errors on a straight line.

    Parameters
    ----------
    tracker : Tracker
        What it is told of delay, lag and slip is left out.
    speed : float, optional
        Of the reference (m/s).

    Returns
    -------
    dict
        ``v_per_x`` (1/s), ``omega_per_y`` (1/(m s)) and ``omega_per_alpha``
        (1/s): by how much a speed and a turn rate grow with an error of (7), as
        far as the noise of a measured pose goes.

    Raises
    ------
    InvalidParameter
        As the law.

    Notes
    -----
    Of what a law integrates, only what one time step adds is in it.
    """
    speed = checks.positive("speed", speed)
    check_tracker(tracker)
    if type(tracker).__name__ in SINGLE:
        tracker = replace(tracker, delay=0.0, lag=0.0, observer=0.0)
    elif isinstance(tracker, Predicting):
        tracker = tracker.tracker
    reference = make_reference(Path([Line((0, 0), (10 * speed, 0))]), speed=speed)
    times = DT * np.arange(int(5 / DT))
    poses = reference.at(times).pose
    position, heading = DISTURBANCE.position_noise, DISTURBANCE.heading_noise

    def command(axis: int, error: float) -> np.ndarray:
        law = tracker.start(reference, KheperaIV(), DT)
        moved = poses[:, -1].copy()
        moved[axis] -= error
        for t, pose in zip(times[:-1], poses.T[:-1], strict=True):
            law(t, pose)
        return np.array(law(times[-1], moved), dtype=float)

    x, y, alpha = (
        (command(axis, size) - command(axis, -size)) / (2 * size)
        for axis, size in enumerate((position, position, heading))
    )
    return {
        "v_per_x": float(x[0]),
        "omega_per_y": float(y[1]),
        "omega_per_alpha": float(alpha[1]),
    }
