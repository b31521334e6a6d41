"""The deck kernel against the ship's own motion table, and against its own derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics import engine
from ssmash_gym.dynamics.deck import COEFFICIENTS, deck_kinematics, gather_piece, prescribed_claw
from ssmash_gym.dynamics.lane import uncompiled
from ssmash_gym.dynamics.layout import DECK_ROWS, Deck
from ssmash_gym.ship import MotionTable

SPACING = 0.25
ROWS = {"R_NS": (Deck.R_NS, 9), "w_NS_S": (Deck.W_NS_S, 3), "wdot_NS_S": (Deck.WDOT_NS_S, 3),
        "v_NS_N": (Deck.V_NS_N, 3), "a_NS_N": (Deck.A_NS_N, 3)}  # fmt: skip


def random_table(seed: int, nodes: int = 6) -> MotionTable:
    """Independent values, rates and accelerations at every node; angles all round the circle."""
    scale = np.array([20.0, 20.0, 20.0, 3.0, 3.0, 3.0])
    rows = np.random.default_rng(seed).uniform(-1.0, 1.0, (nodes, 3, 6)) * scale
    return MotionTable(SPACING, rows.reshape(nodes, 18))


def stacked(tables: list[MotionTable]) -> np.ndarray:
    return np.array([table.nodes for table in tables])


def plain_rows(table: MotionTable, time_s: float) -> np.ndarray:
    """`Deck` rows (DECK_ROWS, 1) by the uncompiled kernels."""
    piece = min(int(time_s / SPACING), len(table.nodes) - 2)
    c, d = np.zeros((6 * COEFFICIENTS, 1)), np.zeros((DECK_ROWS, 1))
    uncompiled(gather_piece)(table.nodes[None], 0, piece, 6, SPACING, c, 0)
    uncompiled(deck_kinematics)(c, np.array([time_s - piece * SPACING]), d)
    return d


@pytest.mark.parametrize("time_s", [0.0, 0.03, 0.25, 0.61, 0.875, 1.1, 1.25])
def test_kernel_is_the_table_at_any_angle(time_s: float) -> None:
    tables = [random_table(seed) for seed in range(5)]  # one more than a block of lanes
    decks = engine.deck_rows(stacked(tables), time_s, SPACING)
    for k, table in enumerate(tables):
        pose, signal = table.pose(time_s), table.at(time_s)
        for name, (row, count) in ROWS.items():
            expected = getattr(pose, name).ravel()
            size = 1.0 + np.max(np.abs(expected))
            np.testing.assert_allclose(decks[row : row + count, k], expected, rtol=0.0, atol=1e-12 * size)
        np.testing.assert_allclose(decks[Deck.ANGLES : Deck.ANGLES + 3, k], signal.position[3:], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("time_s", [0.0, 0.2, 0.49, 1.0])
def test_uncompiled_kernel_gives_the_same_bits(time_s: float) -> None:
    for seed in range(3):
        table = random_table(seed)
        compiled = engine.deck_rows(stacked([table]), time_s, SPACING)
        assert np.array_equal(compiled, plain_rows(table, time_s))


def test_reported_rates_are_the_derivatives_of_what_is_reported() -> None:
    table, h = random_table(7), 1e-5
    for t in (0.1, 0.4, 0.9):
        before, now, after = (plain_rows(table, t + s)[:, 0] for s in (-h, 0.0, h))
        slope = (after - before) / (2.0 * h)
        R = now[Deck.R_NS : Deck.R_NS + 9].reshape(3, 3)
        np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-14)
        assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)
        wx, wy, wz = now[Deck.W_NS_S : Deck.W_NS_S + 3]
        skew = np.array([[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]])
        np.testing.assert_allclose(slope[Deck.R_NS : Deck.R_NS + 9].reshape(3, 3), R @ skew, rtol=1e-7, atol=1e-6)
        for rate, of in ((Deck.WDOT_NS_S, Deck.W_NS_S), (Deck.A_NS_N, Deck.V_NS_N)):
            np.testing.assert_allclose(now[rate : rate + 3], slope[of : of + 3], rtol=1e-6, atol=1e-4)


def test_nothing_jumps_at_a_node() -> None:
    table = random_table(11)
    for k in (1, 2, 3, 4):
        end, start = (plain_rows(table, k * SPACING + s)[:, 0] for s in (-1e-9, 0.0))
        assert np.max(np.abs(end - start) / (1.0 + np.abs(start))) < 1e-3  # a nanosecond of the jerk


def test_a_still_deck_is_still_for_ever() -> None:
    node = np.zeros(18)
    node[:6] = [3.0, -2.0, 1.0, 0.3, -0.2, 2.5]
    table = MotionTable(SPACING, np.array([node, node]))
    start = engine.deck_rows(stacked([table]), 0.0, SPACING)
    assert not np.any(start[Deck.W_NS_S : Deck.C_CLAW_S])
    for time_s in (0.1, 0.25, 17.3, 3600.0):
        assert np.array_equal(engine.deck_rows(stacked([table]), time_s, SPACING), start)


def test_claw_rows_are_left_to_the_claw() -> None:
    decks = engine.deck_rows(stacked([random_table(3)]), 0.3, SPACING)
    assert not np.any(decks[Deck.C_CLAW_S : Deck.V_CLAW_S + 3])
    nodes = np.random.default_rng(5).uniform(-1.0, 1.0, (1, 2, 9))
    c, d = np.zeros((3 * COEFFICIENTS, 1)), np.full((DECK_ROWS, 1), np.nan)
    uncompiled(gather_piece)(nodes, 0, 0, 3, SPACING, c, 0)
    for t, node in ((0.0, 0), (SPACING, 1)):
        uncompiled(prescribed_claw)(c, np.array([t]), d)
        np.testing.assert_allclose(d[Deck.C_CLAW_S : Deck.C_CLAW_S + 3, 0], nodes[0, node, :3], atol=1e-13)
        np.testing.assert_allclose(d[Deck.V_CLAW_S : Deck.V_CLAW_S + 3, 0], nodes[0, node, 3:6], atol=1e-12)
    assert np.all(np.isnan(d[: Deck.C_CLAW_S])) and np.all(np.isnan(d[Deck.ANGLES :]))
