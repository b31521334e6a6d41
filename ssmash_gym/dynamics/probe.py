"""Securing probe: kinematics of the probe in the claw, its in-plane and axial force, capture and loss."""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.dynamics.lane import kernel, load, maximum, minimum, splat, sqrt, where
from ssmash_gym.dynamics.layout import Par, ProbeLaw
from ssmash_gym.dynamics.vectors import Matrix, Vector, apply, apply_t, cross, dot, load3, scale, sub

LEAST_DIP: Final = 0.05  # share of the probe's length that must point into the deck for the claw to hold it
LEAST_LENGTH: Final = 1.0e-6  # [m], keeps directions finite
LEAST_TRANSITION: Final = 1.0e-6  # of D_PS,x and D_PS,y [m]; below it the probe has no first stage
LEAST_RAMP: Final = 1.0e-3  # extension over which axial damping comes in, at least [m]
LEAST_CONSTANT: Final = 1.0e-6  # of a stiffness or damping constant in an effective value
LEAST_SQUARE: Final = 1.0e-24  # of a squared magnitude whose direction is taken


@kernel
def probe_kinematics(
    p: Any, R_SH: Matrix, v_SH_S: Vector, w_SH_H: Vector, r_HC_H: Vector, v_SC_S: Vector
) -> tuple[Any, ...]:
    """Where the probe's axis meets the claw plane, and how fast that moves.

    Everything in H axes, as (2.165)-(2.168); the rates are those of the ship frame, in H axes (2.172).

    Returns:
        ``(reach, reach_rate, length, axis, delta, delta_rate, holds)``: length factor ``d_b`` and its rate,
        undeformed length, unit vector a -> c, claw centre from b and its rate, and 1 where the probe points
        into the deck enough to be held (else 0, and ``reach`` is 0).
    """
    k_H = (R_SH[6], R_SH[7], R_SH[8])  # the ship's z axis
    r_ac_H = load3(p, Par.PROBE_VECTOR)
    length = sqrt(dot(r_ac_H, r_ac_H))
    inverse_length = 1.0 / maximum(length, LEAST_LENGTH)
    r_aC_H = sub(r_HC_H, load3(p, Par.PROBE_MOUNT))
    g = dot(r_ac_H, k_H)  # (2.174)
    dips = g * inverse_length >= LEAST_DIP
    inverse_g = 1.0 / maximum(g, LEAST_DIP * LEAST_LENGTH)
    reach = where(dips, dot(r_aC_H, k_H) * inverse_g, 0.0)  # (2.166), (2.167)
    along = scale(reach, r_ac_H)
    delta = sub(r_aC_H, along)  # (2.165), (2.168)
    # v: velocity of the claw relative to the point of the helicopter that is now at b. With it
    # f' - d_b g' = v . k, so that (2.175)-(2.177) need one cross product.
    r_Hb_H = sub(r_HC_H, delta)
    v = sub(apply_t(R_SH, sub(v_SC_S, v_SH_S)), cross(w_SH_H, r_Hb_H))  # (2.173)
    reach_rate = where(dips, dot(v, k_H) * inverse_g, 0.0)  # (2.175)-(2.177)
    delta_rate = sub(v, scale(reach_rate, r_ac_H))  # (2.172)
    axis = scale(inverse_length, r_ac_H)
    return reach, reach_rate, length, axis, delta, delta_rate, where(dips, splat(1.0), splat(0.0))


