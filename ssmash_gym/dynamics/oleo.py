"""Gas oleo: spring in five regions, staged damping, seal and bearing friction, end stop.

Compression ``x`` and compression rate ``v`` are positive in compression; a positive force pushes the two
ends of the strut apart. Everything that dissipates is written as ``slope(x, v) v`` with ``slope >= 0``: it
can never drive the motion, and the integrator takes the slope implicitly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.lane import fabs, kernel, load, maximum, minimum, uncompiled, where
from ssmash_gym.dynamics.layout import STATION_ROWS, Sta
from ssmash_gym.dynamics.maths import exp, expm1, log
from ssmash_gym.dynamics.suspension import LEAST_SPEED, end_stop

LEAST_GAS: Final = 1.0e-3  # least share of the gas volume, keeps the logarithm defined
LEAST_SEPARATION: Final = 1.0e-3  # of the two bearings [m]

_GIVEN: Final = ("x0", "x1", "x2", "k", "gas_p", "gas_v", "gas_a", "gas_gamma", "e1", "e2", "f1", "f2", "g1", "g2")


@kernel
def friction_slope(beta: Any, w: Any, inverse: Any) -> Any:
    """``(1 - exp(-beta w)) / w``: smoothed dry friction of unit size, divided by the speed.

    Args:
        beta: Decay constant [s/m] or [s/rad].
        w: Magnitude of the speed, at least `LEAST_SPEED`.
        inverse: ``1 / w``.

    Returns:
        The secant slope; it tends to ``beta`` at rest.
    """
    return -expm1(-(beta * w)) * inverse  # (2.8)


@kernel
def spring(p: Any, base: int, x: Any) -> Any:
    """Spring force of the oleo [N] at compression ``x`` [m], (2.203)-(2.207), end stop excluded."""
    x0 = load(p, base + Sta.X0)
    x1 = load(p, base + Sta.X1)
    x2 = load(p, base + Sta.X2)
    k = load(p, base + Sta.K)
    area = load(p, base + Sta.GAS_A)
    # Every law gets the travel clamped to its own region: the unused ones stay finite, and regions 3, 4 and 5
    # follow each other without a selection, the force at x1 being what region 3 gives there.
    x_gas = minimum(maximum(x, x0), x1)
    gas_left = maximum(1.0 - area / load(p, base + Sta.GAS_V) * x_gas, LEAST_GAS)
    pressure = load(p, base + Sta.GAS_P) * exp(-(load(p, base + Sta.GAS_GAMMA) * log(gas_left)))
    gas = area * (pressure - load(p, base + Sta.P_REF))  # (2.205)
    d = minimum(maximum(x - x1, 0.0), x2 - x1)
    e, f, g = load(p, base + Sta.E1), load(p, base + Sta.F1), load(p, base + Sta.G1)
    compressed = gas + d * (e + d * (f + d * g))  # (2.206)
    d = maximum(x - x2, 0.0)
    e, f, g = load(p, base + Sta.E2), load(p, base + Sta.F2), load(p, base + Sta.G2)
    compressed = compressed + d * (e + d * (f + d * g))  # (2.207)
    x_small = minimum(maximum(x, 0.0), x0)
    small = x_small * (k + x_small * (load(p, base + Sta.R2_C) + x_small * load(p, base + Sta.R2_D)))  # (2.204)
    return where(x < 0.0, k * x, where(x < x0, small, compressed))  # (2.203)


@kernel
def damping_slope(p: Any, base: int, v: Any, w: Any, inverse: Any, smooth: Any) -> Any:
    """Damping force divided by the compression rate [N s/m], never negative.

    The staged curve of (2.213) in closed form, ``min(F1, max(R1, min(F2, max(R2, F3))))``, every term divided
    by the speed. The constants ``c_01`` and ``c_1`` come in with the smoothing of the friction.

    Args:
        p: Parameter rows.
        base: First row of the station.
        v: Compression rate [m/s].
        w: Its magnitude, at least `LEAST_SPEED`.
        inverse: ``1 / w``.
        smooth: `friction_slope` of this speed.
    """
    rebound = load(p, base + Sta.C01) * smooth + load(p, base + Sta.C02) + load(p, base + Sta.C03) * w  # (2.212)
    first = load(p, base + Sta.C1) * smooth + load(p, base + Sta.C2) + load(p, base + Sta.C3) * w  # (2.213)
    second = load(p, base + Sta.C4) * inverse + load(p, base + Sta.C5) + load(p, base + Sta.C6) * w
    third = load(p, base + Sta.C7) * inverse + load(p, base + Sta.C8) + load(p, base + Sta.C9) * w
    beyond = minimum(second, maximum(load(p, base + Sta.REL2) * inverse, third))
    staged = minimum(first, maximum(load(p, base + Sta.REL1) * inverse, beyond))
    return maximum(where(v < 0.0, rebound, staged), 0.0)


@kernel
def bearing_load(p: Any, base: int, x: Any, moment: Any) -> Any:
    """Normal load at the upper shaft bearing [N].

    Args:
        p: Parameter rows.
        base: First row of the station.
        x: Compression from full droop [m].
        moment: Magnitude of the moment about the lower bearing, normal to the oleo axis, (2.214) [N m].
    """
    separation = load(p, base + Sta.BEARING_L0) + x  # (2.216)
    return moment / maximum(separation, LEAST_SEPARATION)  # (2.215)


@kernel
def gas_oleo(p: Any, base: int, x: Any, v: Any, normal: Any) -> tuple[Any, Any]:
    """Total force of a gas oleo.

    Args:
        p: Parameter rows.
        base: First row of the station.
        x: Compression from full droop [m].
        v: Compression rate [m/s].
        normal: Bearing normal load, `bearing_load` [N]; 0 on a swing arm.

    Returns:
        ``(F, slope)``: total force with the end stop [N], and the secant slope of its dissipation (damping,
        friction, damping of the stop) [N s/m], finite at rest and never negative.
    """
    w = maximum(fabs(v), LEAST_SPEED)
    inverse = 1.0 / w
    smooth = friction_slope(load(p, base + Sta.BETA), w, inverse)
    friction = load(p, base + Sta.SEAL) + load(p, base + Sta.BEARING_MU) * normal  # (2.217)
    stop, stop_slope = end_stop(p, base, x, v, inverse)
    slope = friction * smooth + stop_slope  # (2.218)
    slope = slope + damping_slope(p, base, v, w, inverse, smooth)
    return spring(p, base, x) + stop + slope * v, slope  # (2.219), (2.220)


# --- for filling and checking parameter tables: plain NumPy, nothing compiled ------------------------------


def gas_law(pressure: Any, volume: Any, area: Any, gamma: Any, x: Any, p_ref: Any = 0.0) -> tuple[Any, Any]:
    """Force of the gas and its derivative, (2.208) and (2.209), with a reference pressure subtracted.

    Args:
        pressure: Absolute gas pressure at full droop [Pa].
        volume: Gas volume at full droop [m3].
        area: Piston area [m2].
        gamma: Polytropic exponent.
        x: Compression [m], less than ``volume / area``.
        p_ref: Pressure outside the piston [Pa], 0 in the thesis.

    Returns:
        ``(F, dF/dx)`` in [N] and [N/m].

    Raises:
        ValueError: The piston would have swept the whole gas volume.
    """
    left = 1.0 - np.asarray(area, dtype=float) * x / volume
    if np.any(left <= 0.0):
        raise ValueError(
            f"oleo: compression {np.max(x):g} m must be less than gas_v / gas_a = {np.min(volume / area):g} m"
        )
    gas = pressure * area * left**-gamma  # (2.208)
    return gas - p_ref * area, gas * gamma * area / (volume * left)  # (2.209)


def region2_constants(
    pressure: Any, volume: Any, area: Any, gamma: Any, x0: Any, k: Any, p_ref: Any = 0.0
) -> tuple[Any, Any]:
    """Constants ``c`` [N/m2] and ``d`` [N/m3] that make the spring C1 at 0 and ``x0``, (2.210) and (2.211).

    Args:
        pressure: Absolute gas pressure at full droop [Pa].
        volume: Gas volume at full droop [m3].
        area: Piston area [m2].
        gamma: Polytropic exponent.
        x0: End of region 2 [m].
        k: Spring rate past full droop [N/m].
        p_ref: Pressure outside the piston [Pa], 0 in the thesis.

    Raises:
        ValueError: ``x0`` is not positive, or beyond ``volume / area``.
    """
    if np.any(np.asarray(x0) <= 0.0):
        raise ValueError(f"oleo: x0 = {np.min(x0):g} m must be greater than 0")
    force, slope = gas_law(pressure, volume, area, gamma, x0, p_ref)
    c = (3.0 * force - slope * x0 - 2.0 * k * x0) / (x0 * x0)  # (2.210)
    d = (slope * x0 - 2.0 * force + k * x0) / (x0 * x0 * x0)  # (2.211)
    return c, d


def spring_curve(values: Mapping[str, float], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Spring force over compression, by the kernel itself; the end stop is not in it.

    Args:
        values: Lower-case names of the members of ``Sta`` from ``X0`` to ``G2`` to SI values. ``p_ref`` is 0
            unless given; the derived ``r2_c`` and ``r2_d`` are worked out here whether given or not.
        x: Compressions [m], any shape.

    Returns:
        Forces [N], shape of ``x``.

    Raises:
        ValueError: A value is missing, or `region2_constants` refuses the set.
    """
    missing = [name for name in _GIVEN if name not in values]
    if missing:
        raise ValueError(f"oleo: the spring curve needs {', '.join(missing)}")
    gas = (values["gas_p"], values["gas_v"], values["gas_a"], values["gas_gamma"])
    p_ref = values.get("p_ref", 0.0)
    block = np.zeros((STATION_ROWS, 1))
    for name in _GIVEN:
        block[Sta[name.upper()]] = values[name]
    block[Sta.P_REF] = p_ref
    block[Sta.R2_C], block[Sta.R2_D] = region2_constants(*gas, values["x0"], values["k"], p_ref)
    travel = np.asarray(x, dtype=float)
    force: NDArray[np.float64] = uncompiled(spring)(block, 0, travel.reshape(-1)).reshape(travel.shape)
    return force
