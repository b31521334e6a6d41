"""Writes the figures of a study into docs/guide/evaluation.md, between its two markers.

python tools/study_page.py runs/standard/summary.json
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from ssmash_gym.evaluation.targets import sentences
from ssmash_gym.files import write_text

PAGE: Final = Path(__file__).resolve().parents[1] / "docs" / "guide" / "evaluation.md"
BEGIN: Final = "<!-- figures of the standard study: begin -->"
END: Final = "<!-- figures of the standard study: end -->"


def number(figure: Mapping[str, Any], factor: float = 1.0, digits: int = 1) -> str:
    """A figure with its interval, as far as there is one."""
    if figure["value"] is None:
        return "-"
    value = f"{factor * figure['value']:.{digits}f}"
    if figure["ci"] is None:
        return value
    low, high = (factor * bound for bound in figure["ci"])
    return f"{value} [{low:.{digits}f}, {high:.{digits}f}]"


def bare(figure: Mapping[str, Any], factor: float = 1.0, digits: int = 1) -> str:
    """A figure without its interval."""
    return number({"value": figure["value"], "ci": None}, factor, digits)


def main_table(condition: Mapping[str, Any]) -> Iterator[str]:
    """Every policy of a condition."""
    heads = ("policy", "seas", "success %", "P95 kN", "mean kN", "IQM kN", "median time s", "over 15 kN, % of time")
    yield f"| {' | '.join(heads)} | main tire P95 kN |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, p in condition["policies"].items():
        peak = p["peak_probe_kN"]
        cells = [
            f"`{name}`", str(p["seas"]), number(p["success"], 100.0), number(peak["p95"]), number(peak["mean"]),
            number(peak["iqm"]), bare(p["time_s"]), bare(p["over_limit_share"], 100.0, 2),
            number(p["peak_main_kN"]["p95"]),
        ]  # fmt: skip
        yield f"| {' | '.join(cells)} |"


def others_table(conditions: Mapping[str, Any], names: list[str]) -> Iterator[str]:
    """Success and tail of some policies in every condition."""
    yield f"| condition | {' | '.join(f'`{name}`' for name in names)} |"
    yield "|---" * (len(names) + 1) + "|"
    for key, condition in conditions.items():
        cells = []
        for name in names:
            p = condition["policies"].get(name)
            cells.append(
                "-" if p is None else f"{100 * p['success']['value']:.0f} %, {number(p['peak_probe_kN']['p95'])}"
            )
        yield f"| `{key}` | {' | '.join(cells)} |"


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
