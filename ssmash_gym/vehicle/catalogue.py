"""Loading, saving and changing helicopters; every refusal is one sentence."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from ssmash_gym.assets import asset_path
from ssmash_gym.document import join, plain_copy, read_file, split, write_yaml
from ssmash_gym.errors import ConfigurationError, refusal, shown
from ssmash_gym.vehicle.description import Helicopter

_SUFFIXES: Final = (".yaml", ".yml", ".json")
_SPRINGS: Final = ("gas_oleo", "linear_strut")
_ALLOWED: Final = {
    "greater_than": "it must be greater than {gt:g}",
    "greater_than_equal": "it must be at least {ge:g}",
    "less_than": "it must be less than {lt:g}",
    "less_than_equal": "it must be at most {le:g}",
    "float_type": "it must be a number",
    "finite_number": "it must be a finite number",
    "bool_type": "it must be true or false",
    "string_type": "it must be a text",
    "string_too_short": "it must not be empty",
    "literal_error": "it must be {expected}",
    "tuple_type": "it must be a list of numbers",
    "model_type": "it must be a mapping of keys to values",
    "union_tag_invalid": "its type must be one of {expected_tags}",
    "union_tag_not_found": "it needs a type, gas_oleo or linear_strut",
    "too_long": "it must have at most {max_length} entries",
    "too_short": "it must have at least {min_length} entries",
}


def helicopter_names() -> list[str]:
    """Names of the helicopters that ship with the package."""
    return sorted(path.stem for path in asset_path("configs", "helicopters").glob("*.yaml"))


def load_helicopter(path_or_name: str | Path) -> Helicopter:
    """Load a helicopter.

    Args:
        path_or_name: A name of `helicopter_names`, or the path of a YAML or JSON file.

    Raises:
        ConfigurationError: There is no such file or name, or the description is refused; one sentence that names the
            file, the key, the value and what is allowed.
    """
    path = Path(path_or_name)
    if path.suffix.lower() in _SUFFIXES or isinstance(path_or_name, Path):
        if not path.is_file():
            raise ConfigurationError(f"{path}: there is no such helicopter file.")
    else:
        if str(path_or_name) not in helicopter_names():
            raise ConfigurationError(
                f"There is no helicopter {path_or_name!r}: give one of {', '.join(helicopter_names())}, or the path of "
                "a YAML file."
            )
        path = asset_path("configs", "helicopters", f"{path_or_name}.yaml")
    return helicopter_from(read_file(path), str(path))


def helicopter_from(document: Mapping[str, Any], source: str = "helicopter") -> Helicopter:
    """Build a helicopter from a document, marks and all.

    Args:
        document: The content of a helicopter file, or what `document_of` or ``Helicopter.model_dump`` returns.
        source: Its name in messages.

    Raises:
        ConfigurationError: The description is refused.
    """
    plain, marks = split({key: child for key, child in document.items() if key != "provenance"}, source)
    plain["provenance"] = [*document.get("provenance", ()), *marks]
    try:
        return Helicopter.model_validate(plain)
    except ValidationError as error:
        raise _one_sentence(error, source) from None


def document_of(helicopter: Helicopter) -> dict[str, Any]:
    """The document of a helicopter, with each mark at its value; only lists, mappings, numbers and texts."""
    plain = helicopter.model_dump(mode="json", exclude={"provenance"})
    document: dict[str, Any] = join(plain, helicopter.marks)
    return document


def save_helicopter(helicopter: Helicopter, path: str | Path) -> None:
    """Write a helicopter to a YAML (or, by its suffix, JSON) file that `load_helicopter` reads back without loss.

    Raises:
        ConfigurationError: The suffix is neither ``.yaml``, ``.yml`` nor ``.json``.
    """
    path = Path(path)
    if path.suffix.lower() not in _SUFFIXES:
        raise ConfigurationError(f"{path}: the file name must end in one of {', '.join(_SUFFIXES)}.")
    document = document_of(helicopter)
    text = json.dumps(document, indent=1) if path.suffix.lower() == ".json" else write_yaml(document)
    path.write_text(text, encoding="utf-8")


def with_changes(helicopter: Helicopter, changes: Mapping[str, Any]) -> Helicopter:
    """Copy a helicopter with some values changed; the copy is validated like a file.

    Args:
        helicopter: The helicopter, left as it is.
        changes: New values by dotted path; ``*`` stands for every key or entry at its place, as in
            ``stations.*.tires.*.friction_coefficient``. A marked leaf ``{value: ..., origin: ...}`` sets the mark
            too; a bare value loses its mark, for it no longer comes from where the old one came from.

    Raises:
        ConfigurationError: A path does not exist, or the changed helicopter is refused.
    """
    source = f"changes to {helicopter.name}"
    document = helicopter.model_dump(mode="json", exclude={"provenance"})
    marks = [mark.model_dump() for mark in helicopter.provenance]
    for pattern, given in changes.items():
        paths = _expand(document, pattern.split("."))
        if not paths:
            raise ConfigurationError(f"{source}: there is no key {pattern} in a helicopter.")
        for keys in paths:
            path = ".".join(str(key) for key in keys)
            plain, new = split(plain_copy(given), source, path)
            functools.reduce(lambda node, key: node[key], keys[:-1], document)[keys[-1]] = plain
            marks = [m for m in marks if not _touches(m["path"], path)] + new
    return helicopter_from({**document, "provenance": marks}, source)


def _expand(node: Any, keys: list[str]) -> list[list[Any]]:
    """Every path of a document that fits a pattern."""
    if not keys:
        return [[]]
    if isinstance(node, dict):
        here: list[tuple[Any, Any]] = [(k, v) for k, v in node.items() if keys[0] in ("*", k)]
    elif isinstance(node, list):
        here = [(k, v) for k, v in enumerate(node) if keys[0] in ("*", str(k))]
    else:
        here = []
    return [[key, *rest] for key, child in here for rest in _expand(child, keys[1:])]


def _touches(marked: str, changed: str) -> bool:
    return (marked + ".").startswith(changed + ".") or (changed + ".").startswith(marked + ".")


def _one_sentence(error: ValidationError, source: str) -> ConfigurationError:
    problems = error.errors(include_url=False)
    first = problems[0]
    path = ".".join(str(key) for key in _location(first))
    context = first.get("ctx", {})
    if first["type"] == "missing":
        sentence = f"{source}: {path} is missing{_meaning(path)}."
    elif first["type"] == "refused":
        path = ".".join(part for part in (path, context["key"]) if part)
        sentence = str(refusal(source, path, context["value"], context["allowed"]))
    else:
        allowed = _ALLOWED.get(first["type"], "").format(**context) or first["msg"]
        if first["type"] == "missing_argument":
            allowed = "it must have all its entries"
        sentence = f"{source}: {path} = {shown(first['input'])} is refused: {allowed}{_meaning(path)}."
    more = len(problems) - 1
    return ConfigurationError(sentence if not more else f"{sentence[:-1]} (and {more} more of the kind).")


def _location(problem: ErrorDetails) -> list[int | str]:
    """Location of a problem without the tag that pydantic puts behind a spring's key."""
    keys = list(problem["loc"])
    return [key for k, key in enumerate(keys) if not (key in _SPRINGS and k > 0 and keys[k - 1] == "spring")]


def _meaning(path: str) -> str:
    """What the field of a path means, in parentheses, if the path leads to one."""
    parts: list[type[BaseModel]] = [Helicopter]
    text = ""
    for key in path.split("."):
        if key.isdigit():
            continue
        fields = [part.model_fields[key] for part in parts if key in part.model_fields]
        if not fields:
            return ""
        text = fields[0].description or ""
        parts = [part for field in fields for part in _models_in(field.annotation)]
    return f" ({text})" if text else ""


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """The parts that an annotation speaks of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for argument in get_args(annotation) for model in _models_in(argument)]
