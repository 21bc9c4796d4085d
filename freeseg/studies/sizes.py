"""Sizes of the paper's obstacles: all that fit what it says, and what each would conclude.

The paper publishes the centres of its obstacles and says which of their segments are
safe; shapes and sizes it does not publish. What is concluded for one choice of sizes
is an accident of that choice, so it is concluded for many, drawn evenly from all that
fit.
"""

from collections.abc import Mapping
from contextlib import suppress
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freeseg import checks
from freeseg.errors import InvalidParameter, NoPath, Trapped
from freeseg.geometry import read_only
from freeseg.paper import load_cases, load_table
from freeseg.plan import Plan, Planner, StepKind, TurningPoint
from freeseg.planners import literal_plan, plan, shortest_path
from freeseg.robot import KheperaIV
from freeseg.segments import MARGIN
from freeseg.world import Disc, Polygon, World

SHAPES = ("disc", "square")

#: Half the width (m) of the smallest obstacle and of the largest that is considered. The paper
#: draws and numbers all of them: none is a point.
LEAST_SIZE, LARGEST_SIZE = 0.005, 0.2

#: More sets would take hours to draw.
MOST_SETS = 100_000

#: Steps of the random walk from one set of sizes to the next that is kept.
THINNING = 40

#: So much longer than the optimum is still optimal: round-off, and straight pieces that graze.
OPTIMAL = 1.001

#: Turns of the wheels that the text of section 5 describes in 16(b): the right one is faster at
#: obstacle 1 and at obstacle 2, then the left one.
TOLD_SENSES = (1, 1, -1)


class Statements:
    """All that the paper says or implies of its obstacles' sizes.

    Parameters
    ----------
    shape : {"disc", "square"}
        Discs, or squares with sides along x and y.
    margin : float, optional
        Security margin delta (m).

    Raises
    ------
    InvalidParameter
        For another shape, or a margin that is no length.

    Notes
    -----
    All segments of Table 1 are safe and all of Table 5 are danger, from which
    the captions of Tables 2 to 4 follow; starts and goals keep R_r + delta/2
    from every obstacle; no two obstacles of a table touch. The obstacles have
    the same sizes in all tables. Notebook A1 derives this.
    """

    def __init__(self, shape: str, margin: float = MARGIN) -> None:
        self.shape = checks.choice("shape", shape, SHAPES)
        self.margin = checks.not_negative("margin", margin)
        robot = KheperaIV()
        self.required = robot.diameter + self.margin
        centers = {k: load_table(k).edges[:, 0] for k in range(1, 6)}
        self.first, self.second = np.triu_indices(7, 1)
        neighbours = self.second == self.first + 1
        #: From the second centre to the first (m), one row a table and a column a pair.
        self.offsets = np.array([c[self.first] - c[self.second] for c in centers.values()])
        self.lower = np.zeros(self.offsets.shape[:2])
        self.upper = np.full_like(self.lower, np.inf)
        self.lower[0, neighbours] = self.upper[4, neighbours] = self.required
        cases = load_cases().values()
        self.from_ends = np.array(
            [centers[case.table] - end for case in cases for end in (case.start, case.goal)]
        )
        self.clearance = self.required / 2

    def slack(self, sizes: ArrayLike) -> float:
        """Length (m) by which the statement nearest to failing is true.

        Parameters
        ----------
        sizes : array_like, shape (7,)
            Radii of the discs, or half the sides of the squares (m).

        Returns
        -------
        float
            Negative where a statement fails.
        """
        sizes = checks.array("sizes", sizes, (7,), unit="m")
        gaps = self._length(self.offsets, sizes[self.first] + sizes[self.second])
        free = self._length(self.from_ends, sizes) - self.clearance
        limits = (gaps - self.lower).min(), (self.upper - gaps).min(), free.min()
        return float(min(*limits, (sizes - LEAST_SIZE).min()))

    def _length(self, offsets: np.ndarray, taken: np.ndarray) -> np.ndarray:
        """Gap along some offsets of centres of which the obstacles take a part (m)."""
        if self.shape == "disc":
            return np.hypot(*np.moveaxis(offsets, -1, 0)) - taken
        beyond = np.abs(offsets) - taken[..., None]
        inside = np.minimum(beyond.max(-1), 0)
        return np.hypot(*np.moveaxis(np.maximum(beyond, 0), -1, 0)) + inside


def random_sizes(
    count: int, shape: str = "disc", seed: int = 0, margin: float = MARGIN
) -> np.ndarray:
    """Sets of sizes that fit the paper, drawn evenly from all that do.

    Parameters
    ----------
    count : int
        How many sets.
    shape : {"disc", "square"}, optional
        Of every obstacle.
    seed : int, optional
        Equal seeds give equal sets; a smaller count gives the first of them.
    margin : float, optional
        Security margin delta (m).

    Returns
    -------
    ndarray, shape (count, 7)
        Radii, or half the sides (m), in whole hundredths of a millimetre.

    Raises
    ------
    InvalidParameter
        For bad values, and for a margin that the published sizes do not fit,
        from which the search sets out.

    Notes
    -----
    Hit-and-run in the form of a slice sampler: from a set that fits, a random
    direction; on it, a random set between the farthest two; where that does
    not fit, the interval shrinks to it (R. Neal, "Slice sampling", *Annals of
    Statistics* 31, 2003, section 5). Evenly distributed sets stay so, and what
    fits need not be convex: of squares it is not.
    """
    count = checks.whole("count", count, 1)
    if count > MOST_SETS:
        raise InvalidParameter(f"count is {checks.shown(count)}; give at most {MOST_SETS}")
    statements, rng = Statements(shape, margin), np.random.default_rng(checks.whole("seed", seed))
    sizes = load_table(1).radii.copy()
    if statements.slack(sizes) < 0:
        raise InvalidParameter(
            f"margin is {margin}; give one that the sizes of obstacles.csv fit, such as {MARGIN}"
        )
    found: list[np.ndarray] = []
    while len(found) < count:
        for _ in range(THINNING):
            sizes = _neighbour(sizes, statements, rng)
        rounded = np.round(sizes, 5)
        if statements.slack(rounded) >= 0:
            found.append(rounded)
    return read_only(np.array(found))


