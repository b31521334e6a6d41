"""Evolution: policies are judged by the environment's own episodes, and a stopped evolution loses nothing."""

from __future__ import annotations

import itertools
import pickle
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import ssmash_gym
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.training import evolution
from ssmash_gym.training.agent import Agent, load_agent
from ssmash_gym.training.checkpoint import checkpoints
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.evolution import (
    CURVE,
    STATE,
    Arena,
    Arenas,
    Metrics,
    Verdict,
    evolve,
    judged,
    numbers,
    with_numbers,
)
from ssmash_gym.training.network import Network, policy_network
from ssmash_gym.training.run import learn
from ssmash_gym.training.sections import Evolution, Judgement
from ssmash_gym.training.seeds import EVALUATION, EVOLUTION, TRAINING, TUNING, block, generation_seed

SMALL = Evolution(generations=3, population=4, episodes=3, sets=2, turn=1, unseen=3, substep_s=0.005, scenario="ss3")
EPISODE = {"reason": "goal", "success": True, "peak_probe_kN": 8.0, "final_yaw_deg": 0.5, "time_s": 43.0}


@pytest.fixture(scope="module")
def agent(finished: Path) -> Agent:
    return load_agent(finished / "agent")


def row(agent: Agent, seed: int) -> np.ndarray:
    """Numbers near the agent's own."""
    return numbers(agent.network) + np.random.default_rng(seed).normal(0.0, 0.3, numbers(agent.network).size)


def evolved(agent: Agent, run: Path, section: Evolution = SMALL, stop_after: int = 99) -> np.ndarray | None:
    stop = threading.Event()

    def tell(generation: int, verdict: object) -> None:
        if generation >= stop_after:
            stop.set()

    outcome = evolve(agent, section, run, 1, stop, tell)
    return None if outcome is None else numbers(outcome.network)


