"""How often the intervals of `studies.statistics` cover a known truth.

    python tests/benchmarks/interval_coverage.py [repeats]

Synthetic studies of several sizes: each run is the sum of normal effects of its course, its
robot, its replicate and itself, all with standard deviation 1 and mean 0, apart for each law;
or of only some of these. The columns are the shares of studies that are covered: by the interval
of percentiles, by the studentised one, and by all differences of four and of ten laws together.
"""

import sys

import numpy as np

from freeseg.studies import statistics

SIZES = (4, 4), (8, 5), (14, 8), (30, 30), (8, 40), (8, 10, 5), (8, 40, 5)

#: Fewer than a study takes: the intervals of many studies are hardly shorter for it.
RESAMPLES = 400


def study(rng, laws, size, effects):
    """Runs of laws, shape (laws, *size), with effects of some axes and of each run."""
    runs = rng.normal(size=(laws, *size))
    for axis in effects:
        sides = [length if axis == side else 1 for side, length in enumerate(size)]
        runs += rng.normal(size=(laws, *sides))
    return runs


def covers(size, effects, seed):
    """Which of the intervals of one study cover zero."""
    statistics.RESAMPLES = RESAMPLES
    # Not the draws of the resampling.
    rng = np.random.default_rng([seed, 1])
    (one,) = study(rng, 1, size, effects)
    intervals = (statistics.interval(one, seed, studentised) for studentised in (False, True))
    found = [low <= 0 <= high for low, high in intervals]
    for laws in (4, 10):
        runs = dict(enumerate(study(rng, laws, size, effects)))
        found.append(all(d.low <= 0 <= d.high for d in statistics.differences(runs, seed)))
    return found


def main(repeats=500, sizes=SIZES):
    print(f"{'size':11s}{'effects':9s} percentile studentised  4 laws    10 laws")
    for size in sizes:
        axes = range(len(size))
        for name, effects in (
            ("all", axes),
            ("courses", axes[:1]),
            ("the last", axes[-1:]),
            ("none", ()),
        ):
            found = [covers(size, effects, seed) for seed in range(repeats)]
            shares = "".join(f"{share:11.1%}" for share in np.mean(found, axis=0))
            print(f"{' x '.join(map(str, size)):11s}{name:9s}{shares}", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
