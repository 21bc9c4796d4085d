"""What reactive laws see and choose, where rivals drive, and who solves what others do not."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import cycle

import numpy as np
from matplotlib import colormaps
from matplotlib.patches import Rectangle
from matplotlib.ticker import PercentFormatter

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import unit
from freeseg.path import Path
from freeseg.plan import Plan
from freeseg.plotting.axes import PALETTE, check_colors, count_in_mm, map_axes, new_axes
from freeseg.plotting.robots import check_pose, draw_robot
from freeseg.plotting.runs import check_run
from freeseg.plotting.worlds import plot_query, plot_world, trace
from freeseg.react import ARRIVED
from freeseg.reactive import DynamicWindow, PotentialField, VectorFieldHistogram
from freeseg.reactive.dynamic_window import free_distances, reachable
from freeseg.reactive.sensing import outlines_of, scan
from freeseg.robot import as_robot
from freeseg.simulate import Run
from freeseg.world import as_position, check_world

#: Length of the longest arrow of a force (m).
ARROW = 0.2

#: Radii of the circles between which the bars of a histogram stand, in robot's radii.
BARS = 1.5, 4.0

#: Height of the bar of an empty sector, in radii of the inner circle.
LOWEST = 0.06

#: Speeds and turn rates of the map of velocities, on each axis.
MESH = 241

#: How tracks are drawn that nobody has given a colour.
TRACKS = ["planned", "tracked", "safe", "danger", "turning", "error", "left"]
DASHES = ["-", (0, (5, 1.5)), (0, (1.5, 1))]

#: Width of the last track's line, and by how much each one before it is wider (points).
THINNEST, WIDER = 1.4, 0.9


def plot_forces(field, world, goal, point, robot=None, ax=None):
    """What pulls and what pushes a robot in a potential field, and their sum.

    Parameters
    ----------
    field : PotentialField
        Law.
    world : World
        Obstacles.
    goal, point : array_like, shape (2,)
        The goal, and where the robot is (m).
    robot : Robot, optional
        Robot; a Khepera IV by default.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("field", field, PotentialField, "a PotentialField")
    goal, point = as_position(goal, "goal"), as_position(point, "point")
    robot = as_robot(robot)
    total = field.force(world, goal, robot)(point)
    pull = replace(field, repulsion=0.0).force(world, goal, robot)(point)
    forces = {"attraction": pull, "repulsion": total - pull, "sum": total}
    scale = ARROW / max(max(np.hypot(*force) for force in forces.values()), 1e-12)
    ax = map_axes(ax)
    draw_robot([*point, np.arctan2(*total[::-1])], robot, ax)
    for (name, force), color in zip(forces.items(), ("safe", "danger", "tracked"), strict=True):
        style = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.012, "zorder": 5}
        ax.quiver(*point, *(scale * force), color=PALETTE[color], label=name, **style)
    ax.plot(*goal, "k*", ms=11, zorder=6, label="goal")
    return ax


