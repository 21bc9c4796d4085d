"""Intervals of what was measured over courses and robots."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter


def interval(values: ArrayLike, seed: int = 0) -> tuple[float, float]:
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

    values = checks.array("values", values, (None, None), unit="one a run")
    seed = checks.whole("seed", seed)
    if min(values.shape) < 2:
        raise InvalidParameter(
            f"values has shape {values.shape}; give numbers of two courses and two robots or more"
        )

    def mean(course: np.ndarray, robot: np.ndarray, axis: int) -> np.ndarray:
        course, robot = course.astype(int), robot.astype(int)
        return values[course[..., :, None], robot[..., None, :]].mean((-1, -2))

    indices = [np.arange(length) for length in values.shape]
    found = bootstrap(indices, mean, n_resamples=2000, method="percentile", rng=seed)
    low, high = found.confidence_interval
    return float(low), float(high)


def separated(intervals: Mapping[str, tuple[float, float]]) -> list[tuple[str, str]]:
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

    Raises
    ------
    InvalidParameter
        For what are no intervals.
    """
    checks.instance("intervals", intervals, Mapping, "a dict of name to (low, high)")  # type: ignore[type-abstract]
    for name, ends in intervals.items():
        low, high = checks.numbers(f"interval of {checks.shown(name)}", ends, 2)
        if low > high:
            what = f"interval of {checks.shown(name)}"
            raise InvalidParameter(f"{what} is {checks.shown(ends)}; give the lower end first")
    return [
        (lower, upper)
        for lower, (_, high) in intervals.items()
        for upper, (low, _) in intervals.items()
        if high < low
    ]
