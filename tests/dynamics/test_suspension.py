"""Linear strut, end stop and swing-arm geometry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import STATION_ROWS, Sta
from ssmash_gym.dynamics.suspension import linear_strut, strut_geometry
from ssmash_gym.dynamics.vectors import rotation, store3

plain_strut, plain_geometry = uncompiled(linear_strut), uncompiled(strut_geometry)

MOUNT, P1, P2 = np.array([-4.0, 1.2, 0.9]), np.array([-4.3, 1.25, -0.4]), np.array([-0.5, 0.03, 0.25])


def block() -> np.ndarray:
    p = np.zeros((STATION_ROWS, 1))
    p[Sta.LINEAR_K], p[Sta.LINEAR_C] = 2.5e5, 1.2e4
    p[Sta.STROKE], p[Sta.STOP_K], p[Sta.STOP_C] = 0.25, 1.0e7, 5.0e4
    for row, vector in ((Sta.MOUNT, MOUNT), (Sta.P1, P1), (Sta.P2, P2)):
        p[row : row + 3, 0] = vector
    return p


def euler(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation matrix by Rodrigues' formula."""
    a = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def geometry(R: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    length, direction, lever = plain_geometry(block(), 0, tuple(R.reshape(9)[:, None]))
    return float(length[0]), np.array(direction)[:, 0], np.array(lever)[:, 0]


def test_linear_strut_is_spring_and_damper_up_to_the_stroke() -> None:
    x, v = np.array([-0.05, 0.0, 0.1, 0.25]), np.array([0.4, -0.3, 0.2, 1.0])
    F, slope = plain_strut(block(), 0, x, v)
    np.testing.assert_allclose(F, 2.5e5 * x + 1.2e4 * v, rtol=1e-14)
    np.testing.assert_array_equal(slope, 1.2e4)


def test_stop_is_continuous_in_compression_and_rate() -> None:
    p = block()
    for v in (-0.7, 0.0, 0.7):
        edge = plain_strut(p, 0, 0.25 + np.array([-1e-10, 1e-10]), np.full(2, v))[0]
        assert abs(edge[1] - edge[0]) < 0.1
    v = np.linspace(-3.0, 3.0, 60_001)
    F = plain_strut(p, 0, np.full_like(v, 0.2507), v)[0]
    assert np.max(np.abs(np.diff(F))) < 1.01 * (1.2e4 + 5e4) * (v[1] - v[0])


@settings(max_examples=200, deadline=None)
@given(
    x=st.floats(-1.0, 1.0) | st.floats(0.25, 0.27),
    v=st.floats(-50.0, 50.0) | st.floats(-1e-7, 1e-7),
)
def test_stop_never_pulls_and_the_rest_is_slope_times_rate(x: float, v: float) -> None:
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        F, slope = plain_strut(block(), 0, np.array([x]), np.array([v]))
    stop = F[0] - 2.5e5 * x - 1.2e4 * v
    elastic = 1e7 * max(x - 0.25, 0.0)
    assert stop >= -1e-6
    assert slope[0] >= 1.2e4
    assert stop - elastic == pytest.approx((slope[0] - 1.2e4) * v, rel=1e-9, abs=1e-5)


def test_a_stop_left_fast_lets_go_instead_of_pulling() -> None:
    x, v = np.full(3, 0.251), np.array([-0.1, -10.0, -50.0])
    stop = plain_strut(block(), 0, x, v)[0] - 2.5e5 * x - 1.2e4 * v
    np.testing.assert_allclose(stop, np.maximum(1e7 * 0.001 + 5e4 * v, 0.0), atol=1e-6)


def test_length_direction_and_lever_of_a_swing_arm() -> None:
    R = euler(np.array([0.1, 1.0, -0.2]), 0.3)
    length, direction, lever = geometry(R)
    between = MOUNT + R @ P2 - P1
    assert length == pytest.approx(np.linalg.norm(between), rel=1e-14)
    np.testing.assert_allclose(direction, between / np.linalg.norm(between), rtol=1e-13)
    np.testing.assert_allclose(lever, R @ P2, rtol=1e-13)


def test_rate_of_length_and_work_agree_with_finite_differences() -> None:
    rng = np.random.default_rng(1)
    h = 1e-5
    for _ in range(20):
        R, a = euler(rng.normal(size=3), 0.4 * rng.normal()), rng.normal(size=3)
        a /= np.linalg.norm(a)
        rate, F = rng.normal(), 2.0e4
        longer = geometry(euler(a, rate * h) @ R)[0] - geometry(euler(a, -rate * h) @ R)[0]
        _, direction, lever = geometry(R)
        assert direction @ np.cross(a * rate, lever) == pytest.approx(longer / (2 * h), rel=1e-7, abs=1e-9)
        # Joint power = power of a force F pushing the ends of the strut apart.
        joint = F * direction @ np.cross(a, lever)
        assert joint * rate == pytest.approx(F * longer / (2 * h), rel=1e-7, abs=1e-4)


def test_joint_force_is_the_printed_pair_of_wrenches_at_work() -> None:
    """(2.238)-(2.241): on the carriage at W and on the helicopter at H, for a rate about the joint axis."""
    rng = np.random.default_rng(2)
    R, a, F = euler(np.array([0.0, 1.0, 0.0]), 0.25), np.array([0.0, 1.0, 0.0]), 1.7e4
    _, direction, lever = geometry(R)
    r_OW_H = R @ rng.normal(size=3)
    w_H, v_H, rate = rng.normal(size=3), rng.normal(size=3), 0.8
    w_O = w_H + a * rate
    v_W = v_H + np.cross(w_H, MOUNT) + np.cross(w_O, r_OW_H)
    force, moment_W = F * direction, np.cross(lever - r_OW_H, F * direction)
    moment_H = -np.cross(P1, force)
    power = force @ v_W + moment_W @ w_O - force @ v_H + moment_H @ w_H
    assert power == pytest.approx(F * direction @ np.cross(a, lever) * rate, rel=1e-10)


def test_a_strut_of_no_length_stays_finite() -> None:
    p = block()
    p[Sta.P1 : Sta.P1 + 3] = p[Sta.MOUNT : Sta.MOUNT + 3] + p[Sta.P2 : Sta.P2 + 3]
    identity = tuple(np.eye(3).reshape(9)[:, None])
    with np.errstate(all="raise"):
        length, direction, _ = plain_geometry(p, 0, identity)
    assert length[0] == 0.0
    assert np.all(np.array(direction) == 0.0)


@kernel
def suspension_driver(p, y, out):
    F, slope = linear_strut(p, 0, load(y, 0), load(y, 1))
    R_HO = rotation(load(y, 2), load(y, 3), load(y, 4), load(y, 5))
    length, direction, lever = strut_geometry(p, 0, R_HO)
    store(out, 0, F)
    store(out, 1, slope)
    store(out, 2, length)
    store3(out, 3, direction)
    store3(out, 6, lever)


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (STATION_ROWS, WIDTH)))
    for _ in range(200):
        y = rng.normal(size=(6, WIDTH))
        y[0] *= 0.2
        y[2:] /= np.linalg.norm(y[2:], axis=0)
        lanes, plain = np.zeros((9, WIDTH)), np.zeros((9, WIDTH))
        suspension_driver(p, y, lanes)
        uncompiled(suspension_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()
