"""A folder of the thesis' files becomes a case."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from ssmash_gym.cases import Case, case_document, case_from
from ssmash_gym.document import Mark, join
from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.thesis_files import document as documents
from ssmash_gym.thesis_files import folder as folders
from ssmash_gym.thesis_files import sidecar as sidecars
from ssmash_gym.thesis_files.conditions import last_row, rounded
from ssmash_gym.thesis_files.defaults import CASE
from ssmash_gym.thesis_files.folder import SIDECAR, Folder
from ssmash_gym.thesis_files.helicopter import ORIENTATIONS, PRISMATIC, tilt
from ssmash_gym.thesis_files.kept import KEPT, RECORDS, checked, kept_lines
from ssmash_gym.thesis_files.layout import Table
from ssmash_gym.thesis_files.paths import MISSING, get, pattern
from ssmash_gym.thesis_files.reading import Rows, read_table
from ssmash_gym.thesis_files.run_layout import FILES
from ssmash_gym.vehicle import Helicopter, document_of, helicopter_from, load_helicopter, with_changes

TILTED: Final = 1.0e-3  # rad between two axes o_z that are told to differ
MOST_ROWS: Final = 250_000  # of output: half a gigabyte


@dataclass(frozen=True)
class Reading:
    """What a folder of the thesis' files is.

    Attributes:
        folder: The files.
        case: The case.
        document: Its document, with the numbers that only the files have under ``thesis_files``.
        defaults: What had to be taken because no file says it, in words.
        remarks: What else is to be known, in words.
    """

    folder: Folder
    case: Case
    document: dict[str, Any]
    defaults: tuple[str, ...]
    remarks: tuple[str, ...]


def read_case(folder: str | Path) -> dict[str, Any]:
    """The document of the case in a folder of the thesis' files, records by their absolute paths.

    Raises:
        ConfigurationError: A file is missing or refused; one sentence with file, line, column and what was expected.
    """
    return read_folder(folder).document


def read_folder(folder: str | Path) -> Reading:
    """Read a folder of the thesis' files.

    Raises:
        ConfigurationError: A file is missing or refused; one sentence with file, line, column and what was expected.
    """
    source = folders.read(Path(folder))
    name = source.path.resolve().name or "case"
    records = {key: str(source.files[key].resolve()) for key in RECORDS if key in source.numbers}
    sidecar = sidecars.load(source.path)
    beside = str(source.path / SIDECAR)
    with told_as(source, ""):
        filed, taken = documents.from_numbers(source.numbers, name, records, set())
    plain, marks, remarks, given = sidecars.apply(sidecar, filed, source.numbers, beside)
    open_ = {path: default for path, default in taken.items() if path not in given}
    note = "no thesis file holds it: default"
    marks |= {path: Mark(path=path, origin="assumed", note=note) for path in open_}
    helicopter, case = _case(source, plain, marks)
    document = case_document(case)
    document["helicopter"] = document_of(helicopter)
    remarks += _named(document, helicopter, sidecar.written_as, source)
    kept = kept_lines(source, filed)
    if kept:
        document[KEPT] = kept
    remarks += _adjusted(source)
    remarks += [f"{path.name} is not read: prescribed.inp does not ask for it" for path in source.unread]
    return Reading(source, case, document, tuple(_told(open_, given, plain)), tuple(remarks))


def _adjusted(source: Folder) -> Iterator[str]:
    """Numbers that are not taken quite as they are, in words."""
    places = [("heli", line) for line in ORIENTATIONS] + [("initials", line) for line in (2, 4, 5, 6)]
    for key, line in places:
        if rounded(row := source.numbers[key][line - 1]):
            norm = math.hypot(*row)
            yield f"{FILES[key].name} line {line}: Euler parameters of norm {norm:.6f} are normalised"
    heli, initials = source.numbers["heli"], source.numbers["initials"]
    for i, line in enumerate(ORIENTATIONS):
        droop, start = heli[line - 1], initials[3 + i]
        if heli[31][i] == PRISMATIC and any(droop) and tilt(droop, start) > TILTED:
            yield (
                f"initials.inp line {4 + i} counts, not heli.inp line {line}: they differ by more than a turn about o_z"
            )
    solution = source.numbers["solution"]
    if (last := last_row(solution)) != solution[0][1]:
        yield f"solution.inp line 1: the last row is at {last:g} s, the last whole step before the end"


def case_of(document: Mapping[str, Any], source: str, folder: Path | None = None) -> tuple[Case, dict[str, Any]]:
    """The case of a document that may hold numbers which only the files have, and these numbers.

    Raises:
        ConfigurationError: It is refused.
    """
    kept = document.get(KEPT, {})
    case = case_from({key: value for key, value in document.items() if key != KEPT}, source, folder)
    return case, checked(kept, source)


@contextmanager
def told_as(source: Folder, prefix: str, name: str = "") -> Iterator[None]:
    """Tell refusals with file, line and column; numbers beyond all bounds are refusals too."""
    try:
        yield
    except ConfigurationError as error:
        raise folders.explained(error, name or str(source.path), source, prefix) from None
    except (ArithmeticError, TypeError) as error:
        raise ConfigurationError(
            f"{source.files['heli']}: its numbers are refused: they leave the range of the arithmetic ({error})."
        ) from None


def _case(source: Folder, plain: Mapping[str, Any], marks: Mapping[str, Mark]) -> tuple[Helicopter, Case]:
    """Helicopter and case of the plain document.

    Raises:
        ConfigurationError: They are refused.
    """
    marked = join(plain, marks)
    heli, name = str(source.files["heli"]), str(source.path)
    with told_as(source, "helicopter.", heli):
        helicopter = helicopter_from(marked["helicopter"], heli)
    with told_as(source, "", name), warnings.catch_warnings():
        warnings.simplefilter("ignore", ConfigurationWarning)  # told when the helicopter was made
        case = case_from({**marked, "helicopter": document_of(helicopter)}, name)
        if case.solution.rows > MOST_ROWS:
            raise ConfigurationError(
                f"{name}: solution.output_step_s = {case.solution.output_step_s:g} is refused: it asks for "
                f"{case.solution.rows} rows, at most {MOST_ROWS} are allowed."
            )
    return helicopter, case


def _named(document: dict[str, Any], helicopter: Helicopter, written: Mapping[str, Any], source: Folder) -> list[str]:
    """Put back the names of what stands in the files in full, where they mean the same; remarks where not."""
    remarks = []
    if "helicopter" in written:
        try:
            given, changes = written["helicopter"], written.get("changes", {})
            same = _base(given, source.path, changes) == helicopter
        except (ConfigurationError, TypeError, AttributeError):
            same = False
        if same:
            document["helicopter"] = _from(given, source.path) if isinstance(given, str) else given
            document["changes"] = changes
        else:
            remarks.append(f"the helicopter is that of the files: they differ from what {SIDECAR} calls it by")
    for key in RECORDS:
        path = written.get(f"{key}.path")
        if path is None or key not in source.numbers or document[key]["type"] != "file":
            continue
        there = os.path.normpath(source.path.resolve() / str(path))
        if _same_record(Path(there), key, source.numbers[key]):
            document[key]["path"] = there
    return remarks


def _base(given: Any, folder: Path, changes: Mapping[str, Any]) -> Helicopter:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConfigurationWarning)
        found = load_helicopter(_from(given, folder)) if isinstance(given, str) else helicopter_from(given)
        return with_changes(found, changes) if changes else found


def _from(name: str, folder: Path) -> str:
    """A helicopter's file by its absolute path; a name of the catalogue as it is."""
    is_file = name.endswith((".yaml", ".yml", ".json"))
    return os.path.normpath(folder.resolve() / name) if is_file else name


def _same_record(path: Path, key: str, rows: Rows) -> bool:
    content = FILES[key].content
    assert isinstance(content, Table)
    try:
        return path.is_file() and read_table(path, content) == rows
    except ConfigurationError:
        return False


def _told(taken: Mapping[str, Any], given: set[str], plain: Mapping[str, Any]) -> Iterator[str]:
    """Defaults in words: of the helicopter, and of the laws between which a case chooses."""
    for default in {pattern(path): default for path, default in taken.items()}.values():
        yield f"helicopter.{default.path} = {default.shown} ({default.why})"
    for default in CASE:
        if default.path not in given and get(plain, default.path) is not MISSING:
            if default.path.startswith("deck.") and plain["deck"]["type"] != "file":
                continue
            yield f"{default.path} = {default.shown} ({default.why})"
