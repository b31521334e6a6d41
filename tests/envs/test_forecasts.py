"""Forecasts in the observation: from the past alone, bit for bit independent of neighbours, and better than nothing."""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.forecasts import HISTORY_S, stride_of
from ssmash_gym.envs.observations import TERMS, chosen_terms
from ssmash_gym.envs.vector import TraverseVectorEnv
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Motion, write_shipmo
from ssmash_gym.vehicle import load_helicopter

HELICOPTER = load_helicopter("generic_tricycle")
SHORT: dict[str, Any] = {"horizon_s": 8.0, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}, "goal": {"hold_s": 0.0}}
MOTION: dict[str, Any] = {
    "type": "irregular",
    "severity": 1.0,
    "levels": [1.0],
    "heave": {"rms": [0.4], "period_s": [8.0]},
    "roll": {"rms": [2.0], "period_s": [10.4]},
    "pitch": {"rms": [0.5], "period_s": [7.0]},
    "sway": {"rms": [0.3], "period_s": [9.0]},
}
SEA = {"base": "flat", "motion": MOTION, "sensors": {"noise": 1.0, "delay_s": {"uniform": [0.0, 0.15]}}}
SEAWAY: dict[str, Any] = {
    "base": "flat",
    "motion": {
        "type": "seaway",
        "hs_m": {"uniform": [2.0, 4.0]},
        "heading_deg": {"uniform": [0.0, 360.0]},
        "speed_kn": {"uniform": [0.0, 20.0]},
    },
    "sensors": SEA["sensors"],
}
LONG = {"lead_in": {"duration_s": 8.0, "ramp_s": 8.0}}  # a short one jerks a ship's deck harder than the sea does
MOVING = pytest.mark.parametrize(
    ("scenario", "task"), [pytest.param(SEA, {}, id="irregular"), pytest.param(SEAWAY, LONG, id="seaway")]
)
NAMES = [f"forecast_{name}_{lead}s" for name in ("roll", "fx", "fy", "fz") for lead in (1, 2, 3, 5)]
TERMS_OF_ROLL = ["yaw", "forecast_roll_2s", "deck_roll", "forecast_roll_1s"]
HOLD = np.zeros(2)


def make(
    n: int = 1, scenario: Any = SEA, task: Any = None, observation: Any = "forecast", **more: Any
) -> TraverseBatch:
    return TraverseBatch(
        n, task={**SHORT, **(task or {})}, scenario=scenario, helicopter=HELICOPTER, observation=observation, **more
    )  # fmt: skip


def places(env: TraverseBatch, names: list[str]) -> list[int]:
    return [env.observer.names.index(name) for name in names]


def told(env: TraverseBatch, steps: int) -> Any:
    """The forecasts at each instant of an episode, (steps + 1, n, 12)."""
    seen = [env.reset(seeds=list(range(env.n)))]
    seen += [env.step(np.tile(HOLD, (env.n, 1))).observation for _ in range(steps)]
    return np.array(seen)[..., places(env, NAMES)]


def test_the_set_is_the_sensors_and_twelve() -> None:
    names = [term.name for term in chosen_terms("forecast")]
    assert names == [term.name for term in chosen_terms("sensors")] + NAMES
    assert not set(NAMES) & {term.name for term in chosen_terms("full")}
    for name in NAMES:
        term = TERMS[name]
        of = TERMS[term.forecast_of]
        assert (term.unit, term.scale, term.noise, term.sensor) == (of.unit, of.scale, 0.0, False)


def test_what_is_measured_does_not_change() -> None:
    """The first 43 numbers of the set are those of the sensors alone, bit for bit."""
    plain, more = make(2, observation="sensors"), make(2)
    assert plain.sensors._forecasts is None
    a, b = plain.reset(seeds=[3, 4]), more.reset(seeds=[3, 4])
    for _ in range(5):
        assert np.array_equal(a, b[:, : a.shape[1]])
        a, b = plain.step(np.zeros((2, 2))).observation, more.step(np.zeros((2, 2))).observation


