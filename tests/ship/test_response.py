"""The ship's response: limits, signs, forward-speed terms written out as published, and a BEM with forward speed."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.cramer import determinant, solve3
from ssmash_gym.ship.hull import load_hull
from ssmash_gym.ship.response import (
    LATERAL,
    LONGITUDINAL,
    TO_PACKAGE,
    Guards,
    HullResponse,
    Loading,
)
from ssmash_gym.ship.roll_damping import RollDamping
from ssmash_gym.ship.seaway_statistics import deck_transfer

G = 9.81
KNOT = 1852.0 / 3600.0
LOADING = Loading(6.2, (0.38 * 14.8, 0.25 * 124.5, 0.25 * 124.5))
LAW = RollDamping(z0=0.02, z_speed=0.4, z_rate=0.1)
FREE = Guards(encounter_floor_radps=1e-6, restraint_period_s=1e9, restraint_damping=0.3, high_pass_radps=1e-6)
SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
SPEEDS = (0.0, 5.0, 9.26)
HEADINGS = np.radians([0.0, 30.0, 90.0, 135.0, 180.0, 225.0, 300.0])


def ship(z0: float | None = None, guards: Guards | None = None, scale: float = 1.0) -> HullResponse:
    """The frigate hull; with `z0`, its roll damping is that share of critical whatever speed and sea."""
    law = LAW if z0 is None else RollDamping(z0=z0, z_speed=0.0, z_rate=0.0)
    loading = Loading(scale * LOADING.kg_m, tuple(scale * radius for radius in LOADING.radii_m))
    return HullResponse(load_hull("frigate").scaled(scale), loading, law, guards)


# --- limits and signs ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("heading", HEADINGS)
def test_a_long_wave_carries_the_ship_along(speed: float, heading: float) -> None:
    omega = np.array([0.1])
    k = omega**2 / G
    response = ship(0.1, FREE).respond(omega, heading, 0.0, speed)
    H, overtaking = response.transfer[0], omega[0] / response.omega_e[0]
    assert H[HEAVE] == pytest.approx(-1.0, abs=0.01)  # z down: the deck goes up with the surface
    assert H[ROLL] / k == pytest.approx(1j * np.sin(heading), abs=0.08)  # 1 / (1 - (0.1 / 0.57)^2) = 1.03 and damping
    assert H[PITCH] / k == pytest.approx(-1j * np.cos(heading), abs=0.02)
    # A slender hull feels the pressure gradient, so its acceleration is that of the water, at the encounter frequency.
    assert H[SURGE] == pytest.approx(-1j * np.cos(heading) * overtaking**2, abs=0.03)
    if speed == 0.0:
        assert H[SWAY] == pytest.approx(-1j * np.sin(heading), abs=0.03)


@pytest.mark.parametrize("speed", SPEEDS)
def test_the_guards_leave_heave_pitch_and_roll_of_long_waves(speed: float) -> None:
    omega = np.array([0.25])
    k = omega**2 / G
    for heading in HEADINGS:
        guarded = ship(0.1).respond(omega, heading, 0.0, speed).transfer[0]
        free = ship(0.1, FREE).respond(omega, heading, 0.0, speed).transfer[0]
        assert guarded[HEAVE] == pytest.approx(free[HEAVE], abs=0.01)
        assert guarded[PITCH] / k == pytest.approx(free[PITCH] / k, abs=0.04)
        assert guarded[ROLL] / k == pytest.approx(free[ROLL] / k, abs=0.12)


def test_the_ship_follows_the_slope_of_the_surface() -> None:
    """In time and with the surface itself: where it rises to starboard, the ship rolls to port (negative)."""
    omega, heading, speed = 0.12, np.radians(60.0), 0.0
    response = ship(0.05).respond(np.array([omega]), heading, 1.0, speed)
    k, t = omega**2 / G, np.linspace(0.0, 100.0, 400)

    def surface(x: float, y: float) -> np.ndarray:
        return np.cos(omega * t - k * (x * np.cos(heading) + y * np.sin(heading)) + 0.7)

    motion = np.real(response.transfer[0] * np.exp(1j * (response.omega_e[0] * t[:, np.newaxis] + 0.7)))
    rising_to_starboard = (surface(0.0, 0.5) - surface(0.0, -0.5)) / 1.0
    rising_forward = (surface(0.5, 0.0) - surface(-0.5, 0.0)) / 1.0
    amplitude = k * np.sin(heading)
    np.testing.assert_allclose(motion[:, ROLL], -rising_to_starboard, atol=0.08 * amplitude)
    np.testing.assert_allclose(motion[:, PITCH], rising_forward, atol=0.05 * k)
    np.testing.assert_allclose(motion[:, HEAVE], -surface(0.0, 0.0), atol=0.01)


@pytest.mark.parametrize("speed", SPEEDS)
def test_waves_from_the_other_side_mirror_the_motion(speed: float) -> None:
    omega = np.linspace(0.3, 1.8, 40)
    port, starboard = (ship().respond(omega, sign * 1.1, 0.05, speed).transfer for sign in (-1.0, 1.0))
    np.testing.assert_allclose(port, starboard * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0]), rtol=1e-12)


def test_encounter_frequency_keeps_its_sign() -> None:
    omega = np.array([0.5, 1.5])
    response = ship().respond(omega, 0.0, 0.1, 9.0)
    np.testing.assert_allclose(response.omega_e, omega - omega**2 / G * 9.0)
    assert response.omega_e[0] > 0.0 > response.omega_e[1]


def test_short_waves_do_not_move_the_ship() -> None:
    for heading in HEADINGS:
        transfer = ship().respond(np.array([2.3]), heading, 0.01, 0.0).transfer[0]
        assert np.all(np.abs(transfer[:3]) < 0.15)


@pytest.mark.parametrize("heading", HEADINGS)
def test_nothing_blows_up_where_the_ship_runs_with_the_waves(heading: float) -> None:
    speed = 10.0
    omega = np.sort(np.append(np.linspace(0.2, 2.4, 600), G / speed))  # the last one: omega_e = 0 at heading 0
    transfer = ship().respond(omega, heading, 0.01, speed).transfer
    assert np.isfinite(transfer).all()
    assert np.all(np.abs(transfer[:, :3]) < 3.0)  # surge of 16 m/m without the guards
    assert np.all(np.abs(transfer[:, 3:]) < np.radians(15.0))


# --- equations -----------------------------------------------------------------------------------------------------


def published(response: HullResponse, omega: float, heading: float, speed: float, zeta: float) -> np.ndarray:
    """Motion of G, (6,): Salvesen, Tuck & Faltinsen's coefficients term by term, e^{+i}, 6 x 6, NumPy's solver."""
    we = omega - omega**2 / G * speed * np.cos(heading)
    A0, B0 = (part[0] for part in response.hull.radiation(np.array([abs(we)])))
    Aw, Bw = (part[0] for part in response.hull.radiation(np.array([omega])))
    FK, FD = (part[0] for part in response.hull.excitation(np.array([omega]), -heading))
    FD = np.conj(FD) * (we * np.diag(A0) - 1j * np.diag(B0)) / (omega * np.diag(Aw) - 1j * np.diag(Bw))
    A, B, U = A0.copy(), B0.copy(), speed
    for j in (SURGE, HEAVE):  # A35 and, in the same way, the surge-pitch pair
        A[j, PITCH] -= U / we**2 * B0[j, HEAVE]
        B[j, PITCH] += U * A0[j, HEAVE]
        A[PITCH, j] += U / we**2 * B0[HEAVE, j]
        B[PITCH, j] -= U * A0[HEAVE, j]
    A[PITCH, PITCH] += U**2 / we**2 * A0[HEAVE, HEAVE]
    B[PITCH, PITCH] += U**2 / we**2 * B0[HEAVE, HEAVE]
    for j in (SWAY, ROLL):
        A[j, YAW] += U / we**2 * B0[j, SWAY]
        B[j, YAW] -= U * A0[j, SWAY]
        A[YAW, j] -= U / we**2 * B0[SWAY, j]
        B[YAW, j] += U * A0[SWAY, j]
    A[YAW, YAW] += U**2 / we**2 * A0[SWAY, SWAY]
    B[YAW, YAW] += U**2 / we**2 * B0[SWAY, SWAY]
    F = np.conj(FK) + FD
    F[PITCH] -= U / (1j * we) * FD[HEAVE]
    F[YAW] += U / (1j * we) * FD[SWAY]
    spring, damper = response.restraint
    B[ROLL, ROLL] += zeta * response.critical_roll_damping
    Z = -(we**2) * (response.inertia + A) + 1j * we * (B + damper) + response.stiffness + spring
    X = np.linalg.solve(Z, F)
    X[:3] += np.cross(X[3:], [0.0, 0.0, response.z_G])  # from O to G
    X *= np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
    high_pass = (we / 0.20) ** 4 / (1.0 + (we / 0.20) ** 4)
    return X * np.array([high_pass, high_pass, 1.0, 1.0, 1.0, high_pass])


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize(("omega", "heading_deg"), [(0.5, 40.0), (0.7, 90.0), (0.9, 150.0), (0.6, 250.0), (1.6, 10.0)])
def test_forward_speed_terms_are_those_published(speed: float, omega: float, heading_deg: float) -> None:
    heading, response = np.radians(heading_deg), ship(0.08)
    H = response.respond(np.array([omega]), heading, 0.0, speed).transfer[0]
    np.testing.assert_allclose(H, published(response, omega, heading, speed, 0.08), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("trio", [LONGITUDINAL, LATERAL])
def test_reversed_stream_swaps_cause_and_effect(trio) -> None:
    """Timman and Newman's relation: the coefficient of i by j at U is that of j by i at -U."""
    response = ship(0.1, Guards(restraint_period_s=1e12))
    omega = np.array([0.4, 0.8, 1.3])
    radiation, excitation = response.hull.radiation_trios(omega), response.hull.excitation(omega, -1.0)
    ahead, astern = (response._equations(trio, omega, omega, U, radiation, excitation)[0] for U in (8.0, -8.0))
    scale = np.abs(ahead).max(axis=(0, 1))
    np.testing.assert_allclose(ahead / scale, astern.transpose(1, 0, 2) / scale, atol=1e-9)
    assert np.abs(ahead - ahead.transpose(1, 0, 2)).max() > 1e5  # they do differ at speed


