"""Deck motion at one instant from the node table: quintic Hermite pieces, yaw-pitch-roll angles, body rates.

A piece between two nodes (position, rate, acceleration at both) is kept as six polynomial coefficients in the
time since its first node, so it is C2 across nodes and its derivatives are those of what it reports.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load
from ssmash_gym.dynamics.layout import Deck
from ssmash_gym.dynamics.maths import cos, sin
from ssmash_gym.dynamics.vectors import store3

COEFFICIENTS = 6  # of one channel's quintic


@kernel
def gather_piece(nodes: Any, column: int, piece: int, channels: int, spacing: float, c: Any, lane: int) -> None:
    """Fill column `lane` of the coefficient block from nodes ``piece`` and ``piece + 1`` of one helicopter.

    `nodes` is (helicopter, node, 3 * channels): values, rates, accelerations. Plain floats, any number of lanes.
    """
    h = spacing
    for k in range(channels):
        q0 = nodes[column, piece, k]
        v0 = nodes[column, piece, channels + k]
        a0 = nodes[column, piece, 2 * channels + k]
        q1 = nodes[column, piece + 1, k]
        v1 = nodes[column, piece + 1, channels + k]
        a1 = nodes[column, piece + 1, 2 * channels + k]
        dq = q1 - q0 - v0 * h - 0.5 * a0 * h * h
        dv = (v1 - v0 - a0 * h) * h
        da = (a1 - a0) * h * h
        row = COEFFICIENTS * k
        c[row, lane] = q0
        c[row + 1, lane] = v0
        c[row + 2, lane] = 0.5 * a0
        c[row + 3, lane] = (10.0 * dq - 4.0 * dv + 0.5 * da) / (h * h * h)
        c[row + 4, lane] = (-15.0 * dq + 7.0 * dv - da) / (h * h * h * h)
        c[row + 5, lane] = (6.0 * dq - 3.0 * dv + 0.5 * da) / (h * h * h * h * h)


@kernel
def quintic(c: Any, channel: int, t: Any) -> Any:
    """Value, rate and acceleration of one channel at time `t` [s] after the piece's first node."""
    row = COEFFICIENTS * channel
    c0 = load(c, row)
    c1 = load(c, row + 1)
    c2 = load(c, row + 2)
    c3 = load(c, row + 3)
    c4 = load(c, row + 4)
    c5 = load(c, row + 5)
    q = c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5))))
    v = c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * (5.0 * c5))))
    a = 2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * (20.0 * c5)))
    return (q, v, a)


@kernel
def deck_kinematics(c: Any, t: Any, d: Any) -> None:
    """Write the `Deck` rows at time `t` after the node: R_NS, w_NS_S, its rate, velocity, acceleration, angles."""
    x = quintic(c, 0, t)
    y = quintic(c, 1, t)
    z = quintic(c, 2, t)
    phi = quintic(c, 3, t)
    theta = quintic(c, 4, t)
    psi = quintic(c, 5, t)
    store3(d, Deck.V_NS_N, (x[1], y[1], z[1]))  # (2.19)
    store3(d, Deck.A_NS_N, (x[2], y[2], z[2]))  # (2.74)
    store3(d, Deck.ANGLES, (phi[0], theta[0], psi[0]))
    attitude(d, phi, theta, psi)


@kernel
def attitude(d: Any, phi: Any, theta: Any, psi: Any) -> None:
    """R_NS = Rz(psi) Ry(theta) Rx(phi) and the body rates (2.20) of these angles with their time derivatives."""
    sp = sin(phi[0])
    cp = cos(phi[0])
    st = sin(theta[0])
    ct = cos(theta[0])
    ss = sin(psi[0])
    cs = cos(psi[0])
    store3(d, Deck.R_NS, (cs * ct, cs * st * sp - ss * cp, cs * st * cp + ss * sp))
    store3(d, Deck.R_NS + 3, (ss * ct, ss * st * sp + cs * cp, ss * st * cp - cs * sp))
    store3(d, Deck.R_NS + 6, (-st, ct * sp, ct * cp))
    dphi = phi[1]
    dth = theta[1]
    dpsi = psi[1]
    store3(d, Deck.W_NS_S, (dphi - dpsi * st, dth * cp + dpsi * ct * sp, dpsi * ct * cp - dth * sp))  # (2.20)
    store3(
        d,
        Deck.WDOT_NS_S,  # (2.79)
        (
            phi[2] - psi[2] * st - dpsi * ct * dth,
            theta[2] * cp - dth * sp * dphi + psi[2] * ct * sp + dpsi * (ct * cp * dphi - st * sp * dth),
            psi[2] * ct * cp - dpsi * (st * cp * dth + ct * sp * dphi) - theta[2] * sp - dth * cp * dphi,
        ),
    )


@kernel
def prescribed_claw(c: Any, t: Any, d: Any) -> None:
    """Claw position and velocity in S from its own node table (three channels)."""
    x = quintic(c, 0, t)
    y = quintic(c, 1, t)
    z = quintic(c, 2, t)
    store3(d, Deck.C_CLAW_S, (x[0], y[0], z[0]))
    store3(d, Deck.V_CLAW_S, (x[1], y[1], z[1]))
