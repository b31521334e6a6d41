"""Evaluation: frozen seeds give frozen numbers, the summary keeps its form, mistakes cost one sentence."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import polars as pl
import pytest
from rich.console import Console

from ssmash_gym.cli import main
from ssmash_gym.document import write_yaml
from ssmash_gym.envs.limits import LIMITS
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation import episodes as running
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.evaluate import scenario_name, typical_seed
from ssmash_gym.evaluation.policies import baselines, find_agent, make_baseline
from ssmash_gym.evaluation.report import severity_table
from ssmash_gym.evaluation.statistics import share
from ssmash_gym.evaluation.summary import comparison, policy_summary

SHORT = {"horizon_s": 6.0, "lead_in": {"duration_s": 5.0, "ramp_s": 4.0}}


@pytest.fixture(scope="module")
def short_task(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The task with a horizon of 6 s, as a file."""
    path = tmp_path_factory.mktemp("task") / "short.yaml"
    path.write_text(write_yaml(load_task(SHORT).model_dump(mode="json")))
    return path


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory, short_task: Path) -> Path:
    """Results of the baselines on three short episodes."""
    out = tmp_path_factory.mktemp("out") / "results"
    words = ["--task", str(short_task), "--episodes", "3", "--seed", "5", "--out", str(out)]
    assert main(["evaluate", "--agent", "yield", "--against", "trapezoid,hold,yield", "--no-film", *words]) == 0
    return out


def rows(**columns: Any) -> pl.DataFrame:
    """Rows as `run_episodes` gives them: two episodes with the named columns changed."""
    ordinary: dict[str, Any] = {
        "success": True, "failed": False, "aligned": True, "reason": "goal", "time_s": 40.0, "scored_peak_kN": 10.0,
        "peak_probe_kN_no_grace": 11.0, "p95_probe_kN": 8.0, "peak_main_kN": 50.0, "least_station_kN": 5.0,
        "lift_offs": 0, "final_yaw_deg": 0.1, "return": 10.0, **{f"cost_{name}": 0 for name in LIMITS},
        "sea_lateral_g": 0.05, "within_validity": True,
    }  # fmt: skip
    return pl.DataFrame({name: columns.get(name, [value, value]) for name, value in ordinary.items()})


def test_the_summary_has_its_form(results: Path) -> None:
    summary = json.loads((results / "summary.json").read_text())
    assert list(summary["policies"]) == ["yield", "trapezoid", "hold"]
    for found in summary["policies"].values():
        assert found["episodes"] == 3
        assert 0.0 <= found["success_rate"] <= 1.0
        assert 0.0 <= found["aligned_rate"] <= 1.0
        low, high = found["peak_probe_kN"]["p95_ci"]
        assert low <= found["peak_probe_kN"]["p95"] <= high
        assert found["peak_probe_kN"]["mean"] > 0.0
        assert found["time_s"]["median"] == pytest.approx(6.0)
        assert 0.0 <= found["lift_off_rate"] <= 1.0
        assert set(found["cost_rates"]) == set(LIMITS)
        assert 0.0 <= found["outside_validity_rate"] <= 1.0
        assert sum(band["episodes"] for band in found["by_lateral_g"]) == 3
        low, high = found["success_rate_ci"]
        assert low == 0.0 and 0.5 < high < 0.6  # none of 3, Wilson
    assert {"seed", "version", "configuration", "comparison"} <= set(summary)
    assert (summary["scenario"], summary["scenario_description"]) == ("training", load_scenario("training").description)
    assert set(summary["comparison"]) == {"trapezoid", "hold"}


def test_results_hold_a_row_an_episode_and_a_picture(results: Path) -> None:
    frame = pl.read_parquet(results / "episodes.parquet")
    assert frame.group_by("policy").len()["len"].to_list() == [3, 3, 3]
    seeds = [frame.filter(policy=name)["seed"].to_list() for name in ("yield", "trapezoid", "hold")]
    assert seeds[0] == seeds[1] == seeds[2]
    assert len(set(seeds[0])) == 3
    sea = ["sea_lateral_g", "sea_roll_deg", "sea_hs_m", "sea_heading_deg", "sea_speed_kn", "within_validity"]
    assert frame.filter(policy="yield").select(sea).equals(frame.filter(policy="hold").select(sea))
    assert frame["sea_hs_m"].is_between(0.5, 5.0).all() and frame["sea_lateral_g"].is_between(0.0, 0.3).all()
    assert frame["sea_heading_deg"].is_between(0.0, 360.0).all() and frame["sea_speed_kn"].is_between(0.0, 20.0).all()
    assert (results / "peaks.png").read_bytes().startswith(b"\x89PNG")


