"""The numbers that a window's page holds for its interactive part: every cell, and its worst episodes, as JSON."""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import polars as pl

from ssmash_gym.windows.chart_layout import Layout, axes_of, layout_of
from ssmash_gym.windows.chart_looks import beyond_words
from ssmash_gym.windows.charts import policies_of, stages_of

MOST_EPISODES: Final = 10  # of a cell that the page holds: all would be tens of megabytes
MOST_PEAKS: Final = 9  # columns of the list of episodes
DIGITS: Final = 4
PEAKS: Final = {
    "peak_probe_kN": "probe, plane", "peak_axial_kN": "probe, axis", "peak_main_kN": "main station",
    "peak_auxiliary_kN": "auxiliary", "least_station_kN": "least station", "peak_roll_deg": "roll",
    "peak_oleo_share": "oleo", "sliding_m": "sliding", "least_clearance_m": "clearance",
}  # fmt: skip
UNITS: Final = ("kN", "N", "deg", "mps", "m", "s", "kNm", "m_s")
KEYS: Final = ("stage", "policy", "cell")
Key = tuple[str, str, int]


@dataclass(frozen=True)
class Peaks:
    """Columns of the table of episodes that the page shows: names and heads."""

    names: list[str]
    heads: list[str]


def peaks_of(rows: pl.DataFrame) -> Peaks:
    """The main peaks of a table of episodes: those known, then others whose name says that they are one."""
    known = [name for name in PEAKS if name in rows.columns]
    others = [name for name in rows.columns if name.startswith(("peak_", "least_")) and name not in PEAKS]
    names = [name for name in (*known, *others) if rows.schema[name].is_numeric()][:MOST_PEAKS]
    return Peaks(names, [_head(name) for name in names])


def _head(name: str) -> str:
    """Head of a column: words and unit."""
    unit = next((one for one in sorted(UNITS, key=len, reverse=True) if name.endswith(f"_{one}")), "")
    plain = name.removesuffix(f"_{unit}") if unit else name
    words = PEAKS.get(name) or re.sub(r"^(peak|least)_", "", plain).replace("_", " ")
    return f"{words} [{'°' if unit == 'deg' else unit}]" if unit else words


def worst(rows: pl.DataFrame, cells: pl.DataFrame) -> pl.DataFrame:
    """The worst episodes of every cell, the worst one first.

    That one is the cell's ``worst_seed``; the others follow by the number of limits exceeded, then by the greatest use
    of a limit.

    Args:
        rows: One row an episode.
        cells: One row a cell.

    Returns:
        Rows of the table, at most `MOST_EPISODES` a cell.
    """
    if not rows.height:
        return rows
    exceeds = pl.col("exceeds").fill_null("") if "exceeds" in rows.columns else pl.lit("")
    success = pl.col("success").fill_null(True) if "success" in rows.columns else pl.lit(True)
    ranked = rows.with_columns(
        _over=pl.when(exceeds == "").then(0).otherwise(exceeds.str.count_matches(",") + 1), _lost=~success,
        _use=pl.col("worst_use"),
    )  # fmt: skip
    order, down = ["_over", "_lost", "_use", "number"], [True, True, True, False]
    if "worst_seed" in cells.columns:
        ranked = ranked.join(cells.select(*KEYS, "worst_seed"), on=KEYS, how="left", suffix="_cell")
        ranked = ranked.with_columns(_worst=(pl.col("seed") == pl.col("worst_seed")).fill_null(False))
        order, down = ["_worst", *order], [True, *down]
    ranked = ranked.sort(order, descending=down, nulls_last=True)
    return ranked.group_by(KEYS, maintain_order=True).head(MOST_EPISODES)


