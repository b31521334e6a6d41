"""`ssmash ship-motion`: the record is the motion it says it is, and its figures, spectra and picture agree with it."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ssmash_gym
from ssmash_gym import ship_motion as verb
from ssmash_gym.analysis.motion_record import (
    sample_record,
)
from ssmash_gym.analysis.motion_report import long_wave_ratios, subtitle, title
from ssmash_gym.cli import INTERRUPTED
from ssmash_gym.ship import read_shipmo
from ssmash_gym.ship.config import parse_motion
from ssmash_gym.ship.motion import pose_of
from ssmash_gym.ship.response_table import write_response_table
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.seaway import Seaway
from ssmash_gym.ship.ships import load_ship
from ssmash_gym.ship.wind import read_wind, true_wind_of_height
from tests.ship_motion_rig import SHORT, head, run, sea

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
    about = head(tmp_path / "motion.wind.csv")
    assert about["seed"] == "0" and f"ssmash_gym {ssmash_gym.__version__}, ssmash ship-motion" in about
    assert "wind_x below 0 comes from ahead" in about["axes"] and "rates" not in about
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
    assert found["roll_deg"].mean == pytest.approx(np.mean(np.degrees(signal.position[:, 3])))
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


def test_a_mean_attitude_stands_in_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "fixed.yaml").write_text("motion: {type: fixed, roll_deg: 5.0}\n")
    assert run("--config", tmp_path / "fixed.yaml", "--duration", 20, "--out", tmp_path / "motion.csv") == 0
    shown = capsys.readouterr().out.splitlines()
    for label, mean in (("roll [deg]", "5.000"), ("lateral specific force [g]", "-0.087")):
        row = next(line for line in shown if label in line)
        assert row.split("]")[1].split()[:2] == [mean, "0.000"]


def test_a_changed_ship_is_told_from_its_base(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ship = "{base: frigate, kg_m: 6.2, deck_point_m: [-40.0, -2.0, 1.5]}"
    config, out = tmp_path / "sea.yaml", tmp_path / "motion.csv"
    config.write_text(f"type: seaway\nship: {ship}\nsea_state: 4\nheading_deg: 30\nspeed_kn: 5\ncomponents: 24\n")
    assert run("--config", config, "--duration", 20, "--out", out) == 0
    flat = " ".join(capsys.readouterr().out.split())
    assert "frigate, changed: kg_m, deck_point_m" in flat
    assert "40 m aft, 2 m to port, 1.5 m below the centre of gravity" in flat
    assert head(out)["ship"] == "frigate, changed: kg_m, deck_point_m"
    source = verb.chosen_source({}, config, None)
    assert title(source) == "Deck motion: frigate, changed: kg_m, deck_point_m, 5 kn, sea state 4"


def test_a_long_record_of_few_waves_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config, out = tmp_path / "sea.yaml", tmp_path / "motion.csv"
    config.write_text("type: seaway\nsea_state: 5\nheading_deg: 90\nspeed_kn: 10\n")
    assert run("--config", config, "--duration", 700, "--dt", 0.5, "--out", out) == 0
    assert "warning: components is 96: a record of 700 s" in capsys.readouterr().out
    assert head(out)["warning"].startswith("components is 96")
    assert run("--duration", 700, "--dt", 0.5, "--out", out) == 0
    assert "warning" not in capsys.readouterr().out


# --- a ship given by a table ----------------------------------------------------------------------------------------


def table_ship(folder: Path, **conventions: str) -> Path:
    """A ship that is a table of the frigate's response, read by conventions of which some may be wrong."""
    write_response_table(
        folder / "table.csv", load_ship("frigate"), [0.0, 10.0], range(0, 360, 30), np.linspace(0.3, 1.3, 21)
    )
    response = ", ".join(f"{key}: {value}" for key, value in {"table": "table.csv", **conventions}.items())
    (folder / "mine.yaml").write_text(f"name: mine\nresponse: {{{response}}}\ndeck_point_m: [-40.0, 0.0, -6.0]\n")
    return folder / "mine.yaml"


def test_a_sea_outside_a_table_is_warned_of_wherever_it_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ship, out, spectra = table_ship(tmp_path), tmp_path / "motion.csv", tmp_path / "spectra.csv"
    words = [*SHORT, "--ship", ship, "--hs-m", 0.5, "--tp-s", 5.0, "--out", out, "--spectra", spectra]
    assert run(*words) == 0
    shown = capsys.readouterr()
    assert shown.out.count("more than 10% of the sea's energy") == 1 and not shown.err
    for path in (out, spectra):
        assert "0.3 to 1.3 rad/s" in head(path)["warning"]
    source = verb.chosen_source(
        {"ship": str(ship), "hs_m": 0.5, "tp_s": 5.0, "heading_deg": 90.0, "speed_kn": 5.0}, None, 30.0
    )
    motion, remarks = verb.realised(source, 0)
    assert [line for line in subtitle(source, motion, remarks) if line.startswith("warning: response table")]
    assert run(*SHORT, "--ship", ship, "--tp-s", 10, "--hs-m", 2, "--out", out) == 0
    assert "warning" not in capsys.readouterr().out


