"""Trackers compared: the same conditions, search and budget for all of them.

All of the protocol is an assumption, for the paper compares no trackers.
"""

from dataclasses import replace
from functools import cache
from itertools import count, islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

import freeseg
from freeseg import metrics
from freeseg.data import DATA, read_csv
from freeseg.disturbance import Disturbance, as_seed
from freeseg.errors import InvalidParameter, NoPath, SolverFailed
from freeseg.generate import random_query, random_world
from freeseg.planners import plan
from freeseg.reference import SMOOTHING, Reference, make_reference
from freeseg.robot import KheperaIV
from freeseg.simulate import simulate
from freeseg.world import World, load_cases, load_table

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

#: How far from the reference a robot starts at most: distance (m) and angle (rad).
START = 0.01, np.radians(10)

#: Time step (s), cruising speed (m/s) and security margin of the plans (m).
DT, SPEED, MARGIN = 0.05, 0.1, 0.03

#: From then on, the start counts as forgotten (s); on a short course, from half of it on.
STEADY = 4.0

#: What 1 m/s^2 of needless wheel acceleration and what a collision cost (m).
ROUGHNESS, COLLISION = 0.02, 1.0

#: Obstacles of a random world, and what makes a plan worth driving: turns and length (m).
OBSTACLES, TURNS, LENGTH = 8, 2, 0.7

#: How many courses, how many robots on each, and the first seed of their worlds and of the robots.
TRAINING = {"courses": 4, "robots": 4, "seed": 0}
HELD_OUT = {"courses": 12, "robots": 8, "seed": 1000}

#: Evaluations of a search, and of these how many a generation has.
BUDGET, POPULATION = 160, 16

#: Where gains are searched for, on a logarithmic scale: ten times the default both ways, and a
#: hundred times for weights of squares; further down for two gains of `SuperTwisting`, where a
#: first search ended. The default weight of `Mpc` on accelerations is for a robot without delay,
#: and lies at the end of its range.
RANGES = {
    "SlidingMode": {
        "k1": (0.04, 4),
        "k2": (0.2, 20),
        "phi1": (0.01, 1),
        "phi2": (0.05, 5),
        "length_scale": (0.0045, 0.45),
    },
    "SuperTwisting": {
        "lambda1": (0.03, 3),
        "lambda2": (0.02, 20),
        "w1": (0.001, 0.1),
        "w2": (0.001, 1),
        "length_scale": (0.008, 0.8),
    },
    "Kanayama": {"k_x": (0.2, 20), "k_y": (10, 1000), "k_alpha": (2, 200)},
    "Lqr": {"q_x": (0.04, 400), "q_y": (1, 1e4), "q_alpha": (0.02, 200)},
    "FeedbackLinearisation": {"k1": (0.2, 20), "k2": (0.2, 20), "ahead": (0.006, 0.6)},
    "PurePursuit": {"lookahead": (0.006, 0.6), "k_x": (0.2, 20)},
    "Stanley": {
        "k": (0.2, 20),
        "k_x": (0.2, 20),
        "softening": (0.002, 0.2),
        "ahead": (0.006, 0.6),
    },
    "Fuzzy": {
        "x_range": (0.01, 1),
        "y_range": (0.02, 2),
        "alpha_range": (0.1, 10),
        "v_range": (0.02, 2),
        "omega_range": (0.2, 20),
    },
    "Pid": {
        "kp_x": (0.3, 30),
        "ki_x": (0.09, 9),
        "kp_y": (34, 3400),
        "ki_y": (76, 7600),
        "kd_y": (2.9, 290),
    },
    "Mpc": {"heading": (3e-6, 0.03), "acceleration": (1e-6, 0.01), "terminal": (0.1, 1000)},
}

#: Trackers whose laws drive one robot only.
SINGLE = ("Mpc",)


class Course(NamedTuple):
    """A reference among obstacles; ``variation`` is its `needed_variation`."""

    name: str
    world: World
    reference: Reference
    variation: float


