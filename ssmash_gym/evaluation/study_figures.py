"""Figures of a study: one policy in one condition, and two policies in the same seas, all with intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.evaluation.statistics import (
    LEVEL,
    RESAMPLES,
    Estimate,
    estimates,
    iqm,
    known_median,
    mean,
    p95,
    ratio,
    share,
)
from ssmash_gym.evaluation.study_rows import StudyRows

Array = NDArray[np.float64]
Codes = NDArray[np.int64]
SHARES: Final = ("success", "aligned", "failed", "corridor")  # of zeros and ones
MEANS: Final = ("over_limit_share", "lift_offs", "lift_offs_per_min", "final_yaw_deg")


@dataclass(frozen=True)
class Episodes:
    """The numbers of one policy in one condition.

    Attributes:
        seas: Episode seeds, (seas,).
        training_seeds: Of the rows of each table; one None where nothing was trained.
        tables: By name, (training seeds, seas) each.
    """

    seas: NDArray[np.int64]
    training_seeds: list[int | None]
    tables: dict[str, Array]

    @classmethod
    def of(cls, rows: StudyRows, condition: str, policy: str, seas: Sequence[int] | NDArray[np.int64]) -> Episodes:
        """Take what figures are made of out of a study's rows."""

        def table(column: str) -> Array:
            return rows.table(condition, policy, column, seas)

        success, failed, time_s = table("success"), table("failed"), table("time_s")
        tables = {
            "peak_kN": table("scored_peak_kN"),
            "main_kN": table("peak_main_kN"),
            "success": success,
            "aligned": table("aligned") * (1.0 - failed),
            "failed": failed,
            "corridor": np.where(table("cost_corridor") > 0.0, 1.0, 0.0),
            "over_limit_share": table("over_limit_s") / time_s,
            "lift_offs": table("lift_offs"),
            "lift_offs_per_min": table("lift_offs") / (time_s / 60.0),
            "final_yaw_deg": np.abs(table("final_yaw_deg")),
            "time_s": np.where(success > 0.0, time_s, np.nan) if success.any() else time_s,
        }
        return cls(np.asarray(seas), rows.seeds(condition, policy), tables)

    @property
    def codes(self) -> Codes:
        """Numbers of the episodes, (training seeds, seas)."""
        return np.arange(len(self.training_seeds) * self.seas.size).reshape(-1, self.seas.size)

    def at(self, name: str, codes: Codes) -> Array:
        """A number of the episodes of those codes, of the codes' shape."""
        return np.asarray(self.tables[name].ravel()[codes])

    def ordered(self, name: str, codes: Codes) -> Array:
        """The same from the smallest to the largest: percentiles of it are found several times as fast."""
        return np.sort(self.at(name, codes), axis=-1)


@dataclass(frozen=True)
class Options:
    """How intervals are made: number of resamples, share that they cover."""

    resamples: int = RESAMPLES
    level: float = LEVEL


def figure(estimate: Estimate) -> dict[str, Any]:
    """A figure as it stands in ``summary.json``; None for what there is not."""
    value = None if math.isnan(estimate.value) else estimate.value
    ci = None if math.isnan(estimate.low) or value is None else estimate.interval
    return {"value": value, "ci": ci}


def policy_figures(episodes: Episodes, options: Options) -> dict[str, Any]:
    """Figures of one policy in one condition.

    A failed episode counts with the ultimate load. Times are those of the successes; without any, of all episodes.

    Args:
        episodes: Its episodes.
        options: Of the intervals.
    """
    found = estimated([episodes], lambda codes: _own(episodes, codes), options)
    load = {key: found.pop(f"peak_{key}") for key in ("p95", "mean", "iqm")}
    main = {key: found.pop(f"main_{key}") for key in ("p95", "mean")}
    document: dict[str, Any] = {
        "episodes": episodes.codes.size,
        "seas": int(episodes.seas.size),
        "training_seeds": [seed for seed in episodes.training_seeds if seed is not None],
        **{name: share_figure(episodes, name, found.pop(name), options) for name in SHARES},
        "peak_probe_kN": load,
        "peak_main_kN": main,
        **found,
    }
    if len(episodes.training_seeds) > 1:
        document["per_seed"] = _per_seed(episodes)
    return document


def beyond_hold(episodes: Episodes, hold: Episodes, options: Options) -> dict[str, Any]:
    """What a policy adds to standing still in the same seas.

    Standing still lasts until the time limit, longer than a drive: hence lift-offs a minute too.

    Args:
        episodes: Those of the policy.
        hold: Those of standing still.
        options: Of the intervals.

    Returns:
        ``excess_kN`` of the peak load, and ``excess`` of lift-offs.
    """
    peak = (episodes.tables["peak_kN"] - hold.tables["peak_kN"]).ravel()
    lift_offs = (episodes.tables["lift_offs"] - hold.tables["lift_offs"]).ravel()
    rate = (episodes.tables["lift_offs_per_min"] - hold.tables["lift_offs_per_min"]).ravel()

    def found(codes: Codes) -> dict[str, Array]:
        load = np.sort(peak[codes], axis=-1)
        return {
            "p95": p95(load),
            "mean": mean(load),
            "iqm": iqm(load),
            "lift_offs": mean(lift_offs[codes]),
            "lift_offs_per_min": mean(rate[codes]),
            "more_lift_offs_share": mean(lift_offs[codes] > 0.0),
        }

    figures = estimated([episodes], found, options)
    loads = {key: figures.pop(key) for key in ("p95", "mean", "iqm")}
    return {"excess_kN": loads, "excess": figures}


