import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from freeseg.geometry import (
    angle_of,
    arc_segment_distance,
    arc_sweep,
    cross,
    point_segment_distance,
    tangents,
    unit,
    wrap_angle,
)

SAMPLES = 401


def along(segments):
    """Points of segments (..., 2, 2), shape (..., SAMPLES, 2), and half their spacing."""
    tail, head = segments[..., :1, :], segments[..., 1:, :]
    share = np.linspace(0, 1, SAMPLES)[:, None]
    return tail + share * (head - tail), 0.5 * np.hypot(*(head - tail)[..., 0, :].T) / (SAMPLES - 1)


def along_arc(center, radius, start_angle, sweep):
    """Points of one arc, shape (SAMPLES, 2), and half their spacing."""
    angles = start_angle + sweep * np.linspace(0, 1, SAMPLES)
    return center + radius * unit(angles), 0.5 * radius * abs(sweep) / (SAMPLES - 1)


def nearest(a, b):
    """Least distance between two sets of points (n, 2)."""
    return np.hypot(*(a[:, None] - b).T).min()


def random_segments(rng, n):
    segments = rng.uniform(-1, 1, (n, 2, 2))
    segments[::7, 1] = segments[::7, 0]
    return segments


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [
        (0, 0),
        (np.pi, np.pi),
        (-np.pi, np.pi),
        (3 * np.pi, np.pi),
        (1.5 * np.pi, -0.5 * np.pi),
        (-1.5 * np.pi, 0.5 * np.pi),
        (7 + 20 * np.pi, 7 - 2 * np.pi),
    ],
)
def test_wrap_angle_by_hand(angle, wrapped):
    assert wrap_angle(angle) == pytest.approx(wrapped, abs=1e-14)


def test_wrap_angle_keeps_direction_and_range():
    angles = np.random.default_rng(1).uniform(-50, 50, 10_000)
    wrapped = wrap_angle(angles)
    assert_allclose(unit(wrapped), unit(angles), atol=1e-13)
    assert (wrapped > -np.pi).all()
    assert (wrapped <= np.pi).all()


def test_wrap_angle_never_gives_minus_pi():
    # The neighbours of odd multiples of pi round to either end of the range.
    odd = np.pi * np.arange(-9, 10, 2)
    beside = np.concatenate([np.nextafter(odd, np.inf), odd, np.nextafter(odd, -np.inf)])
    assert (wrap_angle(beside) > -np.pi).all()


def test_angle_of_inverts_unit():
    angles = np.linspace(-3, 3, 25).reshape(5, 5)
    assert unit(angles).shape == (5, 5, 2)
    assert_allclose(angle_of(unit(angles)), angles, atol=1e-14)


def test_cross_is_positive_to_the_left():
    assert cross(np.array([2.0, 0.0]), np.array([5.0, 3.0])) == 6
    assert cross(np.array([2.0, 0.0]), np.array([5.0, -3.0])) == -6


@pytest.mark.parametrize(
    ("a", "b", "leave", "join"),
    [
        # Two points: the straight line.
        (((0, 0), 0), ((3, 4), 0), (0, 0), (3, 4)),
        # Equal circles, both counter-clockwise: the robot passes on their right, below.
        (((0, 0), 1), ((5, 0), 1), (0, -1), (5, -1)),
        (((0, 0), -1), ((5, 0), -1), (0, 1), (5, 1)),
        # Opposite senses: the inner tangent, here of slope 3/4.
        (((0, 0), 3), ((10, 0), -3), (1.8, -2.4), (8.2, 2.4)),
        # From a point, round a circle with its centre on the left: 3-4-5.
        (((0, 0), 0), ((5, 0), 3), (0, 0), (3.2, -2.4)),
        (((0, 0), 0), ((5, 0), -3), (0, 0), (3.2, 2.4)),
    ],
)
def test_tangents_by_hand(a, b, leave, join):
    assert_allclose(tangents(*a, *b), (leave, join), atol=1e-14)


def test_tangents_touch_both_circles_on_the_right_side():
    rng = np.random.default_rng(2)
    center_a, center_b = rng.uniform(-1, 1, (2, 5000, 2))
    signed_a, signed_b = rng.uniform(-0.5, 0.5, (2, 5000))
    signed_a[::5] = 0
    signed_b[::3] = 0
    leave, join = tangents(center_a, signed_a, center_b, signed_b)

    distance = np.hypot(*(center_b - center_a).T)
    exists = np.abs(signed_b - signed_a) < distance
    assert 100 < (~exists).sum() < 1000
    assert_array_equal(np.isfinite(leave).all(-1), exists)
    assert_array_equal(np.isfinite(join).all(-1), exists)

    direction = unit(angle_of(join - leave))
    for center, signed, point in ((center_a, signed_a, leave), (center_b, signed_b, join)):
        to_center = (center - point)[exists]
        # Perpendicular to the radius, and the centre on the left for positive radii.
        assert_allclose((direction[exists] * to_center).sum(-1), 0, atol=1e-7)
        assert_allclose(cross(direction[exists], to_center), signed[exists], atol=1e-12)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (((0, 0), 3), ((1, 0), 1)),
        (((1, 0), -1), ((0, 0), -3)),
        (((0.5, 0.5), 0), ((0, 0), 1)),
        (((0, 0), 1), ((1, 0), -1)),  # overlapping: no inner tangent
        (((0, 0), 1), ((0, 0), 1)),
    ],
)
def test_tangents_are_nan_where_there_is_none(a, b):
    assert np.isnan(tangents(*a, *b)).all()


