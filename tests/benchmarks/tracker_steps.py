"""Time of a step of every tracker: ``python tests/benchmarks/tracker_steps.py``.

Each plain law of ``data/gains.csv``, with the gains of its first replicate,
drives the paper's cases 15(a) and 16(b) disturbed; then all laws see again, step by
step in turn, what they saw, so that a slow moment of the machine hits all of them. A
law alone is timed, without the robot, by the processor's own time, which says more
where others use the machine too. Stores medians in ``data/tracker_steps.csv``, which
notebook 12 shows; with ``--quick`` it only prints.
"""

import statistics
import sys
import time

from freeseg import KheperaIV
from freeseg.data import DATA, write_csv
from freeseg.studies import courses, tracking, tuning

FILE = DATA / "tracker_steps.csv"


def replay(trackers, course, seed):
    """Times of the steps (s) of each tracker on a course."""
    offsets, robot, dt = courses.spread_offsets(1, seed), KheperaIV(), courses.DT
    seen = {
        name: tracking.drive_course(tracker, course, offsets, seed).measured[:, 0]
        for name, tracker in trackers.items()
    }
    laws = {name: one.start(course.reference, robot, dt) for name, one in trackers.items()}
    times = {name: [] for name in trackers}
    for step, t in enumerate(course.reference.steps(dt)[:-1]):
        for name, law in laws.items():
            pose = seen[name][:, step]
            begin = time.process_time()
            law(t, pose)
            times[name].append(time.process_time() - begin)
    return times


def main(repeats=5, file=FILE):
    """Print the times, and write them to a file if one is given."""
    tuned = tuning.load_gains()
    trackers = {name: replicates[0].tracker for name, replicates in tuned.items()}
    times = {name: [] for name in trackers}
    for seed in range(repeats):
        for course in courses.paper_courses():
            for name, some in replay(trackers, course, seed).items():
                times[name] += some
    rows = []
    for name, some in times.items():
        p99 = statistics.quantiles(some, n=100)[-1]
        rows.append(
            {
                "tracker": name,
                "steps": len(some),
                "median_us": round(1e6 * statistics.median(some), 1),
                "p99_us": round(1e6 * p99, 1),
            }
        )
        print(
            "{tracker:22s} {steps} steps, median {median_us} us, p99 {p99_us} us".format(**rows[-1])
        )
    if file:
        write_csv(file, rows)


if __name__ == "__main__":
    main(1, None) if "--quick" in sys.argv else main()
