"""Methods side by side among movers: collisions, arrivals, delay over the earliest arrival, time.

Every method drives the same robot, at most at the same speed, from the same starts in the
same scenes, and sees the movers with the same noise; but for the offline plan, which is told how
they move and so has no noise. Each drive is judged by the scene as it is.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks, reactive
from freeseg.data import DATA, read_rows, write_rows
from freeseg.errors import InvalidParameter, InvalidQuery, NoPath, Trapped
from freeseg.following import Following
from freeseg.geometry import unit
from freeseg.planners import shortest_path, time_minimal_plan
from freeseg.random_worlds import SIZES
from freeseg.react import ARRIVED, react
from freeseg.reactive.sensing import Reactive, is_reactive
from freeseg.reference import SPEED
from freeseg.replanning import SIGHT_NOISE, Replanning, observe
from freeseg.robot import KheperaIV
from freeseg.scene import Mover, Scene
from freeseg.studies.reacting import FAILED, GAIN_RANGES, PATIENCE, REACTIVE, read_gains
from freeseg.studies.runner import run
from freeseg.studies.statistics import Difference, Share, differences, interval, share
from freeseg.world import Disc, World

#: Side of the square that movers cross (m), what stands in it, and how far before and behind it the
#: robot starts and is to arrive (m).
SQUARE, STANDING, BEYOND = 1.0, 2, 0.15

#: How many movers cross it, and their speeds relative to the robot's.
CROWDS, RATIOS = (2, 4, 8), (0.4, 0.8)

#: Time between two commands (s): 20 Hz; and how long a drive may take (s).
TICK, LONGEST_DRIVE = 0.05, 40.0

#: The method that knows how movers move, which is told their velocities.
OFFLINE = "time-minimal, offline"

#: The method that plans at every step, and the one that looks at no movers.
ANEW, BLIND = "re-planning", "nothing"

#: What `possible` says of scenes that are counted apart.
IMPOSSIBLE = "no", "overrun"

#: Where the study's rows are, written by tests/benchmarks/avoid_movers.py.
DRIVES = DATA / "movers.npz"

#: The same with more noise, which those that can be are told (m), in the first scenes.
NOISY_DRIVES, NOISES = DATA / "movers_noise.npz", (0.005, 0.01)

#: Gains that tests/benchmarks/avoid_movers.py found for the methods that have some, and in which
#: scenes, none of the study's.
MOVERS_GAINS = DATA / "movers_gains.csv"
TRAINING_SCENES = range(100_000, 100_024)

#: Where they are searched for, on a logarithmic scale: the acceleration of the offline plan's
#: reference, and the speed that it leaves; steps that the MPC foresees and its price on coming too
#: close; and what the reactive laws have.
MOVERS_RANGES = {
    OFFLINE: {"acceleration": (0.05, 1.0), "reserve": (0.002, 0.1)},
    "MPC": {"horizon": (10.0, 60.0), "keep_out": (10.0, 10_000.0)},
    **{name: GAIN_RANGES[law] for name, law in REACTIVE.items()},
    # With what is its own where nothing moves, it would creep to the goal.
    "VFH+": GAIN_RANGES[REACTIVE["VFH+"]] | {"approach": (0.3, 10.0)},
}

#: The same of ORCA, which tests/benchmarks/avoid_movers.py drives: the time (s) that it foresees,
#: among what moves and beside what stands, and its steering.
PEER_RANGES = {
    "ORCA": {
        "horizon": (0.5, 16.0),
        "standing": (0.25, 8.0),
        "steering": (1.0, 10.0),
        "turn_rate": (1.0, 10.0),
    }
}

#: What a row says of a drive that was none.
NOT_DRIVEN = {"outcome": "not driven", "ticks": 0, "missed": 0, "late": 0} | dict.fromkeys(
    ("arrival_s", "collision_s", "clearance_m", "median_ms", "p95_ms"), math.nan
)

#: Arrivals that differ by less, relatively, are one.
SAME_TIME = 1e-9

#: A share of no scenes.
NO_SHARE = Share(math.nan, math.nan, math.nan)

#: Columns of `load_drives`, and what they are kept as.
FORM = {
    "scene": int,
    "movers": int,
    "ratio": float,
    "noise_m": float,
    "possible": str,
    "proved": bool,
    "bound_s": float,
    "static_s": float,
    "method": str,
    "outcome": str,
    "arrival_s": float,
    "collision_s": float,
    "clearance_m": float,
    "ticks": int,
    "missed": int,
    "median_ms": float,
    "p95_ms": float,
    "late": int,
}


class MovingTask(NamedTuple):
    """A scene, where to drive in it (m), how many movers it has and their relative speed."""

    scene: Scene
    start: np.ndarray
    goal: np.ndarray
    movers: int
    ratio: float


def random_task(number: int) -> MovingTask:
    """Scene of the study, by its number: every six are one of each density and speed.

    Parameters
    ----------
    number : int
        From 0 on.

    Returns
    -------
    MovingTask
        Two discs that stand, and movers in random directions; half way through the
        shortest drive, each is somewhere on the square.

    Raises
    ------
    InvalidParameter
        For what is no such number.
    """
    number = checks.whole("number", number)
    movers = CROWDS[number % len(CROWDS)]
    ratio = RATIOS[number // len(CROWDS) % len(RATIOS)]
    rng = np.random.default_rng((19, number))
    start, goal = (
        np.array([x, rng.uniform(0.2, 0.8) * SQUARE]) for x in (-BEYOND, SQUARE + BEYOND)
    )
    still = [_disc(rng, rng.uniform(SIZES[1], SQUARE - SIZES[1], 2)) for _ in range(STANDING)]
    half = math.dist(start, goal) / SPEED / 2
    found: list[Mover] = []
    while len(found) < movers:
        velocity = ratio * SPEED * unit(rng.uniform(-np.pi, np.pi))
        disc = _disc(rng, rng.uniform(0, SQUARE, 2) - half * velocity)
        # No law starts with a goal where the robot cannot be.
        if math.dist(disc.center, goal) > disc.radius + KheperaIV().diameter:
            found.append(Mover(disc, velocity=velocity))
    return MovingTask(Scene(World(still), found), start, goal, movers, ratio)


def _disc(rng: np.random.Generator, center: np.ndarray) -> Disc:
    """A disc of random size."""
    return Disc(center, rng.uniform(*SIZES))


def methods() -> dict[str, Reactive]:
    """The methods of this package by their names, with the gains that were found for them.

    Returns
    -------
    dict
        For `compare`. Those that plan keep a margin of 10 mm, for noise and for the robot's
        own accelerations.
    """
    gains = load_gains()
    tuned = {name: with_gains(name, gains[name]) for name in MOVERS_RANGES}
    return {OFFLINE: tuned[OFFLINE], ANEW: Replanning()} | tuned | {BLIND: Following()}


def told_noise(given: Mapping[str, Reactive], noise: float) -> dict[str, Reactive]:
    """Methods that are told with which noise they see, those that can be.

    Parameters
    ----------
    given : dict
        Name to law.
    noise : float
        Standard deviation of an observed position (m).

    Returns
    -------
    dict
        For `compare`.

    Raises
    ------
    InvalidParameter
        For what are no methods, or a noise that is negative.
    """
    noise = _check_noise(noise)
    return {
        name: replace(law, noise=noise) if hasattr(law, "noise") else law  # type: ignore[type-var]
        for name, law in _check_methods(given).items()
    }


def with_gains(method: str, gains: Mapping[str, float]) -> Reactive:
    """A method of `MOVERS_RANGES` with some gains.

    Parameters
    ----------
    method : str
        Name.
    gains : dict
        Name to value; the MPC's horizon is rounded.

    Returns
    -------
    Reactive
        For `compare`.

    Raises
    ------
    InvalidParameter
        For another method, or gains of which it cannot be made.
    """
    ranges = MOVERS_RANGES[checks.choice("method", method, MOVERS_RANGES)]
    if not isinstance(gains, Mapping) or gains.keys() != ranges.keys():
        raise InvalidParameter(
            f"gains is {checks.shown(gains)}; give a dict with {', '.join(ranges)} for {method}"
        )
    if method == OFFLINE:
        acceleration, reserve = gains["acceleration"], gains["reserve"]
        return Following(timed=True, acceleration=acceleration, reserve=reserve)
    if method != "MPC":
        return getattr(reactive, REACTIVE[method])(**gains)
    # Imported here: CasADi takes long to load.
    from freeseg.trackers.mpc import Mpc

    steps = round(gains["horizon"])
    mpc = Mpc(horizon=steps, keep_out=gains["keep_out"], on_failure="brake", nearest=4)
    return Following(mpc, keep_out=True)


def load_gains(file: str | PathLike[str] = MOVERS_GAINS) -> dict[str, dict[str, float]]:
    """Gains that were found in the `TRAINING_SCENES` scenes: method to name to value.

    Raises
    ------
    InvalidData
        As for `reacting.read_gains`.
    """
    ranges = {(method,): of_method for method, of_method in (MOVERS_RANGES | PEER_RANGES).items()}
    found = read_gains(file, ("method",), ranges)
    return {method: gains for (method,), gains in found.items()}


def score_among_movers(
    law: Reactive, numbers: Iterable[int] = TRAINING_SCENES, noise: float = SIGHT_NOISE
) -> float:
    """Mean arrival of a law relative to the bound, where a failure counts `FAILED`.

    Parameters
    ----------
    law : Reactive
        Law.
    numbers : iterable of int, optional
        Scenes; those in which nothing can arrive do not count.
    noise : float, optional
        As for `drive_all`; 0 for a law that is told how movers move.

    Returns
    -------
    float
        The less, the better.

    Raises
    ------
    InvalidParameter
        For what is no law, or numbers of no scene in which something can arrive.
    """
    numbers = checks.sequence("numbers", numbers, "numbers of scenes")
    rows = [drive_all(number, {"law": law}, noise)[0] for number in numbers]
    scores = [
        min(row["arrival_s"] / row["bound_s"], FAILED) if row["outcome"] == "arrived" else FAILED
        for row in rows
        if row["possible"] == "yes"
    ]
    if not scores:
        raise InvalidParameter("numbers has no scene in which something arrives; give others")
    return float(np.mean(scores))


class _Clocked:
    """A reactive law that sees a scene with noise, is held to a speed, and is timed."""

    def __init__(self, law: Reactive, seen: Callable[[Any], Any]) -> None:
        self.law, self.seen = law, seen
        self.seconds: list[float] = []
        self.begun: Any = None

    def start(self, scene, goal, robot, dt):
        """The law, with its clock."""
        self.begun = self.law.start(self.seen(scene), goal, robot, dt)

        def law(t, pose):
            begin = time.process_time()
            v, omega = self.begun(t, pose)
            self.seconds.append(time.process_time() - begin)
            return min(max(v, -SPEED), SPEED), omega

        return law


def bound(task: MovingTask) -> dict[str, Any]:
    """What is known of the earliest arrival in a scene.

    Parameters
    ----------
    task : MovingTask
        Scene.

    Returns
    -------
    dict
        ``possible``: ``"yes"``, ``"no"`` where it is proved that nothing arrives, ``"overrun"``
        where the robot is met at its start at once, ``"unknown"``; ``bound_s``,
        the arrival of the plan without a margin (NaN without one), and whether it
        is ``proved`` that nothing arrives, which here means comes within `ARRIVED` of the
        goal, before it by more than that way takes; ``static_s``, that of the shortest path
        among what stands, which is a bound for all. Both for a point that has its
        speed at once.
    """
    checks.instance("task", task, MovingTask, "one from random_task")
    found: dict[str, Any] = {
        "possible": "yes",
        "proved": False,
        "bound_s": math.nan,
        "static_s": math.nan,
    }
    try:
        still = shortest_path(task.scene.world, task.start, task.goal, margin=0)
        found["static_s"] = still.path.length / SPEED
        arrival, proved = _earliest(task, task.scene)
        if proved:
            # What is beside the goal may be free earlier, where the last of the way is not.
            relaxed = _relaxed(task, found["static_s"], arrival)
            if relaxed is not task.scene:
                eased, proved = _earliest(task, relaxed)
                arrival = min(arrival, eased) if proved else arrival
        # Nothing is faster than the shortest path among what stands.
        as_fast = arrival <= found["static_s"] * (1 + SAME_TIME)
        found |= {"bound_s": arrival, "proved": proved or as_fast}
    except NoPath:
        found["possible"] = "no"
    except InvalidQuery:
        found["possible"] = "overrun"
    except Trapped:
        found["possible"] = "unknown"
    return found


def _earliest(task: MovingTask, scene: Scene) -> tuple[float, bool]:
    """The earliest arrival (s) at a task's goal in a scene, without a margin, and its proof."""
    plan = time_minimal_plan(scene, task.start, task.goal, SPEED, margin=0)
    return float(plan.arrival), plan.proved


