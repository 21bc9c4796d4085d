"""Rules of the ledger: from evidence to a verdict on a sentence of the paper.

A rule is a function of the digests that a row of ``data/claims.csv`` names, in that order, and of
nothing else. Its thresholds stand in it: whoever disagrees with a verdict finds what to argue with.
"""

from collections.abc import Callable
from enum import StrEnum
from functools import partial
from typing import Any, NamedTuple

from freeseg.robot import KheperaIV
from freeseg.studies.comparing import NO_DIFFERENCE
from freeseg.studies.ledger_evidence import LATEST
from freeseg.studies.statistics import verdict

#: An equation is reproduced where the deviation is below this, in SI units.
EQUAL = 1e-6

#: "Rapidly", "slow": a command is held for 50 ms, and twice as long is slower.
HELD_MS, MUCH_SLOWER = 50.0, 2.0

#: A robot that is this near to its timetable follows it (mm): a tenth of its diameter.
FOLLOWS_MM = 100 * KheperaIV().diameter

#: The difference of settling times that counts as none (s).
NO_TIME = 0.1


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
    return f"{low:.{digits}g} to {high:.{digits}g}, median {middle:.{digits}g}"


def _equations(numbers: tuple[str, ...], found: dict[str, float]) -> Verdict:
    worst = max(found[number] for number in numbers)
    if worst <= EQUAL:
        # Not the number itself: round-off differs from one machine to another.
        effect = f"no deviation above {EQUAL:g}"
        return Verdict(Outcome.HOLDS, effect, "agrees with an independent computation")
    effect = f"deviates by up to {worst:.2g}"
    return Verdict(Outcome.FAILS, effect, "differs from an independent computation")


#: Rules that ask only whether equations agree with an independent computation, and with which:
#: (1) integrated, (2) and (3) by centres and radii, (5) and (6) by a plan's candidates, a plan
#: where nothing is in the way, (7) and (8) written out, (11) to (13) by difference quotients.
AGREEING = {
    "kinematics": ("1",),
    "lengths": ("2",),
    "detours": ("5",),
    "straight": ("straight",),
    "error_frame": ("7",),
    "wheels": ("8",),
    "control_law": ("12", "13"),
}
CLAIM_RULES |= {name: partial(_equations, numbers) for name, numbers in AGREEING.items()}


@_rule
def lyapunov(found: dict[str, float]) -> Verdict:
    """(9), on the first surface and off it."""
    on, off = found["9"], found["9 off"]
    effect = f"at most {on:.1g} m²/s where x_e = 0, up to {off:.2g} m²/s elsewhere"
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
    effect = f"the same state turns up to {gap:.2g} rad/s differently in mm than in m"
    if gap <= EQUAL:
        return Verdict(Outcome.HOLDS, effect, "the law does not depend on the unit of length")
    reason = "V_r y_e has a unit; assumes a scale of length, which the paper does not give"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def reaching(found: dict[str, float]) -> Verdict:
    """(11), everywhere or not."""
    share = found["singular"]
    effect = f"in {100 * share:.0f} % of the states within 0.2 m there is no such command"
    if share == 0:
        return Verdict(Outcome.HOLDS, effect, "the denominator of (12) stays positive")
    reason = "solved for w, (12) has a denominator that vanishes behind the reference"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def seven_obstacles(tables: dict[str, Any]) -> Verdict:
    """Each table has seven."""
    counts = tables["obstacles"]
    effect = f"obstacles in the {len(counts)} tables: {', '.join(map(str, counts))}"
    if set(counts) == {7}:
        return Verdict(Outcome.HOLDS, effect, "counted in Tables 1 to 5")
    return Verdict(Outcome.FAILS, effect, "a table has another number")


@_rule
def fixed_target(cases: dict[str, Any]) -> Verdict:
    """One goal a figure, and two starts."""
    effect = f"{cases['goals']} goal and {cases['starts']} starts a figure, {cases['cases']} panels"
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
    effect = f"{count} of 6 segments of Table 1; equal discs fall short by {-equal:.1f} mm"
    if count == 6 and equal > 0:
        return Verdict(Outcome.HOLDS, f"{count} of 6 segments", "equal discs of some size will do")
    return _as_captioned(count == 6, effect)


