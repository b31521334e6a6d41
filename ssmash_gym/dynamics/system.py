"""The whole right-hand side: forces of every element, then the equations of motion of section 2.4.

`rates` is what every integrator calls. With ``gh = 0`` it is the plain right-hand side; with ``gh = gamma h`` it is
a stage of the linearly implicit scheme, in which the mass matrix is ``M + gamma h C`` (C: secant slopes of the joint
dissipation, measured in the first stage and kept for the second).
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.aero import wind
from ssmash_gym.dynamics.channels import STATION_OUT, STATION_OUT_ROWS, Out, StaOut
from ssmash_gym.dynamics.lane import fabs, kernel, load, maximum, splat, sqrt, store, where
from ssmash_gym.dynamics.layout import (
    JOINT_ROWS,
    STATION_COORDINATES,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    TIRE_STATES,
    Deck,
    Joint,
    Mode,
    Par,
    Spring,
    Sta,
    State,
    StationKind,
    Tir,
    Work,
)
from ssmash_gym.dynamics.maths import asin, atan2
from ssmash_gym.dynamics.oleo import bearing_load, gas_oleo
from ssmash_gym.dynamics.patch import patch_factor
from ssmash_gym.dynamics.probe import probe
from ssmash_gym.dynamics.rigid_body import (
    add_blocks,
    body_block,
    carriage_bias,
    coordinate_rates,
    eliminate_joint,
    joint_axes,
    load_tensor,
    origin_acceleration,
    rotate_tensor,
    solve_accelerations,
    symmetric_apply,
)
from ssmash_gym.dynamics.steering import play_moment, steer_moment
from ssmash_gym.dynamics.suspension import linear_strut, strut_geometry
from ssmash_gym.dynamics.tire import tire
from ssmash_gym.dynamics.vectors import (
    add,
    apply,
    apply_t,
    cross,
    dot,
    load3,
    matmul,
    rotation,
    scale,
    store3,
    sub,
)


@kernel
def rates(y: Any, p: Any, d: Any, mode: Any, first: Any, dy: Any, o: Any, w: Any, gh: float, second: int) -> None:
    """Write the rates of the integrated rows of state `y` to `dy` and the outputs to `o`.

    Blocks (row, lane): `y` `State`, `p` `Par`/`Sta`/`Tir`, `d` `Deck`, `w` `Work` scratch; `mode` plain integers.
    `second` is 1 in the second stage of the implicit scheme: `first` then holds the first stage's rates, and `w`
    its slopes.
    """
    R_NS = (
        load(d, Deck.R_NS),
        load(d, Deck.R_NS + 1),
        load(d, Deck.R_NS + 2),
        load(d, Deck.R_NS + 3),
        load(d, Deck.R_NS + 4),
        load(d, Deck.R_NS + 5),
        load(d, Deck.R_NS + 6),
        load(d, Deck.R_NS + 7),
        load(d, Deck.R_NS + 8),
    )
    R_SH = rotation(load(y, State.Q11), load(y, State.Q12), load(y, State.Q13), load(y, State.Q14))
    w_NS_S = load3(d, Deck.W_NS_S)
    r_SH_S = load3(y, State.Q8)
    v_SH_S = load3(y, State.U7)
    w_SH_H = load3(y, State.U10)
    w_NS_H = apply_t(R_SH, w_NS_S)
    w_NH_H = add(w_NS_H, w_SH_H)  # (2.56)

    a_NS_S = apply_t(R_NS, load3(d, Deck.A_NS_N))
    g_S = scale(load(p, Par.GRAVITY), (R_NS[6], R_NS[7], R_NS[8]))
    bias_S = origin_acceleration(r_SH_S, v_SH_S, w_NS_S, load3(d, Deck.WDOT_NS_S), a_NS_S)
    specific = apply_t(R_SH, sub(bias_S, g_S))  # (2.221), (2.222): weight as an acceleration
    alpha = add(apply_t(R_SH, load3(d, Deck.WDOT_NS_S)), cross(w_NS_H, w_SH_H))  # (2.58), (2.89)
    store3(o, Out.DECK_FX, sub(a_NS_S, g_S))
    store3(o, Out.DECK_WX, w_NS_S)

    mass = load(p, Par.MASS)
    tensor = load_tensor(p, Par.IXX)
    load_H = body_loads(y, p, d, mode, o, R_NS, R_SH, w_NS_S, w_NH_H)
    f = sub(load_H[0], scale(mass, specific))  # (2.101)
    gyroscopic = cross(w_NH_H, symmetric_apply(tensor, w_NH_H))
    tau = sub(sub(load_H[1], symmetric_apply(tensor, alpha)), gyroscopic)  # (2.102)
    zero = 0.0 * mass
    block = body_block(mass, tensor, (zero, zero, zero), f, tau)
    for i in range(STATIONS):
        block = add_blocks(block, station(y, p, mode, first, dy, o, w, i, gh, second, R_SH, specific, alpha, w_NH_H))
    solve_accelerations(w, p, R_SH, block, dy)
    coordinate_rates(y, mode, dy)


@kernel
def body_loads(y: Any, p: Any, d: Any, mode: Any, o: Any, R_NS: Any, R_SH: Any, w_NS_S: Any, w_NH_H: Any) -> Any:
    """Force and moment about the c.g. on the helicopter body, H axes: probe, wind, external wrench."""
    r_SH_S = load3(y, State.Q8)
    v_SH_S = load3(y, State.U7)
    held = probe(
        p,
        mode[Mode.PROBE_LAW],
        R_SH,
        r_SH_S,
        v_SH_S,
        load3(y, State.U10),
        load3(d, Deck.C_CLAW_S),
        load3(d, Deck.V_CLAW_S),
        load(y, State.PROBE_CAPTURED),
    )
    reads = held[2]
    store3(o, Out.PROBE_FX, held[0])
    store(o, Out.PROBE_IN_PLANE, reads[0])
    store(o, Out.PROBE_AXIAL, reads[1])
    store(o, Out.PROBE_DX, reads[2])
    store(o, Out.PROBE_DY, reads[3])
    store(o, Out.PROBE_EXTENSION, reads[4])
    store(o, Out.PROBE_X, reads[5])
    store(o, Out.PROBE_Y, reads[6])
    store(o, Out.PROBE_REACH, reads[7])

    r_HCP_H = load3(p, Par.CP)
    v_NS_S = apply_t(R_NS, load3(d, Deck.V_NS_N))
    v_NH_S = add(v_NS_S, add(v_SH_S, cross(w_NS_S, r_SH_S)))  # (2.38)
    v_NCP_H = add(apply_t(R_SH, v_NH_S), cross(w_NH_H, r_HCP_H))  # (2.197)-(2.200)
    R_NH = matmul(R_NS, R_SH)
    f_wind = wind(p, load3(d, Deck.WIND), R_NH, v_NCP_H)
    store3(o, Out.WIND_FX, f_wind)

    force = add(add(held[0], f_wind), load3(p, Par.WRENCH_H))  # (2.223)
    moment = add(add(held[1], cross(r_HCP_H, f_wind)), load3(p, Par.WRENCH_H + 3))  # (2.224)
    return (force, moment)


@kernel
def station(
    y: Any,
    p: Any,
    mode: Any,
    first: Any,
    dy: Any,
    o: Any,
    w: Any,
    i: int,
    gh: float,
    second: int,
    R_SH: Any,
    specific: Any,
    alpha: Any,
    w_NH_H: Any,
) -> Any:
    """One suspension station: tires, strut, steering; writes its joint block and tire rates.

    Returns its share of the helicopter's 6x6 and loads, joints eliminated.
    """
    base = Par.STATION + i * STATION_ROWS
    row = State.Q15 + STATION_COORDINATES * i
    u1 = load(y, State.U13 + 2 * i)
    u2 = load(y, State.U14 + 2 * i)
    R_HO = rotation(load(y, row + 1), load(y, row + 2), load(y, row + 3), load(y, row + 4))
    r_OW_O = (load(p, base + Sta.DROOP), load(p, base + Sta.DROOP + 1), load(y, row))
    r_OW_H = apply(R_HO, r_OW_O)
    r_HW_H = add(load3(p, base + Sta.MOUNT), r_OW_H)
    axes = joint_axes(mode[Mode.STATION_KIND + i], R_HO, r_OW_H)
    w_HO_H = add(scale(u1, axes[1]), scale(u2, axes[3]))  # (2.227), (2.230)
    v_OW_H = add(scale(u1, axes[0]), scale(u2, axes[2]))  # (2.228), (2.229)
    w_NW_H = add(w_NH_H, w_HO_H)  # (2.61)

    mass = load(p, base + Sta.MASS)
    tensor = rotate_tensor(R_HO, load_tensor(p, base + Sta.IXX))
    a_W = carriage_bias(specific, alpha, w_NH_H, r_HW_H, r_OW_H, w_HO_H, v_OW_H)  # (2.51)
    alpha_W = add(alpha, cross(w_NH_H, w_HO_H))  # (2.63), (2.91)

    ground = wheel_loads(y, p, mode, dy, o, i, R_SH, R_HO, r_HW_H, w_HO_H, v_OW_H)
    wrench = Par.WRENCH_W + 6 * i
    force = add(ground[0], apply(R_HO, load3(p, wrench)))  # (2.225)
    torque = add(ground[1], apply(R_HO, load3(p, wrench + 3)))  # (2.226)
    joint = joint_forces(y, p, mode, o, i, R_HO, r_OW_O, ground, axes, w_HO_H)

    f = sub(force, scale(mass, a_W))  # (2.103)
    gyroscopic = cross(w_NW_H, symmetric_apply(tensor, w_NW_H))
    tau = sub(sub(torque, symmetric_apply(tensor, alpha_W)), gyroscopic)  # (2.104)
    implicit = implicit_slopes(w, first, i, gh, second, joint)
    block = body_block(mass, tensor, r_HW_H, f, tau)
    return eliminate_joint(w, p, i, block, mass, tensor, axes, r_HW_H, f, tau, implicit)


@kernel
def implicit_slopes(w: Any, first: Any, i: int, gh: float, second: int, joint: Any) -> Any:
    """The joint forces, with the second stage's 2 gamma h C a1, and gamma h C of the two joint speeds."""
    q1, q2, c1, c2 = joint
    base = Work.JOINT + i * JOINT_ROWS
    if second:
        gc1 = gh * load(w, base + Joint.C1)
        gc2 = gh * load(w, base + Joint.C2)
        q1 = q1 + 2.0 * gc1 * load(first, State.U13 + 2 * i)
        q2 = q2 + 2.0 * gc2 * load(first, State.U14 + 2 * i)
    else:
        store(w, base + Joint.C1, c1)
        store(w, base + Joint.C2, c2)
        gc1 = gh * c1
        gc2 = gh * c2
    return (q1, q2, gc1, gc2)


