"""The report of a benchmark: one HTML page that holds everything (extra ``report``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from ssmash_gym import __version__
from ssmash_gym.benchmark import charts, page_tables, page_words
from ssmash_gym.benchmark.charts import Attempt
from ssmash_gym.evaluation.charts import distribution
from ssmash_gym.evaluation.page import data_uri, require_report
from ssmash_gym.evaluation.page_figures import Figure, Section
from ssmash_gym.evaluation.page_style import Style, styles
from ssmash_gym.files import write_text
from ssmash_gym.trials.trial import SCORED

Document = Mapping[str, Any]


def write_page(document: Document, rows: pl.DataFrame, path: Path, *, command: str = "") -> Path:
    """Write the report of a benchmark.

    The page needs no network, no script and no file beside it. The same figures give the same page, byte for byte.

    Args:
        document: Contents of ``benchmark.json``.
        rows: One row an episode, with the keys of `cache.KEYS`; those of trials that count and of programs.
        path: File to write.
        command: The command that made it, for its provenance.

    Returns:
        The file.

    Raises:
        ImportError: A library is missing; the sentence names the extra ``report`` or ``plot``.
    """
    require_report()
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    loader = ChoiceLoader([PackageLoader(f"ssmash_gym.{part}", "templates") for part in ("benchmark", "evaluation")])
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters["inline"] = Markup  # of what this package has drawn itself
    style = loader.get_source(environment, "study.css")[0]
    told = contents(document, rows, command)
    write_text(path, environment.get_template("benchmark.html.j2").render(css=Markup(style), **told))
    return path


def contents(document: Document, rows: pl.DataFrame, command: str) -> dict[str, Any]:
    """Everything that the template shows, by name."""
    look = looks(document)
    return {
        "generator": f"ssmash_gym {__version__}",
        "title": page_words.title(document),
        "scripted": page_words.scripted_words(document),
        "facts": facts(document),
        "answer": [*page_words.answer(document), *page_words.taught(document)],
        "drivers": page_tables.drivers_table(document, look),
        "members": [
            (name, page_tables.pairs_table(document, name))
            for name in page_words.alone(document)
            if name not in page_words.headed(document)
        ],
        "meaning": [*page_words.MEANING, ("reversals", page_words.reversal_words(document))],
        "sections": [
            {**vars(one), "figures": [_placed(figure) for figure in one.figures]}
            for one in _sections(document, rows, look)
        ],
        "trials": page_tables.trials_table(document["trials"]),
        "refused": page_tables.refused_table(document["trials"]),
        "fair": page_words.FAIR,
        "unequal": page_words.UNEQUAL,
        "provenance": page_tables.provenance(document, command),
    }


def looks(document: Document) -> dict[str, Style]:
    """Styles by name without delay; who was recorded comes first and stands out."""
    recorded = page_words.recorded(document)
    return styles([*recorded, *page_words.programs(document)], recorded[0])


def facts(document: Document) -> list[tuple[str, str]]:
    """Head of the page."""
    counted = sum(one["counts"] for one in document["trials"])
    return [
        ("seas", str(len(document["seeds"]))),
        ("trials", f"{counted} counted of {len(document['trials'])}"),
        ("condition", document["condition"]["name"]),
        ("added delays", ", ".join(f"{one:g}" for one in document["delays_ms"]) + " ms"),
        ("baseline", document["baseline"]),
        ("bound", document["bound"] or "no bound"),
        ("configuration", document["configuration"]),
    ]


def _placed(figure: Figure) -> dict[str, Any]:
    return {**vars(figure), "source": data_uri(figure.svg.encode(), "image/svg+xml")}


def _sections(document: Document, rows: pl.DataFrame, look: Mapping[str, Style]) -> list[Section]:
    tables = [page_tables.pairs_table(document, name) for name in page_words.headed(document)]
    words = "Differences sea by sea, the recorded driver less the program: below zero the driver's number is lower."
    bound = [page_tables.scores_table(document)] if document["scores"] else []
    return [
        Section("loads", "Loads", "Load, and the time it took", page_words.same_seas(document),
                [_scatter(document, rows, look), _distribution(document, rows, look)]),
        Section("pairs", "Pairs", "Driver against program, sea by sea", words, _forests(document, look), tables),
        Section("delays", "Delays", "What a matched delay costs the programs", "A program's commands act later by the "
                "added delay, on top of the claw's own. Bands: recorded drivers with their 95 % intervals, who have "
                "delays of their own.", _delays(document, look), [page_tables.baseline_table(document)]),
        Section("score", "Score", "Score between baseline and bound", page_words.bound_words(document), [], bound),
        Section("learning", "Learning", "Each driver's trials in order", "Practice and scored trials, whole and in "
                "time. Seas differ from trial to trial.", [_learning(document, look)]),
    ]  # fmt: skip


def _shown(document: Document) -> list[str]:
    """Drivers in figures of episodes: recorded ones, or the pools of many; programs without an added delay."""
    alone = page_words.alone(document)
    recorded = alone if len(alone) <= page_words.MOST_NAMED else page_words.headed(document)
    programs = [name for name, one in document["drivers"].items() if name == one["base"] and name not in
                page_words.recorded(document)]  # fmt: skip
    return [*recorded, *programs]


def _of(document: Document, rows: pl.DataFrame, name: str) -> pl.DataFrame:
    """Rows of one driver; of a pool those of its members, in the seas that all of them have met."""
    members = document["drivers"][name]["members"]
    own = rows.filter(pl.col("driver") == name)
    if own.height:
        return own
    own = rows.filter(pl.col("driver").is_in(members))
    return own.filter(pl.len().over("seed") == len(members))


def _scatter(document: Document, rows: pl.DataFrame, look: Mapping[str, Style]) -> Figure:
    found = {}
    for name in _shown(document):
        own = _of(document, rows, name)
        found[name] = own["time_s"].to_numpy(), own["scored_peak_kN"].to_numpy()
    limit = document["limits_kN"]["probe_in_plane"]
    medians = "; ".join(f"{name}: {np.median(load):.1f} kN in {np.median(time):.1f} s" for name, (time, load)
                        in found.items())  # fmt: skip
    return Figure(
        "load-time", "Peak load against time",
        f"A small mark an episode, a large one the medians. Dotted: cost limit {limit:g} kN. "
        "Whoever drives slower can load the probe less: compare loads at like times only.",
        f"Medians: {medians}.", charts.peak_against_time(found, look, limit, document["horizon_s"]),
    )  # fmt: skip


def _distribution(document: Document, rows: pl.DataFrame, look: Mapping[str, Style]) -> Figure:
    limit = document["limits_kN"]["probe_in_plane"]
    loads = {name: _of(document, rows, name)["scored_peak_kN"].to_numpy() for name in _shown(document)}
    return Figure(
        "distribution", "Peak load, episode by episode",
        "Share of episodes whose peak load stayed below a value; the further left, the better. Marks: 95th "
        "percentiles.",
        f"Distribution functions of the peak load of {', '.join(loads)}.", distribution(loads, look, limit),
    )  # fmt: skip


def _forests(document: Document, look: Mapping[str, Style]) -> list[Figure]:
    """Mean differences and probabilities of improvement of each recorded driver."""
    found = []
    for k, name in enumerate(page_words.headed(document)):
        own = [one for one in document["pairs"] if one["driver"] == name]
        if not own:
            continue
        style = [look[document["drivers"][one["other"]]["base"]] for one in own]
        told = "; ".join(f"{one['other']} {page_words.difference(one['peak_mean_kN'])}" for one in own)
        apart = [(one["other"], one["peak_mean_kN"]) for one in own]
        found.append(Figure(
            f"apart-{k}", f"{name}: peak load less that of each program",
            "Mean of the differences sea by sea with 95 % intervals; left of zero the recorded driver's load is lower.",
            f"Mean differences: {told}.", charts.forest(apart, style, f"peak load, {name} less program [kN]", 0.0),
        ))  # fmt: skip
        chance = [(one["other"], one["improvement"]) for one in own]
        told = "; ".join(f"{one['other']} {one['improvement']['value']:.2f}" for one in own)
        found.append(Figure(
            f"improvement-{k}", f"{name}: probability of improvement",
            "Probability that the recorded driver's peak load in a sea is lower than the program's; 0.5: neither.",
            f"Probabilities: {told}.", charts.forest(chance, style, f"probability that {name} is lower", 0.5),
        ))  # fmt: skip
    return found


def _delays(document: Document, look: Mapping[str, Style]) -> list[Figure]:
    limit = document["limits_kN"]["probe_in_plane"]
    asked = (
        ("delay-load", "Peak load over added delay", "peak probe load, mean [kN]", ("peak_probe_kN", "mean"), limit),
        ("delay-limit", "Time over the limit over added delay", "time over limit, mean [s]", ("over_limit_s",), None),
        ("delay-success", "Success over added delay", "share of successes", ("success",), None),
        ("delay-reversals", "Reversals over added delay", "reversals an episode", ("reversals",), None),
    )
    found = []
    for name, title, label, keys, line in asked:
        programs: dict[str, list[tuple[float, Any]]] = {}
        at_the_claw: dict[str, Any] = {}
        recorded, headed = page_words.recorded(document), page_words.headed(document)
        for who, one in document["drivers"].items():
            figure = one[keys[0]] if len(keys) == 1 else one[keys[0]][keys[1]]
            if who in headed:
                at_the_claw[who] = figure
            elif who not in recorded:
                programs.setdefault(one["base"], []).append((one["delay_ms"], figure))
        told = "; ".join(f"{base}: " + ", ".join(f"{delay:g} ms {figure['value']:.2f}" for delay, figure in row)
                         for base, row in programs.items())  # fmt: skip
        svg = charts.over_delay(programs, at_the_claw, look, label, line)
        found.append(Figure(name, title, "With 95 % intervals.", f"{label}: {told}.", svg))
    return found


def _learning(document: Document, look: Mapping[str, Style]) -> Figure:
    known = {
        name: [
            Attempt(one["trial"], one["scored_peak_kN"], one["baseline_kN"], one["phase"] == SCORED,
                    bool(one["success"]))
            for one in trials
        ]
        for name, trials in document["learning"].items()
    }  # fmt: skip
    missing = [name for name in known if name not in look]  # practice only
    everybody = {**look, **{name: replace(style) for name, style in styles(missing).items()}}
    told = "; ".join(f"{name}: " + ", ".join(f"{one.peak_kN:.1f}" for one in row) for name, row in known.items())
    limit, base = document["limits_kN"]["probe_in_plane"], document["baseline"]
    return Figure(
        "learning-curve", "Peak load, trial by trial",
        "Hollow: practice; filled: scored; crossed out: did not succeed. Dotted: cost limit. At the right without what "
        "the seas differ by.",
        f"Peak loads in kN. {told}.", charts.learning(known, everybody, base, limit),
        wide=True,
    )  # fmt: skip
