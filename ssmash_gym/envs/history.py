"""Past readings in the observation: what a memory of a few seconds would hold, for policies that have none."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.observations import Observer

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


class HistoryBank:
    """The past readings of N helicopters, in units of the observation's scales.

    Before the start the first reading stood for ever.

    Args:
        n: Helicopters.
        observer: Which terms are observed, and which of them are past readings.
        control_interval_s: Time between two readings.
    """

    def __init__(self, n: int, observer: Observer, control_interval_s: float) -> None:
        wanted = [(place, term) for place, term in enumerate(observer.terms) if term.past_of]
        names = list(dict.fromkeys(term.past_of for _, term in wanted))
        self._sources = np.array([observer.names.index(name) for name in names])
        self._places = np.array([place for place, _ in wanted])
        self._rows = np.array([names.index(term.past_of) for _, term in wanted])
        self._lags = np.array([round(term.lag_s / control_interval_s) for _, term in wanted])
        self._ring: Array = np.zeros((int(self._lags.max()) + 1, len(names), n))
        self._reads: Columns = np.zeros(n, np.int64)

    def start(self, columns: Columns, scaled: Array) -> None:
        """Begin episodes with the first readings, `scaled` (m, size); the past readings' places are filled."""
        self._ring[:, :, columns] = scaled[:, self._sources].T
        self._reads[columns] = 0
        self.read(columns, scaled)

    def read(self, columns: Columns, scaled: Array) -> None:
        """Take the readings of one instant and write the past ones beside them, in place; `scaled` is (m, size)."""
        length, reads = len(self._ring), self._reads[columns]
        self._ring[reads % length, :, columns] = scaled[:, self._sources]
        moments = (reads[:, None] - self._lags) % length  # (m, places)
        scaled[:, self._places] = self._ring[moments, self._rows, columns[:, None]]
        self._reads[columns] += 1

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        return {"ring": self._ring.copy(), "reads": self._reads.copy()}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        pick = slice(None) if columns is None else columns
        self._ring, self._reads = snapshot["ring"][..., pick].copy(), snapshot["reads"][pick].copy()
