"""Tests of problem set 1: unequal wheels, ends of arcs, gaps between rounded polygons."""

from typing import Any

import numpy as np
import shapely
from scipy.spatial import ConvexHull

from freeseg.robot import Robot
from freeseg.teaching.answered import numbers
from freeseg.teaching.check import Ask

__all__ = ["gap", "largest", "pen", "radii", "turn"]


def _drives(rng: np.random.Generator, count: int) -> list[tuple[Any, Any, float, float]]:
    """Rates (rad/s), radii (m), wheel base (m) and time (s) of some drives below half a turn.

    The first drives straight on, to the last bit; the second but for round-off.
    """
    drives: list[tuple[Any, Any, float, float]] = []
    while len(drives) < count:
        rates, sizes = rng.uniform(2, 9, 2), rng.uniform(0.018, 0.024, 2)
        base, dt = rng.uniform(0.08, 0.15), rng.uniform(0.3, 1.5)
        if not drives:  # products of small whole numbers and powers of two, which are exact
            rates = np.array([6.0, 5.0]) * rng.integers(26, 96) / 64
            sizes = np.array([20.0, 24.0]) / 1024
        elif len(drives) == 1:
            rates = rates[0] * sizes[0] / sizes * [1.0, 1 + 1e-15]
        if abs(rates @ (sizes * [1, -1])) / base * dt < 3:
            drives.append((rates, sizes, base, dt))
    return drives


def _called(number: int, turning: str) -> str:
    """What to call a drive of `_drives`, by its number."""
    return ("straight on", "all but straight on")[number] if number < 2 else turning


def _moved(pose: np.ndarray, rates: np.ndarray, sizes: np.ndarray, base: float, dt: float):
    """Pose of the middle of the axle after a drive."""
    return Robot(base, base, 1.0, 1e3, 1e3).move(pose, rates * sizes, dt)


def pen(ask: Ask, rng: np.random.Generator) -> None:
    """Where the pen of a robot with unequal wheels ends."""
    for number, (rates, sizes, base, dt) in enumerate(_drives(rng, 20)):
        pose, ahead = rng.uniform(-1, 1, 3), rng.uniform(0.03, 0.1)
        mine = numbers(
            ask("pen_after", pose, rates, sizes, base, ahead, dt),
            (2,),
            "give back x and y of the pen (m)",
        )
        x, y, theta = _moved(pose, rates, sizes, base, dt)
        true = np.array([x + ahead * np.cos(theta), y + ahead * np.sin(theta)])
        off = np.hypot(*(mine - true))
        if off < 1e-6:
            continue
        others = {
            "you give the middle of the axle, not the pen": (x, y),
            "right and left wheel are mixed up": _moved(pose, rates[::-1], sizes[::-1], base, dt),
            "the pen is ahead along the new heading, yours along the old one": (
                x + ahead * np.cos(pose[2]),
                y + ahead * np.sin(pose[2]),
            ),
        }
        for name, place in others.items():
            here = np.array(place[:2])
            if len(place) == 3:
                here = here + ahead * np.array([np.cos(place[2]), np.sin(place[2])])
            assert np.hypot(*(mine - here)) > 1e-6, name
        raise AssertionError(
            f"{_called(number, 'on an arc')}, after {dt:.2f} s, your pen is {1000 * off:.1f} mm "
            "from where it should be: each wheel has its own radius, the axle's middle drives an "
            "exact arc, and the pen sits ahead of it along the new heading"
        )


def radii(ask: Ask, rng: np.random.Generator) -> None:
    """Radii of the wheels, from where a drive ended."""
    for number, (rates, sizes, base, dt) in enumerate(_drives(rng, 20)):
        moved = _moved(np.zeros(3), rates, sizes, base, dt)
        drove = _called(number, f"with a turn of {np.degrees(moved[2]):.0f}°")
        mine = numbers(
            ask("radii_from", rates, base, dt, moved),
            (2,),
            f"of a drive {drove}, give back the right and the left radius (m)",
        )
        assert not np.allclose(mine, 1000 * sizes), "your radii are in mm; give them in m"
        right = np.allclose(mine, sizes, rtol=0, atol=1e-7)
        mixed_up = np.allclose(mine, sizes[::-1], rtol=0, atol=1e-7)
        assert right or not mixed_up, "right and left are mixed up"
        assert right, (
            f"of a drive {drove}, the radii are {1000 * sizes[0]:.3f} and "
            f"{1000 * sizes[1]:.3f} mm, yours {1000 * mine[0]:.3f} and {1000 * mine[1]:.3f}: the "
            "heading tells their difference, the chord their mean; an arc is longer than its chord"
        )


