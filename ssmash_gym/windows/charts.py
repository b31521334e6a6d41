"""Figures of a safe operating window as SVG (extra ``plot``): placards, maps of the share exceeded, differences.

A cell is drawn where it stands in the sweep: with a direction and a speed, in a polar chart whose angle is where the
waves (or the wind) come from, ahead at the top and starboard at the right, and whose rings are speeds, the lowest in
the middle. Other sweeps are drawn as heat maps of their two longest axes. Every cell is one element whose identifier
ends in ``s<stage>p<policy>c<cell>``: numbers of the stage and of the policy in the document's order, and the cell's.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import polars as pl

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.charts import require_matplotlib
from ssmash_gym.files import whole_file
from ssmash_gym.windows.chart_layout import Layout, Place, Row, checked, layout_of, ordered_names
from ssmash_gym.windows.chart_looks import (
    INSIDE,
    OPEN,
    UNNAMED,
    Paint,
    limit_looks,
    limit_words,
    share_words,
    verdict_look,
)
from ssmash_gym.windows.chart_panels import Drawing
from ssmash_gym.windows.chart_sheet import Block, Entry, Scale, Words, sheet
from ssmash_gym.windows.sequential import WITHIN

SHARES: Final = "cividis_r"  # perceptually uniform, and from light to dark in grey
DIFFERENCES: Final = "PuOr"  # both ends equally dark in grey: the hatch tells them apart
SMALLEST_SPAN: Final = 0.1  # of the scale of differences
NOT_OPERATIONAL: Final = "assumed limits, not operational"


def placard(cells: pl.DataFrame, document: Mapping[str, Any], stage: str, policies: Iterable[str] | None = None) -> str:
    """Verdict of every cell of a stage, a block of panels a policy; beyond the limits by the limit exceeded most.

    Args:
        cells: One row a stage, policy and cell.
        document: Contents of ``window.json``.
        stage: Which stage.
        policies: Which policies; all that have cells where None.

    Returns:
        The file's text.

    Raises:
        ConfigurationError: A column is missing, or there are no cells of this stage and these policies.
        ImportError: Matplotlib is missing.
    """
    layout, blocks, own = _blocks(cells, document, stage, policies)
    looks = limit_looks(document.get("limits", {}))
    unnamed = any(verdict_look(row, looks) == UNNAMED for block in blocks for row in block.rows.values())
    how = Drawing(lambda row: verdict_look(row, looks), lambda row: row["verdict"] == WITHIN)
    words = _words(document, layout, own, f"{stage}: where the limits are kept")
    return sheet(layout, blocks, how, words, _verdict_legend(document, looks, unnamed=unnamed))


def probability(
    cells: pl.DataFrame, document: Mapping[str, Any], stage: str, policies: Iterable[str] | None = None
) -> str:
    """Share of episodes beyond a limit in every cell of a stage, with a line round what is accepted.

    Args:
        cells: As of `placard`.
        document: As of `placard`.
        stage: As of `placard`.
        policies: As of `placard`.

    Returns:
        The file's text.

    Raises:
        ConfigurationError: As of `placard`.
        ImportError: Matplotlib is missing.
    """
    layout, blocks, own = _blocks(cells, document, stage, policies)
    accepted = float(document["acceptance"])
    colour = _colours(SHARES, 0.0, 1.0)
    how = Drawing(lambda row: Paint(colour(row["share"])), lambda row: row["share"] <= accepted)
    legend = [[
        Entry(f"share of {share_words(accepted)}, the acceptance level", "edge"),
        Entry("outside the seaway model's validity", "beyond"), Entry("no data", Paint("#ffffff")),
    ]]  # fmt: skip
    words = _words(document, layout, own, f"{stage}: share of episodes beyond a limit")
    scale = Scale(SHARES, (0.0, 1.0), "share of episodes beyond a limit", accepted)
    return sheet(layout, blocks, how, words, legend, scale)


def difference(
    cells: pl.DataFrame, document: Mapping[str, Any], stage: str, policies: tuple[str, str] | None = None
) -> str:
    """Share of episodes beyond a limit with one policy less that with another, and where their verdicts differ.

    Args:
        cells: As of `placard`.
        document: As of `placard`.
        stage: As of `placard`.
        policies: Both; the first two that have cells where None.

    Returns:
        The file's text.

    Raises:
        ConfigurationError: As of `placard`, or there are no two policies.
        ImportError: Matplotlib is missing.
    """
    layout, blocks, own = _blocks(cells, document, stage, policies)
    if len(blocks) < 2:
        raise ConfigurationError(f"Stage {stage!r} has cells of one policy only: there is no difference to draw.")
    one, other = blocks[:2]
    rows = {place: _pair(row, other.rows[place]) for place, row in one.rows.items() if place in other.rows}
    span = max([SMALLEST_SPAN, *(abs(row["less"]) for row in rows.values())])
    colour = _colours(DIFFERENCES, -span, span)

    def paint(row: Row) -> Paint:
        return Paint(colour(row["less"]), "////" if row["less"] > 0.0 else "", "#1a1a1a")

    legend = [[
        Entry(f"within with {one.title} only", "o"), Entry(f"within with {other.title} only", "s"),
        Entry("verdicts differ otherwise (undecided, beyond)", "d"),
        Entry(f"hatched: more often beyond a limit with {one.title}", paint({"less": 0.6 * span})),
        Entry("outside the seaway model's validity", "beyond"), Entry("no data", Paint("#ffffff")),
    ]]  # fmt: skip
    block = Block(f"{one.title} less {other.title}", rows, one.key.replace("p", "d"))
    words = _words(document, layout, own, f"{stage}: two policies compared")
    scale = Scale(DIFFERENCES, (-span, span), f"share beyond a limit, {block.title}", hatched=True)
    return sheet(layout, [block], Drawing(paint, mark=lambda row: row["mark"]), words, legend, scale)


def write_csv(cells: pl.DataFrame, path: Path) -> Path:
    """Write the table of cells as CSV, a line a cell; lists, which CSV does not know, as JSON.

    Args:
        cells: The table, with any columns.
        path: File to write; it is written whole or not at all.

    Returns:
        The file.
    """
    with whole_file(path) as place:
        plain(cells).write_csv(place)
    return path


def plain(cells: pl.DataFrame) -> pl.DataFrame:
    """A table without lists: as JSON, which a CSV file can hold."""
    nested = [name for name, kind in cells.schema.items() if kind.is_nested()]
    return cells.with_columns(
        pl.Series(name, [json.dumps(value, default=str) for value in cells[name].to_list()]) for name in nested
    )


def stages_of(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[str]:
    """Stages of a table, in the document's order."""
    return ordered_names(document, "stages", cells, "stage")


