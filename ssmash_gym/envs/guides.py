"""Residual action: a baseline drives, and the action corrects it within a bound."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.task import Residual, TaskConfig
from ssmash_gym.errors import ConfigurationError, shown

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


class Guide:
    """The baseline that an environment's actions correct, for N helicopters.

    Args:
        n: Helicopters.
        task: The task; its `residual` says which baseline, and how far it may be corrected.

    Raises:
        ConfigurationError: There is no such baseline, or the task's observation lacks what it reads.
    """

    def __init__(self, n: int, task: TaskConfig, residual: Residual) -> None:
        self._bound = np.array([residual.along, residual.across])
        self._law = _baseline(residual.baseline)(task)
        self._law.reset(n)
        self._fresh = np.ones(n, dtype=np.bool_)

    def begin(self, columns: Columns) -> None:
        """Start episodes of the listed columns."""
        self._fresh[columns] = True

    def commands(
        self, actions: Array, observations: NDArray[np.float32], columns: Columns, direct: bool = False
    ) -> Array:
        """Commands of the listed columns: the baseline's plus the correction, within +-1, (m, 2).

        Args:
            actions: Corrections as shares of their bounds, (m, 2).
            observations: The last ones of all helicopters, (n, size).
            columns: Which, (m,).
            direct: The actions are commands: the baseline looks on, so that it can take over, and adds nothing.
        """
        before = self._memory()
        driven: Array = self._law.act(observations, self._fresh)[columns]
        for name, values in before.items():  # the others have not moved
            values[columns] = getattr(self._law, name)[columns]
            setattr(self._law, name, values)
        self._fresh[columns] = False
        return actions if direct else np.asarray(np.clip(driven + self._bound * actions, -1.0, 1.0))

    def _memory(self) -> dict[str, NDArray[Any]]:
        return {name: getattr(self._law, name).copy() for name in self._law.MEMORY}

    def snapshot(self) -> dict[str, Any]:
        """A copy of everything that changes."""
        return {"fresh": self._fresh.copy(), "memory": self._memory()}

    def restore(self, snapshot: dict[str, Any], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        pick = slice(None) if columns is None else columns
        self._fresh = snapshot["fresh"][pick].copy()
        for name, values in snapshot["memory"].items():
            setattr(self._law, name, values[pick].copy())


def _baseline(name: str) -> Any:
    """The baseline of a name, found when it is asked for: agents stand on environments, and here one carries one.

    Raises:
        ConfigurationError: There is none.
    """
    known = import_module("ssmash_gym.agents.baselines").BASELINES
    if name not in known:
        raise ConfigurationError(f"task: residual.baseline = {shown(name)}: must be one of {', '.join(known)}.")
    return known[name]
