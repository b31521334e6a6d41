"""Four rigid bodies with twelve degrees of freedom on a prescribed ship: Kane's equations, solved as a tree.

The thesis writes the 12x12 system (2.112) with partial-velocity matrices. Here each joint pair (slide or swing,
steer) is a 2x2 block that hangs on the 6x6 of the helicopter: the pairs are eliminated, the 6x6 is solved by its 3x3
blocks without pivoting, and the pairs follow by back-substitution. Unknowns are u7'..u18' themselves; translation is
written in S axes, rotation in H axes. The mass matrix is positive definite (the thesis' [M] with its sign changed).
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, store
from ssmash_gym.dynamics.layout import JOINT_ROWS, STATION_COORDINATES, STATIONS, Joint, Par, State, StationKind, Work
from ssmash_gym.dynamics.vectors import add, apply, apply_t, cross, dot, load3, matmul, scale, store3, sub


@kernel
def load_tensor(block: Any, row: int) -> Any:
    """Symmetric 3x3 stored as (xx, xy, xz, yy, yz, zz)."""
    return (
        load(block, row), load(block, row + 1), load(block, row + 2), load(block, row + 3), load(block, row + 4),
        load(block, row + 5),
    )  # fmt: skip


@kernel
def rotate_tensor(R: Any, t: Any) -> Any:
    """``R I R^T`` of a symmetric 3x3 (xx, xy, xz, yy, yz, zz)."""
    m = matmul(R, (t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5]))
    return (
        m[0] * R[0] + m[1] * R[1] + m[2] * R[2],
        m[0] * R[3] + m[1] * R[4] + m[2] * R[5],
        m[0] * R[6] + m[1] * R[7] + m[2] * R[8],
        m[3] * R[3] + m[4] * R[4] + m[5] * R[5],
        m[3] * R[6] + m[4] * R[7] + m[5] * R[8],
        m[6] * R[6] + m[7] * R[7] + m[8] * R[8],
    )


@kernel
def origin_acceleration(r_SH_S: Any, v_SH_S: Any, w_NS_S: Any, wdot_NS_S: Any, a_NS_S: Any) -> Any:
    """Inertial acceleration of the helicopter's c.g. in S axes for u7'..u9' = 0."""
    transport = add(cross(wdot_NS_S, r_SH_S), cross(w_NS_S, cross(w_NS_S, r_SH_S)))
    return add(add(a_NS_S, transport), scale(2.0, cross(w_NS_S, v_SH_S)))  # (2.41), (2.88)


@kernel
def joint_axes(kind: int, R_HO: Any, r_OW_H: Any) -> Any:
    """Partial velocities of a station's two speeds in H axes: linear and angular of the first, linear of the second.

    The second speed always turns about o_z; its angular partial velocity is o_z itself.
    """
    o_y = (R_HO[1], R_HO[4], R_HO[7])
    o_z = (R_HO[2], R_HO[5], R_HO[8])
    zero = 0.0 * o_z[0]
    if kind == StationKind.PRISMATIC:
        first = o_z  # (2.231)
        spin = (zero, zero, zero)  # (2.233)
    else:
        first = cross(o_y, r_OW_H)  # (2.232)
        spin = o_y  # (2.234)
    return (first, spin, cross(o_z, r_OW_H), o_z)


@kernel
def carriage_bias(specific: Any, alpha: Any, w_NH_H: Any, r_HW_H: Any, r_OW_H: Any, w_HO_H: Any, v_rel: Any) -> Any:
    """Acceleration of a carriage's c.g. in H axes for zero generalized accelerations of the helicopter and joints.

    `specific` and `alpha` are those of the helicopter frame under the same condition.
    """
    transport = add(cross(alpha, r_HW_H), cross(w_NH_H, cross(w_NH_H, r_HW_H)))
    relative = add(cross(w_HO_H, cross(w_HO_H, r_OW_H)), scale(2.0, cross(w_NH_H, v_rel)))
    return add(specific, add(transport, relative))  # (2.90)


@kernel
def symmetric_inverse(t: Any) -> Any:
    """Inverse of a symmetric positive-definite 3x3 (xx, xy, xz, yy, yz, zz), the same form, by cofactors."""
    xx, xy, xz, yy, yz, zz = t
    c0 = yy * zz - yz * yz
    c1 = xz * yz - xy * zz
    c2 = xy * yz - xz * yy
    inverse = 1.0 / (xx * c0 + xy * c1 + xz * c2)
    return (
        c0 * inverse, c1 * inverse, c2 * inverse,
        (xx * zz - xz * xz) * inverse, (xy * xz - xx * yz) * inverse, (xx * yy - xy * xy) * inverse,
    )  # fmt: skip


