"""Programs at the claw in virtual time, through the same recorder."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.trials import Trial, read_trial, read_trials
from ssmash_gym.trials.protocol import load_protocol
from ssmash_gym.trials.replay import replay
from ssmash_gym.trials.scripted import policy_for, run_scripted, scripted_trial, virtual_stamp
from ssmash_gym.trials.session import Session
from tests.trials.rig import condition

SMALL: dict[str, Any] = {
    "task": {"horizon_s": 2.0},
    "practice": {"least": 2, "most": 2, "plateau": {"last": 2}},
    "scored": {"seas": 3},
}


def test_a_whole_session(tmp_path: Path) -> None:
    told: list[Trial] = []
    with Session.open(load_protocol(SMALL), "robot", tmp_path, experience="script") as session:
        paths = run_scripted(session, "operator", told=lambda trial, path: told.append(trial))
        assert session.next() is None
    found = read_trials(tmp_path)
    assert [path for path, _ in found] == paths and len(told) == 5
    for _, trial in found:
        assert trial.driver == "scripted operator" and trial.about["origin"] == "script"
        assert trial.valid and trial.complete and trial.about["timing"]["late_steps"] == 0
        assert replay(trial).agrees


def test_a_session_stopped_by_ctrl_c_goes_on(tmp_path: Path) -> None:
    protocol = load_protocol(SMALL)

    def stop(trial: Trial, path: Path) -> None:
        if "002" in path.name:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Session.open(protocol, "robot", tmp_path) as session:
        run_scripted(session, "trapezoid", told=stop)
    with Session.open(protocol, "robot", tmp_path) as session:
        assert len(run_scripted(session, "trapezoid", most=1)) == 1
        assert len(run_scripted(session, "trapezoid")) == 2
    assert len(read_trials(tmp_path)) == 5


@pytest.mark.slow
def test_a_killed_session_goes_on(tmp_path: Path) -> None:
    """Killed at any moment, again and again, a session meets each scored sea once and loses no file."""
    code = (
        "import json, sys\nfrom ssmash_gym.trials.protocol import load_protocol\n"
        "from ssmash_gym.trials.scripted import run_scripted\nfrom ssmash_gym.trials.session import Session\n"
        "with Session.open(load_protocol(json.loads(sys.argv[2])), 'robot', sys.argv[1]) as session:\n"
        "    print('open', flush=True)\n    run_scripted(session, 'hold')\n"
    )
    changes = {**SMALL, "scored": {"seas": 40}}
    pauses = np.random.default_rng(0).uniform(0.3, 1.5, size=20)
    kills = 0
    for pause in [*pauses, None]:
        words = [sys.executable, "-c", code, str(tmp_path), json.dumps(changes)]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as runner:
            assert runner.stdout is not None and runner.stdout.readline() == "open\n"
            try:
                runner.wait(pause)
            except subprocess.TimeoutExpired:
                runner.kill()
                kills += 1
        if runner.returncode == 0:
            break
    assert kills > 1
    protocol = load_protocol(changes)
    with Session.open(protocol, "robot", tmp_path) as session:
        assert session.next() is None
        assert len(session.record.trials) == 42
    assert [trial.seed for _, trial in read_trials(tmp_path) if trial.scored] == protocol.order("robot")


def test_trials_by_seed_are_the_episodes_of_the_evaluation(tmp_path: Path) -> None:
    what = condition("ss5", {"horizon_s": 4.0})
    paths = run_scripted(what, "ppo_traverse", [5, 6], tmp_path)
    policy = policy_for("ppo_traverse", what)
    rows = run_episodes(policy, what.scenario, [5, 6], threads=1)
    for path, row in zip(paths, rows.iter_rows(named=True), strict=True):
        trial = read_trial(path)
        assert trial.metrics == {key: row[key] for key in trial.metrics or {}}
        assert trial.driver == "ppo_traverse" and trial.phase == "free"
        assert trial.condition.task.history is None and trial.about["configuration"] == what.configuration


def test_a_planner_is_told_of_the_simulation() -> None:
    what = condition("ss5", {"horizon_s": 1.0})
    trial = scripted_trial(what, 1, policy_for("mppi", what), most_steps=3)
    assert not trial.complete and trial.steps == 3 and replay(trial).agrees


def test_times_of_the_virtual_clock() -> None:
    stamps = [virtual_stamp("x", k, 0.1) for k in range(600)]
    ages = np.array([stamp.taken_s - stamp.received_s for stamp in stamps])
    assert (np.diff([stamp.sequence for stamp in stamps]) == 3).all()  # 30 messages a second
    assert (ages >= -1e-9).all() and (ages < 1 / 30).all()
    assert [stamp.shown_step for stamp in stamps[:2]] == [-1, 0]


def test_mistakes_cost_one_sentence(tmp_path: Path) -> None:
    what = condition("calm")
    with pytest.raises(ConfigurationError, match="there is no agent 'nobody'"):
        run_scripted(what, "nobody", [1], tmp_path)
    with pytest.raises(ConfigurationError, match="need a folder"):
        run_scripted(what, "operator", [1])
    session = Session.open(load_protocol(SMALL), "p", tmp_path)
    with session, pytest.raises(ConfigurationError, match="of its own"):
        run_scripted(session, "operator", [1])
    assert not list(tmp_path.rglob("*.parquet"))


def test_an_agent_drives_a_task_that_is_observed_otherwise_in_its_own_way() -> None:
    what = condition("ss5", {"horizon_s": 1.0, "observation": "full"})
    trial = scripted_trial(what, 1, policy_for("ppo_traverse", what))
    assert trial.condition.task.observation == "full"
    assert trial.complete and replay(trial).agrees
