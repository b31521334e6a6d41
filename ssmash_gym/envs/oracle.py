"""The true future of the deck in the observation: a reference for what forecasts could be worth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.forecasts import true_readings
from ssmash_gym.envs.observations import TERMS, Observer
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.starts import Starter

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


class OracleBank:
    """What noiseless sensors of N decks will read, in units of the observation's scales.

    Behind the end of a record its last instant stands for ever.

    Args:
        n: Helicopters.
        observer: Which terms are observed, and which of them are of the future.
        starter: Gives the motion of a draw.
    """

    def __init__(self, n: int, observer: Observer, starter: Starter) -> None:
        self._starter = starter
        interval_s = starter.task.control_interval_s
        wanted = [(place, term) for place, term in enumerate(observer.terms) if term.oracle_of]
        self._names = list(dict.fromkeys(term.oracle_of for _, term in wanted))
        self._scale = np.array([TERMS[name].scale for name in self._names])
        self._places = np.array([place for place, _ in wanted])
        self._rows = np.array([self._names.index(term.oracle_of) for _, term in wanted])
        self._leads = np.array([round(term.lead_s / interval_s) for _, term in wanted])
        count = starter.task.horizon_steps + int(self._leads.max()) + 1
        self._times_s = interval_s * np.arange(count)
        self._table: Array = np.zeros((count, len(self._names), n))
        self._reads: Columns = np.zeros(n, np.int64)

    def serve(self, starter: Starter) -> None:
        """Take the motions of later episodes from another starter of the same task."""
        self._starter = starter

    def start(self, columns: Columns, draws: Sequence[EpisodeDraw], scaled: Array) -> None:
        """Begin episodes and write what their first instant foresees; `scaled` is (m, size)."""
        for k, draw in zip(columns, draws, strict=True):
            motion, lead_in_s = self._starter.motion(draw)
            times_s = lead_in_s + self._starter.task.lead_in.duration_s + self._times_s
            signal = motion.signal(np.minimum(times_s, motion.duration_s))
            self._table[:, :, k] = true_readings(signal, self._names) / self._scale
        self._reads[columns] = 0
        self.read(columns, scaled)

    def read(self, columns: Columns, scaled: Array) -> None:
        """Write what one instant foresees, in place; `scaled` is (m, size)."""
        moments = self._reads[columns][:, None] + self._leads  # (m, places)
        scaled[:, self._places] = self._table[moments, self._rows, columns[:, None]]
        self._reads[columns] += 1

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        return {"table": self._table.copy(), "reads": self._reads.copy()}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        pick = slice(None) if columns is None else columns
        self._table, self._reads = snapshot["table"][..., pick].copy(), snapshot["reads"][pick].copy()
