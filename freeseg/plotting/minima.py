"""Local minima: the hills of a potential field, and where a robot's centre may be at all."""

import numpy as np
import shapely
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.plotting.axes import PALETTE, map_axes
from freeseg.plotting.worlds import plot_world
from freeseg.world import as_points, as_position, check_world

#: Points of the grid on which a potential is drawn, along each side.
MESH_POINTS = 150
#: Contours of a potential, spread so that as much of the map lies between any two; and the share
#: of the map that is so high, near obstacles, that contours would only blacken it.
LEVELS, SUMMITS = 24, 0.2

#: Least space to draw round what is drawn (m).
PAD = 0.05


def plot_potential(potential, world, limits, ax=None):
    """Contours of a potential field, dark where it is high, and its obstacles.

    Parameters
    ----------
    potential : callable
        ``potential(points)`` of points (k, 2) in metres is its height at each,
        shape (k,); finite, also inside of obstacles.
    world : World
        Obstacles.
    limits : array_like, shape (4,)
        Least and largest x, then y, to draw (m).
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    check_world(world)
    west, east, south, north = checks.numbers("limits", limits, 4)
    points = np.array([[west, south], [east, north]])
    checks.function("potential", potential, "potential(points)", points)
    x, y = np.meshgrid(np.linspace(west, east, MESH_POINTS), np.linspace(south, north, MESH_POINTS))
    points = np.column_stack([x.ravel(), y.ravel()])
    height = checks.array("potential(points)", potential(points), (len(points),), unit="any")
    height = height.reshape(x.shape)
    levels = np.unique(np.quantile(height, np.linspace(0, 1 - SUMMITS, LEVELS)))
    ax = plot_world(world, ax)
    # The shades count contours, for heights near an obstacle are of another order.
    shades = [(0.2, 0.2, 0.2, shade) for shade in np.linspace(0.05, 0.5, len(levels))]
    ax.contourf(x, y, height, levels, colors=shades, extend="max", zorder=0)
    ax.contour(x, y, height, levels, colors="0.35", linewidths=0.4, zorder=0.5)
    ax.set(xlim=(west, east), ylim=(south, north))
    return ax


def plot_free_space(world, goal, clearance, ax=None):
    """Where a robot's centre may be: what leads to the goal, and what does not.

    Parameters
    ----------
    world : World
        Obstacles.
    goal : array_like, shape (2,)
        Where the robot shall go (m).
    clearance : float
        Distance that its centre keeps from every obstacle (m), such as R_D.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    goal = as_position(goal, "goal")
    clearance = checks.not_negative("clearance", clearance)
    as_points(clearance, "clearance", (), InvalidParameter)
    grown = shapely.buffer(check_world(world).cores, world.radii + clearance, quad_segs=64)
    # Wide enough to drive round everything.
    extent = np.vstack([shapely.bounds(grown).reshape(-1, 2), goal])
    pad = max(clearance, PAD)
    room = shapely.box(*(extent.min(0) - pad), *(extent.max(0) + pad))
    parts = shapely.get_parts(shapely.difference(room, shapely.union_all(grown)))
    ax = map_axes(ax)
    named = set()
    for part in parts:
        reached = shapely.intersects_xy(part, *goal)
        label = "leads to the goal" if reached else "does not"
        style = {"fc": PALETTE["safe"], "hatch": None} if reached else {"fc": "0.35", "hatch": "//"}
        rings = [Outline(np.array(ring.coords)) for ring in (part.exterior, *part.interiors)]
        outline = Outline.make_compound_path(*rings)
        style |= {"alpha": 0.3, "lw": 0, "zorder": 0.5}
        ax.add_patch(PathPatch(outline, **style, label=None if label in named else label))
        named.add(label)
    plot_world(world, ax)
    west, south, east, north = room.bounds
    ax.set(xlim=(west, east), ylim=(south, north))
    return ax
