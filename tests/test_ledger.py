"""The ledger: every verdict has evidence, and flips with it and with nothing else."""

import inspect
import re
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
import yaml
from export_ledger import exports

import freeseg as fs
from freeseg.data import DATA
from freeseg.studies import comparing, ledger, ledger_evidence, ledger_export, moving
from freeseg.studies.ledger_evidence import (
    FAR,
    HARSH,
    OUR_LAW,
    SOURCES,
    USUAL,
)
from freeseg.studies.ledger_rules import CLAIM_RULES, Outcome

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module", autouse=True)
def _compare_once():
    """Intervals of the same runs are computed once, however many mutations leave these alone."""
    known, against = {}, comparing.against

    def remembered(values, law):
        key = law, *((name, one.tobytes()) for name, one in values.items())
        if key not in known:
            known[key] = against(values, law)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparing, "against", remembered)
        yield


@pytest.fixture(scope="module")
def claims():
    return ledger.load_claims()


@pytest.fixture(scope="module")
def loaded():
    return {name: source.load() for name, source in SOURCES.items()}


@pytest.fixture(scope="module")
def evidence(loaded):
    return ledger.load_evidence(loaded)


@pytest.fixture(scope="module")
def judged(claims, evidence):
    return ledger.judge_claims(claims, evidence)


def test_every_claim_has_evidence_a_verdict_and_a_reason(judged):
    assert 40 <= len(judged) <= 70
    assert len({one.claim.id for one in judged}) == len(judged)
    for claim, verdict in judged:
        assert claim.evidence, claim.id
        assert verdict.outcome in Outcome
        assert verdict.effect
        assert verdict.reason
        if verdict.outcome is Outcome.ASSUMED:
            assert "assumes" in verdict.reason, claim.id
        assert claim.notebooks
        for stem in claim.notebooks:
            assert (ROOT / "notebooks" / f"{stem}.ipynb").exists()
        assert len(claim.quotation.split()) <= 20
        assert 5 <= len(claim.meaning.split()) <= 25, claim.id
        # Who reads one line alone is told how much, of what.
        assert re.search(r"\d", verdict.effect), claim.id


def test_nothing_lies_idle(claims):
    assert {claim.rule for claim in claims} == set(CLAIM_RULES)
    assert {name for claim in claims for name in claim.evidence} == set(SOURCES)
    assert {claim.kind for claim in claims} == set(ledger.CLAIM_KINDS)
    assert [claim.section for claim in claims] == sorted(
        (claim.section for claim in claims), key=ledger.PARTS.index
    )


def test_a_rule_takes_what_its_claims_name(claims):
    for claim in claims:
        assert len(inspect.signature(CLAIM_RULES[claim.rule]).parameters) == len(claim.evidence)


def test_every_verdict_is_given(judged):
    assert {one.verdict.outcome for one in judged} == set(Outcome)


def every_row(**values):
    """A mutation of rows: these columns, in each."""
    return lambda rows: [row | values for row in rows]


def where(column, value, **values):
    """A mutation of the rows that have a value."""
    return lambda rows: [row | values if row[column] == value else row for row in rows]


def number(name, value):
    """A mutation of one entry of a dict."""
    return lambda found: found | {name: value}


def law(cell, key, value):
    """A mutation of the comparison: what is stored of the paper's law in one cell."""

    def mutate(runs):
        changed = deepcopy(runs[cell])
        changed[key][OUR_LAW] = np.full_like(changed[key][OUR_LAW], value)
        return runs | {cell: changed}

    return mutate


def failing(law, cause):
    """A mutation of the stress study: all runs of a law with a cause touch an obstacle."""

    def mutate(stored):
        found = stored.counts[law][cause]
        touching = found._replace(gap=np.full_like(found.gap, -0.01))
        changed = stored.counts[law] | {cause: touching}
        return stored._replace(counts=stored.counts | {law: changed})

    return mutate


def tails(share):
    """A mutation of the stress study: every level is exceeded with this probability."""

    def mutate(stored):
        ends = {name: np.full_like(stored.tails["Pid", 0].share, share) for name in TAIL_SHARES}
        return stored._replace(
            tails={one: tail._replace(**ends) for one, tail in stored.tails.items()}
        )

    return mutate