def test_the_last_layer_goes_into_a_row_and_back(agent: Agent) -> None:
    again = with_numbers(agent.network, numbers(agent.network))
    for one, other in zip(again.weights + again.biases, agent.network.weights + agent.network.biases, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_candidate_drives_the_episodes_that_an_evaluation_of_it_would(agent: Agent) -> None:
    scenario, seeds = load_scenario("ss3"), block(0, EVOLUTION, 3)
    networks = [with_numbers(agent.network, row(agent, k)) for k in range(2)]
    for network, found in zip(networks, Arena(agent, scenario, seeds, 2).episodes(networks), strict=True):
        expected = run_episodes(replace(agent, network=network), scenario, seeds)
        assert [e["peak_probe_kN"] for e in found] == expected["peak_probe_kN"].to_list()
        assert [e["time_s"] for e in found] == expected["time_s"].to_list()


def test_candidates_in_several_lots_drive_as_they_do_together(agent: Agent, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario, seeds = load_scenario("ss3"), block(0, EVOLUTION, 2)
    networks = [with_numbers(agent.network, row(agent, k)) for k in range(5)]
    together = Arena(agent, scenario, seeds, 1, 5)
    monkeypatch.setattr(evolution, "TOGETHER", 5)
    lots = Arena(agent, scenario, seeds, 1, 5)
    assert (together.copies, lots.copies) == (5, 2)  # two full lots, and one with a copy that stays where it is
    expected = together.episodes(networks)
    assert lots.episodes(networks) == expected
    assert len({str(found) for found in expected}) == 5


def test_the_score_by_hand() -> None:
    rule = Judgement(power=1.0, tail=0.5, success=1.0, success_kN=10.0, yaw_deg=0.5, yaw_kN_per_deg=2.0)
    lost = EPISODE | {"reason": "overload", "success": False, "peak_probe_kN": 70.0, "final_yaw_deg": -9.0}
    verdict = judged([EPISODE, lost], rule, ultimate_kN=75.0)
    assert verdict.peak_mean_kN == pytest.approx(41.5)
    tail = 8.0 + 0.95 * 67.0
    assert verdict.peak_p95_kN == pytest.approx(tail)
    assert verdict.score_kN == pytest.approx(41.5 + 0.5 * tail + 10.0 * 0.5 + 2.0 * 0.5 * 3.5)


def test_being_slow_costs_beyond_the_time_that_is_allowed() -> None:
    rule = Judgement(time_s=40.0, time_kN_per_s=1.0)
    fast, slow = (judged([EPISODE | {"time_s": time}], rule, 75.0).score_kN for time in (39.0, 43.0))
    assert slow - fast == pytest.approx(3.0)


def test_two_generations_draw_different_candidates_and_neighbouring_seeds_too() -> None:
    drawn = {generation_seed(seed, generation) for seed in range(5) for generation in range(40)}
    assert len(drawn) == 200


def test_an_evolution_that_is_stopped_after_any_generation_goes_on_as_if_it_had_not_been(
    agent: Agent, tmp_path: Path
) -> None:
    longer = SMALL.model_copy(update={"generations": 5})
    whole = tmp_path / "whole"
    kept = evolved(agent, whole, longer)
    for stop_after in (1, 2, 3):
        parts = tmp_path / f"stopped_{stop_after}"
        assert evolved(agent, parts, longer, stop_after) is None
        np.testing.assert_array_equal(evolved(agent, parts, longer), kept)
        lines = [(run / CURVE).read_text().splitlines() for run in (whole, parts)]
        assert [line.rsplit(",", 1)[0] for line in lines[0]] == [line.rsplit(",", 1)[0] for line in lines[1]]
        assert len(lines[1]) == 6


def test_an_evolution_of_other_settings_is_not_gone_on_with(agent: Agent, tmp_path: Path) -> None:
    assert evolved(agent, tmp_path, stop_after=1) is None
    with pytest.raises(ConfigurationError, match="another policy, of other seas or settings") as refusal:
        evolved(agent, tmp_path, SMALL.model_copy(update={"spread": 0.5}))
    assert "\n" not in str(refusal.value)


def test_whatever_decides_the_result_is_part_of_the_key(agent: Agent, monkeypatch: pytest.MonkeyPatch) -> None:
    network, normaliser = agent.network, agent.normaliser
    others = [
        replace(agent, network=with_numbers(network, row(agent, 0))),
        replace(agent, network=replace(network, activation="relu")),
        replace(agent, network=replace(network, squash=True)),
        replace(agent, normaliser=replace(normaliser, clip=2.0)),
        replace(agent, normaliser=replace(normaliser, observation=None)),
    ]
    key = Arenas(agent, SMALL, 1).key
    assert Arenas(agent, SMALL.model_copy(update={"generations": 9}), 2).key == key
    keys = [key, *(Arenas(other, SMALL, 1).key for other in others)]
    monkeypatch.setattr(ssmash_gym, "__version__", "0.0.0")
    assert len({*keys, Arenas(agent, SMALL, 1).key}) == 7


@pytest.mark.parametrize(
    ("change", "told"),
    [({"scenario": "ss9"}, "ss9"), ({"scenario": {"start": {"yaw": 1.0}}}, "yaw"), ({"substep_s": 0.03}, "step")],
)
def test_a_mistake_in_the_evolution_is_told_before_the_gradient(
    settings: TrainingConfig, tmp_path: Path, change: dict[str, object], told: str
) -> None:
    wrong = SMALL.model_dump(mode="json") | change
    settings = load_training(settings.model_dump(mode="json") | {"evolution": wrong})
    with pytest.raises(ConfigurationError, match=f"evolution.*{told}"):
        learn(settings, tmp_path / "run", Console(quiet=True))
    assert not (tmp_path / "run").exists()


def test_a_result_that_is_worse_in_unseen_seas_is_not_kept(agent: Agent, tmp_path: Path) -> None:
    wild = SMALL.model_copy(update={"generations": 1, "spread": 50.0})
    np.testing.assert_array_equal(evolved(agent, tmp_path, wild), numbers(agent.network))


def test_a_broken_state_is_told(agent: Agent, tmp_path: Path) -> None:
    (tmp_path / STATE).write_bytes(b"none")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        evolved(agent, tmp_path)


KEPT = SMALL.model_copy(update={"unseen": 2})  # another number of seas than a generation's: see `always_better`


@pytest.fixture
def always_better(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the unseen seas of `KEPT` what is judged second, the evolved network, does better."""
    scores = itertools.cycle((2.0, 1.0))

    def verdict(episodes: Sequence[Metrics], *rule: Any) -> Verdict:
        found = judged(episodes, *rule)
        return replace(found, score_kN=next(scores)) if len(episodes) == KEPT.unseen else found

    monkeypatch.setattr(evolution, "judged", verdict)


def last_mean(run: Path) -> np.ndarray:
    """The last layer's numbers to which an evolution has come."""
    return np.asarray(pickle.loads((run / STATE).read_bytes()).search.mean, dtype=np.float32)


def assert_evolved(run: Path) -> None:
    """The run's agent has the evolved last layer and the checkpoint's other layers, as plain numbers and as a model."""
    from stable_baselines3 import PPO

    left, agent = load_agent(checkpoints(run)[-1]).network, load_agent(run / "agent")
    model = PPO.load(run / "agent" / "policy.zip", device="cpu")
    for network in (agent.network, policy_network(model.policy)):
        np.testing.assert_array_equal(numbers(network), last_mean(run))
        assert np.all(numbers(network) != numbers(left))
        for one, other in zip(
            network.weights[:-1] + network.biases[:-1], left.weights[:-1] + left.biases[:-1], strict=True
        ):
            np.testing.assert_array_equal(one, other)
    assert agent.about["evolution"]["kept"]
    seen = np.random.default_rng(0).normal(0.0, 1.0, (5, agent.network.sizes[0])).astype(np.float32)
    expected, _ = model.predict(agent.normaliser(seen), deterministic=True)
    np.testing.assert_allclose(agent.act(seen), expected, atol=1e-6)


@pytest.mark.usefixtures("always_better")
def test_a_run_ends_with_the_evolved_agent_in_all_its_forms(settings: TrainingConfig, tmp_path: Path) -> None:
    settings = load_training(settings.model_dump(mode="json") | {"evolution": KEPT.model_dump(mode="json")})
    assert learn(settings, tmp_path / "run", Console(quiet=True))
    assert_evolved(tmp_path / "run")


@pytest.mark.usefixtures("always_better")
def test_a_run_that_is_stopped_between_gradient_and_end_is_resumed_to_the_same_agent(
    settings: TrainingConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes = {
        "evolution": KEPT.model_dump(mode="json"),
        "stages": [{"from_step": 300, "reward": {"load_per_s": 0.7}}],
    }
    settings = load_training(settings.model_dump(mode="json") | changes)
    stop = threading.Event()
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    assert learn(settings, whole, Console(quiet=True))
    take = Arena.episodes

    def stopping(arena: Arena, networks: Sequence[Network]) -> list[list[Metrics]]:
        stop.set()  # asked for while the first generation runs
        return take(arena, networks)

    with monkeypatch.context() as patched:
        patched.setattr(Arena, "episodes", stopping)
        assert not learn(settings, parts, Console(quiet=True), stop=stop)
    assert len((parts / CURVE).read_text().splitlines()) == 2
    assert learn(settings, parts, Console(quiet=True), resumed=True)
    for run in (whole, parts):
        assert_evolved(run)
    one, other = (load_agent(run / "agent") for run in (whole, parts))
    np.testing.assert_array_equal(numbers(one.network), numbers(other.network))
    assert one.task == other.task
    assert one.task.reward.load_per_s == 0.7  # the last stage's
    assert one.about["evolution"] == other.about["evolution"]


def test_seeds_of_the_purposes_never_meet() -> None:
    blocks = [set(block(0, purpose, 500)) for purpose in (TRAINING, EVALUATION, TUNING, EVOLUTION)]
    assert len(set.union(*blocks)) == 2000


def test_the_linear_algebra_runs_on_one_thread_whatever_is_allowed() -> None:
    """On two threads an eigenvalue of 130 numbers has other last bits, and the third generation other candidates."""
    from threadpoolctl import threadpool_info, threadpool_limits

    with threadpool_limits(2, user_api="blas"), evolution._one_thread():
        threads = [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]
    assert threads and set(threads) == {1}
