"""Paths of straight lines and circular arcs."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike
from pathlib import Path as FilePath
from typing import Any, Self

import numpy as np
import shapely
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.geometry import (
    angle_of,
    arc_segment_distance,
    arc_sweep,
    read_only,
    tangents,
    wrap_angle,
)
from freeseg.world import World, check_world

#: Pieces shorter than this (m, rad) are round-off.
GRAZING = 1e-9

#: So many edges are compared with arcs at once.
MOST_EDGES = 200_000

#: More points than this would not fit into memory.
MOST_SAMPLES = 1e8


def _check(piece: "Line | Arc", **sizes: int) -> None:
    """Turn a piece's fields into floats and pairs of them, or `InvalidParameter`."""
    for name, size in sizes.items():
        what, value = f"{name} of the {type(piece).__name__}", getattr(piece, name)
        found = checks.number(what, value) if size == 1 else checks.numbers(what, value, size)
        object.__setattr__(piece, name, found)


@dataclass(frozen=True)
class Line:
    """A straight piece of a path from `start` to `end` (m)."""

    start: tuple[float, float]
    end: tuple[float, float]

    curvature = 0.0

    def __post_init__(self) -> None:
        _check(self, start=2, end=2)
        if self.length == 0:
            raise InvalidParameter(f"{self} has length zero; leave it out")

    @property
    def length(self) -> float:
        """Length (m)."""
        return math.dist(self.start, self.end)

    def at(self, s: float | np.ndarray) -> tuple[Any, Any, float]:
        """Position and heading after `s` (m): x, y (m), theta (rad)."""
        theta = math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])
        return self.start[0] + s * math.cos(theta), self.start[1] + s * math.sin(theta), theta


@dataclass(frozen=True)
class Arc:
    """A circular piece of a path.

    Parameters
    ----------
    center : tuple
        Centre [x, y] (m).
    radius : float
        Radius (m), positive.
    start_angle : float
        Direction from the centre to where the arc begins (rad).
    sweep : float
        Angle covered (rad), positive counter-clockwise.
    """

    center: tuple[float, float]
    radius: float
    start_angle: float
    sweep: float

    def __post_init__(self) -> None:
        _check(self, center=2, radius=1, start_angle=1, sweep=1)
        if self.radius <= 0 or self.sweep == 0:
            raise InvalidParameter(f"{self} needs a positive radius and a sweep that is not zero")

    @property
    def length(self) -> float:
        """Length (m)."""
        return self.radius * abs(self.sweep)

    @property
    def curvature(self) -> float:
        """Signed curvature (1/m), positive to the left."""
        return math.copysign(1 / self.radius, self.sweep)

    @property
    def start(self) -> tuple[float, float]:
        """First point (m)."""
        x, y, _ = self.at(0.0)
        return float(x), float(y)

    @property
    def end(self) -> tuple[float, float]:
        """Last point (m)."""
        x, y, _ = self.at(self.length)
        return float(x), float(y)

    def at(self, s: float | np.ndarray) -> tuple[Any, Any, Any]:
        """Position and heading after `s` (m): x, y (m), theta (rad)."""
        angle = self.start_angle + self.curvature * s
        x, y = self.center
        return (
            x + self.radius * np.cos(angle),
            y + self.radius * np.sin(angle),
            angle + math.copysign(math.pi / 2, self.sweep),
        )


