"""Runs of recordings and of trials: the frames are those of the same states seen live."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.cases.description import case_from
from ssmash_gym.cases.run import run_case
from ssmash_gym.console.recorded import state_of
from ssmash_gym.console.runs import run_of_recording, run_of_trial, runs_of
from ssmash_gym.console.scene import frame_of
from ssmash_gym.dynamics.layout import State
from ssmash_gym.envs.rendering.pose import helicopter_pose
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.ship.config import parse_motion
from ssmash_gym.ship.motion import MotionTable
from ssmash_gym.simulate import simulate
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.simulation.recording import read_recording
from ssmash_gym.simulation.telemetry import CHANNELS
from ssmash_gym.trials.files import write_trial
from ssmash_gym.trials.recorder import TrialRecorder
from ssmash_gym.trials.stamps import Stamp
from ssmash_gym.vehicle import load_helicopter
from ssmash_gym.vehicle.geometry import rotation
from tests.console.seas import started

COORDINATES = slice(State.Q8, State.TIRE)


def same_attitude(a: np.ndarray, b: np.ndarray) -> None:
    """Positions agree, and so do the four rotations whatever the signs of their Euler parameters."""
    np.testing.assert_allclose(a[State.Q8 : State.Q11], b[State.Q8 : State.Q11], atol=1e-9)
    for row in (State.Q11, State.Q16, State.Q21, State.Q26):
        np.testing.assert_allclose(rotation(a[row : row + 4]), rotation(b[row : row + 4]), atol=2e-6)
    for row in (State.Q15, State.Q20, State.Q25):
        assert a[row] == pytest.approx(b[row], abs=1e-9)


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_state_comes_back_from_telemetry(name: str) -> None:
    batch = Batch(load_helicopter(name))
    motion = parse_motion({"type": "sinusoid", "dof": "roll", "amplitude_deg": 6.0, "period_s": 4.0})
    deck = motion.realise(np.random.default_rng(0)).bake(6.0, batch.timing.node_spacing_s, ramp_s=1.0)
    batch.set_motion([deck])
    batch.place(0.0, 0.0, 0.1)
    for _ in range(25):
        batch.advance(np.array([[0.7, 0.4]]))
    at = {channel: float(batch.telemetry[channel][0]) for channel in CHANNELS}
    same_attitude(state_of(at, batch), batch.state[:, 0])


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recordings") / "roll.parquet"
    simulate(out=path, duration_s=4.0, lead_in_s=1.0, along=0.6, yaw_deg=3.0)
    return path


def test_recording_shows_what_was_simulated(recording: Path) -> None:
    run = run_of_recording(recording)
    table, about = read_recording(recording)
    assert len(run["frames"]) == table.height == 41
    assert run["version"] == about["version"]
    batch = Batch(load_helicopter("generic_tricycle"))
    motion = parse_motion(about["configuration"]["motion"]).realise(np.random.default_rng(0))
    batch.set_motion([motion.bake(5.0, batch.timing.node_spacing_s, ramp_s=1.0)])
    batch.place(0.0, 0.0, np.radians(3.0))
    for k in range(40):
        batch.advance(np.array([[0.6, 0.0]]) if k >= 10 else None)
        frame = run["frames"][k + 1]
        loads = [float(batch.telemetry[f"{s}_vertical_load"][0]) for s in ("auxiliary", "right", "left")]
        pose = helicopter_pose(batch.state[:, 0], batch.parameters[:, 0], [2, 2, 2], loads)
        np.testing.assert_allclose(frame["body"][:3], pose["r_SH_S"], atol=1e-4)
        np.testing.assert_allclose(np.array(frame["tires"])[:, :3], pose["wheels"].r_ST_S, atol=2e-4)
        np.testing.assert_allclose(frame["load_kN"], 1e-3 * np.array(loads), atol=0.01)
        deck = MotionTable(batch.timing.node_spacing_s, batch.nodes[0]).pose(float(batch.time_s[0]))
        np.testing.assert_allclose(rotation(np.array(frame["ship"][3:])), deck.R_NS, atol=5e-5)
        assert frame["probe_peak_kN"] == pytest.approx(1e-3 * batch.telemetry.peak_max("probe_in_plane")[0], abs=1e-3)


def test_case_is_shown_with_its_heave(tmp_path: Path) -> None:
    document = {
        "name": "heave", "helicopter": "generic_tricycle",
        "deck": {"type": "sinusoid", "dof": "heave", "amplitude_m": 1.0, "period_s": 4.0},
        "solution": {"start_s": 0.5, "end_s": 2.5, "output_step_s": 0.02},
    }  # fmt: skip
    history = run_case(case_from(document))
    history.write(tmp_path / "heave.parquet")
    run = run_of_recording(tmp_path / "heave.parquet")
    frames = run["frames"]
    assert frames[0]["t"] == 0.5
    assert frames[-1]["t"] == pytest.approx(2.5)
    steps = np.diff([frame["t"] for frame in frames])
    assert steps.max() < 0.07, "frames of a fine recording are thinned out, not lost"
    truth = history.deck.pose(np.array([frame["t"] for frame in frames]) - 0.5).r_NS_N[:, 2]
    np.testing.assert_allclose([frame["ship"][2] for frame in frames], truth, atol=1e-4)
    assert np.ptp(truth) > 0.5
    highest = max(frame["probe_peak_kN"] for frame in frames)
    assert highest == pytest.approx(1e-3 * history.peak_max("probe_in_plane").max(), abs=1e-3)


def recorded_trial(path: Path) -> list[dict[str, Any]]:
    """Write a short trial; the frames that were seen meanwhile."""
    batch = started()
    condition = Condition("test", "", batch.task, batch.scenario, batch.starter.helicopter)
    recorder = TrialRecorder(batch, condition, 3, {"origin": "script"})
    frames = [frame_of(batch)]
    for k in range(20):
        result = batch.step([[0.9, 0.4 * np.sin(k)]])
        stamp = Stamp("scripted operator", "", k, np.nan, np.nan, 0.1 * k, 0.1 * k, False, k - 1)
        recorder.note(result, stamp)
        frames.append(frame_of(batch))
    write_trial(path, recorder.trial(complete=bool(batch.book.over[0])))
    return frames


def test_trial_is_seen_again_as_it_was(tmp_path: Path) -> None:
    frames = recorded_trial(tmp_path / "trial.parquet")
    (run,) = runs_of([tmp_path / "trial.parquet"])
    assert run["frames"] == frames
    assert run["driver"] == "scripted operator"
    assert run["note"] == ""
    assert run["name"] == "trial"
    assert all(moment["words"] for moment in run["moments"])


def test_trial_that_does_not_replay_says_so(tmp_path: Path) -> None:
    from ssmash_gym.trials.files import read_trial
    from ssmash_gym.trials.trial import Trial

    recorded_trial(tmp_path / "trial.parquet")
    trial = read_trial(tmp_path / "trial.parquet")
    other = trial.table.with_columns((pl.col("probe_in_plane") + 1.0).alias("probe_in_plane"))
    assert "does not agree" in run_of_trial(Trial(other, trial.about), "other")["note"]


def test_what_cannot_be_shown_is_told_in_a_sentence(tmp_path: Path, recording: Path) -> None:
    with pytest.raises(ConfigurationError, match="there is no such file"):
        runs_of([tmp_path / "none.parquet"])
    (tmp_path / "text.parquet").write_text("no table")
    with pytest.raises(ConfigurationError, match="no Parquet file"):
        runs_of([tmp_path / "text.parquet"])
    pl.DataFrame({"x": [1.0]}).write_parquet(tmp_path / "table.parquet")
    with pytest.raises(ConfigurationError, match="neither a trial nor a recording"):
        runs_of([tmp_path / "table.parquet"])
    table, metadata = pl.read_parquet(recording), pl.read_parquet_metadata(recording)
    kept = {key: value for key, value in metadata.items() if key.startswith("ssmash_gym")}
    table.drop("claw_y").write_parquet(tmp_path / "part.parquet", metadata=kept)
    with pytest.raises(ConfigurationError, match="no channel claw_y"):
        runs_of([tmp_path / "part.parquet"])
    table.write_parquet(tmp_path / "dumb.parquet", metadata={**kept, "ssmash_gym.configuration": "{}"})
    with pytest.raises(ConfigurationError, match="names no helicopter"):
        runs_of([tmp_path / "dumb.parquet"])
