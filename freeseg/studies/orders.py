"""Safety first or length first: what each order of the paper's search computes.

The paper measures all free segments, and then evaluates the endpoints of the safe ones;
of the search that it improves on, [12], it says that it takes the endpoint of the shortest way
first and then measures its segment. Its order, it claims, needs less computation.
`fs.plan` and `fs.length_first_plan` differ in nothing else, so they settle the claim.
"""

from collections.abc import Iterable, Mapping
from itertools import groupby
from os import PathLike
from typing import Any

import numpy as np
import shapely

from freeseg import checks
from freeseg.errors import InvalidParameter
from freeseg.geometry import unit
from freeseg.paper import load_cases, load_table
from freeseg.plan import StepKind, turning_radius
from freeseg.planners import length_first_plan, plan
from freeseg.random_worlds import SIZES
from freeseg.robot import KheperaIV
from freeseg.segments import MARGIN
from freeseg.studies.runner import run
from freeseg.studies.store import COLUMNS
from freeseg.world import Disc, World

#: Widths of segments, in units of D_r + delta: danger ones and safe ones.
DANGER_WIDTHS, SAFE_WIDTHS = (0.1, 0.95), (1.05, 2.0)

#: A row of discs turns by so much at most (rad): no two meet but neighbours.
TURN = 0.5

#: How far before and behind the row a robot starts and arrives, and how far beside (m).
AWAY, ASIDE = 0.5, 0.3

#: Numbers of obstacles, shares of danger segments, and rows of each.
NUMBERS, DANGER_SHARES, ROWS = (5, 10, 20, 50, 100, 200, 500), (0, 0.1, 0.25, 0.5, 0.75, 0.9, 1), 20

#: More obstacles would take minutes.
MOST = 10_000


def row_of_discs(n: int, share: float, seed: int) -> tuple[World, np.ndarray, np.ndarray]:
    """A row of discs in the paper's order, and a query across it.

    Parameters
    ----------
    n : int
        Number of discs, two or more.
    share : float
        Share of the n - 1 segments between neighbours that are danger, from
        0 to 1; rounded to a whole number of segments.
    seed : int
        Equal seeds give equal rows.

    Returns
    -------
    world : World
        Discs of 15 to 60 mm; the segments are danger or safe for a Khepera IV and
        the default margin.
    start, goal : ndarray, shape (2,)
        Free positions (m) on both sides of one of the discs.

    Raises
    ------
    InvalidParameter
        For a number of discs, a share or a seed that is none.
    """
    n = checks.whole("n", n, 2, "a whole number of discs from 2 on")
    if n > MOST:
        raise InvalidParameter(f"n is {checks.shown(n)}; give at most {MOST}")
    part = checks.not_negative("share", share)
    if part > 1:
        raise InvalidParameter(f"share is {checks.shown(share)}; give a part of 1")
    rng = np.random.default_rng([checks.whole("seed", seed), n])
    robot = KheperaIV()
    radii = rng.uniform(*SIZES, n)
    is_danger = rng.permutation(n - 1) < round(part * (n - 1))
    danger, safe = (rng.uniform(*widths, n - 1) for widths in (DANGER_WIDTHS, SAFE_WIDTHS))
    width = np.where(is_danger, danger, safe)
    step = radii[:-1] + radii[1:] + width * (robot.diameter + MARGIN)
    along = step[:, None] * unit(rng.uniform(-TURN, TURN, n - 1))
    centers = np.concatenate([np.zeros((1, 2)), np.cumsum(along, axis=0)])
    world = World([Disc(center, radius) for center, radius in zip(centers, radii, strict=True)])
    while True:
        middle = centers[rng.integers(n)]
        ends = middle + np.column_stack([rng.uniform(-ASIDE, ASIDE, 2), [-AWAY, AWAY]])
        if not len(world.near(shapely.points(ends), turning_radius(robot, MARGIN))[0]):
            return world, ends[0], ends[1]


