"""Paths in time among obstacles that move: straight motions and slides on moving discs."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import angle_of, cross, read_only, unit, wrap_angle

#: Gauss's nodes and weights on [0, 1]: over a short part of a slide they are exact to round-off.
_nodes, _weights = np.polynomial.legendre.leggauss(8)
NODES, WEIGHTS = read_only((1 + _nodes) / 2), read_only(_weights / 2)

#: A slide is integrated over parts of at most this angle (rad), as a share of how near its
#: integrand comes to a singularity; and over this one at most.
SHARE, WIDEST_PART = 0.7, 0.2

#: Newton's method doubles its digits so many times.
DOUBLINGS = 5

#: How far pieces may be apart in place (m) and, relatively, in time: round-off of long sums.
APART = 1e-7

#: Times at which a timed path is looked at to draw or to measure it.
MOMENTS = 2000


@dataclass(frozen=True, eq=False)
class Straight:
    """A straight motion of constant velocity.

    Parameters
    ----------
    start : array_like, shape (2,)
        First point (m).
    velocity : array_like, shape (2,)
        Velocity (m/s).
    begin, end : float
        First and last time (s).
    """

    start: np.ndarray
    velocity: np.ndarray
    begin: float
    end: float

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m) and velocities (m/s) at times (k,), each of shape (k, 2)."""
        velocity = np.broadcast_to(self.velocity, (len(t), 2))
        return self.start + (t - self.begin)[:, None] * self.velocity, velocity


