"""Which robots fill the axes of Figs 17 to 19: ``python tests/benchmarks/figures.py [setting]``.

Drives random robots under each setting of notebook ``A2_decode_the_figures``, whose own lines
these are, and stores those that any of its conditions may still want in ``data/figures.csv``.
Takes some two minutes on one core; with names of settings, only these are driven again.
"""

import sys
from pathlib import Path

import numpy as np

from freeseg.data import DATA, read_csv, write_csv

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from lessons import definitions

FILE = DATA / "figures.csv"
OWN = definitions(
    "A2_decode_the_figures",
    *("settings", "draw", "fly", "last_as_long", "NUMBERS", "ROBOT", "wheel_axis", "error_axes"),
    *("units", "cases"),
)

#: Weaker than any condition of the notebook: how far off (m), share of an axis left at the end,
#: share of an axis filled, and share of the wheels' axis used either way.
WEAKEST = 0.02, 0.1, 0.1, 0.5


def drive(name, tried, dt, fastest, unit=None, **options):
    """Gains, starts and numbers of robots that drive a case under a setting: three arrays."""
    gains, start = OWN["draw"](tried, fastest)
    if unit:
        # arctan(V_r y_e) in a unit: its c = 1 unit²/s, over the top speed.
        gains[4] = unit**2 / OWN["last_as_long"](name, 0.2).v.max()
    return gains, start, OWN["fly"](name, gains, start, np.arange(tried), dt, **options)


def wanted(name, found):
    """Which robots a condition of the notebook may want, shape (n,)."""
    distance, *errors = found[:7]
    errors, axis = np.array(errors), OWN["wheel_axis"][name][0]
    follow, end, fill, share = WEAKEST
    some = (distance < follow) & (found[7] <= axis) & (found[8] >= -axis)
    some &= (found[7] > share * axis) & (found[8] < -share * axis)
    readings = np.zeros_like(some)
    for unit in OWN["units"].values():
        limit = (np.array(OWN["error_axes"][name]) * unit)[:, None]
        fits = (errors[:3] <= limit) & (errors[:3] > fill * limit) & (errors[3:] <= end * limit)
        readings |= fits.all(0)
    return some & readings


def rows_of(label, setting):
    """A row for each robot that is wanted under a setting, of both cases."""
    for name in OWN["cases"]:
        gains, start, found = drive(name, **setting)
        kept = np.flatnonzero(wanted(name, found))
        print(f"{label}, {name}: {len(kept)} of {setting['tried']}", flush=True)
        for robot in kept.tolist():
            values = np.concatenate([gains[:, robot], start[:, robot], found[:, robot]])
            cells = [f"{value:.4g}" for value in values]
            head = {"setting": label, "case": name, "robot": robot}
            yield head | dict(zip([*OWN["ROBOT"], *OWN["NUMBERS"]], cells, strict=True))


def main(*labels, file=FILE):
    """Store the robots of some settings, or of all, and keep those of the others."""
    columns = dict.fromkeys(["setting", "case", "robot", *OWN["ROBOT"], *OWN["NUMBERS"]], str)
    stored = read_csv(file, columns) if labels else []
    for row in stored:
        del row["row"]
    for label in labels or OWN["settings"]:
        fresh = list(rows_of(label, OWN["settings"][label]))
        stored = [row for row in stored if row["setting"] != label] + fresh
        write_csv(file, stored)


if __name__ == "__main__":
    main(*sys.argv[1:])
