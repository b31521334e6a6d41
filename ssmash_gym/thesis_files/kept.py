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
from ssmash_gym.thesis_files.reading import Rows
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


def put_back(numbers: dict[str, Rows], kept: Mapping[str, Any], filed: Mapping[str, Any]) -> None:
    """Put kept lines back, each where the files still say the same with it.

    Raises:
        ConfigurationError: A kept line is not one of the file.
    """
    for file, lines in kept.items():
        key = next((key for key in LINED if FILES[key].name == file), None)
        if key is None:
            raise ConfigurationError(f"{KEPT}: there is no file {file}; allowed are {_listed(LINED)}.")
        for name, row in lines.items():
            rows = list(numbers[key])
            k = int(name[5:]) - 1 if isinstance(name, str) and name[:5] == "line_" and name[5:].isdigit() else -1
            if not 0 <= k < len(rows) or not isinstance(row, list) or len(row) != len(rows[k]):
                raise ConfigurationError(f"{KEPT}.{file}.{name}: this is no line of {file}.")
            rows[k] = tuple(float(number) for number in row)
            tried = {**numbers, key: tuple(rows)}
            records = {record: filed[record].get("path", "") for record in RECORDS}
            if documents.from_numbers(tried, filed["name"], records, set())[0] == dict(filed):
                numbers[key] = tuple(rows)


def _listed(keys: tuple[str, ...]) -> str:
    return ", ".join(FILES[key].name for key in keys)
