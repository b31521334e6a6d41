"""Gusts: the spectrum they are drawn from, exact variance, and a table that follows them."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.gusts import BAND_HZ, HEIGHT_M, Gust, GustTable, band_share, slower_share
from ssmash_gym.simulation.batch import Timing


def kaimal(f: float, mean: float, height: float) -> float:
    """Density [1/Hz] over the variance, as IEC 61400-1 writes it."""
    length = 8.1 * 0.7 * height
    return 4.0 * length / mean / (1.0 + 6.0 * f * length / mean) ** (5.0 / 3.0)


@pytest.mark.parametrize(("mean", "height"), [(3.0, 10.0), (17.0, 10.0), (10.0, 30.0)])
def test_the_share_of_slow_gusts_is_the_integral_of_the_spectrum(mean: float, height: float) -> None:
    for f in (0.003, 0.05, 0.8):
        assert slower_share(f, mean, height) == pytest.approx(quad(kaimal, 0.0, f, (mean, height))[0], rel=1e-8)
    assert slower_share(1e9, mean, height) == pytest.approx(1.0, abs=1e-5)
    expected = quad(kaimal, *BAND_HZ, (mean, height))[0]
    assert band_share(mean, height) == pytest.approx(expected, rel=1e-8)


def test_rms_is_exactly_intensity_times_mean() -> None:
    for seed in range(20):
        gust = Gust.draw(13.0, 0.12, np.random.default_rng(seed), components=1 + seed)
        assert gust.rms == pytest.approx(0.12 * 13.0, rel=1e-12)
        hz = gust.omega / (2.0 * math.pi)
        assert hz.min() >= BAND_HZ[0] and hz.max() <= BAND_HZ[1]
        assert gust.phase.min() >= 0.0 and gust.phase.max() < 2.0 * math.pi


def test_a_long_record_has_that_rms_and_no_mean() -> None:
    speed = Gust.draw(10.0, 0.1, np.random.default_rng(3)).at(0.5 * np.arange(40_000))[:, 0]
    assert np.std(speed) == pytest.approx(1.0, rel=0.02)
    assert abs(np.mean(speed)) < 0.02


@pytest.mark.parametrize("mean", [5.0, 20.0])
def test_the_energy_lies_where_the_spectrum_has_it(mean: float) -> None:
    """Over many draws: the variance below a frequency is the spectrum's, to what a bin can blur."""
    gusts = [Gust.draw(mean, 0.1, np.random.default_rng(seed)) for seed in range(200)]
    omega = np.concatenate([g.omega for g in gusts])
    energy = np.concatenate([0.5 * g.amplitude**2 for g in gusts]) / (200 * (0.1 * mean) ** 2)
    for f in (0.02, 0.05, 0.1, 0.3):
        below = quad(kaimal, BAND_HZ[0], f, (mean, HEIGHT_M))[0] / quad(kaimal, *BAND_HZ, (mean, HEIGHT_M))[0]
        assert np.sum(energy[omega < 2.0 * math.pi * f]) == pytest.approx(below, abs=0.006)


def test_stronger_winds_gust_faster() -> None:
    def mean_hz(wind: float) -> float:
        gust = Gust.draw(wind, 0.1, np.random.default_rng(1))
        return float(np.sum(gust.omega * gust.amplitude**2) / np.sum(gust.amplitude**2)) / (2.0 * math.pi)

    assert mean_hz(20.0) > 1.2 * mean_hz(5.0)


def test_the_same_generator_gives_the_same_gusts_and_moves_on_alike_in_any_wind() -> None:
    generators = [np.random.default_rng(7) for _ in range(3)]
    a, b, calm = (Gust.draw(mean, 0.1, g) for mean, g in zip((9.0, 9.0, 0.0), generators, strict=True))
    assert np.array_equal(a.at([1.0, 2.0]), b.at([1.0, 2.0]))
    assert np.array_equal(a.omega, calm.omega) and np.array_equal(a.phase, calm.phase)
    assert len({g.random() for g in generators}) == 1


@pytest.mark.parametrize(("mean", "intensity"), [(0.0, 0.3), (12.0, 0.0)])
def test_no_wind_or_no_intensity_is_no_gust(mean: float, intensity: float) -> None:
    gust = Gust.draw(mean, intensity, np.random.default_rng(0))
    assert gust.rms == 0.0 and not gust.bake(5.0).nodes.any()


