"""Intervals agree with theory on synthetic samples, pairs count as pairs, and shares never have a width of zero."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.evaluation.statistics import bootstrap, mean, median, p95, share


def test_interval_of_a_mean_agrees_with_the_normal_one() -> None:
    sample = np.random.default_rng(1).normal(10.0, 2.0, 400)
    found = bootstrap(sample, mean)
    half = 1.96 * np.std(sample) / np.sqrt(sample.size)
    assert found.value == pytest.approx(np.mean(sample))
    assert found.low == pytest.approx(np.mean(sample) - half, abs=0.15 * half)
    assert found.high == pytest.approx(np.mean(sample) + half, abs=0.15 * half)


def test_intervals_cover_the_truth_about_as_often_as_they_say() -> None:
    rng = np.random.default_rng(2)
    truth = -np.log(0.05)  # 95th percentile of the unit exponential
    covered = 0
    for _ in range(100):
        found = bootstrap(rng.exponential(1.0, 200), p95, resamples=400)
        covered += found.low <= truth <= found.high
    assert 85 <= covered <= 100


def test_same_sample_same_interval_and_another_seed_another_one() -> None:
    sample = np.random.default_rng(3).random(50)
    assert bootstrap(sample, p95) == bootstrap(sample, p95)
    assert bootstrap(sample, mean) != bootstrap(sample, mean, seed=1)


def test_a_sample_of_one_value_has_no_width() -> None:
    found = bootstrap(np.full(20, 3.0), median)
    assert (found.value, found.low, found.high) == (3.0, 3.0, 3.0)
    assert bootstrap([4.0], p95).interval == [4.0, 4.0]


def test_a_policy_against_itself_is_one_without_width() -> None:
    sample = np.random.default_rng(4).random(60) + 1.0
    found = bootstrap(sample, p95, over=sample)
    assert (found.value, found.low, found.high) == (1.0, 1.0, 1.0)


def test_pairs_are_drawn_together() -> None:
    rng = np.random.default_rng(5)
    base = rng.lognormal(2.0, 0.8, 100)
    found = bootstrap(0.5 * base * rng.uniform(0.95, 1.05, 100), mean, over=base)
    assert found.low == pytest.approx(0.5, abs=0.02)
    assert found.high == pytest.approx(0.5, abs=0.02)
    apart = bootstrap(0.5 * rng.permutation(base), mean, over=base)
    assert apart.high - apart.low > 5.0 * (found.high - found.low)


@pytest.mark.parametrize("sample", [[], [1.0, np.nan], [[1.0, 2.0]]])
def test_a_bad_sample_is_refused(sample: list[float]) -> None:
    with pytest.raises(ValueError, match="finite"):
        bootstrap(sample, mean)


def test_unequal_pairs_and_a_zero_denominator_are_refused() -> None:
    with pytest.raises(ValueError, match="3 and 2"):
        bootstrap([1.0, 2.0, 3.0], mean, over=[1.0, 2.0])
    with pytest.raises(ValueError, match="denominator"):
        bootstrap([1.0, 2.0], mean, over=[0.0, 0.0])


def test_interval_of_a_share_is_wilsons() -> None:
    """The two bounds are the rates from which the sample is 1.96 of their own deviations away (Wilson 1927)."""
    hits = np.repeat([1.0, 0.0], [13, 7])
    found = share(hits)
    assert found.value == 0.65
    for bound in (found.low, found.high):
        assert abs(found.value - bound) == pytest.approx(1.959964 * np.sqrt(bound * (1.0 - bound) / 20.0))
    none, every = share(np.zeros(16)), share(np.ones(16))
    assert (none.value, none.low, every.value, every.high) == (0.0, 0.0, 1.0, 1.0)
    assert every.low == pytest.approx(16.0 / (16.0 + 1.959964**2)) and none.high == pytest.approx(1.0 - every.low)


@pytest.mark.parametrize("sample", [[], [0.5], [1.0, np.nan], [2.0, 0.0]])
def test_a_share_is_of_zeros_and_ones(sample: list[float]) -> None:
    with pytest.raises(ValueError, match=r"finite|zeros and ones"):
        share(sample)
