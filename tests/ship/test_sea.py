"""Sea states, spectra, spreading and the names of directions."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.sea import (
    HIGHEST,
    SEA_STATES,
    TP_RANGE_S,
    Spectrum,
    Spreading,
    check_steepness,
    comes_from_deg,
    encounter,
    named_spectrum,
    period_of_height,
)


def test_heading_is_turned_into_the_operators_direction_and_back() -> None:
    heading = np.array([0.0, 90.0, 180.0, 270.0, -90.0])
    assert comes_from_deg(heading).tolist() == [180.0, 270.0, 0.0, 90.0, 90.0]
    np.testing.assert_array_equal(comes_from_deg(comes_from_deg(heading)), heading % 360.0)


@pytest.mark.parametrize("gamma", [1.0, 2.0, 3.3, 7.0])
def test_the_spectrum_has_the_height_and_the_period(gamma: float) -> None:
    spectrum = Spectrum(3.3, 9.7, gamma)
    omega = np.linspace(0.05, 60.0, 600_001)
    density = spectrum.density(omega)
    assert 4.0 * math.sqrt(np.trapezoid(density, omega)) == pytest.approx(3.3, rel=1e-4)
    assert omega[np.argmax(density)] == pytest.approx(2.0 * math.pi / 9.7, abs=1e-3)
    assert spectrum.energy(0.0, np.inf) == pytest.approx(3.3**2 / 16.0, rel=1e-12)


def test_bretschneider_is_the_published_formula() -> None:
    spectrum, omega = named_spectrum("bretschneider", 5.0, 12.4), np.array([0.3, 0.5, 0.9, 2.0])
    peak = 2.0 * math.pi / 12.4
    published = 5.0 / 16.0 * 25.0 * peak**4 / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)
    np.testing.assert_allclose(spectrum.density(omega), published, rtol=1e-12)
    assert np.all(spectrum.density([0.0, -1.0]) == 0.0)


def test_jonswap_is_bretschneider_with_a_higher_peak() -> None:
    plain, peaked = named_spectrum("bretschneider", 2.0, 9.0), named_spectrum("jonswap", 2.0, 9.0)
    peak = np.array([plain.peak])
    # Peak over Bretschneider's is gamma over the normalisation, which is about 1 / (1 - 0.287 ln gamma) (DNV-RP-C205).
    assert (peaked.density(peak) / plain.density(peak)).item() == pytest.approx(3.3 * (1 - 0.287 * math.log(3.3)), 0.01)
    assert named_spectrum("jonswap", 2.0, 9.0, 1.0) == plain


@pytest.mark.parametrize("gamma", [1.0, 3.3])
def test_the_energy_of_a_band_is_the_integral_of_the_density(gamma: float) -> None:
    spectrum = Spectrum(1.9, 8.8, gamma)
    edges = np.array([0.4, 0.65, 0.714, 0.72, 0.9, 2.4])
    nodes, weights = np.polynomial.legendre.leggauss(200)
    for low, high in itertools.pairwise(edges):
        omega = 0.5 * (high + low) + 0.5 * (high - low) * nodes
        integral = 0.5 * (high - low) * np.sum(weights * spectrum.density(omega))
        assert spectrum.energy(low, high) == pytest.approx(integral, rel=2e-5)


def test_cos2_spreading_is_a_distribution_over_half_a_circle() -> None:
    angle = np.linspace(-math.pi, math.pi, 20_001)
    density = Spreading("cos2").density(angle)
    assert np.trapezoid(density, angle) == pytest.approx(1.0, rel=1e-6)
    assert np.trapezoid(density * np.sin(angle) ** 2, angle) == pytest.approx(0.25, rel=1e-6)
    assert np.all(density[np.abs(angle) > 0.5 * math.pi] == 0.0)
    with pytest.raises(ConfigurationError, match="long_crested"):
        Spreading("long_crested").density(0.0)


def test_periods_of_heights_go_through_the_pairs() -> None:
    for height, period in SEA_STATES.values():
        assert period_of_height(height) == period
        check_steepness(height, period)
    assert 7.5 < period_of_height(1.4) < 8.8
    heights = np.linspace(0.3, 5.0, 50)
    assert np.all(np.diff([period_of_height(float(h)) for h in heights]) > 0.0)


@pytest.mark.parametrize("height", [0.2, 5.1, -1.0, math.nan, "3", True])
def test_periods_of_other_heights_are_refused(height: object) -> None:
    with pytest.raises(ConfigurationError, match="hs_m is "):
        period_of_height(height)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("height", "period", "words"),
    [
        (5.0, 6.0, ("hs_m is 5", "tp_s 6", "3.37 m", "7.31 s")),
        (-0.1, 8.0, ("hs_m is -0.1", "0 m or more")),
        (math.nan, 8.0, ("hs_m is nan", "finite")),
        (1.0, math.inf, ("tp_s is inf", "finite")),
        (0.1, 2.0, ("tp_s is 2", "5 to 25 s")),
        (0.1, 4.9, ("tp_s is 4.9", "5 to 25 s", "2.4 rad/s")),
        (1.0, 26.0, ("tp_s is 26", "5 to 25 s")),
    ],
)
def test_impossible_seas_cost_one_sentence(height: float, period: float, words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        Spectrum(height, period)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_limit_of_steepness_is_allowed() -> None:
    limit = 0.06 * 9.81 / (2.0 * math.pi)
    check_steepness(limit * 64.0, 8.0)
    with pytest.raises(ConfigurationError, match="too steep"):
        check_steepness(1.001 * limit * 64.0, 8.0)


def test_no_sea_that_is_allowed_has_much_energy_beyond_the_band() -> None:
    for gamma in (1.0, 3.3):
        sea = Spectrum(0.3, TP_RANGE_S[0], gamma)
        assert sea.energy(0.0, HIGHEST) > 0.9 * sea.variance


def test_encounter_is_slower_with_the_waves_and_faster_against_them() -> None:
    found = encounter(np.array([0.6, 0.6, 1.4]), np.array([0.0, math.pi, 0.0]), 10.0)
    np.testing.assert_allclose(found, [0.6 - 3.6 / 9.81, 0.6 + 3.6 / 9.81, 1.4 - 19.6 / 9.81])
    assert found[2] < 0.0  # overtaken


def test_unknown_names_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"spectrum is 'tma', allowed are bretschneider, jonswap"):
        named_spectrum("tma", 1.0, 8.0)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match=r"spreading is 'cos4', allowed are cos2, long_crested"):
        Spreading("cos4")  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match=r"gamma is 0\.5"):
        Spectrum(1.0, 8.0, 0.5)
