"""The sea itself: sea states, wave spectra, spreading of directions, and the two ways of naming a wave direction.

Inside the package a heading is the direction the waves travel to, relative to the ship's heading: 0 following, 90
towards starboard, 180 head. Operators' charts name where the waves come from, 0 = head; `comes_from_deg` is the one
place where the two meet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import GRAVITY

KNOT: Final = 1852.0 / 3600.0  # [m/s]

# Most probable significant wave height [m] and peak period [s] of a sea state: STANAG 4194 Annex D, read in the header
# of an open file water_waves.hpp. It stops at 6; for 7 Bales (1983) has 7.5 m, 15.0 s (docs/theory/seaway.md, The sea).
SEA_STATES: Final[dict[int, tuple[float, float]]] = {
    2: (0.3, 6.3),
    3: (0.9, 7.5),
    4: (1.9, 8.8),
    5: (3.3, 9.7),
    6: (5.0, 12.4),
}
STEEPEST: Final = 0.06  # significant height over the wave length of the peak period; open seas stay below
# Peak periods [s]. At 5 s nine tenths of a Bretschneider sea's energy lie below `HIGHEST`, at 4 s eight: shorter seas
# would lose motion that small craft, say, do have.
TP_RANGE_S: Final = (5.0, 25.0)
LOWEST: Final = 0.5  # of the peak frequency: 2e-9 of a Bretschneider sea's energy lies below
HIGHEST: Final = 2.4  # [rad/s]; waves shorter than 11 m leave a ship of a hundred metres alone
GAMMA: Final = 3.3  # mean peakedness of JONSWAP (Hasselmann et al. 1973)

SpectrumName = Literal["bretschneider", "jonswap"]
SpreadingName = Literal["cos2", "long_crested"]


def comes_from_deg(heading_deg: npt.ArrayLike) -> FloatArray:
    """Direction the waves come from, as operators' charts have it, from the direction they travel to.

    Args:
        heading_deg: Direction of travel relative to the ship's heading [deg]: 0 following, 90 towards starboard.

    Returns:
        Direction of origin relative to the bow, clockwise [deg] in [0, 360): 0 head, 90 from starboard. The same
        function turns it back.
    """
    return np.asarray((np.asarray(heading_deg, dtype=np.float64) + 180.0) % 360.0, dtype=np.float64)


def encounter(
    omega: npt.ArrayLike, heading: npt.ArrayLike, speed_mps: npt.ArrayLike, gravity: float = GRAVITY
) -> FloatArray:
    """Encounter frequency ``omega - omega^2 / g U cos(heading)`` [rad/s], signed, never folded; arguments broadcast.

    Args:
        omega: Wave frequencies [rad/s].
        heading: Directions the waves travel relative to the ship's heading [rad].
        speed_mps: Ship speeds [m/s].
        gravity: g [m/s2].
    """
    w = np.asarray(omega, dtype=np.float64)
    along = np.asarray(speed_mps, dtype=np.float64) * np.cos(heading)
    return np.asarray(w - w * w / gravity * along, dtype=np.float64)


def period_of_height(hs_m: float) -> float:
    """Peak period that goes with a significant wave height, on straight lines between the pairs of `SEA_STATES`.

    Args:
        hs_m: Significant wave height [m], 0.3 to 5.0.

    Returns:
        Peak period [s].

    Raises:
        ConfigurationError: A height outside the pairs.
    """
    heights, periods = zip(*SEA_STATES.values(), strict=True)
    height = _number("hs_m", hs_m)
    if not heights[0] <= height <= heights[-1]:
        raise ConfigurationError(
            f"hs_m is {height:g}: without tp_s allowed is {heights[0]:g} to {heights[-1]:g} m, the range of the "
            "STANAG 4194 pairs from which the peak period is taken"
        )
    return float(np.interp(height, heights, periods))


def check_steepness(hs_m: float, tp_s: float) -> None:
    """Refuse a sea that no wind raises: negative, or steeper than ``hs <= 0.06 * g tp^2 / (2 pi)``.

    Args:
        hs_m: Significant wave height [m].
        tp_s: Peak period [s].

    Raises:
        ConfigurationError: Not finite, out of range or too steep.
    """
    height, period = _number("hs_m", hs_m), _number("tp_s", tp_s)
    if height < 0.0:
        raise ConfigurationError(f"hs_m is {height:g}, allowed is a significant wave height of 0 m or more")
    if not TP_RANGE_S[0] <= period <= TP_RANGE_S[1]:
        raise ConfigurationError(
            f"tp_s is {period:g}, allowed is a peak period of {TP_RANGE_S[0]:g} to {TP_RANGE_S[1]:g} s (waves beyond "
            f"{HIGHEST:g} rad/s are left out, and a shorter sea has too much of its energy there)"
        )
    limit = STEEPEST * GRAVITY / (2.0 * math.pi)
    if height > limit * period**2 * (1.0 + 1e-9):
        raise ConfigurationError(
            f"hs_m is {height:g} with tp_s {period:g}: too steep, allowed is hs_m up to {limit * period**2:.3g} m "
            f"with that period or tp_s from {math.sqrt(height / limit):.3g} s with that height"
        )


def _number(key: str, value: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ConfigurationError(f"{key} is {value!r}, allowed is a finite number")
    if not math.isfinite(value):
        raise ConfigurationError(f"{key} is {value!r}, allowed is a finite number")
    return float(value)


@dataclass(frozen=True)
class Spectrum:
    """Spectral density of the sea's elevation over wave frequency, with total energy ``hs^2 / 16``.

    The shape is ``x^-5 exp(-1.25 x^-4) gamma^r``, x the frequency over the peak frequency and
    ``r = exp(-(x - 1)^2 / (2 s^2))`` with s = 0.07 below the peak and 0.09 above: Bretschneider's for gamma = 1,
    JONSWAP's for gamma = 3.3 (Hasselmann et al. 1973), scaled to the height.

    Attributes:
        hs_m: Significant wave height [m], four standard deviations of the elevation.
        tp_s: Period of the spectrum's peak [s].
        gamma: Peakedness, 1 to 7; 1 is Bretschneider's spectrum.

    Raises:
        ConfigurationError: A sea too steep, or a number out of range.
    """

    hs_m: float
    tp_s: float
    gamma: float = 1.0

    def __post_init__(self) -> None:
        check_steepness(self.hs_m, self.tp_s)
        if not 1.0 <= _number("gamma", self.gamma) <= 7.0:
            raise ConfigurationError(f"gamma is {self.gamma:g}, allowed is a peakedness of 1 to 7")

    @property
    def peak(self) -> float:
        """Peak frequency [rad/s]."""
        return 2.0 * math.pi / self.tp_s

    @property
    def variance(self) -> float:
        """Variance of the elevation [m2]."""
        return self.hs_m**2 / 16.0

    def density(self, omega: npt.ArrayLike) -> FloatArray:
        """Spectral density [m2 s/rad] at wave frequencies [rad/s], any shape; zero at and below frequency 0."""
        x = np.asarray(omega, dtype=np.float64) / self.peak
        return self.variance / self.peak * _shape(x, self.gamma) / _Cumulative.of(self.gamma).total

    def energy(self, low: npt.ArrayLike, high: npt.ArrayLike) -> FloatArray:
        """Exact integral of the density [m2] between wave frequencies [rad/s], any shapes that go together."""
        cumulative = _Cumulative.of(self.gamma)
        ends = [cumulative.at(np.asarray(end, dtype=np.float64) / self.peak) for end in (low, high)]
        return np.asarray(self.variance * (ends[1] - ends[0]), dtype=np.float64)


def named_spectrum(name: SpectrumName, hs_m: float, tp_s: float, gamma: float = GAMMA) -> Spectrum:
    """Spectrum by its name.

    Args:
        name: bretschneider or jonswap.
        hs_m: Significant wave height [m].
        tp_s: Peak period [s].
        gamma: Peakedness of JONSWAP.

    Raises:
        ConfigurationError: An unknown name, a sea too steep, or a number out of range.
    """
    if name not in get_args(SpectrumName):
        raise ConfigurationError(f"spectrum is {name!r}, allowed are {', '.join(get_args(SpectrumName))}")
    return Spectrum(hs_m, tp_s, gamma if name == "jonswap" else 1.0)


def _shape(x: FloatArray, gamma: float) -> FloatArray:
    """``5 x^-5 exp(-1.25 x^-4) gamma^r``, whose integral is 1 for gamma = 1."""
    safe = np.maximum(x, 0.1)  # below, exp(-1.25 x^-4) is zero to the last bit
    density = 5.0 * safe**-5.0 * np.exp(-1.25 * safe**-4.0)
    if gamma == 1.0:
        return density
    width = np.where(safe <= 1.0, 0.07, 0.09)
    return np.asarray(density * gamma ** np.exp(-0.5 * ((safe - 1.0) / width) ** 2), dtype=np.float64)


class _Cumulative:
    """Integral of the shape from 0: Bretschneider's closed form plus the peak's extra energy, tabulated.

    The extra energy is integrated to rounding (Gauss-Legendre on short pieces) and interpolated by cubic pieces with
    its exact slope; beyond twice the peak frequency it is constant.
    """

    def __init__(self, gamma: float) -> None:
        from scipy.interpolate import CubicHermiteSpline  # here, so that importing the package stays quick

        self._x = np.linspace(0.3, 2.0, 1701)  # a node at the peak, where the width of the peak jumps
        nodes, weights = np.polynomial.legendre.leggauss(6)
        middle, half = 0.5 * (self._x[1:] + self._x[:-1]), 0.5 * np.diff(self._x)
        points = middle[:, np.newaxis] + half[:, np.newaxis] * nodes
        extra = half * np.einsum("pn,n->p", _shape(points, gamma) - _shape(points, 1.0), weights)
        table = np.concatenate([[0.0], np.cumsum(extra)])
        self._extra = CubicHermiteSpline(self._x, table, _shape(self._x, gamma) - _shape(self._x, 1.0))
        self.total = 1.0 + float(table[-1])

    @staticmethod
    @lru_cache(maxsize=64)
    def of(gamma: float) -> _Cumulative:
        """The tables of one peakedness, made once."""
        return _Cumulative(gamma)

    def at(self, x: FloatArray) -> FloatArray:
        """Share of the energy below x times the peak frequency."""
        safe = np.maximum(x, 0.1)
        extra = self._extra(np.clip(x, self._x[0], self._x[-1]))
        return np.asarray((np.exp(-1.25 * safe**-4.0) + extra) / self.total, dtype=np.float64)


@dataclass(frozen=True)
class Spreading:
    """Distribution of the energy over directions about the main one.

    Attributes:
        name: cos2, ``(2 / pi) cos^2`` over 90 degrees to either side, or long_crested, one direction.

    Raises:
        ConfigurationError: An unknown name.
    """

    name: SpreadingName = "cos2"

    def __post_init__(self) -> None:
        if self.name not in get_args(SpreadingName):
            raise ConfigurationError(f"spreading is {self.name!r}, allowed are {', '.join(get_args(SpreadingName))}")

    def density(self, angle: npt.ArrayLike) -> FloatArray:
        """Density [1/rad] at angles [rad] from the main direction, any shape; cos2 only.

        Raises:
            ConfigurationError: A long-crested sea has no density.
        """
        if self.name == "long_crested":
            raise ConfigurationError("spreading is long_crested: all energy goes one way, it has no density")
        a = np.asarray(angle, dtype=np.float64)
        return np.where(np.abs(a) < 0.5 * math.pi, 2.0 / math.pi * np.cos(a) ** 2, 0.0)
