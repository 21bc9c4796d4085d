"""Studies: many plans and many runs, and what can be concluded from them.

`planning` and `rivals` compare planners, `orders` the two orders of the paper's search, `sizes`
what each set of obstacle sizes would conclude; `courses`, `tracking`, `tuning` and `comparing`
compare trackers, `reacting` reactive laws, `moving` methods among movers; `traps` are worlds in
which laws fail; `stress` counts failures; `ledger` judges the paper's sentences by all of them;
`statistics` gives intervals; `runner`, with `run` and `replay`, uses all cores and survives,
for `store`, with `load`, keeps the rows.
"""

from freeseg.studies import (
    comparing,
    courses,
    ledger,
    ledger_export,
    moving,
    orders,
    planning,
    reacting,
    rivals,
    runner,
    sizes,
    statistics,
    store,
    tracking,
    traps,
    tuning,
)
from freeseg.studies.runner import replay, run
from freeseg.studies.store import load

__all__ = [
    "comparing",
    "courses",
    "ledger",
    "ledger_export",
    "load",
    "moving",
    "orders",
    "planning",
    "reacting",
    "replay",
    "rivals",
    "run",
    "runner",
    "sizes",
    "statistics",
    "store",
    "tracking",
    "traps",
    "tuning",
]