class Tuned(NamedTuple):
    """A tracker with the gains that a search found.

    ``score`` is theirs on the training courses, ``held_out`` that on courses
    the search never saw (m); ``chosen`` marks the seed with the best score.
    """

    tracker: object
    seed: int
    budget: int
    score: float
    held_out: float
    chosen: bool


def make_course(name, world, start, goal, speed=SPEED, neighbours="delaunay"):
    """Plan a way and a timed reference along it.

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
    neighbours : {"delaunay", "chain"}, optional
        See `plan`.

    Returns
    -------
    course : Course
        With smoothed curvature.
    worth : bool
        Whether it has at least `TURNS` turns and the length `LENGTH`.
    """
    made = plan(world, start, goal, margin=MARGIN, neighbours=neighbours)
    reference = make_reference(made.path, speed=speed, smoothing=SMOOTHING, world=world)
    worth = len(made.turning_points) >= TURNS and made.path.length >= LENGTH
    return Course(name, world, reference, needed_variation(reference)), worth


def needed_variation(reference):
    """Total variation of the faster-changing wheel (m/s) that a reference needs by itself."""
    wanted = reference.at(reference.steps(DT) + DT / 2)
    wheels = KheperaIV().to_wheels(wanted.v, wanted.omega)
    return float(np.abs(np.diff(wheels, prepend=0.0)).sum(-1).max())


@cache
def random_courses(number, seed, speed=SPEED):
    """Courses through random worlds that take some turning.

    Parameters
    ----------
    number : int
        How many.
    seed : int
        Seed of the first world; those without a way, or with one that is
        hardly worth driving, are left out.
    speed : float, optional
        Cruising speed (m/s).

    Returns
    -------
    tuple of Course
    """

    def tries():
        for k in count(seed):
            world = random_world(OBSTACLES, k)
            ends = random_query(world, k, margin=MARGIN)
            try:
                course, worth = make_course(f"random {k}", world, *ends, speed)
            except NoPath:
                continue
            if worth:
                yield course

    return tuple(islice(tries(), number))


@cache
def paper_courses(speed=SPEED):
    """The paper's cases 15(a) and 16(b), a tuple of Course."""
    cases = [load_cases()[name] for name in ("15a", "16b")]
    return tuple(
        make_course(case.name, load_table(case.table), case.start, case.goal, speed, "chain")[0]
        for case in cases
    )


@cache
def held_out_courses(speed=SPEED):
    """Courses that no search sees: random ones and the paper's, a tuple of Course."""
    return random_courses(HELD_OUT["courses"], HELD_OUT["seed"], speed) + paper_courses(speed)


def starts(robots, seed):
    """Offsets of some robots, spread evenly over the disc and the angles of `START`.

    Parameters
    ----------
    robots : int
        How many.
    seed : int
        Equal seeds give equal offsets.

    Returns
    -------
    ndarray, shape (3, robots)
        For `simulate`: a Latin hypercube, so that a few robots do not all
        start near by.
    """
    from scipy.stats import qmc

    radius, direction, turned = qmc.LatinHypercube(3, rng=seed).random(robots).T
    distance, angle = START[0] * np.sqrt(radius), 2 * np.pi * direction
    turned = START[1] * (2 * turned - 1)
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), turned])


def drive(tracker, course, offsets, seed, disturbance=DISTURBANCE):
    """Robots that follow a course with one tracker, each with its own noise.

    Parameters
    ----------
    tracker : object
        Tracker; one that drives a single robot drives them one by one.
    course : Course
        What to follow.
    offsets : ndarray, shape (3, n)
        Where they start.
    seed : int
        Of their noise and slip.
    disturbance : Disturbance, optional
        What disturbs them.

    Returns
    -------
    Run
        A batch of n.
    """

    def run(offset, seed):
        return simulate(tracker, course.reference, None, DT, offset, disturbance, seed)

    if type(tracker).__name__ not in SINGLE:
        return run(offsets, seed)
    runs = [run(offset, (seed, k)) for k, offset in enumerate(offsets.T)]
    names = ("pose", "error", "wheels", "measured", "asked")
    stacked = {name: np.stack([getattr(one, name) for one in runs], 1) for name in names}
    return replace(runs[0], **stacked)


