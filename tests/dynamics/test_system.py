"""The whole right-hand side: symmetry, invariance, energy, locks and wrenches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import (
    SPEEDS,
    STATION_ROWS,
    STATIONS,
    TIRE_PAR,
    TIRE_ROWS,
    Deck,
    Mode,
    Par,
    Sta,
    State,
    StationKind,
    Tir,
)
from ssmash_gym.dynamics.vectors import rotation
from ssmash_gym.ship import Fixed, MotionTable, Sinusoid
from ssmash_gym.simulation.batch import Batch, Timing
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes
from tests.dynamics.on_deck import PROMPT, WHEELS, at_rest, brake, loads, weight

HELICOPTERS = ("generic_tricycle", "seahawk_like")


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


# --- invariance and symmetry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_where_the_ship_is_does_not_matter(name: str) -> None:
    batch = Batch(load_helicopter(name), 2)
    nodes = Sinusoid(dof="roll", amplitude_deg=6.0, period_s=6.0).bake(2.0, batch.timing.node_spacing_s).nodes
    far = nodes.copy()
    far[:, :3] += [3000.0, -500.0, 40.0]
    batch.set_motion([MotionTable(0.25, nodes), MotionTable(0.25, far)])
    batch.place(0.0, 0.0, 0.05)
    for _ in range(10):
        batch.advance([[0.7, 0.2]] * 2)
    np.testing.assert_allclose(batch.state[:, 0], batch.state[:, 1], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_how_fast_the_ship_goes_matters_to_the_wind_only(name: str) -> None:
    """Galilei: a steady velocity changes nothing in a vacuum, and nothing if the air moves along."""
    batch = at_rest(load_helicopter(name))
    rng = np.random.default_rng(3)
    batch.state[:SPEEDS] += 0.1 * rng.normal(size=(SPEEDS, 1))
    decks = batch.deck_rows(np.array([0]))
    decks[Deck.W_NS_S : Deck.W_NS_S + 3, 0] = [0.1, -0.05, 0.02]
    moving = decks.copy()
    moving[Deck.V_NS_N : Deck.V_NS_N + 3, 0] += [9.0, -4.0, 1.0]

    def rates(rows: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        engine.write_wind(parameters, batch.gust_nodes, np.zeros(1, np.int64), np.zeros(1), 0.25, rows)
        return engine.derivative(batch.state, parameters, batch.mode, rows)[0]

    vacuum = batch.parameters.copy()
    vacuum[Par.AIR_DENSITY] = 0.0
    assert np.array_equal(rates(decks, vacuum), rates(moving, vacuum))
    still, carried = batch.parameters.copy(), batch.parameters.copy()
    still[Par.WIND : Par.WIND + 3, 0] = [3.0, 6.0, 0.0]
    carried[Par.WIND : Par.WIND + 3, 0] = [12.0, 2.0, 1.0]
    np.testing.assert_allclose(rates(moving, carried), rates(decks, still), rtol=1e-9, atol=1e-11)
    assert np.max(np.abs(rates(moving, still) - rates(decks, still))) > 0.05


def test_the_tricycle_and_its_mirror_image_answer_as_mirror_images(tricycle: Helicopter) -> None:
    """Roll, yaw, sway and lateral claw turned round: port and starboard change places."""
    batch = Batch(tricycle, 2, claw=PROMPT)
    table = Sinusoid(dof="roll", amplitude_deg=4.0, period_s=7.0, pitch_deg=1.0).bake(5.0, 0.25, ramp_s=1.0).nodes
    nodes = [table + Sinusoid(dof="sway", amplitude_m=0.3, period_s=8.0).bake(5.0, 0.25, ramp_s=1.0).nodes]
    nodes.append(nodes[0] * np.tile([1.0, -1.0, 1.0, -1.0, 1.0, -1.0], 3))
    batch.set_motion([MotionTable(0.25, rows) for rows in nodes])
    batch.parameters[Par.WIND : Par.WIND + 2] = [[5.0, 5.0], [8.0, -8.0]]
    batch.place(0.0, [0.05, -0.05], [0.1, -0.1])
    for k in range(50):
        lateral = 0.8 if k < 20 else -0.5
        batch.advance([[0.6, lateral], [0.6, -lateral]])
    read = {name: batch.telemetry[name] for name in ("position_x", "pitch", "auxiliary_vertical_load", "probe_fx")}
    for name, value in read.items():
        np.testing.assert_allclose(value[1], value[0], rtol=1e-8, atol=1e-6, err_msg=name)
    for name in ("position_y", "roll", "yaw", "auxiliary_steer", "probe_fy", "auxiliary_lateral_load"):
        value = batch.telemetry[name]
        np.testing.assert_allclose(value[1], -value[0], rtol=1e-8, atol=1e-6, err_msg=name)
        assert abs(value[0]) > 1e-3
    for name in ("vertical_load", "compression", "tire_vertical_deflection"):
        right, left = batch.telemetry[f"right_{name}"], batch.telemetry[f"left_{name}"]
        np.testing.assert_allclose(right, left[::-1], rtol=1e-8, atol=1e-9, err_msg=name)
        assert right[0] != pytest.approx(right[1], rel=1e-3)


# --- energy --------------------------------------------------------------------------------------------------------


def kinetic_energy(batch: Batch) -> np.ndarray:
    """Of all four bodies over the still deck [J], (N,)."""
    y, p = batch.state, batch.parameters
    rot = uncompiled(rotation)
    R_SH = np.array(rot(*y[State.Q11 : State.Q11 + 4])).reshape(3, 3, -1)
    v_S, w_H = y[State.U7 : State.U7 + 3], y[State.U10 : State.U10 + 3]
    total = 0.5 * p[Par.MASS] * np.sum(v_S**2, axis=0) + spin(p[Par.IXX : Par.IZZ + 1], w_H)
    for i in range(STATIONS):
        base, row = Par.STATION + i * STATION_ROWS, State.Q15 + 5 * i
        u, zero = y[State.U13 + 2 * i : State.U15 + 2 * i], np.zeros(batch.n)
        swings = batch.mode[i] == StationKind.SWING_ARM
        R_HO = np.array(rot(*y[row + 1 : row + 5])).reshape(3, 3, -1)
        r_OW_O = np.array([p[base + Sta.DROOP], p[base + Sta.DROOP + 1], y[row]])
        w_HO_O = np.array([zero, u[0] if swings else zero, u[1]])
        slide_O = np.array([zero, zero, zero if swings else u[0]])
        r_HW_H = p[base + Sta.MOUNT : base + Sta.MOUNT + 3] + np.einsum("ijn,jn->in", R_HO, r_OW_O)
        v_OW_H = np.einsum("ijn,jn->in", R_HO, np.cross(w_HO_O, r_OW_O, axis=0) + slide_O)
        v_W_S = v_S + np.einsum("ijn,jn->in", R_SH, np.cross(w_H, r_HW_H, axis=0) + v_OW_H)
        w_W_O = np.einsum("jin,jn->in", R_HO, w_H) + w_HO_O
        total = total + 0.5 * p[base + Sta.MASS] * np.sum(v_W_S**2, axis=0)
        total = total + spin(p[base + Sta.IXX : base + Sta.IZZ + 1], w_W_O)
    return np.asarray(total)


def spin(t: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Half w I w of a tensor stored as (xx, xy, xz, yy, yz, zz)."""
    xx, xy, xz, yy, yz, zz = t
    a, b, c = w
    return 0.5 * (xx * a * a + yy * b * b + zz * c * c) + xy * a * b + xz * a * c + yz * b * c


