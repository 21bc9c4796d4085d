import base64
import re
from io import BytesIO

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
import shapely
from matplotlib.collections import EllipseCollection, PolyCollection
from matplotlib.patches import Circle
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

import freeseg as fs
from freeseg.plotting import PALETTE
from freeseg.segments import find_endpoints

MINUS = "\N{MINUS SIGN}"
GROUP = mpl.colors.to_rgba(PALETTE["group"])
ROBOT = mpl.colors.to_rgb(PALETTE["robot"])


@pytest.fixture(autouse=True)
def no_window_and_no_trace(monkeypatch):
    """Draw without a screen; nothing may be shown, nor global settings changed."""

    def show(*args, **kwargs):
        raise AssertionError("a figure was shown")

    plt.switch_backend("Agg")
    monkeypatch.setattr(plt, "show", show)
    monkeypatch.setattr(plt.Figure, "show", show)
    before = dict(mpl.rcParams)
    yield
    plt.close("all")
    assert dict(mpl.rcParams) == before


@pytest.fixture(scope="module")
def world():
    """Three obstacles in the way of a line: two discs and a polygon, one danger segment."""
    triangle = fs.Polygon([(0.55, -0.1), (0.65, 0.1), (0.45, 0.1)])
    return fs.World([fs.Disc((0.2, 0.35), 0.05), fs.Disc((0.3, 0.1), 0.05), triangle])


@pytest.fixture(scope="module")
def plan(world):
    return fs.plan(world, (0, 0), (1, 0))


@pytest.fixture(scope="module")
def run(plan, robot):
    reference = fs.make_reference(plan.path, robot)
    return fs.simulate(fs.SlidingMode(), reference, robot, initial_offset=(0, 0.02, 0.2))


def labels(ax):
    return [label for label in ax.get_legend_handles_labels()[1] if not label.startswith("_")]


def line_labelled(ax, label):
    (line,) = (line for line in ax.lines if line.get_label() == label)
    return line


def ticks(axis):
    """Where an axis has its ticks, and what is written there, as numbers."""
    places = axis.get_majorticklocs()
    written = axis.get_major_formatter().format_ticks(places)
    return places, [float(text.replace(MINUS, "-")) for text in written]


def assert_map_in_mm(ax):
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (mm)", "y (mm)")
    assert ax.get_aspect() == 1
    for axis in ax.xaxis, ax.yaxis:
        places, written = ticks(axis)
        assert len(places) > 1
        assert_allclose(written, 1000 * places, atol=1e-6)


def drawn_segments(line):
    """Ends of the segments that one line draws, shape (n, 2, 2)."""
    rows = line.get_xydata().reshape(-1, 3, 2)
    assert np.isnan(rows[:, 2]).all()  # the gaps
    return rows[:, :2]


def test_plot_world_draws_every_obstacle_with_its_number(world, ax):
    assert fs.plotting.plot_world(world, ax) is ax
    assert_map_in_mm(ax)
    discs, polygons = ax.collections
    assert isinstance(discs, EllipseCollection)
    assert_allclose(discs.get_offsets(), [(0.2, 0.35), (0.3, 0.1)])
    for diameters in discs.get_widths(), discs.get_heights():
        assert_allclose(diameters, (0.1, 0.1))
    assert isinstance(polygons, PolyCollection)
    (outline,) = polygons.get_paths()
    assert_allclose(outline.vertices[:-1], world.obstacles[2].vertices)
    for collection in discs, polygons:
        assert_allclose(collection.get_facecolor(), [mpl.colors.to_rgba(PALETTE["obstacle"])])
    assert [text.get_text() for text in ax.texts] == ["1", "2", "3"]
    assert_allclose(ax.texts[1].xy, (0.3, 0.1))
    assert world.cores[2].contains(shapely.Point(ax.texts[2].xy))
    # All of them are in view.
    assert ax.get_xlim()[0] <= 0.15
    assert ax.get_xlim()[1] >= 0.65
    assert ax.get_ylim()[0] <= -0.1
    assert ax.get_ylim()[1] >= 0.4


