"""What the problem sets in ``notebooks/assignments/`` share: seeds, checks, whose work it is."""

import io
import signal
import sys
import warnings
import zlib
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from unittest.mock import patch

import numpy as np

from freeseg.errors import InvalidParameter


def variant_seed(course, student):
    """Seed of the worlds that one student of one course works on.

    Parameters
    ----------
    course, student : str
        Their names; capitals and outer blanks do not count.

    Returns
    -------
    int
        The same for the same names, everywhere.

    Raises
    ------
    InvalidParameter
        For a name that is no text, or empty.

    Examples
    --------
    >>> variant_seed("robotics", "Ada ") == variant_seed("robotics", "ada")
    True
    """
    for name, value in (("course", course), ("student", student)):
        if not isinstance(value, str) or not value.strip():
            raise InvalidParameter(f'{name} is {value!r}; give a name in quotes, such as "ada"')
    return zlib.crc32("\n".join(name.strip().lower() for name in (course, student)).encode())


class TooLong(BaseException):
    """A test has run out of its time; not an `Exception`, which code under test may catch."""


@contextmanager
def time_limit(seconds):
    """Raise `TooLong` in what takes longer, and again every second if that is caught.

    Windows has no such timer: there, nothing is raised.
    """
    if not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_):
        raise TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def check(test, *seeds, limit=20.0):
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
    title = test.__doc__.strip().splitlines()[0]
    for seed in seeds:
        aside = io.StringIO()
        try:
            with warnings.catch_warnings(), redirect_stdout(aside), redirect_stderr(aside):
                warnings.simplefilter("ignore")
                with time_limit(limit):
                    test(np.random.default_rng(seed))
        except TooLong:
            found = f"your code takes over {limit:g} s: is there a loop that does not end?"
        except AssertionError as error:
            found = str(error) or "an assert of your own failed, and has no message"
        except Exception as error:
            found = f"your code raised {type(error).__name__}: {error}"
        else:
            continue
        print(f"not yet: {title}\n{found}", file=sys.stderr)
        return
    print(f"passed: {title}")


@contextmanager
def without(*parts):
    """Let parts of freeseg refuse to work while a student's own code must.

    Parameters
    ----------
    *parts : callable
        Functions, which refuse to be called under whatever name a module
        has them; and trackers' classes, which refuse to start, subclasses
        that do not start by themselves among them.

    Examples
    --------
    >>> import freeseg as fs
    >>> with without(fs.tracking_error):
    ...     fs.tracking_error((0, 0, 0), (0, 0, 0))
    Traceback (most recent call last):
    AssertionError: do it yourself, without fs.tracking_error
    """
    names = "__main__", "freeseg"
    modules = [module for name, module in sys.modules.items() if name.split(".")[0] in names]
    with ExitStack() as stack:
        for part in parts:

            def refuse(*_, name=part.__name__, **__):
                raise AssertionError(f"do it yourself, without fs.{name}")

            if isinstance(part, type):
                stack.enter_context(patch.object(part, "start", refuse))
                continue
            for module in modules:
                for name in [name for name, value in vars(module).items() if value is part]:
                    stack.enter_context(patch.object(module, name, refuse))
        yield
