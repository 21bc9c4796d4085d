"""Robots: one drawn to scale, how its wheels move it, and sketches of both."""

import numpy as np
from matplotlib.patches import Arc, Circle, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import (
    PALETTE,
    check_axes,
    count_in_degrees,
    count_in_mm,
    map_axes,
    new_axes,
)
from freeseg.robot import as_robot, body_velocity, moved_pose

#: Width of a drawn wheel, as a share of its radius: no source publishes that of a Khepera IV.
WHEEL_WIDTH = 0.4
#: Where each wheel is: signs of its distance to the left of the middle.
SIDES = {"right": -1, "left": 1}


def check_pose(pose):
    """`pose` as x, y (m) and heading (rad), or `InvalidParameter`."""
    return checks.array("pose", pose, (3,), unit="x, y in m and heading in rad")


def draw_robot(pose, robot, ax):
    """A robot from above, to scale: body, wheels, and a nose that shows its heading.

    Parameters
    ----------
    pose : array_like, shape (3,)
        x, y (m) and heading (rad).
    robot : Robot
        Its sizes: diameter, wheel base and wheel radius. The width of the
        wheels is ours.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    matplotlib Affine2D
        Where it stands; `move_robot` moves it.
    """
    pose, robot, ax = check_pose(pose), as_robot(robot), check_axes(ax)
    place = move_robot(Affine2D(), pose)
    radius, rim = robot.radius, robot.wheel_radius
    body = Circle((0, 0), radius, fc=PALETTE["robot"], ec=PALETTE["outline"], alpha=0.5)
    tip, back, half = 0.93 * radius, 0.6 * radius, 0.2 * radius
    nose = Polygon([(tip, 0), (back, half), (back, -half)], color=PALETTE["error"], lw=0)
    wheels = [
        Rectangle(
            (-rim, sign * robot.wheel_base / 2 - WHEEL_WIDTH * rim / 2),
            2 * rim,
            WHEEL_WIDTH * rim,
            color=PALETTE[side],
            lw=0,
        )
        for side, sign in SIDES.items()
    ]
    for patch in (body, nose, *wheels):
        patch.set(transform=place + ax.transData, zorder=4.5)
        ax.add_patch(patch)
    return place


def move_robot(place, pose):
    """Move a drawn robot to another pose.

    Parameters
    ----------
    place : matplotlib Affine2D
        What `draw_robot` returned.
    pose : array_like, shape (3,)
        x, y (m) and heading (rad).

    Returns
    -------
    matplotlib Affine2D
        `place`.
    """
    checks.instance("place", place, Affine2D, "what draw_robot returned")
    x, y, theta = check_pose(pose)
    return place.clear().rotate(theta).translate(x, y)


def _ahead(theta):
    """Unit vectors ahead and to the left, of a heading (rad)."""
    return np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])


