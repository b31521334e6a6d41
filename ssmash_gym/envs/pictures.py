"""From the state of one helicopter to a `Scene`, and from scenes to pictures with load traces."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import (
    STATION_COORDINATES,
    STATION_NAMES,
    STATION_ROWS,
    TIRE_PAR,
    TIRE_ROWS,
    Mode,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.ship import MotionTable
from ssmash_gym.vehicle.geometry import rotation

if TYPE_CHECKING:
    from ssmash_gym.envs.batch_env import TraverseBatch
    from ssmash_gym.envs.rendering import Renderer, Scene
    from ssmash_gym.envs.step import StepResult

Array = NDArray[np.float64]
_TRACE_S: Final = 30.0
_WORDS: Final = {
    "goal": "goal held",
    "ultimate_load": "ultimate probe load",
    "probe_lost": "probe lost",
    "overturning": "overturned",
    "corridor": "left the corridor",
    "divergence": "simulation diverged",
    "time": "time is up",
}


class Film:
    """Draws one column of a batch, with the loads of the last seconds.

    Args:
        core: The batch.
        k: Its column.
        mode: ``rgb_array`` or ``human``.
    """

    def __init__(self, core: TraverseBatch, k: int, mode: str) -> None:
        self._core = core
        self._k = k
        self._mode = mode
        self._renderer: Renderer | None = None
        self._trace: deque[tuple[float, float, Array]] = deque(maxlen=round(_TRACE_S / core.control_interval_s) + 1)
        self._outcome = ""
        self._success = False

    def cut(self) -> None:
        """A new episode begins."""
        self._trace.clear()
        self._outcome, self._success = "", False

    def note(self, result: StepResult) -> None:
        """Remember a step's loads and, if it was the last one, how it ended."""
        if self._k not in result.columns:
            return
        telemetry = self._core.telemetry
        loads = np.array([telemetry[f"{name}_vertical_load"][self._k] for name in STATION_NAMES])
        time = float(self._core.book.steps[self._k]) * self._core.control_interval_s
        self._trace.append((time, float(telemetry.peak_max("probe_in_plane")[self._k]), loads))
        ending = result.endings.get(self._k)
        if ending is not None:
            self._outcome, self._success = _WORDS[ending["reason"]], ending["success"]

    def picture(self) -> NDArray[np.uint8] | None:
        """Draw the present state; the array (height, width, 3), or None when it went to the window.

        Raises:
            gymnasium.error.DependencyNotInstalled: pygame-ce is not installed (extra ``render``).
        """
        if self._renderer is None:
            from ssmash_gym.envs.rendering import Renderer

            pace = 1.0 / self._core.control_interval_s if self._mode == "human" else None
            self._renderer = Renderer("human" if self._mode == "human" else "rgb_array", pace_hz=pace)
        return self._renderer.render(self.scene())

    def scene(self) -> Scene:
        """The numbers of the present picture."""
        from ssmash_gym.envs.rendering import History

        times = np.array([entry[0] for entry in self._trace])
        probe = np.array([entry[1] for entry in self._trace])
        loads = np.array([entry[2] for entry in self._trace]).reshape(-1, len(STATION_NAMES))
        history = History(time_s=times, probe_N=probe, station_N=loads)
        return scene_of(self._core, self._k, history, self._outcome, self._success)

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def scene_of(core: TraverseBatch, k: int, history: Any, outcome: str = "", success: bool = False) -> Scene:
    """The scene of column k of a batch."""
    from ssmash_gym.envs.rendering import Airframe, Limits, Scene, Track

    batch, task = core.batch, core.task
    state, p, out = batch.state[:, k], batch.parameters[:, k], batch.telemetry
    R_SH = rotation(state[State.Q11 : State.Q14 + 1])
    r_SH_S = state[State.Q8 : State.Q10 + 1].copy()
    time = min(float(batch.time_s[k]), (batch.nodes.shape[1] - 1) * batch.timing.node_spacing_s)
    pose = MotionTable(batch.timing.node_spacing_s, batch.nodes[k]).pose(time)
    wheels, r_HW_H, r_HO_H = _wheels(core, k, R_SH, r_SH_S)
    force_H = np.array([out[f"probe_f{axis}"][k] for axis in "xyz"])
    draw = core.draws[k]
    return Scene(
        time_s=float(core.book.steps[k]) * task.control_interval_s,
        horizon_s=task.horizon_s,
        r_SH_S=r_SH_S,
        R_SH=R_SH,
        wheels=wheels,
        r_SC_S=np.array([out["claw_x"][k], out["claw_y"][k], p[Par.CLAW_Z]]),
        r_SA_S=r_SH_S + R_SH @ p[Par.PROBE_MOUNT : Par.PROBE_MOUNT + 3],
        r_SB_S=np.array([out["probe_x"][k], out["probe_y"][k], p[Par.CLAW_Z]]),
        probe_force_S=R_SH @ force_H,
        captured=bool(state[State.PROBE_CAPTURED] > 0.5),
        r_NS_N=pose.r_NS_N,
        R_NS=pose.R_NS,
        claw_velocity_S=np.array([out["claw_vx"][k], out["claw_vy"][k]]),
        claw_command=core.book.command[k].copy(),
        history=history,
        track=Track(
            start_x_m=task.track.start_x_m,
            goal_x_m=task.track.goal_x_m,
            goal_tolerance_m=task.goal.x_tolerance_m,
            lateral_tolerance_m=task.goal.y_tolerance_m,
            yaw_tolerance_rad=float(np.deg2rad(task.goal.yaw_tolerance_deg)),
            corridor_m=task.corridor.half_width_m,
            door_corridor_m=task.corridor.door_half_width_m,
            door_claw_x_m=task.corridor.door_claw_x_m,
            hangar_door_x_m=task.track.goal_x_m + 1.8,
        ),
        limits=Limits(
            probe_soft_N=1e3 * task.reward.soft_limit_kN,
            probe_cost_N=1e3 * task.limits.probe_in_plane_kN,
            probe_ultimate_N=1e3 * task.limits.probe_ultimate_kN,
            station_N=1e3 * task.limits.main_vertical_kN,
            lift_off_N=1e3 * task.limits.lift_off_kN,
            roll_rad=float(np.deg2rad(task.limits.roll_deg)),
        ),
        airframe=Airframe.around(r_HW_H, r_HO_H),
        ship_speed_m_s=0.0 if draw is None else draw.wind_ship_speed_mps,
        outcome=outcome,
        success=success,
    )


