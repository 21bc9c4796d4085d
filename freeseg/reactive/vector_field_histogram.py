"""VFH+: a histogram of what is round the robot, and the best opening in it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import TINY, unit, wrap_angle
from freeseg.reactive.sensing import check_drive, for_each, outlines_of, scan, steer
from freeseg.reference import SPEED
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains

#: More sectors than this are narrower than any sensor sees.
MOST_SECTORS = 3600


@dataclass(frozen=True)
class VectorFieldHistogram:
    """Gains of VFH+ (I. Ulrich, J. Borenstein, ICRA 1998).

    Four stages make a direction of what the robot's range scanner reads (the numbers of the
    equations are ours):

    1. *Primary polar histogram.* A reading at the distance d weighs

           (V1)  m = 1 - (d / reach)^2

       and, enlarged by the robot's radius and the margin, fills all sectors within

           (V2)  gamma = asin((radius + margin) / d)

       of its bearing. A sector's height h is the sum of these weights.
    2. *Binary histogram.* A sector is blocked where h is above ``high``, free where it is below
       ``low``, and in between as it was before.
    3. *Masked histogram.* The robot turns on arcs of the radius v / turn_rate. A reading nearer
       than radius + margin to the centre's side of such an arc,

           (V3)  |reading - centre| < v / turn_rate + radius + margin,

       blocks the sectors beyond its bearing on that side.
    4. *Selection.* Of an opening narrower than ``wide`` the middle is a candidate, of any other
       the directions wide / 2 inside its borders, and that to the goal if it lies between them.
       The direction c with the least

           (V4)  to_goal |c - goal| + to_heading |c - heading| + to_previous |c - previous|

       is chosen.

    The paper weighs the cells of a grid in which sonar readings gather; here the scan is
    complete at every step, so each reading counts as a cell that is certain, and none is
    remembered. Where all is blocked the robot stands still. The paper leaves the speed to
    the robot; here it falls with the height of the sector ahead, as that of the first VFH does
    (J. Borenstein, Y. Koren, *IEEE Transactions on Robotics and Automation* 7(3), 1991), and by
    the cosine of what is left to turn. Readings from beyond the goal do not count.

    It knows no map: it has range readings all round, of `BEAMS` rays, and its own pose. The
    defaults come from a small search in random worlds, but for the weights, which are the
    paper's; the paper's wide opening is 16 sectors, 80 degrees.

    Parameters
    ----------
    reach : float
        Of the scanner (m).
    margin : float
        Security distance between the body and an obstacle (m).
    low, high : float
        Thresholds of the histogram: so many readings near by.
    wide : float
        Width of the narrowest wide opening (rad).
    to_goal, to_heading, to_previous : float
        Weights of the selection: 5, 2 and 2 in the paper, which asks the first to be more than
        the others together.
    speed : float
        Top speed (m/s).
    steering : float
        Turn rate over the angle left to turn (1/s).
    turn_rate : float
        Largest turn rate (rad/s).
    approach : float
        Largest speed over the distance from the goal (1/s).
    sectors : int
        How many the histogram has: 72, of five degrees, in the paper.

    Raises
    ------
    InvalidParameter
        For a gain that is negative, not finite or zero, but for the margin, the weights and the
        lower threshold, which may be zero; a threshold ``low`` above ``high``; or under 8
        sectors, or over `MOST_SECTORS`.

    Notes
    -----
    Checked against the beginning of the paper, the four stages, and against a public program
    written after it: (V2), sectors of five degrees, both thresholds, the wide opening, and a
    first weight above the sum of the others. There a reading at the rim still weighs a
    little; by (V1) it weighs nothing.
    """

    reach: float = 0.65
    margin: float = 0.003
    low: float = 1.1
    high: float = 1.5
    wide: float = 0.35
    to_goal: float = 5.0
    to_heading: float = 2.0
    to_previous: float = 2.0
    speed: float = SPEED
    steering: float = 2.2
    turn_rate: float = 6.0
    approach: float = 1.0
    sectors: int = 72

    def __post_init__(self):
        check_gains(self, "margin", "low", "to_goal", "to_heading", "to_previous")
        object.__setattr__(
            self, "sectors", checks.whole("sectors", self.sectors, 8, most=MOST_SECTORS)
        )
        if self.low > self.high:
            raise InvalidParameter(f"low is {self.low:g}, above high, {self.high:g}; give less")

    def start(self, scene: Any, goal: ArrayLike, robot: Robot, dt: float) -> Law:
        """The law for one drive, see `Reactive.start`."""
        goal, robot = check_drive(scene, goal, robot, dt)
        at = outlines_of(scene)

        def start_one():
            was_blocked, previous, v = np.zeros(self.sectors, bool), None, 0.0

            def law(t, pose):
                nonlocal was_blocked, previous, v
                to_goal = goal - pose[:2]
                left = float(np.hypot(*to_goal))
                target, heading = np.arctan2(to_goal[1], to_goal[0]), float(pose[2])
                bearing, distance = scan(at(t), pose, self.reach)
                # What is farther away than the robot at its goal would be does not matter.
                counts = distance <= min(self.reach, left + robot.radius + self.margin)
                readings = bearing[counts], distance[counts]
                height = self.histogram(*readings, robot)
                was_blocked = self.binary(height, was_blocked)
                blocked = self.masked(was_blocked, *readings, heading, v / self.turn_rate, robot)
                before = heading if previous is None else previous
                previous = self.select(blocked, target, heading, before)
                if previous is None:
                    v = 0.0
                    return v, 0.0
                ahead = height[round(heading / self._sector) % self.sectors]
                v = min(self.speed, self.approach * left) * max(1 - ahead / self.high, 0)
                error = wrap_angle(previous - heading)
                v, omega = steer(error, v, self.steering, self.turn_rate)
                return v, omega

            return law

        return for_each(start_one)

    @property
    def _sector(self):
        """Width of a sector (rad)."""
        return 2 * np.pi / self.sectors

    @property
    def _directions(self):
        """Middle of every sector (rad), shape (sectors,)."""
        return self._sector * np.arange(self.sectors)

    def histogram(self, bearing: np.ndarray, distance: np.ndarray, robot: Robot) -> np.ndarray:
        """Stage 1: height of every sector, shape (sectors,).

        Parameters
        ----------
        bearing : ndarray, shape (k,)
            Directions of readings (rad), from the x-axis.
        distance : ndarray, shape (k,)
            Their distances (m), up to the reach.
        robot : Robot
            Robot.
        """
        weight = 1 - (distance / self.reach) ** 2
        sine = np.minimum((robot.radius + self.margin) / np.maximum(distance, TINY), 1)
        # Two directions are within gamma where their unit vectors' product is above its cosine.
        cosine = np.sqrt(1 - sine**2)
        covers = unit(self._directions) @ unit(bearing).T >= cosine
        return covers @ weight

    def binary(self, height: np.ndarray, was_blocked: np.ndarray) -> np.ndarray:
        """Stage 2: which sectors are blocked, after which were, shape (sectors,)."""
        return (height > self.high) | (was_blocked & (height >= self.low))

    def masked(
        self,
        blocked: np.ndarray,
        bearing: np.ndarray,
        distance: np.ndarray,
        heading: float,
        turning_radius: float,
        robot: Robot,
    ) -> np.ndarray:
        """Stage 3: which sectors are blocked, or cannot be turned to, shape (sectors,).

        Parameters
        ----------
        blocked : ndarray of bool, shape (sectors,)
            From stage 2.
        bearing, distance, robot
            As for stage 1.
        heading : float
            The robot's (rad).
        turning_radius : float
            Radius of the arcs on which it turns (m); zero on the spot, which no reading bars.
        """
        if not turning_radius:
            return blocked
        to_left = wrap_angle(bearing - heading)
        beside = distance * np.sin(to_left)
        # From the left and the right centre, by the law of cosines.
        squared = distance**2 + turning_radius**2 - 2 * turning_radius * np.abs(beside)
        barred = squared < (turning_radius + robot.radius + self.margin) ** 2
        most_left = to_left[barred & (beside > 0)].min(initial=np.pi)
        most_right = to_left[barred & (beside < 0)].max(initial=-np.pi)
        direction = wrap_angle(self._directions - heading)
        return blocked | (direction < most_right) | (direction > most_left)

    def select(
        self, blocked: np.ndarray, goal: float, heading: float, previous: float
    ) -> float | None:
        """Stage 4: the best direction (rad); None where all are blocked.

        Parameters
        ----------
        blocked : ndarray of bool, shape (sectors,)
            From stage 3.
        goal, heading, previous : float
            Direction to the goal, the robot's, and that selected before (rad).
        """
        found = np.array(self._candidates(blocked, goal))
        if not len(found):
            return None
        wanted = np.array([[goal], [heading], [previous]])
        weights = self.to_goal, self.to_heading, self.to_previous
        return float(found[np.argmin(weights @ np.abs(wrap_angle(found - wanted)))])

    def _candidates(self, blocked, goal):
        """Directions (rad) among which stage 4 selects, a list."""
        if not blocked.any():
            return [goal]
        # Seen from a blocked sector on, no opening is cut in two.
        first = int(np.argmax(blocked))
        changes = np.flatnonzero(np.diff(np.roll(blocked, -first), append=True))
        found = []
        for before, last in changes.reshape(-1, 2):
            right, width = (first + before + 1) * self._sector, (last - before - 1) * self._sector
            if width <= self.wide:
                found.append(right + width / 2)
                continue
            found += [right + self.wide / 2, right + width - self.wide / 2]
            if self.wide / 2 <= (goal - right) % (2 * np.pi) <= width - self.wide / 2:
                found.append(goal)
        return found
