"""What sketches are made of: arrows, names, dimension lines, and axes without a frame."""

import numpy as np

from freeseg.plotting.axes import new_axes


def arrow(ax, tail, tip, color, style="-|>", **options):
    """An arrow between two points (m)."""
    shape = {"arrowstyle": style, "color": color, "lw": 1.8, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", tip, tail, arrowprops=shape | options, zorder=5)


def write(ax, text, point, color="black", size=12, **options):
    """A label centred on a point (m)."""
    style = {"ha": "center", "va": "center", "zorder": 6} | options
    ax.text(*point, text, color=color, fontsize=size, **style)


def measure(ax, first, last, name, shift):
    """A dimension line between two points (m), and its name, shifted off its middle (m)."""
    arrow(ax, first, last, "black", "<->", lw=1)
    write(ax, name, np.mean([first, last], 0) + shift)


def sketch_axes(ax, size, xlim, ylim):
    """Axes for a sketch: equal scales, no frame."""
    ax = new_axes(ax, size)
    ax.set(aspect="equal", xlim=xlim, ylim=ylim)
    ax.set_axis_off()
    return ax
