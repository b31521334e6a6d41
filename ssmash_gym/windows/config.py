"""A window as its YAML says it (``configs/windows``): axes, stages, limits, acceptance, effort."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from ssmash_gym.envs.loading import BASE_KEY, merged, read
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.sections import validated
from ssmash_gym.ship.sea import SEA_STATES
from ssmash_gym.windows.axes import AXES
from ssmash_gym.windows.criteria import CRITERIA
from ssmash_gym.windows.stages import STAGES, TOUCHDOWN, TRAVERSE

MOST_CELLS: Final = 200_000
MOST_SEAS: Final = 50_000_000  # of all cells together: the plan keeps a byte or so of each
Count = Annotated[int, Field(ge=1)]
Share = Annotated[float, Field(gt=0.0, lt=1.0)]
Number = Annotated[float, Field(allow_inf_nan=False)]


class Section(BaseModel):
    """Part of a window: frozen, and no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Effort(Section):
    """How many seas a cell gets: the same for all at first, then more where that decides nothing yet."""

    seeds: Count = Field(20, description="seas of every cell and policy")
    step: Count = Field(20, description="seas added to a cell that is still undecided")
    most: Count = Field(100, description="seas of a cell and policy at most")
    episodes: Count | None = Field(
        None, description="episodes at most, of all policies of a call; no such bound by default"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.most < self.seeds:
            raise ValueError(f"most = {self.most}: must be at least seeds = {self.seeds}")
        return self


class Limit(Section):
    """A figure that must not be passed, and what it rests on."""

    value: Number = Field(description="in the unit that the limit's name ends with")
    note: str = Field("assumed", description="source, or assumed")


def _spread(given: Any) -> Any:
    """``{from: 0, to: 345, by: 15}`` as a list; a list stays as it is."""
    if not isinstance(given, Mapping):
        if not isinstance(given, list | tuple):
            raise ValueError(f"{shown(given)}: give a list of numbers, or {{from: , to: , by: }}")
        return given
    if set(given) != {"from", "to", "by"}:
        raise ValueError(f"{shown(dict(given))}: give a list of numbers, or {{from: , to: , by: }}")
    first, last, by = (given[key] for key in ("from", "to", "by"))
    numbers = all(isinstance(part, int | float) and not isinstance(part, bool) for part in (first, last, by))
    if not numbers or not by > 0.0 or not last >= first or not math.isfinite(first + last + by):
        raise ValueError(f"{shown(dict(given))}: from must not exceed to, and by must be above 0")
    count = math.floor((last - first) / by + 1e-9) + 1
    if abs(first + (count - 1) * by - last) > 1e-6 * by:
        raise ValueError(f"{shown(dict(given))}: to is not reached from {first:g} in steps of {by:g}")
    if count > MOST_CELLS:
        raise ValueError(f"{shown(dict(given))}: {count} values are too many, at most {MOST_CELLS}")
    return [first + k * by for k in range(count)]


Values = Annotated[tuple[Number, ...], BeforeValidator(_spread), Field(min_length=1)]


def _bare(given: Any) -> Any:
    """A bare number as a limit."""
    return given if isinstance(given, Mapping | Limit) else {"value": given}


Figure = Annotated[Limit, BeforeValidator(_bare)]


class WindowConfig(Section):
    """An operating window; `load_window` makes it."""

    description: str = Field("", description="what it is for, in a sentence")
    seed: Annotated[int, Field(ge=0)] = Field(description="chooses the block of seas, none seen in training")
    stages: Annotated[tuple[Literal["traverse", "secured", "touchdown"], ...], Field(min_length=1)] = Field(
        (TRAVERSE,), description="what the helicopter is doing"
    )
    policies: Annotated[tuple[str, ...], Field(min_length=1)] = Field(
        ("trapezoid",), description="at the claw, where --policy names none"
    )
    task: str | dict[str, Any] = Field("traverse", description="name, file, or changes to the one that base names")
    scenario: str | dict[str, Any] = Field(description="what the cells share: name, file, or changes (key base)")
    helicopter: str = Field("generic_tricycle", description="name or file")
    axes: Annotated[dict[str, Values], Field(min_length=1)] = Field(description="what the cells differ in")
    limits: Annotated[dict[str, Figure], Field(min_length=1)] = Field(description="figures by name; none operational")
    must_arrive: bool = Field(True, description="whether a traverse that does not reach the goal in time exceeds")
    acceptance: Share = Field(0.1, description="probability of exceeding any limit in an episode that is accepted")
    confidence: Share = Field(0.95, description="of the intervals, under the stopping rule")
    effort: Effort = Effort()

    @field_validator("stages", "policies")
    @classmethod
    def _once(cls, given: tuple[str, ...]) -> tuple[str, ...]:
        for name in given:
            if given.count(name) > 1:
                raise ValueError(f"{name} is named twice")
        return given

    @field_validator("axes")
    @classmethod
    def _known_axes(cls, given: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
        for name, values in given.items():
            if name not in AXES:
                raise ValueError(f"there is no axis {name!r}; there are {', '.join(AXES)}")
            turned = {value % 360.0 for value in values} if name.endswith("_from_deg") else set(values)
            if len(turned) < len(values):
                same = ", or one that is the same direction" if name.endswith("_from_deg") else ""
                raise ValueError(f"{name}: a value is listed twice{same}")
        for state in given.get("sea_state", ()):
            if state not in SEA_STATES:
                allowed = ", ".join(map(str, SEA_STATES))
                raise ValueError(f"sea_state = {state:g}: must be one of {allowed} (no other has a source)")
        if "sea_state" in given and "hs_m" in given:
            raise ValueError("sea_state and hs_m both set the height of the waves: leave one of them out")
        if math.prod(map(len, given.values())) > MOST_CELLS:
            raise ValueError(f"{math.prod(map(len, given.values()))} cells are too many, at most {MOST_CELLS}")
        return given

    @field_validator("limits")
    @classmethod
    def _known_limits(cls, given: dict[str, Limit]) -> dict[str, Limit]:
        for name, limit in given.items():
            if name not in CRITERIA:
                raise ValueError(f"there is no limit {name!r}; there are {', '.join(CRITERIA)}")
            if CRITERIA[name].sense == "above" and limit.value <= 0.0:
                raise ValueError(f"{name} = {limit.value:g}: must be above 0, or every episode exceeds it")
            if CRITERIA[name].sense == "below" and limit.value < 0.0:
                raise ValueError(f"{name} = {limit.value:g}: must be at least 0")
        return given

    @model_validator(mode="after")
    def _suited(self) -> Self:
        for name in self.axes:
            stage = AXES[name].stage
            if stage is not None and self.stages != (stage,):
                raise ValueError(f"axes.{name} is of the stage {stage} alone: a window with it must have no other")
        if TOUCHDOWN in self.stages and "least_station_kN" in self.limits:
            raise ValueError(
                "limits.least_station_kN is refused with the stage touchdown: a helicopter in the air stands on "
                "nothing at first (in a window with a base, null takes a limit away)"
            )
        seas = math.prod(map(len, self.axes.values())) * self.effort.most
        if seas > MOST_SEAS:
            raise ValueError(f"cells times effort.most are {seas:,}, at most {MOST_SEAS:,}")
        return self

    @property
    def figures(self) -> dict[str, float]:
        """The limits as plain numbers by name."""
        return {name: limit.value for name, limit in self.limits.items()}

    def arrives(self, stage: str) -> bool:
        """Whether an episode of a stage that does not reach the goal counts as exceeding."""
        return self.must_arrive and STAGES[stage].arrives


def load_window(window: str | Path | Mapping[str, Any]) -> WindowConfig:
    """Load a window: a name in ``configs/windows``, a YAML file, or a ready document.

    A file may have the key ``base``, the name or file of another window that its other keys change, key by key; null
    takes an axis or a limit of the base away.

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed; one sentence.
    """
    if isinstance(window, Mapping):
        return validated(WindowConfig, window, "window")
    document, source = _read(window, ())
    return validated(WindowConfig, document, source)


def _read(window: str | Path, above: tuple[str, ...]) -> tuple[dict[str, Any], str]:
    """The document of a window laid over those of its bases, and its name in messages.

    Raises:
        ConfigurationError: A file cannot be read, or a window is its own base.
    """
    if str(window) in above:
        raise ConfigurationError(f"windows: {' -> '.join((*above, str(window)))}: a window is its own base.")
    document, source = read("windows", window)
    document = _placed(document, Path(window).parent) if Path(window).suffix else document
    if BASE_KEY not in document:
        return document, source
    base, _ = _read(str(document.pop(BASE_KEY)), (*above, str(window)))
    laid = merged(base, document)
    for key in ("axes", "limits"):
        if isinstance(laid.get(key), Mapping):
            laid[key] = {name: value for name, value in laid[key].items() if value is not None}
    return laid, source


def _placed(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """A document whose files (base, scenario, task, helicopter) are taken from its own folder."""
    placed = dict(document)
    for key in (BASE_KEY, "scenario", "task", "helicopter"):
        value = placed.get(key)
        if isinstance(value, str) and value.endswith((".yaml", ".yml", ".json")):
            placed[key] = str(folder / value)  # an absolute path stays as it is
        elif isinstance(value, Mapping) and str(value.get(BASE_KEY, "")).endswith((".yaml", ".yml")):
            placed[key] = {**value, BASE_KEY: str(folder / str(value[BASE_KEY]))}
    return placed
