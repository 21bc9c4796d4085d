"""A differential-drive robot: sizes, limits, wheel and body velocities, exact motion."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import cache
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidData, InvalidParameter

#: Sizes that differ by less than this share of them are the same, but for round-off.
SAME = 1e-9

#: What a message asks for where wheel speeds are wanted.
WHEELS = "right and left wheel speed (m/s)"


@cache
def _datasheet() -> dict[str, float]:
    """Parameters of ``data/khepera4.csv`` in SI units."""
    to_si = {"mm": 1e-3, "rad/s": 1.0, "rad/s^2": 1.0}
    parameters = {}
    for row in read_csv(DATA / "khepera4.csv", {"parameter": str, "value": float, "unit": str}):
        if row["unit"] not in to_si:
            raise InvalidData(
                f"khepera4.csv, row {row['row']}: unit {row['unit']!r} is not in {sorted(to_si)}"
            )
        parameters[row["parameter"]] = row["value"] * to_si[row["unit"]]
    return parameters


def _published(name: str) -> Any:
    """Dataclass field whose default stands in ``data/khepera4.csv``."""
    return field(default_factory=lambda: _datasheet()[name])


@dataclass(frozen=True)
class Robot:
    """A differential-drive robot with a round body.

    Parameters
    ----------
    wheel_base : float
        Distance L between the wheels (m), at most the diameter.
    diameter : float
        Diameter D_r of the body, wheels included (m); of a body that is not
        round, see `from_footprint`.
    wheel_radius : float
        Radius of a wheel (m).
    max_wheel_rate : float
        Largest angular speed of a wheel (rad/s).
    max_wheel_rate_change : float
        Largest angular acceleration of a wheel (rad/s^2).

    Raises
    ------
    InvalidParameter
        For a value that is not a positive finite number, and for wheels that
        stand outside the body.

    Examples
    --------
    >>> Robot(0.16, 0.21, 0.033, 6.7, 30.0).radius  # much like a TurtleBot 3 Burger
    0.105
    """

    wheel_base: float
    diameter: float
    wheel_radius: float
    max_wheel_rate: float
    max_wheel_rate_change: float

    def __post_init__(self):
        for parameter in fields(self):
            value = checks.positive(f"robot.{parameter.name}", getattr(self, parameter.name))
            object.__setattr__(self, parameter.name, value)
        if self.wheel_base > self.diameter * (1 + SAME):
            raise InvalidParameter(
                f"robot.wheel_base is {self.wheel_base:g} m, but robot.diameter only "
                f"{self.diameter:g} m, so the wheels would stick out of the disc that is planned "
                "for; give a diameter that covers the wheels, or their outline to "
                "Robot.from_footprint, or a smaller wheel_base; lengths are in metres, not cm"
            )

    def __str__(self):
        return f"<{type(self).__name__}, {self.diameter:g} m wide>"

    @classmethod
    def from_footprint(cls, outline: ArrayLike, **sizes: float) -> Self:
        """Robot of any footprint, planned for by the circle that it turns in.

        Parameters
        ----------
        outline : array_like, shape (n, 2)
            Corners of the body, wheels included (m), seen from the middle of
            the axle.
        **sizes : float
            All other parameters.

        Raises
        ------
        InvalidParameter
            For an outline that is not such an array, or sizes as above.

        Notes
        -----
        Turning on the spot, the body stays in the circle about the middle of
        the axle through the farthest corner: a plan for its disc is safe for
        the body, though a slim one could pass where the disc does not fit.

        Examples
        --------
        >>> motors = dict(wheel_radius=0.1, max_wheel_rate=9, max_wheel_rate_change=30)
        >>> outline = [(0.4, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.4, -0.3)]
        >>> Robot.from_footprint(outline, wheel_base=0.5, **motors).diameter
        1.0
        """
        corners = checks.array("outline", outline, (None, 2))
        return cls(diameter=2 * float(np.hypot(*corners.T).max(initial=0)), **sizes)

    @property
    def radius(self) -> float:
        """Radius R_r of the body (m)."""
        return self.diameter / 2

    @property
    def max_wheel_speed(self) -> float:
        """Largest speed of a wheel over the ground (m/s)."""
        return self.max_wheel_rate * self.wheel_radius

    @property
    def max_wheel_acceleration(self) -> float:
        """Largest acceleration of a wheel over the ground (m/s^2)."""
        return self.max_wheel_rate_change * self.wheel_radius

    def to_wheels(self, v: ArrayLike, omega: ArrayLike) -> np.ndarray:
        """Wheel speeds for a body velocity, equation (8).

        Parameters
        ----------
        v, omega : array_like, shape (...)
            Forward speed (m/s) and turn rate (rad/s).

        Returns
        -------
        ndarray, shape (2, ...)
            Right and left wheel speed (m/s).

        Raises
        ------
        InvalidParameter
            For what is no finite number, or shapes that do not belong together.
        """
        v = checks.signal("v", v, "speeds (m/s)")
        omega = checks.signal("omega", omega, "turn rates (rad/s)")
        checks.together(v=v.shape, omega=omega.shape)
        return wheel_speeds(self, v, omega)

    def to_body(self, wheels: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Forward speed and turn rate for wheel speeds, equation (1).

        Parameters
        ----------
        wheels : array_like, shape (2, ...)
            Right and left wheel speed (m/s).

        Returns
        -------
        v, omega : ndarray, shape (...)
            Forward speed (m/s) and turn rate (rad/s).

        Raises
        ------
        InvalidParameter
            For what are not two rows of finite numbers.
        """
        return body_velocity(self, checks.signal("wheels", wheels, WHEELS, 2))

    def saturate(self, wheels: ArrayLike, previous: ArrayLike, dt: ArrayLike) -> np.ndarray:
        """Wheel speeds that the motors get to within one time step.

        A command above the speed limit is scaled down as a whole, so that
        the curvature of the motion stays; each wheel then changes from its
        previous speed as far as the acceleration limit lets it.

        Parameters
        ----------
        wheels, previous : array_like, shape (2, ...)
            Commanded and present right and left wheel speed (m/s).
        dt : float, or array_like of shape (...)
            Time step (s).

        Returns
        -------
        ndarray, shape (2, ...)
            Wheel speeds (m/s) at the end of it.

        Raises
        ------
        InvalidParameter
            For what are not two rows of finite numbers, shapes that do not
            belong together, or a time step that is negative.
        """
        wheels = checks.signal("wheels", wheels, WHEELS, 2)
        previous = checks.signal("previous", previous, WHEELS, 2)
        dt = checks.times("dt", dt)
        checks.together(wheels=wheels.shape[1:], previous=previous.shape[1:], dt=dt.shape)
        # Both wheels first, then as many axes each: else a pair could stand for two robots.
        axes = max(wheels.ndim, previous.ndim, 1 + dt.ndim)
        wheels, previous = (
            np.expand_dims(speeds, tuple(range(1, 1 + axes - speeds.ndim)))
            for speeds in (wheels, previous)
        )
        return reached_speeds(self, wheels, previous, dt)

    def move(self, pose: ArrayLike, wheels: ArrayLike, dt: ArrayLike) -> np.ndarray:
        """Pose after driving with constant wheel speeds: an exact arc.

        The solution of equation (1) for constant wheel speeds; the chord of
        the arc is v dt sinc(omega dt / 2), so that a straight line is no
        special case.

        Parameters
        ----------
        pose : array_like, shape (3, ...)
            x, y (m) and heading (rad).
        wheels : array_like, shape (2, ...)
            Right and left wheel speed (m/s).
        dt : float, or array_like of shape (...)
            Time (s).

        Returns
        -------
        ndarray, shape (3, ...)
            Pose after `dt`; the heading is not wrapped.

        Raises
        ------
        InvalidParameter
            For what are not three, or two, rows of finite numbers, shapes that
            do not belong together, or a time that is negative.
        """
        pose = checks.signal("pose", pose, "x, y (m) and heading (rad)", 3)
        wheels = checks.signal("wheels", wheels, WHEELS, 2)
        dt = checks.times("dt", dt)
        checks.together(pose=pose.shape[1:], wheels=wheels.shape[1:], dt=dt.shape)
        return moved_pose(self, pose, wheels, dt)


