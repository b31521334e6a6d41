"""Two lane widths in one process: chosen by the size of the batch, compiled when needed, the same bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics import engine, stepper
from ssmash_gym.dynamics.lane import WIDTH
from ssmash_gym.dynamics.layout import Par, State
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import load_helicopter

TABLES = ("state", "_outputs", "_highs", "_lows")


@pytest.fixture(autouse=True)
def wide(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lanes of 8 for larger batches, whatever the processor prefers."""
    monkeypatch.setattr(engine, "WIDE", 8)


def batch_of(n: int, name: str = "generic_tricycle") -> Batch:
    """Columns that differ, as they are described: in the air, about to fall."""
    batch = Batch(load_helicopter(name), n)
    k = np.arange(n)
    batch.parameters[Par.MASS] *= 1.0 + 0.01 * k
    batch.state[State.Q9] = 0.02 * k
    batch.state[State.Q10] = -2.3
    batch.state[State.U7] = 0.1 * k
    return batch


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_the_same_bits_on_lanes_of_both_widths(name: str) -> None:
    few, many = batch_of(3, name), batch_of(9, name)
    for step in range(4):
        for batch in (few, many):
            batch.advance(np.full((batch.n, 2), 0.2 * step))
    for table in TABLES:
        np.testing.assert_array_equal(getattr(few, table), getattr(many, table)[:, :3], strict=True)
    assert np.max(few.telemetry["right_vertical_load"]) > 1e4  # wheels are down
    assert np.all(np.isfinite(many.state))


def test_the_right_hand_side_has_the_same_bits_on_both() -> None:
    batch = batch_of(9)
    decks = batch.deck_rows(np.arange(9))
    narrow, wide = (engine.derivative(batch.state, batch.parameters, batch.mode, decks, width) for width in (WIDTH, 8))
    np.testing.assert_array_equal(narrow[0], wide[0])
    np.testing.assert_array_equal(narrow[1], wide[1])
    assert np.ptp(narrow[1]) > 0.0


@pytest.fixture
def called(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, int]]:
    """The kernels that the engine asks for, none of which runs, in place of the kernels."""
    calls: list[tuple[Any, int]] = []

    def kernel(function: Any, width: int) -> Any:
        def run(*arguments: Any) -> None:
            calls.append((function, width))
            room, lanes = arguments[-2:]
            assert room.shape[1] == lanes.shape[1] == width
            assert room.ctypes.data % 64 == 0  # no row of a lane straddles two cache lines

        return run

    monkeypatch.setattr(engine, "_kernel", kernel)
    return calls


def test_the_width_follows_the_batch_and_not_the_columns(called: list[tuple[Any, int]]) -> None:
    for n, columns in ((1, [0]), (WIDTH, None), (WIDTH + 1, None), (WIDTH + 1, [2]), (40, [0, 3, 7])):
        batch_of(n).advance(columns=columns)
    assert called == [(stepper.advance_columns, width) for width in (WIDTH, WIDTH, 8, 8, 8)]


def test_one_version_of_a_kernel_whatever_the_layout_in_memory() -> None:
    def versions() -> int:
        return len(getattr(engine._kernel(stepper.rates_columns, WIDTH), "signatures", ()))

    batch = batch_of(3)
    decks = batch.deck_rows(np.arange(3))
    one = engine.derivative(batch.state, batch.parameters, batch.mode, decks)
    before = versions()
    two = engine.derivative(np.asfortranarray(batch.state), batch.parameters[:, [0, 1, 2]], batch.mode, decks.copy("F"))
    np.testing.assert_array_equal(one[0], two[0])
    assert versions() == before
