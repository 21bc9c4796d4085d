"""Studies: many plans and many runs, and what can be concluded from them.

`planning` compares planners, `sizes` what each set of obstacle sizes would conclude;
`courses`, `tracking` and `tuning` compare trackers;
`statistics` gives intervals, and `runner` uses all cores.
"""

from freeseg.studies import courses, planning, runner, sizes, statistics, tracking, tuning

__all__ = ["courses", "planning", "runner", "sizes", "statistics", "tracking", "tuning"]
