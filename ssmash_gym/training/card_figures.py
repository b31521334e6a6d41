"""The figures of an agent for its card, taken from the folder of a study in which it took part."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.statistics import median, p95
from ssmash_gym.evaluation.study_entrants import agent_entrants
from ssmash_gym.evaluation.study_rows import STUDY, SUMMARY, read_rows
from ssmash_gym.evaluation.summary import bands, numbers

SHARED: Final = ("study", "seed", "versions", "configuration", "level", "resamples")  # of the summary


@dataclass(frozen=True)
class Figures:
    """What a study says about an agent.

    Attributes:
        policy: What the agent is called there; several training seeds share it.
        training_seed: That of the agent at hand.
        shared: About the whole study, `SHARED`.
        main: Name of the main condition.
        conditions: For each the figures of its policies (see `ssmash_gym.evaluation.study_figures`), by name, with
            ``description``, the ``best_law`` beside the agent, and its ``own`` figures: of this training seed alone.
        targets: The project's aims, as far as they were checked for the agent.
        roles: Which policy stands for what.
    """

    policy: str
    training_seed: int | None
    shared: Mapping[str, Any]
    main: str
    conditions: Mapping[str, Mapping[str, Any]]
    targets: list[Mapping[str, Any]]
    roles: Mapping[str, Any]

    def document(self) -> dict[str, Any]:
        """The contents of ``evaluation.json``."""
        return {
            **self.shared,
            "policy": self.policy,
            "training_seed": self.training_seed,
            "main": self.main,
            "roles": self.roles,
            "targets": self.targets,
            "conditions": self.conditions,
        }


def study_figures(folder: Path, agent: Path) -> Figures:
    """The figures of an agent.

    Args:
        folder: The study's folder, evaluated.
        agent: The agent's folder, as it was evaluated.

    Raises:
        ConfigurationError: A file is missing or is something else, or this agent did not take part.
    """
    record, summary = (_read(folder / name) for name in (STUDY, SUMMARY))
    policy, seed = _whose(folder, record, agent)
    frame = read_rows(folder).filter(policy=policy)
    mine = frame.filter(pl.col("training_seed") == seed)
    speeds = set(summary["roles"].get("speeds", ())) - {summary["roles"].get("book")}
    conditions = {
        name: {
            "description": found["description"],
            "best_law": found["best_law"].get(policy),
            "gap": found["gap"].get(policy),
            "policies": {key: one for key, one in found["policies"].items() if key not in speeds},
            "own": own_figures(mine.filter(condition=name)),
        }
        for name, found in summary["conditions"].items()
        if policy in found["policies"] and mine.filter(condition=name).height
    }
    if not conditions:
        raise ConfigurationError(f"{folder}: {SUMMARY} holds no figures of {policy}: run the study to its end.")
    main = (record["resolved"].get("targets") or {}).get("main")
    return Figures(
        policy,
        seed,
        {key: summary[key] for key in SHARED if key in summary},
        str(main) if main in conditions else next(iter(conditions)),
        conditions,
        [check for check in summary.get("targets", ()) if check["policy"] == policy],
        summary["roles"],
    )


def own_figures(episodes: pl.DataFrame) -> dict[str, Any]:
    """How the episodes of one training seed in one condition ended, and by severity of the sea."""
    reasons = episodes["reason"].value_counts().sort("count", "reason", descending=[True, False])
    succeeded, others = episodes.filter(pl.col("success")), episodes.filter(~pl.col("success"))
    peak = numbers(episodes, "scored_peak_kN")
    return {
        "episodes": episodes.height,
        "success": succeeded.height / episodes.height,
        "p95_kN": float(p95(peak)),
        "mean_kN": float(peak.mean()),
        "largest_kN": float(peak.max()),
        "time_s": float(median(numbers(succeeded, "time_s"))) if succeeded.height else None,
        "reasons": {str(reason): int(count) for reason, count in reasons.iter_rows()},
        "crooked": others.filter(~pl.col("aligned")).height,
        "by_lateral_g": bands(episodes),
    }


def _whose(folder: Path, record: Mapping[str, Any], agent: Path) -> tuple[str, int | None]:
    """Name and training seed under which an agent took part, known by its weights."""
    (entrant,) = agent_entrants([str(agent)])
    for policy, one in record["policies"].items():
        told = one.get("seeds", {}).get(str(entrant.training_seed), {})
        if told.get("identity") == entrant.identity:
            return policy, entrant.training_seed
    known = ", ".join(name for name, one in record["policies"].items() if one.get("kind") == "agent") or "none"
    raise ConfigurationError(
        f"{folder}: the agent of {agent} did not take part in this study as it is now; its agents are: {known}."
    )


def _read(path: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: this file is missing: give the folder of a finished study.") from None
    except (OSError, ValueError, TypeError) as error:
        raise ConfigurationError(f"{path}: this file cannot be read ({error}).") from None
