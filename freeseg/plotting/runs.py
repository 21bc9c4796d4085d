"""Runs: what a robot drove, with its errors and wheel speeds, and driving."""

import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.patheffects import withStroke

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plan import check_plan
from freeseg.plotting.axes import (
    PALETTE,
    check_axes,
    count_in_degrees,
    count_in_mm,
    new_axes,
    several_axes,
)
from freeseg.plotting.plans import plot_plan
from freeseg.plotting.robots import draw_robot, move_robot
from freeseg.plotting.worlds import plot_path, plot_query, plot_world
from freeseg.robot import contrast
from freeseg.simulate import Run
from freeseg.world import check_world

#: More pictures would fill the memory before anybody saw the last one.
MOST_FRAMES = 10_000
#: Widths of the lines (points): blue is seen on either side of the tracked path's casing.
PLANNED_WIDTH, TRACKED_WIDTH = 6.5, 1.9


def check_run(run, plan=None):
    """A run of one robot, and of the one planned for; or `InvalidParameter`."""
    checks.instance("run", run, Run, "what simulate returned")
    if run.pose.ndim > 2:
        raise InvalidParameter(f"run is a {run!r}; draw one robot: simulate it alone")
    if plan is not None and plan.robot != run.robot:
        driven, planned = contrast(run.robot, plan.robot)
        raise InvalidParameter(
            f"run is of {driven}, the plan for {planned}; give those of one robot"
        )
    return run


def check_tracked(run):
    """A run of one robot that followed a reference; or `InvalidParameter`."""
    if check_run(run).reference is None:
        raise InvalidParameter(f"run is a {run!r} without a reference; simulate one with it")
    return run


def draw_tracked(x, y, ax):
    """A tracked path, cased in white, so that it stands out from the planned one below it."""
    casing = withStroke(linewidth=2 * TRACKED_WIDTH, foreground="white")
    style = {"color": PALETTE["tracked"], "lw": TRACKED_WIDTH, "zorder": 5}
    (line,) = ax.plot(x, y, path_effects=[casing], label="tracked", **style)
    return line


def plot_run(run, ax, robots=6):
    """What a robot drove, and the robot on its way.

    Parameters
    ----------
    run : Run
        What one robot drove.
    ax : matplotlib Axes
        Where to draw.
    robots : int, optional
        How often to draw the robot, at equal intervals of time.

    Returns
    -------
    matplotlib Axes
    """
    check_run(run)
    robots, ax = frames_of(run, "robots", robots), check_axes(ax)
    for when in robots:
        draw_robot(run.pose[:, when], run.robot, ax)
    draw_tracked(*run.pose[:2], ax)
    return ax


