"""Free segments at scale: from room to room through safe segments.

In a triangulation of the obstacles every edge between two of them is a free
segment and every triangle is a room. The shortest way from room to room is
searched first; then the path is pulled taut round the dangerous circles at
the ends of the segments that it passes.
"""

import math
from functools import lru_cache

import numpy as np

from freeseg.errors import Trapped
from freeseg.geometry import cross, point_segment_distance, ranges
from freeseg.planners.query import (
    Step,
    TurningPoint,
    needless_turns,
    repair_kind,
    turning_radius,
)
from freeseg.segments import Endpoint, make_segments
from freeseg.triangulation import triangulate

#: How much longer than the straight line the way may become, as a share of that line: at first,
#: and where that is not enough.
EXCESS = (1 / 16, 1 / 2, np.inf)


@lru_cache(maxsize=4)
def _rooms(world, robot, margin):
    """Graph of the rooms, for all queries of a world.

    A node is one end of a safe segment, where the robot passes it close to
    the obstacle there; links join ends of two safe edges of one triangle.

    Returns
    -------
    triangulation : Triangulation
    places : ndarray, shape (e, 2, 2)
        For both ends of every edge, where the robot passes it (m).
    safe : ndarray of bool, shape (e,)
        Whether the edge is a safe segment.
    heads : ndarray of int, shape (k,)
        Node, 2 e + end, that every link leads to; sorted by where from.
    begins : ndarray of int, shape (2 e + 1,)
        Where in `heads` the links of each node begin.
    """
    rooms = triangulate(world)
    ends, radii = rooms.points[rooms.edges], rooms.radii[rooms.edges]
    across = ends[:, 1] - ends[:, 0]
    length = np.hypot(*across.T)
    gap = length - radii.sum(1)
    # Edges between parts of one obstacle are walls, also across bays: no way leads out of these.
    first, second = rooms.obstacle[rooms.edges].T
    safe = (gap >= robot.diameter + margin) & ((first != second) | (first < 0))
    # Beside the obstacle, but not beyond the middle of the gap.
    beside = np.minimum(turning_radius(robot, margin), gap / 2)[:, None] + radii
    across /= length[:, None]
    places = np.stack(
        [ends[:, 0] + beside[:, :1] * across, ends[:, 1] - beside[:, 1:] * across], axis=1
    )
    # The three pairs of a triangle's edges, both ways, and both ends of each edge.
    pairs = rooms.edges_of[:, [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]]].reshape(-1, 2)
    pairs = pairs[safe[pairs].all(1)]
    nodes = 2 * pairs[:, None] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    nodes = nodes.reshape(-1, 2)
    tails, heads = nodes[np.argsort(nodes[:, 0], kind="stable")].T
    begins = np.searchsorted(tails, np.arange(2 * len(places) + 1))
    return rooms, places, safe, heads, begins


def search_rooms(query, steps):
    """Path through safe segments, from room to room.

    Parameters
    ----------
    query : Query
        What is asked.
    steps : list of Step
        The trace, to which the search appends.

    Returns
    -------
    turns : list of TurningPoint
        In driving order.
    segments : tuple of FreeSegment
        Those that the way leads through.

    Raises
    ------
    Trapped
        Where no way leads from room to room, or its path could not be freed
        of danger.
    """
    if query.danger(steps[-1].path) is None:
        return [], ()
    rooms, places, safe, *links = _rooms(query.world, query.robot, query.margin)
    first, last = rooms.find(query.start), rooms.find(query.goal)
    if first is not None and first == last:
        return _solve_dangers(query, [], steps), ()
    edges = None
    if first is not None and last is not None:
        edges = _find_way(query, places, safe, links, rooms.edges_of[[first, last]])
    if edges is None:
        raise Trapped(
            "no safe segments between different obstacles lead from the start to the goal; ask "
            "fs.shortest_path, which tries every way, or plan for a smaller robot or margin",
            steps,
        )
    # The sites to the left and to the right of every segment passed.
    sites = _orient(rooms, edges, first)
    required = query.robot.diameter + query.margin
    segments = make_segments(
        rooms.obstacle[sites], rooms.points[sites], rooms.radii[sites], required
    )
    reach = np.append(query.turning_radii, 0.0)[rooms.obstacle[sites]] * (1, -1)
    turns = []
    for number, side in pull_taut(query.start, rooms.points[sites], reach, query.goal):
        ends, site = segments[number].ends, sites[number, side]
        across = (ends[1 - side] - ends[side]) / segments[number].length
        obstacle, center = int(rooms.obstacle[site]), rooms.points[site]
        endpoint = Endpoint(ends[side], across, obstacle, number, center)
        radius = float(abs(reach[number, side]))
        turns.append(TurningPoint(endpoint, obstacle, center, radius, 1 - 2 * side))
    return _solve_dangers(query, turns, steps), segments


