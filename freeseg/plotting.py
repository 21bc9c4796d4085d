"""Pictures of worlds, plans and runs: one palette, ticks in mm and degrees.

Every function draws on ``ax``, or on a new figure, and returns the axes. Data are
in metres and radians, as everywhere; only the ticks count in mm and degrees.
"""

import matplotlib.pyplot as plt
import numpy as np
import shapely
from matplotlib.animation import FuncAnimation
from matplotlib.collections import EllipseCollection, PathCollection, PolyCollection
from matplotlib.patches import Circle, PathPatch
from matplotlib.patches import Polygon as PolygonPatch
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.ticker import AutoLocator, ScalarFormatter

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.path import Arc, Path
from freeseg.plan import Plan, Step, StepKind
from freeseg.segments import FreeSegment
from freeseg.simulate import Run
from freeseg.world import Disc, Polygon, check_world

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

#: Of more obstacles than that, numbers hide what they name.
MOST_NUMBERS = 100

#: More pictures would fill the memory before anybody saw the last one.
MOST_FRAMES = 10_000


def count_in_mm(*axes):
    """Let axes in metres have ticks in mm.

    Parameters
    ----------
    *axes : matplotlib Axis
        Such as ``ax.xaxis``; of lengths (m) or of speeds (m/s). Set a logarithmic
        scale first, for it brings its own ticks.
    """
    for axis in axes:
        axis.set_major_formatter(_CountFormatter(1000))


def count_in_degrees(*axes):
    """Let axes in radians have ticks in degrees, at round numbers of them.

    Parameters
    ----------
    *axes : matplotlib Axis
        Such as ``ax.yaxis``; of angles (rad).
    """
    for axis in axes:
        axis.set_major_locator(_DegreeLocator())
        axis.set_major_formatter(_CountFormatter(180 / np.pi))


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
    if ax is None:
        _, ax = plt.subplots(figsize=(5, 5), layout="constrained")
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    count_in_mm(ax.xaxis, ax.yaxis)
    return ax


def _check_plan(plan):
    """`plan`, or `InvalidParameter`."""
    return checks.instance("plan", plan, Plan, "what a planner returned, such as fs.plan's")


def _check_run(run, plan=None):
    """A run of one robot, and of the one planned for; or `InvalidParameter`."""
    checks.instance("run", run, Run, "what simulate returned")
    if run.pose.ndim > 2:
        raise InvalidParameter(f"run is a {run!r}; draw one robot: simulate it alone")
    if plan is not None and plan.robot != run.robot:
        raise InvalidParameter(
            f"run is of the robot {run.robot}, the plan for {plan.robot}; give those of one robot"
        )
    return run


def _patch(obstacle, **style):
    """One obstacle's shape."""
    if isinstance(obstacle, Disc):
        return Circle(obstacle.center, obstacle.radius, **style)
    if obstacle.holes:
        return PathPatch(_outlines(obstacle), **style)
    return PolygonPatch(obstacle.vertices, **style)


def _outlines(polygon):
    """A polygon and its holes as one outline, as Matplotlib has it."""
    rings = [np.concatenate([ring, ring[:1]]) for ring in polygon.rings]
    return Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))


def _trace(path):
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
        pierced = [_outlines(polygon) for polygon in polygons if polygon.holes]
        if pierced:
            ax.add_collection(PathCollection(pierced, **style))
    if len(world):
        grown = world.radii[np.repeat(np.arange(len(world)), world.edge_counts), None]
        ax.update_datalim(np.concatenate([world.edges[:, 0] - grown, world.edges[:, 0] + grown]))
    if len(world) <= MOST_NUMBERS if numbers is None else numbers:
        # The boundary has no number.
        for number, core in enumerate(world.cores[: world.frame], 1):
            middle = core.representative_point().coords[0]
            label = ax.annotate(str(number), middle, ha="center", va="center", fontsize=9, zorder=6)
            label.set_path_effects([withStroke(linewidth=1.5, foreground="white")])
    ax.autoscale_view()
    return ax


