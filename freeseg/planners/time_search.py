"""A* by arrival time over straight lines and slides among discs that move.

Between two discs a time-minimal motion is straight and grazes both; on a disc it
slides along the rim as fast as the robot can (K. Fujimura, H. Samet, *Algorithmica*
1993, for convex polygons). Discs move evenly, and may grow. Let n be the normal where
the robot touches disc c + u t of radius R + g t, and e the direction in which it
passes; then both as it comes in and as it slides, its velocity is v = u + g n + s e,
with s such that |v| is the robot's speed V: it is the same motion that ends the line
and begins the slide. So a grazing line is found where the tangent to the disc as it
stands at that moment touches, and the slide turns by s dt / R.

The search knows *labels*, slides begun at a place of a rim at a time, and *moves*,
straight lines from one to the next. Both are lazy: a slide goes on a part of a turn at a
time, when it is the most promising of all, and whether a line is free is asked when it is.

Where two discs overlap, both slides end at their common corner. What waits there can ride on
it as long as it is slower than the robot, and goes on sliding when it is no longer: so a gap
that opens is passed as early as can be. And what covers the goal is followed until it leaves
it. Both are *waits*: places that move, where the robot must be by a certain time. A slide that is
too early for one can stop on the rim until it comes by.

Loops over arrays and nothing else, so that numba can compile this file; see
`compilation`.
"""

import math
from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np

from freeseg.planners.tangent_search import bars

#: A motion may come closer to an obstacle than its distance to keep by round-off (m).
CLOSER = 1e-10

#: Slides go on by this angle (rad) at a time, looked at in so many places.
PART, LOOKS = math.pi / 8, 4

#: How far (rad) a slide goes on past the end of a corner: it comes closer to its edge by less than
#: round-off.
PAST = 1e-7

#: Directions (rad) and times (relative) differ by round-off.
TURNED, LATER = 1e-9, 1e-12

#: A slide that is so many times closer than it can tell from touching goes on in coarse steps.
CREEPS = 100

#: The goal is the first disc, of radius zero.
TARGET = 0

#: Columns of discs: centre at time zero (m), velocity (m/s), radius then (m), growth (m/s).
X, Y, U, W, RADIUS, GROWTH = range(6)

#: Columns of labels: disc and sense; the direction of the rim (rad) and the time (s) at which the
#: slide begins, the integral `unrolled` there; how far it was followed (rad); the label before,
#: how far that was driven round, how the robot came from there; the label made before on the same
#: disc in the same sense; the disc that ends it, or -1.
DISC, SENSE, BEARING, TIME, UNROLLED, DONE, PARENT, LEFT, HOW, OLDER, ENDED_BY = range(11)

#: Columns of moves: the label left and how far it was driven round; where (m) and when (s) the
#: move begins, its velocity (m/s) and duration (s); the disc reached and in which sense, the
#: direction of its rim there; and what it is.
ON, LEAVING, MX, MY, MV, MW, WHEN, LASTS, ONTO, TO_SENSE, TOUCH, KIND = range(12)

#: Kinds of moves: a straight line at full speed, and a slower ride at a place of a rim.
STRAIGHT, RIDE = 0, 1

#: Columns of waits: what they are; from when until when (s) the robot can ride there, and where
#: that ends (m); the discs that meet there, or -1, or -2 less the number of a wall's edge; which of
#: two corners it is; and from here on two rows of numbers that say where it is, as for `wait_at`.
WAIT, SINCE, UNTIL, END_X, END_Y, ONE, OTHER, SIDE, SHAPE = range(9)

#: Column of the second row of numbers of a wall: how long its edge is (m).
EDGE_LENGTH = 4

#: Kinds of waits: the corner of two discs, or of a disc and an edge; what leaves the goal last.
CORNER, WALL, RELEASE = 0, 1, 2

#: When a line meets a wait, or a wait is free, is found to so much, relatively.
HALVED = 1e-15

#: What a divisor is at least.
LEAST = 1e-300

#: A slide that ends so close (m) to a wait is there.
THERE = 3e-8

#: A place of a rim is met by a corner at so many times that are looked at.
MEETINGS = 8

#: A ride is looked at in steps of at least this share of it, or of the straight way to the goal.
RIDE_STEP = 1e-3


class Field(NamedTuple):
    """Discs that move, edges that stand, and what is known of them beforehand.

    Parameters
    ----------
    start : ndarray, shape (2,)
        Start (m).
    speed : float
        Speed of the robot (m/s).
    disc : ndarray, shape (n, 6)
        Columns as above; the first is the goal.
    cone : ndarray, shape (n, 4)
        Unit normals between which a corner's free directions lie,
        counter-clockwise; zeros for a disc, which has all.
    own : ndarray of int, shape (n, 2)
        Edges that meet at a corner; -1 for a disc.
    edge : ndarray, shape (k, 4)
        Both ends of every edge (m).
    keep : ndarray, shape (k,)
        Distance to keep from each (m).
    table : ndarray, shape (n, 2, knots + 1)
        The integral `unrolled` at even steps of a turn, in both senses.
    node, weight : ndarray, shape (8,)
        Gauss's nodes between 0 and 1, and their weights.
    covered : ndarray, shape (c, 2)
        Times from when until when (s) the goal is covered, disjoint and in order.
    release : ndarray, shape (n, 2)
        When (s) and in which direction from its centre (rad) each disc leaves
        the goal; NaN where it does not.
    wait : ndarray, shape (m, 20)
        Waits, columns as above.
    """

    start: np.ndarray
    speed: float
    disc: np.ndarray
    cone: np.ndarray
    own: np.ndarray
    edge: np.ndarray
    keep: np.ndarray
    table: np.ndarray
    node: np.ndarray
    weight: np.ndarray
    covered: np.ndarray
    release: np.ndarray
    wait: np.ndarray