@settings(max_examples=8, deadline=None)
@given(
    name=st.sampled_from(HELICOPTERS),
    seed=st.integers(0, 2**32 - 1),
    braked=st.booleans(),
    held=st.booleans(),
    model=st.sampled_from(["smiley_horne", "linear"]),
)
def test_a_kick_gives_all_the_energy_there_ever_is(name: str, seed: int, braked: bool, held: bool, model: str) -> None:
    """Still deck, still claw: the kinetic energy never again reaches what the kick gave, and it dies out."""
    batch = Batch(with_changes(load_helicopter(name), {"tire_model": model}), 8, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = float(held)
    batch.parameters[Par.PROBE_ULTIMATE] = 1e9
    if braked:
        brake(batch)
    batch.place(0.0, 0.0, 0.0)
    scale = np.array([0.3, 0.3, 0.3, 0.1, 0.1, 0.1, *[0.3, 0.1] * STATIONS])
    kick = np.random.default_rng(seed).normal(size=(SPEEDS, batch.n)) * scale[:, None]
    batch.state[:SPEEDS] = kick * (batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] == 0.0)
    first, last = kinetic_energy(batch), np.zeros(batch.n)
    for _ in range(40):
        batch.advance()
        last = kinetic_energy(batch)
        assert np.all(last < first)
    if held or braked:  # else it may roll on
        assert np.sum(last) < 0.1 * np.sum(first)


