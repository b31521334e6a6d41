"""Section 2.4 of Léveillé (2013), literally: partial-velocity matrices, the 18x18 system and its 12x12 part.

The readable twin of the production solver, which never forms these matrices. Plain NumPy, corrections as in
docs/errata.md. As printed, [A] and [M] are minus the mass matrix.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.verification import kane_kinematics as kin
from tests.verification.kane_kinematics import HELI, SHIP, Array, Chain, Station, skew

Case = Mapping[str, Any]
ZERO = np.zeros((3, 3))


@dataclass(frozen=True)
class Body:
    """A body in its own axes: mass properties, [V] and [W], ~Z and ~Y, angular velocity, active force and torque."""

    mass: float
    inertia: Array
    V: Array  # 3x18
    W: Array
    Z: Array
    Y: Array
    w: Array
    R: Array
    T: Array

    def inertia_force(self, udot: Array) -> Array:
        """R*."""
        acceleration = self.V @ udot + self.Z  # (2.84), (2.86)
        return np.asarray(-self.mass * acceleration)  # (2.99), (2.101), (2.103)

    def inertia_torque(self, udot: Array) -> Array:
        """T*."""
        alpha = self.W @ udot + self.Y  # (2.85), (2.87)
        return np.asarray(-self.inertia @ alpha - skew(self.w) @ self.inertia @ self.w)  # (2.100), (2.102), (2.104)


# --- partial velocities and what is left of the accelerations ------------------------------------------------


def partial_velocities_H(c: Chain) -> tuple[Array, Array]:
    """[V] and [W] of the helicopter, so that N_H v^H = [V] U and N_H w^H = [W] U."""
    joints = np.zeros((3, 6))
    V = np.hstack([c.T_NH.T, -c.T_HS @ skew(c.r_H), c.T_HS, ZERO, joints])  # (2.64), (2.66)
    W = np.hstack([ZERO, c.T_HS, ZERO, np.eye(3), joints])  # (2.65), (2.67)
    return V, W


def partial_velocities_W(c: Chain, i: int, *, printed_signs: bool = False) -> tuple[Array, Array]:
    """[V] and [W] of carriage i.

    `printed_signs` keeps the two plus signs that the errata turns into minus.
    """
    s = c.stations[i]
    sign = 1.0 if printed_signs else -1.0
    T_WS, T_WH = (c.T_SH @ s.T_HO).T, s.T_HO.T
    to_W = c.T_SH @ s.T_HO @ s.r_W
    lever_S = -skew(c.r_H) + sign * (skew(c.T_SH @ s.r_O) + skew(to_W))
    lever_H = -skew(s.r_O) + sign * skew(s.T_HO @ s.r_W)
    V_joint, W_joint = np.zeros((3, 6)), np.zeros((3, 6))
    first, steer = s.turn.T
    V_joint[:, 2 * i] = -skew(s.r_W) @ first if s.swing else s.slide  # (2.231), (2.232)
    V_joint[:, 2 * i + 1] = -skew(s.r_W) @ steer
    W_joint[:, 2 * i] = first  # (2.233), (2.234)
    W_joint[:, 2 * i + 1] = steer
    V = np.hstack([(c.T_NH @ s.T_HO).T, T_WS @ lever_S, T_WS, T_WH @ lever_H, V_joint])  # (2.68), (2.70), (2.72)
    W = np.hstack([ZERO, T_WS, ZERO, T_WH, W_joint])  # (2.69), (2.71), (2.73)
    return V, W


def remainder_H(c: Chain) -> tuple[Array, Array]:
    """~Z and ~Y of the helicopter: its accelerations for zero derivatives of the speeds."""
    w = skew(c.w_S)
    Z = c.T_HS @ w @ w @ c.r_H + 2.0 * c.T_HS @ w @ c.v_H  # (2.88)
    Y = c.T_HS @ w @ c.T_SH @ c.w_H  # (2.89)
    return Z, Y


def remainder_W(c: Chain, s: Station) -> tuple[Array, Array]:
    """~Z and ~Y of a carriage."""
    w, wH, wO = skew(c.w_S), skew(c.w_H), skew(s.w_O)
    T_WS, T_WH = (c.T_SH @ s.T_HO).T, s.T_HO.T
    T_SO = c.T_SH @ s.T_HO
    Z = (
        T_WS @ w @ w @ c.r_H + 2.0 * T_WS @ w @ c.v_H
        + T_WS @ w @ w @ c.T_SH @ s.r_O + T_WH @ wH @ wH @ s.r_O
        + 2.0 * T_WS @ w @ c.T_SH @ wH @ s.r_O
        + T_WS @ w @ w @ T_SO @ s.r_W + T_WH @ wH @ wH @ s.T_HO @ s.r_W + wO @ wO @ s.r_W
        + 2.0 * T_WS @ w @ c.T_SH @ wH @ s.T_HO @ s.r_W + 2.0 * T_WS @ w @ T_SO @ wO @ s.r_W
        + 2.0 * T_WH @ wH @ s.T_HO @ wO @ s.r_W
        + 2.0 * T_WS @ w @ T_SO @ s.v_W + 2.0 * T_WH @ wH @ s.T_HO @ s.v_W + 2.0 * wO @ s.v_W  # (2.90)
    )  # fmt: skip
    Y = T_WS @ w @ c.T_SH @ c.w_H + T_WS @ w @ T_SO @ s.w_O + T_WH @ wH @ s.T_HO @ s.w_O  # (2.91)
    return Z, Y


def bodies(case: Case, *, printed_signs: bool = False) -> tuple[Body, ...]:
    """Helicopter, then the three carriages."""
    c = Chain.of(case)
    given, loads = case["params"], case["loads"]
    described = [(given["helicopter"], loads["H"]), *zip(given["stations"], loads["W"], strict=True)]
    parts = [(*partial_velocities_H(c), *remainder_H(c), kin.angular_velocity_H(c))]
    for i, s in enumerate(c.stations):
        V, W = partial_velocities_W(c, i, printed_signs=printed_signs)
        parts.append((V, W, *remainder_W(c, s), kin.angular_velocity_W(c, s)))
    return tuple(
        Body(body["mass"], np.array(body["inertia"]), *part, np.array(load["force"]), np.array(load["moment"]))
        for (body, load), part in zip(described, parts, strict=True)
    )


# --- Kane's equations ----------------------------------------------------------------------------------------


def active_forces(system: tuple[Body, ...]) -> Array:
    """~F, the generalized active forces, (18,)."""
    return np.asarray(sum(b.V.T @ b.R + b.W.T @ b.T for b in system))  # (2.93), (2.95), (2.97)


def inertia_forces(system: tuple[Body, ...], udot: Array) -> Array:
    """~F*, the generalized inertial forces, (18,)."""
    parts = [b.V.T @ b.inertia_force(udot) + b.W.T @ b.inertia_torque(udot) for b in system]
    return np.asarray(sum(parts))  # (2.94), (2.96), (2.98), (2.105)


def assemble(system: tuple[Body, ...]) -> tuple[Array, Array]:
    """[A] (18x18) and ~B (18,) of F* = [A] Udot + B."""
    A, B = np.zeros((18, 18)), np.zeros(18)
    for b in system:
        A -= b.mass * b.V.T @ b.V + b.W.T @ b.inertia @ b.W  # (2.106), (2.107)
        torque = b.inertia @ b.Y + skew(b.w) @ b.inertia @ b.w
        B -= b.mass * b.V.T @ b.Z + b.W.T @ torque  # (2.108)
    return A, B


def accelerations(case: Case, *, printed_signs: bool = False) -> Array:
    """u7'..u18' of a case, (12,), by the literal 12x12 system; rows and columns of locked speeds are dropped."""
    system = bodies(case, printed_signs=printed_signs)
    A, B = assemble(system)
    C = -B - active_forces(system)  # (2.109), (2.110)
    ship = np.concatenate([case["ship"]["a_S"], case["ship"]["wdot_S"]])
    M, E, N = A[HELI, HELI], A[HELI, SHIP], C[HELI]  # (2.111)
    free = ~np.array(case["locked"])
    udot = np.zeros(12)
    udot[free] = np.linalg.solve(M[np.ix_(free, free)], (N - E @ ship)[free])  # (2.112)
    return udot
