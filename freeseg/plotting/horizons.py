"""Looking ahead: a horizon, what a tracker plans in it, and what it wins by that."""

from collections.abc import Mapping

import numpy as np
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import NullFormatter

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, count_in_degrees, count_in_mm, map_axes, new_axes
from freeseg.plotting.runs import check_run, check_tracked, draw_tracked
from freeseg.plotting.sketches import arrow, write
from freeseg.plotting.worlds import plot_path, plot_world
from freeseg.reference import Reference
from freeseg.world import Disc, check_world

#: Looks of several lines in one picture: told apart without their colours, too.
LINE_LOOKS = (
    {"color": PALETTE["error"], "ls": ":", "lw": 2},
    {"color": PALETTE["planned"], "ls": "--", "lw": 1.8},
    {"color": PALETTE["turning"], "ls": "-.", "lw": 2},
    {"color": PALETTE["tracked"], "ls": "-", "lw": 2.2},
)
#: Of the sketch: time steps before now, under way, and of the horizon.
PAST_STEPS, UNDER_WAY, AHEAD = 3, 2, 6


def sketch_horizon(ax=None):
    """What a tracker that looks ahead knows, predicts, plans and commands at one time step.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax, (8.6, 4.6))
    ax.set(xlim=(-PAST_STEPS - 0.2, UNDER_WAY + AHEAD + 1.9), ylim=(-2.4, 3.9))
    ax.set_axis_off()
    _sketch_positions(ax)
    _sketch_commands(ax)
    for t, name in ((0, "now"), (UNDER_WAY, "the command\narrives")):
        ax.plot((t, t), (-1.75, 3.1), ":", color="0.4", lw=1, zorder=0)
        write(ax, name, (t, 3.45), "0.3", 10)
    for first, last, name in (
        (0, UNDER_WAY, "delay"),
        (UNDER_WAY, UNDER_WAY + AHEAD, "horizon, $N$ steps"),
    ):
        arrow(ax, (first, -2), (last, -2), "black", "<->", lw=1)
        write(ax, name, ((first + last) / 2, -2.25), size=10)
    return ax


def _sketch_positions(ax):
    """Above: the reference, and the robot as it was, will be, and is to come back."""
    t = np.linspace(-PAST_STEPS, UNDER_WAY + AHEAD, 200)
    ax.plot(t, 2.4 + 0.25 * np.sin(t / 2.5), color=PALETTE["planned"], lw=3)
    write(ax, "reference", (t[-1] + 0.9, 2.4), PALETTE["planned"], 10)

    def apart(t):
        return 2.4 + 0.25 * np.sin(t / 2.5) - 1.2 * np.exp(-np.maximum(t - UNDER_WAY, 0) / 1.7)

    known, steps = t[t <= 0], np.arange(UNDER_WAY, UNDER_WAY + AHEAD + 1)
    ax.plot(known, apart(known), color=PALETTE["error"], lw=2)
    ax.plot(0, apart(0), "o", color=PALETTE["error"], ms=9, zorder=5)
    way = t[(t >= 0) & (t <= UNDER_WAY)]
    ax.plot(way, apart(way), color=PALETTE["error"], lw=2, ls="--")
    write(ax, "driven", (-1.6, apart(-1.6) - 0.35), PALETTE["error"], 10)
    write(ax, "predicted", (1, apart(1) - 0.35), PALETTE["error"], 10)
    plan = t[t >= UNDER_WAY]
    ax.plot(plan, apart(plan), color=PALETTE["tracked"], lw=2)
    style = {"color": PALETTE["tracked"], "mec": "black", "zorder": 5}
    ax.plot(steps, apart(steps), "o", ms=6, **style)
    write(ax, "plan", (UNDER_WAY + 1.9, apart(UNDER_WAY + 1.9) - 0.4), PALETTE["tracked"], 10)


def _sketch_commands(ax):
    """Below: commands that were given, that are planned, and the one that is given now."""
    heights = -1.4 + np.array([0.2, 0.3, 0.25, 0.35, 0.3, 0.95, 0.8, 0.6, 0.45, 0.38, 0.35])
    edges = np.arange(-PAST_STEPS, UNDER_WAY + AHEAD + 1)
    for k, height in enumerate(heights):
        first = edges[k]
        kind = "sent" if first < UNDER_WAY else "now" if first == UNDER_WAY else "planned"
        style = {
            "sent": {"color": PALETTE["obstacle"], "ec": PALETTE["outline"], "hatch": "///"},
            "now": {"color": PALETTE["tracked"], "ec": "black"},
            "planned": {"color": "white", "ec": PALETTE["tracked"]},
        }[kind]
        # The past ones have done their work: only those under way are hatched.
        style |= {"hatch": None} if first < 0 else {}
        ax.bar(first, height + 1.75, 1, -1.75, align="edge", lw=1.2, **style)
    write(ax, "under\nway", (UNDER_WAY / 2, -0.65), PALETTE["outline"], 10)
    write(ax, "given now", (UNDER_WAY + 0.08, -0.2), PALETTE["tracked"], 10, ha="left")
    write(ax, "planned, and\nplanned anew next time", (6.2, -0.5), PALETTE["tracked"], 10)
    write(ax, "commands", (edges[-1] + 0.9, -1.5), "0.3", 10)


def plot_turn(run, reference, since=0.0, until=np.inf, ax=None):
    """The turn rate that a reference asks for, and the one that a robot drives.

    Parameters
    ----------
    run : Run
        What one robot drove.
    reference : Reference
        What it followed.
    since, until : float, optional
        Part of the time to draw (s).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_run(run)
    checks.instance("reference", reference, Reference, "one made by make_reference")
    since, until = checks.as_float(since), checks.as_float(until)
    chosen = (run.t >= since) & (run.t <= until)
    if chosen.sum() < 2:
        raise InvalidParameter(
            f"since is {checks.shown(since)} and until {checks.shown(until)}; give times (s) with "
            f"steps of the run between them, which lasts {run.t[-1]:g} s"
        )
    ax = new_axes(ax, (6, 3))
    fine = np.linspace(run.t[chosen][0], run.t[chosen][-1], 801)
    wanted = reference.at(fine).omega
    ax.plot(fine, wanted, color=PALETTE["planned"], lw=4.5, label="reference")
    driven = run.robot.to_body(run.wheels)[1]
    casing = withStroke(linewidth=3.6, foreground="white")
    style = {"where": "post", "color": PALETTE["tracked"], "lw": 1.8, "path_effects": [casing]}
    ax.step(run.t[chosen], driven[chosen], **style, label="driven")
    ax.set(xlabel="time (s)", ylabel="turn rate (°/s)")
    count_in_degrees(ax.yaxis)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def plot_lookahead(path, driven, plan, ax=None):
    """What a robot has driven, and what its tracker plans from there.

    Parameters
    ----------
    path : Path
        What it follows.
    driven : array_like, shape (2, k)
        x, y (m) until now.
    plan : array_like, shape (2, n)
        x, y (m) that it plans, step by step.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    driven = checks.array("driven", driven, (2, None), unit="x, y in m")
    plan = checks.array("plan", plan, (2, None), unit="x, y in m")
    ax = plot_path(path, map_axes(ax), label="reference", lw=6.5)
    draw_tracked(*driven, ax).set_label("driven")
    style = {"mec": PALETTE["tracked"], "mew": 1.3, "ls": "none", "marker": "o", "zorder": 6}
    ax.plot(*plan, mfc="white", ms=6, **style, label="planned")
    ax.plot(*plan[:, :1], mfc=PALETTE["tracked"], ms=7, **style, label="its first step: commanded")
    ax.plot(*driven[:, -1], "o", color="black", ms=7, zorder=7, label="the robot now")
    return ax


def plot_strip(values, ax=None, quantity="settling time (s)"):
    """Numbers of several things, a row each: every one as a dot, their median as a bar.

    Parameters
    ----------
    values : mapping of str to array_like, shape (n,)
        Numbers by name of the row, from above to below; infinite ones are
        counted at the right.
    ax : matplotlib Axes, optional
        Where to draw.
    quantity : str, optional
        What the numbers are, with their unit.

    Returns
    -------
    matplotlib Axes
    """
    rows = _rows("values", values, lambda name, row: _numbers(name, row, False))
    checks.instance("quantity", quantity, str, "a text")
    ax = new_axes(ax, (6.4, 0.32 * len(rows) + 0.9))
    for height, row in enumerate(rows.values()):
        finite = row[np.isfinite(row)]
        # Dots side by side would hide one another: they are spread over the height of the row.
        spread = height + 0.5 * (np.arange(len(finite)) / max(len(finite) - 1, 1) - 0.5)
        style = {"ls": "none", "marker": "o", "ms": 3.5, "alpha": 0.55, "mew": 0}
        ax.plot(finite, spread, color=PALETTE["planned"], **style)
        median = np.median(row)
        if np.isfinite(median):
            ax.plot([median] * 2, [height - 0.36, height + 0.36], color=PALETTE["tracked"], lw=3)
        if len(finite) < len(row):
            text = f"never: {len(row) - len(finite)} of {len(row)}"
            place = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "center"}
            style = {"color": PALETTE["danger"], "fontsize": 9}
            ax.annotate(text, (0.995, height), **place, **style)
    ax.set(yticks=range(len(rows)), yticklabels=list(rows), xlabel=quantity)
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.grid(axis="x", alpha=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def plot_change(values, labels, ax=None, quantity="RMS distance (mm)"):
    """What a change does to several things, a row each: an arrow from before to after.

    Parameters
    ----------
    values : mapping of str to array_like, shape (2,)
        Positive numbers before and after, by name of the row.
    labels : sequence of 2 str
        What before and after are.
    ax : matplotlib Axes, optional
        Where to draw.
    quantity : str, optional
        What the numbers are, with their unit; the axis is logarithmic.

    Returns
    -------
    matplotlib Axes
    """
    rows = _rows("values", values, lambda name, row: _numbers(name, row, True, (2,)))
    labels = checks.instances("labels", labels, str, "two texts")
    if len(labels) != 2:
        raise InvalidParameter(f"labels is {checks.shown(labels)}; give two texts")
    checks.instance("quantity", quantity, str, "a text")
    both = np.array(list(rows.values()))
    if not np.isfinite(both).all():
        raise InvalidParameter(f"values is {checks.shown(values)}; give finite numbers")
    ax = new_axes(ax, (6.4, 0.32 * len(rows) + 0.9))
    ax.set_xscale("log")
    for height, (before, after) in enumerate(both):
        arrow(ax, (before, height), (after, height), "0.5", lw=1.2)
    style = {"ls": "none", "marker": "o", "zorder": 6, "mec": "black"}
    heights = range(len(rows))
    ax.plot(both[:, 0], heights, **style, mfc="white", ms=6, label=labels[0])
    ax.plot(both[:, 1], heights, **style, mfc=PALETTE["tracked"], ms=8, label=labels[1])
    ax.set(yticks=heights, yticklabels=list(rows), xlabel=quantity)
    _plain_ticks(ax.xaxis)
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.grid(axis="x", alpha=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def plot_keep_out(world, run, ax=None):
    """A robot that passes discs, and the circles that its centre is to keep out of.

    Parameters
    ----------
    world : World
        Discs.
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_tracked(run)
    discs = check_world(world).obstacles
    checks.instances("world", discs, Disc, "a World of discs")
    ax = plot_world(world, map_axes(ax))
    for disc in discs:
        radius = disc.radius + run.robot.radius
        circle = Circle(disc.center, radius, fill=False, ec=PALETTE["danger"], ls="--", lw=1.3)
        ax.add_patch(circle)
    ax.plot([], [], "--", color=PALETTE["danger"], lw=1.3, label="no entry for its centre")
    ax.plot(*run.reference[:2], color=PALETTE["planned"], lw=4.5, zorder=4, label="reference")
    draw_tracked(*run.pose[:2], ax)
    ax.autoscale_view()
    return ax


