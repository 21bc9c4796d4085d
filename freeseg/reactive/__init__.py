"""Reactive laws: gains with ``start(scene, goal, robot, dt) -> law``.

A law maps ``(t, pose)`` to a body velocity ``(v, omega)``, once every time step, as a
tracker's does; but it follows nothing. It sees the obstacles and knows the goal, plans no path
and proves nothing: it may stop short of the goal, for ever. `freeseg.react` drives by it.

The paper names one more, an "agoraphobic algorithm", which is found nowhere by that name. The
*Agoraphilic* algorithm, attraction by free space, is probably meant. It is not here, for its
first papers (J. McFetridge, M. Y. Ibrahim) could not be had, and what is public is a later one:
the algorithm of *Machines* 10(11), 1085, 2022 puts a fuzzy controller, and the tracking and
prediction of movers, on top. Neither the first form of the force of free space nor the gains
of its controller could be established, and a law that we complete ourselves is no rival.
"""

from freeseg.reactive.dynamic_window import DynamicWindow
from freeseg.reactive.potential_field import PotentialField
from freeseg.reactive.vector_field_histogram import VectorFieldHistogram

__all__ = ["DynamicWindow", "PotentialField", "VectorFieldHistogram"]
