"""Outlines of occupied cells: polygons with holes out of a grid.

Cells are squares of side 1 here, cell (row j, column i) from (i, j) to (i + 1, j + 1).
Rings run with the occupied side on their left: counter-clockwise round an obstacle,
clockwise round a hole in it.
"""

import numpy as np
import shapely

from freeseg.geometry import cross

#: The four directions of an edge, each a left turn from the one before: +x, +y, -x, -y.
DIRECTIONS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])

#: Corners that are not on the grid are rounded to this (cells): slivers that are thinner would not
#: outlive the next round-off.
SNAP = 2.0**-30


def trace_cells(occupied: np.ndarray, tolerance: float = 0.0) -> list[shapely.Polygon]:
    """Polygons that cover the occupied cells.

    Parameters
    ----------
    occupied : ndarray of bool, shape (h, w)
        Which cells are occupied.
    tolerance : float, optional
        How far a polygon may reach beyond its cells (cells); with 0 it is
        exactly them.

    Returns
    -------
    list of shapely.Polygon
        One for each set of cells that join at their sides. Every occupied cell
        is covered, and no point of a polygon is farther than `tolerance` from
        an occupied cell of it.
    """
    from scipy import ndimage

    if not occupied.any():
        return []
    corners, cells, sizes = _rings(occupied)
    label = ndimage.label(occupied)[0][cells[:, 1], cells[:, 0]]
    owner = label[np.cumsum(sizes) - sizes]
    rings = _linear_rings(corners, sizes)
    is_shell = shapely.is_ccw(rings)
    exact = _polygons(rings, owner, is_shell)
    if tolerance == 0:
        return list(exact.values())
    corners, sizes, kept, added, ring = _fill_notches(corners, sizes, tolerance)
    rings, owners, is_shell = _linear_rings(corners, sizes), owner[kept], is_shell[kept]
    polygons = _polygons(rings, owners, is_shell)
    # What is filled may reach over another part of the outline, which crosses itself then, or
    # over all of a hole, which turns inside out: the union is the answer there.
    crossing = {name for name, polygon in polygons.items() if not polygon.is_valid}
    for name in crossing.union(owners[shapely.is_ccw(rings) != is_shell].tolist()):
        filled = shapely.polygons(added[owner[ring] == name])
        filled = [exact[name], *filled[shapely.area(filled) > 0]]
        polygons[name] = shapely.union_all(filled, grid_size=SNAP)
    return list(polygons.values())


