"""A study: policies, conditions, and who is run through which; made from ``configs/evaluation/*.yaml``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Self

from pydantic import Field, field_validator, model_validator

from ssmash_gym.envs.loading import read
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition, ConditionConfig, Section, resolved
from ssmash_gym.sections import validated
from ssmash_gym.training.seeds import EVALUATION, block
from ssmash_gym.vehicle import load_helicopter

Count = Annotated[int, Field(ge=1)]
NAME: Final = r"^[A-Za-z0-9][A-Za-z0-9_.@+-]*$"  # of a condition or a policy: it goes into files' names
Name = Annotated[str, Field(pattern=NAME)]


class Run(Section):
    """Some policies through some conditions."""

    conditions: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="names of the study's conditions")
    policies: tuple[Name, ...] = Field((), description="scripted policies by name; NAME@SPEED drives at so many m/s")
    agents: bool = Field(False, description="whether the agents of the command line take part")
    episodes: Count | None = Field(None, description="seas, the first so many of the study's; all by default")


class Roles(Section):
    """Which policy stands for what; one that has not been run is left out of the figures."""

    hold: str = Field("hold", description="stands still: what the sea alone does")
    book: str = Field("trapezoid", description="drives by the book: the time to keep")
    laws: tuple[str, ...] = Field((), description="tuned laws: the best of them is to be beaten")
    clairvoyant: str | None = Field(None, description="knows the future of the deck: what could be reached")
    speeds: tuple[str, ...] = Field((), description="the book at several speeds: load against time")


class Targets(Section):
    """Where the project's aims are checked (`ssmash_gym.evaluation.targets`)."""

    main: str = Field(description="condition of the first, third and fourth aim")
    straight: str | None = Field(None, description="condition of the second one: landed without yaw")
    curve: str | None = Field(None, description="condition in which the book is driven at several speeds")


class StudyConfig(Section):
    """A study; `load_study` makes it."""

    description: str = Field("", description="what it is for, in a sentence")
    seed: Annotated[int, Field(ge=0)] = Field(description="chooses the block of episode seeds, none seen in training")
    episodes: Count = Field(description="seas of that block")
    chunk: Count = Field(250, description="seas of one file of rows: what an interruption can cost")
    planner_chunk: Count = Field(20, description="the same of a planner, which takes longer for each")
    resamples: Annotated[int, Field(ge=10)] = Field(2000, description="of the bootstrap")
    task: str = Field("traverse", description="task, name or file; agents keep their own observation")
    helicopter: str = Field("generic_tricycle", description="name or file")
    conditions: Annotated[dict[Name, ConditionConfig], Field(min_length=1)]
    runs: Annotated[tuple[Run, ...], Field(min_length=1)]
    roles: Roles = Roles()
    targets: Targets | None = None

    @field_validator("conditions")
    @classmethod
    def _apart(cls, given: dict[str, ConditionConfig]) -> dict[str, ConditionConfig]:
        folded = [name.casefold() for name in given]
        if len(set(folded)) < len(folded):
            raise ValueError("two conditions have the same name but for capitals, which some file systems mix up")
        return given

    @model_validator(mode="after")
    def _known(self) -> Self:
        for k, run in enumerate(self.runs):
            for name in run.conditions:
                self._check(f"runs.{k}.conditions", name)
            if run.episodes is not None and run.episodes > self.episodes:
                raise ValueError(f"runs.{k}.episodes = {run.episodes}: must be at most episodes = {self.episodes}")
        if self.targets is not None:
            for key in ("main", "straight", "curve"):
                name = getattr(self.targets, key)
                if name is not None:
                    self._check(f"targets.{key}", name)
        return self

    def _check(self, key: str, name: str) -> None:
        if name not in self.conditions:
            raise ValueError(f"{key}: there is no condition {name!r}; there are {', '.join(self.conditions)}")

    @property
    def scripted(self) -> tuple[str, ...]:
        """Names of all scripted policies, in the order of the runs."""
        return tuple(dict.fromkeys(name for run in self.runs for name in run.policies))

    @property
    def seas(self) -> list[int]:
        """Episode seeds, the same for every policy and condition."""
        return block(self.seed, EVALUATION, self.episodes)

    def resolved(self) -> dict[str, Condition]:
        """The conditions with all that they name.

        Raises:
            ConfigurationError: A condition is refused.
        """
        helicopter = load_helicopter(self.helicopter)
        return {name: resolved(name, one, self.task, helicopter) for name, one in self.conditions.items()}

    def plan(self, agents: tuple[str, ...] = ()) -> dict[tuple[str, str], int]:
        """How many seas each policy meets in each condition.

        Args:
            agents: Names of the agents that take part.

        Returns:
            Number of seas by condition and policy; the largest where several runs name both.
        """
        found: dict[tuple[str, str], int] = {}
        for run in self.runs:
            count = run.episodes or self.episodes
            for condition in run.conditions:
                for policy in (*run.policies, *(agents if run.agents else ())):
                    found[condition, policy] = max(count, found.get((condition, policy), 0))
        return found

    def narrowed(self, policies: tuple[str, ...] | None, conditions: tuple[str, ...] | None, most: int | None) -> Self:
        """The same study with fewer scripted policies, conditions or seas; what is left gives the same rows.

        Args:
            policies: Scripted policies to keep; None keeps all.
            conditions: Conditions to run; None runs all.
            most: Seas at most.

        Raises:
            ConfigurationError: A name is none of the study's, there are fewer seas, or nothing is left.
        """
        if most is not None and most > self.episodes:
            raise ConfigurationError(
                f"--episodes {most} is refused: the study has {self.episodes} seas, and the option only takes fewer."
            )
        for kind, given, known in (("policy", policies, self.scripted), ("condition", conditions, self.conditions)):
            for name in given or ():
                if name not in known:
                    raise ConfigurationError(f"study: there is no {kind} {name!r} in it; there are {', '.join(known)}.")
        runs = []
        for run in self.runs:
            here = tuple(name for name in run.conditions if conditions is None or name in conditions)
            those = tuple(name for name in run.policies if policies is None or name in policies)
            count = run.episodes if most is None else min(most, run.episodes or most)
            if here and (those or run.agents):
                runs.append(run.model_copy(update={"conditions": here, "policies": those, "episodes": count}))
        if not runs:
            raise ConfigurationError(
                "study: nothing is left to run: name policies and conditions that belong together."
            )
        return self.model_copy(update={"runs": tuple(runs), "episodes": self.episodes if most is None else most})


def load_study(study: str | Path | Mapping[str, Any]) -> StudyConfig:
    """Load a study: a name in ``configs/evaluation``, a YAML file, or a ready document.

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed; one sentence.
    """
    if isinstance(study, Mapping):
        return validated(StudyConfig, study, "study")
    document, source = read("evaluation", study)
    return validated(StudyConfig, document, source)