def test_long_waves_tell_a_table_that_was_read_wrongly(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ship = load_ship(table_ship(tmp_path))
    heave, roll, pitch = long_wave_ratios(ship.response, 5.0)
    np.testing.assert_allclose([heave, pitch], 1.0, atol=0.05)
    assert abs(roll - 1.0) < 0.6  # its resonance is not far above
    assert run(*SHORT, "--ship", tmp_path / "mine.yaml", "--out", tmp_path / "motion.csv") == 0
    flat = " ".join(capsys.readouterr().out.split())
    ratios = long_wave_ratios(ship.response, 10.0)
    for name, ratio in zip(("long waves heave", "roll/slope", "pitch/slope"), ratios, strict=True):
        assert f"{name} {ratio:.2f}" in flat
    assert "wrong" not in flat
    for wrong in ({"convention": "z_up_port"}, {"heading": "towards_port"}, {"heading": "from_starboard"}):
        assert run(*SHORT, "--ship", table_ship(tmp_path, **wrong), "--out", tmp_path / "motion.csv") == 0
        assert "a wrong sign, phase or heading?" in " ".join(capsys.readouterr().out.split()), wrong


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


def test_a_record_keeps_its_step_and_its_bad_columns_are_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    theirs, ours = tmp_path / "theirs.csv", tmp_path / "ours.csv"
    assert run(*SHORT, "--rates", "euler", "--out", theirs) == 0
    table = np.loadtxt(theirs, delimiter=",", skiprows=len(head(theirs)) + 1)
    table[:, 12] *= -1.0
    np.savetxt(theirs, table, delimiter=",")
    (tmp_path / "file.yaml").write_text("type: file\npath: theirs.csv\n")
    capsys.readouterr()
    assert run("--config", tmp_path / "file.yaml", "--out", ours) == 0
    shown = capsys.readouterr().out.splitlines()
    (turned,) = (line for line in shown if "acceleration z:" in line)
    assert turned.endswith("<- sign?")
    (yaw,) = (line for line in shown if "yaw rate:" in line)
    assert yaw.endswith("<- more than 2%")  # rates of the angles, read as body rates
    (fine,) = (line for line in shown if "acceleration y:" in line)
    assert "<-" not in fine
    assert read_shipmo(ours).step_s == pytest.approx(0.1)
    assert run("--config", tmp_path / "file.yaml", "--out", ours, "--dt", 0.2) == 0
    assert read_shipmo(ours).step_s == pytest.approx(0.2)


@pytest.mark.parametrize("option", ["--out", "--spectra"])
def test_what_a_motion_is_read_from_is_not_written_over(
    option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*SHORT) == 0
    table_ship(tmp_path)
    Path("record").write_text("type: file\npath: motion.csv\n")
    Path("linked.csv").symlink_to("motion.csv")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    capsys.readouterr()
    for words in (
        ("--config", "record", option, "motion.csv"),
        ("--config", "record", option, "linked.csv"),
        ("--config", "record", option, "record"),
        ("--ship", "mine.yaml", option, "table.csv"),
        ("--ship", "mine.yaml", option, "mine.yaml"),
    ):
        elsewhere = () if option == "--out" else ("--out", "elsewhere.csv")
        assert run(*words, *elsewhere, "--duration", 20) == 1
        assert f"{option} {words[-1]} is refused: the motion is read from this file." in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


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
        (["--sea-state", "7"], "stop at 6"),
        (["--sea-state", "5", "--hs-m", "3"], "one of the two"),
        (["--hs-m", "-1", "--tp-s", "8"], "hs_m is -1"),
        (["--hs-m", "5", "--tp-s", "6"], "too steep"),
        (["--tp-s", "9"], "--hs-m"),
        (["--heading", "nan"], "heading_deg is nan"),
        (["--speed-kn", "-3"], "speed_kn is -3"),
        (["--duration", "0"], "--duration 0"),
        (["--duration", "nan"], "--duration nan"),
        (["--duration", "1e9"], "allowed are 8 to"),
        (["--dt", "-1"], "--dt -1"),
        (["--dt", "5"], "--dt 5 is refused: allowed is at most"),
        (["--gusts", "0.2"], "--gusts 0.2 is refused: it goes with --wind"),
        (["--out", "ship.yaml"], "YAML"),
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

    def stopped(path: Path, *_: Any, **__: Any) -> None:
        assert (path.parent / "motion.csv").stat().st_size > 1000, "the record was written, but not yet in its place"
        raise KeyboardInterrupt

    monkeypatch.setattr(verb, "write_wind", stopped)
    assert run(*SHORT, "--out", out, "--wind") == INTERRUPTED
    assert "stopped" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["motion.csv"]
    assert out.read_text() == "what was there\n"
