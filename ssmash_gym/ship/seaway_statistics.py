"""Long-run severity of a deck in a sea, by linear theory: from drawn waves, or straight from the spectrum."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
import numpy.typing as npt

from ssmash_gym.ship.kinematics import FloatArray, rotation
from ssmash_gym.ship.motion import GRAVITY, DeckRms
from ssmash_gym.ship.sea import HIGHEST, LOWEST, Spectrum, Spreading

if TYPE_CHECKING:
    from ssmash_gym.ship.ships import Ship

FREQUENCIES: Final = 160
DIRECTIONS: Final = 60
SEVERITIES: Final = 7  # columns of `severity_powers`
NOTHING: Final = 1e-12  # least power per metre of wave, squared, that counts as a response


class DeckTransfer(NamedTuple):
    """Complex response of the deck point per metre of wave amplitude, each (n,).

    Attributes:
        roll: Roll [rad/m].
        pitch: Pitch [rad/m].
        vertical: Displacement down, N axes [m/m].
        lateral: Acceleration to starboard, S axes [m/s2/m].
        lateral_specific_force: The same less the component of gravity, S axes [m/s2/m].
    """

    roll: npt.NDArray[np.complex128]
    pitch: npt.NDArray[np.complex128]
    vertical: npt.NDArray[np.complex128]
    lateral: npt.NDArray[np.complex128]
    lateral_specific_force: npt.NDArray[np.complex128]


def deck_transfer(
    omega_e: FloatArray, transfer: npt.NDArray[np.complex128], point: FloatArray, mean_angles: FloatArray
) -> DeckTransfer:
    """Responses of the deck point from those of the ship's centre of gravity, linear about the mean attitude.

    With the mean attitude ``R`` and the point's lever ``r``, a small change of roll, pitch and yaw moves the point by
    ``R (e_x x r)``, ``e_y x R r`` and ``e_z x R r`` (z-y-x sequence, mean yaw zero). The specific force to starboard is
    ``a_y - g roll`` on an even keel.

    Args:
        omega_e: Encounter frequencies, signed [rad/s], (n,).
        transfer: Surge, sway, heave, roll, pitch, yaw per metre of wave [m/m, rad/m], (n, 6).
        point: Deck point from the centre of gravity, S axes [m], (3,).
        mean_angles: Mean roll (heel) and pitch (trim) [rad], (2,).
    """
    R = rotation(np.array([mean_angles[0], mean_angles[1], 0.0]))
    lever = np.einsum("ij,j->i", R, point)
    turned = (
        np.einsum("ij,j->i", R, np.array([0.0, -point[2], point[1]])),  # R (e_x x r)
        np.array([lever[2], 0.0, -lever[0]]),  # e_y x R r
        np.array([-lever[1], lever[0], 0.0]),  # e_z x R r
    )
    moved = [transfer[:, k] + sum(transfer[:, 3 + j] * turned[j][k] for j in range(3)) for k in range(3)]
    lateral = -(omega_e**2) * sum(R[k, 1] * moved[k] for k in range(3))
    (s_heel, s_trim), (c_heel, c_trim) = np.sin(mean_angles), np.cos(mean_angles)
    lean = c_trim * c_heel * transfer[:, 3] - s_trim * s_heel * transfer[:, 4]
    return DeckTransfer(transfer[:, 3], transfer[:, 4], moved[2], lateral, lateral - GRAVITY * lean)


def severity_powers(omega_e: FloatArray, deck: DeckTransfer) -> FloatArray:
    """Squared magnitudes of what makes a deck severe, per squared metre of wave amplitude.

    Args:
        omega_e: Encounter frequencies, signed [rad/s], (n,).
        deck: Response of the deck point.

    Returns:
        Array (n, 7): elevation (1), roll, pitch, vertical displacement, vertical velocity, vertical acceleration and
        lateral specific force.
    """
    square = omega_e**2
    roll, pitch, vertical, force = (
        part.real**2 + part.imag**2 for part in (deck.roll, deck.pitch, deck.vertical, deck.lateral_specific_force)
    )
    columns = (np.ones_like(omega_e), roll, pitch, vertical, vertical * square, vertical * square**2, force)
    return np.stack(columns, axis=1)


def linear_deck_rms(
    omega_e: FloatArray,
    transfer: npt.NDArray[np.complex128],
    amplitude: FloatArray,
    point: FloatArray,
    mean_angles: FloatArray,
) -> DeckRms:
    """Long-run root mean squares of a sum of waves with random phases: ``sqrt(sum |a H|^2 / 2)``.

    Args:
        omega_e: Encounter frequencies, signed [rad/s], (n,).
        transfer: Response of the centre of gravity [m/m, rad/m], (n, 6).
        amplitude: Amplitudes of the waves [m], (n,).
        point: Deck point from the centre of gravity, S axes [m], (3,).
        mean_angles: Mean roll and pitch [rad], (2,).
    """
    deck = deck_transfer(omega_e, transfer, point, mean_angles)
    energy, rate = 0.5 * amplitude**2, omega_e**2

    def rms(response: npt.NDArray[np.complex128], weight: FloatArray | float = 1.0) -> float:
        return math.sqrt(float(np.sum(energy * weight * (response.real**2 + response.imag**2))))

    roll, roll_rate = rms(deck.roll), rms(deck.roll, rate)
    return DeckRms(
        roll_deg=math.degrees(roll),
        pitch_deg=math.degrees(rms(deck.pitch)),
        heave_m=rms(deck.vertical),
        vertical_velocity_m_s=rms(deck.vertical, rate),
        vertical_acceleration_g=rms(deck.vertical, rate**2) / GRAVITY,
        lateral_acceleration_g=rms(deck.lateral) / GRAVITY,
        lateral_specific_force_g=rms(deck.lateral_specific_force) / GRAVITY,
        roll_period_s=2.0 * math.pi * roll / roll_rate if roll_rate > 0.0 else math.nan,
    )


def spectral_deck_rms(
    ship: Ship,
    spectrum: Spectrum,
    spreading: Spreading,
    heading: float,
    speed_mps: float,
    *,
    deck_shift: npt.ArrayLike = (0.0, 0.0, 0.0),
    mean_angles: npt.ArrayLike = (0.0, 0.0),
    roll_damping_factor: float = 1.0,
    gm_factor: float = 1.0,
    frequencies: int = FREQUENCIES,
    directions: int = DIRECTIONS,
) -> DeckRms:
    """Long-run severity of a ship's deck straight from the spectrum, by quadrature over frequency and direction.

    Independent of any draw: midpoints of evenly spaced frequencies from half the peak frequency to 2.4 rad/s and of
    evenly spaced directions, each with the energy of its cell. The roll damping is linearised on the same points, as
    for drawn waves.

    Args:
        ship: The ship.
        spectrum: Spectrum of the elevation.
        spreading: Distribution of directions.
        heading: Main direction of travel relative to the ship's heading [rad].
        speed_mps: Ship's speed [m/s].
        deck_shift: Added to the ship's deck point, S axes [m], (3,).
        mean_angles: Mean roll (heel) and pitch (trim) [rad], (2,).
        roll_damping_factor: Multiplies the roll damping.
        gm_factor: Multiplies the metacentric height.
        frequencies: Points over frequency.
        directions: Points over direction.

    Returns:
        Root mean squares of the deck point.
    """
    omega, angle, amplitude = quadrature(spectrum, spreading, frequencies, directions)
    response = ship.response.respond(
        omega, heading + angle, amplitude, speed_mps, roll_damping_factor=roll_damping_factor, gm_factor=gm_factor
    )
    point = ship.deck_point_m + np.asarray(deck_shift, dtype=np.float64)
    angles = np.asarray(mean_angles, dtype=np.float64)
    return linear_deck_rms(response.omega_e, response.transfer, amplitude, point, angles)


def quadrature(
    spectrum: Spectrum, spreading: Spreading, frequencies: int, directions: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points over frequency and direction with the amplitude ``sqrt(2 S dw D dtheta)`` of their cells.

    Args:
        spectrum: Spectrum of the elevation.
        spreading: Distribution of directions; a long-crested sea has one.
        frequencies: Points over frequency.
        directions: Points over direction.

    Returns:
        Wave frequencies [rad/s], angles from the main direction [rad], amplitudes [m], each (frequencies * directions,)
        or (frequencies,) for a long-crested sea.
    """
    edges = np.linspace(LOWEST * spectrum.peak, HIGHEST, frequencies + 1)
    omega = 0.5 * (edges[1:] + edges[:-1])
    energy = spectrum.density(omega) * np.diff(edges)
    if spreading.name == "long_crested":
        return omega, np.zeros_like(omega), np.sqrt(2.0 * energy)
    step = math.pi / directions
    angle = -0.5 * math.pi + step * (0.5 + np.arange(directions))
    amplitude = np.sqrt(2.0 * np.outer(energy, spreading.density(angle) * step))
    return np.repeat(omega, directions), np.tile(angle, frequencies), amplitude.ravel()
