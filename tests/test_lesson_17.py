"""What the page of verdicts says is what the verdicts are, and its picture counts them."""

import re

import matplotlib.pyplot as plt
import nbformat
import pytest
from lessons import lesson
from refresh_notebooks import NOTEBOOKS

import freeseg as fs
from freeseg.plotting import plot_outcomes
from freeseg.plotting.ledger import OUTCOME_COLORS
from freeseg.studies import ledger
from freeseg.studies.ledger_rules import Outcome

STEM = "17_judge_the_claims"


@pytest.fixture(scope="module")
def page():
    return nbformat.read(NOTEBOOKS / f"{STEM}.ipynb", as_version=4)


@pytest.fixture(scope="module")
def defined():
    plt.switch_backend("Agg")
    names = ("judged", "by_id", "counts", "flipped", "table")
    return dict(zip(names, lesson(STEM, *names), strict=True))


def test_every_claim_stands_in_one_table(page, defined):
    shown = [defined["table"](section).data for section in ledger.PARTS]
    for claim, verdict in defined["judged"]:
        assert sum(f"| {claim.id} |" in one for one in shown) == 1
        words = verdict.outcome, claim.meaning, claim.quotation
        assert any(all(word in one for word in words) for one in shown)
    called = "".join(cell.source for cell in page.cells if cell.cell_type == "code")
    for section in ledger.PARTS:
        assert f'table("{section}")' in called


def test_what_the_prose_says_of_the_counts(defined):
    counts = defined["counts"]
    assert counts["comparison"][Outcome.HOLDS] == 0
    assert counts["definition"][Outcome.HOLDS] > counts["definition"].total() / 2
    assert counts["performance"][Outcome.ASSUMED] == max(counts["performance"].values())
    open_ones = [one for one in defined["judged"] if one.verdict.outcome is Outcome.OPEN]
    assert [one.claim.rule for one in open_ones].count("as_told") == 1


def test_the_three_findings(defined):
    outcome = {one: judged.verdict.outcome for one, judged in defined["by_id"].items()}
    assert outcome["C58"] is outcome["C60"] is Outcome.ASSUMED
    assert outcome["C59"] is Outcome.FAILS
    assert outcome["C24"] is outcome["C09"] is Outcome.PART
    assert outcome["C15"] is outcome["C10"] is Outcome.OPEN
    assert outcome["C65"] is Outcome.HOLDS
    assert outcome["C63"] is outcome["C19"] is outcome["C64"] is Outcome.ASSUMED
    assert outcome["C06"] is outcome["C14"] is outcome["C05"] is Outcome.PART


def test_the_flip_is_of_the_shortest_path(defined):
    # No number of cases proves the “always” of C59.
    after = {row[0]: row[3] for row in defined["flipped"]}
    assert after == {"C04": Outcome.HOLDS, "C18": Outcome.HOLDS, "C59": Outcome.ASSUMED}


def test_what_the_prose_says_of_the_literal_reading(defined):
    effect = defined["by_id"]["C24"].verdict.effect
    with_radii, with_sizes = re.findall(r"(\d+) to (\d+)", effect.replace("(median 0) ", ""))[::2]
    assert with_radii[0] == with_sizes[0] == "0"
    assert 0 < int(with_sizes[1]) < 16 > int(with_radii[1]) > 0


def test_bars_are_as_long_as_the_counts(defined):
    ax = plot_outcomes(defined["counts"])
    widths = [[bar.get_width() for bar in bars] for bars in ax.containers]
    wanted = [[one[outcome] for one in defined["counts"].values()] for outcome in OUTCOME_COLORS]
    assert widths == wanted
    assert [text.get_text() for text in ax.get_yticklabels()] == list(ledger.CLAIM_KINDS)
    assert set(OUTCOME_COLORS) == set(Outcome)
    plt.close("all")


@pytest.mark.parametrize("counts", [{}, {"definition": 3}, "all"])
def test_what_are_no_counts_is_refused(counts):
    with pytest.raises(fs.InvalidParameter, match="give what count_outcomes"):
        plot_outcomes(counts)
