"""The shortest path there is: the paper's loop, on tangents instead of whole paths."""

from numpy.typing import ArrayLike

from freeseg.errors import NoPath
from freeseg.plan import Plan, Step, StepKind
from freeseg.planners.query import Query, ask
from freeseg.planners.route import shortest_route
from freeseg.robot import Robot
from freeseg.segments import MARGIN
from freeseg.world import World

#: So many plans are made at most to name what leaves no way, in worlds of so many edges at most:
#: in larger ones they would take longer than the answer.
PLANS, NAMED = 20, 1000


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
    The paper's loop (plan, look for danger, solve it, plan again), driven to
    its end: `tangent_search` keeps all that could be driven next, looks for
    danger on the most promising tangent only, and goes on from there. The
    first one that arrives ends an optimal path. The last step's group are the
    obstacles that mattered on the way, and `Plan.lower_bound` is the length
    below which the search proved that there is nothing. What prepares a world
    is remembered, so that further queries of the same world are faster.

    Examples
    --------
    >>> import freeseg as fs
    >>> round(shortest_path(fs.load_table(1), (0, 0), (0.75, 0.75)).path.length, 4)
    1.1287
    """
    query = ask(world, start, goal, robot, margin)
    path = query.straight_line()
    steps = [Step(StepKind.STRAIGHT, path)]
    if not len(path.near(world, query.turning_radii - world.radii - query.round_off)[0]):
        return query.answer(path, (), (), steps, lower_bound=path.length)
    try:
        route = shortest_route(query)
    except NoPath:
        if len(world.edges) <= NAMED:
            _name_what_bars(query)
        raise
    steps.append(Step(StepKind.SHORTEST, route.path, group=route.met))
    return query.answer(route.path, (), route.turns, steps, lower_bound=route.length)


def _name_what_bars(query: Query) -> None:
    """`NoPath` that names no more obstacles than the paper's loop meets, if it soon ends.

    Plan, look for danger, and plan again round all that was met: where these alone leave
    no way, the whole world leaves none.
    """
    keep_clear = query.turning_radii - query.world.radii - query.round_off
    met: set[int] = set()
    path = query.straight_line()
    for _ in range(PLANS):
        met |= set(path.near(query.world, keep_clear)[1].tolist())
        path = shortest_route(query, met).path
