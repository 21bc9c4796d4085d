"""Rules of the ledger: from evidence to a verdict on a sentence of the paper.

A rule is a function of the digests that a row of ``data/claims.csv`` names, in that order, and of
nothing else. Its thresholds stand in it: whoever disagrees with a verdict finds what to argue with.
"""

import math
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from freeseg.robot import KheperaIV
from freeseg.studies.comparing import NO_DIFFERENCE
from freeseg.studies.courses import WIDE_MARGIN
from freeseg.studies.ledger_equations import STATES
from freeseg.studies.ledger_evidence import FAR, FAR_REACH, LATEST, NEAR_START, ONE_IN, STRONGER
from freeseg.studies.moving import TICK
from freeseg.studies.statistics import (
    EQUIVALENT,
    LARGER,
    SMALLER,
    UNDECIDED,
    Share,
    share,
    verdict,
)
from freeseg.studies.tracking import REGIMES

#: An equation is reproduced where the deviation is below this, in SI units.
EQUAL = 1e-6

#: "Rapidly", "slow": a command is held for 50 ms, and twice as long is slower.
HELD_MS, MUCH_SLOWER = 50.0, 2.0

#: A robot that is this near to its timetable follows it (mm): a tenth of its diameter.
FOLLOWS_MM = 100 * KheperaIV().diameter

#: A larger share of runs that fail, or touch an obstacle, is too many.
TOO_MANY = 0.05

#: The difference of settling times that counts as none (s).
NO_TIME = 0.1

#: How far off the reference the runs from far off begin, at most.
FAR_START = "up to {:.0f} mm and {:.0f}° off".format(
    *np.multiply(REGIMES[FAR.regime].offset, (1000, np.degrees(1)))
)


class Outcome(StrEnum):
    """What can come of judging a sentence."""

    HOLDS = "holds"
    ASSUMED = "holds under a named assumption"
    PART = "holds in part"
    FAILS = "does not hold"
    OPEN = "cannot be decided from the text"


class Verdict(NamedTuple):
    """What evidence says of a sentence.

    Attributes
    ----------
    outcome : Outcome
        The verdict.
    effect : str
        How much, with its interval or range.
    reason : str
        Why this verdict; the assumption, where it holds under one.
    """

    outcome: Outcome
    effect: str
    reason: str


#: Rule by name.
CLAIM_RULES: dict[str, Callable[..., Verdict]] = {}


def _rule(function: Callable[..., Verdict]) -> Callable[..., Verdict]:
    CLAIM_RULES[function.__name__] = function
    return function


def _span(ends: tuple[float, float, float], digits: int = 4) -> str:
    """Range and median in words."""
    low, middle, high = ends
    if low == high:
        return f"{low:.{digits}g}"
    return f"{low:.{digits}g} to {high:.{digits}g} (median {middle:.{digits}g})"


def _percent(found: Share) -> str:
    """A share with its 95 % interval."""
    return f"{100 * found.share:.1f} % [{100 * found.low:.1f}, {100 * found.high:.1f}]"


def _estimate(found: tuple[float, float, float], unit: str) -> str:
    """A mean with its 95 % interval."""
    return "{:.2f} [{:.2f}, {:.2f}]".format(*found) + f" {unit}"


def _equations(numbers: tuple[str, ...], other: str, found: dict[str, float]) -> Verdict:
    worst = max(found[number] for number in numbers)
    if worst <= EQUAL:
        # Not the number itself: round-off differs from one machine to another.
        effect = f"deviates by {EQUAL:g} or less (SI units) from {other}"
        return Verdict(Outcome.HOLDS, effect, "two independent computations agree")
    effect = f"deviates by up to {worst:.2g} (SI units) from {other}"
    return Verdict(Outcome.FAILS, effect, "two independent computations differ")


#: Rules that ask only whether equations agree with an independent computation, and with which.
AGREEING = {
    "kinematics": (("1",), "a numerical integration of random motions"),
    "lengths": (("2",), "centre distances less radii, for the segments of Tables 1 to 5"),
    "detours": (("5",), "two legs added by hand, for each candidate of the first turn of 15(a)"),
    "straight": (("straight",), "Pythagoras, where the one obstacle is far off"),
    "error_frame": (("7",), f"sines and cosines written out, in {STATES} random states"),
    "wheels": (("8",), "right and left speeds written out, for random commands"),
    "control_law": (("12", "13"), f"difference quotients, in up to {STATES} random states"),
}
CLAIM_RULES |= {name: partial(_equations, *how) for name, how in AGREEING.items()}


