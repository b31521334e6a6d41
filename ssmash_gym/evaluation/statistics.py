"""Statistics of episodes with intervals: Wilson's for shares, percentile bootstrap for everything else.

A sample is a table (training seeds, seas), or a row (seas,) where nothing was trained. The bootstrap draws seas with
replacement, the same for all samples of a figure, so that figures of several policies are paired by sea. Where a sample
has several training seeds, these are drawn with replacement too, independently of the seas and of the other samples:
the bootstrap of crossed factors (Owen 2007, "The pigeonhole bootstrap"). It errs on the side of too wide intervals;
yet a percentile interval over as few as five training seeds is somewhat short: the tests tell how often it holds the
truth.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
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


def known_median(values: ArrayLike, axis: int = -1) -> Array:
    """Median along the last axis of the numbers that are known (not NaN); NaN where none is."""
    ordered = np.sort(np.asarray(values, dtype=np.float64), axis=axis)  # NaN goes to the end
    count = np.sum(~np.isnan(ordered), axis=axis, keepdims=True)
    middle = [np.take_along_axis(ordered, np.maximum(k, 0), axis) for k in ((count - 1) // 2, count // 2)]
    return np.asarray(0.5 * (middle[0] + middle[1])[..., 0])


def iqm(values: ArrayLike, axis: int = -1) -> Array:
    """Interquartile mean along an axis: the mean without the lowest and the highest quarter of the numbers."""
    from scipy.stats import trim_mean

    return np.asarray(trim_mean(np.asarray(values, dtype=np.float64), 0.25, axis=axis))


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

    def found(first: Array, *divisors: Array) -> Array:
        found = statistic(first, axis=-1)
        return found if not divisors else ratio(found, statistic(divisors[0], axis=-1))

    estimate = estimates(samples, found, resamples=resamples, level=level, seed=seed)[0]
    if np.isnan(estimate.value):
        raise ValueError("the denominator's statistic is 0")
    return estimate


def estimates(
    samples: Sequence[ArrayLike],
    figures: Callable[..., ArrayLike],
    *,
    resamples: int = RESAMPLES,
    level: float = LEVEL,
    seed: int = 0,
) -> list[Estimate]:
    """Figures of one or several policies in the same seas, with percentile bootstrap intervals.

    Args:
        samples: One or more of (seas,) or (training seeds, seas); the seas are the same and in the same order. The
            training seeds of different samples are different ones. NaN is for the figures to deal with; whole numbers
            stay such, so that a sample may number the episodes and `figures` look up what it needs of them.
        figures: Function of as many samples (..., episodes), each over its last axis: one figure (...), or several
            (figures, ...). A figure that a resample does not have is NaN, and does not count.
        resamples: Samples drawn with replacement.
        level: Share that the interval covers.
        seed: Seed of the draws: the same samples give the same intervals.

    Returns:
        An estimate a figure; one of a single sea has no width.

    Raises:
        ValueError: A sample is empty or holds an infinite number, or two are not of the same seas.
    """
    from scipy import stats

    tables = [_table(sample) for sample in samples]
    seas = tables[0].shape[1]
    for table in tables:
        if table.shape[1] != seas:
            raise ValueError(f"paired samples: {seas} and {table.shape[1]} episodes")
    trained = [k for k, table in enumerate(tables) if table.shape[0] > 1]

    def drawn(of_seas: Rows, *of_seeds: Rows, axis: int = -1) -> Array:
        seeds = dict(zip(trained, of_seeds, strict=True))
        return np.asarray(figures(*(_taken(table, seeds.get(k), of_seas) for k, table in enumerate(tables))))

    factors = [np.arange(seas), *(np.arange(tables[k].shape[0]) for k in trained)]
    values = np.atleast_1d(drawn(*factors))
    if seas == 1:
        return [Estimate(float(value), float(value), float(value)) for value in values]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # of its own bounds, where a figure is NaN
        found = stats.bootstrap(
            factors, drawn, n_resamples=resamples, batch=CHUNK, vectorized=True, method="percentile",
            confidence_level=level, random_state=np.random.default_rng(seed),
        )  # fmt: skip
    tail = 50.0 * (1.0 - level)
    bounds = [_percentiles(row, tail) for row in np.atleast_2d(found.bootstrap_distribution)]
    return [Estimate(float(value), low, high) for value, (low, high) in zip(values, bounds, strict=True)]


def improvement(values: ArrayLike, others: ArrayLike, axis: int = -1) -> Array:
    """Probability of improvement where less is better: the share of pairs in which the first number is the lower one.

    An equal pair counts half. Pairs are of one sea, so that it is the stratified form of Agarwal et al. (2021, "Deep
    reinforcement learning at the edge of the statistical precipice") with a sea as the task.

    Args:
        values: (..., n) of the first.
        others: The same of the second, in the same seas.
        axis: Along which the pairs lie.
    """
    ours, theirs = np.asarray(values, dtype=np.float64), np.asarray(others, dtype=np.float64)
    return np.asarray(np.mean((ours < theirs) + 0.5 * (ours == theirs), axis=axis))


def ratio(values: ArrayLike, divisors: ArrayLike) -> Array:
    """Quotient, NaN where the divisor is not positive."""
    below = np.asarray(divisors, dtype=np.float64)
    return np.asarray(np.asarray(values, dtype=np.float64) / np.where(below > 0.0, below, np.nan))


def _taken(table: NDArray[Any], seeds: Rows | None, seas: Rows) -> NDArray[Any]:
    """The drawn part of a table, its training seeds one after the other: (..., episodes)."""
    if seeds is None:
        return np.asarray(table[0][seas])
    return table[seeds[..., :, None], seas[..., None, :]].reshape(*seas.shape[:-1], -1)


def _percentiles(drawn: Array, tail: float) -> tuple[float, float]:
    """The two bounds of what resamples gave; NaN where none had the figure."""
    sound = drawn[~np.isnan(drawn)]
    if not sound.size:
        return float("nan"), float("nan")
    low, high = np.percentile(sound, [tail, 100.0 - tail])
    return float(low), float(high)


def _table(sample: ArrayLike) -> NDArray[Any]:
    table = np.atleast_2d(np.asarray(sample))
    if not np.issubdtype(table.dtype, np.integer):
        table = table.astype(np.float64)
    if table.ndim != 2 or table.size == 0 or np.any(np.isinf(table)):
        raise ValueError(f"a sample must be a table of finite numbers, got shape {table.shape}")
    return table


def _checked(values: ArrayLike) -> Array:
    sample = np.asarray(values, dtype=np.float64)
    if sample.ndim != 1 or sample.size == 0 or not np.all(np.isfinite(sample)):
        raise ValueError(f"a sample must be a row of finite numbers, got shape {sample.shape}")
    return sample
