"""Rounds: planned from finished rounds alone, adaptive, within the budget."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.windows.config import WindowConfig, load_window
from ssmash_gym.windows.plan import Tally, Who, chunks, rounds

WHO: Who = ("traverse", "a")
OTHER: Who = ("traverse", "b")


def window(**effort: Any) -> WindowConfig:
    return load_window(
        {
            "seed": 1, "scenario": "ss5", "axes": {"speed_kn": [0, 5, 10]}, "limits": {"probe_in_plane_kN": 15.0},
            "effort": {"seeds": 20, "step": 10, "most": 60, **effort},
        }
    )  # fmt: skip


def run(config: WindowConfig, truth: dict[Who, np.ndarray], rng: np.random.Generator | None = None) -> dict[Who, Tally]:
    """Carry a plan out to its end; with a generator, chunks come back in any order and some are lost at first."""
    tallies = {who: Tally.blank(*table.shape) for who, table in truth.items()}
    while missing := chunks(rounds(config, tallies), tallies, 7):
        kept = missing if rng is None else [missing[k] for k in rng.permutation(len(missing))[: 1 + len(missing) // 2]]
        for chunk in kept:
            for policy in chunk.policies:
                who = chunk.stage, policy
                cells, numbers = np.array(chunk.cells), np.array(chunk.numbers)
                assert not tallies[who].done[cells, numbers].any()  # nothing is run twice
                tallies[who].add(cells, numbers, truth[who][cells, numbers])
    return tallies


@pytest.fixture
def truth() -> dict[Who, np.ndarray]:
    rng = np.random.default_rng(3)
    return {who: rng.random((3, 60)) < np.array([[0.0], [0.1], [0.9]]) for who in (WHO, OTHER)}


def test_seas_are_added_where_nothing_is_decided(truth: dict[Who, np.ndarray]) -> None:
    counts = {who: tally.done.sum(axis=1).tolist() for who, tally in run(window(), truth).items()}
    for quiet, open_, loud in counts.values():
        assert (quiet, open_, loud) == (40, 60, 20)


def test_interruptions_and_order_change_nothing(truth: dict[Who, np.ndarray]) -> None:
    whole = run(window(), truth)
    for seed in range(5):
        parts = run(window(), truth, np.random.default_rng(seed))
        for who in whole:
            assert np.array_equal(parts[who].done, whole[who].done)
            assert np.array_equal(parts[who].exceeded, whole[who].exceeded)


def test_the_budget_is_never_passed_and_policies_keep_the_same_cells(truth: dict[Who, np.ndarray]) -> None:
    for budget in (120, 150, 10_000):
        found = run(window(episodes=budget), truth)
        assert sum(int(tally.done.sum()) for tally in found.values()) <= budget
    one = run(window(episodes=145), truth)  # the quiet cell lies farthest from 10 %: it is decided first
    assert [tally.done.sum(axis=1).tolist() for tally in one.values()] == [[30, 20, 20], [30, 20, 20]]


def test_the_budget_goes_to_what_is_still_open() -> None:
    """A cell in which one policy is beyond all doubt is no better for the other one, which lies at the level."""
    rng = np.random.default_rng(0)
    truth = {WHO: np.zeros((2, 60), np.bool_), OTHER: np.zeros((2, 60), np.bool_)}
    truth[WHO][0] = True
    truth[OTHER][0] = rng.permuted(np.arange(60) % 10 == 0)
    truth[OTHER][0, :20] = np.arange(20) % 10 == 0
    config = load_window({**window().model_dump(mode="json"), "axes": {"speed_kn": [0, 5]}})
    effort = {**config.effort.model_dump(), "episodes": 100}
    found = run(load_window({**config.model_dump(mode="json"), "effort": effort}), truth)
    assert [tally.done.sum(axis=1).tolist() for tally in found.values()] == [[20, 30], [20, 30]]


def test_more_seas_go_on_where_fewer_have_ended(truth: dict[Who, np.ndarray]) -> None:
    tallies = run(window(most=30), truth)
    assert tallies[WHO].done.sum(axis=1).tolist() == [30, 30, 20]
    wanted = rounds(window(), tallies)[WHO]
    assert wanted.tolist() == [40, 40, 20]


def test_policies_that_need_the_same_seas_meet_them_together(truth: dict[Who, np.ndarray]) -> None:
    tallies = {who: Tally.blank(3, 60) for who in truth}
    tallies[OTHER].done[0] = True
    found = chunks(rounds(window(), tallies), tallies, 1000)
    assert {(chunk.policies, chunk.episodes) for chunk in found} == {(("a",), 20), (("a", "b"), 80)}
    assert len({chunk.name for chunk in found}) == 2