def _relaxed(task: MovingTask, since: float, until: float) -> Scene:
    """A scene in which none bars the last of the way, `ARRIVED` long, between two times.

    It is the task's own where none does. Movers that come so near to the goal then are smaller by
    what they and the robot move meanwhile.
    """
    times = np.arange(since - ARRIVED / SPEED, until, TICK)
    there = np.broadcast_to(task.goal, (len(times), 2))
    # Between two times, one comes nearer by less than what it moves.
    near = KheperaIV().radius + ARRIVED + task.ratio * SPEED * TICK
    gaps = Scene(World([]), task.scene.movers).distances(there, times)
    bars = gaps.min(0, initial=np.inf) < near
    if not bars.any():
        return task.scene
    less, movers = ARRIVED * (1 + task.ratio), []
    for mover, is_barring in zip(task.scene.movers, bars, strict=True):
        disc: Any = mover.obstacle
        if not is_barring:
            movers.append(mover)
        elif disc.radius > less:
            movers.append(replace(mover, obstacle=Disc(disc.center, disc.radius - less)))
    return Scene(task.scene.world, movers)


def drive_all(
    number: int, given: Mapping[str, Reactive] | None = None, noise: float = SIGHT_NOISE
) -> list[dict[str, Any]]:
    """Let every method drive in one scene.

    Parameters
    ----------
    number : int
        Of the scene, see `random_task`.
    given : dict, optional
        Name to law; by default `methods`.
    noise : float, optional
        Standard deviation (m) of what is seen of a mover's x and y. An assumption.

    Returns
    -------
    list of dict
        A row a method: ``scene``, ``movers`` and ``ratio``; what `bound` says; ``method``, and the
        ``noise_m`` with which it sees, none for `OFFLINE`;
        ``outcome``: ``"arrived"``, ``"collided"``, wherever it went then, ``"late"`` if it did not
        arrive within `LONGEST_DRIVE` or came no nearer for `PATIENCE` seconds, ``"gave up"`` if it
        refused to drive, and ``"not driven"`` if the robot was met at once; ``arrival_s`` and
        ``collision_s`` (NaN where it has none), ``clearance_m``, the smallest distance of the
        robot's centre from an obstacle; ``ticks``, commands given; ``missed``, of these,
        the ones without a plan; ``median_ms`` and ``p95_ms`` of the processor time of its
        commands, and ``late``, how many took over `TICK`.
    """
    given, noise = _check_methods(given), _check_noise(noise)
    task = random_task(number)
    head = {"scene": number, "movers": task.movers, "ratio": task.ratio} | bound(task)
    rows = []
    for name, law in given.items():
        told = 0.0 if name == OFFLINE else noise
        driven = {} if head["possible"] == "overrun" else _drive(law, task, number, told)
        rows.append(head | {"method": name, "noise_m": told} | NOT_DRIVEN | driven)
    return rows


