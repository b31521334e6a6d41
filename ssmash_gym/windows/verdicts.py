"""What a window amounts to: one row a stage, policy and cell, with interval, verdict and limiting factor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from ssmash_gym.windows import criteria
from ssmash_gym.windows.sequential import BEYOND, UNDECIDED, WITHIN, bounds
from ssmash_gym.windows.stages import STAGES

_WHO = ("stage", "policy", "cell")


def judged_rows(rows: pl.DataFrame, document: Mapping[str, Any]) -> pl.DataFrame:
    """The rows of all stages with what was exceeded in each (`criteria.judged`).

    Args:
        rows: As of `rows.read_rows`.
        document: Contents of ``window.json``; limits and acceptance may be other ones than those it was run with, the
            intervals hold for any, as they hold at all times together.

    Returns:
        `rows` with the columns of `criteria.judged`, and ``exceeds``, the names of what was exceeded with commas.
    """
    given = {name: limit["value"] for name, limit in document["limits"].items()}
    figures = {name: float(value) for name, value in given.items() if value is not None}
    frames = []
    for stage, part in rows.group_by("stage", maintain_order=True):
        must_arrive = bool(document["must_arrive"]) and STAGES[str(stage[0])].arrives
        found = criteria.judged(part, figures, must_arrive=must_arrive)
        told = [
            pl.when(pl.col(f"over_{name}")).then(pl.lit(name))
            for name in criteria.names_of(figures, must_arrive=must_arrive)
        ]
        frames.append(found.with_columns(pl.concat_str(told, separator=",", ignore_nulls=True).alias("exceeds")))
    return pl.concat(frames, how="diagonal_relaxed") if frames else rows


def cells_of(rows: pl.DataFrame, document: Mapping[str, Any]) -> pl.DataFrame:
    """One row a stage, policy and cell.

    Args:
        rows: As of `judged_rows`.
        document: Contents of ``window.json``.

    Returns:
        Stage, policy, cell and its place on each axis; ``episodes``, ``exceeded``, ``share`` with the confidence
        sequence ``low`` to ``high``; ``verdict``; ``limiting``, what was exceeded in most episodes (None where nothing
        was); ``over_NAME``, in how many; ``use_NAME``, the 95th percentile of peak over limit; ``valid``, whether the
        model of the motion holds for all its seas; ``lost``, episodes that ended by a failure; ``worst_seed`` and
        ``worst_use``, of an episode that was lost if there is one, else beyond a limit, else closest to one.
    """
    over = [name for name in rows.columns if name.startswith("over_") and name != "over_limit_s"]
    uses = [name for name in rows.columns if name.startswith("use_")]
    if not rows.height:
        return pl.DataFrame()
    graver = [pl.col("failed"), pl.col("exceeded"), pl.col("worst_use").fill_nan(np.inf)]
    first = {"descending": True, "nulls_last": True}
    cells = rows.group_by(*_WHO).agg(
        *(pl.col(name).first() for name in document["axes"]),
        pl.len().cast(pl.Int64).alias("episodes"),
        pl.col("exceeded").sum().cast(pl.Int64).alias("exceeded"),
        *(pl.col(name).fill_null(False).sum().cast(pl.Int64) for name in over),
        *(pl.col(name).quantile(0.95, "linear") for name in uses),
        pl.col("within_validity").all().alias("valid"),
        pl.col("failed").sum().cast(pl.Int64).alias("lost"),
        pl.col("seed").sort_by(graver, **first).first().alias("worst_seed"),
        pl.col("worst_use").sort_by(graver, **first).first().alias("worst_use"),
    )
    cells = cells.sort(*_WHO)
    found = bounds(cells["exceeded"].to_numpy(), cells["episodes"].to_numpy(), float(document["confidence"]))
    counts = cells.select(over).to_numpy() if over else np.zeros((cells.height, 1))
    names = [name.removeprefix("over_") for name in over]
    limiting = [names[int(np.argmax(row))] if names and row.max() > 0 else None for row in counts]
    return cells.with_columns(
        (pl.col("exceeded") / pl.col("episodes")).alias("share"),
        pl.Series("low", found.low),
        pl.Series("high", found.high),
        pl.Series("verdict", found.verdicts(float(document["acceptance"]))),
        pl.Series("limiting", limiting, dtype=pl.String),
    )


def judged(cells: pl.DataFrame) -> pl.DataFrame:
    """The cells that are counted: those inside the validity of the seaway's model."""
    return cells.filter(pl.col("valid").fill_null(True)) if "valid" in cells.columns else cells


def count(cells: pl.DataFrame, verdict: str) -> int:
    """Number of cells with a verdict."""
    return cells.filter(pl.col("verdict") == verdict).height


def sentences(cells: pl.DataFrame) -> list[str]:
    """What a window says, a line a stage and policy."""
    found = []
    for (stage, policy), part in cells.group_by("stage", "policy", maintain_order=True) if cells.height else ():
        valid = judged(part)
        most = valid.filter(pl.col("verdict") == BEYOND)["limiting"].drop_nulls().mode().sort().to_list()
        limited = f", mostly by: {criteria.label_of(most[0])}" if most else ""
        outside = part.height - valid.height
        note = (
            f"; a further {outside} lie outside the validity of the ship's motion and are not counted"
            if outside
            else ""
        )
        within, beyond, undecided = (count(valid, verdict) for verdict in (WITHIN, BEYOND, UNDECIDED))
        found.append(
            f"{stage}, {policy}: {within} of {valid.height} cells within the limits, {beyond} beyond"
            f"{limited}, {undecided} undecided after {part['episodes'].sum():,} episodes{note}."
        )
    return found
