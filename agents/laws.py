"""Scripted laws: hold, drive by the book, give way to the load.

They read what an operator could read: named terms of the task's observation, in SI units. They know the track, the
claw's greatest speeds, its nominal delay and the control interval, and nothing of the episode's draw (mass, sea, true
delay). What they remember are arrays with a row for each helicopter, named in `MEMORY`.
"""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.laws_gains import Gains, yield_gains

from ssmash_gym.envs.observations import chosen_terms
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError

Array = NDArray[np.float64]
Observations = NDArray[np.float32]

SPEED_M_S: Final = 0.2  # assumed, and fixed: every comparison stands on this trapezoid
ACCELERATION_M_S2: Final = 0.1  # assumed, and fixed: 0.3 would only add a spike of load at either end
CENTRED_AFTER: Final = 0.75  # assumed, share of the track: its end is a straight pull, which straightens the helicopter


class Scripted(Protocol):
    """What every scripted policy can do, always for a batch.

    Attributes:
        name: In tables.
        task: The task it is used in.
        MEMORY: Names of the arrays that it remembers with, each with a row for each helicopter.
    """

    name: str
    task: TaskConfig
    MEMORY: tuple[str, ...]

    def reset(self, count: int) -> None:
        """Start `count` episodes."""

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Normalised claw velocity commands for observations (n, k), along and across, (n, 2)."""


class Readout:
    """Takes named terms out of observations, in SI units.

    Args:
        task: Says which terms an observation holds.
        names: Terms that will be read.

    Raises:
        ConfigurationError: The task's observation lacks one of them.
    """

    def __init__(self, task: TaskConfig, names: tuple[str, ...]) -> None:
        held = {term.name: (column, term.scale) for column, term in enumerate(chosen_terms(task.observation))}
        for name in names:
            if name not in held:
                raise ConfigurationError(
                    f"task: observation lacks the term {name!r}, which this baseline reads; add it, or use 'sensors'."
                )
        self._places = {name: held[name] for name in names}

    def __call__(self, observations: Observations, name: str) -> Array:
        """One term of all helicopters in its SI unit, (n,)."""
        column, scale = self._places[name]
        return observations[:, column].astype(np.float64) * scale


class Hold:
    """Hold still: what the sea alone does to a helicopter that is not moved.

    Args:
        task: The task it is to be used in.
    """

    name = "hold"
    MEMORY: tuple[str, ...] = ()

    def __init__(self, task: TaskConfig) -> None:
        self.task = task

    def reset(self, count: int) -> None:
        """Start `count` episodes."""

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for observations (n, k): zeros, (n, 2)."""
        return np.zeros((observations.shape[0], 2), dtype=np.float32)


class Trapezoid:
    """Drive by the book: one trapezoid of speed along the track, smoothly onto its centre line.

    The claw accelerates at 0.1 m/s2 to 0.2 m/s and stops at the goal by the same ramp. Across, it goes from where it
    is at the start to the centre line within the first three quarters of the track (a raised cosine of the distance)
    and rests there. A command is the mean speed of the profile over its interval, so that the commands of a run add up
    to the track.

    Args:
        task: The task it is to be used in.
        speed_m_s: Its speed; another one than the book's shows what haste costs.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "trapezoid"
    terms: tuple[str, ...] = ("claw_y",)
    MEMORY: tuple[str, ...] = ("_steps", "_offset_m")

    def __init__(self, task: TaskConfig, speed_m_s: float = SPEED_M_S) -> None:
        self.task = task
        self.speed_m_s = speed_m_s
        self.length_m = task.track.goal_x_m - task.track.start_x_m
        self.readout = Readout(task, self.terms)
        self._steps = np.zeros(0, dtype=np.int64)
        self._offset_m = np.zeros(0)

    def reset(self, count: int) -> None:
        """Start `count` episodes."""
        self._steps = np.zeros(count, dtype=np.int64)
        self._offset_m = np.zeros(count)

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for the next interval.

        Args:
            observations: (n, k) as the task's observation table scales them.
            starts: (n,) rows in which a new episode starts; not needed after `reset`.

        Returns:
            Normalised claw velocity, along and across, (n, 2).
        """
        if starts is not None:
            self._steps[starts] = 0
        fresh = self._steps == 0
        self._offset_m[fresh] = self.readout(observations, "claw_y")[fresh]
        interval_s = self.task.control_interval_s
        before, after = (self.travelled((self._steps + k) * interval_s) for k in (0, 1))
        along = (after - before) / interval_s
        across = self.across(observations, before, after) / interval_s
        self._steps += 1
        claw = self.task.claw
        commands = np.stack([along / claw.speed_along_m_s, across / claw.speed_across_m_s], axis=1)
        return np.clip(commands, -1.0, 1.0).astype(np.float32)

    def travelled(self, time_s: Array) -> Array:
        """Distance along the track by the book [m]."""
        top = min(self.speed_m_s, np.sqrt(ACCELERATION_M_S2 * self.length_m), self.task.claw.speed_along_m_s)
        ramp_s = top / ACCELERATION_M_S2
        end_s = self.length_m / top + ramp_s
        time = np.clip(time_s, 0.0, end_s)
        rising = 0.5 * ACCELERATION_M_S2 * np.minimum(time, ramp_s) ** 2
        falling = 0.5 * ACCELERATION_M_S2 * np.maximum(time - (end_s - ramp_s), 0.0) ** 2
        return np.asarray(rising + top * np.maximum(time - ramp_s, 0.0) - falling)

    def remaining(self, travelled_m: Array) -> Array:
        """Share of the lateral offset at the start that is left after a distance along the track."""
        way = travelled_m / (CENTRED_AFTER * self.length_m)
        return np.asarray(0.5 * (1.0 + np.cos(np.pi * np.clip(way, 0.0, 1.0))))

    def across(self, observations: Observations, before: Array, after: Array) -> Array:
        """Way across the track in this interval [m], (n,), while the book goes from `before` to `after` along it."""
        return np.asarray(self._offset_m * (self.remaining(after) - self.remaining(before)))


class Yield(Trapezoid):
    """The trapezoid along the track, and across it a claw that gives way to the load.

    ``v_y = -k_y F_y - k_c y - k_psi yaw`` with the lateral probe force on the helicopter F_y (H axes), the claw's
    lateral position y and the helicopter's yaw relative to the track. One line, and it removes most of the load.

    Args:
        task: The task it is to be used in.
        gains: Other gains than those found by search for the task's delay.
        speed_m_s: Another speed than the trapezoid's.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "yield"
    terms = ("claw_y", "probe_fy", "yaw")

    def __init__(self, task: TaskConfig, gains: Gains | None = None, speed_m_s: float = SPEED_M_S) -> None:
        super().__init__(task, speed_m_s)
        self.gains = yield_gains(task.claw.delay_s) if gains is None else gains

    def across(self, observations: Observations, before: Array, after: Array) -> Array:
        """Way across the track in this interval [m], (n,)."""
        force_N = self.readout(observations, "probe_fy")
        claw_m = self.readout(observations, "claw_y")
        yaw_rad = self.readout(observations, "yaw")
        speed = -self.gains.k_y * force_N - self.gains.k_c * claw_m - self.gains.k_psi * yaw_rad
        return np.asarray(speed * self.task.control_interval_s)
