"""A plan: a path that was checked, and the trace of how it was found."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.path import Path
from freeseg.robot import Robot
from freeseg.segments import MARGIN, Endpoint, FreeSegment
from freeseg.world import World, check_world


class StepKind(StrEnum):
    """What a step of a planner did; as a text, in the paper's words."""

    #: The straight line from the start to the goal, with which every planner begins.
    STRAIGHT = "straight"
    #: The first turning point (section 3.2.2).
    TURNING_POINT = "turning point"
    #: A repair where the path meets an obstacle, and where only the robot's disc does (3.3.1).
    CASE_1 = "case 1"
    CASE_2 = "case 2"
    #: A turn that a later one made needless was dropped.
    NEEDLESS_TURN = "needless turn"
    #: The shortest route round a group of obstacles (3.3.2).
    LOCAL_MINIMUM = "local minimum"
    #: The path along the shortest route from room to room.
    ROOMS = "rooms"
    #: The shortest path round the obstacles met so far.
    SHORTEST = "shortest"

    def __repr__(self) -> str:
        return repr(str(self))

    @property
    def is_repair(self) -> bool:
        """Whether the step solves a danger problem of the path first planned."""
        return self in (
            StepKind.CASE_1,
            StepKind.CASE_2,
            StepKind.NEEDLESS_TURN,
            StepKind.LOCAL_MINIMUM,
        )

    @classmethod
    def of_danger(cls, distance: float) -> "StepKind":
        """Case of a danger problem, given the distance of path and obstacle (m).

        Case 1 where the path meets the obstacle, case 2 where only the
        robot's disc does (section 3.3.1).
        """
        return cls.CASE_1 if distance <= 0 else cls.CASE_2


@dataclass(frozen=True, eq=False)
class TurningPoint:
    """An endpoint that the path turns round, with its dangerous circle.

    Parameters
    ----------
    endpoint : Endpoint or None
        Where the path turns; None where no endpoint was searched: round a
        group, and on the shortest path.
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

    def __repr__(self) -> str:
        sense = "counter-clockwise" if self.sense > 0 else "clockwise"
        return (
            f"TurningPoint {sense} round obstacle {self.obstacle + 1}, radius {self.radius:.4f} m"
        )

    @property
    def point(self) -> np.ndarray:
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

    def __repr__(self) -> str:
        verdict = self.rejected or "chosen"
        return f"Candidate on obstacle {self.endpoint.obstacle + 1}, {self.detour:.4f} m: {verdict}"


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the planner, enough to draw it.

    Parameters
    ----------
    kind : StepKind
        What it did.
    path : Path
        The path as planned after this step; it may still be in danger.
    blocking : int or None
        Index of the obstacle that the path before met.
    leg : ndarray, shape (2, 2) or None
        The points between which a turning point was searched (m).
    candidates : tuple of Candidate
        In the order in which they were tried: by increasing detour, where
        the planner does not say otherwise.
    group : tuple of int
        Obstacles gone round together at a local minimum, or met so far on
        the shortest path.
    """

    kind: StepKind
    path: Path
    blocking: int | None = None
    leg: np.ndarray | None = None
    candidates: tuple[Candidate, ...] = ()
    group: tuple[int, ...] = ()

    def __repr__(self) -> str:
        return f"Step {str(self.kind)!r} to a path of {self.path.length:.3f} m"

    @property
    def chosen(self) -> Candidate | None:
        """The candidate that this step chose, or None."""
        return next((candidate for candidate in self.candidates if not candidate.rejected), None)


@dataclass(frozen=True)
class Effort:
    """What a search by free segments and endpoints has computed.

    Not counted are what comes with the map, where the endpoints are, and the check of
    each path, which is the same in whatever order endpoints are tried.

    Parameters
    ----------
    segments : int
        Free segments that were measured: compared with D_r + delta.
    endpoints : int
        Endpoints whose detour SD was computed, on every leg anew.
    retries : int
        Endpoints that were tried and refused.

    Raises
    ------
    InvalidParameter
        For what is no whole number from 0 on.
    """

    segments: int
    endpoints: int
    retries: int

    def __post_init__(self) -> None:
        for name in ("segments", "endpoints", "retries"):
            object.__setattr__(self, name, checks.whole(name, getattr(self, name)))

    @property
    def distances(self) -> int:
        """Distances between two points: one for a segment (2), two for a detour (5)."""
        return self.segments + 2 * self.endpoints


