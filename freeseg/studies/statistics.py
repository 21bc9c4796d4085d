"""What a study shows, and how sure it is: intervals, differences, orders, shares."""

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter

#: Of a bootstrap.
RESAMPLES = 2000

#: A resample may repeat one course only, and has then next to no spread. Without a least
#: standard error, as a part of that of the data, such resamples would decide the intervals of all.
LEAST_ERROR = 0.25

#: Numbers that the bootstrap of simultaneous intervals holds at a time.
HELD = 10_000_000

#: What is said of an interval of a difference.
SMALLER, LARGER, EQUIVALENT, UNDECIDED = "smaller", "larger", "equivalent", "undecided"

#: Names of intervals of a share, with SciPy's.
SHARES = {"wilson": "wilson", "clopper-pearson": "exact"}


class Difference(NamedTuple):
    """Mean of one law minus that of another, with its interval.

    Attributes
    ----------
    first, second : str
        Names of the two.
    mean : float
        Mean of the first minus mean of the second.
    low, high : float
        Interval of that difference, simultaneous with those of all other pairs.
    """

    first: str
    second: str
    mean: float
    low: float
    high: float


class Order(NamedTuple):
    """Partial order of some laws.

    Attributes
    ----------
    better : tuple of (str, str)
        Pairs, the better first: its mean is smaller by more than the margin.
    equivalent : tuple of (str, str)
        Pairs whose means differ by no more than the margin.
    undecided : tuple of (str, str)
        All other pairs: these runs do not tell.
    lines : tuple of (str, str)
        The pairs of `better` that the others do not imply: what a diagram draws.
    """

    better: tuple[tuple[str, str], ...]
    equivalent: tuple[tuple[str, str], ...]
    undecided: tuple[tuple[str, str], ...]
    lines: tuple[tuple[str, str], ...]


class Share(NamedTuple):
    """A share of all runs, with its interval.

    Attributes
    ----------
    share, low, high : float
    """

    share: float
    low: float
    high: float


class Sequential(NamedTuple):
    """What was known of a difference after each run.

    Attributes
    ----------
    low, high : ndarray, shape (runs,)
        Interval of the mean difference after each run.
    verdict : str
        As of `verdict`, the first that was reached.
    runs : int or None
        Number of runs at which it was reached; None while undecided.
    """

    low: np.ndarray
    high: np.ndarray
    verdict: str
    runs: int | None


def interval(
    values: ArrayLike, seed: int = 0, studentised: bool = False, level: float = 0.95
) -> tuple[float, float]:
    """Bootstrap interval of a mean over courses, robots and replicates.

    Parameters
    ----------
    values : array_like, shape (courses, robots) or (courses, robots, replicates)
        One number a run.
    seed : int, optional
        Of the resampling.
    studentised : bool, optional
        Whether the mean of each resample is measured in standard errors of
        that resample, which makes up for small numbers of courses.
    level : float, optional
        Between 0 and 1.

    Returns
    -------
    low, high : float
        Interval of percentiles; or, studentised, an interval round the mean.

    Raises
    ------
    InvalidParameter
        For values of another shape, or that are no numbers; for fewer than two
        of each axis, or four where studentised; and for a level that is none.

    Notes
    -----
    The same robots drive on every course, so that neither the runs of a
    course nor those of a robot are independent: courses, robots and replicates
    are resampled apart, and crossed. A. Owen, "The pigeonhole bootstrap",
    Annals of Applied Statistics 1, 2007.

    How often the interval covers hangs on the numbers and on what differs most.
    Of 500 synthetic studies of normal effects each (tests/benchmarks/interval_coverage.py),
    give or take 1 %, intervals at 95 % covered:

    ===========  ===========  ===========  ===========  ===========
    size         percentiles               studentised
    -----------  ------------------------  ------------------------
    effects of   all axes     last axis    all axes     last axis
    ===========  ===========  ===========  ===========  ===========
    4 x 4        87 %         90 %         97 %         95 %
    14 x 8       92 %         90 %         95 %         93 %
    30 x 30      92 %         92 %         93 %         94 %
    8 x 10 x 5   90 %         86 %         94 %         95 %
    8 x 40 x 5   87 %         85 %         93 %         97 %
    ===========  ===========  ===========  ===========  ===========

    Percentiles are too narrow for few courses or replicates. The studentised
    interval covered 93 to 98 % of the studies of every size and kind. Where neither
    courses nor robots matter, only chance, both are too wide: the one covered 98
    to 100 %, the other 98 %.
    """
    studentised = checks.flag("studentised", studentised)
    values = _table("values", values, 4 if studentised else 2)
    seed, level = checks.whole("seed", seed), checks.probability("level", level)
    if studentised:
        mean, half = _simultaneous(values[None], np.ones((1, 1)), seed, level)
        return float(mean[0] - half[0]), float(mean[0] + half[0])
    counts = _counts(values.shape, seed)
    axes = "crk"[: values.ndim]
    total = np.einsum(f"{axes},{'b,'.join(axes)}b->b", values, *counts, optimize=True)
    low, high = np.percentile(total / values.size, [50 - 50 * level, 50 + 50 * level])
    return float(low), float(high)


