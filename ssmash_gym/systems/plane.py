"""A helicopter that stands level: its body axes turned parallel to the deck, for systems that move in the deck's plane.

A helicopter at rest stands a little nose-up or nose-down. With heave, roll and pitch held it would turn about its own
tilted z axis: the wheels would rise and sink as it yaws. Here the axes of the description are turned to those of the
deck at rest, and every wheel touches the deck where it does in fact.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.cases.start import Settled, place
from ssmash_gym.dynamics.layout import STATION_COORDINATES, State
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.systems.rigid_suspension import NAMES
from ssmash_gym.vehicle import Helicopter, with_changes
from ssmash_gym.vehicle.geometry import rotation

Array = NDArray[np.float64]
NOTE: Final = "in axes parallel to the deck at rest"
ROUNDS: Final = 2  # the first leaves a thousandth of a degree or less, the second rounding


def level_axes(helicopter: Helicopter, steer_deg: float = 0.0) -> dict[str, Any]:
    """Changes that turn a helicopter's axes so that it rests level; every number is marked as derived.

    Points, directions and the inertia are turned. A station keeps its axes and its geometry about its mount, so that
    the steer axis is upright and the strut does what it did; its mount is put where the wheel stays in its place. The
    drag areas keep their values: they belong to axes that are now off by the angle of the rest, half a degree or less.

    Args:
        helicopter: The helicopter.
        steer_deg: Steer angle of the auxiliary station in the rest: it moves that wheel's contact.

    Returns:
        Changes for `ssmash_gym.vehicle.with_changes`.
    """
    changes: dict[str, Any] = {}
    for _ in range(ROUNDS):
        changes |= _turned(with_changes(helicopter, changes), steer_deg)
    return changes


def _turned(helicopter: Helicopter, steer_deg: float) -> dict[str, Any]:
    """Changes that turn the axes by what the helicopter rests off the level."""
    batch = Batch(helicopter, 1)
    place(batch, Settled(steer_deg=steer_deg, surface="level"), helicopter.name)
    state = batch.state[:, 0]
    R = _tilt(rotation(state[State.Q11 : State.Q14 + 1]))  # H to the deck at rest
    origin = np.array(helicopter.cg_offset_m)
    changes: dict[str, Any] = {
        "cg_offset_m": _derived(R @ origin),
        "inertia_kgm2": _derived(_symmetric(R @ np.array(helicopter.inertia_kgm2) @ R.T)),
        "probe.mount_m": _derived(R @ np.array(helicopter.probe.mount_m)),
        "probe.vector_m": _derived(R @ np.array(helicopter.probe.vector_m)),
        "aerodynamics.centre_of_pressure_m": _derived(R @ np.array(helicopter.aerodynamics.centre_of_pressure_m)),
    }
    for i, (name, station) in enumerate(zip(NAMES, helicopter.station_tuple, strict=True)):
        row = State.Q15 + STATION_COORDINATES * i
        turned = station.orientation if station.kind == "prismatic" else state[row + 1 : row + 5]  # steering left out
        carriage = rotation(turned) @ np.array([*station.droop_m[:2], state[row]])
        mount = np.array(station.mount_m)
        moved = R @ (mount + carriage) - carriage
        changes[f"stations.{name}.mount_m"] = _derived(moved)
        if station.arm is not None:
            point = np.array(station.arm.helicopter_point_m) + moved - mount
            changes[f"stations.{name}.arm.helicopter_point_m"] = _derived(point)
    return changes


def _tilt(R_SH: Array) -> Array:
    """The part of an attitude that is no yaw: pitch, then roll (yaw-pitch-roll angles)."""
    yaw = np.arctan2(R_SH[1, 0], R_SH[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) @ R_SH)


def _symmetric(tensor: Array) -> Array:
    return np.asarray(0.5 * (tensor + tensor.T))


def _derived(value: Array) -> dict[str, Any]:
    return {"value": value.tolist(), "origin": "derived", "note": NOTE}
