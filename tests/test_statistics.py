"""Intervals cover a known truth as often as they say; what follows from them does, too."""

import runpy
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from freeseg.errors import InvalidParameter
from freeseg.studies import statistics
from freeseg.studies.statistics import Difference

REPEATS = 1000


@pytest.fixture
def few(monkeypatch):
    """Fewer resamples than a study takes, so that many studies are quick."""
    monkeypatch.setattr(statistics, "RESAMPLES", 400)


def study(rng, shape, laws=1, interaction=1.0):
    """Runs of laws with mean zero, that depend on each axis, on all of them and on the law."""
    runs = rng.normal(0, interaction, (laws, *shape))
    for axis, length in enumerate(shape):
        sides = [1] * len(shape)
        sides[axis] = length
        # What all laws meet alike, and what each meets alone.
        runs += rng.normal(0, 2, (1, *sides)) + rng.normal(0, 1, (laws, *sides))
    return runs


def test_the_interval_is_that_of_scipys_bootstrap():
    values = np.random.default_rng(3).normal(5, 1, (14, 8))

    def mean(course, robot, axis):
        course, robot = course.astype(int), robot.astype(int)
        return values[course[..., :, None], robot[..., None, :]].mean((-1, -2))

    indices = [np.arange(length) for length in values.shape]
    found = stats.bootstrap(indices, mean, n_resamples=2000, method="percentile", rng=7)
    assert_allclose(statistics.interval(values, 7), found.confidence_interval, rtol=1e-12)


def test_a_replicate_that_is_the_same_everywhere_narrows_nothing():
    values = np.random.default_rng(3).normal(5, 1, (6, 8))
    again = np.repeat(values[..., None], 5, axis=2)
    assert_allclose(statistics.interval(again, 1), statistics.interval(values, 1), rtol=1e-12)


@pytest.mark.parametrize("shape", [(30, 30), (20, 40)])
def test_intervals_of_percentiles_cover_where_there_is_plenty(shape, few):
    rng, covered = np.random.default_rng(8), 0
    for trial in range(REPEATS):
        low, high = statistics.interval(study(rng, shape)[0], trial)
        covered += low <= 0 <= high
    assert 0.93 <= covered / REPEATS <= 0.97


@pytest.mark.parametrize("shape", [(14, 8), (8, 40), (8, 6, 5)])
def test_studentised_intervals_cover_where_there_is_little(shape, few):
    rng, covered, narrow = np.random.default_rng(8), 0, 0
    for trial in range(REPEATS):
        runs = study(rng, shape)[0]
        low, high = statistics.interval(runs, trial, studentised=True)
        covered += low <= 0 <= high
        low, high = statistics.interval(runs, trial)
        narrow += low <= 0 <= high
    assert 0.93 <= covered / REPEATS <= 0.97
    assert narrow < covered


@pytest.mark.parametrize(("laws", "shape"), [(4, (14, 8)), (3, (8, 6, 5))])
def test_all_differences_are_covered_together(laws, shape, few):
    rng, truth = np.random.default_rng(5), np.array([0, 1, 10, 30])[:laws]
    margin, covered, right, better, equivalent = 4, 0, 0, 0, 0
    for trial in range(REPEATS):
        runs = study(rng, shape, laws).T + truth
        found = statistics.differences(dict(enumerate(runs.T)), trial)
        covered += all(d.low <= truth[d.first] - truth[d.second] <= d.high for d in found)
        order = statistics.order(found, margin)
        right += all(truth[a] + margin < truth[b] for a, b in order.better) and all(
            abs(truth[a] - truth[b]) <= margin for a, b in order.equivalent
        )
        better += len(order.better) > 0
        equivalent += len(order.equivalent) > 0
    assert 0.93 <= covered / REPEATS <= 0.97
    # What is said of all pairs errs at most as often as the intervals.
    assert right >= covered
    assert min(better, equivalent) > 0.5 * REPEATS


def test_the_benchmark_of_coverage_prints_a_line_for_each_kind_of_study(few, capsys):
    file = Path(__file__).parent / "benchmarks" / "interval_coverage.py"
    runpy.run_path(str(file))["main"](repeats=2, sizes=[(4, 4)])
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.split()[-4:] == ["4", "laws", "10", "laws"]
    assert [line.split("4 x 4")[1].split()[0] for line in lines] == [
        "all",
        "courses",
        "the",
        "none",
    ]
    shares = [float(share[:-1]) for line in lines for share in line.split()[-4:]]
    assert set(shares) <= {0, 50, 100}