def test_numbers_stand_beside_small_discs_and_on_large_ones(tables, ax):
    world = tables[1]
    fs.plotting.plot_world(world, ax)
    ax.figure.canvas.draw()
    for disc, text in zip(world, ax.texts, strict=True):
        middle = ax.transData.transform(disc.center)
        edge = ax.transData.transform(disc.center + disc.radius * np.eye(2)[0])
        written = ax.transData.inverted().transform(text.get_window_extent().get_points().mean(0))
        apart = np.hypot(*(ax.transData.transform(written) - middle))
        # Either its number is in the middle, or it hides nothing of the disc.
        if disc.radius > 0.03:
            assert apart < 3
        else:
            assert apart > edge[0] - middle[0] + 4
            assert (written - disc.center) @ (disc.center - [0.355, 0.39]) > 0


def test_discs_are_as_large_on_the_canvas_as_circles(world, ax):
    fs.plotting.plot_world(world, ax, numbers=False)
    ax.figure.canvas.draw()
    discs = ax.collections[0]
    unit_circle, *_ = discs.get_paths()
    to_canvas = mpl.transforms.Affine2D(discs.get_transforms()[0]) + discs.get_transform()
    size = to_canvas.transform_path(unit_circle).get_extents().size
    corners = ax.transData.transform([(0, 0), (0.1, 0.1)])  # of a square as wide as the discs
    assert_allclose(size, corners[1] - corners[0])


def test_plot_world_without_numbers(world, ax):
    fs.plotting.plot_world(world, ax, numbers=False)
    discs, polygons = ax.collections
    assert len(discs.get_offsets()) + len(polygons.get_paths()) == 3
    assert not ax.texts


def test_plot_world_of_no_obstacle(ax):
    assert fs.plotting.plot_world(fs.World([]), ax) is ax
    assert len(ax.patches) == 0
    assert len(ax.collections) == 0


