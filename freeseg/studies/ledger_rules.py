"""Rules of the ledger: from evidence to a verdict on a claim of the paper.

A rule is a function of the digests that a row of ``data/claims.csv`` names, in that order, and of
nothing else. Its thresholds stand in it: whoever disagrees with a verdict finds what to argue with.
"""

import math
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from freeseg.replanning import SIGHT_NOISE
from freeseg.robot import KheperaIV
from freeseg.studies.comparing import NO_DIFFERENCE
from freeseg.studies.courses import WIDE_MARGIN
from freeseg.studies.ledger_drives import NOISE_TIMES
from freeseg.studies.ledger_equations import STATES
from freeseg.studies.ledger_evidence import (
    FAR,
    FAR_REACH,
    LATEST,
    NEAR_START,
    ONE_IN,
    SETTLED_S,
    STRONGER,
)
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

#: An error that grows by so much more than the noise grows faster than it.
BEYOND_NOISE = 1.5

#: By how much of its time the exact planner may be flattered, as notebook 13 says.
FLATTERED = 0.25

#: What stands where the paper leaves a choice, as notebook 07 codes it; not what 13 calls its
#: words, with circles round obstacles.
OUR_READING = "our literal reading"

#: What our runs of the predecessor [12] cannot say.
NOT_THEIRS = "this is length first on a known map, and not the robot of [12], which explores"

#: The difference of settling times that counts as none (s).
NO_TIME = 0.1

#: How far off the reference the runs from far off begin, at most.
FAR_START = "up to {:.0f} mm and {:.0f}° off".format(
    *np.multiply(REGIMES[FAR.regime].offset, (1000, np.degrees(1)))
)


class Outcome(StrEnum):
    """What can come of judging a claim."""

    HOLDS = "holds"
    ASSUMED = "holds under a named assumption"
    PART = "holds in part"
    FAILS = "does not hold"
    OPEN = "cannot be decided from the text"


class Verdict(NamedTuple):
    """What evidence says of a claim.

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
    reason = (
        "solved for w, (12) has a denominator that vanishes where the robot is about a scale of "
        "length ahead of the reference"
    )
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
    reason = "with circles round obstacles; the others need a search of groups: both are ours"
    return Verdict(outcome, effect, reason)


@_rule
def circle_at_point(sizes: dict[str, Any], radii: dict[str, Any]) -> Verdict:
    """The circle of radius R_D round the turning point itself, for several R_D and all sizes."""
    low, high = radii["solved"]
    least, _, most = sizes["literal"]
    effect = (
        f"{OUR_READING} solves {low} to {high} of {radii['cases']} cases with R_D from "
        f"{radii['least_mm']:.0f} to {radii['most_mm']:.0f} mm, most at {radii['best_mm']:.0f} mm; "
        f"with R_D = R_r + δ/2 {_cases_of(sizes, 'literal')}; in "
        f"{radii['cases'] - radii['with_gaps']} cases no gap is safe, and it has no turning point"
    )
    assumed = "an endpoint is taken to be the point nearest to the neighbour"
    if least >= radii["with_gaps"]:
        return Verdict(Outcome.HOLDS, effect, "wherever a gap is safe, with all sizes")
    if max(high, most) >= radii["with_gaps"]:
        reason = f"assumes the best R_D or sizes of these; {assumed}"
        return Verdict(Outcome.ASSUMED, effect, reason)
    reason = f"it hangs on R_D, which is not published, on the sizes, and on our choices; {assumed}"
    return Verdict(Outcome.PART if max(high, most) > 0 else Outcome.FAILS, effect, reason)


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
        return Verdict(Outcome.ASSUMED, effect, "assumes our completions, and no worlds but these")
    return Verdict(Outcome.FAILS, effect, "“always” has counterexamples")


@_rule
def always_safely(sizes: dict[str, Any]) -> Verdict:
    """All cases with all sizes, by the completed planner; the literal reading is told beside it."""
    solved = sizes["solved"]
    effect = (
        f"planned safely with our completions: {_cases_of(sizes, 'solved')}; by {OUR_READING}, "
        f"with R_D = R_r + δ/2 and no way out of local minima: {_span(sizes['literal'])}"
    )
    if solved[0] == 16:
        reason = (
            "assumes that there is a way, and our completions: concentric circles, outer "
            "endpoints, a search of groups"
        )
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
        f"assumes discs that keep their velocity, {low:g} to {high:g} of the robot's speed, and "
        f"are seen with noise of {1000 * SIGHT_NOISE:g} mm; none of it is the paper's"
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
def smooth_path(planned: dict[str, Any]) -> Verdict:
    """Corners of the paths, and jumps of their curvature."""
    corner, jump = planned["corner"], planned["jump_per_m"]
    effect = (
        f"headings differ by {np.degrees(EQUAL):.0e}° or less"
        if corner <= EQUAL
        else f"headings differ by up to {np.degrees(corner):.1f}°"
    ) + (f" where pieces of {planned['cases']} paths meet, and curvatures by up to {jump:.1f} 1/m")
    if corner > EQUAL:
        return Verdict(Outcome.FAILS, effect, "a path has a corner")
    if jump <= EQUAL:
        return Verdict(Outcome.HOLDS, effect, "neither corners nor jumps of the curvature")
    reason = "assumes that smooth means without corners: where arcs begin, the curvature jumps"
    return Verdict(Outcome.ASSUMED, effect, reason)


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
    """Discs and polygons, other goals, by the completed planner; the literal reading beside it."""
    solved, solvable = random_worlds["solved"], random_worlds["solvable"]
    effect = (
        f"solved with our completions: {solved} of {solvable} solvable random worlds; by "
        f"{OUR_READING}, with R_D = R_r + δ/2, endpoints nearest to neighbours and no way out of "
        f"local minima, where something is in the way: {_percent(random_worlds['words'])}"
    )
    if solved == solvable:
        reason = "assumes that there is a way, and our completions, the search of groups among them"
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
        reason = f"true where many segments are danger, and by little; {NOT_THEIRS}"
        return Verdict(Outcome.PART, effect, reason)
    return Verdict(Outcome.FAILS, effect, "safety first is nowhere cheaper")


@_rule
def needs_more_time(rivals: dict[str, Any]) -> Verdict:
    """The clock: length first against safety first, in the middle half of the paper's cases."""
    (least, _, most), (low, high) = rivals["safety_first"], rivals["middle_half"]
    effect = (
        f"safety first takes {least:.2f} to {most:.2f} times as long as length first in "
        f"{rivals['timed']} cases, timed once each, {low:.2f} to {high:.2f} in their middle half; "
        f"median over all {rivals['questions']} questions asked in 13: {rivals['everywhere']:.2f}"
    )
    if high < 1:
        return Verdict(Outcome.HOLDS, effect, f"length first is slower; but {NOT_THEIRS}")
    if low > 1:
        return Verdict(Outcome.FAILS, effect, f"length first is quicker; but {NOT_THEIRS}")
    reason = f"some cases take longer, others less, and times are of one machine; and {NOT_THEIRS}"
    return Verdict(Outcome.OPEN, effect, reason)


