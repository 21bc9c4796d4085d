"""Worlds in which reactive laws are known to fail, and what fails there.

Each is small enough to draw, and has its source in the literature.
"""

import numpy as np

from freeseg.reactive import DynamicWindow, PotentialField, VectorFieldHistogram
from freeseg.reactive.sensing import Reactive
from freeseg.robot import KheperaIV
from freeseg.studies.rivals import Question, pose_question
from freeseg.world import Disc, Polygon, World

#: Khatib's field, and that of Ge and Cui, where the goal is near an obstacle.
KHATIB = PotentialField(order=0, influence=0.1, repulsion=1e-4)
GE_CUI = PotentialField(order=2, influence=0.1, repulsion=1e-3)

#: Laws that are trapped in the worlds of `trap_worlds`, and what gets through where not all are.
TRAPPED: dict[str, tuple[Reactive, ...]] = {
    "goal near an obstacle": (KHATIB,),
    "U": (PotentialField(), VectorFieldHistogram(), DynamicWindow()),
    "dead end": (VectorFieldHistogram(), PotentialField(), DynamicWindow()),
    "side door": (DynamicWindow(),),
    "Table 5": (PotentialField(), VectorFieldHistogram(), DynamicWindow()),
}
SPARED: dict[str, Reactive] = {
    "goal near an obstacle": GE_CUI,
    "side door": DynamicWindow(speed=0.05),
}

#: A robot with weak motors: its wheels gain less than a fortieth of what a Khepera IV's do
#: (rad/s^2).
WEAK = KheperaIV(max_wheel_rate_change=3.0)


def trap_worlds() -> dict[str, Question]:
    """Worlds in which a reactive law is known to fail, by name.

    Returns
    -------
    dict
        - ``"goal near an obstacle"``: the disc behind the goal pushes more than the goal pulls,
          so that Khatib's field is lowest short of it: the problem of goals that cannot be
          reached with obstacles nearby (S. Ge, Y. Cui, *IEEE T-RA* 16(5), 2000);
        - ``"U"``: an obstacle that opens towards the start, the local minimum of every law that
          looks at the goal and at what is near (Y. Koren, J. Borenstein, "Potential field
          methods and their inherent limitations for mobile robot navigation", *ICRA* 1991);
        - ``"dead end"``: a corridor that is closed farther away than a histogram reaches, which
          VFH+ enters (I. Ulrich, J. Borenstein, "VFH*", *ICRA* 2000, which looks ahead for that);
        - ``"side door"``: a door beside a corridor, for a robot with weak motors. At speed
          its window holds no turn that leads through, and it is past the door's middle before
          one does (D. Fox, W. Burgard, S. Thrun, *IEEE RAM* 4(1), 1997, on small
          accelerations); the same robot passes it slowly;
        - ``"Table 5"``: the paper's case 16(c), in which every free segment is danger.

        `TRAPPED` has the laws that fail there, `SPARED` what gets through.
    """
    outside, inside = 0.25, 0.22
    cup = [(0.5, -outside), (0.9, -outside), (0.9, outside), (0.5, outside)]
    cup += [(0.5, inside), (0.87, inside), (0.87, -inside), (0.5, -inside)]
    corridor = [
        _wall((0.5, 0.13), (1.4, 0.17)),
        _wall((0.5, -0.17), (1.4, -0.13)),
        _wall((1.4, -0.17), (1.44, 0.17)),
    ]
    beside = [
        _wall((-0.3, -0.18), (3.0, -0.14)),
        _wall((-0.3, 0.14), (1.4, 0.18)),
        _wall((1.6, 0.14), (3.0, 0.18)),
    ]
    return {
        "goal near an obstacle": Question(
            World([Disc(np.array([1.12, 0]), 0.03)]), (0, 0.01), (1, 0)
        ),
        "U": Question(World([Polygon(np.array(cup))]), (0, 0.01), (1.1, 0)),
        "dead end": Question(World(corridor), (0, 0.02), (2.2, 0)),
        "side door": Question(World(beside), (0, 0), (1.5, 0.6), WEAK),
        "Table 5": pose_question(("paper", "16c")),
    }


def _wall(low: tuple[float, float], high: tuple[float, float]) -> Polygon:
    """A rectangle from its lower left corner to its upper right one (m)."""
    return Polygon(np.array([low, (high[0], low[1]), high, (low[0], high[1])]))
