"""Studies: many plans and many runs, and what can be concluded from them.

`planning` compares planners, `sizes` what each set of obstacle sizes would conclude;
`courses`, `tracking` and `tuning` compare trackers;
`statistics` gives intervals, and `runner`, with `run`, `load` and `replay`, uses all cores
and survives.
"""

from freeseg.studies import courses, planning, runner, sizes, statistics, tracking, tuning
from freeseg.studies.runner import load, replay, run

__all__ = [
    "courses",
    "load",
    "planning",
    "replay",
    "run",
    "runner",
    "sizes",
    "statistics",
    "tracking",
    "tuning",
]
