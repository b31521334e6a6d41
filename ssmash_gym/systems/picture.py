"""Pictures of the systems: one manoeuvre through all of them, and the parts of a manoeuvre (extra ``plot``)."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ssmash_gym.cases import quantity
from ssmash_gym.png import save_png
from ssmash_gym.systems.description import FULL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ssmash_gym.systems.additive import Parts
    from ssmash_gym.systems.comparison import Comparison

NEEDS_MATPLOTLIB: Final = 'The picture of the systems needs Matplotlib: pip install "ssmash_gym[plot]".'
SHOWN: Final = ("probe_in_plane_kN", "right_load_kN", "roll_deg", "yaw_deg")
COLOURS: Final = ("#d55e00", "#0072b2", "#56b4e9", "#009e73", "#cc79a7", "#8c6d1f", "#7f7f7f")
INK: Final = "#12344d"
QUIET: Final = "0.45"  # grey of what is not data
WIDTH_IN: Final = 11.0
PANEL_IN: Final = 2.5
DPI: Final = 100
PALETTE: Final = 128
CHARACTERS: Final = 175  # that fit into the width at the size of the foot


def draw_systems(path: Path, comparison: Comparison) -> None:
    """Draw a comparison: four quantities, a curve for each system, and what the others say in words.

    The full model is drawn broad and dark, beneath the others; a scaled vehicle's dashes lie on it where it is similar.
    """
    case = comparison.case
    foot = [line for text in comparison.refusals.values() for line in textwrap.wrap(text, CHARACTERS)]
    figure, axes = _sheet(2, 0.55 + 0.17 * len(foot), 2)
    styles = _styles(list(comparison.histories))
    for k, (name, place) in enumerate(zip(SHOWN, axes.flat, strict=True)):
        for system, history in comparison.histories.items():
            if name.startswith("probe") and not history.case.vehicle.probe.active:
                continue  # no probe, no load: a line at zero would be no result
            place.plot(history.time_s, quantity(name).of(history), label=comparison.labels[system], **styles[system])
        _plain(place, f"{quantity(name).label} [{quantity(name).unit}]", k >= 2)
    handles = [axes.flat[1].get_lines()[k] for k in range(len(comparison.histories))]
    _words(figure, f"{case.name}: {case.title}" if case.title else case.name, foot, handles)
    save_png(
        figure,
        path,
        {"Title": f"case {case.name} by the systems {', '.join(comparison.histories)}"},
        dpi=DPI,
        colours=PALETTE,
    )


def draw_parts(path: Path, parts: Mapping[str, Parts]) -> None:
    """Draw the probe load of a manoeuvre, of the deck's motion alone and of the traverse alone, one panel a scale."""
    figure, axes = _sheet(len(parts), 0.55, 1)
    for k, (title, part) in enumerate(parts.items()):
        place = axes.flat[k]
        for (name, history), style in zip(part.histories.items(), _PART_STYLES, strict=True):
            place.plot(history.time_s, 1e-3 * history["probe_in_plane"], label=name, **style)
        place.set_title(title, loc="left", fontsize=9.5)
        _plain(place, "in-plane probe load [kN]", k == len(parts) - 1)
    case = next(iter(parts.values())).case
    _words(figure, f"{case.name}: what the deck and the traverse add up to", [], list(axes.flat[0].get_lines()))
    save_png(figure, path, {"Title": f"parts of case {case.name}"}, dpi=DPI, colours=PALETTE)


_PART_STYLES: Final[tuple[dict[str, Any], ...]] = (
    {"color": INK, "linewidth": 1.5, "zorder": 1.0},
    {"color": "#0072b2", "linewidth": 1.2, "zorder": 2.0},
    {"color": "#d55e00", "linewidth": 1.2, "zorder": 2.0},
)


def _styles(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Colour and width of each system's curves."""
    styles: dict[str, dict[str, Any]] = {FULL: {"color": INK, "linewidth": 3.0, "alpha": 0.35, "zorder": 1.0}}
    for k, name in enumerate(name for name in names if name != FULL):
        styles[name] = {"color": COLOURS[k % len(COLOURS)], "linewidth": 1.2, "zorder": 2.0 + 0.1 * k}
    if "feldman_scale" in styles:
        styles["feldman_scale"] |= {"linestyle": (0, (4, 3)), "color": "0.1", "linewidth": 1.0}
    return styles


def _sheet(rows: int, foot_in: float, columns: int) -> tuple[Figure, Any]:
    """A figure with room for a title and the legend above, and `foot_in` below [in]."""
    from matplotlib.figure import Figure

    head = 1.05
    height = head + foot_in + rows * PANEL_IN
    figure = Figure(figsize=(WIDTH_IN, height))
    axes = figure.subplots(
        rows, columns, sharex=True, squeeze=False,
        gridspec_kw={"left": 0.062, "right": 0.985, "bottom": foot_in / height, "top": 1.0 - head / height,
                     "wspace": 0.14, "hspace": 0.16},
    )  # fmt: skip
    return figure, axes


def _words(figure: Figure, title: str, foot: Sequence[str], handles: Sequence[Any]) -> None:
    """Title and legend above, refusals below."""
    width, height = figure.get_size_inches()
    left = 0.12 / width
    figure.text(left, 1.0 - 0.1 / height, title, fontsize=12.5, fontweight="bold", color=INK, va="top")
    figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(left - 0.006, 1.0 - 0.36 / height), ncols=3, frameon=False,
        fontsize=9, handlelength=2.2, columnspacing=1.8,
    )  # fmt: skip
    if foot:
        figure.text(left, 0.08 / height, "\n".join(foot), fontsize=8, color=QUIET, va="bottom", linespacing=1.4)


def _plain(axes: Axes, label: str, last: bool) -> None:
    """No frame but the two axes, a light grid, small figures."""
    axes.set_ylabel(label, fontsize=9)
    if last:
        axes.set_xlabel("time [s]", fontsize=9)
    axes.margins(x=0.0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(labelsize=8, color=QUIET)
    axes.grid(alpha=0.25, linewidth=0.6)
