"""The paper's planner: free segments and turning points (section 3).

The flow chart of Fig. 3 is the body of `plan`: find the safe segments, choose
the turning point, place the dangerous circle, plan the path, and as long as
there is a danger problem, solve it and come back.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import shapely

from freeseg.errors import InvalidQuery, NoPath, Trapped
from freeseg.geometry import angle_of, arc_segment_distance, arc_sweep, tangents, unit
from freeseg.path import GRAZING, Arc, Line, Path, taut_path
from freeseg.planners.tangent_graph import shortest_circles
from freeseg.robot import KheperaIV, check_positive
from freeseg.segments import MARGIN, Endpoint, find_endpoints, free_segments, group_labels
from freeseg.world import World, as_position

#: Closed forms and geometric predicates agree to this (m).
ROUND_OFF = 1e-9


@dataclass(frozen=True, eq=False)
class TurningPoint:
    """An endpoint that the path turns round, with its dangerous circle.

    Parameters
    ----------
    endpoint : Endpoint or None
        Where the path turns; None on the way round a group, which has no
        usable endpoint.
    obstacle : int
        Index of the obstacle that is turned round.
    center : ndarray, shape (2,)
        Centre of the dangerous circle (m).
    radius : float
        Radius of the dangerous circle (m): the obstacle's own plus R_D.
    sense : int
        1 counter-clockwise, -1 clockwise.
    """

    endpoint: Endpoint | None
    obstacle: int
    center: np.ndarray
    radius: float
    sense: int

    @property
    def point(self):
        """The endpoint (m), or the circle's centre where there is none."""
        return self.center if self.endpoint is None else self.endpoint.point


