"""What a search for good settings is made of: one YAML file, checked before anything is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from ssmash_gym.envs.loading import merged, read
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.sections import validated
from ssmash_gym.training.config import TrainingConfig, load_training, parsed_change, undotted, with_bases
from ssmash_gym.training.evolution import judged_in
from ssmash_gym.training.sections import Count, NotNegative, Section, Share


class Range(Section):
    """Values that a key may take: numbers between two bounds, or a list."""

    low: float | None = Field(None, description="least value")
    high: float | None = Field(None, description="greatest value")
    log: bool = Field(False, description="spread evenly over magnitudes")
    whole: bool = Field(False, description="whole numbers only")
    choices: tuple[Any, ...] = Field((), description="values to choose from, instead of bounds")

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if bool(self.choices) == (self.low is not None or self.high is not None):
            raise ValueError("give either low and high, or choices")
        if not self.choices and (self.low is None or self.high is None or self.low >= self.high):
            raise ValueError(f"low = {self.low}, high = {self.high}: low must be below high")
        for end, value in (("low", self.low), ("high", self.high)):
            if self.whole and value is not None and not value.is_integer():
                raise ValueError(f"{end} = {value:g}: must be a whole number where whole is true")
        if self.log and (self.choices or (self.low or 0.0) <= 0.0):
            raise ValueError("log: needs low above 0")
        return self


class Objective(Section):
    """What is made small: the 95th percentile of the scored peak loads, plus a penalty for missing successes."""

    scenario: str | dict[str, Any] = Field("ss5", description="scenario of the judging episodes")
    episodes: Count = Field(64, description="judging episodes, from seeds that serve nothing but choices")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="which of these seeds")
    success: Share = Field(0.95, description="share of successes below which the penalty begins")
    penalty_kN: NotNegative = Field(200.0, description="for a success rate that is 1 below [kN]: 10 kN for 5 percent")


class SearchConfig(Section):
    """A search; `load_search` makes it from a YAML file."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", description="of the search")
    description: str = Field("", description="what it is for, in a sentence")
    training: str | dict[str, Any] = Field("ppo_traverse", description="training it starts from: name, file, document")
    changes: dict[str, Any] = Field({}, description="changes to it for every trial, nested or by dotted keys")
    space: Annotated[dict[str, Range], Field(min_length=1)] = Field(description="ranges by dotted key")
    trials: Count = Field(30, description="trainings, the pruned ones among them")
    random_trials: Count = Field(8, description="first trials, drawn without a model of what is good")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="of the search; each trial draws from a stream of its own")
    reports: Count = Field(6, description="times in a training at which a bad one may be given up")
    pruning_after: Count = Field(4, description="finished trials before the first is given up")
    objective: Objective = Field(Objective(), description="what is made small")

    def settings(self, values: Mapping[str, Any]) -> TrainingConfig:
        """The training of a trial, its task, scenario, stages and evolution checked too.

        Args:
            values: What its keys are, by dotted key.

        Raises:
            ConfigurationError: Unknown key, or a value that is not allowed.
        """
        settings = load_training(self.document(values))
        task, scenario = load_task(settings.environment.task), load_scenario(settings.environment.scenario)
        settings.reward_at(settings.total_steps, task.reward)
        last = settings.scenario_at(settings.total_steps, scenario)
        if settings.evolution is not None:
            judged_in(settings.evolution, task, last)
        return settings

    def document(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The same as a document; it holds what the training's file says and the changes, no defaults."""
        base = self.training if isinstance(self.training, dict) else read("training", self.training)[0]
        changed = merged(with_bases(base), undotted(self.changes))
        return merged(with_bases(changed), undotted(values))


def load_search(config: str | Path, changes: Sequence[str] = ()) -> SearchConfig:
    """Load a search.

    Args:
        config: A name in ``configs/training``, or the path of a YAML file.
        changes: ``key=value`` with a dotted key and a YAML value, e.g. ``trials=4``.

    Raises:
        ConfigurationError: Unknown file or key, or a value that is not allowed, in the search, its training or the
            judging scenario; one sentence.
    """
    document, source = read("training", config)
    for change in changes:
        document = merged(document, parsed_change(change))
    plan = validated(SearchConfig, document, source)
    try:
        load_scenario(plan.objective.scenario)
    except ConfigurationError as mistake:
        raise ConfigurationError(f"{source}: objective.scenario is refused: {mistake}") from None
    for end in ("low", "high"):  # a mistake in the space or the changes is told before the search
        first = {key: _end(entry, end) for key, entry in plan.space.items()}
        try:
            plan.settings(first)
        except ConfigurationError as mistake:
            raise ConfigurationError(
                f"{source}: the training with the {end} ends of the space is refused: {mistake}"
            ) from None
    return plan


def _end(entry: Range, end: str) -> Any:
    if entry.choices:
        return entry.choices[0 if end == "low" else -1]
    value = entry.low if end == "low" else entry.high
    assert value is not None
    return int(value) if entry.whole else value
