"""Recordings: what was read, with units, configuration and version, in a file that is whole or not there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest

import ssmash_gym
from ssmash_gym.ship import Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.recording import Recorder, read_recording
from ssmash_gym.simulation.telemetry import CHANNELS
from ssmash_gym.vehicle import load_helicopter

CONFIGURATION = {"helicopter": "generic_tricycle", "seed": 7, "deck": {"dof": "roll", "amplitude_deg": 4.0}}


@pytest.fixture
def batch() -> Batch:
    batch = Batch(load_helicopter("generic_tricycle"), 3)
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=4.0, period_s=6.0).bake(2.0, 0.25)] * 3)
    batch.place(0.0, 0.0, [0.0, 0.05, 0.1])
    return batch


def test_round_trip(batch: Batch, tmp_path: Path) -> None:
    recorder = Recorder(batch, ["probe_in_plane", "roll", "position_x"], [2, 0])
    kept = []
    for _ in range(4):
        telemetry = batch.advance([[1.0, 0.2]] * 3)
        recorder.sample(reward=np.array([1.5, -0.5]))
        kept.append((telemetry["probe_in_plane"], telemetry.peak_max("roll"), telemetry["position_x"]))
    assert len(recorder) == 4
    path = tmp_path / "deep" / "run.parquet"
    recorder.write(path, CONFIGURATION)
    frame, about = read_recording(path)
    assert about["configuration"] == CONFIGURATION and about["version"] == ssmash_gym.__version__
    assert about["units"]["probe_in_plane"] == {
        "unit": "N", "frame": "H", "meaning": CHANNELS["probe_in_plane"].meaning,
    }  # fmt: skip
    assert set(about["units"]) == {"probe_in_plane", "roll", "position_x"}
    assert frame.equals(recorder.table())
    assert frame.columns[:2] == ["time_s", "helicopter"] and frame.height == 8
    assert frame["helicopter"].to_list() == [2, 0] * 4 and frame["helicopter"].dtype == pl.Int64
    np.testing.assert_allclose(frame["time_s"].to_numpy(), np.repeat([0.1, 0.2, 0.3, 0.4], 2), atol=1e-12)
    assert frame["reward"].to_list() == [1.5, -0.5] * 4
    for k, (load, roll, x) in enumerate(kept):  # to the last bit
        rows = frame.slice(2 * k, 2)
        assert rows["probe_in_plane"].to_list() == load[[2, 0]].tolist()
        assert rows["roll_max"].to_list() == roll[[2, 0]].tolist()
        assert rows["position_x"].to_list() == x[[2, 0]].tolist()
    assert "position_x_max" not in frame.columns  # a state has no extremes


def test_all_channels_with_and_without_extremes(batch: Batch) -> None:
    every, plain = Recorder(batch), Recorder(batch, peaks=False)
    batch.advance()
    for recorder in (every, plain):
        recorder.sample()
    assert set(plain.table().columns) == {"time_s", "helicopter", *CHANNELS}
    peaked = sum(c.has_peaks for c in CHANNELS.values())
    assert len(every.table().columns) == 2 + len(CHANNELS) + 2 * peaked
    assert every.table().height == 3


def test_samples_are_of_their_time(batch: Batch) -> None:
    """What was sampled does not change as the batch goes on."""
    recorder = Recorder(batch, ["claw_x"])
    for _ in range(3):
        batch.advance([[1.0, 0.0]] * 3)
        recorder.sample()
    claw = recorder.table()["claw_x"].to_numpy().reshape(3, 3)
    assert claw[0, 0] == 0.0 and 0.0 < claw[1, 0] < claw[2, 0]


def test_an_empty_recording(batch: Batch, tmp_path: Path) -> None:
    recorder = Recorder(batch, ["roll"])
    assert recorder.table().is_empty() and len(recorder) == 0
    recorder.write(tmp_path / "empty.parquet", {})
    assert read_recording(tmp_path / "empty.parquet")[0].is_empty()


def test_an_unknown_channel_is_refused_at_once(batch: Batch) -> None:
    with pytest.raises(KeyError, match=r"no channel 'rol'; close: .*roll"):
        Recorder(batch, ["rol"])


@pytest.mark.parametrize("there_before", [True, False])
def test_a_file_is_whole_or_as_it_was(
    batch: Batch, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, there_before: bool
) -> None:
    """The disk fills half-way through: no half file, no temporary left, what stood there still stands."""
    path = tmp_path / "run.parquet"
    recorder = Recorder(batch, ["roll"])
    batch.advance()
    recorder.sample()
    if there_before:
        recorder.write(path, CONFIGURATION)
    before = path.read_bytes() if there_before else None

    def fails(self: pl.DataFrame, file: Path, **_: object) -> None:
        Path(file).write_bytes(b"PAR1 and then nothing")
        raise OSError("no space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(pl.DataFrame, "write_parquet", fails)
        with pytest.raises(OSError, match="no space left"):
            recorder.write(path, {"other": 1})
    assert [p.name for p in tmp_path.iterdir()] == (["run.parquet"] if there_before else [])
    if there_before:
        assert path.read_bytes() == before
    with pytest.raises(TypeError):  # what is no JSON is found before anything is written
        recorder.write(path, {"object": object()})
    assert [p.name for p in tmp_path.iterdir()] == (["run.parquet"] if there_before else [])
