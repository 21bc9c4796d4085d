"""The tracking law of Kanayama et al., proved stable by a Lyapunov function."""

from dataclasses import dataclass

import numpy as np

from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, watch


@dataclass(frozen=True)
class Kanayama:
    """Gains of the law of Kanayama, Kimura, Miyazaki and Noguchi.

    v = v_r cos(alpha_e) + k_x x_e and
    w = w_r + v_r k_y y_e + |v_r| k_alpha sin(alpha_e); theirs, for a robot
    that drives forwards, has v_r for |v_r|. A robot that looks backwards,
    alpha_e = pi, and is on its path gets no turn, and stays so.

    The defaults are an assumption: sideways, the error is critically damped,
    k_alpha = 2 sqrt(k_y), and falls by 1/e in 1 / (v_r sqrt(k_y)) = 1 s at
    0.1 m/s.

    Parameters
    ----------
    k_x : float
        Gain of x_e (1/s).
    k_y : float
        Gain of y_e (1/m^2).
    k_alpha : float
        Gain of sin(alpha_e) (1/m).
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative or not finite. Zero switches a term off.

    Notes
    -----
    The control rule of Y. Kanayama, Y. Kimura, F. Miyazaki, T. Noguchi, "A
    stable tracking control method for an autonomous mobile robot", IEEE
    International Conference on Robotics and Automation, 1990.
    """

    k_x: float = 2.0
    k_y: float = 100.0
    k_alpha: float = 20.0
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "k_x", "k_y", "k_alpha")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        see = watch(reference, dt, self.preview)

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, omega_r, _, _) = see(t, pose)
            v = v_r * np.cos(alpha_e) + self.k_x * x_e
            # Backwards, y_e asks for the other sense of turn, and alpha_e for the same.
            damping = np.copysign(self.k_alpha, v_r) * np.sin(alpha_e)
            return v, omega_r + v_r * (self.k_y * y_e + damping)

        return law
