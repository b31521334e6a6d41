"""Figures of a study as SVG (extra ``plot``): each takes plain numbers by policy and gives the file's text."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.errors import require
from ssmash_gym.evaluation.page_style import Style
from ssmash_gym.evaluation.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Looks = Mapping[str, Style]

SIZE_IN: Final = (5.4, 4.1)  # narrow, so that the words can be read on a telephone
LEVEL: Final = 0.95
LIMIT: Final[dict[str, Any]] = {"color": "0.35", "linewidth": 1.0, "linestyle": (0, (1, 2))}
APART: Final = 0.085  # between the marks of two policies at one place, as a share of the distance of places
COMPASS: Final = ("head", "45°", "  starboard\n  beam", "135°", "following", "225°", "port  \nbeam  ", "315°")
SETTINGS: Final[Any] = {
    "font.size": 9.0, "axes.labelsize": 9.0, "legend.fontsize": 8.0, "svg.hashsalt": "ssmash_gym",
    "svg.fonttype": "path", "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "0.88", "grid.linewidth": 0.7, "axes.axisbelow": True, "axes.edgecolor": "0.35",
    "xtick.color": "0.25", "ytick.color": "0.25",
}  # fmt: skip


@dataclass(frozen=True)
class Speed:
    """One point of the curve of load against time: the trapezoid at one speed.

    Attributes:
        label: The speed, as it is written beside the point.
        time_s: Median time of the successes.
        load_kN: 95th percentile of the peak probe loads.
    """

    label: str
    time_s: float
    load_kN: float


def require_matplotlib() -> None:
    """Check that figures can be drawn.

    Raises:
        ImportError: Matplotlib is missing; the sentence names the extra.
    """
    require("matplotlib", 'figures need Matplotlib: pip install "ssmash_gym[plot]".')


def drawn(draw: Callable[[Figure], None], size_in: tuple[float, float] = SIZE_IN) -> str:
    """SVG of what `draw` puts into a figure [in]; the same numbers give the same text."""
    require_matplotlib()
    from matplotlib import rc_context
    from matplotlib.figure import Figure as Sheet

    with rc_context(SETTINGS):
        figure = Sheet(figsize=size_in, layout="constrained")
        draw(figure)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


def _legend(figure: Figure, axes: Axes, *, columns: int = 3) -> None:
    """Names of the policies below the axes."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(columns, len(labels)), frameon=False, handlelength=2.9,
        columnspacing=1.4,
    )  # fmt: skip


def distribution(loads: Mapping[str, Array], looks: Looks, limit_kN: float) -> str:
    """Share of episodes whose peak load lies below a value, a line a policy.

    Args:
        loads: Peak probe loads by policy [kN], (episodes,).
        looks: Styles by policy.
        limit_kN: Cost limit, drawn as a line.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for name, values in loads.items():
            style, ordered = looks[name], np.sort(values)
            shares = np.arange(1, ordered.size + 1) / ordered.size
            axes.step(
                np.concatenate([[0.0], ordered]), np.concatenate([[0.0], shares]), where="post", color=style.colour,
                linestyle=style.dash, linewidth=style.width, label=name,
            )  # fmt: skip
            axes.plot(np.percentile(values, 100 * LEVEL), LEVEL, style.marker, color=style.colour, markersize=6.5)
        axes.axvline(limit_kN, **LIMIT)
        axes.axhline(LEVEL, **LIMIT)
        right = max(float(np.max(values)) for values in loads.values())
        axes.text(limit_kN, 0.02, " limit", color="0.3", fontsize=8)
        axes.text(right, LEVEL - 0.015, "95 %", color="0.3", fontsize=8, va="top", ha="right")
        axes.set(xlabel="peak probe load [kN]", ylabel="share of episodes below", xlim=(0.0, None), ylim=(0.0, 1.01))
        _legend(figure, axes)

    return drawn(draw)


def points(
    places: Sequence[str],
    values: Mapping[str, Sequence[Estimate | None]],
    looks: Looks,
    labels: tuple[str, str],
    *,
    joined: bool = True,
    limit: float | None = None,
    top: float | None = None,
) -> str:
    """Values with intervals at a few places (sea states, delays, bands), a marker a policy.

    Args:
        places: Names along the axis.
        values: One estimate a place by policy; None where there is none.
        looks: Styles by policy.
        labels: Of both axes.
        joined: Join a policy's marks by a line.
        limit: Drawn as a horizontal line.
        top: Upper end of the vertical axis.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for k, (name, row) in enumerate(values.items()):
            style = looks[name]
            shift = APART * (k - 0.5 * (len(values) - 1))
            given = [(i + shift, found) for i, found in enumerate(row) if found is not None]
            if not given:
                continue
            middle, spread = _spread([found for _, found in given])
            axes.errorbar(
                [at for at, _ in given], middle, yerr=spread, fmt=style.marker, color=style.colour, markersize=5.0,
                elinewidth=1.1, linewidth=0.9 * style.width if joined else 0.0, linestyle=style.dash, capsize=2.0,
                label=name, zorder=9 - k,
            )  # fmt: skip
        if limit is not None:
            axes.axhline(limit, **LIMIT)
        axes.set_xticks(range(len(places)), places)
        axes.set(xlabel=labels[0], ylabel=labels[1], xlim=(-0.6, len(places) - 0.4), ylim=(0.0, top))
        axes.grid(axis="x", visible=False)
        _legend(figure, axes)

    return drawn(draw)


