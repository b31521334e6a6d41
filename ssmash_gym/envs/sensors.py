"""What is measured: noise and delay of the sensors, and what is made of their readings: forecasts and history.

Each helicopter has its own generator, delay and noise level.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.forecasts import ForecastBank
from ssmash_gym.envs.history import HistoryBank
from ssmash_gym.envs.observations import Observer
from ssmash_gym.envs.oracle import OracleBank
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.starts import Starter

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
_CHUNK = 64  # control intervals whose noise is drawn at once


class Instruments:
    """Turns true observations of N helicopters into measured ones, in place.

    Args:
        n: Helicopters.
        observer: Which terms are observed.
        starter: Of the episodes; its scenario says how late and noisy sensors can be.

    Raises:
        ConfigurationError: The observation holds forecasts, and the task's control interval does not suit them.
    """

    def __init__(self, n: int, observer: Observer, starter: Starter) -> None:
        delay, noise = (starter.scenario.bounds(f"sensors.{key}") or (0.0, 0.0) for key in ("delay_s", "noise"))
        self._places = observer.sensors
        self._sensors = SensorBank(n, observer.noise, delay[1], starter.task.control_interval_s, bool(noise[1]))
        self._forecasts: ForecastBank | None = None
        if any(term.forecast_of for term in observer.terms):
            self._forecasts = ForecastBank(n, observer, starter, self.longest_delay_s)
        self._oracle: OracleBank | None = None
        if any(term.oracle_of for term in observer.terms):
            self._oracle = OracleBank(n, observer, starter)
        self._history: HistoryBank | None = None
        if any(term.past_of for term in observer.terms):
            self._history = HistoryBank(n, observer, starter.task.control_interval_s)

    @property
    def longest_delay_s(self) -> float:
        """What the sensors' memory reaches back [s]."""
        return self._sensors.longest_delay_s

    @property
    def noisy(self) -> bool:
        """Whether any helicopter can have noise."""
        return self._sensors.noisy

    def serve(self, starter: Starter) -> None:
        """Take the motions of later episodes from another starter of the same task."""
        for bank in (self._forecasts, self._oracle):
            if bank is not None:
                bank.serve(starter)

    def start(self, columns: Columns, draws: Sequence[EpisodeDraw], scaled: Array) -> None:
        """Begin episodes of the listed columns and measure their first instant; `scaled` is (m, size)."""
        seeds = [draw.sensor_seed for draw in draws]
        levels, delays = [draw.sensors_noise for draw in draws], [draw.sensors_delay_s for draw in draws]
        scaled[:, self._places] = self._sensors.start(columns, seeds, levels, delays, scaled[:, self._places])
        if self._forecasts is not None:
            self._forecasts.start(columns, draws, scaled)
        if self._oracle is not None:
            self._oracle.start(columns, draws, scaled)
        if self._history is not None:
            self._history.start(columns, scaled)

    def read(self, columns: Columns, scaled: Array) -> None:
        """Measure one instant of the listed columns; `scaled` is (m, size)."""
        scaled[:, self._places] = self._sensors.read(columns, scaled[:, self._places])
        for bank in (self._forecasts, self._oracle, self._history):
            if bank is not None:
                bank.read(columns, scaled)

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        return {name: bank.snapshot() for name, bank in self._banks().items()}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        for name, bank in self._banks().items():
            bank.restore(snapshot[name], columns)

    def _banks(self) -> dict[str, SensorBank | ForecastBank | OracleBank | HistoryBank]:
        banks = {
            "sensors": self._sensors, "forecasts": self._forecasts, "oracle": self._oracle, "history": self._history,
        }  # fmt: skip
        return {name: bank for name, bank in banks.items() if bank is not None}