def _check_methods(given: Any) -> Mapping[str, Reactive]:
    """`given`, or `methods` for None; `InvalidParameter` for anything else."""
    if given is None:
        return methods()
    remedy = "a dict of name to law, such as moving.methods()"
    checks.instance("given", given, Mapping, remedy)  # type: ignore[type-abstract]
    for name, law in given.items():
        if not is_reactive(law):
            raise InvalidParameter(
                f"given has {checks.shown(law)} for {checks.shown(name)}; give {remedy}"
            )
    return given


def _check_noise(noise: object) -> float:
    """A noise (m) with which movers can still be seen."""
    return checks.number(
        "noise", noise, lambda found: 0 <= found <= SQUARE, f"a distance up to {SQUARE:g} m"
    )


def _drive(law: Reactive, task: MovingTask, number: int, noise: float) -> dict[str, Any]:
    """What a row says of a drive."""

    def seen(scene):
        return observe(scene, noise, number, TICK) if noise else scene

    clocked, outcome, driven = _Clocked(law, seen), "arrived", None
    try:
        driven = react(
            clocked, task.scene, task.start, task.goal, dt=TICK,
            tolerance=ARRIVED, patience=PATIENCE, limit=LONGEST_DRIVE,
        )  # fmt: skip
    except Trapped as trapped:
        # Raised by the loop with its run, or by a planner without one.
        outcome, driven = "late", getattr(trapped, "run", None)
    except (NoPath, InvalidQuery):
        # There is no way, or a mover will be where a plan would begin.
        pass
    if driven is None:
        return {"outcome": "gave up"}
    if driven.collision is not None:
        outcome = "collided"
    ms = 1e3 * np.array(clocked.seconds)
    return {
        "outcome": outcome,
        "arrival_s": float(driven.t[-1]) if outcome == "arrived" else math.nan,
        "collision_s": math.nan if driven.collision is None else driven.collision,
        "clearance_m": driven.clearance,
        "ticks": len(ms),
        "missed": getattr(clocked.begun, "missed", 0),
        "median_ms": float(np.median(ms)),
        "p95_ms": float(np.quantile(ms, 0.95)),
        "late": int((ms > 1e3 * TICK).sum()),
    }