@kernel
def wheel_loads(
    y: Any, p: Any, mode: Any, dy: Any, o: Any, i: int, R_SH: Any, R_HO: Any, r_HW_H: Any, w_HO_H: Any, v_OW_H: Any
) -> Any:
    """Force and moment of a station's tires about its carriage origin, H axes; horizontal load for the steering.

    Returns (force_H, moment_H, sqrt(Fx^2 + Fy^2)). Tire rates go to `dy`, station outputs to `o`.
    """
    base = Par.STATION + i * STATION_ROWS
    w_SH_H = load3(y, State.U10)
    R_SO = matmul(R_SH, R_HO)
    r_SW_S = add(load3(y, State.Q8), apply(R_SH, r_HW_H))
    v_SW_S = add(load3(y, State.U7), apply(R_SH, add(cross(w_SH_H, r_HW_H), v_OW_H)))  # (2.47)
    w_SW_S = apply(R_SH, add(w_SH_H, w_HO_H))
    wy_S = (R_SO[1], R_SO[4], R_SO[7])
    lock = load(p, base + Sta.ROLL_LOCK)
    zero = 0.0 * lock
    force = (zero, zero, zero)
    moment = (zero, zero, zero)
    total = (zero, zero, zero, zero, zero, zero, zero, zero)  # fz, fy, fx, then means of dz, d_y, d_x, psi, contact x
    contact_y = zero
    peaks = (zero, zero, zero, zero, zero)  # of the tire that has most: dz, d_y, d_x, psi, share of friction in use
    count = mode[Mode.TIRES + i]
    share = 1.0 / max(count, 1)
    for k in range(count):
        t = 2 * i + k
        row = State.TIRE + TIRE_STATES * t
        tbase = TIRE_PAR + t * TIRE_ROWS
        r_WT_S = apply(R_SO, load3(p, tbase))
        v_ST_S = add(v_SW_S, cross(w_SW_S, r_WT_S))
        height = -(r_SW_S[2] + r_WT_S[2])
        mu = load(p, tbase + Tir.MU)
        if mode[Mode.PATCH]:
            mu = mu * patch_factor(p, r_SW_S[0] + r_WT_S[0], r_SW_S[1] + r_WT_S[1])
        result = tire(
            p, tbase, mode[Mode.TIRE_MODEL], mode[Mode.FRICTION], mode[Mode.CONTACT], r_WT_S, height, v_ST_S, w_SW_S,
            wy_S, load(y, row), load(y, row + 1), load(y, row + 2), lock, mu,
        )  # fmt: skip
        force = add(force, result[0])
        moment = add(moment, result[1])
        store3(dy, row, result[2])
        fz, fy, fx, dz, d_y, d_x, psi, use = result[3]
        total = (
            total[0] + fz,
            total[1] + fy,
            total[2] + fx,
            total[3] + share * maximum(dz, 0.0),
            total[4] + share * d_y,
            total[5] + share * d_x,
            total[6] + share * psi,
            total[7] + share * (r_SW_S[0] + r_WT_S[0]),
        )
        contact_y = contact_y + share * (r_SW_S[1] + r_WT_S[1])
        peaks = larger(peaks, (dz, d_y, d_x, psi, use))
    write_wheel_outputs(o, i, total, contact_y, peaks)
    horizontal = sqrt(total[1] * total[1] + total[2] * total[2])
    return (apply_t(R_SH, force), apply_t(R_SH, moment), horizontal)


