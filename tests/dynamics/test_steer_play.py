"""A helicopter whose locked steering has free play: rest, motion within the play and against its stops."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.channels import STATION_OUT, StaOut
from ssmash_gym.dynamics.layout import STATIONS, Mode, Par, Sta, State
from ssmash_gym.dynamics.reference import Problem, integrate
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes
from ssmash_gym.vehicle.station import FASTEST_STOP_RADPS, LEAST_STOP_DAMPING
from tests.dynamics.on_deck import PROMPT, brake

HELICOPTERS = ("generic_tricycle", "seahawk_like")
PLAY = 0.0175
STEER = STATION_OUT + StaOut.STEER


def with_play(name: str, play: float = PLAY, stiffness: float = 1.5e5, damping: float = 500.0) -> Helicopter:
    section = {"play_rad": play, "stop_stiffness_Nmprad": stiffness, "stop_damping_Nmspr": damping}
    return locked(name, {"stations.auxiliary.steer_play": section})


def locked(name: str, changes: dict[str, Any] | None = None) -> Helicopter:
    return with_changes(load_helicopter(name), {"stations.auxiliary.steering": "locked", **(changes or {})})


def traverse(helicopter: Helicopter, intervals: int = 60) -> tuple[np.ndarray, np.ndarray, Batch]:
    """Steer angle and lateral load of the auxiliary station over a traverse with lateral claw motion, least, most."""
    batch = Batch(helicopter, 1, claw=PROMPT)
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=5.0, period_s=6.0).bake(12.0, 0.25)])
    batch.place(0.0, 0.0, 0.0)
    extremes = []
    for k in range(intervals):
        read = batch.advance([[0.4, 0.6 if k % 20 < 10 else -0.6]])
        names = ("auxiliary_steer", "auxiliary_lateral_load")
        extremes.append([(read.peak_min(name)[0], read.peak_max(name)[0]) for name in names])
    found = np.array(extremes)
    assert not batch.diverged[0]
    return found[:, 0], found[:, 1], batch


@pytest.mark.parametrize("name", HELICOPTERS)
def test_the_wheel_steers_within_its_play_and_leans_on_the_stops(name: str) -> None:
    steer, load, batch = traverse(with_play(name))
    assert batch.parameters[Par.LOCK + State.U14, 0] == 0.0
    assert np.min(steer) < -PLAY and PLAY < np.max(steer) < 3.0 * PLAY
    assert np.max(np.abs(traverse(locked(name))[0])) == 0.0
    assert np.max(np.abs(load)) > 2000.0


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_stiff_lock_without_play_is_a_lock(name: str) -> None:
    """The stiffer, the nearer: steer angle and lateral loads come to those of the locked steering."""
    exact = traverse(locked(name))[1]
    errors, angles = [], []
    for stiffness in (3.0e4, 3.0e5):
        steer, load, _ = traverse(with_play(name, 0.0, stiffness))
        errors.append(np.max(np.abs(load - exact)))
        angles.append(np.max(np.abs(steer)))
    assert angles[1] < 0.15 * angles[0]
    assert errors[1] < 0.2 * errors[0]
    assert errors[1] < 0.02 * np.max(np.abs(exact))


@pytest.mark.parametrize("name", HELICOPTERS)
def test_it_comes_to_rest_within_its_play(name: str) -> None:
    batch = Batch(with_play(name), 3, claw=PROMPT)
    assert np.all(batch.place(0.0, 0.0, [0.0, 0.1, -0.15]) < 1e-6)
    assert np.all(np.abs(batch.telemetry["auxiliary_steer"]) <= PLAY)
    batch.advance(intervals=5)
    assert np.all(np.abs(batch.state[State.U14]) < 1e-4)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_on_a_slope_the_wheel_rests_in_its_play_or_against_a_stop(name: str) -> None:
    batch = Batch(with_play(name), 2, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    brake(batch)
    batch.set_motion([Fixed(roll_deg=side * 5.0).bake(1.0, 0.25) for side in (1.0, -1.0)])
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    steer = batch.telemetry["auxiliary_steer"].copy()
    np.testing.assert_allclose(steer[0], -steer[1], rtol=0.1)
    assert np.all(np.abs(steer) < 1.5 * PLAY) and abs(steer[0]) > 1e-5
    batch.advance(intervals=10)
    np.testing.assert_allclose(batch.telemetry["auxiliary_steer"], steer, atol=1e-5)


def test_all_three_stations_may_have_it() -> None:
    section = {"play_rad": 0.01, "stop_stiffness_Nmprad": 1.0e5, "stop_damping_Nmspr": 200.0}
    helicopter = locked("generic_tricycle", {"stations.*.steer_play": section})
    batch = Batch(helicopter, 1, claw=PROMPT)
    assert list(batch.mode[Mode.PLAY : Mode.PLAY + STATIONS]) == [1, 1, 1]
    batch.place(0.0, 0.0, 0.05)
    for _ in range(10):
        batch.advance([[0.3, 0.8]])
    steer = [abs(batch.telemetry[f"{station}_steer"][0]) for station in ("auxiliary", "right", "left")]
    assert np.all(np.array(steer) > 1e-4) and max(steer) < 0.03


@pytest.mark.parametrize("name", HELICOPTERS)
def test_the_engine_comes_to_the_reference(name: str) -> None:
    """Against the stops, at the usual step: the steer angle and its extremes within half a percent."""
    batch = Batch(with_play(name, damping=120.0), 1, claw=PROMPT)
    batch.place(0.0, 0.0, 0.1)
    commands = np.tile([0.5, 0.9], (8, 1))
    timing = batch.timing
    start = Problem(
        batch.state[:, 0].copy(), batch.parameters[:, 0].copy(), batch.mode, batch.nodes[0].copy(),
        batch.claw_nodes[0].copy(), commands, timing.substep_s, timing.substeps, timing.substeps_per_node,
    )  # fmt: skip
    expected = integrate(start, "Adams", rtol=1e-8, atol=1e-10).outputs[STEER]
    found, extremes = [], []
    for k, command in enumerate(commands):
        read = batch.advance(command[None])
        found.append((read["auxiliary_steer"][0], expected[50 * (k + 1)]))
        extremes.append(max(read.peak_max("auxiliary_steer")[0], -read.peak_min("auxiliary_steer")[0]))
    assert np.max(np.abs(expected)) > PLAY
    np.testing.assert_allclose(*np.array(found).T, atol=0.005 * PLAY)
    assert max(extremes) == pytest.approx(np.max(np.abs(expected)), rel=0.005)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_against_the_stiffest_and_least_damped_stop_the_oscillation_dies_away(name: str) -> None:
    """In the air, without friction; where the stop's damping is taken out, the step itself feeds the oscillation."""
    inertia = load_helicopter(name).stations.auxiliary.inertia_kgm2[2][2]
    stiffness = FASTEST_STOP_RADPS**2 * inertia
    stop = {
        "play_rad": 0.0,
        "stop_stiffness_Nmprad": stiffness,
        "stop_damping_Nmspr": 2.0 * LEAST_STOP_DAMPING * np.sqrt(stiffness * inertia),
    }
    free = {"stations.auxiliary.steer_damping_Nmspr": 0.0, "stations.auxiliary.steer_friction_m": 0.0}
    batch = Batch(locked(name, {"stations.auxiliary.steer_play": stop, **free}), 2, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.parameters[Par.STATION + Sta.STEER_STOP_C, 1] = 0.0
    batch.state[State.Q10] -= 100.0
    batch.state[State.U14] = 0.5
    angles = [batch.advance().peak_max("auxiliary_steer").copy() for _ in range(15)]
    assert angles[-1][0] < 0.6 * angles[0][0]
    assert angles[-1][1] > 2.0 * angles[0][1]


def test_one_batch_has_one_layout() -> None:
    with pytest.raises(ConfigurationError, match="one layout"):
        Batch([locked("generic_tricycle"), with_play("generic_tricycle")])
