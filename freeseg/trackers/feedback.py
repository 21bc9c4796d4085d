"""What every tracker does alike: start a law, check its gains, and see its errors."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.reference import GRID, Reference, Sample, pose_error
from freeseg.robot import Robot, as_robot, body_velocity, reached_speeds, wheel_speeds

#: Up to it, the product of a step of an integral and an excess is no saturation (SI).
NO_EXCESS = 1e-15

#: A slower reference rests (m/s, rad/s).
REST = 1e-9


class Law(Protocol):
    """What drives a robot for one run: a body velocity for a time and a pose."""

    def __call__(self, t: float, pose: np.ndarray, /) -> tuple[ArrayLike, ArrayLike]:
        """Command at a time step; to be asked once for each, in their order.

        Parameters
        ----------
        t : float
            Time (s).
        pose : ndarray, shape (3,) or (3, n)
            Measured x, y (m) and heading (rad) of one robot or of n.

        Returns
        -------
        v, omega : array_like, shape () or (n,)
            Forward speed (m/s) and turn rate (rad/s).
        """


class Tracker(Protocol):
    """Gains, from which a law starts."""

    def start(self, reference: Reference, robot: Robot, dt: float, /) -> Law:
        """The law for one run; what it remembers lives in it alone.

        Parameters
        ----------
        reference : Reference
            What to follow.
        robot : Robot
            Robot, for a law that knows its limits; most do not.
        dt : float
            Time for which each command is held (s).

        Returns
        -------
        Law
            ``law(t, pose) -> (v, omega)``, for a pose of shape (3,) or (3, n).
        """


def starts(gains: object) -> bool:
    """Whether a law can be started from gains: from an object, and not from its class."""
    return not isinstance(gains, type) and callable(getattr(gains, "start", None))


def check_tracker(tracker: object) -> None:
    """Raise `InvalidParameter` for what is no tracker, and say what it seems to be."""
    if starts(tracker):
        return
    remedy = "give one, such as SlidingMode()"
    if hasattr(tracker, "tracker"):
        remedy = "give its .tracker"
    elif callable(tracker) and not isinstance(tracker, type):
        remedy += "; fs.drive(law, pose, dt, steps) drives by a law"
    raise InvalidParameter(f"tracker is {checks.shown(tracker)}; {remedy}")


def check_gains(tracker: Any, *switches: str) -> None:
    """Make every float of a tracker one; `InvalidParameter` unless positive and finite.

    Parameters
    ----------
    tracker : Tracker
        A frozen dataclass.
    *switches : str
        Gains that may be zero, which switches their term off, as well as that
        named ``preview``, see `watch`.
    """
    for gain in fields(tracker):
        if gain.type is float:
            check = checks.not_negative if gain.name in (*switches, "preview") else checks.positive
            value = check(gain.name, getattr(tracker, gain.name))
            object.__setattr__(tracker, gain.name, value)


def forwards_only(tracker: Any, reference: Reference, spot: bool = True) -> None:
    """Raise `InvalidParameter` where a reference asks for what a tracker cannot do.

    Parameters
    ----------
    tracker : Tracker
        One that can only drive forwards.
    reference : Reference
        What to follow.
    spot : bool, optional
        Whether it can turn on the spot.
    """
    resting = np.abs(reference.v) <= REST
    for what, there in (
        ("reverses", reference.v < -REST),
        ("turns on the spot", resting & (np.abs(reference.omega) > REST) & (not spot)),
    ):
        if there.any():
            raise InvalidParameter(
                f"the reference {what} at {reference.t[np.argmax(there)]:.3f} s, which "
                f"{type(tracker).__name__} cannot follow; choose another tracker, such as Pid"
            )


def watch(
    reference: Reference, dt: float, preview: float = 0.0
) -> Callable[[float, np.ndarray], tuple[np.ndarray, Sample]]:
    """What a law sees at a time step.

    A command is held for `dt`: the velocities that it is made from are those
    wanted at the middle of it, or their means over a longer time about it. Means
    begin to change before the reference does: wheels that cannot follow a step
    of the turn rate are on average in time.

    Parameters
    ----------
    reference : Reference
        What to follow.
    dt : float
        Time for which each command is held (s); zero for a law in continuous time.
    preview : float, optional
        Length of the time (s), half of it before and half of it after the middle
        of the command, over which the velocities are averaged; zero for none.

    Returns
    -------
    callable
        ``see(t, pose) -> (error, wanted)`` for a pose of shape (3,) or
        (3, n): the tracking error (7) at t, of the pose's shape, and the
        reference's `Sample` at t + dt / 2, with the means of its velocities
        and of their rates if there is a preview.

    Raises
    ------
    InvalidParameter
        For what is no reference, or a time step that is negative.
    """
    checks.instance("reference", reference, Reference, "one made by make_reference")
    look, mean = reference.sampler(dt), _averages(reference, preview)

    def see(t, pose):
        now_and_middle = look(t)
        wanted = Sample(*(values[..., 1] for values in now_and_middle))
        if np.any(preview):
            wanted = Sample(wanted.pose, *mean(t + dt / 2))
        return pose_error(now_and_middle.pose[:, 0], pose), wanted

    return see


def _averages(reference, preview):
    """``mean(t)``: the velocities and their rates, averaged about a time."""
    steps, v = np.diff(reference.t), reference.v
    driven = np.concatenate([[0.0], np.cumsum(steps * (v[1:] + v[:-1]) / 2)])
    # The mean of a rate is by how much that changes whose rate it is. Over less than the grid's
    # step, it would be lost in round-off.
    changing, span = (driven, reference.pose[2], v, reference.omega), np.maximum(preview, GRID)

    def mean(t):
        ends = t - span / 2, t + span / 2
        return [(np.diff(np.interp(ends, reference.t, one), axis=0) / span)[0] for one in changing]

    return mean


def follow_limits(
    robot: Robot, dt: float
) -> Callable[[ArrayLike, ArrayLike], tuple[np.ndarray, np.ndarray]]:
    """What the limits of the wheels leave of commands, for a law that stops its integrals.

    Parameters
    ----------
    robot : Robot
        Robot; a Khepera IV for None.
    dt : float
        Time for which each command is held (s).

    Returns
    -------
    callable
        ``send(v, omega) -> (v, omega)`` that the wheels reach, from rest on,
        without delay and lag; to be called once for each command, in their order.
    """
    robot, wheels = as_robot(robot), 0.0

    def send(v, omega):
        nonlocal wheels
        wheels = reached_speeds(robot, wheel_speeds(robot, v, omega), wheels, dt)
        return body_velocity(robot, wheels)

    return send


def winds_up(step: float | np.ndarray, excess: float | np.ndarray) -> bool | np.ndarray:
    """Whether a step of an integral only pushes further what a limit cuts off already."""
    return step * excess > NO_EXCESS
