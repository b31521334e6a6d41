"""The identified helicopter as a file: six digits, a mark on every identified number, and where the marks come from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ssmash_gym.analysis.verification.parameters import (
    FREE,
    STROKE_SHARE,
    TOTAL_MASS_KG,
    helicopter_changes,
    trial_inputs,
)
from ssmash_gym.document import write_yaml
from ssmash_gym.dynamics import tire_properties
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import TIRE_PAR, TIRE_ROWS, TireModel
from ssmash_gym.simulation.parameters import parameter_column
from ssmash_gym.vehicle import Helicopter, document_of, with_changes

DIGITS: Final = 6  # significant digits of what is written
NOSE_TIRE_N: Final = 17500.0  # loads a tire in the reference state (case 1), to 0.1 kN
MAIN_TIRE_N: Final = 16900.0
HEADER: Final = """\
# A nose-wheel helicopter: the set that reproduces the verification table of the thesis (Table 3.1).
#
# Written by `ssmash identify`, which refits what is marked "fitted" and keeps the rest: docs/verification_table.md.
# Each number carries its mark: source, derived, fitted or assumed (docs/guide/helicopters.md). "Fitted" means
# identified from Table 3.1 of Léveillé (2013), with the standard deviation in the note; what the table does not
# determine is assumed. Nothing here is operational data of any aircraft.
"""
INPUTS_HEADER: Final = """\
# Inputs of the trials of Table 3.1 that the thesis does not print: changes to the helicopter, by the case's number.
#
# Written by `ssmash identify`; docs/verification_table.md says how.
"""
_MAINS: Final = ("stations.right", "stations.left")


def rounded(value: float) -> float:
    """A number to the digits that are written."""
    return float(f"{value:.{DIGITS}g}")


def _cleaned(value: Any) -> Any:
    """Numbers without the last bits that sums leave behind."""
    return [_cleaned(v) for v in value] if isinstance(value, list) else round(value, 9)


def identified(template: Helicopter, values: Mapping[str, float], deviations: Mapping[str, float] | None) -> Helicopter:
    """The helicopter of these values.

    Args:
        template: Gives everything that is not identified, marks and notes included.
        values: Of all parameters.
        deviations: Standard deviations for the notes; None leaves the marks of changed numbers away.
    """
    written = {name: rounded(value) for name, value in values.items()}
    made = with_changes(template, {p: _cleaned(v) for p, v in helicopter_changes(template, written).items()})
    changes: dict[str, Any] = {}
    for station, load in (("stations.auxiliary", NOSE_TIRE_N), *((main, MAIN_TIRE_N) for main in _MAINS)):
        changes |= _linear(made, station, load, marked=deviations is not None)
    made = with_changes(made, changes)
    if deviations is None:
        return made
    marked = {}
    for path, mark in _marks(template, values, deviations).items():
        marked[path] = {"value": made.value(path.replace("*", "0")) if "*" in path else made.value(path), **mark}
    return with_changes(made, marked)


def identified_inputs(values: Mapping[str, float], deviations: Mapping[str, float] | None) -> dict[str, dict[str, Any]]:
    """Inputs of the trials of these values, with their marks if there are standard deviations."""
    inputs = trial_inputs({name: rounded(value) for name, value in values.items()})
    if deviations is None:
        return inputs
    notes = {
        ("3", "cg_offset_m"): f"sd {deviations['cg_shift_m']:.2g} m",
        ("11", "aerodynamics.wind_N_mps"): "for the assumed area of 7 m2 and 5 s; two unknowns for two values",
        ("11", "aerodynamics.centre_of_pressure_m.2"): "for the assumed 5 s; two unknowns for two values",
        ("12", "aerodynamics.wind_N_mps"): f"for the assumed area of 20 m2; sd {deviations['side_wind_mps']:.2g} m/s",
    }
    return {
        trial: {
            path: {"value": value, "origin": "fitted", "note": notes[trial, path]} for path, value in changes.items()
        }
        for trial, changes in inputs.items()
    }


def _linear(helicopter: Helicopter, station: str, load: float, marked: bool) -> dict[str, Any]:
    """Constants of the linear tire: Smiley and Horne's at a static load [N]."""
    tire = tuple(name for name in ("auxiliary", "right", "left")).index(station.split(".")[1]) * 2
    p, base = parameter_column(helicopter), TIRE_PAR + tire * TIRE_ROWS
    found = helicopter.value(f"{station}.tires.0")
    over_area = 1.0 / (found.diameter_m * found.width_m)

    def at(dz: float) -> tuple[float, ...]:
        L_h, b_t = uncompiled(tire_properties.footprint)(p, base, dz, over_area)
        values = uncompiled(tire_properties.properties)(
            p, base, int(TireModel.SMILEY_HORNE), dz, 0.0, L_h, b_t, over_area
        )
        return tuple(float(v) for v in values)

    from scipy.optimize import brentq

    dz = float(brentq(lambda z: at(z)[0] - load, 1e-6, found.bottoming_deflection_m))
    _, k_x, k_y, k_psi, length, *_ = at(dz)
    kilo = f"{1e-3 * load:.1f} kN"
    law = f"Smiley and Horne at {kilo}"
    constants = {
        "vertical_stiffness_Npm": (load / dz, f"secant of Smiley and Horne's law at {kilo}"),
        "longitudinal_stiffness_Npm": (k_x, law),
        "lateral_stiffness_Npm": (k_y, law),
        "twist_stiffness_Nmprad": (k_psi, law),
        "relaxation_length_m": (length, f"L_y + L_h of {law}"),
    }
    return {
        f"{station}.tires.*.linear.{key}": {"value": float(f"{value:.4g}"), "origin": "derived", "note": note}
        if marked else float(f"{value:.4g}")
        for key, (value, note) in constants.items()
    }  # fmt: skip


