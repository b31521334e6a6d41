"""Starts the helicopters of a batch out of step with each other.

Episodes of one length that start together stay together: every update then sees one part of the track only, and
unlearns the others. So the first episode of each helicopter is cut at another time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

try:
    from stable_baselines3.common.vec_env import VecEnvWrapper
except ImportError as error:
    raise ImportError('training needs Stable-Baselines3: pip install "ssmash_gym[train]".') from error


class Staggered(VecEnvWrapper):
    """Cuts the first episode of helicopter k of N after a share (k + 1) / N of the horizon, as by a time limit.

    Args:
        native: A `TraverseVecEnv`.
    """

    def __init__(self, native: Any) -> None:
        super().__init__(native)
        self.core = native.core
        self._stops = np.ceil(np.arange(1, native.num_envs + 1) / native.num_envs * self.core.task.horizon_steps)
        self.steps = 0

    def reset(self) -> NDArray[np.float32]:
        """Start all episodes."""
        self.steps = 0
        return np.asarray(self.venv.reset())

    def step_wait(self) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """One control interval for all."""
        observations: Any
        observations, rewards, dones, infos = self.venv.step_wait()
        self.steps += 1
        cut = np.flatnonzero((self._stops == self.steps) & ~dones)
        if cut.size:
            for k in cut:
                infos[k] = {**infos[k], "terminal_observation": observations[k].copy(), "TimeLimit.truncated": True}
            dones[cut] = True
            observations[cut] = self.core.reset(cut)
        return observations, rewards, dones, infos
