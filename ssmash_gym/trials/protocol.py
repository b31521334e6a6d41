"""The protocol of trials: which seas are practised in and which are scored, when practice ends, what counts as late."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ssmash_gym.envs.limits import GOAL
from ssmash_gym.envs.loading import load
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation.conditions import Condition, Section, digest
from ssmash_gym.training.seeds import TRIALS, block
from ssmash_gym.trials.trial import bare
from ssmash_gym.vehicle import load_helicopter

Count = Annotated[int, Field(ge=1, le=1000)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class Plateau(Section):
    """When a participant no longer learns much: each of the last trials has reached the goal, and they are alike."""

    figure: Literal["time_s", "peak_probe_kN", "p95_probe_kN"] = Field(
        description="metric that must have settled; assumed"
    )
    last: Annotated[int, Field(ge=2, le=100)] = Field(description="so many last trials are looked at; assumed")
    within: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        description="each lies within this share of their mean; assumed"
    )

    def reached(self, metrics: Sequence[Mapping[str, Any]]) -> bool:
        """Whether the last of these trials, given by their metrics in the order of driving, are a plateau."""
        last = metrics[-self.last :]
        if len(last) < self.last or any(one["reason"] != GOAL for one in last):
            return False
        values = np.array([one[self.figure] for one in last], dtype=np.float64)
        mean = float(np.mean(values))
        return bool((np.abs(values - mean) <= self.within * mean).all())


class Practice(Section):
    """Trials that do not count, in seas of their own."""

    least: Count = Field(description="so many at least; assumed")
    most: Count = Field(description="so many at most, plateau or not; assumed")
    plateau: Plateau

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.plateau.last <= self.least <= self.most:
            raise ValueError(
                f"least = {self.least}: must lie between plateau.last = {self.plateau.last} and most = {self.most}"
            )
        return self


class Scored(Section):
    """Trials that count."""

    seas: Count = Field(description="how many; each is met once; assumed")


class Late(Section):
    """What the server may be behind."""

    after_s: NotNegative = Field(
        description="a step whose input is read later than this after it was due is late [s]; assumed"
    )
    share: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        description="a trial with a larger share of late steps is invalid; assumed"
    )


class TrialProtocol(Section):
    """A protocol; `load_protocol` makes it from ``configs/trials/*.yaml``."""

    description: str = Field("", description="what it is, in a sentence")
    task: str | dict[str, Any] = Field(
        "traverse", description="name, file, or changes to the one that its key base names"
    )
    scenario: str | dict[str, Any] = Field(description="the same")
    helicopter: str = Field("generic_tricycle", description="name or file")
    seed: Annotated[int, Field(ge=0)] = Field(description="from which the seas are drawn")
    practice: Practice
    scored: Scored
    late: Late
    countdown_s: NotNegative = Field(description="before each trial [s]; assumed")

    @functools.cached_property
    def condition(self) -> Condition:
        """What is simulated.

        Raises:
            ConfigurationError: A name, a key or a value is refused.
        """
        name = self.scenario if isinstance(self.scenario, str) else str(self.scenario.get("base", "scenario"))
        task = load_task(self.task)
        return bare(
            Condition(
                Path(name).stem, self.description, task, load_scenario(self.scenario), load_helicopter(self.helicopter)
            )
        )

    @property
    def practice_seeds(self) -> list[int]:
        """Seeds of the practice seas, in the order in which they are met; none is a scored one."""
        return block(self.seed, TRIALS, 2 * self.practice.most)[1::2]

    @property
    def scored_seeds(self) -> list[int]:
        """Seeds of the scored seas; they do not depend on how much is practised."""
        return block(self.seed, TRIALS, 2 * self.scored.seas)[0::2]

    @functools.cached_property
    def identity(self) -> str:
        """Hash of all that is resolved; the description does not count."""
        own = self.model_dump(mode="json", exclude={"description", "task", "scenario", "helicopter"})
        return digest(own, self.condition.configuration, self.practice_seeds, self.scored_seeds)

    def order(self, participant: str) -> list[int]:
        """The scored seeds in a participant's own order, which protocol and participant alone decide."""
        words = np.frombuffer(f"{self.identity}/{participant}".encode(), dtype=np.uint8)
        shuffled = np.random.default_rng(np.random.SeedSequence(words.tolist())).permutation(len(self.scored_seeds))
        return [self.scored_seeds[k] for k in shuffled]

    def practised(self, metrics: Sequence[Mapping[str, Any]]) -> bool:
        """Whether practice is over after these complete and valid trials, given by their metrics in their order."""
        if len(metrics) < self.practice.least:
            return False
        return len(metrics) >= self.practice.most or self.practice.plateau.reached(metrics)


def load_protocol(given: str | Path | Mapping[str, Any] | TrialProtocol = "standard") -> TrialProtocol:
    """Load a protocol: a name in ``configs/trials``, a YAML file, or a mapping of changes (key ``base``: to which).

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed, in the protocol or in what it names;
            one sentence.
    """
    protocol = load(TrialProtocol, "trials", given, "standard")
    protocol.condition.check()
    return protocol
