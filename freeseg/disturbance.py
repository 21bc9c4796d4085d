"""What disturbs a robot: noise, slip, wrong sizes, lag and delay."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import exp, expm1, isclose

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.robot import Robot, reached_speeds, with_wheel_base

#: How many samples of random numbers are drawn at once: what bounds their memory.
BLOCK = 32

#: Random numbers of a robot per sample: noise of x, y and heading; slip of both wheels.
CHANNELS = 5


@dataclass(frozen=True)
class Disturbance:
    """What keeps a robot from doing what it is told; by default, nothing.

    The tracker and the limits know of none of it. A pair is for the right
    and the left wheel; one number stands for both.

    Parameters
    ----------
    position_noise : float
        Standard deviation of the measured x and of the measured y (m): white
        Gaussian noise, new at every sample.
    heading_noise : float
        Standard deviation of the measured heading (rad), likewise.
    slip : float or pair of float
        Share of a wheel's travel that is lost, below 1; negative if it slides on.
    slip_fluctuation : float
        Standard deviation of the random share that is added to it, wheel by
        wheel: an Ornstein-Uhlenbeck process, stationary from the first sample on. The
        sum is kept within -1 and 1.
    slip_time : float
        Correlation time of this process (s).
    wheel_base_error : float
        How much longer than the robot's the true wheel base is, relative.
    wheel_radius_error : float or pair of float
        How much larger than the robot's the true wheel radius is, relative.
    lag : float
        Time constant of the motors, first order (s).
    delay : float
        Time after which a command reaches the motors (s): a whole number of
        time steps. Until the first arrives, the robot rests.

    Raises
    ------
    InvalidParameter
        For a value that is no finite number or out of its range.

    Examples
    --------
    >>> Disturbance(position_noise=0.001, slip=(0.05, 0)).slip
    (0.05, 0.0)
    """

    position_noise: float = 0.0
    heading_noise: float = 0.0
    slip: float | tuple[float, float] = 0.0
    slip_fluctuation: float = 0.0
    slip_time: float = 1.0
    wheel_base_error: float = 0.0
    wheel_radius_error: float | tuple[float, float] = 0.0
    lag: float = 0.0
    delay: float = 0.0

    def __post_init__(self):
        for name in ("position_noise", "heading_noise", "lag", "delay"):
            self._check(name, lambda found: found >= 0, "zero or more")
        self._check("slip_fluctuation", lambda found: 0 <= found < 1, "from 0 to below 1")
        self._check("slip_time", lambda found: found > 0, "above 0")
        self._check("wheel_base_error", lambda found: found > -1, "above -1")
        self._check_pair("slip", lambda found: abs(found) < 1, "between -1 and 1")
        self._check_pair("wheel_radius_error", lambda found: found > -1, "above -1")

    def _check(self, name, valid, bounds):
        """Make a field a float, or raise."""
        remedy = f"a finite number, {bounds}"
        found = checks.number(f"disturbance.{name}", getattr(self, name), valid, remedy)
        object.__setattr__(self, name, found)

    def _check_pair(self, name, valid, bounds):
        """Make a field a pair of floats, right and left; one number stands for both."""
        remedy = f"a finite number, or a pair of them, {bounds}"
        found = checks.pair(f"disturbance.{name}", getattr(self, name), valid, remedy)
        object.__setattr__(self, name, found)

    @property
    def noisy(self) -> bool:
        """Whether the measured pose differs from the true one."""
        return bool(self.position_noise or self.heading_noise)

    def delayed_steps(self, dt: float) -> int:
        """Time steps by which a command is late.

        Parameters
        ----------
        dt : float
            Time step (s).

        Raises
        ------
        InvalidParameter
            For a delay that is not a whole number of them, or a time step that
            is not positive.
        """
        dt = checks.positive("dt", dt)
        steps = np.rint(self.delay / dt)
        if not isclose(steps * dt, self.delay, rel_tol=1e-6):
            raise InvalidParameter(
                f"disturbance.delay is {self.delay:g} s, no whole number of time steps of "
                f"{dt:g} s; give {np.floor(self.delay / dt) * dt:g} or "
                f"{np.ceil(self.delay / dt) * dt:g} s, or change dt"
            )
        return int(steps)

    def lag_shares(self, dt: float) -> tuple[float, float]:
        """What a time step leaves of the difference of a wheel from its target.

        Parameters
        ----------
        dt : float
            Time step (s).

        Returns
        -------
        mean, end : float
            On average over the step, and at its end.

        Raises
        ------
        InvalidParameter
            For a time step that is not positive.
        """
        dt = checks.positive("dt", dt)
        if not self.lag:
            return 0.0, 0.0
        return -expm1(-dt / self.lag) * self.lag / dt, exp(-dt / self.lag)

    def samples(
        self, shape: tuple[int, ...], count: int, dt: float, seed: int | tuple[int, ...]
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """What disturbs measurement and wheels, sample by sample.

        Parameters
        ----------
        shape : tuple of int
            ``()`` for one robot, ``(n,)`` for a batch.
        count : int
            How many are asked for.
        dt : float
            Time between them (s).
        seed : int or tuple of int
            Seed, see `simulate`.

        Yields
        ------
        noise : ndarray, shape (3, ...)
            What is added to x, y (m) and heading (rad).
        rolled : ndarray, shape (2, ...) or (2, 1)
            Distance over the ground of the right and the left wheel, relative
            to that which turning without slip and with the robot's own wheel
            radius would make.
        """
        ones = (1,) * len(shape)
        slip = np.reshape(self.slip, (2, *ones))
        radius = 1 + np.reshape(self.wheel_radius_error, (2, *ones))
        deviation = np.reshape([self.position_noise] * 2 + [self.heading_noise], (3, *ones))
        if not (self.noisy or self.slip_fluctuation):
            still, rolled = np.zeros((3, *ones)), radius * (1 - slip)
            for _ in range(count):
                yield still, rolled
            return
        drawn = normals(seed, shape, count)
        yield from shaken(drawn, deviation, slip, radius, self.slip_fluctuation, self.slip_time, dt)

    def plant(self, robot: Robot) -> Robot:
        """The robot as it is: `robot` with its true wheel base."""
        return with_wheel_base(robot, robot.wheel_base * (1 + self.wheel_base_error))


def shaken(
    numbers: Iterable[np.ndarray],
    deviation: np.ndarray,
    slip: np.ndarray,
    radius: float | np.ndarray,
    fluctuation: float | np.ndarray,
    slip_time: float,
    dt: float,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """As `Disturbance.samples`, of standard normal numbers, (5, *shape) a sample.

    Parameters
    ----------
    numbers : iterable of ndarray
        As `normals` yields them.
    deviation : ndarray, shape (3, *shape)
        Standard deviations of what is measured.
    slip, radius : ndarray, shape (2, *shape)
        Share of its travel that each wheel loses, and its true radius, relative.
    fluctuation : float or ndarray, shape (*shape)
        Standard deviation of the process that is added to the slip.
    slip_time, dt : float
        Correlation time of the process, and time between samples (s).
    """
    # The process at the samples, exactly: what is left of it, and what is new.
    kept = exp(-dt / slip_time)
    new = fluctuation * (-expm1(-2 * dt / slip_time)) ** 0.5
    process = None
    for normal in numbers:
        fresh = normal[3:]
        process = fluctuation * fresh if process is None else kept * process + new * fresh
        yield deviation * normal[:3], radius * (1 - np.clip(slip + process, -1, 1))


class Motors:
    """Delay, limits and lag between a command and the wheels.

    Parameters
    ----------
    robot : Robot
        Its limits count.
    disturbance : Disturbance
        Its delay and its lag count.
    dt : float
        Time step (s).
    steps : int
        Of how many steps the run is: what is later than its end never arrives.
    batch : tuple of int, optional
        ``()`` for one robot, ``(n,)`` for a batch.

    Attributes
    ----------
    asked : ndarray, shape (2, *batch)
        Wheel speeds (m/s) asked for last, within the limits.
    speed : ndarray, shape (2, *batch)
        Those that the motors have reached by the end of the last step (m/s).
    """

    def __init__(
        self,
        robot: Robot,
        disturbance: Disturbance,
        dt: float,
        steps: int,
        batch: tuple[int, ...] = (),
    ):
        self.robot, self.dt, self.lag = robot, dt, disturbance.lag
        self.mean_share, self.end_share = disturbance.lag_shares(dt)
        self.asked = self.speed = np.zeros((2, *batch))
        self.underway = deque([self.asked] * min(disturbance.delayed_steps(dt), steps))

    def follow(self, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Wheel speeds (m/s) for a time step, shape (2, *batch): asked for, and their mean."""
        self.underway.append(command)
        self.asked = reached_speeds(self.robot, self.underway.popleft(), self.asked, self.dt)
        if not self.lag:
            self.speed = self.asked
            return self.asked, self.asked
        missing = self.speed - self.asked
        self.speed = self.asked + self.end_share * missing
        return self.asked, self.asked + self.mean_share * missing


