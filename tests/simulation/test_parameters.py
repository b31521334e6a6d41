"""Every number of a description reaches the kernel's tables, each in its own row."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import (
    PARAMETER_ROWS,
    STATION_ROWS,
    TIRE_PAR,
    TIRE_ROWS,
    Mode,
    Par,
    Spring,
    Sta,
    Tir,
)
from ssmash_gym.simulation.parameters import droop_state, mode_vector, parameter_column
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

STATIONS = ("auxiliary", "right", "left")
PLAY_SECTION = {"play_rad": 0.0175, "stop_stiffness_Nmprad": 1.2e5, "stop_damping_Nmspr": 350.0}
UPPER = {"0.0": 0, "0.1": 1, "0.2": 2, "1.1": 3, "1.2": 4, "2.2": 5}
LINEAR = {"type": "linear_strut", "stiffness_Npm": 2.1e5, "damping_Nspm": 1.3e4}


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


@pytest.fixture(scope="module")
def seahawk() -> Helicopter:
    return load_helicopter("seahawk_like")


# --- which value belongs in which row ------------------------------------------------------------------------

BODY = {
    "mass_kg": Par.MASS,
    "surroundings.gravity_mps2": Par.GRAVITY,
    "surroundings.air_density_kgpm3": Par.AIR_DENSITY,
    "probe.small_stiffness_x_Npm": Par.PROBE_KS_X,
    "probe.small_stiffness_y_Npm": Par.PROBE_KS_Y,
    "probe.large_stiffness_x_Npm": Par.PROBE_KL_X,
    "probe.large_stiffness_y_Npm": Par.PROBE_KL_Y,
    "probe.transition_x_m": Par.PROBE_D_X,
    "probe.transition_y_m": Par.PROBE_D_Y,
    "probe.damping_x_Nspm": Par.PROBE_C_X,
    "probe.damping_y_Nspm": Par.PROBE_C_Y,
    "probe.damping_z_Nspm": Par.PROBE_C_Z,
    "probe.transition_z_m": Par.PROBE_D_Z,
    "probe.small_stiffness_z_Npm": Par.PROBE_KS_Z,
    "probe.large_stiffness_z_Npm": Par.PROBE_KL_Z,
    "probe.capture_radius_m": Par.PROBE_CAPTURE_RADIUS,
    "probe.ultimate_load_N": Par.PROBE_ULTIMATE,
    **{f"inertia_kgm2.{ij}": Par.IXX + n for ij, n in UPPER.items()},
    **{f"aerodynamics.centre_of_pressure_m.{k}": Par.CP + k for k in range(3)},
    **{f"aerodynamics.drag_areas_m2.{k}": Par.AREA + k for k in range(3)},
    **{f"aerodynamics.wind_N_mps.{k}": Par.WIND + k for k in range(3)},
    **{f"probe.mount_m.{k}": Par.PROBE_MOUNT + k for k in range(3)},
    **{f"probe.vector_m.{k}": Par.PROBE_VECTOR + k for k in range(3)},
}

STATION = {
    "mass_kg": Sta.MASS,
    **{f"inertia_kgm2.{ij}": Sta.IXX + n for ij, n in UPPER.items()},
    **{f"mount_m.{k}": Sta.MOUNT + k for k in range(3)},
    **{f"droop_m.{k}": Sta.DROOP + k for k in range(3)},
    "steer_friction_m": Sta.STEER_MU,
    "steer_damping_Nmspr": Sta.STEER_C,
    "steer_decay_spr": Sta.STEER_BETA,
    "end_stop.stroke_m": Sta.STROKE,
    "end_stop.stiffness_Npm": Sta.STOP_K,
    "end_stop.damping_Nspm": Sta.STOP_C,
}

PLAY = {
    "steer_play.play_rad": Sta.STEER_PLAY,
    "steer_play.stop_stiffness_Nmprad": Sta.STEER_STOP_K,
    "steer_play.stop_damping_Nmspr": Sta.STEER_STOP_C,
}

ARM = {
    **{f"arm.helicopter_point_m.{k}": Sta.P1 + k for k in range(3)},
    **{f"arm.arm_point_m.{k}": Sta.P2 + k for k in range(3)},
}

OLEO = {
    "x0_m": Sta.X0,
    "x1_m": Sta.X1,
    "x2_m": Sta.X2,
    "extension_stiffness_Npm": Sta.K,
    "gas_pressure_Pa": Sta.GAS_P,
    "gas_volume_m3": Sta.GAS_V,
    "piston_area_m2": Sta.GAS_A,
    "gas_exponent": Sta.GAS_GAMMA,
    "reference_pressure_Pa": Sta.P_REF,
    "e1_Npm": Sta.E1,
    "e2_Npm": Sta.E2,
    "f1_Npm2": Sta.F1,
    "f2_Npm2": Sta.F2,
    "g1_Npm3": Sta.G1,
    "g2_Npm3": Sta.G2,
    "c01_N": Sta.C01,
    "c02_Nspm": Sta.C02,
    "c03_Ns2pm2": Sta.C03,
    "c1_N": Sta.C1,
    "c2_Nspm": Sta.C2,
    "c3_Ns2pm2": Sta.C3,
    "c4_N": Sta.C4,
    "c5_Nspm": Sta.C5,
    "c6_Ns2pm2": Sta.C6,
    "c7_N": Sta.C7,
    "c8_Nspm": Sta.C8,
    "c9_Ns2pm2": Sta.C9,
    "relief_1_N": Sta.REL1,
    "relief_2_N": Sta.REL2,
    "seal_drag_N": Sta.SEAL,
    "bearing_z_m": Sta.BEARING_Z,
    "bearing_separation_m": Sta.BEARING_L0,
    "bearing_friction": Sta.BEARING_MU,
    "friction_decay_spm": Sta.BETA,
}

TIRE = {
    **{f"position_m.{k}": Tir.X + k for k in range(3)},
    "diameter_m": Tir.DIAMETER,
    "width_m": Tir.WIDTH,
    "axle_radius_m": Tir.AXLE_RADIUS,
    "pressure_Pa": Tir.P_O,
    "rated_pressure_Pa": Tir.P_R,
    "friction_coefficient": Tir.MU,
    "rolling_resistance": Tir.MU_RR,
    "axle_friction": Tir.MU_AXLE,
    "vertical_constant": Tir.CTZ,
    "damping_x_Nspm": Tir.CX,
    "damping_y_Nspm": Tir.CY,
    "damping_z_Nspm": Tir.CZ,
    "rolling_decay_spm": Tir.BETA,
    "minimum_relaxation_m": Tir.SIGMA_MIN,
    "bottoming_deflection_m": Tir.BOTTOM,
    "bottoming_stiffness_Npm": Tir.BOTTOM_K,
    "pull_back_rate_ps": Tir.PULL,
    "pitch_moment_coefficient": Tir.MY_COEFF,
    "linear.vertical_stiffness_Npm": Tir.LIN_KZ,
    "linear.longitudinal_stiffness_Npm": Tir.LIN_KX,
    "linear.lateral_stiffness_Npm": Tir.LIN_KY,
    "linear.twist_stiffness_Nmprad": Tir.LIN_KPSI,
    "linear.relaxation_length_m": Tir.LIN_SIGMA,
}

# Rows that other parts of the simulation fill, and rows worked out from several values.
SCENARIO = set(range(Par.CLAW_Z, Par.RIPPLE_PHASE + 1)) | set(range(Par.WRENCH_H, Par.STATION))
SWITCHES = {int(Par.PROBE_ACTIVE), *range(Par.LOCK, Par.LOCK + 12)}
STATION_DERIVED = {Sta.LENGTH, Sta.R2_C, Sta.R2_D, Sta.STEER_COS, Sta.STEER_SIN}


def rows_of(helicopter: Helicopter) -> dict[str, int]:
    """Row of every number of a helicopter."""
    rows: dict[str, int] = {path: int(row) for path, row in BODY.items()}
    for i, (name, station) in enumerate(zip(STATIONS, helicopter.station_tuple, strict=True)):
        base = Par.STATION + i * STATION_ROWS
        rows |= {f"stations.{name}.{path}": base + row for path, row in STATION.items()}
        if station.arm is not None:
            rows |= {f"stations.{name}.{path}": base + row for path, row in ARM.items()}
        if station.steer_play is not None:
            rows |= {f"stations.{name}.{path}": base + row for path, row in PLAY.items()}
        if station.spring.type == "gas_oleo":
            rows |= {f"stations.{name}.spring.{path}": base + row for path, row in OLEO.items()}
        else:
            rows |= {
                f"stations.{name}.spring.stiffness_Npm": base + Sta.LINEAR_K,
                f"stations.{name}.spring.damping_Nspm": base + Sta.LINEAR_C,
            }
        for k in range(len(station.tires)):
            start = TIRE_PAR + (2 * i + k) * TIRE_ROWS
            rows |= {f"stations.{name}.tires.{k}.{path}": start + row for path, row in TIRE.items()}
    return rows


def numbers(node: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a dumped helicopter with its path."""
    if isinstance(node, float):
        yield path, node
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        yield from numbers(child, f"{path}.{key}".lstrip("."))


