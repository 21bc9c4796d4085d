"""The one search of gains: differential evolution of their logarithms."""

from collections.abc import Callable
from typing import Any

import numpy as np


def evolve(
    cost: Callable[[np.ndarray], Any],
    bounds: np.ndarray,
    first: np.ndarray,
    generations: int,
    rng: np.random.Generator,
    together: bool = False,
) -> Any:
    """What so many generations find, whether the last ones got better or not.

    Parameters
    ----------
    cost : callable
        ``cost(logarithms)``, which is to be small: of one candidate, shape (gains,), or of
        all together, shape (gains, candidates).
    bounds : ndarray, shape (gains, 2)
        Least and largest logarithms.
    first : ndarray, shape (candidates, gains)
        The first generation.
    generations : int
        How many there are, with the first.
    rng : Generator
        Makes candidates.
    together : bool, optional
        Whether the cost is asked once for a generation, and not for each candidate.

    Returns
    -------
    scipy.optimize.OptimizeResult
        With the best ``x``, its cost ``fun``, and the last ``population``.

    Notes
    -----
    R. Storn, K. Price, "Differential evolution", Journal of Global Optimization 11, 1997.
    """
    # Imported here: it takes long, and only this function needs it.
    from scipy.optimize import differential_evolution

    return differential_evolution(
        cost,
        bounds,
        init=first,
        maxiter=generations - 1,
        tol=0,
        polish=False,
        rng=rng,
        vectorized=together,
        updating="deferred" if together else "immediate",
    )


def four_digits(logarithm: float) -> float:
    """The gain of a decimal logarithm, to four digits, as it is stored."""
    return float(f"{10**logarithm:.4g}")
