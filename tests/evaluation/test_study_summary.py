"""Figures of a study, checked by hand on rows that were made up; and the aims, each held and each missed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.statistics import bootstrap, mean, p95, share
from ssmash_gym.evaluation.study import load_study
from ssmash_gym.evaluation.study_figures import (
    Episodes,
    Options,
    beyond_hold,
    gap_figures,
    pair_figures,
    policy_figures,
)
from ssmash_gym.evaluation.study_rows import STUDY, StudyRows
from ssmash_gym.evaluation.study_summary import best_law, summarise
from ssmash_gym.evaluation.targets import HOLDS, HOLDS_NOT, NO_DATA, WITHIN, sentences

QUICK = Options(resamples=200)
ORDINARY: dict[str, Any] = {
    "success": True, "aligned": True, "failed": False, "time_s": 40.0, "scored_peak_kN": 10.0, "peak_main_kN": 60.0,
    "lift_offs": 0, "over_limit_s": 0.0, "cost_corridor": 0, "final_yaw_deg": 0.5, "sea_hs_m": 3.3,
}  # fmt: skip


def made_up(policy: str, training_seed: int | None = None, condition: str = "ss5", **columns: Any) -> pl.DataFrame:
    """Rows of one policy; numbers that are lists set the number of seas."""
    count = next((len(values) for values in columns.values() if isinstance(values, list | np.ndarray)), 4)
    given = {name: columns.get(name, value) for name, value in ORDINARY.items()}
    numbers = {
        name: value if isinstance(value, list | np.ndarray) else [value] * count for name, value in given.items()
    }
    return pl.DataFrame(numbers).select(
        pl.lit(policy).alias("policy"),
        pl.lit(training_seed, dtype=pl.Int64).alias("training_seed"),
        pl.lit(condition).alias("condition"),
        pl.int_range(count, dtype=pl.Int64).alias("sea"),
        pl.lit("x").alias("configuration"),
        pl.lit("y").alias("code"),
        pl.all(),
    )


def episodes(*frames: pl.DataFrame) -> Episodes:
    rows = StudyRows.of(pl.concat(frames))
    policy = frames[0]["policy"][0]
    return Episodes.of(rows, "ss5", policy, rows.seas("ss5", policy))


def test_figures_of_a_policy_by_hand() -> None:
    found = policy_figures(
        episodes(
            made_up(
                "law",
                success=[True, True, False, False],
                aligned=[True, True, True, False],
                failed=[False, False, True, False],
                time_s=[40.0, 44.0, 10.0, 60.0],
                scored_peak_kN=[4.0, 8.0, 75.0, 9.0],
                over_limit_s=[0.0, 4.4, 5.0, 0.0],
                lift_offs=[0, 1, 2, 0],
                cost_corridor=[0, 0, 3, 0],
                final_yaw_deg=[-1.0, 0.5, 0.0, 2.5],
            )
        ),
        QUICK,
    )
    value = {name: one["value"] for name, one in found.items() if isinstance(one, dict) and "value" in one}
    assert value == pytest.approx(
        {
            "success": 0.5, "aligned": 0.5, "failed": 0.25, "corridor": 0.25, "time_s": 42.0, "final_yaw_deg": 1.0,
            "over_limit_share": (0.1 + 0.5) / 4.0, "lift_offs": 0.75, "lift_offs_per_min": (60.0 / 44.0 + 12.0) / 4.0,
        }
    )  # fmt: skip
    assert found["success"]["ci"] == share([1.0, 1.0, 0.0, 0.0]).interval
    load = found["peak_probe_kN"]
    assert load["mean"]["value"] == 24.0 and load["iqm"]["value"] == 8.5  # 8 and 9 are left
    assert load["p95"]["value"] == pytest.approx(9.0 + 0.85 * (75.0 - 9.0))
    expected = bootstrap([4.0, 8.0, 75.0, 9.0], p95, resamples=200)
    assert load["p95"]["ci"] == expected.interval
    assert (found["episodes"], found["seas"], found["training_seeds"]) == (4, 4, [])


def test_times_are_of_all_episodes_where_none_succeeds() -> None:
    nobody = made_up("hold", success=False, time_s=[60.0, 60.0, 10.0])
    assert policy_figures(episodes(nobody), QUICK)["time_s"]["value"] == 60.0


def test_one_sea_gives_no_interval_of_a_load() -> None:
    found = policy_figures(episodes(made_up("law", scored_peak_kN=[7.0])), QUICK)
    assert found["peak_probe_kN"]["p95"] == {"value": 7.0, "ci": None}
    assert found["success"]["ci"] == share([1.0]).interval


def test_several_training_seeds_are_pooled_and_told_apart() -> None:
    frames = [made_up("mine", k, scored_peak_kN=[float(k + 1)] * 6, success=[k < 2] * 6) for k in range(3)]
    found = policy_figures(episodes(*frames), QUICK)
    assert (found["episodes"], found["seas"], found["training_seeds"]) == (18, 6, [0, 1, 2])
    assert found["success"]["value"] == pytest.approx(2 / 3)
    assert found["success"]["ci"] == pytest.approx([0.0, 1.0])  # what three seeds can say
    assert [one["mean_kN"] for one in found["per_seed"]] == [1.0, 2.0, 3.0]
    all_of_them = policy_figures(episodes(made_up("mine", 0), made_up("mine", 1)), QUICK)["success"]
    assert all_of_them == {"value": 1.0, "ci": share(np.ones(4)).interval}  # of 4 seas, not of 8 episodes


def test_one_miss_does_not_narrow_the_interval_of_a_share() -> None:
    hits = np.ones((5, 60), dtype=bool)
    missed = hits.copy()
    missed[2, 7] = False
    low = []
    for table in (hits, missed):
        frames = [made_up("mine", k, success=list(row)) for k, row in enumerate(table)]
        low.append(policy_figures(episodes(*frames), QUICK)["success"]["ci"][0])
    assert low[1] <= low[0] == share(np.ones(60)).low


def test_what_a_policy_adds_to_standing_still() -> None:
    driven = episodes(made_up("law", scored_peak_kN=[12.0, 8.0, 9.0, 20.0], lift_offs=[3, 0, 0, 1], time_s=30.0))
    held = episodes(made_up("hold", scored_peak_kN=[10.0, 9.0, 9.0, 10.0], lift_offs=[1, 0, 2, 1], time_s=60.0))
    found = beyond_hold(driven, held, QUICK)
    assert found["excess_kN"]["mean"]["value"] == pytest.approx((2.0 - 1.0 + 0.0 + 10.0) / 4.0)
    assert found["excess"]["lift_offs"]["value"] == 0.0
    assert found["excess"]["lift_offs_per_min"]["value"] == pytest.approx((5.0 + 0.0 - 2.0 + 1.0) / 4.0)
    assert found["excess"]["more_lift_offs_share"]["value"] == 0.25


def test_a_pair_by_hand() -> None:
    ours = episodes(
        made_up("mine", scored_peak_kN=[5.0, 5.0, 5.0, 5.0], success=[True, True, True, False], time_s=44.0)
    )
    theirs = episodes(made_up("law", scored_peak_kN=[10.0, 10.0, 10.0, 4.0], lift_offs=1, peak_main_kN=61.5))
    found = pair_figures(ours, theirs, QUICK)
    value = {name: one["value"] for name, one in found.items() if name != "seas"}
    assert value == pytest.approx(
        {
            "p95_kN": 5.0, "other_p95_kN": 10.0,
            "p95_difference_kN": -5.0, "p95_ratio": 0.5, "mean_difference_kN": -3.5, "mean_ratio": 5.0 / 8.5,
            "iqm_difference_kN": -5.0, "main_p95_difference_kN": -1.5, "time_ratio": 1.1, "lower_peak_share": 0.75,
            "success_difference": -0.25, "aligned_difference": 0.0, "lift_offs_difference": -1.0,
            "lift_offs_per_min_difference": -1.5, "corridor_difference": 0.0,
        }
    )  # fmt: skip


def test_a_pair_is_paired() -> None:
    sea = np.random.default_rng(0).lognormal(2.5, 0.5, 100)
    found = pair_figures(
        episodes(made_up("mine", scored_peak_kN=0.7 * sea)), episodes(made_up("law", scored_peak_kN=sea)), QUICK
    )
    assert found["p95_ratio"]["value"] == pytest.approx(0.7)
    assert found["p95_ratio"]["ci"] == pytest.approx([0.7, 0.7])
    assert found["mean_difference_kN"]["ci"][1] < 0.0


def test_the_way_to_the_clairvoyant() -> None:
    law, mine, far = (
        episodes(made_up(name, scored_peak_kN=loads))
        for name, loads in (("law", [10.0, 12.0]), ("mine", [7.0, 8.0]), ("far", [4.0, 6.0]))
    )
    found = gap_figures(law, mine, far, QUICK)
    assert found["mean"]["value"] == pytest.approx((11.0 - 7.5) / (11.0 - 5.0))
    assert gap_figures(law, law, far, QUICK)["mean"] == {"value": 0.0, "ci": [0.0, 0.0]}
    assert gap_figures(far, mine, law, QUICK)["mean"] == {"value": None, "ci": None}  # there is no such way


def test_the_best_law_is_among_those_of_the_same_success() -> None:
    def figures(success: float, load: float) -> dict[str, Any]:
        return {"success": {"value": success}, "peak_probe_kN": {"p95": {"value": load}}}

    laws = {"soft": figures(0.90, 8.0), "firm": figures(0.96, 12.0), "hard": figures(1.0, 20.0)}
    roles = load_study("smoke").roles.model_copy(update={"laws": tuple(laws)})
    assert best_law(roles, laws, 0.97) == "firm"  # 95 % is enough, as for the agent
    assert best_law(roles, laws, 0.89) == "soft"
    assert best_law(roles, {"soft": laws["soft"]}, 0.99) == "soft"  # none has it: the nearest
    assert best_law(roles, {}, 0.9) is None


# --- a whole folder ------------------------------------------------------------------------------------------------

SEAS = 200
SEA = np.random.default_rng(1).lognormal(2.5, 0.4, SEAS)
GOOD: dict[str, Any] = {"scored_peak_kN": 0.6 * SEA, "time_s": 43.0}


def folder(out: Path, mine: Mapping[str, Any], straight: Mapping[str, Any] = GOOD) -> dict[str, Any]:
    """A study's folder with made-up rows, summarised."""
    study = load_study(
        {
            "seed": 1, "episodes": SEAS, "resamples": 100,
            "conditions": {name: {"scenario": "ss5"} for name in ("ss5", "straight", "slow")},
            "runs": [{"conditions": ["ss5"]}],
            "roles": {"laws": ["law"], "clairvoyant": "far", "speeds": ["trapezoid@0.1", "trapezoid@0.2"]},
            "targets": {"main": "ss5", "straight": "straight", "curve": "slow"},
        }
    )  # fmt: skip
    frames = [
        made_up("hold", scored_peak_kN=SEA, success=False, time_s=60.0),
        made_up("trapezoid", scored_peak_kN=3.0 * SEA),
        made_up("law", scored_peak_kN=SEA, time_s=44.0),
        made_up("law", scored_peak_kN=SEA, condition="straight"),
        made_up("far", scored_peak_kN=0.4 * SEA[:50]),
        made_up("mine", 0, **mine),
        made_up("mine", 0, condition="straight", **straight),
        made_up("trapezoid@0.1", condition="slow", scored_peak_kN=SEA, time_s=80.0),
        made_up("trapezoid@0.2", condition="slow", scored_peak_kN=3.0 * SEA, time_s=40.0),
    ]
    (out / "rows").mkdir(parents=True)
    for k, frame in enumerate(frames):
        frame.write_parquet(out / "rows" / f"{k}.parquet")
    kinds = {"hold": "scripted", "trapezoid": "scripted", "law": "scripted", "far": "planner", "mine": "agent"}
    kinds |= dict.fromkeys(("trapezoid@0.1", "trapezoid@0.2"), "scripted")
    record = {
        "study": "made up", "configuration": "z", "versions": {}, "resolved": study.model_dump(mode="json"),
        "conditions": {name: {"description": ""} for name in study.conditions},
        "policies": {name: {"kind": kind} for name, kind in kinds.items()},
    }  # fmt: skip
    (out / STUDY).write_text(json.dumps(record))
    return summarise(out, shown=False)


