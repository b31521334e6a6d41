"""Runs a study chunk by chunk: what is done is kept, what is missing is run, what does not fit is refused."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import polars as pl

import ssmash_gym
from ssmash_gym.document import read_record
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition, digest, written
from ssmash_gym.evaluation.episodes import run_episodes, share_of
from ssmash_gym.evaluation.study import StudyConfig
from ssmash_gym.evaluation.study_entrants import PLANNER, Entrant, agent_entrants, code, scripted_entrant
from ssmash_gym.evaluation.study_rows import STUDY, Key, labelled, read_rows, write_rows
from ssmash_gym.files import write_text
from ssmash_gym.progress import Advance, progress_bar

PLANNING: Final = 40.0  # a planner's control interval costs so many scripted ones; only the bar goes by it


@dataclass(frozen=True)
class Chunk:
    """Some seas of one entrant in one condition.

    Attributes:
        entrant, condition: Who and where.
        first: Number of the first sea among the study's.
        seas: Episode seeds.
    """

    entrant: Entrant
    condition: Condition
    first: int
    seas: tuple[int, ...]

    @property
    def key(self) -> Key:
        """Whose rows they are."""
        return self.entrant.name, self.entrant.training_seed, self.condition.name

    @property
    def configuration(self) -> str:
        """Hash of all that its rows depend on: rows of another one are not mixed with these."""
        return digest(self.entrant.identity, self.condition.configuration, ssmash_gym.__version__)

    @property
    def work(self) -> float:
        """Control intervals to come, at most; those of a planner count more."""
        return len(self.seas) * self.condition.task.horizon_steps * (PLANNING if self.entrant.kind == PLANNER else 1.0)


@dataclass(frozen=True)
class Plan:
    """A study ready to be run.

    Attributes:
        study, name: The whole study, whatever part of it is run.
        conditions: Resolved, by name.
        entrants: All that take part.
        chunks: All there is to do, in order, whether done or not.
    """

    study: StudyConfig
    name: str
    conditions: dict[str, Condition]
    entrants: list[Entrant]
    chunks: list[Chunk]


def planned(study: StudyConfig, name: str, agents: Sequence[str] = (), part: StudyConfig | None = None) -> Plan:
    """Resolve a study and try everything that it names; nothing is written.

    Args:
        study: The study.
        name: Of it, in ``study.json``.
        agents: As of `agent_entrants`.
        part: What of it is run (`StudyConfig.narrowed`); None runs all.

    Raises:
        ConfigurationError: A name, a file or a value is refused, or a policy does not suit a condition.
    """
    part = part or study
    learned = agent_entrants(agents)
    names = tuple(dict.fromkeys(one.name for one in learned))
    both = [name for name in names if name in part.scripted]
    if both:
        raise ConfigurationError(f"--agent: the name {both[0]!r} is a scripted policy's: give another (NAME=FOLDER).")
    conditions = study.resolved()
    wanted = part.plan(names)
    for condition in dict.fromkeys(condition for condition, _ in wanted):
        conditions[condition].check()
    first = next(iter(conditions.values()))
    entrants = [*(scripted_entrant(one, first.task) for one in part.scripted), *learned]
    chunks = []
    for (condition, policy), count in wanted.items():
        for entrant in (one for one in entrants if one.name == policy):
            entrant.make(conditions[condition].task)  # refused now rather than after an hour
            chunks += _chunks(study, entrant, conditions[condition], count)
    chunks.sort(key=lambda chunk: chunk.entrant.kind == PLANNER)  # the slow ones last
    return Plan(study, name, conditions, entrants, chunks)


def _chunks(study: StudyConfig, entrant: Entrant, condition: Condition, count: int) -> list[Chunk]:
    seas = study.seas[:count]
    size = study.chunk if entrant.kind != PLANNER else min(study.chunk, study.planner_chunk)
    return [Chunk(entrant, condition, k, tuple(seas[k : k + size])) for k in range(0, count, size)]


def run_study(plan: Plan, out: Path, *, threads: int | None = None, shown: bool = True) -> pl.DataFrame:
    """Run what is missing in a study's folder.

    Args:
        plan: What there is to do.
        out: The study's folder: ``rows/*.parquet`` and ``study.json``. Rows that are there already are kept, also those
            of policies that do not take part this time.
        threads: Of the simulation; rows do not depend on them, nor on how they are chunked.
        shown: Whether a bar shows the progress.

    Returns:
        All rows of the folder.

    Raises:
        ConfigurationError: The folder holds rows of another configuration; nothing has been written.
        KeyboardInterrupt: The same call goes on where this one was stopped.
    """
    present, earlier = read_rows(out), read_record(out / STUDY)
    _refuse_mixing(plan, present, earlier, out)
    document = _document(plan, earlier)
    write_text(out / STUDY, json.dumps(document, indent=1) + "\n")
    missing = _missing(plan.chunks, present)
    total = sum(chunk.work for chunk in missing)
    done = 0.0
    with progress_bar("episodes", shown=shown and bool(missing)) as advance:
        for chunk in missing:
            _run_chunk(chunk, out, threads, functools.partial(_told, advance, chunk, done, total))
            done += chunk.work
        advance(1.0, "episodes")
    return read_rows(out)


def _told(advance: Advance, chunk: Chunk, done: float, total: float, share: float) -> None:
    """Tell the bar of a chunk under way."""
    advance((done + share * chunk.work) / total, f"{chunk.entrant.name} in {chunk.condition.name}")


def _run_chunk(chunk: Chunk, out: Path, threads: int | None, tell: Callable[[float], None]) -> None:
    """Run one chunk and write its rows; `tell` is told the share of it that is done."""
    condition = chunk.condition
    tell(0.0)
    rows = run_episodes(
        chunk.entrant.make(condition.task), condition.scenario, chunk.seas, helicopter=condition.helicopter,
        threads=threads, tell=share_of(len(chunk.seas) * condition.task.horizon_steps, tell),
    )  # fmt: skip
    write_rows(out, chunk.key, labelled(rows, chunk.key, chunk.configuration, code()), chunk.first)


def _missing(chunks: Sequence[Chunk], present: pl.DataFrame) -> list[Chunk]:
    """The chunks without the seas that have rows; those that have all are left out."""
    met: dict[Key, set[int]] = {}
    keys = ("policy", "training_seed", "condition")
    for key, part in present.group_by(keys):
        met[str(key[0]), key[1], str(key[2])] = set(part["sea"].to_list())
    found = []
    for chunk in chunks:
        left = tuple(sea for sea in chunk.seas if sea not in met.get(chunk.key, ()))
        if left:
            first = chunk.first + chunk.seas.index(left[0])
            found.append(Chunk(chunk.entrant, chunk.condition, first, left))
    return found


def _document(plan: Plan, earlier: dict[str, Any]) -> dict[str, Any]:
    """The contents of ``study.json``: this call's study, and what earlier calls have brought into the folder."""
    conditions = dict(earlier.get("conditions", {}))
    for name in dict.fromkeys(chunk.condition.name for chunk in plan.chunks):
        one = plan.conditions[name]
        conditions[name] = {
            "description": one.description or one.scenario.description,
            "configuration": one.configuration,
            **written(one.task, one.scenario, one.helicopter),
        }
    policies = dict(earlier.get("policies", {}))
    for name in dict.fromkeys(one.name for one in plan.entrants):
        policies[name] = _policy([one for one in plan.entrants if one.name == name], policies.get(name, {}))
    return {
        "study": plan.name,
        "configuration": digest(plan.study.model_dump(mode="json")),
        "versions": {"ssmash_gym": ssmash_gym.__version__, "code": code()},
        "resolved": plan.study.model_dump(mode="json"),
        "seed": plan.study.seed,
        "conditions": conditions,
        "policies": policies,
    }