def distinct(helicopter: Helicopter) -> Helicopter:
    """A copy in which no two numbers are alike, so that a swapped row shows."""
    changes: dict[str, Any] = {}
    dumped = helicopter.model_dump(mode="json", exclude={"provenance", "cg_offset_m"})
    for n, (path, value) in enumerate(numbers(dumped)):
        if ".orientation." in path or "inertia" in path:
            continue
        changes[path] = value * (1.0 + 1e-5 * n) if value else 1e-5 * (n + 1)
    for name, path in ((s, f"stations.{s}") for s in STATIONS):
        changes[f"{path}.inertia_kgm2"] = [
            [30.0 + len(name), 0.1, 0.2],
            [0.1, 31.5 + len(name), 0.3],
            [0.2, 0.3, 33.7 + len(name)],
        ]
        if f"{path}.spring.x1_m" in changes:  # the limits of the second relief and of region 3 stay in order
            changes[f"{path}.spring.x1_m"] = changes[f"{path}.end_stop.stroke_m"] * 0.999
    changes["inertia_kgm2"] = [[16e3, 100.0, -4e3], [100.0, 56e3, 200.0], [-4e3, 200.0, 50e3]]
    return with_changes(helicopter, changes)


def with_play(helicopter: Helicopter) -> Helicopter:
    """Free play on all stations that may have it."""
    changes = {f"stations.{s}.steering": "locked" for s in STATIONS}
    stations = zip(STATIONS, helicopter.station_tuple, strict=True)
    changes |= {f"stations.{s}.steer_play": PLAY_SECTION for s, station in stations if station.kind == "prismatic"}
    return with_changes(helicopter, changes)