@dataclass(frozen=True, eq=False)
class Plan:
    """A path that was checked, and how it was found.

    Parameters
    ----------
    path : Path
        From start to goal, nowhere closer than R_r to an obstacle.
    segments : tuple of FreeSegment
        Safe and danger ones; of a triangulation, those that the path was
        led through; none of `shortest_path`, which needs none.
    turning_points : tuple of TurningPoint
        In driving order.
    steps : tuple of Step
        The trace.
    robot : Robot
        Robot planned for.
    margin : float
        Security margin delta (m).
    world : World
        Obstacles planned among.
    lower_bound : float or None
        No path that keeps the margin is shorter (m), as the search for it
        proved: for an optimum, the path's length. None where nothing was
        proved.
    effort : Effort or None
        What the search for turning points computed; None where none were
        searched.

    Raises
    ------
    InvalidParameter, InvalidQuery
        For what is not of these types.
    """

    path: Path
    segments: tuple[FreeSegment, ...]
    turning_points: tuple[TurningPoint, ...]
    steps: tuple[Step, ...]
    robot: Robot
    margin: float
    world: World
    lower_bound: float | None = None
    effort: Effort | None = None

    def __post_init__(self) -> None:
        checks.instance("path", self.path, Path, "a Path")
        for name, kind in (
            ("segments", FreeSegment),
            ("turning_points", TurningPoint),
            ("steps", Step),
        ):
            found = checks.instances(name, getattr(self, name), kind, f"{kind.__name__}s")
            object.__setattr__(self, name, found)
        checks.instance("robot", self.robot, Robot, "a Robot")
        object.__setattr__(self, "margin", checks.not_negative("margin", self.margin))
        check_world(self.world)
        if self.lower_bound is not None:
            bound = checks.not_negative("lower_bound", self.lower_bound)
            object.__setattr__(self, "lower_bound", bound)
        if self.effort is not None:
            checks.instance("effort", self.effort, Effort, "an Effort")

    def __repr__(self) -> str:
        return (
            f"Plan of {self.path.length:.3f} m with {len(self.turning_points)} turns, "
            f"found in {len(self.steps)} steps"
        )

    @property
    def turning_radius(self) -> float:
        """Radius R_D of the dangerous circle round a point (m)."""
        return turning_radius(self.robot, self.margin)


def turning_radius(robot: Robot, margin: float) -> float:
    """Radius R_D = R_r + delta / 2 of the dangerous circle (m).

    An assumption, the paper gives none: two such circles just fit into the
    narrowest safe segment.
    """
    return robot.radius + margin / 2


def check_plan(plan: object, world: object = None) -> Plan:
    """`plan`, or `InvalidParameter` for what is no plan, or one among other obstacles.

    Parameters
    ----------
    plan : Plan
        What a planner returned.
    world : World, optional
        Obstacles that it is drawn or measured among.
    """
    checked = checks.instance("plan", plan, Plan, "what a planner returned, such as fs.plan's")
    if world is None or world is checked.world:
        return checked
    one, other = check_world(world), checked.world
    if (
        len(one) != len(other)
        or (one.radii != other.radii).any()
        or not shapely.equals(one.cores, other.cores).all()
    ):
        raise InvalidParameter(
            f"plan is a {plan!r} in another world, a {other!r}, than the {one!r} given; give "
            "plan.world, or plan again"
        )
    return checked


class Planner(Protocol):
    """What all planners are: one function from a query to a plan."""

    def __call__(
        self,
        world: World,
        start: ArrayLike,
        goal: ArrayLike,
        robot: Robot | None = None,
        margin: float = MARGIN,
    ) -> Plan:
        """Plan a path that is free of collisions, or raise an error that says why not."""
        ...
