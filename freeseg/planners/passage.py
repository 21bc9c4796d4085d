"""How large a robot would pass where there is no path: the widest way, and where it is narrow."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from freeseg.path import Path
from freeseg.planners.query import Query
from freeseg.world import World

#: So often the clearance is bisected: to a 4096th, enough to tell which gap is the narrow one.
BISECTIONS = 12

#: A way that is narrower than this share of what is asked for is none: obstacles touch.
HARDLY_OPEN = 1e-4


class Passage(NamedTuple):
    """The widest way from the start to the goal.

    Parameters
    ----------
    clearance : float
        The largest distance that it can keep from all obstacles (m).
    place : ndarray, shape (2,), or None
        The middle of where it can keep no more (m); None where that was not found.
    between : (int, int) or None
        The obstacles there; twice the same one for two of its parts.
    """

    clearance: float
    place: np.ndarray | None = None
    between: tuple[int, int] | None = None


def widest_passage(query: Query, way: Callable[[Query], Path | None]) -> Passage | None:
    """The widest way where there is no path, or None where even a point would not pass.

    The clearance is bisected, each time by a search that proves what it says. Where the
    last path passes through a gap too narrow for more, that gap is the exact answer.

    Parameters
    ----------
    query : Query
        What there is no path for.
    way : callable
        The shortest path of a query, or None where there is none.
    """
    keep = query.turning_radii - query.world.radii
    high = float(keep.max())
    low = HARDLY_OPEN * high
    path = way(_keeping(query, low))
    if path is None:
        return None
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        found = way(_keeping(query, middle))
        if found is None:
            high = middle
        else:
            low, path = middle, found
    return _narrowest(query.world, keep, path, low, high) or Passage(low)


def _keeping(query: Query, clearance: float) -> Query:
    """A query that keeps at most a clearance (m)."""
    radii = np.minimum(query.turning_radii, query.world.radii + clearance)
    return replace(query, turning_radii=radii)


def _narrowest(
    world: World, keep: np.ndarray, path: Path, low: float, high: float
) -> Passage | None:
    """The gap that a path passes and that is between two clearances (m) wide, or None.

    Parameters
    ----------
    world : World
        n obstacles.
    keep : ndarray, shape (n,)
        The distance kept from each where there is room (m): less near the start and the goal.
    path : Path
        A path that keeps the lower clearance.
    low, high : float
        Clearances with which there is a path, and with which there is none (m).
    """
    line = shapely.LineString(path.sample(max(low / 10, path.length / 1e5)))
    shapely.prepare(line)
    owner = np.repeat(np.arange(len(world)), world.edge_counts)
    # A disc's edge has no length, and is no line to Shapely.
    is_disc = (world.edges[:, 0] == world.edges[:, 1]).all(1)
    edges = shapely.linestrings(world.edges)
    edges[is_disc] = shapely.points(world.edges[is_disc, 0])
    # No side of the gap is farther from the path; its samples cut corners by less.
    beside = np.flatnonzero(
        shapely.dwithin(line, edges, world.radii[owner] + 2 * high - low + 0.01 * high)
    )
    owner, edges = owner[beside], edges[beside]
    first, second = shapely.STRtree(edges).query(
        edges, predicate="dwithin", distance=2 * high + 2 * float(world.radii.max())
    )
    once = first < second
    first, second = first[once], second[once]
    across = shapely.shortest_line(edges[first], edges[second])
    one, other = owner[first], owner[second]
    gap = shapely.length(across) - world.radii[one] - world.radii[other]
    # Both sides keep the same, or the one near the start or the goal less.
    less = np.minimum(keep[one], keep[other])
    clearance = np.maximum(gap / 2, gap - less)
    is_it = np.flatnonzero((clearance >= 0.999 * low) & (clearance <= high))
    is_it = is_it[shapely.intersects(line, across[is_it])]
    if not len(is_it):
        return None
    k = is_it[np.argmin(clearance[is_it])]
    middle = shapely.line_interpolate_point(across[k], world.radii[one[k]] + gap[k] / 2)
    pair = sorted([int(one[k]), int(other[k])])
    return Passage(float(clearance[k]), shapely.get_coordinates(middle)[0], (pair[0], pair[1]))


def remedy(query: Query, way: Callable[[Query], Path | None]) -> str:
    """What helps where there is no path, in words; see `widest_passage`."""
    found = widest_passage(query, way)
    if found is None:
        return "move the start or the goal: no robot would pass, however small"
    where = _where(query.world, found)
    width = 2 * found.clearance
    diameter = width - query.margin
    if diameter > HARDLY_OPEN * query.robot.diameter:
        return (
            "move the start or the goal, or plan for a smaller robot or margin: a robot of at most "
            f"{rounded_down(diameter)} m with that margin would pass{where}"
        )
    return (
        "move the start or the goal, or plan for a smaller margin: with that one no robot would "
        f"pass, however small; its diameter and the margin may be {rounded_down(width)} m "
        f"together at most{where}"
    )


def rounded_down(length: float) -> str:
    """A length (m) with four significant digits, none of them too large."""
    digits = 3 - math.floor(math.log10(length))
    # What is round-off below a round number is that number.
    return f"{math.floor(length * (1 + 1e-12) * 10.0**digits) / 10.0**digits:.12g}"


def _where(world: World, found: Passage) -> str:
    if found.between is None or found.place is None:
        return ""
    one, other = map(world.name_of, found.between)
    names = f"{one} and {other}" if one != other else f"two parts of {one}"
    digits = 2 - math.floor(math.log10(found.clearance))
    place = [round(value, digits) + 0.0 for value in found.place.tolist()]
    return f", between {names} near {place}"
