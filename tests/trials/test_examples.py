"""The trials that ship: scripted, named so everywhere, and the same bit for bit with the present sources."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import yaml

from ssmash_gym.assets import asset_path
from ssmash_gym.trials import Trial, read_trials
from ssmash_gym.trials.protocol import load_protocol
from ssmash_gym.trials.replay import replay
from ssmash_gym.trials.session import Session

FOLDER = asset_path("configs", "trials", "examples", "scripted_operator")
AGAIN = "run `python tools/example_trials.py` to drive them anew"
TRIALS = read_trials(FOLDER)


@pytest.mark.parametrize(("path", "trial"), TRIALS, ids=[path.stem for path, _ in TRIALS])
def test_they_come_out_as_recorded(path: Path, trial: Trial) -> None:
    outcome = replay(trial)
    if "another processor" in outcome.code:  # the last bits are not promised from machine to machine
        assert outcome.metrics is not None and trial.metrics is not None
        assert outcome.metrics["reason"] == trial.metrics["reason"], f"{path.name}: {AGAIN}"
        return
    assert outcome.agrees, f"{path.name} {outcome.words}: if that is meant, {AGAIN}"


def test_they_are_a_session_of_the_standard_protocol(tmp_path: Path) -> None:
    protocol = load_protocol()
    found = yaml.safe_load((FOLDER / "participant.yaml").read_text())
    assert found["protocol"] == protocol.identity, AGAIN
    shutil.copytree(FOLDER, tmp_path / "scripted_operator")
    with Session.open(protocol, "scripted_operator", tmp_path) as session:
        assert session.next() is None
    scored = [trial.seed for _, trial in TRIALS if trial.scored]
    assert scored == protocol.order("scripted_operator")


def test_nobody_could_take_them_for_a_person() -> None:
    assert FOLDER.name == "scripted_operator"
    assert "No person took part" in " ".join((FOLDER / "README.md").read_text().split())
    for _, trial in TRIALS:
        assert trial.driver == "scripted operator" and set(trial.table["driver"]) == {"scripted operator"}
        assert trial.about["origin"] == "script" and trial.about["participant"] == "scripted_operator"
        assert trial.about["experience"] == "script" and trial.about["started_utc"] == ""


def test_they_are_small_and_hold_no_other_file() -> None:
    files = list(FOLDER.iterdir())
    assert sum(path.stat().st_size for path in files) < 1.5e6
    assert {path.name for path in files} == {path.name for path, _ in TRIALS} | {"participant.yaml", "README.md"}
