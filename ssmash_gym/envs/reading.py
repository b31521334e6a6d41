"""What the terms of observation, reward and limits read: one frozen view of some helicopters after an interval."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

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
        held_before: Control instants in a row, up to the last one, at which the goal's tolerances were met.
        broken: Whether numbers were not finite, or the state is held because it diverged.
        half_spread_m: Largest distance of a tire from its station's middle [m], (3, 1).
        limit_steps: Control intervals until the time limit.
    """

    task: TaskConfig
    telemetry: Telemetry
    steps: NDArray[np.int64]
    counted: Flags
    command: Array
    previous: Array
    held_before: NDArray[np.int64]
    peak_before_N: Array
    broken: Flags
    half_spread_m: Array
    limit_steps: int

    def __getitem__(self, channel: str) -> Array:
        """A telemetry channel at the end of the interval."""
        return self.telemetry[channel]

    @cached_property
    def time_s(self) -> Array:
        """Time since the start [s]."""
        return np.asarray(self.steps * self.task.control_interval_s)

    @cached_property
    def time_left_s(self) -> Array:
        """Time until the limit [s]."""
        return np.asarray((self.limit_steps - self.steps) * self.task.control_interval_s)

    @cached_property
    def to_go_m(self) -> Array:
        """Claw's distance to the goal along the track [m]."""
        return np.asarray(self.task.track.goal_x_m - self["claw_x"])

    @cached_property
    def probe_peak_N(self) -> Array:
        """Largest in-plane probe load within the interval [N]."""
        return self.telemetry.peak_max("probe_in_plane")

    @cached_property
    def episode_peak_N(self) -> Array:
        """Largest in-plane probe load of the episode so far, grace left out [N]."""
        return np.where(self.counted, np.maximum(self.peak_before_N, self.probe_peak_N), self.peak_before_N)

    @cached_property
    def main_peak_N(self) -> Array:
        """Largest vertical load of a main station within the interval [N]."""
        right, left = (self.telemetry.peak_max(f"{name}_vertical_load") for name in MAINS)
        return np.maximum(right, left)

    @cached_property
    def least_station_N(self) -> Array:
        """Least vertical load of any station within the interval [N]."""
        loads = [self.telemetry.peak_min(f"{name}_vertical_load") for name in STATION_NAMES]
        return np.minimum(np.minimum(loads[0], loads[1]), loads[2])

    @cached_property
    def roll_peak_rad(self) -> Array:
        """Largest roll relative to the deck within the interval, either way [rad]."""
        return self.telemetry.peak_abs("roll")

    @cached_property
    def wheel_reach_m(self) -> Array:
        """Largest distance of a wheel from the centre line within the interval [m]."""
        reach = [self.telemetry.peak_abs(f"{name}_contact_y") for name in STATION_NAMES]
        spread = [part + reach_m for part, reach_m in zip(self.half_spread_m, reach, strict=True)]
        return np.asarray(np.maximum(np.maximum(spread[0], spread[1]), spread[2]))

    @cached_property
    def corridor_m(self) -> Array:
        """Half-width of the corridor where the claw is [m]."""
        corridor = self.task.corridor
        in_door = self["claw_x"] >= corridor.door_claw_x_m
        return np.where(in_door, corridor.door_half_width_m, corridor.half_width_m)

    @cached_property
    def straight(self) -> Flags:
        """Whether yaw and lateral position are within the goal's tolerances."""
        goal = self.task.goal
        yaw = np.abs(self["yaw"]) < np.deg2rad(goal.yaw_tolerance_deg)
        return np.asarray(yaw & (np.abs(self["probe_y"]) < goal.y_tolerance_m))

    @cached_property
    def in_goal(self) -> Flags:
        """Whether all of the goal's tolerances are met."""
        distance = np.abs(self.task.track.goal_x_m - self["probe_x"])
        return np.asarray(self.straight & (distance < self.task.goal.x_tolerance_m) & ~self.broken)

    @cached_property
    def held(self) -> NDArray[np.int64]:
        """Control instants in a row at which the goal's tolerances were met, this one included."""
        return np.where(self.in_goal, self.held_before + 1, 0)


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
    pick: Any = slice(None) if columns.size == telemetry.state.shape[1] else columns  # then in the batch's order
    if columns.size == telemetry.state.shape[1] and np.any(columns[1:] < columns[:-1]):
        pick = columns
    state, outputs = telemetry.state[:, pick], telemetry.outputs[:, pick]
    highs, lows = (outputs, outputs) if instant else (telemetry.highs[:, pick], telemetry.lows[:, pick])
    tables: tuple[Array, ...] = (state, outputs, highs, lows)
    with np.errstate(invalid="ignore", over="ignore"):
        bad = ~np.isfinite(sum(table.sum(axis=0) for table in tables))
    if bad.any():
        tables = tuple(np.nan_to_num(table, nan=0.0, posinf=0.0, neginf=0.0) for table in tables)
    return Telemetry(*tables), bad