def _wheels(core: TraverseBatch, k: int, R_SH: Array, r_SH_S: Array) -> tuple[Any, Array, Array]:
    """Tires and struts of column k in S, and carriages and mounts in H (3, 3)."""
    from ssmash_gym.envs.rendering import Wheels

    batch = core.batch
    state, p = batch.state[:, k], batch.parameters[:, k]
    centres, axles, sizes, loads, stations, carriages, mounts = [], [], [], [], [], [], []
    for i, name in enumerate(STATION_NAMES):
        row, base = State.Q15 + STATION_COORDINATES * i, Par.STATION + i * STATION_ROWS
        R_HO = rotation(state[row + 1 : row + STATION_COORDINATES])
        mount = p[base + Sta.MOUNT : base + Sta.MOUNT + 3]
        r_OW_O = np.array([p[base + Sta.DROOP], p[base + Sta.DROOP + 1], state[row]])
        mounts.append(mount)
        carriages.append(mount + R_HO @ r_OW_O)
        tires = int(batch.mode[Mode.TIRES + i])
        for t in range(tires):
            tire = TIRE_PAR + (2 * i + t) * TIRE_ROWS
            centres.append(mount + R_HO @ (r_OW_O + p[tire + Tir.X : tire + Tir.Z + 1]))
            axles.append(R_SH @ R_HO[:, 1])
            sizes.append((p[tire + Tir.DIAMETER], p[tire + Tir.WIDTH]))
            loads.append(batch.telemetry[f"{name}_vertical_load"][k] / tires)
            stations.append(i)
    r_HW_H, r_HO_H = np.array(carriages), np.array(mounts)
    wheels = Wheels(
        r_ST_S=r_SH_S + np.array(centres) @ R_SH.T,
        axle_S=np.array(axles),
        diameter_m=np.array(sizes)[:, 0],
        width_m=np.array(sizes)[:, 1],
        load_N=np.array(loads),
        station=np.array(stations, dtype=np.intp),
        r_SO_S=r_SH_S + r_HO_H @ R_SH.T,
        r_SW_S=r_SH_S + r_HW_H @ R_SH.T,
    )
    return wheels, r_HW_H, r_HO_H