@kernel
def symmetric_apply(t: Any, v: Any) -> Any:
    """Product of a symmetric 3x3 (xx, xy, xz, yy, yz, zz) and a vector."""
    return (
        t[0] * v[0] + t[1] * v[1] + t[2] * v[2],
        t[1] * v[0] + t[3] * v[1] + t[4] * v[2],
        t[2] * v[0] + t[4] * v[1] + t[5] * v[2],
    )


@kernel
def add6(a: Any, b: Any) -> Any:
    """Sum of two symmetric 3x3."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5])


@kernel
def add9(a: Any, b: Any) -> Any:
    """Sum of two 3x3."""
    return (
        a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5], a[6] + b[6], a[7] + b[7],
        a[8] + b[8],
    )  # fmt: skip


@kernel
def symmetric_outer(a: Any, b: Any, c: Any, d: Any) -> Any:
    """``a b^T + c d^T`` where that is symmetric."""
    return (
        a[0] * b[0] + c[0] * d[0], a[0] * b[1] + c[0] * d[1], a[0] * b[2] + c[0] * d[2],
        a[1] * b[1] + c[1] * d[1], a[1] * b[2] + c[1] * d[2], a[2] * b[2] + c[2] * d[2],
    )  # fmt: skip


@kernel
def outer(a: Any, b: Any, c: Any, d: Any) -> Any:
    """``a b^T + c d^T``."""
    return (
        a[0] * b[0] + c[0] * d[0], a[0] * b[1] + c[0] * d[1], a[0] * b[2] + c[0] * d[2],
        a[1] * b[0] + c[1] * d[0], a[1] * b[1] + c[1] * d[1], a[1] * b[2] + c[1] * d[2],
        a[2] * b[0] + c[2] * d[0], a[2] * b[1] + c[2] * d[1], a[2] * b[2] + c[2] * d[2],
    )  # fmt: skip


@kernel
def body_block(mass: Any, t: Any, r: Any, f: Any, tau: Any) -> Any:
    """A body's share of the 6x6 about the helicopter's c.g., H axes, and of its loads.

    Args:
        mass: its mass.
        t: its inertia (xx, xy, xz, yy, yz, zz) in H axes.
        r: position of its c.g. from the helicopter's, H axes.
        f: force that is left after the bias inertia.
        tau: moment about its own c.g. that is left after the bias inertia.

    Returns:
        ``(A_tt (6), A_rt (9), A_rr (6), f, tau)``; rows t are translation, rows r rotation.
    """
    zero = 0.0 * mass
    mx, my, mz = mass * r[0], mass * r[1], mass * r[2]
    xx, yy, zz = mx * r[0], my * r[1], mz * r[2]
    a_rt = (zero, -mz, my, mz, zero, -mx, -my, mx, zero)
    a_rr = (
        t[0] + yy + zz, t[1] - mx * r[1], t[2] - mx * r[2], t[3] + xx + zz, t[4] - my * r[2], t[5] + xx + yy,
    )  # fmt: skip
    return ((mass, zero, zero, mass, zero, mass), a_rt, a_rr, f, add(tau, cross(r, f)))  # (2.107), (2.108)


@kernel
def add_blocks(a: Any, b: Any) -> Any:
    """Sum of two such shares."""
    return (add6(a[0], b[0]), add9(a[1], b[1]), add6(a[2], b[2]), add(a[3], b[3]), add(a[4], b[4]))


@kernel
def eliminate_joint(
    w: Any, p: Any, i: int, block: Any, mass: Any, t: Any, axes: Any, r_HW_H: Any, f: Any, tau: Any, joint: Any
) -> Any:
    """Take the joint pair of station i out of its carriage's `block`: subtract B D^-1 B^T and B D^-1 n.

    What the back-substitution needs is kept in `w`. `joint` = (q1, q2, gc1, gc2): joint forces and gamma h C of the
    integrator. Locked speeds drop out (their acceleration comes out as zero).
    """
    v1, w1, v2, o_z = axes
    q1, q2, gc1, gc2 = joint
    keep1 = 1.0 - load(p, Par.LOCK + 6 + 2 * i)
    keep2 = 1.0 - load(p, Par.LOCK + 7 + 2 * i)
    h1 = symmetric_apply(t, w1)
    h2 = symmetric_apply(t, o_z)
    d11 = keep1 * (mass * dot(v1, v1) + dot(w1, h1) + gc1) + (1.0 - keep1)
    d22 = keep2 * (mass * dot(v2, v2) + dot(o_z, h2) + gc2) + (1.0 - keep2)
    d12 = keep1 * keep2 * (mass * dot(v1, v2) + dot(w1, h2))
    inverse = 1.0 / (d11 * d22 - d12 * d12)
    e11 = d22 * inverse
    e12 = -(d12 * inverse)
    e22 = d11 * inverse
    n1 = keep1 * (dot(v1, f) + dot(w1, tau) + q1)
    n2 = keep2 * (dot(v2, f) + dot(o_z, tau) + q2)
    b1t = scale(keep1 * mass, v1)
    b2t = scale(keep2 * mass, v2)
    b1r = add(scale(keep1, h1), cross(r_HW_H, b1t))
    b2r = add(scale(keep2, h2), cross(r_HW_H, b2t))
    keep_joint(w, i, (b1t, b1r, b2t, b2r), (e11, e12, e22, n1, n2))
    g1t = combine(-e11, b1t, -e12, b2t)
    g2t = combine(-e12, b1t, -e22, b2t)
    g1r = combine(-e11, b1r, -e12, b2r)
    g2r = combine(-e12, b1r, -e22, b2r)
    share = (
        symmetric_outer(g1t, b1t, g2t, b2t),
        outer(g1r, b1t, g2r, b2t),
        symmetric_outer(g1r, b1r, g2r, b2r),
        combine(n1, g1t, n2, g2t),
        combine(n1, g1r, n2, g2r),
    )
    return add_blocks(block, share)


@kernel
def combine(a: Any, u: Any, b: Any, v: Any) -> Any:
    """``a u + b v``."""
    return (a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2])


@kernel
def keep_joint(w: Any, i: int, columns: Any, numbers: Any) -> None:
    """Store a joint pair's coupling columns, inverse block and right-hand sides for the back-substitution."""
    base = Work.JOINT + i * JOINT_ROWS
    store3(w, base + Joint.B1, columns[0])
    store3(w, base + Joint.B1 + 3, columns[1])
    store3(w, base + Joint.B2, columns[2])
    store3(w, base + Joint.B2 + 3, columns[3])
    store(w, base + Joint.D11, numbers[0])
    store(w, base + Joint.D12, numbers[1])
    store(w, base + Joint.D22, numbers[2])
    store(w, base + Joint.N1, numbers[3])
    store(w, base + Joint.N2, numbers[4])


