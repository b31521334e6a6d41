"""Every field of the task and of the scenario changes what happens; new ones must be added. Contract test 13."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from ssmash_gym.envs import load_scenario, load_task
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.motions import IrregularMotion
from ssmash_gym.envs.scenario import ScenarioConfig
from ssmash_gym.envs.seaways import SeawayMotions
from ssmash_gym.envs.task import TaskConfig
from ssmash_gym.envs.winds import FreeWind, SeaWind
from ssmash_gym.vehicle import load_helicopter

# A short way to a near goal, which is reached and held in time; every term and limit has something to say.
TASK: dict[str, Any] = {
    "horizon_s": 1.2,
    "grace_s": 0.2,
    "lead_in": {"duration_s": 0.6, "ramp_s": 0.6},
    "track": {"goal_x_m": 0.1},
    "goal": {"hold_s": 0.2},
    "reward": {"soft_limit_kN": 0.1},
}
SEA = {
    "type": "irregular",
    "severity": 1.0,
    "levels": [1.0, 2.0],
    "sway": {"rms": [0.01, 0.02], "period_s": [8.0, 9.0]},
    "roll": {"rms": [0.3, 0.6], "period_s": [9.0, 10.0]},
}
SCENARIO: dict[str, Any] = {"base": "flat", "motion": SEA, "start": {"yaw_deg": 0.4, "lateral_m": 0.03}}
SEAWAY: dict[str, Any] = {
    "base": "flat",
    "motion": {"type": "seaway", "hs_m": 1.0, "heading_deg": 70.0, "speed_kn": 10.0, "components": 24},
    "wind": {"type": "sea", "gust_intensity": 0.1},
}

HELICOPTER = load_helicopter("generic_tricycle")  # read once
Change = tuple[Any, dict[str, Any]]  # the other value, and what must be so for it to matter
TASK_CHANGES: dict[str, Change] = {
    "control_interval_s": (0.2, {}),
    "substep_s": (0.001, {}),
    "horizon_s": (0.8, {}),
    "grace_s": (0.4, {}),
    "track.start_x_m": (0.01, {}),
    "track.goal_x_m": (0.12, {}),
    "lead_in.duration_s": (0.8, {}),
    "lead_in.ramp_s": (0.3, {}),
    "goal.x_tolerance_m": (0.001, {}),
    "goal.y_tolerance_m": (0.001, {}),
    "goal.yaw_tolerance_deg": (0.01, {}),
    "goal.hold_s": (0.4, {}),
    "claw.speed_along_m_s": (0.2, {}),
    "claw.speed_across_m_s": (0.05, {}),
    "claw.acceleration_m_s2": (0.2, {}),
    "claw.x_min_m": (-0.01, {"action": (-1.0, 0.0)}),
    "claw.x_max_m": (0.1, {"action": (1.0, 0.0), "goal.hold_s": 1.0}),
    "claw.y_travel_m": (0.05, {"action": (0.0, 1.0)}),
    "claw.height_m": (0.05, {}),
    "claw.delay_s": (0.0, {}),
    "claw.ripple_along_m": (0.001, {}),
    "claw.ripple_across_m": (0.001, {}),
    "claw.ripple_hz": (2.0, {"claw.ripple_along_m": 0.001}),
    "wheels": ("braked", {}),
    "limits.probe_in_plane_kN": (10.0, {}),
    "limits.main_vertical_kN": (80.0, {}),
    "limits.lift_off_kN": (3.0, {}),
    "limits.roll_deg": (20.0, {}),
    "limits.probe_ultimate_kN": (0.001, {}),
    "corridor.half_width_m": (2.5, {}),
    "corridor.door_half_width_m": (2.2, {"corridor.door_claw_x_m": -1.0}),
    "corridor.door_claw_x_m": (0.0, {}),
    "reward.progress_per_m": (2.0, {}),
    "reward.alignment": (1.0, {}),
    "reward.alignment_yaw_deg": (5.0, {}),
    "reward.alignment_lateral_m": (0.2, {}),
    "reward.alignment_range_m": (2.0, {}),
    "reward.load_per_s": (0.4, {}),
    "reward.soft_limit_kN": (0.2, {}),
    "reward.load_linear_from": (0.1, {}),
    "reward.peak": (2.0, {}),
    "reward.command_change": (0.02, {}),
    "reward.time_per_s": (0.2, {}),
    "reward.time_free_s": (0.5, {}),
    "reward.success": (5.0, {}),
    "reward.failure": (20.0, {"limits.probe_ultimate_kN": 0.001}),
    "observation": ("full", {}),
    "observation_clip": (0.5, {}),
    "history": ({"terms": ["deck_fy"], "samples": 2, "every_s": 0.1}, {}),
    "residual": ({"baseline": "trapezoid", "along": 0.5, "across": 0.5}, {}),
    "models.contact": ("centre", {}),
    "models.friction": ("independent", {"wheels": "braked", "scenario": {"helicopter": {"friction_factor": 0.02}}}),
    "models.probe_law": ("ellipse", {}),
}
SCENARIO_CHANGES: dict[str, Change] = {
    "start.yaw_deg": (0.5, {}),
    "start.lateral_m": (0.02, {}),
    "start.sink_rate_m_s": (1.0, {}),
    "wind.speed_mps": (10.0, {}),
    "wind.from_deg": (90.0, {"wind.speed_mps": 10.0}),
    "wind.ship_speed_mps": (5.0, {}),
    "wind.gust_intensity": (0.2, {"wind.speed_mps": 10.0}),
    "helicopter.mass_factor": (1.05, {}),
    "helicopter.cg_x_m": (0.05, {}),
    "helicopter.cg_y_m": (0.05, {}),
    "helicopter.cg_z_m": (0.05, {}),
    "helicopter.friction_factor": (0.02, {"task": {"wheels": "braked"}}),
    "helicopter.pressure_factor": (1.05, {}),
    "claw.delay_s": (0.2, {}),
    "claw.ripple_along_m": (0.001, {}),
    "claw.ripple_across_m": (0.001, {}),
    "claw.ripple_phase_deg": (90.0, {"claw.ripple_along_m": 0.001}),
    "claw.y_travel_m": (0.03, {"start.lateral_m": -0.03}),
    "claw.speed_across_m_s": (0.01, {}),
    "sensors.noise": (1.0, {}),
    "sensors.delay_s": (0.1, {}),
    "motion.type": ("fixed", {}),
    "motion.heel_deg": (1.0, {}),
    "motion.trim_deg": (1.0, {}),
    "motion.severity": (2.0, {}),
    "motion.levels": ([0.0, 3.0], {}),
    "motion.components": (64, {}),
    **{f"motion.{dof}": ({"rms": [0.1, 0.1], "period_s": [8.0, 8.0]}, {}) for dof in ("surge", "sway", "heave")},
    **{f"motion.{dof}": ({"rms": [0.5, 0.5], "period_s": [8.0, 8.0]}, {}) for dof in ("roll", "pitch", "yaw")},
}


SEAWAY_CHANGES: dict[str, Change] = {
    "motion.type": ("fixed", {}),
    "motion.ship": ("destroyer", {}),
    "motion.sea_state": (4, {"motion.hs_m": None}),
    "motion.hs_m": (1.2, {}),
    "motion.tp_s": (9.0, {}),
    "motion.tp_factor": (1.1, {}),
    "motion.lateral_g": (0.05, {"motion.hs_m": {"uniform": [0.5, 4.0]}}),
    "motion.spectrum": ("jonswap", {}),
    "motion.gamma": (2.0, {"motion.spectrum": "jonswap"}),
    "motion.spreading": ("long_crested", {}),
    "motion.heading_deg": (-70.0, {}),
    "motion.speed_kn": (12.0, {"wind.type": "free"}),
    "motion.roll_damping_factor": (1.2, {}),
    "motion.gm_factor": (1.1, {}),
    **{f"motion.deck_shift_{axis}_m": (1.0, {}) for axis in "xyz"},
    "motion.heel_deg": (1.0, {}),
    "motion.trim_deg": (1.0, {}),
    "motion.components": (32, {}),
    "wind.type": ("free", {}),
    "wind.speed_factor": (1.2, {}),
    "wind.from_waves_deg": (20.0, {}),
    "wind.gust_intensity": (0.2, {}),
}


def leaves(model: type[BaseModel], path: str = "") -> Iterator[str]:
    """Dotted paths of all fields but the descriptions; motion and wind as of a scenario without a seaway."""
    for name, field in model.model_fields.items():
        part = field.annotation
        if name == "motion":
            yield from (f"motion.{key}" for key in IrregularMotion.model_fields)
        elif name == "wind":
            yield from (f"wind.{key}" for key in FreeWind.model_fields if key != "type")
        elif isinstance(part, type) and issubclass(part, BaseModel):
            yield from leaves(part, f"{path}{name}.")
        elif name != "description":
            yield f"{path}{name}"


def nested(path: str, value: Any) -> dict[str, Any]:
    for key in reversed(path.split(".")):
        value = {key: value}
    return value


def laid_over(base: dict[str, Any], *changes: dict[str, Any]) -> dict[str, Any]:
    result = dict(base)
    for change in changes:
        for key, value in change.items():
            both = isinstance(value, dict) and isinstance(result.get(key), dict)
            result[key] = laid_over(result[key], value) if both else value
    return result


def told(task: dict[str, Any], scenario: dict[str, Any], action: tuple[float, float] = (0.5, -0.5)) -> list[Any]:
    """All that an episode says, apart from the draw and what follows from it without a helicopter."""
    env = TraverseBatch(1, task=task, scenario=scenario, helicopter=HELICOPTER)
    said: list[Any] = [env.reset(seeds=[3]).tolist()]
    k = 0
    while not env.book.over[0]:
        step = env.step([np.array(action) * (1.0 if k % 2 else 0.8)])
        said.append((step.observation.tolist(), float(step.reward[0]), step.info(0)))
        k += 1
    metrics = said[-1][2]["episode_metrics"]
    for name in [name for name in metrics if name.startswith("sea_") or name == "within_validity"]:
        del metrics[name]
    return said


@pytest.fixture(scope="module")
def reference() -> list[Any]:
    return told(TASK, SCENARIO)


def test_the_reference_succeeds(reference: list[Any]) -> None:
    assert reference[-1][2]["reason"] == "goal"
    assert told(TASK, SCENARIO) == reference


def test_every_field_is_listed() -> None:
    assert set(TASK_CHANGES) == set(leaves(TaskConfig))
    assert set(SCENARIO_CHANGES) == set(leaves(ScenarioConfig))
    fields = [f"motion.{key}" for key in SeawayMotions.model_fields] + [f"wind.{key}" for key in SeaWind.model_fields]
    assert set(SEAWAY_CHANGES) == set(fields)


@pytest.mark.parametrize("path", TASK_CHANGES)
def test_field_of_the_task(path: str, reference: list[Any]) -> None:
    value, needs = TASK_CHANGES[path]
    needs = dict(needs)
    action = needs.pop("action", (0.5, -0.5))
    scenario = laid_over(SCENARIO, needs.pop("scenario", {}))
    task = laid_over(TASK, *(nested(key, other) for key, other in needs.items()))
    before = (
        reference if task == TASK and scenario == SCENARIO and action == (0.5, -0.5) else told(task, scenario, action)
    )
    assert told(laid_over(task, nested(path, value)), scenario, action) != before


@pytest.mark.parametrize("path", SCENARIO_CHANGES)
def test_field_of_the_scenario(path: str, reference: list[Any]) -> None:
    value, needs = SCENARIO_CHANGES[path]
    needs = dict(needs)
    task = laid_over(TASK, needs.pop("task", {}))
    scenario = laid_over(SCENARIO, *(nested(key, other) for key, other in needs.items()))
    before = reference if task == TASK and scenario == SCENARIO else told(task, scenario)
    changed = (
        {**scenario, "motion": {"type": value}} if path == "motion.type" else laid_over(scenario, nested(path, value))
    )
    assert told(task, changed) != before


@pytest.fixture(scope="module")
def in_a_seaway() -> list[Any]:
    return told(TASK, SEAWAY)


@pytest.mark.parametrize("path", SEAWAY_CHANGES)
def test_field_of_a_seaway_and_its_wind(path: str, in_a_seaway: list[Any]) -> None:
    value, needs = SEAWAY_CHANGES[path]
    scenario = laid_over(SEAWAY, *(nested(key, other) for key, other in needs.items()))
    if path == "motion.type":
        scenario["motion"], scenario["wind"] = {"type": value}, {"type": "free"}
        assert told(TASK, scenario) != in_a_seaway
        return
    changed = laid_over(scenario, nested(path, value))
    before = in_a_seaway if path == "motion.sea_state" or scenario == SEAWAY else told(TASK, scenario)
    assert told(TASK, changed) != before


def test_defaults_and_files_agree() -> None:
    """The claw's numbers stand in the task's file and, for a bare batch, in `ClawLimits`: they must be the same."""
    from ssmash_gym.simulation.claw import ClawLimits

    assert load_task().claw == ClawLimits()
    assert load_scenario().motion.type == "seaway"
