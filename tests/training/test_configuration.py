"""The training's configuration: what ships loads, changes keep their neighbours, mistakes cost one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from ssmash_gym.envs.limits import LIMITS
from ssmash_gym.envs.loading import names
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training import sections, tuning_config
from ssmash_gym.training.config import TrainingConfig, load_training, undotted
from ssmash_gym.training.sections import Section
from ssmash_gym.training.seeds import EVALUATION, TRAINING, TUNING, block


@pytest.mark.parametrize("name", [name for name in names("training") if not name.startswith("tune")])
def test_what_ships_loads_and_reads_back_what_it_writes(name: str, tmp_path: Path) -> None:
    found = load_training(name)
    assert found.total_steps >= found.steps_per_update
    written = tmp_path / "training.yaml"
    written.write_text(yaml.safe_dump(found.model_dump(mode="json")))
    assert load_training(written) == found


def test_a_change_keeps_its_neighbours() -> None:
    base = load_training("smoke")
    found = load_training("smoke", ["ppo.learning_rate=1e-4", "ppo.epochs=7", "name=other"])
    assert (found.ppo.learning_rate, found.ppo.epochs, found.name) == (1e-4, 7, "other")
    unchanged = {"learning_rate", "epochs"}
    assert found.ppo.model_dump(exclude=unchanged) == base.ppo.model_dump(exclude=unchanged)
    assert found.network == base.network


def test_a_change_to_a_named_task_is_a_change_to_that_task() -> None:
    document = {"name": "x", "total_steps": 10, "ppo": {"steps_per_update": 32}, "environment": {"scenario": "calm"}}
    found = load_training(document, ["environment.scenario.start.yaw_deg=2.0"])
    assert found.environment.scenario == {"base": "calm", "start": {"yaw_deg": 2.0}}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        (["ppo.epoch=3"], "epoch"),
        (["ppo.epochs=0"], "ppo.epochs = 0"),
        (["ppo.gamma=1.5"], "ppo.gamma = 1.5"),
        (["ppo.batch_size=100"], "batch_size = 100"),
        (["network.activation=sigmoid"], "sigmoid"),
        (["network.initial_action=[2.0, 0.0]"], "-1 to 1"),
        (["name=../elsewhere"], "name"),
        (["total_steps"], "key=value"),
        (["=3"], "key=value"),
        (["ppo=3"], "ppo"),
        (["algorithm=ddpg"], "algorithm = 'ddpg'"),
        (["algorithm=sac", "sac.train_every=3"], "train_every = 3"),
        (["tqc.dropped=25"], "dropped = 25"),
        (["device=tpu"], "device = 'tpu'"),
        (["costs.probe={rate: 0.1}"], "costs.probe"),
        (["costs.roll={weight: 11.0}"], "weight = 11"),
    ],
)
def test_a_mistake_costs_one_sentence(changes: list[str], told: str) -> None:
    with pytest.raises(ConfigurationError) as refusal:
        load_training("smoke", changes)
    assert told in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(ConfigurationError, match="smoke"):
        load_training("no_such")


def test_every_field_says_what_it_is() -> None:
    found = [kind for module in (sections, tuning_config) for kind in vars(module).values() if isinstance(kind, type)]
    told = {kind for kind in found if issubclass(kind, Section) and kind is not TrainingConfig}
    assert len(told) >= 12
    for section in told:
        assert all(field.description for field in section.model_fields.values()), section


def test_what_can_be_priced_is_what_the_environment_tells() -> None:
    assert set(sections.LimitName.__args__) == set(LIMITS)


def test_stages_add_up_and_keep_what_they_do_not_name() -> None:
    changes = ["stages=[{from_step: 100, reward: {load_per_s: 0.5}}, {from_step: 300, reward: {time_per_s: 0.0}}]"]
    found, reward = load_training("smoke", changes), load_task().reward
    assert found.reward_at(99, reward) == reward
    assert found.reward_at(100, reward) == reward.model_copy(update={"load_per_s": 0.5})
    assert found.reward_at(300, reward) == reward.model_copy(update={"load_per_s": 0.5, "time_per_s": 0.0})


def test_stages_change_the_scenario_and_keep_its_siblings() -> None:
    stages = [
        {"from_step": 100, "scenario": {"motion.hs_m": {"uniform": [2.0, 3.0]}, "start.yaw_deg": 0.0}},
        {"from_step": 300, "scenario": {"start": {"yaw_deg": {"uniform": [-4.0, 4.0]}}}},
    ]
    found = load_training(load_training("smoke").model_dump() | {"stages": stages})
    first = load_scenario("training")
    assert found.scenario_at(99, first) == first
    second, third = found.scenario_at(100, first), found.scenario_at(300, first)
    assert second.bounds("motion.hs_m") == third.bounds("motion.hs_m") == (2.0, 3.0)
    assert (second.bounds("start.yaw_deg"), third.bounds("start.yaw_deg")) == ((0.0, 0.0), (-4.0, 4.0))
    assert third.bounds("start.lateral_m") == first.bounds("start.lateral_m")
    assert undotted({"a.b": 1, "a.c": {"d": 2}}) == {"a": {"b": 1, "c": {"d": 2}}}


def test_a_stage_that_is_refused_is_told() -> None:
    stage = "stages=[{from_step: 100, reward: {loads_per_s: 0.5}}]"
    with pytest.raises(ConfigurationError, match="loads_per_s"):
        load_training("smoke", [stage]).reward_at(200, load_task().reward)
    with pytest.raises(ConfigurationError, match="must rise"):
        load_training("smoke", ["stages=[{from_step: 100, reward: {}}, {from_step: 100, reward: {}}]"])


def test_blocks_of_seeds_never_meet() -> None:
    purposes = (TRAINING, EVALUATION, TUNING)
    blocks = [set(block(seed, purpose, 500)) for seed in range(4) for purpose in purposes]
    assert len(set().union(*blocks)) == sum(map(len, blocks)) == 6000
    assert block(3, TRAINING, 20)[:7] == block(3, TRAINING, 7)


def test_a_training_can_change_another_one(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("base: ppo_traverse\nname: mine\nppo: {epochs: 3}\nevolution: {episodes: 8}\n")
    mine, base = load_training(path), load_training("ppo_traverse")
    assert (mine.name, mine.ppo.epochs, mine.evolution.episodes) == ("mine", 3, 8)
    assert mine.ppo.learning_rate == base.ppo.learning_rate and mine.evolution.scenario == base.evolution.scenario
    path.write_text("base: quick_traverse\nname: mine\n")
    with pytest.raises(
        ConfigurationError, match="base = quick_traverse is refused: training quick_traverse has a base"
    ):
        load_training(path)
