"""Worlds and what lies in them: obstacles, free segments, paths and circles."""

import numpy as np
import shapely
from matplotlib.collections import EllipseCollection, PathCollection, PolyCollection
from matplotlib.patches import Circle, PathPatch
from matplotlib.patches import Polygon as PolygonPatch
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import angle_of, unit
from freeseg.path import Path
from freeseg.plotting.axes import PALETTE, check_axes, check_color, map_axes
from freeseg.robot import as_robot
from freeseg.segments import Endpoint, FreeSegment
from freeseg.world import Disc, Polygon, as_points, as_position, check_world

#: Of more obstacles than that, numbers hide what they name.
MOST_NUMBERS = 100

#: A disc of at least this radius, as a share of the world's extent, has room for its number.
ROOM = 0.05

#: What keeps text readable on lines and on obstacles, and hides less of them than a box.
HALO = [withStroke(linewidth=2, foreground="white")]


def as_patch(obstacle, **style):
    """One obstacle's shape."""
    if isinstance(obstacle, Disc):
        return Circle(obstacle.center, obstacle.radius, **style)
    if obstacle.holes:
        return PathPatch(as_outline(obstacle), **style)
    return PolygonPatch(obstacle.vertices, **style)


def as_outline(polygon):
    """A polygon and its holes as one outline, as Matplotlib has it."""
    rings = [np.concatenate([ring, ring[:1]]) for ring in polygon.rings]
    return Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))


def trace(path):
    """Points to draw a path by, shape (2, n): 2 mm apart, farther on a long one."""
    return path.sample(max(0.002, path.length / 20_000)).T


def plot_world(world, ax=None, numbers=None):
    """Obstacles with their numbers, and what is outside the boundary.

    Parameters
    ----------
    world : World
        Obstacles.
    ax : matplotlib Axes, optional
        Where to draw.
    numbers : bool, optional
        Whether to write the numbers; by default where there are no more than
        100 obstacles.

    Returns
    -------
    matplotlib Axes
    """
    check_world(world)
    numbers = len(world) <= MOST_NUMBERS if numbers is None else checks.flag("numbers", numbers)
    ax = map_axes(ax)
    style = {"facecolors": PALETTE["obstacle"], "edgecolors": PALETTE["outline"], "zorder": 2}
    # A collection each, for ten thousand patches take a minute.
    is_disc = np.array([isinstance(obstacle, Disc) for obstacle in world], bool)
    if is_disc.any():
        centers = world.edges[world.first_edge[is_disc], 0]
        sizes = 2 * world.radii[is_disc]
        round_ones = EllipseCollection(
            sizes, sizes, 0 * sizes, units="xy", offsets=centers, offset_transform=ax.transData
        )
        round_ones.set(**style)
        ax.add_collection(round_ones)
    if not is_disc.all():
        polygons = [obstacle for obstacle in world if isinstance(obstacle, Polygon)]
        plain = [polygon.vertices for polygon in polygons if not polygon.holes]
        ax.add_collection(PolyCollection(plain, **style))
        pierced = [as_outline(polygon) for polygon in polygons if polygon.holes]
        if pierced:
            ax.add_collection(PathCollection(pierced, **style))
    if len(world):
        grown = world.radii[np.repeat(np.arange(len(world)), world.edge_counts), None]
        ax.update_datalim(np.concatenate([world.edges[:, 0] - grown, world.edges[:, 0] + grown]))
    if numbers:
        _write_numbers(world, ax)
    ax.autoscale_view()
    return ax


def _write_numbers(world, ax):
    """Each obstacle's number: on it, and beside a small disc, on the side away from the others."""
    # The boundary has no number.
    cores = world.cores[: world.frame]
    if not len(cores):
        return
    middles = shapely.get_coordinates(shapely.point_on_surface(cores))
    low, high = np.reshape(shapely.total_bounds(cores), (2, 2))
    radii = world.radii[: world.frame]
    extent = (high - low).max() + 2 * radii.max()
    for number, (middle, radius) in enumerate(zip(middles, radii, strict=True), 1):
        # A polygon's core is all of it, and has room.
        small = 0 < radius < ROOM * extent
        away = unit(angle_of(middle - (low + high) / 2)) if small else np.zeros(2)
        ax.annotate(
            str(number),
            middle + radius * away,
            8 * away,
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=9,
            zorder=6,
            path_effects=HALO,
        )