def _policy(entrants: Sequence[Entrant], earlier: dict[str, Any]) -> dict[str, Any]:
    """A policy in ``study.json``; training seeds of earlier calls stay."""
    seeds = dict(earlier.get("seeds", {}))
    seeds |= {str(one.training_seed): {"identity": one.identity, **one.about} for one in entrants}
    return {"kind": entrants[0].kind, "seeds": seeds}


def _refuse_others(plan: Plan, earlier: dict[str, Any], out: Path, advice: str) -> None:
    """Refuse a policy of another make under the name of one that the folder knows, in whatever condition.

    Raises:
        ConfigurationError: Weights, gains or sources were other ones.
    """
    for one in plan.entrants:
        known = earlier.get("policies", {}).get(one.name, {}).get("seeds", {}).get(str(one.training_seed))
        if known is not None and known["identity"] != one.identity:
            raise ConfigurationError(f"{out}: {_who(one.name, one.training_seed)} was another one there; {advice}.")


def _who(name: str, seed: int | None) -> str:
    return name if seed is None else f"{name} of training seed {seed}"


def _refuse_mixing(plan: Plan, present: pl.DataFrame, earlier: dict[str, Any], out: Path) -> None:
    """Refuse to add rows to those of another configuration.

    Raises:
        ConfigurationError: The folder's seas, a condition or a policy were other ones.
    """
    advice = "rows of both must not be mixed: choose another --out, or remove that folder"
    if earlier and earlier["seed"] != plan.study.seed:
        raise ConfigurationError(f"{out}: its seas are of seed {earlier['seed']}, not {plan.study.seed}; {advice}.")
    for name, one in earlier.get("conditions", {}).items():
        if name in plan.conditions and one["configuration"] != plan.conditions[name].configuration:
            raise ConfigurationError(f"{out}: the condition {name} was another one there; {advice}.")
    _refuse_others(plan, earlier, out, advice)
    kinds = present.select("policy", "training_seed", "condition", "configuration").unique()
    known = {row[:3]: row[3] for row in kinds.iter_rows()}
    for chunk in plan.chunks:
        if known.get(chunk.key, chunk.configuration) != chunk.configuration:
            name, seed, condition = chunk.key
            raise ConfigurationError(f"{out}: {_who(name, seed)} was another one there in {condition}; {advice}.")
