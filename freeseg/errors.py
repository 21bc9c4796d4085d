"""The errors that freeseg raises; each message names the value and the remedy."""

from collections import abc
from typing import Any


class FreesegError(Exception):
    """Base of every error that freeseg raises on purpose."""


class InvalidWorld(FreesegError, ValueError):
    """The obstacles make no sense."""


class InvalidQuery(FreesegError, ValueError):
    """The start or the goal is not a free position."""


class InvalidParameter(FreesegError, ValueError):
    """A robot, margin, speed, gain, time step, path or disturbance is out of its range."""


class InvalidData(FreesegError, ValueError):
    """A file is missing, cannot be read or written, or holds what makes no sense."""


class NoPath(FreesegError):
    """There is no path for this robot and margin: the search proved it.

    Parameters
    ----------
    message : str
        What leaves no path.
    remedy : callable, optional
        What helps, in words. It takes some more searches to say what would pass, so it is
        asked when the message is first read: who only catches the error pays nothing.
    """

    def __init__(self, message: str, remedy: abc.Callable[[], str] | None = None):
        super().__init__(message)
        self._remedy = remedy

    def __str__(self) -> str:
        if self._remedy is not None:
            self.args = (f"{self.args[0]}; {self._remedy()}",)
            self._remedy = None
        return super().__str__()

    def __reduce__(self) -> tuple[type["NoPath"], tuple[str]]:
        # Another process has no world to ask.
        return type(self), (str(self),)


class Trapped(FreesegError):
    """A planner that proves nothing found no safe path, or a reactive law did not arrive.

    Attributes
    ----------
    steps : tuple of Step
        What the planner tried.
    run : ReactiveRun or None
        What the robot drove by the law.
    """

    def __init__(self, message: str, steps: abc.Iterable = (), run: Any = None):
        super().__init__(message)
        self.steps = tuple(steps)
        self.run = run


class SolverFailed(FreesegError):
    """The solver of a tracker found no command.

    Attributes
    ----------
    time : float
        When (s).
    status : str
        What the solver says of it.
    """

    def __init__(self, message: str, time: float = float("nan"), status: str = ""):
        super().__init__(message)
        self.time = time
        self.status = status
