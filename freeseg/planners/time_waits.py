"""Where among movers it can pay to wait: at corners of discs that overlap, and at the goal.

A time-minimal motion among discs that do not overlap never waits. Where two overlap, or one
overlaps a wall, a gap may open between them. Before that, their common corner runs towards
the gap, slowly at first, and infinitely fast in the end. Whoever rides on the corner until it
is as fast as the robot, and goes on at full speed from there, passes the gap first: at its
last time the corner moves as the slides on both discs do.
"""

from collections.abc import Callable

import numpy as np

from freeseg.planners.time_search import (
    CORNER,
    END_X,
    END_Y,
    FROM,
    GROWTH,
    ONE,
    OTHER,
    RADIUS,
    RELEASE,
    SHAPE,
    SIDE,
    UNTIL,
    WAIT,
    WALL,
    U,
    W,
    X,
    Field,
    Y,
    corner_at,
    wall_at,
)
from freeseg.planners.timed_query import meeting

#: Number of columns of a wait.
COLUMNS = SHAPE + 12

#: Corners are looked at so many times, closer to each other towards both ends.
LOOKS = 120

#: When a corner is as fast as the robot is found by halving an interval so often.
HALVINGS = 60


def find_waits(field: Field, latest: float) -> np.ndarray:
    """All waits that could make a robot arrive before a time.

    Parameters
    ----------
    field : Field
        What the search is given; its own waits are not looked at.
    latest : float
        When the robot arrives without them (s), or infinite.

    Returns
    -------
    ndarray, shape (m, 20)
        Columns as in `time_search`.
    """
    found = np.concatenate([_releases(field), _corners(field, latest), _walls(field, latest)])
    end, until = found[:, END_X : END_Y + 1], found[:, UNTIL]
    before, after = (np.hypot(*(end - place).T) for place in (field.start, field.disc[0, :2]))
    # It must be reached in time, and must leave time enough.
    useful = (before <= field.speed * until) & (until + after / field.speed < latest)
    return np.ascontiguousarray(found[useful])


def _releases(field: Field) -> np.ndarray:
    """Places of rims that leave the goal last: they move evenly."""
    which = np.flatnonzero(np.isfinite(field.release[:, 0]))
    found = np.zeros((len(which), COLUMNS))
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
    found = np.zeros((len(one), COLUMNS))
    found[:, WAIT], found[:, ONE], found[:, OTHER] = CORNER, one, other
    found[:, SHAPE : SHAPE + 6], found[:, SHAPE + 6 :] = disc[one], disc[other]
    return _rides(field, found, first, last, latest, corner_at)


def _walls(field: Field, latest: float) -> np.ndarray:
    """Corners of a disc that moves and the line that keeps its distance from an edge."""
    moving = np.flatnonzero(field.disc[:, U : GROWTH + 1][:, [0, 1, 3]].any(1))
    disc = np.repeat(moving, 2 * len(field.keep))
    edge = np.tile(np.repeat(field.edge, 2, 0), (len(moving), 1)).reshape(-1, 4)
    keep = np.tile(np.repeat(field.keep, 2), len(moving)) * np.tile([1, -1], len(disc) // 2)
    along = edge[:, 2:] - edge[:, :2]
    along /= np.hypot(*along.T)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], -1)
    found = np.zeros((len(disc), COLUMNS))
    found[:, WAIT], found[:, ONE], found[:, OTHER] = WALL, disc, -1
    found[:, SHAPE : SHAPE + 6] = field.disc[disc]
    found[:, SHAPE + 6 : SHAPE + 8] = edge[:, :2] + keep[:, None] * across
    found[:, SHAPE + 6 + U : SHAPE + 6 + W + 1] = along
    offset = field.disc[disc, :2] - found[:, SHAPE + 6 : SHAPE + 8]
    offset = (offset * across).sum(-1, keepdims=True) * [1, 0]
    drift = (field.disc[disc, U : W + 1] * across).sum(-1, keepdims=True) * [1, 0]
    first, last = meeting(offset, drift, field.disc[disc, RADIUS], field.disc[disc, GROWTH])
    return _rides(field, found, first, last, latest, wall_at)


def _rides(
    field: Field,
    found: np.ndarray,
    first: np.ndarray,
    last: np.ndarray,
    latest: float,
    place: Callable[..., tuple[np.ndarray, ...]],
) -> np.ndarray:
    """Rides on corners that are there from `first` until `last`, to where they are too fast."""
    ends = last[np.isfinite(last)]
    last = np.minimum(last, latest if np.isfinite(latest) else ends.max(initial=0.0))
    there = first < last
    found, first, last = (np.concatenate([one[there]] * 2) for one in (found, first, last))
    found[:, SIDE] = np.repeat([1, -1], len(found) // 2)
    shape, side = found[:, SHAPE:].T[..., None], found[:, SIDE, None]

    def is_slow(t: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Whether corners are slower than the robot at times (rows, ...)."""
        with np.errstate(all="ignore"):
            _, _, vx, vy = place(shape[:6, rows], shape[6:, rows], side[rows], t)
            return np.hypot(vx, vy) < field.speed  # not where it is not there

    def change(slow: np.ndarray, fast: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """When it is as fast as the robot, between times when it is slower and faster."""
        for _ in range(HALVINGS):
            middle = (slow + fast) / 2
            slower = is_slow(middle[:, None], rows)[:, 0]
            slow, fast = np.where(slower, middle, slow), np.where(slower, fast, middle)
        return slow

    share = (1 - np.cos(np.linspace(0, np.pi, LOOKS))) / 2
    t = first[:, None] + (last - first)[:, None] * share
    slow = is_slow(t, np.arange(len(found)))
    slow[:, -1] &= last >= latest
    row, end = np.nonzero(slow[:, :-1] & ~slow[:, 1:])
    # The look at which it began to be slow.
    begin = np.where(slow, 0, np.arange(LOOKS)[None])
    begin = np.maximum.accumulate(begin, 1)[row, end]
    begin_is_slow = slow[row, begin]
    until = change(t[row, end], t[row, end + 1], row)
    since = change(t[row, begin + 1 - begin_is_slow], t[row, begin], row)
    found = found[row]
    found[:, FROM], found[:, UNTIL] = np.where(begin_is_slow, t[row, begin], since), until
    x, y, _, _ = place(found[:, SHAPE:].T[:6], found[:, SHAPE:].T[6:], found[:, SIDE], until)
    found[:, END_X], found[:, END_Y] = x, y
    return found