@dataclass(frozen=True)
class Path:
    """A chain of lines and arcs that the robot can drive without stopping.

    Parameters
    ----------
    pieces : sequence of Line and Arc
        In driving order; each begins where, and in the direction in which,
        the one before it ends.

    Raises
    ------
    InvalidParameter
        For no piece, a gap, or a kink.
    """

    pieces: Sequence[Line | Arc]

    def __post_init__(self) -> None:
        pieces = checks.instances("pieces", self.pieces, (Line, Arc), "Lines and Arcs")
        object.__setattr__(self, "pieces", pieces)
        if not self.pieces:
            raise InvalidParameter("pieces is empty; a path needs at least one piece")
        for before, after in zip(self.pieces, self.pieces[1:], strict=False):
            x, y, theta = before.at(before.length)
            next_x, next_y, next_theta = after.at(0.0)
            kink = math.remainder(next_theta - theta, 2 * math.pi)
            # Round-off of metres and radians, with room; the ends of a short line give its heading
            # the less exactly, the farther out they are.
            blur = 8 * math.ulp(max(abs(x), abs(y))) / min(before.length, after.length)
            if math.hypot(next_x - x, next_y - y) > 1e-7 or abs(kink) > 1e-7 + blur:
                raise InvalidParameter(f"{after} does not go on where, or as, {before} ends")

    def __repr__(self) -> str:
        return f"Path of {self.length:.3f} m in {len(self.pieces)} pieces"

    @cached_property
    def joints(self) -> np.ndarray:
        """Arc length at which each piece begins, then the total (m)."""
        return read_only(np.cumsum([0.0, *(piece.length for piece in self.pieces)]))

    @property
    def length(self) -> float:
        """Length (m)."""
        return float(self.joints[-1])

    @property
    def start(self) -> tuple[float, float]:
        """First point (m)."""
        return self.pieces[0].start

    @property
    def end(self) -> tuple[float, float]:
        """Last point (m)."""
        return self.pieces[-1].end

    def at(self, s: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Position, heading and curvature at arc lengths.

        Parameters
        ----------
        s : array_like, shape (...)
            Distance from the start along the path (m); beyond an end the
            nearest point of the path is meant.

        Returns
        -------
        x, y : ndarray, shape (...)
            Position (m).
        theta : ndarray, shape (...)
            Heading (rad), continuous along the path.
        curvature : ndarray, shape (...)
            Signed curvature (1/m); at a joint that of the piece that begins.
        """
        given = checks.real("s", s, "arc lengths (m)")
        shape = given.shape
        arc_length = np.clip(np.atleast_1d(given.astype(float)), 0, self.length)
        on = np.searchsorted(self.joints, arc_length, side="right") - 1
        on = np.clip(on, 0, len(self.pieces) - 1)
        x, y, theta, curvature = np.empty((4, *arc_length.shape))
        heading = None
        for index, piece in enumerate(self.pieces):
            here = on == index
            x[here], y[here], angle = piece.at(arc_length[here] - self.joints[index])
            first, last = (piece.at(end)[2] for end in (0.0, piece.length))
            whole_turns = 0.0 if heading is None else heading + wrap_angle(first - heading) - first
            theta[here] = angle + whole_turns
            heading = last + whole_turns
            curvature[here] = piece.curvature
        return x.reshape(shape), y.reshape(shape), theta.reshape(shape), curvature.reshape(shape)

    def sample(self, step: float) -> np.ndarray:
        """Points along the path at most `step` apart.

        Parameters
        ----------
        step : float
            Largest distance between neighbours (m), positive.

        Returns
        -------
        ndarray, shape (n, 2)
            Points (m), the joints of the pieces among them.

        Raises
        ------
        InvalidParameter
            For a step that is not positive or makes over 100 million points.
        """
        spacing = checks.as_float(step)
        if not spacing > 0 or self.length / spacing > MOST_SAMPLES:
            raise InvalidParameter(
                f"step is {checks.shown(step)}; give a positive length (m) that makes at most "
                f"{MOST_SAMPLES:g} samples of a path of {self.length:.3f} m"
            )
        counts = [max(math.ceil(piece.length / spacing), 1) for piece in self.pieces]
        points = np.empty((sum(counts) + 1, 2))
        begin = 0
        for piece, count in zip(self.pieces, counts, strict=True):
            part = points[begin : begin + count]
            part[:, 0], part[:, 1], _ = piece.at(np.arange(count) * (piece.length / count))
            begin += count
        points[-1] = self.end
        return points

    def distances(self, world: World) -> np.ndarray:
        """Distance of every piece from every obstacle, exactly.

        Parameters
        ----------
        world : World
            Obstacles.

        Returns
        -------
        ndarray, shape (pieces, n)
            Distance (m); below or at zero where the obstacle is met.
        """
        check_world(world)
        pairs = np.indices((len(self.pieces), len(world))).reshape(2, -1)
        return self._distances(world, *pairs).reshape(len(self.pieces), len(world))

    def near(
        self, world: World, within: float | np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pieces and obstacles that are nearer to each other than `within`.

        Parameters
        ----------
        world : World
            n obstacles.
        within : float or ndarray, shape (n,)
            Distance from each obstacle (m).

        Returns
        -------
        piece, obstacle : ndarray of int, shape (k,)
            Indices of each pair, by piece.
        distance : ndarray, shape (k,)
            Distance (m), as in `distances`.
        """
        check_world(world)
        if not len(world):
            return np.empty(0, int), np.empty(0, int), np.empty(0)
        within = np.broadcast_to(within, len(world))
        # An arc is sought in the disc that it is part of.
        is_arc, arcs = self._arcs
        shapes = np.where(is_arc, shapely.points(arcs[:, :2]), self._lines)
        widths = arcs[:, 2]
        piece, obstacle = world.pairs_near(shapes, widths + within.max())
        # No point of an arc is nearer to a disc than its whole circle is.
        least = shapely.distance(shapes[piece], world.cores[obstacle]) - widths[piece]
        least = np.where(world.edge_counts[obstacle] == 1, np.abs(least), least)
        likely = least < (world.radii + within)[obstacle]
        piece, obstacle = piece[likely], obstacle[likely]
        distance = self._distances(world, piece, obstacle)
        close = np.flatnonzero(distance < within[obstacle])
        close = close[np.lexsort([obstacle[close], piece[close]])]
        return piece[close], obstacle[close], distance[close]

    @cached_property
    def _lines(self) -> np.ndarray:
        """The straight line from end to end of every piece, as Shapely has it."""
        return read_only(shapely.linestrings([(piece.start, piece.end) for piece in self.pieces]))

    @cached_property
    def _arcs(self) -> tuple[np.ndarray, np.ndarray]:
        """Which pieces are arcs, and their parameters (pieces, 5); zeros for lines."""
        is_arc = np.array([isinstance(piece, Arc) for piece in self.pieces])
        arcs = np.zeros((len(self.pieces), 5))
        for index, piece in enumerate(self.pieces):
            if isinstance(piece, Arc):
                arcs[index] = *piece.center, piece.radius, piece.start_angle, piece.sweep
        return read_only(is_arc), read_only(arcs)

    def _distances(self, world: World, piece: np.ndarray, obstacle: np.ndarray) -> np.ndarray:
        """Distance of pieces from obstacles, pair by pair, shape (k,)."""
        distance = shapely.distance(self._lines[piece], world.cores[obstacle])
        is_arc, arcs = self._arcs
        is_arc = is_arc[piece]
        if is_arc.any():
            piece, met = piece[is_arc], obstacle[is_arc]
            # So many pairs at once that their edges fit into memory.
            batches = np.cumsum(world.edge_counts[met]) // MOST_EDGES
            to_edges = np.empty(len(met))
            for batch in np.unique(batches):
                some = batches == batch
                to_edges[some] = _from_outlines(arcs[piece[some]], world, met[some])
            # Inside a polygon, the outline is away but the obstacle is not.
            x, y = np.array([part.start for part in self.pieces]).T
            to_edges[shapely.contains_xy(world.cores[met], x[piece], y[piece])] = 0
            distance[is_arc] = to_edges
        return distance - world.radii[obstacle]

    def clearance(self, world: World) -> float:
        """Distance of the centre line from the nearest obstacle.

        Parameters
        ----------
        world : World
            Obstacles.

        Returns
        -------
        float
            Distance (m); infinite where there is no obstacle.
        """
        check_world(world)
        if not len(world):
            return np.inf
        # Nothing that is farther from the whole path than from its start can be the nearest.
        bound = world.distances(shapely.Point(self.start)).min()
        return float(self.near(world, max(bound, 0) + 2 * world.round_off)[2].min())

    def save(self, file: str | PathLike[str]) -> None:
        """Write the path to a JSON file, to be read with `Path.load`.

        Raises
        ------
        InvalidData
            For a file that cannot be written.
        """
        pieces = [
            {"kind": type(piece).__name__}
            | {part.name: np.asarray(getattr(piece, part.name)).tolist() for part in fields(piece)}
            for piece in self.pieces
        ]
        text = json.dumps({"unit": "m", "pieces": pieces}, indent=1) + "\n"
        try:
            FilePath(file).write_text(text, encoding="utf-8")
        except (OSError, TypeError) as error:
            raise InvalidData(f"{file} cannot be written ({error})") from error

    @classmethod
    def load(cls, file: str | PathLike[str]) -> Self:
        """Read a path that `Path.save` wrote.

        Raises
        ------
        InvalidData
            For a file that is missing or is not such a path.
        """
        kinds = {"Line": Line, "Arc": Arc}
        try:
            saved = json.loads(FilePath(file).read_text(encoding="utf-8-sig"))
            if saved["unit"] != "m":
                raise ValueError(f"its unit is {saved['unit']!r}, not 'm'")
            return cls([kinds[piece.pop("kind")](**piece) for piece in saved["pieces"]])
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise InvalidData(f"{file} is not a path saved by freeseg ({error})") from error


def _from_outlines(arcs: np.ndarray, world: World, obstacles: np.ndarray) -> np.ndarray:
    """Distance of arcs (k, 5) from the outlines of their obstacles' cores, shape (k,)."""
    # All edges of the obstacle of every pair, one pair after the other.
    counts = world.edge_counts[obstacles]
    edges = world.edges[world.edges_of(obstacles)]
    arcs = np.repeat(arcs, counts, axis=0)
    _, _, radius, start_angle, sweep = arcs.T
    apart = arc_segment_distance(arcs[:, :2], radius, start_angle, sweep, edges)
    return np.minimum.reduceat(apart, np.cumsum(counts) - counts)


def taut_path(
    start: ArrayLike, circles: Sequence[tuple[ArrayLike, float]], goal: ArrayLike
) -> tuple[Path | None, list[int]]:
    """Path of tangents that goes round oriented circles in order.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        First and last point (m).
    circles : sequence of (center, signed_radius)
        Centres (m) and radii (m), positive to be driven round
        counter-clockwise.

    Returns
    -------
    path : Path or None
        None where a tangent does not exist because one circle contains the
        next, or contains the start or the goal.
    passed : list of int
        For every piece, how many circles were left behind before it: an arc
        is on circle ``passed``, a line leads to it.
    """
    centers = np.array([start, *(center for center, _ in circles), goal])
    signed = np.array([0.0, *(radius for _, radius in circles), 0.0])
    leave, join = tangents(centers[:-1], signed[:-1], centers[1:], signed[1:])
    if not np.isfinite(leave).all():
        return None, []
    # On every circle, from where it is joined to where it is left.
    first = angle_of(join[:-1] - centers[1:-1])
    sweeps = arc_sweep(centers[1:-1], np.where(signed[1:-1] > 0, 1, -1), join[:-1], leave[1:])
    lengths = np.hypot(*(join - leave).T)
    # Far from the origin, round-off of positions is more than that of metres and radians.
    blur = 8 * math.ulp(np.abs(centers).max())
    pieces: list[Line | Arc] = []
    passed: list[int] = []
    for index, (begin, end) in enumerate(zip(leave.tolist(), join.tolist(), strict=True)):
        # Where a tangent only grazes its circle, round-off leaves no arc or a whole turn.
        radius, sweep = abs(signed[index]), sweeps[index - 1] if index else 0.0
        grazing = max(GRAZING, blur / max(radius, blur))
        if grazing < abs(sweep) < 2 * np.pi - grazing:
            pieces.append(Arc(centers[index].tolist(), radius, first[index - 1], sweep))
            passed.append(index - 1)
        if lengths[index] > max(GRAZING, blur):
            pieces.append(Line(begin, end))
            passed.append(index)
    return Path(pieces), passed
