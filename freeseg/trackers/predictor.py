"""Prediction over delay and lag: a law sees the robot where its next command will find it."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from freeseg import checks
from freeseg.disturbance import Disturbance, Motors
from freeseg.errors import InvalidParameter
from freeseg.geometry import wrap_angle
from freeseg.reference import Reference, pose_error
from freeseg.robot import Robot, as_robot, body_velocity, moved_pose, wheel_speeds
from freeseg.trackers.feedback import Law, Tracker, check_tracker

#: At that speed of a wheel (m/s), its slip is learned half as fast as at high speeds.
CREEP = 0.02

#: Shares of its travel between which a wheel is believed to move the robot.
ROLLED = 0.5, 1.5


@dataclass(frozen=True)
class Predicting:
    """A tracker that is told of the delay and the lag of its robot.

    Commands take a while to act: the delay, until they arrive, and the lag,
    with which the motors follow them. This wrapper remembers what is still
    under way, and gives the law the pose that the robot will have by then
    and the time at which it will have it.

    Parameters
    ----------
    tracker : Tracker
        Whose law to start. `Mpc` predicts by itself: give it delay and lag.
    delay : float
        Time after which a command reaches the motors (s): a whole number of
        time steps.
    lag : float
        Time constant of the motors, first order (s).
    observer : float
        Rate (1/s) at which estimates of the pose and of the wheels' slip follow
        what is measured, see `SlipObserver`: the law is given the estimated
        pose, and its commands are made larger by what the wheels lose. With
        zero, poses are taken as measured, and the wheels not to slip.

    Raises
    ------
    InvalidParameter
        For what is no tracker, or a delay, a lag or a rate that is negative or
        not finite; from `start`, for a delay that is not a whole number of time
        steps, or delay and lag that are longer than the reference together.

    Notes
    -----
    A predictor after O. J. M. Smith, "Closer control of loops with dead
    time", Chemical Engineering Progress 53, 1957, in the form of a state
    prediction, which starts anew from every measured pose: no error of the
    model adds up over more than delay and lag.

    Over the delay, the motion is that of `simulate` without slip, noise
    and wrong sizes. To what comes after it, a lag is as good as one delay
    more: speeds that approach a new value with the time constant T go as far
    as if they kept the old value for T and jumped then.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), (0, 0), (0.75, 0.75))
    >>> reference = fs.make_reference(plan, smoothing=0.03)
    >>> late = fs.Disturbance(delay=0.1, lag=0.03)
    >>> for tracker in (fs.Pid(), Predicting(fs.Pid(), late.delay, late.lag)):
    ...     run = fs.simulate(tracker, reference, disturbance=late)
    ...     print(f"{1000 * fs.metrics.tracking(run)['position_rms_m']:.1f} mm")
    2.9 mm
    0.2 mm
    """

    tracker: Tracker
    delay: float
    lag: float = 0.0

    observer: float = 0.0

    def __post_init__(self):
        check_tracker(self.tracker)
        for name in ("delay", "lag", "observer"):
            object.__setattr__(self, name, checks.not_negative(name, getattr(self, name)))

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`.

        It takes the poses that the tracker's law takes, and is to be called once
        for each time step, in their order.
        """
        predictor = Predictor(self.delay, self.lag, reference, robot, dt)
        robot = predictor.robot
        observer = SlipObserver(self.observer, robot, dt)
        follow, command = self.tracker.start(reference, robot, dt), None

        def law(t, pose):
            nonlocal command
            # Only now, when whoever asked has checked it; a batch may have got one for all.
            if command is not None:
                v, omega, _ = np.broadcast_arrays(*command, pose[0])
                predictor.send(v, omega)
            now = observer.correct(pose, predictor.driven)
            command = follow(t + predictor.ahead, predictor.look(now, observer.rolled))
            if observer.on:
                v, omega, _ = np.broadcast_arrays(*command, pose[0])
                wheels = wheel_speeds(robot, v, omega) / observer.rolled
                command = body_velocity(robot, wheels)
            return command

        return law


