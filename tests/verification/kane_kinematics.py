"""Section 2.3 of Léveillé (2013), literally: positions, velocities and accelerations of the four bodies.

Plain NumPy, one formula of the thesis a line, corrections as in docs/errata.md. ``T_AB`` is the thesis' [T^{A<-B}]
(B components to A components), ``skew(a)`` its [a~]. Every quantity of the chain is a relative one: the ship over N in
N axes, the helicopter over the ship in S axes, a carriage over its oleo frame in O axes. W is parallel to O.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SHIP, HELI = slice(0, 6), slice(6, 18)  # u1-u6 and u7-u18


def skew(a: Array) -> Array:
    """[a~], so that ``a x b = skew(a) @ b``."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])  # (2.2)


def euler_parameters(axis: Array, angle: float) -> Array:
    """Euler parameters of a rotation about a unit axis."""
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * np.asarray(axis))])  # (2.3), (2.4)


def transformation(p: Array) -> Array:
    """[T] from the rotated to the non-rotated frame, with the two signs of the errata."""
    e0, e1, e2, e3 = p
    return 2.0 * np.array(
        [
            [e0 * e0 + e1 * e1 - 0.5, e1 * e2 - e0 * e3, e1 * e3 + e0 * e2],  # (2.5)
            [e1 * e2 + e0 * e3, e0 * e0 + e2 * e2 - 0.5, e2 * e3 - e0 * e1],
            [e1 * e3 - e0 * e2, e2 * e3 + e0 * e1, e0 * e0 + e3 * e3 - 0.5],
        ]
    )


def transformation_rate(T: Array, w: Array) -> Array:
    """Time derivative of a transformation whose rotated frame turns with `w`, given in that frame."""
    return T @ skew(w)  # (2.7)


def parameter_rates(p: Array, w: Array) -> Array:
    """Time derivatives of Euler parameters from the angular velocity in the rotated frame."""
    e0, e1, e2, e3 = p
    L_T = np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])  # (2.30)
    return 0.5 * L_T @ w  # (2.29), (2.31)-(2.35)


@dataclass(frozen=True)
class Station:
    """One oleo frame and its carriage: `r_O` = H_H r^O, `r_W` = O_O r^W, `u` its two generalized speeds."""

    swing: bool
    T_HO: Array
    r_O: Array
    r_W: Array
    u: Array

    @property
    def slide(self) -> Array:
        """Column of the first speed in O_O v^W."""
        return np.zeros(3) if self.swing else np.array([0.0, 0.0, 1.0])  # (2.228), (2.229)

    @property
    def turn(self) -> Array:
        """Columns of both speeds in H_O w^O."""
        first = [0.0, 1.0, 0.0] if self.swing else [0.0, 0.0, 0.0]
        return np.column_stack([first, [0.0, 0.0, 1.0]])  # (2.227), (2.230)

    @property
    def v_W(self) -> Array:
        """O_O v^W."""
        return self.slide * self.u[0]  # (2.23), (2.25), (2.27)

    @property
    def w_O(self) -> Array:
        """H_O w^O."""
        return np.asarray(self.turn @ self.u)  # (2.24), (2.26), (2.28)

    def second(self, udot: Array) -> tuple[Array, Array]:
        """Locally evaluated second derivative of the position and first of the angular velocity."""
        return self.slide * udot[0], np.asarray(self.turn @ udot)  # (2.76)-(2.78), (2.81)-(2.83)


