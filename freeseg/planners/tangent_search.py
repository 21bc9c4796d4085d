"""A* over tangents and arcs that makes a tangent only where the search arrives.

A shortest path of a disc among obstacles consists of common tangents of the
obstacles' dangerous circles and arcs on them (see J.-C. Latombe, *Robot Motion
Planning*, 1991, on generalised visibility graphs). A* (P. E. Hart, N. J. Nilsson,
B. Raphael, 1968) takes the most promising tangent first, and does with it what
the paper's loop does with a path: look for danger, drop it where something bars
it, else go on from where it leads. Two things are lazy: the tangents that leave a
circle are made when the search is there, the promising ones first (M. Yoshizumi,
T. Miura, T. Ishida, *AAAI* 2000), and whether one is free is asked when it is the
most promising of all (B. Cohen, M. Phillips, M. Likhachev, *RSS* 2014). The first
tangent that reaches the goal ends a shortest path: all others promised no better.

Loops over arrays and nothing else, so that numba can compile this file; see
`route`.
"""

import math
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

#: A tangent may come closer to an edge than its distance to keep by round-off (m), leave its
#: corner's normal cone by a sine of so much, and an arc be so many radians short of nothing.
NEARER, CONE, ANGLE = 1e-10, 1e-9, 1e-9

#: How much farther than needed a circle looks round at least, as a share of the straight line.
STEP = 1 / 256

#: The start and the goal are circles of radius zero.
START, GOAL = 0, 1

#: Columns of tangents: directions from the centres where it leaves one circle and joins the next
#: (rad), its length, the straight line on to the goal, the shortest way that leads to it (m), how
#: far the next circle can be driven round from there (rad); the oriented circles, twice the circle
#: and one more for clockwise; the tangent driven before; the tangents listed next of those that
#: leave the same and that join the same oriented circle; and what is known of it.
LEAVE, JOIN, LINE, TO_GOAL, DRIVEN, OPEN, FROM, TO, BEFORE, SIBLING, ARRIVAL, KNOWN = range(12)

#: What is known of a tangent: nothing yet, that it was driven, or that something bars it.
NOTHING, CLEAR, BARRED = 0, 1, 2


class Scene(NamedTuple):
    """Dangerous circles and edges, a grid over them, and room for notes.

    Parameters
    ----------
    circle : ndarray, shape (c, 6)
        Centres (m), and the unit normals between which a corner's free
        directions lie, counter-clockwise; zeros for a disc, which has all.
        First the start and the goal.
    radius : ndarray, shape (c,)
        Radii (m); negative for circles left out.
    largest, span : float
        The largest radius, and a length that no two points of interest are
        apart (m).
    edge : ndarray, shape (k, 4)
        Both ends of every edge (m).
    keep : ndarray, shape (k,)
        Distance to keep from each (m); zero for edges left out.
    corner : ndarray, shape (3,)
        Corner of the grid (m), and the size of a cell (m).
    cells : ndarray of int, shape (2,)
        How many cells the grid has along x and y.
    edge_first, edge_item : ndarray of int
        Edges that keep anything away from a point of a cell, one cell after
        the other, and where each cell's begin.
    circle_first, circle_item : ndarray of int
        Circles whose centre lies in a cell, likewise.
    stamp, mark : ndarray of int, shape (k,) and (1,)
        Which edges were asked in the present walk, and the number of that.
    seen : ndarray of int, shape (c,)
        Which circles were seen in the present view round, by its number.
    sector : ndarray, shape (p, 6)
        Unit vectors that everything in a view is to the left of.
    met : ndarray of bool, shape (k,)
        Edges that barred a tangent or an arc.
    hidden : ndarray, shape (p,)
        Distance (m) beyond which nothing is looked for, by heading: in so many
        parts of a turn headings are told apart.
    """

    circle: np.ndarray
    radius: np.ndarray
    largest: float
    span: float
    edge: np.ndarray
    keep: np.ndarray
    corner: np.ndarray
    cells: np.ndarray
    edge_first: np.ndarray
    edge_item: np.ndarray
    circle_first: np.ndarray
    circle_item: np.ndarray
    stamp: np.ndarray
    mark: np.ndarray
    seen: np.ndarray
    sector: np.ndarray
    met: np.ndarray
    hidden: np.ndarray


