"""The whole figure of a window: heading, panels of each policy in lines, legend, and where the numbers come from."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from ssmash_gym.evaluation.charts import drawn, require_matplotlib
from ssmash_gym.windows.chart_layout import Layout, Place, Row
from ssmash_gym.windows.chart_looks import Paint
from ssmash_gym.windows.chart_panels import Drawing, draw_panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_IN: Final = 11.4  # that a line of several panels fills
NARROWEST_IN: Final = 8.4
MARGIN_IN: Final = 0.15
PANEL_IN: Final = (1.5, 3.1)  # least and greatest side
TEXT_PT: Final = 8.0
LINE_IN: Final = 0.165  # of the text
CHARACTER_IN: Final = 0.061  # of the text, on the wide side
SWATCH_IN: Final = (0.3, 0.13)
ABOVE_IN: Final = 0.62  # heading
NAME_IN: Final = 0.28  # of a policy, above its panels
TITLE_IN: Final = 0.24  # of a panel


@dataclass(frozen=True)
class Block:
    """Panels of one policy.

    Attributes:
        title: Above them.
        rows: Cells by place.
        key: Beginning of their identifiers in the figure.
    """

    title: str
    rows: Mapping[Place, Row]
    key: str


@dataclass(frozen=True)
class Entry:
    """Entry of a legend: words behind a swatch; a string as look is Matplotlib's marker, or ``edge``, ``beyond``."""

    words: str
    look: Paint | str | None


@dataclass(frozen=True)
class Scale:
    """Colour bar: colour map, ends, label, and where a bold line stands, if anywhere; `hatched` above zero."""

    colours: str
    ends: tuple[float, float]
    label: str
    line: float | None = None
    hatched: bool = False


@dataclass(frozen=True)
class Words:
    """Heading, the line below it, and the footer of a figure."""

    heading: str
    below: str
    footer: str


@dataclass(frozen=True)
class Sizes:
    """Sizes of a figure [in]: of a panel without its surroundings, and those."""

    panel: tuple[float, float]
    around: tuple[float, float, float]  # left, right, below
    width: float
    blocks: float
    legend: float
    footer: float

    @property
    def height(self) -> float:
        """Of the whole figure."""
        return ABOVE_IN + self.blocks + self.legend + self.footer + MARGIN_IN


def sheet(
    layout: Layout, blocks: Sequence[Block], how: Drawing, words: Words, legend: Sequence[Sequence[Entry]],
    scale: Scale | None = None,
) -> str:  # fmt: skip
    """Draw a figure as SVG.

    Args:
        layout: Of every policy's panels.
        blocks: Policies from the top.
        how: What the cells show.
        words: Heading and footer.
        legend: Columns of entries.
        scale: Colour bar in front of the entries.
    """
    require_matplotlib()
    from matplotlib import rc_context

    width = _panel_in(layout)[2]
    columns = _wrapped(legend, (width - 2 * MARGIN_IN) / (len(legend) + (scale is not None)))
    sizes = _sizes(layout, len(blocks), columns, words, scale)

    def draw(figure: Figure) -> None:
        figure.set_layout_engine("none")
        _heading(figure, sizes, words)
        top = sizes.height - ABOVE_IN
        for block in blocks:
            top = _block(figure, layout, block, how, sizes, top)
        _legend(figure, sizes, columns, scale)

    with rc_context({"hatch.linewidth": 0.7}):
        return _shorter(drawn(draw, (sizes.width, sizes.height)))


def _shorter(svg: str) -> str:
    """The same figure with its lines to a hundredth of a point: a page holds many."""
    return re.sub(r' d="[^"]*"', lambda found: re.sub(r"(\.\d\d)\d+", r"\1", found[0]), svg)


def _panel_in(layout: Layout) -> tuple[tuple[float, float], tuple[float, float, float], float]:
    """A panel's size, what surrounds it, and the figure's width [in]."""
    around = (0.06, 0.06, 0.06) if layout.polar else (0.6, 0.1, 0.42)
    free = (WIDTH_IN - 2 * MARGIN_IN) / layout.in_line - around[0] - around[1]
    side = min(max(free, PANEL_IN[0]), PANEL_IN[1])
    width = max(NARROWEST_IN, layout.in_line * (side + around[0] + around[1]) + 2 * MARGIN_IN)
    ratio = 1.0 if layout.polar else min(1.0, max(0.5, len(layout.along.values) / len(layout.across.values)))
    return (side, ratio * side), around, width


def _sizes(
    layout: Layout, blocks: int, columns: Sequence[Sequence[tuple[Entry, int]]], words: Words, scale: Scale | None
) -> Sizes:
    panel, around, width = _panel_in(layout)
    line = panel[1] + around[2] + TITLE_IN
    legend = max((sum(lines for _, lines in column) for column in columns), default=0)
    footer = len(_footer(words, width))
    return Sizes(
        panel, around, width, blocks * (NAME_IN + layout.lines * line),
        LINE_IN * max(legend, 3 if scale is not None else 0) + 0.25, LINE_IN * footer + 0.1,
    )  # fmt: skip


def _wrapped(legend: Sequence[Sequence[Entry]], width_in: float) -> list[list[tuple[Entry, int]]]:
    """Entries broken to a column's width, with their numbers of lines."""
    most = max(12, int((width_in - SWATCH_IN[0] - 0.3) / CHARACTER_IN))
    columns = []
    for column in legend:
        broken = [(textwrap.wrap(one.words, most) or [""], one.look) for one in column]
        columns.append([(Entry("\n".join(lines), look), len(lines)) for lines, look in broken])
    return columns


