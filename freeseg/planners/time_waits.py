"""Where among movers it can pay to wait: at corners of discs that overlap, and at the goal.

A time-minimal motion among discs that do not overlap never waits. Where two overlap, or one
overlaps a wall, a gap may open between them. Before that, their common corner runs towards
the gap, slowly at first, and infinitely fast in the end. Whoever rides on the corner until it
is as fast as the robot, and goes on at full speed from there, passes the gap first: at its
last time the corner moves as the slides on both discs do. Another disc may cut a ride before,
or the edge of a wall end: from there, the corner that begins there leads on.
"""

import math
from collections.abc import Callable
from types import ModuleType

import numpy as np

from freeseg.planners.time_search import (
    CORNER,
    EDGE_LENGTH,
    END_X,
    END_Y,
    GROWTH,
    LEAST,
    ONE,
    OTHER,
    RADIUS,
    RELEASE,
    SHAPE,
    SIDE,
    SINCE,
    UNTIL,
    WAIT,
    WALL,
    Field,
    U,
    W,
    corner_at,
    wall_at,
)
from freeseg.planners.timed_query import meeting

#: Number of columns of a wait.
WAIT_COLUMNS = SHAPE + 12

#: Corners are looked at so many times, closer to each other towards both ends.
CORNER_LOOKS = 120

#: Centres so near (m) to each other meet.
MEET = 1e-7

#: Where no way is known, rides are looked for so many times as long as the straight way takes.
EVER = 1000

#: When a corner is as fast as the robot is found by halving an interval so often.
HALVINGS = 60

#: Where corners are, and their velocities.
_Place = Callable[..., tuple[np.ndarray, ...]]


def find_waits(field: Field, kernels: ModuleType, latest: float) -> np.ndarray:
    """All waits that could make a robot arrive before a time.

    Parameters
    ----------
    field : Field
        What the search is given; its own waits are not looked at.
    kernels : module
        The search, compiled or not.
    latest : float
        When the robot arrives without them (s), or infinite.

    Returns
    -------
    ndarray, shape (m, 20)
        Columns as in `time_search`.
    """
    found = np.concatenate([_releases(field), _corners(field, latest), _walls(field, latest)])
    # A part of a ride may be useful where all of it is not, by what it takes at most.
    longest = found[:, UNTIL] - found[:, SINCE]
    found = found[_is_useful(field, found, latest, longest)]
    parts = kernels.free_parts(field._replace(wait=np.ascontiguousarray(found)))
    useful: np.ndarray = parts[_is_useful(field, parts, latest, 0.0)]
    return useful


def _is_useful(
    field: Field, found: np.ndarray, latest: float, spare: np.ndarray | float
) -> np.ndarray:
    """Whether waits, or what is so long (s) before their ends, can make a robot earlier."""
    until = found[:, UNTIL]
    before, after = (
        np.hypot(*(found[:, END_X : END_Y + 1] - place).T) / field.speed
        for place in (field.start, field.disc[0, :2])
    )
    useful: np.ndarray = (before <= until + spare) & (until + after - 2 * spare < latest)
    return useful


def _releases(field: Field) -> np.ndarray:
    """Places of rims that leave the goal last: they move evenly."""
    which = np.flatnonzero(np.isfinite(field.release[:, 0]))
    found = np.zeros((len(which), WAIT_COLUMNS))
    when, angle = field.release[which].T
    normal = np.stack([np.cos(angle), np.sin(angle)], -1)
    velocity = field.disc[which, U : W + 1] + field.disc[which, GROWTH, None] * normal
    found[:, WAIT], found[:, UNTIL], found[:, ONE], found[:, OTHER] = RELEASE, when, which, -1
    found[:, END_X : END_Y + 1] = field.disc[0, :2]
    found[:, SHAPE : SHAPE + 2] = field.disc[0, :2] - when[:, None] * velocity
    found[:, SHAPE + U : SHAPE + W + 1] = velocity
    return found


def _corners(field: Field, latest: float) -> np.ndarray:
    """Corners of two discs."""
    disc = field.disc
    one, other = np.triu_indices(len(disc), 1)
    drift = disc[one, U : W + 1] - disc[other, U : W + 1]
    swell = disc[one, GROWTH] + disc[other, GROWTH]
    keep = (one > 0) & (drift.any(1) | (swell > 0))
    one, other, drift, swell = one[keep], other[keep], drift[keep], swell[keep]
    offset = disc[one, :2] - disc[other, :2]
    first, last = meeting(offset, drift, disc[one, RADIUS] + disc[other, RADIUS], swell)
    found = np.zeros((len(one), WAIT_COLUMNS))
    found[:, WAIT], found[:, ONE], found[:, OTHER] = CORNER, one, other
    found[:, SHAPE : SHAPE + 6], found[:, SHAPE + 6 :] = disc[one], disc[other]
    # Where their centres are nearest, corners change sides, in no time if they all but meet.
    pace = np.maximum(np.hypot(*drift.T), LEAST)
    nearest = -(offset * drift).sum(-1) / pace**2
    meet = np.hypot(*(offset + nearest[:, None] * drift).T) < MEET
    before, after = nearest - MEET / pace, nearest + MEET / pace
    found, nearest = (np.concatenate([each, each[meet]]) for each in (found, nearest))
    first = np.concatenate([first, np.maximum(first, after)[meet]])
    last = np.concatenate([np.where(meet, np.minimum(last, before), last), last[meet]])
    return _rides(field, found, first, last, latest, corner_at, nearest)


