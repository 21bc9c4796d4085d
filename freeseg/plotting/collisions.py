"""Dangers of collision: sketches of them, the loop that solves them, and what it did."""

import numpy as np
from matplotlib.patches import Circle, FancyBboxPatch, Polygon

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plan import StepKind, check_plan
from freeseg.plotting.axes import PALETTE, count_in_mm, new_axes
from freeseg.plotting.sketches import arrow
from freeseg.robot import as_robot

#: Radius of a sketch's obstacle, as a share of the robot's.
OBSTACLE = 0.9
#: Boxes of the loop: centre, half the width, text; all of one height.
BOXES = {
    "segments": ((0, 4), 1.35, "free segments:\ncompute $SP_i$"),
    "safe": ((3.3, 4), 1.35, "keep the safe ones:\n$SP_i\\geq D_r+\\delta$"),
    "point": ((6.6, 4), 1.35, "turning point:\nleast detour $SD$"),
    "circle": ((6.6, 2.2), 1.35, "dangerous circle\nof radius $R_D$"),
    "path": ((3.3, 2.2), 1.35, "path: tangents\nand arcs"),
    "solve": ((3.3, 0), 1.35, "solve it:\none more turn"),
    "done": ((-2.6, 2.2), 0.75, "done"),
}
#: Centre and half the axes of the question, and half the height of a box.
QUESTION, HALF_AXES, HALF_HEIGHT = (0, 2.2), (1.25, 0.95), 0.55


def sketch_danger(distance, robot=None, ax=None, endpoint=None):
    """Sketch of a straight path past an obstacle: d, R_r, and who meets whom.

    Parameters
    ----------
    distance : float
        Distance d of the path from the obstacle (m), negative where the path
        runs through it; not below minus the robot's radius.
    robot : Robot, optional
        Its radius is R_r.
    ax : matplotlib Axes, optional
        Where to draw.
    endpoint : float, optional
        Direction from the obstacle's centre to an endpoint p (rad); its
        distance from the path is drawn, too.

    Returns
    -------
    matplotlib Axes

    Notes
    -----
    The obstacle is a disc of 0.9 of the robot's radius.
    """
    reach = as_robot(robot).radius
    distance = checks.number(
        "distance", distance, lambda d: d >= -reach, f"a length (m) of at least {-reach:.4f}"
    )
    radius = OBSTACLE * reach
    middle = np.array([0, distance + radius])
    ax = new_axes(ax, (5, 4))
    ax.add_patch(Circle((0, 0), reach, fc=PALETTE["robot"], alpha=0.35, label="robot"))
    style = {"fc": PALETTE["obstacle"], "ec": PALETTE["outline"]}
    ax.add_patch(Circle(middle, radius, **style, label="obstacle", zorder=1.5))
    ax.plot([-3 * reach, 3 * reach], [0, 0], color=PALETTE["planned"], lw=2, label="path")
    ax.plot(0, 0, "o", color=PALETTE["planned"], ms=5)
    _measure(ax, (0, 0), (-0.8 * reach, -0.6 * reach), "$R_r$", (8, -9))
    if endpoint is None:
        _measure(ax, (0, 0), (0, distance), "$d$", (9, 0), PALETTE["danger"])
    else:
        direction = checks.number("endpoint", endpoint)
        x, y = middle + radius * np.array([np.cos(direction), np.sin(direction)])
        ax.plot(x, y, "o", color=PALETTE["turning"], mec="black", ms=8, label="endpoint $p$")
        _measure(ax, (x, 0), (x, y), "$d_p$", (10, 0), PALETTE["danger"])
    ax.set(aspect="equal", xlim=(-2.2 * reach, 2.2 * reach), ylim=(-1.4 * reach, 3.0 * reach))
    ax.set_axis_off()
    return ax


def _measure(ax, first, last, name, shift, color="black"):
    """A dimension line between two points (m), and its name beside the middle (points)."""
    arrow(ax, first, last, color, "<->", lw=1.5)
    style = {"ha": "center", "va": "center", "fontsize": 13, "color": color, "zorder": 6}
    ax.annotate(name, np.mean([first, last], 0), shift, textcoords="offset points", **style)


