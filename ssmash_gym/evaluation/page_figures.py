"""The figures of a study's page, by section; each with a title, a caption and words for those who cannot see it."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation import charts
from ssmash_gym.evaluation.page_data import Array, StudyData
from ssmash_gym.evaluation.page_tables import Grid, pair_table
from ssmash_gym.evaluation.severity import BANDS, PEAK, band_means
from ssmash_gym.evaluation.statistics import Estimate
from ssmash_gym.evaluation.summary import FEWEST
from ssmash_gym.evaluation.targets import SLOWER
from ssmash_gym.ship.sea import comes_from_deg

SECTORS: Final = 12  # of the compass
P95: Final = ("peak_probe_kN", "p95")
STRETCHES: Final = 60  # of a learning curve
LOAD: Final = "peak probe load, P95 [kN]"


@dataclass(frozen=True)
class Figure:
    """One figure of the page.

    Attributes:
        name: Anchor.
        title, caption: Below it.
        alt: What it shows, in words.
        svg: Text of the picture.
        wide: Whether it takes the whole width.
    """

    name: str
    title: str
    caption: str
    alt: str
    svg: str
    wide: bool = False


@dataclass(frozen=True)
class Section:
    """Figures that belong together."""

    name: str
    short: str
    title: str
    words: str
    figures: list[Figure]
    tables: list[Grid] = field(default_factory=list)


def sections(data: StudyData, curves: Mapping[str, Path]) -> list[Section]:
    """All sections that the study has data for.

    Args:
        data: The study.
        curves: Files of training curves (``curve.csv``) by name.

    Raises:
        ConfigurationError: A training curve cannot be read.
        ImportError: The extra ``plot`` is missing.
    """
    found = [_loads(data), _seas(data), _pairs(data), _robust(data), _trainings(curves)]
    return [section for section in found if section.figures]


def _kept(*made: Figure | None) -> list[Figure]:
    return [one for one in made if one is not None]


# --- loads ------------------------------------------------------------------------------------------------------


def _loads(data: StudyData) -> Section:
    words = (
        f"All policies meet the same seas in the condition {data.main}. A failed episode counts with the probe's "
        f"ultimate load, {data.limit('probe_ultimate_kN'):g} kN."
    )
    made = _kept(_distribution(data), _time(data))
    return Section("loads", "Loads", "How high the loads go, and what time buys", words, made)


def _distribution(data: StudyData) -> Figure:
    loads = {name: data.values(data.main, name, PEAK) for name in data.in_condition(data.main)}
    limit_kN = data.limit("probe_in_plane_kN")
    above = "; ".join(f"{name} {100 * np.mean(values > limit_kN):.0f} %" for name, values in loads.items())
    return Figure(
        "distribution",
        "Peak probe load, episode by episode",
        f"Share of episodes whose peak in-plane probe load stayed below a value; the further left, the better. Marks: "
        f"95th percentiles. Episodes above the cost limit of {limit_kN:g} kN: {above}.{_fewer(data)}",
        f"Distribution functions of the peak probe load of {', '.join(loads)}.",
        charts.distribution(loads, data.looks, limit_kN),
    )


def _fewer(data: StudyData) -> str:
    """Which policies have met fewer seas of the main condition than the first one."""
    all_of_them = data.rows.seas(data.main, data.first).size
    counts = {name: data.rows.seas(data.main, name).size for name in data.in_condition(data.main)}
    told = [f"{name} {count}" for name, count in counts.items() if count < all_of_them]
    return f" Seas: {all_of_them}; {', '.join(told)}, the first of them." if told else ""


def _time(data: StudyData) -> Figure | None:
    book, hold = data.config.roles.book, data.config.roles.hold
    found = {}
    for name in data.in_condition(data.main):
        load, time_s = data.estimate(data.main, name, *P95), data.estimate(data.main, name, "time_s")
        if name != hold and load is not None and time_s is not None:
            found[name] = (time_s.value, load)
    if not found:
        return None
    curve = data.summary.get("curve") or {}
    speeds = [
        charts.Speed(_speed(one["policy"], book), one["time_s"]["value"], one["p95"]["value"])
        for one in curve.get("points", ())
    ]
    allowed = SLOWER * found[book][0] if book in found else None
    caption = "P95 of the peak probe load over the median time of the successes, with 95 % intervals."
    if speeds:
        caption += f" Grey: {book} at other speeds ({curve['condition']}): what slowness alone does."
    if allowed is not None:
        caption += f" Dotted: {book}'s median time and 10 % more."
    return Figure(
        "load-time", "Load against time", caption, "Peak load over median time: "
        + "; ".join(f"{name} {load.value:.1f} kN in {time_s:.1f} s" for name, (time_s, load) in found.items()) + ".",
        charts.load_against_time(found, speeds, data.looks, allowed),
    )  # fmt: skip


def _speed(policy: str, book: str) -> str:
    """The speed in a policy's name, ``NAME@SPEED``."""
    speed = policy.partition("@")[2]
    return f"{speed} m/s" if speed else book


