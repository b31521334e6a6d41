"""The report of a window that has been run: charts, CSV, films and one HTML page, without running anything again."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.film import require_rendering
from ssmash_gym.evaluation.page import require_report
from ssmash_gym.files import write_text
from ssmash_gym.progress import progress_bar
from ssmash_gym.windows import charts
from ssmash_gym.windows.cells import Grid
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.film import Studio, known
from ssmash_gym.windows.page import Film, write_window_page
from ssmash_gym.windows.plan import Tally, fill, rounds
from ssmash_gym.windows.rows import read_rows
from ssmash_gym.windows.sweep import limits_told
from ssmash_gym.windows.verdicts import cells_of, judged_rows

REPORT: Final = "report"  # folder within a window's
CELLS: Final = "cells.csv"
Key = tuple[str, str, int]


def write_report(
    folder: Path, *, limits: str | None = None, films: int = 0, tell: Callable[[str], None] = lambda words: None
) -> Path:
    """Write the report of a window's folder: ``report/index.html``, ``cells.csv`` and the charts as SVG.

    Args:
        folder: The window's.
        limits: Another window whose limits, acceptance and confidence are judged by, into ``report_NAME``; its own by
            default. The intervals hold for these too, as they hold at all times together.
        films: Of how many cells the worst episode is filmed: those with the greatest shares beyond a limit, the
            policies by turns.
        tell: Told what could not be filmed, and why, in a sentence each.

    Returns:
        The page.

    Raises:
        ConfigurationError: The folder holds no window or no rows; no page is written.
        ImportError: A library is missing; the sentence names the extra.
    """
    require_report()
    told = known(folder) if limits is None else _judged_by(known(folder), limits)
    rows = read_rows(folder)
    if not rows.height:
        raise ConfigurationError(f"{folder}: no episode has been run there yet.")
    rows = judged_rows(rows, told)
    cells = cells_of(rows, told)
    if limits is None and (left := unfinished(told, rows)):
        told = {**told, "description": f"{told['description']} This window is {left}."}
        tell(left)
    out = folder / (REPORT if limits is None else f"{REPORT}_{Path(limits).stem}")
    shown = _films(Studio(folder, told, rows), told, cells, films, tell)
    for stage in charts.stages_of(cells, told):
        write_text(out / f"placard_{stage}.svg", charts.placard(cells, told, stage))
        write_text(out / f"probability_{stage}.svg", charts.probability(cells, told, stage))
        if cells.filter(pl.col("stage") == stage)["policy"].n_unique() > 1:
            write_text(out / f"difference_{stage}.svg", charts.difference(cells, told, stage))
    charts.write_csv(cells, out / CELLS)
    return write_window_page(cells, rows, told, out, shown, command=command_of(told))


def command_of(told: Mapping[str, Any]) -> str:
    """The command that makes a window's rows anew."""
    words = [one["word"] for one in told["policies"].values() if one.get("word")]
    policies = " ".join(f"--policy {shlex.quote(word)}" for word in words)
    effort = told["resolved"]["effort"]
    given = " ".join(f"--{key} {effort[key]}" for key in ("seeds", "most", "episodes") if effort[key] is not None)
    return " ".join(f"ssmash window {shlex.quote(str(told['source']))} {policies} {given} --out DIR".split())


def unfinished(told: Mapping[str, Any], rows: pl.DataFrame) -> str:
    """A sentence where a window has not been run to its end, by its own rule; empty where it has."""
    config = load_window(told["resolved"])
    seas = max(int(rows["number"].max() or 0) + 1, config.effort.most, config.effort.seeds)  # type: ignore[arg-type]
    tallies = {
        (stage, policy): Tally.blank(len(Grid(config.axes)), seas)
        for stage, policy in rows.select("stage", "policy").unique(maintain_order=True).iter_rows()
    }
    fill(tallies, config, rows)
    wanted = rounds(config, tallies)
    left = sum(int((~tallies[who].full(counts)).sum()) for who, counts in wanted.items())
    return f"not finished: {left:,} cells would still get seas; {command_of(told)} goes on" if left else ""


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


def _films(
    studio: Studio, told: Mapping[str, Any], cells: pl.DataFrame, count: int, tell: Callable[[str], None]
) -> Mapping[Key, Film]:
    """Films of the cells with the greatest shares beyond a limit, that of each policy first."""
    ranked = cells.sort(["share", "lost", "worst_use"], descending=True, nulls_last=True).with_columns(
        pl.int_range(pl.len()).over("stage", "policy").alias("place")
    )
    chosen = ranked.sort("place", "stage", "policy", maintain_order=True).head(count)
    found: dict[Key, Film] = {}
    if not chosen.height:
        return found
    try:
        require_rendering()
    except ImportError as missing:
        tell(f"no films: {missing}")
        return found
    with progress_bar("films") as advance:
        for k, row in enumerate(chosen.iter_rows(named=True)):
            advance(k / chosen.height, f"film {k + 1} of {chosen.height}")
            try:
                path = studio.film(row)
            except ConfigurationError as refused:
                tell(f"no film of cell {row['cell']}: {refused}")
                continue
            found[str(row["stage"]), str(row["policy"]), int(row["cell"])] = Film(path, _caption(told, row))
    return found


def _caption(told: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """What a film shows."""
    where = ", ".join(
        f"{one['label']} {row[name]:g} {one['unit']}".strip()
        for name, one in told["axes"].items()
        if row[name] is not None
    )
    lost = f"; lost in {row['lost']} of {row['episodes']} episodes" if row["lost"] else ""
    return (
        f"{row['policy']}, {row['stage']}: {where}; the worst of {row['episodes']} seas, seed {row['worst_seed']}{lost}"
    )
