"""The shortest path there is: the paper's loop with an exact inner plan."""

import numpy as np

from freeseg.errors import NoPath
from freeseg.plan import Plan, Step, StepKind, TurningPoint
from freeseg.planners.query import ROUND_OFF, ask
from freeseg.planners.tangent_graph import TangentGraph
from freeseg.segments import MARGIN


class ShortestRoute:
    """Shortest route round some obstacles, of which there may come more.

    Parameters
    ----------
    query : Query
        Start, goal and dangerous circles.
    """

    def __init__(self, query):
        self.query, self.graph = query, TangentGraph(query.start, query.goal)
        self.members, self.owner = set(), np.empty(0, int)

    def go_round(self, obstacles):
        """Turns of the shortest route round these obstacles and all before.

        Parameters
        ----------
        obstacles : iterable of int
            Indices; those never named are ignored.

        Returns
        -------
        list of TurningPoint
            In driving order.

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
                f"{_name(self.members)} leave no way from {query.start.tolist()} to "
                f"{query.goal.tolist()} for a robot of {query.robot.diameter:g} m with a margin "
                f"of {query.margin:g} m; move the start or the goal, or plan for a smaller robot "
                "or margin"
            )
        turns = []
        for circle, sense in route:
            center, radius = self.graph.centers[circle + 2], self.graph.radii[circle + 2]
            turns.append(TurningPoint(None, int(self.owner[circle]), center, float(radius), sense))
        return turns


def _name(obstacles):
    """Obstacles in words, numbered from 1; of many, the first few."""
    numbers = [index + 1 for index in sorted(obstacles)]
    if len(numbers) <= 12:
        return f"obstacles {numbers}"
    return f"{len(numbers)} obstacles ({numbers[:3]} and more)"


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
    keep_clear = query.turning_radii - world.radii - ROUND_OFF
    route = ShortestRoute(query)
    turns, steps = [], []
    path, _ = query.connect(turns)
    steps.append(Step(StepKind.STRAIGHT, path))
    while new := set(path.near(world, keep_clear)[1].tolist()) - route.members:
        turns = route.go_round(new)
        path, _ = query.connect(turns)
        steps.append(Step(StepKind.SHORTEST, path, group=tuple(sorted(route.members))))
    query.verify(path, steps)
    return Plan(path, (), tuple(turns), tuple(steps), query.robot, query.margin)
