"""The one closed loop: tracker, robot, limits."""

from dataclasses import dataclass

import numpy as np

from freeseg.errors import InvalidParameter
from freeseg.reference import Reference, tracking_error
from freeseg.robot import KheperaIV, as_robot, check_positive

#: A longer run would not end, or not fit into memory.
MOST_STEPS = 1e7


@dataclass(frozen=True, eq=False)
class Run:
    """A simulated run: one robot, or a batch of n with the shapes in brackets.

    Parameters
    ----------
    t : ndarray, shape (N,)
        Time (s).
    pose : ndarray, shape (3, N) [(3, n, N)]
        x, y (m) and heading (rad, not wrapped).
    reference : ndarray, shape (3, N)
        Pose wanted.
    error : ndarray, shape (3, N) [(3, n, N)]
        Tracking error (7): x_e, y_e (m), alpha_e (rad).
    wheels : ndarray, shape (2, N) [(2, n, N)]
        Right and left wheel speed (m/s) driven from each time on; at the
        last time, those that it was reached with.
    robot : KheperaIV
        Robot that was driven.
    """

    t: np.ndarray
    pose: np.ndarray
    reference: np.ndarray
    error: np.ndarray
    wheels: np.ndarray
    robot: KheperaIV


def simulate(tracker, reference, robot=None, dt=0.05, initial_offset=(0.0, 0.0, 0.0)):
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

    Returns
    -------
    Run
        At the times 0, dt, ... up to the end of the reference.

    Raises
    ------
    InvalidParameter
        For what is no tracker or no reference; a time step that is not
        positive, is longer than the reference, or makes over 10 million
        steps; an offset of another shape or not finite.
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
    # The end of the reference is reached: the last step may pass it by less than dt.
    t = dt * np.arange(int(np.ceil(reference.duration / dt - 1e-9)) + 1)
    wanted = reference.at(t).pose
    x, y, theta = wanted[:, 0]
    ahead, left, turned = offset
    pose = np.empty((*offset.shape, len(t)))
    pose[..., 0] = np.stack(
        [
            x + ahead * np.cos(theta) - left * np.sin(theta),
            y + ahead * np.sin(theta) + left * np.cos(theta),
            theta + turned,
        ]
    )
    wheels = np.zeros((2, *offset.shape[1:], len(t)))
    law = tracker.start(reference, robot, dt)
    driven = wheels[..., 0]
    for step in range(len(t) - 1):
        command = robot.to_wheels(*law(t[step], pose[..., step]))
        driven = robot.saturate(command, driven, dt)
        wheels[..., step] = driven
        pose[..., step + 1] = robot.move(pose[..., step], driven, dt)
    wheels[..., -1] = driven
    target = wanted if offset.ndim == 1 else wanted[:, None]
    return Run(t, pose, wanted, tracking_error(target, pose), wheels, robot)
