from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.studies import courses, tracking, tuning
from freeseg.studies.tuning import RANGES, Tuned

TUNED = tuning.load_gains()
EVERY = [(name, one) for name, seeds in TUNED.items() for one in seeds]


def test_ranges_are_decades_round_the_defaults():
    for name, ranges in RANGES.items():
        default = getattr(fs, name)()
        assert set(ranges) <= {gain.name for gain in fields(default)}
        decades = 2 if name in ("Lqr", "Mpc") else 1
        for gain, (low, high) in ranges.items():
            value = getattr(default, gain)
            assert low <= value <= high
            assert np.log10(high / low) >= 2 * decades - 1e-9
            assert high / value == pytest.approx(10**decades, rel=0.05)
            assert value / low >= 9.5**decades


def test_courses_repeat_and_differ():
    training = courses.random_courses(4, 0)
    held_out = courses.held_out_courses()
    assert (len(training), len(held_out)) == (4, 14)
    names = [course.name for course in training + held_out]
    assert len(set(names)) == 18
    assert names[-2:] == ["15a", "16b"]
    courses._random_courses.cache_clear()
    again = courses.random_courses(2, 0)
    for one, other in zip(training, again, strict=False):
        assert_array_equal(one.reference.pose, other.reference.pose)


def test_a_course_is_free_with_its_margin_and_its_wheels_need_what_it_says(robot):
    for course in courses.held_out_courses()[-3:]:
        run = fs.simulate(fs.SlidingMode(), course.reference, dt=courses.DT)
        numbers = fs.metrics.tracking(run, course.world)
        assert numbers["clearance_m"] > robot.radius + 0.9 * courses.WIDE_MARGIN / 2
        assert numbers["wheel_variation_m_s"] == pytest.approx(course.variation, rel=0.05)


def test_starts_fill_the_disc_and_the_angles():
    ahead, left, turned = courses.spread_offsets(4000, 5)
    distance = np.hypot(ahead, left)
    assert distance.max() <= courses.OFFSET[0]
    # Uniform over a disc: a quarter lies within half the radius.
    assert (distance < courses.OFFSET[0] / 2).mean() == pytest.approx(0.25, abs=0.01)
    assert np.abs(turned).max() <= courses.OFFSET[1]
    assert np.abs([ahead.mean(), left.mean()]).max() < 0.0005
    assert_array_equal(courses.spread_offsets(4000, 5)[0], ahead)
    # Of four robots, one starts in each quarter.
    four = np.sort(np.hypot(*courses.spread_offsets(4, 0)[:2]) ** 2)
    assert_array_equal(np.floor(4 * four / courses.OFFSET[0] ** 2), np.arange(4))


def test_one_by_one_is_what_a_batch_does(monkeypatch):
    course, offsets = courses.paper_courses()[1], courses.spread_offsets(3, 1)
    batch = tracking.drive_course(fs.Kanayama(), course, offsets, 7)
    monkeypatch.setattr(tracking, "SINGLE", ("Kanayama",))
    stacked = tracking.drive_course(fs.Kanayama(), course, offsets, 7)
    for name in ("t", "pose", "reference", "error", "wheels", "measured", "asked"):
        assert_array_equal(getattr(stacked, name), getattr(batch, name))


def test_the_score_is_what_it_says(robot):
    some, offsets = courses.paper_courses()[1:], courses.spread_offsets(2, 1)
    tracker = fs.SlidingMode()
    numbers = tracking.evaluate(tracker, some, offsets, 3)
    assert all(values.shape == (1, 2) for values in numbers.values())
    run = tracking.drive_course(tracker, some[0], offsets, 3)
    changes = np.abs(np.diff(run.wheels, axis=-1, prepend=0)).sum(-1).max(0)
    needless = (changes - some[0].variation) / some[0].reference.duration
    rms = np.sqrt((run.error[:2] ** 2).sum(0).mean(-1))
    assert_allclose(numbers["score_m"][0], rms + 0.02 * needless, rtol=1e-12)
    # The parts before and after make the whole.
    before = (run.t < min(4, some[0].reference.duration / 2)).mean()
    steady = numbers["steady_cross_rms_m"] ** 2 + numbers["steady_along_rms_m"] ** 2
    whole = before * numbers["transient_rms_m"] ** 2 + (1 - before) * steady
    assert_allclose(np.sqrt(whole[0]), rms, rtol=1e-12)


def test_a_short_course_has_a_steady_half():
    course = courses.paper_courses(0.3)[1]
    assert course.reference.duration < tracking.STEADY
    numbers = tracking.evaluate(fs.Kanayama(), [course], courses.spread_offsets(2, 1), 3)
    assert all(np.isfinite(values).all() for values in numbers.values())


def test_a_collision_costs():
    course = courses.paper_courses()[1]
    x, y, _ = course.reference.pose[:, -1]
    blocked = course._replace(world=fs.World([fs.Disc((x, y), 0.01)]))
    free, hit = (
        tracking.evaluate(fs.SlidingMode(), [one], courses.spread_offsets(2, 1), 3)["score_m"]
        for one in (course, blocked)
    )
    assert_allclose(hit, free + 1, rtol=1e-12)


def test_a_solver_that_gives_up_is_the_worst():
    class GivesUp:
        def start(self, reference, robot, dt):
            raise fs.SolverFailed("no command")

    assert tuning.training_score(GivesUp()) == np.inf