def policies_of(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[str]:
    """Policies of a table, in the document's order."""
    return ordered_names(document, "policies", cells, "policy")


def _blocks(
    cells: pl.DataFrame, document: Mapping[str, Any], stage: str, policies: Iterable[str] | None
) -> tuple[Layout, list[Block], pl.DataFrame]:
    """Layout, a block a policy, and the rows they show."""
    require_matplotlib()
    checked(cells, document)
    stages, known = stages_of(cells, document), policies_of(cells, document)
    wanted = list(known if policies is None else policies)
    own = cells.filter((pl.col("stage") == stage) & pl.col("policy").is_in(wanted))
    if not own.height:
        raise ConfigurationError(f"There are no cells of stage {stage!r} with {', '.join(wanted) or 'any policy'}.")
    layout, blocks = layout_of(cells, document), []
    for name in (name for name in wanted if name in own["policy"]):
        here = own.filter((pl.col("policy") == name) & pl.col("share").is_finite())  # others have no episodes yet
        rows: dict[Place, Row] = layout.places(here.iter_rows(named=True))
        blocks.append(Block(name, rows, f"s{stages.index(stage)}p{known.index(name)}c"))
    return layout, blocks, own


def _pair(one: Row, other: Row) -> Row:
    """What a cell of the chart of differences shows."""
    mark: tuple[str, bool] | None = None
    if one["verdict"] != other["verdict"]:
        mark = ("o", False) if one["verdict"] == WITHIN else ("s", True) if other["verdict"] == WITHIN else ("d", False)
    both = one.get("valid") is not False and other.get("valid") is not False
    return {"cell": one["cell"], "less": one["share"] - other["share"], "mark": mark, "valid": both}


def _colours(name: str, low: float, high: float) -> Any:
    """Colour of a value, as ``#rrggbb``."""
    from matplotlib import colormaps
    from matplotlib.colors import Normalize, to_hex

    scale, colours = Normalize(low, high), colormaps[name]
    return lambda value: to_hex(colours(scale(value)))


def _verdict_legend(
    document: Mapping[str, Any], looks: Mapping[str, Paint], *, unnamed: bool
) -> Sequence[Sequence[Entry]]:
    """Verdicts at the left, limits at the right."""
    accepted = share_words(float(document["acceptance"]))
    sure = share_words(float(document["confidence"]))
    verdicts = [
        Entry("Verdict", None),
        Entry(f"within: beyond a limit in less than {accepted} of the episodes ({sure} confidence)", INSIDE),
        Entry(f"undecided: the interval still holds {accepted}", OPEN), Entry("end of what is within", "edge"),
        Entry("outside the seaway model's validity", "beyond"), Entry("no data", Paint("#ffffff")),
    ]  # fmt: skip
    limits = [Entry(limit_words(name, one), looks[name]) for name, one in document.get("limits", {}).items()]
    if unnamed:
        limits.append(Entry("no limit named", UNNAMED))
    half = len(limits) if len(limits) <= 4 else -(-len(limits) // 2)
    first = [Entry("Beyond, by the limit exceeded most often", None), *limits[:half]]
    return [verdicts, first, *([[Entry("", None), *limits[half:]]] if limits[half:] else [])]


def _words(document: Mapping[str, Any], layout: Layout, own: pl.DataFrame, subject: str) -> Words:
    """Heading and footer of a figure."""
    across, along = layout.across, layout.along
    if layout.polar:
        below = f"Angle: {across.label}, clockwise from the bow [°]. Rings: {along.title}, the lowest in the middle."
    else:
        below = f"Across: {across.title}." + (f" Up: {along.title}." if along.name else "")
    if layout.left_out:
        below += f" The first {len(layout.panels)} of {len(layout.panels) + layout.left_out} panels."
    return Words(f"{document.get('name', '')}, {subject}", below, provenance_line(document, own))


def provenance_line(document: Mapping[str, Any], cells: pl.DataFrame) -> str:
    """Where the numbers of a figure come from, in one line."""
    versions = document.get("versions", {})
    code = f" (code {versions['code']})" if versions.get("code") else ""
    told = [
        *(str(document[key]) for key in ("helicopter", "scenario", "task") if document.get(key)),
        f"configuration {document.get('configuration', '–')}", f"seed {document.get('seed', '–')}",
        f"ssmash_gym {versions.get('ssmash_gym', '–')}{code}",
        f"{cells.height} cells, {int(cells['episodes'].sum() or 0):,} episodes", NOT_OPERATIONAL,
    ]  # fmt: skip
    return " · ".join(told)