def verdicts(summary: dict[str, Any]) -> list[tuple[int, str]]:
    return [(check["line"], check["verdict"]) for check in summary["targets"]]


def test_a_summary_holds_all_that_can_be_compared(tmp_path: Path) -> None:
    summary = folder(tmp_path / "out", GOOD)
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == summary
    here = summary["conditions"]["ss5"]
    assert here["best_law"] == {"mine": "law"} and summary["best_law"] == "law"
    pairs = {(pair["policy"], pair["other"]): pair for pair in here["pairs"]}
    assert {("mine", other) for other in ("hold", "trapezoid", "law", "far")} <= set(pairs)
    assert {("far", "law"), ("law", "trapezoid"), ("hold", "trapezoid")} <= set(pairs)
    assert pairs["mine", "law"]["seas"] == SEAS and pairs["mine", "far"]["seas"] == 50  # those that both have met
    assert here["gap"]["mine"]["seas"] == 50
    assert here["gap"]["mine"]["mean"]["value"] == pytest.approx((1.0 - 0.6) / (1.0 - 0.4))
    assert "excess_kN" in here["policies"]["law"] and "excess_kN" not in here["policies"]["hold"]
    assert here["policies"]["far"]["excess_kN"]["mean"]["value"] == pytest.approx(float(mean(-0.6 * SEA[:50])))


