"""Free segments at scale: from room to room through safe segments.

In a triangulation of the obstacles every edge between two of them is a free
segment and every triangle is a room. The shortest route from room to room is
searched first; then the path is pulled taut round the dangerous circles at
the ends of the segments that it passes.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freeseg.errors import Trapped
from freeseg.geometry import cross, point_segment_distance, ranges, read_only
from freeseg.path import Arc, Line
from freeseg.plan import Plan, Step, StepKind, TurningPoint, turning_radius
from freeseg.planners.query import Query, ask, needless_turns
from freeseg.robot import Robot
from freeseg.segments import MARGIN, Endpoint, FreeSegment, make_segments
from freeseg.triangulation import Triangulation, triangulate
from freeseg.world import ROUND_OFF, World

#: How much longer than the straight line the route may become, as a share of that line: at first,
#: and where that is not enough.
EXCESS = (1 / 16, 1 / 2, np.inf)


class _RoomGraph(NamedTuple):
    """Graph of the rooms, for all queries of a world.

    A node is one end of a safe segment, where the robot passes it close to
    the obstacle there, and the room that it comes to; links join the ends of
    two safe edges of that room.

    Parameters
    ----------
    mesh : Triangulation
        e edges.
    places : ndarray, shape (e, 2, 2)
        For both ends of every edge, where the robot passes it (m).
    safe : ndarray of bool, shape (e,)
        Whether the edge is a safe segment.
    heads : ndarray of int, shape (k,)
        Node, 4 edge + 2 side + end, that every link leads to; sorted by where
        from. The side is that of the room which is entered, as in `rooms_of`.
    begins : ndarray of int, shape (4 e + 1,)
        Where in `heads` the links of each node begin.
    """

    mesh: Triangulation
    places: np.ndarray
    safe: np.ndarray
    heads: np.ndarray
    begins: np.ndarray

    def leaving(self, room: int) -> np.ndarray:
        """Nodes to which one comes out of a room."""
        edges = self.mesh.edges_of[room]
        edges = edges[self.safe[edges]]
        entered = (self.mesh.rooms_of[edges, 0] == room).astype(int)
        return (4 * edges[:, None] + 2 * entered[:, None] + [0, 1]).ravel()

    def entering(self, room: int) -> np.ndarray:
        """Nodes from which one comes into a room."""
        # The other side of each edge.
        return self.leaving(room) ^ 2


@lru_cache(maxsize=4)
def _prepare(world: World, robot: Robot, margin: float) -> _RoomGraph:
    """Graph of the rooms of a world."""
    mesh = triangulate(world)
    ends, radii = mesh.points[mesh.edges], mesh.radii[mesh.edges]
    across = ends[:, 1] - ends[:, 0]
    length = np.hypot(*across.T)
    gap = length - radii.sum(1)
    required = robot.diameter + margin
    # Nothing leads out of the ring.
    rim = mesh.rooms_of[:, 0] == mesh.rooms_of[:, 1]
    safe = (gap >= required) & ~mesh.walls & ~rim
    # Beside the obstacle, but not beyond the middle of the gap.
    beside = np.minimum(turning_radius(robot, margin), gap / 2)[:, None] + radii
    with np.errstate(invalid="ignore"):
        across /= length[:, None]
    places = np.stack(
        [ends[:, 0] + beside[:, :1] * across, ends[:, 1] - beside[:, 1:] * across], axis=1
    )
    heads, begins = _link(mesh, safe, required)
    return _RoomGraph(mesh, places, safe, heads, begins)


def _link(mesh: Triangulation, safe: np.ndarray, required: float) -> tuple[np.ndarray, np.ndarray]:
    """`heads` and `begins` of a `_RoomGraph`."""
    # The three pairs of a room's edges, in both directions, and both ends of each edge.
    pairs = mesh.edges_of[:, [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]]]
    passable = safe[pairs].all(2) & _are_wide(mesh, required)[:, [0, 1, 2, 0, 1, 2]]
    room, turn = np.nonzero(passable)
    tail, head = pairs[room, turn].T
    tail = 4 * tail + 2 * (mesh.rooms_of[tail, 1] == room)
    head = 4 * head + 2 * (mesh.rooms_of[head, 0] == room)
    nodes = np.column_stack([tail, head])[:, None] + [[0, 0], [0, 1], [1, 0], [1, 1]]
    nodes = nodes.reshape(-1, 2)
    tails, heads = nodes[np.argsort(nodes[:, 0], kind="stable")].T
    return heads, np.searchsorted(tails, np.arange(4 * len(mesh.edges) + 1))


def _are_wide(mesh: Triangulation, required: float) -> np.ndarray:
    """Where the robot fits between a room's corner and the wall opposite, shape (t, 3).

    Column k is of the corner that edges k and k + 1 share.
    """
    corner = mesh.points[mesh.triangles[:, [1, 2, 0]]]
    opposite = mesh.edges_of[:, [2, 0, 1]]
    width = point_segment_distance(corner, mesh.points[mesh.edges[opposite]])
    width -= mesh.radii[mesh.triangles[:, [1, 2, 0]]]
    return (width >= required) | ~mesh.walls[opposite]


def plan_rooms(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> Plan:
    """Plan from room to room through safe segments, in any world, also a large one.

    Parameters
    ----------
    world : World
        Obstacles, in any order.
    start, goal, robot, margin
        As for `plan`.

    Returns
    -------
    Plan
        Checked path and trace. Its segments are those that the path was led
        through, without the open space outside.

    Raises
    ------
    InvalidQuery, InvalidParameter
        As for `plan`.
    Trapped
        Where no route leads from room to room, or its path could not be freed
        of danger; with the trace. That proves nothing: `with_fallback` lets
        another planner decide.

    Notes
    -----
    The shortest route from room to room through safe segments comes first,
    then the path is pulled taut along it, and dangers that are left are
    repaired (section 3.3.1). What prepares a world for that is remembered, so
    that further queries of the same world are faster.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = plan_rooms(fs.random_world(100, seed=0), (0, 0), (3.3, 3.3))
    >>> len(plan.segments) > len(plan.turning_points) > 0
    True
    """
    query = ask(world, start, goal, robot, margin)
    path = query.straight_line()
    steps = [Step(StepKind.STRAIGHT, path)]
    turns: list[TurningPoint] = []
    segments: tuple[FreeSegment, ...] = ()
    if query.danger(path) is not None:
        turns, segments = _lead_through_rooms(query, steps)
        turns = _solve_dangers(query, turns, steps)
    path = steps[-1].path
    return query.answer(path, segments, turns, steps)


def _lead_through_rooms(
    query: Query, steps: list[Step]
) -> tuple[list[TurningPoint], tuple[FreeSegment, ...]]:
    """Turns of the taut path along the shortest route, and the segments that it passes."""
    graph = _prepare(query.world, query.robot, query.margin)
    first, last = graph.mesh.find(query.start), graph.mesh.find(query.goal)
    if first is not None and first == last:
        return [], ()
    edges = None
    if first is not None and last is not None:
        edges = _find_route(query, graph, first, last)
    if first is None or edges is None:
        raise Trapped(
            "no safe segments lead from the start to the goal; ask "
            "fs.shortest_path, which tries every route, or plan for a smaller robot or margin",
            steps,
        )
    return _pull_through(query, graph.mesh, _orient(graph.mesh, edges, first))


def _pull_through(
    query: Query, mesh: Triangulation, sites: np.ndarray
) -> tuple[list[TurningPoint], tuple[FreeSegment, ...]]:
    """Turns of the taut path between sites (k, 2) on its left and right, and the segments."""
    required = query.robot.diameter + query.margin
    passed = make_segments(mesh.obstacle[sites], mesh.points[sites], mesh.radii[sites], required)
    # One that ends in the ring outside joins no two obstacles.
    inner = (mesh.obstacle[sites] >= 0).all(1)
    index = np.cumsum(inner) - 1
    signed = np.append(query.turning_radii, 0.0)[mesh.obstacle[sites]] * (1, -1)
    turns = []
    slack = query.round_off / 10
    for gap, side in pull_taut(query.start, mesh.points[sites], signed, query.goal, slack):
        ends, site = passed[gap].ends, sites[gap, side]
        outward = read_only((ends[1 - side] - ends[side]) / passed[gap].length)
        obstacle, center = int(mesh.obstacle[site]), mesh.points[site]
        segment = int(index[gap]) if inner[gap] else None
        endpoint = Endpoint(ends[side], outward, obstacle, segment, center)
        radius = float(abs(signed[gap, side]))
        turns.append(TurningPoint(endpoint, obstacle, center, radius, 1 - 2 * side))
    return turns, tuple(segment for segment, kept in zip(passed, inner, strict=True) if kept)


def _solve_dangers(
    query: Query, turns: list[TurningPoint], steps: list[Step]
) -> list[TurningPoint]:
    """Add turns where the path is in danger (section 3.3.1), drop those it does not need."""
    seen: set[tuple] = set()
    kind, blocking = StepKind.ROOMS, None
    while True:
        path, passed = query.connect(turns)
        key = tuple((*turn.center.tolist(), turn.sense) for turn in turns)
        if path is None or key in seen:
            raise Trapped(
                "the route through the safe segments is too narrow at some turn; ask "
                "fs.shortest_path, which tries every route",
                steps,
            )
        seen.add(key)
        steps.append(Step(kind, path, blocking=blocking))
        if needless := needless_turns(path, passed):
            turns = [turn for index, turn in enumerate(turns) if index not in needless]
            kind, blocking = StepKind.NEEDLESS_TURN, None
        elif danger := query.danger(path):
            piece, blocking, distance = danger
            kind = StepKind.of_danger(distance)
            turns = turns.copy()
            if not len(query.world.corners[blocking]):
                raise Trapped(
                    f"the route comes too close to {query.world.name_of(blocking)}, which has no "
                    "corner to turn round; ask fs.shortest_path, which tries every route",
                    steps,
                )
            turns.insert(passed[piece], _turn_round(query, blocking, path.pieces[piece]))
        else:
            return turns


def _turn_round(query: Query, blocking: int, piece: Line | Arc) -> TurningPoint:
    """Turn round the corner that blocks a piece most, on the side where the path is."""
    corners, begin, end = query.world.corners[blocking], np.array(piece.start), np.array(piece.end)
    center = corners[np.argmin(point_segment_distance(corners, np.stack([begin, end])))]
    sense = 1 if cross(end - begin, center - begin) > 0 else -1
    return TurningPoint(None, blocking, center, float(query.turning_radii[blocking]), sense)


def _find_route(query: Query, graph: _RoomGraph, first: int, last: int) -> np.ndarray | None:
    """Edges passed on the shortest route from room to room, in order, or None.

    A* (P. Hart, N. Nilsson, B. Raphael, 1968) as Dijkstra's search with every
    length reduced by what the link gains towards the goal.
    """
    # The start is one more node; the goal is reached from the nodes of its room.
    leave, arrive = graph.leaving(first), graph.entering(last)
    places = np.repeat(graph.places, 2, axis=0).reshape(-1, 2)
    points = np.concatenate([places, query.start[None]])
    heads = np.concatenate([graph.heads, leave])
    begins = np.append(graph.begins, len(heads))
    to_goal, from_start = (np.hypot(*(points - end).T) for end in (query.goal, query.start))
    straight = to_goal[-1]
    for excess in EXCESS:
        # No node outside of this ellipse is on a route that is at most so much longer.
        inside = from_start + to_goal <= (1 + excess) * straight
        cost, before = _search(points, heads, begins, inside, to_goal)
        shortest = cost[arrive].min(initial=np.inf)
        if np.isfinite(shortest) and shortest <= excess * straight:
            break
    else:
        return None
    edges, node = [], arrive[np.argmin(cost[arrive])]
    while node != len(points) - 1:
        edges.append(node // 4)
        node = before[node]
    return np.array(edges[::-1])


def _search(
    points: np.ndarray,
    heads: np.ndarray,
    begins: np.ndarray,
    inside: np.ndarray,
    to_goal: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Reduced length from the last node to every one inside, and the node before each."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    nodes = np.flatnonzero(inside)
    counts = begins[nodes + 1] - begins[nodes]
    tail, head = np.repeat(nodes, counts), heads[ranges(begins[nodes], counts)]
    tail, head = tail[inside[head]], head[inside[head]]
    gain = np.hypot(*(points[tail] - points[head]).T) + to_goal[head] - to_goal[tail]
    rows = np.cumsum(np.bincount(tail, minlength=len(points)))
    # Round-off may leave less than nothing, and Dijkstra's search wants no negative length.
    links = np.maximum(gain, 0), head, np.append(0, rows)
    graph = csr_array(links, shape=(len(points), len(points)))
    return dijkstra(graph, indices=len(points) - 1, return_predecessors=True)


def _orient(mesh: Triangulation, edges: np.ndarray, room: int) -> np.ndarray:
    """Sites to the left and right of edges passed one after the other from a room, (k, 2)."""
    sites = []
    for edge in edges:
        triangle = mesh.triangles[room]
        side = int(np.flatnonzero(mesh.edges_of[room] == edge)[0])
        # Counter-clockwise round the room, an edge leads from its right to its left site.
        sites.append((triangle[(side + 1) % 3], triangle[side]))
        pair = mesh.rooms_of[edge]
        room = pair[0] if pair[1] == room else pair[1]
    return np.array(sites)


class _Circle(NamedTuple):
    """An oriented circle (m), and the gap and side that it bounds; a point has neither."""

    x: float
    y: float
    signed_radius: float
    bounds: tuple[int, int] | None = None

    def is_at(self, other: "_Circle") -> bool:
        """Whether both have the same centre."""
        return (self.x, self.y) == (other.x, other.y)

    def apart_from(self, other: "_Circle") -> float:
        """Distance (m) of the centres."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def heading_to(self, other: "_Circle") -> float:
        """Direction (rad) of the tangent between both."""
        apart = self.apart_from(other)
        if apart == 0:
            # There is none; then there will be no path.
            return 0.0
        # Out of range where they overlap; then the path will not pass the check.
        sine = min(max((other.signed_radius - self.signed_radius) / apart, -1), 1)
        return math.atan2(other.y - self.y, other.x - self.x) - math.asin(sine)


