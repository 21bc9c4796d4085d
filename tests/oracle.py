"""Paths by other means, without any of freeseg's geometry.

A shortest path that keeps its distance from discs consists of common tangents
of circles round them and of arcs on these, so it is one of all ordered choices
of these circles, each driven round either way: `shortest` tries them all.
`shortest_way` does for polygons too, with Shapely to tell what is too close;
`may_and_must_connect` asks a grid whether there is any way. Points are complex
numbers.
"""

import cmath
import heapq
import itertools
import math

import numpy as np
import shapely
from scipy import ndimage

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


def _too_close(geometries, cores, keep):
    """Which geometries are nearer to any core than is kept from it."""
    distance = shapely.distance(np.array(cores, object)[:, None], np.array(geometries, object))
    return (distance < np.array(keep)[:, None] - ROUND_OFF).any(0)


def _rings(world, keep):
    """All outlines, with the distance that is kept from each."""
    for obstacle, distance in zip(world.obstacles, keep, strict=True):
        for ring in obstacle.rings:
            yield ring, distance


def _closed_angles(center, radius, world, keep):
    """A direction (rad) from the centre in every part of the circle that is too close."""
    angles = []
    for ring, distance in _rings(world, keep):
        corners = [complex(*corner) for corner in ring]
        reach = distance - ROUND_OFF
        for corner, following in zip(corners, corners[1:] + corners[:1], strict=True):
            # Where the circle crosses that round the corner, and the edge moved out and in.
            apart = abs(corner - center)
            if apart > 0:
                cosine = (radius**2 + apart**2 - reach**2) / (2 * radius * apart)
                angles.append((cosine, cmath.phase(corner - center)))
            if following != corner:
                normal = 1j * (following - corner) / abs(following - corner)
                level = ((corner - center) * normal.conjugate()).real
                angles += [((level + off) / radius, cmath.phase(normal)) for off in (reach, -reach)]
    ends = sorted(
        (base + sign * math.acos(cosine)) % (2 * math.pi)
        for cosine, base in angles
        if abs(cosine) <= 1
        for sign in (1, -1)
    )
    # Between two such ends all is free or all is closed, and the middle tells.
    ends = ends or [0.0]
    middles = [(a + b) / 2 for a, b in itertools.pairwise([*ends, ends[0] + 2 * math.pi])]
    points = [center + cmath.rect(radius, middle) for middle in middles]
    points = shapely.points([(point.real, point.imag) for point in points])
    return np.array(middles)[_too_close(points, world.cores, keep)]


def shortest_way(world, start, goal, keep):
    """Length of the shortest path among discs and polygons.

    All tangents between all corners' circles, and Dijkstra's search over how
    every circle is reached.

    Parameters
    ----------
    world : World
        Obstacles.
    start, goal : tuple
        Positions (m).
    keep : sequence of float
        Distance that the path keeps from each obstacle (m).

    Returns
    -------
    float
        Length (m), infinite where there is no path.
    """
    keep = world.radii + keep
    nodes = [(complex(*start), 0.0), (complex(*goal), 0.0)]
    for ring, distance in _rings(world, keep):
        corners = [complex(*corner) for corner in ring]
        for before, corner, after in zip(
            corners[-1:] + corners[:-1], corners, corners[1:] + corners[:1], strict=True
        ):
            # The material is on the left; nothing turns round one that is not convex.
            if len(corners) == 1 or ((after - corner) / (corner - before)).imag > 0:
                nodes += [(corner, distance), (corner, -distance)]
    ways = [
        (first, second, *ends)
        for first, second in itertools.permutations(range(len(nodes)), 2)
        if first != 1 and second != 0 and nodes[first][0] != nodes[second][0]
        if (ends := tangent(*nodes[first], *nodes[second])) is not None
    ]
    lines = shapely.linestrings([[(p.real, p.imag) for p in way[2:]] for way in ways])
    leaving = {}
    for way, closed in zip(ways, _too_close(lines, world.cores, keep), strict=True):
        if not closed:
            leaving.setdefault(way[0], []).append(way[1:])
    reached, seen, closed = [(0.0, 0, 0, nodes[0][0])], set(), {}
    count = itertools.count(1)
    while reached:
        length, _, node, arrived = heapq.heappop(reached)
        if node == 1:
            return length
        if (node, arrived) in seen:
            continue
        seen.add((node, arrived))
        center, signed = nodes[node]
        sense = math.copysign(1, signed)
        if signed and node not in closed:
            closed[node] = _closed_angles(center, abs(signed), world, keep)
        for target, leave, join in leaving.get(node, []):
            turned = 0.0
            if signed:
                turned = sense * cmath.phase((leave - center) / (arrived - center)) % (2 * math.pi)
                # A tangent that grazes its circle turns by nothing, not by a whole turn.
                turned = 0.0 if turned > 2 * math.pi - ROUND_OFF else turned
                ahead = sense * (closed[node] - cmath.phase(arrived - center)) % (2 * math.pi)
                if (ahead < turned).any():
                    continue
            total = length + abs(signed) * turned + abs(join - leave)
            heapq.heappush(reached, (total, next(count), target, join))
    return math.inf


def may_and_must_connect(world, start, goal, reach, cell):
    """Whether there may be, and whether there must be, a way for a disc.

    Places on a grid are free where they keep one and a half cells less, or
    more, than `reach`: a way for the disc stays among the first, and a way
    among the others is one for the disc.

    Parameters
    ----------
    world : World
        Obstacles.
    start, goal : tuple
        Positions (m).
    reach : float
        Distance to keep (m).
    cell : float
        Distance of neighbours on the grid (m).

    Returns
    -------
    may, must : bool
    """
    corners = np.concatenate([world.edges.reshape(-1, 2), [start, goal]])
    room = world.radii.max() + 3 * reach
    low, high = corners.min(0) - room, corners.max(0) + room
    distance = np.full(np.ceil((high - low) / cell).astype(int) + 1, np.inf)
    for obstacle, core in zip(world.obstacles, world.cores, strict=True):
        room = obstacle.radius + reach + 2 * cell
        box = np.reshape(core.bounds, (2, 2)) + room * np.array([[-1], [1]])
        first, last = np.clip(np.rint((box - low) / cell).astype(int), 0, distance.shape)
        part = tuple(slice(*ends) for ends in zip(first, last + 1, strict=True))
        x, y = low[:, None, None] + cell * np.mgrid[part]
        places, near = x + 1j * y, np.where(shapely.contains_xy(core, x, y), 0, np.inf)
        tails = np.concatenate(obstacle.rings) @ (1, 1j)
        heads = np.concatenate([np.roll(ring, -1, 0) for ring in obstacle.rings]) @ (1, 1j)
        for tail, along in zip(tails, heads - tails, strict=True):
            share = ((places - tail) * np.conj(along)).real / max(abs(along) ** 2, 1e-300)
            near = np.minimum(near, abs(places - tail - np.clip(share, 0, 1) * along))
        distance[part] = np.minimum(distance[part], near - obstacle.radius)
    answers = []
    for keep in (reach - 1.5 * cell, reach + 1.5 * cell):
        labels = ndimage.label(distance >= keep, structure=np.ones((3, 3)))[0]
        ends = [labels[tuple(np.rint((end - low) / cell).astype(int))] for end in (start, goal)]
        answers.append(bool(ends[0] and ends[0] == ends[1]))
    return tuple(answers)
