"""What a plan drives: a yielding law that keeps to a schedule, and knots of claw speed that are added to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.errors import ConfigurationError

Array = NDArray[np.float64]
AXES = 2


@dataclass(frozen=True)
class Seen:
    """What the law reads of helicopters, SI; shape (n,) each.

    Attributes:
        force_N: Lateral probe force on the helicopter, H axes.
        yaw_rad: Heading relative to the track.
        claw_x_m: Claw along the track.
        claw_y_m: Claw across the track.
    """

    force_N: Array
    yaw_rad: Array
    claw_x_m: Array
    claw_y_m: Array


@dataclass(frozen=True)
class Law:
    """A schedule along the track with feedback, and across it the yielding law; all gains are assumed.

    ``v_x = v_s + k_x (x_s - x) + plan_x`` and ``v_y = -k_y F_y - k_c y - k_psi yaw + plan_y``. The schedule is the
    trapezoid of `acceleration_m_s2` that reaches the goal at `arrival_s`.

    Attributes:
        arrival_s: When the claw is to be at the goal [s]. 44.8: with the 2 s in the goal that success takes, and half a
            second to spare, it is the fixed trapezoid's time and 10 %.
        acceleration_m_s2: Of the schedule [m/s2].
        following_per_s: k_x [1/s].
        yielding_m_s_per_N: k_y [m/s/N]; with a delay of 0.1 s, limit cycles begin at 8e-6.
        centring_per_s: k_c [1/s].
        straightening_m_s_per_rad: k_psi [m/s/rad].
        spacing_s: Time between two knots of a plan [s]; a plan is linear between them.
    """

    arrival_s: float = 44.8
    acceleration_m_s2: float = 0.1
    following_per_s: float = 0.2
    yielding_m_s_per_N: float = 4e-6
    centring_per_s: float = 0.15
    straightening_m_s_per_rad: float = 0.15
    spacing_s: float = 1.0

    def knots(self, task: TaskConfig) -> int:
        """How many knots cover the task's time."""
        return int(np.ceil(task.horizon_s / self.spacing_s)) + 2


class Drive:
    """The law of a task: claw speeds from what is seen, the time, and a plan.

    Args:
        task: Track, claw and control interval.
        law: Gains and schedule.

    Raises:
        ConfigurationError: The track is too long for the schedule's time.
    """

    def __init__(self, task: TaskConfig, law: Law) -> None:
        self.task = task
        self.law = law
        length_m = task.track.goal_x_m - task.track.start_x_m
        room = law.arrival_s**2 - 4.0 * length_m / law.acceleration_m_s2
        if room < 0.0:
            raise ConfigurationError(
                f"planning: arrival_s = {law.arrival_s:g} is refused: {length_m:g} m at {law.acceleration_m_s2:g} m/s2 "
                f"take at least {2.0 * np.sqrt(length_m / law.acceleration_m_s2):.1f} s."
            )
        self._ramp_s = 0.5 * (law.arrival_s - np.sqrt(room))
        self._top_m_s = law.acceleration_m_s2 * self._ramp_s
        self._speeds = np.array([task.claw.speed_along_m_s, task.claw.speed_across_m_s])

    def place(self, time_s: Array) -> Array:
        """Where the claw is to be along the track [m]."""
        law = self.law
        time = np.clip(time_s, 0.0, law.arrival_s)
        rising = 0.5 * law.acceleration_m_s2 * np.minimum(time, self._ramp_s) ** 2
        falling = 0.5 * law.acceleration_m_s2 * np.maximum(time - (law.arrival_s - self._ramp_s), 0.0) ** 2
        return np.asarray(
            self.task.track.start_x_m + rising + self._top_m_s * np.maximum(time - self._ramp_s, 0.0) - falling
        )

    def planned(self, plans: Array, steps: NDArray[np.int64]) -> Array:
        """A plan's speeds in the control interval that follows `steps` intervals [m/s].

        Args:
            plans: Knots of n plans, (n, knots, 2).
            steps: Intervals since the start, (n,).
        """
        place = (steps + 0.5) * self.task.control_interval_s / self.law.spacing_s
        left = np.floor(place).astype(np.int64)
        share = (place - left)[:, None]
        rows = np.arange(len(plans))
        return np.asarray((1.0 - share) * plans[rows, left] + share * plans[rows, left + 1])

    def commands(self, seen: Seen, steps: NDArray[np.int64], planned_m_s: Array) -> Array:
        """Normalised commands, (n, 2).

        Args:
            seen: What the law reads.
            steps: Control intervals since the start, (n,).
            planned_m_s: What the plan adds, (n, 2).
        """
        law, dt = self.law, self.task.control_interval_s
        before, after = self.place(steps * dt), self.place((steps + 1) * dt)
        along = (after - before) / dt + law.following_per_s * (before - seen.claw_x_m)
        across = -law.yielding_m_s_per_N * seen.force_N - law.centring_per_s * seen.claw_y_m
        across = across - law.straightening_m_s_per_rad * seen.yaw_rad
        speeds = np.stack([along, across], axis=1) + planned_m_s
        return np.asarray(np.clip(speeds / self._speeds, -1.0, 1.0))
