"""The claw drive: limits, delay, exactness, ripple, prescribed histories."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics.claw import advance_claw, drive
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import PARAMETER_ROWS, STATE_ROWS, Par, State
from ssmash_gym.simulation.batch import Batch, ClawLimits, Timing
from ssmash_gym.simulation.parameters import Modes
from ssmash_gym.vehicle import Helicopter, load_helicopter

H = 0.002
SPEED, ACCEL, LOW, HIGH = (0.3, 0.1), (0.3, 0.2), (-0.5, -0.3), (8.5, 0.3)
plain_drive, plain_advance = uncompiled(drive), uncompiled(advance_claw)


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


def column(delay_s: float = 0.0, **rows: float) -> np.ndarray:
    p = np.zeros((PARAMETER_ROWS, 1))
    p[Par.CLAW_DELAY] = delay_s
    for axis in range(2):
        p[Par.CLAW_SPEED_X + axis], p[Par.CLAW_ACCEL_X + axis] = SPEED[axis], ACCEL[axis]
        p[Par.CLAW_X_MIN + 2 * axis], p[Par.CLAW_X_MAX + 2 * axis] = LOW[axis], HIGH[axis]
    for name, value in rows.items():
        p[Par[name]] = value
    return p


def run_drive(commands: np.ndarray, p: np.ndarray, substeps: int, start: tuple[Any, Any]) -> np.ndarray:
    """Rows claw x, y, vx, vy at every substep, (1 + intervals * substeps, 4, lanes), of `commands` (k, 2, lanes)."""
    interval, many = substeps * H, commands.shape[2]
    history = int(np.ceil(p[Par.CLAW_DELAY, 0] / interval - 1e-9)) + 1
    line, y = np.zeros((2 * history, many)), np.zeros((STATE_ROWS, many))
    y[State.CLAW_X], y[State.CLAW_Y] = start
    rows = [y[State.CLAW_X : State.CLAW_VY + 1].copy()]
    for command in commands:
        line[2:] = line[:-2].copy()
        line[:2] = command
        for s in range(substeps):
            after = y.copy()
            plain_advance(y, p, line, history, s * H, interval, H, after)
            y = after
            rows.append(y[State.CLAW_X : State.CLAW_VY + 1].copy())
    return np.array(rows)


# --- limits ----------------------------------------------------------------------------------------------------


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), bang=st.booleans(), delay=st.sampled_from([0.0, 0.03, 0.1]))
def test_no_limit_is_ever_exceeded(seed: int, bang: bool, delay: float) -> None:
    rng, many = np.random.default_rng(seed), 64
    commands = rng.uniform(-1.0, 1.0, (10, 2, many))
    commands = np.repeat(np.sign(commands) if bang else commands, rng.integers(2, 10), axis=0)
    start = (rng.uniform(LOW[0], LOW[0] + 0.5, many), rng.uniform(LOW[1], HIGH[1], many))  # ends are near
    rows = run_drive(commands, column(delay), 10, start)
    for axis in range(2):
        place, speed = rows[:, axis], rows[:, 2 + axis]
        assert np.all(place >= LOW[axis]) and np.all(place <= HIGH[axis])
        assert np.all(np.abs(speed) <= SPEED[axis] * (1.0 + 1e-12))
        assert np.all(np.abs(np.diff(speed, axis=0)) <= ACCEL[axis] * H * (1.0 + 1e-9) + 1e-15)
        # Position is the exact integral of the velocity, but for the stop at the end of the travel, which is met
        # within what one substep of braking covers.
        miss = np.abs(np.diff(place, axis=0) - 0.5 * H * (speed[:-1] + speed[1:]))
        at_end = (place[1:] == LOW[axis]) | (place[1:] == HIGH[axis])
        assert np.all(miss[~at_end] < 1e-14)
        assert np.all(miss[at_end] <= ACCEL[axis] * H * H / 8.0 + 1e-14)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_full_command_ends_at_rest_at_the_end_of_the_travel(direction: float) -> None:
    start = (8.0 if direction > 0.0 else 0.0, 0.0)
    rows = run_drive(np.full((40, 2, 1), direction), column(), 50, start)[:, :, 0]
    for axis in range(2):
        end = (HIGH if direction > 0.0 else LOW)[axis]
        assert abs(rows[-1, axis] - end) < 1e-5
        assert rows[-1, 2 + axis] == 0.0
        assert np.max(np.abs(rows[:, 2 + axis])) == pytest.approx(SPEED[axis], rel=1e-12)  # not a timid approach


def test_leaves_the_end_of_its_travel_when_asked() -> None:
    commands = np.repeat([1.0, -1.0], [5, 10])[:, None, None] * np.ones((1, 2, 1))
    rows = run_drive(commands, column(), 50, (HIGH[0], HIGH[1]))[:, :, 0]
    assert np.all(rows[: 5 * 50, :2] == [HIGH[0], HIGH[1]])
    assert rows[-1, 0] < HIGH[0] - 0.05 and rows[-1, 1] < HIGH[1] - 0.02


def test_outside_its_travel_it_stands_and_comes_back_only() -> None:
    out = np.array([9.0])
    accel, low, high = np.array([0.3]), np.array([LOW[0]]), np.array([HIGH[0]])
    x, v = plain_drive(out, np.array([0.0]), np.array([0.3]), accel, low, high, H)
    assert x[0] == 9.0 and v[0] == 0.0
    x, v = plain_drive(out, np.array([0.0]), np.array([-0.3]), accel, low, high, H)
    assert x[0] < 9.0 and v[0] == -0.3 * H


# --- delay -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.1, 0.2])
def test_delay_is_exact_to_the_substep(tricycle: Helicopter, delay: float) -> None:
    """A control interval of one substep shows every substep."""
    batch = Batch(tricycle, 1, timing=Timing(H, H), claw=ClawLimits(delay_s=delay))
    batch.place(0.0, 0.0, 0.0)
    moved = []
    for k in range(110):
        batch.advance([[1.0, -1.0]])
        moved.append(batch.telemetry["claw_vx"][0] != 0.0)
        assert (batch.telemetry["claw_vy"][0] != 0.0) == moved[-1]
        if k == 0:
            assert moved[0] == (delay == 0.0)
    assert moved.index(True) == round(delay / H)
    assert all(moved[round(delay / H) :])


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.1, 0.16, 0.2])
@pytest.mark.parametrize("interval", [0.1, 0.05])
def test_delay_shifts_the_whole_motion(tricycle: Helicopter, delay: float, interval: float) -> None:
    """Whatever the control interval, the claw does what an undelayed one did `delay` earlier."""
    rng = np.random.default_rng(4)
    steps = round(interval / H)
    commands = np.repeat(rng.uniform(-1.0, 1.0, (8, 2)), round(0.1 / interval), axis=0)
    late = run_drive(commands[:, :, None], column(delay), steps, (1.0, 0.0))[:, :, 0]
    prompt = run_drive(commands[:, :, None], column(), steps, (1.0, 0.0))[:, :, 0]
    lag = round(delay / H)
    assert np.all(late[: lag + 1] == late[0])
    np.testing.assert_allclose(late[lag:], prompt[: len(prompt) - lag], rtol=0.0, atol=1e-14)
    batch = Batch(tricycle, 1, timing=Timing(H, interval), claw=ClawLimits(delay_s=delay))
    batch.place(1.0, 0.0, 0.0)
    batch.parameters[Par.CLAW_ACCEL_X : Par.CLAW_ACCEL_Y + 1, 0] = ACCEL
    for k, command in enumerate(commands):
        batch.advance(command[None])
        got = batch.state[State.CLAW_X : State.CLAW_VY + 1, 0]
        np.testing.assert_allclose(got, late[(k + 1) * steps], rtol=0.0, atol=1e-14)


def test_a_delay_beyond_the_longest_is_not_cut_short(tricycle: Helicopter) -> None:
    """The batch keeps as many commands as its own claw needs, whatever it was told of others."""
    batch = Batch(tricycle, 1, claw=ClawLimits(delay_s=0.5), longest_delay_s=0.2)
    batch.place(0.0, 0.0, 0.0)
    for _ in range(5):
        batch.advance([[1.0, 0.0]])
    assert batch.telemetry["claw_vx"][0] == 0.0
    batch.advance([[0.0, 0.0]])
    assert batch.telemetry["claw_vx"][0] > 0.0


def test_columns_have_their_own_delays(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 3)
    batch.parameters[Par.CLAW_DELAY] = [0.0, 0.1, 0.2]
    batch.place(0.0, 0.0, 0.0)
    moving = []
    for _ in range(3):
        batch.advance(np.tile([1.0, 0.0], (3, 1)))
        moving.append((batch.telemetry["claw_vx"] > 0.0).tolist())
    assert moving == [[True, False, False], [True, True, False], [True, True, True]]


# --- ripple and prescribed histories -----------------------------------------------------------------------------


def test_ripple_has_its_amplitude_and_frequency(tricycle: Helicopter) -> None:
    limits = ClawLimits(ripple_along_m=0.004, ripple_across_m=0.002, ripple_hz=1.25)
    batch = Batch(tricycle, 2, timing=Timing(0.002, 0.02), claw=limits)
    batch.parameters[Par.RIPPLE_PHASE, 1] = 0.7
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(2.0, 0.1, 0.0)
    times, along, across, rate = [], [], [], []
    for _ in range(80):
        telemetry = batch.advance()
        times.append(batch.time_s[0])
        along.append(telemetry["claw_x"])
        across.append(telemetry["claw_y"])
        rate.append(telemetry["claw_vx"])
    angle = 2.0 * np.pi * 1.25 * np.array(times)[:, None] + [0.0, 0.7]
    np.testing.assert_allclose(np.array(along), 2.0 + 0.004 * np.sin(angle), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(np.array(across), 0.1 + 0.002 * np.sin(angle), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(np.array(rate), 0.004 * 2.0 * np.pi * 1.25 * np.cos(angle), rtol=0.0, atol=1e-12)
    assert np.all(batch.state[State.CLAW_X] == 2.0)  # the drive itself stands


def test_what_is_read_without_advancing_has_the_ripple_too(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2, claw=ClawLimits(ripple_along_m=0.004))
    batch.place(0.0, 0.0, 0.0)
    batch.advance(np.zeros((2, 2)), intervals=2)
    after = {name: batch.telemetry[name] for name in ("claw_x", "claw_vx", "probe_fx", "right_lateral_load")}
    batch.evaluate()
    for name, value in after.items():
        np.testing.assert_allclose(batch.telemetry[name], value, rtol=1e-12, atol=1e-12)
    assert after["claw_x"][0] != 0.0


def history(batch: Batch, seconds: float, start: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Claw nodes (1, n, 9) of a steady motion."""
    times = np.arange(round(seconds / batch.timing.node_spacing_s) + 1) * batch.timing.node_spacing_s
    nodes = np.zeros((1, times.size, 9))
    nodes[0, :, :3] = start + times[:, None] * velocity
    nodes[0, :, 3:6] = velocity
    return nodes


