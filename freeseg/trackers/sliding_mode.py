"""The paper's saturated sliding-mode controller (section 4)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, watch

#: What stands for the switching function in the reaching law (11).
SWITCHING = {"sat": lambda s: np.clip(s, -1, 1), "sign": np.sign, "tanh": np.tanh}


@dataclass(frozen=True)
class SlidingMode:
    """Gains of the sliding-mode law, equations (7) to (13).

    The paper publishes none of them: every default is an assumption. With
    these, disturbed robots hardly ever touch an obstacle (notebook 09). But
    they do not bring a robot back from everywhere. At steps of 50 ms, beside
    a reference that drives straight on at 0.1 m/s, all of 4000 random starts
    within 0.35 m came back, whatever their heading; within 0.5 m along and
    across, some 3 % never did, all of them ahead of the reference. With
    k2 = 1 rad/s, all came back.

    Parameters
    ----------
    k1 : float
        Reaching rate of s1 = x_e (m/s).
    k2 : float
        Reaching rate of s2 = alpha_e + gamma (rad/s).
    phi1 : float
        Half width of the boundary layer of s1 (m).
    phi2 : float
        Half width of the boundary layer of s2 (rad).
    length_scale : float
        Length l (m) in gamma = arctan(v_r y_e / (v_0 l)), v_0 the top speed
        of the reference. The paper's arctan(v_r y_e) hides it in its units.
    switching : {"sat", "sign", "tanh"}
        Switching function; the paper's is ``"sat"``. With ``"sign"``, k1 and
        k2 are best little above what disturbs s1 and s2, for a held command
        overshoots by as much as they move s in a time step: such as 0.01 m/s
        and 0.1 rad/s, where the defaults lose the path.
    floor : float
        Least value of the denominator 1 + x_e dgamma/dy_e of w, which
        vanishes where the law is singular.
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for k1 and k2,
        where zero switches a term off; for another switching.
    """

    k1: float = 0.4
    k2: float = 2.0
    phi1: float = 0.1
    phi2: float = 0.5
    length_scale: float = 0.045
    switching: str = "sat"
    floor: float = 0.25
    preview: float = 0.0

    def __post_init__(self):
        checks.choice("switching", self.switching, SWITCHING)
        check_gains(self, "k1", "k2")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        switch = SWITCHING[self.switching]

        def approach(s1, s2):
            return self.k1 * switch(s1 / self.phi1), self.k2 * switch(s2 / self.phi2)

        return sliding_law(reference, dt, self.length_scale, self.floor, approach, self.preview)


def sliding_law(
    reference: Reference,
    dt: float,
    length_scale: float,
    floor: float,
    approach: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
    preview: float = 0.0,
) -> Law:
    """Law under which s1 and s2 of (10) fall as fast as asked, equation (12).

    Parameters
    ----------
    reference : Reference
        What to follow.
    dt : float
        Time for which each command is held (s).
    length_scale, floor : float
        See `SlidingMode`.
    approach : callable
        ``approach(s1, s2) -> (-ds1/dt, -ds2/dt)`` (m/s, rad/s), the reaching law.
    preview : float, optional
        See `SlidingMode`.

    Returns
    -------
    Law
        ``law(t, pose) -> (v, omega)``, for a pose of shape (3,) or (3, n).

    Raises
    ------
    InvalidParameter
        For a reference that never moves from its place.
    """
    see = watch(reference, dt, preview)
    top_speed = np.abs(reference.v).max()
    scale = top_speed * length_scale
    if not np.all(scale > 0):
        raise InvalidParameter(
            f"the reference's top speed is {top_speed:g} m/s, and gamma is relative to it; give a "
            "reference that moves"
        )

    def law(t, pose):
        (x_e, y_e, alpha_e), (_, v_r, omega_r, v_r_dot, _) = see(t, pose)
        aside = v_r * y_e / scale
        # Not ** 2, which for one robot can differ in the last bit from that for a batch.
        slope = 1 / (1 + aside * aside) / scale
        dgamma_dv, dgamma_dy = slope * y_e, slope * v_r
        fall1, fall2 = approach(x_e, alpha_e + np.arctan(aside))
        omega = (
            omega_r + dgamma_dv * v_r_dot + dgamma_dy * v_r * np.sin(alpha_e) + fall2
        ) / np.maximum(1 + dgamma_dy * x_e, floor)
        v = y_e * omega + v_r * np.cos(alpha_e) + fall1
        return v, omega

    return law
