"""The task for a batch of helicopters, in NumPy: the one core of the single, the vector and the SB3 environment.

Column k of a batch is bit for bit the single environment with the same seed: nothing that happens in a column depends
on its neighbours, the size of the batch or the number of threads.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssmash_gym.dynamics.engine import available_threads, lane_width
from ssmash_gym.envs import limits
from ssmash_gym.envs.divergence import divergence, dump
from ssmash_gym.envs.episode import EpisodeBook
from ssmash_gym.envs.given import as_helicopter, observed
from ssmash_gym.envs.guides import Guide
from ssmash_gym.envs.nursery import Nursery, move_on
from ssmash_gym.envs.observations import Observer
from ssmash_gym.envs.reading import Reading, columns_of, half_spread
from ssmash_gym.envs.rewards import Outcome, alignment_potential, progress_potential, rewards, total
from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig, changed_scenario, load_scenario
from ssmash_gym.envs.sensors import Instruments
from ssmash_gym.envs.starts import Starter, check_room
from ssmash_gym.envs.step import BatchSnapshot, StepResult
from ssmash_gym.envs.task import Reward, TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.sections import validated
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
Flags = NDArray[np.bool_]
ACTIONS = 2


class TraverseBatch:
    """N helicopters on their way into the hangar.

    Args:
        n: How many.
        task: Name, YAML file, mapping of changes, or `TaskConfig`.
        scenario: Name, YAML file, mapping of changes, or `ScenarioConfig`.
        helicopter: Name, file, `Helicopter`, or a mapping: either a whole description, or changes by dotted path to the
            helicopter that its key ``base`` names.
        observation: Overrides the task's: ``sensors``, ``full``, ``forecast``, ``oracle`` or names of
            `observations.TERMS`.
        threads: Workers of a call; None takes as many as are useful. Results do not depend on it.
        dump_dir: Folder for the state of a diverged helicopter; None writes nothing.
        max_episode_steps: Truncates earlier than the task's horizon, as Gymnasium's TimeLimit does.
        beside: Another one of the same simulation, for another policy: both drive the same helicopters, one after the
            other (`begin` with `started`). Only what is observed may differ.

    Attributes:
        batch: The `simulation.Batch` underneath; generators: one a column; draws: of the running episodes.
        last: The last observation of each, (n, size) float32.
        reading: What the terms of reward, limits and observation have read of the last interval.

    Raises:
        ConfigurationError: A configuration is refused; one sentence.
    """

    def __init__(
        self,
        n: int = 1,
        *,
        task: str | Path | Mapping[str, Any] | TaskConfig = "traverse",
        scenario: str | Path | Mapping[str, Any] | ScenarioConfig = "training",
        helicopter: str | Path | Mapping[str, Any] | Helicopter = "generic_tricycle",
        observation: str | Sequence[str] | None = None,
        threads: int | None = None,
        dump_dir: str | Path | None = None,
        max_episode_steps: int | None = None,
        beside: TraverseBatch | None = None,
    ) -> None:
        self.n = n
        self.task = load_task(task)
        if observation is not None:
            self.task = load_task(observed(self.task, observation))
        self.scenario = load_scenario(scenario)
        self.starter = Starter(as_helicopter(helicopter), self.task, self.scenario)
        self.threads = threads or max(1, min(available_threads(), -(-n // lane_width(n))))
        self.batch: Batch = self.starter.batch(n, self.threads) if beside is None else beside.batch
        if beside is not None:
            self.starter.decks = beside.starter.decks
        self.reading: Reading | None = None
        self.observer = Observer(self.task)
        self.sensors = Instruments(n, self.observer, self.starter)
        self.last: NDArray[np.float32] = np.zeros((n, self.observer.size), np.float32)
        self.book = EpisodeBook.blank(n, self.task.horizon_steps)
        self.book.over[:] = True
        self.generators: list[np.random.Generator | None] = [None] * n
        self.draws: list[EpisodeDraw | None] = [None] * n
        self.dump_dir = dump_dir
        self.limit_steps = min(max_episode_steps or self.task.horizon_steps, self.task.horizon_steps)
        self._half_spread = half_spread(self.starter.helicopter)
        self._nursery = Nursery(self.starter, n, self.threads)
        self._guide = None if self.task.residual is None else Guide(n, self.task, self.task.residual)
        self._bound = np.ones((n, ACTIONS))  # of the commands, as shares of the task's claw speeds

    @property
    def control_interval_s(self) -> float:
        """Time between two commands [s]."""
        return self.task.control_interval_s

    @property
    def telemetry(self) -> Telemetry:
        """The true channels of all helicopters, by name, shape (n,), SI."""
        return self.batch.telemetry

    # --- episodes ----------------------------------------------------------------------------------------------

    def reset(
        self,
        columns: ArrayLike | None = None,
        seeds: Sequence[int | None] | None = None,
        draws: Sequence[EpisodeDraw | Mapping[str, Any] | None] | None = None,
    ) -> NDArray[np.float32]:
        """Start new episodes in the listed columns (None: all); returns their first observations, (m, size).

        Args:
            columns: Which.
            seeds: One a column; None lets the column's own generator continue (a first one is seeded by chance).
            draws: Ready-made draws instead of the scenario's, one a column; the generator still moves on.

        Raises:
            ConfigurationError: A draw is refused; nothing has been started.
        """
        chosen = self.batch.columns(columns)
        given = self.starter.checked(draws, chosen.size, self.sensors.longest_delay_s, self.sensors.noisy)
        before = list(self.generators)
        for i, k in enumerate(chosen):
            seed = None if seeds is None else seeds[i]
            if seed is not None or self.generators[k] is None:
                self.generators[k] = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
                self._nursery.forget(int(k))
        try:
            self._start(chosen, given)
        except ConfigurationError:
            self.generators = before
            raise
        return self._first(chosen)

    def begin(self, draws: Sequence[EpisodeDraw], *, started: bool = False) -> NDArray[np.float32]:
        """Start ready-made episodes in the first columns, one a draw; returns their first observations, (m, size).

        Nothing is checked: the draws must come from a scenario with no longer delays and no more noise than this one's.
        A column whose episodes begin so has no generator and cannot be reset without a seed.

        Args:
            draws: The episodes, at most n.
            started: The helicopters stand at the start of these very episodes already (`simulation.snapshot.rewind`).
        """
        chosen = np.arange(len(draws))
        if not started:
            self.starter.start(self.batch, chosen, draws)
        for k, draw in enumerate(draws):
            self._nursery.forget(k)
            self.generators[k], self.draws[k] = None, draw
        return self._first(chosen)

    def _first(self, chosen: Columns) -> NDArray[np.float32]:
        """Open the book of episodes whose helicopters stand at their start; returns the first observations."""
        self.book.begin(chosen)
        self._bound[chosen, 1] = [self._drive_share(int(k)) for k in chosen]
        if self._guide is not None:
            self._guide.begin(chosen)
        telemetry, broken = columns_of(self.batch.telemetry, chosen, instant=True)
        first = self._reading(chosen, telemetry, broken, np.zeros((chosen.size, ACTIONS)))
        self.book.held[chosen] = first.held
        self.book.progress[chosen] = progress_potential(first)
        self.book.alignment[chosen] = alignment_potential(first)
        scaled = self.observer.scaled(first)
        self.sensors.start(chosen, [d for d in (self.draws[k] for k in chosen) if d], scaled)
        self.last[chosen] = self.observer.observation(scaled)[0]
        return self.last[chosen]

    def _start(self, columns: Columns, given: Sequence[EpisodeDraw | None]) -> None:
        """Draw (or take) the columns' episodes and bring them to their start."""
        if any(draw is not None for draw in given):
            ahead = [copy.deepcopy(self._generator(int(k))) for k in columns]
            drawn = [self.scenario.sample(generator) for generator in ahead]
            chosen = [own if draw is None else draw for own, draw in zip(drawn, given, strict=True)]
            self.starter.start(self.batch, columns, chosen)
            for k, draw, generator in zip(columns, chosen, ahead, strict=True):
                self._nursery.forget(int(k))
                self.draws[k] = draw
                move_on(self._generator(int(k)), generator)
            return
        self._nursery.start(self.batch, columns, self.generators, self.draws, self.book.steps)

    def _drive_share(self, k: int) -> float:
        """Speed across at which column k's drive saturates, as a share of the task's."""
        draw = self.draws[k]
        speed = None if draw is None else draw.claw_speed_across_m_s
        return 1.0 if speed is None else min(1.0, speed / self.task.claw.speed_across_m_s)

    def _generator(self, k: int) -> np.random.Generator:
        generator = self.generators[k]
        assert generator is not None
        return generator

    def step(self, actions: ArrayLike, columns: ArrayLike | None = None, *, direct: bool = False) -> StepResult:
        """One control interval under normalised claw commands.

        Args:
            actions: (m, 2), along and across the track; clipped to +-1, the share beyond is reported.
            columns: Which columns; None means all. Their episodes must be running.
            direct: They are commands whatever the task: a baseline that they would correct only looks on.

        Raises:
            ValueError: A command is not finite, or has the wrong shape.
            RuntimeError: An episode is over.
        """
        chosen = self.batch.columns(columns)
        if self.book.over[chosen].any():
            k = int(chosen[np.argmax(self.book.over[chosen])])
            raise RuntimeError(f"the episode of helicopter {k} is over or has not begun: reset it first")
        reading, saturation = self.moved(actions, chosen, direct)
        self.book.note(chosen, reading, saturation)
        return self._judged(chosen, reading, saturation)

    def moved(self, actions: ArrayLike, columns: Columns | None = None, direct: bool = False) -> tuple[Reading, Array]:
        """What a step begins with: one control interval of motion, read but not judged, noted or observed.

        Args:
            actions: As of `step`.
            columns: Which columns, (m,); None means all. Whether their episodes run is not looked at.
            direct: As of `step`.

        Returns:
            What can be read of the interval; share of each command that lay beyond +-1, (m,).
        """
        chosen = self.batch.columns(columns)
        commands, saturation = self._commands(actions, chosen, direct)
        previous = self.book.command[chosen]
        self.batch.advance(commands, columns)
        self.book.command[chosen] = commands
        self.book.steps[chosen] += 1
        telemetry, bad = columns_of(self.batch.telemetry, chosen)
        reading = self._reading(chosen, telemetry, bad | self.batch.diverged[chosen], previous)
        self.reading = reading
        self.book.held[chosen] = reading.held
        return reading, saturation

    def _commands(self, actions: ArrayLike, columns: Columns, direct: bool) -> tuple[Array, Array]:
        raw = np.asarray(actions, dtype=np.float64)
        if raw.shape != (columns.size, ACTIONS):
            raise ValueError(f"action: shape {raw.shape}, must be ({columns.size}, {ACTIONS})")
        if not np.isfinite(raw).all():
            i = int(np.argmin(np.isfinite(raw).all(axis=1)))
            raise ValueError(f"action of helicopter {int(columns[i])}: {raw[i].tolist()}, must be finite numbers")
        beyond = np.abs(raw) > 1.0
        wanted = np.clip(raw, -1.0, 1.0)
        if self._guide is not None:
            wanted = self._guide.commands(wanted, self.last, columns, direct)
        bound = self._bound[columns]
        return np.clip(wanted, -bound, bound), 0.5 * (beyond[:, 0].astype(np.float64) + beyond[:, 1])

    def _reading(self, columns: Columns, telemetry: Telemetry, broken: Flags, previous: Array) -> Reading:
        steps = self.book.steps[columns]
        return Reading(
            task=self.task, telemetry=telemetry, steps=steps, counted=steps > self.task.grace_steps,
            command=self.book.command[columns], previous=previous, held_before=self.book.held[columns],
            peak_before_N=self.book.peak_probe_N[columns], broken=broken, half_spread_m=self._half_spread,
            limit_steps=self.limit_steps,
        )  # fmt: skip

    def _judged(self, columns: Columns, reading: Reading, saturation: Array) -> StepResult:
        """Observation, reward, costs and endings of an interval."""
        margins = limits.margins(reading)
        costs = limits.costs(margins)
        conditions = limits.endings(reading, margins)
        reasons = np.full(columns.size, len(limits.REASONS))
        for grade, name in reversed(list(enumerate(conditions))):
            reasons[conditions[name]] = grade
        goal = limits.REASONS.index(limits.GOAL)
        terminated = reasons <= goal
        truncated = (reading.steps >= self.limit_steps) & ~terminated
        book = self.book
        progress, alignment = progress_potential(reading), alignment_potential(reading)
        gained = progress - book.progress[columns], alignment - book.alignment[columns]
        terms = rewards(reading, Outcome(*gained, success=reasons == goal, failure=reasons < goal))
        book.progress[columns], book.alignment[columns] = progress, alignment
        reward = total(terms, columns.size)
        cost = total(costs, columns.size)
        book.returned[columns] += reward
        book.cost[columns] += cost
        book.over[columns] = terminated | truncated
        scaled = self.observer.scaled(reading)
        self.sensors.read(columns, scaled)
        observation, clipped = self.observer.observation(scaled)
        self.last[columns] = observation
        result = StepResult(
            columns.copy(), observation, reward, terminated, truncated, cost, costs, margins, terms, saturation,
            clipped, reading.time_s,
        )  # fmt: skip
        for i in np.flatnonzero(terminated | truncated):
            name = limits.REASONS[reasons[i]] if terminated[i] else limits.TIME
            result.endings[int(columns[i])] = self._ending(int(columns[i]), reading, int(i), name)
        return result

    def _ending(self, k: int, reading: Reading, i: int, reason: str) -> dict[str, Any]:
        info: dict[str, Any] = {
            "reason": reason,
            "success": reason == limits.GOAL,
            "episode_metrics": {**self.book.metrics(k, reading, i, reason), **self._sea(k)},
        }
        if reason == limits.DIVERGENCE:
            start = self.task.lead_in_steps * self.batch.timing.substeps
            info["divergence"] = divergence(self.batch, k, start)
            if self.dump_dir is not None:
                info["divergence"]["dump"] = dump(self.dump_dir, self.batch, k, self.draws[k], dict(info["divergence"]))
        return info

    def _sea(self, k: int) -> dict[str, float | bool | None]:
        """How severe the sea of column k's episode is: metrics that no policy can change."""
        draw = self.draws[k]
        assert draw is not None
        return self.starter.decks.figures(draw).metrics()

    def change(
        self, scenario: Mapping[str, Any] | ScenarioConfig | None = None, reward: Mapping[str, Any] | None = None
    ) -> None:
        """Change what later episodes are drawn from, and what is rewarded from now on: stages of a curriculum.

        Args:
            scenario: Changes to the present scenario, or another one; what its claw and sensors may delay, and
                whether they are noisy, must stay within the first one's.
            reward: Weights of the reward to change.

        Raises:
            ConfigurationError: A key or value is refused; nothing has changed.
        """
        task = self.task
        if reward is not None:
            weights = {**task.reward.model_dump(), **reward}
            task = task.model_copy(update={"reward": validated(Reward, weights, "task: reward")})
        starter = self.starter
        if scenario is not None:
            changed = changed_scenario(self.scenario, scenario)
            starter = Starter(self.starter.helicopter, task, changed)
            room = self.batch.longest_delay_s, self.sensors.longest_delay_s, self.sensors.noisy
            check_room(changed, *room)
            self.scenario, self.starter = changed, starter
            self.sensors.serve(starter)
            self._nursery = Nursery(starter, self.n, self.threads)
        self.task = task

    # --- copies ------------------------------------------------------------------------------------------------

    def snapshot(self) -> BatchSnapshot:
        """Copy of the complete state: physics, counters, sensors, generators."""
        return BatchSnapshot(
            self.batch.snapshot(),
            self.book.snapshot(),
            self.sensors.snapshot(),
            copy.deepcopy(self.generators),
            copy.deepcopy(self.draws),
            self.last.copy(),
            {} if self._guide is None else self._guide.snapshot(),
        )

    def restore(self, snapshot: BatchSnapshot) -> None:
        """Return to a snapshot of this batch or of one made with the same arguments, bit for bit."""
        self.batch.restore(snapshot.physics)
        self.book.restore(snapshot.book)
        self.sensors.restore(snapshot.sensors)
        self.generators = copy.deepcopy(snapshot.generators)
        self.draws = copy.deepcopy(snapshot.draws)
        self.last = snapshot.last.copy()
        self._bound[:, 1] = [self._drive_share(k) for k in range(self.n)]
        if self._guide is not None:
            self._guide.restore(snapshot.guide)
        self._nursery.clear()

    def fork(self, k: int) -> TraverseBatch:
        """A new batch with every column repeated `k` times (column i becomes i k ... i k + k - 1), same future."""
        other = TraverseBatch(
            self.n * k, task=self.task, scenario=self.scenario, helicopter=self.starter.helicopter,
            threads=self.threads, dump_dir=self.dump_dir, max_episode_steps=self.limit_steps,
        )  # fmt: skip
        copies = np.repeat(np.arange(self.n), k)
        other.batch = self.batch.fork(k)
        other.book.restore(self.book.snapshot(), copies)
        other.sensors.restore(self.sensors.snapshot(), copies)
        other.generators = [copy.deepcopy(self.generators[i]) for i in copies]
        other.draws = [self.draws[i] for i in copies]
        other.last = self.last[copies]
        other._bound = self._bound[copies]
        if self._guide is not None and other._guide is not None:
            other._guide.restore(self._guide.snapshot(), copies)
        return other
