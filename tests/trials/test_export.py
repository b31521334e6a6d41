"""Trials and agents' episodes as Minari datasets: the same numbers come back, and the environment can be made again."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.trials import export as exporting
from ssmash_gym.trials.demonstrations import demonstration, perceived
from ssmash_gym.trials.files import read_trial, write_trial
from ssmash_gym.trials.trial import Trial
from tests.benchmark.recorded import drive, session, short

pytest.importorskip("minari")
pytest.importorskip("h5py")
SEEDS = (11, 12)


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("trials")
    for k, seed in enumerate(SEEDS):
        trial = drive(short(scenario="ss5"), seed, participant="P01", session=session(k + 1))
        write_trial(folder / f"{k}.parquet", trial)
    write_trial(folder / "broken.parquet", drive(short(scenario="ss5"), 13, steps=5, participant="P01"))
    return folder


@pytest.fixture(scope="module")
def root(trials: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("datasets")
    exporting.export((trials,), to="ssmash/p01-v0", folder=folder)
    return folder


def test_what_is_read_back_is_the_episode_bit_for_bit(trials: Path, root: Path) -> None:
    dataset = exporting.read_dataset("ssmash/p01-v0", root)
    assert dataset.total_episodes == len(SEEDS)  # without the one that was broken off
    for k, episode in enumerate(dataset.iterate_episodes()):
        trial = read_trial(trials / f"{k}.parquet")
        assert episode.actions.tobytes() == trial.commands.tobytes()
        assert episode.rewards.tobytes() == trial.table["reward"].to_numpy().tobytes()
        assert episode.terminations.tolist() == [False] * 30
        assert episode.truncations.tolist() == [False] * 29 + [True]
        made = demonstration(trial, perceived(trial.condition.task))
        assert episode.observations.dtype == np.float32
        assert episode.observations.tobytes() == made.observations.tobytes()


def test_a_relative_folder_is_one(trials: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exporting.export((trials,), to="ssmash/p01-v0", folder=Path("sets"))
    assert exporting.read_dataset("ssmash/p01-v0", Path("sets")).total_episodes == len(SEEDS)


def test_observations_are_those_that_a_policy_would_have_had(trials: Path) -> None:
    trial = read_trial(trials / "0.parquet")
    for observation in ("sensors", ("yaw", "to_go")):
        task = perceived(trial.condition.task, observation)
        batch = TraverseBatch(1, task=task, scenario=trial.condition.scenario)
        seen = [batch.reset(seeds=[trial.seed])[0].copy()]
        seen += [batch.step(command[None]).observation[0] for command in trial.commands]
        assert demonstration(trial, task).observations.tobytes() == np.stack(seen).tobytes()


def test_the_recovered_environment_repeats_an_episode(root: Path) -> None:
    dataset = exporting.read_dataset("ssmash/p01-v0", root)
    environment = dataset.recover_environment()
    episode = dataset[0]
    first, _ = environment.reset(seed=SEEDS[0])
    assert first.tobytes() == episode.observations[0].tobytes()
    for k, action in enumerate(episode.actions):
        observation, reward, terminated, truncated, _ = environment.step(action)
        assert observation.tobytes() == episode.observations[k + 1].tobytes()
        assert (reward, terminated, truncated) == (
            episode.rewards[k], episode.terminations[k], episode.truncations[k],
        )  # fmt: skip
    assert dataset.observation_space == environment.observation_space


def test_who_drove_is_told_and_a_script_is_no_participant(root: Path) -> None:
    dataset = exporting.read_dataset("ssmash/p01-v0", root)
    metadata = dataset.storage.metadata
    assert metadata["algorithm_name"] == "scripted operator"
    assert list(metadata["author"]) == ["scripted operator"]
    assert "code_permalink" not in metadata
    assert "participant" not in str(metadata)
    told = list(dataset.storage.get_episode_metadata(range(2)))
    assert [one["seed"] for one in told] == list(SEEDS)
    assert {one["author"] for one in told} == {"scripted operator"}


@pytest.mark.parametrize(
    ("about", "wanted"),
    [
        ({"driver": "person", "origin": "page", "participant": "P01"}, "participant P01"),
        ({"driver": "person", "origin": "script", "participant": "P01"}, "scripted driver person"),
        ({"driver": "linear", "participant": "P01"}, "scripted driver linear"),
    ],
)
def test_authors(about: dict[str, Any], wanted: str) -> None:
    trial = drive(short(0.5), 1, **about)
    assert demonstration(trial, perceived(trial.condition.task)).author == wanted


def test_episodes_of_a_policy_and_of_an_agent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ssmash_gym.envs.task import load_task

    monkeypatch.setattr(exporting, "load_task", lambda name: load_task({"base": name, "horizon_s": 1.0}))
    exporting.export(to="linear-v0", folder=tmp_path, policy="linear", scenario="calm", episodes=2)
    exporting.export(to="ppo-v3", folder=tmp_path, agent="ppo_traverse", episodes=1, observation="yaw, to_go")
    linear, ppo = (exporting.read_dataset(name, tmp_path) for name in ("linear-v0", "ppo-v3"))
    assert linear.storage.metadata["algorithm_name"] == "scripted policy linear"
    assert ppo.storage.metadata["algorithm_name"] == "agent ppo_traverse"
    assert [linear.total_steps, ppo.total_steps] == [20, 10]
    assert ppo.observation_space.shape == (2,)


def test_refusals_write_nothing(trials: Path, root: Path, tmp_path: Path) -> None:
    mixed = tmp_path / "mixed"
    for k, horizon_s in enumerate((0.5, 1.0)):
        write_trial(mixed / f"{k}.parquet", drive(short(horizon_s), 1))
    good = read_trial(trials / "0.parquet")
    forged = good.table.with_columns(command_along=-good.table["command_along"])
    write_trial(tmp_path / "forged.parquet", Trial(forged, good.about))
    for given, words in (
        ({"to": "p01"}, "NAME-vNUMBER"),
        ({"to": "../p01-v0"}, "NAME-vNUMBER"),
        ({"to": "a-v0", "policy": "linear"}, "files and --policy"),
        ({"to": "a-v0", "scenario": "ss5"}, "--scenario"),
        ({"to": "a-v0", "episodes": 0}, "--episodes 0"),
        ({"to": "a-v0", "observation": "nothing"}, "nothing"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            exporting.export((trials,), folder=tmp_path / "out", **given)
    for path, words in ((mixed, "2 configurations"), (tmp_path / "forged.parquet", "does not come out")):
        with pytest.raises(ConfigurationError, match=words):
            exporting.export((path,), to="a-v0", folder=tmp_path / "out")
    with pytest.raises(ConfigurationError, match="already"):
        exporting.export((trials,), to="ssmash/p01-v0", folder=root)
    for given, words in (({"agent": "linear"}, "--policy"), ({"policy": "nobody"}, "no scripted policy"),
                         ({}, "nothing to export")):  # fmt: skip
        with pytest.raises(ConfigurationError, match=words):
            exporting.export(to="a-v0", folder=tmp_path / "out", **given)
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
    with pytest.raises(ConfigurationError, match="no dataset of this name"):
        exporting.read_dataset("b-v0", root)


def test_minari_is_not_imported_before_it_is_needed() -> None:
    code = "import sys, ssmash_gym.trials.export; assert not {'minari', 'h5py'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
