"""The study of failures: what disturbs, what counts as one, and what is stored."""

import numpy as np
import pytest

import freeseg as fs
from freeseg.studies import stress
from freeseg.studies.courses import paper_courses
from freeseg.studies.splitting import split
from freeseg.studies.tracking import DISTURBANCE

COURSE = paper_courses()[1]
SAMPLES = stress.samples_of(COURSE) + 1
LAWS = stress.best_laws()


def numbers(robots, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((6, robots)), rng.standard_normal((SAMPLES, 5, robots))


def test_without_causes_a_robot_drives_as_without_a_disturbance():
    statics, noise = numbers(3)
    offsets, drawn = stress.draw(statics, noise, dict.fromkeys(stress.CAUSES, 0))
    assert not offsets.any()
    run = stress.drive_drawn(fs.Pid(), COURSE, offsets, drawn)
    plain = fs.simulate(fs.Pid(), COURSE.reference, None, 0.05, offsets)
    assert run.pose[..., : len(plain.t)] == pytest.approx(plain.pose)


def test_every_robot_has_its_own_numbers_and_drives_alone_as_in_the_batch():
    statics, noise = numbers(3)
    together = stress.outcome(fs.Pid(), COURSE, statics, noise)
    assert len(set(together.gap)) == 3
    for k in range(3):
        alone = stress.outcome(fs.Pid(), COURSE, statics[:, [k]], noise[..., [k]])
        assert [one[0] for one in alone] == pytest.approx([one[k] for one in together])


def test_constant_numbers_are_those_of_a_plain_disturbance():
    """Slip, wheel base and noise of one robot, against the disturbance that has them as fields."""
    noise = np.random.default_rng(1).standard_normal((SAMPLES, 5, 1))
    statics = np.array([[1.0], [-0.5], [2.0], [0.0], [0.0], [0.0]])
    _, drawn = stress.draw(statics, noise, {"slip_fluctuation": 0, "delay": 0, "noise": 0})
    plain = fs.Disturbance(slip=(0.05, -0.025), wheel_base_error=0.06)
    one = fs.simulate(fs.Pid(), COURSE.reference, disturbance=plain)
    other = fs.simulate(fs.Pid(), COURSE.reference, None, 0.05, np.zeros((3, 1)), drawn)
    assert other.pose[:, 0] == pytest.approx(one.pose)


def test_the_spreads_are_those_of_the_usual_disturbance():
    statics, noise = numbers(4000)
    offsets, drawn = stress.draw(statics, noise[:2])
    assert drawn.slips.std(1) == pytest.approx(DISTURBANCE.slip, rel=0.05)
    assert drawn.bases.std() == pytest.approx(DISTURBANCE.wheel_base_error, rel=0.05)
    assert offsets.std(1) == pytest.approx(stress.SPREADS[3:], rel=0.05)
    assert (drawn.delay, drawn.lag) == (DISTURBANCE.delay, DISTURBANCE.lag)


def test_a_stronger_cause_is_that_cause_alone():
    statics, noise = numbers(2)
    _, usual = stress.draw(statics, noise)
    _, strong = stress.draw(statics, noise, {"slip": [1, 3]})
    assert strong.slips == pytest.approx(usual.slips * [1, 3])
    assert np.array_equal(strong.noise, usual.noise)
    assert np.array_equal(strong.bases, usual.bases)
    _, late = stress.draw(statics, noise, {"delay": 2})
    assert (late.delay, late.lag) == pytest.approx((0.1, 0.06))


def test_what_counts_as_a_failure():
    gap, far, missed = np.array([[-1e-9, 0, 1, 1, 1], [0, 0, 0.2, 0, 0], [0, 0, 0, 0.02, 0.009]])
    found = stress.Outcome(gap, far, missed)
    assert found.contact.tolist() == [True, False, False, False, False]
    assert found.failed.tolist() == [True, False, True, True, False]


def test_a_stored_course_is_driven_again():
    stored = stress.load_stress().counts
    for name, law in LAWS.items():
        for cause, found in stress.count_failures(law, 7, name != "Mpc").items():
            for one, values in found.items():
                kept = getattr(stored[name][cause], one)[7]
                assert values == pytest.approx(kept, rel=1e-4, abs=1e-6), (name, cause, one)


def test_stored_tails_agree_with_counting():
    """Where counting still sees something: 4 000 runs, of which one in ten gets that far."""
    level, dimensions = stress.shortfall(LAWS["Pid"], stress.rare_courses()[1])
    rng = np.random.default_rng(9)
    heights = np.concatenate([level(rng.standard_normal((dimensions, 1000))) for _ in range(4)])
    tail = stress.load_stress().tails["Pid", 1]
    seen = 0
    for shortfall, low, high in zip(tail.levels, tail.low, tail.high, strict=True):
        count = int((heights > shortfall).sum())
        if 40 < count < 3960:
            seen += 1
            error = 4 * np.sqrt(count * (1 - count / 4000)) / 4000
            assert low - error < count / 4000 < high + error
    assert seen >= 2


def test_a_level_is_half_the_margin_less_the_gap():
    level, dimensions = stress.shortfall(fs.Pid(), COURSE)
    drawn = np.random.default_rng(0).standard_normal((dimensions, 2))
    noise = drawn[6:].reshape(SAMPLES, 5, 2)
    gap = stress.outcome(fs.Pid(), COURSE, drawn[:6], noise).gap
    assert level(drawn) == pytest.approx(0.015 - gap)
    tail = split(level, dimensions, [0.001], populations=2, particles=10, killed=2)
    assert 0 < tail.share[0] <= 1


def test_sensitivity_finds_what_matters():
    """The delay that the plain law is not told of, and nothing that is switched off."""
    result = stress.sensitivity(fs.Pid(), COURSE, number=4, robots=4)
    assert result.total_order.shape == (len(stress.CAUSES),)
    assert np.argmax(result.total_order) == stress.CAUSES.index("delay")


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: stress.draw(np.zeros((5, 1)), np.zeros((3, 5, 1))), "statics has shape"),
        (lambda: stress.draw(np.zeros((6, 1)), np.zeros((3, 5, 2))), "numbers has shape"),
        (lambda: stress.draw(*numbers(1), {"wind": 1}), "wind"),
        (lambda: stress.draw(*numbers(1), {"slip": -1}), "give zero or more"),
        (lambda: stress.draw(*numbers(2), {"delay": [1, 2]}), "give zero or more, one for"),
        (lambda: stress.counted_course(stress.COUNTED), "give less than"),
        (lambda: stress.split_shortfall("Pid", 9), "course is 9"),
        (lambda: stress.split_shortfall("Lqr", 0), "law is"),
        (lambda: stress.sensitivity(LAWS["Mpc"], COURSE), "give a law for batches"),
        (lambda: stress.outcome(LAWS["Mpc"], COURSE, *numbers(2)), "drives one robot"),
        (lambda: stress.outcome(fs.Pid(), None, *numbers(2)), "course is None"),
        (
            lambda: stress.outcome(fs.Pid(), COURSE, np.zeros((6, 1)), np.zeros((3, 5, 1))),
            "numbers has 3 samples",
        ),
    ],
)
def test_bad_input(call, told):
    with pytest.raises(fs.InvalidParameter, match=told):
        call()


def test_broken_files(tmp_path):
    with pytest.raises(fs.InvalidData, match="run the study again"):
        stress.load_stress(tmp_path / "none.npz")
    np.savez(tmp_path / "other.npz", a=1)
    with pytest.raises(fs.InvalidData, match="run the study again"):
        stress.load_stress(tmp_path / "other.npz")
