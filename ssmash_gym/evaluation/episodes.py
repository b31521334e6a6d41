"""Runs policies through the same frozen episodes, all of them side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.limits import LIMITS, failed
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.step import StepResult
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.evaluation.policies import Policy
from ssmash_gym.vehicle import Helicopter

OF_A_SEA: Final = ("sea_hs_m", "sea_heading_deg", "sea_speed_kn")  # numbers in every row, or missing in all
LARGEST_BATCH: Final = 256  # helicopters at once; an episode's result does not depend on it


def run_episodes(
    policy: Policy,
    scenario: ScenarioConfig,
    seeds: Sequence[int],
    *,
    helicopter: str | Helicopter = "generic_tricycle",
    threads: int | None = None,
    tell: Callable[[int], None] = lambda steps: None,
) -> pl.DataFrame:
    """One episode a seed.

    Args:
        policy: What drives the claw; its task is the task. Where it has `attach`, it is told of the simulation.
        scenario: What episodes are drawn from.
        seeds: One an episode: the same seed is the same sea, helicopter and start for every policy.
        helicopter: Name, or ready-made.
        threads: Workers; the result does not depend on them.
        tell: Called after each control interval with the number of helicopters that took it.

    Returns:
        One row an episode: ``seed``, the metrics of the environment (the severity of its sea among them), ``failed``
        (ended by anything but goal or time), ``scored_peak_kN`` (the peak probe load, or the ultimate load where it
        failed), for each limit ``cost_NAME`` (control intervals in which it was exceeded), and ``over_limit_s`` (time
        with a probe load above its limit; where the environment does not tell it, all of each such interval).
    """
    rows: list[dict[str, Any]] = []
    for first in range(0, len(seeds), LARGEST_BATCH):
        rows += _run_batch(policy, scenario, seeds[first : first + LARGEST_BATCH], helicopter, threads, tell)
    return pl.DataFrame(rows, schema_overrides=dict.fromkeys(OF_A_SEA, pl.Float64))


def drive(
    policy: Policy,
    batch: TraverseBatch,
    observations: NDArray[np.float32],
    note: Callable[[StepResult], None] = lambda result: None,
) -> dict[int, dict[str, Any]]:
    """Drive episodes that have just begun in the first columns of a batch to their ends.

    Args:
        policy: What drives the claw.
        batch: The episodes; `TraverseBatch.step` is called for those that still run.
        observations: Their first ones, (m, size); overwritten.
        note: Called after each control interval.

    Returns:
        The metrics of each episode, by column.
    """
    policy.reset(len(observations))
    found: dict[int, dict[str, Any]] = {}
    running = np.arange(len(observations))
    while running.size:
        actions = policy.act(observations)  # of all rows: a policy may remember each
        result = batch.step(actions[running], running)
        observations[running] = result.observation
        found |= {k: ending["episode_metrics"] for k, ending in result.endings.items()}
        note(result)
        running = running[~(result.terminated | result.truncated)]
    return found


def share_of(most: int, tell: Callable[[float], None]) -> Callable[[int], None]:
    """A function that adds up control intervals and tells the share of `most` that they are."""
    taken = 0

    def add(steps: int) -> None:
        nonlocal taken
        taken += steps
        tell(taken / most)

    return add


def _run_batch(
    policy: Policy,
    scenario: ScenarioConfig,
    seeds: Sequence[int],
    helicopter: str | Helicopter,
    threads: int | None,
    tell: Callable[[int], None],
) -> list[dict[str, Any]]:
    batch = TraverseBatch(len(seeds), task=policy.task, scenario=scenario, helicopter=helicopter, threads=threads)
    attach = getattr(policy, "attach", None)
    if attach is not None:
        attach(batch)
    observations = batch.reset(seeds=list(seeds))
    exceeded = {name: np.zeros(len(seeds), dtype=np.int64) for name in LIMITS}

    def note(result: StepResult) -> None:
        for name, costs in result.costs.items():
            exceeded[name][result.columns] += costs > 0.0
        tell(int(result.columns.size))

    found = drive(policy, batch, observations, note)
    return [
        _row(seed, found[k], {name: int(count[k]) for name, count in exceeded.items()}, policy.task)
        for k, seed in enumerate(seeds)
    ]


def _row(seed: int, metrics: dict[str, Any], exceeded: dict[str, int], task: TaskConfig) -> dict[str, Any]:
    lost = failed(metrics["reason"])
    peak_kN = task.limits.probe_ultimate_kN if lost else metrics["peak_probe_kN"]
    counts = {f"cost_{name}": count for name, count in exceeded.items()}
    over_s = metrics.get("over_limit_s", exceeded["probe_in_plane"] * task.control_interval_s)
    scored = {"failed": lost, "scored_peak_kN": float(peak_kN), "over_limit_s": float(over_s)}
    return {"seed": seed, **metrics, **scored, **counts}
