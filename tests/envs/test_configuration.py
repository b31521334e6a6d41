"""Tasks, scenarios and ranges: partial overrides keep their siblings, mistakes cost one sentence. Contract test 13."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict

from ssmash_gym.assets import asset_path
from ssmash_gym.envs import EpisodeDraw, load_scenario, load_task
from ssmash_gym.envs.loading import names
from ssmash_gym.envs.ranges import Range
from ssmash_gym.errors import ConfigurationError

CALM: dict[str, Any] = {"type": "free"}
IRREGULAR: dict[str, Any] = {"base": "irregular"}


class Holder(BaseModel):
    model_config = ConfigDict(frozen=True)
    r: Range


def parsed(written: Any) -> Any:
    return Holder.model_validate({"r": written}).r


def test_the_tasks_numbers() -> None:
    """The table of the task; grounds in docs/environments/traverse.md."""
    task = load_task()
    assert (task.control_interval_s, task.substep_s, task.horizon_s, task.grace_s) == (0.1, 0.002, 60.0, 1.0)
    assert (task.track.start_x_m, task.track.goal_x_m) == (0.0, 8.0)
    goal = task.goal
    assert (goal.x_tolerance_m, goal.y_tolerance_m, goal.yaw_tolerance_deg, goal.hold_s) == (0.05, 0.05, 1.0, 2.0)
    claw = task.claw
    assert (claw.speed_along_m_s, claw.speed_across_m_s, claw.acceleration_m_s2) == (0.3, 0.1, 0.3)
    assert (claw.y_travel_m, claw.delay_s) == (0.3, 0.1)
    limits = task.limits
    assert (limits.probe_in_plane_kN, limits.probe_ultimate_kN, task.reward.soft_limit_kN) == (15.0, 75.0, 6.0)
    assert (limits.main_vertical_kN, limits.lift_off_kN, limits.roll_deg) == (90.0, 2.0, 25.0)
    corridor = task.corridor
    assert (corridor.half_width_m, corridor.door_half_width_m, corridor.door_claw_x_m) == (2.6, 2.1, 6.0)
    assert (task.wheels, task.observation) == ("rolling", "sensors")
    scenario = load_scenario()
    assert scenario.bounds("start.yaw_deg") == (-8.0, 8.0) and scenario.bounds("start.lateral_m") == (-0.1, 0.1)
    assert scenario.bounds("claw.delay_s") == (0.0, 0.2)


def test_a_partial_override_keeps_its_siblings() -> None:
    task = load_task({"goal": {"hold_s": 1.0}, "claw": {"delay_s": 0.0}})
    plain = load_task()
    assert task.goal.hold_s == 1.0 and task.claw.delay_s == 0.0
    assert task.goal.model_copy(update={"hold_s": plain.goal.hold_s}) == plain.goal
    assert task.claw.model_copy(update={"delay_s": plain.claw.delay_s}) == plain.claw
    scenario = load_scenario({"base": "irregular", "motion": {"severity": 4.5}, "start": {"yaw_deg": 3.0}})
    assert scenario.bounds("start.yaw_deg") == (3.0, 3.0)
    assert scenario.start.lateral_m == load_scenario("irregular").start.lateral_m
    assert scenario.motion.roll == load_scenario("irregular").motion.roll  # type: ignore[union-attr]
    sea = load_scenario({"motion": {"speed_kn": 12.0, "spectrum": {"jonswap": 0.0}}}).motion
    assert sea.spectrum.possible == ["bretschneider"]  # type: ignore[union-attr]
    assert sea.hs_m == load_scenario().motion.hs_m  # type: ignore[union-attr]


def test_another_kind_of_motion_or_range_replaces_the_old_one() -> None:
    scenario = load_scenario(
        {"motion": {"type": "fixed", "heel_deg": 2.0}, "wind": CALM, "start": {"yaw_deg": {"choice": [-5, 5]}}}
    )
    assert (scenario.motion.type, scenario.wind.type) == ("fixed", "free")
    assert scenario.bounds("start.yaw_deg") == (-5.0, 5.0)


@pytest.mark.parametrize(
    ("load", "given", "words"),
    [
        (load_task, {"gaol": {}}, ["gaol", "goal"]),
        (load_task, {"goal": {"hold": 1.0}}, ["goal.hold", "hold_s"]),
        (load_task, {"horizon_s": -1.0}, ["horizon_s", "-1.0", "greater than 0"]),
        (load_task, {"horizon_s": 1.05}, ["horizon_s", "1.05", "0.1 s"]),
        (
            load_task,
            {"observation": "sensor"},
            ["observation is refused", "'sensor'", "give sensors, full, forecast, or"],
        ),
        (load_task, {"observation": 3}, ["observation is refused", "3 is no observation", "list of terms' names"]),
        (load_task, {"observation": ["roll", 3]}, ["observation is refused", "['roll', 3]"]),
        (load_task, {"wheels": "square"}, ["wheels", "square", "braked"]),
        (load_task, {"track": {"goal_x_m": 20.0}}, ["20.0", "8.0"]),
        (load_task, {"lead_in": {"ramp_s": 9.0}}, ["ramp_s", "9.0", "8.0"]),
        (load_task, "trverse", ["trverse", "traverse"]),
        (load_task, "missing.yaml", ["missing.yaml"]),
        (load_task, 3, ["3", "mapping"]),
        (load_scenario, {"sea": {}}, ["sea", "motion"]),
        (load_scenario, {"wind": {"type": "free", "speed_mps": "strong"}}, ["wind.speed_mps", "strong", "uniform"]),
        (load_scenario, {"wind": {"type": "free", "speed_mps": -3}}, ["wind.speed_mps", "-3", "60"]),
        (load_scenario, {"wind": {"speed_mps": 3}}, ["wind.speed_mps", "speed_factor"]),
        (load_scenario, {"wind": {"type": "storm"}}, ["wind", "storm", "sea"]),
        (load_scenario, {"wind": {"gust_intensity": 1.5}}, ["wind.gust_intensity", "1.5", "0 to 1"]),
        (load_scenario, {"base": "flat", "wind": {"gust_mps": 1.0}}, ["wind.gust_mps", "gust_intensity"]),
        (load_scenario, {"start": {"yaw_deg": {"uniform": [8, -8]}}}, ["start.yaw_deg", "8"]),
        (load_scenario, {**IRREGULAR, "motion": {"severity": 9}}, ["severity", "9", "6"]),
        (load_scenario, {**IRREGULAR, "motion": {"roll": {"rms": [1.0]}}}, ["roll.rms", "3"]),
        (load_scenario, {**IRREGULAR, "motion": {"rol": 1}}, ["motion.rol", "roll"]),
        (load_scenario, {"motion": {"type": "swell"}}, ["motion", "swell", "seaway"]),
        (load_scenario, {"motion": {"hs_m": -1}}, ["motion.hs_m", "-1", "11.5"]),
        (load_scenario, {"motion": {"hs_m": {"uniform": [0.1, 2.0]}}}, ["hs_m", "0.1", "0.3 to 5", "tp_s"]),
        (load_scenario, {"motion": {"hs_m": 5.0, "tp_factor": 0.5}}, ["hs_m", "tp_s", "too steep"]),
        (load_scenario, {"motion": {"tp_factor": 1.0, "tp_s": {"uniform": [5.0, 9.0]}}}, ["hs_m is 5", "tp_s 5"]),
        (load_scenario, {"motion": {"tp_s": 9.0}}, ["tp_s", "tp_factor", "leave one"]),
        (load_scenario, {"base": "ss5", "motion": {"tp_s": 9.0}}, ["tp_s", "sea_state"]),
        (load_scenario, {"base": "ss5", "motion": {"sea_state": 7}}, ["sea_state = 7", "2, 3, 4, 5, 6"]),
        (load_scenario, {"base": "ss5", "motion": {"hs_m": 2.0}}, ["hs_m", "sea_state: null", "not both"]),
        (load_scenario, {"base": "ss5", "motion": {"lateral_g": 0.05}}, ["range of hs_m", "sea_state: null"]),
        (load_scenario, {"motion": {"lateral_g": 0.05, "hs_m": 2.0}}, ["lateral_g", "range of hs_m"]),
        (load_scenario, {"motion": {"ship": 7}}, ["motion.ship", "7 is no ship", "mapping"]),
        (load_scenario, {"motion": {"ship": {"kg_m": float("inf")}}}, ["motion.ship", "finite"]),
        (load_scenario, {"motion": {"ship": {"deck_point_m": np.zeros(3)}}}, ["motion.ship", "ndarray"]),
        (load_scenario, {"motion": {"heading_deg": "north"}}, ["motion.heading_deg", "north", "uniform"]),
        (load_scenario, {"motion": {"heading_deg": float("nan")}}, ["motion.heading_deg", "nan"]),
        (load_scenario, {"motion": {"speed_kn": 30}}, ["motion.speed_kn", "30", "25"]),
        (load_scenario, {"motion": {"spectrum": "pierson"}}, ["motion.spectrum.pierson", "jonswap"]),
        (load_scenario, {"motion": {"spreading": {"cos2": 0.0, "long_crested": 0.0}}}, ["spreading", "above 0"]),
        (load_scenario, {"motion": {"spreading": {"cos2": -1.0}}}, ["motion.spreading.cos2", "-1.0"]),
        (load_scenario, {"motion": {"components": 3}}, ["motion.components", "3", "24"]),
        (load_scenario, {"motion": {"type": "fixed"}}, ["wind.type sea", "motion.type fixed", "free"]),
        (load_scenario, {"wind": {"type": "free", "ship_speed_mps": 5}}, ["wind.ship_speed_mps", "5", "speed_kn"]),
    ],
)
def test_a_mistake_costs_one_sentence(load: Any, given: Any, words: list[str]) -> None:
    with pytest.raises(ConfigurationError) as caught:
        load(given)
    text = str(caught.value)
    assert "\n" not in text and len(text) < 400
    for word in words:
        assert word in text, text


def test_every_file_is_accepted_and_says_what_it_is() -> None:
    assert set(names("scenarios")) >= {"training", "irregular", "ss3", "ss4", "ss5", "ss6", "calm", "flat"}
    for name in names("scenarios"):
        assert load_scenario(name).description
    for name in names("tasks"):
        assert load_task(name).description


def test_every_number_of_the_task_file_says_assumed_or_why() -> None:
    lines = asset_path("configs", "tasks", "traverse.yaml").read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("reward:"))  # told once for the whole section
    for line in lines[:start]:
        key, _, value = line.partition(":")
        if value.split("#")[0].strip().replace(".", "").replace("-", "").isdigit():
            assert "#" in line or key.strip().startswith("ripple"), line


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    document = yaml.safe_load(asset_path("configs", "scenarios", "calm.yaml").read_text())
    document["wind"] = {"speed_mps": {"normal": [5.0, 2.0], "within": [0.0, 10.0]}}
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(document))
    assert load_scenario(path).bounds("wind.speed_mps") == (0.0, 10.0)


@given(u=st.floats(0.0, 1.0, exclude_max=True))
def test_draws_stay_within_their_bounds(u: float) -> None:
    for written in (
        2.5,
        {"uniform": [-1.0, 4.0]},
        {"choice": [3.0, -2.0, 7.0]},
        {"normal": [1.0, 2.0], "within": [0.0, 6.0]},
    ):
        found = parsed(written)
        low, high = found.bounds
        assert low <= found.draw(u) <= high


def test_ranges_have_their_distributions() -> None:
    u = (np.arange(4000) + 0.5) / 4000
    normal = np.array([parsed({"normal": [1.0, 2.0], "within": [-3.0, 5.0]}).draw(x) for x in u])
    assert np.mean(normal) == pytest.approx(1.0, abs=0.01)
    assert np.std(normal) == pytest.approx(2.0 * 0.8796, rel=0.01)  # cut at two deviations
    uniform = np.array([parsed({"uniform": [0.0, 2.0]}).draw(x) for x in u])
    assert np.percentile(uniform, [10, 90]) == pytest.approx([0.2, 1.8], abs=0.01)
    choice = [parsed({"choice": [1.0, 2.0]}).draw(x) for x in u]
    assert choice.count(1.0) == choice.count(2.0)


def test_a_draw_is_a_plain_record() -> None:
    scenario = load_scenario()
    draw = scenario.sample(np.random.default_rng(3))
    record = json.loads(json.dumps(draw.to_dict()))
    assert EpisodeDraw.from_dict(record) == draw
    assert scenario.sample(np.random.default_rng(3)) == draw
    with pytest.raises(ConfigurationError, match="motion_seed is missing"):
        EpisodeDraw.from_dict({k: v for k, v in record.items() if k != "motion_seed"})
    with pytest.raises(ConfigurationError, match="extra is unknown"):
        EpisodeDraw.from_dict({**record, "extra": 1})


def test_scenarios_share_their_random_numbers() -> None:
    """Changing one range leaves all other draws as they are: comparisons are paired."""
    one = load_scenario().sample(np.random.default_rng(8)).to_dict()
    two = load_scenario({"start": {"yaw_deg": {"choice": [4, 5]}}}).sample(np.random.default_rng(8)).to_dict()
    assert {key for key in one if one[key] != two[key]} == {"start_yaw_deg"}
    base: dict[str, Any] = {"base": "irregular"}
    sea = load_scenario(base).sample(np.random.default_rng(8)).to_dict()
    calm = load_scenario({**base, "motion": {"type": "fixed"}}).sample(np.random.default_rng(8)).to_dict()
    assert {key for key in sea if sea[key] != calm[key]} == {"motion"}
    assert {key for key in one if one[key] != sea[key]} == {
        "motion", "wind_speed_mps", "wind_from_deg", "wind_ship_speed_mps", "wind_gust_intensity",
    }  # fmt: skip
    generator = np.random.default_rng(8)
    load_scenario("flat").sample(generator)
    other = np.random.default_rng(8)
    load_scenario().sample(other)
    assert generator.bit_generator.state == other.bit_generator.state


def test_severity_ties_the_degrees_of_freedom_together() -> None:
    still = {"scatter": 1.0, "period_scatter": 1.0}
    scenario = load_scenario({"base": "irregular", "motion": {dof: still for dof in ("roll", "heave")}})
    sections = [scenario.sample(np.random.default_rng(k)).motion for k in range(40)]
    roll = np.array([section["roll"]["rms_deg"] for section in sections])
    heave = np.array([section["heave"]["rms_m"] for section in sections])
    assert np.array_equal(np.argsort(roll), np.argsort(heave))
    assert 1.8 <= roll.min() < 2.4 and 3.8 < roll.max() <= 4.4
