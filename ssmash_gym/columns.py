"""Text files of numbers in columns: rows of words, and numbers as C, Python or Fortran write them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

COMMENTS: Final = ("#", "%", "!")


def read_text(path: Path) -> str:
    """The text of a file; spreadsheets put a byte-order mark first, and old files hold any bytes in their comments.

    Raises:
        OSError: It cannot be read.
    """
    return path.read_text(encoding="utf-8-sig", errors="replace")


def rows_of(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and words of each row: separated by blanks, tabs, commas or semicolons; comments are passed over."""
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if words and not words[0].startswith(COMMENTS):
            yield number, words


def number_in(word: str) -> float | None:
    """A number as C, Python or Fortran (1.0D+00) writes it; None for another word."""
    try:
        return float(word.replace("D", "E").replace("d", "e"))
    except ValueError:
        return None
