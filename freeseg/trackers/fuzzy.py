"""A fuzzy tracker: thirty rules between the errors and the velocities."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freeseg.reference import Reference
from freeseg.robot import Robot
from freeseg.trackers.feedback import Law, check_gains, watch

#: Peaks of the five triangular sets of an input, and consequents: negative big to positive big.
NB, NS, ZE, PS, PB = SETS = (-1.0, -0.5, 0.0, 0.5, 1.0)

#: Change of speed for x_e in each set.
SPEED_RULES = np.array(SETS)

#: Change of turn rate; a row for y_e and a column for alpha_e in each set.
TURN_RULES = np.array(
    [
        [NB, NB, NB, NS, ZE],
        [NB, NB, NS, ZE, PS],
        [NB, NS, ZE, PS, PB],
        [NS, ZE, PS, PB, PB],
        [ZE, PS, PB, PB, PB],
    ]
)


@dataclass(frozen=True)
class Fuzzy:
    """Ranges of a fuzzy controller.

    Rules such as "if y_e is positive small and alpha_e is zero, then turn
    left a little": 5 for the speed and 25 for the turn rate, added to
    v_r cos(alpha_e) and w_r. Both inputs of a rule are joined by their
    product, and the command is the mean of all consequents, weighted with
    how far each rule holds.

    The paper cites a fuzzy controller and tells neither its rules nor its
    sets: all of this is an assumption.

    Parameters
    ----------
    x_range, y_range : float
        Size of x_e and y_e (m) from which on they are "big".
    alpha_range : float
        The same for alpha_e (rad).
    v_range : float
        Change of speed (m/s) that is "big".
    omega_range : float
        Change of turn rate (rad/s) that is "big".
    preview : float
        Time about that of a command over which the reference's velocities are
        averaged (s), see `feedback.watch`; zero for no average.

    Raises
    ------
    InvalidParameter
        For a range that is negative, not finite or zero, but for v_range and
        omega_range, where zero switches a term off.

    Notes
    -----
    The rule table is the diagonal one of P. J. MacVicar-Whelan, "Fuzzy sets
    for man-machine interaction", International Journal of Man-Machine Studies 8,
    1976; rules with constant consequents are those of order zero of
    T. Takagi, M. Sugeno, "Fuzzy identification of systems and its applications
    to modeling and control", IEEE Transactions on Systems, Man, and
    Cybernetics 15, 1985. A controller after Mamdani with product inference,
    summed consequents of equal area and their centroid computes the same.

    In two corners of the table, where y_e is big and alpha_e big the other
    way, the rules cancel: a robot that looks backwards there does not turn.
    """

    x_range: float = 0.1
    y_range: float = 0.2
    alpha_range: float = 1.0
    v_range: float = 0.2
    omega_range: float = 2.0
    preview: float = 0.0

    def __post_init__(self):
        check_gains(self, "v_range", "omega_range")

    def start(self, reference: Reference, robot: Robot, dt: float) -> Law:
        """The law for one run, see `Tracker.start`."""
        see = watch(reference, dt, self.preview)

        def law(t, pose):
            (x_e, y_e, alpha_e), (_, v_r, omega_r, _, _) = see(t, pose)
            # Backwards, y_e asks for the other sense of turn.
            y = np.copysign(1.0, v_r) * y_e / self.y_range
            x, alpha = x_e / self.x_range, alpha_e / self.alpha_range
            # Sets come first in an array and robots last. Python's sum adds the rules in
            # order, as for one robot so for many; NumPy's does not, to the last bit.
            speed = sum((memberships(x).T * SPEED_RULES).T)
            holds = memberships(y)[:, None] * memberships(alpha)
            turn = sum(sum((holds.T * TURN_RULES.T).T))
            return (
                v_r * np.cos(alpha_e) + self.v_range * speed,
                omega_r + self.omega_range * turn,
            )

        return law


def memberships(value: ArrayLike) -> np.ndarray:
    """How far a value belongs to each set, shape (5, ...); in all, to one.

    Examples
    --------
    >>> memberships(0.4).round(9).tolist()
    [0.0, 0.0, 0.2, 0.8, 0.0]
    """
    distance = np.abs(np.subtract.outer(SETS, np.clip(value, -1, 1)))
    return np.maximum(1 - 2 * distance, 0)
