"""Random worlds and queries, the same for the same seed."""

from collections.abc import Iterable

import numpy as np
import shapely

from freeseg import checks
from freeseg.errors import InvalidParameter, InvalidWorld
from freeseg.geometry import unit
from freeseg.plan import turning_radius
from freeseg.robot import Robot, as_robot
from freeseg.segments import MARGIN
from freeseg.world import Disc, Polygon, World, check_world

#: Radii (m) of random discs, and of the circles in which random polygons lie.
SIZES = (0.015, 0.06)

#: Square metres per random obstacle; the paper's maps have 0.13.
SPACIOUS = 0.1

#: Widest square (m): on a wider one, obstacles of centimetres are lost.
WIDEST = 1e4

#: More would take minutes.
MOST_OBSTACLES = 1e6


def random_world(
    n: int, seed: int, shapes: Iterable[str] = ("disc",), area: float = SPACIOUS
) -> World:
    """Obstacles scattered over a square, none of which meets another.

    Parameters
    ----------
    n : int
        Number of obstacles.
    seed : int
        Equal seeds give equal worlds.
    shapes : iterable of str, optional
        ``"disc"``, ``"polygon"`` or both, which then are equally likely. A
        polygon has three to seven corners and need not be convex.
    area : float, optional
        Area of the square per obstacle (m^2); the smaller, the more crowded.

    Returns
    -------
    World
        On the square from (0, 0) to (side, side), side = sqrt(n area).

    Raises
    ------
    InvalidParameter
        For an `n` or a seed that is not a whole number from 0 on, a shape that
        is not known, an area that is not positive, or over a million obstacles.
    InvalidWorld
        Where the square is too crowded for n obstacles.

    Examples
    --------
    >>> len(random_world(5, seed=1, shapes=("disc", "polygon")))
    5
    """
    n = checks.whole("n", n, remedy="a whole number of obstacles from 0 on")
    if n > MOST_OBSTACLES:
        raise InvalidParameter(f"n is {checks.shown(n)}; give at most {MOST_OBSTACLES:g}")
    try:
        # In this order whatever theirs is: a set's is not the same in every run.
        kinds = sorted(set() if isinstance(shapes, str) else set(shapes))
    except TypeError:
        kinds = []
    if not kinds or not set(kinds) <= {"disc", "polygon"}:
        raise InvalidParameter(
            f"shapes is {checks.shown(shapes)}; give a list of 'disc' and 'polygon'"
        )
    side = np.sqrt(n * checks.positive("area", area))
    if side > WIDEST:
        raise InvalidParameter(
            f"area is {area:g} m^2, and the square {side:g} m wide; give less, for at most "
            f"{WIDEST:g} m"
        )
    rng = np.random.default_rng(checks.whole("seed", seed))
    centers, radii = _scatter(n, side, rng)
    return World(
        [
            Disc(center, radius) if kind == "disc" else _star(center, radius, rng)
            for kind, center, radius in zip(rng.choice(kinds, n), centers, radii, strict=True)
        ]
    )


def _scatter(n: int, side: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 2) and radii (n,) of circles on a square, none of which meets another."""
    # Imported here: it takes long, and only this function needs it.
    from scipy.spatial import KDTree

    centers, radii = np.empty((0, 2)), np.empty(0)
    for _ in range(100):
        missing = n - len(radii)
        if not missing:
            return centers, radii
        centers = np.concatenate([centers, rng.uniform(0, side, (missing, 2))])
        radii = np.concatenate([radii, rng.uniform(*SIZES, missing)])
        pairs = KDTree(centers).query_pairs(2 * SIZES[1], output_type="ndarray")
        first, second = pairs.min(1), pairs.max(1)
        apart = np.hypot(*(centers[first] - centers[second]).T)
        # Of two that meet, the later one goes.
        keep = np.ones(len(radii), bool)
        keep[second[apart <= radii[first] + radii[second]]] = False
        centers, radii = centers[keep], radii[keep]
    raise InvalidWorld(
        f"{n} obstacles do not fit on {side:.3g} m x {side:.3g} m; give a larger area"
    )


def _star(center: np.ndarray, radius: float, rng: np.random.Generator) -> Polygon:
    """A polygon inside a circle: one corner in each of equal sectors."""
    corners = int(rng.integers(3, 8))
    angles = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.9, corners)) / corners
    return Polygon(center + radius * rng.uniform(0.4, 1, (corners, 1)) * unit(angles))


def random_query(
    world: World, seed: int, robot: Robot | None = None, margin: float = MARGIN
) -> tuple[np.ndarray, np.ndarray]:
    """A start and a goal where the robot stands free with its margin.

    Parameters
    ----------
    world : World
        Obstacles.
    seed : int
        Equal seeds give equal queries.
    robot : Robot, optional
        Robot.
    margin : float, optional
        Security margin delta (m).

    Returns
    -------
    start, goal : ndarray, shape (2,)
        Positions (m), uniform over the free part of the obstacles' bounding
        box widened by the robot's diameter, or of what the boundary encloses.

    Raises
    ------
    InvalidParameter
        For a seed that is not a whole number from 0 on, a robot that is none,
        or a margin that is negative or not finite.
    InvalidWorld
        Where there is hardly any free position.
    """
    check_world(world)
    robot = as_robot(robot)
    rng = np.random.default_rng(checks.whole("seed", seed))
    low, high = np.zeros(2), np.zeros(2)
    if world.boundary is not None:
        low, high = world.boundary.min(0) + robot.diameter, world.boundary.max(0) - robot.diameter
    elif len(world):
        low, high = world.edges.min((0, 1)), world.edges.max((0, 1))
    clearance = turning_radius(robot, checks.not_negative("margin", margin))
    free = np.empty((0, 2))
    for _ in range(100):
        points = rng.uniform(low - robot.diameter, high + robot.diameter, (16, 2))
        close, _, _ = world.near(shapely.points(points), clearance)
        free = np.concatenate([free, np.delete(points, close, axis=0)])
        if len(free) > 1:
            return free[0], free[1]
    raise InvalidWorld(
        "100 times 16 random positions left no two free for this robot and margin; give a less "
        "crowded world, or less margin"
    )
