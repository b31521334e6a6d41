"""Held speeds: a speed at zero stays there exactly, and with all six joints held the helicopter is one rigid body."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, SPEEDS, STATION_ROWS, STATIONS, Deck, Par, Sta, State, StationKind
from ssmash_gym.dynamics.reference import Problem, integrate
from ssmash_gym.dynamics.vectors import rotation
from ssmash_gym.ship import Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import load_helicopter
from tests.dynamics.on_deck import PROMPT, WHEELS

HELICOPTERS = ("generic_tricycle", "seahawk_like")
JOINTS = tuple(range(int(State.U13), SPEEDS))
GROUPS = {
    **{f"u{7 + k}": (k,) for k in range(SPEEDS)},
    "u9 u10 u11": (2, 3, 4),
    "u13 u15 u17": (6, 8, 10),
    "all joints": JOINTS,
    "all but the yaw": tuple(k for k in range(SPEEDS) if k != State.U12),
}


def rolling(name: str, n: int) -> Batch:
    batch = Batch(load_helicopter(name), n, claw=PROMPT)
    batch.place(0.0, 0.0, 0.05)
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=6.0, period_s=5.0).bake(3.0, 0.25)] * n)
    return batch


def coordinates(batch: Batch, k: int) -> list[int]:
    """Rows of the state that speed k moves and no other speed does."""
    if k < 3:
        return [int(State.Q8) + k]
    if k < 6:
        return []
    i = (k - 6) // 2
    start = int(State.Q15) + 5 * i
    prismatic = batch.mode[i] == StationKind.PRISMATIC
    return ([start] if prismatic else [start + 1, start + 3]) if k % 2 == 0 else []


@pytest.mark.parametrize("name", HELICOPTERS)
def test_held_speeds_stay_zero_and_so_do_their_motions(name: str) -> None:
    """One column a group of held speeds; the last holds none."""
    groups = list(GROUPS.values())
    batch = rolling(name, len(groups) + 1)
    for column, group in enumerate(groups):
        for k in group:
            batch.parameters[Par.LOCK + k, column] = 1.0
            batch.state[k, column] = 0.0
    start = batch.state.copy()
    for _ in range(8):
        batch.advance([[0.5, 0.8]] * batch.n)
        for column, group in enumerate(groups):
            assert np.all(batch.state[list(group), column] == 0.0)
    assert not batch.diverged.any()
    for column, group in enumerate(groups):
        free = [k for k in range(SPEEDS) if k not in group and batch.parameters[Par.LOCK + k, -1] == 0.0]
        assert np.all(batch.state[free, column] != 0.0)
        for k in group:
            rows = coordinates(batch, k)
            # Euler parameters are scaled to unit length after each substep.
            np.testing.assert_allclose(batch.state[rows, column], start[rows, column], rtol=0.0, atol=1e-15)
            if rows:
                assert np.all(np.abs(batch.state[rows, -1] - start[rows, -1]) > 1e-7)


def test_held_speeds_hold_in_the_reference_too() -> None:
    batch = rolling("seahawk_like", 1)
    held = [int(State.U9), int(State.U10), int(State.U11)]
    batch.parameters[[Par.LOCK + k for k in held]] = 1.0
    timing = batch.timing
    start = Problem(
        batch.state[:, 0], batch.parameters[:, 0], batch.mode, batch.nodes[0], batch.claw_nodes[0],
        np.tile([0.5, 0.5], (2, 1)), timing.substep_s, timing.substeps, timing.substeps_per_node,
    )  # fmt: skip
    found = integrate(start, "Gear", rtol=1e-6)
    assert np.all(found.states[held] == 0.0)
    assert np.ptp(found.states[State.U7]) > 1e-3


# --- one rigid body --------------------------------------------------------------------------------------------------


def matrix(parameters: np.ndarray) -> np.ndarray:
    return np.array(uncompiled(rotation)(*parameters)).reshape(3, 3)


def tensor(rows: np.ndarray) -> np.ndarray:
    xx, xy, xz, yy, yz, zz = rows
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def bodies(y: np.ndarray, p: np.ndarray) -> list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]:
    """Mass, c.g. from the helicopter's, inertia about it, and axes of the four bodies; all in H axes."""
    found = [(p[Par.MASS], np.zeros(3), tensor(p[Par.IXX : Par.IZZ + 1]), np.eye(3))]
    for i in range(STATIONS):
        base, row = Par.STATION + i * STATION_ROWS, State.Q15 + 5 * i
        R_HO = matrix(y[row + 1 : row + 5])
        r_OW_O = np.array([p[base + Sta.DROOP], p[base + Sta.DROOP + 1], y[row]])
        I_W = R_HO @ tensor(p[base + Sta.IXX : base + Sta.IZZ + 1]) @ R_HO.T
        found.append((p[base + Sta.MASS], p[base + Sta.MOUNT : base + Sta.MOUNT + 3] + R_HO @ r_OW_O, I_W, R_HO))
    return found


