"""Linear-quadratic regulator of the linearised error, scheduled on the speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import REST, Law, check_gains, watch


@dataclass(frozen=True)
class Lqr:
    """Weights of a discrete linear-quadratic regulator.

    Near the reference, and with w_r left out, the errors obey
    dx_e/dt = -u_1, dy_e/dt = v_r alpha_e and dalpha_e/dt = -u_2, with
    v = v_r cos(alpha_e) + u_1 and w = w_r + u_2. Held for dt, the u = K(v_r) e
    that this law computes minimises the sum of
    q_x x_e^2 + q_y y_e^2 + q_alpha alpha_e^2 + u_1^2 + u_2^2 over all steps.

    The defaults are an assumption. For small dt, K tends to
    k_x = sqrt(q_x), k_y = sqrt(q_y), k_alpha = sqrt(q_alpha + 2 v_r k_y).

    Parameters
    ----------
    q_x : float
        Weight of x_e, relative to that of u_1 (1/s^2).
    q_y : float
        Weight of y_e, relative to that of u_2 (1/(m s)^2).
    q_alpha : float
        Weight of alpha_e, relative to that of u_2 (1/s^2).
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a weight that is negative, not finite or zero, but for q_x and
        q_y, where zero switches a term off; for a time step of a run that is
        not positive.

    Notes
    -----
    At rest no turn moves the robot sideways, and the Riccati equation has no
    stabilising solution. But its gains have a limit as v_r falls to zero,
    and that is K(0): the robot comes to rest turned a little towards the path.

    The regulator is that of B. Anderson, J. Moore, "Optimal Control: Linear
    Quadratic Methods", 1990; the linearised error that of
    G. Klancar, D. Matko, S. Blazic, "Mobile robot control on a reference
    path", 13th Mediterranean Conference on Control and Automation, 2005.
    """

    q_x: float = 4.0
    q_y: float = 100.0
    q_alpha: float = 2.0
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "q_x", "q_y")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        dt = checks.positive("dt", dt)
        see = watch(reference, dt, self.preview)
        # Gains that overflow do so at the ends of the speeds, and are named here.
        for speed in (0.0, np.abs(reference.v).max()):
            self.gains(speed, dt)

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, omega_r, _, _) = see(t, pose)
            # Backwards, y_e asks for the other sense of turn, and alpha_e for the same.
            k_x, k_y, k_alpha = self._gains(np.abs(v_r), dt)
            turn = np.copysign(k_y, v_r) * y_e + k_alpha * alpha_e
            return v_r * np.cos(alpha_e) + k_x * x_e, omega_r + turn

        return law

    def gains(self, v_r: ArrayLike, dt: float) -> tuple[float, np.ndarray, np.ndarray]:
        """Solution of the discrete Riccati equation at speeds.

        Parameters
        ----------
        v_r : array_like, shape (...)
            Speeds (m/s), not negative.
        dt : float
            Time for which each command is held (s).

        Returns
        -------
        k_x : float
            Gain of x_e (1/s).
        k_y, k_alpha : ndarray, shape (...)
            Gains of y_e (1/(m s)) and alpha_e (1/s).

        Raises
        ------
        InvalidParameter
            For what are no speeds, a time step that is not positive, and numbers so
            large that the gains overflow.

        Notes
        -----
        In closed form. With m = z + 1/z - 2, the closed loop's eigenvalues z
        inside the unit circle, and their inverses, are the roots of
        m = q_x dt^2 ahead and of m^2 - (a - b / 4) m + b = 0 sideways,
        a = q_alpha dt^2 and b = q_y v_r^2 dt^4; the gains place them.
        """
        v_r = checks.signal("v_r", v_r, "speeds (m/s)")
        dt = checks.positive("dt", dt)
        with np.errstate(over="ignore", invalid="ignore"):
            k_x, k_y, k_alpha = self._gains(v_r, dt)
        if not all(np.isfinite(gains).all() for gains in (k_x, k_y, k_alpha)):
            raise InvalidParameter(
                f"v_r is {checks.shown(v_r)} and dt {dt:g} s, for which the gains of {self} "
                "overflow; give smaller weights, speeds or time steps"
            )
        return k_x, k_y, k_alpha

    def _gains(self, v_r, dt):
        """`gains` without its checks."""
        # At rest the gains have a limit but no formula.
        step = np.maximum(v_r, REST) * dt * dt
        a, b = self.q_alpha * dt * dt, self.q_y * step * step
        half = (a - b / 4) / 2
        root = np.sqrt(half * half - b + 0j)
        m = half + np.where(half < 0, -root, root)
        # 1 - z; the smaller m from the product of both, for their difference cancels.
        first, other = _one_minus_z(m), _one_minus_z(b / m)
        product = (first * other).real
        k_x = _one_minus_z(self.q_x * dt * dt) / dt
        return k_x, product / step, ((first + other).real - product / 2) / dt


def _one_minus_z(m):
    """1 - z for the z inside the unit circle with z + 1/z - 2 = m."""
    return -np.expm1(-2 * np.arcsinh(np.sqrt(m) / 2))
