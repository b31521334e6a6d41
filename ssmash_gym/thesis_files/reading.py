"""Numbers out of the text of the thesis' files, and every mistake told with file, line, column and what was expected.

Numbers are separated by blanks, tabs, commas or semicolons. They may be written as C, Python or Fortran write them:
``1.5``, ``1.5e3``, ``1.5D+03``, ``1.5+103``, and ``3*0.0`` for three zeros. Behind the last number of a line a comment
may stand: whatever begins with ``!``, ``#`` or ``%``, or words. Empty lines and lines that begin with one of these
three signs are passed over and do not count. SHIPMO may have one line of column names before its first row.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.thesis_files.layout import GREATEST, Column, InputFile, Line, Table

COMMENTS: Final = ("!", "#", "%")
LONGEST_FILE: Final = 200_000_000  # characters; half a day of deck motion at 20 Hz is below it
MOST_ALIKE: Final = 1000  # numbers that a repeat count may stand for
Row = tuple[float, ...]
Rows = tuple[Row, ...]

_SEPARATORS: Final = str.maketrans(",;\t\f\v", "     ")
_NUMBER: Final = re.compile(r"([+-]?)(\d+\.?\d*|\.\d+)(?:[eEdDqQ]([+-]?\d+)|([+-]\d+))?", re.ASCII)
_NOT_FINITE: Final = re.compile(r"[+-]?(?:nan|inf|infinity)(?:\(\w*\))?", re.ASCII | re.IGNORECASE)
_REPEATED: Final = re.compile(r"(\d{1,9})\*(.+)", re.ASCII)
_BEGINS_AS_NUMBER: Final = re.compile(r"[+-]?\.?\d", re.ASCII)


@dataclass(frozen=True)
class Place:
    """A line of a file: where a mistake is.

    Attributes:
        file: The file.
        line: Number of the line in the file, from 1.
        meant: Number of the line in appendix A; None in a table.
    """

    file: Path
    line: int
    meant: int | None = None

    def refused(self, what: str, column: int | None = None) -> ConfigurationError:
        """The error for a mistake here."""
        where = f"{self.file}, line {self.line}"
        if self.meant is not None and self.meant != self.line:
            where += f" (line {self.meant} of appendix A)"
        if column is not None:
            where += f", column {column}"
        return ConfigurationError(f"{where}: {what}.")


def find(folder: Path, file: InputFile) -> Path | None:
    """The file of a folder that goes by one of the names, whatever its capitals; None if there is none.

    Raises:
        ConfigurationError: There are two, or the folder cannot be read.
    """
    try:
        found = [path for path in sorted(folder.iterdir()) if path.name.lower() in file.names]
    except OSError as error:
        raise ConfigurationError(f"{folder}: cannot be read ({error.strerror or error}).") from None
    if len(found) > 1:
        names = " and ".join(path.name for path in found)
        raise ConfigurationError(f"{folder}: {names} are both there, expected one {file.name} only.")
    return found[0] if found else None


def read_lines(path: Path, lines: Sequence[Line]) -> tuple[Rows, tuple[int, ...]]:
    """Read a file of which each line is known.

    Args:
        path: The file.
        lines: What they hold.

    Returns:
        The numbers of each line, and its number in the file.

    Raises:
        ConfigurationError: The file cannot be read, or a line is not what it should be.
    """
    rows: list[Row] = []
    numbers: list[int] = []
    for number, text in _written_lines(path):
        if len(rows) == len(lines):
            raise Place(path, number).refused(
                f"expected the end of the file after its {len(lines)} lines, found {_shown(text)}"
            )
        line = lines[len(rows)]
        rows.append(_line_numbers(Place(path, number, line.number), text, line))
        numbers.append(number)
    if len(rows) < len(lines):
        missing = lines[len(rows)]
        raise ConfigurationError(
            f"{path}: the file ends after {len(rows)} lines, expected {len(lines)}; line {missing.number} holds: "
            f"{missing.meaning}."
        )
    return tuple(rows), tuple(numbers)


def read_table(path: Path, table: Table) -> Rows:
    """Read a file that is one table, (rows, columns), with times that rise.

    Raises:
        ConfigurationError: The file cannot be read, or a row is not what it should be.
    """
    rows: list[Row] = []
    names_passed = not table.named
    for number, text in _written_lines(path):
        place = Place(path, number)
        if not rows and not names_passed and not any(_BEGINS_AS_NUMBER.match(word) for word in _words(text)):
            names_passed = True
            continue
        rows.append(_line_numbers(place, text, Line(0, "", table.columns)))
        if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
            raise place.refused(
                f"expected a time after {rows[-2][0]:g} s, that of the row before, found {rows[-1][0]:g} s", 1
            )
    if len(rows) < table.fewest_rows:
        raise ConfigurationError(
            f"{path}: {len(rows)} rows of numbers found, expected {table.fewest_rows} or more of "
            f"{len(table.columns)} columns."
        )
    return tuple(rows)


def read_number(word: str) -> float | None:
    """A number as C, Python or Fortran write it; None if it is none. It may be infinite or not a number."""
    if _NOT_FINITE.fullmatch(word):
        return math.nan
    match = _NUMBER.fullmatch(word)
    if match is None:
        return None
    sign, digits, exponent, bare = match.groups()
    return float(f"{sign}{digits}e{exponent or bare or 0}")


def _written_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines that are neither empty nor a comment, with their numbers in the file."""
    try:
        if path.stat().st_size > LONGEST_FILE:
            raise ConfigurationError(f"{path}: the file is longer than {LONGEST_FILE / 1e6:g} MB.")
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror or error}).") from None
    for number, line in enumerate(text.split("\n"), start=1):
        stripped = line.translate(_SEPARATORS).strip()
        if stripped and not stripped.startswith(COMMENTS):
            yield number, stripped


