"""What is to be drawn: one frozen record of plain numbers in SI units.

The renderer knows nothing of the dynamics; whoever wants a picture (an environment, a replay) fills a `Scene`.
Deck frame S: origin on the track's centre line at deck level, x forward (towards the hangar), y starboard, z down.
Helicopter frame H: origin at the centre of gravity, x forward, y starboard, z down. Inertial frame N: z down.
``R_AB`` takes B components to A components.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import atan2, radians

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float, float]

STATIONS = 3
STATION_LABELS = ("aux", "right", "left")


@dataclass(frozen=True, kw_only=True)
class Airframe:
    """Proportions of the drawn body, H axes, metres. For the eye only: nothing is computed from them.

    Attributes:
        nose_x: Foremost point.
        cabin_aft_x: Where the cabin ends and the tail boom begins.
        tail_x: Aft end of the tail boom.
        half_width: Half the cabin's width.
        floor_z: Belly (positive: below the centre of gravity).
        roof_z: Cabin roof (negative: above it).
        hub_x: Rotor mast.
        blade_length: Length of a folded main-rotor blade.
        mounts: Attachments of the auxiliary, the right and the left station.
    """

    nose_x: float = 5.45
    cabin_aft_x: float = -3.3
    tail_x: float = -9.3
    half_width: float = 1.15
    floor_z: float = 1.25
    roof_z: float = -0.95
    hub_x: float = 0.25
    blade_length: float = 7.2
    mounts: tuple[Point, Point, Point] = ((3.8, 0.0, 1.1), (-1.98, 1.6, 1.1), (-1.98, -1.6, 1.1))

    @classmethod
    def around(cls, r_HW_H: Array, r_HO_H: Array) -> Airframe:
        """Proportions that suit a landing gear.

        Args:
            r_HW_H: Wheel centres of the auxiliary, right and left station [m], H axes, (3, 3).
            r_HO_H: Their attachments to the helicopter [m], H axes, (3, 3).

        Returns:
            A body with the cabin ahead of a tail wheel or above a nose wheel, in whole centimetres.
        """
        wheels, mounts = np.asarray(r_HW_H, dtype=np.float64), np.asarray(r_HO_H, dtype=np.float64)
        auxiliary_x, main_x = float(wheels[0, 0]), float(wheels[1:, 0].mean())
        half_track = float(np.abs(wheels[1:, 1]).mean())
        floor = max(float(wheels[:, 2].mean()) - 0.72, float(mounts[1:, 2].mean()) - 0.05)  # struts start on the body
        nose_wheel = auxiliary_x > main_x
        nose_x = auxiliary_x + 1.7 if nose_wheel else main_x + 3.4
        auxiliary, right, left = ((round(float(m[0]), 2), round(float(m[1]), 2), round(float(m[2]), 2)) for m in mounts)
        # Whole centimetres: helicopters that stand a little differently share one mesh.
        return cls(
            nose_x=round(nose_x, 2),
            cabin_aft_x=round(main_x - 1.3 if nose_wheel else nose_x - 7.0, 2),
            tail_x=round(main_x - 7.3 if nose_wheel else min(nose_x - 14.0, auxiliary_x - 2.5), 2),
            half_width=round(min(1.15, max(0.7, half_track - 0.4)), 2),
            floor_z=round(floor, 2),
            roof_z=round(floor - 2.2, 2),
            hub_x=round(nose_x - 5.2, 2),
            mounts=(auxiliary, right, left),
        )


@dataclass(frozen=True, kw_only=True)
class Track:
    """The deck's markings and the goal, S axes.

    Attributes:
        start_x_m: Claw position where the track begins [m].
        goal_x_m: Claw position to reach [m].
        goal_tolerance_m: Half-width of the goal along the track [m].
        lateral_tolerance_m: Half-width of the goal across the track [m].
        yaw_tolerance_rad: Largest yaw at the goal [rad].
        corridor_m: Largest distance of a wheel from the centre line on the open deck [m].
        door_corridor_m: The same from claw position `door_claw_x_m` on [m].
        door_claw_x_m: Claw position from which the narrow corridor counts [m].
        hangar_door_x_m: Where the door frame is drawn [m].
    """

    start_x_m: float = 0.0
    goal_x_m: float = 8.0
    goal_tolerance_m: float = 0.05
    lateral_tolerance_m: float = 0.05
    yaw_tolerance_rad: float = radians(1.0)
    corridor_m: float = 2.6
    door_corridor_m: float = 2.1
    door_claw_x_m: float = 6.0
    hangar_door_x_m: float = 9.8


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Loads and angles at which the colours change.

    Attributes:
        probe_soft_N: In-plane probe load above which the reward falls [N].
        probe_cost_N: In-plane probe load that counts as a cost [N].
        probe_ultimate_N: In-plane probe load that ends the run [N].
        station_N: Vertical load of a station that counts as a cost [N].
        lift_off_N: Vertical load of a station below which it counts as lifted [N].
        roll_rad: Relative roll that counts as overturned [rad].
    """

    probe_soft_N: float = 6e3
    probe_cost_N: float = 15e3
    probe_ultimate_N: float = 75e3
    station_N: float = 90e3
    lift_off_N: float = 2e3
    roll_rad: float = radians(25.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Wheels:
    """Tires and struts at their true places, S axes. n tires, 3 stations (auxiliary, right, left).

    Attributes:
        r_ST_S: Tire centres [m], (n, 3).
        axle_S: Unit vectors along the wheel axles, (n, 3).
        diameter_m: Undeflected tire diameters [m], (n,).
        width_m: Tire widths [m], (n,).
        load_N: Vertical tire loads [N], (n,).
        station: Station 0, 1 or 2 of each tire, (n,).
        r_SO_S: Attachments of the stations to the helicopter [m], (3, 3).
        r_SW_S: Wheel carriages [m], (3, 3).
    """

    r_ST_S: Array
    axle_S: Array
    diameter_m: Array
    width_m: Array
    load_N: Array
    station: NDArray[np.intp]
    r_SO_S: Array
    r_SW_S: Array

    @property
    def station_load_N(self) -> Array:
        """Vertical load of each station [N], (3,)."""
        return np.bincount(self.station, weights=self.load_N, minlength=STATIONS).astype(np.float64)


def _empty(*shape: int) -> Array:
    return np.zeros(shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class History:
    """Past loads for the traces, oldest first; the renderer shows the last 30 s.

    Attributes:
        time_s: Instants [s], (k,), rising.
        probe_N: In-plane probe load [N], (k,); interval peaks or instantaneous values, as the caller likes.
        station_N: Vertical load of the auxiliary, right and left station [N], (k, 3).
    """

    time_s: Array = field(default_factory=lambda: _empty(0))
    probe_N: Array = field(default_factory=lambda: _empty(0))
    station_N: Array = field(default_factory=lambda: _empty(0, STATIONS))


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """One picture's worth of numbers. Everything in SI and finite; nothing in it is changed by drawing.

    Attributes:
        time_s: Time since the start of the task [s].
        horizon_s: Time at which the run is cut off [s].
        r_SH_S: Helicopter's centre of gravity [m], S axes, (3,).
        R_SH: Helicopter's attitude, H components to S components, (3, 3).
        wheels: Tires and struts.
        r_SC_S: Claw centre [m], S axes, (3,).
        r_SA_S: Where the probe leaves the helicopter [m], S axes, (3,).
        r_SB_S: The probe's tip, on the claw plane [m], S axes, (3,).
        probe_force_S: Securing-probe force on the helicopter [N], S axes, (3,).
        captured: Whether the claw holds the probe; a free probe is drawn so and has no force arrow.
        r_NS_N: Deck origin from its mean place [m], N axes (z down), (3,).
        R_NS: Deck's attitude, S components to N components, (3, 3).
        claw_velocity_S: Claw velocity along and across the track [m/s], (2,).
        claw_command: Normalised command along and across the track, each from -1 to 1, (2,).
        lateral_m: Lateral offset that the task counts [m]; by default that of the probe's tip.
        history: Past loads.
        track: Markings, corridor, goal.
        limits: Loads at which colours change.
        airframe: Proportions of the body.
        ship_speed_m_s: Speed at which the drawn sea streams aft [m/s].
        lines: Further lines of text for the right column, as many as fit (five or so).
        outcome: Why the run ended, in words; empty while it runs.
        success: Whether that end was the goal.
    """

    time_s: float
    r_SH_S: Array
    R_SH: Array
    wheels: Wheels
    r_SC_S: Array
    r_SA_S: Array
    r_SB_S: Array
    probe_force_S: Array = field(default_factory=lambda: _empty(3))
    captured: bool = True
    r_NS_N: Array = field(default_factory=lambda: _empty(3))
    R_NS: Array = field(default_factory=lambda: np.eye(3))
    claw_velocity_S: Array = field(default_factory=lambda: _empty(2))
    claw_command: Array = field(default_factory=lambda: _empty(2))
    lateral_m: float | None = None
    horizon_s: float = 60.0
    history: History = field(default_factory=History)
    track: Track = field(default_factory=Track)
    limits: Limits = field(default_factory=Limits)
    airframe: Airframe = field(default_factory=Airframe)
    ship_speed_m_s: float = 0.0
    lines: tuple[str, ...] = ()
    outcome: str = ""
    success: bool = False

    @property
    def angles_SH(self) -> tuple[float, float, float]:
        """Roll, pitch and yaw of the helicopter relative to the deck [rad] (yaw-pitch-roll sequence)."""
        return roll_pitch_yaw(self.R_SH)

    @property
    def angles_NS(self) -> tuple[float, float, float]:
        """Roll, pitch and yaw of the deck [rad] (yaw-pitch-roll sequence)."""
        return roll_pitch_yaw(self.R_NS)

    @property
    def lateral(self) -> float:
        """Lateral offset shown and judged [m]."""
        return float(self.r_SB_S[1]) if self.lateral_m is None else self.lateral_m

    @property
    def to_go_m(self) -> float:
        """Claw's distance to the goal along the track [m]."""
        return self.track.goal_x_m - float(self.r_SC_S[0])

    @property
    def in_plane_force_S(self) -> Array:
        """The probe force without its part along the helicopter's z axis [N], S axes, (3,)."""
        h_z = self.R_SH[:, 2]
        return self.probe_force_S - float(self.probe_force_S @ h_z) * h_z

    @property
    def probe_in_plane_N(self) -> float:
        """Magnitude of the in-plane probe load [N]."""
        return float(np.linalg.norm(self.in_plane_force_S))

    @property
    def probe_axial_N(self) -> float:
        """Pull of the probe along the helicopter's z axis (positive: downwards) [N]."""
        return float(self.probe_force_S @ self.R_SH[:, 2])


def roll_pitch_yaw(R_AB: Array) -> tuple[float, float, float]:
    """Yaw-pitch-roll (z-y-x) Euler angles of B relative to A, returned as roll, pitch, yaw [rad]."""
    pitch = atan2(-R_AB[2, 0], float(np.hypot(R_AB[2, 1], R_AB[2, 2])))
    return atan2(R_AB[2, 1], R_AB[2, 2]), pitch, atan2(R_AB[1, 0], R_AB[0, 0])


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Matrix ``R_AB`` of yaw-pitch-roll (z-y-x) Euler angles of B relative to A [rad], (3, 3)."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
