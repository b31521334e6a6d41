"""Runs some episodes of a window: the same function in a thread, in a process, or on another machine.

A chunk is a list of (cell, sea) and the policies that meet them. Each sea is drawn, baked and brought to its start
once, and every policy starts from there: same numbers as alone, in less time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
import polars as pl

import ssmash_gym
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.limits import failed
from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig
from ssmash_gym.envs.step import StepResult
from ssmash_gym.evaluation.conditions import digest
from ssmash_gym.evaluation.episodes import OF_A_SEA, drive
from ssmash_gym.evaluation.policies import Policy, attach
from ssmash_gym.evaluation.study_entrants import Entrant, code
from ssmash_gym.simulation.snapshot import moving, rewind
from ssmash_gym.windows.cells import Grid, Setting
from ssmash_gym.windows.peaks import PeakBook

KEYS: Final = ("stage", "policy", "cell", "number")  # what an episode is, in a window of one configuration
Tell = Callable[[int], None]  # told how many control intervals have just been simulated


@dataclass(frozen=True)
class Chunk:
    """Episodes that are run together.

    Attributes:
        stage: Of all of them.
        policies: Names; each meets all of the seas.
        cells: Cell of each sea.
        numbers: Its number among the window's seas.
    """

    stage: str
    policies: tuple[str, ...]
    cells: tuple[int, ...]
    numbers: tuple[int, ...]

    @property
    def episodes(self) -> int:
        """How many rows it gives."""
        return len(self.cells) * len(self.policies)

    @property
    def name(self) -> str:
        """Of its file: the same episodes, the same name."""
        return f"{self.stage}-{digest(self.stage, self.policies, self.cells, self.numbers)}"


@dataclass(frozen=True, eq=False)
class Job:
    """All that a worker needs to run chunks of a window; can be pickled, and is equal to its copies.

    Attributes:
        grid: The cells.
        settings: The stages, by name.
        entrants: The policies, by stage and name.
        seeds: Episode seeds of the seas.
        size: Seas at once, at most.
    """

    grid: Grid
    settings: dict[str, Setting]
    entrants: dict[str, dict[str, Entrant]]
    seeds: tuple[int, ...]
    size: int

    @cached_property
    def identity(self) -> str:
        """Hash of everything."""
        makes = {s: {name: one.identity for name, one in those.items()} for s, those in self.entrants.items()}
        stages = {name: one.configuration for name, one in self.settings.items()}
        axes = {name: list(values) for name, values in self.grid.axes.items()}
        return digest(makes, stages, axes, list(self.seeds), self.size)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Job) and other.identity == self.identity

    def __hash__(self) -> int:
        return hash(self.identity)

    def most_steps(self, chunk: Chunk) -> int:
        """Control intervals of a chunk, at most."""
        return chunk.episodes * self.settings[chunk.stage].task.horizon_steps

    def configuration(self, stage: str, policy: str) -> str:
        """Hash of all that rows depend on besides their cell and seed: others are not mixed with them."""
        entrant, setting = self.entrants[stage][policy], self.settings[stage]
        return digest(entrant.identity, setting.configuration, ssmash_gym.__version__)


class Worker:
    """Runs chunks one after the other, in one thread.

    Args:
        job: The window.
    """

    def __init__(self, job: Job) -> None:
        self._job = job
        self._crew: _Crew | None = None  # of one stage at a time: it needs much memory
        self._scenarios: dict[tuple[str, int], ScenarioConfig] = {}

    def run(self, chunk: Chunk, tell: Tell = lambda steps: None) -> pl.DataFrame:
        """The rows of a chunk, one an episode; they do not depend on how episodes are put into chunks."""
        if self._crew is None or self._crew.stage != chunk.stage:
            self._crew = None
            self._crew = _Crew(self._job, chunk.stage)
        draws = [self._draw(chunk.stage, cell, n) for cell, n in zip(chunk.cells, chunk.numbers, strict=True)]
        found = self._crew.run(chunk.policies, draws, tell)
        return pl.concat([self._rows(chunk, policy, rows) for policy, rows in found.items()])

    def _draw(self, stage: str, cell: int, number: int) -> EpisodeDraw:
        """The episode that an environment with the cell's scenario and the same seed would draw."""
        key = stage, cell
        if key not in self._scenarios:
            if len(self._scenarios) > self._job.size:
                self._scenarios.clear()
            self._scenarios[key] = self._job.settings[stage].of(self._job.grid.cell(cell))
        seed = np.random.SeedSequence(self._job.seeds[number])
        return self._scenarios[key].sample(np.random.Generator(np.random.PCG64(seed)))

    def _rows(self, chunk: Chunk, policy: str, rows: list[dict[str, Any]]) -> pl.DataFrame:
        """Rows of one policy with what they are in front."""
        places = [self._job.grid.cell(cell) for cell in chunk.cells]
        frame = pl.DataFrame(rows, schema_overrides=dict.fromkeys(OF_A_SEA, pl.Float64))
        count = len(rows)
        return pl.DataFrame(
            {
                "stage": [chunk.stage] * count,
                "policy": [policy] * count,
                "cell": pl.Series(chunk.cells, dtype=pl.Int64),
                **{name: [place[name] for place in places] for name in self._job.grid.axes},
                "number": pl.Series(chunk.numbers, dtype=pl.Int64),
                "seed": pl.Series([self._job.seeds[n] for n in chunk.numbers], dtype=pl.Int64),
                **{name: frame[name] for name in frame.columns},
                "configuration": [self._job.configuration(chunk.stage, policy)] * count,
                "version": [ssmash_gym.__version__] * count,
                "code": [code()] * count,
            }
        )


