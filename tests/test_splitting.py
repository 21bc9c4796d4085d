"""Splitting against a closed form and against counting."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import freeseg as fs
from freeseg.studies.splitting import Tail, lowest_level, split

SPEC = importlib.util.spec_from_file_location(
    "stress_benchmark", Path(__file__).parent / "benchmarks" / "stress.py"
)
BENCHMARK = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(BENCHMARK)
SMALL = {"populations": 6, "particles": 60, "killed": 12}


def first(numbers):
    return numbers[0]


def test_a_normal_tail():
    levels = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    tail = split(first, 3, levels, seed=1)
    assert np.all(tail.low <= norm.sf(levels))
    assert np.all(norm.sf(levels) <= tail.high)
    assert tail.share == pytest.approx(norm.sf(levels), rel=0.35)
    assert 0 < tail.runs < 100_000


def test_the_highest_point_of_brownian_motion_with_a_drift():
    counted = BENCHMARK.highest(
        np.random.default_rng(0).standard_normal((1 + 2 * BENCHMARK.STEPS, 20_000))
    )
    for height in (1.0, 2.0):
        assert (counted > height).mean() == pytest.approx(BENCHMARK.exceeded(height), abs=0.01)
    tail = split(BENCHMARK.highest, 1 + 2 * BENCHMARK.STEPS, [2.0, 4.0], seed=2, **SMALL)
    for low, high, height in zip(tail.low, tail.high, tail.levels, strict=True):
        assert low <= BENCHMARK.exceeded(height) <= high


def test_it_is_without_bias():
    shares = [split(first, 1, [2.0], seed, **SMALL).share[0] for seed in range(40)]
    error = np.std(shares) / np.sqrt(len(shares))
    assert abs(np.mean(shares) - norm.sf(2)) < 4 * error
    assert error < 0.05 * norm.sf(2)


def test_ties_go_together():
    """Heights of whole numbers, of which many are the same."""
    levels = [0.5, 1.5, 2.5]
    tail = split(lambda numbers: np.floor(numbers[0]), 1, levels, seed=3)
    assert tail.share == pytest.approx(norm.sf([1, 2, 3]), rel=0.4)


def test_what_nobody_reaches_has_no_chance():
    tail = split(lambda numbers: np.minimum(numbers[0], 1.0), 1, [0.5, 1.0], **SMALL)
    assert tail.share[1] == tail.low[1] == 0
    assert tail.error[1] == np.inf


def test_it_ends_where_it_is_rare_enough():
    tail = split(first, 1, [1.0, 2.0, 9.0], least=1e-3, **SMALL)
    assert tail.share[:2] == pytest.approx(norm.sf([1, 2]), rel=0.5)
    assert np.isnan(tail.share[2])


def test_equal_seeds_give_equal_tails():
    one, two, other = (split(first, 2, [1.0, 2.0], seed, **SMALL) for seed in (5, 5, 6))
    assert np.array_equal(one.share, two.share)
    assert not np.array_equal(one.share, other.share)


def test_a_level_between_those_of_a_tail():
    shares = np.array([0.1, 0.001, 0.0])
    tail = Tail(np.array([1.0, 2.0, 3.0]), shares, shares, shares, shares, 1)
    assert lowest_level(tail, 0.01) == pytest.approx(1.5)
    assert np.isnan(lowest_level(tail, 0.5))
    assert np.isnan(lowest_level(tail, 1e-6))


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"levels": [2, 1]}, "give increasing"),
        ({"levels": []}, "levels"),
        ({"killed": 60, "particles": 60}, "killed is 60"),
        ({"populations": 1}, "populations is 1"),
        ({"level": lambda numbers: numbers}, "level has shape"),
        ({"level": lambda numbers: np.nan * numbers[0]}, "level"),
        ({"level": None}, "level is None"),
        ({"dimensions": 0}, "dimensions is 0"),
        ({"moves": 0}, "moves is 0"),
    ],
)
def test_bad_input(changed, told):
    good = {"level": first, "dimensions": 1, "levels": [1.0]}
    with pytest.raises(fs.InvalidParameter, match=told):
        split(**good | changed)


def test_a_level_that_never_rises_is_named(monkeypatch):
    monkeypatch.setattr("freeseg.studies.splitting.MOST_ROUNDS", 5)
    with pytest.raises(fs.InvalidParameter, match="has not passed 40 in 5 rounds"):
        split(first, 1, [40.0], **SMALL)