def test_load_against_time_is_read_between_the_books_speeds(tmp_path: Path) -> None:
    curve = folder(tmp_path, GOOD)["curve"]
    assert [point["policy"] for point in curve["points"]] == ["trapezoid@0.2", "trapezoid@0.1"]
    own = curve["equal_time"]["mine"]
    highest = float(p95(SEA))
    assert own["book_p95_kN"] == pytest.approx(highest * (3.0 - 2.0 * (43.0 - 40.0) / 40.0))
    assert own["ratio"] == pytest.approx(0.6 * highest / own["book_p95_kN"])
    assert set(curve["equal_time"]) == {"mine", "trapezoid", "law", "far"}  # standing still takes no time to compare


def test_all_aims_held(tmp_path: Path) -> None:
    summary = folder(tmp_path, GOOD)
    assert verdicts(summary) == [(line, HOLDS) for line in (1, 1, 1, 1, 2, 3, 4, 4, 4)]
    told = sentences(summary["targets"])
    assert told[0] == ("1. mine in ss5: at least 95 % of the episodes succeed, aligned: 100.0 [98.1, 100.0] %: holds")
    assert "60.0 [60.0, 60.0] % of it" in told[3]
    assert "66.7 [66.7, 66.7] % from law in 50 seas" in told[5]