@_rule
def both_kinds(segments: dict[str, Any]) -> Verdict:
    """Tables 2 to 4."""
    safe, danger = (segments[kind] for kind in ("safe", "danger"))
    effect = ", ".join(f"Table {k}: {safe[k]} safe, {danger[k]} danger" for k in (2, 3, 4))
    return _as_captioned(all(safe[k] and danger[k] for k in (2, 3, 4)), effect)


@_rule
def number_of_segments(segments: dict[str, Any]) -> Verdict:
    """(4): n - 1 segments less the danger ones."""
    total = {safe + segments["danger"][k] for k, safe in segments["safe"].items()}
    effect = f"{min(total)} segments between seven obstacles"
    if total == {6}:
        return Verdict(Outcome.HOLDS, effect, "neighbours are consecutive numbers, as in Fig. 12")
    return Verdict(Outcome.FAILS, effect, "neighbours are others")


@_rule
def two_conditions(segments: dict[str, Any]) -> Verdict:
    """Step 2 asks for D_r, and (4) for D_r + delta, which may not matter."""
    between = segments["between"]
    effect = f"{between} of {segments['measured']} segments lie between D_r and D_r + δ"
    if between:
        return Verdict(Outcome.OPEN, effect, "(4) asks for D_r + δ, Step 2 for D_r: they differ")
    reason = "(4) asks for D_r + δ, Step 2 for D_r; assumes our sizes, for which both say the same"
    return Verdict(Outcome.ASSUMED, effect, reason)


@_rule
def greedy_alone(sizes: dict[str, Any]) -> Verdict:
    """How far the paper's rules get without a search of ours."""
    low, _, high = sizes["greedy"]
    effect = f"{_span(sizes['greedy'])} of 16 cases, over {sizes['sets']} sets of sizes"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "turning points decide every case")
    outcome = Outcome.PART if high > 0 else Outcome.FAILS
    return Verdict(outcome, effect, "the other cases need a search round a group, which is ours")


@_rule
def circle_at_point(sizes: dict[str, Any]) -> Verdict:
    """The circle of radius R_D round the turning point itself, word by word."""
    low, _, high = sizes["literal"]
    effect = f"{_span(sizes['literal'])} of 16 cases, over {sizes['sets']} sets of sizes"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "word by word, every case is solved")
    if high == 16:
        return Verdict(Outcome.PART, effect, "word by word, it depends on the sizes")
    reason = "a circle round a point of the boundary cuts through the obstacle behind it"
    return Verdict(Outcome.FAILS, effect, reason)


@_rule
def least_detour(sizes: dict[str, Any]) -> Verdict:
    """Of what the greedy rule solves, how much is the shortest path."""
    low, _, high = sizes["greedy_share"]
    effect = f"shortest in {100 * low:.0f} to {100 * high:.0f} % of what this rule decides"
    if low == 1:
        return Verdict(Outcome.HOLDS, effect, "the least detour is the shortest path throughout")
    outcome = Outcome.PART if high > 0 else Outcome.FAILS
    return Verdict(outcome, effect, "the least detour is a guess: it leaves out the turns to come")


@_rule
def finds_shortest(sizes: dict[str, Any]) -> Verdict:
    """Whether the shortest path is found at all, and how often."""
    low, middle, _ = sizes["optimal"]
    effect = f"{_span(sizes['optimal'])} of 16 cases, worst {sizes['worst_ratio'][2]:.2f} × optimum"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "all are optimal")
    outcome = Outcome.PART if middle >= 8 else Outcome.FAILS
    return Verdict(outcome, effect, "often, not always; our group search helps")


@_rule
def always_shortest(sizes: dict[str, Any]) -> Verdict:
    """As `finds_shortest`, but the sentence says always."""
    low, _, _ = sizes["optimal"]
    effect = f"{_span(sizes['optimal'])} of 16 cases, worst {sizes['worst_ratio'][2]:.2f} × optimum"
    if low == 16:
        return Verdict(Outcome.HOLDS, effect, "all are optimal")
    return Verdict(Outcome.FAILS, effect, "“always” has counterexamples")


