"""Sampled futures go on where the past ends, are seeded, and are as wide and as connected as the sea is."""

from __future__ import annotations

import numpy as np

from ssmash_gym.monitor.futures import DeckModel, damped, error_times, future_nodes, samples_ahead
from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.forecast import ArModel
from ssmash_gym.ship.motion import hermite
from tests.monitor.decks import motion

NOW_S = 180.0


def past_of(seed: int = 1, length_s: float = 180.0) -> np.ndarray:
    count = round(length_s / SPACING_S)
    signal = motion(True, seed).sample(NOW_S - (count - 1) * SPACING_S, SPACING_S, count)
    return np.concatenate([signal.rate[:, :3], signal.position[:, 3:]], axis=1)


def test_futures_join_the_past_in_value_rate_and_acceleration() -> None:
    past = past_of()
    futures = DeckModel.fit(past).sample(16, samples_ahead(10.0), np.random.default_rng(0))
    nodes = future_nodes(past, futures, 41)
    assert nodes.shape == (17, 41, 18)
    true = motion(True).signal([NOW_S])
    deviation = [np.std(x, axis=0) for x in motion(True).sample(0.0, SPACING_S, 900)]
    np.testing.assert_array_equal(nodes[:, 0, :3], 0.0)  # positions count from now on
    np.testing.assert_allclose(nodes[:, 0, 3:6], np.tile(true.position[0, 3:], (17, 1)), atol=1e-9)
    np.testing.assert_allclose(nodes[:, 0, 6:9], np.tile(true.rate[0, :3], (17, 1)), atol=1e-9)
    assert np.all(np.abs(nodes[:, 0, 6:12] - true.rate[0]) < 0.02 * deviation[1])
    off = np.abs(nodes[:, 0, 12:] - true.acceleration[0]) / deviation[2]
    assert np.all(off[:, :3] < 0.05)
    # A future's next error bends the second derivative of the angles at the join.
    assert np.all(off[:, 3:] < 0.3) and np.all(np.median(off, axis=0) < 0.12)


def test_nodes_are_each_others_derivatives() -> None:
    past = past_of()
    futures = DeckModel.fit(past).sample(4, samples_ahead(10.0), np.random.default_rng(0))
    nodes = future_nodes(past, futures, 41)
    middle = hermite(nodes[:, :-1], nodes[:, 1:], 0.25, np.full((1, 1, 1), 0.125))
    bend = np.std(nodes[..., 12:], axis=(0, 1))
    # What a parabola from one node leaves at the next is the third derivative's, and small.
    assert np.all(np.abs(middle.rate - 0.5 * (nodes[:, :-1, 6:12] + nodes[:, 1:, 6:12])) < 0.05 * bend)
    assert np.all(np.abs(np.diff(nodes[..., 6:12], axis=1) / 0.25 - 0.5 * (nodes[:, 1:, 12:] + nodes[:, :-1, 12:]))
                  < 0.2 * bend)  # fmt: skip


def test_futures_are_seeded() -> None:
    model = DeckModel.fit(past_of())
    first, again, other = (model.sample(5, 60, np.random.default_rng(seed)) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first[1:], other[1:])
    np.testing.assert_array_equal(first[0], other[0])


def test_the_first_row_is_the_forecast_and_the_futures_mean_comes_to_it() -> None:
    past = past_of()
    model = DeckModel.fit(past)
    sampled = model.sample(512, 50, np.random.default_rng(0))
    told = model.model.forecast(past, range(1, 51))
    np.testing.assert_allclose(sampled[0], told, atol=1e-9)
    error = np.std(sampled[1:], axis=0) / np.sqrt(512)
    assert np.all(np.abs(np.mean(sampled[1:], axis=0) - told) < 5.0 * error + 1e-12)


def test_far_ahead_futures_are_as_wide_as_the_sea_and_their_channels_belong_together() -> None:
    """Errors drawn one by one would lose two thirds of the width (see the guide)."""
    wide, kept = [], []
    for seed in range(4):
        past = past_of(seed)
        sampled = DeckModel.fit(past).sample(128, 200, np.random.default_rng(seed))[1:, 100:]
        wide.append(np.std(sampled, axis=(0, 1)) / np.std(past, axis=0))
        true, found = np.corrcoef(past.T), np.corrcoef(sampled.reshape(-1, 6).T)
        kept.append(np.abs(true - found)[np.abs(true) > 0.5])
    assert np.all(np.abs(np.mean(wide, axis=0) - 1.0) < 0.3)
    assert np.mean(np.concatenate(kept)) < 0.2


def test_errors_are_drawn_in_runs_and_at_the_same_times_for_all_channels() -> None:
    times = error_times(850, 3, 120, np.random.default_rng(0))
    assert times.shape == (3, 120)
    assert times.min() >= 0 and times.max() < 850
    assert np.sum(np.diff(times, axis=1) != 1) <= 3 * 2
    past = past_of()
    model = DeckModel.fit(past)
    other = np.array(past)
    other[:, 0] *= 2.0  # a channel of its own scale: the others stay as they are
    a, b = model.sample(3, 40, np.random.default_rng(0)), DeckModel.fit(other).sample(3, 40, np.random.default_rng(0))
    np.testing.assert_allclose(b[..., 1:], a[..., 1:], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(b[..., 0], 2.0 * a[..., 0], rtol=1e-4, atol=1e-6)


def test_a_model_that_would_grow_is_damped_and_another_is_left_alone() -> None:
    radius, w = 1.03, 0.2
    growing = ArModel(np.array([[2.0 * radius * np.cos(w)], [-(radius**2)]]), np.zeros(1))
    roots = np.roots([1.0, *(-damped(growing).coefficients[:, 0])])
    np.testing.assert_allclose(np.abs(roots), 0.9995, atol=1e-5)
    np.testing.assert_allclose(np.abs(np.angle(roots)), w, atol=1e-6)
    steady = ArModel(np.array([[2.0 * 0.9 * np.cos(w)], [-(0.9**2)]]), np.zeros(1))
    np.testing.assert_array_equal(damped(steady).coefficients, steady.coefficients)


def test_futures_of_a_single_sine_stay_finite() -> None:
    sine = parse_motion({"type": "sinusoid", "dof": "roll", "amplitude_deg": 8.0, "period_s": 9.0}).realise()
    signal = sine.sample(0.0, SPACING_S, 300)
    past = np.concatenate([signal.rate[:, :3], signal.position[:, 3:]], axis=1)
    sampled = DeckModel.fit(past).sample(16, 300, np.random.default_rng(0))
    assert np.all(np.abs(sampled) < 2.0 * np.deg2rad(8.0))
