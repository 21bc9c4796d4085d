"""Pictures of failures: rare ones against the margin, and what causes them."""

from collections.abc import Mapping

import numpy as np

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, check_colors, count_in_mm, new_axes
from freeseg.studies.splitting import Tail
from freeseg.studies.statistics import Share

#: Laws side by side are so far apart, as a part of the distance between strengths.
ABREAST = 0.14


def plot_tails(tails, colors=None, aim=None, ax=None):
    """How probable contact is, against the margin of the plan.

    Parameters
    ----------
    tails : dict
        Name of each law to a list of `Tail` of shortfalls (m): one line a tail, and its
        interval as a band.
    colors : dict, optional
        Name to colour.
    aim : float, optional
        A probability that is marked.
    ax : matplotlib Axes, optional
        Where to draw; its ordinate becomes logarithmic.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("tails", tails, Mapping, "a dict of name to tails")
    colors = check_colors(colors, tails)
    aim = None if aim is None else checks.positive("aim", aim)
    ax = new_axes(ax, (7, 4.2))
    for name, found in tails.items():
        some = checks.instances(f"tails of {name}", found, Tail, "what split returns, as a list")
        for number, tail in enumerate(some):
            seen = tail.share > 0
            margin, share = 2 * tail.levels[seen], tail.share[seen]
            label = None if number else name
            (line,) = ax.plot(margin, share, color=colors.get(name), label=label, lw=1.5)
            # What reaches down to zero has no lower end on a logarithmic scale.
            low = np.maximum(tail.low[seen], share / 100)
            ax.fill_between(margin, low, tail.high[seen], color=line.get_color(), alpha=0.2, lw=0)
    ax.set(yscale="log", xlabel="margin δ of the plan (mm)", ylabel="probability of contact")
    if aim is not None:
        ax.axhline(aim, color=PALETTE["outline"], lw=1, ls=":")
    count_in_mm(ax.xaxis)
    ax.grid(color="0.92")
    ax.legend(frameon=False)
    return ax


def plot_failures(shares, strengths, colors=None, ax=None):
    """Share of runs that fail, against the strength of what disturbs them.

    Parameters
    ----------
    shares : dict
        Name of each law to a list of `Share`, one for every strength.
    strengths : sequence of float
        Factors.
    colors : dict, optional
        Name to colour.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("shares", shares, Mapping, "a dict of name to shares")
    strengths = checks.array("strengths", strengths, (None,))
    colors = check_colors(colors, shares)
    ax = new_axes(ax, (5, 3.5))
    place = np.arange(len(strengths))
    for number, (name, given) in enumerate(shares.items()):
        found = checks.instances(f"shares of {name}", given, Share, "what share returns")
        if len(found) != len(strengths):
            raise InvalidParameter(
                f"shares of {name} are {len(found)}; give {len(strengths)}, as of strengths"
            )
        share, low, high = np.array(found).T
        beside = place + ABREAST * (number - (len(shares) - 1) / 2)
        apart = np.maximum([share - low, high - share], 0)
        style = {"color": colors.get(name), "capsize": 2, "lw": 1.3, "ms": 4}
        ax.errorbar(beside, share, apart, fmt="o-", label=name, **style)
    ax.set_xticks(place, [f"{one:g}×" for one in strengths])
    ax.set(ylim=(-0.03, 1.03), xlabel="strength", ylabel="runs that fail")
    ax.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    ax.grid(axis="y", color="0.92")
    return ax


def plot_indices(names, first, total, ax=None):
    """Sobol's indices of each cause, with their intervals.

    Parameters
    ----------
    names : sequence of str
        Of the k causes.
    first, total : array_like, shape (3, k)
        First-order and total indices: estimates, low and high ends.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    names = checks.instances("names", names, str, "texts")
    if not names:
        raise InvalidParameter("names is empty; give one or more")
    shape = 3, len(names)
    first, total = checks.array("first", first, shape), checks.array("total", total, shape)
    ax = new_axes(ax, (6, 3))
    rows = np.arange(len(names))
    for values, label, color, shift in (
        (first, "alone", PALETTE["planned"], -0.12),
        (total, "with others", PALETTE["tracked"], 0.12),
    ):
        index, low, high = values
        apart = np.maximum([index - low, high - index], 0)
        ax.errorbar(index, rows + shift, xerr=apart, fmt="o", color=color, capsize=2, label=label)
    ax.set_yticks(rows, names)
    ax.invert_yaxis()
    ax.set(xlabel="share of the variance")
    ax.grid(axis="x", color="0.92")
    ax.legend(frameon=False)
    return ax
