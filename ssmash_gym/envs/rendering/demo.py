"""A made-up scene, for tests, the documentation's picture and a look at the renderer without a simulation."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering.scene import History, Scene, Wheels, rotation

Array = NDArray[np.float64]

# A nose-wheel helicopter in rough proportion: carriages at rest and mounts from the centre of gravity, H axes [m].
_CARRIAGES: Final = np.array([[3.77, 0.0, 2.04], [-1.98, 1.60, 1.99], [-1.98, -1.60, 1.99]])
_MOUNTS: Final = np.array([[3.82, 0.0, 1.10], [-1.98, 1.60, 1.05], [-1.98, -1.60, 1.05]])
_HEIGHT: Final = 2.29
_SPREAD: Final = 0.15  # half the distance between the twin tires
_DIAMETER: Final = np.array([0.56, 0.66, 0.66])
_WIDTH: Final = np.array([0.17, 0.20, 0.20])


def demo_scene(progress: float = 0.45, *, motion: float = 1.0) -> Scene:
    """A helicopter on its way to the hangar, in a seaway.

    Nothing here is simulated: poses and loads are smooth made-up functions of the progress.

    Args:
        progress: Share of the track, 0 to 1.
        motion: Size of the deck's motion; 0 is a deck at rest, 1 a fresh sea.

    Returns:
        A complete scene.
    """
    time = 6.0 + 42.0 * progress
    phase = 2.0 * pi * time / 9.0
    yaw, side, claw_x = radians(7.0 * (1.0 - progress) ** 2), 0.09 * (1.0 - progress), 8.0 * progress
    roll = motion * radians(1.3) * sin(phase)
    R_SH = rotation(roll, radians(0.4), yaw)
    r_SH_S = np.array([claw_x, side, -_HEIGHT])
    sway = motion * sin(phase)
    station_N = 34e3 + np.array([-1.5e3 * cos(phase) * motion, 16e3 * sway, -16e3 * sway])
    force = np.array([1.2e3 + 2.0e3 * cos(0.7 * phase), -7.5e3 * sway, 0.0])
    tip = np.array([r_SH_S[0] + 0.004, r_SH_S[1], -0.06])
    claw = tip - force / 1.2e6
    return Scene(
        time_s=time,
        r_SH_S=r_SH_S,
        R_SH=R_SH,
        wheels=_wheels(r_SH_S, R_SH, station_N),
        r_SC_S=claw,
        r_SA_S=r_SH_S + R_SH @ np.array([0.0, 0.0, 1.25]),
        r_SB_S=tip,
        probe_force_S=force,
        r_NS_N=motion * np.array([0.15 * cos(phase), 0.4 * sin(phase - 0.4), 0.8 * cos(phase)]),
        R_NS=rotation(motion * radians(4.0) * sin(phase), motion * radians(1.2) * cos(phase), motion * radians(0.3)),
        claw_velocity_S=np.array([0.2, -0.02 * sway]),
        claw_command=np.array([0.67, -0.2 * sway]),
        history=_history(time, motion),
        ship_speed_m_s=5.0,
        lines=("made-up demonstration",),
    )


def _wheels(r_SH_S: Array, R_SH: Array, station_N: Array) -> Wheels:
    """Twin tires under the struts; each carriage follows the body and rests on the deck."""
    station = np.repeat(np.arange(3), 2)
    carriage = r_SH_S + _CARRIAGES @ R_SH.T
    radius, deflection = 0.5 * _DIAMETER, station_N / 1.5e6
    carriage[:, 2] = -(radius - deflection)
    axle = np.repeat(R_SH[:, 1][None, :], 6, axis=0)
    spread = np.tile([_SPREAD, -_SPREAD], 3)[:, None] * axle
    return Wheels(
        r_ST_S=carriage[station] + spread,
        axle_S=axle,
        diameter_m=_DIAMETER[station],
        width_m=_WIDTH[station],
        load_N=0.5 * station_N[station],
        station=station,
        r_SO_S=r_SH_S + _MOUNTS @ R_SH.T,
        r_SW_S=carriage,
    )


def _history(time: float, motion: float) -> History:
    past = np.arange(0.0, time + 0.05, 0.1)
    phase = 2.0 * np.pi * past / 9.0
    sway = motion * np.sin(phase)
    probe = np.hypot(1.2e3 + 2.0e3 * np.cos(0.7 * phase), 7.5e3 * sway)
    station = 34e3 + np.stack([-1.5e3 * motion * np.cos(phase), 16e3 * sway, -16e3 * sway], axis=1)
    return History(time_s=past, probe_N=probe, station_N=station)
