"""Mean peak load in bands of the sea's severity, over several sea states whose episodes share their seeds."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.evaluation.statistics import Estimate, estimates, ratio
from ssmash_gym.evaluation.study_rows import StudyRows
from ssmash_gym.evaluation.summary import BANDS_G, FEWEST

Array = NDArray[np.float64]
PEAK: Final = "scored_peak_kN"
BANDS: Final = tuple(itertools.pairwise(BANDS_G))


def band_means(
    rows: StudyRows, conditions: Sequence[str], policies: Sequence[str]
) -> tuple[dict[str, list[Estimate | None]], list[int]]:
    """Mean peak load of each policy in each band, with intervals, and the number of seas in each.

    The same seed is another sea in each sea state, but its wave phases, course and helicopter are the same: so a
    resample draws seeds, each with all its seas, and not seas as if they were independent.

    Args:
        rows: Of the study.
        conditions: Sea states that all policies have met.
        policies: Names.

    Returns:
        By policy an estimate a band, None where there are fewer than `FEWEST` seas, or where none of its training seeds
        has met all conditions; and the seas of each band.
    """
    common = functools.reduce(np.intersect1d, [rows.seas(one, *policies) for one in conditions])
    severity = np.array([rows.table(one, policies[0], "sea_lateral_g", common)[0] for one in conditions])
    inside = [(severity >= low) & (severity < high) for low, high in BANDS]  # (conditions, seeds) each
    counts = [int(one.sum()) for one in inside]
    found: dict[str, list[Estimate | None]] = {}
    for policy in policies:
        peaks = _peaks(rows, conditions, policy, common)
        found[policy] = [_mean(peaks, one) if len(peaks) and one.sum() >= FEWEST else None for one in inside]
    return found, counts


def _peaks(rows: StudyRows, conditions: Sequence[str], policy: str, seas: NDArray[np.int64]) -> Array:
    """Peak loads, (training seeds, conditions, seas), of the training seeds that have met all conditions."""
    trained = [rows.seeds(one, policy) for one in conditions]
    everywhere = [seed for seed in trained[0] if all(seed in here for here in trained)]
    tables = [rows.table(one, policy, PEAK, seas) for one in conditions]
    kept = [table[[here.index(seed) for seed in everywhere]] for table, here in zip(tables, trained, strict=True)]
    return np.stack(kept, axis=1)


def _mean(peaks: Array, inside: NDArray[np.bool_]) -> Estimate:
    """Mean of the peaks in a band; `inside` is (conditions, seas)."""
    sums = np.where(inside, peaks, 0.0).sum(axis=1)  # (training seeds, seas)
    counts = np.broadcast_to(inside.sum(axis=0), sums.shape)
    codes = np.arange(sums.size).reshape(sums.shape)

    def figure(drawn: NDArray[np.int64]) -> Array:
        return ratio(sums.ravel()[drawn].sum(axis=-1), counts.ravel()[drawn].sum(axis=-1))

    return estimates([codes], figure)[0]