@_rule
def lyapunov(found: dict[str, float]) -> Verdict:
    """(9), on the first surface and off it."""
    on, off = found["9"], found["9 off"]
    effect = (
        f"the rate of V = y_e²/2 is at most {on:.1g} m²/s where x_e = 0, but up to {off:.2g} m²/s "
        f"elsewhere, in {STATES} random states (the paper says: never above 0)"
    )
    if on > 0:
        return Verdict(Outcome.FAILS, effect, "|y_e| may grow even on the surface")
    if off > 0:
        reason = "assumes x_e = 0: off the first surface |y_e| may grow"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.HOLDS, effect, "the rate is nowhere positive")


@_rule
def surfaces(found: dict[str, float]) -> Verdict:
    """(10): the sum of an angle and of the arctangent of a number with a unit."""
    gap = found["unit"]
    effect = (
        f"in the same state, the turn rate commanded in mm differs by up to {gap:.2g} rad/s from "
        f"that in m ({STATES} random states; it should not differ)"
    )
    if gap <= EQUAL:
        return Verdict(Outcome.HOLDS, effect, "the law does not depend on the unit of length")
    reason = "V_r y_e has a unit; assumes a scale of length, which the paper does not give"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def reaching(found: dict[str, float]) -> Verdict:
    """(11), everywhere or not."""
    none = share(round(STATES * found["singular"]), STATES)
    effect = (
        f"in {_percent(none)} of {STATES} random states within ±0.2 m of the reference, no command "
        "makes it"
    )
    if none.share == 0:
        return Verdict(Outcome.HOLDS, effect, "the denominator of (12) stays positive")
    reason = "solved for w, (12) has a denominator that vanishes behind the reference"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def seven_obstacles(tables: dict[str, Any]) -> Verdict:
    """Each table has seven."""
    counts = tables["obstacles"]
    effect = f"{', '.join(map(str, counts))} obstacles in the {len(counts)} tables"
    if set(counts) == {7}:
        return Verdict(Outcome.HOLDS, effect, "counted in Tables 1 to 5")
    return Verdict(Outcome.FAILS, effect, "a table has another number")


@_rule
def fixed_target(cases: dict[str, Any]) -> Verdict:
    """One goal a figure, and two starts."""
    effect = (
        f"{cases['goals']} goal and {cases['starts']} starts in each figure, of "
        f"{cases['cases']} panels in all"
    )
    if cases["goals"] == 1 and cases["starts"] > 1:
        return Verdict(Outcome.HOLDS, effect, "counted in the captions of Figs 13 to 16")
    return Verdict(Outcome.FAILS, effect, "a figure has several goals, or one start")


def _as_captioned(true: bool, effect: str) -> Verdict:
    if true:
        reason = "assumes sizes of our own, chosen to make the captions true; none are published"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "not so with our sizes")


@_rule
def all_safe(segments: dict[str, Any], tables: dict[str, Any]) -> Verdict:
    """Table 1, and whether equal obstacles would do for it and Table 5."""
    count, equal = segments["safe"][1], tables["equal_discs_mm"]
    effect = (
        f"{count} of 6 segments of Table 1 are safe; no one size of disc makes these safe and all "
        f"of Table 5 danger, it falls short by {-equal:.1f} mm of radius"
    )
    if count == 6 and equal > 0:
        return Verdict(Outcome.HOLDS, f"{count} of 6 segments", "equal discs of some size will do")
    return _as_captioned(count == 6, effect)


@_rule
def both_kinds(segments: dict[str, Any]) -> Verdict:
    """Tables 2 to 4."""
    safe, danger = (segments[kind] for kind in ("safe", "danger"))
    effect = "; ".join(f"Table {k}: {safe[k]} safe, {danger[k]} danger" for k in (2, 3, 4))
    return _as_captioned(all(safe[k] and danger[k] for k in (2, 3, 4)), effect)


@_rule
def number_of_segments(segments: dict[str, Any]) -> Verdict:
    """(4): n - 1 segments less the danger ones."""
    total = {safe + segments["danger"][k] for k, safe in segments["safe"].items()}
    effect = f"{min(total)} segments between 7 obstacles in each of 5 tables, where n - 1 is 6"
    if total == {6}:
        return Verdict(Outcome.HOLDS, effect, "neighbours are consecutive numbers, as in Fig. 12")
    return Verdict(Outcome.FAILS, effect, "neighbours are others")


@_rule
def two_conditions(segments: dict[str, Any]) -> Verdict:
    """Step 2 asks for D_r, and (4) for D_r + delta, which may not matter."""
    between = segments["between"]
    narrow, wide = segments["limits_mm"]
    effect = (
        f"{between} of {segments['measured']} segments are between D_r and D_r + δ long, "
        f"{narrow:.1f} to {wide:.1f} mm"
    )
    if between:
        return Verdict(Outcome.OPEN, effect, "(4) asks for D_r + δ, Step 2 for D_r: they differ")
    reason = "(4) asks for D_r + δ, Step 2 for D_r; assumes our sizes, for which both say the same"
    return Verdict(Outcome.ASSUMED, effect, reason)


