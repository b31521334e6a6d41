"""What a training run is made of: one YAML file, checked before anything is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import yaml
from pydantic import Field, model_validator

from ssmash_gym.envs.loading import BASE_KEY, merged, read
from ssmash_gym.envs.scenario import ScenarioConfig, changed_scenario
from ssmash_gym.envs.task import Reward
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.sections import validated
from ssmash_gym.training.sections import (
    Checkpoints,
    Cost,
    Count,
    Environment,
    Evolution,
    LimitName,
    Network,
    Normalise,
    Ppo,
    Sac,
    Section,
    Stage,
    Tqc,
)

NEAR_ONE: Final = 0.99  # beyond it the tanh of SAC and TQC is so flat that their first policy would hardly learn


class TrainingConfig(Section):
    """A training run; `load_training` makes it from ``configs/training/*.yaml``."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="of the run and the agent")
    description: str = ""
    seed: Annotated[int, Field(ge=0)] = 0
    total_steps: Count = Field(description="control intervals of all helicopters together")
    algorithm: Literal["ppo", "sac", "tqc", "cloning"] = Field(
        "ppo", description="which section of that name holds; cloning: supervised learning, by `ssmash clone`"
    )
    device: Literal["auto", "cpu", "cuda"] = Field(
        "cpu", description="of the networks: small ones are quickest on the processor; auto takes a GPU that is there"
    )
    torch_threads: Count = Field(1, description="threads of the networks: small ones are quickest on one")
    environment: Environment = Environment()
    stages: tuple[Stage, ...] = Field((), description="changes of reward and scenario along the way, in order")
    costs: dict[LimitName, Cost] = Field({}, description="what exceeding a limit costs, by the limit's name")
    network: Network = Network()
    ppo: Ppo = Ppo()
    sac: Sac = Sac()
    tqc: Tqc = Tqc()
    evolution: Evolution | None = Field(None, description="what follows the gradient; nothing by default")
    normalise: Normalise = Normalise()
    checkpoints: Checkpoints = Checkpoints()

    @property
    def learner(self) -> Ppo | Sac:
        """The section of the chosen algorithm."""
        off_policy = self.tqc if self.algorithm == "tqc" else self.sac
        return self.ppo if self.algorithm in ("ppo", "cloning") else off_policy

    @property
    def steps_per_update(self) -> int:
        """Control intervals of all helicopters between two updates (SAC, TQC: between two lines of the curve)."""
        return self.environment.count * self.learner.steps_per_update

    def stage_at(self, steps: int) -> int:
        """How many stages have begun after so many control intervals of all helicopters together."""
        return sum(stage.from_step <= steps for stage in self.stages)

    def reward_at(self, steps: int, reward: Reward) -> Reward:
        """The reward's weights after so many steps.

        Args:
            steps: Control intervals of all helicopters together.
            reward: The task's.

        Raises:
            ConfigurationError: A stage names an unknown key, or a value that is not allowed.
        """
        changes = {key: value for stage in self.stages[: self.stage_at(steps)] for key, value in stage.reward.items()}
        return validated(Reward, reward.model_dump() | changes, "training: stages") if changes else reward

    def scenario_at(self, steps: int, scenario: ScenarioConfig) -> ScenarioConfig:
        """What episodes are drawn from after so many steps.

        Args:
            steps: Control intervals of all helicopters together.
            scenario: The first one.

        Raises:
            ConfigurationError: A stage names an unknown key, or a value that is not allowed.
        """
        for stage in self.stages[: self.stage_at(steps)]:
            if stage.scenario:
                scenario = changed_scenario(scenario, undotted(stage.scenario))
        return scenario

    @model_validator(mode="after")
    def _stages_in_order(self) -> Self:
        starts = [stage.from_step for stage in self.stages]
        if any(later <= earlier for earlier, later in pairwise(starts)):
            raise ValueError(f"stages: from_step = {starts}: must rise")
        return self

    @model_validator(mode="after")
    def _whole_batches(self) -> Self:
        if self.algorithm == "ppo" and self.steps_per_update % self.ppo.batch_size:
            raise ValueError(
                f"ppo.batch_size = {self.ppo.batch_size}: must divide environment.count * ppo.steps_per_update = "
                f"{self.steps_per_update}"
            )
        return self

    @model_validator(mode="after")
    def _before_the_tanh(self) -> Self:
        begin = self.network.initial_action
        if isinstance(self.learner, Sac) and any(abs(value) > NEAR_ONE for value in begin):
            raise ValueError(
                f"network.initial_action = {list(begin)}: must be within -{NEAR_ONE:g} to {NEAR_ONE:g} with algorithm "
                f"{self.algorithm}, whose commands are a tanh that never reaches 1"
            )
        return self

    @model_validator(mode="after")
    def _whole_trainings(self) -> Self:
        section = self.learner
        if isinstance(section, Sac) and section.steps_per_update % section.train_every:
            raise ValueError(
                f"{self.algorithm}.train_every = {section.train_every}: must divide steps_per_update = "
                f"{section.steps_per_update}"
            )
        return self


def load_training(config: str | Path | Mapping[str, Any], changes: Sequence[str] = ()) -> TrainingConfig:
    """Load a training configuration.

    Args:
        config: A name in ``configs/training``, the path of a YAML file, or a ready document.
        changes: ``key=value`` with a dotted key and a YAML value, e.g. ``ppo.epochs=4``.

    Raises:
        ConfigurationError: Unknown file or key, or a value that is not allowed; one sentence.
    """
    if isinstance(config, Mapping):
        document, source = dict(config), "training"
    else:
        document, source = read("training", config)
    document = upon_base(document, source)
    for change in changes:
        document = merged(with_bases(document), parsed_change(change))
    return validated(TrainingConfig, document, source)


def upon_base(document: Mapping[str, Any], source: str) -> dict[str, Any]:
    """The document laid over the training that its key ``base`` names, if it has that key.

    Raises:
        ConfigurationError: There is no such training, or it has a base itself.
    """
    changes = dict(document)
    name = changes.pop(BASE_KEY, None)
    if name is None:
        return changes
    base, called = read("training", str(name))
    if BASE_KEY in base:
        raise ConfigurationError(f"{source}: base = {name} is refused: {called} has a base itself.")
    return merged(with_bases(base), changes)


def with_bases(document: Mapping[str, Any]) -> dict[str, Any]:
    """The document with a named task or scenario written as a mapping, so that a change to it keeps its name."""
    found = dict(document)
    for section, keys in (("environment", ("task", "scenario")), ("evolution", ("scenario",))):
        values = document.get(section)
        if isinstance(values, Mapping):
            named = {key: {BASE_KEY: values[key]} for key in keys if isinstance(values.get(key), str)}
            found[section] = {**values, **named}
    return found


def undotted(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes by dotted keys as a nested mapping: ``{"a.b": 1, "a.c": 2}`` becomes ``{"a": {"b": 1, "c": 2}}``."""
    document: dict[str, Any] = {}
    for key, value in changes.items():
        for part in reversed(str(key).split(".")):
            value = {part: value}
        document = merged(document, value)
    return document


def parsed_change(change: str) -> dict[str, Any]:
    """Make a nested mapping of ``a.b=value``.

    Raises:
        ConfigurationError: There is no ``=``, no key, or the value is no YAML.
    """
    key, sign, text = change.partition("=")
    parts = key.strip().split(".")
    if not sign or not all(parts):
        raise ConfigurationError(f"--set {change!r} is refused: write key=value, with dots between nested keys.")
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        raise ConfigurationError(f"--set {change!r} is refused: {text!r} is no YAML value.") from None
    if isinstance(value, str):
        value = as_number(value)
    for part in reversed(parts):
        value = {part: value}
    return dict(value)


def as_number(text: str) -> float | str:
    """YAML reads ``3e-4`` as a text; a person means a number."""
    try:
        return float(text)
    except ValueError:
        return text
