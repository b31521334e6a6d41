"""The native batch as a Stable-Baselines3 `VecEnv` (extra ``train``), without sub-environments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import Film
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.spaces import BATCH_RENDER_MODES, action_space, checked_render_mode, metadata, observation_space
from ssmash_gym.envs.step import BatchSnapshot
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.envs.traverse import reset_info
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise ImportError('TraverseVecEnv needs Stable-Baselines3: pip install "ssmash_gym[train]".') from error

Array = NDArray[Any]


class TraverseVecEnv(VecEnv):
    """N helicopters as one SB3 `VecEnv`; episode for episode the single environment.

    Each step's infos hold ``cost`` alone; at an episode's end they hold everything the single environment tells, and
    ``terminal_observation`` and ``TimeLimit.truncated``. After a reset `reset_infos` holds the draws.

    Args:
        num_envs: How many.
        max_episode_steps: Truncates earlier than the task's horizon.
        render_mode: None or ``rgb_array``.
        task, scenario, helicopter, observation, threads, dump_dir: As in `TraverseBatch`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        *,
        task: str | Path | Mapping[str, Any] | TaskConfig = "traverse",
        scenario: str | Path | Mapping[str, Any] | ScenarioConfig = "training",
        helicopter: str | Path | Mapping[str, Any] | Helicopter = "generic_tricycle",
        observation: str | Sequence[str] | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        threads: int | None = None,
        dump_dir: str | Path | None = None,
    ) -> None:
        self.core = TraverseBatch(
            num_envs, task=task, scenario=scenario, helicopter=helicopter, observation=observation, threads=threads,
            dump_dir=dump_dir, max_episode_steps=max_episode_steps,
        )  # fmt: skip
        self.render_mode = checked_render_mode(render_mode, BATCH_RENDER_MODES)
        shown = range(num_envs) if self.render_mode == "rgb_array" else ()
        self._films = [Film(self.core, k, "rgb_array") for k in shown]
        self._actions: Array = np.zeros((num_envs, 2))
        self.last_costs: dict[str, Array] = {}  # of the last interval, by name of the limit, (num_envs,) each
        super().__init__(num_envs, observation_space(self.core), action_space())
        self.metadata = metadata(self.core, BATCH_RENDER_MODES)

    @property
    def control_interval_s(self) -> float:
        """Time between two commands [s]."""
        return self.core.control_interval_s

    @property
    def telemetry(self) -> Telemetry:
        """The true channels of all helicopters, by name, shape (num_envs,), SI."""
        return self.core.telemetry

    @property
    def unwrapped(self) -> TraverseVecEnv:
        """This environment."""
        return self

    def reset(self) -> NDArray[np.float32]:
        """Start all episodes; uses the seeds given by `seed` and the options given by `set_options` (``draw``) once."""
        draws = [options.get("draw") for options in self._options] if any(self._options) else None
        observation = self.core.reset(seeds=self._seeds, draws=draws)
        self.reset_infos = [reset_info(self.core, k) for k in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        for film in self._films:
            film.cut()
        return observation

    def step_async(self, actions: Array) -> None:
        """Take the commands (num_envs, 2)."""
        self._actions = np.array(actions)

    def step_wait(self) -> tuple[NDArray[np.float32], NDArray[np.float32], Array, list[dict[str, Any]]]:
        """One control interval for all; ended episodes start anew at once."""
        result = self.core.step(self._actions)
        self.last_costs = result.costs
        for film in self._films:
            film.note(result)
        infos: list[dict[str, Any]] = [{"cost": cost} for cost in result.cost.tolist()]
        observation = result.observation
        if result.endings:
            ended = np.array(list(result.endings), dtype=np.int64)
            for k in ended:
                last = {"terminal_observation": observation[k].copy(), "TimeLimit.truncated": bool(result.truncated[k])}
                infos[k] = {**result.info(int(k)), **last}
            observation[ended] = self.core.reset(ended)
            for k in ended:
                self.reset_infos[k] = reset_info(self.core, int(k))
                if self._films:
                    self._films[k].cut()
        return observation, result.reward.astype(np.float32), result.terminated | result.truncated, infos

    def close(self) -> None:
        """Let the renderers go."""
        for film in self._films:
            film.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """One picture each in mode ``rgb_array``."""
        if self.render_mode != "rgb_array":
            return [None] * self.num_envs
        return [film.picture() for film in self._films]

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """The attribute, once for each index: there are no sub-environments."""
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set the attribute; there are no sub-environments."""
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Call a method once and give its result for each index: there are no sub-environments."""
        result = getattr(self, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: Any = None) -> list[bool]:
        """Never: there are no sub-environments that could be wrapped."""
        return [False for _ in self._get_indices(indices)]

    def snapshot(self) -> BatchSnapshot:
        """Copy of the complete state."""
        return self.core.snapshot()

    def restore(self, snapshot: BatchSnapshot) -> None:
        """Return to a snapshot, bit for bit."""
        self.core.restore(snapshot)
