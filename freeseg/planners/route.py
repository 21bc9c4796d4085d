"""The shortest route round obstacles: what the search is given, and what it finds."""

import itertools
import math
from collections.abc import Iterable
from functools import lru_cache
from types import ModuleType
from typing import NamedTuple

import numpy as np

from freeseg.errors import NoPath
from freeseg.geometry import cross, read_only
from freeseg.path import Arc, Path
from freeseg.plan import TurningPoint, turning_radius
from freeseg.planners import tangent_search
from freeseg.planners.compilation import compiled
from freeseg.planners.passage import remedy
from freeseg.planners.query import Query
from freeseg.planners.tangent_search import Scene
from freeseg.world import World

#: Compilation takes longer than so many searches among so few circles.
OFTEN, FEW = 300, 32
_SMALL_SEARCHES = itertools.count()

#: In worlds of more edges, compiled or not, the searches for what would pass take longer than the
#: answer is worth.
SEARCHED, PLAIN = 5000, 300

#: In so many parts of a turn headings are told apart: many cost little where it is compiled.
FINE, COARSE = 512, 64

#: The grid has so many cells an edge at most, and so many along an axis (memory).
CELLS, ROW = 4, 4096


class Route(NamedTuple):
    """The shortest route round some obstacles.

    Parameters
    ----------
    turns : list of TurningPoint
        In driving order.
    path, passed
        From `taut_path`.
    met : tuple of int
        Obstacles that the search came to, or that barred its way.
    length : float
        Length of the route, as the search summed it up (m): no route round
        these obstacles is shorter.
    """

    turns: list[TurningPoint]
    path: Path
    passed: list[int]
    met: tuple[int, ...]
    length: float


def shortest_route(query: Query, obstacles: Iterable[int] | None = None) -> Route:
    """The shortest route that keeps its distance from obstacles.

    Parameters
    ----------
    query : Query
        Start, goal and dangerous circles.
    obstacles : iterable of int, optional
        Indices of those that count; all if not given.

    Returns
    -------
    Route

    Raises
    ------
    NoPath
        Where these obstacles leave none.
    """
    world = query.world
    counts = np.ones(len(world), bool)
    if obstacles is not None:
        counts[:] = False
        counts[list(obstacles)] = True
    turns, length, met = _search(query, counts)
    if math.isinf(length):
        raise NoPath(
            f"{_in_words(world, np.flatnonzero(counts))} leave no way "
            f"from {query.start.tolist()} to {query.goal.tolist()} for a robot of "
            f"{query.robot.diameter:g} m with a margin of {query.margin:g} m",
            lambda: _remedy(query),
        )
    return Route(*_drop_grazed(query, turns), met, length)


def _remedy(query: Query) -> str:
    """What helps where there is no path, in words: how large a robot would pass, if soon found."""
    edges = len(query.world.edges)
    if edges > (PLAIN if _kernels(edges) is tangent_search else SEARCHED):
        return "move the start or the goal, or plan for a smaller robot or margin"
    return remedy(query, _way)


def _way(query: Query) -> Path | None:
    """The shortest path round all obstacles, or None where there is none."""
    turns, length, _ = _search(query, np.ones(len(query.world), bool))
    return None if math.isinf(length) else query.connect(turns)[0]


def _search(query: Query, counts: np.ndarray) -> tuple[list[TurningPoint], float, tuple[int, ...]]:
    """Turns, length (m; infinite for no route) and `met` among the obstacles that count (n,)."""
    layout = _lay_out(query.world, turning_radius(query.robot, query.margin))
    scene, kernels = _set(query, layout, counts)
    found, length, reached = kernels.search(scene)
    of_circle = layout.of_circle
    reached = reached.reshape(-1, 2).any(1)[2:]
    met = np.unique(np.concatenate([of_circle[reached], layout.of_edge[scene.met]]))
    turns = []
    for oriented in found.tolist():
        corner, sense = oriented // 2 - 2, 1 - 2 * (oriented % 2)
        obstacle, center = int(of_circle[corner]), layout.center[corner]
        turns.append(
            TurningPoint(None, obstacle, center, float(query.turning_radii[obstacle]), sense)
        )
    return turns, float(length), tuple(met.tolist())


def _drop_grazed(
    query: Query, turns: list[TurningPoint]
) -> tuple[list[TurningPoint], Path, list[int]]:
    """Turns without those whose circle the path only grazes, and their path."""
    path, passed = query.connect(turns)
    assert path is not None, "the search has its tangents"
    arcs = zip(path.pieces, passed, strict=True)
    driven = [turns[place] for piece, place in arcs if isinstance(piece, Arc)]
    if len(driven) < len(turns):
        straighter, places = query.connect(driven)
        if straighter is not None and straighter.length > path.length - query.round_off:
            return driven, straighter, places
    return turns, path, passed


def _set(query: Query, layout: "_Layout", counts: np.ndarray) -> tuple[Scene, ModuleType]:
    """The scene of a query among the obstacles that count (n,), and what searches it."""
    ends = np.array([query.start, query.goal]) - layout.origin
    circle = np.concatenate([np.column_stack([ends, np.zeros((2, 4))]), layout.circle])
    of_circle, of_edge, radii = layout.of_circle, layout.of_edge, query.turning_radii
    radius = np.concatenate([np.zeros(2), np.where(counts[of_circle], radii[of_circle], -1.0)])
    keep = np.where(counts[of_edge], radii[of_edge], 0.0)
    kernels = _kernels(len(circle))
    parts = FINE if kernels is not tangent_search else COARSE
    stamp, seen = np.zeros(len(keep), int), np.zeros(len(circle), int)
    x0, y0, cell = layout.grid["corner"]
    scene = Scene(
        circle=circle,
        radius=radius,
        largest=float(radius.max()),
        span=float(cell * layout.grid["cells"].sum() + np.abs(ends - (x0, y0)).sum()),
        edge=layout.edge,
        keep=keep,
        stamp=stamp,
        mark=np.zeros(1, int),
        seen=seen,
        sector=np.empty((parts, 6)),
        met=np.zeros(len(keep), bool),
        hidden=np.empty(parts),
        **layout.grid,
    )
    return scene, kernels


