"""Forecasts in the observation: each helicopter's own model of its deck, fitted on the past and fed with readings.

A ship has been at sea for hours when a helicopter is moved. So before an episode the deck has a past: the motion that
was drawn, at times before the task's, without the ramp by which the simulation brings it up. From noisy readings of
that past, and from nothing else, an autoregressive model is fitted; after that the observation's own readings, noise
and delay included, are all that comes in. Nothing here looks at the motion after the task's time has begun.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.observations import GRAVITY, TERMS, Observer
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.starts import Starter
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Signal
from ssmash_gym.ship.forecast import ORDER, ArModel, ordered_sum, persistence
from ssmash_gym.ship.motion import pose_of

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
SPACING_S: Final = 0.2  # between the samples of a model, as near as whole control intervals come to it
WIDEST_S: Final = 0.25
HISTORY_S: Final = 180.0  # what a model is fitted on; assumed
SHORTEST_S: Final = 60.0  # with less past than this the forecast is that all stays as it is
_KEY: Final = 1  # of the past's noise among the children of an episode's sensor seed


class ForecastBank:
    """The forecasts of N helicopters, in units of the observation's scales.

    Args:
        n: Helicopters.
        observer: Which terms are observed, and which of them are forecasts.
        starter: Gives the motion of a draw.
        longest_delay_s: Longest sensor delay that any helicopter will have.

    Raises:
        ConfigurationError: The task's control interval does not suit.
    """

    def __init__(self, n: int, observer: Observer, starter: Starter, longest_delay_s: float) -> None:
        self._starter = starter
        self._interval = starter.task.control_interval_s
        self._stride = stride_of(self._interval)
        self._spacing = self._stride * self._interval
        wanted = [(place, term) for place, term in enumerate(observer.terms) if term.forecast_of]
        self._names = list(dict.fromkeys(term.forecast_of for _, term in wanted))
        leads = sorted({term.lead_s for _, term in wanted})
        self._leads = [round(lead / self._spacing) for lead in leads]
        self._sources = np.array([observer.names.index(name) for name in self._names])
        self._places = np.array([place for place, _ in wanted])
        self._rows = np.array([self._names.index(term.forecast_of) for _, term in wanted])
        self._columns = np.array([leads.index(term.lead_s) for _, term in wanted])
        self._scale = np.array([TERMS[name].scale for name in self._names])
        self._noise = np.array([TERMS[name].noise for name in self._names]) / self._scale
        self._lags = self._stride * np.arange(ORDER)
        signals = len(self._names)
        late = math.ceil(longest_delay_s / self._interval - 1e-9)
        # Helicopters last: the elementwise loops of a step are long then.
        self._weights: Array = np.zeros((ORDER, signals, len(leads), n))
        self._constant: Array = np.zeros((signals, len(leads), n))
        self._ring: Array = np.zeros((int(self._lags[-1]) + 1, signals, n))
        self._late: Array = np.zeros((late + 1, signals, n))  # the last row stays zero
        self._reads: Columns = np.zeros(n, np.int64)

    def serve(self, starter: Starter) -> None:
        """Take the motions of later episodes from another starter of the same task."""
        self._starter = starter

    def start(self, columns: Columns, draws: Sequence[EpisodeDraw], scaled: Array) -> None:
        """Begin episodes: fit their models, take the first readings, and write the first forecasts.

        Args:
            columns: Which, (m,).
            draws: Their episodes.
            scaled: Observations as measured, (m, size); the forecasts' places are filled.
        """
        for k, draw in zip(columns, draws, strict=True):
            self._begin(int(k), draw)
        self.read(columns, scaled)

    def read(self, columns: Columns, scaled: Array) -> None:
        """Take the readings of one instant and write the forecasts beside them, in place; `scaled` is (m, size)."""
        reads, every = self._reads[columns], np.arange(len(self._names))[:, None]
        length = len(self._ring)
        late = np.minimum(reads, len(self._late) - 1)
        read = scaled[:, self._sources].T + self._late[late, every, columns]
        self._ring[reads % length, every, columns] = read
        past = self._ring[((reads - self._lags[:, None]) % length)[:, None], every, columns]  # (order, signals, m)
        told = ordered_sum(self._of(self._weights, columns) * past[:, :, None]) + self._of(self._constant, columns)
        scaled[:, self._places] = told[self._rows, self._columns].T
        self._reads[columns] += 1

    def _of(self, numbers: Array, columns: Columns) -> Array:
        """The listed columns of a table; a view where they are all of them in order."""
        whole = columns.size == len(self._reads) and bool((columns[1:] > columns[:-1]).all())
        return numbers if whole else numbers[..., columns]

    def _begin(self, k: int, draw: EpisodeDraw) -> None:
        """Give column k the model and the past readings of its episode."""
        self._reads[k] = 0
        self._late[..., k] = 0.0
        self._ring[..., k] = 0.0
        motion, lead_in_s = self._starter.motion(draw)
        start_s = lead_in_s + self._starter.task.lead_in.duration_s
        now_s = start_s - draw.sensors_delay_s  # of the motion, when the reading of instant 0 is taken
        count = round(HISTORY_S / self._spacing)
        if math.isfinite(motion.duration_s):  # a record begins at its time 0
            count = min(count, math.floor(now_s / self._spacing + 1e-9))
        if count * self._spacing < SHORTEST_S - 1e-9:
            self._weights[..., k] = np.moveaxis(persistence(ORDER, self._leads, len(self._names)), 0, -1)
            self._constant[..., k] = 0.0
            return
        children = np.random.SeedSequence(draw.sensor_seed, spawn_key=(_KEY,))
        noise = np.random.default_rng(children).standard_normal((count * self._stride, len(self._names)))
        noise *= draw.sensors_noise * self._noise
        true = self._scaled(motion.sample(now_s - count * self._spacing, self._spacing, count))
        model = ArModel.fit(true + noise[:: self._stride])
        weights = model.weights(self._leads)
        self._weights[..., k] = np.moveaxis(weights, 0, -1)
        self._constant[..., k] = (model.mean * (1.0 - ordered_sum(np.moveaxis(weights, 1, 0)))).T
        recent = len(self._ring) - 1
        late = math.ceil(draw.sensors_delay_s / self._interval - 1e-9)
        instants = self._interval * np.arange(-recent, late)
        true = self._scaled(motion.signal(np.append(now_s + instants, start_s)))
        if recent:
            self._ring[1:, :, k] = true[:recent] + noise[-recent:]  # instant j stands in place j modulo the length
        # Late sensors still hold the first value when the episode begins, though the deck has moved: what they lack.
        self._late[:late, :, k] = true[recent : recent + late] - true[-1]

    def _scaled(self, signal: Signal) -> Array:
        """What noiseless sensors would read at the signal's times, scaled, (times, signals)."""
        return np.asarray(true_readings(signal, self._names) / self._scale)

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        return {name: getattr(self, name).copy() for name in _SAVED}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        for name in _SAVED:
            setattr(self, name, snapshot[name].copy() if columns is None else snapshot[name][..., columns])