def evaluate(tracker, courses, offsets, seed, disturbance=DISTURBANCE):
    """Numbers of a tracker on courses.

    Parameters
    ----------
    tracker, offsets, seed, disturbance
        As for `drive`: the same robots drive on every course.
    courses : sequence of Course
        What to follow.

    Returns
    -------
    dict
        Name to ndarray, shape (courses, n): those of `metrics.tracking`;
        ``transient_rms_m``, the position's before `STEADY`, and
        ``steady_cross_rms_m``, ``steady_along_rms_m`` and
        ``steady_heading_rms_rad`` from then on; ``roughness_m_s2``, the total
        variation per time that the course does not need; and ``score_m``.

    Notes
    -----
    The score is the RMS of the position error, plus `ROUGHNESS` times the
    roughness, plus `COLLISION` for a robot that touches an obstacle.
    """
    rows = []
    for course in courses:
        run = drive(tracker, course, offsets, seed, disturbance)
        row = metrics.tracking(run, course.world)
        forgotten = min(STEADY, course.reference.duration / 2)
        steady = metrics.tracking(run, since=forgotten)
        row["transient_rms_m"] = metrics.tracking(run, until=forgotten)["position_rms_m"]
        row["steady_cross_rms_m"] = steady["cross_track_rms_m"]
        row["steady_along_rms_m"] = steady["along_track_rms_m"]
        row["steady_heading_rms_rad"] = steady["heading_rms_rad"]
        needless = np.maximum(row["wheel_variation_m_s"] - course.variation, 0)
        row["roughness_m_s2"] = needless / course.reference.duration
        row["score_m"] = row["position_rms_m"] + ROUGHNESS * row["roughness_m_s2"]
        row["score_m"] += COLLISION * (row["clearance_m"] < run.robot.radius)
        rows.append(row)
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}


def training_score(tracker):
    """Score (m) on the training courses; infinite where a solver gives up."""
    courses = random_courses(TRAINING["courses"], TRAINING["seed"])
    offsets = starts(TRAINING["robots"], TRAINING["seed"])
    try:
        return float(evaluate(tracker, courses, offsets, TRAINING["seed"])["score_m"].mean())
    except SolverFailed:
        return np.inf


def held_out(tracker, speed=SPEED):
    """Numbers on the courses that no search sees, see `evaluate`."""
    offsets = starts(HELD_OUT["robots"], HELD_OUT["seed"])
    return evaluate(tracker, held_out_courses(speed), offsets, HELD_OUT["seed"])


def tune(name, seed, budget=BUDGET):
    """Search the best gains of a tracker.

    Parameters
    ----------
    name : str
        One of `RANGES`.
    seed : int
        Of the search, not of what the robots meet.
    budget : int, optional
        Evaluations: a multiple of `POPULATION`.

    Returns
    -------
    gains : dict
        Name to value, of four digits.
    score : float
        Theirs (m).

    Raises
    ------
    InvalidParameter
        For a name that is not known, another budget, or no seed.

    Notes
    -----
    Differential evolution of the logarithms of the gains, from a Latin
    hypercube in which the defaults take the first place: R. Storn, K. Price,
    "Differential evolution", Journal of Global Optimization 11, 1997.
    """
    if name not in RANGES:
        raise InvalidParameter(f"tracker is {name!r}; choose one of {sorted(RANGES)}")
    as_seed(seed)
    if not isinstance(budget, int) or budget < POPULATION or budget % POPULATION:
        raise InvalidParameter(f"budget is {budget!r}; give a multiple of {POPULATION}")
    # Imported here: they take long, and only this function needs them.
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    kind, ranges = getattr(freeseg, name), RANGES[name]
    bounds = np.log10(list(ranges.values()))
    rng = np.random.default_rng(seed)
    low, high = bounds.T
    first = low + (high - low) * qmc.LatinHypercube(len(ranges), rng=rng).random(POPULATION)
    first[0] = np.log10([getattr(kind(), gain) for gain in ranges])

    def gains_of(logarithms):
        return {
            gain: float(f"{10**value:.4g}") for gain, value in zip(ranges, logarithms, strict=True)
        }

    found = differential_evolution(
        lambda logarithms: training_score(kind(**gains_of(logarithms))),
        bounds,
        init=first,
        maxiter=budget // POPULATION - 1,
        tol=0,
        polish=False,
        rng=rng,
    )
    return gains_of(found.x), float(found.fun)