def _bend(first: _Circle, middle: _Circle, last: _Circle) -> float:
    """Angle by which a taut path over three circles turns to the left, times the shorter leg (m).

    So far, by and large, is the middle one from where the path would be without it.
    """
    angle = math.remainder(middle.heading_to(last) - first.heading_to(middle), 2 * math.pi)
    return angle * min(first.apart_from(middle), middle.apart_from(last))


class _Funnel:
    """Both sides of the funnel, each from its apex on, and the circles turned round before."""

    def __init__(self, start: _Circle, slack: float) -> None:
        self.chains = [start], [start]
        self.behind: list[_Circle] = []
        self.slack = slack

    def add(self, circle: _Circle, side: int) -> None:
        """Take a circle into the left (0) or the right (1) side."""
        chain, other, sign = self.chains[side], self.chains[1 - side], 1 - 2 * side
        # A left chain bends to the left; what would bend it back, or by round-off only, falls away.
        while (
            len(chain) > 1
            and not circle.is_at(chain[-1])
            and sign * _bend(chain[-2], chain[-1], circle) <= self.slack
        ):
            chain.pop()
        # Nothing new where a segment shares its end with the one before, or one after that does.
        if circle.is_at(chain[-1]):
            return
        if len(chain) == 1:
            # The side may even pass over to the other: then the apex moves on along that one.
            while len(other) > 1 and self._passes_over(other, circle, sign):
                other.pop(0)
                self.behind.append(other[0])
            chain[0] = other[0]
        chain.append(circle)

    @staticmethod
    def _passes_over(other: list[_Circle], circle: _Circle, sign: int) -> bool:
        """Whether the direction to a circle lies beyond the first leg of the other side."""
        turned = other[0].heading_to(circle) - other[0].heading_to(other[1])
        return sign * math.remainder(turned, 2 * math.pi) < 0


def pull_taut(
    start: ArrayLike,
    centers: np.ndarray,
    signed: np.ndarray,
    goal: ArrayLike,
    slack: float = ROUND_OFF / 10,
) -> list[tuple[int, int]]:
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
        Their radii (m), negative to the right; zero where there is nothing
        to turn round.
    slack : float, optional
        What bends the path by less (m) is round-off, and no turn.

    Returns
    -------
    list of (int, int)
        Gap and side (0 left, 1 right) of every circle that is turned round.
    """
    first, last = (_Circle(x, y, 0.0) for x, y in np.array([start, goal], float).tolist())
    funnel = _Funnel(first, slack)
    for gap, (pair, radii) in enumerate(zip(centers.tolist(), signed.tolist(), strict=True)):
        for side in (0, 1):
            if radii[side]:
                x, y = pair[side]
                funnel.add(_Circle(x, y, radii[side], (gap, side)), side)
    funnel.add(last, 0)
    return [circle.bounds for circle in [*funnel.behind, *funnel.chains[0][1:-1]] if circle.bounds]
