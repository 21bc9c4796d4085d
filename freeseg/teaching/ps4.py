"""Tests of problem set 4: a contest of laws and planners against tuned baselines."""

from dataclasses import replace
from functools import cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from freeseg.disturbance import Disturbance
from freeseg.errors import NoPath
from freeseg.metrics import tracking as measure
from freeseg.path import Path, taut_path
from freeseg.planners import plan, shortest_path
from freeseg.random_worlds import random_query, random_world
from freeseg.reference import SMOOTHING, Reference, make_reference
from freeseg.reference import SPEED as CRUISING
from freeseg.robot import KheperaIV
from freeseg.simulate import Run, simulate
from freeseg.studies import courses, tracking, tuning
from freeseg.teaching.answered import numbers
from freeseg.teaching.check import Ask, Tracker
from freeseg.teaching.ps2 import turns_of
from freeseg.world import World

__all__ = ["arrives", "contest", "contract"]

#: What disturbs the robot of every second run: about twice what disturbs the others.
ROUGH = replace(
    tracking.DISTURBANCE,
    position_noise=0.002,
    heading_noise=float(np.radians(1)),
    slip=0.1,
    slip_fluctuation=0.04,
    wheel_base_error=0.06,
    lag=0.06,
    delay=0.1,
)
#: The tuned trackers to beat, and the one of them that an observer helps, as in lesson 12.
BASELINES, OBSERVED = ("Pid", "SlidingMode", "Mpc"), "SlidingMode"
#: What a second costs, 1 m/s^2 of needless work, and a touch (mm).
SECOND, WORK, TOUCH_COSTS = 0.75, 20.0, 1000.0
#: From which gap on to an obstacle nearness costs (m), and what it costs (mm for each mm).
NEARBY, NEARNESS = 0.01, 0.1
#: The part of the best baseline's cost from which points are paid; the share of them that the
#: observed one gets; and the part of its cost for all of them.
PAYS_FROM, OBSERVED_PAYS, PAYS_ALL = 0.9, 1 / 3, 0.6
#: Cases of a draw, every second one on a rough day, and of the test of arrival; in each case,
#: another path with a narrow margin is so much shorter (m).
CASES_OF_DRAW, CASES_OF_ARRIVAL, NARROW, SAVED = 4, 2, 0.02, (0.05, 0.1)
#: How far from its reference a robot begins at most (m, rad).
STARTS_WITHIN = 0.005, float(np.radians(5))
#: What "arrived" means: distance from the goal, and from the path all the way (m).
AT_GOAL, ASTRAY = 0.02, 0.05


class Case(NamedTuple):
    """A world, a query, the reference along the given path, where a robot begins, and its day."""

    world: World
    start: np.ndarray
    goal: np.ndarray
    given: Reference
    offset: np.ndarray
    day: Disturbance
    seed: tuple[int, int]

    def run(self, tracker: Any, reference: Reference, day: Disturbance | None = None) -> Run:
        """Drive a tracker in this case."""
        day = day or self.day
        return simulate(tracker, reference, None, courses.DT, self.offset, day, self.seed)


@cache
def cases(draw: int, number: int) -> tuple[Case, ...]:
    """Cases of a draw, in which a planner can do better than the given path."""
    found: list[Case] = []
    for seed in count(draw):
        world = random_world(courses.OBSTACLES, seed)
        start, goal = random_query(world, seed, margin=courses.WIDE_MARGIN)
        try:
            path = plan(world, start, goal, margin=courses.WIDE_MARGIN).path
        except NoPath:
            continue
        roomy = path.clearance(world) > KheperaIV().radius + 0.49 * courses.WIDE_MARGIN
        # No path is shorter than the straight line.
        if not roomy or path.length - np.hypot(*(goal - start)) < SAVED[0]:
            continue
        saved = path.length - shortest_path(world, start, goal, margin=NARROW).path.length
        if path.length > courses.LENGTH and SAVED[0] < saved < SAVED[1]:
            offset = courses.spread_offsets(1, seed, STARTS_WITHIN)[:, 0]
            day = (tracking.DISTURBANCE, ROUGH)[len(found) % 2]
            given = _along(path, world)
            found.append(Case(world, start, goal, given, offset, day, (draw, seed)))
        if len(found) == number:
            break
    return tuple(found)


def _along(path: Path, world: World) -> Reference:
    """Reference along a path; the speed is the same for all."""
    return make_reference(path, KheperaIV(), CRUISING, smoothing=SMOOTHING, world=world)


