"""The earliest arrival among obstacles that move."""

import math
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike

from freeseg.errors import NoPath, Trapped
from freeseg.planners import time_search
from freeseg.planners.shortest import shortest_path
from freeseg.planners.time_search import GROWTH, RADIUS, Field, U, W
from freeseg.planners.time_waits import find_waits
from freeseg.planners.timed_query import TimedQuery, ask_in_time, meeting
from freeseg.robot import Robot
from freeseg.scene import Scene
from freeseg.segments import MARGIN
from freeseg.timed_path import APART, Ride, Slide, Straight, TimedPath
from freeseg.world import World

#: A slide or a line that takes less (s, relative to the arrival) is round-off.
MOMENT = 1e-11

#: By how much (m) a checked path may be too close to a mover, and how much too fast (relative).
TOO_CLOSE, TOO_FAST = 1e-8, 1e-6

#: Samples of the check are so many radii of the robot apart, unless that makes too many.
FINER, MOST_CHECKS = 1 / 70, 100_000


@dataclass(frozen=True, eq=False)
class TimedPlan:
    """A path in time that was checked.

    Parameters
    ----------
    path : TimedPath
        From start to goal, from time zero to the arrival.
    turns : tuple of (int, int)
        Obstacle of the scene that each slide is on, and its sense (1
        counter-clockwise, -1 clockwise), in driving order.
    scene : Scene
        Obstacles planned among.
    robot : Robot
        Robot planned for.
    margin : float
        Security margin delta (m).
    speed : float
        Speed of the robot (m/s).
    doubts : tuple of (int, int)
        Obstacles of the scene whose dangerous circles overlap at a time and
        place that could matter, while one moves: their common corner can be
        faster than the robot, and it is not proved that nothing arrives earlier.
    """

    path: TimedPath
    turns: tuple[tuple[int, int], ...]
    scene: Scene
    robot: Robot
    margin: float
    speed: float
    doubts: tuple[tuple[int, int], ...]

    def __repr__(self) -> str:
        proved = "proved" if self.proved else "not proved to be the earliest"
        return f"TimedPlan that arrives after {self.arrival:.3f} s, {proved}"

    @property
    def arrival(self) -> float:
        """Time of the arrival (s)."""
        return self.path.arrival

    @property
    def proved(self) -> bool:
        """Whether nothing can arrive earlier, as the search proved."""
        return not self.doubts


