"""The one closed loop: tracker, robot, limits, disturbance."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.disturbance import Disturbance, Motors, as_disturbance
from freeseg.errors import InvalidParameter
from freeseg.geometry import read_only
from freeseg.reference import MOST_STEPS, Reference, pose_error
from freeseg.robot import Robot, as_robot, moved_pose, same_robot, wheel_speeds
from freeseg.trackers.feedback import Law, Tracker, check_tracker

#: Shapes of the poses of one robot and of n robots, and the units of their rows.
POSES, POSE_UNITS = ((3,), (3, None)), "m, m, rad"

#: Signals of a run, how many rows they have, and whether each robot of a batch has its own.
SIGNALS_OF_RUN = (
    ("pose", 3, True),
    ("wheels", 2, True),
    ("measured", 3, True),
    ("asked", 2, True),
    ("reference", 3, False),
    ("error", 3, True),
)


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated run: one robot, or a batch of n with the shapes in brackets.

    Parameters
    ----------
    t : ndarray, shape (N,)
        Time (s).
    pose : ndarray, shape (3, N) [(3, n, N)]
        True x, y (m) and heading (rad, not wrapped).
    wheels : ndarray, shape (2, N) [(2, n, N)]
        Right and left wheel speed (m/s) driven from each time on; at the
        last time, those of the step before. They are what the motors
        turn, times the robot's own wheel radius: before slip, and whatever
        the true radius is. With lag, the mean over each time step.
    robot : Robot
        Robot that was driven, as the tracker knows it.
    measured : ndarray, shape (3, N) [(3, n, N)]
        What the tracker saw: the pose with measurement noise.
    asked : ndarray, shape (2, N) [(2, n, N)]
        Wheel speeds (m/s) that the motors were asked for from each time on,
        within the limits; the motors follow with their lag.
    reference : ndarray, shape (3, N), or None
        Pose wanted; None where nothing was to be followed.
    error : ndarray, shape (3, N) [(3, n, N)], or None
        Tracking error (7) of the true pose: x_e, y_e (m), alpha_e (rad).

    Raises
    ------
    InvalidParameter
        For arrays that are not finite or do not belong together.
    """

    t: np.ndarray
    pose: np.ndarray
    wheels: np.ndarray
    robot: Robot
    measured: np.ndarray
    asked: np.ndarray
    reference: np.ndarray | None = None
    error: np.ndarray | None = None

    def __post_init__(self):
        checks.instance("robot", self.robot, Robot, "the Robot that was driven")
        t, pose = self._signal("t", None), self._signal("pose", None)
        if t.ndim != 1 or len(t) < 2 or not (np.diff(t) > 0).all():
            raise InvalidParameter(f"run t is {checks.shown(self.t)}; give increasing times (s)")
        if pose.ndim not in (2, 3):
            raise InvalidParameter(f"run pose has shape {pose.shape}; give (3, N) or (3, n, N)")
        robots = pose.shape[1:-1]
        for name, rows, batch in SIGNALS_OF_RUN:
            if getattr(self, name) is not None or name not in ("reference", "error"):
                self._signal(name, (rows, *(robots if batch else ()), len(t)))

    def _signal(self, name, shape):
        """Make a field a read-only array of a shape, or of any for None; or raise."""
        given = getattr(self, name)
        if not isinstance(given, np.ndarray) or given.dtype != float:
            given = checks.real(f"run {name}", given, "an array of numbers").astype(float)
        if given.flags.writeable:
            given = read_only(given.copy())
        object.__setattr__(self, name, given)
        if shape and given.shape != shape:
            raise InvalidParameter(f"run {name} has shape {given.shape}; give {shape}")
        # What was measured, or asked for, may be the same array as what was done.
        known = {"measured": self.pose, "asked": self.wheels}.get(name) is given
        # Their sum is finite where all are, unless it overflows, and costs a batch less.
        if shape and not (known or isfinite(given.sum()) or np.isfinite(given).all()):
            raise InvalidParameter(f"run {name} is not finite; give finite numbers")
        return given

    def __repr__(self):
        robots = "one robot" if self.pose.ndim == 2 else f"{self.pose.shape[1]} robots"
        return f"Run of {robots} over {self.t[-1]:.3f} s in {len(self.t) - 1} steps"


