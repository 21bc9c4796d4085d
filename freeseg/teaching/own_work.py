"""Whether a student's work is their own: parts of freeseg that refuse to work meanwhile."""

import inspect
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import Any

#: Parts of the package that stand for the answers of a set, and refuse to work for them.
REFUSED = {"ps2": ("freeseg.planners",), "ps4": ("freeseg.planners",)}


class NotOwn(AssertionError):
    """What should be a student's own calls a part of freeseg that refuses to work."""


def refuse(*parts: str) -> dict[FunctionType, CodeType]:
    """Let all functions and methods of some modules refuse to work, whoever holds them.

    Parameters
    ----------
    *parts : str
        Names of modules, with those below them, as far as they are imported.

    Returns
    -------
    dict
        The code that each function had. Whoever drops it cannot get it back.
    """
    codes = {}
    for function in _functions(parts):
        codes[function] = function.__code__
        free = function.__code__.co_freevars
        replaced = _refuse.__code__.replace(co_name=function.__name__, co_freevars=free)
        function.__code__ = replaced
    return codes


@contextmanager
def without(*parts: str) -> Iterator[None]:
    """Let parts of freeseg refuse to work while a student's own code must.

    Parameters
    ----------
    *parts : str
        As for `refuse`.

    Raises
    ------
    NotOwn
        In what calls one of their functions.

    Examples
    --------
    >>> import freeseg as fs
    >>> with without("freeseg.planners"):
    ...     fs.plan(fs.load_table(1), (0, 0), (1, 1))
    Traceback (most recent call last):
    freeseg.teaching.own_work.NotOwn: do it yourself, without freeseg's plan
    """
    codes = refuse(*parts)
    try:
        yield
    finally:
        for function, code in codes.items():
            function.__code__ = code


@cache
def _functions(parts: tuple[str, ...]) -> frozenset[FunctionType]:
    """Functions and methods of some modules, and of those below them."""
    return frozenset(
        function
        for name, module in list(sys.modules.items())
        if any(name == part or name.startswith(f"{part}.") for part in parts)
        for function in _functions_of(module)
    )


def _functions_of(module: ModuleType) -> Iterator[FunctionType]:
    """Functions and methods that a module defines, also below decorators."""
    for value in list(vars(module).values()):
        inner = vars(value).values() if isinstance(value, type) else (value,)
        for one in inner:
            one = getattr(one, "func", getattr(one, "fget", getattr(one, "__func__", one)))
            one = inspect.unwrap(one) if callable(one) else one
            if isinstance(one, FunctionType) and one.__module__ == module.__name__:
                yield one


def _refuse(*_: Any, **__: Any) -> None:
    """Stand for the function whose name this code has; it runs in that one's module."""
    import sys

    from freeseg.teaching.own_work import NotOwn

    raise NotOwn(f"do it yourself, without freeseg's {sys._getframe().f_code.co_name}")
