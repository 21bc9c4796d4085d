"""Plans, whole and step by step."""

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.path import Arc
from freeseg.plan import StepKind, check_plan
from freeseg.plotting.axes import PALETTE
from freeseg.plotting.worlds import (
    as_patch,
    plot_band,
    plot_circle,
    plot_group,
    plot_path,
    plot_query,
    plot_segments,
    plot_world,
)
from freeseg.world import check_world


def plot_plan(world, plan, ax=None):
    """A plan: obstacles, free segments, dangerous circles and path.

    The band is what the robot's disc sweeps.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_plan(plan, check_world(world))
    ax = plot_world(world, ax)
    plot_segments(plan.segments, ax)
    for index, turn in enumerate(plan.turning_points):
        plot_circle(turn.center, turn.radius, ax, label=None if index else "dangerous circle")
    plot_band(plan.path, plan.robot, ax)
    plot_path(plan.path, ax, label="planned path", lw=3.5)
    return plot_query(plan.path.start, plan.path.end, ax)


def plot_step(world, plan, step, ax=None):
    """One step of a plan's trace: what was met, considered and chosen.

    The obstacle that blocked the path before is outlined, a group is filled;
    a thin line joins the ends of the leg on which candidates, the small
    circles, were ranked.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        The plan that the step belongs to.
    step : Step
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_plan(plan, check_world(world))
    place = next((k for k, one in enumerate(plan.steps) if one is step), None)
    if place is None:
        raise InvalidParameter(f"step is {checks.shown(step)}; give one of plan.steps")
    ax = plot_world(world, ax)
    plot_segments(plan.segments, ax)
    if step.group:
        plot_group(world, step.group, ax)
    if step.blocking is not None:
        label = "turn dropped here" if step.kind == StepKind.NEEDLESS_TURN else "blocking obstacle"
        style = {"fill": False, "ec": PALETTE["danger"], "lw": 2.5, "zorder": 2.6, "label": label}
        ax.add_patch(as_patch(world.obstacles[step.blocking], **style))
    if place:
        plot_path(plan.steps[place - 1].path, ax, "0.45", lw=1.5, ls="--", label="path before")
    if step.leg is not None:
        style = {"color": PALETTE["turning"], "lw": 1.2, "ls": ":", "zorder": 3.5}
        ax.plot(*step.leg.T, **style, label="leg searched")
    for k, arc in enumerate(piece for piece in step.path.pieces if isinstance(piece, Arc)):
        plot_circle(arc.center, arc.radius, ax, label=None if k else "dangerous circle")
    for index, candidate in enumerate(step.candidates):
        x, y = candidate.endpoint.point
        style = {"mfc": "white", "mec": PALETTE["turning"], "ms": 4, "zorder": 5}
        ax.plot(x, y, "o", **style, label=None if index else "candidate")
    if step.chosen:
        x, y = step.chosen.endpoint.point
        style = {"color": PALETTE["turning"], "mec": "black", "ms": 8, "zorder": 7}
        ax.plot(x, y, "o", **style, label="turning point")
    plot_path(step.path, ax, label="path after this step")
    ax.set_title(step.kind)
    return plot_query(plan.path.start, plan.path.end, ax)
