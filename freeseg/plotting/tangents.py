"""Free segments, detours, tangents and dangerous circles: sketches of lessons 02 and 03."""

import numpy as np
import shapely
from matplotlib.patches import Arc, Circle, Ellipse

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import unit
from freeseg.plan import turning_radius
from freeseg.plotting.axes import PALETTE, check_color, map_axes
from freeseg.plotting.robots import draw_robot
from freeseg.plotting.sketches import arrow, measure, sketch_axes, write
from freeseg.plotting.worlds import HALO
from freeseg.robot import as_robot
from freeseg.segments import MARGIN
from freeseg.world import as_position

#: Looks of an obstacle, as `plot_world` draws it.
GREY = {"fc": PALETTE["obstacle"], "ec": PALETTE["outline"], "zorder": 2}
#: A line that helps to see, and stands for nothing.
GUIDE = {"color": "0.4", "lw": 1, "ls": ":", "zorder": 3}


def sketch_segment(length, robot=None, margin=MARGIN, ax=None):
    """Two obstacles, the free segment between them, and what has to fit through.

    Parameters
    ----------
    length : float
        Length SP of the segment (m).
    robot : Robot, optional
        What is to pass; by default a Khepera IV.
    margin : float, optional
        Security margin delta (m).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
        Its title says whether the segment is safe.
    """
    robot, length = as_robot(robot), checks.positive("length", length)
    required = robot.diameter + checks.not_negative("margin", margin)
    unit_length, half = robot.radius, length / 2
    ahead, up = unit_length * np.eye(2)
    reach = max(half, required / 2) + 2.3 * unit_length
    ax = sketch_axes(ax, (5, 3.6), (-reach, reach), (-2.35 * unit_length, 2.8 * unit_length))
    kind, sign = ("safe", r"\geq ") if length >= required else ("danger", "<")
    for side, radius, names in ((-1, 0.8, ("1", "2")), (1, 0.6, ("2", "3"))):
        end = np.array([side * half, 0.0])
        center = end + side * radius * ahead
        ax.add_patch(Circle(center, radius * unit_length, **GREY))
        ax.plot(*np.transpose([end, center]), **GUIDE)
        write(ax, f"obstacle {names[0]}", center + 0.2 * side * ahead - 1.2 * up, size=10)
        write(ax, f"$p_{names[1]}$", end + 0.45 * side * ahead + 0.3 * up)
        ax.plot(*end, "o", color=PALETTE[kind], ms=6, zorder=6)
        ax.plot((end[0], end[0]), (0, -1.75 * unit_length), **GUIDE)
    draw_robot((0, 0, np.pi / 2), robot, ax)
    outline = {"fill": False, "ls": "--", "lw": 1.3, "ec": PALETTE["outline"], "zorder": 5}
    ax.add_patch(Circle((0, 0), required / 2, **outline))
    dashes = "-" if kind == "safe" else (0, (3, 2))
    ax.plot((-half, half), (0, 0), color=PALETTE[kind], ls=dashes, lw=2.5, zorder=5)
    for width, height, name in (
        (length, -1.75, "$SP_1$"),
        (robot.diameter, 1.45, "$D_r$"),
        (required, 2.1, r"$D_r+\delta$"),
    ):
        y = height * unit_length
        above = (0, np.sign(height) * 0.3 * unit_length)
        measure(ax, (-width / 2, y), (width / 2, y), name, above)
        if height > 0:
            for x in (-width / 2, width / 2):
                ax.plot((x, x), (0, y), **GUIDE)
    ax.set_title(rf"{kind}: $SP_1{sign}D_r+\delta$", color=PALETTE[kind])
    return ax


