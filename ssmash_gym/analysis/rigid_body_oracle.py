"""Rigid-body reference cases through the production kernel.

A case gives masses, inertias, a state, the ship's kinematics and the loads at each body's centre of gravity; no
force element acts. It is answered by the same compiled right-hand side that runs everything else, with the force
elements switched off by their parameters: no tires, no springs, no probe, no wind, no gravity.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    DECK_ROWS,
    MODES,
    ODE_ROWS,
    PARAMETER_ROWS,
    SPEEDS,
    STATE_ROWS,
    STATION_ROWS,
    Deck,
    Mode,
    Par,
    Sta,
    State,
    StationKind,
    Tir,
)
from ssmash_gym.dynamics.vectors import rotation
from ssmash_gym.ship.kinematics import angular_acceleration, angular_velocity
from ssmash_gym.ship.kinematics import rotation as attitude

Array = NDArray[np.float64]
Case = Mapping[str, Any]
STATE_OUT = 34  # columns of STATE.OUT without the time


def accelerations(case: Case) -> Array:
    """Generalized accelerations u7'..u18' of one case, (12,), SI units.

    Args:
        case: as in ``tests/verification/data/rigid_body_cases.json`` (its key `schema` says what every number is).
    """
    deck = np.zeros((DECK_ROWS, 1))
    ship = case["ship"]
    deck[Deck.R_NS : Deck.R_NS + 9, 0] = uncompiled(rotation)(*ship["p_S"])
    deck[Deck.W_NS_S : Deck.W_NS_S + 3, 0] = ship["w_S"]
    deck[Deck.WDOT_NS_S : Deck.WDOT_NS_S + 3, 0] = ship["wdot_S"]
    deck[Deck.V_NS_N : Deck.V_NS_N + 3, 0] = ship["v_S"]
    deck[Deck.A_NS_N : Deck.A_NS_N + 3, 0] = ship["a_S"]
    rates, _ = engine.derivative(_state(case), _parameters(case), _mode(case), deck)
    return np.asarray(rates[:SPEEDS, 0])


def trajectory(case: Case) -> Array:
    """States in STATE.OUT order at the case's output times, (n, 34), by DOP853 at tight tolerance.

    The ship follows the sinusoids of ``case["ship_motion"]``, evaluated exactly.
    """
    from scipy.integrate import solve_ivp

    parameters, mode = _parameters(case), _mode(case)
    full = _state(case)

    def rhs(t: float, y: Array) -> Array:
        full[:STATE_OUT, 0] = y
        rates, _ = engine.derivative(full, parameters, mode, sinusoidal_deck(case["ship_motion"], t))
        return np.asarray(rates[:STATE_OUT, 0])

    times = np.asarray(case["expected"]["t"], dtype=np.float64)
    start = full[:STATE_OUT, 0].copy()
    solution = solve_ivp(rhs, (times[0], times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-13)
    return np.asarray(solution.y.T)


def sinusoidal_deck(motion: Mapping[str, Any], t: float) -> Array:
    """`Deck` rows (DECK_ROWS, 1) of ``amp sin(omega t + phase)`` in the three angles [rad] and positions [m]."""
    angle, move = (_sinusoid(motion[key], t) for key in ("angles", "translation"))
    deck = np.zeros((DECK_ROWS, 1))
    deck[Deck.R_NS : Deck.R_NS + 9, 0] = attitude(angle[0]).ravel()
    deck[Deck.W_NS_S : Deck.W_NS_S + 3, 0] = angular_velocity(angle[0], angle[1])
    deck[Deck.WDOT_NS_S : Deck.WDOT_NS_S + 3, 0] = angular_acceleration(*angle)
    deck[Deck.V_NS_N : Deck.V_NS_N + 3, 0] = move[1]
    deck[Deck.A_NS_N : Deck.A_NS_N + 3, 0] = move[2]
    return deck


def _sinusoid(wave: Mapping[str, Any], t: float) -> tuple[Array, Array, Array]:
    amp, omega, phase = (np.asarray(wave[key], dtype=np.float64) for key in ("amp", "omega", "phase"))
    s, c = np.sin(omega * t + phase), np.cos(omega * t + phase)
    return amp * s, amp * omega * c, -amp * omega**2 * s


def _mode(case: Case) -> NDArray[np.int64]:
    mode = np.zeros(MODES, np.int64)
    for i, station in enumerate(case["params"]["stations"]):
        kind = StationKind.SWING_ARM if station["type"] == "swing" else StationKind.PRISMATIC
        mode[Mode.STATION_KIND + i] = kind
    return mode


def _tensor(inertia: Any) -> tuple[float, ...]:
    return tuple(inertia[a][b] for a, b in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


def _parameters(case: Case) -> Array:
    p = np.zeros((PARAMETER_ROWS, 1))
    p[Par.PROBE_VECTOR + 2] = 1.0
    p[int(Par.STATION) + 3 * STATION_ROWS :] = 1.0  # unused tires, kept away from zero diameters
    p[int(Par.STATION) + 3 * STATION_ROWS + int(Tir.TYPE_I)] = 0.0
    body = case["params"]["helicopter"]
    p[Par.MASS] = body["mass"]
    p[Par.IXX : Par.IZZ + 1, 0] = _tensor(body["inertia"])
    p[Par.LOCK : Par.LOCK + SPEEDS, 0] = case["locked"]
    p[Par.WRENCH_H : Par.WRENCH_H + 6, 0] = [*case["loads"]["H"]["force"], *case["loads"]["H"]["moment"]]
    stations = zip(case["params"]["stations"], case["state"]["stations"], case["loads"]["W"], strict=True)
    for i, (station, state, wrench) in enumerate(stations):
        base = int(Par.STATION) + i * STATION_ROWS
        p[base + Sta.MASS] = station["mass"]
        p[base + Sta.IXX : base + Sta.IZZ + 1, 0] = _tensor(station["inertia"])
        p[base + Sta.MOUNT : base + Sta.MOUNT + 3, 0] = station["mount"]
        p[base + Sta.DROOP : base + Sta.DROOP + 3, 0] = state["r_W"]
        p[base + Sta.P2 : base + Sta.P2 + 3] = 1.0
        row = int(Par.WRENCH_W) + 6 * i
        p[row : row + 6, 0] = [*wrench["force"], *wrench["moment"]]
    return p


def _state(case: Case) -> Array:
    state = np.zeros((STATE_ROWS, 1))
    s = case["state"]
    state[State.U7 : State.U7 + 3, 0] = s["v_H"]
    state[State.U10 : State.U10 + 3, 0] = s["w_H"]
    state[State.Q8 : State.Q8 + 3, 0] = s["r_H"]
    state[State.Q11 : State.Q11 + 4, 0] = s["p_H"]
    for i, station in enumerate(s["stations"]):
        state[State.U13 + 2 * i : State.U13 + 2 * i + 2, 0] = station["u"]
        row = int(State.Q15) + 5 * i
        state[row, 0] = station["r_W"][2]
        state[row + 1 : row + 5, 0] = station["p_O"]
    locked = np.flatnonzero(case["locked"])
    state[locked, 0] = 0.0
    return state


__all__ = ["ODE_ROWS", "accelerations", "trajectory"]
