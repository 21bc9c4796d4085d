"""Reactive laws: the time of a step, and with ``--tune`` a search of their gains.

``python tests/benchmarks/reactive.py``: each law drives among random discs and polygons; then
all see again, step by step in turn, what they saw, so that a slow moment of the machine hits all
of them. A law alone is timed, without the robot, by the processor's own time. Prints medians and
99th percentiles; ``--quick`` takes one small world.

``--tune`` searches the gains of every law by the same number of evaluations, see
`freeseg.studies.reacting`, and stores them in ``data/reactive_gains.csv``, with what the
defaults score on the same tasks. Ten minutes on one core; with ``--store FOLDER`` a search that
was stopped goes on.
"""

import argparse
import statistics
import time
from itertools import product

import freeseg as fs
from freeseg.data import DATA, write_csv
from freeseg.studies import reacting
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS

FILE = DATA / "reactive_gains.csv"

#: Evaluations of a search.
BUDGET = 48

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


def search(case, seed, budget=BUDGET):
    """Rows of the gains of one law for one aim, (aim, law): one a gain."""
    aim, law = case
    tasks = reacting.training_tasks(aim)
    before = reacting.score(getattr(fs, law)(), tasks)
    gains, score = reacting.tune(law, tasks, seed, budget)
    common = {"tuned_for": aim, "law": law}
    return [
        common
        | {"gain": gain, "value": value, "score_before": round(before, 6), "score": round(score, 6)}
        for gain, value in gains.items()
    ]


def tune(store=None, file=FILE):
    """Search all gains, print what they score, and store them."""
    cases = list(product(reacting.TUNED_FOR, reacting.REACTIVE.values()))
    rows = [
        {name: value for name, value in row.items() if name not in COLUMNS}
        for row in run(search, cases, store, jobs=1, strict=True)
    ]
    for aim, law in cases:
        one = next(row for row in rows if (row["tuned_for"], row["law"]) == (aim, law))
        print(f"{aim:8s}{law:22s} {one['score_before']:.3f} -> {one['score']:.3f}")
    write_csv(file, rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="one small world")
    parser.add_argument("--tune", action="store_true", help="search the gains")
    parser.add_argument("--store", help="folder where searches that are done are kept")
    options = parser.parse_args()
    if options.tune:
        tune(options.store)
    else:
        main(*(((8,), 20) if options.quick else ()))
