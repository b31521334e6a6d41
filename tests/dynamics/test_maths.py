"""Elementary functions: a few ulp from NumPy's, sane at the ends, the same bits compiled, uncompiled and anywhere."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssmash_gym.dynamics import maths
from ssmash_gym.dynamics.lane import WIDTHS, kernel, load, of_width, store, uncompiled

ROOT = Path(__file__).resolve().parents[2]
PLAIN = {name: uncompiled(getattr(maths, name)) for name in maths.__all__}
RNG_SEED = 11
COUNT = 20_000


def spread(low: float, high: float) -> np.ndarray:
    return np.random.default_rng(RNG_SEED).uniform(low, high, COUNT)


def decades(low: float, high: float) -> np.ndarray:
    return 10.0 ** spread(low, high)


def signed(values: np.ndarray) -> np.ndarray:
    return values * np.where(np.arange(values.size) % 2, 1.0, -1.0)


def ulps(got: np.ndarray, wanted: np.ndarray) -> float:
    """Largest difference in units of the last place of the wanted value."""
    return float(np.max(np.abs(got - wanted) / np.spacing(np.abs(wanted))))


QUARTERS = np.arange(1, 6300) * (np.pi / 2)
CASES: dict[str, tuple[str, Callable[..., Any], np.ndarray, float]] = {
    "exp everywhere": ("exp", np.exp, spread(-707.9, 709.7), 1),
    "exp near zero": ("exp", np.exp, signed(decades(-12, 0)), 1),
    "expm1 everywhere": ("expm1", np.expm1, spread(-70.0, 708.9), 2.5),
    "expm1 near zero": ("expm1", np.expm1, signed(decades(-300, 0.5)), 2.5),
    "log everywhere": ("log", np.log, decades(-307, 308), 1),
    "log near one": ("log", np.log, 1.0 + signed(decades(-15, -0.5)), 1),
    "cbrt everywhere": ("cbrt", np.cbrt, decades(-307, 308), 1),
    "cbrt of ordinary numbers": ("cbrt", np.cbrt, spread(0.01, 64.0), 1),
    "sin": ("sin", np.sin, spread(-1e4, 1e4), 2.5),
    "sin of small angles": ("sin", np.sin, signed(decades(-300, 0.5)), 2.5),
    "sin at its zeros": ("sin", np.sin, QUARTERS, 2.5),
    "sin of large angles": ("sin", np.sin, spread(-1e6, 1e6), 2.5),
    "cos": ("cos", np.cos, spread(-1e4, 1e4), 2.5),
    "cos at its zeros": ("cos", np.cos, QUARTERS, 2.5),
    "asin": ("asin", np.arcsin, spread(-1.0, 1.0), 3),
    "asin near one": ("asin", np.arcsin, signed(1.0 - decades(-16, -0.1)), 3),
    "asin of small numbers": ("asin", np.arcsin, signed(decades(-300, 0)), 3),
}


@pytest.mark.parametrize("case", CASES)
def test_within_the_stated_error_of_numpy(case: str) -> None:
    name, reference, x, bound = CASES[case]
    assert ulps(PLAIN[name](x), reference(x)) <= bound + 1.0  # NumPy's own error included


def test_atan2_in_all_directions() -> None:
    y, x = signed(decades(-4, 4)), decades(-4, 4)[::-1] * np.where(np.arange(COUNT) % 3, 1.0, -1.0)
    assert ulps(PLAIN["atan2"](y, x), np.arctan2(y, x)) <= 3.0
    axes = np.array([0.0, 1.0, -1.0, 3.0, -3.0])
    y, x = (part.ravel() for part in np.meshgrid(axes, axes))
    np.testing.assert_allclose(PLAIN["atan2"](y, x), np.arctan2(y, x), rtol=5e-16)
    np.testing.assert_array_equal(PLAIN["atan2"](np.array([-0.0, 0.0]), np.array([-2.0, -2.0])), [-np.pi, np.pi])


def test_power_error_grows_with_the_exponent_only() -> None:
    x, y = decades(-3, 3), spread(-4.0, 4.0)[::-1]
    wanted = np.power(x, y)
    error = np.abs(PLAIN["power"](x, y) - wanted) / np.spacing(wanted)
    assert np.all(error <= 3.0 + 1.5 * np.abs(y * np.log(x)) + 1.0)


def test_exact_values() -> None:
    cubes = np.arange(0.0, 60.0)
    np.testing.assert_array_equal(PLAIN["cbrt"](cubes**3), cubes)
    np.testing.assert_array_equal(PLAIN["exp"](np.array([0.0, -0.0])), 1.0)
    np.testing.assert_array_equal(PLAIN["log"](np.array([1.0])), 0.0)
    np.testing.assert_array_equal(PLAIN["expm1"](np.array([0.0, -80.0])), [0.0, -1.0])
    np.testing.assert_array_equal(PLAIN["sign"](np.array([-3.0, -0.0, 0.0, 5e-324])), [-1.0, 0.0, 0.0, 1.0])
    np.testing.assert_array_equal(PLAIN["round_integer"](np.array([0.5, 1.5, -2.5, 2.6])), [0.0, 2.0, -2.0, 3.0])


def test_ends_are_sane() -> None:
    np.testing.assert_array_equal(PLAIN["exp"](np.array([-708.5, -1000.0, -1e308])), 0.0)
    assert np.all(PLAIN["exp"](np.array([709.78, 1e4, 1e308])) == PLAIN["exp"](np.array([709.78])))
    assert np.all(PLAIN["log"](np.array([0.0, -2.0, 1e-320])) == np.log(2.2250738585072014e-308))
    np.testing.assert_array_equal(PLAIN["cbrt"](np.array([0.0, -8.0, 1e-310])), 0.0)
    np.testing.assert_array_equal(PLAIN["asin"](np.array([1.5, -7.0])), [np.pi / 2, -np.pi / 2])
    assert PLAIN["power"](np.array([0.0]), np.array([1.3])) == 0.0


def test_every_finite_number_gives_a_finite_one_without_a_warning() -> None:
    wide = np.concatenate([signed(decades(-323, 308)), [0.0, -0.0, 1.7e308, -1.7e308, 5e-324]])
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        for name, function in PLAIN.items():
            if name in ("atan2", "power"):
                moderate = np.clip(wide, -1e150, 1e150)
                values = function(np.abs(moderate) if name == "power" else moderate, moderate[::-1])
            else:
                values = function(wide)
            assert np.all(np.isfinite(values)), name
        assert np.all(np.abs(PLAIN["sincos"](wide)) <= 1.0)


@pytest.mark.parametrize("name", sorted(set(PLAIN) - {"sign"}))
def test_not_a_number_stays_one(name: str) -> None:
    nan, one = np.full(2, np.nan), np.ones(2)
    with np.errstate(invalid="ignore"):
        if name in ("atan2", "power"):
            assert np.all(np.isnan(PLAIN[name](nan, one))) and np.all(np.isnan(PLAIN[name](one, nan)))
        else:
            assert np.all(np.isnan(PLAIN[name](nan)))


@given(st.floats(-20.0, 20.0), st.floats(1e-3, 1e3))
def test_identities(angle: float, radius: float) -> None:
    sine, cosine = PLAIN["sincos"](np.float64(angle))
    assert sine * sine + cosine * cosine == pytest.approx(1.0, abs=1e-15)
    assert PLAIN["sin"](np.float64(-angle)) == -sine
    back = PLAIN["atan2"](radius * sine, radius * cosine)
    assert np.cos(back - angle) == pytest.approx(1.0, abs=1e-14)
    assert PLAIN["log"](PLAIN["exp"](np.float64(angle))) == pytest.approx(angle, abs=1e-14)
    assert PLAIN["power"](np.float64(radius), np.float64(1 / 3)) == pytest.approx(PLAIN["cbrt"](np.float64(radius)))


OUTPUTS = 11


@kernel
def everything(a: Any, b: Any, out: Any) -> None:
    for i in range(a.shape[0]):
        x = load(a, i)
        y = load(b, i)
        k = OUTPUTS * i
        store(out, k, maths.exp(x))
        store(out, k + 1, maths.expm1(x))
        store(out, k + 2, maths.log(x))
        store(out, k + 3, maths.power(x, y))
        store(out, k + 4, maths.cbrt(x))
        store(out, k + 5, maths.asin(x))
        store(out, k + 6, maths.sign(x))
        store(out, k + 7, maths.round_integer(x))
        store(out, k + 8, maths.atan2(y, x))
        both = maths.sincos(y)
        store(out, k + 9, both[0])
        store(out, k + 10, both[1])


def arguments() -> tuple[np.ndarray, np.ndarray]:
    """Numbers of all sizes for all functions; the count is a multiple of all lane widths."""
    rng = np.random.default_rng(5)
    a = np.concatenate([rng.normal(size=1000) * 10.0 ** rng.uniform(-300, 150, 1000), rng.uniform(-720, 720, 1000)])
    b = np.concatenate([rng.normal(size=1000), rng.normal(size=1000) * 10.0 ** rng.uniform(-30, 4, 1000)])
    a[:8] = [0.0, -0.0, 1.0, -1.0, 5e-324, 1.7e308, -1.7e308, 0.5]
    return a, b


def digest(width: int) -> str:
    """Hash of the bits of all functions, computed by compiled lanes."""
    a, b = (part.reshape(-1, width) for part in arguments())
    out = np.zeros((OUTPUTS * a.shape[0], width))
    with np.errstate(all="ignore"):
        of_width(everything, width)(a, b, out)
    values = out.reshape(-1, OUTPUTS, width).transpose(1, 0, 2).ravel()
    values[np.isnan(values)] = np.nan
    return hashlib.sha256(values.tobytes()).hexdigest()


def test_the_same_bits_for_any_width_target_and_without_compilation() -> None:
    a, b = arguments()
    with np.errstate(all="ignore"):
        x, y = a, b
        columns = [PLAIN[name](x) for name in ("exp", "expm1", "log")]
        columns += [PLAIN["power"](x, y), *(PLAIN[name](x) for name in ("cbrt", "asin", "sign", "round_integer"))]
        columns += [PLAIN["atan2"](y, x), *PLAIN["sincos"](y)]
    values = np.concatenate(columns)
    values[np.isnan(values)] = np.nan
    wanted = hashlib.sha256(values.tobytes()).hexdigest()
    assert [digest(width) for width in WIDTHS] == [wanted] * len(WIDTHS)
    other = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    paths = os.pathsep.join((str(ROOT), str(Path(__file__).parent)))
    command = [sys.executable, "-c", "import test_maths; print(test_maths.digest(8))"]
    done = subprocess.run(
        command, env={**os.environ, **other, "PYTHONPATH": paths}, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == wanted
