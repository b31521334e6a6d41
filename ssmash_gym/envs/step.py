"""What a step of the batch gives, and what a copy of the batch holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.simulation.batch import Snapshot

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class StepResult:
    """What a step gave for its m columns; shape (m,) unless said otherwise. All arrays are new.

    Attributes:
        columns: Which columns.
        observation: (m, size) float32.
        reward, terminated, truncated: As in Gymnasium.
        cost: Sum of `costs`; costs, margins, reward_terms: by name.
        saturation: Share of the command's components that lay beyond +-1 before clipping.
        clipped: How many numbers of the observation were clipped.
        time_s: Time since the start [s].
        endings: For each ended column: ``reason``, ``success``, ``episode_metrics``, and ``divergence`` if it was one.
    """

    columns: Columns
    observation: NDArray[np.float32]
    reward: Array
    terminated: Flags
    truncated: Flags
    cost: Array
    costs: dict[str, Array]
    margins: dict[str, Array]
    reward_terms: dict[str, Array]
    saturation: Array
    clipped: NDArray[np.int64]
    time_s: Array
    endings: dict[int, dict[str, Any]] = field(default_factory=dict)

    def info(self, i: int) -> dict[str, Any]:
        """Row i as the single environment's info."""
        return {
            "time_s": float(self.time_s[i]),
            "cost": float(self.cost[i]),
            "costs": {name: float(values[i]) for name, values in self.costs.items()},
            "margins": {name: float(values[i]) for name, values in self.margins.items()},
            "reward_terms": {name: float(values[i]) for name, values in self.reward_terms.items()},
            "action_saturation": float(self.saturation[i]),
            "observation_clipped": int(self.clipped[i]),
            **self.endings.get(int(self.columns[i]), {}),
        }


@dataclass(frozen=True)
class BatchSnapshot:
    """Everything a `TraverseBatch` is at one instant; can be pickled."""

    physics: Snapshot
    book: dict[str, NDArray[Any]]
    sensors: dict[str, Any]
    generators: list[np.random.Generator | None]
    draws: list[EpisodeDraw | None]
    last: NDArray[np.float32]
    guide: dict[str, Any]
