"""Spectra and pictures of `ssmash ship-motion`: areas are variances, and files say what they hold."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import ssmash_gym
from ssmash_gym.analysis.motion_picture import draw_picture, has_line, has_window
from ssmash_gym.analysis.motion_record import (
    QUANTITIES,
    long_run_spectra,
    record_spectrum,
    sample_record,
)
from ssmash_gym.analysis.motion_report import caption
from ssmash_gym.ship.sea import KNOT, Spreading
from ssmash_gym.ship.seaway_statistics import spectral_deck_rms
from ssmash_gym.ship.ships import load_ship
from tests.ship_motion_rig import SHORT, head, run, sea

# --- spectra --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("heading_deg", [20.0, 90.0, 180.0])
def test_long_run_spectra_hold_the_variance_of_the_spectral_integral(heading_deg: float) -> None:
    source = sea(heading_deg=heading_deg, speed_kn=15.0)
    motion = source.realise(np.random.default_rng(0))
    omega = np.linspace(0.0, 8.0, 2001)  # short waves of a head sea are met at 7 rad/s
    spectra = long_run_spectra(source, motion, omega)
    ship, spreading = load_ship(source.ship), Spreading(source.spreading)
    expected = spectral_deck_rms(ship, source.sea(), spreading, math.radians(heading_deg), 15.0 * KNOT)
    for quantity in QUANTITIES:
        rms = math.sqrt(np.sum(spectra.deck[quantity.key]) * (omega[1] - omega[0]))
        assert rms == pytest.approx(getattr(expected, quantity.key), rel=0.01), quantity.key
    # Steaming shifts the waves' energy over frequency and leaves it what it is.
    for density in (spectra.wave, spectra.wave_at_rest):
        assert np.sum(density) * (omega[1] - omega[0]) == pytest.approx(3.3**2 / 16.0, rel=0.02)


@pytest.mark.parametrize("speed_kn", [0.0, 10.0])
def test_long_run_spectra_are_smooth(speed_kn: float) -> None:
    source = sea(speed_kn=speed_kn)
    spectra = long_run_spectra(source, source.realise(np.random.default_rng(0)), np.linspace(0.0, 2.0, 501))
    turns = np.diff(spectra.deck["roll_deg"])
    largest = np.max(spectra.deck["roll_deg"])
    counted = turns[np.abs(turns) > 1e-4 * largest]
    assert np.sum(np.diff(np.sign(counted)) != 0) == 1  # one peak, no steps
    if speed_kn == 0.0:
        np.testing.assert_allclose(spectra.wave, spectra.wave_at_rest, atol=0.02 * np.max(spectra.wave))


def test_in_a_head_sea_the_spectrum_of_the_waves_moves_to_higher_frequencies() -> None:
    source = sea(heading_deg=180.0, speed_kn=15.0, spreading="long_crested")
    omega = np.linspace(0.0, 3.0, 751)
    spectra = long_run_spectra(source, source.realise(np.random.default_rng(0)), omega)
    peak = 2.0 * math.pi / 9.7
    assert omega[np.argmax(spectra.wave_at_rest)] == pytest.approx(peak, abs=0.01)
    met = omega[np.argmax(spectra.wave)]
    assert met == pytest.approx(peak + peak**2 / 9.81 * 15.0 * KNOT, abs=0.04)  # the density flattens as it spreads


def test_spectrum_of_a_record_finds_frequency_and_variance_of_a_sine() -> None:
    time = 0.1 * np.arange(6001)
    omega, density = record_spectrum(2.0 * np.sin(0.7 * time) + 5.0, 0.1)
    assert omega[np.argmax(density)] == pytest.approx(0.7, abs=0.03)
    slow = 3.0 * np.sin(2.0 * np.pi * time / 300.0) + np.sin(0.7 * time)  # slower than the pieces are long
    omega, density = record_spectrum(slow, 0.1)
    assert np.sum(density) * (omega[1] - omega[0]) == pytest.approx(np.var(slow), rel=1e-9)
    assert not record_spectrum(np.ones(600), 0.1)[1].any()
    omega, density = record_spectrum(2.0 * np.sin(0.7 * time) + 5.0, 0.1)
    assert np.sum(density) * (omega[1] - omega[0]) == pytest.approx(2.0, rel=0.02)


def test_spectra_file_names_its_units_and_reads_back(tmp_path: Path) -> None:
    spectra = tmp_path / "spectra.csv"
    assert run(*SHORT, "--out", tmp_path / "motion.csv", "--spectra", spectra) == 0
    lines = [line for line in spectra.read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    assert names[0] == "omega_radps" and "vertical_velocity_mps_squared_s" in names
    assert set(names) <= set(head(spectra)) and "rates" not in head(spectra)
    assert "over encounter frequency" in head(spectra)["elevation_over_encounter_m_squared_s"]
    table = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    wave = table[:, names.index("elevation_over_wave_m_squared_s")]
    np.testing.assert_allclose(wave, sea().sea().density(table[:, 0]), rtol=1e-6, atol=1e-12)
    assert json.loads(head(spectra)["motion"])["sea_state"] == 5


# --- the picture ----------------------------------------------------------------------------------------------------


def test_the_picture_carries_version_configuration_and_seed(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    picture = tmp_path / "motion.png"
    assert run(*SHORT, "--seed", 4, "--out", tmp_path / "motion.csv", "--plot", picture) == 0
    with image.open(picture) as found:
        about, size, colours = found.text, found.size, len(found.convert("RGB").getcolors(1 << 16))
    assert ssmash_gym.__version__ in about["Software"]
    assert "seed: 4" in about["Description"]
    assert '"heading_deg": 90.0' in about["Description"]
    assert size[0] > 1000 and colours > 20


def test_a_motion_without_a_sea_has_a_picture_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    config = tmp_path / "roll.yaml"
    config.write_text("motion: {type: sinusoid, dof: roll, amplitude_deg: 4.0, period_s: 8.0}\n")
    words = ["--config", config, "--duration", 40, "--out", tmp_path / "motion.csv", "--plot", tmp_path / "roll.png"]
    assert run(*words) == 0
    shown = capsys.readouterr().out
    row = next(line for line in shown.splitlines() if "roll [deg]" in line)
    assert "2.827" in row and "4.000" in row
    assert (tmp_path / "roll.png").stat().st_size > 10_000


def test_a_short_record_is_drawn_once_and_without_a_spectrum_of_its_own(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    source = sea(components=24)
    motion = source.realise(np.random.default_rng(0))
    spectra = long_run_spectra(source, motion, np.linspace(0.0, 2.0, 101))
    short, long = (sample_record(motion, length, 0.5) for length in (100.0, 400.0))
    assert (has_window(short), has_line(short, spectra), has_line(short, None)) == (False, False, True)
    assert has_window(long) and has_line(long, spectra)
    sizes = []
    for record in (short, long):
        words = ("title", ["under"], caption(record, spectra, 0))
        draw_picture(tmp_path / "motion.png", record, spectra, {}, words, {})
        sizes.append((tmp_path / "motion.png").stat().st_size)
    assert min(sizes) > 10_000
    assert "no spectrum below 300 s" in caption(short, spectra, 0)
    assert "scaled to its variance" in caption(long, spectra, 0)


GUIDE = Path(ssmash_gym.__file__).parents[1] / "docs" / "guide" / "ship_motion.md"


def test_the_picture_in_the_guide_is_of_the_command_beside_it() -> None:
    image = pytest.importorskip("PIL.Image")
    page = GUIDE.read_text(encoding="utf-8")
    command = page.split("ssmash ship-motion --ship")[1].split("```")[0].replace("\\", "").split()
    given = dict(zip(command[1::2], command[2::2], strict=True))
    path = GUIDE.parent / "../images/ship_motion.png"
    assert path.stat().st_size < 200_000
    with image.open(path) as found:
        about = dict(line.partition(": ")[::2] for line in found.text["Description"].splitlines())
    section = json.loads(about["motion"])
    assert about["seed"] == given["--seed"] and about["ship"] == command[0]
    for option, key in (("--sea-state", "sea_state"), ("--heading", "heading_deg"), ("--speed-kn", "speed_kn")):
        assert float(given[option]) == section[key]
