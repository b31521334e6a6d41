"""The observation: scales, clipping, sensors' noise and delay, and that nothing of the future is in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs import load_scenario
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.observations import GRAVITY, TERMS, chosen_terms
from ssmash_gym.envs.sensors import SensorBank
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.simulation.telemetry import CHANNELS
from ssmash_gym.vehicle import load_helicopter

HELICOPTER = load_helicopter("generic_tricycle")
SHORT: dict[str, Any] = {"horizon_s": 1.0, "lead_in": {"duration_s": 2.0, "ramp_s": 2.0}}
SEA = {"base": "training", "sensors": {"noise": 0.0, "delay_s": 0.0}}


def make(n: int = 1, scenario: Any = SEA, **more: Any) -> TraverseBatch:
    return TraverseBatch(n, task=SHORT, scenario=scenario, helicopter=HELICOPTER, **more)


def test_each_number_is_its_channel_over_its_scale() -> None:
    """Every term that is a channel, and the computed ones, against the telemetry table."""
    env = make(3, observation="full")
    env.reset(seeds=[1, 2, 3])
    result = env.step(np.full((3, 2), 0.4))
    telemetry = env.telemetry
    computed = {
        "deck_fz": telemetry["deck_fz"] + GRAVITY,
        "probe_peak": telemetry.peak_max("probe_in_plane"),
        "auxiliary_steer_sin": np.sin(telemetry["auxiliary_steer"]),
        "auxiliary_steer_cos": np.cos(telemetry["auxiliary_steer"]),
        "to_go": 8.0 - telemetry["claw_x"],
        "to_go_near": (8.0 - telemetry["claw_x"]) / (8.25 - telemetry["claw_x"]),
        "last_command_x": np.full(3, 0.4),
        "last_command_y": np.full(3, 0.4),
        "time_left": np.full(3, 0.9),
        "episode_peak": np.zeros(3),  # none yet: the grace lasts
        "goal_held": np.zeros(3),
    }
    for k, term in enumerate(env.observer.terms):
        value = computed[term.name] if term.name in computed else telemetry[term.name]
        expected = np.clip(value / term.scale, -5.0, 5.0)
        assert result.observation[:, k] == pytest.approx(expected, rel=1e-6, abs=1e-9), term.name


def test_the_sets() -> None:
    names = [term.name for term in chosen_terms("sensors")]
    wanted = "roll pitch yaw roll_rate pitch_rate yaw_rate deck_roll deck_pitch deck_wx deck_wy deck_wz deck_fx deck_fy"
    wanted += " deck_fz probe_fx probe_fy probe_axial auxiliary_steer_sin auxiliary_steer_cos claw_x claw_y claw_vx"
    wanted += " claw_vy to_go last_command_x last_command_y time_left"
    for station in ("auxiliary", "right", "left"):
        for kind in ("tire_vertical_deflection", "tire_lateral_deflection", "vertical_load", "compression"):
            wanted += f" {station}_{kind}"
    assert set(wanted.split()) <= set(names)
    full, forecast, oracle = ({term.name for term in chosen_terms(name)} for name in ("full", "forecast", "oracle"))
    assert set(names) == full & forecast == full & oracle and full | forecast | oracle == set(TERMS)
    assert full - forecast and forecast - full == {name for name, term in TERMS.items() if term.forecast_of}
    assert oracle - full == {name for name, term in TERMS.items() if term.oracle_of}
    assert [term.name for term in chosen_terms(["yaw", "claw_y"])] == ["yaw", "claw_y"]
    assert make(observation=["yaw", "claw_y"]).reset(seeds=[0]).shape == (1, 2)


@pytest.mark.parametrize(
    ("given", "words"),
    [(["yaw", "probe_fxx"], "probe_fx"), ([], "at least one"), (["yaw", "yaw"], "none twice")],
)
def test_wrong_names_are_refused(given: list[str], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        make(observation=given)


def test_every_term_says_what_it_is() -> None:
    for term in TERMS.values():
        assert term.scale > 0.0 and term.unit and term.meaning
        assert term.sensor == (term.noise > 0.0)
        if term.channel:
            assert CHANNELS[term.channel].unit == term.unit


def test_clipping_is_bounded_and_counted() -> None:
    env = TraverseBatch(1, task={**SHORT, "observation_clip": 0.5}, scenario=SEA, helicopter=HELICOPTER)
    env.reset(seeds=[4])
    result = env.step([[0.2, 0.0]])
    assert np.max(np.abs(result.observation)) == 0.5
    assert result.clipped[0] == np.count_nonzero(np.abs(result.observation) == 0.5) > 3


def test_noise_has_its_level_and_spares_what_is_known() -> None:
    """Over many helicopters at rest each sensor scatters by its nominal deviation times the factor."""
    n = 600
    quiet = make(1, {"base": "flat"})
    noisy = make(n, {"base": "flat", "sensors": {"noise": 2.0}})
    true = quiet.reset(seeds=[0])[0]
    scatter = noisy.reset(seeds=list(range(n))) - true
    deviation = np.array([2.0 * term.noise / term.scale for term in noisy.observer.terms])
    found = np.sqrt(np.mean(scatter.astype(float) ** 2, axis=0))
    known = deviation == 0.0
    assert np.max(np.abs(scatter[:, known])) == 0.0
    assert found[~known] == pytest.approx(deviation[~known], rel=0.15)


def test_delay_gives_the_past() -> None:
    """A sensor of age d reads what was d ago, interpolated between control instants."""
    interval = 0.1
    for delay, expected in ((0.0, [1.0, 4.0, 9.0]), (0.1, [0.0, 1.0, 4.0]), (0.15, [0.0, 0.5, 2.5])):
        bank = SensorBank(2, np.zeros(1), 0.2, interval, noisy=False)
        columns = np.array([1])
        assert bank.start(columns, [0], [0.0], [delay], np.zeros((1, 1))) == 0.0
        read = [float(bank.read(columns, np.full((1, 1), value))[0, 0]) for value in (1.0, 4.0, 9.0)]
        assert read == pytest.approx(expected)


def test_the_future_is_not_observed() -> None:
    """Two seas that differ only later give the same observations until then."""
    env, other = make(1), make(1)
    env.reset(seeds=[5]), other.reset(seeds=[5])
    now = int(env.batch.time_s[0] / env.batch.timing.node_spacing_s)
    other.batch._nodes[0, now + 2 :] += 1e-3
    same = other.batch.nodes[0, now + 1] - env.batch.nodes[0, now + 1]
    assert not same.any()
    for k in range(2):
        a, b = env.step([[0.3, 0.1]]), other.step([[0.3, 0.1]])
        assert np.array_equal(a.observation, b.observation), k
    for _ in range(4):
        a, b = env.step([[0.3, 0.1]]), other.step([[0.3, 0.1]])
    assert not np.array_equal(a.observation, b.observation)


def test_the_environments_page_lists_every_term() -> None:
    """docs/environments/traverse.md names each term of the observation with its scale."""
    page = (Path(__file__).parents[2] / "docs" / "environments" / "traverse.md").read_text(encoding="utf-8")
    for term in chosen_terms("full"):
        meaning = term.meaning.replace("|", r"\|")  # else it ends the table's cell
        assert f"| `{term.name}` | {meaning} | {term.unit} | {term.scale:g} | {term.noise:g} |" in page, term.name


def test_default_scenario_has_noise() -> None:
    assert load_scenario().bounds("sensors.noise") == (0.5, 1.5)
