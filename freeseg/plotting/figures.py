"""Pictures of tracking: references, Figs 18 and 19 on the paper's axes, and many runs at once."""

from collections.abc import Mapping

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plan import check_plan
from freeseg.plotting.axes import PALETTE, check_color, count_in_mm, new_axes, several_axes
from freeseg.plotting.runs import check_run, check_tracked, plot_wheels
from freeseg.reference import Reference
from freeseg.robot import as_robot, wheel_speeds

#: Units that errors may be counted in: what one is, in m or in rad.
LENGTHS, ANGLES = {"m": 1.0, "cm": 0.01, "mm": 0.001}, {"rad": 1.0, "°": np.pi / 180}
#: A slower reference has no curvature (m/s), and one that turns less drives straight on (rad/s).
SLOW, NO_TURN = 1e-3, 1e-9
#: Shares of the runs within the bands of `plot_quantiles`, and how dark each is.
BANDS = (1.0, 0.15), (0.9, 0.3), (0.5, 0.5)
#: Position errors at which `plot_starts` changes its colour (m), and its colours.
END_LEVELS = (0, 0.001, 0.01, 0.1, 1)
END_COLORS = "#f7f4e4", "#c9dff0", "#7fb0d6", "#3a6ea5", "#1c2a48"


def turns_of(reference):
    """When a reference begins and ends to turn (s), shape (k, 2)."""
    turning = np.abs(reference.omega) > NO_TURN
    changes = np.diff(np.concatenate([[False], turning, [False]]).astype(int))
    last = len(reference.t) - 1
    return reference.t[np.minimum(np.flatnonzero(changes), last)].reshape(-1, 2)


def check_reference(reference):
    """A reference, or `InvalidParameter`."""
    return checks.instance("reference", reference, Reference, "one made by make_reference")


def plot_reference(reference, robot=None, axes=None):
    """How sharply a reference turns, and how fast the wheels have to be for it.

    Parameters
    ----------
    reference : Reference
        What is to be followed.
    robot : Robot, optional
        Whose wheels; by default a Khepera IV.
    axes : sequence of 2 matplotlib Axes, optional
        Where to draw the curvature and the wheels, over the way.

    Returns
    -------
    tuple of 2 matplotlib Axes
    """
    check_reference(reference)
    robot = as_robot(robot)
    above, below = several_axes(axes, 2, 1, (6.4, 4.2))
    way = np.append(0, np.cumsum(np.hypot(*np.diff(reference.pose[:2]))))
    moving = reference.v > SLOW
    curvature = np.divide(reference.omega, reference.v, out=np.full_like(way, np.nan), where=moving)
    above.axhline(0, color="0.6", lw=0.8)
    above.plot(way, curvature, color=PALETTE["planned"], lw=1.6)
    above.set_ylabel(r"$\kappa$ (1/m)")
    wheels = wheel_speeds(robot, reference.v, reference.omega)
    for speed, side, symbol in zip(wheels, ("right", "left"), ("$V_R$", "$V_L$"), strict=True):
        below.plot(way, speed, color=PALETTE[side], lw=1.4, label=f"{symbol} ({side})")
    below.set(xlabel="way (mm)", ylabel="wheel speed (mm/s)")
    count_in_mm(above.xaxis, below.xaxis, below.yaxis)
    below.legend(loc="lower center", ncols=2, frameon=False)
    for ax in (above, below):
        ax.spines[["top", "right"]].set_visible(False)
    above.figure.align_ylabels([above, below])
    return above, below


