"""Snapshot, restore and fork: the complete state, bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import Par
from ssmash_gym.ship import Irregular
from ssmash_gym.ship.sources import IrregularRotation
from ssmash_gym.ship.wind import Gust
from ssmash_gym.simulation.batch import Batch, ClawLimits
from ssmash_gym.vehicle import load_helicopter

SEA = Irregular(roll=IrregularRotation(rms_deg=3.0, period_s=9.0), pitch=IrregularRotation(rms_deg=1.0, period_s=7.0))
TABLES = ("state", "parameters", "_commands", "clocks", "_nodes", "_ends", "_gust_nodes", "_gust_ends",
          "_claw_nodes", "_outputs", "_highs", "_lows", "_mode")  # fmt: skip


def at_sea(name: str = "generic_tricycle", n: int = 3) -> Batch:
    """Under way, commands waiting in the delay line, the last column in gusts."""
    batch = Batch(load_helicopter(name), n, claw=ClawLimits(delay_s=0.16, ripple_along_m=0.001))
    tables = [SEA.realise(np.random.default_rng(k)).bake(4.0, batch.timing.node_spacing_s) for k in range(n)]
    batch.set_motion(tables)
    gust = Gust.draw(15.0, 0.2, np.random.default_rng(9)).bake(3.5, batch.timing.node_spacing_s)
    batch.set_gusts([None] * (n - 1) + [gust])
    batch.parameters[Par.GUST + 1, -1] = 1.0
    batch.place(0.0, 0.0, np.linspace(-0.1, 0.1, n))
    batch.parameters[Par.MASS] *= np.linspace(0.9, 1.1, n)
    drive(batch, 0, 5)
    return batch


def drive(batch: Batch, first: int, last: int, columns: list[int] | None = None) -> None:
    chosen = np.arange(batch.n) if columns is None else np.array(columns)
    for step in range(first, last):
        draws = [np.random.default_rng([step, 7]).uniform(-1.0, 1.0, 2)] * chosen.size
        batch.advance(np.array(draws), chosen)


def same(a: Batch, b: Batch) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in TABLES)


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_a_restored_run_goes_on_bit_for_bit(name: str) -> None:
    batch = at_sea(name)
    saved = batch.snapshot()
    drive(batch, 5, 12)
    end = batch.snapshot()
    batch.restore(saved)
    assert not np.array_equal(batch.state, end.arrays["state"])
    drive(batch, 5, 12)
    assert all(np.array_equal(batch.snapshot().arrays[key], value) for key, value in end.arrays.items())


def test_a_snapshot_is_complete() -> None:
    """Everything a batch holds as an array is in it, and a batch of another history takes it up."""
    batch, other = at_sea(), Batch(load_helicopter("generic_tricycle"), 3, claw=ClawLimits(delay_s=0.16))
    arrays = {name for name, value in vars(batch).items() if isinstance(value, np.ndarray)}
    assert arrays == set(batch.snapshot().arrays) == set(TABLES)
    other.restore(batch.snapshot())
    drive(batch, 5, 8)
    drive(other, 5, 8)
    assert same(batch, other)


def test_a_snapshot_is_a_copy() -> None:
    batch = at_sea()
    saved = batch.snapshot()
    kept = {key: value.copy() for key, value in saved.arrays.items()}
    drive(batch, 5, 7)
    batch.parameters[:] = 0.0
    batch.restore(saved)
    drive(batch, 5, 7)
    assert all(np.array_equal(saved.arrays[key], value) for key, value in kept.items())


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_fork_is_k_runs(name: str) -> None:
    batch = at_sea(name)
    forked = batch.fork(3)
    assert forked.n == 9 and forked.threads == batch.threads and forked.timing == batch.timing
    for name_ in TABLES[:4]:
        repeated = np.repeat(getattr(batch, name_), 3, axis=-1)
        assert np.array_equal(getattr(forked, name_), repeated)
    commands = np.random.default_rng(0).uniform(-1.0, 1.0, (6, 9, 2))
    for command in commands:
        forked.advance(command)
    for copy in range(3):
        run = batch.fork(1)
        for command in commands:
            run.advance(command[copy::3])
        for table in ("state", "_outputs", "_highs", "_lows"):
            assert np.array_equal(getattr(run, table), getattr(forked, table)[:, copy::3])
    assert np.ptp(forked.state[0].reshape(3, 3), axis=1).min() > 0.0  # the copies have gone their own ways


def test_a_fork_and_its_parent_do_not_touch_each_other() -> None:
    batch = at_sea()
    before = batch.snapshot()
    forked = batch.fork(2)
    drive(forked, 5, 9)
    forked.parameters[:] = 0.0
    assert all(np.array_equal(getattr(batch, key), value) for key, value in before.arrays.items())


def test_a_prescribed_claw_is_saved_and_forked_too() -> None:
    batch = at_sea(n=1)
    nodes = np.random.default_rng(3).normal(size=(1, 8, 9)) * 0.02
    saved = batch.snapshot()
    batch.prescribe_claw(nodes)
    forked = batch.fork(2)
    for run in (batch, forked):
        run.advance(intervals=3)
    assert np.array_equal(forked.state[:, 1], batch.state[:, 0])
    batch.restore(saved)
    twin = at_sea(n=1)
    for run in (batch, twin):
        drive(run, 5, 8)
    assert np.array_equal(batch.state, twin.state)
