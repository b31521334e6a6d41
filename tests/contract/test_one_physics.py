"""Single, native batch, Gymnasium's own vector environments and SB3 are the same bits. Contract tests 3-7, 15."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from tests.contract.kinds import Kind

SEEDS = [5, 90, 7]
STEPS = 17  # three episodes of five steps and a little more, one reset step each in NEXT_STEP mode


def make_single(env_id: str, arguments: dict[str, Any]) -> gym.Env[Any, Any]:
    return gym.make(env_id, **arguments)


def actions(n: int = len(SEEDS)) -> Iterator[np.ndarray]:
    rng = np.random.default_rng(1)
    for _ in range(STEPS):
        yield rng.uniform(-1.0, 1.0, (n, 2)).astype(np.float32)


def rollout(envs: Any, seeds: list[int], disabled: bool = False) -> list[Any]:
    """Everything that a vector environment says over three episodes."""
    said: list[Any] = [envs.reset(seed=seeds)]
    for action in actions():
        step = envs.step(action[: len(seeds)])
        said.append(step)
        over = step[2] | step[3]
        if disabled and over.any():
            said.append(envs.reset(options={"reset_mask": over}))
    envs.close()
    return said


def same(a: Any, b: Any, path: str = "") -> None:
    """Exact equality of nested arrays, mappings and tuples."""
    assert type(a) is type(b), path
    if isinstance(a, dict):
        assert a.keys() == b.keys(), f"{path}: {a.keys() ^ b.keys()}"
        for key in a:
            same(a[key], b[key], f"{path}.{key}")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), path
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            same(x, y, f"{path}[{k}]")
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype and a.shape == b.shape, path
        if a.dtype == object:
            same(list(a), list(b), path)
        else:
            assert np.array_equal(a, b), f"{path}: {a} {b}"
    else:
        assert a == b, path


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_native_batch_is_gymnasiums_sync(kind: Kind, short: dict[str, Any], mode: AutoresetMode) -> None:
    native = kind.batch(len(SEEDS), autoreset_mode=mode, **short)
    sync = gym.vector.SyncVectorEnv([lambda: make_single(kind.id, short)] * len(SEEDS), autoreset_mode=mode)
    assert native.metadata["autoreset_mode"] == mode and kind.batch.metadata is not native.metadata
    off = mode == AutoresetMode.DISABLED
    same(rollout(native, SEEDS, off), rollout(sync, SEEDS, off))


def test_async_in_spawned_processes(env_id: str, short: dict[str, Any]) -> None:
    def maker() -> gym.Env[Any, Any]:
        return make_single(env_id, short)

    native = gym.make_vec(env_id, num_envs=2, **short)
    parallel = gym.vector.AsyncVectorEnv([maker] * 2, context="spawn")
    same(rollout(native, SEEDS[:2]), rollout(parallel, SEEDS[:2]))


def sb3_rollout(envs: Any) -> list[Any]:
    envs._seeds = list(SEEDS[: envs.num_envs])
    said: list[Any] = [envs.reset(), list(envs.reset_infos)]
    for action in actions():
        observation, reward, done, infos = envs.step(action[: envs.num_envs])
        ends = [
            {k: v for k, v in info.items() if k != "episode"} if d else None
            for info, d in zip(infos, done, strict=True)
        ]
        said.append((observation, np.asarray(reward, np.float32), done, [info["cost"] for info in infos], ends))
    envs.close()
    return said


@pytest.mark.parametrize("their", ["DummyVecEnv", "SubprocVecEnv"])
def test_sb3_adapter_is_sb3s_own(env_id: str, short: dict[str, Any], told: dict[str, Any], their: str) -> None:
    vec_env = pytest.importorskip("stable_baselines3.common.vec_env")
    from ssmash_gym.envs.sb3 import TraverseVecEnv

    n = 2 if their == "SubprocVecEnv" else 3
    makers: list[Callable[[], gym.Env[Any, Any]]] = [lambda: make_single(env_id, short)] * n
    other = getattr(vec_env, their)(makers)
    same(sb3_rollout(TraverseVecEnv(n, **told)), sb3_rollout(other))


def test_batch_size_threads_and_neighbours_do_not_matter(kind: Kind, short: dict[str, Any]) -> None:
    """Episode k of a batch is the single environment's, whatever else is in the batch, also past autoresets."""
    seeds = [100 + k for k in range(10)]
    large = kind.batch(10, threads=2, autoreset_mode="SameStep", **short)
    observations = [large.reset(seed=seeds)[0]]
    rewards = []
    moves = [np.concatenate([a] * 4)[:10] for a in actions()]
    for move in moves:
        observation, reward, *_ = large.step(move)
        observations.append(observation), rewards.append(reward)
    for k in (0, 3, 9):
        env = kind.single(**short)
        assert np.array_equal(env.reset(seed=seeds[k])[0], observations[0][k])
        for i, move in enumerate(moves):
            observation, reward, terminated, truncated, _ = env.step(move[k])
            assert reward == rewards[i][k]
            if terminated or truncated:
                observation, _ = env.reset()
            assert np.array_equal(observation, observations[i + 1][k])


