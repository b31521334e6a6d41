"""Sections of a configuration: validated models, and the first mistake told in one sentence."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ValidationError, ValidationInfo

from ssmash_gym.errors import ConfigurationError, shown

Model = TypeVar("Model", bound=BaseModel)


def _from_folder(path: Path, info: ValidationInfo) -> Path:
    folder = (info.context or {}).get("folder")
    return path if folder is None else Path(folder) / path  # an absolute path stays as it is


FilePath = Annotated[Path, AfterValidator(_from_folder)]  # relative ones are taken from ``context={"folder": ...}``


def validated(
    model: type[Model], document: Mapping[str, Any], source: str, context: Mapping[str, Any] | None = None
) -> Model:
    """Make the section of a document.

    Args:
        model: What to make of it.
        document: Its keys and values.
        source: Its name in messages.
        context: What pydantic hands to the validators, e.g. the folder of the file.

    Raises:
        ConfigurationError: It is refused; the first mistake in one sentence.
    """
    try:
        return model.model_validate(dict(document), context=dict(context or {}))
    except ValidationError as error:
        raise ConfigurationError(sentence(model, error, source)) from None


def sentence(model: type[BaseModel], error: ValidationError, source: str) -> str:
    """The first mistake in one sentence: source, key, value and what is allowed."""
    first = error.errors(include_url=False)[0]
    path, fields = _walk(model, first["loc"])
    if first["type"] == "refused":  # see fields.refuse
        about = first["ctx"]
        key = ".".join(part for part in (*path, str(about["key"])) if part)
        return f"{source}: {key} = {shown(about['value'])} is refused: {about['allowed']}."
    key = ".".join(path)
    if first["type"] == "extra_forbidden":
        return f"{source}: there is no key {key}; allowed here are {', '.join(fields)}."
    if first["type"] == "missing":
        return f"{source}: the key {key} is missing."
    if first["type"] == "value_error":
        return f"{source}: {key} is refused: {first['ctx']['error']}." if key else f"{source}: {first['ctx']['error']}."
    message = first["msg"][:1].lower() + first["msg"][1:]
    return f"{source}: {key} = {shown(first['input'])} is refused: {message}."


def _walk(model: type[BaseModel], location: tuple[int | str, ...]) -> tuple[list[str], list[str]]:
    """The location without the tags of unions, and the keys allowed where it ends."""
    path: list[str] = []
    here: list[type[BaseModel]] = [model]
    for step in location:
        tagged = [m for m in here if "type" in m.model_fields and step in get_args(m.model_fields["type"].annotation)]
        if tagged:
            here = tagged
            continue
        path.append(str(step))
        if step != location[-1]:
            here = [m for part in here if step in part.model_fields for m in _models(part.model_fields[str(step)])]
    return path, sorted({name for part in here for name in part.model_fields})


def _models(field: Any) -> list[type[BaseModel]]:
    """The sections that a field may hold."""
    return _sections(getattr(field, "annotation", field))


def _sections(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, BaseModel) else []
    if get_origin(annotation) is None or get_origin(annotation) not in (Union, *_UNIONS):
        return []
    return [model for part in get_args(annotation) for model in _sections(part)]


_UNIONS: Final = (type(int | str),)
