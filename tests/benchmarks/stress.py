"""How often robots fail: ``python tests/benchmarks/stress.py [--store FOLDER] [PART ...]``.

Counts failures on courses that no search has seen, at the usual disturbance and with one
cause after the other made stronger; splits down to rare contacts; and measures which
assumption matters most. What `freeseg.studies.stress.load_stress` reads is stored in
``data/stress.npz``; notebook 15 shows it. All of it takes half an hour on one quiet core;
counting can go on where it stopped. ``check`` tries splitting on a closed form, and
stores that, too.
"""

import argparse
import time
from functools import partial
from pathlib import Path

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import log_ndtr, ndtr

from freeseg.data import DATA, read_arrays, write_arrays
from freeseg.studies import stress
from freeseg.studies.runner import run
from freeseg.studies.splitting import split

FILE = DATA / "stress.npz"

#: The closed form: Brownian motion over unit time, in so many steps, with a normal drift.
STEPS, DRIFT = 50, 0.5

#: Probabilities at which splitting is checked, and how often.
CHECKED = {1e-3: 200, 1e-6: 40}


def highest(numbers):
    """Highest point of Brownian motion with a random drift, between the steps, too."""
    drift, steps = DRIFT * numbers[:1], numbers[1:].reshape(STEPS, 2, -1)
    end = np.cumsum(np.sqrt(1 / STEPS) * steps[:, 0] + drift / STEPS, 0)
    begin = np.concatenate([np.zeros((1, end.shape[1])), end[:-1]])
    # The highest point of a bridge, of a uniform number.
    bridge = (end - begin) ** 2 - 2 / STEPS * log_ndtr(steps[:, 1])
    return ((begin + end + np.sqrt(bridge)) / 2).max(0)


def exceeded(height):
    """Probability that it gets higher: of Bachelier and Levy for each drift, averaged."""

    def density(drift):
        passed = ndtr(drift - height) + np.exp(2 * drift * height) * ndtr(-height - drift)
        return passed * np.exp(-((drift / DRIFT) ** 2) / 2) / (np.sqrt(2 * np.pi) * DRIFT)

    return quad(density, -8 * DRIFT, 8 * DRIFT, epsabs=1e-15, epsrel=1e-10, limit=400)[0]


def check():
    """Coverage, error and runs of splitting, on the closed form."""
    found = {}
    for probability, repeats in CHECKED.items():
        height = brentq(lambda one, p=probability: np.log(exceeded(one) / p), 1, 9)
        tails = [split(highest, 1 + 2 * STEPS, [height], seed) for seed in range(repeats)]
        rows = [(one.share[0], one.low[0], one.high[0], one.runs) for one in tails]
        found[f"check_{probability:g}"] = np.array(rows)
        shares, low, high, runs = np.array(rows).T
        covered = ((low <= probability) & (probability <= high)).mean()
        print(
            f"p = {probability:g}: covered {covered:.1%} of {repeats}, relative error "
            f"{shares.std() / probability:.3f}, bias {shares.mean() / probability - 1:+.3f}, "
            f"{runs.mean():.0f} runs"
        )
    return found


def counted(case, _):
    """Numbers of one course, all laws."""
    number, strong = case
    row = {}
    for name, law in stress.best_laws().items():
        for cause, numbers in stress.count_failures(law, number, strong).items():
            row |= {f"{name}.{cause}.{one}": values.tolist() for one, values in numbers.items()}
    return row


def count(store):
    """Outcomes of all counted runs: by law, cause and number, shape (courses, strengths)."""
    found = {}
    for strong, numbers in (
        (True, range(stress.COUNTED_STRONG)),
        (False, range(stress.COUNTED_STRONG, stress.COUNTED)),
    ):
        where = store and Path(store) / ("strong" if strong else "nominal")
        rows = list(run(counted, [(k, strong) for k in numbers], where, jobs=1, strict=True))
        for key in rows[0]:
            if "." in key:
                found.setdefault(key, []).extend(row[key] for row in rows)
    return {key: np.array(values, "f4") for key, values in found.items()}


def rare(names=stress.SPLIT):
    """Tails of the shortfall, by law and course."""
    found = {}
    for law, number in names:
        begin = time.process_time()
        tail = stress.split_shortfall(law, number)
        found[f"tail.{law}.{number}"] = np.array(
            [tail.levels, tail.share, tail.low, tail.high, tail.error]
        )
        found[f"runs.{law}.{number}"] = np.array(tail.runs)
        print(law, number, tail.share[-1], f"{time.process_time() - begin:.0f} s", flush=True)
    return found


def sensitivities():
    """Sobol's indices with their intervals, by law: shape (first and total, 3, causes)."""
    found = {}
    for law in ("SlidingMode", "Pid"):
        result = stress.sensitivity(stress.best_laws()[law], stress.rare_courses()[1])
        spread = result.bootstrap(n_resamples=500)
        pairs = ("first_order", "total_order")
        found[f"sobol.{law}"] = np.array(
            [
                [
                    getattr(result, one),
                    getattr(spread, one).confidence_interval.low,
                    getattr(spread, one).confidence_interval.high,
                ]
                for one in pairs
            ]
        )
    return found


def main(arguments=None):
    """Compute the parts that are asked for, and store them beside what is stored."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parts = {"check": check, "count": count, "rare": rare, "sobol": sensitivities}
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(parts)}; or all")
    parser.add_argument("--store", help="folder where what is counted is kept")
    options = parser.parse_args(arguments)
    parts["count"] = partial(count, options.store)
    for name in options.parts or parts:
        found = parts[name]()
        write_arrays(FILE, (read_arrays(FILE) if FILE.exists() else {}) | found)
        print(name, "is stored", flush=True)


if __name__ == "__main__":
    main()
