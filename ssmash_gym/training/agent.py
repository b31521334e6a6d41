"""A trained agent as a folder that stands on its own: `save_agent` writes it, `load_agent` reads it.

```
agent.json        what it is: name, version, shape of the network, observation terms, how it was trained
policy.npz        weights of the policy, plain numbers: enough to act
policy.zip        the same for Stable-Baselines3, with the value network and the optimiser: to train on
normaliser.json   moments of observations and rewards (an agent is refused without it)
task.yaml scenario.yaml training.yaml   resolved configurations
README.md         model card
```
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from ssmash_gym.document import write_yaml
from ssmash_gym.envs.observations import chosen_terms
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.network import ACTIVATIONS, Network, policy_network
from ssmash_gym.training.normaliser import Normaliser

FORMAT: Final = 1
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
        """The same agent in another task, e.g. with other limits.

        Raises:
            ConfigurationError: The task is observed by other terms, or commanded at another interval.
        """
        if [t.name for t in chosen_terms(task.observation)] != [t.name for t in chosen_terms(self.task.observation)]:
            raise ConfigurationError(f"{self.name}: the task's observation terms are not those it was trained with.")
        if task.control_interval_s != self.task.control_interval_s:
            raise ConfigurationError(
                f"{self.name}: control_interval_s = {task.control_interval_s:g} is refused: it was trained with "
                f"{self.task.control_interval_s:g} s."
            )
        return replace(self, task=task)


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
    terms = [{"name": t.name, "unit": t.unit, "scale": t.scale} for t in chosen_terms(task.observation)]
    record = {
        "format": FORMAT,
        "name": training.name,
        "activation": training.network.activation,
        "observation": terms,
        "action": ["along", "across"],
        "control_interval_s": task.control_interval_s,
        "configuration": fingerprint(training, task, scenario),
        **about,
    }
    with whole_folder(folder) as temporary:
        np.savez(temporary / WEIGHTS, **policy_network(model.policy, training.network.activation).arrays())  # type: ignore[arg-type]
        model.save(temporary / "policy.zip", exclude=["ep_info_buffer", "ep_success_buffer", "_last_obs"])
        Normaliser.of(wrapper).write(temporary / NORMALISER)
        for name, section in (("training", training), ("task", task), ("scenario", scenario)):
            write_text(temporary / f"{name}.yaml", write_yaml(section.model_dump(mode="json")))
        write_text(temporary / "README.md", model_card(record, training))
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
    if about.get("format") != FORMAT or about.get("activation") not in ACTIVATIONS:
        raise ConfigurationError(
            f"{root / ABOUT}: format {about.get('format')!r} is unknown; this version reads {FORMAT}."
        )
    task = load_task(root / "task.yaml")
    written = {entry["name"]: entry["scale"] for entry in about["observation"]}
    present = {term.name: term.scale for term in chosen_terms(task.observation)}
    if list(written.items()) != list(present.items()):
        raise ConfigurationError(f"{root}: the agent was trained with other observation terms or scales than today's.")
    with np.load(root / WEIGHTS) as arrays:
        network = Network.of_arrays(arrays, about["activation"])
    return Agent(
        str(about["name"]), network, normaliser, task, load_scenario(root / "scenario.yaml"),
        load_training(root / "training.yaml"), about,
    )  # fmt: skip


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


def model_card(record: Mapping[str, Any], training: TrainingConfig) -> str:
    """What a reader should know before using the agent, as Markdown."""
    lines = [
        f"# {record['name']}",
        "",
        training.description or "A policy for `ssmash/Traverse-v0`.",
        "",
        f"- Trained by proximal policy optimisation for {record.get('steps', 0):,} control intervals, seed "
        f"{training.seed}, with ssmash_gym {record.get('versions', {}).get('ssmash_gym', '?')}.",
        f"- Reads {len(record['observation'])} named observation terms (`agent.json`), acts every "
        f"{record['control_interval_s']:g} s on the claw's velocity, along and across the track.",
        f"- Policy: perceptron {' - '.join(map(str, training.network.layers))}, {training.network.activation}, "
        "deterministic when evaluated; the normaliser is frozen.",
        "- Trained in the seas, poses and disturbances of `scenario.yaml`; outside of them nothing is known.",
        "- A research model on assumed numbers. Not for use on a ship.",
        "",
        "Use it: `evaluate.py --agent FOLDER`, or `ssmash_gym.training.agent.load_agent(FOLDER).act(observations)`.",
        "",
    ]
    return "\n".join(lines)