def _drive_all(
    number: int, _: int, given: Mapping[str, Reactive] | None, noise: float
) -> list[dict[str, Any]]:
    """As `drive_all`; the seed of a scene is its number, not the runner's."""
    return drive_all(number, given, noise)


def compare(
    numbers: Iterable[int],
    given: Mapping[str, Reactive] | None = None,
    noise: float = SIGHT_NOISE,
    store: str | PathLike[str] | None = None,
    jobs: int | None = 1,
) -> list[dict[str, Any]]:
    """Let every method drive in many scenes.

    Parameters
    ----------
    numbers : iterable of int
        Of the scenes.
    given, noise
        As for `drive_all`.
    store, jobs : optional
        Where rows are kept, and processes, see `runner.run`.

    Returns
    -------
    list of dict
        Rows of `drive_all`.

    Raises
    ------
    InvalidParameter
        For what are no methods, no noise, or no numbers of scenes.
    """
    given = _check_methods(given)
    function = partial(_drive_all, given=given, noise=_check_noise(noise))
    rows = run(function, numbers, store, jobs=jobs, strict=True)
    return [{name: row[name] for name in FORM} for row in rows]


def save_drives(rows: Iterable[Mapping[str, Any]], file: str | PathLike[str] = DRIVES) -> None:
    """Write rows of `compare` as arrays, one a column of `FORM`."""
    write_rows(file, _checked(rows), FORM)


