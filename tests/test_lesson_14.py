"""Notebook 14: the rooms are the lower hull, and what it counts is counted rightly."""

import numpy as np
from lessons import lesson

import freeseg as fs
from freeseg.triangulation import triangulate

STEM = "14_scale_the_planner"


def test_the_faces_seen_from_below_are_the_rooms():
    faces, world = lesson(STEM, "found", "hull", "sites", "seen_from_below", "world")[3:]
    rooms = triangulate(world).triangles
    assert set(map(tuple, np.sort(faces, axis=1))) == set(map(tuple, np.sort(rooms, axis=1)))


def test_a_segment_is_barred_by_a_third_obstacle():
    count_blocked, world = lesson(STEM, "count_blocked", "chain", "mesh", "world")[::3]
    chain = fs.free_segments(world)
    by_hand = 0
    for segment in chain:
        points = np.linspace(*segment.ends, 2000)
        others = [k for k in range(len(world)) if k not in segment.obstacles]
        by_hand += any(
            np.hypot(*(points - world[k].center).T).min() < world[k].radius for k in others
        )
    assert count_blocked(chain) == by_hand == 35


def test_exponent_is_the_slope_of_a_power_law():
    exponent = lesson(STEM, "exponent")
    n = np.array([10, 1000, 2000, 5000])
    # What is below 1000 does not count.
    assert exponent(n, np.where(n < 1000, 1.0, 1e-3 * n**1.5)) == "1.50 [1.50, 1.50]"


def test_a_column_is_of_one_shape():
    column, scale = lesson(STEM, "column", "scale")
    found = column("n", "disc")
    assert list(found) == [row["n"] for row in scale if row["shape"] == "disc"]
    assert found.max() == 10_000


def test_what_is_said_of_how_the_triangulation_grows():
    row_of, grown, by_rival, ratio, lost = lesson(
        STEM, "row_of", "grown", "by_rival", "ratio", "lost"
    )
    ends, slow = {}, {}
    for rival, (n, t) in by_rival.items():
        some = slow[rival] = t[n == 10_000]
        label, told, _, large = row_of(rival, n, t)
        assert (label, large) == (rival, f"{np.median(some):.0f}, {max(some):.0f} ({len(some)})")
        ends[rival] = [float(end) for end in told.partition("[")[2][:-1].split(", ")]
    # Its interval is within that of the exact planner, and above the slope of n log n.
    (low, high), (least, most) = ends["exact"], ends["triangulation"]
    assert low < least < most < high
    assert least > 1 + 1 / np.log(1000)
    assert ratio > 10
    assert slow["triangulation"].min() < ratio * slow["exact"].max()
    assert slow["triangulation"].max() > ratio * slow["exact"].min()
    assert all(row["outcome"] == "path" for row in grown if row["rival"] == "exact")
    assert 0 < lost < len(grown) / 2
