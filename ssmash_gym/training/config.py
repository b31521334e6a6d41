"""What a training run is made of: one YAML file, checked before anything is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ssmash_gym.envs.loading import BASE_KEY, merged, read
from ssmash_gym.envs.task import Reward
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.sections import validated

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0.0, le=1.0)]
Count = Annotated[int, Field(ge=1)]
Choice = str | dict[str, Any]  # a name in configs, the path of a YAML file, or changes to one


class Section(BaseModel):
    """Part of the configuration: frozen, and no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Environment(Section):
    """Where the agent learns."""

    task: Choice = Field("traverse", description="task: name, file, or changes to the default one")
    scenario: Choice = Field("default", description="scenario: name, file, or changes to the default one")
    count: Count = Field(64, description="helicopters that are simulated side by side")
    threads: Count = Field(2, description="threads of the simulation; the result does not depend on them")


class Stage(Section):
    """Weights of the reward from a step on: first to arrive at all, then to do it well."""

    from_step: Count = Field(description="control intervals of all helicopters together from which it holds")
    reward: dict[str, float] = Field(description="keys of the task's reward to change, with all stages before")


class Network(Section):
    """Policy and value networks: two separate perceptrons of the same shape."""

    layers: tuple[Count, ...] = Field((64, 64), description="units of the hidden layers")
    activation: Literal["tanh", "relu", "elu"] = Field("tanh", description="of the hidden layers")
    log_std: float = Field(-1.0, ge=-5.0, le=1.0, description="logarithm of the initial exploration, per action")
    initial_action: tuple[float, float] = Field(
        (0.0, 0.0), description="mean action before any learning (along, across): a claw that moves learns sooner"
    )

    @model_validator(mode="after")
    def _within_box(self) -> Self:
        if any(abs(value) > 1.0 for value in self.initial_action):
            raise ValueError(f"initial_action = {list(self.initial_action)}: must be within -1 to 1")
        return self


class Ppo(Section):
    """Proximal policy optimisation; the names are those of Stable-Baselines3, written out."""

    steps_per_update: Count = Field(128, description="control intervals of each helicopter between two updates")
    batch_size: Annotated[int, Field(ge=2)] = Field(2048, description="samples of a gradient step")
    epochs: Count = Field(5, description="passes over the samples of an update")
    learning_rate: Positive = Field(3e-4, description="at the start")
    learning_rate_end: NotNegative = Field(3e-5, description="at the end; linear in between")
    gamma: Share = Field(0.997, description="discount of a control interval: 0.997 looks 33 s ahead at 0.1 s")
    gae_lambda: Share = Field(0.95, description="generalised advantage estimation")
    clip_range: Positive = Field(0.2, description="bound of the probability ratio's change")
    entropy: NotNegative = Field(0.0, description="weight of the entropy bonus")
    value_weight: NotNegative = Field(0.5, description="weight of the value loss")
    gradient_norm: Positive = Field(0.5, description="bound of the gradient's norm")
    target_kl: Positive | None = Field(None, description="divergence at which an update stops early")


class Normalise(Section):
    """Running normalisation; observations are scaled by physical limits already, so they need none."""

    reward: bool = Field(True, description="divide rewards by the running deviation of the return")
    observation: bool = Field(False, description="shift and scale observations by their running moments")
    clip: Positive = Field(10.0, description="bound of normalised values")


class Checkpoints(Section):
    """What is kept along the way."""

    every_steps: Count = Field(1_000_000, description="control intervals (of all helicopters) between two of them")
    keep: Count = Field(2, description="how many are kept: the newest")


class TrainingConfig(Section):
    """A training run; `load_training` makes it from ``configs/training/*.yaml``."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="of the run and the agent")
    description: str = ""
    seed: Annotated[int, Field(ge=0)] = 0
    total_steps: Count = Field(description="control intervals of all helicopters together")
    torch_threads: Count = Field(1, description="threads of the networks: small ones are quickest on one")
    environment: Environment = Environment()
    stages: tuple[Stage, ...] = Field((), description="changes of the reward along the way, in order")
    network: Network = Network()
    ppo: Ppo = Ppo()
    normalise: Normalise = Normalise()
    checkpoints: Checkpoints = Checkpoints()

    @property
    def steps_per_update(self) -> int:
        """Control intervals of all helicopters between two updates."""
        return self.environment.count * self.ppo.steps_per_update

    def reward_at(self, steps: int, reward: Reward) -> Reward:
        """The reward's weights after so many steps.

        Args:
            steps: Control intervals of all helicopters together.
            reward: The task's.

        Raises:
            ConfigurationError: A stage names an unknown key, or a value that is not allowed.
        """
        changes = {
            key: value for stage in self.stages if stage.from_step <= steps for key, value in stage.reward.items()
        }
        return validated(Reward, reward.model_dump() | changes, "training: stages") if changes else reward

    @model_validator(mode="after")
    def _stages_in_order(self) -> Self:
        starts = [stage.from_step for stage in self.stages]
        if any(later <= earlier for earlier, later in pairwise(starts)):
            raise ValueError(f"stages: from_step = {starts}: must rise")
        return self

    @model_validator(mode="after")
    def _whole_batches(self) -> Self:
        if self.steps_per_update % self.ppo.batch_size:
            raise ValueError(
                f"ppo.batch_size = {self.ppo.batch_size}: must divide environment.count * ppo.steps_per_update = "
                f"{self.steps_per_update}"
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
    for change in changes:
        document = merged(with_bases(document), parsed_change(change))
    return validated(TrainingConfig, document, source)


def with_bases(document: Mapping[str, Any]) -> dict[str, Any]:
    """The document with a named task or scenario written as a mapping, so that a change to it keeps its name."""
    environment = document.get("environment")
    if not isinstance(environment, Mapping):
        return dict(document)
    named = {key: {BASE_KEY: value} if isinstance(value, str) else value for key, value in environment.items()}
    return {**document, "environment": named}


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
