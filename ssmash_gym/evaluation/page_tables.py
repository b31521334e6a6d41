"""The tables of a study's page: every number is one of ``summary.json`` or a count of rows."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import polars as pl

from ssmash_gym.envs.loading import names
from ssmash_gym.evaluation.page_data import AGENT, StudyData
from ssmash_gym.evaluation.page_style import sample
from ssmash_gym.ship.sea import comes_from_deg

MOST_LISTED: Final = 200  # episodes without success that are listed one by one
DASH: Final = "–"


@dataclass(frozen=True)
class Column:
    """Head of a column: name, unit below it, whether it holds words."""

    name: str
    unit: str = ""
    words: bool = False


@dataclass(frozen=True)
class Cell:
    """One entry: text, small text behind it, whether it is to be typed as it stands."""

    text: str
    small: str = ""
    code: bool = False


@dataclass(frozen=True)
class Row:
    """One row: its entries, the policy's line as SVG, whether it is the policy the study is about."""

    cells: list[Cell]
    key: str = ""
    first: bool = False


@dataclass(frozen=True)
class Grid:
    """A table: columns and rows; title, words and whether it is unfolded, where it can be folded."""

    columns: list[Column]
    rows: list[Row]
    caption: str = ""
    title: str = ""
    words: str = ""
    open: bool = False


@dataclass(frozen=True)
class Failures:
    """What did not succeed."""

    words: str
    counts: Grid
    listed: Grid
    title: str = ""
    open: bool = False
    command: str = ""


@dataclass(frozen=True)
class Shown:
    """How a figure of the summary is written: keys that lead to it, factor and digits."""

    column: Column
    keys: tuple[str, ...]
    factor: float = 1.0
    digits: int = 1
    interval: bool = False
    sign: bool = False


FIGURES: Final = (
    Shown(Column("success", "%"), ("success",), 100.0, 1, interval=True),
    Shown(Column("aligned", "%"), ("aligned",), 100.0),
    Shown(Column("failed", "%"), ("failed",), 100.0),
    Shown(Column("peak load, P95", "kN"), ("peak_probe_kN", "p95"), interval=True),
    Shown(Column("IQM", "kN"), ("peak_probe_kN", "iqm"), interval=True),
    Shown(Column("mean", "kN"), ("peak_probe_kN", "mean")),
    Shown(Column("beyond holding", "mean, kN"), ("excess_kN", "mean"), sign=True),
    Shown(Column("time above limit", "%"), ("over_limit_share",), 100.0, 2),
    Shown(Column("main tires, P95", "kN"), ("peak_main_kN", "p95")),
    Shown(Column("lift-offs", "per episode"), ("lift_offs",), 1.0, 2),
    Shown(Column("beyond holding", "lift-offs"), ("excess", "lift_offs"), 1.0, 2, sign=True),
    Shown(Column("beyond corridor", "% of episodes"), ("corridor",), 100.0),
    Shown(Column("time", "median s"), ("time_s",), interval=True),
)
PAIR: Final = (
    Shown(Column("P95 ratio", "%"), ("p95_ratio",), 100.0, 0, interval=True),
    Shown(Column("P95 difference", "kN"), ("p95_difference_kN",), interval=True, sign=True),
    Shown(Column("mean difference", "kN"), ("mean_difference_kN",), interval=True, sign=True),
    Shown(Column("lower load in", "% of pairs"), ("lower_peak_share",), 100.0, 0, interval=True),
    Shown(Column("success, difference", "points"), ("success_difference",), 100.0, 1, interval=True, sign=True),
    Shown(Column("time ratio", "%"), ("time_ratio",), 100.0, 0, interval=True),
    Shown(Column("main tires P95, difference", "kN"), ("main_p95_difference_kN",), interval=True, sign=True),
    Shown(Column("lift-offs, difference", "per episode"), ("lift_offs_difference",), 1.0, 2, interval=True, sign=True),
)


def number(value: float | None, digits: int = 1, sign: bool = False) -> str:
    """A number as the page writes it; a dash for none."""
    if value is None or not np.isfinite(value):
        return DASH
    rounded = round(value, digits) + 0.0  # no minus before a zero
    return f"{rounded:{'+' if sign and rounded else ''}.{digits}f}".replace("-", "−")