def row_cases(rows: int = ROWS) -> list[tuple[int, float, int]]:
    """Numbers of discs, shares of danger and seeds of the rows that are compared.

    Parameters
    ----------
    rows : int, optional
        Rows of each number and share.

    Raises
    ------
    InvalidParameter
        For what is no whole number, or more than 10 000.
    """
    rows = checks.whole("rows", rows)
    if rows > MOST:
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give at most {MOST}")
    # Of few segments, two shares may be the same number.
    shares = {n: {round(share * (n - 1)) / (n - 1) for share in DANGER_SHARES} for n in NUMBERS}
    return [(n, share, k) for n in NUMBERS for share in sorted(shares[n]) for k in range(rows)]


def count_operations(case: str | tuple[int, float, int]) -> dict[str, Any]:
    """What both orders compute for one case.

    Parameters
    ----------
    case : str or tuple
        Name of one of the paper's cases, or the arguments of `row_of_discs`.

    Returns
    -------
    dict
        ``name`` of the paper's case, or nothing; ``n`` obstacles; ``share`` of danger segments;
        ``seed``; for each order, ``safety`` and ``length``, the counts of `Effort`
        and the ``distances`` between points that they come to; and ``escaped``, 1
        where the path left a local minimum, the exact search for which is not counted.

    Raises
    ------
    InvalidParameter
        For what is no such case.
    """
    query, name, seed = _query_of(case)
    plans = {"safety": plan(*query), "length": length_first_plan(*query)}
    segments = plans["safety"].segments
    row: dict[str, Any] = {
        "name": name,
        "n": len(query[0]),
        "share": sum(not segment.safe for segment in segments) / max(len(segments), 1),
        "seed": seed,
    }
    for order, found in plans.items():
        for operation in ("segments", "endpoints", "retries", "distances"):
            row[f"{order}_{operation}"] = getattr(found.effort, operation)
    row["escaped"] = int(any(step.kind is StepKind.LOCAL_MINIMUM for step in found.steps))
    return row


def _query_of(
    case: str | tuple[int, float, int],
) -> tuple[tuple[World, np.ndarray, np.ndarray], str, int]:
    """World, start and goal of a case, its name or nothing, and its seed or 0."""
    if isinstance(case, str):
        cases = load_cases()
        found = cases[checks.choice("case", case, tuple(cases))]
        return (load_table(found.table), np.array(found.start), np.array(found.goal)), case, 0
    if not isinstance(case, tuple | list) or len(case) != 3:
        raise InvalidParameter(
            f"case is {checks.shown(case)}; give the name of one of the paper's, or n, share, seed"
        )
    try:
        return row_of_discs(*case), "", case[2]
    except InvalidParameter as error:
        raise InvalidParameter(f"case is {checks.shown(case)}: {error}") from error


def _count_operations(case: str | tuple[int, float, int], _: int) -> dict[str, Any]:
    """As `count_operations`; the seed of a row is the case's, not the runner's."""
    return count_operations(case)


def compare_orders(
    cases: Iterable[str | tuple[int, float, int]],
    jobs: int | None = 1,
    store: str | PathLike[str] | None = None,
) -> list[dict[str, Any]]:
    """What both orders compute for many cases, see `count_operations`.

    Parameters
    ----------
    cases : iterable
        As for `count_operations`: names, `row_cases`, or both.
    jobs, store : optional
        Processes, and where the rows are kept, see `runner.run`.

    Returns
    -------
    list of dict
        A row a case.

    Raises
    ------
    InvalidParameter
        For what are no such cases, or is no number of processes.
    """
    rows = run(_count_operations, cases, store, jobs=jobs, strict=True)
    return [{name: value for name, value in row.items() if name not in COLUMNS} for row in rows]