@kernel
def larger(a: Any, b: Any) -> Any:
    """Element by element that of the larger magnitude, with its sign."""
    return (
        where(fabs(b[0]) > fabs(a[0]), b[0], a[0]),
        where(fabs(b[1]) > fabs(a[1]), b[1], a[1]),
        where(fabs(b[2]) > fabs(a[2]), b[2], a[2]),
        where(fabs(b[3]) > fabs(a[3]), b[3], a[3]),
        where(fabs(b[4]) > fabs(a[4]), b[4], a[4]),
    )


@kernel
def write_wheel_outputs(o: Any, i: int, total: Any, contact_y: Any, peaks: Any) -> None:
    """Station outputs of the tires; order of `total` and `peaks` as in `wheel_loads`."""
    out = STATION_OUT + i * STATION_OUT_ROWS
    store(o, out + StaOut.VERTICAL_LOAD, total[0])
    store(o, out + StaOut.LATERAL_LOAD, total[1])
    store(o, out + StaOut.LONGITUDINAL_LOAD, total[2])
    store(o, out + StaOut.TIRE_VERTICAL_DEFLECTION, total[3])
    store(o, out + StaOut.TIRE_LATERAL_DEFLECTION, total[4])
    store(o, out + StaOut.TIRE_LONGITUDINAL_DEFLECTION, total[5])
    store(o, out + StaOut.TIRE_TWIST, total[6])
    store(o, out + StaOut.CONTACT_X, total[7])
    store(o, out + StaOut.CONTACT_Y, contact_y)
    store(o, out + StaOut.TIRE_VERTICAL_DEFLECTION_LARGEST, peaks[0])
    store(o, out + StaOut.TIRE_LATERAL_DEFLECTION_LARGEST, peaks[1])
    store(o, out + StaOut.TIRE_LONGITUDINAL_DEFLECTION_LARGEST, peaks[2])
    store(o, out + StaOut.TIRE_TWIST_LARGEST, peaks[3])
    store(o, out + StaOut.FRICTION_USE, peaks[4])


