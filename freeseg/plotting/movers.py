"""Obstacles that move: moments, space and time, and sketches of the three motions of lesson 16."""

import math

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.patches import Arc, Circle
from matplotlib.ticker import MaxNLocator
from scipy.optimize import brentq

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import cross, unit
from freeseg.planners.time_minimal import TimedPlan
from freeseg.plotting.axes import PALETTE, count_in_mm, map_axes, new_axes
from freeseg.plotting.robots import draw_robot
from freeseg.plotting.runs import MOST_FRAMES
from freeseg.plotting.sketches import arrow, sketch_axes, write
from freeseg.plotting.worlds import plot_circle, plot_query, plot_world
from freeseg.world import Disc

#: Sheets of a mover in space and time: so many times, and directions round it.
SHEET_TIMES, SHEET_ANGLES = 30, 40
#: Arrows of velocities lead to where a mover is after this time (s).
ARROW_TIME = 1.5
#: The sketches' disc moves so fast, as a share of the robot's speed.
DISC_SPEED = np.array([0.0, 0.45])
#: Dangerous circle of the sketches.
SKETCH_RIM = {"fill": False, "ls": "--", "lw": 1.3, "ec": PALETTE["turning"], "zorder": 3}
#: A line that helps to see.
THIN = {"color": "0.4", "lw": 1, "ls": ":", "zorder": 2}


def _check_plan(plan):
    """`plan`, or `InvalidParameter`."""
    return checks.instance("plan", plan, TimedPlan, "what time_minimal_plan returned")


def _keep(plan):
    """Distance R_D that the plan keeps (m)."""
    return plan.robot.radius + plan.margin / 2


def plot_moment(plan, t, ax=None):
    """A plan among movers at one time: where all are, and what was driven.

    Arrows show where a mover will be a second and a half later; dashed are
    the circles that the robot's centre keeps out of.

    Parameters
    ----------
    plan : TimedPlan
        What was planned.
    t : float
        Time (s), zero or more; after the arrival the robot stands.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    scene, t = _check_plan(plan).scene, checks.not_negative("t", t)
    ax = plot_world(scene.at(t), ax)
    for mover in scene.movers:
        body = mover.at(t)
        if isinstance(body, Disc):
            plot_circle(body.center, body.radius + _keep(plan), ax, lw=0.9)
            if np.any(mover.velocity):
                ahead = body.center + ARROW_TIME * np.asarray(mover.velocity)
                arrow(ax, body.center, ahead, PALETTE["outline"], lw=1.2)
    path = plan.path
    ax.plot(*path.pose[:2], color=PALETTE["planned"], lw=1, ls=":", zorder=3)
    driven = path.pose[:2, path.t <= t]
    ax.plot(*driven, color=PALETTE["planned"], lw=2.2, zorder=4, label="driven")
    draw_robot(path.at(t)[0], plan.robot, ax)
    return plot_query(path.pose[:2, 0], path.pose[:2, -1], ax)


def animate_plan(plan, limits, ax=None, frames=40):
    """A robot that drives its plan among movers.

    Parameters
    ----------
    plan : TimedPlan
        What was planned.
    limits : array_like, shape (4,)
        Least and largest x, then y, to draw (m).
    ax : matplotlib Axes, optional
        Where to draw.
    frames : int, optional
        Number of pictures, at equal intervals of time.

    Returns
    -------
    matplotlib FuncAnimation
        Keep it, and pass it to `as_gif` to show it.
    """
    _check_plan(plan)
    west, east, south, north = checks.numbers("limits", limits, 4)
    frames = checks.whole("frames", frames, 1)
    if frames > MOST_FRAMES:
        raise InvalidParameter(f"frames is {frames}; give at most {MOST_FRAMES}")
    ax = map_axes(ax)

    def show(t):
        ax.clear()
        plot_moment(plan, t, ax)
        ax.set(xlim=(west, east), ylim=(south, north), title=f"{t:.1f} s")
        return ax.get_children()

    times = np.linspace(0, plan.arrival, frames)
    return FuncAnimation(ax.figure, show, frames=times, interval=100)


def plot_space_time(plan, ax=None):
    """Movers and a path in space and time: time points up, and a faster mover leans more.

    Parameters
    ----------
    plan : TimedPlan
        What was planned.
    ax : matplotlib Axes3D, optional
        Where to draw; a new one by default.

    Returns
    -------
    matplotlib Axes3D
    """
    scene = _check_plan(plan).scene
    if ax is None:
        ax = plt.figure(figsize=(7, 6), layout="constrained").add_subplot(projection="3d")
    if getattr(ax, "name", None) != "3d":
        raise InvalidParameter(
            f'ax is {checks.shown(ax)}; give axes in three dimensions: projection="3d"'
        )
    t, angle = np.linspace(0, plan.arrival, SHEET_TIMES), np.linspace(0, 2 * np.pi, SHEET_ANGLES)
    for mover in scene.movers:
        if isinstance(mover.obstacle, Disc):
            radius = mover.obstacle.radius + _keep(plan) + mover.growth * t
            rim = mover.obstacle.center + mover.shifts(t)
            x, y = rim.T[:, :, None] + radius[:, None] * unit(angle).T[:, None]
            style = {"color": PALETTE["obstacle"], "alpha": 0.45, "lw": 0, "shade": True}
            ax.plot_surface(x, y, np.broadcast_to(t[:, None], x.shape), **style)
    path = plan.path
    style = {"color": PALETTE["planned"], "lw": 2.5, "zorder": 10}
    ax.plot(*path.pose[:2], path.t, **style, label="the robot's centre")
    ends = path.pose[:2, [0, -1]]
    ax.scatter(*ends[:, :1], [0], color="black", marker="s", zorder=11)
    goal = ends[:, 1]
    ax.plot(*np.repeat(goal[:, None], 2, 1), [0, plan.arrival], color="black", lw=1, ls=":")
    ax.scatter(*goal, plan.arrival, color="black", marker="*", s=80, zorder=11)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(5))
        count_in_mm(axis)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="time (s)")
    ax.set_box_aspect((1, 1, 0.9), zoom=0.9)
    return ax


def _disc(ax, center, name="disc $j$"):
    """A disc of the sketches at a time, with the circle round it."""
    ax.add_patch(Circle(center, 0.62, fc=PALETTE["obstacle"], ec=PALETTE["outline"], zorder=1))
    ax.add_patch(Circle(center, 1, **SKETCH_RIM))
    write(ax, name, center, size=10)


def _pace(e):
    """Speed of a robot of speed 1 in the frame of the sketches' disc, in a direction there."""
    along = DISC_SPEED @ e
    return -along + math.sqrt(along**2 + 1 - DISC_SPEED @ DISC_SPEED)


