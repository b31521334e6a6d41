"""`ssmash ship-motion`: the record is the motion it says it is, and its figures, spectra and picture agree with it."""

from __future__ import annotations

import inspect
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssmash_gym
from ssmash_gym import ship_motion as verb
from ssmash_gym.analysis.motion_record import (
    QUANTITIES,
    long_run_spectra,
    record_spectrum,
    sample_record,
)
from ssmash_gym.cli import INTERRUPTED, main
from ssmash_gym.ship import read_shipmo
from ssmash_gym.ship.config import parse_motion
from ssmash_gym.ship.motion import pose_of
from ssmash_gym.ship.sea import KNOT, Spreading
from ssmash_gym.ship.seaway import Seaway
from ssmash_gym.ship.seaway_statistics import spectral_deck_rms
from ssmash_gym.ship.ships import load_ship
from ssmash_gym.ship.wind import read_wind, true_wind_of_height

SHORT = ["--duration", "30", "--dt", "0.1", "--components", "32"]
BEAM = {"type": "seaway", "sea_state": 5, "heading_deg": 90.0, "speed_kn": 10.0}


def run(*words: str | Path) -> int:
    return main(["ship-motion", *map(str, words)])


def head(path: Path) -> dict[str, str]:
    """The comment lines of a record: what stands before and after their first colon."""
    lines = [line[2:] for line in path.read_text().splitlines() if line.startswith("# ")]
    return dict(line.partition(": ")[::2] for line in lines)


def sea(**changes: Any) -> Seaway:
    source = parse_motion({**BEAM, **changes})
    assert isinstance(source, Seaway)
    return source


# --- the record -----------------------------------------------------------------------------------------------------


def test_the_record_is_the_motion_that_its_head_describes(tmp_path: Path) -> None:
    out = tmp_path / "motion.csv"
    assert run(*SHORT, "--sea-state", 4, "--heading", 135, "--speed-kn", 18, "--seed", 7, "--out", out) == 0
    about = head(out)
    assert about["seed"] == "7"
    assert f"ssmash_gym {ssmash_gym.__version__}, ssmash ship-motion" in about
    section = json.loads(about["motion"])
    assert (section["sea_state"], section["heading_deg"], section["speed_kn"]) == (4, 135.0, 18.0)
    motion = parse_motion(section).realise(np.random.default_rng(7))
    record = read_shipmo(out)
    time = record.step_s * np.arange(len(record.angles))
    assert (len(time), record.step_s) == (301, pytest.approx(0.1))
    signal = motion.signal(time)
    pose = pose_of(signal)
    np.testing.assert_allclose(record.angles, signal.position[:, 3:], atol=1e-10)
    np.testing.assert_allclose(record.velocity, pose.v_NS_N, atol=1e-9)
    np.testing.assert_allclose(record.rates, pose.w_NS_S, atol=1e-10)
    np.testing.assert_allclose(record.acceleration, pose.a_NS_N, atol=1e-9)


def test_same_seed_same_file_and_the_sea_does_not_depend_on_what_else_is_written(tmp_path: Path) -> None:
    first, again, more, other = (tmp_path / f"{name}.csv" for name in ("first", "again", "more", "other"))
    assert run(*SHORT, "--seed", 1, "--out", first) == 0
    assert run(*SHORT, "--seed", 1, "--out", again) == 0
    assert run(*SHORT, "--seed", 1, "--out", more, "--wind", "--spectra", tmp_path / "spectra.csv") == 0
    assert run(*SHORT, "--seed", 2, "--out", other) == 0
    assert first.read_bytes() == again.read_bytes()
    rows = [[x for x in path.read_text().splitlines() if x[0] != "#"] for path in (first, more, other)]
    assert rows[0] == rows[1]
    assert rows[0] != rows[2]


def test_a_record_for_the_thesis_program_has_no_head(tmp_path: Path) -> None:
    out = tmp_path / "SHIPMO.INP"
    assert run(*SHORT, "--out", out) == 0
    assert np.loadtxt(out, comments=None).shape == (301, 16)


def test_long_records_are_drawn_with_more_waves() -> None:
    given = {"heading_deg": 0.0, "speed_kn": 5.0}
    assert verb.chosen_source(given, None, None).components == 96
    assert verb.chosen_source(given, None, 600.0).components == 96
    assert verb.chosen_source(given, None, 1800.0).components == 256
    assert verb.chosen_source({**given, "components": 64}, None, 1800.0).components == 64