def load_drives(file: str | PathLike[str] = DRIVES) -> list[dict[str, Any]]:
    """Rows that `save_drives` wrote.

    Raises
    ------
    InvalidData
        For a file that cannot be read, or has other columns.
    """
    return read_rows(file, FORM, "give what tests/benchmarks/avoid_movers.py wrote")


def summarise(
    rows: Iterable[Mapping[str, Any]], by: tuple[str, ...] = ("movers", "ratio")
) -> list[dict[str, Any]]:
    """One row for each kind of scene and method, of the rows of `compare`.

    Parameters
    ----------
    rows : iterable of dict
        From `compare` or `load_drives`.
    by : tuple of str, optional
        What makes a kind of scene: of ``"movers"``, ``"ratio"`` and ``"noise_m"``; none for all at
        once.

    Returns
    -------
    list of dict
        The kind; ``method``; ``scenes``, and of these ``impossible``, those that are not
        counted any further, for nothing arrives there or the robot is met at once;
        ``collided`` and ``arrived``, shares of the others, each a `Share` with
        Wilson's interval; ``delayed``, the number of those that arrived with a bound;
        ``delay``, the mean of arrival over bound minus one of these, where the bound is less by
        what it takes to drive `ARRIVED` (a mover that leaves the goal last may free what is near
        it earlier than that), with
        ``delay_low`` and ``delay_high``, its bootstrap interval, and ``delay_median``; the same
        of only those with a proved bound as ``proved`` (number) and ``proved_delay`` (mean);
        ``missed``, the share of commands without a plan, and ``over``, of those that took
        longer than `TICK`; ``median_ms`` and ``p95_ms``, medians over the drives of theirs. NaN
        where there is none.

    Raises
    ------
    InvalidParameter
        For what are no such rows, or another kind.
    """
    found = _checked(rows)
    if not isinstance(by, tuple | list) or any(
        name not in ("movers", "ratio", "noise_m") for name in by
    ):
        raise InvalidParameter(
            f"by is {checks.shown(by)}; give some of ('movers', 'ratio', 'noise_m'), or none"
        )
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in found:
        groups.setdefault((*(row[name] for name in by), row["method"]), []).append(row)
    names = (*by, "method")
    return [dict(zip(names, key, strict=True)) | _summary(group) for key, group in groups.items()]


