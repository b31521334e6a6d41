"""Costs of exceeding limits: reward minus multiplier times the environment's cost.

With a `rate`, the multipliers are those of a Lagrangian: they rise by projected ascent while the episodes' mean cost is
above what is allowed, and fall while it is below. With rate 0 they are fixed weights: cost shaping.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.training.sections import Cost, LimitName

try:
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecEnvWrapper
except ImportError as error:
    raise ImportError('training needs Stable-Baselines3: pip install "ssmash_gym[train]".') from error

Array = NDArray[np.float64]


class Priced(VecEnvWrapper):
    """Takes the costs off the reward.

    Args:
        venv: A `Staggered` batch, or any other wrapper of a `TraverseVecEnv`.
        costs: What is priced, by name of the limit.

    Attributes:
        multipliers: Reward lost for a control interval beyond each limit, (m,).
        finished: Costs of each episode that ended since the last `update`, (m,) each.
    """

    def __init__(self, venv: Any, costs: Mapping[LimitName, Cost]) -> None:
        super().__init__(venv)
        self.names: tuple[str, ...] = tuple(costs)
        self._native = venv.unwrapped
        of = {key: np.array([getattr(cost, key) for cost in costs.values()]) for key in Cost.model_fields}
        self._limit, self._rate, self._proportional = of["limit_per_episode"], of["rate"], of["proportional"]
        self._largest = of["largest"]
        self._integral: Array = of["weight"].astype(np.float64)
        self.multipliers: Array = self._integral.copy()
        self._running = np.zeros((venv.num_envs, len(self.names)))
        self.finished: list[Array] = []

    def reset(self) -> NDArray[np.float32]:
        """Start all episodes."""
        self._running[:] = 0.0
        return np.asarray(self.venv.reset())

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One control interval for all."""
        observations, rewards, dones, infos = self.venv.step_wait()
        costs = np.stack([self._native.last_costs[name] for name in self.names], axis=1)
        self._running += costs
        for k in np.flatnonzero(dones):
            if "episode_metrics" in infos[k]:  # else it was cut short to get the helicopters out of step
                self.finished.append(self._running[k].copy())
            self._running[k] = 0.0
        priced = rewards - (costs * self.multipliers).sum(axis=1).astype(np.float32)
        return observations, priced, np.asarray(dones), infos

    def told(self) -> dict[str, float]:
        """For the curve: mean cost of the finished episodes [control intervals] and multiplier, by name."""
        found = np.mean(self.finished, axis=0) if self.finished else np.full(len(self.names), np.nan)
        costs = {f"cost_{name}": float(value) for name, value in zip(self.names, found, strict=True)}
        prices = zip(self.names, self.multipliers, strict=True)
        return costs | {f"multiplier_{name}": float(value) for name, value in prices}

    def update(self) -> None:
        """Adapt the multipliers to the finished episodes; without any, they stay."""
        if not self.finished:
            return
        excess = np.mean(self.finished, axis=0) - self._limit
        self._integral = np.clip(self._integral + self._rate * excess, 0.0, self._largest)
        self.multipliers = np.clip(self._integral + self._proportional * excess, 0.0, self._largest)
        self.finished = []

    def state(self) -> dict[str, Array]:
        """Everything that changes, for a checkpoint; between two updates no finished episode is waiting."""
        waiting = np.reshape(self.finished, (len(self.finished), len(self.names)))
        return {
            "integral": self._integral, "multipliers": self.multipliers, "running": self._running, "finished": waiting
        }  # fmt: skip

    def restore(self, state: Mapping[str, Array]) -> None:
        """The inverse of `state`."""
        self._integral, self.multipliers = state["integral"].copy(), state["multipliers"].copy()
        self._running, self.finished = state["running"].copy(), list(state["finished"].copy())


class Multipliers(BaseCallback):
    """Adapts the multipliers after each update's episodes; the next ones are priced anew.

    Args:
        priced: Whose.
        every: Control intervals of all helicopters together between two updates.
    """

    def __init__(self, priced: Priced, every: int) -> None:
        super().__init__()
        self.priced, self.every = priced, every

    def _on_rollout_end(self) -> None:
        if self.model.num_timesteps % self.every == 0:
            self.priced.update()

    def _on_step(self) -> bool:
        return True
