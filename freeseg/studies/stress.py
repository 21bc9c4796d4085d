"""How often robots fail: random disturbances, counted, split, and traced to their causes.

All of the protocol is an assumption, for the paper shows two runs. What
`tracking.DISTURBANCE` fixes of slip and wheel base is here the standard deviation of what
differs from run to run.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, metrics
from freeseg.data import DATA, read_arrays
from freeseg.disturbance import CHANNELS, Disturbance, shaken
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.geometry import read_only
from freeseg.react import ARRIVED
from freeseg.robot import Robot, with_wheel_base
from freeseg.simulate import Run, simulate
from freeseg.studies.courses import (
    DT,
    OFFSET,
    WIDE_MARGIN,
    Course,
    paper_courses,
    random_courses,
)
from freeseg.studies.splitting import Tail, split
from freeseg.studies.tracking import DISTURBANCE, SINGLE
from freeseg.studies.tuning import Tuned, load_gains
from freeseg.trackers.feedback import check_tracker

#: What a run has from its beginning, and its standard deviations: slip of both wheels, error of
#: the wheel base, and where it begins, ahead and to the left (m) and turned (rad).
STATICS = ("slip_right", "slip_left", "wheel_base", "ahead", "left", "turned")
SPREADS = (
    *np.broadcast_to(DISTURBANCE.slip, 2).tolist(),
    DISTURBANCE.wheel_base_error,
    OFFSET[0] / 2,
    OFFSET[0] / 2,
    OFFSET[1] / 2,
)

#: What can be stronger or weaker, each by a factor, and what of `Disturbance` that is.
CAUSES = ("noise", "slip", "slip_fluctuation", "wheel_base", "start", "delay")

#: Strengths that are tried, of one cause after the other.
STRENGTHS = (2.0, 4.0, 8.0)

#: Laws that are put under stress, in their best form; of each, the gains that did best on the
#: courses they were searched on.
STRESSED = ("SlidingMode", "Mpc", "Pid")

#: Runs, each on a course of its own, that none of the searches has seen: so many, and of these
#: so many for each cause and strength.
COUNTED, COUNTED_STRONG = 600, 120

#: Seed of the first of their worlds, and how many worlds are tried for each at most.
COUNTED_SEED, SEEDS_BETWEEN = 30_000, 100

#: Levels of shortfall (m) that splitting estimates, and the probability at which it ends.
SHORTFALLS, RAREST = tuple(0.0005 * np.arange(2, 41)), 1e-7

#: What is split: laws and courses, see `rare_courses`. An MPC drives no batches, and has smaller
#: populations that end earlier.
SPLIT = (
    *((law, course) for course in range(4) for law in ("SlidingMode", "Pid")),
    ("Mpc", 1),
)
FEWER: dict[str, Any] = {
    "populations": 5, "particles": 60, "killed": 20, "moves": 2, "least": 3e-4
}  # fmt: skip

#: Robots that drive at once, for the memory of their numbers.
MOST_AT_ONCE = 2600

#: Farther from the reference than this (m) at any time, a robot is lost; farther from the goal
#: than `ARRIVED`, so long (s) after the reference ends, it has not arrived.
LOST, SETTLE = 0.1, 2.0


class Outcome(NamedTuple):
    """What came of n runs.

    Attributes
    ----------
    gap : ndarray, shape (n,)
        Smallest distance between the robot's rim and an obstacle (m); negative where it
        would have to drive through it.
    farthest : ndarray, shape (n,)
        Largest distance from the reference (m).
    missed : ndarray, shape (n,)
        Distance from the goal at the end (m).
    """

    gap: np.ndarray
    farthest: np.ndarray
    missed: np.ndarray

    @property
    def contact(self) -> np.ndarray:
        """Whether the robot touches an obstacle, shape (n,)."""
        return self.gap < 0

    @property
    def failed(self) -> np.ndarray:
        """Whether it touches one, is lost or does not arrive, shape (n,)."""
        return self.contact | (self.farthest > LOST) | (self.missed > ARRIVED)


#: What is kept of a run.
KEPT_OF_RUN = Outcome._fields


@dataclass(frozen=True, eq=False)
class Drawn(Disturbance):
    """A disturbance whose random numbers are given: each robot has its own.

    Parameters
    ----------
    noise : ndarray, shape (3, n)
        Standard deviations of what is measured, of each robot: x, y (m), heading (rad).
    slips : ndarray, shape (2, n)
        Share of travel that each robot's right and left wheel lose.
    fluctuation : ndarray, shape (n,)
        As `slip_fluctuation`, of each robot.
    bases : ndarray, shape (n,)
        As `wheel_base_error`, of each robot.
    numbers : ndarray, shape (N, 5, n)
        Standard normal numbers for every sample, see `disturbance.normals`.

    Notes
    -----
    Lag and delay are those of all robots. A robot that drives alone has the
    first of each.
    """

    noise: np.ndarray = field(default_factory=lambda: np.zeros((3, 1)))
    slips: np.ndarray = field(default_factory=lambda: np.zeros((2, 1)))
    fluctuation: np.ndarray = field(default_factory=lambda: np.zeros(1))
    bases: np.ndarray = field(default_factory=lambda: np.zeros(1))
    numbers: np.ndarray = field(default_factory=lambda: np.zeros((1, CHANNELS, 1)))

    @property
    def noisy(self) -> bool:
        """Always: which robot measures without noise is not asked."""
        return True

    def samples(
        self, shape: tuple[int, ...], count: int, dt: float, seed: int | tuple[int, ...]
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """As `Disturbance.samples`, of the numbers given; the seed counts for nothing."""
        noise, slips, fluctuation, numbers = (
            values if shape else values[..., 0]
            for values in (self.noise, self.slips, self.fluctuation, self.numbers)
        )
        if len(numbers) < count:
            raise InvalidParameter(f"numbers has {len(numbers)} samples; give {count}")
        yield from shaken(numbers[:count], noise, slips, 1.0, fluctuation, self.slip_time, dt)

    def plant(self, robot: Robot) -> Robot:
        """The robot as it is, with a wheel base for each of a batch."""
        # A robot's sizes are numbers; the arithmetic of the loop takes arrays.
        errors = self.bases if len(self.bases) > 1 else self.bases[0]
        return with_wheel_base(robot, robot.wheel_base * (1 + errors))


def draw(
    statics: np.ndarray, numbers: np.ndarray, times: Mapping[str, Any] | None = None
) -> tuple[np.ndarray, Drawn]:
    """Where robots begin, and what disturbs them, of standard normal numbers.

    Parameters
    ----------
    statics : ndarray, shape (6, n)
        What each robot has from its beginning, see `STATICS`.
    numbers : ndarray, shape (N, 5, n)
        Its noise and its slip at every sample.
    times : dict, optional
        A cause, one of `CAUSES`, to a factor, or to n of them; 1 where it is not
        named. That of the delay is for all robots, and for the lag, too.

    Returns
    -------
    offsets : ndarray, shape (3, n)
        For `simulate`.
    disturbance : Drawn

    Raises
    ------
    InvalidParameter
        For arrays of other shapes, an unknown cause, and what are no factors.
    """
    statics = checks.array("statics", statics, (len(STATICS), None))
    count = statics.shape[1]
    numbers = checks.array("numbers", numbers, (None, CHANNELS, count))
    factor = _factors({} if times is None else times, count)
    slip_right, slip_left, base, *start = np.array(SPREADS)[:, None] * statics
    white = [DISTURBANCE.position_noise] * 2 + [DISTURBANCE.heading_noise]
    late = factor.pop("delay")
    disturbance = Drawn(
        noise=np.multiply.outer(white, factor["noise"]),
        # Wheels that lose all of their travel, or more, drive nowhere.
        slips=np.clip(factor["slip"] * np.stack([slip_right, slip_left]), -0.95, 0.95),
        fluctuation=DISTURBANCE.slip_fluctuation * factor["slip_fluctuation"],
        bases=np.maximum(factor["wheel_base"] * base, -0.95),
        numbers=numbers,
        slip_time=DISTURBANCE.slip_time,
        lag=late * DISTURBANCE.lag,
        delay=late * DISTURBANCE.delay,
    )
    return factor["start"] * np.stack(start), disturbance


def _factors(times, count):
    """Each cause to its factors, shape (count,), but that of the delay: one number."""
    checks.instance("times", times, Mapping, "a dict of cause to factor")
    factor = dict.fromkeys(CAUSES, np.ones(count)) | {"delay": 1.0}
    for cause, value in times.items():
        checks.choice("times", cause, CAUSES)
        given = checks.array("times", value, (), (count,))
        if (given < 0).any() or (cause == "delay" and given.ndim):
            raise InvalidParameter(
                f"times has {checks.shown(value)} for {cause}; give zero or more, one for the delay"
            )
        factor[cause] = float(given) if cause == "delay" else np.broadcast_to(given, (count,))
    return factor


def drive_drawn(tracker: Any, course: Course, offsets: np.ndarray, drawn: Drawn) -> Run:
    """Robots that follow a course, each with numbers of its own; then `SETTLE` seconds more.

    Parameters
    ----------
    tracker : Tracker
        One that drives a single robot drives the only one there is.
    course : Course
        What to follow.
    offsets : ndarray, shape (3, n)
        Where they begin.
    drawn : Drawn
        What disturbs them.

    Returns
    -------
    Run
        A batch of n, or one robot.

    Raises
    ------
    InvalidParameter
        For what is no course, or several robots for a tracker that drives one; and as `simulate`.
    """
    _check_course(course)
    alone = type(tracker).__name__ in SINGLE
    if alone and offsets.shape[1] != 1:
        raise InvalidParameter(f"{type(tracker).__name__} drives one robot; give one")
    offset = offsets[:, 0] if alone else offsets
    return simulate(tracker, course.reference, None, DT, offset, drawn, 0, SETTLE, 1e-9)


def _check_course(course: Any) -> None:
    """`InvalidParameter` for what is no course."""
    checks.instance("course", course, Course, "a Course, such as one of paper_courses()")


def samples_of(course: Course) -> int:
    """How many samples of random numbers a run on a course takes."""
    _check_course(course)
    return len(course.reference.steps(DT)) + int(np.ceil(SETTLE / DT - 1e-9))


def outcome(
    tracker: Any,
    course: Course,
    statics: np.ndarray,
    numbers: np.ndarray,
    times: Mapping[str, Any] | None = None,
) -> Outcome:
    """What comes of runs on a course.

    Parameters
    ----------
    tracker, course
        As for `drive_drawn`.
    statics, numbers, times
        As for `draw`; at least `samples_of` the course.

    Returns
    -------
    Outcome

    Raises
    ------
    InvalidParameter
        As `draw` and `simulate`.

    Notes
    -----
    The gap is measured at the samples, 5 mm apart at 0.1 m/s: beside a disc
    of 30 mm, the robot is nearer in between by less than 0.1 mm.
    """
    run = drive_drawn(tracker, course, *draw(statics, numbers, times))
    found = metrics.tracking(run, course.world)
    names = "clearance_m", "position_max_m", "position_final_m"
    clearance, farthest, missed = (np.atleast_1d(found[name]) for name in names)
    return Outcome(*map(read_only, (clearance - run.robot.radius, farthest, missed)))


def best_laws() -> dict[str, Any]:
    """The laws of `STRESSED`, told of delay and lag and with an observer of slip."""
    found = load_gains(form="observed")
    return {name: min(found[name], key=_score).tracker for name in STRESSED}


def _score(tuned: Tuned) -> float:
    return tuned.score


def counted_course(number: int) -> Course:
    """One of the courses that failures are counted on: the first of its own random worlds."""
    number = checks.whole("number", number)
    if number >= COUNTED:
        raise InvalidParameter(f"number is {number}; give less than {COUNTED}")
    return random_courses(1, COUNTED_SEED + SEEDS_BETWEEN * number)[0]


def count_failures(tracker: Any, number: int, strong: bool) -> dict[str, dict[str, np.ndarray]]:
    """One run on a course of its own; and again, with one cause after the other made stronger.

    Parameters
    ----------
    tracker : Tracker
        As of `best_laws`.
    number : int
        Which of `COUNTED` courses; the random numbers hang on it, too, and are the
        same for all laws and all strengths.
    strong : bool
        Whether causes are made stronger.

    Returns
    -------
    dict
        ``"nominal"``, and each cause where strong, to `Outcome`'s numbers, of the
        shape of `STRENGTHS` for a cause and (1,) else.

    Raises
    ------
    InvalidParameter
        For what is no tracker or no such number.
    """
    course = counted_course(number)
    rng = np.random.default_rng((COUNTED_SEED, number))
    statics = rng.standard_normal((len(STATICS), 1))
    numbers = rng.standard_normal((samples_of(course) + 1, CHANNELS, 1))
    cells: list[dict[str, Any]] = [{}]
    if checks.flag("strong", strong):
        cells += [{cause: strength} for cause in CAUSES for strength in STRENGTHS]
    outcomes = _try_cells(tracker, course, statics, numbers, cells)
    found = {"nominal": outcomes[:1]}
    for place, cause in enumerate(CAUSES if strong else ()):
        first = 1 + place * len(STRENGTHS)
        found[cause] = outcomes[first : first + len(STRENGTHS)]
    return {
        cause: {name: np.concatenate([getattr(one, name) for one in some]) for name in KEPT_OF_RUN}
        for cause, some in found.items()
    }


def _try_cells(tracker, course, statics, numbers, cells):
    """An `Outcome` for each cell; what can drive together does."""
    if type(tracker).__name__ in SINGLE:
        return [outcome(tracker, course, statics, numbers, cell) for cell in cells]
    together = [cell for cell in cells if "delay" not in cell]
    times = {
        cause: np.array([cell.get(cause, 1.0) for cell in together])
        for cause in CAUSES
        if cause != "delay"
    }
    many = len(together)
    batch = outcome(
        tracker, course, np.repeat(statics, many, 1), np.repeat(numbers, many, 2), times
    )
    found = [Outcome(*(one[[k]] for one in batch)) for k in range(many)]
    return found + [
        outcome(tracker, course, statics, numbers, cell) for cell in cells if "delay" in cell
    ]


def shortfall(
    tracker: Any, course: Course, margin: float = WIDE_MARGIN
) -> tuple[Callable[[np.ndarray], np.ndarray], int]:
    """How much nearer to obstacles than planned a robot comes, as a level for `split`.

    Parameters
    ----------
    tracker : Tracker
    course : Course
    margin : float, optional
        Security margin of the course's plan (m), of which half is on either side.

    Returns
    -------
    level : callable
        Standard normal numbers, shape (dimensions, m), to shortfall (m), shape (m,): half of
        the margin less the gap, so that a plan of margin d is touched where it is
        more than d/2, as far as the path keeps its shape.
    dimensions : int
    """
    check_tracker(tracker)
    samples, margin = samples_of(course) + 1, checks.not_negative("margin", margin)

    def level(numbers: np.ndarray) -> np.ndarray:
        statics, noise = numbers[: len(STATICS)], numbers[len(STATICS) :]
        noise = noise.reshape(samples, CHANNELS, -1)
        if type(tracker).__name__ not in SINGLE:
            return margin / 2 - outcome(tracker, course, statics, noise).gap
        return np.array(
            [
                margin / 2 - outcome(tracker, course, statics[:, [k]], noise[..., [k]]).gap[0]
                for k in range(statics.shape[1])
            ]
        )

    return level, len(STATICS) + samples * CHANNELS


def rare_courses() -> tuple[Course, ...]:
    """Courses that are split on: the paper's two, and two in random worlds."""
    return paper_courses() + tuple(map(counted_course, range(2)))