def load_against_time(
    found: Mapping[str, tuple[float, Estimate]], speeds: Sequence[Speed], looks: Looks, limit_s: float | None
) -> str:
    """P95 of the peak load over the median time, a mark a policy; the trapezoid at several speeds as a curve.

    Args:
        found: Median time [s] and P95 with its interval [kN] by policy.
        speeds: The trapezoid, from fast to slow.
        looks: Styles by policy.
        limit_s: Allowed time, drawn as a line.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        if len(speeds) > 1:
            axes.plot(
                [one.time_s for one in speeds], [one.load_kN for one in speeds], "-", color="0.55", linewidth=1.3,
                marker=".", label="trapezoid, other speeds",
            )  # fmt: skip
            for one in speeds:
                axes.annotate(
                    one.label, (one.time_s, one.load_kN), xytext=(4, 5), textcoords="offset points", fontsize=7.5,
                    color="0.35",
                )  # fmt: skip
        for name, (time_s, load) in found.items():
            style = looks[name]
            middle, spread = _spread([load])
            axes.errorbar(
                [time_s], middle, yerr=spread, fmt=style.marker, color=style.colour, markersize=7.0, capsize=2.5,
                elinewidth=1.1, label=name,
            )  # fmt: skip
        if limit_s is not None:
            axes.axvline(limit_s, **LIMIT)
            axes.text(limit_s, 0.0, " allowed", color="0.3", fontsize=8, va="bottom")
        axes.set(xlabel="median time of the successes [s]", ylabel="peak probe load, P95 [kN]", ylim=(0.0, None))
        axes.margins(x=0.12, y=0.12)
        _legend(figure, axes, columns=2)

    return drawn(draw)


def by_heading(centres_deg: Array, values: Mapping[str, Array], looks: Looks, limit_kN: float) -> str:
    """Mean peak load by where the waves come from, as a polar chart: ahead at the top, starboard at the right.

    Args:
        centres_deg: Middles of the sectors [deg], (k,): 0 ahead, clockwise.
        values: One mean a sector by policy [kN], (k,); not a number where there is no episode.
        looks: Styles by policy.
        limit_kN: Cost limit, drawn as a circle.
    """

    def draw(figure: Figure) -> None:
        axes: Any = figure.add_subplot(projection="polar")
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(-1)
        around = np.radians(np.append(centres_deg, centres_deg[0]))
        for name, row in values.items():
            style = looks[name]
            axes.plot(
                around, np.append(row, row[0]), color=style.colour, linestyle=style.dash, linewidth=style.width,
                marker=style.marker, markersize=4.0, label=name,
            )  # fmt: skip
        axes.plot(np.linspace(0.0, 2.0 * np.pi, 181), np.full(181, limit_kN), **LIMIT)
        axes.set_thetagrids(range(0, 360, 45), COMPASS)
        axes.set_rlabel_position(22.5)
        axes.set_ylim(0.0, None)
        axes.tick_params(axis="y", labelsize=7.5)
        axes.tick_params(axis="x", pad=7.0)
        _legend(figure, axes)

    return drawn(draw, (5.4, 5.2))


def dots(
    rows: Sequence[str],
    loads: Mapping[str, Sequence[Estimate | None]],
    successes: Mapping[str, Sequence[Estimate | None]],
    looks: Looks,
    limit_kN: float,
) -> str:
    """One row a condition: P95 of the peak load at the left, success at the right, a mark a policy.

    Args:
        rows: Names of the conditions, from the top.
        loads: P95 a condition by policy [kN]; None where there is none.
        successes: Share of successes a condition by policy, 0 to 1.
        looks: Styles by policy.
        limit_kN: Cost limit, drawn as a line.
    """

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        for k, name in enumerate(loads):
            shift = 0.1 * (k - 0.5 * (len(loads) - 1))
            _across(left, loads[name], looks[name], shift, 1.0, name)
            _across(right, successes.get(name, ()), looks[name], shift, 100.0, name)
        left.axvline(limit_kN, **LIMIT)
        left.set(xlabel="peak probe load, P95 [kN]", xlim=(0.0, None), ylim=(len(rows) - 0.5, -0.5))
        left.set_yticks(range(len(rows)), rows)
        right.set(xlabel="success [%]", xlim=(None, 101.0))
        right.tick_params(left=False)
        for axes in (left, right):
            axes.grid(axis="y", visible=False)
            for i in range(1, len(rows), 2):
                axes.axhspan(i - 0.5, i + 0.5, color="0.955", zorder=0)
        _legend(figure, left)

    return drawn(draw, (7.2, 1.5 + 0.34 * len(rows) + 0.03 * len(rows) * len(loads)))


def _across(axes: Axes, row: Sequence[Estimate | None], style: Style, shift: float, factor: float, name: str) -> None:
    """A policy's marks with their intervals, one a row."""
    given = [(i + shift, found) for i, found in enumerate(row) if found is not None]
    if not given:
        return
    middle, spread = _spread([found for _, found in given])
    axes.errorbar(
        factor * middle, [at for at, _ in given], xerr=factor * spread, fmt=style.marker, color=style.colour,
        markersize=4.5, elinewidth=1.0, linewidth=0.0, label=name,
    )  # fmt: skip


