"""A ship by formulas: a floating box, for tests that need some ship and no particular one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ssmash_gym.ship.response import Response

G = 9.81
LENGTH, BEAM, DRAUGHT = 120.0, 14.0, 4.5
ROLL, HEAVE, PITCH = 2.0 * np.pi / 10.5, 2.0 * np.pi / 5.5, 2.0 * np.pi / 5.4


class BoxResponse:
    """Froude-Krylov forces on a box, each degree of freedom an oscillator; roll damping grows with the roll rate."""

    def respond(self, omega, heading, amplitude, speed_mps, *, roll_damping_factor=1.0, gm_factor=1.0) -> Response:
        k = omega**2 / G
        omega_e = omega - k * speed_mps * np.cos(heading)
        along, across = k * np.cos(heading), k * np.sin(heading)
        depth = np.exp(-k * DRAUGHT)
        mean = depth * np.sinc(along * LENGTH / (2.0 * np.pi)) * np.sinc(across * BEAM / (2.0 * np.pi))
        half = 0.5 * along * LENGTH
        safe = np.where(np.abs(half) < 1e-3, 1.0, half)
        bend = np.where(np.abs(half) < 1e-3, 1.0, 3.0 * (np.sin(safe) - safe * np.cos(safe)) / safe**3)
        transfer = np.zeros((len(omega), 6), dtype=complex)
        transfer[:, 0] = -1j * np.cos(heading) * mean
        transfer[:, 1] = -1j * np.sin(heading) * mean
        transfer[:, 2] = -mean * oscillator(omega_e / HEAVE, 0.3)
        transfer[:, 4] = -1j * along * depth * bend * oscillator(omega_e / PITCH, 0.3)
        transfer[:, 5] = -0.2j * along * np.sin(heading) * depth * bend
        zeta = 0.1
        for _ in range(12):
            roll = 1j * across * mean * oscillator(omega_e / (ROLL * np.sqrt(gm_factor)), zeta)
            rate = np.sqrt(0.5 * np.sum(np.abs(omega_e * roll * amplitude) ** 2))
            zeta = roll_damping_factor * (0.05 + 0.004 * speed_mps + 0.8 * rate)
        transfer[:, 3] = roll
        return Response(omega_e=omega_e, transfer=transfer, roll_damping=zeta, converged=True)


def oscillator(ratio, zeta):
    """Dynamic magnification, complex, for time as exp(+i omega t); `ratio` is frequency over natural frequency."""
    return 1.0 / (1.0 - ratio**2 + 2j * zeta * ratio)


@dataclass(frozen=True, eq=False)  # as `Ship`
class BoxShip:
    name: str = "box"
    deck_point_m: np.ndarray = field(default_factory=lambda: np.array([-45.0, 0.0, -6.0]))
    response: BoxResponse = field(default_factory=BoxResponse)
