"""Two planners as one: what the first cannot decide, the second does."""

from dataclasses import replace

from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import Trapped
from freeseg.plan import Plan, Planner
from freeseg.robot import Robot
from freeseg.segments import MARGIN
from freeseg.world import World


def with_fallback(first: Planner, second: Planner) -> Planner:
    """Planner that asks a second one where the first is trapped.

    Parameters
    ----------
    first, second : Planner
        Such as `plan_rooms`, which is fast and proves nothing, and
        `shortest_path`, which finds a path wherever there is one.

    Returns
    -------
    Planner
        Its plan is the first one's or, with the first one's steps before its
        own, the second one's.

    Examples
    --------
    >>> import freeseg as fs
    >>> planner = with_fallback(fs.plan_rooms, fs.shortest_path)
    >>> planner(fs.load_table(5), (0, 0), (0.8, 0.5)).steps[-1].kind.value
    'rooms'
    """
    for name, given in (("first", first), ("second", second)):
        question = None, None, None, None, MARGIN
        checks.function(name, given, "a planner, such as fs.plan", *question)

    def planner(
        world: World,
        start: ArrayLike,
        goal: ArrayLike,
        robot: Robot | None = None,
        margin: float = MARGIN,
    ) -> Plan:
        try:
            return first(world, start, goal, robot, margin)
        except Trapped as trapped:
            found = second(world, start, goal, robot, margin)
            # Both begin with the straight line.
            return replace(found, steps=(*trapped.steps, *found.steps[1:]))

    return planner