@MOVING
def test_forecasts_come_true(scenario: dict[str, Any], task: dict[str, Any]) -> None:
    """Against what the deck then does, over many seas, at the episode's start and later: much better than nothing.

    The error's share of the truth: small 1 s ahead, with the first reading as with later ones; 1 at most 5 s ahead.
    """
    env = make(24, scenario, task)
    seen = told(env, 30)
    limits = {"roll": 0.25, "fx": 0.7, "fy": 0.4, "fz": 0.35}
    scales = {"roll": 0.1, "fx": 1.0, "fy": 1.0, "fz": 1.0}
    for row, (name, lead) in enumerate((name, lead) for name in limits for lead in (1, 2, 3, 5)):
        errors, truths = [], []
        for k, draw in enumerate(env.draws):
            assert draw is not None
            times = env.task.lead_in.duration_s + 0.1 * np.arange(31) + lead - draw.sensors_delay_s
            table = env.starter.table(draw)
            force = table.pose(times).specific_force_S(9.81)
            truth = {"fx": force[:, 0], "fy": force[:, 1], "fz": force[:, 2] + 9.81}.get(name)
            truth = table.at(times).position[:, 3] if truth is None else truth
            truths.append(truth / scales[name])
            errors.append(seen[:, k, row] - truths[-1])
        for part in (slice(None), slice(3)):  # the whole time, and the first readings only
            share = np.sqrt(np.mean(np.square(errors)[:, part]) / np.mean(np.square(truths)[:, part]))
            assert share < (limits[name] if lead == 1 else 1.1), (name, lead, part, share)


def test_a_sine_is_foreseen_from_the_first_instant_on() -> None:
    """Late sensors too: readings held at the start are completed by the past. Forecasts count from their reading."""
    sine = {"type": "sinusoid", "dof": "roll", "amplitude": 4.0, "period_s": 9.0, "phase_deg": 90.0}
    for delay in (0.0, 0.1, 0.17):
        scenario = {"base": "flat", "motion": sine, "sensors": {"noise": 0.0, "delay_s": delay}}
        env = make(scenario=scenario)
        seen = told(env, 20)[:, 0]
        times = 2.0 + 0.1 * np.arange(21) - delay
        for row, lead in enumerate((1, 2, 3, 5)):
            roll = math.radians(4.0) * np.cos(2.0 * math.pi * (times + lead) / 9.0) / 0.1
            np.testing.assert_allclose(seen[:, row], roll, atol=3e-4)


def test_a_still_deck_stays() -> None:
    scenario = {"base": "flat", "motion": {"type": "fixed", "heel_deg": 3.0}, "sensors": {"noise": 0.0}}
    seen = told(make(scenario=scenario), 5)[:, 0]
    heel = math.radians(3.0)
    expected = np.repeat([heel / 0.1, 0.0, -9.81 * math.sin(heel), 9.81 * (1.0 - math.cos(heel))], 4)
    np.testing.assert_allclose(seen, np.tile(expected, (6, 1)), rtol=1e-6, atol=1e-12)


class Blind(Motion):
    """A motion that must not be looked at from a given time on."""

    def __init__(self, motion: Motion, until_s: float) -> None:
        self.motion, self.until_s, self.latest_s = motion, until_s, -math.inf

    @property
    def duration_s(self) -> float:
        return self.motion.duration_s

    def signal(self, t: Any) -> Any:
        self.latest_s = max(self.latest_s, float(np.max(t)))
        assert self.latest_s <= self.until_s + 1e-9
        return self.motion.signal(t)


