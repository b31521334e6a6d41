"""Wind force on the helicopter body."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.aero import place_wind, wind
from ssmash_gym.dynamics.lane import WIDTH, kernel, load, uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, PARAMETER_ROWS, Deck, Par
from ssmash_gym.dynamics.vectors import load3, rotation, store3

plain_wind = uncompiled(wind)
AREA, DENSITY = np.array([6.0, 20.0, 15.0]), 1.225
LEVEL = tuple(np.eye(3).reshape(9)[:, None])


def force(true_wind: object, velocity: object = (0.0, 0.0, 0.0), R_NH: tuple = LEVEL) -> np.ndarray:
    p = np.zeros((PARAMETER_ROWS, 1))
    p[Par.AREA : Par.AREA + 3, 0], p[Par.AIR_DENSITY] = AREA, DENSITY
    wind_N = tuple(np.asarray(true_wind, dtype=float)[:, None])
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        return np.array(plain_wind(p, wind_N, R_NH, tuple(np.asarray(velocity, dtype=float)[:, None])))[:, 0]


def test_no_wind_no_force() -> None:
    assert np.all(force((0.0, 0.0, 0.0)) == 0.0)
    np.testing.assert_array_equal(force((3.0, -8.0, 0.5), (3.0, -8.0, 0.5)), 0.0)


def test_force_of_a_beam_wind_pushes_downwind_with_the_square_of_speed() -> None:
    expected = 0.5 * DENSITY * 20.0 * 10.0**2
    np.testing.assert_allclose(force((0.0, 10.0, 0.0)), (0.0, expected, 0.0))
    np.testing.assert_allclose(force((0.0, -20.0, 0.0)), (0.0, -4.0 * expected, 0.0))
    np.testing.assert_allclose(force((0.0, 0.0, 0.0), (0.0, 10.0, 0.0)), (0.0, -expected, 0.0))


def test_eighteen_knots_of_ship_speed_on_twenty_square_metres_is_a_kilonewton() -> None:
    assert force((0.0, -18.0 * 1852.0 / 3600.0, 0.0))[1] == pytest.approx(-1.05e3, rel=0.01)


def test_components_share_the_norm_of_the_relative_wind() -> None:
    v = np.array([6.0, -8.0, 2.0])
    np.testing.assert_allclose(force(v), 0.5 * DENSITY * AREA * v * np.linalg.norm(v), rtol=1e-14)


def test_wind_is_turned_into_helicopter_axes() -> None:
    half = np.deg2rad(90.0) / 2  # helicopter nose to starboard: north wind comes over its port side
    R_NH = np.array(uncompiled(rotation)(np.cos(half), 0.0, 0.0, np.sin(half))).reshape(3, 3)
    F = force((10.0, 0.0, 0.0), R_NH=tuple(R_NH.reshape(9)[:, None]))
    np.testing.assert_allclose(F, (0.0, -0.5 * DENSITY * 20.0 * 100.0, 0.0), atol=1e-9)


@settings(max_examples=100, deadline=None)
@given(v=st.tuples(*[st.floats(-80.0, 80.0)] * 3), u=st.tuples(*[st.floats(-20.0, 20.0)] * 3))
def test_wind_does_work_on_what_drifts_slower_and_is_odd(v: tuple, u: tuple) -> None:
    F = force(v, u)
    assert F @ (np.array(v) - np.array(u)) >= 0.0
    np.testing.assert_array_equal(F, -force(-np.array(v), -np.array(u)))


PIECE = np.array([0.6, -1.1, 0.4, 2.0, -3.0, 0.7])  # coefficients of a gust speed's quintic


def placed(direction: object, since: object, gusty: int = 1) -> np.ndarray:
    """Wind rows at times since the piece's first node, (3, n)."""
    t = np.atleast_1d(np.asarray(since, dtype=float))
    p, d = np.zeros((PARAMETER_ROWS, t.size)), np.full((DECK_ROWS, t.size), 99.0)
    p[Par.WIND : Par.WIND + 3] = np.array([3.0, -8.0, 0.5])[:, None]
    p[Par.GUST : Par.GUST + 3] = np.asarray(direction, dtype=float)[:, None]
    uncompiled(place_wind)(p, gusty, np.repeat(PIECE[:, None], t.size, axis=1), t, d)
    assert np.all(d[: Deck.WIND] == 99.0)
    return d[Deck.WIND : Deck.WIND + 3]


def test_a_gust_adds_its_speed_along_its_direction() -> None:
    t = np.linspace(0.0, 0.25, 11)
    speed = np.polynomial.polynomial.polyval(t, PIECE)
    expected = np.array([3.0, -8.0, 0.5])[:, None] + np.array([0.6, 0.8, 0.0])[:, None] * speed
    np.testing.assert_allclose(placed((0.6, 0.8, 0.0), t), expected, atol=1e-14)
    assert np.ptp(speed) > 0.1
    assert np.array_equal(placed((0.0, 0.0, 0.0), t), placed((0.6, 0.8, 0.0), t, gusty=0))  # bit for bit


@kernel
def wind_driver(p, y, out):
    R_NH = rotation(load(y, 0), load(y, 1), load(y, 2), load(y, 3))
    store3(out, 0, wind(p, load3(y, 7), R_NH, load3(y, 4)))


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        p = rng.uniform(0.0, 20.0, (PARAMETER_ROWS, WIDTH))
        y = rng.normal(size=(10, WIDTH))
        lanes, plain = np.zeros((3, WIDTH)), np.zeros((3, WIDTH))
        wind_driver(p, y, lanes)
        uncompiled(wind_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()
