"""The routes of the 16 cases, the rounds that find the shortest one, and what came of them."""

from collections.abc import Mapping

import numpy as np
import shapely

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import read_only, unit
from freeseg.path import Path
from freeseg.plan import check_plan, turning_radius
from freeseg.plotting.axes import PALETTE, check_axes, new_axes
from freeseg.plotting.worlds import (
    as_patch,
    plot_band,
    plot_circle,
    plot_group,
    plot_path,
    plot_query,
    plot_segments,
    plot_world,
    trace,
)
from freeseg.robot import as_robot
from freeseg.world import Disc, check_world

#: Distance of a number from its disc (m), and the directions in which a place for it is sought.
BESIDE, AROUND = 0.045, read_only(unit(np.linspace(0, 2 * np.pi, 49)))

#: The paper has so many cases; height of the bar of the commonest count in a row.
CASES, TALLEST = 16, 0.42

#: Colours above and below the base line.
COUNT_COLORS = "planned", "turning"


def plot_case(plan, best, ax=None):
    """A plan and, dashed, the shortest path, among segments, circles and groups.

    The numbers stand beside the discs, where no line is near.

    Parameters
    ----------
    plan, best : Plan
        What is judged, such as `freeseg.plan`'s, and what `shortest_path`
        found in the same world.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    world = check_plan(plan).world
    check_plan(best, world)
    ax = plot_world(world, ax)
    plot_group(world, {index for step in plan.steps for index in step.group}, ax)
    plot_segments(plan.segments, ax)
    for index, turn in enumerate(plan.turning_points):
        plot_circle(turn.center, turn.radius, ax, label=None if index else "dangerous circle")
    plot_band(plan.path, plan.robot, ax)
    plot_path(plan.path, ax, lw=4, label="plan")
    plot_path(best.path, ax, "black", lw=1.3, ls=(0, (4, 2)), label="shortest path")
    lines = [trace(plan.path).T, trace(best.path).T]
    lines += [segment.ends for segment in plan.segments]
    lines += [turn.center + turn.radius * AROUND for turn in plan.turning_points]
    _put_numbers_beside(ax, world, lines)
    return plot_query(plan.path.start, plan.path.end, ax)


def plot_round(world, path, met, robot, margin, ax=None):
    """A round of the exact loop: the obstacles met so far, and those now in danger.

    Parameters
    ----------
    world : World
        Obstacles.
    path : Path or None
        Shortest path among the obstacles met; None where they leave none.
    met : sequence of int
        Indices of the obstacles met so far.
    robot : Robot
        Its radius and half the margin are kept from the obstacles met.
    margin : float
        Security margin delta (m).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    met = checks.indices("met", met, len(check_world(world)), "obstacles")
    keep = turning_radius(as_robot(robot), checks.not_negative("margin", margin))
    ax = plot_group(world, met, plot_world(world, ax), "obstacle met")
    grown = shapely.union_all([world.cores[k].buffer(world.radii[k] + keep) for k in met])
    for k, outline in enumerate(shapely.get_parts(shapely.boundary(grown))):
        style = {"color": PALETTE["turning"], "lw": 1.3, "ls": "--", "zorder": 3}
        ax.plot(*outline.xy, **style, label=None if k else "$R_D$ from them")
    if path is None:
        return ax
    plot_band(path, robot, ax)
    plot_path(path, ax, label="shortest path among them")
    danger = set(path.near(world, keep - 2 * world.round_off)[1].tolist()) - set(met)
    for k, index in enumerate(sorted(danger)):
        style = {"fill": False, "ec": "black", "lw": 3, "zorder": 5}
        label = None if k else "in danger: met next"
        ax.add_patch(as_patch(world.obstacles[index], **style, label=label))
    _put_numbers_beside(ax, world, [trace(path).T])
    return plot_query(path.start, path.end, ax)


