"""The hull's database: limits, symmetries and energy, interpolation, Froude scaling, refusals, and its tool."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.hull import DATA, HullDatabase, load_hull

ROOT = Path(__file__).resolve().parents[2]
EVEN, ODD = (0, 2, 4), (1, 3, 5)  # surge, heave, pitch; sway, roll, yaw


@pytest.fixture(scope="module")
def hull() -> HullDatabase:
    return load_hull("frigate")


@pytest.fixture(scope="module")
def tool() -> Iterator[Callable[[str], ModuleType]]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "tools"))
        yield importlib.import_module


@pytest.fixture(scope="module")
def record() -> dict[str, Any]:
    return json.loads((ROOT / "tests" / "data" / "forward_speed.json").read_text(encoding="utf-8"))


def weight(hull: HullDatabase) -> float:
    return hull.water_density * hull.gravity


def everywhere(hull: HullDatabase, n: int = 400) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.uniform(0.05, 2.4, n), rng.uniform(-np.pi, np.pi, n)


# --- physics of the stored numbers -----------------------------------------------------------------------------------


def test_main_particulars_are_a_frigate_s(hull: HullDatabase) -> None:
    box = hull.length_m * hull.beam_m * hull.draught_m
    assert hull.volume_m3 / box == pytest.approx(0.506, abs=0.002)
    assert hull.A_wp / (hull.length_m * hull.beam_m) == pytest.approx(0.775, abs=0.002)
    metacentre = hull.draught_m + hull.z_B + hull.I_T / hull.volume_m3
    assert 1.0 < metacentre - 6.2 < 1.4  # metacentric height with G 6.2 m above the keel


def test_long_wave_forces_are_the_hydrostatic_ones(hull: HullDatabase) -> None:
    omega, k = hull.omega[0], hull.omega[0] ** 2 / hull.gravity
    FK = hull.FK[0]
    scale = weight(hull)
    np.testing.assert_allclose(FK[:, 2], scale * hull.A_wp, rtol=0.01)
    along, across = np.cos(hull.beta), np.sin(hull.beta)
    thrust = -1j * k * scale * hull.volume_m3
    peak = abs(thrust)
    np.testing.assert_allclose(FK[:, 0], thrust * along, atol=0.02 * peak)
    np.testing.assert_allclose(FK[:, 1], thrust * across, atol=0.02 * peak)
    heel = 1j * k * scale * (hull.I_T + hull.volume_m3 * hull.z_B)
    np.testing.assert_allclose(FK[:, 3], heel * across, atol=0.02 * abs(heel))
    trim = 1j * k * (hull.I_L + hull.volume_m3 * hull.z_B) * along
    np.testing.assert_allclose(FK[:, 4], -scale * (hull.S_x + trim), atol=0.02 * scale * np.abs(trim).max())
    assert omega < 0.12


def test_long_wave_diffraction_is_added_mass_times_the_wave_s_acceleration(hull: HullDatabase) -> None:
    """G. I. Taylor's theorem: sideways the diffraction force is A22 times the acceleration of the water at O."""
    i = 1
    acceleration = -1j * hull.omega[i] ** 2 * np.sin(hull.beta)
    for dof in (1, 3):
        expected = hull.A[i, dof, 1] * acceleration
        np.testing.assert_allclose(hull.FD[i, :, dof], expected, atol=0.05 * np.abs(expected).max())


def test_radiation_is_symmetric_coupled_as_the_hull_and_loses_energy(hull: HullDatabase) -> None:
    for matrix in (hull.A, hull.B):
        np.testing.assert_array_equal(matrix, matrix.transpose(0, 2, 1))
        assert not matrix[:, EVEN][:, :, ODD].any()
    size = np.sqrt(np.einsum("nii->ni", hull.B).max(axis=0))
    assert np.linalg.eigvalsh(hull.B / np.outer(size, size)).min() > -1e-7  # single precision in the file
    assert np.linalg.eigvalsh(hull.A).min() > 0.0


