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
    column, exponent = lesson(STEM, "names", "columns", "scale", "column", "exponent")[3:]
    column.__globals__["scale"] = [
        {"shape": "disc", "n": n, "t": 1e-3 * n**1.5} for n in (10, 1000, 2000, 5000)
    ]
    assert exponent("t", "disc").startswith("1.50 [1.50, 1.50]")
