"""A scripted model of a human operator: what delay, lag and dead bands make of driving by the book.

No person's data stand behind it, and no result of it is a person's. Its parts are those of the quasi-linear models of
manual control (McRuer et al., AFFDL-TR-65-15, 1965; McRuer and Jex, IEEE Trans. Human Factors in Electronics HFE-8,
1967): what is seen acts after a pure delay, times a gain, through the first-order lag of arm and stick. It looks at the
claw and at the helicopter, never at the probe's load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.laws import ACCELERATION_M_S2, SPEED_M_S, Observations, Readout

from ssmash_gym.envs.task import TaskConfig

Array = NDArray[np.float64]
SEEN = ("to_go", "claw_y", "yaw")


@dataclass(frozen=True)
class OperatorParameters:
    """Numbers of the operator model.

    Attributes:
        delay_s: From seeing to acting, rounded to control intervals. Sourced: the crossover model's effective delay for
            a rate-controlled element is 0.36 s at low bandwidth (McRuer and Jex 1967); less the lag, 0.26 s are left.
        lag_s: Time constant of arm and stick; sourced: about 0.1 s (McRuer et al. 1965).
        lateral_per_s: Lateral speed per lateral offset, the crossover frequency [rad/s]; assumed. Full attention to a
            fast target reaches 4.75 rad/s (McRuer and Jex 1967), a slow drift under a heavy helicopter does not ask it.
        yaw_m_s_per_rad: Lateral speed per yaw; assumed.
        lateral_band_m: Offsets below it are not corrected; assumed, half of what the goal allows.
        yaw_band_deg: The same of yaw; assumed, half of what the goal allows.
        lateral_limit_m_s: Greatest lateral speed it commands; assumed, half the claw's.
        stopping_per_s: Speed per distance to go, close to the goal; assumed.
    """

    delay_s: float = 0.26
    lag_s: float = 0.1
    lateral_per_s: float = 0.3
    yaw_m_s_per_rad: float = 0.1
    lateral_band_m: float = 0.025
    yaw_band_deg: float = 0.5
    lateral_limit_m_s: float = 0.05
    stopping_per_s: float = 0.5


class Operator:
    """Scripted operator model: by the book along the track, and across it slow corrections of what can be seen.

    Along the track it speeds up to 0.2 m/s by 0.1 m/s2 and brakes for the goal by the same rate. It previews no more
    than its own delay and lag: it brakes for where the claw will be by the time its hand has moved.

    Args:
        task: The task it is to be used in.
        parameters: Other numbers than the default ones.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "operator"
    MEMORY: tuple[str, ...] = ("_begun", "_seen", "_wanted_m_s", "_stick_m_s")

    def __init__(self, task: TaskConfig, parameters: OperatorParameters | None = None) -> None:
        self.task = task
        self.parameters = OperatorParameters() if parameters is None else parameters
        self.readout = Readout(task, SEEN)
        self._delay = max(1, round(self.parameters.delay_s / task.control_interval_s))
        self.reset(0)

    def reset(self, count: int) -> None:
        """Start `count` episodes."""
        self._begun = np.zeros(count, dtype=np.bool_)
        self._seen = np.zeros((count, self._delay + 1, len(SEEN)))  # oldest first
        self._wanted_m_s = np.zeros(count)
        self._stick_m_s = np.zeros((count, 2))

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for the next interval.

        Args:
            observations: (n, k) as the task's observation table scales them.
            starts: (n,) rows in which a new episode starts; not needed after `reset`.

        Returns:
            Normalised claw velocity, along and across, (n, 2).
        """
        fresh = ~self._begun if starts is None else ~self._begun | starts
        now = np.stack([self.readout(observations, name) for name in SEEN], axis=1)
        self._seen = np.where(fresh[:, None, None], now[:, None, :], np.roll(self._seen, -1, axis=1))
        self._seen[:, -1] = now
        self._wanted_m_s = np.where(fresh, 0.0, self._wanted_m_s)
        self._stick_m_s = np.where(fresh[:, None], 0.0, self._stick_m_s)
        self._begun = np.ones_like(self._begun)
        to_go_m, offset_m, yaw_rad = np.moveaxis(self._seen[:, 0], 1, 0)
        self._wanted_m_s = self._along(to_go_m)
        wanted = np.stack([self._wanted_m_s, self._across(offset_m, yaw_rad)], axis=1)
        share = self.task.control_interval_s / (self.parameters.lag_s + self.task.control_interval_s)
        self._stick_m_s = self._stick_m_s + share * (wanted - self._stick_m_s)
        claw = self.task.claw
        commands = self._stick_m_s / [claw.speed_along_m_s, claw.speed_across_m_s]
        return np.clip(commands, -1.0, 1.0).astype(np.float32)

    def _along(self, to_go_m: Array) -> Array:
        """Wanted speed along the track from the distance to go that was seen [m/s]."""
        number = self.parameters
        ahead_m = self._stick_m_s[:, 0] * (number.delay_s + number.lag_s)
        left_m = np.maximum(to_go_m - ahead_m, 0.0)
        braking = np.minimum(np.sqrt(2.0 * ACCELERATION_M_S2 * left_m), number.stopping_per_s * left_m)
        faster = self._wanted_m_s + ACCELERATION_M_S2 * self.task.control_interval_s
        return np.minimum(np.minimum(faster, SPEED_M_S), braking)

    def _across(self, offset_m: Array, yaw_rad: Array) -> Array:
        """Wanted speed across the track from the offset and the yaw that were seen [m/s]."""
        number = self.parameters
        speed = -number.lateral_per_s * beyond(offset_m, number.lateral_band_m)
        speed = speed - number.yaw_m_s_per_rad * beyond(yaw_rad, float(np.deg2rad(number.yaw_band_deg)))
        return np.clip(speed, -number.lateral_limit_m_s, number.lateral_limit_m_s)


def beyond(values: Array, band: float) -> Array:
    """What exceeds a dead band, with its sign."""
    return np.sign(values) * np.maximum(np.abs(values) - band, 0.0)