def _cases_of(sizes: dict[str, Any], count: str) -> str:
    """How many cases, as a range over all sets of sizes."""
    return f"{_span(sizes[count])} of 16 cases, over {sizes['sets']} sets of obstacle sizes"


@_rule
def greedy_alone(sizes: dict[str, Any]) -> Verdict:
    """How far the paper's rules get without a search of ours."""
    low, _, high = sizes["greedy"]
    effect = f"they alone solve {_cases_of(sizes, 'greedy')}"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "turning points decide every case")
    outcome = Outcome.PART if high > 0 else Outcome.FAILS
    return Verdict(outcome, effect, "the other cases need a search round a group, which is ours")


@_rule
def circle_at_point(sizes: dict[str, Any]) -> Verdict:
    """The circle of radius R_D round the turning point itself, word by word."""
    low, _, high = sizes["literal"]
    effect = f"such circles solve {_cases_of(sizes, 'literal')}"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "word by word, every case is solved")
    if high == 16:
        return Verdict(Outcome.PART, effect, "word by word, it depends on the sizes")
    reason = "a circle round a point of the boundary cuts through the obstacle behind it"
    return Verdict(Outcome.FAILS, effect, reason)


@_rule
def least_detour(sizes: dict[str, Any]) -> Verdict:
    """Of what the greedy rule solves, how much is the shortest path."""
    low, middle, high = sizes["greedy_share"]
    effect = (
        f"of the cases that this rule decides, {100 * low:.0f} to {100 * high:.0f} % (median "
        f"{100 * middle:.0f} %) get the shortest path, over {sizes['sets']} sets of obstacle sizes"
    )
    if low == 1:
        return Verdict(Outcome.HOLDS, effect, "the least detour is the shortest path throughout")
    outcome = Outcome.PART if high > 0 else Outcome.FAILS
    return Verdict(outcome, effect, "the least detour is a guess: it leaves out the turns to come")


def _shortest(sizes: dict[str, Any]) -> str:
    worst = sizes["worst_ratio"][2]
    return f"shortest in {_cases_of(sizes, 'optimal')}; at worst {worst:.2f} × the optimum"


@_rule
def finds_shortest(sizes: dict[str, Any]) -> Verdict:
    """Whether the shortest path is found at all, and how often."""
    low, middle, _ = sizes["optimal"]
    effect = _shortest(sizes)
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "all are optimal")
    outcome = Outcome.PART if middle >= 8 else Outcome.FAILS
    return Verdict(outcome, effect, "often, not always; our group search helps")


@_rule
def always_shortest(sizes: dict[str, Any]) -> Verdict:
    """As `finds_shortest`, but the sentence says always."""
    low, _, _ = sizes["optimal"]
    effect = _shortest(sizes)
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "all are optimal")
    return Verdict(Outcome.FAILS, effect, "“always” has counterexamples")


@_rule
def always_safely(sizes: dict[str, Any]) -> Verdict:
    """All cases with all sizes, by the words and by the completed planner."""
    solved, words = sizes["solved"], sizes["literal"]
    effect = (
        f"planned safely with our completions: {_span(solved)} of 16 cases; word by word: "
        f"{_span(words)}; over {sizes['sets']} sets of obstacle sizes"
    )
    if words[0] == 16:
        return Verdict(Outcome.HOLDS, effect, "the words alone do")
    if solved[0] == 16:
        reason = "assumes our completions: concentric circles, outer endpoints, a search of groups"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "some cases stay unsolved")


@_rule
def as_told(sizes: dict[str, Any]) -> Verdict:
    """The route of 16(b) that section 5 tells by the wheels: left, left, right."""
    told, sets = sizes["told"], sizes["sets"]
    effect = (
        f"with {told} of {sets} sets of obstacle sizes the plan of 16(b) turns left, left, right"
    )
    if told:
        return Verdict(Outcome.ASSUMED, effect, "assumes one of the sets of sizes that lead so")
    reason = "it describes a drawing that we do not have, and no sizes that we tried reproduce it"
    return Verdict(Outcome.OPEN, effect, reason)


@_rule
def safe_paths(planned: dict[str, Any]) -> Verdict:
    """All 16 cases with our sizes."""
    effect = (
        f"{planned['safe']} of {planned['cases']} plans are safe: the robot's centre passes "
        f"obstacles at {planned['clearance_mm']:.1f} mm or more, its radius is "
        f"{planned['radius_mm']:.1f} mm"
    )
    if planned["safe"] == planned["cases"]:
        return Verdict(Outcome.ASSUMED, effect, "assumes our sizes and our completions")
    return Verdict(Outcome.FAILS, effect, "a path collides")