TAIL_SHARES = ("share", "low", "high")


def all_laws(kind, value):
    """A mutation of runs that begin on the reference: this error (m), of every law."""
    return lambda found: {
        law: one | {kind: np.full_like(one[kind], value)} for law, one in found.items()
    }


def swings(**values):
    """A mutation of how far the heading swings (rad), by the switching function."""

    def mutate(found):
        swing = {key: values.get(key[0], one) for key, one in found["swing"].items()}
        return found | {"swing": swing}

    return mutate


def mild_sensors(found):
    """No law minds a sensor that reads too much, nor a derivative by differences the noise."""
    noise = dict.fromkeys(found["noise"], found["noise"]["PID"])
    return {"noise": noise, "gain": {law: 0 * one for law, one in found["gain"].items()}}


#: What is done to each source, so that between them all of its verdicts flip.
MUTATIONS = {
    "tables": [
        lambda rows: rows[:-1],
        # With Table 5 half as wide, equal discs would do.
        lambda rows: [
            row | {"x_mm": row["x_mm"] / 2, "y_mm": row["y_mm"] / 2} if row["table"] == 5 else row
            for row in rows
        ],
    ],
    "cases": [lambda rows: [rows[0] | {"goal_x_mm": 0.0}, *rows[1:]], lambda rows: rows[:1]],
    "segments": [
        lambda lengths: {k: [0.1] * 6 for k in lengths},
        lambda lengths: {k: [1.0] * 6 for k in lengths},
        lambda lengths: lengths | {1: [0.143, *lengths[1][1:]]},
        lambda lengths: {k: [1.0] * 5 for k in lengths},
    ],
    "sizes": [
        every_row(literal=14),
        every_row(greedy=0, greedy_optimal=0),
        every_row(optimal=16),
        every_row(greedy=16, greedy_optimal=16),
        every_row(as_told=1),
        every_row(solved=15),
    ],
    "radii": [
        # An R_D with which each case is solved that has a turning point at all.
        lambda rows: [row | {"solved": row["safe"] and row["radius"] > 0.1} for row in rows],
    ],
    "planned": [
        every_row(clearance=0.07),
        every_row(clearance=0.2),
        every_row(kinds=["straight"], group=False),
        lambda rows: [row | {"widest": row["length"]} for row in rows],
        every_row(corner=0.1),
    ],
    "random_worlds": [where("rule", "completed", solved=1)],
    "orders": [every_row(safety_distances=1, length_distances=2)],
    "rivals": [
        where("rival", "paper, completed", ms=1000.0),
        where("rival", "paper, completed", ms=0.1),
        where("rival", "paper, completed", arrives=False),
        where("rival", "paper, length first", ms=1000.0),
    ],
    "comparison": [
        law(HARSH, "position_rms_m", 1.0),
        law(HARSH, "hit", 1.0),
        law(FAR, "position_rms_m", 1.0),
        law(FAR, "settling_time_s", np.inf),
        law(USUAL, "position_rms_m", 1.0),
    ],
    "stress": [
        failing("SlidingMode", "nominal"),
        failing("Pid", "noise"),
        # No margin would be wide enough; the one that we took would be.
        tails(0.5),
        tails(1e-6),
    ],
    "movers": [
        # Nobody has to look at movers.
        where("method", moving.BLIND, outcome="arrived", arrival_s=20.0),
    ],
    # A rival is earlier than what is proved to be the earliest.
    "crossings": [where("proved", 1, grid=0.9)],
    "tracker_steps": [
        where("tracker", "Fuzzy", median_us=1e4),
        where("tracker", "Fuzzy", median_us=30.0),
    ],
    # Without the robots that only centimetres fit.
    "figures": [lambda rows: [row for row in rows if row["x"] <= 0.0005]],
    "equations": [
        *(number(name, 1.0) for name in ("1", "2", "5", "straight", "7", "8", "12", "9")),
        number("unit", 0.0),
        number("singular", 0.0),
    ],
    "driven": [
        lambda runs: {k: run | {"far_ends": 0 * run["far_ends"]} for k, run in runs.items()},
        lambda runs: {k: run | {"gap": -0.01} for k, run in runs.items()},
        # For a while the robot is 20 mm off.
        lambda runs: {
            k: run | {"near": np.c_[run["near"], [[6.0, 60.0], [0.02, 1e-6]]]}
            for k, run in runs.items()
        },
    ],
    "sensors": [
        mild_sensors,
        lambda found: found | {"noise": found["noise"] | {"PID": np.array([1e-3, 0.1])}},
    ],
    "chatter": [
        # No swing by a delay, and as much of it without.
        swings(sign=0.0),
        swings(sign=0.01, sat=0.001),
        lambda found: found | {"rough": dict.fromkeys(found["rough"], np.ones(16))},
    ],
    "remains": [all_laws("disturbed", 1e-5), all_laws("calm", 1e-3)],
    "axes": [lambda ends: ends | {"Fig. 19": ends["Fig. 18"]}],
}