@pytest.mark.parametrize("play", [False, True])
@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_each_number_stands_in_its_own_row_and_no_row_is_forgotten(name: str, play: bool) -> None:
    helicopter = load_helicopter(name)
    helicopter = distinct(with_play(helicopter) if play else helicopter)
    column = parameter_column(helicopter)
    assert column.shape == (PARAMETER_ROWS,)
    assert np.isfinite(column).all()
    rows = rows_of(helicopter)
    assert len(set(rows.values())) == len(rows)
    for path, row in rows.items():
        value = helicopter.value(path)
        if value is not None:  # e1 and e2 may be left to be derived
            assert column[row] == value, path
    filled = set(rows.values()) | SCENARIO | SWITCHES
    for i, station in enumerate(helicopter.station_tuple):
        base = Par.STATION + i * STATION_ROWS
        filled |= {base + row for row in (*STATION_DERIVED, Sta.ROLL_LOCK, Sta.LINEAR_K, Sta.LINEAR_C)}
        for part, first, last in (
            (station.arm, Sta.P1, Sta.LENGTH),
            (station.steer_play, Sta.STEER_PLAY, Sta.STEER_SIN),
        ):
            if part is None:
                unused = range(base + first, base + last + 1)
                assert not column[list(unused)].any()
                filled |= set(unused)
        for k in range(2):
            start = TIRE_PAR + (2 * i + k) * TIRE_ROWS
            if k < len(station.tires):
                filled |= {start + Tir.P_ABS, start + Tir.TYPE_I}
            else:
                assert not column[start : start + TIRE_ROWS].any()
                filled |= set(range(start, start + TIRE_ROWS))
    assert filled == set(range(PARAMETER_ROWS))
    assert not column[sorted(SCENARIO)].any()


