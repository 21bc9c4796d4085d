import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import freeseg as fs
from freeseg.path import Arc, Line, Path
from freeseg.smoothing import moving_average


def chain(curvatures, lengths):
    """A path of lines and arcs, begun at (1, 2) to the north."""
    pieces, x, y, theta = [], 1.0, 2.0, np.pi / 2
    for curvature, length in zip(curvatures, lengths, strict=True):
        if curvature:
            radius, side = 1 / abs(curvature), np.sign(curvature)
            toward = theta + side * np.pi / 2
            center = (x + radius * np.cos(toward), y + radius * np.sin(toward))
            piece = Arc(center, radius, toward + np.pi, side * length / radius)
        else:
            piece = Line((x, y), (x + length * np.cos(theta), y + length * np.sin(theta)))
        pieces.append(piece)
        x, y, theta = map(float, piece.at(piece.length))
    return Path(pieces)


WINDING = chain([0, 10, 0, -12, 11, 0], [0.2, 0.15, 0.02, 0.1, 0.25, 0.3])


def test_average_is_that_of_samples():
    course = moving_average(WINDING, 0.03)
    s = np.linspace(0.015, WINDING.length - 0.015, 97)
    # The middles of 3000 slices of each window.
    offsets = (np.arange(3000) + 0.5) / 3000 * 0.03 - 0.015
    x, y, *_ = WINDING.at(s[:, None] + offsets)
    smooth = course(s)
    assert_allclose(smooth.x, x.mean(1), atol=1e-10)
    assert_allclose(smooth.y, y.mean(1), atol=1e-10)


def test_rates_are_those_of_differences():
    course = moving_average(WINDING, 0.03)
    # Away from where a window meets a joint.
    s = np.linspace(0, WINDING.length, 1001)
    breaks = np.add.outer(WINDING.joints, [-0.015, 0.015]).ravel()
    s = s[np.abs(s[:, None] - breaks).min(1) > 1e-5]
    step = 1e-6
    before, here, after = (course(s + shift) for shift in (-step, 0, step))
    way = here.stretch * 2 * step
    assert_allclose(np.hypot(after.x - before.x, after.y - before.y), way, rtol=1e-6)
    heading = np.arctan2(after.y - before.y, after.x - before.x)
    assert_allclose(np.cos(heading - here.theta), 1, atol=1e-12)
    assert_allclose((after.theta - before.theta) / way, here.curvature, atol=1e-5)
    rate = (after.curvature - before.curvature) / way
    assert_allclose(rate, here.curvature_rate, atol=1e-3)


def test_curvature_has_no_steps_and_is_that_of_the_path_where_a_window_holds_one_piece():
    course = moving_average(WINDING, 0.03)
    s = np.linspace(0, WINDING.length, 20001)
    smooth = course(s)
    # Ramps over the window, from one curvature to the next: at most 23 in 30 mm, a little steeper
    # since the average is the shorter way.
    steepest = 23 / 0.03 * 1.02
    assert np.abs(np.diff(smooth.curvature)).max() <= steepest * np.diff(s).max()
    alone = np.abs(s[:, None] - WINDING.joints).min(1) > 0.015
    *_, curvature = WINDING.at(s[alone])
    # On an arc, the average is a circle of radius R sinc(w / 2R).
    radius = 1 / np.where(curvature, curvature, np.inf)
    assert_allclose(
        smooth.curvature[alone] * np.sinc(0.015 * curvature / np.pi),
        curvature,
        rtol=1e-9,
        atol=1e-9,
    )
    assert (radius[curvature == 0] == 0).all()


def test_zero_width_is_the_path_itself():
    s = np.linspace(0, WINDING.length, 100).reshape(4, 25)
    smooth = moving_average(WINDING, 0)(s)
    for got, expected in zip(
        (smooth.x, smooth.y, smooth.theta, smooth.curvature), WINDING.at(s), strict=True
    ):
        assert_allclose(got, expected, rtol=0, atol=0)
    assert (smooth.stretch == 1).all()
    assert (smooth.curvature_rate == 0).all()


@given(
    st.lists(
        st.tuples(st.sampled_from([0, 4, -7, 14, -14]), st.floats(0.002, 0.5)),
        min_size=1,
        max_size=6,
    ),
    st.floats(0.001, 0.07),
)
def test_ends_stay_and_the_shift_is_bounded(parts, width):
    path = chain(*zip(*parts, strict=True))
    width = min(width, path.length)
    s = np.linspace(0, path.length, 500)
    smooth, (x, y, theta, _) = moving_average(path, width)(s), path.at(s)
    shift = np.hypot(smooth.x - x, smooth.y - y)
    sharpest = max(abs(curvature) for curvature, _ in parts)
    assert shift.max() <= sharpest * width**2 / 24 + 1e-10
    assert_allclose(shift[[0, -1]], 0, atol=1e-10)
    # The heading follows that of the path, without whole turns, and differs by what a window turns.
    assert np.abs(smooth.theta - theta).max() <= sharpest * width / 2 + 1e-9


def test_window_longer_than_a_radius():
    with pytest.raises(fs.InvalidParameter, match=r"radius 0\.0833\S* m of the arc .* 0\.37\S* m"):
        moving_average(WINDING, 0.09)