def search(field):
    """The earliest arrival at the goal.

    Returns
    -------
    arrival : float
        When (s); infinite where no motion was found.
    labels, last : ndarray, ndarray
        All labels, and the move that arrives.
    """
    labels, known = np.empty((64, 11)), 0
    moves, count = np.empty((256, 12)), 0
    newest = np.full((len(field.disc), 2), -1)
    waited = np.zeros(len(field.wait), np.bool_)
    heap = [(0.0, 0)]
    heappop(heap)
    moves, count = leave_start(field, moves, count, heap)
    while heap:
        promise, k = heappop(heap)
        if k < 0:
            moves, count = go_on(field, labels, -1 - k, newest, waited, moves, count, heap)
            continue
        if known == len(labels):
            labels = doubled(labels)
        move = moves[k]
        if move[ONTO] == TARGET:
            if is_open(field, labels, move):
                return promise, labels[:known], move
            continue
        if move[ONTO] >= len(field.disc):
            if not waited[int(move[ONTO]) - len(field.disc)] and is_open(field, labels, move):
                waited[int(move[ONTO]) - len(field.disc)] = True
                begin_wait(labels[known], move)
                moves, count = ride(field, labels, known, moves, count, heap)
                known += 1
            continue
        i, side = int(move[ONTO]), int(move[TO_SENSE] < 0)
        when = move[WHEN] + move[LASTS]
        if is_late(field, labels, newest[i, side], move[TOUCH], when):
            continue
        if not is_open(field, labels, move):
            continue
        begin_slide(field, labels[known], move, newest[i, side])
        newest[i, side] = known
        heappush(heap, (promise, -1 - known))
        known += 1
    return math.inf, labels[:known], np.empty(12)


def doubled(rows):
    """Rows with twice as much room."""
    more = np.empty((2 * len(rows), rows.shape[1]))
    more[: len(rows)] = rows
    return more


def begin_slide(field, label, move, older):
    """Fill in the label of the slide that a move leads to."""
    i, sense = int(move[ONTO]), move[TO_SENSE]
    label[DISC], label[SENSE], label[BEARING] = i, sense, move[TOUCH]
    label[TIME] = move[WHEN] + move[LASTS]
    label[UNROLLED] = unrolled(field, i, sense, move[TOUCH])
    label[DONE], label[PARENT], label[LEFT], label[HOW] = 0.0, move[ON], move[LEAVING], move[KIND]
    label[OLDER], label[ENDED_BY] = older, -1


def is_late(field, labels, a, angle, when):
    """Whether an earlier slide came past a place of the rim before, and could wait there."""
    while a >= 0:
        label = labels[a]
        ahead = (label[SENSE] * (angle - label[BEARING])) % (2 * math.pi)
        if ahead > 2 * math.pi - TURNED:
            ahead = 0.0
        if ahead <= label[DONE] or ahead == 0.0:
            _, _, _, _, t = slide_at(field, label, ahead)
            if t <= when * (1 + LATER) and can_wait(field, int(label[DISC]), angle, t, when):
                return True
        a = int(label[OLDER])
    return False


def can_wait(field, i, angle, begin, end):
    """Whether a place of a rim is free from one time to another."""
    if end <= begin:
        return True
    x, y, u, w, radius, growth = field.disc[i]
    nx, ny = math.cos(angle), math.sin(angle)
    r = radius + growth * begin
    x, y = x + u * begin + r * nx, y + w * begin + r * ny
    return is_free(field, x, y, u + growth * nx, w + growth * ny, begin, end - begin, i, i)


def rim_speed(field, i, sense, nx, ny):
    """How fast (m/s) the robot passes a disc's centre where it slides, at a normal of the rim."""
    u, w, g = field.disc[i, U], field.disc[i, W], field.disc[i, GROWTH]
    along = sense * (w * nx - u * ny)
    a, b = u + g * nx, w + g * ny
    rest = field.speed * field.speed - a * a - b * b
    root = math.sqrt(along * along + rest)
    return rest / (root + along) if along > 0 else root - along


def unrolled(field, i, sense, angle):
    """Integral of 1 / `rim_speed` over the direction of the rim, from zero on (rad s/m)."""
    turns = math.floor(angle / (2 * math.pi))
    rest = angle - 2 * math.pi * turns
    table = field.table[i, int(sense < 0)]
    last = len(table) - 1
    width = 2 * math.pi / last
    knot = min(int(rest / width), last - 1)
    return turns * table[last] + table[knot] + part_of(field, i, sense, knot * width, rest)


def part_of(field, i, sense, begin, end):
    """The integral of `unrolled` over a short part."""
    total, width = 0.0, end - begin
    for k in range(len(field.node)):
        angle = begin + width * field.node[k]
        total += field.weight[k] / rim_speed(field, i, sense, math.cos(angle), math.sin(angle))
    return total * width