def time_minimal_plan(
    scene: Scene | World,
    start: ArrayLike,
    goal: ArrayLike,
    speed: float,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> TimedPlan:
    """Plan the path that arrives first, among obstacles that move.

    Parameters
    ----------
    scene : Scene or World
        Static discs and polygons, and discs that move evenly or grow.
    start, goal : array_like, shape (2,)
        Positions (m); the start is left at time zero.
    speed : float
        Largest speed V of the robot (m/s); each mover must be slower.
    robot : Robot, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m).

    Returns
    -------
    TimedPlan
        Its `arrival` (s), its `path` in time, and whether it is `proved` that
        nothing arrives earlier. The centre keeps R_D from every obstacle, or
        less where the start, or of static ones the goal, is closer.

    Raises
    ------
    InvalidQuery
        For what is no scene, and for a start or goal that is not free.
    InvalidParameter
        For a speed that the robot does not reach, or that a mover reaches too.
    InvalidWorld
        For a mover that is not a disc, or that does not move evenly.
    NoPath
        Where there is none: this is a proof.
    Trapped
        Where none was found, but movers overlap, so that nothing is proved.

    Notes
    -----
    The path is that of a point that turns at once and never changes its speed. For convex
    polygons that are slower than the robot and do not overlap, K. Fujimura and
    H. Samet (*Algorithmica* 1993) prove that a time-minimal motion is made of edges of
    the accessibility graph: whoever passes a place of an obstacle first can wait there
    for all others. `time_search` carries that over to discs. What covers the
    goal, it waits for on the rim that is the last to leave it.

    Examples
    --------
    >>> import freeseg as fs
    >>> crossing = fs.Mover(fs.Disc((0.5, -0.5), 0.1), velocity=(0, 0.05))
    >>> plan = time_minimal_plan(fs.Scene(fs.World([]), [crossing]), (0, 0), (1, 0), speed=0.1)
    >>> round(plan.arrival, 3), plan.proved
    (10.0, True)
    """
    query = ask_in_time(scene, start, goal, speed, robot, margin)
    field, kernels = query.field()
    found = kernels.search(field)
    # Waits are many, and few can matter: those that leave time to arrive earlier.
    waits = find_waits(field, kernels, found[0])
    if len(waits):
        field = field._replace(wait=waits)
        found = min(found, kernels.search(field), key=itemgetter(0))
    arrival, labels, last = found
    doubts = _doubts(query, arrival)
    if math.isinf(arrival):
        raise _nothing(query, doubts)
    path, turns = _in_time(query, field, labels, last, arrival)
    _verify(query, path)
    still = query.still
    return TimedPlan(path, turns, query.scene, still.robot, still.margin, query.speed, doubts)


def _nothing(query: TimedQuery, doubts: tuple[tuple[int, int], ...]) -> NoPath | Trapped:
    """The error that says why there is no path, or none was found."""
    still = query.still
    # Raises the error that names what bars the way, if it is barred without movers already.
    shortest_path(still.world, still.start, still.goal, still.robot, still.margin)
    told = (
        f"from {still.start.tolist()} to {still.goal.tolist()} for a robot of "
        f"{still.robot.diameter:g} m at {query.speed:g} m/s with a margin of {still.margin:g} m"
    )
    if not doubts:
        return NoPath(f"the movers leave no way {told}; move the goal, or give a higher speed")
    one, other = map(query.scene.name_of, doubts[0])
    return Trapped(
        f"no way was found {told}, and none is proved not to be there: {one} and {other} overlap; "
        "give a higher speed, or plan for a smaller robot or margin"
    )


def _in_time(
    query: TimedQuery, field: Field, labels: np.ndarray, last: np.ndarray, arrival: float
) -> tuple[TimedPath, tuple[tuple[int, int], ...]]:
    """The path of the move that arrives, and obstacle and sense of each slide."""
    chain = [(int(last[time_search.ON]), float(last[time_search.LEAVING]))]
    while chain[-1][0] >= 0:
        label = labels[chain[-1][0]]
        chain.append((int(label[time_search.PARENT]), float(label[time_search.LEFT])))
    pieces: list[Straight | Slide | Ride] = []
    turns = []
    place, time = query.still.start, 0.0
    for row, turned in chain[-2::-1]:
        label = labels[row]
        begin = float(label[time_search.TIME])
        is_slide = label[time_search.DISC] < len(field.disc)
        # How far a slide is driven, or until when a ride.
        slide = _slide(query, label, turned) if is_slide else _ride(query, field, label, turned)
        touch = slide.at(np.array([begin]))[0][0]
        pieces += _straight(place, touch, time, begin, arrival)
        place, time = touch, begin
        if slide.end - begin > MOMENT * arrival:
            pieces.append(slide)
            if isinstance(slide, Slide):
                obstacle = int(query.obstacle_of[int(label[time_search.DISC])])
                turns.append((obstacle, slide.sense))
            time = slide.end
            place = slide.at(np.array([time]))[0][0]
    pieces += _straight(place, query.still.goal, time, arrival, arrival)
    return TimedPath(pieces), tuple(turns)


def _straight(
    start: np.ndarray, end: np.ndarray, begin: float, finish: float, arrival: float
) -> list[Straight]:
    """The straight motion between two places (m) and times (s), unless it is round-off."""
    if finish - begin <= MOMENT * arrival:
        return []
    return [Straight(start, (end - start) / (finish - begin), begin, finish)]


def _slide(query: TimedQuery, label: np.ndarray, turned: float) -> Slide:
    """The slide of a label of the search, for so much of a turn (rad)."""
    disc = query.disc[int(label[time_search.DISC])]
    return Slide(
        center=disc[:2] + query.origin,
        velocity=disc[U : W + 1],
        radius=float(disc[RADIUS]),
        growth=float(disc[GROWTH]),
        angle=float(label[time_search.BEARING]),
        sweep=float(label[time_search.SENSE]) * turned,
        begin=float(label[time_search.TIME]),
        speed=query.speed,
    )


def _ride(query: TimedQuery, field: Field, label: np.ndarray, end: float) -> Ride:
    """The ride of a label of the search, until a time (s)."""
    wait = field.wait[int(label[time_search.DISC]) - len(field.disc)]

    def place(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y, vx, vy = time_search.wait_at(wait, t)
        return np.stack([x, y], -1) + query.origin, np.stack([vx, vy], -1)

    return Ride(place, float(label[time_search.TIME]), end)


def _doubts(query: TimedQuery, arrival: float) -> tuple[tuple[int, int], ...]:
    """Pairs of obstacles whose dangerous circles overlap where and when it could matter."""
    disc = query.disc[1:]
    place, velocity = disc[:, :2], disc[:, U : W + 1]
    radius, growth = disc[:, RADIUS], disc[:, GROWTH]
    one, other = np.triu_indices(len(disc), 1)
    keep = one < len(query.discs)
    one, other = one[keep], other[keep]
    # What moves along with the other has a corner that does too.
    drift, swell = velocity[one] - velocity[other], growth[one] + growth[other]
    first, last = meeting(place[one] - place[other], drift, radius[one] + radius[other], swell)
    for end, reach, pace in (
        (query.still.start, 0.0, query.speed),
        (query.still.goal, query.speed * min(arrival, 1e9), -query.speed),
    ):
        # Where the robot can be at a time is a disc that grows, and then shrinks.
        from_when, until = meeting(
            place - (end - query.origin), velocity, radius + reach, growth + pace
        )
        first = np.maximum(first, np.maximum(from_when[one], from_when[other]))
        last = np.minimum(last, np.minimum(until[one], until[other]))
    apart = drift.any(1) | (swell > 0)
    doubted = np.flatnonzero((first < np.minimum(last, arrival)) & apart)
    number = query.obstacle_of[1:]
    pairs = {(int(number[one[k]]), int(number[other[k]])) for k in doubted}
    return tuple(sorted(pairs))


def _verify(query: TimedQuery, path: TimedPath) -> None:
    """Check a path by other means: the distances of dense samples, and their speed.

    Raises
    ------
    Trapped
        Where the path does not lead from start to goal, comes too close to an obstacle, or is
        too fast.
    """
    still = query.still
    count = math.ceil(path.arrival * query.speed / (still.robot.radius * FINER))
    t = np.linspace(0, path.arrival, min(max(count, 2), MOST_CHECKS))
    pose, velocity = path.at(t)
    points = pose[:2].T
    beside = np.hypot(*(points[[0, -1]] - [still.start, still.goal]).T).max()
    if beside > APART:
        raise Trapped(
            f"the path begins or ends {beside:.6g} m from the start or the goal; please report "
            "this scene"
        )
    still.verify_points(points, ())
    gaps = query.scene.distances(points, t)[:, query.moving]
    movers = [query.scene.movers[index - len(query.scene.world)] for index in query.moving]
    keep = query.discs[:, RADIUS] - [mover.obstacle.radius for mover in movers]
    speeds = np.hypot(*velocity) / query.speed
    # Velocities are the pieces' own word for it.
    speeds = np.append(speeds, np.hypot(*np.diff(points, axis=0).T) / np.diff(t) / query.speed)
    if (gaps < keep - TOO_CLOSE).any() or speeds.max() > 1 + TOO_FAST:
        when, which = np.unravel_index(np.argmin(gaps - keep), gaps.shape) if gaps.size else (0, 0)
        told = query.scene.name_of(int(query.moving[which])) if gaps.size else "nothing"
        raise Trapped(
            f"the path comes within {gaps[when, which] if gaps.size else math.inf:.6g} m of {told} "
            f"after {t[when]:.6g} s, or is {speeds.max():.9g} times as fast as it may be; please "
            "report this scene"
        )
