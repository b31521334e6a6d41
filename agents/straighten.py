"""The scripted policy of `ssmash/Straighten-v0`: drive the helicopter forward like a car that is led by its probe.

The mains roll without side slip, so the middle of their axle moves along the helicopter's axis only, and its path is
curved as the castored auxiliary wheel stands. That wheel turns when it is pushed sideways: the lateral probe force sets
how fast the curvature changes with the way, which makes a chain of three integrals from force to place. The law plans
the force with the least square that brings axle and heading onto the centre line by the end of the track, and lets the
claw give way until the force is the planned one. It is scripted; no operator has been asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from ssmash_gym.agents.laws import Readout

from ssmash_gym.envs.task import TaskConfig

Array = NDArray[np.float64]
Observations = NDArray[np.float32]

AXLE_BEHIND_PROBE_M: Final = 1.94  # of the generic tricycle (configs/helicopters), derived from its mounting points
WHEELBASE_M: Final = 5.65  # from the mains to the auxiliary wheel, likewise
ACCELERATION_M_S2: Final = 0.1  # assumed: that of the trapezoid
END_MARGIN_M: Final = 0.06  # assumed: the claw stops this far before the ends of its travel
STRAIGHT_YAW_RAD: Final = np.deg2rad(0.6)  # assumed: well within the goal's tolerance, so that it stays there
STRAIGHT_LATERAL_M: Final = 0.03  # assumed, likewise
CREEP_M_S: Final = 0.04  # assumed: slow enough to stop within a fraction of the goal's tolerance
FORWARD, AFT = 1.0, -1.0


@dataclass(frozen=True)
class Gains:
    """Numbers of the law; the defaults were chosen by tools/straighten_search.py on tuning seeds.

    Attributes:
        speed_m_s: Along the helicopter's axis.
        force_N: Largest planned lateral probe force.
        force_per_rate_Nm2: Force for a curvature that changes by 1/m a metre.
        give_m_s_per_N: Lateral speed for each newton that the force is off the planned one.
        give_aft_m_s_per_N: The same going aft or at rest.
        reserve_m: How far before the end of the track the plan ends; shortest_m: its least way.
        back_up_rad: Yaw from which the law goes aft first, which lengthens the way.
        retreat_m: How far it goes aft for another pass. The auxiliary wheel keeps its angle going aft, so that the
            helicopter goes back the way it came.
    """

    speed_m_s: float = 0.1914
    force_N: float = 14.67e3
    force_per_rate_Nm2: float = 120e3
    give_m_s_per_N: float = 2.534e-6
    give_aft_m_s_per_N: float = 0.5842e-6
    reserve_m: float = 0.0916
    shortest_m: float = 0.8279
    back_up_rad: float = 0.05704
    retreat_m: float = 2.624


class Straighten:
    """Forward passes under a planned lateral force, and straight back along the helicopter's axis in between.

    Args:
        task: The task it is to be used in.
        gains: Its numbers.

    Raises:
        ConfigurationError: The task's observation lacks a term that is read.
    """

    name = "straighten"
    terms: tuple[str, ...] = ("yaw", "claw_x", "claw_y", "probe_fy", "auxiliary_steer_sin", "auxiliary_steer_cos")
    MEMORY: tuple[str, ...] = ("_speed_m_s", "_way", "_passed")

    def __init__(self, task: TaskConfig, gains: Gains | None = None) -> None:
        self.task = task
        self.gains = gains or Gains()
        self.readout = Readout(task, self.terms)
        self._speed_m_s = np.zeros(0)  # along the helicopter's axis
        self._way = np.zeros(0)  # FORWARD or AFT; 0 before the first command
        self._passed = np.zeros(0, dtype=np.bool_)  # whether a forward pass has ended without success

    def reset(self, count: int) -> None:
        """Start `count` episodes."""
        self._speed_m_s = np.zeros(count)
        self._way = np.zeros(count)
        self._passed = np.zeros(count, dtype=np.bool_)

    def act(self, observations: Observations, starts: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """Commands for the next interval.

        Args:
            observations: (n, k) as the task's observation table scales them.
            starts: (n,) rows in which a new episode starts; not needed after `reset`.

        Returns:
            Normalised claw velocity, along and across, (n, 2).
        """
        if starts is not None:
            self._speed_m_s[starts], self._way[starts], self._passed[starts] = 0.0, 0.0, False
        gains, claw = self.gains, self.task.claw
        yaw, claw_y = self.readout(observations, "yaw"), self.readout(observations, "claw_y")
        ahead, behind = self.rooms(self.readout(observations, "claw_x"), claw_y, yaw)
        straight = (np.abs(yaw) < STRAIGHT_YAW_RAD) & (np.abs(claw_y) < STRAIGHT_LATERAL_M)
        curvature = self.curvature(observations)
        self._drive(yaw, curvature, (ahead, behind), straight)
        planned_N = np.where(straight, 0.0, self.planned_force(yaw, claw_y, curvature, ahead))
        planned_N *= np.clip(self._speed_m_s / 0.05, 0.0, 1.0)  # a wheel at rest would be scrubbed round, not rolled
        give = np.where(self._speed_m_s > 0.01, gains.give_m_s_per_N, gains.give_aft_m_s_per_N)
        along = self._speed_m_s
        across = along * curvature * AXLE_BEHIND_PROBE_M
        across = across + give * (planned_N - self.readout(observations, "probe_fy"))
        cos, sin = np.cos(yaw), np.sin(yaw)
        commands = np.stack(
            [
                (along * cos - across * sin) / claw.speed_along_m_s,
                (along * sin + across * cos) / claw.speed_across_m_s,
            ],
            axis=1,
        )
        return np.clip(commands, -1.0, 1.0).astype(np.float32)

    def curvature(self, observations: Observations) -> Array:
        """Curvature of the axle's path as the auxiliary wheel stands [1/m], (n,); to starboard positive."""
        sin, cos = (self.readout(observations, f"auxiliary_steer_{part}") for part in ("sin", "cos"))
        tangent = sin * np.where(cos < 0.0, -1.0, 1.0) / np.maximum(np.abs(cos), 0.3)
        return np.asarray(np.clip(tangent, -3.0, 3.0) / WHEELBASE_M)

    def rooms(self, claw_x: Array, claw_y: Array, yaw: Array) -> tuple[Array, Array]:
        """Room of the claw ahead and behind [m], (n,) each; going aft along the axis, lateral travel ends it too."""
        claw = self.task.claw
        sideways = claw.y_travel_m - END_MARGIN_M + np.sign(yaw) * claw_y
        behind = np.minimum(claw_x - claw.x_min_m - END_MARGIN_M, sideways / np.maximum(np.tan(np.abs(yaw)), 0.05))
        return claw.x_max_m - END_MARGIN_M - claw_x, behind

    def _drive(self, yaw: Array, curvature: Array, rooms: tuple[Array, Array], straight: NDArray[np.bool_]) -> None:
        """Turn where the room ends, and take the speed a ramp further."""
        gains, (ahead, behind) = self.gains, rooms
        first = np.where(np.abs(yaw) > gains.back_up_rad, AFT, FORWARD)
        way = np.where(self._way == 0.0, first, self._way)
        behind = np.where(self._passed, np.minimum(behind, gains.retreat_m - ahead), behind)
        room = np.where(way > 0.0, ahead, behind)
        turning = (room < 0.03) & (np.abs(self._speed_m_s) < 0.02) & ~straight
        self._passed |= turning & (way > 0.0)
        way = np.where(turning, -way, way)
        room = np.maximum(np.where(way > 0.0, ahead, behind), 0.0)
        top = np.minimum(gains.speed_m_s, braking(room) * np.minimum(room / 0.05, 1.0))
        turns = -np.sign(yaw) * curvature * way  # positive: the way ahead straightens the helicopter
        until_straight = np.where(turns > 0.0, np.abs(yaw) / np.maximum(turns, 1e-3), np.inf)
        top = np.minimum(top, CREEP_M_S + braking(until_straight))
        step = ACCELERATION_M_S2 * self.task.control_interval_s
        self._way = way
        wanted = np.where(straight, 0.0, way * top)
        self._speed_m_s = np.clip(wanted, self._speed_m_s - step, self._speed_m_s + step)

    def planned_force(self, yaw: Array, claw_y: Array, curvature: Array, ahead: Array) -> Array:
        """Lateral probe force on the helicopter at the start of the plan [N], (n,).

        With the axle's offset y, the heading and the curvature c, and the way D to go, the rate dc/ds of least square
        that ends with y = 0 and heading 0, whatever the wheel's angle, is -(40 y / D + 28 heading + 8 c D) / D^2 now.
        """
        gains = self.gains
        axle_y = claw_y - AXLE_BEHIND_PROBE_M * np.sin(yaw)
        way = np.maximum(ahead - gains.reserve_m, gains.shortest_m)
        rate = -(40.0 * axle_y / way + 28.0 * yaw + 8.0 * curvature * way) / (way * way)
        return np.asarray(np.clip(gains.force_per_rate_Nm2 * rate, -gains.force_N, gains.force_N))


def braking(way_m: Array) -> Array:
    """Speed from which the claw stops within a way [m/s], (n,)."""
    return np.asarray(np.sqrt(2.0 * ACCELERATION_M_S2 * way_m))


STRAIGHTEN_BASELINES: Final[dict[str, Callable[[TaskConfig], Straighten]]] = {Straighten.name: Straighten}
