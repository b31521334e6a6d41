"""What a window says in plain words, and its tables: counts of cells, directions and speeds that are within."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import polars as pl

from ssmash_gym import __version__
from ssmash_gym.evaluation.page_tables import DASH, Cell, Column, Grid, Row
from ssmash_gym.windows.chart_layout import Axis, Layout, axes_of, layout_of
from ssmash_gym.windows.chart_looks import beyond_words, limit_words, quantity, share_words
from ssmash_gym.windows.charts import policies_of, stages_of
from ssmash_gym.windows.sequential import BEYOND, UNDECIDED, WITHIN
from ssmash_gym.windows.verdicts import count, judged

EVERYWHERE: Final = "all"
NOWHERE: Final = "none"


def headline(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[str]:
    """The answer: a sentence or two for each stage and policy, and what one policy opens that the other does not."""
    told = []
    for stage in stages_of(cells, document):
        own = cells.filter(pl.col("stage") == stage)
        policies = policies_of(own, document)
        told += [_answer(own.filter(pl.col("policy") == name), document, stage, name) for name in policies]
        if len(policies) > 1:
            told.append(_compared(judged(own), stage, policies[0], policies[1]))
    return told


def _answer(own: pl.DataFrame, document: Mapping[str, Any], stage: str, policy: str) -> str:
    """Where one policy keeps the limits in one stage."""
    sound = judged(own)
    if not sound.height:
        return f"{stage.capitalize()} with {policy}: every cell lies outside the validity of the seaway's model."
    within, beyond, undecided = (count(sound, verdict) for verdict in (WITHIN, BEYOND, UNDECIDED))
    told = f"{stage.capitalize()} with {policy}: within the limits in {within} of {_cells(sound.height)}, "
    told += f"beyond in {beyond}"
    most = _most(sound, document)
    told += f" (most often by {most[0]}: {most[1]} of them)" if most else ""
    told += f", undecided in {undecided}."
    outside = own.height - sound.height
    return told + (f" A further {_cells(outside)} outside the model's validity: not counted." if outside else "")


def _cells(number: int) -> str:
    return f"{number} cell" if number == 1 else f"{number} cells"


def _most(cells: pl.DataFrame, document: Mapping[str, Any]) -> tuple[str, int] | None:
    """Label of the limit by which most cells are beyond, and in how many."""
    names = cells.filter((pl.col("verdict") == BEYOND) & pl.col("limiting").is_not_null())["limiting"].to_list()
    if not names:
        return None
    known = [*document.get("limits", {}), *sorted(set(names))]
    name = max(known, key=names.count)
    return str(document.get("limits", {}).get(name, {}).get("label") or name), names.count(name)


def _compared(cells: pl.DataFrame, stage: str, one: str, other: str) -> str:
    """In how many cells only one of two policies is within."""
    sets = [
        set(cells.filter((pl.col("policy") == name) & (pl.col("verdict") == WITHIN))["cell"]) for name in (one, other)
    ]
    both = set(cells.filter(pl.col("policy") == one)["cell"]) & set(cells.filter(pl.col("policy") == other)["cell"])
    only, lost = len((sets[0] - sets[1]) & both), len((sets[1] - sets[0]) & both)
    return f"Of the {stage} cells that both policies ran, {only} are within with {one} only, {lost} with {other} only."


# --- tables --------------------------------------------------------------------------------------------------


def counts(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[Grid]:
    """Cells by verdict, policy and panel (such as the sea state), a table a stage."""
    layout = layout_of(cells, document)
    head = Column(layout.others[-1].label) if layout.others else Column("cells")
    columns = [Column("policy"), head, Column("within"), Column("undecided"), Column("beyond"),
               Column("most often by", words=True), *_columns(layout),
               Column("outside validity", "not counted")]  # fmt: skip
    found = []
    for stage in stages_of(cells, document):
        rows = []
        for policy in policies_of(cells, document):
            own = cells.filter((pl.col("stage") == stage) & (pl.col("policy") == policy))
            rows += _rows(own, document, layout, policy) if own.height else []
        found.append(Grid(columns, rows, f"{stage.capitalize()}: number of cells"))
    return found


def _columns(layout: Layout) -> list[Column]:
    if not layout.polar:
        return []
    unit = "°" if layout.across.unit == "deg" else layout.across.unit
    return [Column("within at every speed", f"directions, {unit}", words=True),
            Column("all directions within", f"up to, {layout.along.unit}")]  # fmt: skip


def _rows(own: pl.DataFrame, document: Mapping[str, Any], layout: Layout, policy: str) -> list[Row]:
    """Rows of one policy, one a value of the axis that differs from panel to panel."""
    axis = layout.others[-1] if layout.others else None
    found = []
    for value in axis.values if axis else (None,):
        here = own if axis is None or value is None else own.filter((pl.col(axis.name) - value).abs() < 1e-9)
        if not here.height:
            continue
        sound = judged(here)
        most = _most(sound, document)
        told = [quantity(value, axis.unit) if axis else EVERYWHERE]
        told += [str(count(sound, verdict)) for verdict in (WITHIN, UNDECIDED, BEYOND)]
        told.append(f"{most[0]} ({most[1]})" if most else DASH)
        told += [directions(here, layout), fastest(here, layout)] if layout.polar else []
        found.append(Row([Cell(policy), *map(Cell, told), Cell(str(here.height - sound.height))]))
    return found


def _inside(cells: pl.DataFrame, column: str, values: Sequence[float]) -> list[bool]:
    """Whether all cells with each value are within, and inside the model's validity; without cells, they are not."""
    valid = pl.col("valid").fill_null(True) if "valid" in cells.columns else pl.lit(True)
    good = cells.with_columns(_good=(pl.col("verdict") == WITHIN) & valid)
    table = dict(good.group_by(pl.col(column).round(9)).agg(pl.col("_good").all()).iter_rows())
    return [bool(table.get(value, False)) for value in values]


