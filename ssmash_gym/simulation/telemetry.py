"""The telemetry table: every quantity that can be read, by name, with unit, frame, meaning and thesis symbol.

Observations, rewards, limits, recordings, plots and reports pick their channels here. Sources are the kernel's
outputs (`channels.Out`, `channels.StaOut`), which also have extremes over the substeps of an interval, and state rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.channels import STATION_OUT, STATION_OUT_ROWS, Out, StaOut
from ssmash_gym.dynamics.layout import STATION_NAMES, State

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """One named quantity: SI unit, frame of its components, meaning, thesis symbol, and where it is read."""

    name: str
    unit: str
    frame: str
    meaning: str
    symbol: str
    row: int
    has_peaks: bool


def _output_channels() -> Iterator[Channel]:
    for out in Out:
        yield Channel(out.name.lower(), out.unit, out.frame, out.meaning, out.symbol, int(out), True)
    for i, station in enumerate(STATION_NAMES):
        for sta in StaOut:
            row = STATION_OUT + i * STATION_OUT_ROWS + int(sta)
            name = f"{station}_{sta.name.lower()}"
            yield Channel(name, sta.unit, sta.frame, f"{station} station: {sta.meaning}", sta.symbol, row, True)


_STATE_CHANNELS: Final = (
    ("velocity_x", "m/s", "S", "helicopter c.g. velocity over the deck, x", "u7", State.U7),
    ("velocity_y", "m/s", "S", "helicopter c.g. velocity over the deck, y", "u8", State.U8),
    ("velocity_z", "m/s", "S", "helicopter c.g. velocity over the deck, z", "u9", State.U9),
    ("roll_rate", "rad/s", "H", "angular velocity relative to the ship, x", "u10", State.U10),
    ("pitch_rate", "rad/s", "H", "angular velocity relative to the ship, y", "u11", State.U11),
    ("yaw_rate", "rad/s", "H", "angular velocity relative to the ship, z", "u12", State.U12),
    ("auxiliary_steer_rate", "rad/s", "O", "steer rate of the auxiliary station", "u14", State.U14),
    ("position_x", "m", "S", "helicopter c.g., x", "q8", State.Q8),
    ("position_y", "m", "S", "helicopter c.g., y", "q9", State.Q9),
    ("position_z", "m", "S", "helicopter c.g., z (down)", "q10", State.Q10),
    ("probe_captured", "1", "", "1 while the claw holds the probe", "", State.PROBE_CAPTURED),
    ("probe_lost", "1", "", "1 once the ultimate load has broken the probe", "", State.PROBE_LOST),
)


def _state_channels() -> Iterator[Channel]:
    for name, unit, frame, meaning, symbol, row in _STATE_CHANNELS:
        yield Channel(name, unit, frame, meaning, symbol, int(row), False)


CHANNELS: Final[Mapping[str, Channel]] = {c.name: c for c in (*_output_channels(), *_state_channels())}


def channel(name: str) -> Channel:
    """The channel called `name`.

    Raises:
        KeyError: no such channel; the message names close ones.
    """
    if name not in CHANNELS:
        import difflib

        close = difflib.get_close_matches(name, CHANNELS, n=4)
        hint = f"; close: {', '.join(close)}" if close else ""
        raise KeyError(f"telemetry has no channel {name!r}{hint}")
    return CHANNELS[name]


@dataclass(frozen=True)
class Telemetry:
    """What a batch reads after an interval; a channel is read as a copy, shape (N,), SI units.

    It looks into the batch: read it before the next interval.

    ``telemetry["probe_in_plane"]`` is the value at the end of the interval; `peak_max` and `peak_min` are the
    extremes over all its substeps, both ends included.
    """

    state: Array
    outputs: Array
    highs: Array
    lows: Array

    def __getitem__(self, name: str) -> Array:
        """Value at the end of the interval, (N,)."""
        c = channel(name)
        table = self.outputs if c.has_peaks else self.state
        return np.array(table[c.row])

    def peak_max(self, name: str) -> Array:
        """Largest value within the interval, (N,).

        Raises:
            KeyError: the channel is a state without extremes.
        """
        return self._peak(self.highs, name)

    def peak_min(self, name: str) -> Array:
        """Smallest value within the interval, (N,)."""
        return self._peak(self.lows, name)

    def peak_abs(self, name: str) -> Array:
        """Largest magnitude within the interval, (N,)."""
        return np.maximum(np.abs(self.peak_max(name)), np.abs(self.peak_min(name)))

    def _peak(self, table: Array, name: str) -> Array:
        c = channel(name)
        if not c.has_peaks:
            raise KeyError(f"channel {name!r} is a state: it has no extremes within an interval")
        return np.array(table[c.row])