class Predictor:
    """Where the commands under way take a robot.

    Parameters
    ----------
    delay, lag : float
        See `Predicting`.
    reference : Reference
        What is followed.
    robot : Robot
        Robot; a Khepera IV for None.
    dt : float
        Time step (s).

    Attributes
    ----------
    ahead : float
        How far it looks ahead: delay and lag (s).
    driven : ndarray, shape (2, ...)
        Wheel speeds (m/s) in the step before the present one, on average.
    """

    def __init__(
        self, delay: float, lag: float, reference: Reference, robot: Robot | None, dt: float
    ):
        checks.instance("reference", reference, Reference, "one made by make_reference")
        self.robot, self.dt, self.lag = as_robot(robot), checks.positive("dt", dt), lag
        self.ahead = delay + lag
        if self.ahead > reference.duration:
            raise InvalidParameter(
                f"delay is {delay:g} s and lag {lag:g} s, and the reference lasts "
                f"{reference.duration:.3f} s; give less"
            )
        steps = Disturbance(delay=delay).delayed_steps(dt)
        # What the motors will do with a command is known when it is given.
        self.motors = Motors(self.robot, Disturbance(lag=lag), dt, 0)
        self.driven = self.motors.speed
        self.underway = deque([self.driven] * steps)

    def send(self, v: np.ndarray, omega: np.ndarray) -> None:
        """Take note of a command, and that a time step has passed.

        Parameters
        ----------
        v, omega : array_like, shape (...)
            Forward speed (m/s) and turn rate (rad/s).
        """
        command = wheel_speeds(self.robot, v, omega)
        if command.ndim != self.motors.asked.ndim:
            # The robots of a batch have rested so far.
            self.motors.asked = self.motors.speed = np.zeros_like(command)
        self.underway.append(self.motors.follow(command)[1])
        self.driven = self.underway.popleft()

    def look(self, pose: np.ndarray, rolled: float | np.ndarray = 1.0) -> np.ndarray:
        """The pose after delay and lag.

        Parameters
        ----------
        pose : ndarray, shape (3, ...)
            x, y (m) and heading (rad) now.
        rolled : float or ndarray, shape (2, ...)
            Share of the wheels' travel that moves the robot.

        Returns
        -------
        ndarray, shape (3, ...)
        """
        for wheels in self.underway:
            pose = moved_pose(self.robot, pose, _each(wheels, pose) * rolled, self.dt)
        if not self.lag:
            return pose
        wheels = _each(self.motors.speed, pose)
        return moved_pose(self.robot, pose, wheels * rolled, self.lag)


class SlipObserver:
    """Estimate of a robot's pose and of what its wheels lose by slip.

    Parameters
    ----------
    rate : float
        How fast a wrong estimate is forgotten (1/s). With zero, poses are
        taken as measured, and the wheels not to slip.
    robot : Robot
        Robot.
    dt : float
        Time step (s).

    Attributes
    ----------
    on : bool
        Whether it estimates at all.
    rolled : ndarray, shape (2, ...)
        Share of the right and the left wheel's travel that moves the robot.

    Notes
    -----
    A Luenberger observer, with both of its poles at exp(-rate
    dt) while a wheel drives at a constant speed. It learns from the pose in
    the direction of travel and from the heading, and from standing wheels
    nothing.
    """

    def __init__(self, rate: float, robot: Robot, dt: float):
        self.rate, self.robot, self.dt = rate, robot, dt
        pole = np.exp(-rate * dt)
        self.trust, self.learn = 1 - pole * pole, (1 - pole) ** 2
        self.pose: np.ndarray | None = None
        self.on, self.rolled = bool(np.any(rate)), np.ones(2)

    def correct(self, measured: np.ndarray, driven: np.ndarray) -> np.ndarray:
        """The pose now, by what was measured and how the wheels turned.

        Parameters
        ----------
        measured : array_like, shape (3, ...)
            x, y (m) and heading (rad).
        driven : ndarray, shape (2, ...)
            Right and left wheel speed (m/s) over the last time step.

        Returns
        -------
        ndarray, shape (3, ...)
        """
        measured = np.asarray(measured)
        self.rolled = _each(self.rolled, measured)
        if not self.on or self.pose is None:
            self.pose = measured
            return measured
        driven = _each(driven, measured)
        expected = moved_pose(self.robot, self.pose, self.rolled * driven, self.dt)
        ahead, _, turned = pose_error(measured, expected)
        # How much further each wheel has come than expected.
        apart = turned * self.robot.wheel_base / 2
        further = np.stack([ahead + apart, ahead - apart])
        travel = driven * self.dt
        scale = travel * travel + (CREEP * self.dt) ** 2
        rolled = self.rolled + self.learn * further * travel / scale
        self.rolled = np.clip(rolled, *ROLLED)
        difference = measured - expected
        difference[2] = wrap_angle(difference[2])
        self.pose = expected + self.trust * difference
        return self.pose


def _each(wheels: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """What both wheels of each robot of a batch have, where one pair stands for all."""
    return wheels[:, None] if wheels.ndim < pose.ndim else wheels
