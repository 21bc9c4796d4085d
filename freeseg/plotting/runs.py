"""Runs: what a robot drove, with its errors and wheel speeds, and driving."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plan import check_plan
from freeseg.plotting.axes import PALETTE, check_axes, count_in_degrees, count_in_mm, new_axes
from freeseg.plotting.plans import plot_plan
from freeseg.plotting.worlds import plot_path, plot_query, plot_world
from freeseg.robot import as_robot, contrast
from freeseg.simulate import Run
from freeseg.world import check_world

#: More pictures would fill the memory before anybody saw the last one.
MOST_FRAMES = 10_000


def check_pose(pose):
    """`pose` as x, y (m) and heading (rad), or `InvalidParameter`."""
    return checks.array("pose", pose, (3,), unit="x, y in m and heading in rad")


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
    plot_path(plan.path, ax, label="planned path", lw=3.5)
    x, y, theta = run.pose
    ax.plot(x, y, color=PALETTE["tracked"], lw=1.3, zorder=5, label="tracked")
    for when in np.linspace(0, len(x) - 1, 6).astype(int):
        draw_robot((x[when], y[when], theta[when]), run.robot, ax)
    return plot_query(plan.path.start, plan.path.end, ax)


def draw_robot(pose, robot, ax):
    """The robot's disc with its heading.

    Parameters
    ----------
    pose : array_like, shape (3,)
        x, y (m) and heading (rad).
    robot : Robot
        Its size.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    disc : matplotlib Circle
    nose : matplotlib Line2D
        The artists, for an animation to move.
    """
    (x, y, _), robot, ax = check_pose(pose), as_robot(robot), check_axes(ax)
    disc = Circle((x, y), robot.radius, fc=PALETTE["robot"], alpha=0.35)
    disc.set(edgecolor=PALETTE["planned"], zorder=4)
    ax.add_patch(disc)
    (nose,) = ax.plot([], [], color=PALETTE["error"], lw=1.2, zorder=4)
    move_robot(disc, nose, pose)
    return disc, nose


def move_robot(disc, nose, pose):
    """Move the artists of `draw_robot` to another pose (m, rad)."""
    checks.instance("disc", disc, Circle, "the circle that draw_robot returned")
    checks.instance("nose", nose, Line2D, "the line that draw_robot returned")
    x, y, theta = check_pose(pose)
    disc.center = x, y
    radius = disc.radius
    nose.set_data([x, x + radius * np.cos(theta)], [y, y + radius * np.sin(theta)])


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
    if check_run(run).error is None:
        raise InvalidParameter(f"run is a {run!r} without a reference; simulate one with it")
    if axes is None:
        _, axes = plt.subplots(3, 1, figsize=(6, 5), sharex=True, layout="constrained")
    x_axes, y_axes, heading_axes = _three_axes(axes)
    labels = "$x_e$ (mm)", "$y_e$ (mm)", r"$\alpha_e$ (°)"
    for ax, error, label in zip((x_axes, y_axes, heading_axes), run.error, labels, strict=True):
        ax.axhline(0, color="0.8", lw=0.8)
        ax.plot(run.t, error, color=PALETTE["error"], lw=1.3)
        ax.set_ylabel(label)
    count_in_mm(x_axes.yaxis, y_axes.yaxis)
    count_in_degrees(heading_axes.yaxis)
    heading_axes.set_xlabel("time (s)")
    return axes


def _three_axes(axes):
    """`axes` as a tuple of three, or `InvalidParameter`."""
    remedy = "three Axes, such as those of fig, axes = plt.subplots(3)"
    found = checks.instances("axes", axes, Axes, remedy)
    if len(found) != 3:
        raise InvalidParameter(f"axes is {len(found)} Axes; give {remedy}")
    return tuple(map(check_axes, found))


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
    ax.legend(frameon=False)
    return ax


def animate(world, plan, run, ax=None, frames=40):
    """The robot driving along its plan.

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
    frames : int, optional
        Number of pictures.

    Returns
    -------
    matplotlib FuncAnimation
        Keep it, and pass it to `as_gif` to show it.
    """
    check_run(run, check_plan(plan, check_world(world)))
    frames = checks.whole("frames", frames, 1)
    if frames > MOST_FRAMES:
        raise InvalidParameter(f"frames is {checks.shown(frames)}; give at most {MOST_FRAMES}")
    ax = plot_plan(world, plan, ax)
    x, y, _ = run.pose
    (trail,) = ax.plot([], [], color=PALETTE["tracked"], lw=1.3, zorder=5, label="tracked")
    disc, nose = draw_robot(run.pose[:, 0], run.robot, ax)
    disc.set_alpha(0.8)

    def show(when):
        trail.set_data(x[: when + 1], y[: when + 1])
        move_robot(disc, nose, run.pose[:, when])
        return trail, disc, nose

    times = np.linspace(0, len(x) - 1, frames).astype(int)
    return FuncAnimation(ax.figure, show, frames=times, interval=100, blit=True)