def plot_detours(start, goal, lengths, ax=None, color=PALETTE["turning"]):
    """Where the detour over a point has given lengths: ellipses round start and goal.

    Each has its length written on it (mm), at the end of its shorter axis.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        Positions (m).
    lengths : array_like, shape (k,)
        Detours SD (m), longer than the straight line from start to goal.
    ax : matplotlib Axes, optional
        Where to draw.
    color : color, optional
        Their colour.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidParameter
        For a length that no detour has.

    Notes
    -----
    |start p| + |p goal| = SD holds on an ellipse whose foci are the start and the
    goal: its axes are SD and the square root of SD^2 - |start goal|^2.
    """
    start, goal = as_position(start, "start"), as_position(goal, "goal")
    lengths = checks.array("lengths", lengths, (None,), unit="m")
    apart = np.hypot(*(goal - start))
    if (lengths <= apart).any():
        raise InvalidParameter(
            f"lengths has {lengths.min():g} m; start and goal are {apart:g} m apart, and every "
            "detour is longer"
        )
    color, ax = check_color(color), map_axes(ax)
    middle, slope = (start + goal) / 2, np.arctan2(*(goal - start)[::-1])
    for length in lengths:
        width = np.sqrt(length**2 - apart**2)
        shape = {"fill": False, "ec": color, "lw": 1.3, "zorder": 3}
        ax.add_patch(Ellipse(middle, length, width, angle=np.degrees(slope), **shape))
        # To the right of the way, where both pictures of lesson 03 have room.
        place = middle + width / 2 * unit(slope - np.pi / 2)
        write(ax, f"{1000 * length:.0f}", place, color, 8, path_effects=HALO)
    return ax


def sketch_tangent(ax=None):
    """Both tangents from a point to a dangerous circle, and the triangle that gives them.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    radius, distance = 1.0, 3.2
    length, angle = np.sqrt(distance**2 - radius**2), np.arcsin(radius / distance)
    ax = sketch_axes(ax, (5.6, 3.4), (-0.55, 4.6), (-1.6, 1.6))
    center = np.array([distance, 0])
    circle = {"fill": False, "ec": PALETTE["turning"], "ls": "--", "lw": 1.5}
    ax.add_patch(Circle(center, radius, **circle))
    for sense, color, dashes in ((1, PALETTE["planned"], "-"), (-1, "0.45", (0, (5, 2)))):
        along = unit(-sense * angle)
        join = length * along
        ax.plot(*np.transpose([(0, 0), join]), color=color, ls=dashes, lw=2.2, zorder=4)
        # A little further round the circle, to show which way the robot goes on.
        turned = -sense * (np.pi / 2 + angle) + sense * np.linspace(0, 0.8, 30)
        onwards = center + radius * unit(turned)
        ax.plot(*onwards.T, color=color, lw=2.2, zorder=4)
        arrow(ax, onwards[-2], onwards[-1], color, mutation_scale=16)
        side = "left" if sense > 0 else "right"
        words = f"sense ${sense:+d}$:\ncentre on the {side}"
        write(ax, words, join - np.array([0.4, 0.5 * sense]), color, 10)
        ax.plot(*join, "o", color=color, ms=6, zorder=6)
    along, join = unit(-angle), length * unit(-angle)
    ax.plot(*np.transpose([(0, 0), center]), **GUIDE)
    ax.plot(*np.transpose([center, join]), color="black", lw=1.2)
    # The tangent stands at right angles to the radius.
    inward = (center - join) / radius
    corner = join + 0.16 * np.array([-along, inward - along, inward])
    ax.plot(*corner.T, color="black", lw=1)
    ax.add_patch(Arc((0, 0), 2, 2, theta1=-np.degrees(angle), theta2=0, lw=1.2))
    write(ax, r"$\beta$", 1.15 * unit(-angle / 2))
    write(ax, "$D$", (0.5 * distance, 0.14))
    write(ax, "$R$", (center + join) / 2 + (0.17, 0.0))
    below = 0.47 * join + 0.22 * unit(-angle - np.pi / 2)
    slope = np.degrees(-angle)
    write(ax, r"$\sqrt{D^2-R^2}$", below, PALETTE["planned"], rotation=slope)
    ax.plot(0, 0, "ks", ms=6)
    write(ax, "start", (-0.3, 0), size=10)
    ax.plot(*center, "+", color="black", ms=9)
    write(ax, "centre", center + np.array([0.4, 0]), size=10)
    return ax


def sketch_literal_circle(angle, obstacle_radius, robot=None, margin=MARGIN, ax=None):
    """A turn on a circle that is centred on a disc's boundary, and where it comes too close.

    The path turns by twice the angle, and the robot is drawn where the line on
    which it leaves comes nearest to the obstacle. What they share is filled.

    Parameters
    ----------
    angle : float
        Angle phi (rad) between the outward normal at the turning point and where
        the robot leaves the circle; from 0 to pi / 2.
    obstacle_radius : float
        Radius r of the disc (m).
    robot : Robot, optional
        By default a Khepera IV.
    margin : float, optional
        Security margin delta (m); the circle's radius is R_D = R_r + delta / 2.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot, phi = as_robot(robot), checks.not_negative("angle", angle)
    r = checks.positive("obstacle_radius", obstacle_radius)
    if phi > np.pi / 2:
        raise InvalidParameter(f"angle is {phi:g} rad; give one from 0 to pi / 2")
    turn = turning_radius(robot, checks.not_negative("margin", margin))
    top, away = np.array([0, r]), unit(np.pi / 2 - phi)
    leave, foot = top + turn * away, r * np.cos(phi) * away
    nearest = foot + turn * away
    below = -max(r, turn - r) - 0.15 * turn
    # The same for all angles, so that pages of a flipbook fit.
    limits = (-1.3 * turn, r + 1.65 * turn), (below, r + 2.05 * turn)
    ax = sketch_axes(ax, (4.8, 4.5), *limits)
    ax.add_patch(Circle((0, 0), r, **GREY))
    circle = {"fill": False, "ec": PALETTE["turning"], "ls": "--", "lw": 1.3, "zorder": 3}
    ax.add_patch(Circle(top, turn, **circle))
    arc = top + turn * unit(np.pi / 2 + np.linspace(phi, -phi, 60))
    along = np.array([away[1], -away[0]])
    far = 3 * turn * along
    path = np.concatenate([[arc[0] + far * (-1, 1)], arc, [arc[-1] + far]])
    ax.plot(*path.T, color=PALETTE["planned"], lw=2.2, zorder=4)
    body = {"fc": PALETTE["robot"], "ec": PALETTE["outline"], "alpha": 0.45, "zorder": 3}
    ax.add_patch(Circle(nearest, robot.radius, **body))
    discs = shapely.buffer(shapely.points([nearest, (0, 0)]), (robot.radius, r), quad_segs=90)
    shared = shapely.intersection(*discs)
    if not shared.is_empty:
        ax.fill(*shared.exterior.xy, color=PALETTE["danger"], lw=0, zorder=3.5)
    _name_parts(ax, top, leave, foot, nearest, phi)
    return ax


