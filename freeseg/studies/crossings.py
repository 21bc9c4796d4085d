"""Random scenes of movers that cross a robot's way, and how near rivals come to the optimum.

`tests/benchmarks/movers.py` lets a grid in space and time and a nonlinear programme look for
an arrival before that of `time_minimal_plan` in each scene; `load_crossings` reads what it stored.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from freeseg import checks
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidParameter
from freeseg.geometry import unit
from freeseg.planners.time_minimal import TimedPlan, time_minimal_plan
from freeseg.robot import KheperaIV
from freeseg.scene import Mover, Scene
from freeseg.segments import MARGIN
from freeseg.world import Disc, Polygon, World

#: Speed of the robot (m/s), and how far its centre keeps from obstacles (m).
CROSSING_SPEED = 0.3
CROSSING_KEEP = KheperaIV().radius + MARGIN / 2

#: Where the robot begins and where it is to be (m).
CROSSING_START, CROSSING_GOAL = (0.0, 0.0), (2.0, 0.0)

#: What stands in a scene besides what moves: in every five scenes, one with each.
CROSSING_KINDS = ("movers", "movers", "movers", "with discs", "with polygons")

#: The rivals' columns, and by how much one must be earlier to have won (relative).
RIVAL_NAMES = ("grid", "from_ours", "from_random", "from_grid")
WON_BY = 1e-4

#: At the start nothing is closer than this to what the robot keeps (m); nor stands at the goal.
HEADROOM = 0.01


def random_crossing(seed: int) -> Scene:
    """Scene number `seed`, of one to ten movers that bar the straight way.

    Parameters
    ----------
    seed : int
        Equal numbers give equal scenes.

    Returns
    -------
    Scene
        To be driven from `CROSSING_START` to `CROSSING_GOAL` at `CROSSING_SPEED`; whoever
        drives straight ahead at once meets something.

    Raises
    ------
    InvalidParameter
        For a seed that is not a whole number from 0 on.
    """
    seed = checks.whole("seed", seed)
    rng = np.random.default_rng(seed)
    kind, count = CROSSING_KINDS[seed % 5], 1 + seed // 5 % 10
    straight = np.linspace(CROSSING_START, CROSSING_GOAL, 400)
    far = CROSSING_GOAL[0] - CROSSING_START[0]
    t = np.linspace(0, far / CROSSING_SPEED, 400)
    while True:
        still = 0 if kind == "movers" else int(rng.integers(1, 4))
        world = World([_still(rng, kind, far) for _ in range(still)])
        scene = Scene(world, [_mover(rng, far) for _ in range(count)])
        clear = scene.distances(CROSSING_START, 0.0).min() > CROSSING_KEEP + HEADROOM
        at_goal = Scene(world).distances(CROSSING_GOAL, 0.0).min(initial=1.0)
        barred = scene.distances(straight, t).min() < CROSSING_KEEP
        if clear and at_goal > CROSSING_KEEP + HEADROOM and barred:
            return scene


def _mover(rng: np.random.Generator, far: float) -> Mover:
    """A disc that is somewhere near the straight way at some time on it."""
    when, radius = rng.uniform(0, far / CROSSING_SPEED), rng.uniform(0.05, 0.3)
    velocity = rng.uniform(0, 0.95 * CROSSING_SPEED) * unit(rng.uniform(-np.pi, np.pi))
    place = np.array([rng.uniform(-0.1, 1.1) * far, rng.normal(0, 0.25)])
    return Mover(Disc(place - when * velocity, radius), velocity)


def _still(rng: np.random.Generator, kind: str, far: float) -> Disc | Polygon:
    """A disc or a triangle that stands."""
    place = rng.uniform((0, -0.5), (far, 0.5))
    if kind == "with discs":
        return Disc(place, rng.uniform(0.05, 0.25))
    corners = unit(rng.uniform(0, 2 * np.pi) + np.array([0, 2.1, 4.2]))
    return Polygon(place + rng.uniform(0.1, 0.25, (3, 1)) * corners)


def plan_crossing(seed: int) -> TimedPlan:
    """The optimum in scene number `seed`."""
    return time_minimal_plan(random_crossing(seed), CROSSING_START, CROSSING_GOAL, CROSSING_SPEED)


def load_crossings() -> list[dict[str, Any]]:
    """Rows of ``data/movers_optimal.csv``, one a scene.

    Returns
    -------
    list of dict
        ``seed``, ``kind``, numbers of ``movers`` and of obstacles that stand ``still``,
        ``proved``, ``arrival_s`` (s), and the arrivals of rivals as multiples of that, 0
        where there is no answer: of the ``grid``, and of the programme ``from_ours``,
        ``from_random``, ``from_grid``.
    """
    columns = {"seed": int, "kind": str, "movers": int, "still": int, "proved": int}
    columns |= dict.fromkeys(("arrival_s", *RIVAL_NAMES), float)
    return read_csv(DATA / "movers_optimal.csv", columns)


def judge_rivals(rows: Sequence[dict[str, Any]], names: Sequence[str]) -> dict[str, Any]:
    """How near some rivals came, where one of them answered.

    Parameters
    ----------
    rows : sequence of dict
        Scenes, as from `load_crossings`.
    names : sequence of str
        Rivals, of `RIVAL_NAMES`; in each scene the best one counts.

    Returns
    -------
    dict
        ``answers``, in how many scenes; ``earlier``, in how many one arrived before us by
        more than `WON_BY`; ``near``, in how many within that; ``median``, of the ratio, and
        ``least``, NaN without an answer.

    Raises
    ------
    InvalidParameter
        For what are no such rows, or other rivals.
    """
    remedy = "rows of load_crossings"
    rows = checks.instances("rows", rows, Mapping, remedy)  # type: ignore[type-abstract]
    if any(set(RIVAL_NAMES) - row.keys() for row in rows):
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give {remedy}")
    for name in checks.instances("names", names, str, "some of RIVAL_NAMES"):
        checks.choice("names", name, RIVAL_NAMES)
    best = [min(found) for row in rows if (found := [row[name] for name in names if row[name]])]
    ratios = np.array(best) if best else np.array([np.nan])
    return {
        "answers": len(best),
        "earlier": int((ratios < 1 - WON_BY).sum()),
        "near": int((np.abs(ratios - 1) <= WON_BY).sum()),
        "median": float(np.median(ratios)),
        "least": float(ratios.min()),
    }