def differences(
    values: Mapping[str, ArrayLike], seed: int = 0, level: float = 0.95
) -> tuple[Difference, ...]:
    """Differences of all pairs of laws, with simultaneous intervals.

    Parameters
    ----------
    values : dict
        Name of each law to one number a run, shape (courses, robots) or
        (courses, robots, replicates): all laws with the same courses, robots
        and replicates, in the same order.
    seed : int, optional
        Of the resampling.
    level : float, optional
        How often *all* intervals of a study cover, between 0 and 1.

    Returns
    -------
    tuple of Difference
        Of each two laws, in the order in which `values` names them.

    Raises
    ------
    InvalidParameter
        For fewer than two laws; for values that are no numbers, of other
        shapes than one another, or of fewer than four courses, robots or
        replicates; and for a level that is none.

    Notes
    -----
    Laws are compared run by run, so that what a course or a start does to both
    cancels. Of every crossed resample (see `interval`) the mean difference of
    each pair is taken in standard errors of that resample, and the largest of
    all pairs kept ("max-T"); the quantile of these is the half-width of every
    interval, in standard errors of its own pair. P. Hall, "Theoretical
    comparison of bootstrap confidence intervals", Annals of Statistics 16,
    1988; J. Romano and M. Wolf, "Exact and approximate stepdown methods for
    multiple hypothesis testing", JASA 100, 2005.

    The square of a standard error is the sum over the axes of the variance of
    the axis' own means, divided by their number. That counts interactions more
    than once, and is never too small.

    In the same benchmark as for `interval`, all differences of four laws were
    covered together in 94 to 97 % of the studies, those of ten laws in 94 to
    100 %; with four courses and four robots, or where only chance matters, in
    98 to 100 %. With many laws and few courses the intervals are too wide rather
    than too narrow. Those of one pair are as `interval`'s, studentised.
    """
    checks.instance("values", values, Mapping, "a dict of name to numbers")  # type: ignore[type-abstract]
    seed, level = checks.whole("seed", seed), checks.probability("level", level)
    tables = {name: _table(f"values of {checks.shown(name)}", values[name], 4) for name in values}
    shapes = {table.shape for table in tables.values()}
    if len(tables) < 2 or len(shapes) > 1:
        raise InvalidParameter(
            f"values has {len(tables)} laws, of shapes {checks.shown(sorted(shapes))}; "
            "give two laws or more, with the same courses, robots and replicates"
        )
    pairs = list(combinations(range(len(tables)), 2))
    unit = np.eye(len(tables))
    contrasts = np.array([unit[first] - unit[second] for first, second in pairs])
    mean, half = _simultaneous(np.stack(list(tables.values())), contrasts, seed, level)
    return tuple(
        Difference(*names, float(centre), float(centre - width), float(centre + width))
        for names, centre, width in zip(combinations(tables, 2), mean, half, strict=True)
    )


