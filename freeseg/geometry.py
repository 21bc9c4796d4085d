"""Plane geometry on arrays: angles, tangents of oriented circles, distances.

Every function broadcasts. Points are ``(..., 2)``, segments ``(..., 2, 2)``.
"""

import numpy as np
from numpy.typing import ArrayLike

#: How much nearer than touching two circles may be by round-off, relative to their distance.
TANGENCY = 1e-12

#: Stands for zero where a length of zero would be divided by.
TINY = np.finfo(float).tiny


def read_only(array: np.ndarray) -> np.ndarray:
    """The array itself, which can no longer be written to."""
    array.setflags(write=False)
    return array


def ranges(begins: ArrayLike, counts: ArrayLike) -> np.ndarray:
    """Indices of ranges, one range after the other.

    Parameters
    ----------
    begins, counts : array_like of int, shape (n,)
        First index of every range, and how many it has.

    Examples
    --------
    >>> ranges([5, 0], [2, 3]).tolist()
    [5, 6, 0, 1, 2]
    """
    begins, counts = np.asarray(begins), np.asarray(counts)
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) + np.repeat(begins - (ends - counts), counts)


def wrap_angle(angle: ArrayLike) -> np.ndarray:
    """Angle brought into (-pi, pi].

    Parameters
    ----------
    angle : array_like
        Angle (rad).

    Examples
    --------
    >>> float(wrap_angle(3 * np.pi))
    3.141592653589793
    """
    turned = np.array(np.pi - np.asarray(angle, float))
    # The modulus is slow, and leaves what is in range as it is.
    inside = (turned >= 0) & (turned < 2 * np.pi)
    wrapped = np.pi - np.mod(turned, 2 * np.pi, out=turned, where=~inside)
    # Round-off of the modulus can leave -pi.
    return np.where(wrapped <= -np.pi, np.pi, wrapped)


def unit(angle: ArrayLike) -> np.ndarray:
    """Unit vector(s) at an angle (rad), shape ``(..., 2)``."""
    angle = np.asarray(angle, float)
    vector = np.empty((*angle.shape, 2))
    np.cos(angle, out=vector[..., 0])
    np.sin(angle, out=vector[..., 1])
    return vector


