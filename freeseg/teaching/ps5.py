"""Tests of problem set 5: how many runs it takes until one may say "better"."""

from itertools import combinations
from typing import Any

import numpy as np
from scipy import stats

from freeseg.teaching.answered import numbers
from freeseg.teaching.check import Ask

__all__ = ["compare", "many", "needed", "stop"]

#: Intervals cover so often, and verdicts are wrong so rarely.
LEVEL = 0.95
#: Studies of a test, the share of them that may be wrong (by chance, one right answer in ten
#: thousand is beyond it), and how wide intervals are at least, relative to Student's.
STUDIES, WRONG, NARROWEST = 300, 0.1, 0.9
#: The same of studies with many comparisons, which say little each.
MANY_STUDIES, WRONG_OF_MANY = 1000, 0.08
#: Six trackers are equal within groups of these sizes.
GROUPS = ((4, 2), (4, 2), (4, 2), (6,))
#: Comparisons run by run: how many, how many may be wrong, chance included, and after how many
#: runs a verdict is asked for: a verdict that is wrong by then is wrong if asked for more often.
SERIES, WRONG_SERIES = 60, 8
LOOKED_AT = np.unique([*range(2, 21), *np.geomspace(20, 5000, 20).astype(int)])
#: Means that have to be found, and within how many runs.
FOUND_WITHIN = {0.8: 40, 0.4: 100, 0.1: 5000}


def _costs(rng: np.random.Generator, runs: int, difference: float) -> tuple[np.ndarray, np.ndarray]:
    """Costs (mm) of two trackers in the same runs, which differ far more than the trackers do."""
    course = rng.gamma(4, 1, runs)
    first = course + difference + rng.normal(0, 0.2, runs)
    return first, course + rng.normal(0, 0.2, runs)


def compare(ask: Ask, rng: np.random.Generator) -> None:
    """An interval of the difference, from runs that share their courses."""
    covered, widths, least = 0, [], []
    for _ in range(STUDIES):
        true, runs = rng.uniform(-0.3, 0.3), int(rng.integers(6, 13))
        first, second = _costs(rng, runs, true)
        low, high = numbers(
            ask("interval_of", first, second), (2,), "give back low and high of first minus second"
        )
        assert low < high, f"low is {low:.3f} and high is {high:.3f}: give the lower end first"
        covered += low <= true <= high
        widths.append(high - low)
        error = stats.sem(first - second) * stats.t.ppf((1 + LEVEL) / 2, runs - 1)
        least.append(2 * error)
    share, wide = covered / STUDIES, np.mean(widths) / np.mean(least)
    assert wide < 2, (
        f"your intervals are {wide:.1f} times as wide as they need be: both trackers drove the "
        "same courses, so what is common to a pair tells nothing of their difference"
    )
    honest = share > 1 - WRONG and wide > NARROWEST
    assert honest, (
        f"your intervals of {100 * LEVEL:.0f} % cover the difference in {100 * share:.0f} % of "
        f"{STUDIES} studies of 6 to 12 runs; is the spread that of n - 1, and the factor that of "
        "so few runs?"
    )
    assert wide < 1.3, (
        f"your intervals are {wide:.2f} times as wide as they need be, and cover "
        f"{100 * share:.0f} %: at {100 * LEVEL:.0f} %, they may miss in one study of twenty"
    )


def _power(runs: int, spread: float, difference: float) -> float:
    """How often a paired t-interval finds a difference with its sign."""
    edge = stats.t.ppf((1 + LEVEL) / 2, runs - 1)
    return float(stats.nct.sf(edge, runs - 1, difference / spread * np.sqrt(runs)))


def needed(ask: Ask, rng: np.random.Generator) -> None:
    """How many runs it takes to find a difference."""
    for number in range(18):
        spread, power = rng.uniform(0.5, 2), rng.choice([0.5, 0.8, 0.9])
        # Every third study needs so few runs that no correction of a normal is enough.
        few = rng.choice([2.0, 3.0]) * rng.uniform(1, 1.03)
        difference = spread * (rng.uniform(0.25, 0.9) if number % 3 else few)
        enough = next(n for n in range(2, 10**4) if _power(n, spread, difference) >= power)
        mine = float(
            numbers(
                ask("runs_needed", spread, difference, power), (), "give back one number of runs"
            )
        )
        assert mine == int(mine), f"you need {mine:g} runs: round up"
        assert mine >= 2, f"you need {mine:g} runs: of fewer than two, nobody knows the spread"
        finds = _power(int(mine), spread, difference)
        assert finds >= power - 0.025, (
            f"a difference of {difference:.2f} with a spread of {spread:.2f}: with your "
            f"{mine:.0f} runs it is found in {100 * finds:.0f} % of all studies, not in "
            f"{100 * power:.0f} %. Does your number know the power, and that few runs need a "
            "larger factor?"
        )
        assert mine <= 1.1 * enough + 1, (
            f"a difference of {difference:.2f} with a spread of {spread:.2f}: you need "
            f"{mine:.0f} runs, and fewer find it in {100 * power:.0f} % of all studies"
        )