def _neighbour(sizes: np.ndarray, statements: Statements, rng: np.random.Generator) -> np.ndarray:
    """Another set that fits, in a random direction from one."""
    direction = rng.normal(size=7)
    ends = (np.array([[LEAST_SIZE], [LARGEST_SIZE]]) - sizes) / direction
    low, high = ends.min(0).max(), ends.max(0).min()
    while True:
        along = rng.uniform(low, high)
        if statements.slack(sizes + along * direction) >= 0:
            return sizes + along * direction
        low, high = (along, high) if along < 0 else (low, along)


def make_tables(sizes: ArrayLike, shape: str = "disc") -> dict[int, World]:
    """Tables 1 to 5 with other sizes.

    Parameters
    ----------
    sizes : array_like, shape (7,)
        Radii of the discs, or half the sides of the squares (m).
    shape : {"disc", "square"}, optional
        Of every obstacle.

    Returns
    -------
    dict
        Number of the table to its `World`.

    Raises
    ------
    InvalidParameter
        For sizes that are none, or another shape.
    """
    sizes = checks.array("sizes", sizes, (7,), unit="m")
    if not (sizes > 0).all():
        raise InvalidParameter(f"sizes is {checks.shown(sizes)}; give seven positive lengths (m)")
    square = checks.choice("shape", shape, SHAPES) == "square"
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return {
        table: World(
            [
                Polygon(center + size * corners) if square else Disc(center, size)
                for center, size in zip(load_table(table).edges[:, 0], sizes, strict=True)
            ]
        )
        for table in range(1, 6)
    }


def try_sizes(sizes: ArrayLike, shape: str = "disc", margin: float = MARGIN) -> dict[str, Any]:
    """Plan the 16 cases with some sizes, and count.

    Parameters
    ----------
    sizes : array_like, shape (7,)
        Radii of the discs, or half the sides of the squares (m).
    shape : {"disc", "square"}, optional
        Of every obstacle.
    margin : float, optional
        Security margin delta (m).

    Returns
    -------
    dict
        ``solved`` by `plan`; of these ``greedy``, without the search round a
        group; ``optimal``, within 0.1 % of the optimum, and
        ``greedy_optimal``, both; ``worst_ratio`` of its length to the
        optimum; ``literal``, solved by `literal_plan`; ``possible``, by
        `shortest_path`; ``as_told``, 1 where one of the three drives 16(b) as
        section 5 describes it: left, left, right.

    Raises
    ------
    InvalidParameter
        For sizes that are none, another shape, or a margin that is none.
    """
    tables = make_tables(sizes, shape)
    ours, literal, exact = (
        _solved(planner, tables, margin) for planner in (plan, literal_plan, shortest_path)
    )
    both = ours.keys() & exact.keys()
    greedy = {name for name in both if not by_group(ours[name])}
    ratio = {name: ours[name].path.length / exact[name].path.length for name in both}
    optimal = {name for name in both if ratio[name] <= OPTIMAL}
    told = [found["16b"] for found in (ours, literal, exact) if "16b" in found]
    return {
        "solved": len(both),
        "greedy": len(greedy),
        "optimal": len(optimal),
        "greedy_optimal": len(optimal & greedy),
        "worst_ratio": max(ratio.values(), default=np.nan),
        "literal": len(literal),
        "possible": len(exact),
        "as_told": int(any(senses(found) == TOLD_SENSES for found in told)),
    }


def _solved(planner: Planner, tables: Mapping[int, World], margin: float) -> dict[str, Plan]:
    """Plans of the cases that a planner solves."""
    found = {}
    for name, case in load_cases().items():
        with suppress(NoPath, Trapped):
            found[name] = planner(tables[case.table], case.start, case.goal, margin=margin)
    return found


def by_group(plan: Plan) -> bool:
    """Whether a plan needed the exact search round a group of obstacles (section 3.3.2).

    Parameters
    ----------
    plan : Plan
        What `freeseg.plan` returned.

    Returns
    -------
    bool
        False where the greedy rule and its repairs alone found the path.
    """
    checks.instance("plan", plan, Plan, "what freeseg.plan returned")
    return any(step.kind == StepKind.LOCAL_MINIMUM for step in plan.steps)


def senses(plan: Plan) -> tuple[int, ...]:
    """Sides to which a plan turns, one obstacle after the other.

    Parameters
    ----------
    plan : Plan
        What a planner returned.

    Returns
    -------
    tuple of int
        1 to the left, where the right wheel is faster, and -1 to the right.

    Raises
    ------
    InvalidParameter
        For what is no plan.
    """
    checks.instance("plan", plan, Plan, "what a planner returned")
    # A square is gone round by up to four turns.
    return tuple(sense for (_, sense), _ in groupby(plan.turning_points, _obstacle_and_sense))


def _obstacle_and_sense(turn: TurningPoint) -> tuple[int, int]:
    return turn.obstacle, turn.sense
