"""What a line or a column of the thesis' files is: the types of the tables that everything here is made from.

Léveillé (2013), appendix A, lists the lines of each input file and the columns of each table. `heli_layout`,
`run_layout` and `output_layout` hold these lists once; reader, writer, messages and the documentation page read them
there. A column knows where its number stands in a case's document (`path`), so most of the conversion is this table
too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

STATIONS: Final = ("auxiliary", "right", "left")
GREATEST: Final = 1.0e15  # magnitude of any number in the files: beyond it products leave the range of the arithmetic


@dataclass(frozen=True)
class Column:
    """One number of a line, or one column of a table.

    Attributes:
        name: What tells it apart from its neighbours, such as ``x``, ``e0`` or ``right``.
        unit: Unit as in the file; empty for a pure number.
        path: Dotted path of the value in a case's document; ``*`` stands for all three stations; empty where a case
            has no such value.
        choices: Meanings of an integer that chooses; empty for a number.
        values: What stands in the case's document for each choice; the meanings themselves unless given.
        whole: Whether the number is an integer, which it always is where there are choices.
        least: Smallest value allowed; None for no limit other than the description's own.
        meaning: Meaning of a column of a table; a line says it for all its columns.
    """

    name: str
    unit: str = ""
    path: str = ""
    choices: Mapping[int, str] = field(default_factory=dict)
    values: Mapping[int, Any] = field(default_factory=dict)
    whole: bool = False
    least: float | None = None
    meaning: str = ""

    @property
    def integer(self) -> bool:
        """Whether the number is an integer."""
        return self.whole or bool(self.choices)

    @property
    def allowed(self) -> str:
        """What may stand here, as the end of ``expected ...``."""
        if self.choices:
            listed = ", ".join(f"{number} = {word}" for number, word in self.choices.items())
            return f"one of {listed}"
        kind = "an integer" if self.whole else "a number"
        unit = f" [{self.unit}]" if self.unit else ""
        least = f", at least {self.least:g}" if self.least is not None else ""
        return f"{kind}{unit}{least}"

    def value(self, number: float) -> Any:
        """What stands in the case's document for a number of the file."""
        if not self.choices:
            return int(number) if self.whole else number
        return (self.values or self.choices)[int(number)]

    def number(self, value: Any) -> float:
        """The number of the file for a value of the case's document.

        Raises:
            KeyError: The choice has no number.
        """
        if not self.choices:
            return float(value)
        for number, known in (self.values or self.choices).items():
            if known == value:
                return float(number)
        raise KeyError(value)


@dataclass(frozen=True)
class Line:
    """One line of an input file.

    Attributes:
        number: Its number in appendix A, from 1.
        meaning: What it holds.
        columns: Its numbers, in order.
        when: When it is used, if not always; its numbers are kept, but nothing is made of them, when it is not.
    """

    number: int
    meaning: str
    columns: tuple[Column, ...]
    when: str = ""


@dataclass(frozen=True)
class Table:
    """A file that is one table: a row an instant.

    Attributes:
        columns: Its columns.
        fewest_rows: Least number of rows.
        named: Whether a line of column names may stand before the first row.
    """

    columns: tuple[Column, ...]
    fewest_rows: int
    named: bool = False


@dataclass(frozen=True)
class InputFile:
    """One input file.

    Attributes:
        name: The name that is written.
        names: Names under which it is read; capitals do not matter.
        content: Its lines, or the table that it is.
        meaning: What it holds.
    """

    name: str
    names: tuple[str, ...]
    content: tuple[Line, ...] | Table
    meaning: str


def vector(path: str, unit: str) -> tuple[Column, ...]:
    """Three columns x, y, z."""
    return tuple(Column(name, unit, _entry(path, k)) for k, name in enumerate("xyz"))


def euler_parameters(path: str) -> tuple[Column, ...]:
    """Four columns e0 to e3."""
    return tuple(Column(f"e{k}", "", _entry(path, k)) for k in range(4))


def per_station(path: str, unit: str = "", **rest: Any) -> tuple[Column, ...]:
    """A column for each station; ``{}`` in the path becomes its name, or its number where nothing is to be named."""
    return tuple(
        Column(name, unit, path.format(name) if "{}" in path else _entry(path, k), **rest)
        for k, name in enumerate(STATIONS)
    )


def _entry(path: str, k: int) -> str:
    return f"{path}.{k}" if path else ""