def angle_of(vector: ArrayLike) -> np.ndarray:
    """Direction (rad) of vector(s) of shape ``(..., 2)``."""
    vector = np.asarray(vector, float)
    return np.arctan2(vector[..., 1], vector[..., 0])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Third component of the cross product of plane vectors ``(..., 2)``."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def tangents(
    center_a: ArrayLike, signed_a: ArrayLike, center_b: ArrayLike, signed_b: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Tangent lines from oriented circles to oriented circles.

    A circle's orientation is the sign of its radius: positive is driven
    round counter-clockwise (centre on the left), negative clockwise, and a
    radius of zero is a point. Two oriented circles have one common tangent
    along which the robot can leave the first and join the second.

    Parameters
    ----------
    center_a, center_b : array_like, shape (..., 2)
        Centres (m).
    signed_a, signed_b : array_like, shape (...)
        Signed radii (m).

    Returns
    -------
    leave, join : ndarray, shape (..., 2)
        Where the tangent leaves a and joins b (m); NaN where there is none:
        where one circle contains the other or, for opposite senses, where
        they overlap.

    Examples
    --------
    A point 5 m from the centre of a circle of radius 3 m: the tangent has
    length 4 m.

    >>> leave, join = tangents((0, 0), 0, (5, 0), 3)
    >>> float(round(np.hypot(*(join - leave)), 12))
    4.0
    """
    center_a, center_b = np.asarray(center_a, float), np.asarray(center_b, float)
    signed_a, signed_b = np.asarray(signed_a, float), np.asarray(signed_b, float)
    delta = center_b - center_a
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.hypot(delta[..., 0], delta[..., 1])
        # The left normal n of the line satisfies n.(b - a) = signed_b - signed_a.
        sine = (signed_b - signed_a) / distance
        # Circles that touch have a tangent, whatever round-off says.
        rest = 1 - sine**2
        cosine = np.sqrt(np.where(rest > -TANGENCY, np.maximum(rest, 0), np.nan))
        along = delta / distance[..., None]
    normal = np.stack(
        [
            sine * along[..., 0] - cosine * along[..., 1],
            cosine * along[..., 0] + sine * along[..., 1],
        ],
        axis=-1,
    )
    return center_a - signed_a[..., None] * normal, center_b - signed_b[..., None] * normal


def arc_sweep(center: ArrayLike, sense: ArrayLike, first: ArrayLike, last: ArrayLike) -> np.ndarray:
    """Signed angle driven round a centre from one point to another.

    Parameters
    ----------
    center, first, last : array_like, shape (..., 2)
        Centre, and points on the circle (m).
    sense : array_like, shape (...)
        1 counter-clockwise, -1 clockwise.

    Returns
    -------
    ndarray, shape (...)
        Angle (rad), of the sign of `sense`, smaller than a whole turn.
    """
    return sense * np.mod(
        sense * (angle_of(np.subtract(last, center)) - angle_of(np.subtract(first, center))),
        2 * np.pi,
    )


def point_segment_distance(points: ArrayLike, segments: ArrayLike) -> np.ndarray:
    """Distance from points to segments.

    Parameters
    ----------
    points : array_like, shape (..., 2)
        Points (m).
    segments : array_like, shape (..., 2, 2)
        Both ends of every segment (m); a segment may have length zero.

    Returns
    -------
    ndarray, shape (...)
        Distance (m).
    """
    points, segments = np.asarray(points, float), np.asarray(segments, float)
    tail = segments[..., 0, :]
    along = segments[..., 1, :] - tail
    from_tail = points - tail
    share = (from_tail * along).sum(-1) / np.maximum((along**2).sum(-1), TINY)
    gap = from_tail - np.clip(share, 0, 1)[..., None] * along
    return np.hypot(gap[..., 0], gap[..., 1])


def touching_points(center: ArrayLike, radius: ArrayLike, segments: ArrayLike) -> np.ndarray:
    """Points of segments where their distance from a circle can be smallest.

    Parameters
    ----------
    center : array_like, shape (..., 2)
        Centres (m).
    radius : array_like, shape (...)
        Radii (m), positive.
    segments : array_like, shape (..., 2, 2)
        Both ends of every segment (m).

    Returns
    -------
    ndarray, shape (..., 5, 2)
        Both ends, the foot of the centre, and the crossings (m). Seen from
        the centre, every nearest point of the circle is in the direction of
        one of them.
    """
    center, segments = np.asarray(center, float)[..., None, :], np.asarray(segments, float)
    radius = np.asarray(radius, float)[..., None]
    tail, along = segments[..., :1, :], segments[..., 1:, :] - segments[..., :1, :]
    length_squared = np.maximum((along**2).sum(-1), TINY)
    foot = ((center - tail) * along).sum(-1) / length_squared
    from_center = ((tail + foot[..., None] * along - center) ** 2).sum(-1)
    # Where the segment's line cuts the circle; at its foot where it does not.
    half_chord = np.sqrt(np.maximum(radius**2 - from_center, 0)) / np.sqrt(length_squared)
    share = np.concatenate([0 * foot, 0 * foot + 1, foot - half_chord, foot, foot + half_chord], -1)
    return tail + np.clip(share, 0, 1)[..., None] * along


def arc_segment_distance(
    center: ArrayLike,
    radius: ArrayLike,
    start_angle: ArrayLike,
    sweep: ArrayLike,
    segments: ArrayLike,
) -> np.ndarray:
    """Distance from arcs to segments, in closed form.

    The nearest pair is an end of the arc and a point of the segment, or it
    is in the direction of one of the `touching_points`.

    Parameters
    ----------
    center : array_like, shape (..., 2)
        Centres of the arcs (m).
    radius : array_like, shape (...)
        Radii (m), positive.
    start_angle, sweep : array_like, shape (...)
        First direction and signed angle covered (rad).
    segments : array_like, shape (..., 2, 2)
        Both ends of every segment (m).

    Returns
    -------
    ndarray, shape (...)
        Distance (m).
    """
    offset = touching_points(center, radius, segments) - np.asarray(center, float)[..., None, :]
    # A last axis over the candidate points of each pair of arc and segment.
    center, segments = np.asarray(center, float)[..., None, :], np.asarray(segments, float)
    radius, start_angle, sweep = (
        np.asarray(value, float)[..., None] for value in (radius, start_angle, sweep)
    )
    ends = center + radius[..., None] * unit(start_angle + sweep * [0.0, 1.0])
    turned = np.mod(np.where(sweep < 0, -1, 1) * (angle_of(offset) - start_angle), 2 * np.pi)
    to_circle = np.abs(np.hypot(offset[..., 0], offset[..., 1]) - radius)
    beside = np.where(turned <= np.abs(sweep), to_circle, np.inf).min(-1)
    return np.minimum(beside, point_segment_distance(ends, segments[..., None, :, :]).min(-1))
