"""The law of the roll damping and its stochastic linearisation, against a simulated quadratically damped roll."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.roll_damping import GAUSSIAN, RollDamping, critical_damping, linearised

LAW = RollDamping(z0=0.02, z_speed=0.4, z_rate=0.1)


def test_law_adds_its_three_parts() -> None:
    assert LAW.ratio(0.0, 0.0, 3.5) == 0.02
    assert LAW.ratio(0.25, 0.0, 3.5) == pytest.approx(0.12)
    assert LAW.ratio(0.25, 0.03, 3.5) == pytest.approx(0.12 + 0.1 * math.sqrt(8.0 / math.pi) * 0.03 * 3.5)


def test_froude_scaled_ship_has_the_same_ratio() -> None:
    scale = 1.7  # lengths; times grow with its square root, so rates fall with it
    root = math.sqrt(scale)
    assert LAW.ratio(0.2, 0.03 / root, 3.5 * root) == pytest.approx(LAW.ratio(0.2, 0.03, 3.5), rel=1e-14)


def test_gaussian_factor_preserves_the_dissipated_power() -> None:
    rate = 0.04 * np.random.default_rng(3).standard_normal(2_000_000)
    quadratic = np.mean(np.abs(rate) * rate**2)
    assert GAUSSIAN * np.std(rate) * np.mean(rate**2) == pytest.approx(quadratic, rel=3e-3)


def test_critical_damping_is_the_border_of_oscillation() -> None:
    stiffness, inertia = 5.6e7, 1.7e8
    b = critical_damping(stiffness, inertia)
    slightly_less = np.roots([inertia, 0.999 * b, stiffness])
    slightly_more = np.roots([inertia, 1.001 * b, stiffness])
    assert np.abs(slightly_less.imag).min() > 0.0
    assert np.abs(slightly_more.imag).max() == 0.0


def test_unstable_ship_has_no_critical_damping() -> None:
    with pytest.raises(ConfigurationError, match=r"roll stiffness is -1 N m"):
        critical_damping(-1.0, 1.0)


@pytest.mark.parametrize("z0", [0.0, 0.02, 0.2])
def test_iteration_finds_the_ratio_that_agrees_with_its_own_rolling(z0: float) -> None:
    law = RollDamping(z0=z0, z_speed=0.0, z_rate=0.2)

    def sigma(ratio: float) -> float:
        return 0.01 / math.sqrt(ratio + 1e-3)  # white-noise rolling of a lightly damped ship

    ratio, converged = linearised(lambda rate: law.ratio(0.0, rate, 3.5), sigma)
    assert converged
    assert ratio == pytest.approx(law.ratio(0.0, sigma(ratio), 3.5), rel=1e-9)


def test_iteration_says_when_it_has_not_closed_in() -> None:
    ratio, converged = linearised(lambda rate: 1.0 + rate, lambda ratio: ratio)  # grows by one each time
    assert not converged
    assert math.isfinite(ratio)


def test_linearised_ratio_is_that_of_the_nonlinear_rolling() -> None:
    """Time-step roll with linear and quadratic damping in irregular excitation; compare the RMS with linear theory."""
    omega_n, linear, quadratic, n, dt, steps = 0.57, 0.03, 0.45, 120, 0.1, 60_000
    rng = np.random.default_rng(11)
    omega = np.sort(rng.uniform(0.3, 1.0, n))
    force, phase = np.full(n, 1.2e-3), rng.uniform(0.0, 2.0 * np.pi, n)
    time = dt * np.arange(2 * steps + 1) / 2.0
    moment = np.zeros_like(time)
    for w, f, p in zip(omega, force, phase, strict=True):
        moment += f * np.cos(w * time + p)

    def sigma(ratio: float) -> float:
        rate = omega * force / np.abs(omega_n**2 - omega**2 + 2j * ratio * omega_n * omega)
        return float(np.sqrt(0.5 * np.sum(rate**2)))

    # quadratic damping q |v| v stands for a ratio q sqrt(8/pi) sigma / (2 omega_n)
    law = RollDamping(z0=linear, z_speed=0.0, z_rate=quadratic / (2.0 * omega_n))
    ratio, converged = linearised(lambda rate: law.ratio(0.0, rate, 1.0), sigma)
    assert converged and ratio > 1.3 * linear  # the quadratic part matters here

    x, v, squares = 0.0, 0.0, 0.0
    load = moment.tolist()
    for k in range(steps):
        a = load[2 * k] - 2.0 * linear * omega_n * v - quadratic * abs(v) * v - omega_n**2 * x
        xm, vm = x + 0.5 * dt * v, v + 0.5 * dt * a
        x += dt * vm
        v += dt * (load[2 * k + 1] - 2.0 * linear * omega_n * vm - quadratic * abs(vm) * vm - omega_n**2 * xm)
        squares += v * v
    assert math.sqrt(squares / steps) == pytest.approx(sigma(ratio), rel=0.05)


def test_negative_coefficients_are_refused() -> None:
    with pytest.raises(ValueError, match="greater than or equal to 0"):
        RollDamping(z0=-0.1, z_speed=0.0, z_rate=0.0)