def test_damping_is_the_energy_of_the_waves_that_the_excitation_tells_of(hull: HullDatabase) -> None:
    """Haskind and Newman: B_ii = omega k / (4 pi rho g^2) times the integral of |F_i|^2 over all directions."""
    total = hull.FK + hull.FD
    around = 2.0 * np.trapezoid(np.abs(total) ** 2, hull.beta, axis=1)
    haskind = (hull.omega**3 / (4.0 * np.pi * hull.water_density * hull.gravity**3))[:, None] * around
    damping = np.einsum("nii->ni", hull.B)
    used = (hull.omega > 0.35) & (hull.omega < 1.6)
    np.testing.assert_allclose(haskind[used], damping[used], rtol=0.035)


def test_no_frequency_sticks_out(hull: HullDatabase) -> None:
    """An irregular frequency would show as a spike of several per cent against the neighbours."""
    omega = hull.omega
    assert np.allclose(np.diff(omega), omega[1] - omega[0])
    for matrix in (hull.A, hull.B):
        curve = np.einsum("nii->ni", matrix)
        neighbours = (-curve[:-4] + 4 * curve[1:-3] + 4 * curve[3:-1] - curve[4:]) / 6.0
        high = omega[2:-2] > 1.0  # the inside of the hull has no resonance below
        assert (np.abs(curve[2:-2] - neighbours)[high] / curve.max(axis=0)).max() < 2e-3


# --- interpolation ---------------------------------------------------------------------------------------------------


def test_interpolation_passes_through_the_table(hull: HullDatabase) -> None:
    A, B = hull.radiation(-hull.omega)  # the sign does not matter
    np.testing.assert_allclose(A, hull.A, rtol=1e-12)
    np.testing.assert_allclose(B, hull.B, rtol=1e-12)
    omega, beta = (grid.ravel() for grid in np.meshgrid(hull.omega, hull.beta, indexing="ij"))
    for got, table in zip(hull.excitation(omega, beta), (hull.FK, hull.FD), strict=True):
        np.testing.assert_allclose(got.reshape(table.shape), table, atol=1e-10 * np.abs(table).max())


def test_the_trios_are_the_whole_of_the_radiation(hull: HullDatabase) -> None:
    omega, _ = everywhere(hull, 40)
    trios, own = hull.radiation_trios(-omega), hull.own_radiation(omega)
    for part, matrix in enumerate(hull.radiation(omega)):
        for trio, dofs in enumerate((EVEN, ODD)):
            np.testing.assert_array_equal(trios[part, trio].transpose(2, 0, 1), matrix[:, dofs][:, :, dofs])
            np.testing.assert_array_equal(own[part, trio].T, np.einsum("nii->ni", matrix)[:, dofs])
        assert not matrix[:, EVEN][:, :, ODD].any()


def test_between_the_nodes_the_force_is_the_exact_one(hull: HullDatabase, tool: Callable[[str], ModuleType]) -> None:
    shape = tool("frigate_hull")
    omega, beta = everywhere(hull, 60)
    got, _ = hull.excitation(omega, beta)
    constants = (hull.water_density, hull.gravity)
    pairs = zip(omega, beta, strict=True)
    exact = np.concatenate(
        [shape.froude_krylov(shape.FrigateHull(), w**2 / hull.gravity, np.array([b]), *constants) for w, b in pairs]
    )
    assert (np.abs(got - exact).max(axis=0) / np.abs(hull.FK).max(axis=(0, 1))).max() < 2e-3


def test_the_other_side_mirrors(hull: HullDatabase) -> None:
    omega, beta = everywhere(hull)
    sign = np.array([1, -1, 1, -1, 1, -1])
    for here, mirrored, around in zip(
        hull.excitation(omega, beta),
        hull.excitation(omega, -beta),
        hull.excitation(omega, beta + 4 * np.pi),
        strict=True,
    ):
        np.testing.assert_allclose(mirrored, here * sign, atol=1e-12 * np.abs(here).max())
        np.testing.assert_allclose(around, here, atol=1e-9 * np.abs(here).max())
    for end in (0.0, np.pi, -np.pi, 3 * np.pi):
        for force in hull.excitation(omega, np.full(omega.shape, end)):
            assert np.abs(force[:, ODD]).max() < 1e-6 * np.abs(force).max()


