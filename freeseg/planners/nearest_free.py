"""Where the robot can stand: the nearest free position, in closed form."""

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidQuery
from freeseg.geometry import angle_of, cross, point_segment_distance, read_only, unit
from freeseg.plan import turning_radius
from freeseg.robot import Robot, as_robot
from freeseg.segments import MARGIN
from freeseg.world import World, as_position, check_world, round_off

#: So many candidates are compared with the world at once.
CANDIDATES = 10_000


def nearest_free(
    world: World, point: ArrayLike, robot: Robot | None = None, margin: float = MARGIN
) -> np.ndarray:
    """The position nearest to a point where the robot stands free with its margin.

    Parameters
    ----------
    world : World
        Obstacles.
    point : array_like, shape (2,)
        Any position (m), also inside of an obstacle or outside the boundary.
    robot : Robot, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m).

    Returns
    -------
    ndarray, shape (2,)
        The point itself where it is free; else the nearest position that is
        R_D = R_r + delta / 2 away from every obstacle (m).

    Raises
    ------
    InvalidQuery
        For a point that is not two finite numbers, and where no position in
        the world is free.
    InvalidParameter
        For a robot that is none, or a margin that is negative or not finite.

    Notes
    -----
    What is forbidden to the robot's centre is bounded by circles round corners
    and by lines along edges. The nearest free point is the nearest of one of
    those, or where two of them meet, so these points are compared: the answer
    is exact but for four times the world's `round_off`, by which it keeps away
    farther than it must.

    Examples
    --------
    >>> import freeseg as fs
    >>> nearest_free(fs.World([fs.Disc((0, 0), 1)]), (0.5, 0), margin=0).round(6).tolist()
    [1.0704, 0.0]
    """
    check_world(world)
    robot, margin = as_robot(robot), checks.not_negative("margin", margin)
    point = as_position(point, "point")
    found = find_nearest_free(world, point, turning_radius(robot, margin))
    if found is None:
        raise InvalidQuery(
            f"point is {point.tolist()}, but this world has no position that is free for the "
            "robot; ask for a smaller robot or margin"
        )
    return found


def find_nearest_free(world: World, point: np.ndarray, keep: float) -> np.ndarray | None:
    """The nearest position (m) that is `keep` away from all obstacles, or None."""
    slack = max(world.round_off, round_off(point))
    if _are_free(world, point[None], keep).all():
        return point
    curves = _Curves(world, keep + 4 * slack)
    nearest = curves.nearest_to(point)
    limit = np.hypot(*(nearest - point).T)
    feet = _first_free(world, nearest, limit, keep + 2 * slack)
    best = None if feet is None else nearest[feet]
    # What lies farther away than a free position cannot bound a nearer one. Without one, look at
    # ever more.
    bound = np.inf if feet is None else limit[feet]
    within = min(bound, 2 * limit.min(initial=np.inf) + keep)
    while True:
        meeting = curves.crossings(np.flatnonzero(limit <= within))
        apart = np.hypot(*(meeting - point).T)
        meeting, apart = meeting[apart <= within], apart[apart <= within]
        first = _first_free(world, meeting, apart, keep + 2 * slack)
        if first is not None:
            return read_only(meeting[first].copy())
        if within >= min(bound, limit.max(initial=0) + 2 * keep):
            return None if best is None else read_only(best.copy())
        within = min(2 * within, bound)


def _are_free(world: World, points: np.ndarray, keep: float) -> np.ndarray:
    """Which positions (k, 2) are inside the boundary and `keep` away from all, shape (k,)."""
    free = np.ones(len(points), bool)
    if world.boundary is not None:
        free = shapely.contains_xy(shapely.Polygon(world.boundary), *points.T)
    which, _, distance = world.near(shapely.points(points), keep)
    free[which[distance < keep]] = False
    return free


def _first_free(world: World, points: np.ndarray, apart: np.ndarray, keep: float) -> int | None:
    """Index of the free position with the smallest of some distances, or None."""
    order = np.argsort(apart, kind="stable")
    batch, begin = 16, 0
    while begin < len(order):
        some = order[begin : begin + batch]
        free = _are_free(world, points[some], keep)
        if free.any():
            return int(some[np.argmax(free)])
        begin, batch = begin + batch, min(2 * batch, CANDIDATES)
    return None


