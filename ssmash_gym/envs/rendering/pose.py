"""From the kernel's rows to the part of a scene that is the helicopter.

A convenience for whoever holds a state and its parameters; the forces stay with the telemetry.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import (
    STATION_COORDINATES,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.envs.rendering.scene import Airframe, Wheels

Array = NDArray[np.float64]


class Pose(TypedDict):
    """Fields of a `Scene` that follow from the state: ``Scene(time_s=t, r_SC_S=claw, **pose)``."""

    r_SH_S: Array
    R_SH: Array
    wheels: Wheels
    r_SA_S: Array
    r_SB_S: Array


def helicopter_pose(state: Array, parameters: Array, tires: Sequence[int], station_load_N: Sequence[float]) -> Pose:
    """Where the body, struts, wheels and the probe are.

    Args:
        state: One helicopter's state, rows of `layout.State`, (STATE_ROWS,).
        parameters: Its parameters, rows of `layout.Par`, (PARAMETER_ROWS,).
        tires: Tires of the auxiliary, right and left station, each 0 to 2.
        station_load_N: Vertical load of each station [N]; its tires are drawn as carrying equal shares.

    Returns:
        Fields of a scene. The probe's tip is where the probe's axis meets the claw plane, or the probe's own end where
        that is higher.
    """
    r_SH_S = np.array(state[State.Q8 : State.Q8 + 3])
    R_SH = euler_matrix(state[State.Q11 : State.Q11 + 4])
    mounts, carriages, centres, axles, rows, station = [], [], [], [], [], []
    for i in range(STATIONS):
        row = int(Par.STATION) + i * STATION_ROWS
        joint = int(State.Q15) + i * STATION_COORDINATES
        R_SO = R_SH @ euler_matrix(state[joint + 1 : joint + 5])
        droop = parameters[row + Sta.DROOP : row + Sta.DROOP + 3]
        mount = r_SH_S + R_SH @ parameters[row + Sta.MOUNT : row + Sta.MOUNT + 3]
        carriage = mount + R_SO @ np.array([droop[0], droop[1], state[joint]])
        mounts.append(mount)
        carriages.append(carriage)
        for t in range(tires[i]):
            tire = TIRE_PAR + (2 * i + t) * TIRE_ROWS
            centres.append(carriage + R_SO @ parameters[tire + Tir.X : tire + Tir.X + 3])
            axles.append(R_SO[:, 1])
            rows.append(tire)
            station.append(i)
    share = np.array([station_load_N[i] / tires[i] for i in station], dtype=np.float64)
    wheels = Wheels(
        r_ST_S=np.reshape(centres, (-1, 3)),
        axle_S=np.reshape(axles, (-1, 3)),
        diameter_m=np.array([parameters[r + Tir.DIAMETER] for r in rows]),
        width_m=np.array([parameters[r + Tir.WIDTH] for r in rows]),
        load_N=share,
        station=np.array(station, dtype=np.intp),
        r_SO_S=np.array(mounts),
        r_SW_S=np.array(carriages),
    )
    r_SA_S = r_SH_S + R_SH @ parameters[Par.PROBE_MOUNT : Par.PROBE_MOUNT + 3]
    probe = R_SH @ parameters[Par.PROBE_VECTOR : Par.PROBE_VECTOR + 3]
    reach = (parameters[Par.CLAW_Z] - r_SA_S[2]) / max(float(probe[2]), 1e-9)
    return Pose(
        r_SH_S=r_SH_S, R_SH=R_SH, wheels=wheels, r_SA_S=r_SA_S, r_SB_S=r_SA_S + min(max(reach, 0.0), 1.0) * probe
    )


def airframe_for(pose: Pose) -> Airframe:
    """A body that suits the landing gear as it stands in this pose."""
    wheels, R_HS = pose["wheels"], pose["R_SH"].T
    return Airframe.around((wheels.r_SW_S - pose["r_SH_S"]) @ R_HS.T, (wheels.r_SO_S - pose["r_SH_S"]) @ R_HS.T)


def euler_matrix(e: Array) -> Array:
    """Rotation matrix of unit Euler parameters, rotated frame to non-rotated frame, (3, 3)."""
    e0, e1, e2, e3 = (float(x) for x in e)
    return np.array(
        [
            [2.0 * (e0 * e0 + e1 * e1) - 1.0, 2.0 * (e1 * e2 - e0 * e3), 2.0 * (e1 * e3 + e0 * e2)],  # (2.5)
            [2.0 * (e1 * e2 + e0 * e3), 2.0 * (e0 * e0 + e2 * e2) - 1.0, 2.0 * (e2 * e3 - e0 * e1)],
            [2.0 * (e1 * e3 - e0 * e2), 2.0 * (e2 * e3 + e0 * e1), 2.0 * (e0 * e0 + e3 * e3) - 1.0],
        ]
    )
