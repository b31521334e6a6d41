"""A system: another simulation or test vehicle of the thesis, as settings laid over a case of this one.

Léveillé (2013), section 1.1.1, reviews what was there before. Each of these is a subset of the present model, so that
one YAML file in ``configs/systems`` says it all: what changes in the helicopter, which speeds are held, whether deck,
claw and probe act, and at what length scale.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import Field, ValidationError, field_validator

from ssmash_gym.assets import asset_path
from ssmash_gym.cases.description import SPEEDS, ModelChoices, Speed
from ssmash_gym.document import read_file
from ssmash_gym.errors import ConfigurationError, shown
from ssmash_gym.fields import Part, Positive
from ssmash_gym.sections import sentence, validated
from ssmash_gym.systems.scaling import GREATEST, LEAST

FULL: Final = "ssmash"  # the system that changes nothing
_SUFFIXES: Final = (".yaml", ".yml", ".json")


class System(Part):
    """One system. Make one with `load_system` or `system_from`; lay it over a case with `apply`."""

    name: str = Field(min_length=1, description="short name; that of the file")
    title: str = Field(min_length=1, description="what it is, in one line")
    source: str = Field(min_length=1, description="who made it, and where the thesis speaks of it")
    answers: tuple[str, ...] = Field((), description="what it can answer")
    cannot: tuple[str, ...] = Field((), description="what it cannot, and where it differs from its original")
    changes: dict[str, Any] = Field(default_factory=dict, description="values of the helicopter by dotted path")
    suspension: Literal["keep", "in_tires"] = Field(
        "keep", description="in_tires: carriages rigid with the body, struts in series with linear tires"
    )
    axes: Literal["keep", "level"] = Field(
        "keep", description="level: body axes parallel to the deck at rest, so that held speeds leave a plane motion"
    )
    held: tuple[Speed, ...] = Field((), description="generalized speeds that stay zero after the start")
    model: dict[str, str] = Field(default_factory=dict, description="choices between laws, as in a case")
    starts: tuple[Literal["settled", "drop", "state"], ...] = Field(
        ("settled", "drop", "state"), description="starts of a case that it can take"
    )
    deck: Literal["keep", "level"] = Field("keep", description="level: a level, still deck whatever the case says")
    claw: Literal["keep", "still"] = Field("keep", description="still: the claw stays where it starts")
    probe: Literal["keep", "off"] = Field("keep", description="off: nothing secures the helicopter")
    scale: Annotated[Positive, Field(ge=LEAST, le=GREATEST)] = Field(
        1.0, description="length of the vehicle over that of the case's, Froude-scaled"
    )

    @field_validator("held")
    @classmethod
    def _in_order(cls, held: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name in SPEEDS if name in held)

    @field_validator("model")
    @classmethod
    def _known_laws(cls, model: dict[str, str]) -> dict[str, str]:
        try:
            ModelChoices.model_validate(model)
        except ValidationError as error:
            raise ValueError(sentence(ModelChoices, error, "model").rstrip(".")) from None
        return model


def system_names() -> list[str]:
    """Names of the systems that ship with the package, the full model first."""
    names = sorted(path.stem for path in asset_path("configs", "systems").glob("*.yaml"))
    return sorted(names, key=lambda name: name != FULL)


def load_system(name_or_path: str | Path) -> System:
    """Load a system by its name (capitals do not matter) or from a YAML file.

    Raises:
        ConfigurationError: There is no such system, or its file is refused; one sentence.
    """
    path = Path(name_or_path)
    if path.suffix.lower() not in _SUFFIXES:
        name = str(name_or_path).lower().replace("-", "_")
        if name not in system_names():
            raise ConfigurationError(
                f"There is no system {shown(str(name_or_path))}: give one of {', '.join(system_names())}, or the path "
                "of a YAML file."
            )
        path = asset_path("configs", "systems", f"{name}.yaml")
    if not path.is_file():
        raise ConfigurationError(f"{path}: there is no such system file.")
    return system_from(read_file(path), str(path), path.stem)


def system_from(document: Mapping[str, Any], source: str = "system", name: str = "") -> System:
    """Make a system of a document.

    Args:
        document: Its keys and values.
        source: Its name in messages.
        name: Its name where the document gives none.

    Raises:
        ConfigurationError: It is refused; one sentence.
    """
    return validated(System, {**({"name": name} if name else {}), **document}, source)