@_rule
def rapidly(rivals: dict[str, Any]) -> Verdict:
    """Against the time for which a command is held; and against the exact planner."""
    low, _, high = rivals["slower"]
    effect = (
        f"{rivals['median_ms']:.0f} ms or less, median of each set of questions, where a command "
        f"is held for {HELD_MS:.0f} ms; {low:.1f} to {high:.1f} × the time of an exact planner"
    )
    if rivals["median_ms"] < HELD_MS:
        reason = f"assumes our computer, and that rapid means within a step of {HELD_MS:.0f} ms"
        return Verdict(Outcome.ASSUMED, effect, reason)
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
        "planner, which is compiled in large worlds and was timed in its favour by up to a quarter"
    )
    if solved < asked:
        return Verdict(Outcome.FAILS, effect, "some questions stay without a path")
    # A quarter off the exact planner's time is this much of the ratio.
    if high * (1 - FLATTERED) <= 1:
        return Verdict(Outcome.HOLDS, effect, "as good as the exact planner, and no slower")
    reason = (
        "adequate, with our completions; but an exact planner is never longer at the same "
        "clearance, and quicker as both are programmed here"
    )
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
def error_remains(remains: dict[str, Any]) -> Verdict:
    """Whether a law brings the error to zero, disturbed and, from the same starts, not."""
    (low, high), calm, none = remains["disturbed_mm"], remains["calm_mm"], 1000 * NO_DIFFERENCE
    effect = (
        f"begun on the reference, {remains['runs']} runs of {remains['laws']} tuned laws end with "
        f"RMS errors of {low:.2f} to {high:.2f} mm at the usual disturbance, and the best law with "
        f"{calm:.3f} mm at none; {none:g} mm counts as none"
    )
    if low <= none:
        return Verdict(Outcome.FAILS, effect, "a law removes it, in a disturbed run")
    if calm > none:
        return Verdict(Outcome.HOLDS, effect, "it stays even where nothing disturbs")
    reason = "assumes what disturbs, as something does every real robot; our amounts are our own"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def fuzzy_is_slow(steps: dict[str, Any]) -> Verdict:
    """Time of a step of a fuzzy law over those of the laws that it may be compared with."""
    low, high = steps["fuzzy"]
    fast, slow = steps["beside"]
    effect = (
        f"a step takes {steps['fuzzy_us']:.0f} µs (median; {steps['fuzzy_slow_us']:.0f} µs at the "
        f"99th percentile), {low:.1f} times as long as that of {slow} and {high:.1f} times that of "
        f"{fast}, {steps['sliding']:.1f} times the sliding mode's; {MUCH_SLOWER:g} times counts as "
        "slow"
    )
    if low > MUCH_SLOWER:
        return Verdict(Outcome.HOLDS, effect, "clearly slower than every other law")
    if high < MUCH_SLOWER:
        return Verdict(Outcome.FAILS, effect, "hardly slower than any, on a computer of today")
    reason = (
        "the paper names neither a comparator nor fuzzy rules: it hangs on who stands beside, and "
        "the rules are ours"
    )
    return Verdict(Outcome.OPEN, effect, reason)