def test_the_companion_wind_is_that_of_the_sea_less_the_ship(tmp_path: Path) -> None:
    out = tmp_path / "motion.csv"
    words = [*SHORT, "--hs-m", "2.5", "--heading", "180", "--speed-kn", "12", "--out", out, "--wind"]
    assert run(*words, "--gusts", 0) == 0
    wind = read_wind(tmp_path / "motion.wind.csv")
    # Head seas: the wind comes from ahead and blows aft, and the ship steams into it.
    np.testing.assert_allclose(wind.wind[:, 0], -true_wind_of_height(2.5) - 12.0 * KNOT, rtol=1e-9)
    np.testing.assert_allclose(wind.wind[:, 1:], 0.0, atol=1e-9)
    assert head(out)["wind"].startswith(f"true wind {true_wind_of_height(2.5):.1f} m/s from 0 deg")
    assert run(*words, "--gusts", 0.2) == 0
    gusts = read_wind(tmp_path / "motion.wind.csv").wind[:, 0] - wind.wind[:, 0]
    assert 0.05 < np.std(gusts) / true_wind_of_height(2.5) < 0.4


# --- figures --------------------------------------------------------------------------------------------------------


def test_statistics_are_those_of_the_columns(tmp_path: Path) -> None:
    source = sea(heel_deg=3.0, components=48)
    motion = source.realise(np.random.default_rng(3))
    record = sample_record(motion, 60.0, 0.1)
    found = record.statistics()
    signal = motion.signal(record.time_s)
    roll = np.degrees(signal.position[:, 3]) - np.mean(np.degrees(signal.position[:, 3]))
    assert found["roll_deg"].rms == pytest.approx(np.sqrt(np.mean(roll**2)))
    assert found["roll_deg"].significant == pytest.approx(2.0 * found["roll_deg"].rms)
    assert found["roll_deg"].largest == pytest.approx(np.max(np.abs(roll)))
    assert found["vertical_velocity_m_s"].rms == pytest.approx(np.std(signal.rate[:, 2]))
    assert found["vertical_acceleration_g"].rms == pytest.approx(np.std(signal.acceleration[:, 2]) / 9.81)
    specific = pose_of(signal).specific_force_S(9.81)[:, 1] / 9.81
    assert found["lateral_specific_force_g"].largest == pytest.approx(np.max(np.abs(specific - specific.mean())))
    np.testing.assert_allclose(record.elevation_m, motion.elevation(record.time_s))


def test_blocks_leave_no_seam_and_progress_rises_to_one() -> None:
    motion = sea(components=32).realise(np.random.default_rng(0))
    told: list[float] = []
    record = sample_record(motion, 500.0, 0.1, told.append)  # more instants than one block
    assert told == sorted(told) and told[-1] == 1.0 and len(told) > 1
    whole = motion.signal(record.time_s)
    np.testing.assert_allclose(record.series["roll_deg"], np.degrees(whole.position[:, 3]), atol=1e-9)
    np.testing.assert_allclose(record.series["vertical_acceleration_g"], whole.acceleration[:, 2] / 9.81, atol=1e-9)


def test_the_table_shows_the_long_run_and_both_conventions_of_heading(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*SHORT, "--heading", 45, "--seed", 5, "--out", tmp_path / "motion.csv") == 0
    shown = capsys.readouterr().out
    deck = sea(heading_deg=45.0, components=32).realise(np.random.default_rng(5)).deck
    row = next(line for line in shown.splitlines() if "lateral specific force" in line)
    assert f"{deck.lateral_specific_force_g:.3f}" in row
    flat = " ".join(shown.split())
    assert "waves travel to 45°" in flat
    assert "come from 225°" in flat
    assert "natural periods" in flat and "roll damping" in flat and "Hs 3.3 m, Tp 9.7 s" in flat
    assert "outside validity" not in flat


def test_large_rolling_is_flagged_in_words_and_in_the_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "motion.csv"
    assert run(*SHORT, "--hs-m", 7, "--tp-s", 11.5, "--speed-kn", 0, "--out", out) == 0
    assert "outside validity: roll RMS is" in capsys.readouterr().out
    assert head(out)["outside validity"].startswith("roll RMS is")


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
    assert np.sum(density) * (omega[1] - omega[0]) == pytest.approx(2.0, rel=0.02)


