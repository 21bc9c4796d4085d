"""Shortest way round some obstacles: a graph of tangents and arcs that grows.

A shortest path of a disc among obstacles consists of common tangents of the
obstacles' dangerous circles and arcs on them (see J.-C. Latombe, *Robot Motion
Planning*, 1991, on generalised visibility graphs), so a search over those finds it.
"""

from itertools import groupby

import numpy as np

from freeseg.geometry import (
    angle_of,
    point_segment_distance,
    ranges,
    tangents,
    touching_points,
    unit,
)

#: A tangent may come closer to a circle than its radius by round-off (m).
ROUND_OFF = 1e-10

#: So many lines, and edges in their way, are compared at once: what fits into a processor's cache,
#: and most lines fall to the first edges.
LINES, EDGES = 1024, 32


def _near(points, segments, reach):
    """Which points are nearer than `reach` to which segments, shape (points, segments).

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
    return beside < reach**2


def _cross(a, b):
    """Which segments properly cross which, shape (a, b)."""

    def parts(lines, others):
        along = lines[:, 1] - lines[:, 0]
        across = np.column_stack([-along[:, 1], along[:, 0]])
        level = (across * lines[:, 0]).sum(1)[:, None]
        return (across @ others[:, 0].T > level) != (across @ others[:, 1].T > level)

    return parts(a, b) & parts(b, a).T


def unblocked(lines, edges, reach):
    """Which lines keep away from all edges.

    Parameters
    ----------
    lines : ndarray, shape (m, 2, 2)
        Both ends of every line (m).
    edges : ndarray, shape (k, 2, 2)
        Segments (m); the outlines of obstacles, or points.
    reach : ndarray, shape (k,)
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
            left = left[~_hit(lines[left], edges[some], reach[some] - ROUND_OFF)]
            begin, batch = begin + batch, 2 * batch
        free.append(left)
    return np.concatenate(free) if free else np.empty(0, int)


def _hit(lines, edges, keep):
    """Which lines are too close to any of the edges, shape (m,)."""
    hit = _near(edges[:, 0], lines, keep[:, None]).any(0)
    is_long = (edges[:, 0] != edges[:, 1]).any(1)
    if is_long.any():
        edges, keep = edges[is_long], keep[is_long]
        hit |= _near(edges[:, 1], lines, keep[:, None]).any(0) | _cross(edges, lines).any(0)
        for end in (0, 1):
            hit |= _near(lines[:, end], edges, keep).any(1)
    return hit


