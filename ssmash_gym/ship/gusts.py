"""Gusts along the true wind: a wind spectrum drawn as sines, and the node table that the dynamics read."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, TIME_SLACK, NodeTable, positive, smootherstep

HEIGHT_M: Final = 10.0  # assumed: where a helicopter on a frigate's flight deck meets the wind, above the sea
LENGTH_OVER_HEIGHT: Final = 8.1 * 0.7  # Kaimal length scale over height, IEC 61400-1, below 60 m
BAND_HZ: Final = (0.01, 0.8)  # assumed: slower is another mean wind to an episode, faster averages out over a body
SLOWEST_MPS: Final = 0.01  # a mean wind below that has the spectrum's shape of that one: of a calm it has none
NODES_PER_PERIOD: Final = 4.0  # of the fastest gust: below that the quintic pieces no longer follow it


def slower_share(frequency_hz: npt.ArrayLike, mean_mps: float, height_m: float = HEIGHT_M) -> FloatArray:
    """Share of the variance of the Kaimal spectrum that lies below frequencies, exact.

    The spectrum of the speed along the wind is ``f S / sigma^2 = 4 x / (1 + 6 x)^(5/3)`` with ``x = f L / U`` and
    ``L = 8.1 * 0.7 z`` at heights z below 60 m (IEC 61400-1; Kaimal et al. 1972).

    Args:
        frequency_hz: Frequencies [Hz], any shape.
        mean_mps: Mean wind U [m/s], above 0.
        height_m: Height z above the sea [m].

    Returns:
        Shares in [0, 1), shaped as the frequencies.
    """
    x = np.asarray(frequency_hz, dtype=np.float64) * (LENGTH_OVER_HEIGHT * height_m / mean_mps)
    return np.asarray(1.0 - (1.0 + 6.0 * x) ** (-2.0 / 3.0), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Gust:
    """Speed of the gusts along the true wind: ``sum_k amplitude_k sin(omega_k t + phase_k)``.

    Attributes:
        omega: Angular frequencies [rad/s], (n,).
        amplitude: Amplitudes [m/s], (n,).
        phase: Phases [rad], (n,).
    """

    omega: FloatArray
    amplitude: FloatArray
    phase: FloatArray

    @classmethod
    def draw(
        cls,
        mean_mps: float,
        intensity: float,
        rng: np.random.Generator,
        components: int = 24,
        *,
        height_m: float = HEIGHT_M,
    ) -> Self:
        """Draw gusts whose long-run RMS is exactly ``intensity * mean_mps``, with the shape of the Kaimal spectrum.

        The band `BAND_HZ` is cut into bins of equal ratio; each holds one component, at a random frequency and phase,
        with the bin's share of the variance in the band. What the spectrum has beyond the band is left out, and the
        rest scaled up to the RMS: see `band_share`. The same numbers are drawn whatever the wind is.

        Args:
            mean_mps: Mean true wind speed [m/s]; no wind, no gusts.
            intensity: RMS of the gusts over the mean wind.
            rng: Generator; `components` places, then as many phases are drawn.
            components: How many sines.
            height_m: Height above the sea [m], which sets the length scale.

        Raises:
            ConfigurationError: A negative speed or intensity, a height that is not positive, or no component.
        """
        mean, share = finite("gust", "mean_mps", mean_mps), finite("gust", "intensity", intensity)
        for key, value in (("mean_mps", mean), ("intensity", share)):
            if value < 0.0:
                raise ConfigurationError(f"gust: {key} is {value:g}, allowed are numbers of 0 or more")
        if isinstance(components, bool) or not isinstance(components, int | np.integer) or components < 1:
            raise ConfigurationError(f"gust: components is {components!r}, allowed are whole numbers of 1 or more")
        height = positive("gust", "height_m", height_m)
        edges = np.geomspace(*BAND_HZ, components + 1)
        place, phase = rng.random(components), rng.uniform(0.0, 2.0 * math.pi, components)
        omega = 2.0 * math.pi * edges[:-1] * (edges[1:] / edges[:-1]) ** place
        if mean * share == 0.0:
            return cls(omega, np.zeros(components), phase)
        energy = np.diff(slower_share(edges, max(mean, SLOWEST_MPS), height))
        return cls(omega, share * mean * np.sqrt(2.0 * energy / np.sum(energy)), phase)

    @property
    def rms(self) -> float:
        """Long-run root mean square [m/s], from the amplitudes."""
        return float(np.sqrt(0.5 * np.sum(self.amplitude**2)))

    def at(self, t: npt.ArrayLike) -> FloatArray:
        """Speed [m/s], rate [m/s2] and acceleration [m/s3] at times `t` [s], shape (n,): (n, 3)."""
        angle = np.outer(np.asarray(t, dtype=np.float64), self.omega) + self.phase
        sine, cosine = np.sin(angle), np.cos(angle)
        weights = (self.amplitude, self.amplitude * self.omega, -self.amplitude * self.omega**2)
        columns = [np.einsum("tk,k->t", wave, w) for wave, w in zip((sine, cosine, sine), weights, strict=True)]
        return np.stack(columns, axis=1)

    def bake(
        self, duration_s: float, spacing_s: float = DEFAULT_SPACING_S, start_s: float = 0.0, *, ramp_s: float = 0.0
    ) -> GustTable:
        """Table of nodes of these gusts.

        Args:
            duration_s: Time the table must cover [s]; rounded up to whole spacings.
            spacing_s: Time between nodes [s].
            start_s: Time of the gusts at the table's start [s].
            ramp_s: Time in which the gusts grow from nothing, as `Motion.bake` ramps a motion [s]; 0 for none.

        Raises:
            ConfigurationError: A duration or spacing that is not positive, a negative ramp, a start that is not
                finite, or a spacing too wide for the fastest component.
        """
        duration, h = positive("gust", "duration_s", duration_s), positive("gust", "spacing_s", spacing_s)
        start, ramp = finite("gust", "start_s", start_s), finite("gust", "ramp_s", ramp_s)
        if ramp < 0.0:
            raise ConfigurationError(f"gust: ramp_s is {ramp:g}, allowed are numbers of 0 s or more")
        widest = 2.0 * math.pi / float(np.max(self.omega)) / NODES_PER_PERIOD
        if h > widest * (1.0 + 1e-9):
            raise ConfigurationError(
                f"gust: spacing_s is {h:g}, allowed is at most {widest:.4g} s, a quarter of the fastest gust's period"
            )
        time = h * np.arange(max(1, math.ceil(duration / h - TIME_SLACK)) + 1, dtype=np.float64)
        nodes = self.at(start + time)
        if ramp > 0.0:
            q, qd, qdd = nodes.T
            r, rd, rdd = smootherstep(time, ramp)
            nodes = np.stack([r * q, r * qd + rd * q, r * qdd + 2.0 * rd * qd + rdd * q], axis=1)
        return GustTable(h, nodes)


def band_share(mean_mps: float, height_m: float = HEIGHT_M) -> float:
    """Share of the Kaimal spectrum's variance that lies within `BAND_HZ`, the rest being left out of a `Gust`.

    A turbulence intensity from ten-minute records, times the root of this share, is the intensity of what it has in
    the band.

    Args:
        mean_mps: Mean wind [m/s], above 0.
        height_m: Height above the sea [m].
    """
    low, high = slower_share(BAND_HZ, positive("band_share", "mean_mps", mean_mps), height_m)
    return float(high - low)


class GustTable(NodeTable):
    """Nodes of the gust speed along the true wind (n_nodes, 3): speed [m/s], rate [m/s2] and acceleration [m/s3]."""

    NAME = "gust table"
    CHANNEL_COUNT = 1

    def at(self, t: npt.ArrayLike) -> FloatArray:
        """Speed [m/s], rate [m/s2] and acceleration [m/s3] at times `t` [s] in [0, duration_s], (n,): (n, 3).

        Raises:
            ConfigurationError: A time outside the table.
        """
        return np.concatenate(self.interpolated(t), axis=-1)


def finite(where: str, key: str, value: float) -> float:
    """`value` as a float; refused with one sentence unless it is a finite number."""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not (number and math.isfinite(value)):
        raise ConfigurationError(f"{where}: {key} is {value!r}, allowed are finite numbers")
    return float(value)
