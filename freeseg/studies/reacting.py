"""Reactive laws in random worlds: how far they drive, and a search of their gains."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, reactive
from freeseg.disturbance import Disturbance
from freeseg.errors import InvalidParameter, NoPath, Trapped
from freeseg.planners import shortest_path
from freeseg.random_worlds import SPACIOUS, random_query, random_world
from freeseg.react import ReactiveRun, react
from freeseg.reactive.sensing import Reactive
from freeseg.studies.searching import evolve, four_digits
from freeseg.world import World

#: What a run counts that does not arrive, or collides: so many times the shortest path.
FAILED = 3.0

#: A query whose shortest path is not so long (m) is left out, for it asks for nothing.
WORTH = 0.4

#: A search with more evaluations would not end.
MOST_EVALUATIONS = 1_000_000

#: More tasks would take days.
MOST_TASKS = 100_000

#: So many worlds are tried for a task.
MOST_TRIES = 50

#: Where gains are searched for, on a logarithmic scale. Speeds are no gains: all laws have one.
GAIN_RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "PotentialField": {
        "attraction": (0.2, 5),
        "repulsion": (1e-5, 0.1),
        "influence": (0.02, 0.5),
        "order": (1, 4),
        "steering": (1, 10),
        "turn_rate": (1, 10),
    },
    "VectorFieldHistogram": {
        "reach": (0.2, 1.5),
        "margin": (0.001, 0.03),
        "low": (0.1, 5),
        "high": (0.5, 10),
        "wide": (0.2, 3),
        "to_heading": (0.2, 5),
        "to_previous": (0.2, 5),
        "steering": (1, 10),
        "turn_rate": (1, 10),
    },
    "DynamicWindow": {
        "to_clear": (0.1, 10),
        "to_speed": (0.03, 3),
        "interval": (0.05, 3),
        "reach": (0.08, 1.5),
        "margin": (0.001, 0.03),
        "turn_rate": (1, 10),
        "approach": (0.3, 3),
    },
}


class Task(NamedTuple):
    """A world, where to drive in it, and the length (m) of the shortest path there."""

    world: World
    start: np.ndarray
    goal: np.ndarray
    shortest: float


def random_tasks(
    count: int,
    seed: int,
    n: int = 8,
    shapes: Iterable[str] = ("disc", "polygon"),
    area: float = SPACIOUS,
) -> tuple[Task, ...]:
    """Tasks that can be done, in random worlds.

    Parameters
    ----------
    count : int
        How many.
    seed : int
        Seed of the first world. Those without a path, or with one shorter than `WORTH`, are
        left out.
    n, shapes, area
        As for `random_world`.

    Returns
    -------
    tuple of Task

    Raises
    ------
    InvalidParameter
        For less than one task or over `MOST_TASKS`, or as `random_world`; or where it takes over
        `MOST_TRIES` worlds a task.
    """
    count, seed = checks.whole("count", count, 1, most=MOST_TASKS), checks.whole("seed", seed)
    found: list[Task] = []
    tries = 0
    while len(found) < count:
        world = random_world(n, seed + len(found) + tries, shapes, area)
        task = _make_task(world, seed + len(found) + tries)
        if task:
            found.append(task)
        else:
            tries += 1
        if tries > MOST_TRIES * count:
            raise InvalidParameter(
                f"n is {n} and area {area}: of {tries} worlds hardly one makes a task; give more "
                "obstacles or a larger area"
            )
    return tuple(found)


def _make_task(world: World, seed: int) -> Task | None:
    """The task in a world; None where there is no path, or hardly a way to drive."""
    start, goal = random_query(world, seed)
    try:
        length = shortest_path(world, start, goal).path.length
    except NoPath:
        return None
    return Task(world, start, goal, length) if length >= WORTH else None


def attempt(
    law: Reactive,
    task: Task,
    disturbance: Disturbance | None = None,
    seed: int | tuple[int, int] = 0,
    **limits: Any,
) -> tuple[ReactiveRun, bool]:
    """What a robot drives by a law, and whether it arrives without a collision.

    Parameters
    ----------
    law : Reactive
        Law.
    task : Task
        What it is to do.
    disturbance, seed, **limits
        As for `react`.
    """
    checks.instance("task", task, Task, "one that random_tasks made")
    try:
        run = react(law, *task[:3], disturbance=disturbance, seed=seed, **limits)
    except Trapped as trapped:
        return trapped.run, False
    return run, run.collision is None


def score(law: Reactive, tasks: Iterable[Task]) -> float:
    """Mean length driven, relative to the shortest path's; `FAILED` where it fails or is longer.

    Parameters
    ----------
    law : Reactive
        Law.
    tasks : sequence of Task
        Tasks.

    Raises
    ------
    InvalidParameter
        For what are no tasks, none, or no law.
    """
    ratios = []
    for task in _check_tasks(tasks):
        run, arrived = attempt(law, task)
        driven = float(np.hypot(*np.diff(run.pose[:2])).sum())
        ratios.append(min(driven / task.shortest, FAILED) if arrived else FAILED)
    return float(np.mean(ratios))


def _check_tasks(tasks: Any) -> tuple[Task, ...]:
    """`tasks` as a tuple; `InvalidParameter` for what are no tasks, or none."""
    found = checks.instances("tasks", tasks, Task, "what random_tasks made")
    if not found:
        raise InvalidParameter(f"tasks is {checks.shown(tasks)}; give what random_tasks made")
    return tuple(found)


def search(
    cost: Callable[[dict[str, float]], float],
    ranges: dict[str, tuple[float, float]],
    first: dict[str, float],
    seed: int,
    budget: int,
    population: int = 16,
) -> tuple[dict[str, float], float]:
    """The best gains that a number of evaluations finds, see `searching.evolve`.

    Parameters
    ----------
    cost : callable
        ``cost(gains)``, which is to be small.
    ranges : dict
        Name to least and largest value, both positive.
    first : dict
        Gains to begin with, within their ranges.
    seed : int
        Of the search.
    budget : int
        Evaluations: a multiple of the population.
    population : int, optional
        Of these, how many a generation has: at least 5.

    Returns
    -------
    gains : dict
        Name to value, of four digits.
    cost : float
        Theirs.

    Raises
    ------
    InvalidParameter
        For what is no function, gains out of their ranges, another budget, or no seed.
    """
    seed = checks.whole("seed", seed)
    checks.function("cost", cost, "cost(gains) -> float", {})
    population = checks.whole("population", population, 5, most=MOST_EVALUATIONS)
    budget = checks.whole("budget", budget, population, most=MOST_EVALUATIONS)
    if budget % population:
        raise InvalidParameter(f"budget is {budget}; give a multiple of {population}")
    _check_ranges(ranges, first)
    # Imported here: it takes long, and only this function needs it.
    from scipy.stats import qmc

    bounds, rng = np.log10(list(ranges.values())), np.random.default_rng(seed)
    low, high = bounds.T
    begin = low + (high - low) * qmc.LatinHypercube(len(ranges), rng=rng).random(population)
    begin[0] = np.log10([first[name] for name in ranges])

    def gains_of(logarithms: np.ndarray) -> dict[str, float]:
        values = np.clip(logarithms, low, high)
        return {name: four_digits(value) for name, value in zip(ranges, values, strict=True)}

    def score_of(logarithms: np.ndarray) -> float:
        return cost(gains_of(logarithms))

    found = evolve(score_of, bounds, begin, budget // population, rng)
    return gains_of(found.x), float(found.fun)


def _check_ranges(ranges: Any, first: Any) -> None:
    """`InvalidParameter` unless these are ranges of positive gains, and gains within them."""
    checks.instance("ranges", ranges, dict, "a dict of name to least and largest")
    checks.instance("first", first, dict, "a dict of name to value")
    if not ranges:
        raise InvalidParameter("ranges is empty; give the range of one gain at least")
    for name, within in ranges.items():
        low, high = checks.numbers(f"ranges[{name!r}]", within, 2)
        if not 0 < low < high:
            raise InvalidParameter(
                f"ranges[{name!r}] is {checks.shown(within)}; give a positive number and a larger"
            )
        if not low <= checks.as_float(first.get(name)) <= high:
            raise InvalidParameter(
                f"first {name} is {checks.shown(first.get(name))}; give {low:g} to {high:g}"
            )


def tune(
    name: str, tasks: Iterable[Task], seed: int, budget: int = 160
) -> tuple[dict[str, float], float]:
    """Search the best gains of a reactive law on training tasks.

    Parameters
    ----------
    name : str
        One of `GAIN_RANGES`.
    tasks : sequence of Task
        To train on.
    seed, budget : int
        As for `search`.

    Returns
    -------
    gains : dict
        Name to value.
    score : float
        Theirs; see `score`.

    Raises
    ------
    InvalidParameter
        For a name that is not known, and as `score` and `search`.
    """
    kind = getattr(reactive, checks.choice("name", name, GAIN_RANGES))
    # Here, for the search wraps the errors of its function.
    tasks = _check_tasks(tasks)

    def cost(gains: dict[str, float]) -> float:
        try:
            law = kind(**gains)
        except InvalidParameter:
            # Such as thresholds in the wrong order.
            return np.inf
        return score(law, tasks)

    first = {gain: getattr(kind(), gain) for gain in GAIN_RANGES[name]}
    return search(cost, GAIN_RANGES[name], first, seed, budget)
