"""What all pictures share: one palette, and axes with ticks in mm and degrees."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import is_color_like
from matplotlib.ticker import AutoLocator, ScalarFormatter

from freeseg import checks
from freeseg.errors import InvalidParameter

#: The colour of each thing, everywhere; safe for the colour-blind.
PALETTE = {
    "obstacle": "#c8c8c8",
    "outline": "#5a5a5a",
    "group": "#e3bfd2",
    "robot": "#56b4e9",
    "planned": "#0072b2",
    "tracked": "#d55e00",
    "safe": "#009e73",
    "danger": "#aa3377",
    "turning": "#e69f00",
    "right": "#004488",
    "left": "#bb5566",
    "error": "#333333",
}

#: How many, in words.
COUNTS = {2: "two", 3: "three", 4: "four"}


def count_in_mm(*axes):
    """Let axes in metres have ticks in mm.

    Parameters
    ----------
    *axes : matplotlib Axis
        Such as ``ax.xaxis``; of lengths (m) or of speeds (m/s). Set a logarithmic
        scale first, for it brings its own ticks.
    """
    for axis in _check_axis(axes):
        axis.set_major_formatter(_CountFormatter(1000))


def count_in_degrees(*axes):
    """Let axes in radians have ticks in degrees, at round numbers of them.

    Parameters
    ----------
    *axes : matplotlib Axis
        Such as ``ax.yaxis``; of angles (rad).
    """
    for axis in _check_axis(axes):
        axis.set_major_locator(_DegreeLocator())
        axis.set_major_formatter(_CountFormatter(180 / np.pi))


def _check_axis(axes):
    """Matplotlib's Axis objects, or `InvalidParameter`."""
    return checks.instances("axes", axes, Axis, "one Axis after the other, such as ax.xaxis")


class _CountFormatter(ScalarFormatter):
    """Matplotlib's numbers, of units of which there are `factor` in one of the data."""

    def __init__(self, factor):
        super().__init__(useOffset=False)
        self.set_scientific(False)
        self.factor = factor

    def set_locs(self, locs):
        super().set_locs(self.factor * np.asarray(locs))

    def __call__(self, value, pos=None):
        # As many decimals each, but not where ticks lie decades apart.
        if self.axis.get_scale() != "linear":
            return self.format_data_short(value)
        return super().__call__(self.factor * value, pos)

    def format_data_short(self, value):
        return self.fix_minus(f"{self.factor * value:.6g}")


class _DegreeLocator(AutoLocator):
    """Places of round numbers of degrees on an axis in radians."""

    def tick_values(self, vmin, vmax):
        return np.radians(super().tick_values(*np.degrees([vmin, vmax])))


def map_axes(ax=None):
    """Axes set up for a map: metres, with ticks in mm.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        What to set up; a new one by default.

    Returns
    -------
    matplotlib Axes
    """
    ax = new_axes(ax, (5, 5))
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    count_in_mm(ax.xaxis, ax.yaxis)
    return ax


def check_axes(ax):
    """`ax`, or `InvalidParameter` for what is no plane axes, such as an array of them."""
    if not isinstance(ax, Axes) or ax.name != "rectilinear":
        raise InvalidParameter(
            f"ax is {checks.shown(ax)}; give one plane Axes, such as that of fig, ax = "
            "plt.subplots(), or one out of an array of them"
        )
    return ax


def new_axes(ax, size):
    """`ax`, or the axes of a new figure of a size (inches) where it is None."""
    if ax is None:
        _, ax = plt.subplots(figsize=size, layout="constrained")
    return check_axes(ax)


def several_axes(axes, rows, columns, size):
    """`axes`, an array or a sequence of so many, as a list; those of a new figure where None."""
    if axes is None:
        _, axes = plt.subplots(rows, columns, figsize=size, layout="constrained", sharex=True)
    count = rows * columns
    remedy = f"{COUNTS.get(count, count)} Axes, such as those of fig, axes = plt.subplots({count})"
    found = axes.flat if isinstance(axes, np.ndarray) else axes
    found = checks.instances("axes", found, Axes, remedy)
    if len(found) != count:
        raise InvalidParameter(f"axes is {len(found)} Axes; give {remedy}")
    return [check_axes(ax) for ax in found]


def check_color(color):
    """`color`, or `InvalidParameter` for what is none; None is Matplotlib's own choice."""
    if color is not None and not is_color_like(color):
        raise InvalidParameter(
            f"color is {checks.shown(color)}; give a colour, such as PALETTE['planned'] or 'red'"
        )
    return color


def check_colors(colors, names):
    """`colors` of some of the names, or `InvalidParameter`."""
    if colors is None:
        return {}
    checks.instance("colors", colors, Mapping, "a dict of name to colour")
    for name, color in colors.items():
        checks.choice("a name in colors", name, names)
        check_color(color)
    return dict(colors)