def test_one_direction_serves_all_frequencies(hull: HullDatabase) -> None:
    omega, _ = everywhere(hull)
    one, many = hull.excitation(omega, np.array(0.7)), hull.excitation(omega, np.full(omega.shape, 0.7))
    np.testing.assert_array_equal(one, many)


def test_beyond_the_table_nothing_surprises(hull: HullDatabase) -> None:
    last, omega = hull.omega[-1], np.linspace(0.0, 8.0, 8001)
    A, B = hull.radiation(omega)
    forces = hull.excitation(omega, np.full(omega.shape, 2.0))
    assert all(np.isfinite(part).all() for part in (A, B, *forces))
    size = np.sqrt(np.einsum("nii->ni", hull.B).max(axis=0))
    assert np.linalg.eigvalsh(B / np.outer(size, size)).min() > -1e-6
    for curve in (*(np.einsum("nii->ni", m) for m in (A, B)), *forces):  # no jump anywhere, 1 mrad/s apart
        assert (np.abs(np.diff(curve, axis=0)).max(axis=0) / np.abs(curve).max(axis=0)).max() < 0.05
    above, below = omega > last, omega < hull.omega[0]
    np.testing.assert_allclose(A[below], np.broadcast_to(hull.A[0], A[below].shape), rtol=1e-12)
    share = omega[below] / hull.omega[0]
    heave = B[below, 2, 2] / hull.B[0, 2, 2]
    np.testing.assert_allclose(heave, share**3, atol=0.02)
    np.testing.assert_allclose(A[above], np.broadcast_to(hull.A[-1], A[above].shape), rtol=1e-12)
    np.testing.assert_allclose(B[above], hull.B[-1] * (last / omega[above])[:, None, None] ** 4, rtol=1e-9)
    for force in forces:
        size = np.abs(force[above]).max(axis=1)
        assert (np.diff(size) < 0.0).all()
        assert size[-1] < 0.01 * size[0]


def test_at_rest_only_hydrostatics_is_left(hull: HullDatabase) -> None:
    A, B = hull.radiation(np.zeros(1))
    FK, FD = hull.excitation(np.zeros(1), np.array([1.0]))
    np.testing.assert_array_equal(A[0], hull.A[0])
    assert not B.any()
    assert np.abs(FD).max() < 1e-9 * np.abs(FK).max()
    expected = weight(hull) * np.array([0.0, 0.0, hull.A_wp, 0.0, -hull.S_x, 0.0])
    np.testing.assert_allclose(FK[0], expected, atol=1e-9 * np.abs(FK).max())


# --- scaling ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("factor", [0.5, 1.14])
def test_froude_scaling_keeps_the_dimensionless_ship(hull: HullDatabase, factor: float) -> None:
    big = hull.scaled(factor)
    omega, beta = everywhere(hull, 50)
    length = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    for ours, theirs, power in zip(
        hull.radiation(omega), big.radiation(omega / np.sqrt(factor)), (3.0, 2.5), strict=True
    ):
        np.testing.assert_allclose(theirs, ours * factor**power * np.outer(length, length), rtol=1e-6, atol=1e-3)
    for ours, theirs in zip(hull.excitation(omega, beta), big.excitation(omega / np.sqrt(factor), beta), strict=True):
        np.testing.assert_allclose(theirs, ours * factor**2 * length, rtol=1e-6, atol=1e-7 * np.abs(theirs).max())
    assert big.volume_m3 / (big.length_m * big.beam_m * big.draught_m) == pytest.approx(
        hull.volume_m3 / (hull.length_m * hull.beam_m * hull.draught_m)
    )
    assert big.z_B + big.I_T / big.volume_m3 == pytest.approx(factor * (hull.z_B + hull.I_T / hull.volume_m3))
    assert big.I_L / big.A_wp == pytest.approx(factor**2 * hull.I_L / hull.A_wp)
    assert big.S_x / big.A_wp == pytest.approx(factor * hull.S_x / hull.A_wp)
    assert big.provenance["scale"] == factor


