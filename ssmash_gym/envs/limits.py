"""Limits: costs apart from the reward, each with its margin; and what ends an episode. One table each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.reading import Reading

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Reasons why an episode ends, the gravest first; the last two are no failures.
DIVERGENCE: Final = "divergence"
ULTIMATE: Final = "ultimate_load"  # in-plane load above the task's limit
PROBE_LOST: Final = "probe_lost"  # resultant load above what the helicopter's probe bears
OVERTURNING: Final = "overturning"
CORRIDOR: Final = "corridor"
GOAL: Final = "goal"
TIME: Final = "time"
REASONS: Final = (DIVERGENCE, ULTIMATE, PROBE_LOST, OVERTURNING, CORRIDOR, GOAL, TIME)


def _probe_in_plane(r: Reading) -> Array:
    margin = 1.0 - r.probe_peak_N / (1e3 * r.task.limits.probe_in_plane_kN)
    return np.where(r.counted, margin, 1.0)


def _main_vertical(r: Reading) -> Array:
    return np.asarray(1.0 - r.main_peak_N / (1e3 * r.task.limits.main_vertical_kN))


def _lift_off(r: Reading) -> Array:
    limit = 1e3 * r.task.limits.lift_off_kN
    return np.asarray((r.least_station_N - limit) / max(limit, 1.0))


def _roll(r: Reading) -> Array:
    return np.asarray(1.0 - r.roll_peak_rad / np.deg2rad(r.task.limits.roll_deg))


def _corridor(r: Reading) -> Array:
    return np.asarray(1.0 - r.wheel_reach_m / r.corridor_m)


# Margin of each limit over the interval's substeps: 1 far away, 0 at the limit, negative beyond it.
LIMITS: Final[Mapping[str, Callable[[Reading], Array]]] = {
    "probe_in_plane": _probe_in_plane,
    "main_vertical": _main_vertical,
    "lift_off": _lift_off,
    "roll": _roll,
    "corridor": _corridor,
}


def margins(r: Reading) -> dict[str, Array]:
    """Every margin by name, (n,) each; in units of the limit."""
    return {name: margin(r) for name, margin in LIMITS.items()}


def costs(margins: Mapping[str, Array]) -> dict[str, Array]:
    """1 for each limit that was exceeded within the interval, else 0; (n,) each."""
    return {name: (margin < 0.0).astype(np.float64) for name, margin in margins.items()}


def failed(reason: str) -> bool:
    """Whether an episode that ended so has failed: neither reached the goal nor run out of time."""
    return reason not in (GOAL, TIME)


def endings(r: Reading, margins: Mapping[str, Array]) -> dict[str, Flags]:
    """Which helicopters are in which terminal condition, the gravest first; (n,) each."""
    return {
        DIVERGENCE: r.broken,
        ULTIMATE: np.asarray(r.probe_peak_N > 1e3 * r.task.limits.probe_ultimate_kN),
        PROBE_LOST: np.asarray(r["probe_lost"] > 0.5),
        OVERTURNING: np.asarray(margins["roll"] < 0.0),
        CORRIDOR: np.asarray(margins["corridor"] < 0.0),
        GOAL: np.asarray(r.held > r.task.hold_steps),
    }