def _solve_dangers(query, turns, steps):
    """Add turns where the path is in danger (section 3.3.1), drop those it does not need."""
    seen, kind, blocking = set(), "rooms", None
    while True:
        path, passed = query.connect(turns)
        key = tuple((*turn.center.tolist(), turn.sense) for turn in turns)
        if path is None or key in seen:
            raise Trapped(
                "the way through the safe segments is too narrow at some turn; ask "
                "fs.shortest_path, which tries every way",
                steps,
            )
        seen.add(key)
        steps.append(Step(kind, path, blocking=blocking))
        if needless := needless_turns(path, passed):
            turns = [turn for number, turn in enumerate(turns) if number not in needless]
            kind, blocking = "needless turn", None
            continue
        danger = query.danger(path)
        if danger is None:
            return turns
        number, blocking, distance = danger
        # The corner that is deepest in the way, turned round on the side where the path is.
        piece, corners = path.pieces[number], query.world.corners[blocking]
        begin, end = np.array(piece.start), np.array(piece.end)
        center = corners[np.argmin(point_segment_distance(corners, np.stack([begin, end])))]
        sense = 1 if cross(end - begin, center - begin) > 0 else -1
        radius = float(query.turning_radii[blocking])
        kind = repair_kind(distance)
        turns = turns.copy()
        turns.insert(passed[number], TurningPoint(None, blocking, center, radius, sense))