@pytest.mark.parametrize("name", HELICOPTERS)
def test_the_work_of_the_claw_is_kinetic_energy_and_losses(name: str) -> None:
    """Level and straight: to speed, five seconds of towing, and back to rest."""
    batch = at_rest(load_helicopter(name), timing=Timing(0.002, 0.01))
    work, before, done = 0.0, 0.0, []
    for k in range(800):
        batch.advance([[1.0 if k < 500 else 0.0, 0.0]])
        along = batch.telemetry["probe_fx"][0] * np.cos(batch.telemetry["pitch"][0])
        power = along * batch.telemetry["claw_vx"][0]
        work += 0.01 * 0.5 * (before + power)
        before = power
        done.append(work)
        if k == 499:
            kinetic = kinetic_energy(batch)[0]
            drag = -np.sum([batch.telemetry[f"{wheel}_longitudinal_load"][0] for wheel in WHEELS])
    mass = weight(batch)[0] / 9.81
    assert kinetic == pytest.approx(0.5 * mass * 0.3**2, rel=1e-3)
    assert done[499] > kinetic + drag * 1.3
    assert done[499] - done[399] == pytest.approx(drag * 0.3, rel=0.03)  # steady towing pays for the rolling only
    assert drag * 1.3 < done[-1] < done[499] - 0.5 * kinetic  # what was lent comes back, what rolling took does not
    assert kinetic_energy(batch)[0] < 0.01 * kinetic


# --- locks ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_every_lock_holds_its_speed_and_only_that(name: str) -> None:
    """Column k locks speed k; the last locks none. A lock holds the very speed it finds."""
    batch = Batch(load_helicopter(name), SPEEDS + 1, claw=PROMPT)
    batch.place(0.0, 0.0, 0.05)
    batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] = 0.0
    batch.parameters[Par.LOCK + np.arange(SPEEDS), np.arange(SPEEDS)] = 1.0
    kick = np.random.default_rng(5).normal(size=SPEEDS) * 0.05
    batch.state[:SPEEDS] = kick[:, None]
    for _ in range(3):
        batch.advance([[0.5, 0.5]] * batch.n)
        speeds = batch.state[:SPEEDS]
        same = speeds == kick[:, None]
        assert np.array_equal(same, np.eye(SPEEDS, SPEEDS + 1, dtype=bool))


@pytest.mark.parametrize("name", HELICOPTERS)
def test_all_locks_together_make_a_statue(name: str) -> None:
    batch = at_rest(load_helicopter(name))
    batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] = 1.0
    before = batch.state[: State.TIRE].copy()
    batch.set_motion([Sinusoid(dof="roll", amplitude_deg=8.0, period_s=4.0).bake(3.0, 0.25)])
    for _ in range(10):
        batch.advance([[0.1, 0.1]])
    np.testing.assert_allclose(batch.state[: State.TIRE], before, rtol=0.0, atol=1e-15)
    assert batch.telemetry["probe_in_plane"][0] > 1e4


def test_locked_wheels_stand_and_free_wheels_roll(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.place(0.0, 0.0, 0.0)
    for i in range(STATIONS):
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK, 0] = 1.0
    batch.set_motion([Fixed(pitch_deg=4.0).bake(1.0, 0.25)] * 2)
    start = batch.state[State.Q8].copy()
    for _ in range(20):
        batch.advance()
    gone = batch.state[State.Q8] - start
    assert abs(gone[0]) < 0.03
    assert gone[1] == pytest.approx(-0.5 * 9.81 * np.sin(np.deg2rad(4.0)) * 2.0**2, rel=0.05)  # downhill, aft


@pytest.mark.parametrize("locked", [True, False])
def test_steering_lock_decides_whether_the_wheel_castors(tricycle: Helicopter, locked: bool) -> None:
    batch = at_rest(tricycle)
    batch.parameters[Par.LOCK + State.U14] = float(locked)
    for _ in range(40):
        batch.advance([[1.0, 0.5]])
    steer = abs(batch.telemetry["auxiliary_steer"][0])
    assert steer == 0.0 if locked else steer > 0.01