def cell(figures: Mapping[str, Any] | None, how: Shown) -> Cell:
    """A figure of the summary as an entry."""
    found: Any = figures
    for key in how.keys:
        found = None if found is None else found.get(key)
    if found is None or found.get("value") is None:
        return Cell(DASH)
    interval = ""
    if how.interval and found.get("ci"):
        low, high = (number(how.factor * bound, how.digits) for bound in found["ci"])
        interval = f"[{low}, {high}]"
    return Cell(number(how.factor * found["value"], how.digits, how.sign), interval)


def policy_row(data: StudyData, name: str, cells: Sequence[Cell]) -> Row:
    """A row that begins with a policy's name and line."""
    key = sample(data.looks[name]) if name in data.looks else ""
    return Row([Cell(name), *cells], key, name == data.first)


def condition_tables(data: StudyData) -> list[Grid]:
    """All figures, a table a condition; that of the main condition first."""
    found = []
    for condition in sorted(data.conditions, key=lambda one: one != data.main):
        figures = data.figures(condition).get("policies", {})
        rows = []
        for name in (one for one in data.policies if one in figures):
            own = figures[name]
            seeds = own.get("training_seeds") or []
            several = f"{len(seeds)} × {own['seas']}" if len(seeds) > 1 else str(own["seas"])
            rows.append(policy_row(data, name, [Cell(several), *(cell(own, how) for how in FIGURES)]))
        columns = [Column("policy"), Column("episodes"), *(how.column for how in FIGURES)]
        main = condition == data.main
        found.append(Grid(columns, rows, "", condition, data.words(condition), main))
    return [*found, *_per_seed(data)]


def _per_seed(data: StudyData) -> list[Grid]:
    """Each training seed by itself, in the main condition."""
    rows = []
    for name, own in data.figures(data.main).get("policies", {}).items():
        for one in own.get("per_seed", ()):
            told = [number(100 * one["success"]), number(one["p95_kN"]), number(one["mean_kN"])]
            rows.append(policy_row(data, name, [Cell(str(one["training_seed"])), *map(Cell, told)]))
    if not rows:
        return []
    columns = [
        Column("policy"), Column("training seed"), Column("success", "%"), Column("peak probe load, P95", "kN"),
        Column("mean", "kN"),
    ]  # fmt: skip
    return [Grid(columns, rows, "", "Each training seed by itself", f"in {data.main}")]


def pair_table(data: StudyData) -> list[Grid]:
    """The first policy against each other one in the main condition."""
    rows = []
    for name in data.drivers:
        found = data.pair(data.main, data.first, name)
        if found is not None:
            rows.append(policy_row(data, name, [Cell(str(found["seas"])), *(cell(found, how) for how in PAIR)]))
    if not rows:
        return []
    caption = (
        f"{data.first} against each in {data.main}: ratios are {data.first} over the other, differences {data.first} "
        "less the other, with 95 % intervals paired by sea."
    )
    return [Grid([Column("against"), Column("seas"), *(how.column for how in PAIR)], rows, caption)]


def condition_differences(data: StudyData) -> Grid:
    """What each condition changes of the main one."""
    rows = []
    for name in data.conditions:
        changes = data.changes(name)
        told = "; ".join(f"{path} = {_short(value)}" for path, value in changes.items())
        told = told or ("the main condition" if name == data.main else "nothing")
        mark = str(data.document["conditions"].get(name, {}).get("configuration", ""))
        rows.append(Row([Cell(name), Cell(data.words(name)), Cell(told), Cell(mark, code=True)]))
    columns = [
        Column("condition"), Column("stands for", words=True), Column(f"differs from {data.main} by", words=True),
        Column("configuration"),
    ]  # fmt: skip
    return Grid(columns, rows, "", "What each condition changes")


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def failures(data: StudyData) -> Failures:
    """How many episodes did not succeed, and which; `hold`, which cannot succeed, is left out."""
    hold = data.config.roles.hold
    drivers = [name for name in data.drivers if name != hold]
    counted = _counts(data, drivers)
    bad = [
        data.frame(condition, name).filter(~pl.col("success"))
        for name in (data.first, *(one for one in drivers if one != data.first))
        for condition in data.conditions
        if (condition, name) in data.rows.frames
    ]
    together = pl.concat(bad, how="diagonal_relaxed") if bad else pl.DataFrame()
    shown = _chosen(data, together)
    rows = [_episode(one) for one in shown.iter_rows(named=True)]
    columns = [
        Column("policy"), Column("condition"), Column("sea (seed)"), Column("ended by"), Column("after", "s"),
        Column("peak probe load", "kN"), Column("final yaw", "°"), Column("beside the track", "cm"),
        Column("wave height", "m"), Column("waves from", "°"), Column("ship", "kn"),
    ]  # fmt: skip
    words = (
        "Failed: ended by an ultimate load, a lost probe, overturning, the corridor or a divergence. Without success: "
        "these, and episodes whose time ran out before the goal was held, straight."
    )
    title = f"{shown.height} of {together.height} episodes without success, those of {data.first} and failures first"
    listed = Grid(columns, rows)
    command = _command(data, shown.row(0, named=True)) if shown.height else ""
    return Failures(words, counted, listed, title, shown.height <= 30, command)


