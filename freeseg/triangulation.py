"""Triangulation of a world: which obstacles are neighbours, and the rooms between them."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg.geometry import cross, read_only, unit
from freeseg.world import World

#: How often outlines are halved, at most, where the triangulation does not follow them: where they
#: cross each other it never will, and what is left there soon is short.
ROUNDS = 16

#: So many sites a corner are enough, whatever the outlines still ask for.
MOST_SITES = 20

#: How many points far outside stand round the world, so that there are rooms all round it.
RING = 8


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles between the obstacles of a world.

    Parameters
    ----------
    points : ndarray, shape (s, 2)
        Sites (m): a disc's centre, a polygon's corners and, where the
        triangulation would not follow its outline, points of its edges; and a
        ring of points far outside.
    radii : ndarray, shape (s,)
        Radii of the sites (m): a disc's own, or zero.
    obstacle : ndarray of int, shape (s,)
        Obstacle that each site belongs to, the first one where several share
        it; -1 for the ring.
    triangles : ndarray of int, shape (t, 3)
        Sites of every triangle, counter-clockwise.
    edges : ndarray of int, shape (e, 2)
        Sites of every edge, each once.
    edges_of : ndarray of int, shape (t, 3)
        Edges of every triangle; edge k joins its sites k and k + 1.
    rooms_of : ndarray of int, shape (e, 2)
        Triangles on both sides of every edge; the same one twice outside.
    walls : ndarray of bool, shape (e,)
        Whether an edge is part of an outline, or runs through a polygon.
    """

    points: np.ndarray
    radii: np.ndarray
    obstacle: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    edges_of: np.ndarray
    rooms_of: np.ndarray
    walls: np.ndarray

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
        x, y = np.asarray(point, float).tolist()
        # Walk to it from the nearest of a few triangles (E. Muecke, I. Saias, B. Zhu, "Fast
        # randomized point location", *Comput. Geom.* 12, 1999).
        some = np.arange(0, len(self.triangles), math.ceil(len(self.triangles) ** (2 / 3)))
        apart = self.points[self.triangles[some, 0]] - (x, y)
        room = int(some[np.argmin((apart**2).sum(1))])
        for _ in range(len(self.triangles)):
            a, b, c = self.points[self.triangles[room]].tolist()
            sides = [
                (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
                for p, q in ((a, b), (b, c), (c, a))
            ]
            if min(sides) >= 0:
                return room
            first, second = self.rooms_of[self.edges_of[room, np.argmin(sides)]].tolist()
            if first == second:
                break
            room = second if first == room else first
        return self._search((x, y))

    def _search(self, point: tuple[float, float]) -> int | None:
        """As `find`, but looking at all triangles."""
        corners = self.points[self.triangles]
        inside = (cross(np.roll(corners, -1, 1) - corners, point - corners) >= 0).all(1)
        return int(np.argmax(inside)) if inside.any() else None


@lru_cache(maxsize=4)
def triangulate(world: World) -> Triangulation:
    """Power triangulation of a world's obstacles.

    The Delaunay triangulation weighted with the squared radii: its edges part
    unequal discs, and a disc that meets no other is never left out. It is the
    lower hull of the sites lifted to x^2 + y^2 - r^2 (F. Aurenhammer, "Power
    diagrams", *SIAM J. Comput.* 16, 1987). Outlines that it does not follow are
    halved until it does. A world is triangulated once and remembered.

    Parameters
    ----------
    world : World
        Obstacles.

    Returns
    -------
    Triangulation
    """
    points, radii, obstacle, outlines = _place_sites(world)
    if len(outlines):
        new, owner, outlines = _split_where_they_meet(points, outlines, world.round_off)
        points, radii = np.concatenate([points, new]), np.append(radii, np.zeros(len(new)))
        obstacle = np.append(obstacle, obstacle[owner])
    corners = len(points)
    middle = (points.min(0) + points.max(0)) / 2
    extent = np.ptp(points, axis=0).max()
    # Room for a robot also where there is hardly any obstacle, but not so much that round-off
    # would swallow a tiny world.
    extent += min(1.0, 1000 * (extent + radii.max()))
    ring = middle + 4 * extent * unit(2 * np.pi * (np.arange(RING) + 0.3) / RING)
    points = np.concatenate([points, ring])
    radii = np.append(radii, np.zeros(RING))
    obstacle = np.append(obstacle, np.full(RING, -1))
    for halved in range(ROUNDS + 1):
        triangles = _lower_hull((points - middle) / extent, radii / extent)
        missing = _missing(world, points, outlines, triangles)
        if not missing.any() or halved == ROUNDS or len(points) > MOST_SITES * (corners + RING):
            break
        tails, heads = outlines[missing].T
        halfway = _halfway(points, tails, heads, corners)
        new, added = _merge(points, halfway, world.round_off)
        points, radii = np.concatenate([points, halfway[added]]), np.append(radii, 0.0 * added)
        obstacle = np.append(obstacle, obstacle[tails[added]])
        parts = np.column_stack([tails, new]), np.column_stack([new, heads])
        outlines = _each_once(np.concatenate([outlines[~missing], *parts]))
    edges, edges_of, rooms_of = _find_edges(triangles, len(points))
    walls = _find_walls(world, points, edges, outlines, missing)
    arrays = points, radii, obstacle, triangles, edges, edges_of, rooms_of, walls
    return Triangulation(*map(read_only, arrays))


def _place_sites(world: World) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centres and corners (s, 2), their radii and obstacles (s,), and pairs on outlines (k, 2)."""
    owner = np.repeat(np.arange(len(world)), world.edge_counts)
    tails = world.edges[:, 0]
    corners = np.flatnonzero(world.edge_counts[owner] > 1)
    # Where outlines meet in a corner, they share a site.
    _, first, alike = np.unique(tails[corners] @ (1, 1j), return_index=True, return_inverse=True)
    same = np.arange(len(tails))
    same[corners] = corners[first[alike]]
    kept = np.flatnonzero(same == np.arange(len(tails)))
    number = np.searchsorted(kept, same)
    outlines = number[np.column_stack([corners, world.following_edge[corners]])]
    return tails[kept], world.radii[owner[kept]], owner[kept], _each_once(outlines)


def _split_where_they_meet(
    points: np.ndarray, outlines: np.ndarray, gap: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Outlines cut where they cross, and where a corner of one lies on another.

    Halving alone would not get there: of two lines that cross, a triangulation
    without a site at the crossing follows one at most.

    Returns
    -------
    new : ndarray, shape (k, 2)
        Where they cross (m): sites to be counted on from the old ones.
    owner : ndarray of int, shape (k,)
        An old site on the outline of each.
    outlines : ndarray of int, shape (m, 2)
        Pairs of sites, old and new.
    """
    lines = shapely.linestrings(points[outlines])
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=gap)
    apart = (outlines[first][:, :, None] != outlines[second][:, None]).all((1, 2))
    first, second = first[apart], second[apart]
    along = np.diff(points[outlines[first]], axis=1)
    length = np.hypot(*along[:, 0].T)
    # Ends of the second line, in the frame of the first: along it and to its left (m).
    ends = points[outlines[second]] - points[outlines[first, :1]]
    ahead = (ends * along).sum(2) / length[:, None]
    left = cross(along, ends) / length[:, None]
    pair, end = np.nonzero((abs(left) <= gap) & (ahead > gap) & (ahead < length[:, None] - gap))

    beyond = (left.min(1) < -gap) & (left.max(1) > gap)
    share = left[:, 0] / np.where(beyond, left[:, 0] - left[:, 1], 1)
    crossed = ahead[:, 0] + share * (ahead[:, 1] - ahead[:, 0])
    at = np.flatnonzero(beyond & (crossed > gap) & (crossed < length - gap))
    place = points[outlines[first[at], 0]] + (crossed / length)[at, None] * along[at, 0]
    number, added = _merge(points, place, gap)
    whole = np.arange(len(outlines))
    # Which line, how far along it (m), and the site there; first and last its own ends.
    edge = np.concatenate([whole, first[pair], first[at], whole])
    way = np.concatenate([0.0 * whole, ahead[pair, end], crossed[at], np.inf + whole])
    site = np.concatenate([outlines[:, 0], outlines[second[pair], end], number, outlines[:, 1]])
    order = np.lexsort([way, edge])
    edge, site = edge[order], site[order]
    on = edge[1:] == edge[:-1]
    split = np.column_stack([site[:-1][on], site[1:][on]])
    return place[added], outlines[first[at[added]], 0], _each_once(split)


