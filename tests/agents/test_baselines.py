"""Baselines: the trapezoid keeps to the book, yielding takes the load off, and all read named observation terms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.agents import baselines
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import TERMS, chosen_terms
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import make_baseline

TASK = load_task("traverse")


def observations(task: TaskConfig, **values: Any) -> np.ndarray:
    """Observations with the named terms set to SI values, everything else 0, one row a value."""
    names = [term.name for term in chosen_terms(task.observation)]
    rows = max(np.size(value) for value in values.values())
    found = np.zeros((rows, len(names)), dtype=np.float32)
    for name, value in values.items():
        found[:, names.index(name)] = np.asarray(value) / TERMS[name].scale
    return found


def commands(name: str, task: TaskConfig, seen: np.ndarray, steps: int) -> np.ndarray:
    """Commands of a policy that always sees the same, (steps, rows, 2)."""
    policy = make_baseline(name, task)
    policy.reset(seen.shape[0])
    return np.array([policy.act(seen) for _ in range(steps)])


@pytest.mark.parametrize("changes", [{}, {"control_interval_s": 0.2}, {"track": {"goal_x_m": 3.0}}])
def test_trapezoid_keeps_its_speed_and_acceleration_and_ends_at_the_goal(changes: dict[str, Any]) -> None:
    task = load_task(changes)
    dt = task.control_interval_s
    speed = commands("trapezoid", task, observations(task, claw_y=0.0), task.horizon_steps)[:, 0]
    along = speed[:, 0] * task.claw.speed_along_m_s
    assert np.all(along >= 0.0)
    assert np.max(along) == pytest.approx(0.2, abs=1e-6)
    assert np.max(np.abs(np.diff(along, prepend=0.0, append=0.0))) / dt <= 0.1 + 1e-5
    assert np.sum(along) * dt == pytest.approx(task.track.goal_x_m - task.track.start_x_m, abs=1e-4)
    moving = np.count_nonzero(along > 1e-9) * dt
    assert moving == pytest.approx((task.track.goal_x_m - task.track.start_x_m) / 0.2 + 2.0, abs=2 * dt)
    assert np.all(speed[:, 1] == 0.0)


def test_trapezoid_comes_onto_the_centre_line_and_rests_there() -> None:
    offsets = np.array([0.1, -0.07, 0.0])
    given = commands("trapezoid", TASK, observations(TASK, claw_y=offsets), TASK.horizon_steps)
    dt = TASK.control_interval_s
    way = np.cumsum(given * [TASK.claw.speed_along_m_s, TASK.claw.speed_across_m_s] * dt, axis=0)
    np.testing.assert_allclose(offsets + way[-1, :, 1], 0.0, atol=1e-5)
    resting = way[:-1, 0, 0] > 6.0
    np.testing.assert_allclose(given[1:][resting][:, :, 1], 0.0, atol=1e-6)
    across = given[:, :, 1] * TASK.claw.speed_across_m_s
    assert np.max(np.abs(np.diff(across, axis=0))) / dt < 0.1
    assert np.all(np.sign(way[:, 0, 1]) <= 0.0)
    assert np.all(np.sign(way[:, 1, 1]) >= 0.0)


def test_trapezoid_drives_the_claw_to_the_goal_in_the_simulation() -> None:
    batch = TraverseBatch(2, scenario={"base": "flat", "start": {"lateral_m": 0.1}})
    policy = make_baseline("trapezoid", batch.task)
    seen = batch.reset(seeds=[1, 2])
    policy.reset(2)
    peak_speed, over = 0.0, False
    while not over:
        result = batch.step(policy.act(seen))
        seen, over = result.observation, bool(result.terminated[0])
        peak_speed = max(peak_speed, float(batch.telemetry.peak_abs("claw_vx")[0]))
    assert result.endings[0]["reason"] == "goal"
    assert peak_speed == pytest.approx(0.2, abs=1e-3)
    assert batch.telemetry["claw_x"][0] == pytest.approx(8.0, abs=0.01)
    assert batch.telemetry["claw_y"][0] == pytest.approx(0.0, abs=0.005)


def test_a_row_that_starts_anew_does_what_a_fresh_policy_does() -> None:
    policy = make_baseline("trapezoid", TASK)
    policy.reset(2)
    seen = observations(TASK, claw_y=[0.05, 0.05])
    first = [policy.act(seen) for _ in range(60)]
    again = [policy.act(seen, np.array([False, k == 0])) for k in range(60)]
    np.testing.assert_array_equal([a[1] for a in again], [a[1] for a in first])
    assert np.any(again[30][0] != first[30][0])


def test_yielding_gives_way_to_the_load_and_goes_back_to_the_line() -> None:
    cases = {"probe_fy": [1e4, 0.0, 0.0], "claw_y": [0.0, 0.1, 0.0], "yaw": [0.0, 0.0, 0.1]}
    across = commands("yield", TASK, observations(TASK, **cases), 1)[0, :, 1] * TASK.claw.speed_across_m_s
    gains = (baselines.YIELD_M_S_PER_N, baselines.CENTRING_PER_S, baselines.STRAIGHTENING_M_S_PER_RAD)
    np.testing.assert_allclose(across, [-gains[0] * 1e4, -gains[1] * 0.1, -gains[2] * 0.1], rtol=1e-5)


def test_yielding_is_limited_to_what_can_be_commanded() -> None:
    given = commands("yield", TASK, observations(TASK, probe_fy=[5e4, -5e4], claw_y=[0.2, -0.2]), 1)[0]
    np.testing.assert_array_equal(given[:, 1], [-1.0, 1.0])


def test_yielding_drives_along_the_track_like_the_trapezoid() -> None:
    seen = observations(TASK, claw_y=0.05, probe_fy=2e3, yaw=0.05)
    along = [commands(name, TASK, seen, 100)[:, 0, 0] for name in ("trapezoid", "yield")]
    np.testing.assert_array_equal(*along)


def test_holding_commands_nothing() -> None:
    assert not np.any(commands("hold", TASK, observations(TASK, probe_fy=[1e4, -1e4]), 3))


@pytest.mark.parametrize("name", ["trapezoid", "yield"])
def test_commands_do_not_depend_on_where_the_terms_stand_in_the_observation(name: str) -> None:
    values = {"claw_y": 0.08, "probe_fy": 3e3, "yaw": -0.04}
    expected = commands(name, TASK, observations(TASK, **values), 20)
    for terms in ("full", ("yaw", "to_go", "probe_fy", "claw_y")):
        task = load_task({"observation": terms})
        np.testing.assert_array_equal(commands(name, task, observations(task, **values), 20), expected)


def test_an_observation_without_what_is_read_is_refused() -> None:
    task = load_task({"observation": ["claw_y", "yaw"]})
    with pytest.raises(ConfigurationError, match="probe_fy"):
        make_baseline("yield", task)
    make_baseline("trapezoid", task)


def test_yielding_takes_much_of_the_load_off_on_a_rough_deck() -> None:
    scenario = load_scenario("ss5")
    seeds = list(range(900, 912))
    peaks = {
        name: run_episodes(make_baseline(name, TASK), scenario, seeds)["scored_peak_kN"].to_numpy()
        for name in ("trapezoid", "yield")
    }
    assert np.mean(peaks["yield"]) < 0.75 * np.mean(peaks["trapezoid"])
    assert np.mean(peaks["yield"] < peaks["trapezoid"]) > 0.8
