"""PID control along and across the path: the classical baseline."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, follow_limits, watch, winds_up


@dataclass(frozen=True)
class Pid:
    """Gains of two loops: PI for x_e by the speed, PID for y_e by the turn rate.

    Near the reference, the speed acts on x_e through 1/s, where a derivative
    would only scale the gain, and the turn rate on y_e through v_r/s^2. The
    lateral gains are per metre driven, not per time: over time, P grows with
    v_r and I with v_r^2, so that the loop keeps its shape at every speed.
    Without the integrals, and where `approach` bounds nothing, this is the law
    of `Kanayama`.

    The paper names PID [17] and designs none: the defaults are those that
    notebook 10 computes for 0.1 m/s, lag and delay, rounded.

    Parameters
    ----------
    kp_x : float
        Speed for x_e (1/s).
    ki_x : float
        Speed for the integral of x_e over time (1/s^2).
    kp_y : float
        Curvature for y_e (1/m^2).
    ki_y : float
        Curvature for the integral of y_e over the arc length (1/m^3).
    kd_y : float
        Curvature for sin(alpha_e), the rate of y_e over the arc length (1/m).
    approach : float
        Steepest angle at which the robot is sent towards the path (rad),
        below pi / 2: it bounds the sum of P and I of y_e.
    anti_windup : bool
        Whether an integral stops where it would only push further against a
        limit, of the wheels or of `approach`.
    gate : float, optional
        Largest error that an integral takes in (m): what is further off is on
        its way to the path, and would be paid for by an overshoot. By
        default any is taken in.
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for kp_x, ki_x,
        kp_y and ki_y, where zero switches a term off; for an angle that is
        not below pi / 2, an `anti_windup` that is no bool, or a gate that is
        negative or not finite.

    Notes
    -----
    The derivative of y_e is v_r sin(alpha_e), read off the measured heading:
    the difference of two noisy positions over a time step would multiply
    their noise. A robot that looks backwards, alpha_e = pi, gets none.
    """

    kp_x: float = 3.0
    ki_x: float = 0.9
    kp_y: float = 340.0
    ki_y: float = 760.0
    kd_y: float = 29.0
    approach: float = np.pi / 3
    anti_windup: bool = True
    gate: float | None = None
    preview: float = 0.0

    def __post_init__(self):
        object.__setattr__(self, "anti_windup", checks.flag("anti_windup", self.anti_windup))
        check_gains(self, "kp_x", "ki_x", "kp_y", "ki_y")
        if self.gate is not None:
            object.__setattr__(self, "gate", checks.not_negative("gate", self.gate))
        if self.approach >= np.pi / 2:
            raise InvalidParameter(f"approach is {self.approach!r} rad; give less than pi / 2")

    def command(
        self,
        error: np.ndarray,
        integrals: Sequence[float | np.ndarray],
        v_r: float | np.ndarray,
        omega_r: float | np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Body velocity for an error, and what `approach` cuts off.

        Parameters
        ----------
        error : ndarray, shape (3, ...)
            x_e, y_e (m) and alpha_e (rad).
        integrals : sequence of 2 float or ndarray, shape (...)
            Of x_e over time (m s), and of y_e over the arc length (m^2).
        v_r, omega_r : float or ndarray, shape (...)
            Speed (m/s) and turn rate (rad/s) of the reference.

        Returns
        -------
        v, omega, cut : ndarray, shape (...)
            Forward speed (m/s), turn rate (rad/s), and what the turn rate
            would be more without the bound that `approach` sets (rad/s).
        """
        x_e, y_e, alpha_e = error
        along, across = integrals
        bend = self.kp_y * y_e + self.ki_y * across
        # D is at most kd_y: were P + I larger, the robot would never stop turning.
        most = self.kd_y * np.sin(self.approach)
        bounded = np.minimum(np.maximum(bend, -most), most)
        v = v_r * np.cos(alpha_e) + self.kp_x * x_e + self.ki_x * along
        # P changes its sign with v_r, D does not: that damps a reference that reverses, too.
        omega = omega_r + v_r * bounded + np.abs(v_r) * self.kd_y * np.sin(alpha_e)
        return v, omega, v_r * (bend - bounded)

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`.

        The robot's limits stop the integrals; with a `dt` of zero, they stay zero.
        """
        see, send = watch(reference, dt, self.preview), follow_limits(robot, dt)
        integrals = 0.0, 0.0

        def law(t, pose):
            nonlocal integrals
            error, (_, v_r, omega_r, _, _) = see(t, pose)
            v, omega, cut = self.command(error, integrals, v_r, omega_r)
            steps = dt * error[0], dt * np.abs(v_r) * error[1]
            if self.anti_windup:
                v_sent, omega_sent = send(v, omega)
                excess = v - v_sent, v_r * (omega + cut - omega_sent)
                steps = [
                    np.where(winds_up(step, beyond), 0.0, step)
                    for step, beyond in zip(steps, excess, strict=True)
                ]
            if self.gate is not None:
                steps = [
                    np.where(np.abs(off) > self.gate, 0.0, step)
                    for step, off in zip(steps, error, strict=False)
                ]
            integrals = [total + step for total, step in zip(integrals, steps, strict=True)]
            return v, omega

        return law
