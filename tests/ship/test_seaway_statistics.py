"""Severity of a deck: by sampling, from drawn waves, from the spectrum; and that the seed does not change it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import (
    SEA_STATES,
    DeckRms,
    Irregular,
    Motion,
    SeawayMotion,
    Sinusoid,
    Spectrum,
    Spreading,
    draw_seaway,
    parse_motion,
    spectral_deck_rms,
)
from ssmash_gym.ship.sea import KNOT, period_of_height
from ssmash_gym.ship.seaway_statistics import linear_deck_rms
from ssmash_gym.ship.ships import load_ship
from ssmash_gym.ship.waves import Waves, sea_grid
from tests.ship.box_ship import BoxShip

JUDGED = ("roll_deg", "pitch_deg", "vertical_velocity_m_s", "vertical_acceleration_g", "lateral_specific_force_g")


def values(rms: DeckRms) -> np.ndarray:
    return np.array([getattr(rms, key) for key in JUDGED])


# The corners of the sweep: narrow resonances at rest and low seas, slow encounter in following seas, waves overtaken.
CELLS = [(3, 180, 0), (3, 30, 20), (4, 150, 10), (5, 90, 10), (5, 0, 18), (6, 300, 20), (6, 225, 5)]


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("ship", ["box", "frigate"])
def test_the_severity_comes_from_the_parameters_and_not_from_the_seed(ship: str, cell: tuple[int, int, int]) -> None:
    vessel = BoxShip() if ship == "box" else load_ship("frigate")
    sea_state, heading, speed = cell
    given = (vessel, Spectrum(*SEA_STATES[sea_state]), Spreading(), math.radians(heading), speed * KNOT)
    drawn = np.array([values(draw_seaway(*given, np.random.default_rng(seed)).deck) for seed in range(4)])
    expected = values(spectral_deck_rms(*given))
    np.testing.assert_allclose(drawn, np.tile(expected, (4, 1)), rtol=0.03)
    assert np.all(np.std(drawn, axis=0, ddof=1) < 0.01 * np.mean(drawn, axis=0))


def seas(count: int, seed: int, long_crested: float, damping: tuple[float, float], gm: tuple[float, float]):
    """Seas of the training ranges: arguments of `draw_seaway` and, by name, the factors on the ship."""
    r = np.random.default_rng(seed)
    for _ in range(count):
        height = r.uniform(0.5, 5.0)
        spectrum = Spectrum(height, period_of_height(height) * r.uniform(0.85, 1.15), r.choice([1.0, 3.3]))
        spreading = Spreading("long_crested" if r.random() < long_crested else "cos2")
        given = (load_ship("frigate"), spectrum, spreading, r.uniform(0.0, 2.0 * math.pi), KNOT * r.uniform(0.0, 20.0))
        yield given, {"roll_damping_factor": r.uniform(*damping), "gm_factor": r.uniform(*gm)}


def of_the_grid(given, factors) -> np.ndarray:
    """Severities of the grid's cells, taken as waves: what a draw is to have."""
    ship, spectrum, spreading, heading, speed = given
    grid = sea_grid(spectrum, spreading)
    amplitude = np.sqrt(2.0 * grid.energy.ravel())
    response = ship.response.respond(grid.omega.ravel(), heading + grid.angle.ravel(), amplitude, speed, **factors)
    return values(linear_deck_rms(response.omega_e, response.transfer, amplitude, ship.deck_point_m, np.zeros(2)))


