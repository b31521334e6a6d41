"""The core of the environment: actions, endings, divergence, metrics, copies. Contract tests 9, 11, 14."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import State
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.traverse import TraverseEnv
from ssmash_gym.vehicle import load_helicopter

HELICOPTER = load_helicopter("generic_tricycle")
SEA: dict[str, Any] = {"base": "training", "motion": {"hs_m": {"uniform": [0.5, 1.5]}, "components": 24}}  # short ramp
TASK: dict[str, Any] = {"horizon_s": 1.0, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}, "grace_s": 0.2}


def make(n: int = 1, scenario: Any = "flat", task: dict[str, Any] | None = None, **more: Any) -> TraverseBatch:
    return TraverseBatch(n, task={**TASK, **(task or {})}, scenario=scenario, helicopter=HELICOPTER, **more)


def test_actions_are_clipped_and_the_share_beyond_is_told() -> None:
    one, two = make(), make()
    one.reset(seeds=[0]), two.reset(seeds=[0])
    a, b = one.step([[3.0, -0.5]]), two.step([[1.0, -0.5]])
    assert np.array_equal(a.observation, b.observation)
    assert (a.saturation[0], b.saturation[0]) == (0.5, 0.0)


@pytest.mark.parametrize("wrong", [[[np.nan, 0.0]], [[0.0, np.inf]], [[0.0]], [0.0, 0.0]])
def test_wrong_actions_are_refused_and_change_nothing(wrong: Any) -> None:
    env = make()
    env.reset(seeds=[0])
    before = env.batch.state.copy()
    with pytest.raises(ValueError, match="action"):
        env.step(wrong)
    assert np.array_equal(env.batch.state, before) and env.book.steps[0] == 0


def test_a_short_traverse_succeeds() -> None:
    """The goal is reached, held, and ends the episode with its reason, bonus and metrics."""
    env = make(task={"horizon_s": 5.0, "track": {"goal_x_m": 0.2}, "goal": {"hold_s": 0.5}})
    env.reset(seeds=[0])
    returned = 0.0
    while not env.book.over[0]:
        to_go = 0.2 - env.telemetry["claw_x"][0]
        result = env.step([[np.clip(3.0 * to_go, -1.0, 1.0), 0.0]])
        returned += float(result.reward[0])
    info = result.info(0)
    assert result.terminated[0] and not result.truncated[0]
    assert info["reason"] == "goal" and info["success"] is True
    metrics = info["episode_metrics"]
    assert metrics["aligned"] is True and abs(metrics["final_to_go_m"]) < 0.05
    assert metrics["return"] == pytest.approx(returned)
    assert sum(info["reward_terms"].values()) == pytest.approx(result.reward[0])
    assert 0.0 < metrics["peak_probe_kN"] <= metrics["peak_probe_kN_no_grace"] < 15.0
    assert metrics["p95_probe_kN"] <= metrics["peak_probe_kN"]
    assert metrics["sea_hs_m"] is metrics["sea_heading_deg"] is metrics["sea_speed_kn"] is None  # a deck without a sea
    assert (metrics["sea_lateral_g"], metrics["sea_roll_deg"], metrics["within_validity"]) == (0.0, 0.0, True)
    assert json.loads(json.dumps(info, allow_nan=False)) == info


def test_peaks_are_taken_over_substeps() -> None:
    env = make(scenario={**SEA, "sensors": {"noise": 0.0, "delay_s": 0.0}})
    env.reset(seeds=[3])
    instants, intervals = [], []
    while not env.book.over[0]:
        result = env.step([[1.0, 0.0]])
        instants.append(env.telemetry["probe_in_plane"][0])
        intervals.append(env.telemetry.peak_max("probe_in_plane")[0])
    metrics = result.info(0)["episode_metrics"]
    assert metrics["peak_probe_kN_no_grace"] == pytest.approx(1e-3 * max(intervals))
    assert metrics["peak_probe_kN"] == pytest.approx(1e-3 * max(intervals[2:]))  # grace of two intervals
    assert np.all(np.array(intervals) >= instants) and np.any(np.array(intervals) > 1.05 * np.array(instants))


@pytest.mark.parametrize(
    ("reason", "task", "thrown"),
    [
        ("ultimate_load", {"limits": {"probe_ultimate_kN": 0.5}}, {}),
        ("overturning", {"limits": {"roll_deg": 0.5}}, {State.U10: 0.5}),
        ("corridor", {"corridor": {"half_width_m": 1.0}}, {}),
    ],
)
def test_failures_end_with_their_reason(reason: str, task: dict[str, Any], thrown: dict[int, float]) -> None:
    env = make(task=task)
    env.reset(seeds=[0])
    for row, value in thrown.items():
        env.batch.state[row] = value
    while not env.book.over[0]:
        result = env.step([[1.0, 0.0]])
    info = result.info(0)
    assert info["reason"] == reason and info["success"] is False
    assert result.terminated[0] and not result.truncated[0]
    assert info["reward_terms"]["failure"] == -15.0
    if reason in info["costs"]:
        assert info["costs"][reason] == 1.0 and info["cost"] >= 1.0


def test_not_a_number_ends_the_episode_is_told_and_written_down(tmp_path: Path) -> None:
    """Contract test 14: the others go on, nothing that is returned is infinite, a dump tells the state."""
    env = make(3, scenario="calm", dump_dir=tmp_path)
    env.reset(seeds=[0, 1, 2])
    for _ in range(3):
        env.step(np.full((3, 2), 0.2))
    env.batch.state[State.U9, 1] = np.nan
    result = env.step(np.full((3, 2), 0.2))
    assert result.terminated.tolist() == [False, True, False]
    info = result.info(1)
    assert info["reason"] == "divergence"
    told = info["divergence"]
    assert told["channel"] and 0.3 <= told["time_s"] <= 0.4
    dump = np.load(told["dump"])
    assert Path(told["dump"]).parent == tmp_path
    assert np.isnan(dump["state"]).any() and json.loads(str(dump["draw"])) == env.draws[1].to_dict()  # type: ignore[union-attr]
    assert np.isfinite(result.observation).all() and np.isfinite(result.reward).all()
    assert result.reward[1] == -15.0
    for table in (result.costs, result.margins, result.reward_terms):
        assert all(np.isfinite(values).all() for values in table.values())
    assert np.isfinite(env.reset([1])).all()
    assert not env.step(np.zeros((3, 2))).terminated.any()


def test_a_state_that_runs_away_is_caught() -> None:
    env = make()
    env.reset(seeds=[0])
    env.batch.state[State.U9] = 1e9
    while not env.book.over[0]:
        result = env.step([[0.0, 0.0]])
    assert np.isfinite(result.observation).all() and np.isfinite(result.reward).all()
    assert result.terminated[0] and result.info(0)["reason"] in ("divergence", "ultimate_load", "overturning")


def test_snapshot_and_restore_are_exact_past_the_next_reset() -> None:
    env = make(3, scenario=SEA)
    env.reset(seeds=[0, 1, 2])
    moves = np.random.default_rng(0).uniform(-1.0, 1.0, (14, 3, 2))
    for move in moves[:4]:
        env.step(move)
    kept = pickle.loads(pickle.dumps(env.snapshot()))

    def future() -> list[Any]:
        said = []
        for move in moves[4:]:
            result = env.step(move)
            said.append((result.observation, result.reward))
            if result.endings:
                said.append((env.reset(sorted(result.endings)), np.zeros(0)))
        return said

    first = future()
    env.restore(kept)
    for (a, b), (c, d) in zip(first, future(), strict=True):
        assert np.array_equal(a, c) and np.array_equal(b, d)


def test_forks_have_the_same_future() -> None:
    env = make(2, scenario=SEA)
    env.reset(seeds=[7, 8])
    env.step(np.full((2, 2), 0.3))
    copies = env.fork(2)
    a, b = env.step(np.full((2, 2), -0.4)), copies.step(np.full((4, 2), -0.4))
    assert np.array_equal(np.repeat(a.observation, 2, axis=0), b.observation)
    assert np.array_equal(np.repeat(a.reward, 2), b.reward)
    one = copies.step(np.linspace(-1.0, 1.0, 8).reshape(4, 2))
    assert not np.array_equal(one.observation[0], one.observation[1])
    assert np.array_equal(np.repeat(env.reset(), 2, axis=0), copies.reset())


def test_environment_copies_and_attributes() -> None:
    env = TraverseEnv(task=TASK, scenario=SEA, helicopter=HELICOPTER)
    env.reset(seed=1)
    kept = env.snapshot()
    first = env.step(np.array([0.5, 0.1]))
    forked = env.fork(2)
    env.restore(kept)
    assert np.array_equal(first[0], env.step(np.array([0.5, 0.1]))[0])
    after = env.step(np.array([0.1, 0.1]))[0]
    assert np.array_equal(forked.step(np.full((2, 2), 0.1))[0], np.stack([after, after]))
    assert env.unwrapped.control_interval_s == forked.control_interval_s == env.metadata["control_interval_s"] == 0.1
    assert env.unwrapped.telemetry["claw_x"].shape == (1,) and forked.telemetry["claw_x"].shape == (2,)
    assert env.metadata is not TraverseEnv.metadata


def test_a_draw_can_be_repeated() -> None:
    env = TraverseEnv(task=TASK, scenario=SEA, helicopter=HELICOPTER)
    observation, info = env.reset(seed=5)
    other = TraverseEnv(task=TASK, scenario=SEA, helicopter=HELICOPTER)
    again, told = other.reset(seed=77, options={"draw": json.loads(json.dumps(info["draw"]))})
    assert np.array_equal(observation, again) and told == info
    with pytest.raises(ValueError, match="drow"):
        other.reset(options={"drow": {}})


def test_seahawk_stands_too() -> None:
    """Another helicopter, with swing arms and a tail wheel, does the same task."""
    env = TraverseBatch(1, task=TASK, scenario="flat", helicopter="seahawk_like")
    env.reset(seeds=[0])
    result = env.step([[0.5, 0.0]])
    assert not result.terminated[0] and result.margins["lift_off"][0] > 0.0
    assert env.telemetry["probe_in_plane"][0] < 5e3


def test_learning_saving_and_evaluating_agree(tmp_path: Path) -> None:
    """Contract test 11: a saved agent with its normaliser gives the same returns, and evaluation leaves both alone."""
    sb3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

    from ssmash_gym.envs.sb3 import TraverseVecEnv

    def envs() -> Any:
        return VecMonitor(TraverseVecEnv(4, task=TASK, scenario=SEA, helicopter=HELICOPTER))

    training = VecNormalize(envs())
    model = sb3.PPO("MlpPolicy", training, n_steps=8, batch_size=16, n_epochs=1, seed=0, device="cpu")
    model.learn(64)
    model.save(tmp_path / "agent.zip")
    training.save(str(tmp_path / "normaliser.pkl"))
    returns = []
    for agent in (model, sb3.PPO.load(tmp_path / "agent.zip", device="cpu")):
        seen = VecNormalize.load(str(tmp_path / "normaliser.pkl"), envs())
        seen.training, seen.norm_reward = False, False
        mean = seen.obs_rms.mean.copy()
        seen.seed(9)
        returns.append(evaluate_policy(agent, seen, n_eval_episodes=6, return_episode_rewards=True))
        assert np.array_equal(seen.obs_rms.mean, mean)
    assert returns[0] == returns[1] and len(returns[0][0]) == 6


def test_the_refused_value_is_told_and_the_dump_holds_the_whole_call(tmp_path: Path) -> None:
    env = make(dump_dir=tmp_path)
    env.reset(seeds=[0])
    env.step([[0.5, 0.0]])
    env.batch.state[State.U9] = 1e9
    while not env.book.over[0]:
        result = env.step([[0.5, 0.0]])
    info = result.info(0)
    assert info["reason"] == "divergence"
    value = info["divergence"]["value"]
    held = env.batch.state[:60, 0]
    assert value == "nan" or (value not in held and abs(value) > 1e3)
    dump = np.load(info["divergence"]["dump"])
    assert np.count_nonzero(dump["commands"]) and dump["clock"] == env.batch.clocks[0]
    assert json.loads(str(dump["timing"]))["substep_s"] == env.task.substep_s
    assert np.array_equal(dump["modes"], env.batch.mode)