def test_scaling_there_and_back(hull: HullDatabase) -> None:
    back = hull.scaled(1.6).scaled(1 / 1.6)
    np.testing.assert_allclose(back.A, hull.A, rtol=1e-12)
    np.testing.assert_allclose(back.FD, hull.FD, rtol=1e-12)
    assert back.provenance["scale"] == pytest.approx(1.0)
    assert hull.scaled(1.0) is hull


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf, 1e6, 1e-3])
def test_a_scale_that_is_none_is_refused(hull: HullDatabase, factor: float) -> None:
    with pytest.raises(ConfigurationError, match="scale"):
        hull.scaled(factor)


# --- files -----------------------------------------------------------------------------------------------------------


def stored() -> dict[str, np.ndarray]:
    with np.load(DATA / "frigate.npz", allow_pickle=False) as file:
        return {key: file[key] for key in file.files}


def test_the_file_is_small_and_read_once(hull: HullDatabase) -> None:
    path = DATA / "frigate.npz"
    assert path.stat().st_size < 300_000
    assert load_hull("frigate") is hull
    assert load_hull(path) is hull
    assert {"numbers", "command", "code", "date", "assumed"} <= hull.provenance.keys()


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    path, arrays = tmp_path / "mine.npz", stored()
    np.savez(path, **arrays)
    first = load_hull(path)
    arrays["name"] = np.array("another")
    np.savez(path, **arrays)
    assert (first.name, load_hull(path).name) == ("frigate", "another")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"B": None}, "lacks B"),
        ({"provenance": np.array("not json")}, "provenance"),
        ({"provenance": np.array("3")}, "provenance"),
        ({"A": np.zeros((3, 6, 6))}, "A = "),
        ({"volume_m3": np.array(np.nan)}, "volume_m3"),
        ({"volume_m3": np.array(-1.0)}, "volume_m3"),
        ({"omega": np.linspace(2.4, 0.1, 59)}, "omega"),
        ({"omega": np.linspace(0.0, 2.4, 59)}, "omega"),
        ({"beta": np.linspace(0.0, 3.0, 46)}, "beta"),
        ({"omega": np.array(0.5)}, "omega"),
        ({"length_m": np.array([1.0, 2.0])}, "length_m"),
        ({"A": np.full((59, 6, 6), "a")}, "A"),
        ({"FD": np.full((59, 46, 6), np.inf)}, "FD"),
        ({"name": np.array({"a": 1}, dtype=object)}, "without objects"),
    ],
)
def test_a_database_that_does_not_fit_is_refused(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    path = tmp_path / "mine.npz"
    np.savez(path, **{key: value for key, value in (stored() | change).items() if value is not None})
    with pytest.raises(ConfigurationError) as refused:
        load_hull(path)
    message = str(refused.value)
    assert words in message
    assert "mine.npz" in message
    assert "\n" not in message


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    text = tmp_path / "text.npz"
    text.write_text("not an archive")
    with pytest.raises(ConfigurationError, match="not a hull database"):
        load_hull(text)
    (tmp_path / "empty.npz").touch()
    with pytest.raises(ConfigurationError, match="not a hull database"):
        load_hull(tmp_path / "empty.npz")
    array = tmp_path / "array.npz"
    with array.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(ConfigurationError, match="not a hull database"):
        load_hull(array)
    for name in ("frigat", tmp_path / "missing.npz"):
        with pytest.raises(ConfigurationError, match=r"hull: database = .*\(frigate\)"):
            load_hull(name)


# --- the tool --------------------------------------------------------------------------------------------------------


def test_the_stored_hydrostatics_are_those_of_the_formula(
    hull: HullDatabase, tool: Callable[[str], ModuleType]
) -> None:
    shape = tool("frigate_hull")
    still = shape.hydrostatics(shape.FrigateHull(**hull.provenance["numbers"]))
    for key in ("volume_m3", "z_B", "A_wp", "S_x", "I_T", "I_L"):
        assert getattr(hull, key) == pytest.approx(still[key], rel=1e-9)


def test_the_panels_close_the_hull(tool: Callable[[str], ModuleType]) -> None:
    shape = tool("frigate_hull")
    frigate = shape.FrigateHull()
    still = shape.hydrostatics(frigate)
    corners = shape.half_panels(frigate, 60, 9)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2.0  # into the water, x area
    centre = corners.mean(axis=1)
    assert 2.0 * normal[:, 2].sum() == pytest.approx(-still["A_wp"], rel=2e-3)
    assert abs(normal[:, 0].sum()) < 1e-9 * np.abs(normal).sum()
    for axis in range(3):
        assert 2.0 * (normal[:, axis] * centre[:, axis]).sum() == pytest.approx(still["volume_m3"], rel=0.01)
    lid = shape.half_lid(frigate, 48, 4)
    area = np.cross(lid[:, 2] - lid[:, 0], lid[:, 3] - lid[:, 1])[:, 2]
    assert abs(area.sum()) == pytest.approx(still["A_wp"], rel=2e-3)


def test_a_coarse_rebuild_agrees(hull: HullDatabase, tool: Callable[[str], ModuleType]) -> None:
    pytest.importorskip("capytaine")
    build_rao = tool("build_rao")
    shape = tool("frigate_hull")
    coarse = build_rao.Resolution(along=26, around=6, lid_along=16, lid_across=3)
    omega, beta = np.array([0.5, 1.0]), np.radians([0.0, 90.0, 150.0])
    arrays = build_rao.build(shape.FrigateHull(), coarse, omega, beta, quiet=True)
    for key, table in zip(("A", "B"), hull.radiation(omega), strict=True):
        ours, theirs = (np.einsum("nii->ni", matrix) for matrix in (arrays[key], table))
        np.testing.assert_allclose(ours, theirs, rtol=0.08)
    grid = (part.ravel() for part in np.meshgrid(omega, beta, indexing="ij"))
    FD = hull.excitation(*grid)[1].reshape(2, 3, 6)
    assert (np.abs(arrays["FD"] - FD).max(axis=(0, 1)) / np.abs(FD).max(axis=(0, 1))).max() < 0.05


# --- the forward-speed fixture ---------------------------------------------------------------------------------------


def test_the_fixture_s_motions_solve_its_equation(record: dict[str, Any], tool: Callable[[str], ModuleType]) -> None:
    solve = tool("forward_speed").solve_motion
    for point in record["points"]:
        force = sum(np.array(point[key]["re"]) + 1j * np.array(point[key]["im"]) for key in ("FK", "FD"))
        motion = np.array(point["motion_of_G"]["re"]) + 1j * np.array(point["motion_of_G"]["im"])
        k = point["omega"] ** 2 / record["inputs"]["gravity"]
        encounter = point["omega"] - k * point["speed_mps"] * np.cos(np.radians(point["heading_deg"]))
        assert encounter == pytest.approx(point["omega_e"], rel=1e-6)
        ours = solve(np.array(point["A"]), np.array(point["B"]), force, encounter, record["inputs"])
        np.testing.assert_allclose(ours, motion, atol=1e-4 * np.abs(motion).max())


def test_the_fixture_belongs_to_the_database(
    hull: HullDatabase, record: dict[str, Any], tool: Callable[[str], ModuleType]
) -> None:
    assert record["provenance"]["hull"] == hull.provenance["numbers"]
    inputs = tool("forward_speed").ship_inputs(tool("frigate_hull").FrigateHull())
    for key in ("inertia", "restoring"):
        np.testing.assert_allclose(record["inputs"][key], inputs[key], rtol=1e-6, atol=1.0)
    for key in ("stiffness", "damping"):
        ours = inputs["restraint"][key]
        np.testing.assert_allclose(record["inputs"]["restraint"][key], ours, rtol=1e-4)
    for point in record["points"]:
        A, _ = hull.radiation(np.array([point["omega_e"]]))
        assert point["A"][2][2] == pytest.approx(A[0, 2, 2], rel=0.05)  # speed enters heave through omega_e only
        FK, _ = hull.excitation(np.array([point["omega"]]), np.radians(point["beta_bem_deg"]))
        exact = np.array(point["FK"]["re"]) + 1j * np.array(point["FK"]["im"])
        np.testing.assert_allclose(FK[0], exact, atol=2e-3 * np.abs(exact).max())