# --- external wrenches ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_vertical_force_on_any_body_is_carried_by_the_wheels(name: str) -> None:
    """Columns: none, on the helicopter, on each carriage; down is +z, in H and W axes of a level helicopter."""
    batch = Batch(load_helicopter(name), 2 + STATIONS, claw=PROMPT)
    rows = [Par.WRENCH_H + 2] + [Par.WRENCH_W + 6 * i + 2 for i in range(STATIONS)]
    for k, row in enumerate(rows):
        batch.parameters[row, 1 + k] = 2000.0
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    brake(batch)
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    got = loads(batch)
    up = np.array([2000.0 * cosine(batch, k) for k in range(1, batch.n)])
    np.testing.assert_allclose(np.sum(got, axis=0)[1:], weight(batch)[0] + up, rtol=1e-9)
    assert np.sum(got[:, 0]) == pytest.approx(weight(batch)[0], rel=1e-9)
    change = got - got[:, :1]
    for i in range(STATIONS):  # a carriage's own wheel carries nearly all of it
        assert change[i, 2 + i] > 1900.0
        assert np.all(np.abs(np.delete(change[:, 2 + i], i)) < 150.0)
    assert np.all(change[:, 1] > 200.0)


def cosine(batch: Batch, k: int) -> float:
    """Between the vertical and the z axis of the body that column k of the test above pulls at."""
    rot = uncompiled(rotation)
    R = np.array(rot(*batch.state[State.Q11 : State.Q11 + 4, k])).reshape(3, 3)
    if k > 1:
        row = State.Q15 + 5 * (k - 2) + 1
        R = R @ np.array(rot(*batch.state[row : row + 4, k])).reshape(3, 3)
    return float(R[2, 2])


@pytest.mark.parametrize("name", HELICOPTERS)
def test_a_side_force_is_taken_up_by_the_tires(name: str) -> None:
    batch = Batch(load_helicopter(name), 2, claw=PROMPT)
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    batch.parameters[Par.LOCK + State.U14] = 1.0
    batch.parameters[Par.WRENCH_H + 1, 1] = 3000.0
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    side = np.sum([batch.telemetry[f"{wheel}_lateral_load"] for wheel in WHEELS], axis=0)
    assert side[0] == pytest.approx(0.0, abs=1e-3)
    assert side[1] == pytest.approx(-3000.0, rel=2e-3)  # rolled half a degree, headed a little off
    assert batch.telemetry["roll"][1] > 0.002
    assert loads(batch)[1, 1] > loads(batch)[1, 0] + 500.0 and loads(batch)[2, 1] < loads(batch)[2, 0] - 500.0


def test_moments_turn_about_their_own_axes(tricycle: Helicopter) -> None:
    """A couple moves load between the wheels by its size over their distance."""
    batch = Batch(tricycle, 3, claw=PROMPT)
    batch.parameters[Par.WRENCH_H + 3, 1] = 2000.0  # starboard down
    batch.parameters[Par.WRENCH_H + 4, 2] = 2000.0  # nose up
    batch.parameters[Par.PROBE_ACTIVE] = 0.0
    brake(batch)
    assert np.all(batch.place(0.0, 0.0, 0.0) < 1e-6)
    change = loads(batch) - loads(batch)[:, :1]
    x, y = (np.array([batch.telemetry[f"{wheel}_contact_{axis}"] for wheel in WHEELS]) for axis in "xy")
    # The roll it makes shifts the c.g. too, which adds; the pitch lifts the nose, which shifts the c.g. aft.
    assert 1.0 < change[1, 1] * (y[1, 1] - y[2, 1]) / 2000.0 < 1.4
    assert change[1, 1] == pytest.approx(-change[2, 1] - change[0, 1], rel=1e-7)
    assert 1.0 < -change[0, 2] * (x[0, 2] - x[1, 2]) / 2000.0 < 1.4


def test_of_two_tires_on_a_station_the_one_that_has_most_is_told(tricycle: Helicopter) -> None:
    batch = at_rest(tricycle)
    assert batch.mode[Mode.TIRES] == 2
    half = 0.5 * np.deg2rad(1.0)
    batch.state[State.Q11], batch.state[State.Q12] = np.cos(half), np.sin(half)
    batch.parameters[Par.STATION + Sta.ROLL_LOCK] = 1.0
    batch.state[State.TIRE : State.TIRE + 6, 0] = [1e-3, 2e-3, 3e-3, -2e-3, -1e-3, -4e-3]
    read = batch.evaluate()
    track = abs(batch.parameters[TIRE_PAR + Tir.Y, 0] - batch.parameters[TIRE_PAR + TIRE_ROWS + Tir.Y, 0])
    mean, most = (read[f"auxiliary_tire_vertical_deflection{end}"][0] for end in ("", "_largest"))
    assert most - mean == pytest.approx(0.5 * track * np.sin(2.0 * half), rel=1e-3)
    for name, value in (("longitudinal_deflection", -2e-3), ("lateral_deflection", 2e-3), ("twist", -4e-3)):
        assert read[f"auxiliary_tire_{name}_largest"][0] == pytest.approx(value, rel=1e-12)