@_rule
def always_safely(sizes: dict[str, Any]) -> Verdict:
    """All cases with all sizes, by the words and by the completed planner."""
    solved, words = sizes["solved"], sizes["literal"]
    effect = f"completed: {_span(solved)} of 16; word by word: {_span(words)}"
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
    effect = f"{told} of {sets} sets of sizes lead that way"
    if told:
        return Verdict(Outcome.ASSUMED, effect, "assumes one of the sets of sizes that lead so")
    reason = "it describes a drawing that we do not have, and no sizes that we tried reproduce it"
    return Verdict(Outcome.OPEN, effect, reason)


@_rule
def safe_paths(planned: dict[str, Any]) -> Verdict:
    """All 16 cases with our sizes."""
    effect = (
        f"{planned['safe']} of {planned['cases']}; nearest {planned['clearance_mm']:.1f} mm, "
        f"the robot needs {planned['radius_mm']:.1f} mm"
    )
    if planned["safe"] == planned["cases"]:
        return Verdict(Outcome.ASSUMED, effect, "assumes our sizes and our completions")
    return Verdict(Outcome.FAILS, effect, "a path collides")


@_rule
def reactive(planned: dict[str, Any]) -> Verdict:
    """Reactive is what plans anew for every change of the map; nothing is sensed."""
    effect = f"{planned['safe']} of {planned['cases']} changed starts, goals and maps"
    if planned["safe"] == planned["cases"]:
        reason = "assumes that “reactive” means planning anew: the planner knows the map throughout"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.FAILS, effect, "a change leaves it without a safe path")


def _repaired(found: tuple[int, int], case: str) -> Verdict:
    solved, met = found
    effect = f"{solved} of {met} plans that need it are safe in the end"
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
    effect = f"{dropped} of 16 plans drop a turn or start over round a group"
    if not dropped:
        return Verdict(Outcome.HOLDS, effect, f"kept in all {repaired} plans with repairs")
    return Verdict(Outcome.PART, effect, "to keep every turn would leave needless ones in the path")


@_rule
def local_minimum(planned: dict[str, Any], segments: dict[str, Any]) -> Verdict:
    """Figs 16(c) and (d): all segments are danger, and turning points do not help."""
    met, safe = sum(planned["group"]), segments["safe"][5]
    effect = f"{met} of 2 panels with {safe} safe segments; {planned['groups']} of 16 in all"
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
        f"passes at {passes:.1f} mm; {100 * low:.1f} to {100 * high:.1f} % over the straight line"
    )
    if passes > 2 * kept:
        return Verdict(Outcome.HOLDS, effect, "the way out keeps far from the obstacles")
    reason = "it leads round all of them, as told; “far” is neither defined nor needed"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def safest_segment(planned: dict[str, Any]) -> Verdict:
    """“Safest” as the widest, or as any that is safe: (5) and (6) compare all safe ones."""
    alike, cases = planned["reads_alike"], planned["cases"]
    effect = f"both readings give the same path in {alike} of {cases} cases"
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
        f"completed: {solved} of {solvable} random worlds; word by word, where something is in "
        f"the way: {100 * words.share:.1f} % [{100 * words.low:.1f}, {100 * words.high:.1f}]"
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
        f"fewer distances in {cheaper} of {searched} cases, {_span(orders['ratios'], 3)} times as "
        f"many; in rows of discs fewer above {100 * low:.0f} to {100 * high:.0f} % danger"
    )
    if cheaper == searched:
        return Verdict(Outcome.HOLDS, effect, "safety first is cheaper throughout")
    if orders["ratios"][0] < 1:
        return Verdict(Outcome.PART, effect, "true where many segments are danger, and by little")
    return Verdict(Outcome.FAILS, effect, "safety first is nowhere cheaper")