def plot_segments(segments, ax=None, lengths=False, names=False):
    """Free segments: safe ones solid, danger ones dashed.

    Parameters
    ----------
    segments : sequence of FreeSegment
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.
    lengths : bool, optional
        Whether to write each length (mm) on its segment.
    names : bool, optional
        Whether to name the ends as the paper does: those of the first segment
        p2 and p3, of the second p4 and p5.

    Returns
    -------
    matplotlib Axes
    """
    segments = checks.instances("segments", segments, FreeSegment, "FreeSegments")
    lengths, names = checks.flag("lengths", lengths), checks.flag("names", names)
    ax = map_axes(ax)
    for kind, dashes in (("safe", "-"), ("danger", (0, (3, 2)))):
        some = [segment for segment in segments if segment.safe == (kind == "safe")]
        if not some:
            continue
        # One line with gaps: quick also for thousands of segments.
        ends = np.full((len(some), 3, 2), np.nan)
        ends[:, :2] = [segment.ends for segment in some]
        style = {"color": PALETTE[kind], "ls": dashes, "lw": 2, "marker": "o", "ms": 3}
        ax.plot(*ends.reshape(-1, 2).T, **style, zorder=3, label=f"{kind} segment")
        for segment in some if lengths else ():
            middle, text = segment.ends.mean(0), f"{1000 * segment.length:.0f}"
            style = {"ha": "center", "va": "center", "fontsize": 9, "path_effects": HALO}
            ax.annotate(text, middle, color=PALETTE[kind], **style, zorder=5)
    for number, segment in enumerate(segments if names else (), 1):
        _name_ends(number, segment.ends, ax)
    return ax


def _name_ends(number, ends, ax):
    """The paper's names of both ends of a segment, beside it."""
    across = unit(angle_of(ends[1] - ends[0]))
    for k, (end, along) in enumerate(zip(ends, (across, -across), strict=True)):
        shift = 7 * along + 8 * np.array([across[1], -across[0]])
        style = {"ha": "center", "va": "center", "fontsize": 9, "path_effects": HALO}
        text = f"$p_{{{2 * number + k}}}$"
        ax.annotate(text, end, shift, textcoords="offset points", **style, zorder=5)


def plot_endpoints(endpoints, ax=None):
    """Endpoints: filled at the ends of safe segments, hollow where they face no neighbour.

    Parameters
    ----------
    endpoints : sequence of Endpoint
        From `find_endpoints`.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    endpoints = checks.instances("endpoints", endpoints, Endpoint, "Endpoints")
    ax = map_axes(ax)
    for label, outer in (("end of a safe segment", False), ("outer endpoint", True)):
        points = [end.point for end in endpoints if (end.segment is None) == outer]
        if points:
            style = {"mfc": "white" if outer else PALETTE["turning"], "mec": "black", "mew": 0.8}
            ax.plot(*np.transpose(points), "o", **style, ms=4.5, zorder=5, label=label)
    return ax


def plot_path(path, ax=None, color=PALETTE["planned"], **style):
    """A path's centre line.

    Parameters
    ----------
    path : Path
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.
    color : color, optional
        Its colour.
    **style
        For ``Axes.plot``.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("path", path, Path, "a Path, such as plan.path")
    color, ax = check_color(color), map_axes(ax)
    ax.plot(*trace(path), color=color, **({"lw": 2, "zorder": 4} | style))
    return ax


def plot_circle(center, radius, ax, color=PALETTE["turning"], **style):
    """A circle, by default a dangerous one: dashed.

    Parameters
    ----------
    center : array_like, shape (2,)
        Centre (m).
    radius : float
        Radius (m).
    ax : matplotlib Axes
        Where to draw.
    color : color, optional
        Colour of the line.
    **style
        For ``matplotlib.patches.Circle``.

    Returns
    -------
    matplotlib Axes
    """
    center = as_position(center, "center")
    radius = as_points(checks.positive("radius", radius), "radius", (), InvalidParameter)
    color, ax = check_color(color), check_axes(ax)
    style = {"fill": False, "ls": "--", "lw": 1.3, "zorder": 3} | style
    ax.add_patch(Circle(center, radius, color=color, **style))
    return ax


def plot_query(start, goal, ax):
    """Start and goal.

    Parameters
    ----------
    start, goal : array_like, shape (2,)
        Positions (m).
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    start, goal = as_position(start, "start"), as_position(goal, "goal")
    check_axes(ax)
    ax.plot(*start, "ks", ms=6, zorder=6, label="start")
    ax.plot(*goal, "k*", ms=11, zorder=6, label="goal")
    return ax


def plot_band(path, robot, ax):
    """The band that the robot's disc sweeps along a path.

    Parameters
    ----------
    path : Path
        Centre line.
    robot : Robot
        Its radius is half the band's width.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    checks.instance("path", path, Path, "a Path, such as plan.path")
    robot, ax = as_robot(robot), check_axes(ax)
    band = shapely.LineString(trace(path).T).buffer(robot.radius)
    # Fewer corners are drawn sooner, and look the same.
    outline = band.exterior.simplify(robot.radius / 1000)
    ax.fill(
        *outline.xy, color=PALETTE["robot"], alpha=0.25, lw=0, zorder=1, label="swept by the robot"
    )
    return ax


def plot_group(world, group, ax, label="group"):
    """Obstacles that form a group, filled.

    Parameters
    ----------
    world : World
        Obstacles.
    group : sequence of int
        Indices of its members.
    ax : matplotlib Axes
        Where to draw.
    label : str, optional
        For the legend.

    Returns
    -------
    matplotlib Axes
    """
    group = checks.indices("group", group, len(check_world(world)), "obstacles")
    check_axes(ax)
    for k, index in enumerate(group):
        style = {"facecolor": PALETTE["group"], "edgecolor": PALETTE["outline"], "zorder": 2.5}
        ax.add_patch(as_patch(world.obstacles[index], **style, label=None if k else label))
    return ax
