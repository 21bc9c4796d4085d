"""Evidence of the ledger: what is stored or driven again, and the numbers that it comes to.

Each source has two halves. `load` fetches rows, arrays or runs; `digest` reduces them to the
few numbers that rules of `ledger_rules` judge by. A test changes what is loaded, and sees which
verdicts change.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import shapely

from freeseg.data import DATA, read_csv
from freeseg.errors import NoPath, Trapped
from freeseg.geometry import wrap_angle
from freeseg.paper import load_cases, load_table
from freeseg.plan import StepKind, turning_radius
from freeseg.planners import literal_plan, plan, shortest_path, widest_segment_plan
from freeseg.reference import make_reference
from freeseg.robot import KheperaIV
from freeseg.segments import MARGIN, free_segments
from freeseg.simulate import simulate
from freeseg.studies import (
    comparing,
    crossings,
    ledger_drives,
    moving,
    orders,
    rivals,
    statistics,
    stress,
    tracking,
)
from freeseg.studies.ledger_equations import check_equations
from freeseg.studies.sizes import OPTIMAL, by_group
from freeseg.studies.splitting import Tail, lowest_level
from freeseg.trackers import SlidingMode

#: The paper's law, as `comparing` calls it.
OUR_LAW = "sliding mode"

#: Ways in which the ten laws are judged here: told the same, as usual, from far, and with three
#: times all that disturbs.
USUAL = comparing.Cell("observed", "nominal")
FAR = comparing.Cell("observed", "far starts")
HARSH = comparing.Cell("observed", "disturbed", told=3.0)

#: What has not settled by then counts as this (s).
LATEST = 8.0

#: Starts beside the reference, ahead and to the left (m), from which a robot is to come back.
NEAR_START, FAR_REACH, FAR_STEPS = 0.01, 0.6, 41

#: How often contact is accepted: in one of so many runs.
ONE_IN = 1000

#: How much stronger than usual a cause of failures is, that a robust law stands.
STRONGER = 4.0

#: Radii R_D (m) that the literal reading is tried with, besides R_r + delta / 2, as in notebook 07.
LITERAL_RADII = np.arange(75, 146, 10) / 1000

#: From then on (s), a robot that began nearby is to follow closely.
SETTLED_S = 5.0

#: A robot is back where its error is below this in the end (m).
BACK = 0.01

#: Ends of the time axes of Figs 18 and 19 as printed (s): the run of Fig. 15(a), and of 16(b).
FIG_18_ENDS, FIG_19_ENDS = (120.0, 60.0), (15e4, 3e5)

#: Axes of Figs 18 and 19: errors x_e, y_e and alpha_e, without a unit; wheels and tick step (m/s).
ERROR_AXES = {"15a": (0.5, 0.5, 2.0), "16b": (0.5, 5.0, 5.0)}
WHEEL_AXES = {"15a": (0.2, 0.05), "16b": (0.4, 0.1)}

#: Units that the axes of x_e and y_e may have (m); alpha_e in rad.
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}


class Source(NamedTuple):
    """Where evidence comes from.

    Attributes
    ----------
    load : callable
        ``load()`` fetches it.
    digest : callable
        ``digest(loaded)`` is the dict of numbers that rules are given.
    where : str
        File of ``data/``, or what is computed.
    files : tuple of str
        Of ``data/``, all that it is read or computed from.
    """

    load: Callable[[], Any]
    digest: Callable[[Any], dict[str, Any]]
    where: str
    files: tuple[str, ...] = ()


#: What plans of the paper's cases are made from; and drives with tuned gains, on random courses.
PAPER_FILES = ("cases.csv", "khepera4.csv", "obstacles.csv", "tables.csv")
TUNED_FILES = ("gains.csv", "khepera4.csv")


def _stored(
    name: str, load: Callable[[], Any], digest: Callable[[Any], dict[str, Any]], *more: str
) -> Source:
    """A source that is a file of ``data/``, and what else is read for it."""
    return Source(load, digest, name, (name, *more))


def _csv(name: str, **columns: type) -> Callable[[], list[dict[str, Any]]]:
    return lambda: read_csv(DATA / name, columns)


def _tables(rows: list[dict[str, Any]]) -> dict[str, Any]:
    centers: dict[int, list[tuple[float, float]]] = {}
    for row in rows:
        centers.setdefault(row["table"], []).append((row["x_mm"], row["y_mm"]))
    found = {table: np.array(points) for table, points in centers.items()}
    gaps = {table: np.hypot(*np.diff(points, axis=0).T) for table, points in found.items()}
    return {
        "obstacles": [len(points) for points in found.values()],
        # By so much can equal discs make Table 1's segments safe and Table 5's danger (mm).
        "equal_discs_mm": float(gaps[1].min() - gaps[5].max()) / 2,
    }


def _cases(rows: list[dict[str, Any]]) -> dict[str, Any]:
    goals: dict[int, set[tuple[float, float]]] = {}
    starts: dict[int, set[tuple[float, float]]] = {}
    for row in rows:
        goals.setdefault(row["figure"], set()).add((row["goal_x_mm"], row["goal_y_mm"]))
        starts.setdefault(row["figure"], set()).add((row["start_x_mm"], row["start_y_mm"]))
    return {
        "cases": len(rows),
        "goals": max(map(len, goals.values())),
        "starts": min(map(len, starts.values())),
    }


def _measure_segments() -> dict[int, list[float]]:
    return {k: [one.length for one in free_segments(load_table(k))] for k in range(1, 6)}


def _segments(lengths: dict[int, list[float]]) -> dict[str, Any]:
    diameter = KheperaIV().diameter
    safe = {k: sum(one >= diameter + MARGIN for one in some) for k, some in lengths.items()}
    every = [one for some in lengths.values() for one in some]
    return {
        "safe": safe,
        "danger": {k: len(some) - safe[k] for k, some in lengths.items()},
        "counts": sorted({len(some) for some in lengths.values()}),
        "between": sum(diameter < one < diameter + MARGIN for one in every),
        "measured": len(every),
        "limits_mm": (1000 * diameter, 1000 * (diameter + MARGIN)),
    }


def _ends(values: Any) -> tuple[float, float, float]:
    """Least, median and largest."""
    return tuple(float(one) for one in np.quantile(np.asarray(values, float), (0, 0.5, 1)))  # type: ignore[return-value]


def _sizes(rows: list[dict[str, Any]]) -> dict[str, Any]:
    keys = ("solved", "optimal", "greedy", "greedy_optimal", "worst_ratio", "literal", "possible")
    found: dict[str, Any] = {key: _ends([row[key] for row in rows]) for key in keys}
    found["sets"] = len(rows)
    found["told"] = sum(row["as_told"] for row in rows)
    found["greedy_share"] = _ends([row["greedy_optimal"] / max(row["greedy"], 1) for row in rows])
    return found


def _plan_cases() -> list[dict[str, Any]]:
    """Each of the 16 cases planned, beside its optimum and the other reading of "safest"."""
    rows = []
    for name, case in load_cases().items():
        query = load_table(case.table), case.start, case.goal
        ours, best = plan(*query), shortest_path(*query)
        pieces = ours.path.pieces
        bends = [piece.curvature for piece in pieces]
        corners = [
            wrap_angle(after.at(0.0)[2] - before.at(before.length)[2])
            for before, after in pairwise(pieces)
        ]
        try:
            widest = widest_segment_plan(*query).path.length
        except (NoPath, Trapped):
            widest = np.inf
        rows.append(
            {
                "name": name,
                "clearance": ours.path.clearance(ours.world),
                "length": ours.path.length,
                "optimum": best.path.length,
                "widest": widest,
                "straight": float(np.hypot(*(np.asarray(case.goal) - case.start))),
                "kinds": [str(step.kind) for step in ours.steps],
                "group": by_group(ours),
                "kept": ours.turning_radius,
                "corner": float(np.abs(corners).max(initial=0)),
                "jump": float(np.abs(np.diff(bends)).max(initial=0)),
            }
        )
    return rows


def _planned(rows: list[dict[str, Any]]) -> dict[str, Any]:
    radius = KheperaIV().radius
    safe = [row["clearance"] >= radius for row in rows]
    kinds = [row["kinds"] for row in rows]
    far = [row for row in rows if row["name"] in ("16c", "16d")]

    def solved_after(kind: StepKind) -> tuple[int, int]:
        with_kind = [ok for ok, steps in zip(safe, kinds, strict=True) if str(kind) in steps]
        return sum(with_kind), len(with_kind)

    return {
        "cases": len(rows),
        "safe": sum(safe),
        "clearance_mm": 1000 * min(row["clearance"] for row in rows),
        "radius_mm": 1000 * radius,
        "shortest": sum(row["length"] <= OPTIMAL * row["optimum"] for row in rows),
        "case_1": solved_after(StepKind.CASE_1),
        "case_2": solved_after(StepKind.CASE_2),
        "dropped": sum(
            bool({str(StepKind.NEEDLESS_TURN), str(StepKind.LOCAL_MINIMUM)} & set(steps))
            for steps in kinds
        ),
        "repaired": sum(len(steps) > 2 for steps in kinds),
        "group": [row["group"] for row in far],
        "groups": sum(row["group"] for row in rows),
        "passes_mm": [1000 * row["clearance"] for row in far],
        "kept_mm": 1000 * max(row["kept"] for row in far),
        "corner": max(row["corner"] for row in rows),
        "jump_per_m": max(row["jump"] for row in rows),
        "longer": [row["length"] / row["straight"] - 1 for row in far],
        "reads_alike": sum(abs(row["widest"] / row["length"] - 1) < 1e-6 for row in rows),
    }


def _widen_circles() -> list[dict[str, Any]]:
    """Each case by the literal reading, for R_r + delta / 2 and for larger R_D."""
    rows = []
    for radius in (turning_radius(KheperaIV(), MARGIN), *LITERAL_RADII):
        for name, case in load_cases().items():
            world = load_table(case.table)
            safe = any(one.safe for one in free_segments(world))
            try:
                literal_plan(world, case.start, case.goal, turning_radius=radius)
                solved = True
            except Trapped:
                solved = False
            rows.append({"radius": float(radius), "name": name, "safe": safe, "solved": solved})
    return rows


def _radii(rows: list[dict[str, Any]]) -> dict[str, Any]:
    solved: dict[float, int] = {}
    for row in rows:
        solved[row["radius"]] = solved.get(row["radius"], 0) + row["solved"]
    return {
        "cases": len({row["name"] for row in rows}),
        "with_gaps": len({row["name"] for row in rows if row["safe"]}),
        "solved": (min(solved.values()), max(solved.values())),
        "least_mm": 1000 * min(solved),
        "most_mm": 1000 * max(solved),
        "best_mm": 1000 * max(solved, key=lambda radius: solved[radius]),
    }


def _random_worlds(rows: list[dict[str, Any]]) -> dict[str, Any]:
    most = max(row["worlds"] for row in rows)
    by_rule = {row["rule"]: row for row in rows if row["worlds"] == most}
    words, ours = by_rule["literal"], by_rule["completed"]
    blocked = words["solvable"] - words["straight"]
    return {
        "solvable": ours["solvable"],
        "solved": ours["solved"],
        "optimal": ours["optimal"],
        "max_ratio": ours["max_ratio"],
        "words": statistics.share(words["solved"] - words["straight"], blocked),
    }


def _orders(rows: list[dict[str, Any]]) -> dict[str, Any]:
    of_paper = next(row for row in orders.judge_orders(rows) if row["set"] == "paper")
    turns = orders.turning_share(rows)
    ratios = [
        row["safety_distances"] / row["length_distances"]
        for row in rows
        if row["name"] and row["length_endpoints"]
    ]
    return of_paper | {"turns": tuple(turns.values()), "ratios": _ends(ratios)}


def _load_orders() -> list[dict[str, Any]]:
    columns = ("n", "seed", "escaped", *orders_columns("safety"), *orders_columns("length"))
    rows = read_csv(DATA / "orders.csv", dict.fromkeys(columns, int) | {"share": float})
    # A name is missing by design, which a column of text may not be: the paper's cases come first.
    names = list(load_cases())
    return [row | {"name": names[k] if k < len(names) else ""} for k, row in enumerate(rows)]


def orders_columns(order: str) -> list[str]:
    """Columns of ``data/orders.csv`` that count what an order of the search computes.

    Parameters
    ----------
    order : str
        ``"safety"`` or ``"length"``.
    """
    return [f"{order}_{one}" for one in ("segments", "endpoints", "retries", "distances")]


def _rivals(rows: list[dict[str, Any]]) -> dict[str, Any]:
    found = {(row["set"], row["rival"]): row for row in rivals.summarise(rows)}
    sets = list(dict.fromkeys(row["set"] for row in rows))
    ours = [found[kind, "paper, completed"] for kind in sets]
    exact = [found[kind, "exact"] for kind in sets]
    safety, length = (
        np.array([row["ms"] for row in rows if row["rival"] == rival])
        for rival in ("paper, completed", "paper, length first")
    )
    paper = np.array([row["set"] == "paper" for row in rows if row["rival"] == "paper, completed"])
    return {
        "questions": sum(row["questions"] for row in ours),
        "solved": sum(row["solved"] for row in ours),
        "near": min(row["near"] for row in ours),
        "max_ratio": max(row["max_ratio"] for row in ours),
        "median_ms": max(row["median_ms"] for row in ours),
        "slower": _ends(
            [a["median_ms"] / b["median_ms"] for a, b in zip(ours, exact, strict=True)]
        ),
        "safety_first": _ends(safety[paper] / length[paper]),
        "middle_half": tuple(np.quantile(safety[paper] / length[paper], (0.25, 0.75)).tolist()),
        "everywhere": float(np.median(safety / length)),
        "timed": int(paper.sum()),
    }


def _comparison(runs: Mapping[comparing.Cell, Mapping[str, Any]]) -> dict[str, Any]:
    settling = {law: np.minimum(t, LATEST) for law, t in runs[FAR]["settling_time_s"].items()}
    values = {
        "usual": runs[USUAL]["position_rms_m"],
        "harsh": runs[HARSH]["position_rms_m"],
        "far": runs[FAR]["position_rms_m"],
        "settling": settling,
    }
    ours = runs[HARSH]["hit"][OUR_LAW]
    found: dict[str, Any] = {
        name: tuple(comparing.against(one, OUR_LAW).values()) for name, one in values.items()
    }
    settled = settling[OUR_LAW] < LATEST
    found["rms_mm"] = {
        name: _mean(1000 * values[name][OUR_LAW]) for name in ("usual", "harsh", "far")
    }
    found["hits"] = statistics.share(int(ours.sum()), ours.size)
    found["settled"] = statistics.share(int(settled.sum()), settled.size)
    found["settles_in_s"] = _mean(settling[OUR_LAW])
    return found


def _mean(values: np.ndarray) -> tuple[float, float, float]:
    """Mean, and its interval's ends."""
    return float(values.mean()), *statistics.interval(values, studentised=True)


