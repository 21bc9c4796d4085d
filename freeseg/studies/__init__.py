"""Studies: many plans and many runs, and what can be concluded from them.

`planning` compares planners, `sizes` what each set of obstacle sizes would conclude;
`courses`, `tracking` and `tuning` compare trackers, `reacting` reactive laws;
`statistics` gives intervals; `runner`, with `run` and `replay`, uses all cores and survives,
for `store`, with `load`, keeps the rows.
"""

from freeseg.studies import (
    courses,
    planning,
    reacting,
    runner,
    sizes,
    statistics,
    store,
    tracking,
    tuning,
)
from freeseg.studies.runner import replay, run
from freeseg.studies.store import load

__all__ = [
    "courses",
    "load",
    "planning",
    "reacting",
    "replay",
    "run",
    "runner",
    "sizes",
    "statistics",
    "store",
    "tracking",
    "tuning",
]
