"""Four rigid bodies with twelve degrees of freedom on a prescribed ship: Kane's equations, solved as a tree.

The thesis writes the 12x12 system (2.112) with partial-velocity matrices. Here each joint pair (slide or swing,
steer) is a 2x2 block that hangs on the 6x6 of the helicopter: the pairs are eliminated, the 6x6 is solved by LDL'
without pivoting, and the pairs follow by back-substitution. Unknowns are u7'..u18' themselves; translation is
written in S axes, rotation in H axes. The mass matrix is positive definite (the thesis' [M] with its sign changed).
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, splat, store, where
from ssmash_gym.dynamics.layout import JOINT_ROWS, STATION_COORDINATES, STATIONS, Joint, Par, State, StationKind, Work
from ssmash_gym.dynamics.vectors import add, apply, apply_t, cross, dot, load3, matmul, scale, store3


@kernel
def symmetric(block: Any, row: int) -> Any:
    """3x3 tensor stored as (xx, xy, xz, yy, yz, zz)."""
    xx = load(block, row)
    xy = load(block, row + 1)
    xz = load(block, row + 2)
    yy = load(block, row + 3)
    yz = load(block, row + 4)
    zz = load(block, row + 5)
    return (xx, xy, xz, xy, yy, yz, xz, yz, zz)


@kernel
def rotate_tensor(R: Any, tensor: Any) -> Any:
    """``R I R^T``."""
    m = matmul(R, tensor)
    xx = m[0] * R[0] + m[1] * R[1] + m[2] * R[2]
    xy = m[0] * R[3] + m[1] * R[4] + m[2] * R[5]
    xz = m[0] * R[6] + m[1] * R[7] + m[2] * R[8]
    yy = m[3] * R[3] + m[4] * R[4] + m[5] * R[5]
    yz = m[3] * R[6] + m[4] * R[7] + m[5] * R[8]
    zz = m[6] * R[6] + m[7] * R[7] + m[8] * R[8]
    return (xx, xy, xz, xy, yy, yz, xz, yz, zz)


@kernel
def origin_acceleration(r_SH_S: Any, v_SH_S: Any, w_NS_S: Any, wdot_NS_S: Any, a_NS_S: Any) -> Any:
    """Inertial acceleration of the helicopter's c.g. in S axes for u7'..u9' = 0."""
    transport = add(cross(wdot_NS_S, r_SH_S), cross(w_NS_S, cross(w_NS_S, r_SH_S)))
    return add(add(a_NS_S, transport), scale(2.0, cross(w_NS_S, v_SH_S)))  # (2.88)


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
def clear_system(w: Any, zero: Any) -> None:
    """Zero the 6x6 and its right-hand side."""
    for k in range(Work.JOINT - Work.A):
        store(w, Work.A + k, zero)


@kernel
def store_joint(
    w: Any, p: Any, i: int, mass: Any, tensor_H: Any, axes: Any, r_HW_H: Any, f: Any, tau: Any, q1: Any, q2: Any,
    gc1: Any, gc2: Any,
) -> None:
    """Write the 2x2 block of station i (inverted), its coupling columns and its right-hand sides.

    `f`, `tau`: what is left on the carriage after its bias inertia, H axes; `q1`, `q2`: joint forces;
    `gc1`, `gc2`: gamma h C of the integrator. Locked speeds drop out (their acceleration comes out as zero).
    """
    v1, w1, v2, o_z = axes
    base = Work.JOINT + i * JOINT_ROWS
    keep1 = 1.0 - load(p, Par.LOCK + 6 + 2 * i)
    keep2 = 1.0 - load(p, Par.LOCK + 7 + 2 * i)
    h1 = apply(tensor_H, w1)
    h2 = apply(tensor_H, o_z)
    d11 = keep1 * (mass * dot(v1, v1) + dot(w1, h1) + gc1) + (1.0 - keep1)
    d22 = keep2 * (mass * dot(v2, v2) + dot(o_z, h2) + gc2) + (1.0 - keep2)
    d12 = keep1 * keep2 * (mass * dot(v1, v2) + dot(w1, h2))
    inverse = 1.0 / (d11 * d22 - d12 * d12)
    mv1 = scale(keep1 * mass, v1)
    mv2 = scale(keep2 * mass, v2)
    store3(w, base + Joint.B1, mv1)
    store3(w, base + Joint.B1 + 3, add(scale(keep1, h1), cross(r_HW_H, mv1)))
    store3(w, base + Joint.B2, mv2)
    store3(w, base + Joint.B2 + 3, add(scale(keep2, h2), cross(r_HW_H, mv2)))
    store(w, base + Joint.D11, d22 * inverse)
    store(w, base + Joint.D12, -d12 * inverse)
    store(w, base + Joint.D22, d11 * inverse)
    store(w, base + Joint.N1, keep1 * (dot(v1, f) + dot(w1, tau) + q1))
    store(w, base + Joint.N2, keep2 * (dot(v2, f) + dot(o_z, tau) + q2))


@kernel
def helicopter_block(w: Any, mass: Any, moment: Any, tensor: Any, f: Any, tau: Any) -> None:
    """Lower triangle of the composite 6x6 in H axes: total mass, first moment about the c.g., inertia; loads."""
    for k in range(3):
        store(w, Work.A + 7 * k, mass)
    store(w, Work.A + 19, -moment[2])  # rotation rows, translation columns: [c]
    store(w, Work.A + 20, moment[1])
    store(w, Work.A + 24, moment[2])
    store(w, Work.A + 26, -moment[0])
    store(w, Work.A + 30, -moment[1])
    store(w, Work.A + 31, moment[0])
    store(w, Work.A + 21, tensor[0])
    store(w, Work.A + 27, tensor[1])
    store(w, Work.A + 28, tensor[4])
    store(w, Work.A + 33, tensor[2])
    store(w, Work.A + 34, tensor[5])
    store(w, Work.A + 35, tensor[8])
    store3(w, Work.X, f)
    store3(w, Work.X + 3, tau)


