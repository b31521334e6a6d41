"""A section of a configuration becomes a motion source."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import Field, TypeAdapter, ValidationError

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.seaway import Seaway
from ssmash_gym.ship.sources import Fixed, Irregular, MotionFile, Section, Sinusoid

# For a field of a larger model; a relative path of a record is then taken from `context={"folder": ...}`.
MotionConfig = Annotated[Fixed | Sinusoid | Irregular | MotionFile | Seaway, Field(discriminator="type")]
_ADAPTER: Final[TypeAdapter[Fixed | Sinusoid | Irregular | MotionFile | Seaway]] = TypeAdapter(MotionConfig)
_SECTIONS: Final[dict[str, type[Section]]] = {
    "fixed": Fixed,
    "sinusoid": Sinusoid,
    "irregular": Irregular,
    "file": MotionFile,
    "seaway": Seaway,
}


def parse_motion(
    section: Mapping[str, Any], *, folder: str | Path | None = None, where: str = "motion"
) -> Fixed | Sinusoid | Irregular | MotionFile | Seaway:
    """The motion source that a section describes, for example ``{"type": "fixed", "roll_deg": 5}``.

    Args:
        section: Mapping with `type` (fixed, sinusoid, irregular, file or seaway) and that type's keys.
        folder: Folder of the configuration file, from which a relative `path` is taken.
        where: What the section is called in messages.

    Raises:
        ConfigurationError: An unknown type or key, a missing key, or a value that is not allowed.
    """
    if not isinstance(section, Mapping):
        raise ConfigurationError(f"{where}: expected keys and values, found {section!r}")
    kind = section.get("type")
    if kind not in _SECTIONS:
        raise ConfigurationError(f"{where}.type is {kind!r}, allowed are {', '.join(_SECTIONS)}")
    try:
        return _ADAPTER.validate_python(dict(section), context={"folder": folder})
    except ValidationError as error:
        raise ConfigurationError(_sentence(where, str(kind), error)) from None


def _sentence(where: str, kind: str, error: ValidationError) -> str:
    """The first mistake in one sentence: key, value and what is allowed."""
    first = error.errors(include_url=False)[0]
    path = [str(part) for part in first["loc"] if part != kind]
    key = ".".join([where, *path])
    if first["type"] == "missing":
        return f"{key} is missing from the {kind} motion ({_allowed(kind, path)})"
    if first["type"] == "extra_forbidden":
        return f"{key} is not a key of the {kind} motion ({_allowed(kind, path)})"
    if first["type"] in ("model_type", "dict_type"):
        return f"{key} is {first['input']!r}, expected keys and values ({_allowed(kind, [*path, ''])})"
    if first["type"] == "value_error":
        return f"{key}: {first['ctx']['error']}"
    return f"{key} is {first['input']!r}: {first['msg'][:1].lower()}{first['msg'][1:]}"


def _allowed(kind: str, path: list[str]) -> str:
    """The keys that may stand where `path` ends."""
    fields: Any = _SECTIONS[kind].model_fields
    for name in path[:-1]:
        model = next(arg for arg in fields[name].annotation.__args__ if hasattr(arg, "model_fields"))
        fields = model.model_fields
    return f"allowed are {', '.join(fields)}"