@pytest.mark.parametrize(("components", "worst", "usual"), [(24, 0.03, 1e-3), (48, 0.015, 3e-4), (96, 0.005, 1e-4)])
def test_every_sea_of_the_training_ranges_has_its_severity(components: int, worst: float, usual: float) -> None:
    """Half of them long-crested, where few waves answer near resonance and the energies are hard to correct."""
    missed = []
    for seed, (given, factors) in enumerate(seas(150, components, 0.5, (0.7, 1.3), (0.85, 1.15))):
        motion = draw_seaway(*given, np.random.default_rng(seed), components=components, **factors)
        missed.append(np.max(np.abs(values(motion.deck) / of_the_grid(given, factors) - 1.0)))
        # The waves stay many: none holds more of the elevation than a few of its kind.
        assert np.max(motion.waves.amplitude**2) < 0.5 * np.sum(motion.waves.amplitude**2)
    assert np.max(missed) < worst
    assert np.median(missed) < usual


@pytest.mark.parametrize(("damping", "worst"), [((0.5, 0.5), 0.05), ((0.7, 1.3), 0.03), ((2.0, 2.0), 0.02)])
def test_the_grid_is_the_spectral_integral_over_the_range_of_factors(damping, worst: float) -> None:
    for given, factors in seas(12, 5, 0.0, damping, (0.5, 2.0)):
        exact = values(spectral_deck_rms(*given, frequencies=300, directions=80, **factors))
        np.testing.assert_allclose(of_the_grid(given, factors), exact, rtol=worst)


@pytest.mark.parametrize("components", [24, 96, 256])
def test_the_severity_does_not_depend_on_the_number_of_waves(components: int) -> None:
    given = (BoxShip(), Spectrum(3.3, 9.7), Spreading(), 2.0, 5.0)
    motion = draw_seaway(*given, np.random.default_rng(1), components=components)
    np.testing.assert_allclose(values(motion.deck), values(spectral_deck_rms(*given)), rtol=0.03)
    assert np.sum(0.5 * motion.waves.amplitude**2) == pytest.approx(Spectrum(3.3, 9.7).variance, rel=0.01)


@pytest.mark.parametrize("spectrum", [Spectrum(3.3, 9.7), Spectrum(3.3, 9.7, 3.3)])
def test_long_crested_seas_agree_with_the_spectral_integral(spectrum: Spectrum) -> None:
    given = (BoxShip(), spectrum, Spreading("long_crested"), 1.2, 6.0)
    drawn = values(draw_seaway(*given, np.random.default_rng(1)).deck)
    np.testing.assert_allclose(drawn, values(spectral_deck_rms(*given)), rtol=0.01)


def test_the_spectral_integral_has_converged() -> None:
    given = (BoxShip(), Spectrum(0.9, 7.5), Spreading(), math.pi, 5.0)
    finer = values(spectral_deck_rms(*given, frequencies=300, directions=100))
    np.testing.assert_allclose(values(spectral_deck_rms(*given)), finer, rtol=3e-3)


def test_the_spectral_integral_of_a_ship_that_follows_the_sea() -> None:
    """A ship whose point only heaves with the sea has the sea's own moments, in closed form at speed 0."""

    class Cork:
        def respond(self, omega, heading, amplitude, speed_mps, **factors):
            from ssmash_gym.ship.response import Response

            transfer = np.zeros((len(omega), 6), dtype=complex)
            transfer[:, 2] = -1.0
            return Response(omega, transfer, 0.0, True)

    spectrum = Spectrum(2.0, 8.0)
    rms = spectral_deck_rms(BoxShip(response=Cork()), spectrum, Spreading(), 0.3, 0.0)
    omega = np.linspace(0.5 * spectrum.peak, 2.4, 100_001)
    rate = math.sqrt(np.trapezoid(spectrum.density(omega) * omega**2, omega))
    assert rms.heave_m == pytest.approx(0.5, rel=0.01)
    assert rms.vertical_velocity_m_s == pytest.approx(rate, rel=1e-3)
    assert rms.roll_deg == rms.lateral_acceleration_g == 0.0
    assert math.isnan(rms.roll_period_s)


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.08, -0.04)])
def test_the_long_run_is_what_long_records_show(angles: tuple[float, float]) -> None:
    """Linear severity from the waves against the sampled motion, specific force and all, in a low sea.

    No two of these waves meet the ship at frequencies so alike that they beat for longer than the record.
    """
    drawn = draw_seaway(BoxShip(), Spectrum(0.5, 9.0), Spreading(), 1.2, 5.0, np.random.default_rng(6), components=24)
    motion = SeawayMotion(drawn.waves, drawn.response, [-45.0, 3.0, -6.0], angles)
    long, exact = Motion.deck_rms(motion, 12_000.0), motion.deck
    for key in (*JUDGED, "heave_m", "lateral_acceleration_g", "roll_period_s"):
        assert getattr(long, key) == pytest.approx(getattr(exact, key), rel=0.02), key


