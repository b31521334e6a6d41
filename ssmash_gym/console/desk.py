"""The claw desk: one helicopter, one episode after another, a person or a policy at the claw. No clock, no network."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.console.commands import LONGEST_INTERVAL_S
from ssmash_gym.console.scene import frame_of, setup_of
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.step import StepResult
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.policies import Policy, planners
from ssmash_gym.evaluation.study_entrants import Entrant, entrant
from ssmash_gym.trials.recorder import TrialRecorder
from ssmash_gym.trials.stamps import Stamp
from ssmash_gym.trials.trial import Trial

STANDING: Final = (0.0, 0.0)


def entrant_of(word: str, task: TaskConfig) -> Entrant:
    """A policy that can drive in real time: a scripted one, or a trained agent by name or folder.

    Raises:
        ConfigurationError: There is none of that name, or it is a planner.
    """
    if word.partition("@")[0] in planners():
        raise ConfigurationError(f"--policy {word} is refused: a planner thinks longer than a control step lasts.")
    return entrant(word, task)


class Desk:
    """One helicopter under the claw.

    A person's and a policy's commands take the same way. The policy is asked in every step, also while a person
    drives: what it remembers stays up to date, and it can take over at any moment.

    Args:
        condition: What is simulated.
        entrant: The policy that may drive; None: none may.

    Attributes:
        condition: As above; policy: its name, or None.
        seed: Of the present episode; None before the first one.
        result: Of the last control step; None before the first one of an episode.

    Raises:
        ConfigurationError: The condition or the policy is refused, or control steps are too long for a person.
    """

    def __init__(self, condition: Condition, entrant: Entrant | None = None) -> None:
        interval_s = condition.task.control_interval_s
        if interval_s > LONGEST_INTERVAL_S:
            raise ConfigurationError(
                f"task: control_interval_s = {interval_s:g} is refused: {LONGEST_INTERVAL_S:g} s at most for a person."
            )
        condition.check()
        self.condition = condition
        self._policy: Policy | None = None if entrant is None else entrant.make(condition.task)
        self.policy = None if entrant is None else entrant.name
        task = condition.task if self._policy is None else self._policy.task
        self._batch = TraverseBatch(
            1, task=task, scenario=condition.scenario, helicopter=condition.helicopter, threads=1
        )
        self.seed: int | None = None
        self.result: StepResult | None = None
        self._recorder: TrialRecorder | None = None
        self._observation: NDArray[np.float32] = np.zeros((1, 0), np.float32)

    @property
    def interval_s(self) -> float:
        """Between two commands [s]."""
        return self._batch.control_interval_s

    def begin(self, seed: int, about: Mapping[str, Any]) -> None:
        """Bring an episode to its start.

        Args:
            seed: Of the sea, the helicopter and the start.
            about: What its record says besides, as of `TrialRecorder`.
        """
        self._observation = self._batch.reset(seeds=[seed])
        if self._policy is not None:
            self._policy.reset(1)
        self.seed, self.result = seed, None
        self._recorder = TrialRecorder(self._batch, self.condition, seed, about)

    def wish(self) -> NDArray[np.float32] | None:
        """What the policy would command now, (1, 2); None without one. To be asked once in every step."""
        return None if self._policy is None else self._policy.act(self._observation)

    def step(self, action: NDArray[np.float32] | None, command: tuple[float, float], stamp: Stamp) -> StepResult:
        """One control interval.

        Args:
            action: The policy's, where it drives; None: the command counts.
            command: A person's, along and across.
            stamp: Whose it is, and when it came.
        """
        wanted = np.array([command]) if action is None else action
        result = self._batch.step(wanted, direct=action is None)
        self._observation = result.observation
        self.result = result
        assert self._recorder is not None
        self._recorder.note(result, stamp)
        return result

    @property
    def sound(self) -> bool:
        """Whether the numbers can be shown: a simulation that has diverged has none."""
        return not self._batch.batch.diverged[0]

    @property
    def over(self) -> bool:
        """Whether the episode has ended by itself."""
        return self.result is not None and bool(self.result.terminated[0] or self.result.truncated[0])

    @property
    def ending(self) -> dict[str, Any]:
        """How the episode ended: ``reason``, ``success``, ``episode_metrics``; empty while it runs."""
        return {} if self.result is None else self.result.endings.get(0, {})

    def trial(self) -> Trial:
        """The record of the present episode."""
        assert self._recorder is not None
        return self._recorder.trial(complete=self.over)

    def setup(self) -> dict[str, Any]:
        """What a page draws that does not move."""
        return setup_of(self._batch)

    def frame(self) -> dict[str, Any]:
        """What a page draws of this instant."""
        return frame_of(self._batch)
