from dataclasses import fields

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal

import freeseg as fs
from freeseg.errors import InvalidData, InvalidParameter
from freeseg.studies import courses, tracking, tuning
from freeseg.studies.tuning import RANGES, Tuned


def test_ranges_hold_the_defaults_in_their_middle():
    for name, ranges in RANGES.items():
        default = getattr(fs, name)()
        assert set(ranges) <= {gain.name for gain in fields(default)}
        for gain, (low, high) in ranges.items():
            value = getattr(default, gain)
            assert low < value < high
            assert min(value / low, high / value) >= 10


def test_courses_repeat_and_differ():
    training = courses.random_courses(4, 0)
    held_out = courses.random_courses(12, 1000) + courses.paper_courses()
    assert (len(training), len(held_out)) == (4, 14)
    names = [course.name for course in training + held_out]
    assert len(set(names)) == 18
    assert names[-2:] == ["15a", "16b"]
    courses._random_courses.cache_clear()
    again = courses.random_courses(2, 0)
    for one, other in zip(training, again, strict=False):
        assert_array_equal(one.reference.pose, other.reference.pose)


def test_a_course_is_free_with_its_margin_and_its_wheels_need_what_it_says(robot):
    for course in courses.random_courses(12, 1000)[-1:] + courses.paper_courses():
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


def test_a_solver_that_gives_up_is_the_worst(monkeypatch):
    def evaluate(*_):
        raise fs.SolverFailed("no command", 0.0, "stuck")

    monkeypatch.setattr(tuning, "evaluate", evaluate)
    gains = {gain: np.array([0.1, 0.2]) for gain in RANGES["Mpc"]}
    numbers = tuning.training_numbers("Mpc", "plain", gains, "nominal", 0)
    assert all((values == np.inf).all() and len(values) == 2 for values in numbers.values())


@pytest.fixture
def short(monkeypatch):
    """One short course, where the search is what is tested."""
    course, _ = courses.make_course("short", fs.World([]), (0, 0), (0.2, 0.1))
    monkeypatch.setattr(tuning, "random_courses", lambda *_: [course])


@pytest.mark.parametrize("name", [name for name in RANGES if name != "Mpc"])
def test_candidates_in_a_batch_are_what_they_are_alone(name, short):
    rng = np.random.default_rng(5)
    ranges = tuning.ranges(name, "observed")
    gains = {
        gain: np.sqrt(low * high) * 3.0 ** rng.uniform(-1, 1, 3)
        for gain, (low, high) in ranges.items()
    }
    together = tuning.training_numbers(name, "observed", gains, "nominal", 0)
    for k in range(3):
        alone = {gain: values[[k]] for gain, values in gains.items()}
        numbers = tuning.training_numbers(name, "observed", alone, "nominal", 0)
        for key, values in together.items():
            assert values[k] == pytest.approx(numbers[key][0], rel=1e-9)


def test_a_search_repeats_and_beats_the_middle_of_the_ranges(short):
    search = "PurePursuit", "observed", "nominal"
    (gains, best), (calm, _) = tuning.tune(*search, 1, (0.02, 0.2))
    ranges = tuning.ranges(*search[:2])
    assert all(low <= gains[gain] <= high for gain, (low, high) in ranges.items())

    def numbers(gains):
        found = {gain: np.array([value]) for gain, value in gains.items()}
        return {key: v[0] for key, v in tuning.training_numbers(*search[:2], found, *ends).items()}

    ends = search[2], 1
    found = numbers(gains)
    assert best == pytest.approx(found["position_rms_m"] + 0.02 * found["roughness_m_s2"])
    middle = numbers({gain: np.sqrt(low * high) for gain, (low, high) in ranges.items()})
    assert best < middle["position_rms_m"] + 0.02 * middle["roughness_m_s2"]
    # At a higher price, calmer gains are better, or the same.
    assert numbers(calm)["roughness_m_s2"] <= found["roughness_m_s2"]
    assert tuning.tune(*search, 1, (0.02, 0.2)) == [(gains, best), (calm, _)]
    assert tuning.tune(*search, 2)[0][0] != gains


@pytest.mark.parametrize(
    ("search", "named"),
    [
        (("Bicycle", "plain", "nominal", 0), "tracker is 'Bicycle'"),
        (("Lqr", "fancy", "nominal", 0), "form is 'fancy'"),
        (("Lqr", "plain", "icy", 0), "regime is 'icy'"),
        (("Lqr", "plain", "nominal", -1), "replicate is -1"),
        (("Lqr", "plain", "nominal", 0, (0.0,)), "prices is"),
    ],
)
def test_a_search_that_makes_no_sense_is_refused(search, named):
    with pytest.raises(InvalidParameter, match=named):
        tuning.tune(*search)


