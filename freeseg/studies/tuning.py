"""Search of gains: the same method and budget for every tracker, and what it found."""

from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, trackers
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidData, InvalidParameter, SolverFailed
from freeseg.studies.courses import TRAINING, random_courses, spread_offsets
from freeseg.studies.tracking import evaluate

#: Evaluations of a search, and of these how many a generation has.
BUDGET, POPULATION = 160, 16

#: A search with more evaluations would not end.
MOST_EVALUATIONS = 1_000_000

#: Where gains are searched for, on a logarithmic scale: ten times the default up and down, and
#: a hundred times for weights of squares; further down for two gains of `SuperTwisting`, where a
#: first search ended.
RANGES: dict[str, dict[str, tuple[float, float]]] = {
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


class Tuned(NamedTuple):
    """A tracker with the gains that a search found.

    ``score`` is theirs on the training courses, ``held_out`` that on courses
    the search never saw (m); ``chosen`` marks the seed with the best score.
    """

    tracker: Any
    seed: int
    budget: int
    score: float
    held_out: float
    chosen: bool


def training_score(tracker: Any) -> float:
    """Score (m) on the training courses; infinite where a solver gives up."""
    courses = random_courses(TRAINING["courses"], TRAINING["seed"])
    offsets = spread_offsets(TRAINING["robots"], TRAINING["seed"])
    try:
        return float(evaluate(tracker, courses, offsets, TRAINING["seed"])["score_m"].mean())
    except SolverFailed:
        return np.inf


def tune(name: str, seed: int, budget: int = BUDGET) -> tuple[dict[str, float], float]:
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
    checks.choice("tracker", name, RANGES)
    seed, budget = checks.whole("seed", seed), checks.whole("budget", budget)
    if not POPULATION <= budget <= MOST_EVALUATIONS or budget % POPULATION:
        raise InvalidParameter(
            f"budget is {checks.shown(budget)}; give a multiple of {POPULATION} up to "
            f"{MOST_EVALUATIONS}"
        )
    # Imported here: they take long, and only this function needs them.
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    kind, ranges = getattr(trackers, name), RANGES[name]
    bounds = np.log10(list(ranges.values()))
    rng = np.random.default_rng(seed)
    low, high = bounds.T
    first = low + (high - low) * qmc.LatinHypercube(len(ranges), rng=rng).random(POPULATION)
    first[0] = np.log10([getattr(kind(), gain) for gain in ranges])

    def gains_of(logarithms: np.ndarray) -> dict[str, float]:
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


def load_gains(file: str | PathLike[str] = DATA / "gains.csv") -> dict[str, list[Tuned]]:
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
    InvalidData
        For a file that is broken, or names gains that no tracker has.
    InvalidParameter
        For a gain that is out of its range.
    """
    columns: dict[str, type] = {
        "tracker": str,
        "gain": str,
        "value": float,
        "budget": int,
        "seed": int,
    }
    columns |= {"score": float, "held_out": float, "chosen": int}
    searches: dict[tuple[str, int], tuple[dict[str, float], dict[str, Any]]] = {}
    for row in read_csv(file, columns):
        if row["gain"] not in RANGES.get(row["tracker"], ()):
            raise InvalidData(
                f"{Path(file).name}, row {row['row']}: {row['tracker']} has no gain "
                f"{row['gain']} to tune; tune again"
            )
        gains, _ = searches.setdefault((row["tracker"], row["seed"]), ({}, row))
        gains[row["gain"]] = row["value"]
    found: dict[str, list[Tuned]] = {}
    for (name, seed), (gains, row) in searches.items():
        if missing := sorted(RANGES[name].keys() - gains):
            raise InvalidData(f"{Path(file).name}: {name}, seed {seed} lacks {missing}; tune again")
        tracker = getattr(trackers, name)(**gains)
        numbers = row["budget"], row["score"], row["held_out"], bool(row["chosen"])
        found.setdefault(name, []).append(Tuned(tracker, seed, *numbers))
    return found
