"""What a test of a problem set asks of answers: their kind and shape, in words for a student."""

from typing import Any

import numpy as np


def numbers(value: Any, shape: tuple[int, ...], remedy: str) -> np.ndarray:
    """An answer as an array of finite numbers.

    Parameters
    ----------
    value : object
        What a student's function gave back: lists and arrays are the same.
    shape : tuple of int
        Its shape; () for one number.
    remedy : str
        What to give back instead.

    Raises
    ------
    AssertionError
        For anything else, with the remedy.
    """
    if value is None:
        raise AssertionError(f"your function gives back nothing: {remedy}")
    try:
        found = np.array(value, float)
    except (TypeError, ValueError):
        raise AssertionError(f"{remedy}; yours is {value!r:.100}") from None
    if found.shape != shape and found.size == 1 and shape == ():
        found = found.reshape(())
    assert found.shape == shape, f"{remedy}; yours has the shape {found.shape}, not {shape}"
    assert np.isfinite(found).all(), (
        f"{remedy}, all of them finite; yours has {found[~np.isfinite(found)][0]}"
    )
    return found
