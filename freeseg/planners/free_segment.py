"""The paper's planner: free segments and turning points (section 3).

The flow chart of Fig. 3 is the body of `plan`: find the safe segments, choose
the turning point, place the dangerous circle, plan the path, and as long as
there is a danger problem, solve it and come back.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from freeseg.errors import InvalidParameter, Trapped
from freeseg.geometry import angle_of, arc_segment_distance, arc_sweep, tangents, unit
from freeseg.path import GRAZING, Line
from freeseg.planners.query import (
    ROUND_OFF,
    Candidate,
    Plan,
    Step,
    TurningPoint,
    ask,
    needless_turns,
    repair_kind,
)
from freeseg.planners.rooms import search_rooms
from freeseg.planners.shortest import ShortestWay, shortest_path
from freeseg.segments import MARGIN, find_endpoints, free_segments, group_labels


def plan(world, start, goal, robot=None, margin=MARGIN, neighbours="chain", complete=True):
    """Plan a path with free segments and turning points (Fig. 3).

    Parameters
    ----------
    world : World
        Obstacles; for ``neighbours="chain"`` in the paper's order.
    start, goal : array_like, shape (2,)
        Positions p_i and p_g (m).
    robot : KheperaIV, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m); 5 mm is an assumption. Where the start or
        the goal is closer to an obstacle than R_D, the circles round that
        obstacle shrink to the distance there.
    neighbours : {"chain", "delaunay"}, optional
        Which obstacles free segments join: consecutive ones, as published;
        or neighbours in a triangulation, which suits any world, also a large
        one.
    complete : bool, optional
        Whether `shortest_path` decides where the search through a
        triangulation fails. By default it does, for who asks for a path
        wants it wherever there is one; say no to study the search itself.

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
        For a margin that is not positive, or neighbours that are not known.
    NoPath
        Where it is proved that no path keeps the margin.
    Trapped
        Where the search fails and is not to be completed; with its trace.

    Notes
    -----
    What the paper leaves open is completed as follows. Turns go round the
    obstacle itself (a disc's concentric circle, a polygon's corner). Each
    obstacle also has outer endpoints, see `find_endpoints`. A turn that a
    later one makes needless is dropped. Where all segments of the blocking
    obstacle are danger, where it has no usable endpoint, where an arc and
    not a line is in danger, or where the rules go round in circles, it and
    the obstacles within D_r + delta of each other form a group, and the path
    starts again with the shortest way round all groups met so far. Groups
    only grow, and round all obstacles that way is exact, so the search ends:
    with a path, or with the proof that there is none. `literal_plan` does
    without all this.

    With a triangulation, the shortest way from room to room through safe
    segments comes first, see `search_rooms`; what prepares a world for that
    is remembered, so that further queries of the same world are faster.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), start=(0.4, 0), goal=(0.8, 0.5))
    >>> [(turn.obstacle + 1, turn.sense) for turn in plan.turning_points]
    [(1, -1), (2, 1)]
    """
    query = ask(world, start, goal, robot, margin)
    searches = {"chain": _search_chain, "delaunay": search_rooms}
    if neighbours not in list(searches):  # not in the dict, for it may have no hash
        raise InvalidParameter(f"neighbours is {neighbours!r}; give 'chain' or 'delaunay'")
    steps = [Step("straight", query.connect([])[0])]
    try:
        turns, segments = searches[neighbours](query, steps)
        path = steps[-1].path
        query.verify(path, steps)
    except Trapped:
        if not complete:
            raise
        best = shortest_path(world, start, goal, robot, margin)
        path, turns, segments = best.path, best.turning_points, ()
        steps += best.steps[1:]  # the straight line is there already
    return Plan(path, segments, tuple(turns), tuple(steps), query.robot, query.margin)


def _search_chain(query, steps):
    """Turns of the paper's search, and all free segments; `steps` grows."""
    search = _Search(query, steps)
    while (danger := query.danger(search.path)) is not None:
        search.solve(*danger)
    return search.turns, search.segments


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

    def __init__(self, query, steps):
        self.query, self.world, self.robot = query, query.world, query.robot
        self.segments, self.endpoints, self.dead_ends = _prepare(
            query.world, query.robot, query.margin
        )
        self.turns, self.group, self.seen, self.steps = [], set(), {()}, steps
        self.way = ShortestWay(query)
        self.path, self.passed = query.connect([])

    def record(self, kind, **details):
        """Append a step to the trace."""
        self.steps.append(Step(kind, self.path, **details))

    def solve(self, number, blocking, distance):
        """Solve a danger problem: one more turning point, or a local minimum."""
        leg_number = self.passed[number]
        first = not self.turns
        leg, candidates = None, ()
        if isinstance(self.path.pieces[number], Line) and blocking not in self.dead_ends:
            # Section 3.2.2 searches all endpoints; a repair (3.3.1) those of the blocking obstacle.
            leg, candidates = self.rank(
                [end for end in self.endpoints if first or end.obstacle == blocking], leg_number
            )
        chosen = next((candidate for candidate in candidates if not candidate.rejected), None)
        if chosen is not None:
            turns = self.turns.copy()
            turns.insert(leg_number, self.turn(chosen.endpoint, chosen.sense))
            if self.adopt(turns):
                kind = "turning point" if first else repair_kind(distance)
                self.record(kind, blocking=blocking, leg=leg, candidates=candidates)
                if not self.drop_needless_turns():
                    self.go_round_group(blocking)
                return
            refused = replace(chosen, rejected="it leads back to turns tried before, or to none")
            candidates = tuple(refused if one is chosen else one for one in candidates)
        self.go_round_group(blocking, leg, candidates)

    def turn(self, endpoint, sense):
        """Turning point at an endpoint."""
        radius = float(self.query.turning_radii[endpoint.obstacle])
        return TurningPoint(endpoint, endpoint.obstacle, endpoint.center, radius, sense)

    def adopt(self, turns):
        """Take these turns, unless they have no path or were tried before."""
        key = tuple((turn.obstacle, *turn.center, turn.sense) for turn in turns)
        path, passed = self.query.connect(turns)
        if path is None or key in self.seen:
            return False
        self.seen.add(key)
        self.turns, self.path, self.passed = turns, path, passed
        return True

    def drop_needless_turns(self):
        """Drop turns that a later one made needless; False if that fails."""
        while needless := [
            number
            for number in needless_turns(self.path, self.passed)
            if self.turns[number].endpoint
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
            [
                before.point if before else self.query.start,
                after.point if after else self.query.goal,
            ]
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
        radius, senses = self.query.turning_radii[index], np.array([1, -1])
        signed = senses * radius
        come = (before.center, before.sense * before.radius) if before else (self.query.start, 0.0)
        go = (after.center, after.sense * after.radius) if after else (self.query.goal, 0.0)
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
        label = group_labels(self.world, self.robot.diameter + self.query.margin)
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
        self.turns = self.way.go_round(grown)
        self.path, self.passed = self.query.connect(self.turns)
        details = {"blocking": blocking, "leg": leg, "candidates": candidates}
        self.record("local minimum", group=tuple(sorted(grown)), **details)