def page_data(
    cells: pl.DataFrame, rows: pl.DataFrame, document: Mapping[str, Any], films: Mapping[Key, str]
) -> dict[str, Any]:
    """Everything that the page's script shows.

    Args:
        cells: One row a cell.
        rows: One row an episode; may be empty.
        document: Contents of ``window.json``.
        films: Identifier of the film's element in the page, by stage, policy and cell.
    """
    stages, policies = stages_of(cells, document), policies_of(cells, document)
    limits, axes, peaks = document.get("limits", {}), axes_of(cells, document), peaks_of(rows)
    layout = layout_of(cells, document)
    kept = worst(rows, cells)
    listed = {key: part for key, part in kept.partition_by(KEYS, as_dict=True).items()} if kept.height else {}
    reasons = sorted(set(kept["reason"].drop_nulls())) if kept.height and "reason" in kept.columns else []
    found = [
        _cell(row, layout, axes_names=[axis.name for axis in axes], limits=list(limits))
        | {
            "s": stages.index(row["stage"]), "p": policies.index(row["policy"]),
            "film": films.get((row["stage"], row["policy"], row["cell"])),
            "rows": _episodes(listed.get((row["stage"], row["policy"], row["cell"])), list(limits), peaks, reasons),
        }
        for row in cells.iter_rows(named=True)
    ]  # fmt: skip
    return {
        "stages": stages, "policies": policies, "reasons": reasons, "peaks": peaks.heads,
        "axes": [{"label": one.label.split(",")[0], "unit": "°" if one.unit == "deg" else one.unit} for one in axes],
        "limits": [{"label": str(one.get("label") or name), "value": beyond_words(one)}
                   for name, one in limits.items()],
        "names": list(limits), "closed": layout.closed, "most": MOST_EPISODES,
        "sizes": [len(layout.panels), len(layout.across.values), len(layout.along.values)],
        "commands": [[_command(stage, policy) for policy in policies] for stage in stages], "cells": found,
    }  # fmt: skip


def _command(stage: str, policy: str) -> str:
    """What films a cell, but for its number."""
    return f"ssmash window --film DIR --policy {shlex.quote(policy)} --stage {shlex.quote(stage)} --cell "


def _cell(row: Mapping[str, Any], layout: Layout, axes_names: Sequence[str], limits: Sequence[str]) -> dict[str, Any]:
    """Numbers of one cell under short names: there are many."""
    return {
        "c": row["cell"], "at": [rounded(row[name]) for name in axes_names], "place": layout.place(row),
        "n": row["episodes"], "over": row.get("exceeded"), "share": [rounded(row[k]) for k in ("share", "low", "high")],
        "v": row["verdict"], "by": row["limiting"], "valid": row.get("valid") is not False,
        "by_limit": [row.get(f"over_{name}") for name in limits],
        "use": [rounded(row.get(f"use_{name}")) for name in limits], "worst": rounded(row.get("worst_use")),
    }  # fmt: skip


def _episodes(
    part: pl.DataFrame | None, limits: Sequence[str], peaks: Peaks, reasons: Sequence[str]
) -> list[list[Any]]:
    """Episodes of a cell: seed (as a string: it may be longer than a number of the script), number, reason, ..."""
    if part is None:
        return []
    found = []
    for row in part.iter_rows(named=True):
        over = [name for name in (row.get("exceeds") or "").split(",") if name]
        reason = reasons.index(row["reason"]) if row.get("reason") is not None else -1
        known = [limits.index(name) if name in limits else name for name in over]
        values = [rounded(row.get(name)) for name in ("time_s", *peaks.names)]
        found.append([str(row.get("seed")), row.get("number"), reason, int(bool(row.get("success"))), known, *values])
    return found


def rounded(value: float | None) -> float | int | None:
    """A number to sensible digits; None for what is not finite, which JSON does not know."""
    if value is None or not math.isfinite(value):
        return None
    short = float(f"{value:.{DIGITS}g}")
    return int(short) if short.is_integer() else short


def as_json(data: Mapping[str, Any]) -> str:
    """JSON that may stand in a page: without a sign that begins a tag."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