def _planned_anew(planned: dict[str, Any]) -> str:
    return f"a safe path in {planned['safe']} of {planned['cases']} changes of start, goal and map"


def _blindly(movers: dict[str, Any]) -> str:
    """What becomes of a plan among movers that is made once."""
    few, _, many = movers["movers"]
    return (
        f"among {few:.0f} to {many:.0f} obstacles that move, a robot that plans once, round what "
        "stands, "
        f"collides in {_percent(movers['blind_hit'])} of {movers['scenes']} scenes"
    )


@_rule
def reactive_drive(planned: dict[str, Any], movers: dict[str, Any]) -> Verdict:
    """As `reactive`, of a robot on its way, among obstacles that move."""
    effect = f"{_planned_anew(planned)}; but {_blindly(movers)}"
    if planned["safe"] < planned["cases"]:
        return Verdict(Outcome.FAILS, effect, "a change leaves it without a safe path")
    if movers["blind_hit"].high < TOO_MANY:
        return Verdict(Outcome.HOLDS, effect, "not even movers hit who plans once")
    reason = "assumes a map that is known and stands still: nothing is sensed on the way"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def static_only(movers: dict[str, Any]) -> Verdict:
    """The limit that the abstract sets: whether it is needed."""
    low, high = (-100 * end for end in reversed(movers["fewer"]))
    effect = (
        f"{_blindly(movers)}; one that plans anew {1 / TICK:.0f} times a second does in "
        f"{_percent(movers['anew_hit'])}, and arrives {low:.0f} to {high:.0f} percentage points "
        "more often"
    )
    if movers["fewer"][1] < 0:
        return Verdict(Outcome.HOLDS, effect, "the limit is needed, and rightly named")
    return Verdict(Outcome.FAILS, effect, "who plans once does as well: the limit is not needed")


@_rule
def worth_the_future(movers: dict[str, Any], crossings: dict[str, Any]) -> Verdict:
    """Whether looking at movers helps, and how near to the earliest arrival one comes."""
    later = "{:.1f} % [{:.1f}, {:.1f}]".format(*(100 * one for one in movers["anew_later"]))
    (won, asked), (beaten, more) = crossings["proved"], crossings["unproved"]
    effect = (
        f"planning anew arrives in {_percent(movers['anew_arrives'])} of {movers['scenes']} "
        f"scenes, on average {later} later than the earliest arrival known; rivals beat our "
        f"planner in {won} of {asked} scenes where it is proved to be optimal, and in {beaten} of "
        f"{more} others"
    )
    if movers["fewer"][1] >= 0:
        return Verdict(Outcome.FAILS, effect, "who looks at no mover arrives as often")
    if won:
        return Verdict(Outcome.PART, effect, "it helps, but what we call optimal is not")
    low, _, high = movers["speeds"]
    reason = (
        f"assumes discs that keep their velocity, {low:g} to {high:g} of the robot's speed; none "
        "of it is the paper's"
    )
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def reactive(planned: dict[str, Any]) -> Verdict:
    """Reactive is what plans anew for every change of the map; nothing is sensed."""
    effect = _planned_anew(planned)
    if planned["safe"] == planned["cases"]:
        reason = "assumes that “reactive” means planning anew: the planner knows the map throughout"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "a change leaves it without a safe path")


def _repaired(found: tuple[int, int], case: str) -> Verdict:
    solved, met = found
    effect = f"{solved} of {met} plans of ours that need it are safe in the end"
    if met and solved == met:
        reason = f"assumes our sizes, and our order of repairs of {case}"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, f"{case} is not repaired, or never met")


@_rule
def second_circle(planned: dict[str, Any]) -> Verdict:
    """Case 1 of section 3.3.1."""
    return _repaired(planned["case_1"], "case 1")


@_rule
def adequate_point(planned: dict[str, Any]) -> Verdict:
    """Case 2 of section 3.3.1."""
    return _repaired(planned["case_2"], "case 2")


@_rule
def keeps_turns(planned: dict[str, Any]) -> Verdict:
    """Whether the turning point that was found is kept when others are added."""
    dropped, repaired = planned["dropped"], planned["repaired"]
    effect = f"{dropped} of {planned['cases']} plans drop a turn or start over round a group"
    if not dropped:
        return Verdict(Outcome.HOLDS, effect, f"kept in all {repaired} plans with repairs")
    return Verdict(Outcome.PART, effect, "to keep every turn would leave needless ones in the path")


@_rule
def local_minimum(planned: dict[str, Any], segments: dict[str, Any]) -> Verdict:
    """Figs 16(c) and (d): all segments are danger, and turning points do not help."""
    met, safe = sum(planned["group"]), segments["safe"][5]
    effect = (
        f"met in {met} of 2 panels, 16(c) and (d), with {safe} of 6 segments safe; and in "
        f"{planned['groups']} of {planned['cases']} panels in all"
    )
    if met == 2 and not safe:
        reason = "assumes our sizes; by our rule one is also met with safe segments left"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "with our sizes there is a way without leaving the group")


