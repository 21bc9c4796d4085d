"""The ledger for other programs: as a CODECHECK configuration and as an RO-Crate."""

from collections import Counter
from collections.abc import Iterable
from typing import Any

from freeseg import checks
from freeseg.studies.ledger import Judged
from freeseg.studies.ledger_evidence import SOURCES
from freeseg.studies.ledger_rules import Outcome

#: The paper, and those who checked it.
PAPER = {
    "title": "Robot Path Planning with Avoiding Obstacles in Known Environment Using Free Segments "
    "and Turning Points Algorithm",
    "authors": ("Imen Hassani", "Imen Maalej", "Chokri Rekik"),
    "reference": "https://doi.org/10.1155/2018/2163278",
}
CHECKERS = "The freeseg authors"

#: What judges, besides the evidence of each claim; and the page that shows all verdicts.
JUDGES = tuple(
    f"freeseg/studies/ledger{part}.py"
    for part in ("", "_drives", "_equations", "_evidence", "_rules")
)
PAGE, CLAIMS = "notebooks/17_judge_the_claims.ipynb", "data/claims.csv"

#: Version and year of this collection.
VERSION, PUBLISHED = "1.0.0", "2026"

#: Versions of the specifications that are followed.
CODECHECK = "https://codecheck.org.uk/spec/config/2.0/"
RO_CRATE = "https://w3id.org/ro/crate/1.2"

#: Licences of the package and of the paper's words and numbers.
MIT, CC_BY = "https://spdx.org/licenses/MIT", "https://creativecommons.org/licenses/by/4.0/"


def _checked(judged: Iterable[Judged]) -> list[Judged]:
    found: list[Judged] = checks.instances("judged", judged, Judged, "what judge_claims returns")
    return found


def _files(one: Judged) -> list[str]:
    """The notebooks that show the evidence of a claim, and the files that it is made from."""
    data = {f"data/{file}" for name in one.claim.evidence for file in SOURCES[name].files}
    return [*(f"notebooks/{stem}.ipynb" for stem in one.claim.notebooks), *sorted(data)]


def _summary(judged: list[Judged]) -> str:
    counts = Counter(one.verdict.outcome for one in judged)
    said = "; ".join(f"{outcome}: {counts[outcome]}" for outcome in Outcome)
    return (
        f"{len(judged)} claims of the paper, judged by computation with freeseg {VERSION}. "
        f"{said}. This is a check by those who wrote the code, not by an independent codechecker; "
        "no certificate was registered, so that there is no identifier and no report of one."
    )


def as_codecheck(judged: Iterable[Judged]) -> dict[str, Any]:
    """The ledger as ``codecheck.yml``, specification 2.0.

    Parameters
    ----------
    judged : iterable of Judged
        From `ledger.judge_claims`.

    Returns
    -------
    dict
        Lists, dicts and texts only. What a certificate of the CODECHECK register would
        add is not in it: ``certificate``, ``report``, and ORCIDs.

    Raises
    ------
    InvalidParameter
        For what are no judged claims.
    """
    judged = _checked(judged)
    shown: dict[str, list[str]] = {}
    for one in judged:
        for file in _files(one):
            shown.setdefault(file, []).append(f"{one.claim.id} {one.verdict.outcome}")
    return {
        "version": CODECHECK,
        "paper": {
            "title": PAPER["title"],
            "authors": [{"name": name} for name in PAPER["authors"]],
            "reference": PAPER["reference"],
        },
        "codechecker": [{"name": CHECKERS}],
        "summary": _summary(judged),
        "manifest": [
            {"file": PAGE, "comment": "all verdicts"},
            {"file": CLAIMS, "comment": "all claims, and what each is judged by"},
            *({"file": file, "comment": "judges all claims"} for file in JUDGES),
            *({"file": file, "comment": "; ".join(shown[file])} for file in sorted(shown)),
        ],
    }


def as_ro_crate(judged: Iterable[Judged]) -> dict[str, Any]:
    """The ledger as ``ro-crate-metadata.json``, RO-Crate 1.2.

    Parameters
    ----------
    judged : iterable of Judged
        From `ledger.judge_claims`.

    Returns
    -------
    dict
        Each claim is a ``Claim`` of schema.org, each verdict a ``ClaimReview``.

    Raises
    ------
    InvalidParameter
        For what are no judged claims.
    """
    judged = _checked(judged)
    files = sorted({file for one in judged for file in _files(one)} | {PAGE, CLAIMS, *JUDGES})
    crate = _collection_and_paper(judged, files)
    for file in files:
        code = ["File", "SoftwareSourceCode"] if file.endswith(".py") else "File"
        crate.append({"@id": file, "@type": code, "name": file.rpartition("/")[2]})
    # A verdict has no number: "cannot be decided" is neither better nor worse than the others.
    crate += [_rating(outcome) | {"@type": "Rating", "name": str(outcome)} for outcome in Outcome]
    for one in judged:
        crate += _claim_and_review(one)
    return {"@context": f"{RO_CRATE}/context", "@graph": crate}


def _collection_and_paper(judged: list[Judged], files: list[str]) -> list[dict[str, Any]]:
    """What the crate is, what it is about, and whose it is."""
    people = [{"@id": f"#{name.replace(' ', '-')}"} for name in PAPER["authors"]]
    crate: list[dict[str, Any]] = [
        {
            "@id": "ro-crate-metadata.json",
            "@type": "CreativeWork",
            "conformsTo": {"@id": RO_CRATE},
            "about": {"@id": "./"},
        },
        {
            "@id": "./",
            "@type": "Dataset",
            "name": "freeseg",
            "version": VERSION,
            "description": _summary(judged),
            "datePublished": PUBLISHED,
            "license": {"@id": MIT},
            "author": {"@id": "#freeseg"},
            "about": {"@id": PAPER["reference"]},
            "hasPart": [{"@id": file} for file in files],
            "mentions": [{"@id": f"#{one.claim.id}-verdict"} for one in judged],
        },
        {"@id": MIT, "@type": "CreativeWork", "name": "MIT License"},
        {"@id": CC_BY, "@type": "CreativeWork", "name": "Creative Commons Attribution 4.0"},
        {"@id": "#freeseg", "@type": "Organization", "name": CHECKERS},
        {
            "@id": PAPER["reference"],
            "@type": "ScholarlyArticle",
            "name": PAPER["title"],
            "author": people,
            "license": {"@id": CC_BY},
            "datePublished": "2018-06-11",
        },
    ]
    names = zip(people, PAPER["authors"], strict=True)
    return crate + [one | {"@type": "Person", "name": name} for one, name in names]


def _rating(outcome: Outcome) -> dict[str, str]:
    return {"@id": f"#{outcome.replace(' ', '-')}"}


def _claim_and_review(one: Judged) -> list[dict[str, Any]]:
    claim, verdict = one
    return [
        {
            "@id": f"#{claim.id}",
            "@type": "Claim",
            "name": f"{claim.id}, {claim.place}",
            "text": claim.quotation,
            "description": claim.meaning,
            "additionalType": claim.kind,
            "appearance": {"@id": PAPER["reference"]},
        },
        {
            "@id": f"#{claim.id}-verdict",
            "@type": "ClaimReview",
            "name": f"{claim.id}: {verdict.outcome}",
            "itemReviewed": {"@id": f"#{claim.id}"},
            "claimReviewed": claim.quotation,
            "reviewBody": f"{verdict.effect}. {verdict.reason}",
            "reviewRating": _rating(verdict.outcome),
            "author": {"@id": "#freeseg"},
            "isBasedOn": [{"@id": file} for file in (*_files(one), *JUDGES)],
        },
    ]
