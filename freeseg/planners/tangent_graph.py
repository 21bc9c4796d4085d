"""Shortest way round a few obstacles: a graph of tangents and arcs.

A shortest path of a disc among obstacles consists of common tangents of the
obstacles' dangerous circles and arcs on them (see J.-C. Latombe, *Robot Motion
Planning*, 1991, on generalised visibility graphs), so a search over those finds it.
"""

from itertools import groupby

import numpy as np

from freeseg.geometry import (
    angle_of,
    arc_segment_distance,
    segment_segment_distance,
    tangents,
)

#: A tangent may come closer to a circle than its radius by round-off (m).
ROUND_OFF = 1e-10


def shortest_circles(start, goal, circles, blockers):
    """Oriented circles that the shortest free path goes round.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        First and last point (m).
    circles : centers (c, 2), radii (c,)
        Dangerous circles (m) that the path may go round either way.
    blockers : edges (k, 2, 2), reach (k,)
        Segments (m) and the distance (m) that the path keeps from each.

    Returns
    -------
    list of (int, int) or None
        Circle index and sense (1 counter-clockwise, -1 clockwise) in driving
        order; None where there is no free path at all.
    """
    # Imported here: it takes as long as all the rest of the package, and few plans need it.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    centers, radii = circles
    edges, reach = blockers
    keep = reach - ROUND_OFF
    # Oriented circles: start, every circle counter-clockwise, every circle clockwise, goal.
    center = np.concatenate([[start], centers, centers, [goal]])
    signed = np.concatenate([[0], radii, -radii, [0]])
    last = len(signed) - 1

    tail, head = (index.ravel() for index in np.indices((last + 1, last + 1)))
    apart = (tail != head) & (head != 0) & (tail != last)
    tail, head = tail[apart], head[apart]
    leave, join = tangents(center[tail], signed[tail], center[head], signed[head])
    lines = np.stack([leave, join], axis=1)
    free = np.isfinite(lines).all((1, 2))
    free[free] = (segment_segment_distance(lines[free][:, None], edges) >= keep).all(1)
    tail, head, lines = tail[free], head[free], lines[free]

    # A graph node is an end of a tangent: 2k where tangent k leaves, 2k + 1 where it joins.
    node_circle = np.stack([tail, head], axis=1).ravel()
    node_point = lines.reshape(-1, 2)
    tangent = np.arange(len(lines))
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    links = [(2 * tangent, 2 * tangent + 1, length)]

    # On every oriented circle, an arc leads from each node to the next in the sense of driving.
    round_circle = np.flatnonzero((node_circle != 0) & (node_circle != last))
    sense = np.sign(signed[node_circle])
    direction = angle_of(node_point - center[node_circle])
    turned = np.mod(sense * direction, 2 * np.pi)
    order = round_circle[np.lexsort([turned[round_circle], node_circle[round_circle]])]
    if len(order):
        owner = node_circle[order]
        first_of_run = np.r_[True, owner[1:] != owner[:-1]]
        run_start = np.maximum.accumulate(np.where(first_of_run, np.arange(len(order)), 0))
        is_last = np.r_[first_of_run[1:], True]
        following = order[np.where(is_last, run_start, np.arange(len(order)) + 1)]
        sweep = turned[following] - turned[order] + 2 * np.pi * is_last
        radius = np.abs(signed[owner])
        clear = arc_segment_distance(
            center[owner][:, None],
            radius[:, None],
            direction[order][:, None],
            (sense[order] * sweep)[:, None],
            edges,
        )
        open_arc = (clear >= keep).all(1) & (order != following)
        links.append((order[open_arc], following[open_arc], (radius * sweep)[open_arc]))

    # The start and the goal are one point each, whichever tangent leaves or joins there.
    nodes = 2 * len(lines)
    begin = np.flatnonzero(node_circle == 0)
    finish = np.flatnonzero(node_circle == last)
    links.append((np.full_like(begin, nodes), begin, np.zeros(len(begin))))
    links.append((finish, np.full_like(finish, nodes + 1), np.zeros(len(finish))))
    source, target, weight = (np.concatenate(part) for part in zip(*links, strict=True))
    graph = coo_array((weight, (source, target)), shape=(nodes + 2, nodes + 2))
    distance, before = dijkstra(graph.tocsr(), indices=nodes, return_predecessors=True)
    if not np.isfinite(distance[nodes + 1]):
        return None
    visited, node = [], before[nodes + 1]
    while node != nodes:
        visited.append(node_circle[node])
        node = before[node]
    # Several nodes in a row on one circle are one turn; the circle may come again later.
    return [
        (int(number - 1) % len(radii), int(np.sign(signed[number])))
        for number, _ in groupby(reversed(visited))
        if number not in (0, last)
    ]