def _find_way(query, places, safe, links, rooms):
    """Edges passed on the shortest way from room to room, in order, or None.

    A* (P. Hart, N. Nilsson, B. Raphael, 1968) as Dijkstra's search with every
    length reduced by what the link gains towards the goal.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    heads, begins = links
    points = places.reshape(-1, 2)
    to_goal = np.hypot(*(points - query.goal).T)
    from_start = np.hypot(*(points - query.start).T)
    straight = math.dist(query.start, query.goal)
    # The start is one more node; the goal is reached from the nodes of its room.
    leave, arrive = ((2 * edges[safe[edges], None] + [0, 1]).ravel() for edges in rooms)
    begin = len(points)
    for excess in EXCESS:
        # No node outside of this ellipse is on a way that is at most so much longer.
        inside = from_start + to_goal <= (1 + excess) * straight
        nodes = np.flatnonzero(inside)
        counts = begins[nodes + 1] - begins[nodes]
        tail, head = np.repeat(nodes, counts), heads[ranges(begins[nodes], counts)]
        tail, head = tail[inside[head]], head[inside[head]]
        first = leave[inside[leave]]
        gain = np.hypot(*(points[tail] - points[head]).T) + to_goal[head] - to_goal[tail]
        gain = np.concatenate([gain, from_start[first] + to_goal[first] - straight])
        rows = np.append(np.bincount(tail, minlength=begin), len(first))
        graph = csr_array(
            (
                # Not zero, which would be no link; by round-off it may be below.
                np.maximum(gain, 1e-12),
                np.concatenate([head, first]),
                np.concatenate([[0], np.cumsum(rows)]),
            ),
            shape=(begin + 1, begin + 1),
        )
        cost, before = dijkstra(graph, indices=begin, return_predecessors=True)
        shortest = cost[arrive].min(initial=np.inf)
        if np.isfinite(shortest) and shortest <= excess * straight:
            break
    else:
        return None
    edges, node = [], arrive[np.argmin(cost[arrive])]
    while node != begin:
        edges.append(node // 2)
        node = before[node]
    return np.array(edges[::-1])


def _orient(rooms, edges, room):
    """Sites to the left and right of edges passed one after the other from a room, (k, 2)."""
    sites = []
    for edge in edges:
        triangle = rooms.triangles[room]
        place = int(np.flatnonzero(rooms.edges_of[room] == edge)[0])
        # Counter-clockwise round the room, an edge leads from its right to its left site.
        sites.append((triangle[(place + 1) % 3], triangle[place]))
        pair = rooms.rooms_of[edge]
        room = pair[0] if pair[1] == room else pair[1]
    return np.array(sites)


def pull_taut(start, centers, signed, goal):
    """Turns of the shortest path through gaps between pairs of circles.

    The funnel algorithm (D. Lee, F. Preparata, "Euclidean shortest paths in
    the presence of rectilinear barriers", *Networks* 14, 1984) with oriented
    circles for points (D. Demyen, M. Buro, "Efficient triangulation-based
    pathfinding", AAAI 2006).

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        First and last point (m).
    centers : ndarray, shape (k, 2, 2)
        Centres of the circles to the left and right of every gap (m), in
        driving order.
    signed : ndarray, shape (k, 2)
        Their radii (m), negative to the right.

    Returns
    -------
    list of (int, int)
        Gap and side (0 left, 1 right) of every circle that is turned round.
    """
    start, goal = np.asarray(start, float).tolist(), np.asarray(goal, float).tolist()
    circles = [(start, 0.0, None)]
    for number, (pair, radii) in enumerate(zip(centers.tolist(), signed.tolist(), strict=True)):
        circles += [(pair[side], radii[side], (number, side)) for side in (0, 1)]
    circles.append((goal, 0.0, None))

    def heading(a, b):
        """Direction (rad) of the tangent between two oriented circles."""
        (x_a, y_a), signed_a, _ = a
        (x_b, y_b), signed_b, _ = b
        apart = math.hypot(x_b - x_a, y_b - y_a)
        # Out of range where they overlap; then the path will not pass the check.
        sine = min(max((signed_b - signed_a) / apart, -1), 1)
        return math.atan2(y_b - y_a, x_b - x_a) - math.asin(sine)

    def turn(first, second):
        return math.remainder(second - first, 2 * math.pi)

    # Both sides of the funnel, from its apex on, and what the path has turned round before.
    chains, done = ([circles[0]], [circles[0]]), []
    for circle in circles[1:]:
        sides = (circle[2][1],) if circle[2] else (0,)
        for side in sides:
            chain, other, sign = chains[side], chains[1 - side], 1 - 2 * side
            # Nothing to turn round on the ring outside.
            if circle[2] and not circle[1]:
                continue
            # To the left a chain bends to the left; what would bend it back falls away.
            while (
                len(chain) > 1
                and circle[0] != chain[-1][0]
                and sign * turn(heading(chain[-2], chain[-1]), heading(chain[-1], circle)) < 0
            ):
                chain.pop()
            # Nor anew where a segment shares its end, or one after the next does.
            if circle[0] == chain[-1][0]:
                continue
            if len(chain) == 1:
                # The side may even pass over to the other: then the apex moves on along that one.
                while (
                    len(other) > 1
                    and sign * turn(heading(other[0], other[1]), heading(other[0], circle)) < 0
                ):
                    done.append(other[1])
                    other.pop(0)
                chain[0] = other[0]
            chain.append(circle)
    return [circle[2] for circle in [*done, *chains[0][1:-1]]]
