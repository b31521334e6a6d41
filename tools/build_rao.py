"""Builds ssmash_gym/ship/data/frigate.npz with Capytaine, and the forward-speed fixture of the tests.

python tools/build_rao.py --out ssmash_gym/ship/data/frigate.npz        (two to three minutes)
python tools/build_rao.py --forward-speed tests/data/forward_speed.json (a few minutes)
python tools/build_rao.py --check                                       (mesh study, printed)

Needs Capytaine 3 (`pip install capytaine`); nothing else of the project does.
"""

from __future__ import annotations

import argparse
import datetime
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from frigate_hull import (
    ComplexArray,
    FloatArray,
    FrigateHull,
    froude_krylov,
    half_lid,
    half_panels,
    hydrostatics,
)
from rich.progress import track

GRAVITY = 9.81
DENSITY = 1025.0
DOFS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
EVEN, ODD = (0, 2, 4), (1, 3, 5)  # a port/starboard symmetric hull couples only within each set


@dataclass(frozen=True)
class Resolution:
    """Panels of half the hull (along x around) and of half the lid (along x across)."""

    along: int = 60
    around: int = 9
    lid_along: int = 48
    lid_across: int = 4


def make_body(hull: FrigateHull, resolution: Resolution) -> Any:
    """Capytaine body of the hull about O = (LCB, 0, waterline), with its lid and six rigid degrees of freedom."""
    import capytaine as cpt

    shift = np.array([hydrostatics(hull)["lcb_m"], 0.0, 0.0])

    def mirrored(corners: FloatArray, name: str) -> Any:
        panels = np.arange(4 * len(corners)).reshape(-1, 4)
        half = cpt.Mesh((corners - shift).reshape(-1, 3), panels, auto_check=False)
        return cpt.ReflectionSymmetricMesh(half, plane="xOz", name=name)

    return cpt.FloatingBody(
        mesh=mirrored(half_panels(hull, resolution.along, resolution.around), "hull"),
        lid_mesh=mirrored(half_lid(hull, resolution.lid_along, resolution.lid_across), "lid"),
        dofs=cpt.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0)),
    )


