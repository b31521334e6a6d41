"""The search: it proposes, prunes, keeps the best, and goes on after a stop as if there had been none."""

from __future__ import annotations

import csv
import threading
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
import yaml
from rich.console import Console

from ssmash_gym.cli import main
from ssmash_gym.document import write_yaml
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.training import tuning
from ssmash_gym.training.config import load_training
from ssmash_gym.training.seeds import TUNING, block
from ssmash_gym.training.tuning import BEST, SEARCH, TABLE, Watch, penalised, search
from ssmash_gym.training.tuning_config import Objective, SearchConfig, load_search

optuna = pytest.importorskip("optuna")
QUIET = Console(quiet=True)
RATE = "rate.txt"  # what the agent of a quick training is made of


@pytest.fixture
def plan() -> SearchConfig:
    """Four small trainings of the smoke configuration."""
    return SearchConfig(
        name="small",
        training="smoke",
        changes={"total_steps": 256, "environment.task.horizon_s": 2.0},
        space={
            "ppo.learning_rate": {"low": 1e-4, "high": 1e-2, "log": True},
            "ppo.epochs": {"low": 1, "high": 3, "whole": True},
            "network.activation": {"choices": ["tanh", "relu"]},
        },  # type: ignore[dict-item]
        trials=4,
        random_trials=2,
        objective=Objective(scenario="calm", episodes=2),
    )


def rows(run: Path) -> list[dict[str, str]]:
    with (run / TABLE).open(newline="") as file:
        return list(csv.DictReader(file))


def quick(
    monkeypatch: pytest.MonkeyPatch, stop_at: int | None = None, stop: threading.Event | None = None
) -> list[Any]:
    """Trainings that take no time: the score is a function of the settings; one of them may be interrupted."""
    seen: list[Any] = []

    def learn(settings: Any, run: Path, console: Console, *, stop: threading.Event, watch: Any) -> bool:
        seen.append(settings)
        write_text(run / "agent" / RATE, repr(settings.ppo.learning_rate))
        if stop_at == len(seen) - 1:
            outer.set()
        return not stop.is_set()

    outer = stop or threading.Event()
    monkeypatch.setattr("ssmash_gym.training.run.learn", learn)
    monkeypatch.setattr(tuning, "score", lambda folder, objective: 10.0 + 1e3 * seen[-1].ppo.learning_rate)
    return seen


def test_a_search_trains_judges_and_keeps_the_best(plan: SearchConfig, tmp_path: Path) -> None:
    two = plan.model_copy(update={"trials": 2})
    assert search(two, tmp_path / "run", QUIET)
    found = rows(tmp_path / "run")
    assert [row["state"] for row in found] == ["COMPLETE", "COMPLETE"]
    best = min(found, key=lambda row: float(row["objective_kN"]))
    settings = load_training(tmp_path / "run" / BEST)
    assert settings.ppo.learning_rate == pytest.approx(float(best["ppo.learning_rate"]))
    assert (settings.total_steps, settings.ppo.epochs) == (256, int(best["ppo.epochs"]))
    assert (tmp_path / "run" / "trials" / "0001" / "agent" / "agent.json").is_file()
    assert not (tmp_path / "run" / "trials" / "0001" / "checkpoints").exists()