def verdict(low: float, high: float, margin: float = 0) -> str:
    """What an interval of a difference says, given what is too little to count.

    Parameters
    ----------
    low, high : float
        Interval.
    margin : float, optional
        Largest difference that is called none, in the unit of the interval; to
        be stated before the runs are seen.

    Returns
    -------
    str
        "smaller" or "larger" where the whole interval is so by more than the
        margin, "equivalent" where it lies within the margin, else "undecided".

    Raises
    ------
    InvalidParameter
        For what is no interval, and for a negative margin.

    Notes
    -----
    That an interval has zero in it shows no equivalence: it may be wide. D.
    Schuirmann, "A comparison of the two one-sided tests procedure and the power
    approach", Journal of Pharmacokinetics and Biopharmaceutics 15, 1987. Two
    one-sided tests at 5 % need an interval at 90 % only; with the one at 95 %
    all verdicts on a study follow from the same intervals, and all of them hold
    whenever these cover.
    """
    low, high = checks.number("low", low), checks.number("high", high)
    if low > high:
        raise InvalidParameter(f"low is {low} and high is {high}; give the lower end first")
    margin = checks.not_negative("margin", margin)
    return str(_verdicts(np.array(low), np.array(high), margin))


def order(found: Sequence[Difference], margin: float = 0) -> Order:
    """Partial order of laws: who is better by more than a margin.

    Parameters
    ----------
    found : sequence of Difference
        As `differences` returns them, of what is the better the smaller it is;
        of what should be large, give `differences` the negative.
    margin : float, optional
        As for `verdict`.

    Returns
    -------
    Order

    Raises
    ------
    InvalidParameter
        For what are no differences, or contradict one another; and for a
        negative margin.

    Notes
    -----
    What is better than the better is better: where the intervals cover, this
    holds whatever the interval of that pair says alone. Equivalence is no such
    relation: of three laws, two may both be equivalent to the third only. The
    lines are the transitive reduction of A. Aho, M. Garey and J. Ullman, "The
    transitive reduction of a directed graph", SIAM Journal on Computing 1, 1972.
    """
    found = checks.instances("found", found, Difference, "what `differences` returns")
    said = {(one.first, one.second): verdict(one.low, one.high, margin) for one in found}
    names = list(dict.fromkeys(name for pair in said for name in pair))
    better = np.zeros((len(names), len(names)), dtype=bool)
    for (first, second), word in said.items():
        here = names.index(first), names.index(second)
        if word in (SMALLER, LARGER):
            better[here if word == SMALLER else here[::-1]] = True
    for through in range(len(names)):
        better |= better[:, [through]] & better[through]
    if better.diagonal().any():
        raise InvalidParameter(
            f"found is {checks.shown(found)}, by which one is better than itself; "
            "give what `differences` returns"
        )

    def pairs(which: np.ndarray) -> tuple[tuple[str, str], ...]:
        return tuple((names[first], names[second]) for first, second in np.argwhere(which))

    ranked = {*pairs(better), *pairs(better.T)}
    return Order(
        pairs(better),
        tuple(pair for pair, word in said.items() if word == EQUIVALENT),
        tuple(pair for pair, word in said.items() if word != EQUIVALENT and pair not in ranked),
        pairs(better & ~(better @ better)),
    )


