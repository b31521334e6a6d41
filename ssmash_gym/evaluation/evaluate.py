"""`evaluate.py`: policies on the same frozen seeds; table, intervals, plots and a film."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import polars as pl
import tyro
from rich.console import Console

import ssmash_gym
from ssmash_gym.document import listed
from ssmash_gym.envs.loading import names
from ssmash_gym.envs.scenario import ScenarioConfig, load_scenario
from ssmash_gym.envs.task import OF_AN_AGENT, load_task, observed_as
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes, share_of
from ssmash_gym.evaluation.film import film_episode, require_rendering
from ssmash_gym.evaluation.policies import Policy, baselines, find_agent, make_baseline, tuned_laws
from ssmash_gym.evaluation.report import (
    plot_peaks,
    require_matplotlib,
    sentences,
    severity_table,
    table,
)
from ssmash_gym.evaluation.study import StudyConfig, load_study
from ssmash_gym.evaluation.study_rows import STUDY, SUMMARY
from ssmash_gym.evaluation.study_verb import chosen_study, evaluate_study
from ssmash_gym.evaluation.summary import comparison, numbers, policy_summary
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.progress import Advance, progress_bar
from ssmash_gym.training.agent import Agent, fingerprint
from ssmash_gym.training.seeds import EVALUATION, block

AGAINST: Final = "trapezoid,hold,yield"
EPISODES: Final = 200
Agents = Annotated[tuple[str, ...], tyro.conf.UseAppendAction]


def evaluate(
    agent: Agents = (),
    against: str | None = None,
    episodes: int | None = None,
    seed: int | None = None,
    out: Path = Path("runs/evaluation"),
    scenario: Path | None = None,
    task: Path | None = None,
    threads: int | None = None,
    plots: bool = True,
    film: bool = True,
    study: str | None = None,
    conditions: str | None = None,
    report: Path | None = None,
) -> None:
    """Compare an agent with the baselines on the same frozen seeds, or run a whole study.

    Writes ``summary.json``, ``episodes.parquet`` (one row an episode and policy), ``peaks.png`` and ``episode.mp4``;
    of a study ``rows/*.parquet``, ``study.json`` and ``summary.json``. A study that was stopped is gone on with by the
    same command.

    Args:
        agent: Run folder, agent's folder, checkpoint, or name; baselines alone without it. In a study several may be
            given, also as NAME=FOLDER,FOLDER: several training seeds of one agent.
        against: Names of baselines, with commas: trapezoid,hold,yield by default; in a study all of its own.
        episodes: Episodes of each policy, 200 by default; in a study its own number, or fewer.
        seed: Chooses the block of seeds, 0 by default; no block holds a seed that training has seen.
        out: Folder for the results.
        scenario: Seas, winds and so on: YAML file or name; those the agent was trained in by default.
        task: The task: YAML file or name; the agent's own by default.
        threads: Threads of the simulation; the results do not depend on them.
        plots: Draw the plots (extra ``plot``).
        film: Film one episode of the agent (extra ``render``).
        study: Name of a study (standard, smoke) or its YAML file.
        conditions: Conditions of the study to run, with commas; all by default.
        report: Folder for a page with all figures and a film, of a study or of this comparison (extra ``report``).

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    agents = (agent,) if isinstance(agent, str) else tuple(agent or ())
    for option, given in (("--episodes", episodes), ("--threads", threads)):
        if given is not None and given < 1:
            raise ConfigurationError(f"{option} {given} is refused: at least 1.")
    if seed is not None and seed < 0:
        raise ConfigurationError(f"--seed {seed} is refused: it must not be negative.")
    if study is not None:
        refuse_beside_study({"--seed": seed, "--scenario": scenario, "--task": task})
        whole, name, part = chosen_study(study, against, conditions, episodes)
        evaluate_study(whole, name, agents, out, part=part, threads=threads, report=report, film=film)
        return
    one = only_agent(agents, conditions)
    others, count, number = against if against is not None else AGAINST, episodes or EPISODES, seed or 0
    if report is not None:
        of_words = plain_study(one, others, count, number, scenario, task)
        learned = () if one is None or one in baselines() else agents
        evaluate_study(of_words, "comparison", learned, out, threads=threads, report=report, film=film)
        return
    compare(one, others, count, number, out, scenario, task, threads, plots, film)


def only_agent(agents: Sequence[str], conditions: str | None) -> str | None:
    """The agent of a comparison that is no study.

    Raises:
        ConfigurationError: There are several, or conditions of a study are named.
    """
    if conditions is not None:
        raise ConfigurationError("--conditions is refused without --study: it names conditions of a study.")
    if len(agents) > 1:
        raise ConfigurationError("--agent is refused twice without --study: the comparison is of one agent.")
    return agents[0] if agents else None


def refuse_beside_study(options: dict[str, Any]) -> None:
    """Refuse options that a study's file answers.

    Raises:
        ConfigurationError: One is given.
    """
    for option, value in options.items():
        if value is not None:
            raise ConfigurationError(f"{option} {value} is refused with --study: the study's file says that.")


def plain_study(
    agent: str | None, against: str, episodes: int, seed: int, scenario: Path | None, task: Path | None
) -> StudyConfig:
    """The comparison of one agent with baselines as a study of one condition; the arguments are those of `evaluate`.

    Raises:
        ConfigurationError: A name, a file or a number is refused.
    """
    policies, seas, name = chosen(agent, against, scenario, task)
    scripted = [policy.name for policy in policies if not isinstance(policy, Agent)]
    judged = policies[0].task.model_dump(mode="json", exclude=set(OF_AN_AGENT))
    condition = {"scenario": seas.model_dump(mode="json"), "task": judged, "description": seas.description or name}
    place = re.sub(r"[^A-Za-z0-9_.-]+", "_", name)
    document = {
        "description": f"A comparison in the scenario {name}.",
        "seed": seed,
        "episodes": episodes,
        "conditions": {place: condition},
        "runs": [{"conditions": [place], "policies": scripted, "agents": True}],
        "roles": {"laws": [one for one in scripted if one in tuned_laws()], "clairvoyant": "clairvoyant"},
    }
    return load_study(document)


def compare(
    agent: str | None,
    against: str,
    episodes: int,
    seed: int,
    out: Path,
    scenario: Path | None,
    task: Path | None,
    threads: int | None,
    plots: bool,
    film: bool,
) -> None:
    """One policy against others on the same frozen seeds; the arguments are those of `evaluate`.

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: A library is missing; the sentence names the extra.
    """
    if (out / STUDY).is_file():
        raise ConfigurationError(f"--out {out} is refused: a study lies there, whose summary would be replaced.")
    if plots:
        require_matplotlib()
    if film and agent is not None:
        require_rendering()
    policies, seas, name = chosen(agent, against, scenario, task)
    console = Console()
    rows = run_all(policies, seas, block(seed, EVALUATION, episodes), threads)
    summary = summarised(policies, rows, seas, name, seed)
    write_results(out, summary, rows)
    shown = Console(width=max(console.width, 140)) if not console.is_terminal else console
    title = f"scenario {name}, {episodes} episodes, seed {seed}"
    shown.print(table(summary["policies"], title))
    shown.print(severity_table(summary["policies"]))
    if "comparison" in summary:
        for sentence in sentences(policies[0].name, summary["comparison"]):
            shown.print(sentence)
    if plots:
        plot_peaks(rows, policies[0].task.limits.probe_in_plane_kN, out / "peaks.png", title)
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
    others = list(dict.fromkeys(listed(against)))
    scripted = agent is None or agent in baselines()
    learned = None if scripted else find_agent(str(agent))
    base = load_task("traverse") if learned is None else learned.task
    common = base if task is None else observed_as(load_task(str(task)), base)
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


def run_all(
    policies: list[Policy], scenario: ScenarioConfig, seeds: list[int], threads: int | None
) -> dict[str, pl.DataFrame]:
    """Rows of episodes of each policy, by name."""
    rows: dict[str, pl.DataFrame] = {}
    with progress_bar("episodes", shown=Console(stderr=True).is_terminal) as advance:
        for k, policy in enumerate(policies):
            tell = functools.partial(_told, advance, policy.name, k, len(policies))
            counted = share_of(len(seeds) * policy.task.horizon_steps, tell)
            rows[policy.name] = run_episodes(policy, scenario, seeds, threads=threads, tell=counted)
    return rows


def _told(advance: Advance, name: str, number: int, policies: int, share: float) -> None:
    """Tell the bar of one policy under way."""
    advance((number + share) / policies, name)


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
    write_text(out / SUMMARY, json.dumps(summary, indent=1) + "\n")


def typical_seed(episodes: pl.DataFrame) -> int:
    """Seed of the episode whose peak probe load is nearest the median."""
    peak = numbers(episodes, "scored_peak_kN")
    return int(episodes["seed"][int(np.argmin(np.abs(peak - np.median(peak))))])
