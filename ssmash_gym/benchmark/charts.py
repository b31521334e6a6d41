"""Figures of a benchmark as SVG (extra ``plot``): each takes plain numbers by driver and gives the file's text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.evaluation.charts import LIMIT, drawn
from ssmash_gym.evaluation.page_style import Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Looks = Mapping[str, Style]
Estimated = Mapping[str, Any]  # a figure of ``benchmark.json``: value and ci
BAND_ALPHA: Final = 0.16


@dataclass(frozen=True)
class Attempt:
    """One trial of a learning curve.

    Attributes:
        trial: Its place, from 1.
        peak_kN: Peak load.
        baseline_kN: That of the baseline in the same sea.
        scored: Whether it was scored, and no practice.
        success: Whether it succeeded.
    """

    trial: int
    peak_kN: float
    baseline_kN: float
    scored: bool
    success: bool


def _legend(figure: Figure, axes: Axes, columns: int = 2) -> None:
    """Names below the axes."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(columns, len(labels)), frameon=False,
                  handlelength=2.9, columnspacing=1.4)  # fmt: skip


def peak_against_time(found: Mapping[str, tuple[Array, Array]], looks: Looks, limit_kN: float, horizon_s: float) -> str:
    """Peak load over duration, a small mark an episode and a large one for the medians.

    Args:
        found: Durations [s] and peak loads [kN] of the episodes by driver, (episodes,) each.
        looks: Styles by driver.
        limit_kN: Cost limit, drawn as a line.
        horizon_s: Time limit, drawn as a line where somebody comes near it.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for k, (name, (time_s, peak_kN)) in enumerate(found.items()):
            style = looks[name]
            axes.plot(time_s, peak_kN, style.marker, color=style.colour, markersize=3.4, alpha=0.4, markeredgewidth=0.0)
            axes.plot(
                np.median(time_s), np.median(peak_kN), style.marker, color=style.colour, markersize=10.0,
                markeredgecolor="white", markeredgewidth=1.2, label=name, zorder=20 - k,
            )  # fmt: skip
        axes.axhline(limit_kN, **LIMIT)
        if any(np.max(time_s) > 0.9 * horizon_s for time_s, _ in found.values()):
            axes.axvline(horizon_s, **LIMIT)
            axes.text(horizon_s, 0.0, "time limit ", color="0.3", fontsize=8, va="bottom", ha="right")
        axes.set(xlabel="duration of the episode [s]", ylabel="peak probe load [kN]", ylim=(0.0, None))
        axes.margins(x=0.06)
        _legend(figure, axes)

    return drawn(draw)


def over_delay(
    programs: Mapping[str, Sequence[tuple[float, Estimated]]],
    recorded: Mapping[str, Estimated],
    looks: Looks,
    label: str,
    limit: float | None,
) -> str:
    """A figure of each program over its added delay, and of those at the claw as level bands.

    Args:
        programs: Delay [ms] and figure, by program.
        recorded: Figures of participants and scripted drivers, who have delays of their own.
        looks: Styles by name.
        label: Of the vertical axis.
        limit: Drawn as a horizontal line.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        right = max((delay for row in programs.values() for delay, _ in row), default=0.0)
        for name, one in recorded.items():
            style = looks[name]
            low, high = one["ci"] or (one["value"], one["value"])
            axes.axhspan(low, high, color=style.colour, alpha=BAND_ALPHA, linewidth=0)
            axes.axhline(one["value"], color=style.colour, linewidth=1.8, linestyle=style.dash, label=name)
        for k, (name, row) in enumerate(programs.items()):
            style = looks[name]
            shift = 0.006 * max(right, 1.0) * (k - 0.5 * (len(programs) - 1))
            middle, spread = _spread([one for _, one in row])
            axes.errorbar(
                [delay + shift for delay, _ in row], middle, yerr=spread, fmt=style.marker, color=style.colour,
                linestyle=style.dash, linewidth=0.9 * style.width, markersize=5.0, elinewidth=1.1, capsize=2.0,
                label=name,
            )  # fmt: skip
        if limit is not None:
            axes.axhline(limit, **LIMIT)
        axes.set_xticks(sorted({delay for row in programs.values() for delay, _ in row}))
        axes.set(xlabel="added delay of the program's commands [ms]", ylabel=label, ylim=(0.0, None))
        _legend(figure, axes)

    return drawn(draw)


