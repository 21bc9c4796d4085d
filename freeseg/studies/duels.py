"""What the rows of rivals say when rivals are taken in pairs, over several sets of questions.

All rivals are asked the same questions, so that what a question does to both of a pair
cancels. Who solves more is settled by the questions that only one of them solves (Q. McNemar,
*Psychometrika* 12, 1947), who is shorter by the lengths of those that both solve; and many
pairs are tested so strictly that all that is said of them holds together (Bonferroni).
"""

import math
from collections.abc import Callable, Iterable, Mapping
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from freeseg import checks
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidParameter, Trapped
from freeseg.studies.rivals import (
    ALIKE,
    Question,
    Rival,
    check_rivals,
    check_rows,
    summarise,
)
from freeseg.studies.statistics import RESAMPLES, share

#: Chance that anything is wrong of what is said of all pairs together.
RISK = 0.05

#: Of more tests together, none would be decided.
MOST_TESTS = 1_000_000

#: Speed (m/s) of BARN's optimal time.
BARN_SPEED = 2.0


class Duels(NamedTuple):
    """Who of some rivals solves what another does not.

    Attributes
    ----------
    names : tuple of str
        The n rivals that fail on any question.
    alone : ndarray of int, shape (n, n)
        How many questions the first (row) solves, and the second (column) does not.
    decided : ndarray of bool, shape (n, n)
        Whether that differs from its opposite by more than chance.
    """

    names: tuple[str, ...]
    alone: np.ndarray
    decided: np.ndarray

    def between(self, one: str, other: str) -> str:
        """What the questions say of two of the rivals, in words.

        Raises
        ------
        InvalidParameter
            For a rival that is none of `names`.
        """
        a, b = (self.names.index(checks.choice("rival", k, self.names)) for k in (one, other))
        decided = "" if self.decided[a, b] else "not "
        return (
            f"{one} alone solves {self.alone[a, b]}, {other} alone {self.alone[b, a]}: "
            f"{decided}more than chance"
        )


