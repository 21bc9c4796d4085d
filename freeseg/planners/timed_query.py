"""What a planner among movers is asked, and what its search is given."""

import math
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter, InvalidQuery, InvalidWorld
from freeseg.geometry import angle_of, read_only
from freeseg.planners import time_search
from freeseg.planners.compilation import compiled
from freeseg.planners.query import Query, ask
from freeseg.planners.route import convex_corners
from freeseg.planners.time_search import GROWTH, RADIUS, SHAPE, Field, U, W, X, Y
from freeseg.robot import Robot
from freeseg.scene import Mover, Scene, check_scene
from freeseg.timed_path import NODES, SHARE, WEIGHTS
from freeseg.world import Disc, World

#: The robot must be faster than a disc's rim by this share of its speed.
FASTER = 1e-6

#: The table of a rim has at least so many steps a turn.
KNOTS = 32

#: A search among so few discs is not worth the loading of what is compiled, if it is not yet.
SMALL_FIELD = 8


@dataclass(frozen=True, eq=False)
class TimedQuery:
    """A question to a planner among movers that has been checked, see `ask_in_time`.

    Parameters
    ----------
    scene : Scene
        What was asked about.
    still : Query
        The same question among what stands, movers that stand among it.
    number : ndarray of int
        Which obstacle of the scene each obstacle of ``still.world`` is.
    moving : ndarray of int, shape (m,)
        Which obstacles of the scene move.
    discs : ndarray, shape (m, 6)
        Their dangerous circles: centre (m) and velocity (m/s), radius at time
        zero (m) and growth (m/s).
    speed : float
        Speed of the robot (m/s).
    """

    scene: Scene
    still: Query
    number: np.ndarray
    moving: np.ndarray
    discs: np.ndarray
    speed: float

    @cached_property
    def origin(self) -> np.ndarray:
        """Where positions of the search are counted from (m), so that they are small."""
        return (self.still.start + self.still.goal) / 2

    @cached_property
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """At which edges of the world convex corners and discs begin (c,), their cones (c, 4)."""
        return convex_corners(self.still.world, self.still.world.edges)

    @cached_property
    def obstacle_of(self) -> np.ndarray:
        """Which obstacle of the scene each disc of the search is, -1 for the goal."""
        world = self.still.world
        of_edge = np.repeat(self.number, world.edge_counts)
        return np.concatenate([[-1], self.moving, of_edge[self.corners[0]]]).astype(int)

    @cached_property
    def disc(self) -> np.ndarray:
        """Discs of the search, as in `Field`: the goal, what moves, what can be turned round."""
        world, (which, _) = self.still.world, self.corners
        of_edge = np.repeat(np.arange(len(world)), world.edge_counts)
        disc = np.zeros((1 + len(self.discs) + len(which), 6))
        disc[0, :2] = self.still.goal
        disc[1 : 1 + len(self.discs)] = self.discs
        disc[1 + len(self.discs) :, :2] = world.edges[which, 0]
        disc[1 + len(self.discs) :, RADIUS] = self.still.turning_radii[of_edge[which]]
        disc[:, :2] -= self.origin
        return disc

    def field(self) -> tuple[Field, ModuleType]:
        """What the search is given, and the search, compiled where that pays."""
        world, (which, cones) = self.still.world, self.corners
        disc, moving = self.disc, len(self.discs) + 1
        is_edge = (world.edges[:, 0] != world.edges[:, 1]).any(1)
        # A corner's own edges are the one that begins there and the one before it.
        before = np.empty(len(world.edges), int)
        before[world.following_edge] = np.arange(len(world.edges))
        place = np.where(is_edge, np.cumsum(is_edge) - 1, -1)
        cone, own = np.zeros((len(disc), 4)), np.full((len(disc), 2), -1)
        own[moving:] = np.stack([place[before[which]], place[which]], -1)
        cone[moving:] = np.where(is_edge[which][:, None], cones, 0.0)
        of_edge = np.repeat(np.arange(len(world)), world.edge_counts)
        covered, release = covers(disc)
        field = Field(
            start=self.still.start - self.origin,
            speed=self.speed,
            disc=disc,
            cone=cone,
            own=own,
            edge=(world.edges[is_edge] - self.origin).reshape(-1, 4),
            keep=self.still.turning_radii[of_edge[is_edge]],
            table=np.empty((len(disc), 2, _knots(disc, self.speed) + 1)),
            node=NODES.copy(),
            weight=WEIGHTS.copy(),
            covered=covered,
            release=release,
            wait=np.empty((0, SHAPE + 12)),
        )
        is_small = len(disc) <= SMALL_FIELD and not compiled.cache_info().currsize
        kernels = time_search if is_small else compiled(time_search)
        kernels.fill_table(field)
        return field, kernels


def _knots(disc: np.ndarray, speed: float) -> int:
    """How many steps a turn the tables of rims need."""
    ratio = float((np.hypot(disc[:, U], disc[:, W]) + disc[:, GROWTH]).max()) / speed
    return max(KNOTS, math.ceil(2 * np.pi / (SHARE * math.acosh(1 / ratio))) if ratio else 0)


