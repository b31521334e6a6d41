"""The gas oleo: spring regions, staged damping, friction, end stop."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics import oleo
from ssmash_gym.dynamics.lane import WIDTH, kernel, load, store, uncompiled
from ssmash_gym.dynamics.layout import STATION_ROWS, Sta
from ssmash_gym.dynamics.oleo import bearing_load, gas_oleo, spring

plain_oleo, plain_spring, plain_load = uncompiled(gas_oleo), uncompiled(spring), uncompiled(bearing_load)

GAS = {"gas_p": 2.1e6, "gas_v": 2.4e-3, "gas_a": 5.0e-3, "gas_gamma": 1.3}
STRUT = {
    **GAS,
    "x0": 0.01, "x1": 0.22, "x2": 0.27, "k": 2.0e6, "p_ref": 101325.0,
    "e1": 1.4e5, "f1": 3.0e5, "g1": 2.0e6, "e2": 9.0e4, "f2": -1.0e5, "g2": 8.0e6,
    "c01": 150.0, "c02": 4.0e3, "c03": 2.0e4,
    "c1": 120.0, "c2": 3.0e3, "c3": 6.0e4, "c4": 500.0, "c5": 2.5e3, "c6": 2.0e4, "c7": 800.0, "c8": 2.0e3, "c9": 4.0e3,
    "rel1": 8.0e3, "rel2": 1.4e4,
    "seal": 300.0, "bearing_z": 0.5, "bearing_l0": 0.35, "bearing_mu": 0.05, "beta": 100.0,
    "stroke": 0.30, "stop_k": 2.0e7, "stop_c": 4.0e4,
}  # fmt: skip
SPRING = (*GAS, "x0", "x1", "x2", "k", "p_ref", "e1", "e2", "f1", "f2", "g1", "g2")


def block(**changes: float) -> np.ndarray:
    values = {**STRUT, **changes}
    p = np.zeros((STATION_ROWS, 1))
    for name, value in values.items():
        p[Sta[name.upper()]] = value
    c, d = oleo.region2_constants(*(values[name] for name in GAS), values["x0"], values["k"], values["p_ref"])
    p[Sta.R2_C], p[Sta.R2_D] = c, d
    return p


def force(p: np.ndarray, x: object, v: object, normal: float = 0.0) -> np.ndarray:
    return plain_oleo(p, 0, *np.broadcast_arrays(np.atleast_1d(x).astype(float), v, normal))[0]


def test_every_region_follows_its_equation() -> None:
    p = block()
    s = STRUT
    x = np.array([-0.02, 0.004, 0.1, 0.25, 0.29])

    def gas(x: float) -> float:
        ratio = s["gas_v"] / (s["gas_v"] - s["gas_a"] * x)
        return s["gas_a"] * (s["gas_p"] * ratio ** s["gas_gamma"] - s["p_ref"])

    def cubic(d: float, i: int) -> float:
        return s[f"e{i}"] * d + s[f"f{i}"] * d**2 + s[f"g{i}"] * d**3

    at_x1 = gas(s["x1"])
    c, d = p[Sta.R2_C, 0], p[Sta.R2_D, 0]
    expected = [
        s["k"] * -0.02,
        s["k"] * 0.004 + c * 0.004**2 + d * 0.004**3,
        gas(0.1),
        at_x1 + cubic(0.25 - s["x1"], 1),
        at_x1 + cubic(s["x2"] - s["x1"], 1) + cubic(0.29 - s["x2"], 2),
    ]
    np.testing.assert_allclose(plain_spring(p, 0, x), expected, rtol=1e-12)


@pytest.mark.parametrize("p_ref", [0.0, 101325.0])
def test_spring_is_c1_at_full_droop_and_at_x0(p_ref: float) -> None:
    p = block(p_ref=p_ref)
    h = 1e-6
    for x in (0.0, STRUT["x0"]):
        f = plain_spring(p, 0, x + h * np.array([-2.0, -1.0, 0.0, 1.0, 2.0]))
        left = (3 * f[2] - 4 * f[1] + f[0]) / (2 * h)
        right = (-3 * f[2] + 4 * f[3] - f[4]) / (2 * h)
        assert left == pytest.approx(right, rel=1e-4)
    assert plain_spring(p, 0, np.array([0.0]))[0] == 0.0


def test_region_two_constants_are_those_printed_without_a_reference_pressure() -> None:
    P, V, A, gamma = GAS.values()
    x0, k = 0.012, 1.7e6
    m = V - A * x0
    c = (P * V**gamma * A * (3 * m - A * gamma * x0) - 2 * k * x0 * m ** (gamma + 1)) / (m ** (gamma + 1) * x0**2)
    d = (P * V**gamma * A * (A * gamma * x0 - 2 * m) + k * x0 * m ** (gamma + 1)) / (m ** (gamma + 1) * x0**3)
    np.testing.assert_allclose(oleo.region2_constants(P, V, A, gamma, x0, k), (c, d), rtol=1e-10)


def test_relief_cubics_with_matching_slopes_make_the_spring_c1_at_x1_and_x2() -> None:
    gas = tuple(GAS.values())
    e1 = oleo.gas_law(*gas, STRUT["x1"], STRUT["p_ref"])[1]
    span = STRUT["x2"] - STRUT["x1"]
    e2 = e1 + 2 * STRUT["f1"] * span + 3 * STRUT["g1"] * span**2
    p = block(e1=e1, e2=e2)
    h = 1e-6
    for x in (STRUT["x1"], STRUT["x2"]):
        f = plain_spring(p, 0, x + h * np.array([-1.0, 0.0, 1.0]))
        assert f[1] - f[0] == pytest.approx(f[2] - f[1], rel=1e-4)


@pytest.mark.parametrize("v", [-0.8, -1e-4, 0.0, 1e-4, 0.8])
def test_force_is_continuous_in_compression(v: float) -> None:
    p = block()
    edges = np.array([0.0, STRUT["x0"], STRUT["x1"], STRUT["x2"], STRUT["stroke"]])
    step = 1e-10
    jump = force(p, edges + step, v, 5e3) - force(p, edges - step, v, 5e3)
    steepest = STRUT["stop_k"] + STRUT["stop_c"] * abs(v) / 1e-3
    assert np.all(np.abs(jump) <= 2.5 * step * steepest + 1e-9)
    x = np.linspace(-0.02, 0.31, 200_001)
    assert np.max(np.abs(np.diff(force(p, x, v)))) < 1.1 * steepest * (x[1] - x[0])


def test_force_is_continuous_in_rate_with_constant_terms_in_the_damping() -> None:
    p = block()
    v = np.linspace(-1e-3, 1e-3, 20_001)
    f = force(p, 0.1, v, 5e3)
    rest = 300.0 + 0.05 * 5e3 + 150.0
    assert np.max(np.abs(np.diff(f))) < 1.1 * (rest * 100.0 + 4e3) * (v[1] - v[0])


def trigger_sequence(polynomials: list[np.ndarray], relief: list[float], v: np.ndarray) -> np.ndarray:
    """Damping of (2.213) followed as the valves would: hold at a trigger until the next curve comes up to it."""
    stage, held, forces = 0, False, []
    for speed in v:
        if held and np.polyval(polynomials[stage + 1], speed) >= relief[stage]:
            stage, held = stage + 1, False
        if not held and stage < 2 and np.polyval(polynomials[stage], speed) >= relief[stage]:
            held = True
        forces.append(relief[stage] if held else np.polyval(polynomials[stage], speed))
    return np.array(forces)


def test_damping_in_closed_form_is_the_staircase_of_the_relief_valves() -> None:
    p = block(seal=0.0, beta=1e12)  # no friction, no smoothing: the bare polynomials
    s = STRUT
    v = np.linspace(1e-6, 3.0, 3001)
    curves = [np.array([s[f"c{i + 2}"], s[f"c{i + 1}"], s[f"c{i}"]]) for i in (1, 4, 7)]
    followed = trigger_sequence(curves, [s["rel1"], s["rel2"]], v)
    f = force(p, 0.0, v)
    np.testing.assert_allclose(f, followed, rtol=1e-12)
    assert np.sum(np.isclose(f, s["rel1"], rtol=1e-12)) > 10  # both plateaus are there
    assert np.sum(np.isclose(f, s["rel2"], rtol=1e-12)) > 10
    assert f[-1] > s["rel2"]


def test_rebound_damping_follows_its_polynomial() -> None:
    p = block(seal=0.0)
    v = np.array([-0.3, -2.0])
    w = -v
    expected = -(150.0 * (1 - np.exp(-100.0 * w)) + 4e3 * w + 2e4 * w * w)
    np.testing.assert_allclose(force(p, 0.0, v), expected, rtol=1e-12)


def test_friction_is_smoothed_and_grows_with_the_bearing_load() -> None:
    quiet = {f"c{i}": 0.0 for i in ("01", "02", "03", 1, 2, 3, 4, 5, 6, 7, 8, 9)}
    p = block(**quiet)
    v = np.array([-0.5, -1e-3, 0.0, 2e-3, 0.5])
    normal = plain_load(p, 0, np.array([0.05]), np.array([4e3]))[0]
    assert normal == pytest.approx(4e3 / 0.40, rel=1e-14)
    expected = np.sign(v) * (300.0 + 0.05 * normal) * (1 - np.exp(-100.0 * np.abs(v)))
    np.testing.assert_allclose(force(p, 0.0, v, normal), expected, rtol=1e-10)


def test_slope_at_rest_is_the_limit() -> None:
    F, slope = plain_oleo(block(), 0, np.array([0.1]), np.array([0.0]), np.array([5e3]))
    assert F[0] == plain_spring(block(), 0, np.array([0.1]))[0]
    assert slope[0] == pytest.approx(100.0 * (300.0 + 0.05 * 5e3 + 120.0) + 3e3, rel=1e-6)


finite = {"allow_nan": False, "allow_infinity": False}


@settings(max_examples=150, deadline=None)
@given(
    x=st.floats(-0.3, 0.6, **finite),
    v=st.floats(-20.0, 20.0, **finite) | st.floats(-1e-6, 1e-6, **finite),
    normal=st.floats(0.0, 1e6),
    coefficient=st.floats(-1e4, 1e4, **finite),
)
def test_dissipation_is_slope_times_rate_and_never_drives(
    x: float, v: float, normal: float, coefficient: float
) -> None:
    p = block(c3=coefficient, c03=-coefficient, c4=coefficient)
    arguments = np.array([x]), np.array([v]), np.array([normal])
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        F, slope = plain_oleo(p, 0, *arguments)
        still = plain_oleo(p, 0, arguments[0], np.zeros(1), arguments[2])[0]
    assert np.isfinite(F[0]) and np.isfinite(slope[0]) and slope[0] >= 0.0
    assert (F[0] - still[0]) * v >= -1e-9 * abs(still[0] * v)
    assert F[0] - still[0] == pytest.approx(slope[0] * v, rel=1e-9, abs=1e-9 * abs(still[0]) + 1e-9)


def test_end_stop_pushes_only_and_stops() -> None:
    p = block()
    x = np.linspace(0.29, 0.32, 3001)
    for v in (-30.0, -0.5, 0.0, 0.5):
        stopped, free = force(p, x, v), force(block(stop_k=0.0, stop_c=0.0), x, v)
        assert np.all(stopped - free >= -1e-6)
        assert np.all((stopped == free)[x <= STRUT["stroke"]])
    assert force(p, 0.32, 0.0)[0] - force(block(stop_k=0.0), 0.32, 0.0)[0] == pytest.approx(0.02 * 2e7, rel=1e-6)


def test_a_cycle_of_compression_dissipates_what_the_slope_says() -> None:
    p = block()
    t = np.linspace(0.0, 1.0, 20_001)
    x, v = 0.15 + 0.145 * np.sin(2 * np.pi * t), 0.145 * 2 * np.pi * np.cos(2 * np.pi * t)
    F, slope = plain_oleo(p, 0, x, v, np.full_like(x, 2e3))
    work = np.trapezoid(F * v, t)
    assert work > 0.0
    assert work == pytest.approx(np.trapezoid(slope * v * v, t), rel=1e-6)


def test_spring_curve_is_the_kernel_and_shows_a_falling_region_two() -> None:
    x = np.linspace(-0.01, 0.3, 4001).reshape(1, -1)
    curve = oleo.spring_curve({name: STRUT[name] for name in SPRING}, x)
    assert curve.shape == x.shape
    np.testing.assert_array_equal(curve[0], plain_spring(block(), 0, x[0]))
    assert np.all(np.diff(curve) > 0.0)
    small = np.linspace(0.0, STRUT["x0"], 1001)
    within = 3 * oleo.gas_law(*GAS.values(), STRUT["x0"], STRUT["p_ref"])[0] / STRUT["x0"]
    assert np.all(np.diff(oleo.spring_curve({**STRUT, "k": within}, small)) > 0.0)
    assert np.any(np.diff(oleo.spring_curve({**STRUT, "k": 3 * within}, small)) < 0.0)


def test_faulty_sets_are_refused_in_a_sentence() -> None:
    with pytest.raises(ValueError, match="x0 = 0 m must be greater than 0"):
        oleo.region2_constants(*GAS.values(), 0.0, 1e6)
    with pytest.raises(ValueError, match=r"must be less than gas_v / gas_a = 0.48 m"):
        oleo.gas_law(*GAS.values(), 0.5)
    with pytest.raises(ValueError, match="needs gas_a"):
        oleo.spring_curve({name: value for name, value in STRUT.items() if name != "gas_a"}, np.zeros(1))


@kernel
def oleo_driver(p, y, out):
    normal = bearing_load(p, 0, load(y, 0), load(y, 2))
    F, slope = gas_oleo(p, 0, load(y, 0), load(y, 1), normal)
    store(out, 0, F)
    store(out, 1, slope)


def test_lanes_give_the_bits_of_numpy() -> None:
    rng = np.random.default_rng(5)
    p = np.ascontiguousarray(np.broadcast_to(block(), (STATION_ROWS, WIDTH)))
    for _ in range(300):
        y = np.array([rng.uniform(-0.1, 0.4, WIDTH), rng.normal(size=WIDTH), rng.uniform(0, 1e5, WIDTH)])
        y[1] *= 10.0 ** rng.uniform(-12, 1, WIDTH)
        lanes, plain = np.zeros((2, WIDTH)), np.zeros((2, WIDTH))
        oleo_driver(p, y, lanes)
        uncompiled(oleo_driver)(p, y, plain)
        assert lanes.tobytes() == plain.tobytes()
