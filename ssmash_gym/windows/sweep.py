"""Runs a window: what is done is kept, what is missing is run, what does not fit is refused."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl

import ssmash_gym
from ssmash_gym.envs.loading import BASE_KEY
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import digest, written
from ssmash_gym.evaluation.policies import is_scripted
from ssmash_gym.evaluation.study_entrants import Entrant, agent_entrants, code, scripted_entrant
from ssmash_gym.progress import Advance, progress_bar
from ssmash_gym.training.seeds import WINDOWS, block
from ssmash_gym.windows.axes import AXES
from ssmash_gym.windows.cells import Grid, Setting, settings
from ssmash_gym.windows.chunks import Chunk, Job
from ssmash_gym.windows.config import WindowConfig
from ssmash_gym.windows.criteria import CRITERIA, columns_read, label_of, names_of
from ssmash_gym.windows.engines import Engine
from ssmash_gym.windows.plan import Tally, Who, chunks, fill, rounds
from ssmash_gym.windows.rows import WINDOW, alone_in, read_document, read_rows, write_document, write_rows
from ssmash_gym.windows.sequential import UNDECIDED, bounds
from ssmash_gym.windows.stages import STAGES

SIZE: Final = 720  # seas of a chunk: what an interruption can cost, and what a worker holds at once


@dataclass(frozen=True)
class Sweep:
    """A window ready to be run.

    Attributes:
        config: The window.
        name: Of it, in ``window.json``.
        job: What workers need.
        source: What was named on the command line: a shipped window or a file.
        words: The policies as they were named, by their own names.
    """

    config: WindowConfig
    name: str
    job: Job
    source: str = ""
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def identity(self) -> str:
        """Hash of all that the plan and the rows depend on, whoever is at the claw and however far it goes."""
        effort = self.config.effort
        return digest(
            [setting.configuration for setting in self.job.settings.values()],
            {name: list(values) for name, values in self.config.axes.items()},
            [self.config.seed, self.config.figures, self.config.must_arrive, self.config.acceptance],
            [self.config.confidence, effort.seeds, effort.step],
            ssmash_gym.__version__,
        )


def prepared(
    config: WindowConfig, name: str, policies: Sequence[str] = (), size: int = SIZE, source: str = ""
) -> Sweep:
    """Resolve a window and try everything that it names; nothing is written.

    Args:
        config: The window.
        name: Of it.
        policies: At the claw: scripted ones by name, trained ones by name or folder (``NAME=FOLDER``); the window's own
            by default.
        size: Seas of a chunk.
        source: What was named on the command line; the name by default.

    Raises:
        ConfigurationError: A name, a file, a cell or a value is refused, or a policy does not suit a stage.
    """
    found = settings(config)
    asked = policies or config.policies
    named = _entrants(next(iter(found.values())), asked)  # refused also where every stage has a policy of its own
    entrants = {stage: _of_stage(setting, asked) for stage, setting in found.items()}
    _refuse_impossible(config, found)
    for stage, those in entrants.items():
        for entrant in those.values():
            entrant.make(found[stage].task)  # refused now rather than after an hour
    first = len(Grid(config.axes)) * config.effort.seeds * sum(map(len, entrants.values()))
    if config.effort.episodes is not None and config.effort.episodes < first:
        raise ConfigurationError(
            f"window: effort.episodes = {config.effort.episodes} is refused: the first round alone takes {first} "
            "(cells times seeds times policies)."
        )
    seeds = tuple(block(config.seed, WINDOWS, max(config.effort.most, config.effort.seeds)))
    grid = Grid(config.axes)
    size = min(size, len(grid) * config.effort.seeds)
    words = {entrant.name: word for word, entrant in zip(asked, named.values(), strict=True)}
    return Sweep(config, name, Job(grid, found, entrants, seeds, size), source or name, words)


def _of_stage(setting: Setting, policies: Sequence[str]) -> dict[str, Entrant]:
    """Who is at the claw in a stage, by name."""
    fixed = STAGES[setting.stage].policy
    return _entrants(setting, policies if fixed is None else (fixed,))


def _entrants(setting: Setting, policies: Sequence[str]) -> dict[str, Entrant]:
    """Policies by name, one for each word.

    Raises:
        ConfigurationError: There is none of a name, or two have the same.
    """
    found: dict[str, Entrant] = {}
    for word in policies:
        those = [scripted_entrant(word, setting.task)] if is_scripted(word) else agent_entrants([word])
        if len(those) > 1:
            raise ConfigurationError(f"--policy {word} is refused: name one folder; a window is of single policies.")
        if those[0].name in found:
            raise ConfigurationError(
                f"--policy: {those[0].name} is named twice: give different ones different names (NAME=FOLDER)."
            )
        found[those[0].name] = those[0]
    return found


def _refuse_impossible(config: WindowConfig, found: Mapping[str, Setting]) -> None:
    """Refuse limits that no episode can keep.

    Raises:
        ConfigurationError: There is one.
    """
    clearance_m = config.figures.get("corridor_clearance_m")
    for setting in found.values():
        width_m = setting.task.corridor.door_half_width_m
        if clearance_m is not None and clearance_m >= width_m:
            raise ConfigurationError(
                f"window: limits.corridor_clearance_m = {clearance_m:g} is refused: the hangar door is {width_m:g} m "
                "wide to either side."
            )


def run_sweep(sweep: Sweep, out: Path, engine: Engine, *, shown: bool = True) -> dict[Who, Tally]:
    """Run what is missing in a window's folder, round by round.

    Args:
        sweep: The window.
        out: Its folder: ``rows/*.parquet`` and ``window.json``. Rows that are there already are kept.
        engine: What runs the episodes; rows do not depend on it, nor on how they are chunked.
        shown: Whether a bar shows the progress.

    Returns:
        What has been run, by stage and policy.

    Raises:
        ConfigurationError: The folder holds rows of another configuration; nothing has been written.
        KeyboardInterrupt: The same call goes on where this one was stopped.
    """
    with alone_in(out):
        return _run(sweep, out, engine, shown)


def _run(sweep: Sweep, out: Path, engine: Engine, shown: bool) -> dict[Who, Tally]:
    """`run_sweep` in a folder that nobody else runs in."""
    config, job = sweep.config, sweep.job
    earlier = read_document(out)
    present = read_rows(out, [*columns_read(config.figures), "configuration", "code"])
    _refuse_mixing(sweep, present, earlier, out)
    write_document(out, document(sweep, earlier))
    tallies = {
        (stage, policy): Tally.blank(len(job.grid), len(job.seeds))
        for stage in job.settings
        for policy in job.entrants[stage]
    }
    if present.height:
        fill(tallies, config, present)
    with progress_bar("episodes", shown=shown) as advance:
        while missing := chunks(rounds(config, tallies), tallies, job.size):
            clock = _Clock(advance, sweep, missing, tallies)
            for chunk, rows in engine.run(job, _spread(missing, engine.workers), clock.tell):
                _refuse_foreign(rows)
                write_rows(out, chunk.name, rows)
                fill(tallies, config, rows)
    return tallies


def _spread(missing: Sequence[Chunk], workers: int) -> list[Chunk]:
    """The chunks, cut smaller where there are fewer than workers, so that all have work until the end."""
    found = list(missing)
    while found and len(found) < 2 * workers and max(len(chunk.cells) for chunk in found) > 64:
        found = [half for chunk in found for half in _halves(chunk)]
    return found


def _halves(chunk: Chunk) -> list[Chunk]:
    middle = len(chunk.cells) // 2
    parts = [slice(0, middle), slice(middle, None)] if middle else [slice(0, None)]
    return [replace(chunk, cells=chunk.cells[part], numbers=chunk.numbers[part]) for part in parts]


class _Clock:
    """Tells the bar how far a round is, and how fast."""

    def __init__(self, advance: Advance, sweep: Sweep, missing: Sequence[Chunk], tallies: dict[Who, Tally]) -> None:
        self._advance = advance
        self._most = sum(sweep.job.most_steps(chunk) for chunk in missing)
        self._interval_s = max(one.task.control_interval_s for one in sweep.job.settings.values())
        self._began, self._steps = time.monotonic(), 0
        self._words = f"{sum(chunk.episodes for chunk in missing):,} episodes, {_open_cells(sweep.config, tallies)}"

    def tell(self, steps: int) -> None:
        """Add control intervals that have been simulated."""
        self._steps += steps
        passed = max(time.monotonic() - self._began, 1e-9)
        speed = self._steps * self._interval_s / passed
        self._advance(min(self._steps / max(self._most, 1), 1.0), f"{self._words}, {speed:,.0f} x real time")


def _open_cells(config: WindowConfig, tallies: dict[Who, Tally]) -> str:
    """How many cells are undecided, in words."""
    left = 0
    for tally in tallies.values():
        counts = tally.done.sum(axis=1)
        found = bounds(tally.hits(counts), counts, config.confidence).verdicts(config.acceptance)
        left += int(np.sum(found == UNDECIDED))
    return f"{left:,} cells open"


def document(sweep: Sweep, earlier: dict[str, Any]) -> dict[str, Any]:
    """The contents of ``window.json``: what was asked for, resolved; policies of earlier calls stay."""
    config, job = sweep.config, sweep.job
    policies = dict(earlier.get("policies", {}))
    for stage, entrants in job.entrants.items():
        for name, one in entrants.items():
            known = dict(policies.get(name, {"kind": one.kind, "training_seed": one.training_seed, **one.about}))
            known["word"] = sweep.words.get(name)
            known["identities"] = {**known.get("identities", {}), stage: one.identity}
            policies[name] = known
    return {
        "name": sweep.name,
        "source": sweep.source,
        "description": config.description,
        "configuration": sweep.identity,
        "versions": {"ssmash_gym": ssmash_gym.__version__, "code": code()},
        "seed": config.seed,
        "stages": {stage: STAGES[stage].meaning for stage in job.settings},
        "axes": {
            name: {"label": AXES[name].label, "unit": AXES[name].unit, "values": list(values)}
            for name, values in config.axes.items()
        },
        "limits": limits_told(config),
        "must_arrive": config.must_arrive,
        "acceptance": config.acceptance,
        "confidence": config.confidence,
        "policies": policies,
        "helicopter": config.helicopter,
        "task": _called(config.task),
        "scenario": _called(config.scenario),
        "resolved": config.model_dump(mode="json"),
        "settings": {
            stage: written(one.task, one.scenario, one.helicopter) for stage, one in job.settings.items()
        },
    }  # fmt: skip


def limits_told(config: WindowConfig) -> dict[str, dict[str, Any]]:
    """The limits of a window in words and figures, by name; those that have no figure have None there."""
    found: dict[str, dict[str, Any]] = {
        name: {
            "value": limit.value,
            "note": limit.note,
            "label": CRITERIA[name].label,
            "unit": CRITERIA[name].unit,
            "sense": CRITERIA[name].sense,
            "column": CRITERIA[name].column,
        }
        for name, limit in config.limits.items()
    }
    names = names_of({}, must_arrive=any(config.arrives(stage) for stage in config.stages))
    return found | {name: {"value": None, "note": "in any case", "label": label_of(name), "unit": ""} for name in names}


def _called(given: str | Mapping[str, Any]) -> str:
    """A task or a scenario in a word or two."""
    if isinstance(given, str):
        return given
    changed = ", changed" if set(given) - {BASE_KEY} else ""
    return f"{given.get(BASE_KEY, 'its own')}{changed}"


def _refuse_mixing(sweep: Sweep, present: pl.DataFrame, earlier: dict[str, Any], out: Path) -> None:
    """Refuse to add rows to those of another configuration.

    Raises:
        ConfigurationError: The folder's window, its sources, or a policy of a name, was another one.
    """
    advice = "rows of both must not be mixed: choose another --out, or remove that folder"
    if present.height and not earlier:
        raise ConfigurationError(f"{out}: there are rows but no {WINDOW}, so nobody knows what of; {advice}.")
    if earlier and earlier.get("configuration") != sweep.identity:
        raise ConfigurationError(
            f"{out}: the window there ({earlier.get('name')}, configuration {earlier.get('configuration')}) was "
            f"another one than {sweep.name} ({sweep.identity}); {advice}."
        )
    for stage, entrants in sweep.job.entrants.items():
        for name, one in entrants.items():
            known = earlier.get("policies", {}).get(name, {}).get("identities", {}).get(stage, one.identity)
            rows = present.filter(pl.col("stage") == stage, pl.col("policy") == name)
            others = set(rows["configuration"]) - {sweep.job.configuration(stage, name)} if rows.height else set()
            if known != one.identity or others:
                raise ConfigurationError(f"{out}: the policy {name} was another one there; {advice}.")
    made_by = set(present["code"]) - {code()} if present.height else set()
    if made_by:
        raise ConfigurationError(
            f"{out}: its rows were made by other sources of ssmash_gym ({min(made_by)}) than these ({code()}); "
            f"{advice}."
        )


def _refuse_foreign(rows: pl.DataFrame) -> None:
    """Refuse rows from a worker with another ssmash_gym.

    Raises:
        ConfigurationError: There are some.
    """
    if set(rows["code"]) != {code()} or set(rows["version"]) != {ssmash_gym.__version__}:
        raise ConfigurationError(
            f"a worker runs other sources of ssmash_gym ({rows['version'][0]}, code {rows['code'][0]}) than this "
            f"process ({ssmash_gym.__version__}, code {code()}): give every node the same package."
        )
