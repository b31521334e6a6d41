"""Bands of the sea's severity: several sea states share their seeds."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

from ssmash_gym.evaluation.severity import BANDS, band_means
from ssmash_gym.evaluation.study_rows import StudyRows

SEAS = 40
LOAD = np.random.default_rng(2).lognormal(2.0, 0.4, SEAS)


def rows(conditions: dict[str, float], trained: dict[str, list[int | None]]) -> StudyRows:
    """The same loads in every condition; `conditions` gives the severity, `trained` the training seeds."""
    frames = [
        pl.DataFrame({"sea": range(SEAS), "scored_peak_kN": LOAD}).with_columns(
            policy=pl.lit("mine"), condition=pl.lit(name), training_seed=pl.lit(seed, pl.Int64), sea_lateral_g=pl.lit(g)
        )
        for name, g in conditions.items()
        for seed in trained[name]
    ]
    return StudyRows.of(pl.concat(frames))


def test_a_seed_met_in_two_sea_states_is_one_draw() -> None:
    inside = sum(BANDS[0]) / 2.0
    once, _ = band_means(rows({"ss3": inside}, {"ss3": [None]}), ["ss3"], ["mine"])
    states = {"ss3": inside, "ss4": inside}
    twice, counts = band_means(rows(states, {one: [None] for one in states}), list(states), ["mine"])
    assert counts[0] == 2 * SEAS and sum(counts[1:]) == 0
    one, two = once["mine"][0], twice["mine"][0]
    assert one is not None and two is not None and twice["mine"][1] is None
    assert one.value == pytest.approx(LOAD.mean())
    assert (two.value, two.low, two.high) == pytest.approx((one.value, one.low, one.high))  # no false certainty


def test_training_seeds_that_miss_a_sea_state_are_left_out() -> None:
    inside = sum(BANDS[0]) / 2.0
    found, _ = band_means(rows({"ss3": inside, "ss4": inside}, {"ss3": [0, 1], "ss4": [1]}), ["ss3", "ss4"], ["mine"])
    assert found["mine"][0] is not None and found["mine"][0].value == pytest.approx(LOAD.mean())
    nowhere, _ = band_means(rows({"ss3": inside, "ss4": inside}, {"ss3": [0], "ss4": [1]}), ["ss3", "ss4"], ["mine"])
    assert nowhere["mine"][0] is None
