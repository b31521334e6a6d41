"""`evaluate.py`: policies on the same frozen seeds; table, intervals, plots and a film."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

import ssmash_gym
from ssmash_gym.envs.loading import names
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation import report
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.film import film_episode, require_rendering
from ssmash_gym.evaluation.policies import Policy, baselines, find_agent, make_baseline
from ssmash_gym.evaluation.summary import comparison, numbers, policy_summary
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.training.agent import Agent, fingerprint
from ssmash_gym.training.seeds import EVALUATION, block


def evaluate(
    agent: str | None = None,
    against: str = "trapezoid,hold,yield",
    episodes: int = 200,
    seed: int = 0,
    out: Path = Path("runs/evaluation"),
    scenario: Path | None = None,
    task: Path | None = None,
    threads: int | None = None,
    plots: bool = True,
    film: bool = True,
) -> None:
    """Compare an agent with the baselines on the same frozen seeds.

    Writes ``summary.json``, ``episodes.parquet`` (one row an episode and policy), ``peaks.png`` and ``episode.mp4``.

    Args:
        agent: Run folder, agent's folder, checkpoint, or name; baselines alone without it.
        against: Names of baselines, with commas.
        episodes: Episodes of each policy.
        seed: Chooses the block of seeds; no block holds a seed that training has seen.
        out: Folder for the results.
        scenario: Seas, winds and so on: YAML file or name; those the agent was trained in by default.
        task: The task: YAML file or name; the agent's own by default.
        threads: Threads of the simulation; the results do not depend on them.
        plots: Draw the plots (extra ``plot``).
        film: Film one episode of the agent (extra ``render``).

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    if episodes < 1:
        raise ConfigurationError(f"--episodes {episodes} is refused: at least 1.")
    if seed < 0:
        raise ConfigurationError(f"--seed {seed} is refused: it must not be negative.")
    if plots:
        report.require_matplotlib()
    if film and agent is not None:
        require_rendering()
    policies, seas, name = chosen(agent, against, scenario, task)
    console = Console()
    seeds = block(seed, EVALUATION, episodes)
    rows = run_all(policies, seas, seeds, threads, console)
    summary = summarised(policies, rows, seas, name, seed)
    write_results(out, summary, rows)
    shown = Console(width=max(console.width, 140)) if not console.is_terminal else console
    title = f"scenario {name}, {episodes} episodes, seed {seed}"
    shown.print(report.table(summary["policies"], title))
    shown.print(report.severity_table(summary["policies"]))
    if "comparison" in summary:
        for sentence in report.sentences(policies[0].name, summary["comparison"]):
            shown.print(sentence)
    if plots:
        report.plot_peaks(rows, policies[0].task.limits.probe_in_plane_kN, out / "peaks.png", title)
    if film and agent is not None:
        film_episode(policies[0], seas, typical_seed(rows[policies[0].name]), out / "episode.mp4")
    console.print(f"results in {out}")


def chosen(
    agent: str | None, against: str, scenario: Path | None, task: Path | None
) -> tuple[list[Policy], ScenarioConfig, str]:
    """The policies, the agent first, the scenario and its name.

    Raises:
        ConfigurationError: A name or file is refused.
    """
    others = list(dict.fromkeys(name.strip() for name in against.split(",") if name.strip()))
    scripted = agent is None or agent in baselines()
    learned = None if scripted else find_agent(str(agent))
    base = load_task("traverse") if learned is None else learned.task
    common = base if task is None else with_observation(load_task(str(task)), base)
    policies: list[Policy] = []
    if learned is not None:
        policies.append(learned.within(common))
    elif agent is not None:
        others = [agent, *(name for name in others if name != agent)]
    policies += [make_baseline(name, common) for name in others]
    if not policies:
        raise ConfigurationError("there is nothing to evaluate: give --agent, or names in --against.")
    if scenario is not None:
        return policies, load_scenario(str(scenario)), Path(scenario).stem
    if learned is None:
        return policies, load_scenario("training"), "training"
    return policies, learned.scenario, scenario_name(learned)


def scenario_name(agent: Agent) -> str:
    """Name of the scenario that an agent was trained in: the package's, if it is one of those."""
    same = (name for name in names("scenarios") if load_scenario(name) == agent.scenario)
    return next(same, f"of {agent.name}")


def with_observation(task: TaskConfig, other: TaskConfig) -> TaskConfig:
    """The task, observed as in another one."""
    return task.model_copy(update={"observation": other.observation, "observation_clip": other.observation_clip})


def run_all(
    policies: list[Policy], scenario: ScenarioConfig, seeds: list[int], threads: int | None, console: Console
) -> dict[str, pl.DataFrame]:
    """Rows of episodes of each policy, by name."""
    progress = Progress(
        TextColumn("{task.description:>14}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"), TimeElapsedColumn(),
        console=console, disable=not console.is_terminal,
    )  # fmt: skip
    rows = {}
    with progress:
        for policy in policies:
            bar = progress.add_task(policy.name, total=len(seeds) * policy.task.horizon_steps)
            tell = lambda steps, bar=bar: progress.advance(bar, steps)  # noqa: E731
            rows[policy.name] = run_episodes(policy, scenario, seeds, threads=threads, tell=tell)
            progress.update(bar, completed=len(seeds) * policy.task.horizon_steps)
    return rows


def summarised(
    policies: list[Policy], rows: dict[str, pl.DataFrame], scenario: ScenarioConfig, name: str, seed: int
) -> dict[str, Any]:
    """The contents of ``summary.json``: ``policies``, ``comparison`` of the first with the others, and provenance."""
    first, *others = policies
    document: dict[str, Any] = {"policies": {policy: policy_summary(frame) for policy, frame in rows.items()}}
    if others:
        document["comparison"] = {other.name: comparison(rows[first.name], rows[other.name]) for other in others}
    document |= {
        "seed": seed,
        "version": ssmash_gym.__version__,
        "configuration": fingerprint(first.task, scenario),
        "scenario": name,
        "scenario_description": scenario.description,
    }
    if isinstance(first, Agent):
        document["agent"] = {key: first.about[key] for key in ("name", "configuration") if key in first.about}
        document["agent"]["steps"] = first.about.get("steps")
    return document


def write_results(out: Path, summary: dict[str, Any], rows: dict[str, pl.DataFrame]) -> None:
    """Write ``episodes.parquet`` and then ``summary.json``, each whole or not at all."""
    frames = [frame.select(pl.lit(name).alias("policy"), pl.all()) for name, frame in rows.items()]
    with whole_file(out / "episodes.parquet") as temporary:
        pl.concat(frames).write_parquet(temporary)
    write_text(out / "summary.json", json.dumps(summary, indent=1) + "\n")


def typical_seed(episodes: pl.DataFrame) -> int:
    """Seed of the episode whose peak probe load is nearest the median."""
    peak = numbers(episodes, "scored_peak_kN")
    return int(episodes["seed"][int(np.argmin(np.abs(peak - np.median(peak))))])