@kernel
def potential_force(p: Any, d_x: Any, d_y: Any, v_x: Any, v_y: Any) -> tuple[Any, Any]:
    """In-plane force as minus the gradient of a potential, with diagonal damping (errata section 3).

    With ``d`` the probe point from the claw centre and ``rho = |d / D|``: ``F = -(K_S d + s^2 dK d +
    s (d' dK d) D^-2 d / rho^3)``, ``dK = K_L - K_S``, ``s = 1 - 1/rho`` beyond ``rho = 1`` and 0 within. On
    either axis this is (2.183), and an isotropic probe is equally stiff in every direction.
    """
    soft_x, soft_y = load(p, Par.PROBE_KS_X), load(p, Par.PROBE_KS_Y)
    extra_x = load(p, Par.PROBE_KL_X) - soft_x
    extra_y = load(p, Par.PROBE_KL_Y) - soft_y
    scale_x = 1.0 / maximum(load(p, Par.PROBE_D_X), LEAST_TRANSITION)
    scale_y = 1.0 / maximum(load(p, Par.PROBE_D_Y), LEAST_TRANSITION)
    e_x, e_y = d_x * scale_x, d_y * scale_y
    inverse_rho = 1.0 / sqrt(maximum(e_x * e_x + e_y * e_y, 1.0))  # 1 within the first stage
    s = 1.0 - inverse_rho
    ss = s * s
    growth = s * (extra_x * d_x * d_x + extra_y * d_y * d_y) * (inverse_rho * inverse_rho * inverse_rho)
    return (
        -((soft_x + ss * extra_x) * d_x + growth * scale_x * e_x + load(p, Par.PROBE_C_X) * v_x),
        -((soft_y + ss * extra_y) * d_y + growth * scale_y * e_y + load(p, Par.PROBE_C_Y) * v_y),
    )


@kernel
def effective(c_x: Any, c_y: Any, cos2: Any, sin2: Any, printed: bool) -> Any:
    """Effective constant in a direction: on the ellipse of the two constants, or as printed."""
    inverse_x = 1.0 / maximum(c_x, LEAST_CONSTANT)
    inverse_y = 1.0 / maximum(c_y, LEAST_CONSTANT)
    if printed:
        cos2, sin2 = cos2 * cos2, sin2 * sin2
    return 1.0 / sqrt(cos2 * inverse_x * inverse_x + sin2 * inverse_y * inverse_y)  # (2.184)-(2.186), (2.190)


@kernel
def radial_force(p: Any, d_x: Any, d_y: Any, v_x: Any, v_y: Any, printed: bool) -> tuple[Any, Any]:
    """In-plane force along the displacement, damping along the rate, with effective constants.

    Not conservative where x and y differ. ``printed`` takes (2.184)-(2.186) and (2.190) to the letter, which
    makes an isotropic probe 41 % too stiff at 45 degrees; otherwise the constants lie on an ellipse.
    """
    square = d_x * d_x + d_y * d_y
    some = square > LEAST_SQUARE
    inverse = 1.0 / maximum(square, LEAST_SQUARE)
    cos2 = where(some, d_x * d_x * inverse, 1.0)  # (2.182) without the arctangent, which loses the sign
    sin2 = where(some, d_y * d_y * inverse, 0.0)
    soft = effective(load(p, Par.PROBE_KS_X), load(p, Par.PROBE_KS_Y), cos2, sin2, printed)  # (2.184)
    stiff = effective(load(p, Par.PROBE_KL_X), load(p, Par.PROBE_KL_Y), cos2, sin2, printed)  # (2.185)
    transition = effective(load(p, Par.PROBE_D_X), load(p, Par.PROBE_D_Y), cos2, sin2, printed)  # (2.186)
    distance = sqrt(square)  # (2.181)
    beyond = maximum(distance - transition, 0.0)
    force = soft * (distance - beyond) + stiff * beyond  # (2.183)
    secant = force * sqrt(inverse)
    square = v_x * v_x + v_y * v_y  # (2.187)
    some = square > LEAST_SQUARE
    inverse = 1.0 / maximum(square, LEAST_SQUARE)
    cos2 = where(some, v_x * v_x * inverse, 1.0)  # (2.188)
    sin2 = where(some, v_y * v_y * inverse, 0.0)
    c = effective(load(p, Par.PROBE_C_X), load(p, Par.PROBE_C_Y), cos2, sin2, printed)  # (2.190)
    return -(secant * d_x + c * v_x), -(secant * d_y + c * v_y)  # (2.189)


@kernel
def axial_tension(p: Any, extension: Any, rate: Any) -> Any:
    """Tension along the probe's axis [N]: none while slack, never negative, no jump at first tension."""
    stretch = maximum(extension, 0.0)  # (2.192)
    transition = load(p, Par.PROBE_D_Z)
    beyond = maximum(stretch - transition, 0.0)
    spring = load(p, Par.PROBE_KS_Z) * (stretch - beyond) + load(p, Par.PROBE_KL_Z) * beyond  # (2.191)
    ramp = minimum(stretch / maximum(transition, LEAST_RAMP), 1.0)
    return maximum(spring + load(p, Par.PROBE_C_Z) * rate * ramp, 0.0)  # (2.193)


