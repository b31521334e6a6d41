"""A helicopter that is only just being set down: in the air over a moving deck, its lowest wheel at first contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import Deck, Par, State
from ssmash_gym.envs.scenario import EpisodeDraw
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.parameters import droop_state
from ssmash_gym.vehicle import Station
from ssmash_gym.vehicle.geometry import rotation

Array = NDArray[np.float64]
Columns = NDArray[np.int64]


def set_down(batch: Batch, columns: Columns, draws: Sequence[EpisodeDraw]) -> None:
    """Take up the helicopters whose draw has a sink rate, and let them come down where they stand.

    Such a helicopter is level with the horizon, follows the ship's mean course and speed, and sinks at the drawn rate;
    the deck comes to meet it as it moves at that moment. Suspensions are at full droop, the lowest tire just touches,
    the rotor carries nothing, and the probe is free. These are assumptions: a landing by a pilot is softer or harder.

    Args:
        batch: The helicopters, standing on the moving deck.
        columns: Which have a draw, (n,).
        draws: One each.
    """
    falling = [i for i, draw in enumerate(draws) if draw.start_sink_rate_m_s is not None]
    if not falling:
        return
    chosen = columns[falling]
    decks = batch.deck_rows(chosen)
    for i, k, deck in zip(falling, chosen, np.ascontiguousarray(decks.T), strict=True):
        batch.state[:, k] = _falling(batch, int(k), draws[i], deck)
    batch.parameters[Par.PROBE_ACTIVE, chosen] = 0.0  # or the claw would take the probe as soon as it dips in
    batch.evaluate(chosen)


def _falling(batch: Batch, k: int, draw: EpisodeDraw, deck: Array) -> Array:
    """State of column k in the air, (STATE_ROWS,)."""
    R_NS = deck[Deck.R_NS : Deck.R_NS + 9].reshape(3, 3)
    w_NS_S = deck[Deck.W_NS_S : Deck.W_NS_S + 3]
    yaw = deck[Deck.ANGLES + 2] + np.radians(draw.start_yaw_deg)
    R_NH = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    R_SH = _product(R_NS.T, R_NH)
    helicopter, standing = batch.helicopters[k], batch.state[:, k]
    lowest = max(_lowest(station, R_SH) for station in helicopter.station_tuple)
    shift = (draw.helicopter_cg_x_m, draw.helicopter_cg_y_m, draw.helicopter_cg_z_m)
    height = lowest - _product(R_SH, np.array(helicopter.cg_offset_m) + shift)[2]
    r_SH_S = np.array([standing[State.Q8], standing[State.Q9], -height])
    state = droop_state(helicopter, position_S=tuple(r_SH_S), orientation=_euler_parameters(R_SH))
    v_H_N = np.array([0.0, 0.0, float(draw.start_sink_rate_m_s or 0.0)])
    v_NS_N = deck[Deck.V_NS_N : Deck.V_NS_N + 3]
    state[State.U7 : State.U9 + 1] = _product(R_NS.T, v_H_N - v_NS_N) - np.cross(w_NS_S, r_SH_S)
    state[State.U10 : State.U12 + 1] = -_product(R_SH.T, w_NS_S)
    state[State.CLAW_X : State.CLAW_VY + 1] = standing[State.CLAW_X : State.CLAW_VY + 1]
    return state


def _lowest(station: Station, R_SH: Array) -> float:
    """How far the lowest tire of a station reaches below the reference point at full droop, along s_z [m].

    As the tire's vertical deflection counts it: a radius below the wheel's centre, however the wheel is inclined.
    """
    R_SO = _product(R_SH, rotation(station.orientation))
    carriage = _product(R_SH, np.array(station.mount_m)) + _product(R_SO, np.array(station.droop_m))
    wheels = [carriage + _product(R_SO, np.array(tire.position_m)) for tire in station.tires]
    reach = [wheel[2] + 0.5 * tire.diameter_m for wheel, tire in zip(wheels, station.tires, strict=True)]
    return float(max(reach))


def _product(R: Array, other: Array) -> Array:
    """``R @ other`` of a vector or a matrix, summed in a fixed order: a library's bits differ between machines."""
    return np.asarray(sum(np.multiply.outer(R[:, k], other[k]) for k in range(3)))


def _euler_parameters(R_SH: Array) -> tuple[float, float, float, float]:
    """Euler parameters H to S of a rotation by less than a right angle or so."""
    e0 = 0.5 * np.sqrt(1.0 + np.trace(R_SH))
    e = (R_SH[2, 1] - R_SH[1, 2], R_SH[0, 2] - R_SH[2, 0], R_SH[1, 0] - R_SH[0, 1])
    return float(e0), float(e[0] / (4.0 * e0)), float(e[1] / (4.0 * e0)), float(e[2] / (4.0 * e0))
