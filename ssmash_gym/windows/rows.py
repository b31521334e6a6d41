"""The dataset of a window on disk: one Parquet file a chunk, one row an episode, and what was asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.document import read_record
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.study_rows import ROWS, read_frames
from ssmash_gym.files import whole_file, write_text
from ssmash_gym.windows.chunks import KEYS

WINDOW: Final = "window.json"
LOCK: Final = ".lock"


def write_rows(out: Path, name: str, rows: pl.DataFrame) -> None:
    """Write one chunk, whole or not at all."""
    with whole_file(out / ROWS / f"{name}.parquet") as temporary:
        rows.write_parquet(temporary)


def read_rows(out: Path, columns: Sequence[str] | None = None) -> pl.DataFrame:
    """All rows of a window's folder in the order of stage, policy, cell and sea; none where nothing has been run.

    Args:
        out: The folder.
        columns: Besides those of `KEYS`; all by default.

    Raises:
        ConfigurationError: A file holds no such rows, or an episode stands there twice.
    """
    frames = read_frames(out / ROWS, KEYS, "a window", columns)
    if not frames:
        return pl.DataFrame(schema={"stage": pl.String, "policy": pl.String, "cell": pl.Int64, "number": pl.Int64})
    rows = pl.concat(frames, how="diagonal_relaxed").sort(*KEYS)
    if rows.select(KEYS).is_duplicated().any():
        rows = rows.unique(maintain_order=True)  # the same episode run twice has the same numbers
    if rows.select(KEYS).is_duplicated().any():
        raise ConfigurationError(
            f"{out / ROWS}: some episodes stand there twice, with other numbers: remove it and run again."
        )
    return rows


@contextmanager
def alone_in(out: Path) -> Iterator[None]:
    """Hold a window's folder: no other process may run it at the same time. A process that dies lets go of it.

    Raises:
        ConfigurationError: Another one does.
    """
    from filelock import FileLock, Timeout

    out.mkdir(parents=True, exist_ok=True)
    lock = FileLock(out / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise ConfigurationError(f"{out}: another process is running a window in this folder.") from None
    try:
        yield
    finally:
        lock.release()


def write_document(out: Path, document: dict[str, Any]) -> None:
    """Write ``window.json``, whole or not at all."""
    write_text(out / WINDOW, json.dumps(document, indent=1) + "\n")


def read_document(out: Path) -> dict[str, Any]:
    """The ``window.json`` of a folder; empty where there is none.

    Raises:
        ConfigurationError: It cannot be read.
    """
    return read_record(out / WINDOW)
