"""The engine's promise: the bits of a helicopter depend on nothing but itself."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.dynamics import engine, stepper
from ssmash_gym.dynamics.channels import OUTPUT_ROWS, Out
from ssmash_gym.dynamics.lane import WIDTH, uncompiled
from ssmash_gym.dynamics.layout import SPEEDS, Deck, Par, State
from ssmash_gym.dynamics.vectors import rotation
from ssmash_gym.ship import Irregular, MotionTable
from ssmash_gym.ship.sources import IrregularRotation, IrregularTranslation
from ssmash_gym.ship.wind import Gust, GustTable, blows_towards
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.vehicle import load_helicopter

ROOT = Path(__file__).resolve().parents[2]
HELICOPTERS = ("generic_tricycle", "seahawk_like")
SEA = Irregular(
    roll=IrregularRotation(rms_deg=3.0, period_s=9.0),
    pitch=IrregularRotation(rms_deg=1.0, period_s=7.0),
    heave=IrregularTranslation(rms_m=0.5, period_s=8.0),
)
TABLES = ("state", "_outputs", "_highs", "_lows", "clocks")


def fleet(name: str, n: int, threads: int = 1, first: int = 0) -> Batch:
    """Columns that all differ: mass, friction, delay, yaw, sea and gusts follow from the column's own number.

    Every second one has gusts; the first has none.
    """
    batch = Batch(load_helicopter(name), n, threads=threads, claw=ClawLimits(ripple_across_m=0.001))
    tables: list[MotionTable] = []
    gusts: list[GustTable | None] = []
    for k in range(n):
        rng = np.random.default_rng(100 + first + k)
        batch.parameters[Par.MASS, k] *= rng.uniform(0.9, 1.1)
        batch.parameters[Par.CLAW_DELAY, k] = round(rng.uniform(0.0, 0.2) / 0.002) * 0.002
        batch.parameters[Par.WIND : Par.WIND + 3, k] = rng.uniform(-8.0, 8.0, 3)
        tables.append(SEA.realise(rng).bake(2.0, batch.timing.node_spacing_s))
        blowing = (first + k) % 2 == 1
        gusts.append(Gust.draw(12.0, 0.2, rng).bake(2.0, batch.timing.node_spacing_s) if blowing else None)
        batch.parameters[Par.GUST : Par.GUST + 3, k] = blows_towards(40.0 * (first + k)) if blowing else 0.0
    batch.set_motion(tables)
    batch.set_gusts(gusts)
    rng = [np.random.default_rng(200 + first + k) for k in range(n)]
    batch.place(0.0, [r.uniform(-0.1, 0.1) for r in rng], [r.uniform(-0.15, 0.15) for r in rng])
    return batch


def commands(step: int, n: int, first: int = 0) -> np.ndarray:
    return np.array([np.random.default_rng([step, first + k]).uniform(-1.0, 1.0, 2) for k in range(n)])


def drive(batch: Batch, steps: int = 6, first: int = 0) -> Batch:
    for step in range(steps):
        batch.advance(commands(step, batch.n, first))
    return batch


def column(batch: Batch, k: int) -> list[np.ndarray]:
    return [getattr(batch, name)[..., k].copy() for name in TABLES]


def same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("name", HELICOPTERS)
def test_same_bits_for_any_batch_size(name: str) -> None:
    whole = drive(fleet(name, 9))
    assert np.ptp(whole.state[State.Q9]) > 0.01  # they do differ
    for n in (1, 3, 4, 5):
        part = drive(fleet(name, n))
        for k in range(n):
            assert same(column(part, k), column(whole, k))
    alone = drive(fleet(name, 1, first=7), first=7)
    assert same(column(alone, 0), column(whole, 7))


@pytest.mark.parametrize("name", HELICOPTERS)
@pytest.mark.parametrize("threads", [2, 3])
def test_same_bits_for_any_number_of_threads(name: str, threads: int) -> None:
    one, many = drive(fleet(name, 9)), drive(fleet(name, 9, threads=threads))
    for k in range(9):
        assert same(column(one, k), column(many, k))


def test_same_bits_in_any_order_and_for_any_subset() -> None:
    whole = drive(fleet("generic_tricycle", 7))
    shuffled, parts = fleet("generic_tricycle", 7), fleet("generic_tricycle", 7)
    order = np.random.default_rng(1).permutation(7)
    for step in range(6):
        values = commands(step, 7)
        shuffled.advance(values[order], order)
        for some in ([3], [0, 6, 1, 5, 2], [4]):
            parts.advance(values[some], some)
    for k in range(7):
        assert same(column(shuffled, k), column(whole, k))
        assert same(column(parts, k), column(whole, k))


def test_columns_not_listed_are_not_touched() -> None:
    batch = drive(fleet("generic_tricycle", 6), 2)
    before = [column(batch, k) for k in range(6)]
    batch.advance(np.ones((2, 2)), [4, 1])
    for k in range(6):
        assert same(column(batch, k), before[k]) == (k not in (1, 4))
    assert (batch.clocks == np.where(np.isin(np.arange(6), [1, 4]), 150, 100)).all()


def test_a_control_interval_may_be_cut_anywhere() -> None:
    """The engine keeps nothing between calls: 10 substeps are 3 + 7 substeps, in the middle of a node's piece too."""
    batches = [drive(fleet("seahawk_like", 5), 2) for _ in range(2)]
    for batch, cuts in zip(batches, ([10], [3, 7]), strict=True):
        batch._commands[:] = 0.0
        for substeps in cuts:
            engine.advance(
                batch.state, batch.parameters, batch._commands, batch.mode, batch.nodes, batch._claw_nodes,
                batch.gust_nodes, batch.clocks, np.arange(5), substeps, 0.002, 125, batch._outputs, batch._highs,
                batch._lows,
            )  # fmt: skip
    assert np.array_equal(batches[0].state, batches[1].state)
    assert np.array_equal(batches[0]._outputs, batches[1]._outputs)


