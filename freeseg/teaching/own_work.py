"""Whether a student's work is their own: parts of freeseg that refuse to work meanwhile."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any


class NotOwn(AssertionError):
    """What should be a student's own calls a part of freeseg that refuses to work."""


@contextmanager
def without(*parts: Any) -> Iterator[None]:
    """Let parts of freeseg refuse to work while a student's own code must.

    Parameters
    ----------
    *parts : callable
        Functions, and classes of trackers, which refuse to start; by
        whatever name the code under test knows them.

    Raises
    ------
    NotOwn
        In what calls one of them.

    Examples
    --------
    >>> import freeseg as fs
    >>> with without(fs.tracking_error):
    ...     fs.tracking_error((0, 0, 0), (0, 0, 0))
    Traceback (most recent call last):
    freeseg.teaching.own_work.NotOwn: do it yourself, without fs.tracking_error
    """
    with ExitStack() as stack:
        for part in parts:
            function = getattr(part, "start", part)
            stack.callback(setattr, function, "__code__", function.__code__)
            function.__code__ = _refuse.__code__.replace(co_name=part.__name__)
        yield


def _refuse(*_: Any, **__: Any) -> None:
    """Stand for the function whose name this code has; it runs in that one's module."""
    import sys

    from freeseg.teaching.own_work import NotOwn

    raise NotOwn(f"do it yourself, without fs.{sys._getframe().f_code.co_name}")
