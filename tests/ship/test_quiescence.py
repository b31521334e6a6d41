"""Quiescent windows: closed forms on a sine, brute force on irregular motion, the index's envelope."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, MotionTable, Sinusoid, parse_motion
from ssmash_gym.ship.quiescence import (
    ILLUSTRATIVE,
    QUANTITIES,
    Window,
    energy_index,
    label,
    record_means,
    statistics,
    windows,
    zero_crossing_frequencies,
)

PERIOD_S = 8.0


def rolling(amplitude_deg: float = 5.0, duration_s: float = 24.0) -> MotionTable:
    return Sinusoid(dof="roll", amplitude_deg=amplitude_deg, period_s=PERIOD_S).bake(duration_s)


def irregular(duration_s: float = 300.0) -> MotionTable:
    section = {
        "type": "irregular",
        "roll": {"rms_deg": 2.4, "period_s": 10.4},
        "pitch": {"rms_deg": 0.8, "period_s": 7.0},
        "heave": {"rms_m": 0.7, "period_s": 8.0},
    }
    return parse_motion(section).realise(np.random.default_rng(3)).bake(duration_s)


def test_a_sine_leaves_its_limit_when_it_must() -> None:
    """5 deg of roll is within 2.5 deg from a twelfth of a period before each passage through zero to one after."""
    times = np.array([0.0, 0.5, 1.0, 3.5, 4.0, 4.5, 6.0])
    told = label(rolling(), {"roll_deg": 2.5}, times)
    part = PERIOD_S / 12.0
    np.testing.assert_array_equal(told.inside, [True, True, False, True, True, True, False])
    ends = np.array([part, part, np.nan, 4.0 + part, 4.0 + part, 4.0 + part, np.nan])
    starts = np.array([0.0, 0.0, np.nan, 4.0 - part, 4.0 - part, 4.0 - part, np.nan])
    np.testing.assert_allclose(told.end_s, ends, atol=1e-6)
    np.testing.assert_allclose(told.start_s, starts, atol=1e-6)
    np.testing.assert_allclose(told.to_exceedance_s, np.nan_to_num(ends - times), atol=1e-6)
    np.testing.assert_allclose(told.length_s, np.nan_to_num(ends - starts), atol=1e-6)
    np.testing.assert_array_equal(told.open_start, times < 1.0)
    assert not told.open_end.any()
    assert label(rolling(), {"roll_deg": 2.5}, 23.9).open_end[0]


def test_windows_and_labels_agree_with_a_fine_search() -> None:
    """All illustrative limits at once on irregular motion: the ends stand where the first limit is reached."""
    table = irregular()
    found = windows(table, ILLUSTRATIVE, shortest_s=0.0)
    assert len(found) > 20

    def use(times: Any) -> Any:
        signal = table.at(times)
        angles = np.degrees(np.abs(signal.position[..., 3:5])) / (2.5, 1.5)
        return np.maximum(angles.max(axis=-1), np.abs(signal.rate[..., 2]) / 0.8)

    inner = [(w.start_s, w.end_s) for w in found if not (w.open_start or w.open_end)]
    np.testing.assert_allclose(use(np.array(inner)), 1.0, atol=1e-7)
    times = np.random.default_rng(0).uniform(0.0, 300.0, 2000)
    told = label(table, ILLUSTRATIVE, times)
    # Excursions shorter than the sampling may be missed; there are few of those.
    assert np.mean(told.inside == (use(times) <= 1.0)) > 0.998
    some = np.flatnonzero(told.inside & ~told.open_end)[:200]
    just = told.to_exceedance_s[some]
    assert np.all(use(times[some] + just - 1e-4) < 1.0) and np.all(use(times[some] + just + 1e-4) > 1.0)


def test_short_windows_are_left_out_and_counted_as_told() -> None:
    table = irregular()
    every, long = windows(table, ILLUSTRATIVE, shortest_s=0.0), windows(table, ILLUSTRATIVE)
    assert long == [w for w in every if w.length_s >= 6.0] and 1 < len(long) < len(every)
    sums = statistics([Window(0.0, 10.0, open_start=True), Window(40.0, 47.0), Window(90.0, 98.0)], 100.0)
    assert (sums.count, sums.fraction, sums.median_s, sums.spacing_s) == (3, 0.25, 8.0, 45.0)
    none = statistics([], 100.0)
    assert (none.count, none.fraction) == (0, 0.0) and math.isnan(none.median_s) and math.isnan(none.spacing_s)


def test_a_still_deck_is_one_open_window_or_none() -> None:
    level, heeled = Fixed().bake(30.0), Fixed(roll_deg=4.0).bake(30.0)
    assert windows(level, ILLUSTRATIVE) == [Window(0.0, 30.0, open_start=True, open_end=True)]
    assert label(level, ILLUSTRATIVE, 12.0).to_exceedance_s[0] == 18.0
    told = label(heeled, ILLUSTRATIVE, [1.0, 2.0])
    assert not told.inside.any() and not told.to_exceedance_s.any() and not told.length_s.any()


def test_what_a_heeled_deck_feels_sideways_is_the_sine_of_the_heel() -> None:
    table = Fixed(roll_deg=5.0).bake(10.0)
    assert QUANTITIES["lateral_specific_force_g"].value(table.at(1.0)) == pytest.approx(-math.sin(math.radians(5.0)))
    for limit, inside in ((0.087, False), (0.088, True)):
        assert label(table, {"lateral_specific_force_g": limit}, 1.0).inside[0] == inside


@pytest.mark.parametrize("name", ["roll_deg", "pitch_deg", "vertical_velocity_m_s"])
def test_rates_are_the_derivatives_of_the_values(name: str) -> None:
    table, times, step = irregular(60.0), np.linspace(1.0, 50.0, 40), 1e-4
    quantity = QUANTITIES[name]
    assert quantity.rate is not None
    slope = (quantity.value(table.at(times + step)) - quantity.value(table.at(times - step))) / (2.0 * step)
    np.testing.assert_allclose(quantity.rate(table.at(times)), slope, atol=1e-5)


def test_the_index_of_a_sine_is_its_amplitude_over_the_limit() -> None:
    """Whatever the phase; and the quantity nearest its limit decides."""
    table = rolling()
    frequencies = zero_crossing_frequencies(table, {"roll_deg": 2.5})
    assert frequencies["roll_deg"] == pytest.approx(2.0 * math.pi / PERIOD_S, rel=0.02)
    exact = {"roll_deg": 2.0 * math.pi / PERIOD_S, "pitch_deg": 1.0}
    signal = table.at(np.linspace(0.0, 24.0, 50))
    np.testing.assert_allclose(energy_index(signal, {"roll_deg": 2.5, "pitch_deg": 1.0}, exact), 2.0, rtol=1e-5)
    np.testing.assert_allclose(energy_index(signal, {"roll_deg": 2.5}, frequencies), 2.0, rtol=0.02)


def test_the_index_of_a_heeled_deck_counts_the_heel() -> None:
    """2 deg of heel and a roll of 1.5 deg reach 3.5 deg in every cycle: beyond 2.5 deg at all times."""
    table = Sinusoid(dof="roll", amplitude_deg=1.5, period_s=PERIOD_S, roll_deg=2.0).bake(24.0)
    limits, w = {"roll_deg": 2.5}, {"roll_deg": 2.0 * math.pi / PERIOD_S}
    means = record_means(table, limits)
    assert means["roll_deg"] == pytest.approx(2.0, abs=0.03)
    signal = table.at(np.linspace(0.0, 24.0, 50))
    np.testing.assert_allclose(energy_index(signal, limits, w, {"roll_deg": 2.0}), 1.4, rtol=1e-5)
    np.testing.assert_allclose(energy_index(signal, limits, w, means), 1.4, rtol=0.03)
    assert np.min(energy_index(signal, limits, w)) < 0.5  # without the mean it swings
    with pytest.raises(ConfigurationError, match="mean of roll_deg is nan"):
        energy_index(signal, limits, w, {"roll_deg": math.nan})


@pytest.mark.parametrize(
    ("limits", "words"),
    [({}, "no limits"), ({"role_deg": 1.0}, "role_deg"), ({"roll_deg": 0.0}, "roll_deg is 0.0"),
     ({"roll_deg": math.nan}, "nan")],
)  # fmt: skip
def test_wrong_limits_are_refused(limits: dict[str, float], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        windows(rolling(), limits)


def test_wrong_times_samplings_and_indices_are_refused() -> None:
    table = rolling()
    with pytest.raises(ConfigurationError, match="outside the table"):
        label(table, ILLUSTRATIVE, 25.0)
    with pytest.raises(ConfigurationError, match="sampling_s"):
        windows(table, ILLUSTRATIVE, sampling_s=0.0)
    with pytest.raises(ConfigurationError, match="no rate"):
        zero_crossing_frequencies(table, {"lateral_specific_force_g": 0.1})
    with pytest.raises(ConfigurationError, match="does not move"):
        zero_crossing_frequencies(table, {"pitch_deg": 0.1})
    with pytest.raises(ConfigurationError, match="frequency of roll_deg"):
        energy_index(table.at(0.0), {"roll_deg": 2.5}, {})
