"""Triangulation of a world: which obstacles are neighbours, and the rooms between them."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from freeseg.geometry import cross, ranges, read_only, unit
from freeseg.world import World

#: Polygon edges are divided so that no part is longer (m): the triangulation then nearly always
#: follows them.
PART = 0.1

#: How many points far outside stand round the world, so that there are rooms all round it.
RING = 8


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles between the obstacles of a world.

    Parameters
    ----------
    points : ndarray, shape (s, 2)
        Sites (m): a disc's centre, a polygon's corners and points of its
        edges, and a ring of points far outside.
    radii : ndarray, shape (s,)
        Radii of the sites (m): a disc's own, or zero.
    obstacle : ndarray of int, shape (s,)
        Obstacle that each site belongs to; -1 for the ring.
    triangles : ndarray of int, shape (t, 3)
        Sites of every triangle, counter-clockwise.
    edges : ndarray of int, shape (e, 2)
        Sites of every edge, each once.
    edges_of : ndarray of int, shape (t, 3)
        Edges of every triangle; edge k joins its sites k and k + 1.
    rooms_of : ndarray of int, shape (e, 2)
        Triangles on both sides of every edge; the same one twice outside.
    """

    points: np.ndarray
    radii: np.ndarray
    obstacle: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    edges_of: np.ndarray
    rooms_of: np.ndarray

    def __repr__(self) -> str:
        inner = int((self.obstacle >= 0).sum())
        return f"Triangulation of {inner} sites and a ring of {RING}: {len(self.triangles)} rooms"

    @property
    def neighbours(self) -> np.ndarray:
        """Pairs of neighbouring obstacles, first < second, shape (k, 2)."""
        pairs = np.sort(self.obstacle[self.edges], axis=1)
        between = (pairs[:, 0] >= 0) & (pairs[:, 0] < pairs[:, 1])
        return read_only(np.unique(pairs[between], axis=0))

    def find(self, point: ArrayLike) -> int | None:
        """Index of the triangle that a point (m) lies in; None outside the ring."""
        normals, levels = self._sides
        inside = (normals @ np.asarray(point) >= levels).all(1)
        return int(np.argmax(inside)) if inside.any() else None

    @cached_property
    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """Inward normals of the triangles' edges (t, 3, 2), and their levels (t, 3)."""
        corners = self.points[self.triangles]
        along = np.roll(corners, -1, 1) - corners
        normals = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        return read_only(normals), read_only((normals * corners).sum(-1))


@lru_cache(maxsize=4)
def triangulate(world: World) -> Triangulation:
    """Power triangulation of a world's obstacles.

    The Delaunay triangulation weighted with the squared radii: its edges part
    unequal discs, and a disc that meets no other is never left out. It is the
    lower hull of the sites lifted to x^2 + y^2 - r^2 (F. Aurenhammer, "Power
    diagrams", *SIAM J. Comput.* 16, 1987). A world is triangulated once and
    remembered.

    Parameters
    ----------
    world : World
        Obstacles.

    Returns
    -------
    Triangulation
    """
    points, obstacle = _divide(world)
    middle = (points.min(0) + points.max(0)) / 2
    extent = np.ptp(points, axis=0).max() + 1
    ring = middle + 4 * extent * unit(2 * np.pi * (np.arange(RING) + 0.3) / RING)
    radii = np.concatenate([world.radii[obstacle], np.zeros(RING)])
    points = np.concatenate([points, ring])
    obstacle = np.concatenate([obstacle, np.full(RING, -1)])
    triangles = _lower_hull((points - middle) / extent, radii / extent)
    arrays = points, radii, obstacle, triangles, *_find_edges(triangles, len(points))
    return Triangulation(*map(read_only, arrays))


def _divide(world: World) -> tuple[np.ndarray, np.ndarray]:
    """Points along the obstacles' outlines (m), no farther apart than `PART`; whose they are."""
    length = np.hypot(*(world.edges[:, 1] - world.edges[:, 0]).T)
    parts = np.maximum(np.ceil(length / PART), 1).astype(int)
    edge = np.repeat(np.arange(len(parts)), parts)
    share = ranges(np.zeros_like(parts), parts) / parts[edge]
    points = world.edges[edge, 0] + share[:, None] * (world.edges[edge, 1] - world.edges[edge, 0])
    return points, np.repeat(np.arange(len(world)), world.edge_counts)[edge]


def _lower_hull(points: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Triangles (t, 3) on the lower hull of the lifted sites, counter-clockwise."""
    # Imported here: it takes long, and only large worlds need it.
    from scipy.spatial import ConvexHull

    hull = ConvexHull(np.column_stack([points, (points**2).sum(1) - radii**2]))
    # Qhull counts in 32 bits, too few for the product that names an edge in `_find_edges`.
    triangles = hull.simplices[hull.equations[:, 2] < 0].astype(int)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    area = cross(b - a, c - a)
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return triangles[area != 0]


def _find_edges(triangles: np.ndarray, sites: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`edges`, `edges_of` and `rooms_of` of a `Triangulation` of so many sites."""
    both = np.sort(np.stack([triangles, np.roll(triangles, -1, 1)], axis=2).reshape(-1, 2), axis=1)
    edges, edges_of = np.unique(both[:, 0] * sites + both[:, 1], return_inverse=True)
    order = np.argsort(edges_of, kind="stable")
    ends = np.searchsorted(edges_of[order], [np.arange(len(edges)), np.arange(1, len(edges) + 1)])
    rooms_of = (order // 3)[np.stack([ends[0], ends[1] - 1], axis=1)]
    return np.column_stack(np.divmod(edges, sites)), edges_of.reshape(-1, 3), rooms_of
