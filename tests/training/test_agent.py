"""An agent's folder: what was learned comes back, frozen; half a folder is refused."""

from __future__ import annotations

import base64
import itertools
import json
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.observations import chosen_terms
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import Residual, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.training.agent import Agent, inputs, load_agent, save_agent
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.network import ACTIVATIONS, Network, _affine, policy_network
from ssmash_gym.training.normaliser import Normaliser


@pytest.fixture
def copied(finished: Path, tmp_path: Path) -> Path:
    """A copy of the agent that may be spoiled."""
    return Path(shutil.copytree(finished / "agent", tmp_path / "agent"))


def some_observations(n: int, size: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-3.0, 3.0, (n, size)).astype(np.float32)


def test_the_agent_does_what_stable_baselines_does(finished: Path) -> None:
    from stable_baselines3 import PPO

    agent = load_agent(finished / "agent")
    model = PPO.load(finished / "agent" / "policy.zip", device="cpu")
    seen = some_observations(50, len(chosen_terms(agent.task.observation)))
    expected, _ = model.predict(agent.normaliser(seen), deterministic=True)
    np.testing.assert_allclose(agent.act(seen), expected, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_every_activation_agrees_with_pytorch(activation: str, settings: TrainingConfig) -> None:
    from ssmash_gym.training.algorithms import make_environment, make_model

    network = settings.network.model_copy(update={"activation": activation, "initial_action": (0.4, -0.2)})
    model = make_model(settings.model_copy(update={"network": network}), make_environment(settings))
    seen = some_observations(20, model.observation_space.shape[0])
    expected, _ = model.predict(seen, deterministic=True)
    found = policy_network(model.policy)
    assert found.activation == activation
    np.testing.assert_allclose(np.clip(found(seen), -1.0, 1.0), expected, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(np.mean(found(seen), axis=0), [0.4, -0.2], atol=0.05)


def actor(library: str, name: str, **changes: object) -> Any:
    """An untrained policy of SAC's or TQC's kind."""
    import torch
    from gymnasium.spaces import Box

    module = pytest.importorskip(f"{library}.{name}.policies")
    torch.manual_seed(3)
    observed, commanded = Box(-5.0, 5.0, (43,), np.float32), Box(-1.0, 1.0, (2,), np.float32)
    kind = getattr(module, f"{name.upper()}Policy")
    return kind(observed, commanded, lambda _: 1e-3, net_arch=[32, 24], **changes)


@pytest.mark.parametrize(("library", "name"), [("stable_baselines3", "sac"), ("sb3_contrib", "tqc")])
def test_actors_with_a_squashed_output_agree_with_pytorch(library: str, name: str) -> None:
    import torch

    policy = actor(library, name)
    with torch.no_grad():
        policy.actor.mu.weight.mul_(8.0)
    found = policy_network(policy)
    assert (found.activation, found.squash, found.sizes) == ("relu", True, [43, 32, 24, 2])
    seen = some_observations(200, 43)
    expected, _ = policy.predict(seen, deterministic=True)
    assert np.max(np.abs(expected)) > 0.9, "the squashing must matter"
    np.testing.assert_allclose(found(seen), expected, rtol=0.0, atol=1e-6)


def test_the_model_of_stable_baselines_needs_nothing_of_this_package(finished: Path) -> None:
    """A later version may move its modules; what was trained before must still load."""
    with zipfile.ZipFile(finished / "agent" / "policy.zip") as archive:
        data = json.loads(archive.read("data"))
    held = {key: base64.b64decode(entry[":serialized:"]) for key, entry in data.items() if ":serialized:" in str(entry)}
    assert "policy_class" in held
    assert [key for key, pickled in held.items() if b"ssmash_gym" in pickled] == []


def test_exploration_that_depends_on_the_state_is_not_taken_for_another_network() -> None:
    with pytest.raises(ValueError, match="use_sde"):
        policy_network(actor("stable_baselines3", "sac", use_sde=True))


def some_network(*sizes: int, activation: str = "tanh", squash: bool = False) -> Network:
    rng = np.random.default_rng(1)
    weights = tuple(rng.normal(0.0, 0.3, pair).astype(np.float32) for pair in itertools.pairwise(sizes))
    biases = tuple(rng.normal(0.0, 0.3, size).astype(np.float32) for size in sizes[1:])
    return Network(weights, biases, activation, squash)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_bits_are_the_same_in_batches_of_1_to_300(activation: str) -> None:
    network = some_network(43, 33, 16, 2, activation=activation, squash=True)
    seen = some_observations(300, 43)
    together = network(seen)
    for n in range(1, 301):
        np.testing.assert_array_equal(network(seen[-n:]), together[-n:])
    np.testing.assert_array_equal(network(np.asfortranarray(seen)), together)
    np.testing.assert_array_equal(network(np.repeat(seen, 2, axis=0)[::2]), together)


def test_the_compiled_sum_has_the_bits_of_the_sum_input_by_input() -> None:
    rng = np.random.default_rng(2)
    x, weight, bias = rng.normal(size=(50, 37)), rng.normal(size=(37, 19)), rng.normal(size=19)
    total = np.broadcast_to(bias, (50, 19)).copy()
    for k in range(37):
        total += x[:, k : k + 1] * weight[k]
    np.testing.assert_array_equal(_affine(x, weight, bias), total)


def test_bits_do_not_depend_on_the_size_of_the_batch(finished: Path) -> None:
    agent = load_agent(finished / "agent")
    seen = some_observations(67, len(chosen_terms(agent.task.observation)))
    together = agent.act(seen)
    np.testing.assert_array_equal(np.concatenate([agent.act(row[None]) for row in seen]), together)
    np.testing.assert_array_equal(np.concatenate([agent.act(seen[:13]), agent.act(seen[13:])]), together)


def test_an_agent_that_was_saved_and_loaded_has_the_same_returns(finished: Path, copied: Path) -> None:
    agent, again = load_agent(finished / "agent"), load_agent(copied)
    scenario = load_scenario("calm")
    first = run_episodes(agent, scenario, [11, 12, 13])
    assert run_episodes(again, scenario, [11, 12, 13]).equals(first)


def test_evaluation_leaves_the_normaliser_alone(finished: Path) -> None:
    before = (finished / "agent" / "normaliser.json").read_text()
    agent = load_agent(finished / "agent")
    assert agent.normaliser.observation is not None
    assert agent.normaliser.observation.count > 768
    run_episodes(agent, load_scenario("calm"), [1, 2])
    assert agent.normaliser == load_agent(finished / "agent").normaliser
    assert (finished / "agent" / "normaliser.json").read_text() == before


def test_moments_survive_their_file_and_their_wrapper(finished: Path, tmp_path: Path, settings: TrainingConfig) -> None:
    from ssmash_gym.training.algorithms import make_environment

    found = Normaliser.read(finished / "agent" / "normaliser.json")
    found.write(tmp_path / "n.json")
    wrapper = make_environment(settings)
    Normaliser.read(tmp_path / "n.json").into(wrapper)
    assert Normaliser.of(wrapper) == found
    seen = some_observations(5, wrapper.observation_space.shape[0])
    np.testing.assert_allclose(found(seen), wrapper.normalize_obs(seen), atol=1e-6)


def test_an_agent_without_its_normaliser_is_refused(copied: Path) -> None:
    (copied / "normaliser.json").unlink()
    with pytest.raises(ConfigurationError, match=r"normaliser\.json"):
        load_agent(copied)


def test_a_folder_that_is_no_agent_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="no agent"):
        load_agent(tmp_path)


def test_an_agent_of_another_format_is_refused(copied: Path) -> None:
    about = json.loads((copied / "agent.json").read_text())
    (copied / "agent.json").write_text(json.dumps(about | {"format": 99}))
    with pytest.raises(ConfigurationError, match="format 99"):
        load_agent(copied)


def test_an_agent_of_a_newer_version_is_refused_with_the_remedy(copied: Path) -> None:
    spoil(copied, format=3)
    with pytest.raises(ConfigurationError, match=r"format 3 is unknown; .*newer ssmash_gym.*update"):
        load_agent(copied)


def spoil(folder: Path, **changes: object) -> None:
    about = json.loads((folder / "agent.json").read_text())
    (folder / "agent.json").write_text(json.dumps(about | changes))


def test_the_squashing_is_kept_and_an_older_format_has_none(finished: Path, copied: Path) -> None:
    numbers = load_agent(finished / "agent").network.arrays()
    np.savez(copied / "policy.npz", **numbers | {"weight_2": 50.0 * numbers["weight_2"]})
    agent = load_agent(copied)
    seen = some_observations(9, agent.network.sizes[0])
    spoil(copied, squash=True)
    squashed = load_agent(copied).act(seen)
    np.testing.assert_allclose(squashed, np.tanh(agent.network(agent.normaliser(seen))), atol=1e-6)
    assert np.max(np.abs(squashed - agent.act(seen))) > 1e-3
    about = json.loads((copied / "agent.json").read_text())
    del about["squash"]
    (copied / "agent.json").write_text(json.dumps(about | {"format": 1}))
    np.testing.assert_array_equal(load_agent(copied).act(seen), agent.act(seen))


@pytest.mark.parametrize("content", [b"", b"no numbers", None])
def test_an_agent_whose_numbers_cannot_be_read_is_refused(copied: Path, content: bytes | None) -> None:
    (copied / "policy.npz").unlink()
    if content is not None:
        (copied / "policy.npz").write_bytes(content)
    with pytest.raises(ConfigurationError, match=r"policy\.npz: the policy's numbers cannot be read"):
        load_agent(copied)


def test_an_agent_with_another_network_than_it_says_is_refused(copied: Path) -> None:
    np.savez(copied / "policy.npz", **some_network(12, 8, 2).arrays())
    with pytest.raises(ConfigurationError, match=r"from 12 to 2 numbers .* 43 to 2"):
        load_agent(copied)


def test_arrays_that_do_not_follow_each_other_are_no_network() -> None:
    arrays = some_network(5, 4, 2).arrays() | {"weight_1": np.zeros((3, 2), np.float32)}
    with pytest.raises(ValueError, match="no perceptron"):
        Network.of_arrays(arrays, "tanh")


def test_an_agent_that_saw_other_scales_is_refused(copied: Path) -> None:
    about = json.loads((copied / "agent.json").read_text())
    about["observation"][0]["scale"] *= 2.0
    (copied / "agent.json").write_text(json.dumps(about))
    with pytest.raises(ConfigurationError, match="scales"):
        load_agent(copied)


def test_an_agent_is_refused_in_a_task_it_cannot_read(finished: Path) -> None:
    agent = load_agent(finished / "agent")
    with pytest.raises(ConfigurationError, match="observation terms"):
        agent.within(load_task({"observation": ["yaw", "to_go"]}))
    with pytest.raises(ConfigurationError, match=r"control_interval_s = 0\.2"):
        agent.within(load_task({"control_interval_s": 0.2}))
    with pytest.raises(ConfigurationError, match="observation_clip = 3"):
        agent.within(load_task({"observation_clip": 3.0}))
    assert agent.within(load_task({"horizon_s": 30.0})).task.horizon_s == 30.0


HISTORY = {"terms": ["deck_roll", "yaw"], "samples": 2, "every_s": 0.2}


def test_history_and_residual_action_go_with_the_agent(finished: Path) -> None:
    agent = load_agent(finished / "agent")
    residual = Residual(baseline="yield", along=0.1, across=0.2)
    own = load_task({"history": HISTORY}).history
    assert agent.within(load_task({"history": HISTORY})).task.history is None
    remembering = replace(agent, task=agent.task.model_copy(update={"history": own, "residual": residual}))
    elsewhere = remembering.within(load_task({"horizon_s": 30.0})).task
    assert (elsewhere.history, elsewhere.residual, elsewhere.horizon_s) == (own, residual, 30.0)


@pytest.fixture(scope="module")
def remembering(tmp_path_factory: pytest.TempPathFactory, settings: TrainingConfig) -> Path:
    """The folder of an untrained agent that sees past readings."""
    from ssmash_gym.training.algorithms import make_environment, make_model

    section = settings.environment.model_copy(update={"task": {**dict(settings.environment.task), "history": HISTORY}})
    config = settings.model_copy(update={"environment": section})
    wrapper = make_environment(config)
    core = wrapper.venv.core
    folder = tmp_path_factory.mktemp("history") / "agent"
    save_agent(folder, make_model(config, wrapper), wrapper, config, core.task, core.scenario, {"steps": 0})
    return folder


def test_past_readings_are_inputs_by_name(remembering: Path) -> None:
    agent: Agent = load_agent(remembering)
    assert agent.network.sizes[0] == 43 + 4
    assert [entry["name"] for entry in agent.about["observation"][43:]] == [
        "deck_roll_before_0.2s", "deck_roll_before_0.4s", "yaw_before_0.2s", "yaw_before_0.4s",
    ]  # fmt: skip
    assert agent.about["observation"] == inputs(agent.task)
    assert agent.within(load_task()).task.history == agent.task.history


def test_an_agent_whose_history_was_changed_is_refused(remembering: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(remembering, tmp_path / "agent"))
    text = (folder / "task.yaml").read_text()
    assert "every_s: 0.2" in text
    (folder / "task.yaml").write_text(text.replace("every_s: 0.2", "every_s: 0.3"))
    with pytest.raises(ConfigurationError, match="other observation terms"):
        load_agent(folder)


def test_a_network_survives_its_arrays() -> None:
    network = some_network(5, 7, 3, 2, activation="elu")
    seen = some_observations(4, 5)
    np.testing.assert_array_equal(Network.of_arrays(network.arrays(), "elu")(seen), network(seen))
