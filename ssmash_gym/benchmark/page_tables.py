"""The tables of a benchmark's page: every number is one of ``benchmark.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ssmash_gym.benchmark.figures import PEOPLE, SCRIPTED
from ssmash_gym.benchmark.page_words import replay_words
from ssmash_gym.evaluation.page_style import Style, sample
from ssmash_gym.evaluation.page_tables import DASH, Cell, Column, Grid, Row, Shown

FIGURES: Final = (
    Shown(Column("success", "%"), ("success",), 100.0, 0, interval=True),
    Shown(Column("peak load, mean", "kN"), ("peak_probe_kN", "mean"), interval=True),
    Shown(Column("IQM", "kN"), ("peak_probe_kN", "iqm"), interval=True),
    Shown(Column("P95", "kN"), ("peak_probe_kN", "p95"), interval=True),
    Shown(Column("over limit", "mean, s"), ("over_limit_s",), 1.0, 2),
    Shown(Column("time", "median s"), ("time_s",), interval=True),
    Shown(Column("main tires, P95", "kN"), ("peak_main_kN", "p95")),
    Shown(Column("lift-offs", "per episode"), ("lift_offs",), 1.0, 2),
    Shown(Column("claw path", "mean, m"), ("claw_path_m",), 1.0, 2),
    Shown(Column("reversals", "per episode"), ("reversals",)),
)
PAIR: Final = (
    Shown(Column("peak load, mean", "kN"), ("peak_mean_kN",), interval=True, sign=True),
    Shown(Column("IQM", "kN"), ("peak_iqm_kN",), interval=True, sign=True),
    Shown(Column("P95", "kN"), ("peak_p95_kN",), interval=True, sign=True),
    Shown(Column("probability of improvement", "%"), ("improvement",), 100.0, 0, interval=True),
    Shown(Column("success", "points"), ("success",), 100.0, 0, interval=True, sign=True),
    Shown(Column("over limit", "s"), ("over_limit_s",), 1.0, 2, sign=True),
    Shown(Column("time", "s"), ("time_s",), interval=True, sign=True),
    Shown(Column("lift-offs", "per episode"), ("lift_offs",), 1.0, 2, sign=True),
    Shown(Column("claw path", "m"), ("claw_path_m",), 1.0, 2, sign=True),
    Shown(Column("reversals", "per episode"), ("reversals",), sign=True),
)
SCORE: Final = tuple(Shown(Column(name), (key,), 1.0, 0, interval=True)
                     for name, key in (("mean", "mean"), ("IQM", "iqm"), ("P95", "p95")))  # fmt: skip


def cell(figures: Mapping[str, Any], shown: Shown) -> Cell:
    """A figure as its column shows it."""
    found: Any = figures
    for key in shown.keys:
        found = found[key]
    if found["value"] is None:
        return Cell(DASH)
    texts = [_number(shown.factor * one, shown) for one in (found["value"], *(found["ci"] or ()))]
    small = f"[{texts[1]}, {texts[2]}]" if shown.interval and found["ci"] else ""
    return Cell(texts[0], small)


def _number(value: float, shown: Shown) -> str:
    """A number with the column's digits; zero has no sign."""
    text = f"{value:{'+' if shown.sign else ''}.{shown.digits}f}"
    return text.lstrip("+-") if not float(text) else text.replace("-", "−")


def drivers_table(document: Mapping[str, Any], looks: Mapping[str, Style]) -> Grid:
    """Everybody's figures, a row each."""
    columns = [Column("driver"), Column("seas"), *(one.column for one in FIGURES)]
    rows = []
    for name, figures in document["drivers"].items():
        cells = [Cell(name), Cell(str(figures["seas"])), *(cell(figures, one) for one in FIGURES)]
        rows.append(Row(cells, sample(looks[figures["base"]]), figures["kind"] in (PEOPLE, SCRIPTED)))
    return Grid(columns, rows, "In brackets: 95 % intervals.")


