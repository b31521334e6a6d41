"""A condition: the same frozen seas under one set of circumstances, such as a longer delay or a wet deck."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from ssmash_gym.envs.loading import BASE_KEY
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.starts import Starter
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.vehicle import Helicopter, with_changes

Factor = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class Section(BaseModel):
    """Part of a study: frozen, and no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class ConditionConfig(Section):
    """What differs from the study's task and helicopter."""

    description: str = Field("", description="what it stands for, in a sentence")
    scenario: str | dict[str, Any] = Field(description="name, file, or changes to the one that the key base names")
    task: dict[str, Any] = Field({}, description="changes to the study's task, e.g. claw.delay_s")
    helicopter: dict[str, Any] = Field({}, description="new values of the study's helicopter, by dotted path")
    helicopter_factors: dict[str, Factor] = Field({}, description="factors on its values, by dotted path")


@dataclass(frozen=True)
class Condition:
    """A condition, resolved.

    Attributes:
        name, description: As in the study.
        task: As it is judged; a policy observes it in its own way.
        scenario: What episodes are drawn from.
        helicopter: With the condition's changes.
    """

    name: str
    description: str
    task: TaskConfig
    scenario: ScenarioConfig
    helicopter: Helicopter

    @property
    def configuration(self) -> str:
        """Hash of all that is resolved; what is only said about it does not count."""
        return digest(*hashed(self.task, self.scenario, self.helicopter))

    def check(self) -> None:
        """Refuse what cannot be started.

        Raises:
            ConfigurationError: The scenario does not suit the helicopter or the claw.
        """
        try:
            Starter(self.helicopter, self.task, self.scenario)
        except ConfigurationError as error:
            raise ConfigurationError(f"study: conditions.{self.name}: {error}") from None


def resolved(name: str, config: ConditionConfig, task: str, helicopter: Helicopter) -> Condition:
    """Load what a condition names and apply its changes.

    Args:
        name: Of the condition.
        config: The condition.
        task: The study's: name or file.
        helicopter: The study's.

    Raises:
        ConfigurationError: A name, a key or a value is refused; one sentence.
    """
    try:
        changes = {**config.helicopter, **scaled(helicopter, config.helicopter_factors)}
        return Condition(
            name,
            config.description,
            load_task({BASE_KEY: task, **config.task}),
            load_scenario(config.scenario),
            with_changes(helicopter, changes) if changes else helicopter,
        )
    except ConfigurationError as error:
        raise ConfigurationError(f"study: conditions.{name}: {error}") from None


def written(task: TaskConfig, scenario: ScenarioConfig, helicopter: Helicopter) -> dict[str, Any]:
    """What is simulated, resolved, as a record holds it."""
    return {
        "task": task.model_dump(mode="json"),
        "scenario": scenario.model_dump(mode="json"),
        "helicopter": helicopter.model_dump(mode="json", exclude={"provenance"}),
    }


def hashed(task: TaskConfig, scenario: ScenarioConfig, helicopter: Helicopter) -> list[dict[str, Any]]:
    """The same for `digest`, part by part: what is only said about task and scenario does not count."""
    parts = written(task, scenario, helicopter)
    for name in ("task", "scenario"):
        del parts[name]["description"]
    return list(parts.values())


def digest(*parts: Any) -> str:
    """Hash of plain numbers, texts, lists and mappings: the same hash, the same contents."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def scaled(helicopter: Helicopter, factors: Mapping[str, float]) -> dict[str, float]:
    """New values by dotted path: the helicopter's own times the factor.

    Raises:
        ConfigurationError: A path leads to no number.
    """
    found = {}
    document = helicopter.model_dump(mode="json", exclude={"provenance"}) if factors else {}
    for path, factor in factors.items():
        value: Any = document
        for key in path.split("."):
            value = value.get(key) if isinstance(value, Mapping) else None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ConfigurationError(f"helicopter_factors.{path} is refused: {shown(value)} there is no number.")
        found[path] = factor * value
    return found