class TangentGraph:
    """Tangents of dangerous circles and arcs on them.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        First and last point (m), to be kept away from by no edge.
    """

    def __init__(self, start, goal):
        # The start and the goal are circles 0 and 1, of radius zero.
        self.centers, self.radii = np.array([start, goal], float), np.zeros(2)
        self.edges, self.reach = np.empty((0, 2, 2)), np.empty(0)
        # A tangent is kept once for both ways; the senses are those of driving from its first end.
        self.circles, self.senses = np.array([[0, 1]]), np.array([[1, 1]])
        self.lines = self.centers[None].copy()
        # Where a circle is closed: directions from its centre, in every part that is too close
        # to some edge.
        self.closed_circle, self.closed_angle = np.empty(0, int), np.empty(0)

    def add(self, centers, radii, edges, reach):
        """Add circles to go round and edges to keep away from.

        Parameters
        ----------
        centers, radii : ndarray, shape (c, 2) and (c,)
            Dangerous circles (m).
        edges, reach : ndarray, shape (k, 2, 2) and (k,)
            Segments and the distance to keep from each (m).
        """
        old_circles, old_edges = len(self.radii), len(self.reach)
        left = unblocked(self.lines, edges, reach)
        self.circles, self.senses = self.circles[left], self.senses[left]
        self.lines = self.lines[left]
        self.centers = np.concatenate([self.centers, centers])
        self.radii = np.concatenate([self.radii, radii])
        self.edges = np.concatenate([self.edges, edges])
        self.reach = np.concatenate([self.reach, reach])
        self._close(np.arange(old_circles), slice(old_edges, None))
        self._close(np.arange(old_circles, len(self.radii)), slice(None))

        # Every pair of a new circle with one before it, in all pairs of senses.
        new = np.arange(old_circles, len(self.radii))
        pairs = np.column_stack([np.repeat(new, new), ranges(np.zeros_like(new), new)])
        circles = np.repeat(pairs, 4, axis=0)
        senses = np.tile([[1, 1], [1, -1], [-1, 1], [-1, -1]], (len(pairs), 1))
        # A point is driven round one way.
        once = (self.radii[circles[:, 1]] > 0) | (senses[:, 1] > 0)
        circles, senses = circles[once], senses[once]
        center, signed = self.centers[circles], senses * self.radii[circles]
        ends = tangents(center[:, 0], signed[:, 0], center[:, 1], signed[:, 1])
        lines = np.stack(ends, axis=1)
        exists = np.flatnonzero(np.isfinite(lines).all((1, 2)))
        free = exists[unblocked(lines[exists], self.edges, self.reach)]
        self.circles = np.concatenate([self.circles, circles[free]])
        self.senses = np.concatenate([self.senses, senses[free]])
        self.lines = np.concatenate([self.lines, lines[free]])

    def _close(self, circles, which):
        """Find where circles are too close to edges.

        The distance to an edge, driven round a circle, is smallest at points
        known in closed form, and each closed part has such a point.
        """
        circles = circles[self.radii[circles] > 0]
        if not len(circles):
            return
        edges, reach = self.edges[which], self.reach[which]
        apart = point_segment_distance(self.centers[circles][:, None], edges)
        row, edge = np.nonzero(apart < self.radii[circles][:, None] + reach)
        center, radius = self.centers[circles[row]], self.radii[circles[row]]
        on_edge = touching_points(center, radius, edges[edge])
        direction = angle_of(on_edge - center[:, None])
        on_circle = center[:, None] + radius[:, None, None] * unit(direction)
        gap = point_segment_distance(on_circle, edges[edge][:, None])
        closed, nearest = np.nonzero(gap < reach[edge][:, None] - ROUND_OFF)
        self.closed_circle = np.concatenate([self.closed_circle, circles[row[closed]]])
        self.closed_angle = np.concatenate([self.closed_angle, direction[closed, nearest]])

    def shortest(self):
        """Circles that the shortest path goes round.

        Returns
        -------
        list of (int, int) or None
            Circle, in the order of adding, and sense (1 counter-clockwise, -1
            clockwise) in driving order; None where there is no path at all.
        """
        # Imported here: it takes as long as all the rest of the package, and few plans need it.
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        # Both ways of every tangent; node k is where tangent k leaves, k + count where it joins.
        circle = np.concatenate([self.circles, self.circles[:, ::-1]])
        sense = np.concatenate([self.senses, -self.senses[:, ::-1]])
        line = np.concatenate([self.lines, self.lines[:, ::-1]])
        count = len(line)
        length = np.hypot(*(line[:, 1] - line[:, 0]).T)
        node_circle, node_sense = circle.T.ravel(), sense.T.ravel()
        offset = line.transpose(1, 0, 2).reshape(-1, 2) - self.centers[node_circle]
        round_circle = np.flatnonzero(node_circle > 1)

        # On every oriented circle an arc leads from each node to the next, unless the circle is
        # closed between them: sorted together, a node follows a node.
        closed = np.tile(self.closed_circle, 2)
        way = np.repeat([1, -1], len(self.closed_circle))
        owner = np.concatenate([node_circle[round_circle], closed])
        way = np.concatenate([node_sense[round_circle], way])
        angle = np.concatenate([angle_of(offset[round_circle]), np.tile(self.closed_angle, 2)])
        name = np.concatenate([round_circle, np.full(len(closed), -1)])
        owner, turned = 2 * owner + (way < 0), np.mod(way * angle, 2 * np.pi)
        order = np.lexsort([turned, owner])
        owner, turned, name = owner[order], turned[order], name[order]
        links = [(np.arange(count), np.arange(count) + count, length)]
        if len(order):
            begins = np.flatnonzero(np.r_[True, owner[1:] != owner[:-1]])
            following = np.arange(1, len(order) + 1)
            ends = np.r_[begins[1:], len(order)] - 1
            following[ends] = begins
            sweep = turned[following] - turned
            sweep[ends] += 2 * np.pi
            is_arc = (name >= 0) & (name[following] >= 0) & (following != np.arange(len(order)))
            links.append(
                (
                    name[is_arc],
                    name[following][is_arc],
                    (self.radii[owner // 2] * sweep)[is_arc],
                )
            )
        # The start and the goal are one node each, whichever tangent leaves or joins there.
        begin, finish = 2 * count, 2 * count + 1
        leave, join = np.flatnonzero(circle[:, 0] == 0), np.flatnonzero(circle[:, 1] == 1) + count
        links.append((np.full_like(leave, begin), leave, np.zeros(len(leave))))
        links.append((join, np.full_like(join, finish), np.zeros(len(join))))
        source, target, weight = (np.concatenate(part) for part in zip(*links, strict=True))
        order = np.argsort(source, kind="stable")
        rows = np.searchsorted(source[order], np.arange(2 * count + 3))
        graph = csr_array((weight[order], target[order], rows), shape=(2 * count + 2,) * 2)
        distance, before = dijkstra(graph, indices=begin, return_predecessors=True)
        if not np.isfinite(distance[finish]):
            return None
        visited, node = [], before[finish]
        while node != begin:
            if node_circle[node] > 1:
                visited.append((int(node_circle[node]) - 2, int(node_sense[node])))
            node = before[node]
        # Several nodes in a row on one circle are one turn; the circle may come again later.
        return [turn for turn, _ in groupby(reversed(visited))]
