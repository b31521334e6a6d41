"""Checkpoints: everything that a run needs to go on as if it had never stopped.

A checkpoint is an agent's folder (see `ssmash_gym.training.agent`) with the state of the run beside it: counters, the
random generators of exploration and of shuffling, the running return of the normaliser, the multipliers of the costs,
the environment itself, and the past transitions of SAC and TQC. It is taken between two updates, so a resumed run is
bit for bit the run that was not interrupted (on one processor thread; `algorithm_state` says what SAC and TQC add).
"""

from __future__ import annotations

import json
import pickle
import shutil
from pathlib import Path
from typing import Any, Final

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training.agent import save_agent, whole_folder
from ssmash_gym.training.algorithms import layer
from ssmash_gym.training.algorithms_state import (
    algorithm_state,
    restore_algorithm,
    restore_transitions,
    write_transitions,
)
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.normaliser import Normaliser

STATE: Final = "state.json"
ENVIRONMENT: Final = "environment.pickle"
GENERATORS: Final = "generators.npz"
COSTS: Final = "costs.npz"
TRANSITIONS: Final = "transitions.npz"


def save_checkpoint(folder: Path, model: Any, config: TrainingConfig, about: dict[str, Any]) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        folder: Where.
        model: The model between two updates, its environment a `VecNormalize` of the native batch.
        config: The run's configuration.
        about: Entries for ``agent.json``.
    """
    import torch

    wrapper = model.env
    staggered, priced = layers(wrapper)
    with whole_folder(folder) as temporary:
        save_agent(temporary / "agent", model, wrapper, config, staggered.core.task, staggered.core.scenario, about)
        for path in (temporary / "agent").iterdir():
            path.rename(temporary / path.name)
        (temporary / "agent").rmdir()
        kind, keys, place, has_gauss, gauss = np.random.get_state()
        np.savez(
            temporary / GENERATORS,
            torch=torch.get_rng_state().numpy(),
            numpy_keys=keys,
            last_observation=model._last_obs,
            last_original=model._last_obs if model._last_original_obs is None else model._last_original_obs,
            last_starts=model._last_episode_starts,
            returns=wrapper.returns,
        )
        state = {
            "steps": model.num_timesteps,
            "updates": model._n_updates,
            "environment_steps": staggered.steps,
            "logged": {key: float(value) for key, value in model.logger.name_to_value.items()},
            "numpy": [str(kind), int(place), int(has_gauss), float(gauss)],
            "algorithm": algorithm_state(model),
        }
        if priced is not None:
            np.savez(temporary / COSTS, **priced.state())
        if config.checkpoints.replay_buffer:
            write_transitions(temporary / TRANSITIONS, model)
        (temporary / STATE).write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")
        (temporary / ENVIRONMENT).write_bytes(pickle.dumps(staggered.core.snapshot()))


def load_checkpoint(folder: Path, model: Any, *, transitions: bool = True) -> dict[str, float]:
    """Put a checkpoint into a fresh model of the same configuration.

    The environment's state is a pickle: only load checkpoints that you or someone you trust has written.

    Args:
        folder: The checkpoint.
        model: A model on an environment of the same configuration.
        transitions: Whether SAC and TQC shall have their past transitions; without them they begin to collect anew.

    Returns:
        What the last update before it had logged; the next line of the curve tells it.

    Raises:
        ConfigurationError: The folder holds no complete checkpoint.
    """
    import torch

    wrapper = model.env
    staggered, priced = layers(wrapper)
    needed = [STATE, ENVIRONMENT, GENERATORS, "policy.zip", *([] if priced is None else [COSTS])]
    if transitions and hasattr(model, "replay_buffer"):
        needed.append(TRANSITIONS)
    for name in needed:
        if not (folder / name).is_file():
            raise ConfigurationError(f"{folder}: this is no complete checkpoint, {name} is missing.")
    model.set_parameters(folder / "policy.zip", exact_match=True, device=model.device)
    staggered.core.restore(pickle.loads((folder / ENVIRONMENT).read_bytes()))
    state = json.loads((folder / STATE).read_text(encoding="utf-8"))
    model.num_timesteps, model._n_updates = state["steps"], state["updates"]
    staggered.steps = state["environment_steps"]
    with np.load(folder / GENERATORS) as arrays:
        wrapper.returns = arrays["returns"].copy()
        model._last_obs = arrays["last_observation"].copy()
        model._last_original_obs = arrays["last_original"].copy()
        model._last_episode_starts = arrays["last_starts"].copy()
        torch.set_rng_state(torch.from_numpy(arrays["torch"].copy()))
        kind, place, has_gauss, gauss = state["numpy"]
        np.random.set_state((kind, arrays["numpy_keys"].copy(), place, has_gauss, gauss))
    restore_algorithm(model, state["algorithm"])
    if TRANSITIONS in needed:
        restore_transitions(folder / TRANSITIONS, model)
    if priced is not None:
        with np.load(folder / COSTS) as arrays:
            priced.restore(arrays)
    Normaliser.read(folder / "normaliser.json").into(wrapper)
    return dict(state["logged"])


def layers(wrapper: Any) -> tuple[Any, Any]:
    """The `Staggered` and, where there are costs, the `Priced` inside a `VecNormalize`."""
    from ssmash_gym.training.costs import Priced
    from ssmash_gym.training.stagger import Staggered

    return layer(wrapper, Staggered), layer(wrapper, Priced)


def checkpoints(run: Path) -> list[Path]:
    """The checkpoints of a run, oldest first."""
    return sorted(path for path in (run / "checkpoints").glob("step_*") if (path / STATE).is_file())


def prune(run: Path, keep: int) -> None:
    """Delete all but the newest checkpoints of a run."""
    for path in checkpoints(run)[:-keep]:
        shutil.rmtree(path)
