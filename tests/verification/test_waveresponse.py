"""The spectral statistics of a ship at rest against waveresponse, an independent code (MIT) with its own sea.

Handed over are the transfer functions alone. Spectrum, spreading, directions, integration: all waveresponse's.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssmash_gym.ship.sea import SEA_STATES, Spectrum, Spreading, comes_from_deg
from ssmash_gym.ship.seaway_statistics import quadrature, spectral_deck_rms
from ssmash_gym.ship.ships import load_ship

wr = pytest.importorskip("waveresponse")
pytestmark = pytest.mark.filterwarnings("ignore:The `:DeprecationWarning:waveresponse")  # its own calls of its own

HS, TP = SEA_STATES[5]
FREQUENCIES = np.linspace(0.30, 2.40, 211)  # [rad/s]; 0.01 rad/s resolves the roll peak
DIRECTIONS = np.arange(0.0, 360.0, 5.0)  # [deg]
COURSE = 30.0  # the ship's course over ground [deg]; the sea is given to waveresponse by compass


def transfer(heading_deg: float) -> tuple[np.ndarray, float]:
    """H (frequencies, directions, 6) of the frigate at rest, its roll damped as in this sea, and that damping."""
    ship = load_ship("frigate")
    omega, angle, amplitude = quadrature(Spectrum(HS, TP), Spreading("cos2"), 160, 60)
    w, beta = (grid.ravel() for grid in np.meshgrid(FREQUENCIES, np.radians(DIRECTIONS), indexing="ij"))
    # The grid's waves have no height: the roll damping is that of the sea's waves.
    response = ship.response.respond(
        np.concatenate([w, omega]),
        np.concatenate([beta, math.radians(heading_deg) + angle]),
        np.concatenate([np.zeros_like(w), amplitude]),
        0.0,
    )
    H = response.transfer[: len(w)].reshape(len(FREQUENCIES), len(DIRECTIONS), 6)
    return H, response.roll_damping


@pytest.mark.parametrize("heading_deg", [90.0, 135.0])
def test_motions_of_a_ship_at_rest_agree_within_a_percent(heading_deg: float) -> None:
    """SS5 (3.3 m, 9.7 s), cos^2: heave, roll and pitch of the centre of gravity; a beam sea, and one on the bow."""
    ship = load_ship("frigate")
    own = spectral_deck_rms(
        ship, Spectrum(HS, TP), Spreading("cos2"), math.radians(heading_deg), 0.0, deck_shift=-ship.deck_point_m
    )
    from_north = (comes_from_deg(heading_deg) + COURSE) % 360.0
    sea = wr.WaveSpectrum.from_spectrum1d(
        FREQUENCIES,
        DIRECTIONS,
        wr.ModifiedPiersonMoskowitz(FREQUENCIES)(HS, TP)[1],
        wr.CosineHalfSpreading(s=1, degrees=True),
        from_north,
        degrees=True,
        clockwise=True,
        waves_coming_from=True,
    )
    assert sea.hs == pytest.approx(HS, rel=0.01)
    H, damping = transfer(heading_deg)
    assert 0.01 < damping < 0.2

    def rms(dof: int) -> float:
        rao = wr.RAO(FREQUENCIES, DIRECTIONS, H[:, :, dof], degrees=True, clockwise=True, waves_coming_from=False)
        return float(wr.calculate_response(rao, sea, COURSE, heading_degrees=True).std())

    heave, roll, pitch = rms(2), math.degrees(rms(3)), math.degrees(rms(4))
    print(
        f"heading {heading_deg:g}: waveresponse/own heave {heave:.4f}/{own.heave_m:.4f} m, "
        f"roll {roll:.4f}/{own.roll_deg:.4f} deg, pitch {pitch:.4f}/{own.pitch_deg:.4f} deg, zeta4 {damping:.4f}"
    )
    assert heave == pytest.approx(own.heave_m, rel=0.01)
    assert roll == pytest.approx(own.roll_deg, rel=0.01)
    assert pitch == pytest.approx(own.pitch_deg, rel=0.01)