def simulate(
    tracker: Tracker,
    reference: Reference,
    robot: Robot | None = None,
    dt: float = 0.05,
    initial_offset: ArrayLike = (0.0, 0.0, 0.0),
    disturbance: Disturbance | None = None,
    seed: int | tuple[int, ...] = 0,
    settle: float = 0.0,
    tolerance: float = 0.01,
) -> Run:
    """Drive a robot after a reference with a tracker, from rest.

    Every `dt`, the tracker sees the pose and commands a body velocity; its
    wheel speeds are brought within the robot's limits and held.

    Parameters
    ----------
    tracker : Tracker
        With ``start(reference, robot, dt) -> law``, see `SlidingMode`.
    reference : Reference
        What to follow.
    robot : Robot, optional
        Robot; by default that of the reference, or a Khepera IV.
    dt : float, optional
        Time step (s).
    initial_offset : array_like, shape (3,) or (3, n)
        Where the robot begins, seen from the reference's first pose: ahead
        and to the left (m), turned counter-clockwise (rad). With n columns,
        n robots are simulated at once.
    disturbance : Disturbance, optional
        What keeps the robot from doing what it is told.
    seed : int or tuple of int, optional
        Seed of its random numbers. Each robot of a batch has its own, which
        depend on the seed and on the robot's index in the batch, from 0 on:
        robot k of a batch with seed s is, bit for bit, the single robot with
        the seed (s, k), and a batch with that seed begins at robot k.

    settle : float, optional
        How long (s) the run goes on at most after the reference has ended,
        until every robot is within the tolerance of its end.
    tolerance : float, optional
        That distance (m).

    Returns
    -------
    Run
        At the times 0, dt, ... up to the end of the reference, or longer.

    Raises
    ------
    InvalidParameter
        For what is no tracker or no reference; a time step that is not
        positive, is longer than the reference, or makes over 10 million
        steps; an offset of another shape or not finite; what is no
        disturbance or no seed, or a delay that is not a whole number of
        time steps; a robot that is not the reference's; a settling time that
        is negative, or a tolerance that is not positive; from the loop, what
        the law returns that is no command, with its time.

    Notes
    -----
    In this order: the measured pose is the true one with noise; the command
    waits for the delay; the limits apply, as the motors' own controller
    knows them, to what the motors are asked for; they follow with their lag.
    The true wheel radius and the slip turn that into speeds over the ground,
    and the true wheel base these into the turn rate.

    With lag, the wheel speeds vary within a time step. They decay towards
    the constant speeds asked for, which is integrated exactly: their mean
    makes the length and the turn of the step. The arc driven has that length
    and that turn; only its shape is taken for a circle's. At 0.1 m/s, that
    moves the end of a step of 50 ms by less than 0.1 mm, even while the
    wheels change as fast as they can in opposite senses.

    Examples
    --------
    A tracker of one's own is anything with such a ``start``:

    >>> import freeseg as fs
    >>> class Pull:
    ...     def start(self, reference, robot, dt):
    ...         def law(t, pose):
    ...             x_e, y_e, alpha_e = fs.tracking_error(reference.at(t).pose, pose)
    ...             return reference.at(t).v + 2 * x_e, 20 * y_e + 4 * alpha_e
    ...         return law
    >>> reference = fs.make_reference(fs.Path([fs.Line((0, 0), (1, 0))]))
    >>> run = simulate(Pull(), reference, initial_offset=(0, 0.01, 0))
    >>> bool(fs.metrics.tracking(run)["position_final_m"] < 0.005)
    True
    """
    check_tracker(tracker)
    checks.instance("reference", reference, Reference, "one made by make_reference")
    robot = as_robot(same_robot(robot, reference.robot, "the reference"))
    dt = checks.positive("dt", dt)
    if dt > reference.duration:
        raise InvalidParameter(
            f"dt is {dt} s, and the reference lasts {reference.duration:.3f} s; shorten it"
        )
    steps = len(reference.steps(dt)) - 1
    offset = checks.array("initial_offset", initial_offset, *POSES, unit=POSE_UNITS)
    disturbance, seed = as_disturbance(disturbance), checks.seed(seed)
    disturbance.delayed_steps(dt)
    settle = checks.not_negative("settle", settle)
    tolerance = checks.positive("tolerance", tolerance)
    if (reference.duration + settle) / dt > MOST_STEPS:
        raise InvalidParameter(f"settle is {settle:g} s; give less, for {MOST_STEPS:g} steps")
    goal = np.expand_dims(reference.pose[:2, -1], tuple(range(1, offset.ndim)))
    arrived = _arrival(goal, dt * (steps - 0.5), tolerance) if settle else None
    first = _offset_pose(reference.pose[:, 0], offset)
    law = _start(tracker, reference, robot, dt)
    steps += int(np.ceil(settle / dt - 1e-9))
    run = drive(law, first, dt, steps, robot, disturbance, seed, arrived)
    wanted = reference.at(run.t).pose
    target = wanted[:, None] if offset.ndim == 2 else wanted
    error = pose_error(target, run.pose)
    # Nobody else has this run yet: to replace it would check all of its signals once more.
    object.__setattr__(run, "reference", read_only(wanted))
    object.__setattr__(run, "error", read_only(error))
    return run


