"""Tests of a problem set: one line in a notebook, and the same tests when it is graded."""

import io
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from threading import current_thread, main_thread
from traceback import walk_tb
from typing import Any, Protocol

import numpy as np

from freeseg.checks import shown
from freeseg.errors import FreesegError, InvalidParameter
from freeseg.teaching.own_work import REFUSED, without
from freeseg.teaching.plain import NotPlain, pack, unpack
from freeseg.teaching.seeds import variant_seed

#: Longest time of one call of a student's function (s).
LIMIT = 10.0


class TooLong(BaseException):
    """Time is up; not an `Exception`, for code under test may catch these."""


class Late(AssertionError):
    """A call of a student's function took longer than it may."""


class Ask(Protocol):
    """How a test asks the code that it judges, wherever that runs."""

    #: How many times the time that is stated a call may take here.
    patience: float

    def clock(self) -> float:
        """Time (s) that the code has worked, from some beginning on."""
        ...

    def __call__(self, name: str, *values: Any, limit: float = LIMIT, keep: bool = False) -> Any:
        """Call a function of a notebook.

        Parameters
        ----------
        name : str
            Its name, or that of what was kept.
        *values : object
            Its arguments, as `pack` has them.
        limit : float, optional
            Longest time (s).
        keep : bool, optional
            Whether to keep the function that it gives back, and to give back
            the name by which that can be asked.

        Raises
        ------
        AssertionError
            Where it raises, is late, or gives back no plain data; it says so.
        """
        ...


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
    Late
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
            signal.setitimer(signal.ITIMER_REAL, max(limit, 1e-3), 1.0)
            stack.callback(signal.setitimer, signal.ITIMER_REAL, 0)
        try:
            yield
        except TooLong:
            raise Late(too_long(limit)) from None


def too_long(limit: float) -> str:
    """What is said of a call that took longer than it may (s)."""
    return f"your code takes over {limit:.3g} s: is there a loop that does not end?"


class Here:
    """Asks functions of this process, as a notebook's own check does.

    Parameters
    ----------
    names : dict
        Where the functions are.
    refused : tuple of str, optional
        Modules that refuse to work meanwhile.
    """

    patience = 1.0
    clock = staticmethod(time.process_time)

    def __init__(self, names: Mapping[str, Any], refused: Sequence[str] = ()):
        self.names, self.refused = names, refused
        self.kept: dict[str, Any] = {}

    def __call__(self, name: str, *values: Any, limit: float = LIMIT, keep: bool = False) -> Any:
        """See `Ask`."""
        function = self.kept.get(name) or self.names.get(name)
        with without(*self.refused), quietly(limit * self.patience):
            found, problem = answer(function, name, unpack(pack(values), question=True))
        if problem:
            raise AssertionError(problem)
        if keep:
            self.kept[f"#{len(self.kept)}"] = found
            return f"#{len(self.kept) - 1}"
        return unpack(packed(name, found))


def answer(function: Any, name: str, values: Sequence[Any]) -> tuple[Any, str]:
    """What a student's function gives back, and what is to be said where it does not.

    Parameters
    ----------
    function : callable
        The function; None where there is none.
    name : str
        Its name.
    values : sequence
        Its arguments.
    """
    if not callable(function):
        return None, f"there is no function {name} here; run its cell first, and keep its name"
    try:
        return function(*values), ""
    except Exception as error:
        lines = [line for frame, line in walk_tb(error.__traceback__) if _in_notebook(frame)]
        place = f" (line {lines[-1]} of its cell)" if lines else ""
        hint = "; does a function of yours end without a return?" * ("NoneType" in str(error))
        what = name if name.isidentifier() else "your law"
        return None, f"{what} raised {type(error).__name__}: {error}{place}{hint}"


def _in_notebook(frame: Any) -> bool:
    return frame.f_globals is vars(sys.modules["__main__"])


def packed(name: str, found: Any) -> str:
    """An answer as it travels; `NotPlain` says whose it is."""
    try:
        return pack(found)
    except NotPlain as error:
        raise NotPlain(f"look at what {name} gives back: {error}") from None


