"""Tune the trackers: ``python tests/benchmarks/tune_trackers.py [tracker ...]``.

Searches the gains of every tracker, or of those named, by the protocol of
`freeseg.studies.tuning`, with two seeds each on two processes, and stores them in
``data/gains.csv``, which notebook 12 shows; rows of trackers not named stay. Takes
some ten minutes on two cores; with ``--store FOLDER`` a search that is done is kept
there, and need not be done again by a run that was killed. With ``--quick`` it tries
one generation for one tracker and prints only.
"""

import argparse
import csv
from functools import partial
from itertools import groupby

from freeseg import trackers
from freeseg.data import DATA, write_csv
from freeseg.studies import tracking, tuning
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS

FILE = DATA / "gains.csv"
SEEDS = (0, 1)


def search(name, seed, budget):
    """Rows on one search."""
    gains, score = tuning.tune(name, seed, budget)
    held_out = tracking.held_out(getattr(trackers, name)(**gains))["score_m"].mean()
    common = {"budget": budget, "seed": seed, "score": score, "held_out": float(held_out)}
    return [{"tracker": name, "gain": gain, "value": gains[gain]} | common for gain in gains]


def search_case(case, _, budget):
    """As `search`; its seeds are those that every tracker has."""
    return search(*case, budget)


def main(names=(), budget=tuning.BUDGET, file=FILE, store=None):
    """Tune, print, and write the rows to a file if one is given."""
    names = names or list(tuning.RANGES)
    cases = [(name, seed) for name in names for seed in SEEDS]
    searches = run(partial(search_case, budget=budget), cases, store, jobs=2, strict=True)
    found = {}
    for case, gains in groupby(searches, lambda row: cases[row["case"]]):
        found[case] = [{k: v for k, v in row.items() if k not in COLUMNS} for row in gains]
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
        rows.sort(key=lambda row: list(tuning.RANGES).index(row["tracker"]))
        write_csv(file, rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="tracker")
    parser.add_argument("--store", metavar="FOLDER")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if options.quick:
        main(["PurePursuit"], tuning.POPULATION, None)
    else:
        main(options.names, store=options.store)
