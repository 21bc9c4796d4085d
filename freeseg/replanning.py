"""Planning again at every time step, on obstacles that are observed with noise."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter, InvalidQuery, InvalidWorld, NoPath, Trapped
from freeseg.geometry import wrap_angle
from freeseg.planners import time_search
from freeseg.planners.compilation import compiled
from freeseg.planners.time_minimal import TimedPlan, time_minimal_plan
from freeseg.reactive.sensing import check_drive, steer
from freeseg.reference import SPEED
from freeseg.robot import Robot
from freeseg.scene import Mover, Scene, check_scene
from freeseg.segments import MARGIN
from freeseg.world import Disc

#: Standard deviation (m) of an observed position. An assumption.
SIGHT_NOISE = 0.002

#: What a mover's velocity may change by (m/s in the square root of a second), for the filter.
#: An assumption: those of the study keep theirs.
DRIFT = 0.005

#: Movers are taken to be so much slower, at least, than the robot plans to drive (relative).
SLOWER = 1e-3

#: What a robot does at a time step for which there is no plan.
FALLBACKS = ("keep", "brake")


def observe(scene: Any, noise: float = SIGHT_NOISE, seed: int = 0, dt: float = 0.05) -> Scene:
    """A scene as a robot sees it: its movers jump about where they are.

    Parameters
    ----------
    scene : World or Scene
        Obstacles.
    noise : float, optional
        Standard deviation of an observed x and of a y (m), new every `dt`.
    seed : int, optional
        Of the noise.
    dt : float, optional
        Time between two observations (s).

    Returns
    -------
    Scene
        The same at every call: who asks twice at a time is told the same. No
        velocity is known of its movers.

    Raises
    ------
    InvalidQuery
        For what is no scene.
    InvalidParameter
        For a noise that is negative, no seed, or a time that is not positive.

    Examples
    --------
    >>> from freeseg.world import World
    >>> scene = Scene(World([]), [Mover(Disc((0, 0), 0.1), velocity=(0.1, 0))])
    >>> seen = observe(scene, noise=0.001, seed=1)
    >>> (seen.movers[0].at(2.0).center - scene.movers[0].at(2.0).center).round(4).tolist()
    [0.0001, 0.0013]
    """
    scene = check_scene(scene)
    noise, dt = checks.not_negative("noise", noise), checks.positive("dt", dt)
    seed = checks.whole("seed", seed)
    return Scene(
        scene.world, [_seen(mover, noise, (seed, k), dt) for k, mover in enumerate(scene.movers)]
    )


def _seen(mover: Mover, noise: float, seed: tuple[int, int], dt: float) -> Mover:
    """A mover with noise on where it is."""
    if not isinstance(mover.obstacle, Disc):
        raise InvalidWorld("a mover is a Polygon; give the Disc round it")

    def noise_at(times: np.ndarray) -> np.ndarray:
        steps = np.rint(times / dt).astype(int)
        return np.array([np.random.default_rng((*seed, k)).normal(0, noise, 2) for k in steps])

    first = noise_at(np.zeros(1))[0]
    disc = Disc(mover.obstacle.center + first, mover.obstacle.radius)
    return Mover(
        disc,
        shift=lambda times: mover.shifts(times) + noise_at(times) - first,
        growth=mover.growth,
    )


class Estimates:
    """Where movers are and how they move, by a Kalman filter of what is seen of them.

    Parameters
    ----------
    scene : Scene
        As it is seen, see `observe`. Only where its movers are at the present
        time is used, and nothing of their velocities.
    dt : float
        Time between two observations (s).
    noise : float
        Standard deviation of an observed position (m).
    speed : float
        No mover is faster (m/s).

    Notes
    -----
    A constant velocity is drawn to zero by what the top speed leaves likely at
    first, so that the first observations, in which noise outweighs motion, are
    no wild guesses. The gains are the same for all movers, for all are seen alike.
    """

    def __init__(self, scene: Scene, dt: float, noise: float, speed: float) -> None:
        self.scene, self.dt, self.speed = scene, dt, speed
        self.noise = max(noise, 1e-6 * speed * dt)
        self.last, self.known = -math.inf, scene
        self.place = self.velocity = np.zeros((len(scene.movers), 2))
        self.covariance = np.diag([math.inf, speed**2 / 4])

    def at(self, t: float) -> Scene:
        """The scene from a time (s) on, which is its time zero, with constant velocities."""
        if t != self.last:
            self._correct(t)
            self.known = Scene(self.scene.world, list(self._movers(t)))
            self.last = t
        return self.known

    def _correct(self, t: float) -> None:
        """Take in what is seen at a time (s)."""
        seen = np.array([mover.at(t).center for mover in self.scene.movers]).reshape(-1, 2)  # type: ignore[union-attr]
        if math.isinf(self.last):
            self.place = seen
            self.covariance[0, 0] = self.noise**2
            return
        step = t - self.last
        move = np.array([[1, step], [0, 1]])
        self.covariance = move @ self.covariance @ move.T
        # White acceleration, over a step.
        self.covariance += DRIFT**2 * np.array([[step**3 / 3, step**2 / 2], [step**2 / 2, step]])
        gain = self.covariance[:, 0] / (self.covariance[0, 0] + self.noise**2)
        self.place = self.place + step * self.velocity
        surprise = seen - self.place
        self.place = self.place + gain[0] * surprise
        self.velocity = self.velocity + gain[1] * surprise
        self.covariance = self.covariance - np.outer(gain, self.covariance[0])

    def _movers(self, t: float):
        """Movers as they are estimated to be at a time (s) and to go on."""
        pace = np.hypot(*self.velocity.T)
        share = np.minimum(1, self.speed / np.maximum(pace, 1e-12))
        for mover, place, velocity in zip(
            self.scene.movers, self.place, share[:, None] * self.velocity, strict=True
        ):
            radius = mover.obstacle.radius + mover.growth * t
            yield Mover(Disc(place, radius), velocity=velocity, growth=mover.growth)


@dataclass(frozen=True)
class Replanning:
    """Law that plans the earliest arrival again at every time step.

    At every step the robot sees where the movers are, estimates how they move,
    plans by `time_minimal_plan` from where it is, and turns towards where
    that plan is a moment later. What the plan takes for granted, a point that has
    its speed at once and in any direction, the next plan puts right.

    Parameters
    ----------
    speed : float
        That it plans with, and drives at (m/s). Movers have to be slower; one that
        seems to be faster is taken to be as fast as this allows.
    margin : float
        Security margin delta (m).
    noise : float
        Standard deviation of an observed position (m), as it is told. An
        assumption.
    reach : float
        Movers that are farther away (m) from the robot's centre are not in its
        plans; infinite for all that there are.
    ahead : float
        How far ahead on the plan it steers for (s).
    fallback : {"keep", "brake"}
        What it does where there is no plan: follow the last one, which it does in the
        time of that plan, or stop.
    steering, turn_rate : float
        Turn rate over the angle left to turn (1/s), and the largest one
        (rad/s).

    Raises
    ------
    InvalidParameter
        For a number that is negative or not finite, but for the reach, or a fallback
        that is none.

    Examples
    --------
    >>> import freeseg as fs
    >>> scene = fs.Scene(fs.World([]), [fs.Mover(fs.Disc((0.5, 0.3), 0.05), (0, -0.06))])
    >>> run = fs.react(fs.Replanning(), scene, (0, 0), (1, 0))
    >>> run.collision is None
    True
    """

    speed: float = SPEED
    margin: float = 2 * MARGIN
    noise: float = SIGHT_NOISE
    reach: float = math.inf
    ahead: float = 0.1
    fallback: str = "keep"
    steering: float = 6.0
    turn_rate: float = 3.0

    def __post_init__(self) -> None:
        reach = checks.as_float(self.reach)
        if not reach > 0:
            raise InvalidParameter(
                f"reach is {checks.shown(self.reach)}; give a distance (m), or inf for no limit"
            )
        object.__setattr__(self, "reach", reach)
        for name in ("margin", "noise"):
            object.__setattr__(self, name, checks.not_negative(name, getattr(self, name)))
        for name in ("speed", "ahead", "steering", "turn_rate"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        checks.choice("fallback", self.fallback, FALLBACKS)

    def start(self, scene: Any, goal: ArrayLike, robot: Robot, dt: float) -> "ReplanningLaw":
        """The law for one drive of one robot, see `Reactive.start`.

        Obstacles are given as they are seen, see `observe`.

        Returns
        -------
        Law
            It counts its steps, ``planned`` and ``missed``, those without a plan.

        Raises
        ------
        InvalidWorld
            For a mover that is no disc.
        """
        goal, robot = check_drive(scene, goal, robot, dt)
        scene = check_scene(scene)
        for number, mover in enumerate(scene.movers, 1):
            if not isinstance(mover.obstacle, Disc):
                raise InvalidWorld(f"mover {number} is a Polygon; give the Disc round it")
        return ReplanningLaw(self, scene, goal, robot, dt)


class ReplanningLaw:
    """What `Replanning` starts.

    Attributes
    ----------
    planned, missed : int
        Time steps with and without a plan.
    """

    def __init__(
        self, gains: Replanning, scene: Scene, goal: np.ndarray, robot: Robot, dt: float
    ) -> None:
        self.gains, self.goal, self.robot = gains, goal, robot
        self.estimates = Estimates(scene, dt, gains.noise, (1 - SLOWER) * gains.speed)
        self.planned = self.missed = 0
        # Over hundreds of plans that pays however few obstacles there are.
        compiled(time_search)
        self.plan: TimedPlan | None = None
        self.since = 0.0

    def __call__(self, t: float, pose: np.ndarray) -> tuple[float, float]:
        """Forward speed (m/s) and turn rate (rad/s) at a time (s) and a pose."""
        checks.numbers("pose", pose, 3)
        gains, place = self.gains, np.asarray(pose[:2])
        is_new = self._plan(t, place)
        if self.plan is None or not (is_new or gains.fallback == "keep"):
            return 0.0, 0.0
        to = self.plan.path.at(t - self.since + gains.ahead)[0][:2] - place
        error = wrap_angle(np.arctan2(to[1], to[0]) - pose[2])
        speed = min(gains.speed, math.hypot(*to) / gains.ahead)
        return steer(error, speed, gains.steering, gains.turn_rate)

    def _plan(self, t: float, place: np.ndarray) -> bool:
        """Plan from a place (m) at a time (s); whether there is a plan."""
        gains = self.gains
        scene = self.estimates.at(t)
        near = scene.distances(place, 0.0)[len(scene.world) :] < gains.reach
        movers = [mover for mover, is_near in zip(scene.movers, near, strict=True) if is_near]
        try:
            self.plan = time_minimal_plan(
                Scene(scene.world, movers), place, self.goal, gains.speed, self.robot, gains.margin
            )
        except (NoPath, Trapped, InvalidQuery):
            # InvalidQuery where a mover seems to be on the robot, or on its goal for good.
            self.missed += 1
            return False
        self.since = t
        self.planned += 1
        return True
