"""HELI.INP: 68 lines that describe the helicopter (Léveillé 2013, appendix A).

Paths are those of a helicopter's document, see `ssmash_gym.vehicle`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from ssmash_gym.thesis_files.layout import STATIONS, Column, Line, euler_parameters, per_station, vector

# Name, unit, key of the description, meaning.
_TIRE: Final = (
    ("x", "m", "position_m.0", "tire centre from the carriage's c.g., wheel axes, x"),
    ("y", "m", "position_m.1", "tire centre from the carriage's c.g., wheel axes, y"),
    ("z", "m", "position_m.2", "tire centre from the carriage's c.g., wheel axes, z"),
    ("d_t", "m", "diameter_m", "unloaded diameter"),
    ("w_t", "m", "width_m", "nominal width"),
    ("r_axle", "m", "axle_radius_m", "radius of the axle"),
    ("P_o", "Pa", "pressure_Pa", "inflation pressure of the unloaded tire"),
    ("P_r", "Pa", "rated_pressure_Pa", "rated inflation pressure"),
    ("type", "", "type", "standard type designation"),
    ("mu", "", "friction_coefficient", "greatest coefficient of friction with the deck"),
    ("mu_rr", "", "rolling_resistance", "coefficient of rolling resistance"),
    ("mu_axle", "", "axle_friction", "friction coefficient of the axle"),
    ("C_tz", "", "vertical_constant", "constant of the vertical deflection"),
    ("C_x", "N s/m", "damping_x_Nspm", "longitudinal damping rate"),
    ("C_y", "N s/m", "damping_y_Nspm", "lateral damping rate"),
    ("C_z", "N s/m", "damping_z_Nspm", "vertical damping rate"),
)
TIRE_TYPES: Final = {1: "I", 3: "III", 7: "VII"}
NO_TIRE: Final = {0: "no tire"}  # in a line of zeros

_OLEO: Final = (
    ("x_0", "m", "x0_m", "compression at which region 2 ends"),
    ("x_1", "m", "x1_m", "compression at which region 3 ends"),
    ("x_2", "m", "x2_m", "compression at which region 4 ends"),
    ("k", "N/m", "extension_stiffness_Npm", "spring rate past full droop"),
    ("P", "Pa", "gas_pressure_Pa", "gas pressure at full droop"),
    ("V", "m3", "gas_volume_m3", "gas volume at full droop"),
    ("A", "m2", "piston_area_m2", "piston area"),
    ("gamma", "", "gas_exponent", "ratio of the gas' specific heats"),
    ("e_1", "N/m", "e1_Npm", "linear spring constant of region 4"),
    ("e_2", "N/m", "e2_Npm", "linear spring constant of region 5"),
    ("f_1", "N/m2", "f1_Npm2", "quadratic spring constant of region 4"),
    ("f_2", "N/m2", "f2_Npm2", "quadratic spring constant of region 5"),
    ("g_1", "N/m3", "g1_Npm3", "cubic spring constant of region 4"),
    ("g_2", "N/m3", "g2_Npm3", "cubic spring constant of region 5"),
    ("c_01", "N", "c01_N", "extension damping, constant"),
    ("c_02", "N s/m", "c02_Nspm", "extension damping, linear"),
    ("c_03", "N s2/m2", "c03_Ns2pm2", "extension damping, quadratic"),
    ("c_1", "N", "c1_N", "first compression damping curve, constant"),
    ("c_2", "N s/m", "c2_Nspm", "first compression damping curve, linear"),
    ("c_3", "N s2/m2", "c3_Ns2pm2", "first compression damping curve, quadratic"),
    ("c_4", "N", "c4_N", "second compression damping curve, constant"),
    ("c_5", "N s/m", "c5_Nspm", "second compression damping curve, linear"),
    ("c_6", "N s2/m2", "c6_Ns2pm2", "second compression damping curve, quadratic"),
    ("c_7", "N", "c7_N", "third compression damping curve, constant"),
    ("c_8", "N s/m", "c8_Nspm", "third compression damping curve, linear"),
    ("c_9", "N s2/m2", "c9_Ns2pm2", "third compression damping curve, quadratic"),
    ("F_rel1", "N", "relief_1_N", "first compression damping relief force"),
    ("F_rel2", "N", "relief_2_N", "second compression damping relief force"),
    ("F_seal", "N", "seal_drag_N", "seal drag"),
    ("r_Ob1", "m", "bearing_z_m", "lower shaft bearing from the oleo frame's origin along o_z"),
    ("l_b20", "m", "bearing_separation_m", "distance of the shaft bearings at full droop"),
    ("mu_bearing", "", "bearing_friction", "friction coefficient of the shaft bearings"),
    ("beta", "s/m", "friction_decay_spm", "decay constant of the friction's smoothing"),
)

_PROBE: Final = (
    (44, "small_stiffness_x_Npm", "N/m", "stiffness at small displacement, x, K_PS,x"),
    (45, "small_stiffness_y_Npm", "N/m", "stiffness at small displacement, y, K_PS,y"),
    (46, "large_stiffness_x_Npm", "N/m", "stiffness at large displacement, x, K_PL,x"),
    (47, "large_stiffness_y_Npm", "N/m", "stiffness at large displacement, y, K_PL,y"),
    (48, "transition_x_m", "m", "displacement between the two stiffnesses, x, D_PS,x"),
    (49, "transition_y_m", "m", "displacement between the two stiffnesses, y, D_PS,y"),
    (50, "damping_x_Nspm", "N s/m", "damping rate, x, C_Px"),
    (51, "damping_y_Nspm", "N s/m", "damping rate, y, C_Py"),
    (52, "damping_z_Nspm", "N s/m", "damping rate, axial, C_Pz"),
    (53, "transition_z_m", "m", "extension between the two axial stiffnesses, D_PS,z"),
    (54, "small_stiffness_z_Npm", "N/m", "axial stiffness at small extension, K_PS,z"),
    (55, "large_stiffness_z_Npm", "N/m", "axial stiffness at large extension, K_PL,z"),
)

LOCKED: Final = {1: "locked", 0: "free"}
KINDS: Final = {1: "prismatic", 2: "swing_arm"}
SPRINGS: Final = {1: "linear_strut", 2: "gas_oleo"}
ARMS: Final = "swing arms only"


def tire_columns(path: str, types: Mapping[int, str]) -> tuple[Column, ...]:
    """The sixteen columns of a tire."""
    return tuple(
        Column(name, unit, f"{path}.{key}", choices=types if key == "type" else {}, meaning=meaning)
        for name, unit, key, meaning in _TIRE
    )


def oleo_columns(path: str) -> tuple[Column, ...]:
    """The 33 columns of a gas oleo."""
    return tuple(Column(name, unit, f"{path}.{key}", meaning=meaning) for name, unit, key, meaning in _OLEO)


def _inertia(first: int, path: str, what: str) -> tuple[Line, ...]:
    return tuple(
        Line(
            first + i,
            f"{what}, row {i + 1} of the inertia tensor",
            tuple(Column(f"I{'xyz'[i]}{'xyz'[j]}", "kg m2", f"{path}.{i}.{j}") for j in range(3)),
        )
        for i in range(3)
    )


def _bodies() -> tuple[Line, ...]:
    lines = [Line(1, "helicopter, mass", (Column("mass", "kg", "mass_kg"),))]
    lines += _inertia(2, "inertia_kgm2", "helicopter")
    for i, name in enumerate(STATIONS):
        first, path, what = 5 + 4 * i, f"stations.{name}", f"{name} wheel carriage"
        lines.append(Line(first, f"{what}, mass", (Column("mass", "kg", f"{path}.mass_kg"),)))
        lines += _inertia(first + 1, f"{path}.inertia_kgm2", what)
    return tuple(lines)


def _stations() -> tuple[Line, ...]:
    lines = []
    for first, key, meaning in (
        (17, "mount_m", "suspension, mounting point on the helicopter, helicopter axes"),
        (20, "droop_m", "wheel carriage from the oleo frame's origin at full droop, oleo axes"),
    ):
        lines += [
            Line(first + i, f"{name} {meaning}", vector(f"stations.{name}.{key}", "m"))
            for i, name in enumerate(STATIONS)
        ]
    lines += [
        Line(
            23 + i,
            f"{name} swing arm, orientation relative to the helicopter at full droop",
            euler_parameters(f"stations.{name}.orientation"),
            "swing arms; on a prismatic station it is read where it is not zero",
        )
        for i, name in enumerate(STATIONS)
    ]
    for first, key, meaning in (
        (26, "arm.helicopter_point_m", "swing arm, mount of the oleo on the helicopter, helicopter axes"),
        (29, "arm.arm_point_m", "swing arm, mount of the oleo on the arm, oleo axes"),
    ):
        lines += [
            Line(first + i, f"{name} {meaning}", vector(f"stations.{name}.{key}", "m"), ARMS)
            for i, name in enumerate(STATIONS)
        ]
    lines += [
        Line(32, "type of suspension", per_station("stations.{}.kind", choices=KINDS)),
        Line(33, "lock of the steering", per_station("stations.{}.steering", choices=LOCKED)),
        Line(34, "rolling lock of the axle", per_station("stations.{}.rolling", choices=LOCKED)),
        Line(
            35,
            "effective coefficient of the steer friction moment, mu_steer,eff, all stations",
            (Column("mu_steer", "m", "stations.*.steer_friction_m"),),
        ),
        Line(
            36,
            "coefficient of the steer damping moment, all stations (printed as N s)",
            (Column("c_steer", "N m s/rad", "stations.*.steer_damping_Nmspr"),),
        ),
    ]
    return tuple(lines)


def _body_and_probe() -> tuple[Line, ...]:
    on = {1: True, 0: False}
    active = Column("active", "", "probe.active", {1: "active", 0: "disabled"}, on)
    captured = Column("captured", "", "probe.captured", {1: "precaptured", 0: "uncaptured"}, on)
    return (
        Line(37, "centre of pressure, helicopter axes", vector("aerodynamics.centre_of_pressure_m", "m")),
        Line(38, "equivalent drag areas across x, y, z", vector("aerodynamics.drag_areas_m2", "m2")),
        Line(39, "wind velocity, inertial axes", vector("aerodynamics.wind_N_mps", "m/s")),
        Line(40, "securing probe, whether it acts", (active,)),
        Line(41, "securing probe, whether the claw holds it at the start", (captured,)),
        Line(42, "securing probe, mounting point, helicopter axes", vector("probe.mount_m", "m")),
        Line(
            43, "securing probe, from the mount to the undeflected tip, helicopter axes", vector("probe.vector_m", "m")
        ),
        *(
            Line(number, f"securing probe, {meaning}", (Column(key.rsplit("_", 1)[0], unit, f"probe.{key}"),))
            for number, key, unit, meaning in _PROBE
        ),
    )


def _tires_and_springs() -> tuple[Line, ...]:
    lines = []
    for i, name in enumerate(STATIONS):
        for k, which in enumerate(("first", "second")):
            columns = tire_columns(f"stations.{name}.tires.{k}", TIRE_TYPES if k == 0 else {**NO_TIRE, **TIRE_TYPES})
            when = "" if k == 0 else "zeros for none"
            lines.append(Line(56 + 2 * i + k, f"{which} tire of the {name} station", columns, when))
    springs = per_station("stations.{}.spring.type", choices=SPRINGS)
    lines.append(Line(62, "type of the force-generating element", springs))
    for i, name in enumerate(STATIONS):
        path = f"stations.{name}.spring"
        columns = (Column("k", "N/m", f"{path}.stiffness_Npm"), Column("c", "N s/m", f"{path}.damping_Nspm"))
        lines.append(Line(63 + i, f"linear spring and damping rates of the {name} station", columns, "line 62 is 1"))
    for i, name in enumerate(STATIONS):
        columns = oleo_columns(f"stations.{name}.spring")
        lines.append(Line(66 + i, f"gas oleo of the {name} station", columns, "line 62 is 2"))
    return tuple(lines)


HELI: Final = (*_bodies(), *_stations(), *_body_and_probe(), *_tires_and_springs())
