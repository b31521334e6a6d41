"""A trial as data: a table with one row a control step, and what is to be known of the whole."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

import ssmash_gym
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.task import OF_AN_AGENT, TaskConfig
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition, written
from ssmash_gym.evaluation.study_entrants import PHYSICS
from ssmash_gym.sections import validated
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.trials.stamps import NOBODY, PERSON
from ssmash_gym.vehicle import helicopter_from

KIND: Final = "trial"
FORMAT: Final = 1
PRACTICE: Final = "practice"
SCORED: Final = "scored"
FREE: Final = "free"
SEVERAL: Final = "several"
PAGE: Final = "page"  # origin: the claw could be held by a person at the page
MOST_DESERTED: Final = 0.05  # of the steps; assumed
SCRIPT: Final = "script"  # origin: virtual time, nobody at the claw

# Telemetry channels at the end of the interval, in their SI units, and the largest values within it.
CHANNELS: Final = (
    "probe_in_plane", "probe_axial", "probe_fx", "probe_fy", "roll", "pitch", "yaw", "claw_x", "claw_y",
    "claw_vx", "claw_vy", "probe_x", "probe_y", "deck_roll", "deck_pitch", "deck_fx", "deck_fy", "deck_fz",
    "auxiliary_steer", "auxiliary_vertical_load", "right_vertical_load", "left_vertical_load",
)  # fmt: skip
PEAKS: Final = (
    "probe_in_plane", "probe_axial", "auxiliary_vertical_load", "right_vertical_load", "left_vertical_load",
)  # fmt: skip
COLUMNS: Final[Mapping[str, Any]] = {
    "step": pl.Int64,
    "time_s": pl.Float64,
    "command_along": pl.Float64,
    "command_across": pl.Float64,
    "saturation": pl.Float64,
    "driver": pl.String,
    "device": pl.String,
    "sequence": pl.Int64,
    "input_ms": pl.Float64,
    "received_s": pl.Float64,
    "planned_s": pl.Float64,
    "taken_s": pl.Float64,
    "late": pl.Boolean,
    "shown_step": pl.Int64,
    "state_digest": pl.UInt64,
    "reward": pl.Float64,
    **{name: pl.Float32 for name in CHANNELS},  # the digest vouches for all bits of the state
    **{f"{name}_max": pl.Float32 for name in PEAKS},
}
KEYS: Final[Mapping[str, tuple[str, ...]]] = {  # of the record, those that are relied on
    "version": (),
    "code": (),
    "sources": (),
    "configuration": (),
    "condition": ("name", "description", "task", "scenario", "helicopter"),
    "seed": (),
    "draw": (),
    "draw_of_seed": (),
    "participant": (),
    "session": ("number", "of", "phase", "id"),
    "origin": (),
    "timing": ("interval_s", "valid"),
    "complete": (),
    "metrics": (),
}
SIMULATED: Final = ("state_digest", "reward", *CHANNELS, *(f"{name}_max" for name in PEAKS))  # what a replay compares


@dataclass(frozen=True)
class Trial:
    """One episode at the claw, by a person or a program.

    Attributes:
        table: One row a control step; its columns are `COLUMNS`.
        about: What holds for the whole, ready for JSON; `docs/guide/trials.md` lists the keys.
    """

    table: pl.DataFrame
    about: dict[str, Any]

    @functools.cached_property
    def condition(self) -> Condition:
        """What was simulated, made anew from the record.

        Raises:
            ConfigurationError: This version of the package does not take it.
        """
        told = self.about["condition"]
        return Condition(
            str(told["name"]),
            str(told["description"]),
            validated(TaskConfig, told["task"], "trial: task"),
            validated(ScenarioConfig, told["scenario"], "trial: scenario"),
            helicopter_from(told["helicopter"], "trial: helicopter"),
        )

    @property
    def seed(self) -> int:
        """Of the episode."""
        return int(self.about["seed"])

    @property
    def steps(self) -> int:
        """Control steps that were taken."""
        return self.table.height

    @property
    def commands(self) -> NDArray[np.float64]:
        """Commands as they were applied, along and across the track, within -1 to 1, (n, 2)."""
        return self.table.select("command_along", "command_across").to_numpy().reshape(self.steps, 2)

    @property
    def driver(self) -> str:
        """Who commanded: one name; ``several`` where it changed hands, apart from steps with nobody at the claw."""
        names = [name for name in self.table["driver"].unique(maintain_order=True).to_list() if name != NOBODY]
        return NOBODY if not names else str(names[0]) if len(names) == 1 else SEVERAL

    @property
    def by_person(self) -> bool:
        """Whether a person drove it, and nobody else: only at the page can there have been one."""
        return self.driver == PERSON and self.about["origin"] == PAGE

    @property
    def complete(self) -> bool:
        """Whether the episode has come to its own end."""
        return bool(self.about["complete"])

    @property
    def valid(self) -> bool:
        """Whether no more steps were late than are allowed."""
        return bool(self.about["timing"]["valid"])

    @property
    def deserted(self) -> bool:
        """Whether nobody held the claw for more than `MOST_DESERTED` of the steps: such a trial tells little."""
        return self.deserted_share > MOST_DESERTED

    @property
    def deserted_share(self) -> float:
        """Share of the steps with nobody at the claw, or with a page that had fallen silent."""
        return float((self.table["driver"] == NOBODY).mean() or 0.0)  # type: ignore[arg-type]

    @property
    def phase(self) -> str:
        """``practice``, ``scored`` or ``free``."""
        return str(self.about["session"]["phase"])

    @property
    def scored(self) -> bool:
        """Whether it counts: a scored trial of a session, complete and valid, with somebody at the claw."""
        return self.phase == SCORED and self.complete and self.valid and not self.deserted

    @property
    def metrics(self) -> dict[str, Any] | None:
        """The metrics of the episode; None where it has not come to its end."""
        found: dict[str, Any] | None = self.about["metrics"]
        return found


def bare(condition: Condition) -> Condition:
    """The condition as it is judged and replayed: without what an agent brings along (history, residual action)."""
    return replace(condition, task=condition.task.model_copy(update=dict.fromkeys(OF_AN_AGENT)))


def record_of(condition: Condition) -> dict[str, Any]:
    """A condition as a trial's file holds it, resolved."""
    resolved = written(condition.task, condition.scenario, condition.helicopter)
    return {"name": condition.name, "description": condition.description, **resolved}


