"""Notebook 15: what its sentences say is what its numbers say."""

import numpy as np
import pytest
from lessons import lesson

from freeseg.studies import stress
from freeseg.studies.splitting import lowest_level
from freeseg.studies.statistics import share

STEM = "15_stress_with_monte_carlo"
STORED = stress.load_stress()


def test_margins_are_twice_the_shortfalls():
    margins = lesson(STEM, "margins")
    for law in ("SlidingMode", "Pid"):
        found = margins(law, 1e-3)
        tails = [tail for (name, _), tail in STORED.tails.items() if name == law]
        assert len(found) == len(tails) == len(stress.rare_courses())
        for (margin, low, high), tail in zip(found, tails, strict=True):
            place = np.searchsorted(tail.levels, margin / 2)
            assert tail.share[place] <= 1e-3 <= tail.share[place - 1]
            assert low < margin < high


def test_what_the_first_screen_says():
    """Less for the sliding mode on each course, and the MPC between the two on its own."""
    margins = lesson(STEM, "margins")
    (ours, *_, most), (pid, least, _), (mpc, low, high) = (
        np.array(margins(law, 1e-3)).T for law in ("SlidingMode", "Pid", "Mpc")
    )
    assert (most < least).all()
    assert np.round(1000 * np.array([ours.min(), ours.max()])).tolist() == [6, 12]
    assert np.round(1000 * np.array([pid.min(), pid.max()])).tolist() == [10, 19]
    assert most[1] < low[0] < mpc[0] < high[0] < least[1]
    for found in (ours, pid):
        assert 1.5 < found.max() / found.min() < 2.5


def test_a_plan_made_anew_is_touched_as_often_as_was_said():
    count_contacts = lesson(STEM, "count_contacts")
    for probability in (0.1, 0.01, 1e-3):
        margin = 2 * lowest_level(STORED.tails["Pid", 1], probability)
        _, low, high = count_contacts(margin)
        assert low <= probability <= high


def test_shares_begin_with_the_usual_strength():
    shares = lesson(STEM, "shares")
    usual = STORED.counts["Pid"]["nominal"].failed[: stress.COUNTED_STRONG]
    for cause in stress.CAUSES:
        found = shares(cause)["PID"]
        assert len(found) == 1 + len(stress.STRENGTHS)
        assert found[0].share == usual.mean()
        assert [one.share for one in found[1:]] == pytest.approx(
            STORED.counts["Pid"][cause].failed.mean(0)
        )


def test_what_the_text_says_of_causes():
    """The delay most, then the start and slip; noise and its like hardly ever."""
    shares = lesson(STEM, "shares")
    last = {cause: [found[-1].share for found in shares(cause).values()] for cause in stress.CAUSES}
    assert min(last["delay"]) > 0.9
    assert 0.05 < min(last["start"]) <= max(last["start"]) < 0.6
    assert 0.02 < min(last["slip"]) <= max(last["slip"]) < 0.3
    for cause in ("noise", "slip_fluctuation", "wheel_base"):
        assert max(last[cause]) < 0.05
    fourfold = [found[2].share for found in shares("delay").values()]
    twofold = [found[1].share for found in shares("delay").values()]
    assert min(fourfold) > 0.5
    assert max(twofold) < 0.05


def test_what_the_text_says_of_pairs():
    compare, pairs = lesson(STEM, "compare", "pairs")
    usual = [compare("nominal", 0, *pair) for pair in pairs]
    assert {(one.verdict, one.runs) for one in usual} == {("equivalent", 296)}
    strongest = [compare(cause, 2, *pair) for cause in stress.CAUSES for pair in pairs]
    assert {one.verdict for one in strongest} == {"undecided"}
    ours, _, pid = (compare("delay", 1, *pair) for pair in pairs)
    assert ours.low[-1] > 0
    assert pid.high[-1] < 0
    assert ours.verdict == pid.verdict == "undecided"


def test_splitting_is_too_sure_of_the_line_that_bends():
    heights, tail = lesson(STEM, "heights", "tail")
    seen = [(heights > level).mean() for level in (0.003, 0.004, 0.005, 0.006)]
    places = [np.argmin(np.abs(tail.levels - level)) for level in (0.003, 0.004, 0.005, 0.006)]
    assert (seen > tail.share[places]).all()
    assert share(int((heights > 0.004).sum()), len(heights)).low > tail.high[places[1]]


def test_splitting_keeps_what_the_text_promises():
    for truth, found in STORED.checked.items():
        share, low, high, runs = found.T
        covered = ((low <= truth) & (truth <= high)).mean()
        # Of 200 repeats, 95 % give or take 3 standard errors.
        assert 0.9 <= covered <= 1
        assert abs(share.mean() / truth - 1) < 0.05
        assert runs.mean() <= 1e5
        assert share.std() / truth <= 0.1


def test_the_delay_decides():
    for law, (first, total) in STORED.sobol.items():
        order = np.argsort(-total[0])
        assert stress.CAUSES[order[0]] == "delay", law
        assert first[0, order[0]] > 0.8
        assert total[0, order[1]] < 0.1
