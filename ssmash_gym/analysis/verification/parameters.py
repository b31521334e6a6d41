"""What is identified from Table 3.1: the free numbers, their bounds, and where they go in a description.

Numbers that the table cannot determine stay as the helicopter's file has them (docs/verification_table.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from ssmash_gym.vehicle import Helicopter

Values = Mapping[str, float]
TOTAL_MASS_KG: Final = 10450.0  # 102.514 kN over 9.81 m/s2, to the table's rounding
STROKE_SHARE: Final = 0.93  # of the compression that exhausts the gas: where the end stop is assumed
STOP_GRID_M: Final = 0.01  # strokes are whole centimetres
_NOSE: Final = "stations.auxiliary"
_MAINS: Final = (("stations.right", 1.0), ("stations.left", -1.0))


@dataclass(frozen=True)
class Parameter:
    """One identified number.

    Args:
        name: Its name, unit included.
        meaning: What it is.
        guess: Round number that the search starts from.
        low: Lower bound.
        high: Upper bound.
        scale: Size of a small change.
        trial: The trial that it is an input of; empty for a number of the helicopter.
    """

    name: str
    meaning: str
    guess: float
    low: float
    high: float
    scale: float
    trial: str = ""


FREE: Final = (
    Parameter("nose_x_m", "nose wheels ahead of the body's c.g.", 3.75, 3.3, 4.2, 0.1),
    Parameter("main_x_m", "main wheels from the body's c.g., x", -1.95, -2.4, -1.6, 0.1),
    Parameter("half_track_m", "main wheels off the centre line", 1.55, 1.2, 1.9, 0.1),
    Parameter("nose_foot_m", "nose tires' bottom below the body's c.g. at full droop", 2.63, 2.5, 2.72, 0.1),
    Parameter("nose_gas_Pa", "gas pressure of the nose oleo", 2.8e6, 2.0e6, 4.0e6, 1.0e5),
    Parameter("nose_gas_m3", "gas volume of the nose oleo", 0.0021, 0.00185, 0.0025, 1.0e-4),
    Parameter("nose_piston_m2", "piston area of the nose oleo", 0.0046, 0.004, 0.0052, 1.0e-4),
    Parameter("main_gas_Pa", "gas pressure of the main oleos", 2.2e6, 1.5e6, 3.5e6, 1.0e5),
    Parameter("main_piston_m2", "piston area of the main oleos", 0.0073, 0.006, 0.009, 1.0e-4),
    Parameter("nose_carriage_kg", "mass of the nose carriage", 170.0, 50.0, 350.0, 10.0),
    Parameter("nose_tire_Pa", "pressure of the nose tires", 9.0e5, 4.0e5, 2.0e6, 1.0e5),
    Parameter("main_tire_Pa", "pressure of the main tires", 9.0e5, 4.0e5, 2.0e6, 1.0e5),
    Parameter("probe_Npm", "in-plane probe stiffness along x", 1.2e6, 4.0e5, 4.0e6, 1.0e5),
    Parameter("pressure_point_x_m", "centre of pressure from the body's c.g., x", -1.0, -3.0, 1.0, 0.1),
    Parameter("pressure_point_z_m", "centre of pressure from the body's c.g., z", 0.0, -2.0, 2.0, 0.1),
    Parameter("cg_shift_m", "shift of the body's c.g.", 0.5, 0.3, 0.7, 0.1, "3"),
    Parameter("side_wind_mps", "wind speed for the assumed area of 20 m2", 25.0, 15.0, 40.0, 1.0, "12"),
)
ROLLING: Final = Parameter("rolling_resistance", "rolling resistance coefficient", 0.0007, 0.0, 0.02, 1.0e-4)
HEAD_WIND: Final = (
    Parameter("tail_wind_mps", "wind speed for the assumed area of 7 m2", 54.0, 20.0, 100.0, 1.0, "11"),
    Parameter("tail_wind_point_z_m", "centre of pressure from the body's c.g., z", -0.9, -5.0, 2.0, 0.1, "11"),
)


def guesses() -> dict[str, float]:
    """Where the search starts."""
    return {p.name: p.guess for p in (*FREE, ROLLING, *HEAD_WIND)}


def _stroke(volume: float, area: float) -> float:
    """End of the stroke [m]: a share of the compression that exhausts the gas, in whole centimetres."""
    return round(math.floor(STROKE_SHARE * volume / area / STOP_GRID_M) * STOP_GRID_M, 6)


def helicopter_changes(template: Helicopter, values: Values) -> dict[str, Any]:
    """Changes to a helicopter, by dotted path, that make it the one of these values.

    Args:
        template: Gives everything that is not identified.
        values: By the names of `FREE` and `ROLLING`.
    """
    nose, main = template.stations.auxiliary, template.stations.right
    assert main.spring.type == "gas_oleo"
    main_volume = main.spring.gas_volume_m3
    mount_z = values["nose_foot_m"] - 0.5 * nose.tires[0].diameter_m - nose.droop_m[2]
    centre = template.aerodynamics.centre_of_pressure_m
    changes: dict[str, Any] = {
        "mass_kg": TOTAL_MASS_KG - values["nose_carriage_kg"] - 2.0 * main.mass_kg,
        f"{_NOSE}.mass_kg": values["nose_carriage_kg"],
        f"{_NOSE}.mount_m": [values["nose_x_m"] - nose.droop_m[0], nose.mount_m[1], mount_z],
        f"{_NOSE}.spring.gas_volume_m3": values["nose_gas_m3"],
        "probe.small_stiffness_x_Npm": values["probe_Npm"],
        "probe.large_stiffness_x_Npm": values["probe_Npm"],
        "probe.small_stiffness_y_Npm": values["probe_Npm"],
        "probe.large_stiffness_y_Npm": values["probe_Npm"],
        "aerodynamics.centre_of_pressure_m": [values["pressure_point_x_m"], centre[1], values["pressure_point_z_m"]],
        "stations.*.tires.*.rolling_resistance": values["rolling_resistance"],
    }
    changes |= _strut(_NOSE, values["nose_gas_Pa"], values["nose_piston_m2"], values["nose_gas_m3"])
    changes |= _tires(_NOSE, values["nose_tire_Pa"])
    for station, side in _MAINS:
        changes[f"{station}.mount_m"] = [
            values["main_x_m"] - main.droop_m[0], side * values["half_track_m"], main.mount_m[2]
        ]  # fmt: skip
        changes |= _strut(station, values["main_gas_Pa"], values["main_piston_m2"], main_volume)
        changes |= _tires(station, values["main_tire_Pa"])
    return changes


def _strut(station: str, pressure: float, area: float, volume: float) -> dict[str, Any]:
    stroke = _stroke(volume, area)
    return {
        f"{station}.spring.gas_pressure_Pa": pressure,
        f"{station}.spring.piston_area_m2": area,
        f"{station}.spring.x1_m": stroke,
        f"{station}.spring.x2_m": round(stroke + STOP_GRID_M, 6),
        f"{station}.end_stop.stroke_m": stroke,
    }


def _tires(station: str, pressure: float) -> dict[str, Any]:
    return {
        f"{station}.tires.*.pressure_Pa": pressure,
        f"{station}.tires.*.rated_pressure_Pa": pressure,
    }


def trial_inputs(values: Values) -> dict[str, dict[str, Any]]:
    """Inputs of the trials that the thesis does not print, as changes to the helicopter by trial."""
    return {
        "3": {"cg_offset_m": [values["cg_shift_m"], 0.0, 0.0]},
        "11": {
            "aerodynamics.wind_N_mps": [values["tail_wind_mps"], 0.0, 0.0],
            "aerodynamics.centre_of_pressure_m.2": values["tail_wind_point_z_m"],
        },
        "12": {"aerodynamics.wind_N_mps": [0.0, values["side_wind_mps"], 0.0]},
    }
