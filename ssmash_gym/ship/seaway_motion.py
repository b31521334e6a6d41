"""Motion of a ship's deck point in one drawn sea.

Linear theory gives the ship's centre of gravity G and its yaw-pitch-roll angles as sums of sines at the waves'
encounter frequencies. The deck point follows from them by rigid-body kinematics without further approximation, so
position, velocity and acceleration of the deck belong to one another to the last digit.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray, angular_acceleration, angular_velocity, rotation
from ssmash_gym.ship.motion import RMS_DURATION_S, DeckRms, Motion, Signal
from ssmash_gym.ship.response import Response
from ssmash_gym.ship.seaway_statistics import linear_deck_rms
from ssmash_gym.ship.waves import Waves

BLOCK: Final = 32  # nodes that share one set of sines and cosines in `SeawayMotion.sample`
# Of the fastest waves that matter (`SeawayMotion.shortest_period_s`): tables of 0.25 s hold any sea up to 25 kn, with
# accelerations within 0.05 % of their standard deviation, 0.5 % at 25 kn into short waves.
NODES_PER_PERIOD: Final = 2.5
FAST_SHARE: Final = 0.99  # of the acceleration's energy is to be followed closely; the nodes hold the rest, too
VALID_ROLL_DEG: Final = 6.0  # RMS; beyond it linear response is not to be trusted (assumed)


class SeawayMotion(Motion):
    """Motion of a ship's deck point in one drawn sea.

    Args:
        waves: The drawn waves, n of them.
        response: The ship's response to them.
        point: Deck point from the ship's centre of gravity, S axes [m], (3,).
        mean_angles: Constant heel and trim [rad], (2,), added to roll and pitch.

    Attributes:
        waves: As given.
        response: As given.
        point: As given, read-only.
    """

    def __init__(
        self, waves: Waves, response: Response, point: npt.ArrayLike, mean_angles: npt.ArrayLike = (0.0, 0.0)
    ) -> None:
        self.waves = waves
        self.response = response
        self.point = np.array(point, dtype=np.float64)
        self.point.flags.writeable = False
        self._mean = np.concatenate([np.zeros(3), np.asarray(mean_angles, dtype=np.float64), [0.0]])
        self._mean.flags.writeable = False
        amplitude = waves.amplitude * np.exp(1j * waves.phase)
        self._motion = response.transfer * amplitude[:, np.newaxis]  # (n, 6), of G at t = 0

    @property
    def mean(self) -> FloatArray:
        """Mean pose (6,) [m, rad]: no displacement, heel and trim."""
        return self._mean

    @property
    def rms(self) -> FloatArray:
        """Long-run RMS (6,) of surge, sway, heave of G [m] and roll, pitch, yaw [rad] about the mean."""
        variance = 0.5 * np.sum(self._motion.real**2 + self._motion.imag**2, axis=0)
        return np.asarray(np.sqrt(variance), dtype=np.float64)

    @property
    def elevation_rms_m(self) -> float:
        """Long-run RMS of the elevation [m]; a quarter of the wave height less what is shorter than any drawn wave."""
        return math.sqrt(0.5 * float(np.sum(self.waves.amplitude**2)))

    @cached_property
    def deck(self) -> DeckRms:
        """Long-run severity of the deck point, exact for the drawn waves (linear about the mean attitude)."""
        return linear_deck_rms(
            self.response.omega_e, self.response.transfer, self.waves.amplitude, self.point, self._mean[3:5]
        )

    def deck_rms(self, duration_s: float = RMS_DURATION_S) -> DeckRms:
        """`deck`, whatever the duration: the long run needs no sampling."""
        return self.deck

    @property
    def outside_validity(self) -> str | None:
        """One sentence where the long-run roll is too large for linear theory, else None."""
        if self.deck.roll_deg <= VALID_ROLL_DEG:
            return None
        return (
            f"roll RMS is {self.deck.roll_deg:.1f} deg, linear ship response is valid up to about "
            f"{VALID_ROLL_DEG:g} deg (no parametric roll, no broaching, no green water)"
        )

    @cached_property
    def shortest_period_s(self) -> float:
        """Encounter period [s] of the fastest waves that matter: faster ones hold 1 % of the deck point's acceleration.

        Infinite for a deck that does not move.
        """
        frequency = np.abs(self.response.omega_e)
        moved = self._motion[:, :3] + np.cross(self._motion[:, 3:], self.point)  # of the deck point, linear
        energy = np.sum(moved.real**2 + moved.imag**2, axis=1) * frequency**4
        order = np.argsort(frequency)
        total = np.cumsum(energy[order])
        if not total[-1] > 0.0:
            return math.inf
        return 2.0 * math.pi / float(frequency[order][np.searchsorted(total, FAST_SHARE * total[-1])])

    def elevation(self, t: npt.ArrayLike) -> FloatArray:
        """Height of the undisturbed sea at G's mean place [m], up positive, at times `t` [s], shape (n,)."""
        time = np.atleast_1d(np.asarray(t, dtype=np.float64))
        angle = np.outer(time, self.response.omega_e) + self.waves.phase
        return np.asarray(np.einsum("tk,k->t", np.cos(angle), self.waves.amplitude), dtype=np.float64)

    def signal(self, t: npt.ArrayLike) -> Signal:
        """Six channels of the deck point and their exact derivatives at times `t` [s], (n,): three arrays (n, 6)."""
        time = np.atleast_1d(np.asarray(t, dtype=np.float64))
        angle = np.outer(time, self.response.omega_e)
        basis = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
        return self._deck(np.einsum("tk,dck->dtc", basis, self._weights(self._motion[np.newaxis])[0]))

    def sample(self, start_s: float, spacing_s: float, count: int) -> Signal:
        """`signal` at evenly spaced times, some ten times faster by the addition theorem.

        The times are cut into blocks. The six degrees of freedom share their frequencies, so one set of cosines and
        sines of the offsets within a block serves all of them and their derivatives; a block's start enters through
        the turned complex amplitudes. Sums run over the waves in a fixed order: the bits depend neither on `count` nor
        on threads.

        Raises:
            ConfigurationError: The spacing is too wide for the fastest waves that matter.
        """
        limit = self.shortest_period_s / NODES_PER_PERIOD
        if spacing_s > limit * (1.0 + 1e-9):
            raise ConfigurationError(
                f"bake: spacing_s is {spacing_s:g}, allowed is at most {limit:.4g} s for the shortest encounter "
                f"period that matters, {self.shortest_period_s:.4g} s"
            )
        blocks = -(-count // BLOCK)
        start = start_s + spacing_s * BLOCK * np.arange(blocks)
        angle = np.outer(spacing_s * np.arange(BLOCK), self.response.omega_e)
        basis = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
        turned = np.exp(1j * np.outer(start, self.response.omega_e))[:, :, np.newaxis] * self._motion
        # No matrix library here: its sums may depend on the number of threads.
        parts = np.einsum("bdck,jk->dbjc", self._weights(turned), basis)
        return self._deck(parts.reshape(3, blocks * BLOCK, 6)[:, :count])

    def _weights(self, motion: npt.NDArray[np.complex128]) -> FloatArray:
        """Weights of cosines and sines of encounter phase for the motion and two derivatives.

        Args:
            motion: Complex amplitudes (b, n, 6) at the start of each of b blocks.

        Returns:
            Real (b, 3, 6, 2 n): ``Re(c exp(i w t)) = Re(c) cos(w t) - Im(c) sin(w t)``, and a derivative is ``i w c``.
        """
        c = np.ascontiguousarray(np.swapaxes(motion, 1, 2))  # (b, 6, n)
        w = self.response.omega_e
        rows = [(c.real, -c.imag), (-w * c.imag, -w * c.real), (-(w**2) * c.real, w**2 * c.imag)]
        return np.stack([np.concatenate(pair, axis=2) for pair in rows], axis=1)

    def _deck(self, parts: FloatArray) -> Signal:
        """From G to the deck point: ``p = p_G + (R - R_mean) r`` and its exact derivatives.

        Args:
            parts: Motion of G about the mean and its two derivatives, (3, n, 6).
        """
        q, qd, qdd = parts[0] + self._mean, parts[1], parts[2]
        angles, rates = q[:, 3:], qd[:, 3:]
        r = self.point
        R = rotation(angles)
        w, wdot = angular_velocity(angles, rates), angular_acceleration(angles, rates, qdd[:, 3:])
        speed = _cross(w, np.broadcast_to(r, w.shape))
        levers = np.stack(
            [np.broadcast_to(r, w.shape), speed, _cross(wdot, np.broadcast_to(r, w.shape)) + _cross(w, speed)]
        )
        moved = np.einsum("nij,dnj->dni", R, levers)
        moved[0] -= np.einsum("ij,j->i", rotation(self._mean[3:]), r)
        out = np.array([q, qd, qdd])
        out[:, :, :3] += moved
        return Signal(*out)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Vector product of (n, 3) arrays."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