def test_closed_form_solver() -> None:
    rng = np.random.default_rng(5)
    Z = rng.standard_normal((3, 3, 50)) + 1j * rng.standard_normal((3, 3, 50))
    F = rng.standard_normal((3, 50)) + 1j * rng.standard_normal((3, 50))
    expected = np.linalg.solve(Z.transpose(2, 0, 1), F.T[..., np.newaxis])[..., 0]
    np.testing.assert_allclose(np.stack(solve3(Z, F), axis=1), expected, rtol=1e-8)
    np.testing.assert_allclose(determinant(Z), np.linalg.det(Z.transpose(2, 0, 1)), rtol=1e-10)


def test_froude_scaled_ship_moves_alike() -> None:
    scale, omega, heading = 1.4, np.linspace(0.4, 1.6, 30), np.linspace(0.0, 3.0, 30)
    root = np.sqrt(scale)
    guards = Guards(encounter_floor_radps=0.15 / root, restraint_period_s=120.0 * root, high_pass_radps=0.20 / root)
    small = ship().respond(omega, heading, 0.05, 6.0)
    large = ship(guards=guards, scale=scale).respond(omega / root, heading, 0.05 * scale, 6.0 * root)
    assert large.roll_damping == pytest.approx(small.roll_damping, rel=1e-9)
    turning = np.array([1.0, 1.0, 1.0, scale, scale, scale])
    np.testing.assert_allclose(large.transfer * turning, small.transfer, rtol=1e-6, atol=1e-9)


