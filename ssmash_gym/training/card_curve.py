"""The picture of a training: success and peak loads of the training's own episodes over its steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.errors import require
from ssmash_gym.png import save_png

Array = NDArray[np.float64]
WINDOW: Final = 0.04  # share of the lines that a drawn mean is taken over
SHARES: Final = {"aligned_rate": ("straight at the end", "#e69f00"), "success_rate": ("success", "#0072b2")}
PEAKS: Final = {"peak_probe_kN_p95": ("95th percentile", "#d55e00"), "peak_probe_kN_mean": ("mean", "#cc79a7")}

EVOLVED: Final = {"peak_p95_kN": PEAKS["peak_probe_kN_p95"], "peak_mean_kN": PEAKS["peak_probe_kN_mean"]}


def require_matplotlib() -> None:
    """Check that pictures can be drawn.

    Raises:
        ImportError: Matplotlib is missing; the sentence names the extra.
    """
    require("matplotlib", 'the picture of the training needs Matplotlib: pip install "ssmash_gym[plot]".')


def draw_curve(
    lines: Sequence[Mapping[str, str]], path: Path, name: str, evolution: Sequence[Mapping[str, str]] = ()
) -> None:
    """Draw the curve as PNG: each line of it faint, and a mean of its neighbours; beside it the evolution, if any.

    Args:
        lines: Of ``curve.csv``.
        path: File to write.
        name: Of the agent, above the picture.
        evolution: Lines of ``evolution.csv``.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    count = 3 if evolution else 2
    figure = Figure(figsize=(4.5 * count, 3.4), layout="constrained")
    after = "; on the right the evolution, without" if evolution else ""
    figure.suptitle(f"{name}: episodes of the training itself, with exploration{after}")
    millions = column(lines, "steps") / 1e6
    places = figure.subplots(1, count)
    for axes, curves in zip(places, (SHARES, PEAKS), strict=False):
        for key, (label, colour) in curves.items():
            values = column(lines, key)
            axes.plot(millions, values, color=colour, linewidth=0.6, alpha=0.35)
            wide = 3.6 if key == "aligned_rate" else 1.6  # often the same as the successes: it shows beneath them
            axes.plot(millions, smoothed(values), color=colour, linewidth=wide, label=label)
        axes.set_xlabel("control intervals [millions]")
        axes.grid(alpha=0.3)
        axes.legend()
        axes.set_ylim(bottom=0.0)
    if evolution:
        _draw_evolution(places[2], evolution)
    first, second = places[:2]
    first.set(ylabel="share of the episodes", ylim=(-0.02, 1.02))
    second.set(ylabel="peak in-plane probe load [kN]")
    save_png(figure, path, {"Title": name}, dpi=110, colours=256)


def _draw_evolution(axes: Any, lines: Sequence[Mapping[str, str]]) -> None:
    """The best candidate of each generation; its seas change every few generations, hence the steps."""
    generations = column(lines, "generation")
    for key, (label, colour) in EVOLVED.items():
        axes.plot(generations, column(lines, key), color=colour, linewidth=1.6, label=label)
    axes.set(xlabel="generation", ylabel="peak of the best candidate [kN]")
    axes.grid(alpha=0.3)
    axes.legend()
    axes.set_ylim(bottom=0.0)


def column(lines: Sequence[Mapping[str, str]], key: str) -> Array:
    """A column of the curve, NaN where there is no number, (lines,)."""
    return np.array([float(line.get(key) or "nan") for line in lines])


def smoothed(values: Array, window: float = WINDOW) -> Array:
    """Mean of each line and its neighbours, those without a number left out, (lines,)."""
    reach = max(1, round(0.5 * window * values.size))
    present = np.isfinite(values)
    summed = np.concatenate([[0.0], np.cumsum(np.where(present, values, 0.0))])
    counted = np.concatenate([[0], np.cumsum(present)])
    low = np.maximum(np.arange(values.size) - reach, 0)
    high = np.minimum(np.arange(values.size) + reach + 1, values.size)
    found = counted[high] - counted[low]
    return np.where(found > 0, (summed[high] - summed[low]) / np.maximum(found, 1), np.nan)