@kernel
def to_ship_axes(R: Any, block: Any) -> Any:
    """Turn the translation rows and columns of the 6x6 and its force from H to S axes; ``R = R_SH``."""
    c = block[1]
    r0 = apply(R, (c[0], c[1], c[2]))
    r1 = apply(R, (c[3], c[4], c[5]))
    r2 = apply(R, (c[6], c[7], c[8]))
    a_rt = (r0[0], r0[1], r0[2], r1[0], r1[1], r1[2], r2[0], r2[1], r2[2])
    return (rotate_tensor(R, block[0]), a_rt, block[2], apply(R, block[3]), block[4])


@kernel
def hold_locked(p: Any, block: Any) -> Any:
    """Drop the equations of locked u7..u12: unit diagonal, zero row, column and load."""
    t0 = 1.0 - load(p, Par.LOCK)
    t1 = 1.0 - load(p, Par.LOCK + 1)
    t2 = 1.0 - load(p, Par.LOCK + 2)
    r0 = 1.0 - load(p, Par.LOCK + 3)
    r1 = 1.0 - load(p, Par.LOCK + 4)
    r2 = 1.0 - load(p, Par.LOCK + 5)
    a, c, d, f, tau = block
    a_tt = (
        t0 * a[0] + (1.0 - t0), t0 * t1 * a[1], t0 * t2 * a[2],
        t1 * a[3] + (1.0 - t1), t1 * t2 * a[4], t2 * a[5] + (1.0 - t2),
    )  # fmt: skip
    a_rt = (
        r0 * t0 * c[0], r0 * t1 * c[1], r0 * t2 * c[2], r1 * t0 * c[3], r1 * t1 * c[4], r1 * t2 * c[5],
        r2 * t0 * c[6], r2 * t1 * c[7], r2 * t2 * c[8],
    )  # fmt: skip
    a_rr = (
        r0 * d[0] + (1.0 - r0), r0 * r1 * d[1], r0 * r2 * d[2],
        r1 * d[3] + (1.0 - r1), r1 * r2 * d[4], r2 * d[5] + (1.0 - r2),
    )  # fmt: skip
    return (a_tt, a_rt, a_rr, (t0 * f[0], t1 * f[1], t2 * f[2]), (r0 * tau[0], r1 * tau[1], r2 * tau[2]))


