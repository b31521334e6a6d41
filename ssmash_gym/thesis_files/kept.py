"""Numbers that mean nothing to a case and are kept, so that a folder comes back as it was.

Lines that are not used, lines 3 to 5 of SOLUTION.INP, and such: they stand under ``thesis_files`` in the case's
document, by file and line.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.thesis_files import document as documents
from ssmash_gym.thesis_files.folder import LINED, Folder
from ssmash_gym.thesis_files.layout import Table
from ssmash_gym.thesis_files.reading import Rows, check_row
from ssmash_gym.thesis_files.run_layout import FILES

KEPT: Final = "thesis_files"
RECORDS: Final = ("claw", "deck")


def kept_lines(source: Folder, filed: Mapping[str, Any]) -> dict[str, Any]:
    """Lines that would come back otherwise: they are not used, or their numbers choose nothing here."""
    records = {key: source.numbers[key] for key in ("claw", "deck") if key in source.numbers}
    again = documents.numbers_of(filed, records)
    kept: dict[str, Any] = {}
    for key in LINED:
        for line, (old, new) in enumerate(zip(source.numbers[key], again[key], strict=True), start=1):
            if old != new:
                kept.setdefault(FILES[key].name, {})[f"line_{line}"] = list(old)
    return kept


def checked(kept: Any, source: str) -> dict[str, dict[str, list[float]]]:
    """Kept lines of a document, each with numbers that its file may hold.

    Raises:
        ConfigurationError: One is no line of its file; told with the name of the document.
    """
    if not isinstance(kept, dict) or not all(isinstance(lines, dict) for lines in kept.values()):
        raise ConfigurationError(f"{source}: {KEPT} must hold lines of numbers by file.")
    found: dict[str, dict[str, list[float]]] = {}
    for file, lines in kept.items():
        key = next((key for key in LINED if FILES[key].name == file), None)
        if key is None:
            raise ConfigurationError(f"{source}: {KEPT}: there is no file {file}; allowed are {_listed(LINED)}.")
        lined = FILES[key].content
        assert not isinstance(lined, Table)
        content = {f"line_{line.number}": line for line in lined}
        for name, row in lines.items():
            if name not in content or not isinstance(row, list):
                raise ConfigurationError(f"{source}: {KEPT}.{file}.{name}: this is no line of {file}.")
            numbers = check_row(f"{source}: {KEPT}.{file}.{name}", content[name], row)
            found.setdefault(file, {})[name] = list(numbers)
    return found


def put_back(numbers: dict[str, Rows], kept: Mapping[str, Mapping[str, list[float]]], filed: Mapping[str, Any]) -> None:
    """Put kept lines, see `checked`, back: each where the files still say the same with it."""
    for key in LINED:
        for name, row in kept.get(FILES[key].name, {}).items():
            rows = list(numbers[key])
            rows[int(name.removeprefix("line_")) - 1] = tuple(row)
            tried = {**numbers, key: tuple(rows)}
            records = {record: filed[record].get("path", "") for record in RECORDS}
            if documents.from_numbers(tried, filed["name"], records, set())[0] == dict(filed):
                numbers[key] = tuple(rows)


def _listed(keys: tuple[str, ...]) -> str:
    return ", ".join(FILES[key].name for key in keys)
