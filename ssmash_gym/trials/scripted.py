"""Trials in virtual time: a program at the claw, through the same recorder as a person's trials.

Nobody takes part, and nothing here is a person's: the driver's name and the origin ``script`` in every file say so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.policies import Policy, attach
from ssmash_gym.evaluation.study_entrants import entrant
from ssmash_gym.trials.files import write_trial
from ssmash_gym.trials.recorder import TrialRecorder
from ssmash_gym.trials.session import Session
from ssmash_gym.trials.stamps import Stamp
from ssmash_gym.trials.trial import SCRIPT, Trial

OPERATOR: Final = "operator"
SCRIPTED_OPERATOR: Final = "scripted operator"  # its name in trials
MESSAGE_HZ: Final = 30.0  # virtual messages, as often as a page sends them
Told = Callable[[Trial, Path], None]


def run_scripted(
    what: Session | Condition,
    policy_name: str,
    seeds: Sequence[int] = (),
    folder: str | Path | None = None,
    *,
    most: int | None = None,
    told: Told = lambda trial, path: None,
) -> list[Path]:
    """Let a program drive the trials of a session, or trials of a condition by seed.

    Args:
        what: An open session, which says itself what comes next; or what is simulated.
        policy_name: ``operator``, another baseline or planner, or a trained agent.
        seeds: Of a condition's episodes; a session has its own.
        folder: For a condition's trials, one file each; a session has its own.
        most: So many trials of a session at most.
        told: Called after each trial with its file.

    Returns:
        The files, in the order of driving.

    Raises:
        ConfigurationError: There is no such policy, or it cannot drive this condition; nothing has been written.
    """
    if isinstance(what, Condition):
        if folder is None:
            raise ConfigurationError("trials of a condition need a folder.")
        return _by_seed(what, policy_for(policy_name, what), seeds, Path(folder), told)
    if seeds or folder is not None:
        raise ConfigurationError("a session has seeds and a folder of its own.")
    policy = policy_for(policy_name, what.condition)
    paths: list[Path] = []
    while (most is None or len(paths) < most) and (assignment := what.next()) is not None:
        trial = scripted_trial(what.condition, assignment.seed, policy, what.about(assignment))
        paths.append(what.keep(trial))
        told(trial, paths[-1])
    return paths


def _by_seed(condition: Condition, policy: Policy, seeds: Sequence[int], folder: Path, told: Told) -> list[Path]:
    paths = []
    for seed in seeds:
        trial = scripted_trial(condition, seed, policy)
        paths.append(folder / f"{policy.name}_{seed}.parquet")
        write_trial(paths[-1], trial)
        told(trial, paths[-1])
    return paths


def policy_for(name: str, condition: Condition) -> Policy:
    """A policy by name that can drive a condition.

    Raises:
        ConfigurationError: There is none of that name, or it was made for another task.
    """
    return entrant(name, condition.task).make(condition.task)


def driver_name(policy: str) -> str:
    """What the driver of a policy's trials is called; the operator model is never taken for a person."""
    return SCRIPTED_OPERATOR if policy == OPERATOR else policy


def scripted_trial(
    condition: Condition,
    seed: int,
    policy: Policy,
    about: dict[str, Any] | None = None,
    *,
    most_steps: int | None = None,
) -> Trial:
    """One trial of a policy in virtual time.

    Args:
        condition: What is simulated, as it is judged.
        seed: Of the episode.
        policy: At the claw; it observes in its own way. Told of the simulation where it has `attach`.
        about: As of `TrialRecorder`; the origin is the script.
        most_steps: The trial is broken off after so many.
    """
    batch = TraverseBatch(1, task=policy.task, scenario=condition.scenario, helicopter=condition.helicopter, threads=1)
    attach(policy, batch)
    observation = batch.reset(seeds=[seed])
    policy.reset(1)
    recorder = TrialRecorder(batch, condition, seed, {**(about or {}), "origin": SCRIPT})
    ended = False
    while not ended and (most_steps is None or len(recorder) < most_steps):
        stamp = virtual_stamp(driver_name(policy.name), len(recorder), batch.control_interval_s)
        result = batch.step(np.asarray(policy.act(observation)))
        observation, ended = result.observation, bool(result.endings)
        recorder.note(result, stamp)
    return recorder.trial(complete=ended)


def virtual_stamp(driver: str, steps: int, interval_s: float) -> Stamp:
    """The stamp of a step in virtual time: the newest of `MESSAGE_HZ` messages a second, read when the step is due."""
    due_s = steps * interval_s
    sequence = math.floor(due_s * MESSAGE_HZ + 1e-9)
    sent_s = sequence / MESSAGE_HZ
    return Stamp(driver, "", sequence, 1e3 * sent_s, sent_s, due_s, due_s, False, steps - 1)
