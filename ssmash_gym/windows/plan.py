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

    def complete(self, counts: Counts) -> bool:
        """Whether each cell has its first `counts` seas."""
        return bool(np.all(self.done | (np.arange(self.done.shape[1]) >= counts[:, None])))


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
    while all(tallies[who].complete(counts) for who, counts in wanted.items()):
        more = {who: _next(config, tallies[who], counts) for who, counts in wanted.items()}
        if effort.episodes is not None:
            more = _affordable(wanted, more, effort.episodes, _promise(config, tallies, wanted))
        if all(np.array_equal(more[who], wanted[who]) for who in wanted):
            break
        wanted = more
    return wanted


def _next(config: WindowConfig, tally: Tally, counts: Counts) -> Counts:
    """Seas after the next round: `step` more for the cells that these leave undecided."""
    found = bounds(tally.hits(counts), counts, config.confidence).verdicts(config.acceptance)
    return np.where(found == UNDECIDED, np.minimum(counts + config.effort.step, config.effort.most), counts)


def _promise(config: WindowConfig, tallies: Mapping[Who, Tally], counts: Mapping[Who, Counts]) -> NDArray[np.float64]:
    """How far each cell's share is from the acceptance level: the farther, the sooner it will be decided, (cells,)."""
    shares = [tallies[who].hits(counts[who]) / counts[who] for who in counts]
    return np.asarray(np.max(np.abs(np.array(shares) - config.acceptance), axis=0), dtype=np.float64)


def _affordable(
    before: dict[Who, Counts], after: dict[Who, Counts], budget: int, promise: NDArray[np.float64]
) -> dict[Who, Counts]:
    """As much of a round as the budget pays for: cells of most promise first, each for all policies together."""
    left = budget - sum(int(counts.sum()) for counts in before.values())
    cost = sum(after[who] - before[who] for who in after)
    order = np.argsort(-promise, kind="stable")
    paid = np.zeros(len(promise), np.bool_)
    paid[order] = np.cumsum(np.asarray(cost)[order]) <= left
    return {who: np.where(paid, after[who], before[who]) for who in after}


def chunks(wanted: Mapping[Who, Counts], tallies: Mapping[Who, Tally], size: int) -> list[Chunk]:
    """The episodes that are wanted and have no row, in chunks of at most `size` seas.

    The seas of a cell stay together, and policies that need the same ones meet them in one chunk.
    """
    found = []
    for stage in dict.fromkeys(stage for stage, _ in wanted):
        names = [policy for here, policy in wanted if here == stage]
        need = np.stack(
            [_missing(tallies[stage, name], wanted[stage, name]) for name in names]
        )  # (policies, cells, seas)
        sets = np.tensordot(1 << np.arange(len(names)), need.astype(np.int64), axes=1)
        for which in np.unique(sets[sets > 0]):
            cells, numbers = np.nonzero(sets == which)
            policies = tuple(name for k, name in enumerate(names) if which >> k & 1)
            for first in range(0, cells.size, size):
                part = slice(first, first + size)
                found.append(Chunk(stage, policies, tuple(cells[part].tolist()), tuple(numbers[part].tolist())))
    return found


def _missing(tally: Tally, counts: Counts) -> Flags:
    return np.asarray((np.arange(tally.done.shape[1]) < counts[:, None]) & ~tally.done)