def test_what_all_laws_meet_alike_cancels():
    rng = np.random.default_rng(0)
    common, own = rng.normal(0, 100, (8, 1)), rng.normal(0, 1, (3, 8, 10))
    plain = statistics.differences(dict(zip("abc", own, strict=True)))
    same = statistics.differences(dict(zip("abc", own + common, strict=True)))
    assert_allclose([d[2:] for d in same], [d[2:] for d in plain], atol=1e-10)
    assert [d[:2] for d in plain] == list(combinations("abc", 2))
    for one in plain:
        a, b = ("abc".index(name) for name in one[:2])
        assert one.mean == pytest.approx((own[a] - own[b]).mean())
        assert one.low < one.mean < one.high


def test_the_standard_error_is_that_of_means_of_each_axis():
    values = np.random.default_rng(1).normal(size=(5, 4, 6))
    means = [values.mean(rest) for rest in ((1, 2), (0, 2), (0, 1))]
    by_hand = np.sqrt(sum(one.var(ddof=1) / len(one) for one in means))
    even = [np.full((length, 1), 1 / length) for length in values.shape]
    mean, error = statistics._mean_and_error(values[None], np.ones((1, 1)), even)
    assert_allclose((mean[0, 0], error[0, 0]), (values.mean(), by_hand))


def test_equal_runs_have_no_interval():
    assert statistics.interval(np.full((5, 3), 2.0)) == (2, 2)
    assert statistics.interval(np.full((5, 4), 0.1), studentised=True) == pytest.approx((0.1, 0.1))
    # Two that are the same say nothing of a third.
    rng = np.random.default_rng(2)
    one, other = rng.normal(size=(2, 8, 10))
    with_twin = statistics.differences({"one": one, "twin": one.copy(), "other": other})
    assert with_twin[0] == ("one", "twin", 0, 0, 0)
    assert with_twin[1][2:] == pytest.approx(
        statistics.differences({"one": one, "other": other})[0][2:]
    )


def test_a_pair_that_differs_on_one_course_widens_no_other_beyond_measure():
    rng = np.random.default_rng(4)
    runs = dict(zip("abc", rng.normal(size=(3, 8, 10)), strict=True))
    odd = runs["a"] + (np.arange(8) == 0)[:, None]
    before = statistics.differences(runs)[0]
    after = next(d for d in statistics.differences({**runs, "odd": odd}) if d[:2] == before[:2])
    assert after.high - after.low < 2 * (before.high - before.low)


def test_many_runs_are_taken_in_parts(monkeypatch):
    runs = dict(zip("abcd", np.random.default_rng(4).normal(size=(4, 8, 10, 5)), strict=True))
    whole = statistics.differences(runs)
    monkeypatch.setattr(statistics, "HELD", 100_000)
    assert_allclose([d[2:] for d in statistics.differences(runs)], [d[2:] for d in whole])


def test_a_front_leaves_an_area_to_the_worst():
    front = [(3, 1), (1, 3), (2, 2)]
    assert statistics.hypervolume(front, (4, 4)) == 1 + 2 + 3
    # What is beaten, or beyond the worst, adds nothing.
    assert statistics.hypervolume([*front, (2.5, 3.5), (5, 0.5), (9, 9)], (4, 4)) == 6
    assert statistics.hypervolume([(5, 1)], (4, 4)) == 0


def test_a_function_of_means_is_covered_as_often_as_the_interval_says(few):
    # The ratio of two means, 2 in truth.
    rng, covered = np.random.default_rng(2), 0
    for _ in range(REPEATS // 5):
        runs = study(rng, (8, 6, 5), laws=2) + np.array([40, 20])[:, None, None, None]
        ratio = statistics.linearised(runs, lambda means: means[0] / means[1])
        assert ratio.mean() == pytest.approx(runs[0].mean() / runs[1].mean(), rel=1e-12)
        low, high = statistics.interval(ratio, studentised=True)
        covered += low <= 2 <= high
    assert 0.93 <= covered / (REPEATS // 5) <= 0.99


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (-3, -1.1, "smaller"),
        (-3, -1, "undecided"),
        (-1, 1, "equivalent"),
        (-0.2, 0.1, "equivalent"),
        # Surely larger, but not surely by more than the margin; and the other way round.
        (0.2, 1.5, "undecided"),
        (0.2, 0.5, "equivalent"),
        (1.1, 9, "larger"),
        (-9, 9, "undecided"),
    ],
)
def test_a_verdict_needs_the_whole_interval(low, high, verdict):
    assert statistics.verdict(np.float32(low), high, 1) == verdict


def pair(first, second, low, high):
    return Difference(first, second, (low + high) / 2, low, high)


