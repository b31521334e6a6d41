"""A confidence sequence for a share: intervals that hold at all times at once, so that one may stop when one likes.

For each share p a test martingale bets against it: the likelihood of the episodes so far under a mixture of smaller (or
greater) shares, over that under p. While p is the truth it is a non-negative martingale with mean 1, and exceeds
``1 / a`` with a probability of at most a, whenever one looks and however long (Ville 1939; Robbins 1970, "Statistical
methods related to the law of the iterated logarithm", Ann. Math. Statist. 41). The interval is what neither of the two
bets has refuted, half of the error on each side. It is wider than an interval of a fixed number of episodes, and stays
valid when episodes are added because of what was seen. A cell is decided when its interval leaves the acceptance level
on one side.

The mixtures are Beta densities cut off at p, chosen for acceptance levels about 10 %: the one of smaller shares has
most of its weight close to zero, so that a cell in which nothing happens is soon within; that of greater ones about a
fifth. This is for efficiency alone; the coverage holds whatever they are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
LEVEL: Final = 0.95
WITHIN: Final = "within"
BEYOND: Final = "beyond"
UNDECIDED: Final = "undecided"
_SMALLER: Final = (0.3, 10.0)  # Beta parameters of the mixture of shares below p: 39 quiet episodes show less than 10 %
_GREATER: Final = (3.0, 12.0)  # and above: about a fifth, where a decision against 10 % is hard to come by
_HALVINGS: Final = 40  # of an interval of length 1: the bounds are good to 1e-12


@dataclass(frozen=True)
class Bounds:
    """Intervals for shares; every array has the shape of what was asked.

    Attributes:
        low, high: Bounds of the share.
    """

    low: Array
    high: Array

    def verdicts(self, acceptance: float) -> NDArray[np.str_]:
        """`WITHIN` where all of the interval is at most the acceptance level, `BEYOND` above it, else `UNDECIDED`."""
        return np.where(self.high <= acceptance, WITHIN, np.where(self.low > acceptance, BEYOND, UNDECIDED))


def bounds(hits: ArrayLike, episodes: ArrayLike, level: float = LEVEL) -> Bounds:
    """Confidence sequence after so many episodes.

    Args:
        hits: Episodes in which it happened, (n,) or a number.
        episodes: How many there were, of the same shape; 0 gives the interval from 0 to 1.
        level: Probability with which the intervals of a cell hold its true share at all times together.

    Raises:
        ValueError: More hits than episodes, a negative number, or a level that is not between 0 and 1.
    """
    s, n = np.broadcast_arrays(np.asarray(hits, dtype=np.float64), np.asarray(episodes, dtype=np.float64))
    if np.any(s < 0.0) or np.any(s > n) or not 0.0 < level < 1.0:
        raise ValueError(f"hits {hits!r} of {episodes!r} episodes at level {level!r}: no share")
    pairs, place = np.unique(np.stack([s.ravel(), n.ravel()]), axis=1, return_inverse=True)  # cells have many in common
    low, high = _bounds(pairs[0], pairs[1], np.log(2.0 / (1.0 - level)))
    return Bounds(low[place].reshape(s.shape), high[place].reshape(s.shape))


def fewest(acceptance: float, level: float = LEVEL) -> int:
    """How many episodes without a hit it takes until a cell is shown to be within an acceptance level.

    Args:
        acceptance: The level, above 0.
        level: Of the confidence sequence.
    """

    def shown(episodes: int) -> bool:
        return bool(bounds(0, episodes, level).high <= acceptance)

    high = 1
    while not shown(high):
        high *= 2
    low = high // 2  # not enough
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if shown(middle) else (middle, high)
    return high


def _bounds(s: Array, n: Array, refuted: float) -> tuple[Array, Array]:
    """Lower and upper bounds: shares against which the logarithm of a bet has not come to `refuted`."""
    share = np.divide(s, n, out=np.full(s.shape, 0.5), where=n > 0.0)
    high = _boundary(lambda p: log_bet_smaller(p, s, n) < refuted, share, 1.0)
    low = _boundary(lambda p: log_bet_greater(p, s, n) < refuted, share, 0.0)
    return np.where((n > 0.0) & (s > 0.0), low, 0.0), np.where((n > 0.0) & (s < n), high, 1.0)


def log_bet_smaller(p: ArrayLike, hits: ArrayLike, episodes: ArrayLike) -> Array:
    """Logarithm of the martingale that bets on shares smaller than p: large where p is too great."""
    from scipy.special import betainc

    return _log_bet(p, hits, episodes, _SMALLER, betainc)


def log_bet_greater(p: ArrayLike, hits: ArrayLike, episodes: ArrayLike) -> Array:
    """Logarithm of the martingale that bets on shares greater than p: large where p is too small."""
    from scipy.special import betaincc

    return _log_bet(p, hits, episodes, _GREATER, betaincc)


def _log_bet(
    p: ArrayLike, hits: ArrayLike, episodes: ArrayLike, mixture: tuple[float, float], part: Callable[..., Array]
) -> Array:
    """Logarithm of a bet: likelihood under the part of a Beta mixture on one side of p, over that under p."""
    from scipy.special import betaln

    a, b = mixture
    share, s, n = _floats(p, hits, episodes)
    with np.errstate(divide="ignore", invalid="ignore"):
        mixed = betaln(a + s, b + n - s) + np.log(part(a + s, b + n - s, share))
        before = betaln(a, b) + np.log(part(a, b, share))
    return np.asarray(mixed - before - _log_likelihood(share, s, n))


def _log_likelihood(p: Array, s: Array, n: Array) -> Array:
    from scipy.special import xlog1py, xlogy

    return np.asarray(xlogy(s, p) + xlog1py(n - s, -p))


def _floats(*values: ArrayLike) -> list[Array]:
    return list(np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in values)))


def _boundary(holds: Callable[[Array], NDArray[np.bool_]], inner: Array, outer: float) -> Array:
    """Where a statement that holds at `inner` ceases to hold on the way to `outer`, by halving; the far side of it."""
    near, far = np.array(inner, dtype=np.float64), np.full(inner.shape, outer)
    for _ in range(_HALVINGS):
        middle = 0.5 * (near + far)
        kept = holds(middle)
        near, far = np.where(kept, middle, near), np.where(kept, far, middle)
    return far
