"""A case becomes a folder of the thesis' files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ssmash_gym.cases import Case
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import whole_files
from ssmash_gym.thesis_files import document as documents
from ssmash_gym.thesis_files import folder as folders
from ssmash_gym.thesis_files import sidecar as sidecars
from ssmash_gym.thesis_files.case import case_of
from ssmash_gym.thesis_files.defaults import CASE
from ssmash_gym.thesis_files.folder import SIDECAR
from ssmash_gym.thesis_files.kept import RECORDS, put_back
from ssmash_gym.thesis_files.layout import GREATEST
from ssmash_gym.thesis_files.paths import differences, gathered, get
from ssmash_gym.thesis_files.reading import Rows, find
from ssmash_gym.thesis_files.run_layout import FILES
from ssmash_gym.vehicle import document_of

SAME: Final = 1e-12  # share by which two numbers may differ and be the same
UNSTRAINED: Final = (
    "start: initials.inp has no place for the tires' stored deflections; read without the sidecar they start at zero"
)
WORDS: Final = ("name", "title", "source", "reconstructed", "helicopter.name", "helicopter.description", "seed")


@dataclass(frozen=True)
class Written:
    """What became of a case in a folder.

    Attributes:
        files: The files; the sidecar, if there is one, is the last.
        sidecar: Whether there is one.
        beyond: Values that the files have no place for, by name.
        words: Names and texts that they have no place for.
        instead: What they hold in another form, by name.
        marks: How many values carry a mark of their origin.
        notes: What else is to be known, in words.
    """

    files: tuple[Path, ...]
    sidecar: bool
    beyond: tuple[str, ...]
    words: tuple[str, ...]
    instead: tuple[str, ...]
    marks: int
    notes: tuple[str, ...]


def write_case(
    case: Case | Mapping[str, Any], folder: str | Path, *, sidecar: bool = True, overwrite: bool = False
) -> Written:
    """Write a case as a folder of the thesis' files, whole or not at all.

    Args:
        case: The case, or its document.
        folder: Folder to write to; made if it is not there.
        sidecar: Write what the files cannot hold into ``beyond_thesis.yaml`` beside them. Without it a case is
            refused that would not be the same without.
        overwrite: Replace such files that are there.

    Raises:
        ConfigurationError: The case is refused, cannot be held by the files alone, or the folder has such files.
    """
    target = Path(folder)
    made, kept = (case, {}) if isinstance(case, Case) else case_of(case, "case")
    check_target(target, overwrite)
    filing = documents.Filing(made)
    numbers = dict(filing.numbers)
    places: dict[str, str] = {key: str((target / FILES[key].name).resolve()) for key in RECORDS if key in numbers}
    for key, path in places.items():
        filing.document[key]["path"] = path
    filed, taken = documents.from_numbers(numbers, target.resolve().name, places, set())
    put_back(numbers, kept, filed)
    lost = _lost(filing.document, filed)
    if lost and not sidecar:
        raise ConfigurationError(
            f"case {made.name}: the thesis' files alone cannot hold {', '.join(gathered(lost, filed))}; allow the "
            f"sidecar {SIDECAR}, or change the case."
        )
    marks = {f"helicopter.{mark.path}": mark for mark in made.vehicle.provenance}
    marks |= {mark.path: mark for mark in made.provenance}
    names = _names(made, target)
    always = ("name", "helicopter.name", *taken, *(default.path for default in CASE))
    beside = sidecars.sidecar_of(documents.plain(made), marks, filed, numbers, always, names)
    _check_size(made.name, numbers)
    texts = {target / FILES[key].name: text for key, text in folders.texts(numbers).items()}
    if sidecar:
        texts[target / SIDECAR] = beside.text
    _write(target, texts)
    words = tuple(path for path in beside.beyond if path in WORDS)
    beyond = tuple(path for path in beside.beyond if path not in words)
    notes = (UNSTRAINED,) if made.start.type == "settled" else ()
    called = [f"{key}: {name}" for key, name in names.items() if isinstance(name, str)]
    return Written(tuple(texts), sidecar, beyond, (*words, *called), tuple(beside.instead), len(marks), notes)


def check_target(folder: Path, overwrite: bool) -> None:
    """Refuse a place that is no folder, or has files that would be replaced.

    Raises:
        ConfigurationError: It is refused.
    """
    if folder.exists() and not folder.is_dir():
        raise ConfigurationError(f"{folder}: this is a file, expected a folder.")
    if not folder.is_dir():
        return
    there = [path for file in FILES.values() if (path := find(folder, file)) is not None]
    there += [folder / SIDECAR] if (folder / SIDECAR).exists() else []
    if there and not overwrite:
        raise ConfigurationError(
            f"{folder}: {there[0].name} is there already; give another folder, or allow to overwrite."
        )
    odd = [path for path in there if path.name not in (*(file.name for file in FILES.values()), SIDECAR)]
    if odd:
        raise ConfigurationError(f"{folder}: {odd[0].name} is there already under another name; give another folder.")


def _check_size(name: str, numbers: Mapping[str, Rows]) -> None:
    """Refuse numbers that the reader would refuse.

    Raises:
        ConfigurationError: One is out of bounds.
    """
    for key, rows in numbers.items():
        for k, row in enumerate(rows, start=1):
            for number in row:
                if not abs(number) <= GREATEST:
                    raise ConfigurationError(
                        f"case {name}: {number:g}, for line {k} of {FILES[key].name}, is refused: the thesis' files "
                        f"hold numbers within {GREATEST:g} of zero."
                    )


def _lost(wanted: Mapping[str, Any], filed: Mapping[str, Any]) -> dict[str, Any]:
    """What of the case in the files' form the files do not say, words apart."""
    lost = {}
    for path in differences(wanted, filed):
        a, b = get(wanted, path), get(filed, path)
        close = isinstance(a, float) and isinstance(b, float) and abs(a - b) <= SAME * max(abs(a), abs(b))
        idle = path.endswith(".linear") and wanted["helicopter"]["tire_model"] != "linear"
        if path not in WORDS and not close and not idle:
            lost[path] = a
    return lost


def _names(case: Case, target: Path) -> dict[str, Any]:
    """Names of what stands in the files in full."""
    names: dict[str, Any] = {}
    given = case.helicopter
    if isinstance(given, str):
        is_file = given.endswith((".yaml", ".yml", ".json"))
        names["helicopter"] = os.path.relpath(given, target) if is_file else given
    elif case.changes or given != document_of(case.vehicle):
        names["helicopter"] = given
    if case.changes:
        names["changes"] = case.changes
    for key, section in (("deck", case.deck), ("claw", case.claw)):
        if section.type == "file" and Path(section.path).resolve() != (target / FILES[key].name).resolve():
            names[f"{key}.path"] = os.path.relpath(section.path, target)
    return names


def _write(target: Path, texts: Mapping[Path, str]) -> None:
    """Write all files, or none."""
    new = [path for path in (target, *target.parents) if not path.exists()]
    try:
        target.mkdir(parents=True, exist_ok=True)
        with whole_files(texts) as staged:
            for path, text in texts.items():
                staged[path].write_text(text, encoding="utf-8", newline="\n")
    except BaseException as error:
        for path in new:
            if path.is_dir() and not any(path.iterdir()):
                path.rmdir()
        if isinstance(error, OSError):
            raise ConfigurationError(f"{target}: cannot be written ({error.strerror or error}).") from None
        raise
    stale = target / SIDECAR
    if stale not in texts and stale.exists():
        stale.unlink()