def test_a_search_repeats_and_beats_the_default(monkeypatch):
    # One short course, for the search is what is tested here.
    short, _ = courses.make_course("short", fs.World([]), (0, 0), (0.2, 0.1))
    monkeypatch.setattr(tuning, "random_courses", lambda *_: [short])
    calls = []
    score = tuning.training_score

    def counted(tracker):
        calls.append(tracker)
        return score(tracker)

    monkeypatch.setattr(tuning, "training_score", counted)
    gains, best = tuning.tune("PurePursuit", 1, 32)
    assert len(calls) == 32
    assert calls[0] == fs.PurePursuit()
    assert best == score(fs.PurePursuit(**gains)) < score(fs.PurePursuit())
    for gain, (low, high) in RANGES["PurePursuit"].items():
        assert all(low <= getattr(call, gain) <= high for call in calls)
    assert tuning.tune("PurePursuit", 1, 32) == (gains, best)
    assert tuning.tune("PurePursuit", 2, 32) != (gains, best)


@pytest.mark.parametrize(
    ("name", "seed", "budget"),
    [("Bicycle", 0, 32), ("Lqr", 0, 0), ("Lqr", 0, 50), ("Lqr", 0, 32.5), ("Lqr", -1, 32)],
)
def test_a_search_that_makes_no_sense_is_refused(name, seed, budget):
    with pytest.raises(InvalidParameter, match=r"choose one|give a (multiple|whole)"):
        tuning.tune(name, seed, budget)


def test_every_tracker_is_tuned_with_the_same_budget():
    assert list(TUNED) == list(RANGES)
    assert {one.budget for _, one in EVERY} == {tuning.BUDGET}
    for seeds in TUNED.values():
        assert [one.seed for one in seeds] == [0, 1]
        (chosen,) = [one for one in seeds if one.chosen]
        assert chosen.score == min(one.score for one in seeds)


@pytest.mark.parametrize(("name", "tuned"), EVERY, ids=lambda part: getattr(part, "seed", part))
def test_stored_gains_have_the_stored_score(name, tuned):
    assert isinstance(tuned, Tuned)
    for gain, (low, high) in RANGES[name].items():
        assert low <= getattr(tuned.tracker, gain) <= high
    assert tuning.training_score(tuned.tracker) == pytest.approx(tuned.score, rel=1e-6)


def test_gains_that_no_tracker_has_are_refused(tmp_path):
    file = tmp_path / "gains.csv"
    header = "tracker,gain,value,budget,seed,score,held_out,chosen\n"
    for row in ("Lqr,k9,1,200,0,0.1,0.1,1", "Bicycle,k,1,200,0,0.1,0.1,1"):
        file.write_text(header + row + "\n")
        with pytest.raises(InvalidData, match="has no gain"):
            tuning.load_gains(file)
    file.write_text(header + "Lqr,q_x,1,200,0,0.1,0.1,1\n")
    with pytest.raises(InvalidData, match="seed 0 lacks"):
        tuning.load_gains(file)
    rest = "Lqr,q_y,1,200,0,0.1,0.1,1\nLqr,q_alpha,1,200,0,0.1,0.1,1\n"
    file.write_text(header + "Lqr,q_x,-1,200,0,0.1,0.1,1\n" + rest)
    with pytest.raises(InvalidParameter, match="q_x"):
        tuning.load_gains(file)
    file.write_text(header + "Lqr,q_x,nan,200,0,0.1,0.1,1\n")
    with pytest.raises(InvalidData, match="row 2"):
        tuning.load_gains(file)


def test_what_a_study_is_given_wrongly_is_named():
    course, offsets = courses.paper_courses()[1], np.zeros((3, 2))
    for call, named in (
        (lambda: courses.random_courses(-1, 0), "courses is -1"),
        (lambda: courses.random_courses([1], 0), r"courses is \[1\]"),
        (lambda: courses.spread_offsets(0, 0), "robots is 0"),
        (lambda: courses.paper_courses([0.1]), "speed is"),
        (lambda: tracking.drive_course(fs.Pid(), course.reference, offsets, 0), "course is"),
        (lambda: tracking.drive_course(fs.Pid(), course, (0, 0, 0), 0), "offsets has shape"),
        (lambda: tracking.drive_course(fs.Mpc(), course, "near", 0), "offsets is"),
        (lambda: tracking.drive_course(fs.Mpc(), course, offsets, "0"), "seed is"),
        (lambda: tracking.evaluate(fs.Pid(), course, offsets, 0), "courses is"),
        (lambda: tracking.evaluate(fs.Pid(), [], offsets, 0), "courses is"),
        (lambda: tuning.tune("Pid", 0, 10**400), "budget is"),
    ):
        with pytest.raises(fs.InvalidParameter, match=named):
            call()


def test_robots_one_by_one_may_begin_at_any_index(monkeypatch):
    course, offsets = courses.paper_courses()[1], courses.spread_offsets(3, 1)
    batch = tracking.drive_course(fs.Kanayama(), course, offsets[:, 1:], (7, 1))
    monkeypatch.setattr(tracking, "SINGLE", ("Kanayama",))
    stacked = tracking.drive_course(fs.Kanayama(), course, offsets[:, 1:], (7, 1))
    assert_array_equal(stacked.pose, batch.pose)