@pytest.mark.parametrize("name", HELICOPTERS)
@pytest.mark.parametrize("n", [1, 6])
def test_compiled_lanes_give_the_bits_of_the_uncompiled_source(name: str, n: int) -> None:
    """The very same `advance_columns`, run as plain Python on NumPy arrays."""
    compiled = drive(fleet(name, n), 2)
    plain = drive(fleet(name, n), 2)
    columns, substeps = np.arange(n), 4
    arguments = []
    for batch in (compiled, plain):
        rng = np.random.default_rng(3)  # all speeds, off balance: every branch of the forces
        batch.state[: State.Q8] += rng.normal(size=(State.Q8, 1)) * 0.05
        arguments.append((
            batch.state, batch.parameters, batch._commands, batch.mode, batch.nodes, batch._claw_nodes,
            batch.gust_nodes, batch.clocks,
        ))  # fmt: skip
    engine.advance(*arguments[0], columns, substeps, 0.002, 125, compiled._outputs, compiled._highs, compiled._lows)
    rows = stepper.advance_room(plain.parameters.shape[0], plain._commands.shape[0])
    room, lanes = np.zeros((rows, WIDTH)), np.zeros((2, WIDTH), np.int64)
    history = plain._commands.shape[0] // 2
    uncompiled(stepper.advance_columns)(
        *arguments[1], columns, 0, -(-n // WIDTH), history, substeps, 0.002, 125, 1, 1, plain._outputs, plain._highs,
        plain._lows, room, lanes,
    )  # fmt: skip
    for k in range(n):
        assert same(column(compiled, k), column(plain, k))
    assert np.all(np.isfinite(plain.state)) and np.all(np.isfinite(plain._outputs))


@pytest.mark.parametrize("name", HELICOPTERS)
def test_plain_right_hand_side_does_not_depend_on_its_neighbours(name: str) -> None:
    batch = drive(fleet(name, 9), 3)
    decks = batch.deck_rows(np.arange(9))
    rates, outputs = engine.derivative(batch.state, batch.parameters, batch.mode, decks)
    assert outputs.shape == (OUTPUT_ROWS, 9)
    for some in ([4], [8, 0, 3], [1, 2, 3, 4, 5]):
        one = engine.derivative(batch.state[:, some], batch.parameters[:, some], batch.mode, decks[:, some])
        assert np.array_equal(one[0], rates[:, some]) and np.array_equal(one[1], outputs[:, some])


def digest() -> str:
    """Hash of a run; what `test_two_processes_agree` prints from two processes."""
    hashes = hashlib.sha256()
    for name in HELICOPTERS:
        batch = drive(fleet(name, 5), 3)
        for table in TABLES:
            hashes.update(np.ascontiguousarray(getattr(batch, table)).tobytes())
    return hashes.hexdigest()


def test_two_processes_agree() -> None:
    program = (
        f"import importlib.util as u; s = u.spec_from_file_location('t', {str(Path(__file__))!r}); "
        "m = u.module_from_spec(s); s.loader.exec_module(m); print(m.digest())"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "77"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert done.stdout.strip() == digest()


def test_threads_available_are_those_of_this_process() -> None:
    assert 1 <= engine.available_threads() <= (os.cpu_count() or 1)


SWING = Gust(np.array([2.0 * np.pi / 3.0]), np.array([4.0]), np.array([0.4]))  # one sine of 3 s and 4 m/s


def gusty(gust: Gust = SWING, n: int = 3) -> Batch:
    """A calm column, one whose gusts have no direction and one with gusts to starboard, all on a still deck."""
    batch = Batch(load_helicopter("generic_tricycle"), n, claw=ClawLimits(ripple_across_m=0.001))
    batch.parameters[Par.WIND + 1] = 10.0
    batch.parameters[Par.GUST + 1, 2:] = 1.0
    table = gust.bake(15.0, batch.timing.node_spacing_s)
    batch.set_gusts([None, table, table][:n])
    batch.place(0.0, 0.0, 0.0)
    return batch


def test_a_gust_makes_the_wind_force_swing_with_its_period() -> None:
    batch = gusty()
    calm = gusty(n=1)
    rest = batch.state.copy()
    assert np.array_equal(rest[:, 2], rest[:, 0])  # settled in the mean wind
    force = []
    for _ in range(90):
        calm.advance()
        force.append(batch.advance()["wind_fy"])
    force = np.array(force)
    spectrum = np.abs(np.fft.rfft(force[:, 2] - force[:, 2].mean()))  # 9 s: the third line is the gust's
    assert np.argmax(spectrum) == 3 and spectrum[3] > 5.0 * np.max(np.delete(spectrum, 3))
    assert np.max(force[:, 2]) / force[0, 0] == pytest.approx(1.4**2, rel=0.03)
    assert np.min(force[:, 2]) / force[0, 0] == pytest.approx(0.6**2, rel=0.06)


def test_without_a_direction_there_is_no_gust_to_the_bit() -> None:
    """Neither a table nor a neighbour's gusts change what a calm column does."""
    batch, calm = gusty(), gusty(n=1)
    for run in (batch, calm):
        run.advance(np.full((run.n, 2), 0.3), intervals=20)
    for k in (0, 1):
        assert same(column(batch, k), column(calm, 0))
    assert not np.array_equal(batch.state[:, 2], calm.state[:, 0])


def test_the_kernel_meets_the_gusts_that_were_drawn() -> None:
    """A helicopter that cannot move feels the drag of the wind that NumPy works out from the sines."""
    gust = Gust.draw(12.0, 0.15, np.random.default_rng(8))
    batch = gusty(gust)
    batch.parameters[Par.LOCK : Par.LOCK + SPEEDS] = 1.0
    p = batch.parameters[:, 2]
    R_NH = np.array(uncompiled(rotation)(*batch.state[State.Q11 : State.Q15, 2])).reshape(3, 3)
    forces, expected, speeds = [], [], []
    for _ in range(120):
        batch.advance()
        speeds.append(gust.at(batch.time_s[2:])[0, 0])
        wind = R_NH.T @ (p[Par.WIND : Par.WIND + 3] + speeds[-1] * np.array([0.0, 1.0, 0.0]))
        drag = 0.5 * p[Par.AIR_DENSITY] * np.linalg.norm(wind) * p[Par.AREA : Par.AREA + 3] * wind
        forces.append(batch.telemetry.outputs[[Out.WIND_FX, Out.WIND_FY, Out.WIND_FZ], 2])
        expected.append(drag)
    scale = np.max(np.abs(expected))
    np.testing.assert_allclose(forces, expected, rtol=0.0, atol=1e-3 * scale)  # the quintics of 0.25 s are good to that
    assert np.std(speeds) == pytest.approx(1.8, rel=0.3)


def test_reading_an_instant_of_a_gust_is_what_the_engine_left_there() -> None:
    batch = gusty()
    batch.advance(intervals=7)
    left = batch.telemetry.outputs.copy()
    again = batch.evaluate().outputs
    rows = [Out.WIND_FX, Out.WIND_FY, Out.WIND_FZ]
    assert np.array_equal(again[rows], left[rows]) and left[Out.WIND_FY, 2] != left[Out.WIND_FY, 1]
    np.testing.assert_allclose(again, left, rtol=1e-9, atol=1e-6)
    met = batch.deck_rows(np.arange(3))[Deck.WIND + 1]
    np.testing.assert_allclose(met, [10.0, 10.0, 10.0 + SWING.at([0.7])[0, 0]], rtol=1e-6)