@kernel
def solve6(block: Any) -> Any:
    """Solution (translation, rotation) of the 6x6 by 3x3 blocks; two divisions, short chains."""
    a_tt, c, a_rr, f, tau = block
    inverse = symmetric_inverse(a_tt)
    g0 = symmetric_apply(inverse, (c[0], c[1], c[2]))  # rows of A_rt A_tt^-1
    g1 = symmetric_apply(inverse, (c[3], c[4], c[5]))
    g2 = symmetric_apply(inverse, (c[6], c[7], c[8]))
    schur = (
        a_rr[0] - (g0[0] * c[0] + g0[1] * c[1] + g0[2] * c[2]),
        a_rr[1] - (g0[0] * c[3] + g0[1] * c[4] + g0[2] * c[5]),
        a_rr[2] - (g0[0] * c[6] + g0[1] * c[7] + g0[2] * c[8]),
        a_rr[3] - (g1[0] * c[3] + g1[1] * c[4] + g1[2] * c[5]),
        a_rr[4] - (g1[0] * c[6] + g1[1] * c[7] + g1[2] * c[8]),
        a_rr[5] - (g2[0] * c[6] + g2[1] * c[7] + g2[2] * c[8]),
    )
    load_r = (tau[0] - dot(g0, f), tau[1] - dot(g1, f), tau[2] - dot(g2, f))
    rotation = symmetric_apply(symmetric_inverse(schur), load_r)
    rest = sub(f, apply_t(c, rotation))
    return (symmetric_apply(inverse, rest), rotation)


@kernel
def solve_accelerations(w: Any, p: Any, R_SH: Any, block: Any, dy: Any) -> None:
    """u7'..u18' into the first rows of `dy` from the helicopter's 6x6 after the elimination of the joints."""
    solution = solve6(hold_locked(p, to_ship_axes(R_SH, block)))  # (2.112)
    a_S = solution[0]
    alpha = solution[1]
    store3(dy, State.U7, a_S)  # (2.75)
    store3(dy, State.U10, alpha)  # (2.80)
    a_H = apply_t(R_SH, a_S)
    for i in range(STATIONS):
        base = Work.JOINT + i * JOINT_ROWS
        n1 = load(w, base + Joint.N1) - (
            dot(load3(w, base + Joint.B1), a_H) + dot(load3(w, base + Joint.B1 + 3), alpha)
        )
        n2 = load(w, base + Joint.N2) - (
            dot(load3(w, base + Joint.B2), a_H) + dot(load3(w, base + Joint.B2 + 3), alpha)
        )
        d12 = load(w, base + Joint.D12)
        store(dy, State.U13 + 2 * i, load(w, base + Joint.D11) * n1 + d12 * n2)  # (2.76)-(2.78)
        store(dy, State.U14 + 2 * i, d12 * n1 + load(w, base + Joint.D22) * n2)  # (2.81)-(2.83)


@kernel
def parameter_rates(y: Any, row: int, w: Any, dy: Any) -> None:
    """Rates of four Euler parameters from the angular velocity in the rotated frame."""
    e0 = load(y, row)
    e1 = load(y, row + 1)
    e2 = load(y, row + 2)
    e3 = load(y, row + 3)
    store(dy, row, 0.5 * (-e1 * w[0] - e2 * w[1] - e3 * w[2]))  # (2.29), (2.30), (2.32)
    store(dy, row + 1, 0.5 * (e0 * w[0] - e3 * w[1] + e2 * w[2]))
    store(dy, row + 2, 0.5 * (e3 * w[0] + e0 * w[1] - e1 * w[2]))
    store(dy, row + 3, 0.5 * (-e2 * w[0] + e1 * w[1] + e0 * w[2]))


@kernel
def coordinate_rates(y: Any, mode: Any, dy: Any) -> None:
    """q8'..q29' from the generalized speeds."""
    store3(dy, State.Q8, load3(y, State.U7))  # (2.21)
    parameter_rates(y, State.Q11, load3(y, State.U10), dy)
    for i in range(STATIONS):
        u1 = load(y, State.U13 + 2 * i)
        u2 = load(y, State.U14 + 2 * i)
        row = State.Q15 + STATION_COORDINATES * i
        zero = 0.0 * u2
        if mode[i] == StationKind.PRISMATIC:
            store(dy, row, u1)  # (2.23)
            parameter_rates(y, row + 1, (zero, zero, u2), dy)  # (2.33)-(2.35)
        else:
            store(dy, row, zero)  # section 2.6: the distance is constant
            parameter_rates(y, row + 1, (zero, u1, u2), dy)  # (2.230)