def test_an_order_says_who_is_better_who_is_equal_and_what_is_open():
    found = [
        pair("a", "b", -5, -2),
        pair("c", "b", 2, 5),
        # Follows from the two above, though these runs alone do not tell.
        pair("a", "c", -9, 0.5),
        pair("d", "a", -0.5, 0.5),
        pair("d", "b", -3, 0.5),
        pair("d", "c", -9, -2),
    ]
    order = statistics.order(found, 1)
    assert set(order.better) == {("a", "b"), ("b", "c"), ("a", "c"), ("d", "c")}
    assert set(order.lines) == {("a", "b"), ("b", "c"), ("d", "c")}
    assert order.equivalent == (("d", "a"),)
    assert order.undecided == (("d", "b"),)


def test_every_pair_has_one_place_in_an_order():
    rng = np.random.default_rng(6)
    for trial in range(20):
        runs = rng.normal(0, 0.3, (7, 6, 5)) + rng.normal(0, 1, (7, 1, 1))
        found = statistics.differences(dict(zip("abcdefg", runs, strict=True)), trial)
        order = statistics.order(found, 0.4)
        placed = [*order.better, *order.equivalent, *order.undecided]
        assert sorted(map(sorted, placed)) == sorted(map(list, combinations("abcdefg", 2)))
        means = {name: run.mean() for name, run in zip("abcdefg", runs, strict=True)}
        assert all(means[first] < means[second] for first, second in order.better)
        assert set(order.lines) <= set(order.better)
        # The lines lead to all that is better, and none of them can be left out.
        assert reached(order.lines) == set(order.better)
        for line in order.lines:
            assert reached(set(order.lines) - {line}) != set(order.better)


def reached(lines):
    """All pairs that lines lead through."""
    found = set(lines)
    while more := {(a, d) for a, b in found for c, d in found if b == c} - found:
        found |= more
    return found


def coverage(runs, true_shares, method):
    """How often an interval of a share covers each true one, summed over all counts."""
    counts = np.arange(runs + 1)
    found = [statistics.share(count, runs, method) for count in counts]
    _, low, high = np.transpose(found)[..., None]
    covers = (low <= true_shares) & (true_shares <= high)
    return (stats.binom.pmf(counts[:, None], runs, true_shares) * covers).sum(0)


def test_intervals_of_shares_are_those_of_the_books():
    # Of no failure in ten runs, both have closed forms.
    square = stats.norm.isf(0.025) ** 2
    assert_allclose(statistics.share(0, 10), (0, 0, square / (10 + square)), atol=1e-12)
    exact = statistics.share(np.int64(0), 10, "clopper-pearson")
    assert_allclose(exact, (0, 0, 1 - 0.025**0.1), atol=1e-12)
    assert statistics.share(10, 10).high == 1


def test_shares_cover_as_often_as_they_say():
    shares = np.linspace(0.02, 0.5, 200)
    wilson, exact = (coverage(60, shares, one) for one in ("wilson", "clopper-pearson"))
    assert 0.93 <= np.mean(wilson) <= 0.97
    assert exact.min() >= 0.95
    # Which is the price: the one is narrower, and not always wide enough.
    assert wilson.min() < 0.95
    assert wilson.mean() < exact.mean()


def failures(rng, courses, robots):
    """Runs that fail on some courses rather than on others, one time in five."""
    chance = stats.beta.rvs(1, 4, size=(courses, 1), random_state=rng)
    return rng.random((courses, robots)) < chance


def test_runs_that_share_a_course_need_the_crossed_bootstrap(few):
    rng, wilson, crossed = np.random.default_rng(0), 0, 0
    for trial in range(REPEATS):
        failed = failures(rng, 30, 20)
        one = statistics.share(int(failed.sum()), failed.size)
        wilson += one.low <= 0.2 <= one.high
        low, high = statistics.interval(failed.astype(float), trial, studentised=True)
        crossed += low <= 0.2 <= high
    assert wilson / REPEATS < 0.75
    assert 0.93 <= crossed / REPEATS <= 0.97


def paired(rng, runs):
    """Differences of what two laws fail, each the mean over robots of a fresh course."""
    chance = rng.beta(1, 4, (2, runs, 1))
    first, second = rng.random((2, runs, 5)) < chance
    return (first.astype(float) - second).mean(-1)


def test_a_sequence_covers_at_all_times_and_a_look_after_every_run_does_not():
    rng, always, looked, runs = np.random.default_rng(0), 0, 0, 1000
    count = np.arange(1, runs + 1)
    for _ in range(REPEATS):
        values = paired(rng, runs)
        found = statistics.sequential(values, (-1, 1))
        always += (found.low <= 0).all() and (found.high >= 0).all()
        # The usual interval, from the thirtieth run on.
        mean, square = np.cumsum([values, values**2], axis=1)[:, 30:] / count[30:]
        looked += (np.abs(mean) <= 1.96 * np.sqrt((square - mean**2) / count[30:])).all()
    assert always / REPEATS >= 0.95
    assert looked / REPEATS < 0.8


