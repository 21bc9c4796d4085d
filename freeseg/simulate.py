"""The one closed loop: tracker, robot, limits, disturbance."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from freeseg.disturbance import as_disturbance, as_seed
from freeseg.errors import InvalidParameter
from freeseg.reference import Reference, tracking_error
from freeseg.robot import KheperaIV, as_robot, check_positive

#: A longer run would not end, or not fit into memory.
MOST_STEPS = 1e7

#: How many time steps are put in order at once: as many as the cache holds.
TILE = 32


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated run: one robot, or a batch of n with the shapes in brackets.

    Parameters
    ----------
    t : ndarray, shape (N,)
        Time (s).
    pose : ndarray, shape (3, N) [(3, n, N)]
        True x, y (m) and heading (rad, not wrapped).
    reference : ndarray, shape (3, N)
        Pose wanted.
    error : ndarray, shape (3, N) [(3, n, N)]
        Tracking error (7) of the true pose: x_e, y_e (m), alpha_e (rad).
    wheels : ndarray, shape (2, N) [(2, n, N)]
        Right and left wheel speed (m/s) driven from each time on; at the
        last time, those that it was reached with. They are what the motors
        turn, times the robot's own wheel radius: before slip, and whatever
        the true radius is. With lag, the mean over each time step.
    robot : KheperaIV
        Robot that was driven, as the tracker knows it.
    measured : ndarray, shape (3, N) [(3, n, N)]
        What the tracker saw: the pose with measurement noise.
    asked : ndarray, shape (2, N) [(2, n, N)]
        Wheel speeds (m/s) that the motors were asked for from each time on,
        within the limits; the motors follow with their lag.
    """

    t: np.ndarray
    pose: np.ndarray
    reference: np.ndarray
    error: np.ndarray
    wheels: np.ndarray
    robot: KheperaIV
    measured: np.ndarray | None = None
    asked: np.ndarray | None = None

    def __post_init__(self):
        if self.measured is None:
            object.__setattr__(self, "measured", self.pose)
        if self.asked is None:
            object.__setattr__(self, "asked", self.wheels)


