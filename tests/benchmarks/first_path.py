"""Time the first path: ``python tests/benchmarks/first_path.py``.

Prints medians. Timings of one table are interleaved, so that a slow moment of
the machine hits all of them alike.
"""

import statistics
import subprocess
import sys
import time

import freeseg as fs


def time_of(action):
    """Wall-clock time of an action (s)."""
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def medians(actions, repeats):
    """Median time of each of some named actions (s), interleaved."""
    times = {name: [] for name in actions}
    for _ in range(repeats):
        for name, action in actions.items():
            times[name].append(time_of(action))
    return {name: statistics.median(values) for name, values in times.items()}


def import_time(module):
    """Time that a fresh interpreter takes to import a module (s)."""
    clock = "__import__('time').perf_counter()"
    program = f"begin = {clock}; import {module}; print({clock} - begin)"
    return float(subprocess.check_output([sys.executable, "-c", program], text=True))


def main(repeats=50):
    """Print all timings."""
    imports = {name: [] for name in ("numpy, shapely", "freeseg")}
    for _ in range(max(repeats // 5, 1)):
        for name, times in imports.items():
            times.append(import_time(name))
    for name, times in imports.items():
        print(f"import {name:16s} {1e3 * statistics.median(times):7.1f} ms")

    cases = [case for case in fs.load_cases().values() if case.table == 1]
    world = fs.load_table(1)
    actions = {case.name: lambda case=case: fs.plan(world, case.start, case.goal) for case in cases}
    print(f"first plan of a process {1e3 * time_of(actions['16b']):9.1f} ms")
    planning = medians(actions, repeats)
    for name, value in planning.items():
        print(f"plan case {name:13s} {1e3 * value:7.2f} ms")
    typical = statistics.median(planning.values())
    print(f"plan, median of {len(planning)} cases {1e3 * typical:6.2f} ms")

    def new_world():
        return fs.plan(fs.load_table(1), cases[-1].start, cases[-1].goal)

    load_and_plan = medians({"load": new_world}, repeats)["load"]
    print(f"load a table and plan   {1e3 * load_and_plan:9.2f} ms")

    path = fs.plan(world, (0, 0), (0.75, 0.75)).path
    reference = fs.make_reference(path)
    tracking = medians(
        {
            "make_reference": lambda: fs.make_reference(path),
            "simulate": lambda: fs.simulate(fs.SlidingMode(), reference),
        },
        max(repeats // 5, 1),
    )
    for name, value in tracking.items():
        print(f"{name:23s} {1e3 * value:7.1f} ms")


if __name__ == "__main__":
    main()
