"""Analytic frigate-like hull: its formula, its hydrostatics, its Froude-Krylov forces and its panels (no BEM here).

x is measured forward from midship, y to port, z up from the still waterline [m]; xi = x / L runs from -1/2 (transom)
to +1/2 (stem). With u_f, u_a, u_k the shares (0..1) of the way from x_m to the stem, from x_m to the transom and
from x_k to the transom, the half-breadth at the depth z is

    y(xi, z) = b(xi) [1 - s^q(xi)],   s = -z / d(xi),   0 <= s <= 1
    b(xi) = B/2 (1 - u_f^n_f) [1 - (1 - b_t) u_a^n_a]      waterline
    d(xi) = T [1 - (1 - d_t) u_k^2]                        local draught: the keel rises to the transom
    q(xi) = q_m + (q_f - q_m) u_f + (q_t - q_m) u_a        section exponent: full amidships, V-shaped at the stem
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class FrigateHull:
    """The numbers of the formula; lengths in m, the others are shares or exponents (the project's own choice)."""

    length: float = 124.5
    beam: float = 14.8
    draught: float = 4.98
    x_m: float = -0.05  # fullest section
    x_k: float = -0.06  # where the keel begins to rise
    n_f: float = 2.32  # waterline exponent forward
    n_a: float = 1.96  # and aft
    b_t: float = 0.61  # waterline breadth of the transom / B
    d_t: float = 0.12  # draught of the transom / T
    q_m: float = 4.0  # section exponent amidships
    q_f: float = 1.2  # at the stem
    q_t: float = 2.0  # at the transom

    def section(self, xi: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Half-breadth at the waterline b [m], draught d [m] and exponent q of the sections at `xi` (n,)."""
        u_f = np.clip((xi - self.x_m) / (0.5 - self.x_m), 0.0, 1.0)
        u_a = np.clip((self.x_m - xi) / (0.5 + self.x_m), 0.0, 1.0)
        u_k = np.clip((self.x_k - xi) / (0.5 + self.x_k), 0.0, 1.0)
        b = self.beam / 2.0 * (1.0 - u_f**self.n_f) * (1.0 - (1.0 - self.b_t) * u_a**self.n_a)
        d = self.draught * (1.0 - (1.0 - self.d_t) * u_k**2)
        q = self.q_m + (self.q_f - self.q_m) * u_f + (self.q_t - self.q_m) * u_a
        return b, d, q

    def stations(self, per_piece: int = 60) -> tuple[FloatArray, FloatArray]:
        """Gauss nodes xi and weights [m] along the length, piece by piece between the formula's joints."""
        node, weight = np.polynomial.legendre.leggauss(per_piece)
        joints = np.unique([-0.5, self.x_k, self.x_m, 0.5])
        half, middle = np.diff(joints) / 2.0, (joints[1:] + joints[:-1]) / 2.0
        return (middle[:, None] + half[:, None] * node).ravel(), (half[:, None] * weight * self.length).ravel()

    def numbers(self) -> dict[str, float]:
        """The numbers of the formula, for the provenance."""
        return asdict(self)


def hydrostatics(hull: FrigateHull) -> dict[str, float]:
    """Hydrostatic integrals of the exact hull by Gauss quadrature, about O = (LCB, 0, waterline).

    Returns:
        ``volume_m3``, ``lcb_m`` and ``lcf_m`` (from midship, forward), ``z_B`` [m, negative], ``A_wp`` [m2], ``S_x``
        [m3], ``I_T`` and ``I_L`` [m4] of the waterplane about O, and the coefficients ``c_b``, ``c_wp``, ``c_m``.
    """
    xi, w = hull.stations()
    b, d, q = hull.section(xi)
    x = xi * hull.length
    area = 2.0 * b * d * q / (q + 1.0)
    volume, waterplane = float(np.sum(w * area)), float(np.sum(w * 2.0 * b))
    lcb = float(np.sum(w * area * x)) / volume
    box = hull.length * hull.beam
    c_m = float(np.max(q / (q + 1.0) * b * d) * 2.0 / (hull.beam * hull.draught))
    return {
        "volume_m3": volume,
        "lcb_m": lcb,
        "lcf_m": float(np.sum(w * 2.0 * b * x)) / waterplane,
        "z_B": -float(np.sum(w * 2.0 * b * d**2 * (0.5 - 1.0 / (q + 2.0)))) / volume,
        "A_wp": waterplane,
        "S_x": float(np.sum(w * 2.0 * b * (x - lcb))),
        "I_T": float(np.sum(w * 2.0 / 3.0 * b**3)),
        "I_L": float(np.sum(w * 2.0 * b * (x - lcb) ** 2)),
        "c_b": volume / (box * hull.draught),
        "c_wp": waterplane / box,
        "c_m": c_m,
    }


def froude_krylov(
    hull: FrigateHull, wavenumber: float, beta: FloatArray, density: float, gravity: float
) -> ComplexArray:
    """Froude-Krylov force of a deep-water wave of unit amplitude on the exact hull, about O, e^{-i w t}.

    The pressure integral over the hull is taken by Gauss' theorem as one over the volume and one over the waterplane,
    so a long wave gives exactly the hydrostatic integrals.

    Args:
        hull: The hull.
        wavenumber: Wavenumber k [rad/m].
        beta: Directions (m,) the wave travels to, from +x towards +y (port) [rad].
        density: Density of water [kg/m3].
        gravity: Acceleration of gravity [m/s2].

    Returns:
        Force and moment (m, 6) in BEM axes [N/m, N m/m].
    """
    xi, w_x = hull.stations(40)
    b, d, q = hull.section(xi)
    x = xi * hull.length - hydrostatics(hull)["lcb_m"]
    node, weight = np.polynomial.legendre.leggauss(24)
    s, w_s = (node + 1.0) / 2.0, weight / 2.0
    z = -d[:, None] * s
    half = b[:, None] * (1.0 - s ** q[:, None])  # half-breadth at (x, z)
    w_v = w_x[:, None] * d[:, None] * w_s * np.exp(wavenumber * z)
    scale = density * gravity
    force = np.zeros((len(beta), 6), dtype=np.complex128)
    for row, angle in enumerate(beta):
        kx, ky = wavenumber * np.cos(angle), wavenumber * np.sin(angle)
        wave = np.exp(1j * kx * x)
        even, odd = _across(ky, half)  # integrals of e^{i ky y} and y e^{i ky y} over the breadth
        top, top_odd = _across(ky, b)
        volume = wave[:, None] * w_v * even  # p dV / (rho g), summed over y
        lever = wave[:, None] * w_v * odd
        p_x, p_y, p_z = 1j * kx, 1j * ky, wavenumber  # gradient of p = these times p
        force[row, 0] = -p_x * volume.sum()
        force[row, 1] = -p_y * volume.sum()
        force[row, 2] = -p_z * volume.sum() + (w_x * wave * top).sum()
        force[row, 3] = -p_z * lever.sum() + p_y * (z * volume).sum() + (w_x * wave * top_odd).sum()
        force[row, 4] = (-p_x * z * volume + p_z * x[:, None] * volume).sum() - (w_x * x * wave * top).sum()
        force[row, 5] = (-p_y * x[:, None] * volume + p_x * lever).sum()
    return scale * force


def _across(ky: float, half: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Integrals over -half..half of e^{i ky y} and of y e^{i ky y}; series where ky half is small."""
    a = ky * half
    small = np.abs(a) < 1e-2
    safe = np.where(small, 1.0, a)
    sinc = np.where(small, 1.0 - a**2 / 6.0 + a**4 / 120.0, np.sin(safe) / safe)
    first = np.where(small, a / 3.0 - a**3 / 30.0, (np.sin(safe) - safe * np.cos(safe)) / safe**2)
    return 2.0 * half * sinc, 2j * half**2 * first


def half_panels(hull: FrigateHull, along: int, around: int) -> FloatArray:
    """Corner points (panels, 4, 3) of the port half below the waterline, normals into the water, x from midship.

    Stations are closer at both ends, points around a section lie at equal arc lengths; the transom is closed with
    vertical strips.
    """
    t = np.linspace(0.0, 1.0, along + 1)
    xi = -0.5 + 0.6 * t + 0.4 * (1.0 - np.cos(np.pi * t)) / 2.0
    xi[-1] = 0.5
    grid = np.stack([_section_points(hull, value, around) for value in xi])  # (along + 1, around + 1, 3) WL -> keel
    skin = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    edge = grid[0]
    lifted = edge * [1.0, 1.0, 0.0]
    transom = np.stack([lifted[:-1], edge[:-1], edge[1:], lifted[1:]], axis=1)
    return np.concatenate([skin.reshape(-1, 4, 3), transom])


def half_lid(hull: FrigateHull, along: int, across: int) -> FloatArray:
    """Corner points (panels, 4, 3) of the port half of the waterplane (a lid against irregular frequencies)."""
    t = np.linspace(0.0, 1.0, along + 1)
    b, _, _ = hull.section(t - 0.5)
    y = np.linspace(0.0, 1.0, across + 1)
    grid = np.stack(np.broadcast_arrays(((t - 0.5) * hull.length)[:, None], b[:, None] * y, 0.0), axis=-1)
    return np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2).reshape(-1, 4, 3)


def _section_points(hull: FrigateHull, xi: float, around: int) -> FloatArray:
    """Points (around + 1, 3) of a section at equal arc lengths from the waterline to the keel."""
    b, d, q = (float(v[0]) for v in hull.section(np.array([xi])))
    s = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 2001)))
    y, z = b * (1.0 - s**q), -d * s
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    at = np.interp(np.linspace(0.0, arc[-1], around + 1), arc, s)
    return np.stack([np.full(around + 1, xi * hull.length), b * (1.0 - at**q), -d * at], axis=1)