class Law:
    """A law that is asked step by step, with the time that it may take in all.

    Parameters
    ----------
    ask : Ask
        Whom to ask.
    name : str
        Name of the function that gives the law.
    *values : object
        Its arguments.
    duration : float
        Time (s) of the run that the law may take, altogether.
    """

    def __init__(self, ask: Ask, name: str, *values: Any, duration: float):
        self.ask, self.left, self.duration = ask, duration, duration
        self.law = ask(name, *values, keep=True)

    def __call__(self, t: Any, pose: np.ndarray) -> Any:
        """V and w for a time (s) and a measured pose."""
        begin = self.ask.clock()
        try:
            found = self.ask(self.law, float(t), pose, limit=self.left)
        except Late:
            self.left = 0.0
        else:
            self.left -= (self.ask.clock() - begin) / self.ask.patience
        if self.left <= 0:
            raise Late(
                f"your law takes longer than the robot drives: over {self.duration:.1f} s in all, "
                f"at t = {t:.2f} s"
            )
        return found


class Tracker:
    """A tracker whose laws a notebook gives: what `simulate` needs, and no more.

    Parameters
    ----------
    ask : Ask
        Whom to ask for ``name(reference, robot, dt, *values)``.
    name : str, optional
        The function's name.
    *values : object
        More arguments for it.
    """

    def __init__(self, ask: Ask, name: str = "start", *values: Any):
        self.ask, self.name, self.values = ask, name, values

    def start(self, reference: Any, robot: Any, dt: float) -> Law:
        """The law for one run, which may take as long as the run does."""
        values = reference, robot, dt, *self.values
        return Law(self.ask, self.name, *values, duration=max(reference.duration, 1.0))


def find_test(name: object) -> Callable[[Ask, np.random.Generator], Any]:
    """The test of a name such as "ps1.gap".

    Raises
    ------
    InvalidParameter
        For a name that is none.
    """
    part, _, exercise = name.partition(".") if isinstance(name, str) else ("", "", "")
    if part in PROBLEM_SETS:
        tests = import_module(f"freeseg.teaching.{part}")
        if exercise in tests.__all__:
            return getattr(tests, exercise)
        raise InvalidParameter(f"name is {shown(name)}; {part} has {', '.join(tests.__all__)}")
    raise InvalidParameter(f'name is {shown(name)}; give that of a set and test, such as "ps1.gap"')


#: The problem sets.
PROBLEM_SETS = ("ps1", "ps2", "ps3", "ps4", "ps5")


def judge(name: str, ask: Ask, seeds: Sequence[int]) -> tuple[float, str]:
    """Run a test with random generators of some seeds.

    Parameters
    ----------
    name : str
        The test's.
    ask : Ask
        Whom to ask.
    seeds : sequence of int
        It is run with each, until it fails.

    Returns
    -------
    share : float
        Of the points, from 0 to 1.
    said : str
        What is wrong, or that it passed.
    """
    test = find_test(name)
    title = (test.__doc__ or "").strip().splitlines()[0].rstrip(".")
    shares, notes = [], []
    for seed in seeds:
        try:
            found = test(ask, np.random.default_rng(seed))
        except (AssertionError, FreesegError) as error:
            return 0.0, f"not yet: {title}\n{error}"
        except Exception as error:
            what = "; does a function of yours end without a return?" * ("NoneType" in str(error))
            return 0.0, (
                f"not yet: {title}\nwhat your function gives back cannot be used "
                f"({type(error).__name__}: {error}){what}"
            )
        share, note = (1.0, "") if found is None else found
        shares.append(float(share))
        notes.append(note)
    share, note = float(np.mean(shares)), f"\n{notes[0]}" * bool(notes[0])
    if share == 1:
        return share, f"passed: {title}{note}"
    return share, f"so far {100 * share:.0f} % of the points: {title}{note}"


def check(name: str, *_: Any) -> None:
    """Run a test of a problem set; say what is wrong, and let the notebook go on.

    The functions that it asks for are looked up by name in the notebook, as is
    `student`, on which its numbers depend. When a set is graded, the same test
    runs with other numbers, in another process than the notebook.

    Parameters
    ----------
    name : str
        Such as "ps1.gap".
    *_ : object
        What it tests, for a reader.

    Raises
    ------
    InvalidParameter
        For a name that is none.
    """
    names = vars(sys.modules["__main__"])
    find_test(name)
    if names.get("student") in (None, "", UNKNOWN):
        print(f"not yet: write your id into `student`, it makes your numbers ({name})")
    seed = variant_seed(name, str(names.get("student") or UNKNOWN))
    print(judge(name, Here(names, REFUSED.get(name.partition(".")[0], ())), [seed])[1])


#: What stands in a set where a student's id belongs.
UNKNOWN = "write your id here"
