"""Films of a window's episodes: bit for bit the ones that were judged."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.film import film_side_by_side, require_rendering
from ssmash_gym.evaluation.study_entrants import Entrant, agent_entrants, code
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
        word = "--film needs --stage" if stage is None else f"--stage {stage} is refused"
        raise ConfigurationError(f"{word}: the window has {', '.join(stages)}.")
    if cell is None or len(policies) > 1:
        raise ConfigurationError("--film needs one --cell, and one --policy at most: the report tells both.")
    rows = read_rows(folder)
    cells = cells_of(judged_rows(rows, told), told)
    here = cells.filter(pl.col("stage") == chosen)
    names = here["policy"].unique(maintain_order=True).to_list()
    if not policies and len(names) > 1:
        raise ConfigurationError(f"--film needs --policy: the window has {', '.join(names)} in this stage.")
    word = policies[0] if policies else names[0]
    name = word if word in names else _name_of(word)
    found = here.filter(pl.col("policy") == name, pl.col("cell") == cell)
    if not found.height:
        raise ConfigurationError(
            f"--cell {cell} --policy {word} is refused: {folder} has no rows of it; its policies are "
            f"{', '.join(names)}."
        )
    return Studio(folder, told, rows).film(found.row(0, named=True), None if word == name else word)


def _name_of(word: str) -> str:
    """The name of an agent that is given by its folder; the word itself where it is none."""
    try:
        return agent_entrants([word])[0].name
    except ConfigurationError:
        return word


def known(folder: Path) -> dict[str, Any]:
    """The ``window.json`` of a folder that holds a window.

    Raises:
        ConfigurationError: It holds none.
    """
    told = read_document(folder)
    if not told:
        raise ConfigurationError(f"{folder}: there is no window in this folder (window.json is missing).")
    return told


class Studio:
    """Films the episodes of one window.

    Args:
        folder: The window's.
        told: Its ``window.json``.
        rows: Its rows.
    """

    def __init__(self, folder: Path, told: dict[str, Any], rows: pl.DataFrame) -> None:
        self._folder, self._told, self._rows = folder, told, rows
        self._sweeps: dict[str | None, Sweep] = {}  # by the word for the policy: to prepare one takes a while

    def film(self, row: dict[str, Any], word: str | None = None) -> Path:
        """Film the worst episode of one row of `verdicts.cells_of`; what has been filmed already is kept.

        Args:
            row: Stage, policy, cell and ``worst_seed``.
            word: Where its policy is to be found; where the window found it by default.

        Raises:
            ConfigurationError: The code, the window or the policy is not the one of the rows.
        """
        folder, told = self._folder, self._told
        stage, name, cell, seed = str(row["stage"]), str(row["policy"]), int(row["cell"]), int(row["worst_seed"])
        path = folder / FILMS / f"{stage}-{name}-{cell}-{seed}-{told['configuration']}.mp4"
        if path.is_file():
            return path
        episode = self._rows.filter(
            pl.col("stage") == stage, pl.col("policy") == name, pl.col("cell") == cell, pl.col("seed") == seed
        ).row(0, named=True)
        if episode["code"] != code():
            raise ConfigurationError(
                f"{folder}: {name} cannot be filmed: the sources have changed since its rows were made."
            )
        sweep = self._sweep(word or told["policies"].get(name, {}).get("word"))
        entrant = _same(sweep, told, folder, stage, name)
        setting = sweep.job.settings[stage]
        policy = entrant.make(setting.task)
        scenario = setting.of(sweep.job.grid.cell(cell))
        metrics = film_side_by_side(
            [policy], scenario, seed, path, helicopter=setting.helicopter, largest_bytes=LARGEST_BYTES
        )[policy.name]
        if any(episode[key] != value for key, value in metrics.items() if key in episode):
            path.unlink()
            raise ConfigurationError(f"{folder}: what was filmed was not the episode of the rows, so it was not kept.")
        return path

    def _sweep(self, word: str | None) -> Sweep:
        """The window with the policy that a word names; with its own where there is none."""
        if word not in self._sweeps:
            window = load_window(self._told["resolved"])
            self._sweeps[word] = prepared(window, str(self._told["name"]), (word,) if word else ())
        return self._sweeps[word]


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
    return entrant
