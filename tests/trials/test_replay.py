"""A recorded trial is simulated once more from seed and commands, and gives the same bits; a changed one does not."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import Policy, find_agent, make_baseline
from ssmash_gym.trials import Stamp, Trial, TrialRecorder
from ssmash_gym.trials.replay import replay
from tests.trials.rig import batch_for, condition, recorded

SS5 = condition()
SHORT = {"horizon_s": 5.0}  # the whole of an episode in 50 steps


def random_commands(seed: int, count: int) -> np.ndarray[Any, Any]:
    """Held for a while, then others; some lie beyond what can be applied."""
    rng = np.random.default_rng(seed)
    return np.repeat(rng.uniform(-2.0, 2.0, size=(count, 2)), rng.integers(1, 8, size=count), axis=0)[:count]


def driven(policy: Policy, what: Any, seed: int, most: int = 10**6) -> Trial:
    core = TraverseBatch(1, task=policy.task, scenario=what.scenario, helicopter=what.helicopter, threads=1)
    observation = core.reset(seeds=[seed])
    policy.reset(1)
    recorder = TrialRecorder(core, what, seed, {})
    result = None
    while len(recorder) < most and (result is None or not result.endings):
        result = core.step(policy.act(observation))
        observation = result.observation
        recorder.note(result, Stamp(policy.name))
    return recorder.trial(complete=bool(result and result.endings))


def test_fifty_short_trials_come_out_the_same() -> None:
    core = batch_for(SS5)
    for seed in range(50):
        trial = recorded(SS5, seed, random_commands(seed, 4 + seed % 9), batch=core)
        again = replay(trial)
        assert (again.agrees, again.where, again.code) == (True, "", ""), seed
        assert not trial.complete and again.metrics is None


@pytest.mark.slow
def test_fifty_whole_episodes_come_out_the_same() -> None:
    core = batch_for(SS5)
    endings = set()
    for seed in range(50):
        steady = [[0.7, 0.0]] * 600 if seed % 2 else random_commands(seed, 600)
        trial = recorded(SS5, seed, steady, batch=core)
        again = replay(trial)
        assert again.agrees and again.metrics == trial.metrics, (seed, again.where)
        assert trial.metrics is not None
        endings.add(trial.metrics["reason"])
    assert len(endings) > 1


@pytest.mark.parametrize("name", ["trapezoid", "ppo_traverse"])
def test_a_policy_that_observes_otherwise_is_replayed_on_a_bare_batch(name: str) -> None:
    shipped = name == "ppo_traverse"
    policy: Policy = find_agent(name).within(SS5.task) if shipped else make_baseline(name, SS5.task)
    trial = driven(policy, SS5, 5)
    assert trial.complete and trial.condition.task.history is None
    again = replay(trial)
    assert again.agrees, again.where
    row = run_episodes(policy, SS5.scenario, [5], threads=1).row(0, named=True)
    assert {key: row[key] for key in again.metrics or {}} == again.metrics == trial.metrics


def test_commands_of_a_residual_task_are_recorded_as_applied() -> None:
    corrected = SS5.task.model_copy(
        update={
            "residual": condition(
                task={"residual": {"baseline": "trapezoid", "along": 0.2, "across": 0.5}}
            ).task.residual
        }
    )
    core = batch_for(SS5, corrected)
    core.reset(seeds=[3])
    recorder = TrialRecorder(core, SS5, 3, {})
    rng = np.random.default_rng(0)
    for k in range(40):
        action = rng.uniform(-1.5, 1.5, size=(1, 2))
        result = core.step(action, direct=k >= 20)  # a person takes over at step 20
        if k >= 20:
            np.testing.assert_array_equal(core.book.command, np.clip(action, -1.0, 1.0))
        else:
            assert not np.array_equal(core.book.command, np.clip(action, -1.0, 1.0))
        recorder.note(result, Stamp())
    trial = recorder.trial(complete=False)
    assert trial.condition.task.residual is None and trial.about["configuration"] == SS5.configuration
    assert replay(trial).agrees


def test_a_baseline_that_looks_on_is_ready_to_take_over() -> None:
    """Driven by its own commands from outside, the baseline of a residual task goes on as if it had driven."""
    task = condition(task={"residual": {"baseline": "operator", "along": 0.2, "across": 0.2}}).task
    alone, watched = batch_for(SS5, task), batch_for(SS5, task)
    alone.reset(seeds=[4])
    watched.reset(seeds=[4])
    still = np.zeros((1, 2))
    for k in range(60):
        alone.step(still)
        watched.step(alone.book.command if k < 40 else still, direct=k < 40)
        np.testing.assert_array_equal(alone.book.command, watched.book.command)
    np.testing.assert_array_equal(alone.batch.state, watched.batch.state)


def test_an_episode_that_runs_out_of_time() -> None:
    trial = recorded(condition("calm", SHORT), 1, [[0.7, 0.1]] * 50)
    assert trial.complete and trial.metrics is not None and trial.metrics["reason"] == "time"
    again = replay(trial)
    assert again.agrees and again.metrics == trial.metrics


def test_wild_commands_keep_their_share_of_saturation() -> None:
    trial = recorded(condition("calm", SHORT), 2, [[3.0, -0.5], [1e300, 7.0]] * 25)
    assert trial.metrics is not None and trial.metrics["saturation"] > 0.4
    again = replay(trial)
    assert again.agrees and again.metrics == trial.metrics


def test_an_episode_that_ends_early() -> None:
    task = {"limits": {"probe_ultimate_kN": 3.0}}
    trial = recorded(condition("ss6", task), 0, [[1.0, 1.0], [-1.0, -1.0]] * 300)
    assert trial.complete and trial.steps < 600 and trial.metrics is not None
    assert trial.metrics["reason"] == "ultimate_load"
    assert replay(trial).agrees


def test_nothing_driven_yet() -> None:
    trial = recorded(SS5, 7, [])
    assert trial.steps == 0 and trial.commands.shape == (0, 2) and trial.driver == "none"
    assert replay(trial).agrees


def test_a_draw_given_by_hand_is_replayed() -> None:
    core = batch_for(SS5)
    core.reset(seeds=[9])
    given = {**core.draws[0].to_dict(), "claw_delay_s": 0.05, "start_yaw_deg": 3.0}
    trial = recorded(SS5, 9, [[0.5, 0.2]] * 20, batch=core, draws=[given])
    assert not trial.about["draw_of_seed"]
    assert replay(trial).agrees
    as_of_seed = replace(trial, about={**trial.about, "draw_of_seed": True})
    assert "the seed draws another episode" in replay(as_of_seed).where


@pytest.mark.parametrize("column", ["command_along", "command_across", "probe_in_plane_max", "state_digest", "reward"])
def test_a_changed_number_is_found_at_its_step(column: str) -> None:
    trial = recorded(SS5, 8, random_commands(8, 12))
    values = trial.table[column].to_numpy().copy()
    if column == "state_digest":
        values[6] ^= np.uint64(1)
    else:  # a command's last bit need not act: the claw has limits of its own
        values[6] = -values[6] if column.startswith("command") else np.nextafter(values[6], np.float32(0.0))
    changed = replace(trial, table=trial.table.with_columns(pl.Series(column, values)))
    again = replay(changed)
    assert not again.agrees
    assert again.where.startswith(("step 7 ", "step 8 ")), again.where  # a command acts after the claw's delay
    if not column.startswith("command"):
        assert again.where.endswith(column)


def test_other_sources_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    trial = recorded(SS5, 8, [[0.5, 0.0]] * 3)
    older = replace(trial, about={**trial.about, "sources": "0" * 16})
    assert "other sources" in replay(older).words and replay(older).agrees
    monkeypatch.setattr("ssmash_gym.trials.replay.fingerprint", lambda: "another")
    assert "another processor" in replay(trial).words


def test_more_commands_than_the_episode_has() -> None:
    trial = recorded(condition("calm", SHORT), 1, [[1.0, 0.0]] * 50)
    longer = trial.table.vstack(trial.table.tail(1))
    assert "the episode ends at step" in replay(replace(trial, table=longer)).where
    shorter = replace(trial, table=trial.table.head(20))
    assert "does not come to its end" in replay(shorter).where


def test_other_metrics_are_found() -> None:
    trial = recorded(condition("calm", SHORT), 1, [[1.0, 0.0]] * 50)
    assert trial.metrics is not None
    better = {**trial.metrics, "peak_probe_kN": trial.metrics["peak_probe_kN"] - 1e-12}
    assert "the metric peak_probe_kN" in replay(replace(trial, about={**trial.about, "metrics": better})).where


def test_the_record_of_a_trial() -> None:
    trial = recorded(SS5, 12, [[0.5, 0.0]] * 10, about={"participant": "p1", "allowed_late_share": 0.1}, late=2)
    assert trial.condition.configuration == SS5.configuration == trial.about["configuration"]
    timing = trial.about["timing"]
    assert (timing["steps"], timing["late_steps"], timing["late_share"], timing["valid"]) == (10, 2, 0.2, False)
    assert timing["latency_ms"]["p95"] == pytest.approx(10.0)
    assert timing["latency_ms"]["messages"] == 9, "none waited for the first step"
    assert trial.driver == "person" and not trial.scored
    assert trial.about["participant"] == "p1" and "allowed_late_share" not in trial.about
    assert json.loads(json.dumps(trial.about)) == trial.about
    assert trial.table["time_s"].to_list() == pytest.approx(np.arange(1, 11) * 0.1)


def test_a_recording_is_of_one_condition_from_its_start() -> None:
    core = batch_for(SS5)
    core.reset(seeds=[1])
    for other in (condition("ss6"), condition(task={"limits": {"roll_deg": 20.0}})):
        with pytest.raises(ConfigurationError, match="simulates another"):
            TrialRecorder(core, other, 1, {})
    recorder = TrialRecorder(core, SS5, 1, {})
    result = core.step([[0.0, 0.0]])
    with pytest.raises(ValueError, match="start of an episode"):
        TrialRecorder(core, SS5, 1, {})
    recorder.note(result, Stamp())
    with pytest.raises(ValueError, match="noted once"):
        recorder.note(result, Stamp())
    with pytest.raises(ValueError, match="not complete"):
        recorder.trial(complete=True)
