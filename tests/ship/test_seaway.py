"""The motion of a ship's deck point in a sea, and the configuration section it comes from."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.ship import Motion, MotionTable, Seaway, SeawayMotion, Spectrum, Spreading, draw_seaway, parse_motion
from ssmash_gym.ship import seaway as seaway_module
from ssmash_gym.ship.kinematics import rotation
from ssmash_gym.ship.response import Response
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.waves import Waves
from tests.ship.box_ship import BoxShip

SEVERE = Spectrum(5.0, 12.4)
SECTION = {"type": "seaway", "sea_state": 5, "heading_deg": 90.0, "speed_kn": 10.0}


def sea(seed: int = 0, heading: float = 1.0, speed: float = 5.0, spectrum: Spectrum = SEVERE, **other) -> SeawayMotion:
    return draw_seaway(BoxShip(), spectrum, Spreading(), heading, speed, np.random.default_rng(seed), **other)


def section(**changes: object) -> Seaway:
    return parse_motion({**SECTION, **changes})


# --- kinematics ----------------------------------------------------------------------------------------------------


def one_wave(transfer: list[complex], point: list[float], angles=(0.0, 0.0), omega_e: float = 0.7) -> SeawayMotion:
    """A deck in one regular wave of 1 m with phase 0.4."""
    waves = Waves(np.array([0.7]), np.array([1.0]), np.array([1.0]), np.array([0.4]))
    response = Response(np.array([omega_e]), np.array([transfer], dtype=complex), 0.1, True)
    return SeawayMotion(waves, response, point, angles)


def test_the_motion_is_the_transfer_function_at_the_encounter_frequency() -> None:
    transfer = [0.1 + 0.2j, 0.3j, -0.9 + 0.1j, 0.05j, -0.02, 0.01 + 0.01j]
    for omega_e in (0.7, -0.3, 0.0):
        motion = one_wave(transfer, [0.0, 0.0, 0.0], omega_e=omega_e)
        t = np.linspace(-20.0, 40.0, 61)
        expected = np.real(np.outer(np.exp(1j * (omega_e * t + 0.4)), transfer))
        np.testing.assert_allclose(motion.signal(t).position, expected, atol=1e-14)
        np.testing.assert_allclose(motion.elevation(t), np.cos(omega_e * t + 0.4), atol=1e-14)


def test_the_deck_point_is_carried_by_the_rotation() -> None:
    point, angles = np.array([-45.0, 2.0, -6.0]), np.array([0.1, -0.03])
    transfer = [0.3, 0.2j, -0.8, 0.1j, 0.03, 0.02j]
    centre, deck = one_wave(transfer, [0.0, 0.0, 0.0], angles), one_wave(transfer, list(point), angles)
    t = np.linspace(0.0, 20.0, 41)
    at_G, moved = centre.signal(t).position, deck.signal(t).position
    np.testing.assert_array_equal(at_G[:, 3:], moved[:, 3:])
    lever = rotation(at_G[:, 3:]) - rotation(np.array([0.1, -0.03, 0.0]))
    np.testing.assert_allclose(moved[:, :3], at_G[:, :3] + np.einsum("nij,j->ni", lever, point), atol=1e-13)
    assert deck.mean.tolist() == [0.0, 0.0, 0.0, 0.1, -0.03, 0.0]


@pytest.mark.parametrize("heading", [0.4, 1.6, 2.6])
def test_derivatives_are_those_of_the_position(heading: float) -> None:
    """Velocity, acceleration and turning of the baked table against fourth-order differences of it, in sea state 6."""
    table = sea(heading=heading, speed=9.0, heel=0.03, trim=-0.01).bake(60.0)
    t = np.arange(2.1, 58.0, 0.75)  # a piece's nodes are 0.1 s away

    def slope(part, h: float = 2e-3):
        far, near = (part(table.pose(t + k * h)) - part(table.pose(t - k * h)) for k in (2, 1))
        return (8.0 * near - far) / (12.0 * h)

    pose = table.pose(t)
    turning = np.einsum("nji,njk->nik", pose.R_NS, slope(lambda p: p.R_NS))
    pairs = (
        (pose.v_NS_N, slope(lambda p: p.r_NS_N)),
        (pose.a_NS_N, slope(lambda p: p.v_NS_N)),
        (pose.w_NS_S, np.stack([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]], axis=1)),
        (pose.wdot_NS_S, slope(lambda p: p.w_NS_S)),
    )
    for value, difference in pairs:
        assert np.all(np.abs(value - difference) < 1e-8 * np.std(value, axis=0))


def test_the_exact_signal_has_exact_derivatives() -> None:
    motion, t, h = sea(), np.arange(0.0, 60.0, 0.7), 1e-3
    values = {k: motion.signal(t + k * h) for k in (-2, -1, 0, 1, 2)}
    for lower, upper in itertools.pairwise(range(3)):
        difference = (8.0 * (values[1][lower] - values[-1][lower]) - (values[2][lower] - values[-2][lower])) / (12 * h)
        error = np.abs(difference - values[0][upper]) / np.std(values[0][upper], axis=0)
        assert np.max(error) < 1e-9


def test_evenly_spaced_samples_are_the_signal() -> None:
    motion = sea(seed=3, components=40)
    for start, spacing, count in ((0.0, 0.25, 481), (-7.3, 0.2, 33), (1000.0, 0.25, 2)):
        quick = motion.sample(start, spacing, count)
        exact = motion.signal(start + spacing * np.arange(count))
        for a, b in zip(quick, exact, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-11 * np.max(np.abs(b)))


def test_samples_do_not_depend_on_their_number() -> None:
    motion = sea()
    few, many = motion.sample(5.0, 0.25, 50), motion.sample(5.0, 0.25, 481)
    for a, b in zip(few, many, strict=True):
        np.testing.assert_array_equal(a, b[:50])


def test_a_table_follows_the_signal_between_its_nodes() -> None:
    motion = sea()
    t = np.arange(0.0, 60.0, 0.0317)
    for read, exact, share in zip(motion.bake(60.0).at(t), motion.signal(t), (1e-6, 1e-5, 1e-3), strict=True):
        assert np.max(np.abs(read - exact) / np.std(exact, axis=0)) < share


def test_a_spacing_too_wide_for_the_waves_that_matter_is_refused() -> None:
    motion = sea(heading=math.pi, speed=9.0)
    motion.bake(10.0, 0.25)
    fastest = 2.0 * math.pi / np.max(np.abs(motion.response.omega_e))
    assert fastest < motion.shortest_period_s < 8.0
    with pytest.raises(ConfigurationError, match=r"spacing_s is 4, allowed is at most"):
        motion.bake(10.0, 4.0)


def test_long_waves_carry_the_ship_like_a_cork() -> None:
    """Signs of the whole chain: in a long swell roll is the slope to port, pitch the slope ahead, heave the sea."""
    omega, amplitude, phase = np.array([0.05, 0.07]), np.array([1.0, 2.0]), np.array([0.3, 2.0])
    k = omega**2 / 9.81
    for heading in np.radians([0.0, 50.0, 90.0, 180.0, 250.0]):
        waves = Waves(omega, np.full(2, heading), amplitude, phase)
        response = BoxShip().response.respond(omega, waves.heading, amplitude, 0.0)
        t = np.linspace(0.0, 300.0, 601)
        position = SeawayMotion(waves, response, [0.0, 0.0, 0.0]).signal(t).position
        # zeta = a cos(omega t - k s + phase) along the direction of travel s; its slope there at s = 0:
        slope = np.einsum("tk,k->t", np.sin(np.outer(t, omega) + phase), k * amplitude)
        size = np.std(slope)
        assert np.std(position[:, 2] + SeawayMotion(waves, response, [0, 0, 0]).elevation(t)) < 0.08
        assert np.std(position[:, 3] + np.sin(heading) * slope) < 0.05 * size
        assert np.std(position[:, 4] - np.cos(heading) * slope) < 0.05 * size


# --- draws ---------------------------------------------------------------------------------------------------------


def test_same_seed_same_bits_and_other_seed_other_motion() -> None:
    first, again, other = (section().realise(np.random.default_rng(seed)).bake(30.0).nodes for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert np.max(np.abs(first - other)) > 0.1


def test_bits_do_not_depend_on_threads() -> None:
    code = (
        "import hashlib, numpy as np; from ssmash_gym.ship import parse_motion; "
        f"motion = parse_motion({SECTION!r}).realise(np.random.default_rng(5)); "
        "print(hashlib.sha256(motion.bake(30.0).nodes.tobytes()).hexdigest())"
    )
    here = hashlib.sha256(section().realise(np.random.default_rng(5)).bake(30.0).nodes.tobytes()).hexdigest()
    limits = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    run = subprocess.run([sys.executable, "-c", code], env={**os.environ, **limits}, capture_output=True, text=True)
    assert run.stdout.strip() == here, run.stderr


def test_random_numbers_are_common_to_cells() -> None:
    generators = [np.random.default_rng(2) for _ in range(4)]
    motions = [
        section().realise(generators[0]),
        section(sea_state=3).realise(generators[1]),
        section(heading_deg=200.0, speed_kn=20.0).realise(generators[2]),
        section(spreading="long_crested", spectrum="jonswap").realise(generators[3]),
    ]
    for motion in motions[1:]:
        np.testing.assert_array_equal(motion.waves.phase, motions[0].waves.phase)
    assert len({rng.random() for rng in generators}) == 1


def test_mirrored_headings_mirror_the_motion() -> None:
    """A symmetric ship: waves from the other side move it to the other side, as severely."""
    port, starboard = (sea(heading=angle).deck for angle in (1.1, -1.1))
    for key in ("roll_deg", "pitch_deg", "vertical_velocity_m_s", "lateral_specific_force_g"):
        assert getattr(port, key) == pytest.approx(getattr(starboard, key), rel=0.03)


def test_a_flat_sea_leaves_the_deck_still_and_the_heel_in_place() -> None:
    still = draw_seaway(
        BoxShip(), Spectrum(0.0, 8.0), Spreading(), 1.0, 5.0, np.random.default_rng(0), heel=0.05, trim=-0.02
    )
    table = still.bake(20.0, 0.25, ramp_s=5.0)
    np.testing.assert_array_equal(table.nodes[:, 3:5], np.tile([0.05, -0.02], (81, 1)))
    assert np.all(np.delete(table.nodes, [3, 4], axis=1) == 0.0)
    assert still.deck.roll_deg == 0.0
    assert math.isnan(still.deck.roll_period_s)
    assert still.shortest_period_s == math.inf


def test_the_motion_goes_to_nothing_with_the_height() -> None:
    tiny = sea(spectrum=Spectrum(1e-6, 12.4), heel=0.05)
    table = tiny.bake(20.0)
    assert np.max(np.abs(table.nodes[:, 3] - 0.05)) < 1e-6
    assert np.max(np.abs(table.nodes[:, :3])) < 1e-5
    # Half the height, half the motion, where the damping hardly changes with it.
    half = sea(spectrum=Spectrum(0.5e-6, 12.4))
    assert half.deck.roll_deg == pytest.approx(0.5 * tiny.deck.roll_deg, rel=1e-3)


def test_head_seas_of_one_direction_do_not_roll_the_ship() -> None:
    motion = draw_seaway(BoxShip(), SEVERE, Spreading("long_crested"), math.pi, 5.0, np.random.default_rng(0))
    assert motion.deck.roll_deg < 1e-9
    assert motion.deck.pitch_deg > 0.5


def test_ramps_begin_in_the_heeled_mean_pose() -> None:
    table = sea(heel=0.05, trim=0.01).bake(20.0, ramp_s=5.0)
    np.testing.assert_allclose(table.nodes[0], [0, 0, 0, 0.05, 0.01, *[0.0] * 13], atol=1e-15)


def test_hull_and_loading_reach_the_response() -> None:
    plain = section().realise(np.random.default_rng(0)).deck
    damped = section(roll_damping_factor=1.3).realise(np.random.default_rng(0)).deck
    stiff = section(gm_factor=1.3).realise(np.random.default_rng(0)).deck
    higher = section(deck_shift_m=[0.0, 0.0, -3.0]).realise(np.random.default_rng(0)).deck
    assert damped.roll_deg < 0.95 * plain.roll_deg
    assert stiff.roll_period_s < 0.95 * plain.roll_period_s
    assert higher.lateral_acceleration_g > 1.05 * plain.lateral_acceleration_g
    assert higher.roll_deg == pytest.approx(plain.roll_deg, rel=1e-6)


def test_rolling_beyond_linear_theory_is_said() -> None:
    mild, wild = sea(spectrum=Spectrum(1.9, 8.8)), sea(spectrum=Spectrum(8.0, 12.4), heading=0.5 * math.pi)
    assert mild.outside_validity is None
    assert wild.deck.roll_deg > 6.0
    assert f"roll RMS is {wild.deck.roll_deg:.1f} deg" in (wild.outside_validity or "")


# --- the section ---------------------------------------------------------------------------------------------------


def test_the_section_builds_its_sea_and_comes_back() -> None:
    source = section(heel_deg=2.0, deck_shift_m=[1.0, 0.0, 0.5])
    assert isinstance(source, Seaway)
    assert source.sea() == Spectrum(3.3, 9.7)
    assert parse_motion(source.model_dump(mode="json")) == source
    motion = source.realise(np.random.default_rng(0))
    assert isinstance(motion, SeawayMotion)
    assert isinstance(motion.bake(5.0), MotionTable)
    assert len(motion.waves.omega) == 96
    assert motion.mean[3] == math.radians(2.0)
    assert motion.elevation_rms_m == pytest.approx(3.3 / 4.0, rel=0.01)
    k = motion.waves.omega**2 / 9.81
    encounter = motion.waves.omega - k * 10.0 * KNOT * np.cos(motion.waves.heading)
    np.testing.assert_allclose(motion.response.omega_e, encounter, rtol=1e-12)


def test_seas_by_height_and_period() -> None:
    assert section(sea_state=None, hs_m=1.9).sea() == Spectrum(1.9, 8.8)
    assert section(sea_state=None, hs_m=6.0, tp_s=14.0).sea() == Spectrum(6.0, 14.0)
    assert section(sea_state=None, hs_m=0.0, tp_s=8.0).realise(np.random.default_rng(0)).deck.roll_deg == 0.0
    assert section(spectrum="jonswap").sea() == Spectrum(3.3, 9.7, 3.3)
    assert section(spectrum="jonswap", gamma=2.0).sea() == Spectrum(3.3, 9.7, 2.0)


def test_a_described_ship_is_the_named_one() -> None:
    named = section().realise(np.random.default_rng(0))
    described = section(ship={"base": "frigate", "deck_point_m": [-45.0, 0.0, -6.0]})
    np.testing.assert_array_equal(
        described.realise(np.random.default_rng(0)).signal([1.0]).position, named.signal([1.0]).position
    )
    assert parse_motion(described.model_dump(mode="json")) == described


TABLE = ["speed_kn,heading_deg,omega_rad_s,heave_m_per_m,heave_phase_deg"]
TABLE += [f"10,{heading},{omega},HEAVE,180" for heading in range(0, 360, 45) for omega in (0.1, 0.5, 1.0, 2.4)]
TABLE_SHIP = {"name": "mine", "response": {"table": "rao.csv"}, "deck_point_m": [0.0, 0.0, 0.0]}


def write_table(folder, heave: float) -> None:
    folder.mkdir(exist_ok=True)
    (folder / "rao.csv").write_text("\n".join(TABLE).replace("HEAVE", str(heave)), encoding="utf-8")


def heave_of(ship, folder) -> float:
    source = parse_motion({**SECTION, "ship": ship}, folder=folder)
    return source.realise(np.random.default_rng(0)).deck.heave_m


def test_the_files_of_a_ship_are_taken_from_the_folder_of_the_configuration(tmp_path) -> None:
    """A ship's file, a table in a mapping and a mapping's base: none of them is where the tests run."""
    write_table(tmp_path / "sub", 0.5)
    (tmp_path / "sub" / "mine.yaml").write_text(json.dumps(TABLE_SHIP), encoding="utf-8")
    ships = ("mine.yaml", TABLE_SHIP, {"base": "mine.yaml"})
    found = [heave_of(ship, tmp_path / "sub") for ship in ships]
    assert found[0] == pytest.approx(0.5 * math.sqrt(Spectrum(3.3, 9.7).variance), rel=0.02)
    assert found[1] == found[2] == found[0]
    for ship in ships:
        with pytest.raises(ConfigurationError, match=r"mine\.yaml|rao\.csv"):
            heave_of(ship, tmp_path)


def test_a_changed_file_of_a_described_ship_is_read_again(tmp_path) -> None:
    write_table(tmp_path, 0.5)
    before = heave_of(TABLE_SHIP, tmp_path)
    write_table(tmp_path, 0.25)
    os.utime(tmp_path / "rao.csv", ns=(1, 1))
    assert heave_of(TABLE_SHIP, tmp_path) == pytest.approx(0.5 * before, rel=1e-6)


def test_too_few_waves_for_a_sea_are_told_of(monkeypatch) -> None:
    monkeypatch.setattr(seaway_module, "LARGEST_MISS", 1e-9)
    with pytest.warns(ConfigurationWarning, match=r"24 waves cannot have the sea's severity"):
        sea(components=24)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sea_state": 7}, ("sea_state is 7", "2, 3, 4, 5, 6")),
        ({"sea_state": None}, ("sea_state or by hs_m",)),
        ({"hs_m": 2.0}, ("sea_state or by hs_m",)),
        ({"tp_s": 9.0}, ("tp_s is 9", "sea_state 5")),
        ({"sea_state": None, "hs_m": -1.0, "tp_s": 8.0}, ("hs_m is -1", "0 m or more")),
        ({"sea_state": None, "hs_m": 6.0}, ("hs_m is 6", "0.3 to 5 m")),
        ({"sea_state": None, "hs_m": 5.0, "tp_s": 6.0}, ("hs_m is 5", "too steep", "3.37 m")),
        ({"sea_state": None, "hs_m": math.nan, "tp_s": 6.0}, ("motion.hs_m", "nan", "finite")),
        ({"heading_deg": math.nan}, ("motion.heading_deg", "nan", "finite")),
        ({"heading_deg": "beam"}, ("motion.heading_deg", "'beam'", "number")),
        ({"speed_kn": 26.0}, ("motion.speed_kn", "26", "25")),
        ({"speed_kn": -1.0}, ("motion.speed_kn", "-1", "0")),
        ({"spectrum": "tma"}, ("motion.spectrum", "'tma'", "'jonswap'")),
        ({"gamma": 3.0}, ("gamma is 3", "jonswap")),
        ({"spectrum": "jonswap", "gamma": 9.0}, ("gamma is 9", "1 to 7")),
        ({"spreading": "cos4"}, ("motion.spreading", "'cos4'", "'cos2'")),
        ({"components": 4}, ("motion.components", "4", "24")),
        ({"gm_factor": 0.0}, ("motion.gm_factor", "0.5")),
        ({"roll_damping_factor": 0.4}, ("motion.roll_damping_factor", "0.4", "0.5")),
        ({"heading_deg": True}, ("motion.heading_deg", "True", "numbers")),
        ({"heading_deg": 1e300}, ("motion.heading_deg", "1e+300", "720")),
        ({"deck_shift_m": [1e9, 0.0, 0.0]}, ("motion.deck_shift_m", "500")),
        ({"deck_shift_m": [0.0, True, 0.0]}, ("motion.deck_shift_m", "True", "numbers")),
        ({"roll_damping_factor": -1.0}, ("motion.roll_damping_factor", "-1")),
        ({"heel_deg": 40.0}, ("motion.heel_deg", "40", "30")),
        ({"deck_shift_m": [1.0, 2.0]}, ("motion.deck_shift_m",)),
        ({"ship": "galleon"}, ("motion.ship", "'galleon'", "frigate")),
        ({"ship": 7}, ("motion.ship", "7", "name")),
        ({"heading": 90}, ("motion.heading", "not a key", "heading_deg")),
    ],
)
def test_mistakes_cost_one_sentence(changes: dict, words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        section(**changes)
    message = str(caught.value)
    assert message.startswith("motion")
    assert "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("key", ["heading_deg", "speed_kn"])
def test_heading_and_speed_are_asked_for(key: str) -> None:
    with pytest.raises(ConfigurationError, match=rf"motion\.{key} is missing"):
        parse_motion({k: v for k, v in SECTION.items() if k != key})


def test_a_seaway_wants_a_generator() -> None:
    with pytest.raises(ConfigurationError, match=r"realise\(rng\)"):
        section().realise()


def test_other_motions_have_no_limit_of_validity() -> None:
    motion: Motion = parse_motion({"type": "fixed", "roll_deg": 20.0}).realise()
    assert motion.outside_validity is None
