"""The report of a window that has been run: charts, CSV, films and one HTML page, without running anything again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.film import require_rendering
from ssmash_gym.evaluation.page import require_report
from ssmash_gym.files import write_text
from ssmash_gym.progress import progress_bar
from ssmash_gym.windows import charts
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.film import film_worst, known
from ssmash_gym.windows.page import Film, write_window_page
from ssmash_gym.windows.rows import read_rows
from ssmash_gym.windows.sweep import limits_told
from ssmash_gym.windows.verdicts import cells_of, judged_rows

REPORT: Final = "report"  # folder within a window's
CELLS: Final = "cells.csv"
Key = tuple[str, str, int]


def write_report(folder: Path, *, limits: str | None = None, films: int = 0) -> Path:
    """Write the report of a window's folder: ``report/index.html``, ``cells.csv`` and the charts as SVG.

    Args:
        folder: The window's.
        limits: Another window whose limits, acceptance and confidence are judged by; its own by default. The intervals
            hold for these too, as they hold at all times together.
        films: Of how many cells the worst episode is filmed: those that are farthest beyond a limit, the policies by
            turns.

    Returns:
        The page.

    Raises:
        ConfigurationError: The folder holds no window or no rows, or something cannot be filmed; no page is written.
        ImportError: A library is missing; the sentence names the extra.
    """
    require_report()
    if films:
        require_rendering()
    told = known(folder) if limits is None else _judged_by(known(folder), limits)
    rows = read_rows(folder)
    if not rows.height:
        raise ConfigurationError(f"{folder}: no episode has been run there yet.")
    rows = judged_rows(rows, told)
    cells = cells_of(rows, told)
    out = folder / REPORT
    shown = _films(folder, told, cells, films)
    for stage in charts.stages_of(cells, told):
        write_text(out / f"placard_{stage}.svg", charts.placard(cells, told, stage))
        write_text(out / f"probability_{stage}.svg", charts.probability(cells, told, stage))
        if cells.filter(pl.col("stage") == stage)["policy"].n_unique() > 1:
            write_text(out / f"difference_{stage}.svg", charts.difference(cells, told, stage))
    charts.write_csv(cells, out / CELLS)
    words = " ".join(f"--policy {name}" for name in charts.policies_of(cells, told))
    command = f"ssmash window {told['name']} {words} --out DIR"
    return write_window_page(cells, rows, told, out, shown, command=command)


def _judged_by(told: dict[str, Any], limits: str) -> dict[str, Any]:
    """The record of a window with the limits of another one."""
    other = load_window(limits)
    return {
        **told,
        "limits": limits_told(other),
        "must_arrive": other.must_arrive,
        "acceptance": other.acceptance,
        "confidence": other.confidence,
        "description": f"{told['description']} Judged by the limits of {limits}.",
    }


def _films(folder: Path, told: dict[str, Any], cells: pl.DataFrame, count: int) -> Mapping[Key, Film]:
    """Films of the cells with the greatest use of a limit, the best known cell of each policy first."""
    ranked = cells.filter(pl.col("worst_use").is_finite()).with_columns(
        pl.col("worst_use").rank("ordinal", descending=True).over("stage", "policy").alias("place")
    )
    chosen = ranked.sort("place", "stage", "policy").head(count)
    found = {}
    with progress_bar("films", shown=bool(chosen.height)) as advance:
        for k, row in enumerate(chosen.iter_rows(named=True)):
            advance(k / chosen.height, f"film {k + 1} of {chosen.height}")
            path = film_worst(folder, told, row)
            where = ", ".join(f"{one['label'].split(' (')[0]} {row[name]:g} {one['unit']}".strip()
                              for name, one in told["axes"].items())  # fmt: skip
            use = f"seed {row['worst_seed']}, {row['worst_use']:.1f} times a limit"
            words = f"{row['policy']}, {row['stage']}: {where}; {use}"
            found[str(row["stage"]), str(row["policy"]), int(row["cell"])] = Film(path, words)
    return found
