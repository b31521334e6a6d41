"""Studies as files: what they name is resolved, what is wrong costs one sentence, everyone gets the same seas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ssmash_gym.envs.loading import names
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.evaluation.study import load_study
from ssmash_gym.evaluation.study_entrants import agent_entrants, scripted_entrant
from ssmash_gym.training.seeds import EVALUATION, TRAINING, TUNING, block
from ssmash_gym.vehicle import load_helicopter
from tests.evaluation.studies import short_study, untrained


@pytest.mark.parametrize("name", names("evaluation"))
def test_every_study_that_ships_names_what_exists(name: str) -> None:
    study = load_study(name)
    conditions = study.resolved()
    for condition, policy in study.plan():
        assert make_baseline(policy, conditions[condition].task).name == policy
    known = {*study.scripted}
    assert {study.roles.hold, study.roles.book, *study.roles.laws, *study.roles.speeds} <= known


def test_the_standard_study_is_what_was_asked_for() -> None:
    study = load_study("standard")
    conditions, plan = study.resolved(), study.plan(("agent",))
    for name, state in (("ss3", 3), ("ss4", 4), ("ss5", 5), ("ss6", 6)):
        motion: Any = conditions[name].scenario.motion
        assert motion.sea_state == state
        assert motion.heading_deg.bounds == (0.0, 360.0) and motion.speed_kn.bounds == (0.0, 20.0)
        assert plan[name, "agent"] == plan[name, "trapezoid"] == 500
    delays = {name: conditions[name].task.claw.delay_s for name in ("ss5_delay_0", "ss5", "ss5_delay_200")}
    assert delays == {"ss5_delay_0": 0.0, "ss5": 0.1, "ss5_delay_200": 0.2}
    assert all(conditions[name].scenario.claw.delay_s is None for name in delays)
    assert conditions["ss5"].scenario.start.yaw_deg.bounds == (-8.0, 8.0)
    assert conditions["ss5_straight"].scenario.start.yaw_deg.bounds == (0.0, 0.0)
    assert plan["ss5", "clairvoyant"] == plan["ss5_straight", "mppi"] == 200
    factors = {"mass_light": "mass_factor", "mass_heavy": "mass_factor", "deck_wet": "friction_factor"}
    found = {name: getattr(conditions[name].scenario.helicopter, key).bounds[0] for name, key in factors.items()}
    assert found == {"mass_light": 0.85, "mass_heavy": 1.15, "deck_wet": 0.5}
    assert conditions["noise_double"].scenario.sensors.noise.bounds == (1.0, 3.0)


def test_seas_are_an_evaluations_and_a_shorter_study_has_the_first_of_them() -> None:
    study = load_study("standard")
    assert study.seas == block(100000, EVALUATION, 500)
    assert not set(study.seas) & {*block(100000, TRAINING, 2000), *block(100000, TUNING, 2000)}
    assert study.narrowed(None, ("ss5",), 20).seas == study.seas[:20]


def test_a_condition_changes_the_helicopter_by_factors() -> None:
    soft = short_study().resolved()["soft"].helicopter.probe
    own = load_helicopter("generic_tricycle").probe
    assert soft.small_stiffness_x_Npm == 0.5 * own.small_stiffness_x_Npm
    assert soft.small_stiffness_y_Npm == own.small_stiffness_y_Npm


def test_words_about_a_condition_do_not_change_what_it_is() -> None:
    one, other = (
        short_study(conditions={"a": {"scenario": "ss5", "description": words}}, runs=[{"conditions": ["a"]}])
        for words in ("one", "other")
    )
    assert one.resolved()["a"].configuration == other.resolved()["a"].configuration
    assert one.resolved()["a"].configuration != short_study().resolved()["calm"].configuration


def test_two_runs_that_name_the_same_count_once_with_the_larger_number() -> None:
    runs = [
        {"conditions": ["calm", "soft"], "policies": ["hold"], "episodes": 2},
        {"conditions": ["calm"], "policies": ["hold", "yield"], "agents": True},
    ]
    plan = short_study(runs=runs).plan(("mine",))
    assert plan == {("calm", "hold"): 5, ("soft", "hold"): 2, ("calm", "yield"): 5, ("calm", "mine"): 5}


def test_a_study_can_be_run_in_part() -> None:
    part = short_study().narrowed(("hold",), ("soft",), 3)
    assert part.plan() == {("soft", "hold"): 3}
    for words in ((("tractor",), None, None), (None, ("ss7",), None)):
        with pytest.raises(ConfigurationError, match=r"there is no (policy 'tractor'|condition 'ss7') in it"):
            short_study().narrowed(*words)
    with pytest.raises(ConfigurationError, match="--episodes 6 is refused: the study has 5 seas"):
        short_study().narrowed(None, None, 6)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"seeds": 3}, "no key seeds"),
        ({"episodes": 0}, "episodes = 0"),
        ({"runs": [{"conditions": ["ss9"]}]}, "no condition 'ss9'"),
        ({"runs": [{"conditions": ["calm"], "episodes": 6}]}, "must be at most episodes = 5"),
        ({"runs": [{"conditions": ["calm"], "policies": ["a/b"]}]}, "runs.0.policies.0"),
        ({"targets": {"main": "ss9"}}, "targets.main: there is no condition 'ss9'"),
        ({"conditions": {"a": {"scenario": "ss5"}, "A": {"scenario": "ss6"}}}, "but for capitals"),
        ({"conditions": {"calm": {"scenario": "ss5", "wind": {}}}}, "no key conditions.calm.wind"),
    ],
)
def test_a_wrong_study_costs_one_sentence(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ConfigurationError, match="study") as refused:
        short_study(**changes)
    assert told in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("condition", "told"),
    [
        ({"scenario": "ss9"}, "ss9"),
        ({"scenario": "ss5", "task": {"clow": {}}}, "clow"),
        ({"scenario": "ss5", "helicopter": {"probe.colour": 1.0}}, "probe.colour"),
        ({"scenario": "ss5", "helicopter_factors": {"probe.colour": 0.5}}, "probe.colour"),
        ({"scenario": "ss5", "helicopter_factors": {"probe.active": 0.5}}, "probe.active"),
    ],
)
def test_a_condition_that_names_what_is_not_there_is_refused(condition: dict[str, Any], told: str) -> None:
    study = short_study(conditions={"a": condition}, runs=[{"conditions": ["a"]}])
    with pytest.raises(ConfigurationError, match=r"study: conditions\.a: ") as refused:
        study.resolved()
    assert told in str(refused.value)


@pytest.mark.usefixtures("agents_without_training")
def test_several_training_seeds_of_one_agent_share_a_name(tmp_path: Path) -> None:
    folders = [untrained(tmp_path / f"run{seed}", 0.5, seed) for seed in (0, 1)]
    found = agent_entrants([f"mine={folders[0]},{folders[1]}", str(untrained(tmp_path / "other", 0.1, 0, "other"))])
    assert [(one.name, one.training_seed, one.kind) for one in found] == [
        ("mine", 0, "agent"), ("mine", 1, "agent"), ("other", 0, "agent"),
    ]  # fmt: skip
    assert len({one.identity for one in found}) == 2  # the first two have the same weights
    with pytest.raises(ConfigurationError, match="mine of training seed 1 is named twice"):
        agent_entrants([f"mine={folders[1]}", f"mine={folders[1]}"])
    with pytest.raises(ConfigurationError, match="mine of training seed 1 is named twice"):
        agent_entrants([f"mine={folders[1]},{folders[1]}"])


def test_who_is_not_there_is_told() -> None:
    with pytest.raises(ConfigurationError, match="no agent 'nobody'"):
        agent_entrants(["mine=nobody"])
    task = short_study().resolved()["calm"].task
    with pytest.raises(ConfigurationError, match="no baseline 'tractor'"):
        scripted_entrant("tractor", task)


@pytest.mark.parametrize(
    ("name", "told"), [("trapezoid@fast", "a number"), ("trapezoid@0.5", "0.3 m/s"), ("hold@0.1", "no speed")]
)
def test_a_speed_that_cannot_be_driven_is_refused(name: str, told: str) -> None:
    with pytest.raises(ConfigurationError, match=told):
        make_baseline(name, short_study().resolved()["calm"].task)


def test_the_book_at_another_speed_takes_another_time() -> None:
    task = short_study().resolved()["calm"].task
    usual, slow = make_baseline("trapezoid@0.2", task), make_baseline("trapezoid@0.1", task)
    assert (usual.name, slow.name, make_baseline("trapezoid", task).name) == (
        "trapezoid@0.2", "trapezoid@0.1", "trapezoid",
    )  # fmt: skip
    travelled = [float(policy.travelled(20.0)) for policy in (usual, slow)]  # type: ignore[attr-defined]
    assert travelled == pytest.approx([0.2 * 20.0 - 0.2, 0.1 * 20.0 - 0.05])