def sketch_loop(ax=None):
    """The paper's algorithm as a block diagram, after its Fig. 3.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax, (8.4, 3.8))
    for (x, y), half, text in BOXES.values():
        # What the loop repeats stands out from what is done once.
        repeated = text in (BOXES["path"][2], BOXES["solve"][2])
        color = PALETTE["turning"] if repeated else PALETTE["robot"]
        low = (x - half, y - HALF_HEIGHT)
        style = {"boxstyle": "round,pad=0,rounding_size=0.15", "fc": color, "alpha": 0.35}
        ax.add_patch(FancyBboxPatch(low, 2 * half, 2 * HALF_HEIGHT, **style, lw=0))
        ax.text(x, y, text, ha="center", va="center", fontsize=11)
    (x, y), (a, b) = QUESTION, HALF_AXES
    corners = [(x - a, y), (x, y - b), (x + a, y), (x, y + b)]
    ax.add_patch(Polygon(corners, fc=PALETTE["turning"], alpha=0.35, lw=0))
    ax.text(x, y, "danger\nproblem?\n$d<R_r$", ha="center", va="center", fontsize=11)
    for tail, tip in (
        ((1.35, 4), (1.95, 4)),
        ((4.65, 4), (5.25, 4)),
        ((6.6, 3.45), (6.6, 2.75)),
        ((5.25, 2.2), (4.65, 2.2)),
        ((1.95, 2.2), (1.25, 2.2)),
        ((-1.25, 2.2), (-1.85, 2.2)),
        ((3.3, 0.55), (3.3, 1.65)),
    ):
        _arrow(ax, tail, tip)
    ax.plot([0, 0], [1.25, 0], color="black", lw=1.4)
    _arrow(ax, (0, 0), (1.95, 0))
    ax.text(-1.55, 2.4, "no", ha="center", fontsize=11)
    ax.text(0.15, 0.5, "yes", fontsize=11)
    ax.set(aspect="equal", xlim=(-3.5, 8.1), ylim=(-0.7, 4.7))
    ax.set_axis_off()
    return ax


def _arrow(ax, tail, tip):
    """An arrow of the block diagram."""
    style = {"arrowstyle": "-|>", "color": "black", "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", tip, tail, arrowprops=style)


def plot_repairs(plans, ax=None):
    """Clearance of the path after every step of some plans.

    Parameters
    ----------
    plans : dict of str to Plan
        Names and plans, all for one robot.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("plans", plans, dict, "names and plans, such as {'15a': plan}")
    robots = {check_plan(plan).robot for plan in plans.values()}
    if len(robots) != 1:
        raise InvalidParameter(f"plans are for {len(robots)} robots; give those of one robot")
    (reach,) = (robot.radius for robot in robots)
    ax = new_axes(ax, (7.5, 4.2))
    for mark, (name, plan) in zip("os^vD*XPdph<>" * len(plans), plans.items(), strict=False):
        clearances = [step.path.clearance(plan.world) for step in plan.steps]
        ax.plot(clearances, marker=mark, lw=1.3, label=name)
    low, high = ax.get_ylim()
    low, high = min(low, -reach / 4), max(high, 1.15 * reach)
    for bottom, top, kind, color in (
        (low, 0, StepKind.CASE_1, "danger"),
        (0, reach, StepKind.CASE_2, "turning"),
    ):
        ax.axhspan(bottom, top, color=PALETTE[color], alpha=0.15, lw=0, zorder=0)
        ax.text(-0.4, (bottom + top) / 2, kind, rotation=90, ha="center", va="center")
    most = max(len(plan.steps) for plan in plans.values())
    ax.axhline(reach, color="black", lw=1, ls="--", label="$R_r$")
    ax.set(xlabel="step", ylabel="clearance of the whole path (mm)", xticks=range(most))
    ax.set(xlim=(-0.6, most - 0.7), ylim=(low, high))
    count_in_mm(ax.yaxis)
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=8)
    return ax
