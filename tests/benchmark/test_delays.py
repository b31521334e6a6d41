"""A matched delay delays the commands and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from ssmash_gym.benchmark.delays import delays_of, labelled, later
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.ranges import Choice, Normal, Uniform
from ssmash_gym.envs.scenario import Claw
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from tests.benchmark.recorded import short

SEED = 5


def driven(condition: Condition, commands: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Channels at the end of each control interval under given commands."""
    batch = TraverseBatch(
        1, task=condition.task, scenario=condition.scenario, helicopter=condition.helicopter, threads=1
    )
    batch.reset(seeds=[SEED])
    names = ("claw_x", "claw_y", "claw_vx", "probe_in_plane", "deck_roll")
    found: dict[str, list[float]] = {name: [] for name in names}
    for command in commands:
        batch.step(command[None])
        for name in names:
            found[name].append(float(batch.telemetry[name][0]))
    return {name: np.array(values) for name, values in found.items()}


def test_a_delay_of_one_control_interval_is_the_same_commands_one_interval_later() -> None:
    condition = short(scenario="ss5")
    assert condition.task.control_interval_s == 0.1
    commands = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 2))
    delayed = driven(later(condition, 100.0), commands)
    shifted = driven(condition, np.vstack([np.zeros((1, 2)), commands[:-1]]))
    at_once = driven(condition, commands)
    for name, values in delayed.items():
        assert values.tobytes() == shifted[name].tobytes(), name
    assert np.max(np.abs(delayed["claw_vx"] - at_once["claw_vx"])) > 0.01  # m/s


@pytest.mark.parametrize("name", ["ss5", "hard", "training"])
def test_a_seed_draws_the_same_episode_but_for_the_delay(name: str) -> None:
    condition = short(scenario=name)
    changed = later(condition, 50.0)
    for seed in range(5):
        before, after = (one.scenario.sample(np.random.default_rng(seed)).to_dict() for one in (condition, changed))
        own = before.pop("claw_delay_s")
        own_s = condition.task.claw.delay_s if own is None else own
        assert after.pop("claw_delay_s") == pytest.approx(own_s + 0.05, abs=1e-12)
        assert before == after


def test_every_kind_of_range_becomes_longer() -> None:
    condition = short()
    for kind, least, greatest in (
        (Uniform(uniform=(0.1, 0.2)), 0.3, 0.4),
        (Choice(choice=(0.1, 0.3)), 0.3, 0.5),
        (Normal(normal=(0.1, 0.02), within=(0.05, 0.2)), 0.25, 0.4),
    ):
        scenario = condition.scenario.model_copy(update={"claw": Claw(delay_s=kind)})
        own = Condition("own", "", condition.task, scenario, condition.helicopter)
        assert later(own, 200.0).scenario.bounds("claw.delay_s") == pytest.approx((least, greatest))
    assert later(condition, 0.0) is condition


@pytest.mark.parametrize("observation", ["sensors", "full", "forecast"])
def test_a_program_is_not_told_of_the_delay(observation: str) -> None:
    """At the start it observes the same, whatever the delay."""
    condition = short(scenario="ss5")
    found = []
    for one in (condition, later(condition, 200.0)):
        batch = TraverseBatch(2, task=one.task, scenario=one.scenario, observation=observation, threads=1)
        found.append(batch.reset(seeds=[SEED, SEED + 1]).tobytes())
    assert found[0] == found[1]


def test_delays_of_the_command_line() -> None:
    assert delays_of("100, 0,50,50", 0.002) == (0.0, 50.0, 100.0)
    assert [labelled("linear", delay) for delay in (0.0, 50.0)] == ["linear", "linear +50 ms"]
    for words in ("fast", "-50", "51.1", "", "nan", "5000"):
        with pytest.raises(ConfigurationError, match="--delays"):
            delays_of(words, 0.002)
