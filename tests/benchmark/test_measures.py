"""The figures of a benchmark against numbers worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.benchmark.figures import common, driver, drivers, own_figures, pair_figures, score
from ssmash_gym.benchmark.measures import path_m, reversals
from ssmash_gym.evaluation.statistics import improvement
from ssmash_gym.evaluation.study_figures import Options

OPTIONS = Options(resamples=200)
SEEDS = [1, 2, 3, 4]


def rows(name: str, kind: str, peaks: list[float], **changes: list[Any]) -> pl.DataFrame:
    """Four episodes of a driver."""
    columns: dict[str, Any] = {
        "scored_peak_kN": peaks, "peak_main_kN": [50.0] * 4, "success": [True] * 4, "time_s": [43.0] * 4,
        "over_limit_s": [0.0] * 4, "lift_offs": [0] * 4, "claw_path_m": [8.0] * 4, "reversals": [0] * 4, **changes,
    }  # fmt: skip
    size = len(peaks)
    told = {"driver": [name] * size, "kind": [kind] * size, "delay_ms": [0.0] * size, "member": [name] * size}
    return pl.DataFrame({**told, "seed": SEEDS[:size], **{key: values[:size] for key, values in columns.items()}})


PERSON = rows(
    "P01", "participant", [10.0, 20.0, 30.0, 40.0], success=[True, True, False, True],
    time_s=[40.0, 42.0, 60.0, 44.0], over_limit_s=[0.0, 0.5, 1.0, 2.5], lift_offs=[0, 0, 1, 2],
    claw_path_m=[8.0, 8.2, 8.4, 8.6], reversals=[4, 6, 8, 10],
)  # fmt: skip
BASE = rows("book", "scripted", [20.0, 20.0, 40.0, 60.0])
BOUND = rows("seer", "planner", [10.0, 10.0, 20.0, 20.0])


def test_reversals_are_changes_of_sign_of_commands_outside_the_band() -> None:
    along = [0.5, 0.02, 0.5, -0.5, -0.04, -0.5, 0.3]  # without the small ones + + - - +: two changes
    across = [0.0, 0.2, 0.0, 0.2, -0.05, 0.2, -0.2]  # -0.05 lies on the band: + + + -: one change
    assert reversals(np.stack([along, across], axis=1)) == 3
    assert reversals(np.stack([along, across], axis=1), band=0.01) == 5  # + + + - - - + has 2, + + - + - has 3
    assert reversals(np.zeros((5, 2))) == 0
    assert reversals([]) == 0


def test_the_path_is_the_sum_of_straight_pieces() -> None:
    assert path_m([(0.0, 0.0), (3.0, 4.0), (3.0, 4.0), (3.0, 5.0)]) == 5.0 + 0.0 + 1.0
    assert path_m([(1.0, 1.0)]) == 0.0


def test_figures_of_a_driver() -> None:
    found = own_figures(driver(PERSON, "P01"), OPTIONS)
    peak = found["peak_probe_kN"]
    assert peak["mean"]["value"] == 25.0  # (10 + 20 + 30 + 40) / 4
    assert peak["iqm"]["value"] == 25.0  # 10 and 40 are left out: (20 + 30) / 2
    assert peak["p95"]["value"] == pytest.approx(38.5)  # at 0.95 * 3 = 2.85: 30 + 0.85 * 10
    assert found["success"]["value"] == 0.75
    assert found["time_s"]["value"] == 42.0  # of the successes 40, 42 and 44
    assert found["over_limit_s"]["value"] == 1.0  # (0 + 0.5 + 1 + 2.5) / 4
    assert found["lift_offs"]["value"] == 0.75
    assert found["claw_path_m"]["value"] == pytest.approx(8.3)
    assert found["reversals"]["value"] == 7.0
    low, high = peak["mean"]["ci"]
    assert 10.0 <= low < 25.0 < high <= 40.0


def test_figures_of_a_pair_are_of_differences_sea_by_sea() -> None:
    found = pair_figures(*common(driver(PERSON, "P01"), driver(BASE, "book")), OPTIONS)
    assert found["seas"] == 4
    assert found["peak_mean_kN"]["value"] == -10.0  # (-10 + 0 - 10 - 20) / 4
    assert found["peak_iqm_kN"]["value"] == -10.0  # without -20 and 0: (-10 - 10) / 2
    assert found["peak_p95_kN"]["value"] == pytest.approx(38.5 - 57.0)  # 40 + 0.85 * 20 = 57
    assert found["improvement"]["value"] == 0.875  # lower in three seas, equal in one: (3 + 0.5) / 4
    assert found["success"]["value"] == -0.25
    assert found["time_s"]["value"] == pytest.approx(-1.0)  # where both arrive: (-3 - 1 + 1) / 3
    assert found["over_limit_s"]["value"] == 1.0
    assert found["reversals"]["value"] == 7.0


def test_the_score_lies_between_baseline_and_bound() -> None:
    ends = driver(BASE, "book"), driver(BOUND, "seer")
    found = score(*common(driver(PERSON, "P01"), *ends), OPTIONS)
    assert found["mean"]["value"] == pytest.approx(50.0)  # 100 (35 - 25) / (35 - 15)
    assert found["iqm"]["value"] == pytest.approx(100.0 * 5.0 / 15.0)  # 100 (30 - 25) / (30 - 15)
    assert score(ends[0], *ends, OPTIONS)["mean"]["value"] == 0.0
    assert score(ends[1], *ends, OPTIONS)["mean"]["value"] == 100.0
    assert score(ends[0], ends[1], ends[0], OPTIONS)["mean"]["value"] is None  # a bound above the baseline is none


def test_a_pool_holds_the_seas_that_all_have_met() -> None:
    other = rows("P02", "participant", [12.0, 24.0, 36.0])
    everybody = drivers(pl.concat([PERSON, other], how="diagonal_relaxed"), BASE)
    assert [one.name for one in everybody] == ["P01", "P02", "all participants", "book"]
    pool = everybody[2]
    assert pool.members == ("P01", "P02") and pool.pooled and pool.episodes.seas.tolist() == [1, 2, 3]
    assert own_figures(pool, OPTIONS)["peak_probe_kN"]["mean"]["value"] == 22.0  # (10 + 20 + 30 + 12 + 24 + 36) / 6
    found = pair_figures(*common(pool, everybody[3]), OPTIONS)
    assert found["peak_mean_kN"]["value"] == pytest.approx((-10.0 + 0.0 - 10.0 - 8.0 + 4.0 - 4.0) / 6.0)
    assert found["improvement"]["value"] == pytest.approx((1.0 + 0.5 + 1.0 + 1.0 + 0.0 + 1.0) / 6.0)


def test_scripted_drivers_are_never_pooled_with_people() -> None:
    script = rows("scripted P01", "scripted operator", [12.0, 24.0, 36.0, 48.0])
    names = [one.name for one in drivers(pl.concat([script, PERSON], how="diagonal_relaxed"), BASE)]
    assert names == ["P01", "scripted P01", "book"]


def test_improvement_counts_ties_half() -> None:
    assert improvement([1.0, 2.0, 3.0, 4.0], [2.0, 2.0, 2.0, 2.0]) == 0.375  # (1 + 0.5 + 0 + 0) / 4
