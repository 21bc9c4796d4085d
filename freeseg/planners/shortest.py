"""The shortest path there is: the paper's loop with an exact inner plan."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from freeseg.errors import NoPath
from freeseg.path import Path
from freeseg.plan import Plan, Step, StepKind, TurningPoint
from freeseg.planners.query import ROUND_OFF, Query, ask
from freeseg.planners.tangent_graph import TangentGraph
from freeseg.robot import Robot
from freeseg.segments import MARGIN
from freeseg.world import World


class ShortestRoute:
    """Shortest route round some obstacles, of which there may come more.

    Parameters
    ----------
    query : Query
        Start, goal and dangerous circles.
    """

    def __init__(self, query: Query) -> None:
        self.query, self.graph = query, TangentGraph(query.start, query.goal)
        self.members: set[int] = set()
        self.owner = np.empty(0, int)

    def go_round(self, obstacles: Iterable[int]) -> tuple[list[TurningPoint], Path, list[int]]:
        """The shortest route round these obstacles and all before.

        Parameters
        ----------
        obstacles : iterable of int
            Indices; those never named are ignored.

        Returns
        -------
        turns : list of TurningPoint
            In driving order.
        path, passed
            From `taut_path`.

        Raises
        ------
        NoPath
            Where these obstacles alone leave no way.
        """
        query, world = self.query, self.query.world
        new = np.array(sorted(set(obstacles) - self.members), int)
        self.members.update(new.tolist())
        corners = [world.corners[index] for index in new]
        owner = np.repeat(new, [len(part) for part in corners])
        self.owner = np.concatenate([self.owner, owner])
        self.graph.add(
            np.concatenate(corners),
            query.turning_radii[owner],
            world.edges[world.edges_of(new)],
            query.turning_radii[np.repeat(new, world.edge_counts[new])],
        )
        route = self.graph.shortest()
        if route is None:
            raise NoPath(
                f"{_in_words(self.members)} leave no way from {query.start.tolist()} to "
                f"{query.goal.tolist()} for a robot of {query.robot.diameter:g} m with a margin "
                f"of {query.margin:g} m; move the start or the goal, or plan for a smaller robot "
                "or margin"
            )
        turns = []
        for circle, sense in route:
            center, radius = self.graph.centers[circle + 2], self.graph.radii[circle + 2]
            turns.append(TurningPoint(None, int(self.owner[circle]), center, float(radius), sense))
        path, passed = query.connect(turns)
        assert path is not None, "the graph has its tangents"
        return turns, path, passed


def _in_words(obstacles: Iterable[int]) -> str:
    """Obstacles in words, numbered from 1; of many, the first few."""
    numbers = [index + 1 for index in sorted(obstacles)]
    if len(numbers) <= 12:
        return f"obstacles {numbers}"
    return f"{len(numbers)} obstacles ({numbers[:3]} and more)"


def shortest_path(
    world: World,
    start: ArrayLike,
    goal: ArrayLike,
    robot: Robot | None = None,
    margin: float = MARGIN,
) -> Plan:
    """Plan the shortest path that keeps the margin, or prove that there is none.

    Parameters
    ----------
    world : World
        Obstacles, in any order.
    start, goal : array_like, shape (2,)
        Positions (m).
    robot : Robot, optional
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
    keep_clear = query.turning_radii - world.radii - ROUND_OFF
    route = ShortestRoute(query)
    turns: list[TurningPoint] = []
    path = query.straight_line()
    steps = [Step(StepKind.STRAIGHT, path)]
    while new := set(path.near(world, keep_clear)[1].tolist()) - route.members:
        turns, path, _ = route.go_round(new)
        steps.append(Step(StepKind.SHORTEST, path, group=tuple(sorted(route.members))))
    return query.answer(path, (), turns, steps)