@_rule
def needs_more_time(rivals: dict[str, Any]) -> Verdict:
    """The clock: length first against safety first, in the paper's cases."""
    ratio = rivals["safety_first"]
    effect = f"safety first takes {ratio:.2f} times as long, median of 16 cases"
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
        f"median at most {rivals['median_ms']:.0f} ms; {low:.1f} to {high:.1f} × the exact planner"
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
        f"completed: {solved} of {asked} questions; within 1 % of the optimum in "
        f"{100 * rivals['near']:.0f} % of a set or more, worst {rivals['max_ratio']:.2f} ×; "
        f"{low:.1f} to {high:.1f} × the exact planner's time"
    )
    if solved < asked:
        return Verdict(Outcome.FAILS, effect, "some questions stay without a path")
    if low <= 1:
        return Verdict(Outcome.HOLDS, effect, "as good as the exact planner, and no slower")
    reason = "adequate, with our completions; but an exact planner is shorter and quicker"
    return Verdict(Outcome.PART, effect, reason)


def _against_nine(found: Any, margin: float, unit: str, factor: float) -> tuple[list[str], str]:
    said = [verdict(low, high, margin) for _, low, high in found]
    ends = min(low for _, low, _ in found), max(high for _, _, high in found)
    counts = ", ".join(f"{said.count(one)} {one}" for one in dict.fromkeys(said))
    low, high = (factor * end for end in ends)
    return said, f"against nine laws: {counts}; differences within [{low:.2f}, {high:.2f}] {unit}"


def _no_better(said: list[str], effect: str, good: str) -> Verdict:
    if set(said) == {"smaller"}:
        return Verdict(Outcome.HOLDS, effect, "ahead of all nine rivals")
    if "larger" not in said:
        return Verdict(Outcome.PART, effect, f"{good}, but so do rivals that are told the same")
    return Verdict(Outcome.FAILS, effect, "behind a rival that is told the same")


@_rule
def robust(comparison: dict[str, Any]) -> Verdict:
    """Three times all that disturbs: what touches an obstacle, and the error beside the rivals'."""
    hits, rms = comparison["hits"], comparison["rms_mm"]["harsh"]
    said, text = _against_nine(comparison["harsh"], NO_DIFFERENCE, "mm", 1000)
    effect = (
        f"RMS {rms:.1f} mm, {100 * hits.share:.1f} % [{100 * hits.low:.1f}, "
        f"{100 * hits.high:.1f}] touch an obstacle; {text}"
    )
    if hits.low > 0.05:
        return Verdict(Outcome.FAILS, effect, "too many runs touch an obstacle")
    return _no_better(said, effect, "it stands three times the disturbance, with an observer")


@_rule
def stable(comparison: dict[str, Any]) -> Verdict:
    """Starts 50 mm and 60 degrees off."""
    settled = comparison["settled"]
    effect = f"{100 * settled:.1f} % of starts up to 50 mm and 60° off settle within {LATEST:.0f} s"
    if settled == 1:
        reason = "assumes starts nearby and tuned gains; from farther off see “tend to zero”"
        return Verdict(Outcome.ASSUMED, effect, reason)
    return Verdict(Outcome.PART if settled > 0.9 else Outcome.FAILS, effect, "some do not settle")


@_rule
def fast_response(comparison: dict[str, Any]) -> Verdict:
    """Settling times from far starts."""
    said, text = _against_nine(comparison["settling"], NO_TIME, "s", 1)
    effect = f"settles in {comparison['settles_in_s']:.2f} s; {text}"
    return _no_better(said, effect, "it settles soon")


@_rule
def good_transient(comparison: dict[str, Any]) -> Verdict:
    """Errors from far starts."""
    said, text = _against_nine(comparison["far"], NO_DIFFERENCE, "mm", 1000)
    effect = f"RMS {comparison['rms_mm']['far']:.1f} mm from far starts; {text}"
    return _no_better(said, effect, "it comes back well")


@_rule
def good_tracking(comparison: dict[str, Any]) -> Verdict:
    """The error under the usual disturbance."""
    rms = comparison["rms_mm"]["usual"]
    _, text = _against_nine(comparison["usual"], NO_DIFFERENCE, "mm", 1000)
    effect = f"RMS {rms:.1f} mm at the usual disturbance; {text}"
    if rms < FOLLOWS_MM:
        return Verdict(Outcome.ASSUMED, effect, "assumes gains that we tuned: none are published")
    return Verdict(Outcome.FAILS, effect, "a tenth of the robot's diameter off, or more")


