"""What the environments take in place of ready-made sections: names, files, mappings of changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.vehicle import Helicopter, helicopter_from, load_helicopter, with_changes


def observed(task: TaskConfig, observation: str | Sequence[str]) -> dict[str, Any]:
    """The task as a document with another observation."""
    chosen = observation if isinstance(observation, str) else list(observation)
    return {**task.model_dump(mode="json"), "observation": chosen}


def as_helicopter(given: str | Path | Mapping[str, Any] | Helicopter) -> Helicopter:
    """A helicopter from a name, a file, a description, or changes to a base.

    Raises:
        ConfigurationError: It is refused; one sentence.
    """
    if isinstance(given, Helicopter):
        return given
    if isinstance(given, Mapping):
        changes = dict(given)
        base = changes.pop("base", None)
        return helicopter_from(changes) if base is None else with_changes(load_helicopter(base), changes)
    return load_helicopter(given)
