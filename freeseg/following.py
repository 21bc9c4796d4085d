"""Laws that plan once, and then follow their plan by a tracker."""

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import wrap_angle
from freeseg.planners import shortest_path, time_minimal_plan
from freeseg.reactive.sensing import check_drive, steer
from freeseg.reference import SPEED, Reference, make_reference, timed_reference
from freeseg.replanning import SIGHT_NOISE, Estimates
from freeseg.robot import Robot
from freeseg.scene import Mover, Scene, check_scene
from freeseg.segments import MARGIN
from freeseg.trackers.feedback import Law, Tracker, check_tracker
from freeseg.trackers.kanayama import Kanayama
from freeseg.world import Disc, World

#: Nearer to the goal than this (m), once its reference has ended, a robot drives there straight.
DOCKING = 0.03

#: Gains of that: speed over distance (1/s), turn rate over angle (1/s), and the largest turn
#: rate (rad/s).
APPROACH, STEERING, TURN_RATE = 2.0, 4.0, 3.0

#: Accelerations that are tried for a timed reference which turns faster than that, each half of the
#: one before.
GENTLER = 3

#: How fast a robot turns in place before it follows (rad/s), and by what angle (rad) it need not.
#: A plan that takes the time of the turn into account may ask for another turn, so often at most.
TURNING, ALIGNED, TURNS_TRIED = 2.5, 1e-3, 8


