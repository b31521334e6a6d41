"""The book of each helicopter's episode: counters, peaks over substeps, and the metrics at the end."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.reading import Reading

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass
class EpisodeBook:
    """Numbers of N running episodes; shape (N,) unless said otherwise.

    Attributes:
        steps: Control intervals since the start.
        held: Control instants in a row at which the goal's tolerances were met.
        over: Whether the episode has ended.
        command: Applied command of the last interval, (N, 2).
        progress, alignment: Potentials of the reward at the last instant.
        peak_probe_N, peak_probe_no_grace_N, peak_axial_N, peak_main_N, least_station_N, peak_roll_rad: Extremes so far.
        lifted: Whether a station was lifted in the last interval; lift_offs: how often that began.
        saturation: Sum of the intervals' shares of saturated commands.
        returned: Sum of rewards; cost: sum of costs.
        probe_N: In-plane probe load of each counted interval, its peak, (N, horizon); counted: how many.
        overloaded: counted intervals in which the in-plane probe load exceeded its cost limit.
    """

    steps: NDArray[np.int64]
    held: NDArray[np.int64]
    over: Flags
    command: Array
    progress: Array
    alignment: Array
    peak_probe_N: Array
    peak_probe_no_grace_N: Array
    peak_axial_N: Array
    peak_main_N: Array
    least_station_N: Array
    peak_roll_rad: Array
    lifted: Flags
    lift_offs: NDArray[np.int64]
    saturation: Array
    returned: Array
    cost: Array
    probe_N: NDArray[np.float32]
    counted: NDArray[np.int64]
    overloaded: NDArray[np.int64]

    @classmethod
    def blank(cls, n: int, horizon_steps: int) -> EpisodeBook:
        """A book for n helicopters whose episodes have not begun."""
        kinds: dict[str, Any] = {
            "steps": np.int64, "held": np.int64, "lift_offs": np.int64, "counted": np.int64, "overloaded": np.int64,
            "over": np.bool_, "lifted": np.bool_, "probe_N": np.float32,
        }  # fmt: skip
        shapes = {"command": (n, 2), "probe_N": (n, horizon_steps)}
        arrays = {f.name: np.zeros(shapes.get(f.name, (n,)), kinds.get(f.name, np.float64)) for f in fields(cls)}
        return cls(**arrays)

    def begin(self, columns: Columns) -> None:
        """Start the listed columns' episodes."""
        for f in fields(self):
            getattr(self, f.name)[columns] = 0
        self.least_station_N[columns] = np.inf

    def note(self, columns: Columns, r: Reading, saturation: Array) -> None:
        """Write down an interval of the listed columns."""
        probe = r.probe_peak_N
        rows = columns[r.counted]
        self.probe_N[rows, self.counted[rows]] = probe[r.counted]
        self.counted[rows] += 1
        self.overloaded[rows] += probe[r.counted] > 1e3 * r.task.limits.probe_in_plane_kN
        self._raise("peak_probe_N", rows, probe[r.counted])
        self._raise("peak_probe_no_grace_N", columns, probe)
        self._raise("peak_axial_N", columns, r.telemetry.peak_max("probe_axial"))
        self._raise("peak_main_N", columns, r.main_peak_N)
        self._raise("peak_roll_rad", columns, r.roll_peak_rad)
        least = r.least_station_N
        self.least_station_N[columns] = np.minimum(self.least_station_N[columns], least)
        lifted = least < 1e3 * r.task.limits.lift_off_kN
        self.lift_offs[columns] += lifted & ~self.lifted[columns]
        self.lifted[columns] = lifted
        self.saturation[columns] += saturation

    def _raise(self, name: str, columns: Columns, values: Array) -> None:
        book = getattr(self, name)
        book[columns] = np.maximum(book[columns], values)

    def metrics(self, k: int, r: Reading, i: int, reason: str) -> dict[str, Any]:
        """The finished episode of column k, which is row i of the reading: plain numbers, kN and degrees."""
        steps = int(self.steps[k])
        counted = int(self.counted[k])
        p95 = float(np.percentile(self.probe_N[k, :counted], 95.0)) if counted else 0.0
        return {
            "success": reason == "goal",
            "reason": reason,
            "aligned": bool(r.straight[i]) and reason != "divergence",
            "time_s": steps * r.task.control_interval_s,
            "peak_probe_kN": 1e-3 * float(self.peak_probe_N[k]),
            "peak_probe_kN_no_grace": 1e-3 * float(self.peak_probe_no_grace_N[k]),
            "p95_probe_kN": 1e-3 * p95,
            "over_limit_s": int(self.overloaded[k]) * r.task.control_interval_s,
            "peak_axial_kN": 1e-3 * float(self.peak_axial_N[k]),
            "peak_main_kN": 1e-3 * float(self.peak_main_N[k]),
            "least_station_kN": 1e-3 * float(self.least_station_N[k]),
            "peak_roll_deg": float(np.rad2deg(self.peak_roll_rad[k])),
            "lift_offs": int(self.lift_offs[k]),
            "final_yaw_deg": float(np.rad2deg(r["yaw"][i])),
            "final_lateral_m": float(r["probe_y"][i]),
            "final_to_go_m": float(r.to_go_m[i]),
            "saturation": float(self.saturation[k]) / max(steps, 1),
            "return": float(self.returned[k]),
            "cost": float(self.cost[k]),
        }

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """A copy of all numbers."""
        return {f.name: getattr(self, f.name).copy() for f in fields(self)}

    def restore(self, snapshot: dict[str, NDArray[Any]], columns: Columns | None = None) -> None:
        """Return to a snapshot, or make each helicopter a copy of the snapshot's column listed for it."""
        for name, saved in snapshot.items():
            setattr(self, name, saved.copy() if columns is None else saved[columns])