@dataclass(frozen=True)
class Chain:
    """Ship, helicopter and stations at one instant; `udot` are the eighteen derivatives of the generalized speeds."""

    T_NS: Array
    T_SH: Array
    r_S: Array  # N_N r^S
    v_S: Array
    w_S: Array  # N_S w^S
    r_H: Array  # S_S r^H
    v_H: Array
    w_H: Array  # S_H w^H
    stations: tuple[Station, ...]

    @classmethod
    def of(cls, case: Mapping[str, Any]) -> Chain:
        """The chain of a case of ``data/rigid_body_cases.json``; locked speeds are zero."""
        ship, state = case["ship"], case["state"]
        free = 1.0 - np.array(case["locked"], dtype=float)
        stations = tuple(
            Station(
                swing=given["type"] == "swing",
                T_HO=transformation(np.array(now["p_O"])),  # (2.14), (2.16), (2.18)
                r_O=np.array(given["mount"]),
                r_W=np.array(now["r_W"]),  # (2.13), (2.15), (2.17)
                u=np.array(now["u"]) * free[6 + 2 * i : 8 + 2 * i],
            )
            for i, (given, now) in enumerate(zip(case["params"]["stations"], state["stations"], strict=True))
        )
        return cls(
            T_NS=transformation(np.array(ship["p_S"])),  # (2.10)
            T_SH=transformation(np.array(state["p_H"])),  # (2.12)
            r_S=np.array(ship["r_S"]),  # (2.9)
            v_S=np.array(ship["v_S"]),  # (2.19)
            w_S=np.array(ship["w_S"]),  # (2.20)
            r_H=np.array(state["r_H"]),  # (2.11)
            v_H=np.array(state["v_H"]) * free[0:3],  # (2.21)
            w_H=np.array(state["w_H"]) * free[3:6],  # (2.22)
            stations=stations,
        )

    @property
    def speeds(self) -> Array:
        """All eighteen generalized speeds."""
        return np.concatenate([self.v_S, self.w_S, self.v_H, self.w_H, *(s.u for s in self.stations)])

    @property
    def T_NH(self) -> Array:
        return np.asarray(self.T_NS @ self.T_SH)  # (2.6)

    @property
    def T_HS(self) -> Array:
        return np.asarray(self.T_SH.T)

    def moved(self, udot: Array, h: float) -> Chain:
        """The chain `h` seconds on with constant `udot`; symmetric in h, so central differences are of second order."""

        def turned(T: Array, w: Array) -> Array:
            angle = float(np.linalg.norm(w)) * h
            return np.asarray(T @ transformation(euler_parameters(w / max(np.linalg.norm(w), 1e-300), angle)))

        joints = udot[12:].reshape(3, 2)
        return replace(
            self,
            T_NS=turned(self.T_NS, self.w_S),
            T_SH=turned(self.T_SH, self.w_H),
            r_S=self.r_S + h * self.v_S,
            v_S=self.v_S + h * udot[0:3],
            w_S=self.w_S + h * udot[3:6],
            r_H=self.r_H + h * self.v_H,
            v_H=self.v_H + h * udot[6:9],
            w_H=self.w_H + h * udot[9:12],
            stations=tuple(
                replace(s, T_HO=turned(s.T_HO, s.w_O), r_W=s.r_W + h * s.v_W, u=s.u + h * du)
                for s, du in zip(self.stations, joints, strict=True)
            ),
        )


# --- positions and velocities ------------------------------------------------------------------------------


def position_H(c: Chain) -> Array:
    """N_N r^H."""
    return np.asarray(c.r_S + c.T_NS @ c.r_H)  # (2.36)


def position_W(c: Chain, s: Station) -> Array:
    """N_N r^W."""
    return np.asarray(position_H(c) + c.T_NH @ (s.r_O + s.T_HO @ s.r_W))


def velocity_H_in_N(c: Chain) -> Array:
    """N_N v^H."""
    return np.asarray(c.v_S + c.T_NS @ skew(c.w_S) @ c.r_H + c.T_NS @ c.v_H)  # (2.37)


def velocity_H(c: Chain) -> Array:
    """N_H v^H."""
    return np.asarray(c.T_NH.T @ c.v_S - c.T_HS @ skew(c.r_H) @ c.w_S + c.T_HS @ c.v_H)  # (2.38)


def velocity_O_in_N(c: Chain, s: Station) -> Array:
    """N_N v^O."""
    over_H = c.T_NS @ skew(c.w_S) @ c.T_SH @ s.r_O + c.T_NH @ skew(c.w_H) @ s.r_O  # (2.43)
    return np.asarray(velocity_H_in_N(c) + over_H)  # (2.42)


def velocity_W_in_N(c: Chain, s: Station) -> Array:
    """N_N v^W."""
    T_NO = c.T_NH @ s.T_HO
    over_O = (
        c.T_NS @ skew(c.w_S) @ c.T_SH @ s.T_HO @ s.r_W
        + c.T_NH @ skew(c.w_H) @ s.T_HO @ s.r_W
        + T_NO @ skew(s.w_O) @ s.r_W
        + T_NO @ s.v_W  # (2.46)
    )
    return np.asarray(velocity_O_in_N(c, s) + over_O)  # (2.45)


def velocity_W(c: Chain, s: Station) -> Array:
    """N_W v^W: angular velocities as vectors, all of it in W axes (the labels of the print are corrected)."""
    T_WS, T_WH = (c.T_SH @ s.T_HO).T, s.T_HO.T
    return np.asarray(
        (c.T_NH @ s.T_HO).T @ c.v_S - T_WS @ skew(c.r_H) @ c.w_S + T_WS @ c.v_H
        - T_WS @ skew(c.T_SH @ s.r_O) @ c.w_S - T_WH @ skew(s.r_O) @ c.w_H
        - T_WS @ skew(c.T_SH @ s.T_HO @ s.r_W) @ c.w_S - T_WH @ skew(s.T_HO @ s.r_W) @ c.w_H
        - skew(s.r_W) @ s.w_O + s.v_W  # (2.47)
    )  # fmt: skip


# --- accelerations -------------------------------------------------------------------------------------------


def acceleration_H_in_N(c: Chain, udot: Array) -> Array:
    """N_N a^H."""
    w = skew(c.w_S)
    return np.asarray(
        udot[0:3]  # (2.74)
        + c.T_NS @ w @ w @ c.r_H
        + c.T_NS @ skew(udot[3:6]) @ c.r_H  # (2.79)
        + 2.0 * c.T_NS @ w @ c.v_H
        + c.T_NS @ udot[6:9]  # (2.39), (2.75)
    )


