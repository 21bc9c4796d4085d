"""Super-twisting control on the paper's sliding surfaces."""

from dataclasses import dataclass

import numpy as np

from freeseg import checks
from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, follow_limits, winds_up
from freeseg.trackers.sliding_mode import sliding_law


@dataclass(frozen=True)
class SuperTwisting:
    """Gains of a second-order sliding mode on s1 and s2 of equation (10).

    In place of the reaching law (11),
    ds/dt = -lambda |s|^(1/2) sign(s) - z with dz/dt = w sign(s): the command
    is continuous without a boundary layer, and z learns a constant
    disturbance. The defaults are an assumption.

    Parameters
    ----------
    lambda1, lambda2 : float
        Gains of |s1|^(1/2) (m^(1/2)/s) and |s2|^(1/2) (rad^(1/2)/s).
    w1, w2 : float
        Rates of the integrals (m/s^2, rad/s^2).
    length_scale, floor, preview : float
        See `SlidingMode`.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for lambda1,
        lambda2, w1 and w2, where zero switches a term off; for a time step of
        a run that is not positive.

    Notes
    -----
    The super-twisting algorithm of A. Levant, "Sliding order and sliding
    accuracy in sliding mode control", International Journal of Control 58,
    1993. Its time steps are those of the implicit Euler method, after
    B. Brogliato, A. Polyakov, D. Efimov, "The implicit discretization of the
    super-twisting sliding-mode control algorithm", IEEE Transactions on
    Automatic Control 65, 2020: held commands then bring no chattering. But s
    after a step is reckoned as if z cancelled the disturbance already, so
    that a constant one leaves no error.
    """

    lambda1: float = 0.3
    lambda2: float = 2.0
    w1: float = 0.01
    w2: float = 0.1
    length_scale: float = 0.08
    floor: float = 0.25
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "lambda1", "lambda2", "w1", "w2")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`.

        The robot's limits stop the integrals. They are reckoned without delay and lag.

        Raises
        ------
        InvalidParameter
            For a time step that is not positive.
        """
        dt = checks.positive("dt", dt)
        first = _SuperTwist(self.lambda1, self.w1, dt)
        second = _SuperTwist(self.lambda2, self.w2, dt)
        unlimited = sliding_law(
            reference,
            dt,
            self.length_scale,
            self.floor,
            lambda s1, s2: (first.approach(s1), second.approach(s2)),
            self.preview,
        )
        send = follow_limits(robot, dt)

        def law(t, pose):
            v, omega = unlimited(t, pose)
            v_sent, omega_sent = send(v, omega)
            first.hold(v - v_sent)
            second.hold(omega - omega_sent)
            return v, omega

        return law


class _SuperTwist:
    """The algorithm for one surface, with its integral z."""

    def __init__(self, gain, rate, dt):
        self.gain, self.rate, self.dt = gain, rate, dt
        self.z = self.before = 0.0

    def approach(self, s):
        """How fast s is to fall; z grows."""
        gain, rate, dt = self.gain, self.rate, self.dt
        # s', the s after the step, solves s' = s - dt (gain |s'|^(1/2) sign(s') + push) with
        # push = dt rate sign(s'), where sign(0) is what in [-1, 1] makes s' zero.
        push = np.clip(s / dt, -rate * dt, rate * dt)
        left = np.maximum(np.abs(s) - rate * dt * dt, 0)
        root = (np.sqrt(gain * gain * dt * dt + 4 * left) - gain * dt) / 2
        self.before, self.z = self.z, self.z + push
        return gain * root * np.sign(s) + push + self.z

    def hold(self, excess):
        """Take the last step of z back where a limit kept the command from following it."""
        self.z = np.where(winds_up(self.z - self.before, excess), self.before, self.z)
