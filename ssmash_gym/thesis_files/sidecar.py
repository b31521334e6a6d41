"""beyond_thesis.yaml: what the six files cannot hold, beside them.

It has up to four parts. ``beyond``: values that the files have no place for. ``instead``: values that the files hold in
another form (a settled start as its numbers, say), each with what the file held; once the file holds something else,
the file is right. ``marks``: where the numbers of the files come from, for as long as the files hold those numbers.
``written_as``: names of what stands in the files in full (a helicopter of the catalogue, a record), for as long as
they mean the same.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel

from ssmash_gym.cases import Case
from ssmash_gym.document import Mark, join, read_yaml, split, write_yaml
from ssmash_gym.errors import ConfigurationError, refusal
from ssmash_gym.thesis_files.document import models_of
from ssmash_gym.thesis_files.folder import SIDECAR, digest
from ssmash_gym.thesis_files.heli_layout import HELI
from ssmash_gym.thesis_files.paths import MISSING, differences, expand, gathered, get, leaves, put
from ssmash_gym.thesis_files.reading import Rows
from ssmash_gym.vehicle import Helicopter

PARTS: Final = ("beyond", "instead", "marks", "written_as")
HEAD: Final = """\
# What the thesis' files in this folder cannot hold; `ssmash run` and `ssmash convert` read it with them.
# beyond: values without a place in the files. instead: values that the files hold in another form, valid for as long
# as the file holds what stands under `file`. marks: where numbers of the files come from. written_as: names of what
# stands in the files in full.
"""
_CASE: Final = {
    "start",
    *(f"solution.{key}" for key in ("start_s", "end_s", "output_step_s", "solver", "rtol", "atol")),
    *(f"deck.{key}" for key in ("dof", "amplitude_deg", "amplitude_m", "period_s", "roll_deg", "pitch_deg", "yaw_deg")),
    *(f"claw.{key}" for key in ("x_m", "y_m", "z_m")),
    "deck",
    "claw",
}
RECORDS: Final = ("deck.path", "claw.path")
TYPES: Final = ("deck.type", "claw.type")
_OF_CHOICE: Final = ("deck.", "claw.", "start.", "helicopter.stations.")  # what is there hangs on choices in the files


def _in_files() -> frozenset[str]:
    """Patterns of the values of a case that stand in the files; a vector is one value."""
    return frozenset(f"helicopter.{_leaf(column.path)}" for line in HELI for column in line.columns) | _CASE


def _leaf(path: str) -> str:
    """The path of the vector or tensor that an entry belongs to, stations and tires as they are."""
    keys = path.split(".")
    while keys[-1].isdigit():
        keys.pop()
    return ".".join(keys)


IN_FILES: Final = _in_files()


def in_files(path: str) -> bool:
    """Whether the files hold the value of a path (in this or another form)."""
    return (
        path in IN_FILES or any("*" in known and _fits(known, path) for known in IN_FILES) or path.startswith("start.")
    )


def _held(path: str) -> bool:
    """Whether the files hold a value, the vector that it is an entry of, or a part of it."""
    if in_files(path) or in_files(_leaf(path)) or path in TYPES:
        return True
    return any(_fits(".".join(known.split(".")[: path.count(".") + 1]), path) for known in IN_FILES)


def _fits(known: str, path: str) -> bool:
    one, other = known.split("."), path.split(".")
    return len(one) == len(other) and all(a in ("*", b) for a, b in zip(one, other, strict=True))


@dataclass(frozen=True)
class Sidecar:
    """The content of the file, paths in their short form (``*`` for all stations and tires)."""

    beyond: Mapping[str, Any]
    instead: Mapping[str, Any]
    marks: Mapping[str, Any]
    written_as: Mapping[str, Any]

    @property
    def text(self) -> str:
        """The file."""
        parts = {name: dict(getattr(self, name)) for name in PARTS}
        return HEAD + write_yaml({name: part for name, part in parts.items() if part})


EMPTY: Final = Sidecar({}, {}, {}, {})


def in_brief(section: Any, numbers: Rows | None) -> Any:
    """What stands under ``file``: the value itself, or a record's numbers by their digest."""
    if isinstance(section, Mapping) and section.get("type") == "file" and numbers is not None:
        return {"type": "file", "numbers": digest(numbers)}
    return section


# --- writing -------------------------------------------------------------------------------------------------------


def sidecar_of(
    document: Mapping[str, Any],
    marks: Mapping[str, Mark],
    filed: Mapping[str, Any],
    numbers: Mapping[str, Rows],
    always: Iterable[str],
    written_as: Mapping[str, Any],
) -> Sidecar:
    """The sidecar that makes of what the files say what the case says.

    Args:
        document: The complete plain document of the case.
        marks: Its marks, by path in it.
        filed: The complete plain document that reading the files without a sidecar gives.
        numbers: Numbers of the files.
        always: Paths for which reading the files takes defaults: they are written even where they are the same.
        written_as: Names to keep.
    """
    beyond: dict[str, Any] = {}
    instead: dict[str, Any] = {}
    for path in differences(document, filed):
        if path in RECORDS:
            continue
        value = join(get(document, path), marks, path)
        if in_files(path):
            instead[path] = {"file": in_brief(get(filed, path), numbers.get(path)), "case": value}
        else:
            beyond[path] = value
    for path in always:
        if get(document, path) is not MISSING:
            beyond.setdefault(path, join(get(document, path), marks, path))
    told = [*beyond, *instead]
    rest = {path for path in marks if not any((path + ".").startswith(known + ".") for known in told)}
    kept = {leaf: join(value, marks, leaf) for leaf, value in _marked_leaves(document, rest)}
    short = [gathered(part, document) for part in (beyond, instead, kept)]
    return Sidecar(short[0], short[1], short[2], dict(written_as))


