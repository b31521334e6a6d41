"""The grid over a sea's energy, the drawn waves, and the correction of their energies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.sea import HIGHEST, LOWEST, Spectrum, Spreading
from ssmash_gym.ship.waves import DIRECTIONS, FREQUENCIES, LARGEST_FACTOR, calibrated, draw_waves, sea_grid

SEA = Spectrum(3.3, 9.7)


@pytest.mark.parametrize("spreading", ["cos2", "long_crested"])
@pytest.mark.parametrize("spectrum", [SEA, Spectrum(0.9, 7.5), Spectrum(5.0, 12.4, 3.3)])
def test_the_grid_holds_the_energy_of_the_sea(spectrum: Spectrum, spreading: str) -> None:
    grid = sea_grid(spectrum, Spreading(spreading))
    band = spectrum.energy(LOWEST * spectrum.peak, HIGHEST)
    assert grid.energy.sum() == pytest.approx(band, rel=1e-12)
    assert grid.energy.size == FREQUENCIES * DIRECTIONS
    omega = np.linspace(LOWEST * spectrum.peak, HIGHEST, 20_001)
    for power in (1, 2, 4):
        moment = np.trapezoid(spectrum.density(omega) * omega**power, omega)
        assert np.sum(grid.energy * grid.omega**power) == pytest.approx(moment, rel=3e-3)


def test_the_grid_holds_the_directions_of_the_sea() -> None:
    grid = sea_grid(SEA, Spreading())
    share = grid.energy / grid.energy.sum()
    assert np.sum(share * np.sin(grid.angle)) == pytest.approx(0.0, abs=1e-3)
    assert np.sum(share * np.cos(grid.angle) ** 2) == pytest.approx(0.75, rel=2e-3)
    assert np.sum(share * np.cos(grid.angle)) == pytest.approx(8.0 / (3.0 * math.pi), rel=2e-3)


def test_no_two_cells_share_a_frequency_or_a_direction() -> None:
    grid = sea_grid(SEA, Spreading())
    assert len(np.unique(np.round(grid.omega, 9))) == grid.omega.size
    assert len(np.unique(np.round(grid.angle, 9))) == grid.angle.size


def test_drawn_waves_stand_for_the_sea_without_bias() -> None:
    """Whatever the importance: sums over many draws are the integrals over the spectrum."""
    grid = sea_grid(SEA, Spreading())
    narrow = grid.energy * (0.2 + np.exp(-(((grid.omega - 0.6) / 0.05) ** 2) - ((grid.angle - 0.7) / 0.3) ** 2))
    tests = (
        lambda w, a: np.ones_like(w),
        lambda w, a: w**2,
        lambda w, a: np.sin(a) ** 2,
        lambda w, a: np.exp(-(((w - 0.6) / 0.05) ** 2) - ((a - 0.7) / 0.3) ** 2),
    )
    draws = [draw_waves(grid, narrow, 0.3, 96, np.random.default_rng(seed)) for seed in range(60)]
    fine = np.meshgrid(
        np.linspace(LOWEST * SEA.peak, HIGHEST, 2001), np.linspace(-0.5 * np.pi, 0.5 * np.pi, 401), indexing="ij"
    )
    density = SEA.density(fine[0]) * Spreading().density(fine[1])
    for test in tests:
        expected = np.trapezoid(np.trapezoid(density * test(*fine), fine[1][0], axis=1), fine[0][:, 0])
        found = np.array([np.sum(0.5 * d.amplitude**2 * test(d.omega, d.heading - 0.3)) for d in draws])
        assert found.mean() == pytest.approx(expected, abs=4.0 * found.std() / np.sqrt(60.0) + 1e-3 * expected)
        assert found.std() < 0.2 * expected


def test_frequencies_are_stratified_and_directions_lie_in_the_spreading() -> None:
    grid = sea_grid(SEA, Spreading())
    waves = draw_waves(grid, grid.energy, 2.0, 96, np.random.default_rng(0))
    assert np.all(np.diff(waves.omega) > 0.0)
    assert LOWEST * SEA.peak < waves.omega[0] < waves.omega[-1] < HIGHEST
    assert np.all(np.abs(waves.heading - 2.0) <= 0.5 * np.pi)
    # Drawn as the energy lies, every wave has about its share of it.
    np.testing.assert_allclose(0.5 * waves.amplitude**2, grid.energy.sum() / 96.0, rtol=0.8)
    # Any sixteen neighbours have directions from all over: the shares of cos^2 in thirds hold four to seven each.
    share = 0.5 + (waves.heading - 2.0) / np.pi + np.sin(2.0 * (waves.heading - 2.0)) / (2.0 * np.pi)
    for first in range(0, 81, 16):
        counts = np.histogram(share[first : first + 16], bins=3, range=(0.0, 1.0))[0]
        assert counts.min() >= 3


def test_a_long_crested_sea_goes_one_way() -> None:
    grid = sea_grid(SEA, Spreading("long_crested"))
    waves = draw_waves(grid, np.ones_like(grid.energy), 1.0, 96, np.random.default_rng(0))
    assert np.all(waves.heading == 1.0)
    assert np.sum(0.5 * waves.amplitude**2) == pytest.approx(SEA.variance, rel=0.1)


def test_random_numbers_are_common_to_seas_and_headings() -> None:
    generators = [np.random.default_rng(7) for _ in range(3)]
    seas = (SEA, SEA, Spectrum(0.9, 7.5, 3.3))
    spreadings = (Spreading(), Spreading("long_crested"), Spreading())
    grids = [sea_grid(s, d) for s, d in zip(seas, spreadings, strict=True)]
    drawn = [
        draw_waves(grid, grid.energy + k * 1e-3, 0.5 * k, 96, rng)
        for k, (grid, rng) in enumerate(zip(grids, generators, strict=True))
    ]
    for other in drawn[1:]:
        np.testing.assert_array_equal(other.phase, drawn[0].phase)
    assert len({rng.random() for rng in generators}) == 1
    again = draw_waves(grids[0], grids[0].energy, 0.0, 96, np.random.default_rng(7))
    np.testing.assert_array_equal(again.omega, drawn[0].omega)
    # The same places: turned to another heading, the same sea.
    turned = draw_waves(grids[0], grids[0].energy, 1.0, 96, np.random.default_rng(7))
    np.testing.assert_array_equal(turned.omega, drawn[0].omega)
    np.testing.assert_allclose(turned.heading - 1.0, drawn[0].heading, atol=1e-14)


def test_a_flat_sea_has_waves_without_height() -> None:
    grid = sea_grid(Spectrum(0.0, 8.0), Spreading())
    waves = draw_waves(grid, np.ones_like(grid.energy), 0.0, 24, np.random.default_rng(0))
    assert np.all(waves.amplitude == 0.0)
    assert np.isfinite(waves.omega).all()


def met(energy: np.ndarray, powers: np.ndarray) -> np.ndarray:
    """Sums over the waves."""
    return np.sum(energy[:, np.newaxis] * powers, axis=0)


def test_calibrated_energies_meet_the_sums_and_stay_close() -> None:
    rng = np.random.default_rng(3)
    energy = rng.uniform(0.5, 1.5, 96)
    powers = np.stack([np.ones(96), rng.random(96), rng.random(96) ** 4], axis=1)
    targets = met(energy, powers) * np.array([1.0, 1.05, 0.85])
    corrected, error = calibrated(energy, powers, targets)
    np.testing.assert_allclose(met(corrected, powers), targets, rtol=1e-3)
    assert error == pytest.approx(np.max(np.abs(met(corrected, powers) / targets - 1.0)))
    assert np.all(corrected > 0.0)
    assert np.max(np.abs(np.log(corrected / energy))) < 0.7
    same, _ = calibrated(energy, powers, met(energy, powers))
    np.testing.assert_allclose(same, energy, rtol=1e-4)  # what fits is left alone


def test_calibration_survives_severities_that_say_the_same() -> None:
    energy = np.random.default_rng(0).uniform(0.5, 1.5, 50)
    one = np.linspace(0.1, 1.0, 50)
    powers = np.stack([one, one * (1.0 + 1e-9), np.ones(50)], axis=1)
    targets = met(energy, powers) * 1.1
    corrected, _ = calibrated(energy, powers, targets)
    np.testing.assert_allclose(met(corrected, powers), targets, rtol=1e-3)


@pytest.mark.parametrize("wanted", [0.3, 0.0999, 4.0])
def test_sums_that_no_energies_have_are_approached_and_no_wave_runs_away(wanted: float) -> None:
    """The mean of powers from 0.1 to 1 cannot be less, nor more, nor can five times the energy be got from all."""
    energy, powers = np.full(30, 1.0 / 30.0), np.stack([np.ones(30), np.linspace(0.1, 1.0, 30) ** 2], axis=1)
    powers[:, 1] = np.maximum(powers[:, 1], 0.1)
    targets = np.array([1.0, wanted])
    corrected, error = calibrated(energy, powers, targets)
    assert np.isfinite(corrected).all() and np.all(corrected >= 0.0)
    assert np.all(corrected <= LARGEST_FACTOR * energy * (1.0 + 1e-12))
    before = np.max(np.abs(met(energy, powers) / targets - 1.0))
    assert error < before
    assert (error < 1e-3) == (wanted == 0.3)
    again, _ = calibrated(energy, powers, targets)
    np.testing.assert_array_equal(again, corrected)


def test_what_cannot_be_drawn_is_refused() -> None:
    grid = sea_grid(SEA, Spreading())
    with pytest.raises(ConfigurationError, match="heading is nan"):
        draw_waves(grid, grid.energy, math.nan, 96, np.random.default_rng(0))
    with pytest.raises(ConfigurationError, match="components is 0"):
        draw_waves(grid, grid.energy, 0.0, 0, np.random.default_rng(0))
