"""Recorded trials as what learns from them needs: observations, commands and rewards, made anew by simulation.

A trial's file holds no observations: what a policy is to see is chosen afterwards. Whatever is observed, the physics
must come out bit for bit as it was recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.given import observed
from ssmash_gym.envs.task import History, TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.progress import progress_bar
from ssmash_gym.trials.files import read_trial
from ssmash_gym.trials.replay import batch_of
from ssmash_gym.trials.scripted import SCRIPTED_OPERATOR
from ssmash_gym.trials.trial import Trial, state_digest

SENSORS: Final = "sensors"


@dataclass(frozen=True)
class Demonstration:
    """One episode, as a policy would have seen it.

    Attributes:
        observations: (n + 1, k) float32, scaled as the task says; the last one is that after the end.
        actions: Applied commands, along and across the track, (n, 2).
        rewards: (n,).
        terminated: Whether the last step ended the episode other than by its time limit.
        truncated: Whether it was that limit.
        seed: Of the episode.
        author: Who drove: ``participant P01``, ``scripted operator``, ``agent NAME`` and so on.
        metrics: Of the episode.
    """

    observations: NDArray[np.float32]
    actions: NDArray[np.float64]
    rewards: NDArray[np.float64]
    terminated: bool
    truncated: bool
    seed: int
    author: str
    metrics: dict[str, Any]


def perceived(
    task: TaskConfig, observation: str | Sequence[str] = SENSORS, history: History | None = None
) -> TaskConfig:
    """A task, observed in a chosen way.

    Args:
        task: As it is judged.
        observation: A named set, or terms.
        history: Past readings behind the present ones.

    Raises:
        ConfigurationError: The observation or the history is refused.
    """
    document = observed(task, observation)
    return load_task({**document, "history": None if history is None else history.model_dump(mode="json")})


def demonstration(trial: Trial, task: TaskConfig, author: str = "", place: str = "trial") -> Demonstration:
    """A trial simulated once more under other eyes.

    Args:
        trial: A complete one.
        task: As of `perceived`, of the trial's own task.
        author: Who drove; as the trial tells it by default.
        place: What the trial is called in messages.

    Raises:
        ConfigurationError: It is not complete, or does not come out bit for bit as it was recorded.
    """
    if not trial.complete or trial.metrics is None:
        raise ConfigurationError(f"{place}: the trial is refused: it was broken off.")
    batch = batch_of(trial, task)
    observations = [batch.last[0].copy()]
    rewards = []
    digests = trial.table["state_digest"].to_list()
    ends = [False, False]
    for k, command in enumerate(trial.commands):
        result = batch.step(command[None])
        if state_digest(batch.batch.state[:, 0]) != digests[k]:
            raise ConfigurationError(
                f"{place}: the trial is refused: from step {k + 1} on it does not come out as it was recorded."
            )
        observations.append(result.observation[0])
        rewards.append(float(result.reward[0]))
        ends = [bool(result.terminated[0]), bool(result.truncated[0])]
    return Demonstration(
        np.stack(observations), trial.commands, np.array(rewards), ends[0], ends[1], trial.seed,
        author or author_of(trial), trial.metrics,
    )  # fmt: skip


def demonstrations(
    paths: Sequence[Path], seen: Callable[[TaskConfig], TaskConfig]
) -> tuple[Condition, TaskConfig, list[Demonstration]]:
    """The complete trials among files, as they would have been observed.

    Args:
        paths: Files.
        seen: From the trials' task to the same under the eyes of a policy, see `perceived`.

    Returns:
        What was simulated, the task as it is observed, and the episodes.

    Raises:
        ConfigurationError: A file cannot be read or does not replay, none is complete, or there are several
            configurations.
    """
    trials = [(path.name, trial) for path in paths if (trial := read_trial(path)).complete]
    one_condition(trials)
    condition = trials[0][1].condition
    task = seen(condition.task)
    made = []
    with progress_bar("replaying trials") as advance:
        for k, (place, trial) in enumerate(trials):
            advance(k / len(trials), f"replaying {place}")
            made.append(demonstration(trial, task, place=place))
    return condition, task, made


def author_of(trial: Trial) -> str:
    """Who drove a trial; what a script drove is never a participant's."""
    if trial.by_person:
        return f"participant {trial.about['participant'] or 'without a name'}"
    return SCRIPTED_OPERATOR if trial.driver == SCRIPTED_OPERATOR else f"scripted driver {trial.driver}"


def one_condition(trials: Sequence[tuple[str, Trial]]) -> None:
    """Check that trials were driven in one configuration.

    Args:
        trials: Each with what it is called in messages.

    Raises:
        ConfigurationError: There is no trial, or there are several configurations.
    """
    if not trials:
        raise ConfigurationError("there is no complete trial to learn from.")
    kinds = {str(trial.about["configuration"]): place for place, trial in trials}
    if len(kinds) > 1:
        told = " and ".join(f"{place} ({name})" for name, place in list(kinds.items())[:2])
        raise ConfigurationError(f"the trials were driven in {len(kinds)} configurations, such as {told}: name one's.")
