"""Free segments between neighbouring obstacles: paper, section 3.2.1."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from freeseg import checks
from freeseg.geometry import angle_of, read_only, unit
from freeseg.robot import Robot, as_robot
from freeseg.triangulation import triangulate
from freeseg.world import Disc, World, check_world

#: Security margin delta (m). Not published: an assumption.
MARGIN = 0.005


@dataclass(frozen=True, eq=False)
class FreeSegment:
    """The gap between two neighbouring obstacles; of length zero where they meet.

    Parameters
    ----------
    obstacles : tuple of int
        Indices of the two obstacles; -1 for a point far outside of them all.
    ends : ndarray, shape (2, 2)
        The mutually nearest points of their boundaries (m); twice the same
        point, of both, where they meet.
    required : float
        Length that makes it safe, D_r + delta (m).
    """

    obstacles: tuple[int, int]
    ends: np.ndarray
    required: float

    def __repr__(self) -> str:
        first, second = (f"obstacle {k + 1}" if k >= 0 else "outside" for k in self.obstacles)
        kind = "safe" if self.safe else "danger"
        return f"FreeSegment of {self.length:.4f} m from {first} to {second}, {kind}"

    @property
    def length(self) -> float:
        """Length SP (m), equations (2) and (3)."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))

    @property
    def safe(self) -> bool:
        """Whether the robot fits through with its margin: SP >= D_r + delta."""
        return self.length >= self.required


def free_segments(
    world: World,
    robot: Robot | None = None,
    margin: float = MARGIN,
    neighbours: str = "chain",
) -> tuple[FreeSegment, ...]:
    """Free segments between neighbouring obstacles, equations (2) to (4).

    Parameters
    ----------
    world : World
        n obstacles; for ``neighbours="chain"`` in the paper's order.
    robot : Robot, optional
        Robot; its diameter is D_r.
    margin : float, optional
        Security margin delta (m); 5 mm is an assumption, the paper gives
        none.
    neighbours : {"chain", "delaunay"}, optional
        Which obstacles are joined: consecutive ones, as published, without
        the boundary, or those that are neighbours in the world's
        triangulation, see `triangulate`.

    Returns
    -------
    tuple of FreeSegment
        Safe and danger ones; of a chain n - 1, or n - 2 with a boundary.
        Those of obstacles that touch or overlap have length zero, and are
        danger. Safe speaks of the two obstacles joined: now and then a third
        one is in between.

    Raises
    ------
    InvalidQuery, InvalidParameter
        For a world or a robot that is none, a margin that is negative or not finite,
        or neighbours that are not known.

    Examples
    --------
    >>> import freeseg as fs
    >>> [round(segment.length, 4) for segment in free_segments(fs.load_table(1))]
    [0.2772, 0.164, 0.203, 0.2979, 0.2246, 0.2326]
    """
    check_world(world)
    required = as_robot(robot).diameter + checks.not_negative("margin", margin)
    checks.choice("neighbours", neighbours, ("chain", "delaunay"))
    if neighbours == "chain":
        # The boundary comes last, but in no order with the others.
        count = len(world) if world.frame is None else world.frame
        pairs = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    else:
        pairs = triangulate(world).neighbours if len(world) else np.empty((0, 2), int)
    nearest = shapely.get_coordinates(shapely.shortest_line(*world.cores[pairs].T))
    nearest = nearest.reshape(-1, 2, 2)
    return make_segments(pairs, nearest, world.radii[pairs], required)


def make_segments(
    obstacles: np.ndarray, points: np.ndarray, radii: np.ndarray, required: float
) -> tuple[FreeSegment, ...]:
    """Free segments between points of cores that are grown.

    Parameters
    ----------
    obstacles : ndarray of int, shape (k, 2)
        Indices of both obstacles of every segment.
    points : ndarray, shape (k, 2, 2)
        A point of each one's core (m).
    radii : ndarray, shape (k, 2)
        Radii by which the cores are grown (m).
    required : float
        Length that makes a segment safe (m).

    Returns
    -------
    tuple of FreeSegment
    """
    along = points[:, 1] - points[:, 0]
    across = unit(angle_of(along))
    apart, grown = np.hypot(*along.T), radii.sum(1)
    # Where the obstacles meet, both ends are the point that parts the line like the radii.
    share = apart / np.where(grown > apart, grown, 1)
    reaching = np.where((grown > apart)[:, None], share[:, None] * radii, radii)
    ends = points + reaching[..., None] * np.stack([across, -across], axis=1)
    ends[grown >= apart, 1] = ends[grown >= apart, 0]
    read_only(ends)
    return tuple(
        FreeSegment((first, second), both, required)
        for (first, second), both in zip(obstacles.tolist(), ends, strict=True)
    )