def _words(text: str) -> list[str]:
    """Words of a line up to the comment that a sign begins."""
    words = []
    for word in text.split():
        if word.startswith(COMMENTS):
            break
        words.append(word)
    return words


def _line_numbers(place: Place, text: str, line: Line) -> Row:
    """The numbers of a line.

    Raises:
        ConfigurationError: Too few, too many, or one that is not what it should be.
    """
    row: list[float] = []
    wanted = len(line.columns)
    for word in _words(text):
        if len(row) == wanted:
            if _BEGINS_AS_NUMBER.match(word) or read_number(word) is not None:
                raise place.refused(f"expected {_count(wanted)} ({_holds(line)}), found {_shown(word)} after them")
            break  # words: a comment
        count, written = _repeat(word)
        number = read_number(written)
        if number is None or count < 1 or count > MOST_ALIKE:
            raise place.refused(_expected(line, len(row), word), len(row) + 1)
        if len(row) + count > wanted:
            raise place.refused(f"expected {_count(wanted)} ({_holds(line)}), found {_shown(word)} after them")
        for _ in range(count):
            _check(place, line, len(row), number, word)
            row.append(number)
    if len(row) < wanted:
        raise place.refused(f"expected {_count(wanted)} ({_holds(line)}), found {len(row)}")
    return tuple(row)


def _repeat(word: str) -> tuple[int, str]:
    """``3*0.0`` as 3 and ``0.0``."""
    match = _REPEATED.fullmatch(word)
    return (int(match[1]), match[2]) if match else (1, word)


def _check(place: Place, line: Line, k: int, number: float, word: str) -> None:
    """Refuse a number that cannot be what the column holds."""
    if not sound(line.columns[k], number):
        raise place.refused(_expected(line, k, word), k + 1)


def sound(column: Column, number: float) -> bool:
    """Whether a number can be what a column holds."""
    if not (math.isfinite(number) and abs(number) <= GREATEST) or (column.integer and number != int(number)):
        return False
    if column.choices and int(number) not in column.choices:
        return False
    return column.least is None or number >= column.least


def check_row(where: str, line: Line, row: Sequence[object]) -> Row:
    """The numbers of a line that stands elsewhere than in its file.

    Raises:
        ConfigurationError: They are not what the line holds; told with ``where``.
    """
    if len(row) != len(line.columns):
        raise ConfigurationError(f"{where}: expected {_count(len(line.columns))} ({_holds(line)}), found {len(row)}.")
    for k, entry in enumerate(row):
        number = float(entry) if isinstance(entry, int | float) and not isinstance(entry, bool) else math.nan
        if not sound(line.columns[k], number):
            raise ConfigurationError(f"{where}, column {k + 1}: {_expected(line, k, str(entry))}.")
    return tuple(float(str(entry)) for entry in row)


def _expected(line: Line, k: int, word: str) -> str:
    column = line.columns[k]
    finite = "" if column.choices else f", finite and within {GREATEST:g} of zero"
    return f"expected {_name(line, column)} as {column.allowed}{finite}, found {_shown(word)}"


def _name(line: Line, column: Column) -> str:
    meaning = column.meaning or line.meaning
    return f"{column.name} ({meaning})" if column.name != meaning else meaning


def _holds(line: Line) -> str:
    """What a line holds, in few words."""
    names = [column.name for column in line.columns]
    listed = " ".join(names) if len(names) <= 6 else f"{names[0]} to {names[-1]}"
    return f"{line.meaning}: {listed}" if line.meaning else listed


def _count(wanted: int) -> str:
    return "one number" if wanted == 1 else f"{wanted} numbers"


def _shown(text: str) -> str:
    """Some text of a file as it goes into a message."""
    short = text if len(text) <= 32 else text[:29] + "..."
    return repr(short)