def test_all_aims_missed(tmp_path: Path) -> None:
    rare = np.arange(SEAS) % 10 == 0
    bad = {
        "scored_peak_kN": 1.2 * SEA, "time_s": 47.5, "success": ~rare, "peak_main_kN": 70.0, "lift_offs": 2,
        "cost_corridor": np.where(rare, 3, 0),
    }  # fmt: skip
    summary = folder(tmp_path, bad, {"scored_peak_kN": 0.95 * SEA})
    assert verdicts(summary) == [(line, HOLDS_NOT) for line in (1, 1, 1, 1, 2, 3, 4, 4, 4)]


def test_a_little_above_the_law_may_be_chance(tmp_path: Path) -> None:
    once = GOOD | {"lift_offs": [1, *[0] * (SEAS - 1)], "peak_main_kN": 60.0}
    summary = folder(tmp_path, once)
    assert verdicts(summary)[-3:] == [(4, HOLDS), (4, WITHIN), (4, HOLDS)]


def test_a_ratio_without_a_sure_difference_does_not_hold(tmp_path: Path) -> None:
    """A few seas decide over a percentile of so few: far below by luck is not enough."""
    wild = np.random.default_rng(2).permutation(np.concatenate([np.full(SEAS - 11, 1.0), np.full(11, 40.0)]))
    mine = GOOD | {"scored_peak_kN": wild}
    summary = folder(tmp_path, mine)
    law = next(
        check for check in summary["targets"] if check["statement"].endswith("that of law") and check["line"] == 1
    )
    assert law["verdict"] == HOLDS_NOT


def test_what_was_not_run_is_no_data(tmp_path: Path) -> None:
    folder(tmp_path, GOOD)
    for name in ("1", "2", "3", "4", "6"):
        (tmp_path / "rows" / f"{name}.parquet").unlink()
    assert [verdict for _, verdict in verdicts(summarise(tmp_path, shown=False))][1:] == [NO_DATA] * 8


def test_a_folder_without_rows_is_refused(tmp_path: Path) -> None:
    folder(tmp_path, GOOD)
    for path in (tmp_path / "rows").iterdir():
        path.unlink()
    with pytest.raises(ConfigurationError, match="no row"):
        summarise(tmp_path, shown=False)


def test_who_fails_at_once_is_not_praised_for_its_time_and_its_tires(tmp_path: Path) -> None:
    early = {"scored_peak_kN": 75.0 + 0.0 * SEA, "success": False, "failed": True, "aligned": False, "time_s": 5.0}
    found = [check for check in folder(tmp_path, early)["targets"] if check["condition"] == "ss5"]
    assert {check["verdict"] for check in found} <= {"does not hold", "no data"}
    assert next(check["figure"] for check in found if "median time" in check["statement"]) == "no episode succeeded"