def test_a_law_is_told_what_its_form_says():
    gains = {"k_x": 2.0, "k_y": 100.0, "k_alpha": 20.0}
    assert tuning.make_tracker("Kanayama", "plain", gains) == fs.Kanayama()
    told = tuning.make_tracker("Kanayama", "told", gains | {"preview": 0.1}, 3)
    assert told == fs.Predicting(fs.Kanayama(preview=0.1), 3 * 0.05, 3 * 0.03)
    gains = dict.fromkeys(RANGES["Mpc"], 0.1) | {"observer": 2.0}
    mpc = tuning.make_tracker("Mpc", "observed", gains)
    assert (mpc.delay, mpc.lag, mpc.observer) == (0.05, 0.03, 2.0)
    with pytest.raises(InvalidParameter, match="gains is"):
        tuning.make_tracker("Kanayama", "told", {"k_x": 1.0})


@pytest.mark.parametrize("form", tuning.FORMS)
def test_every_law_is_tuned_in_every_form(form):
    tuned = tuning.load_gains(form=form)
    assert list(tuned) == list(RANGES)
    for name, replicates in tuned.items():
        assert [one.replicate for one in replicates] == list(range(tuning.REPLICATES))
        assert all(isinstance(one, Tuned) for one in replicates)
        best = replicates[0].tracker
        gains = {}
        for gain, (low, high) in tuning.ranges(name, form).items():
            gains[gain] = (
                getattr(best, gain) if hasattr(best, gain) else getattr(best.tracker, gain)
            )
            assert low <= gains[gain] <= high
        if name != "Mpc":
            one = {gain: np.array([value]) for gain, value in gains.items()}
            found = tuning.training_numbers(name, form, one, "nominal", 0)
            score = found["position_rms_m"] + tracking.ROUGHNESS * found["roughness_m_s2"]
            assert score[0] == pytest.approx(replicates[0].score, rel=1e-6)


def test_gains_that_no_law_has_are_refused(tmp_path):
    file = tmp_path / "gains.csv"
    header = "tracker,form,regime,price,replicate,gain,value,score\n"
    same = "plain,nominal,0.02,0"
    for row in (f"Lqr,{same},k9,1,0.1", f"Bicycle,{same},k,1,0.1"):
        file.write_text(header + row + "\n")
        with pytest.raises((InvalidData, InvalidParameter), match=r"has no gain|tracker is"):
            tuning.load_gains(file)
    file.write_text(header + f"Lqr,{same},q_x,1,0.1\n")
    with pytest.raises(InvalidData, match="replicate 0 lacks"):
        tuning.load_gains(file)
    with pytest.raises(InvalidData, match="no gains of the form told"):
        tuning.load_gains(file, "told")
    rest = f"Lqr,{same},q_y,1,0.1\nLqr,{same},q_alpha,1,0.1\n"
    file.write_text(header + f"Lqr,{same},q_x,-1,0.1\n" + rest)
    with pytest.raises(InvalidParameter, match="q_x"):
        tuning.load_gains(file)
    file.write_text(header + f"Lqr,{same},q_x,nan,0.1\n")
    with pytest.raises(InvalidData, match="row 2"):
        tuning.load_gains(file)


def test_disturbances_grow_together():
    assert tracking.disturbed(1) == tracking.DISTURBANCE
    worse = tracking.disturbed(3)
    assert worse.delay == pytest.approx(0.15)
    assert worse.slip == pytest.approx(np.multiply(3, tracking.DISTURBANCE.slip))
    assert worse.slip_time == tracking.DISTURBANCE.slip_time


def test_a_course_begins_with_the_room_that_it_is_given(robot):
    for course in courses.random_courses(2, 300, room=0.06):
        start = course.reference.pose[:2, 0]
        assert course.world.distances(shapely.Point(start)).min() >= robot.radius + 0.06


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
        (lambda: courses.random_courses(1, 0, room=-1), "room is -1"),
        (lambda: courses.random_courses(1, 0, room=1), "room is 1"),
        (lambda: courses.spread_offsets(1, 0, (1, -1)), "offset is"),
    ):
        with pytest.raises(fs.InvalidParameter, match=named):
            call()


def test_robots_one_by_one_may_begin_at_any_index(monkeypatch):
    course, offsets = courses.paper_courses()[1], courses.spread_offsets(3, 1)
    batch = tracking.drive_course(fs.Kanayama(), course, offsets[:, 1:], (7, 1))
    monkeypatch.setattr(tracking, "SINGLE", ("Kanayama",))
    stacked = tracking.drive_course(fs.Kanayama(), course, offsets[:, 1:], (7, 1))
    assert_array_equal(stacked.pose, batch.pose)
