"""What a person sees of an evaluation at once: tables in the terminal and two plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from rich.markup import escape
from rich.table import Table

from ssmash_gym.errors import require
from ssmash_gym.evaluation.summary import FEWEST, numbers
from ssmash_gym.evaluation.targets import HOLDS, HOLDS_NOT
from ssmash_gym.files import whole_file

COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")  # distinct to most eyes
MARKERS: Final = ("o", "s", "^", "D", "v", "P")


def table(policies: Mapping[str, Mapping[str, Any]], title: str) -> Table:
    """The comparison as a table; one row a policy.

    Args:
        policies: Their summaries by name, as in ``summary.json``.
        title: Above the table.
    """
    found = Table(
        title=title,
        caption="[...]: 95 % intervals (success: Wilson, loads: bootstrap); "
        "a failed episode counts with the ultimate load",
    )
    found.add_column("policy")
    for heading in (
        "success\n%", "aligned\n%", "failed\n%", "peak probe load\nmean kN", "peak probe load\nP95 kN",
        "main tires\nP95 kN", "lift-off\n%", "beyond cost\nlimit %", "time\nmedian s",
    ):  # fmt: skip
        found.add_column(heading, justify="right")
    for name, summary in policies.items():
        load = summary["peak_probe_kN"]
        found.add_row(
            name,
            f"{100 * summary['success_rate']:.1f} {_interval(summary['success_rate_ci'], 100.0, 0)}",
            f"{100 * summary['aligned_rate']:.1f}",
            f"{100 * summary['failure_rate']:.1f}",
            f"{load['mean']:.1f} {_interval(load['mean_ci'])}",
            f"{load['p95']:.1f} {_interval(load['p95_ci'])}",
            f"{summary['peak_main_kN']['p95']:.1f}",
            f"{100 * summary['lift_off_rate']:.1f}",
            f"{100 * summary['cost_rates']['probe_in_plane']:.1f}",
            f"{summary['time_s']['median']:.1f}",
        )
    return found


def severity_table(policies: Mapping[str, Mapping[str, Any]]) -> Table:
    """Peak probe loads by severity of the sea; one row a policy, one column a band of the lateral specific force.

    Args:
        policies: Their summaries by name, as in ``summary.json``; all of the same episodes.
    """
    first = next(iter(policies.values()))
    outside = 100 * first["outside_validity_rate"]
    found = Table(
        title="peak probe load by the deck's lateral specific force (long-run RMS): mean / P95 kN, success %",
        caption=f"{outside:.1f} % of the episodes lie outside the validity of the ship's motion; "
        f"no P95 of fewer than {FEWEST} episodes",
    )
    found.add_column("policy")
    for band in first["by_lateral_g"]:
        found.add_column(f"{_band(band)}\n{band['episodes']} episodes", justify="right")
    for name, summary in policies.items():
        cells = []
        for band in summary["by_lateral_g"]:
            load = band["peak_probe_kN"]
            highest = "-" if load["p95"] is None else f"{load['p95']:.1f}"
            cells.append(f"{load['mean']:.1f} / {highest}, {100 * band['success_rate']:.0f}")
        found.add_row(name, *cells)
    return found


def study_tables(summary: Mapping[str, Any]) -> list[Table]:
    """A study in the terminal: a table of the conditions, and one of the aims where there are any.

    Args:
        summary: Contents of the study's ``summary.json``.
    """
    names = list(dict.fromkeys(name for one in summary["conditions"].values() for name in one["policies"]))
    found = Table(
        title=f"study {summary['study']}: peak probe load P95 kN, success %",
        caption="\\[...]: 95 % interval of the P95; a failed episode counts with the ultimate load",
    )
    found.add_column("condition")
    for name in names:
        found.add_column(name, justify="right")
    for condition, one in summary["conditions"].items():
        found.add_row(condition, *(_study_cell(one["policies"].get(name)) for name in names))
    aims = summary.get("targets") or ()
    return [found, _aims(aims)] if aims else [found]


def _study_cell(figures: Mapping[str, Any] | None) -> str:
    """P95 with its interval, and success, of one policy in one condition."""
    if figures is None:
        return "-"
    load, success = figures["peak_probe_kN"]["p95"], figures["success"]["value"]
    interval = f" {_interval(load['ci'])}" if load["ci"] else ""
    return f"{load['value']:.1f}{interval}, {100 * success:.0f}"


def _aims(aims: Sequence[Mapping[str, Any]]) -> Table:
    found = Table(title="aims", show_lines=False)
    for heading in ("", "policy in condition", "aim", "figure [95 % interval]", "verdict"):
        found.add_column(escape(heading))
    for one in aims:
        style = {HOLDS: "green", HOLDS_NOT: "bold red"}.get(one["verdict"], "")
        words = (f"{one['policy']} in {one['condition']}", one["statement"], one["figure"])
        found.add_row(str(one["line"]), *map(escape, words), one["verdict"], style=style)
    return found


def _band(band: Mapping[str, Any]) -> str:
    if band["to_g"] is None:
        return f"from {band['from_g']:g} g"
    return f"{band['from_g']:g} to {band['to_g']:g} g"


def sentences(agent: str, against: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The comparison of one policy with the others, a sentence each."""
    return [
        f"{agent} against {name}: P95 of the peak probe load {100 * found['p95_ratio']:.0f} % "
        f"{_interval(found['p95_ratio_ci'], 100.0, 0)}, lower in {100 * found['lower_peak_rate']:.0f} % of the "
        f"episodes; {100 * found['on_time_rate']:.1f} % succeed within {found['allowed_time_s']:.1f} s."
        for name, found in against.items()
    ]


