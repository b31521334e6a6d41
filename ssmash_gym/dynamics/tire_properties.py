"""What a loaded tire is: vertical force, footprint, stiffnesses and relaxation lengths (Smiley & Horne, TR R-64).

Everything here depends on the vertical deflection alone. Deflections are clamped at zero and ratios where the
empirical formulas turn around, so that no input makes a negative stiffness or length. Theory: docs/theory/tire.md.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, maximum, minimum, splat, sqrt, where
from ssmash_gym.dynamics.layout import Tir, TireModel
from ssmash_gym.dynamics.maths import cbrt

DEEPEST_D = 0.5  # (2.126) is valid up to here: the deck through the tire centre
WIDEST_W = 0.55  # the widest footprint: beyond, (2.127) narrows again
LEAST_LENGTH_W = 0.05  # least relaxation length over the width: (2.128), (2.129) go negative near dz/d = 0.22
LEAST_SIGMA = 1e-3  # of the linear tire [m]


@kernel
def vertical_shape(x: Any, c_tz: Any) -> Any:
    """Shape ``f1`` of the vertical force; ``x = dz/w >= 0``, ``c_tz > 0`` (0.02 type I, 0.03 types III, VII)."""
    onset = 0.96 * x + 0.216 * x * x / c_tz  # (2.123)
    return where(x <= 10.0 / 3.0 * c_tz, onset, 2.4 * (x - c_tz))  # (2.124)


@kernel
def half_length_share(x: Any) -> Any:
    """Half footprint length over the diameter; ``x = dz/d`` in [0, 0.5]."""
    return 0.85 * sqrt(x - x * x)  # (2.126)


@kernel
def footprint_width_share(x: Any) -> Any:
    """Footprint width over the tire width; ``x = dz/w >= 0``, clamped where the formula turns."""
    x = minimum(x, WIDEST_W)
    cubed = x * x * x
    return 1.7 * sqrt(x * (1.0 - cubed * (2.5 - 1.5 * x * x)))  # (2.127)


@kernel
def yawed_relaxation_share(x: Any) -> Any:
    """Yawed relaxation length over ``(2.8 - 0.8 P/P_r) w``; ``x = dz/d >= 0``. Negative beyond 0.227."""
    middle = 64.0 * x - 500.0 * x * x - 1.4045
    return where(x <= 0.053, 11.0 * x, where(x <= 0.068, middle, 0.9075 - 4.0 * x))  # (2.129)


@kernel
def twist_shape(x: Any, type_i: Any) -> Any:
    """Twist stiffness over ``(P + 0.8 P_r) w^3``; ``x = dz/d >= 0``, ``type_i`` 1 for type I, else 0."""
    one = where(x <= 0.02, 475.0 * x * x, 19.0 * (x - 0.01))  # (2.132)
    others = where(x <= 0.03, 250.0 * x * x, 15.0 * (x - 0.015))  # (2.133)
    return where(type_i > 0.5, one, others)


@kernel
def footprint(p: Any, base: int, dz: Any, over_area: Any) -> tuple[Any, Any]:
    """Half length ``L_h`` and width ``b_t`` of the contact patch [m].

    Args:
        p: Parameter rows.
        base: First row of the tire (offsets `Tir`).
        dz: Vertical deflection, not negative [m].
        over_area: ``1 / (d w)`` [1/m2].
    """
    d = load(p, base + Tir.DIAMETER)
    w = load(p, base + Tir.WIDTH)
    half = d * half_length_share(minimum(dz * (w * over_area), DEEPEST_D))
    return half, w * footprint_width_share(dz * (d * over_area))


@kernel
def vertical_force(p: Any, base: int, elastic: Any, dz: Any, v_z: Any) -> Any:
    """Total vertical force [N], upwards: elastic force, damping and the rim; never pulls, nothing in the air."""
    beyond_rim = maximum(dz - load(p, base + Tir.BOTTOM), 0.0)
    total = elastic + load(p, base + Tir.CZ) * v_z + load(p, base + Tir.BOTTOM_K) * beyond_rim  # (2.122)
    return where(dz > 0.0, maximum(total, 0.0), 0.0)


@kernel
def smiley_horne(p: Any, base: int, dz: Any, v_z: Any, L_h: Any, b_t: Any, over_area: Any) -> Any:
    """Tire of TR R-64; arguments and result as in `properties`."""
    d = load(p, base + Tir.DIAMETER)
    w = load(p, base + Tir.WIDTH)
    p_o = load(p, base + Tir.P_O)
    p_r = load(p, base + Tir.P_R)
    type_i = load(p, base + Tir.TYPE_I)
    area = w * d
    x_w = dz * (d * over_area)
    x_d = dz * (w * over_area)
    pressure = p_o + 1.5 * load(p, base + Tir.P_ABS) * dz * dz * over_area  # (2.118), (2.119), (2.120), (2.121)

    shape = vertical_shape(x_w, load(p, base + Tir.CTZ))  # (2.125): the constant comes with the parameters
    F_z = vertical_force(p, base, (pressure + 0.08 * p_r) * w * sqrt(area) * shape, dz, v_z)  # (2.122)

    k_floor = 0.2 * (p_o + 0.24 * p_r) * w  # (2.131)
    k_y = (pressure + 0.24 * p_r) * (w - 0.7 * dz)  # (2.130)
    k_y = (2.0 + type_i) * maximum(k_y, k_floor)  # tau = 3 for type I, else 2
    k_x = 0.8 * d * (pressure + 4.0 * p_r) * cbrt(x_d)  # (2.134)
    k_psi = twist_shape(x_d, type_i) * (pressure + 0.8 * p_r) * w * w * w

    scale = (2.8 - 0.8 * pressure / p_r) * w
    least = LEAST_LENGTH_W * w
    L_u = maximum(scale * (1.0 - 4.5 * x_d), least)  # (2.128)
    L_y = maximum(scale * yawed_relaxation_share(x_d), least)  # (2.129)
    camber_moment = 0.01 * b_t * b_t * k_x  # (2.143)
    return F_z, k_x, k_y, k_psi, L_y + L_h, L_y, L_u, L_h, F_z, camber_moment  # (2.135), (2.140)


@kernel
def linear_tire(p: Any, base: int, dz: Any, v_z: Any) -> Any:
    """Tire of constant stiffnesses and one relaxation length; result as in `properties`."""
    F_z = vertical_force(p, base, load(p, base + Tir.LIN_KZ) * dz, dz, v_z)
    k_x = load(p, base + Tir.LIN_KX)
    k_y = load(p, base + Tir.LIN_KY)
    sigma = maximum(load(p, base + Tir.LIN_SIGMA), LEAST_SIGMA)
    none = splat(0.0)
    return F_z, k_x, k_y, load(p, base + Tir.LIN_KPSI), sigma, sigma, sigma, none, none, none


@kernel
def properties(p: Any, base: int, model: int, dz: Any, v_z: Any, L_h: Any, b_t: Any, over_area: Any) -> Any:
    """Vertical force and elastic properties of one tire.

    Args:
        p: Parameter rows.
        base: First row of the tire (offsets `Tir`).
        model: `TireModel`.
        dz: Vertical deflection, not negative [m].
        v_z: Rate of the vertical deflection (velocity of the tire centre towards the deck) [m/s].
        L_h: Half footprint length at this deflection [m].
        b_t: Footprint width at this deflection [m].
        over_area: ``1 / (d w)`` [1/m2].

    Returns:
        ``(F_z, k_x, k_y, k_psi, L_0, L_y, L_u, L_m, c_f, c_m)``: vertical force [N]; longitudinal and lateral [N/m]
        and twist stiffness [N m/rad]; cornering power over lateral stiffness [m]; yawed and un-yawed relaxation
        length of the twist [m]; length that the yawed rolling moment scales with [m]; force [N/rad] and moment
        [N m/rad] per inclination of a rolling tire.
    """
    if model == TireModel.LINEAR:
        return linear_tire(p, base, dz, v_z)
    return smiley_horne(p, base, dz, v_z, L_h, b_t, over_area)
