"""Behaviour cloning on a small scale: what it learns from, what it writes, and that it is the same each time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.agents import cloning
from ssmash_gym.envs.observations import observed_terms
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import find_agent
from ssmash_gym.evaluation.study_entrants import agent_entrants
from ssmash_gym.training.run import train
from ssmash_gym.trials import export, imitation
from ssmash_gym.trials.demonstrations import Demonstration
from ssmash_gym.trials.files import write_trial
from ssmash_gym.trials.imitation import Settings, fit, split
from tests.benchmark.recorded import drive, short

pytest.importorskip("torch")
SMALL = Settings(layers=(16,), epochs=40, batch_size=32, learning_rate=5e-3)
CALM_S = 4.0


def lesson(seed: int, slope: float = 0.5, steps: int = 200) -> Demonstration:
    """An episode whose commands follow from what is observed by a known law."""
    drawn = np.random.default_rng(seed).uniform(-1.0, 1.0, (steps + 1, 3)).astype(np.float32)
    commands = np.stack([slope * drawn[:-1, 0], 0.02 * drawn[:-1, 1]], axis=1).astype(np.float64)
    return Demonstration(drawn, commands, np.zeros(steps), False, True, seed, "scripted operator", {})


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trials")
    for seed in range(4):
        write_trial(folder / f"{seed}.parquet", drive(short(CALM_S), seed, participant="P01"))
    return folder


@pytest.fixture(scope="module")
def run(trials: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "clone"
    cloning.clone((trials,), out=folder, epochs=5, episodes=2, threads=1)
    return folder


def test_a_known_law_is_found_on_both_axes() -> None:
    """The small commands across count as much as the large ones along."""
    made = [lesson(seed) for seed in range(6)]
    found = fit(*split(made, SMALL), SMALL)
    for axis in imitation.AXES:
        explained = found.errors[axis]["explained"]
        assert explained is not None and explained > 0.97
    new = lesson(99)
    commands = found.network(found.normaliser(new.observations[:-1]))
    assert np.sqrt(np.mean((commands - new.actions) ** 2, axis=0)) == pytest.approx([0.0, 0.0], abs=0.05)
    assert found.best_epoch == min(found.curve, key=lambda line: line["validation"])["epoch"]


def test_the_same_seed_gives_the_same_bits_and_another_one_others() -> None:
    made = [lesson(seed) for seed in range(4)]
    few = Settings(layers=(8,), epochs=2)
    first, again, other = (fit(*split(made, one), one) for one in (few, few, Settings(layers=(8,), epochs=2, seed=1)))
    weights = [b"".join(w.tobytes() for w in one.network.weights) for one in (first, again, other)]
    assert weights[0] == weights[1] != weights[2]


def test_training_stops_when_the_validation_error_rises() -> None:
    """Commands that have nothing to do with what is observed cannot be learned: what is learned is noise."""
    noise = [
        Demonstration(
            one.observations, np.random.default_rng(k).normal(0.0, 0.3, one.actions.shape), one.rewards, False, True, k,
            "scripted operator", {},
        )
        for k, one in enumerate(lesson(seed, steps=40) for seed in range(4))
    ]  # fmt: skip
    settings = Settings(layers=(32,), epochs=300, patience=5, learning_rate=1e-2)
    found = fit(*split(noise, settings), settings)
    assert len(found.curve) == found.best_epoch + settings.patience < settings.epochs


def test_no_seed_is_on_both_sides_whoever_drove_it() -> None:
    made = [lesson(seed) for seed in (0, 1, 2, 3, 4, 0, 1, 2, 3, 4)]
    training, validation = split(made, Settings())
    assert len(validation) == 2 and len(training) == 8
    assert not {one.seed for one in training} & {one.seed for one in validation}
    with pytest.raises(ConfigurationError, match="one seed only"):
        split([lesson(0), lesson(0)], Settings())


def test_the_agent_is_one_like_any_other(run: Path) -> None:
    agent = find_agent(str(run))
    rows = [run_episodes(agent, agent.scenario, [5, 6], threads=threads).to_dicts() for threads in (1, 2)]
    assert rows[0] == rows[1]
    entrant = agent_entrants([str(run)])[0]
    assert (entrant.name, entrant.kind, entrant.training_seed) == ("clone", "agent", 0)
    assert entrant.make(short(CALM_S).task).task.history == agent.task.history  # in a benchmark as it was trained
    assert entrant.about["cloned_from"] == {"teachers": ["scripted operator"], "seeds": [0, 1, 2, 3]}
    card = (run / "agent" / "README.md").read_text()
    assert "behaviour cloning" in card and "scripted operator" in card and "PPO" not in card


def test_the_clone_does_not_see_its_own_commands_unless_it_is_asked_for(run: Path, trials: Path) -> None:
    seen = {term.name for term in observed_terms(find_agent(str(run)).task)}
    assert not seen & {*cloning.OWN_COMMANDS, *cloning.BESIDE}
    asked = {term.name for term in observed_terms(cloning.of_trials([trials], ()).task)}
    assert set(cloning.OWN_COMMANDS) < asked
    assert len(cloning.of_trials([trials], ()).made[0].observations[0]) == len(
        observed_terms(cloning.of_trials([trials], ()).task)
    )


def test_the_report_says_how_well_it_imitates(run: Path) -> None:
    report: dict[str, Any] = json.loads((run / "imitation.json").read_text())
    assert report["teachers"] == ["scripted operator"]
    assert list(report["unseen"]["drivers"]) == ["clone", "scripted operator"]
    assert not set(report["unseen"]["seeds"]) & set(range(4))
    assert report["episodes"] == {"training": 3, "validation": 1}
    assert report["steps"] == {"training": 120, "validation": 40}
    told = " ".join(cloning.sentences(report))
    assert "scripted operator in 2 unseen seas" in told and "participant" not in told


def test_lessons_from_a_dataset_are_those_of_the_trials(trials: Path, tmp_path: Path) -> None:
    pytest.importorskip("minari")
    pytest.importorskip("h5py")
    export.export((trials,), to="lessons-v0", folder=tmp_path)
    read = cloning.of_dataset("lessons-v0", tmp_path, cloning.OWN_COMMANDS)
    own = cloning.of_trials([trials], cloning.OWN_COMMANDS)
    assert read.condition.configuration == own.condition.configuration
    size = len(observed_terms(read.task))
    assert read.task.history is None
    for one, other in zip(read.made, own.made, strict=True):
        assert one.observations.tobytes() == np.ascontiguousarray(other.observations[:, :size]).tobytes()
        assert one.actions.tobytes() == other.actions.tobytes()
        assert (one.seed, one.author) == (other.seed, other.author)


def test_refusals(trials: Path, run: Path, tmp_path: Path) -> None:
    for given, words in (
        ({}, "name recorded trials"),
        ({"trials": trials, "from_minari": "a-v0"}, "name recorded trials"),
        ({"trials": trials, "epochs": 0}, "--epochs"),
        ({"trials": trials, "out": run}, "not empty"),
        ({"trials": trials, "name": "no name", "out": tmp_path / "out"}, "name"),
        ({"from_minari": "none-v0", "folder": tmp_path, "out": tmp_path / "out"}, "no dataset of this name"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            cloning.clone(**given)
    with pytest.raises(ConfigurationError, match="ssmash clone"):
        train(run / "agent" / "training.yaml", out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