def test_reset_after_abuse_is_a_fresh_environment(kind: Kind, short: dict[str, Any]) -> None:
    used, fresh = kind.single(**short), kind.single(**short)
    used.reset(seed=1)
    used.core.batch.state[:12] = 3.0  # thrown off the deck
    for _ in range(5):
        if used.step(np.array([1.0, -1.0]))[2]:
            break
    same(used.reset(seed=2), fresh.reset(seed=2))
    for _ in range(3):
        same(used.step(np.array([0.5, 0.2])), fresh.step(np.array([0.5, 0.2])))


def test_reset_mask_resets_only_those(kind: Kind, short: dict[str, Any]) -> None:
    envs = kind.batch(4, autoreset_mode="Disabled", **short)
    envs.reset(seed=0)
    before, *_ = envs.step(np.full((4, 2), 0.3))
    state = envs.core.batch.state.copy()
    mask = np.array([False, True, False, True])
    after, infos = envs.reset(seed=[None, 50, None, 51], options={"reset_mask": mask})
    assert np.array_equal(after[~mask], before[~mask]) and np.array_equal(
        envs.core.batch.state[:, ~mask], state[:, ~mask]
    )
    assert infos["_draw"].tolist() == mask.tolist()
    assert np.array_equal(after[1], kind.single(**short).reset(seed=50)[0])
    for wrong, error in (([True] * 4, TypeError), (np.zeros(4, bool), ValueError), (np.ones(3, bool), ValueError)):
        with pytest.raises(error, match="reset_mask"):
            envs.reset(options={"reset_mask": wrong})


def test_nothing_returned_is_reused(kind: Kind, short: dict[str, Any]) -> None:
    envs = kind.batch(3, **short)
    kept = [envs.reset(seed=0)]
    copies = [np.copy(kept[0][0])]
    for action in actions():
        kept.append(envs.step(action))
        copies.append(np.copy(kept[-1][0]))
    arrays = [array for said in kept for array in _arrays(said)]
    ids = {id(array) for array in arrays}
    assert len(ids) == len(arrays)
    assert not any(np.shares_memory(a, envs.core.batch.telemetry.outputs) for a in arrays if a.dtype == np.float64)
    assert all(np.array_equal(said[0], copy) for said, copy in zip(kept, copies, strict=True))


def _arrays(said: Any) -> list[np.ndarray]:
    if isinstance(said, np.ndarray):
        return [said]
    parts = said.values() if isinstance(said, dict) else said if isinstance(said, tuple | list) else ()
    return [array for part in parts for array in _arrays(part)]


def test_seed_lists_of_the_wrong_length_are_refused(kind: Kind, short: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="one entry for each of 3"):
        kind.batch(3, **short).reset(seed=[1, 2])
