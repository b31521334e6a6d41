"""A folder of the thesis' files: their numbers, where each stands, and their text."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.thesis_files.layout import STATIONS, Column, InputFile, Line, Table
from ssmash_gym.thesis_files.paths import expand
from ssmash_gym.thesis_files.reading import Place, Rows, find, read_lines, read_table
from ssmash_gym.thesis_files.run_layout import FILES, FROM_FILE

SIDECAR: Final = "beyond_thesis.yaml"
LINED: Final = ("heli", "initials", "solution", "prescribed")
FIRST_TIME_TOLERANCE: Final = 0.05  # share of the record's step by which its first time may be off 0
_ELSEWHERE: Final = {  # keys of a case whose number has no column with that path
    "deck.dof": ("prescribed", 4, None),
    "deck.amplitude_deg": ("prescribed", 5, 1),
    "deck.amplitude_m": ("prescribed", 5, 1),
    "deck.period_s": ("prescribed", 5, 2),
    "deck.roll_deg": ("prescribed", 6, 1),
    "deck.pitch_deg": ("prescribed", 6, 2),
    "deck.yaw_deg": ("prescribed", 6, 3),
    "claw.x_m": ("prescribed", 2, 1),
    "claw.y_m": ("prescribed", 2, 2),
    "claw.z_m": ("prescribed", 2, 3),
}


@dataclass(frozen=True)
class Folder:
    """What stands in a folder.

    Attributes:
        path: The folder.
        files: The files that are read, by their key in `FILES`.
        numbers: Their numbers, by the same key; records only where they are used.
        lines: Number in the file of each line of appendix A.
        unread: Records that are there and are not used.
    """

    path: Path
    files: Mapping[str, Path]
    numbers: Mapping[str, Rows]
    lines: Mapping[str, tuple[int, ...]]
    unread: tuple[Path, ...]


def read(folder: Path) -> Folder:
    """Read the files of a folder.

    Raises:
        ConfigurationError: A file is missing, or something in one is not what it should be.
    """
    if not folder.is_dir():
        raise ConfigurationError(f"{folder}: there is no such folder.")
    files: dict[str, Path] = {}
    numbers: dict[str, Rows] = {}
    lines: dict[str, tuple[int, ...]] = {}
    for key in LINED:
        files[key] = _needed(folder, FILES[key], "")
    for key in LINED:
        content = FILES[key].content
        assert not isinstance(content, Table)
        numbers[key], lines[key] = read_lines(files[key], content)
    unread = []
    for key, line, what in (("claw", 1, "the claw"), ("deck", 3, "the ship")):
        found = find(folder, FILES[key])
        if numbers["prescribed"][line - 1][0] != FROM_FILE:
            unread += [found] if found is not None else []
            continue
        why = f", though line {line} of {files['prescribed'].name} says that {what} moves as in that file"
        files[key] = _needed(folder, FILES[key], why)
        numbers[key] = _record(key, files[key])
    return Folder(folder, files, numbers, lines, tuple(unread))


def _needed(folder: Path, file: InputFile, why: str) -> Path:
    found = find(folder, file)
    if found is None:
        raise ConfigurationError(f"{folder}: there is no {file.name} ({file.meaning}){why}.")
    return found


def _record(key: str, path: Path) -> Rows:
    """Rows of a record; what the run reads it with has no objection either."""
    from ssmash_gym.cases.claw import read_claw_file
    from ssmash_gym.ship.shipmo import read_shipmo

    content = FILES[key].content
    assert isinstance(content, Table)
    rows = read_table(path, content)
    if key == "claw":
        read_claw_file(path)
        return rows
    step = read_shipmo(path).step_s
    if abs(rows[0][0]) > FIRST_TIME_TOLERANCE * step:
        raise Place(path, 1).refused(f"expected a first row at 0 s, where the clock starts, found {rows[0][0]:g} s", 1)
    return rows


def digest(rows: Rows) -> str:
    """Short name of a record's numbers: the same for the same numbers, however they are written."""
    text = "\n".join(" ".join(map(repr, row)) for row in rows)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


# --- where a value of a case stands -------------------------------------------------------------------------------


def explained(error: ConfigurationError, source: str, folder: Folder, prefix: str = "") -> ConfigurationError:
    """The same error with file, line and column in place of its source, if its key stands in a file.

    Args:
        error: A refusal whose message begins with `source` and a key.
        source: What the message calls the document.
        folder: Where the numbers stand.
        prefix: Path of the document in a case: ``helicopter.``, or empty.
    """
    text = str(error)
    match = re.match(re.escape(source) + r":\s+(?:the key )?(?P<key>[\w.]+)", text)
    if match is None:
        return error
    key = match["key"]
    where = place_of(prefix + key, folder)
    return ConfigurationError(f"{where}{text[len(source) :]}") if where else error


def place_of(path: str, folder: Folder) -> str:
    """File, line and column of a value of a case, as text; empty if no file holds it."""
    if path in ("deck.path", "claw.path"):
        return str(folder.files.get(path[:4], ""))
    if path in _ELSEWHERE:
        key, number, column = _ELSEWHERE[path]
        return _text(folder, key, [(number, column)])
    section, _, rest = path.partition(".")
    file, wanted = {"helicopter": ("heli", rest), "start": ("initials", path), "solution": ("solution", path)}.get(
        section, ("", "")
    )
    if not file:
        return ""
    content = FILES[file].content
    assert not isinstance(content, Table)
    found = [
        (line.number, k if _is(column, wanted) else None)
        for line in content
        for k, column in enumerate(line.columns, start=1)
        if any(_related(full, wanted) for full in _full(column))
    ]
    return _text(folder, file, found)


def _full(column: Column) -> list[str]:
    return expand({"stations": {name: {} for name in STATIONS}}, column.path) if column.path else []


def _is(column: Column, path: str) -> bool:
    return path in _full(column)


def _related(one: str, other: str) -> bool:
    return (one + ".").startswith(other + ".") or (other + ".").startswith(one + ".")


def _text(folder: Folder, key: str, found: Sequence[tuple[int, int | None]]) -> str:
    path = str(folder.files[key])
    if not found or len({number for number, _ in found}) > 4:
        return path
    numbers = sorted({folder.lines[key][number - 1] for number, _ in found})
    lines = f"line {numbers[0]}" if len(numbers) == 1 else f"lines {numbers[0]}-{numbers[-1]}"
    column = f", column {found[0][1]}" if len(found) == 1 and found[0][1] is not None else ""
    return f"{path}, {lines}{column}"


# --- writing -------------------------------------------------------------------------------------------------------


def texts(numbers: Mapping[str, Rows]) -> dict[str, str]:
    """The text of each file, by its key."""
    made = {}
    for key, rows in numbers.items():
        content = FILES[key].content
        if isinstance(content, Table):
            made[key] = "".join(" ".join(map(repr, row)) + "\n" for row in rows)
        else:
            made[key] = "".join(_line_text(line, row) for line, row in zip(content, rows, strict=True))
    return made


def _line_text(line: Line, row: Sequence[float]) -> str:
    """A line with its meaning behind its numbers."""
    written = "  ".join(
        str(int(number)) if column.integer else repr(float(number))
        for column, number in zip(line.columns, row, strict=True)
    )
    units = sorted({column.unit for column in line.columns if column.unit})
    unit = f" [{units[0]}]" if len(units) == 1 else ""
    return f"{written}  ! {line.number}: {line.meaning}{unit}\n"
