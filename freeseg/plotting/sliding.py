"""The sliding-mode law: its error frame, its surface, where it is singular, and its proof."""

import numpy as np
from matplotlib.patches import Arc

from freeseg import checks
from freeseg.plotting.axes import PALETTE, count_in_mm, new_axes
from freeseg.plotting.robots import check_pose, draw_robot
from freeseg.plotting.sketches import arrow, measure, sketch_axes, write
from freeseg.plotting.worlds import HALO
from freeseg.reference import tracking_error
from freeseg.robot import as_robot


def _direction(angle):
    """Unit vectors along an angle (rad) and to its left."""
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, np.array([-along[1], along[0]])


def _angle(ax, corner, radius, first, last, name, color="black"):
    """An angle at a corner (m), from one direction to another (rad), and its name."""
    degrees = np.degrees(sorted([first, last]))
    ax.add_patch(
        Arc(corner, 2 * radius, 2 * radius, theta1=degrees[0], theta2=degrees[1], ec=color)
    )
    middle, _ = _direction((first + last) / 2)
    write(ax, name, np.add(corner, 1.28 * radius * middle), color)


def sketch_error(pose, wanted, robot=None, ax=None):
    """Sketch of the tracking error (7): the reference's pose as the robot sees it (Fig. 11).

    Parameters
    ----------
    pose, wanted : array_like, shape (3,)
        Where the robot is and where it should be: x, y (m), heading (rad).
    robot : Robot, optional
        The robot to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    pose, wanted, robot = check_pose(pose), check_pose(wanted), as_robot(robot)
    x_e, _, alpha_e = tracking_error(wanted, pose)
    ahead, left = _direction(pose[2])
    place, target = pose[:2], wanted[:2]
    foot = place + x_e * ahead
    reach = 1.4 * robot.radius
    spread = np.array([place, target, foot])
    low, high = spread.min(0) - 1.6 * reach, spread.max(0) + 1.6 * reach
    ax = sketch_axes(ax, (6.2, 4.4), (low[0], high[0]), (low[1], high[1]))
    for at, color in ((pose, "tracked"), (wanted, "planned")):
        draw_robot(at, robot, ax)
        arrow(ax, at[:2], at[:2] + reach * _direction(at[2])[0], PALETTE[color], lw=2.5)
        ax.plot(*at[:2], "o", color=PALETTE[color], zorder=6)
    write(ax, "$p$: is", place + reach * left, PALETTE["tracked"])
    _, side = _direction(wanted[2])
    write(ax, "$p_r$: should be", target + reach * side, PALETTE["planned"], ha="right")
    ax.plot(*np.transpose([place, foot, target]), ls=":", color="black", lw=1)
    measure(ax, place, foot, "$x_e$", -0.25 * reach * left)
    measure(ax, foot, target, "$y_e$", reach * (0.22 * ahead - 0.35 * left))
    ax.plot(*np.transpose([target, target + reach * ahead]), ls=":", color="black", lw=1)
    _angle(ax, target, 0.8 * reach, pose[2], pose[2] + alpha_e, r"$\alpha_e$")
    return ax


def sketch_surface(robot=None, ax=None):
    """Sketch of a robot on the surface s = 0 beside a straight path, at top speed.

    Parameters
    ----------
    robot : Robot, optional
        The robot to draw; l and y_e are 2.6 and 1.9 times its radius.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    unit = robot.radius
    length, lateral = 2.6 * unit, 1.9 * unit
    gamma = np.arctan(lateral / length)
    ahead, left = _direction(gamma)
    place = np.array([0.0, -lateral * np.cos(gamma)])
    meets, target = place + length * ahead, place + lateral * left
    ax = sketch_axes(ax, (6.4, 3.4), (-2.6 * unit, 4.6 * unit), (-2.7 * unit, 0.9 * unit))
    ax.axhline(0, color=PALETTE["planned"], lw=2)
    write(ax, "path", (4.2 * unit, 0.3 * unit), PALETTE["planned"])
    draw_robot([*place, gamma], robot, ax)
    ax.plot(*np.transpose([place, meets]), color=PALETTE["turning"], lw=2.5)
    ax.plot(*np.transpose([place, target]), color="black", lw=1, ls="--")
    write(ax, r"$\ell$", (place + meets) / 2 + unit * (0.55 * ahead - 0.35 * left), size=14)
    write(ax, "$y_e$", (place + target) / 2 + unit * (0.45 * left - 0.3 * ahead), size=13)
    ax.plot(*place, "o", color=PALETTE["tracked"], zorder=6)
    ax.plot(*target, "o", color=PALETTE["planned"], zorder=6)
    write(ax, "reference", target + unit * np.array([0, 0.35]), PALETTE["planned"])
    ax.plot(*meets, "o", color=PALETTE["turning"], mec="black", zorder=6)
    _angle(ax, meets, 0.9 * unit, np.pi, np.pi + gamma, r"$\gamma$")
    return ax


