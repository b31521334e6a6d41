"""Short-term forecasts of deck motion from its own past: autoregression by least squares.

A series is sampled evenly, its mean is taken off, and each sample is fitted by the `order` samples before it. Used
again on its own results, the one-step prediction reaches any lead; collapsed, every lead is one row of fixed weights
on the last `order` samples. What comes out rests on the past alone: it can be computed on a ship.

All sums are taken in a fixed order of elementwise operations, so the bits depend neither on threads nor on how many
series are fitted at once. Method: covariance form of linear prediction (Makhoul 1975, "Linear prediction: a tutorial
review", Proc. IEEE 63), used for ship motion in many variants; the ridge is this package's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.elimination import solved
from ssmash_gym.ship.kinematics import FloatArray

ORDER: Final = 50  # samples looked back on: 10 s at 5 Hz, a period of the slowest usual roll
RIDGE: Final = 1e-6  # share of the variance, as if the readings had 0.1 % more noise: keeps a noise-free fit solvable
_TINY: Final = 1e-300  # keeps a series that does not move from dividing by zero


@dataclass(frozen=True, eq=False)
class ArModel:
    """Autoregressive models of one or more series; what is a column of the series is a column of everything.

    Attributes:
        coefficients: Of the one-step prediction, newest sample first, (order, columns).
        mean: Mean of each series, in its unit, (columns,).
    """

    coefficients: FloatArray
    mean: FloatArray

    @property
    def order(self) -> int:
        """How many past samples a prediction takes."""
        return len(self.coefficients)

    @classmethod
    def fit(cls, series: npt.ArrayLike, order: int = ORDER, ridge: float = RIDGE) -> ArModel:
        """Least-squares fit, each column by itself.

        Args:
            series: Evenly spaced samples, oldest first, (n,) or (n, columns), any unit.
            order: Past samples of a prediction.
            ridge: Added to the diagonal of the normal equations, as a share of the series' variance; positive.

        Raises:
            ConfigurationError: Fewer than 2 `order` samples, a sample that is not finite, or an order or ridge that is
                not positive.
        """
        if order < 1 or not (math.isfinite(ridge) and ridge > 0.0):
            raise ConfigurationError(f"forecast: order = {order}, ridge = {ridge}: both must be above 0")
        x = _columns(series)
        if len(x) < 2 * order:
            raise ConfigurationError(
                f"forecast: {len(x)} samples are too few, at least twice the order of {order} are needed"
            )
        if not np.isfinite(x).all():
            raise ConfigurationError("forecast: the series holds a value that is not finite")
        mean = ordered_sum(x) / len(x)
        x = x - mean
        products = _lagged_products(x, order)
        # What is not resolved beside the mean counts as no motion: rounding must not be fitted.
        floor = (1e-12 * mean) ** 2 * len(x) + _TINY
        diagonal = np.arange(order)
        normal = products[1:, 1:].copy()
        normal[diagonal, diagonal] += ridge * ordered_sum(x * x) + floor
        return cls(solved(normal, products[1:, 0]), mean)

    def weights(self, leads: Sequence[int]) -> FloatArray:
        """What each lead's forecast takes of the past samples about their mean, newest first, (leads, order, columns).

        Args:
            leads: Samples ahead of the newest one, 1 or more each.

        Raises:
            ConfigurationError: A lead below 1, or none.
        """
        if not leads or min(leads) < 1:
            raise ConfigurationError(f"forecast: leads = {list(leads)}: must be one or more whole numbers from 1 on")
        rows = [self.coefficients]
        for _ in range(max(leads) - 1):
            before = rows[-1]
            # One sample later its newest sample is itself predicted, and the others have moved one place back.
            row = before[0] * self.coefficients
            row[:-1] += before[1:]
            rows.append(row)
        return np.stack([rows[lead - 1] for lead in leads])

    def forecast(self, past: npt.ArrayLike, leads: Sequence[int]) -> FloatArray:
        """Forecasts from the last `order` samples.

        Args:
            past: Samples up to now, oldest first, (n,) or (n, columns), n at least the order, in the series' unit.
            leads: Samples ahead of the newest one.

        Returns:
            (leads, columns), in the series' unit.

        Raises:
            ConfigurationError: Too few samples, or another number of columns than was fitted.
        """
        x = _columns(past)
        if len(x) < self.order or x.shape[1] != len(self.mean):
            raise ConfigurationError(
                f"forecast: a past of shape {x.shape}, must be ({self.order} or more, {len(self.mean)})"
            )
        newest_first = (x[::-1] - self.mean)[: self.order]
        return self.mean + np.stack([ordered_sum(row * newest_first) for row in self.weights(leads)])


def persistence(order: int, leads: Sequence[int], columns: int = 1) -> FloatArray:
    """Weights of the forecast that all stays as it is, laid out as `ArModel.weights`, (leads, order, columns)."""
    weights = np.zeros((len(leads), order, columns))
    weights[:, 0] = 1.0
    return weights


def ordered_sum(values: FloatArray) -> FloatArray:
    """Sum over the first axis by halves, elementwise: the same bits whatever the other axes are."""
    while len(values) > 1:
        half = len(values) // 2
        folded = values[:half] + values[half : 2 * half]
        if len(values) % 2:
            folded[0] += values[-1]
        values = folded
    return np.asarray(values[0], dtype=np.float64)


def _columns(series: npt.ArrayLike) -> FloatArray:
    x = np.asarray(series, dtype=np.float64)
    if x.ndim not in (1, 2):
        raise ConfigurationError(f"forecast: a series of shape {x.shape}, must be (n,) or (n, columns)")
    return x[:, np.newaxis] if x.ndim == 1 else x


def _lagged_products(x: FloatArray, order: int) -> FloatArray:
    """``sum_t x[t - i] x[t - j]`` for i, j = 0 ... order over all t with a full past, (order + 1, order + 1, columns).

    Each entry is its upper left neighbour with one product more and one less, so only the first row is summed.
    """
    n, p = len(x), order
    rows = np.ascontiguousarray(x.T)
    lagged = np.lib.stride_tricks.sliding_window_view(rows, n - p, axis=1)[:, ::-1]  # (columns, order + 1, n - order)
    first = ordered_sum(np.moveaxis(lagged * rows[:, np.newaxis, p:], -1, 0)).T
    head, tail = x[p::-1], x[: n - p - 2 : -1]  # x[p - j] and, from j = 1 on, x[n - j], j = 0 ... order
    products = np.empty((p + 1, p + 1, x.shape[1]))
    products[0] = products[:, 0] = first
    for i in range(1, p + 1):
        row = products[i - 1, i - 1 : -1] + head[i] * head[i:] - tail[i - 1] * tail[i - 1 : p]
        products[i, i:] = products[i:, i] = row
    return products
