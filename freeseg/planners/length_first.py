"""Length first: the order that the paper ascribes to the search that it improves on.

That is J. Hong, K. Park, "A new mobile robot navigation using a turning point searching
algorithm with the consideration of obstacle avoidance", *Int. J. Adv. Manuf. Technol.*
52, 2011, the paper's [12]. By its own abstract it is meant for an unknown workspace,
which a laser scanner sees; what is compared here is what the paper takes it for.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from freeseg.plan import Plan
from freeseg.planners.free_segment import Survey, by_detour, find_segments, search
from freeseg.planners.query import Query, ask
from freeseg.robot import Robot
from freeseg.segments import MARGIN, Endpoint, find_endpoints
from freeseg.world import World

#: What is longer than nothing has two ends.
ANY_LENGTH = float(np.finfo(float).tiny)


def length_first_plan(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> Plan:
    """Plan like `plan`, but measure a segment only when its endpoint is tried.

    Take the endpoint with the shortest detour of all, test its segment, and search again
    if it is danger.

    Parameters
    ----------
    world, start, goal, robot, margin
        As for `plan`.

    Returns
    -------
    Plan
        The path that `plan` finds; its ``effort`` is another one, and refused
        candidates are in its trace.

    Raises
    ------
    InvalidQuery, InvalidParameter, NoPath, Trapped
        As for `plan`.

    Notes
    -----
    Both orders end at the same turning point: the safe one of shortest detour. They
    differ in what they compute on the way, see `Effort`. Safety first measures all n - 1
    segments once, and then evaluates the endpoints of the safe ones; length first evaluates
    the endpoints of all, and then measures the segments at which it looks.

    Examples
    --------
    >>> import freeseg as fs
    >>> query = fs.load_table(4), (0, 0), (0.75, 0.75)
    >>> fs.plan(*query).effort.distances, fs.length_first_plan(*query).effort.distances
    (90, 99)
    """
    return search(ask(world, start, goal, robot, margin), measured_when_tried, by_detour)


def measured_when_tried(query: Query) -> Survey:
    """Survey with no segment measured yet, and the ends of all of them tried."""
    segments, of_obstacle = find_segments(query.world, query.robot, query.margin)
    ends = _all_ends(query.world, query.robot, query.margin)
    return Survey(segments, ends, of_obstacle, set())


@lru_cache(maxsize=16)
def _all_ends(world: World, robot: Robot, margin: float) -> tuple[Endpoint, ...]:
    """Endpoints of all segments, and outer ones; many queries of a world share them."""
    segments, _ = find_segments(world, robot, margin)
    return find_endpoints(world, [replace(segment, required=ANY_LENGTH) for segment in segments])