def split_shortfall(law: str, course: int) -> Tail:
    """Tail of the shortfall of a law on a course: one of `SPLIT`.

    Parameters
    ----------
    law : str
        One of `STRESSED`.
    course : int
        Of `rare_courses`.

    Returns
    -------
    Tail

    Raises
    ------
    InvalidParameter
        For an unknown law or course.
    """
    courses = rare_courses()
    tracker = best_laws()[checks.choice("law", law, STRESSED)]
    course = checks.whole("course", course)
    if course >= len(courses):
        raise InvalidParameter(f"course is {course}; give less than {len(courses)}")
    level, dimensions = shortfall(tracker, courses[course])
    sizes: dict[str, Any] = FEWER if type(tracker).__name__ in SINGLE else {"least": RAREST}
    return split(level, dimensions, SHORTFALLS, **sizes)


def sensitivity(
    tracker: Any, course: Course, number: int = 128, robots: int = 32, seed: int = 0
) -> Any:
    """Which assumed strength matters most: Sobol's indices of the mean shortfall.

    Parameters
    ----------
    tracker : Tracker
        One that drives batches.
    course : Course
        What to follow.
    number : int, optional
        Base samples, a power of two: of these, `scipy.stats.sobol_indices` makes
        ``number * (causes + 2)`` sets of strengths.
    robots : int, optional
        Runs for each set, the same for all of them.
    seed : int, optional
        Of the sets and of the runs.

    Returns
    -------
    scipy.stats' SobolResult
        ``first_order`` and ``total_order``, shape (6,), in the order of `CAUSES`, and
        ``bootstrap``. Each strength is uniform from 0 to 2; delay and lag are 0, 1 or
        2 times theirs, all three as likely.

    Raises
    ------
    InvalidParameter
        For a tracker that drives one robot only, and numbers that make no sense.
    """
    from scipy.stats import sobol_indices, uniform

    if type(tracker).__name__ in SINGLE:
        raise InvalidParameter(f"{type(tracker).__name__} drives one robot; give a law for batches")
    number = checks.whole("number", number, 1, most=MOST_AT_ONCE)
    if number & (number - 1):
        raise InvalidParameter(f"number is {number}; give a power of two")
    robots = checks.whole("robots", robots, 1, most=MOST_AT_ONCE)
    seed = checks.whole("seed", seed)
    rng = np.random.default_rng(seed)
    statics = rng.standard_normal((len(STATICS), robots))
    noise = rng.standard_normal((samples_of(course) + 1, CHANNELS, robots))

    def mean_shortfall(strengths: np.ndarray) -> np.ndarray:
        late = np.minimum(np.floor(1.5 * strengths[CAUSES.index("delay")]), 2)
        found = np.empty(strengths.shape[1])
        for delay in range(3):
            for part in np.array_split(*_parts(late == delay, MOST_AT_ONCE // robots)):
                many = len(part)
                if not many:
                    continue
                times = {
                    cause: np.repeat(strengths[k, part], robots) for k, cause in enumerate(CAUSES)
                } | {"delay": float(delay)}
                runs = outcome(tracker, course, np.tile(statics, many), np.tile(noise, many), times)
                found[part] = WIDE_MARGIN / 2 - runs.gap.reshape(many, robots).mean(1)
        return found

    return sobol_indices(
        func=mean_shortfall, n=number, dists=[uniform(0, 2)] * len(CAUSES), rng=seed
    )


def _parts(chosen, size):
    """Indices of what is chosen, and into how many parts of a size they go."""
    places = np.flatnonzero(chosen)
    return places, max(-(-len(places) // size), 1)


class Stress(NamedTuple):
    """What is stored of this study.

    Attributes
    ----------
    counts : dict
        Law to cause, or ``"nominal"``, to `Outcome` of shape (courses, strengths).
    tails : dict
        Law and course, as in `SPLIT`, to `Tail`.
    sobol : dict
        Law to ndarray, shape (2, 3, 6): first and total index; estimate, low and
        high; of each of `CAUSES`.
    checked : dict
        True probability to ndarray, shape (repeats, 4): estimates, low and high ends,
        runs.
    """

    counts: dict[str, dict[str, Outcome]]
    tails: dict[tuple[str, int], Tail]
    sobol: dict[str, np.ndarray]
    checked: dict[float, np.ndarray]


def load_stress(file: str | PathLike[str] = DATA / "stress.npz") -> Stress:
    """Stored numbers of this study.

    Parameters
    ----------
    file : path-like, optional
        Written by ``tests/benchmarks/stress.py``.

    Returns
    -------
    Stress

    Raises
    ------
    InvalidData
        For a file that cannot be read or holds another study.
    """
    again = "run the study again"
    stored = read_arrays(file, again=again)
    arrays = {key: values.astype(float) for key, values in stored.items()}
    try:
        counts = {
            law: {
                cause: Outcome(*(arrays[f"{law}.{cause}.{one}"] for one in KEPT_OF_RUN))
                for cause in ("nominal", *CAUSES)
            }
            for law in STRESSED
        }
        tails = {one: _tail_of(arrays, *one) for one in SPLIT}
        sobol = {law: arrays[f"sobol.{law}"] for law in STRESSED if law not in SINGLE}
        checked = {one: arrays[f"check_{one:g}"] for one in (1e-3, 1e-6)}
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidData(f"{file} holds another study ({error}); {again}") from error
    wanted = COUNTED_STRONG, len(STRENGTHS)
    for law, cause in product(STRESSED, CAUSES):
        if (shape := counts[law][cause].gap.shape) != wanted:
            raise InvalidData(f"{file} has {shape} runs of {law}, not {wanted}; {again}")
    return Stress(counts, tails, sobol, checked)


def _tail_of(arrays: Mapping[str, np.ndarray], law: str, course: int) -> Tail:
    """A stored tail."""
    levels, share, low, high, error = arrays[f"tail.{law}.{course}"]
    return Tail(levels, share, low, high, error, int(arrays[f"runs.{law}.{course}"]))