def plot_histogram(law, world, goal, pose, robot=None, ax=None):
    """What VFH+ makes of one scan: readings, sectors and the direction it chooses.

    Parameters
    ----------
    law : VectorFieldHistogram
        Law.
    world : World
        Obstacles.
    goal : array_like, shape (2,)
        Where to (m).
    pose : array_like, shape (3,)
        x, y (m) and heading (rad) of the robot, which stands.
    robot : Robot, optional
        Robot; a Khepera IV by default.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("law", law, VectorFieldHistogram, "a VectorFieldHistogram")
    goal, pose, robot = as_position(goal, "goal"), check_pose(pose), as_robot(robot)
    bearing, distance = _readings(world, pose, law.reach)
    height = law.histogram(bearing, distance, robot)
    blocked = law.binary(height, np.zeros(law.sectors, bool))
    target = np.arctan2(*(goal - pose[:2])[::-1])
    chosen = law.select(blocked, target, pose[2], pose[2])
    ax = map_axes(ax)
    inner, outer = robot.radius * np.array(BARS)
    scale = (outer - inner) / max(height.max(), law.high)
    _draw_sectors(pose[:2], inner, np.maximum(scale * height, LOWEST * inner), blocked, ax)
    circle = pose[:2] + (inner + scale * law.high) * unit(np.linspace(0, 2 * np.pi, 181))
    ax.plot(*circle.T, color="0.3", ls=":", lw=1.2, zorder=3.5, label="threshold")
    points = pose[:2] + distance[:, None] * unit(bearing)
    ax.plot(*points.T, ".", color=PALETTE["error"], ms=4, zorder=4, label="reading")
    draw_robot(pose, robot, ax)
    if chosen is not None:
        style = {"arrowstyle": "-|>", "color": PALETTE["tracked"], "lw": 2.5}
        end = pose[:2] + 1.3 * outer * unit(chosen)
        ax.annotate("", end, pose[:2], arrowprops=style, zorder=6)
        ax.plot([], [], color=PALETTE["tracked"], lw=2.5, label="direction chosen")
    ax.plot(*goal, "k*", ms=11, zorder=6, label="goal")
    return ax


def _readings(world, pose, reach):
    """Bearings (rad) and distances (m) of what a scan meets of a world."""
    bearing, distance = scan(outlines_of(check_world(world))(0.0), pose, reach)
    met = np.isfinite(distance)
    return bearing[met], distance[met]


def _draw_sectors(middle, inner, tall, blocked, ax):
    """Bars on a circle, one a sector, blocked ones in another colour."""
    sectors = len(tall)
    angles = 2 * np.pi / sectors * (np.arange(sectors)[:, None] + (-0.45, 0.45))
    labels = {True: "blocked sector", False: "free sector"}
    for (low, high), bar, bad in zip(angles, tall, blocked.tolist(), strict=True):
        far, color = inner + bar, PALETTE["danger" if bad else "safe"]
        corners = [inner * unit(low), far * unit(low), far * unit(high), inner * unit(high)]
        bars = ax.fill(*(middle + corners).T, color=color, lw=0, zorder=1.5)
        bars[0].set_label(labels.pop(bad, None))


def plot_window(law, world, goal, run, step, ax=None):
    """All velocities of a dynamic window at one step of a drive, and the one that it chose.

    Parameters
    ----------
    law : DynamicWindow
        Law.
    world : World
        Obstacles.
    goal : array_like, shape (2,)
        Where to (m).
    run : Run
        What one robot drove by the law.
    step : int
        Which of its steps: the first is 0, from rest.
    ax : matplotlib Axes, optional
        Where to draw: turn rates to the right, speeds upwards.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("law", law, DynamicWindow, "a DynamicWindow")
    goal = as_position(goal, "goal")
    check_run(run)
    (step,) = checks.indices("step", [step], len(run.t) - 1, "steps")
    robot, dt, pose = run.robot, run.t[1] - run.t[0], run.pose[:, step]
    present = robot.to_body(run.wheels[:, step - 1]) if step else (0.0, 0.0)
    v, omega = np.meshgrid(
        np.linspace(0, law.speed, MESH), np.linspace(-law.turn_rate, law.turn_rate, MESH)
    )
    worth = _worth_of(law, v, omega, world, goal, pose, robot, dt)
    ax = new_axes(ax, (6.4, 4))
    shades = ax.contourf(omega, v, worth, 12, cmap="Blues", zorder=1)
    ax.figure.colorbar(shades, ax=ax, label="objective")
    ax.set_facecolor(PALETTE["obstacle"])
    inside = reachable(v, omega, *present, robot, dt)
    ax.contour(omega, v, inside, [0.5], colors=PALETTE["error"], linewidths=2, zorder=3)
    ax.plot([], [], color=PALETTE["error"], lw=2, label="dynamic window")
    ax.fill([], [], color=PALETTE["obstacle"], label="cannot stop in time")
    ax.plot(present[1], present[0], "o", color=PALETTE["error"], ms=6, zorder=4, label="driven now")
    chosen = robot.to_body(run.asked[:, step])
    style = {"color": PALETTE["tracked"], "ms": 14, "mec": "white", "zorder": 5, "clip_on": False}
    ax.plot(chosen[1], chosen[0], "*", label="chosen", **style)
    ax.set(xlabel="turn rate (rad/s); positive to the left", ylabel="speed (mm/s)")
    # The robot's left is on the left.
    ax.set(xlim=(law.turn_rate, -law.turn_rate), ylim=(0, law.speed))
    count_in_mm(ax.yaxis)
    return ax


def _worth_of(law, v, omega, world, goal, pose, robot, dt):
    """The objective of velocities before it is smoothed; NaN for those not admissible."""
    bearing, distance = _readings(world, pose, law.reach)
    x, y = distance * unit(bearing - pose[2]).T
    dist = free_distances(v, omega, x, y, robot.radius + law.margin)
    away, (cos, sin) = goal - pose[:2], unit(pose[2])
    ahead, left = cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]
    worth = law.objective(v, omega, dist, ahead, left, robot)
    return np.where(law.admissible(v, omega, dist, robot, dt), worth, np.nan)


