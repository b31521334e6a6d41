"""Friction and damping about the steer axis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import STATION_ROWS, Sta
from ssmash_gym.dynamics.steering import steer_moment

plain_moment = uncompiled(steer_moment)
MU, C, BETA = 0.011, 45.0, 60.0


def block() -> np.ndarray:
    p = np.zeros((STATION_ROWS, 1))
    p[Sta.STEER_MU], p[Sta.STEER_C], p[Sta.STEER_BETA] = MU, C, BETA
    return p


def test_moment_is_smoothed_friction_and_damping_against_the_rate() -> None:
    rate = np.array([-2.0, -0.01, 0.0, 1e-4, 0.5])
    F = np.array([2e4, 1e3, 5e3, 8e3, 0.0])
    M, slope = plain_moment(block(), 0, rate, F)
    np.testing.assert_allclose(M, -(MU * F * np.sign(rate) * -np.expm1(-BETA * np.abs(rate)) + C * rate), rtol=1e-12)
    assert slope[2] == pytest.approx(MU * 5e3 * BETA + C, rel=1e-6)
    assert slope[4] == C


@settings(max_examples=200, deadline=None)
@given(rate=st.floats(-100.0, 100.0) | st.floats(-1e-7, 1e-7), F=st.floats(0.0, 1e6))
def test_moment_never_drives_and_is_slope_times_rate(rate: float, F: float) -> None:
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        M, slope = plain_moment(block(), 0, np.array([rate]), np.array([F]))
    assert np.isfinite(slope[0])
    assert slope[0] >= C
    assert M[0] * rate <= 0.0
    assert M[0] == -slope[0] * rate


def test_moment_is_odd_and_continuous_through_rest() -> None:
    rate = np.linspace(-1e-3, 1e-3, 20_001)
    M, _ = plain_moment(block(), 0, rate, np.full_like(rate, 3e4))
    np.testing.assert_allclose(M, -M[::-1], atol=1e-9)
    assert np.max(np.abs(np.diff(M))) < 1.01 * (MU * 3e4 * BETA + C) * (rate[1] - rate[0])


@kernel
def steering_driver(p, y, out):
    M, slope = steer_moment(p, 0, load(y, 0), load(y, 1))
    store(out, 0, M)
    store(out, 1, slope)


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (STATION_ROWS, WIDTH)))
    for _ in range(200):
        y = rng.normal(size=(2, WIDTH)) * 10.0 ** rng.uniform(-12, 2, (2, WIDTH))
        y[1] = np.abs(y[1]) * 1e3
        lanes, plain = np.zeros((2, WIDTH)), np.zeros((2, WIDTH))
        steering_driver(p, y, lanes)
        uncompiled(steering_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()
