"""Shortest route round some obstacles: a graph of tangents and arcs that grows.

A shortest path of a disc among obstacles consists of common tangents of the
obstacles' dangerous circles and arcs on them (see J.-C. Latombe, *Robot Motion
Planning*, 1991, on generalised visibility graphs), so a search over those finds it.
"""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freeseg.geometry import (
    angle_of,
    point_segment_distance,
    ranges,
    read_only,
    tangents,
    touching_points,
    unit,
)

#: A tangent may come closer to a circle than its radius by round-off (m).
TOLERANCE = 1e-10

#: So many lines, and edges that may block them, are compared at once: what fits into a
#: processor's cache, and most lines fall to the first edges.
LINES, EDGES = 1024, 32


def _near(points: np.ndarray, segments: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Which points are nearer than `within` to which segments, shape (points, segments).

    `point_segment_distance` in the fewest passes over memory: this is where
    an exact plan spends its time.
    """
    along = segments[:, 1] - segments[:, 0]
    length = np.hypot(along[:, 0], along[:, 1])
    along[length == 0] = 1.0, 0.0
    along /= np.where(length == 0, 1.0, length)[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    middle = segments.mean(1)
    beside = points @ across.T
    beside -= (across * middle).sum(1)
    beyond = points @ along.T
    beyond -= (along * middle).sum(1)
    np.abs(beyond, out=beyond)
    beyond -= length / 2
    np.maximum(beyond, 0, out=beyond)
    beside *= beside
    beyond *= beyond
    beside += beyond
    return beside < within**2


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Which segments properly cross which, shape (a, b)."""

    def parts(lines: np.ndarray, others: np.ndarray) -> np.ndarray:
        along = lines[:, 1] - lines[:, 0]
        across = np.column_stack([-along[:, 1], along[:, 0]])
        level = (across * lines[:, 0]).sum(1)[:, None]
        return (across @ others[:, 0].T > level) != (across @ others[:, 1].T > level)

    return parts(a, b) & parts(b, a).T


def unblocked(lines: np.ndarray, edges: np.ndarray, keep_clear: np.ndarray) -> np.ndarray:
    """Which lines keep away from all edges.

    Parameters
    ----------
    lines : ndarray, shape (m, 2, 2)
        Both ends of every line (m).
    edges : ndarray, shape (k, 2, 2)
        Segments (m); the outlines of obstacles, or points.
    keep_clear : ndarray, shape (k,)
        How far to keep from each (m).

    Returns
    -------
    ndarray of int
        Indices of the lines that do.
    """
    free = []
    for first in range(0, len(lines), LINES):
        left = np.arange(first, min(first + LINES, len(lines)))
        # Most lines end at the edges nearest to where they begin.
        away = edges[:, 0] - lines[left, 0].mean(0)
        order = np.argsort((away**2).sum(1))
        begin, batch = 0, EDGES
        while begin < len(order) and len(left):
            some = order[begin : begin + batch]
            left = left[~_hit(lines[left], edges[some], keep_clear[some] - TOLERANCE)]
            begin, batch = begin + batch, 2 * batch
        free.append(left)
    return np.concatenate(free) if free else np.empty(0, int)


def _hit(lines: np.ndarray, edges: np.ndarray, within: np.ndarray) -> np.ndarray:
    """Which lines are too close to any of the edges, shape (m,)."""
    hit = np.zeros(len(lines), bool)
    hit |= _near(edges[:, 0], lines, within[:, None]).any(0)
    is_long = (edges[:, 0] != edges[:, 1]).any(1)
    if is_long.any():
        edges, within = edges[is_long], within[is_long]
        hit |= _near(edges[:, 1], lines, within[:, None]).any(0) | _cross(edges, lines).any(0)
        for end in (0, 1):
            hit |= _near(lines[:, end], edges, within).any(1)
    return hit


class TangentGraph:
    """Tangents of dangerous circles and arcs on them.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        First and last point (m), to be kept away from by no edge.
    """

    def __init__(self, start: ArrayLike, goal: ArrayLike) -> None:
        # The start and the goal are circles 0 and 1, of radius zero.
        self.centers, self.radii = np.array([start, goal], float), np.zeros(2)
        self.edges, self.keep_clear = np.empty((0, 2, 2)), np.empty(0)
        # A tangent is kept once for both directions; the senses are those of driving from its first
        # end.
        self.circles, self.senses = np.array([[0, 1]]), np.array([[1, 1]])
        self.lines = self.centers[None].copy()
        # Where a circle is closed: directions from its centre, in every part that is too close
        # to some edge.
        self.closed_circle, self.closed_angle = np.empty(0, int), np.empty(0)

    def add(
        self, centers: np.ndarray, radii: np.ndarray, edges: np.ndarray, keep_clear: np.ndarray
    ) -> None:
        """Add circles to go round and edges to keep away from.

        Parameters
        ----------
        centers, radii : ndarray, shape (c, 2) and (c,)
            Dangerous circles (m).
        edges, keep_clear : ndarray, shape (k, 2, 2) and (k,)
            Segments and the distance to keep from each (m).
        """
        old_circles, old_edges = len(self.radii), len(self.edges)
        left = unblocked(self.lines, edges, keep_clear)
        self.circles, self.senses = self.circles[left], self.senses[left]
        self.lines = self.lines[left]
        self.centers = read_only(np.concatenate([self.centers, centers]))
        self.radii = np.concatenate([self.radii, radii])
        self.edges = np.concatenate([self.edges, edges])
        self.keep_clear = np.concatenate([self.keep_clear, keep_clear])
        self._close(np.arange(old_circles), slice(old_edges, None))
        new = np.arange(old_circles, len(self.radii))
        self._close(new, slice(None))
        self._add_tangents(new)

    def _add_tangents(self, new: np.ndarray) -> None:
        """Add the free tangents of new circles with each other and with those before."""
        # Every pair of a new circle with one before it, in all pairs of senses.
        pairs = np.column_stack([np.repeat(new, new), ranges(np.zeros_like(new), new)])
        circles = np.repeat(pairs, 4, axis=0)
        senses = np.tile([[1, 1], [1, -1], [-1, 1], [-1, -1]], (len(pairs), 1))
        # Both senses round a point are one.
        once = (self.radii[circles[:, 1]] > 0) | (senses[:, 1] > 0)
        circles, senses = circles[once], senses[once]
        center, signed = self.centers[circles], senses * self.radii[circles]
        ends = tangents(center[:, 0], signed[:, 0], center[:, 1], signed[:, 1])
        lines = np.stack(ends, axis=1)
        exists = np.flatnonzero(np.isfinite(lines).all((1, 2)))
        free = exists[unblocked(lines[exists], self.edges, self.keep_clear)]
        self.circles = np.concatenate([self.circles, circles[free]])
        self.senses = np.concatenate([self.senses, senses[free]])
        self.lines = np.concatenate([self.lines, lines[free]])

    def _close(self, circles: np.ndarray, which: slice) -> None:
        """Find where circles are too close to edges.

        The distance to an edge, driven round a circle, is smallest at points
        known in closed form, and each closed part has such a point.
        """
        circles = circles[self.radii[circles] > 0]
        if not len(circles):
            return
        edges, keep_clear = self.edges[which], self.keep_clear[which]
        apart = point_segment_distance(self.centers[circles][:, None], edges)
        row, edge = np.nonzero(apart < self.radii[circles][:, None] + keep_clear)
        center, radius = self.centers[circles[row]], self.radii[circles[row]]
        on_edge = touching_points(center, radius, edges[edge])
        direction = angle_of(on_edge - center[:, None])
        on_circle = center[:, None] + radius[:, None, None] * unit(direction)
        gap = point_segment_distance(on_circle, edges[edge][:, None])
        closed, nearest = np.nonzero(gap < keep_clear[edge][:, None] - TOLERANCE)
        self.closed_circle = np.concatenate([self.closed_circle, circles[row[closed]]])
        self.closed_angle = np.concatenate([self.closed_angle, direction[closed, nearest]])

    def shortest(self) -> list[tuple[int, int]] | None:
        """Circles that the shortest path goes round.

        Returns
        -------
        list of (int, int) or None
            Circle, in the order of adding, and sense (1 counter-clockwise, -1
            clockwise) in driving order; None where there is no path at all.
        """
        ends = self._ends()
        count = len(ends.length)
        # The start and the goal are one node each, whichever tangent leaves or joins there.
        begin, finish = 2 * count, 2 * count + 1
        leave = np.flatnonzero(ends.circle[:count] == 0)
        join = np.flatnonzero(ends.circle[count:] == 1) + count
        links = [
            (np.arange(count), np.arange(count) + count, ends.length),
            self._arcs(ends),
            (np.full_like(leave, begin), leave, np.zeros(len(leave))),
            (join, np.full_like(join, finish), np.zeros(len(join))),
        ]
        nodes = _search(links, begin, finish)
        if nodes is None:
            return None
        visited = [(int(ends.circle[node]) - 2, int(ends.sense[node])) for node in nodes]
        # Several nodes in a row on one circle are one turn; the circle may come again later.
        return [turn for turn, _ in groupby(visited) if turn[0] >= 0]

    def _ends(self) -> "_Ends":
        """Ends of all tangents, driven in both directions."""
        circle = np.concatenate([self.circles, self.circles[:, ::-1]])
        sense = np.concatenate([self.senses, -self.senses[:, ::-1]])
        line = np.concatenate([self.lines, self.lines[:, ::-1]])
        length = np.hypot(*(line[:, 1] - line[:, 0]).T)
        point = line.transpose(1, 0, 2).reshape(-1, 2)
        return _Ends(circle.T.ravel(), sense.T.ravel(), point, length)

    def _arcs(self, ends: "_Ends") -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Arcs from node to next node on every oriented circle, unless it is closed between.

        Returns
        -------
        tail, head : ndarray of int, shape (k,)
            Node where each arc begins, and where it ends.
        length : ndarray, shape (k,)
            Its length (m).
        """
        # Sorted together with the directions that are closed, whose node is -1, a node follows a
        # node wherever the circle is open between them. The start and the goal have no arcs.
        on_circle, closed = np.flatnonzero(ends.circle > 1), len(self.closed_circle)
        direction = angle_of(ends.point[on_circle] - self.centers[ends.circle[on_circle]])
        node = np.concatenate([on_circle, np.full(2 * closed, -1)])
        circle = np.concatenate([ends.circle[on_circle], np.tile(self.closed_circle, 2)])
        sense = np.concatenate([ends.sense[on_circle], np.repeat([1, -1], closed)])
        angle = np.concatenate([direction, np.tile(self.closed_angle, 2)])
        oriented, turned = 2 * circle + (sense < 0), np.mod(sense * angle, 2 * np.pi)
        order = np.lexsort([turned, oriented])
        node, oriented, turned = node[order], oriented[order], turned[order]
        # The last of a circle is followed by its first, a turn later.
        first = np.flatnonzero(np.diff(oriented, prepend=-1))
        last = np.flatnonzero(np.diff(oriented, append=-1))
        following = np.arange(1, len(order) + 1)
        following[last] = first
        sweep = turned[following] - turned
        sweep[last] += 2 * np.pi
        is_arc = (node >= 0) & (node[following] >= 0) & (following != np.arange(len(order)))
        length = self.radii[oriented // 2] * sweep
        return node[is_arc], node[following][is_arc], length[is_arc]


class _Ends(NamedTuple):
    """Ends of m tangents: node k is where tangent k leaves, node k + m where it joins.

    Their circle, sense and point (m) have 2 m rows; the tangents' length (m) has m.
    """

    circle: np.ndarray
    sense: np.ndarray
    point: np.ndarray
    length: np.ndarray


def _search(
    links: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], begin: int, finish: int
) -> list[int] | None:
    """Nodes between two on the shortest route along links, in order, or None; Dijkstra's search.

    Parameters
    ----------
    links
        Tails, heads and lengths (m) of several kinds of links.
    begin, finish : int
        The last two nodes.
    """
    # Imported here: it takes as long as all the rest of the package, and few plans need it.
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    tail, head, length = (np.concatenate(part) for part in zip(*links, strict=True))
    order = np.argsort(tail, kind="stable")
    rows = np.searchsorted(tail[order], np.arange(finish + 2))
    graph = csr_array((length[order], head[order], rows), shape=(finish + 1, finish + 1))
    distance, before = dijkstra(graph, indices=begin, return_predecessors=True)
    if not np.isfinite(distance[finish]):
        return None
    nodes, node = [], before[finish]
    while node != begin:
        nodes.append(int(node))
        node = before[node]
    return nodes[::-1]
