"""The tables of the documentation page `docs/guide/thesis_files.md`, made from the tables that the code reads by.

``python -m ssmash_gym.thesis_files.page docs/guide/thesis_files.md`` writes them into the page.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

from ssmash_gym.thesis_files.defaults import CASE, HELICOPTER
from ssmash_gym.thesis_files.heli_layout import HELI, TIRE_TYPES, oleo_columns, tire_columns
from ssmash_gym.thesis_files.layout import Column, Line, Table
from ssmash_gym.thesis_files.output_layout import AUX, RUN, STATE
from ssmash_gym.thesis_files.run_layout import FILES

BEGIN: Final = "<!-- begin of the tables made by ssmash_gym.thesis_files.page -->"
END: Final = "<!-- end of the tables -->"
MOST_NAMES: Final = 6


def tables() -> str:
    """All tables, from the first marker to the last."""
    parts = [BEGIN, ""]
    for file in FILES.values():
        parts += [f"### {file.name}", "", f"{file.meaning[0].upper()}{file.meaning[1:]}.", ""]
        parts += [*_columns(file.content.columns)] if isinstance(file.content, Table) else [*_lines(file.content)]
        if file.content is HELI:
            parts += ["#### Columns of a tire (lines 56 to 61)", "", *_columns(tire_columns("", TIRE_TYPES))]
            parts += ["#### Columns of a gas oleo (lines 66 to 68)", "", *_columns(oleo_columns(""))]
    parts += ["### run.out", "", *_lines(RUN), "### state.out", "", *_columns(STATE), "### aux.out", "", *_columns(AUX)]
    parts += ["### Defaults", "", *_defaults()]
    return "\n".join([*parts, END])


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield f"| {' | '.join(row)} |"
    yield ""


def _lines(lines: Sequence[Line]) -> Iterator[str]:
    return _table(
        ("line", "meaning", "numbers", "unit", "used"),
        (
            (str(line.number), line.meaning, _names(line.columns), _unit(line.columns), line.when or "always")
            for line in lines
        ),
    )


def _columns(columns: Sequence[Column]) -> Iterator[str]:
    return _table(
        ("column", "name", "meaning", "unit"),
        (
            (str(k), f"`{column.name}`", column.meaning + _choices(column), column.unit or "-")
            for k, column in enumerate(columns, start=1)
        ),
    )


def _names(columns: Sequence[Column]) -> str:
    names = [f"`{column.name}`" for column in columns]
    listed = ", ".join(names) if len(names) <= MOST_NAMES else f"{len(names)} columns, see below"
    return listed + (_choices(columns[0]) if len(names) <= MOST_NAMES else "")


def _choices(column: Column) -> str:
    return f": {', '.join(f'{number} {word}' for number, word in column.choices.items())}" if column.choices else ""


def _unit(columns: Sequence[Column]) -> str:
    units = list(dict.fromkeys(column.unit for column in columns))
    return ", ".join(unit or "-" for unit in units) if len(units) <= 2 else "-"


def _defaults() -> Iterator[str]:
    values = [(f"helicopter.{default.path}", default) for default in HELICOPTER]
    values += [(default.path, default) for default in CASE]
    return _table(("key", "taken", "why"), ((f"`{path}`", default.shown, default.why) for path, default in values))


def write(page: Path) -> None:
    """Write the tables between the markers of a page."""
    text = page.read_text(encoding="utf-8")
    before, after = text.index(BEGIN), text.index(END) + len(END)
    page.write_text(text[:before] + tables() + text[after:], encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
