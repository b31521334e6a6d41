"""One substep and many: order, stiffness, unit quaternions, peaks, and what happens when all goes wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.channels import OUTPUT_ROWS
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    ODE_ROWS,
    SPEEDS,
    STATE_ROWS,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    TIRES,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.dynamics.stepper import ABSURD, accept, normalise, record_peaks, total_size
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.simulation.batch import Batch, ClawLimits, Timing
from ssmash_gym.simulation.settle import lower
from ssmash_gym.vehicle import load_helicopter, with_changes

HELICOPTERS = ("generic_tricycle", "seahawk_like")
QUATERNIONS = [int(State.Q11), int(State.Q16), int(State.Q21), int(State.Q26)]
LINEAR = {"type": "linear_strut", "stiffness_Npm": 2.1e5, "damping_Nspm": 1.3e4}


def finite(batch: Batch) -> bool:
    """Nothing that can be read is anything but a number."""
    telemetry = batch.telemetry
    tables = (batch.state, telemetry.outputs, telemetry.highs, telemetry.lows)
    return all(bool(np.all(np.isfinite(table))) for table in tables)


# --- parts ---------------------------------------------------------------------------------------------------------


def test_normalise_makes_unit_quaternions_and_touches_nothing_else() -> None:
    y = np.random.default_rng(1).normal(size=(STATE_ROWS, 3))
    before = y.copy()
    uncompiled(normalise)(y)
    rows = [row + k for row in QUATERNIONS for k in range(4)]
    others = np.delete(np.arange(STATE_ROWS), rows)
    assert np.array_equal(y[others], before[others])
    for row in QUATERNIONS:
        old, new = before[row : row + 4], y[row : row + 4]
        np.testing.assert_allclose(np.linalg.norm(new, axis=0), 1.0, rtol=1e-15)
        np.testing.assert_allclose(new * np.linalg.norm(old, axis=0), old, rtol=1e-14)


def test_peaks_are_running_extremes() -> None:
    rows = np.random.default_rng(2).normal(size=(5, OUTPUT_ROWS, 2))
    high, low = np.full((OUTPUT_ROWS, 2), -np.inf), np.full((OUTPUT_ROWS, 2), np.inf)
    for o in rows:
        uncompiled(record_peaks)(o, high, low)
    assert np.array_equal(high, rows.max(axis=0)) and np.array_equal(low, rows.min(axis=0))


def test_total_size_counts_every_integrated_row() -> None:
    y = np.zeros((STATE_ROWS, ODE_ROWS))
    y[np.arange(ODE_ROWS), np.arange(ODE_ROWS)] = -2.0
    assert np.array_equal(uncompiled(total_size)(y), np.full(ODE_ROWS, 2.0))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 2.0 * ABSURD])
def test_a_bad_row_is_named_and_the_sound_state_kept(bad: float) -> None:
    y, trial = np.zeros((STATE_ROWS, 3)), np.ones((STATE_ROWS, 3))
    y[State.PROBE_CAPTURED] = 1.0
    trial[State.Q9, 1] = bad
    trial[State.Q21, 1] = np.nan
    y[State.DIVERGED, 2], y[State.DIVERGED_CLOCK, 2], y[State.DIVERGED_VALUE, 2] = 3.0, 11.0, 7.0  # gone long ago
    uncompiled(accept)(y, trial.copy(), np.full(3, 40.0))
    assert np.array_equal(y[: State.PROBE_CAPTURED, 0], trial[: State.PROBE_CAPTURED, 0])
    assert not np.any(y[: State.PROBE_CAPTURED, 1:])
    assert y[State.DIVERGED].tolist() == [0.0, State.Q9 + 1.0, 3.0]  # the first of the two
    assert y[State.DIVERGED_CLOCK].tolist() == [0.0, 40.0, 11.0]
    kept = 0.0 if np.isnan(bad) else float(np.clip(bad, -1e308, 1e308))
    assert y[State.DIVERGED_VALUE].tolist() == [0.0, kept, 7.0]
    assert np.all(y[State.PROBE_CAPTURED] == 1.0)


# --- the scheme ----------------------------------------------------------------------------------------------------


def swinging(substep: float, **rows: Any) -> Batch:
    """Struts and tires linear, wheels free: nothing but smooth motion."""
    helicopter = with_changes(
        load_helicopter("generic_tricycle"),
        {"tire_model": "linear", **{f"stations.{name}.spring": LINEAR for name in ("auxiliary", "right", "left")}},
    )
    batch = Batch(helicopter, 1, timing=Timing(substep, 0.1))
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(0.0, 0.0, 0.0)
    for name, value in rows.items():
        for i in range(STATIONS):
            batch.parameters[Par.STATION + i * STATION_ROWS + Sta[name]] = value
    batch.state[:SPEEDS] = 0.0
    batch.state[State.U9] = 0.15
    batch.state[State.U10] = 0.05
    return batch


def test_second_order_on_smooth_motion() -> None:
    """Richardson: halving the step divides the change by about four."""
    ends = []
    for substep in (0.001, 0.0005, 0.00025):
        batch = swinging(substep)
        batch.advance(intervals=5)
        ends.append(batch.state[:ODE_ROWS, 0].copy())
    ratio = np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2])
    assert 3.48 < ratio < 4.59  # order 1.8 to 2.2


@pytest.mark.parametrize("damping", [1e6, 1e8, 1e10])
def test_any_damping_of_a_joint_is_stable(damping: float) -> None:
    """A carriage of 170 kg on 1e10 N s/m: a rate of 6e7 1/s, where an explicit step of 2 ms needs less than 1e3."""
    batch = swinging(0.002, LINEAR_C=damping)
    for _ in range(10):
        telemetry = batch.advance()
        rates = [telemetry.peak_abs(f"{name}_compression_rate")[0] for name in ("auxiliary", "right", "left")]
    assert max(rates) < 2.0e6 / damping  # as good as rigid: some 1e5 N over the damping
    assert finite(batch) and not batch.diverged[0]


@pytest.mark.parametrize("name", HELICOPTERS)
def test_quaternions_stay_unit_for_a_minute_at_sea(name: str) -> None:
    batch = Batch(load_helicopter(name), 1)
    batch.place(0.0, 0.0, 0.1)
    table = Sinusoid(dof="roll", amplitude_deg=6.0, period_s=9.0).bake(61.0, batch.timing.node_spacing_s, ramp_s=5.0)
    batch.set_motion([table])
    batch.advance(intervals=600)
    for row in QUATERNIONS:
        assert np.linalg.norm(batch.state[row : row + 4, 0]) == pytest.approx(1.0, abs=1e-15)


def test_peaks_cover_every_substep_of_the_interval() -> None:
    """Against the same run with a control interval of one substep."""
    whole, fine = (Batch(load_helicopter("generic_tricycle"), 1, timing=Timing(0.002, c)) for c in (0.1, 0.002))
    seen = []
    for batch in (whole, fine):
        batch.parameters[Par.CLAW_DELAY] = 0.0
        batch.place(0.0, 0.0, 0.0)
        batch.state[State.U9] = -0.4
    whole.advance([[1.0, 0.0]])
    for _ in range(50):
        telemetry = fine.advance([[1.0, 0.0]])
        seen.append(np.stack([telemetry.highs[:, 0], telemetry.lows[:, 0], telemetry.outputs[:, 0]]))
    seen = np.array(seen)
    assert np.array_equal(whole.state, fine.state)
    assert np.array_equal(whole.telemetry.highs[:, 0], seen[:, 0].max(axis=0))
    assert np.array_equal(whole.telemetry.lows[:, 0], seen[:, 1].min(axis=0))
    assert np.array_equal(whole.telemetry.outputs[:, 0], seen[-1, 2])


# --- when all goes wrong -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_drop_bounces_and_comes_to_rest(name: str) -> None:
    batch = Batch(load_helicopter(name), 1)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.state[State.Q10] -= 0.8  # 0.8 m above its droop, 4 m/s at touchdown
    air, height = [], []
    for _ in range(80):
        telemetry = batch.advance()
        loads = [telemetry[f"{wheel}_vertical_load"][0] for wheel in ("auxiliary", "right", "left")]
        air.append(sum(loads) == 0.0)
        height.append(telemetry["position_z"][0])
        assert finite(batch) and not batch.diverged[0]
    assert air[0] and not air[-1]
    landed = air.index(False)
    assert any(air[landed:]) or max(height[landed:]) > height[-1] + 0.02  # off the deck again, or deep in its struts
    assert np.ptp(height[-5:]) < 0.01


@pytest.mark.parametrize("name", HELICOPTERS)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_tips_over_and_lies_there(name: str, side: float) -> None:
    """A side wrench that no track can take: over the wheels, far beyond the 25 degrees at which a task ends."""
    batch = Batch(load_helicopter(name), 1)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(0.0, 0.0, 0.0)
    batch.parameters[Par.WRENCH_H + 3] = side * 4.0e5
    roll = []
    for _ in range(40):
        batch.advance()
        roll.append(np.rad2deg(batch.telemetry["roll"][0]) * side)
        assert finite(batch)
    assert max(roll) > 60.0


@pytest.mark.parametrize("name", HELICOPTERS)
def test_from_an_initial_roll_it_falls_back_or_over(name: str) -> None:
    """On one main wheel; the c.g. is over that wheel at about 35 degrees."""
    batch = Batch(load_helicopter(name), 4)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(0.0, 0.0, 0.0)
    half = 0.5 * np.deg2rad([15.0, 25.0, 45.0, 50.0])
    batch.state[State.Q11], batch.state[State.Q12] = np.cos(half), np.sin(half)
    lower(batch, np.arange(4))
    roll = []
    for _ in range(40):
        batch.advance()
        roll.append(np.abs(np.rad2deg(batch.telemetry["roll"])))
        assert finite(batch)
    assert np.all(roll[-1][:2] < 6.0) and np.all(np.max(roll, axis=0)[:2] < 25.0)
    assert np.all(np.max(roll, axis=0)[2:] > 90.0)


def test_off_the_deck_it_flies_as_thrown() -> None:
    """In the air, without wind drag, the c.g. of the whole follows the parabola."""
    batch = Batch(load_helicopter("seahawk_like"), 1)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.parameters[Par.AIR_DENSITY] = 0.0
    batch.parameters[Par.LOCK + 6 : Par.LOCK + SPEEDS] = 1.0  # rigid: body and whole fall alike
    batch.state[State.Q10] -= 30.0
    start = batch.state[State.Q8 : State.Q10 + 1, 0].copy()
    throw = np.array([3.0, -1.0, -4.0])
    batch.state[State.U7 : State.U9 + 1, 0] = throw
    batch.advance(intervals=10)
    expected = start + throw + [0.0, 0.0, 0.5 * 9.81]
    np.testing.assert_allclose(batch.state[State.Q8 : State.Q10 + 1, 0], expected, rtol=0.0, atol=1e-9)


INSANE = {
    "struts": [Par.STATION + i * STATION_ROWS + Sta.GAS_P for i in range(STATIONS)],
    "stops": [Par.STATION + i * STATION_ROWS + Sta.STOP_K for i in range(STATIONS)],
    "dampers": [Par.STATION + i * STATION_ROWS + Sta.C2 for i in range(STATIONS)],
    "tires": [TIRE_PAR + t * TIRE_ROWS + Tir.P_O for t in range(TIRES)],
    "tire dampers": [TIRE_PAR + t * TIRE_ROWS + Tir.CY for t in range(TIRES)],
    "probe": [Par.PROBE_KS_X, Par.PROBE_KS_Y, Par.PROBE_KL_X, Par.PROBE_KL_Y, Par.PROBE_ULTIMATE],
    "gravity": [Par.GRAVITY],
    "wind": [Par.WIND + 1],
    "inertia": [Par.IXX, Par.IYY, Par.IZZ],
}


@settings(max_examples=15, deadline=None)
@given(
    name=st.sampled_from(HELICOPTERS),
    what=st.sampled_from(sorted(INSANE)),
    factor=st.sampled_from([1e-6, 1e3, 1e6, 1e9]),
    seed=st.integers(0, 1000),
)
def test_insane_parameters_give_numbers_and_leave_the_neighbours_alone(
    name: str, what: str, factor: float, seed: int
) -> None:
    """Column 1 of three goes mad (wind: 5 m/s times the factor); its neighbours keep the bits they have without it."""
    mad = Batch(load_helicopter(name), 3, claw=ClawLimits(delay_s=0.0))
    mad.place(0.0, 0.0, [0.0, 0.05, -0.05])
    mad.parameters[Par.WIND + 1] = 5.0
    sane = mad.fork(1)
    mad.parameters[INSANE[what], 1] *= factor
    rng = np.random.default_rng(seed)
    mad.state[:SPEEDS, 1] += rng.normal(size=SPEEDS) * (mad.parameters[Par.LOCK : Par.LOCK + SPEEDS, 1] == 0.0)
    for _ in range(8):
        command = rng.uniform(-1.0, 1.0, (3, 2))
        mad.advance(command)
        sane.advance(command)
        assert finite(mad)
    for a, b in ((mad.state, sane.state), (mad.telemetry.highs, sane.telemetry.highs)):
        assert np.array_equal(a[:, [0, 2]], b[:, [0, 2]])
    assert mad.clocks.tolist() == [400, 400, 400]


def test_divergence_is_caught_once_told_and_held() -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 3, claw=ClawLimits(delay_s=0.0))
    batch.place(0.0, 0.0, 0.0)
    batch.advance(intervals=2)
    for i in range(STATIONS):
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.GAS_P, 1] *= 1e6
    for _ in range(5):
        batch.advance([[0.5, 0.0]] * 3)
    assert batch.diverged.tolist() == [False, True, False]
    row, clock = batch.state[State.DIVERGED, 1] - 1, batch.state[State.DIVERGED_CLOCK, 1]
    assert row == int(row) and 0 <= row < ODE_ROWS
    assert 100 <= clock < 350
    assert abs(batch.state[State.DIVERGED_VALUE, 1]) >= ABSURD / ODE_ROWS  # the one that was refused, not the one held
    held = batch.state[:, 1].copy()
    assert finite(batch) and np.sum(np.abs(held[:ODE_ROWS])) < ABSURD
    batch.advance([[0.5, 0.0]] * 3, intervals=3)
    assert np.array_equal(batch.state[:, 1], held)  # claw and all
    assert batch.clocks.tolist() == [500, 500, 500]
    assert batch.telemetry["claw_x"][0] > held[State.CLAW_X]
    batch.parameters[:, 1] = batch.parameters[:, 0]
    batch.place(0.0, 0.0, 0.0, [1])
    assert not batch.diverged[1]


def test_a_state_that_is_no_number_is_never_passed_on() -> None:
    batch = Batch(load_helicopter("generic_tricycle"), 2)
    batch.place(0.0, 0.0, 0.0)
    batch.set_motion([Fixed().bake(1.0, 0.25)] * 2)
    twin = batch.fork(1)
    batch.parameters[Par.WRENCH_H, 0] = np.inf  # the first step is not finite
    batch.advance()
    twin.advance()
    assert batch.diverged.tolist() == [True, False]
    assert batch.state[State.DIVERGED_CLOCK, 0] == 0.0
    assert np.array_equal(batch.state[:, 1], twin.state[:, 1])
    assert np.all(np.isfinite(batch.state))