def acceleration_H(c: Chain, udot: Array) -> Array:
    """N_H a^H, all derivatives of speeds as vectors."""
    w = skew(c.w_S)
    return np.asarray(
        c.T_NH.T @ udot[0:3] + c.T_HS @ w @ w @ c.r_H - c.T_HS @ skew(c.r_H) @ udot[3:6]
        + 2.0 * c.T_HS @ w @ c.v_H + c.T_HS @ udot[6:9]  # (2.40), (2.41)
    )  # fmt: skip


def acceleration_O_over_H_in_N(c: Chain, s: Station, udot: Array) -> Array:
    """H_N a^O."""
    w, wH = skew(c.w_S), skew(c.w_H)
    return np.asarray(
        c.T_NS @ skew(udot[3:6]) @ c.T_SH @ s.r_O
        + c.T_NH @ skew(udot[9:12]) @ s.r_O  # (2.80)
        + c.T_NS @ w @ w @ c.T_SH @ s.r_O
        + c.T_NH @ wH @ wH @ s.r_O
        + 2.0 * c.T_NS @ w @ c.T_SH @ wH @ s.r_O  # (2.44)
    )


def acceleration_W_over_O_in_N(c: Chain, s: Station, udot: Array, joint: Array) -> Array:
    """O_N a^W; `joint` are the derivatives of the station's two speeds."""
    a_W, wdot_O = s.second(joint)
    w, wH, wO = skew(c.w_S), skew(c.w_H), skew(s.w_O)
    T_NO, T_SO = c.T_NH @ s.T_HO, c.T_SH @ s.T_HO
    return np.asarray(
        c.T_NS @ skew(udot[3:6]) @ T_SO @ s.r_W + c.T_NH @ skew(udot[9:12]) @ s.T_HO @ s.r_W
        + T_NO @ skew(wdot_O) @ s.r_W + c.T_NS @ w @ w @ T_SO @ s.r_W
        + c.T_NH @ wH @ wH @ s.T_HO @ s.r_W + T_NO @ wO @ wO @ s.r_W
        + 2.0 * c.T_NS @ w @ c.T_SH @ wH @ s.T_HO @ s.r_W + 2.0 * c.T_NS @ w @ T_SO @ wO @ s.r_W
        + 2.0 * c.T_NH @ wH @ s.T_HO @ wO @ s.r_W + 2.0 * c.T_NS @ w @ T_SO @ s.v_W
        + 2.0 * c.T_NH @ wH @ s.T_HO @ s.v_W + 2.0 * T_NO @ wO @ s.v_W + T_NO @ a_W  # (2.49), (2.50)
    )  # fmt: skip


def acceleration_W(c: Chain, s: Station, udot: Array, joint: Array) -> Array:
    """N_W a^W."""
    total = (
        acceleration_H_in_N(c, udot)
        + acceleration_O_over_H_in_N(c, s, udot)
        + acceleration_W_over_O_in_N(c, s, udot, joint)  # (2.48)
    )
    return np.asarray((c.T_NH @ s.T_HO).T @ total)  # (2.51)


# --- angular motion ------------------------------------------------------------------------------------------


def angular_velocity_H(c: Chain) -> Array:
    """N_H w^H."""
    in_N = c.T_NS @ c.w_S + c.T_NH @ c.w_H  # (2.52), (2.54), (2.55)
    return np.asarray(c.T_NH.T @ in_N)  # (2.56)


def angular_velocity_W(c: Chain, s: Station) -> Array:
    """N_W w^W."""
    in_N = c.T_NH @ angular_velocity_H(c) + c.T_NH @ s.T_HO @ s.w_O  # (2.59), (2.60)
    return np.asarray((c.T_NH @ s.T_HO).T @ in_N)  # (2.61)


def angular_acceleration_H_in_N(c: Chain, udot: Array) -> Array:
    """N_N alpha^H."""
    ship = c.T_NS @ udot[3:6]  # (2.53)
    over_S = c.T_NS @ skew(c.w_S) @ c.T_SH @ c.w_H + c.T_NH @ udot[9:12]  # (2.57)
    return np.asarray(ship + over_S)  # (2.58)


def angular_acceleration_W(c: Chain, s: Station, udot: Array, joint: Array) -> Array:
    """N_W alpha^W."""
    T_NO = c.T_NH @ s.T_HO
    over_H = (
        c.T_NS @ skew(c.w_S) @ c.T_SH @ s.T_HO @ s.w_O
        + c.T_NH @ skew(c.w_H) @ s.T_HO @ s.w_O
        + T_NO @ s.second(joint)[1]  # (2.62)
    )
    return np.asarray(T_NO.T @ (angular_acceleration_H_in_N(c, udot) + over_H))  # (2.63)