def plot_segments(segments, ax=None, lengths=False):
    """Free segments: safe ones solid, danger ones dashed.

    Parameters
    ----------
    segments : sequence of FreeSegment
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.
    lengths : bool, optional
        Whether to write each length (mm) beside its segment.

    Returns
    -------
    matplotlib Axes
    """
    segments = checks.instances("segments", segments, FreeSegment, "FreeSegments")
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
            ax.annotate(
                f"{1000 * segment.length:.0f}",
                segment.ends.mean(0),
                ha="center",
                va="center",
                fontsize=8,
                color=PALETTE[kind],
                bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85},
                zorder=5,
            )
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
    ax = map_axes(ax)
    ax.plot(*_trace(path), color=color, **({"lw": 2, "zorder": 4} | style))
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
    ax.plot(*start, "ks", ms=6, zorder=6, label="start")
    ax.plot(*goal, "k*", ms=11, zorder=6, label="goal")
    return ax


def plot_plan(world, plan, ax=None):
    """A plan: obstacles, free segments, dangerous circles and path.

    The band is what the robot's disc sweeps.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    _check_plan(plan)
    ax = plot_world(world, ax)
    plot_segments(plan.segments, ax)
    for index, turn in enumerate(plan.turning_points):
        plot_circle(turn.center, turn.radius, ax, label=None if index else "dangerous circle")
    plot_band(plan.path, plan.robot, ax)
    plot_path(plan.path, ax, label="planned path", lw=3.5)
    return plot_query(plan.path.start, plan.path.end, ax)


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
    outline = shapely.LineString(_trace(path).T).buffer(robot.radius).exterior
    ax.fill(
        *outline.xy, color=PALETTE["robot"], alpha=0.25, lw=0, zorder=1, label="swept by the robot"
    )
    return ax


def plot_step(world, plan, step, ax=None):
    """One step of a plan's trace: what was met, considered and chosen.

    The obstacle that blocked the path before is outlined, a group is filled;
    a thin line joins the ends of the leg on which candidates, the small
    circles, were ranked.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        The plan that the step belongs to.
    step : Step
        What to draw.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    _check_plan(plan)
    checks.instance("step", step, Step, "one of plan.steps")
    ax = plot_world(world, ax)
    plot_segments(plan.segments, ax)
    if step.group:
        plot_group(world, step.group, ax)
    if step.blocking is not None:
        label = "turn dropped here" if step.kind == StepKind.NEEDLESS_TURN else "blocking obstacle"
        style = {"fill": False, "ec": PALETTE["danger"], "lw": 2.5, "zorder": 2.6, "label": label}
        ax.add_patch(_patch(world.obstacles[step.blocking], **style))
    place = next((k for k, one in enumerate(plan.steps) if one is step), 0)
    if place:
        plot_path(plan.steps[place - 1].path, ax, "0.45", lw=1.5, ls="--", label="path before")
    if step.leg is not None:
        style = {"color": PALETTE["turning"], "lw": 1.2, "ls": ":", "zorder": 3.5}
        ax.plot(*step.leg.T, **style, label="leg searched")
    for k, arc in enumerate(piece for piece in step.path.pieces if isinstance(piece, Arc)):
        plot_circle(arc.center, arc.radius, ax, label=None if k else "dangerous circle")
    for index, candidate in enumerate(step.candidates):
        x, y = candidate.endpoint.point
        style = {"mfc": "white", "mec": PALETTE["turning"], "ms": 4, "zorder": 5}
        ax.plot(x, y, "o", **style, label=None if index else "candidate")
    if step.chosen:
        x, y = step.chosen.endpoint.point
        style = {"color": PALETTE["turning"], "mec": "black", "ms": 8, "zorder": 7}
        ax.plot(x, y, "o", **style, label="turning point")
    plot_path(step.path, ax, label="path after this step")
    ax.set_title(step.kind)
    return plot_query(plan.path.start, plan.path.end, ax)


def plot_group(world, group, ax):
    """Obstacles that form a group, filled.

    Parameters
    ----------
    world : World
        Obstacles.
    group : sequence of int
        Indices of its members.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    for k, index in enumerate(group):
        style = {"facecolor": PALETTE["group"], "edgecolor": PALETTE["outline"], "zorder": 2.5}
        label = None if k else "group"
        ax.add_patch(_patch(world.obstacles[index], **style, label=label))
    return ax


def plot_tracking(world, plan, run, ax=None):
    """A tracked path over the planned one (Fig. 17).

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What was planned.
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    _check_run(run, _check_plan(plan))
    ax = plot_world(world, ax)
    plot_path(plan.path, ax, label="planned path", lw=3.5)
    x, y, theta = run.pose
    ax.plot(x, y, color=PALETTE["tracked"], lw=1.3, zorder=5, label="tracked")
    for when in np.linspace(0, len(x) - 1, 6).astype(int):
        draw_robot((x[when], y[when], theta[when]), run.robot, ax)
    return plot_query(plan.path.start, plan.path.end, ax)