@pytest.mark.parametrize("history_first", [True, False])
def test_prescribed_and_commanded_claw_with_one_motion_move_the_helicopter_alike(
    tricycle: Helicopter, history_first: bool
) -> None:
    velocity, start = np.array([0.2, 0.04, 0.0]), np.array([0.5, -0.1, 0.0])
    commanded = Batch(tricycle, 1, claw=ClawLimits(delay_s=0.0))
    commanded.place(0.5, -0.1, 0.03)
    commanded.state[State.CLAW_VX : State.CLAW_VY + 1, 0] = velocity[:2]
    prescribed = Batch(tricycle, 1, modes=Modes(claw="prescribed" if history_first else "commanded"))
    if history_first:
        prescribed.prescribe_claw(history(prescribed, 3.0, start, velocity))
    prescribed.place(0.5, -0.1, 0.03)
    if not history_first:
        prescribed.prescribe_claw(history(prescribed, 3.0, start, velocity))
    for _ in range(20):
        a = commanded.advance([[velocity[0] / 0.3, velocity[1] / 0.1]])
        b = prescribed.advance()
        for name in ("position_x", "position_y", "yaw", "roll", "claw_x", "claw_vy"):
            np.testing.assert_allclose(b[name], a[name], rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(b["probe_in_plane"], a["probe_in_plane"], rtol=1e-7, atol=1e-3)
    assert a["position_x"][0] > 0.8


def test_prescribed_history_is_followed_and_held_at_its_end(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2, timing=Timing(0.002, 0.25))  # every interval ends at a node
    batch.place(0.0, 0.0, 0.0)
    nodes = np.random.default_rng(2).normal(size=(2, 4, 9)) * np.repeat([0.01, 0.02, 0.05], 3)
    nodes[:, -1, 3:] = 0.0
    batch.prescribe_claw(nodes)
    for k in range(1, 7):
        batch.advance()
        node = nodes[:, min(k, 3)]
        np.testing.assert_allclose(batch.telemetry["claw_x"], node[:, 0], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(batch.telemetry["claw_vy"], node[:, 4], rtol=0.0, atol=1e-11)
        batch.evaluate()
        np.testing.assert_allclose(batch.telemetry["claw_x"], node[:, 0], rtol=0.0, atol=1e-12)
    assert np.all(batch.telemetry["claw_vx"] == 0.0)
