"""Obstacles and the world that they form.

An obstacle is a *core*, a point or a polygon, grown by a radius: a disc is a
grown point, a polygon is grown by zero. Every distance in freeseg is a
distance to a core less that radius. What lies outside a world's boundary is one
more obstacle, a frame, so that nothing else need know of boundaries.
"""

import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import FreesegError, InvalidParameter, InvalidQuery, InvalidWorld
from freeseg.geometry import angle_of, cross, ranges, read_only, unit

#: Largest coordinate (m): room for projected maps, whose northings go up to 1e7 m. Beyond it,
#: round-off would be as large as what is decided by.
FARTHEST = 1e8

#: Closed forms and geometric predicates agree to this (m), up to 100 km from the origin.
ROUND_OFF = 1e-9

#: Polygons of more segments are sought one by one, with Shapely's index of their own segments.
MANY_SEGMENTS = 64

#: How wide the frame round a boundary is, as a share of the boundary's extent.
FRAME = 0.1


def round_off(*points: ArrayLike) -> float:
    """Length (m) to which closed forms and geometric predicates agree at such coordinates.

    Farther out than 100 km it is that of some operations on the largest coordinate.
    """
    largest = max((np.abs(part).max(initial=0) for part in map(np.asarray, points)), default=0)
    return max(ROUND_OFF, 32 * np.finfo(float).eps * float(largest))


def as_points(
    values: ArrayLike, what: str, shape: tuple[int | None, ...], error: type[FreesegError]
) -> np.ndarray:
    """Positions or lengths (m) as a read-only array, or the error; see `checks.array`."""
    array = checks.array(what, values, shape, error=error)
    if (np.abs(array) > FARTHEST).any():
        raise error(
            f"{what} is {checks.shown(array.tolist())}, beyond {FARTHEST:g} m; positions are in "
            "metres"
        )
    return array


def as_position(values: ArrayLike, what: str) -> np.ndarray:
    """A query's position (m) as an array of shape (2,), or `InvalidQuery`."""
    return as_points(values, what, (2,), InvalidQuery)


@dataclass(frozen=True, eq=False)
class Disc:
    """A round obstacle.

    Parameters
    ----------
    center : array_like, shape (2,)
        Centre [x, y] (m).
    radius : float
        Radius (m), positive.

    Raises
    ------
    InvalidWorld
        For a centre that is not two finite numbers or a radius that is not
        a positive one.
    """

    center: np.ndarray
    radius: float

    def __post_init__(self) -> None:
        center = as_points(self.center, "disc centre", (2,), InvalidWorld)
        what = f"radius of the disc at {center.tolist()}"
        radius = checks.positive(what, self.radius, InvalidWorld)
        as_points(radius, what, (), InvalidWorld)
        object.__setattr__(self, "center", center)
        object.__setattr__(self, "radius", radius)

    def __reduce__(self) -> tuple[Callable[..., "Disc"], tuple[Any, ...]]:
        # Made anew, for arrays that are unpickled can be written to.
        return Disc, (self.center, self.radius)

    @property
    def core(self) -> shapely.Point:
        """The shapely geometry that, grown by `radius`, is the obstacle."""
        return shapely.Point(self.center)

    @property
    def vertices(self) -> np.ndarray:
        """The core's corners, shape (1, 2): the centre."""
        return self.center[None]

    #: Centres that the robot can turn round, shape (1, 2).
    corners = vertices

    @property
    def rings(self) -> tuple[np.ndarray, ...]:
        """The core as outlines (m): one of one corner."""
        return (self.vertices,)