@pytest.mark.parametrize("mean", [1e-300, 5e-324, 1e-9])
def test_next_to_no_wind_is_next_to_no_gust(mean: float) -> None:
    gust = Gust.draw(mean, 0.3, np.random.default_rng(0))
    assert np.isfinite(gust.amplitude).all() and np.max(gust.amplitude) <= mean
    assert np.isfinite(gust.bake(5.0).nodes).all()


def test_rates_are_the_derivatives() -> None:
    gust = Gust.draw(15.0, 0.2, np.random.default_rng(5))
    t, d = np.linspace(0.0, 30.0, 40), 1e-5
    ahead, behind, now = gust.at(t + d), gust.at(t - d), gust.at(t)
    np.testing.assert_allclose((ahead - behind)[:, :2] / (2.0 * d), now[:, 1:], atol=1e-7)


@pytest.mark.parametrize("spacing", [0.25, Timing(0.0045, 0.0045).node_spacing_s])
def test_the_table_follows_the_gusts(spacing: float) -> None:
    gust = Gust.draw(20.0, 0.15, np.random.default_rng(11))
    table = gust.bake(20.0, spacing, start_s=100.0)
    assert 20.0 <= table.duration_s < 20.0 + spacing
    t = np.linspace(0.0, 20.0, 1001)
    error = table.at(t) - gust.at(100.0 + t)
    assert np.max(np.abs(error[:, 0])) < 2e-4 * gust.rms
    np.testing.assert_array_equal(table.at(spacing * np.arange(40)), gust.at(100.0 + spacing * np.arange(40)))


def test_ramped_gusts_start_from_nothing_and_end_as_themselves() -> None:
    gust = Gust.draw(12.0, 0.2, np.random.default_rng(2))
    plain, ramped = gust.bake(10.0), gust.bake(10.0, ramp_s=4.0)
    assert not ramped.nodes[0].any()
    np.testing.assert_array_equal(ramped.nodes[16:], plain.nodes[16:])
    half = ramped.at([2.0])[0, 0]
    assert half == pytest.approx(0.5 * plain.at([2.0])[0, 0], rel=1e-9)
    t, d = np.linspace(0.1, 5.0, 30), 1e-5  # the nodes' rates are those of the ramped speed
    np.testing.assert_allclose((ramped.at(t + d) - ramped.at(t - d))[:, :2] / (2.0 * d), ramped.at(t)[:, 1:], atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "keys", "message"),
    [
        ((-1.0, 0.1), {}, r"mean_mps is -1, allowed are numbers of 0 or more"),
        ((1.0, math.nan), {}, r"intensity is nan, allowed are finite numbers"),
        ((1.0, True), {}, r"intensity is True"),
        ((1.0, 0.1), {"components": 0}, r"components is 0, allowed are whole numbers of 1 or more"),
        ((1.0, 0.1), {"components": 2.5}, r"components is 2\.5"),
        ((1.0, 0.1), {"height_m": 0.0}, r"height_m is 0\.0"),
    ],
)
def test_a_draw_that_makes_no_sense_is_refused(arguments: tuple[float, float], keys: dict, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        Gust.draw(*arguments, np.random.default_rng(0), **keys)


def test_a_table_that_cannot_be_is_refused() -> None:
    gust = Gust.draw(10.0, 0.1, np.random.default_rng(0))
    with pytest.raises(ConfigurationError, match=r"spacing_s is 0\.5, allowed is at most 0\.\d+ s, a quarter"):
        gust.bake(10.0, 0.5)
    with pytest.raises(ConfigurationError, match="duration_s is 0"):
        gust.bake(0.0)
    with pytest.raises(ConfigurationError, match="ramp_s is -1"):
        gust.bake(1.0, ramp_s=-1.0)
    with pytest.raises(ConfigurationError, match="start_s is inf"):
        gust.bake(1.0, start_s=math.inf)
    with pytest.raises(ConfigurationError, match=r"shape \(1, 3\), allowed is \(2 or more, 3\)"):
        GustTable(0.25, np.zeros((1, 3)))
    with pytest.raises(ConfigurationError, match="node 1 holds a value that is not finite"):
        GustTable(0.25, np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]]))
    with pytest.raises(ConfigurationError, match=r"time 10\.1 s is outside the table, 0 to 10 s"):
        gust.bake(10.0).at([1.0, 10.1])


def test_a_table_cannot_be_changed_and_survives_a_copy() -> None:
    table = pickle.loads(pickle.dumps(Gust.draw(10.0, 0.1, np.random.default_rng(0)).bake(3.0)))
    with pytest.raises(ValueError, match="read-only"):
        table.nodes[0] = 1.0
    assert table.nodes.shape == (13, 3) and table.duration_s == 3.0