@pytest.mark.parametrize(
    ("sense", "last", "sweep"),
    [
        (1, (0, 1), np.pi / 2),
        (-1, (0, 1), -3 * np.pi / 2),
        (1, (0, -1), 3 * np.pi / 2),
        (-1, (0, -1), -np.pi / 2),
        (1, (-1, 0), np.pi),
        (-1, (-1, 0), -np.pi),
        (1, (1, 0), 0),
    ],
)
def test_arc_sweep_by_hand(sense, last, sweep):
    center = (3.0, -2.0)
    found = arc_sweep(center, sense, np.add(center, (1, 0)), np.add(center, last))
    assert found == pytest.approx(sweep, abs=1e-14)


def test_arc_sweep_leads_from_first_to_last():
    rng = np.random.default_rng(3)
    center, first, last = rng.uniform(-1, 1, (3, 1000, 2))
    sense = rng.choice([-1, 1], 1000)
    sweep = arc_sweep(center, sense, first, last)
    assert (sense * sweep >= 0).all()
    assert (np.abs(sweep) < 2 * np.pi).all()
    assert_allclose(
        unit(angle_of(first - center) + sweep), unit(angle_of(last - center)), atol=1e-13
    )


@pytest.mark.parametrize(
    ("point", "distance"),
    [((1, 3), 3), ((-3, 4), 5), ((5, 4), 5), ((2, 0), 0), ((1, 0), 0)],
)
def test_point_segment_distance_by_hand(point, distance):
    assert point_segment_distance(point, [(0, 0), (2, 0)]) == pytest.approx(distance)
    assert point_segment_distance(point, [(2, 0), (0, 0)]) == pytest.approx(distance)


def test_point_segment_distance_against_sampling():
    rng = np.random.default_rng(4)
    points, segments = rng.uniform(-1, 1, (500, 2)), random_segments(rng, 500)
    samples, half_spacing = along(segments)
    sampled = np.hypot(*np.moveaxis(samples - points[:, None], -1, 0)).min(1)
    exact = point_segment_distance(points, segments)
    assert (exact <= sampled + 1e-12).all()
    assert (sampled <= exact + half_spacing + 1e-12).all()


@pytest.mark.parametrize(
    ("sweep", "segment", "distance"),
    [
        (np.pi, [(-2, 3), (2, 3)], 2),  # above the upper half circle
        (np.pi, [(-2, -3), (2, -3)], 3),  # below: the arc's ends are nearest
        (-np.pi, [(-2, -3), (2, -3)], 2),  # clockwise, the lower half circle
        (np.pi, [(0, 0), (0, 5)], 0),  # crosses
        (np.pi, [(0, 0), (0, 0)], 1),  # the centre
        (np.pi, [(0.1, 0.5), (-0.1, 0.5)], 1 - np.hypot(0.1, 0.5)),  # inside
        (1.5 * np.pi, [(0, -3), (0, -2)], 1),  # ends at the lowest point
        (-1.5 * np.pi, [(0, 3), (0, 2)], 1),
        (0.5 * np.pi, [(-3, 0), (-2, 0)], np.hypot(2, 1)),
    ],
)
def test_arc_segment_distance_by_hand(sweep, segment, distance):
    assert arc_segment_distance((0, 0), 1, 0, sweep, segment) == pytest.approx(distance, abs=1e-14)


def test_arc_segment_distance_of_an_arc_of_no_sweep():
    # Such an arc is the point (1, 0): only its own distance counts, not the circle's.
    assert arc_segment_distance((0, 0), 1, 0, 0.0, [(-3, 0), (-3, 0)]) == pytest.approx(4)


def test_arc_segment_distance_against_sampling():
    rng = np.random.default_rng(6)
    n = 400
    centers, radii = rng.uniform(-1, 1, (n, 2)), rng.uniform(0.05, 1, n)
    start_angles, sweeps = rng.uniform(-7, 7, n), rng.uniform(-2 * np.pi, 2 * np.pi, n)
    segments = random_segments(rng, n)
    exact = arc_segment_distance(centers, radii, start_angles, sweeps, segments)
    assert (np.abs(sweeps) > np.pi).sum() > 100
    assert 50 < (exact < 1e-12).sum() < 300
    for number, distance in enumerate(exact):
        arc = centers[number], radii[number], start_angles[number], sweeps[number]
        (on_arc, half_arc), (on_segment, half_segment) = along_arc(*arc), along(segments[number])
        sampled = nearest(on_arc, on_segment)
        assert distance <= sampled + 1e-12
        assert sampled <= distance + half_arc + half_segment + 1e-12


def test_distances_broadcast():
    rng = np.random.default_rng(7)
    a, b = random_segments(rng, 4), random_segments(rng, 5)
    assert point_segment_distance(a[:, None, 0], b).shape == (4, 5)
    arcs = a[:, None, 0], np.full((4, 1), 0.2), np.zeros((4, 1)), np.full((4, 1), -2.0)
    table = arc_segment_distance(*arcs, b)
    assert table.shape == (4, 5)
    assert table[2, 3] == arc_segment_distance(a[2, 0], 0.2, 0, -2.0, b[3])