def plot_leads(run, reference, plan, ax=None):
    """Wheel speeds over time (Fig. 19), and at which obstacle the reference turns.

    Parameters
    ----------
    run : Run
        What one robot drove.
    reference : Reference
        What it followed.
    plan : Plan
        What the reference was made of.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_reference(reference), check_plan(plan), check_run(run)
    turns = turns_of(reference)
    if len(turns) != len(plan.turning_points):
        raise InvalidParameter(
            f"reference turns {len(turns)} times, the plan {len(plan.turning_points)} times; give "
            "the reference of this plan"
        )
    ax = plot_wheels(run, ax)
    low, high = ax.get_ylim()
    for (first, last), turn in zip(turns, plan.turning_points, strict=True):
        ax.axvspan(first, last, color=PALETTE["turning"], alpha=0.25, lw=0)
        text, middle = f"obstacle {turn.obstacle + 1}", (first + last) / 2
        ax.annotate(text, (middle, low + 0.03 * (high - low)), ha="center", fontsize=9)
    return ax


def plot_pull(run, axes=None, most=0.02, wheels=0.4):
    """Error along the robot over time, and what its wheels do about it.

    Parameters
    ----------
    run : Run
        What one robot drove.
    axes : sequence of 2 matplotlib Axes, optional
        Where to draw.
    most, wheels : float, optional
        Where the axes of x_e (m) and of the wheels (m/s) end; the same for all
        pages of a flipbook. Downwards, they show a quarter of it.

    Returns
    -------
    tuple of 2 matplotlib Axes
    """
    check_tracked(run)
    most, wheels = checks.positive("most", most), checks.positive("wheels", wheels)
    above, below = several_axes(axes, 2, 1, (6.4, 4.4))
    above.axhline(0, color="0.6", lw=0.8)
    above.plot(run.t, run.error[0], color=PALETTE["error"], lw=1.5)
    above.set(ylabel="$x_e$ (mm)", ylim=(-most / 4, most))
    above.spines[["top", "right"]].set_visible(False)
    count_in_mm(above.yaxis)
    plot_wheels(run, below)
    below.set_ylim(-wheels / 4, wheels)
    return above, below


def plot_across(runs, ax=None, most=0.06):
    """Error across the robot over time, of several runs.

    Parameters
    ----------
    runs : dict of str to Run
        By name, up to three runs of one robot each.
    ax : matplotlib Axes, optional
        Where to draw.
    most : float, optional
        Where the axis of y_e ends, either way (m).

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("runs", runs, Mapping, "a dict of names and runs")
    if any(check_run(run).error is None for run in runs.values()):
        raise InvalidParameter("runs has one without a reference; simulate each with one")
    most, ax = checks.positive("most", most), new_axes(ax, (6.4, 3.4))
    ax.axhline(0, color="0.6", lw=0.8)
    looks = ("tracked", "-"), ("left", "--"), ("planned", ":")
    for (name, run), (color, style) in zip(runs.items(), looks, strict=False):
        ax.plot(run.t, run.error[1], style, color=PALETTE[color], lw=1.6, label=str(name))
    ax.set(xlabel="time (s)", ylabel="$y_e$ (mm)", ylim=(-most, most))
    ax.spines[["top", "right"]].set_visible(False)
    count_in_mm(ax.yaxis)
    ax.legend(loc="upper left", frameon=False)
    return ax


def plot_on_axes(run, limits, wheels, axes=None, length="mm", angle="rad", until=None):
    """Errors and wheel speeds on axes of a given size, as Figs 18 and 19 have them.

    Parameters
    ----------
    run : Run
        What one robot drove.
    limits : sequence of 3 floats
        Where the axes of x_e, y_e and alpha_e end, either way, in their units.
    wheels : float
        Where the axis of the wheels ends, either way (m/s).
    axes : sequence of 4 matplotlib Axes, optional
        Where to draw.
    length : {"m", "cm", "mm"}, optional
        Unit of x_e and y_e.
    angle : {"rad", "°"}, optional
        Unit of alpha_e.
    until : float, optional
        Where the time axis ends (s); by default with the run.

    Returns
    -------
    tuple of 4 matplotlib Axes
    """
    check_tracked(run)
    limits = checks.array("limits", limits, (3,), unit="of the errors")
    limits = [checks.positive("limits", limit) for limit in limits]
    wheels = checks.positive("wheels", wheels)
    until = checks.positive("until", run.t[-1] if until is None else until)
    checks.choice("length", length, LENGTHS), checks.choice("angle", angle, ANGLES)
    *of_errors, of_wheels = axes = several_axes(axes, 4, 1, (5, 6))
    units = LENGTHS[length], LENGTHS[length], ANGLES[angle]
    labels = f"$x_e$ ({length})", f"$y_e$ ({length})", rf"$\alpha_e$ ({angle})"
    for ax, error, unit, limit, label in zip(
        of_errors, run.error, units, limits, labels, strict=True
    ):
        ax.axhline(0, color="0.7", lw=0.8)
        ax.plot(run.t, error / unit, color=PALETTE["error"], lw=1.5)
        ax.set(ylim=(-limit, limit), yticks=(-limit, 0, limit), ylabel=label)
        ax.tick_params(labelbottom=False)
    plot_wheels(run, of_wheels)
    of_wheels.set(ylim=(-wheels, wheels), yticks=np.linspace(-wheels, wheels, 5))
    of_wheels.set_ylabel("wheels (mm/s)")
    for ax in axes:
        ax.set_xlim(0, until)
        ax.spines[["top", "right"]].set_visible(True)
    of_wheels.figure.align_ylabels(axes)
    return axes


