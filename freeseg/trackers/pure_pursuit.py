"""Pure pursuit: drive the arc that ends in a point ahead on the path."""

from dataclasses import dataclass

import numpy as np

from freeseg.reference import Reference, pose_error
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, forwards_only, watch


@dataclass(frozen=True)
class PurePursuit:
    """Gains of pure pursuit, made to keep to a timetable.

    The goal point lies a lookahead distance of path ahead of the reference.
    The arc that leaves along the robot's heading and ends there has the
    curvature 2 y / d^2, with y the goal's distance to the left and d that to
    the robot. The speed v is v_r plus k_x times the distance by which the
    robot lags along the path, and w is v times the curvature.

    Feedforward is the geometry alone: on lines and on arcs the robot keeps
    to the path, where they meet it cuts the corner. The defaults are an
    assumption.

    Parameters
    ----------
    lookahead : float
        Length of path (m) from the reference to the goal point; beyond its
        end, the path is taken to go on straight.
    k_x : float
        Gain of the distance along the path (1/s).
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for k_x, where
        zero switches a term off.

    Notes
    -----
    R. C. Coulter, "Implementation of the pure pursuit path tracking
    algorithm", CMU-RI-TR-92-01, 1992, where the goal point lies at the
    lookahead distance from the robot, whenever that gets there. Here the
    distance d varies with the lag. It is not taken to be less than half the
    lookahead, so that the curvature stays bounded. A robot that backs up does
    not turn, for backwards the arc leads away from the goal, and backs up no
    further than brings it nearer along the path.
    """

    lookahead: float = 0.06
    k_x: float = 2.0
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "k_x")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        see = watch(reference, dt, self.preview)
        forwards_only(self, reference, spot=False)
        arc_length = np.hypot(*np.diff(reference.pose[:2], axis=1)).cumsum()
        arc_length = np.concatenate([[0.0], arc_length])
        x, y, theta = reference.pose

        def goal_point(t):
            ahead = np.interp(t, reference.t, arc_length) + self.lookahead
            beyond = np.maximum(ahead - arc_length[-1], 0)
            return [
                np.interp(ahead, arc_length, x) + beyond * np.cos(theta[-1]),
                np.interp(ahead, arc_length, y) + beyond * np.sin(theta[-1]),
                np.zeros_like(ahead),
            ]

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, _, _, _) = see(t, pose)
            cos, sin = np.cos(alpha_e), np.sin(alpha_e)
            speed = v_r + self.k_x * (cos * x_e + sin * y_e)
            forward, left, _ = pose_error(goal_point(t), pose)
            distance = np.hypot(forward, left)
            # Behind the robot, as if beside it: that arc is the tightest.
            left = np.where(forward < 0, np.copysign(distance, left), left)
            distance = np.maximum(distance, self.lookahead / 2)
            curvature = 2 * left / (distance * distance)
            return np.where(speed > 0, speed, speed * cos), np.maximum(speed, 0) * curvature

        return law
