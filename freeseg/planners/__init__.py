"""Planners: each is one function, see `freeseg.plan.Planner`; and where they may begin."""

from freeseg.planners.fallback import with_fallback
from freeseg.planners.free_segment import plan
from freeseg.planners.length_first import length_first_plan
from freeseg.planners.literal import literal_plan
from freeseg.planners.nearest_free import nearest_free
from freeseg.planners.rooms import plan_rooms
from freeseg.planners.shortest import shortest_path
from freeseg.planners.time_minimal import time_minimal_plan
from freeseg.planners.widest_segment import widest_segment_plan

__all__ = [
    "length_first_plan",
    "literal_plan",
    "nearest_free",
    "plan",
    "plan_rooms",
    "shortest_path",
    "time_minimal_plan",
    "widest_segment_plan",
    "with_fallback",
]