@kernel
def probe(
    p: Any,
    law: int,
    R_SH: Matrix,
    r_SH_S: Vector,
    v_SH_S: Vector,
    w_SH_H: Vector,
    r_SC_S: Vector,
    v_SC_S: Vector,
    captured: Any,
) -> tuple[Vector, Vector, tuple[Any, ...]]:
    """Force and moment of the securing probe on the helicopter.

    Args:
        p: Parameter rows.
        law: A `ProbeLaw`.
        R_SH: Takes H components to S components.
        r_SH_S: Helicopter's c.g. from the ship-frame origin, S axes [m].
        v_SH_S: Its velocity over the ship, S axes [m/s].
        w_SH_H: Angular velocity of the helicopter relative to the ship, H axes [rad/s].
        r_SC_S: Claw centre, S axes [m].
        v_SC_S: Claw velocity over the ship, S axes [m/s].
        captured: 1 while the claw holds the probe, else 0.

    Returns:
        ``(F_H, M_H, reads)``: force at the claw centre [N] and its moment about the helicopter's c.g. [N m],
        H axes. ``reads = (in_plane, axial, d_x, d_y, extension, b_S_x, b_S_y, reach)``: magnitudes of the two
        forces [N]; probe point b from the claw centre in H and axial extension [m]; b in S [m]; the length
        factor ``d_b`` (2.167). Displacements are reported whether captured or not. A probe that points into
        the deck with less than `LEAST_DIP` of its length is not held: no force, ``reach`` 0, b at its mount.
    """
    r_HC_H = apply_t(R_SH, sub(r_SC_S, r_SH_S))
    reach, reach_rate, length, axis, delta, delta_rate, dips = probe_kinematics(p, R_SH, v_SH_S, w_SH_H, r_HC_H, v_SC_S)
    d_x, d_y = -delta[0], -delta[1]  # (2.169), (2.170)
    v_x, v_y = -delta_rate[0], -delta_rate[1]  # (2.178), (2.179)
    extension = (reach - 1.0) * length  # (2.171)
    if law == ProbeLaw.POTENTIAL:
        F_x, F_y = potential_force(p, d_x, d_y, v_x, v_y)
    else:
        F_x, F_y = radial_force(p, d_x, d_y, v_x, v_y, law == ProbeLaw.PRINTED)
    hold = captured * load(p, Par.PROBE_ACTIVE) * dips
    F_x, F_y = hold * F_x, hold * F_y
    axial = hold * axial_tension(p, extension, reach_rate * length)  # (2.180)
    pull = scale(axial, axis)
    F_H = (pull[0] + F_x, pull[1] + F_y, pull[2])  # (2.194)
    b_S = sub(r_SC_S, apply(R_SH, delta))
    in_plane = sqrt(F_x * F_x + F_y * F_y)
    return F_H, cross(r_HC_H, F_H), (in_plane, axial, d_x, d_y, extension, b_S[0], b_S[1], reach)  # (2.195)


@kernel
def capture(p: Any, d_x: Any, d_y: Any, reach: Any, resultant: Any, captured: Any, lost: Any) -> tuple[Any, Any]:
    """Whether the claw holds the probe after this step (errata section 7; the thesis gives no law).

    Captured, and from then on, once b lies within the claw's window and the tip is at or below the claw plane
    (``0 < reach <= 1``); lost for good when the load of a captured probe exceeds the ultimate load.

    Args:
        p: Parameter rows.
        d_x: Probe point b from the claw centre, H axes, x [m].
        d_y: The same, y.
        reach: Length factor, as `probe` reports it.
        resultant: Magnitude of the probe force [N].
        captured: 1 captured, 0 not.
        lost: 1 lost, 0 not.

    Returns:
        The new ``(captured, lost)``.
    """
    broken = (captured > 0.5) & (resultant > load(p, Par.PROBE_ULTIMATE))
    lost = where(broken, 1.0, lost)
    radius = load(p, Par.PROBE_CAPTURE_RADIUS)
    within = (d_x * d_x + d_y * d_y <= radius * radius) & (reach > 0.0) & (reach <= 1.0)
    within = within & (load(p, Par.PROBE_ACTIVE) > 0.5)
    return where(lost > 0.5, 0.0, where(within, 1.0, captured)), lost
