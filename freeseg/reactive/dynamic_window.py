"""Dynamic window: the best of the velocities that can be reached and stopped from."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.geometry import TINY, wrap_angle
from freeseg.reactive.sensing import check_drive, for_each, outlines_of, scan
from freeseg.reference import SPEED
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, follow_limits

#: Weights of a velocity and of its two neighbours in the smoothing of the objective.
SMOOTHED = 0.25, 0.5, 0.25

#: Slower turns drive straight on (rad/s).
NO_TURNING = 1e-9

#: A finer grid of velocities would take seconds for a step.
MOST_VALUES = 1000


@dataclass(frozen=True)
class DynamicWindow:
    """Gains of the dynamic window (D. Fox, W. Burgard, S. Thrun, *IEEE RAM* 4(1), 1997).

    Of the velocities (v, w) that are allowed, that with the largest objective is driven until
    the next step (the numbers of the equations are ours),

        (D1)  G = smoothed(to_goal heading + to_clear dist + to_speed velocity),

    where each term lies between 0 and 1:

    - *heading* is 1 - |angle to the goal| / pi where the robot would rest, after it has driven
      (v, w) for the interval and then braked as hard as it can;
    - *dist* is how far the arc of curvature w / v leads until the body, grown by the margin,
      meets a reading; relative to the reach, or to the distance from the goal where that is less.
      On the spot no reading is ever met: there, it is how far the way is free that the robot
      has turned to, without which it would stand before an obstacle and look at it;
    - *velocity* is v, relative to the top speed, which is lower near the goal.

    Smoothing, over neighbours in the grid of velocities, leaves more room beside obstacles, for
    there the objective of a velocity that is not allowed counts as zero. Allowed are those

        (D2)  0 <= v <= speed, |w| <= turn_rate, which the wheels can turn;
        (D3)  from which the robot stops in time,
              v <= sqrt(2 dist a) and |w| <= sqrt(2 dist a_w),
              with the largest decelerations a and a_w = 2 a / L of the wheels;
        (D4)  that the wheels reach in one step from those they turn at: the dynamic window.

    If none is, the robot brakes as hard as it can.

    Fox's robot is a synchro drive, whose window is a rectangle; the wheels of this one make it
    a rhombus. What is driven before the braking begins, v dt, is taken off dist in (D3). Both
    conditions are the paper's, which compares a turn rate with a length as it stands.

    It knows no map: it has range readings all round, of `BEAMS` rays, its own pose, and the
    limits of its wheels, of which it remembers what it asked for. The defaults come from a small
    search in random worlds.

    Parameters
    ----------
    to_goal, to_clear, to_speed : float
        Weights of heading, dist and velocity: alpha, beta and gamma in the paper.
    interval : float
        Time (s) for which a velocity is followed to see its heading.
    reach : float
        Distance (m) from which on more is no better for dist. The scanner reaches as far, and
        at least as far as it takes to stop.
    margin : float
        Security distance between the body and an obstacle (m).
    speed : float
        Top speed (m/s).
    turn_rate : float
        Largest turn rate (rad/s).
    approach : float
        Largest speed over the distance from the goal (1/s).
    speeds, turns : int
        How many speeds and turn rates are compared.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for the weights and the margin,
        which may be zero; for under 2 speeds or 3 turns, or over
        `MOST_VALUES`.

    Notes
    -----
    Checked against the paper's abstract and what is quoted from it: the maximised (D1), with
    sigma for the smoothing, and (D3). The numbers of its equations could not be checked.
    """

    to_goal: float = 2.0
    to_clear: float = 3.0
    to_speed: float = 0.55
    interval: float = 0.6
    reach: float = 0.12
    margin: float = 0.002
    speed: float = SPEED
    turn_rate: float = 4.4
    approach: float = 1.0
    speeds: int = 6
    turns: int = 21

    def __post_init__(self):
        check_gains(self, "to_goal", "to_clear", "to_speed", "margin")
        for name, least in (("speeds", 2), ("turns", 3)):
            object.__setattr__(
                self, name, checks.whole(name, getattr(self, name), least, most=MOST_VALUES)
            )

    def start(self, scene: Any, goal: ArrayLike, robot: Robot, dt: float) -> Law:
        """The law for one drive, see `Reactive.start`."""
        goal, robot = check_drive(scene, goal, robot, dt)
        at = outlines_of(scene)
        # What is too far away to matter may still be too near to stop for.
        stops = self.speed * dt + self.speed**2 / (2 * robot.max_wheel_acceleration)
        sight = max(self.reach, robot.radius + self.margin + stops)

        def start_one():
            send = follow_limits(robot, dt)
            now = 0.0, 0.0

            def law(t, pose):
                nonlocal now
                bearing, distance = scan(at(t), pose, sight)
                met = np.isfinite(distance)
                bearing, distance = bearing[met] - pose[2], distance[met]
                points = distance * np.cos(bearing), distance * np.sin(bearing)
                ahead, left = _seen_from(pose, goal)
                v, omega = self.window(*now, robot, dt, np.hypot(ahead, left))
                turned = self._turned(omega, robot)
                dist = free_distances(v, omega, *points, robot.radius + self.margin, turned)
                allowed = self.admissible(v, omega, dist, robot, dt)
                allowed &= reachable(v, omega, *now, robot, dt)
                if not allowed.any():
                    now = send(0.0, 0.0)
                    return 0.0, 0.0
                worth = self.objective(v, omega, dist, ahead, left, robot)
                best = np.argmax(np.where(allowed, _smoothed(np.where(allowed, worth, 0)), -1))
                command = v.flat[best], omega.flat[best]
                now = send(*command)
                return command

            return law

        return for_each(start_one)

    def window(
        self, v: float, omega: float, robot: Robot, dt: float, distance: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Grid of velocities round the dynamic window (D4), within (D2).

        Parameters
        ----------
        v, omega : float
            Present speed (m/s) and turn rate (rad/s).
        robot : Robot
            Robot.
        dt : float
            Time step (s).
        distance : float
            From the goal (m).

        Returns
        -------
        v, omega : ndarray, shape (speeds, turns)
            Speeds (m/s) and turn rates (rad/s), of which some the wheels do not reach.
        """
        change = robot.max_wheel_acceleration * dt
        top = self._top(distance)
        slowest = max(v - change, 0.0)
        speeds = np.linspace(slowest, max(min(v + change, top), slowest), self.speeds)
        change *= 2 / robot.wheel_base
        lowest, highest = max(omega - change, -self.turn_rate), min(omega + change, self.turn_rate)
        turns = np.linspace(min(lowest, highest), max(lowest, highest), self.turns)
        # Straight on is among them if it is near: else the robot would weave.
        turns -= turns[np.argmin(np.abs(turns))] * (lowest <= 0 <= highest)
        return np.meshgrid(speeds, turns, indexing="ij")

    def admissible(
        self, v: np.ndarray, omega: np.ndarray, dist: np.ndarray, robot: Robot, dt: float
    ) -> np.ndarray:
        """Which velocities the robot stops in time from (D3), of their shape.

        Parameters
        ----------
        v, omega : ndarray
            Speeds (m/s) and turn rates (rad/s).
        dist : ndarray
            From `free_distances` (m).
        robot, dt
            As for `window`.
        """
        braking = robot.max_wheel_acceleration
        left = np.maximum(dist - v * dt, 0)
        turns_in_time = omega**2 <= 4 * left * braking / robot.wheel_base
        return (v**2 <= 2 * left * braking) & (turns_in_time | (v == 0))

    def objective(
        self,
        v: np.ndarray,
        omega: np.ndarray,
        dist: np.ndarray,
        ahead: float,
        left: float,
        robot: Robot,
    ) -> np.ndarray:
        """The objective (D1) before it is smoothed, of the shape of the velocities.

        Parameters
        ----------
        v, omega, dist, robot
            As for `admissible`.
        ahead, left : float
            The goal (m), as the robot sees it.
        """
        braking = robot.max_wheel_acceleration
        distance = np.hypot(ahead, left)
        # Beyond the goal it would seem to be behind.
        driven = np.minimum(v * self.interval + v**2 / (2 * braking), distance / 2)
        turned = self._turned(omega, robot)
        chord = driven * np.sinc(turned / (2 * np.pi))
        x, y = chord * np.cos(turned / 2), chord * np.sin(turned / 2)
        off = np.abs(wrap_angle(np.arctan2(left - y, ahead - x) - turned))
        far = max(min(self.reach, distance), TINY)
        return (
            self.to_goal * (1 - off / np.pi)
            + self.to_clear * np.minimum(dist / far, 1)
            + self.to_speed * v / max(self._top(distance), TINY)
        )

    def _top(self, distance):
        """Largest speed (m/s) at a distance from the goal (m)."""
        return min(self.speed, self.approach * distance)

    def _turned(self, omega, robot):
        """By how much (rad) the robot turns in the interval and while it brakes."""
        braking = 2 * robot.max_wheel_acceleration / robot.wheel_base
        return omega * (self.interval + np.abs(omega) / (2 * braking))


