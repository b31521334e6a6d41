"""What every planner has in common: it is attached to the running batch, keeps one plan a helicopter, and drives it."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.planning_law import AXES, Drive, Law, Seen
from ssmash_gym.agents.planning_rehearsal import seen_of

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
Observations = NDArray[np.float32]


class Planner(ABC):
    """A policy that plans on copies of the helicopters it drives.

    Whoever runs the episodes calls `attach` with the batch, then `reset`, then `act` before every step.

    Args:
        task: The task it is to be used in.
        law: The law that its plans are added to.
        replan_every: Control intervals from one plan to the next; 0 plans once, at the start.
    """

    name: str

    def __init__(self, task: TaskConfig, law: Law, replan_every: int) -> None:
        self.task = task
        self.drive = Drive(task, law)
        self._every = replan_every
        self._core: TraverseBatch | None = None
        self._steps: Columns = np.zeros(0, dtype=np.int64)
        self._plans: Array = np.zeros((0, law.knots(task), AXES))

    @property
    def core(self) -> TraverseBatch:
        """The batch that is driven.

        Raises:
            ConfigurationError: There is none yet.
        """
        if self._core is None:
            raise ConfigurationError(
                f"{self.name}: a planner rehearses on the running simulation; call attach(batch) before reset and act."
            )
        return self._core

    def attach(self, core: TraverseBatch) -> None:
        """Take the batch whose helicopters will be driven; it is only ever copied from.

        Raises:
            ConfigurationError: Its control interval is not the task's.
        """
        if core.control_interval_s != self.task.control_interval_s:
            raise ConfigurationError(
                f"{self.name}: control_interval_s = {core.control_interval_s:g} of the batch is refused: must be the "
                f"task's {self.task.control_interval_s:g} s."
            )
        self._core = core
        self.prepare(core)

    def reset(self, count: int) -> None:
        """Start `count` episodes."""
        self._steps = np.zeros(count, dtype=np.int64)
        self._plans = np.zeros((count, *self._plans.shape[1:]))

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for the next interval.

        Args:
            observations: (n, k) as the task's observation table scales them.
            starts: (n,) rows in which a new episode starts; not needed after `reset`.

        Returns:
            Normalised claw velocity, along and across, (n, 2).
        """
        core = self.core
        if starts is not None:
            self._steps[starts], self._plans[starts] = 0, 0.0
        running = ~core.book.over
        fresh = np.flatnonzero(running & (self._steps == 0))
        if fresh.size:
            self.begin(fresh)
        due = running & (self._steps % self._every == 0 if self._every else self._steps == 0)
        for step in np.unique(self._steps[due]):
            rows = np.flatnonzero(due & (self._steps == step))
            self._plans[rows] = self.improved(rows, int(step), self._plans[rows])
        steps = np.minimum(self._steps, self.task.horizon_steps - 1)
        planned = self.drive.planned(self._plans, steps)
        commands = self.drive.commands(self.seen(observations), steps, planned)
        self._steps += 1
        return commands.astype(np.float32)

    def seen(self, observations: Observations) -> Seen:
        """What the law reads; here the simulation's own channels, without noise and delay."""
        return seen_of(self.core.batch)

    @abstractmethod
    def prepare(self, core: TraverseBatch) -> None:
        """Make what rehearsals need."""

    @abstractmethod
    def begin(self, rows: Columns) -> None:
        """New episodes begin in these rows."""

    @abstractmethod
    def improved(self, rows: Columns, step: int, plans: Array) -> Array:
        """Better plans of the listed helicopters, `step` control intervals after their start, (n, knots, 2)."""
