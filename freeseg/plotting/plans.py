"""Plans, whole and step by step."""

import numpy as np
from matplotlib.figure import Figure

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.path import Arc
from freeseg.plan import StepKind, check_plan
from freeseg.plotting.axes import PALETTE
from freeseg.plotting.worlds import (
    HALO,
    MOST_NUMBERS,
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

#: Half the width of an obstacle that holds its number, as a share of the map's.
SMALL = 0.045


def plot_plan(world, plan, ax=None, numbers=None):
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
    numbers : bool, optional
        Whether to number the obstacles, see `plot_world`.

    Returns
    -------
    matplotlib Axes
    """
    check_plan(plan, check_world(world))
    ax = plot_world(world, ax, numbers)
    plot_segments(plan.segments, ax)
    for index, turn in enumerate(plan.turning_points):
        plot_circle(turn.center, turn.radius, ax, label=None if index else "dangerous circle")
    plot_band(plan.path, plan.robot, ax)
    plot_path(plan.path, ax, label="planned path", lw=3.5)
    return plot_query(plan.path.start, plan.path.end, ax)


def plot_step(world, plan, step, ax=None):
    """One step of a plan's trace: what was met, considered and chosen.

    The obstacle that blocked the path before is outlined, a group is filled.
    Thin crosses are all candidates of the step, also those that were never
    examined because a shorter detour had been found; the chosen one is a
    large disc. A dotted line joins the ends of the leg on which they were
    ranked.

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
    ax = plot_world(world, ax, numbers=False)
    if len(world) <= MOST_NUMBERS:
        _write_numbers(world, ax)
    plot_segments(plan.segments, ax)
    _plot_met(world, step, ax)
    if place:
        plot_path(plan.steps[place - 1].path, ax, "0.45", lw=1.5, ls="--", label="path before")
    if step.leg is not None:
        style = {"color": PALETTE["error"], "lw": 1, "ls": ":", "zorder": 3.5}
        ax.plot(*step.leg.T, **style, label="leg searched")
    for k, arc in enumerate(piece for piece in step.path.pieces if isinstance(piece, Arc)):
        plot_circle(arc.center, arc.radius, ax, label=None if k else "dangerous circle")
    _plot_candidates(step, ax)
    plot_path(step.path, ax, label="path after this step")
    ax.set_title(f"step {place}: {step.kind}")
    return plot_query(plan.path.start, plan.path.end, ax)


def _write_numbers(world, ax):
    """Numbers inside of large obstacles, and beside small ones, whose rims candidates cover."""
    extent = np.ptp(world.edges.reshape(-1, 2), axis=0).max() if len(world) else 0
    for number, core in enumerate(world.cores[: world.frame], 1):
        (x, y), radius = core.representative_point().coords[0], world.radii[number - 1]
        half = radius + (core.bounds[2] - core.bounds[0]) / 2
        inside = half > SMALL * extent
        style = {"ha": "center" if inside else "left", "va": "center", "fontsize": 9, "zorder": 6}
        shift = {"xytext": (0 if inside else 6, 0), "textcoords": "offset points"}
        place = (x, y) if inside else (core.bounds[2] + radius, y)
        ax.annotate(str(number), place, path_effects=HALO, **shift, **style)


def _plot_met(world, step, ax):
    """The obstacles that a step is about: its group, and what was in the way."""
    if step.group:
        plot_group(world, step.group, ax)
    if step.blocking is not None:
        label = "turn dropped here" if step.kind == StepKind.NEEDLESS_TURN else "blocking obstacle"
        style = {"fill": False, "ec": PALETTE["danger"], "lw": 3, "zorder": 2.6, "label": label}
        ax.add_patch(as_patch(world.obstacles[step.blocking], **style))


def _plot_candidates(step, ax):
    """All endpoints that a step ranked, and the one that it chose."""
    if step.candidates:
        points = [candidate.endpoint.point for candidate in step.candidates]
        style = {"mec": PALETTE["error"], "mew": 1.1, "ms": 5, "zorder": 5}
        ax.plot(*zip(*points, strict=True), "x", **style, label="candidate")
    if step.chosen:
        x, y = step.chosen.endpoint.point
        style = {"color": PALETTE["turning"], "mec": "black", "ms": 9, "zorder": 7}
        ax.plot(x, y, "o", **style, label="turning point chosen")


def legend_below(figure, ncols=4):
    """One legend for all axes of a figure, below them, where it hides nothing.

    Parameters
    ----------
    figure : matplotlib Figure
        With the layout "constrained", which makes room for the legend.
    ncols : int, optional
        Number of columns.

    Returns
    -------
    matplotlib Legend
    """
    checks.instance("figure", figure, Figure, "a Figure, such as ax.figure")
    ncols = checks.whole("ncols", ncols, 1)
    named = {}
    for ax in figure.axes:
        handles, labels = ax.get_legend_handles_labels()
        # What two axes call by one name is drawn alike.
        named |= dict(zip(labels, handles, strict=True))
    place = {"loc": "outside lower center", "ncols": ncols, "fontsize": 8}
    return figure.legend(named.values(), named, **place)
