"""Safety first or length first: ``python tests/benchmarks/orders.py``.

Counts what both orders of the paper's search compute (`freeseg.studies.orders`) in the 16
cases and in rows of 5 to 500 discs, prints the verdict, and stores a row a case in
``data/orders.csv``. Then it times both on some of the rows: planning again in a world that
both know, one after the other; processor time, medians. With ``--quick`` it prints only,
for few rows.
"""

import statistics
import sys
import time

import freeseg as fs
from freeseg.data import DATA, write_csv
from freeseg.studies import orders

FILE = DATA / "orders.csv"


def times(query, repeats=5):
    """Time (ms) of planning in each order, the median of some."""
    found = {fs.plan: [], fs.length_first_plan: []}
    for _ in range(repeats):
        for planner, durations in found.items():
            begin = time.process_time()
            planner(*query)
            durations.append(1e3 * (time.process_time() - begin))
    # The first prepared the world.
    return [statistics.median(durations[1:]) for durations in found.values()]


def main(cases, timed, file=None, jobs=None):
    """Count, print, and write the rows to a file if one is given."""
    rows = orders.compare_orders([*fs.load_cases(), *cases], jobs=jobs)
    for row in orders.judge_orders(rows):
        print(", ".join(f"{name} {value}" for name, value in row.items()))
    for n, share in orders.turning_share(rows).items():
        print(f"n = {n:4d}: safety first computes less from {share:.3f} of danger segments on")
    for n in timed:
        ratios = []
        for seed in range(5):
            safety, length = times(orders.row_of_discs(n, 0.25, seed))
            ratios.append(safety / length)
        print(f"n = {n:4d}: time of safety first over length first {statistics.median(ratios):.3f}")
    if file:
        write_csv(file, [{k: _short(v) for k, v in row.items()} for row in rows])


def _short(value):
    return round(value, 6) if isinstance(value, float) else value


if __name__ == "__main__":
    if "--quick" in sys.argv:
        main(orders.row_cases(1), [10])
    else:
        main(orders.row_cases(), [5, 50, 500], FILE)
