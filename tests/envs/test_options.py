"""Options of the environment: history, the true future, residual action, a weaker drive, changes along the way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs import load_task
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import TERMS, observed_terms
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.vehicle import load_helicopter

HELICOPTER = load_helicopter("generic_tricycle")
SHORT: dict[str, Any] = {"horizon_s": 8.0}
HISTORY: dict[str, Any] = {"terms": ["deck_fy", "yaw_rate"], "samples": 3, "every_s": 0.2}
RESIDUAL: dict[str, Any] = {"baseline": "yield", "along": 0.3, "across": 0.5}
QUIET = {"base": "ss5", "sensors": {"noise": 0.0, "delay_s": 0.0}}
SEEDS = [11, 12, 13]


def make(n: int = 3, task: Any = None, scenario: Any = "ss5", **more: Any) -> TraverseBatch:
    return TraverseBatch(n, task={**SHORT, **(task or {})}, scenario=scenario, helicopter=HELICOPTER, **more)


def actions(count: int, n: int = 3) -> np.ndarray:
    return np.random.default_rng(7).uniform(-1.0, 1.0, (count, n, 2))


# --- history ----------------------------------------------------------------------------------------------------


def test_history_is_what_was_read_before() -> None:
    env = make(task={"history": HISTORY})
    seen = [env.reset(seeds=SEEDS).copy()]
    seen += [env.step(action).observation for action in actions(12)]
    names = [term.name for term in env.observer.terms]
    assert names[-6:] == [f"{of}_before_{lag}s" for of in HISTORY["terms"] for lag in ("0.2", "0.4", "0.6")]
    for of in HISTORY["terms"]:
        for lag, steps in (("0.2", 2), ("0.4", 4), ("0.6", 6)):
            place = names.index(f"{of}_before_{lag}s")
            for t in range(len(seen)):
                earlier = seen[max(t - steps, 0)][:, names.index(of)]  # the first reading stood for ever
                assert np.array_equal(seen[t][:, place], earlier)


def test_history_changes_nothing_else() -> None:
    plain, more = make(), make(task={"history": HISTORY})
    assert np.array_equal(plain.reset(seeds=SEEDS), more.reset(seeds=SEEDS)[:, : plain.observer.size])


@pytest.mark.parametrize(
    ("history", "words"),
    [
        ({"terms": ["deck_fx", "time_left"], "samples": 2, "every_s": 0.2}, "'time_left': must be a measured term"),
        ({"terms": ["velocity_x"], "samples": 2, "every_s": 0.2}, "'velocity_x'"),
        ({"terms": ["yaw", "yaw"], "samples": 2, "every_s": 0.2}, "none twice"),
        ({"terms": ["yaw"], "samples": 2, "every_s": 0.25}, "whole number of intervals"),
        ({"terms": ["yaw"], "samples": 2, "every_s": 0.01}, "history.every_s"),
    ],
)
def test_wrong_histories_are_refused(history: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        make(1, {"history": history})


# --- the true future ----------------------------------------------------------------------------------------------


def test_the_oracle_tells_what_noiseless_sensors_will_read() -> None:
    env = make(scenario=QUIET, observation="oracle")
    seen = [env.reset(seeds=SEEDS).copy()]
    seen += [env.step(action).observation for action in 0.3 * actions(60)]
    names = [term.name for term in env.observer.terms]
    for name, term in TERMS.items():
        if term.oracle_of:
            steps = round(term.lead_s / 0.1)
            for t in range(0, len(seen) - steps, 7):
                told, true = seen[t][:, names.index(name)], seen[t + steps][:, names.index(term.oracle_of)]
                assert told == pytest.approx(true, abs=2e-3)  # the table of nodes against the sum of waves


# --- residual action ----------------------------------------------------------------------------------------------


def test_no_correction_is_the_baseline() -> None:
    guided, plain = make(task={"residual": RESIDUAL}), make()
    law = make_baseline("yield", plain.task)
    law.reset(3)
    seen = plain.reset(seeds=SEEDS)
    assert np.array_equal(guided.reset(seeds=SEEDS), seen)
    for _ in range(20):
        result = plain.step(law.act(seen))
        seen = result.observation
        assert np.array_equal(guided.step(np.zeros((3, 2))).observation, seen)


def test_a_correction_is_bounded_and_added() -> None:
    guided = make(task={"residual": RESIDUAL})
    law = make_baseline("yield", guided.task)
    law.reset(3)
    seen = guided.reset(seeds=SEEDS)
    for action in actions(15):
        wanted = np.clip(law.act(seen) + np.array([0.3, 0.5]) * action, -1.0, 1.0)
        seen = guided.step(action).observation
        assert guided.book.command == pytest.approx(wanted, abs=1e-12)


def test_a_guided_batch_forks_restores_and_steps_in_parts() -> None:
    whole, parts = make(task={"residual": RESIDUAL}), make(task={"residual": RESIDUAL})
    assert np.array_equal(whole.reset(seeds=SEEDS), parts.reset(seeds=SEEDS))
    for action in actions(10):
        expected = whole.step(action).observation
        for columns in ([2], [0, 1]):
            assert np.array_equal(parts.step(action[columns], columns).observation, expected[columns])
    kept, forked = whole.snapshot(), whole.fork(2)
    after = [whole.step(action).observation for action in actions(5)]
    assert all(
        np.array_equal(forked.step(np.repeat(action, 2, axis=0)).observation, np.repeat(seen, 2, axis=0))
        for action, seen in zip(actions(5), after, strict=True)
    )
    whole.restore(kept)
    assert all(np.array_equal(whole.step(a).observation, seen) for a, seen in zip(actions(5), after, strict=True))


def test_an_unknown_baseline_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"residual\.baseline = 'glide'"):
        make(1, {"residual": {**RESIDUAL, "baseline": "glide"}})


# --- a weaker drive -----------------------------------------------------------------------------------------------


def test_the_hard_scenario_limits_the_drive_across() -> None:
    env = make(scenario="hard")
    env.reset(seeds=SEEDS)
    for _ in range(70):
        env.step(np.tile([0.0, 1.0], (3, 1)))
    assert env.book.command[:, 1] == pytest.approx(0.2)  # 0.02 m/s of the task's 0.1 m/s
    assert env.telemetry["claw_y"] == pytest.approx(0.05, abs=1e-3)  # with the ripple


def test_a_landing_beyond_a_drawn_travel_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"lateral travel of 0\.05 m"):
        make(scenario={"base": "ss5", "claw": {"y_travel_m": 0.05}})


# --- changes along the way ----------------------------------------------------------------------------------------


def test_a_change_holds_for_later_episodes() -> None:
    env = make(n=16, scenario={"base": "ss5", "start": {"yaw_deg": 0.0}})
    env.reset(seeds=range(16))
    env.change(scenario={"start": {"yaw_deg": {"uniform": [5.0, 8.0]}}}, reward={"time_per_s": 3.0})
    assert np.abs(env.telemetry["yaw"]).max() < np.deg2rad(3.0)
    assert env.step(np.zeros((16, 2))).reward_terms["time"] == pytest.approx(-0.3)
    env.reset(columns=[1, 4])
    yaws = np.array([draw.start_yaw_deg for draw in env.draws if draw is not None])
    assert np.all(yaws[[1, 4]] >= 5.0) and np.all(np.delete(yaws, [1, 4]) == 0.0)


def test_a_refused_change_changes_nothing() -> None:
    env = make(n=1)
    for changes, words in (
        ({"reward": {"time_per_hour": 1.0}}, "time_per_hour"),
        ({"scenario": {"claw": {"delay_s": 0.5}}}, "refused as a change"),
        ({"reward": {"peak": 1.0}, "scenario": {"start": {"yaw": 1.0}}}, "yaw"),
    ):
        before = env.task, env.scenario
        with pytest.raises(ConfigurationError, match=words):
            env.change(**changes)
        assert (env.task, env.scenario) == before


def test_time_that_costs_nothing() -> None:
    env = make(n=1, task={"reward": {"time_per_s": 1.0, "time_free_s": 0.3}})
    env.reset(seeds=[1])
    assert [float(env.step(np.zeros((1, 2))).reward_terms["time"][0]) for _ in range(5)] == [0, 0, 0, -0.1, -0.1]


def test_observed_terms_of_a_task() -> None:
    assert len(observed_terms(load_task({"history": HISTORY}))) == 43 + 6
