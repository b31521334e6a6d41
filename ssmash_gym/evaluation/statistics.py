"""Statistics of episodes with intervals: Wilson's for shares, percentile bootstrap for everything else."""

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
    """A statistic with the bounds of its interval, in the unit of the sample."""

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


def share(hits: ArrayLike, *, level: float = LEVEL) -> Estimate:
    """Share of episodes with Wilson's interval, which has a width also where all or none are hits.

    Args:
        hits: (n,) 1 for a hit and 0 for none.
        level: Share that the interval covers.

    Raises:
        ValueError: The sample is empty, or holds anything but 0 and 1.
    """
    from scipy.stats import binomtest

    sample = _checked(hits)
    if not np.all((sample == 0.0) | (sample == 1.0)):
        raise ValueError("a share is of zeros and ones")
    found = binomtest(int(np.sum(sample)), sample.size).proportion_ci(level, method="wilson")
    return Estimate(float(np.mean(sample)), float(found.low), float(found.high))


def bootstrap(
    values: ArrayLike,
    statistic: Callable[..., Array],
    *,
    over: ArrayLike | None = None,
    resamples: int = RESAMPLES,
    level: float = LEVEL,
    seed: int = 0,
) -> Estimate:
    """A statistic of one sample, or its ratio to that of another one, with the percentile bootstrap interval.

    Args:
        values: (n,) one number an episode.
        statistic: Function of a sample and an axis, e.g. `p95`.
        over: (n,) numbers of the same episodes: the ratio of the two statistics is taken, episodes are drawn in pairs.
        resamples: Samples drawn with replacement.
        level: Share that the interval covers.
        seed: Seed of the draws: the same sample gives the same interval.

    Raises:
        ValueError: A sample is empty or not finite, two are not of one length, or the statistic divided by is 0.
    """
    samples = [_checked(values)] if over is None else [_checked(values), _checked(over)]
    if samples[0].size != samples[-1].size:
        raise ValueError(f"paired samples: {samples[0].size} and {samples[-1].size} episodes")

    def found(rows: NDArray[np.int64]) -> Array:
        first, *divisors = (statistic(sample[rows], axis=-1) for sample in samples)
        return np.asarray(first if not divisors else first / np.where(divisors[0] == 0.0, np.nan, divisors[0]))

    size = samples[0].size
    value = float(found(np.arange(size)))
    if np.isnan(value):
        raise ValueError("the denominator's statistic is 0")
    rng = np.random.default_rng(seed)
    counts = (min(CHUNK, resamples - first) for first in range(0, resamples, CHUNK))
    drawn = np.concatenate([found(rng.integers(0, size, (count, size))) for count in counts])
    tail = 50.0 * (1.0 - level)
    low, high = np.nanpercentile(drawn, [tail, 100.0 - tail])
    return Estimate(value, float(low), float(high))


def _checked(values: ArrayLike) -> Array:
    sample = np.asarray(values, dtype=np.float64)
    if sample.ndim != 1 or sample.size == 0 or not np.all(np.isfinite(sample)):
        raise ValueError(f"a sample must be a row of finite numbers, got shape {sample.shape}")
    return sample
