"""What reactive laws share: what they see of the obstacles, and how they turn.

A law that knows the map is told the nearest point of every obstacle, one that has a range
scanner what its rays meet. Either is of the time at which it looks.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import TINY, cross, point_segment_distance, unit
from freeseg.planners.query import check_free
from freeseg.robot import Robot, as_robot
from freeseg.scene import Scene, check_scene
from freeseg.trackers.feedback import Law, starts
from freeseg.world import World, as_position

#: Rays of a range scan, equally spaced: one every three degrees.
BEAMS = 120

#: Sine of the angle at which a ray is taken to be parallel to a segment, and by which share of
#: its length a segment reaches farther.
PARALLEL = 1e-9


class Outlines(NamedTuple):
    """All obstacles at a time, as arrays: m segments that are grown by radii.

    Attributes
    ----------
    edges : ndarray, shape (m, 2, 2)
        Both ends of every segment (m), by obstacle; a disc's has length zero.
    radii : ndarray, shape (m,)
        By how much each is grown (m).
    first : ndarray of int, shape (k,)
        Index of the first segment of each of the k obstacles.
    """

    edges: np.ndarray
    radii: np.ndarray
    first: np.ndarray


class Reactive(Protocol):
    """Gains, from which a law starts that sees obstacles and needs no path."""

    def start(self, scene: World | Scene, goal: ArrayLike, robot: Robot, dt: float, /) -> Law:
        """The law for one drive; what it remembers lives in it alone.

        Parameters
        ----------
        scene : World or Scene
            Obstacles.
        goal : array_like, shape (2,)
            Where to drive (m).
        robot : Robot
            Robot.
        dt : float
            Time for which each command is held (s).

        Returns
        -------
        Law

        Raises
        ------
        InvalidQuery
            For what is no world and no scene, or a goal where the robot does not fit.
        InvalidParameter
            For what is no robot, or a time step that is not positive.
        """


def outlines_of(scene: World | Scene) -> Callable[[float], Outlines]:
    """``at(t)``: the obstacles' outlines at a time (s)."""
    scene = check_scene(scene)

    # A world that stands still is the same at all times.
    @lru_cache(maxsize=1)
    def outlines(world: World) -> Outlines:
        radii = np.repeat(world.radii, world.edge_counts)
        return Outlines(world.edges, radii, world.first_edge)

    return lambda t: outlines(scene.at(t))


def is_reactive(law: Any) -> bool:
    """Whether gains start a law from a scene, a goal, a robot and a time step."""
    start = law.start if starts(law) else None
    try:
        checks.function("start", start, "", None, None, None, None)
    except InvalidParameter:
        return False
    return True


def check_drive(
    scene: World | Scene, goal: ArrayLike, robot: Robot | None, dt: float
) -> tuple[np.ndarray, Robot]:
    """The goal (m) and the robot of a drive, checked.

    Raises
    ------
    InvalidQuery
        For what is no world and no scene, or a goal where the robot does not fit as long as
        all obstacles stand where they begin.
    InvalidParameter
        For what is no robot, or a time step that is not positive.
    """
    scene, robot, goal = check_scene(scene), as_robot(robot), as_position(goal, "goal")
    checks.positive("dt", dt)
    check_free("goal", goal, scene.at(0.0), robot, 0.0)
    return goal, robot


