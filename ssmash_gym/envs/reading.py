"""What the terms of observation, reward and limits read: one frozen view of some helicopters after an interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import STATION_NAMES
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.simulation.telemetry import Telemetry
from ssmash_gym.vehicle import Helicopter

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
MAINS = ("right", "left")


@dataclass(frozen=True)
class Reading:
    """n helicopters at the end of an interval; every array has shape (n,) unless said otherwise, SI units.

    Attributes:
        task: The task.
        telemetry: Their channels, and the extremes over the substeps of the interval.
        steps: Control intervals since the start.
        counted: Whether probe loads count already (grace).
        command: Applied command of this interval, (n, 2); `previous` is that of the one before.
        held: Control instants in a row at which the goal's tolerances were met.
        half_spread_m: Largest distance of a tire from its station's middle [m], (3, 1).
    """

    task: TaskConfig
    telemetry: Telemetry
    steps: NDArray[np.int64]
    counted: Flags
    command: Array
    previous: Array
    held: NDArray[np.int64]
    half_spread_m: Array

    def __getitem__(self, channel: str) -> Array:
        """A telemetry channel at the end of the interval."""
        return self.telemetry[channel]

    @property
    def time_s(self) -> Array:
        """Time since the start [s]."""
        return np.asarray(self.steps * self.task.control_interval_s)

    @property
    def to_go_m(self) -> Array:
        """Claw's distance to the goal along the track [m]."""
        return np.asarray(self.task.track.goal_x_m - self["claw_x"])

    @property
    def probe_peak_N(self) -> Array:
        """Largest in-plane probe load within the interval [N]."""
        return self.telemetry.peak_max("probe_in_plane")

    @property
    def main_peak_N(self) -> Array:
        """Largest vertical load of a main station within the interval [N]."""
        right, left = (self.telemetry.peak_max(f"{name}_vertical_load") for name in MAINS)
        return np.maximum(right, left)

    @property
    def least_station_N(self) -> Array:
        """Least vertical load of any station within the interval [N]."""
        loads = [self.telemetry.peak_min(f"{name}_vertical_load") for name in STATION_NAMES]
        return np.minimum(np.minimum(loads[0], loads[1]), loads[2])

    @property
    def roll_peak_rad(self) -> Array:
        """Largest roll relative to the deck within the interval, either way [rad]."""
        return self.telemetry.peak_abs("roll")

    @property
    def wheel_reach_m(self) -> Array:
        """Largest distance of a wheel from the centre line within the interval [m]."""
        reach = [self.telemetry.peak_abs(f"{name}_contact_y") for name in STATION_NAMES]
        spread = [part + reach_m for part, reach_m in zip(self.half_spread_m, reach, strict=True)]
        return np.asarray(np.maximum(np.maximum(spread[0], spread[1]), spread[2]))

    @property
    def corridor_m(self) -> Array:
        """Half-width of the corridor where the claw is [m]."""
        corridor = self.task.corridor
        in_door = self["claw_x"] >= corridor.door_claw_x_m
        return np.where(in_door, corridor.door_half_width_m, corridor.half_width_m)

    @property
    def straight(self) -> Flags:
        """Whether yaw and lateral position are within the goal's tolerances."""
        goal = self.task.goal
        yaw = np.abs(self["yaw"]) < np.deg2rad(goal.yaw_tolerance_deg)
        return np.asarray(yaw & (np.abs(self["probe_y"]) < goal.y_tolerance_m))

    @property
    def in_goal(self) -> Flags:
        """Whether all of the goal's tolerances are met."""
        distance = np.abs(self.task.track.goal_x_m - self["probe_x"])
        return np.asarray(self.straight & (distance < self.task.goal.x_tolerance_m))


def half_spread(helicopter: Helicopter) -> Array:
    """Largest distance of a tire from its station's middle [m], (3, 1): a bound for its place across the track."""
    spreads = []
    for station in helicopter.station_tuple:
        sides = np.array([tire.position_m[1] for tire in station.tires])
        spreads.append(float(np.max(np.abs(sides - np.mean(sides)))))
    return np.array(spreads)[:, None]


def columns_of(telemetry: Telemetry, columns: NDArray[np.int64], *, instant: bool = False) -> tuple[Telemetry, Flags]:
    """The listed columns as their own table of finite numbers, and which columns held something else.

    Args:
        telemetry: The batch's table.
        columns: Helicopters.
        instant: Replace the extremes by the instant's values (nothing has happened yet).
    """
    state, outputs = telemetry.state[:, columns], telemetry.outputs[:, columns]
    highs, lows = (outputs, outputs) if instant else (telemetry.highs[:, columns], telemetry.lows[:, columns])
    bad = ~(np.isfinite(outputs).all(axis=0) & np.isfinite(highs).all(axis=0) & np.isfinite(lows).all(axis=0))
    bad |= ~np.isfinite(state).all(axis=0)
    if bad.any():
        state, outputs, highs, lows = (np.nan_to_num(t, nan=0.0, posinf=0.0, neginf=0.0) for t in (state, outputs, highs, lows))
    return Telemetry(state, outputs, highs, lows), bad
