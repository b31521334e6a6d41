"""Every choice of model runs and is a choice; the probe disabled, captured and lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import (
    SPEEDS,
    Par,
    State,
)
from ssmash_gym.ship import Sinusoid
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes
from tests.dynamics.on_deck import PROMPT, WHEELS, at_rest, brake, loads, weight

HELICOPTERS = ("generic_tricycle", "seahawk_like")
LINEAR = {"type": "linear_strut", "stiffness_Npm": 2.1e5, "damping_Nspm": 1.3e4}


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


# --- every choice of model -----------------------------------------------------------------------------------------


def final_state(helicopter: Helicopter, modes: Modes | None = None) -> np.ndarray:
    """A sharp traverse with brakes on the mains, on a rolling deck, from one given state."""
    batch = Batch(helicopter, 1, modes=modes, claw=ClawLimits(delay_s=0.0, speed_across_m_s=0.3))
    if modes is not None and modes.claw == "prescribed":
        batch.prescribe_claw(np.zeros((1, 2, 9)))
    batch.place(0.0, 0.0, 0.05)
    brake(batch, (1, 2))
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=6.0, period_s=5.0).bake(4.0, 0.25)])
    for k in range(30):
        batch.advance([[0.5, 1.0 if k < 10 else -1.0]])
    assert not batch.diverged[0]
    assert np.all(np.isfinite(batch.state)) and np.all(np.isfinite(batch.telemetry.outputs))
    return batch.state[: State.TIRE, 0].copy()


@pytest.mark.parametrize("name", HELICOPTERS)
def test_every_mode_runs_and_is_a_choice(name: str) -> None:
    stages = {f"probe.{kind}_stiffness_{axis}_Npm": value for kind, axis, value in (
        ("small", "x", 6.0e5), ("small", "y", 3.0e5), ("large", "x", 2.0e6), ("large", "y", 1.2e6))}  # fmt: skip
    helicopter = with_changes(load_helicopter(name), {**stages, "probe.transition_x_m": 0.003})
    default = final_state(helicopter)
    others = [
        Modes(contact="centre"), Modes(friction="friction_circle"), Modes(friction="independent"),
        Modes(probe_law="ellipse"), Modes(probe_law="printed"), Modes(claw="prescribed"),
    ]  # fmt: skip
    found = [default] + [final_state(helicopter, modes) for modes in others]
    for i, a in enumerate(found):
        for b in found[:i]:
            assert np.max(np.abs(a - b)) > 1e-5
    assert np.array_equal(final_state(helicopter, Modes()), default)


@pytest.mark.parametrize(
    "changes",
    [
        {"tire_model": "linear"},
        {f"stations.{wheel}.spring": LINEAR for wheel in WHEELS},
        {"stations.auxiliary.spring": LINEAR, "tire_model": "linear"},
        {"stations.auxiliary.tires.0.type": "I", "stations.auxiliary.tires.1.type": "III"},
    ],
    ids=["linear tires", "linear struts", "mixed", "tire types"],
)
@pytest.mark.parametrize("name", HELICOPTERS)
def test_every_element_runs_and_carries_the_weight(name: str, changes: dict[str, Any]) -> None:
    helicopter = load_helicopter(name)
    changed = with_changes(helicopter, changes)
    batch = at_rest(with_changes(changed, {"probe.active": False}))
    assert np.sum(loads(batch)) == pytest.approx(weight(batch)[0], rel=1e-9)
    assert np.max(np.abs(final_state(changed) - final_state(helicopter))) > 1e-4


def test_single_tires_carry_what_twins_carried(tricycle: Helicopter) -> None:
    document = {f"stations.{wheel}.tires": [] for wheel in WHEELS}
    for wheel, station in zip(WHEELS, tricycle.station_tuple, strict=True):
        tire = station.tires[0].model_dump(mode="json")
        tire["position_m"] = [0.0, 0.0, 0.0]
        tire["pressure_Pa"] = 1.9 * tire["pressure_Pa"]
        document[f"stations.{wheel}.tires"] = [tire]
    single, twin = at_rest(with_changes(tricycle, document)), at_rest(tricycle)
    np.testing.assert_allclose(loads(single), loads(twin), rtol=0.02)
    deflections = [b.telemetry["right_tire_vertical_deflection"][0] for b in (single, twin)]
    assert deflections[0] == pytest.approx(deflections[1], rel=0.2)
    assert not np.any(single.state[State.TIRE + 3 : State.TIRE + 6])  # the second tire is not there


@pytest.mark.parametrize(("contact", "low", "high"), [("contact", 200.0, 1200.0), ("centre", -9000.0, -2000.0)])
def test_rolling_over_standing_tires_is_camber_not_a_side_step(
    tricycle: Helicopter, contact: str, low: float, high: float
) -> None:
    """All twelve speeds are prescribed by their locks: two degrees of roll about the deck under the nose wheel."""
    batch = at_rest(tricycle, modes=Modes(contact=contact))
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] = 1.0
    rate = np.deg2rad(2.0) / 0.5
    batch.state[:SPEEDS] = 0.0
    batch.state[State.U10] = rate
    batch.state[State.U8] = -rate * batch.state[State.Q10]  # the c.g. moves to starboard as the tires stand
    for _ in range(5):
        batch.advance()
    batch.state[:SPEEDS] = 0.0
    batch.evaluate()
    assert np.rad2deg(batch.telemetry["roll"][0]) == pytest.approx(2.0, abs=0.01)
    assert low < 0.5 * batch.telemetry["auxiliary_lateral_load"][0] < high  # a tire


# --- the probe: captured, disabled, lost -----------------------------------------------------------------------------


def test_a_disabled_probe_does_nothing(tricycle: Helicopter) -> None:
    batch = at_rest(with_changes(tricycle, {"probe.active": False}))
    x = batch.state[State.Q8, 0]
    for _ in range(10):
        telemetry = batch.advance([[1.0, 1.0]])
        assert telemetry.peak_max("probe_in_plane")[0] == 0.0 and telemetry.peak_max("probe_axial")[0] == 0.0
    assert batch.state[State.Q8, 0] == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_an_open_claw_captures_the_probe_it_passes_under(name: str) -> None:
    changes = {"probe.captured": False, "probe.capture_radius_m": 0.03}
    batch = Batch(with_changes(load_helicopter(name), changes), 2, claw=PROMPT)
    batch.place(0.0, 0.0, 0.0)
    batch.state[State.CLAW_X] = [-0.4, -0.4]
    batch.state[State.CLAW_Y] = [0.0, 0.04]  # the second passes beside the window
    captured = []
    for _ in range(40):
        gap = batch.telemetry["probe_x"] - batch.telemetry["claw_x"]
        telemetry = batch.advance([[1.0, 0.0]] * 2)
        captured.append(telemetry["probe_captured"][0])
        if captured[-1] == 0.0:
            assert telemetry.peak_max("probe_in_plane")[0] == 0.0
        elif captured[-2] == 0.0:
            assert 0.03 < gap[0] < 0.06  # it comes 0.03 m nearer in an interval
            assert 2.5e4 < telemetry.peak_max("probe_in_plane")[0] < 5.0e4  # 0.03 m at 1.22 MN/m
    assert captured[0] == 0.0 and captured[-1] == 1.0
    assert np.all(np.diff(captured) >= 0.0)  # for good
    assert batch.telemetry["probe_captured"][1] == 0.0
    assert batch.telemetry["position_x"][0] > batch.telemetry["position_x"][1] + 0.3


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_probe_that_hangs_above_the_claw_is_not_captured(name: str) -> None:
    changes = {"probe.captured": False, "probe.ultimate_load_N": 1e9}
    batch = Batch(with_changes(load_helicopter(name), changes), 1, claw=PROMPT)
    batch.place(0.0, 0.0, 0.0)
    batch.state[State.Q10] -= 0.3  # dropped from there, onto the claw
    captured, reach = [], []
    for _ in range(8):
        telemetry = batch.advance()
        captured.append(telemetry["probe_captured"][0])
        reach.append(telemetry.peak_min("probe_reach")[0])
        assert captured[-1] == (min(reach) <= 1.0)
    assert captured[0] == 0.0 and captured[-1] == 1.0


def test_above_its_ultimate_load_the_probe_is_lost_and_the_helicopter_free(tricycle: Helicopter) -> None:
    batch = Batch(with_changes(tricycle, {"probe.ultimate_load_N": 20000.0}), 1, claw=PROMPT)
    batch.place(0.0, 0.0, 0.0)
    brake(batch)
    peak, lost = 0.0, []
    for _ in range(20):
        telemetry = batch.advance([[1.0, 0.0]])
        peak = max(peak, telemetry.peak_max("probe_in_plane")[0])
        lost.append(telemetry["probe_lost"][0])
    assert 20000.0 < peak < 22000.0
    assert lost[0] == 0.0 and lost[-1] == 1.0 and np.all(np.diff(lost) >= 0.0)
    assert batch.telemetry["probe_captured"][0] == 0.0
    assert batch.telemetry["probe_in_plane"][0] == 0.0
    assert batch.telemetry["claw_x"][0] > batch.telemetry["probe_x"][0] + 0.2
    batch.state[State.CLAW_X] = batch.telemetry["probe_x"]
    batch.advance()
    assert batch.telemetry["probe_captured"][0] == 0.0  # a lost probe is not captured again
