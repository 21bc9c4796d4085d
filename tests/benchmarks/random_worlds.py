"""Success and length of every rule: ``python tests/benchmarks/random_worlds.py [worlds]``.

Prints the table of `freeseg.studies.planning.compare_rules` over 20 000 random worlds of
up to 60 obstacles and stores it in ``data/random_worlds.csv``, which the notebook
on scale shows. Takes some ten minutes on two cores; with a number of worlds it
prints only, and with a folder after it the worlds that are done are kept there.
"""

import sys

from freeseg.data import DATA, write_csv
from freeseg.studies.planning import compare_rules

FILE = DATA / "random_worlds.csv"
WORLDS = 20_000

#: So many of them are stored apart: the notebook plans these again.
SAMPLE = 120


def main(worlds, store=None, file=None):
    """Print the table, and write it to a file if one is given."""
    rows = compare_rules(range(SAMPLE), None) + compare_rules(range(worlds), None, store)
    for row in rows:
        print(
            ", ".join(
                f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
                for name, value in row.items()
            )
        )
    if file:
        write_csv(file, rows)


if __name__ == "__main__":
    main(int(sys.argv[1]), *sys.argv[2:]) if len(sys.argv) > 1 else main(WORLDS, file=FILE)