class _Curves:
    """Circles round all corners, then lines beside all edges, a distance away.

    Parameters
    ----------
    world : World
        Obstacles.
    keep : float
        The distance (m).
    """

    def __init__(self, world: World, keep: float) -> None:
        owner = np.repeat(np.arange(len(world)), world.edge_counts)
        self.centers, self.radii = world.edges[:, 0], world.radii[owner] + keep
        along = world.edges[:, 1] - world.edges[:, 0]
        is_long = (along != 0).any(1)
        direction = unit(angle_of(along[is_long]))
        # The material is on the left of every edge.
        outward = np.stack([direction[:, 1], -direction[:, 0]], axis=1)
        self.lines = world.edges[is_long] + keep * outward[:, None]

    def nearest_to(self, point: np.ndarray) -> np.ndarray:
        """The point of every curve that is nearest to a point (m), shape (k, 2)."""
        on_circles = self.centers + self.radii[:, None] * unit(angle_of(point - self.centers))
        tails, along = self.lines[:, 0], self.lines[:, 1] - self.lines[:, 0]
        share = ((point - tails) * along).sum(1) / np.maximum((along**2).sum(1), 1e-300)
        return np.concatenate([on_circles, tails + np.clip(share, 0, 1)[:, None] * along])

    def crossings(self, curves: np.ndarray) -> np.ndarray:
        """Where curves of these indices meet (m), shape (m, 2)."""
        count = len(self.radii)
        low = np.concatenate([self.centers - self.radii[:, None], self.lines.min(1)])[curves]
        high = np.concatenate([self.centers + self.radii[:, None], self.lines.max(1)])[curves]
        boxes = shapely.box(*low.T, *high.T)
        first, second = curves[shapely.STRtree(boxes).query(boxes)]
        once = first < second
        first, second = first[once], second[once]
        # Lines come after circles, so that the first one of a pair of both is the circle.
        two, none = second < count, first >= count
        mixed = ~two & ~none
        lines = self.lines[second[~two] - count]
        parts = (
            _where_circles_meet(self.centers, self.radii, first[two], second[two]),
            _where_lines_meet_circles(
                self.centers[first[mixed]], self.radii[first[mixed]], lines[mixed[~two]]
            ),
            _where_lines_meet(self.lines[first[none] - count], lines[none[~two]]),
        )
        return np.concatenate(parts)


def _where_circles_meet(
    centers: np.ndarray, radii: np.ndarray, first: np.ndarray, second: np.ndarray
) -> np.ndarray:
    """Both points where every two circles meet that do, shape (m, 2)."""
    between = centers[second] - centers[first]
    apart = np.hypot(*between.T)
    meet = (apart > 0) & (apart <= radii[first] + radii[second])
    meet &= apart >= np.abs(radii[first] - radii[second])
    first, second, between, apart = first[meet], second[meet], between[meet], apart[meet]
    ahead = (apart + (radii[first] ** 2 - radii[second] ** 2) / apart) / 2
    aside = np.sqrt(np.maximum(radii[first] ** 2 - ahead**2, 0))
    along = between / apart[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    foot = centers[first] + ahead[:, None] * along
    return np.concatenate([foot + sign * aside[:, None] * across for sign in (1, -1)])


def _where_lines_meet_circles(
    centers: np.ndarray, radii: np.ndarray, lines: np.ndarray
) -> np.ndarray:
    """Where lines (k, 2, 2) meet their circles, shape (m, 2)."""
    meet = point_segment_distance(centers, lines) <= radii
    centers, radii, lines = centers[meet], radii[meet], lines[meet]
    along = lines[:, 1] - lines[:, 0]
    length = np.hypot(*along.T)
    along = along / length[:, None]
    ahead = ((centers - lines[:, 0]) * along).sum(1)
    off = cross(along, centers - lines[:, 0])
    half = np.sqrt(np.maximum(radii**2 - off**2, 0))
    found = []
    for sign in (1, -1):
        place = ahead + sign * half
        on = (place >= 0) & (place <= length)
        found.append(lines[on, 0] + place[on, None] * along[on])
    return np.concatenate(found)


def _where_lines_meet(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Where lines (k, 2, 2) cross their partners, shape (m, 2)."""
    along, other = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    turn = cross(along, other)
    between = second[:, 0] - first[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share, share_other = cross(between, other) / turn, cross(between, along) / turn
    meet = (share >= 0) & (share <= 1) & (share_other >= 0) & (share_other <= 1)
    return first[meet, 0] + share[meet, None] * along[meet]
