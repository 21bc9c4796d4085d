"""What lesson 02 shows, against the package and against what it says of it."""

import numpy as np
import pytest
from lessons import lesson

import freeseg as fs
from freeseg.segments import MARGIN

STEM = "02_find_free_segments"


def test_segments_are_the_packages_on_all_five_tables(robot, tables):
    segments_of, length, is_safe = lesson(
        STEM, "segments_of", "length", "is_safe", "free_segment", "gaps"
    )[:3]
    for world in tables.values():
        expected = fs.free_segments(world, robot, MARGIN)
        for ends, segment in zip(segments_of(world), expected, strict=True):
            assert np.allclose(segment.ends, ends, rtol=0, atol=1e-15)
            assert segment.length == pytest.approx(length(ends), rel=0, abs=1e-15)
            assert segment.safe == is_safe(ends)


def test_counts_agree_with_the_captions():
    rows = lesson(STEM, "rows", "row", "segments_of", "free_segment", "is_safe")[0]
    safe = {k: row[-1] for k, row in enumerate(rows, 1)}
    assert safe[1] == 6
    assert safe[5] == 0
    assert all(0 < safe[k] < 6 for k in (2, 3, 4))
    for row in rows:
        assert sum("danger" in str(cell) for cell in row[1:-1]) == 6 - row[-1]


def test_pages_of_the_flipbook_say_what_the_package_counts(robot, tables):
    deltas, count_safe = lesson(STEM, "deltas", "count_safe", "gaps", "free_segment")[:2]
    counts = []
    for delta in deltas:
        label = count_safe(delta)
        counts.append(sum(one.safe for one in fs.free_segments(tables[1], robot, delta)))
        assert label.startswith(f"δ = {1000 * delta:.0f} mm: {counts[-1]} of 6 safe")
        danger = label.partition("danger: ")[2]
        assert len([one for one in danger.split(", ") if one]) == 6 - counts[-1]
    assert counts == sorted(counts, reverse=True)
    assert (counts[0], counts[-1]) == (6, 0)


def test_each_segment_closes_just_beyond_what_is_printed(robot, tables):
    gaps, order = lesson(STEM, "gaps", "order", "free_segment")[:2]
    for count, name in enumerate(order):
        closing = gaps[name] - robot.diameter
        for delta, danger in ((closing - 1e-9, count), (closing + 1e-9, count + 1)):
            segments = fs.free_segments(tables[1], robot, delta)
            assert sum(not segment.safe for segment in segments) == danger


def test_the_margin_of_the_sketches_tells_safe_from_danger(robot):
    sketches = [
        fs.plotting.sketch_segment(length, robot, margin=0.03).get_title()
        for length in (0.215, 0.155)
    ]
    assert [title.partition(":")[0] for title in sketches] == ["safe", "danger"]
    # The robot itself would fit through both.
    assert robot.diameter < 0.155


def test_nearest_points_of_two_polygons_have_a_corner_among_them(robot):
    mixed = lesson(STEM, "mixed", "legend_below")[0]
    segments = fs.free_segments(mixed, robot, MARGIN)
    ends = segments[1].ends
    corners = np.concatenate([mixed[1].vertices, mixed[2].vertices])
    assert min(np.hypot(*(corners - end).T).min() for end in ends) < 1e-12
    # The other end lies on an edge, and so does the first segment's.
    assert max(np.hypot(*(corners - end).T).min() for end in ends) > 0.01
    assert np.hypot(*(mixed[1].vertices - segments[0].ends[1]).T).min() > 0.01


def test_endpoints_lie_on_their_obstacles_and_end_safe_segments():
    endpoints, segments, outer, worlds = lesson(
        STEM, "endpoints", "segments", "outer", "worlds", "legend_below", "draw_map"
    )[:4]
    for endpoint in endpoints:
        disc = worlds[4][endpoint.obstacle]
        assert np.hypot(*(endpoint.point - disc.center)) == pytest.approx(disc.radius)
        assert endpoint.segment is None or segments[endpoint.segment].safe
    assert len(endpoints) - outer == 2 * sum(segment.safe for segment in segments)
    # Every disc can be turned round, wherever the robot comes from.
    assert {end.obstacle for end in endpoints if end.segment is None} == set(range(7))