@MOVING
def test_nothing_after_the_start_is_looked_at(
    scenario: dict[str, Any], task: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The motion is asked up to the task's time zero only, and later readings come from the table alone."""
    env, other = make(1, scenario, task), make(1, scenario, task)
    asked: list[Blind] = []
    starter = other.starter
    real = starter.motion

    def blind(draw: Any) -> Any:
        motion, start_s = real(draw)
        asked.append(Blind(motion, start_s + env.task.lead_in.duration_s))
        return asked[-1], start_s

    monkeypatch.setattr(starter, "motion", blind)
    assert np.allclose(env.reset(seeds=[5]), other.reset(seeds=[5]), atol=1e-5)
    assert asked and asked[-1].latest_s > asked[-1].until_s - 0.2


def test_the_future_of_the_table_is_not_in_the_forecasts() -> None:
    """Two seas that differ only later give the same observations until then, and others after."""
    env, other = make(), make()
    assert np.array_equal(env.reset(seeds=[5]), other.reset(seeds=[5]))
    now = int(env.batch.time_s[0] / env.batch.timing.node_spacing_s)
    other.batch._nodes[0, now + 2 :] += 1e-2
    for k in range(2):
        assert np.array_equal(env.step([HOLD]).observation, other.step([HOLD]).observation), k
    for _ in range(4):
        a, b = env.step([HOLD]).observation, other.step([HOLD]).observation
    assert not np.array_equal(a[:, places(env, NAMES)], b[:, places(env, NAMES)])


@MOVING
def test_bits_do_not_depend_on_the_batch(scenario: dict[str, Any], task: dict[str, Any]) -> None:
    """Column by column the single environment, whatever the number of neighbours, threads, and order of the columns."""
    many, threaded = told(make(6, scenario, task), 4), told(make(6, scenario, task, threads=2), 4)
    assert np.array_equal(many, threaded)
    for k in (0, 3, 5):
        env = make(1, scenario, task)
        seen = [env.reset(seeds=[k])]
        seen += [env.step([HOLD]).observation for _ in range(4)]
        assert np.array_equal(np.array(seen)[:, 0, places(env, NAMES)], many[:, k])
    mixed = make(6, scenario, task)
    mixed.reset(seeds=list(range(6)))
    order = np.array([4, 1, 5])
    part = mixed.step(np.zeros((3, 2)), order).observation
    assert np.array_equal(part[:, places(mixed, NAMES)], many[1, order])


def test_copies_carry_the_models() -> None:
    """Snapshot, restore and fork, past the next reset; through pickle."""
    env = make(2, task={"horizon_s": 1.0})
    env.reset(seeds=[1, 2])
    for _ in range(3):
        env.step(np.zeros((2, 2)))
    kept = pickle.loads(pickle.dumps(env.snapshot()))
    copies = env.fork(2)
    first = [env.step(np.zeros((2, 2))).observation for _ in range(7)] + [env.reset()]
    forked = [copies.step(np.zeros((4, 2))).observation for _ in range(7)] + [copies.reset()]
    env.restore(kept)
    again = [env.step(np.zeros((2, 2))).observation for _ in range(7)] + [env.reset()]
    for a, b, c in zip(first, again, forked, strict=True):
        assert np.array_equal(a, b) and np.array_equal(np.repeat(a, 2, axis=0), c)


def test_the_vector_environments_carry_them() -> None:
    core, env = make(3, task={"horizon_s": 0.5}), TraverseVectorEnv(
        3, task={**SHORT, "horizon_s": 0.5}, scenario=SEA, helicopter=HELICOPTER, observation="forecast"
    )  # fmt: skip
    assert np.array_equal(core.reset(seeds=[7, 8, 9]), env.reset(seed=7)[0])
    assert env.single_observation_space.shape == (59,)
    kept = env.snapshot()
    first = [env.step(np.zeros((3, 2)))[0] for _ in range(7)]
    assert np.array_equal(first[0], core.step(np.zeros((3, 2))).observation)
    env.restore(kept)
    assert all(np.array_equal(a, env.step(np.zeros((3, 2)))[0]) for a in first)


def test_stable_baselines_carries_them() -> None:
    """Across the end of an episode, where the environment resets by itself; and its snapshots too."""
    pytest.importorskip("stable_baselines3")
    from ssmash_gym.envs.sb3 import TraverseVecEnv

    core = make(2, task={"horizon_s": 0.3})
    env = TraverseVecEnv(
        2, task={**SHORT, "horizon_s": 0.3}, scenario=SEA, helicopter=HELICOPTER, observation="forecast"
    )
    env.seed(3)
    assert np.array_equal(env.reset(), core.reset(seeds=[3, 4]))
    kept = env.snapshot()
    seen = [env.step(np.zeros((2, 2)))[0] for _ in range(4)]
    expected = [core.step(np.zeros((2, 2))).observation for _ in range(3)]
    assert np.array_equal(seen[0], expected[0]) and np.array_equal(seen[1], expected[1])
    assert np.array_equal(seen[2], core.reset())
    assert np.array_equal(seen[3], core.step(np.zeros((2, 2))).observation)
    env.restore(kept)
    assert all(np.array_equal(a, env.step(np.zeros((2, 2)))[0]) for a in seen)


def test_custom_lists_hold_what_they_name() -> None:
    env, whole = make(observation=TERMS_OF_ROLL), make()
    env.reset(seeds=[6]), whole.reset(seeds=[6])
    seen, full = env.step([HOLD]).observation, whole.step([HOLD]).observation
    assert seen.shape == (1, 4)
    # Other terms take other random numbers, so the noise differs; the sea does not.
    assert seen[0, 1] == pytest.approx(full[0, places(whole, ["forecast_roll_2s"])[0]], abs=0.2)
    assert abs(seen[0, 1] - seen[0, 3]) > 1e-3


@pytest.mark.parametrize("observation", [["forecast_fy_1s"], ["deck_roll", "forecast_fz_5s"]])
def test_a_forecast_needs_its_readings(observation: list[str]) -> None:
    with pytest.raises(ConfigurationError, match="whose readings"):
        make(observation=observation)


def test_control_intervals_must_suit() -> None:
    assert [stride_of(interval) for interval in (0.01, 0.02, 0.05, 0.1, 0.2, 0.25)] == [20, 10, 4, 2, 1, 1]
    for interval in (0.15, 0.08, 0.3, 0.5, 1.0):
        with pytest.raises(ConfigurationError, match=f"control_interval_s = {interval:g} is refused with forecasts"):
            stride_of(interval)
    task = {"control_interval_s": 0.5}
    make(task=task, observation="sensors")
    with pytest.raises(ConfigurationError, match="forecasts in the observation"):
        make(task=task)
    assert make(task={"control_interval_s": 0.2, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}}).reset().shape == (
        1,
        59,
    )


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A recorded sea of 150 s."""
    from ssmash_gym.ship import parse_motion

    section = {"type": "irregular", "roll": {"rms_deg": 3.0, "period_s": 10.0}, "sway": {"rms_m": 0.5, "period_s": 9.0}}
    path = tmp_path_factory.mktemp("records") / "sea.csv"
    write_shipmo(path, parse_motion(section).realise(np.random.default_rng(0)), 0.1, 150.0)
    yield str(path)


def test_a_record_is_used_as_far_as_it_reaches_back(record: str) -> None:
    """With a minute of record before the start there are forecasts; with less, all stays as it was read."""

    def seen(start_s: float) -> tuple[Any, Any]:
        motion = {"type": "file", "paths": [record], "start_s": start_s}
        env = make(scenario={"base": "flat", "motion": motion, "sensors": {"noise": 0.0}})
        observation = env.reset(seeds=[0])[0]
        return observation[places(env, NAMES)], observation[places(env, ["deck_roll", "deck_fx", "deck_fy", "deck_fz"])]

    forecasts, read = seen(57.0)
    np.testing.assert_array_equal(forecasts, np.repeat(read, 4))
    forecasts, read = seen(100.0)
    assert np.max(np.abs(forecasts - np.repeat(read, 4))) > 0.05


def test_the_past_has_noise_of_its_own() -> None:
    """The level of the draw, from the sensor seed: another seed gives another past, the same seed the same."""
    env = make()
    env.reset(seeds=[1])
    draw = env.draws[0]
    assert draw is not None

    def pasts(**changes: Any) -> Any:
        env.reset(draws=[replace(draw, **{"sensors_delay_s": 0.0, **changes})])
        bank = env.sensors._forecasts
        assert bank is not None
        return bank._ring[1:, :, 0].copy()  # the first reading stands in place 0

    quiet, one, other = pasts(sensors_noise=0.0), pasts(), pasts(sensor_seed=draw.sensor_seed + 1)
    assert np.array_equal(one, pasts()) and not np.array_equal(one, other)
    deviation = np.std(one - quiet, axis=0)
    assert deviation == pytest.approx([0.01, 0.02, 0.02, 0.02], rel=0.35)
    assert HISTORY_S == 180.0


def test_the_page_lists_them() -> None:
    page = (Path(__file__).parents[2] / "docs" / "guide" / "quiescence.md").read_text(encoding="utf-8")
    for name in NAMES:
        term = TERMS[name]
        assert f"| `{name}` | {term.meaning} | {term.unit} | {term.scale:g} |" in page, name