def _arrow(ax, tail, tip, color, style="-|>", **options):
    """An arrow between two points (m)."""
    shape = {"arrowstyle": style, "color": color, "lw": 1.8, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", tip, tail, arrowprops=shape | options, zorder=5)


def _write(ax, text, point, color="black", size=12, **options):
    """A label centred on a point (m)."""
    style = {"ha": "center", "va": "center", "zorder": 6} | options
    ax.text(*point, text, color=color, fontsize=size, **style)


def _measure(ax, first, last, name, shift):
    """A dimension line between two points (m), and its name, shifted off its middle (m)."""
    _arrow(ax, first, last, "black", "<->", lw=1)
    _write(ax, name, np.mean([first, last], 0) + shift)


def _sketch_axes(ax, size, xlim, ylim):
    """Axes for a sketch: equal scales, no frame."""
    ax = new_axes(ax, size)
    ax.set(aspect="equal", xlim=xlim, ylim=ylim)
    ax.set_axis_off()
    return ax


def sketch_pose(robot=None, ax=None):
    """A robot's pose, its wheel base and its wheel speeds, named (Fig. 1).

    Parameters
    ----------
    robot : Robot, optional
        What to draw; by default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    unit = robot.radius
    middle, theta = np.array([1.9, 1.55]) * unit, np.radians(30)
    ahead, left = _ahead(theta)
    ax = _sketch_axes(ax, (4.6, 4), (-0.45 * unit, 4.2 * unit), (-0.45 * unit, 3.3 * unit))
    draw_robot((*middle, theta), robot, ax)
    for axis, name in ((np.array([1, 0]), "x"), (np.array([0, 1]), "y")):
        _arrow(ax, (0, 0), 3.1 * unit * axis, "black", lw=1)
        _write(ax, f"${name}$", 3.25 * unit * axis)
        # Dotted lines lead from the middle to both axes.
        ax.plot(*np.transpose([middle, middle * axis]), ":", color="0.4", lw=1)
        _write(ax, f"${name}$", middle * axis - 0.2 * unit * axis[::-1])
    for side, sign in SIDES.items():
        hub = middle + sign * robot.wheel_base / 2 * left
        _arrow(ax, hub, hub + 1.15 * unit * ahead, PALETTE[side], lw=2.2)
        beside = hub + unit * (1.1 * ahead + 0.25 * sign * left)
        _write(ax, f"$V_{side[0].upper()}$", beside, PALETTE[side])
    for ray in (ahead, np.array([1, 0])):
        ax.plot(*np.transpose([middle, middle + 2.1 * unit * ray]), "--", color="0.4", lw=1)
    size = 3.5 * unit
    ax.add_patch(Arc(middle, size, size, theta1=0, theta2=np.degrees(theta), lw=1.3))
    _write(ax, r"$\alpha$", middle + 1.95 * unit * _ahead(theta / 2)[0])
    # The wheel base is measured behind the robot, where nothing else is.
    ends = middle - 1.2 * unit * ahead + np.outer([-0.5, 0.5], robot.wheel_base * left)
    _measure(ax, *ends, "$L$", -0.17 * unit * ahead)
    return ax


def sketch_turn(robot=None, ax=None):
    """Why unequal wheels turn a robot, and round which point.

    Parameters
    ----------
    robot : Robot, optional
        What to draw; by default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    unit, half = robot.radius, robot.wheel_base / 2
    fast, slow = 1.9 * unit, 0.9 * unit  # arrows of the right and left wheel
    center = -half * (fast + slow) / (fast - slow)
    right_end = half + 1.9 * unit
    limits = (center - 1.5 * unit, right_end), (-1.95 * unit, 2.5 * unit)
    ax = _sketch_axes(ax, (6.4, 3.7), *limits)
    draw_robot((0, 0, np.pi / 2), robot, ax)
    for tip in (0, fast):
        ax.plot((center, half), (0, tip), "--", color="0.4", lw=1)
    ax.plot(center, 0, "o", color=PALETTE["turning"], mec="black", ms=8, zorder=6)
    _write(ax, "centre of\nthe turn", (center - 0.2 * unit, 0), size=10, ha="right")
    for x, tip, color, name in (
        (half, fast, PALETTE["right"], "$V_R$"),
        (-half, slow, PALETTE["left"], "$V_L$"),
        (0, (fast + slow) / 2, "black", "$V$"),
    ):
        _arrow(ax, (x, 0), (x, tip), color, lw=2.2)
        _write(ax, name, (x, tip + 0.25 * unit), color)
    # How much faster the right wheel is.
    beside = half + 0.6 * unit
    for first, tip in ((-half, slow), (half, fast)):
        ax.plot((first, beside), (tip, tip), ":", color="0.4", lw=1)
    _measure(ax, (beside, slow), (beside, fast), "$V_R-V_L$", (0.65 * unit, 0))
    size, angle = -0.9 * center, np.arctan2(fast, half - center)
    ax.add_patch(Arc((center, 0), size, size, theta1=0, theta2=np.degrees(angle), lw=1.3))
    _write(ax, "$w$", (center + 0.62 * size, 0.3 * size * angle))
    for first, last, name, y in ((center, 0, "$V/w$", -1.15), (-half, half, "$L$", -1.55)):
        _measure(ax, (first, y * unit), (last, y * unit), name, (0, -0.2 * unit))
    return ax


def sketch_sum(robot=None, ax=None):
    """Wheel speeds of a motion as those of driving ahead plus those of turning on the spot.

    Parameters
    ----------
    robot : Robot, optional
        What to draw; by default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    unit, half = robot.radius, robot.wheel_base / 2
    ahead, turn, apart = 1.45 * unit, 0.75 * unit, 3.4 * unit
    limits = (-1.3 * unit, 2 * apart + 1.3 * unit), (-1.8 * unit, 2.6 * unit)
    ax = _sketch_axes(ax, (6.6, 3.1), *limits)
    names = (("$V$", "$V$"), ("$L\\,w/2$", "$-L\\,w/2$"), ("$V_R$", "$V_L$"))
    motions = ("ahead", "turning on the spot", "both at once")
    for k, (labels, motion) in enumerate(zip(names, motions, strict=True)):
        middle = k * apart
        draw_robot((middle, 0, np.pi / 2), robot, ax)
        _write(ax, motion, (middle, -1.65 * unit), size=10)
        for (side, sign), name in zip(SIDES.items(), labels, strict=True):
            x = middle - sign * half
            length = (k != 1) * ahead - (k != 0) * sign * turn
            _arrow(ax, (x, 0), (x, length), PALETTE[side], lw=2.2)
            beyond = length + np.sign(length) * 0.28 * unit
            _write(ax, name, (x, beyond), PALETTE[side])
        if k:
            _write(ax, "+="[k - 1], (middle - apart / 2, 0), size=18)
    return ax


def sketch_step(robot=None, ax=None):
    """One time step: the arc that is driven, its chord, and Euler's step.

    Parameters
    ----------
    robot : Robot, optional
        What to draw; by default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    unit = robot.radius
    theta, turn, length = np.radians(15), np.radians(65), 6 * unit
    ahead, left = _ahead(theta)
    along = theta + np.linspace(0, turn, 80)
    radius = length / turn
    arc = radius * np.transpose([np.sin(along) - np.sin(theta), np.cos(theta) - np.cos(along)])
    ax = _sketch_axes(ax, (6, 4.6), (-1.2 * unit, 6.6 * unit), (-1.1 * unit, 5.6 * unit))
    for pose in ((0, 0, theta), (*arc[-1], theta + turn)):
        draw_robot(pose, robot, ax)
    ax.plot(*arc.T, color=PALETTE["planned"], lw=2.5, zorder=5)
    ax.plot(*arc[[0, -1]].T, "--", color="0.2", lw=1.5, zorder=5)
    _arrow(ax, (0, 0), length * ahead, PALETTE["tracked"], lw=2)
    ax.plot((0, 4 * unit), (0, 0), ":", color="0.4", lw=1)
    slope, aside = theta + turn / 2, 0.3 * unit
    _write(ax, "chord", 0.6 * arc[-1] + aside * _ahead(slope)[1], rotation=np.degrees(slope))
    place = arc[55] + 0.2 * unit * np.array([1, -1])
    _write(ax, "exact arc,\nlength $V\\,dt$", place, PALETTE["planned"], 11, ha="left", va="top")
    place, slope = 0.75 * length * ahead - aside * left, np.degrees(theta)
    _write(ax, "Euler's step, length $V\\,dt$", place, PALETTE["tracked"], 11, rotation=slope)
    for size, first, last, middle, name in (
        (5 * unit, 0, theta, theta / 2, r"$\alpha$"),
        # Nearer to the chord, for the arc passes through the middle.
        (4 * unit, theta, theta + turn / 2, theta + 0.37 * turn, r"$\frac{w\,dt}{2}$"),
    ):
        ends = {"theta1": np.degrees(first), "theta2": np.degrees(last)}
        ax.add_patch(Arc((0, 0), size, size, **ends, lw=1.3, zorder=5))
        _write(ax, name, (0.5 * size + aside) * _ahead(middle)[0], size=13)
    return ax


def _check_speed(name, speed, robot):
    """A wheel speed (m/s) that the robot reaches, or `InvalidParameter`."""
    speed = checks.number(name, speed)
    if abs(speed) > robot.max_wheel_speed:
        raise InvalidParameter(
            f"{name} is {speed:g} m/s; the robot's wheels reach at most "
            f"{robot.max_wheel_speed:.4g} m/s"
        )
    return speed


def plot_drive(right, left, duration, robot=None, ax=None):
    """Where two constant wheel speeds take a robot, and the point that it turns round.

    It starts at the origin, looking along the x axis. Drawn are the paths of its
    middle and of both wheels, and the robot at either end.

    Parameters
    ----------
    right, left : float
        Wheel speeds (m/s).
    duration : float
        Time (s).
    robot : Robot, optional
        By default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidParameter
        For a speed beyond the robot's limit, or a time that is not positive.
    """
    robot = as_robot(robot)
    wheels = [_check_speed("right", right, robot), _check_speed("left", left, robot)]
    times = np.linspace(0, checks.positive("duration", duration), 400)
    ax = map_axes(ax)
    x, y, theta = poses = moved_pose(robot, np.zeros((3, 1)), np.array(wheels)[:, None], times)
    for side, sign in SIDES.items():
        hub = sign * robot.wheel_base / 2 * np.array([-np.sin(theta), np.cos(theta)])
        ax.plot(*(poses[:2] + hub), color=PALETTE[side], lw=1, label=f"{side} wheel")
    ax.plot(x, y, color=PALETTE["tracked"], lw=2.2, zorder=5, label="middle of the axle")
    for pose in poses.T[[0, -1]]:
        draw_robot(pose, robot, ax)
    v, omega = body_velocity(robot, wheels)
    if omega:
        style = {"color": PALETTE["turning"], "mec": "black", "ms": 8, "zorder": 6}
        ax.plot(0, v / omega, "o", **style, label="centre of the turn")
        ax.plot((0, 0), (0, v / omega), "--", color="0.4", lw=1)
    return ax


def plot_limits(robot=None, ax=None):
    """Forward speeds and turn rates that a robot's wheels can give it.

    Parameters
    ----------
    robot : Robot, optional
        By default a Khepera IV.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    robot = as_robot(robot)
    ax = new_axes(ax, (6, 4))
    top = robot.max_wheel_speed
    corners = body_velocity(robot, top * np.array([[1, 1, -1, -1], [1, -1, -1, 1]]))
    label = "within the wheels' limits"
    ax.fill(*corners, color=PALETTE["robot"], alpha=0.3, lw=0, label=label)
    ax.set(xlabel="forward speed V (mm/s)", ylabel="turn rate w (°/s)")
    count_in_mm(ax.xaxis)
    count_in_degrees(ax.yaxis)
    return ax
