"""Planners: one call for all, ``planner(world, start, goal, robot) -> Plan``."""

from freeseg.planners.free_segment import plan
from freeseg.planners.shortest import shortest_path

__all__ = ["plan", "shortest_path"]
