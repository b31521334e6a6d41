"""A run: same seed, same bits; a resumed run is the run that was never stopped; its folder stands on its own."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from rich.console import Console
from stable_baselines3.common.logger import Logger

from ssmash_gym.cli import main
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training import run as running
from ssmash_gym.training.agent import load_agent
from ssmash_gym.training.algorithms import Linear, make_environment, make_model
from ssmash_gym.training.checkpoint import checkpoints, load_checkpoint, save_checkpoint
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.run import learn

QUIET = Console(quiet=True)


def weights(folder: Path) -> dict[str, np.ndarray]:
    """The numbers of an agent's policy."""
    with np.load(folder / "policy.npz") as arrays:
        return dict(arrays)


def assert_same_agent(one: Path, other: Path) -> None:
    """Both have the same weights and moments, bit for bit."""
    expected = weights(one)
    for name, array in weights(other).items():
        np.testing.assert_array_equal(array, expected[name])
    assert (other / "normaliser.json").read_text() == (one / "normaliser.json").read_text()


def curve(run: Path) -> list[dict[str, str]]:
    """The lines of the curve without what the clock says."""
    with (run / "curve.csv").open(newline="") as file:
        return [
            {k: v for k, v in line.items() if not k.endswith("_s") or k == "time_s_median"}
            for line in csv.DictReader(file)
        ]


def test_the_folder_says_what_was_done(finished: Path, settings: TrainingConfig) -> None:
    assert load_training(finished / "training.yaml") == settings
    about = json.loads((finished / "run.json").read_text())
    assert about["versions"]["torch"] == torch.__version__
    assert about["seed"] == settings.seed
    assert [int(line["steps"]) for line in curve(finished)] == [256, 512, 768]
    assert [path.name for path in checkpoints(finished)] == ["step_0000000256", "step_0000000512", "step_0000000768"]
    assert any((finished / "tensorboard").iterdir())
    assert (finished.parent / "latest" / "agent" / "agent.json").is_file()
    card = (finished / "agent" / "README.md").read_text()
    assert "768 control intervals" in card
    assert str(Path.cwd()) not in card


def test_learning_changes_the_policy(finished: Path) -> None:
    first, last = (weights(checkpoints(finished)[k]) for k in (0, -1))
    assert all(np.any(first[name] != last[name]) for name in first)


def test_same_seed_same_bits_and_another_seed_another_policy(
    finished: Path, settings: TrainingConfig, tmp_path: Path
) -> None:
    assert learn(settings, tmp_path / "again", QUIET)
    assert_same_agent(finished / "agent", tmp_path / "again" / "agent")
    other = settings.model_copy(update={"seed": 1})
    assert learn(other, tmp_path / "other", QUIET)
    name = "weight_0"
    assert np.any(weights(tmp_path / "other" / "agent")[name] != weights(finished / "agent")[name])


def test_a_resumed_run_is_the_run_that_was_never_stopped(
    finished: Path, settings: TrainingConfig, tmp_path: Path
) -> None:
    assert_resumed_is_the_same(settings, finished, tmp_path / "stopped", left=1)


