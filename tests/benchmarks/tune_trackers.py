"""Tune the trackers: ``python tests/benchmarks/tune_trackers.py [tracker ...]``.

Searches the gains of every tracker, or of those named, by the protocol of
`freeseg.comparison`, with two seeds each on two processes, and stores them in
``data/gains.csv``, which notebook 12 shows; rows of trackers not named stay. Takes
some ten minutes on two cores; with ``--quick`` it tries one generation for one
tracker and prints only.
"""

import csv
import sys

from joblib import Parallel, delayed
from tqdm import tqdm

import freeseg
from freeseg import comparison
from freeseg.data import DATA, write_csv

FILE = DATA / "gains.csv"
SEEDS = (0, 1)


def search(name, seed, budget):
    """Rows on one search."""
    gains, score = comparison.tune(name, seed, budget)
    held_out = comparison.held_out(getattr(freeseg, name)(**gains))["score_m"].mean()
    common = {"budget": budget, "seed": seed, "score": score, "held_out": float(held_out)}
    return [{"tracker": name, "gain": gain, "value": gains[gain]} | common for gain in gains]


def main(names=(), budget=comparison.BUDGET, file=FILE):
    """Tune, print, and write the rows to a file if one is given."""
    names = names or list(comparison.RANGES)
    jobs = [delayed(search)(name, seed, budget) for name in names for seed in SEEDS]
    found = {}
    for rows in tqdm(Parallel(2, return_as="generator_unordered")(jobs), total=len(jobs)):
        found[rows[0]["tracker"], rows[0]["seed"]] = rows
    rows = []
    for name in names:
        best = min(SEEDS, key=lambda seed: found[name, seed][0]["score"])
        for seed in SEEDS:
            one = found[name, seed]
            print(
                f"{name:22s} seed {seed}: training {1e3 * one[0]['score']:.3f} mm, "
                f"held out {1e3 * one[0]['held_out']:.3f} mm, "
                + ", ".join(f"{row['gain']} {row['value']:g}" for row in one)
            )
            rows += [row | {"chosen": int(seed == best)} for row in one]
    if file:
        if file.exists():
            with file.open(newline="") as stream:
                rows += [row for row in csv.DictReader(stream) if row["tracker"] not in names]
        rows.sort(key=lambda row: list(comparison.RANGES).index(row["tracker"]))
        write_csv(file, rows)


if __name__ == "__main__":
    if "--quick" in sys.argv:
        main(["PurePursuit"], comparison.POPULATION, None)
    else:
        main(sys.argv[1:])
