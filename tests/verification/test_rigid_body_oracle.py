"""The production kernel against three multibody engines, and against conservation laws."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ssmash_gym.analysis import rigid_body_oracle as oracle
from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, State
from ssmash_gym.dynamics.vectors import rotation

DATA = Path(__file__).parent / "data"
CASES = json.loads((DATA / "rigid_body_cases.json").read_text())["cases"]
TRAJECTORIES = json.loads((DATA / "rigid_body_trajectories.json").read_text())["cases"]


@pytest.mark.parametrize("case", CASES, ids=[c["id"] for c in CASES])
def test_accelerations(case: dict[str, Any]) -> None:
    got, expected = oracle.accelerations(case), np.array(case["expected"]["udot"])
    assert np.linalg.norm(got - expected) <= 1e-9 * np.linalg.norm(expected)
    assert np.max(np.abs(got - expected) / (1.0 + np.abs(expected))) <= 1e-9


@pytest.mark.parametrize("case", TRAJECTORIES, ids=[c["id"] for c in TRAJECTORIES])
def test_trajectories(case: dict[str, Any]) -> None:
    got, expected = oracle.trajectory(case), np.array(case["expected"]["state_vectors"])
    assert got.shape == expected.shape
    assert np.linalg.norm(got[-1] - expected[-1]) <= 1e-8 * np.linalg.norm(expected[-1])


@pytest.mark.parametrize("case", CASES[::4], ids=[c["id"] for c in CASES[::4]])
def test_ship_position_and_velocity_do_not_matter(case: dict[str, Any]) -> None:
    moved = copy.deepcopy(case)
    moved["ship"]["r_S"] = [1e5, -2e5, 3e4]
    moved["ship"]["v_S"] = [9.0, -7.0, 5.0]
    assert np.array_equal(oracle.accelerations(moved), oracle.accelerations(case))


def test_every_speed_can_be_locked() -> None:
    for k in range(12):
        case = copy.deepcopy(CASES[k % 5])
        case["locked"] = [j == k for j in range(12)]
        udot = oracle.accelerations(case)
        assert udot[k] == 0.0
        assert np.count_nonzero(udot) == 11


def _momenta(case: dict[str, Any], y: np.ndarray, deck: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, float]:
    """Kinetic energy, linear and angular momentum (about the N origin's moving twin) in N axes, and sum |m v|."""
    rot = uncompiled(rotation)
    R_NS = deck[0:9, 0].reshape(3, 3)
    w_S, v_S, r_S = deck[9:12, 0], deck[15:18, 0], deck[DECK_ROWS:, 0]
    R_SH = np.array(rot(*y[State.Q11 : State.Q11 + 4])).reshape(3, 3)
    r_H, v_H, w_H = y[State.Q8 : State.Q8 + 3], y[State.U7 : State.U7 + 3], y[State.U10 : State.U10 + 3]
    w_NH_H = R_SH.T @ w_S + w_H
    bodies = [(case["params"]["helicopter"], r_H, v_H + np.cross(w_S, r_H), R_SH, w_NH_H)]
    for i, station in enumerate(case["params"]["stations"]):
        row = State.Q15 + 5 * i
        R_HO = np.array(rot(*y[row + 1 : row + 5])).reshape(3, 3)
        r_O = np.array([*case["state"]["stations"][i]["r_W"][:2], y[row]])
        u1, u2 = y[State.U13 + 2 * i], y[State.U14 + 2 * i]
        swing = station["type"] == "swing"
        w_O = np.array([0.0, u1 if swing else 0.0, u2])
        slide = np.array([0.0, 0.0, 0.0 if swing else u1])
        r_HW = np.array(station["mount"]) + R_HO @ r_O
        v_W = np.cross(w_NH_H, r_HW) + R_HO @ (np.cross(w_O, r_O) + slide)
        position = r_H + R_SH @ r_HW
        velocity = v_H + np.cross(w_S, r_H) + R_SH @ v_W
        bodies.append((station, position, velocity, R_SH @ R_HO, R_HO.T @ w_NH_H + w_O))
    energy, linear, angular, scale = 0.0, np.zeros(3), np.zeros(3), 0.0
    for body, r, v, R, w in bodies:
        m, inertia = body["mass"], np.array(body["inertia"])
        v_N, r_N = v_S + R_NS @ v, r_S + R_NS @ r
        energy += 0.5 * m * v_N @ v_N + 0.5 * w @ inertia @ w
        linear += m * v_N
        angular += np.cross(r_N, m * v_N) + R_NS @ R @ inertia @ w
        scale += m * float(np.linalg.norm(v_N))
    return energy, linear, angular, scale


@pytest.mark.parametrize("case", TRAJECTORIES[:1] + TRAJECTORIES[1:2], ids=["prismatic", "swing"])
def test_energy_and_momentum_whatever_the_ship_does(case: dict[str, Any]) -> None:
    case = copy.deepcopy(case)
    for wrench in (case["loads"]["H"], *case["loads"]["W"]):
        wrench["force"], wrench["moment"] = [0.0] * 3, [0.0] * 3
    for station in case["state"]["stations"]:
        station["u"] = [0.1 * u for u in station["u"]]  # keeps the strokes within metres over five seconds
    parameters, mode = oracle._parameters(case), oracle._mode(case)
    full = oracle._state(case)

    def deck(t: float) -> np.ndarray:
        rows = oracle.sinusoidal_deck(case["ship_motion"], t)
        wave = case["ship_motion"]["translation"]
        place = np.array(wave["amp"]) * np.sin(np.array(wave["omega"]) * t + np.array(wave["phase"]))
        return np.concatenate([rows, place[:, None]])

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        full[:34, 0] = y
        return engine.derivative(full, parameters, mode, deck(t)[:DECK_ROWS])[0][:34, 0]

    solution = solve_ivp(rhs, (0.0, 5.0), full[:34, 0].copy(), "DOP853", rtol=1e-12, atol=1e-13)
    e0, p0, h0, scale = _momenta(case, solution.y[:, 0], deck(0.0))
    e1, p1, h1, _ = _momenta(case, solution.y[:, -1], deck(5.0))
    assert abs(e1 - e0) < 1e-10 * e0
    assert np.linalg.norm(p1 - p0) < 1e-10 * scale
    assert np.linalg.norm(h1 - h0) < 1e-10 * max(np.linalg.norm(h0), scale)
