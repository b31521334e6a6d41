"""From the description of a helicopter to the numbers that the kernels read.

One helicopter is one column of the parameter table, a short vector of integer modes, and a state to start from.
Claw, ripple and external wrenches belong to the scenario: their rows stay 0 here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import (
    MODES,
    PARAMETER_ROWS,
    STATE_ROWS,
    STATION_COORDINATES,
    STATION_ROWS,
    TIRE_PAR,
    TIRE_ROWS,
    ClawDrive,
    Contact,
    Friction,
    Mode,
    Par,
    ProbeLaw,
    Spring,
    Sta,
    State,
    StationKind,
    Tir,
    TireModel,
)
from ssmash_gym.dynamics.oleo import region2_constants
from ssmash_gym.errors import ConfigurationError, refusal
from ssmash_gym.vehicle.description import Helicopter
from ssmash_gym.vehicle.geometry import lowest_points, rotation, strut_length
from ssmash_gym.vehicle.oleo import GasOleo, LinearStrut
from ssmash_gym.vehicle.station import Station, SteerPlay
from ssmash_gym.vehicle.tire import Tire

Array = NDArray[np.float64]

_KINDS: Final = {"prismatic": StationKind.PRISMATIC, "swing_arm": StationKind.SWING_ARM}
_TIRE_MODELS: Final = {"smiley_horne": TireModel.SMILEY_HORNE, "linear": TireModel.LINEAR}
_CHOICES: Final[dict[str, type[IntEnum]]] = {
    "contact": Contact,
    "friction": Friction,
    "probe_law": ProbeLaw,
    "claw": ClawDrive,
}


@dataclass(frozen=True)
class Modes:
    """Choices between laws that hold for a whole batch, by name.

    Args:
        contact: Where the tire's travel over the deck is taken: ``contact`` (default) or ``centre`` (thesis).
        friction: ``limit_surface`` (default), ``friction_circle`` or ``independent`` (thesis).
        probe_law: ``potential`` (default), ``ellipse`` or ``printed`` (thesis).
        claw: ``commanded`` (default) or ``prescribed``.

    Raises:
        ConfigurationError: A name is unknown. Hyphens and capitals do not matter.
    """

    contact: str = "contact"
    friction: str = "limit_surface"
    probe_law: str = "potential"
    claw: str = "commanded"

    def __post_init__(self) -> None:
        for key, choices in _CHOICES.items():
            given = getattr(self, key)
            name = str(given).lower().replace("-", "_")
            if name.upper() not in choices.__members__:
                known = ", ".join(member.name.lower() for member in choices)
                raise refusal("modes", key, given, f"it must be one of {known}")
            object.__setattr__(self, key, name)

    def number(self, key: str) -> int:
        """The number by which the kernels know a choice."""
        return int(_CHOICES[key][getattr(self, key).upper()])


def mode_vector(helicopter: Helicopter, modes: Modes | None = None) -> NDArray[np.int64]:
    """Make the integer modes of a helicopter, shape (MODES,), rows of `ssmash_gym.dynamics.layout.Mode`.

    Args:
        helicopter: The helicopter.
        modes: Choices between laws; the defaults if None.
    """
    modes = modes or Modes()
    vector = np.zeros(MODES, dtype=np.int64)
    for i, station in enumerate(helicopter.station_tuple):
        vector[Mode.STATION_KIND + i] = _KINDS[station.kind]
        vector[Mode.SPRING + i] = Spring.GAS_OLEO if isinstance(station.spring, GasOleo) else Spring.LINEAR
        vector[Mode.TIRES + i] = len(station.tires)
        vector[Mode.PLAY + i] = int(station.steer_play is not None)
    vector[Mode.TIRE_MODEL] = _TIRE_MODELS[helicopter.tire_model]
    vector[Mode.CONTACT] = modes.number("contact")
    vector[Mode.FRICTION] = modes.number("friction")
    vector[Mode.PROBE_LAW] = modes.number("probe_law")
    vector[Mode.CLAW] = modes.number("claw")
    return vector


def common_mode(helicopters: Sequence[Helicopter], modes: Modes) -> NDArray[np.int64]:
    """The mode vector shared by all descriptions.

    Raises:
        ConfigurationError: they differ: one batch has one layout.
    """
    vectors = [mode_vector(h, modes) for h in {id(h): h for h in helicopters}.values()]
    if any(np.any(v != vectors[0]) for v in vectors):
        names = ", ".join(sorted({h.name for h in helicopters}))
        raise ConfigurationError(f"helicopters of one batch must have one layout (stations, springs, tires): {names}")
    return np.asarray(vectors[0])


def parameter_column(helicopter: Helicopter) -> Array:
    """Make the parameters of a helicopter, shape (PARAMETER_ROWS,), rows and units of `ssmash_gym.dynamics.layout`.

    Coordinates are turned from the description's reference point to the body's c.g. The rows of the claw, the ripple,
    the external wrenches, the gusts and the patch are 0, and so are those of what the helicopter does not have: a
    spring element, a tire, free play.

    Args:
        helicopter: The helicopter.
    """
    column = np.zeros(PARAMETER_ROWS)
    cg = np.array(helicopter.cg_offset_m)
    column[Par.MASS] = helicopter.mass_kg
    column[Par.IXX : Par.IZZ + 1] = _upper(helicopter.inertia_kgm2)
    column[Par.GRAVITY] = helicopter.surroundings.gravity_mps2
    column[Par.CP : Par.CP + 3] = helicopter.aerodynamics.centre_of_pressure_m - cg
    column[Par.AREA : Par.AREA + 3] = helicopter.aerodynamics.drag_areas_m2
    column[Par.AIR_DENSITY] = helicopter.surroundings.air_density_kgpm3
    column[Par.WIND : Par.WIND + 3] = helicopter.aerodynamics.wind_N_mps
    _fill_probe(column, helicopter, cg)
    for i, station in enumerate(helicopter.station_tuple):
        start = Par.STATION + i * STATION_ROWS
        _fill_station(column[start : start + STATION_ROWS], station, cg)
        # A locked steering without play holds u14, u16 or u18 at 0.
        column[Par.LOCK + State.U14 + 2 * i] = float(station.steering == "locked" and station.steer_play is None)
        for k, tire in enumerate(station.tires):
            start = TIRE_PAR + (2 * i + k) * TIRE_ROWS
            _fill_tire(column[start : start + TIRE_ROWS], tire, helicopter.surroundings.atmospheric_pressure_Pa)
    return column


def _upper(tensor: tuple[tuple[float, float, float], ...]) -> tuple[float, ...]:
    return tuple(tensor[i][j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


def _fill_probe(column: Array, helicopter: Helicopter, cg: Array) -> None:
    probe = helicopter.probe
    column[Par.PROBE_ACTIVE] = float(probe.active)
    column[Par.PROBE_MOUNT : Par.PROBE_MOUNT + 3] = probe.mount_m - cg
    column[Par.PROBE_VECTOR : Par.PROBE_VECTOR + 3] = probe.vector_m
    column[Par.PROBE_KS_X] = probe.small_stiffness_x_Npm
    column[Par.PROBE_KS_Y] = probe.small_stiffness_y_Npm
    column[Par.PROBE_KL_X] = probe.large_stiffness_x_Npm
    column[Par.PROBE_KL_Y] = probe.large_stiffness_y_Npm
    column[Par.PROBE_D_X] = probe.transition_x_m
    column[Par.PROBE_D_Y] = probe.transition_y_m
    column[Par.PROBE_C_X] = probe.damping_x_Nspm
    column[Par.PROBE_C_Y] = probe.damping_y_Nspm
    column[Par.PROBE_C_Z] = probe.damping_z_Nspm
    column[Par.PROBE_D_Z] = probe.transition_z_m
    column[Par.PROBE_KS_Z] = probe.small_stiffness_z_Npm
    column[Par.PROBE_KL_Z] = probe.large_stiffness_z_Npm
    column[Par.PROBE_CAPTURE_RADIUS] = probe.capture_radius_m
    column[Par.PROBE_ULTIMATE] = probe.ultimate_load_N


def _fill_station(rows: Array, station: Station, cg: Array) -> None:
    rows[Sta.MASS] = station.mass_kg
    rows[Sta.IXX : Sta.IZZ + 1] = _upper(station.inertia_kgm2)
    rows[Sta.MOUNT : Sta.MOUNT + 3] = station.mount_m - cg
    rows[Sta.DROOP : Sta.DROOP + 3] = station.droop_m
    if station.arm is not None:
        rows[Sta.P1 : Sta.P1 + 3] = station.arm.helicopter_point_m - cg
        rows[Sta.P2 : Sta.P2 + 3] = station.arm.arm_point_m
        rows[Sta.LENGTH] = strut_length(station)
    rows[Sta.ROLL_LOCK] = float(station.rolling == "locked")
    rows[Sta.STEER_MU] = station.steer_friction_m
    rows[Sta.STEER_C] = station.steer_damping_Nmspr
    rows[Sta.STEER_BETA] = station.steer_decay_spr
    if station.steer_play is not None:
        _fill_play(rows, station, station.steer_play)
    rows[Sta.STROKE] = station.end_stop.stroke_m
    rows[Sta.STOP_K] = station.end_stop.stiffness_Npm
    rows[Sta.STOP_C] = station.end_stop.damping_Nspm
    if isinstance(station.spring, LinearStrut):
        rows[Sta.LINEAR_K] = station.spring.stiffness_Npm
        rows[Sta.LINEAR_C] = station.spring.damping_Nspm
    else:
        _fill_oleo(rows, station.spring)


def _fill_play(rows: Array, station: Station, play: SteerPlay) -> None:
    rows[Sta.STEER_PLAY] = play.play_rad
    rows[Sta.STEER_STOP_K], rows[Sta.STEER_STOP_C] = play.stop_stiffness_Nmprad, play.stop_damping_Nmspr
    half = np.array([station.orientation[0], station.orientation[3]])  # of the angle at which it is locked
    rows[Sta.STEER_COS : Sta.STEER_SIN + 1] = half / np.linalg.norm(half)


def _fill_oleo(rows: Array, oleo: GasOleo) -> None:
    rows[Sta.X0], rows[Sta.X1], rows[Sta.X2] = oleo.x0_m, oleo.x1_m, oleo.x2_m
    rows[Sta.K] = oleo.extension_stiffness_Npm
    rows[Sta.GAS_P] = oleo.gas_pressure_Pa
    rows[Sta.GAS_V] = oleo.gas_volume_m3
    rows[Sta.GAS_A] = oleo.piston_area_m2
    rows[Sta.GAS_GAMMA] = oleo.gas_exponent
    rows[Sta.P_REF] = oleo.reference_pressure_Pa
    gas = (oleo.gas_pressure_Pa, oleo.gas_volume_m3, oleo.piston_area_m2, oleo.gas_exponent)
    rows[Sta.R2_C], rows[Sta.R2_D] = region2_constants(
        *gas, oleo.x0_m, oleo.extension_stiffness_Npm, oleo.reference_pressure_Pa
    )
    rows[Sta.E1], rows[Sta.F1], rows[Sta.G1] = oleo.region4
    rows[Sta.E2], rows[Sta.F2], rows[Sta.G2] = oleo.region5
    rows[Sta.C01], rows[Sta.C02], rows[Sta.C03] = oleo.c01_N, oleo.c02_Nspm, oleo.c03_Ns2pm2
    rows[Sta.C1], rows[Sta.C2], rows[Sta.C3] = oleo.c1_N, oleo.c2_Nspm, oleo.c3_Ns2pm2
    rows[Sta.C4], rows[Sta.C5], rows[Sta.C6] = oleo.c4_N, oleo.c5_Nspm, oleo.c6_Ns2pm2
    rows[Sta.C7], rows[Sta.C8], rows[Sta.C9] = oleo.c7_N, oleo.c8_Nspm, oleo.c9_Ns2pm2
    rows[Sta.REL1], rows[Sta.REL2] = oleo.relief_1_N, oleo.relief_2_N
    rows[Sta.SEAL] = oleo.seal_drag_N
    rows[Sta.BEARING_Z] = oleo.bearing_z_m
    rows[Sta.BEARING_L0] = oleo.bearing_separation_m
    rows[Sta.BEARING_MU] = oleo.bearing_friction
    rows[Sta.BETA] = oleo.friction_decay_spm


def _fill_tire(rows: Array, tire: Tire, atmosphere: float) -> None:
    rows[Tir.X : Tir.Z + 1] = tire.position_m
    rows[Tir.DIAMETER], rows[Tir.WIDTH] = tire.diameter_m, tire.width_m
    rows[Tir.AXLE_RADIUS] = tire.axle_radius_m
    rows[Tir.P_O], rows[Tir.P_R] = tire.pressure_Pa, tire.rated_pressure_Pa
    rows[Tir.P_ABS] = tire.pressure_Pa + atmosphere
    rows[Tir.TYPE_I] = float(tire.type == "I")
    rows[Tir.MU], rows[Tir.MU_RR] = tire.friction_coefficient, tire.rolling_resistance
    rows[Tir.MU_AXLE] = tire.axle_friction
    rows[Tir.CTZ] = tire.vertical_constant
    rows[Tir.CX], rows[Tir.CY], rows[Tir.CZ] = tire.damping_x_Nspm, tire.damping_y_Nspm, tire.damping_z_Nspm
    rows[Tir.BETA] = tire.rolling_decay_spm
    rows[Tir.SIGMA_MIN] = tire.minimum_relaxation_m
    rows[Tir.BOTTOM], rows[Tir.BOTTOM_K] = tire.bottoming_deflection_m, tire.bottoming_stiffness_Npm
    rows[Tir.PULL] = tire.pull_back_rate_ps
    rows[Tir.MY_COEFF] = tire.pitch_moment_coefficient
    if tire.linear is not None:
        rows[Tir.LIN_KZ] = tire.linear.vertical_stiffness_Npm
        rows[Tir.LIN_KX] = tire.linear.longitudinal_stiffness_Npm
        rows[Tir.LIN_KY] = tire.linear.lateral_stiffness_Npm
        rows[Tir.LIN_KPSI] = tire.linear.twist_stiffness_Nmprad
        rows[Tir.LIN_SIGMA] = tire.linear.relaxation_length_m


def droop_state(
    helicopter: Helicopter,
    *,
    position_S: tuple[float, float, float] | None = None,
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0),
) -> Array:
    """Make a state at rest with every suspension at full droop, shape (STATE_ROWS,).

    Args:
        helicopter: The helicopter.
        position_S: Body c.g. from the ship-frame origin, S axes [m]; None puts it over the origin, with the lowest tire
            just touching the deck.
        orientation: Euler parameters H to S; level and straight by default.
    """
    state = np.zeros(STATE_ROWS)
    R_SH = rotation(orientation)
    if position_S is None:
        feet = np.concatenate([lowest_points(station, R_SH) for station in helicopter.station_tuple])
        position_S = (0.0, 0.0, -float(feet[:, 2].max() - (R_SH @ np.array(helicopter.cg_offset_m))[2]))
    state[State.Q8 : State.Q10 + 1] = position_S
    state[State.Q11 : State.Q14 + 1] = unit(orientation)
    for i, station in enumerate(helicopter.station_tuple):
        row = State.Q15 + i * STATION_COORDINATES
        state[row] = station.droop_m[2]
        state[row + 1 : row + STATION_COORDINATES] = unit(station.orientation)
    state[State.PROBE_CAPTURED] = float(helicopter.probe.captured)
    return state


def unit(parameters: Sequence[float]) -> Array:
    """Euler parameters brought to unit length, (4,)."""
    vector = np.array(parameters)
    return np.asarray(vector / np.linalg.norm(vector))