def plot_denominator(length_scale, floor, ax=None):
    """Where the law divides by zero: the denominator of w over the error, at top speed.

    Parameters
    ----------
    length_scale : float
        Length l of the law (m).
    floor : float
        Value below which the law divides by this one instead.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    length_scale, floor = (
        _length(length_scale),
        checks.positive("floor", floor),
    )
    ax = new_axes(ax, (6.6, 4.6))
    x_e, y_e = np.meshgrid(
        np.linspace(-4, 2, 301) * length_scale, np.linspace(-3, 3, 301) * length_scale
    )
    value = 1 + x_e * length_scale / (length_scale**2 + y_e**2)
    style = {"levels": np.arange(-1.5, 2.51, 0.25), "cmap": "cividis", "extend": "both"}
    filled = ax.contourf(x_e, y_e, value, **style)
    ax.figure.colorbar(filled, ax=ax, label=r"denominator $1+x_e\,\partial\gamma/\partial y_e$")
    for level, color, name in (
        (0, "white", "singular: 0"),
        (floor, PALETTE["turning"], f"floor: {floor:g}"),
    ):
        ax.contour(x_e, y_e, value, [level], colors=[color], linewidths=2.2)
        ax.plot([], [], color=color, lw=2.2, label=name)
    ax.plot(0, 0, "o", color="black", label="no error: 1")
    ax.set(xlabel="$x_e$ (mm)", ylabel="$y_e$ (mm)", aspect="equal")
    ax.set_title(rf"$\ell={1000 * length_scale:.0f}$ mm, at top speed")
    count_in_mm(ax.xaxis, ax.yaxis)
    ax.legend(loc="upper right", facecolor="0.6", framealpha=1)
    return ax


def plot_lyapunov_rate(length_scale, speed, turn_rate, ax=None):
    """Where half the square of y_e grows although s2 = 0, on an arc at top speed.

    Parameters
    ----------
    length_scale : float
        Length l of the law (m).
    speed : float
        Speed of the reference (m/s).
    turn_rate : float
        Turn rate of the reference (rad/s).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    length_scale, speed = (
        _length(length_scale),
        checks.positive("speed", speed),
    )
    turn_rate = checks.number("turn_rate", turn_rate)
    ax = new_axes(ax, (6.2, 4.4))
    side = np.linspace(-0.9, 0.9, 401) * length_scale  # right of the singular line
    x_e, y_e = np.meshgrid(side, side)
    sine = y_e / np.hypot(y_e, length_scale)
    denominator = 1 + x_e * length_scale / (length_scale**2 + y_e**2)
    rate = -y_e * (x_e * turn_rate + speed * sine) / denominator
    ax.contourf(x_e, y_e, rate, levels=[0, np.inf], colors=[PALETTE["danger"]], alpha=0.4)
    ax.fill([], [], color=PALETTE["danger"], alpha=0.4, label="$|y_e|$ grows")
    ax.axvline(0, color=PALETTE["safe"], lw=2.5, label="$s=0$: what (9) is about")
    ax.set(xlabel="$x_e$ (mm)", ylabel="$y_e$ (mm)", aspect="equal")
    count_in_mm(ax.xaxis, ax.yaxis)
    return ax


def plot_tradeoff(families, marks=(), ax=None):
    """Accuracy against chattering: a curve for each way to choose a gain.

    Parameters
    ----------
    families : dict of str to array_like, shape (2, n)
        By name: total variation of the wheels over the reference's, and the
        error (m), gain by gain.
    marks : sequence of sequences of str, optional
        For the first families, what each gain is.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("families", families, dict, "names and curves")
    marks = [
        checks.instances("marks", texts, str, "texts, family by family")
        for texts in checks.sequence("marks", marks, "texts, family by family")
    ]
    ax = new_axes(ax, (6.4, 4.6))
    looks = (("danger", "s-"), ("planned", "o--"), ("turning", "^:"))
    for number, (name, curve) in enumerate(families.items()):
        color, mark = looks[number % len(looks)]
        variation, error = checks.array(f"families: {name}", curve, (2, None), unit="1 and m")
        style = {"ms": 6, "lw": 1.4, "label": name, "color": PALETTE[color]}
        ax.loglog(variation, error, mark, **style)
        told = marks[number] if number < len(marks) else ()
        # In turns left and right, for curves meet where both chatter most.
        side, aside = ("left", 5) if number % 2 else ("right", -5)
        where = {"xytext": (aside, 4), "textcoords": "offset points", "ha": side, "fontsize": 8}
        for x, y, text in zip(variation, error, told, strict=False):
            ax.annotate(text, (x, y), color=PALETTE[color], path_effects=HALO, **where)
    ax.axvline(1, color="0.5", lw=1, ls="-.", label="the reference itself")
    ax.set(xlabel="total variation of the wheels (times the reference's)", ylabel="error (mm)")
    count_in_mm(ax.yaxis)
    return ax


def _length(length_scale):
    """The law's length, or `InvalidParameter` for one whose square is not a number, or zero."""
    remedy = "a positive length (m) of a robot, such as 0.045"
    return checks.number("length_scale", length_scale, lambda found: 1e-9 < found < 1e9, remedy)
