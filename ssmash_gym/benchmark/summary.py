"""From rows to ``benchmark.json``: who is compared with whom, figures, trials, and what they were made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import polars as pl

import ssmash_gym
from ssmash_gym.benchmark.admission import Entry
from ssmash_gym.benchmark.figures import Driver, common, drivers, own_figures, pair_figures, score
from ssmash_gym.benchmark.measures import BAND
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.evaluation.study_entrants import code
from ssmash_gym.evaluation.study_figures import Options
from ssmash_gym.progress import progress_bar
from ssmash_gym.trials.trial import sources

BENCHMARK = "benchmark.json"


@dataclass(frozen=True)
class Asked:
    """What a benchmark was asked for.

    Attributes:
        baseline: Name of the policy at the score's 0.
        bound: Name of the one at 100; empty where there is none, and `no_bound` says why.
        delays_ms: Added delays [ms].
        identities: Hashes of the programs by name.
        learned_from: Seeds of the recorded episodes that agents have learned from, by name.
    """

    baseline: str
    bound: str
    no_bound: str
    delays_ms: tuple[float, ...]
    identities: dict[str, str]
    learned_from: dict[str, list[int]]


def summarised(
    entries: Sequence[Entry],
    trials: pl.DataFrame,
    programs: pl.DataFrame,
    beside: pl.DataFrame,
    condition: Condition,
    asked: Asked,
    *,
    options: Options | None = None,
    shown: bool = True,
) -> dict[str, Any]:
    """All figures of a benchmark, ready for JSON.

    Args:
        entries: All trials, also those that do not count.
        trials: Rows of recorded trials.
        programs: Rows of programs.
        beside: Rows of the baseline in all seas of the learning curves.
        condition: What was simulated.
        asked: What was asked for.
        options: Of the intervals.
        shown: Whether a bar shows the progress.
    """
    options = options or Options()
    compared = drivers(trials.filter(pl.col("counts")), programs)
    with progress_bar("intervals", shown=shown) as advance:
        found = {}
        for k, one in enumerate(compared):
            advance(0.3 * k / len(compared), f"figures of {one.name}")
            found[one.name] = {**_about(one), **_repeated(trials, one), **own_figures(one, options)}
        whom = _pairs(compared, asked.baseline)
        pairs = []
        for k, pair in enumerate(whom):
            advance(0.3 + 0.7 * k / len(whom), f"{pair[0].name} and {pair[1].name}")
            pairs += _pair(*pair, options)
    return {
        "versions": {"ssmash_gym": ssmash_gym.__version__, "code": code(), "sources": sources()},
        "configuration": condition.configuration,
        "condition": {"name": condition.name, "description": condition.description or condition.scenario.description},
        "limits_kN": {
            "probe_in_plane": condition.task.limits.probe_in_plane_kN,
            "ultimate": condition.task.limits.probe_ultimate_kN,
        },
        "interval_s": condition.task.control_interval_s,
        "horizon_s": condition.task.horizon_s,
        "seeds": sorted(trials.filter(pl.col("counts"))["seed"].unique().to_list()),
        "baseline": asked.baseline,
        "bound": asked.bound or None,
        "no_bound": asked.no_bound or None,
        "delays_ms": list(asked.delays_ms),
        "identities": asked.identities,
        "learned_from": asked.learned_from,
        "level": options.level,
        "resamples": options.resamples,
        "reversal_band": BAND,
        "drivers": found,
        "pairs": pairs,
        "scores": _scores(compared, asked, options),
        "learning": _learning(trials, beside),
        "replayed": _replayed(trials),
        "trials": [_trial(one) for one in entries],
    }


def _about(one: Driver) -> dict[str, Any]:
    return {
        "kind": one.kind,
        "base": one.base,
        "delay_ms": one.delay_ms,
        "pooled": one.pooled,
        "members": list(one.members),
        "seas": int(one.episodes.seas.size),
        "episodes": int(one.episodes.codes.size),
    }


def _repeated(trials: pl.DataFrame, one: Driver) -> dict[str, Any]:
    """How many of a recorded driver's seas counted at a later attempt only, and the mean peak load without them."""
    own = trials.filter(pl.col("counts"), pl.col("driver").is_in(one.members), pl.col("seed").is_in(one.episodes.seas))
    if not one.at_the_claw or own["attempt"].max() == 1:
        return {"repeated": 0, "first_attempts_kN": None}
    first = own.filter(pl.col("attempt") == 1)["scored_peak_kN"].mean()
    return {"repeated": own.filter(pl.col("attempt") > 1).height, "first_attempts_kN": first}


def _pairs(compared: Sequence[Driver], baseline: str) -> list[tuple[Driver, Driver]]:
    """Who is compared: all who were recorded with all programs, and all programs with the baseline."""
    recorded = [one for one in compared if one.at_the_claw]
    programs = [one for one in compared if not one.at_the_claw]
    base = next(one for one in programs if one.name == baseline)
    found = [(one, program) for one in recorded for program in programs]
    return found + [(program, base) for program in programs if program.base != baseline or program.delay_ms]


def _pair(ours: Driver, theirs: Driver, options: Options) -> list[dict[str, Any]]:
    """Two drivers in the seas that both have met; nothing where there is none."""
    a, b = common(ours, theirs)
    if not a.episodes.seas.size:
        return []
    return [{"driver": ours.name, "other": theirs.name, **pair_figures(a, b, options)}]


def _scores(compared: Sequence[Driver], asked: Asked, options: Options) -> dict[str, Any]:
    """The normalised scores by driver; empty without a bound."""
    by_name = {one.name: one for one in compared}
    if not asked.bound:
        return {}
    found = {}
    for name, one in by_name.items():
        if name in (asked.baseline, asked.bound):
            continue
        own, base, far = common(one, by_name[asked.baseline], by_name[asked.bound])
        if own.episodes.seas.size:
            found[name] = score(own, base, far, options)
    return found


def _learning(trials: pl.DataFrame, beside: pl.DataFrame) -> dict[str, list[dict[str, Any]]]:
    """Every trial of each driver in the order in which they were driven, with the baseline's load in the same sea."""
    kept = ("phase", "number", "seed", "scored_peak_kN", "baseline_kN", "success", "time_s", "over_limit_s", "place")
    load = beside.select("seed", pl.col("scored_peak_kN").alias("baseline_kN"))
    trials = trials.join(load, on="seed", how="left", maintain_order="left")
    found = {}
    for name in sorted(trials["driver"].unique().to_list()):
        own = trials.filter(pl.col("driver") == name)  # rows lie in that order
        found[name] = [{"trial": k + 1, **row} for k, row in enumerate(own.select(kept).iter_rows(named=True))]
    return found


def _replayed(trials: pl.DataFrame) -> dict[str, Any]:
    """How many trials came out bit for bit, of how many, and how far apart the peak loads of the others are [kN]."""
    return {
        "agree": int(trials["agrees"].sum()),
        "of": trials.height,
        "apart_kN": float(trials["apart_kN"].max()),  # type: ignore[arg-type]
    }


def _trial(one: Entry) -> dict[str, Any]:
    """A trial as the table of trials shows it."""
    timing = one.trial.about["timing"]
    return {
        "place": one.place,
        "driver": one.driver,
        "scripted": one.scripted,
        "phase": one.phase,
        "number": one.number,
        "attempt": one.attempt,
        "seed": one.trial.seed,
        "counts": one.counts,
        "reason": one.reason,
        "steps": timing["steps"],
        "late_share": timing["late_share"],
        "latency_ms": timing["latency_ms"],
        "version": one.trial.about["version"],
    }
