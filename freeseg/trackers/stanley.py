"""The steering law of the robot Stanley, for a robot without a steered wheel."""

from dataclasses import dataclass

import numpy as np

from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, forwards_only, watch


@dataclass(frozen=True)
class Stanley:
    """Gains of the Stanley law, adapted to a differential drive.

    Stanley steers its front wheel along the path, and turns it towards the
    path by arctan(k e / (k_soft + v)), e the distance of that wheel from the
    path. A differential drive has no such wheel, but moves as if it had one
    at any distance b ahead of its axle: driven at the speed u in the
    direction delta, it makes v = u cos(delta) and w = u sin(delta) / b.
    Here that wheel follows the same wheel of the reference.

    Its speed keeps the timetable: that of the reference's wheel plus k_x
    times the distance by which it lags. The defaults are an assumption.

    Parameters
    ----------
    k : float
        Gain of the distance from the path (1/s).
    k_x : float
        Gain of the distance along the path (1/s).
    softening : float
        Speed k_soft (m/s) that keeps the steering calm at rest.
    ahead : float
        Distance b of the wheel ahead of the axle (m).
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for k and k_x,
        where zero switches a term off.

    Notes
    -----
    G. Hoffmann, C. Tomlin, M. Montemerlo, S. Thrun, "Autonomous automobile
    trajectory tracking for off-road driving", American Control Conference
    2007: the kinematic steering law with its softening constant; what is
    there for tyres and for the servo's lag has no counterpart here. A robot
    that backs up does not turn, for backwards the law steers away from the
    path, and backs up no further than brings it nearer along the path. One
    that looks backwards, alpha_e = pi, on its path does not turn either.
    """

    k: float = 2.0
    k_x: float = 2.0
    softening: float = 0.02
    ahead: float = 0.06
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "k", "k_x")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        see = watch(reference, dt, self.preview)
        forwards_only(self, reference)
        b = self.ahead

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, omega_r, _, _) = see(t, pose)
            # The reference's wheel from that of the robot, in the robot's frame.
            x, y = x_e + b * np.cos(alpha_e) - b, y_e + b * np.sin(alpha_e)
            wanted = np.hypot(v_r, b * omega_r)
            psi = alpha_e + np.arctan2(b * omega_r, v_r)
            cos, sin = np.cos(psi), np.sin(psi)
            along, aside = cos * x + sin * y, cos * y - sin * x
            speed = wanted + self.k_x * along
            towards = np.arctan(self.k * aside / (self.softening + wanted))
            delta = psi + np.where(speed > 0, towards, 0)
            return speed * np.cos(delta), np.maximum(speed, 0) * np.sin(delta) / b

        return law