def flips(name, mutate, loaded, claims, evidence, judged):
    """Ids of the claims whose verdict changes with one source."""
    changed = evidence | {name: SOURCES[name].digest(mutate(loaded[name]))}
    again = ledger.judge_claims(claims, changed)
    return {
        before.claim.id
        for before, after in zip(judged, again, strict=True)
        if before.verdict.outcome != after.verdict.outcome
    }


@pytest.mark.parametrize("name", SOURCES)
def test_a_changed_result_flips_exactly_the_verdicts_that_depend_on_it(
    name, loaded, claims, evidence, judged
):
    found = [flips(name, one, loaded, claims, evidence, judged) for one in MUTATIONS[name]]
    assert all(found), "a mutation that nothing notices"
    assert set.union(*found) == {claim.id for claim in claims if name in claim.evidence}


@pytest.mark.parametrize("name", ["movers", "crossings"])
@pytest.mark.parametrize("half", [0, 1])
def test_a_verdict_does_not_hang_on_which_scenes_were_drawn(
    name, half, loaded, claims, evidence, judged
):
    scene = "scene" if name == "movers" else "seed"

    def some(rows):
        return [row for row in rows if row[scene] // 50 % 2 == half]

    assert 0 < len(some(loaded[name])) < len(loaded[name])
    assert not flips(name, some, loaded, claims, evidence, judged)


def test_evidence_is_given_as_it_is_loaded(loaded, evidence, monkeypatch):
    monkeypatch.setattr(ledger, "SOURCES", {name: SOURCES[name] for name in ("sizes", "planned")})
    few = {name: loaded[name] for name in ("sizes", "planned")}
    before = deepcopy(few)
    assert ledger.load_evidence(few) == {name: evidence[name] for name in few}
    assert few == before


def test_the_words_of_a_quantifier_are_judged_by_what_they_speak_of(claims):
    """“Always” of all worlds, of Fig. 17, and a guarantee: none by a rule for a mean."""
    rules = {claim.id: claim.rule for claim in claims if "always" in claim.quotation}
    assert rules == {
        "C08": "error_remains",
        "C52": "always_follows",
        "C58": "always_safely",
    }


def test_every_file_that_evidence_reads_is_named(loaded, monkeypatch):
    for source in SOURCES.values():
        assert all((DATA / name).is_file() for name in source.files), source.where
    read, plain = set(), Path.open

    def noted(self, *how, **more):
        read.add(self.name)
        return plain(self, *how, **more)

    monkeypatch.setattr(Path, "open", noted)
    for name in ("cases", "orders", "tracker_steps", "crossings", "figures", "random_worlds"):
        read.clear()
        SOURCES[name].load()
        assert read - set(ledger_evidence.PAPER_FILES) <= set(SOURCES[name].files), name


def test_undecidable_says_why(judged):
    for claim, verdict in judged:
        if verdict.outcome is Outcome.OPEN:
            assert len(verdict.reason.split()) > 5, claim.id


def test_counts_are_of_all_claims(judged):
    counts = ledger.count_outcomes(judged)
    assert list(counts) == list(ledger.CLAIM_KINDS)
    assert sum(one.total() for one in counts.values()) == len(judged)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("safe_paths,planned", "no_rule,planned", r"claims.csv, row 2: rule is 'no_rule'"),
        ("safe_paths,planned", "safe_paths,hearsay", r"row 2: evidence is 'hearsay'; give one of"),
        ("performance", "rumour", r"row 2: kind is 'rumour'; give one of definition"),
        ("C02,abstract", "C02,7", r"row 3: section is '7'"),
        ("C02,", "C01,", r"row 3: id C01 is taken"),
    ],
)
def test_a_broken_ledger_is_refused(tmp_path, old, new, named):
    text = (DATA / "claims.csv").read_text(encoding="utf-8")
    file = tmp_path / "claims.csv"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(fs.InvalidData, match=named):
        ledger.load_claims(file)