def test_the_judging_episodes_are_those_of_choices(
    plan: SearchConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import polars

    seen: list[list[int]] = []

    def run_episodes(agent: object, scenario: object, seeds: list[int]) -> Any:
        seen.append(list(seeds))
        return polars.DataFrame({"scored_peak_kN": [10.0, 20.0], "success": [True, False]})

    monkeypatch.setattr("ssmash_gym.evaluation.episodes.run_episodes", run_episodes)
    monkeypatch.setattr(tuning, "load_agent", lambda folder: None)
    found = tuning.score(tmp_path, plan.objective)
    assert seen == [block(0, TUNING, 2)]
    assert found == pytest.approx(19.5 + 200.0 * 0.45)
    assert penalised(19.5, 0.97, plan.objective) == 19.5


def test_a_search_that_was_stopped_goes_on_as_if_it_had_not_been(
    plan: SearchConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick(monkeypatch)
    assert search(plan, tmp_path / "whole", QUIET)
    stop = threading.Event()
    quick(monkeypatch, stop_at=2, stop=stop)
    assert not search(plan, tmp_path / "stopped", QUIET, stop)
    assert len([row for row in rows(tmp_path / "stopped") if row["state"] == "COMPLETE"]) == 2
    quick(monkeypatch)
    assert search(plan, tmp_path / "stopped", QUIET)
    keys = ["objective_kN", *plan.space]
    whole, stopped = (
        [[row[key] for key in keys] for row in rows(tmp_path / name) if row["state"] == "COMPLETE"]
        for name in ("whole", "stopped")
    )
    assert whole == stopped
    assert len({tuple(row) for row in whole}) == 4
    assert (tmp_path / "whole" / BEST).read_text().splitlines()[1:] == (
        (tmp_path / "stopped" / BEST).read_text().splitlines()[1:]
    )


@pytest.mark.parametrize("stop_at", [0, 1, 2])
def test_after_a_stop_each_trial_has_its_own_folder_and_number(
    stop_at: int, plan: SearchConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop, told = threading.Event(), Console(record=True, file=StringIO(), width=200)
    quick(monkeypatch, stop_at=stop_at, stop=stop)
    assert not search(plan, tmp_path, told, stop)
    quick(monkeypatch)
    assert search(plan, tmp_path, told)
    done = [row for row in rows(tmp_path) if row["state"] == "COMPLETE"]
    assert len(done) == 4
    for row in done:
        rate = float((tmp_path / "trials" / f"{int(row['trial']):04d}" / "agent" / RATE).read_text())
        assert rate == pytest.approx(float(row["ppo.learning_rate"]))
        assert told.export_text(clear=False).count(f"trial {row['trial']}: {float(row['objective_kN']):.2f} kN") == 1


def test_a_combination_that_is_refused_is_given_up_and_any_other_mistake_ends_the_search(
    plan: SearchConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = plan.model_copy(update={"changes": {**plan.changes, "environment.task.reward.laod": 1.0}, "trials": 2})
    seen = quick(monkeypatch)
    assert search(refused, tmp_path / "refused", QUIET)
    assert not seen
    assert [row["state"] for row in rows(tmp_path / "refused")] == ["PRUNED", "PRUNED"]

    def learn(*_: Any, **__: Any) -> bool:
        raise ConfigurationError("PyTorch finds no GPU")

    monkeypatch.setattr("ssmash_gym.training.run.learn", learn)
    with pytest.raises(ConfigurationError, match="no GPU"):
        search(plan, tmp_path / "run", QUIET)
    quick(monkeypatch)
    assert search(plan, tmp_path / "run", QUIET)  # and the trial is tried again
    assert [row["state"] for row in rows(tmp_path / "run")] == ["FAIL", *["COMPLETE"] * 4]


@pytest.mark.parametrize("resumed", [False, True])
def test_a_stopped_search_leaves_as_a_stopped_training_does(
    resumed: bool, plan: SearchConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_text(tmp_path / SEARCH, write_yaml(plan.model_dump(mode="json")))
    words = ["--resume", str(tmp_path)] if resumed else ["--tune", "tune_ppo", "--out", str(tmp_path / "run")]
    monkeypatch.setattr(tuning, "search", lambda *_: True)
    assert main(["train", *words]) == 0
    monkeypatch.setattr(tuning, "search", lambda *_: False)
    with pytest.raises(SystemExit) as left:
        main(["train", *words])
    assert left.value.code == 130


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("objective.scenario=ss9", r"objective\.scenario.*'ss9'.*ss5"),
        ("objective.scenario={start: {yaw: 1.0}}", r"objective\.scenario.*start\.yaw.*yaw_deg"),
        ("changes={environment.task.reward.laod: 1}", r"no key reward\.laod; allowed here are.*load_per_s"),
        ("changes={environment.scenario: ss9}", "'ss9'.*ss5"),
        ("changes={stages: [{from_step: 9, reward: {laod: 1.0}}]}", "laod.*load_per_s"),
        ("changes={evolution.scenario: ss9}", "'ss9'.*ss5"),
        ("space.ppo.epochs={low: 1.5, high: 8, whole: true}", r"low = 1\.5: must be a whole number"),
        ("space.ppo.epochs={low: 1, high: 8.9, whole: true}", r"high = 8\.9: must be a whole number"),
    ],
)
def test_a_mistake_in_what_the_trials_need_costs_one_sentence_and_no_training(
    change: str, told: str, plan: SearchConfig, tmp_path: Path
) -> None:
    file = tmp_path / "plan.yaml"
    file.write_text(write_yaml(plan.model_dump(mode="json", exclude_unset=True)))
    assert load_search(file).space == plan.space
    if change.startswith("space"):  # its keys have dots
        document = yaml.safe_load(file.read_text())
        document["space"]["ppo.epochs"] = yaml.safe_load(change.split("=", 1)[1])
        file.write_text(yaml.safe_dump(document))
    with pytest.raises(ConfigurationError, match=told) as refusal:
        load_search(file, [] if change.startswith("space") else [change])
    assert "\n" not in str(refusal.value)


def test_a_training_that_is_worse_than_the_others_is_given_up(plan: SearchConfig) -> None:
    study = optuna.create_study(pruner=optuna.pruners.MedianPruner(n_startup_trials=1, n_warmup_steps=0))

    def followed(peak_kN: float) -> Watch:
        trial = study.ask()
        watch = Watch(trial, plan, 600, threading.Event())
        for steps in range(50, 601, 50):
            watch({"steps": steps, "episodes": 4.0, "peak_probe_kN_p95": peak_kN, "success_rate": 0.9})
        study.tell(trial, peak_kN)
        return watch

    assert not followed(20.0).pruned
    assert followed(30.0).pruned
    assert not followed(10.0).pruned
    assert study.trials[0].intermediate_values == pytest.approx(dict.fromkeys(range(1, 6), 30.0))


def test_mistakes_are_told_before_the_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    document = {"name": "x", "training": "smoke", "space": {"ppo.epoch": {"low": 1, "high": 2, "whole": True}}}
    Path("space.yaml").write_text(yaml.safe_dump(document))
    assert main(["train", "--tune", "space.yaml"]) == 1
    message = capsys.readouterr().err
    assert "epoch" in message
    assert message.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["space.yaml"]
    for wrong in (
        {"low": 2.0, "high": 1.0},
        {"choices": [1], "low": 0.0, "high": 1.0},
        {"low": 0.0, "high": 1, "log": 1},
    ):
        Path("space.yaml").write_text(yaml.safe_dump(document | {"space": {"ppo.epochs": wrong}}))
        with pytest.raises(ConfigurationError, match=r"space\.ppo\.epochs|low|log"):
            load_search("space.yaml")


def test_what_ships_loads() -> None:
    plan = load_search("tune_ppo", ["trials=3"])
    assert plan.trials == 3
    assert plan.settings({"ppo.epochs": 7}).ppo.epochs == 7