def simulate(
    tracker,
    reference,
    robot=None,
    dt=0.05,
    initial_offset=(0.0, 0.0, 0.0),
    disturbance=None,
    seed=0,
):
    """Drive a robot after a reference with a tracker, from rest.

    Every `dt`, the tracker sees the pose and commands a body velocity; its
    wheel speeds are brought within the robot's limits and held.

    Parameters
    ----------
    tracker : object
        With ``start(reference, robot, dt) -> law``, see `SlidingMode`.
    reference : Reference
        What to follow.
    robot : KheperaIV, optional
        Robot.
    dt : float, optional
        Time step (s).
    initial_offset : array_like, shape (3,) or (3, n)
        Where the robot starts, seen from the reference's first pose: ahead
        and to the left (m), turned counter-clockwise (rad). With n columns,
        n robots are simulated at once.
    disturbance : Disturbance, optional
        What keeps the robot from doing what it is told.
    seed : int or (int, int), optional
        Seed of its random numbers. Each robot of a batch has its own, which
        depend on the seed and on the robot's number in the batch, from 0 on:
        robot k of a batch with seed s is, bit for bit, the single robot with
        the seed (s, k), and a batch with that seed begins at robot k.

    Returns
    -------
    Run
        At the times 0, dt, ... up to the end of the reference.

    Raises
    ------
    InvalidParameter
        For what is no tracker or no reference; a time step that is not
        positive, is longer than the reference, or makes over 10 million
        steps; an offset of another shape or not finite; what is no
        disturbance or no seed, or a delay that is not a whole number of
        time steps.

    Notes
    -----
    In this order: the measured pose is the true one with noise; the command
    waits for the delay; the limits apply, as the motors' own controller
    knows them, to what the motors are asked for; they follow with their lag.
    The true wheel radius and the slip turn that into speeds over the ground,
    and the true wheel base these into the turn rate.

    With lag, the wheel speeds vary within a time step. They decay towards
    the constant speeds asked for, which is integrated exactly: their mean
    makes the way and the turn of the step. The arc driven has that length
    and that turn; only its shape is taken for a circle's. At 0.1 m/s, that
    moves the end of a step of 50 ms by less than 0.1 mm, even while the
    wheels change as fast as they can in opposite senses.
    """
    robot = as_robot(robot)
    if isinstance(tracker, type) or not callable(getattr(tracker, "start", None)):
        raise InvalidParameter(f"tracker is {tracker!r}; give one, such as SlidingMode()")
    if not isinstance(reference, Reference):
        kind = type(reference).__name__
        raise InvalidParameter(f"reference is a {kind}; give one made by make_reference")
    dt = check_positive("dt", dt)
    if dt > reference.duration:
        raise InvalidParameter(
            f"dt is {dt} s, and the reference lasts {reference.duration:.3f} s; shorten it"
        )
    if reference.duration / dt > MOST_STEPS:
        raise InvalidParameter(
            f"dt is {dt} s, over {MOST_STEPS:g} steps for {reference.duration:.3f} s; lengthen it"
        )
    try:
        offset = np.asarray(initial_offset, float)
    except (TypeError, ValueError, OverflowError):
        offset = np.array(np.nan)
    if (
        offset.shape[:1] != (3,)
        or offset.ndim > 2
        or not offset.size
        or not np.isfinite(offset).all()
    ):
        raise InvalidParameter(
            f"initial_offset is {initial_offset!r}; give three finite numbers or three rows of them"
        )
    disturbance = as_disturbance(disturbance)
    seed = as_seed(seed)
    late = disturbance.delayed_steps(dt)
    t = reference.steps(dt)
    wanted = reference.at(t).pose
    x, y, theta = wanted[:, 0]
    ahead, left, turned = offset
    # Time comes first until the end: a step's numbers lie side by side.
    pose = np.empty((len(t), *offset.shape))
    pose[0] = np.stack(
        [
            x + ahead * np.cos(theta) - left * np.sin(theta),
            y + ahead * np.sin(theta) + left * np.cos(theta),
            theta + turned,
        ]
    )
    measured = np.empty_like(pose) if disturbance.noisy else pose
    batch = offset.shape[1:]
    wheels = np.zeros((len(t), 2, *batch))
    targets = np.zeros_like(wheels) if disturbance.lag else wheels
    law = tracker.start(reference, robot, dt)
    plant = replace(robot, wheel_base=robot.wheel_base * (1 + disturbance.wheel_base_error))
    samples = disturbance.start(batch, len(t), dt, seed)
    mean, end = disturbance.lag_shares(dt)
    asked = speed = driven = np.zeros((2, *batch))
    underway = deque([asked] * int(min(late, len(t))))
    # A law may give one command for a whole batch.
    form = (2, -1) if batch else (2,)
    for step, (noise, rolled) in enumerate(samples):
        if disturbance.noisy:
            measured[step] = pose[step] + noise
        if step == len(t) - 1:
            break
        underway.append(robot.to_wheels(*law(t[step], measured[step])).reshape(form))
        asked = robot.saturate(underway.popleft(), asked, dt)
        driven = asked
        if disturbance.lag:
            driven, speed = asked + mean * (speed - asked), asked + end * (speed - asked)
            targets[step] = asked
        wheels[step] = driven
        pose[step + 1] = plant.move(pose[step], driven * rolled, dt)
    wheels[-1], targets[-1] = driven, asked
    measured = _time_last(measured) if disturbance.noisy else None
    targets = _time_last(targets) if disturbance.lag else None
    pose, wheels = _time_last(pose), _time_last(wheels)
    target = wanted[:, None] if batch else wanted
    return Run(t, pose, wanted, tracking_error(target, pose), wheels, robot, measured, targets)


def _time_last(array):
    """A copy with the first axis last, tile by tile: that is several times faster."""
    moved = np.empty((*array.shape[1:], len(array)))
    for begin in range(0, len(array), TILE):
        moved[..., begin : begin + TILE] = np.moveaxis(array[begin : begin + TILE], 0, -1)
    return moved