def solve_frequency(
    body: Any, solver: Any, omega: float, beta: FloatArray
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Added mass (6, 6), damping (6, 6) and diffraction force (m, 6) at one frequency, without forward speed."""
    import capytaine as cpt

    common = {"body": body, "omega": omega, "rho": DENSITY, "g": GRAVITY}
    added, damping = np.zeros((6, 6)), np.zeros((6, 6))
    for i, dof in enumerate(DOFS):
        result = solver.solve(
            cpt.RadiationProblem(**common, radiating_dof=dof), keep_details=False, _check_wavelength=False
        )
        added[:, i] = [result.added_mass[name] for name in DOFS]
        damping[:, i] = [result.radiation_damping[name] for name in DOFS]
    diffraction = np.zeros((len(beta), 6), dtype=np.complex128)
    for row, angle in enumerate(beta):
        problem = cpt.DiffractionProblem(**common, wave_direction=float(angle))
        forces = solver.solve(problem, keep_details=False, _check_wavelength=False).forces
        diffraction[row] = [forces[name] for name in DOFS]
    return added, damping, diffraction


def symmetric(matrix: FloatArray) -> FloatArray:
    """The symmetric part, with the couplings removed that a port/starboard symmetric hull does not have."""
    coupled = np.zeros((6, 6))
    for group in (EVEN, ODD):
        coupled[np.ix_(group, group)] = 1.0
    return coupled * (matrix + np.swapaxes(matrix, -1, -2)) / 2.0


def not_negative(damping: FloatArray, negligible: float) -> FloatArray:
    """The damping (6, 6) without negative eigenvalues, which the panels leave where there is next to no radiation.

    Raises:
        RuntimeError: An eigenvalue is more negative than `negligible` [kg/s].
    """
    result = np.zeros((6, 6))
    length = np.array([1.0, 1.0, 1.0, 5.0, 50.0, 50.0])  # to compare forces with moments
    scaled = damping / np.outer(length, length)
    for group in (EVEN, ODD):
        values, vectors = np.linalg.eigh(scaled[np.ix_(group, group)])
        if values[0] < -negligible:
            raise RuntimeError(f"radiation damping has the eigenvalue {values[0]:.3g} kg/s")
        result[np.ix_(group, group)] = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return result * np.outer(length, length)


def build(
    hull: FrigateHull, resolution: Resolution, omega: FloatArray, beta: FloatArray, *, quiet: bool = False
) -> dict[str, Any]:
    """The arrays of the database, see `ssmash_gym.ship.hull.HullDatabase`; symmetries are enforced."""
    import capytaine as cpt

    body, solver = make_body(hull, resolution), cpt.BEMSolver(method="direct")
    mass = DENSITY * hydrostatics(hull)["volume_m3"]
    added, damping, diffraction, krylov = [], [], [], []
    for value in track(omega, description="radiation and diffraction", disable=quiet):
        a, b, fd = solve_frequency(body, solver, float(value), beta)
        added.append(symmetric(a))
        damping.append(not_negative(symmetric(b), 1e-5 * value * mass))
        diffraction.append(fd)
        krylov.append(froude_krylov(hull, value**2 / GRAVITY, beta, DENSITY, GRAVITY))
    ends = np.isclose(np.sin(beta), 0.0)
    arrays = {"A": np.array(added), "B": np.array(damping), "FK": np.array(krylov), "FD": np.array(diffraction)}
    for name in ("FK", "FD"):
        arrays[name][np.ix_(range(len(omega)), np.flatnonzero(ends), ODD)] = 0.0
    return {"omega": omega, "beta": beta, **arrays}


def write_database(path: Path, hull: FrigateHull, resolution: Resolution, arrays: dict[str, Any]) -> None:
    """Write the npz: numbers of the hull, arrays in float32 / complex64, provenance as a JSON string."""
    import capytaine as cpt

    still = hydrostatics(hull)
    panels = 2 * len(half_panels(hull, resolution.along, resolution.around))
    provenance = {
        "hull": "frigate-like, analytic, of the project's own design; no ship's lines",
        "formula": "y = b [1 - s^q], s = -z/d; b, d, q: see docs/theory/hull.md and tools/frigate_hull.py",
        "numbers": hull.numbers(),
        "hydrostatics": still,
        "origin": "O = (LCB, 0, still waterline); x forward, y port, z up; e^{-i omega t}; deep water",
        "wave_direction": "beta: 0 travels to +x (following), pi/2 to +y (port), pi head",
        "panels": {"hull": panels, "lid": 4 * resolution.lid_along * resolution.lid_across // 2},
        "forces": "A, B, FD: panels (direct method, lid at z = 0); FK: exact hull, Gauss quadrature",
        "code": f"capytaine {cpt.__version__}",
        "date": datetime.date.today().isoformat(),
        "command": "python tools/build_rao.py --out ssmash_gym/ship/data/frigate.npz",
        "assumed": "main dimensions and coefficients frigate-like; bare hull, no appendages, no speed, no viscosity",
    }
    scalars = {
        "name": np.array("frigate"),
        "provenance": np.array(json.dumps(provenance)),
        "length_m": hull.length,
        "beam_m": hull.beam,
        "draught_m": hull.draught,
        "water_density": DENSITY,
        "gravity": GRAVITY,
        **{key: still[key] for key in ("volume_m3", "z_B", "A_wp", "S_x", "I_T", "I_L")},
    }
    halves = {key: np.asarray(arrays[key], np.float32) for key in ("A", "B")}
    halves |= {key: np.asarray(arrays[key], np.complex64) for key in ("FK", "FD")}
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        np.savez_compressed(file, omega=arrays["omega"], beta=arrays["beta"], **scalars, **halves)


def print_particulars(hull: FrigateHull) -> None:
    """Print the table of main particulars of docs/theory/hull.md."""
    still = hydrostatics(hull)
    metacentre = hull.draught + still["z_B"] + still["I_T"] / still["volume_m3"]
    rows = (
        ("length L", f"{hull.length:.1f} m"),
        ("beam B", f"{hull.beam:.1f} m"),
        ("draught T", f"{hull.draught:.2f} m"),
        ("volume", f"{still['volume_m3']:.0f} m³"),
        ("mass at 1025 kg/m³", f"{still['volume_m3'] * DENSITY / 1e3:.0f} t"),
        ("block coefficient", f"{still['c_b']:.3f}"),
        ("waterplane coefficient", f"{still['c_wp']:.3f}"),
        ("midship section coefficient", f"{still['c_m']:.3f}"),
        ("centre of buoyancy from midship", f"{100.0 * still['lcb_m'] / hull.length:+.2f} % L"),
        ("centre of flotation from midship", f"{100.0 * still['lcf_m'] / hull.length:+.2f} % L"),
        ("centre of buoyancy above the keel", f"{hull.draught + still['z_B']:.2f} m"),
        ("metacentre above the keel", f"{metacentre:.2f} m"),
    )
    print("| particular | value |\n|---|---|")
    print("\n".join(f"| {name} | {value} |" for name, value in rows))


def print_checks(hull: FrigateHull, resolution: Resolution) -> None:
    """Print what a finer mesh changes, and how far single frequencies stick out with and without the lid."""
    import capytaine as cpt

    beta = np.radians(np.arange(0.0, 181.0, 5.0))
    omega = np.array([0.4, 0.6, 0.8, 1.2, 1.6, 2.0])
    finer = Resolution(*(round(1.5 * value) for value in (*vars(resolution).values(),)))
    ours, theirs = (build(hull, size, omega, beta) for size in (resolution, finer))
    peak = {key: np.abs(ours[key]).max(axis=tuple(range(ours[key].ndim - 1))) for key in ("FK", "FD")}
    print(f"{resolution} against {finer}: change, % of the largest")
    print("omega    A11..A66                             B11..B66                             F1..F6")
    for row, value in enumerate(omega):
        change = []
        for key in ("A", "B"):
            a, b = (np.diagonal(data[key], axis1=1, axis2=2) for data in (ours, theirs))
            change.append((b[row] - a[row]) / np.abs(a).max(axis=0))
        force = np.abs(theirs["FD"][row] - ours["FD"][row]).max(axis=0) / (peak["FK"] + peak["FD"])
        print(
            f"{value:5.2f}", *("  ".join(f"{100.0 * x:+6.2f}" for x in part) for part in (*change, force)), sep="    "
        )
    dense = np.arange(1.3, 2.42, 0.02)
    body = make_body(hull, resolution)
    for name, one in (("lid", body), ("no lid", cpt.FloatingBody(mesh=body.mesh, dofs=body.dofs))):
        solver = cpt.BEMSolver(method="direct")
        solved = [
            solve_frequency(one, solver, float(value), beta[:0]) for value in track(dense, description=f"scan, {name}")
        ]
        for key, part in (("A", 0), ("B", 1)):
            x = np.array([np.diag(result[part]) for result in solved])
            out = np.abs(x[2:-2] - (-x[:-4] + 4 * x[1:-3] + 4 * x[3:-1] - x[4:]) / 6.0).max(axis=0)
            out /= np.abs(x).max(axis=0)
            print(f"{name:7s}{key}: furthest from the cubic through the neighbours {100.0 * out.max():.3f} % of peak")


def main() -> int:
    """Read the command line and do what it says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="write the database here (npz)")
    parser.add_argument("--forward-speed", type=Path, help="write the forward-speed fixture here (JSON)")
    parser.add_argument("--check", action="store_true", help="compare meshes at a few frequencies")
    arguments = parser.parse_args()
    hull, resolution = FrigateHull(), Resolution()
    print_particulars(hull)
    if arguments.out:
        omega = np.round(0.10 + 0.04 * np.arange(59), 4)
        arrays = build(hull, resolution, omega, np.radians(np.arange(0.0, 181.0, 4.0)))
        write_database(arguments.out, hull, resolution, arrays)
        print(f"{arguments.out}: {arguments.out.stat().st_size / 1e3:.0f} kB")
    if arguments.forward_speed:
        from forward_speed import write_forward_speed

        write_forward_speed(arguments.forward_speed, hull)
        print(f"{arguments.forward_speed}: {arguments.forward_speed.stat().st_size / 1e3:.0f} kB")
    if arguments.check:
        print_checks(hull, resolution)
    return 0


if __name__ == "__main__":
    sys.exit(main())
