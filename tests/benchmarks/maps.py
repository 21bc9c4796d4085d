"""Time and memory of the exact planner in maps: ``python tests/benchmarks/maps.py``.

One row a world: the median and the slowest of some queries, each in a world that was
never planned in (so that preparation counts), the median in one that was, and the largest
memory. With ``--quick`` it prints a few rows of small worlds only.
"""

import argparse
import statistics
import sys
import time
import tracemalloc
from functools import partial

import numpy as np
import shapely
from scipy import ndimage

import freeseg as fs

SMALL = fs.KheperaIV()


def squares(side, pitch=0.37, size=0.2):
    """A square of square blocks, `pitch` apart: between its corners, ties everywhere."""
    corners = size * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    places = pitch * np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    world = fs.World([fs.Polygon(place + corners) for place in places])
    far = pitch * side
    return world, [((-0.2, -0.2), (far, far)), ((-0.2, far), (far, -0.2))]


def star(corners, inner=4.0, outer=5.0):
    """One star, from one side to the other."""
    angle = 2 * np.pi * np.arange(corners) / corners
    radius = np.where(np.arange(corners) % 2, inner, outer)[:, None]
    world = fs.World([fs.Polygon(radius * np.column_stack([np.cos(angle), np.sin(angle)]))])
    return world, [((-6, 0.1), (6, 0.2)), ((0.1, -6), (0.2, 6))]


def maze(side, seed=0, pitch=0.5):
    """Walls of a maze of square rooms in which every room is reached, and two opposite corners."""
    rng, walls = np.random.default_rng(seed), set()
    for x in range(side):
        for y in range(side):
            walls |= {(x, y, 0), (x, y, 1), (x + 1, y, 1), (x, y + 1, 0)}
    stack, seen = [(0, 0)], {(0, 0)}
    while stack:
        x, y = stack[-1]
        steps = [((x + 1, y), (x + 1, y, 1)), ((x - 1, y), (x, y, 1))]
        steps += [((x, y + 1), (x, y + 1, 0)), ((x, y - 1), (x, y, 0))]
        new = [
            (to, wall) for to, wall in steps if to not in seen and 0 <= min(to) <= max(to) < side
        ]
        if not new:
            stack.pop()
            continue
        to, wall = new[rng.integers(len(new))]
        walls.remove(wall)
        seen.add(to)
        stack.append(to)
    lines = [[(x, y), (x + (1 - up), y + up)] for x, y, up in sorted(walls)]
    ends = pitch * np.sort(np.array(lines), axis=1)
    boxes = shapely.box(*(ends[:, 0] - 0.02).T, *(ends[:, 1] + 0.02).T)
    world = fs.World([fs.Polygon(box.exterior.coords[:-1]) for box in boxes])
    near, far = 0.5 * pitch, (side - 0.5) * pitch
    return world, [((near, near), (far, far)), ((near, far), (far, near))]


def grid_map(side, seed=0, cell=0.1):
    """A map of cells as rectangles that touch, as people cut occupancy grids."""
    rng = np.random.default_rng(seed)
    noise = ndimage.gaussian_filter(rng.normal(size=(side, side)), side / 60)
    occupied = noise > np.quantile(noise, 0.6)
    boxes = []
    for row in range(side):
        change = np.flatnonzero(np.diff(np.r_[0, occupied[row].astype(int), 0]))
        boxes += [(a, row, b, row + 1) for a, b in change.reshape(-1, 2)]
    merged, last = [], {}
    for a, y, b, top in boxes:
        key = (a, b)
        if key in last and merged[last[key]][3] == y:
            merged[last[key]][3] = top
        else:
            last[key] = len(merged)
            merged.append([a, y, b, top])
    world = fs.World(
        [
            fs.Polygon(np.array(shapely.box(*(cell * np.array(one))).exterior.coords[:-1]))
            for one in merged
        ]
    )
    return world, queries_in(world, cell * side, seed)


def queries_in(world, extent, seed, count=5):
    """Queries far apart where the robot fits."""
    rng, queries = np.random.default_rng(seed), []
    while len(queries) < count:
        ends = rng.uniform(0, extent, (2, 2))
        far = np.hypot(*(ends[1] - ends[0])) > 0.6 * extent
        if far and world.distances(shapely.points(ends)[:, None]).min() > SMALL.radius + 0.003:
            queries.append(tuple(map(tuple, ends)))
    return queries


def random_polygons(n, seed=0):
    """Random polygons, corner to corner."""
    world = fs.random_world(n, seed, shapes=("polygon",))
    low, high = world.edges.min((0, 1)) - 0.1, world.edges.max((0, 1)) + 0.1
    return world, [(low, high), ((low[0], high[1]), (high[0], low[1]))]


def random_discs(n, worlds):
    """Random discs: queries as they come, or corner to corner."""
    for seed in range(worlds):
        world = fs.random_world(n, seed)
        low, high = world.edges.min((0, 1)) - 0.1, world.edges.max((0, 1)) + 0.1
        yield world, [fs.random_query(world, seed), (low, high)]


def timed(action):
    """Time (ms) that an action takes; NoPath is an answer like others."""
    begin = time.perf_counter()
    try:
        plan = action()
    except fs.NoPath:
        plan = None
    return 1e3 * (time.perf_counter() - begin), plan


def measure(name, worlds, planner=fs.shortest_path, memory=True):
    """Print a row; return the lengths found."""
    first, again, lengths = [], [], []
    for world, queries in worlds:
        for start, goal in queries:
            fresh = fs.World(world.obstacles)
            ask = partial(planner, fresh, start, goal)
            duration, plan = timed(ask)
            first.append(duration)
            again.append(timed(ask)[0])
            lengths.append(plan.path.length if plan else np.nan)
    peak = np.nan
    if memory:
        fresh = fs.World(world.obstacles)
        tracemalloc.start()
        timed(partial(planner, fresh, start, goal))
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
    print(
        f"{name:34s} first {statistics.median(first):9.2f} ms, slowest {max(first):9.2f} ms, "
        f"again {statistics.median(again):9.2f} ms, {peak:7.1f} MB, {len(first)} queries",
        flush=True,
    )
    return lengths


def main(arguments):
    """Measure."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args(arguments)
    timed(partial(fs.shortest_path, *_large_enough_to_compile()))
    sizes = {7: 3} if options.quick else {7: 20, 100: 20, 1000: 10, 10000: 10}
    for n, worlds in sizes.items():
        measure(f"{n} discs", random_discs(n, worlds))
    if options.quick:
        measure("5 x 5 squares", [squares(5)])
        return
    measure("1000 polygons, corner to corner", (random_polygons(1000, seed) for seed in range(5)))
    measure("22 x 22 squares", [squares(22)])
    measure("32 x 32 squares", [squares(32)])
    measure("star of 5000 corners", [star(5000)])
    measure("regular 2000-gon", [star(2000, 5.0)])
    for planner in (fs.shortest_path, fs.plan, fs.with_fallback(fs.plan_rooms, fs.shortest_path)):
        measure(f"maze 20 x 20, {planner.__name__}", [maze(20)], planner=planner)
    for side in (400, 768):
        measure(f"map of {side} x {side} cells", [grid_map(side)])


def _large_enough_to_compile():
    """A query that has numba compile, or load, the search."""
    world = fs.random_world(100, 1)
    return world, *fs.random_query(world, 1)


if __name__ == "__main__":
    main(sys.argv[1:])
