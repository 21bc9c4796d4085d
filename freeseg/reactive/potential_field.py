"""Potential field: roll down a hill that the obstacles raise and the goal lowers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import TINY, wrap_angle
from freeseg.reactive.sensing import check_drive, nearest_points, outlines_of, steer
from freeseg.reference import SPEED
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains

#: Distance (m) below which the hill of an obstacle rises no further: the robot touches it.
CONTACT = 1e-4

#: Point of a run, or of a map, to its potential or its force.
Field = Callable[[ArrayLike], np.ndarray]


@dataclass(frozen=True)
class PotentialField:
    """Gains of a potential field (O. Khatib, *IJRR* 5(1), 1986).

    With the distance d of the robot's centre from the goal, and rho of its body from an
    obstacle, the potential is the sum of (these numbers are ours)

        (P1)  U_att = attraction d^2 / 2
        (P2)  U_rep = repulsion (1 / rho - 1 / influence)^2 d^order / 2,

    of (P2) one for every obstacle nearer than the influence. An order of zero is Khatib's
    field: its slope need not vanish at a goal near an obstacle, which then is not reached. Any
    other is the correction of S. Ge and Y. Cui (*IEEE Transactions on Robotics and Automation*
    16(5), 2000), whose lowest point is the goal. The force is minus the gradient,

        (P3)  F_att = attraction d n
        (P4)  F_rep = repulsion (1 / rho - 1 / influence) d^order / rho^2 m
                      + order / 2 repulsion (1 / rho - 1 / influence)^2 d^(order - 1) n,

    with the unit vectors n to the goal and m away from the obstacle's nearest point. As
    Khatib's has, the motion has a top speed: the robot is to move with the velocity F, or as
    fast as the top speed in its direction. Khatib's robot can move any way; this one turns
    towards it and slows down by the cosine of what is left to turn.

    It knows the map: the nearest point of every obstacle, however far away. The defaults
    come from a small search in random worlds.

    Parameters
    ----------
    attraction : float
        Of the goal (1/s).
    repulsion : float
        Of the obstacles (m^(4 - order)/s).
    influence : float
        Distance (m) from the body beyond which an obstacle has no effect.
    order : float
        Power of d in (P2): zero, or at least one.
    speed : float
        Top speed (m/s).
    steering : float
        Turn rate over the angle left to turn (1/s).
    turn_rate : float
        Largest turn rate (rad/s).

    Raises
    ------
    InvalidParameter
        For a gain that is not finite or negative, or zero but for the order and the repulsion.

    Notes
    -----
    Of Ge and Cui's paper we had the abstract and the first page, which give the problem and the
    remedy: a repulsion that takes the distance from the goal into account, so that the goal is
    the lowest point. (P2) is the form that is quoted from it everywhere, and a test has (P4) as
    its gradient; the numbers of the paper's equations could not be checked.

    Examples
    --------
    >>> import freeseg as fs
    >>> field = fs.PotentialField()
    >>> force = field.force(fs.World([]), goal=(1, 0))
    >>> force((0.5, 0)).round(3).tolist()
    [0.5, 0.0]
    """

    attraction: float = 1.0
    repulsion: float = 0.0002
    influence: float = 0.13
    order: float = 2.0
    speed: float = SPEED
    steering: float = 2.0
    turn_rate: float = 1.5

    def __post_init__(self):
        check_gains(self, "repulsion", "order")
        if 0 < self.order < 1:
            raise InvalidParameter(
                f"order is {checks.shown(self.order)}, and the force has no bound at the goal; "
                "give zero, or at least one"
            )

    def start(self, scene: Any, goal: ArrayLike, robot: Robot, dt: float) -> Law:
        """The law for one drive, of one robot or of many, see `Reactive.start`."""
        goal, robot = check_drive(scene, goal, robot, dt)
        at = outlines_of(scene)

        def law(t, pose):
            points = pose[:2].T.reshape(-1, 2)
            force = self._force(at(t), goal, robot, points).reshape(pose[:2].T.shape).T
            strength = np.hypot(force[0], force[1])
            error = wrap_angle(np.arctan2(force[1], force[0]) - pose[2])
            return steer(error, np.minimum(strength, self.speed), self.steering, self.turn_rate)

        return law

    def potential(
        self, scene: Any, goal: ArrayLike, robot: Robot | None = None, t: float = 0.0
    ) -> Field:
        """The potential as a function of points, for drawing and for tests.

        Parameters
        ----------
        scene, goal, robot
            As for `start`.
        t : float, optional
            Time (s).

        Returns
        -------
        callable
            ``potential(points)``, for points of shape (..., 2) (m), of shape (...) (m^2/s).

        Raises
        ------
        InvalidQuery, InvalidParameter
            As for `start`.
        """
        return self._field(self._potential, scene, goal, robot, t)

    def force(
        self, scene: Any, goal: ArrayLike, robot: Robot | None = None, t: float = 0.0
    ) -> Field:
        """The force, minus the potential's gradient (m/s), as a function of points.

        As `potential`, but for its values: they have the shape (..., 2).
        """
        return self._field(self._force, scene, goal, robot, t)

    def _field(self, values, scene, goal, robot, t):
        """A function of points from one of outlines, goal, robot and points (n, 2)."""
        goal, robot = check_drive(scene, goal, robot, 1.0)
        outlines = outlines_of(scene)(float(checks.times("t", t)))

        def field(points):
            points = checks.real("points", points, "points (m), (..., 2)")
            found = values(outlines, goal, robot, points.reshape(-1, 2))
            return found.reshape(points.shape[:-1] + found.shape[1:])

        return field

    def _hills(self, outlines, robot, points):
        """1 / rho - 1 / influence, zero where that is far; 1 / rho; and m of (P4)."""
        rho, away = nearest_points(outlines, points)
        near = 1 / np.maximum(rho - robot.radius, CONTACT)
        return np.maximum(near - 1 / self.influence, 0), near, away

    def _potential(self, outlines, goal, robot, points):
        """(P1) and (P2), shape (n,)."""
        distance = np.hypot(*(goal - points).T)
        steep, _, _ = self._hills(outlines, robot, points)
        hills = self.repulsion * (steep**2).sum(-1) * distance**self.order
        return 0.5 * (self.attraction * distance**2 + hills)

    def _force(self, outlines, goal, robot, points):
        """(P3) and (P4), shape (n, 2)."""
        to_goal = goal - points
        distance = np.hypot(*to_goal.T)[:, None]
        steep, near, away = self._hills(outlines, robot, points)
        force = self.attraction * to_goal
        uphill = self.repulsion * steep * near**2 * distance**self.order
        force += (uphill[..., None] * away).sum(-2)
        if self.order:
            slope = (steep**2).sum(-1, keepdims=True) * distance ** (self.order - 1)
            direction = to_goal / np.maximum(distance, TINY)
            force += 0.5 * self.order * self.repulsion * slope * direction
        return force