# --- seas -------------------------------------------------------------------------------------------------------


def _seas(data: StudyData) -> Section:
    words = "By height of the sea, by how hard the deck moves across, and by where the waves come from."
    return Section("seas", "Seas", "Sea by sea", words, _kept(_states(data), _severity(data), _heading(data)))


def _estimates(data: StudyData, conditions: list[str], *keys: str) -> dict[str, list[Estimate | None]]:
    """A figure of each policy in several conditions; without policies that have none."""
    table = {name: [data.estimate(one, name, *keys) for one in conditions] for name in data.drivers}
    return {name: row for name, row in table.items() if any(found is not None for found in row)}


def _states(data: StudyData) -> Figure | None:
    states = data.sea_states()
    if len(states) < 2:
        return None
    places = {name: f"SS{number}" for name, number in states.items()}
    words = "P95 of the peak probe load with 95 % intervals; dotted: cost limit."
    return _peaks_over(data, places, "sea state", ("sea-states", "By sea state", words))


def _peaks_over(data: StudyData, places: Mapping[str, str], axis: str, told: tuple[str, str, str]) -> Figure:
    """P95 of the peak loads in some conditions.

    Args:
        data: The study.
        places: What stands below each condition.
        axis: What that is.
        told: The figure's key, title and words.
    """
    values = _estimates(data, list(places), *P95)
    below = list(places.values())
    picture = charts.points(below, values, data.looks, (axis, LOAD), limit=data.limit("probe_in_plane_kN"))
    return Figure(*told, _told(below, values), picture)


def _told(places: list[str], values: Mapping[str, list[Estimate | None]]) -> str:
    """Numbers of a figure as words."""
    rows = []
    for name, row in values.items():
        given = (f"{place} {one.value:.1f}" for place, one in zip(places, row, strict=True) if one is not None)
        rows.append(f"{name}: {', '.join(given)}")
    return "P95 in kN. " + "; ".join(rows) + "."


def _severity(data: StudyData) -> Figure | None:
    """Mean peak load in bands of the lateral specific force, all sea states together."""
    states = [one for one in (data.sea_states() or {data.main: 0}) if (one, data.first) in data.rows.frames]
    everywhere = [name for name in data.drivers if states and all((one, name) in data.rows.frames for one in states)]
    if not everywhere:
        return None
    values, counts = band_means(data.rows, states, everywhere)
    places = [f"{low:g}-{high:g}" if math.isfinite(high) else f"> {low:g}" for low, high in BANDS]
    told = [f"{place}\n{count} seas" for place, count in zip(places, counts, strict=True)]
    filled = [k for k, count in enumerate(counts) if count >= FEWEST]
    if not filled:
        return None
    return Figure(
        "severity",
        "By severity of the deck's motion",
        "Mean peak probe load with 95 % intervals in bands of the deck's lateral specific force (long-run RMS), "
        f"{_listed(states)} together; no mark for fewer than {FEWEST} seas.",
        "Mean peak load over the lateral specific force of the deck.",
        charts.points(
            [told[k] for k in filled], {name: [row[k] for k in filled] for name, row in values.items()}, data.looks,
            ("lateral specific force, RMS [g]", "peak probe load, mean [kN]"), limit=data.limit("probe_in_plane_kN"),
        ),
    )  # fmt: skip


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _heading(data: StudyData) -> Figure | None:
    """Mean peak load by sector of the compass in the main condition."""
    values: dict[str, Array] = {}
    width = 360.0 / SECTORS
    for name in data.in_condition(data.main):
        heading = data.values(data.main, name, "sea_heading_deg")
        if not np.isfinite(heading).all():
            return None
        sector = np.round(comes_from_deg(heading) / width).astype(int) % SECTORS
        loads = data.values(data.main, name, PEAK)
        means = [float(np.mean(loads[sector == k])) if np.any(sector == k) else np.nan for k in range(SECTORS)]
        values[name] = np.array(means)
    if np.isnan(values[data.in_condition(data.main)[0]]).all():
        return None
    return Figure(
        "heading",
        "By where the waves come from",
        f"Mean peak probe load [kN] in sectors of {width:g}°, condition {data.main}; the bow is at the top, the "
        "dotted circle is the cost limit. A failed episode counts with the ultimate load.",
        "Polar chart of the mean peak load over the direction that the waves come from.",
        charts.by_heading(
            np.arange(SECTORS, dtype=np.float64) * width, values, data.looks, data.limit("probe_in_plane_kN")
        ),
    )


# --- pairs ------------------------------------------------------------------------------------------------------