def fill_table(field):
    """Fill in the table of `unrolled`."""
    last = field.table.shape[2] - 1
    width = 2 * math.pi / last
    for i in range(len(field.disc)):
        for side in range(2):
            table = field.table[i, side]
            table[0] = 0.0
            for k in range(last):
                table[k + 1] = table[k] + part_of(
                    field, i, 1 - 2 * side, k * width, (k + 1) * width
                )


def slide_at(field, label, turned):
    """Place (m), velocity (m/s) and time (s) after so much of a slide (rad)."""
    i, sense = int(label[DISC]), label[SENSE]
    x, y, u, w, radius, g = field.disc[i]
    angle = label[BEARING] + sense * turned
    nx, ny = math.cos(angle), math.sin(angle)
    reach = sense * (unrolled(field, i, sense, angle) - label[UNROLLED])
    begin = radius + g * label[TIME]
    # The radius grows by e with every 1 / g of the integral.
    t = label[TIME] + begin * (math.expm1(g * reach) / g if g > 0 else reach)
    r = radius + g * t
    s = rim_speed(field, i, sense, nx, ny)
    vx, vy = u + g * nx - s * sense * ny, w + g * ny + s * sense * nx
    return x + u * t + r * nx, y + w * t + r * ny, vx, vy, t


def graze(field, x, y, t, j, sense):
    """Line from a point at a time that grazes a disc: velocity, duration and normal at its end.

    The duration is negative where the point is inside the disc. After the discs there come
    the waits, which a line meets.
    """
    if j >= len(field.disc):
        return catch(field, x, y, t, field.wait[j - len(field.disc)])
    speed = field.speed
    cx, cy, u, w, radius, g = field.disc[j]
    dx, dy, r = cx + u * t - x, cy + w * t - y, sense * (radius + g * t)
    squared = dx * dx + dy * dy
    rest = squared - r * r
    # A slide that ends at the disc is closer by what its end is found to, which is as much.
    if rest < -8 * CLOSER * abs(r) or squared == 0:
        return 0.0, 0.0, -1.0, 0.0, 0.0
    length = math.sqrt(max(rest, 0.0))
    ex, ey = (length * dx + r * dy) / squared, (length * dy - r * dx) / squared
    scale = 1 / math.sqrt(ex * ex + ey * ey)
    ex, ey = ex * scale, ey * scale
    nx, ny = sense * ey, -sense * ex
    along, a, b = u * ex + w * ey, u + g * nx, w + g * ny
    room = speed * speed - a * a - b * b
    root = math.sqrt(along * along + room)
    s = room / (root + along) if along > 0 else root - along
    return a + s * ex, b + s * ey, length / s, nx, ny


def leave_start(field, moves, count, heap):
    """List all lines that leave the start."""
    x, y = field.start
    return leave_place(field, -1, 0.0, x, y, 0.0, moves, count, heap)


def leave_place(field, a, leaving, x, y, t, moves, count, heap):
    """List all lines that leave a place at a time."""
    for j in range(len(field.disc) + len(field.wait)):
        for sense in (1, -1):
            if sense < 0 and (j == TARGET or j >= len(field.disc)):
                continue
            vx, vy, lasts, nx, ny = graze(field, x, y, t, j, sense)
            if lasts < 0:
                continue
            touch = math.atan2(ny, nx)
            move = (a + 0.0, leaving, x, y, vx, vy, t, lasts, j + 0.0, sense + 0.0, touch, 0.0)
            moves, count = list_move(field, move, nx, ny, moves, count, heap)
    return moves, count


def wait_at(wait, t):
    """Place (m) and velocity (m/s) of a wait at a time, or at times."""
    a, b = wait[SHAPE : SHAPE + 6], wait[SHAPE + 6 : SHAPE + 12]
    if wait[WAIT] == RELEASE:
        return a[X] + a[U] * t, a[Y] + a[W] * t, a[U] + 0 * t, a[W] + 0 * t
    if wait[WAIT] == WALL:
        return wall_at(a, b, wait[SIDE], t)
    return corner_at(a, b, wait[SIDE], t)


def corner_at(a, b, side, t):
    """Place and velocity of a corner of two discs, to the left or right of the way to the other."""
    x, y = a[X] + a[U] * t, a[Y] + a[W] * t
    dx, dy = b[X] + b[U] * t - x, b[Y] + b[W] * t - y
    r, s, squared = a[RADIUS] + a[GROWTH] * t, b[RADIUS] + b[GROWTH] * t, dx * dx + dy * dy
    share = (squared + r * r - s * s) / (2 * squared)
    half = side * np.sqrt(np.maximum(r * r / squared - share * share, 0.0))
    nx, ny = share * dx - half * dy, share * dy + half * dx
    mx, my = nx - dx, ny - dy
    # What is there stays on both rims.
    one, other = a[U] * nx + a[W] * ny + a[GROWTH] * r, b[U] * mx + b[W] * my + b[GROWTH] * s
    # Where they only touch, it is as fast as can be told.
    twist = nx * my - ny * mx
    twist = twist + LEAST * (twist == 0)
    return x + nx, y + ny, (one * my - other * ny) / twist, (other * nx - one * mx) / twist


