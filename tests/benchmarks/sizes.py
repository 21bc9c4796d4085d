"""What each set of sizes would conclude: ``python tests/benchmarks/sizes.py [sets]``.

Plans the 16 cases with 1000 sets of sizes that fit the paper, of discs and of squares, and with
300 of discs at other margins, and stores the counts of `freeseg.studies.sizes.try_sizes` in
``data/sizes.csv``, which notebooks 06 and A1 show. Takes some ten minutes on two cores; with a
number of sets it prints only.
"""

import sys
from functools import partial

import numpy as np

from freeseg.data import DATA, write_csv
from freeseg.segments import MARGIN
from freeseg.studies.runner import run
from freeseg.studies.sizes import random_sizes, try_sizes
from freeseg.studies.store import COLUMNS

FILE = DATA / "sizes.csv"

#: Shape, margin (m) and number of sets.
GROUPS = [("disc", MARGIN, 1000), ("square", MARGIN, 1000), ("disc", 0.001, 300)]
GROUPS += [("disc", 0.02, 300)]


def study(shape, margin, count):
    """A row for each set of sizes of one shape, at one margin (m)."""
    sets = random_sizes(count, shape, margin=margin)
    found = run(partial(try_set, shape=shape, margin=margin), sets, strict=True)
    head = {"shape": shape, "margin_mm": f"{1000 * margin:g}"}
    return [
        head | {"set": row["case"]} | {k: v for k, v in row.items() if k not in COLUMNS}
        for row in found
    ]


def try_set(sizes, _, shape, margin):
    """As `try_sizes`, in which there is no chance."""
    return try_sizes(sizes, shape=shape, margin=margin)


def main(most=None):
    """Print how each group came out; without a limit to the number of sets, store all rows."""
    rows = []
    for shape, margin, count in GROUPS:
        found = study(shape, margin, min(count, most or count))
        rows += found
        print(f"{len(found)} sets, {shape}, margin {1000 * margin:g} mm")
        for name in list(found[0])[3:]:
            low, middle, high = np.quantile([row[name] for row in found], (0, 0.5, 1))
            print(f"    {name}: {low:.4g} to {high:.4g}, median {middle:.4g}")
    if most is None:
        for row in rows:
            row["worst_ratio"] = f"{row['worst_ratio']:.6f}"
        write_csv(FILE, rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
