"""How good probabilities are: Brier score, reliability, and rules to compare with. All by records, left out in turn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssmash_gym.evaluation.statistics import Estimate, share
from ssmash_gym.ship.kinematics import FloatArray

RESAMPLES: Final = 2000
LEVEL_PERCENT: Final = 95.0
BINS: Final = 10
RIDGE: Final = 0.1  # on the standardised weights of the logistic rule: finite where classes can be told apart exactly
_UNDECIDED: Final = 0.5  # where there is no other record
_SURE: Final = 0.5  # of a copy: what a share of 0 or 1 of the copies is moved by before it becomes a logit


@dataclass(frozen=True)
class Bin:
    """One bin of a reliability curve: how often it was said, what was said, what happened."""

    count: int
    said: float
    happened: Estimate


def brier(said: ArrayLike, happened: ArrayLike) -> float:
    """Mean squared difference between probabilities (n,) and outcomes (n,) of 0 or 1: 0 is perfect."""
    return float(np.mean((np.asarray(said, dtype=np.float64) - np.asarray(happened, dtype=np.float64)) ** 2))


def reliability(said: FloatArray, happened: FloatArray, bins: int = BINS) -> list[Bin]:
    """Bins of equal width over the probabilities, (n,) each; empty ones are left out."""
    place = np.minimum((said * bins).astype(np.int64), bins - 1)
    return [
        Bin(int(np.sum(place == k)), float(np.mean(said[place == k])), share(happened[place == k]))
        for k in range(bins)
        if np.any(place == k)
    ]


def by_records(records: NDArray[np.int64], figure: Callable[[NDArray[np.int64]], float], *, seed: int = 0) -> Estimate:
    """A figure with its percentile bootstrap interval; whole records are drawn, as starts of one record are alike.

    Args:
        records: Record of each row, (n,).
        figure: Function of the rows that are drawn.
        seed: Of the draws.
    """
    rows = [np.flatnonzero(records == record) for record in np.unique(records)]
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(RESAMPLES):
        chosen = rng.integers(len(rows), size=len(rows))
        drawn.append(figure(np.concatenate([rows[k] for k in chosen])))
    tail = 0.5 * (100.0 - LEVEL_PERCENT)
    sound = [value for value in drawn if not np.isnan(value)]
    low, high = np.percentile(sound, [tail, 100.0 - tail]) if sound else (np.nan, np.nan)
    return Estimate(figure(np.arange(len(records))), float(low), float(high))


def skill(said: FloatArray, reference: FloatArray, happened: FloatArray) -> Callable[[NDArray[np.int64]], float]:
    """Brier skill as a function of rows: 1 less the ratio of both scores; nan where the reference is perfect."""

    def figure(rows: NDArray[np.int64]) -> float:
        against = brier(reference[rows], happened[rows])
        return 1.0 - brier(said[rows], happened[rows]) / against if against > 0.0 else float("nan")

    return figure


def base_rate(records: NDArray[np.int64], cells: ArrayLike, happened: FloatArray) -> FloatArray:
    """What has happened in all other records of the same cell, (n,); over all cells where there is no other record."""
    groups = np.asarray(cells)
    said = np.zeros(len(records))
    for k in range(len(records)):
        others = records != records[k]
        same = others & (groups == groups[k])
        known = happened[same if same.any() else others]
        said[k] = np.mean(known) if known.size else _UNDECIDED
    return said


def left_out(records: NDArray[np.int64], features: FloatArray, happened: FloatArray) -> FloatArray:
    """Probabilities of a logistic regression, each fitted on all other records, (n,).

    Args:
        records: Record of each row, (n,).
        features: (n, k), any unit.
        happened: Outcomes of 0 or 1, (n,).
    """
    said = np.zeros(len(records))
    for record in np.unique(records):
        own = records == record
        said[own] = _UNDECIDED if own.all() else _logistic(features[~own], happened[~own], features[own])
    return said


def logit(shares: FloatArray, copies: int) -> FloatArray:
    """Log odds of shares of so many copies, finite at 0 and 1 too."""
    hits = shares * copies
    return np.asarray(np.log((hits + _SURE) / (copies - hits + _SURE)))


def _logistic(features: FloatArray, happened: FloatArray, asked: FloatArray) -> FloatArray:
    """Probabilities at `asked` of a logistic regression on standardised features."""
    from scipy.optimize import minimize
    from scipy.special import expit

    mean, scale = np.mean(features, axis=0), np.maximum(np.std(features, axis=0), 1e-12)

    def with_one(x: FloatArray) -> FloatArray:
        return np.column_stack([np.ones(len(x)), (x - mean) / scale])

    x, sign = with_one(features), 2.0 * happened - 1.0

    def loss(w: FloatArray) -> tuple[float, FloatArray]:
        z = sign * (x @ w)
        value = np.sum(np.logaddexp(0.0, -z)) + 0.5 * RIDGE * np.sum(w[1:] ** 2)
        slope = -x.T @ (sign * expit(-z)) + RIDGE * np.append(0.0, w[1:])
        return float(value), np.asarray(slope)

    found = minimize(loss, np.zeros(x.shape[1]), jac=True, method="L-BFGS-B")
    return np.asarray(expit(with_one(asked) @ found.x), dtype=np.float64)
