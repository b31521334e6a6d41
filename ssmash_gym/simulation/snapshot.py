"""Copies of a batch at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ssmash_gym.vehicle import Helicopter


_WHOLE: Final = frozenset(("_mode",))
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