def state_digest(state: NDArray[np.float64]) -> int:
    """First 8 bytes of BLAKE2b over the bytes of a state column, (rows,): the same number, the same bits."""
    return int.from_bytes(hashlib.blake2b(np.ascontiguousarray(state).tobytes(), digest_size=8).digest(), "little")


def simulated(state: NDArray[np.float64], telemetry: Telemetry, reward: float) -> dict[str, Any]:
    """The columns of one step that come from the simulation, of column 0 of a batch.

    Args:
        state: State of the helicopter, (rows,).
        telemetry: Of the batch.
        reward: Of the step.
    """
    row: dict[str, Any] = {"state_digest": state_digest(state), "reward": float(reward)}
    row |= {name: np.float32(telemetry[name][0]) for name in CHANNELS}
    return row | {f"{name}_max": np.float32(telemetry.peak_max(name)[0]) for name in PEAKS}


@functools.cache
def sources() -> str:
    """Hash of the sources that make an episode, as they are when first asked for; libraries do not count."""
    digest, package = hashlib.sha256(), Path(ssmash_gym.__file__).parent
    for path in sorted(path for part in PHYSICS for path in (package / part).rglob("*.py")):
        digest.update(path.relative_to(package).as_posix().encode())
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()[:16]


def checked(trial: Trial) -> Trial:
    """The trial, if its table and its record are those of one.

    Raises:
        ConfigurationError: A column or key is missing or of another type.
    """
    for name, kind in COLUMNS.items():
        if trial.table.schema.get(name) != kind:
            raise ConfigurationError(f"the column {name} is missing or of another type.")
    for key, inside in KEYS.items():
        if key not in trial.about:
            raise ConfigurationError(f"the key {key} is missing.")
        for name in inside:
            if name not in trial.about[key]:
                raise ConfigurationError(f"the key {key}.{name} is missing.")
    commands = trial.commands
    if not (np.abs(commands) <= 1.0).all():
        raise ConfigurationError("a command is not within -1 to 1.")
    return trial