def test_a_sequence_is_that_of_theorem_two():
    values = np.random.default_rng(3).beta(2, 5, 60)
    found = statistics.sequential(values, (0, 1))
    bets, paid, low, high = [], 0, 0, 1
    for count, value in enumerate(values, 1):
        # Each bet, and the mean that its price is reckoned from, know the runs before only.
        means = (0.5 + np.cumsum(values[: count - 1])) / np.arange(2, count + 1)
        variance = (0.25 + ((values[: count - 1] - means) ** 2).sum()) / count
        bets.append(min(0.5, np.sqrt(2 * np.log(40) / (variance * count * np.log(count + 1)))))
        before = means[-1] if count > 1 else 0.5
        paid += 4 * (value - before) ** 2 * (-np.log(1 - bets[-1]) - bets[-1]) / 4
        centre, half = np.average(values[:count], weights=bets), (np.log(40) + paid) / sum(bets)
        low, high = max(low, centre - half), min(high, centre + half)
        assert_allclose((found.low[count - 1], found.high[count - 1]), (low, high), rtol=1e-9)


def test_a_sequence_tells_when_it_is_decided():
    rng = np.random.default_rng(1)
    values = np.clip(rng.normal(0.3, 0.5, 3000), -2, 2)
    found = statistics.sequential(values, (-2, 2), 0.1)
    assert found.verdict == "larger"
    assert found.low[found.runs - 1] > 0.1 >= found.low[found.runs - 2]
    # Later runs change nothing of what was known before them.
    early = statistics.sequential(values[: found.runs], (-2, 2), 0.1)
    assert (early.verdict, early.runs) == ("larger", found.runs)
    assert_allclose(early.high, found.high[: found.runs])
    assert statistics.sequential(values[: found.runs - 1], (-2, 2), 0.1)[2:] == ("undecided", None)
    # Whichever law comes first, and in whatever unit.
    turned = statistics.sequential(-1000 * values, (-2000, 2000), 100)
    assert (turned.verdict, turned.runs) == ("smaller", found.runs)
    assert_allclose(turned.low, -1000 * found.high)
    assert statistics.sequential(values - 0.3, (-2.3, 1.7), 0.1).verdict == "equivalent"
    assert found.low[-1] < values.mean() < found.high[-1]


RUNS = np.random.default_rng(0).normal(size=(4, 5))


@pytest.mark.parametrize("values", [1, [1, 2, 3], [[1, 2]], [[1], [2]], [[1, np.nan], [1, 2]]])
def test_too_few_numbers_are_refused(values):
    with pytest.raises(InvalidParameter, match=r"give 2 courses|expected n x n|must be finite"):
        statistics.interval(values)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: statistics.interval(RUNS[:3], studentised=True), "give 4 courses"),
        (lambda: statistics.interval(1e200 * RUNS), "no number beyond"),
        (lambda: statistics.interval(RUNS, level=95), "level is 95"),
        (lambda: statistics.differences(RUNS), "values is"),
        (lambda: statistics.differences({"a": RUNS}), "values has 1 laws"),
        (lambda: statistics.differences({"a": RUNS, "b": RUNS.T}), "values has 2 laws"),
        (lambda: statistics.differences({"a": RUNS, "b": "good"}), "values of 'b' is"),
        (lambda: statistics.hypervolume([(0, 1, 2)], (3, 3)), "points has shape"),
        (lambda: statistics.hypervolume([(0, 1)], 3), "worst is 3"),
        (lambda: statistics.linearised(np.zeros((1, 4, 4, 4)), sum), "a quantity of mean 0"),
        (lambda: statistics.linearised(RUNS, sum), "values has shape"),
        (lambda: statistics.verdict(1, 0), "give the lower end first"),
        (lambda: statistics.verdict(0, 1, -0.1), "margin is -0.1"),
        (lambda: statistics.order([("a", "b", 0, 0, 0)]), "found is"),
        (
            lambda: statistics.order([pair("a", "b", 1, 2), pair("b", "a", 1, 2)]),
            "better than itself",
        ),
        (lambda: statistics.share(3, 2), "count is 3; give at most the 2 runs"),
        (lambda: statistics.share(0, 0), "runs is 0"),
        (lambda: statistics.share(0.5, 2), "count is 0.5"),
        (lambda: statistics.share(1, 2, "wald"), "method is 'wald'"),
        (lambda: statistics.sequential([0, 2], (-1, 1)), "from 0.0 to 2.0"),
        (lambda: statistics.sequential([0], (1, -1)), "bounds is"),
        (lambda: statistics.sequential([], (-1, 1)), "values has shape"),
    ],
)
def test_what_is_given_wrongly_is_named(call, named):
    with pytest.raises(InvalidParameter, match=named):
        call()