def wall_at(a, b, side, t):
    """Place and velocity of a corner of a disc and a line: b has a point, a direction, a length."""
    x, y, r = a[X] + a[U] * t, a[Y] + a[W] * t, a[RADIUS] + a[GROWTH] * t
    ex, ey = b[U], b[W]
    along, across = (x - b[X]) * ex + (y - b[Y]) * ey, (y - b[Y]) * ex - (x - b[X]) * ey
    half = side * np.sqrt(np.maximum(r * r - across * across, 0.0))
    half = half + LEAST * (half == 0)
    nx, ny = half * ex + across * ey, half * ey - across * ex
    pace = (a[U] * nx + a[W] * ny + a[GROWTH] * r) / half
    return b[X] + (along + half) * ex, b[Y] + (along + half) * ey, pace * ex, pace * ey


def catch(field, x, y, t, wait):
    """Line from a point at a time to a wait: as `graze`; slower where it would be there too early.

    The duration is negative where it comes too late.
    """
    low, high = max(wait[SINCE], t), wait[UNTIL]
    if low > high:
        return 0.0, 0.0, -1.0, 1.0, 0.0
    dx, dy = wait[END_X] - x, wait[END_Y] - y
    far = math.hypot(dx, dy)
    if far > field.speed * (high - t):
        pace = field.speed / max(far, LEAST)
        return pace * dx, pace * dy, -1.0, 1.0, 0.0
    when = low
    # Newton's method, kept between what is too early and what is late enough.
    for _ in range(60):
        px, py, vx, vy = wait_at(wait, when)
        gx, gy = px - x, py - y
        far = math.hypot(gx, gy)
        late = field.speed * (when - t) - far
        if late >= 0:
            high = when
            if when == low:
                break
        else:
            low = when
        slope = field.speed - (gx * vx + gy * vy) / max(far, LEAST)
        step = late / slope if slope > 0 else math.inf
        if abs(step) <= HALVED * high or high - low <= HALVED * high:
            break
        when -= step
        if not low < when < high:
            when = (low + high) / 2
    lasts = when - t
    if lasts <= 0:
        return 0.0, 0.0, -1.0, 1.0, 0.0
    return (px - x) / lasts, (py - y) / lasts, lasts, 1.0, 0.0


def begin_wait(label, move):
    """Fill in the label of the ride that a move leads to."""
    label[:] = 0.0
    label[DISC], label[SENSE] = move[ONTO], 1.0
    label[TIME] = move[WHEN] + move[LASTS]
    label[PARENT], label[LEFT], label[HOW] = move[ON], move[LEAVING], move[KIND]
    label[OLDER], label[ENDED_BY] = -1, -1


def ride(field, labels, a, moves, count, heap):
    """List what a ride leads to: slides on both discs, and all lines and waits where it ends."""
    wait = field.wait[int(labels[a, DISC]) - len(field.disc)]
    end = wait[UNTIL]
    x, y, vx, vy = wait_at(wait, end)
    x_left, y_left = x - field.disc[TARGET, X], y - field.disc[TARGET, Y]
    if wait[WAIT] == RELEASE and math.hypot(x_left, y_left) < THERE:
        move = (a + 0.0, end, x, y, 0.0, 0.0, end, 0.0, TARGET + 0.0, 1.0, 0.0, RIDE + 0.0)
        return list_move(field, move, 0.0, 0.0, moves, count, heap)
    for i in (int(wait[ONE]), int(wait[OTHER])):
        if i >= 0:
            cx, cy, u, w, _, _ = field.disc[i]
            nx, ny = x - cx - u * end, y - cy - w * end
            sense = 1.0 if nx * (vy - w) - ny * (vx - u) > 0 else -1.0
            touch = math.atan2(ny, nx)
            move = (a + 0.0, end, x, y, vx, vy, end, 0.0, i + 0.0, sense, touch, 0.0)
            size = math.hypot(nx, ny)
            moves, count = list_move(field, move, nx / size, ny / size, moves, count, heap)
    moves, count = change_wait(field, a, end, x, y, end, moves, count, heap)
    return leave_place(field, a, end, x, y, end, moves, count, heap)


def free_parts(field):
    """The waits, cut to the parts in which nothing is in the way, and to where others begin."""
    parts, count = np.empty((64, field.wait.shape[1])), 0
    x_left, y_left = field.start[0] - field.disc[TARGET, X], field.start[1] - field.disc[TARGET, Y]
    far = math.hypot(x_left, y_left)
    for k in range(len(field.wait)):
        wait = field.wait[k]
        least = RIDE_STEP * (wait[UNTIL] - wait[SINCE])
        if far > 0:
            least = min(least, RIDE_STEP * far / field.speed)
        before = t = since = wait[SINCE]
        room = spare(field, wait, t)
        was_free = is_free = room >= 0
        while True:
            if is_free != was_free or (t >= wait[UNTIL] and is_free):
                change = t if is_free == was_free else turn(field, wait, before, t, was_free)
                if was_free and change > since:
                    if count == len(parts):
                        parts = doubled(parts)
                    parts[count] = wait
                    parts[count, SINCE], parts[count, UNTIL] = since, change
                    parts[count, END_X], parts[count, END_Y], _, _ = wait_at(wait, change)
                    count += 1
                since, was_free = change, is_free
            if t >= wait[UNTIL]:
                break
            before = t
            t = min(t + max(abs(room), least), wait[UNTIL])
            room = spare(field, wait, t)
            is_free = room >= 0
    return cut_at_beginnings(parts, count)


