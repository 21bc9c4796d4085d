"""Trackers: gains with ``start(reference, robot, dt) -> law``.

A law maps ``(t, pose)`` to a body velocity ``(v, omega)``. What it has to
remember lives in that closure, so a second run never sees the first.
"""

from freeseg.trackers.sliding_mode import SlidingMode

__all__ = ["SlidingMode"]