def test_missing_evidence_is_named(claims, evidence):
    with pytest.raises(fs.InvalidParameter, match="evidence has no 'axes'; give what"):
        ledger.judge_claims(claims, {k: v for k, v in evidence.items() if k != "axes"})
    with pytest.raises(fs.InvalidParameter, match="loaded is 'hearsay'"):
        ledger.load_evidence({"hearsay": 1})
    with pytest.raises(fs.InvalidParameter, match="claims"):
        ledger.judge_claims(["C01"], evidence)


def test_the_committed_exports_are_what_the_script_writes(judged):
    for name, text in exports(judged).items():
        assert (ROOT / name).read_text(encoding="utf-8") == text, "run tests/export_ledger.py"


def test_codecheck_follows_what_an_unregistered_check_can_follow():
    text = (ROOT / "codecheck.yml").read_text(encoding="utf-8")
    found = yaml.safe_load(text)
    assert text.startswith("---\n")
    assert found["version"] == "https://codecheck.org.uk/spec/config/2.0/"
    assert found["paper"]["title"]
    assert len(found["paper"]["authors"]) == 3
    assert all(one["name"] for one in found["paper"]["authors"] + found["codechecker"])
    assert re.fullmatch(r"https://doi\.org/10\.\S+", found["paper"]["reference"])
    assert found["summary"]
    assert not re.search("FIXME|TODO|XXXX", text)
    for one in found["manifest"]:
        assert (ROOT / one["file"]).is_file()
        assert one["comment"]
    assert "not by an independent codechecker" in found["summary"]
    # What decides is on the list: files that drives are made from, rules, the page itself.
    listed = {one["file"] for one in found["manifest"]}
    assert listed >= {f"data/{file}" for source in SOURCES.values() for file in source.files}
    assert listed >= {ledger_export.PAGE, ledger_export.CLAIMS, *ledger_export.JUDGES}
    # These only a registered check has, and none is made up.
    assert not {"certificate", "report"} & found.keys()


def test_the_crate_is_closed(judged):
    crate = ledger_export.as_ro_crate(judged)
    graph = {one["@id"]: one for one in crate["@graph"]}
    assert len(graph) == len(crate["@graph"])
    assert crate["@context"] == "https://w3id.org/ro/crate/1.2/context"
    assert graph["ro-crate-metadata.json"]["about"] == {"@id": "./"}
    assert {"name", "description", "datePublished", "license"} <= graph["./"].keys()

    def targets(value):
        if isinstance(value, list):
            for one in value:
                yield from targets(one)
        elif isinstance(value, dict):
            yield value["@id"]

    for one in graph.values():
        for key, value in one.items():
            if key != "conformsTo":
                assert set(targets(value)) <= graph.keys(), (one["@id"], key)
    assert graph["./"]["version"] == fs.__version__
    ratings = [one for one in crate["@graph"] if one["@type"] == "Rating"]
    assert {one["name"] for one in ratings} == set(Outcome)
    assert not any("ratingValue" in one for one in ratings)
    for one in graph["./"]["hasPart"]:
        assert (ROOT / one["@id"]).is_file()


def test_the_law_that_is_judged_is_the_papers():
    assert OUR_LAW in comparing.LAWS.values()
    assert {USUAL, FAR, HARSH} <= set(comparing.COMPARED)