def draw_robot(pose, robot, ax):
    """The robot's disc with its heading.

    Parameters
    ----------
    pose : array_like, shape (3,)
        x, y (m) and heading (rad).
    robot : Robot
        Its size.
    ax : matplotlib Axes
        Where to draw.

    Returns
    -------
    disc : matplotlib Circle
    nose : matplotlib Line2D
        The artists, for an animation to move.
    """
    x, y, _ = pose
    disc = Circle((x, y), robot.radius, fc=PALETTE["robot"], alpha=0.35)
    disc.set(edgecolor=PALETTE["planned"], zorder=4)
    ax.add_patch(disc)
    (nose,) = ax.plot([], [], color=PALETTE["error"], lw=1.2, zorder=4)
    move_robot(disc, nose, pose)
    return disc, nose


def move_robot(disc, nose, pose):
    """Move the artists of `draw_robot` to another pose (m, rad)."""
    x, y, theta = pose
    disc.center = x, y
    radius = disc.radius
    nose.set_data([x, x + radius * np.cos(theta)], [y, y + radius * np.sin(theta)])


def plot_errors(run, axes=None):
    """Tracking errors over time (Fig. 18).

    Parameters
    ----------
    run : Run
        What one robot drove.
    axes : sequence of 3 matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    array of 3 matplotlib Axes
    """
    if _check_run(run).error is None:
        raise InvalidParameter(f"run is a {run!r} without a reference; simulate one with it")
    if axes is None:
        _, axes = plt.subplots(3, 1, figsize=(6, 5), sharex=True, layout="constrained")
    labels = "$x_e$ (mm)", "$y_e$ (mm)", r"$\alpha_e$ (°)"
    for ax, error, label in zip(axes, run.error, labels, strict=True):
        ax.axhline(0, color="0.8", lw=0.8)
        ax.plot(run.t, error, color=PALETTE["error"], lw=1.3)
        ax.set_ylabel(label)
    count_in_mm(axes[0].yaxis, axes[1].yaxis)
    count_in_degrees(axes[2].yaxis)
    axes[-1].set_xlabel("time (s)")
    return axes


def plot_wheels(run, ax=None):
    """Wheel speeds over time (Fig. 19).

    Parameters
    ----------
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib Axes
    """
    _check_run(run)
    if ax is None:
        _, ax = plt.subplots(figsize=(6, 3), layout="constrained")
    for speed, side, symbol in zip(run.wheels, ("right", "left"), ("$V_R$", "$V_L$"), strict=True):
        # A speed is held until the next time: stairs, not slopes.
        ax.step(
            run.t,
            speed,
            where="post",
            color=PALETTE[side],
            lw=1.3,
            label=f"{symbol} ({side})",
        )
    ax.set_xlabel("time (s)")
    ax.set_ylabel("wheel speed (mm/s)")
    count_in_mm(ax.yaxis)
    ax.legend(frameon=False)
    return ax


def animate(world, plan, run, ax=None, frames=40):
    """The robot driving along its plan.

    Parameters
    ----------
    world : World
        Obstacles.
    plan : Plan
        What was planned.
    run : Run
        What one robot drove.
    ax : matplotlib Axes, optional
        Where to draw.
    frames : int, optional
        Number of pictures.

    Returns
    -------
    matplotlib FuncAnimation
        Keep it, and pass it to `as_gif` to show it.
    """
    _check_run(run, _check_plan(plan))
    frames = checks.whole("frames", frames, 1)
    if frames > MOST_FRAMES:
        raise InvalidParameter(f"frames is {checks.shown(frames)}; give at most {MOST_FRAMES}")
    ax = plot_plan(world, plan, ax)
    x, y, _ = run.pose
    (trail,) = ax.plot([], [], color=PALETTE["tracked"], lw=1.3, zorder=5, label="tracked")
    disc, nose = draw_robot(run.pose[:, 0], run.robot, ax)
    disc.set_alpha(0.8)

    def show(when):
        trail.set_data(x[: when + 1], y[: when + 1])
        move_robot(disc, nose, run.pose[:, when])
        return trail, disc, nose

    times = np.linspace(0, len(x) - 1, frames).astype(int)
    return FuncAnimation(ax.figure, show, frames=times, interval=100, blit=True)