@kernel
def eliminate_joints(w: Any) -> None:
    """Schur complement: subtract B D^-1 B^T and B D^-1 n of each joint pair from the 6x6 and its loads."""
    for i in range(STATIONS):
        base = Work.JOINT + i * JOINT_ROWS
        d11 = load(w, base + Joint.D11)
        d12 = load(w, base + Joint.D12)
        d22 = load(w, base + Joint.D22)
        n1 = load(w, base + Joint.N1)
        n2 = load(w, base + Joint.N2)
        for row in range(6):
            b1 = load(w, base + Joint.B1 + row)
            b2 = load(w, base + Joint.B2 + row)
            g1 = b1 * d11 + b2 * d12
            g2 = b1 * d12 + b2 * d22
            store(w, Work.X + row, load(w, Work.X + row) - (g1 * n1 + g2 * n2))
            for column in range(row + 1):
                k = Work.A + 6 * row + column
                product = g1 * load(w, base + Joint.B1 + column) + g2 * load(w, base + Joint.B2 + column)
                store(w, k, load(w, k) - product)


@kernel
def translation_to_ship_axes(w: Any, R_SH: Any) -> None:
    """Turn the translation rows and columns of the 6x6 and its loads from H to S axes."""
    a = Work.A
    tensor = (
        load(w, a), load(w, a + 6), load(w, a + 12),
        load(w, a + 6), load(w, a + 7), load(w, a + 13),
        load(w, a + 12), load(w, a + 13), load(w, a + 14),
    )
    turned = rotate_tensor(R_SH, tensor)
    store(w, a, turned[0])
    store(w, a + 6, turned[3])
    store(w, a + 7, turned[4])
    store(w, a + 12, turned[6])
    store(w, a + 13, turned[7])
    store(w, a + 14, turned[8])
    for row in range(3, 6):
        store3(w, a + 6 * row, apply(R_SH, load3(w, a + 6 * row)))
    store3(w, Work.X, apply(R_SH, load3(w, Work.X)))


@kernel
def hold_locked(w: Any, p: Any) -> None:
    """Drop the equations of locked u7..u12: unit diagonal, zero row, column and load."""
    for row in range(6):
        locked = load(p, Par.LOCK + row) > 0.5
        store(w, Work.X + row, where(locked, 0.0, load(w, Work.X + row)))
        for column in range(6):
            k = Work.A + 6 * row + column
            if column < row:
                store(w, k, where(locked | (load(p, Par.LOCK + column) > 0.5), 0.0, load(w, k)))
            if column == row:
                store(w, k, where(locked, 1.0, load(w, k)))


@kernel
def solve6(w: Any) -> None:
    """LDL' of the 6x6 in place (lower triangle) and its solution in the right-hand side."""
    for j in range(6):
        pivot = load(w, Work.A + 7 * j)
        for k in range(j):
            ljk = load(w, Work.A + 6 * j + k)
            pivot = pivot - ljk * ljk * load(w, Work.A + 7 * k)
        store(w, Work.A + 7 * j, pivot)
        inverse = 1.0 / pivot
        for i in range(j + 1, 6):
            value = load(w, Work.A + 6 * i + j)
            for k in range(j):
                value = value - (
                    load(w, Work.A + 6 * i + k) * load(w, Work.A + 6 * j + k) * load(w, Work.A + 7 * k)
                )
            store(w, Work.A + 6 * i + j, value * inverse)
    for i in range(6):
        value = load(w, Work.X + i)
        for k in range(i):
            value = value - load(w, Work.A + 6 * i + k) * load(w, Work.X + k)
        store(w, Work.X + i, value)
    for m in range(6):
        i = 5 - m
        value = load(w, Work.X + i) / load(w, Work.A + 7 * i)
        for k in range(i + 1, 6):
            value = value - load(w, Work.A + 6 * k + i) * load(w, Work.X + k)
        store(w, Work.X + i, value)


@kernel
def solve_accelerations(w: Any, p: Any, R_SH: Any, dy: Any) -> None:
    """u7'..u18' into the first rows of `dy`: eliminate, solve, substitute back."""
    eliminate_joints(w)
    translation_to_ship_axes(w, R_SH)
    hold_locked(w, p)
    solve6(w)  # (2.112)
    a_S = load3(w, Work.X)
    alpha = load3(w, Work.X + 3)
    store3(dy, State.U7, a_S)
    store3(dy, State.U10, alpha)
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
        store(dy, State.U13 + 2 * i, load(w, base + Joint.D11) * n1 + d12 * n2)
        store(dy, State.U14 + 2 * i, d12 * n1 + load(w, base + Joint.D22) * n2)


@kernel
def parameter_rates(y: Any, row: int, w: Any, dy: Any) -> None:
    """Rates of four Euler parameters from the angular velocity in the rotated frame."""
    e0 = load(y, row)
    e1 = load(y, row + 1)
    e2 = load(y, row + 2)
    e3 = load(y, row + 3)
    store(dy, row, 0.5 * (-e1 * w[0] - e2 * w[1] - e3 * w[2]))  # (2.32)
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
        zero = splat(0.0)
        if mode[i] == StationKind.PRISMATIC:
            store(dy, row, u1)  # (2.23)
            parameter_rates(y, row + 1, (zero, zero, u2), dy)  # (2.33)-(2.35)
        else:
            store(dy, row, zero)  # section 2.6: the distance is constant
            parameter_rates(y, row + 1, (zero, u1, u2), dy)  # (2.230)