def plot_radii(radii, ax=None):
    """How errors grow or fade from step to step, over the length of the horizon.

    Parameters
    ----------
    radii : mapping of str to array_like, shape (n,)
        By label, at most four: the spectral radius of the closed loop for
        horizons of 1 to n steps; from 1 on, errors grow.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    rows = _lines("radii", radii, lambda name, row: _numbers(name, row, True))
    ax = new_axes(ax, (6.4, 3.4))
    highest = max(row[np.isfinite(row)].max(initial=1) for row in rows.values())
    ax.axhspan(1, 1 + 1.15 * max(highest - 1, 0.02), color=PALETTE["danger"], alpha=0.15, lw=0)
    ax.axhline(1, color=PALETTE["danger"], lw=1)
    for (label, row), look in zip(rows.items(), LINE_LOOKS, strict=False):
        ax.plot(1 + np.arange(len(row)), row, marker="o", ms=4, label=label, **look)
    place = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "bottom"}
    ax.annotate("errors grow", (0.99, 1.005), **place, color=PALETTE["danger"])
    ax.set(xlabel="horizon $N$ (steps)", ylabel="factor on an error, each step")
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def plot_distances(runs, ax=None):
    """Distance from the reference over time, of several runs.

    Parameters
    ----------
    runs : mapping of str to Run
        By label, at most four: what one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    rows = _lines("runs", runs, lambda name, run: check_run(run))
    for label, run in rows.items():
        if run.error is None:
            raise InvalidParameter(f"runs[{label!r}] has no reference; simulate one with it")
    ax = new_axes(ax, (7, 3))
    for (label, run), look in zip(rows.items(), LINE_LOOKS, strict=False):
        ax.plot(run.t, np.hypot(*run.error[:2]), label=label, **look)
    ax.set(xlabel="time (s)", ylabel="distance (mm)")
    count_in_mm(ax.yaxis)
    ax.set_ylim(bottom=0)
    ax.grid(alpha=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def _rows(name, values, check):
    """A mapping of text to what has passed a check, with one entry at least."""
    checks.instance(name, values, Mapping, "a dict, by label")
    checks.instances(name, values, str, "a dict with texts as labels")
    if not values:
        raise InvalidParameter(f"{name} is {checks.shown(values)}; give one row at least")
    return {label: check(f"{name}[{label!r}]", row) for label, row in values.items()}


def _lines(name, values, check):
    """As `_rows`, of no more than have looks of their own."""
    rows = _rows(name, values, check)
    if len(rows) > len(LINE_LOOKS):
        raise InvalidParameter(f"{name} has {len(rows)} lines; give at most {len(LINE_LOOKS)}")
    return rows


def _numbers(name, row, positive, shape=None):
    """A row of numbers, infinite ones among them; positive ones, if they are to be."""
    found = checks.real(name, row, "a row of numbers").astype(float)
    if found.ndim != 1 or not found.size or (shape and found.shape != shape):
        wanted = f"{shape[0]} numbers" if shape else "a row of numbers"
        raise InvalidParameter(f"{name} is {checks.shown(row)}; give {wanted}")
    if (found <= 0).any() if positive else np.isneginf(found).any():
        raise InvalidParameter(f"{name} is {checks.shown(row)}; give positive numbers")
    return found


def _plain_ticks(axis):
    """Numbers such as 0.5 and 20 on a logarithmic axis, instead of powers of ten."""
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(NullFormatter())
