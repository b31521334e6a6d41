"""One tire on the deck: contact forces, moments and the rates of its three stored deflections.

The five degrees of freedom of Léveillé 2013, section 2.5.1 (longitudinal, lateral and vertical deflection, camber and
twist), with the transient states written as rates, so that the answer does not depend on the step size. Theory, signs
and deviations from the print: docs/theory/tire.md.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import fabs, kernel, load, maximum, minimum, sqrt, where
from ssmash_gym.dynamics.layout import Contact, Friction, Tir
from ssmash_gym.dynamics.maths import atan2, expm1, sign
from ssmash_gym.dynamics.tire_properties import footprint, properties
from ssmash_gym.dynamics.vectors import Vector, add, cross

EPS_SPEED = 1e-5  # regularises the slip angle at rest; steady slip is low by EPS_SPEED / |v_x| [m/s]
EPS_SIDE = 1e-12  # least lateral speed in the slip angle: keeps 0/0 out of the relaxation length [m/s]
LEAST_GRIP = 1e-6  # [N]
LEAST_RADIUS = 1e-4  # effective radius of the contact patch under twist [m]
LEAST_SIGMA = 1e-4  # relaxation length, should the parameter be zero [m]
LEAST_STIFFNESS = 1e-3  # [N/m], [N m/rad]
TOUCH_LOAD = 10.0  # below this vertical force the deck drags less and less at the stored deflections [N]
STANDING_CAMBER = 0.57  # of (2.139), over 1.0 of (2.140)
BLEND_ANGLE = 0.02  # slip angle at which the twist relaxes half with L_y, half with L_u [rad]
FASTEST = 400.0  # bound of the relaxation rates [1/s]: beyond some 20 m/s, or on a nearly weightless tire
MOST_TWIST = 0.2  # bound of the steady twist: (2.144) grows without limit as the load vanishes [rad]
LEAST_DAMPING = 1e-12  # over mu F_z: keeps 0/0 out of the share of damping that friction leaves


@kernel
def tire_frame(wy_S: Vector) -> tuple[Any, Any, Any]:
    """Heading and inclination of the wheel from its axle ``w_y``.

    Returns:
        ``(c, s, inclination)``: ``t_x = (c, s, 0)``, ``t_y = (-s, c, 0)``, ``t_z = s_z`` in S, and the inclination
        angle [rad], positive when the wheel leans to starboard (positive roll). A vertical axle has no heading:
        ``t_x`` shrinks to zero there.
    """
    over = 1.0 / maximum(sqrt(wy_S[0] * wy_S[0] + wy_S[1] * wy_S[1]), 1e-6)
    z = wy_S[2]
    z2 = z * z
    inclination = z * (1.0 + z2 * (1.0 / 6.0 + 0.075 * z2))  # (2.114) arcsine, within 0.1 % up to 30 deg
    return wy_S[1] * over, -(wy_S[0] * over), inclination  # (2.113), (2.115), (2.116)


@kernel
def yawed_force(phi: Any) -> Any:
    """Steady lateral force over ``mu F_z`` of a tire rolling at the slip parameter ``phi >= 0``; a magnitude."""
    x = minimum(phi, 1.5)
    return x * (1.0 - (4.0 / 27.0) * x * x)  # (2.137)


@kernel
def yawed_moment(phi: Any) -> Any:
    """Steady twisting moment over ``mu F_z L_h`` of a tire rolling at ``phi >= 0``; a magnitude."""
    falling = maximum(0.2925 - 0.1 * phi, 0.0)
    return where(phi <= 0.1, 0.8 * phi, where(phi <= 0.55, phi - phi * phi - 0.01, falling))  # (2.142)


@kernel
def damping_share(used: Any, size: Any) -> Any:
    """Factor that keeps damping of `size` in the room that elastic forces `used` leave, both shares of the limit."""
    return minimum(maximum(1.0 - used, 0.0) / maximum(size, LEAST_DAMPING), 1.0)


@kernel
def friction_limit(friction: int, F_z: Any, a: Any, b: Any, c: Any, e: Any, f: Any) -> Any:
    """What friction leaves of the elastic and of the damping forces.

    Damping has the room between the elastic forces and the limit, whichever way it acts: by the triangle inequality
    the sum stays within the limit.

    Args:
        friction: `Friction`.
        F_z: Vertical force [N]; nothing is left where it vanishes.
        a: Longitudinal elastic force over ``mu F_z``.
        b: Lateral elastic force over ``mu F_z``.
        c: Twisting moment over ``M_max``.
        e: Longitudinal damping force over ``mu F_z``.
        f: Lateral damping force over ``mu F_z``.

    Returns:
        ``(s_x, s_y, s_psi, damp_x, damp_y, use)``: factors of the elastic forces, of the damping forces, and the
        share of the limit that both use together, at most 1.
    """
    loaded = where(F_z > 0.0, 1.0, 0.0)
    if friction == Friction.LIMIT_SURFACE:
        root = sqrt(a * a + b * b + c * c)
        left = loaded / maximum(root, 1.0)
        damp = damping_share(root, sqrt(e * e + f * f))
        x, y = a + damp * e, b + damp * f
        use = where(root < 1.0, minimum(sqrt(x * x + y * y + c * c), 1.0), 1.0)
        return left, left, left, loaded * damp, loaded * damp, loaded * use
    twist = fabs(c)
    if friction == Friction.FRICTION_CIRCLE:
        root = sqrt(a * a + b * b)
        left = loaded / maximum(root, 1.0)
        damp = damping_share(root, sqrt(e * e + f * f))
        x, y = a + damp * e, b + damp * f
        use = where(root < 1.0, minimum(maximum(sqrt(x * x + y * y), twist), 1.0), 1.0)
        return left, left, loaded / maximum(twist, 1.0), loaded * damp, loaded * damp, loaded * use
    along = fabs(a)
    across = fabs(b)
    s_x = loaded / maximum(along, 1.0)  # (2.153)
    s_y = loaded / maximum(across, 1.0)  # (2.147)
    damp_x = loaded * damping_share(along, fabs(e))
    damp_y = loaded * damping_share(across, fabs(f))
    use = loaded * minimum(maximum(fabs(a + damp_x * e), fabs(b + damp_y * f)), 1.0)
    return s_x, s_y, loaded, damp_x, damp_y, use


@kernel
def yawed_rolling(v_x: Any, v_y: Any, v_roll: Any, lengths: Any, slide: Any, over_slide: Any, least: Any) -> Any:
    """Relaxation of a tire that rolls at a slip angle.

    Args:
        v_x: Velocity over the deck along ``t_x`` [m/s].
        v_y: Velocity over the deck along ``t_y`` [m/s].
        v_roll: Rolling speed, ``|v_x|`` of a wheel that turns, 0 of a locked one [m/s].
        lengths: ``(L_0, L_y, L_u)`` as in `properties` [m].
        slide: Lateral deflection at which the tire slides, ``mu F_z / k_y`` [m].
        over_slide: ``1 / slide``, finite.
        least: Least relaxation length of the lateral deflection, positive [m].

    Returns:
        ``(rate_y, rate_psi, moment)``: relaxation rates of lateral deflection and twist [1/s] and the steady
        twisting moment over ``mu F_z L_h``, signed.
    """
    L_0, L_y, L_u = lengths
    ahead = fabs(v_x) + EPS_SPEED
    aside = maximum(fabs(v_y), EPS_SIDE)
    over = 1.0 / ahead
    tangent = aside * over
    angle = atan2(aside, ahead)  # (2.117), magnitude
    phi = L_0 * angle * over_slide  # (2.136)
    # sigma = max(|d_ss| / tan(angle), least) with |d_ss| = slide * yawed_force(phi); all multiplied by the tangent
    rate_y = minimum(v_roll * tangent / maximum(slide * yawed_force(phi), least * tangent), FASTEST)
    # the twist relaxes with L_y, L_u as the angle vanishes: mean with the weights angle^2 and BLEND_ANGLE^2
    yawed = angle * angle
    both = yawed + BLEND_ANGLE * BLEND_ANGLE
    rate_psi = minimum(v_roll * both / (yawed * L_y + (BLEND_ANGLE * BLEND_ANGLE) * L_u), FASTEST)
    return rate_y, rate_psi, sign(v_y) * v_x * over * yawed_moment(phi)


@kernel
def free_rates(
    p: Any,
    base: int,
    props: Any,
    grip: Any,
    over_grip: Any,
    motion: Any,
    inclination: Any,
    d_y: Any,
    psi: Any,
    lock: Any,
) -> Any:
    """Rates of the stored deflections as if friction had no limit.

    Args:
        p: Parameter rows.
        base: First row of the tire.
        props: What `properties` returns.
        grip: ``mu F_z`` [N].
        over_grip: ``1 / (mu F_z)``, finite [1/N].
        motion: ``(v_x, v_y, r_z)``: velocity over the deck along ``t_x``, ``t_y`` [m/s] and yaw rate [rad/s].
        inclination: Inclination angle [rad].
        d_y: Stored lateral deflection [m].
        psi: Stored twist [rad].
        lock: 1 where the wheel may not turn, 0 where it rolls.

    Returns:
        ``(d_x', d_y', psi', standing, rolls)``: rates [m/s], [m/s], [rad/s]; camber force beside the stored
        deflection [N]; 0 for a standing or locked wheel to 1 for a rolling one.
    """
    _, _, k_y, k_psi, L_0, L_y, L_u, L_m, c_f, c_m = props
    v_x, v_y, r_z = motion
    v_roll = (1.0 - lock) * fabs(v_x)
    rolls = -expm1(-(load(p, base + Tir.BETA) * v_roll))
    over_k_y = 1.0 / maximum(k_y, LEAST_STIFFNESS)
    least = maximum(load(p, base + Tir.SIGMA_MIN), LEAST_SIGMA)
    lengths = (L_0, L_y, L_u)
    rate_y, rate_psi, m_ss = yawed_rolling(v_x, v_y, v_roll, lengths, grip * over_k_y, k_y * over_grip, least)

    camber = c_f * inclination
    standing = STANDING_CAMBER * (1.0 - rolls) * camber  # (2.139)
    d_camber = (camber - standing) * over_k_y  # (2.138): with the standing part, (2.140) in all
    psi_ss = (grip * L_m * m_ss + c_m * inclination) / maximum(k_psi, LEAST_STIFFNESS)  # (2.144)
    psi_ss = minimum(maximum(psi_ss, -MOST_TWIST), MOST_TWIST)
    dot_x = -(lock * v_x)  # (2.152)
    dot_y = -v_y - rate_y * (d_y - d_camber)  # (2.145), (2.146) as a rate; steady state (2.141)
    dot_psi = -r_z - rate_psi * (psi - psi_ss)  # (2.149), (2.150) as a rate
    return dot_x, dot_y, dot_psi, standing, rolls


@kernel
def carriage_velocity(contact: int, height: Any, v_ST_S: Vector, w_SW_S: Vector, c: Any, s: Any) -> tuple[Any, Any]:
    """Velocity over the deck along ``t_x`` and ``t_y`` [m/s] of the carriage point at the contact, or the centre."""
    if contact == Contact.CONTACT:
        x = v_ST_S[0] + w_SW_S[1] * height
        y = v_ST_S[1] - w_SW_S[0] * height
        return c * x + s * y, c * y - s * x
    return c * v_ST_S[0] + s * v_ST_S[1], c * v_ST_S[1] - s * v_ST_S[0]


@kernel
def wrench(
    r_WT_S: Vector, height: Any, c: Any, s: Any, F_x: Any, F_y: Any, F_z: Any, M_x: Any, M_y: Any, M_z: Any
) -> tuple[Vector, Vector]:
    """Force and moment about the carriage origin, S axes, of contact forces and moments in the tire frame."""
    force = (c * F_x - s * F_y, s * F_x + c * F_y, -F_z)  # (2.160)
    arm = (r_WT_S[0], r_WT_S[1], r_WT_S[2] + height)
    moment = (c * M_x - s * M_y, s * M_x + c * M_y, M_z)
    return force, add(moment, cross(arm, force))  # (2.161)


@kernel
def tire(
    p: Any,
    base: int,
    model: int,
    friction: int,
    contact: int,
    r_WT_S: Vector,
    height: Any,
    v_ST_S: Vector,
    w_SW_S: Vector,
    wy_S: Vector,
    d_x: Any,
    d_y: Any,
    psi: Any,
    lock: Any,
    mu: Any,
) -> Any:
    """Forces of one tire and the rates of its stored deflections.

    Args:
        p: Parameter rows.
        base: First row of the tire (offsets `Tir`).
        model: `TireModel`.
        friction: `Friction`.
        contact: `Contact`.
        r_WT_S: Tire centre from the carriage origin, S axes [m].
        height: Height of the tire centre over the deck plane [m].
        v_ST_S: Velocity of the tire centre over the deck, S axes [m/s].
        w_SW_S: Angular velocity of the carriage relative to the ship, S axes [rad/s].
        wy_S: Wheel axle, unit vector ``w_y`` in S.
        d_x: Stored longitudinal deflection [m].
        d_y: Stored lateral deflection [m].
        psi: Stored twist [rad].
        lock: 1 where the wheel may not turn, 0 where it rolls.
        mu: Friction coefficient where the tire touches the deck.

    Returns:
        ``(F_S, M_S, rates, reads)``: force on the carriage [N] and moment about the carriage origin [N m], S axes;
        ``(d_x', d_y', psi')`` [m/s], [m/s], [rad/s]; ``(F_z, F_y, F_x, dz, d_y, d_x, psi, use)``: vertical force
        (upwards) and in-plane forces in the tire frame [N], vertical deflection [m], lateral and longitudinal
        deflection [m] and twist [rad] within the friction limit, share of the friction limit in use.
    """
    d = load(p, base + Tir.DIAMETER)
    over_area = 1.0 / (d * load(p, base + Tir.WIDTH))
    dz = maximum(0.5 * d - height, 0.0)
    c, s, inclination = tire_frame(wy_S)
    L_h, b_t = footprint(p, base, dz, over_area)
    props = properties(p, base, model, dz, v_ST_S[2], L_h, b_t, over_area)
    F_z, k_x, k_y, k_psi = props[0], props[1], props[2], props[3]
    radius = maximum(0.5 * L_h + 0.25 * b_t, LEAST_RADIUS)
    over = 1.0 / (maximum(mu * F_z, LEAST_GRIP) * radius)
    over_grip = radius * over

    touch = minimum(F_z * (1.0 / TOUCH_LOAD), 1.0)  # the deck does not drag at a tire in the air
    v_x, v_y = carriage_velocity(contact, height, v_ST_S, w_SW_S, c, s)
    v_x, v_y = touch * v_x, touch * v_y
    motion = (v_x, v_y, touch * w_SW_S[2])
    free = free_rates(p, base, props, mu * F_z, over_grip, motion, inclination, d_y, psi, lock)
    dot_x, dot_y, dot_psi, standing, rolls = free

    # elastic forces, and what friction leaves of them
    E_x = lock * k_x * d_x
    E_y = k_y * d_y + standing
    E_psi = k_psi * psi
    D_x = lock * load(p, base + Tir.CX) * dot_x
    D_y = load(p, base + Tir.CY) * dot_y
    s_x, s_y, s_psi, damp_x, damp_y, use = friction_limit(
        friction, F_z, E_x * over_grip, E_y * over_grip, 1.5 * E_psi * over, D_x * over_grip, D_y * over_grip
    )
    F_y = s_y * E_y + damp_y * D_y  # (2.148)
    side = 2.0 * load(p, base + Tir.MU_AXLE) * load(p, base + Tir.AXLE_RADIUS) * (d * over_area)
    drag = (1.0 - lock) * rolls * (load(p, base + Tir.MU_RR) * F_z + side * fabs(F_y))  # (2.155), (2.156)
    braked = s_x * E_x + damp_x * D_x  # (2.154)
    F_x = braked + where(v_x < 0.0, drag, -drag)  # (2.157)

    # deflections within the limit: the stored ones are pulled towards them
    lim_x = lock * s_x * d_x
    lim_y = s_y * d_y - (1.0 - s_y) * standing / maximum(k_y, LEAST_STIFFNESS)
    lim_psi = s_psi * psi
    pull = load(p, base + Tir.PULL)
    rates = (dot_x - pull * (d_x - lim_x), dot_y - pull * (d_y - lim_y), dot_psi - pull * (psi - lim_psi))
    M_x = -0.8 * lim_y * F_z  # (2.158)
    M_y = load(p, base + Tir.MY_COEFF) * lim_x * F_z  # (2.159)
    F_S, M_S = wrench(r_WT_S, height, c, s, F_x, F_y, F_z, M_x, M_y, s_psi * E_psi)  # (2.151)
    return F_S, M_S, rates, (F_z, F_y, F_x, dz, lim_y, lim_x, lim_psi, use)