def plot_turns(judged, points=None, ax=None):
    """Distances that safety first takes over those of length first, against the share of danger.

    Parameters
    ----------
    judged : sequence of dict
        From `judge_orders`: a line for each number of obstacles.
    points : array_like, shape (k, 2), optional
        Share of danger and ratio of single cases.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instances("judged", judged, Mapping, "what judge_orders returns")
    numbers = ("n", "share", "ratio", "searched")
    if any(not one.keys() >= {*numbers} for one in judged):
        raise InvalidParameter(f"judged is {checks.shown(judged)}; give what judge_orders returns")
    found = [one for one in judged if one["searched"]]
    ax = new_axes(ax, (6.5, 4))
    each = sorted({one["n"] for one in found})
    for place, n in enumerate(each):
        shade = colormaps["cividis_r"](0.1 + 0.85 * place / len(each))
        line = [(one["share"], one["ratio"]) for one in found if one["n"] == n]
        ax.plot(*np.transpose(line), "o-", color=shade, ms=4, lw=1.3, label=f"{n} obstacles")
    if points is not None:
        points = checks.array("points", points, (None, 2), unit="share and ratio")
        style = {"color": PALETTE["tracked"], "ms": 6, "zorder": 5}
        ax.plot(*points.T, "D", label="the paper's cases", **style)
    ax.axhline(1, color="0.3", lw=1)
    ax.xaxis.set_major_formatter(PercentFormatter(1))
    ax.set(xlabel="share of danger segments", ylabel="distances: safety first / length first")
    ax.legend(frameon=False, ncols=2, fontsize=9)
    return ax


def plot_tracks(world, start, goal, tracks, ax=None, colors=None):
    """Tracks of rivals from a start to a goal; a cross where one ends elsewhere.

    Parameters
    ----------
    world : World
        Obstacles.
    start, goal : array_like, shape (2,)
        Positions (m).
    tracks : dict
        Name to a Plan, a Path, a Run of one robot, or points (m), shape (k, 2).
    ax : matplotlib Axes, optional
        Where to draw.
    colors : dict, optional
        Name to colour; the others have the palette's, in turn.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("tracks", tracks, Mapping, "a dict of name to track")
    start, goal = as_position(start, "start"), as_position(goal, "goal")
    colors = check_colors(colors, tracks)
    ax = plot_world(world, ax, numbers=False)
    dashes = cycle(np.repeat(np.arange(len(DASHES)), len(TRACKS)))
    styles = zip(cycle(TRACKS), dashes, strict=False)
    for k, ((name, track), (color, dash)) in enumerate(zip(tracks.items(), styles, strict=False)):
        points = _points_of(name, track)
        color = colors.get(name, PALETTE[color])
        # The first are the widest, and show below those that drive the same way.
        width = THINNEST + WIDER * (len(tracks) - 1 - k)
        ax.plot(*points.T, color=color, ls=DASHES[dash], lw=width, zorder=4, label=name)
        if np.hypot(*(points[-1] - goal)) > ARRIVED:
            ax.plot(*points[-1], "X", color=color, mec="white", ms=10, zorder=5)
    return plot_query(start, goal, ax)


def _points_of(name, track):
    """Points (m) of a track, shape (k, 2)."""
    track = track.path if isinstance(track, Plan) else track
    if isinstance(track, Path):
        return trace(track).T
    track = track.pose[:2].T if isinstance(track, Run) else track
    return checks.array(f"track of {checks.shown(name)}", track, (None, 2))


def plot_chase(world, start, goal, run, t, ax=None):
    """A robot on its way to a goal, at one time, and what it drove until then.

    Parameters
    ----------
    world : World
        Obstacles.
    start, goal : array_like, shape (2,)
        Positions (m).
    run : Run
        What one robot drove.
    t : float
        Time (s); after the end of the run, the robot stands where it ended.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_run(run)
    t = checks.number("t", t)
    now = min(max(int(np.searchsorted(run.t, t, "right")) - 1, 0), len(run.t) - 1)
    ax = plot_query(start, goal, plot_world(world, ax, numbers=False))
    ax.plot(*run.pose[:2, : now + 1], color=PALETTE["tracked"], lw=2, zorder=4)
    draw_robot(run.pose[:, now], run.robot, ax)
    return ax


def plot_duels(names, alone, decided, ax=None):
    """Who solves what another does not: a number for each two, coloured where it is decided.

    Parameters
    ----------
    names : sequence of str
        Of n rivals.
    alone : array_like of int, shape (n, n)
        How many questions the first (row) solves and the second (column) does not.
    decided : ndarray of bool, shape (n, n)
        Whether the difference of two is more than chance; symmetric.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    names = checks.instances("names", names, str, "names of rivals")
    n = len(names)
    alone = checks.array("alone", alone, (n, n), unit="numbers of questions")
    checks.instance("decided", decided, np.ndarray, f"an array of true or false, {n} x {n}")
    if decided.shape != (n, n) or decided.dtype != bool:
        raise InvalidParameter(f"decided is {checks.shown(decided)}; give true or false, {n} x {n}")
    ax = new_axes(ax, (0.55 * n + 2.4, 0.36 * n + 1.6))
    for row, column in np.argwhere(~np.eye(n, dtype=bool)):
        more = alone[row, column] > alone[column, row]
        color = PALETTE["safe" if more else "danger"] if decided[row, column] else "white"
        cell = (column - 0.5, row - 0.5)
        ax.add_patch(Rectangle(cell, 1, 1, fc=color, alpha=0.45, ec="0.8", lw=0.8))
        text = f"{alone[row, column]:.0f}"
        weight = "bold" if more and decided[row, column] else "normal"
        ax.text(column, row, text, ha="center", va="center", fontsize=9, weight=weight)
    ax.set(xlim=(-0.5, n - 0.5), ylim=(n - 0.5, -0.5))
    ax.set_xticks(range(n), names, rotation=30, ha="left")
    ax.set_yticks(range(n), names)
    ax.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    ax.spines[:].set_visible(False)
    return ax