def share(count: int, runs: int, method: str = "wilson", level: float = 0.95) -> Share:
    """A share of all runs, such as those that failed, with its interval.

    Parameters
    ----------
    count, runs : int
        How many failed, of how many.
    method : {"wilson", "clopper-pearson"}, optional
        Wilson's interval covers about as often as it says, for some true
        shares less often; Clopper's and Pearson's never does so less often, and
        is wider.
    level : float, optional
        Between 0 and 1.

    Returns
    -------
    Share

    Raises
    ------
    InvalidParameter
        For numbers that cannot be, an unknown method, and a level that is none.

    Notes
    -----
    E. Wilson, JASA 22, 1927; C. Clopper and E. Pearson, Biometrika 26, 1934;
    compared by L. Brown, T. Cai and A. DasGupta, "Interval estimation for a
    binomial proportion", Statistical Science 16, 2001.

    The runs must be independent. Those that share a course are not, and then
    both intervals are too narrow: where one of five runs fails, on some courses
    rather than on others (as the beta distribution with 1 and 4 has it), Wilson's
    interval of 30 courses with 20 robots each covers two times in three. Give
    `interval` zeros and ones instead.
    """
    from scipy.stats import binomtest

    runs = checks.whole("runs", runs, 1)
    if runs > checks.LARGEST:
        raise InvalidParameter(f"runs is {checks.shown(runs)}; give fewer")
    count = checks.whole("count", count)
    if count > runs:
        raise InvalidParameter(f"count is {checks.shown(count)}; give at most the {runs} runs")
    method = SHARES[checks.choice("method", method, SHARES)]
    low, high = binomtest(count, runs).proportion_ci(checks.probability("level", level), method)
    return Share(count / runs, float(low), float(high))


def sequential(
    values: ArrayLike, bounds: tuple[float, float], margin: float = 0, level: float = 0.95
) -> Sequential:
    """Compare two laws run by run, and stop as soon as it is decided.

    Parameters
    ----------
    values : array_like, shape (runs,)
        Difference of the two in each run, in the order of the runs. Each must
        be a fresh draw of all that is random: of runs that share a course, give
        the mean difference on that course.
    bounds : (float, float)
        What no difference can leave, known before the first run: -1 and 1 for
        failures; else clip what is measured, and compare what is clipped.
    margin : float, optional
        As for `verdict`.
    level : float, optional
        How often the intervals after *all* runs cover, between 0 and 1.

    Returns
    -------
    Sequential

    Raises
    ------
    InvalidParameter
        For values that are no numbers, or leave the bounds; for bounds, a margin
        or a level that make no sense.

    Notes
    -----
    One may look after every run, stop at will, and go on later: the intervals
    hold at all times together, whatever the distribution within the bounds; an
    ordinary interval at 95 %, looked at after every run, leaves the truth sooner
    or later. This is the predictable plug-in empirical Bernstein confidence
    sequence, theorem 2 of I. Waudby-Smith and A. Ramdas, "Estimating means of
    bounded random variables by betting", Journal of the Royal Statistical Society
    B 86, 2024, each interval intersected with those before it. The hedged capital
    of the same paper needs fewer runs, but for each interval a search over all
    means. For being valid at all times it is wide: it covers more often than it
    says.
    """
    low, high = checks.numbers("bounds", bounds, 2)
    if not -checks.LARGEST <= low < high <= checks.LARGEST:
        raise InvalidParameter(f"bounds is {checks.shown(bounds)}; give the lower one first")
    margin, level = checks.not_negative("margin", margin), checks.probability("level", level)
    values = checks.array("values", values, (None,), unit="one a run")
    if values.min() < low or values.max() > high:
        raise InvalidParameter(
            f"values has numbers from {values.min()} to {values.max()}, but bounds is "
            f"{(low, high)}; give bounds that hold, or clip what is measured"
        )
    centre, half = _bernstein((values - low) / (high - low), 1 - level)
    lows = low + (high - low) * np.maximum.accumulate(np.maximum(centre - half, 0))
    highs = low + (high - low) * np.minimum.accumulate(np.minimum(centre + half, 1))
    said = _verdicts(lows, highs, margin)
    first = int(np.argmax(said != UNDECIDED))
    decided = said[first] != UNDECIDED
    return Sequential(lows, highs, str(said[first]), first + 1 if decided else None)