def sketch_graze(ax=None):
    """From a point, the line that grazes a disc that moves.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    ax = sketch_axes(ax, (6.4, 4.2), (-0.5, 4.6), (-1.5, 2.9))
    center = np.array([2.4, 0.0])
    _disc(ax, center)
    tilt = math.asin(1 / math.hypot(*center))
    e = unit(tilt)
    length = math.sqrt(center @ center - 1)
    # The disc's frame: there it stands, and the robot's velocity is that less the disc's.
    pace = _pace(e)
    velocity = DISC_SPEED + pace * e
    drift = length / pace * DISC_SPEED
    ax.add_patch(Circle(center + drift, 1, **SKETCH_RIM | {"alpha": 0.4}))
    ax.plot(*np.transpose([(0, 0), length * e]), **THIN)
    ax.plot(*np.transpose([length * e, center]), **THIN)
    ax.plot(*np.transpose([(0, 0), center]), **THIN)
    ax.plot(*np.transpose([(0, 0), length / pace * velocity]), color=PALETTE["planned"], lw=2.2)
    arrow(ax, (0, 0), pace * e, PALETTE["error"])
    arrow(ax, pace * e, velocity, PALETTE["danger"])
    arrow(ax, (0, 0), velocity, PALETTE["planned"])
    ax.plot(0, 0, "ks", ms=6)
    ax.add_patch(Arc((0, 0), 0.6, 0.6, theta1=0, theta2=math.degrees(tilt), color="0.3"))
    for text, place, color in (
        ("$p$", (-0.2, 0), "black"),
        ("$d$", (1.25, -0.2), "0.3"),
        (r"$\lambda e$", pace * e + (0.05, -0.2), PALETTE["error"]),
        ("$u$", pace * e + (0.16, 0.3), PALETTE["danger"]),
        ("$v$", 0.6 * velocity + (-0.2, 0.16), PALETTE["planned"]),
        ("$R_j$", (length * e + center) / 2 + (0.2, 0.05), "0.3"),
        (r"$\beta$", (0.42, 0.09), "0.3"),
        ("where it is when\nthey touch", center + drift + (0.3, 0.3), "0.3"),
    ):
        write(ax, text, place, color, 12 if len(text) < 15 else 9)
    return ax


def sketch_slide(ax=None):
    """Sliding on a disc that moves: the robot's velocity, and the part of it along the rim.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    ax = sketch_axes(ax, (5.6, 4.2), (-1.5, 2.9), (-1.3, 2.2))
    _disc(ax, np.zeros(2))
    angle = math.radians(35)
    place, along = unit(angle), unit(angle - math.pi / 2)
    pace = _pace(along)
    ax.plot(*np.transpose([(0, 0), place]), **THIN)
    arrow(ax, place, place + DISC_SPEED, PALETTE["danger"])
    arrow(ax, place + DISC_SPEED, place + DISC_SPEED + pace * along, PALETTE["error"])
    arrow(ax, place, place + DISC_SPEED + pace * along, PALETTE["planned"])
    arrow(ax, np.zeros(2), DISC_SPEED, PALETTE["danger"])
    ax.plot(*place, "o", color=PALETTE["planned"], ms=8, zorder=6)
    ax.add_patch(Arc((0, 0), 0.9, 0.9, theta1=0, theta2=35, color="0.3"))
    ax.plot([0, 0.8], [0, 0], **THIN)
    for text, spot, color in (
        ("$u$", place + DISC_SPEED / 2 - (0.14, 0), PALETTE["danger"]),
        ("$u$", DISC_SPEED / 2 - (0.14, 0), PALETTE["danger"]),
        ("$w\\,e$", place + DISC_SPEED + pace * along / 2 + (0.28, 0.1), PALETTE["error"]),
        ("$v$", place + (DISC_SPEED + pace * along) / 2 + (0.05, -0.2), PALETTE["planned"]),
        ("$R_j$", place / 2 + (-0.05, 0.15), "0.3"),
        (r"$\theta$", (0.57, 0.15), "0.3"),
    ):
        write(ax, text, spot, color)
    return ax