def nearest_points(outlines: Outlines, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of points from every obstacle, and the way there.

    Parameters
    ----------
    outlines : Outlines
        k obstacles.
    points : ndarray, shape (n, 2)
        Points (m).

    Returns
    -------
    distance : ndarray, shape (n, k)
        Distance from the outline (m); negative inside of a disc.
    away : ndarray, shape (n, k, 2)
        Unit vector from the nearest point of each obstacle; zero on the centre of a disc.
    """
    tails = outlines.edges[:, 0]
    along = outlines.edges[:, 1] - tails
    from_tails = points[:, None] - tails
    share = (from_tails * along).sum(-1) / np.maximum((along**2).sum(-1), TINY)
    gaps = from_tails - np.clip(share, 0, 1)[..., None] * along
    apart = np.hypot(gaps[..., 0], gaps[..., 1])
    away, distance = gaps / np.maximum(apart, TINY)[..., None], apart - outlines.radii
    if len(outlines.first) == len(outlines.radii):
        return distance, away
    # Of every obstacle, the segment that is nearest.
    least = np.minimum.reduceat(distance, outlines.first, axis=-1)
    counts = np.diff(np.append(outlines.first, len(outlines.radii)))
    index = np.arange(len(outlines.radii))
    is_nearest = distance == np.repeat(least, counts, axis=-1)
    nearest = np.maximum.reduceat(np.where(is_nearest, index, -1), outlines.first, axis=-1)
    return least, np.take_along_axis(away, nearest[..., None], axis=-2)


def scan(outlines: Outlines, pose: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Range readings all round a pose.

    Parameters
    ----------
    outlines : Outlines
        Obstacles.
    pose : ndarray, shape (3, ...)
        x, y (m) and heading (rad); the first ray leaves along the heading.
    reach : float
        Largest range (m).

    Returns
    -------
    bearing : ndarray, shape (BEAMS, ...)
        Direction of every ray (rad), counter-clockwise from the x-axis.
    distance : ndarray, shape (BEAMS, ...)
        How far the first obstacle is along it (m); infinite beyond the reach, zero inside of a
        disc.
    """
    turns = 2 * np.pi / BEAMS * np.arange(BEAMS)
    bearing = turns.reshape(-1, *(1,) * (pose.ndim - 1)) + pose[2]
    rays, origin = unit(bearing)[..., None, :], np.moveaxis(pose[:2], 0, -1)[..., None, :]
    apart = point_segment_distance(origin, outlines.edges) - outlines.radii
    near = (apart < reach).any(axis=tuple(range(apart.ndim - 1)))
    edges, radii = outlines.edges[near], outlines.radii[near]
    is_disc = (edges[:, 0] == edges[:, 1]).all(-1)
    distance = np.minimum(
        _to_discs(rays, edges[is_disc, 0] - origin, radii[is_disc]).min(-1, initial=np.inf),
        _to_segments(rays, edges[~is_disc], origin).min(-1, initial=np.inf),
    )
    return bearing, np.where(distance <= reach, distance, np.inf)


def _to_discs(rays: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Lengths of rays (..., 1, 2) up to discs; their centres (..., k, 2) are seen from there."""
    ahead = (rays * centers).sum(-1)
    outside = (centers**2).sum(-1) - radii**2
    inner = ahead**2 - outside
    meets = (inner >= 0) & (ahead > 0)
    length = np.where(meets, ahead - np.sqrt(np.maximum(inner, 0)), np.inf)
    return np.where(outside <= 0, 0.0, length)


def _to_segments(rays: np.ndarray, edges: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Lengths of rays (..., 1, 2) from an origin (..., 1, 2) up to segments (k, 2, 2)."""
    along, to_tails = edges[:, 1] - edges[:, 0], edges[:, 0] - origin
    turned = cross(rays, along)
    with np.errstate(divide="ignore", invalid="ignore"):
        length = cross(to_tails, along) / turned
        share = cross(to_tails, rays) / turned
    # A ray along a segment meets its neighbours at their corner.
    crosses = np.abs(turned) > PARALLEL * np.hypot(along[..., 0], along[..., 1])
    # Nor does round-off let it through between two neighbours.
    meets = crosses & (length >= 0) & (np.abs(share - 0.5) <= 0.5 + PARALLEL)
    return np.where(meets, length, np.inf)


def steer(error: Any, speed: Any, gain: float, turn_rate: float) -> tuple[Any, Any]:
    """Command of a robot that turns towards a direction while it drives.

    Parameters
    ----------
    error : float or ndarray
        By how much the direction is to the left of the heading (rad).
    speed : float or ndarray
        Forward speed on that direction (m/s).
    gain : float
        Turn rate over error (1/s).
    turn_rate : float
        Largest turn rate (rad/s).

    Returns
    -------
    v, omega : float or ndarray
        Forward speed (m/s), zero where the direction is not ahead, and turn rate (rad/s).
    """
    return speed * np.maximum(np.cos(error), 0), np.clip(gain * error, -turn_rate, turn_rate)


def for_each(start: Callable[[], Law]) -> Law:
    """A law for one robot or for many, each of which has one of its own.

    Parameters
    ----------
    start : callable
        Starts the law of one robot.
    """
    laws: list[Law] = []

    def law(t, pose):
        poses = [pose] if pose.ndim == 1 else list(pose.T)
        laws.extend(start() for _ in poses[len(laws) :])
        commands = np.array([one(t, its) for one, its in zip(laws, poses, strict=True)])
        return tuple(commands.T if pose.ndim > 1 else commands[0])

    return law