@kernel
def joint_forces(
    y: Any, p: Any, mode: Any, o: Any, i: int, R_HO: Any, r_OW_O: Any, ground: Any, axes: Any, w_HO_H: Any
) -> Any:
    """Generalized forces on the two joint speeds and their dissipation slopes: strut and steering."""
    base = Par.STATION + i * STATION_ROWS
    spring = mode[Mode.SPRING + i]
    u2 = load(y, State.U14 + 2 * i)
    zero = 0.0 * u2
    steer = steer_moment(p, base, u2, ground[2])
    if mode[Mode.STATION_KIND + i] == StationKind.PRISMATIC:
        x = load(p, base + Sta.DROOP + 2) - r_OW_O[2]
        v = -load(y, State.U13 + 2 * i)
        lever1 = 1.0 + zero
        lever2 = zero
        arm = (r_OW_O[0], r_OW_O[1], r_OW_O[2] - load(p, base + Sta.BEARING_Z))
        applied = add(cross(arm, apply_t(R_HO, ground[0])), apply_t(R_HO, ground[1]))  # (2.214)
        normal = bearing_load(p, base, x, sqrt(applied[0] * applied[0] + applied[1] * applied[1]))
        if mode[Mode.PLAY + i]:
            row = State.Q15 + STATION_COORDINATES * i + 1
            play = play_moment(p, base, load(y, row), load(y, row + 3), u2)
            steer = (steer[0] + play[0], steer[1] + play[1])
    else:
        strut = strut_geometry(p, base, R_HO)
        x = load(p, base + Sta.LENGTH) - strut[0]
        v = -dot(strut[1], cross(w_HO_H, strut[2]))  # (2.236), (2.237)
        lever1 = dot(strut[1], cross(axes[1], strut[2]))
        lever2 = dot(strut[1], cross(axes[3], strut[2]))
        normal = zero
    if spring == Spring.GAS_OLEO:
        force, slope = gas_oleo(p, base, x, v, normal)
    elif spring == Spring.LINEAR:
        force, slope = linear_strut(p, base, x, v)
    else:
        force, slope = zero, zero
    out = STATION_OUT + i * STATION_OUT_ROWS
    store(o, out + StaOut.COMPRESSION, x)
    store(o, out + StaOut.COMPRESSION_RATE, v)
    store(o, out + StaOut.OLEO_FORCE, force)
    q1 = force * lever1  # (2.220), (2.238)-(2.241) as work on the joint
    q2 = force * lever2 + steer[0]
    return (q1, q2, slope * lever1 * lever1, slope * lever2 * lever2 + steer[1])


@kernel
def attitude_outputs(y: Any, d: Any, o: Any) -> None:
    """Outputs that only telemetry needs: relative angles, steer angles, claw, deck angles."""
    R = rotation(load(y, State.Q11), load(y, State.Q12), load(y, State.Q13), load(y, State.Q14))
    store(o, Out.ROLL, atan2(R[7], R[8]))
    store(o, Out.PITCH, -asin(R[6]))
    store(o, Out.YAW, atan2(R[3], R[0]))
    for i in range(STATIONS):
        row = State.Q15 + STATION_COORDINATES * i + 1
        e0 = load(y, row)
        e3 = load(y, row + 3)
        flip = where(e0 < 0.0, splat(-1.0), splat(1.0))
        out = STATION_OUT + i * STATION_OUT_ROWS
        store(o, out + StaOut.STEER, 2.0 * atan2(flip * e3, flip * e0))
    for k in range(2):
        store(o, Out.CLAW_X + k, load(d, Deck.C_CLAW_S + k))
        store(o, Out.CLAW_VX + k, load(d, Deck.V_CLAW_S + k))
    store3(o, Out.DECK_ROLL, load3(d, Deck.ANGLES))