def _footer(words: Words, width_in: float) -> list[str]:
    return textwrap.wrap(words.footer, int((width_in - 2 * MARGIN_IN) / (0.9 * CHARACTER_IN)))


def _heading(figure: Figure, sizes: Sizes, words: Words) -> None:
    """Heading and footer."""
    left, high = MARGIN_IN / sizes.width, sizes.height
    plain: dict[str, Any] = {"parse_math": False, "va": "top"}
    figure.text(left, 1.0 - 0.12 / high, words.heading, fontsize=12, fontweight="bold", **plain)
    figure.text(left, 1.0 - 0.36 / high, words.below, fontsize=TEXT_PT, color="0.25", **plain)
    told = "\n".join(_footer(words, sizes.width))
    figure.text(left, 0.1 / high, told, fontsize=TEXT_PT - 1, color="0.35", va="bottom", parse_math=False)


def _block(figure: Figure, layout: Layout, block: Block, how: Drawing, sizes: Sizes, top: float) -> float:
    """Draw one policy's panels from the height `top` downwards [in]; where they end."""
    figure.text(
        MARGIN_IN / sizes.width, (top - 0.06) / sizes.height, block.title, fontsize=10, fontweight="bold", va="top",
        parse_math=False,
    )  # fmt: skip
    top -= NAME_IN
    (wide, high), (left, right, below) = sizes.panel, sizes.around
    for panel in range(len(layout.panels)):
        line, column = divmod(panel, layout.in_line)
        x = MARGIN_IN + column * (left + wide + right) + left
        y = top - line * (TITLE_IN + high + below) - TITLE_IN - high
        axes = figure.add_axes(
            (x / sizes.width, y / sizes.height, wide / sizes.width, high / sizes.height), label=f"{block.key}{panel}"
        )
        axes.set_title(layout.title(panel), fontsize=9, pad=4, parse_math=False)
        draw_panel(axes, layout, panel, block.rows, how, block.key)
    return top - layout.lines * (TITLE_IN + high + below)


def _legend(figure: Figure, sizes: Sizes, columns: Sequence[Sequence[tuple[Entry, int]]], scale: Scale | None) -> None:
    """Colour bar and entries between the panels and the footer."""
    bottom = sizes.footer + MARGIN_IN
    axes = figure.add_axes((0.0, bottom / sizes.height, 1.0, sizes.legend / sizes.height))
    axes.set(xlim=(0.0, sizes.width), ylim=(0.0, sizes.legend))
    axes.set_axis_off()
    step = (sizes.width - 2 * MARGIN_IN) / (len(columns) + (scale is not None))
    x = MARGIN_IN
    if scale is not None:
        _bar(figure, sizes, scale, step)
        x += step
    for column in columns:
        y = sizes.legend - 0.2
        for entry, lines in column:
            indent = _swatch(axes, entry.look, x, y)
            axes.text(
                x + indent, y, entry.words, fontsize=TEXT_PT, va="top", parse_math=False, linespacing=1.35,
                fontweight="normal" if entry.look is not None else "bold",
            )  # fmt: skip
            y -= LINE_IN * lines
        x += step


def _swatch(axes: Axes, look: Paint | str | None, x: float, y: float) -> float:
    """Draw the sign of an entry; how far its words stand aside."""
    from matplotlib.patches import Rectangle

    wide, high = SWATCH_IN
    if look is None:
        return 0.0
    if isinstance(look, str) and look == "edge":
        axes.plot([x, x + wide], [y - 0.065, y - 0.065], color="black", linewidth=1.8)
    elif isinstance(look, str) and look != "beyond":
        face = "black" if look == "s" else "white"
        axes.plot([x + 0.5 * wide], [y - 0.065], look, color=face, markersize=4.5, markeredgecolor="black")
    else:
        paint = look if isinstance(look, Paint) else Paint("#ffffff")
        box = Rectangle((x, y - high), wide, high, facecolor=paint.face, edgecolor=paint.ink, linewidth=0.0)
        box.set(hatch=paint.hatch or None)
        axes.add_patch(box)
        axes.add_patch(Rectangle((x, y - high), wide, high, fill=False, edgecolor="0.4", linewidth=0.5))
        for start in (0.0, 0.13) if look == "beyond" else ():
            ends = [x + start + 0.02, x + start + 0.02 + high], [y - high, y]
            axes.plot(*ends, color="black", linewidth=1.1, solid_capstyle="butt")
    return wide + 0.1


def _bar(figure: Figure, sizes: Sizes, scale: Scale, step: float) -> None:
    """Colour bar at the left of the legend."""
    import numpy as np

    low, high = scale.ends
    bottom = sizes.footer + MARGIN_IN + sizes.legend - 0.35
    axes = figure.add_axes(
        (MARGIN_IN / sizes.width, bottom / sizes.height, (step - 0.6) / sizes.width, 0.15 / sizes.height)
    )
    borders = np.linspace(low, high, 65)
    axes.pcolormesh(
        borders, [0.0, 1.0], 0.5 * (borders[:-1] + borders[1:])[None, :], cmap=scale.colours, vmin=low, vmax=high,
        edgecolors="face", linewidth=0.2,
    )  # fmt: skip
    if scale.hatched:
        axes.fill_between([0.0, high], 0.0, 1.0, facecolor="none", edgecolor="black", hatch="////", linewidth=0.0)
    if scale.line is not None:
        axes.axvline(scale.line, color="white", linewidth=3.4)
        axes.axvline(scale.line, color="black", linewidth=1.8)
    axes.set(yticks=[], xlim=scale.ends)
    axes.tick_params(labelsize=7, length=2)
    axes.set_xlabel(scale.label, fontsize=TEXT_PT, labelpad=1, parse_math=False)