def _seen_from(pose: np.ndarray, point: np.ndarray) -> tuple[float, float]:
    """How far (m) a point is ahead of a robot, and to its left."""
    x, y = point - pose[:2]
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return cos * x + sin * y, cos * y - sin * x


def _smoothed(worth: np.ndarray) -> np.ndarray:
    """Means of neighbours in a grid, with the border repeated, of the same shape."""
    outer, middle, _ = SMOOTHED
    for _ in range(2):
        padded = np.pad(worth, ((1, 1), (0, 0)), mode="edge")
        worth = (outer * (padded[:-2] + padded[2:]) + middle * worth).T
    return worth


def reachable(
    v: np.ndarray,
    omega: np.ndarray,
    present_v: float,
    present_omega: float,
    robot: Robot,
    dt: float,
) -> np.ndarray:
    """Which velocities the wheels reach in a time step from the present one, of their shape.

    Parameters
    ----------
    v, omega : ndarray
        Speeds (m/s) and turn rates (rad/s).
    present_v, present_omega : float
        Those that the robot drives at.
    robot : Robot
        Robot.
    dt : float
        Time step (s).
    """
    half = robot.wheel_base / 2
    change = np.abs(v - present_v) + half * np.abs(omega - present_omega)
    fastest = np.abs(v) + half * np.abs(omega)
    # What is at a limit is within it, whatever round-off says.
    limit = 1 + 1e-9
    return (change <= limit * robot.max_wheel_acceleration * dt) & (
        fastest <= limit * robot.max_wheel_speed
    )