@_rule
def goes_far(planned: dict[str, Any]) -> Verdict:
    """How far the shortest way out of 16(c) and (d) keeps, and how much longer it is."""
    passes, kept = max(planned["passes_mm"]), planned["kept_mm"]
    low, high = sorted(planned["longer"])
    effect = (
        f"the robot's centre passes obstacles at {passes:.1f} mm, where the least, R_D, is "
        f"{kept:.1f} mm; the "
        f"path is {100 * low:.1f} to {100 * high:.1f} % longer than the straight line"
    )
    if passes > 2 * kept:
        return Verdict(Outcome.HOLDS, effect, "the way out keeps far from the obstacles")
    reason = "it leads round all of them, as told; “far” is neither defined nor needed"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def safest_segment(planned: dict[str, Any]) -> Verdict:
    """“Safest” as the widest, or as any that is safe: (5) and (6) compare all safe ones."""
    alike, cases = planned["reads_alike"], planned["cases"]
    effect = f"widest of all or any that is safe: the same path in {alike} of {cases} cases"
    if alike == cases:
        return Verdict(Outcome.HOLDS, effect, "it makes no difference which is meant")
    reason = "“safest” may mean widest or safe; section 3.2.2 compares all that are safe"
    return Verdict(Outcome.OPEN, effect, reason)


@_rule
def any_world(random_worlds: dict[str, Any]) -> Verdict:
    """Discs and polygons, other goals: the completed planner and the words alone."""
    solved, solvable = random_worlds["solved"], random_worlds["solvable"]
    words = random_worlds["words"]
    effect = (
        f"solved with our completions: {solved} of {solvable} solvable random worlds; word by "
        f"word, where something is in the way: {_percent(words)}"
    )
    if words.low > 0.99:
        return Verdict(Outcome.HOLDS, effect, "the words alone do")
    if solved == solvable:
        reason = "assumes our completions, the search round groups among them"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "some worlds stay unsolved")


@_rule
def less_computation(orders: dict[str, Any]) -> Verdict:
    """Distances that safety first computes, over those of length first."""
    cheaper, searched = orders["cheaper"], orders["searched"]
    low, high = min(orders["turns"]), max(orders["turns"])
    effect = (
        f"safety first computes fewer distances in {cheaper} of {searched} cases, "
        f"{_span(orders['ratios'], 3)} times as many as length first; in rows of discs, fewer "
        f"where more than {100 * low:.0f} to {100 * high:.0f} % of the segments are danger"
    )
    if cheaper == searched:
        return Verdict(Outcome.HOLDS, effect, "safety first is cheaper throughout")
    if orders["ratios"][0] < 1:
        return Verdict(Outcome.PART, effect, "true where many segments are danger, and by little")
    return Verdict(Outcome.FAILS, effect, "safety first is nowhere cheaper")


@_rule
def needs_more_time(rivals: dict[str, Any]) -> Verdict:
    """The clock: length first against safety first, in the paper's cases."""
    low, ratio, high = rivals["safety_first"]
    effect = (
        f"safety first takes {low:.2f} to {high:.2f} times as long as length first, median "
        f"{ratio:.2f}, in 16 cases"
    )
    if ratio < 0.8:
        return Verdict(Outcome.HOLDS, effect, "length first is clearly slower")
    if ratio < 0.95:
        return Verdict(Outcome.PART, effect, "length first is a little slower")
    return Verdict(Outcome.FAILS, effect, "length first is not slower on the clock")


@_rule
def rapidly(rivals: dict[str, Any]) -> Verdict:
    """Against the time for which a command is held; and against the exact planner."""
    low, _, high = rivals["slower"]
    effect = (
        f"{rivals['median_ms']:.0f} ms or less, median of each set of questions, where a command "
        f"is held for {HELD_MS:.0f} ms; {low:.1f} to {high:.1f} × the time of an exact planner"
    )
    if rivals["median_ms"] < HELD_MS:
        return Verdict(Outcome.HOLDS, effect, f"within one time step of {HELD_MS:.0f} ms")
    return Verdict(Outcome.FAILS, effect, f"longer than one time step of {HELD_MS:.0f} ms")


