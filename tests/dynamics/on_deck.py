"""Helicopters at rest on a deck, for the tests of the whole system."""

from __future__ import annotations

from typing import Any

import numpy as np

from ssmash_gym.dynamics.layout import STATION_ROWS, STATIONS, Par, Sta
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.vehicle import Helicopter

WHEELS = ("auxiliary", "right", "left")
PROMPT = ClawLimits(delay_s=0.0)


def at_rest(helicopter: Helicopter, n: int = 1, **keys: Any) -> Batch:
    batch = Batch(helicopter, n, claw=PROMPT, **keys)
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    return batch


def brake(batch: Batch, stations: tuple[int, ...] = (0, 1, 2)) -> None:
    for i in stations:
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] = 1.0


def loads(batch: Batch) -> np.ndarray:
    """Vertical tire loads of the three stations [N], (3, N)."""
    return np.array([batch.telemetry[f"{wheel}_vertical_load"] for wheel in WHEELS])


def weight(batch: Batch) -> np.ndarray:
    masses = [Par.MASS] + [Par.STATION + i * STATION_ROWS + Sta.MASS for i in range(STATIONS)]
    return np.sum(batch.parameters[masses], axis=0) * batch.parameters[Par.GRAVITY]