def _summary(group: list[Mapping[str, Any]]) -> dict[str, Any]:
    """Numbers of one method's rows."""
    tried = [row for row in group if row["possible"] not in IMPOSSIBLE]
    arrived = [row for row in tried if row["outcome"] == "arrived"]
    collided = sum(row["outcome"] == "collided" for row in tried)
    bounded = [row for row in arrived if math.isfinite(row["bound_s"])]
    # Who is so near has arrived, which the bound is not told.
    earliest = np.array([row["bound_s"] for row in bounded]) - ARRIVED / SPEED
    delays = np.array([row["arrival_s"] for row in bounded]) / earliest - 1
    proved = delays[np.array([row["proved"] for row in bounded], bool)]
    ticks = sum(row["ticks"] for row in tried)
    low, high = _interval(delays)
    driven = [row for row in tried if row["ticks"]]
    return {
        "scenes": len(group),
        "impossible": len(group) - len(tried),
        "collided": share(collided, len(tried)) if tried else NO_SHARE,
        "arrived": share(len(arrived), len(tried)) if tried else NO_SHARE,
        "delayed": len(delays),
        "delay": _of(np.mean, delays),
        "delay_low": low,
        "delay_high": high,
        "delay_median": _of(np.median, delays),
        "proved": len(proved),
        "proved_delay": _of(np.mean, proved),
        "missed": sum(row["missed"] for row in tried) / max(ticks, 1),
        "over": sum(row["late"] for row in tried) / max(ticks, 1),
        "median_ms": _of(np.median, np.array([row["median_ms"] for row in driven])),
        "p95_ms": _of(np.median, np.array([row["p95_ms"] for row in driven])),
    }


def _of(number: Callable[..., Any], values: np.ndarray) -> float:
    """A number of some values; NaN where there is none."""
    return float(number(values)) if len(values) else math.nan