class SensorBank:
    """The sensors of N helicopters; values are in units of the observation's scales.

    A reading of age d between two control instants is interpolated between them. Before the start the first value
    stood for ever.

    Args:
        n: Helicopters.
        noise: Nominal standard deviation of each sensor, (k,).
        longest_delay_s: Longest delay that any helicopter will have; control_interval_s: time between two readings.
        noisy: Whether any helicopter will have noise.
    """

    def __init__(self, n: int, noise: Array, longest_delay_s: float, control_interval_s: float, noisy: bool) -> None:
        self._noise = noise
        self._noisy = noisy
        self._interval = control_interval_s
        depth = int(np.ceil(longest_delay_s / control_interval_s - 1e-9)) + 1
        self._past: Array = np.zeros((depth, n, noise.size))  # newest first
        self._draws: Array = np.zeros((n, _CHUNK, noise.size)) if noisy else np.zeros((n, 0, noise.size))
        self._reads: Columns = np.zeros(n, np.int64)
        self._level: Array = np.zeros(n)
        self._delay: Array = np.zeros(n)  # in control intervals
        self._aim()
        self._generators = [np.random.default_rng(0) for _ in range(n)]

    @property
    def longest_delay_s(self) -> float:
        """What the memory reaches back [s]."""
        return float((self._past.shape[0] - 1) * self._interval)

    @property
    def noisy(self) -> bool:
        """Whether any helicopter can have noise."""
        return self._noisy

    def start(
        self, columns: Columns, seeds: Sequence[int], levels: Sequence[float], delays_s: Sequence[float], values: Array
    ) -> Array:
        """Begin an episode and read its first instant; returns what is measured, (m, k)."""
        for k, seed in zip(columns, seeds, strict=True):
            self._generators[k] = np.random.default_rng(seed)
        self._reads[columns] = 0
        self._level[columns] = levels
        self._delay[columns] = np.asarray(delays_s) / self._interval
        self._aim()
        self._past[:, columns] = values
        return self._measured(columns, values)

    def read(self, columns: Columns, values: Array) -> Array:
        """Read one instant: the true values (m, k) go in, what is measured comes out."""
        pick: Any = slice(None) if self._all(columns) else columns  # slices spare the copies of a whole bank
        for age in range(self._past.shape[0] - 1, 0, -1):
            self._past[age, pick] = self._past[age - 1, pick]
        self._past[0, pick] = values
        return self._measured(columns, values)

    def _all(self, columns: Columns) -> bool:
        """Whether these are all helicopters, in order."""
        return columns.size == self._reads.size and bool((columns[1:] > columns[:-1]).all())

    def _aim(self) -> None:
        """Work out from the delays between which readings of the past each helicopter's lies."""
        self._whole = np.floor(self._delay).astype(np.int64)
        self._part = (self._delay - self._whole)[:, None]
        self._older = np.minimum(self._whole + 1, self._past.shape[0] - 1)

    def _measured(self, columns: Columns, values: Array) -> Array:
        if self._past.shape[0] > 1:
            part = self._part[columns]
            newer, older = self._past[self._whole[columns], columns], self._past[self._older[columns], columns]
            values = (1.0 - part) * newer + part * older
        if not self._noisy:
            return values
        place = self._reads[columns] % _CHUNK
        for k in columns[place == 0]:
            self._draws[k] = self._generators[k].standard_normal(self._draws.shape[1:])
        self._reads[columns] += 1
        return values + self._level[columns][:, None] * self._noise * self._draws[columns, place]

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        arrays = {name: getattr(self, name).copy() for name in _SAVED}
        return {**arrays, "_generators": copy.deepcopy(self._generators)}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        for name in _SAVED:
            saved = snapshot[name]
            axis = 1 if name == "_past" else 0
            setattr(self, name, saved.copy() if columns is None else np.take(saved, columns, axis=axis))
        self._aim()
        found = snapshot["_generators"]
        order = range(len(found)) if columns is None else columns
        self._generators = [copy.deepcopy(found[k]) for k in order]


_SAVED = ("_past", "_draws", "_reads", "_level", "_delay")
