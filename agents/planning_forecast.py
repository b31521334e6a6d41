"""The deck that a planner rehearses on: the measured past carried on by autoregression, or the true future.

Angles are forecast as they are, and surge, sway and heave as accelerations, which are what loads a helicopter; a
forecast goes to the mean by itself as its lead grows. Readings are taken without noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.ship.forecast import ArModel, ordered_sum
from ssmash_gym.ship.motion import N_CHANNELS

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
HISTORY_S: Final = 180.0  # what a model is fitted on; assumed
LOOK_BACK_S: Final = 10.0  # samples of a prediction
RIDGE: Final = 1e-5  # as if the readings had 0.3 % more noise; assumed
GUST_FADES_S: Final = 5.0  # a gust is taken to die away so; assumed
_LINEAR: Final = 3  # of the six channels the first three are forecast as accelerations
_BESIDES: Final = 2  # further samples that the derivatives of the last node need


class ArForecast:
    """Forecasts for the running helicopters of a batch, each from its own past.

    Of an episode's draw it takes the sea at times before the task's, as a ship that has been at sea for long has
    measured it; from then on the deck table up to the present. It never looks at a later time.

    Args:
        core: The batch.
        horizon_s: Longest time ahead [s].
    """

    def __init__(self, core: TraverseBatch, horizon_s: float) -> None:
        self._core = core
        timing = core.batch.timing
        self._spacing_s = timing.node_spacing_s
        self._per_node = timing.substeps_per_node
        self._ahead = math.ceil(horizon_s / self._spacing_s) + 2
        self._order = round(LOOK_BACK_S / self._spacing_s)
        # The first node of the task's own time: those before it are the lead-in's, whose motion is ramped.
        self._first = math.ceil(core.task.lead_in.duration_s / self._spacing_s - 1e-9)
        self._before: dict[int, Array] = {}
        self._models: dict[int, tuple[Array, Array] | None] = {}

    def begin(self, rows: Columns) -> None:
        """Fit the models of episodes that have just begun."""
        leads = range(1, self._ahead + _BESIDES)
        for k in rows.tolist():
            past = self._history(k)
            self._before[k], self._models[k] = past[-self._order :], None
            if len(past) >= 2 * self._order:
                model = ArModel.fit(past, self._order, RIDGE)
                self._models[k] = model.weights(leads), model.mean

    def nodes(self, rows: Columns) -> tuple[Array, Array]:
        """Deck and gust nodes of the listed helicopters from the last node passed on, (n, m, 18) and (n, m, 3)."""
        passed = self._core.batch.clocks[rows] // self._per_node
        decks = np.stack([self._deck(int(k), int(node)) for k, node in zip(rows, passed, strict=True)])
        time = self._spacing_s * np.arange(self._ahead)
        fading = np.exp(-time / GUST_FADES_S)
        shape = np.stack([fading, -fading / GUST_FADES_S, fading / GUST_FADES_S**2], axis=1)
        gusts = self._core.batch.gust_nodes
        now = np.minimum(passed, gusts.shape[1] - 1)  # a batch without gusts has a short table of zeros
        return decks, gusts[rows, now, 0][:, None, None] * shape

    def _history(self, k: int) -> Array:
        """Samples of the unramped motion before the task's time, oldest first, (count, 6)."""
        draw = self._core.draws[k]
        assert draw is not None
        motion, lead_in_s = self._core.starter.motion(draw)
        end_s = lead_in_s + self._first * self._spacing_s
        count = round(HISTORY_S / self._spacing_s)
        if math.isfinite(motion.duration_s):  # a record begins at its time 0
            count = min(count, math.floor(end_s / self._spacing_s + 1e-9))
        if count == 0:
            return np.zeros((0, N_CHANNELS))
        signal = motion.sample(end_s - count * self._spacing_s, self._spacing_s, count)
        return _series(signal.position, signal.acceleration)

    def _deck(self, k: int, passed: int) -> Array:
        """Nodes of one helicopter's deck from its last node on, (m, 18)."""
        known = self._core.batch.nodes[k, : passed + 1]
        now = known[-1]
        model = self._models[k]
        measured = known[self._first :]
        past = np.concatenate([self._before[k], _series(measured[:, :6], measured[:, 12:])])
        if model is None:  # too short a past: the deck stays as it is
            told = np.tile(np.append(np.zeros(_LINEAR), now[_LINEAR:N_CHANNELS]), (self._ahead + _BESIDES - 1, 1))
        else:
            weights, mean = model
            newest_first = (past[::-1] - mean)[: self._order]
            told = mean + ordered_sum(np.moveaxis(weights * newest_first, 1, 0))
        return self._joined(now, past[-_BESIDES - 1 :], told)

    def _joined(self, now: Array, past: Array, told: Array) -> Array:
        """Nodes from the present one and the forecast series that follows it."""
        h, ahead = self._spacing_s, self._ahead
        nodes = np.zeros((ahead, 3 * N_CHANNELS))
        nodes[0] = now
        x, v, a = (nodes[:, N_CHANNELS * d : N_CHANNELS * d + _LINEAR] for d in range(3))
        a[1:] = told[: ahead - 1, :_LINEAR]
        for i in range(1, ahead):  # linear acceleration between nodes, integrated
            v[i] = v[i - 1] + 0.5 * h * (a[i - 1] + a[i])
            x[i] = x[i - 1] + h * v[i - 1] + h * h * (2.0 * a[i - 1] + a[i]) / 6.0
        angles = np.concatenate([past[:, _LINEAR:], told[:, _LINEAR:]])
        inner = [angles[_BESIDES + d : _BESIDES + d + ahead] for d in (-2, -1, 0, 1, 2)]
        nodes[1:, _LINEAR:N_CHANNELS] = inner[2][1:]
        rate = (inner[0] - 8.0 * inner[1] + 8.0 * inner[3] - inner[4]) / (12.0 * h)
        bend = (-inner[0] + 16.0 * inner[1] - 30.0 * inner[2] + 16.0 * inner[3] - inner[4]) / (12.0 * h * h)
        nodes[1:, N_CHANNELS + _LINEAR : 2 * N_CHANNELS] = rate[1:]
        nodes[1:, 2 * N_CHANNELS + _LINEAR :] = bend[1:]
        return nodes


class TrueFuture:
    """The deck and the gusts as they will be: for the clairvoyant reference alone.

    Args:
        core: The batch.
        horizon_s: Longest time ahead [s].
    """

    def __init__(self, core: TraverseBatch, horizon_s: float) -> None:
        self._core = core
        self._ahead = math.ceil(horizon_s / core.batch.timing.node_spacing_s) + 2

    def begin(self, rows: Columns) -> None:
        """Nothing has to be fitted."""

    def nodes(self, rows: Columns) -> tuple[Array, Array]:
        """Deck and gust nodes of the listed helicopters from the last node passed on, (n, m, 18) and (n, m, 3)."""
        batch = self._core.batch
        passed = batch.clocks[rows] // batch.timing.substeps_per_node
        return self._from(batch.nodes, rows, passed), self._from(batch.gust_nodes, rows, passed)

    def _from(self, store: Array, rows: Columns, passed: Sequence[int] | Columns) -> Array:
        place = np.minimum(np.asarray(passed)[:, None] + np.arange(self._ahead), store.shape[1] - 1)
        return np.asarray(store[rows[:, None], place])


def _series(position: Array, acceleration: Array) -> Array:
    """What is forecast of the six channels, (count, 6)."""
    return np.concatenate([acceleration[:, :_LINEAR], position[:, _LINEAR:N_CHANNELS]], axis=1)
