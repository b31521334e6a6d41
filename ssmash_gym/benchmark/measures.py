"""What a benchmark measures besides the environment's metrics: how far the claw went and how often it was turned back.

One definition for everybody: a participant's trial is re-simulated under the same eyes as an agent's episode.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.step import StepResult

Array = NDArray[np.float64]
BAND: Final = 0.05  # commands nearer zero have no direction: a stick never rests exactly at zero; assumed


def reversals(commands: ArrayLike, band: float = BAND) -> int:
    """How often a driver turned the claw's command back.

    Each axis by itself: commands within the band are left out, and of what is left every change of sign between one
    command and the next counts. So forward, stop, forward is none, and forward, stop, back is one, however long the
    stop. Both axes together.

    Args:
        commands: Applied commands, (n, 2), shares of the claw's speeds along and across the track.
        band: Largest size of a command without a direction.
    """
    count = 0
    for axis in np.reshape(np.asarray(commands, dtype=np.float64), (-1, 2)).T:
        signs = np.sign(axis[np.abs(axis) > band])
        count += int(np.count_nonzero(signs[1:] != signs[:-1]))
    return count


def path_m(places: ArrayLike) -> float:
    """Length of the way through places (n, 2) [m]: the straight pieces between control instants, added up."""
    steps = np.diff(np.reshape(np.asarray(places, dtype=np.float64), (-1, 2)), axis=0)
    return float(np.sum(np.hypot(steps[:, 0], steps[:, 1])))


class ClawWatch:
    """Writes down commands and places of the claw of episodes that have just begun.

    Places are those at the end of each control interval: in the first one the claw has hardly begun to move.

    Args:
        batch: The episodes.
    """

    def __init__(self, batch: TraverseBatch) -> None:
        self._batch = batch
        self._places: list[list[tuple[float, float]]] = [[] for _ in range(batch.n)]
        self._commands: list[list[tuple[float, float]]] = [[] for _ in range(batch.n)]

    def note(self, result: StepResult) -> None:
        """Called after each control interval."""
        telemetry, command = self._batch.telemetry, self._batch.book.command
        x, y = telemetry["claw_x"], telemetry["claw_y"]
        for k in result.columns:
            self._places[k].append((float(x[k]), float(y[k])))
            self._commands[k].append((float(command[k, 0]), float(command[k, 1])))

    def row(self, k: int) -> dict[str, Any]:
        """Length of the claw's way over the deck [m] and reversals of the command, of column k."""
        return {"claw_path_m": path_m(self._places[k]), "reversals": reversals(self._commands[k])}
