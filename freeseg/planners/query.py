"""What a planner is asked: a checked query, which checks paths in turn."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter, InvalidQuery, Trapped
from freeseg.geometry import read_only
from freeseg.path import Arc, Line, Path, taut_path
from freeseg.plan import Effort, Plan, Step, TurningPoint, turning_radius
from freeseg.planners.nearest_free import find_nearest_free
from freeseg.robot import Robot, as_robot
from freeseg.segments import Endpoint, FreeSegment
from freeseg.world import ROUND_OFF as ROUND_OFF
from freeseg.world import World, as_position, check_world, round_off

#: So many samples of a path are checked together.
STRETCH = 100

#: In worlds of more segments, it may take seconds to find the nearest free position for a message.
QUICK = 5000

#: Smallest radius of a robot, in round-offs: less would be lost in them.
SMALLEST = 10


def needless_turns(path: Path, passed: Sequence[int]) -> list[int]:
    """Indices of the turns whose arc is more than half a turn, in driving order.

    There the taut path would leave the circle before it arrives: a sign that a later
    turn made this one needless.

    Parameters
    ----------
    path, passed
        From `taut_path`.
    """
    return [
        turn
        for piece, turn in zip(path.pieces, passed, strict=True)
        if isinstance(piece, Arc) and abs(piece.sweep) > np.pi
    ]


def detour_lengths(endpoints: Sequence[Endpoint], leg: np.ndarray) -> np.ndarray:
    """Lengths SD over endpoints (m), equations (5) and (6), shape (k,).

    Parameters
    ----------
    endpoints : sequence of Endpoint
        k endpoints.
    leg : ndarray, shape (2, 2)
        The points between which a turning point is searched (m).
    """
    points = np.array([endpoint.point for endpoint in endpoints]).reshape(-1, 2)
    return np.hypot(*(points - leg[0]).T) + np.hypot(*(points - leg[1]).T)


@dataclass(frozen=True, eq=False)
class Query:
    """A question to a planner that has been checked, see `ask`.

    Parameters
    ----------
    world : World
        n obstacles.
    start, goal : ndarray, shape (2,)
        Free positions (m).
    robot : Robot
        Robot.
    margin : float
        Security margin delta (m).
    turning_radii : ndarray, shape (n,)
        Radius of the dangerous circle round each obstacle's corners (m).
    """

    world: World
    start: np.ndarray
    goal: np.ndarray
    robot: Robot
    margin: float
    turning_radii: np.ndarray

    @cached_property
    def round_off(self) -> float:
        """Length (m) that decides nothing here, for it is round-off; see `round_off`."""
        return max(self.world.round_off, round_off(self.start, self.goal))

    def straight_line(self) -> Path:
        """Path from the start straight to the goal, with which every planner begins."""
        return Path([Line(self.start.tolist(), self.goal.tolist())])

    def connect(self, turns: Sequence[TurningPoint]) -> tuple[Path | None, list[int]]:
        """Path round the dangerous circles of turns, see `taut_path`."""
        return taut_path(
            self.start, [(turn.center, turn.sense * turn.radius) for turn in turns], self.goal
        )

    def leg(self, turns: Sequence[TurningPoint], place: int) -> np.ndarray:
        """The points (m) between which one more turn is searched, shape (2, 2).

        Parameters
        ----------
        turns : sequence of TurningPoint
            In driving order.
        place : int
            How many of them come before the new one.
        """
        before = turns[place - 1].point if place else self.start
        after = turns[place].point if place < len(turns) else self.goal
        return read_only(np.array([before, after]))

    def danger(self, path: Path) -> tuple[int, int, float] | None:
        """The first danger problem of a path (section 3.3.1).

        Returns
        -------
        (int, int, float) or None
            Piece, obstacle, and their distance (m), below R_r; None where
            the path is free.
        """
        pieces, obstacles, distances = path.near(self.world, self.robot.radius - self.round_off)
        if not len(pieces):
            return None
        first = np.flatnonzero(pieces == pieces[0])
        piece = path.pieces[pieces[0]]
        heading = np.subtract(piece.end, piece.start)
        middles = [self._place_of(index, pieces[0], path) for index in obstacles[first]]
        met = first[np.argmin((np.array(middles) - piece.start) @ heading)]
        return int(pieces[met]), int(obstacles[met]), float(distances[met])

    def _place_of(self, obstacle: int, piece: int, path: Path) -> np.ndarray:
        """Where a piece that is in danger comes to an obstacle, by and large (m)."""
        core = self.world.cores[obstacle]
        if not shapely.get_num_interior_rings(core):
            return self.world.corners[obstacle].mean(0)
        # What is round the path has its middle anywhere.
        chord = shapely.LineString([path.pieces[piece].start, path.pieces[piece].end])
        return shapely.get_coordinates(shapely.shortest_line(chord, core))[0]

    def answer(
        self,
        path: Path,
        segments: Sequence[FreeSegment],
        turns: Sequence[TurningPoint],
        steps: Sequence[Step],
        lower_bound: float | None = None,
        effort: Effort | None = None,
    ) -> Plan:
        """The plan, once its path has passed the check; see `verify`."""
        self.verify(path, steps)
        found = tuple(segments), tuple(turns), tuple(steps)
        return Plan(path, *found, self.robot, self.margin, self.world, lower_bound, effort)

    def verify(self, path: Path, steps: Sequence[Step]) -> None:
        """Check a path by other means: Shapely, on samples.

        They are R_r / 70 apart, 1 mm for a Khepera IV, unless that makes over
        a million.

        Raises
        ------
        Trapped
            Where the path comes closer than R_r to an obstacle.
        """
        self.verify_points(path.sample(max(self.robot.radius / 70, path.length / 1e6)), steps)

    def verify_points(self, points: np.ndarray, steps: Sequence[Step]) -> None:
        """`verify` for points (m) along a path, shape (k, 2)."""
        # Short stretches: the search tree then compares each with the few obstacles beside it.
        stretch = np.arange(len(points)) // STRETCH
        if len(points) % STRETCH == 1:
            stretch[-1] -= 1
        limit = self.robot.radius - self.round_off
        # A line through the samples is at least as near as they are, and quickly compared.
        suspect, _, _ = self.world.near(shapely.linestrings(points, indices=stretch), limit)
        if len(suspect):
            again = shapely.points(points[np.isin(stretch, suspect)])
            _, met, distances = self.world.near(again, limit)
            if not len(met):
                return
            nearest = int(np.argmin(distances))
            raise Trapped(
                f"the path comes within {distances[nearest]:.6g} m of "
                f"{self.world.name_of(met[nearest])}, the robot's radius is "
                f"{self.robot.radius:.6g} m; please report this world",
                steps,
            )


def ask(
    world: World, start: ArrayLike, goal: ArrayLike, robot: Robot | None, margin: float
) -> Query:
    """Check what a planner is asked.

    Parameters
    ----------
    world, start, goal, robot, margin
        As for `plan`.

    Returns
    -------
    Query
        Its dangerous circles have the radius R_D beyond the obstacle, or less
        where the start or the goal is closer than R_D, but never below R_r.

    Raises
    ------
    InvalidQuery, InvalidParameter
        As for `plan`.
    """
    robot, margin = as_robot(robot), checks.not_negative("margin", margin)
    check_world(world)
    start, goal = as_position(start, "start"), as_position(goal, "goal")
    least = max(world.round_off, round_off(start, goal))
    if robot.radius < SMALLEST * least:
        raise InvalidParameter(
            f"robot.diameter is {robot.diameter:g} m, which round-off would swallow; lengths are "
            f"in metres, give at least {2 * SMALLEST * least:g} m"
        )
    if np.hypot(*(goal - start)) <= least:
        raise InvalidQuery(f"start and goal are the same point {start.tolist()}; move one")
    clear = np.full(len(world), turning_radius(robot, margin))
    for what, position in (("start", start), ("goal", goal)):
        check_free(what, position, world, robot, margin)
        distances = world.distances(shapely.Point(position))
        # The circle must leave the position outside, by more than round-off, but not by so much
        # that a large robot would seem to touch.
        clear = np.minimum(clear, distances - least * np.minimum(distances, 0.5))
    if len(world) and margin > robot.diameter and (clear < turning_radius(robot, margin)).all():
        raise InvalidParameter(
            f"margin is {margin:g} m, wider than the robot, and the start or the goal is too close "
            f"to every obstacle for it (R_D = R_r + margin / 2); give at most "
            f"{2 * (clear.max() - robot.radius):.4g} m"
        )
    return Query(world, start, goal, robot, margin, read_only(world.radii + clear))


def check_free(what: str, position: np.ndarray, world: World, robot: Robot, margin: float) -> None:
    """`InvalidQuery` for a position (m) where the robot's disc does not fit."""
    distances, beyond = _surroundings(position, world)
    if not beyond and (distances >= robot.radius).all():
        return
    remedy = "move it away: ask fs.nearest_free"
    if len(world.edges) <= QUICK:
        free = find_nearest_free(world, position, turning_radius(robot, margin))
        remedy = "move it away, or plan for a smaller robot or margin"
        if free is not None:
            named = _rounded_free(free, world, robot.radius)
            remedy = f"move it away: fs.nearest_free gives {named}"
    if beyond:
        raise InvalidQuery(f"{what} {position.tolist()} is outside the boundary; {remedy}")
    nearest = int(np.argmin(distances))
    where = _whereabouts(position, world, nearest, float(distances[nearest]), robot.radius)
    raise InvalidQuery(
        f"{what} {position.tolist()} is {where} {world.name_of(nearest)}, and the robot's radius "
        f"is {_metres(robot.radius)} m; {remedy}"
    )


