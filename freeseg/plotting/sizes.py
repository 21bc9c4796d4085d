"""What sizes the paper's obstacles may have."""

from collections.abc import Mapping

import numpy as np

from freeseg import checks
from freeseg.plotting.axes import PALETTE, count_in_mm, new_axes

#: From the widest statement to the narrowest: ranges are drawn over one another.
RANGE_COLORS = "robot", "planned", "turning"


def plot_ranges(ranges, chosen, ax=None):
    """Ranges of the obstacles' sizes, and the sizes that were chosen.

    Parameters
    ----------
    ranges : dict
        Label to an array of shape (n, 2): smallest and largest size (m) of
        each obstacle; up to three, the widest first.
    chosen : array_like, shape (n,)
        Sizes (m).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("ranges", ranges, Mapping, "a dict of label to smallest and largest sizes")
    chosen = checks.array("chosen", chosen, (None,), unit="m")
    ax = new_axes(ax, (6, 3.6))
    numbers = np.arange(1, len(chosen) + 1)
    for (label, ends), color, width in zip(ranges.items(), RANGE_COLORS, (9, 6, 3), strict=False):
        low, high = checks.array("ranges", ends, (len(chosen), 2), unit="m").T
        ax.hlines(numbers, low, high, color=PALETTE[color], lw=width, label=label)
    ax.plot(chosen, numbers, "kD", ms=5, ls="", label="chosen")
    ax.set(xlabel="radius (mm)", ylabel="obstacle", yticks=numbers, xlim=(0, None))
    ax.invert_yaxis()
    count_in_mm(ax.xaxis)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=4, frameon=False)
    return ax