@dataclass(frozen=True, eq=False)
class Candidate:
    """A turning point that a step considered.

    Parameters
    ----------
    endpoint : Endpoint
        The endpoint.
    detour : float
        Length SD over the endpoint (m), equations (5) and (6).
    sense : int
        Sense of the turn that leads past the endpoint.
    rejected : str
        Why it was not chosen; empty for the chosen one.
    """

    endpoint: Endpoint
    detour: float
    sense: int
    rejected: str


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the planner, enough to draw it.

    Parameters
    ----------
    kind : str
        ``"straight"``, ``"turning point"``, ``"case 1"``, ``"case 2"``,
        ``"needless turn"`` or ``"local minimum"``.
    path : Path
        The path as planned after this step; it may still be in danger.
    blocking : int or None
        Index of the obstacle that the path before met.
    leg : ndarray, shape (2, 2) or None
        The points between which a turning point was searched (m).
    candidates : tuple of Candidate
        By increasing detour.
    group : tuple of int
        Obstacles gone round together at a local minimum.
    """

    kind: str
    path: Path
    blocking: int | None = None
    leg: np.ndarray | None = None
    candidates: tuple = ()
    group: tuple = ()

    @property
    def chosen(self):
        """The candidate that this step chose, or None."""
        return next((candidate for candidate in self.candidates if not candidate.rejected), None)


@dataclass(frozen=True, eq=False)
class Plan:
    """A path that was checked, and how it was found.

    Parameters
    ----------
    path : Path
        From start to goal, nowhere closer than R_r to an obstacle.
    segments : tuple of FreeSegment
        Safe and danger ones.
    turning_points : tuple of TurningPoint
        In driving order.
    steps : tuple of Step
        The trace.
    robot : KheperaIV
        Robot planned for.
    margin : float
        Security margin delta (m).
    """

    path: Path
    segments: tuple
    turning_points: tuple
    steps: tuple
    robot: KheperaIV
    margin: float

    @property
    def turning_radius(self):
        """Radius R_D of the dangerous circle round a point (m)."""
        return turning_radius(self.robot, self.margin)


def turning_radius(robot, margin):
    """Radius R_D = R_r + delta / 2 of the dangerous circle (m).

    An assumption, the paper gives none: two such circles just fit into the
    narrowest safe segment.
    """
    return robot.radius + margin / 2


def plan(world, start, goal, robot=None, margin=MARGIN):
    """Plan a path with free segments and turning points (Fig. 3).

    Parameters
    ----------
    world : World
        Obstacles, in the paper's order: consecutive ones are neighbours.
    start, goal : array_like, shape (2,)
        Positions p_i and p_g (m).
    robot : KheperaIV, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m); 5 mm is an assumption.

    Returns
    -------
    Plan
        Checked path and trace.

    Raises
    ------
    InvalidQuery
        For a start or goal that is not two finite numbers, is closer than
        R_r to an obstacle, or if both are the same point.
    InvalidParameter
        For a margin that is not positive.
    NoPath
        Where no path keeps the margin.

    Notes
    -----
    What the paper leaves open is completed as follows. Turns go round the
    obstacle itself (a disc's concentric circle, a polygon's corner). Each
    obstacle also has outer endpoints, see `find_endpoints`. A turn that a
    later one makes needless is dropped. Where the blocking obstacle has no
    usable endpoint, or the rules go round in circles, it and the obstacles
    within D_r + delta of each other form a group, and the path starts again
    with the shortest way round all groups met so far. Groups only grow, and
    round all obstacles that way is exact, so the search ends: with a path,
    or with the proof that there is none.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), start=(0.4, 0), goal=(0.8, 0.5))
    >>> [(turn.obstacle + 1, turn.sense) for turn in plan.turning_points]
    [(1, -1), (2, 1)]
    """
    search = _Search(world, start, goal, robot or KheperaIV(), check_positive("margin", margin))
    while (danger := search.danger()) is not None:
        search.solve(*danger)
    search.verify()
    return Plan(
        search.path,
        search.segments,
        tuple(search.turns),
        tuple(search.steps),
        search.robot,
        search.margin,
    )


@lru_cache(maxsize=16)
def _prepare(world, robot, margin):
    """What does not depend on start and goal: many queries of a world share it.

    Returns
    -------
    segments : tuple of FreeSegment
    endpoints : tuple of Endpoint
    dead_ends : frozenset of int
        Obstacles all of whose segments are danger.
    """
    segments = free_segments(world, robot, margin)
    joined = {index for segment in segments for index in segment.obstacles}
    passable = {index for segment in segments if segment.safe for index in segment.obstacles}
    return segments, find_endpoints(world, segments), frozenset(joined - passable)


class _Search:
    """State of one planning run; its methods are the boxes of Fig. 3."""

    def __init__(self, world, start, goal, robot, margin):
        self.world, self.robot, self.margin = world, robot, margin
        self.start, self.goal, reach = check_query(world, start, goal, robot, margin)
        self.segments, self.endpoints, self.dead_ends = _prepare(world, robot, margin)
        self.turning_radii = world.radii + reach
        self.turns, self.group, self.seen, self.steps = [], set(), {()}, []
        self.path, self.passed = self.connect([])
        self.record("straight")

    def record(self, kind, **details):
        """Append a step to the trace."""
        self.steps.append(Step(kind, self.path, **details))

    def connect(self, turns):
        """Path round the dangerous circles of turns."""
        return taut_path(
            self.start, [(turn.center, turn.sense * turn.radius) for turn in turns], self.goal
        )

    def danger(self):
        """The first danger problem: (piece, obstacle, distance), or None."""
        distances = self.path.distances(self.world)
        too_close = distances < self.robot.radius - ROUND_OFF
        if not too_close.any():
            return None
        number = int(np.argmax(too_close.any(1)))
        piece, met = self.path.pieces[number], np.flatnonzero(too_close[number])
        heading = np.subtract(piece.end, piece.start)
        along = [(self.world.corners[index].mean(0) - piece.start) @ heading for index in met]
        blocking = int(met[np.argmin(along)])
        return number, blocking, distances[number, blocking]

    def solve(self, number, blocking, distance):
        """Solve a danger problem: one more turning point, or a local minimum."""
        leg_number = self.passed[number]
        first = not self.turns
        leg, candidates = None, ()
        if isinstance(self.path.pieces[number], Line):
            # Section 3.2.2 searches all endpoints; a repair (3.3.1) those of the blocking obstacle.
            leg, candidates = self.rank(
                [end for end in self.endpoints if first or end.obstacle == blocking], leg_number
            )
        chosen = next((candidate for candidate in candidates if not candidate.rejected), None)
        if chosen is not None:
            turns = self.turns.copy()
            turns.insert(leg_number, self.turn(chosen.endpoint, chosen.sense))
            if self.adopt(turns):
                kind = "turning point" if first else "case 1" if distance <= 0 else "case 2"
                self.record(kind, blocking=blocking, leg=leg, candidates=candidates)
                if not self.drop_needless_turns():
                    self.go_round_group(blocking)
                return
            refused = replace(chosen, rejected="it leads back to turns tried before, or to none")
            candidates = tuple(refused if one is chosen else one for one in candidates)
        self.go_round_group(blocking, leg, candidates)

    def turn(self, endpoint, sense):
        """Turning point at an endpoint."""
        radius = float(self.turning_radii[endpoint.obstacle])
        return TurningPoint(endpoint, endpoint.obstacle, endpoint.center, radius, sense)

    def adopt(self, turns):
        """Take these turns, unless they have no path or were tried before."""
        key = tuple((turn.obstacle, *turn.center, turn.sense) for turn in turns)
        path, passed = self.connect(turns)
        if path is None or key in self.seen:
            return False
        self.seen.add(key)
        self.turns, self.path, self.passed = turns, path, passed
        return True

    def drop_needless_turns(self):
        """Drop turns that a later one made needless; False if that fails.

        Such a turn shows as an arc of more than half a turn: the taut path
        would leave its circle before it arrives there.
        """
        while needless := [
            passed
            for piece, passed in zip(self.path.pieces, self.passed, strict=True)
            if isinstance(piece, Arc) and abs(piece.sweep) > np.pi and self.turns[passed].endpoint
        ]:
            turns = [turn for number, turn in enumerate(self.turns) if number != needless[0]]
            dropped = self.turns[needless[0]].obstacle
            if not self.adopt(turns):
                return False
            self.record("needless turn", blocking=dropped)
        return True

    def rank(self, endpoints, leg_number):
        """Candidates for a turn on a leg, by increasing detour (5)-(6)."""
        before = self.turns[leg_number - 1] if leg_number else None
        after = self.turns[leg_number] if leg_number < len(self.turns) else None
        leg = np.array(
            [before.point if before else self.start, after.point if after else self.goal]
        )
        points = np.array([endpoint.point for endpoint in endpoints]).reshape(-1, 2)
        detours = np.hypot(*(points - leg[0]).T) + np.hypot(*(points - leg[1]).T)
        verdicts, middle = {}, None
        order = np.argsort(detours, kind="stable").tolist()
        for chosen in order:
            *verdicts[chosen], middle = self.examine(endpoints[chosen], before, after)
            if middle is not None:
                break
        if middle is not None and endpoints[chosen].segment is None:
            # The end of a safe segment may lie on the same turn: then that is the paper's point.
            for index in order:
                twin = endpoints[index]
                same_circle = np.array_equal(twin.center, endpoints[chosen].center)
                if twin.segment is not None and same_circle and middle @ twin.outward > 0:
                    verdicts[index] = verdicts[chosen]
                    alike = f"the end of segment {twin.segment + 1} turns alike"
                    verdicts[chosen] = verdicts[chosen][0], alike
                    break
        skipped = 0, "a shorter detour was found"
        return leg, tuple(
            Candidate(endpoints[index], float(detours[index]), *verdicts.get(index, skipped))
            for index in order
        )

    def examine(self, endpoint, before, after):
        """Sense of the turn past an endpoint, what is wrong, and where its middle is.

        The middle, as a direction from the circle's centre, is None where
        something is wrong.
        """
        index, center = endpoint.obstacle, endpoint.center
        if index in self.dead_ends:
            return 0, "all segments of its obstacle are danger", None
        radius, senses = self.turning_radii[index], np.array([1, -1])
        signed = senses * radius
        come = (before.center, before.sense * before.radius) if before else (self.start, 0.0)
        go = (after.center, after.sense * after.radius) if after else (self.goal, 0.0)
        # First row: from where the robot comes to the circle; second row: on from there.
        (_, leave), (join, _) = tangents(
            np.array([come[0], center])[:, None],
            np.array([[come[1], come[1]], signed]),
            np.array([center, go[0]])[:, None],
            np.array([signed, [go[1], go[1]]]),
        )
        if not np.isfinite([join, leave]).all(-1).all(0).any():
            return 0, "no tangent leads to its dangerous circle and on", None
        sweep, first = arc_sweep(center, senses, join, leave), angle_of(join - center)
        middle = unit(first + sweep / 2)
        # A turn past the endpoint has its middle on the endpoint's side of the obstacle.
        needed = (np.abs(sweep) > GRAZING) & (np.abs(sweep) <= np.pi)
        past = needed & (middle @ endpoint.outward > 0)
        if not past.any():
            return 0, "no turn is needed to pass there", None
        side = int(np.argmax(past))
        clearance = self.world.per_obstacle(
            arc_segment_distance(center, radius, first[side], sweep[side], self.world.edges)
        )
        if clearance.min() < self.robot.radius - ROUND_OFF:
            touched = int(np.argmin(clearance)) + 1
            return int(senses[side]), f"a turn there touches obstacle {touched}", None
        return int(senses[side]), "", middle[side]

    def go_round_group(self, blocking, leg=None, candidates=()):
        """Escape a local minimum (section 3.3.2): the shortest way round groups."""
        label = group_labels(self.world, self.robot.diameter + self.margin)
        # Normally the blocking obstacle's group is new; if not, the turns' groups, at last all.
        for met in ({blocking}, {turn.obstacle for turn in self.turns}, set(range(len(label)))):
            grown = self.group | set(np.flatnonzero(np.isin(label, label[list(met)])).tolist())
            if grown > self.group:
                break
        else:
            raise Trapped(
                f"round-off at obstacle {blocking + 1}; please report this world", self.steps
            )
        self.group = grown
        members = sorted(self.group)
        reach = self.turning_radii
        corners = [self.world.corners[index] for index in members]
        edges = [self.world.obstacles[index].edges for index in members]
        circles = (
            np.concatenate(corners),
            np.repeat(reach[members], [len(part) for part in corners]),
        )
        blockers = np.concatenate(edges), np.repeat(reach[members], [len(part) for part in edges])
        way = shortest_circles(self.start, self.goal, circles, blockers)
        if way is None:
            raise NoPath(
                f"obstacles {[index + 1 for index in members]} leave no way from "
                f"{self.start.tolist()} to {self.goal.tolist()} for a robot of "
                f"{self.robot.diameter:g} m with a margin of {self.margin:g} m; move the start or "
                "the goal, or plan for a smaller robot or margin"
            )
        owner = np.repeat(members, [len(part) for part in corners])
        self.turns = [
            TurningPoint(
                None, int(owner[index]), circles[0][index], float(circles[1][index]), sense
            )
            for index, sense in way
        ]
        self.path, self.passed = self.connect(self.turns)
        self.record(
            "local minimum", blocking=blocking, leg=leg, candidates=candidates, group=tuple(members)
        )

    def verify(self):
        """Check the path by other means: Shapely, on samples 1 mm apart."""
        distances = self.world.distances(shapely.multipoints(self.path.sample(0.001)))
        if (distances < self.robot.radius - ROUND_OFF).any():
            nearest = int(np.argmin(distances))
            raise Trapped(
                f"the path comes within {distances[nearest]:.6f} m of obstacle {nearest + 1}, "
                f"the robot's radius is {self.robot.radius:.6f} m; please report this world",
                self.steps,
            )


def check_query(world, start, goal, robot, margin):
    """Validated start and goal, and the radius left for turns.

    Returns
    -------
    start, goal : ndarray, shape (2,)
        Positions (m).
    reach : ndarray, shape (n,)
        Distance (m) that a turn keeps from each obstacle: R_D, or less where
        the start or the goal is closer than R_D, but never below R_r.
    """
    if not isinstance(world, World):
        raise InvalidQuery(f"world is {world!r}; give a World")
    start, goal = as_position(start, "start"), as_position(goal, "goal")
    if (start == goal).all():
        raise InvalidQuery(f"start and goal are the same point {start.tolist()}; move one")
    reach = np.full(len(world), turning_radius(robot, margin))
    for what, position in (("start", start), ("goal", goal)):
        distances = world.distances(shapely.Point(position))
        if (distances < robot.radius).any():
            nearest = int(np.argmin(distances))
            raise InvalidQuery(
                f"{what} {position.tolist()} is {distances[nearest]:.4f} m from obstacle "
                f"{nearest + 1}, and the robot's radius is {robot.radius:.4f} m; move it away"
            )
        # The circle must leave the position outside, by more than round-off.
        reach = np.minimum(reach, distances * (1 - ROUND_OFF))
    return start, goal, reach
