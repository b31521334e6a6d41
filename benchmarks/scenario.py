"""The job that is timed: a traverse at 0.2 m/s on a deck in irregular motion, each helicopter in its own sea."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.ship.sources import Irregular
from ssmash_gym.simulation.batch import Batch, Timing
from ssmash_gym.vehicle import load_helicopter

SUBSTEP_S = 0.002
CONTROL_INTERVAL_S = 0.1
CLAW_SPEED_MPS = 0.2
TRACK_M = 8.0
LEAD_IN_S = 8.0
DURATION_S = LEAD_IN_S + TRACK_M / CLAW_SPEED_MPS
LEAD_IN = round(LEAD_IN_S / CONTROL_INTERVAL_S)
INTERVALS = round(DURATION_S / CONTROL_INTERVAL_S)
Array = NDArray[np.float64]
SEA = Irregular.model_validate(
    {
        "roll": {"rms_deg": 2.0, "period_s": 10.0},
        "pitch": {"rms_deg": 0.7, "period_s": 8.0},
        "yaw": {"rms_deg": 0.3, "period_s": 10.0},
        "heave": {"rms_m": 0.6, "period_s": 9.0},
        "sway": {"rms_m": 0.4, "period_s": 10.0},
        "surge": {"rms_m": 0.1, "period_s": 9.0},
    }
)


def motion(seed: int) -> MotionTable:
    """One sea, ramped in from a still deck."""
    return SEA.realise(np.random.default_rng(seed)).bake(DURATION_S + 1.0, ramp_s=5.0)


class Traverse:
    """A batch that is hauled to and fro for as long as it is timed.

    Args:
        helicopter: Name in the catalogue.
        count: Helicopters in the batch.
        threads: Threads of the engine.
    """

    def __init__(self, helicopter: str, count: int, threads: int = 1) -> None:
        timing = Timing(SUBSTEP_S, CONTROL_INTERVAL_S)
        self.batch = Batch(load_helicopter(helicopter), count, timing=timing, threads=threads)
        self.count = count
        self.batch.set_motion([motion(seed) for seed in range(count)])
        self.batch.place(0.0, 0.0, 0.0)
        self._start = self.batch.snapshot()
        self._hold = np.zeros((count, 2))
        self._haul = np.zeros((count, 2))
        self._haul[:, 0] = CLAW_SPEED_MPS / self.batch.claw.speed_along_m_s
        self._done = 0

    def advance(self, intervals: int) -> float:
        """Advance every helicopter, from the start again when the track ends; simulated seconds of all of them."""
        for _ in range(intervals):
            if self._done == INTERVALS:
                self.batch.restore(self._start)
                self._done = 0
            self.batch.advance(self._hold if self._done < LEAD_IN else self._haul)
            self._done += 1
        if self.batch.diverged.any():
            raise RuntimeError("a helicopter diverged: its time must not count")
        return intervals * CONTROL_INTERVAL_S * self.count

    def right_hand_side(self) -> tuple[Array, Array, NDArray[np.int64], Array]:
        """State, parameters, modes and deck rows of the present instant: what `engine.derivative` takes."""
        batch = self.batch
        return batch.state, batch.parameters, batch.mode, batch.deck_rows(np.arange(self.count))