def _pairs(data: StudyData) -> Section:
    """The first policy against the book and the best law, sea by sea."""
    others = [data.law, data.config.roles.book, data.config.roles.clairvoyant]
    known = [name for name in dict.fromkeys(others) if name and data.rows.has(data.main, data.first, name)]
    made: list[Figure] = []
    for other in known:
        if other != data.first:
            made += _against(data, other)
    words = "The same seed is the same sea, helicopter and start for each: two policies can be compared sea by sea."
    return Section("pairs", "Pairs", "Sea against sea", words, made, pair_table(data))


def _against(data: StudyData, other: str) -> list[Figure]:
    seas, (ours, theirs) = data.paired(data.main, [data.first, other], PEAK)
    names = (data.first, other)
    averaged = " (means over its training seeds)" if len(data.rows.seeds(data.main, data.first)) > 1 else ""
    difference = ours - theirs
    return [
        Figure(
            f"pairs-{other}",
            f"{data.first} and {other} in the same {seas.size} seas",
            f"Each dot is a sea of {data.main}; in the shaded half {data.first}{averaged} has the lower load.",
            f"{data.first} has the lower peak load in {100 * np.mean(ours < theirs):.0f} % of the seas.",
            charts.pairs(ours, theirs, names, data.looks),
        ),
        Figure(
            f"differences-{other}",
            f"{data.first} less {other}",
            "Differences of the peak probe load in the same sea, in order. Below zero (filled): lower load. Above "
            "(hatched): higher load.",
            f"Median of the difference {np.median(difference):+.1f} kN.",
            charts.differences(difference, names, data.looks),
        ),
    ]


# --- robustness -------------------------------------------------------------------------------------------------


def _robust(data: StudyData) -> Section:
    words = (
        "The agents are those of the other figures: nothing was trained anew. Where a condition changes the task, laws "
        "take what was tuned for it (the nominal delay); of all else nobody is told."
    )
    made = _kept(_dots(data), _delay(data))
    return Section("robustness", "Robustness", "When things are not as assumed", words, made)


def _delay(data: StudyData) -> Figure | None:
    delays = data.delays()
    if len(delays) < 2:
        return None
    places = {name: f"{delay}" for name, delay in delays.items()}
    words = "P95 of the peak probe load with 95 % intervals over the delay of the claw's commands; dotted: cost limit."
    return _peaks_over(data, places, "delay of the commands [ms]", ("delay", "By command delay", words))


def _dots(data: StudyData) -> Figure | None:
    hold = data.config.roles.hold
    conditions = [one for one in data.conditions if len(data.in_condition(one)) > 1]
    conditions.sort(key=lambda one: one != data.main)  # the others stand below what they differ from
    if len(conditions) < 2:
        return None
    loads = _estimates(data, conditions, *P95)
    successes = {name: row for name, row in _estimates(data, conditions, "success").items() if name != hold}
    return Figure(
        "conditions",
        "Every condition",
        f"P95 of the peak probe load and share of successes, with 95 % intervals; dotted: cost limit; {hold} cannot "
        "succeed. What the names stand for is told with the tables.",
        _told(conditions, loads),
        charts.dots(conditions, loads, successes, data.looks, data.limit("probe_in_plane_kN")),
        wide=True,
    )


# --- training ---------------------------------------------------------------------------------------------------


def _trainings(curves: Mapping[str, Path]) -> Section:
    words = "Episodes of the training itself, with exploration and in the training's seas: not the figures of the aims."
    found = {name: _smoothed(*read_curve(path)) for name, path in curves.items()}
    made = []
    if found:
        made.append(
            Figure(
                "learning",
                "Learning curves",
                f"Mean peak probe load and share of successes, a line a training; means of up to {STRETCHES} stretches "
                "of it.",
                "; ".join(f"{name} ends at {100 * curve[2][-1]:.0f} % success" for name, curve in found.items()),
                charts.learning(found),
            )
        )
    return Section("training", "Training", "How it was learned", words, made)


def _smoothed(*columns: Array) -> tuple[Array, Array, Array]:
    """Means of stretches of a training's curve."""
    ends = np.unique(np.linspace(0, len(columns[0]), min(STRETCHES, len(columns[0])) + 1).astype(int))
    steps, load, success = (np.add.reduceat(column, ends[:-1]) / np.diff(ends) for column in columns)
    return steps, load, success


def read_curve(path: Path) -> tuple[Array, Array, Array]:
    """Steps, mean peak load [kN] and share of successes of a training's ``curve.csv``.

    Raises:
        ConfigurationError: The file is missing, or is no curve.
    """
    wanted = ("steps", "peak_probe_kN_mean", "success_rate")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = [[float(line[name]) for name in wanted] for line in csv.DictReader(file)]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise ConfigurationError(f"{path}: this training curve cannot be read ({error}).") from None
    numbers = np.array([line for line in lines if np.isfinite(line).all()]).reshape(-1, len(wanted))
    if not len(numbers):
        raise ConfigurationError(f"{path}: this training curve holds no episode.")
    return numbers[:, 0], numbers[:, 1], numbers[:, 2]