def plot_tracking(world, plan, run, ax=None):
    """A tracked path over the planned one (Fig. 17).

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What was planned.
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_run(run, check_plan(plan, check_world(world)))
    ax = plot_world(world, ax)
    plot_path(plan.path, ax, label="planned path", lw=PLANNED_WIDTH)
    plot_run(run, ax)
    return plot_query(plan.path.start, plan.path.end, ax)


def plot_errors(run, axes=None):
    """Tracking errors over time (Fig. 18).

    Parameters
    ----------
    run : Run
        What one robot drove.
    axes : sequence of 3 matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    array of 3 matplotlib Axes
    """
    check_tracked(run)
    x_axes, y_axes, heading_axes = three = several_axes(axes, 3, 1, (6.4, 5))
    labels = "$x_e$ (mm)", "$y_e$ (mm)", r"$\alpha_e$ (°)"
    for ax, error, label in zip(three, run.error, labels, strict=True):
        ax.axhline(0, color="0.5", lw=0.8)
        ax.plot(run.t, error, color=PALETTE["error"], lw=1.6)
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
        ax.spines[["top", "right"]].set_visible(False)
    count_in_mm(x_axes.yaxis, y_axes.yaxis)
    count_in_degrees(heading_axes.yaxis)
    heading_axes.set_xlabel("time (s)")
    heading_axes.figure.align_ylabels(three)
    return np.array(three) if axes is None else axes


def plot_wheels(run, ax=None):
    """Wheel speeds over time (Fig. 19).

    Parameters
    ----------
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_run(run)
    ax = new_axes(ax, (6, 3))
    for speed, side, symbol in zip(run.wheels, ("right", "left"), ("$V_R$", "$V_L$"), strict=True):
        # A speed is held until the next time: stairs, not slopes.
        ax.step(
            run.t,
            speed,
            where="post",
            color=PALETTE[side],
            lw=1.3,
            label=f"{symbol} ({side})",
        )
    ax.set_xlabel("time (s)")
    ax.set_ylabel("wheel speed (mm/s)")
    count_in_mm(ax.yaxis)
    ax.grid(alpha=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    # Room for the legend above all data.
    low, high = ax.dataLim.intervaly
    room = 0.05 * (high - low) or 0.01  # a robot may stand still
    ax.set_ylim(low - room, high + 6 * room)
    ax.legend(loc="upper right", ncols=2, frameon=False)
    return ax


def animate(world, plan, run, ax=None, frames=40):
    """The robot driving along its plan, beside a gauge of its wheel speeds.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What was planned.
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw; the gauge stands to the right of it, and the layout of
        the figure is fixed. By default a new figure, 600 px wide at 100 dots
        per inch.
    frames : int, optional
        Number of pictures, at equal intervals of time.

    Returns
    -------
    matplotlib FuncAnimation
        Keep it, and pass it to `as_gif` to show it.
    """
    check_run(run, check_plan(plan, check_world(world)))
    times = frames_of(run, "frames", frames, 1)
    ax = plot_plan(world, plan, new_axes(ax, (6, 4.6)))
    # Wider than in a still picture: the tracked path comes to lie on it.
    plot_path(plan.path, ax, lw=PLANNED_WIDTH)
    x, y, _ = run.pose
    trail = draw_tracked([], [], ax)
    place = draw_robot(run.pose[:, 0], run.robot, ax)
    set_gauge = draw_gauge(run, ax)
    # Only the second layout knows where the first one has put the gauge.
    for _ in range(2):
        ax.figure.draw_without_rendering()
    # Else every picture would be laid out anew, and the map would tremble.
    ax.figure.set_layout_engine("none")

    def show(when):
        trail.set_data(x[: when + 1], y[: when + 1])
        move_robot(place, run.pose[:, when])
        return [trail, *set_gauge(when)]

    return FuncAnimation(ax.figure, show, frames=times, interval=100)


def draw_gauge(run, ax):
    """Bars of both wheel speeds to the right of `ax`; returns what sets them to a time step."""
    gauge = ax.inset_axes([1.06, 0.14, 0.22, 0.7])
    sides = "left", "right"
    speeds = run.wheels[::-1]
    bars = gauge.bar((0, 1), (0, 0), color=[PALETTE[side] for side in sides], tick_label=sides)
    low, high = min(0, speeds.min()), max(0, speeds.max())
    gauge.set_ylim(low, high + 0.02 * (high - low) + 1e-3)
    gauge.axhline(0, color="0.3", lw=0.8)
    gauge.yaxis.tick_right()
    gauge.yaxis.set_label_position("right")
    gauge.set_ylabel("wheel speed (mm/s)")
    count_in_mm(gauge.yaxis)
    style = {"transform": gauge.get_xaxis_transform(), "ha": "center"}
    numbers = [
        gauge.text(place, 1.02, "", color=PALETTE[side], **style)
        for place, side in enumerate(sides)
    ]
    clock = gauge.text(0.5, 1.13, "", **style | {"transform": gauge.transAxes})

    def set_gauge(when):
        for bar, number, speed in zip(bars, numbers, speeds[:, when], strict=True):
            bar.set_height(speed)
            number.set_text(f"{1000 * speed:.0f}")
        clock.set_text(f"{run.t[when]:.1f} s")
        return [*bars, *numbers, clock]

    set_gauge(0)
    return set_gauge


def frames_of(run, name, count, least=0):
    """Indices of so many of a run's times, equally far apart; or `InvalidParameter`."""
    count = checks.whole(name, count, least)
    if count > MOST_FRAMES:
        raise InvalidParameter(f"{name} is {checks.shown(count)}; give at most {MOST_FRAMES}")
    return np.linspace(0, len(run.t) - 1, count).astype(int)
