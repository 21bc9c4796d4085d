"""Driving by a reactive law from a start to a goal, and what came of it."""

from dataclasses import dataclass, fields
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.disturbance import Disturbance
from freeseg.errors import InvalidParameter, InvalidQuery, Trapped
from freeseg.planners.query import check_free
from freeseg.reactive.sensing import Reactive, is_reactive
from freeseg.reference import MOST_STEPS
from freeseg.robot import Robot, as_robot
from freeseg.scene import check_scene
from freeseg.simulate import Run, drive
from freeseg.world import as_points, as_position, round_off

#: Largest distance (m) between the points of a run at which its clearance is measured.
CHECK_STEP = 0.001

#: Distance from the goal (m) at which a robot has arrived, unless it is told otherwise.
ARRIVED = 0.01


@dataclass(frozen=True, eq=False)
class ReactiveRun(Run):
    """What a robot drove by a reactive law, checked by other means than the law's.

    Parameters
    ----------
    t, pose, wheels, robot, measured, asked, reference, error
        As for `Run`, of one robot that followed nothing.
    clearance : float
        Smallest distance (m) of the robot's centre from an obstacle, each where it is at that
        time: by Shapely, at points of the arcs driven that are at most `CHECK_STEP` apart.
    collision : float or None
        Time (s) at which the body first meets an obstacle; None if it never does.
    """

    clearance: float = np.inf
    collision: float | None = None

    def __post_init__(self):
        super().__post_init__()
        clearance = checks.as_float(self.clearance)
        if np.isnan(clearance):
            raise InvalidParameter(
                f"run clearance is {checks.shown(self.clearance)}; give a distance (m)"
            )
        object.__setattr__(self, "clearance", clearance)
        if self.collision is not None:
            collision = checks.not_negative("run collision", self.collision)
            object.__setattr__(self, "collision", collision)

    def __repr__(self):
        hit = "" if self.collision is None else f", with a collision at {self.collision:.3f} s"
        return super().__repr__() + hit


def react(
    reactive: Reactive,
    scene: Any,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    dt: float = 0.05,
    disturbance: Disturbance | None = None,
    seed: int | tuple[int, int] = 0,
    tolerance: float = ARRIVED,
    patience: float = 20.0,
    limit: float = 300.0,
) -> ReactiveRun:
    """Drive a robot from a start to a goal by a reactive law, from rest.

    The loop is that of `drive`: limits, disturbance and arcs are those of the trackers.

    Parameters
    ----------
    reactive : Reactive
        With ``start(scene, goal, robot, dt) -> law``, see `PotentialField`.
    scene : World or Scene
        Obstacles.
    start : array_like, shape (2,) or (3,)
        Where the robot begins: x, y (m), and its heading (rad), by default to the goal.
    goal : array_like, shape (2,)
        Where to (m).
    robot, dt, disturbance, seed
        As for `simulate`; a Khepera IV by default.
    tolerance : float, optional
        Distance from the goal (m) at which the robot has arrived.
    patience : float, optional
        Time (s) after which a robot is trapped that in all of it has not come nearer to the
        goal, by the tolerance, than it ever was.
    limit : float, optional
        Longest time (s) that it drives.

    Returns
    -------
    ReactiveRun
        Until it arrives. It drives on after a collision, which the run names.

    Raises
    ------
    Trapped
        Where it does not arrive, with its ``run``.
    InvalidQuery
        For what is no world and no scene, or a start or goal where the robot does not fit as
        the obstacles stand at first.
    InvalidParameter
        For what is no reactive law; a tolerance, patience or limit that is not positive, or a
        limit of no or over 10 million time steps; and as `drive`.

    Examples
    --------
    >>> import freeseg as fs
    >>> run = react(fs.PotentialField(), fs.World([fs.Disc((0.5, 0.02), 0.05)]), (0, 0), (1, 0))
    >>> run.collision is None, run.clearance > run.robot.radius
    (True, True)
    """
    robot, dt = as_robot(robot), checks.positive("dt", dt)
    tolerance = checks.positive("tolerance", tolerance)
    patience, limit = checks.positive("patience", patience), checks.positive("limit", limit)
    if dt > limit:
        raise InvalidParameter(f"dt is {dt:g} s, longer than the limit, {limit:g} s; give less")
    if limit / dt > MOST_STEPS:
        raise InvalidParameter(f"limit is {limit:g} s; give less, for {MOST_STEPS:g} steps")
    goal = as_position(goal, "goal")
    pose = _first_pose(start, goal)
    check_free("start", pose[:2], check_scene(scene).at(0.0), robot, 0.0)
    law = _start(reactive, scene, goal, robot, dt)
    stop = _end(goal, float(np.hypot(*(goal - pose[:2]))), tolerance, patience)
    run = drive(law, pose, dt, ceil(limit / dt - 1e-9), robot, disturbance, seed, stop)
    run = _checked(run, check_scene(scene))
    left = float(np.hypot(*(goal - run.pose[:2, -1])))
    if left < tolerance:
        return run
    raise Trapped(
        f"the robot was {left:.3f} m from the goal after {run.t[-1]:.2f} s, and "
        f"{type(reactive).__name__} brings it no nearer; plan a path, for which reactive laws are "
        "no substitute, or give it other gains, more patience or a longer limit",
        run=run,
    )


