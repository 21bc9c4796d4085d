"""The shortest path there is: the paper's loop with an exact inner plan."""

import numpy as np

from freeseg.errors import NoPath
from freeseg.planners.query import ROUND_OFF, Plan, Step, TurningPoint, ask
from freeseg.planners.tangent_graph import shortest_circles
from freeseg.segments import MARGIN, free_segments


def go_round(query, members):
    """Turns of the shortest way round some of the obstacles.

    Parameters
    ----------
    query : Query
        Start, goal and dangerous circles.
    members : sequence of int
        Indices of the obstacles to go round; the others are ignored.

    Returns
    -------
    list of TurningPoint
        In driving order.

    Raises
    ------
    NoPath
        Where these obstacles alone leave no way.
    """
    corners = [query.world.corners[index] for index in members]
    edges = [query.world.obstacles[index].edges for index in members]
    owner = np.repeat(members, [len(part) for part in corners]).astype(int)
    walls = np.repeat(members, [len(part) for part in edges]).astype(int)
    centers, radii = np.concatenate(corners), query.turning_radii[owner]
    way = shortest_circles(
        query.start,
        query.goal,
        (centers, radii),
        (np.concatenate(edges), query.turning_radii[walls]),
    )
    if way is None:
        raise NoPath(
            f"obstacles {[int(index) + 1 for index in members]} leave no way from "
            f"{query.start.tolist()} to {query.goal.tolist()} for a robot of "
            f"{query.robot.diameter:g} m with a margin of {query.margin:g} m; move the start or "
            "the goal, or plan for a smaller robot or margin"
        )
    return [
        TurningPoint(None, int(owner[index]), centers[index], float(radii[index]), sense)
        for index, sense in way
    ]


def shortest_path(world, start, goal, robot=None, margin=MARGIN):
    """Plan the shortest path that keeps the margin, or prove that there is none.

    Parameters
    ----------
    world : World
        Obstacles, in any order.
    start, goal : array_like, shape (2,)
        Positions (m).
    robot : KheperaIV, optional
        Robot; its disc must fit.
    margin : float, optional
        Security margin delta (m); 5 mm is an assumption.

    Returns
    -------
    Plan
        Checked path; its centre line keeps R_D from every obstacle, or less
        where the start or the goal is closer.

    Raises
    ------
    InvalidQuery, InvalidParameter
        As for `plan`.
    NoPath
        Where no path keeps the margin: this is a proof.

    Notes
    -----
    The paper's loop (plan, look for danger, solve it, plan again), with each
    plan the exact shortest path among the obstacles met so far. Leaving
    obstacles out can only shorten the optimum, so the first path without
    danger is optimal in the whole world; and if the obstacles met leave no
    way, there is none.

    Examples
    --------
    >>> import freeseg as fs
    >>> round(shortest_path(fs.load_table(1), (0, 0), (0.75, 0.75)).path.length, 4)
    1.1287
    """
    query = ask(world, start, goal, robot, margin)
    reach = query.turning_radii - world.radii
    turns, met, steps = [], set(), []
    path, _ = query.connect(turns)
    steps.append(Step("straight", path))
    while True:
        too_close = (path.distances(world) < reach - ROUND_OFF).any(0)
        new = set(np.flatnonzero(too_close).tolist()) - met
        if not new:
            break
        met |= new
        turns = go_round(query, sorted(met))
        path, _ = query.connect(turns)
        steps.append(Step("shortest", path, group=tuple(sorted(met))))
    query.verify(path, steps)
    segments = free_segments(world, query.robot, query.margin)
    return Plan(path, segments, tuple(turns), tuple(steps), query.robot, query.margin)
