"""Obstacles and the world that they form.

An obstacle is a *core*, a point or a polygon, grown by a radius: a disc is a
grown point, a polygon is grown by zero. Every distance in freeseg is a
distance to a core less that radius.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import FreesegError, InvalidQuery, InvalidWorld
from freeseg.geometry import angle_of, cross, ranges, read_only, unit

#: Largest coordinate (m): beyond it, round-off would be as large as what is decided by.
FARTHEST = 1e4

#: Obstacles nearer than this touch (m): less is round-off.
TOUCHING = 1e-9


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


@dataclass(frozen=True, eq=False)
class Polygon:
    """A polygonal obstacle, convex or not, without holes.

    Parameters
    ----------
    vertices : array_like, shape (n, 2)
        Corners [x, y] (m) in order, in either sense; n at least 3. They are
        kept counter-clockwise.

    Raises
    ------
    InvalidWorld
        For fewer than three corners, a number that is not finite, an outline
        that crosses or touches itself, or an area of zero.
    """

    vertices: np.ndarray

    def __post_init__(self) -> None:
        vertices = as_points(self.vertices, "polygon", (None, 2), InvalidWorld)
        if len(vertices) > 1 and (vertices[0] == vertices[-1]).all():
            vertices = vertices[:-1]
        shown = f"polygon {checks.shown(vertices.tolist())}"
        if len(vertices) < 3:
            raise InvalidWorld(f"{shown} has under three different corners; add some")
        if (np.roll(vertices, -1, 0) == vertices).all(1).any():
            raise InvalidWorld(f"{shown} repeats a corner; remove the copy")
        core = shapely.Polygon(vertices)
        if not core.is_valid or core.area <= 0:
            why = shapely.is_valid_reason(core) if core.area > 0 else "its area is zero"
            raise InvalidWorld(f"{shown} is degenerate ({why}); give a simple outline")
        if not shapely.is_ccw(core.exterior):
            vertices = vertices[::-1]
        object.__setattr__(self, "vertices", vertices)

    radius = 0.0

    @property
    def core(self) -> shapely.Polygon:
        """The shapely geometry that, grown by `radius`, is the obstacle."""
        return shapely.Polygon(self.vertices)

    @property
    def corners(self) -> np.ndarray:
        """Centres that the robot can turn round, shape (k, 2): convex corners."""
        return read_only(self.vertices[self._convex])

    @property
    def outward(self) -> np.ndarray:
        """Unit vectors that halve the angle outside each of `corners`, shape (k, 2)."""
        along = unit(angle_of(np.roll(self.vertices, -1, 0) - self.vertices))
        return read_only(unit(angle_of(np.roll(along, 1, 0) - along))[self._convex])

    @property
    def _convex(self) -> np.ndarray:
        """Which vertices are convex corners, shape (n,)."""
        leaving = np.roll(self.vertices, -1, 0) - self.vertices
        return read_only(cross(np.roll(leaving, 1, 0), leaving) > 0)


@dataclass(frozen=True, eq=False)
class World:
    """Known static obstacles, none of which meets another.

    Parameters
    ----------
    obstacles : sequence of Disc and Polygon
        In the paper's order where there is one: neighbours in this order
        are joined by free segments. May be empty.

    Raises
    ------
    InvalidWorld
        For anything that is not a `Disc` or a `Polygon`, and for two
        obstacles that touch or overlap.
    """

    obstacles: Sequence[Disc | Polygon]

    def __post_init__(self) -> None:
        try:
            obstacles = tuple(self.obstacles)
        except TypeError:
            obstacles = None
        if obstacles is None or isinstance(self.obstacles, str | bytes):
            raise InvalidWorld(
                f"obstacles is {checks.shown(self.obstacles)}; give a list of Disc and Polygon"
            )
        for index, obstacle in enumerate(obstacles):
            if not isinstance(obstacle, (Disc, Polygon)):
                raise InvalidWorld(
                    f"obstacle {index + 1} is {checks.shown(obstacle)}; give a Disc or a Polygon"
                )
        object.__setattr__(self, "obstacles", obstacles)
        first, second = self.close_pairs(TOUCHING)
        if len(first):
            i, j = int(first[0]), int(second[0])
            at = [self.corners[index].mean(0).tolist() for index in (i, j)]
            raise InvalidWorld(
                f"obstacles {i + 1} at {at[0]} m and {j + 1} at {at[1]} m touch or overlap; "
                "move one, or join them into one polygon"
            )

    def __len__(self) -> int:
        return len(self.obstacles)

    def __iter__(self) -> Iterator[Disc | Polygon]:
        return iter(self.obstacles)

    def __getitem__(self, index: int) -> Disc | Polygon:
        return self.obstacles[index]

    def __repr__(self) -> str:
        return f"World of {len(self)} obstacles"

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
    def edges(self) -> np.ndarray:
        """All cores' outlines as segments (m), shape (m, 2, 2), by obstacle.

        A disc's has length zero.
        """
        if not len(self):
            return read_only(np.empty((0, 2, 2)))
        tails = np.concatenate([obstacle.vertices for obstacle in self.obstacles])
        following = np.arange(1, len(tails) + 1)
        following[np.r_[self.first_edge[1:], len(tails)] - 1] = self.first_edge
        return read_only(np.stack([tails, tails[following]], axis=1))

    @cached_property
    def first_edge(self) -> np.ndarray:
        """Index in `edges` of each obstacle's first segment, shape (n,)."""
        counts = [len(obstacle.vertices) for obstacle in self.obstacles]
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
        """Pairs of obstacles whose boundaries are at most `gap` apart.

        Parameters
        ----------
        gap : float
            Distance (m).

        Returns
        -------
        first, second : ndarray of int, shape (k,)
            Obstacle indices, first < second.
        """
        if len(self) < 2:
            return np.empty(0, int), np.empty(0, int)
        # No core that is farther away belongs to an obstacle so close.
        farthest = self.radii + self.radii.max() + gap
        first, second = self.tree.query(self.cores, predicate="dwithin", distance=farthest)
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
        which, obstacle = self.tree.query(
            geometries, predicate="dwithin", distance=within + self.radii.max()
        )
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
        """
        return shapely.distance(self.cores, geometry) - self.radii


def check_world(world: object) -> World:
    """`world`, or `InvalidQuery` for what is not a `World`."""
    return checks.instance("world", world, World, "a World", InvalidQuery)
