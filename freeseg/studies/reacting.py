"""Reactive laws as rivals of planners, and a search of their gains.

Gains are searched on worlds that no comparison asks about, by one search for all laws: for a
Khepera IV in random worlds of three densities, and for the wide robot of BARN in rooms like
BARN's. All laws drive at the same top speed.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, reactive
from freeseg.data import DATA, read_csv
from freeseg.disturbance import Disturbance
from freeseg.errors import InvalidData, InvalidParameter, NoPath, Trapped
from freeseg.planners import shortest_path
from freeseg.random_worlds import SPACIOUS, random_query, random_world
from freeseg.react import ReactiveRun, react
from freeseg.reactive.sensing import Reactive
from freeseg.robot import KheperaIV, Robot, as_robot
from freeseg.studies.rivals import DENSITIES, PER_WORLD, Rival
from freeseg.studies.searching import evolve, four_digits
from freeseg.world import Disc, World

#: What a run counts that does not arrive, or collides: so many times the shortest path.
FAILED = 3.0

#: So long (s) the study waits for a robot that comes no nearer to its goal, in the search of gains
#: as in the comparison: two metres at the top speed.
PATIENCE = 10.0

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


#: What laws are tuned for, and the robot that drives there: random worlds, and rooms like BARN's.
TUNED_FOR = {"random": KheperaIV(), "barn": KheperaIV(diameter=0.43)}

#: Seed of the first world that gains are searched on. The worlds that rivals are compared in
#: have seeds from 0 on.
TRAINING_SEED = 100_000

#: So many tasks are searched on, of each density and of rooms.
TASKS = {"random": 3, "barn": 3}

#: Rooms like BARN's: cells in a row of the field and rows before it, and their width (m); where
#: the first is; the least and the largest share of cells that are filled; and where the robot
#: starts and is to go (m).
FIELD, WAY_IN, CELL, FIRST = 30, 34, 0.15, (-4.425, 0.075)
FILLED = 0.15, 0.3
ACROSS = (-2.25, 3.0), (-2.25, 13.0)

#: The laws by the names that rivals have, and what each knows.
REACTIVE = {
    "potential field": "PotentialField",
    "VFH+": "VectorFieldHistogram",
    "dynamic window": "DynamicWindow",
}
KNOWS = {
    "potential field": "the map: the nearest point of every obstacle; its own pose",
    "VFH+": "range readings all round, up to its reach; its own pose",
    "dynamic window": "range readings all round, up to its reach; its own pose; its limits",
}


class Task(NamedTuple):
    """A world, where to drive in it, the length (m) of the shortest path there, and the robot."""

    world: World
    start: np.ndarray
    goal: np.ndarray
    shortest: float
    robot: Robot | None = None


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


def room_like_barn(seed: int) -> World:
    """A room as those of BARN are: a way in, and a field of cylinders that touch.

    A cellular automaton clears single cells and fills narrow bays. The rooms are made by a rule
    of our own, to train on; BARN's worlds are others.

    Parameters
    ----------
    seed : int
        Equal seeds give equal rooms.

    Returns
    -------
    World
        Discs of half a cell.

    Raises
    ------
    InvalidParameter
        For a seed that is not a whole number from 0 on.
    """
    rng = np.random.default_rng(checks.whole("seed", seed))
    field = rng.random((FIELD, FIELD)) < rng.uniform(*FILLED)
    for _ in range(rng.integers(2, 5)):
        around = np.pad(field, 1, constant_values=True)
        beside = sum(
            np.roll(around, (i, j), (0, 1))[1:-1, 1:-1].astype(int)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if i or j
        )
        field = (beside > 4) | (field & (beside > 1))
    cells = np.zeros((WAY_IN + FIELD, FIELD), bool)
    cells[WAY_IN:] = field
    cells[0] = cells[:, 0] = cells[:, -1] = True
    row, column = np.nonzero(cells)
    centers = np.column_stack([column, row]) * CELL + FIRST
    return World([Disc(center, CELL / 2) for center in centers])


def training_tasks(name: str) -> tuple[Task, ...]:
    """What gains are searched on, one of `TUNED_FOR`.

    Parameters
    ----------
    name : str
        ``"random"`` or ``"barn"``.

    Returns
    -------
    tuple of Task

    Raises
    ------
    InvalidParameter
        For any other name.
    """
    robot = TUNED_FOR[checks.choice("name", name, TUNED_FOR)]
    if name == "random":
        return tuple(
            task._replace(robot=robot)
            for area in DENSITIES.values()
            for task in random_tasks(TASKS[name], TRAINING_SEED, PER_WORLD, area=area)
        )
    found: list[Task] = []
    seed = TRAINING_SEED
    while len(found) < TASKS[name]:
        world, seed = room_like_barn(seed), seed + 1
        try:
            length = shortest_path(world, *ACROSS, robot, 0.0).path.length
        except NoPath:
            continue
        start, goal = np.array(ACROSS)
        found.append(Task(world, start, goal, length, robot))
    return tuple(found)


def load_laws(
    file: str | PathLike[str] = DATA / "reactive_gains.csv",
) -> dict[str, dict[str, Reactive]]:
    """Laws with the gains that were found.

    Parameters
    ----------
    file : path-like, optional
        Written by ``tests/benchmarks/reactive.py --tune``.

    Returns
    -------
    dict
        What they were tuned for, of `TUNED_FOR`, to name of law, of `REACTIVE`, to law.

    Raises
    ------
    InvalidData
        For a file that cannot be read, a row of an unknown law or gain, a gain that is missing,
        twice or out of its range, or gains of which no law can be made.
    """
    path = checks.file("file", file)
    ranges = {(aim, law): of_law for aim in TUNED_FOR for law, of_law in GAIN_RANGES.items()}
    found = read_gains(path, ("tuned_for", "law"), ranges)
    try:
        return {
            aim: {name: getattr(reactive, law)(**found[aim, law]) for name, law in REACTIVE.items()}
            for aim in TUNED_FOR
        }
    except InvalidParameter as error:
        raise InvalidData(f"{path.name}: {error}; tune the laws again") from error


def read_gains(
    file: str | PathLike[str],
    keys: tuple[str, ...],
    ranges: Mapping[Any, Mapping[str, tuple[float, float]]],
) -> dict[Any, dict[str, float]]:
    """Gains that a search stored, one a row.

    Parameters
    ----------
    file : path-like
        CSV file with columns ``gain`` and ``value``, and the keys.
    keys : tuple of str
        Columns that say whose a gain is.
    ranges : dict
        What stands in those columns to name of gain to its least and largest value: all
        that the file must have.

    Returns
    -------
    dict
        What stands in those columns to name of gain to value.

    Raises
    ------
    InvalidData
        For a file that cannot be read, and for a gain that is unknown, missing, twice or out of
        its range.
    InvalidParameter
        For what are no names of columns, or no ranges.
    """
    path = checks.file("file", file)
    checks.instance("ranges", ranges, Mapping, "a dict of keys to ranges")  # type: ignore[type-abstract]
    checks.instances("ranges", ranges.values(), Mapping, "a dict for each key")  # type: ignore[type-abstract]
    remedy = "a tuple of names of columns, as many as each key of ranges has"
    checks.instances("keys", checks.instance("keys", keys, tuple, remedy), str, remedy)
    if any(not isinstance(key, tuple) or len(key) != len(keys) for key in ranges):
        raise InvalidParameter(f"keys is {checks.shown(keys)}; give {remedy}")
    found: dict[Any, dict[str, float]] = {key: {} for key in ranges}
    for row in read_csv(path, dict.fromkeys((*keys, "gain"), str) | {"value": float}):
        key = tuple(row[name] for name in keys)
        gains = found.get(key, {})
        low, high = ranges.get(key, {}).get(row["gain"], (np.inf, -np.inf))
        if not low <= row["value"] <= high or row["gain"] in gains:
            raise InvalidData(
                f"{path.name}, row {row['row']}: no gain within its range, or the second of its "
                "name; tune the laws again"
            )
        gains[row["gain"]] = row["value"]
    for key, gains in found.items():
        if gains.keys() != ranges[key].keys():
            whose = " for ".join(reversed(key))
            raise InvalidData(f"{path.name} lacks gains of {whose}; tune the laws again")
    return found


def reactive_rivals(
    file: str | PathLike[str] = DATA / "reactive_gains.csv",
) -> dict[str, Rival]:
    """The tuned laws as rivals of planners, for `rivals.compare`.

    Parameters
    ----------
    file : path-like, optional
        As for `load_laws`.

    Returns
    -------
    dict
        Name, of `REACTIVE`, to rival. It drives by the gains that were tuned for the robot whose
        diameter is nearest, with `PATIENCE`, and returns where; it is told no margin, and
        keeps its own.

    Raises
    ------
    InvalidData
        As `load_laws`.
    """
    tuned = load_laws(file)
    return {
        name: partial(_drive, laws={aim: tuned[aim][name] for aim in TUNED_FOR})
        for name in REACTIVE
    }


def _drive(
    world: World, start: Any, goal: Any, robot: Robot, _: float, laws: dict[str, Reactive]
) -> ReactiveRun:
    """What a robot drives by the law that is tuned for its like."""
    robot = as_robot(robot)
    aim = min(TUNED_FOR, key=lambda name: abs(TUNED_FOR[name].diameter - robot.diameter))
    return react(laws[aim], world, start, goal, robot, patience=PATIENCE)


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
        run = react(law, *task[:3], task.robot, disturbance=disturbance, seed=seed, **limits)
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
        run, arrived = attempt(law, task, patience=PATIENCE)
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
