"""Search of gains: the same method and budget for every law, and what it found.

All of the protocol is an assumption, for the paper compares no trackers.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, trackers
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidData, InvalidParameter, SolverFailed
from freeseg.studies.courses import random_courses, spread_offsets
from freeseg.studies.searching import evolve, four_digits
from freeseg.studies.tracking import (
    COLLISION,
    DISTURBANCE,
    REGIMES,
    ROUGHNESS,
    SINGLE,
    disturbed,
    evaluate,
)
from freeseg.trackers.predictor import Predicting

#: Candidates of a generation, generations of a search, and of one for a further price.
POPULATION, GENERATIONS, FURTHER = 16, 8, 3

#: Prices of roughness (s^2) that gains are searched for, in this order: each search begins with
#: the last candidates of that for the next price nearer to the first.
PRICES = (ROUGHNESS, 0.05, 0.2, 0.01, 0.005, 0.002)

#: What a replicate of tuning sees: its own courses, robots and noise.
TRAINING = {"courses": 4, "robots": 3}

#: How many replicates there are, and by what their first worlds are apart.
REPLICATES, FIRST_SEED, SEEDS_APART = 5, 10_000, 1000

#: What a law is told of: nothing; delay and lag, and what comes next, where it has a use for
#: it; and, in addition, what an observer says of the pose and of slip.
FORMS = ("plain", "told", "observed")

#: Where gains are searched for, on a logarithmic scale.
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "SlidingMode": {
        "k1": (0.004, 40),
        "k2": (0.02, 200),
        "phi1": (0.001, 10),
        "phi2": (0.005, 50),
        "length_scale": (0.00045, 4.5),
    },
    "SuperTwisting": {
        "lambda1": (0.003, 30),
        "lambda2": (0.002, 200),
        "w1": (0.0001, 1),
        "w2": (0.0001, 10),
        "length_scale": (0.0008, 8),
    },
    "Kanayama": {"k_x": (0.02, 200), "k_y": (1, 1e4), "k_alpha": (0.2, 2000)},
    "Lqr": {"q_x": (4e-4, 4e4), "q_y": (0.01, 1e6), "q_alpha": (2e-4, 2e4)},
    "FeedbackLinearisation": {"k1": (0.02, 200), "k2": (0.02, 200), "ahead": (6e-4, 6)},
    "PurePursuit": {"lookahead": (6e-4, 6), "k_x": (0.02, 200)},
    "Stanley": {
        "k": (0.02, 200),
        "k_x": (0.02, 200),
        "softening": (2e-4, 2),
        "ahead": (6e-4, 6),
    },
    "Fuzzy": {
        "x_range": (0.001, 10),
        "y_range": (0.002, 20),
        "alpha_range": (0.01, 100),
        "v_range": (0.002, 20),
        "omega_range": (0.02, 200),
    },
    "Pid": {
        "kp_x": (0.03, 300),
        "ki_x": (0.009, 90),
        "kp_y": (3.4, 34000),
        "ki_y": (7.6, 76000),
        "kd_y": (0.29, 2900),
    },
    "Mpc": {"heading": (3e-8, 3), "acceleration": (1e-8, 1), "terminal": (0.001, 1e5)},
}

#: Those of what comes with being told: over which time a law averages its feedforward (s), and
#: up to which error a PID integrates (m); and with an observer, its rate (1/s).
PREVIEW, GATE, OBSERVER = (0.01, 1.0), (0.0005, 0.5), (0.1, 20.0)


#: A gain within this factor of an end of its range is at that end.
NEAR = 1.2


class Tuned(NamedTuple):
    """A law with the gains that a search found.

    Attributes
    ----------
    tracker : Tracker
    replicate : int
        Which of the searches.
    score : float
        RMS position error plus price times roughness on the training courses (m).
    """

    tracker: Any
    replicate: int
    score: float


def ranges(name: str, form: str) -> dict[str, tuple[float, float]]:
    """Where the gains of a law are searched for.

    Parameters
    ----------
    name : str
        One of `RANGES`.
    form : str
        One of `FORMS`.

    Returns
    -------
    dict
        Name of gain to its least and its largest value.

    Raises
    ------
    InvalidParameter
        For another name or form.
    """
    found = dict(RANGES[checks.choice("tracker", name, RANGES)])
    if checks.choice("form", form, FORMS) != "plain":
        # An MPC knows what comes next, and integrates nothing.
        found |= {} if name == "Mpc" else {"preview": PREVIEW}
        found |= {"gate": GATE} if name == "Pid" else {}
    return found | ({"observer": OBSERVER} if form == "observed" else {})


def make_tracker(name: str, form: str, gains: Mapping[str, float], times: float = 1.0) -> Any:
    """A law with gains, told what its form says.

    Parameters
    ----------
    name, form : str
        As for `ranges`.
    gains : dict
        Name of gain to value.
    times : float, optional
        Told of so many times the delay and the lag of `DISTURBANCE`.

    Returns
    -------
    Tracker

    Raises
    ------
    InvalidParameter
        For an unknown name or form, and gains that the law does not take.
    """
    checks.instance("gains", gains, Mapping, "a dict of name to value")  # type: ignore[type-abstract]
    times = checks.not_negative("times", times)
    if set(gains) != set(ranges(name, form)):
        raise InvalidParameter(
            f"gains is {checks.shown(gains)}; give {', '.join(ranges(name, form))}"
        )
    told = {"delay": times * DISTURBANCE.delay, "lag": times * DISTURBANCE.lag}
    kind = getattr(trackers, name)
    if name == "Mpc":
        return kind(**gains, **(told if form != "plain" else {}))
    own = {gain: value for gain, value in gains.items() if gain != "observer"}
    if form == "plain":
        return kind(**own)
    return Predicting(kind(**own), **told, observer=gains.get("observer", 0.0))


def training_numbers(
    name: str, form: str, gains: Mapping[str, np.ndarray], regime: str, replicate: int
) -> dict[str, np.ndarray]:
    """How candidates do on the courses of a replicate.

    Parameters
    ----------
    name, form : str
        As for `ranges`.
    gains : dict
        Name of gain to its value for each candidate, shape (m,).
    regime : str
        One of `tracking.REGIMES`.
    replicate : int
        Which courses, robots and noise.

    Returns
    -------
    dict
        Means over all runs, shape (m,): ``position_rms_m``, ``roughness_m_s2``
        and ``hit``, the share that touches an obstacle; infinite where a
        solver gives up.
    """
    under = REGIMES[checks.choice("regime", regime, REGIMES)]
    checks.instance("gains", gains, Mapping, "a dict of name to values")  # type: ignore[type-abstract]
    if set(gains) != set(ranges(name, form)):
        raise InvalidParameter(
            f"gains is {checks.shown(gains)}; give values for {', '.join(ranges(name, form))}"
        )
    gains = {gain: checks.array("gains", gains[gain], (None,)) for gain in ranges(name, form)}
    seed = FIRST_SEED + SEEDS_APART * checks.whole("replicate", replicate)
    courses = random_courses(TRAINING["courses"], seed, under.speed, under.room)
    offsets = spread_offsets(TRAINING["robots"], seed, under.offset)
    candidates = len(next(iter(gains.values())))
    if name in SINGLE:
        parts = [[index] for index in range(candidates)]
    else:
        parts = [list(range(candidates))]
    found = []
    for part in parts:
        chosen = {gain: values[part] for gain, values in gains.items()}
        found.append(_numbers(name, form, chosen, courses, offsets, seed, under.times))
    return {one: np.concatenate([row[one] for row in found]) for one in found[0]}


def _numbers(name, form, gains, courses, offsets, seed, times):
    """`training_numbers` of candidates that drive in one batch."""
    robots, candidates = offsets.shape[1], len(next(iter(gains.values())))
    tracker = make_tracker(name, form, {gain: float(values[0]) for gain, values in gains.items()})
    if candidates > 1:
        tracker = _one_each(
            tracker, {gain: np.repeat(values, robots) for gain, values in gains.items()}
        )
    try:
        # All candidates meet the same noise.
        numbers = evaluate(
            tracker, courses, np.tile(offsets, candidates), (seed, 0, robots), disturbed(times)
        )
    except SolverFailed:
        return dict.fromkeys(("position_rms_m", "roughness_m_s2", "hit"), np.full(1, np.inf))

    def mean(values):
        return values.reshape(len(courses), candidates, robots).mean((0, 2))

    return {one: mean(numbers[one]) for one in ("position_rms_m", "roughness_m_s2", "hit")}


def _one_each(tracker, gains):
    """A tracker of which each robot of a batch has gains of its own, shape (n,).

    The laws are arithmetic and take arrays; the checks of gains, which are for people, are
    passed by.
    """
    made = copy(tracker)
    inner = {}
    for gain, values in gains.items():
        if hasattr(made, gain):
            object.__setattr__(made, gain, values)
        else:
            inner[gain] = values
    if inner:
        object.__setattr__(made, "tracker", _one_each(made.tracker, inner))
    return made


def tune(
    name: str, form: str, regime: str, replicate: int, prices: Sequence[float] = PRICES[:1]
) -> list[tuple[dict[str, float], float]]:
    """Search the best gains of a law, for one price of roughness after another.

    Parameters
    ----------
    name, form : str
        As for `ranges`.
    regime : str
        One of `tracking.REGIMES`.
    replicate : int
        Seed of the search, and of what it sees.
    prices : sequence of float, optional
        Of 1 m/s^2 of roughness (s^2); the first as a rule is `ROUGHNESS`.

    Returns
    -------
    list of (dict, float)
        For each price the gains, of four digits, and their score (m).

    Raises
    ------
    InvalidParameter
        For a name, a form or a regime that is not known, or no prices.

    Notes
    -----
    See `searching.evolve`. The first candidates are a Latin hypercube of the
    logarithms: one half all over the ranges, the other within half a decade
    about their middles, where the defaults are.
    """
    bounds = np.log10(list(ranges(name, form).values()))
    checks.choice("regime", regime, REGIMES)
    prices = [checks.positive("prices", one) for one in prices]
    rng = np.random.default_rng(checks.whole("replicate", replicate))
    seen: list[tuple[np.ndarray, ...]] = []

    def priced(price, logarithms):
        gains = _gains(name, form, logarithms)
        found = training_numbers(name, form, gains, regime, replicate)
        seen.append((logarithms, *found.values()))
        return _score(price, *found.values())

    tuned, population = {}, _first_population(name, form, rng)
    populations: dict[float, np.ndarray] = {}
    for price in prices:
        nearest = min(populations, key=lambda one: abs(np.log(one / price)), default=None)
        first = population if nearest is None else populations[nearest]
        generations = GENERATIONS if nearest is None else FURTHER
        score = partial(priced, price)
        populations[price] = evolve(score, bounds, first, generations, rng, True).population
    logarithms, rms, rough, hit = (np.concatenate(one, -1) for one in zip(*seen, strict=True))
    for price in prices:
        # What was seen for another price may be better for this one.
        scores = _score(price, rms, rough, hit)
        best = int(np.argmin(scores))
        gains = _gains(name, form, logarithms[:, best])
        tuned[price] = {one: float(value) for one, value in gains.items()}, float(scores[best])
    return [tuned[price] for price in prices]


def _score(price, rms, rough, hit):
    """What is to be small (m), from the numbers of `training_numbers`."""
    return rms + price * rough + COLLISION * hit


def _gains(name, form, logarithms):
    """Gains of four digits, from logarithms of shape (gains, ...)."""
    rounded = [np.vectorize(four_digits)(row) for row in logarithms]
    return dict(zip(ranges(name, form), rounded, strict=True))


def _first_population(name, form, rng):
    """Logarithms of the first candidates, shape (candidates, gains)."""
    # Imported here: it takes long, and only this function needs it.
    from scipy.stats import qmc

    low, high = np.log10(list(ranges(name, form).values())).T
    drawn = qmc.LatinHypercube(len(low), rng=rng).random(POPULATION)
    middle = (low + high) / 2
    near = np.maximum(middle - 0.5, low), np.minimum(middle + 0.5, high)
    half = POPULATION // 2
    wide, close = low + (high - low) * drawn[:half], near[0] + (near[1] - near[0]) * drawn[half:]
    first = np.concatenate([wide, close])
    first[-1] = middle
    return first


def load_gains(
    file: str | PathLike[str] = DATA / "gains.csv",
    form: str = "plain",
    regime: str = "nominal",
    price: float = ROUGHNESS,
) -> dict[str, list[Tuned]]:
    """Tuned laws of a file.

    Parameters
    ----------
    file : path-like, optional
        A row for every gain, see ``data/README.md``.
    form : str, optional
        One of `FORMS`.
    regime : str, optional
        One of `tracking.REGIMES`.
    price : float, optional
        One of `PRICES` (s^2).

    Returns
    -------
    dict
        Name to list of Tuned, one for each replicate.

    Raises
    ------
    InvalidData
        For a file that is broken, lacks what is asked for, or names gains that
        no law has.
    InvalidParameter
        For a gain that is out of its range, and an unknown form or regime.
    """
    checks.choice("form", form, FORMS), checks.choice("regime", regime, REGIMES)
    price = checks.not_negative("price", price)
    columns: dict[str, type] = dict.fromkeys(("tracker", "form", "regime"), str)
    columns |= {"price": float, "replicate": int, "gain": str, "value": float, "score": float}
    searches: dict[tuple[str, int], tuple[dict[str, float], float]] = {}
    for row in read_csv(file, columns):
        if row["gain"] not in ranges(row["tracker"], row["form"]):
            raise InvalidData(
                f"{Path(file).name}, row {row['row']}: {row['tracker']} has no gain "
                f"{row['gain']} to tune; tune again"
            )
        if (row["form"], row["regime"], row["price"]) == (form, regime, price):
            key = row["tracker"], row["replicate"]
            gains, _ = searches.setdefault(key, ({}, row["score"]))
            gains[row["gain"]] = row["value"]
    if not searches:
        raise InvalidData(
            f"price is {price:g}, and {Path(file).name} has no gains of the form {form} for "
            f"{regime} at that price (s^2); tune for them"
        )
    found: dict[str, list[Tuned]] = {}
    for (name, replicate), (gains, score) in searches.items():
        if missing := sorted(ranges(name, form).keys() - gains):
            raise InvalidData(
                f"{Path(file).name}: {name}, replicate {replicate} lacks {missing}; tune again"
            )
        found.setdefault(name, []).append(Tuned(make_tracker(name, form, gains), replicate, score))
    return found


def at_ends(form: str, regime: str, file: str | PathLike[str] = DATA / "gains.csv") -> list[str]:
    """Gains that ended at an end of their range, where a wider one might serve better.

    Parameters
    ----------
    form, regime, file
        As for `load_gains`.

    Returns
    -------
    list of str
        Law, gain, and in how many of the replicates.

    Raises
    ------
    InvalidData, InvalidParameter
        As `load_gains`.
    """
    found = []
    for name, replicates in load_gains(file, form, regime).items():
        for gain, (low, high) in ranges(name, form).items():
            trackers = [
                one.tracker if hasattr(one.tracker, gain) else one.tracker.tracker
                for one in replicates
            ]
            values = np.array([getattr(tracker, gain) for tracker in trackers])
            count = int(((values < NEAR * low) | (values > high / NEAR)).sum())
            found += [f"{name}: {gain}, {count} of {len(values)}"] * bool(count)
    return found