# --- roll ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("zeta", [0.02, 0.06])
def test_roll_damping_is_the_share_of_critical_that_it_says(zeta: float) -> None:
    """Half-power width of the resonance in beam seas at rest: 2 zeta of the natural frequency."""
    omega = np.linspace(0.4, 0.8, 8001)
    moment_like = np.abs(ship(zeta).respond(omega, np.pi / 2.0, 0.0, 0.0).transfer[:, ROLL]) / omega**2
    above = omega[moment_like > moment_like.max() / np.sqrt(2.0)]
    peak = omega[moment_like.argmax()]
    assert (above[-1] - above[0]) / (2.0 * peak) == pytest.approx(zeta + 0.0012, rel=0.06)
    assert 2.0 * np.pi / peak == pytest.approx(ship().natural_period_s["roll"], rel=0.02)


def test_roll_of_a_beam_sea_at_rest_is_that_of_its_resonance() -> None:
    """RMS roll from many components against the area under the resonance peak, pi zeta omega |H|^2 S."""
    omega = np.linspace(0.3, 1.2, 1500)
    density = 0.05
    amplitude = np.full_like(omega, np.sqrt(2.0 * density * (omega[1] - omega[0])))
    response = ship().respond(omega, np.pi / 2.0, amplitude, 0.0)
    gain = np.abs(response.transfer[:, ROLL])
    rms = np.sqrt(0.5 * np.sum((gain * amplitude) ** 2))
    area = np.pi * response.roll_damping * omega[gain.argmax()] * gain.max() ** 2 * density
    assert rms == pytest.approx(np.sqrt(area), rel=0.12)