@_rule
def pid_unstable(sensors: dict[str, Any], stress: dict[str, Any]) -> Verdict:
    """Two readings: a sensor that reads too much, and noise, for a careful D and a careless one."""
    pid, sliding = stress["noisy"]["Pid"], stress["noisy"]["SlidingMode"]
    growth, from_times = sensors["growth"], sensors["from"]
    careful, careless = growth["PID"], growth["PID, D by differences"]
    effect = (
        f"on a line, where sensors read too much, the PID's error stays from "
        f"{_factor(from_times['PID'])} on, the sliding mode's from "
        f"{_factor(from_times['sliding mode'])}; {NOISE_TIMES:g} times the noise, and nothing "
        f"else, makes the PID's {careful:.1f} times as large, with D by differences "
        f"{careless:.1f} times; on courses with {stress['noise_times']:g} times the noise "
        f"{_percent(pid)} of a tuned PID's runs fail, {_percent(sliding)} of the sliding mode's"
    )
    faster = BEYOND_NOISE * NOISE_TIMES
    if careful > faster or pid.low > sliding.high:
        return Verdict(Outcome.HOLDS, effect, "a careful PID, too, suffers from noise")
    if careless > faster or np.isfinite(from_times["PID"]):
        reason = (
            "true beyond the gain margin, as of any loop, and by noise beyond proportion with a "
            "careless derivative; not by noise where D reads the heading"
        )
        return Verdict(Outcome.PART, effect, reason)
    return Verdict(Outcome.FAILS, effect, "it stands both in all forms that were tried")


def _factor(times: float) -> str:
    return f"{times:g} times" if np.isfinite(times) else "none of the factors tried"


@_rule
def delays_chatter(chatter: dict[str, Any]) -> Verdict:
    """How far a law that switches swings, with little delay of its commands and with more."""
    least, more = chatter["sign_deg"]
    short, long = chatter["hold_ms"]
    effect = (
        f"on a straight line, with sign, the heading swings by {least:.3f}° where a command is "
        f"held for {short:.0f} ms and not delayed, by {more:.3f}° with "
        f"{chatter['delay_ms']:.0f} ms of delay, and by {chatter['held_deg']:.3f}° held for "
        f"{long:.0f} ms instead (standard deviations); with sat, by {chatter['sat_deg']:.4f}° at "
        "most"
    )
    if more <= max(least, chatter["sat_deg"]):
        return Verdict(Outcome.FAILS, effect, "a delay makes no oscillation larger")
    if more < 2 * least:
        return Verdict(Outcome.PART, effect, "a delay adds to it, but most of it is there without")
    return Verdict(Outcome.HOLDS, effect, "most of it comes from delay, and holding is one")


@_rule
def saturation_calms(chatter: dict[str, Any]) -> Verdict:
    """What sat is for."""
    sat, sign = chatter["sat"], chatter["sign"]
    effect = (
        f"the wheels' roughness is {sat:.3f} m/s² with sat and {sign:.3f} with sign, means of "
        f"{chatter['runs']} undelayed runs each"
    )
    if sat < sign / 2:
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
def always_follows(driven: dict[str, Any]) -> Verdict:
    """“Always” in what Fig. 17 shows: in its two runs, at all times."""
    begun, worst, later = (driven[key] for key in ("begun_mm", "worst_mm", "later_mm"))
    effect = (
        f"in two cases, undisturbed, the error begins at {begun:.1f} mm and is never above "
        f"{worst:.1f} mm, from {SETTLED_S:g} s on never above {later:.2f} mm"
    )
    if worst > begun + 1 or later > FOLLOWS_MM:
        return Verdict(Outcome.FAILS, effect, "there are times at which it does not follow")
    reason = "assumes a start nearby and our gains, and that Fig. 17 speaks of its own runs only"
    return Verdict(Outcome.ASSUMED, effect, reason)


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
