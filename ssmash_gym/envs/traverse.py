"""`ssmash/Traverse-v0`: the single environment, which is the batch of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import ACTIONS, TraverseBatch
from ssmash_gym.envs.pictures import Film
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.spaces import action_space, checked_options, checked_render_mode, metadata, observation_space
from ssmash_gym.envs.step import BatchSnapshot
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

if TYPE_CHECKING:
    from ssmash_gym.envs.vector import TraverseVectorEnv

Observation = NDArray[np.float32]


class TraverseEnv(gymnasium.Env[Any, Any]):
    """Bring a helicopter, held by its probe, along the deck track of a moving ship into the hangar.

    ## Description
    A 12-degree-of-freedom helicopter stands on the flight deck of a ship in a seaway; the claw of the securing device
    holds its probe. The claw is to take it 8 m forward into the hangar position, straight, with every load low. Docs:
    ``docs/environments/traverse.md``.

    ## Action Space
    ``Box(-1, 1, (2,), float32)``: claw velocity along (x) and across (y, starboard positive) the track as a share of
    0.3 and 0.1 m/s. Values beyond are clipped, and their share is reported as ``info["action_saturation"]``.

    ## Observation Space
    ``Box(-5, 5, (n,), float32)``: telemetry in units of physical scales, see `observations.TERMS`; ``sensors`` (the
    default), ``full``, or names.

    ## Rewards
    Sum of ``info["reward_terms"]``: progress, alignment, load, peak, command_rate, time, success, failure.

    ## Starting State
    Settled on the moving deck after a lead-in, at a drawn yaw and lateral offset; ``info["draw"]`` tells all draws.

    ## Episode End
    Terminated with ``info["reason"]``: goal (held 2 s), ultimate_load, probe_lost, overturning, corridor,
    divergence. Truncated: time (60 s).

    ## Arguments
    `task`, `scenario`, `helicopter`: a name, a YAML file, or a mapping of changes (`TraverseBatch`); `observation`;
    `render_mode`; `threads`; `dump_dir`. ``reset(options={"draw": info["draw"]})`` repeats an episode's draw.

    ## Vectorized
    ``gymnasium.make_vec("ssmash_gym:ssmash/Traverse-v0", num_envs=64)`` is the native batch: `TraverseVectorEnv`.

    ## Version History
    * v0: first version.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        *,
        task: str | Path | Mapping[str, Any] | TaskConfig = "traverse",
        scenario: str | Path | Mapping[str, Any] | ScenarioConfig = "training",
        helicopter: str | Path | Mapping[str, Any] | Helicopter = "generic_tricycle",
        observation: str | Sequence[str] | None = None,
        render_mode: str | None = None,
        threads: int | None = None,
        dump_dir: str | Path | None = None,
    ) -> None:
        self.render_mode = checked_render_mode(render_mode)
        self.core = TraverseBatch(
            1, task=task, scenario=scenario, helicopter=helicopter, observation=observation, threads=threads,
            dump_dir=dump_dir,
        )  # fmt: skip
        self.metadata = metadata(self.core)
        self.action_space = action_space()
        self.observation_space = observation_space(self.core)
        self._film = None if self.render_mode is None else Film(self.core, 0, self.render_mode)

    @property
    def control_interval_s(self) -> float:
        """Time between two commands [s]."""
        return self.core.control_interval_s

    @property
    def telemetry(self) -> Telemetry:
        """The true channels by name, shape (1,), SI."""
        return self.core.telemetry

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seeds the generator; None lets it continue.
            options: ``{"draw": record}`` starts an episode as told by an earlier ``info["draw"]``.

        Raises:
            ValueError: An option is unknown.
        """
        chosen = checked_options(options, "draw")
        super().reset(seed=seed)
        self.core.generators[0] = self.np_random
        draw = chosen.get("draw")
        observation = self.core.reset(draws=None if draw is None else [draw])[0]
        if self._film is not None:
            self._film.cut()
        self._show()
        return observation, reset_info(self.core, 0)

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One control interval under a normalised claw command, shape (2,).

        Raises:
            ValueError: The command is not finite or has the wrong shape.
            RuntimeError: The episode is over.
        """
        command = np.asarray(action)
        if command.shape != (ACTIONS,):
            raise ValueError(f"action: shape {command.shape}, must be ({ACTIONS},)")
        result = self.core.step(command[None])
        if self._film is not None:
            self._film.note(result)
        self._show()
        terminated, truncated = bool(result.terminated[0]), bool(result.truncated[0])
        return result.observation[0], float(result.reward[0]), terminated, truncated, result.info(0)

    def render(self) -> NDArray[np.uint8] | None:
        """The picture (height, width, 3) in mode ``rgb_array``; None otherwise, the window is already up to date."""
        if self.render_mode is None:
            gymnasium.logger.warn('render() without a mode: give render_mode="rgb_array" or "human" to make().')
            return None
        return None if self._film is None or self.render_mode != "rgb_array" else self._film.picture()

    def _show(self) -> None:
        if self._film is not None and self.render_mode == "human":
            self._film.picture()

    def close(self) -> None:
        """Close the window, if there is one; may be called again."""
        if self._film is not None:
            self._film.close()

    def snapshot(self) -> BatchSnapshot:
        """Copy of the complete state: physics, counters, sensors, generator."""
        return self.core.snapshot()

    def restore(self, snapshot: BatchSnapshot) -> None:
        """Return to a snapshot, bit for bit."""
        self.core.restore(snapshot)
        generator = self.core.generators[0]
        if generator is not None:
            self.np_random = generator

    def fork(self, k: int) -> TraverseVectorEnv:
        """`k` copies of this environment as they stand, as a vector environment that does not reset by itself."""
        from ssmash_gym.envs.vector import TraverseVectorEnv

        return TraverseVectorEnv.around(self.core.fork(k), "Disabled")


def reset_info(core: TraverseBatch, k: int) -> dict[str, Any]:
    """The info of a reset: what was drawn."""
    draw = core.draws[k]
    return {"time_s": 0.0, "draw": {} if draw is None else draw.to_dict()}
