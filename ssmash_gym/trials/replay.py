"""A trial simulated once more, from its seed and its applied commands: it must give the same bits."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssmash_gym.dynamics.cache import fingerprint
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.envs.step import StepResult
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.trials.trial import SIMULATED, Trial, simulated, sources

Note = Callable[[TraverseBatch, StepResult], None]


@dataclass(frozen=True)
class Replay:
    """What became of a trial that was simulated once more.

    Attributes:
        agrees: Whether every step, and the metrics, came out the same bit for bit.
        where: What differs first, with the step; empty where all agrees.
        metrics: Of the episode, as they are now; None where it does not come to its end.
        code: What has changed since it was recorded: sources, or libraries and processor; empty where nothing has.
        elsewhere: Whether the sources are the same, but libraries or processor are not: then the last bits, which
            are promised for one machine only, may differ, and nothing else.
    """

    agrees: bool
    where: str
    metrics: dict[str, Any] | None
    code: str = ""
    elsewhere: bool = False

    @property
    def words(self) -> str:
        """The outcome in one sentence, without a full stop."""
        if self.agrees:
            return "agrees bit for bit" + (f", although {self.code}" if self.code else "")
        return f"does not agree: {self.where}" + (f"; {self.code}" if self.code else "")


def batch_of(trial: Trial, task: TaskConfig | None = None) -> TraverseBatch:
    """A batch of the trial's condition at the start of its episode, to be driven once more.

    Args:
        trial: The trial.
        task: Its task under other eyes; None: as it was judged.

    Raises:
        ConfigurationError: This version of the package does not take the condition or the draw.
    """
    condition = trial.condition
    batch = TraverseBatch(
        1, task=task or condition.task, scenario=condition.scenario, helicopter=condition.helicopter, threads=1
    )
    given = None if trial.about["draw_of_seed"] else [EpisodeDraw.from_dict(trial.about["draw"])]
    batch.reset(seeds=[trial.seed], draws=given)
    return batch


def replay(trial: Trial, note: Note | None = None, batch: TraverseBatch | None = None) -> Replay:
    """Simulate a trial once more.

    Args:
        trial: The trial.
        note: Called with the batch and the result after each control step.
        batch: As of `batch_of`, at the start; None makes one.

    Raises:
        ConfigurationError: This version of the package does not take the condition or the draw.
    """
    batch = batch_of(trial) if batch is None else batch
    code = changed(trial)
    draw = batch.draws[0]
    where = _other_configuration(trial)
    if not where and (draw is None or not _same(draw.to_dict(), trial.about["draw"])):
        where = "the seed draws another episode"
    recorded = {name: trial.table[name].to_numpy() for name in SIMULATED}
    saturation = trial.table["saturation"].to_list()
    metrics: dict[str, Any] | None = None
    for k, command in enumerate(trial.commands):
        if metrics is not None:
            where = where or f"the episode ends at step {k}, but {trial.steps} steps were recorded"
            break
        batch.book.saturation[0] += saturation[k]  # of what was asked for: the applied command never exceeds 1
        result = batch.step(command[None])
        where = where or _difference(batch, result, recorded, command, k)
        if note is not None:
            note(batch, result)
        if 0 in result.endings:
            metrics = dict(result.endings[0]["episode_metrics"])
    if trial.complete:
        where = where or _other_metrics(metrics, trial.metrics)
    return Replay(not where, where, metrics, code, trial.about["sources"] == sources() and bool(code))


def changed(trial: Trial) -> str:
    """What has changed since a trial was recorded; empty where nothing has."""
    if trial.about["sources"] != sources():
        return f"it was recorded with other sources of the simulation (version {trial.about['version']})"
    if trial.about["code"] != fingerprint():
        return "it was recorded with other versions of libraries or on another processor"
    return ""


def _other_configuration(trial: Trial) -> str:
    """Whether the configuration's hash in the record is another one than that of the condition beside it."""
    told, own = trial.about["configuration"], trial.condition.configuration
    return "" if told == own else f"its configuration is called {told}, but what was simulated is {own}"


def _difference(batch: TraverseBatch, result: StepResult, recorded: dict[str, Any], command: Any, k: int) -> str:
    """Which column of row k differs first from the present step; empty where none does."""
    applied = batch.book.command[0]
    if applied.tobytes() != np.ascontiguousarray(command).tobytes():
        return f"step {k + 1}: the command cannot be applied as it was"
    now = simulated(batch.batch.state[:, 0], batch.telemetry, float(result.reward[0]))
    for name in SIMULATED:
        old = recorded[name][k]
        if old.tobytes() != old.dtype.type(now[name]).tobytes():
            return f"step {k + 1} ({float(result.time_s[0]):.1f} s): {name}"
    return ""


def _other_metrics(now: dict[str, Any] | None, recorded: dict[str, Any] | None) -> str:
    """Which metric differs; empty where none does."""
    if now is None or recorded is None:
        return "the episode does not come to its end"
    for name in recorded:
        if name not in now or not _same(now[name], recorded[name]):
            return f"the metric {name} is {now.get(name)}, recorded is {recorded[name]}"
    return ""


def _same(a: Any, b: Any) -> bool:
    """Whether two values of JSON are the same, bit for bit where they are numbers."""
    return json.dumps(a, sort_keys=True) == json.dumps(b, sort_keys=True)
