"""Checks of what the package is given: each kind of value is checked here, and only here.

A check returns the value in the form that the package works with, or raises an
error that names the value and the remedy. NumPy's scalars are numbers; texts and
bools are not. Zero is a value, unless it makes no sense.
"""

import dataclasses
import inspect
import math
import operator
from collections.abc import Callable, Collection
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from freeseg.errors import FreesegError, InvalidData, InvalidParameter

Kind = TypeVar("Kind")

#: Longer values are cut in messages, so that the remedy is read.
LONGEST = 200

#: No signal of a robot is larger, and the product of larger ones would overflow.
LARGEST = 1e100

#: Texts, with those whose characters are whole numbers to Python.
TEXTS = (str, bytes, bytearray, memoryview)

#: What `float` would take for a number.
NO_NUMBERS = (*TEXTS, bool, np.bool_, complex, np.complexfloating)


def shown(value: object) -> str:
    """What a message shows of a value: its `repr`, or `str` if shorter, cut where that is long."""
    try:
        # Of dataclasses, `str` is `repr` unless they say themselves what is enough.
        text = str(value) if dataclasses.is_dataclass(value) else repr(value)
    except ValueError:
        # Python prints no whole number of more than some thousand digits.
        return f"<{type(value).__name__} too long to print>"
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def as_float(value: Any) -> float:
    """`value` as a float; NaN for what is not one real number."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    # `float` reads texts, takes bools for 0 and 1, and drops imaginary parts.
    if isinstance(value, NO_NUMBERS) or getattr(value, "ndim", 0) > 0:
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def number(
    name: str,
    value: object,
    valid: Callable[[float], bool] = lambda found: True,
    remedy: str = "a finite number",
    error: type[FreesegError] = InvalidParameter,
) -> float:
    """`value` as a float, or the error.

    Parameters
    ----------
    name : str
        What the value is, for the message.
    value : object
        What was given.
    valid : callable, optional
        Whether a finite float is one that makes sense.
    remedy : str, optional
        What to give instead.
    error : type, optional
        Error to raise.
    """
    found = as_float(value)
    if not (math.isfinite(found) and valid(found)):
        raise error(f"{name} is {shown(value)}; give {remedy}")
    return found


def positive(name: str, value: object, error: type[FreesegError] = InvalidParameter) -> float:
    """`value` as a float, or the error unless positive and finite."""
    return number(name, value, lambda found: found > 0, "a positive finite number", error)


def not_negative(name: str, value: object) -> float:
    """`value` as a float; `InvalidParameter` unless finite, and zero or more."""
    return number(name, value, lambda found: found >= 0, "a finite number, zero or more")


def numbers(
    name: str, values: Any, size: int, error: type[FreesegError] = InvalidParameter
) -> tuple[float, ...]:
    """`values` as a tuple of so many finite floats, or the error."""
    try:
        found = () if isinstance(values, TEXTS) else tuple(map(as_float, values))
    except TypeError:
        found = ()
    if len(found) != size or not all(map(math.isfinite, found)):
        raise error(f"{name} is {shown(values)}; give {size} finite numbers")
    return found


def pair(name: str, value: Any, valid: Callable[[float], bool], remedy: str) -> tuple[float, float]:
    """`value` as a pair of floats, for which one number may stand; or `InvalidParameter`.

    Parameters
    ----------
    name, value, valid, remedy
        As for `number`.
    """
    several = isinstance(value, tuple | list) or getattr(value, "ndim", 0) > 0
    first, second = map(as_float, value if several and len(value) == 2 else (value, value))
    if not all(math.isfinite(found) and valid(found) for found in (first, second)):
        raise InvalidParameter(f"{name} is {shown(value)}; give {remedy}")
    return first, second


def whole(
    name: str, value: Any, least: int = 0, remedy: str | None = None, most: float = math.inf
) -> int:
    """`value` as an int; `InvalidParameter` unless whole, and from `least` to `most`."""
    try:
        found = operator.index(value)
    except TypeError:
        found = least - 1
    if not least <= found <= most or isinstance(value, bool | np.bool_):
        upper = "on" if most == math.inf else f"to {most:g}"
        remedy = remedy or f"a whole number from {least} {upper}"
        raise InvalidParameter(f"{name} is {shown(value)}; give {remedy}")
    return found


def probability(name: str, value: Any) -> float:
    """`value` as a float; `InvalidParameter` unless between 0 and 1."""
    return number(
        name, value, lambda found: 0 < found < 1, "a number between 0 and 1, such as 0.95"
    )


def flag(name: str, value: object) -> bool:
    """`value` as a bool; `InvalidParameter` for what is none."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidParameter(f"{name} is {shown(value)}; give True or False")
    return bool(value)


def choice(name: str, value: object, choices: Collection[str]) -> str:
    """`value`; `InvalidParameter` unless it is one of some texts."""
    if not isinstance(value, str) or value not in choices:
        raise InvalidParameter(f"{name} is {shown(value)}; choose one of {sorted(choices)}")
    return value


def instance(
    name: str,
    value: object,
    kind: type[Kind],
    remedy: str,
    error: type[FreesegError] = InvalidParameter,
) -> Kind:
    """`value`, or the error for what is not of a type."""
    if not isinstance(value, kind):
        raise error(f"{name} is {shown(value)}; give {remedy}")
    return value


def sequence(
    name: str, values: Any, remedy: str, error: type[FreesegError] = InvalidParameter
) -> tuple[Any, ...]:
    """`values` as a tuple, or the error for what is no sequence, or a text."""
    try:
        if not isinstance(values, str | bytes):
            return tuple(values)
    except TypeError:
        pass
    raise error(f"{name} is {shown(values)}; give {remedy}")


