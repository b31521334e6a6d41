"""The description holds every quantity of HELI.INP (Léveillé 2013, appendix A), says its unit, and is frozen."""

from __future__ import annotations

import re
from typing import Any, get_args

import pytest
from pydantic import BaseModel, ValidationError

from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

STATIONS = ("auxiliary", "right", "left")


def each_station(first: int, step: int, name: str) -> dict[int, str]:
    return {first + step * i: f"stations.{station}.{name}" for i, station in enumerate(STATIONS)}


# Line of HELI.INP -> paths of the description.
LINES: dict[int, list[str]] = {
    1: ["mass_kg"],
    **{2 + i: [f"inertia_kgm2.{i}"] for i in range(3)},
    **{n: [path] for n, path in each_station(5, 4, "mass_kg").items()},
    **{n + i: [f"{path}.{i}"] for n, path in each_station(6, 4, "inertia_kgm2").items() for i in range(3)},
    **{n: [path] for n, path in each_station(17, 1, "mount_m").items()},
    **{n: [path] for n, path in each_station(20, 1, "droop_m").items()},
    **{n: [path] for n, path in each_station(23, 1, "orientation").items()},
    **{n: [path] for n, path in each_station(26, 1, "arm.helicopter_point_m").items()},
    **{n: [path] for n, path in each_station(29, 1, "arm.arm_point_m").items()},
    32: [f"stations.{s}.kind" for s in STATIONS],
    33: [f"stations.{s}.steering" for s in STATIONS],
    34: [f"stations.{s}.rolling" for s in STATIONS],
    35: [f"stations.{s}.steer_friction_m" for s in STATIONS],
    36: [f"stations.{s}.steer_damping_Nmspr" for s in STATIONS],
    37: ["aerodynamics.centre_of_pressure_m"],
    38: ["aerodynamics.drag_areas_m2"],
    39: ["aerodynamics.wind_N_mps"],
    40: ["probe.active"],
    41: ["probe.captured"],
    42: ["probe.mount_m"],
    43: ["probe.vector_m"],
    44: ["probe.small_stiffness_x_Npm"],
    45: ["probe.small_stiffness_y_Npm"],
    46: ["probe.large_stiffness_x_Npm"],
    47: ["probe.large_stiffness_y_Npm"],
    48: ["probe.transition_x_m"],
    49: ["probe.transition_y_m"],
    50: ["probe.damping_x_Nspm"],
    51: ["probe.damping_y_Nspm"],
    52: ["probe.damping_z_Nspm"],
    53: ["probe.transition_z_m"],
    54: ["probe.small_stiffness_z_Npm"],
    55: ["probe.large_stiffness_z_Npm"],
    **{56 + 2 * i + k: [f"stations.{s}.tires.{k}"] for i, s in enumerate(STATIONS) for k in range(2)},
    62: [f"stations.{s}.spring.type" for s in STATIONS],
    **{n: [f"{path}.stiffness_Npm", f"{path}.damping_Nspm"] for n, path in each_station(63, 1, "spring").items()},
    **{n: [path] for n, path in each_station(66, 1, "spring").items()},
}

TIRE_COLUMNS = {
    **{1 + i: f"position_m.{i}" for i in range(3)},
    4: "diameter_m",
    5: "width_m",
    6: "axle_radius_m",
    7: "pressure_Pa",
    8: "rated_pressure_Pa",
    9: "type",
    10: "friction_coefficient",
    11: "rolling_resistance",
    12: "axle_friction",
    13: "vertical_constant",
    14: "damping_x_Nspm",
    15: "damping_y_Nspm",
    16: "damping_z_Nspm",
}

OLEO_COLUMNS = {
    1: "x0_m",
    2: "x1_m",
    3: "x2_m",
    4: "extension_stiffness_Npm",
    5: "gas_pressure_Pa",
    6: "gas_volume_m3",
    7: "piston_area_m2",
    8: "gas_exponent",
    9: "e1_Npm",
    10: "e2_Npm",
    11: "f1_Npm2",
    12: "f2_Npm2",
    13: "g1_Npm3",
    14: "g2_Npm3",
    15: "c01_N",
    16: "c02_Nspm",
    17: "c03_Ns2pm2",
    18: "c1_N",
    19: "c2_Nspm",
    20: "c3_Ns2pm2",
    21: "c4_N",
    22: "c5_Nspm",
    23: "c6_Ns2pm2",
    24: "c7_N",
    25: "c8_Nspm",
    26: "c9_Ns2pm2",
    27: "relief_1_N",
    28: "relief_2_N",
    29: "seal_drag_N",
    30: "bearing_z_m",
    31: "bearing_separation_m",
    32: "bearing_friction",
    33: "friction_decay_spm",
}