def _halfway(points: np.ndarray, tails: np.ndarray, heads: np.ndarray, corners: int) -> np.ndarray:
    """Points (k, 2) that halve parts of outlines, by and large.

    A part that begins at a corner, one of the first sites, is cut at a power of
    two, so that the cuts of both edges there are level and ask for no further
    ones (J. Ruppert, *J. Algorithms* 18, 1995).
    """
    along = points[heads] - points[tails]
    length = np.hypot(*along.T)
    share = 2 ** np.round(np.log2(length / 2)) / length
    from_tail, from_head = tails < corners, heads < corners
    share = np.where(from_tail == from_head, 0.5, np.where(from_tail, share, 1 - share))
    return points[tails] + share[:, None] * along


def _merge(points: np.ndarray, new: np.ndarray, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Which sites new ones (k, 2) become, and which of them are added after those there are.

    One that is at most `gap` (m) from another is the same: outlines that lie on each
    other are cut at the same places.
    """
    # Imported here: it takes long, and only large worlds need it.
    from scipy.spatial import KDTree

    everything = np.concatenate([points, new])
    _, near = KDTree(everything).query(new, k=4, distance_upper_bound=gap)
    # Beyond the end stands for none; the new site itself is among its neighbours.
    own = len(points) + np.arange(len(new))
    same = np.minimum(near.min(1), own)
    # Of a row of such neighbours, only the first two are taken for one.
    later = np.maximum(same - len(points), 0)
    same = np.where((same < len(points)) | (same[later] == own[later]), same, own)
    added = np.flatnonzero(same == own)
    number = np.append(np.arange(len(points)), np.zeros(len(new), int))
    number[own[added]] = len(points) + np.arange(len(added))
    return number[same], added


def _each_once(outlines: np.ndarray) -> np.ndarray:
    """Pairs of different sites (k, 2), each once whatever its order."""
    outlines = outlines[outlines[:, 0] != outlines[:, 1]]
    _, first = np.unique(np.sort(outlines, axis=1) @ (1, 1j), return_index=True)
    return outlines[np.sort(first)]


def _missing(
    world: World, points: np.ndarray, outlines: np.ndarray, triangles: np.ndarray
) -> np.ndarray:
    """Which parts of outlines are no edges of triangles though they should be, shape (k,)."""
    sides = np.stack([triangles, np.roll(triangles, -1, 1)], axis=2).reshape(-1, 2)
    missing = ~np.isin(_name(outlines, len(points)), _name(sides, len(points)))
    discs = np.flatnonzero(world.radii)
    if missing.any() and len(discs):
        # Within a disc there is nothing to follow, and its weight hides sites there.
        number = np.flatnonzero(missing)
        tree = shapely.STRtree(world.cores[discs])
        inside = []
        for end in points[outlines[number]].transpose(1, 0, 2):
            near = shapely.points(end)
            which, disc = tree.query(near, predicate="dwithin", distance=world.radii.max())
            apart = np.hypot(*(end[which] - world.edges[world.first_edge[discs[disc]], 0]).T)
            covered = apart <= world.radii[discs[disc]]
            inside.append(which[covered] * len(discs) + disc[covered])
        missing[number[np.intersect1d(*inside) // len(discs)]] = False
    return missing


def _name(pairs: np.ndarray, sites: int) -> np.ndarray:
    """A number for every pair of so many sites, in either order."""
    return pairs.min(1) * sites + pairs.max(1)


def _find_walls(
    world: World,
    points: np.ndarray,
    edges: np.ndarray,
    outlines: np.ndarray,
    missing: np.ndarray,
) -> np.ndarray:
    """Which edges are part of outlines, or run through polygons, shape (e,)."""
    walls = np.isin(_name(edges, len(points)), _name(outlines, len(points)))
    if not len(outlines):
        return walls
    # All of an edge that crosses no outline is where its middle is.
    open_ones = np.flatnonzero(~walls)
    middles = points[edges[open_ones]].mean(1)
    which, met = world.tree.query(shapely.points(middles))
    solid = world.edge_counts[met] > 1
    which, cores = which[solid], world.cores[met[solid]]
    shapely.prepare(cores)
    walls[open_ones[which[shapely.intersects_xy(cores, *middles[which].T)]]] = True
    if missing.any():
        lines, sides = points[outlines[missing]], points[edges]
        tree = shapely.STRtree(shapely.linestrings(sides))
        which, side = tree.query(shapely.linestrings(lines))
        walls[side[_crosses(lines[which], sides[side]) & _crosses(sides[side], lines[which])]] = (
            True
        )
    return walls


def _crosses(lines: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether the ends of the other lie on both sides of each line (k, 2, 2), shape (k,)."""
    along = (lines[:, 1] - lines[:, 0])[:, None]
    sides = cross(along, others - lines[:, :1])
    return sides.min(1) * sides.max(1) < 0


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
    both = np.stack([triangles, np.roll(triangles, -1, 1)], axis=2).reshape(-1, 2)
    edges, edges_of = np.unique(_name(both, sites), return_inverse=True)
    order = np.argsort(edges_of, kind="stable")
    ends = np.searchsorted(edges_of[order], [np.arange(len(edges)), np.arange(1, len(edges) + 1)])
    rooms_of = (order // 3)[np.stack([ends[0], ends[1] - 1], axis=1)]
    return np.column_stack(np.divmod(edges, sites)), edges_of.reshape(-1, 3), rooms_of
