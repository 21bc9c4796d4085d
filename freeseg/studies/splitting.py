"""Probabilities of rare events, by adaptive multilevel splitting."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter

#: Runs of a population, how many of them are replaced in a round, moves that each of these makes,
#: and how many populations there are, each an experiment of its own.
PARTICLES, KILLED, MOVES, POPULATIONS = 260, 52, 3, 10

#: Share of new random numbers in a proposal: first, least and largest. It grows where more
#: than `ACCEPTED` of the proposals are accepted, and shrinks where fewer are.
BLEND, LEAST_BLEND, MOST_BLEND, ACCEPTED = 0.4, 0.03, 0.9, 0.3

#: Larger sizes would not fit into memory, all together and each.
MOST_NUMBERS_HELD, MOST_OF_A_KIND = 500_000_000, 1_000_000

#: More rounds would take for ever: the level rises too slowly.
MOST_ROUNDS = 1000


class Tail(NamedTuple):
    """How probable it is that a run gets above each of some levels.

    Attributes
    ----------
    levels : ndarray, shape (k,)
    share : ndarray, shape (k,)
        Estimated probabilities; NaN where splitting ended before.
    low, high : ndarray, shape (k,)
        Their intervals, each for itself.
    error : ndarray, shape (k,)
        Relative standard errors; infinite where no run got there.
    runs : int
        Runs that were simulated, of all populations.
    """

    levels: np.ndarray
    share: np.ndarray
    low: np.ndarray
    high: np.ndarray
    error: np.ndarray
    runs: int


def split(
    level: Callable[[np.ndarray], np.ndarray],
    dimensions: int,
    levels: ArrayLike,
    seed: int = 0,
    populations: int = POPULATIONS,
    particles: int = PARTICLES,
    killed: int = KILLED,
    moves: int = MOVES,
    least: float = 0.0,
) -> Tail:
    """Probabilities that a random run gets above levels, down to very rare ones.

    Parameters
    ----------
    level : callable
        ``level(numbers)`` gives how high each of m runs gets, shape (m,). It is a
        function of nothing but standard normal numbers, shape (dimensions, m): all
        that is random in a run, its noise at every time and what it has from its
        beginning.
    dimensions : int
        How many numbers a run has.
    levels : array_like, shape (k,)
        Increasing; the last one is where splitting ends.
    seed : int, optional
        Of all random numbers.
    populations : int, optional
        Experiments, two or more: their spread makes the intervals.
    particles, killed : int, optional
        Runs of a population, and how many are replaced in a round at least.
    moves : int, optional
        Of each run that is replaced, one or more.
    least : float, optional
        Splitting ends at the last level, or where a population has come to a
        probability below this one.

    Returns
    -------
    Tail

    Raises
    ------
    InvalidParameter
        For what is no function, or returns no such heights; levels that do not
        increase, or are not passed in `MOST_ROUNDS` rounds; and numbers that make no
        sense.

    Notes
    -----
    F. Cérou and A. Guyader, "Adaptive multilevel splitting for rare event
    analysis", Stochastic Analysis and Applications 25, 2007; ties are treated as by
    C.-E. Bréhier, M. Gazeau, L. Goudenège, T. Lelièvre and M. Rousset, "Unbiasedness
    of some generalized adaptive multilevel splitting algorithms", Annals of Applied
    Probability 26, 2016: all runs at or below the level go.

    In every round the lowest runs of each population are replaced by copies of
    others, which then move without falling back to the level. They move in all of
    their numbers at once: these are blended with new ones, and the blend is taken
    where it is above the level, too. That is the subset simulation of S.-K. Au and
    J. Beck, Probabilistic Engineering Mechanics 16, 2001, with the walk of S.
    Cotter, G. Roberts, A. Stuart and D. White, Statistical Science 28, 2013, which
    does not mind how many numbers there are.

    Splitting a run in time instead, with all noise drawn anew from the moment on
    at which it first passed the level, and blending only by turns with that, was
    tried: on the closed form of ``tests/benchmarks/stress.py`` its standard error
    was some 30 % larger for the same number of runs.

    The interval is Student's, of the populations' estimates. Where runs get high in more than
    one way, copies move slowly from one to the other, and it is too narrow: notebook 15 shows
    such a case.
    """
    dimensions = checks.whole("dimensions", dimensions, 1, most=MOST_OF_A_KIND)
    populations = checks.whole("populations", populations, 2, most=MOST_OF_A_KIND)
    particles = checks.whole("particles", particles, 2, most=MOST_OF_A_KIND)
    if dimensions * populations * particles > MOST_NUMBERS_HELD:
        raise InvalidParameter(
            f"dimensions is {dimensions}, for {populations} populations of {particles}; give less"
        )
    killed, at = checks.whole("killed", killed, 1), _check_levels(levels)
    moves, seed = checks.whole("moves", moves, 1, most=MOST_OF_A_KIND), checks.whole("seed", seed)
    least = checks.not_negative("least", least)
    if killed >= particles:
        raise InvalidParameter(f"killed is {killed}; give fewer than the {particles} particles")
    swarm = _Swarm(level, dimensions, populations, particles, seed)
    weight, climbing = np.ones(populations), np.ones(populations, bool)
    shares, floor = np.zeros((populations, len(at))), np.full(populations, -np.inf)
    for _ in range(MOST_ROUNDS):
        here = climbing[:, None] & (at >= floor[:, None])
        above = (swarm.height[..., None] > at).mean(1)
        shares = np.where(here, weight[:, None] * above, shares)
        lowest = np.partition(swarm.height, killed - 1)[:, killed - 1]
        floor = np.where(climbing, lowest, floor)
        dead = swarm.height <= floor[:, None]
        climbing &= (floor <= at[-1]) & ~dead.all(1)
        dead &= climbing[:, None]
        weight *= 1 - dead.mean(1)
        ended = climbing & (weight < least)
        shares[ended[:, None] & (at > floor[:, None])] = np.nan
        climbing, dead = climbing & ~ended, dead & ~ended[:, None]
        if not climbing.any():
            return _tail(at, shares, swarm.runs)
        swarm.replace(dead, floor, moves)
    raise InvalidParameter(
        f"level has not passed {at[-1]:g} in {MOST_ROUNDS} rounds; end at a lower one, or kill "
        "more at once"
    )


def _check_levels(levels):
    """Levels, shape (k,), that increase; or `InvalidParameter`."""
    found = checks.array("levels", levels, (None,))
    if not len(found) or (np.diff(found) <= 0).any():
        raise InvalidParameter(f"levels is {checks.shown(levels)}; give increasing ones")
    return found


class _Swarm:
    """The runs of all populations: numbers (dimensions, populations, particles), and heights."""

    def __init__(self, level, dimensions, populations, particles, seed):
        self.level, self.rng, self.runs = level, np.random.default_rng(seed), 0
        self.blend = np.full(populations, BLEND)
        self.numbers = self.rng.standard_normal((dimensions, populations, particles))
        flat = self.numbers.reshape(dimensions, -1)
        checks.function("level", level, "level(numbers) -> heights", flat[:, :1])
        self.height = self._heights(flat).reshape(populations, particles).copy()

    def _heights(self, numbers):
        """How high runs get, shape (m,)."""
        count = numbers.shape[1]
        self.runs += count
        return checks.array("level", self.level(numbers), (count,))

    def replace(self, dead, floor, moves):
        """Put moved copies of runs above the floor in the place of those at or below it."""
        home, place = np.nonzero(dead)
        parents = np.concatenate(
            [self.rng.choice(np.flatnonzero(~one), one.sum()) for one in dead if one.any()]
        )
        numbers, height = self.numbers[:, home, parents], self.height[home, parents]
        count = np.bincount(home, minlength=len(dead))
        for _ in range(moves):
            new = self.blend[home]
            fresh = self.rng.standard_normal(numbers.shape)
            tried = np.sqrt(1 - new * new) * numbers + new * fresh
            reached = self._heights(tried)
            taken = reached > floor[home]
            numbers, height = np.where(taken, tried, numbers), np.where(taken, reached, height)
            accepted = np.bincount(home, taken, len(dead)) / np.maximum(count, 1)
            grown = np.clip(self.blend * np.exp(accepted - ACCEPTED), LEAST_BLEND, MOST_BLEND)
            self.blend = np.where(count > 0, grown, self.blend)
        self.numbers[:, home, place], self.height[home, place] = numbers, height


def _tail(levels: np.ndarray, shares: np.ndarray, runs: int) -> Tail:
    """Mean and Student's interval of the populations' estimates, shape (populations, k)."""
    from scipy.stats import t

    mean = shares.mean(0)
    error = shares.std(0, ddof=1) / np.sqrt(len(shares))
    half = t.ppf(0.975, len(shares) - 1) * error
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = np.where(mean > 0, error / mean, np.inf)
    low, high = np.maximum(mean - half, 0), np.minimum(mean + half, 1)
    return Tail(levels, mean, low, high, relative, runs)


def lowest_level(tail: Tail, probability: float) -> float:
    """The level that a run gets above with a probability, between those of a tail.

    Parameters
    ----------
    tail : Tail
        As `split` returns it.
    probability : float
        Between 0 and 1.

    Returns
    -------
    float
        Interpolated in the logarithm of the probability; NaN where the tail does not
        reach it.

    Raises
    ------
    InvalidParameter
        For what is no tail or no probability.
    """
    checks.instance("tail", tail, Tail, "what split returns")
    wanted, seen = np.log(checks.probability("probability", probability)), tail.share > 0
    shares = np.log(tail.share[seen])[::-1]
    if not seen.any() or not shares[0] <= wanted <= shares[-1]:
        return float("nan")
    return float(np.interp(wanted, shares, tail.levels[seen][::-1]))
