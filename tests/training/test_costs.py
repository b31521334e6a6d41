"""Costs: what is taken off the reward, and how the multipliers follow the limits."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from ssmash_gym.training.algorithms import layer, make_environment
from ssmash_gym.training.checkpoint import checkpoints
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.costs import Priced
from ssmash_gym.training.run import learn
from ssmash_gym.training.sections import Cost

QUIET = Console(quiet=True)


def priced_document(settings: TrainingConfig, costs: dict[str, Any]) -> TrainingConfig:
    """The smoke training with short episodes, a limit that is always exceeded, and costs."""
    document = settings.model_dump() | {"costs": costs}
    document["environment"]["task"] |= {"horizon_s": 2.0, "limits": {"probe_in_plane_kN": 0.001}, "grace_s": 0.0}
    return load_training(document)


def stepped(environment: Any, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Rewards and dones of constant commands, (steps, n)."""
    environment.reset()
    found = [environment.step(np.full((environment.num_envs, 2), 0.5))[1:3] for _ in range(steps)]
    return np.array([reward for reward, _ in found]), np.array([done for _, done in found])


def test_a_fixed_weight_takes_the_cost_off_the_reward(settings: TrainingConfig) -> None:
    plain, priced = (
        make_environment(priced_document(settings, costs))
        for costs in ({}, {"probe_in_plane": {"weight": 0.25}, "roll": {"weight": 3.0}})
    )
    bare, _ = stepped(plain.venv, 15)
    less, dones = stepped(priced.venv, 15)
    expected = np.full_like(bare, 0.25)  # beyond one limit nearly all the time, never beyond the other
    starts = np.concatenate([np.ones((1, 4), bool), dones[:-1]])
    expected[starts] = 0.0  # the claw has not begun to pull
    np.testing.assert_allclose(bare - less, expected, atol=1e-5)


def test_an_episode_is_counted_whole_and_one_that_was_cut_short_is_not(settings: TrainingConfig) -> None:
    environment = make_environment(priced_document(settings, {"probe_in_plane": {}}))
    _, dones = stepped(environment, 45)
    priced = layer(environment, Priced)
    assert [costs.tolist() for costs in priced.finished] == [[19.0]] * len(priced.finished)
    assert dones.sum() == 4 - 1 + len(priced.finished)  # the last helicopter's first episode is not cut


def test_multipliers_rise_above_the_limit_fall_below_it_and_stay_in_bounds(settings: TrainingConfig) -> None:
    environment = make_environment(priced_document(settings, {"probe_in_plane": {}}))
    staggered = layer(environment, Priced).venv
    cost = Cost(limit_per_episode=3.0, weight=0.5, rate=0.1, proportional=0.05, largest=1.0)
    priced = Priced(staggered, {"probe_in_plane": cost, "roll": Cost(weight=0.2)})
    assert priced.multipliers.tolist() == [0.5, 0.2]
    seen = []
    for found in (5.0, 3.0, 1.0, 40.0, 0.0, 0.0, 0.0, 0.0, 0.0):
        priced.finished = [np.array([found - 1.0, 7.0]), np.array([found + 1.0, 7.0])]
        priced.update()
        seen.append(priced.multipliers.tolist())
    assert [one for one, _ in seen] == pytest.approx([0.8, 0.7, 0.4, 1.0, 0.55, 0.25, 0.0, 0.0, 0.0])
    assert {fixed for _, fixed in seen} == {0.2}
    before = priced.multipliers.copy()
    priced.update()  # no episode has ended
    np.testing.assert_array_equal(priced.multipliers, before)


def test_a_run_logs_them_and_a_resumed_one_goes_on_with_them(settings: TrainingConfig, tmp_path: Path) -> None:
    costs = {"probe_in_plane": {"limit_per_episode": 2.0, "rate": 0.01, "proportional": 0.002}}
    priced = priced_document(settings, costs)
    run, again = tmp_path / "run", tmp_path / "again"
    assert learn(priced, run, QUIET)
    with (run / "curve.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["cost_probe_in_plane"]) for line in lines] == [19.0] * 3
    assert [float(line["multiplier_probe_in_plane"]) for line in lines] == pytest.approx([0.0, 0.204, 0.374])
    shutil.copytree(run, again)
    for path in checkpoints(again)[1:]:
        shutil.rmtree(path)
    assert learn(priced, again, QUIET, resumed=True)
    for name in ("policy.npz", "normaliser.json"):
        assert (again / "agent" / name).read_bytes() == (run / "agent" / name).read_bytes()
    plain = tmp_path / "plain"
    assert learn(priced_document(settings, {}), plain, QUIET)
    assert (plain / "agent" / "policy.npz").read_bytes() != (run / "agent" / "policy.npz").read_bytes()