def test_same_seed_same_numbers(results: Path, short_task: Path, tmp_path: Path) -> None:
    words = ["--task", str(short_task), "--seed", "5", "--no-plots", "--out", str(tmp_path)]
    assert main(["evaluate", "--against", "trapezoid", "--episodes", "3", "--threads", "1", *words]) == 0
    policies = [json.loads((folder / "summary.json").read_text())["policies"] for folder in (results, tmp_path)]
    assert policies[1]["trapezoid"] == policies[0]["trapezoid"]


def test_episodes_do_not_depend_on_how_they_are_grouped(monkeypatch: pytest.MonkeyPatch) -> None:
    task, scenario = load_task(SHORT), load_scenario("training")
    together = run_episodes(make_baseline("yield", task), scenario, [1, 2, 3])
    monkeypatch.setattr(running, "LARGEST_BATCH", 2)
    assert run_episodes(make_baseline("yield", task), scenario, [1, 2, 3]).equals(together)
    assert run_episodes(make_baseline("yield", task), scenario, [3]).equals(together[2:])


def test_what_is_told_of_progress_adds_up_to_what_was_simulated() -> None:
    told: list[int] = []
    frame = run_episodes(make_baseline("hold", load_task(SHORT)), load_scenario("flat"), [1, 2], tell=told.append)
    assert sum(told) == round(frame["time_s"].sum() / 0.1)
    sea = frame.select("sea_hs_m", "sea_heading_deg", "sea_speed_kn")  # columns of numbers also where there is no sea
    assert sea.dtypes == [pl.Float64] * 3 and sea.null_count().row(0) == (2, 2, 2)


def test_a_failed_episode_counts_with_the_ultimate_load() -> None:
    task = load_task(SHORT | {"limits": {"probe_ultimate_kN": 1.0}})
    frame = run_episodes(make_baseline("trapezoid", task), load_scenario("training"), [1, 2])
    assert set(frame["reason"]) == {"ultimate_load"}
    assert frame["scored_peak_kN"].to_list() == [1.0, 1.0]
    assert policy_summary(frame)["failure_rate"] == 1.0


def test_an_episode_out_of_time_counts_with_its_own_peak_and_no_success() -> None:
    frame = run_episodes(make_baseline("hold", load_task(SHORT)), load_scenario("training"), [1])
    assert frame["reason"].to_list() == ["time"]
    assert frame["scored_peak_kN"].to_list() == frame["peak_probe_kN"].to_list()
    assert not frame["success"][0]


def test_times_are_those_of_successes() -> None:
    frame = rows(success=[True, False], reason=["goal", "time"], time_s=[41.0, 60.0])
    found = policy_summary(frame)
    assert found["time_s"]["median"] == 41.0
    assert found["success_rate"] == 0.5
    nobody = rows(success=[False, False], reason=["time", "time"], time_s=[60.0, 60.0])
    assert policy_summary(nobody)["time_s"]["median"] == 60.0


def test_a_failure_is_not_aligned_and_costs_count_once_an_episode() -> None:
    failed = rows(failed=[True, False], success=[False, True], reason=["corridor", "goal"], cost_probe_in_plane=[7, 0])
    found = policy_summary(failed)
    assert found["aligned_rate"] == 0.5
    assert found["cost_rates"]["probe_in_plane"] == 0.5
    assert found["reasons"] == {"corridor": 1, "goal": 1}


def test_severity_of_the_seas_is_told() -> None:
    """Bands of the lateral specific force hold each episode once; empty ones are left out."""
    seas = rows(sea_lateral_g=[0.01, 0.09], within_validity=[True, False], success=[True, False])
    seas = seas.with_columns(scored_peak_kN=pl.Series([6.0, 30.0]))
    found = policy_summary(seas)
    assert found["outside_validity_rate"] == 0.5
    mild, rough = found["by_lateral_g"]
    assert mild == {
        "from_g": 0.0, "to_g": 0.02, "episodes": 1, "success_rate": 1.0, "success_rate_ci": share([1.0]).interval,
        "peak_probe_kN": {"mean": 6.0, "p95": None},
    }  # fmt: skip
    assert (rough["from_g"], rough["to_g"], rough["success_rate"]) == (0.08, None, 0.0)
    console = Console(width=140)
    with console.capture() as shown:
        console.print(severity_table({"yield": found}))
    text = shown.get()
    assert "0 to 0.02 g" in text and "from 0.08 g" in text and "30.0 / -, 0" in text and "50.0 %" in text


def test_a_band_needs_twenty_episodes_for_a_95th_percentile() -> None:
    seas = pl.concat([rows(scored_peak_kN=[6.0, 30.0])] * 10)
    assert policy_summary(seas[:19])["by_lateral_g"][0]["peak_probe_kN"]["p95"] is None
    full = policy_summary(seas)
    assert full["by_lateral_g"][0]["peak_probe_kN"]["p95"] == 30.0
    console = Console(width=140)
    with console.capture() as shown:
        console.print(severity_table({"yield": full}))
    assert "18.0 / 30.0, 100" in shown.get()


