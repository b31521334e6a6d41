"""Measure how much simulated time a second of processor time buys."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Rate:
    """Simulated seconds per second of processor time: the best and the median of several turns.

    The best says what the code can do, the median what it did on this machine with its neighbours.
    """

    best: float
    median: float

    def as_dict(self) -> dict[str, float]:
        """For JSON, rounded to what the measurement is worth."""
        return {key: float(f"{value:.4g}") for key, value in asdict(self).items()}


def rate(values: list[float]) -> Rate:
    """Best and median of several turns."""
    return Rate(max(values), statistics.median(values))


def cpu_rate(turn: Callable[[], float]) -> float:
    """One turn: simulated seconds, as `turn` returns them, per second of this process' processor time."""
    start = time.process_time()
    simulated_s = turn()
    return simulated_s / (time.process_time() - start)


def wall_rate(turn: Callable[[], float]) -> float:
    """One turn: simulated seconds per second on the wall clock."""
    start = time.perf_counter()
    simulated_s = turn()
    return simulated_s / (time.perf_counter() - start)