def turn(ask: Ask, rng: np.random.Generator) -> None:
    """Where a turn round a circle ends."""
    for start, center in rng.uniform(-1, 1, (20, 2, 2)):
        sweep = rng.uniform(10, 300) * rng.choice([-1, 1])
        mine = numbers(
            ask("turn_end", start, center, sweep), (3,), "give back x, y and heading (m, m, rad)"
        )
        turned = np.exp(1j * np.radians(sweep))
        spoke = complex(*(start - center)) * turned
        apart = np.hypot(*(start - center))
        assert abs(np.hypot(*(mine[:2] - center)) - apart) < 1e-9, (
            f"your robot leaves its circle: the start is {apart:.3f} m from the centre, your end "
            f"{np.hypot(*(mine[:2] - center)):.3f} m"
        )
        assert np.allclose(mine[:2] - center, [spoke.real, spoke.imag]), (
            f"a sweep of {sweep:.0f}° turns the spoke from the centre by that angle, "
            "counter-clockwise if positive: is it in radians where it has to be?"
        )
        ahead = np.exp(1j * mine[2])
        assert abs(ahead.real * spoke.real + ahead.imag * spoke.imag) < 1e-6 * apart, (
            "your heading is not along the circle, which is perpendicular to the spoke"
        )
        forward = (ahead * np.conj(spoke)).imag * np.sign(sweep) > 0
        assert forward, "your heading points back: driven clockwise, it is the other one"


def _polygon(rng: np.random.Generator, center: np.ndarray) -> tuple[np.ndarray, float]:
    """Corners of a convex polygon (m), counter-clockwise, and the radius that rounds them (m)."""
    points = center + rng.uniform(-0.1, 0.1, (7, 2))
    return points[ConvexHull(points).vertices], float(rng.uniform(0.01, 0.05))


def gap(ask: Ask, rng: np.random.Generator) -> None:
    """The free segment between two rounded polygons."""
    for _ in range(25):
        direction = np.exp(1j * rng.uniform(-np.pi, np.pi))
        first = _polygon(rng, rng.uniform(-1, 1, 2))
        second = _polygon(rng, first[0].mean(0) + 0.5 * np.array([direction.real, direction.imag]))
        mine = numbers(
            ask("gap", *first, *second), (2, 2), "give back both ends of the segment, as rows (m)"
        )
        cores = [shapely.Polygon(corners) for corners, _ in (first, second)]
        core_gap = shapely.distance(*cores)
        wanted = core_gap - first[1] - second[1]
        length = np.hypot(*(mine[1] - mine[0]))
        assert abs(length - core_gap) > 1e-9, (
            "your ends are on the polygons; what rounds them makes each reach out by its radius"
        )
        corners = min(np.hypot(*(a - b)) for a in first[0] for b in second[0])
        assert wanted > corners - first[1] - second[1] - 1e-9 or (
            abs(length - corners + first[1] + second[1]) > 1e-9
        ), "you measure between corners; here the nearest point of one polygon is on an edge"
        for end, core, (_, radius) in zip(mine, cores, (first, second), strict=True):
            away = shapely.distance(core, shapely.Point(end))
            assert abs(away - radius) < 1e-7, (
                f"your end is {1000 * away:.2f} mm from its polygon, whose radius is "
                f"{1000 * radius:.2f} mm; the first row belongs to the first polygon"
            )
        assert abs(length - wanted) < 1e-7, (
            f"your segment is {1000 * length:.2f} mm long; one of {1000 * wanted:.2f} mm joins "
            "them, too"
        )


def largest(ask: Ask, rng: np.random.Generator) -> None:
    """The largest robot for which enough segments are safe."""
    for count in range(1, 30):
        # Multiples of 2^-10, so that no sum depends on the order of its terms.
        lengths = rng.integers(20, 400, rng.integers(1, 9)) / 1024
        if rng.random() < 0.5:
            lengths = np.append(lengths, lengths[0])
        margin, wanted = rng.integers(0, 60) / 1024, int(rng.integers(1, len(lengths) + 2))
        if count == 1:
            wanted = len(lengths) + 1
        mine = float(
            numbers(ask("largest_robot", lengths, margin, wanted), (), "give back one diameter (m)")
        )

        def safe(diameter, lengths=lengths, margin=margin):
            return int((lengths >= diameter + margin).sum())

        told = f"of lengths {np.round(lengths, 3).tolist()} m, with a margin of {margin:.3f} m,"
        if safe(1e-9) < wanted:
            assert mine == 0, f"{told} no robot has {wanted} safe: give 0"
            continue
        assert mine > 0, f"{told} a small robot has {wanted} safe; yours has no size"
        assert safe(mine) >= wanted, (
            f"{told} only {safe(mine)} are safe for a robot of {mine:.4f} m, and {wanted} have to "
            "be: is the margin in it, and is a segment of exactly D_r + margin safe?"
        )
        assert safe(mine + 1e-6) < wanted, (
            f"{told} a robot larger than yours of {mine:.4f} m still has {wanted} safe: segments "
            "count, not obstacles"
        )
