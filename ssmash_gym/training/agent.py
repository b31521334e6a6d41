"""A trained agent as a folder that stands on its own: `save_agent` writes it, `load_agent` reads it.

```
agent.json        what it is: name, versions, network, every input with its scale, how it was trained
policy.npz        weights of the policy, plain numbers: enough to act
policy.zip        the same for Stable-Baselines3, with value networks and optimisers: to train on
normaliser.json   moments of observations and rewards, plain numbers (an agent is refused without it)
task.yaml scenario.yaml training.yaml   resolved configurations
README.md         model card
```

A shipped agent holds more: see `ssmash_gym.training.ship`.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from ssmash_gym.document import write_yaml
from ssmash_gym.envs.observations import chosen_terms, observed_terms
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import OF_AN_AGENT, TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training.card import brief_card
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.network import ACTIVATIONS, Network, policy_network
from ssmash_gym.training.normaliser import Normaliser

FORMAT: Final = 2
READABLE: Final = (1, 2)  # 1: networks without `squash`
# Of the run, not of the model; the schedule is a class of this package, which the file must not depend on.
NOT_KEPT: Final = ("ep_info_buffer", "ep_success_buffer", "_last_obs", "learning_rate", "lr_schedule")
ABOUT: Final = "agent.json"
NORMALISER: Final = "normaliser.json"
WEIGHTS: Final = "policy.npz"


@dataclass(frozen=True)
class Agent:
    """A trained policy, deterministic, with its frozen normaliser.

    Attributes:
        name: Of the agent.
        network: Mean of the policy.
        normaliser: What it does to observations.
        task, scenario, training: Resolved configurations that it was trained with.
        about: Contents of ``agent.json``.
    """

    name: str
    network: Network
    normaliser: Normaliser
    task: TaskConfig
    scenario: ScenarioConfig
    training: TrainingConfig
    about: Mapping[str, Any]

    def reset(self, count: int) -> None:
        """Start `count` episodes; the agent remembers nothing."""

    def act(self, observations: NDArray[np.float32], starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for observations (n, k) as the agent's task scales them, (n, 2) within -1 to 1."""
        return np.clip(self.network(self.normaliser(observations)), -1.0, 1.0)

    def within(self, task: TaskConfig) -> Agent:
        """The same agent in another task, e.g. with other limits; its own history and residual action go with it.

        Raises:
            ConfigurationError: The task is observed otherwise, or commanded at another interval.
        """
        other = task.model_copy(update={key: getattr(self.task, key) for key in OF_AN_AGENT})
        if list(chosen_terms(task.observation)) != list(chosen_terms(self.task.observation)):
            raise ConfigurationError(f"{self.name}: the task's observation terms are not those it was trained with.")
        for key in ("control_interval_s", "observation_clip"):
            if getattr(task, key) != getattr(self.task, key):
                raise ConfigurationError(
                    f"{self.name}: {key} = {getattr(task, key):g} is refused: it was trained with "
                    f"{getattr(self.task, key):g}."
                )
        return replace(self, task=other)


def save_agent(
    folder: Path,
    model: Any,
    wrapper: Any,
    training: TrainingConfig,
    task: TaskConfig,
    scenario: ScenarioConfig,
    about: Mapping[str, Any],
) -> None:
    """Write an agent's folder, whole or not at all; an older folder of that name is replaced.

    Args:
        folder: Where.
        model: The Stable-Baselines3 model.
        wrapper: Its `VecNormalize`.
        training: Resolved configuration of the training.
        task: The same of the task.
        scenario: The same of the scenario.
        about: Further entries for ``agent.json`` (steps, seeds, versions).
    """

    def also(temporary: Path) -> None:
        model.save(temporary / "policy.zip", exclude=list(NOT_KEPT))

    write_agent(folder, policy_network(model.policy), Normaliser.of(wrapper), training, task, scenario, about, also)