def cut_at_beginnings(parts, count):
    """So many parts of rides, and each of them up to where another one begins on it."""
    more = count
    for k in range(count):
        for m in range(count):
            since = parts[m, SINCE]
            # What begins as early or as late is on the ride's ends.
            early, late = parts[k, SINCE] * (1 + TURNED), parts[k, UNTIL] * (1 - TURNED)
            if not early < since < late:
                continue
            x, y, _, _ = wait_at(parts[k], since)
            px, py, _, _ = wait_at(parts[m], since)
            if math.hypot(px - x, py - y) < THERE:
                if more == len(parts):
                    parts = doubled(parts)
                parts[more] = parts[k]
                parts[more, UNTIL], parts[more, END_X], parts[more, END_Y] = since, x, y
                more += 1
    return parts[:more].copy()


def turn(field, wait, low, high, was_free):
    """When something begins, or ends, to be in the way of a ride, between two times."""
    while high - low > HALVED * high:
        middle = (low + high) / 2
        if middle in (low, high):
            break
        if (spare(field, wait, middle) >= 0) == was_free:
            low = middle
        else:
            high = middle
    return low if was_free else high


def spare(field, wait, t):
    """How long (s) it takes at least until something is in the way of a ride, or no longer is."""
    x, y, _, _ = wait_at(wait, t)
    nearest = math.inf
    for j in range(1, len(field.disc)):
        gap, _ = gap_to(field, x, y, 0.0, 0.0, t, j, -1)
        # On those that it is on, it is where they meet, unless one holds the other.
        if gap < -THERE or (j != int(wait[ONE]) and j != int(wait[OTHER])):
            pace = math.hypot(field.disc[j, U], field.disc[j, W]) + field.disc[j, GROWTH]
            nearest = min(nearest, (gap + CLOSER) / (field.speed + pace))
    for e in range(len(field.keep)):
        if e != -2 - int(wait[OTHER]):
            gap, _ = gap_to(field, x, y, 0.0, 0.0, t, -1, e)
            nearest = min(nearest, (gap + CLOSER) / field.speed)
    if wait[WAIT] == WALL:
        # Beyond its ends an edge has corners, which are discs.
        b = wait[SHAPE + 6 :]
        along = (x - b[X]) * b[U] + (y - b[Y]) * b[W]
        nearest = min(nearest, (min(along, b[EDGE_LENGTH] - along) + CLOSER) / field.speed)
    return nearest


def change_wait(field, a, leaving, x, y, t, moves, count, heap):
    """List all waits that are where the robot is at a time."""
    for k in range(len(field.wait)):
        wait = field.wait[k]
        if wait[SINCE] <= t * (1 + TURNED) and t < wait[UNTIL]:
            px, py, _, _ = wait_at(wait, t)
            if math.hypot(px - x, py - y) < THERE:
                onto = len(field.disc) + k + 0.0
                move = (a + 0.0, leaving, x, y, 0.0, 0.0, t, 0.0, onto, 1.0, 0.0, 0.0)
                moves, count = list_move(field, move, 1.0, 0.0, moves, count, heap)
    return moves, count


def list_move(field, move, nx, ny, moves, count, heap):
    """List a move that ends at a normal (nx, ny) of the disc that it leads to."""
    j = int(move[ONTO])
    lasts = move[LASTS]
    t, x, y = move[WHEN] + lasts, move[MX] + lasts * move[MV], move[MY] + lasts * move[MW]
    if j >= len(field.disc):
        t, x, y = field.wait[j - len(field.disc), UNTIL : END_Y + 1]
    elif is_outside(field, j, nx, ny):
        return moves, count
    promise = t if j == TARGET else earliest(field, x, y, t)
    if promise == math.inf:
        return moves, count
    if count == len(moves):
        moves = doubled(moves)
    for column in range(len(move)):
        moves[count, column] = move[column]
    heappush(heap, (promise, count))
    return moves, count + 1


def is_outside(field, j, nx, ny):
    """Whether a normal is out of a corner's cone."""
    ax, ay, bx, by = field.cone[j]
    return ax * ny - ay * nx < -TURNED or nx * by - ny * bx < -TURNED


def earliest(field, x, y, t):
    """When (s) the robot could be at the goal if only what covers that stood in its way."""
    t += math.hypot(field.disc[TARGET, X] - x, field.disc[TARGET, Y] - y) / field.speed
    for k in range(len(field.covered)):
        if field.covered[k, 0] < t < field.covered[k, 1]:
            return field.covered[k, 1]
    return t