def lumped(parts: list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, c.g. and inertia about it (parallel axes) of the bodies fixed to one another."""
    M = sum(m for m, _, _, _ in parts)
    c = sum(m * r for m, r, _, _ in parts) / M
    J = sum(t + m * ((r - c) @ (r - c) * np.eye(3) - np.outer(r - c, r - c)) for m, r, t, _ in parts)
    return M, c, J


def rigid_accelerations(y: np.ndarray, p: np.ndarray, d: np.ndarray) -> np.ndarray:
    """u7'..u12' of one rigid body under gravity and the external wrenches, by Newton and Euler."""
    parts = bodies(y, p)
    M, c, J = lumped(parts)
    force, torque = np.zeros(3), np.zeros(3)
    for k, (_, r, _, axes) in enumerate(parts):
        row = Par.WRENCH_H if k == 0 else Par.WRENCH_W + 6 * (k - 1)
        f = axes @ p[row : row + 3]
        force += f
        torque += axes @ p[row + 3 : row + 6] + np.cross(r - c, f)
    R_NS, R_SH = d[Deck.R_NS : Deck.R_NS + 9].reshape(3, 3), matrix(y[State.Q11 : State.Q11 + 4])
    w_S, wdot_S = d[Deck.W_NS_S : Deck.W_NS_S + 3], d[Deck.WDOT_NS_S : Deck.WDOT_NS_S + 3]
    a_S = R_NS.T @ d[Deck.A_NS_N : Deck.A_NS_N + 3]
    r, v, w_SH_H = y[State.Q8 : State.Q8 + 3], y[:3], y[3:6]
    w_H = R_SH.T @ w_S + w_SH_H
    spin = np.linalg.solve(J, torque - np.cross(w_H, J @ w_H))
    g_H = R_SH.T @ R_NS.T @ np.array([0.0, 0.0, p[Par.GRAVITY]])
    a_H = force / M + g_H - np.cross(spin, c) - np.cross(w_H, np.cross(w_H, c))
    transport = a_S + np.cross(wdot_S, r) + np.cross(w_S, np.cross(w_S, r)) + 2.0 * np.cross(w_S, v)
    turning = spin - R_SH.T @ wdot_S + np.cross(w_SH_H, R_SH.T @ w_S)
    return np.concatenate([R_SH @ a_H - transport, turning])


@pytest.mark.parametrize("name", HELICOPTERS)
def test_with_all_joints_held_it_accelerates_as_one_rigid_body(name: str) -> None:
    """In the air on a moving ship, under random wrenches on all four bodies; struts and wheels in any place."""
    rng = np.random.default_rng(7)
    n = 6
    batch = Batch(load_helicopter(name), n, claw=PROMPT)
    y, p, d = batch.state, batch.parameters, np.zeros((DECK_ROWS, n))
    p[[Par.LOCK + k for k in JOINTS]] = 1.0
    p[Par.PROBE_ACTIVE] = p[Par.AIR_DENSITY] = 0.0
    p[Par.WRENCH_H : Par.GUST] = 5.0e3 * rng.normal(size=(Par.GUST - Par.WRENCH_H, n))
    y[State.U7 : State.U13] = rng.normal(size=(6, n))
    y[State.Q8 : State.Q10 + 1] = np.array([[3.0], [1.0], [-30.0]]) + rng.normal(size=(3, n))
    for row in (State.Q11, *(State.Q15 + 5 * i + 1 for i in range(STATIONS))):
        y[row : row + 4] += 0.2 * rng.normal(size=(4, n))
        y[row : row + 4] /= np.linalg.norm(y[row : row + 4], axis=0)
    y[[State.Q15 + 5 * i for i in range(STATIONS)]] -= rng.uniform(0.0, 0.2, (STATIONS, n))
    for k in range(n):
        turned = rng.normal(size=4) * 0.1 + [1.0, 0.0, 0.0, 0.0]
        d[Deck.R_NS : Deck.R_NS + 9, k] = matrix(turned / np.linalg.norm(turned)).ravel()
    d[Deck.W_NS_S : Deck.W_NS_S + 6] = 0.3 * rng.normal(size=(6, n))
    d[Deck.A_NS_N : Deck.A_NS_N + 3] = rng.normal(size=(3, n))
    rates = engine.derivative(y, p, batch.mode, d)[0][:SPEEDS]
    expected = np.array([rigid_accelerations(y[:, k], p[:, k], d[:, k]) for k in range(n)]).T
    np.testing.assert_allclose(rates[:6], expected, rtol=1e-9, atol=1e-9)
    assert np.all(rates[list(JOINTS)] == 0.0)
    assert np.min(np.max(np.abs(expected), axis=1)) > 0.1


@pytest.mark.parametrize("name", HELICOPTERS)
def test_on_its_wheels_and_probe_it_moves_as_the_lumped_body(name: str) -> None:
    """Column 1 is one body with the lumped mass and inertia; its carriages weigh nothing."""
    batch = rolling(name, 2)
    y, p = batch.state, batch.parameters
    p[[Par.LOCK + k for k in JOINTS]] = 1.0
    y[list(JOINTS)] = 0.0
    M, c, J = lumped(bodies(y[:, 1], p[:, 1]))
    p[Par.MASS, 1] = M
    p[Par.IXX : Par.IZZ + 1, 1] = J[np.triu_indices(3)]
    points = [Par.PROBE_MOUNT, Par.CP]
    for i in range(STATIONS):
        base = Par.STATION + i * STATION_ROWS
        points += [base + Sta.MOUNT, base + Sta.P1]
        p[base + Sta.MASS : base + Sta.IZZ + 1, 1] = 0.0
    for row in points:
        p[row : row + 3, 1] -= c
    y[State.Q8 : State.Q10 + 1, 1] += matrix(y[State.Q11 : State.Q11 + 4, 1]) @ c
    for k in range(12):
        batch.advance([[0.5, 0.8 if k < 6 else -0.8]] * 2)
        read = batch.telemetry
        for name_ in [f"{wheel}_{load}_load" for wheel in WHEELS for load in ("vertical", "lateral")]:
            assert read[name_][1] == pytest.approx(read[name_][0], rel=1e-6, abs=0.01)
        for name_ in ("probe_fx", "probe_fy", "roll", "pitch", "yaw"):
            assert read[name_][1] == pytest.approx(read[name_][0], rel=1e-6, abs=1e-4)
    assert np.linalg.norm(c) > 0.01  # the origins differ
    assert np.all(batch.telemetry.peak_max("probe_in_plane") > 2000.0)
