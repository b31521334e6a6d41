"""Gymnasium's and Stable-Baselines3's own checkers, and the wrappers people use. Contract tests 1, 2, 8, 9, 10."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env

import ssmash_gym
from ssmash_gym.registration import ENTRY_POINTS, register_environments
from tests.contract.kinds import KINDS


def test_gymnasium_checker_has_nothing_to_say(env_id: str, short: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make(env_id, **short)
        check_env(env.unwrapped, skip_render_check=True)


def test_gymnasium_checker_renders(env_id: str, short: dict[str, Any]) -> None:
    pytest.importorskip("pygame")
    env = gym.make(env_id, render_mode="rgb_array", **short)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    frame = env.render()
    assert isinstance(frame, np.ndarray) and frame.dtype == np.uint8 and frame.ndim == 3 and frame.std() > 10.0
    env.close()
    env.close()


def test_sb3_checker_has_nothing_to_say(env_id: str, short: dict[str, Any]) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(gym.make(env_id, **short).unwrapped)


def test_two_instances_agree_exactly(env_id: str, short: dict[str, Any]) -> None:
    one, two = gym.make(env_id, **short), gym.make(env_id, **short)
    one.action_space.seed(4)
    for seed in (11, None, None):
        assert _same(one.reset(seed=seed), two.reset(seed=seed))
        over = False
        while not over:
            action = one.action_space.sample()
            a, b = one.step(action), two.step(action)
            assert _same(a, b)
            over = a[2] or a[3]


def _same(a: Any, b: Any) -> bool:
    """Exact equality, down to the type."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(_same(a[k], b[k]) for k in a)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    return bool(a == b)


def test_spec_survives_json_and_pickle(env_id: str, short: dict[str, Any]) -> None:
    env = gym.make(env_id, **short)
    assert env.spec is not None
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    unpickled = gym.make(pickle.loads(pickle.dumps(env.spec)))
    first = env.reset(seed=3)
    assert _same(first, again.reset(seed=3))
    assert _same(first, unpickled.reset(seed=3))
    assert json.loads(json.dumps(first[1])) == first[1]


def test_time_truncates_and_flags_are_python_bools(env_id: str, short: dict[str, Any]) -> None:
    env = gym.make(env_id, **short)
    env.reset(seed=0)
    for k in range(5):
        _, reward, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        assert type(terminated) is bool and type(truncated) is bool and type(reward) is float
        assert not terminated and truncated == (k == 4)
    assert info["reason"] == "time" and info["success"] is False
    with pytest.raises(RuntimeError, match="reset it first"):
        env.unwrapped.step(np.zeros(2, np.float32))


def test_a_gymnasium_time_limit_comes_on_top(env_id: str, short: dict[str, Any]) -> None:
    env = gym.make(env_id, max_episode_steps=2, **short)
    batch = gym.make_vec(env_id, num_envs=2, max_episode_steps=2, **short)
    env.reset(seed=0), batch.reset(seed=0)
    for k in range(2):
        truncated = env.step(np.zeros(2, np.float32))[3]
        truncations = batch.step(np.zeros((2, 2), np.float32))[3]
        assert truncated == (k == 1) and truncations.tolist() == [k == 1] * 2


def test_wrappers(env_id: str, short: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    pytest.importorskip("pygame")
    env = gym.make(env_id, render_mode="rgb_array", **short)
    env = gym.wrappers.RecordVideo(env, str(tmp_path / "video"), episode_trigger=lambda k: k == 0, disable_logger=True)
    env = gym.wrappers.RecordEpisodeStatistics(gym.wrappers.NormalizeObservation(env))
    env.reset(seed=0)
    total = 0.0
    for _ in range(5):
        _, reward, _, _, info = env.step(np.array([0.5, 0.0], np.float32))
        total += float(reward)
    env.close()
    assert info["episode"]["r"] == pytest.approx(total) and info["episode"]["l"] == 5
    assert info["episode_metrics"]["return"] == pytest.approx(total)
    assert len(list((tmp_path / "video").glob("*.mp4"))) == 1


def test_vector_wrappers(env_id: str, short: dict[str, Any]) -> None:
    envs = gym.wrappers.vector.RecordEpisodeStatistics(gym.make_vec(env_id, num_envs=3, **short))
    envs = gym.wrappers.vector.NormalizeObservation(envs)
    envs.reset(seed=0)
    for _ in range(5):
        observation, *_, infos = envs.step(np.zeros((3, 2), np.float32))
    assert infos["_episode"].all() and np.isfinite(observation).all()
    assert infos["episode"]["r"] == pytest.approx(infos["episode_metrics"]["return"])


def test_every_registered_id_is_under_contract() -> None:
    assert {kind.id for kind in KINDS} == {f"ssmash_gym:{name}" for name in ENTRY_POINTS}


def test_registration_twice_and_cheap_import() -> None:
    register_environments()
    for name in ENTRY_POINTS:
        assert gym.spec(name).vector_entry_point is not None
    code = (
        "import ssmash_gym, ssmash_gym.registration as r, sys; r.register_environments();"
        "print(sorted({'torch', 'numba', 'pygame', 'stable_baselines3', 'polars', 'matplotlib'} & set(sys.modules)))"
    )
    root = str(Path(ssmash_gym.__file__).parents[1])
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=True)
    assert found.stdout.strip() == "[]"
