"""Motions that are sums of sines: a mean pose, one sinusoid, or the many components of an irregular motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import N_CHANNELS, RMS_DURATION_S, DeckRms, Motion, Signal, positive
from ssmash_gym.ship.seaway_statistics import linear_deck_rms

BLOCK: Final = 32  # nodes that share one set of sines and cosines in `Harmonics.sample`
NODES_PER_PERIOD: Final = 4.0  # of the fastest component: below that the quintic pieces no longer follow it
LOWEST: Final = 0.5  # band of the spectrum in units of the peak frequency: 2e-9 of the energy lies below,
HIGHEST: Final = 3.0  # 1.5 % above (cut off, because the acceleration's moment of the full tail does not converge)


@dataclass(frozen=True, eq=False)
class Component:
    """Sines of one channel: ``sum_k amplitude_k sin(omega_k t + phase_k)``.

    Attributes:
        channel: Index in `CHANNELS`.
        omega: Angular frequencies [rad/s], (n,).
        amplitude: Amplitudes [m or rad], (n,).
        phase: Phases [rad], (n,).
    """

    channel: int
    omega: FloatArray
    amplitude: FloatArray
    phase: FloatArray


class Harmonics(Motion):
    """A mean pose and sines in any of the six channels.

    Args:
        mean: Mean pose (6,) [m, rad].
        components: Sines, at most one entry a channel.
    """

    def __init__(self, mean: npt.ArrayLike, components: tuple[Component, ...] = ()) -> None:
        self._mean = np.array(mean, dtype=np.float64)
        self._mean.flags.writeable = False
        self.components = components

    @property
    def mean(self) -> FloatArray:
        """Mean pose (6,) [m, rad]."""
        return self._mean

    @property
    def rms(self) -> FloatArray:
        """Long-run root mean square (6,) [m, rad] about the mean pose, from the amplitudes."""
        rms = np.zeros(N_CHANNELS)
        for c in self.components:
            rms[c.channel] = np.sqrt(0.5 * np.sum(c.amplitude**2))
        return rms

    @cached_property
    def deck(self) -> DeckRms:
        """Long-run severity from the amplitudes, linear about the mean pose.

        Sines of one frequency in several channels add up with their phases. The mean yaw turns what moves forward
        and to starboard of N into what does so of the ship; gravity does not know of it.
        """
        sines = [c.omega for c in self.components]
        omega, place = np.unique(np.concatenate([*sines, np.zeros(0)]), return_inverse=True)
        amplitude = np.zeros((omega.size, N_CHANNELS), dtype=np.complex128)
        first = 0
        for c in self.components:
            np.add.at(amplitude[:, c.channel], place[first : first + c.omega.size], c.amplitude * np.exp(1j * c.phase))
            first += c.omega.size
        cos, sin = np.cos(self._mean[5]), np.sin(self._mean[5])
        x, y = amplitude[:, 0].copy(), amplitude[:, 1].copy()
        amplitude[:, 0], amplitude[:, 1] = cos * x + sin * y, cos * y - sin * x
        return linear_deck_rms(omega, amplitude, np.ones_like(omega), np.zeros(3), self._mean[3:5])

    def deck_rms(self, duration_s: float = RMS_DURATION_S) -> DeckRms:
        """`deck`, whatever the duration: the long run needs no sampling.

        Raises:
            ConfigurationError: A duration that is not positive.
        """
        positive("deck_rms", "duration_s", duration_s)
        return self.deck

    def signal(self, t: npt.ArrayLike) -> Signal:
        """Six channels and their exact derivatives at times `t` [s], shape (n,): three arrays (n, 6)."""
        time = np.atleast_1d(np.asarray(t, dtype=np.float64))
        out = self._still(len(time))
        for c in self.components:
            angle = np.outer(time, c.omega) + c.phase
            sine, cosine = np.sin(angle), np.cos(angle)
            out.position[:, c.channel] += np.einsum("tk,k->t", sine, c.amplitude)
            out.rate[:, c.channel] = np.einsum("tk,k->t", cosine, c.amplitude * c.omega)
            out.acceleration[:, c.channel] = np.einsum("tk,k->t", sine, -c.amplitude * c.omega**2)
        return out

    def sample(self, start_s: float, spacing_s: float, count: int) -> Signal:
        """`signal` at evenly spaced times, some ten times faster by the addition theorem.

        The times are cut into blocks; the sines of block starts and of offsets within a block are multiplied out.
        Sums run over components in a fixed order, so the bits depend neither on `count` nor on threads.

        Raises:
            ConfigurationError: The spacing is too wide for the fastest component.
        """
        out = self._still(count)
        blocks = -(-count // BLOCK)
        start = start_s + spacing_s * BLOCK * np.arange(blocks)
        offset = spacing_s * np.arange(BLOCK)
        for c in self.components:
            fastest = 2.0 * np.pi / float(np.max(c.omega))
            if spacing_s * NODES_PER_PERIOD > fastest * (1.0 + 1e-9):
                raise ConfigurationError(
                    f"bake: spacing_s is {spacing_s:g}, allowed is at most {fastest / NODES_PER_PERIOD:.4g} s, "
                    f"a quarter of the motion's shortest period of {fastest:.4g} s"
                )
            angle = np.outer(start, c.omega) + c.phase
            sine, cosine = np.sin(angle), np.cos(angle)
            turn = np.outer(offset, c.omega)
            basis = np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
            speed, acceleration = c.amplitude * c.omega, -c.amplitude * c.omega**2
            weights = (
                np.concatenate([c.amplitude * sine, c.amplitude * cosine], axis=1),
                np.concatenate([speed * cosine, -speed * sine], axis=1),
                np.concatenate([acceleration * sine, acceleration * cosine], axis=1),
            )
            for values, weight in zip(out, weights, strict=True):
                # No matrix library here: its sums may depend on the number of threads.
                values[:, c.channel] += np.einsum("bk,jk->bj", weight, basis).reshape(-1)[:count]
        return out

    def _still(self, count: int) -> Signal:
        return Signal(np.tile(self._mean, (count, 1)), np.zeros((count, N_CHANNELS)), np.zeros((count, N_CHANNELS)))


def spectrum_bins(count: int) -> tuple[FloatArray, FloatArray]:
    """Bins of a Bretschneider-shaped spectrum of unit variance, ``S ~ x^-5 exp(-1.25 x^-4)``.

    The edges share out half the energy and half the energy of the rate, so that slow and fast components are both
    well represented; each bin's energy is exact (difference of the closed-form integral).

    Args:
        count: Number of bins.

    Returns:
        Edges (count + 1,) in units of the peak frequency, and energies (count,) that add up to one.
    """
    from scipy.special import erfc  # here, so that importing the package stays quick

    grid = np.linspace(LOWEST, HIGHEST, 4001)
    energy, rate = np.exp(-1.25 * grid**-4.0), erfc(np.sqrt(1.25) * grid**-2.0)
    share = 0.5 * (energy - energy[0]) / (energy[-1] - energy[0]) + 0.5 * (rate - rate[0]) / (rate[-1] - rate[0])
    edges = np.interp(np.linspace(0.0, 1.0, count + 1), share, grid)
    integral = np.exp(-1.25 * edges**-4.0)
    return edges, np.diff(integral) / (integral[-1] - integral[0])


def irregular_component(
    channel: int,
    rms: float,
    period_s: float,
    bins: tuple[FloatArray, FloatArray],
    jitter: FloatArray,
    phase: FloatArray,
) -> Component:
    """Sines of one channel with an exact long-run RMS: one component a bin, at a random frequency within it.

    Args:
        channel: Index in `CHANNELS`.
        rms: Root mean square [m or rad].
        period_s: Period of the spectrum's peak [s].
        bins: Edges (n + 1,) and energies (n,) from `spectrum_bins`.
        jitter: Place of each frequency within its bin, in [0, 1), (n,).
        phase: Phases [rad], (n,).
    """
    edges, energy = bins
    omega = 2.0 * np.pi / period_s * (edges[:-1] + jitter * np.diff(edges))
    return Component(channel, omega, rms * np.sqrt(2.0 * energy), phase)
