"""Time a batch of robots: ``python tests/benchmarks/batch.py``.

Prints robot-steps per second, by the clock and by the processor's own time,
from the medians of interleaved runs. On a machine that others use too, the
processor's time says more.
"""

import statistics
import time

import numpy as np

import freeseg as fs
from freeseg.studies.tracking import DISTURBANCE


def times_of(action):
    """Time of an action by the clock and by the processor (s)."""
    begin = time.perf_counter(), time.process_time()
    action()
    return time.perf_counter() - begin[0], time.process_time() - begin[1]


def main(robots=10_000, repeats=7):
    """Print all speeds."""
    case = fs.load_cases()["15a"]
    reference = fs.make_reference(fs.plan(fs.load_table(1), case.start, case.goal).path)
    offsets = np.random.default_rng(0).normal(0, [[0.02], [0.02], [0.2]], (3, robots))

    def run(offset, disturbance, seed=0):
        return fs.simulate(
            fs.SlidingMode(), reference, initial_offset=offset, disturbance=disturbance, seed=seed
        )

    rows = {
        f"{count} {kind}": (offset, disturbance)
        for kind, disturbance in (("undisturbed", None), ("disturbed", DISTURBANCE))
        for count, offset in ((robots, offsets), (1, offsets[:, 0]))
    }
    times = {name: [] for name in rows}
    for _ in range(repeats):
        for name, row in rows.items():
            times[name].append(times_of(lambda row=row: run(*row)))
    steps = len(run(offsets[:, 0], None).t) - 1
    speeds = {}
    print(f"robots over {steps} steps     robot-steps/s by the clock, by the processor")
    for name, values in times.items():
        count = int(name.split()[0])
        speeds[name] = [
            count * steps / statistics.median(column) for column in zip(*values, strict=True)
        ]
        print(f"{name:24s}" + "".join(f"{speed:15,.0f}" for speed in speeds[name]))
    for kind in ("undisturbed", "disturbed"):
        ratio = speeds[f"{robots} {kind}"][0] / speeds[f"1 {kind}"][0]
        print(f"batch over single, {kind:12s} {ratio:6.0f} times")
    for kind, disturbance in (("undisturbed", None), ("disturbed", DISTURBANCE)):
        batch = run(offsets, disturbance)
        same = all(
            np.array_equal(batch.pose[:, k], run(offsets[:, k], disturbance, (0, k)).pose)
            for k in np.linspace(0, robots - 1, min(robots, 20)).astype(int)
        )
        print(f"bit-equal to single, {kind:12s} {same}")


if __name__ == "__main__":
    main()