def test_a_linear_strut_fills_its_own_rows_only(tricycle: Helicopter) -> None:
    helicopter = with_changes(tricycle, {"stations.right.spring": LINEAR})
    column, modes = parameter_column(helicopter), mode_vector(helicopter)
    right = column[Par.STATION + STATION_ROWS : Par.STATION + 2 * STATION_ROWS]
    assert right[Sta.LINEAR_K] == 2.1e5
    assert right[Sta.LINEAR_C] == 1.3e4
    assert not right[Sta.X0 : Sta.STROKE].any()
    assert right[Sta.STROKE] == tricycle.stations.right.end_stop.stroke_m
    assert list(modes[Mode.SPRING : Mode.SPRING + 3]) == [Spring.GAS_OLEO, Spring.LINEAR, Spring.GAS_OLEO]


# --- mutation: no number of a description is idle ------------------------------------------------------------


def snapshot(helicopter: Helicopter) -> bytes:
    return b"".join(
        t.tobytes() for t in (parameter_column(helicopter), mode_vector(helicopter), droop_state(helicopter))
    )


def mutated(path: str, value: float) -> tuple[str, Any]:
    """The smallest change of one number that leaves the helicopter valid, as (path, value) for `with_changes`."""
    if ".orientation." in path:
        turn = [1.0, 0.0, 0.0, 0.0]
        k = int(path[-1])
        turn[k] = 1e-3 if k else -1.0
        norm = sum(e * e for e in turn) ** 0.5
        return path.rsplit(".", 1)[0], [e / norm for e in turn]
    if path.endswith(("x0_m", "x1_m", "relief_1_N")):
        return path, value * (1.0 - 1e-3)
    return path, value * (1.0 + 1e-3) if value else 1e-3


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like", "struts"])
def test_changing_any_number_changes_the_tables(name: str) -> None:
    """No exceptions: each number changes the parameter column, the modes or the initial state."""
    helicopter = load_helicopter("generic_tricycle" if name == "struts" else name)
    if name == "struts":
        helicopter = with_play(with_changes(helicopter, {"stations.*.spring": LINEAR}))
    helicopter = helicopter.model_copy(update={"provenance": ()})  # lighter: the marks do not matter here
    before = snapshot(helicopter)
    dumped = helicopter.model_dump(mode="json", exclude={"provenance"})
    for path, value in numbers(dumped):
        if ".left." in path or ".tires.1." in path or (".tires." in path and name == "struts"):
            continue  # the same code as its twin, which is tried
        if "inertia_kgm2" in path:
            continue  # in pairs, below
        changed = with_changes(helicopter, dict([mutated(path, value)]))
        assert snapshot(changed) != before, path


@pytest.mark.parametrize("owner", ["", "stations.auxiliary.", "stations.right.", "stations.left."])
@pytest.mark.parametrize(("i", "j"), [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)])
def test_changing_any_entry_of_an_inertia_tensor_changes_the_tables(
    tricycle: Helicopter, owner: str, i: int, j: int
) -> None:
    tensor = np.array(tricycle.value(f"{owner}inertia_kgm2"))
    tensor[i, j] = tensor[j, i] = tensor[i, j] + 0.01
    assert snapshot(with_changes(tricycle, {f"{owner}inertia_kgm2": tensor})) != snapshot(tricycle)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("stations.auxiliary.steering", "locked"),
        ("stations.auxiliary.rolling", "locked"),
        ("stations.right.steer_play", PLAY_SECTION),
        ("stations.left.tires.1.type", "I"),
        ("stations.left.spring", LINEAR),
        ("tire_model", "linear"),
        ("probe.active", False),
        ("probe.captured", False),
        ("stations.right.spring.e1_Npm", 4.0e6),
        ("stations.right.spring.e2_Npm", 4.0e6),
        ("stations.right.tires.0.linear", None),
    ],
)
@pytest.mark.filterwarnings("ignore:e[12]_Npm")
def test_changing_any_choice_changes_the_tables(tricycle: Helicopter, path: str, value: Any) -> None:
    """Exceptions: type VII instead of III (the thesis' equations treat them alike), name, description, marks."""
    assert snapshot(with_changes(tricycle, {path: value})) != snapshot(tricycle)


def test_what_is_told_to_change_nothing_changes_nothing(tricycle: Helicopter) -> None:
    idle = {"name": "other", "description": "other", "stations.*.tires.*.type": "III"}
    assert snapshot(with_changes(tricycle, idle)) == snapshot(tricycle)
