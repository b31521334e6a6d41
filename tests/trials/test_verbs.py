"""`ssmash replay`: a line a file, status 1 for what does not come out, one sentence for a mistake."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.cli import main
from ssmash_gym.trials import Trial, write_trial
from tests.trials.rig import condition, recorded


@pytest.fixture(scope="module")
def trial() -> Trial:
    return recorded(condition("calm", {"horizon_s": 1.0}), 4, [[0.5, 0.1]] * 10)


def replayed(*words: str | Path) -> int:
    return main(["replay", *map(str, words)])


def test_files_and_folders(trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_trial(tmp_path / "a" / "one.parquet", trial)
    write_trial(tmp_path / "a" / "deeper" / "two.parquet", replace(trial, table=trial.table.head(3), about={
        **trial.about, "complete": False, "metrics": None}))  # fmt: skip
    assert replayed(tmp_path / "a", tmp_path / "a" / "one.parquet") == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 and all("agrees bit for bit" in line for line in lines)
    assert "two.parquet" in lines[0] and "person, 3 steps, broken off" in lines[0]
    assert "person, 10 steps, time after 1.0 s, peak" in lines[1]


def test_a_damaged_and_a_wrong_file_among_others(
    trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_trial(tmp_path / "1.parquet", trial)
    content = bytearray((tmp_path / "1.parquet").read_bytes())
    content[len(content) // 2] ^= 1
    (tmp_path / "2.parquet").write_bytes(content)
    loads = trial.table["probe_in_plane_max"].to_numpy().copy()
    loads[4] = np.nextafter(loads[4], np.float32(0.0))
    write_trial(
        tmp_path / "3.parquet", replace(trial, table=trial.table.with_columns(probe_in_plane_max=pl.Series(loads)))
    )
    assert replayed(tmp_path) == 1
    shown = capsys.readouterr()
    lines = shown.out.splitlines()
    assert "1.parquet: agrees" in lines[0]
    assert lines[1].endswith("2.parquet: the file is damaged: its seal does not fit its contents.")
    assert "3.parquet: does not agree: step 5 (0.5 s): probe_in_plane_max (" in lines[2]
    assert shown.err == "ssmash replay: 2 of 3 trials did not come out as recorded.\n"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "name a file of a recorded trial, or a folder of them"),
        (["none.parquet"], "none.parquet: there is no such file or folder"),
        (["."], "there is no recorded trial in this folder"),
        (["text.parquet"], "1 of 1 trials did not come out"),
        (["one.parquet", "--speed", "0"], "--speed 0 is refused"),
        (["one.parquet", "--speed", "nan"], "--speed nan is refused"),
        (["one.parquet", "two.parquet", "--video", "x.mp4"], "--video is refused: 2 trials are named"),
        (["one.parquet", "--video", "folder"], "this is a folder"),
    ],
)
def test_a_mistake_costs_one_sentence(
    words: list[str], sentence: str, trial: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    if words != ["."]:
        for name in ("one", "two"):
            write_trial(tmp_path / f"{name}.parquet", trial)
        (tmp_path / "text.parquet").write_text("text")
    before = sorted(tmp_path.rglob("*"))
    assert main(["replay", *words]) == 1
    told = capsys.readouterr().err
    assert sentence in told and told.count("\n") == 1 and "Traceback" not in told
    assert sorted(tmp_path.rglob("*")) == before


def test_a_video(trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pygame")
    frames: Any = pytest.importorskip("imageio_ffmpeg")
    write_trial(tmp_path / "one.parquet", trial)
    assert replayed(tmp_path / "one.parquet", "--video", tmp_path / "films" / "one.mp4", "--speed", "2") == 0
    assert "video in" in capsys.readouterr().out
    assert sorted(path.name for path in (tmp_path / "films").iterdir()) == ["one.mp4"]
    count, seconds = frames.count_frames_and_secs(str(tmp_path / "films" / "one.mp4"))
    assert abs(count - 10) <= 1 and seconds == pytest.approx(0.5, abs=0.1)
    broken = replace(trial, table=trial.table.head(0), about={**trial.about, "complete": False})
    write_trial(tmp_path / "none.parquet", broken)
    assert replayed(tmp_path / "none.parquet", "--video", tmp_path / "none.mp4") == 1
    assert "before its first step" in capsys.readouterr().out and not (tmp_path / "none.mp4").exists()
