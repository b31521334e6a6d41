"""The training's configuration: what ships loads, changes keep their neighbours, mistakes cost one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from ssmash_gym.envs.loading import names
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.training.config import TrainingConfig, load_training
from ssmash_gym.training.seeds import EVALUATION, TRAINING, block


@pytest.mark.parametrize("name", names("training"))
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
    sections = [TrainingConfig, *(f.annotation for f in TrainingConfig.model_fields.values())]
    models = [model for model in sections if isinstance(model, type) and hasattr(model, "model_fields")]
    assert len(models) == 6
    for model in models[1:]:
        assert all(field.description for field in model.model_fields.values()), model


def test_blocks_of_seeds_never_meet() -> None:
    blocks = [set(block(seed, purpose, 500)) for seed in range(4) for purpose in (TRAINING, EVALUATION)]
    assert len(set().union(*blocks)) == sum(map(len, blocks)) == 4000
    assert block(3, TRAINING, 20)[:7] == block(3, TRAINING, 7)