def pair_figures(episodes: Episodes, other: Episodes, options: Options) -> dict[str, Any]:
    """Figures of one policy against another one in the same seas; intervals are paired by sea.

    Differences are the first minus the other, ratios the first over the other; ``p95_kN`` and ``other_p95_kN`` are
    those of the seas that both have met.
    """
    below = (episodes.tables["peak_kN"][:, None] < other.tables["peak_kN"][None]).mean(axis=1)

    def found(ours: Codes, theirs: Codes) -> dict[str, Array]:
        a, b = episodes.ordered("peak_kN", ours), other.ordered("peak_kN", theirs)
        highest, average, middle = ((statistic(a), statistic(b)) for statistic in (p95, mean, iqm))
        main = p95(episodes.ordered("main_kN", ours)) - p95(other.ordered("main_kN", theirs))
        times = known_median(episodes.at("time_s", ours)), known_median(other.at("time_s", theirs))
        differences = {
            f"{name}_difference": mean(episodes.at(name, ours)) - mean(other.at(name, theirs))
            for name in ("success", "aligned", "lift_offs", "lift_offs_per_min", "corridor")
        }
        return {
            "p95_kN": highest[0],
            "other_p95_kN": highest[1],
            "p95_difference_kN": highest[0] - highest[1],
            "p95_ratio": ratio(*highest),
            "mean_difference_kN": average[0] - average[1],
            "mean_ratio": ratio(*average),
            "iqm_difference_kN": middle[0] - middle[1],
            "main_p95_difference_kN": main,
            "time_ratio": ratio(*times),
            "lower_peak_share": mean(below.ravel()[ours]),
            **differences,
        }

    return {"seas": int(episodes.seas.size), **estimated([episodes, other], found, options)}


def gap_figures(law: Episodes, policy: Episodes, clairvoyant: Episodes, options: Options) -> dict[str, Any]:
    """How much of the way from a law's peak loads to the clairvoyant's a policy goes; None where there is no way.

    0 is the law, 1 the clairvoyant; by mean, 95th percentile and interquartile mean of the peak load.
    """

    def found(*codes: Codes) -> dict[str, Array]:
        loads = [one.ordered("peak_kN", drawn) for one, drawn in zip((law, policy, clairvoyant), codes, strict=True)]
        gaps = {}
        for name, statistic in (("mean", mean), ("p95", p95), ("iqm", iqm)):
            high, here, low = (statistic(load) for load in loads)
            gaps[name] = ratio(high - here, high - low)
        return gaps

    return {"seas": int(law.seas.size), **estimated([law, policy, clairvoyant], found, options)}


def _own(episodes: Episodes, codes: Codes) -> dict[str, Array]:
    peak, main = episodes.ordered("peak_kN", codes), episodes.ordered("main_kN", codes)
    return {
        "peak_p95": p95(peak),
        "peak_mean": mean(peak),
        "peak_iqm": iqm(peak),
        "main_p95": p95(main),
        "main_mean": mean(main),
        "time_s": known_median(episodes.at("time_s", codes)),
        **{name: mean(episodes.at(name, codes)) for name in (*SHARES, *MEANS)},
    }


def _per_seed(episodes: Episodes) -> list[dict[str, Any]]:
    """Each training seed by itself."""
    return [
        {
            "training_seed": seed,
            "success": float(np.mean(episodes.tables["success"][k])),
            "p95_kN": float(p95(episodes.tables["peak_kN"][k])),
            "mean_kN": float(np.mean(episodes.tables["peak_kN"][k])),
        }
        for k, seed in enumerate(episodes.training_seeds)
    ]


def share_figure(episodes: Episodes, name: str, found: dict[str, Any], options: Options) -> dict[str, Any]:
    """A share with Wilson's interval; of several training seeds with the wider bounds of the bootstrap and Wilson's.

    Wilson's is then that of so many seas with the mean share: near 0 and 1 the bootstrap alone is too narrow, and has
    no width where all are hits.
    """
    table = episodes.tables[name]
    if table.shape[0] == 1:
        return figure(share(table[0], level=options.level))
    seas = table.shape[1]
    wilson = share(np.arange(seas) < round(float(table.mean()) * seas), level=options.level)
    low, high = found["ci"] if found["ci"] is not None else wilson.interval
    return {"value": found["value"], "ci": [min(low, wilson.low), max(high, wilson.high)]}


def estimated(samples: Sequence[Episodes], figures: Any, options: Options) -> dict[str, Any]:
    """Named figures of episodes with their intervals, as they stand in ``summary.json``.

    Args:
        samples: The episodes of one policy, or of several in the same seas.
        figures: Function of as many numbers of episodes as there are samples, ``(..., episodes)``; gives (...) by name.
        options: Of the intervals.
    """
    names: list[str] = []

    def stacked(*codes: Codes) -> Array:
        found = figures(*codes)
        names[:] = list(found)
        return np.stack([np.asarray(values, dtype=np.float64) for values in found.values()])

    codes = [one.codes for one in samples]
    found = estimates(codes, stacked, resamples=options.resamples, level=options.level)
    shown = {name: figure(estimate) for name, estimate in zip(names, found, strict=True)}
    if samples[0].seas.size < 2:  # one sea says nothing about others
        return {name: {"value": one["value"], "ci": None} for name, one in shown.items()}
    return shown