def _edges(occupied: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sides between an occupied and a free cell: start (n, 2), direction (n,), cell (n, 2)."""
    padded = np.pad(occupied, 1)
    inner = padded[1:-1, 1:-1]
    # The neighbour across the lower, right, upper and left side; where the side starts.
    across = padded[:-2, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1], padded[1:-1, :-2]
    offsets = (0, 0), (1, 0), (1, 1), (0, 1)
    starts, directions, cells = [], [], []
    for direction, (beyond, offset) in enumerate(zip(across, offsets, strict=True)):
        cell = np.argwhere(inner & ~beyond)[:, ::-1]
        starts.append(cell + offset)
        directions.append(np.full(len(cell), direction))
        cells.append(cell)
    return np.concatenate(starts), np.concatenate(directions), np.concatenate(cells)


def _rings(occupied: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (n, 2) of all rings, a cell inside at each, and the number of corners of each ring.

    No ring touches itself.
    """
    start, direction, cell = _edges(occupied)
    width = occupied.shape[1] + 1
    node = start @ (1, width)
    leaving = np.full((width * (occupied.shape[0] + 1), 4), -1)
    leaving[node, direction] = np.arange(len(node))
    end = (start + DIRECTIONS[direction]) @ (1, width)
    # Where cells meet at a corner only, a left turn stays with the same cell.
    turns = [leaving[end, (direction + turn) % 4] for turn in (1, 0, -1)]
    following = np.where(turns[0] >= 0, turns[0], np.where(turns[1] >= 0, turns[1], turns[2]))
    rings = [np.array(ring) for ring in _walk(following.tolist(), node.tolist())]
    # Only where it turns has a ring a corner.
    rings = [ring[direction[ring] != direction[np.roll(ring, 1)]] for ring in rings]
    order = np.concatenate(rings)
    return start[order], cell[order], np.array([len(ring) for ring in rings])


def _walk(following: list[int], node: list[int]) -> list[list[int]]:
    """Edges in the order of each ring, cut apart where a ring meets itself."""
    waiting, rings = [True] * len(following), []
    for first in range(len(following)):
        if not waiting[first]:
            continue
        ring: list[int] = []
        place: dict[int, int] = {}
        edge = first
        while waiting[edge]:
            waiting[edge] = False
            if node[edge] in place:
                since = place[node[edge]]
                loop = ring[since:]
                rings.append(loop)
                for passed in loop:
                    del place[node[passed]]
                del ring[since:]
            place[node[edge]] = len(ring)
            ring.append(edge)
            edge = following[edge]
        rings.append(ring)
    return rings


def _linear_rings(corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Rings as shapely has them."""
    return shapely.linearrings(corners.astype(float), indices=np.repeat(range(len(sizes)), sizes))


def _polygons(
    rings: np.ndarray, owner: np.ndarray, is_shell: np.ndarray
) -> dict[int, shapely.Polygon]:
    """Polygons out of the rings of each owner, of which one is its shell."""
    holes: dict[int, list] = {}
    for name, ring in zip(owner[~is_shell].tolist(), rings[~is_shell], strict=True):
        holes.setdefault(name, []).append(ring)
    return {
        name: shapely.Polygon(ring, holes.get(name))
        for name, ring in zip(owner[is_shell].tolist(), rings[is_shell], strict=True)
    }


def _fill_notches(
    corners: np.ndarray, sizes: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Leave out reflex corners, which only adds to what is inside.

    A corner v between a and b that turns right or not at all is left out: that adds
    the triangle a, v, b. No point of it is farther from the outline a, v, b than v is
    from the line a, b, so these heights, added up, bound the way from the cells.

    Parameters
    ----------
    corners, sizes : ndarray
        Rings, as `_rings` has them.
    tolerance : float
        Largest sum of heights.

    Returns
    -------
    corners, sizes : ndarray
        Rings that are left.
    kept : ndarray of int
        Which rings these are; a small hole may vanish.
    added : ndarray, shape (m, 3, 2)
        Triangles that were added.
    ring : ndarray of int, shape (m,)
        Which ring each was added to.
    """
    points, ring = corners.astype(float), np.repeat(np.arange(len(sizes)), sizes)
    gone = np.zeros(len(points))  # how far off the side from a corner to the next one may be
    rng = np.random.default_rng(0)
    added, owners = [], []
    while True:
        sizes = np.bincount(ring, minlength=len(sizes))
        begin = np.cumsum(sizes) - sizes
        after, before = np.arange(1, len(ring) + 1), np.arange(-1, len(ring) - 1)
        after[(begin + sizes - 1)[sizes > 0]] = begin[sizes > 0]
        before[begin[sizes > 0]] = (begin + sizes - 1)[sizes > 0]
        coming, leaving = points - points[before], points[after] - points
        base = np.hypot(*(points[after] - points[before]).T)
        twice = -cross(coming, leaving)
        height = np.divide(twice, base, out=np.zeros(len(ring)), where=base > 0)
        sums = height + np.maximum(gone[before], gone)
        wanted = (twice >= 0) & (sums <= tolerance)
        if not wanted.any():
            break
        # No two neighbours at once; which of them is chance, so that a few rounds do.
        turn = np.where(wanted, rng.random(len(ring)), np.inf)
        out = wanted & (turn < turn[before]) & (turn < turn[after])
        added.append(np.stack([points[before], points, points[after]], axis=1)[out])
        owners.append(ring[out])
        gone[before[out]] = sums[out]
        left = ~out
        left &= np.bincount(ring[left], minlength=len(sizes))[ring] > 2
        points, gone, ring = points[left], gone[left], ring[left]
    kept = np.flatnonzero(sizes)
    return (
        points,
        sizes[kept],
        kept,
        np.concatenate([*added, np.empty((0, 3, 2))]),
        np.concatenate([*owners, np.empty(0, int)]),
    )