def go_on(field, labels, a, newest, waited, moves, count, heap):
    """Follow a slide for a part of a turn, and list all moves that leave it there."""
    label = labels[a]
    begin = label[DONE]
    end = min(begin + PART, 2 * math.pi)
    looks = np.empty((LOOKS + 1, 7))
    look(field, label, begin, end, looks)
    stop = first_end(field, labels, a, newest, looks)
    label[DONE] = stop
    if stop <= begin:
        return moves, count
    if stop < end:
        look(field, label, begin, stop, looks)
    for j in range(len(field.disc)):
        if j != label[DISC]:
            for side in range(2 if j != TARGET else 1):
                sense = 1 - 2 * side
                moves, count = leave(field, label, a, j, sense, looks, moves, count, heap)
    _, x, y, _, _, t, _ = looks[0]
    for k in range(len(field.wait)):
        wait = field.wait[k]
        far = math.hypot(wait[END_X] - x, wait[END_Y] - y)
        in_time = far <= field.speed * (wait[UNTIL] - t) + CLOSER and not waited[k]
        if in_time and label[DISC] != wait[ONE] and label[DISC] != wait[OTHER]:
            j = len(field.disc) + k
            moves, count = leave(field, label, a, j, 1, looks, moves, count, heap)
    if stop < end:
        _, x, y, _, _, t, _ = looks[LOOKS]
        moves, count = change_wait(field, a, stop, x, y, t, moves, count, heap)
    moves, count = ride_to_goal(field, label, a, begin, moves, count, heap)
    moves, count = ride_to_corners(field, label, a, begin, waited, moves, count, heap)
    if stop == end and end < 2 * math.pi:
        _, x, y, _, _, t, _ = looks[LOOKS]
        promise = earliest(field, x, y, t)
        if promise < math.inf:
            heappush(heap, (promise, -1 - a))
    return moves, count


def look(field, label, begin, end, looks):
    """Note how far, where, how fast, when, and how far its velocity turned, at steps of a slide."""
    looks[0, 6] = 0.0
    for k in range(LOOKS + 1):
        turned = begin + (end - begin) * (k / LOOKS)
        looks[k, 0] = turned if k < LOOKS else end
        looks[k, 1], looks[k, 2], looks[k, 3], looks[k, 4], looks[k, 5] = slide_at(
            field, label, looks[k, 0]
        )
        if k > 0:
            _, _, _, vx, vy, _, so_far = looks[k - 1]
            sine, cosine = vx * looks[k, 4] - vy * looks[k, 3], vx * looks[k, 3] + vy * looks[k, 4]
            looks[k, 6] = so_far + abs(math.atan2(sine, cosine))


def first_end(field, labels, a, newest, looks):
    """How far (rad) the part of a slide looked at goes on at most."""
    label = labels[a]
    i, begin, end = int(label[DISC]), looks[0, 0], looks[LOOKS, 0]
    stop = min(end, begin + end_of_cone(field, label, begin))
    stop = overtaken(field, labels, a, newest, stop)
    x, y, t, lasts = looks[0, 1], looks[0, 2], looks[0, 5], looks[LOOKS, 5] - looks[0, 5]
    for j in range(1, len(field.disc)):
        cx, cy, u, w, radius, g = field.disc[j]
        near = radius + g * t + lasts * (field.speed + math.hypot(u, w) + g)
        dx, dy = cx + u * t - x, cy + w * t - y
        if j != i and dx * dx + dy * dy < near * near and not is_same(field, i, j):
            met = first_met(field, label, begin, stop, j, -1)
            if met < stop:
                stop, label[ENDED_BY] = met, j
    for e in range(len(field.keep)):
        if e != field.own[i, 0] and e != field.own[i, 1]:
            gap, _ = gap_to(field, x, y, 0.0, 0.0, t, -1, e)
            if gap < lasts * field.speed:
                stop = min(stop, first_met(field, label, begin, stop, -1, e))
    return stop


def is_same(field, i, j):
    """Whether two discs are one and the same."""
    return np.abs(field.disc[i] - field.disc[j]).max() <= CLOSER


def end_of_cone(field, label, begin):
    """How much farther (rad) a slide can go round the corner that it is on."""
    i, sense = int(label[DISC]), label[SENSE]
    ax, ay, bx, by = field.cone[i]
    if ax == 0 and ay == 0:
        return math.inf
    last = math.atan2(by, bx) if sense > 0 else math.atan2(ay, ax)
    rest = (sense * (last - label[BEARING]) - begin) % (2 * math.pi)
    # A line along an edge leaves where the cone ends, and round-off must not hide it.
    return (0.0 if rest > 2 * math.pi - 1e-6 else rest) + PAST


def overtaken(field, labels, a, newest, stop):
    """How far (rad) a slide goes on until another one was there before."""
    label = labels[a]
    b = newest[int(label[DISC]), int(label[SENSE] < 0)]
    while b >= 0:
        other = labels[b]
        if b != a:
            ahead = (label[SENSE] * (other[BEARING] - label[BEARING])) % (2 * math.pi)
            if label[DONE] < ahead < stop:
                _, _, _, _, t = slide_at(field, label, ahead)
                if other[TIME] <= t and can_wait(
                    field, int(label[DISC]), other[BEARING], other[TIME], t
                ):
                    stop = ahead
        b = int(other[OLDER])
    return stop