def group_labels(world: World, gap: float) -> np.ndarray:
    """Groups of obstacles that the robot cannot pass between.

    Parameters
    ----------
    world : World
        n obstacles.
    gap : float
        Obstacles at most this far apart (m) belong together, and so do all
        that a chain of such pairs joins.

    Returns
    -------
    ndarray of int, shape (n,)
        Index of the group that each obstacle belongs to.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = world.close_pairs(gap)
    joined = coo_array((np.ones(len(pairs[0])), pairs), shape=(len(world), len(world)))
    return connected_components(joined, directed=False)[1]


@dataclass(frozen=True, eq=False)
class Endpoint:
    """A point of an obstacle's boundary that the robot may turn round.

    Parameters
    ----------
    point : ndarray, shape (2,)
        The point (m).
    outward : ndarray, shape (2,)
        Unit vector away from the obstacle.
    obstacle : int
        Index of the obstacle.
    segment : int or None
        Index of the free segment that ends here; None for an outer endpoint,
        which faces no neighbour.
    center : ndarray, shape (2,)
        Centre of the dangerous circle for a turn here (m): the disc's centre,
        the polygon's corner.
    """

    point: np.ndarray
    outward: np.ndarray
    obstacle: int
    segment: int | None
    center: np.ndarray

    def __repr__(self) -> str:
        x, y = self.point
        kind = "an outer one" if self.segment is None else f"of segment {self.segment + 1}"
        return f"Endpoint at ({x:.4f}, {y:.4f}) m on obstacle {self.obstacle + 1}, {kind}"


def find_endpoints(world: World, segments: Sequence[FreeSegment]) -> tuple[Endpoint, ...]:
    """Endpoints of the safe segments, and outer endpoints.

    An end of a danger segment is no endpoint, for danger segments are
    ignored. The paper also draws endpoints that belong to no segment (p1 and
    p6 in its Fig. 4) but does not say where they are. Here an obstacle has
    such outer endpoints wherever its boundary faces no neighbour: a disc at
    least every quarter turn between its segments, a polygon at its convex
    corners.

    Parameters
    ----------
    world : World
        Obstacles.
    segments : sequence of FreeSegment
        Their free segments.

    Returns
    -------
    tuple of Endpoint
        Of all obstacles.
    """
    facing: list[list[tuple[int, np.ndarray, np.ndarray]]] = [[] for _ in world]
    for index, segment in enumerate(segments):
        for side, (owner, end) in enumerate(zip(segment.obstacles, segment.ends, strict=True)):
            across = segment.ends[1 - side] - end
            if segment.length == 0:
                # What touches a disc is away from its centre, and a polygon's own direction is
                # asked for at no danger segment.
                across = end - world[owner].vertices[0]
            length = np.hypot(*across)
            if length > 0:
                facing[owner].append((index, end, read_only(across / length)))
    endpoints = []
    for owner, (obstacle, ends) in enumerate(zip(world, facing, strict=True)):
        corners = world.corners[owner]
        for index, end, outward in ends:
            if segments[index].safe:
                corner = corners[np.argmin(((corners - end) ** 2).sum(1))]
                endpoints.append(Endpoint(end, outward, owner, index, corner))
        if isinstance(obstacle, Disc):
            angles = sorted(math.atan2(outward[1], outward[0]) for _, _, outward in ends)
            for outward in read_only(unit(_between(angles))):
                point = read_only(obstacle.center + obstacle.radius * outward)
                endpoints.append(Endpoint(point, outward, owner, None, obstacle.center))
        else:
            for corner, outward in zip(corners, obstacle.outward, strict=True):
                endpoints.append(Endpoint(corner, outward, owner, None, corner))
    return tuple(endpoints)


def _between(angles: list[float]) -> list[float]:
    """Directions that part the gaps between sorted angles into quarter turns at most."""
    quarter = math.pi / 2
    if not angles:
        return [0, quarter, 2 * quarter, 3 * quarter]
    directions: list[float] = []
    for angle, following in zip(angles, [*angles[1:], angles[0] + 2 * math.pi], strict=True):
        # The small amount keeps a gap of exactly a quarter turn from counting as more.
        parts = math.ceil((following - angle) / quarter - 1e-9)
        directions += [angle + (following - angle) * part / parts for part in range(1, parts)]
    return directions