def _first_pose(start, goal):
    """Where the robot begins (m, m, rad), from a position or a pose."""
    start = checks.array("start", start, (2,), (3,), error=InvalidQuery)
    as_points(start[:2], "start", (2,), InvalidQuery)
    heading = start[2] if len(start) > 2 else np.arctan2(*(goal - start)[::-1])
    return np.array([*start[:2], heading])


def _start(reactive, scene, goal, robot, dt):
    """The law that gains start; `InvalidParameter` for what is no reactive law."""
    if not is_reactive(reactive):
        raise InvalidParameter(
            f"reactive is {checks.shown(reactive)}; give one, such as PotentialField(), with "
            "start(scene, goal, robot, dt) -> law"
        )
    return reactive.start(scene, goal, robot, dt)


def _end(goal, first, tolerance, patience):
    """``stop(t, pose)``: whether the robot has arrived, or has long come no nearer."""
    nearest, since = first, 0.0

    def stop(t, pose):
        nonlocal nearest, since
        left = np.hypot(*(goal - pose[:2]))
        if left <= nearest - tolerance:
            nearest, since = left, t
        return left < tolerance or t - since >= patience

    return stop


def _checked(run, scene):
    """The run with its clearance and its first collision."""
    points, t = arc_points(run)
    apart = scene.distances(points, t).min(-1, initial=np.inf)
    met = np.flatnonzero(apart < run.robot.radius - round_off(points))
    values = {field.name: getattr(run, field.name) for field in fields(Run)}
    collision = float(t[met[0]]) if len(met) else None
    return ReactiveRun(**values, clearance=float(apart.min()), collision=collision)


def arc_points(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Points of the arcs that a robot drove, at most `CHECK_STEP` apart, and their times.

    Parameters
    ----------
    run : Run
        Of one robot.

    Returns
    -------
    points : ndarray, shape (k, 2)
        Positions (m).
    t : ndarray, shape (k,)
        Times (s).
    """
    x, y, theta = run.pose
    turned, middle = np.diff(theta), 0.5 * (theta[1:] + theta[:-1])
    # Signed: the robot may back up.
    chord = np.diff(x) * np.cos(middle) + np.diff(y) * np.sin(middle)
    length = chord / np.sinc(turned / (2 * np.pi))
    count = max(ceil(np.abs(length).max() / CHECK_STEP), 1)
    share = np.arange(count) / count
    part = np.multiply.outer(length, share) * np.sinc(
        np.multiply.outer(turned, share / (2 * np.pi))
    )
    direction = theta[:-1, None] + np.multiply.outer(turned, share / 2)
    points = np.stack(
        [x[:-1, None] + part * np.cos(direction), y[:-1, None] + part * np.sin(direction)], -1
    )
    t = run.t[:-1, None] + np.multiply.outer(np.diff(run.t), share)
    points = np.concatenate([points.reshape(-1, 2), run.pose[:2, -1:].T])
    return points, np.append(t, run.t[-1])
