"""The other reading of the paper's "safest segment": the widest one."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from freeseg.plan import Plan
from freeseg.planners.free_segment import measured_first, search
from freeseg.planners.query import ask
from freeseg.robot import Robot
from freeseg.segments import MARGIN, Endpoint, FreeSegment
from freeseg.world import World


def widest_segment_plan(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> Plan:
    """Plan like `plan`, but turn at the widest free segment.

    Parameters
    ----------
    world, start, goal, robot, margin
        As for `plan`.

    Returns
    -------
    Plan
        Checked path and trace.

    Raises
    ------
    InvalidQuery, InvalidParameter, NoPath, Trapped
        As for `plan`.

    Notes
    -----
    Section 3.1 has the turning point on "the safest segment which gives the shortest
    path"; equations (5) and (6), which `plan` follows, compare the endpoints of every safe
    segment. Here the widest safe segment is tried first, of its two ends that with the
    shorter detour, then the next widest; and endpoints of no segment come last. A repair
    (section 3.3.1) does the same with the segments of the obstacle in the way.

    Examples
    --------
    >>> import freeseg as fs
    >>> query = fs.load_table(1), (0.4, 0), (0.8, 0.5)
    >>> widest_segment_plan(*query).path.length > fs.plan(*query).path.length
    True
    """
    return search(ask(world, start, goal, robot, margin), measured_first, by_width)


def by_width(
    segments: Sequence[FreeSegment], endpoints: Sequence[Endpoint], detours: np.ndarray
) -> np.ndarray:
    """Endpoints by decreasing width of their segment, then by increasing detour."""
    widths = [0.0 if end.segment is None else segments[end.segment].length for end in endpoints]
    return np.lexsort([detours, np.negative(widths)])