def write_agent(
    folder: Path,
    network: Network,
    normaliser: Normaliser,
    training: TrainingConfig,
    task: TaskConfig,
    scenario: ScenarioConfig,
    about: Mapping[str, Any],
    also: Callable[[Path], None] = lambda temporary: None,
) -> None:
    """Write an agent's folder from plain numbers, whole or not at all; an older folder of that name is replaced.

    Args:
        folder: Where.
        network: Mean of the policy.
        normaliser: What it does to observations.
        training: Resolved configuration of the training.
        task: The same of the task.
        scenario: The same of the scenario.
        about: Further entries for ``agent.json`` (steps, seeds, versions).
        also: Writes further files into the folder it is given.
    """
    record = {
        "format": FORMAT,
        "name": training.name,
        "layers": network.sizes,
        "activation": network.activation,
        "squash": network.squash,
        "observation": inputs(task),
        "observation_clip": task.observation_clip,
        "action": ["along", "across"],
        "control_interval_s": task.control_interval_s,
        "configuration": fingerprint(training, task, scenario),
        **about,
    }
    with whole_folder(folder) as temporary:
        np.savez(temporary / WEIGHTS, **network.arrays())  # type: ignore[arg-type]
        also(temporary)
        normaliser.write(temporary / NORMALISER)
        for name, section in (("training", training), ("task", task), ("scenario", scenario)):
            write_text(temporary / f"{name}.yaml", write_yaml(section.model_dump(mode="json")))
        write_text(temporary / "README.md", brief_card(record, training))
        write_text(temporary / ABOUT, json.dumps(record, indent=1) + "\n")


def load_agent(folder: str | Path) -> Agent:
    """Read an agent's folder; the policy is deterministic and its normaliser frozen.

    Raises:
        ConfigurationError: The folder holds no agent, lacks its normaliser, or was written for other observations.
    """
    root = Path(folder)
    if not (root / ABOUT).is_file():
        raise ConfigurationError(f"{root}: there is no agent in this folder ({ABOUT} is missing).")
    normaliser = Normaliser.read(root / NORMALISER)
    about = json.loads((root / ABOUT).read_text(encoding="utf-8"))
    given = about.get("format")
    if given not in READABLE or about.get("activation") not in ACTIVATIONS:
        newer = isinstance(given, int) and given > FORMAT
        remedy = "; a newer ssmash_gym has written it: update" if newer else ""
        raise ConfigurationError(f"{root / ABOUT}: format {given!r} is unknown; this version reads {FORMAT}{remedy}.")
    task = load_task(root / "task.yaml")
    if [(entry["name"], entry["scale"]) for entry in about["observation"]] != [
        (term.name, term.scale) for term in observed_terms(task)
    ]:
        raise ConfigurationError(f"{root}: the agent was trained with other observation terms or scales than today's.")
    network = read_network(root / WEIGHTS, about)
    ends, wanted = (network.sizes[0], network.sizes[-1]), (len(about["observation"]), len(about["action"]))
    if ends != wanted:
        raise ConfigurationError(
            f"{root / WEIGHTS}: a network from {ends[0]} to {ends[1]} numbers does not fit {ABOUT}: {wanted[0]} to "
            f"{wanted[1]}."
        )
    return Agent(
        str(about["name"]), network, normaliser, task, load_scenario(root / "scenario.yaml"),
        load_training(root / "training.yaml"), about,
    )  # fmt: skip


def read_network(path: Path, about: Mapping[str, Any]) -> Network:
    """The network of an agent's folder.

    Raises:
        ConfigurationError: The file is missing, or holds something else.
    """
    try:
        with np.load(path) as arrays:
            return Network.of_arrays(arrays, about["activation"], bool(about.get("squash", False)))
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise ConfigurationError(f"{path}: the policy's numbers cannot be read ({error}).") from None


def inputs(task: TaskConfig) -> list[dict[str, Any]]:
    """What stands in each place of a task's observation, past readings included; ``agent.json`` holds it."""
    return [
        {"name": term.name, "meaning": term.meaning, "unit": term.unit, "scale": term.scale}
        for term in observed_terms(task)
    ]


def fingerprint(*sections: BaseModel) -> str:
    """Hash of resolved configurations: the same number, the same settings."""
    text = json.dumps([section.model_dump(mode="json") for section in sections], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


class whole_folder:
    """A temporary folder beside `folder`: it takes its place when the block ends well and is removed otherwise."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.temporary = folder.with_name(f".{folder.name}.new")

    def __enter__(self) -> Path:
        shutil.rmtree(self.temporary, ignore_errors=True)
        self.temporary.mkdir(parents=True)
        return self.temporary

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if kind is None:
            old = self.folder.with_name(f".{self.folder.name}.old")
            shutil.rmtree(old, ignore_errors=True)
            if self.folder.exists():
                self.folder.rename(old)
            self.temporary.rename(self.folder)
            shutil.rmtree(old, ignore_errors=True)
        shutil.rmtree(self.temporary, ignore_errors=True)
