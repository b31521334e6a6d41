"""A case: one deterministic run of one helicopter, described in a YAML file.

A case says which helicopter, where it starts, how deck and claw move, which speeds are held, and how it is solved.
The verification table, the validation manoeuvres, the thesis' input files and the other systems of the thesis are all
cases, so that they run through the same code. Degrees and the names of files stand here only; SI inside.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator, model_validator

from ssmash_gym.assets import asset_path
from ssmash_gym.cases.claw import Claw, StillClaw
from ssmash_gym.cases.section import CaseSection
from ssmash_gym.cases.start import Settled, Start
from ssmash_gym.document import Mark, is_leaf, join, plain_copy, read_file, split
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.fields import NonNegative, Number, Positive
from ssmash_gym.sections import validated
from ssmash_gym.ship.config import MotionConfig
from ssmash_gym.ship.sources import Fixed
from ssmash_gym.simulation.patch import DEFAULT_EDGE_M, is_wide
from ssmash_gym.simulation.timing import LONGEST_SUBSTEP_S, NODE_SPACING_S
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes
from ssmash_gym.vehicle.catalogue import helicopter_from

Speed = Literal["u7", "u8", "u9", "u10", "u11", "u12", "u13", "u14", "u15", "u16", "u17", "u18"]
Solver = Literal["engine", "adams", "gear", "automatic", "dop853", "rk45", "radau"]
SPEEDS: Final = get_args(Speed)
SOLVERS: Final = get_args(Solver)
_RAW: Final = ("helicopter", "changes")  # documents of a helicopter: they keep their own marks
_WHOLE: Final = 1e-4  # share of a step by which a whole number of steps may be off: rounding of the numbers in a file
MOST_STEPS: Final = 10_000_000  # rows of a run, and substeps of a row


class ModelChoices(CaseSection):
    """Choices between laws, see `ssmash_gym.simulation.parameters.Modes`."""

    contact: Literal["contact", "centre"] = Field("contact", description="where the tire's travel is taken")
    friction: Literal["limit_surface", "friction_circle", "independent"] = Field(
        "limit_surface", description="how the friction limit couples the tire's forces"
    )
    probe_law: Literal["potential", "ellipse", "printed"] = Field("potential", description="in-plane probe stiffness")


class Patch(CaseSection):
    """A rectangle of the deck with less friction."""

    x_m: tuple[Number, Number] = Field(description="from and to along the track, S axes [m]")
    y_m: tuple[Number, Number] = Field(description="from and to across the track, S axes [m]")
    friction_factor: Annotated[Number, Field(ge=0.0, le=1.0)] = Field(description="friction there over that elsewhere")
    edge_m: Positive = Field(DEFAULT_EDGE_M, description="width over which the friction changes [m]")

    @model_validator(mode="after")
    def _ordered(self) -> Patch:
        for key, span in (("x_m", self.x_m), ("y_m", self.y_m)):
            if not is_wide(span, self.edge_m):
                raise ValueError(
                    f"{key} must go up by at least two edges, {2.0 * self.edge_m:g} m, it goes from {span[0]:g} to "
                    f"{span[1]:g}"
                )
        return self


class ProbeTurn(CaseSection):
    """The probe turned about its axis in its housing: its gauges, and what they read, turn with it.

    Only what is measured turns; the load on the helicopter is that of the unturned probe.
    """

    angle_deg: Number = Field(description="angle turned in the end, positive about the helicopter's z [deg]")
    from_s: NonNegative = Field(0.0, description="time at which it begins to turn [s]")
    to_s: NonNegative = Field(0.0, description="time at which it has turned; linear in between [s]")

    @model_validator(mode="after")
    def _ordered(self) -> ProbeTurn:
        if self.to_s < self.from_s:
            raise ValueError(f"to_s = {self.to_s:g} must not be before from_s = {self.from_s:g}")
        return self


class Solution(CaseSection):
    """Time span, output and solver."""

    start_s: NonNegative = Field(0.0, description="start of the run on the clock of deck and claw [s]")
    end_s: NonNegative = Field(description="end of the run [s]")
    output_step_s: Positive = Field(0.02, description="time between rows of the output [s]")
    solver: Solver = Field(
        "engine",
        description="engine: the fixed-step kernel; adams, gear: VODE; automatic: LSODA; dop853, rk45, radau: SciPy's",
    )
    longest_node_s: Annotated[Positive, Field(le=NODE_SPACING_S)] | None = Field(
        None, description="longest spacing of the nodes of deck and claw; null: 0.25 s, 0.02 s where the claw moves [s]"
    )
    substep_s: Annotated[Positive, Field(le=LONGEST_SUBSTEP_S)] = Field(0.002, description="step of the engine [s]")
    rtol: Annotated[Positive, Field(ge=1.0e-13, le=0.1)] = Field(
        1.0e-6, description="relative tolerance of the other solvers"
    )
    atol: Annotated[Positive, Field(le=0.1)] = Field(1.0e-8, description="absolute tolerance of the other solvers")
    equilibrium: bool = Field(False, description="find the rest on the deck as it stands at the start; no time passes")

    @model_validator(mode="after")
    def _whole(self) -> Solution:
        if not self.equilibrium and self.end_s <= self.start_s:
            raise ValueError(f"end_s = {self.end_s:g} must be after start_s = {self.start_s:g}")
        for key, span, step in (
            ("end_s - start_s", self.end_s - self.start_s, self.output_step_s),
            ("output_step_s", self.output_step_s, self.substep_s),
        ):
            name = "output_step_s" if step == self.output_step_s else "substep_s"
            count = min(span / step, 1.0e300)
            if self.equilibrium and key != "output_step_s":
                continue
            if count > MOST_STEPS:
                raise ValueError(f"{key} = {span:g} s must be at most {MOST_STEPS:g} times {name} = {step:g} s")
            if abs(count - round(count)) > _WHOLE or round(count) < 1:
                raise ValueError(f"{key} = {span:g} s must be a whole number of {name} = {step:g} s")
        return self

    @property
    def rows(self) -> int:
        """Rows of output after the first."""
        return 0 if self.equilibrium else round((self.end_s - self.start_s) / self.output_step_s)


class Case(CaseSection):
    """One deterministic run. Make one with `load_case` or `case_from`."""

    name: str = Field(min_length=1, description="short name")
    title: str = Field("", description="what it is, in one line")
    source: str = Field("", description="where it comes from")
    reconstructed: str = Field("", description="what of it is rebuilt, and from what; empty: nothing")
    helicopter: str | dict[str, Any] = Field(description="name in the catalogue, file, or the document of one")
    changes: dict[str, Any] = Field(default_factory=dict, description="values of the helicopter by dotted path")
    model: ModelChoices = Field(default_factory=ModelChoices, description="choices between laws")
    held: tuple[Speed, ...] = Field((), description="generalized speeds that stay zero after the start")
    start: Start = Field(default_factory=Settled, description="where the helicopter starts")
    deck: MotionConfig = Field(default_factory=Fixed, description="motion of the deck")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="seed of what draws: seas, claw noise")
    ramp_s: NonNegative = Field(0.0, description="time over which the deck's motion about its mean grows [s]")
    claw: Claw = Field(default_factory=StillClaw, description="motion of the claw")
    patch: Patch | None = Field(None, description="a rectangle of the deck with less friction")
    probe_turn: ProbeTurn | None = Field(None, description="the probe's gauges turned about its axis")
    solution: Solution = Field(description="time span, output and solver")
    thesis_files: dict[str, dict[str, list[float]]] = Field(
        default_factory=dict, description="numbers that only the thesis' files have, kept for the way back"
    )
    provenance: tuple[Mark, ...] = Field((), description="where each value comes from")

    @field_validator("helicopter")
    @classmethod
    def _from_folder(cls, given: str | dict[str, Any], info: ValidationInfo) -> str | dict[str, Any]:
        folder = (info.context or {}).get("folder")
        if isinstance(given, dict):
            if is_leaf(given):
                raise ValueError("it must be a name, a file or the document of a helicopter, without a mark of its own")
            return dict(plain_copy(given))
        if folder is None or not given.lower().endswith((".yaml", ".yml", ".json")):
            return given
        return str(Path(folder) / given)  # an absolute path stays as it is

    @field_validator("held")
    @classmethod
    def _once(cls, held: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(held)) < len(held):
            raise ValueError("each speed may be named once only")
        return held

    @field_validator("changes")
    @classmethod
    def _own(cls, changes: dict[str, Any]) -> dict[str, Any]:
        return dict(plain_copy(changes))

    @cached_property
    def vehicle(self) -> Helicopter:
        """The helicopter with the changes applied.

        Raises:
            ConfigurationError: It does not exist, or it is refused.
        """
        if isinstance(self.helicopter, str):
            helicopter = load_helicopter(self.helicopter)
        else:
            helicopter = helicopter_from(self.helicopter, f"helicopter of case {self.name}")
        return with_changes(helicopter, self.changes) if self.changes else helicopter

    def changed(self, changes: Mapping[str, Any]) -> Case:
        """A copy with some values changed.

        Args:
            changes: New values by dotted path, e.g. ``{"start.yaw_deg": 10.0}``. ``changes`` itself is a mapping of
                changes to the helicopter, laid over those that the case has.

        Raises:
            ConfigurationError: The changed case is refused.
        """
        document = case_document(self)
        for path, value in changes.items():
            if path == "changes":
                if not isinstance(value, Mapping):
                    raise ConfigurationError(f"case {self.name}: changes = {shown(value)} is refused: give a mapping.")
                document["changes"] = {**document["changes"], **value}
                continue
            *folders, last = path.split(".")
            node = document
            for key in folders:
                if not isinstance(node.get(key), dict):
                    raise ConfigurationError(f"case {self.name}: there is no key {path} in a case.")
                node = node[key]
            node[last] = value
        return case_from(document, f"case {self.name}")


def load_case(name_or_path: str | Path) -> Case:
    """Load a case from ``configs/manoeuvres`` by its name (capitals do not matter), or from a YAML file.

    Raises:
        ConfigurationError: There is no such case, or it is refused; one sentence.
    """
    path = Path(name_or_path)
    if path.suffix.lower() not in (".yaml", ".yml", ".json"):
        path = _by_name(str(name_or_path))
    if not path.is_file():
        raise ConfigurationError(f"{path}: there is no such case file.")
    return case_from(read_file(path), str(path), path.parent.resolve())


def case_names() -> list[str]:
    """Names of the cases that ship with the package."""
    return sorted(path.stem for path in asset_path("configs", "manoeuvres").glob("*.yaml"))


def _by_name(name: str) -> Path:
    if name.lower() not in case_names():
        raise ConfigurationError(
            f"There is no case {shown(name)}: give one of {', '.join(case_names())}, or the path of a YAML file."
        )
    return asset_path("configs", "manoeuvres", f"{name.lower()}.yaml")


def case_from(document: Mapping[str, Any], source: str = "case", folder: Path | None = None) -> Case:
    """Make a case of a document, marks and all; its helicopter is loaded too, its records are read when it runs.

    Args:
        document: The content of a case file, or what `case_document` returns.
        source: Its name in messages.
        folder: Folder from which relative paths are taken.

    Raises:
        ConfigurationError: It is refused.
    """
    raw = {key: document[key] for key in _RAW if key in document}
    rest = {key: value for key, value in document.items() if key not in (*_RAW, "provenance")}
    plain, marks = split(rest, source)
    given = document.get("provenance", ())
    if not isinstance(given, list | tuple):
        raise ConfigurationError(f"{source}: provenance = {shown(given)} is refused: it must be a list of marks.")
    plain["provenance"] = [*given, *marks]
    case = validated(Case, {**plain, **raw}, source, {"folder": folder})
    case.vehicle  # noqa: B018  refused now or never
    return case


def case_document(case: Case) -> dict[str, Any]:
    """The document of a case, with each mark at its value; only lists, mappings, numbers and texts."""
    plain = case.model_dump(mode="json", exclude={"provenance"})
    raw = {key: plain.pop(key) for key in _RAW}
    document = {**join(plain, {mark.path: mark for mark in case.provenance}), **raw}
    return {key: document[key] for key in Case.model_fields if key in document}
