"""One tire: rolling, standing and sliding, friction limit, wrench."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ssmash_gym.dynamics import tire_properties
from ssmash_gym.dynamics.lane import WIDTH, uncompiled
from ssmash_gym.dynamics.layout import TIRE_ROWS, Contact, Friction, Tir, TireModel
from tests.dynamics.tire_rig import many

MAIN = {
    "diameter": 0.6604, "width": 0.254, "axle_radius": 0.03, "p_o": 9.65e5, "p_r": 9.65e5, "p_abs": 1.066e6,
    "mu": 0.8, "mu_rr": 0.01, "mu_axle": 0.05, "ctz": 0.03, "cx": 2000.0, "cy": 2500.0, "cz": 3000.0,
    "beta": 10.0, "sigma_min": 0.02, "bottom": 0.145, "bottom_k": 3e6, "pull": 100.0, "my_coeff": 0.25,
    "lin_kz": 8e5, "lin_kx": 9e5, "lin_ky": 5e5, "lin_kpsi": 1.5e4, "lin_sigma": 0.4,
}  # fmt: skip
LOAD = 30e3  # vertical force of most tests [N]
GRIP = MAIN["mu"] * LOAD


plain = uncompiled(many)


def block(n: int = 1, **changes: float) -> np.ndarray:
    p = np.zeros((TIRE_ROWS, n))
    for name, value in {**MAIN, **changes}.items():
        p[Tir[name.upper()]] = value
    return p


def axle(roll: Any = 0.0, yaw: Any = 0.0) -> tuple[Any, Any, Any]:
    return (-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll))


def evaluate(
    p: np.ndarray,
    dz: Any,
    v: Any = (0.0, 0.0, 0.0),
    state: Any = (0.0, 0.0, 0.0),
    *,
    w: Any = (0.0, 0.0, 0.0),
    wy: Any = (0.0, 1.0, 0.0),
    r: Any = (0.0, 0.0, 0.0),
    lock: Any = 0.0,
    model: int = TireModel.SMILEY_HORNE,
    friction: int = Friction.LIMIT_SURFACE,
    contact: int = Contact.CONTACT,
) -> SimpleNamespace:
    """Results of ``n`` tires, arrays (n,) and (3, n): one compiled, more of them in NumPy."""
    n = p.shape[1]
    inputs = np.array([np.broadcast_to(x, n) for x in (*r, 0.5 * p[Tir.DIAMETER] - dz, *v, *w, *wy, *state, lock)])
    how = (int(model), int(friction), int(contact))
    if n == 1:
        wide = np.empty((17, WIDTH))
        many(np.repeat(p, WIDTH, axis=1), np.repeat(inputs, WIDTH, axis=1), wide, *how)
        out = wide[:, :1]
    else:
        out = np.empty((17, n))
        with np.errstate(divide="raise", invalid="raise", over="raise"):
            plain(p, inputs, out, *how)
    names = ("F_z", "F_y", "F_x", "dz", "d_y", "d_x", "psi", "use")
    reads = dict(zip(names, out[9:], strict=True))
    return SimpleNamespace(force=out[:3], moment=out[3:6], rates=out[6:9], all=out, **reads)


def stiffness(p: np.ndarray, dz: float) -> dict[str, float]:
    over_area = 1.0 / (p[Tir.DIAMETER] * p[Tir.WIDTH])
    deflection = np.array([dz])
    L_h, b_t = uncompiled(tire_properties.footprint)(p, 0, deflection, over_area)
    names = ("F_z", "k_x", "k_y", "k_psi", "L_0", "L_y", "L_u")
    known = uncompiled(tire_properties.properties)(p, 0, TireModel.SMILEY_HORNE, deflection, 0.0, L_h, b_t, over_area)
    return {"L_h": L_h[0], "b_t": b_t[0]} | {name: float(x[0]) for name, x in zip(names, known[:7], strict=True)}


P = block()
DZ = float(brentq(lambda dz: evaluate(P, dz).F_z[0] - LOAD, 1e-3, 0.1, xtol=1e-15))
K = stiffness(P, DZ)
HEIGHT = MAIN["diameter"] / 2 - DZ


def roll_on(
    p: np.ndarray, v: Any, state: Any = (0.0, 0.0, 0.0), time: float = 30.0, dz: Any = None, **how: Any
) -> np.ndarray:
    """State after ``time`` at constant velocity."""

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return evaluate(p, DZ if dz is None else dz, v, y, **how).rates[:, 0]

    return solve_ivp(rates, (0.0, time), state, method="LSODA", rtol=1e-9, atol=1e-12).y[:, -1]


def steady(phi: float) -> tuple[float, float]:
    """(2.137) over mu F_z and (2.142) over mu F_z L_h, written out again; phi >= 0."""
    force = phi - 4 * phi**3 / 27 if phi <= 1.5 else 1.0
    if phi <= 0.1:
        return force, 0.8 * phi
    return force, phi - phi**2 - 0.01 if phi <= 0.55 else max(0.2925 - 0.1 * phi, 0.0)


# --- rolling ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phi", [0.02, 0.4, 1.0, 1.49, 1.6, 2.5, 4.0])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_steady_yawed_rolling_without_friction_limit_is_the_steady_law(phi: float, direction: float) -> None:
    p = block(pull=0.0)
    angle = phi * GRIP / (K["k_y"] * K["L_0"])
    force, moment = steady(phi)
    d_x, d_y, psi = roll_on(p, (direction, np.tan(angle), 0.0))
    assert d_x == 0.0
    assert d_y == pytest.approx(-force * GRIP / K["k_y"], rel=2e-5)
    assert psi == pytest.approx(direction * moment * GRIP * K["L_h"] / K["k_psi"], rel=5e-5)


@pytest.mark.parametrize("phi", [0.4, 1.2, 1.5, 2.0, 2.9])
def test_limit_surface_costs_at_most_three_and_a_half_percent_of_the_steady_side_force(phi: float) -> None:
    angle = phi * GRIP / (K["k_y"] * K["L_0"])
    v = (0.3, 0.3 * np.tan(angle), 0.0)
    share = evaluate(P, DZ, v, roll_on(P, v)).F_y[0] / GRIP
    assert -steady(phi)[0] - 1e-4 <= share <= -0.965 * steady(phi)[0]


def test_rolling_relaxes_with_distance_not_with_time() -> None:
    p = block(pull=0.0)
    start = (0.0, 0.01, 0.0)
    slow, fast = roll_on(p, (0.05, 0.0, 0.0), start, 8.0), roll_on(p, (4.0, 0.0, 0.0), start, 0.1)
    assert slow[1] == pytest.approx(fast[1], rel=1e-7)
    assert slow[1] == pytest.approx(0.01 * np.exp(-0.4 / K["L_0"]), rel=1e-7)  # sigma(0) = L_y + L_h
    start = (0.0, 0.0, 0.01)
    assert roll_on(p, (1.0, 0.0, 0.0), start, 0.4)[2] == pytest.approx(0.01 * np.exp(-0.4 / K["L_u"]), rel=1e-7)


def test_answer_does_not_depend_on_how_the_run_is_cut() -> None:
    v = (0.3, 0.02, 0.0)
    whole = roll_on(P, v, time=2.0)
    cut = (0.0, 0.0, 0.0)
    for _ in range(8):
        cut = roll_on(P, v, cut, 0.25)
    assert cut == pytest.approx(whole, rel=1e-7, abs=1e-12)


def test_relaxation_shortens_under_saturation_down_to_its_floor() -> None:
    def rate(tangent: float, **changes: float) -> float:
        p = block(pull=0.0, **changes)
        return -(evaluate(p, DZ, (1, tangent, 0), (0, 0.01, 0)).rates[1, 0] + tangent) / 0.01

    slide = GRIP / K["k_y"]
    assert 1 / rate(0.0) == pytest.approx(K["L_0"])
    assert 1 / rate(0.5) == pytest.approx(slide / 0.5, rel=1e-4)
    assert 1 / rate(8.0) == pytest.approx(0.02, rel=1e-4)
    assert 1 / rate(8.0, sigma_min=1e-4) == pytest.approx(slide / 8.0, rel=1e-4)


def test_rolling_resistance_opposes_motion_and_vanishes_at_rest() -> None:
    for speed in (-1.0, -1e-3, 0.0, 1e-3, 1.0):
        a = evaluate(P, DZ, (speed, 0, 0), (0, 0.01, 0))
        full = 0.01 * LOAD + 2 * 0.05 * 0.03 / MAIN["width"] * abs(a.F_y[0])  # (2.155), (2.156)
        assert a.F_x[0] == pytest.approx(full * np.sign(speed) * np.expm1(-10.0 * abs(speed)), rel=1e-12)


def test_camber_force_standing_rolling_and_between() -> None:
    inclination = np.deg2rad(2.0)
    wy = axle(inclination)
    assert evaluate(P, DZ, wy=wy).F_y == pytest.approx(0.57 * LOAD * inclination, rel=1e-6)
    for speed in (0.01, 0.1, 1.0):
        state = roll_on(block(pull=0.0), (speed, 0, 0), time=20.0 / speed, wy=wy)
        a = evaluate(P, DZ, (speed, 0, 0), state, wy=wy)
        assert a.F_y == pytest.approx(1.0 * LOAD * inclination, rel=1e-6)
        moment = 0.01 * K["b_t"] ** 2 * K["k_x"] * inclination  # (2.143)
        assert state[2] == pytest.approx(moment / K["k_psi"], rel=1e-6)
    assert evaluate(P, DZ, (1.0, 0, 0), wy=wy, lock=1.0).F_y == pytest.approx(0.57 * LOAD * inclination, rel=1e-6)


@pytest.mark.parametrize(("contact", "force"), [(Contact.CONTACT, 597.0), (Contact.CENTRE, -5.6e3 + 597.0)])
def test_two_degrees_of_roll_about_standing_tires_is_camber_not_a_side_step(contact: int, force: float) -> None:
    rate = np.deg2rad(2.0)
    v = (0.0, rate * HEIGHT, 0.0)  # the wheel rolls over about its contact point: the centre moves to starboard
    state = roll_on(P, v, time=1.0, w=(rate, 0.0, 0.0), wy=axle(rate / 2), contact=contact)
    assert evaluate(P, DZ, state=state, wy=axle(rate), contact=contact).F_y == pytest.approx(force, rel=0.02)


# --- standing and locked wheels ----------------------------------------------------------------------------------


def test_standing_tire_is_a_spring() -> None:
    a = evaluate(P, DZ, state=(0.0, 0.01, 0.02))
    assert a.F_y == pytest.approx(K["k_y"] * 0.01)
    assert a.moment[2] == pytest.approx(K["k_psi"] * 0.02)
    assert a.F_x == 0.0
    np.testing.assert_array_equal(a.rates, 0.0)
    a = evaluate(P, DZ, (0.0, 0.003, 0.0), (0.0, 0.01, 0.02), w=(0.0, 0.0, 0.004))
    assert a.rates[:, 0] == pytest.approx((0.0, -0.003, -0.004))
    assert a.F_y == pytest.approx(K["k_y"] * 0.01 - MAIN["cy"] * 0.003)


def test_locked_wheel_holds_and_a_free_wheel_rolls() -> None:
    v, state = (0.002, 0.0, 0.0), (-0.005, 0.004, 0.01)
    locked = evaluate(P, DZ, v, state, lock=1.0)
    assert locked.rates[:, 0] == pytest.approx((-0.002, 0.0, 0.0), abs=1e-15)  # no rolling, no relaxation
    assert locked.F_x == pytest.approx(-K["k_x"] * 0.005 - MAIN["cx"] * 0.002)
    assert locked.moment[1] != 0.0
    free = evaluate(P, DZ, v, state)
    assert free.rates[0] == pytest.approx(100.0 * 0.005)  # the stored deflection of the lock is let go
    assert -0.011 * LOAD < free.F_x < 0.0
    assert free.rates[1] < 0.0 and free.d_x == 0.0


def test_sliding_locked_wheel_is_held_back_by_the_whole_grip_at_any_direction() -> None:
    for heading in np.deg2rad([0.0, 37.0, 90.0, 200.0]):
        v = 0.4 * np.array([np.cos(heading), np.sin(heading), 0.0])
        a = evaluate(P, DZ, v, roll_on(P, v, time=5.0, lock=1.0), lock=1.0)
        assert a.use == pytest.approx(1.0)
        assert a.force[:2, 0] @ v[:2] < 0.0
        assert np.hypot(a.F_x, a.F_y) == pytest.approx(GRIP, rel=1e-6)


@pytest.mark.parametrize("friction", list(Friction))
def test_closed_skid_takes_energy(friction: int) -> None:
    """Over closed paths of random shape and speed, locked wheels in the first half of the columns."""
    n, step, laps = 40, 0.008, 2
    rng = np.random.default_rng(4)
    p = np.repeat(P, n, axis=1)
    lock = np.repeat([1.0, 0.0], n // 2)
    size = rng.uniform(0.05, 0.6, (3, 3, n)) * np.array([1.0, 1.0, 0.6])[:, None, None]
    phase = rng.uniform(0, 2 * np.pi, (3, 3, n))

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        v_x, v_y, r_z = (size * np.cos(2 * np.pi * np.arange(1, 4)[:, None] * t + phase)).sum(axis=1)
        a = evaluate(p, DZ, (v_x, v_y, 0.0), y[:3], w=(0.0, 0.0, r_z), lock=lock, friction=friction)
        return np.array([*a.rates, a.force[0] * v_x + a.force[1] * v_y + a.moment[2] * r_z])

    y = np.zeros((4, n))
    for i in range(round(laps / step)):
        if i == round((laps - 1) / step):
            first = y[3]
        middle = y + 0.5 * step * rates(i * step, y)
        y = y + step * rates((i + 0.5) * step, middle)
    assert np.all(y[3] < -100.0)
    assert np.all(y[3] - first < -100.0)
    assert np.max(np.abs(y[:2])) < 0.15


def test_slide_is_no_trouble_for_a_multistep_integrator() -> None:
    def rates(t: float, y: np.ndarray) -> np.ndarray:
        v = (0.3 * np.sin(3 * t), 0.5 * np.cos(5 * t), 0.0)
        return evaluate(P, DZ, v, y, w=(0, 0, np.sin(t)), lock=1.0).rates[:, 0]

    stiff = solve_ivp(rates, (0, 1), (0, 0, 0), method="LSODA", rtol=1e-5, atol=1e-8)
    plain = solve_ivp(rates, (0, 1), (0, 0, 0), method="DOP853", rtol=1e-6, atol=1e-9)
    assert stiff.nfev < 1000
    assert stiff.y[:, -1] == pytest.approx(plain.y[:, -1], rel=1e-3, abs=1e-6)


# --- friction limit ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("friction", list(Friction))
def test_forces_stay_within_the_limit_damping_included(friction: int) -> None:
    n = 3000
    rng = np.random.default_rng(friction)
    state = rng.uniform(-1, 1, (3, n)) * np.array([0.06, 0.1, 0.3])[:, None]
    given_: dict[str, Any] = {"v": (*rng.uniform(-2, 2, (2, n)), 0.0), "wy": axle(rng.uniform(-0.3, 0.3, n))}
    given_ |= {"state": state, "lock": rng.integers(0, 2, n).astype(float), "friction": friction}
    bare = evaluate(block(n, cx=0.0, cy=0.0, mu_rr=0.0, mu_axle=0.0), DZ, **given_)
    x, y = bare.F_x / GRIP, bare.F_y / GRIP
    z = K["k_psi"] * bare.psi / (2 / 3 * GRIP * (K["L_h"] + K["b_t"] / 2) / 2)
    used = [np.sqrt(x * x + y * y + z * z), np.maximum(np.hypot(x, y), np.abs(z)), np.maximum(np.abs(x), np.abs(y))]
    np.testing.assert_allclose(used[friction], bare.use, rtol=1e-9)
    assert 0.3 < np.mean(bare.use == 1.0) < 0.97
    damped = evaluate(block(n, mu_rr=0.0, mu_axle=0.0), DZ, **given_)
    most = MAIN["cy"] * np.abs(evaluate(block(n, pull=0.0), DZ, **given_).rates[1])
    assert np.all(np.abs(damped.F_y - bare.F_y) <= most + 1e-9)
    x, y = damped.F_x / GRIP, damped.F_y / GRIP
    used = [np.sqrt(x * x + y * y + z * z), np.maximum(np.hypot(x, y), np.abs(z)), np.maximum(np.abs(x), np.abs(y))]
    np.testing.assert_allclose(used[friction], damped.use, rtol=1e-9)  # at most 1
    assert np.any(damped.use > bare.use + 0.01) and np.any(damped.use < bare.use - 0.01)  # it helps or hinders
    if friction == Friction.LIMIT_SURFACE:
        np.testing.assert_array_equal(damped.F_y[bare.use == 1.0], bare.F_y[bare.use == 1.0])


@pytest.mark.parametrize("friction", list(Friction))
def test_no_damping_however_large_carries_the_force_past_the_limit(friction: int) -> None:
    """A locked tire jerked sideways: the force grows with the speed up to the limit, steadily, and stays there."""
    p = block(cy=1e6, mu_rr=0.0, mu_axle=0.0)
    share = K["k_y"] * 0.01 / GRIP
    force, use = [], []
    for speed in np.linspace(0.0, 0.1, 201):
        a = evaluate(p, DZ, (0.0, -speed, 0.0), (0.0, 0.01, 0.0), lock=1.0, friction=friction)
        force.append(a.F_y[0] / GRIP)
        use.append(a.use[0])
    assert force[0] == pytest.approx(share) and force[-1] == pytest.approx(1.0)
    assert np.all(np.diff(force) >= -1e-12) and np.max(np.diff(force)) < 1.01 * 1e6 * 0.0005 / GRIP
    np.testing.assert_allclose(use, force, rtol=1e-12)


def test_twist_takes_side_force_in_the_limit_surface_only() -> None:
    state = (0.0, 0.03, 0.2)
    force = {f: evaluate(P, DZ, state=state, friction=f).F_y[0] for f in Friction}
    assert force[Friction.LIMIT_SURFACE] < 0.8 * force[Friction.FRICTION_CIRCLE]
    assert force[Friction.FRICTION_CIRCLE] == pytest.approx(K["k_y"] * 0.03)
    both = (-0.03, 0.03, 0.0)
    circle = evaluate(P, DZ, state=both, lock=1.0, friction=Friction.FRICTION_CIRCLE)
    apart = evaluate(P, DZ, state=both, lock=1.0, friction=Friction.INDEPENDENT)
    assert np.hypot(circle.F_x, circle.F_y) == pytest.approx(GRIP)
    assert apart.F_x == pytest.approx(-GRIP) and apart.F_y == pytest.approx(K["k_y"] * 0.03)
    assert evaluate(P, DZ, state=(0, 0, 0.5), friction=Friction.INDEPENDENT).moment[2] == pytest.approx(
        0.5 * K["k_psi"]
    )


def test_stored_deflections_return_to_the_surface() -> None:
    state = roll_on(P, (0, 0, 0), (-0.2, 0.2, 0.4), 1.0, lock=1.0)
    a = evaluate(P, DZ, state=state, lock=1.0)
    assert a.use == pytest.approx(1.0, rel=1e-6)
    assert state == pytest.approx((a.d_x[0], a.d_y[0], a.psi[0]), rel=1e-6)
    cambered = evaluate(P, DZ, state=(0, 0.3, 0), wy=axle(0.05))
    assert K["k_y"] * cambered.d_y + 0.57 * LOAD * 0.05 == pytest.approx(GRIP, rel=1e-4)


def test_unloaded_tire_has_no_force_and_forgets() -> None:
    for dz in (-1.0, -1e-9, 0.0):
        a = evaluate(P, dz, (2.0, -1.0, 0.5), (0.02, -0.03, 0.1), w=(0.3, 0.2, 1.0), lock=0.5, r=(0.1, 0.2, 0.3))
        assert not np.any(a.force) and not np.any(a.moment) and a.use == 0.0
        assert not np.any([a.d_x, a.d_y, a.psi, a.dz])
        assert a.rates[:, 0] == pytest.approx(-100.0 * np.array([0.02, -0.03, 0.1]))
    rebound = evaluate(P, 0.01, (2.0, -1.0, -50.0), (0.02, -0.03, 0.1))  # leaves faster than its damping lets it
    assert not np.any(rebound.force) and not np.any(rebound.moment)


def test_nothing_jumps_or_runs_away_where_the_load_vanishes() -> None:
    dz = np.array([1e-12, 1e-9, 1e-7, 3e-5])
    p = block(4, cz=0.0)
    locked = evaluate(p, dz, (0.5, 0.4, 0.0), (0.01, 0.02, 0.3), wy=axle(0.1), lock=1.0)
    assert np.all(np.hypot(locked.F_x, locked.F_y) <= 0.8 * locked.F_z + 2500 * 0.7 * locked.F_z / 10)
    rolling = evaluate(p, dz, (0.5, 0.2, 0.0), wy=axle(0.6))
    assert np.all(
        np.abs(rolling.rates[2]) <= 0.2 * 0.5 / (0.05 * MAIN["width"])
    )  # (2.143), (2.144) alone: 3.7 times that


# --- linear tire ----------------------------------------------------------------------------------------------


def test_linear_tire_is_linear_until_it_slides() -> None:
    how: dict[str, Any] = {"model": TireModel.LINEAR}
    dz = LOAD / MAIN["lin_kz"]
    a = evaluate(P, dz, (0, 0, 0.1), (0.01, 0.01, 0.01), wy=axle(0.1), lock=1.0, **how)
    assert a.F_z == pytest.approx(LOAD + 300.0)
    assert (a.F_x[0], a.F_y[0], 1.5e4 * a.psi[0]) == pytest.approx((9e3, 5e3, 150.0))
    for phi in (0.5, 1.3, 2.0):
        v = (1.0, np.tan(phi * GRIP / (5e5 * 0.4)), 0.0)
        _, d_y, psi = roll_on(block(pull=0.0), v, (0.0, 0.0, 0.01), 20.0, dz=dz, **how)
        assert d_y == pytest.approx(-steady(phi)[0] * GRIP / 5e5, rel=2e-5)
        assert psi == pytest.approx(0.0, abs=1e-9)


# --- wrench and pull-back -------------------------------------------------------------------------------------


def test_force_acts_at_the_deck_under_the_tire() -> None:
    r = (0.2, -0.1, 0.05)
    state = (-0.004, 0.01, 0.02)
    a = evaluate(P, DZ, state=state, r=r, lock=1.0)
    contact = (r[0], r[1], r[2] + HEIGHT)
    own = (-0.8 * a.d_y[0] * LOAD, 0.25 * a.d_x[0] * LOAD, K["k_psi"] * a.psi[0])  # (2.158), (2.159), (2.151)
    np.testing.assert_allclose(a.force[:, 0], (a.F_x[0], a.F_y[0], -LOAD))
    np.testing.assert_allclose(a.moment[:, 0], own + np.cross(contact, a.force[:, 0]))


def test_turning_about_the_contact_point_does_not_drag_it() -> None:
    w = np.array([0.3, -0.2, 0.0])
    v_centre = np.cross(w, (0.0, 0.0, -HEIGHT))
    a = evaluate(P, DZ, v_centre, w=w, lock=1.0)
    np.testing.assert_allclose(a.rates[:, 0], 0.0, atol=1e-15)
    assert evaluate(P, DZ, v_centre, w=w, lock=1.0, contact=Contact.CENTRE).rates[1] == pytest.approx(-v_centre[1])


@settings(max_examples=50, deadline=None)
@given(
    v=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    state=st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5)),
    dz=st.floats(0.001, 0.14),
    friction=st.sampled_from(list(Friction)),
)
def test_stored_deflections_beyond_the_limit_are_pulled_in(v: Any, state: Any, dz: float, friction: int) -> None:
    a = evaluate(P, dz, v, state, lock=1.0, friction=friction)
    free = evaluate(block(pull=0.0), dz, v, state, lock=1.0, friction=friction)
    pulled = (a.rates - free.rates)[:, 0]
    over = np.array(state) - (a.d_x[0], a.d_y[0], a.psi[0])
    np.testing.assert_allclose(pulled, -100.0 * over, rtol=1e-9, atol=1e-9)
    assert np.all(over * state >= -1e-15)
