"""Statistics of episodes with bootstrap intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
LEVEL = 0.95
RESAMPLES = 2000
CHUNK = 256  # resamples at once, to spare memory


@dataclass(frozen=True)
class Estimate:
    """A statistic with the bounds of its bootstrap interval, in the unit of the sample."""

    value: float
    low: float
    high: float

    @property
    def interval(self) -> list[float]:
        """Both bounds, for JSON."""
        return [self.low, self.high]


def p95(values: ArrayLike, axis: int = -1) -> Array:
    """95th percentile along an axis, linearly interpolated between order statistics."""
    return np.asarray(np.percentile(np.asarray(values, dtype=np.float64), 95.0, axis=axis))


def mean(values: ArrayLike, axis: int = -1) -> Array:
    """Mean along an axis."""
    return np.asarray(np.mean(np.asarray(values, dtype=np.float64), axis=axis))


def median(values: ArrayLike, axis: int = -1) -> Array:
    """Median along an axis."""
    return np.asarray(np.median(np.asarray(values, dtype=np.float64), axis=axis))


def bootstrap(
    values: ArrayLike,
    statistic: Callable[..., Array],
    *,
    resamples: int = RESAMPLES,
    level: float = LEVEL,
    seed: int = 0,
) -> Estimate:
    """A statistic of one sample with its percentile bootstrap interval.

    Args:
        values: (n,) one number an episode.
        statistic: Function of a sample and an axis, e.g. `p95`.
        resamples: Samples drawn with replacement.
        level: Share that the interval covers.
        seed: Seed of the draws: the same sample gives the same interval.

    Raises:
        ValueError: The sample is empty or not finite.
    """
    sample = _checked(values)
    drawn = _drawn(sample.size, lambda rows: statistic(sample[rows], axis=-1), resamples, seed)
    return Estimate(float(statistic(sample)), *_bounds(drawn, level))


def bootstrap_ratio(
    numerator: ArrayLike,
    denominator: ArrayLike,
    statistic: Callable[..., Array],
    *,
    resamples: int = RESAMPLES,
    level: float = LEVEL,
    seed: int = 0,
) -> Estimate:
    """Ratio of a statistic of two policies on the same episodes: the episodes are drawn in pairs.

    Args:
        numerator: (n,) one number an episode.
        denominator: (n,) the other policy's on the same seeds.
        statistic: As in `bootstrap`.
        resamples: As there.
        level: As there.
        seed: As there.

    Raises:
        ValueError: The samples are not of one length, empty or not finite, or the denominator's statistic is 0.
    """
    above, below = _checked(numerator), _checked(denominator)
    if above.size != below.size:
        raise ValueError(f"paired samples: {above.size} and {below.size} episodes")
    divisor = float(statistic(below))
    if divisor == 0.0:
        raise ValueError("the denominator's statistic is 0")

    def ratios(rows: NDArray[np.int64]) -> Array:
        divisors = statistic(below[rows], axis=-1)
        return np.asarray(statistic(above[rows], axis=-1) / np.where(divisors == 0.0, np.nan, divisors))

    drawn = _drawn(above.size, ratios, resamples, seed)
    return Estimate(float(statistic(above)) / divisor, *_bounds(drawn, level))


def _drawn(size: int, of: Callable[[NDArray[np.int64]], Array], resamples: int, seed: int) -> Array:
    """A statistic of many samples drawn with replacement; `of` takes rows of places, (draws, size)."""
    rng = np.random.default_rng(seed)
    parts = [of(rng.integers(0, size, (min(CHUNK, resamples - first), size))) for first in range(0, resamples, CHUNK)]
    return np.concatenate(parts)


def _bounds(drawn: Array, level: float) -> tuple[float, float]:
    """The percentile interval of drawn statistics."""
    tail = 50.0 * (1.0 - level)
    low, high = np.nanpercentile(drawn, [tail, 100.0 - tail])
    return float(low), float(high)


def _checked(values: ArrayLike) -> Array:
    sample = np.asarray(values, dtype=np.float64)
    if sample.ndim != 1 or sample.size == 0 or not np.all(np.isfinite(sample)):
        raise ValueError(f"a sample must be a row of finite numbers, got shape {sample.shape}")
    return sample
