"""Gusts of a batch: on the clock of the deck motion, carried wherever a column goes, left out of settling."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import Deck, Par
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship import Fixed, Sinusoid
from ssmash_gym.ship.wind import Gust, GustTable, blows_towards, wind_over_deck
from ssmash_gym.simulation.batch import Batch, Timing
from ssmash_gym.vehicle import Helicopter, load_helicopter

ROLLING = Sinusoid(dof="roll", amplitude_deg=3.0, period_s=7.0)
GUST = Gust.draw(14.0, 0.2, np.random.default_rng(2))


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


def windy(helicopter: Helicopter, n: int, gusts: list[GustTable | None] | None, seconds: float = 6.0) -> Batch:
    """Rolling decks in a wind from starboard of 14 m/s."""
    batch = Batch(helicopter, n)
    batch.parameters[Par.WIND : Par.WIND + 3] = wind_over_deck(14.0, 90.0, 5.0)[:, None]
    batch.parameters[Par.GUST : Par.GUST + 3] = blows_towards(90.0)[:, None]
    batch.set_motion([ROLLING.bake(seconds, 0.25)] * n)
    batch.set_gusts(gusts)
    batch.place(0.0, 0.0, 0.0)
    return batch


def wind_N(batch: Batch) -> np.ndarray:
    return batch.deck_rows(np.arange(batch.n))[Deck.WIND : Deck.WIND + 3]


def test_the_wind_is_mean_plus_gust_speed_along_its_direction(tricycle: Helicopter) -> None:
    batch = windy(tricycle, 2, [GUST.bake(6.0, 0.25), None])
    for intervals in (1, 13, 20):
        batch.advance(intervals=intervals)
        speed = GUST.at(batch.time_s[:1])[0, 0]
        expected = np.array([[-5.0, -14.0 - speed, 0.0], [-5.0, -14.0, 0.0]]).T
        np.testing.assert_allclose(wind_N(batch), expected, atol=5e-3)
    assert batch.gust_nodes.shape == (2, 26, 3) and not batch.gust_nodes[1].any()


def test_columns_at_different_times_read_their_own_gusts(tricycle: Helicopter) -> None:
    table = GUST.bake(6.0, 0.25)
    batch = windy(tricycle, 3, [table] * 3)
    batch.advance(columns=[1], intervals=7)
    batch.advance(columns=[2], intervals=31)
    together = wind_N(batch)
    assert np.ptp(together[1]) > 0.1
    for k in range(3):
        alone = batch.deck_rows(np.array([k]))[Deck.WIND : Deck.WIND + 3, 0]
        assert np.array_equal(together[:, k], alone)
        assert together[1, k] == pytest.approx(-14.0 - table.at(batch.time_s[k : k + 1])[0, 0], abs=1e-12)


def test_a_column_settles_in_the_mean_wind(tricycle: Helicopter) -> None:
    gusty, calm = windy(tricycle, 2, [GUST.bake(6.0, 0.25)] * 2), windy(tricycle, 2, None)
    assert np.array_equal(gusty.state, calm.state)
    assert abs(GUST.at([0.0])[0, 0]) > 0.5  # there was something to be left out
    gusty.advance()
    calm.advance()
    assert not np.array_equal(gusty.state, calm.state)


def test_a_table_of_another_spacing_is_refused(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 2)
    with pytest.raises(ConfigurationError, match=r"gust table: node spacing 0\.2 s, must be 0\.25 s"):
        batch.set_gusts([None, GUST.bake(1.0, 0.2)])
    fine = Batch(tricycle, 1, timing=Timing(0.003, 0.03))
    fine.set_gusts([GUST.bake(1.0, fine.timing.node_spacing_s)])
    assert fine.gust_nodes.any()


def test_the_end_of_the_gusts_is_refused_before_anything_moves(tricycle: Helicopter) -> None:
    batch = windy(tricycle, 3, [None, GUST.bake(1.0, 0.25), GUST.bake(9.0, 0.25)])
    batch.advance(intervals=10)
    before = batch.snapshot()
    with pytest.raises(ValueError, match="the gust table of helicopter 1 ends at 1 s; bake a longer table"):
        batch.advance()
    assert all(np.array_equal(getattr(batch, name), array) for name, array in before.arrays.items())
    batch.advance(columns=[0, 2], intervals=50)
    with pytest.raises(ValueError, match="the deck motion of helicopter 2 ends at 6 s"):
        batch.advance(columns=[2, 0])


def test_steady_extra_wind_never_ends(tricycle: Helicopter) -> None:
    batch = Batch(tricycle, 1)
    batch.set_motion([Fixed().bake(1.0, 0.25)])
    batch.set_gusts([GustTable(0.25, np.array([[2.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))])
    batch.parameters[Par.GUST] = 1.0
    batch.place(0.0, 0.0, 0.0)
    batch.advance(intervals=15)
    assert wind_N(batch)[0, 0] == 2.0


def test_a_new_motion_drops_the_gusts_of_its_columns(tricycle: Helicopter) -> None:
    batch = windy(tricycle, 2, [GUST.bake(2.0, 0.25)] * 2)
    batch.set_motion([ROLLING.bake(6.0, 0.25)], [1])
    assert batch.gust_nodes[0].any() and not batch.gust_nodes[1].any()
    batch.advance(columns=[1], intervals=40)  # beyond the end of the gusts that were
    assert np.array_equal(wind_N(batch)[:, 1], wind_over_deck(14.0, 90.0, 5.0))
    batch.set_gusts(None)
    assert not batch.gust_nodes.any()


def test_tables_of_different_lengths_live_together(tricycle: Helicopter) -> None:
    tables = [Gust.draw(14.0, 0.2, np.random.default_rng(k)).bake(s, 0.25) for k, s in ((0, 1.0), (1, 9.0))]
    both, alone, later = windy(tricycle, 2, tables), windy(tricycle, 1, tables[:1]), windy(tricycle, 2, None)
    later.set_gusts(tables[1:], [1])
    later.set_gusts(tables[:1], [0])
    for batch in (both, alone, later):
        batch.advance(intervals=9)
    assert np.array_equal(both.state[:, 0], alone.state[:, 0])
    assert np.array_equal(both.state, later.state)


def test_gusts_go_with_a_column_into_another_batch(tricycle: Helicopter) -> None:
    source = windy(tricycle, 2, [None, GUST.bake(5.0, 0.25)])
    source.advance(intervals=3)
    target = windy(tricycle, 3, [Gust.draw(14.0, 0.3, np.random.default_rng(6)).bake(9.0, 0.25), None, None])
    kept = target.gust_nodes[0].copy()
    target.take(source, [1, 0], [2, 1])
    assert np.array_equal(target.gust_nodes[0], kept) and not target.gust_nodes[1].any()
    twin = source.fork(1)
    twin.advance(intervals=20)
    target.advance(columns=[2, 1], intervals=20)
    assert np.array_equal(target.state[:, [2, 1]], twin.state[:, [1, 0]])
    with pytest.raises(ValueError, match="gust table of helicopter 2 ends at 5 s"):
        target.advance(columns=[2], intervals=40)
    with pytest.raises(ValueError, match="gust table of helicopter 1 ends at 5 s"):
        twin.advance(columns=[1], intervals=40)
