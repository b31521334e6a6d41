"""Writes the figures of a study into docs/guide/evaluation.md, between its two markers.

``python tools/study_page.py runs/standard/summary.json``
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from ssmash_gym.evaluation.figure_text import number, percent
from ssmash_gym.evaluation.targets import sentences
from ssmash_gym.files import write_text
from ssmash_gym.training.card_tables import table

PAGE: Final = Path(__file__).resolve().parents[1] / "docs" / "guide" / "evaluation.md"
BEGIN: Final = "<!-- figures of the standard study: begin -->"
END: Final = "<!-- figures of the standard study: end -->"


def main_table(condition: Mapping[str, Any]) -> list[str]:
    """Every policy of a condition."""
    rows = []
    for name, p in condition["policies"].items():
        peak = p["peak_probe_kN"]
        rows.append(
            (
                f"`{name}`", p["seas"], percent(p["success"]), number(peak["p95"]), number(peak["mean"]),
                number(peak["iqm"]), number(p["time_s"], short=True),
                number(p["over_limit_share"], 2, factor=100.0, short=True), number(p["peak_main_kN"]["p95"]),
            )
        )  # fmt: skip
    heads = (
        "policy", "seas", "success %", "P95 kN", "mean kN", "IQM kN", "median time s", "over 15 kN, % of time",
        "main tire P95 kN",
    )  # fmt: skip
    return table(heads, rows)


def others_table(conditions: Mapping[str, Any], names: list[str]) -> list[str]:
    """Success and tail of some policies in every condition."""
    rows = []
    for key, condition in conditions.items():
        found = [condition["policies"].get(name) for name in names]
        rows.append((f"`{key}`", *("-" if p is None else success_and_tail(p) for p in found)))
    return table(("condition", *(f"`{name}`" for name in names)), rows)


def success_and_tail(policy: Mapping[str, Any]) -> str:
    """Its successes, and the 95th percentile of its peaks."""
    return f"{number(policy['success'], 0, factor=100.0, short=True)} %, {number(policy['peak_probe_kN']['p95'])}"


def block(summary: Mapping[str, Any]) -> Iterator[str]:
    """All that stands between the markers."""
    conditions = summary["conditions"]
    met = {name: p["kind"] for condition in conditions.values() for name, p in condition["policies"].items()}
    agents = [name for name, kind in met.items() if kind == "agent"]
    versions = summary["versions"]
    yield (
        f"Study `{summary['study']}`, seed {summary['seed']}, ssmash_gym {versions['ssmash_gym']}, configuration "
        f"`{summary['configuration']}`. In brackets 95 % intervals; {summary['resamples']} resamples."
    )
    yield ""
    yield from (f"- {line}" for line in sentences(summary["targets"]))
    yield ""
    yield "Sea state 5, yaw up to 8 deg, delay 0.1 s (`ss5`):"
    yield ""
    yield from main_table(conditions["ss5"])
    yield ""
    yield "Success, and the 95th percentile of the peak probe load in kN, in all conditions:"
    yield ""
    shown = [n for n in ("hold", "trapezoid", "linear", *agents) if n in conditions["ss5"]["policies"]]
    yield from others_table({k: c for k, c in conditions.items() if k != "ss5_time"}, shown)


def main() -> None:
    """Rewrite the page."""
    if len(sys.argv) != 2:
        raise SystemExit("give the summary.json of a study of `standard`")
    summary = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    write_text(PAGE, f"{before}{BEGIN}\n" + "\n".join(block(summary)) + f"\n{END}{after}")


if __name__ == "__main__":
    main()
