"""The whole right-hand side: symmetry, invariance, energy, locks, wrenches and every choice of model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    SPEEDS,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    Deck,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.dynamics.oleo import spring_curve
from ssmash_gym.dynamics.vectors import rotation
from ssmash_gym.ship import Fixed, MotionTable, Sinusoid
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

HELICOPTERS = ("generic_tricycle", "seahawk_like")
WHEELS = ("auxiliary", "right", "left")
LINEAR = {"type": "linear_strut", "stiffness_Npm": 2.1e5, "damping_Nspm": 1.3e4}
PROMPT = ClawLimits(delay_s=0.0)


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


def at_rest(helicopter: Helicopter, n: int = 1, **keys: Any) -> Batch:
    batch = Batch(helicopter, n, claw=PROMPT, **keys)
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    return batch


def brake(batch: Batch, stations: tuple[int, ...] = (0, 1, 2)) -> None:
    for i in stations:
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] = 1.0


def loads(batch: Batch) -> np.ndarray:
    """Vertical tire loads of the three stations [N], (3, N)."""
    return np.array([batch.telemetry[f"{wheel}_vertical_load"] for wheel in WHEELS])


def weight(batch: Batch) -> np.ndarray:
    masses = [Par.MASS] + [Par.STATION + i * STATION_ROWS + Sta.MASS for i in range(STATIONS)]
    return np.sum(batch.parameters[masses], axis=0) * batch.parameters[Par.GRAVITY]


# --- invariance and symmetry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_where_the_ship_is_does_not_matter(name: str) -> None:
    batch = Batch(load_helicopter(name), 2)
    nodes = Sinusoid(dof="roll", amplitude_deg=6.0, period_s=6.0).bake(2.0, batch.timing.node_spacing_s).nodes
    far = nodes.copy()
    far[:, :3] += [3000.0, -500.0, 40.0]
    batch.set_motion([MotionTable(0.25, nodes), MotionTable(0.25, far)])
    batch.place(0.0, 0.0, 0.05)
    for _ in range(10):
        batch.advance([[0.7, 0.2]] * 2)
    np.testing.assert_allclose(batch.state[:, 0], batch.state[:, 1], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_how_fast_the_ship_goes_matters_to_the_wind_only(name: str) -> None:
    """Galilei: a steady velocity changes nothing in a vacuum, and nothing if the air moves along."""
    batch = at_rest(load_helicopter(name))
    rng = np.random.default_rng(3)
    batch.state[:SPEEDS] += 0.1 * rng.normal(size=(SPEEDS, 1))
    decks = batch.deck_rows(np.array([0]))
    decks[Deck.W_NS_S : Deck.W_NS_S + 3, 0] = [0.1, -0.05, 0.02]
    moving = decks.copy()
    moving[Deck.V_NS_N : Deck.V_NS_N + 3, 0] += [9.0, -4.0, 1.0]

    def rates(rows: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        return engine.derivative(batch.state, parameters, batch.mode, rows)[0]

    vacuum = batch.parameters.copy()
    vacuum[Par.AIR_DENSITY] = 0.0
    assert np.array_equal(rates(decks, vacuum), rates(moving, vacuum))
    still, carried = batch.parameters.copy(), batch.parameters.copy()
    still[Par.WIND : Par.WIND + 3, 0] = [3.0, 6.0, 0.0]
    carried[Par.WIND : Par.WIND + 3, 0] = [12.0, 2.0, 1.0]
    np.testing.assert_allclose(rates(moving, carried), rates(decks, still), rtol=1e-9, atol=1e-11)
    assert np.max(np.abs(rates(moving, still) - rates(decks, still))) > 0.05


def test_the_tricycle_and_its_mirror_image_answer_as_mirror_images(tricycle: Helicopter) -> None:
    """Roll, yaw, sway and lateral claw turned round: port and starboard change places."""
    batch = Batch(tricycle, 2, claw=PROMPT)
    table = Sinusoid(dof="roll", amplitude_deg=6.0, period_s=5.0, pitch_deg=2.0).bake(5.0, 0.25, ramp_s=1.0).nodes
    nodes = [table + Sinusoid(dof="sway", amplitude_m=0.5, period_s=7.0).bake(5.0, 0.25, ramp_s=1.0).nodes]
    nodes.append(nodes[0] * np.tile([1.0, -1.0, 1.0, -1.0, 1.0, -1.0], 3))
    batch.set_motion([MotionTable(0.25, rows) for rows in nodes])
    batch.parameters[Par.WIND : Par.WIND + 2] = [[5.0, 5.0], [8.0, -8.0]]
    batch.place(0.0, [0.05, -0.05], [0.1, -0.1])
    for k in range(50):
        lateral = 0.8 if k < 20 else -0.5
        batch.advance([[0.6, lateral], [0.6, -lateral]])
    read = {name: batch.telemetry[name] for name in ("position_x", "pitch", "auxiliary_vertical_load", "probe_fx")}
    for name, value in read.items():
        np.testing.assert_allclose(value[1], value[0], rtol=1e-8, atol=1e-6, err_msg=name)
    for name in ("position_y", "roll", "yaw", "auxiliary_steer", "probe_fy", "auxiliary_lateral_load"):
        value = batch.telemetry[name]
        np.testing.assert_allclose(value[1], -value[0], rtol=1e-8, atol=1e-6, err_msg=name)
        assert abs(value[0]) > 1e-3
    for name in ("vertical_load", "compression", "tire_vertical_deflection"):
        right, left = batch.telemetry[f"right_{name}"], batch.telemetry[f"left_{name}"]
        np.testing.assert_allclose(right, left[::-1], rtol=1e-8, atol=1e-9, err_msg=name)
        assert right[0] != pytest.approx(right[1], rel=1e-3)


# --- energy --------------------------------------------------------------------------------------------------------


def energy(batch: Batch, springs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Kinetic energy, energy of height and of the struts' gas [J], (N,)."""
    y, p = batch.state, batch.parameters
    rot = uncompiled(rotation)
    R_SH = np.array(rot(*y[State.Q11 : State.Q11 + 4])).reshape(3, 3, -1)
    w_H = y[State.U10 : State.U10 + 3]
    v_H = y[State.U7 : State.U7 + 3]
    total = 0.5 * p[Par.MASS] * np.sum(v_H**2, axis=0) + spin(p[Par.IXX : Par.IZZ + 1], w_H)
    total = total - p[Par.MASS] * p[Par.GRAVITY] * y[State.Q10]
    for i in range(STATIONS):
        base, row = Par.STATION + i * STATION_ROWS, State.Q15 + 5 * i
        R_HO = np.array(rot(*y[row + 1 : row + 5])).reshape(3, 3, -1)
        r_OW_O = np.array([p[base + Sta.DROOP], p[base + Sta.DROOP + 1], y[row]])
        r_OW_H = np.einsum("ijn,jn->in", R_HO, r_OW_O)
        r_HW_H = p[base + Sta.MOUNT : base + Sta.MOUNT + 3] + r_OW_H
        u, steer = y[State.U13 + 2 * i], y[State.U14 + 2 * i]
        zero = np.zeros_like(u)
        swing = batch.mode[i] == 2
        w_O = np.einsum("ijn,jn->in", R_HO, np.array([zero, u if swing else zero, steer]))
        slide = np.einsum("ijn,jn->in", R_HO, np.array([zero, zero, zero if swing else u]))
        v_W = v_H + np.einsum("ijn,jn->in", R_SH, np.cross(w_H, r_HW_H, axis=0) + np.cross(w_O, r_OW_H, axis=0) + slide)
        w_W = np.einsum("jin,jn->in", R_HO, w_H + w_O)
        height = -(y[State.Q10] + np.einsum("jn,jn->n", R_SH[2], r_HW_H))
        mass = p[base + Sta.MASS]
        total = total + 0.5 * mass * np.sum(v_W**2, axis=0) + spin(p[base + Sta.IXX : base + Sta.IZZ + 1], w_W)
        total = total + mass * p[Par.GRAVITY] * height
        x = batch.telemetry[f"{WHEELS[i]}_compression"]
        total = total + np.interp(x, *springs[i])
    return np.asarray(total)


def spin(t: np.ndarray, w: np.ndarray) -> np.ndarray:
    xx, xy, xz, yy, yz, zz = t
    a, b, c = w
    return 0.5 * (xx * a * a + yy * b * b + zz * c * c) + xy * a * b + xz * a * c + yz * b * c
