"""The ONNX file of an agent: from the observation as it comes to the action that NumPy and PyTorch give too."""

from __future__ import annotations

import itertools
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training.agent import Agent, load_agent
from ssmash_gym.training.network import ACTIVATIONS, Network, policy_network
from ssmash_gym.training.onnx import check_onnx, export_onnx, run_onnx

onnx = pytest.importorskip("onnx")
onnxruntime = pytest.importorskip("onnxruntime")

SAME = 1e-6


@pytest.fixture(scope="module")
def model(finished: Path) -> Any:
    """The Stable-Baselines3 model, its last layer enlarged: hardly trained, it would command next to nothing."""
    import torch
    from stable_baselines3 import PPO

    found = PPO.load(finished / "agent" / "policy.zip", device="cpu")
    with torch.no_grad():
        found.policy.action_net.weight.mul_(40.0)
    return found


@pytest.fixture(scope="module")
def agent(finished: Path, model: Any) -> Agent:
    """An agent of that model, with a normaliser of observations."""
    return replace(load_agent(finished / "agent"), network=policy_network(model.policy))


@pytest.fixture(scope="module")
def exported(agent: Agent, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its ONNX file."""
    path = tmp_path_factory.mktemp("onnx") / "policy.onnx"
    export_onnx(agent, path)
    return path


def torch_actions(model: Any, agent: Agent, seen: np.ndarray) -> np.ndarray:
    actions, _ = model.predict(agent.normaliser(seen), deterministic=True)
    assert np.ptp(actions) > 0.2, "there must be something to compare"
    return np.asarray(actions)


def random_observations(n: int, size: int, bound: float) -> np.ndarray:
    return np.random.default_rng(5).uniform(-bound, bound, (n, size)).astype(np.float32)


def test_onnx_numpy_and_pytorch_agree_on_random_observations(model: Any, agent: Agent, exported: Path) -> None:
    seen = random_observations(300, agent.network.sizes[0], agent.task.observation_clip)
    found = run_onnx(exported, seen)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, agent.act(seen), rtol=0.0, atol=SAME)
    np.testing.assert_allclose(found, torch_actions(model, agent, seen), rtol=0.0, atol=SAME)


def test_onnx_numpy_and_pytorch_agree_on_observations_of_episodes(model: Any, agent: Agent, exported: Path) -> None:
    core = TraverseBatch(3, task=agent.task, scenario=agent.scenario)
    seen = [core.reset(seeds=[1, 2, 3]).copy()]
    for _ in range(25):
        seen.append(core.step(agent.act(seen[-1])).observation)
    together = np.concatenate(seen)
    assert np.ptp(together, axis=0).max() > 0.1
    found = run_onnx(exported, together)
    np.testing.assert_allclose(found, agent.act(together), rtol=0.0, atol=SAME)
    np.testing.assert_allclose(found, torch_actions(model, agent, together), rtol=0.0, atol=SAME)


@pytest.mark.parametrize(("activation", "squash"), [(name, name == "relu") for name in sorted(ACTIVATIONS)])
def test_every_activation_with_large_weights(agent: Agent, tmp_path: Path, activation: str, squash: bool) -> None:
    rng = np.random.default_rng(0)
    sizes = (43, 64, 64, 2)
    weights = tuple(rng.normal(0.0, 2.0 / a**0.5, (a, b)).astype(np.float32) for a, b in itertools.pairwise(sizes))
    network = Network(weights, tuple(rng.normal(size=b).astype(np.float32) for b in sizes[1:]), activation, squash)
    other = replace(agent, network=network)
    export_onnx(other, tmp_path / "policy.onnx")
    seen = random_observations(500, 43, 2.0)
    assert np.ptp(other.act(seen)) > 1.5
    np.testing.assert_allclose(run_onnx(tmp_path / "policy.onnx", seen), other.act(seen), rtol=0.0, atol=SAME)


def test_without_normaliser_of_observations(agent: Agent, tmp_path: Path) -> None:
    plain = replace(agent, normaliser=replace(agent.normaliser, observation=None))
    export_onnx(plain, tmp_path / "policy.onnx")
    seen = random_observations(20, 43, 5.0)
    assert check_onnx(plain, tmp_path / "policy.onnx", [seen]) <= SAME
    assert np.max(np.abs(plain.act(seen) - agent.act(seen))) > 1e-3


def test_the_file_says_what_its_numbers_are(agent: Agent, exported: Path) -> None:
    session = onnxruntime.InferenceSession(exported, providers=["CPUExecutionProvider"])
    (given,), (taken,) = session.get_inputs(), session.get_outputs()
    assert (given.name, given.type, given.shape) == ("observation", "tensor(float)", ["n", 43])
    assert (taken.name, taken.type, taken.shape) == ("action", "tensor(float)", ["n", 2])
    told = session.get_modelmeta().custom_metadata_map
    assert json.loads(told["observation"]) == agent.about["observation"]
    assert told["name"] == agent.name
    assert told["configuration"] == agent.about["configuration"]
    assert told["version"] == agent.about["versions"]["ssmash_gym"]
    assert float(told["control_interval_s"]) == agent.task.control_interval_s
    assert [entry["scale"] for entry in json.loads(told["action"])] == [0.3, 0.1]
    assert json.loads(told["residual"]) is None


def test_the_file_is_of_an_opset_that_older_runtimes_know(exported: Path) -> None:
    model = onnx.load(exported)
    assert [(entry.domain, entry.version) for entry in model.opset_import] == [("", 17)]
    assert model.ir_version == 8


def test_another_agent_is_told_from_the_file(agent: Agent, exported: Path) -> None:
    network = agent.network
    biases = (*network.biases[:-1], network.biases[-1] + np.float32(1e-4))
    other = replace(agent, network=Network(network.weights, biases, network.activation))
    with pytest.raises(ConfigurationError, match="differ from the agent's by 1"):
        check_onnx(other, exported, [random_observations(4, 43, 0.5)])


def test_a_missing_library_is_told_with_its_extra(
    agent: Agent, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(ImportError, match=r"ssmash_gym\[onnx\]"):
        export_onnx(agent, tmp_path / "policy.onnx")
    assert not list(tmp_path.iterdir())
