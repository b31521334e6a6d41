"""What a window needs next: rounds of seas, decided from the rows of the earlier ones alone.

The first round gives every cell and policy the same seas. Then each cell that is still undecided gets `step` more,
until all are decided, have `most`, or the budget of episodes is spent. A round is planned from finished rounds only, so
the plan, and with it the dataset, is the same however often the work was interrupted and whoever did it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.windows.chunks import Chunk
from ssmash_gym.windows.config import WindowConfig
from ssmash_gym.windows.criteria import judged
from ssmash_gym.windows.sequential import UNDECIDED, bounds

Counts = NDArray[np.int64]
Flags = NDArray[np.bool_]
Who = tuple[str, str]  # stage and policy


@dataclass
class Tally:
    """Episodes of one policy in one stage.

    Attributes:
        done: Whether an episode has a row, (cells, seas).
        exceeded: Whether a limit was exceeded in it, (cells, seas).
    """

    done: Flags
    exceeded: Flags

    @classmethod
    def blank(cls, cells: int, seas: int) -> Tally:
        """No episode yet."""
        return cls(np.zeros((cells, seas), np.bool_), np.zeros((cells, seas), np.bool_))

    def add(self, cells: NDArray[np.int64], numbers: NDArray[np.int64], exceeded: Flags) -> None:
        """Note finished episodes; seas beyond the table are left out."""
        known = numbers < self.done.shape[1]
        self.done[cells[known], numbers[known]] = True
        self.exceeded[cells[known], numbers[known]] = exceeded[known]

    def hits(self, counts: Counts) -> Counts:
        """Episodes with an exceedance among the first `counts` seas of each cell, (cells,)."""
        first = np.arange(self.done.shape[1]) < counts[:, None]
        return np.asarray(np.sum(self.exceeded & first, axis=1), dtype=np.int64)

    def full(self, counts: Counts) -> Flags:
        """Which cells have their first `counts` seas, (cells,)."""
        return np.asarray(~np.any(self.missing(counts), axis=1))

    def missing(self, counts: Counts) -> Flags:
        """Which of each cell's first `counts` seas have not been run, (cells, seas)."""
        return np.asarray((np.arange(self.done.shape[1]) < counts[:, None]) & ~self.done)


def fill(tallies: Mapping[Who, Tally], config: WindowConfig, rows: pl.DataFrame) -> None:
    """Note the episodes of some rows."""
    for (stage, policy), tally in tallies.items():
        those = rows.filter(pl.col("stage") == stage, pl.col("policy") == policy)
        if those.height:
            found = judged(those, config.figures, must_arrive=config.arrives(stage))
            numbers = (found[name].to_numpy() for name in ("cell", "number", "exceeded"))
            tally.add(*numbers)


def rounds(config: WindowConfig, tallies: Mapping[Who, Tally]) -> dict[Who, Counts]:
    """How many seas each cell shall have at the end of the first round that is not complete yet; or of the last one.

    Args:
        config: The window.
        tallies: What has been run.

    Returns:
        Seas by stage and policy, (cells,).
    """
    effort = config.effort
    wanted = {who: np.full(len(tally.done), effort.seeds, np.int64) for who, tally in tallies.items()}
    closed = np.zeros(len(next(iter(wanted.values()))), np.bool_)  # cells that the budget has once not paid for
    while all(tallies[who].full(counts).all() for who, counts in wanted.items()):
        more = {who: np.where(closed, counts, _next(config, tallies[who], counts)) for who, counts in wanted.items()}
        if effort.episodes is not None:
            paid = _paid(wanted, more, effort.episodes, _promise(config, tallies, wanted, more))
            more = {who: np.where(paid, more[who], counts) for who, counts in wanted.items()}
            closed |= ~paid
        if all(np.array_equal(more[who], wanted[who]) for who in wanted):
            break
        wanted = more
    return wanted


def _next(config: WindowConfig, tally: Tally, counts: Counts) -> Counts:
    """Seas after the next round: `step` more for the cells that these leave undecided."""
    found = bounds(tally.hits(counts), counts, config.confidence).verdicts(config.acceptance)
    return np.where(found == UNDECIDED, np.minimum(counts + config.effort.step, config.effort.most), counts)


def _promise(
    config: WindowConfig, tallies: Mapping[Who, Tally], counts: Mapping[Who, Counts], more: Mapping[Who, Counts]
) -> NDArray[np.float64]:
    """How far the share of a cell's undecided policies is from the acceptance level: the farther, the sooner decided.

    Returns:
        The largest distance of its policies that are to be gone on with, minus infinity where there is none, (cells,).
    """
    found = []
    for who, count in counts.items():
        distance = np.abs(tallies[who].hits(count) / count - config.acceptance)
        found.append(np.where(more[who] > count, distance, -np.inf))
    return np.asarray(np.max(np.array(found), axis=0), dtype=np.float64)


def _paid(
    before: Mapping[Who, Counts], after: Mapping[Who, Counts], budget: int, promise: NDArray[np.float64]
) -> Flags:
    """Which cells' part of a round the budget pays for: those of most promise first, each for all policies together.

    A cell that is not paid for is not gone on with later either: its neighbours, whose seas have the same random
    numbers, may have shown by then what its next ones hold.
    """
    left = budget - sum(int(counts.sum()) for counts in before.values())
    cost = np.sum([after[who] - before[who] for who in after], axis=0)
    order = np.argsort(-promise, kind="stable")
    paid = np.zeros(len(promise), np.bool_)
    paid[order] = np.cumsum(cost[order]) <= left
    return np.asarray(paid | (cost == 0))


def chunks(wanted: Mapping[Who, Counts], tallies: Mapping[Who, Tally], size: int) -> list[Chunk]:
    """The episodes that are wanted and have no row, in chunks of at most `size` seas.

    The seas of a cell stay together, and policies that need the same ones meet them in one chunk.
    """
    found = []
    for stage in dict.fromkeys(stage for stage, _ in wanted):
        names = [policy for here, policy in wanted if here == stage]
        sets = np.zeros(tallies[stage, names[0]].done.shape, np.uint32)
        for k, name in enumerate(names):
            sets |= tallies[stage, name].missing(wanted[stage, name]).astype(np.uint32) << np.uint32(k)
        for which in np.unique(sets[sets > 0]):
            cells, numbers = np.nonzero(sets == which)
            policies = tuple(name for k, name in enumerate(names) if int(which) >> k & 1)
            for first in range(0, cells.size, size):
                part = slice(first, first + size)
                found.append(Chunk(stage, policies, tuple(cells[part].tolist()), tuple(numbers[part].tolist())))
    return found