@_rule
def good_alternative(rivals: dict[str, Any]) -> Verdict:
    """Solved, near the optimum, and next to the exact planner."""
    solved, asked = rivals["solved"], rivals["questions"]
    low, _, high = rivals["slower"]
    effect = (
        f"with our completions: {solved} of {asked} questions solved; within 1 % of the shortest "
        f"path in {100 * rivals['near']:.0f} % or more of each set, at worst "
        f"{rivals['max_ratio']:.2f} × as long; {low:.1f} to {high:.1f} × the time of an exact "
        "planner"
    )
    if solved < asked:
        return Verdict(Outcome.FAILS, effect, "some questions stay without a path")
    if low <= 1:
        return Verdict(Outcome.HOLDS, effect, "as good as the exact planner, and no slower")
    reason = "adequate, with our completions; but an exact planner is shorter and quicker"
    return Verdict(Outcome.PART, effect, reason)


#: How a law whose numbers are so stands to a rival, where small is good.
BESIDE_RIVALS = {
    SMALLER: "ahead of",
    LARGER: "behind",
    EQUIVALENT: "level with",
    UNDECIDED: "undecided beside",
}


def _beside(found: Any, margin: float, unit: str, factor: float) -> tuple[list[str], str]:
    """Verdict on each rival, and a sentence on all of them."""
    said = [verdict(low, high, margin) for _, low, high in found]
    counts = ", ".join(f"{BESIDE_RIVALS[one]} {said.count(one)}" for one in dict.fromkeys(said))
    low = factor * min(low for _, low, _ in found)
    high = factor * max(high for _, _, high in found)
    return said, (
        f"{counts} of {len(said)} rivals told the same, differences within "
        f"[{low:.2f}, {high:.2f}] {unit}"
    )


def _no_better(said: list[str], effect: str, good: str) -> Verdict:
    if set(said) == {SMALLER}:
        return Verdict(Outcome.HOLDS, effect, f"{good}, ahead of all rivals")
    if LARGER not in said:
        return Verdict(
            Outcome.PART, effect, f"{good}, but not ahead of all rivals that are told the same"
        )
    return Verdict(Outcome.FAILS, effect, "behind a rival that is told the same")


def _stands(stress: dict[str, Any]) -> tuple[list[str], str]:
    """Causes that, much stronger, make too many runs fail; and a sentence on all of them."""
    shares = {cause.replace("_", " "): found for cause, found in stress["stronger"].items()}
    bad = [cause for cause, found in shares.items() if found.low > TOO_MANY]
    told = [f"{cause} {_percent(one)}" for cause, one in shares.items() if one.high > TOO_MANY]
    rest = f"the others less than {100 * TOO_MANY:.0f} %"
    return bad, (
        f"Of {stress['runs']} usual runs with a margin of {1000 * WIDE_MARGIN:g} mm, "
        f"{_percent(stress['failed'])} fail; with one cause {STRONGER:g} times as strong, untold: "
        f"{', '.join([*told, rest] if len(told) < len(shares) else told)}"
    )


@_rule
def robust(comparison: dict[str, Any], stress: dict[str, Any]) -> Verdict:
    """Three times all that disturbs, beside rivals; and one cause at a time, much stronger."""
    hits, rms = comparison["hits"], comparison["rms_mm"]["harsh"]
    said, text = _beside(comparison["harsh"], NO_DIFFERENCE, "mm", 1000)
    bad, stands = _stands(stress)
    effect = (
        f"three times all disturbances: {_percent(hits)} of the runs touch an obstacle; RMS error "
        f"{_estimate(rms, 'mm')}, {text}. {stands}"
    )
    if max(hits.low, stress["failed"].low) > TOO_MANY:
        return Verdict(Outcome.FAILS, effect, "too many runs fail or touch an obstacle")
    found = _no_better(said, effect, _all_but(bad))
    if bad and found.outcome is Outcome.HOLDS:
        return found._replace(outcome=Outcome.PART)
    return found


def _all_but(bad: list[str]) -> str:
    return f"it stands all but {' and '.join(bad)}" if bad else "it stands all causes"


@_rule
def stable(comparison: dict[str, Any]) -> Verdict:
    """Starts 50 mm and 60 degrees off."""
    settled = comparison["settled"]
    effect = (
        f"{_percent(settled)} of the runs that start {FAR_START} the reference "
        f"settle within {LATEST:.0f} s"
    )
    if settled.share == 1:
        reason = "assumes starts nearby and tuned gains; from farther off see “tend to zero”"
        return Verdict(Outcome.ASSUMED, effect, reason)
    some = Outcome.PART if settled.share > 0.9 else Outcome.FAILS
    return Verdict(some, effect, "some do not settle")


@_rule
def robust_and_fast(comparison: dict[str, Any], stress: dict[str, Any]) -> Verdict:
    """Settling times from far starts, and runs that fail."""
    said, text = _beside(comparison["settling"], NO_TIME, "s", 1)
    bad, stands = _stands(stress)
    effect = (
        f"from starts {FAR_START} it settles in "
        f"{_estimate(comparison['settles_in_s'], 's')}, {text}. "
        f"{stands}"
    )
    if stress["failed"].low > TOO_MANY:
        return Verdict(Outcome.FAILS, effect, "too many runs fail")
    return _no_better(said, effect, f"it settles soon, and {_all_but(bad)}")