def load_gains(file=DATA / "gains.csv"):
    """Tuned trackers of a file.

    Parameters
    ----------
    file : path-like, optional
        A row for every gain, see ``data/README.md``.

    Returns
    -------
    dict
        Name to list of Tuned, one for each seed.

    Raises
    ------
    InvalidWorld, InvalidParameter
        For a file that is broken, or gains that no tracker can have.
    """
    columns = {"tracker": str, "gain": str, "value": float, "budget": int, "seed": int}
    columns |= {"score": float, "held_out": float, "chosen": int}
    found = {}
    for row in read_csv(file, columns):
        if row["gain"] not in RANGES.get(row["tracker"], ()):
            raise InvalidParameter(
                f"{Path(file).name}, row {row['row']}: {row['tracker']} has no gain "
                f"{row['gain']} to tune; tune again"
            )
        seeds = found.setdefault(row["tracker"], {})
        gains, _ = seeds.setdefault(row["seed"], ({}, row))
        gains[row["gain"]] = row["value"]
    for name, seeds in found.items():
        for seed, (gains, _) in seeds.items():
            if missing := sorted(RANGES[name].keys() - gains):
                raise InvalidParameter(
                    f"{Path(file).name}: {name}, seed {seed} lacks {missing}; tune again"
                )
    return {
        name: [
            Tuned(
                getattr(freeseg, name)(**gains),
                seed,
                row["budget"],
                row["score"],
                row["held_out"],
                bool(row["chosen"]),
            )
            for seed, (gains, row) in seeds.items()
        ]
        for name, seeds in found.items()
    }


def interval(values, seed=0):
    """Bootstrap interval of a mean over courses and robots.

    Parameters
    ----------
    values : array_like, shape (courses, robots)
        One number a run.
    seed : int, optional
        Of the resampling.

    Returns
    -------
    low, high : float
        Percentile interval at 95 %.

    Raises
    ------
    InvalidParameter
        For values of another shape, or that are no numbers.

    Notes
    -----
    The same robots drive on every course, so that neither the runs of a
    course nor those of a robot are independent: courses and robots are
    resampled apart, and crossed. A. Owen, "The pigeonhole bootstrap", Annals
    of Applied Statistics 1, 2007: it rather overestimates the variance.
    """
    from scipy.stats import bootstrap

    values = np.asarray(values, float)
    if values.ndim != 2 or min(values.shape) < 2 or np.isnan(values).any():
        raise InvalidParameter(
            f"values has shape {values.shape}; give numbers of two courses and two robots or more"
        )

    def mean(course, robot, axis):
        course, robot = course.astype(int), robot.astype(int)
        return values[course[..., :, None], robot[..., None, :]].mean((-1, -2))

    numbers = [np.arange(length) for length in values.shape]
    found = bootstrap(numbers, mean, n_resamples=2000, method="percentile", rng=seed)
    return tuple(map(float, found.confidence_interval))


def separated(intervals):
    """Which of some intervals lie apart.

    Parameters
    ----------
    intervals : dict
        Name to (low, high).

    Returns
    -------
    list of (str, str)
        Pairs of names, the lower interval first; where two overlap, nothing
        is said of their order.
    """
    return [
        (lower, upper)
        for lower, (_, high) in intervals.items()
        for upper, (low, _) in intervals.items()
        if high < low
    ]