def _stress(stored: stress.Stress) -> dict[str, Any]:
    """Shares of runs that fail, at the usual disturbance and with one cause made stronger."""

    def shares(runs: np.ndarray) -> statistics.Share:
        return statistics.share(int(runs.sum()), len(runs))

    strong, strongest = stress.STRENGTHS.index(STRONGER), len(stress.STRENGTHS) - 1
    ours = stored.counts["SlidingMode"]
    tails = [tail for (law, _), tail in stored.tails.items() if law == "SlidingMode"]
    # The level at which half of our margin is used up, of those that were asked for.
    place = int(np.argmin(np.abs(tails[0].levels - MARGIN / 2)))
    ends = [_used_up(tail._replace(share=one)) for tail in tails for one in (tail.low, tail.high)]
    return {
        "runs": len(ours["nominal"].failed),
        "failed": shares(ours["nominal"].failed),
        "contact": shares(ours["nominal"].contact),
        "stronger": {cause: shares(ours[cause].failed[:, strong]) for cause in stress.CAUSES},
        "noisy": {
            law: shares(stored.counts[law]["noise"].failed[:, strongest])
            for law in ("SlidingMode", "Pid")
        },
        "noise_times": stress.STRENGTHS[strongest],
        "courses": len(tails),
        "margin_mm": (2000 * min(ends), 2000 * max(ends)),
        "widest_mm": 2000 * float(tails[0].levels[-1]),
        "our_margin_mm": 1000 * MARGIN,
        "touched": (
            min(float(tail.low[place]) for tail in tails),
            max(float(tail.high[place]) for tail in tails),
        ),
    }


