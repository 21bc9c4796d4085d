"""Planners: one call for all, ``planner(world, start, goal, robot) -> Plan``."""

from freeseg.planners.free_segment import plan
from freeseg.planners.literal import literal_plan
from freeseg.planners.shortest import shortest_path

__all__ = ["literal_plan", "plan", "shortest_path"]
