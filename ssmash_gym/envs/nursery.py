"""Episodes prepared ahead of time, several at once.

Columns of a batch end their episodes at different times, and the start of an episode (settling, lead-in) takes as long
for four helicopters as for one. So when a column needs a start, the next starts of some neighbours are prepared with
it and kept until they are needed. Each column draws from its own generator only, and nothing depends on neighbours:
the episodes are bit for bit what they would be without.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.engine import lane_width
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.starts import Starter
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation.batch import Batch

Columns = NDArray[np.int64]
_GROUP = 4  # lane blocks a thread prepares at once


@dataclass
class _Child:
    """A prepared start: its slot in the nursery's batch, its draw, and the generator after the draw."""

    slot: int
    draw: EpisodeDraw
    generator: np.random.Generator


class Nursery:
    """Prepared starts for the columns of a batch.

    Args:
        starter: Starts episodes.
        n: Columns of the batch that is served.
        threads: Workers.
    """

    def __init__(self, starter: Starter, n: int, threads: int) -> None:
        self._starter = starter
        self._threads = threads
        self._width = lane_width(n)
        self._capacity = min(n, _GROUP * self._width * threads) if n > self._width else 0
        self._batch: Batch | None = None
        self._children: dict[int, _Child] = {}

    def clear(self) -> None:
        """Forget all prepared starts."""
        self._children.clear()

    def forget(self, k: int) -> None:
        """Forget the prepared start of column k: its generator is no longer the one it was drawn from."""
        self._children.pop(k, None)

    def start(
        self,
        batch: Batch,
        columns: Columns,
        generators: list[np.random.Generator | None],
        draws: list[EpisodeDraw | None],
        steps: NDArray[np.int64],
    ) -> None:
        """Bring columns of the batch to the start of their next episodes.

        Args:
            batch: The batch that is served.
            columns: Which.
            generators: One a column of the batch; those of `columns` move on by one draw.
            draws: One a column of the batch; those of `columns` are replaced.
            steps: How long each column's episode has run: the longest ones are prepared first.

        Raises:
            ConfigurationError: A draw is refused; nothing has been started, and no generator has moved on.
        """
        missing = np.array([k for k in columns if int(k) not in self._children], dtype=np.int64)
        if 0 < missing.size < self._width and self._capacity:
            with suppress(ConfigurationError):  # perhaps of a neighbour, whose own start will tell
                self._prepare(missing, generators, steps)
            missing = np.array([k for k in missing if int(k) not in self._children], dtype=np.int64)
        if missing.size:
            ahead = [copy.deepcopy(_of(generators, k)) for k in missing]
            fresh = [self._starter.scenario.sample(generator) for generator in ahead]
            self._starter.start(batch, missing, fresh)
            for k, draw, generator in zip(missing, fresh, ahead, strict=True):
                draws[k] = draw
                move_on(_of(generators, k), generator)
        ready = [int(k) for k in columns if int(k) in self._children]
        if ready and self._batch is not None:
            children = [self._children.pop(k) for k in ready]
            batch.take(self._batch, [child.slot for child in children], ready)
            for k, child in zip(ready, children, strict=True):
                draws[k], generators[k] = child.draw, child.generator

    def _prepare(
        self, missing: Columns, generators: list[np.random.Generator | None], steps: NDArray[np.int64]
    ) -> None:
        """Prepare starts for the missing columns and, with the room that is left, for others."""
        if self._batch is None:
            self._batch = self._starter.batch(self._capacity, self._threads)
        self._make_room(int(missing.size), steps)
        taken = {child.slot for child in self._children.values()}
        free = [slot for slot in range(self._capacity) if slot not in taken]
        wanted = [int(k) for k in missing]
        others = [int(k) for k in np.argsort(-steps, kind="stable") if int(k) not in self._children]
        wanted += [k for k in others if k not in wanted and generators[k] is not None]
        chosen = wanted[: len(free)]
        children: dict[int, _Child] = {}
        for k, slot in zip(chosen, free, strict=False):
            generator = copy.deepcopy(_of(generators, k))
            children[k] = _Child(slot, self._starter.scenario.sample(generator), generator)
        slots = np.array(free[: len(chosen)], dtype=np.int64)
        self._starter.start(self._batch, slots, [child.draw for child in children.values()])
        self._children |= children  # only now: a refused draw is no start

    def _make_room(self, count: int, steps: NDArray[np.int64]) -> None:
        """Give up prepared starts until `count` slots are free, those needed last first."""
        while self._capacity - len(self._children) < count:
            del self._children[min(self._children, key=lambda k: int(steps[k]))]


def move_on(generator: np.random.Generator, ahead: np.random.Generator) -> None:
    """Bring a generator to where a copy of it has got to; it stays the same object, which others may hold."""
    generator.bit_generator.state = ahead.bit_generator.state


def _of(generators: Sequence[np.random.Generator | None], k: int) -> np.random.Generator:
    generator = generators[k]
    assert generator is not None
    return generator