def true_readings(signal: Signal, names: Sequence[str]) -> Array:
    """What noiseless sensors of the deck would read at a signal's times, SI, (times, names).

    Args:
        signal: Motion of the deck.
        names: Terms: ``deck_roll``, ``deck_fx``, ``deck_fy``, ``deck_fz``.
    """
    force = pose_of(signal).specific_force_S(GRAVITY)
    values = {
        "deck_roll": signal.position[:, 3],
        "deck_fx": force[:, 0],
        "deck_fy": force[:, 1],
        "deck_fz": force[:, 2] + GRAVITY,
    }
    return np.stack([values[name] for name in names], axis=1)


def stride_of(control_interval_s: float) -> int:
    """Control intervals between two samples of a model: about `SPACING_S`, and the leads are whole samples.

    Raises:
        ConfigurationError: There is no such number.
    """
    stride = round(SPACING_S / control_interval_s)
    spacing_s = stride * control_interval_s
    samples = 1.0 / spacing_s if stride else 0.0
    if not stride or spacing_s > WIDEST_S + 1e-9 or abs(samples - round(samples)) > 1e-6:
        raise ConfigurationError(
            f"task: control_interval_s = {control_interval_s:g} is refused with forecasts in the observation: a whole "
            f"number of intervals near {SPACING_S:g} s, at most {WIDEST_S:g} s, must divide 1 s (0.05, 0.1 or 0.2 do)."
        )
    return stride


_SAVED = ("_weights", "_constant", "_ring", "_late", "_reads")
