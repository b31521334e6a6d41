"""The native vector environment: one compiled call advances all helicopters. All three autoreset modes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import Film
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.spaces import (
    BATCH_RENDER_MODES,
    action_space,
    checked_options,
    checked_render_mode,
    metadata,
    observation_space,
)
from ssmash_gym.envs.step import BatchSnapshot, StepResult
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.envs.traverse import reset_info
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

Array = NDArray[Any]
Flags = NDArray[np.bool_]


class TraverseVectorEnv(VectorEnv[Array, Array, Array]):
    """N helicopters as one `gymnasium.vector.VectorEnv`; episode for episode the single environment.

    Infos have the layout of Gymnasium's own vector environments: an array and a mask ``_key`` for each key.

    Args:
        num_envs: How many.
        autoreset_mode: ``NextStep`` (default), ``SameStep`` or ``Disabled``.
        max_episode_steps: Truncates earlier than the task's horizon; `gymnasium.make_vec` may pass it.
        render_mode: ``rgb_array`` gives one picture each.
        task, scenario, helicopter, observation, threads, dump_dir: As in `TraverseBatch`.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        *,
        task: str | Path | Mapping[str, Any] | TaskConfig = "traverse",
        scenario: str | Path | Mapping[str, Any] | ScenarioConfig = "training",
        helicopter: str | Path | Mapping[str, Any] | Helicopter = "generic_tricycle",
        observation: str | Sequence[str] | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        threads: int | None = None,
        dump_dir: str | Path | None = None,
    ) -> None:
        core = TraverseBatch(
            num_envs, task=task, scenario=scenario, helicopter=helicopter, observation=observation, threads=threads,
            dump_dir=dump_dir, max_episode_steps=max_episode_steps,
        )  # fmt: skip
        self._build(core, autoreset_mode, render_mode)

    @classmethod
    def around(cls, core: TraverseBatch, autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP) -> Self:
        """The vector environment of a batch that exists already, as it stands."""
        made = cls.__new__(cls)
        made._build(core, autoreset_mode, None)
        return made

    def _build(self, core: TraverseBatch, autoreset_mode: str | AutoresetMode, render_mode: str | None) -> None:
        self.core = core
        self.num_envs = core.n
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.render_mode = checked_render_mode(render_mode, BATCH_RENDER_MODES)
        self.metadata = metadata(core, BATCH_RENDER_MODES, autoreset_mode=self.autoreset_mode)
        self.single_action_space = action_space()
        self.single_observation_space = observation_space(core)
        self.action_space = batch_space(self.single_action_space, core.n)
        self.observation_space = batch_space(self.single_observation_space, core.n)
        shown = range(core.n) if self.render_mode == "rgb_array" else ()
        self._films = [Film(self.core, k, "rgb_array") for k in shown]
        self._waiting: Flags = core.book.over & (core.book.steps > 0)  # NEXT_STEP: resets at the next step
        self._last: Array = core.last.copy()

    @property
    def control_interval_s(self) -> float:
        """Time between two commands [s]."""
        return self.core.control_interval_s

    @property
    def telemetry(self) -> Telemetry:
        """The true channels of all helicopters, by name, shape (num_envs,), SI."""
        return self.core.telemetry

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator | None, ...]:  # type: ignore[override]
        """The generators, one a helicopter; None before its first reset."""
        return tuple(self.core.generators)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start episodes.

        Args:
            seed: An integer (environment i gets ``seed + i``) or a list, one each; None lets the generators continue.
            options: ``reset_mask``: bool array (num_envs,), only those are reset; ``draws``: list of records, one each.

        Raises:
            ValueError, TypeError: A seed list of the wrong length, a mask that is no bool array, an unknown option.
            ConfigurationError: A draw is refused; one sentence.
        """
        chosen = checked_options(options, "reset_mask", "draws")
        columns = np.arange(self.num_envs)
        if "reset_mask" in chosen:
            columns = np.flatnonzero(self._mask(chosen["reset_mask"]))
        seeds = self._seeds(seed)
        draws = chosen.get("draws")
        if draws is not None and (not isinstance(draws, list | tuple) or len(draws) != self.num_envs):
            raise ConfigurationError(
                f"draws: {shown(draws)} is refused: must be a list of {self.num_envs}, one a helicopter."
            )
        observation = self._last.copy()
        observation[columns] = self.core.reset(
            columns, [seeds[k] for k in columns], None if draws is None else [draws[k] for k in columns]
        )
        self._waiting[columns] = False
        self._last = observation
        self._cut(columns)
        return observation.copy(), self._reset_infos({}, columns)

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int | np.integer):
            return [int(seed) + k for k in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"seed: a list of {len(seed)}, must have one entry for each of {self.num_envs}")
        return list(seed)

    def _mask(self, given: Any) -> Flags:
        if not isinstance(given, np.ndarray) or given.dtype != np.bool_:
            raise TypeError(f"reset_mask: {type(given).__name__}, must be a NumPy array of bool")
        if given.shape != (self.num_envs,) or not given.any():
            raise ValueError(f"reset_mask: must have shape ({self.num_envs},) and at least one True")
        return given

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """One control interval for all; what happens at an episode's end depends on the autoreset mode.

        Raises:
            ValueError: A command is not finite, or the shape is wrong.
            RuntimeError: Autoreset is disabled and an episode is over.
        """
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs, 2):
            raise ValueError(f"actions: shape {actions.shape}, must be ({self.num_envs}, 2)")
        resting = np.flatnonzero(self._waiting) if self.autoreset_mode == AutoresetMode.NEXT_STEP else np.array([], int)
        columns = np.flatnonzero(~self._waiting) if resting.size else np.arange(self.num_envs)
        observation = np.zeros_like(self._last)
        reward = np.zeros(self.num_envs)
        terminated, truncated = np.zeros(self.num_envs, np.bool_), np.zeros(self.num_envs, np.bool_)
        infos: dict[str, Any] = {}
        if columns.size:
            result = self.core.step(actions[columns], columns)
            observation[columns], reward[columns] = result.observation, result.reward
            terminated[columns], truncated[columns] = result.terminated, result.truncated
            for film in self._films:
                film.note(result)
            if self.autoreset_mode == AutoresetMode.SAME_STEP and result.endings:
                infos = self._same_step(result, observation)
            else:
                infos = self._step_infos(result, result.columns)
        if resting.size:
            observation[resting] = self.core.reset(resting)
            self._cut(resting)
            infos = self._reset_infos(infos, resting)
        self._waiting = (terminated | truncated) & (self.autoreset_mode == AutoresetMode.NEXT_STEP)
        self._last = observation
        return observation.copy(), reward, terminated, truncated, infos

    def _same_step(self, result: StepResult, observation: Array) -> dict[str, Any]:
        """SAME_STEP: the ended episodes' last words go to ``final_obs`` and ``final_info``, then they are reset."""
        ended = np.array(list(result.endings), dtype=np.int64)
        running = np.array([k for k in result.columns if int(k) not in result.endings], dtype=np.int64)
        infos = self._step_infos(result, running) if running.size else {}
        for k in ended:
            final = {"final_obs": observation[k].copy(), "final_info": result.info(int(k))}
            infos = self._add_info(infos, final, int(k))
        observation[ended] = self.core.reset(ended)
        self._cut(ended)
        return self._reset_infos(infos, ended)

    # --- infos -------------------------------------------------------------------------------------------------

    def _step_infos(self, result: StepResult, columns: NDArray[np.int64]) -> dict[str, Any]:
        """Infos of a step for some of its columns: arrays and masks."""
        mask = np.zeros(self.num_envs, np.bool_)
        mask[columns] = True
        rows = np.flatnonzero(mask[result.columns])

        def spread(values: Array) -> Array:
            out = np.zeros(self.num_envs, values.dtype)
            out[columns] = values[rows]
            return out

        def table(named: Mapping[str, Array]) -> dict[str, Any]:
            out: dict[str, Any] = {}
            for name, values in named.items():
                out[name], out[f"_{name}"] = spread(values), mask.copy()
            return out

        infos = table({"time_s": result.time_s, "cost": result.cost})
        for name in ("costs", "margins", "reward_terms"):
            infos[name], infos[f"_{name}"] = table(getattr(result, name)), mask.copy()
        infos |= table({"action_saturation": result.saturation, "observation_clipped": result.clipped})
        for k, ending in result.endings.items():
            if mask[k]:
                infos = self._add_info(infos, ending, k)
        return infos

    def _reset_infos(self, infos: dict[str, Any], columns: NDArray[np.int64]) -> dict[str, Any]:
        for k in columns:
            infos = self._add_info(infos, reset_info(self.core, int(k)), int(k))
        return infos

    # --- pictures and copies -----------------------------------------------------------------------------------

    def render(self) -> tuple[NDArray[np.uint8] | None, ...] | None:  # type: ignore[override]
        """One picture (height, width, 3) each in mode ``rgb_array``; None without a mode."""
        if self.render_mode is None:
            return None
        return tuple(film.picture() for film in self._films)

    def _cut(self, columns: NDArray[np.int64]) -> None:
        for k in columns:
            if self._films:
                self._films[int(k)].cut()

    def close_extras(self, **kwargs: Any) -> None:
        """Let the renderers go."""
        for film in self._films:
            film.close()

    def snapshot(self) -> tuple[BatchSnapshot, Flags, Array]:
        """Copy of the complete state."""
        return self.core.snapshot(), self._waiting.copy(), self._last.copy()

    def restore(self, snapshot: tuple[BatchSnapshot, Flags, Array]) -> None:
        """Return to a snapshot, bit for bit."""
        core, waiting, last = snapshot
        self.core.restore(core)
        self._waiting, self._last = waiting.copy(), last.copy()

    def fork(self, k: int) -> TraverseVectorEnv:
        """`k` copies of each environment as they stand, as one vector environment that does not reset by itself."""
        return TraverseVectorEnv.around(self.core.fork(k), AutoresetMode.DISABLED)
