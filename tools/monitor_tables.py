"""Tables and picture of the study of the deck monitor (`tools/monitor_study.py`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.files import whole_file


def _words(three: list[float | None], digits: int) -> str:
    value, low, high = ("-" if number is None else f"{number:.{digits}f}" for number in three)
    return f"{value} ({low} to {high})"


def row(*cells: object) -> str:
    """One line of a table in Markdown."""
    return "| " + " | ".join(map(str, cells)) + " |"


def _shares(told: dict[str, Any]) -> str:
    return f"{told['happened']:.3f} / {told['said']:.3f}"


def tables(told: dict[str, Any]) -> str:
    """The figures as Markdown."""
    lines = [
        "| Horizon [s] | exceeded / foreseen | Brier: monitor | base rate | RMS rule | rehearsed past |",
        "|---|---|---|---|---|---|",
    ]
    for h in told["horizons"]:
        briers = [h[f"brier_{name}"] for name in ("monitor", "base_rate", "rms_rule", "rehearsed_past")]
        lines.append(row(f"{h['horizon_s']:g}", _shares(h), *(_words(three, 3) for three in briers)))
    lines += [
        "",
        "| Horizon [s] | skill over base rate | over RMS rule | over rehearsed past | starts without an exceeding copy "
        "| exceeded |",
        "|---|---|---|---|---|---|",
    ]
    for h in told["horizons"]:
        skills = [h[f"skill_monitor_over_{name}"] for name in ("base_rate", "rms_rule", "rehearsed_past")]
        count, *happened = h["no_copy"]
        words = [_words(three, 2) for three in skills]
        lines.append(row(f"{h['horizon_s']:g}", *words, count, _words(happened, 3)))
    lines += [
        "",
        "| Between [s], none before | starts | exceeded / foreseen | Brier: monitor | RMS rule | skill over RMS rule |",
        "|---|---|---|---|---|---|",
    ]
    for h in told["later"]:
        briers = [h["brier_monitor"], h["brier_rms_rule"]]
        skill = _words(h["skill_over_rms_rule"], 2)
        between = f"{h['from_s']:g} and {h['to_s']:g}"
        lines.append(row(between, h["starts"], _shares(h), *(_words(three, 3) for three in briers), skill))
    last = told["horizons"][-1]
    lines += ["", f"| Foreseen within {last['horizon_s']:g} s | starts | exceeded |", "|---|---|---|"]
    for b in last["reliability"]:
        happened = b["happened"]
        lines.append(row(f"{b['said']:.2f}", b["count"], _words([happened[k] for k in ("value", "low", "high")], 2)))
    return "\n".join(lines) + "\n"


def picture(told: dict[str, Any], path: Path) -> None:
    """Reliability at every horizon, with counts."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullFormatter

    count = len(told["horizons"])
    figure, axes = plt.subplots(2, count, figsize=(3.0 * count, 4.6), height_ratios=(3, 1), squeeze=False)
    for (top, below), h in zip(axes.T, told["horizons"], strict=True):
        top.plot([0, 1], [0, 1], color="0.6", linewidth=1)
        for key, label, colour in (
            ("reliability", "monitor", "tab:blue"),
            ("reliability_rms_rule", "RMS rule", "tab:orange"),
        ):
            said = [b["said"] for b in h[key]]
            value = np.array([[b["happened"][k] for k in ("value", "low", "high")] for b in h[key]])
            error = np.maximum(np.abs(value[:, 1:] - value[:, :1]).T, 0.0)
            top.errorbar(said, value[:, 0], error, marker="o", markersize=3, linewidth=1, color=colour, label=label)
        top.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.02), title=f"within {h['horizon_s']:g} s", aspect="equal")
        below.bar([b["said"] for b in h["reliability"]], [b["count"] for b in h["reliability"]], 0.06, log=True)
        below.set(xlim=(-0.02, 1.02), ylim=(1.0, None), xlabel="foreseen")
        below.yaxis.set_minor_formatter(NullFormatter())
    axes[0, 0].set_ylabel("exceeded")
    axes[0, 0].legend(loc="upper left", fontsize="small")
    axes[1, 0].set_ylabel("starts")
    figure.tight_layout()
    with whole_file(path) as temporary:
        figure.savefig(temporary, format="png", dpi=110)
    plt.close(figure)