def _series(rng: np.random.Generator, mean: float, runs: int) -> np.ndarray:
    """Differences of one run after the other, between -1 and 1."""
    return np.clip(mean + rng.normal(0, 0.3, runs), -1, 1)


def _equal(rng: np.random.Generator, number: int) -> np.ndarray:
    """Differences of trackers that are equally good, for as long as anybody looks.

    Every other series has rare large losses of one tracker, which make up for many small gains:
    what trusts in a normal distribution, at any level, is sure of the gains too early.
    """
    if number % 2:
        return _series(rng, 0.0, LOOKED_AT[-1])
    loses = rng.random(LOOKED_AT[-1]) < 0.05
    differences = np.where(loses, -0.95, 0.05) + rng.normal(0, 0.005, LOOKED_AT[-1])
    return rng.choice([-1, 1]) * differences


def _verdict(ask: Ask, differences: np.ndarray, looks: Any) -> str:
    """What is said first of a series, after some numbers of runs."""
    for runs in looks:
        said: Any = ask("verdict_so_far", differences[:runs])
        assert said in ("smaller", "larger", "go on"), (
            f'give "smaller", "larger" or "go on"; yours is {said!r:.60}'
        )
        if said != "go on":
            return said
    return "go on"


def stop(ask: Ask, rng: np.random.Generator) -> None:
    """A verdict that may be looked for after every run."""
    for mean, within in FOUND_WITHIN.items():
        looks = LOOKED_AT if within > LOOKED_AT[-2] else range(2, within + 1)
        found = [_verdict(ask, _series(rng, sign * mean, within), looks) for sign in (1, -1) * 4]
        wanted = ("larger", "smaller") * 4
        right = sum(said == name for said, name in zip(found, wanted, strict=True))
        assert right or set(found) == {"go on"}, (
            "you call the smaller one larger: the differences are first minus second"
        )
        assert right >= 7, (
            f"of {len(found)} series with a mean of {mean} and bounds of -1 and 1, you decided "
            f"{right} within {within} runs: you may be more daring, and have to go on looking"
        )
    wrong = sum(_verdict(ask, _equal(rng, k), LOOKED_AT) != "go on" for k in range(SERIES))
    assert wrong <= WRONG_SERIES, (
        f"of {SERIES} series of {LOOKED_AT[-1]} runs without any difference, you called {wrong} "
        "one; "
        "5 % are allowed. An interval that is right after a number of runs that was set before is "
        "wrong sooner or later if you look after every run; and all that is known of a difference "
        "are its bounds"
    )


def _holm(values: np.ndarray) -> np.ndarray:
    """Which comparisons hold: S. Holm, Scandinavian Journal of Statistics 6, 1979."""
    order = np.argsort(values)
    holds = values[order] <= (1 - LEVEL) / np.arange(len(values), 0, -1)
    found = np.zeros(len(values), bool)
    found[order] = np.logical_and.accumulate(holds)
    return found


def many(ask: Ask, rng: np.random.Generator) -> None:
    """Many comparisons at once."""
    wrong = missed = 0
    for _ in range(MANY_STUDIES):
        sizes = GROUPS[rng.integers(len(GROUPS))]
        group = rng.permutation(np.repeat(range(len(sizes)), sizes))
        real = np.not_equal(*group[np.array(list(combinations(range(6), 2))).T])
        values = np.where(real, rng.uniform(0, 0.006, len(real)), rng.uniform(0, 1, len(real)))
        mine = numbers(
            ask("which_hold", values), real.shape, "give True or False for every p-value, in order"
        )
        wrong += bool((mine.astype(bool) & ~real).any())
        missed += int((_holm(values) & ~mine.astype(bool)).sum())
    assert wrong / MANY_STUDIES <= WRONG_OF_MANY, (
        f"in {100 * wrong / MANY_STUDIES:.0f} % of {MANY_STUDIES} studies you call at "
        "least one difference real that is none; 5 % are allowed, of all comparisons of a study "
        "together"
    )
    assert missed == 0, (
        f"you miss {missed} differences that may be called real at no higher risk: when the "
        "smallest p-value holds, one comparison fewer is left"
    )