def _marks(template: Helicopter, values: Mapping[str, float], sd: Mapping[str, float]) -> dict[str, dict[str, str]]:
    """Marks of what is identified, by dotted path."""

    def spread(name: str, unit: str) -> dict[str, str]:
        return _fitted(f"sd {sd[name]:.2g} {unit}")

    side = f"x fitted, sd {sd['main_x_m']:.2g} m; y fitted, sd {sd['half_track_m']:.2g} m"
    marks = {
        "mass_kg": {
            "origin": "derived",
            "note": f"total of {TOTAL_MASS_KG:g} kg (102.514 kN at 9.81 m/s2) minus the three carriages",
        },
        "stations.auxiliary.mass_kg": _fitted(
            f"sd {sd['nose_carriage_kg']:.2g} kg; case 2 fixes the difference to the main carriages"
        ),
        "stations.auxiliary.mount_m": _fitted(
            f"wheel at x = {values['nose_x_m']:.4f} m, sd {sd['nose_x_m']:.2g} m, and tire bottom "
            f"{values['nose_foot_m']:.4f} m below the c.g. at full droop, sd {sd['nose_foot_m']:.2g} m; for the "
            "assumed trail and droop length"
        ),
        "stations.auxiliary.spring.gas_pressure_Pa": spread("nose_gas_Pa", "Pa"),
        "stations.auxiliary.spring.gas_volume_m3": spread("nose_gas_m3", "m3"),
        "stations.auxiliary.spring.piston_area_m2": spread("nose_piston_m2", "m2"),
        "stations.right.mount_m": _fitted(
            f"{side}; height assumed, tire bottom 2.5 m below the c.g. from the 0.2 m clearance of the drop"
        ),
        "stations.left.mount_m": _fitted("mirror image of the right station"),
        "probe.small_stiffness_x_Npm": spread("probe_Npm", "N/m; case 6, both stages alike"),
        "probe.large_stiffness_x_Npm": spread("probe_Npm", "N/m; case 6, both stages alike"),
        "probe.small_stiffness_y_Npm": {"origin": "assumed", "note": "as longitudinally"},
        "probe.large_stiffness_y_Npm": {"origin": "assumed", "note": "as longitudinally"},
        "aerodynamics.centre_of_pressure_m": _fitted(
            f"case 12 with no force across z; x: sd {sd['pressure_point_x_m']:.2g} m, z: sd "
            f"{sd['pressure_point_z_m']:.2g} m"
        ),
    }
    for station, name in (("auxiliary", "nose"), ("right", "main"), ("left", "main")):
        marks |= _station_marks(template, station, name, values, sd)
    return marks


