"""Recorded trials for tests: short, scripted, of a sea that costs little."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.given import as_helicopter
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.trials.files import write_trial
from ssmash_gym.trials.recorder import TrialRecorder
from ssmash_gym.trials.stamps import Stamp
from ssmash_gym.trials.trial import Trial

SEEDS = (11, 12, 13)
PRACTICE_SEED = 10


def short(horizon_s: float = 3.0, scenario: str = "calm") -> Condition:
    """A traverse that is broken off by its time limit after a few seconds."""
    task = load_task({"base": "traverse", "horizon_s": horizon_s})
    return Condition("short", "", task, load_scenario(scenario), as_helicopter("generic_tricycle"))


def drive(
    condition: Condition,
    seed: int,
    *,
    policy: str = "operator",
    driver: str = "scripted operator",
    steps: int | None = None,
    late: bool = False,
    **about: Any,
) -> Trial:
    """One recorded trial; broken off after so many steps."""
    by = make_baseline(policy, condition.task)
    batch = TraverseBatch(
        1, task=condition.task, scenario=condition.scenario, helicopter=condition.helicopter, threads=1
    )
    observations = batch.reset(seeds=[seed])
    by.reset(1)
    recorder = TrialRecorder(batch, condition, seed, {"origin": "script", **about})
    while not batch.book.over[0] and len(recorder) != steps:
        result = batch.step(by.act(observations))
        observations = result.observation
        recorder.note(result, Stamp(driver=driver, late=late))
    return recorder.trial(complete=bool(batch.book.over[0]))


def session(number: int, phase: str = "scored") -> dict[str, Any]:
    """A trial's place in a session."""
    return {"number": number, "of": len(SEEDS) + 1, "phase": phase, "id": "test"}


def write_session(
    folder: Path, participant: str, condition: Condition, policy: str = "operator", seeds: Sequence[int] = SEEDS
) -> None:
    """A practice trial, and a scored one in each sea."""
    phases = [(PRACTICE_SEED, "practice"), *((seed, "scored") for seed in seeds)]
    for k, (seed, phase) in enumerate(phases):
        trial = drive(
            condition, seed, policy=policy, participant=participant, session=session(k + 1, phase),
            started_utc=f"2026-01-01T00:{k:02d}:00Z",
        )  # fmt: skip
        write_trial(folder / participant / f"{k}.parquet", trial)