def pool(rows: Iterable[Mapping[str, Any]], sets: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Numbers of every rival, over some sets of questions together.

    Parameters
    ----------
    rows : iterable of dict
        From `rivals.compare`, or as stored.
    sets : iterable of str
        Names of sets, such as ``["sparse", "dense"]``.

    Returns
    -------
    dict
        Name of a rival to what `summarise` says of it.

    Raises
    ------
    InvalidParameter
        For what are no such rows, or no sets that have any.
    """
    some = _of_sets(rows, sets)
    # One set, whose questions keep their names apart.
    some = [row | {"question": (row["set"], row["question"]), "set": ""} for row in some]
    return {one["rival"]: one for one in summarise(some)}


def _of_sets(rows: Iterable[Mapping[str, Any]], sets: Iterable[str]) -> list[dict[str, Any]]:
    """The rows of some sets, as dicts."""
    kinds = checks.instances("sets", sets, str, "names of sets")
    found = check_rows(rows)
    some = [dict(row) for row in found if row["set"] in kinds]
    if not some:
        known = sorted({row["set"] for row in found})
        raise InvalidParameter(f"sets is {checks.shown(sets)}; give some of {known}")
    return some


def percent(found: Mapping[str, Any]) -> str:
    """Share of the questions that a rival solves, in per cent, given its entry of `pool`.

    Raises
    ------
    InvalidParameter
        For what is no such entry.
    """
    try:
        return f"{100 * found['solved'] / found['questions']:.1f} %"
    except (KeyError, IndexError, TypeError, ZeroDivisionError) as error:
        raise InvalidParameter(f"found is {checks.shown(found)}; give one of pool's") from error


def span(
    by_set: Mapping[str, Mapping[str, Mapping[str, Any]]],
    rival: str,
    key: str,
    over: str | None = None,
) -> tuple[float, float]:
    """Least and greatest of a rival's numbers over sets, or of their ratio to another's.

    Parameters
    ----------
    by_set : dict
        Name of a set to what `pool` returns for it.
    rival, key : str
        Rival, and which of its numbers, as of `rivals.summarise`.
    over : str, optional
        Rival whose numbers they are divided by.

    Raises
    ------
    InvalidParameter
        For no such sets, or a rival or number that one of them lacks.
    """
    checks.instance("by_set", by_set, Mapping, "a dict of set to what pool returns")  # type: ignore[type-abstract]
    try:
        some = [
            found[rival][key] / (1.0 if over is None else found[over][key])
            for found in by_set.values()
        ]
        return min(some), max(some)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        beside = "" if over is None else f", or none over {checks.shown(over)}"
        raise InvalidParameter(
            f"by_set has no {checks.shown(key)} of {checks.shown(rival)}{beside}; give what pool "
            "returns"
        ) from error


def fastest(found: Mapping[str, Mapping[str, Any]], near: float = 0.0) -> str:
    """Of the rivals that solve all that can be, who takes least time in the median.

    Parameters
    ----------
    found : dict
        From `pool`.
    near : float, optional
        Share of its tracks that have to be within 1 % of the optimum.

    Returns
    -------
    str
        Its name.

    Raises
    ------
    InvalidParameter
        Where there is none, or for what is no such dict or share.
    """
    near = checks.not_negative("near", near)
    return _least(found, "median_ms", lambda one: one["near"] >= near, f"near is {near:g}")


def _least(
    found: Mapping[str, Mapping[str, Any]],
    key: str,
    fits: Callable[[Mapping[str, Any]], bool],
    wanted: str,
) -> str:
    """Name of the rival that solves all that can be, fits, and has the least of a number."""
    checks.instance("found", found, Mapping, "what pool returns")  # type: ignore[type-abstract]
    try:
        fit = {
            name: one[key]
            for name, one in found.items()
            if one["solved"] == one["solvable"] and fits(one)
        }
    except (KeyError, TypeError) as error:
        raise InvalidParameter(f"found is {checks.shown(found)}; give what pool returns") from error
    if not fit:
        raise InvalidParameter(f"{wanted}, and no rival does as well; ask for less")
    return min(fit, key=lambda name: fit[name])


def shortest(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Of the rivals that solve all that can be, and keep R_D, who is least beyond the optimum.

    Parameters
    ----------
    found : dict
        From `pool`.

    Returns
    -------
    str
        Its name: the longest of its tracks is least, relative to the optimum.

    Raises
    ------
    InvalidParameter
        Where there is none, or for what is no such dict.
    """
    return _least(
        found,
        "max_ratio",
        lambda one: one["keeps"] == one["solved"],
        "R_D is to be kept everywhere",
    )


def differs(one: int, other: int, tests: int = 1, risk: float = RISK) -> bool:
    """Whether two counts differ by more than chance, if either was as likely each time.

    Parameters
    ----------
    one, other : int
        Such as questions that only one of two rivals solves, and that only the other does.
    tests : int, optional
        Of how many tests this is one.
    risk : float, optional
        Chance that any of them is wrong where nothing differs.

    Returns
    -------
    bool
        Whether the exact interval of one's share leaves out one half.

    Raises
    ------
    InvalidParameter
        For what are no counts, or no risk between 0 and 1.
    """
    one, other = checks.whole("one", one), checks.whole("other", other)
    tests = checks.whole("tests", tests, 1, most=MOST_TESTS)
    risk = checks.probability("risk", risk)
    if not one + other:
        return False
    found = share(one, one + other, "clopper-pearson", 1 - risk / tests)
    return not found.low <= 0.5 <= found.high


def duel(rows: Iterable[Mapping[str, Any]], sets: Iterable[str], risk: float = RISK) -> Duels:
    """Who solves what another does not, for every two rivals that fail on any question.

    Parameters
    ----------
    rows, sets
        As for `pool`.
    risk : float, optional
        As for `differs`, for all pairs together.

    Returns
    -------
    Duels

    Raises
    ------
    InvalidParameter
        As `pool` and `differs`.
    """
    solved: dict[str, set[Any]] = {}
    questions = set()
    for row in _of_sets(rows, sets):
        question = row["set"], row["question"]
        questions.add(question)
        of = solved.setdefault(row["rival"], set())
        if row["arrives"] and not row["collides"]:
            of.add(question)
    names = tuple(name for name, of in solved.items() if of < questions)
    n = len(names)
    alone = np.array([len(solved[a] - solved[b]) for a in names for b in names], int).reshape(n, n)
    decided = np.zeros((n, n), bool)
    for row, column in np.argwhere(np.triu(np.ones((n, n), bool), 1)):
        counts = int(alone[row, column]), int(alone[column, row])
        decided[row, column] = differs(*counts, n * (n - 1) // 2, risk)
    return Duels(names, alone, decided | decided.T)


def length_ratios(
    rows: Iterable[Mapping[str, Any]], sets: Iterable[str], reference: str, risk: float = RISK
) -> list[dict[str, Any]]:
    """Lengths of all rivals in pairs with one of them, on the questions that both solve.

    Parameters
    ----------
    rows, sets
        As for `pool`.
    reference : str
        Name of the rival that all others are compared with.
    risk : float, optional
        Chance that any of the intervals, or of the decisions, does not hold.

    Returns
    -------
    list of dict
        For each other rival its ``rival``; ``both``, on how many questions; of these it is
        ``shorter`` and ``longer`` on so many, by more than round-off, and ``decided`` is
        whether that is more than chance; and the geometric mean of the ratios, ``mean``, with
        its interval, ``low`` and ``high``, from a bootstrap of the questions. A length is
        taken relative to the optimum that keeps no more than its track does.

    Raises
    ------
    InvalidParameter
        As `pool` and `differs`, or for a rival that solves none of the questions.
    """
    excess: dict[str, dict[Any, float]] = {}
    for row in _of_sets(rows, sets):
        of = excess.setdefault(row["rival"], {})
        if math.isfinite(row["equal_m"]):
            of[row["set"], row["question"]] = row["length_m"] / row["equal_m"]
    best = excess[checks.choice("reference", reference, excess)]
    others = [name for name in excess if name != reference]
    found = []
    for name in others:
        both = [question for question in excess[name] if question in best]
        if not both:
            raise InvalidParameter(f"{reference} and {name} solve no question both; leave it out")
        logs = np.log([excess[name][question] / best[question] for question in both])
        shorter, longer = int((logs < -ALIKE).sum()), int((logs > ALIKE).sum())
        low, high = np.exp(_interval(logs, 1 - risk / len(others)))
        found.append(
            {"rival": name, "both": len(both), "shorter": shorter, "longer": longer}
            | {"decided": differs(shorter, longer, len(others), risk)}
            | {"mean": float(np.exp(logs.mean())), "low": float(low), "high": float(high)}
        )
    return found


def _interval(values: np.ndarray, level: float) -> np.ndarray:
    """Ends of the bootstrap interval of a mean, by percentiles."""
    rng = np.random.default_rng(0)
    means = [rng.choice(values, len(values)).mean() for _ in range(2 * RESAMPLES)]
    return np.quantile(means, [(1 - level) / 2, (1 + level) / 2])


def tracks_of(rivals: Mapping[str, Rival], question: Question) -> dict[str, Any]:
    """What rivals answer to one question: for drawing, not for judging.

    Parameters
    ----------
    rivals : dict
        Name to rival.
    question : Question
        As of `rivals.pose_question`.

    Returns
    -------
    dict
        Name to track. Of a law that was trapped, what it drove; who gives no answer is
        left out.

    Raises
    ------
    InvalidParameter
        For what are no rivals or no question; and what a rival raises but `Trapped`.
    """
    check_rivals(rivals)
    checks.instance("question", question, Question, "what pose_question returns")
    found = {}
    for name, rival in rivals.items():
        try:
            track = rival(*question)
        except Trapped as trapped:
            track = getattr(trapped, "run", None)
        if track is not None:
            found[name] = track
    return found


def load_tracks(
    file: str | PathLike[str] = DATA / "rival_tracks.csv",
) -> dict[tuple[str, Any], dict[str, np.ndarray]]:
    """Stored tracks of rivals from elsewhere, whose packages it takes to find them.

    Parameters
    ----------
    file : path-like, optional
        Written by ``tests/benchmarks/rival_tracks.py``.

    Returns
    -------
    dict
        Case, as of `rivals.pose_question`, to name to points (m), shape (k, 2).

    Raises
    ------
    InvalidData
        For a file that cannot be read.
    """
    columns = {"set": str, "question": str, "rival": str, "x": float, "y": float}
    found: dict[tuple[str, Any], dict[str, Any]] = {}
    for row in read_csv(file, columns):
        question = row["question"]
        case = row["set"], int(question) if question.isdecimal() else question
        found.setdefault(case, {}).setdefault(row["rival"], []).append((row["x"], row["y"]))
    return {
        case: {name: np.array(points) for name, points in tracks.items()}
        for case, tracks in found.items()
    }


def barn_scores(
    rows: Iterable[Mapping[str, Any]], lengths: Mapping[int, float], speed: float = 1.0
) -> dict[str, tuple[float, int]]:
    """Score that BARN would give to each rival's tracks, driven at a constant speed.

    Parameters
    ----------
    rows : iterable of dict
        From `rivals.compare`, or as stored; those of the set ``"barn"`` count.
    lengths : dict
        Number of a world to the length (m) that is called optimal.
    speed : float, optional
        At which the tracks are driven (m/s); turning takes no time.

    Returns
    -------
    dict
        Name to the mean score, and to how many tracks score the most there is.

    Raises
    ------
    InvalidParameter
        For what are no such rows or lengths, a world of which there is no length, or a
        speed that is not positive.

    Notes
    -----
    With the time T of a run and the optimal time T_0, which is that of the optimal length at
    2 m/s, a run that arrives without a collision scores T_0 / clip(T, 2 T_0, 8 T_0), and any
    other nothing: the navigation metric of the BARN Challenge, as its script ``run.py``
    computes it.
    """
    checks.instance("lengths", lengths, Mapping, "a dict of world to length (m)")  # type: ignore[type-abstract]
    speed = checks.positive("speed", speed)
    scores: dict[str, list[float]] = {}
    for row in _of_sets(rows, ["barn"]):
        if row["question"] not in lengths:
            raise InvalidParameter(f"lengths lacks world {row['question']}; give its length (m)")
        best = checks.positive("length", lengths[row["question"]]) / BARN_SPEED
        time = row["length_m"] / speed
        solved = row["arrives"] and not row["collides"]
        found = best / min(max(time, 2 * best), 8 * best) if solved else 0.0
        scores.setdefault(row["rival"], []).append(found)
    return {
        name: (float(np.mean(found)), sum(one > 0.5 - ALIKE for one in found))
        for name, found in scores.items()
    }
