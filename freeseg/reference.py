"""A path with a time law: what a tracker has to follow."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from freeseg.errors import InvalidParameter
from freeseg.geometry import wrap_angle
from freeseg.path import Path
from freeseg.robot import as_robot, check_positive

#: Cruising speed (m/s) and acceleration along the path (m/s^2). Not published: assumptions.
SPEED, ACCELERATION = 0.1, 0.2

#: Time between two points of a reference (s), and how many points a slow one has at most.
GRID, MOST_POINTS = 0.001, 200_000


class Sample(NamedTuple):
    """A reference at some times: pose (3, ...), speeds and their rates (...)."""

    pose: np.ndarray
    v: np.ndarray
    omega: np.ndarray
    v_dot: np.ndarray
    omega_dot: np.ndarray


@dataclass(frozen=True, eq=False)
class Reference:
    """A timed reference on a grid.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time (s), increasing from zero.
    pose : ndarray, shape (3, n)
        x_r, y_r (m) and heading alpha_r (rad, not wrapped).
    v, omega : ndarray, shape (n,)
        Speed v_r (m/s) and turn rate w_r (rad/s).
    v_dot, omega_dot : ndarray, shape (n,)
        Their rates (m/s^2, rad/s^2).

    Raises
    ------
    InvalidParameter
        For arrays that are not finite or do not belong together.
    """

    t: np.ndarray
    pose: np.ndarray
    v: np.ndarray
    omega: np.ndarray
    v_dot: np.ndarray
    omega_dot: np.ndarray

    def __post_init__(self):
        n = len(self.t)
        if n < 2 or self.t[0] != 0 or not (np.diff(self.t) > 0).all():
            raise InvalidParameter(
                f"reference has times {self.t!r}; give two or more, increasing from zero"
            )
        for name in Sample._fields:
            array, shape = getattr(self, name), (3, n) if name == "pose" else (n,)
            if np.shape(array) != shape or not np.isfinite(array).all():
                raise InvalidParameter(f"reference {name} needs finite numbers of shape {shape}")

    @property
    def duration(self):
        """Time from the first to the last point (s)."""
        return float(self.t[-1])

    def at(self, t):
        """Reference at times, interpolated; at rest at an end beyond it.

        Parameters
        ----------
        t : array_like, shape (...)
            Time (s).

        Returns
        -------
        Sample
            ``pose, v, omega, v_dot, omega_dot``.
        """
        t = np.asarray(t, float)
        pose = np.stack([np.interp(t, self.t, row) for row in self.pose])
        outside = (t < 0) | (t > self.duration)
        rates = (self.v, self.omega, self.v_dot, self.omega_dot)
        return Sample(pose, *(np.where(outside, 0.0, np.interp(t, self.t, rate)) for rate in rates))

    def steps(self, dt):
        """Times 0, dt, ... (s) up to the end, which the last passes by less than dt."""
        return dt * np.arange(int(np.ceil(self.duration / dt - 1e-9)) + 1)

    def sampler(self, dt):
        """Reference at a time and half a step later, read off at the steps of a run.

        Parameters
        ----------
        dt : float
            Time step (s); zero for a law that is in continuous time.

        Returns
        -------
        callable
            ``look(t) -> Sample``, as ``at([t, t + dt / 2])`` and several times
            faster where t is one of the ``steps(dt)``.
        """
        steps = self.steps(dt) if dt > 0 else np.empty(0)
        ahead = self.at(np.stack([steps, steps + dt / 2], -1))
        numbers = {t: number for number, t in enumerate(steps.tolist())}

        def look(t):
            number = numbers.get(t)
            if number is None:
                return self.at([t, t + dt / 2])
            return Sample(*(values[..., number, :] for values in ahead))

        return look


def make_reference(path, robot=None, speed=SPEED, acceleration=ACCELERATION):
    """Drive a path from rest to rest with a trapezoidal speed.

    The paper publishes no speed and no time law: both are assumptions.

    Parameters
    ----------
    path : Path
        What to follow.
    robot : KheperaIV, optional
        Robot; its wheels bound the speed.
    speed : float, optional
        Cruising speed (m/s).
    acceleration : float, optional
        Rate at which it is reached and left (m/s^2).

    Returns
    -------
    Reference
        On a grid of 1 ms, or coarser where it lasts longer than 200 s.

    Raises
    ------
    InvalidParameter
        For a speed or an acceleration that is not positive or that a wheel
        cannot deliver on the tightest arc of the path.

    Notes
    -----
    Where a line meets an arc, the curvature and so w_r jump: no robot
    follows that exactly. omega_dot is the rate without these jumps.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    >>> round(make_reference(plan.path).duration, 2)
    11.82
    """
    robot = as_robot(robot)
    speed = check_positive("speed", speed)
    acceleration = check_positive("acceleration", acceleration)
    if not isinstance(path, Path):
        raise InvalidParameter(f"path is a {type(path).__name__}; give a Path, such as plan.path")
    tightest = max(abs(piece.curvature) for piece in path.pieces)
    outer = 1 + tightest * robot.wheel_base / 2
    for name, value, limit, unit in (
        ("speed", speed, robot.max_wheel_speed, "m/s"),
        ("acceleration", acceleration, robot.max_wheel_acceleration, "m/s^2"),
    ):
        if value > limit / outer:
            raise InvalidParameter(
                f"{name} is {value:g} {unit}; on the tightest arc of this path, of radius "
                f"{1 / tightest if tightest else np.inf:.4f} m, the outer wheel allows at most "
                f"{limit / outer:.4f} {unit}"
            )
    # A short path is left for braking before the cruising speed is reached.
    top = min(speed, np.sqrt(acceleration * path.length))
    ramp = top / acceleration
    duration = ramp + path.length / top
    t = np.linspace(0, duration, int(min(np.ceil(duration / GRID) + 1, MOST_POINTS)))
    v = np.minimum(top, acceleration * np.minimum(t, duration - t))
    v_dot = acceleration * ((t < ramp).astype(float) - (t > duration - ramp))
    from_end = np.minimum(t, duration - t)
    ramped = 0.5 * acceleration * np.minimum(from_end, ramp) ** 2 + top * np.maximum(
        from_end - ramp, 0
    )
    s = np.where(t <= duration / 2, ramped, path.length - ramped)
    x, y, theta, curvature = path.at(s)
    return Reference(t, np.stack([x, y, theta]), v, v * curvature, v_dot, v_dot * curvature)


def tracking_error(reference_pose, pose):
    """Error of a pose in the robot's frame, equation (7).

    Parameters
    ----------
    reference_pose, pose : array_like, shape (3, ...)
        x, y (m) and heading (rad) wanted and actual.

    Returns
    -------
    ndarray, shape (3, ...)
        x_e, y_e (m) and alpha_e (rad, in (-pi, pi]).

    Examples
    --------
    A reference 1 m north of a robot that looks north is straight ahead.

    >>> [float(round(e, 12)) for e in tracking_error((0, 1, 0), (0, 0, np.pi / 2))]
    [1.0, 0.0, -1.570796326795]
    """
    x_r, y_r, theta_r = reference_pose
    x, y, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    dx, dy = x_r - x, y_r - y
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, wrap_angle(theta_r - theta)])