def pairs_table(document: Mapping[str, Any], driver: str) -> Grid:
    """One driver less the others, sea by sea."""
    own = [one for one in document["pairs"] if one["driver"] == driver]
    columns = [Column(f"{driver} less"), Column("seas"), *(one.column for one in PAIR)]
    rows = [Row([Cell(one["other"]), Cell(str(one["seas"])), *(cell(one, shown) for shown in PAIR)]) for one in own]
    return Grid(columns, rows)


def baseline_table(document: Mapping[str, Any]) -> Grid:
    """Programs less the baseline, sea by sea."""
    base = document["baseline"]
    own = [one for one in document["pairs"] if document["drivers"][one["driver"]]["kind"] not in (PEOPLE, SCRIPTED)]
    columns = [Column("program"), Column("seas"), *(one.column for one in PAIR)]
    rows = [Row([Cell(one["driver"]), Cell(str(one["seas"])), *(cell(one, shown) for shown in PAIR)]) for one in own]
    return Grid(columns, rows, f"Each less {base} without delay.")


def scores_table(document: Mapping[str, Any]) -> Grid:
    """The normalised scores."""
    columns = [Column("driver"), Column("seas"), *(one.column for one in SCORE)]
    rows = [
        Row([Cell(name), Cell(str(figures["seas"])), *(cell(figures, one) for one in SCORE)])
        for name, figures in document["scores"].items()
    ]
    return Grid(columns, rows, f"0: {document['baseline']}; 100: {document['bound']}.")


def trials_table(trials: Sequence[Mapping[str, Any]]) -> Grid:
    """Every trial that counts or is practice: its timing, and what became of it."""
    heads = (
        ("file", ""), ("driver", ""), ("phase", ""), ("attempt", ""), ("late steps", "%"),
        ("latency P50", "ms"), ("P95", "ms"), ("max", "ms"), ("messages", ""),
    )  # fmt: skip
    rows = []
    for one in trials:
        waits = one["latency_ms"]
        numbers = [DASH if waits[key] is None else f"{waits[key]:.1f}" for key in ("p50", "p95", "max")]
        texts = [
            one["driver"],
            one["phase"],
            str(one["attempt"]),
            f"{100.0 * one['late_share']:.1f}",
            *numbers,
            str(waits["messages"]),
        ]
        rows.append(Row([Cell(one["place"], code=True), *map(Cell, texts)]))
    return Grid([Column(*head) for head in heads], rows)


def refused_table(trials: Sequence[Mapping[str, Any]]) -> Grid:
    """The trials that do not count, with the reason."""
    own = [one for one in trials if not one["counts"]]
    columns = [Column("file"), Column("driver"), Column("does not count because", words=True)]
    return Grid(columns, [Row([Cell(one["place"], code=True), Cell(one["driver"]), Cell(one["reason"])])
                          for one in own])  # fmt: skip


def provenance(document: Mapping[str, Any], command: str) -> Grid:
    """What every figure was made from."""
    seeds = document["seeds"]
    versions = document["versions"]
    listed = ", ".join(map(str, seeds))
    told = [
        ("version", f"ssmash_gym {versions['ssmash_gym']}"),
        ("code", f"{versions['code']} (simulation and scripted policies), {versions['sources']} (simulation)"),
        ("configuration", document["configuration"]),
        (f"seeds ({len(seeds)})", listed),
        *((f"program {name}", identity) for name, identity in document["identities"].items()),
        ("trials", f"{sum(one['counts'] for one in document['trials'])} of {len(document['trials'])} count; "
         f"{replay_words(document)}"),
        ("intervals", f"{100.0 * document['level']:g} %, percentile bootstrap, {document['resamples']} resamples over "
         "seas (and, where there are several, over participants or training seeds); shares: Wilson's"),
        *([("made by", command)] if command else []),
    ]  # fmt: skip
    return Grid([Column("what"), Column("value", words=True)], [Row([Cell(name), Cell(value)]) for name, value in told])
