"""Many plans: how often each rule finds a path, and how long the paths are."""

import math
from collections.abc import Iterable
from functools import partial
from numbers import Integral
from os import PathLike
from typing import Any

import numpy as np

from freeseg.checks import instances, shown, whole
from freeseg.errors import InvalidParameter, InvalidWorld, NoPath, Trapped
from freeseg.plan import Planner
from freeseg.planners import literal_plan, plan, plan_rooms, shortest_path
from freeseg.random_worlds import random_query, random_world
from freeseg.studies.runner import run
from freeseg.world import World

#: The rules that are compared, from the paper's words to the optimum.
RULES: dict[str, Planner] = {
    "literal": literal_plan,
    "literal, round the obstacle": partial(literal_plan, concentric=True),
    "completed": plan,
    "rooms": plan_rooms,
    "exact": shortest_path,
}


def random_case(seed: int) -> tuple[World, np.ndarray, np.ndarray]:
    """A random small world with a query.

    Parameters
    ----------
    seed : int
        Equal seeds give equal cases.

    Returns
    -------
    world : World
        1 to 60 discs, polygons or both, from crowded to spacious.
    start, goal : ndarray, shape (2,)
        Free positions (m).

    Raises
    ------
    InvalidParameter
        For a seed that is not a whole number from 0 on.
    """
    seed = whole("seed", seed)
    rng = np.random.default_rng(seed)
    while True:
        n, area = int(rng.integers(1, 61)), rng.uniform(0.02, 0.1)
        shapes = (("disc",), ("polygon",), ("disc", "polygon"))[rng.integers(3)]
        try:
            world = random_world(n, int(rng.integers(2**32)), shapes, area)
            return world, *random_query(world, int(rng.integers(2**32)))
        except InvalidWorld:
            # No room for so many obstacles, or none left for the robot.
            continue


def try_rules(seed: int) -> dict[str, tuple[float, float]]:
    """Plan one random case by every rule.

    Parameters
    ----------
    seed : int
        As for `random_case`.

    Returns
    -------
    dict
        Rule to (length, clearance) of its path (m), NaN where it found none;
        and ``"straight"``, with the distance from start to goal.
    """
    world, start, goal = random_case(seed)
    found = {"straight": (math.dist(start, goal), np.nan)}
    for rule, planner in RULES.items():
        try:
            path = planner(world, start, goal).path
            found[rule] = path.length, path.clearance(world)
        except (NoPath, Trapped):
            found[rule] = np.nan, np.nan
    return found


def _try_rules(seed: int, _: int) -> dict[str, tuple[float, float]]:
    """As `try_rules`; the seed of the world is the case's, not the runner's."""
    return try_rules(seed)


def compare_rules(
    seeds: Iterable[int], jobs: int | None = 1, store: str | PathLike[str] | None = None
) -> list[dict[str, Any]]:
    """Success and length of every rule over random cases.

    Parameters
    ----------
    seeds : iterable of int
        One case each.
    jobs, store : optional
        Processes, and where the cases are kept, see `runner.run`.

    Returns
    -------
    list of dict
        A row for every rule: ``rule``; ``worlds`` and, of these, ``solvable``
        (the exact planner finds a path), ``straight`` (the optimum is the
        straight line) and ``solved``; ``tighter``, paths that it found where
        none keeps R_D, by straight pieces that keep only R_r;
        ``median_ratio``, ``p95_ratio`` and ``max_ratio`` of the length to the
        optimum; ``optimal``, the share of these within 0.1 % of it;
        ``min_clearance_m``.

    Raises
    ------
    InvalidParameter
        For what are no seeds, or is no number of processes.
    """
    seeds = instances("seeds", seeds, Integral, "whole numbers, one or more")
    results = list(run(_try_rules, seeds, store, jobs=jobs, strict=True))
    if not results:
        raise InvalidParameter(f"seeds is {shown(seeds)}; give one or more")
    optimum = np.array([found["exact"][0] for found in results])
    straight = np.array([found["straight"][0] for found in results])
    solvable, rows = np.isfinite(optimum), []
    for rule in RULES:
        length, clearance = np.array([found[rule] for found in results]).reshape(-1, 2).T
        found = np.isfinite(length)
        ratio = (length / optimum)[found & solvable]
        rows.append(
            {
                "rule": rule,
                "worlds": len(results),
                "solvable": int(solvable.sum()),
                "straight": int((optimum <= straight * (1 + 1e-9)).sum()),
                "solved": len(ratio),
                "tighter": int((found & ~solvable).sum()),
                "median_ratio": _or_nan(np.median, ratio),
                "p95_ratio": _or_nan(np.quantile, ratio, 0.95),
                "max_ratio": _or_nan(np.max, ratio),
                "optimal": _or_nan(np.mean, ratio <= 1.001),
                "min_clearance_m": _or_nan(np.min, clearance[found]),
            }
        )
    return rows


def _or_nan(number, values, *more):
    """A number of some values; NaN where there is none."""
    return float(number(values, *more)) if len(values) else math.nan