@_rule
def good_transient(comparison: dict[str, Any]) -> Verdict:
    """Errors from far starts."""
    said, text = _beside(comparison["far"], NO_DIFFERENCE, "mm", 1000)
    rms = _estimate(comparison["rms_mm"]["far"], "mm")
    effect = f"RMS error {rms} from starts {FAR_START}; {text}"
    return _no_better(said, effect, "it comes back well")


@_rule
def good_tracking(comparison: dict[str, Any]) -> Verdict:
    """The error under the usual disturbance."""
    rms = comparison["rms_mm"]["usual"]
    _, text = _beside(comparison["usual"], NO_DIFFERENCE, "mm", 1000)
    effect = (
        f"RMS error {_estimate(rms, 'mm')} at the usual disturbance, where good is below "
        f"{FOLLOWS_MM:.0f} mm; {text}"
    )
    if rms[0] < FOLLOWS_MM:
        return Verdict(Outcome.ASSUMED, effect, "assumes gains that we tuned: none are published")
    return Verdict(Outcome.FAILS, effect, "a tenth of the robot's diameter off, or more")


@_rule
def error_remains(comparison: dict[str, Any]) -> Verdict:
    """No law brings the error of a disturbed robot to zero."""
    least, none = comparison["least_rms_mm"], 1000 * NO_DIFFERENCE
    effect = (
        f"RMS error {_estimate(least, 'mm')} for the best of ten tuned laws at the usual "
        f"disturbance, where {none:g} mm counts as none"
    )
    if least[0] > none:
        return Verdict(Outcome.HOLDS, effect, "so Fig. 18 shows runs without such a disturbance")
    return Verdict(Outcome.FAILS, effect, "a law removes it")


@_rule
def fuzzy_is_slow(steps: dict[str, Any]) -> Verdict:
    """Time of a step of a fuzzy law over the sliding mode's."""
    ratio = steps["fuzzy"]
    effect = (
        f"a step takes {ratio:.1f} times as long as the sliding mode's (median "
        f"{steps['fuzzy_us']:.0f} µs), {steps['fuzzy_slow']:.1f} times at the 99th percentile "
        f"({steps['fuzzy_slow_us']:.0f} µs)"
    )
    if ratio > MUCH_SLOWER:
        return Verdict(Outcome.HOLDS, effect, "clearly slower")
    return Verdict(Outcome.FAILS, effect, "hardly slower, on a computer of today")


@_rule
def pid_unstable(noise: dict[str, Any], stress: dict[str, Any]) -> Verdict:
    """Eight times the noise of the sensors, for a tuned PID and for the paper's law."""
    low, middle, high = noise["growth"]["Pid"]
    least, ours, most = noise["growth"]["SlidingMode"]
    pid, sliding = stress["noisy"]["Pid"], stress["noisy"]["SlidingMode"]
    effect = (
        f"with {stress['noise_times']:g} times the noise its RMS error grows {middle:.1f} "
        f"[{low:.1f}, {high:.1f}] times, to {noise['noisy_mm']['Pid']:.1f} mm, the sliding mode's "
        f"{ours:.1f} [{least:.1f}, {most:.1f}] times; {_percent(pid)} of its runs fail, "
        f"{_percent(sliding)} of the sliding mode's"
    )
    if low > most or pid.low > sliding.high:
        return Verdict(Outcome.HOLDS, effect, "the PID suffers more than the sliding mode")
    reason = "a tuned PID that reads its derivative off the heading stands the noise as well"
    return Verdict(Outcome.FAILS, effect, reason)


@_rule
def delays_chatter(chatter: dict[str, Any]) -> Verdict:
    """A law that switches, without delay and with one."""
    at_once, late = chatter["sign"], chatter["sign_late"]
    effect = (
        f"with sign, the wheels' roughness is {_span(at_once, 2)} m/s² without delay, "
        f"{_span(late, 2)} with {chatter['delay_ms']:.0f} ms, in {chatter['runs']} runs each; with "
        f"sat, {_span(chatter['sat'], 2)}"
    )
    if at_once[1] < 2 * chatter["sat"][1]:
        return Verdict(Outcome.HOLDS, effect, "no delay, no chattering")
    reason = "it chatters without: to hold a command for a time step is itself a delay"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def saturation_calms(chatter: dict[str, Any]) -> Verdict:
    """What sat is for."""
    sat, sign = chatter["sat"], chatter["sign"]
    effect = (
        f"the wheels' roughness is {_span(sat, 2)} m/s² with sat, {_span(sign, 2)} with sign, "
        f"in {chatter['runs']} runs each"
    )
    if sat[1] < sign[1] / 2:
        return Verdict(Outcome.HOLDS, effect, "the wheels are far calmer")
    return Verdict(Outcome.FAILS, effect, "the wheels are no calmer")


