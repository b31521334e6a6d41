"""The rows of a study on disk and in tables: one Parquet file a chunk, one number a policy, training seed and sea."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import whole_file

STUDY: Final = "study.json"  # of a study's folder: what was asked for
SUMMARY: Final = "summary.json"  # and its figures
ROWS: Final = "rows"
KEYS: Final = ("policy", "training_seed", "condition", "sea", "configuration", "code")
OF_A_SEA: Final = ("sea_lateral_g", "sea_hs_m", "sea_heading_deg", "sea_speed_kn")

Array = NDArray[np.float64]
Key = tuple[str, int | None, str]  # policy, training seed, condition


def labelled(episodes: pl.DataFrame, key: Key, configuration: str, code: str) -> pl.DataFrame:
    """Rows of `run_episodes` as a study keeps them: with `KEYS` in front, and ``seed`` called ``sea``."""
    policy, training_seed, condition = key
    return episodes.rename({"seed": "sea"}).select(
        pl.lit(policy).alias("policy"),
        pl.lit(training_seed, dtype=pl.Int64).alias("training_seed"),
        pl.lit(condition).alias("condition"),
        pl.col("sea"),
        pl.lit(configuration).alias("configuration"),
        pl.lit(code).alias("code"),
        pl.exclude("sea"),
    )


def write_rows(out: Path, key: Key, rows: pl.DataFrame, first: int) -> None:
    """Write one chunk, whole or not at all.

    Args:
        out: The study's folder.
        key: Whose rows they are.
        rows: As of `labelled`.
        first: Number of the chunk's first sea among the study's, for the file's name.
    """
    policy, training_seed, condition = key
    name = policy if training_seed is None else f"{policy}.seed{training_seed}"
    with whole_file(out / ROWS / f"{name}--{condition}--{first:04d}-{rows.height}.parquet") as temporary:
        rows.write_parquet(temporary)


def read_rows(out: Path) -> pl.DataFrame:
    """All rows of a study's folder; none where nothing has been run.

    Raises:
        ConfigurationError: A file holds no such rows, or a sea stands twice in the rows of a policy and condition.
    """
    frames = read_frames(out / ROWS, KEYS, "a study's rows")
    if not frames:
        return pl.DataFrame(schema={name: pl.String for name in KEYS} | {"training_seed": pl.Int64, "sea": pl.Int64})
    rows = pl.concat(frames, how="diagonal_relaxed")
    if rows.select("policy", "training_seed", "condition", "sea").is_duplicated().any():
        raise ConfigurationError(f"{out / ROWS}: some episodes stand there twice: remove the folder and run it again.")
    return rows


def read_frames(
    folder: Path, keys: Sequence[str], kind: str, columns: Sequence[str] | None = None, names: str = "*"
) -> list[pl.DataFrame]:
    """The tables of a folder's Parquet files, in the order of their names.

    Args:
        folder: Where they lie; there may be none.
        keys: Columns that each must have.
        kind: What they are of, for messages.
        columns: Those to read besides the keys; all by default.
        names: Pattern of the files' names, without ``.parquet``.

    Raises:
        ConfigurationError: A file cannot be read, or lacks a key.
    """
    frames = []
    for path in sorted(folder.glob(f"{names}.parquet")):
        try:
            frame = pl.read_parquet(path, columns=None if columns is None else [*keys, *columns])
        except (pl.exceptions.PolarsError, OSError) as error:
            raise ConfigurationError(f"{path}: this file of rows cannot be read ({error}).") from None
        missing = [name for name in keys if name not in frame.columns]
        if missing:
            raise ConfigurationError(f"{path}: this is no file of {kind}: the column {missing[0]} is missing.")
        frames.append(frame)
    return frames


@dataclass(frozen=True)
class StudyRows:
    """Rows by condition and policy, as tables of numbers.

    Attributes:
        frames: Rows by condition and policy, sorted by training seed and sea.
    """

    frames: dict[tuple[str, str], pl.DataFrame]

    @classmethod
    def of(cls, rows: pl.DataFrame) -> StudyRows:
        """Sort rows out.

        Raises:
            ConfigurationError: Policies did not meet the same seas.
        """
        _check_seas(rows)
        ordered = rows.sort("condition", "policy", "training_seed", "sea", nulls_last=False)
        parts = ordered.partition_by("condition", "policy", as_dict=True) if rows.height else {}
        return cls({(str(key[0]), str(key[1])): frame for key, frame in parts.items()})

    def policies(self, condition: str) -> list[str]:
        """Names of those that have rows of a condition."""
        return [policy for here, policy in self.frames if here == condition]

    def has(self, condition: str, *policies: str | None) -> bool:
        """Whether all of them have rows of a condition, some of them of the same seas."""
        known = all(policy is not None and (condition, policy) in self.frames for policy in policies)
        return known and self.seas(condition, *(str(policy) for policy in policies)).size > 0

    def seeds(self, condition: str, policy: str) -> list[int | None]:
        """Training seeds of a policy; one None where it was not trained."""
        return self.frames[condition, policy]["training_seed"].unique(maintain_order=True).to_list()

    def seas(self, condition: str, *policies: str) -> NDArray[np.int64]:
        """The seas that all of them, with all their training seeds, have met: (seas,), ascending."""
        common: set[int] | None = None
        for policy in policies:
            frame = self.frames[condition, policy]
            count = len(self.seeds(condition, policy))
            met = frame.group_by("sea").len().filter(pl.col("len") == count)["sea"].to_list()
            common = set(met) if common is None else common & set(met)
        return np.array(sorted(common or ()), dtype=np.int64)

    def table(self, condition: str, policy: str, column: str, seas: Sequence[int] | NDArray[np.int64]) -> Array:
        """A metric of one policy, (training seeds, seas)."""
        frame = self.frames[condition, policy]
        chosen = frame.filter(pl.col("sea").is_in(list(map(int, seas))))
        values = chosen[column].cast(pl.Float64).to_numpy()
        return np.asarray(values.reshape(len(self.seeds(condition, policy)), len(seas)))


def _check_seas(rows: pl.DataFrame) -> None:
    """Refuse rows in which the same seed of a condition was not the same sea for all: then nothing is paired."""
    columns = [name for name in OF_A_SEA if name in rows.columns]
    if not columns or not rows.height:
        return
    kinds = rows.group_by("condition", "sea").agg(pl.col(name).n_unique() for name in columns)
    wrong: Any = kinds.filter(pl.any_horizontal(pl.col(name) > 1 for name in columns))
    if wrong.height:
        raise ConfigurationError(
            f"rows: seed {wrong['sea'][0]} of condition {wrong['condition'][0]} was not the same sea for all policies; "
            "they come from different versions of the seas: remove the older ones."
        )
