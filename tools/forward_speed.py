"""Forward-speed reference of the tests: Capytaine's own forward speed on the frigate hull, with every input used.

Capytaine solves at the encounter frequency with the body conditions of a uniform stream (the m-terms: heave's normal
in pitch, minus sway's in yaw) and the pressure -rho (d/dt - U d/dx) phi; its free-surface condition has the encounter
frequency but no other speed terms, and the steady disturbance of the hull is left out. The Froude-Krylov force does not
depend on the speed; the one of the exact hull is used.
"""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from typing import Any

import numpy as np
from build_rao import DENSITY, DOFS, GRAVITY, Resolution, make_body
from frigate_hull import ComplexArray, FloatArray, FrigateHull, froude_krylov, hydrostatics
from rich.progress import track

from ssmash_gym.ship.hull import load_hull

KNOT = 1852.0 / 3600.0
KG_M = 6.2  # assumed
GYRATION = {"kxx_of_beam": 0.38, "kyy_of_length": 0.25, "kzz_of_length": 0.25}  # assumed
ROLL_DAMPING_N_M_S = 1.9e7  # added to the radiation damping; about a tenth of critical
SOFT_PERIOD_S, SOFT_SHARE = 120.0, 0.30  # spring and damper on surge, sway and yaw, of the ship's own inertia
RESOLUTION = Resolution(along=64, around=12, lid_along=40, lid_across=4)
HEADINGS_DEG = (0.0, 45.0, 90.0, 135.0, 180.0)
CASES = tuple(
    (speed, heading, omega) for speed in (18.0, 10.0) for omega in (0.4, 0.5, 0.6) for heading in HEADINGS_DEG
)
SHORT = tuple((18.0, heading, 0.8) for heading in HEADINGS_DEG)


def write_forward_speed(path: Path, hull: FrigateHull) -> None:
    """Solve every case and write the JSON file."""
    import capytaine as cpt

    engine = _keeping_engine()
    solver = cpt.BEMSolver(engine=engine, method="indirect")  # the direct method has no forward speed
    body, ship = make_body(hull, RESOLUTION), ship_inputs(hull)
    points = [solve_case(body, solver, hull, ship, *case) for case in track(CASES + SHORT, description="forward speed")]
    record = {"provenance": _provenance(hull), "inputs": ship, "points": points}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(_compact(record), encoding="utf-8")


def ship_inputs(hull: FrigateHull) -> dict[str, Any]:
    """Every number of the equation of motion that is not the hull's hydrodynamics (SI, BEM frame, about O)."""
    still = hydrostatics(hull)
    mass, height = DENSITY * still["volume_m3"], KG_M - hull.draught
    radii = [GYRATION["kxx_of_beam"] * hull.beam]
    radii += [GYRATION[key] * hull.length for key in ("kyy_of_length", "kzz_of_length")]
    of_g = np.diag([mass, mass, mass, *(mass * radius**2 for radius in radii)])
    to_g = motion_at(height)
    inertia = to_g.T @ of_g @ to_g
    weight, lever = DENSITY * GRAVITY, still["z_B"] - height
    c = np.zeros((6, 6))
    c[2, 2] = weight * still["A_wp"]
    c[2, 4] = c[4, 2] = -weight * still["S_x"]
    c[3, 3] = weight * (still["I_T"] + still["volume_m3"] * lever)
    c[4, 4] = weight * (still["I_L"] + still["volume_m3"] * lever)
    rate = 2.0 * np.pi / SOFT_PERIOD_S
    held = np.zeros((6, 6))
    held[:, [0, 1, 5]] = (inertia + load_hull("frigate").radiation(np.array([rate]))[0][0])[:, [0, 1, 5]]
    return {
        "water_density": DENSITY,
        "gravity": GRAVITY,
        "kg_m": KG_M,
        "gyration": GYRATION,
        "height_of_G_over_O_m": height,
        "inertia": inertia.tolist(),
        "restoring": c.tolist(),
        "roll_damping_N_m_s": ROLL_DAMPING_N_M_S,
        "restraint": {
            "what": "spring and damper on surge, sway and yaw, of the inertia of ship and water at the spring's rate",
            "period_s": SOFT_PERIOD_S,
            "share_of_critical": SOFT_SHARE,
            "stiffness": (held * rate**2).tolist(),
            "damping": (held * 2.0 * SOFT_SHARE * rate).tolist(),
        },
        "high_pass": "none",
        "encounter_floor": "none",
    }


def motion_at(height: float) -> FloatArray:
    """Matrix (6, 6) that gives the motion of the point `height` above the point whose motion it is applied to."""
    matrix = np.eye(6)
    matrix[0, 4], matrix[1, 3] = height, -height
    return matrix


