"""What a study's folder holds, as its page needs it: who took part, which conditions belong to which figure."""

from __future__ import annotations

import datetime
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.envs.ranges import RANGE_KEYS
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.page_style import Style, styles
from ssmash_gym.evaluation.statistics import Estimate
from ssmash_gym.evaluation.study import StudyConfig, load_study
from ssmash_gym.evaluation.study_rows import ROWS, STUDY, SUMMARY, StudyRows, read_rows

Array = NDArray[np.float64]

FILM: Final = "film.mp4"
STILL: Final = "film.jpg"
CREDITS: Final = "film.json"
CURVES: Final = "curves"
SEA_STATE: Final = "scenario.motion.sea_state"
DELAYS: Final = ("task.claw.delay_s", "scenario.claw.delay_s")
UNTOLD: Final = ("description", "provenance", "name")  # keys that say nothing about an episode
AGENT: Final = "agent"
RANGE: Final = RANGE_KEYS | {"within"}


@dataclass(frozen=True)
class StudyData:
    """A study's folder, read.

    Attributes:
        folder: Where it lies.
        document: ``study.json``; summary: ``summary.json``; config: the resolved study.
        rows: Rows of episodes by condition and policy.
    """

    folder: Path
    document: Mapping[str, Any]
    summary: Mapping[str, Any]
    config: StudyConfig
    rows: StudyRows
    _changes: dict[str, dict[str, Any]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Of the study."""
        return str(self.document["study"])

    @cached_property
    def date(self) -> str:
        """Day of the data: as the record says, else that of the newest file of rows."""
        told = self.document.get("date") or self.summary.get("date")
        if told:
            return str(told)[:10]
        newest = max(path.stat().st_mtime for path in (self.folder / ROWS).glob("*.parquet"))
        return datetime.datetime.fromtimestamp(newest, datetime.UTC).date().isoformat()

    @cached_property
    def conditions(self) -> list[str]:
        """Names of those that have rows, in the study's order."""
        present = {condition for condition, _ in self.rows.frames}
        ordered = [name for name in self.config.conditions if name in present]
        return [*ordered, *sorted(present - set(ordered))]

    @cached_property
    def main(self) -> str:
        """Condition of the main aim; the first one where none is named or it has not been run."""
        named = self.config.targets.main if self.config.targets else None
        return named if named in self.conditions else self.conditions[0]

    @cached_property
    def policies(self) -> list[str]:
        """All that have rows: agents, laws, the book, holding, the others; the book at other speeds last."""
        roles = self.config.roles
        known = list(dict.fromkeys(policy for _, policy in self.rows.frames))
        agents = [name for name in known if self.kind(name) == AGENT]
        front = [*agents, *roles.laws, roles.book, roles.hold]
        rest = [name for name in known if name not in front and name not in roles.speeds]
        wanted = dict.fromkeys([*front, *rest, *roles.speeds])
        return [name for name in wanted if name in known]

    @cached_property
    def drivers(self) -> list[str]:
        """The policies that are compared: all but the book at other speeds."""
        roles = self.config.roles
        return [name for name in self.policies if name not in roles.speeds or name == roles.book]

    @cached_property
    def first(self) -> str:
        """The policy that the study is about: the first agent, else the best law, else the first of all."""
        if self.kind(self.policies[0]) == AGENT:
            return self.policies[0]
        return self.law or self.policies[0]

    @cached_property
    def law(self) -> str | None:
        """The best tuned law, as the summary says; else the first one of the study's that has rows."""
        agents = [name for name in self.policies if self.kind(name) == AGENT]
        told = self.figures(self.main).get("best_law", {}).get(agents[0]) if agents else None
        here = [name for name in self.config.roles.laws if (self.main, name) in self.rows.frames]
        return str(told) if told in here else next(iter(here), None)

    @cached_property
    def looks(self) -> dict[str, Style]:
        """Style of each driver."""
        return styles(self.drivers, self.first)

    def kind(self, policy: str) -> str:
        """``agent``, ``scripted`` or ``planner``; empty where the record does not say."""
        return str(self.document.get("policies", {}).get(policy, {}).get("kind", ""))

    def in_condition(self, condition: str) -> list[str]:
        """Drivers with rows of a condition, in the usual order."""
        return [name for name in self.drivers if (condition, name) in self.rows.frames]

    def limit(self, name: str) -> float:
        """A limit of the main condition's task, such as ``probe_in_plane_kN``."""
        return float(self.document["conditions"][self.main]["task"]["limits"][name])

    def words(self, condition: str) -> str:
        """What a condition stands for."""
        return str(self.document["conditions"].get(condition, {}).get("description", ""))

    # --- groups of conditions ------------------------------------------------------------------------------------

    def changes(self, condition: str) -> dict[str, Any]:
        """What differs from the main condition: new values by dotted path."""
        if condition not in self._changes:
            mine, other = (flat(self.document["conditions"].get(name, {})) for name in (condition, self.main))
            paths = [path for path in {**other, **mine} if mine.get(path) != other.get(path)]
            self._changes[condition] = {path: mine.get(path) for path in sorted(paths)}
        return self._changes[condition]

    def sea_states(self) -> dict[str, int]:
        """The conditions that differ from the main one by the sea state only, with it; from calm to rough."""
        return self._along((SEA_STATE,), lambda flat_: int(flat_[SEA_STATE]))

    def delays(self) -> dict[str, int]:
        """The conditions that differ from the main one by the command's delay only, with it [ms]."""
        return self._along(DELAYS, _delay_ms)

    def _along(self, paths: Sequence[str], value: Any) -> dict[str, int]:
        found = {}
        for name in self.conditions:
            numbers = flat(self.document["conditions"].get(name, {}))
            if set(self.changes(name)) <= set(paths):
                try:
                    found[name] = value(numbers)
                except (KeyError, TypeError, ValueError):
                    continue  # a range, or no seaway
        return dict(sorted(found.items(), key=lambda item: item[1]))

    # --- numbers -------------------------------------------------------------------------------------------------

    def figures(self, condition: str) -> Mapping[str, Any]:
        """What the summary holds of a condition: ``policies``, ``pairs``, ``best_law``, ``gap``."""
        return dict(self.summary.get("conditions", {}).get(condition, {}))

    def of(self, condition: str, policy: str) -> Mapping[str, Any] | None:
        """A policy's figures in a condition as in the summary; None where it was not run."""
        found = self.figures(condition).get("policies", {}).get(policy)
        return None if found is None else dict(found)

    def estimate(self, condition: str, policy: str, *keys: str) -> Estimate | None:
        """A figure of the summary by its keys, such as ``peak_probe_kN``, ``p95``; None where there is none."""
        found: Any = self.of(condition, policy)
        for key in keys:
            found = None if found is None else found.get(key)
        return estimate(found)

    def pair(self, condition: str, policy: str, other: str) -> Mapping[str, Any] | None:
        """The comparison of two policies in the same seas as in the summary; None where there is none."""
        pairs = self.figures(condition).get("pairs", ())
        return next((dict(one) for one in pairs if (one["policy"], one["other"]) == (policy, other)), None)

    def frame(self, condition: str, policy: str) -> pl.DataFrame:
        """Rows of a policy in a condition, all its training seeds."""
        return self.rows.frames[condition, policy]

    def values(self, condition: str, policy: str, column: str) -> Array:
        """A metric of all episodes of a policy in a condition, (episodes,)."""
        return np.asarray(self.frame(condition, policy)[column].cast(pl.Float64).to_numpy())

    def paired(self, condition: str, policies: Sequence[str], column: str) -> tuple[NDArray[np.int64], list[Array]]:
        """A metric in the seas that all have met, means over training seeds: the seas, and (seas,) a policy."""
        seas = self.rows.seas(condition, *policies)
        return seas, [self.rows.table(condition, name, column, seas).mean(axis=0) for name in policies]


def estimate(figure: Mapping[str, Any] | None) -> Estimate | None:
    """A figure of the summary, ``value`` and ``ci``; without an interval it has no width."""
    if figure is None or figure.get("value") is None:
        return None
    low, high = figure.get("ci") or (figure["value"], figure["value"])
    return Estimate(float(figure["value"]), float(low), float(high))


def _delay_ms(numbers: Mapping[str, Any]) -> int:
    drawn = numbers.get("scenario.claw.delay_s")
    return round(1000.0 * float(numbers["task.claw.delay_s"] if drawn is None else drawn))


def flat(section: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Values of nested mappings by dotted path, without words and hashes."""
    found: dict[str, Any] = {}
    for key, value in section.items():
        if key in UNTOLD or (not path and key == "configuration"):
            continue
        if isinstance(value, Mapping) and value and RANGE.issuperset(value):
            found[f"{path}{key}"] = _range(value)
        elif isinstance(value, Mapping):
            found |= flat(value, f"{path}{key}.")
        else:
            found[f"{path}{key}"] = value
    return found


def _range(value: Mapping[str, Any]) -> Any:
    """A range as its constant, or as words."""
    told = {key: one for key, one in value.items() if one is not None}
    if set(told) == {"constant"}:
        return told["constant"]
    return ", ".join(f"{key} {one}" for key, one in told.items())


def read_study(folder: Path) -> StudyData:
    """Read a study's folder.

    Raises:
        ConfigurationError: A file is missing or cannot be read, or there are no rows.
    """
    found = {name: read_json(folder / name) for name in (STUDY, SUMMARY)}
    rows = read_rows(folder)
    if not rows.height:
        raise ConfigurationError(f"{folder / ROWS}: there are no rows of episodes in this folder: run the study first.")
    config = load_study(found[STUDY].get("resolved", {}))
    return StudyData(folder, found[STUDY], found[SUMMARY], config, StudyRows.of(rows))


def read_json(path: Path) -> dict[str, Any]:
    """A JSON file of a study's folder.

    Raises:
        ConfigurationError: It is missing or cannot be read.
    """
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: this file is missing: it is no folder of a finished study.") from None
    except (ValueError, TypeError) as error:
        raise ConfigurationError(f"{path}: this file cannot be read ({error}).") from None
