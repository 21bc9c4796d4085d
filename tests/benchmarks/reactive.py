"""Time of a step of every reactive law: ``python tests/benchmarks/reactive.py``.

Each law drives among random discs and polygons; then all see again, step by step in turn, what
they saw, so that a slow moment of the machine hits all of them. A law alone is timed, without
the robot, by the processor's own time. Prints medians and 99th percentiles; ``--quick`` takes
one small world.
"""

import statistics
import sys
import time

import freeseg as fs

LAWS = fs.PotentialField(), fs.VectorFieldHistogram(), fs.DynamicWindow()

#: How many obstacles the worlds have, and how long the robot drives in each (steps).
SIZES, STEPS = (8, 50, 300), 200


def replay(world, start, goal, steps):
    """Times of the steps (s) of each law on the way from a start to a goal."""
    robot, dt, times = fs.KheperaIV(), 0.05, {type(law).__name__: [] for law in LAWS}
    seen = [
        fs.drive(law.start(world, goal, robot, dt), (*start, 0.0), dt, steps).measured
        for law in LAWS
    ]
    laws = [law.start(world, goal, robot, dt) for law in LAWS]
    for step in range(steps):
        for some, law, poses in zip(times.values(), laws, seen, strict=True):
            begin = time.process_time()
            law(dt * step, poses[:, step])
            some.append(time.process_time() - begin)
    return times


def main(sizes=SIZES, steps=STEPS):
    """Print a line for each number of obstacles and each law."""
    for n in sizes:
        world = fs.random_world(n, 0, ("disc", "polygon"))
        for name, some in replay(world, *fs.random_query(world, 0), steps).items():
            median, p99 = 1e3 * statistics.median(some), 1e3 * statistics.quantiles(some, n=100)[-1]
            print(f"{n:4d} obstacles  {name:22s} median {median:6.3f} ms  p99 {p99:6.3f} ms")


if __name__ == "__main__":
    main((8,), 20) if "--quick" in sys.argv else main()
