"""The paper's planner word by word (section 3), to see what its words leave open."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import Trapped
from freeseg.geometry import cross, read_only
from freeseg.plan import Plan, Step, StepKind, TurningPoint
from freeseg.planners.query import Query, ask, detour_lengths
from freeseg.robot import Robot
from freeseg.segments import MARGIN, Endpoint, find_endpoints, free_segments
from freeseg.world import World


def literal_plan(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
    concentric: bool = False,
    outer_endpoints: bool = False,
    turning_radius: float | None = None,
) -> Plan:
    """Plan by the paper's words, with only what it takes to run them.

    Parameters
    ----------
    world, start, goal, robot, margin
        As for `plan`.
    concentric : bool, optional
        Whether to go round the obstacle itself; by default the dangerous
        circle is centred on the turning point, as section 3.2.2 has it.
    outer_endpoints : bool, optional
        Whether endpoints that face no neighbour count, see `find_endpoints`;
        by default only the ends of safe segments do.
    turning_radius : float, optional
        R_D (m), at least R_r; by default R_r + delta / 2, for the paper gives none.

    Returns
    -------
    Plan
        Checked path and trace.

    Raises
    ------
    InvalidQuery, InvalidParameter
        As for `plan`, and for a turning radius below R_r.
    Trapped
        Where these rules find no path, with their trace.

    Notes
    -----
    What the words leave open, and what stands here for it:

    1. the radius of the dangerous circle: R_D = R_r + delta / 2, or `turning_radius`;
    2. what an endpoint is: the point of an obstacle nearest to the neighbour;
       an endpoint serves once;
    3. which danger is solved: the first one on the way;
    4. what a repair chooses from (section 3.3.1): the endpoints of the obstacle
       in the way, by their detour between the turning points before and after;
    5. the side of a turn: through the segment, with the obstacle on the other
       side;
    6. the order of turns: a repair goes in where the danger was, and no turn
       is moved or dropped.

    The way out of a local minimum, "far away" (section 3.3.2), names neither a
    side nor a distance and is left out.
    """
    query = ask(world, start, goal, robot, margin)
    if turning_radius is not None:
        least = query.robot.radius
        remedy = f"at least the robot's radius, {least:g} m"
        reach = checks.number("turning_radius", turning_radius, lambda one: one >= least, remedy)
        query = replace(query, turning_radii=read_only(world.radii + reach))
    segments = free_segments(world, query.robot, query.margin)
    endpoints = [
        end for end in find_endpoints(world, segments) if outer_endpoints or end.segment is not None
    ]
    turns: list[TurningPoint] = []
    path, passed = query.straight_line(), [0]
    steps = [Step(StepKind.STRAIGHT, path)]
    while (danger := query.danger(path)) is not None:
        piece, blocking, distance = danger
        leg = query.leg(turns, passed[piece])
        endpoint = _choose(endpoints, turns, blocking, leg)
        if endpoint is None:
            raise Trapped(
                f"there is no endpoint, or none left, to turn at before obstacle {blocking + 1}; "
                "plan with fs.plan",
                steps,
            )
        turns.insert(passed[piece], _turn(query, endpoint, leg, concentric))
        longer, passed = query.connect(turns)
        if longer is None:
            raise Trapped(
                "no tangent leads to the dangerous circle at obstacle "
                f"{endpoint.obstacle + 1} and on; plan with fs.plan",
                steps,
            )
        path = longer
        kind = StepKind.TURNING_POINT if len(turns) == 1 else StepKind.of_danger(distance)
        steps.append(Step(kind, path, blocking=blocking, leg=leg))
    return query.answer(path, segments, turns, steps)


def _choose(
    endpoints: Sequence[Endpoint], turns: Sequence[TurningPoint], blocking: int, leg: np.ndarray
) -> Endpoint | None:
    """The endpoint of least detour where there is no turn yet, or None.

    The first search is over all endpoints, a repair's (3.3.1) over the blocking obstacle's.
    """
    used = [turn.endpoint for turn in turns]
    choice = [end for end in endpoints if not turns or end.obstacle == blocking]
    choice = [end for end in choice if end not in used]
    return choice[np.argmin(detour_lengths(choice, leg))] if choice else None


def _turn(query: Query, endpoint: Endpoint, leg: np.ndarray, concentric: bool) -> TurningPoint:
    """Turning point at an endpoint, through the segment: the obstacle stays on the other side."""
    obstacle = endpoint.obstacle
    sense = 1 if cross(leg[1] - leg[0], endpoint.outward) < 0 else -1
    center, radius = endpoint.center, float(query.turning_radii[obstacle])
    if not concentric:
        center, radius = endpoint.point, radius - float(query.world.radii[obstacle])
    return TurningPoint(endpoint, obstacle, center, radius, sense)