def _walls(field: Field, latest: float) -> np.ndarray:
    """Corners of a disc that moves and the line that keeps its distance from an edge."""
    moving = np.flatnonzero(field.disc[:, U : GROWTH + 1][:, [0, 1, 3]].any(1))
    disc = np.repeat(moving, 2 * len(field.keep))
    edge = np.tile(np.repeat(field.edge, 2, 0), (len(moving), 1)).reshape(-1, 4)
    keep = np.tile(np.repeat(field.keep, 2), len(moving)) * np.tile([1, -1], len(disc) // 2)
    along = edge[:, 2:] - edge[:, :2]
    length = np.hypot(*along.T)
    along /= length[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], -1)
    found = np.zeros((len(disc), WAIT_COLUMNS))
    number = np.tile(np.repeat(np.arange(len(field.keep)), 2), len(moving))
    found[:, WAIT], found[:, ONE], found[:, OTHER] = WALL, disc, -2 - number
    found[:, SHAPE : SHAPE + 6] = field.disc[disc]
    found[:, SHAPE + 6 : SHAPE + 8] = edge[:, :2] + keep[:, None] * across
    found[:, SHAPE + 6 + U : SHAPE + 6 + W + 1] = along
    found[:, SHAPE + 6 + EDGE_LENGTH] = length
    offset = field.disc[disc, :2] - found[:, SHAPE + 6 : SHAPE + 8]
    offset = (offset * across).sum(-1, keepdims=True) * [1, 0]
    drift = (field.disc[disc, U : W + 1] * across).sum(-1, keepdims=True) * [1, 0]
    first, last = meeting(offset, drift, field.disc[disc, RADIUS], field.disc[disc, GROWTH])
    return _rides(field, found, first, last, latest, wall_at, first)


def _within_reach(field: Field, latest: float) -> tuple[np.ndarray, np.ndarray]:
    """From when until when a robot that arrives in time can touch each disc."""
    since, until = np.zeros(len(field.disc)), np.full(len(field.disc), latest)
    ends = [(field.start, 0.0, field.speed)]
    if np.isfinite(latest):
        ends.append((field.disc[0, :2], field.speed * latest, -field.speed))
    for end, reach, pace in ends:
        # Where the robot can be at a time is a disc that grows, and then shrinks.
        first, last = meeting(
            field.disc[:, :2] - end,
            field.disc[:, U : W + 1],
            field.disc[:, RADIUS] + reach,
            field.disc[:, GROWTH] + pace,
        )
        since, until = np.maximum(since, first), np.minimum(until, last)
    return since, until


def _rides(
    field: Field,
    found: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    latest: float,
    place: _Place,
    fastest: np.ndarray,
) -> np.ndarray:
    """Rides on corners that are there from `first` until `last`, to where they are too fast.

    Each is looked at also at the time when it can be fastest in between.
    """
    ends = last[np.isfinite(last)]
    far = math.dist(field.start, field.disc[0, :2]) or 1.0
    # What drives along an edge, but for round-off, never leaves it.
    ever = min(ends.max(initial=0.0), EVER * far / field.speed)
    horizon = latest if np.isfinite(latest) else ever
    near = _within_reach(field, latest)
    first, gone = np.maximum(first, near[0][found[:, ONE].astype(int)]), last
    last = np.minimum(np.minimum(last, near[1][found[:, ONE].astype(int)]), horizon)
    is_end = last == gone
    there = first < last
    found, first, last, is_end, fastest = (
        np.concatenate([one[there]] * 2) for one in (found, first, last, is_end, fastest)
    )
    found[:, SIDE] = np.repeat([1, -1], len(found) // 2)
    share = (1 - np.cos(np.linspace(0, np.pi, CORNER_LOOKS))) / 2
    t = first[:, None] + (last - first)[:, None] * share
    t = np.sort(np.column_stack([t, np.clip(fastest, first, last)]), 1)
    slow = _is_slow(field, found, t, place)
    # In the end it is infinitely fast.
    slow[:, -1] &= ~is_end
    # What is slow up to the end of what was looked at may yet be cut by something else.
    after = np.concatenate([slow[:, 1:], np.zeros((len(slow), 1), bool)], 1)
    row, end = np.nonzero(slow & ~after)
    if not len(row):
        return found[:0]
    # The look at which it began to be slow.
    begin = np.where(slow, 0, np.arange(slow.shape[1])[None])
    begin = np.maximum.accumulate(begin, 1)[row, end]
    begin_is_slow = slow[row, begin]
    found, t_row = found[row], t[row]
    each, fast = np.arange(len(row)), np.minimum(end + 1, CORNER_LOOKS)
    until = _change(field, found, t_row[each, end], t_row[each, fast], place)
    since = _change(field, found, t_row[each, begin + 1 - begin_is_slow], t_row[each, begin], place)
    found[:, SINCE], found[:, UNTIL] = np.where(begin_is_slow, t_row[each, begin], since), until
    x, y, _, _ = place(found[:, SHAPE:].T[:6], found[:, SHAPE:].T[6:], found[:, SIDE], until)
    found[:, END_X], found[:, END_Y] = x, y
    return found


def _is_slow(field: Field, found: np.ndarray, t: np.ndarray, place: _Place) -> np.ndarray:
    """Whether corners are there and slower than the robot at times (rows, k)."""
    shape = found[:, SHAPE:].T[..., None]
    with np.errstate(all="ignore"):
        _, _, vx, vy = place(shape[:6], shape[6:], found[:, SIDE, None], t)
        slow: np.ndarray = np.hypot(vx, vy) < field.speed
    return slow


def _change(
    field: Field, found: np.ndarray, slow: np.ndarray, fast: np.ndarray, place: _Place
) -> np.ndarray:
    """When corners are as fast as the robot, between times when they are slower and faster."""
    for _ in range(HALVINGS):
        middle = (slow + fast) / 2
        slower = _is_slow(field, found, middle[:, None], place)[:, 0]
        slow, fast = np.where(slower, middle, slow), np.where(slower, fast, middle)
    return slow
