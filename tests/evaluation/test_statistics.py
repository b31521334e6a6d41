"""Intervals agree with theory on synthetic samples, pairs count as pairs, and shares never have a width of zero."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.evaluation.statistics import bootstrap, estimates, iqm, known_median, mean, median, p95, ratio, share


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


def test_statistics_of_small_samples_by_hand() -> None:
    assert iqm([8.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 100.0]) == 4.5  # 3, 4, 5 and 6 are left
    assert p95(np.arange(21.0)) == 19.0
    assert known_median([[3.0, np.nan, 1.0], [np.nan, 4.0, np.nan]]).tolist() == [2.0, 4.0]
    assert np.isnan(known_median([np.nan, np.nan]))
    np.testing.assert_array_equal(ratio([1.0, 1.0, 1.0], [4.0, 0.0, -1.0]), [0.25, np.nan, np.nan])


def test_several_figures_share_their_draws() -> None:
    sample = np.random.default_rng(6).lognormal(2.0, 0.5, 80)
    together = estimates([sample], lambda drawn: np.stack([p95(drawn), mean(drawn)]), resamples=200)
    assert together == [bootstrap(sample, p95, resamples=200), bootstrap(sample, mean, resamples=200)]


def test_a_sample_of_numbers_of_episodes_stays_whole_numbers() -> None:
    values = np.random.default_rng(7).random(30)
    looked_up = estimates([np.arange(30)], lambda codes: mean(values[codes]), resamples=100)
    assert looked_up == estimates([values], mean, resamples=100)


def test_training_seeds_and_seas_are_drawn_crosswise() -> None:
    """A table of which only the seeds differ has the seeds' width, one of which only the seas differ theirs."""
    of_seeds, of_seas = np.array([[1.0], [2.0], [6.0]]), np.random.default_rng(8).normal(size=(1, 50))
    low = estimates([of_seeds + np.zeros((1, 50))], mean, resamples=3000)[0]
    assert (low.value, low.low, low.high) == pytest.approx((3.0, 1.0, 6.0))  # thrice the same draw: each 1 in 27
    seas = estimates([np.zeros((3, 1)) + of_seas], mean, resamples=500)[0]
    alone = estimates([of_seas], mean, resamples=500)[0]
    assert seas.high - seas.low == pytest.approx(alone.high - alone.low, rel=0.15)


def test_policies_with_training_seeds_are_paired_by_sea() -> None:
    """What the sea does to both cancels in the difference, however many training seeds either has."""
    rng = np.random.default_rng(9)
    sea = 10.0 * rng.normal(size=(1, 60))
    ours, theirs = sea + rng.normal(size=(5, 60)), sea + 1.0 + rng.normal(size=(1, 60))
    found = estimates([ours, theirs], lambda a, b: mean(a) - mean(b), resamples=400)[0]
    assert found.value == pytest.approx(float(np.mean(ours) - np.mean(theirs)))
    assert found.high - found.low < 1.5 and found.low < -1.0 < found.high


def test_paired_differences_cover_the_truth_about_as_often_as_they_say() -> None:
    rng, truth, covered = np.random.default_rng(10), -2.0, 0
    for _ in range(200):
        sea = rng.lognormal(2.0, 0.6, 60)
        ours, theirs = sea + truth + rng.normal(size=60), sea + rng.normal(size=60)
        found = estimates([ours, theirs], lambda a, b: mean(a) - mean(b), resamples=300)[0]
        covered += found.low <= truth <= found.high
    assert 180 <= covered <= 199


def test_crossed_intervals_cover_at_least_as_often_as_a_few_seeds_allow() -> None:
    """Five training seeds and forty seas, both random: the percentile interval of so few seeds is somewhat short."""
    rng, covered = np.random.default_rng(11), 0
    for _ in range(200):
        table = rng.normal(size=(5, 1)) + rng.normal(size=(1, 40)) + 3.0 * rng.normal(size=(5, 40))
        found = estimates([table], mean, resamples=300)[0]
        covered += found.low <= 0.0 <= found.high
    assert 165 <= covered <= 200


def test_a_figure_that_some_resamples_do_not_have() -> None:
    found = estimates([[np.nan, np.nan, 5.0]], known_median, resamples=200)[0]
    assert (found.value, found.low, found.high) == (5.0, 5.0, 5.0)
    nothing = estimates([[np.nan, np.nan]], known_median, resamples=50)[0]
    assert np.isnan([nothing.value, nothing.low, nothing.high]).all()


def test_samples_of_other_seas_are_refused() -> None:
    with pytest.raises(ValueError, match="3 and 2"):
        estimates([[1.0, 2.0, 3.0], [[1.0, 2.0], [3.0, 4.0]]], lambda a, b: mean(a) - mean(b))
    with pytest.raises(ValueError, match="finite"):
        estimates([[1.0, np.inf]], mean)