def _surroundings(position: np.ndarray, world: World) -> tuple[np.ndarray, bool]:
    """Distances of a position from all obstacles (m), and whether it is beyond the boundary.

    Beyond the frame, which is only as wide as must be, nothing is free either.
    """
    point = shapely.Point(position)
    beyond = world.boundary is not None and not shapely.covers(
        shapely.Polygon(world.boundary), point
    )
    return world.distances(point), beyond


def _rounded_free(free: np.ndarray, world: World, radius: float) -> list[float]:
    """A free position (m) with the fewest digits with which the robot still fits there."""
    least = max(3, 2 - math.floor(math.log10(radius)))
    for digits in range(least, least + 7):
        # Zero is without a sign.
        named = free.round(digits) + 0.0
        distances, beyond = _surroundings(named, world)
        if not beyond and (distances >= radius).all():
            return named.tolist()
    return free.tolist()


def _whereabouts(
    position: np.ndarray, world: World, obstacle: int, gap: float, radius: float
) -> str:
    """Where a position is as seen from an obstacle that is nearer than the radius (m)."""
    if gap > 0:
        # As many digits as it takes to tell the gap from the radius.
        shown = (_metres(gap, digits) for digits in range(4, 18))
        return f"{next(text for text in shown if text != _metres(radius))} m from"
    core = world.cores[obstacle]
    off = shapely.Point(position).distance(core.boundary) if world.radii[obstacle] == 0 else -gap
    return "on the edge of" if off <= world.round_off else "inside"


def _metres(length: float, digits: int = 4) -> str:
    """A length (m) with so many digits after the point, or significant ones where it is short."""
    return f"{length:.{digits}f}" if length >= 0.001 else f"{length:.{digits}g}"
