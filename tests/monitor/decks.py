"""Decks for the tests: records as a file holds them, line by line."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ssmash_gym.monitor import Settings
from ssmash_gym.ship import Motion, parse_motion, write_shipmo

ROUGH = {"type": "seaway", "ship": "frigate", "hs_m": 4.5, "tp_s": 11.0, "heading_deg": 80.0, "speed_kn": 5.0}
CALM = {"type": "seaway", "ship": "frigate", "sea_state": 2, "heading_deg": 150.0, "speed_kn": 5.0}
STEP_S = 0.2


def quick(**changes: Any) -> Settings:
    """Settings that answer in a moment."""
    given: dict[str, Any] = {"copies": 8, "horizon_s": 6.0, "past_s": 40.0, "least_past_s": 25.0, "threads": 1}
    return Settings(**{**given, **changes})


def motion(rough: bool, seed: int = 1) -> Motion:
    return parse_motion(ROUGH if rough else CALM).realise(np.random.default_rng(seed))


@functools.cache
def lines(rough: bool = False, duration_s: float = 34.0, step_s: float = STEP_S) -> tuple[str, ...]:
    """A record, comments and names included."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_shipmo(Path(folder) / "deck.csv", motion(rough), step_s, duration_s, comments=("a record",))
        return tuple(path.read_text(encoding="utf-8").splitlines())


def changed(line: str, column: int, value: str) -> str:
    """A row with another word in one column."""
    words = line.split(",")
    words[column] = value
    return ",".join(words)
