"""A path without curvature steps: its moving average."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import wrap_angle
from freeseg.path import Arc, Line, Path


class Curve(NamedTuple):
    """Where a curve is at parameters s, and how it changes there; shapes (...).

    Position x, y (m) and heading theta (rad); stretch, the length of the curve
    per s; curvature, the turn per length (1/m), and its rate per length (1/m^2).
    """

    x: np.ndarray
    y: np.ndarray
    theta: np.ndarray
    stretch: np.ndarray
    curvature: np.ndarray
    curvature_rate: np.ndarray


def moving_average(path: Path, width: float) -> Callable[[ArrayLike], Curve]:
    """A path, averaged over a window that slides along it.

    The average of the position has a box filter's tangent and so, but for
    the turn within a window, a box filter's curvature: its steps become
    ramps as long as the window. Nothing adds up along the path: lines stay
    where they are but for half a window at their ends, and so do the path's
    ends.

    Parameters
    ----------
    path : Path
        Lines and arcs.
    width : float
        Width w of the window (m), at most the path's length; zero for the
        path itself.

    Returns
    -------
    callable
        ``course(s) -> Curve``, for arc lengths s of the path (m), which the
        window is centred on.

    Raises
    ------
    InvalidParameter
        For what is no path, or a window that is negative, longer than the path
        or than the radius of an arc.

    Notes
    -----
    With p the path and P' = p, the average is (P(s + w/2) - P(s - w/2)) / w,
    and its derivatives are such differences of p, p' and p''. It is away
    from p(s) by at most w^2 / 24 times the largest curvature. Beyond an end,
    the path goes on as its mirror image through the end point: so the
    average begins and ends where the path does.
    """
    checks.instance("path", path, Path, "a Path, such as plan.path")
    width = checks.not_negative("width", width)
    if not width:
        return _unsmoothed(path)
    if width > path.length:
        raise InvalidParameter(
            f"width is {width:g} m, and the path is {path.length:g} m long; give at most that"
        )
    tightest = int(np.argmax([abs(piece.curvature) for piece in path.pieces]))
    bend = abs(path.pieces[tightest].curvature)
    if width * bend > 1:
        raise InvalidParameter(
            f"smoothing is over a window of {width:g} m, longer than the radius {1 / bend:g} m of "
            f"the arc that begins at {path.joints[tightest]:.4f} m; give at most that"
        )
    longer = _continued(path)

    def course(s):
        s = np.asarray(s, float)
        window = path.length + s[..., None] + np.array([-0.5, 0.5]) * width
        x, y, theta, curvature = longer.at(window)
        tangent = np.stack([np.cos(theta), np.sin(theta)])
        normal = np.stack([-tangent[1], tangent[0]])
        (x, y), first, second, third = (
            np.diff(values)[..., 0] / width
            for values in (_primitive(longer, window), (x, y), tangent, curvature * normal)
        )
        stretch = np.hypot(*first)
        middle = path.at(s)[2]
        theta = middle + wrap_angle(np.arctan2(first[1], first[0]) - middle)
        bend = (first[0] * second[1] - first[1] * second[0]) / stretch**3
        rate = (first[0] * third[1] - first[1] * third[0]) / stretch**3
        rate -= 3 * bend * (first * second).sum(0) / stretch**2
        return Curve(x, y, theta, stretch, bend, rate / stretch)

    return course


def _unsmoothed(path):
    """The path itself as a course, with its steps of the curvature."""

    def course(s):
        x, y, theta, curvature = path.at(s)
        return Curve(x, y, theta, np.ones_like(x), curvature, np.zeros_like(x))

    return course


def _continued(path):
    """A path between its mirror images through both of its ends."""
    before = [_mirrored(piece, path.start) for piece in reversed(path.pieces)]
    after = [_mirrored(piece, path.end) for piece in reversed(path.pieces)]
    return Path([*before, *path.pieces, *after])


def _mirrored(piece, point):
    """A piece's image through a point, driven so that the other end comes first."""
    x, y = 2 * point[0], 2 * point[1]
    if isinstance(piece, Line):
        return Line((x - piece.end[0], y - piece.end[1]), (x - piece.start[0], y - piece.start[1]))
    center = (x - piece.center[0], y - piece.center[1])
    return Arc(center, piece.radius, piece.start_angle + piece.sweep + math.pi, -piece.sweep)


def _primitive(path, s):
    """Integral of the position along a path, shape (2, ...), but for a constant."""
    interval = np.searchsorted(path.joints[1:-1], s, side="right")
    total, before = np.empty((2, *s.shape)), np.zeros(2)
    for index, piece in enumerate(path.pieces):
        here = interval == index
        along = np.append(s[here] - path.joints[index], piece.length)
        if isinstance(piece, Line):
            integral = np.outer(piece.start, along)
            integral += np.outer(np.subtract(piece.end, piece.start) / piece.length, along**2 / 2)
        else:
            angle = piece.start_angle + piece.curvature * along
            arc = np.stack([np.sin(angle), -np.cos(angle)])
            first = [[math.sin(piece.start_angle)], [-math.cos(piece.start_angle)]]
            turned = piece.radius / piece.curvature * (arc - first)
            integral = np.outer(piece.center, along) + turned
        total[:, here] = before[:, None] + integral[:, :-1]
        before += integral[:, -1]
    return total
