"""Tires under random inputs: symmetry, no NaN and no NumPy warning, the same bits on lanes and in NumPy."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from ssmash_gym.dynamics.lane import WIDTH, uncompiled
from ssmash_gym.dynamics.layout import TIRE_ROWS, Contact, Friction, Tir, TireModel
from tests.dynamics.tire_rig import many

MAIN = {
    "diameter": 0.56, "width": 0.17, "axle_radius": 0.025, "p_o": 1.0e6, "p_r": 1.0e6, "p_abs": 1.1e6,
    "mu": 0.8, "mu_rr": 0.01, "mu_axle": 0.05, "ctz": 0.03, "cx": 2000.0, "cy": 2500.0, "cz": 3000.0,
    "beta": 10.0, "sigma_min": 0.02, "bottom": 0.12, "bottom_k": 3e6, "pull": 100.0, "my_coeff": 0.25,
    "lin_kz": 8e5, "lin_kx": 9e5, "lin_ky": 5e5, "lin_kpsi": 1.5e4, "lin_sigma": 0.4,
}  # fmt: skip
MODES = [tuple(map(int, mode)) for mode in itertools.product(TireModel, Friction, Contact)]
# rows of the inputs x and of the results
R, HEIGHT, V, W, AXLE, STATE, LOCK = slice(0, 3), 3, slice(4, 7), slice(7, 10), slice(10, 13), slice(13, 16), 16
FORCE, MOMENT, F_Z, USE = slice(0, 3), slice(3, 6), 9, 16


plain = uncompiled(many)


def block(n: int, **changes: float) -> np.ndarray:
    p = np.zeros((TIRE_ROWS, n))
    for name, value in {**MAIN, **changes}.items():
        p[Tir[name.upper()]] = value
    return p


def answer(p: np.ndarray, x: np.ndarray, mode: tuple[int, int, int]) -> np.ndarray:
    out = np.full((17, x.shape[1]), np.nan)
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        plain(p, x, out, *mode)
    return out


def inputs(seed: int, n: int) -> np.ndarray:
    """Tires at the deck and in the air, at usual speeds."""
    rng = np.random.default_rng(seed)
    roll, yaw = rng.uniform(-0.5, 0.5, n), rng.uniform(-np.pi, np.pi, n)
    size = np.repeat([0.3, 0.0, 0.5, 0.3, 0.0, 0.02, 0.05, 0.0], [3, 1, 3, 3, 3, 2, 1, 1])
    x = rng.normal(size=(17, n)) * size[:, None]
    x[HEIGHT] = MAIN["diameter"] / 2 - rng.uniform(-0.02, 0.1, n)
    x[AXLE] = -np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)
    x[LOCK] = rng.integers(0, 2, n)
    return x


@pytest.mark.parametrize("mode", MODES)
def test_mirrored_tire_answers_in_the_mirror(mode: tuple[int, int, int]) -> None:
    polar, axial, state, same = (1, -1, 1), (-1, 1, -1), (1, -1, -1), (1,)
    flip_in = np.array([*polar, *same, *polar, *axial, *axial, *state, *same])[:, None]
    flip_out = np.array([*polar, *axial, *state, 1, -1, 1, 1, -1, 1, -1, 1])[:, None]
    p, x = block(200), inputs(1, 200)
    np.testing.assert_allclose(answer(p, flip_in * x, mode), flip_out * answer(p, x, mode), rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_answer_turns_with_the_heading(mode: tuple[int, int, int]) -> None:
    turn = np.array([[np.cos(0.7), -np.sin(0.7), 0.0], [np.sin(0.7), np.cos(0.7), 0.0], [0.0, 0.0, 1.0]])
    p, x = block(200), inputs(2, 200)
    expected = answer(p, x, mode)
    for rows in (R, V, W, AXLE):
        x[rows] = turn @ x[rows]
    for rows in (FORCE, MOMENT):
        expected[rows] = turn @ expected[rows]
    np.testing.assert_allclose(answer(p, x, mode), expected, rtol=1e-9, atol=1e-7)


WEIRD: list[dict[str, float]] = [
    {},
    {"mu": 0.0, "sigma_min": 0.0, "cy": 0.0},
    {"type_i": 1.0, "lin_ky": 0.0, "lin_kpsi": 0.0, "lin_sigma": 0.0, "sigma_min": 0.0},
]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("changes", WEIRD)
def test_no_input_makes_a_nan(mode: tuple[int, int, int], changes: dict[str, float]) -> None:
    n = 4000
    rng = np.random.default_rng(3)
    x = inputs(3, n)
    dz = np.where(rng.random(n) < 0.1, 0.0, rng.uniform(-1.0, 0.3, n))
    dz[: n // 8] = 10 ** rng.uniform(-15, -3, n // 8)
    x[HEIGHT] = MAIN["diameter"] / 2 - dz
    for rows, scale in ((V, 1.0), (W, 1.0), (STATE, 1e-3)):
        x[rows] = scale * rng.choice([-1.0, 0.0, 1.0], (3, n)) * 10 ** rng.uniform(-12, 5, (3, n))
    x[AXLE] = rng.normal(size=(3, n))
    x[AXLE, : n // 4] *= np.array([[0.0], [0.0], [1.0]])  # the wheel lies flat
    x[AXLE] /= np.linalg.norm(x[AXLE], axis=0)
    x[LOCK] = rng.choice([0.0, 0.5, 1.0], n)
    out = answer(block(n, **changes), x, mode)
    assert np.all(np.isfinite(out))
    assert np.all(out[F_Z] >= 0.0)
    assert np.all((out[USE] >= 0.0) & (out[USE] <= 1.0))


@pytest.mark.parametrize("mode", MODES)
def test_compiled_tire_gives_the_bits_of_the_uncompiled_one(mode: tuple[int, int, int]) -> None:
    p = block(WIDTH)
    x = inputs(5, 25 * WIDTH)
    for i in range(0, x.shape[1], WIDTH):
        part = np.ascontiguousarray(x[:, i : i + WIDTH])
        fast = np.full((17, WIDTH), np.nan)
        many(p, part, fast, *mode)
        np.testing.assert_array_equal(fast, answer(p, part, mode))


def test_one_tire_does_not_see_its_neighbours() -> None:
    p, x = block(8), inputs(6, 8)
    together = answer(p, x, (0, 0, 0))
    for k in range(8):
        np.testing.assert_array_equal(answer(p[:, k : k + 1], x[:, k : k + 1], (0, 0, 0))[:, 0], together[:, k])
