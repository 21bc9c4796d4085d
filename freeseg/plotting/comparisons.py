"""Pictures of a comparison: fronts, intervals, and who is better than whom."""

from collections.abc import Mapping

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, check_colors, count_in_mm, new_axes
from freeseg.studies.statistics import Order

#: What is not named in colours is drawn in.
OTHERS = "0.7"

#: Size of a law's box in the picture of an order, and from row to row.
ORDER_BOX, ROW_HEIGHT = (0.9, 0.5), 1.0


def plot_fronts(fronts, colors=None, ax=None):
    """Error against roughness of each law, at several prices of roughness.

    Parameters
    ----------
    fronts : dict
        Name of each law to an array of shape (n, 2): position error (m) and
        roughness (m/s^2) at each price.
    colors : dict, optional
        Name to colour; all other laws are grey, and share one line of the legend.
    ax : matplotlib Axes, optional
        Where to draw; its scales become logarithmic.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("fronts", fronts, Mapping, "a dict of name to errors and roughnesses")
    colors = check_colors(colors, fronts)
    ax = new_axes(ax, (7, 5))
    others = "the other laws"
    for name in sorted(fronts, key=lambda name: name in colors):
        points = checks.array(f"front of {name}", fronts[name], (None, 2), unit="m, m/s^2")
        x, y = points[np.argsort(points[:, 0])].T
        color = colors.get(name, OTHERS)
        label = name if name in colors else others
        ax.plot(x, y, "o-", color=color, ms=5, lw=1.8 if name in colors else 1, label=label)
        if name not in colors:
            others = None
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="RMS position error (mm)", ylabel="roughness (m/s²)")
    ticks = np.outer(10.0 ** np.arange(-4, 1), [1, 1.5, 2, 3, 5, 7]).ravel()
    for axis in (ax.xaxis, ax.yaxis):
        low, high = axis.get_view_interval()
        axis.set_ticks(ticks[(ticks >= low) & (ticks <= high)])
        axis.set_major_formatter("{x:g}")
    count_in_mm(ax.xaxis)
    ax.minorticks_off()
    ax.grid(color="0.92")
    ax.legend(frameon=False)
    return ax


def plot_intervals(intervals, margin=None, ax=None, colors=None, lengths=True):
    """Means with intervals, a row for each law, and several kinds in a row.

    Parameters
    ----------
    intervals : dict
        Name of each kind to a dict of name of each law to mean, low and high.
    margin : float, optional
        Differences that count as none: a band about zero.
    ax : matplotlib Axes, optional
        Where to draw.
    colors : dict, optional
        Kind to colour.
    lengths : bool, optional
        Whether these are lengths (m), whose ticks count in mm; shares are not.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("intervals", intervals, Mapping, "a dict of kind to a dict of law to interval")
    colors, lengths = check_colors(colors, intervals), checks.flag("lengths", lengths)
    if not intervals or not all(isinstance(kind, Mapping) for kind in intervals.values()):
        raise InvalidParameter(
            f"intervals is {checks.shown(intervals)}; give a dict of kind to a dict of law to "
            "interval"
        )
    names = list(next(iter(intervals.values())))
    ax = new_axes(ax, (7, 0.36 * len(names) + 1))
    if margin is not None:
        margin = checks.not_negative("margin", margin)
        ax.axvspan(-margin, margin, color=PALETTE["safe"], alpha=0.15, lw=0)
    shifts = np.linspace(-0.15, 0.15, len(intervals)) if len(intervals) > 1 else [0.0]
    for shift, (kind, found) in zip(shifts, intervals.items(), strict=True):
        color = colors.get(kind, PALETTE["planned"])
        for place, name in enumerate(names):
            mean, low, high = checks.numbers(f"interval of {name}", found[name], 3)
            ax.plot([low, high], [place + shift] * 2, color=color, lw=2)
            label = kind if place == 0 else None
            ax.plot(mean, place + shift, "o", color=color, ms=5, label=label)
    # Not inverted, which axes that share theirs would undo in turn.
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.5, -0.5)
    ax.grid(axis="x", color="0.92")
    if lengths:
        count_in_mm(ax.xaxis)
    if len(intervals) > 1:
        ax.legend(frameon=False)
    return ax


def plot_order(order, means, ax=None):
    """A partial order: whoever is better stands higher, with a line down to the next.

    Parameters
    ----------
    order : Order
        As `statistics.order` returns it.
    means : dict
        Name of each law to its mean (m), which the boxes tell.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes

    Notes
    -----
    A row holds laws none of which is better than another; from left to right,
    means grow. A law's row is as high as those allow that are better than it.
    """
    checks.instance("order", order, Order, "what statistics.order returns")
    checks.instance("means", means, Mapping, "a dict of name to mean")
    unknown = {name for pair in order.better for name in pair} - set(means)
    if unknown:
        raise InvalidParameter(f"means lacks {sorted(unknown)}; give the mean of each law")
    rows = _rows(order, means)
    widest = max(len(row) for row in rows)
    ax = new_axes(ax, (1.15 * widest, ROW_HEIGHT * len(rows)))
    places = {}
    for depth, row in enumerate(rows):
        for place, name in enumerate(row):
            places[name] = place - (len(row) - 1) / 2, -ROW_HEIGHT * depth
    for better, worse in order.lines:
        (x, y), (x_below, y_below) = places[better], places[worse]
        ends = [y - ORDER_BOX[1] / 2, y_below + ORDER_BOX[1] / 2]
        ax.plot([x, x_below], ends, color="0.55", lw=1, zorder=1)
    for name, (x, y) in places.items():
        text = f"{name}\n{1000 * means[name]:.2f} mm"
        box = {"boxstyle": "round,pad=0.3", "fc": "white", "ec": PALETTE["planned"]}
        ax.text(x, y, text, ha="center", va="center", fontsize=8, bbox=box, zorder=2)
    ax.set(xlim=(-widest / 2, widest / 2), ylim=(-ROW_HEIGHT * (len(rows) - 0.5), ROW_HEIGHT / 2))
    ax.axis("off")
    return ax


def _rows(order, means):
    """Names row by row: a law stands below all that are better, and no lower."""
    depth = dict.fromkeys(means, 0)
    for name in sorted(means, key=means.get):
        above = [depth[better] + 1 for better, worse in order.better if worse == name]
        depth[name] = max(above, default=0)
    rows = [[] for _ in range(max(depth.values()) + 1)]
    for name in sorted(means, key=means.get):
        rows[depth[name]].append(name)
    return rows