# What the errata add to HELI.INP.
ADDED = [
    *(f"stations.right.end_stop.{k}" for k in ("stroke_m", "stiffness_Npm", "damping_Nspm")),
    "stations.right.steer_decay_spr",
    "stations.right.spring.reference_pressure_Pa",
    *(
        f"stations.right.tires.0.{k}"
        for k in (
            "rolling_decay_spm",
            "minimum_relaxation_m",
            "bottoming_deflection_m",
            "bottoming_stiffness_Npm",
            "pull_back_rate_ps",
            "pitch_moment_coefficient",
            "linear.vertical_stiffness_Npm",
            "linear.relaxation_length_m",
        )
    ),
    "probe.capture_radius_m",
    "probe.ultimate_load_N",
    "surroundings.gravity_mps2",
    "surroundings.air_density_kgpm3",
    "surroundings.atmospheric_pressure_Pa",
]

LINEAR = {"type": "linear_strut", "stiffness_Npm": 2.0e5, "damping_Nspm": 1.0e4}


def numbered(text: str, word: str) -> set[int]:
    """Numbers that a field's description cites, as in ``(lines 6-8, 10-12)``."""
    found: set[int] = set()
    for listing in re.findall(rf"{word}s? ([\d, -]+)", text):
        for span in listing.strip(" ,").split(","):
            first, _, last = span.strip().partition("-")
            found |= set(range(int(first), int(last or first) + 1))
    return found


def models(model: type[BaseModel]) -> set[type[BaseModel]]:
    found = {model}
    for field in model.model_fields.values():
        stack: list[Any] = [field.annotation]
        while stack:
            part = stack.pop()
            if isinstance(part, type) and issubclass(part, BaseModel):
                found |= models(part) if part not in found else set()
            else:
                stack += get_args(part)
    return found


def test_every_line_of_heli_inp_has_a_field() -> None:
    assert sorted(LINES) == list(range(1, 69))
    oleos = load_helicopter("generic_tricycle")
    struts = with_changes(oleos, {"stations.*.spring": LINEAR})
    arms = load_helicopter("seahawk_like")
    for line, paths in LINES.items():
        for path in paths:
            if "stations.auxiliary.arm" in path:
                assert oleos.value("stations.auxiliary.arm") is None  # prismatic: the lines are not used
                continue
            owner = struts if 63 <= line <= 65 else arms if ".arm." in path else oleos
            assert owner.value(path) is not None, path


def test_every_column_of_a_tire_and_an_oleo_has_a_field() -> None:
    assert sorted(TIRE_COLUMNS) == list(range(1, 17))
    assert sorted(OLEO_COLUMNS) == list(range(1, 34))
    helicopter = load_helicopter("generic_tricycle")
    for column, key in TIRE_COLUMNS.items():
        assert helicopter.value(f"stations.left.tires.1.{key}") is not None
        field = type(helicopter.stations.left.tires[1]).model_fields[key.split(".")[0]]
        assert column in numbered(field.description or "", "column")
    for column, key in OLEO_COLUMNS.items():
        helicopter.value(f"stations.left.spring.{key}")
        field = type(helicopter.stations.left.spring).model_fields[key]
        assert numbered(field.description or "", "column") == {column}


def test_descriptions_cite_their_lines() -> None:
    cited: set[int] = set()
    for model in models(Helicopter):
        for field in model.model_fields.values():
            cited |= numbered(field.description or "", "line")
    assert cited == set(range(1, 69))


def test_what_the_errata_add_has_a_field() -> None:
    helicopter = load_helicopter("generic_tricycle")
    for path in ADDED:
        assert isinstance(helicopter.value(path), float), path


def test_every_number_says_its_unit() -> None:
    for model in models(Helicopter):
        for name, field in model.model_fields.items():
            if "float" in str(field.annotation):
                assert re.search(r"\[[^\]]+\]$", field.description or ""), f"{model.__name__}.{name}"


def test_a_helicopter_is_frozen_and_hashable() -> None:
    helicopter = load_helicopter("generic_tricycle")
    with pytest.raises(ValidationError):
        helicopter.mass_kg = 1.0  # type: ignore[misc]
    with pytest.raises(ValidationError):
        helicopter.stations.right.tires[0].width_m = 1.0  # type: ignore[misc]
    assert len({helicopter, load_helicopter("generic_tricycle"), load_helicopter("seahawk_like")}) == 2


def test_a_path_that_does_not_exist_is_a_key_error() -> None:
    helicopter = load_helicopter("generic_tricycle")
    for path in ("mass", "stations.right.tires.2", "stations.right.tires.x", "mass_kg.real"):
        with pytest.raises(KeyError):
            helicopter.value(path)
