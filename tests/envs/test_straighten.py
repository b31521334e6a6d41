"""`ssmash/Straighten-v0`: its task, its limits, and the scripted law that shows that it can be done."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from ssmash_gym.agents.straighten import AXLE_BEHIND_PROBE_M, WHEELBASE_M, Gains, Straighten

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import TERMS, chosen_terms
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.straighten import StraightenEnv, StraightenVectorEnv
from ssmash_gym.envs.task import TaskConfig, load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.vehicle import load_helicopter

TASK = load_task("straighten")
CALM = {"base": "calm", "start": {"yaw_deg": 0.0, "lateral_m": 0.0}}


def landed(landings: list[tuple[float, float]], task: TaskConfig = TASK) -> tuple[TraverseBatch, np.ndarray]:
    """Helicopters on a level deck at rest with the given yaw [deg] and lateral offset [m], and what is observed."""
    batch = TraverseBatch(len(landings), task=task, scenario=CALM)
    plain = batch.scenario.sample(np.random.default_rng(0))
    draws = [replace(plain, start_yaw_deg=yaw, start_lateral_m=y) for yaw, y in landings]
    return batch, batch.reset(seeds=list(range(len(landings))), draws=draws)


def driven(policy: Any, landings: list[tuple[float, float]]) -> tuple[list[dict[str, Any]], list[np.ndarray]]:
    """Metrics of the policy's episodes, and the claw's lateral places and the yaw of all at each instant, (2, n)."""
    batch, seen = landed(landings)
    policy.reset(len(landings))
    ends: dict[int, dict[str, Any]] = {}
    ways = []
    running = np.arange(len(landings))
    while running.size:
        result = batch.step(policy.act(seen)[running], running)
        seen[running] = result.observation
        ends |= {k: ending["episode_metrics"] for k, ending in result.endings.items()}
        ways.append(np.stack([batch.telemetry["claw_y"], batch.telemetry["yaw"]]))
        running = running[~(result.terminated | result.truncated)]
    return [ends[k] for k in range(len(landings))], ways


def observations(rows: int, **values: Any) -> np.ndarray:
    """Observations with the named terms set to SI values, everything else 0."""
    names = [term.name for term in chosen_terms(TASK.observation)]
    found = np.zeros((rows, len(names)), dtype=np.float32)
    for name, value in ({"auxiliary_steer_cos": 1.0} | values).items():
        found[:, names.index(name)] = np.asarray(value) / TERMS[name].scale
    return found


# --- the task ------------------------------------------------------------------------------------------------------


def test_the_id_has_its_own_task_and_scenario_and_mappings_change_those() -> None:
    env = gym.make("ssmash_gym:ssmash/Straighten-v0").unwrapped
    assert isinstance(env, StraightenEnv) and env.core.task == TASK
    assert env.core.scenario == load_scenario("straighten")
    changed = StraightenVectorEnv(2, task={"horizon_s": 20.0}, scenario={"start": {"yaw_deg": 12.0}})
    assert changed.core.task == TASK.model_copy(update={"horizon_s": 20.0})
    assert changed.core.scenario.motion == env.core.scenario.motion
    assert changed.core.scenario.bounds("start.yaw_deg") == (12.0, 12.0)
    traverse = StraightenEnv(task={"base": "traverse"})
    assert traverse.core.task == load_task("traverse")


def test_landings_reach_thirty_degrees_and_the_castor_is_free() -> None:
    assert load_scenario("straighten").bounds("start.yaw_deg") == (-30.0, 30.0)
    assert TASK.wheels == "rolling"
    assert landed([(0.0, 0.0)])[0].starter.helicopter.stations.auxiliary.steering == "free"


def test_the_goal_is_anywhere_on_the_track_and_so_is_the_reward_of_being_straight() -> None:
    for end in (TASK.claw.x_min_m, TASK.claw.x_max_m):
        distance = abs(end - TASK.track.goal_x_m)
        assert distance < TASK.goal.x_tolerance_m
        assert distance / TASK.reward.alignment_range_m < 0.01
    assert TASK.reward.progress_per_m == 0.0
    assert 3.0 * TASK.reward.alignment_yaw_deg >= 30.0  # the potential's clip lies beyond every landing


def test_who_stands_straight_already_has_only_to_stay() -> None:
    batch, _ = landed([(0.2, 0.01), (2.0, 0.01)])
    for _ in range(TASK.hold_steps):
        result = batch.step(np.zeros((2, 2)))
    assert result.terminated.tolist() == [True, False]
    assert result.endings[0]["reason"] == "goal"


def test_no_landing_and_no_place_of_the_claw_is_clipped_from_the_observation() -> None:
    clip = {name: TASK.observation_clip * TERMS[name].scale for name in ("yaw", "claw_x", "claw_y")}
    assert clip["yaw"] > np.deg2rad(40.0)
    assert clip["claw_y"] > TASK.claw.y_travel_m + 0.1 and clip["claw_x"] > TASK.claw.x_max_m


def test_the_corridor_has_room_for_every_landing_and_for_backing_up_but_has_an_end() -> None:
    batch, _ = landed([(30.0, 0.1), (30.0, -TASK.claw.y_travel_m), (55.0, TASK.claw.y_travel_m)])
    result = batch.step(np.zeros((3, 2)))
    reach = (1.0 - result.margins["corridor"]) * TASK.corridor.half_width_m
    assert reach[0] < 2.7 and reach[1] < 3.1
    assert result.terminated.tolist() == [False, False, True]
    assert result.endings[2]["reason"] == "corridor"


# --- the law -------------------------------------------------------------------------------------------------------


def test_the_law_knows_the_helicopters_lengths() -> None:
    stations = load_helicopter("generic_tricycle").stations
    wheel = stations.auxiliary.mount_m[0] + stations.auxiliary.droop_m[0]
    probe = load_helicopter("generic_tricycle").probe.mount_m[0]
    assert probe - stations.right.mount_m[0] == pytest.approx(AXLE_BEHIND_PROBE_M, abs=0.01)
    assert wheel - stations.right.mount_m[0] == pytest.approx(WHEELBASE_M, abs=0.01)


def test_the_law_straightens_from_either_side_alike_and_gently() -> None:
    """From +-30 deg with the offset that makes it worst and best, mirrored; a straight pull does not do it."""
    landings = [(30.0, 0.1), (-30.0, -0.1), (30.0, -0.1), (-30.0, 0.1), (4.0, 0.0), (-4.0, 0.0)]
    ends, ways = driven(Straighten(TASK), landings)
    assert all(end["success"] for end in ends)
    assert all(abs(end["final_yaw_deg"]) < 1.0 and abs(end["final_lateral_m"]) < 0.05 for end in ends)
    assert max(end["peak_probe_kN"] for end in ends) < TASK.limits.probe_in_plane_kN
    for one, other in ((0, 1), (2, 3), (4, 5)):
        assert ends[one]["time_s"] == pytest.approx(ends[other]["time_s"], abs=0.2)
        assert ends[one]["peak_probe_kN"] == pytest.approx(ends[other]["peak_probe_kN"], rel=0.01)
        steps = round(min(ends[one]["time_s"], ends[other]["time_s"]) / TASK.control_interval_s)
        way = np.array(ways[:steps])
        np.testing.assert_allclose(way[:, :, one], -way[:, :, other], atol=2e-3)


def test_a_straight_pull_along_the_whole_track_neither_straightens_nor_spares_the_probe() -> None:
    task = TASK.model_copy(update={"track": TASK.track.model_copy(update={"goal_x_m": TASK.claw.x_max_m})})
    (end,), _ = driven(make_baseline("trapezoid", task), [(30.0, 0.0)])
    assert not end["success"] and abs(end["final_yaw_deg"]) > 2.0
    assert end["peak_probe_kN"] > 3.0 * TASK.limits.probe_in_plane_kN


def test_the_plan_ends_on_the_line() -> None:
    """Integrates the chain of three that the plan stands on: with the plan renewed at each step it arrives."""
    law = Straighten(TASK, Gains(force_N=1e9, reserve_m=0.0, shortest_m=1e-3))
    force_per_rate = law.gains.force_per_rate_Nm2
    axle_y, heading, curvature, step = -0.9, 0.3, 0.0, 1e-3
    for k in range(3990):
        claw_y = axle_y + AXLE_BEHIND_PROBE_M * np.sin(heading)
        force = law.planned_force(*(np.array([x]) for x in (heading, claw_y, curvature, 4.0 - k * step)))[0]
        axle_y += step * heading
        heading += step * curvature
        curvature += step * force / force_per_rate
    assert abs(axle_y) < 2e-3 and abs(heading) < 5e-3


def test_the_planned_force_is_bounded_and_odd() -> None:
    law = Straighten(TASK)
    rng = np.random.default_rng(0)
    yaw, y, curvature = (rng.uniform(-a, a, 50) for a in (0.6, 0.6, 0.3))
    ahead = rng.uniform(0.0, 5.0, 50)
    force = law.planned_force(yaw, y, curvature, ahead)
    assert np.max(np.abs(force)) == law.gains.force_N
    np.testing.assert_array_equal(force, -law.planned_force(-yaw, -y, -curvature, ahead))


def test_the_claw_gives_way_to_a_load_that_is_not_planned() -> None:
    law = Straighten(TASK)
    law.reset(2)
    across = law.act(observations(2, claw_x=1.0, probe_fy=[6e3, -6e3]))[:, 1] * TASK.claw.speed_across_m_s
    np.testing.assert_allclose(across, law.gains.give_aft_m_s_per_N * np.array([-6e3, 6e3]), rtol=1e-4)


def test_a_crooked_one_backs_up_first_and_a_new_episode_forgets() -> None:
    law = Straighten(TASK)
    law.reset(2)
    crooked = observations(2, yaw=[0.5, 0.05], claw_y=0.0)
    for _ in range(10):
        along = law.act(crooked)[:, 0]
    assert along[0] < 0.0 < along[1]
    fresh = Straighten(TASK)
    fresh.reset(2)
    first = fresh.act(crooked[::-1])
    again = law.act(crooked[::-1], starts=np.array([True, True]))
    np.testing.assert_array_equal(first, again)
    for name in Straighten.MEMORY:
        assert getattr(law, name).shape == (2,)


def test_an_observation_without_what_the_law_reads_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="lacks the term 'claw_x'"):
        Straighten(load_task({"base": "straighten", "observation": ["yaw"]}))
