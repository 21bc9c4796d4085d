"""The ledger: what the paper claims, and what evidence says of each claim.

``data/claims.csv`` has the claims; of each, which rule judges it by what evidence. It has no
verdict: `judge_claims` computes all of them from `load_evidence`, and `ledger_export` writes them
for other programs.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any, NamedTuple

from freeseg import checks
from freeseg.data import DATA, read_csv
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.studies.ledger_evidence import SOURCES
from freeseg.studies.ledger_rules import CLAIM_RULES, Outcome, Verdict

#: Kinds of claims.
CLAIM_KINDS = ("definition", "construction", "performance", "comparison", "generality")

#: Parts of the paper, in its order.
PARTS = ("title", "abstract", "1", "2", "3", "4", "5", "6")


class Claim(NamedTuple):
    """A sentence of the paper, or a part of one, that can be checked.

    Attributes
    ----------
    id : str
        Such as ``C01``.
    section : str
        One of `PARTS`.
    place : str
        Equation, figure or section that it stands at.
    kind : str
        One of `CLAIM_KINDS`.
    quotation : str
        A few of the paper's words.
    meaning : str
        What the sentence says, for who has not read the paper.
    rule : str
        Which of `ledger_rules.CLAIM_RULES` judges it.
    evidence : tuple of str
        What the rule is given, of `ledger_evidence.SOURCES`: the verdict depends on
        this and nothing else.
    notebooks : tuple of str
        Stems of the notebooks that show the evidence.
    """

    id: str
    section: str
    place: str
    kind: str
    quotation: str
    meaning: str
    rule: str
    evidence: tuple[str, ...]
    notebooks: tuple[str, ...]


class Judged(NamedTuple):
    """A claim with its verdict."""

    claim: Claim
    verdict: Verdict


def load_claims(file: str | PathLike[str] = DATA / "claims.csv") -> list[Claim]:
    """The claims, in the paper's order.

    Parameters
    ----------
    file : path-like, optional
        See ``data/README.md``.

    Returns
    -------
    list of Claim

    Raises
    ------
    InvalidData
        For a file that cannot be read; for two claims of one id; for a part, a
        kind, a rule or evidence that there is not.
    """
    path = checks.file("file", file)
    claims: list[Claim] = []
    for row in read_csv(path, dict.fromkeys(Claim._fields, str)):
        where = f"{path.name}, row {row.pop('row')}"
        claim = Claim(
            **row | {name: tuple(row[name].split()) for name in ("evidence", "notebooks")}
        )
        known = {"section": PARTS, "kind": CLAIM_KINDS, "rule": CLAIM_RULES}
        given = [(name, getattr(claim, name), known[name]) for name in known]
        given += [("evidence", one, SOURCES) for one in claim.evidence]
        for name, value, choices in given:
            if value not in choices:
                some = ", ".join(map(str, choices))
                raise InvalidData(f"{where}: {name} is {value!r}; give one of {some}")
        if claim.id in {one.id for one in claims}:
            raise InvalidData(f"{where}: id {claim.id} is taken; give another")
        claims.append(claim)
    return claims


def load_evidence(loaded: Mapping[str, Any] | None = None) -> dict[str, dict[str, Any]]:
    """All evidence, as numbers that rules judge by.

    Parameters
    ----------
    loaded : dict, optional
        By name of the source, what takes the place of what it loads.

    Returns
    -------
    dict
        Name of each source to its digest.

    Raises
    ------
    InvalidParameter
        For a source that there is not.
    InvalidData
        For a file that cannot be read.

    Notes
    -----
    A few seconds: what is quick is planned and driven again.
    """
    loaded = {} if loaded is None else loaded
    checks.instance("loaded", loaded, Mapping, "a dict of source to what it loads")  # type: ignore[type-abstract]
    for name in loaded:
        checks.choice("loaded", name, SOURCES)
    return {
        name: source.digest(loaded[name] if name in loaded else source.load())
        for name, source in SOURCES.items()
    }


def judge_claims(
    claims: Iterable[Claim], evidence: Mapping[str, Mapping[str, Any]]
) -> list[Judged]:
    """A verdict on each claim.

    Parameters
    ----------
    claims : iterable of Claim
        From `load_claims`.
    evidence : dict
        From `load_evidence`.

    Returns
    -------
    list of Judged
        In the order given.

    Raises
    ------
    InvalidParameter
        For what are no claims, and where evidence is missing.
    """
    claims = checks.instances("claims", claims, Claim, "what load_claims returns")
    checks.instance("evidence", evidence, Mapping, "what load_evidence returns")  # type: ignore[type-abstract]
    missing = {name for claim in claims for name in claim.evidence} - evidence.keys()
    if missing:
        raise InvalidParameter(
            f"evidence has no {sorted(missing)[0]!r}; give what load_evidence returns"
        )
    return [
        Judged(claim, CLAIM_RULES[claim.rule](*(evidence[name] for name in claim.evidence)))
        for claim in claims
    ]


def count_outcomes(judged: Iterable[Judged]) -> dict[str, Counter[Outcome]]:
    """How often each verdict was given, by kind of claim.

    Parameters
    ----------
    judged : iterable of Judged
        From `judge_claims`.

    Returns
    -------
    dict
        Each of `CLAIM_KINDS` to a count by `Outcome`.

    Raises
    ------
    InvalidParameter
        For what are no judged claims.
    """
    judged = checks.instances("judged", judged, Judged, "what judge_claims returns")
    return {
        kind: Counter(one.verdict.outcome for one in judged if one.claim.kind == kind)
        for kind in CLAIM_KINDS
    }
