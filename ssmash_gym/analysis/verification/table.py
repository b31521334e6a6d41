"""The verification table as a file: trials, printed values, tolerances, and what is wrong with some of them.

A trial is a case (`ssmash_gym.cases`): one base, laid over by the trial's own settings. Inputs that the thesis does not
print (how far a centre of gravity moves, how strong a wind is) stand in a second file that `ssmash identify` writes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field, field_validator, model_validator

from ssmash_gym.assets import asset_path
from ssmash_gym.cases import QUANTITIES, Case, case_from
from ssmash_gym.document import read_yaml, split
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.fields import Number, Part, Positive, refuse
from ssmash_gym.sections import validated
from ssmash_gym.vehicle import Helicopter, document_of, load_helicopter

Status = Literal["fitted", "predicted", "faulty"]
STATUSES: Final[tuple[Status, ...]] = ("fitted", "predicted", "faulty")
REFERENCE: Final = "1"  # the trial that displacements start from


class PrintedRow(Part):
    """One printed value."""

    quantity: str = Field(description="name of the quantity, unit included")
    printed: Number = Field(description="the value as printed")
    expected: Number | str | None = Field(None, description="what the table says was expected, if it does")
    tolerance: Positive = Field(description="greatest difference that passes")
    why: str = Field("", description="where the tolerance comes from, if it is not the common one")
    status: Status = Field(description="fitted: identified with it; predicted: follows; faulty: misprinted")
    sigma: Positive | None = Field(None, description="standard deviation in the identification; none: not used there")
    corrected: Number | None = Field(None, description="what a faulty value should be, if that is known")
    reason: str = Field("", description="what is wrong with a faulty value")

    @field_validator("quantity")
    @classmethod
    def _known(cls, name: str) -> str:
        if name not in QUANTITIES:
            raise ValueError(f"there is no quantity {name!r}; known are {', '.join(QUANTITIES)}")
        return name

    @model_validator(mode="after")
    def _honest(self) -> PrintedRow:
        faulty = self.status == "faulty"
        if faulty != bool(self.reason):
            raise refuse("reason", self.reason, "a faulty value needs a reason, and no other value has one")
        if self.corrected is not None and not faulty:
            raise refuse("corrected", self.corrected, "only a faulty value can be corrected")
        if self.sigma is not None and self.status != "fitted":
            raise refuse("sigma", self.sigma, "only a fitted value has one")
        return self

    @property
    def aim(self) -> float | None:
        """What the simulation is compared with; None for a faulty value that nobody can correct."""
        return self.corrected if self.status == "faulty" else self.printed


class Variation(Part):
    """A trial run once more with something else that the thesis does not give."""

    label: str = Field(min_length=1, description="what is varied, as printed")
    trail_m: Number | None = Field(None, description="mechanical trail of the nose wheels [m]")
    overlay: dict[str, Any] = Field(default_factory=dict, description="settings by dotted path")


class TrialFile(Part):
    """One trial of the table."""

    title: str = Field(description="as in the table")
    overlay: dict[str, Any] = Field(default_factory=dict, description="settings of the case by dotted path")
    increments: dict[str, Number] = Field(default_factory=dict, description="additions to numbers of the helicopter")
    from_reference: bool = Field(False, description="whether it starts from the rest of the reference, in numbers")
    note: str = Field("", description="what else must be known")
    rows: tuple[PrintedRow, ...] = Field(min_length=1, description="printed values")
    variations: tuple[Variation, ...] = Field((), description="the same with what the thesis leaves open")


class TableFile(Part):
    """The whole file."""

    title: str
    source: str
    base: dict[str, Any] = Field(description="the case that every trial is laid over")
    inputs: Annotated[str, Field(min_length=1)] = Field(description="file of the identified inputs of trials")
    trials: dict[str, TrialFile] = Field(description="trials by the number of the table")

    @model_validator(mode="after")
    def _starts(self) -> TableFile:
        if REFERENCE not in self.trials:
            raise refuse("trials", sorted(self.trials), f"trial {REFERENCE!r} is the reference and must be there")
        return self


@dataclass(frozen=True)
class Trial:
    """One trial, ready to run with any helicopter."""

    key: str
    file: TrialFile
    base: Mapping[str, Any]
    inputs: Mapping[str, Any]
    where: str

    def changes(self, helicopter: Helicopter) -> dict[str, Any]:
        """What the trial changes in a helicopter, by dotted path; increments are worked out."""
        added = {
            path: {"value": helicopter.value(path) + step, "origin": "source", "note": f"Table 3.1: {step:+g}"}
            for path, step in self.file.increments.items()
        }
        own = self.file.overlay.get("changes", {})
        return {**self.base.get("changes", {}), **own, **self.inputs, **added}

    def case(
        self,
        helicopter: Helicopter,
        document: str | dict[str, Any],
        start: Mapping[str, Any] | None = None,
        variation: Variation | None = None,
    ) -> Case:
        """The case of this trial.

        Args:
            helicopter: The helicopter.
            document: The same as a case names it: its name, its file, or its document.
            start: Rest of the reference as a case's start, for a trial that begins there.
            variation: Something else to lay over it.
        """
        settings = {key: value for key, value in self.file.overlay.items() if key != "changes"}
        if self.file.from_reference and start is not None:
            settings["start"] = dict(start)
        changes = self.changes(helicopter)
        name = f"Table 3.1, case {self.key}"
        if variation is not None:
            overlay = dict(variation.overlay)
            changes |= overlay.pop("changes", {})
            if variation.trail_m is not None:
                changes |= trail(helicopter, variation.trail_m)
            settings |= overlay
        base = {"name": name, "title": self.file.title, **self.base, "helicopter": document, "changes": changes}
        return case_from(base, self.where).changed(settings)


@dataclass(frozen=True)
class VerificationTable:
    """The table with its two files."""

    file: TableFile
    inputs: Mapping[str, Mapping[str, Any]]
    path: Path
    inputs_path: Path

    @cached_property
    def trials(self) -> dict[str, Trial]:
        """The trials by their number."""
        return {
            key: Trial(key, trial, self.file.base, self.inputs.get(key, {}), f"{self.path.name}, trial {key}")
            for key, trial in self.file.trials.items()
        }

    @property
    def helicopter(self) -> str:
        """Name of the helicopter in the catalogue."""
        return str(self.file.base["helicopter"])

    def with_inputs(self, inputs: Mapping[str, Mapping[str, Any]]) -> VerificationTable:
        """The same table with other inputs of its trials, changes to the helicopter by trial."""
        return VerificationTable(self.file, inputs, self.path, self.inputs_path)


def trail(helicopter: Helicopter, trail_m: float) -> dict[str, Any]:
    """Changes that give the nose wheels another mechanical trail and leave them where they are [m]."""
    station = helicopter.stations.auxiliary
    wheel = station.mount_m[0] + station.droop_m[0]
    return {
        "stations.auxiliary.mount_m.0": wheel + trail_m,
        "stations.auxiliary.droop_m.0": -trail_m,
    }


def load_table(path: Path | None = None) -> VerificationTable:
    """Read the table; the one that ships with the package by default.

    Raises:
        ConfigurationError: A file is missing or refused.
    """
    path = path or asset_path("configs", "verification", "table_3_1.yaml")
    file = validated(TableFile, _read(path), str(path))
    inputs_path = path.parent / file.inputs
    inputs = _read(inputs_path)
    for key in inputs:
        if key not in file.trials:
            raise ConfigurationError(f"{inputs_path}: there is no trial {key!r} in {path}.")
    table = VerificationTable(file, inputs, path, inputs_path)
    helicopter = load_helicopter(table.helicopter)
    document = document_of(helicopter)
    for trial in table.trials.values():
        trial.case(helicopter, document)  # refused now or never
    return table


def _read(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise ConfigurationError(f"{path}: there is no such file.")
    return read_yaml(path.read_text(encoding="utf-8"), str(path))


def plain(inputs: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Inputs of a trial without their marks."""
    values: dict[str, Any] = split(dict(inputs), source)[0]
    return values