def judge_orders(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """In how many cases safety first computes fewer distances.

    Parameters
    ----------
    rows : iterable of dict
        From `compare_orders`, or as stored.

    Returns
    -------
    list of dict
        For the paper's cases together, and for rows of discs by ``n`` and ``share`` of danger:
        ``cases``; of these ``searched``, those in which an endpoint was evaluated: not
        where the straight line is free, and not where a dead end leaves none to try,
        for there safety first has measured all segments in vain. Of those
        searched, in how many safety first is ``cheaper``, and in how many the orders are
        ``equal``; ``ratio``, its distances over those of length first, in the
        median, NaN of none; and ``known_cheaper``, in how many it is cheaper once its
        segments have been measured for another query in the same world.

    Raises
    ------
    InvalidParameter
        For what are no such rows.
    """
    found = []
    for (of_paper, n, _), some in groupby(sorted(_checked(rows), key=_group), key=_group):
        cases = list(some)
        searched = [row for row in cases if row["length_endpoints"]]
        safety, length, segments = (
            np.array([row[name] for row in searched])
            for name in ("safety_distances", "length_distances", "safety_segments")
        )
        found.append(
            {
                "set": "paper" if of_paper else "rows",
                "n": n,
                "share": float(np.mean([row["share"] for row in cases])),
                "cases": len(cases),
                "searched": len(searched),
                "cheaper": int((safety < length).sum()),
                "equal": int((safety == length).sum()),
                "ratio": float(np.median(safety / length)) if searched else np.nan,
                "known_cheaper": int((safety - segments < length).sum()),
            }
        )
    return found


def _group(row: Mapping[str, Any]) -> tuple[bool, int, float]:
    """The paper's cases are one group; rows of discs are one by number and share."""
    return (True, row["n"], 0.0) if row["name"] else (False, row["n"], row["share"])


def _checked(rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows of `compare_orders` as a list, or `InvalidParameter`."""
    remedy = "rows of compare_orders, one or more"
    found: list[Mapping[str, Any]] = checks.instances("rows", rows, Mapping, remedy)
    wanted = {"name", "n", "share", "safety_segments", "safety_distances", "length_distances"}
    wanted.add("length_endpoints")
    if not found or any(wanted - row.keys() for row in found):
        raise InvalidParameter(f"rows is {checks.shown(rows)}; give {remedy}")
    return found


def turning_share(rows: Iterable[Mapping[str, Any]]) -> dict[int, float]:
    """Share of danger segments above which safety first computes fewer distances.

    Parameters
    ----------
    rows : iterable of dict
        As for `judge_orders`; of the rows of discs, those that were searched count.

    Returns
    -------
    dict
        Number of discs to the share at which the mean of the difference is
        zero, between the shares that were tried; NaN where it is nowhere.

    Raises
    ------
    InvalidParameter
        For what are no such rows.
    """
    differences: dict[int, dict[float, list[int]]] = {}
    for row in _checked(rows):
        if not row["name"] and row["length_endpoints"]:
            by_share = differences.setdefault(row["n"], {})
            by_share.setdefault(row["share"], []).append(
                row["safety_distances"] - row["length_distances"]
            )
    found = {}
    for n, by_share in sorted(differences.items()):
        shares = sorted(by_share)
        means = np.array([np.mean(by_share[share]) for share in shares])
        turns = np.flatnonzero((means[:-1] > 0) & (means[1:] <= 0))
        found[n] = np.nan
        if len(turns):
            k = turns[0]
            part = means[k] / (means[k] - means[k + 1])
            found[n] = float(shares[k] + part * (shares[k + 1] - shares[k]))
    return found


def turning_interval(
    rows: Iterable[Mapping[str, Any]], seed: int = 0, resamples: int = 300
) -> dict[int, tuple[float, float]]:
    """Interval at 95 % of each `turning_share`, by a bootstrap of the rows.

    Parameters
    ----------
    rows : iterable of dict
        As for `turning_share`.
    seed : int, optional
        Of the resampling; rows of the same number and share of discs replace each other.
    resamples : int, optional
        How many.

    Returns
    -------
    dict
        Number of discs to the ends of the interval; NaN where it turns in no resample.

    Raises
    ------
    InvalidParameter
        For what are no such rows, no seed, or no number of resamples.
    """
    rng = np.random.default_rng(checks.whole("seed", seed))
    resamples = checks.whole("resamples", resamples, 1)
    if resamples > MOST:
        raise InvalidParameter(f"resamples is {resamples}; give at most {MOST}")
    found = _checked(rows)
    groups = [list(some) for _, some in groupby(sorted(found, key=_group), key=_group)]
    shares = []
    for _ in range(resamples):
        drawn = [some[k] for some in groups for k in rng.integers(len(some), size=len(some))]
        shares.append(turning_share(drawn))
    ends = {}
    for n in turning_share(found):
        values = np.array([one[n] for one in shares if np.isfinite(one.get(n, np.nan))])
        low, high = np.quantile(values, (0.025, 0.975)) if len(values) else (np.nan, np.nan)
        ends[n] = float(low), float(high)
    return ends
