"""The benchmark of the deck's share reads the very deck that the engine meets, and reports a share."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import deck_share
from ssmash_gym.dynamics.lane import WIDTH, uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, Deck
from ssmash_gym.dynamics.prescribed import CLAW_PIECES, DECK_PIECES, GUST_PIECES


def test_the_deck_alone_is_the_deck_of_the_engine() -> None:
    """After 130 substeps, past a node: the rows that the timed kernel leaves are those that the batch reads."""
    batch = deck_share.windy(WIDTH, gusty=True).batch
    room, blocks = np.zeros((deck_share.ROOM, WIDTH)), np.arange(WIDTH)[None]
    clocks = np.zeros_like(blocks)
    uncompiled(deck_share.deck_alone)(
        batch.state, batch.parameters, batch.mode, batch.nodes, batch._claw_nodes, batch.gust_nodes, blocks, clocks,
        130, 0.002, 125, 1, room,
    )  # fmt: skip
    batch.clocks[:] = 130
    first = DECK_PIECES + CLAW_PIECES + GUST_PIECES
    assert np.array_equal(clocks, np.full((1, WIDTH), 130))
    read = batch.deck_rows(np.arange(WIDTH))
    np.testing.assert_allclose(room[first : first + DECK_ROWS], read, rtol=1e-12, atol=1e-12)
    assert np.ptp(read[Deck.WIND + 1]) > 0.1


def test_a_share_is_a_share() -> None:
    figures = deck_share.measure(WIDTH, True, 1)
    assert figures["deck_ns"] > 0.0
    assert figures["median_share"] == pytest.approx(figures["deck_ns"] / figures["engine_ns"], rel=0.01)
