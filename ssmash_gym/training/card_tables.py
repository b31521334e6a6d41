"""Tables and sentences of a model card, made from the figures of a study."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from ssmash_gym.evaluation.figure_text import number, percent

LOW: Final = 3  # so many conditions are named as the worst
WORDS: Final = {"goal": "reached the goal", "time": "ran out of time"}


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """A Markdown table."""
    rule = ["---"] * len(heads)
    cells = ([str(cell).replace("|", "\\|") for cell in row] for row in (heads, rule, *rows))
    return [f"| {' | '.join(row)} |" for row in cells]


def prose(*sentences: str) -> list[str]:
    """A paragraph in lines of at most 120 characters; what stands between backticks stays on one line."""
    whole = re.sub(r"`[^`]*`", lambda code: code[0].replace(" ", "\0"), " ".join(sentences))
    lines = textwrap.wrap(whole, 120, break_long_words=False, break_on_hyphens=False)
    return [line.replace("\0", " ") for line in lines]


def by_policy(agent: str, condition: Mapping[str, Any], roles: Mapping[str, Any]) -> list[str]:
    """All policies of a condition: the agent first, then laws, planners, the book, holding."""
    found = condition["policies"]
    last = [name for name in (roles.get("book"), roles.get("hold")) if name in found]
    order = [agent, *(name for name in found if name not in (agent, *last)), *last]
    rows = []
    for name in order:
        one = found[name]
        load = one["peak_probe_kN"]
        rows.append(
            (
                f"**{name}**" if name == agent else name, percent(one["success"]), percent(one["aligned"], short=True),
                number(load["p95"]), number(load["mean"]), number(load["iqm"], short=True),
                number(one["peak_main_kN"]["p95"], short=True), number(one["lift_offs"], 2, short=True),
                number(one["time_s"], short=True), one["seas"],
            )
        )  # fmt: skip
    heads = (
        "policy", "success %", "aligned %", "peak P95 kN", "mean kN", "IQM kN", "main tires P95 kN", "lift-offs",
        "time median s", "seas",
    )  # fmt: skip
    return table(heads, rows)


def targets(checks: Sequence[Mapping[str, Any]]) -> list[str]:
    """The project's aims and what became of them."""
    rows = [
        (one["line"], f"{one['statement']} (`{one['condition']}`)", one["figure"], one["verdict"]) for one in checks
    ]
    return table(("Nr", "aim", "found", "verdict"), rows)


def by_training_seed(agent: str, seed: int | None, condition: Mapping[str, Any]) -> list[str]:
    """The agent's training seeds beside each other, with words and an empty line; nothing where there is one."""
    each = condition["policies"][agent].get("per_seed", ())
    if not each:
        return []
    rows = [
        (
            f"**{one['training_seed']}** (this agent)" if one["training_seed"] == seed else one["training_seed"],
            f"{100 * one['success']:.1f}", f"{one['p95_kN']:.1f}", f"{one['mean_kN']:.1f}",
        )
        for one in each
    ]  # fmt: skip
    heads = ("training seed", "success %", "peak P95 kN", "mean kN")
    return ["The same configuration with other training seeds, in the main condition:", "", *table(heads, rows), ""]


def by_condition(conditions: Mapping[str, Mapping[str, Any]], roles: Mapping[str, Any]) -> list[str]:
    """The agent's own figures in each condition, beside the book and the law it is compared with."""
    rows = []
    for name, one in conditions.items():
        own, found = one["own"], one["policies"]
        time_s = "-" if own["time_s"] is None else f"{own['time_s']:.1f}"
        rows.append(
            (
                f"`{name}`", own["episodes"], f"{100 * own['success']:.1f}", f"{own['p95_kN']:.1f}",
                f"{own['mean_kN']:.1f}", f"{own['largest_kN']:.1f}", time_s,
                *(_other(found, other) for other in (roles.get("book"), one["best_law"])),
            )
        )  # fmt: skip
    heads = (
        "condition", "seas", "success %", "peak P95 kN", "mean kN", "largest kN", "time median s", "the book's P95",
        "the law's P95",
    )  # fmt: skip
    return table(heads, rows)


def by_severity(bands: Sequence[Mapping[str, Any]]) -> list[str]:
    """Success and loads in bands of the sea's lateral specific force."""
    rows = []
    for one in bands:
        low, high = f"{one['from_g']:g}", one["to_g"]
        highest = one["peak_probe_kN"]["p95"]
        load = "-" if highest is None else f"{highest:.1f}"
        success, mean = f"{100 * one['success_rate']:.0f}", f"{one['peak_probe_kN']['mean']:.1f}"
        band = f"{low} g and more" if high is None else f"{low} to {high:g} g"
        rows.append((band, one["episodes"], success, load, mean))
    return table(("severity", "seas", "success %", "peak P95 kN", "mean kN"), rows)


def endings(own: Mapping[str, Any]) -> str:
    """How episodes ended, as a sentence without its full stop."""
    told = ", ".join(f"{count} {WORDS.get(name, f'ended by `{name}`')}" for name, count in own["reasons"].items())
    crooked = own["crooked"]
    tail = f"; of those without success {crooked} ended crooked or beside the line" if crooked else ""
    return f"of {own['episodes']} episodes {told}{tail}"


def worst_conditions(conditions: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The conditions with the lowest success and the highest loads, as a list."""
    success = sorted(conditions, key=lambda name: float(conditions[name]["own"]["success"]))[:LOW]
    loads = sorted(conditions, key=lambda name: -float(conditions[name]["own"]["p95_kN"]))[:LOW]
    lowest = ", ".join(f"{100 * conditions[name]['own']['success']:.1f} % in `{name}`" for name in success)
    highest = ", ".join(f"{conditions[name]['own']['p95_kN']:.1f} kN in `{name}`" for name in loads)
    return [f"- Lowest success: {lowest}.", f"- Highest P95 of the peak load: {highest}."]


def _other(policies: Mapping[str, Any], name: str | None) -> str:
    return number(policies[str(name)]["peak_probe_kN"]["p95"], short=True) if name in policies else "-"