def _start(tracker, reference, robot, dt):
    """The law that a tracker starts; `InvalidParameter` where it cannot."""
    try:
        return tracker.start(reference, robot, dt)
    except TypeError as error:
        # Such as one that takes other arguments.
        raise InvalidParameter(
            f"tracker is {checks.shown(tracker)}, whose start(reference, robot, dt) raised "
            f"{checks.shown(error)}; let it take these three and return law(t, pose)"
        ) from error


def drive(
    law: Law,
    pose: ArrayLike,
    dt: float,
    steps: int,
    robot: Robot | None = None,
    disturbance: Disturbance | None = None,
    seed: int | tuple[int, ...] = 0,
    stop: Callable[[float, np.ndarray], bool] | None = None,
) -> Run:
    """Drive a robot by a law, from rest: the closed loop, which needs no reference.

    Parameters
    ----------
    law : Law
        ``law(t, pose) -> (v, omega)``, asked every `dt` for a body velocity
        (m/s, rad/s), with the time (s) and the measured pose, of the shape
        of `pose`.
    pose : array_like, shape (3,) or (3, n)
        Where the robot, or each of n robots, begins: x, y (m), heading (rad).
    dt : float
        Time step (s), for which each command is held.
    steps : int
        How many time steps.
    robot, disturbance, seed
        As for `simulate`.
    stop : callable, optional
        ``stop(t, pose)``, asked at every time step but the first with the time
        (s) and the true pose, whether the run ends there; of a batch, it ends
        where that holds for all robots.

    Returns
    -------
    Run
        At the times 0, dt, ..., steps dt, or until it was to stop; without
        reference and error.

    Raises
    ------
    InvalidParameter
        For a pose of another shape or not finite, a time step that is not
        positive, no or over 10 million steps, what is no law, no robot, no
        disturbance or no seed, or a delay that is not a whole number of time
        steps; from the loop, what the law returns that is no command, with
        its time.
    """
    robot, disturbance = as_robot(robot), as_disturbance(disturbance)
    dt, steps = checks.positive("dt", dt), checks.whole("steps", steps, 1)
    if steps > MOST_STEPS:
        raise InvalidParameter(f"steps is {checks.shown(steps)}; give at most {MOST_STEPS:g}")
    if stop is not None:
        checks.function("stop", stop, "stop(t, pose) -> bool, or None", 0.0, pose)
    checks.function("law", law, "law(t, pose) -> (v, omega)", 0.0, pose)
    first, seed = checks.array("pose", pose, *POSES, unit=POSE_UNITS), checks.seed(seed)
    batch = first.shape[1:]
    # Time comes first until the end: a step's numbers lie side by side.
    poses = np.empty((steps + 1, *first.shape))
    poses[0] = first
    measured = np.empty_like(poses) if disturbance.noisy else poses
    wheels = np.zeros((steps + 1, 2, *batch))
    asked = np.zeros_like(wheels) if disturbance.lag else wheels
    motors = Motors(robot, disturbance, dt, steps, batch)
    plant = disturbance.plant(robot)
    t = dt * np.arange(steps + 1)
    for step, (noise, rolled) in enumerate(disturbance.samples(batch, steps + 1, dt, seed)):
        if disturbance.noisy:
            measured[step] = poses[step] + noise
        if step == steps or (stop and step and np.all(stop(t[step], poses[step].copy()))):
            break
        target, wheels[step] = motors.follow(_ask(law, t[step], measured[step], robot))
        if asked is not wheels:
            asked[step] = target
        poses[step + 1] = moved_pose(plant, poses[step], wheels[step] * rolled, dt)
    t, poses, measured, wheels, asked = (
        signal[: step + 1] for signal in (t, poses, measured, wheels, asked)
    )
    # At the last time, those of the step before.
    wheels[-1], asked[-1] = wheels[-2], asked[-2]
    poses, wheels = _time_last(poses), _time_last(wheels)
    measured = _time_last(measured) if disturbance.noisy else poses
    asked = _time_last(asked) if disturbance.lag else wheels
    arrays = map(read_only, (t, poses, wheels, measured, asked))
    t, poses, wheels, measured, asked = arrays
    return Run(t, poses, wheels, robot, measured, asked)