@dataclass(frozen=True, eq=False)
class Slide:
    """A motion of constant speed on the rim of a disc that moves, and may grow.

    Parameters
    ----------
    center, velocity : array_like, shape (2,)
        Centre at time zero (m), and its velocity (m/s).
    radius, growth : float
        Radius at time zero (m), and its growth (m/s).
    angle : float
        Direction from the centre in which the slide begins (rad).
    sweep : float
        Angle covered as seen from the centre (rad), positive counter-clockwise.
    begin : float
        First time (s).
    speed : float
        Speed of what slides (m/s), above that of every place of the rim.

    Notes
    -----
    With the normal n and the direction e of the slide, its velocity is
    u + g n + s e of length V, so s turns it by s dt / R: a smooth integral over
    the angle, of which Gauss and Legendre's sum is exact to round-off. A
    growing disc makes a logarithmic spiral.
    """

    center: np.ndarray
    velocity: np.ndarray
    radius: float
    growth: float
    angle: float
    sweep: float
    begin: float
    speed: float

    @property
    def sense(self) -> int:
        """1 counter-clockwise, -1 clockwise."""
        return 1 if self.sweep > 0 else -1

    def _pace(self, turned: np.ndarray) -> np.ndarray:
        """Seconds per metre of rim after so much of the slide (rad)."""
        normal = unit(self.angle + self.sense * turned)
        along = self.sense * cross(normal, np.asarray(self.velocity))
        rim = self.velocity + self.growth * normal
        rest = self.speed**2 - (rim**2).sum(-1)
        root = np.sqrt(along**2 + rest)
        # One or the other form loses digits.
        return np.where(along > 0, (root + along) / rest, 1 / np.where(along > 0, 1, root - along))

    def _part(self, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Integral of `_pace` over short parts (k,)."""
        width = end - begin
        return width * (self._pace(begin[:, None] + width[:, None] * NODES) @ WEIGHTS)

    @cached_property
    def _table(self) -> tuple[np.ndarray, np.ndarray]:
        """Even steps of the slide (rad), and the integral of `_pace` up to each."""
        ratio = (math.hypot(*self.velocity) + self.growth) / self.speed
        widest = min(WIDEST_PART, SHARE * math.acosh(1 / ratio)) if ratio else WIDEST_PART
        knots = np.linspace(0, abs(self.sweep), math.ceil(abs(self.sweep) / widest) + 1)
        parts = self._part(knots[:-1], knots[1:])
        return read_only(knots), read_only(np.append(0.0, np.cumsum(parts)))

    @cached_property
    def end(self) -> float:
        """Last time (s)."""
        total, first = float(self._table[1][-1]), self.radius + self.growth * self.begin
        grown = math.expm1(self.growth * total) / self.growth if self.growth else total
        return self.begin + first * grown

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m) and velocities (m/s) at times (k,), each of shape (k, 2)."""
        first = self.radius + self.growth * self.begin
        wanted = (t - self.begin) / first
        if self.growth:
            wanted = np.log1p(self.growth * wanted) / self.growth
        knots, total = self._table
        place = np.clip(np.searchsorted(total, wanted) - 1, 0, len(knots) - 2)
        begin, short = knots[place], wanted - total[place]
        turned = begin + short * (knots[1] - knots[0]) / (total[place + 1] - total[place])
        for _ in range(DOUBLINGS):
            turned -= (self._part(begin, turned) - short) / self._pace(turned)
        normal = unit(self.angle + self.sense * turned)
        across = self.sense * np.stack([-normal[:, 1], normal[:, 0]], -1)
        place = self.center + t[:, None] * self.velocity
        place = place + (self.radius + self.growth * t)[:, None] * normal
        rim = self.velocity + self.growth * normal
        return place, rim + across / self._pace(turned)[:, None]


@dataclass(frozen=True, eq=False)
class Ride:
    """A motion that waits where two discs, or a disc and a wall, meet.

    Parameters
    ----------
    place : callable
        ``place(t)`` gives places (m) and velocities (m/s), each of shape (k, 2),
        at times (k,).
    begin, end : float
        First and last time (s).
    """

    place: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    begin: float
    end: float

    def at(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m) and velocities (m/s) at times (k,), each of shape (k, 2)."""
        return self.place(t)


@dataclass(frozen=True, eq=False)
class TimedPath:
    """Motions, each of which begins where and when the one before it ends.

    Parameters
    ----------
    pieces : sequence of Straight, Slide and Ride
        In driving order.

    Raises
    ------
    InvalidParameter
        For no piece, or a gap in place or time.
    """

    pieces: Sequence[Straight | Slide | Ride]

    def __post_init__(self) -> None:
        pieces = checks.instances(
            "pieces", self.pieces, (Straight, Slide, Ride), "Straights, Slides and Rides"
        )
        object.__setattr__(self, "pieces", pieces)
        if not pieces:
            raise InvalidParameter("pieces is empty; a path needs at least one piece")
        for before, after in itertools.pairwise(pieces):
            (end, _), (begin, _) = (
                piece.at(np.array([time]))
                for piece, time in ((before, before.end), (after, after.begin))
            )
            late = abs(after.begin - before.end) / max(1.0, abs(before.end))
            if math.dist(end[0], begin[0]) > APART or late > APART:
                raise InvalidParameter(
                    f"{after} does not go on where and when {before} ends, at {end[0].tolist()} m "
                    f"and {before.end:.9g} s; join them by another piece"
                )

    def __repr__(self) -> str:
        return f"TimedPath of {len(self.pieces)} pieces, from {self.begin:g} to {self.arrival:g} s"

    @property
    def begin(self) -> float:
        """First time (s)."""
        return self.pieces[0].begin

    @property
    def arrival(self) -> float:
        """Last time (s)."""
        return self.pieces[-1].end

    @cached_property
    def joints(self) -> np.ndarray:
        """Time at which each piece begins, then the arrival (s)."""
        return read_only(np.array([*(piece.begin for piece in self.pieces), self.arrival]))

    def at(self, t: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Pose and velocity at times.

        Parameters
        ----------
        t : array_like, shape (...)
            Times (s); before the first and after the last one it stands at
            that end.

        Returns
        -------
        pose : ndarray, shape (3, ...)
            x, y (m), and the heading (rad), continuous.
        velocity : ndarray, shape (2, ...)
            Velocity (m/s).

        Raises
        ------
        InvalidParameter
            For what are no times.
        """
        times = checks.signal("t", t, "times (s)")
        flat = np.clip(times.astype(float).ravel(), self.begin, self.arrival)
        on = np.searchsorted(self.joints[1:-1], flat, side="right")
        place, velocity = np.empty((2, len(flat), 2))
        for index, piece in enumerate(self.pieces):
            here = on == index
            if here.any():
                place[here], velocity[here] = piece.at(flat[here])
        heading = angle_of(velocity)
        order = np.argsort(flat, kind="stable")
        turns = np.cumsum(wrap_angle(np.diff(heading[order], prepend=heading[order][:1])))
        heading[order] = heading[order][:1] + turns
        pose = np.stack([*place.T, heading])
        return pose.reshape(3, *times.shape), velocity.T.reshape(2, *times.shape)

    @cached_property
    def t(self) -> np.ndarray:
        """Times (s) along the path, among them those of the joints."""
        even = np.linspace(self.begin, self.arrival, MOMENTS)
        return read_only(np.unique(np.concatenate([even, self.joints])))

    @cached_property
    def pose(self) -> np.ndarray:
        """Poses at `t`, shape (3, k)."""
        return read_only(self.at(self.t)[0])
