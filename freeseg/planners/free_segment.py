"""The paper's planner: free segments and turning points (section 3).

The flow chart of Fig. 3 is the body of `plan`: find the safe segments, choose
the turning point, place the dangerous circle, plan the path, and as long as
there is a danger problem, solve it and come back.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from freeseg.errors import Trapped
from freeseg.geometry import angle_of, arc_sweep, tangents, unit
from freeseg.path import GRAZING, Arc, Line, Path
from freeseg.plan import Candidate, Effort, Plan, Step, StepKind, TurningPoint
from freeseg.planners.query import Query, ask, detour_lengths, needless_turns
from freeseg.planners.route import shortest_route
from freeseg.robot import Robot
from freeseg.segments import (
    MARGIN,
    Endpoint,
    FreeSegment,
    find_endpoints,
    free_segments,
    group_labels,
)
from freeseg.world import World


def plan(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> Plan:
    """Plan a path with free segments and turning points (Fig. 3).

    Parameters
    ----------
    world : World
        Obstacles, in the paper's order: consecutive ones are neighbours. The
        boundary, if there is one, is in no order with them.
    start, goal : array_like, shape (2,)
        Positions p_i and p_g (m).
    robot : Robot, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m); 5 mm is an assumption. Where the start or
        the goal is closer to an obstacle than R_D, the circles round that
        obstacle shrink to the distance there. Turns keep R_D, straight lines
        only R_r, see below.

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
        For a robot that is none, or a margin that is negative or not finite.
    NoPath
        Where it is proved that no path keeps the margin.
    Trapped
        Where round-off keeps the search from a path that passes the check.

    Notes
    -----
    What the paper leaves open is completed as follows. Turns go round the
    obstacle itself (a disc's concentric circle, a polygon's corner). Each
    obstacle also has outer endpoints, see `find_endpoints`. A turn that a
    later one makes needless is dropped. Where all segments of the blocking
    obstacle are danger, where it has no usable endpoint, where an arc and
    not a line is in danger, or where the rules go round in circles, it and
    the obstacles within D_r + delta of each other form a group, and the path
    starts again with the shortest route round all groups met so far. Groups
    only grow, and round all obstacles that route is exact, so the search
    ends: with a path, or with the proof that there is none. `literal_plan`
    does without all this. In a world whose order means nothing, the chain's
    segments are chance, and most plans end with the route round groups:
    `plan_rooms` finds the neighbours itself.

    As in the paper, a straight line is in danger only where it comes closer
    than R_r to an obstacle, while turns keep R_D = R_r + delta / 2. So a plan
    can be shorter than that of `shortest_path`, which keeps R_D everywhere: its
    lines may pass obstacles that need no turn by less.

    Examples
    --------
    >>> import freeseg as fs
    >>> plan = fs.plan(fs.load_table(1), start=(0.4, 0), goal=(0.8, 0.5))
    >>> [(turn.obstacle + 1, turn.sense) for turn in plan.turning_points]
    [(1, -1), (2, 1)]
    """
    return search(ask(world, start, goal, robot, margin), measured_first, by_detour)


def search(query: Query, survey: "Callable[[Query], Survey]", order: "Rank") -> Plan:
    """Plan with free segments and turning points, as the notes of `plan` say.

    Parameters
    ----------
    query : Query
        Start, goal and world.
    survey : callable
        What of the free segments is measured before the search.
    order : callable
        Endpoints in the order in which they are tried.
    """
    run = _Search(query, survey(query), order)
    while (danger := query.danger(run.path)) is not None:
        run.solve(*danger)
    effort = Effort(len(run.survey.measured), run.evaluated, run.retries)
    return query.answer(run.path, run.survey.segments, run.turns, run.steps, effort=effort)


@dataclass
class Survey:
    """Free segments and endpoints of a world, and which segments have been measured.

    Parameters
    ----------
    segments : tuple of FreeSegment
        All of them.
    endpoints : tuple of Endpoint
        Those that are tried.
    of_obstacle : dict
        Indices of the segments of each obstacle that has any.
    measured : set of int
        Indices of the segments that were compared with D_r + delta.
    """

    segments: tuple[FreeSegment, ...]
    endpoints: tuple[Endpoint, ...]
    of_obstacle: Mapping[int, Sequence[int]]
    measured: set[int]

    def is_safe(self, segment: int) -> bool:
        """Whether a segment is safe: it is measured, unless it has been."""
        self.measured.add(segment)
        return self.segments[segment].safe

    def is_dead_end(self, obstacle: int) -> bool:
        """Whether an obstacle has segments and all of them are danger."""
        own = self.of_obstacle.get(obstacle, ())
        return bool(own) and not any(self.is_safe(segment) for segment in own)

    def fault(self, endpoint: Endpoint) -> str:
        """What is wrong with the segments at an endpoint; empty where nothing is."""
        if endpoint.segment is not None:
            return "" if self.is_safe(endpoint.segment) else "its segment is danger"
        dead = self.is_dead_end(endpoint.obstacle)
        return "all segments of its obstacle are danger" if dead else ""


def measured_first(query: Query) -> Survey:
    """Survey with all segments measured and only the safe ones' ends tried, as in the paper."""
    segments, of_obstacle = find_segments(query.world, query.robot, query.margin)
    endpoints = _safe_ends(query.world, query.robot, query.margin)
    return Survey(segments, endpoints, of_obstacle, set(range(len(segments))))


