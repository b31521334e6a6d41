"""Films of a window's episodes: bit for bit the ones that were judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.film import film_side_by_side, require_rendering
from ssmash_gym.evaluation.study_entrants import Entrant
from ssmash_gym.windows.cells import Grid
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.rows import read_document, read_rows
from ssmash_gym.windows.sweep import Sweep, prepared
from ssmash_gym.windows.verdicts import cells_of, judged_rows

FILMS: Final = "films"  # folder within a window's
LARGEST_BYTES: Final = 1_000_000  # of one film: several go into a page


def film_cell(folder: Path, cell: int | None, policies: Sequence[str], stage: str | None) -> Path:
    """Film the worst episode of a cell.

    Args:
        folder: The window's.
        cell: Number of the cell.
        policies: One, at the claw: as the window was run with.
        stage: Of the window; may be left out where it has only one.

    Raises:
        ConfigurationError: The folder holds no window, or no such cell, policy or stage; or the code or the policy is
            not the one of the rows.
        ImportError: A library is missing; the sentence names the extra.
    """
    require_rendering()
    told = known(folder)
    stages = list(told["stages"])
    chosen = stage or (stages[0] if len(stages) == 1 else None)
    if chosen not in stages:
        raise ConfigurationError(f"--stage {stage} is refused: the window has {', '.join(stages)}.")
    if cell is None or len(policies) > 1:
        raise ConfigurationError("--film needs one --cell and one --policy: the report tells their numbers and names.")
    cells = cells_of(judged_rows(read_rows(folder), told), told)
    here = cells.filter(pl.col("stage") == chosen)
    names = here["policy"].unique(maintain_order=True).to_list()
    name = policies[0].partition("=")[0] if policies else names[0]
    found = here.filter(pl.col("policy") == name, pl.col("cell") == cell)
    if not found.height:
        raise ConfigurationError(
            f"--cell {cell} --policy {name} is refused: {folder} has no rows of it; its policies are "
            f"{', '.join(names)}."
        )
    return film_worst(folder, told, found.row(0, named=True), policies or (name,))


def known(folder: Path) -> dict[str, Any]:
    """The ``window.json`` of a folder that holds a window.

    Raises:
        ConfigurationError: It holds none.
    """
    told = read_document(folder)
    if not told:
        raise ConfigurationError(f"{folder}: there is no window in this folder (window.json is missing).")
    return told


def film_worst(folder: Path, told: dict[str, Any], row: dict[str, Any], policies: Sequence[str] = ()) -> Path:
    """Film the worst episode of one row of `verdicts.cells_of`; what has been filmed already is kept.

    Raises:
        ConfigurationError: The code or the policy is not the one of the rows.
    """
    stage, name, cell = str(row["stage"]), str(row["policy"]), int(row["cell"])
    path = folder / FILMS / f"{stage}-{name}-{cell}-{row['worst_seed']}.mp4"
    if path.is_file():
        return path
    sweep = prepared(load_window(told["resolved"]), str(told["name"]), policies or (name,))
    entrant = _same(sweep, told, folder, stage, name)
    setting = sweep.job.settings[stage]
    policy = entrant.make(setting.task)
    scenario = setting.of(Grid(sweep.config.axes).cell(cell))
    metrics = film_side_by_side(
        [policy], scenario, int(row["worst_seed"]), path, helicopter=setting.helicopter, largest_bytes=LARGEST_BYTES
    )[policy.name]
    rows = read_rows(folder).filter(pl.col("stage") == stage, pl.col("policy") == name, pl.col("cell") == cell)
    judged = rows.filter(pl.col("seed") == row["worst_seed"]).row(0, named=True)
    if metrics["peak_probe_kN"] != judged["peak_probe_kN"]:
        path.unlink()
        raise ConfigurationError(f"{folder}: the film was not the episode of the rows; the code has changed since.")
    return path


def _same(sweep: Sweep, told: dict[str, Any], folder: Path, stage: str, name: str) -> Entrant:
    """The policy, if the window and it are those of the folder.

    Raises:
        ConfigurationError: They are not.
    """
    entrant = sweep.job.entrants.get(stage, {}).get(name)
    made = told["policies"].get(name, {}).get("identities", {}).get(stage)
    if entrant is None or sweep.identity != told["configuration"] or entrant.identity != made:
        raise ConfigurationError(
            f"{folder}: {name} in {stage} cannot be filmed: the window or the policy is not the one of the rows any "
            "more."
        )
    return replace(entrant, name=name)