def instances(name, values, kind, remedy, error=InvalidParameter):
    """`values` as a tuple, or the error for what is no sequence of a type."""
    found = sequence(name, values, remedy, error)
    if not all(isinstance(one, kind) for one in found):
        raise error(f"{name} is {shown(values)}; give {remedy}")
    return found


def real(name: str, values: object, remedy: str) -> np.ndarray:
    """`values` as an array of real numbers of any shape; `InvalidParameter` for anything else."""
    try:
        found = np.asarray(values)
    except ValueError:
        found = np.array(None)
    if found.dtype.kind not in "iuf" or np.isnan(found).any():
        raise InvalidParameter(f"{name} is {shown(values)}; give {remedy}")
    return found


def signal(name: str, values: object, remedy: str, rows: int | None = None) -> np.ndarray:
    """`values` as an array of finite numbers that come first component by component.

    Parameters
    ----------
    name, values, remedy
        As for `real`.
    rows : int, optional
        How many components; by default the array may have any shape.

    Raises
    ------
    InvalidParameter
        For anything else, and for numbers beyond `LARGEST`.
    """
    found = real(name, values, remedy)
    if not (np.abs(found) <= LARGEST).all() or (rows and found.shape[:1] != (rows,)):
        raise InvalidParameter(f"{name} is {shown(values)}; give {remedy}, finite")
    return found


def times(name: str, values: object) -> np.ndarray:
    """`values` as an array of finite times (s) from zero on; `InvalidParameter` otherwise."""
    remedy = "a time (s), zero or more"
    found = signal(name, values, remedy)
    if (found < 0).any():
        raise InvalidParameter(f"{name} is {shown(values)}; give {remedy}")
    return found


def together(**shapes: tuple[int, ...]) -> None:
    """Raise `InvalidParameter` unless arrays of these shapes broadcast."""
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        told = " and ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InvalidParameter(
            f"{told} do not belong together: these are the shapes that remain for the robots; "
            "give as many of each, or one"
        ) from None


def array(
    name: str,
    values: ArrayLike,
    *shapes: tuple[int | None, ...],
    error: type[FreesegError] = InvalidParameter,
    unit: str = "m",
) -> np.ndarray:
    """`values` as a finite, read-only array of floats, or the error.

    Parameters
    ----------
    name : str
        What the values are, for the message.
    values : array_like
        What was given; it is copied.
    *shapes : tuple of int or None
        Shapes that will do; None stands for any length from 1 on.
    error : type, optional
        Error to raise.
    unit : str, optional
        Unit of the numbers, for the message.

    Returns
    -------
    ndarray
    """
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "iufO":
            raise TypeError
        if given.dtype.kind == "O":
            # Such as fractions, whole numbers beyond 64 bits, and whatever else was mixed.
            given = np.reshape([as_float(entry) for entry in given.flat], given.shape)
            if np.isnan(given).any():
                raise TypeError
        found = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise error(f"{name} is {shown(values)}; give numbers ({unit})") from None
    if not found.size or not any(_has_shape(found, shape) for shape in shapes):
        wanted = " or ".join(
            " x ".join("n" if want is None else str(want) for want in shape) for shape in shapes
        )
        raise error(f"{name} has shape {found.shape}; expected {wanted} numbers ({unit})")
    if not np.isfinite(found).all():
        raise error(f"{name} is {shown(found.tolist())}; every number must be finite ({unit})")
    found.setflags(write=False)
    return found


def _has_shape(found: np.ndarray, shape: tuple[int | None, ...]) -> bool:
    return found.ndim == len(shape) and all(
        want in (None, have) for want, have in zip(shape, found.shape, strict=True)
    )


def seed(value: Any) -> tuple[int, ...]:
    """`value` as a seed and indices of robots; `InvalidParameter` for anything else.

    Parameters
    ----------
    value : int or tuple of int
        Seed; optionally the index of the first robot, which is 0 by default; and
        optionally the number of robots after which their numbers come again.

    Returns
    -------
    tuple of 2 or 3 int
    """
    pair = value if isinstance(value, tuple | list) else (value, 0)
    try:
        entropy, first, *again = (whole("seed", entry) for entry in pair)
        if len(again) > 1 or 0 in again:
            raise ValueError
    except (InvalidParameter, ValueError):
        raise InvalidParameter(
            f"seed is {shown(value)}; give a whole number from 0 on, or a pair of them: "
            "the seed, and the index of the first robot; or three, the last of them after "
            "how many robots the numbers come again"
        ) from None
    return entropy, first, *again


def indices(name: str, values: Any, count: int, what: str) -> tuple[int, ...]:
    """`values` as a tuple of indices below `count`; `InvalidParameter` for anything else."""
    try:
        found = tuple(whole(name, value) for value in values)
    except (TypeError, InvalidParameter):
        found = (count,)
    if any(index >= count for index in found):
        raise InvalidParameter(f"{name} is {shown(values)}; give indices of {what}, below {count}")
    return found


def function(
    name: str, value: Any, remedy: str, *arguments: object, **named: object
) -> Callable[..., Any]:
    """`value`; `InvalidParameter` for what cannot be called with such arguments."""
    try:
        inspect.signature(value).bind(*arguments, **named)
    except TypeError:
        raise InvalidParameter(f"{name} is {shown(value)}; give {remedy}") from None
    except ValueError:
        # What is written in C need not say what it takes.
        pass
    return value


def file(name: str, value: str | PathLike[str], error: type[FreesegError] = InvalidData) -> Path:
    """`value` as the path of a file, or the error."""
    try:
        return Path(value)
    except TypeError:
        raise error(f"{name} is {shown(value)}; give the path of a file") from None