def _used_up(tail: Tail) -> float:
    """Shortfall (m) that one run in `ONE_IN` exceeds; infinite where even the largest is common."""
    found = lowest_level(tail, 1 / ONE_IN)
    if np.isnan(found):
        return np.inf if tail.share[-1] > 1 / ONE_IN else float(tail.levels[0])
    return found


def _movers(rows: list[dict[str, Any]]) -> dict[str, Any]:
    by_method = {row["method"]: row for row in moving.summarise(rows, by=())}
    anew, blind = by_method[moving.ANEW], by_method[moving.BLIND]
    beside = {one.method: one.arrivals for one in moving.beside(rows)}
    return {
        "scenes": blind["scenes"] - blind["impossible"],
        "movers": _ends([row["movers"] for row in rows]),
        "speeds": _ends([row["ratio"] for row in rows]),
        "blind_hit": blind["collided"],
        "anew_hit": anew["collided"],
        "anew_arrives": anew["arrived"],
        "anew_later": tuple(anew[f"delay{end}"] for end in ("", "_low", "_high")),
        # How many fewer arrivals without a look at movers: ends of the simultaneous interval.
        "fewer": beside[moving.BLIND],
    }


def _crossings(rows: list[dict[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, kind in (("proved", True), ("unproved", False)):
        some = [row for row in rows if bool(row["proved"]) == kind]
        judged = crossings.judge_rivals(some, crossings.RIVAL_NAMES)
        found[name] = judged["earlier"], judged["answers"]
    return found


def _steps(rows: list[dict[str, Any]]) -> dict[str, Any]:
    times = {row["tracker"]: row["median_us"] for row in rows}
    # An optimisation in each step is no measure of what is heavy.
    others = [name for name in times if name not in ("Fuzzy", *tracking.SINGLE)]
    fast, slow = min(others, key=times.__getitem__), max(others, key=times.__getitem__)
    return {
        "fuzzy": (times["Fuzzy"] / times[slow], times["Fuzzy"] / times[fast]),
        "beside": (comparing.LAWS[fast], comparing.LAWS[slow]),
        "sliding": times["Fuzzy"] / times["SlidingMode"],
        "fuzzy_us": times["Fuzzy"],
        "fuzzy_slow_us": next(row["p99_us"] for row in rows if row["tracker"] == "Fuzzy"),
    }


def _fits(rows: list[dict[str, Any]], case: str, unit: float) -> int:
    """How many stored robots would give Figs 17 to 19 with errors in a unit (notebook A2)."""
    errors, ends = ("x", "y", "turn"), ("x_end", "y_end", "turn_end")
    limit = np.array(ERROR_AXES[case]) * (unit, unit, 1)
    axis, tick = WHEEL_AXES[case]
    count = 0
    for row in rows:
        if (row["setting"], row["case"]) != ("base", case):
            continue
        seen, last = (np.array([row[key] for key in keys]) for keys in (errors, ends))
        count += bool(
            ((seen <= limit) & (seen > 0.1 * limit) & (last <= 0.05 * limit)).all()
            and axis - tick < row["fastest"] <= axis
            and -axis <= row["slowest"] < tick - axis
            and row["distance"] < 0.01
            and row["change"] <= 20 * axis
        )
    return count


def _figures(rows: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "units": [
            name
            for name, unit in UNITS.items()
            if all(_fits(rows, case, unit) for case in ERROR_AXES)
        ]
    }


def _drive() -> dict[str, Any]:
    """Errors in the end (m), from a start nearby and from many far off; the gap to obstacles."""
    reach = np.linspace(-FAR_REACH, FAR_REACH, FAR_STEPS)
    ahead, left = (grid.ravel() for grid in np.meshgrid(reach, reach))
    found: dict[str, Any] = {}
    for name in ERROR_AXES:
        case = load_cases()[name]
        ours = plan(load_table(case.table), case.start, case.goal)
        reference = make_reference(ours, speed=0.1, smoothing=0.03)
        near: Any = simulate(SlidingMode(), reference, initial_offset=(-NEAR_START, NEAR_START, 0))
        track = shapely.LineString(near.pose[:2].T)
        far: Any = simulate(SlidingMode(), reference, initial_offset=(ahead, left, 0 * ahead))
        found[name] = {
            "near": np.stack([near.t, np.hypot(*near.error[:2])]),
            "gap": float(np.min(ours.world.distances(track)) - KheperaIV().radius),
            "far_ends": np.hypot(*far.error[:2, :, -1]),
        }
    return found


def _driven(runs: dict[str, Any]) -> dict[str, Any]:
    far = [run["far_ends"] for run in runs.values()]
    near = [run["near"] for run in runs.values()]
    return {
        "near_mm": 1000 * max(error[-1] for _, error in near),
        "begun_mm": 1000 * max(error[0] for _, error in near),
        "worst_mm": 1000 * max(error.max() for _, error in near),
        "later_mm": 1000 * max(error[t >= SETTLED_S].max() for t, error in near),
        "gap_mm": 1000 * min(run["gap"] for run in runs.values()),
        "far": [float((ends < BACK).mean()) for ends in far],
        "starts": len(far[0]),
    }


def _sensors(found: dict[str, dict[str, np.ndarray]]) -> dict[str, Any]:
    def first(errors: np.ndarray) -> float:
        """The factor from which an error of 1 mm does not fade; infinite where there is none."""
        return float(min(ledger_drives.TOO_MUCH[errors > 1e-3], default=np.inf))

    return {
        "growth": {name: float(noisy / usual) for name, (usual, noisy) in found["noise"].items()},
        "from": {name: first(errors) for name, errors in found["gain"].items()},
    }


def _chatter(found: dict[str, dict[Any, Any]]) -> dict[str, Any]:
    rough, swings = found["rough"], {key: np.degrees(one) for key, one in found["swing"].items()}
    (short, none), (_, delay), (long, _), _ = ledger_drives.LATENESS
    return {
        "sat": float(rough["sat", none].mean()),
        "sign": float(rough["sign", none].mean()),
        "runs": len(rough["sat", none]),
        "hold_ms": (1000 * short, 1000 * long),
        "delay_ms": 1000 * delay,
        "sign_deg": (swings["sign", short, none], swings["sign", short, delay]),
        "held_deg": swings["sign", long, none],
        "sat_deg": max(one for (name, *_), one in swings.items() if name == "sat"),
    }


def _remains(found: dict[str, dict[str, np.ndarray]]) -> dict[str, Any]:
    disturbed = 1000 * np.stack([one["disturbed"] for one in found.values()])
    return {
        "laws": len(found),
        "runs": disturbed.size,
        "disturbed_mm": (float(disturbed.min()), float(disturbed.max())),
        "calm_mm": 1000 * min(float(one["calm"].mean()) for one in found.values()),
    }


def _axes(ends: dict[str, tuple[float, float]]) -> dict[str, Any]:
    ratios = [b / a for a, b in zip(ends["Fig. 18"], ends["Fig. 19"], strict=True)]
    return {"ratios": ratios, "hours": [one / 3600 for one in ends["Fig. 19"]]}


#: All evidence, by the name that ``data/claims.csv`` gives it.
SOURCES: dict[str, Source] = {
    "tables": _stored(
        "tables.csv", _csv("tables.csv", table=int, obstacle=int, x_mm=float, y_mm=float), _tables
    ),
    "cases": _stored(
        "cases.csv",
        _csv(
            "cases.csv",
            figure=int,
            start_x_mm=float,
            start_y_mm=float,
            goal_x_mm=float,
            goal_y_mm=float,
        ),
        _cases,
    ),
    "segments": Source(
        _measure_segments,
        _segments,
        "free_segments, Tables 1 to 5",
        ("khepera4.csv", "obstacles.csv", "tables.csv"),
    ),
    "sizes": _stored(
        "sizes.csv",
        _csv(
            "sizes.csv",
            worst_ratio=float,
            **dict.fromkeys(
                (
                    "solved",
                    "greedy",
                    "optimal",
                    "greedy_optimal",
                    "literal",
                    "possible",
                    "as_told",
                ),
                int,
            ),
        ),
        _sizes,
    ),
    "radii": Source(_widen_circles, _radii, "literal_plan, several R_D", PAPER_FILES),
    "planned": Source(_plan_cases, _planned, "plan, 16 cases", PAPER_FILES),
    "random_worlds": _stored(
        "random_worlds.csv",
        _csv(
            "random_worlds.csv",
            rule=str,
            optimal=float,
            max_ratio=float,
            **dict.fromkeys(("worlds", "solvable", "straight", "solved"), int),
        ),
        _random_worlds,
    ),
    "orders": _stored("orders.csv", _load_orders, _orders),
    "rivals": _stored("rivals.npz", rivals.load_rivals, _rivals),
    "comparison": _stored("comparison.npz", comparing.load_comparison, _comparison),
    "stress": _stored("stress.npz", stress.load_stress, _stress),
    "movers": _stored("movers.npz", moving.load_drives, _movers),
    "crossings": _stored("movers_optimal.csv", crossings.load_crossings, _crossings),
    "tracker_steps": _stored(
        "tracker_steps.csv",
        _csv("tracker_steps.csv", tracker=str, median_us=float, p99_us=float),
        _steps,
    ),
    "figures": _stored(
        "figures.csv",
        _csv(
            "figures.csv",
            setting=str,
            case=str,
            **dict.fromkeys(
                (
                    "distance",
                    "x",
                    "y",
                    "turn",
                    "x_end",
                    "y_end",
                    "turn_end",
                    "fastest",
                    "slowest",
                    "change",
                ),
                float,
            ),
        ),
        _figures,
    ),
    "equations": Source(
        check_equations, dict, "equations (1) to (13), in random states", PAPER_FILES
    ),
    "driven": Source(_drive, _driven, "simulate, 15(a) and 16(b)", PAPER_FILES),
    "sensors": Source(
        ledger_drives.mislead, _sensors, "simulate, sensors that mislead", ("khepera4.csv",)
    ),
    "chatter": Source(
        lambda: {"rough": ledger_drives.switch(), "swing": ledger_drives.swing()},
        _chatter,
        "tracking.evaluate and simulate, sat and sign",
        TUNED_FILES,
    ),
    "remains": Source(
        ledger_drives.leave_rest, _remains, "tracking.evaluate, begun without error", TUNED_FILES
    ),
    "axes": Source(
        lambda: {"Fig. 18": FIG_18_ENDS, "Fig. 19": FIG_19_ENDS}, _axes, "printed on Figs 18, 19"
    ),
}
