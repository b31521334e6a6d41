"""Short trials for the tests: any commands, broken off after some steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.trials import Stamp, Trial, TrialRecorder
from ssmash_gym.vehicle import load_helicopter


def condition(scenario: Any = "ss5", task: Any = "traverse") -> Condition:
    return Condition("test", "", load_task(task), load_scenario(scenario), load_helicopter("generic_tricycle"))


def batch_for(what: Condition, task: Any = None) -> TraverseBatch:
    return TraverseBatch(1, task=task or what.task, scenario=what.scenario, helicopter=what.helicopter, threads=1)


def recorded(
    what: Condition,
    seed: int,
    commands: Any,
    *,
    batch: TraverseBatch | None = None,
    about: Mapping[str, Any] | None = None,
    draws: Any = None,
    late: int = 0,
) -> Trial:
    """A trial under these commands; broken off where they end before the episode does."""
    core = batch or batch_for(what)
    core.reset(seeds=[seed], draws=draws)
    recorder = TrialRecorder(core, what, seed, about or {})
    ended = False
    for k, command in enumerate(commands):
        due = k * core.control_interval_s
        result = core.step(np.asarray(command, dtype=np.float64)[None], direct=True)
        recorder.note(result, Stamp("person", "keyboard", k, 1e3 * due, due - 0.01, due, due, k < late, k - 2))
        ended = bool(result.endings)
        if ended:
            break
    return recorder.trial(complete=ended)
