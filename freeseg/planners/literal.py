"""The paper's planner word by word (section 3), to see what its words leave open."""

import numpy as np

from freeseg.errors import Trapped
from freeseg.geometry import cross
from freeseg.plan import Plan, Step, StepKind, TurningPoint
from freeseg.planners.query import ask
from freeseg.segments import MARGIN, find_endpoints, free_segments


def literal_plan(
    world, start, goal, robot=None, margin=MARGIN, concentric=False, outer_endpoints=False
):
    """Plan with nothing added to the paper's words: each choice once, and the first one.

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

    Returns
    -------
    Plan
        Checked path and trace.

    Raises
    ------
    InvalidQuery, InvalidParameter
        As for `plan`.
    Trapped
        Where these rules find no path, with their trace.
    """
    query = ask(world, start, goal, robot, margin)
    segments = free_segments(world, query.robot, query.margin)
    endpoints = [
        end for end in find_endpoints(world, segments) if outer_endpoints or end.segment is not None
    ]
    turns, steps = [], []
    path, passed = query.connect(turns)
    steps.append(Step(StepKind.STRAIGHT, path))
    while (danger := query.danger(path)) is not None:
        number, blocking, distance = danger
        # The first search is over all endpoints, a repair's (3.3.1) over the blocking obstacle's.
        used = [turn.endpoint for turn in turns]
        choice = [end for end in endpoints if not turns or end.obstacle == blocking]
        choice = [end for end in choice if end not in used]
        if not choice:
            raise Trapped(
                f"there is no endpoint, or none left, to turn at before obstacle {blocking + 1}; "
                "plan with fs.plan",
                steps,
            )
        place = passed[number]
        before = turns[place - 1].point if place else query.start
        after = turns[place].point if place < len(turns) else query.goal
        points = np.array([end.point for end in choice])
        detour = np.hypot(*(points - before).T) + np.hypot(*(points - after).T)  # (5), (6)
        end = choice[np.argmin(detour)]
        # Through the segment: the obstacle stays on the other side.
        sense = 1 if cross(after - before, end.outward) < 0 else -1
        radius = float(query.turning_radii[end.obstacle])
        center = end.center
        if not concentric:
            center, radius = end.point, radius - float(world.radii[end.obstacle])
        turns.insert(place, TurningPoint(end, end.obstacle, center, radius, sense))
        path, passed = query.connect(turns)
        if path is None:
            raise Trapped(
                f"no tangent leads to the dangerous circle at obstacle {end.obstacle + 1} and on; "
                "plan with fs.plan",
                steps,
            )
        kind = StepKind.TURNING_POINT if len(turns) == 1 else StepKind.of_danger(distance)
        steps.append(Step(kind, path, blocking=blocking, leg=np.array([before, after])))
    query.verify(path, steps)
    return Plan(path, segments, tuple(turns), tuple(steps), query.robot, query.margin)