@lru_cache(maxsize=16)
def find_segments(
    world: World, robot: Robot, margin: float
) -> tuple[tuple[FreeSegment, ...], Mapping[int, Sequence[int]]]:
    """Free segments, and those of each obstacle: many queries of a world share them."""
    segments = free_segments(world, robot, margin)
    of_obstacle: dict[int, list[int]] = {}
    for index, segment in enumerate(segments):
        for obstacle in segment.obstacles:
            of_obstacle.setdefault(obstacle, []).append(index)
    return segments, of_obstacle


@lru_cache(maxsize=16)
def _safe_ends(world: World, robot: Robot, margin: float) -> tuple[Endpoint, ...]:
    """Endpoints of the safe segments, and outer ones; shared likewise."""
    return find_endpoints(world, find_segments(world, robot, margin)[0])


class Rank(Protocol):
    """In which order endpoints are tried."""

    def __call__(
        self, segments: Sequence[FreeSegment], endpoints: Sequence[Endpoint], detours: np.ndarray
    ) -> np.ndarray:
        """Indices of the endpoints, given their detours (k,), the first to be tried first."""
        ...


def by_detour(
    segments: Sequence[FreeSegment], endpoints: Sequence[Endpoint], detours: np.ndarray
) -> np.ndarray:
    """Endpoints by increasing detour, equations (5) and (6)."""
    return np.argsort(detours, kind="stable")