def test_a_resume_that_dies_while_it_writes_the_curve_anew_loses_none_of_it(
    finished: Path, settings: TrainingConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    shutil.rmtree(checkpoints(run)[-1])
    before = (run / "curve.csv").read_text()

    def die(*_: Any) -> None:
        raise OSError("killed")

    monkeypatch.setattr(csv.DictWriter, "writerows", die)
    with pytest.raises(OSError, match="killed"):
        learn(settings, run, QUIET, resumed=True)
    assert (run / "curve.csv").read_text() == before


def test_a_checkpoint_brings_back_counters_schedule_optimiser_and_generators(
    finished: Path, settings: TrainingConfig
) -> None:
    model = make_model(settings, make_environment(settings))
    load_checkpoint(checkpoints(finished)[1], model)
    assert (model.num_timesteps, model._n_updates) == (512, 2 * settings.ppo.epochs)
    moments = model.policy.optimizer.state_dict()["state"]
    assert all(int(entry["step"]) == 2 * settings.ppo.epochs * 4 for entry in moments.values())
    drawn = (torch.rand(1).item(), np.random.random())
    load_checkpoint(checkpoints(finished)[1], model)
    assert (torch.rand(1).item(), np.random.random()) == drawn
    rate = Linear(settings.ppo.learning_rate, settings.ppo.learning_rate_end)
    with (finished / "curve.csv").open() as file:
        logged = [float(line["learning_rate"]) for line in csv.DictReader(file)]
    assert logged[1:] == pytest.approx([rate(1 - 256 / 768), rate(1 - 512 / 768)], rel=1e-4)


def test_a_stop_that_is_asked_for_keeps_everything(finished: Path, settings: TrainingConfig, tmp_path: Path) -> None:
    stop = threading.Event()
    stop.set()
    run = tmp_path / "interrupted"
    assert not learn(settings, run, QUIET, stop=stop)
    assert [path.name for path in checkpoints(run)] == ["step_0000000000"]
    assert not (run / "agent").exists()
    assert learn(settings, run, QUIET, resumed=True)
    assert_same_agent(finished / "agent", run / "agent")


def test_a_stage_changes_the_reward_from_its_step_on_and_after_a_resume(
    finished: Path, settings: TrainingConfig, tmp_path: Path
) -> None:
    staged = load_training(settings.model_dump() | {"stages": [{"from_step": 512, "reward": {"load_per_s": 3.0}}]})
    run = tmp_path / "staged"
    assert learn(staged, run, QUIET)
    assert weights(checkpoints(run)[1])["weight_0"].tobytes() == weights(checkpoints(finished)[1])["weight_0"].tobytes()
    assert weights(run / "agent")["weight_0"].tobytes() != weights(finished / "agent")["weight_0"].tobytes()
    assert load_agent(checkpoints(run)[1]).task.reward.load_per_s == settings_reward(settings)
    assert load_agent(run / "agent").task.reward.load_per_s == 3.0
    assert_resumed_is_the_same(staged, run, tmp_path / "again", left=2)


def test_a_stage_changes_the_scenario_and_a_resumed_run_has_it(settings: TrainingConfig, tmp_path: Path) -> None:
    document = settings.model_dump()
    document["environment"]["task"] |= {"horizon_s": 2.0}  # several episodes
    document["stages"] = [{"from_step": 256, "scenario": {"start.yaw_deg": 3.0}, "reward": {"load_per_s": 1.0}}]
    staged = load_training(document)
    run = tmp_path / "staged"
    assert learn(staged, run, QUIET)
    assert load_agent(checkpoints(run)[0]).scenario.bounds("start.yaw_deg") != (3.0, 3.0)
    assert load_agent(run / "agent").scenario.bounds("start.yaw_deg") == (3.0, 3.0)
    assert_resumed_is_the_same(staged, run, tmp_path / "again", left=2)


def test_a_stage_that_cannot_be_entered_is_told_before_the_start(settings: TrainingConfig, tmp_path: Path) -> None:
    stages = [{"from_step": 256, "scenario": {"claw.delay_s": 0.7}}]
    with pytest.raises(ConfigurationError, match=r"claw\.delay_s"):
        learn(load_training(settings.model_dump() | {"stages": stages}), tmp_path / "run", QUIET)
    assert not list(tmp_path.iterdir())


def assert_resumed_is_the_same(settings: TrainingConfig, run: Path, copied: Path, left: int) -> None:
    """A copy of a finished run with its first `left` checkpoints ends with the same agent and the same curve."""
    shutil.copytree(run, copied)
    shutil.rmtree(copied / "agent")
    for path in checkpoints(copied)[left:]:
        shutil.rmtree(path)
    assert learn(settings, copied, QUIET, resumed=True)
    assert_same_agent(run / "agent", copied / "agent")
    assert curve(copied) == curve(run)


def settings_reward(settings: TrainingConfig) -> float:
    """The load's weight of the unchanged task."""
    return load_task(settings.environment.task).reward.load_per_s


def test_ctrl_c_asks_for_a_stop_and_a_later_one_stops_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from ssmash_gym.training import callbacks
    from ssmash_gym.training.callbacks import stop_on_interrupt

    before = signal.getsignal(signal.SIGINT)
    stop = threading.Event()
    with pytest.raises(KeyboardInterrupt), stop_on_interrupt(stop, QUIET):
        signal.raise_signal(signal.SIGINT)
        assert stop.is_set()
        signal.raise_signal(signal.SIGINT)  # the same one, passed on by a parent
        monkeypatch.setattr(callbacks, "AGAIN_S", 0.0)
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) == before


def test_a_checkpoint_that_is_not_finished_leaves_no_trace(
    settings: TrainingConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = make_model(settings, make_environment(settings))
    model.set_logger(Logger(None, []))
    model._last_obs = model.env.reset()

    def fail(*_: Any) -> bytes:
        raise OSError("disk full")

    monkeypatch.setattr("ssmash_gym.training.checkpoint.pickle.dumps", fail)
    with pytest.raises(OSError, match="disk full"):
        save_checkpoint(tmp_path / "checkpoints" / "step_1", model, settings, {})
    assert not list((tmp_path / "checkpoints").iterdir())


def test_an_incomplete_checkpoint_is_refused(finished: Path, settings: TrainingConfig, tmp_path: Path) -> None:
    folder = tmp_path / "checkpoint"
    shutil.copytree(checkpoints(finished)[0], folder)
    (folder / "environment.pickle").unlink()
    with pytest.raises(ConfigurationError, match=r"environment\.pickle"):
        load_checkpoint(folder, make_model(settings, make_environment(settings)))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--config", "nowhere.yaml"], "nowhere.yaml"),
        (["--config", "smoke", "--set", "ppo.epoch=3"], "epoch"),
        (["--config", "smoke", "--set", "environment.task.horizon=3"], "horizon"),
        (["--config", "smoke", "--set", "algorithm=sac", "network.initial_action=[1.0, 0.0]"], "-0.99 to 0.99"),
        (["--config", "smoke", "--set", "algorithm=tqc", "network.initial_action=[0.0, -1.0]"], "-0.99 to 0.99"),
        (["--resume", "nowhere"], "nowhere"),
        (["--resume", "x", "--config", "smoke"], "--resume"),
    ],
)
def test_a_mistake_costs_one_sentence_and_nothing_is_written(
    words: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["train", *words]) == 1
    message = capsys.readouterr().err
    assert told in message
    assert message.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_folder_in_use_is_not_overwritten(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "--config", "smoke", "--out", str(finished)]) == 1
    assert "not empty" in capsys.readouterr().err


def test_a_missing_library_names_its_extra(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    assert main(["train", "--config", "smoke"]) == 1
    assert "ssmash_gym[train]" in capsys.readouterr().err


def test_runs_are_numbered(tmp_path: Path) -> None:
    (tmp_path / "x-1").mkdir()
    assert running.free_folder(tmp_path, "x").name == "x-2"
