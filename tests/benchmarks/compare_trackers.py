"""Tune and judge the trackers: ``python tests/benchmarks/compare_trackers.py [--store FOLDER]``.

Searches the gains of every law in every form and regime, with five replicates each, by
the protocol of `freeseg.studies.tuning`, and stores them in ``data/gains.csv``; then drives
all of them on courses that no search has seen, and stores what `freeseg.studies.comparing`
keeps of these runs in ``data/comparison.npz``. Notebook 12 shows both. Takes some hour and
a half on two cores; with a store, a study that was killed goes on where it stopped.
With ``--quick`` it tries one law and writes nothing.
"""

import argparse
from itertools import product
from pathlib import Path

import numpy as np

from freeseg.data import DATA, write_arrays, write_csv
from freeseg.studies import comparing, tuning
from freeseg.studies.runner import run

#: The slowest law begins, so that all cores end together.
LAWS = ("Mpc", *(name for name in tuning.RANGES if name != "Mpc"))


def searches():
    """What is tuned for: law, form, regime, replicate."""
    kinds = {(cell.form, cell.regime) for cell in comparing.COMPARED if cell.regime != "disturbed"}
    return [
        (name, *kind, replicate)
        for name in LAWS
        for kind in sorted(kinds)
        for replicate in range(tuning.REPLICATES)
    ]


def search(case, _):
    """Rows of gains of one search."""
    name, form, regime, replicate = case
    many = (form, regime) == ("observed", "nominal")
    prices = tuning.PRICES if many else tuning.PRICES[:1]
    common = {"tracker": name, "form": form, "regime": regime}
    return [
        common
        | {"price": price, "replicate": replicate, "gain": gain, "value": value, "score": score}
        for price, (gains, score) in zip(prices, tuning.tune(*case, prices), strict=True)
        for gain, value in gains.items()
    ]


def judged(case, _):
    """What is kept of the runs of one law."""
    name, number, _, gains = case
    cell = comparing.COMPARED[number]
    numbers = comparing.judge(tuning.make_tracker(name, cell.form, gains, cell.told), cell.regime)
    return {one: numbers[one].ravel().tolist() for one in comparing.KEPT}


def judgements(rows):
    """What is judged: law, number of the cell, replicate, gains."""
    gains = {}
    for row in rows:
        key = tuple(row[one] for one in ("tracker", "form", "regime", "price", "replicate"))
        gains.setdefault(key, {})[row["gain"]] = row["value"]
    cases = []
    for name, (number, cell), replicate in product(
        LAWS, enumerate(comparing.COMPARED), range(tuning.REPLICATES)
    ):
        regime = "nominal" if cell.regime == "disturbed" else cell.regime
        found = gains[name, cell.form, regime, cell.price, replicate]
        cases.append((name, number, replicate, found))
    return cases


def main(store=None, jobs=2, folder=DATA):
    """Tune, judge, and write both files."""
    stores = [Path(store) / one if store else None for one in ("tuned", "judged")]
    rows = list(run(search, searches(), stores[0], jobs=jobs, strict=True))
    columns = ("tracker", "form", "regime", "price", "replicate", "gain", "value", "score")
    rows.sort(key=lambda row: list(tuning.RANGES).index(row["tracker"]))
    write_csv(folder / "gains.csv", [{one: row[one] for one in columns} for row in rows])
    cases, laws = judgements(rows), list(tuning.RANGES)
    runs = list(run(judged, cases, stores[1], jobs=jobs, strict=True))
    order = sorted(range(len(cases)), key=lambda k: (cases[k][1], laws.index(cases[k][0]), k))
    size = comparing.JUDGED["courses"], comparing.JUDGED["robots"]
    shape = len(comparing.COMPARED), len(laws), tuning.REPLICATES, *size
    arrays = {}
    for one in comparing.KEPT:
        values = np.reshape([runs[k][one] for k in order], shape)
        arrays[one] = np.moveaxis(values, 2, -1).astype(np.float32 if one != "hit" else bool)
    write_arrays(folder / "comparison.npz", arrays)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--store", metavar="FOLDER")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if options.quick:
        gains, score = tuning.tune("PurePursuit", "observed", "fast", 0)[0]
        print(f"{1000 * score:.2f} mm with {gains}")
    else:
        main(options.store)