def test_lateral_specific_force_has_gravity_with_the_right_sign() -> None:
    """In a long beam swell the deck leans into the slope, and a load on it hardly slides for all the acceleration."""
    omega, across, amplitude = np.array([0.15]), np.array([0.5 * math.pi]), np.array([2.0])
    waves = Waves(omega, across, amplitude, np.zeros(1))
    response = BoxShip().response.respond(omega, across, amplitude, 0.0)
    centre = SeawayMotion(waves, response, [0.0, 0.0, 0.0])
    assert centre.deck.lateral_acceleration_g == pytest.approx(2.0 * 0.15**2 / math.sqrt(2.0) / 9.81, rel=0.05)
    assert centre.deck.lateral_specific_force_g < 0.15 * centre.deck.lateral_acceleration_g
    sampled = Motion.deck_rms(centre, 2.0 * math.pi / 0.15 * 10.0)
    assert sampled.lateral_specific_force_g == pytest.approx(centre.deck.lateral_specific_force_g, rel=0.01)


def test_deck_rms_of_a_sinusoid() -> None:
    rms = Sinusoid(dof="roll", amplitude_deg=4.0, period_s=10.0, roll_deg=2.0).realise().deck_rms(1000.0)
    assert rms.roll_deg == pytest.approx(4.0 / math.sqrt(2.0), rel=1e-3)
    assert rms.roll_period_s == pytest.approx(10.0, rel=1e-3)
    assert rms.lateral_specific_force_g == pytest.approx(math.radians(4.0) / math.sqrt(2.0), rel=3e-3)
    assert rms.pitch_deg == rms.vertical_velocity_m_s == 0.0
    assert rms.lateral_acceleration_g == pytest.approx(0.0, abs=1e-12)


def test_deck_rms_of_a_still_and_of_an_irregular_deck() -> None:
    still = parse_motion({"type": "fixed", "roll_deg": 5.0}).realise().deck_rms()
    assert still.roll_deg == pytest.approx(0.0, abs=1e-12)
    assert math.isnan(still.roll_period_s)
    source = Irregular.model_validate({"heave": {"rms_m": 0.7, "period_s": 7.5}})
    motion = source.realise(np.random.default_rng(0))
    rms, sines = motion.deck_rms(6000.0), motion.components[0]
    assert rms.heave_m == pytest.approx(0.7, rel=0.05)
    acceleration = math.sqrt(0.5 * np.sum((sines.amplitude * sines.omega**2) ** 2)) / 9.81
    assert rms.vertical_acceleration_g == pytest.approx(acceleration, rel=0.05)
    with pytest.raises(ConfigurationError, match="duration_s is -1"):
        motion.deck_rms(-1.0)


def test_a_ten_minute_record_scatters_about_the_long_run() -> None:
    """A finite record of a narrow-banded roll differs from the long run by several percent, by nature."""
    ratios = []
    for seed in range(8):
        motion = draw_seaway(BoxShip(), Spectrum(3.3, 9.7), Spreading(), 1.5, 5.0, np.random.default_rng(seed))
        ratios.append(Motion.deck_rms(motion, 600.0).roll_deg / motion.deck_rms(600.0).roll_deg)
    assert 0.02 < np.std(ratios) < 0.2
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1)
