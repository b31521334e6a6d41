"""Rows of a benchmark on disk: what has been simulated once is only read again."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import polars as pl

from ssmash_gym.evaluation.study_rows import ROWS, read_frames
from ssmash_gym.files import whole_file

KEYS: Final = ("driver", "kind", "delay_ms", "member", "seed")  # of the benchmark's table, one row an episode


def kept(out: Path, key: str) -> pl.DataFrame:
    """The rows under a key; none where nothing has been run.

    Args:
        out: The benchmark's folder.
        key: Hash of all that the rows depend on.

    Raises:
        ConfigurationError: A file cannot be read.
    """
    frames = read_frames(out / ROWS, ("seed",), "a benchmark's rows", names=f"*--{key}--*")
    return (
        pl.concat(frames, how="diagonal_relaxed") if frames else pl.DataFrame({"seed": []}, schema={"seed": pl.Int64})
    )


def keep(out: Path, name: str, key: str, rows: pl.DataFrame, part: int) -> None:
    """Write rows under a key, whole or not at all.

    Args:
        out: The benchmark's folder.
        name: Beginning of the file's name, for a reader.
        key: As of `kept`.
        rows: What to keep.
        part: Number of the file among those of the key.
    """
    with whole_file(out / ROWS / f"{name}--{key}--{part:04d}.parquet") as temporary:
        rows.write_parquet(temporary)