def _interval(values: np.ndarray) -> tuple[float, float]:
    """Bootstrap interval of a mean over scenes, NaN for fewer than two."""
    if len(values) < 2:
        return math.nan, math.nan
    # All drives are of the one robot, so only scenes are resampled.
    return interval(np.stack([values, values], -1))


def pairs(rows: Iterable[Mapping[str, Any]]) -> tuple[Difference, ...]:
    """Differences of the shares of scenes in which methods arrive unharmed, paired by scene.

    Parameters
    ----------
    rows : iterable of dict
        From `compare` or `load_drives`: of every method in the same scenes.

    Returns
    -------
    tuple of Difference
        Of all pairs of methods, with simultaneous intervals, over the scenes that are not
        impossible.

    Raises
    ------
    InvalidParameter
        For what are no such rows, or fewer than four scenes.
    """
    arrived: dict[str, dict[int, float]] = {}
    for row in _checked(rows):
        if row["possible"] not in IMPOSSIBLE:
            of_method = arrived.setdefault(row["method"], {})
            of_method[row["scene"]] = float(row["outcome"] == "arrived")
    scenes = sorted(set.union(*map(set, arrived.values()))) if arrived else []
    if any(set(scenes) - of_method.keys() for of_method in arrived.values()):
        raise InvalidParameter("rows lacks a method in some scene; give all of compare")
    return differences(
        {
            name: np.tile([[of_method[scene]] for scene in scenes], 4)
            for name, of_method in arrived.items()
        }
    )


class Beside(NamedTuple):
    """What pairs of drives, each in one scene, say of a method and a rival.

    Attributes
    ----------
    method : str
    arrivals : (float, float)
        Interval of its share of arrivals less the rival's, simultaneous with those of
        all pairs of methods.
    delay : (float, float)
        Interval of its mean delay less the rival's, simultaneous with those of all methods
        beside that rival.
    delays : ndarray, shape (k,)
        That difference in each scene in which both arrive and there is a bound, relative to it.
    """

    method: str
    arrivals: tuple[float, float]
    delay: tuple[float, float]
    delays: np.ndarray


def beside(rows: Iterable[Mapping[str, Any]], rival: str = ANEW) -> list[Beside]:
    """Each method beside one of them, in pairs.

    Parameters
    ----------
    rows : iterable of dict
        As for `pairs`.
    rival : str, optional
        Name of the one that all others are compared with.

    Returns
    -------
    list of Beside
        In the order of `pairs`.

    Raises
    ------
    InvalidParameter
        As `pairs`; for a rival that is no method; and where fewer than four scenes have both
        arrive.
    """
    found = _checked(rows)
    checks.choice("rival", rival, {row["method"]: None for row in found})
    saved = ARRIVED / SPEED
    late = {
        (row["method"], row["scene"]): row["arrival_s"] / (row["bound_s"] - saved) for row in found
    }
    chosen = [pair for pair in pairs(found) if rival in pair[:2]]
    judged = []
    for first, second, _, low, high in chosen:
        name, arrivals = (first, (low, high)) if second == rival else (second, (-high, -low))
        gaps = np.array([late[key] - late[rival, key[1]] for key in late if key[0] == name])
        gaps = gaps[np.isfinite(gaps)]
        if len(gaps) < 4:
            raise InvalidParameter(
                f"rows has {len(gaps)} scenes in which {name} and {rival} arrive"
            )
        level = 1 - 0.05 / len(chosen)
        delay = interval(np.tile(gaps[:, None], 4), studentised=True, level=level)
        judged.append(Beside(name, arrivals, delay, gaps))
    return judged


def _checked(rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows of `compare` as a list, or `InvalidParameter`."""
    remedy = "rows of compare, one or more"
    found: list[Mapping[str, Any]] = checks.instances("rows", rows, Mapping, remedy)  # type: ignore[type-abstract]
    if not found or any(FORM.keys() - row.keys() for row in found):
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give {remedy}")
    return found