def forest(rows: Sequence[tuple[str, Estimated]], looks: Sequence[Style], label: str, middle: float) -> str:
    """Figures with intervals one below the other, with a line at what means no difference.

    Args:
        rows: Name and figure, from the top.
        looks: Style of each row.
        label: Of the axis.
        middle: No difference.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for k, ((_, one), style) in enumerate(zip(rows, looks, strict=True)):
            value, spread = _spread([one])
            axes.errorbar(value, [k], xerr=spread, fmt=style.marker, color=style.colour, markersize=5.5,
                          elinewidth=1.4, capsize=2.5)  # fmt: skip
            if k % 2:
                axes.axhspan(k - 0.5, k + 0.5, color="0.955", zorder=0)
        axes.axvline(middle, color="0.25", linewidth=1.0)
        axes.set_yticks(range(len(rows)), [name for name, _ in rows])
        axes.set(xlabel=label, ylim=(len(rows) - 0.5, -0.5))
        axes.grid(axis="y", visible=False)
        axes.margins(x=0.08)

    return drawn(draw, (5.4, 1.1 + 0.27 * len(rows)))


def learning(curves: Mapping[str, Sequence[Attempt]], looks: Looks, baseline: str, limit_kN: float) -> str:
    """Peak load of each trial in the order driven, by itself and less the baseline's in the same sea.

    Practice is hollow, no success is crossed out.

    Args:
        curves: Trials by driver.
        looks: Styles by driver.
        baseline: Name of the baseline.
        limit_kN: Cost limit, drawn as a line.
    """

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2)
        for name, trials in curves.items():
            _attempts(left, name, trials, [one.peak_kN for one in trials], looks[name])
            _attempts(right, name, trials, [one.peak_kN - one.baseline_kN for one in trials], looks[name])
        left.axhline(limit_kN, **LIMIT)
        right.axhline(0.0, color="0.25", linewidth=1.0)
        left.set(xlabel="trial, in the order driven", ylabel="peak probe load [kN]", ylim=(0.0, None))
        right.set(xlabel="trial, in the order driven", ylabel=f"peak load less that of {baseline} [kN]")
        for axes in (left, right):
            axes.locator_params(axis="x", integer=True)
        _legend(figure, left, 4)

    return drawn(draw, (9.0, 4.0))


def _attempts(axes: Axes, name: str, trials: Sequence[Attempt], values: Sequence[float], style: Style) -> None:
    """One driver's trials as a line with marks."""
    places = [one.trial for one in trials]
    axes.plot(places, values, color=style.colour, linewidth=0.8, linestyle=style.dash, alpha=0.7)
    for scored in (False, True):
        own = [k for k, one in enumerate(trials) if one.scored == scored]
        axes.plot(
            [places[k] for k in own], [values[k] for k in own], style.marker, color=style.colour, markersize=5.5,
            fillstyle="full" if scored else "none", markeredgewidth=1.3, linestyle="none",
            label=f"{name}, {'scored' if scored else 'practice'}" if own else None,
        )  # fmt: skip
    lost = [k for k, one in enumerate(trials) if not one.success]
    axes.plot([places[k] for k in lost], [values[k] for k in lost], "x", color="#000000", markersize=9.0,
              linestyle="none", label=f"{name}, no success" if lost else None)  # fmt: skip


def _spread(found: Sequence[Estimated]) -> tuple[Array, Array]:
    """Values (k,), and how far their intervals reach below and above them (2, k)."""
    middle = np.array([one["value"] for one in found])
    bounds = np.array([one["ci"] or (one["value"], one["value"]) for one in found])
    return middle, np.maximum(np.stack([middle - bounds[:, 0], bounds[:, 1] - middle]), 0.0)