def free_distances(
    v: np.ndarray,
    omega: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    clearance: float,
    turned: np.ndarray | float = 0.0,
) -> np.ndarray:
    """How far the robot drives on an arc until it comes too close to a point.

    Parameters
    ----------
    v, omega : ndarray
        Forward speeds (m/s) and turn rates (rad/s), of one shape.
    x, y : ndarray, shape (k,)
        Points (m), ahead of the robot and to its left.
    clearance : float
        Distance from them to keep (m).
    turned : ndarray or float, optional
        By how much (rad) who turns on the spot has turned then.

    Returns
    -------
    ndarray
        Length of the arc (m), of the velocities' shape; infinite where no point is met. Where
        the robot turns on the spot or rests, it is that of driving straight on then.
        A point that is too close already is met at once if the robot drives towards it, and
        else not at all, so that it can leave.
    """
    shape, v, omega = v.shape, v.reshape(-1, 1), omega.reshape(-1, 1)
    straight = (np.abs(omega) < NO_TURNING) | (v == 0)
    turned = np.where(v == 0, np.broadcast_to(turned, shape).reshape(-1, 1), 0.0)
    cos, sin = np.cos(turned), np.sin(turned)
    x, y = cos * x + sin * y, cos * y - sin * x
    # Seen with the centre on the left, on which the robot begins at the angle zero.
    radius = v / np.where(straight, 1.0, np.abs(omega))
    side = y * np.where(omega < 0, -1.0, 1.0)
    inward = radius - side
    squared = x**2 + inward**2
    cosine = (radius**2 + squared - clearance**2) / np.maximum(2 * radius * np.sqrt(squared), TINY)
    angle = np.arctan2(x, inward) % (2 * np.pi)
    with np.errstate(invalid="ignore"):
        length = radius * ((angle - np.arccos(cosine)) % (2 * np.pi))
        straight_on = x - np.sqrt(clearance**2 - side**2)
    length = np.where(straight, np.where(x > 0, straight_on, np.inf), length)
    length = np.where(x**2 + y**2 < clearance**2, np.where(x > 0, 0.0, np.inf), length)
    # Not a number: the point stays out of the way.
    length = np.where(np.isnan(length), np.inf, length)
    return length.min(-1, initial=np.inf).reshape(shape)
