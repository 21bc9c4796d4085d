"""Pictures of what planning costs: time against size, what a search met, and peers."""

import numpy as np
from matplotlib.collections import EllipseCollection

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, check_color, map_axes, new_axes
from freeseg.world import Disc, check_world


def plot_growth(sizes, times, ax=None, color=PALETTE["planned"], label=None):
    """Times against sizes: each a dot, the medians a line, the slowest a crossed line.

    Parameters
    ----------
    sizes : array_like, shape (k,)
        How many obstacles each query had.
    times : array_like, shape (k,)
        How long it took (s).
    ax : matplotlib Axes, optional
        Where to draw; its scales become logarithmic.
    color : color, optional
        Of dots and lines.
    label : str, optional
        For the legend.

    Returns
    -------
    matplotlib Axes
    """
    sizes = checks.array("sizes", sizes, (None,), unit="numbers of obstacles")
    times = checks.array("times", times, (len(sizes),), unit="s")
    if not ((sizes > 0).all() and (times > 0).all()):
        raise InvalidParameter("sizes and times are not all positive; give those of queries")
    color, ax = check_color(color), new_axes(ax, (6, 4))
    each = np.unique(sizes)
    ax.loglog(sizes, 1000 * times, ".", color=color, ms=3, alpha=0.3)
    for of, style, text in ((np.median, "o-", label), (np.max, "x:", None)):
        values = [1000 * of(times[sizes == size]) for size in each]
        ax.loglog(each, values, style, color=color, ms=5, label=text)
    ax.set(xlabel="obstacles", ylabel="time of a query (ms)")
    return ax


def plot_met(world, met, ax=None):
    """Discs that a search met among all others, without numbers.

    Parameters
    ----------
    world : World
        Discs.
    met : sequence of int
        Indices of those that it met.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    met = checks.indices("met", met, len(check_world(world)), "obstacles")
    if not all(isinstance(obstacle, Disc) for obstacle in world):
        raise InvalidParameter(f"world is {checks.shown(world)}; give one of discs only")
    ax = map_axes(ax)
    is_met = np.isin(np.arange(len(world)), met)
    kinds = (~is_met, PALETTE["obstacle"], "never met"), (is_met, PALETTE["turning"], "met")
    for chosen, color, label in kinds:
        size = 2 * world.radii[chosen]
        style = {"units": "xy", "offset_transform": ax.transData, "color": color, "lw": 0}
        offsets = world.edges[:, 0][chosen]
        ax.add_collection(EllipseCollection(size, size, 0 * size, offsets=offsets, **style))
        ax.plot([], [], "o", color=color, label=label)
    ax.autoscale_view()
    return ax


def plot_bars(values, labels, ax=None, color=PALETTE["planned"]):
    """Numbers as bars from above to below, each with its number.

    Parameters
    ----------
    values : array_like, shape (n,)
        Lengths of the bars; the axis is logarithmic.
    labels : sequence of str
        What each is.
    ax : matplotlib Axes, optional
        Where to draw.
    color : color, optional
        Of the bars.

    Returns
    -------
    matplotlib Axes
    """
    values = checks.array("values", values, (None,), unit="lengths of bars")
    labels = checks.instances("labels", labels, str, "texts")
    if len(labels) != len(values) or not (values > 0).all():
        raise InvalidParameter(
            f"values is {checks.shown(values)}; give positive numbers, one for each of "
            f"{len(labels)} labels"
        )
    color, ax = check_color(color), new_axes(ax, (6, 0.35 * len(values) + 1))
    bars = ax.barh(range(len(values)), values, color=color)
    texts = [np.format_float_positional(value, 3, fractional=False, trim="-") for value in values]
    ax.bar_label(bars, texts, padding=3, fontsize=9)
    ax.set(yticks=range(len(values)), xscale="log")
    ax.set_yticklabels(labels)
    ax.invert_yaxis()
    ax.margins(x=0.25)  # room for the numbers
    return ax
