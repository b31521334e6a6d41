"""The reward: one table of named terms. A new term is one function and one line in `TERMS`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.reading import Reading

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Outcome:
    """What the reward needs beyond the reading, (n,) each: the potentials' gain, and how the interval ended."""

    progress: Array
    alignment: Array
    success: Flags
    failure: Flags


def progress_potential(r: Reading) -> Array:
    """Minus the claw's distance to the goal [m]; overshoot counts as distance."""
    return np.asarray(-np.abs(r.to_go_m))


def alignment_potential(r: Reading) -> Array:
    """Minus the lack of alignment, faded in over the last metres before the goal [1].

    Each of yaw and lateral offset counts its ratio to its scale, at most 3.
    """
    w = r.task.reward
    yaw = np.minimum(np.abs(r["yaw"]) / np.deg2rad(w.alignment_yaw_deg), 3.0)
    lateral = np.minimum(np.abs(r["probe_y"]) / w.alignment_lateral_m, 3.0)
    near = np.clip(1.0 - np.abs(r.to_go_m) / w.alignment_range_m, 0.0, 1.0)
    return np.asarray(-near * (yaw + lateral))


def load_excess(r: Reading) -> Array:
    """Square of the in-plane probe load's excess over the soft limit, in soft limits; linear when large [1]."""
    w = r.task.reward
    excess = np.maximum(r.probe_peak_N / (1e3 * w.soft_limit_kN) - 1.0, 0.0)
    start = w.load_linear_from
    shaped = np.where(excess < start, excess * excess, start * (2.0 * excess - start))
    return np.where(r.counted, shaped, 0.0)


def _progress(r: Reading, o: Outcome) -> Array:
    return np.asarray(r.task.reward.progress_per_m * o.progress)


def _alignment(r: Reading, o: Outcome) -> Array:
    return np.asarray(r.task.reward.alignment * o.alignment)


def _load(r: Reading, o: Outcome) -> Array:
    return np.asarray(-r.task.reward.load_per_s * r.task.control_interval_s * load_excess(r))


def _peak(r: Reading, o: Outcome) -> Array:
    soft_N = 1e3 * r.task.reward.soft_limit_kN
    after, before = (np.maximum(peak / soft_N - 1.0, 0.0) for peak in (r.episode_peak_N, r.peak_before_N))
    return np.asarray(-r.task.reward.peak * (after - before))


def _command_rate(r: Reading, o: Outcome) -> Array:
    change = r.command - r.previous
    return np.asarray(-r.task.reward.command_change * (change[:, 0] * change[:, 0] + change[:, 1] * change[:, 1]))


def _time(r: Reading, o: Outcome) -> Array:
    w = r.task.reward
    return np.where(r.time_s > w.time_free_s + 1e-9, -w.time_per_s * r.task.control_interval_s, 0.0)


def _success(r: Reading, o: Outcome) -> Array:
    return np.asarray(r.task.reward.success * o.success)


def _failure(r: Reading, o: Outcome) -> Array:
    return np.asarray(-r.task.reward.failure * o.failure)


TERMS: Final[Mapping[str, Callable[[Reading, Outcome], Array]]] = {
    "progress": _progress,
    "alignment": _alignment,
    "load": _load,
    "peak": _peak,
    "command_rate": _command_rate,
    "time": _time,
    "success": _success,
    "failure": _failure,
}


def rewards(r: Reading, o: Outcome) -> dict[str, Array]:
    """Every term by name, (n,) each; helicopters whose numbers are broken get the failure term alone."""
    terms = {name: term(r, o) for name, term in TERMS.items()}
    if r.broken.any():
        for name in terms:
            if name != "failure":
                terms[name] = np.where(r.broken, 0.0, terms[name])
    return terms


def total(terms: Mapping[str, Array], n: int) -> Array:
    """Sum of named terms, in their order, (n,)."""
    found = np.zeros(n)
    for values in terms.values():
        found = found + values
    return found