def _interval(bounds: list[float], factor: float = 1.0, digits: int = 1) -> str:
    return f"\\[{factor * bounds[0]:.{digits}f}, {factor * bounds[1]:.{digits}f}]"


def require_matplotlib() -> None:
    """Check that plots can be made.

    Raises:
        ImportError: Matplotlib is missing; the sentence names the extra.
    """
    require("matplotlib", 'plots need Matplotlib: pip install "ssmash_gym[plot]", or say --no-plots.')


def plot_peaks(episodes: Mapping[str, pl.DataFrame], limit_kN: float, path: Path, title: str = "") -> None:
    """Peak probe load against time (left) and the share of episodes below a peak (right), as PNG.

    Args:
        episodes: Rows of each policy, by name.
        limit_kN: Cost limit of the probe load, drawn as a line.
        path: File to write.
        title: Above both.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    figure.suptitle(title)
    scatter, shares = figure.subplots(1, 2)
    for k, (name, frame) in enumerate(episodes.items()):
        colour, marker = COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
        peak, success = numbers(frame, "scored_peak_kN"), frame["success"].to_numpy()
        time_s = numbers(frame, "time_s")
        scatter.scatter(time_s[success], peak[success], s=16, color=colour, marker=marker, alpha=0.6, label=name)
        scatter.scatter(time_s[~success], peak[~success], s=16, facecolors="none", edgecolors=colour, marker=marker)
        shares.step(np.sort(peak), np.arange(1, peak.size + 1) / peak.size, where="post", color=colour, label=name)
    scatter.axhline(limit_kN, color="0.5", linewidth=0.8, linestyle="--")
    shares.axvline(limit_kN, color="0.5", linewidth=0.8, linestyle="--")
    scatter.set(xlabel="time of the episode [s]", ylabel="peak probe load [kN]", title="filled: goal reached")
    shares.set(
        xlabel="peak probe load [kN]", ylabel="share of episodes below", ylim=(0.0, 1.0), title="dashed: cost limit"
    )
    for axes in (scatter, shares):
        axes.grid(alpha=0.3)
        axes.legend()
    with whole_file(path) as temporary:
        figure.savefig(temporary, format="png", dpi=130)