@pytest.mark.parametrize("factor", [0.7, 1.0, 1.3])
@pytest.mark.parametrize("speed", SPEEDS)
def test_damping_agrees_with_the_rolling_that_it_leaves(speed: float, factor: float) -> None:
    omega = np.linspace(0.4, 1.4, 96)
    amplitude = np.full(96, 0.12)
    response = ship().respond(omega, 1.8, amplitude, speed, roll_damping_factor=factor)
    rate = np.sqrt(0.5 * np.sum(np.abs(response.omega_e * response.transfer[:, ROLL] * amplitude) ** 2))
    law = LAW.ratio(speed / np.sqrt(G * 124.5), rate, np.sqrt(124.5 / G))
    assert response.converged
    assert response.roll_damping == pytest.approx(factor * law, rel=1e-8)
    assert response.roll_damping > factor * LAW.ratio(speed / np.sqrt(G * 124.5), 0.0, 1.0)


def test_a_higher_sea_rolls_the_ship_less_than_in_proportion() -> None:
    omega = np.linspace(0.4, 1.0, 96)
    low, high = (ship().respond(omega, np.pi / 2.0, height, 0.0) for height in (0.02, 0.2))
    assert high.roll_damping > 1.3 * low.roll_damping
    assert np.abs(high.transfer[:, ROLL]).max() < 0.8 * np.abs(low.transfer[:, ROLL]).max()
    np.testing.assert_array_equal(high.transfer[:, [HEAVE, PITCH]], low.transfer[:, [HEAVE, PITCH]])


@pytest.mark.parametrize("gm_factor", [0.85, 1.2])
def test_metacentric_height_shifts_the_roll_period_only(gm_factor: float) -> None:
    omega = np.linspace(0.4, 0.8, 2001)
    nominal, changed = (
        ship(0.03).respond(omega, np.pi / 2.0, 0.0, 0.0, gm_factor=gm).transfer for gm in (1.0, gm_factor)
    )
    peaks = [omega[np.argmax(np.abs(transfer[:, ROLL]) / omega**2)] for transfer in (nominal, changed)]
    assert peaks[1] / peaks[0] == pytest.approx(np.sqrt(gm_factor), rel=0.01)
    np.testing.assert_array_equal(nominal[:, [SURGE, HEAVE, PITCH]], changed[:, [SURGE, HEAVE, PITCH]])


# --- against a boundary-element solution with forward speed --------------------------------------------------------

FIXTURE = json.loads((Path(__file__).parents[1] / "data" / "forward_speed.json").read_text(encoding="utf-8"))
POINTS = {f"{p['speed_kn']:g}kn-{p['heading_deg']:g}deg-{p['omega']:g}": p for p in FIXTURE["points"]}
COMPARED = (HEAVE, ROLL, PITCH)
BAND, BAND_UP_TO = 0.20, 0.6  # share; wave frequency [rad/s]
# A motion below this is nothing: roll in head seas, and pitch in beam seas, which is a small difference of large
# forces (a tenth of the slope there).
NOTHING = 0.1
TURNED, TURNED_ROLL = 8.0, 40.0  # of phase [deg]
DECK = np.array([-45.0, 0.0, -6.0])
FELT, BAND_FORCE = 0.05, 0.30  # lateral specific force at the deck that counts [m/s2 per metre of wave]; share