def _chosen(data: StudyData, episodes: pl.DataFrame) -> pl.DataFrame:
    """The episodes that are listed: the first policy's, then failures before others, at most `MOST_LISTED`."""
    if not episodes.height:
        return episodes
    ours = (pl.col("policy") == data.first).alias("ours")
    return episodes.sort([ours, "failed"], descending=True, maintain_order=True).head(MOST_LISTED)


def _counts(data: StudyData, drivers: Sequence[str]) -> Grid:
    rows = []
    for name in drivers:
        cells = []
        for condition in data.conditions:
            if (condition, name) not in data.rows.frames:
                cells.append(Cell(DASH))
                continue
            frame = data.frame(condition, name)
            failed, missed = int(frame["failed"].sum()), frame.height - int(frame["success"].sum())
            cells.append(Cell(f"{failed} / {missed}", f"of {frame.height}"))
        rows.append(policy_row(data, name, cells))
    caption = "Failed / without success, episodes"
    return Grid([Column("policy"), *(Column(one) for one in data.conditions)], rows, caption)


def _episode(row: Mapping[str, Any]) -> Row:
    """One episode of the list of failures."""
    seed, heading = row.get("training_seed"), row.get("sea_heading_deg")
    policy = row["policy"] if seed is None else f"{row['policy']} (training seed {seed})"
    lateral = row.get("final_lateral_m")
    told = [
        Cell(str(row["reason"]).replace("_", " ")),
        Cell(number(row["time_s"])),
        Cell(number(row["peak_probe_kN"])),
        Cell(number(row.get("final_yaw_deg"))),
        Cell(number(None if lateral is None else 100.0 * lateral, 0)),
        Cell(number(row.get("sea_hs_m"))),
        Cell(number(None if heading is None else float(comes_from_deg(heading)), 0)),
        Cell(number(row.get("sea_speed_kn"), 0)),
    ]
    return Row([Cell(policy), Cell(row["condition"]), Cell(str(row["sea"]), code=True), *told])


def _command(data: StudyData, row: Mapping[str, Any]) -> str:
    """The command line that films an episode beside the book."""
    book, policy = data.config.roles.book, str(row["policy"])
    study = data.name if data.name in names("evaluation") else "FOLDER"
    words = ["ssmash", "film", "--sea", str(row["sea"]), "--study", study, "--condition", str(row["condition"])]
    if data.kind(policy) == AGENT:
        words += ["--agent", policy, "--policies", book]
    else:
        words += ["--policies", policy if policy == book else f"{policy},{book}"]
    return shlex.join([*words, "--out", "runs/film.mp4"])


def provenance(data: StudyData) -> Grid:
    """Where each policy comes from."""
    rows = []
    for name in data.policies:
        about = data.document.get("policies", {}).get(name, {})
        for seed, one in about.get("seeds", {}).items():
            steps, versions = one.get("steps"), one.get("versions", {})
            told = [
                Cell(str(about.get("kind", ""))),
                Cell(DASH if seed == "None" else str(seed)),
                Cell(DASH if steps is None else f"{steps:,}"),
                Cell(str(versions.get("ssmash_gym", DASH))),
                Cell(str(one.get("configuration", DASH)), code=True),
                Cell(str(one.get("identity", DASH)), code=True),
            ]
            rows.append(policy_row(data, name, told))
    columns = [
        Column("policy"), Column("kind"), Column("training seed"), Column("trained for", "control intervals"),
        Column("trained with", "version"), Column("training's configuration"), Column("identity"),
    ]  # fmt: skip
    return Grid(columns, rows)
