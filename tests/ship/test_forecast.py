"""The autoregressive forecaster: against least squares, against the recursion, and its skill."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.analysis.forecast_study import LEADS_S, errors, quiet, sea
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.forecast import ArModel, ordered_sum, persistence

RATE_HZ = 5


def motion(seconds: float, noise: float, seed: int = 0) -> Any:
    """Roll, pitch and heave of an irregular motion at 5 Hz (n, 3), with noise as a share of each one's deviation."""
    section = {
        "type": "irregular",
        "roll": {"rms_deg": 3.3, "period_s": 10.4},
        "pitch": {"rms_deg": 0.8, "period_s": 7.0},
        "heave": {"rms_m": 0.7, "period_s": 8.0},
    }
    rng = np.random.default_rng(seed)
    moved = parse_motion(section).realise(rng).sample(0.0, 1.0 / RATE_HZ, round(seconds * RATE_HZ))
    series = moved.position[:, [3, 4, 2]] + (0.02, 0.0, -0.3)
    return series + noise * np.std(series, axis=0) * rng.standard_normal(series.shape)


def test_the_fit_is_the_least_squares_solution() -> None:
    """NumPy's own least squares on the rows written out, with a row for each ridge, gives the same coefficients."""
    series, order, ridge = motion(60.0, 0.01), 12, 1e-5
    model = ArModel.fit(series, order, ridge)
    for k in range(3):
        x = series[:, k] - np.mean(series[:, k])
        rows = np.stack([x[order - 1 - i : len(x) - 1 - i] for i in range(order)], axis=1)
        rows = np.concatenate([rows, np.sqrt(ridge * np.sum(x**2)) * np.eye(order)])
        expected = np.linalg.lstsq(rows, np.concatenate([x[order:], np.zeros(order)]), rcond=None)[0]
        np.testing.assert_allclose(model.coefficients[:, k], expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(model.mean, np.mean(series, axis=0), rtol=1e-12)


def test_a_known_process_is_found_again() -> None:
    rng = np.random.default_rng(1)
    x = np.zeros(20000)
    shocks = rng.standard_normal(x.size)
    for t in range(2, x.size):
        x[t] = 1.6 * x[t - 1] - 0.8 * x[t - 2] + shocks[t]
    np.testing.assert_allclose(ArModel.fit(x + 5.0, 4).coefficients[:, 0], [1.6, -0.8, 0.0, 0.0], atol=0.03)


def test_the_weights_are_the_recursion_written_out() -> None:
    series, leads = motion(120.0, 0.01), (1, 5, 25)
    model = ArModel.fit(series, 20)
    told = model.forecast(series, leads)
    past = list(series - model.mean)
    for _ in range(max(leads)):
        past.append(sum(model.coefficients[i] * past[-1 - i] for i in range(20)))
    for row, lead in zip(told, leads, strict=True):
        np.testing.assert_allclose(row, model.mean + past[len(series) - 1 + lead], rtol=1e-9)
    by_hand = np.einsum("lpc,pc->lc", model.weights(leads), (series - model.mean)[:-21:-1])
    np.testing.assert_allclose(told, model.mean + by_hand, rtol=1e-9)


def test_a_pure_sine_is_foreseen() -> None:
    t = np.arange(900) / RATE_HZ
    told = ArModel.fit(2.0 + np.sin(0.6 * t)).forecast(2.0 + np.sin(0.6 * t), [1, 25])
    np.testing.assert_allclose(told[:, 0], 2.0 + np.sin(0.6 * (t[-1] + np.array([0.2, 5.0]))), atol=2e-3)


def test_a_column_does_not_know_of_its_neighbours() -> None:
    """Bit for bit the same whichever columns are fitted together."""
    series, leads = motion(60.0, 0.01), (5, 10)
    together = ArModel.fit(series, 20)
    for columns in ([0], [1], [2, 0], [1, 2]):
        apart = ArModel.fit(series[:, columns], 20)
        assert np.array_equal(apart.coefficients, together.coefficients[:, columns])
        assert np.array_equal(apart.weights(leads), together.weights(leads)[..., columns])
        assert np.array_equal(apart.forecast(series[:, columns], leads), together.forecast(series, leads)[:, columns])


@pytest.mark.parametrize("value", [0.0, 0.1, -9.81])
def test_what_does_not_move_stays_where_it_is(value: float) -> None:
    model = ArModel.fit(np.full(200, value), 20)
    assert np.max(np.abs(model.coefficients)) < 1e-3
    assert model.forecast(np.full(20, value), [1, 25]) == pytest.approx(value, rel=1e-12)


def skill(series: Any, truth: Any, leads: tuple[int, ...], weights: Any, mean: Any) -> Any:
    """nRMSE of each lead and column over all instants of a record."""
    order = weights.shape[1]
    past = np.lib.stride_tricks.sliding_window_view(series - mean, order, axis=0)[..., ::-1]  # (n, columns, order)
    told = mean + np.einsum("ncp,lpc->lnc", past, weights)
    errors = [told[k, : -lead or None] - truth[order - 1 + lead :] for k, lead in enumerate(leads)]
    return np.stack([np.sqrt(np.mean(e**2, axis=0)) for e in errors]) / np.std(truth, axis=0)


def test_the_skill_on_later_data() -> None:
    """Fitted on 180 s with 1 % noise and judged on what follows: far better than persistence, worse with the lead."""
    leads = (5, 15, 25)
    noisy, true = motion(600.0, 0.01), motion(600.0, 0.0)
    model = ArModel.fit(noisy[:900])
    found = skill(noisy[900:], true[900:], leads, model.weights(leads), model.mean)
    still = skill(noisy[900:], true[900:], leads, persistence(50, leads, 3), model.mean)
    assert np.all(found[0] < 0.25) and np.all(found[0] < 0.35 * still[0])
    assert np.all(np.diff(found, axis=0) > 0.0)
    assert np.all(found[:, 0] < (0.12, 0.5, 0.7)) and np.all(still[1:] > 1.0)


def test_noise_alone_is_not_foreseen() -> None:
    series = np.random.default_rng(2).standard_normal((2000, 1))
    model = ArModel.fit(series[:900])
    found = skill(series[900:], series[900:], (5, 25), model.weights((5, 25)), model.mean)
    assert np.all((found > 0.97) & (found < 1.1))


def test_the_sum_is_a_sum() -> None:
    for n in (1, 2, 3, 50, 51, 127):
        values = np.random.default_rng(n).standard_normal((n, 2, 3))
        np.testing.assert_allclose(ordered_sum(values), values.sum(axis=0), atol=1e-13)


@pytest.mark.parametrize(
    ("series", "more", "words"),
    [
        (np.zeros(99), {}, "too few"),
        (np.full(200, np.nan), {}, "not finite"),
        (np.zeros((9, 9, 9)), {}, "shape"),
        (np.zeros(200), {"order": 0}, "order"),
        (np.zeros(200), {"ridge": 0.0}, "ridge"),
    ],
)
def test_what_cannot_be_fitted_is_refused(series: Any, more: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        ArModel.fit(series, **more)


def test_what_cannot_be_forecast_is_refused() -> None:
    model = ArModel.fit(motion(60.0, 0.01), 20)
    with pytest.raises(ConfigurationError, match="leads"):
        model.weights([0, 5])
    with pytest.raises(ConfigurationError, match="20 or more, 3"):
        model.forecast(np.zeros((19, 3)), [5])


def test_the_skill_in_a_seaway() -> None:
    """Sea state 5, beam sea: roll is foreseen for seconds, forces for less, as the guide says; persistence is not."""
    names = ["deck_roll", "deck_fy", "deck_fz"]
    told, still = (
        np.array(part) for part in zip(*[errors(sea(90.0, k, 600.0), names, None, k) for k in (0, 1)], strict=True)
    )
    one, five = LEADS_S.index(1), LEADS_S.index(5)
    assert np.all(told[:, one] < (0.12, 0.22, 0.25)) and np.all(told[:, five] < (0.5, 1.0, 1.15))
    assert np.all(told[:, one] < 0.3 * still[:, one]) and np.all(still[:, five] > 1.0)


def test_quiet_windows_of_a_seaway() -> None:
    """A beam sea of sea state 5 is quiet now and then: some of the time in windows, more within the limits at all."""
    found = quiet(90.0, 1)
    assert 0.02 < found["in windows of 6 s or more"] < found["within limits"] - 0.1 < 0.6
    assert 6.0 < found["median [s]"] < found["spacing [s]"]
