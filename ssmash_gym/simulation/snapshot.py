"""Copies of a batch at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ssmash_gym.simulation.batch import Batch
    from ssmash_gym.vehicle import Helicopter

Moving = dict[str, NDArray[np.float64] | NDArray[np.int64]]

_WHOLE: Final = frozenset(("_mode",))
_MOVING: Final = ("state", "_commands", "clocks", "_outputs", "_highs", "_lows")  # what `Batch.advance` changes
_ROW_EACH: Final = frozenset(("clocks", "_nodes", "_ends", "_gust_nodes", "_gust_ends", "_claw_nodes"))


@dataclass(frozen=True)
class Snapshot:
    """Copy of everything a batch is at one instant; immutable by convention, taken by `Batch.snapshot`."""

    arrays: dict[str, NDArray[np.float64] | NDArray[np.int64]]
    helicopters: tuple[Helicopter, ...]

    def of_columns(self, columns: NDArray[np.int64]) -> Snapshot:
        """The listed columns, in their order; one may be listed many times."""
        arrays = {
            name: array if name in _WHOLE else array[columns] if name in _ROW_EACH else array[:, columns]
            for name, array in self.arrays.items()
        }
        return Snapshot(arrays, tuple(self.helicopters[k] for k in columns))


def moving(batch: Batch) -> Moving:
    """Copy of what time changes of a batch, to `rewind` to while decks and parameters stay: a small part of it."""
    return {name: getattr(batch, name).copy() for name in _MOVING}


def rewind(batch: Batch, kept: Moving) -> None:
    """Return a batch, whose decks and parameters are still the same, to where `moving` was taken, bit for bit."""
    for name, array in kept.items():
        getattr(batch, name)[...] = array
