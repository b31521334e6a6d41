"""Scores of probabilities, on cases whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.monitor import scores


def test_brier_and_skill() -> None:
    happened = np.array([1.0, 0.0, 1.0, 0.0])
    assert scores.brier(happened, happened) == 0.0
    assert scores.brier(np.full(4, 0.5), happened) == 0.25
    rows = np.arange(4)
    assert scores.skill(happened, np.full(4, 0.5), happened)(rows) == 1.0
    assert scores.skill(np.full(4, 0.5), np.full(4, 0.5), happened)(rows) == 0.0
    assert np.isnan(scores.skill(happened, happened, happened)(rows))


def test_reliability_counts_every_start_once() -> None:
    rng = np.random.default_rng(0)
    said = rng.random(2000)
    happened = (rng.random(2000) < said).astype(float)
    bins = scores.reliability(np.append(said, [0.0, 1.0]), np.append(happened, [0.0, 1.0]))
    assert sum(b.count for b in bins) == 2002
    for b in bins:
        assert abs(b.happened.value - b.said) < 0.12


def test_a_record_is_judged_by_the_others_alone() -> None:
    records = np.array([0, 0, 1, 1, 2, 2])
    cells = np.array([4, 4, 4, 4, 5, 5])
    happened = np.array([1.0, 1.0, 0.0, 0.0, 1.0, 0.0])
    np.testing.assert_allclose(scores.base_rate(records, cells, happened), [0.0, 0.0, 1.0, 1.0, 0.5, 0.5])


def test_the_logistic_rule_finds_what_there_is_to_find_and_no_more() -> None:
    rng = np.random.default_rng(1)
    records = np.repeat(np.arange(60), 10)
    x = rng.normal(size=(600, 2))
    p = 1.0 / (1.0 + np.exp(-(2.0 * x[:, 0] - 0.5)))
    happened = (rng.random(600) < p).astype(float)
    said = scores.left_out(records, x, happened)
    assert np.mean(np.abs(said - p)) < 0.05
    nothing = scores.left_out(records, x[:, 1:], happened)
    assert scores.brier(said, happened) < 0.8 * scores.brier(nothing, happened)


def test_classes_that_can_be_told_apart_give_finite_probabilities() -> None:
    x = np.linspace(-1.0, 1.0, 40)[:, np.newaxis]
    said = scores.left_out(np.arange(40), x, (x[:, 0] > 0.0).astype(float))
    assert np.all((said > 0.0) & (said < 1.0))
    assert np.all(np.isfinite(scores.logit(np.array([0.0, 0.5, 1.0]), 64)))


def test_intervals_draw_whole_records() -> None:
    records = np.repeat(np.arange(20), 50)
    values = np.repeat(np.random.default_rng(0).random(20), 50)
    found = scores.by_records(records, lambda rows: float(np.mean(values[rows])))
    assert found.value == pytest.approx(np.mean(values))
    spread = np.std(values) / np.sqrt(20)
    assert 2.5 * spread < found.high - found.low < 5.0 * spread  # 50 rows of a record count as one