@dataclass(frozen=True)
class Following:
    """Law that plans when it starts to drive, and follows its plan.

    What it makes of movers is said by two switches. With neither it drives
    blindly along the shortest path among what stands.

    Parameters
    ----------
    tracker : Tracker
        What follows; by default Kanayama's law.
    timed : bool
        Whether the plan is the one of `time_minimal_plan`, for which the
        scene has to say how its movers move: with perfect knowledge, that is.
    keep_out : bool
        Whether the tracker, an `Mpc`, keeps out of all obstacles where they
        are foreseen: movers by `Estimates` of what is seen of them, see `observe`.
    speed : float
        Top speed (m/s).
    reserve : float
        Share of that speed that a timed plan leaves to the tracker, to
        catch up with.
    acceleration : float
        Of the reference (m/s^2); of a timed one at most, see the notes.
    margin : float
        Security margin delta (m).
    noise : float
        Standard deviation of an observed position (m), as it is told.

    Raises
    ------
    InvalidParameter
        For a number that is out of range, what is no tracker, or one that cannot keep out of
        obstacles but is to.

    Notes
    -----
    The robot first turns in place, to where its reference begins, and then follows: a tracker
    that has to turn it while its reference drives on swings wide. A timed plan is made for
    where the movers are when it has turned, and half of its reference's lateness has passed,
    see `timed_reference`; that nothing comes while it turns is not looked at. Where a path waits
    it may bend sharply: an acceleration that makes the reference turn faster than the robot is to
    is halved, up to twice, which rounds the bends. A tracker that
    keeps out is told that the wheels reach the top speed and no more, so that it never counts
    on more.
    """

    tracker: Tracker = field(default_factory=Kanayama)
    timed: bool = False
    keep_out: bool = False
    speed: float = SPEED
    reserve: float = 0.02
    acceleration: float = 0.5
    margin: float = 2 * MARGIN
    noise: float = SIGHT_NOISE

    def __post_init__(self) -> None:
        check_tracker(self.tracker)
        for name in ("timed", "keep_out"):
            checks.flag(name, getattr(self, name))
        for name in ("speed", "acceleration"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        for name in ("margin", "noise"):
            object.__setattr__(self, name, checks.not_negative(name, getattr(self, name)))
        reserve = checks.number(
            "reserve", self.reserve, lambda found: 0 <= found < 1, "a share from 0 to below 1"
        )
        object.__setattr__(self, "reserve", reserve)
        if self.keep_out and not hasattr(self.tracker, "obstacles"):
            raise InvalidParameter(
                f"keep_out is True, but tracker is {checks.shown(self.tracker)}, which knows of "
                "no obstacles; give an Mpc"
            )

    def start(self, scene: Any, goal: ArrayLike, robot: Robot, dt: float) -> Law:
        """The law for one drive of one robot, see `Reactive.start`.

        It plans at its first step, and raises what the planner then raises.
        """
        goal, robot = check_drive(scene, goal, robot, dt)
        scene = check_scene(scene)
        if self.keep_out:
            rate = min(robot.max_wheel_rate, self.speed / robot.wheel_radius)
            robot = replace(robot, max_wheel_rate=rate)
        begun: list[tuple[Reference, Law, float, float]] = []

        def law(t, pose):
            if not begun:
                begun.append(self._begin(scene, pose, goal, robot, dt))
            reference, track, turned, rate = begun[0]
            if t < turned:
                return 0.0, rate
            to = goal - pose[:2]
            left = math.hypot(*to)
            if t - turned < reference.duration or (self.keep_out and left > DOCKING):
                return track(t - turned, pose)
            error = wrap_angle(np.arctan2(to[1], to[0]) - pose[2])
            return steer(error, min(self.speed, APPROACH * left), STEERING, TURN_RATE)

        return law

    def _begin(
        self, scene: Scene, pose: np.ndarray, goal: np.ndarray, robot: Robot, dt: float
    ) -> tuple[Reference, Law, float, float]:
        """The reference from a pose, the tracker's law; and till when (s), how fast it turns."""
        turned = rate = 0.0
        for _ in range(TURNS_TRIED):
            reference = self._reference(scene_after(scene, turned), pose[:2], goal, robot)
            angle = float(wrap_angle(reference.pose[2, 0] - pose[2]))
            needed = dt * math.ceil(abs(angle) / (TURNING * dt)) if abs(angle) > ALIGNED else 0.0
            # Later than it had to be is no harm.
            turned, enough = max(turned, needed), needed <= turned
            rate = angle / turned if turned else 0.0
            if enough:
                break
        tracker: Any = self.tracker
        if self.keep_out:
            estimates = Estimates(scene, dt, self.noise, self.speed)
            tracker = replace(tracker, obstacles=lambda t: self._grown(estimates.at(t + turned)))
        return reference, tracker.start(reference, robot, dt), turned, rate

    def _reference(
        self, scene: Scene, place: np.ndarray, goal: np.ndarray, robot: Robot
    ) -> Reference:
        """What is followed from a place (m), in a scene from then on."""
        if not self.timed:
            plan = shortest_path(scene.world, place, goal, robot, self.margin)
            return make_reference(plan, speed=self.speed, acceleration=self.acceleration)
        speed, acceleration = (1 - self.reserve) * self.speed, self.acceleration
        for _ in range(GENTLER):
            later = scene_after(scene, speed / acceleration / 2)
            timed = time_minimal_plan(later, place, goal, speed, robot, self.margin)
            reference = timed_reference(timed, acceleration)
            if np.abs(reference.omega).max() <= TURN_RATE:
                break
            acceleration /= 2
        return reference

    def _grown(self, scene: Scene) -> Scene:
        """All obstacles as movers that are larger by half of the margin, as the planners' are."""
        movers = [*(Mover(obstacle) for obstacle in scene.world), *scene.movers]
        return Scene(World([]), [_larger(mover, self.margin / 2) for mover in movers])


def _larger(mover: Mover, by: float) -> Mover:
    """A mover that is larger (m); what is no disc stays, for the tracker to refuse it."""
    disc = mover.obstacle
    if not isinstance(disc, Disc):
        return mover
    return replace(mover, obstacle=Disc(disc.center, disc.radius + by))


def scene_after(scene: Scene, t: float) -> Scene:
    """The scene from a time (s) on, which then is time zero."""
    return Scene(scene.world, [_mover_after(mover, t) for mover in scene.movers])


def _mover_after(mover: Mover, t: float) -> Mover:
    """A mover from a time (s) on."""
    if mover.shift is None:
        return replace(mover, obstacle=mover.at(t))
    return replace(
        mover,
        obstacle=mover.at(t),
        shift=lambda times: mover.shifts(times + t) - mover.shifts(t),
    )
