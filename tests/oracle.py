"""Shortest paths among discs by exhaustion, without any of freeseg's geometry.

A shortest path that keeps its distance from discs consists of common tangents
of circles round them and of arcs on these, so it is one of all ordered choices
of these circles, each driven round either way. Points are complex numbers.
"""

import cmath
import math

#: What round-off may take from a clearance (m) and from a whole turn (rad).
ROUND_OFF = 1e-9


def tangent(a, signed_a, b, signed_b):
    """Ends of the tangent from one oriented circle to another, or None."""
    sine = (signed_b - signed_a) / abs(b - a)
    if abs(sine) > 1:
        return None
    # The left normal: the line has it turned by acos(sine) from the line of centres.
    normal = (b - a) / abs(b - a) * cmath.exp(1j * math.acos(sine))
    return a - signed_a * normal, b - signed_b * normal


def line_is_clear(first, last, centers, keep):
    """Whether the segment stays `keep` from every centre."""
    along = last - first
    for center, distance in zip(centers, keep, strict=True):
        share = ((center - first) * along.conjugate()).real / max(abs(along) ** 2, 1e-300)
        nearest = first + min(max(share, 0), 1) * along
        if abs(center - nearest) < distance - ROUND_OFF:
            return False
    return True


def arc_is_clear(middle, first, turned, centers, keep):
    """Whether the arc from `first`, round `middle`, stays `keep` from every centre."""
    last = middle + (first - middle) * cmath.exp(1j * turned)
    for center, distance in zip(centers, keep, strict=True):
        nearest = min(abs(center - first), abs(center - last))
        if center != middle:
            ahead = cmath.phase((center - middle) / (first - middle))
            if math.copysign(1, turned) * ahead % (2 * math.pi) <= abs(turned):
                nearest = min(nearest, abs(abs(center - middle) - abs(first - middle)))
        if nearest < distance - ROUND_OFF:
            return False
    return True


def shortest(start, goal, centers, keep):
    """Length of the shortest path, and the way it goes.

    Parameters
    ----------
    start, goal : tuple
        Positions (m).
    centers : sequence of tuple
        Centres of the discs (m).
    keep : sequence of float
        Distance that the path keeps from each centre (m).

    Returns
    -------
    float, list of (int, int)
        Length (m), infinite where there is no path that turns round no disc
        twice; disc and sense (1 counter-clockwise) of every turn.
    """
    start, goal = complex(*start), complex(*goal)
    centers = [complex(*center) for center in centers]
    best = [math.inf, []]

    def extend(way, circle, arrived, length):
        """Try the goal and every unused circle next, from where a circle was reached.

        A choice ends where it collides or cannot become the shortest any more.
        """
        used = {index for index, _ in way}
        options = [(goal, 0.0, None)]
        options += [
            (center, sense * radius, (index, sense))
            for index, (center, radius) in enumerate(zip(centers, keep, strict=True))
            for sense in (1, -1)
            if index not in used
        ]
        center, signed = circle
        for target, signed_target, turn in options:
            ends = tangent(center, signed, target, signed_target)
            if ends is None:
                continue
            leave, join = ends
            turned = 0.0
            if signed:
                sense = math.copysign(1, signed)
                turned = sense * (
                    sense * cmath.phase((leave - center) / (arrived - center)) % (2 * math.pi)
                )
                # A tangent that grazes its circle turns by nothing, not by a whole turn.
                if abs(turned) > 2 * math.pi - ROUND_OFF:
                    turned = 0.0
            total = length + abs(signed * turned) + abs(join - leave)
            if (
                total + abs(goal - join) >= best[0]
                or not line_is_clear(leave, join, centers, keep)
                or (turned and not arc_is_clear(center, arrived, turned, centers, keep))
            ):
                continue
            if turn is None:
                best[:] = total, way
            else:
                extend([*way, turn], (target, signed_target), join, total)

    extend([], (start, 0.0), start, 0.0)
    return best[0], best[1]
