"""From the rows of a study to ``summary.json``: all figures, who is compared with whom, and the project's aims."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.statistics import known_median, p95
from ssmash_gym.evaluation.study import Roles, StudyConfig
from ssmash_gym.evaluation.study_entrants import AGENT, PLANNER
from ssmash_gym.evaluation.study_figures import (
    Episodes,
    Options,
    beyond_hold,
    gap_figures,
    pair_figures,
    policy_figures,
)
from ssmash_gym.evaluation.study_rows import STUDY, SUMMARY, StudyRows, read_rows
from ssmash_gym.evaluation.targets import REQUIRED_SUCCESS, checked
from ssmash_gym.files import write_text
from ssmash_gym.progress import progress_bar
from ssmash_gym.sections import validated


class Comparison:
    """Makes the figures of a study.

    Args:
        rows: Its rows.
        study: The study.
        kinds: ``agent``, ``scripted`` or ``planner``, by policy.
    """

    def __init__(self, rows: StudyRows, study: StudyConfig, kinds: dict[str, str]) -> None:
        self.rows = rows
        self.roles: Roles = study.roles
        self.options = Options(study.resamples)
        self.kinds = kinds
        self.agents = [name for name, kind in kinds.items() if kind == AGENT]

    def condition(self, name: str) -> dict[str, Any]:
        """All figures of one condition."""
        present = [policy for policy in self.kinds if policy in self.rows.policies(name)]
        figures = {policy: self._policy(name, policy) for policy in present if self.rows.has(name, policy)}
        able = [one for one in figures if self.kinds[one] in (AGENT, PLANNER) and one != self.roles.clairvoyant]
        best = {one: best_law(self.roles, figures, figures[one]["success"]["value"]) for one in able}
        return {
            "policies": figures,
            "pairs": [self._pair(name, *pair) for pair in self._pairs(list(figures)) if self.rows.has(name, *pair)],
            "best_law": best,
            "gap": {one: gap for one in able if (gap := self._gap(name, one, best[one]))},
        }

    def _policy(self, condition: str, policy: str) -> dict[str, Any]:
        own = Episodes.of(self.rows, condition, policy, self.rows.seas(condition, policy))
        figures = {"kind": self.kinds[policy], **policy_figures(own, self.options)}
        if policy != self.roles.hold and self.rows.has(condition, policy, self.roles.hold):
            seas = self.rows.seas(condition, policy, self.roles.hold)
            driven, held = (Episodes.of(self.rows, condition, one, seas) for one in (policy, self.roles.hold))
            figures |= beyond_hold(driven, held, self.options)
        return figures

    def _pairs(self, policies: list[str]) -> list[tuple[str, str]]:
        """Who is compared: agents with all, planners with the laws, all with the book."""
        others = [name for name in policies if name not in self.agents]
        agents = [name for name in policies if name in self.agents]
        planners = [name for name in others if self.kinds[name] == PLANNER]
        found = [(agent, other) for k, agent in enumerate(agents) for other in (*agents[k + 1 :], *others)]
        found += [(planner, law) for planner in planners for law in self.roles.laws if law in others]
        found += [(name, self.roles.book) for name in others if name != self.roles.book and self.roles.book in others]
        return list(dict.fromkeys(found))

    def _pair(self, condition: str, policy: str, other: str) -> dict[str, Any]:
        seas = self.rows.seas(condition, policy, other)
        ours, theirs = (Episodes.of(self.rows, condition, one, seas) for one in (policy, other))
        return {"policy": policy, "other": other, **pair_figures(ours, theirs, self.options)}

    def _gap(self, condition: str, policy: str, law: str | None) -> dict[str, Any] | None:
        far = self.roles.clairvoyant
        if law is None or far is None or not self.rows.has(condition, law, policy, far):
            return None
        seas = self.rows.seas(condition, law, policy, far)
        near, here, there = (Episodes.of(self.rows, condition, one, seas) for one in (law, policy, far))
        return {"law": law, "clairvoyant": far, **gap_figures(near, here, there, self.options)}


def best_law(roles: Roles, figures: dict[str, Any], success: float) -> str | None:
    """The tuned law with the lowest 95th percentile of the peak load among those of the same success.

    The same means: at least the agent's, or at least the share that the aims ask for, whichever is lower. Where no law
    has that, the one with the highest success. It is chosen in the same seas in which it is then compared, which is to
    its advantage.

    Args:
        roles: Say which policies are laws.
        figures: Of the condition's policies, by name.
        success: Share of the agent's episodes that succeed.
    """
    laws = [name for name in roles.laws if name in figures]
    enough = [name for name in laws if figures[name]["success"]["value"] >= min(success, REQUIRED_SUCCESS)]
    if enough:
        return min(enough, key=lambda name: float(figures[name]["peak_probe_kN"]["p95"]["value"]))
    return max(laws, key=lambda name: float(figures[name]["success"]["value"]), default=None)


def main_law(study: StudyConfig, conditions: dict[str, Any], agents: list[str]) -> str | None:
    """The best law in the condition of the main aim, for the first agent; without an agent for the success required."""
    main = study.targets.main if study.targets is not None else next(iter(conditions))
    if main not in conditions:
        return None
    figures = conditions[main]["policies"]
    first = next((agent for agent in agents if agent in figures), None)
    return best_law(study.roles, figures, REQUIRED_SUCCESS if first is None else figures[first]["success"]["value"])


def curve(study: StudyConfig, conditions: dict[str, Any], rows: StudyRows) -> dict[str, Any] | None:
    """Load against time: the book at several speeds, and each policy beside the book that takes as long.

    None where it was not driven at two speeds or more. The peak load of the book at a policy's median time is
    interpolated between its speeds; a policy beyond them has none. Policies are taken in the seas that the book has met
    at its speeds.
    """
    name = study.targets.curve if study.targets is not None else None
    figures = conditions.get(name or "", {}).get("policies", {})
    driven = [one for one in study.roles.speeds if one in figures and figures[one]["success"]["value"] > 0.0]
    points = [
        {"policy": one, **{key: figures[one][key] for key in ("time_s", "success")}, **figures[one]["peak_probe_kN"]}
        for one in driven
    ]
    if len(points) < 2 or study.targets is None:
        return None
    points.sort(key=lambda point: point["time_s"]["value"])
    times, loads = ([point[key]["value"] for point in points] for key in ("time_s", "p95"))
    beside = {}
    main = study.targets.main
    driven_seas = rows.seas(str(name), *driven)
    for policy in conditions.get(main, {}).get("policies", {}):
        seas = np.intersect1d(driven_seas, rows.seas(main, policy))
        if not seas.size:
            continue
        own = Episodes.of(rows, main, policy, seas).tables
        time_s, load = float(known_median(own["time_s"].ravel())), float(p95(own["peak_kN"].ravel()))
        if own["success"].any() and times[0] <= time_s <= times[-1]:
            book = float(np.interp(time_s, times, loads))
            beside[policy] = {"time_s": time_s, "p95_kN": load, "book_p95_kN": book, "ratio": load / book}
    return {"condition": name, "points": points, "equal_time": beside}


def summarise(out: Path, *, shown: bool = True) -> dict[str, Any]:
    """Work out all figures of a study's folder and write its ``summary.json``.

    Args:
        out: The study's folder.
        shown: Whether a bar shows the progress.

    Returns:
        The contents of the file.

    Raises:
        ConfigurationError: There are no rows, or they do not belong together.
    """
    record = json.loads((out / STUDY).read_text(encoding="utf-8"))
    study = validated(StudyConfig, record["resolved"], f"{out / STUDY}")
    frame = read_rows(out)
    if not frame.height:
        raise ConfigurationError(f"{out}: no row has been written there.")
    rows = StudyRows.of(frame)
    kinds = {name: one["kind"] for name, one in record["policies"].items()}
    comparison = Comparison(rows, study, kinds)
    ran = {name for name, _ in rows.frames}
    conditions: dict[str, Any] = {}
    with progress_bar("intervals", shown=shown) as advance:
        for k, name in enumerate(here := [name for name in record["conditions"] if name in ran]):
            advance(k / len(here), f"intervals, {name}")
            conditions[name] = {"description": record["conditions"][name]["description"], **comparison.condition(name)}
    roles = {**study.roles.model_dump(mode="json"), "agents": comparison.agents}
    summary = {
        "study": record["study"],
        "configuration": record["configuration"],
        "versions": record["versions"],
        "code_states": frame["code"].n_unique(),
        "seed": study.seed,
        "level": comparison.options.level,
        "resamples": comparison.options.resamples,
        "roles": roles,
        "best_law": main_law(study, conditions, comparison.agents),
        "conditions": conditions,
        "curve": curve(study, conditions, rows),
        "targets": checked(study, conditions, comparison.agents),
    }
    write_text(out / SUMMARY, json.dumps(summary, indent=1) + "\n")
    return summary