def search(scene):
    """The shortest route.

    Returns
    -------
    route : ndarray of int
        Oriented circles gone round, in driving order; empty where the
        straight line is free, and where there is no path.
    length : float
        Length of the route (m); infinite where there is none.
    reached : ndarray of bool, shape (2 c,)
        Oriented circles that the search came to.
    """
    oriented = 2 * len(scene.circle)
    lines, count = np.empty((256, 12)), 0
    leaving, joining = np.full(oriented, -1), np.full(oriented, -1)
    # How much longer than the way to it (m) an oriented circle was looked round for, and that way.
    looked, nearest = np.full(oriented, -math.inf), np.full(oriented, math.inf)
    straight = distance_to_goal(scene, START, 0.0)
    nearest[2 * START] = 0.0
    heap = [(straight, 0.0, -1 - 2 * START)]
    while heap:
        promise, driven, k = heappop(heap)
        if k < 0:
            # Of equal promises, what was driven farther comes first: it counts down in the heap.
            o = -1 - k
            if looked[o] < math.inf and promise >= nearest[o] + looked[o]:
                more = max(promise - straight, STEP * straight)
                begin, previous = count, looked[o]
                looked[o] = promise - nearest[o] + more
                if looked[o] > scene.span / 2:
                    looked[o] = math.inf
                lines, count = look_round(scene, o, previous, looked[o], lines, count)
                leaving[o] = chain(lines, begin, count, leaving[o])
                drive_on_all(scene, o, begin, joining[o], leaving[o], lines, heap)
                heappush(heap, (nearest[o] + looked[o], 0.0, k))
            continue
        if lines[k, KNOWN] != NOTHING:
            continue
        o = int(lines[k, TO])
        lines[k, KNOWN] = CLEAR if is_free(scene, lines[k]) else BARRED
        if lines[k, KNOWN] == BARRED:
            continue
        if o == 2 * GOAL:
            return route_to(lines, k), -driven, nearest < math.inf
        lines[k, OPEN] = open_arc(scene, o, lines[k, JOIN])
        lines[k, ARRIVAL] = joining[o]
        joining[o] = k
        drive_on(scene, o, k, leaving[o], 0, lines, heap)
        if -driven < nearest[o]:
            nearest[o] = -driven
            heappush(heap, (max(promise, nearest[o] + looked[o]), 0.0, -1 - o))
    return np.empty(0, np.int64), math.inf, nearest < math.inf


def route_to(lines, k):
    """Oriented circles driven round before a tangent, in driving order."""
    turns, before = 0, int(lines[k, BEFORE])
    while before >= 0:
        turns, before = turns + 1, int(lines[before, BEFORE])
    route, before = np.empty(turns, np.int64), int(lines[k, BEFORE])
    for turn in range(turns - 1, -1, -1):
        route[turn] = lines[before, TO]
        before = int(lines[before, BEFORE])
    return route


def chain(lines, begin, count, after):
    """Chain new tangents that leave one oriented circle; the last of them, from which on."""
    for d in range(begin, count):
        lines[d, SIBLING] = after
        after = d
    return after


def drive_on_all(scene, o, begin, arrival, last, lines, heap):
    """Drive on to the tangents from `begin` on, from wherever their oriented circle was joined."""
    if o == 2 * START:
        for d in range(begin, last + 1):
            lines[d, DRIVEN] = 0.0
            heappush(heap, (lines[d, LINE] + lines[d, TO_GOAL], -lines[d, LINE], d))
    while arrival >= 0:
        drive_on(scene, o, arrival, last, begin, lines, heap)
        arrival = int(lines[arrival, ARRIVAL])