def _outline(values: ArrayLike, what: str) -> np.ndarray:
    """Corners of a simple outline, counter-clockwise and each once, or `InvalidWorld`."""
    corners = as_points(values, what, (None, 2), InvalidWorld)
    changes = (corners[1:] != corners[:-1]).any(1)
    corners = corners[np.append(True, changes)]
    if len(corners) > 1 and (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    if len(corners) < 3:
        raise InvalidWorld(f"{what} {_shown(corners)} has under three different corners; add some")
    core = shapely.Polygon(corners)
    if core.area <= 0:
        raise InvalidWorld(
            f"{what} {_shown(corners)} is degenerate (its area is zero); give a simple outline"
        )
    if not core.is_valid:
        raise InvalidWorld(
            f"{what} crosses or touches itself ({shapely.is_valid_reason(core)}); give a simple "
            f"outline, not {_shown(corners)}"
        )
    return read_only(corners if shapely.is_ccw(core.exterior) else corners[::-1])


def _shown(corners: np.ndarray) -> str:
    """What a message shows of corners."""
    return checks.shown(corners[:20].tolist())


@dataclass(frozen=True, eq=False)
class Polygon:
    """A polygonal obstacle, convex or not, with or without holes.

    Parameters
    ----------
    vertices : array_like, shape (n, 2)
        Corners [x, y] (m) of the outer outline in order, in either sense,
        closed or not; n at least 3. A corner given several times in a row is
        kept once. They are kept counter-clockwise.
    holes : sequence of array_like, shape (k, 2), optional
        Outlines inside of which is free space, such as a courtyard, likewise.
        They are kept clockwise, so that the material is on the left of every
        edge.

    Raises
    ------
    InvalidWorld
        For an outline of fewer than three different corners, with a number
        that is not finite, that crosses or touches itself, or with an area of
        zero; and for a hole that is not inside, or meets the outline or
        another hole in more than a point.
    """

    vertices: np.ndarray
    holes: tuple[np.ndarray, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _outline(self.vertices, "polygon"))
        remedy = "a list of outlines, each an array of corners"
        given = checks.sequence("holes", self.holes, remedy, InvalidWorld)
        holes = [
            read_only(_outline(hole, f"holes[{index}]")[::-1]) for index, hole in enumerate(given)
        ]
        object.__setattr__(self, "holes", tuple(holes))
        if holes and not self.core.is_valid:
            raise InvalidWorld(
                f"holes do not fit into the polygon ({shapely.is_valid_reason(self.core)}); give "
                "holes inside of the outline and apart from each other"
            )

    def __reduce__(self) -> tuple[Callable[..., "Polygon"], tuple[Any, ...]]:
        return Polygon, (self.vertices, self.holes)

    radius = 0.0

    @property
    def rings(self) -> tuple[np.ndarray, ...]:
        """All outlines (m): the outer one, then the holes."""
        return (self.vertices, *self.holes)

    @property
    def core(self) -> shapely.Polygon:
        """The shapely geometry that, grown by `radius`, is the obstacle."""
        return shapely.Polygon(self.vertices, self.holes)

    @property
    def corners(self) -> np.ndarray:
        """Centres that the robot can turn round, shape (k, 2): convex corners."""
        return read_only(np.concatenate([ring[_is_convex(ring)] for ring in self._turnable]))

    @property
    def outward(self) -> np.ndarray:
        """Unit vectors that halve the angle outside each of `corners`, shape (k, 2)."""
        return read_only(np.concatenate([_halving(ring) for ring in self._turnable]))

    @property
    def _turnable(self) -> tuple[np.ndarray, ...]:
        """Outlines that the robot can turn round corners of (m)."""
        return self.rings


def _is_convex(ring: np.ndarray) -> np.ndarray:
    """At which corners of an outline (n, 2) the material, on its left, is convex, shape (n,)."""
    leaving = np.roll(ring, -1, 0) - ring
    return read_only(cross(np.roll(leaving, 1, 0), leaving) > 0)


def _halving(ring: np.ndarray) -> np.ndarray:
    """Unit vectors that halve the angle outside each convex corner of an outline, (k, 2)."""
    along = unit(angle_of(np.roll(ring, -1, 0) - ring))
    return unit(angle_of(np.roll(along, 1, 0) - along))[_is_convex(ring)]


@dataclass(frozen=True, eq=False)
class Frame(Polygon):
    """All that is outside a boundary, as an obstacle; a `World` makes it.

    Parameters
    ----------
    vertices : array_like, shape (n, 2)
        The boundary (m). The frame's outer outline, which stands for the
        infinite, becomes a box round it.
    holes : tuple
        Becomes the boundary, clockwise.
    """

    def __post_init__(self) -> None:
        boundary = _outline(self.vertices, "boundary")
        low, high = boundary.min(0), boundary.max(0)
        wide = FRAME * (high - low).max()
        (left, bottom), (right, top) = low - wide, high + wide
        box = np.array([(left, bottom), (right, bottom), (right, top), (left, top)])
        object.__setattr__(self, "vertices", read_only(box))
        object.__setattr__(self, "holes", (read_only(boundary[::-1]),))

    def __reduce__(self) -> tuple[Callable[..., "Frame"], tuple[Any, ...]]:
        return Frame, (self.boundary,)

    @property
    def boundary(self) -> np.ndarray:
        """Corners of the boundary (m), counter-clockwise."""
        return self.holes[0][::-1]

    @property
    def _turnable(self) -> tuple[np.ndarray, ...]:
        # Nothing comes round the frame from outside.
        return self.holes


@dataclass(frozen=True, eq=False)
class World:
    """Known static obstacles, and perhaps a boundary that the robot stays inside.

    Obstacles may touch, overlap and contain each other, and meet the boundary:
    what counts is all that they cover together.

    Parameters
    ----------
    obstacles : sequence of Disc and Polygon
        In the paper's order where there is one: neighbours in this order
        are joined by free segments. May be empty. With a boundary, all that is
        outside of it becomes one more obstacle, a `Frame`, the last one.
    boundary : array_like of shape (n, 2), or Polygon, optional
        Corners [x, y] (m) of a simple outline, convex or not. It is kept as an
        array, counter-clockwise.

    Raises
    ------
    InvalidWorld
        For anything that is not a `Disc` or a `Polygon`, and for a boundary
        that is no simple outline or has holes.
    """

    obstacles: Sequence[Disc | Polygon]
    boundary: np.ndarray | None = None

    def __post_init__(self) -> None:
        remedy = "a list of Disc and Polygon"
        obstacles = checks.sequence("obstacles", self.obstacles, remedy, InvalidWorld)
        for index, obstacle in enumerate(obstacles):
            if not isinstance(obstacle, (Disc, Polygon)):
                raise InvalidWorld(
                    f"obstacle {index + 1} is {checks.shown(obstacle)}; give a Disc or a Polygon"
                )
        # The obstacles of a world, handed on to another one, bring their frame with them.
        frames = [obstacle for obstacle in obstacles if isinstance(obstacle, Frame)]
        if self.boundary is not None:
            frames = [_frame(self.boundary)]
        if frames:
            others = (obstacle for obstacle in obstacles if not isinstance(obstacle, Frame))
            obstacles = *others, frames[-1]
        object.__setattr__(self, "obstacles", obstacles)
        object.__setattr__(self, "boundary", frames[-1].boundary if frames else None)

    def __reduce__(self) -> tuple[Callable[[bytes], "World"], tuple[bytes]]:
        return _unpickled, (pickle.dumps(self.obstacles),)

    def __len__(self) -> int:
        return len(self.obstacles)

    def __iter__(self) -> Iterator[Disc | Polygon]:
        return iter(self.obstacles)

    def __getitem__(self, index: int) -> Disc | Polygon:
        return self.obstacles[index]

    def __repr__(self) -> str:
        bounded = ", the last of them what is outside the boundary"
        if self.boundary is not None and len(self) == 1:
            return "World of 1 obstacle, which is what is outside the boundary"
        count = f"{len(self)} obstacle{'' if len(self) == 1 else 's'}"
        return f"World of {count}{'' if self.boundary is None else bounded}"

    @property
    def frame(self) -> int | None:
        """Index of the obstacle that is all outside the boundary; None without one."""
        return None if self.boundary is None else len(self) - 1

    def name_of(self, obstacle: int) -> str:
        """What messages call an obstacle: its number from 1, or "the boundary"."""
        return "the boundary" if obstacle == self.frame else f"obstacle {obstacle + 1}"

    @cached_property
    def round_off(self) -> float:
        """Length (m) that decides nothing here, for it is round-off; see `round_off`."""
        return round_off(self.edges, self.radii)

    @cached_property
    def cores(self) -> np.ndarray:
        """Shapely geometries of the cores, shape (n,)."""
        return read_only(np.array([obstacle.core for obstacle in self.obstacles], dtype=object))

    @cached_property
    def radii(self) -> np.ndarray:
        """Radius by which each core is grown (m), shape (n,)."""
        return read_only(np.array([obstacle.radius for obstacle in self.obstacles], dtype=float))

    @cached_property
    def tree(self) -> shapely.STRtree:
        """Shapely's search tree over the cores."""
        return shapely.STRtree(self.cores)

    @cached_property
    def _trees(self) -> tuple[shapely.STRtree, shapely.STRtree]:
        """As `tree`, but of the cores with few segments, and of those with many."""
        many = self.edge_counts > MANY_SEGMENTS
        shapely.prepare(self.cores[many])
        few, others = self.cores.copy(), self.cores.copy()
        # A tree leaves out what is None, and counts on.
        few[many], others[~many] = None, None
        return shapely.STRtree(few), shapely.STRtree(others)

    def pairs_near(
        self, geometries: np.ndarray, within: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pairs among which are all geometries and obstacles at most `within` apart.

        Parameters
        ----------
        geometries : ndarray of shapely geometry, shape (k,)
            Any, in metres.
        within : ndarray, shape (k,)
            Largest distance (m).

        Returns
        -------
        which, obstacle : ndarray of int, shape (m,)
            Geometry, in order, and obstacle.
        """
        few, many = self._trees
        reach = within + self.radii.max()
        which, obstacle = few.query(geometries, predicate="dwithin", distance=reach)
        if not len(many):
            return which, obstacle
        left, bottom, right, top = shapely.bounds(geometries).T
        boxes = shapely.box(left - within, bottom - within, right + within, top + within)
        also, large = many.query(boxes)
        close = shapely.dwithin(self.cores[large], geometries[also], within[also])
        which = np.append(which, also[close])
        order = np.argsort(which, kind="stable")
        return which[order], np.append(obstacle, large[close])[order]

    @cached_property
    def edges(self) -> np.ndarray:
        """All cores' outlines as segments (m), shape (m, 2, 2), by obstacle.

        Those of a polygon's holes follow on its outer ones; a disc's has
        length zero.
        """
        if not len(self):
            return read_only(np.empty((0, 2, 2)))
        tails = np.concatenate([ring for obstacle in self.obstacles for ring in obstacle.rings])
        return read_only(np.stack([tails, tails[self.following_edge]], axis=1))

    @cached_property
    def following_edge(self) -> np.ndarray:
        """Index in `edges` of the segment that goes on where each ends, shape (m,)."""
        rings = (ring for obstacle in self.obstacles for ring in obstacle.rings)
        ends = np.cumsum([len(ring) for ring in rings], dtype=int)
        following = np.arange(1, ends[-1] + 1 if len(ends) else 1)
        following[ends - 1] = np.append(0, ends[:-1])[: len(ends)]
        return read_only(following)

    @cached_property
    def first_edge(self) -> np.ndarray:
        """Index in `edges` of each obstacle's first segment, shape (n,)."""
        counts = [sum(map(len, obstacle.rings)) for obstacle in self.obstacles]
        return read_only(np.cumsum([0, *counts[:-1]]) if counts else np.empty(0, int))

    @cached_property
    def edge_counts(self) -> np.ndarray:
        """Number of segments of each obstacle, shape (n,)."""
        return read_only(np.diff(np.r_[self.first_edge, len(self.edges)]))

    def edges_of(self, obstacles: np.ndarray) -> np.ndarray:
        """Indices in `edges` of the segments of obstacles, one obstacle after the other."""
        return ranges(self.first_edge[obstacles], self.edge_counts[obstacles])

    @cached_property
    def corners(self) -> tuple[np.ndarray, ...]:
        """Centres that the robot can turn round, by obstacle.

        A disc has one, its centre; a polygon has its convex corners.
        """
        return tuple(obstacle.corners for obstacle in self.obstacles)

    def close_pairs(self, gap: float) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of obstacles that are at most `gap` apart, or meet.

        Parameters
        ----------
        gap : float
            Distance (m).

        Returns
        -------
        first, second : ndarray of int, shape (k,)
            Obstacle indices, first < second.

        Raises
        ------
        InvalidParameter
            For a gap that is not a finite number.
        """
        gap = checks.number("gap", gap)
        if len(self) < 2:
            return np.empty(0, int), np.empty(0, int)
        first, second = self.pairs_near(self.cores, self.radii + gap)
        once = first < second
        first, second = first[once], second[once]
        apart = shapely.distance(self.cores[first], self.cores[second])
        close = apart - self.radii[first] - self.radii[second] <= gap
        return first[close], second[close]

    def near(
        self, geometries: np.ndarray, within: float | np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Obstacles near to geometries, and how near.

        Parameters
        ----------
        geometries : ndarray of shapely geometry, shape (k,)
            Any, in metres.
        within : float or ndarray, shape (k,)
            Largest distance (m).

        Returns
        -------
        which, obstacle : ndarray of int, shape (m,)
            Geometry and obstacle of every pair at most `within` apart.
        distance : ndarray, shape (m,)
            Distance (m); at or below zero where they meet.
        """
        if not len(self):
            return np.empty(0, int), np.empty(0, int), np.empty(0)
        within = np.broadcast_to(within, np.shape(geometries))
        which, obstacle = self.pairs_near(geometries, within)
        distance = shapely.distance(self.cores[obstacle], geometries[which]) - self.radii[obstacle]
        close = distance <= within[which]
        return which[close], obstacle[close], distance[close]

    def distances(self, geometry: shapely.Geometry | np.ndarray) -> np.ndarray:
        """Distance from every obstacle to geometries.

        Parameters
        ----------
        geometry : shapely geometry, or ndarray of them, shape (..., 1)
            Any, in metres.

        Returns
        -------
        ndarray, shape (..., n)
            Distance (m); below or at zero where the obstacle is met.

        Raises
        ------
        InvalidParameter
            For what is no such geometry, or an empty one.
        """
        try:
            distances = shapely.distance(self.cores, geometry) - self.radii
        except (TypeError, ValueError):
            distances = np.array(np.nan)
        if np.isnan(distances).any():
            raise InvalidParameter(
                f"geometry is {checks.shown(geometry)}; give shapely geometries that are not "
                "empty, such as shapely.Point(x, y), several as an array of shape (k, 1)"
            )
        return distances


@lru_cache(maxsize=16)
def _unpickled(obstacles: bytes) -> World:
    """The world of pickled obstacles.

    Whenever a process receives it, it is the same object, so that what planners
    remember of a world is found again.
    """
    return World(pickle.loads(obstacles))


def _frame(boundary: ArrayLike | Polygon) -> Frame:
    """The frame outside a boundary, or `InvalidWorld`."""
    if isinstance(boundary, Polygon):
        if boundary.holes:
            raise InvalidWorld(
                f"boundary has {len(boundary.holes)} holes; give its outer outline alone, and the "
                "holes as obstacles"
            )
        boundary = boundary.vertices
    return Frame(as_points(boundary, "boundary", (None, 2), InvalidWorld))


def check_world(world: object) -> World:
    """`world`, or `InvalidQuery` for what is not a `World`."""
    return checks.instance("world", world, World, "a World", InvalidQuery)
