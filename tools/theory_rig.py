"""The force elements one by one, on NumPy arrays, for tools/theory_figures.py: the project's kernels, uncompiled."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
from scipy.integrate import solve_ivp

from ssmash_gym.dynamics import probe as probes
from ssmash_gym.dynamics import tire as tires
from ssmash_gym.dynamics import tire_properties
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    STATION_ROWS,
    TIRE_PAR,
    TIRE_ROWS,
    Contact,
    Friction,
    Par,
    Tir,
    TireModel,
)
from ssmash_gym.simulation.parameters import parameter_column
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

PSI: Final = 6894.757
POUND: Final = 4.4482216  # of force [N]
TIRE: Final = {"diameter_m": 0.6604, "pressure_Pa": 140 * PSI, "rated_pressure_Pa": 140 * PSI}
# A strut with all five regions and both relief valves: the tricycle's nose oleo with cubics and curves of its own.
STRUT: Final = {
    "x1_m": 0.30, "x2_m": 0.37, "f1_Npm2": -6.0e5, "g1_Npm3": 2.0e6, "f2_Npm2": 5.0e6, "g2_Npm3": 0.0,
    "c4_N": 900.0, "c5_Nspm": 1800.0, "c6_Ns2pm2": 600.0, "c7_N": 1200.0, "c8_Nspm": 1500.0, "c9_Ns2pm2": 300.0,
    "relief_1_N": 3000.0, "relief_2_N": 5500.0,
}  # fmt: skip
# A probe with two stages, twice as stiff across as along, and one that is alike in both directions.
PROBE: Final = {
    "small_stiffness_x_Npm": 2.0e5, "small_stiffness_y_Npm": 4.0e5, "large_stiffness_x_Npm": 1.2e6,
    "large_stiffness_y_Npm": 2.4e6, "transition_x_m": 0.01, "transition_y_m": 0.01,
    "small_stiffness_z_Npm": 3.0e5, "large_stiffness_z_Npm": 2.0e6, "transition_z_m": 0.01, "damping_z_Nspm": 1.5e4,
}  # fmt: skip
ALIKE: Final = {**PROBE, "small_stiffness_y_Npm": 2.0e5, "large_stiffness_y_Npm": 1.2e6}


@cache
def helicopter(name: str) -> Helicopter:
    return load_helicopter(name)


def column(name: str, prefix: str, changes: Mapping[str, Any]) -> np.ndarray:
    """Parameter rows of a catalogue helicopter with changes below a dotted prefix, (PARAMETER_ROWS, 1)."""
    return parameter_column(with_changes(helicopter(name), {prefix + k: v for k, v in changes.items()}))[:, None]


def tire_block(n: int = 1, **changes: Any) -> np.ndarray:
    """Parameter rows of the main tire of seahawk_like with `TIRE` and `changes`, (TIRE_ROWS, n)."""
    start = TIRE_PAR + 2 * TIRE_ROWS
    rows = column("seahawk_like", "stations.right.tires.0.", {**TIRE, **changes})[start : start + TIRE_ROWS]
    return np.repeat(rows, n, axis=1)


def nose_strut(changes: Mapping[str, Any]) -> np.ndarray:
    """Parameter rows of the tricycle's nose station with changes to its spring, (STATION_ROWS, 1)."""
    rows = column("generic_tricycle", "stations.auxiliary.spring.", changes)
    return rows[Par.STATION : Par.STATION + STATION_ROWS].copy()


def elastic(p: np.ndarray, dz: np.ndarray) -> SimpleNamespace:
    """Vertical force, stiffnesses and lengths over the vertical deflection."""
    over_area = 1.0 / (p[Tir.DIAMETER] * p[Tir.WIDTH])
    L_h, b_t = uncompiled(tire_properties.footprint)(p, 0, dz, over_area)
    known = uncompiled(tire_properties.properties)(p, 0, TireModel.SMILEY_HORNE, dz, 0.0 * dz, L_h, b_t, over_area)
    names = ("F_z", "k_x", "k_y", "k_psi", "L_0", "L_y", "L_u")
    return SimpleNamespace(L_h=L_h, b_t=b_t, **dict(zip(names, known[:7], strict=True)))


def deflection_at(p: np.ndarray, load: float) -> float:
    dz = np.linspace(1e-4, 0.12, 4001)
    return float(np.interp(load, elastic(p, dz).F_z, dz))


