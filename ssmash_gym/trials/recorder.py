"""Records an episode while it is driven: every applied command, its stamps, and what the simulation made of it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import polars as pl

import ssmash_gym
from ssmash_gym.dynamics.cache import fingerprint
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import EpisodeDraw, ScenarioConfig
from ssmash_gym.envs.starts import prepared
from ssmash_gym.envs.step import StepResult
from ssmash_gym.envs.task import PERCEIVED, TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.trials.stamps import Stamp, timing_of
from ssmash_gym.trials.trial import COLUMNS, FORMAT, FREE, KIND, PAGE, Trial, bare, record_of, simulated, sources

ALLOWED_LATE_SHARE: Final = 0.02  # assumed; a session's protocol has its own


class TrialRecorder:
    """Records column 0 of a batch from the start of an episode.

    Args:
        batch: Has just been reset with the seed. Its task may be a policy's: what is observed and what an action
            corrects do not matter, for the applied commands are recorded.
        condition: What is simulated, as it is judged.
        seed: Of the episode.
        about: What only the caller knows: ``participant``, ``session``, ``origin``, ``started_utc``, and
            ``allowed_late_share`` of the steps; further keys are kept as they are.

    Raises:
        ConfigurationError: The batch is not one of that condition.
        ValueError: The episode has not just begun.
    """

    def __init__(self, batch: TraverseBatch, condition: Condition, seed: int, about: Mapping[str, Any]) -> None:
        _check(batch, condition)
        draw = batch.draws[0]
        if draw is None or batch.book.over[0] or batch.book.steps[0]:
            raise ValueError("a recording starts at the start of an episode: reset the batch first")
        self._batch = batch
        self._rows: list[dict[str, Any]] = []
        self._stamps: list[Stamp] = []
        self._metrics: dict[str, Any] | None = None
        given = dict(about)
        self._allowed_late_share = float(given.pop("allowed_late_share", ALLOWED_LATE_SHARE))
        judged = bare(condition)
        self._about: dict[str, Any] = {
            "participant": "",
            "session": {"number": 0, "of": 0, "phase": FREE, "id": ""},
            "origin": PAGE,
            "started_utc": "",
            **given,
            "kind": KIND,
            "format": FORMAT,
            "version": ssmash_gym.__version__,
            "code": fingerprint(),
            "sources": sources(),
            "configuration": judged.configuration,
            "condition": record_of(judged),
            "seed": int(seed),
            "draw": draw.to_dict(),
            "draw_of_seed": drawn(condition.scenario, seed) == draw,
        }

    def __len__(self) -> int:
        """Control steps recorded so far."""
        return len(self._rows)

    def note(self, result: StepResult, stamp: Stamp) -> None:
        """Record a control step.

        Args:
            result: What the batch's step gave; read at once, before the next step.
            stamp: Who commanded it, and when.

        Raises:
            ValueError: It is not the next step of the episode, or the episode had ended.
        """
        batch = self._batch
        if self._metrics is not None or 0 not in result.columns or batch.book.steps[0] != len(self._rows) + 1:
            raise ValueError("every step of one episode must be noted once, in its order")
        row = int(np.flatnonzero(result.columns == 0)[0])
        along, across = batch.book.command[0].tolist()
        self._rows.append(
            {
                "step": len(self._rows) + 1,
                "time_s": float(result.time_s[row]),
                "command_along": along,
                "command_across": across,
                "saturation": float(result.saturation[row]),
                **vars(stamp),
                **simulated(batch.batch.state[:, 0], batch.telemetry, float(result.reward[row])),
            }
        )
        self._stamps.append(stamp)
        if 0 in result.endings:
            self._metrics = dict(result.endings[0]["episode_metrics"])

    def trial(self, *, complete: bool) -> Trial:
        """What has been recorded so far.

        Args:
            complete: Whether the episode has come to its own end; not so when it was broken off.

        Raises:
            ValueError: It is to be complete, but has not ended.
        """
        if complete and self._metrics is None:
            raise ValueError("the episode has not ended: the trial is not complete")
        timing = timing_of(self._stamps, self._batch.control_interval_s, self._allowed_late_share)
        metrics = self._metrics if complete else None
        about = {**self._about, "timing": timing, "complete": complete, "metrics": metrics}
        columns = {name: [row[name] for row in self._rows] for name in COLUMNS}
        return Trial(pl.DataFrame(columns, schema=dict(COLUMNS)), json.loads(json.dumps(about)))


def drawn(scenario: ScenarioConfig, seed: int) -> EpisodeDraw:
    """The episode that a reset with this seed draws."""
    return scenario.sample(np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed))))


def _check(batch: TraverseBatch, condition: Condition) -> None:
    """Refuse a batch that does not simulate the condition."""
    parts = {
        "task": (_judged(batch.task), _judged(condition.task)),
        "scenario": (batch.scenario, condition.scenario),
        "helicopter": (batch.starter.helicopter, prepared(condition.helicopter, condition.task)),
        "horizon": (batch.limit_steps, condition.task.horizon_steps),
    }
    for name, (own, wanted) in parts.items():
        if own != wanted:
            raise ConfigurationError(
                f"a recording of the condition {condition.name!r} is refused: the batch simulates another {name}."
            )


def _judged(task: TaskConfig) -> dict[str, Any]:
    """A task without what a policy perceives, and without words about it."""
    return task.model_dump(exclude={*PERCEIVED, "description"})
