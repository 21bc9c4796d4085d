"""Sketches of segments, detours, tangents and dangerous circles: drawn to scale, and named."""

import numpy as np
import pytest
import shapely
from drawn import texts
from matplotlib.patches import Circle, Ellipse
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import (
    PALETTE,
    plot_detours,
    sketch_literal_circle,
    sketch_segment,
    sketch_tangent,
)

pytestmark = pytest.mark.usefixtures("ax")


def circles(ax):
    return [patch for patch in ax.patches if isinstance(patch, Circle)]


def path_drawn(ax):
    return [line for line in ax.lines if line.get_color() == PALETTE["planned"]]


def test_a_segment_is_as_long_as_asked_for_and_says_whether_it_is_safe(robot, ax):
    for length, kind in ((0.2, "safe"), (0.15, "danger"), (robot.diameter + 0.03, "safe")):
        ax.clear()
        assert sketch_segment(length, robot, 0.03, ax) is ax
        assert ax.get_title().startswith(kind)
        (segment,) = (line for line in ax.lines if len(line.get_xdata()) == 2 and line.get_lw() > 2)
        assert segment.get_color() == PALETTE[kind]
        assert_allclose(np.ptp(segment.get_xdata()), length)
        first, second, *_ = circles(ax)
        gap = second.center[0] - first.center[0] - first.radius - second.radius
        assert_allclose(gap, length)
        # The dashed circle is the robot with its margin.
        assert any(np.isclose(circle.radius, robot.radius + 0.015) for circle in circles(ax))


def test_a_segment_and_what_must_fit_through_are_named(ax):
    sketch_segment(0.2, ax=ax)
    assert {"$p_2$", "$p_3$", "$SP_1$", "$D_r$", r"$D_r+\delta$"} < set(texts(ax))


def test_detours_are_equally_long_all_over_an_ellipse(ax):
    start, goal = np.array([0.4, 0.0]), np.array([0.5, 0.75])
    assert plot_detours(start, goal, [0.8, 1.0], ax) is ax
    ellipses = [patch for patch in ax.patches if isinstance(patch, Ellipse)]
    for length, ellipse in zip((0.8, 1.0), ellipses, strict=True):
        points = ellipse.get_patch_transform().transform(
            np.transpose([np.cos(np.arange(9)), np.sin(np.arange(9))])
        )
        detours = np.hypot(*(points - start).T) + np.hypot(*(points - goal).T)
        assert_allclose(detours, length)
    assert texts(ax) == ["800", "1000"]
    # Its length is written on it.
    for length, text in zip((0.8, 1.0), ax.texts, strict=True):
        place = np.array(text.get_position())
        assert_allclose(np.hypot(*(place - start)) + np.hypot(*(place - goal)), length)


def test_no_detour_is_as_short_as_the_straight_line(ax):
    with pytest.raises(fs.InvalidParameter, match=r"lengths has 1 m; start and goal are 1 m apart"):
        plot_detours((0, 0), (1, 0), [2, 1], ax)


def test_tangents_touch_the_circle_at_right_angles(ax):
    assert sketch_tangent(ax) is ax
    (circle,) = circles(ax)
    center = np.array(circle.center)
    ends = [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 2]
    tangent = [
        line
        for line in ends
        if np.isclose(np.hypot(*(line[1] - center)), circle.radius) and not line[0].any()
    ]
    assert len(tangent) == 2
    for start, join in tangent:
        assert_allclose((join - start) @ (join - center), 0, atol=1e-12)
    assert {"$D$", "$R$", r"$\beta$", r"$\sqrt{D^2-R^2}$"} < set(texts(ax))


@pytest.mark.parametrize("degrees", [0, 15, 20, 21, 35, 60, 90])
def test_what_is_filled_is_where_the_robot_is_too_near(robot, ax, degrees):
    phi, r, margin = np.radians(degrees), 0.039, 0.005
    assert sketch_literal_circle(phi, r, robot, margin, ax) is ax
    obstacle, turn, body = circles(ax)
    assert_allclose([obstacle.radius, body.radius], [r, robot.radius])
    assert_allclose(turn.radius, robot.radius + margin / 2)
    assert_allclose(turn.center, (0, r))
    distance = turn.radius - r * (1 - np.cos(phi))
    assert_allclose(np.hypot(*body.center) - r, distance)
    (path,) = path_drawn(ax)
    line = shapely.LineString(path.get_xydata())
    # The arc is drawn by chords.
    assert line.distance(shapely.Point(0, 0)) - r == pytest.approx(distance, abs=1e-4)
    filled = any(
        patch.get_facecolor()[:3] == (170 / 255, 51 / 255, 119 / 255) for patch in ax.patches
    )
    assert filled == (distance < robot.radius)
    assert {"$r$", "$R_D$", "$d$", "$P_{tp}$"} <= set(texts(ax))


def test_a_turn_by_more_than_half_a_circle_is_refused(ax):
    with pytest.raises(fs.InvalidParameter, match=r"angle is 2 rad; give one from 0 to pi / 2"):
        sketch_literal_circle(2, 0.04, ax=ax)
