"""Struts in series with linear tires, for a body whose wheel carriages are rigid with it (Blackwell and Feik).

The carriage is fixed where it sits at rest on a level deck, and the tire's centre where it would be at full droop. A
tire of the secant stiffness of strut and tire in series then carries the same load at the same height of the body,
and lifts off where the suspended wheel does. In between the real struts are not linear: the stiffness against small
motions about the rest differs (`Corner.tangent_Npm`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import STATION_COORDINATES, TIRE_PAR, TIRE_ROWS, State, TireModel
from ssmash_gym.dynamics.tire_properties import footprint, properties
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.parameters import parameter_column
from ssmash_gym.simulation.settle import turn
from ssmash_gym.vehicle import GasOleo, Helicopter, Station
from ssmash_gym.vehicle.geometry import rotation

Array = NDArray[np.float64]
NAMES: Final = ("auxiliary", "right", "left")
# A strut that stands in for a rigid one while the helicopter settles; afterwards its speed is held. At 35 kN it gives
# way by 0.35 mm; so much damping that the engine's step takes it.
RIGID_NPM: Final = 1.0e8
RIGID_NSPM: Final = 1.0e6
RIGID_STROKE_M: Final = 0.01
_STEP: Final = 1.0e-4  # of the compression in a difference quotient [m]


@dataclass(frozen=True)
class Corner:
    """What one station is at rest on a level deck, reduced to its wheels' vertical travel.

    Attributes:
        load_N: Vertical load of the station.
        rise_m: Wheel centre above its place at full droop, helicopter axes.
        deflection_m: Vertical tire deflection.
        tires: How many share the load.
        lever: Strut compression over wheel rise, secant.
        strut_Nspm: Damping of the strut, mean of compression and extension at small speed.
        tire_Nspm: Vertical damping of one tire.
        tangent_Npm: Stiffness of the station, strut and tires in series, against small motions about the rest.
        carriage_m: Distance from mount to carriage along ``o_z``, as the state has it.
        orientation: Euler parameters O to H.
        centres_H_m: Tire centres of the rigid vehicle from the description's reference point, H axes.
    """

    load_N: float
    rise_m: float
    deflection_m: float
    tires: int
    lever: float
    strut_Nspm: float
    tire_Nspm: float
    tangent_Npm: float
    carriage_m: float
    orientation: tuple[float, float, float, float]
    centres_H_m: tuple[tuple[float, float, float], ...]

    @property
    def secant_Npm(self) -> float:
        """Load over the whole way from touching the deck to the rest: the series stiffness of the station [N/m]."""
        return self.load_N / (self.rise_m + self.deflection_m)

    @property
    def damping_Nspm(self) -> float:
        """Damping of the series for slow motion: each part by the square of its share of the speed [N s/m]."""
        strut = self.load_N / self.rise_m
        tire = self.load_N / self.deflection_m
        share = tire / (strut + tire)  # of the speed that the strut takes
        return share**2 * self.lever**2 * self.strut_Nspm + (1.0 - share) ** 2 * self.tires * self.tire_Nspm


def corners(helicopter: Helicopter) -> dict[str, Corner]:
    """Every station at rest on a level deck, by name, found by the simulation itself."""
    batch = Batch(helicopter, 1)
    batch.place(0.0, 0.0, 0.0)
    return {name: _corner(batch, i, name) for i, name in enumerate(NAMES)}


def suspension_in_tires(helicopter: Helicopter) -> dict[str, Any]:
    """Changes that put the suspension into linear tires; every number is marked as derived.

    Vertical: `Corner.secant_Npm` and `Corner.damping_Nspm`, shared by the station's tires. A tire now deflects by the
    strut's travel too, so it has no rim to reach: the bottoming stiffness is zero, and with the struts their end stops
    are gone. Lateral and longitudinal stiffness, twist and relaxation are those of the tire alone, at the rest: a strut
    gives way along its axis only.

    Args:
        helicopter: The helicopter with its suspension.

    Returns:
        Changes for `ssmash_gym.vehicle.with_changes`.
    """
    changes: dict[str, Any] = {"tire_model": "linear"}
    for i, (name, corner) in enumerate(corners(helicopter).items()):
        station = helicopter.station_tuple[i]
        path = f"stations.{name}"
        if station.kind == "prismatic":
            drop = (*station.droop_m[:2], corner.carriage_m)
            changes[f"{path}.droop_m"] = _derived(drop, "carriage where it is at rest on a level deck")
        else:
            drop = station.droop_m
            changes[f"{path}.orientation"] = _derived(corner.orientation, "arm where it is at rest on a level deck")
        note = "stands in for a rigid strut while the helicopter settles; held afterwards"
        changes[f"{path}.spring"] = {
            "type": "linear_strut",
            "stiffness_Npm": {"value": RIGID_NPM, "origin": "assumed", "note": note},
            "damping_Nspm": {"value": RIGID_NSPM, "origin": "assumed", "note": note},
        }
        changes[f"{path}.end_stop.stroke_m"] = {"value": RIGID_STROKE_M, "origin": "assumed", "note": note}
        R_OH = rotation(corner.orientation).T
        for k, centre in enumerate(corner.centres_H_m):
            place = R_OH @ (np.array(centre) - np.array(station.mount_m)) - np.array(drop)
            changes |= _tire_changes(helicopter, i, k, f"{path}.tires.{k}", corner, place)
    return changes


def _tire_changes(helicopter: Helicopter, i: int, k: int, path: str, corner: Corner, place: Array) -> Mapping[str, Any]:
    """Changes of tire `k` of station `i`: where it is, and its constants."""
    linear = _linear(helicopter, i, k, corner)
    said = (
        f"secant at {corner.load_N / corner.tires / 1e3:.1f} kN: strut travel {corner.rise_m:.4f} m and tire "
        f"deflection {corner.deflection_m:.4f} m in series"
    )
    linear["vertical_stiffness_Npm"] = _derived(corner.secant_Npm / corner.tires, said)
    return {
        f"{path}.position_m": _derived(place, "tire centre where it is at full droop, fore and aft as at rest"),
        f"{path}.linear": linear,
        f"{path}.damping_z_Nspm": _derived(corner.damping_Nspm / corner.tires, "strut and tire in series, slow motion"),
        f"{path}.bottoming_stiffness_Npm": _derived(0.0, "the deflection holds the strut's travel: no rim to reach"),
    }


def _linear(helicopter: Helicopter, i: int, k: int, corner: Corner) -> dict[str, Any]:
    """Constants of the linear tire besides the vertical one: those of the description, else Smiley and Horne's."""
    tire = helicopter.station_tuple[i].tires[k]
    if tire.linear is not None:
        start = f"stations.{NAMES[i]}.tires.{k}.linear."
        marks = {key.removeprefix(start): mark for key, mark in helicopter.marks.items() if key.startswith(start)}
        return {
            key: {"value": value, "origin": marks[key].origin, "note": marks[key].note} if key in marks else value
            for key, value in tire.linear.model_dump().items()
        }
    column = parameter_column(helicopter)[:, None]
    base = TIRE_PAR + (2 * i + k) * TIRE_ROWS
    over_area = 1.0 / (tire.diameter_m * tire.width_m)
    deflection = np.array([corner.deflection_m])
    L_h, b_t = uncompiled(footprint)(column, base, deflection, over_area)
    found = uncompiled(properties)(
        column, base, int(TireModel.SMILEY_HORNE), deflection, np.zeros(1), L_h, b_t, over_area
    )
    _, k_x, k_y, k_psi, relaxation = (float(value[0]) for value in found[:5])
    note = f"Smiley and Horne at {corner.load_N / corner.tires / 1e3:.1f} kN"
    return {
        "longitudinal_stiffness_Npm": _derived(k_x, note),
        "lateral_stiffness_Npm": _derived(k_y, note),
        "twist_stiffness_Nmprad": _derived(k_psi, note),
        "relaxation_length_m": _derived(relaxation, note),
    }


