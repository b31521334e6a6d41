"""Quantities as tables and figures print them: kilonewtons, degrees, millimetres; each by name, from a history.

A new quantity is one entry of `QUANTITIES`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.cases.run import History
from ssmash_gym.dynamics import vectors
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import STATION_COORDINATES, State
from ssmash_gym.ship.kinematics import angles_from_rotation, rotation
from ssmash_gym.ship.motion import MotionTable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """One quantity.

    Attributes:
        name: Its name, unit included.
        label: What an axis calls it.
        unit: Unit as printed.
        of: Its values at the rows of a history, (m,).
    """

    name: str
    label: str
    unit: str
    of: Callable[[History], Array]


def _channel(name: str, scale: float = 1.0) -> Callable[[History], Array]:
    return lambda history: scale * history[name]


def _state(row: int) -> Callable[[History], Array]:
    return lambda history: np.array(history.states[row])


def _sum(*names: str) -> Callable[[History], Array]:
    return lambda history: np.asarray(1e-3 * sum(history[name] for name in names))


def _strut(i: int) -> Callable[[History], Array]:
    return _state(State.Q15 + STATION_COORDINATES * i)


def attitude_N(history: History) -> Array:
    """Roll, pitch, yaw of the helicopter relative to N (yaw-pitch-roll), (3, m) [rad]."""
    deck = np.stack([history[f"deck_{name}"] for name in ("roll", "pitch", "yaw")], axis=-1)
    R_NS = rotation(deck)
    flat = uncompiled(vectors.rotation)(*history.states[State.Q11 : State.Q14 + 1])
    R_SH = np.moveaxis(np.array(flat).reshape(3, 3, -1), -1, 0)
    roll, pitch, yaw = angles_from_rotation(R_NS @ R_SH).T
    return np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)])


def height_N(history: History) -> Array:
    """Z of the body's c.g. from the mean place of the ship-frame origin, N axes, (m,) [m]."""
    table: MotionTable = history.deck
    deck = table.pose(history.time_s - history.time_s[0])
    r_SH_S = history.states[State.Q8 : State.Q10 + 1].T
    return np.asarray(deck.r_NS_N[:, 2] + np.einsum("mij,mj->mi", deck.R_NS, r_SH_S)[:, 2])


def probe_measured(history: History) -> Array:
    """In-plane probe force as the probe's gauges read it: turned with the probe about its axis, (2, m) [N]."""
    fx, fy = history["probe_fx"], history["probe_fy"]
    turn = history.case.probe_turn
    if turn is None:
        return np.stack([fx, fy])
    span = turn.to_s - turn.from_s
    since = history.time_s - turn.from_s
    share = np.clip(since / span, 0.0, 1.0) if span > 0.0 else np.where(since >= 0.0, 1.0, 0.0)
    angle = np.radians(turn.angle_deg) * share
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * fx + s * fy, c * fy - s * fx])


def _attitude(k: int) -> Callable[[History], Array]:
    return lambda history: np.asarray(np.degrees(attitude_N(history)[k]))


def _gauge(k: int) -> Callable[[History], Array]:
    return lambda history: np.asarray(1e-3 * probe_measured(history)[k])


def _angle(name: str) -> Callable[[History], Array]:
    return lambda history: np.asarray(np.degrees(np.unwrap(history[name])))


_DEG: Final = 180.0 / np.pi
_LOADS: Final = tuple(f"{station}_vertical_load" for station in ("auxiliary", "right", "left"))
_ALL: Final = (
    Quantity("nose_load_kN", "nose tire load", "kN", _channel(_LOADS[0], 1e-3)),
    Quantity("right_load_kN", "right tire load", "kN", _channel(_LOADS[1], 1e-3)),
    Quantity("left_load_kN", "left tire load", "kN", _channel(_LOADS[2], 1e-3)),
    Quantity("sum_load_kN", "sum of the tire loads", "kN", _sum(*_LOADS)),
    Quantity("main_sum_load_kN", "sum of the main tire loads", "kN", _sum(*_LOADS[1:])),
    Quantity("roll_deg", "roll relative to the deck", "deg", _channel("roll", _DEG)),
    Quantity("pitch_deg", "pitch relative to the deck", "deg", _channel("pitch", _DEG)),
    Quantity("yaw_deg", "yaw relative to the deck", "deg", _angle("yaw")),
    Quantity("roll_N_deg", "roll angle", "deg", _attitude(0)),
    Quantity("pitch_N_deg", "pitch angle", "deg", _attitude(1)),
    Quantity("yaw_N_deg", "yaw angle", "deg", _attitude(2)),
    Quantity("deck_roll_deg", "roll of the deck", "deg", _channel("deck_roll", _DEG)),
    Quantity("deck_pitch_deg", "pitch of the deck", "deg", _channel("deck_pitch", _DEG)),
    Quantity("deck_yaw_deg", "yaw of the deck", "deg", _channel("deck_yaw", _DEG)),
    Quantity("steer_deg", "steer angle", "deg", _angle("auxiliary_steer")),
    Quantity("x_m", "c.g. along the deck", "m", _state(State.Q8)),
    Quantity("y_m", "c.g. across the deck", "m", _state(State.Q9)),
    Quantity("z_m", "c.g. over the deck, z", "m", _state(State.Q10)),
    Quantity("z_N_m", "c.g. z position", "m", height_N),
    Quantity("nose_compression_m", "nose oleo compression", "m", _channel("auxiliary_compression")),
    Quantity("nose_extension_m", "nose gear oleo extension", "m", _strut(0)),
    Quantity("right_extension_m", "right main gear oleo extension", "m", _strut(1)),
    Quantity("left_extension_m", "left main gear oleo extension", "m", _strut(2)),
    Quantity("probe_x_kN", "probe x-force", "kN", _gauge(0)),
    Quantity("probe_y_kN", "probe y-force", "kN", _gauge(1)),
    Quantity("probe_in_plane_kN", "in-plane probe load", "kN", _channel("probe_in_plane", 1e-3)),
    Quantity("tire_deflection_m", "right tire lateral deflection", "m", _channel("right_tire_lateral_deflection")),
    Quantity(
        "nose_tire_deflection_mm", "auxiliary tire lateral deflection", "mm",
        _channel("auxiliary_tire_lateral_deflection", 1e3),
    ),
    Quantity(
        "right_tire_deflection_mm", "right main tire lateral deflection", "mm",
        _channel("right_tire_lateral_deflection", 1e3),
    ),
    Quantity(
        "left_tire_deflection_mm", "left main tire lateral deflection", "mm",
        _channel("left_tire_lateral_deflection", 1e3),
    ),
    Quantity("claw_x_m", "claw x-position", "m", _channel("claw_x")),
    Quantity("claw_y_m", "claw y-position", "m", _channel("claw_y")),
)  # fmt: skip
QUANTITIES: Final = {q.name: q for q in _ALL}


def quantity(name: str) -> Quantity:
    """The quantity of a name.

    Raises:
        KeyError: There is none.
    """
    if name not in QUANTITIES:
        raise KeyError(f"there is no quantity {name!r}; known are {', '.join(QUANTITIES)}")
    return QUANTITIES[name]
