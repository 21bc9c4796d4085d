"""Time the runner: ``python tests/benchmarks/runner.py [rows]``.

Prints how long a million robot-steps of the sliding-mode and of the PID law take on all
cores; how much faster two workers are than one on chunks of a second; and time and
memory of ten million rows written and summarised. Writes the table of
``docs/from_laptop_to_cluster.md``: what a million runs cost at the rates of this machine.
Takes some five minutes on two cores; with another number of rows, or with ``--quick``,
which is over in seconds, it prints only.
"""

import resource
import statistics
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import psutil

import freeseg as fs
from freeseg import studies
from freeseg.studies import courses, planning, tracking

#: The page, and what stands round its table.
PAGE = Path(__file__).parent.parent.parent / "docs" / "from_laptop_to_cluster.md"
BEGIN, END = "<!-- Written by tests/benchmarks/runner.py -->", "<!-- end -->"

#: Robots that drive at once: one case.
ROBOTS = 250

#: What a core costs in an hour (EUR): an assumption, of the order that clouds ask for.
CORE_HOUR = 0.05


def drive(case, seed, tracker, course, robots):
    """Steps, and the mean error (m), of some disturbed robots."""
    offsets = courses.spread_offsets(robots, seed % 2**32)
    run = tracking.drive_course(tracker, course, offsets, seed)
    return {"steps": robots * (len(run.t) - 1), "error": float(np.abs(run.error[:2]).mean())}


def plan(case, seed):
    """Lengths (m) of the paths that every rule finds in one random world."""
    found = planning.try_rules(seed % 2**32)
    return {rule: length for rule, (length, _) in found.items()}


def draw(case, seed):
    """A row that takes no time."""
    return {"number": seed / 2**64, "even": seed % 2 == 0}


def compute(case, seed):
    """Keep a core busy for some 50 ms."""
    rng = np.random.default_rng(seed)
    return {"mean": float(sum(rng.normal(size=1000).mean() for _ in range(3000)))}


def spend(case, seed, study):
    """Time of the processor (s) that a case takes, also where others use the machine."""
    begin = time.process_time()
    study(case, seed)
    return {"seconds": time.process_time() - begin}


def timed(function, cases, jobs=-1, **given):
    """Rows, and time (s), of a study in memory whose workers are there already."""
    studies.run(function, range(8), jobs=jobs, strict=True, chunk_time=0.01)
    begin = time.perf_counter()
    rows = studies.run(function, range(cases), jobs=jobs, strict=True, **given)
    return rows, time.perf_counter() - begin


def show_steps(steps):
    """Print the time of so many robot-steps of two laws."""
    course = courses.paper_courses()[0]
    each = drive(0, 0, fs.SlidingMode(), course, ROBOTS)["steps"]
    cases = -(-steps // each)
    for tracker in (fs.SlidingMode(), fs.Pid()):
        study = partial(drive, tracker=tracker, course=course, robots=ROBOTS)
        rows, seconds = timed(study, cases)
        print(
            f"{sum(row['steps'] for row in rows):,} robot-steps, {type(tracker).__name__:12s} "
            f"{seconds:5.2f} s"
        )


def show_speed_up(cases):
    """Print how much faster two workers are than one."""
    times = {jobs: [] for jobs in (1, 2)}
    for _ in range(3):
        for jobs, some in times.items():
            some.append(timed(compute, cases, jobs, chunk_time=1.0)[1])
    one, two = (min(some) for some in times.values())
    print(f"{cases} cases: one worker {one:.2f} s, two {two:.2f} s, {one / two:.2f} times as fast")


def show_rows(count):
    """Print time and memory of many rows."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        studies.run(draw, iter(range(count)), folder)
        written = time.perf_counter() - begin
        begin, rows, total, even = time.perf_counter(), 0, 0.0, 0
        for batch in studies.load(folder).to_batches(columns=["number", "even"]):
            rows += len(batch)
            total += batch["number"].to_numpy().sum()
            even += batch["even"].true_count
        read = time.perf_counter() - begin
    assert rows == count
    here = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    workers = [child.memory_info().rss / 2**30 for child in psutil.Process().children(True)]
    print(
        f"{rows:,} rows: written in {written:.1f} s, summarised in {read:.1f} s (mean "
        f"{total / rows:.4f}, {even / rows:.2%} even), at most {here:.2f} GiB here and "
        f"{max(workers, default=0):.2f} in a worker"
    )


def costs(cases):
    """The table of the page: what a million runs cost."""
    course = courses.paper_courses()[0]
    kinds = {
        "worlds of up to 60 obstacles, planned by five rules": (plan, 1),
        f"robots on case 15(a), sliding mode, {ROBOTS} at once": (
            partial(drive, tracker=fs.SlidingMode(), course=course, robots=ROBOTS),
            ROBOTS,
        ),
        "robots on case 15(a), MPC": (
            partial(drive, tracker=fs.Mpc(), course=course, robots=1),
            1,
        ),
    }
    lines = [
        f"Measured by the processor's time of {cases} cases each, and reckoned at an assumed "
        f"{CORE_HOUR} EUR for a core and hour:",
        "",
        "| a million | a second and core | core-hours | hours on 2 cores | minutes on 256 | EUR |",
        "|---|---|---|---|---|---|",
    ]
    for name, (study, robots) in kinds.items():
        rows, _ = timed(partial(spend, study=study), cases)
        rate = robots / statistics.mean(row["seconds"] for row in rows)
        hours = 1e6 / rate / 3600
        numbers = rate, hours, hours / 2, 60 * hours / 256, CORE_HOUR * hours
        lines.append(
            f"| {name} | " + " | ".join(f"{float(f'{number:.2g}'):,g}" for number in numbers) + " |"
        )
    return "\n".join(lines)


def main(rows=10_000_000, steps=1_000_000, cases=100, page=None):
    """Print everything, and write the table into a page if one is given."""
    show_steps(steps)
    show_speed_up(cases)
    print(f"\n{(table := costs(cases))}\n")
    if page:
        before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
        page.write_text(
            f"{before}{BEGIN}\n{table}\n{END}{rest.partition(END)[2]}", encoding="utf-8"
        )
    show_rows(rows)


if __name__ == "__main__":
    if "--quick" in sys.argv:
        main(10_000, 10_000, 4)
    elif len(sys.argv) > 1:
        main(int(sys.argv[1]))
    else:
        main(page=PAGE)
