"""The figures of a benchmark: each driver by itself, two in the same seas, and the score between baseline and bound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.evaluation.statistics import improvement, iqm, known_median, mean, p95
from ssmash_gym.evaluation.study_figures import Episodes, Options, estimated, gap_figures, share_figure

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
PEOPLE: Final = "participant"  # kinds of drivers besides those of programs
SCRIPTED: Final = "scripted operator"
POOLS: Final = {PEOPLE: "all participants", SCRIPTED: "all scripted operators"}
MEANS: Final = ("over_limit_s", "lift_offs", "claw_path_m", "reversals")  # of which a driver's figure is the mean
COLUMNS: Final = {
    "peak_kN": "scored_peak_kN",
    "main_kN": "peak_main_kN",
    "success": "success",
    "time_s": "time_s",
    **{name: name for name in MEANS},
}


@dataclass(frozen=True)
class Driver:
    """One who is compared: a participant, several of them pooled, or a program with a delay.

    Attributes:
        name: In tables and figures.
        kind: ``participant``, ``scripted operator``, ``agent``, ``scripted`` or ``planner``.
        delay_ms: Added to each episode's own claw delay [ms].
        members: Participants of a pool, or training seeds of an agent; otherwise one.
        episodes: Their numbers; ``training_seeds`` there stands for the members.
        base: Name without the delay.
    """

    name: str
    kind: str
    delay_ms: float
    members: tuple[str, ...]
    episodes: Episodes
    base: str

    @property
    def pooled(self) -> bool:
        """Whether it is several of those whose trials were recorded, taken together."""
        return self.at_the_claw and len(self.members) > 1

    @property
    def at_the_claw(self) -> bool:
        """Whether it is one of those whose trials were recorded."""
        return self.kind in (PEOPLE, SCRIPTED)


def driver(rows: pl.DataFrame, name: str, base: str = "") -> Driver:
    """A driver from its rows; of several members the seas that all of them have met.

    Args:
        rows: Of one driver, one row an episode.
        name: Of it.
        base: The same without its delay.
    """
    members = rows["member"].unique(maintain_order=True).to_list()
    met = rows.group_by("seed").len().filter(pl.col("len") == len(members))["seed"].sort()
    ordered = rows.filter(pl.col("seed").is_in(met.to_list())).sort("seed")

    def table(column: str) -> Array:
        found = [ordered.filter(pl.col("member") == one)[column].cast(pl.Float64).to_numpy() for one in members]
        return np.stack(found) if met.len() else np.empty((len(members), 0))

    tables = {key: table(column) for key, column in COLUMNS.items()}
    tables["time_s"] = np.where(tables["success"] > 0.0, tables["time_s"], np.nan)  # a time is that of a success
    seeds: list[int | None] = list(range(len(members))) if len(members) > 1 else [None]
    episodes = Episodes(met.to_numpy(), seeds, tables)
    return Driver(name, str(rows["kind"][0]), float(rows["delay_ms"][0]), tuple(members), episodes, base or name)


def drivers(trials: pl.DataFrame, programs: pl.DataFrame) -> list[Driver]:
    """All who are compared: people, scripted drivers, each of these pooled where there are several, then programs.

    Args:
        trials: Rows of trials that count.
        programs: Rows of programs.
    """
    found = []
    for kind, pooled in POOLS.items():
        own = trials.filter(pl.col("kind") == kind)
        names = own["driver"].unique(maintain_order=True).sort().to_list()
        found += [driver(own.filter(pl.col("driver") == name), name) for name in names]
        if len(names) > 1:
            together = driver(own, pooled)
            found += [together] if together.episodes.seas.size else []
    for name in programs["driver"].unique(maintain_order=True).to_list():
        own = programs.filter(pl.col("driver") == name)
        found.append(driver(own, name, name.partition(" +")[0]))
    return found


def common(*several: Driver) -> list[Driver]:
    """The same drivers in the seas that all of them have met."""
    seas = several[0].episodes.seas
    for one in several[1:]:
        seas = np.intersect1d(seas, one.episodes.seas)
    return [_within(one, seas) for one in several]


def _within(one: Driver, seas: NDArray[np.int64]) -> Driver:
    places = np.searchsorted(one.episodes.seas, seas)
    tables = {name: table[:, places] for name, table in one.episodes.tables.items()}
    episodes = Episodes(seas, one.episodes.training_seeds, tables)
    return Driver(one.name, one.kind, one.delay_ms, one.members, episodes, one.base)


def own_figures(one: Driver, options: Options) -> dict[str, Any]:
    """Figures of a driver with intervals.

    A failed episode counts with the probe's ultimate load. Times are those of the successes; without any there is none.

    Args:
        one: The driver.
        options: Of the intervals.
    """
    episodes = one.episodes

    def found(codes: Codes) -> dict[str, Array]:
        peak = episodes.ordered("peak_kN", codes)
        return {
            "mean": mean(peak),
            "iqm": iqm(peak),
            "p95": p95(peak),
            "main_p95": p95(episodes.ordered("main_kN", codes)),
            "time_s": known_median(episodes.at("time_s", codes)),
            **{name: mean(episodes.at(name, codes)) for name in ("success", *MEANS)},
        }

    figures = estimated([episodes], found, options)
    return {
        "success": share_figure(episodes, "success", figures.pop("success"), options),
        "peak_probe_kN": {key: figures.pop(key) for key in ("mean", "iqm", "p95")},
        "peak_main_kN": {"p95": figures.pop("main_p95")},
        **figures,
    }


def pair_figures(ours: Driver, theirs: Driver, options: Options) -> dict[str, Any]:
    """Two drivers in the same seas: differences sea by sea, the first less the other, with intervals.

    Of an agent with several training seeds the mean over these is the other of each pair. ``improvement`` is the
    probability that the first one's peak load is the lower one, ``time_s`` the difference in seas in which both arrive.

    Args:
        ours: The first.
        theirs: The other; both of the same seas (`common`).
        options: Of the intervals.
    """
    a, b = ours.episodes, theirs.episodes
    apart = {name: _apart(a.tables[name], b.tables[name]) for name in COLUMNS}
    lower = improvement(a.tables["peak_kN"][:, None], b.tables["peak_kN"][None], axis=1)

    def found(mine: Codes, other: Codes) -> dict[str, Array]:
        peak = apart["peak_kN"].ravel()[mine]
        return {
            "peak_mean_kN": mean(peak),
            "peak_iqm_kN": iqm(peak),
            "peak_p95_kN": p95(a.ordered("peak_kN", mine)) - p95(b.ordered("peak_kN", other)),
            "improvement": mean(lower.ravel()[mine]),
            "time_s": known_mean(apart["time_s"].ravel()[mine]),
            **{name: mean(apart[name].ravel()[mine]) for name in ("success", *MEANS)},
        }

    return {"seas": int(a.seas.size), **estimated([a, b], found, options)}


def _apart(ours: Array, theirs: Array) -> Array:
    """Differences sea by sea, (members of the first, seas), of the mean over the other's members."""
    return np.asarray((ours[:, None] - theirs[None]).mean(axis=1))


def known_mean(values: Array) -> Array:
    """Mean along the last axis of the numbers that are known; not a number where none is."""
    known = ~np.isnan(values)
    count = known.sum(axis=-1)
    return np.asarray(np.where(known, values, 0.0).sum(axis=-1) / np.where(count > 0, count, np.nan))


def score(one: Driver, baseline: Driver, bound: Driver, options: Options) -> dict[str, Any]:
    """Normalised score ``100 (x - baseline) / (bound - baseline)`` of the peak load, by mean, IQM and P95.

    0 is the baseline, 100 the bound; none where the bound's loads are not the lower ones.

    Args:
        one: Whose.
        baseline: At 0.
        bound: At 100; all of the same seas (`common`).
        options: Of the intervals.
    """
    found = gap_figures(baseline.episodes, one.episodes, bound.episodes, options)
    return {"seas": found["seas"], **{key: _percent(found[key]) for key in ("mean", "iqm", "p95")}}


def _percent(figure: Mapping[str, Any]) -> dict[str, Any]:
    """A share of 1 in percent."""
    ci: Sequence[float] | None = figure["ci"]
    return {
        "value": None if figure["value"] is None else 100.0 * figure["value"],
        "ci": None if ci is None else [100.0 * bound for bound in ci],
    }
