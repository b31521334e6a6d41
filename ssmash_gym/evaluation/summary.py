"""From rows of episodes to the numbers of ``summary.json``."""

from __future__ import annotations

import itertools
import math
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.envs.limits import LIMITS
from ssmash_gym.evaluation.statistics import bootstrap, mean, median, p95, share

ON_TIME: Final = 1.2  # a success counts as on time within this factor of the other policy's median time
BANDS_G: Final = (0.0, 0.02, 0.04, 0.06, 0.08, math.inf)  # of the sea's lateral specific force, long-run RMS [g]
FEWEST: Final = 20  # episodes of a band from which on it has a 95th percentile: below, that is all but the largest one


def policy_summary(episodes: pl.DataFrame) -> dict[str, Any]:
    """Numbers of one policy.

    A failed episode counts with the ultimate load. An episode that ran out of time counts with its own peak, and not
    as a success. Times are those of successes; without any, those of all episodes. ``aligned_rate`` is the share that
    ended straight and on the centre line, wherever along the track, and without a failure; ``cost_rates`` are the
    shares of episodes in which a limit was exceeded at least once. ``outside_validity_rate`` is the share in seas for
    which the model of the ship's motion is not valid, ``by_lateral_g`` the same numbers by severity (`bands`). The
    success rate has Wilson's 95 % interval, loads have 95 % bootstrap intervals.
    """
    success, peak = numbers(episodes, "success"), numbers(episodes, "scored_peak_kN")
    aligned = numbers(episodes, "aligned") * (1.0 - numbers(episodes, "failed"))
    succeeded, load, average = share(success), bootstrap(peak, p95), bootstrap(peak, mean)
    return {
        "episodes": episodes.height,
        "success_rate": succeeded.value,
        "success_rate_ci": succeeded.interval,
        "aligned_rate": float(np.mean(aligned)),
        "failure_rate": float(np.mean(numbers(episodes, "failed"))),
        "peak_probe_kN": {
            "mean": average.value,
            "mean_ci": average.interval,
            "p95": load.value,
            "p95_ci": load.interval,
            "p95_no_grace": float(p95(_no_grace(episodes))),
        },
        "p95_probe_kN": {"mean": float(np.mean(numbers(episodes, "p95_probe_kN")))},
        "peak_main_kN": {"p95": float(p95(numbers(episodes, "peak_main_kN")))},
        "least_station_kN": {"p5": float(np.percentile(numbers(episodes, "least_station_kN"), 5.0))},
        "time_s": {"median": float(median(times(episodes)))},
        "lift_off_rate": float(np.mean(numbers(episodes, "lift_offs") > 0.0)),
        "cost_rates": {name: float(np.mean(numbers(episodes, f"cost_{name}") > 0.0)) for name in LIMITS},
        "final_yaw_deg": {"mean_abs": float(np.mean(np.abs(numbers(episodes, "final_yaw_deg"))))},
        "return": {"mean": float(np.mean(numbers(episodes, "return")))},
        "outside_validity_rate": float(np.mean(1.0 - numbers(episodes, "within_validity"))),
        "by_lateral_g": bands(episodes),
        "reasons": {str(name): int(count) for name, count in sorted(episodes["reason"].value_counts().iter_rows())},
    }


def bands(episodes: pl.DataFrame) -> list[dict[str, Any]]:
    """Peak probe loads by severity of the sea: a row for each band of `BANDS_G` that holds an episode.

    Args:
        episodes: Rows as of `ssmash_gym.evaluation.episodes.run_episodes`.

    Returns:
        For each band its bounds ``from_g`` and ``to_g`` (None: no bound), ``episodes``, ``success_rate`` with its
        interval ``success_rate_ci``, and ``peak_probe_kN`` with ``mean`` and ``p95`` (None with fewer than `FEWEST`
        episodes); a failed episode counts with the ultimate load.
    """
    severity = numbers(episodes, "sea_lateral_g")
    success, peak = numbers(episodes, "success"), numbers(episodes, "scored_peak_kN")
    found = []
    for low, high in itertools.pairwise(BANDS_G):
        inside = (severity >= low) & (severity < high)
        if inside.any():
            succeeded, loads = share(success[inside]), peak[inside]
            highest = float(p95(loads)) if loads.size >= FEWEST else None
            found.append(
                {
                    "from_g": low,
                    "to_g": high if math.isfinite(high) else None,
                    "episodes": loads.size,
                    "success_rate": succeeded.value,
                    "success_rate_ci": succeeded.interval,
                    "peak_probe_kN": {"mean": float(np.mean(loads)), "p95": highest},
                }
            )
    return found


def comparison(episodes: pl.DataFrame, other: pl.DataFrame) -> dict[str, Any]:
    """A policy against another one on the same seeds; intervals are of pairs of episodes.

    ``on_time_rate`` is the share of all episodes that succeeded within 1.2 times the other's median time.
    """
    ours, theirs = numbers(episodes, "scored_peak_kN"), numbers(other, "scored_peak_kN")
    highest, average = bootstrap(ours, p95, over=theirs), bootstrap(ours, mean, over=theirs)
    allowed_s = ON_TIME * float(median(times(other)))
    on_time = numbers(episodes, "success") * (numbers(episodes, "time_s") <= allowed_s)
    return {
        "p95_ratio": highest.value,
        "p95_ratio_ci": highest.interval,
        "mean_ratio": average.value,
        "mean_ratio_ci": average.interval,
        "lower_peak_rate": float(np.mean(ours < theirs)),
        "allowed_time_s": allowed_s,
        "on_time_rate": float(np.mean(on_time)),
    }


def numbers(episodes: pl.DataFrame, column: str) -> NDArray[np.float64]:
    """A column as floats, (episodes,)."""
    return episodes[column].cast(pl.Float64).to_numpy()


def times(episodes: pl.DataFrame) -> NDArray[np.float64]:
    """Durations of the successes [s]; of all episodes where there is none."""
    succeeded = episodes.filter(pl.col("success"))
    return numbers(succeeded if succeeded.height else episodes, "time_s")


def _no_grace(episodes: pl.DataFrame) -> NDArray[np.float64]:
    """Peak probe loads counted from the start [kN], failures with the ultimate load."""
    counted, all_of_it = numbers(episodes, "scored_peak_kN"), numbers(episodes, "peak_probe_kN_no_grace")
    return np.where(numbers(episodes, "failed") > 0.0, counted, all_of_it)