def _in_words(world: World, obstacles: np.ndarray) -> str:
    """Obstacles in words, numbered from 1; of many, the first few."""
    numbers = [index + 1 for index in obstacles.tolist() if index != world.frame]
    words = f"obstacles {numbers}"
    if len(numbers) > 12:
        words = f"{len(numbers)} obstacles ({numbers[:3]} and more)"
    if world.frame is None or world.frame not in obstacles:
        return words
    return f"{words} and the boundary" if numbers else "the walls of the boundary"


class _Layout(NamedTuple):
    """What a search needs to know of a world, for all its queries.

    Parameters
    ----------
    origin : ndarray, shape (2,)
        The middle of the world (m): positions are relative to it, so that they
        are small also on a projected map.
    circle : ndarray, shape (c, 6)
        As in `Scene`, without the start and the goal.
    center : ndarray, shape (c, 2)
        Centres (m) as they stand in the world.
    of_circle, of_edge : ndarray of int, shape (c,) and (k,)
        Obstacle of each circle and of each edge.
    edge : ndarray, shape (k, 4)
        As in `Scene`.
    grid : dict
        From `corner` to `circle_item` as in `Scene`, by these names.
    """

    origin: np.ndarray
    circle: np.ndarray
    center: np.ndarray
    of_circle: np.ndarray
    of_edge: np.ndarray
    edge: np.ndarray
    grid: dict[str, np.ndarray]


@lru_cache(maxsize=4)
def _lay_out(world: World, clearance: float) -> _Layout:
    """Lay out a world for searches that keep at most this clearance (m); it is remembered."""
    of_edge = np.repeat(np.arange(len(world)), world.edge_counts)
    low, high = (
        (world.edges.min((0, 1)), world.edges.max((0, 1))) if len(world) else np.zeros((2, 2))
    )
    origin = (low + high) / 2
    edges = world.edges - origin
    which, normals = convex_corners(world, edges)
    circle = np.column_stack([edges[which, 0], normals])
    edge, keep = edges.reshape(-1, 4), world.radii[of_edge] + clearance
    grid = _lay_grid(edge, keep, circle)
    center = read_only(world.edges[which, 0].copy())
    return _Layout(origin, circle, center, of_edge[which], of_edge, edge, grid)


def convex_corners(world: World, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At which edges (k, 2, 2) convex corners and discs begin (c,), and their cones (c, 4)."""
    along = edges[:, 1] - edges[:, 0]
    along /= np.maximum(np.hypot(*along.T), np.finfo(float).tiny)[:, None]
    before = np.empty(len(edges), int)
    before[world.following_edge] = np.arange(len(edges))
    is_disc = before == np.arange(len(edges))
    convex = is_disc | (cross(along[before], along) > 0)
    if world.frame is not None:
        # Nothing comes round the frame from outside.
        convex[world.first_edge[-1] : world.first_edge[-1] + 4] = False
    which = np.flatnonzero(convex)
    come, go = along[before[which]], along[which]
    return which, np.column_stack([come[:, 1], -come[:, 0], go[:, 1], -go[:, 0]])


def _lay_grid(edge: np.ndarray, keep: np.ndarray, circle: np.ndarray) -> dict[str, np.ndarray]:
    """Grid over edges (k, 4) that keep (k,) away from them, and over circles (c, 6)."""
    low, high = np.zeros(2), np.ones(2)
    if len(edge):
        ends = edge.reshape(-1, 2)
        low, high = ends.min(0) - keep.max(), ends.max(0) + keep.max()
    extent, edges = high - low, max(len(edge), 1)
    cell = max(math.sqrt(extent.prod() / (CELLS * edges)), extent.max() / ROW)
    # As wide as most edges keep: a narrower cell only has them entered more often.
    cell = max(cell, float(np.partition(keep, edges // 2)[edges // 2]) if len(keep) > 1 else cell)
    cells = np.ceil(extent / cell).astype(int)
    corner, count = np.array([*low, cell]), int(cells.prod())
    kernels, first = _kernels(len(edge)), np.zeros(count + 2, int)
    kernels.enter_cells(edge, keep, corner, cells, True, first, np.empty(0, int))
    first = np.cumsum(first)
    item = np.empty(first[-1], int)
    kernels.enter_cells(edge, keep, corner, cells, False, first, item)
    column, row = ((circle[:, :2] - low) / cell).astype(int).T
    place = row * cells[0] + column
    order = np.argsort(place, kind="stable")
    begins = np.searchsorted(place[order], np.arange(count + 1))
    return {
        "corner": corner,
        "cells": cells,
        "edge_first": first[:-1],
        "edge_item": item,
        "circle_first": begins,
        "circle_item": order + 2,
    }


def _kernels(size: int) -> ModuleType:
    """The search, compiled where that pays."""
    is_compiled = compiled.cache_info().currsize > 0
    if size < FEW and not is_compiled and next(_SMALL_SEARCHES) < OFTEN:
        return tangent_search
    return compiled(tangent_search)
