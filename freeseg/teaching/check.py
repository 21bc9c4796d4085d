"""Tests of a problem set, which say what is wrong and let the notebook go on."""

import io
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from threading import current_thread, main_thread
from traceback import walk_tb
from typing import Any

import numpy as np

#: Longest time of a test for each seed (s).
LIMIT = 20.0


class TooLong(BaseException):
    """Time is up; not an `Exception`, for code under test may catch these."""


@contextmanager
def quietly(limit: float = LIMIT) -> Iterator[None]:
    """Hide what code under test prints, and end it when its time is up.

    Parameters
    ----------
    limit : float, optional
        Longest time (s). Then `TooLong` is raised in it, and again every
        second if that is caught. Windows has no such timer, and other threads
        than the main one cannot have it: there is no limit.

    Raises
    ------
    AssertionError
        When the time is up.
    """

    def stop(*_: object) -> None:
        raise TooLong

    with warnings.catch_warnings(), ExitStack() as stack:
        warnings.simplefilter("ignore")
        for redirect in (redirect_stdout, redirect_stderr):
            stack.enter_context(redirect(io.StringIO()))
        if hasattr(signal, "setitimer") and current_thread() is main_thread():
            stack.callback(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, stop))
            signal.setitimer(signal.ITIMER_REAL, limit, 1.0)
            stack.callback(signal.setitimer, signal.ITIMER_REAL, 0)
        try:
            yield
        except TooLong:
            raise AssertionError(
                f"your code takes over {limit:g} s: is there a loop that does not end?"
            ) from None


def check(test: Callable[[np.random.Generator], None], *seeds: int, limit: float = LIMIT) -> None:
    """Run a test of a problem set; say what fails, and let the notebook go on.

    What fails is printed to the error stream, for which nbgrader gives no
    points. What the code under test prints or warns of is not shown and does
    not count.

    Parameters
    ----------
    test : callable
        ``test(rng)`` raises an `AssertionError` that says what is wrong. The
        first line of its docstring says what it tests.
    *seeds : int
        It is run with a random generator of each, until it fails.
    limit : float, optional
        Longest time for each seed (s).
    """
    title = (test.__doc__ or "a test without a docstring").strip().splitlines()[0]
    for seed in seeds:
        try:
            with quietly(limit):
                test(np.random.default_rng(seed))
        except AssertionError as error:
            found = str(error) or "an assert failed, and has no message"
        except Exception as error:
            found = f"your code raised {type(error).__name__}: {error}{_place(error, test)}"
            if "NoneType" in str(error):
                found += "; does a function of yours end without a return?"
        else:
            continue
        print(f"not yet: {title}\n{found}", file=sys.stderr)
        return
    print(f"passed: {title}")


def _place(error: Exception, test: Any) -> str:
    """Where in the notebook an error came from, if not in the test itself."""
    frames = [
        (frame.f_code.co_name, line)
        for frame, line in walk_tb(error.__traceback__)
        if frame.f_globals is getattr(test, "__globals__", None)
    ]
    if not frames:
        return ""
    name, line = frames[-1]
    return "" if name == test.__name__ else f" (in {name}, line {line} of its cell)"
