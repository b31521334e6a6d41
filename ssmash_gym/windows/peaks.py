"""What an episode leaves in its row beside the environment's metrics: extremes over its substeps, and distance slid.

A new column is one entry of `PEAKS`; a limit on it is one of `criteria.CRITERIA`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.channels import Out
from ssmash_gym.dynamics.layout import STATION_NAMES
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.reading import Reading
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

Array = NDArray[np.float64]
Columns = NDArray[np.int64]
_PROBE: Final = slice(int(Out.PROBE_FX), int(Out.PROBE_AXIAL) + 1)  # rows that the grace is for
AT_THE_LIMIT: Final = 0.999  # of the tires' friction: they slide


@dataclass(frozen=True)
class Extreme:
    """A column of an episode's row that the extremes of all its substeps tell.

    Attributes:
        meaning: In words, with the unit.
        of: Its value of each helicopter, (n,), from the extremes over the episode.
        after_grace: Whether they count from the task's grace on, as the probe's loads do.
    """

    meaning: str
    of: Callable[[Telemetry], Array]
    after_grace: bool = False


def _largest(t: Telemetry, channel: str) -> Array:
    """Largest of the three stations."""
    return np.asarray(np.max([t.peak_max(f"{name}_{channel}") for name in STATION_NAMES], axis=0))


def _largest_magnitude(t: Telemetry, channel: str) -> Array:
    return np.asarray(np.max([t.peak_abs(f"{name}_{channel}") for name in STATION_NAMES], axis=0))


PEAKS: Final[Mapping[str, Extreme]] = {
    "peak_probe_x_kN": Extreme(
        "largest probe force along the helicopter, either way [kN]", lambda t: 1e-3 * t.peak_abs("probe_fx"), True
    ),
    "peak_probe_y_kN": Extreme(
        "largest probe force across the helicopter, either way [kN]", lambda t: 1e-3 * t.peak_abs("probe_fy"), True
    ),
    "peak_auxiliary_kN": Extreme(
        "largest vertical load of the auxiliary station [kN]", lambda t: 1e-3 * t.peak_max("auxiliary_vertical_load")
    ),
    "peak_lateral_tire_kN": Extreme(
        "largest lateral tire force of a station [kN]", lambda t: 1e-3 * _largest_magnitude(t, "lateral_load")
    ),
    "peak_friction_use": Extreme(
        "largest share of a tire's friction limit in use [1]", lambda t: _largest(t, "friction_use")
    ),
    "peak_tire_vertical_mm": Extreme(
        "largest vertical tire deflection [mm]", lambda t: 1e3 * _largest(t, "tire_vertical_deflection_largest")
    ),
    "peak_tire_lateral_mm": Extreme(
        "largest lateral tire deflection [mm]",
        lambda t: 1e3 * _largest_magnitude(t, "tire_lateral_deflection_largest"),
    ),
    "peak_yaw_deg": Extreme(
        "largest yaw relative to the track, either way [deg]", lambda t: np.rad2deg(t.peak_abs("yaw"))
    ),
    "peak_deck_roll_deg": Extreme(
        "largest roll of the ship, either way [deg]", lambda t: np.rad2deg(t.peak_abs("deck_roll"))
    ),
    "peak_deck_pitch_deg": Extreme(
        "largest pitch of the ship, either way [deg]", lambda t: np.rad2deg(t.peak_abs("deck_pitch"))
    ),
}
# What needs more than extremes; kept interval by interval.
CLEARANCE: Final = "least_clearance_m"  # least distance of a wheel from the corridor's wall
TILT: Final = "peak_deck_tilt_deg"  # largest angle between the deck's normal and apparent gravity, at control instants
OLEO: Final = "peak_oleo_share"  # largest share of a station's stroke in use
SLIDING: Final = "sliding_m"  # largest distance slid by a station
COLUMNS: Final = (*PEAKS, CLEARANCE, TILT, OLEO, SLIDING)


class PeakBook:
    """Peaks of running episodes.

    Sliding is the way that a station's contact moves across its wheels' plane (and along it where the wheels cannot
    roll) over the deck, added up over the control intervals in which its tires have reached the friction limit. Tires
    creep sideways below that limit too; that is no sliding, and does not count.

    Args:
        core: The episodes; they stand at their start.
        count: How many.
    """

    def __init__(self, core: TraverseBatch, count: int) -> None:
        self._strokes = strokes(core.starter.helicopter)
        self._rolls = rolls(core.starter.helicopter)
        rows = core.telemetry.outputs.shape[0]
        self._highs, self._lows = np.full((rows, count), -np.inf), np.full((rows, count), np.inf)
        self._counted = np.zeros((rows, count)), np.zeros((rows, count))  # the same from the grace on
        self._clearance, self._tilt = np.full(count, np.inf), np.zeros(count)
        self._slid = np.zeros((len(STATION_NAMES), count))
        self._place = _contacts(core.telemetry, count)

    def note(self, reading: Reading, columns: Columns) -> None:
        """Write down an interval of the listed columns."""
        highs, lows = reading.telemetry.highs, reading.telemetry.lows
        if columns.size == self._slid.shape[1]:  # in place: most of the time all of them run
            np.maximum(self._highs, highs, out=self._highs)
            np.minimum(self._lows, lows, out=self._lows)
        else:
            self._highs[:, columns] = np.maximum(self._highs[:, columns], highs)
            self._lows[:, columns] = np.minimum(self._lows[:, columns], lows)
        counted = columns[reading.counted]
        for table, values, extreme in zip(self._counted, (highs, lows), (np.maximum, np.minimum), strict=True):
            table[_PROBE, counted] = extreme(table[_PROBE, counted], values[_PROBE, reading.counted])
        clearance = reading.corridor_m - reading.wheel_reach_m
        self._clearance[columns] = np.minimum(self._clearance[columns], clearance)
        self._tilt[columns] = np.maximum(self._tilt[columns], _tilt_deg(reading))
        self._slide(reading, columns)

    def _slide(self, r: Reading, columns: Columns) -> None:
        place = _contacts(r.telemetry, columns.size)
        way = place - self._place[:, :, columns]
        heading = r["yaw"] + np.array([r[f"{name}_steer"] for name in STATION_NAMES])
        cos, sin = np.cos(heading), np.sin(heading)
        along, across = cos * way[0] + sin * way[1], cos * way[1] - sin * way[0]
        moved = np.where(self._rolls[:, None], np.abs(across), np.hypot(along, across))
        slides = np.array([r.telemetry.peak_max(f"{name}_friction_use") for name in STATION_NAMES]) >= AT_THE_LIMIT
        self._slid[:, columns] += np.where(slides, moved, 0.0)
        self._place[:, :, columns] = place

    def columns(self) -> dict[str, Array]:
        """The columns of all episodes, by name, (n,) each."""
        nothing = np.zeros((0, self._highs.shape[1]))
        whole = Telemetry(nothing, nothing, self._highs, self._lows)
        counted = Telemetry(nothing, nothing, *self._counted)
        shares = [
            whole.peak_max(f"{name}_compression") / stroke
            for name, stroke in zip(STATION_NAMES, self._strokes, strict=True)
        ]
        return {
            **{name: one.of(counted if one.after_grace else whole) for name, one in PEAKS.items()},
            CLEARANCE: self._clearance,
            TILT: self._tilt,
            OLEO: np.max(shares, axis=0),
            SLIDING: np.max(self._slid, axis=0),
        }


def _tilt_deg(r: Reading) -> Array:
    """Angle between the deck's normal and apparent gravity at the interval's end [deg]."""
    along, across, down = (r[f"deck_f{axis}"] for axis in "xyz")
    return np.asarray(np.rad2deg(np.arctan2(np.hypot(along, across), np.abs(down))))


def strokes(helicopter: Helicopter) -> list[float]:
    """Length of each station's stroke, auxiliary, right, left [m]."""
    return [station.end_stop.stroke_m for station in helicopter.station_tuple]


def rolls(helicopter: Helicopter) -> NDArray[np.bool_]:
    """Whether each station's wheels can roll, (3,)."""
    return np.array([station.rolling == "free" for station in helicopter.station_tuple])


def _contacts(telemetry: Telemetry, count: int) -> Array:
    """Contact points of the first so many helicopters' stations over the deck [m], (2, 3, count)."""
    return np.array([[telemetry[f"{name}_contact_{axis}"][:count] for name in STATION_NAMES] for axis in "xy"])