def _marked_leaves(document: Mapping[str, Any], marked: set[str]) -> Iterator[tuple[str, Any]]:
    for path, value in leaves(document):
        if any((mark + ".").startswith(path + ".") for mark in marked):
            yield path, value


# --- reading -------------------------------------------------------------------------------------------------------


def load(folder: Path) -> Sidecar:
    """The sidecar of a folder; an empty one if there is none.

    Raises:
        ConfigurationError: It cannot be read, or has parts that it should not have.
    """
    path = folder / SIDECAR
    if not path.exists():
        return EMPTY
    try:
        content = read_yaml(path.read_text(encoding="utf-8"), str(path))
    except ConfigurationError as error:
        raise ConfigurationError(" ".join(str(error).split())) from None  # a reader of YAML may tell it in two lines
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror or error}).") from None
    except UnicodeDecodeError:
        raise ConfigurationError(f"{path}: this is not a text in UTF-8.") from None
    for key, part in content.items():
        if key not in PARTS:
            raise ConfigurationError(f"{path}: there is no part {key}; allowed are {', '.join(PARTS)}.")
        if not isinstance(part, dict) or not all(isinstance(name, str) for name in part):
            raise refusal(str(path), str(key), part, "it must be a mapping of keys to values")
    for key, entry in content.get("instead", {}).items():
        if not isinstance(entry, dict) or set(entry) != {"file", "case"}:
            raise refusal(str(path), f"instead.{key}", entry, "it must have the keys file and case")
    return Sidecar(**{name: content.get(name, {}) for name in PARTS})


def apply(
    sidecar: Sidecar, filed: Mapping[str, Any], numbers: Mapping[str, Rows], source: str
) -> tuple[dict[str, Any], dict[str, Mark], list[str], set[str]]:
    """Lay a sidecar over what the files say.

    Args:
        sidecar: The sidecar.
        filed: The complete plain document of the files.
        numbers: Numbers of the files.
        source: Name of the sidecar in messages.

    Returns:
        The plain document, its marks by path, remarks on what is no longer valid, and the paths that it gave.

    Raises:
        ConfigurationError: A path that no case has or that the files hold, or a mark that is not well formed.
    """
    document: dict[str, Any] = copy.deepcopy(dict(filed))
    marks: dict[str, Mark] = {}
    remarks: list[str] = []
    given: set[str] = set()
    gone: list[str] = []
    for path, entry in _full(sidecar.instead, filed, source, "instead", gone):
        if in_brief(get(filed, path), numbers.get(path)) == entry["file"]:
            _set(document, marks, path, entry["case"], source)
        else:
            remarks.append(f"{path} is taken from the files: they have been changed since {source} was written")
    for path, value in _full(sidecar.beyond, document, source, "beyond", gone):
        if _held(path):
            raise ConfigurationError(f"{source}: beyond.{path} is refused: the files hold it; change it there.")
        _set(document, marks, path, value, source)
        given.add(path)
    dropped = []
    for path, value in _full(sidecar.marks, document, source, "marks", gone):
        bare, found = split(value, source, path)
        if bare == get(document, path):
            marks.update({mark["path"]: Mark(**mark) for mark in found})
        else:
            dropped.append(path)
    if dropped:
        remarks.append(f"the marks of {', '.join(dropped)} are dropped: the numbers have been changed since")
    if gone:
        told = ", ".join(dict.fromkeys(gone))
        remarks.append(f"dropped from {source}, of what has another type or number in the files now: {told}")
    return document, marks, remarks, given


def _full(
    part: Mapping[str, Any], document: Mapping[str, Any], source: str, name: str, gone: list[str]
) -> Iterator[tuple[str, Any]]:
    """Entries of a part by full paths; ``gone`` takes the paths that another type or number in the files has removed.

    Raises:
        ConfigurationError: A path that no case has.
    """
    for short, value in part.items():
        paths = [path for path in expand(document, short) if get(document, path) is not MISSING]
        if not paths:
            if not (short.startswith(_OF_CHOICE) and _possible(short)):
                raise ConfigurationError(f"{source}: {name}.{short} is refused: this case has no such key.")
            gone.append(short)
        for path in paths:
            yield path, value


def _possible(path: str) -> bool:
    """Whether a case of other types and numbers has a path."""
    head, _, rest = path.partition(".")
    model: type[BaseModel] = Case
    if head == "helicopter":
        model, path = Helicopter, rest
    return _in(model, path.split("."))


def _in(annotation: Any, keys: list[str]) -> bool:
    if not keys:
        return True
    key, rest = keys[0], keys[1:]
    models = models_of(annotation)
    entry = key == "*" or key.isdigit()
    if not models:
        return entry and _in(annotation, rest)
    if entry and _in(annotation, rest):
        return True
    fields = [field for model in models for known, field in model.model_fields.items() if key in (known, "*")]
    return any(_in(field.annotation, rest) for field in fields)


def _set(document: dict[str, Any], marks: dict[str, Mark], path: str, value: Any, source: str) -> None:
    bare, found = split(value, source, path)
    put(document, path, copy.deepcopy(bare))
    marks.update({mark["path"]: Mark(**mark) for mark in found})
