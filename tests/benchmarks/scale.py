"""Time and length against the number of obstacles: ``python tests/benchmarks/scale.py``.

Both planners answer the same queries in the same random worlds, of discs and of polygons, one
after the other, so that a slow moment of the machine hits both. A world is new to
the exact planner with every query, whose time so includes the preparation; the
free-segment planner's first query of a world is timed apart from the second.
Stores a row a query in ``data/scale.csv``, which the notebook on scale shows; with
``--quick`` it only prints, for small worlds.
"""

import statistics
import sys
import time
import tracemalloc
from functools import partial
from itertools import product

import freeseg as fs
from freeseg.data import DATA, write_csv
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS

ROOMS_FIRST = fs.with_fallback(fs.plan_rooms, fs.shortest_path)
SHAPES = "disc", "polygon"
FILE = DATA / "scale.csv"
SIZES = {7: 40, 20: 40, 50: 40, 100: 40, 200: 30, 500: 20, 1000: 20, 2000: 20, 5000: 20, 10000: 20}


def timed(action):
    """Result of an action, and the processor time (ms) that it took.

    Other programs on the machine lengthen it less than the time on the clock. Both
    planners use one thread.
    """
    begin = time.process_time()
    result = action()
    return result, 1e3 * (time.process_time() - begin)


def measure(n, seed, shape):
    """A row on one query of one world of n obstacles of a shape."""
    world = fs.random_world(n, seed, (shape,))
    start, goal = fs.random_query(world, seed)
    before = fs.random_query(world, seed + 10_000)
    try:
        # New worlds, for what was prepared to draw the queries must not be ready.
        prepared, fresh = fs.World(world.obstacles), fs.World(world.obstacles)
        _, first = timed(lambda: ROOMS_FIRST(prepared, *before))
        rooms, query = timed(lambda: ROOMS_FIRST(prepared, start, goal))
        best, exact = timed(lambda: fs.shortest_path(fresh, start, goal))
    except fs.NoPath:
        return None
    return {
        "shape": shape,
        "n": n,
        "seed": seed,
        "first_ms": first,
        "rooms_ms": query,
        "exact_ms": exact,
        "rooms_m": rooms.path.length,
        "exact_m": best.path.length,
        "completed": int(any(step.kind == "shortest" for step in rooms.steps)),
        "met": len(best.steps[-1].group),
        "rounds": len(best.steps) - 1,
    }


def measure_case(case, _):
    """Rows on one case, (shape, n, seed): one, or none where there is no path."""
    shape, n, seed = case
    row = measure(n, seed, shape)
    return [] if row is None else [row]


def corner_to_corner(n, repeats):
    """Median time (ms) of the exact planner across a whole world, and how many obstacles matter."""
    times, met = [], []
    for seed in range(repeats):
        world = fs.random_world(n, seed)
        low, high = world.edges.min((0, 1)) - 0.1, world.edges.max((0, 1)) + 0.1
        plan, duration = timed(partial(fs.shortest_path, world, low, high))
        times.append(duration)
        met.append(len(plan.steps[-1].group))
    return statistics.median(times), statistics.median(met)


def peak_memory(n):
    """Largest memory (MB) that planning in a world of n discs takes, both planners."""
    world = fs.random_world(n, 1)
    start, goal = fs.random_query(world, 1)
    tracemalloc.start()
    fs.shortest_path(world, start, goal)
    ROOMS_FIRST(world, start, goal)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main(sizes, file=None):
    """Measure, print medians, and write the rows to a file if one is given."""
    for shape in SHAPES:
        # Imports, and what is compiled, do not count.
        measure(100, 10_000, shape)
    cases = [
        (shape, n, seed)
        for shape in SHAPES
        for n, queries in sizes.items()
        for seed in range(queries)
    ]
    # One after the other: two at once would slow each other down.
    found = run(measure_case, cases, jobs=1, strict=True)
    rows = [{k: v for k, v in row.items() if k not in COLUMNS} for row in found]
    for shape, n in product(SHAPES, sizes):
        some = [row for row in rows if (row["shape"], row["n"]) == (shape, n)]
        numbers = [name for name in some[0] if name != "shape"]
        median = {name: statistics.median(row[name] for row in some) for name in numbers}
        ratio = statistics.median(row["rooms_m"] / row["exact_m"] for row in some)
        print(
            f"{shape}, n = {n:6d}: exact {median['exact_ms']:7.2f} ms, "
            f"{median['met']:.0f} obstacles met; "
            f"rooms {median['rooms_ms']:6.2f} ms, first query {median['first_ms']:7.2f} ms, "
            f"median ratio {ratio:.4f}"
        )
    largest = max(sizes)
    n = min(largest, 1000)
    duration, met = corner_to_corner(n, 5)
    print(f"n = {n:6d}, corner to corner: exact {duration:.1f} ms, {met:.0f} obstacles met")
    print(f"n = {largest:6d}: peak memory {peak_memory(largest):.0f} MB")
    if file:
        write_csv(
            file,
            [{k: round(v, 4) if k.endswith("_ms") else v for k, v in row.items()} for row in rows],
        )


if __name__ == "__main__":
    main({7: 3, 20: 3}) if "--quick" in sys.argv else main(SIZES, FILE)