def plot_quantiles(t, values, ax=None, color=PALETTE["tracked"]):
    """Many runs as bands: between which values half of them, 90 % and all of them are.

    Parameters
    ----------
    t : array_like, shape (N,)
        Times (s).
    values : array_like, shape (n, N)
        A signal of each of n runs.
    ax : matplotlib Axes, optional
        Where to draw.
    color : color, optional
        Of the bands.

    Returns
    -------
    matplotlib Axes
    """
    t = checks.array("t", t, (None,), unit="s")
    values = checks.array("values", values, (None, len(t)), unit="a row for each run")
    color, ax = check_color(color), new_axes(ax, (6.4, 3.2))
    for share, alpha in BANDS:
        low, high = np.quantile(values, [(1 - share) / 2, (1 + share) / 2], axis=0)
        label = "all" if share == 1 else f"{100 * share:.0f} %"
        ax.fill_between(t, low, high, color=color, alpha=alpha, lw=0, label=label)
    ax.plot(t, np.median(values, axis=0), color="black", lw=1.2, label="median")
    ax.set_xlabel("time (s)")
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def plot_starts(offsets, ends, ax=None):
    """How far from the reference robots end, by where they start beside it.

    Parameters
    ----------
    offsets : array_like, shape (k,)
        How far ahead and how far to the left they start (m).
    ends : array_like, shape (k, k)
        Position error at the end (m): a row for each offset to the left, a
        column for each ahead.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    offsets = checks.array("offsets", offsets, (None,), unit="m")
    ends = checks.array("ends", ends, (len(offsets), len(offsets)), unit="m")
    if len(offsets) < 2 or not (np.diff(offsets) > 0).all():
        raise InvalidParameter("offsets do not increase; give two or more that do (m)")
    ax = new_axes(ax, (5.2, 4.4))
    norm = BoundaryNorm(END_LEVELS, len(END_COLORS), extend="max")
    style = {"cmap": ListedColormap(END_COLORS), "norm": norm, "shading": "nearest"}
    drawn = ax.pcolormesh(offsets, offsets, ends, **style)
    ax.plot(0, 0, "o", color=PALETTE["tracked"], mec="white", ms=8)
    ax.set(xlabel="starts ahead of the reference (mm)", ylabel="to its left (mm)", aspect="equal")
    bar = ax.figure.colorbar(drawn, ax=ax, label="position error at the end (mm)", extend="max")
    count_in_mm(ax.xaxis, ax.yaxis, bar.ax.yaxis)
    return ax


def plot_agreement(counts, rows, columns, ax=None):
    """How many of what was tried agree with two cases, by assumption and by reading.

    Parameters
    ----------
    counts : array_like, shape (r, c, 2)
        How many agree with the first case, and with the second.
    rows, columns : sequence of str
        Names of the r assumptions and of the c readings.
    ax : matplotlib Axes, optional
        Where to draw; coloured is where some agree with both, pale where some
        agree with one only.

    Returns
    -------
    matplotlib Axes
    """
    rows, columns = (
        [str(one) for one in checks.sequence(name, given, "names")]
        for name, given in (("rows", rows), ("columns", columns))
    )
    counts = checks.array("counts", counts, (len(rows), len(columns), 2), unit="counts")
    ax = new_axes(ax, (1 + 1.1 * len(columns), 0.6 + 0.34 * len(rows)))
    colors = ListedColormap(["white", "#fbe3b4", "#8fd3bd"])
    ax.pcolormesh((counts > 0).sum(-1), cmap=colors, vmin=0, vmax=2, edgecolors="0.85", lw=1)
    for (row, column), (first, second) in zip(
        np.ndindex(counts.shape[:2]), counts.reshape(-1, 2), strict=True
    ):
        text = f"{first:.0f} | {second:.0f}" if first or second else "–"
        ax.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=9)
    ax.set_xticks(np.arange(len(columns)) + 0.5, columns)
    ax.set_yticks(np.arange(len(rows)) + 0.5, rows)
    ax.invert_yaxis()
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    return ax