def normals(
    seed: int | tuple[int, ...], shape: tuple[int, ...], samples: int
) -> Iterator[np.ndarray]:
    """Standard normal numbers, sample by sample, each robot's its own.

    Parameters
    ----------
    seed : int or tuple of int
        Seed; the index of the first robot, 0 if there is none; and after how
        many robots the numbers come again, never if there is none.
    shape : tuple of int
        ``()`` for one robot, ``(n,)`` for a batch.
    samples : int
        How many are asked for.

    Yields
    ------
    ndarray, shape (5, *shape)
        One sample. A robot's depend on the seed and on its index alone, not
        on who else is in the batch nor on how many samples are asked for.
    """
    count = int(np.prod(shape))
    entropy, first, *again = checks.seed(seed)
    robots = min([count, *again])
    streams = [
        np.random.default_rng(np.random.SeedSequence(entropy, spawn_key=(first + index,)))
        for index in range(robots)
    ]
    for begin in range(0, samples, BLOCK):
        drawn = np.empty((len(streams), min(BLOCK, samples - begin), CHANNELS))
        for stream, rows in zip(streams, drawn, strict=True):
            stream.standard_normal(out=rows)
        drawn = np.ascontiguousarray(np.moveaxis(drawn, 0, -1)[..., np.arange(count) % robots])
        yield from drawn.reshape(-1, CHANNELS, *shape)


def as_disturbance(disturbance: Disturbance | None) -> Disturbance:
    """`disturbance`, none of it for None; `InvalidParameter` for anything else."""
    if disturbance is None:
        return Disturbance()
    return checks.instance("disturbance", disturbance, Disturbance, "a Disturbance")