def _spread(found: Sequence[Estimate]) -> tuple[Array, Array]:
    """Values (k,), and how far their intervals reach below and above them (2, k)."""
    middle = np.array([one.value for one in found])
    low, high = np.array([one.low for one in found]), np.array([one.high for one in found])
    return middle, np.maximum(np.stack([middle - low, high - middle]), 0.0)


def pairs(ours: Array, theirs: Array, names: tuple[str, str], looks: Looks) -> str:
    """Peak loads of two policies in the same seas, a dot a sea; below the diagonal the first one's is lower.

    Args:
        ours: Of the first, (seas,) [kN].
        theirs: Of the other, in the same seas.
        names: Of both.
        looks: Styles by policy.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        top = 1.04 * max(float(np.max(ours)), float(np.max(theirs)))
        style = looks[names[0]]
        axes.fill_between([0.0, top], [0.0, top], 0.0, color="0.955", linewidth=0, zorder=0)
        axes.plot([0.0, top], [0.0, top], color="0.35", linewidth=1.0)
        axes.plot(theirs, ours, "o", color=style.colour, markersize=3.2, alpha=0.55, markeredgewidth=0.0)
        axes.text(0.97, 0.05, f"{names[0]} lower in {100 * np.mean(ours < theirs):.0f} %", transform=axes.transAxes,
                  ha="right", fontsize=8.5, color="0.2")  # fmt: skip
        axes.set(xlim=(0.0, top), ylim=(0.0, top), aspect="equal")
        axes.set(xlabel=f"{names[1]}: peak probe load [kN]", ylabel=f"{names[0]}: peak probe load [kN]")

    return drawn(draw, (4.6, 4.4))


def differences(values: Array, names: tuple[str, str], looks: Looks) -> str:
    """Differences of the peak loads in the same sea, in order of size; below zero the first policy's is lower.

    Args:
        values: First less other, (seas,) [kN].
        names: Of both.
        looks: Styles by policy.
    """

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        ordered = np.sort(values)
        share = 100.0 * (np.arange(ordered.size) + 0.5) / ordered.size
        mine, other = looks[names[0]], looks[names[1]]
        axes.fill_between(share, np.minimum(ordered, 0.0), 0.0, step="mid", color=mine.colour, alpha=0.75, linewidth=0)
        axes.fill_between(
            share, np.maximum(ordered, 0.0), 0.0, step="mid", facecolor="none", edgecolor=other.colour, hatch="////",
            linewidth=0.6,
        )  # fmt: skip
        axes.axhline(0.0, color="0.25", linewidth=1.0)
        middle = float(np.median(ordered))
        words = f"median {middle:+.1f} kN".replace("-", "−")
        axes.axhline(middle, **LIMIT)
        axes.text(99.0, middle, words, ha="right", va="bottom", fontsize=8.5, color="0.2")
        axes.set(xlabel="seas, in order of the difference [%]", xlim=(0.0, 100.0))
        axes.set(ylabel=f"peak load, {names[0]} less {names[1]} [kN]")

    return drawn(draw)


def learning(curves: Mapping[str, tuple[Array, Array, Array]], success_at: float = LEVEL) -> str:
    """Peak load and success over the steps of training, a line a training.

    Args:
        curves: Steps, mean peak load [kN] and share of successes of the training episodes, by name.
        success_at: Share of successes that is asked for, drawn as a line.
    """

    def draw(figure: Figure) -> None:
        above, below = figure.subplots(2, 1, sharex=True)
        greys = np.linspace(0.0, 0.6, len(curves))
        dashes = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)), (0, (1, 1.2)))
        for k, (name, (steps, load, success)) in enumerate(curves.items()):
            look = {"color": f"{greys[k]:.2f}", "linestyle": dashes[k % len(dashes)], "linewidth": 1.3}
            above.plot(1e-6 * steps, load, label=name, **look)
            below.plot(1e-6 * steps, 100.0 * success, **look)
        below.axhline(100.0 * success_at, **LIMIT)
        above.set(ylabel="peak load, mean [kN]", ylim=(0.0, None))
        below.set(ylabel="success [%]", xlabel="control intervals of training [million]", ylim=(0.0, 101.0))
        _legend(figure, above)

    return drawn(draw)
