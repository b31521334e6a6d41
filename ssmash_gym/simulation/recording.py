"""Recordings: telemetry against time in one Parquet file, with units and the resolved configuration inside."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.files import whole_file
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.telemetry import CHANNELS, Channel, channel

Array = NDArray[np.float64]
PEAK_SUFFIXES = ("_max", "_min")  # extremes over the substeps of the interval that ends at this row


class Recorder:
    """Collects the telemetry of some columns of a batch, one row a control interval and helicopter.

    Args:
        batch: what is recorded.
        channels: names of the telemetry table; None records all.
        columns: helicopters; None records all.
        peaks: also record each channel's extremes within the interval, where it has them.

    Raises:
        KeyError: no such channel.
    """

    def __init__(
        self,
        batch: Batch,
        channels: Sequence[str] | None = None,
        columns: Sequence[int] | None = None,
        *,
        peaks: bool = True,
    ) -> None:
        self.batch = batch
        self.channels = [channel(name) for name in (channels if channels is not None else CHANNELS)]
        self.columns = batch.columns(columns)
        self.peaks = peaks
        self._rows: list[dict[str, Array]] = []

    def __len__(self) -> int:
        """Samples taken so far."""
        return len(self._rows)

    def sample(self, **extra: Array) -> None:
        """Record the batch as it stands after an interval; `extra` adds columns of shape (n,)."""
        telemetry = self.batch.telemetry
        row: dict[str, Array] = {
            "time_s": self.batch.time_s[self.columns],
            "helicopter": self.columns.astype(np.float64),
        }
        for c in self.channels:
            row[c.name] = telemetry[c.name][self.columns]
            if self.peaks and c.has_peaks:
                row[c.name + "_max"] = telemetry.peak_max(c.name)[self.columns]
                row[c.name + "_min"] = telemetry.peak_min(c.name)[self.columns]
        row.update({name: np.asarray(values, dtype=np.float64) for name, values in extra.items()})
        self._rows.append(row)

    def table(self) -> pl.DataFrame:
        """Everything recorded, one row a sample and helicopter, in time order."""
        if not self._rows:
            return pl.DataFrame()
        names = self._rows[0]
        frame = pl.DataFrame({name: np.concatenate([row[name] for row in self._rows]) for name in names})
        return frame.with_columns(pl.col("helicopter").cast(pl.Int64))

    def write(self, path: str | Path, configuration: Mapping[str, Any]) -> None:
        """Write the Parquet file whole or not at all.

        Args:
            path: file to write.
            configuration: the resolved configuration, JSON-able: what made this recording (with seed and version).
        """
        write_recording(path, self.table(), self.channels, configuration)


def write_recording(
    path: str | Path, table: pl.DataFrame, channels: Sequence[Channel], configuration: Mapping[str, Any]
) -> None:
    """Write a recording whole or not at all.

    Args:
        path: file to write.
        table: what was recorded, columns named as the channels.
        channels: what they are.
        configuration: the resolved configuration, JSON-able: what made this recording (with seed and version).
    """
    from ssmash_gym import __version__

    units = {c.name: {"unit": c.unit, "frame": c.frame, "meaning": c.meaning} for c in channels}
    metadata = {
        "ssmash_gym.version": __version__,
        "ssmash_gym.units": json.dumps(units),
        "ssmash_gym.configuration": json.dumps(dict(configuration)),
    }
    with whole_file(path) as temporary:
        table.write_parquet(temporary, metadata=metadata)


def telemetry_frame(
    time_s: Array, helicopter: Array, states: Array, outputs: Array, highs: Array, lows: Array,
    channels: Sequence[Channel],
) -> pl.DataFrame:  # fmt: skip
    """Channels, and their extremes where they have them, from the kernel's tables (rows, m) at times (m,) [s]."""
    columns: dict[str, Array] = {"time_s": time_s, "helicopter": helicopter}
    for c in channels:
        columns[c.name] = (outputs if c.has_peaks else states)[c.row]
        if c.has_peaks:
            columns[c.name + "_max"], columns[c.name + "_min"] = highs[c.row], lows[c.row]
    return pl.DataFrame(columns).with_columns(pl.col("helicopter").cast(pl.Int64))


def read_recording(path: str | Path) -> tuple[pl.DataFrame, dict[str, Any]]:
    """A recording's table and what it says of itself: ``version``, ``units``, ``configuration``."""
    raw = pl.read_parquet_metadata(path)
    about = {
        "version": raw["ssmash_gym.version"],
        "units": json.loads(raw["ssmash_gym.units"]),
        "configuration": json.loads(raw["ssmash_gym.configuration"]),
    }
    return pl.read_parquet(path), about