def solve_case(
    body: Any, solver: Any, hull: FrigateHull, ship: dict[str, Any], knots: float, heading_deg: float, omega: float
) -> dict[str, Any]:
    """One speed, heading and wave frequency: coefficients about O and the motion of G per metre of wave."""
    import capytaine as cpt

    beta, speed = -np.radians(heading_deg), knots * KNOT
    common = {
        "body": body,
        "omega": omega,
        "rho": DENSITY,
        "g": GRAVITY,
        "forward_speed": speed,
        "wave_direction": beta,
    }
    added, damping = np.zeros((6, 6)), np.zeros((6, 6))
    for column, dof in enumerate(DOFS):
        result = solver.solve(cpt.RadiationProblem(**common, radiating_dof=dof), _check_wavelength=False)
        added[:, column] = [result.added_mass[name] for name in DOFS]
        damping[:, column] = [result.radiation_damping[name] for name in DOFS]
    result = solver.solve(cpt.DiffractionProblem(**common), _check_wavelength=False)
    diffraction = np.array([result.forces[name] for name in DOFS])
    krylov = froude_krylov(hull, omega**2 / GRAVITY, np.array([beta]), DENSITY, GRAVITY)[0]
    encounter = omega - omega**2 / GRAVITY * speed * np.cos(beta)
    if not np.isclose(encounter, result.encounter_omega):
        raise RuntimeError("the encounter frequency differs from Capytaine's: waves that are overtaken are left out")
    motion = solve_motion(added, damping, krylov + diffraction, encounter, ship)
    return {
        "speed_kn": knots,
        "speed_mps": speed,
        "heading_deg": heading_deg,
        "beta_bem_deg": -heading_deg,
        "omega": omega,
        "omega_e": float(encounter),
        "A": added.tolist(),
        "B": damping.tolist(),
        "FK": _parts(krylov),
        "FD": _parts(diffraction),
        "motion_of_G": _parts(motion),
    }


def solve_motion(
    added: FloatArray, damping: FloatArray, force: ComplexArray, encounter: float, ship: dict[str, Any]
) -> ComplexArray:
    """Motion (6,) of G per metre of wave, BEM frame, from coefficients about O."""
    soft = ship["restraint"]
    losses = damping + np.array(soft["damping"])
    losses[3, 3] += ship["roll_damping_N_m_s"]
    stiffness = np.array(ship["restoring"]) + np.array(soft["stiffness"])
    dynamic = -(encounter**2) * (np.array(ship["inertia"]) + added) - 1j * encounter * losses + stiffness
    motion: ComplexArray = motion_at(ship["height_of_G_over_O_m"]) @ np.linalg.solve(dynamic, force)
    return motion


def _keeping_engine() -> Any:
    """Capytaine's matrix engine that keeps the last velocity matrices: seven problems of a case share them."""
    import capytaine as cpt

    class Keeping(cpt.DefaultMatrixEngine):
        def __init__(self) -> None:
            super().__init__()
            self.kept: tuple[float, Any] | None = None

        def build_fullK_matrix(self, mesh1: Any, mesh2: Any, **parameters: Any) -> Any:
            wavenumber = float(parameters["wavenumber"])
            if self.kept is None or self.kept[0] != wavenumber:
                self.kept = (wavenumber, super().build_fullK_matrix(mesh1, mesh2, **parameters))
            return self.kept[1]

    return Keeping()


def _provenance(hull: FrigateHull) -> dict[str, Any]:
    """What made the file."""
    import capytaine as cpt

    return {
        "what": "radiation, wave forces and motions of the frigate hull with forward speed solved in the BEM itself",
        "hull": hull.numbers(),
        "frame": "x forward, y port, z up; e^{-i omega_e t}; A, B, FK, FD about O = (LCB, 0, waterline), motion of G;"
        " A[i][j]: force i by motion j; wave of unit amplitude at O, travelling to beta_bem = -heading",
        "equation": "[-(M + A) omega_e^2 - i omega_e (B + roll damping + restraint) + C + restraint] X = F about O",
        "code": f"capytaine {cpt.__version__}, indirect method, forward_speed, lid at z = 0",
        "forces": "A, B, FD: panels; FK: exact hull (it does not depend on the speed)",
        "left_out": "speed terms of the free-surface condition beyond the encounter frequency, steady wave of the hull",
        "half_panels": {"along": RESOLUTION.along, "around": RESOLUTION.around},
        "date": datetime.date.today().isoformat(),
        "command": "python tools/build_rao.py --forward-speed tests/data/forward_speed.json",
        "assumed": "KG, radii of gyration, roll damping, soft restraint",
    }


def _parts(values: ComplexArray) -> dict[str, list[float]]:
    """Real and imaginary parts for JSON."""
    return {"re": values.real.tolist(), "im": values.imag.tolist()}


def _compact(record: dict[str, Any]) -> str:
    """JSON with 7 significant digits, one point a line."""

    def rounded(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: rounded(item) for key, item in value.items()}
        if isinstance(value, list):
            return [rounded(item) for item in value]
        return float(f"{value:.7g}") if isinstance(value, float) else value

    head = {key: rounded(value) for key, value in record.items() if key != "points"}
    lines = ",\n".join(json.dumps(rounded(point)) for point in record["points"])
    return json.dumps(head, indent=1)[:-2] + ',\n "points": [\n' + lines + "\n]}\n"