def wheel_speeds(robot: Robot, v: ArrayLike, omega: ArrayLike) -> np.ndarray:
    """`Robot.to_wheels` without its checks, for the laws and the loop."""
    difference = 0.5 * robot.wheel_base * np.asarray(omega)
    return np.stack([np.add(v, difference), np.subtract(v, difference)])


def body_velocity(robot: Robot, wheels: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """`Robot.to_body` without its checks, for the laws and the loop."""
    right, left = np.asarray(wheels, float)
    return 0.5 * (right + left), (right - left) / robot.wheel_base


def reached_speeds(robot: Robot, wheels: ArrayLike, previous: ArrayLike, dt: Any) -> np.ndarray:
    """`Robot.saturate` without its checks, for the laws and the loop."""
    wheels, previous = np.asarray(wheels, float), np.asarray(previous, float)
    fastest = np.maximum(np.abs(wheels[0]), np.abs(wheels[1]))
    target = wheels * (robot.max_wheel_speed / np.maximum(fastest, robot.max_wheel_speed))
    largest_change = robot.max_wheel_acceleration * dt
    return previous + np.clip(target - previous, -largest_change, largest_change)


def moved_pose(robot: Robot, pose: ArrayLike, wheels: ArrayLike, dt: Any) -> np.ndarray:
    """`Robot.move` without its checks, for the loop."""
    x, y, theta = np.asarray(pose)
    v, omega = body_velocity(robot, wheels)
    half_turn = 0.5 * omega * dt
    chord = v * dt * np.sinc(half_turn / np.pi)
    middle = theta + half_turn
    moved = np.empty((3, *np.shape(middle)))
    moved[0] = x + chord * np.cos(middle)
    moved[1] = y + chord * np.sin(middle)
    moved[2] = theta + 2 * half_turn
    return moved


@dataclass(frozen=True)
class KheperaIV(Robot):
    """The Khepera IV, or one with some sizes changed.

    Every default is published, with its source, in ``data/khepera4.csv``.

    Parameters
    ----------
    wheel_base, diameter, wheel_radius, max_wheel_rate, max_wheel_rate_change
        As for `Robot`.

    Examples
    --------
    >>> KheperaIV().diameter
    0.1408
    """

    wheel_base: float = _published("wheel_base")
    diameter: float = _published("diameter")
    wheel_radius: float = _published("wheel_radius")
    max_wheel_rate: float = _published("max_wheel_rate")
    max_wheel_rate_change: float = _published("max_wheel_rate_change")


def with_wheel_base(robot: Robot, wheel_base: float | np.ndarray) -> Robot:
    """`robot` as it turns, not as it was measured: with another wheel base (m).

    How a robot turns stands for all that makes it turn differently, so the base may be
    wider than the body; a batch has an array of them, shape (n,).
    """
    true = replace(robot)
    object.__setattr__(true, "wheel_base", wheel_base)
    return true


def as_robot(robot: Robot | None) -> Robot:
    """`robot`, a Khepera IV for None; `InvalidParameter` for anything else."""
    if robot is None:
        return KheperaIV()
    remedy = "a Robot, such as fs.KheperaIV()"
    if not isinstance(robot, Robot) and math.isfinite(number := checks.as_float(robot)):
        remedy += f", or name what the number is for, such as margin={number:g}"
    return checks.instance("robot", robot, Robot, remedy)


def contrast(robot: Robot, other: Robot) -> tuple[str, str]:
    """Texts of two robots, with the sizes in which they differ."""
    names = [size.name for size in fields(Robot)]
    names = [name for name in names if getattr(robot, name) != getattr(other, name)]
    first, second = (
        f"{type(one).__name__}({', '.join(f'{name}={getattr(one, name)!r}' for name in names)})"
        for one in (robot, other)
    )
    return first, second


def same_robot(robot: Robot | None, other: Robot | None, what: str) -> Robot | None:
    """The one robot that two name, or None where neither does.

    Parameters
    ----------
    robot, other : Robot or None
        Robots; None leaves it to the other one.
    what : str
        What the other one is of, for the message.

    Raises
    ------
    InvalidParameter
        For what is no robot, or for two different ones.
    """
    if robot is None or other is None:
        return other if robot is None else as_robot(robot)
    if as_robot(robot) != other:
        mine, theirs = contrast(robot, other)
        raise InvalidParameter(f"robot is {mine}, but {what} is for {theirs}; give the same one")
    return other
