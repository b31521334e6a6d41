"""Settling: an equilibrium, exactly, wherever there is one; and an honest answer where there is none."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.layout import (
    SPEEDS,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    TIRES,
    Deck,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation import settle as settling
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.vehicle import load_helicopter

HELICOPTERS = ("generic_tricycle", "seahawk_like")
WHEELS = ("auxiliary", "right", "left")
SLOPES = [{"pitch_deg": 5.0}, {"roll_deg": 5.0}, {"roll_deg": -4.0, "pitch_deg": -3.0}]


def on_a_slope(name: str, n: int = 1, *, locked: bool, held: bool, **angles: float) -> Batch:
    batch = Batch(load_helicopter(name), n)
    batch.parameters[Par.PROBE_ACTIVE] = float(held)
    if locked:
        for i in range(STATIONS):
            batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] = 1.0
    batch.set_motion([Fixed(**angles).bake(1.0, batch.timing.node_spacing_s)] * n)
    return batch


def assert_it_stays(batch: Batch, tolerance: float = 1e-8) -> None:
    """Ten seconds later all stands where it stood, and the loads are what they were."""
    batch.evaluate()
    state, outputs = batch.state.copy(), batch.telemetry.outputs.copy()
    batch.advance(intervals=100)
    assert np.max(np.abs(batch.state - state)[: State.TIRE]) < tolerance
    np.testing.assert_allclose(batch.telemetry.outputs, outputs, rtol=1e-5, atol=0.1)


def weight(batch: Batch) -> np.ndarray:
    masses = [Par.MASS] + [Par.STATION + i * STATION_ROWS + Sta.MASS for i in range(STATIONS)]
    return np.sum(batch.parameters[masses], axis=0) * batch.parameters[Par.GRAVITY]


def loads(batch: Batch, kind: str = "vertical") -> np.ndarray:
    return np.array([batch.telemetry[f"{wheel}_{kind}_load"] for wheel in WHEELS])


# --- level deck ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_level_whatever_the_mass_and_the_pressure(name: str) -> None:
    batch = on_a_slope(name, 8, locked=False, held=False)
    rng = np.random.default_rng(6)
    batch.parameters[Par.MASS] *= rng.uniform(0.75, 1.2, 8)
    for t in range(TIRES):
        row = TIRE_PAR + t * TIRE_ROWS + Tir.P_O
        pressure = batch.parameters[row] * rng.uniform(0.6, 1.3, 8)
        batch.parameters[TIRE_PAR + t * TIRE_ROWS + Tir.P_ABS] += pressure - batch.parameters[row]
        batch.parameters[row] = pressure
    for i in range(STATIONS):
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.MOUNT] += rng.uniform(-0.1, 0.1, 8)
    assert np.all(batch.settle() < 2e-5)  # port and starboard differ: a castored wheel on its camber rolls for ever
    assert_it_stays(batch, 1e-3)
    np.testing.assert_allclose(np.sum(loads(batch), axis=0), weight(batch), rtol=1e-6)
    assert np.ptp(batch.telemetry["position_z"]) > 0.01


@pytest.mark.parametrize("name", HELICOPTERS)
def test_it_is_found_from_any_height_and_attitude(name: str) -> None:
    batch = on_a_slope(name, 4, locked=False, held=False)
    batch.state[State.Q10] += [0.0, -3.0, 0.3, 0.0]
    half = 0.5 * np.deg2rad([0.0, 4.0, -3.0, 8.0])
    batch.state[State.Q11], batch.state[State.Q12] = np.cos(half), np.sin(half)
    batch.state[:SPEEDS] = 0.5
    assert np.all(batch.settle() < 1e-6)
    assert not np.any(batch.state[:SPEEDS])
    for row in (State.Q10, State.Q12, State.Q15, State.Q20, State.Q21 + 1):
        assert np.ptp(batch.state[row]) < 1e-5


# --- slopes ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angles", SLOPES)
@pytest.mark.parametrize("name", HELICOPTERS)
def test_locked_wheels_hold_on_a_slope(name: str, angles: dict[str, float]) -> None:
    batch = on_a_slope(name, locked=True, held=False, **angles)
    batch.parameters[Par.LOCK + State.U14] = 1.0
    assert np.all(batch.settle() < 1e-6)
    deck = batch.deck_rows(np.array([0]))[Deck.R_NS : Deck.R_NS + 9, 0].reshape(3, 3)
    normal = weight(batch)[0] * deck[2, 2]
    batch.evaluate()
    assert np.sum(loads(batch)) == pytest.approx(normal, rel=1e-9)
    along, across = np.sum(loads(batch, "longitudinal")), np.sum(loads(batch, "lateral"))
    assert np.hypot(along, across) == pytest.approx(weight(batch)[0] * np.hypot(deck[2, 0], deck[2, 1]), rel=1e-5)
    assert_it_stays(batch)


@pytest.mark.parametrize("angles", SLOPES)
@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_probe_holds_what_would_roll_away(name: str, angles: dict[str, float]) -> None:
    batch = on_a_slope(name, locked=False, held=True, **angles)
    assert np.all(batch.place(0.0, 0.0, 0.03) < 1e-6)
    assert batch.telemetry["probe_captured"][0] == 1.0 and batch.telemetry["probe_lost"][0] == 0.0
    if "pitch_deg" in angles:
        slope = weight(batch)[0] * np.sin(np.deg2rad(angles["pitch_deg"]))
        assert batch.telemetry["probe_fx"][0] == pytest.approx(slope, rel=0.05)
    assert np.hypot(batch.telemetry["probe_x"], batch.telemetry["probe_y"])[0] < 0.02  # it gives by its stiffness
    assert_it_stays(batch)
    before = batch.state.copy()
    assert np.all(batch.settle() < 1e-6)
    assert batch.telemetry["probe_captured"][0] == 1.0 and batch.telemetry["probe_lost"][0] == 0.0
    assert np.max(np.abs(batch.state - before)[State.Q8 : State.TIRE]) < 0.05  # tires hold many a rest


@pytest.mark.parametrize("name", HELICOPTERS)
def test_what_is_free_to_roll_down_is_told_so(name: str) -> None:
    batch = on_a_slope(name, locked=False, held=False, pitch_deg=5.0)
    left = batch.settle()
    assert left[0] == pytest.approx(9.81 * np.sin(np.deg2rad(5.0)), rel=0.05)  # it would start like that
    assert np.all(np.isfinite(batch.state)) and abs(batch.state[State.Q8, 0]) < 0.5
    batch.evaluate()
    assert np.sum(loads(batch)) == pytest.approx(weight(batch)[0] * np.cos(np.deg2rad(5.0)), rel=0.01)


def test_too_steep_for_the_tires_is_told_so() -> None:
    batch = on_a_slope("generic_tricycle", locked=True, held=False, pitch_deg=50.0)
    assert batch.settle()[0] > 0.1
    assert np.all(np.isfinite(batch.state))


def test_in_the_wind() -> None:
    batch = on_a_slope("generic_tricycle", 2, locked=True, held=False)
    batch.parameters[Par.WIND + 1] = [0.0, 20.0]
    assert np.all(batch.settle() < 1e-6)
    batch.evaluate()
    side = np.sum(loads(batch, "lateral"), axis=0)
    assert side[1] == pytest.approx(-batch.telemetry["wind_fy"][1], rel=0.01) and abs(side[0]) < 1e-3
    assert batch.telemetry["wind_fy"][1] == pytest.approx(0.5 * 1.225 * 20.0 * 20.0**2, rel=0.02)
    assert_it_stays(batch)


# --- what it leaves alone --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_column_settles_as_it_would_alone(name: str) -> None:
    """Bit for bit, on a slope too, where some have long found their rest while others still look."""
    whole = on_a_slope(name, 5, locked=True, held=False, roll_deg=4.0)
    whole.parameters[Par.MASS] *= [1.0, 0.8, 1.1, 0.9, 1.2]
    alone, pair = whole.fork(1), whole.fork(1)
    whole.settle()
    pair.settle([4, 1])
    for k in range(5):
        alone.settle([k])
    assert np.array_equal(alone.state, whole.state)
    assert np.array_equal(pair.state[:, [1, 4]], whole.state[:, [1, 4]])


@pytest.mark.parametrize("held", [True, False])
def test_only_the_state_of_its_columns_is_changed(held: bool) -> None:
    batch = on_a_slope("generic_tricycle", 3, locked=False, held=held, pitch_deg=3.0)
    batch.state[State.CLAW_VX] = 0.1  # a moving claw is looked at as it stands
    batch.advance([[0.5, 0.0]] * 3)
    saved = batch.snapshot()
    batch.settle([1])
    for name, before in saved.arrays.items():
        after = batch.snapshot().arrays[name]
        if name == "state":
            assert np.array_equal(after[:, [0, 2]], before[:, [0, 2]])
            assert np.array_equal(after[State.CLAW_X :, 1], before[State.CLAW_X :, 1])
            assert not np.array_equal(after[: State.TIRE, 1], before[: State.TIRE, 1])
        else:
            assert np.array_equal(after, before), name


def test_a_tilted_moving_deck_is_taken_as_it_stands() -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 2)
    moving = Sinusoid(dof="roll", amplitude_deg=6.0, period_s=8.0).bake(6.0, 0.25)
    batch.set_motion([moving, Fixed(roll_deg=6.0).bake(6.0, 0.25)])
    batch.clocks[:] = 1000  # a quarter period: 6 degrees, at rest
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    np.testing.assert_allclose(batch.state[: State.TIRE, 0], batch.state[: State.TIRE, 1], rtol=0.0, atol=1e-6)


def test_a_prescribed_and_a_rippling_claw() -> None:
    """Settled against the claw where its history has it; against the drive's place, its ripple left out."""
    nodes = np.zeros((1, 2, 9))
    nodes[0, :, 0] = 0.004
    prescribed = Batch(load_helicopter("generic_tricycle"), 1, modes=Modes(claw="prescribed"))
    commanded = Batch(load_helicopter("generic_tricycle"), 1, claw=ClawLimits(ripple_along_m=0.003))
    for batch in (prescribed, commanded):
        batch.place(0.0, 0.0, 0.0)
    prescribed.prescribe_claw(nodes)
    commanded.state[State.CLAW_X] = 0.004
    commanded.parameters[Par.RIPPLE_PHASE] = 0.5
    for batch in (prescribed, commanded):
        assert np.all(batch.settle() < 1e-6)
    np.testing.assert_allclose(commanded.state[: State.TIRE], prescribed.state[: State.TIRE], rtol=0.0, atol=1e-9)
    assert prescribed.state[State.Q8, 0] > 0.003 - 0.03  # wheels roll: the probe is pulled over the claw
    assert abs(prescribed.evaluate()["probe_in_plane"][0]) < 1.0


def test_remaining_is_the_acceleration_at_rest() -> None:
    batch = on_a_slope("generic_tricycle", locked=False, held=False)
    batch.settle()
    batch.parameters[Par.WRENCH_H + 2] = 1000.0
    rates = engine.derivative(batch.state, batch.parameters, batch.mode, batch.deck_rows(np.array([0])))[0]
    assert settling.remaining(batch, np.array([0]))[0] == np.max(np.abs(rates[:SPEEDS]))
    assert 0.05 < rates[State.U9, 0] < 0.2  # a tenth of a ton on ten