@_rule
def error_remains(comparison: dict[str, Any]) -> Verdict:
    """No law brings the error of a disturbed robot to zero."""
    least = comparison["least_rms_mm"]
    effect = f"at least {least:.2f} mm RMS, for all of ten tuned laws"
    if least > 1000 * NO_DIFFERENCE:
        return Verdict(Outcome.HOLDS, effect, "so Fig. 18 shows runs without such a disturbance")
    return Verdict(Outcome.FAILS, effect, "a law removes it")


@_rule
def fuzzy_is_slow(steps: dict[str, Any]) -> Verdict:
    """Time of a step of a fuzzy law over the sliding mode's."""
    ratio = steps["fuzzy"]
    effect = f"a step takes {ratio:.1f} times the sliding mode's, {steps['fuzzy_us']:.0f} µs"
    if ratio > MUCH_SLOWER:
        return Verdict(Outcome.HOLDS, effect, "clearly slower")
    return Verdict(Outcome.FAILS, effect, "hardly slower, on a computer of today")


@_rule
def pid_unstable(noise: dict[str, Any]) -> Verdict:
    """Eight times the noise of the sensors, for a tuned PID and for the paper's law."""
    low, middle, high = noise["growth"]["Pid"]
    _, ours, most = noise["growth"]["SlidingMode"]
    effect = (
        f"error × {middle:.1f} [{low:.1f}, {high:.1f}] with eight times the noise, "
        f"{noise['noisy_mm']['Pid']:.1f} mm; sliding mode × {ours:.1f}"
    )
    if low > most:
        return Verdict(Outcome.HOLDS, effect, "the PID suffers more than the sliding mode")
    reason = "a tuned PID that reads its derivative off the heading stands the noise as well"
    return Verdict(Outcome.FAILS, effect, reason)


@_rule
def delays_chatter(chatter: dict[str, Any]) -> Verdict:
    """A law that switches, without delay and with one."""
    at_once, late = chatter["sign"], chatter["sign_late"]
    effect = f"sign: {at_once:.2f} m/s² without delay, {late:.2f} with {chatter['delay_ms']:.0f} ms"
    if at_once < 2 * chatter["sat"]:
        return Verdict(Outcome.HOLDS, effect, "no delay, no chattering")
    reason = "it chatters without: to hold a command for a time step is itself a delay"
    return Verdict(Outcome.PART, effect, reason)


@_rule
def saturation_calms(chatter: dict[str, Any]) -> Verdict:
    """What sat is for."""
    sat, sign = chatter["sat"], chatter["sign"]
    effect = f"roughness {sat:.3f} m/s² with sat, {sign:.2f} with sign"
    if sat < sign / 2:
        return Verdict(Outcome.HOLDS, effect, "the wheels are far calmer")
    return Verdict(Outcome.FAILS, effect, "the wheels are no calmer")


def _near_and_far(driven: dict[str, Any]) -> str:
    low, high = sorted(driven["far"])
    return (
        f"{driven['near_mm']:.2f} mm at the end from 14 mm off; back from {100 * low:.0f} to "
        f"{100 * high:.0f} % of {driven['starts']} starts within ±0.6 m"
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
def drives_clear(driven: dict[str, Any]) -> Verdict:
    """Driven tracks of 15(a) and 16(b)."""
    gap = driven["gap_mm"]
    effect = f"{gap:.1f} mm between the robot and the nearest obstacle"
    if gap >= 0:
        return Verdict(Outcome.ASSUMED, effect, "assumes our sizes, gains and a start nearby")
    return Verdict(Outcome.FAILS, effect, "the robot touches an obstacle")


@_rule
def error_units(figures: dict[str, Any]) -> Verdict:
    """Which units of the errors fit what is printed on Figs 17 to 19."""
    fit = figures["units"]
    effect = f"{' and '.join(fit) or 'no unit'} of m, cm, mm fit both figures, with rad"
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
    effect = f"Fig. 19 lasts {low:.0f} and {high:.0f} times as long: {hours:.0f} hours or more"
    if high <= 2:
        return Verdict(Outcome.HOLDS, effect, "both figures last alike")
    return Verdict(Outcome.FAILS, effect, "not seconds, as its axis says; time steps would fit")
