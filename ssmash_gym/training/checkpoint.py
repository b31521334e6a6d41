"""Checkpoints: everything that a run needs to go on as if it had never stopped.

A checkpoint is an agent's folder (see `ssmash_gym.training.agent`) with the state of the run beside it: counters, the
random generators of exploration and of shuffling, the running return of the normaliser, and the environment itself.
It is taken between two updates, so a resumed run is bit for bit the run that was not interrupted.
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
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.normaliser import Normaliser

STATE: Final = "state.json"
ENVIRONMENT: Final = "environment.pickle"
GENERATORS: Final = "generators.npz"


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
    staggered = wrapper.venv
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
            last_starts=model._last_episode_starts,
            returns=wrapper.returns,
        )
        state = {
            "steps": model.num_timesteps,
            "updates": model._n_updates,
            "environment_steps": staggered.steps,
            "logged": {key: float(value) for key, value in model.logger.name_to_value.items()},
            "numpy": [str(kind), int(place), int(has_gauss), float(gauss)],
        }
        (temporary / STATE).write_text(json.dumps(state, indent=1) + "\n", encoding="utf-8")
        (temporary / ENVIRONMENT).write_bytes(pickle.dumps(staggered.core.snapshot()))


def load_checkpoint(folder: Path, model: Any) -> dict[str, float]:
    """Put a checkpoint into a fresh model of the same configuration.

    The environment's state is a pickle: only load checkpoints that you or someone you trust has written.

    Returns:
        What the last update before it had logged; the next line of the curve tells it.

    Raises:
        ConfigurationError: The folder holds no complete checkpoint.
    """
    import torch

    for name in (STATE, ENVIRONMENT, GENERATORS, "policy.zip"):
        if not (folder / name).is_file():
            raise ConfigurationError(f"{folder}: this is no complete checkpoint, {name} is missing.")
    wrapper = model.env
    staggered = wrapper.venv
    model.set_parameters(folder / "policy.zip", exact_match=True, device="cpu")
    staggered.core.restore(pickle.loads((folder / ENVIRONMENT).read_bytes()))
    state = json.loads((folder / STATE).read_text(encoding="utf-8"))
    model.num_timesteps, model._n_updates = state["steps"], state["updates"]
    staggered.steps = state["environment_steps"]
    with np.load(folder / GENERATORS) as arrays:
        wrapper.returns = arrays["returns"].copy()
        model._last_obs = arrays["last_observation"].copy()
        model._last_episode_starts = arrays["last_starts"].copy()
        torch.set_rng_state(torch.from_numpy(arrays["torch"].copy()))
        kind, place, has_gauss, gauss = state["numpy"]
        np.random.set_state((kind, arrays["numpy_keys"].copy(), place, has_gauss, gauss))
    Normaliser.read(folder / "normaliser.json").into(wrapper)
    return dict(state["logged"])


def checkpoints(run: Path) -> list[Path]:
    """The checkpoints of a run, oldest first."""
    return sorted(path for path in (run / "checkpoints").glob("step_*") if (path / STATE).is_file())


def prune(run: Path, keep: int) -> None:
    """Delete all but the newest checkpoints of a run."""
    for path in checkpoints(run)[:-keep]:
        shutil.rmtree(path)