def _derived(value: Any, note: str) -> dict[str, Any]:
    return {"value": np.asarray(value, dtype=float).tolist(), "origin": "derived", "note": note}


def _corner(batch: Batch, i: int, name: str) -> Corner:
    """One station of a batch of one at rest."""
    helicopter = batch.helicopters[0]
    station = helicopter.station_tuple[i]
    read = batch.telemetry
    row = State.Q15 + STATION_COORDINATES * i
    state = batch.state[:, 0]
    e0, e1, e2, e3 = (float(e) for e in state[row + 1 : row + 5])
    orientation = e0, e1, e2, e3
    centres = []
    rises = []
    for tire in station.tires:
        here = _centre(station, state[row], orientation, tire.position_m)
        there = _centre(station, station.droop_m[2], station.orientation, tire.position_m)
        rises.append(there[2] - here[2])
        centres.append((float(here[0]), float(here[1]), float(there[2])))
    rise = float(np.mean(rises))
    compression = float(read[f"{name}_compression"][0])
    spring = station.spring
    damping = 0.5 * (spring.c2_Nspm + spring.c02_Nspm) if isinstance(spring, GasOleo) else spring.damping_Nspm
    return Corner(
        load_N=float(read[f"{name}_vertical_load"][0]),
        rise_m=rise,
        deflection_m=float(read[f"{name}_tire_vertical_deflection"][0]),
        tires=len(station.tires),
        lever=compression / rise,
        strut_Nspm=damping,
        tire_Nspm=float(np.mean([tire.damping_z_Nspm for tire in station.tires])),
        tangent_Npm=_tangent(batch, i),
        carriage_m=float(state[row]),
        orientation=orientation,
        centres_H_m=tuple(centres),
    )