def test_spectra_file_names_its_units_and_reads_back(tmp_path: Path) -> None:
    spectra = tmp_path / "spectra.csv"
    assert run(*SHORT, "--out", tmp_path / "motion.csv", "--spectra", spectra) == 0
    lines = [line for line in spectra.read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    assert names[:3] == ["omega_radps", "wave_encounter_m2s", "wave_m2s"]
    table = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    wave = table[:, names.index("wave_m2s")]
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


# --- a recorded motion ----------------------------------------------------------------------------------------------


def test_the_check_of_a_record_is_printed_and_the_record_rewritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*SHORT, "--rates", "euler", "--out", tmp_path / "theirs.csv") == 0
    (tmp_path / "file.yaml").write_text("type: file\npath: theirs.csv\ndetrend: false\n")
    capsys.readouterr()
    assert run("--config", tmp_path / "file.yaml", "--dt", 0.1, "--out", tmp_path / "ours.csv") == 0
    shown = capsys.readouterr()
    assert "yaw rate: RMS difference" in shown.out
    assert "rates: euler" in shown.out
    assert not shown.err
    theirs, ours = read_shipmo(tmp_path / "theirs.csv"), read_shipmo(tmp_path / "ours.csv")
    np.testing.assert_allclose(ours.angles, theirs.angles, atol=1e-9)
    assert np.max(np.abs(ours.rates[5:-5] - theirs.rates[5:-5])) > 1e-3  # body, no longer rates of the angles


# --- the page -------------------------------------------------------------------------------------------------------

GUIDE = Path(ssmash_gym.__file__).parents[1] / "docs" / "guide" / "ship_motion.md"


def test_the_guide_names_every_key_and_option() -> None:
    page = GUIDE.read_text(encoding="utf-8")
    keys, options = (page.split(title)[1].split("\n## ")[0] for title in ("## A ship in a seaway", "## `ssmash ship-m"))
    assert not [key for key in Seaway.model_fields if key != "type" and f"`{key}`" not in keys]
    assert not [name for name in inspect.signature(verb.ship_motion).parameters if _option(name) not in options]


def _option(name: str) -> str:
    return f"`--{name.replace('_', '-')}`"


# --- mistakes -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--ship", "no_such"], "no_such"),
        (["--sea-state", "7"], "no readable source"),
        (["--sea-state", "5", "--hs-m", "3"], "one of the two"),
        (["--hs-m", "-1", "--tp-s", "8"], "hs_m is -1"),
        (["--hs-m", "5", "--tp-s", "4"], "too steep"),
        (["--tp-s", "9"], "--hs-m"),
        (["--heading", "nan"], "heading_deg is nan"),
        (["--speed-kn", "-3"], "speed_kn is -3"),
        (["--duration", "0"], "--duration 0"),
        (["--duration", "nan"], "--duration nan"),
        (["--duration", "1e9"], "allowed are 8 to"),
        (["--dt", "-1"], "--dt -1"),
        (["--seed", "-1"], "--seed -1"),
        (["--wind", "--gusts", "2"], "--gusts 2"),
        (["--config", "nowhere.yaml"], "nowhere.yaml"),
        (["--plot", "motion.jpg"], "motion.jpg"),
        (["--spectra", "motion.csv"], "same file"),
        (["--plot", "nowhere/motion.png"], "no folder nowhere"),
    ],
)
def test_a_mistake_costs_one_sentence_and_nothing_is_written(
    words: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*words) == 1
    message = capsys.readouterr().err
    assert told in message
    assert message.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [["--heading", "30"], ["--sea-state", "4"], ["--wind"], ["--spectra", "s.csv"]])
def test_a_file_describes_the_motion_alone(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("still.yaml").write_text("motion: {type: fixed}\n")
    assert run("--config", "still.yaml", *words) == 1
    assert words[0] in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["still.yaml"]


def test_a_missing_library_is_named_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    assert run(*SHORT, "--out", tmp_path / "motion.csv", "--plot", tmp_path / "motion.png") == 1
    assert "ssmash_gym[plot]" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_run_that_is_stopped_leaves_everything_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "motion.csv"
    out.write_text("what was there\n")

    def stopped(path: Path, *_: Any) -> None:
        assert (path.parent / "motion.csv").stat().st_size > 1000, "the record was written, but not yet in its place"
        raise KeyboardInterrupt

    monkeypatch.setattr(verb, "write_wind", stopped)
    assert run(*SHORT, "--out", out, "--wind") == INTERRUPTED
    assert "stopped" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["motion.csv"]
    assert out.read_text() == "what was there\n"
