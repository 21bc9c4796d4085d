import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Circle, Polygon, Rectangle
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.plotting import PALETTE

SKETCHES = ("sketch_pose", "sketch_turn", "sketch_sum", "sketch_step")


@pytest.fixture(autouse=True)
def no_figure_is_left():
    yield
    plt.close("all")


def corners(patch, ax):
    """Corners or rim of a patch, where it lies on the map (m)."""
    return (patch.get_transform() - ax.transData).transform(patch.get_path().vertices)


def test_a_robot_is_drawn_to_scale_and_moved(robot, ax):
    place = fs.plotting.draw_robot((0.1, 0.2, np.pi / 2), robot, ax)
    body, nose, right, left = ax.patches
    for x, y, heading in ((0.1, 0.2, np.pi / 2), (0.3, 0.4, 0)):
        assert fs.plotting.move_robot(place, (x, y, heading)) is place
        ahead = np.array([np.cos(heading), np.sin(heading)])
        to_left = np.array([-ahead[1], ahead[0]])
        rim = corners(body, ax) - (x, y)
        assert_allclose(np.abs(rim @ ahead).max(), 0.0704)
        for wheel, sign in ((right, -1), (left, 1)):
            edges = corners(wheel, ax) - (x, y)
            # The base is measured from the middle of one wheel to that of the other.
            assert_allclose(np.ptp(edges @ ahead), 2 * 0.021)
            middle = (edges @ to_left).min() + (edges @ to_left).max()
            assert_allclose(middle / 2, sign * 0.1054 / 2)
        tip = (corners(nose, ax) - (x, y)) @ ahead
        assert 0 < tip.min() < tip.max() < 0.0704
    kinds = [type(patch) for patch in (body, nose, right, left)]
    assert kinds == [Circle, Polygon, Rectangle, Rectangle]


def test_any_robot_is_drawn_in_its_own_sizes(ax):
    wide = fs.Robot(0.34, 0.44, 0.07, 10.0, 20.0)
    fs.plotting.draw_robot((0, 0, 0), wide, ax)
    body, _, right, _ = ax.patches
    assert body.radius == 0.22
    assert_allclose(corners(right, ax).mean(0)[0], -0.014, atol=0.02)
    # It is in view.
    assert ax.dataLim.width >= 0.44


def written(ax):
    return {text.get_text() for text in ax.texts} - {""}


@pytest.mark.parametrize(
    ("sketch", "symbols"),
    [
        ("sketch_pose", {"$x$", "$y$", r"$\alpha$", "$V_R$", "$V_L$", "$L$"}),
        ("sketch_turn", {"$V_R$", "$V_L$", "$V$", "$w$", "$L$", "$V/w$", "$V_R-V_L$"}),
        ("sketch_sum", {"$V$", r"$L\,w/2$", r"$-L\,w/2$", "$V_R$", "$V_L$"}),
        ("sketch_step", {r"$\alpha$", r"$\frac{w\,dt}{2}$", "chord"}),
    ],
)
def test_sketches_name_every_symbol_once_at_least(sketch, symbols):
    assert symbols <= written(getattr(fs.plotting, sketch)())


def overlap(first, second):
    return (
        first.x0 < second.x1
        and second.x0 < first.x1
        and first.y0 < second.y1
        and (second.y0 < first.y1)
    )


@pytest.mark.parametrize("sketch", SKETCHES)
@pytest.mark.parametrize("robot", [None, fs.Robot(0.34, 0.44, 0.07, 10.0, 20.0)])
def test_no_label_of_a_sketch_lies_on_another_or_outside(sketch, robot):
    ax = getattr(fs.plotting, sketch)(robot)
    ax.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text()]
    assert len(boxes) > 4
    frame = ax.figure.bbox
    for k, box in enumerate(boxes):
        assert frame.x0 <= box.x0 < box.x1 <= frame.x1
        assert frame.y0 <= box.y0 < box.y1 <= frame.y1
        assert not any(overlap(box, other) for other in boxes[:k])


def line_labelled(ax, label):
    (line,) = (line for line in ax.lines if line.get_label() == label)
    return line.get_xydata()


def test_plot_drive_draws_circles_round_one_centre(robot, ax):
    right, left, duration = 0.1, 0.05, 6
    assert fs.plotting.plot_drive(right, left, duration, robot, ax) is ax
    (center,) = line_labelled(ax, "centre of the turn")
    # V / w, by hand from (1).
    assert_allclose(center, (0, 0.1054 * 1.5 / 2 / 0.5))
    for label, radius in (
        ("middle of the axle", center[1]),
        ("right wheel", center[1] + 0.0527),
        ("left wheel", center[1] - 0.0527),
    ):
        assert_allclose(np.hypot(*(line_labelled(ax, label) - center).T), radius)
    end = robot.move((0, 0, 0), (right, left), duration)
    assert_allclose(line_labelled(ax, "middle of the axle")[-1], end[:2])


def test_plot_drive_straight_on_turns_round_nothing(robot, ax):
    fs.plotting.plot_drive(0.1, 0.1, 2, robot, ax)
    assert "centre of the turn" not in ax.get_legend_handles_labels()[1]
    assert_allclose(line_labelled(ax, "right wheel")[[0, -1]], [(0, -0.0527), (0.2, -0.0527)])


@pytest.mark.parametrize(
    ("wheels", "named"),
    [
        ((1, 0), "right is 1 m/s.*at most 0.9998"),
        ((0, -2), "left is -2 m/s"),
        (("", 0), "right is"),
    ],
)
def test_plot_drive_names_a_speed_that_no_wheel_reaches(robot, wheels, named):
    with pytest.raises(fs.InvalidParameter, match=named):
        fs.plotting.plot_drive(*wheels, 1, robot)


def test_limits_are_those_of_each_wheel(robot, ax):
    assert fs.plotting.plot_limits(robot, ax) is ax
    (diamond,) = ax.patches
    wheels = robot.to_wheels(*diamond.get_xy().T)
    assert_allclose(np.abs(wheels), robot.max_wheel_speed)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "forward speed V (mm/s)",
        "turn rate w (°/s)",
    )
    assert diamond.get_facecolor()[:3] == plt.matplotlib.colors.to_rgb(PALETTE["robot"])
