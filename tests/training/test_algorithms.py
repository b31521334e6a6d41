"""SAC and TQC: they learn, repeat themselves, and go on as if they had never been stopped."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from rich.console import Console

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training.agent import load_agent
from ssmash_gym.training.algorithms import chosen_device, make_environment, make_model
from ssmash_gym.training.checkpoint import TRANSITIONS, checkpoints
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.run import learn

QUIET = Console(quiet=True)
SMALL = {
    "steps_per_update": 64, "train_every": 4, "gradient_steps": 2, "batch_size": 32, "buffer_size": 600,
    "learning_starts": 100, "n_steps": 2,
}  # fmt: skip


@pytest.fixture(scope="module", params=["sac", "tqc"])
def learned(request: pytest.FixtureRequest, settings: TrainingConfig, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Settings and run folder of a small training whose store of transitions overflows."""
    small = load_training(settings.model_dump() | {"algorithm": request.param, request.param: SMALL})
    run = tmp_path_factory.mktemp(request.param) / "run"
    assert learn(small, run, QUIET)
    return small, run


def weights(folder: Path) -> dict[str, np.ndarray]:
    with np.load(folder / "policy.npz") as arrays:
        return dict(arrays)


def assert_same_weights(one: Path, other: Path) -> None:
    expected = weights(one)
    for name, array in weights(other).items():
        np.testing.assert_array_equal(array, expected[name])


def lines(run: Path) -> list[dict[str, str]]:
    with (run / "curve.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_it_learns_and_tells_its_own_curve(learned: tuple[TrainingConfig, Path]) -> None:
    small, run = learned
    found = lines(run)
    assert [int(line["steps"]) for line in found] == [256, 512, 768]
    assert {"entropy_weight", "actor_loss", "critic_loss"} < set(found[0])
    assert float(found[-1]["entropy_weight"]) != pytest.approx(small.learner.first_entropy, rel=1e-6)
    first, last = (weights(checkpoints(run)[k]) for k in (0, -1))
    assert all(np.any(first[name] != last[name]) for name in first)


def test_the_agent_does_what_the_model_does(learned: tuple[TrainingConfig, Path]) -> None:
    small, run = learned
    agent = load_agent(run / "agent")
    model = make_model(small, make_environment(small))
    model.set_parameters(run / "agent" / "policy.zip", device="cpu")
    seen = np.random.default_rng(0).uniform(-3.0, 3.0, (40, *model.observation_space.shape)).astype(np.float32)
    expected, _ = model.predict(agent.normaliser(seen), deterministic=True)
    np.testing.assert_allclose(agent.act(seen), expected, atol=2e-6)


def test_a_resumed_run_is_the_run_that_was_never_stopped(learned: tuple[TrainingConfig, Path], tmp_path: Path) -> None:
    small, run = learned
    copied = tmp_path / "stopped"
    shutil.copytree(run, copied)
    shutil.rmtree(copied / "agent")
    shutil.rmtree(checkpoints(copied)[-1])
    shutil.rmtree(checkpoints(copied)[-1])
    assert learn(small, copied, QUIET, resumed=True)
    assert_same_weights(run / "agent", copied / "agent")
    with np.load(checkpoints(copied)[-1] / TRANSITIONS) as one, np.load(checkpoints(run)[-1] / TRANSITIONS) as other:
        assert all(np.array_equal(one[name], other[name]) for name in other)
    timed = ("collect_s", "update_s", "wall_s")
    one, other = ([{k: v for k, v in line.items() if k not in timed} for line in lines(r)] for r in (run, copied))
    assert one == other


def test_without_its_transitions_a_run_collects_anew(
    settings: TrainingConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkpoints_without = settings.checkpoints.model_copy(update={"replay_buffer": False})
    document = settings.model_dump() | {"algorithm": "sac", "sac": SMALL, "total_steps": 256}
    small = load_training(document | {"checkpoints": checkpoints_without.model_dump()})
    run = tmp_path / "run"
    assert learn(small, run, QUIET)
    assert not (checkpoints(run)[-1] / TRANSITIONS).exists()
    longer = small.model_copy(update={"total_steps": 512})
    assert learn(longer, run, QUIET, resumed=True)
    with pytest.raises(ConfigurationError, match=r"transitions\.npz"):
        kept = settings.checkpoints.model_copy(update={"replay_buffer": True})
        learn(longer.model_copy(update={"checkpoints": kept}), run, QUIET, resumed=True)


@pytest.mark.parametrize("algorithm", ["ppo", "sac", "tqc"])
def test_the_first_policy_is_the_one_that_is_asked_for(algorithm: str, settings: TrainingConfig) -> None:
    network = settings.network.model_copy(update={"initial_action": (0.5, -0.25), "log_std": -2.0})
    asked = settings.model_copy(update={"algorithm": algorithm, "network": network})
    model = make_model(asked, make_environment(asked))
    seen = np.zeros((4000, *model.observation_space.shape), np.float32)
    mean, _ = model.predict(seen[:1], deterministic=True)
    np.testing.assert_allclose(mean, [[0.5, -0.25]], atol=0.02)
    drawn, _ = model.predict(seen, deterministic=False)
    slope = [1.0, 1.0] if algorithm == "ppo" else [1.0 - 0.5**2, 1.0 - 0.25**2]  # of the tanh
    np.testing.assert_allclose(drawn.std(axis=0), np.exp(-2.0) * np.array(slope), rtol=0.15)


def test_a_gpu_is_taken_when_it_is_there_and_wanted(settings: TrainingConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    def chosen(device: str) -> str:
        return chosen_device(settings.model_copy(update={"device": device}))

    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert [chosen(device) for device in ("auto", "cpu", "cuda")] == ["cuda", "cpu", "cuda"]
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert [chosen(device) for device in ("auto", "cpu")] == ["cpu", "cpu"]
    with pytest.raises(ConfigurationError, match="device = 'cuda'"):
        chosen("cuda")