def _ask(law, t, pose, robot):
    """Wheel speeds (m/s) that a law commands; `InvalidParameter` for what is no command."""
    # A copy: whatever the law does with it, the robot stays where it is.
    given = law(t, pose.copy())
    try:
        v, omega = given
        wheels = wheel_speeds(robot, v, omega)
        # Of a batch, all robots may get one command; it is cheaper to try than to compare shapes.
        command = wheels.reshape(2, -1) if pose.ndim > 1 and wheels.ndim == 1 else wheels
        known = command.dtype.kind == "f" and command.shape[1:] in (pose.shape[1:], (1,))
        if known and command.ndim == pose.ndim:
            # NumPy's calls cost more than a step of one robot has to spare.
            one = pose.ndim == 1
            if all(map(isfinite, command.tolist())) if one else np.isfinite(command).all():
                return command
    except (TypeError, ValueError, OverflowError):
        pass
    wanted = "two finite numbers" if pose.ndim == 1 else f"finite, one or {pose.shape[1]} of each"
    raise InvalidParameter(
        f"the law {checks.shown(law)} returned {checks.shown(given)} at {t:.3f} s; give v and "
        f"omega (m/s, rad/s), {wanted}"
    )


def _offset_pose(pose, offset):
    """Pose that is ahead, to the left (m) and turned (rad) by an offset, seen from a pose."""
    (x, y, theta), (ahead, left, turned) = pose, offset
    return np.stack(
        [
            x + ahead * np.cos(theta) - left * np.sin(theta),
            y + ahead * np.sin(theta) + left * np.cos(theta),
            theta + turned,
        ]
    )


def _arrival(goal, since, tolerance):
    """``stop(t, pose)``: whether all robots are near to a goal, from some time on."""

    def stop(t, pose):
        return t > since and (np.hypot(*(pose[:2] - goal)) < tolerance).all()

    return stop


def _time_last(array):
    """A copy with the first axis last."""
    return np.ascontiguousarray(np.moveaxis(array, 0, -1))
