"""Reactive laws: gains with ``start(scene, goal, robot, dt) -> law``.

A law maps ``(t, pose)`` to a body velocity ``(v, omega)``, once every time step, as a
tracker's does; but it follows nothing. It sees the obstacles and knows the goal, plans no path
and proves nothing: it may stop short of the goal, for ever. `freeseg.react` drives by it.

The paper names one more, an "agoraphobic algorithm", which is found nowhere by that name. The
*Agoraphilic* algorithm, attraction by free space, is probably meant. It is not here, for it
could not be established well enough to be fair to it. The papers that introduced it (J.
McFetridge, M. Y. Ibrahim, from 1998 on) are not public. What is public describes
later versions, in English words and figures more than in equations: in that of H. S. Hewawasam,
M. Y. Ibrahim and G. K. Appuhamillage (*Machines* 10(11), 1085, 2022) a fuzzy controller weighs
the forces of free space, and movers are tracked and predicted.
"""

from freeseg.reactive.dynamic_window import DynamicWindow
from freeseg.reactive.potential_field import PotentialField
from freeseg.reactive.vector_field_histogram import VectorFieldHistogram

__all__ = ["DynamicWindow", "PotentialField", "VectorFieldHistogram"]
