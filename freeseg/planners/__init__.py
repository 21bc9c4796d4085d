"""Planners: one call for all, ``planner(world, start, goal, robot) -> Plan``."""

from freeseg.planners.free_segment import plan

__all__ = ["plan"]
