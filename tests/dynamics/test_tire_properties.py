"""Footprint, vertical force, stiffnesses and relaxation lengths of a tire against figures and catalogue rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

from ssmash_gym.dynamics import tire as rolling
from ssmash_gym.dynamics import tire_properties
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import TIRE_ROWS, Tir, TireModel

properties = uncompiled(tire_properties.properties)
footprint = uncompiled(tire_properties.footprint)

PSI, INCH, POUND = 6894.757, 0.0254, 4.4482216
WIDTH_M, GAUGE, MU = 10.0 * INCH, 140 * PSI, 0.8


class Elastic(NamedTuple):
    """What `properties` returns, then the footprint."""

    F_z: np.ndarray
    k_x: np.ndarray
    k_y: np.ndarray
    k_psi: np.ndarray
    L_0: np.ndarray
    L_y: np.ndarray
    L_u: np.ndarray
    L_m: np.ndarray
    c_f: np.ndarray
    c_m: np.ndarray
    L_h: np.ndarray
    b_t: np.ndarray


def block(
    n: int = 1, *, size_in: tuple[float, float] = (26.0, 10.0), psi: float = 140.0, **changes: float
) -> np.ndarray:
    """Parameter rows of an undamped 26x10.0-11 tire without a rim."""
    d, w = size_in
    values = {"diameter": d * INCH, "width": w * INCH, "p_o": psi * PSI, "p_r": psi * PSI, "bottom": 1.0}
    values |= {"p_abs": psi * PSI + 101325.0, "ctz": 0.03, **changes}
    p = np.zeros((TIRE_ROWS, n))
    for name, value in values.items():
        p[Tir[name.upper()]] = value
    return p


def elastic(p: np.ndarray, dz: object, v_z: float = 0.0, model: int = TireModel.SMILEY_HORNE) -> Elastic:
    deflection = np.atleast_1d(np.asarray(dz, dtype=float))
    over_area = 1.0 / (p[Tir.DIAMETER] * p[Tir.WIDTH])
    with np.errstate(all="raise", under="ignore"):
        L_h, b_t = footprint(p, 0, deflection, over_area)
        return Elastic(*properties(p, 0, model, deflection, v_z + 0.0 * deflection, L_h, b_t, over_area), L_h, b_t)


def deflection_at(p: np.ndarray, load: float) -> float:
    return float(brentq(lambda dz: elastic(p, dz).F_z[0] - load, 1e-6, 0.14, xtol=1e-15))


def test_figures_of_a_26x10_tire_at_30_kN() -> None:
    p = block()
    dz = deflection_at(p, 30e3)
    e = Elastic(*(float(x[0]) for x in elastic(p, dz)))
    assert dz == pytest.approx(36.5e-3, abs=0.1e-3)
    assert e.k_y == pytest.approx(553e3, rel=2e-3)
    assert e.k_x == pytest.approx(974e3, rel=2e-3)
    assert e.k_psi == pytest.approx(17.4e3, rel=5e-3)
    assert e.k_y * e.L_0 == pytest.approx(240e3, rel=2e-3)
    assert (e.L_y, e.L_u, e.L_h) == pytest.approx((0.306, 0.379, 0.128), abs=1e-3)
    assert np.rad2deg(1.5 * MU * 30e3 / (e.k_y * e.L_0)) == pytest.approx(8.6, abs=0.05)
    assert MU * 30e3 / e.k_y == pytest.approx(43e-3, abs=0.5e-3)


# catalogue: outer diameter and width, inflation, rated load, loaded radius; largest and smallest tire of a size
@pytest.mark.parametrize(
    ("size_in", "psi", "rated_lb", "deflection_mm", "tolerance"),
    [((26.0, 10.0), 110, 9700, 66.0, 0.15), ((17.7, 6.1), 140, 2750, 21.6, 0.25), ((17.3, 6.1), 140, 2750, 19.0, 0.25)],
)
def test_rated_deflection_agrees_with_the_catalogue(
    size_in: tuple[float, float], psi: float, rated_lb: float, deflection_mm: float, tolerance: float
) -> None:
    p = block(size_in=size_in, psi=psi)
    assert deflection_at(p, rated_lb * POUND) == pytest.approx(deflection_mm * 1e-3, rel=tolerance)


def test_load_at_the_bottoming_deflection_agrees_with_the_catalogue() -> None:
    assert elastic(block(psi=110.0), (13.0 - 7.3) * INCH).F_z[0] == pytest.approx(29100 * POUND, rel=0.15)


@pytest.mark.parametrize("type_i", [0.0, 1.0])
def test_region_boundaries_are_continuous_in_value_and_slope(type_i: float) -> None:
    c = 0.03
    shapes = {
        lambda x: uncompiled(tire_properties.vertical_shape)(x, c): [10 * c / 3],
        uncompiled(tire_properties.yawed_relaxation_share): [0.053, 0.068],
        lambda x: uncompiled(tire_properties.twist_shape)(x, type_i): [0.02, 0.03],
        uncompiled(rolling.yawed_force): [1.5],
        uncompiled(rolling.yawed_moment): [0.1, 0.55],
    }
    h = 1e-7
    for shape, edges in shapes.items():
        for edge in edges:
            below, at, above = (float(shape(np.float64(edge + k * h))) for k in (-1, 0, 1))
            assert above == pytest.approx(below, abs=50 * h)
            assert (above - at) / h == pytest.approx((at - below) / h, abs=2e-4)
    moment = uncompiled(rolling.yawed_moment)
    assert moment(np.float64(2.925)) == pytest.approx(0.0, abs=1e-15)
    assert moment(np.float64(50.0)) == 0.0


def test_printed_values_inside_the_regions() -> None:
    one = np.float64
    assert uncompiled(tire_properties.vertical_shape)(one(0.05), 0.02) == pytest.approx(
        0.96 * 0.05 + 0.216 * 0.0025 / 0.02
    )
    assert uncompiled(tire_properties.vertical_shape)(one(0.3), 0.02) == pytest.approx(2.4 * 0.28)
    assert uncompiled(tire_properties.yawed_relaxation_share)(one(0.06)) == pytest.approx(0.6355)
    assert uncompiled(tire_properties.twist_shape)(one(0.01), 1.0) == pytest.approx(0.0475)
    assert uncompiled(tire_properties.twist_shape)(one(0.05), 1.0) == pytest.approx(0.76)
    assert uncompiled(tire_properties.twist_shape)(one(0.01), 0.0) == pytest.approx(0.025)
    assert uncompiled(tire_properties.twist_shape)(one(0.05), 0.0) == pytest.approx(0.525)
    assert uncompiled(tire_properties.half_length_share)(one(0.1)) == pytest.approx(0.255)
    assert uncompiled(tire_properties.footprint_width_share)(one(0.2)) == pytest.approx(
        1.7 * np.sqrt(0.2 - 0.004 + 0.000096)
    )


def test_stiffnesses_and_lengths_stay_positive_and_continuous_at_any_deflection() -> None:
    dz = np.linspace(1e-6, 0.3, 30001)
    for type_i in (0.0, 1.0):
        e = elastic(block(dz.size, type_i=type_i), dz)
        assert np.all(e.L_y >= 0.05 * WIDTH_M) and np.all(e.L_u >= 0.05 * WIDTH_M)
        for values in (e.F_z, e.k_x, e.k_y, e.k_psi, e.L_0, e.L_u, e.L_h, e.b_t):
            assert np.all(values > 0.0)
            assert np.max(np.abs(np.diff(values[200:]))) < 2e-3 * np.max(values)  # cube root and roots start steeply
        assert np.all(np.diff(e.F_z) > 0.0)


def test_lateral_stiffness_falls_with_deflection_to_a_fifth() -> None:
    for type_i, tau in ((0.0, 2.0), (1.0, 3.0)):
        p = block(p_abs=0.0, type_i=type_i)  # pressure does not rise
        undeflected = tau * WIDTH_M * 1.24 * GAUGE
        assert elastic(p, 0.0).k_y[0] == pytest.approx(undeflected)
        assert elastic(p, 0.1).k_y[0] == pytest.approx(undeflected * (1 - 0.07 / WIDTH_M))
        assert elastic(p, 0.32).k_y[0] == pytest.approx(0.2 * undeflected)


def test_vertical_force_never_pulls_and_the_rim_stiffens_it() -> None:
    p = block(cz=3000.0, bottom=0.145, bottom_k=3e6)
    assert elastic(p, 0.01, 0.1).F_z - elastic(p, 0.01, -0.1).F_z == pytest.approx(600.0)
    assert elastic(p, 0.01, -50.0).F_z == 0.0
    assert elastic(p, 0.0, 50.0).F_z == 0.0
    assert elastic(p, 0.16).F_z - elastic(block(), 0.16).F_z == pytest.approx(3e6 * 0.015)


def test_linear_tire_keeps_its_constants() -> None:
    p = block(lin_kz=8e5, lin_kx=9e5, lin_ky=5e5, lin_kpsi=1.5e4, lin_sigma=0.4, cz=3000.0)
    e = elastic(p, [0.03, 0.2], 0.1, TireModel.LINEAR)
    np.testing.assert_allclose(e.F_z, [24e3 + 300, 160e3 + 300])
    for value, expected in zip(e[1:7], (9e5, 5e5, 1.5e4, 0.4, 0.4, 0.4), strict=True):
        np.testing.assert_array_equal(value, expected)
    for value in e[7:10]:
        np.testing.assert_array_equal(value, 0.0)
    assert np.all(e.L_h == elastic(p, [0.03, 0.2]).L_h)