def grid_of_discs(count):
    """Small discs in rows of a hundred."""
    return fs.World([fs.Disc((0.2 * (k % 100), 0.2 * (k // 100)), 0.05) for k in range(count)])


def test_numbers_are_left_out_where_they_would_hide_the_world():
    for count, numbers, written in (
        (100, None, 100),
        (101, None, 0),
        (101, True, 101),
        (100, False, 0),
    ):
        ax = fs.plotting.plot_world(grid_of_discs(count), numbers=numbers)
        assert len(ax.texts) == written


def test_ten_thousand_discs_are_as_few_artists_as_one():
    one, many = grid_of_discs(1), grid_of_discs(10_000)
    few = [len(fs.plotting.plot_world(one, numbers=False).get_children())]
    ax = fs.plotting.plot_world(many)
    assert [len(ax.get_children())] == few
    assert len(ax.collections[0].get_offsets()) == 10_000


def test_a_plan_through_rooms_stays_in_the_picture_of_its_world(robot, ax):
    world = fs.random_world(100, seed=0)
    plan = fs.plan_rooms(world, (0, 0), (3.3, 3.3))
    assert plan.segments
    fs.plotting.plot_plan(world, plan, ax)
    inside = np.concatenate([world.edges.reshape(-1, 2), [plan.path.start, plan.path.end]])
    beyond = world.radii.max() + robot.diameter
    assert (ax.dataLim.min >= inside.min(0) - beyond).all()
    assert (ax.dataLim.max <= inside.max(0) + beyond).all()


def test_functions_open_a_figure_where_they_are_given_none(world, plan, run):
    for draw in (
        lambda: fs.plotting.plot_world(world),
        lambda: fs.plotting.plot_segments(plan.segments),
        lambda: fs.plotting.plot_path(plan.path),
        lambda: fs.plotting.plot_plan(world, plan),
        lambda: fs.plotting.plot_step(world, plan, plan.steps[-1]),
        lambda: fs.plotting.plot_tracking(world, plan, run),
        lambda: fs.plotting.plot_wheels(run),
        lambda: fs.plotting.plot_errors(run)[0],
    ):
        before = plt.get_fignums()
        figure = draw().figure
        assert plt.get_fignums() == [*before, figure.number]


def test_plot_segments_tells_safe_from_danger(plan, ax):
    assert [segment.safe for segment in plan.segments] == [True, False]
    assert fs.plotting.plot_segments(plan.segments, ax, lengths=True) is ax
    assert_map_in_mm(ax)
    assert labels(ax) == ["safe segment", "danger segment"]
    for line, segment in zip(ax.lines, plan.segments, strict=True):
        assert_allclose(drawn_segments(line), [segment.ends])
        assert line.get_color() == PALETTE["safe" if segment.safe else "danger"]
    written = [text.get_text() for text in ax.texts]
    assert written == [f"{1000 * segment.length:.0f}" for segment in plan.segments]
    middles = [segment.ends.mean(0) for segment in plan.segments]
    assert_allclose([text.xy for text in ax.texts], middles)


def test_plot_segments_labels_each_kind_once(tables, ax):
    segments = fs.free_segments(tables[2])
    fs.plotting.plot_segments(segments, ax)
    assert sorted(labels(ax)) == ["danger segment", "safe segment"]
    assert len(segments) == 6
    for kind, safe in (("safe segment", True), ("danger segment", False)):
        ends = [segment.ends for segment in segments if segment.safe == safe]
        assert_allclose(drawn_segments(line_labelled(ax, kind)), ends)
    assert len(ax.texts) == 0


def test_plot_segments_names_the_ends_as_the_paper_does(tables, ax):
    segments = fs.free_segments(tables[1])
    fs.plotting.plot_segments(segments, ax, names=True)
    assert [text.get_text() for text in ax.texts] == [f"$p_{{{k}}}$" for k in range(2, 14)]
    ends = np.concatenate([segment.ends for segment in segments])
    assert_allclose([text.xy for text in ax.texts], ends)


def test_text_on_segments_hides_less_than_a_box(plan, ax):
    fs.plotting.plot_segments(plan.segments, ax, lengths=True, names=True)
    assert all(text.get_bbox_patch() is None and text.get_path_effects() for text in ax.texts)


def test_plot_endpoints_tells_ends_of_segments_from_outer_ones(tables, ax):
    segments = fs.free_segments(tables[4])
    endpoints = find_endpoints(tables[4], segments)
    assert fs.plotting.plot_endpoints(endpoints, ax) is ax
    assert_map_in_mm(ax)
    for label, outer, fill in (
        ("end of a safe segment", False, PALETTE["turning"]),
        ("outer endpoint", True, "white"),
    ):
        line = line_labelled(ax, label)
        points = [end.point for end in endpoints if (end.segment is None) == outer]
        assert_allclose(line.get_xydata(), points)
        assert line.get_markerfacecolor() == fill
        # They leave the numbers of the discs readable.
        assert line.get_markersize() < 5


def test_plot_endpoints_of_none(ax):
    fs.plotting.plot_endpoints([], ax)
    assert not ax.lines


def test_plot_path_draws_the_centre_line(plan, ax):
    assert fs.plotting.plot_path(plan.path, ax, color="red", label="a path", lw=5) is ax
    assert_map_in_mm(ax)
    (line,) = ax.lines
    assert_allclose(line.get_xydata(), plan.path.sample(0.002))
    assert (line.get_color(), line.get_label(), line.get_linewidth()) == ("red", "a path", 5)


def test_plot_circle(ax):
    assert fs.plotting.plot_circle((0.1, 0.2), 0.05, ax, label="dangerous circle") is ax
    (circle,) = ax.patches
    assert_allclose((*circle.center, circle.radius), (0.1, 0.2, 0.05))
    assert not circle.get_fill()
    assert labels(ax) == ["dangerous circle"]


def test_plot_query(ax):
    assert fs.plotting.plot_query((0.1, 0.2), (0.3, 0.4), ax) is ax
    assert_allclose(line_labelled(ax, "start").get_xydata(), [(0.1, 0.2)])
    assert_allclose(line_labelled(ax, "goal").get_xydata(), [(0.3, 0.4)])


def test_plot_band_is_as_wide_as_the_robot(plan, robot, ax):
    assert fs.plotting.plot_band(plan.path, robot, ax) is ax
    (band,) = ax.patches
    low = band.get_xy().min(0)
    # Left of the start, by the radius; its round ends are polygons.
    assert low[0] == pytest.approx(-robot.radius, abs=1e-4)
    assert labels(ax) == ["swept by the robot"]


def test_plot_plan_draws_all_of_it(world, plan, ax):
    assert fs.plotting.plot_plan(world, plan, ax) is ax
    assert_map_in_mm(ax)
    assert plan.turning_points
    circles = [patch for patch in ax.patches if isinstance(patch, Circle) and not patch.get_fill()]
    expected = [(*turn.center, turn.radius) for turn in plan.turning_points]
    assert_allclose([(*circle.center, circle.radius) for circle in circles], expected)
    assert sorted(labels(ax)) == [
        "danger segment",
        "dangerous circle",
        "goal",
        "planned path",
        "safe segment",
        "start",
        "swept by the robot",
    ]
    way = line_labelled(ax, "planned path").get_xydata()
    assert_allclose(way[[0, -1]], [(0, 0), (1, 0)], atol=1e-12)


def test_plot_step_draws_its_candidates_and_its_choice(world, plan, ax):
    step = plan.steps[1]
    assert step.chosen
    assert fs.plotting.plot_step(world, plan, step, ax) is ax
    assert_map_in_mm(ax)
    assert ax.get_title() == f"step 1: {step.kind}"
    chosen = line_labelled(ax, "turning point chosen")
    assert_allclose(chosen.get_xydata(), [step.chosen.endpoint.point])
    way = line_labelled(ax, "path after this step").get_xydata()
    assert_allclose(way, step.path.sample(0.002))
    # All of them, and told by their shape from the one chosen.
    candidates = line_labelled(ax, "candidate")
    points = [candidate.endpoint.point for candidate in step.candidates]
    assert_allclose(candidates.get_xydata(), points)
    assert len(points) > 1
    assert candidates.get_marker() != chosen.get_marker()
    assert candidates.get_color() != chosen.get_color()
    assert candidates.get_markersize() < chosen.get_markersize()


def test_plot_step_marks_what_blocked_the_leg_and_the_path_before(world, plan, ax):
    step = plan.steps[1]
    fs.plotting.plot_step(world, plan, step, ax)
    (outline,) = (patch for patch in ax.patches if patch.get_label() == "blocking obstacle")
    blocking = world.obstacles[step.blocking]
    if isinstance(blocking, fs.Disc):
        assert_allclose(outline.center, blocking.center)
    else:
        assert_allclose(outline.get_xy()[:-1], blocking.vertices)
    before = line_labelled(ax, "path before").get_xydata()
    assert_allclose(before, plan.steps[0].path.sample(0.002))
    assert_allclose(line_labelled(ax, "leg searched").get_xydata(), step.leg)
    arcs = [piece for piece in step.path.pieces if hasattr(piece, "radius")]
    circles = [patch for patch in ax.patches if patch.get_linestyle() == "--"]
    assert_allclose([c.radius for c in circles], [arc.radius for arc in arcs])


def test_plot_step_fills_a_group(ax):
    world = fs.World([fs.Disc((0.5, y), 0.05) for y in (-0.1, 0.05, 0.6)])
    plan = fs.plan(world, (0, 0), (1, 0))
    step = plan.steps[-1]
    assert step.group == (0, 1)
    fs.plotting.plot_step(world, plan, step, ax)
    filled = [patch.center for patch in ax.patches if patch.get_facecolor() == GROUP]
    assert_allclose(filled, [(0.5, -0.1), (0.5, 0.05)])
    assert "group" in labels(ax)


def test_plot_step_of_the_straight_way_has_no_turning_point(world, plan, ax):
    fs.plotting.plot_step(world, plan, plan.steps[0], ax)
    assert ax.get_title() == "step 0: straight"
    assert not {"turning point chosen", "candidate", "path before", "blocking obstacle"} & set(
        labels(ax)
    )


def test_plot_step_writes_numbers_inside_of_large_obstacles_and_beside_small_ones(ax):
    world = fs.World([fs.Disc((0.5, 0), 0.1), fs.Disc((0.5, 0.5), 0.01)])
    plan = fs.plan(world, (0, 0), (1, 0))
    fs.plotting.plot_step(world, plan, plan.steps[-1], ax)
    assert [text.get_text() for text in ax.texts] == ["1", "2"]
    assert_allclose([text.xy for text in ax.texts], [(0.5, 0), (0.51, 0.5)])
    assert [text.get_ha() for text in ax.texts] == ["center", "left"]


def test_one_legend_below_names_each_thing_once(world, plan):
    figure, axes = plt.subplots(1, 2, layout="constrained")
    for ax, step in zip(axes, plan.steps, strict=False):
        fs.plotting.plot_step(world, plan, step, ax)
    legend = fs.plotting.legend_below(figure)
    named = [text.get_text() for text in legend.get_texts()]
    assert len(named) == len(set(named))
    assert set(named) == set(labels(axes[0])) | set(labels(axes[1]))
    figure.canvas.draw()
    # It hides nothing.
    assert legend.get_window_extent().y1 < min(ax.get_tightbbox().y0 for ax in axes)


def robots_in(ax, robot):
    """Where robots are drawn, as x, y and heading, one a row."""
    circles = [patch for patch in ax.patches if isinstance(patch, Circle)]
    bodies = [patch for patch in circles if patch.get_facecolor()[:3] == ROBOT]
    assert all(patch.radius == robot.radius for patch in bodies)
    to_data = [patch.get_data_transform() - ax.transData for patch in bodies]
    ends = np.array([place.transform([(0, 0), (1, 0)]) for place in to_data]).reshape(-1, 2, 2)
    ahead = ends[:, 1] - ends[:, 0]
    return np.column_stack([ends[:, 0], np.arctan2(ahead[:, 1], ahead[:, 0])])


def test_plot_tracking_draws_the_driven_path_on_the_planned_one(world, plan, run, robot, ax):
    assert fs.plotting.plot_tracking(world, plan, run, ax) is ax
    assert_map_in_mm(ax)
    planned, tracked = (line_labelled(ax, label) for label in ("planned path", "tracked"))
    assert_array_equal(tracked.get_xydata(), run.pose[:2].T)
    assert {"planned path", "tracked", "start", "goal"} <= set(labels(ax))
    poses = robots_in(ax, robot)
    assert len(poses) == 6
    assert_allclose(poses[[0, -1]], run.pose[:, [0, -1]].T, atol=1e-12)
    # On top, cased in white, and narrower than what it must not hide.
    assert tracked.zorder > planned.zorder
    (casing,) = tracked.get_path_effects()
    assert casing._gc["foreground"] == "white"
    assert planned.get_linewidth() > casing._gc["linewidth"] > tracked.get_linewidth()


def test_plot_run_draws_as_many_robots_as_asked_for(run, robot, ax):
    for count in (0, 1, 3):
        ax.clear()
        assert fs.plotting.plot_run(run, ax, robots=count) is ax
        assert len(robots_in(ax, robot)) == count
        assert labels(ax) == ["tracked"]


def test_plot_errors_in_mm_and_degrees(run):
    axes = plt.figure().subplots(3)
    assert fs.plotting.plot_errors(run, axes) is axes
    for ax, error, factor in zip(axes, run.error, (1000, 1000, 180 / np.pi), strict=True):
        curve = ax.lines[-1]
        assert_array_equal(curve.get_xdata(), run.t)
        assert_array_equal(curve.get_ydata(), error)
        places, written = ticks(ax.yaxis)
        assert len(places) > 1
        assert_allclose(written, factor * places, atol=1e-6)
        # Round numbers of mm and of degrees.
        assert_array_equal(written, np.round(written, 1))
    assert [re.sub(r".*\((.*)\)", r"\1", ax.get_ylabel()) for ax in axes] == ["mm", "mm", "°"]
    assert axes[-1].get_xlabel() == "time (s)"


def test_plot_wheels_in_mm_per_second(run, ax):
    assert fs.plotting.plot_wheels(run, ax) is ax
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time (s)", "wheel speed (mm/s)")
    for line, speed, side in zip(ax.lines, run.wheels, ("right", "left"), strict=True):
        assert_array_equal(line.get_ydata(), speed)
        assert line.get_drawstyle() == "steps-post"
        assert side in line.get_label()
        assert line.get_color() == PALETTE[side]
    assert len(ax.get_legend().get_texts()) == 2
    places, written = ticks(ax.yaxis)
    assert_allclose(written, 1000 * places, atol=1e-6)


def test_ticks_in_mm_are_written_as_matplotlib_would(ax):
    for limits, places, written in (
        ((-0.3, 13), [-0.25, -0.0, 0.1 + 0.2, 12.5], [f"{MINUS}250", "0", "300", "12500"]),
        # As many decimals each, without those of round-off.
        ((0, 0.01), [0, 0.0025, 0.005, 0.01], ["0.0", "2.5", "5.0", "10.0"]),
        ((0, 1e-9), [0, 5e-10, 1e-9], ["0.0000000", "0.0000005", "0.0000010"]),
    ):
        ax.set(xlim=limits, xticks=places)
        fs.plotting.count_in_mm(ax.xaxis)
        assert ax.xaxis.get_major_formatter().format_ticks(places) == written
    # Under the mouse, too.
    assert "(x, y) = (123.4, " in ax.format_coord(0.1234, 0)


def test_ticks_in_mm_on_a_logarithmic_axis(ax):
    ax.loglog([1e-6, 1], [1, 2])
    fs.plotting.count_in_mm(ax.xaxis)
    written = ax.xaxis.get_major_formatter().format_ticks([1e-6, 1e-3, 1])
    assert written == ["0.001", "1", "1000"]


def test_ticks_in_degrees_stand_at_round_numbers(ax):
    ax.set(ylim=(-np.pi / 2, np.pi / 2))
    fs.plotting.count_in_degrees(ax.yaxis)
    places, written = ticks(ax.yaxis)
    assert_allclose(np.radians(written), places, atol=1e-12)
    assert {-80, -60, -40, -20, 0, 20, 40, 60, 80} <= set(written)
    assert f"{MINUS}20" in ax.yaxis.get_major_formatter().format_ticks(places)


def test_animation_ends_where_the_robot_does_and_becomes_a_gif(world, plan, run, robot, ax):
    animation = fs.plotting.animate(world, plan, run, ax, frames=3)
    html = fs.display.as_gif(animation, dpi=30).data
    assert plt.get_fignums() == []
    data = re.fullmatch(r'<img alt="[^"]+" src="data:image/gif;base64,([^"]+)">', html)[1]
    picture = Image.open(BytesIO(base64.b64decode(data)))
    assert (picture.format, picture.n_frames) == ("GIF", 3)
    # What the last frame has left.
    assert_array_equal(line_labelled(ax, "tracked").get_xydata(), run.pose[:2].T)
    assert_allclose(robots_in(ax, robot), [run.pose[:, -1]], atol=1e-12)


def test_animation_is_600_pixels_wide_and_shows_the_wheel_speeds(world, plan, run):
    animation = fs.plotting.animate(world, plan, run, frames=3)
    assert animation._fig.get_size_inches()[0] * 100 == 600
    (ax,) = animation._fig.axes
    (gauge,) = ax.child_axes
    assert gauge.get_ylabel() == "wheel speed (mm/s)"
    left, right = gauge.patches
    assert [text.get_text() for text in gauge.get_xticklabels()] == ["left", "right"]
    for when in np.linspace(0, len(run.t) - 1, 3).astype(int):
        animation._func(when)
        assert [right.get_height(), left.get_height()] == [*run.wheels[:, when]]
        written = [f"{1000 * speed:.0f}" for speed in run.wheels[::-1, when]]
        assert [text.get_text() for text in gauge.texts] == [*written, f"{run.t[when]:.1f} s"]
    low, high = gauge.get_ylim()
    assert low <= run.wheels.min()
    assert run.wheels.max() <= high
    animation._draw_was_started = True  # it was never to be shown


def test_no_legend_covers_data(run, ax):
    fs.plotting.plot_wheels(run, ax)
    ax.figure.draw_without_rendering()
    legend = ax.get_legend().get_window_extent()
    assert ax.transData.transform((0, run.wheels.max()))[1] < legend.y0


@pytest.mark.filterwarnings("error")
def test_a_robot_that_stands_still_is_drawn(robot, ax):
    still = fs.drive(lambda t, pose: (0, 0), (0, 0, 0), 0.1, 5, robot)
    fs.plotting.plot_wheels(still, ax)
    low, high = ax.get_ylim()
    assert low < 0 < high


def test_show_table_is_markdown():
    table = fs.display.show_table(["case", "length (mm)"], [["13a", 805.2], ["13b", None]])
    assert table.data.splitlines() == [
        "| case | length (mm) |",
        "| --- | --- |",
        "| 13a | 805.2 |",
        "| 13b | None |",
    ]


def test_palette_names_its_colours():
    assert {"robot", "planned", "tracked", "safe", "danger", "turning"} <= set(PALETTE)
    assert all(mpl.colors.is_color_like(color) for color in PALETTE.values())
    assert len(set(PALETTE.values())) == len(PALETTE)


def test_two_robots_in_one_picture_are_refused(world, plan, robot):
    small = fs.KheperaIV(diameter=0.1, wheel_base=0.08)
    other = fs.simulate(fs.SlidingMode(), fs.make_reference(plan.path, small))
    for draw in (fs.plotting.plot_tracking, fs.plotting.animate):
        with pytest.raises(fs.InvalidParameter, match="give those of one robot"):
            draw(world, plan, other)


def test_a_batch_is_not_drawn(world, plan):
    reference = fs.make_reference(plan)
    batch = fs.simulate(fs.SlidingMode(), reference, initial_offset=np.zeros((3, 2)))
    for draw in (
        lambda: fs.plotting.plot_tracking(world, plan, batch),
        lambda: fs.plotting.plot_errors(batch),
        lambda: fs.plotting.plot_wheels(batch),
    ):
        with pytest.raises(fs.InvalidParameter, match="draw one robot"):
            draw()


def test_what_are_no_plane_axes_is_refused_by_every_function(world, plan, run, robot):
    figure = plt.figure()
    for bad in (figure, figure.subplots(2), 3, plt, figure.add_subplot(projection="3d")):
        for draw in (
            lambda ax: fs.plotting.map_axes(ax),
            lambda ax: fs.plotting.plot_world(world, ax),
            lambda ax: fs.plotting.plot_segments(plan.segments, ax),
            lambda ax: fs.plotting.plot_path(plan.path, ax),
            lambda ax: fs.plotting.plot_circle((0, 0), 0.1, ax),
            lambda ax: fs.plotting.plot_query((0, 0), (1, 0), ax),
            lambda ax: fs.plotting.plot_plan(world, plan, ax),
            lambda ax: fs.plotting.plot_band(plan.path, robot, ax),
            lambda ax: fs.plotting.plot_step(world, plan, plan.steps[0], ax),
            lambda ax: fs.plotting.plot_group(world, [0], ax),
            lambda ax: fs.plotting.plot_tracking(world, plan, run, ax),
            lambda ax: fs.plotting.draw_robot((0, 0, 0), robot, ax),
            lambda ax: fs.plotting.plot_wheels(run, ax),
            lambda ax: fs.plotting.animate(world, plan, run, ax, 3),
        ):
            with pytest.raises(fs.InvalidParameter, match=r"ax is .*give one plane Axes"):
                draw(bad)


def test_errors_are_drawn_on_three_axes(run):
    for axes in (plt.figure().subplots(2), [], plt.figure().add_subplot()):
        with pytest.raises(fs.InvalidParameter, match=r"axes is .*give three Axes"):
            fs.plotting.plot_errors(run, axes)


def test_a_plan_is_drawn_and_measured_in_its_own_world(world, plan, run):
    copy = fs.World([*world])
    fs.plotting.plot_plan(copy, plan)
    assert fs.metrics.planning(copy, plan) == fs.metrics.planning(world, plan)
    moved = fs.World([fs.Disc((0.2, 0.36), 0.05), *world.obstacles[1:]])
    for other in (moved, fs.World([]), fs.load_table(1)):
        for use in (
            lambda world: fs.plotting.plot_plan(world, plan),
            lambda world: fs.plotting.plot_step(world, plan, plan.steps[0]),
            lambda world: fs.plotting.plot_tracking(world, plan, run),
            lambda world: fs.plotting.animate(world, plan, run),
            lambda world: fs.metrics.planning(world, plan),
        ):
            with pytest.raises(fs.InvalidParameter, match=r"in another world.* give plan.world"):
                use(other)


def test_what_cannot_be_drawn_is_named(world, plan, robot, ax):
    step = fs.plan(world, (0, 0), (1, 0)).steps[0]
    for draw, named in (
        (lambda: fs.plotting.plot_circle((0, 0), -0.1, ax), "radius is -0.1"),
        (lambda: fs.plotting.plot_query((0, 0), (1, 0, 0), ax), "goal has shape"),
        (lambda: fs.plotting.plot_band(plan, robot, ax), "path is .* such as plan.path"),
        (lambda: fs.plotting.plot_group(world, [99], ax), r"group is \[99\].* below 3"),
        (lambda: fs.plotting.plot_step(world, plan, step), "step is .* one of plan.steps"),
        (lambda: fs.plotting.draw_robot((0, 0), robot, ax), "pose has shape"),
        (lambda: fs.plotting.plot_world(world, numbers="yes"), "numbers is 'yes'"),
        (lambda: fs.plotting.plot_segments(plan.segments, lengths="yes"), "lengths is 'yes'"),
        (lambda: fs.plotting.plot_path(plan.path, color="planned"), "color is 'planned'"),
        (lambda: fs.plotting.count_in_mm(ax), "axes is"),
    ):
        with pytest.raises((fs.InvalidParameter, fs.InvalidQuery), match=named):
            draw()