@pytest.mark.parametrize("name", POINTS)
def test_response_at_speed_against_a_solution_with_the_speed_in_it(name: str) -> None:
    point, inputs = POINTS[name], FIXTURE["inputs"]
    response = ship(inputs["roll_damping_N_m_s"] / ship().critical_roll_damping)
    omega, omega_e, heading = point["omega"], point["omega_e"], np.radians(point["heading_deg"])
    H = response.respond(np.array([omega]), heading, 0.0, point["speed_mps"]).transfer[0]
    G_bem = np.array(point["motion_of_G"]["re"]) + 1j * np.array(point["motion_of_G"]["im"])
    native = np.conj(G_bem) * TO_PACKAGE
    native[[SURGE, SWAY, YAW]] *= (omega_e / 0.20) ** 4 / (1.0 + (omega_e / 0.20) ** 4)  # the fixture has no high-pass
    unit = np.array([1.0, 1.0, 1.0, *3 * [omega**2 / G]])
    ratios = {dof: abs(H[dof]) / abs(native[dof]) for dof in range(6) if abs(native[dof]) > 0.01 * unit[dof]}
    turned = {dof: np.degrees(np.angle(H[dof] / native[dof])) for dof in ratios}
    figures = (
        f"{DOFS[dof]} {abs(native[dof] / unit[dof]):.3f} x {ratios[dof]:.2f} {turned[dof]:+.0f}" for dof in ratios
    )
    forces = [
        deck_transfer(np.array([omega_e]), motion[np.newaxis], DECK, np.zeros(2)).lateral_specific_force[0]
        for motion in (H, native)
    ]
    print(name, *figures, f"f_y {abs(forces[1]):.3f} x {abs(forces[0]) / max(abs(forces[1]), 1e-9):.2f}")
    if omega <= BAND_UP_TO:
        checked = [dof for dof in COMPARED if abs(native[dof]) > NOTHING * unit[dof]]
        assert checked
        for dof in checked:
            assert ratios[dof] == pytest.approx(1.0, abs=BAND), DOFS[dof]
            assert abs(turned[dof]) < (TURNED_ROLL if dof == ROLL else TURNED), DOFS[dof]
        if abs(forces[1]) > FELT:
            assert abs(forces[0]) / abs(forces[1]) == pytest.approx(1.0, abs=BAND_FORCE)
    else:  # printed; both are small there
        assert np.all(np.abs(H[COMPARED,] - native[COMPARED,]) < np.array([0.3, 1.5, 0.2]) * unit[COMPARED,])


def test_the_reference_stands_on_the_same_ship() -> None:
    inputs, response = FIXTURE["inputs"], ship()
    np.testing.assert_allclose(inputs["inertia"], response.inertia, rtol=1e-6, atol=1e3)
    np.testing.assert_allclose(inputs["restoring"], response.stiffness, rtol=1e-5, atol=1e4)
    assert len({point["speed_kn"] for point in FIXTURE["points"]}) >= 2


# --- particulars and mistakes --------------------------------------------------------------------------------------


def test_particulars_of_the_frigate_like_hull() -> None:
    response = ship()
    assert response.mass_kg == pytest.approx(4.76e6, rel=0.01)
    assert response.gm_m == pytest.approx(1.18, abs=0.02)
    assert response.natural_period_s["roll"] == pytest.approx(11.1, rel=0.03)
    assert response.natural_period_s["heave"] == pytest.approx(5.35, rel=0.08)
    assert response.natural_period_s["pitch"] == pytest.approx(5.30, rel=0.08)
    assert np.all(np.linalg.eigvalsh(response.inertia) > 0.0)


def test_a_ship_that_would_capsize_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"kg_m is 9, allowed is less than 7\.\d+ m, the height of the meta"):
        HullResponse(load_hull("frigate"), replace(LOADING, kg_m=9.0), LAW)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"omega": np.array([0.5, 0.0])}, "finite frequencies above 0"),
        ({"omega": np.array([0.5, -0.1])}, "finite frequencies above 0"),
        ({"heading": np.array([0.0, np.nan])}, "finite headings"),
        ({"amplitude": np.array([np.inf, 0.1])}, "finite amplitudes"),
        ({"amplitude": np.ones(3)}, r"amplitude has shape \(3,\) and omega \(2,\)"),
        ({"speed_mps": -1.0}, "speed_mps is -1.0, allowed are finite numbers of 0 or more"),
        ({"speed_mps": np.nan}, "speed_mps is nan"),
        ({"roll_damping_factor": -0.1}, "roll_damping_factor is -0.1"),
        ({"gm_factor": 0.0}, "gm_factor is 0.0, allowed are finite numbers above 0"),
        ({"gm_factor": True}, "gm_factor is True"),
    ],
)
def test_bad_input_costs_one_sentence(change: dict[str, object], message: str) -> None:
    given = {"omega": np.array([0.5, 0.6]), "heading": 0.0, "amplitude": 0.1, "speed_mps": 5.0} | change
    with pytest.raises(ConfigurationError, match=message):
        ship().respond(**given)  # type: ignore[arg-type]