class _Crew:
    """The policies of a stage, and helicopters for them: all drive the same ones, one after the other.

    A planner looks at the whole batch that it is attached to, so it gets one of its own for each chunk.
    """

    def __init__(self, job: Job, stage: str) -> None:
        self.stage = stage
        self._setting = job.settings[stage]
        self._policies: dict[str, Policy] = {
            name: entrant.make(self._setting.task) for name, entrant in job.entrants[stage].items()
        }
        self._cores: dict[str, TraverseBatch] = {}
        first: TraverseBatch | None = None
        for name, policy in self._policies.items():
            if not hasattr(policy, "attach"):
                self._cores[name] = self._core(policy, job.size, first)
                first = first or self._cores[name]

    def _core(self, policy: Policy, count: int, beside: TraverseBatch | None = None) -> TraverseBatch:
        return TraverseBatch(
            count, task=policy.task, scenario=self._setting.scenario, helicopter=self._setting.helicopter, threads=1,
            beside=beside,
        )  # fmt: skip

    def run(self, policies: Sequence[str], draws: Sequence[EpisodeDraw], tell: Tell) -> dict[str, list[dict[str, Any]]]:
        """Each policy through the same episodes; a row for each of them."""
        found = {}
        start = None
        for name in policies:
            policy = self._policies[name]
            if name not in self._cores:
                core = self._core(policy, len(draws))
                found[name] = _episodes(policy, core, core.begin(draws), tell)
                continue
            core = self._cores[name]
            if start is not None:
                rewind(core.batch, start)
            observations = core.begin(draws, started=start is not None)
            if start is None and len(policies) > 1:
                start = moving(core.batch)
            found[name] = _episodes(policy, core, observations, tell)
        return found


def _episodes(policy: Policy, core: TraverseBatch, observations: Any, tell: Tell) -> list[dict[str, Any]]:
    """Metrics and peaks of episodes that stand at their start."""
    attach(policy, core)
    book = PeakBook(core, len(observations))

    def note(result: StepResult) -> None:
        assert core.reading is not None
        book.note(core.reading, result.columns)
        tell(int(result.columns.size))

    metrics = drive(policy, core, observations, note)
    peaks = book.columns()
    return [
        {**metrics[k], "failed": failed(metrics[k]["reason"]), **{name: float(v[k]) for name, v in peaks.items()}}
        for k in range(len(observations))
    ]