def _name_parts(ax, top, leave, foot, nearest, phi):
    """Names of lengths and angles in the sketch of a literal circle."""
    r, turn = top[1], np.hypot(*(leave - top))
    away, side = unit(np.pi / 2 - phi), unit(-phi)
    for first, last in ((top, np.array([0, r + 0.95 * turn])), ((0, 0), nearest), (top, foot)):
        ax.plot(*np.transpose([first, last]), **GUIDE)
    for first, last, name, shift in (
        ((0, 0), top, "$r$", (-0.13 * turn, 0)),
        # Its name stands far out, beyond that of the angle.
        (top, leave, "$R_D$", turn * (0.25 * away - 0.16 * side)),
        (r * away, nearest, "$d$", 0.13 * turn * side),
    ):
        arrow(ax, first, last, "black", "<->", lw=1)
        write(ax, name, np.mean([first, last], 0) + shift)
    size = 1.1 * turn
    ax.add_patch(Arc(top, size, size, theta1=90 - np.degrees(phi), theta2=90, lw=1.2, zorder=5))
    if phi > 0.2:
        write(ax, r"$\varphi$", top + 0.42 * turn * unit(np.pi / 2 - phi / 2))
    ax.plot(*top, "o", color=PALETTE["turning"], mec="black", ms=8, zorder=6)
    write(ax, "$P_{tp}$", top + np.array([-0.3, 0.12]) * turn)
    ax.plot(*nearest, "ko", ms=4, zorder=6)