def covers(disc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """When discs (n, 6) cover the first one's centre, and when and where they release it.

    Returns
    -------
    covered, release : ndarray
        As in `Field`.
    """
    offset = disc[:, :2] - disc[0, :2]
    first, last = meeting(offset, disc[:, U : W + 1], disc[:, RADIUS], disc[:, GROWTH])
    covering = (first < last) & (disc[:, RADIUS] > 0)
    merged: list[list[float]] = []
    for begin, end in sorted(zip(first[covering].tolist(), last[covering].tolist(), strict=True)):
        if merged and begin <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([begin, end])
    covered = np.array(merged).reshape(-1, 2)
    release = np.full((len(disc), 2), np.nan)
    ends = covering & np.isin(last, covered[:, 1]) & np.isfinite(last)
    release[ends, 0] = last[ends]
    release[ends, 1] = angle_of(-(offset[ends] + last[ends, None] * disc[ends, U : W + 1]))
    return covered, release


def meeting(
    offset: np.ndarray, velocity: np.ndarray, radius: np.ndarray, growth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """From when until when |offset + velocity t| < radius + growth t, for t from zero on (s).

    Parameters
    ----------
    offset, velocity : ndarray, shape (..., 2)
        Where something is seen (m), and how it moves (m/s).
    radius, growth : ndarray, shape (...)
        A distance (m), not negative, and its growth (m/s); where that is negative, it is
        beyond the speed.

    Returns
    -------
    first, last : ndarray, shape (...)
        Times (s); the first is not before the last where it never is.
    """
    square = (velocity**2).sum(-1) - growth**2
    half = (offset * velocity).sum(-1) - radius * growth
    apart = (offset**2).sum(-1) - radius**2
    root = half**2 - square * apart
    with np.errstate(divide="ignore", invalid="ignore"):
        # Of both forms of a root, the one that loses no digits.
        large = -half - np.where(half < 0, -1, 1) * np.sqrt(np.maximum(root, 0))
        one, other = large / square, apart / large
    one, other = np.where(np.isnan(one), np.inf, one), np.where(np.isnan(other), np.inf, other)
    low, high = np.minimum(one, other), np.maximum(one, other)
    even, once = square == 0, apart / np.where(half == 0, -1.0, -2 * half)
    cases = [
        even & (apart < 0) & (half <= 0),
        even & (apart < 0),
        even & (half < 0),
        even,
        square > 0,
        growth > 0,
    ]
    first = np.select(cases, [0.0, 0.0, once, np.inf, low, high], 0.0)
    last = np.select(cases, [np.inf, once, np.inf, 0.0, high, np.inf], low)
    never = (root <= 0) & (square > 0)
    return np.where(never, np.inf, np.maximum(first, 0)), np.where(never, -np.inf, last)


def ask_in_time(
    scene: Scene | World,
    start: ArrayLike,
    goal: ArrayLike,
    speed: float,
    robot: Robot | None,
    margin: float,
) -> TimedQuery:
    """Check what a planner among movers is asked.

    Parameters
    ----------
    scene, start, goal, speed, robot, margin
        As for `time_minimal_plan`.

    Raises
    ------
    InvalidQuery, InvalidParameter, InvalidWorld
        As for `time_minimal_plan`.
    """
    scene = check_scene(scene)
    found = checks.positive("speed", speed)
    static = len(scene.world)
    stands = np.array([_stands(mover) for mover in scene.movers], bool)
    for index in np.flatnonzero(~stands).tolist():
        _check_mover(scene.movers[index], scene.name_of(static + index), found)
    world, standing = scene.world, np.flatnonzero(stands)
    if len(standing):
        obstacles = (scene.movers[index].obstacle for index in standing.tolist())
        world = World([*world, *obstacles])
    still = ask(world, start, goal, robot, margin)
    if found > still.robot.max_wheel_speed:
        raise InvalidParameter(
            f"speed is {found:g} m/s, but the robot's wheels reach {still.robot.max_wheel_speed:g} "
            "m/s; give less"
        )
    fixed = static if scene.world.frame is None else static - 1
    number = np.concatenate([np.arange(fixed), static + standing, np.arange(fixed, static)])
    moving = static + np.flatnonzero(~stands)
    discs = _dangerous_discs(scene, still, moving)
    return TimedQuery(scene, still, number.astype(int), moving, discs, found)


def _stands(mover: Mover) -> bool:
    """Whether a mover stands."""
    return mover.is_predictable and not np.any(mover.velocity)


def _check_mover(mover: Mover, name: str, speed: float) -> None:
    """Raise unless a mover is a disc that moves evenly, and more slowly than the robot."""
    if mover.shift is not None or not isinstance(mover.obstacle, Disc):
        what = "moves by a function of time" if mover.shift is not None else "is a Polygon"
        raise InvalidWorld(
            f"{name} {what}; give the Disc round it, with its velocity, or with its top speed as "
            "its growth"
        )
    pace = math.hypot(*np.asarray(mover.velocity)) + mover.growth
    if pace > speed * (1 - FASTER):
        raise InvalidParameter(
            f"speed is {speed:g} m/s, and {name} is no slower, with {pace:g} m/s; give a higher "
            "speed, for a robot that is slower than an obstacle is beyond this planner"
        )


def _dangerous_discs(scene: Scene, still: Query, moving: np.ndarray) -> np.ndarray:
    """Columns of `TimedQuery.discs`, or `InvalidQuery` where the start is not free."""
    distances = scene.distances(still.start, 0.0)[moving]
    discs = np.empty((len(moving), 6))
    for row, index in enumerate(moving.tolist()):
        mover, gap = scene.movers[index - len(scene.world)], float(distances[row])
        if gap < still.robot.radius:
            raise InvalidQuery(
                f"start {still.start.tolist()} is {gap:.4f} m from {scene.name_of(index)} at time "
                f"zero, and the robot's radius is {still.robot.radius:g} m; move it away"
            )
        wide = still.robot.radius + still.margin / 2
        clear = min(wide, gap - still.round_off * min(gap, 0.5))
        obstacle = mover.obstacle
        assert isinstance(obstacle, Disc), "it was checked"
        discs[row] = *obstacle.center, *np.asarray(mover.velocity), 0.0, mover.growth
        discs[row, RADIUS] = obstacle.radius + clear
    return read_only(discs)


assert (X, Y) == (0, 1), "centres are the first two columns"
