"""A world in which obstacles move, and distances in it at a time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter, InvalidQuery, InvalidWorld
from freeseg.geometry import read_only
from freeseg.world import Disc, Frame, Polygon, World, as_points, check_world


@dataclass(frozen=True, eq=False)
class Mover:
    """An obstacle that moves without turning.

    Parameters
    ----------
    obstacle : Disc or Polygon
        The obstacle where it is at time zero.
    velocity : array_like, shape (2,)
        Constant velocity (m/s); by default it stands.
    shift : callable, optional
        How far it has moved since time zero, in place of a velocity:
        ``shift(t)`` takes times (s) of shape (k,) and returns shifts (m) of
        shape (k, 2), zero at time zero.
    growth : float, optional
        Speed (m/s) at which a disc grows. A mover of which no more is known
        than its top speed is a disc that grows at that speed: it covers every
        place where the mover could be.

    Raises
    ------
    InvalidWorld
        For what is no such obstacle, velocity, function or growth, for a
        velocity and a shift at once, and for a polygon that grows.

    Notes
    -----
    That an unpredictable mover is a growing disc is from J. van den Berg and
    M. Overmars, *IJRR* 2008.

    Examples
    --------
    >>> mover = Mover(Disc((0, 0), 0.1), velocity=(0.2, 0))
    >>> mover.at(2.0).center.tolist(), mover.at(2.0).radius
    ([0.4, 0.0], 0.1)
    """

    obstacle: Disc | Polygon
    velocity: ArrayLike = (0.0, 0.0)
    shift: Callable[[np.ndarray], np.ndarray] | None = None
    growth: float = 0.0

    def __post_init__(self) -> None:
        remedy = "a Disc or a Polygon"
        checks.instance("obstacle", self.obstacle, (Disc, Polygon), remedy, InvalidWorld)  # type: ignore[arg-type]
        if isinstance(self.obstacle, Frame):
            raise InvalidWorld("obstacle is the frame of a boundary, which cannot move; leave it")
        velocity = as_points(self.velocity, "velocity", (2,), InvalidWorld)
        growth = checks.number(
            "growth", self.growth, lambda found: found >= 0, "a speed (m/s), zero or more",
            InvalidWorld,
        )  # fmt: skip
        if growth and not isinstance(self.obstacle, Disc):
            raise InvalidWorld(
                f"growth is {growth:g} m/s, but the obstacle is a Polygon; give the Disc round it"
            )
        object.__setattr__(self, "velocity", velocity)
        object.__setattr__(self, "growth", growth)
        if self.shift is not None:
            self._check_shift()

    def _check_shift(self) -> None:
        """`InvalidWorld` unless `shift` is such a function."""
        remedy = "a function of times (k,) that returns shifts (k, 2) in metres"
        if not callable(self.shift):
            raise InvalidWorld(f"shift is {checks.shown(self.shift)}; give {remedy}")
        if np.any(self.velocity):
            raise InvalidWorld(
                f"velocity is {np.asarray(self.velocity).tolist()} and there is a shift too; give "
                "one of them"
            )
        if np.abs(self.shifts(np.zeros(1))).max() > 0:
            raise InvalidWorld(
                f"shift is {self.shifts(np.zeros(1))[0].tolist()} m at time zero; subtract that, "
                "for the obstacle stands where it is then"
            )

    @property
    def is_predictable(self) -> bool:
        """Whether its velocity is constant and known."""
        return self.shift is None and not self.growth

    def shifts(self, t: ArrayLike) -> np.ndarray:
        """How far it has moved at times (s) of shape (...), shape (..., 2) (m).

        Raises
        ------
        InvalidParameter
            For what are no times, zero or more.
        """
        t = checks.times("t", t)
        if self.shift is None:
            return t[..., None] * np.asarray(self.velocity)
        try:
            found = np.array(self.shift(t.ravel()), dtype=float)
        except (TypeError, ValueError) as error:
            raise InvalidWorld(
                f"shift fails ({error}); give a function of times (k,) that returns shifts (k, 2)"
            ) from error
        if found.shape != (t.size, 2) or not np.isfinite(found).all():
            raise InvalidWorld(
                f"shift returns {checks.shown(found.tolist())} for {t.size} times; make it return "
                f"{t.size} x 2 finite numbers (m)"
            )
        return found.reshape(*t.shape, 2)

    def at(self, t: float) -> Disc | Polygon:
        """The obstacle where, and as large as, it is at a time (s).

        Raises
        ------
        InvalidParameter
            For what is not one time, zero or more.
        """
        time = checks.not_negative("t", t)
        shift = self.shifts(np.array(time))
        if isinstance(self.obstacle, Disc):
            return Disc(self.obstacle.center + shift, self.obstacle.radius + self.growth * time)
        outer, *holes = (ring + shift for ring in self.obstacle.rings)
        return Polygon(outer, tuple(holes))


@dataclass(frozen=True, eq=False)
class Scene:
    """Static obstacles, and some that move.

    Parameters
    ----------
    world : World
        n static obstacles, and perhaps a boundary.
    movers : sequence of Mover
        m obstacles that move. They may touch, and pass through each other and
        the static ones. They are numbered after those of the world.

    Raises
    ------
    InvalidQuery
        For what is no world.
    InvalidWorld
        For movers that are none.

    Examples
    --------
    >>> scene = Scene(World([Disc((0, 1), 0.1)]), [Mover(Disc((0, 0), 0.1), velocity=(0.2, 0))])
    >>> scene.distances((1, 0), t=[0, 2])[:, 1].round(3).tolist()
    [0.9, 0.5]
    """

    world: World
    movers: Sequence[Mover] = ()

    def __post_init__(self) -> None:
        check_world(self.world)
        movers = checks.instances("movers", self.movers, Mover, "a list of Movers", InvalidWorld)
        object.__setattr__(self, "movers", movers)

    def __len__(self) -> int:
        return len(self.world) + len(self.movers)

    def __repr__(self) -> str:
        return f"Scene of {len(self.world)} static and {len(self.movers)} moving obstacles"

    def name_of(self, obstacle: int) -> str:
        """What messages call an obstacle: a static one as in the world, a mover by its number."""
        first = len(self.world)
        return (
            f"mover {obstacle - first + 1}" if obstacle >= first else self.world.name_of(obstacle)
        )

    def at(self, t: float) -> World:
        """All obstacles where they are at a time, as a world.

        Parameters
        ----------
        t : float
            Time (s), zero or more.

        Returns
        -------
        World
            The static obstacles, then the movers, then the frame if there is
            a boundary.
        """
        checks.not_negative("t", t)
        if not self.movers:
            return self.world
        return World([*self.world, *(mover.at(t) for mover in self.movers)])

    def distances(self, points: ArrayLike, t: ArrayLike) -> np.ndarray:
        """Distance of points from every obstacle, each at its time.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            Positions (m).
        t : array_like, shape (...)
            Times (s), zero or more; the shapes broadcast.

        Returns
        -------
        ndarray, shape (..., n + m)
            Distance (m), at or below zero where the obstacle is met: first
            from the world's obstacles, then from the movers.

        Raises
        ------
        InvalidParameter
            For what are no such points and times.
        """
        remedy = "positions [x, y] (m), as the last axis"
        given, times = checks.signal("points", points, remedy), checks.times("t", t)
        if given.shape[-1:] != (2,):
            checks.array("points", given, (None, 2))
        checks.together(points=given.shape[:-1], t=times.shape)
        shape = np.broadcast_shapes(given.shape[:-1], times.shape)
        given, times = np.broadcast_to(given, (*shape, 2)), np.broadcast_to(times, shape)
        found = np.empty((*shape, len(self)))
        static = len(self.world)
        found[..., :static] = self.world.distances(shapely.points(given[..., None, :]))
        steady = self._steady
        if steady is not None:
            center, velocity, radius, growth = steady
            gap = given[..., None, :] - center - times[..., None, None] * velocity
            found[..., static:] = np.hypot(gap[..., 0], gap[..., 1]) - radius
            found[..., static:] -= growth * times[..., None]
            return found
        for index, mover in enumerate(self.movers, static):
            # As the mover sees the points, it stands and they move.
            seen = shapely.points(given - mover.shifts(times))
            found[..., index] = shapely.distance(mover.obstacle.core, seen)
            found[..., index] -= mover.obstacle.radius + mover.growth * times
        return found

    @cached_property
    def _steady(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
        """Centres, velocities, radii and growths where all movers are discs that move evenly."""
        discs = [mover.obstacle for mover in self.movers if isinstance(mover.obstacle, Disc)]
        if len(discs) < len(self.movers) or any(mover.shift for mover in self.movers):
            return None
        center = np.array([disc.center for disc in discs]).reshape(-1, 2)
        velocity = np.array([mover.velocity for mover in self.movers]).reshape(-1, 2)
        radius, growth = (
            np.array([disc.radius for disc in discs]),
            np.array([mover.growth for mover in self.movers]),
        )
        return tuple(map(read_only, (center, velocity, radius, growth)))  # type: ignore[return-value]

    def clearance(self, timed: Any) -> np.ndarray:
        """Smallest distance from any obstacle along a run or a timed path.

        Parameters
        ----------
        timed : object
            With times ``t`` (s), shape (k,), and a ``pose``, shape (3, k) or
            (3, robots, k), such as a `Run`.

        Returns
        -------
        ndarray, shape () or (robots,)
            Distance (m) of the centre; infinite where there is no obstacle.

        Raises
        ------
        InvalidParameter
            For what has no such times and poses.
        """
        try:
            t, pose = timed.t, np.asarray(timed.pose, float)
        except (AttributeError, TypeError, ValueError):
            t, pose = None, np.empty(0)
        if t is None or pose.ndim not in (2, 3):
            raise InvalidParameter(
                f"timed is {checks.shown(timed)}; give a run, or a path with t and pose"
            )
        points = np.moveaxis(pose[:2], 0, -1)
        return self.distances(points, t).min((-1, -2), initial=np.inf)


def check_scene(scene: object) -> Scene:
    """`scene`, or a world as a scene without movers; `InvalidQuery` for anything else."""
    if isinstance(scene, World):
        return Scene(scene)
    return checks.instance("scene", scene, Scene, "a Scene or a World", InvalidQuery)