def gap_to(field, x, y, vx, vy, t, j, e):
    """Distance beyond that to keep (m) from disc j, or else edge e, and its rate (m/s)."""
    if j >= 0:
        cx, cy, u, w, radius, g = field.disc[j]
        dx, dy, r = x - cx - u * t, y - cy - w * t, radius + g * t
        vx, vy = vx - u, vy - w
    else:
        ax, ay, bx, by = field.edge[e]
        ex, ey, g, r = bx - ax, by - ay, 0.0, field.keep[e]
        share = ((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey)
        share = min(max(share, 0.0), 1.0)
        dx, dy = x - ax - share * ex, y - ay - share * ey
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0:
        return -r, 0.0
    return distance - r, (dx * vx + dy * vy) / distance - g


def first_met(field, label, begin, stop, j, e):
    """How far (rad) a slide can go on from `begin` until it meets disc j, or else edge e.

    Seen from what it comes to, distance bends down no more than the slide bends: by
    steps no longer than that allows nothing is missed, and they are Newton's in the end.
    """
    i = int(label[DISC])
    u, w = field.disc[i, U], field.disc[i, W]
    bend = 2 * field.speed * (field.speed + math.hypot(u, w))
    bend /= field.disc[i, RADIUS] + field.disc[i, GROWTH] * label[TIME]
    turned = begin
    x, y, vx, vy, t = slide_at(field, label, turned)
    for creep in range(16 * CREEPS):
        gap, rate = gap_to(field, x, y, vx, vy, t, j, e)
        if gap < -CLOSER / 2:
            return turned
        if turned >= stop:
            return stop
        lasts = (rate + math.sqrt(rate * rate + 2 * bend * (gap + CLOSER))) / bend
        angle = label[BEARING] + label[SENSE] * turned
        pace = rim_speed(field, i, label[SENSE], math.cos(angle), math.sin(angle))
        pace /= field.disc[i, RADIUS] + field.disc[i, GROWTH] * t
        step = lasts * pace
        if creep > CREEPS:
            step = max(step, PART / 256)
        while True:
            x, y, vx, vy, later = slide_at(field, label, min(turned + step, stop))
            if later - t <= lasts * (1 + 1e-6) or creep > CREEPS:
                break
            step *= 0.98 * lasts / (later - t)
        turned, t = min(turned + step, stop), later
    return turned


def leave(field, label, a, j, sense, looks, moves, count, heap):
    """List the lines that leave a slide, in the part looked at, and graze disc j."""
    _, x, y, vx, vy, t, _ = looks[0]
    sine, cosine, far = aside(field, label, x, y, vx, vy, t, j, sense)
    if j < len(field.disc) and passes_by(field, looks, j, cosine, far):
        return moves, count
    speed = 2 * field.speed
    if j < len(field.disc):
        speed = field.speed + math.hypot(field.disc[j, U], field.disc[j, W])
    for k in range(LOOKS):
        begin, end, from_t = looks[k, 0], looks[k + 1, 0], looks[k, 5]
        _, x, y, vx, vy, t, _ = looks[k + 1]
        next_sine, next_cosine, next_far = aside(field, label, x, y, vx, vy, t, j, sense)
        # So close to a small disc, its direction changes by much in one step.
        steps = min(int(2 * speed * (t - from_t) / max(min(far, next_far), 1e-12)) + 1, 64)
        turned = begin
        for step in range(1, steps + 1):
            to, to_sine, to_cosine = end, next_sine, next_cosine
            if step < steps:
                to = begin + (end - begin) * step / steps
                x, y, vx, vy, t = slide_at(field, label, to)
                to_sine, to_cosine, _ = aside(field, label, x, y, vx, vy, t, j, sense)
            before, after = label[SENSE] * sine, label[SENSE] * to_sine
            # The slide turns towards the line wherever it passes it: it does so once a turn.
            if before < 0 <= after and after * cosine - to_cosine * before > 0:
                moves, count = leave_between(
                    field, label, a, j, sense, turned, to, sine, to_sine, moves, count, heap
                )
            turned, sine, cosine = to, to_sine, to_cosine
        far = next_far
    return moves, count


def passes_by(field, looks, j, cosine, far):
    """Whether a slide, in the part looked at, surely never points along a line that grazes disc j.

    Given are the cosine of the angle between the two where the part begins, and the distance (m).
    """
    _, _, u, w, radius, g = field.disc[j]
    t, lasts, pace = looks[0, 5], looks[LOOKS, 5] - looks[0, 5], math.hypot(u, w)
    moved = (field.speed + pace + g) * lasts
    near, r = far - moved, radius + g * (t + lasts)
    if near <= r:
        return False
    # A tangent turns by no more than it is moved sideways, over its length, and the velocity along
    # it, which is the disc's and a part along the tangent, by so many times that.
    times = 1 + pace / math.sqrt(field.speed * field.speed - (pace + g) * (pace + g))
    turned = looks[LOOKS, 6] + times * moved / math.sqrt(near * near - r * r)
    return turned < math.pi and cosine < math.cos(turned)


def aside(field, label, x, y, vx, vy, t, j, sense):
    """Sine and cosine of the angle from the line that grazes disc j to a velocity; distance (m)."""
    gx, gy, _, _, _ = graze(field, x, y, t, j, sense)
    if j < len(field.disc):
        cx, cy, u, w, _, _ = field.disc[j]
        far = math.hypot(cx + u * t - x, cy + w * t - y)
        squared = field.speed * field.speed
    else:
        wait = field.wait[j - len(field.disc)]
        far = math.hypot(wait[END_X] - x, wait[END_Y] - y)
        # A line to a wait may be slow: it leaves along the rim as seen from there.
        cx, cy, u, w, radius, g = field.disc[int(label[DISC])]
        swell = g / (radius + g * t)
        u, w = u + swell * (x - cx - u * t), w + swell * (y - cy - w * t)
        gx, gy, vx, vy = gx - u, gy - w, vx - u, vy - w
        squared = max(math.hypot(gx, gy) * math.hypot(vx, vy), LEAST)
    return (gx * vy - gy * vx) / squared, (gx * vx + gy * vy) / squared, far


def leave_between(field, label, a, j, sense, low, high, below, above, moves, count, heap):
    """List the line that leaves a slide between two angles, of which the sines are given.

    The root is found by regula falsi as M. Dowell and P. Jarratt bend it (*BIT* 1971).
    """
    for _ in range(60):
        turned = high - above * (high - low) / (above - below)
        if not min(low, high) < turned < max(low, high):
            break
        x, y, vx, vy, t = slide_at(field, label, turned)
        sine, _, _ = aside(field, label, x, y, vx, vy, t, j, sense)
        if sine * above < 0:
            low, below = high, above
        else:
            # Between two thirds of what it was and nothing: the end that stays is drawn nearer.
            below *= above / (above + sine) if sine != 0 else 1.0
        high, above = turned, sine
        if abs(high - low) < 1e-14 or abs(above) < 1e-15:
            break
    turned = high
    x, y, _, _, t = slide_at(field, label, turned)
    # As fast as the slide, but to a wait that it would be at too early.
    vx, vy, lasts, nx, ny = graze(field, x, y, t, j, sense)
    if lasts < 0:
        return moves, count
    touch = math.atan2(ny, nx)
    move = (a + 0.0, turned, x, y, vx, vy, t, lasts, j + 0.0, sense + 0.0, touch, STRAIGHT + 0.0)
    return list_move(field, move, nx, ny, moves, count, heap)


def ride_to_goal(field, label, a, begin, moves, count, heap):
    """List the ride at the place of the rim that is to leave the goal, where the slide is early."""
    when, angle = field.release[int(label[DISC])]
    if math.isnan(when):
        return moves, count
    return ride_at(field, label, a, begin, angle, when, TARGET, moves, count, heap)


def ride_to_corners(field, label, a, begin, waited, moves, count, heap):
    """List the rides at places of the rim to where a corner that can be waited at comes later."""
    i = int(label[DISC])
    cx, cy, u, w, _, _ = field.disc[i]
    for k in range(len(field.wait)):
        wait = field.wait[k]
        if waited[k] or wait[WAIT] == RELEASE or (i != int(wait[ONE]) and i != int(wait[OTHER])):
            continue
        for m in range(MEETINGS):
            when = wait[SINCE] + (wait[UNTIL] - wait[SINCE]) * (m / MEETINGS)
            px, py, _, _ = wait_at(wait, when)
            angle = math.atan2(py - cy - w * when, px - cx - u * when)
            onto = len(field.disc) + k
            moves, count = ride_at(field, label, a, begin, angle, when, onto, moves, count, heap)
    return moves, count


def ride_at(field, label, a, begin, angle, when, onto, moves, count, heap):
    """List the ride at a place of the rim until a time, if the part of a slide passes it before."""
    ahead = (label[SENSE] * (angle - label[BEARING])) % (2 * math.pi)
    if not (begin < ahead <= label[DONE] or begin == ahead == 0):
        return moves, count
    x, y, _, _, t = slide_at(field, label, ahead)
    if t > when:
        return moves, count
    u, w, _, g = field.disc[int(label[DISC]), U : GROWTH + 1]
    vx, vy = u + g * math.cos(angle), w + g * math.sin(angle)
    move = (a + 0.0, ahead, x, y, vx, vy, t, when - t, onto + 0.0, 1.0, 0.0, RIDE + 0.0)
    return list_move(field, move, 1.0, 0.0, moves, count, heap)


def is_open(field, labels, move):
    """Whether a move meets nothing."""
    if move[LASTS] == 0 and move[ONTO] >= len(field.disc):
        return is_there(field, move[MX], move[MY], move[WHEN])
    a = int(move[ON])
    i = int(labels[a, DISC]) if a >= 0 else TARGET
    return is_free(
        field, move[MX], move[MY], move[MV], move[MW], move[WHEN], move[LASTS], i, int(move[ONTO])
    )


def is_there(field, x, y, t):
    """Whether a slide that ended at a place can change to a wait there, for all that it meets."""
    nearest = math.inf
    for j in range(1, len(field.disc)):
        nearest = min(nearest, gap_to(field, x, y, 0.0, 0.0, t, j, -1)[0])
    for e in range(len(field.keep)):
        nearest = min(nearest, gap_to(field, x, y, 0.0, 0.0, t, -1, e)[0])
    return nearest > -THERE


def is_free(field, x, y, vx, vy, t, lasts, i, j):
    """Whether a straight motion meets no edge, and no disc but perhaps i and j."""
    for k in range(1, len(field.disc)):
        cx, cy, u, w, radius, g = field.disc[k]
        dx, dy, wx, wy = cx + u * t - x, cy + w * t - y, vx - u, vy - w
        r = radius + g * t - CLOSER
        nearing, apart = dx * wx + dy * wy + r * g, dx * dx + dy * dy - r * r
        if k in (i, j) or (apart >= 0 and nearing <= 0):
            continue
        square = wx * wx + wy * wy - g * g
        root = nearing * nearing - square * apart
        if apart < 0 or (root > 0 and nearing - math.sqrt(root) < square * lasts):
            return False
    to_x, to_y = x + vx * lasts, y + vy * lasts
    barred = False
    for e in range(len(field.keep)):
        # It reads the edges and what they keep.
        barred = barred or bars(x, y, to_x, to_y, field, e)
    return not barred
