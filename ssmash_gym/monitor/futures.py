"""Possible futures of a deck: its autoregressive model, driven by the model's own errors.

The error of each one-step prediction in the past is kept with its time. A future is the recursion of the prediction, at
each step with an error of the past added: runs of consecutive errors, the same times for all six channels, so that what
moves together keeps moving together (roll with sway) and errors that follow each other keep doing so. Without errors
the recursion is the forecast, which is also the mean of the futures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.monitor.settings import SPACING_S
from ssmash_gym.ship.forecast import ORDER, ArModel
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, N_CHANNELS

RUN: Final = 50  # consecutive errors drawn together: 10 s, about a period of roll
DEGREE: Final = 5  # of the spline through samples: accelerations are smooth
JOINED: Final = 30  # past samples that a future's spline goes through: its other end is then too far to matter
BEYOND: Final = 8  # samples after the last node, for the same reason at the far end
LARGEST_ROOT: Final = 0.9995  # of the recursion: errors must die away, or a future would grow without bound
_LINEAR: Final = 3  # of the six channels the first three are velocities, the others angles


@dataclass(frozen=True, eq=False)
class DeckModel:
    """An autoregressive model of six channels, with its one-step errors.

    Attributes:
        model: The prediction.
        errors: Of the one-step prediction in the past, about their mean, oldest first, (n, 6).
        past: The samples it was fitted on, (n + order, 6).
    """

    model: ArModel
    errors: FloatArray
    past: FloatArray

    @classmethod
    def fit(cls, past: FloatArray, order: int = ORDER) -> DeckModel:
        """Fit the past, (n, 6), evenly spaced.

        Raises:
            ConfigurationError: The past is too short, or not finite.
        """
        model = damped(ArModel.fit(past, order))
        about = past - model.mean
        lagged = np.lib.stride_tricks.sliding_window_view(about[:-1], order, axis=0)[:, :, ::-1]  # (n, 6, order)
        predicted = np.einsum("tcl,lc->tc", lagged, model.coefficients)
        errors = about[order:] - predicted
        # As many numbers were fitted as the order is: errors of predictions outside the fit are larger by this.
        larger = math.sqrt(len(errors) / max(len(errors) - order, 1))
        return cls(model, larger * (errors - np.mean(errors, axis=0)), past)

    def sample(self, copies: int, count: int, rng: np.random.Generator, run: int = RUN) -> FloatArray:
        """The forecast and sampled futures that follow the past.

        Args:
            copies: How many futures.
            count: Samples ahead.
            rng: Where the errors' times come from.
            run: Consecutive errors drawn together.

        Returns:
            (1 + copies, count, 6): the forecast, then the futures; units of the past.
        """
        chosen = self.errors[error_times(len(self.errors), copies, count, rng, run)]  # (copies, count, 6)
        added = np.concatenate([np.zeros((1, count, N_CHANNELS)), chosen])
        order = self.model.order
        newest_last = np.zeros((order + count, 1 + copies, N_CHANNELS))
        newest_last[:order] = (self.past[-order:] - self.model.mean)[:, np.newaxis]
        oldest_first = np.ascontiguousarray(self.model.coefficients[::-1])
        for k in range(count):
            step = np.einsum("lc,lkc->kc", oldest_first, newest_last[k : k + order])
            newest_last[order + k] = step + added[:, k]
        return np.asarray(np.moveaxis(newest_last[order:], 0, 1) + self.model.mean)


def error_times(
    available: int, copies: int, count: int, rng: np.random.Generator, longest: int = RUN
) -> NDArray[np.int64]:
    """Which past errors drive each future: runs of consecutive ones, (copies, count)."""
    run = max(1, min(longest, available // 4))
    runs = math.ceil(count / run)
    starts = rng.integers(available - run + 1, size=(copies, runs))
    return np.asarray((starts[..., np.newaxis] + np.arange(run)).reshape(copies, -1)[:, :count])


def damped(model: ArModel) -> ArModel:
    """The model with all roots of each recursion within `LARGEST_ROOT`: least squares do not promise that.

    Every root is scaled alike, so the frequencies stay; a model whose roots lie within is returned as it is.
    """
    coefficients = model.coefficients.copy()
    order = model.order
    for c in range(coefficients.shape[1]):
        companion = np.eye(order, k=-1)
        companion[0] = coefficients[:, c]
        # Rounded, so that the last bits of an eigenvalue, which differ from library to library, do not matter.
        largest = round(float(np.max(np.abs(np.linalg.eigvals(companion)))), 6)
        if largest > LARGEST_ROOT:
            coefficients[:, c] *= (LARGEST_ROOT / largest) ** np.arange(1, order + 1)
    return ArModel(coefficients, model.mean)


def future_nodes(past: FloatArray, futures: FloatArray, nodes: int) -> FloatArray:
    """Table nodes from now on for each future, joined to the past.

    One spline of degree 5 goes through the last past samples and the future's. Angles are its values, positions the
    integral of its velocities from zero now on; rates and accelerations are the derivatives.

    Args:
        past: Samples up to now, (n, 6): velocities [m/s], angles [rad].
        futures: Those that follow, (k, m, 6).
        nodes: How many nodes of `DEFAULT_SPACING_S`, the first one now.

    Returns:
        (k, nodes, 18) in the layout of `ship.MotionTable`.
    """
    joined = past[-JOINED:]
    before = np.broadcast_to(joined, (len(futures), *joined.shape))
    series = np.moveaxis(np.concatenate([before, futures], axis=1), 1, 0)
    return splined_nodes(series, len(joined) - 1, DEFAULT_SPACING_S * np.arange(nodes, dtype=np.float64))


def splined_nodes(series: FloatArray, now: int, times: FloatArray) -> FloatArray:
    """Nodes of the spline through samples, (k, times, 18).

    Args:
        series: Samples (n, k, 6): velocities [m/s], angles [rad].
        now: Which sample stands at time 0.
        times: Of the nodes [s], within the samples.
    """
    from scipy.interpolate import make_interp_spline

    at = SPACING_S * (np.arange(len(series)) - now)
    spline = make_interp_spline(at, series, k=DEGREE)
    value, rate, bend = spline(times), spline(times, 1), spline(times, 2)
    whole = spline.antiderivative()
    way = whole(times) - whole(0.0)
    linear, angular = slice(0, _LINEAR), slice(_LINEAR, N_CHANNELS)
    parts = (
        way[..., linear], value[..., angular], value[..., linear], rate[..., angular], rate[..., linear],
        bend[..., angular],
    )  # fmt: skip
    return np.asarray(np.moveaxis(np.concatenate(parts, axis=-1), 0, 1), dtype=np.float64)


def samples_ahead(horizon_s: float) -> int:
    """How many future samples a table over a horizon needs."""
    return math.ceil(horizon_s / SPACING_S) + BEYOND