def _reference(ask: Ask, case: Case) -> Reference:
    """Reference along a student's path in a case."""
    answer = ask("plan_turns", case.world, case.start, case.goal)
    if answer is None:
        return case.given
    path = taut_path(case.start, turns_of(answer), case.goal)[0]
    assert path is not None, "there is no way round your turns; is each (center, ±radius)?"
    clearance = path.clearance(case.world)
    assert clearance >= KheperaIV().radius - 1e-9, (
        f"your path comes to {1000 * clearance:.1f} mm from an obstacle, the robot's radius is "
        f"{1000 * KheperaIV().radius:.1f} mm"
    )
    return _along(path, case.world)


def _cost(tracker: Any, case: Case, reference: Reference) -> float:
    """Cost (mm) of one run."""
    found = measure(case.run(tracker, reference), case.world)
    needless = found["wheel_variation_m_s"] - courses.needed_variation(case.given)
    gap = found["clearance_m"] - KheperaIV().radius
    return float(
        1000 * found["position_rms_m"]
        + WORK * max(0.0, needless) / case.given.duration
        + SECOND * (reference.duration - case.given.duration)
        + 1000 * NEARNESS * max(0.0, NEARBY - gap)
        + TOUCH_COSTS * (gap < 0)
    )


@cache
def baselines(draw: int) -> dict[str, float]:
    """Mean costs (mm) of the baselines on the cases of a draw, the observed one last."""
    gains = tuning.load_gains()
    trackers = {name: gains[name][0].tracker for name in BASELINES}
    trackers["observed"] = tuning.load_gains(form="observed")[OBSERVED][0].tracker
    return {
        name: float(np.mean([_cost(tracker, one, one.given) for one in cases(draw, CASES_OF_DRAW)]))
        for name, tracker in trackers.items()
    }


def share_of(mine: float, known: dict[str, float]) -> float:
    """Share of the contest's points for a mean cost (mm), given those of the baselines."""
    observed = known["observed"]
    best = min(known[name] for name in BASELINES)
    paid = PAYS_ALL * observed, observed, max(PAYS_FROM * best, observed)
    return float(np.interp(mine, paid, (1.0, OBSERVED_PAYS, 0.0)))


def contract(ask: Ask, rng: np.random.Generator) -> None:
    """The contract of an entry."""
    (case,) = cases(int(rng.integers(2**20)), 1)
    reference = _reference(ask, case)
    law = Tracker(ask).start(reference, KheperaIV(), courses.DT)
    numbers(law(0.0, reference.pose[:, 0]), (2,), "a law gives back V and w, two numbers")
    runs = [case.run(Tracker(ask), reference, ROUGH).pose for _ in range(2)]
    assert np.array_equal(runs[0], runs[1]), (
        "the same run again goes elsewhere: your law remembers the run before, or draws random "
        "numbers. Keep what it remembers in variables inside start"
    )
    left, way = (np.hypot(*(case.goal - end)) for end in (runs[0][:2, -1], case.start))
    assert left < way / 2, (
        f"your robot is {1000 * left:.0f} mm from its goal at the end, and was {1000 * way:.0f} mm "
        "from it at the start: it has to get at least half of the way"
    )


def arrives(ask: Ask, rng: np.random.Generator) -> None:
    """The robot arrives."""
    for case in cases(int(rng.integers(2**20)), CASES_OF_ARRIVAL):
        run = case.run(Tracker(ask), _reference(ask, case), ROUGH)
        found = measure(run, case.world)
        off, most = found["position_final_m"], found["position_max_m"]
        assert off < AT_GOAL, (
            f"your robot ends {1000 * off:.0f} mm from its goal; {1000 * AT_GOAL:.0f} are allowed"
        )
        assert most < ASTRAY, (
            f"your robot strays {1000 * most:.0f} mm from its path; {1000 * ASTRAY:.0f} are allowed"
        )
        gap = 1000 * (found["clearance_m"] - KheperaIV().radius)
        assert gap >= 0, f"your robot's disc goes {-gap:.1f} mm into an obstacle"


def contest(ask: Ask, rng: np.random.Generator) -> tuple[float, str]:
    """The contest."""
    draw = int(rng.integers(2**20))
    known = baselines(draw)
    mine = np.mean(
        [_cost(Tracker(ask), one, _reference(ask, one)) for one in cases(draw, CASES_OF_DRAW)]
    )
    r = mine / min(known[name] for name in BASELINES)
    told = ", ".join(f"{name} {cost:.2f}" for name, cost in known.items())
    share = share_of(float(mine), known)
    return share, f"r = {r:.3f}: yours costs {mine:.2f} mm; {told}"