def sketch_leave(ax=None):
    """Leaving a disc: on from the place of its rim where going straight on meets the goal.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    ax = sketch_axes(ax, (6.4, 3.9), (-1.5, 4.4), (-1.35, 2.1))
    _disc(ax, np.zeros(2), "disc $j$")
    goal = np.array([3.9, 0.15])

    def leaving(angle):
        normal, along = unit(angle), unit(angle - math.pi / 2)
        return normal, DISC_SPEED + _pace(along) * along

    def aside(angle):
        place, velocity = leaving(angle)
        return cross(velocity, goal - place)

    for angle in np.radians(np.linspace(130, 30, 6)):
        place, velocity = leaving(angle)
        arrow(ax, place, place + 0.75 * velocity, "0.55", lw=1.1)
    place, velocity = leaving(brentq(aside, math.radians(30), math.radians(130)))
    ax.plot(*np.transpose([place, goal]), color=PALETTE["planned"], lw=2.2, zorder=4)
    arrow(ax, place, place + 0.75 * velocity, PALETTE["planned"])
    ax.plot(*place, "o", color=PALETTE["planned"], ms=8, zorder=6)
    ax.plot(*goal, "k*", ms=12)
    for text, spot, color in (
        ("$p$", np.add(place, (-0.1, -0.18)), PALETTE["planned"]),
        ("$v$", np.add(place, 0.45 * velocity + (0.02, 0.17)), PALETTE["planned"]),
        ("goal $g$", np.add(goal, (0, -0.3)), "black"),
        ("too early", (-0.75, 1.75), "0.35"),
        ("too late", (1.6, -0.2), "0.35"),
    ):
        write(ax, text, spot, color, 10)
    return ax


def plot_opening(t, lengths, required, ax=None):
    """Length of a free segment over time: when it is safe, and when it turns to danger.

    Parameters
    ----------
    t : array_like, shape (k,)
        Times (s), in order.
    lengths : array_like, shape (k,)
        Length SP at each (m).
    required : float
        Length D_r + delta that makes it safe (m).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    t = checks.times("t", t)
    lengths = checks.array("lengths", lengths, (t.size,), unit="m")
    required = checks.positive("required", required)
    ax = new_axes(ax, (6.4, 3))
    top = 1.1 * max(lengths.max(), required)
    ax.axhspan(required, top, color=PALETTE["safe"], alpha=0.15, lw=0)
    ax.axhspan(0, required, color=PALETTE["danger"], alpha=0.15, lw=0)
    ax.plot(t, lengths, color="black", lw=2)
    ax.axhline(required, color="black", lw=1, ls="--")
    style = {"ha": "left", "fontsize": 10, "transform": ax.get_yaxis_transform()}
    ax.text(0.01, required + 0.02 * top, "safe", color=PALETTE["safe"], va="bottom", **style)
    ax.text(0.01, required - 0.02 * top, "danger", color=PALETTE["danger"], va="top", **style)
    safe = lengths >= required
    for k in np.flatnonzero(safe[1:] != safe[:-1]):
        share = (required - lengths[k]) / (lengths[k + 1] - lengths[k])
        when = t[k] + share * (t[k + 1] - t[k])
        ax.plot(when, required, "o", color=PALETTE["turning"], mec="black", ms=8, zorder=5)
        turn = "danger" if safe[k] else "safe"
        # Below the line, on the side where the curve is above it.
        style = {"textcoords": "offset points", "fontsize": 9, "ha": "right" if safe[k] else "left"}
        shift = (-7 if safe[k] else 7, -14)
        ax.annotate(f"{turn} from {when:.2f} s on", (when, required), shift, **style)
    ax.set(xlabel="time (s)", ylabel="length $SP$ (mm)", ylim=(0, top), xlim=t[[0, -1]])
    count_in_mm(ax.yaxis)
    return ax
