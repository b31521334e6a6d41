"""Laws whose gains and speed depend on the place on the track: soft where the loads are, aligning where it counts."""

from __future__ import annotations

from typing import Final

import numpy as np
from ssmash_gym.agents.laws import ACCELERATION_M_S2, Array, Observations, Readout, Trapezoid
from ssmash_gym.agents.laws_gains import FeedbackGains, feedback_gains

from ssmash_gym.envs.task import TaskConfig

YIELDING: Final = ("probe_fy", "claw_y", "yaw", "deck_fy")
MORE: Final = ("yaw_rate", "auxiliary_steer_sin", "roll", "claw_vy", "last_command_y", "deck_wx", "deck_roll")


class YieldScheduled(Trapezoid):
    """The yielding law with gains and speed that depend on the place on the track.

    As `Yield`, with a value of each gain for the begin of the track, where the castor wheels swing and the greatest
    loads are, one for the way, and one for the end, where the helicopter is to come straight; smooth steps between. The
    speed along the track has three values, too. The deck's lateral specific force is fed forward.

    Args:
        task: The task it is to be used in.
        gains: Other gains than those found by search for the task's delay.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "yield_scheduled"
    reads: tuple[str, ...] = YIELDING

    def __init__(self, task: TaskConfig, gains: FeedbackGains | None = None) -> None:
        super().__init__(task)
        self.gains = feedback_gains(task.claw.delay_s, self.name) if gains is None else gains
        self.readout = Readout(task, self.reads)
        schedule, fastest = self.gains.schedule, task.claw.speed_along_m_s
        self._book = schedule.book(self.length_m, fastest, ACCELERATION_M_S2)

    def travelled(self, time_s: Array) -> Array:
        """Distance along the track by the book [m]."""
        return self._book.travelled(time_s)

    def across(self, observations: Observations, before: Array, after: Array) -> Array:
        """Way across the track in this interval [m], (n,)."""
        gains = self.gains
        start, way, near = gains.schedule.shares(before, self.length_m)
        speed = np.zeros(before.shape)
        for name in self.reads:
            gain = start * gains.start[name] + way * gains.way[name] + near * gains.near[name]
            speed -= gain * self.readout(observations, name)
        return np.asarray(speed * self.task.control_interval_s)


class Linear(YieldScheduled):
    """Linear feedback of all that tells how the lateral load will go on, scheduled as `YieldScheduled`.

    Besides load, offset and yaw it reads how the helicopter turns and rolls, how its auxiliary wheel stands, what the
    claw is about to do (which makes up for its delay), and how the deck moves. Its gains were found on a linear model
    of the lateral motion that was identified on the simulation (`tools/lateral_model.py`).
    """

    name = "linear"
    reads = (*YIELDING, *MORE)
