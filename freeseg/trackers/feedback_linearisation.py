"""Static input-output linearisation of a point ahead of the axle."""

from dataclasses import dataclass

import numpy as np

from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, watch


@dataclass(frozen=True)
class FeedbackLinearisation:
    """Gains of the static input-output linearisation.

    The point B at a distance b ahead of the axle can be driven in any
    direction: v moves it along the robot's axis, and b w across. Here B
    follows the same point of the reference, and its error decays as that of
    two integrators. That is regular at rest, unlike dynamic feedback
    linearisation. Once B is where it should be, the heading follows by
    dalpha_e/dt = w_r (1 - cos(alpha_e)) - (v_r / b) sin(alpha_e): its error
    vanishes while the reference drives forwards, and stays while it rests.

    The defaults are an assumption.

    Parameters
    ----------
    k1, k2 : float
        Gains of the error of B along and across the robot's axis (1/s).
    ahead : float
        Distance b of B ahead of the axle (m).
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for k1 and k2,
        where zero switches a term off.

    Notes
    -----
    The input-output linearisation (11.75) of B. Siciliano, L. Sciavicco,
    L. Villani, G. Oriolo, "Robotics: Modelling, Planning and Control", 2009.
    There k1 and k2 act along the world's axes, here along the robot's, so
    that the law does not depend on where north is. A robot on its path that
    looks backwards, alpha_e = pi, gets no turn, and stays so.
    """

    k1: float = 2.0
    k2: float = 2.0
    ahead: float = 0.06
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "k1", "k2")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        see = watch(reference, dt, self.preview)

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, omega_r, _, _) = see(t, pose)
            # Ahead in the direction driven: of a robot that reverses, behind it.
            b = np.copysign(self.ahead, v_r)
            cos, sin = np.cos(alpha_e), np.sin(alpha_e)
            along, across = x_e + b * cos - b, y_e + b * sin
            v = v_r * cos - b * omega_r * sin + self.k1 * along
            return v, (v_r * sin + b * omega_r * cos + self.k2 * across) / b

        return law
