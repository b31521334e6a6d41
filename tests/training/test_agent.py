"""An agent's folder: what was learned comes back, frozen; half a folder is refused."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.envs.observations import chosen_terms
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.training.agent import load_agent
from ssmash_gym.training.config import TrainingConfig
from ssmash_gym.training.network import ACTIVATIONS, Network, policy_network
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
    np.testing.assert_allclose(agent.act(seen), expected, atol=2e-6)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_every_activation_agrees_with_pytorch(activation: str, settings: TrainingConfig) -> None:
    from ssmash_gym.training.ppo import make_environment, make_model

    network = settings.network.model_copy(update={"activation": activation, "initial_action": (0.4, -0.2)})
    model = make_model(settings.model_copy(update={"network": network}), make_environment(settings))
    seen = some_observations(20, model.observation_space.shape[0])
    expected, _ = model.predict(seen, deterministic=True)
    found = policy_network(model.policy, activation)
    np.testing.assert_allclose(np.clip(found(seen), -1.0, 1.0), expected, atol=2e-6)
    np.testing.assert_allclose(np.mean(found(seen), axis=0), [0.4, -0.2], atol=0.05)


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
    from ssmash_gym.training.ppo import make_environment

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
    assert agent.within(load_task({"horizon_s": 30.0})).task.horizon_s == 30.0


def test_a_network_survives_its_arrays() -> None:
    rng = np.random.default_rng(1)
    shapes = [(5, 7), (7, 3), (3, 2)]
    network = Network(
        tuple(rng.random(shape, dtype=np.float32) for shape in shapes),
        tuple(rng.random(shape[1], dtype=np.float32) for shape in shapes),
        "elu",
    )
    seen = some_observations(4, 5)
    np.testing.assert_array_equal(Network.of_arrays(network.arrays(), "elu")(seen), network(seen))
