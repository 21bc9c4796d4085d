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
    """There is no path for this robot and margin: the search proved it."""


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
