"""About the steer axis: friction, damping, free play."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import STATION_ROWS, Sta
from ssmash_gym.dynamics.steering import play_moment, steer_moment

plain_moment, plain_play = uncompiled(steer_moment), uncompiled(play_moment)
MU, C, BETA = 0.011, 45.0, 60.0
PLAY, STOP_K, STOP_C = 0.02, 8.0e4, 300.0


def block() -> np.ndarray:
    p = np.zeros((STATION_ROWS, 1))
    p[Sta.STEER_MU], p[Sta.STEER_C], p[Sta.STEER_BETA] = MU, C, BETA
    p[Sta.STEER_PLAY], p[Sta.STEER_STOP_K], p[Sta.STEER_STOP_C] = PLAY, STOP_K, STOP_C
    p[Sta.STEER_COS] = 1.0
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


# --- free play -----------------------------------------------------------------------------------------------------


def at(angle: np.ndarray | float, rate: np.ndarray | float = 0.0, p: np.ndarray | None = None) -> np.ndarray:
    """Moment and slope of the play at steer angles, (2, n)."""
    angle, rate = np.broadcast_arrays(np.atleast_1d(angle), rate)
    return np.array(plain_play(block() if p is None else p, 0, np.cos(0.5 * angle), np.sin(0.5 * angle), rate * 1.0))


def test_within_the_play_there_is_nothing_and_beyond_it_a_spring() -> None:
    angle = np.array([-0.1, -0.03, -0.02, -0.019, 0.0, 0.015, 0.02, 0.021, 0.1])
    M, slope = at(angle)
    beyond = np.maximum(np.abs(angle) - PLAY, 0.0)
    np.testing.assert_allclose(M, -STOP_K * beyond * np.sign(angle), rtol=0.01, atol=STOP_K * 1e-6)
    assert np.all(M[[3, 4, 5]] == 0.0) and np.all(slope[[3, 4, 5]] == 0.0)
    moving = at(np.array([-0.019, 0.0, 0.019]), np.array([-3.0, 2.0, 5.0]))
    assert np.all(moving == 0.0)


def test_the_angle_is_as_close_as_it_says() -> None:
    """Too large by angle^3 / 12: a quarter of a percent at 10 deg, one at 20; and growing up to half a turn."""
    p = block()
    p[Sta.STEER_PLAY] = 0.0
    for degrees, percent in ((1.0, 0.0025), (10.0, 0.25), (20.0, 1.03)):
        angle = np.deg2rad(degrees)
        found = -at(angle, p=p)[0, 0] / STOP_K
        assert 100.0 * (found / angle - 1.0) == pytest.approx(percent, rel=0.03)
    M = at(np.linspace(0.0, 0.999 * np.pi, 500), p=p)[0]
    assert np.all(np.diff(M) < 0.0)
    assert np.all(np.isfinite(at(np.array([np.pi, -np.pi]), 1.0, p)))


def test_the_lock_is_where_the_orientation_at_droop_puts_it() -> None:
    """A raked strut that is locked 0.3 rad to starboard: the play lies about that angle."""
    rake = np.array([np.cos(0.1), 0.0, np.sin(0.1), 0.0])
    p = block()
    p[[Sta.STEER_COS, Sta.STEER_SIN], 0] = np.cos(0.15), np.sin(0.15)

    def moment(angle: float) -> float:
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        e0, e3 = rake[0] * c, rake[0] * s  # quaternion product of the rake and a turn about o_z
        return float(plain_play(p, 0, np.array([e0]), np.array([e3]), np.zeros(1))[0][0])

    assert moment(0.3 + 0.99 * PLAY) == 0.0 and moment(0.3 - 0.99 * PLAY) == 0.0
    assert moment(0.3 + 0.05) == pytest.approx(-0.03 * STOP_K, rel=1e-3)
    assert moment(0.3 - 0.05) == pytest.approx(0.03 * STOP_K, rel=1e-3)


@settings(max_examples=200, deadline=None)
@given(angle=st.floats(-0.3, 0.3) | st.floats(0.0199, 0.0202), rate=st.floats(-100.0, 100.0) | st.floats(-1e-7, 1e-7))
def test_the_stop_never_drives_outwards_and_its_damping_only_takes(angle: float, rate: float) -> None:
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        moment, slope = at(angle, rate)[:, 0]
    elastic = at(angle)[0, 0]
    assert moment * angle <= 1e-9
    assert 0.0 <= slope <= STOP_C
    assert moment == pytest.approx(elastic - slope * rate, rel=1e-12, abs=1e-9)


def test_the_stop_is_continuous_where_it_is_met() -> None:
    for rate in (-2.0, 0.0, 2.0):
        M = at(np.linspace(PLAY - 1e-3, PLAY + 3e-3, 40_001), rate)[0]
        steepest = STOP_K + 2.0 * STOP_C / 1e-3
        assert np.max(np.abs(np.diff(M))) < 1.05 * steepest * 1e-7


@kernel
def steering_driver(p, y, out):
    M, slope = steer_moment(p, 0, load(y, 0), load(y, 1))
    store(out, 0, M)
    store(out, 1, slope)
    M, slope = play_moment(p, 0, load(y, 2), load(y, 3), load(y, 0))
    store(out, 2, M)
    store(out, 3, slope)


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (STATION_ROWS, WIDTH)))
    for _ in range(200):
        y = rng.normal(size=(4, WIDTH)) * 10.0 ** rng.uniform(-12, 2, (4, WIDTH))
        y[1] = np.abs(y[1]) * 1e3
        y[2:] /= np.linalg.norm(y[2:], axis=0)
        lanes, plain = np.zeros((4, WIDTH)), np.zeros((4, WIDTH))
        steering_driver(p, y, lanes)
        uncompiled(steering_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()