def test_the_scenario_has_a_name_in_table_and_summary(
    tmp_path: Path, short_task: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "my_sea.yaml"
    mine.write_text("motion: {type: fixed}\n")
    words = ["--task", str(short_task), "--episodes", "1", "--no-plots", "--against", "hold", "--out", str(tmp_path)]
    for given, name in ((str(mine), "my_sea"), ("flat", "flat")):
        assert main(["evaluate", *words, "--scenario", given]) == 0
        assert f"scenario {name}, 1 episodes" in capsys.readouterr().out
        assert json.loads((tmp_path / "summary.json").read_text())["scenario"] == name


def test_an_agents_own_scenario_is_called_by_name() -> None:
    about = {"name": "mine"}
    one = SimpleNamespace(scenario=load_scenario("ss4"), **about)
    other = SimpleNamespace(scenario=load_scenario({"base": "ss4", "sensors": {"noise": 0.0}}), **about)
    assert [scenario_name(agent) for agent in (one, other)] == ["ss4", "of mine"]  # type: ignore[arg-type]


def test_on_time_means_within_a_fifth_of_the_others_median() -> None:
    slow = rows(time_s=[47.9, 48.1], scored_peak_kN=[5.0, 12.0])
    found = comparison(slow, rows())
    assert found["allowed_time_s"] == pytest.approx(48.0)
    assert found["on_time_rate"] == 0.5
    assert found["lower_peak_rate"] == 0.5
    assert found["mean_ratio"] == pytest.approx(0.85)


def test_the_filmed_episode_is_the_typical_one() -> None:
    frame = pl.DataFrame({"seed": [1, 2, 3], "scored_peak_kN": [3.0, 9.0, 40.0]})
    assert typical_seed(frame) == 2


def test_the_film_shows_the_evaluated_episode(tmp_path: Path) -> None:
    from ssmash_gym.evaluation.film import film_episode

    policy = make_baseline("trapezoid", load_task(SHORT | {"horizon_s": 2.0}))
    scenario = load_scenario("training")
    metrics = film_episode(policy, scenario, 7, tmp_path / "episode.mp4")
    frame = run_episodes(policy, scenario, [7])
    assert metrics["peak_probe_kN"] == frame["peak_probe_kN"][0]
    assert metrics["return"] == frame["return"][0]
    assert (tmp_path / "episode.mp4").stat().st_size > 1000
    assert [path.name for path in tmp_path.iterdir()] == ["episode.mp4"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--against", "trapezoid,tractor"], "'tractor'"),
        (["--agent", "no_such"], "'no_such'"),
        (["--episodes", "0"], "--episodes 0"),
        (["--seed", "-1"], "--seed -1"),
        (["--threads", "0"], "--threads 0"),
        (["--study", "smoke", "--agent", "yield"], "'yield' is a scripted policy, no trained agent"),
        (["--study", "smoke", "--episodes", "5"], "--episodes 5 is refused: the study has 4 seas"),
        (["--scenario", "no_such.yaml"], "no_such.yaml"),
        (["--against", ""], "nothing to evaluate"),
    ],
)
def test_a_mistake_costs_one_sentence_and_nothing_is_written(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["evaluate", *words, "--out", str(out)]) == 1
    message = capsys.readouterr().err
    assert told in message
    assert message.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("missing", "words", "extra"),
    [("matplotlib", [], "plot"), ("imageio_ffmpeg", ["--agent", "yield", "--no-plots"], "render")],
)
def test_a_missing_library_names_its_extra(
    missing: str, words: list[str], extra: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    assert main(["evaluate", *words]) == 1
    assert f"ssmash_gym[{extra}]" in capsys.readouterr().err


def test_a_run_that_is_not_finished_is_told(tmp_path: Path) -> None:
    (tmp_path / "training.yaml").write_text("name: x\n")
    with pytest.raises(ConfigurationError, match="not been finished"):
        find_agent(str(tmp_path))


def test_baselines_are_found_by_name() -> None:
    assert {"hold", "trapezoid", "yield"} <= set(baselines())
    assert all(make_baseline(name, load_task()).name == name for name in baselines())
    np.testing.assert_array_equal(make_baseline("hold", load_task()).act(np.zeros((2, 3), np.float32)), 0.0)


def test_a_comparison_does_not_write_into_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "study.json").write_text("{}")
    assert main(["evaluate", "--against", "hold", "--out", str(tmp_path)]) == 1
    assert "a study lies there" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["study.json"]