class _Search:
    """State of one planning run; its methods are the boxes of Fig. 3."""

    def __init__(self, query: Query, survey: Survey, order: Rank) -> None:
        self.query, self.world, self.robot = query, query.world, query.robot
        self.survey, self.order = survey, order
        self.evaluated = self.retries = 0
        self.turns: list[TurningPoint] = []
        self.group: set[int] = set()
        self.seen: set[tuple] = {()}
        self.steps: list[Step] = []
        self.path, self.passed = query.straight_line(), [0]
        self.record(StepKind.STRAIGHT)

    def record(self, kind: StepKind, **details: Any) -> None:
        """Append a step to the trace."""
        self.steps.append(Step(kind, self.path, **details))

    def solve(self, piece: int, blocking: int, distance: float) -> None:
        """Solve a danger problem: one more turning point, or a local minimum."""
        place = self.passed[piece]
        first = not self.turns
        leg: np.ndarray | None = None
        candidates: tuple[Candidate, ...] = ()
        if isinstance(self.path.pieces[piece], Line) and not self.survey.is_dead_end(blocking):
            # Section 3.2.2 searches all endpoints; a repair (3.3.1) those of the blocking obstacle.
            leg, candidates = self.rank(
                [end for end in self.survey.endpoints if first or end.obstacle == blocking], place
            )
        chosen = next((candidate for candidate in candidates if not candidate.rejected), None)
        if chosen is not None:
            turns = self.turns.copy()
            turns.insert(place, self.turn(chosen.endpoint, chosen.sense))
            if self.adopt(turns):
                kind = StepKind.TURNING_POINT if first else StepKind.of_danger(distance)
                self.record(kind, blocking=blocking, leg=leg, candidates=candidates)
                if not self.drop_needless_turns():
                    self.go_round_group(blocking)
                return
            refused = replace(chosen, rejected="it leads back to turns tried before, or to none")
            candidates = tuple(refused if one is chosen else one for one in candidates)
        self.go_round_group(blocking, leg, candidates)

    def turn(self, endpoint: Endpoint, sense: int) -> TurningPoint:
        """Turning point at an endpoint."""
        radius = float(self.query.turning_radii[endpoint.obstacle])
        return TurningPoint(endpoint, endpoint.obstacle, endpoint.center, radius, sense)

    def adopt(self, turns: list[TurningPoint]) -> bool:
        """Take these turns, unless they have no path or were tried before."""
        key = tuple((turn.obstacle, *turn.center, turn.sense) for turn in turns)
        path, passed = self.query.connect(turns)
        if path is None or key in self.seen:
            return False
        self.seen.add(key)
        self.turns, self.path, self.passed = turns, path, passed
        return True

    def drop_needless_turns(self) -> bool:
        """Drop turns that a later one made needless; False if that fails."""
        while needless := [
            index for index in needless_turns(self.path, self.passed) if self.turns[index].endpoint
        ]:
            turns = [turn for index, turn in enumerate(self.turns) if index != needless[0]]
            dropped = self.turns[needless[0]].obstacle
            if not self.adopt(turns):
                return False
            self.record(StepKind.NEEDLESS_TURN, blocking=dropped)
        return True

    def rank(
        self, endpoints: Sequence[Endpoint], place: int
    ) -> tuple[np.ndarray, tuple[Candidate, ...]]:
        """Ends of a leg, and candidates for a turn on it by increasing detour (5)-(6)."""
        before = self.turns[place - 1] if place else None
        after = self.turns[place] if place < len(self.turns) else None
        leg = self.query.leg(self.turns, place)
        detours = detour_lengths(endpoints, leg)
        self.evaluated += len(detours)
        candidates: list[Candidate] = []
        middle = None
        for index in self.order(self.survey.segments, endpoints, detours).tolist():
            endpoint, sense, rejected = endpoints[index], 0, "a shorter detour was found"
            if middle is None:
                sense, rejected, middle = self.examine(endpoint, before, after)
                self.retries += middle is None
            candidates.append(Candidate(endpoint, float(detours[index]), sense, rejected))
        return leg, tuple(candidates if middle is None else _prefer_segment(candidates, middle))

    def examine(
        self, endpoint: Endpoint, before: TurningPoint | None, after: TurningPoint | None
    ) -> tuple[int, str, np.ndarray | None]:
        """Sense of the turn past an endpoint, what is wrong, and where its middle is.

        The middle, as a direction from the circle's centre, is None where
        something is wrong.
        """
        if fault := self.survey.fault(endpoint):
            return 0, fault, None
        radius, senses = self.query.turning_radii[endpoint.obstacle], np.array([1, -1])
        join, leave = self.touch(endpoint.center, senses * radius, before, after)
        if not np.isfinite([join, leave]).all(-1).all(0).any():
            return 0, "no tangent leads to its dangerous circle and on", None
        sweep = arc_sweep(endpoint.center, senses, join, leave)
        first = angle_of(join - endpoint.center)
        middle = unit(first + sweep / 2)
        # A turn past the endpoint has its middle on the endpoint's side of the obstacle.
        needed = (np.abs(sweep) > GRAZING) & (np.abs(sweep) <= np.pi)
        past = needed & (middle @ endpoint.outward > 0)
        if not past.any():
            return 0, "no turn is needed to pass there", None
        side = int(np.argmax(past))
        arc = Path([Arc(endpoint.center.tolist(), radius, first[side], sweep[side])])
        _, touched, distances = arc.near(self.world, self.robot.radius - self.query.round_off)
        if len(touched):
            nearest = self.world.name_of(touched[np.argmin(distances)])
            return int(senses[side]), f"a turn there touches {nearest}", None
        return int(senses[side]), "", middle[side]

    def touch(
        self,
        center: np.ndarray,
        signed: np.ndarray,
        before: TurningPoint | None,
        after: TurningPoint | None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where tangents from the turn before join a circle, and leave it for the one after.

        Of shape (2, 2) each: for both senses, the circle's signed radii.
        """
        come = (before.center, before.sense * before.radius) if before else (self.query.start, 0.0)
        go = (after.center, after.sense * after.radius) if after else (self.query.goal, 0.0)
        # First row: from where the robot comes to the circle; second row: on from there.
        (_, leave), (join, _) = tangents(
            np.array([come[0], center])[:, None],
            np.array([[come[1], come[1]], signed]),
            np.array([center, go[0]])[:, None],
            np.array([signed, [go[1], go[1]]]),
        )
        return join, leave

    def go_round_group(
        self,
        blocking: int,
        leg: np.ndarray | None = None,
        candidates: tuple[Candidate, ...] = (),
    ) -> None:
        """Escape a local minimum (section 3.3.2): the shortest route round groups."""
        label = group_labels(self.world, self.robot.diameter + self.query.margin)
        # Normally the blocking obstacle's group is new; if not, the turns' groups, at last all.
        for met in ({blocking}, {turn.obstacle for turn in self.turns}, set(range(len(label)))):
            grown = self.group | set(np.flatnonzero(np.isin(label, label[list(met)])).tolist())
            if grown > self.group:
                break
        else:
            raise Trapped(
                f"round-off at {self.world.name_of(blocking)}; please report this world, and "
                "where its order means nothing, plan with fs.plan_rooms",
                self.steps,
            )
        self.group = grown
        route = shortest_route(self.query, grown)
        self.turns, self.path, self.passed = route.turns, route.path, route.passed
        details = {"blocking": blocking, "leg": leg, "candidates": candidates}
        self.record(StepKind.LOCAL_MINIMUM, group=tuple(sorted(grown)), **details)


def _prefer_segment(candidates: list[Candidate], middle: np.ndarray) -> list[Candidate]:
    """Candidates with the chosen one named by the end of a safe segment, where there is one.

    An outer endpoint and the end of a safe segment may lie on the same turn, whose
    middle is given as a direction: then the latter is the paper's point.
    """
    chosen = next(index for index, one in enumerate(candidates) if not one.rejected)
    outer = candidates[chosen]
    if outer.endpoint.segment is not None:
        return candidates
    for index, candidate in enumerate(candidates):
        end = candidate.endpoint
        same_circle = np.array_equal(end.center, outer.endpoint.center)
        if end.segment is not None and same_circle and middle @ end.outward > 0:
            alike = f"the end of segment {end.segment + 1} turns alike"
            candidates = candidates.copy()
            candidates[index] = replace(candidate, sense=outer.sense, rejected="")
            candidates[chosen] = replace(outer, rejected=alike)
            break
    return candidates
