"""Runs policies through the same frozen episodes, all of them side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, Protocol

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.limits import LIMITS, failed
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.step import StepResult
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.evaluation.policies import Policy, attach
from ssmash_gym.vehicle import Helicopter

OF_A_SEA: Final = ("sea_hs_m", "sea_heading_deg", "sea_speed_kn")  # numbers in every row, or missing in all
LARGEST_BATCH: Final = 256  # helicopters at once; an episode's result does not depend on it


class Watch(Protocol):
    """What looks on while episodes are driven, and adds numbers to their rows."""

    def note(self, result: StepResult) -> None:
        """Called after each control interval."""

    def row(self, k: int) -> dict[str, Any]:
        """What it adds to the row of column k, whose episode has ended."""


class Exceeded:
    """Counts the control intervals in which a limit was exceeded.

    Args:
        count: Episodes, one a column.
    """

    def __init__(self, count: int) -> None:
        self._counts = {name: np.zeros(count, dtype=np.int64) for name in LIMITS}

    def note(self, result: StepResult) -> None:
        """Called after each control interval."""
        for name, costs in result.costs.items():
            self._counts[name][result.columns] += costs > 0.0

    def row(self, k: int) -> dict[str, int]:
        """The counts of column k, by limit."""
        return {name: int(count[k]) for name, count in self._counts.items()}


def run_episodes(
    policy: Policy,
    scenario: ScenarioConfig,
    seeds: Sequence[int],
    *,
    helicopter: str | Helicopter = "generic_tricycle",
    threads: int | None = None,
    tell: Callable[[int], None] = lambda steps: None,
    watch: Callable[[TraverseBatch], Watch] | None = None,
) -> pl.DataFrame:
    """One episode a seed.

    Args:
        policy: What drives the claw; its task is the task. Where it has `attach`, it is told of the simulation.
        scenario: What episodes are drawn from.
        seeds: One an episode: the same seed is the same sea, helicopter and start for every policy.
        helicopter: Name, or ready-made.
        threads: Workers; the result does not depend on them.
        tell: Called after each control interval with the number of helicopters that took it.
        watch: Given each batch of episodes that have just begun, it makes what looks on; None: nothing does.

    Returns:
        One row an episode: ``seed``, the metrics of the environment (the severity of its sea among them), ``failed``
        (ended by anything but goal or time), ``scored_peak_kN`` (the peak probe load, or the ultimate load where it
        failed), for each limit ``cost_NAME`` (control intervals in which it was exceeded), and ``over_limit_s`` (time
        with a probe load above its limit; where the environment does not tell it, all of each such interval).
    """
    rows: list[dict[str, Any]] = []
    for first in range(0, len(seeds), LARGEST_BATCH):
        rows += _run_batch(policy, scenario, seeds[first : first + LARGEST_BATCH], helicopter, threads, tell, watch)
    return numbered(rows)


def numbered(rows: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Rows of episodes as a table."""
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
    watch: Callable[[TraverseBatch], Watch] | None,
) -> list[dict[str, Any]]:
    batch = TraverseBatch(len(seeds), task=policy.task, scenario=scenario, helicopter=helicopter, threads=threads)
    attach(policy, batch)
    observations = batch.reset(seeds=list(seeds))
    exceeded = Exceeded(len(seeds))
    also = None if watch is None else watch(batch)

    def note(result: StepResult) -> None:
        exceeded.note(result)
        if also is not None:
            also.note(result)
        tell(int(result.columns.size))

    found = drive(policy, batch, observations, note)
    return [
        episode_row(seed, found[k], exceeded.row(k), policy.task) | ({} if also is None else also.row(k))
        for k, seed in enumerate(seeds)
    ]


def episode_row(seed: int, metrics: dict[str, Any], exceeded: dict[str, int], task: TaskConfig) -> dict[str, Any]:
    """The row of an episode, see `run_episodes`.

    Args:
        seed: Of the episode.
        metrics: The environment's.
        exceeded: As of `Exceeded.row`.
        task: As the episode is judged.
    """
    lost = failed(metrics["reason"])
    peak_kN = task.limits.probe_ultimate_kN if lost else metrics["peak_probe_kN"]
    counts = {f"cost_{name}": count for name, count in exceeded.items()}
    over_s = metrics.get("over_limit_s", exceeded["probe_in_plane"] * task.control_interval_s)
    scored = {"failed": lost, "scored_peak_kN": float(peak_kN), "over_limit_s": float(over_s)}
    return {"seed": seed, **metrics, **scored, **counts}
