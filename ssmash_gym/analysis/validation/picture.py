"""The drawing of figures of section 3.2: the thesis' quantities on the thesis' axes (extra ``plot``)."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.analysis.validation.figures import Curve, Figure, Panel
from ssmash_gym.analysis.validation.measures import curve
from ssmash_gym.errors import require
from ssmash_gym.png import save_png

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Sheet

    from ssmash_gym.cases import History

Array = NDArray[np.float64]
NEEDS_MATPLOTLIB: Final = 'The figures need Matplotlib: pip install "ssmash_gym[plot]".'
# One colour for each run and, lighter, for the second curve of a panel; the first run is drawn solid.
COLOURS: Final = ("#12344d", "#d9772b", "#2a8a6d", "#8a4f9e", "#b03a48", "#6b7a1f", "#4f6d8f")
SECOND: Final = ("#4aa3c7", "#efb679", "#86c9b0", "#c3a0cf", "#dd8d97", "#b6c26b", "#a3b7cb")
DASHES: Final = ("-", (0, (5, 2)), (0, (5, 1, 1, 1)), (0, (2, 1)), (0, (8, 2)), (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
QUIET: Final = "0.45"  # grey of what is not data
WIDTH_IN: Final = 11.5
NARROW_IN: Final = 7.0  # a sheet of one column
PANEL_IN: Final = 1.42  # height of a panel in the fuller column
BETWEEN_FIGURES_IN: Final = 0.56
BETWEEN_PANELS_IN: Final = 0.15
LEFT_IN: Final = 0.62  # from the left of a column to its axes: marks and label
RIGHT_IN: Final = 0.12
HEAD_IN: Final = 0.60
FOOT_IN: Final = 0.52
LINE_IN: Final = 0.145  # of the foot's text
DPI: Final = 110
PALETTE: Final = 96  # colours of the file
CHARACTERS_PER_IN: Final = 17.0  # of the foot's text


def draw_sheet(
    path: Path,
    figures: Sequence[Figure],
    runs: Mapping[str, History],
    words: tuple[str, str],
    metadata: Mapping[str, str],
) -> None:
    """Write figures on one sheet, see `sheet_of`, as PNG.

    Args:
        path: PNG to write.
        figures: The figures.
        runs: Histories by the label of their curves.
        words: Title, and what the foot says.
        metadata: Text that goes into the file.

    Raises:
        ImportError: Matplotlib is missing.
    """
    save_png(sheet_of(figures, runs, words), path, metadata, dpi=DPI, colours=PALETTE)


def sheet_of(figures: Sequence[Figure], runs: Mapping[str, History], words: tuple[str, str]) -> Sheet:
    """Draw figures on one sheet, in one or two columns.

    Args:
        figures: The figures.
        runs: Histories by the label of their curves; the first one is drawn solid.
        words: Title, and what the foot says.

    Raises:
        ImportError: Matplotlib is missing.
    """
    require("matplotlib", NEEDS_MATPLOTLIB)
    from matplotlib.figure import Figure as Sheet

    columns = two_columns(figures)
    width = WIDTH_IN if len(columns) > 1 else NARROW_IN
    foot = textwrap.wrap(words[1], round(CHARACTERS_PER_IN * width))
    body = max(_gaps(column) + PANEL_IN * max(_panels(column), 2) for column in columns)
    head = HEAD_IN + (0.25 if len(runs) > 1 else 0.0)
    height = head + body + FOOT_IN + LINE_IN * len(foot)
    sheet = Sheet(figsize=(width, height))
    for k, column in enumerate(columns):
        left = LEFT_IN + k * width / len(columns)
        across = width / len(columns) - LEFT_IN - RIGHT_IN
        _column(sheet, column, (left, height - head, across, body), runs)
    sheet.text(0.12 / width, 1.0 - 0.1 / height, words[0], fontsize=12, fontweight="bold", color=COLOURS[0], va="top")
    if len(runs) > 1:
        _legend_of_runs(sheet, list(runs), (0.12 / width, 1.0 - 0.33 / height))
    sheet.text(0.12 / width, 0.1 / height, "\n".join(foot), fontsize=7.5, color=QUIET, va="bottom", linespacing=1.35)
    return sheet


def two_columns(figures: Sequence[Figure]) -> list[list[Figure]]:
    """Figures in two columns, each put where there are fewer panels; a single figure in one."""
    if len(figures) == 1:
        return [list(figures)]
    columns: list[list[Figure]] = [[], []]
    for figure in figures:
        columns[int(_panels(columns[0]) > _panels(columns[1]))].append(figure)
    return columns


# --- one column -------------------------------------------------------------------------------------------------


def _panels(figures: Sequence[Figure]) -> int:
    return sum(len(figure.panels) for figure in figures)


def _gaps(figures: Sequence[Figure]) -> float:
    """Height of a column that is not panels [in]."""
    return BETWEEN_FIGURES_IN * (len(figures) - 1) + BETWEEN_PANELS_IN * (_panels(figures) - len(figures))


def _column(
    sheet: Sheet, figures: Sequence[Figure], box: tuple[float, float, float, float], runs: Mapping[str, History]
) -> None:
    """Figures above each other; the panels of a figure share their time axis.

    Args:
        sheet: The sheet.
        figures: Figures of the column.
        box: Left, top, width and height on the sheet [in].
        runs: Histories by the label of their curves.
    """
    left, top, across, body = box
    width, height = sheet.get_size_inches()
    tall = (body - _gaps(figures)) / _panels(figures)
    for figure in figures:
        first = top
        for k, panel in enumerate(figure.panels):
            top -= tall
            axes = sheet.add_axes((left / width, top / height, across / width, tall / height))
            _panel(axes, figure, panel, runs)
            last = k == len(figure.panels) - 1
            axes.tick_params(labelbottom=last)
            if k == 0:
                axes.set_title(f"Figure {figure.number}: {figure.title}", loc="left", fontsize=9, color="0.15", pad=4)
            if last:
                axes.set_xlabel("time [s]", fontsize=8.5, labelpad=1)
            top -= BETWEEN_FIGURES_IN if last else BETWEEN_PANELS_IN
        middle = 0.5 * (first + top + BETWEEN_FIGURES_IN)
        sheet.text((left - LEFT_IN + 0.1) / width, middle / height, figure.panels[0].label, fontsize=8.5, rotation=90,
                   ha="left", va="center")  # fmt: skip


def _panel(axes: Axes, figure: Figure, panel: Panel, runs: Mapping[str, History]) -> None:
    """One pair of axes with the curves of all runs."""
    left: list[str] = []
    for k, history in enumerate(runs.values()):
        for one, colour in zip(panel.curves, (COLOURS[k % len(COLOURS)], SECOND[k % len(SECOND)]), strict=False):
            values = curve(history, one.quantity)
            label = one.label if k == 0 else None
            axes.plot(history.time_s, values, color=colour, linestyle=DASHES[k % len(DASHES)], linewidth=1.25,
                      label=label or None, zorder=3.0 - 0.1 * k)  # fmt: skip
            left += _beyond(panel, one, values, history.time_s, figure.seconds) if k == 0 else []
    axes.set_xlim(*figure.seconds)
    axes.set_ylim(*panel.limits)
    axes.set_xticks(_marks(figure.seconds, figure.seconds_step))
    axes.set_yticks(_marks(panel.limits, panel.step))
    if panel.title:
        _word(axes, panel.title, (0.99, 0.94), "right", "0.25")
    if left:
        at = 0.82 if _ends_low(panel, next(iter(runs.values()))) else 0.05
        _word(axes, "beyond the printed axis: " + ", ".join(left), (0.99, at), "right", "#b03a48")
    if any(one.label for one in panel.curves):
        axes.legend(loc="upper left", fontsize=7.5, frameon=False, ncols=len(panel.curves), handlelength=1.6,
                    borderaxespad=0.1)  # fmt: skip
    _plain(axes)


def _beyond(panel: Panel, one: Curve, values: Array, time: Array, seconds: tuple[float, float]) -> list[str]:
    """The range of a curve that leaves the printed limits, in words."""
    shown = values[(time >= seconds[0]) & (time <= seconds[1])]
    low, high = float(np.min(shown)), float(np.max(shown))
    if panel.holds(low) and panel.holds(high):
        return []
    form = f"z.{panel.digits}f"
    return [f"{one.label + ' ' if one.label else ''}{low:{form}} to {high:{form}}"]


def _ends_low(panel: Panel, history: History) -> bool:
    """Whether the first curve spends the second half of its time in the lower half of the panel."""
    values = curve(history, panel.curves[0].quantity)
    return bool(np.mean(values[values.size // 2 :]) < 0.5 * sum(panel.limits))


def _marks(limits: tuple[float, float], step: float) -> Array:
    """Marks of an axis from its lower limit on."""
    return np.asarray(limits[0] + step * np.arange(round((limits[1] - limits[0]) / step) + 1))


def _word(axes: Axes, text: str, at: tuple[float, float], side: str, colour: str) -> None:
    place: dict[str, Any] = {"transform": axes.transAxes, "ha": side, "va": "top" if at[1] > 0.5 else "bottom"}
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    axes.text(*at, text, fontsize=7.5, color=colour, bbox=ground, zorder=5.0, **place)


def _legend_of_runs(sheet: Sheet, labels: Sequence[str], at: tuple[float, float]) -> None:
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=COLOURS[k % len(COLOURS)], linestyle=DASHES[k % len(DASHES)], linewidth=1.5)
        for k in range(len(labels))
    ]
    sheet.legend(lines, labels, loc="upper left", bbox_to_anchor=at, ncols=len(labels), fontsize=8, frameon=False,
                 borderaxespad=0.0, handlelength=2.6, columnspacing=1.4)  # fmt: skip


def _plain(axes: Axes) -> None:
    """A thin frame as printed, a light grid, small figures."""
    for spine in axes.spines.values():
        spine.set_color("0.75")
        spine.set_linewidth(0.7)
    axes.tick_params(labelsize=7.5, color="0.75", length=2.5, pad=2)
    axes.grid(alpha=0.25, linewidth=0.6)