def _near_and_far(driven: dict[str, Any]) -> str:
    low, high = sorted(driven["far"])
    begun = 1000 * math.hypot(NEAR_START, NEAR_START)
    return (
        f"undisturbed, an error of {begun:.0f} mm is {driven['near_mm']:.2f} mm at the end; of "
        f"{driven['starts']} starts within ±{FAR_REACH:g} m of the reference {100 * low:.0f} to "
        f"{100 * high:.0f} % come back, in two cases"
    )


@_rule
def errors_vanish(driven: dict[str, Any]) -> Verdict:
    """Runs without disturbance, from nearby and from far off."""
    effect = _near_and_far(driven)
    if driven["near_mm"] > 1:
        return Verdict(Outcome.FAILS, effect, "not even from nearby")
    if min(driven["far"]) == 1:
        return Verdict(Outcome.HOLDS, effect, "from everywhere that was tried")
    return Verdict(Outcome.ASSUMED, effect, "assumes a start nearby, and our gains")


@_rule
def guaranteed(driven: dict[str, Any]) -> Verdict:
    """A guarantee has no exceptions."""
    effect = _near_and_far(driven)
    if min(driven["far"]) == 1:
        return Verdict(Outcome.HOLDS, effect, "no exception among the starts that were tried")
    reason = "some starts are lost: a guarantee needs a region, and none is given"
    return Verdict(Outcome.FAILS, effect, reason)


@_rule
def drives_clear(driven: dict[str, Any], stress: dict[str, Any]) -> Verdict:
    """Driven tracks of 15(a) and 16(b), and disturbed ones with a narrow and a wide margin."""
    gap, contact = driven["gap_mm"], stress["contact"]
    low, high = stress["touched"]
    effect = (
        f"undisturbed, {gap:.1f} mm are left between robot and obstacle, in two cases; disturbed, "
        f"{100 * low:.1f} to {100 * high:.1f} % of the runs touch one with a margin of "
        f"{stress['our_margin_mm']:g} mm, on {stress['courses']} courses, and {_percent(contact)} "
        f"of {stress['runs']} with {1000 * WIDE_MARGIN:g} mm"
    )
    if gap < 0 or contact.low > TOO_MANY:
        return Verdict(Outcome.FAILS, effect, "the robot touches an obstacle")
    reason = "assumes our sizes, gains, a start nearby, and a margin for what disturbs"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def margin_suffices(stress: dict[str, Any]) -> Verdict:
    """The margin that is needed; the paper says that there is one, and not how large."""
    low, high = stress["margin_mm"]
    if high > stress["widest_mm"]:
        effect = f"more than 1 in {ONE_IN} runs touch an obstacle at {stress['widest_mm']:.0f} mm"
        return Verdict(Outcome.FAILS, effect, "the widest margin that was tried is not enough")
    few, many = (100 * end for end in stress["touched"])
    effect = (
        f"for contact in 1 of {ONE_IN} disturbed runs δ has to be {low:.0f} to {high:.0f} mm, on "
        f"{stress['courses']} courses; with our {stress['our_margin_mm']:g} mm, {few:.1f} to "
        f"{many:.1f} % of the runs touch an obstacle"
    )
    if high <= stress["our_margin_mm"]:
        return Verdict(Outcome.HOLDS, effect, "the margin that we took is enough")
    reason = "assumes a margin of that size, and disturbances of ours: the paper gives neither"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def error_units(figures: dict[str, Any]) -> Verdict:
    """Which units of the errors fit what is printed on Figs 17 to 19."""
    fit = figures["units"]
    effect = (
        f"{' and '.join(fit) or 'no unit'}, of m, cm and mm, fit the axes of both panels of "
        "Figs 18 and 19, with angles in rad"
    )
    if len(fit) == 1:
        return Verdict(
            Outcome.ASSUMED, effect, f"assumes errors in {fit[0]}, which are not printed"
        )
    return Verdict(
        Outcome.OPEN, effect, "no unit is printed on the axes, and the gains are open too"
    )


@_rule
def same_clock(axes: dict[str, Any]) -> Verdict:
    """The time axes of Figs 18 and 19 are of the same runs."""
    low, high = min(axes["ratios"]), max(axes["ratios"])
    hours = min(axes["hours"])
    effect = (
        f"the axes of Fig. 19 end {low:.0f} and {high:.0f} times later than those of Fig. 18, of "
        f"the same runs: after {hours:.0f} hours or more"
    )
    if high <= 2:
        return Verdict(Outcome.HOLDS, effect, "both figures last alike")
    return Verdict(Outcome.FAILS, effect, "not seconds, as its axis says; time steps would fit")