def _centre(station: Station, carriage: float, orientation: Any, position: tuple[float, float, float]) -> Array:
    """Tire centre from the reference point of the description, H axes [m]."""
    r_OT_O = np.array([*station.droop_m[:2], carriage]) + np.array(position)
    return np.asarray(np.array(station.mount_m) + rotation(orientation) @ r_OT_O)


def _tangent(batch: Batch, i: int) -> float:
    """Stiffness of a station against small vertical motion of its mount about the rest [N/m], by differences.

    The strut force is turned to the wheel by the work it does: ``F_wheel = F_strut dx/drise``.
    """
    helicopter = batch.helicopters[0]
    station = helicopter.station_tuple[i]
    row = State.Q15 + STATION_COORDINATES * i
    one = np.zeros(1, np.int64)
    forces, rises = [], []
    for sign in (-1.0, 1.0):
        state = batch.state.copy()
        size = sign * _STEP
        if station.kind == "prismatic":
            state[row] -= size
        else:
            arm = max(abs(station.droop_m[0]), 1e-3)
            turn(state, row + 1, (np.zeros(1), np.array([size / arm]), np.zeros(1)))
        _, outputs = batch.derivative(state, batch.parameters, batch.deck_rows(one))
        orientation = tuple(state[row + 1 : row + 5, 0])
        rises.append(-_centre(station, state[row, 0], orientation, station.tires[0].position_m)[2])
        forces.append(_strut(outputs, i))
    (f0, x0), (f1, x1) = forces
    lever = (x1 - x0) / (rises[1] - rises[0])
    strut = (f1 - f0) / (rises[1] - rises[0]) * lever
    tire = _tire_tangent(batch, i)
    return float(strut * tire / (strut + tire))


def _strut(outputs: Array, i: int) -> tuple[float, float]:
    """Force and compression of a strut from a column of outputs."""
    from ssmash_gym.dynamics.channels import STATION_OUT, STATION_OUT_ROWS, StaOut

    base = STATION_OUT + i * STATION_OUT_ROWS
    return float(outputs[base + StaOut.OLEO_FORCE, 0]), float(outputs[base + StaOut.COMPRESSION, 0])


def _tire_tangent(batch: Batch, i: int) -> float:
    """Vertical stiffness of a station's tires about the rest [N/m]: the body raised and lowered a little."""
    from ssmash_gym.dynamics.channels import STATION_OUT, STATION_OUT_ROWS, StaOut

    one = np.zeros(1, np.int64)
    loads = []
    for sign in (-1.0, 1.0):
        state = batch.state.copy()
        state[State.Q10] += sign * _STEP
        outputs = batch.derivative(state, batch.parameters, batch.deck_rows(one))[1]
        loads.append(outputs[STATION_OUT + i * STATION_OUT_ROWS + StaOut.VERTICAL_LOAD, 0])
    return float((loads[1] - loads[0]) / (2.0 * _STEP))