def hypervolume(points: ArrayLike, worst: ArrayLike) -> float:
    """Area that a front leaves to the worst: the larger, the better the front.

    Parameters
    ----------
    points : array_like, shape (n, 2)
        What is to be small, such as error and roughness, of each point of the front.
    worst : array_like, shape (2,)
        Corner up to which the area is counted.

    Returns
    -------
    float
        Area of all that is no better than some point, and better than the worst.

    Raises
    ------
    InvalidParameter
        For what are no points.

    Notes
    -----
    E. Zitzler and L. Thiele, "Multiobjective evolutionary algorithms: a comparative
    case study and the strength Pareto approach", IEEE Transactions on
    Evolutionary Computation 3, 1999.
    """
    points = checks.array("points", points, (None, 2), unit="two numbers each")
    worst = checks.numbers("worst", worst, 2)
    x, y = np.minimum(points[np.argsort(points[:, 0])], worst).T
    return float(np.diff(x, append=worst[0]) @ (worst[1] - np.minimum.accumulate(y)))


def linearised(
    values: ArrayLike, statistic: Callable[[np.ndarray], float], step: float = 1e-6
) -> np.ndarray:
    """Numbers of runs whose mean is a function of means, to first order.

    Parameters
    ----------
    values : array_like, shape (quantities, courses, robots, replicates)
        Several numbers of each run.
    statistic : callable
        ``statistic(means)`` of the means of the quantities, shape (quantities,).
    step : float, optional
        Change of a mean, relative, by which the derivatives are found.

    Returns
    -------
    ndarray, shape (courses, robots, replicates)
        For `interval` and `differences`: the delta method.

    Raises
    ------
    InvalidParameter
        For values that are no numbers, of another shape, or of mean zero.

    Notes
    -----
    The mean of the numbers is the statistic of the means. Their spread is
    that of the statistic, so far as this is linear over the spread of the means.
    """
    values = checks.array("values", values, (None, None, None, None), unit="one a run")
    step, means = checks.positive("step", step), values.mean((1, 2, 3))
    checks.function("statistic", statistic, "a function of the means", means)
    if not means.all():
        raise InvalidParameter("values has a quantity of mean 0; leave it out, or give others")
    moves = np.diag(step * means)
    slopes = np.array(
        [(statistic(means + move) - statistic(means - move)) / (2 * move.sum()) for move in moves]
    )
    return statistic(means) + np.tensordot(slopes, values - means[:, None, None, None], 1)


def _table(name: str, values: ArrayLike, least: int) -> np.ndarray:
    """`values` as courses × robots (× replicates), at least so many of each."""
    found = checks.array(name, values, (None, None), (None, None, None), unit="one a run")
    if min(found.shape) < least or np.abs(found).max() > checks.LARGEST:
        raise InvalidParameter(
            f"{name} has shape {found.shape} and numbers up to {np.abs(found).max():g}; "
            f"give {least} courses, robots and replicates or more, and no number "
            f"beyond {checks.LARGEST:g}"
        )
    return found


def _counts(shape: tuple[int, ...], seed: int) -> list[np.ndarray]:
    """How often each resample takes each course, robot and replicate: (length, resamples)."""
    rng = np.random.default_rng(seed)
    counts = []
    for length in shape:
        # Indices, not multinomial counts, so that the draws are those of `scipy.stats.bootstrap`.
        drawn = rng.integers(0, length, (RESAMPLES, length))
        places = drawn * RESAMPLES + np.arange(RESAMPLES)[:, None]
        taken = np.bincount(places.ravel(), minlength=RESAMPLES * length)
        counts.append(taken.reshape(length, RESAMPLES).astype(float))
    return counts