def drive_on(scene, o, arrival, last, begin, lines, heap):
    """Drive round an oriented circle, from where a tangent joins it, to tangents that leave it."""
    sense, radius = 1 - 2 * (o % 2), scene.radius[o // 2]
    driven = lines[arrival, DRIVEN] + lines[arrival, LINE]
    at, limit = lines[arrival, JOIN], lines[arrival, OPEN]
    d = last
    while d >= begin:
        if lines[d, KNOWN] == NOTHING:
            sweep = (sense * (lines[d, LEAVE] - at)) % (2 * math.pi)
            # Where it only grazes the circle, round-off leaves no arc or a whole turn.
            if sweep > 2 * math.pi - ANGLE:
                sweep = 0.0
            length = driven + radius * sweep
            if sweep <= limit and length < lines[d, DRIVEN]:
                lines[d, DRIVEN], lines[d, BEFORE] = length, arrival
                length += lines[d, LINE]
                heappush(heap, (length + lines[d, TO_GOAL], -length, d))
        d = int(lines[d, SIBLING])


def open_arc(scene, o, at):
    """How far an oriented circle can be driven round from a direction on (rad).

    The distance to an edge, driven round a circle, is smallest at points known
    in closed form, and each part that is too close has such a point.
    """
    i, sense = o // 2, 1 - 2 * (o % 2)
    x, y, radius = scene.circle[i, 0], scene.circle[i, 1], scene.radius[i]
    x0, y0, cell = scene.corner
    nx, ny = scene.cells
    limit = math.inf
    scene.mark[0] += 1
    for row in range(
        max(int((y - radius - y0) / cell), 0), min(int((y + radius - y0) / cell), ny - 1) + 1
    ):
        for column in range(
            max(int((x - radius - x0) / cell), 0), min(int((x + radius - x0) / cell), nx - 1) + 1
        ):
            here = row * nx + column
            for place in range(scene.edge_first[here], scene.edge_first[here + 1]):
                e = scene.edge_item[place]
                if scene.stamp[e] != scene.mark[0]:
                    scene.stamp[e] = scene.mark[0]
                    limit = min(limit, closed_from(x, y, radius, sense, at, scene, e))
    return limit


def closed_from(x, y, radius, sense, at, scene, e):
    """How far a circle can be driven round until it is too close to one edge (rad)."""
    ax, ay, bx, by = scene.edge[e]
    reach, limit = radius + scene.keep[e], math.inf
    if scene.keep[e] <= 0 or not is_near(x, y, ax, ay, bx, by, reach * reach):
        return limit
    squared = (scene.keep[e] - NEARER) ** 2
    ex, ey = bx - ax, by - ay
    length = ex * ex + ey * ey
    foot, half = 0.0, 0.0
    if length > 0:
        foot = ((x - ax) * ex + (y - ay) * ey) / length
        fx, fy = ax + foot * ex - x, ay + foot * ey - y
        half = math.sqrt(max(radius * radius - fx * fx - fy * fy, 0.0) / length)
    # Both ends of the edge, where the circle cuts it, and the foot of the centre.
    for share in (0.0, 1.0, foot - half, foot, foot + half):
        share = min(max(share, 0.0), 1.0)
        angle = math.atan2(ay + share * ey - y, ax + share * ex - x)
        tx, ty = x + radius * math.cos(angle), y + radius * math.sin(angle)
        if is_near(tx, ty, ax, ay, bx, by, squared):
            limit = min(limit, (sense * (angle - at)) % (2 * math.pi))
            scene.met[e] = True
    return limit


def is_near(x, y, ax, ay, bx, by, squared):
    """Whether a point is nearer to a segment than the root of `squared`."""
    ex, ey = bx - ax, by - ay
    px, py = x - ax, y - ay
    along = px * ex + py * ey
    if along > 0:
        length = ex * ex + ey * ey
        if along >= length:
            px, py = x - bx, y - by
        else:
            across = px * ey - py * ex
            return across * across < squared * length
    return px * px + py * py < squared


def bars(px, py, qx, qy, scene, e):
    """Whether the line from p to q comes too near to an edge."""
    ax, ay, bx, by = scene.edge[e]
    keep = scene.keep[e] - NEARER
    if (
        keep <= 0
        or min(px, qx) - keep >= max(ax, bx)
        or max(px, qx) + keep <= min(ax, bx)
        or min(py, qy) - keep >= max(ay, by)
        or max(py, qy) + keep <= min(ay, by)
    ):
        return False
    squared = keep * keep
    if is_near(ax, ay, px, py, qx, qy, squared):
        return True
    if ax == bx and ay == by:
        return False
    if (
        is_near(bx, by, px, py, qx, qy, squared)
        or is_near(px, py, ax, ay, bx, by, squared)
        or is_near(qx, qy, ax, ay, bx, by, squared)
    ):
        return True
    # Far from each other's ends, they are near where they cross.
    dx, dy, ex, ey = qx - px, qy - py, bx - ax, by - ay
    a_left, b_left = dx * (ay - py) > dy * (ax - px), dx * (by - py) > dy * (bx - px)
    p_left, q_left = ex * (py - ay) > ey * (px - ax), ex * (qy - ay) > ey * (qx - ax)
    return a_left != b_left and p_left != q_left


def is_free(scene, line):
    """Whether a tangent keeps away from all edges: a walk through the cells that it crosses.

    See J. Amanatides and A. Woo, "A fast voxel traversal algorithm", *Eurographics* 1987.
    """
    i, j = int(line[FROM]) // 2, int(line[TO]) // 2
    px = scene.circle[i, 0] + scene.radius[i] * math.cos(line[LEAVE])
    py = scene.circle[i, 1] + scene.radius[i] * math.sin(line[LEAVE])
    qx = scene.circle[j, 0] + scene.radius[j] * math.cos(line[JOIN])
    qy = scene.circle[j, 1] + scene.radius[j] * math.sin(line[JOIN])
    dx, dy = qx - px, qy - py
    x0, y0, cell = scene.corner
    nx = scene.cells[0]
    begin, end = inside_grid(px, py, dx, dy, scene)
    if begin > end:
        return True
    scene.mark[0] += 1
    column, row = cell_at(scene.corner, scene.cells, px + begin * dx, py + begin * dy)
    last_column, last_row = cell_at(scene.corner, scene.cells, px + end * dx, py + end * dy)
    step_x, step_y = (1 if last_column > column else -1), (1 if last_row > row else -1)
    # Shares of the line at which it enters the next column and the next row.
    wide, high = (cell / abs(dx) if dx else math.inf), (cell / abs(dy) if dy else math.inf)
    next_x = (x0 + (column + (step_x > 0)) * cell - px) / dx if dx else math.inf
    next_y = (y0 + (row + (step_y > 0)) * cell - py) / dy if dy else math.inf
    for _ in range(abs(last_column - column) + abs(last_row - row) + 1):
        here = row * nx + column
        for place in range(scene.edge_first[here], scene.edge_first[here + 1]):
            e = scene.edge_item[place]
            if scene.stamp[e] != scene.mark[0]:
                scene.stamp[e] = scene.mark[0]
                if bars(px, py, qx, qy, scene, e):
                    scene.met[e] = True
                    return False
        if row == last_row or (column != last_column and next_x < next_y):
            column, next_x = column + step_x, next_x + wide
        else:
            row, next_y = row + step_y, next_y + high
    return True


def inside_grid(px, py, dx, dy, scene):
    """Between which shares of a line it is inside the grid; the first is larger where nowhere."""
    x0, y0, cell = scene.corner
    nx, ny = scene.cells
    begin, end = 0.0, 1.0
    for p, d, low, high in ((px, dx, x0, x0 + nx * cell), (py, dy, y0, y0 + ny * cell)):
        if d != 0:
            one, two = (low - p) / d, (high - p) / d
            begin, end = max(begin, min(one, two)), min(end, max(one, two))
        elif p < low or p > high:
            end = -1.0
    return begin, end


def cell_at(corner, cells, x, y):
    """Column and row of the cell at a point, or of the nearest one."""
    x0, y0, cell = corner
    column, row = int((x - x0) / cell), int((y - y0) / cell)
    return min(max(column, 0), cells[0] - 1), min(max(row, 0), cells[1] - 1)


def distance_to_goal(scene, i, angle):
    """Straight line from a point of a circle, in a direction from its centre, to the goal (m)."""
    x = scene.circle[i, 0] + scene.radius[i] * math.cos(angle) - scene.circle[GOAL, 0]
    y = scene.circle[i, 1] + scene.radius[i] * math.sin(angle) - scene.circle[GOAL, 1]
    return math.hypot(x, y)


def look_round(scene, o, shortest, longest, lines, count):
    """List the tangents that leave an oriented circle and that no near edge hides.

    Only those whose length and straight line on to the goal are together above
    `shortest` and at most `longest` (m).

    Returns
    -------
    lines, count
        The list, grown where need be, and how many are listed in it.
    """
    i = o // 2
    longest = min(longest, 4 * scene.span)
    limit_view(scene, o, longest)
    cell, (nx, ny) = scene.corner[2], scene.cells
    # How far what is entered in a cell can be seen from beside the cell's middle, and as far
    # as from the circle's.
    around = scene.largest + scene.radius[i] + 0.71 * cell
    ci, cj = cell_at(scene.corner, scene.cells, scene.circle[i, 0], scene.circle[i, 1])
    scene.mark[0] += 1
    inner, outer = -1, 1
    while True:
        count_views = find_views(scene, max(inner * cell - around, 0.0))
        # First what hides, then what is seen, in a frame of cells.
        for seeing in (False, True):
            for view in range(count_views):
                lines, count = look_into(
                    scene, o, view, around, inner, outer, seeing, shortest, longest, lines, count
                )
        inner, outer = outer, 2 * outer
        is_all = max(ci, cj, nx - 1 - ci, ny - 1 - cj) <= inner
        if is_all or inner * cell - around > scene.hidden.max():
            break
    return see(scene, o, GOAL, shortest, longest, lines, count)


def find_views(scene, distance):
    """Note the runs of headings in which something may be seen beyond a distance (m).

    What is between the first and the last heading of one is left of three directions,
    noted in `scene.sector`: the first, the last turned back, and one across. A run
    goes on over a few headings in which nothing is seen, but not over a third of a turn.
    """
    width = 2 * math.pi / len(scene.hidden)
    parts = len(scene.hidden)
    views, first, last = 0, -1, -1
    for part in range(parts + 1):
        is_open = part < parts and scene.hidden[part] > distance
        ends = part == parts or (
            is_open and (part - last > parts // 64 or part - first >= parts // 3)
        )
        if first >= 0 and ends:
            begin, end = first * width, (last + 1) * width
            for side, angle in enumerate((begin, end + math.pi, (begin + end - math.pi) / 2)):
                scene.sector[views, 2 * side] = math.cos(angle)
                scene.sector[views, 2 * side + 1] = math.sin(angle)
            views, first = views + 1, -1
        if is_open:
            first, last = (part if first < 0 else first), part
    return views


def look_into(scene, o, view, around, inner, outer, seeing, shortest, longest, lines, count):
    """Look for what hides, or for what is seen, in the part of a frame of cells in one view."""
    x0, y0, cell = scene.corner
    nx, ny = scene.cells
    i = o // 2
    x, y = scene.circle[i, 0], scene.circle[i, 1]
    ci, cj = cell_at(scene.corner, scene.cells, x, y)
    for row in range(max(cj - outer, 0), min(cj + outer, ny - 1) + 1):
        low, high = row_of_ellipse(scene, i, longest + 2 * around + 2 * cell, row)
        low, high = max(low, ci - outer), min(high, ci + outer)
        left, right = row_of_view(scene.sector[view], y0 + (row + 0.5) * cell - y, around)
        low = max(low, math.floor(max((x + left - x0) / cell, -1.0)))
        high = min(high, math.ceil(min((x + right - x0) / cell, nx + 0.0)))
        column = low
        while column <= high:
            if abs(row - cj) <= inner and abs(column - ci) <= inner:
                column = ci + inner + 1
                continue
            here = row * nx + column
            column += 1
            if not seeing:
                hide_in(scene, o, here)
                continue
            for place in range(scene.circle_first[here], scene.circle_first[here + 1]):
                other = scene.circle_item[place]
                # Views overlap; what was seen in one is not listed again.
                if scene.seen[other] != scene.mark[0]:
                    scene.seen[other] = scene.mark[0]
                    lines, count = see(scene, o, other, shortest, longest, lines, count)
    return lines, count


def row_of_view(sector, dy, around):
    """From where to where a row of cells is in view, or nearer to it than `around` (m).

    The row is `dy` above the eye; the bounds are beside the eye.
    """
    low, high = -math.inf, math.inf
    for side in range(3):
        ux, uy = sector[2 * side], sector[2 * side + 1]
        rest = ux * dy + around
        if uy > 1e-12:
            high = min(high, rest / uy)
        elif uy < -1e-12:
            low = max(low, rest / uy)
        elif rest < 0:
            return 1.0, -1.0
    return low, high


def row_of_ellipse(scene, i, across, row):
    """First and last column of an ellipse in a row of cells; the first is larger where none.

    The sum of the distances from a circle's centre and from the goal is `across` (m).
    """
    x0, y0, cell = scene.corner
    x, y = scene.circle[i, 0], scene.circle[i, 1]
    gx, gy = scene.circle[GOAL, 0] - x, scene.circle[GOAL, 1] - y
    between = math.hypot(gx, gy)
    ux, uy = (gx / between, gy / between) if between > 0 else (1.0, 0.0)
    a, b = 4 / (across * across), 4 / (across * across - between * between)
    dy = y0 + (row + 0.5) * cell - y - gy / 2
    quadratic = ux * ux * a + uy * uy * b
    linear = dy * ux * uy * (a - b)
    root = linear * linear - quadratic * (dy * dy * (uy * uy * a + ux * ux * b) - 1)
    if root < 0:
        return 0, -1
    middle = x + gx / 2 - x0 - linear / quadratic
    half = math.sqrt(root) / quadratic
    low, high = (middle - half) / cell, (middle + half) / cell
    return int(max(low, 0.0)), int(min(high, scene.cells[0] - 1.0)) if high >= 0 else -1


def limit_view(scene, o, longest):
    """Note how far to look along the tangents of an oriented circle, by heading.

    Where the corner's normal cone lets none leave, not at all; elsewhere, as far as a
    line and the straight line on to the goal are together `longest` (m): an ellipse,
    seen from its focus.
    """
    i, sense = o // 2, 1 - 2 * (o % 2)
    signed, (ax, ay, bx, by) = sense * scene.radius[i], scene.circle[i, 2:]
    goal_x = scene.circle[GOAL, 0] - scene.circle[i, 0]
    goal_y = scene.circle[GOAL, 1] - scene.circle[i, 1]
    width = 2 * math.pi / len(scene.hidden)
    first, parts = 0, len(scene.hidden)
    if ax != 0 or ay != 0:
        low = math.atan2(ay, ax) + sense * math.pi / 2
        turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        first = math.floor((low - 1e-6) / width)
        parts = min(math.floor((low + turn + 1e-6) / width) + 1 - first, parts)
    # A heading's part of a turn is as wide as this moves the tangent's beginning.
    longest += scene.radius[i] * width
    scene.hidden[:] = -1.0
    for part in range(first, first + parts):
        tx, ty = math.cos((part + 0.5) * width), math.sin((part + 0.5) * width)
        gx, gy = goal_x - signed * ty, goal_y + signed * tx
        squared = gx * gx + gy * gy
        distance = math.sqrt(squared)
        ahead = min(gx * tx + gy * ty + distance * width / 2, distance)
        rest = longest * longest - squared
        if rest > 0:
            scene.hidden[part % len(scene.hidden)] = min(rest / (2 * (longest - ahead)), longest)


def hide_in(scene, o, here):
    """Note what the edges in a cell hide from an oriented circle."""
    for place in range(scene.edge_first[here], scene.edge_first[here + 1]):
        e = scene.edge_item[place]
        if scene.stamp[e] != scene.mark[0]:
            scene.stamp[e] = scene.mark[0]
            if scene.keep[e] > 0:
                hide_behind(scene, o, e)


def hide_behind(scene, o, e):
    """Note behind what distance an edge hides all that is seen along an oriented circle's tangents.

    A heading is hidden between those at which the tangents to the circles round the
    edge's ends leave, in the one sense and in the other.
    """
    i, keep = o // 2, scene.keep[e]
    signed = (1 - 2 * (o % 2)) * scene.radius[i]
    ax, ay = scene.edge[e, 0] - scene.circle[i, 0], scene.edge[e, 1] - scene.circle[i, 1]
    bx, by = scene.edge[e, 2] - scene.circle[i, 0], scene.edge[e, 3] - scene.circle[i, 1]
    reach = abs(signed) + keep
    if is_near(0.0, 0.0, ax, ay, bx, by, reach * reach):
        return
    direction, distance = math.atan2(ay, ax), math.hypot(ax, ay)
    low = direction - math.asin(min((keep - signed) / distance, 1.0))
    high = direction + math.asin(min((keep + signed) / distance, 1.0))
    far = distance
    if ax != bx or ay != by:
        direction += math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        distance = math.hypot(bx, by)
        low = min(low, direction - math.asin(min((keep - signed) / distance, 1.0)))
        high = max(high, direction + math.asin(min((keep + signed) / distance, 1.0)))
        far = max(far, distance)
    width = 2 * math.pi / len(scene.hidden)
    for part in range(math.ceil(low / width), math.floor(high / width)):
        scene.hidden[part % len(scene.hidden)] = min(
            scene.hidden[part % len(scene.hidden)], far + keep
        )


def see(scene, o, other, shortest, longest, lines, count):
    """List the tangents from an oriented circle to another circle, driven either way."""
    i, sense = o // 2, 1 - 2 * (o % 2)
    if scene.radius[other] < 0 or other == i:
        return lines, count
    dx = scene.circle[other, 0] - scene.circle[i, 0]
    dy = scene.circle[other, 1] - scene.circle[i, 1]
    squared, parts = dx * dx + dy * dy, len(scene.hidden)
    for to_sense in (1, -1):
        signed = to_sense * scene.radius[other]
        difference = signed - sense * scene.radius[i]
        rest = squared - difference * difference
        # One contains the other, or both senses round the goal, which is a point, are one.
        if squared == 0 or rest < -1e-12 * squared or (other == GOAL and to_sense < 0):
            continue
        length = math.sqrt(max(rest, 0.0))
        # The left normal of the line from one to the other.
        nx, ny = (
            (difference * dx - length * dy) / squared,
            (length * dx + difference * dy) / squared,
        )
        x = scene.circle[other, 0] - signed * nx - scene.circle[GOAL, 0]
        y = scene.circle[other, 1] - signed * ny - scene.circle[GOAL, 1]
        to_goal = math.sqrt(x * x + y * y)
        part = int(math.atan2(-nx, ny) * parts / (2 * math.pi) + parts) % parts
        if (
            not shortest < length + to_goal <= longest
            or is_outside(scene, i, -sense * nx, -sense * ny)
            or is_outside(scene, other, -to_sense * nx, -to_sense * ny)
            or length > scene.hidden[part]
        ):
            continue
        if count == len(lines):
            lines = grown(lines)
        lines[count, LEAVE] = math.atan2(-sense * ny, -sense * nx)
        lines[count, JOIN] = math.atan2(-to_sense * ny, -to_sense * nx)
        lines[count, LINE : DRIVEN + 1] = length, to_goal, math.inf
        lines[count, FROM : BEFORE + 1] = o, 2 * other + (to_sense < 0), -1
        lines[count, KNOWN] = NOTHING
        count += 1
    return lines, count


def is_outside(scene, i, x, y):
    """Whether a direction from a circle's centre is out of its corner's normal cone."""
    _, _, ax, ay, bx, by = scene.circle[i]
    return ax * y - ay * x < -CONE or x * by - y * bx < -CONE


def grown(lines):
    """A list of tangents with twice as much room."""
    more = np.empty((2 * len(lines), lines.shape[1]))
    more[: len(lines)] = lines
    return more


def enter_cells(edge, keep, corner, cells, counting, first, item):
    """Enter every edge in all cells with points nearer to it than it keeps.

    With `counting`, only how many there are is counted, in `first` shifted by two, so
    that the second time each cell's are entered from where they begin.
    """
    x0, y0, cell = corner
    nx = cells[0]
    for e in range(len(edge)):
        ax, ay, bx, by = edge[e]
        near = keep[e]
        reach = (near + 0.71 * cell) ** 2
        low, bottom = cell_at(corner, cells, min(ax, bx) - near, min(ay, by) - near)
        high, top = cell_at(corner, cells, max(ax, bx) + near, max(ay, by) + near)
        for row in range(bottom, top + 1):
            for column in range(low, high + 1):
                x, y = x0 + (column + 0.5) * cell, y0 + (row + 0.5) * cell
                if is_near(x, y, ax, ay, bx, by, reach):
                    here = row * nx + column
                    if counting:
                        first[here + 2] += 1
                    else:
                        item[first[here + 1]] = e
                        first[here + 1] += 1