def directions(cells: pl.DataFrame, layout: Layout) -> str:
    """The directions that are within at every speed, as ranges that may go over the bow."""
    values, good = layout.across.values, _inside(cells, layout.across.name, layout.across.values)
    if all(good):
        return EVERYWHERE
    if not any(good):
        return NOWHERE
    first = good.index(False) if layout.closed else 0
    order = [*range(first, len(values)), *range(first)]
    runs: list[list[int]] = []
    for before, k in zip([None, *order], order, strict=False):
        if good[k]:
            if before is not None and good[before]:
                runs[-1].append(k)
            else:
                runs.append([k])
    return ", ".join(f"{values[run[0]]:g}" + (f"–{values[run[-1]]:g}" if len(run) > 1 else "") for run in runs)


def fastest(cells: pl.DataFrame, layout: Layout) -> str:
    """The speed up to which every direction is within."""
    good = _inside(cells, layout.along.name, layout.along.values)
    kept = good.index(False) if not all(good) else len(good)
    return f"{layout.along.values[kept - 1]:g}" if kept else NOWHERE


# --- where it comes from -------------------------------------------------------------------------------------


def limits(document: Mapping[str, Any]) -> Grid:
    """Every limit with its value and its ground."""
    rows = [
        Row([
            Cell(str(one.get("label") or name)), Cell(name, code=True),
            Cell(beyond_words(one) or "it happens"),
            Cell(str(one.get("note") or DASH)),
        ])
        for name, one in document.get("limits", {}).items()
    ]  # fmt: skip
    columns = [Column("limit"), Column("name"), Column("beyond when"), Column("ground", words=True)]
    return Grid(columns, rows, "Limits: an episode is beyond when one of them is exceeded at any moment.")


def axes(cells: pl.DataFrame, document: Mapping[str, Any]) -> Grid:
    """What was varied."""
    rows = [Row([Cell(one.title), Cell(one.name, code=True), Cell(_values(one))]) for one in axes_of(cells, document)]
    return Grid([Column("axis"), Column("name"), Column("values", words=True)], rows, "What was varied")


def _values(axis: Axis) -> str:
    return ", ".join(quantity(value) for value in axis.values)


def policies(document: Mapping[str, Any]) -> Grid:
    """What is known of each policy."""
    rows = []
    for name, about in (document.get("policies") or {}).items():
        told: Iterable[tuple[str, Any]] = about.items() if isinstance(about, Mapping) else [("", about)]
        plain = [
            f"{key}: {value!s}" if key else str(value) for key, value in told if not isinstance(value, Mapping | list)
        ]
        rows.append(Row([Cell(name), Cell("; ".join(plain) or DASH)]))
    return Grid([Column("policy"), Column("what it is", words=True)], rows, "Policies; scripted ones are not humans")


def method(document: Mapping[str, Any]) -> list[str]:
    """How a cell is judged."""
    accepted = share_words(float(document["acceptance"]))
    sure = share_words(float(document["confidence"]))
    return [
        f"An episode counts as beyond when it exceeds any limit. A cell is within when the {sure} interval of the "
        f"share of such episodes lies below {accepted}, beyond when it lies above, undecided when it still "
        f"holds {accepted}.",
        "The interval is a time-uniform confidence sequence: it holds at every number of episodes at once, so that "
        "stopping as soon as a cell is decided does not spoil it. It holds for each cell by itself, not for all "
        "cells together, and it covers the draw of the seas, not errors of the model.",
        "Cells outside the validity of the seaway's model are drawn with wide diagonal lines and are not counted.",
        "Limits marked as assumed come from no operator and no manufacturer: no operational limit follows from this.",
    ]


def facts(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names and numbers below the title."""
    given = [(key, str(document[key])) for key in ("helicopter", "scenario", "task") if document.get(key)]
    total = int(cells["episodes"].sum() or 0)
    low, high = cells["episodes"].min(), cells["episodes"].max()
    told = [
        ("cells", f"{cells['cell'].n_unique():,}"), ("episodes", f"{total:,}"),
        ("in a cell", str(low) if low == high else f"{low!s} to {high!s}"), ("seed", str(document.get("seed", DASH))),
    ]  # fmt: skip
    told += [("accepted share", share_words(float(document["acceptance"])))]
    return [*given, *told, ("confidence", share_words(float(document["confidence"])))]


def made(document: Mapping[str, Any]) -> str:
    """Where the page comes from."""
    versions = document.get("versions", {})
    return (
        f"Window “{document.get('name', '')}”, configuration {document.get('configuration', DASH)}, seed "
        f"{document.get('seed', DASH)}, code {versions.get('code', DASH)}, made by ssmash_gym "
        f"{versions.get('ssmash_gym', DASH)}; page written by ssmash_gym {__version__}."
    )


def told_limits(document: Mapping[str, Any]) -> list[str]:
    """Every limit in one phrase."""
    return [limit_words(name, one) for name, one in document.get("limits", {}).items()]