def _station_marks(
    template: Helicopter, station: str, name: str, values: Mapping[str, float], sd: Mapping[str, float]
) -> dict[str, dict[str, str]]:
    """Marks of a station's oleo, end stop and tires, by dotted path."""
    strut = template.value(f"stations.{station}")
    spring = f"stations.{station}.spring"
    stop = {"origin": "assumed", "note": "gas law up to the end of the stroke"}
    marks = {f"{spring}.x1_m": stop, f"{spring}.x2_m": {"origin": "assumed", "note": "x1 and 1 cm"}}
    if name == "main":
        given = "for the assumed volume and exponent"
        marks[f"{spring}.gas_pressure_Pa"] = _fitted(f"sd {sd['main_gas_Pa']:.2g} Pa, {given}")
        marks[f"{spring}.piston_area_m2"] = _fitted(f"sd {sd['main_piston_m2']:.2g} m2, {given}")
    volume = values["nose_gas_m3"] if name == "nose" else strut.spring.gas_volume_m3
    exhausted = volume / values[f"{name}_piston_m2"]
    share = f"{100 * STROKE_SHARE:.0f} % of the compression that exhausts the gas, {exhausted:.3f} m, in whole cm"
    marks[f"stations.{station}.end_stop.stroke_m"] = {"origin": "assumed", "note": share}
    pressure = f"for the assumed size, with inflation and rated pressure equal; sd {sd[f'{name}_tire_Pa']:.2g} Pa"
    rolling = f"with the decay of {strut.tires[0].rolling_decay_spm:g} s/m, case 5; only both together are identified"
    for k in range(len(strut.tires)):
        tire = f"stations.{station}.tires.{k}"
        marks[f"{tire}.pressure_Pa"] = marks[f"{tire}.rated_pressure_Pa"] = _fitted(pressure)
        marks[f"{tire}.rolling_resistance"] = _fitted(rolling)
    return marks


def _fitted(note: str) -> dict[str, str]:
    return {"origin": "fitted", "note": note}


def helicopter_text(helicopter: Helicopter) -> str:
    """The helicopter's file; what is absent is left out."""
    return HEADER + write_yaml(_present(document_of(helicopter)))


def _present(node: Any) -> Any:
    """A document without the keys that hold nothing."""
    if isinstance(node, dict):
        return {key: _present(child) for key, child in node.items() if child is not None}
    return [_present(child) for child in node] if isinstance(node, list) else node


def inputs_text(inputs: Mapping[str, Mapping[str, Any]]) -> str:
    """The file of the trials' inputs."""
    return INPUTS_HEADER + write_yaml(inputs)


def values_of(helicopter: Helicopter, inputs: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    """The identified values that a helicopter and the trials' inputs hold; where a search can start.

    Args:
        helicopter: As identified.
        inputs: Without marks.
    """
    nose, main = helicopter.stations.auxiliary, helicopter.stations.right
    oleo, strut = nose.spring, main.spring
    assert oleo.type == "gas_oleo" and strut.type == "gas_oleo"
    centre = helicopter.aerodynamics.centre_of_pressure_m
    found = {
        "nose_x_m": nose.mount_m[0] + nose.droop_m[0],
        "main_x_m": main.mount_m[0] + main.droop_m[0],
        "half_track_m": main.mount_m[1],
        "nose_foot_m": nose.mount_m[2] + nose.droop_m[2] + 0.5 * nose.tires[0].diameter_m,
        "nose_gas_Pa": oleo.gas_pressure_Pa,
        "nose_gas_m3": oleo.gas_volume_m3,
        "nose_piston_m2": oleo.piston_area_m2,
        "main_gas_Pa": strut.gas_pressure_Pa,
        "main_piston_m2": strut.piston_area_m2,
        "nose_carriage_kg": nose.mass_kg,
        "nose_tire_Pa": nose.tires[0].pressure_Pa,
        "main_tire_Pa": main.tires[0].pressure_Pa,
        "probe_Npm": helicopter.probe.small_stiffness_x_Npm,
        "pressure_point_x_m": centre[0],
        "pressure_point_z_m": centre[2],
        "rolling_resistance": main.tires[0].rolling_resistance,
        "cg_shift_m": inputs["3"]["cg_offset_m"][0],
        "side_wind_mps": inputs["12"]["aerodynamics.wind_N_mps"][1],
        "tail_wind_mps": inputs["11"]["aerodynamics.wind_N_mps"][0],
        "tail_wind_point_z_m": inputs["11"]["aerodynamics.centre_of_pressure_m.2"],
    }
    assert {p.name for p in FREE} <= set(found)
    return {name: float(np.float64(value)) for name, value in found.items()}
