"""The command line: a simulation is recorded, a mistake costs one sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.cli import INTERRUPTED, MISREAD, main
from ssmash_gym.ship import parse_motion, write_shipmo
from ssmash_gym.simulation.recording import read_recording


def test_simulate_records_the_traverse_with_units_and_configuration(tmp_path: Path) -> None:
    motion = tmp_path / "roll.yaml"
    motion.write_text("motion: {type: sinusoid, dof: roll, amplitude_deg: 3.0, period_s: 8.0}\n")
    out = tmp_path / "run.parquet"
    words = ["--motion", str(motion), "--out", str(out), "--duration-s", "6", "--lead-in-s", "2", "--along", "0.5"]
    assert main(["simulate", *words]) == 0
    table, about = read_recording(out)
    assert about["configuration"]["motion"]["amplitude_deg"] == 3.0
    assert about["configuration"]["helicopter"]["name"] == "generic_tricycle"
    assert about["units"]["probe_in_plane"]["unit"] == "N"
    time = table["time_s"].to_numpy()
    np.testing.assert_allclose(np.diff(time), 0.1, atol=1e-9)
    claw = table["claw_x"].to_numpy()
    assert np.all(claw[time <= 2.0] == claw[0])
    np.testing.assert_allclose(
        claw[-1] - claw[0], 0.15 * (4.0 - 0.1 - 0.25), atol=0.01
    )  # delay, then 0.3 m/s2 to 0.15 m/s


def test_simulate_in_a_seaway_records_the_whole_section_and_flags_large_rolling(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    motion, out = tmp_path / "sea.yaml", tmp_path / "run.parquet"
    motion.write_text("type: seaway\nhs_m: 7.0\ntp_s: 11.5\nheading_deg: 90.0\nspeed_kn: 0.0\ncomponents: 48\n")
    words = ["--motion", str(motion), "--out", str(out), "--duration-s", "2", "--lead-in-s", "1", "--seed", "3"]
    assert main(["simulate", *words]) == 0
    shown = capsys.readouterr().out
    assert "outside validity: roll RMS" in shown
    assert "ship: frigate, at 0 kn" in shown and "Hs 7 m, Tp 11.5 s" in shown and "wind: none acts" in shown
    configuration = read_recording(out)[1]["configuration"]
    assert configuration["motion"]["ship"] == "frigate"
    assert configuration["outside_validity"].startswith("roll RMS")
    table, _ = read_recording(out)
    deck = parse_motion(configuration["motion"]).realise(np.random.default_rng(configuration["seed"]))
    roll = deck.signal([2.0]).position[0, 3]  # after the lead-in the deck moves as the section says
    assert table["deck_roll"].to_numpy()[-1] == pytest.approx(roll, abs=1e-6)


def test_simulate_prints_the_check_of_a_record(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sea = parse_motion({"type": "irregular", "roll": {"rms_deg": 4.0, "period_s": 9.0}})
    write_shipmo(tmp_path / "deck.csv", sea.realise(np.random.default_rng(1)), 0.05, 10.0)
    (tmp_path / "deck.yaml").write_text("motion: {type: file, path: deck.csv}\n")
    out = tmp_path / "run.parquet"
    words = ["--motion", str(tmp_path / "deck.yaml"), "--out", str(out), "--duration-s", "2", "--lead-in-s", "1"]
    assert main(["simulate", *words]) == 0
    shown = capsys.readouterr()
    assert "roll rate: RMS difference" in shown.out
    assert not shown.err
    out.unlink()
    assert main(["simulate", *words, "--duration", "10.2"]) == 1
    assert "--duration-s 10.2 is refused: the motion lasts 10 s, allowed is 10 s" in capsys.readouterr().err
    assert not out.exists()
    assert main(["simulate", *words, "--duration", "10"]) == 0  # the record to its end
    assert read_recording(out)[0]["time_s"].to_numpy()[-1] == pytest.approx(10.0)


def test_a_run_that_is_stopped_says_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def stopped() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ssmash_gym.info.info", stopped)
    assert main(["info"]) == INTERRUPTED
    assert capsys.readouterr().err == "ssmash info: stopped.\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--helicopter", "no_such"], "no_such"),
        (["--along", "2"], "--along 2 is refused: it must be a claw command within -1 to 1"),
        (["--yaw-deg", "nan"], "--yaw-deg nan"),
        (["--lead-in-s", "70"], "--lead-in-s 70 is refused: it must be 0 s or more and below --duration-s, 60 s"),
        (["--duration-s", "-3"], "--duration-s -3 is refused: it must be above 0 s"),
        (["--duration", "inf"], "--duration-s inf"),
        (["--seed", "-1"], "--seed -1"),
        (["--motion", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_a_mistake_costs_one_sentence_and_nothing_is_written(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run.parquet"
    assert main(["simulate", *words, "--out", str(out)]) == 1
    message = capsys.readouterr().err
    assert told in message
    assert message.count("\n") == 1
    assert not out.exists()


def test_what_the_system_refuses_names_the_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    words = ["evaluate", "--study", "smoke", "--against", "hold", "--out", str(tmp_path / "file" / "out")]
    assert main(words) == 1
    assert "file/out" in (told := capsys.readouterr().err) and "cannot be read or written (" in told


def test_a_folder_that_is_not_there_is_not_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--out", str(tmp_path / "no" / "run.parquet")]) == 1
    assert "there is no folder" in capsys.readouterr().err
    assert main(["simulate", "--out", str(tmp_path)]) == 1
    assert "this is a folder" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--heading", "east"], "--heading: could not convert string to float: 'east'"),
        (["--hs-m", "tall"], "['tall']"),
        (
            ["--spectrum", "pierson"],
            "'pierson' for argument '--spectrum'. Expected one of ('bretschneider', 'jonswap')",
        ),
        (["--seed", "1.5"], "'1.5'"),
        (["--headings", "3"], "--headings"),
        (["--heading"], "--heading"),
    ],
)
def test_words_that_cannot_be_read_cost_one_line(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["ship-motion", *words]) == MISREAD
    shown = capsys.readouterr()
    assert shown.err.startswith("ssmash ship-motion: ") and shown.err.count("\n") == 1 and not shown.out
    assert told in shown.err and "│" not in shown.err


def test_the_help_of_a_verb_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as leaving:
        main(["simulate", "--help"])
    assert not leaving.value.code
    shown = capsys.readouterr().out
    assert "usage: ssmash simulate" in shown and "--lead-in-s" in shown and "Run one helicopter" in shown


def test_info_lists_versions_cache_and_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    shown = capsys.readouterr().out
    for word in ("numba", "extra train", "kernel cache", "generic_tricycle", "frigate"):
        assert word in shown
