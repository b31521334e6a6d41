"""The scripted operator model: late, coarse, and blind to the load, it still brings the helicopter home."""

from __future__ import annotations

import numpy as np
import pytest
from ssmash_gym.agents.operator import SEEN, Operator, OperatorParameters, beyond

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import TERMS, chosen_terms
from ssmash_gym.envs.task import load_task

TASK = load_task("traverse")
NAMES = [term.name for term in chosen_terms(TASK.observation)]


def seen(**values: float) -> np.ndarray:
    """One observation with the named terms set to SI values, everything else 0."""
    found = np.zeros((1, len(NAMES)), dtype=np.float32)
    for name, value in values.items():
        found[0, NAMES.index(name)] = value / TERMS[name].scale
    return found


def lateral(policy: Operator, before: np.ndarray, after: np.ndarray, steps: int) -> np.ndarray:
    """Lateral speeds [m/s] while the view changes from one observation to another after the first."""
    policy.reset(1)
    given = [policy.act(before), *(policy.act(after) for _ in range(steps))]
    return np.array(given)[:, 0, 1] * TASK.claw.speed_across_m_s


def test_it_acts_after_its_delay_and_through_its_lag() -> None:
    number = OperatorParameters()
    speed = lateral(Operator(TASK), seen(to_go=4.0), seen(to_go=4.0, claw_y=0.1), 60)
    steps = round(number.delay_s / TASK.control_interval_s)
    np.testing.assert_array_equal(speed[: 1 + steps], 0.0)
    assert speed[1 + steps] < 0.0
    final = -number.lateral_per_s * (0.1 - number.lateral_band_m)
    assert speed[-1] == pytest.approx(final, rel=1e-3)
    assert abs(speed[1 + steps]) < 0.8 * abs(final)


def test_it_does_not_see_what_is_small_nor_the_load() -> None:
    assert not np.any(lateral(Operator(TASK), seen(to_go=4.0), seen(to_go=4.0, claw_y=0.02, yaw=0.008), 20))
    assert not np.any(lateral(Operator(TASK), seen(to_go=4.0), seen(to_go=4.0, probe_fy=3e4), 20))
    assert not any("probe" in name for name in SEEN)


def test_its_lateral_speed_is_limited() -> None:
    speed = lateral(Operator(TASK), seen(to_go=4.0), seen(to_go=4.0, claw_y=-0.3, yaw=-0.2), 60)
    assert np.max(speed) == pytest.approx(OperatorParameters().lateral_limit_m_s, rel=1e-3)


def test_a_dead_band_takes_away_the_same_on_either_side() -> None:
    np.testing.assert_allclose(beyond(np.array([-3.0, -0.5, 0.0, 0.5, 3.0]), 1.0), [-2.0, 0.0, 0.0, 0.0, 2.0])


def test_its_delay_rounds_to_control_intervals_and_is_never_none() -> None:
    quick = Operator(TASK, OperatorParameters(delay_s=0.0))
    speed = lateral(quick, seen(to_go=4.0), seen(to_go=4.0, claw_y=0.1), 3)
    assert speed[1] == 0.0
    assert speed[2] < 0.0


def test_it_brings_the_helicopter_to_the_goal_on_a_level_deck() -> None:
    batch = TraverseBatch(2, scenario={"base": "calm"})
    policy = Operator(batch.task)
    views = batch.reset(seeds=[3, 4])
    policy.reset(2)
    running = np.arange(2)
    endings = {}
    while running.size:
        result = batch.step(policy.act(views)[running], running)
        views[running] = result.observation
        endings |= result.endings
        running = running[~(result.terminated | result.truncated)]
    assert {ending["reason"] for ending in endings.values()} == {"goal"}
    assert all(43.0 < ending["episode_metrics"]["time_s"] < 50.0 for ending in endings.values())