def on_deck(
    p: np.ndarray,
    dz: Any,
    v: Any,
    state: Any,
    *,
    lock: float = 0.0,
    friction: int = Friction.LIMIT_SURFACE,
    factor: Any = 1.0,
) -> SimpleNamespace:
    """The tire upright on the deck at velocity ``v`` (2,) or (2, n) with stored deflections (3, n).

    ``factor`` is that of the friction coefficient, `patch_factor`.
    """
    n = p.shape[1]
    full = [np.broadcast_to(np.asarray(x, dtype=float), n).copy() for x in (*v, *state, 0.5 * p[Tir.DIAMETER] - dz)]
    v_x, v_y, d_x, d_y, psi, height = full
    zero = np.zeros(n)
    _, M, rates, reads = uncompiled(tires.tire)(
        p, 0, TireModel.SMILEY_HORNE, friction, Contact.CONTACT, (zero, zero, zero), height, (v_x, v_y, zero),
        (zero, zero, zero), (zero, zero + 1.0, zero), d_x, d_y, psi, zero + lock, factor * p[Tir.MU],
    )  # fmt: skip
    return SimpleNamespace(F_z=reads[0], F_y=reads[1], F_x=reads[2], M_z=M[2], rates=np.array(rates), use=reads[7])


def rolled(p: np.ndarray, dz: Any, v: Any, metres: Any, **how: Any) -> np.ndarray:
    """States (3, n) or, at several distances, (3, n, m) of tires that start undeflected and roll at ``v``."""
    n = p.shape[1]
    times = np.atleast_1d(metres) / float(np.max(np.abs(v[0])))

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        return on_deck(p, dz, v, y.reshape(3, n), **how).rates.ravel()

    run = solve_ivp(rates, (0.0, times[-1]), np.zeros(3 * n), t_eval=times, method="RK45", rtol=1e-7, atol=1e-9)
    states = run.y.reshape(3, n, -1)
    return states if np.ndim(metres) else states[:, :, -1]


def printed_steps(e: SimpleNamespace, steady: float, tangent: float, step: float, metres: float) -> Any:
    """Lateral deflection of (2.145), (2.146) as printed, taken again after every ``step`` of rolled distance."""
    x, d = [0.0], [0.0]
    while x[-1] < metres:
        d.append(steady - (steady - d[-1]) * np.exp(-step / e.L_y[0]) - step * tangent)
        x.append(x[-1] + step)
    return np.array(x), np.array(d)


def dragged(p: np.ndarray, dz: float, speed: float, factor: Any, x: np.ndarray) -> np.ndarray:
    """Longitudinal force [N] at the places ``x`` of a locked tire dragged ahead; ``factor(x)`` is that of friction."""

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return on_deck(p, dz, (speed, 0.0), y[:, None], lock=1.0, factor=factor(x[0] + speed * t)).rates[:, 0]

    times = (x - x[0]) / speed
    run = solve_ivp(rates, (0.0, times[-1]), np.zeros(3), t_eval=times, max_step=0.01, rtol=1e-6, atol=1e-9)
    forces = [
        on_deck(p, dz, (speed, 0.0), y[:, None], lock=1.0, factor=factor(place)).F_x[0]
        for place, y in zip(x, run.y.T, strict=True)
    ]
    return np.array(forces)


def probe_force(changes: dict[str, float], d: Any, law: str) -> np.ndarray:
    """In-plane force (2, n) of displacements (2, n), no damping."""
    p = column("generic_tricycle", "probe.", changes)
    still = np.zeros(d.shape[1])
    if law == "potential":
        return np.array(uncompiled(probes.potential_force)(p, d[0], d[1], still, still))
    return np.array(uncompiled(probes.radial_force)(p, d[0], d[1], still, still, law == "printed"))


def loop_work(law: str, points: int = 8192) -> float:
    """Net work of the probe round an off-centre ellipse over the work turned over; constants of tests/dynamics."""
    constants = (4.0e5, 6.0e5, 1.2e6, 2.5e6, 0.004, 0.007)
    keys = [f"{size}_{axis}" for size in ("small_stiffness", "large_stiffness") for axis in ("x_Npm", "y_Npm")]
    changes = dict(zip([*keys, "transition_x_m", "transition_y_m"], constants, strict=True))
    t = 2 * np.pi * np.arange(points) / points
    d = np.array([0.006 + 0.013 * np.cos(t), -0.002 + 0.011 * np.sin(t)])
    power = np.sum(probe_force(changes, d, law) * np.array([-0.013 * np.sin(t), 0.011 * np.cos(t)]), axis=0)
    return float(np.sum(power) / np.sum(np.abs(power)))