def plot_clearance(world, path, obstacle, ax):
    """Where a path is nearest to an obstacle: a short line from the one to the other.

    Parameters
    ----------
    world : World
        Obstacles.
    path : Path
        Centre line.
    obstacle : int
        Index of the obstacle.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    (obstacle,) = checks.indices("obstacle", [obstacle], len(check_world(world)), "obstacles")
    checks.instance("path", path, Path, "a Path, such as plan.path")
    check_axes(ax)
    line = shapely.LineString(trace(path).T)
    ends = shapely.get_coordinates(shapely.shortest_line(line, world.cores[obstacle]))
    length = np.hypot(*(ends[1] - ends[0]))
    # The core of a disc is its centre; the line ends where the disc begins.
    share = world.radii[obstacle] / length if length else 0.0
    ends[1] += min(share, 1.0) * (ends[0] - ends[1])
    ax.plot(*ends.T, color="black", lw=2.5, zorder=8, label="$d$")
    return ax


def plot_counts(counts, chosen, ax=None):
    """How often each count came out, with two kinds of worlds back to back.

    Parameters
    ----------
    counts : dict
        Name of a kind to a dict of row labels to whole numbers, shape (n,),
        one of each world. Two kinds with the same rows: the first is drawn
        above the base line, the second below. Each row has a scale of its own.
    chosen : dict
        Row label to the count that is marked by a diamond.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidParameter
        For counts that are none or not 0 to 16, other than two kinds, or rows that differ.
    """
    kinds = _check_counts(counts, chosen)
    ax = new_axes(ax, (8, 1.0 + 0.9 * len(chosen)))
    for place, label in enumerate(chosen):
        bars = [np.bincount(rows[label], minlength=CASES + 1) for rows in kinds.values()]
        heights = np.array([found / found.sum() for found in bars])
        heights *= TALLEST / heights.max()
        for kind, height, sign, color in zip(kinds, heights, (1, -1), COUNT_COLORS, strict=True):
            style = {"bottom": -place, "width": 0.9, "color": PALETTE[color]}
            ax.bar(range(CASES + 1), sign * height, **style, label=None if place else kind)
    places = -np.arange(len(chosen))
    ax.hlines(places, -0.5, CASES + 0.5, color=PALETTE["outline"], lw=0.8)
    style = {"ls": "", "mfc": "white", "mec": "black", "ms": 7, "zorder": 5}
    ax.plot(list(chosen.values()), places, "D", **style, label="our sizes")
    ax.set(xlim=(-0.6, CASES + 0.6), xticks=range(CASES + 1), xlabel=f"cases out of {CASES}")
    ax.set_yticks(places, list(chosen))
    ax.tick_params(axis="y", length=0)
    ax.spines[["top", "left", "right"]].set_visible(False)
    return ax


def _check_counts(counts, chosen):
    """Counts as arrays of whole numbers, by kind and row, or `InvalidParameter`."""
    checks.instance("chosen", chosen, Mapping, "a dict of row label to count")
    checks.instance("counts", counts, Mapping, "a dict of two kinds")
    for label, count in chosen.items():
        _check_row(label, [count])
    kinds = {}
    for kind, rows in counts.items():
        checks.instance(f"counts[{kind!r}]", rows, Mapping, "a dict of row label to counts")
        if set(rows) != set(chosen):
            raise InvalidParameter(
                f"counts[{kind!r}] has the rows {checks.shown(list(rows))}; give those of chosen, "
                f"{checks.shown(list(chosen))}"
            )
        kinds[kind] = {label: _check_row(label, found) for label, found in rows.items()}
    if len(kinds) != 2 or not chosen:
        raise InvalidParameter(
            f"counts has {len(kinds)} kinds and {len(chosen)} rows; give two kinds, and rows"
        )
    return kinds


def _check_row(label, found):
    """Counts of one row as an array, or `InvalidParameter`."""
    counts = checks.array(f"row {label!r}", found, (None,), unit="cases")
    if ((counts < 0) | (counts > CASES) | (counts % 1 != 0)).any():
        raise InvalidParameter(
            f"row {label!r} is {checks.shown(counts.tolist())}; give whole numbers of cases, 0 to "
            f"{CASES}"
        )
    return counts.astype(int)


def _put_numbers_beside(ax, world, lines):
    """Move the numbers off the discs, to where no line (m) and no obstacle is near."""
    grown = [core.buffer(r) for core, r in zip(world.cores, world.radii, strict=True)]
    busy = shapely.union_all([*grown, *map(shapely.LineString, lines)])
    for number, obstacle in zip(ax.texts, world.obstacles, strict=False):
        if isinstance(obstacle, Disc):
            spots = obstacle.center + (obstacle.radius + BESIDE) * AROUND
            room = shapely.distance(shapely.points(spots), busy).round(6)
            number.xyann = spots[np.argmax(room)]
            busy = busy.union(shapely.Point(number.xyann))