def _mean_and_error(
    values: np.ndarray, contrasts: np.ndarray, weights: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Contrasts of weighted means of laws, and their standard errors.

    Parameters
    ----------
    values : ndarray, shape (laws, courses, robots[, replicates])
    contrasts : ndarray, shape (contrasts, laws)
    weights : list of ndarray, shape (length, resamples)
        Of each axis; each column sums to one.

    Returns
    -------
    mean, error : ndarray, shape (contrasts, resamples)
    """
    variance = 0.0
    axes = "crk"[: len(weights)]
    for axis, weight in zip(axes, weights, strict=True):
        rest = [(f"{one}b", w) for one, w in zip(axes, weights, strict=True) if one != axis]
        terms = ",".join([f"l{axes}", *(term for term, _ in rest)])
        means = np.einsum(f"{terms}->l{axis}b", values, *(w for _, w in rest), optimize=True)
        means = np.tensordot(contrasts, means, 1)
        mean = (means * weight).sum(1)
        spread = ((means - mean[:, None]) ** 2 * weight).sum(1)
        variance = variance + spread / (len(weight) - 1)
    return mean, np.sqrt(variance)


def _simultaneous(
    values: np.ndarray, contrasts: np.ndarray, seed: int, level: float
) -> tuple[np.ndarray, np.ndarray]:
    """Contrasts of means of laws, and the half-widths of their simultaneous intervals.

    Parameters
    ----------
    values : ndarray, shape (laws, courses, robots[, replicates])
    contrasts : ndarray, shape (contrasts, laws)
    seed : int
    level : float

    Returns
    -------
    mean, half : ndarray, shape (contrasts,)
    """
    even = [np.full((length, 1), 1 / length) for length in values.shape[1:]]
    mean, error = (found[:, 0] for found in _mean_and_error(values, contrasts, even))
    # What is equal in all runs is so but for rounding, in every resample.
    varies = error > 1e-12 * np.abs(values).max()
    if not varies.any():
        return mean, np.zeros_like(mean)
    contrasts, least = contrasts[varies], LEAST_ERROR * error[varies]
    weights = [count / len(count) for count in _counts(values.shape[1:], seed)]
    size = max(values.size, len(contrasts) * max(values.shape[1:]))
    largest = []
    for part in np.array_split(np.arange(RESAMPLES), min(RESAMPLES, 1 + RESAMPLES * size // HELD)):
        means, errors = _mean_and_error(values, contrasts, [w[:, part] for w in weights])
        off = np.abs(means - mean[varies, None]) / np.maximum(errors, least[:, None])
        largest.append(off.max(0))
    return mean, np.where(varies, error, 0) * np.quantile(np.concatenate(largest), level)


def _verdicts(low: np.ndarray, high: np.ndarray, margin: float) -> np.ndarray:
    """What `verdict` says of each of many intervals."""
    said = [high < -margin, low > margin, (-margin <= low) & (high <= margin)]
    return np.select(said, [SMALLER, LARGER, EQUIVALENT], UNDECIDED)


def _bernstein(shares: np.ndarray, alpha: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres and half-widths of a confidence sequence for a mean of numbers from 0 to 1."""
    count = np.arange(1, len(shares) + 1)
    mean = (0.5 + np.cumsum(shares)) / (count + 1)
    variance = (0.25 + np.cumsum((shares - mean) ** 2)) / (count + 1)
    # Each bet is made before its run: on what the runs before it showed.
    before, spread = np.append(0.5, mean[:-1]), np.append(0.25, variance[:-1])
    price = np.log(2 / alpha)
    bet = np.minimum(np.sqrt(2 * price / (spread * count * np.log1p(count))), 0.5)
    paid = (shares - before) ** 2 * (-np.log1p(-bet) - bet)
    staked = np.cumsum(bet)
    return np.cumsum(bet * shares) / staked, (price + np.cumsum(paid)) / staked
