"""Running a study: resumed rows are the same rows, whatever chunks and threads; what does not fit is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from polars.testing import assert_frame_equal

from ssmash_gym.cli import main
from ssmash_gym.document import write_yaml
from ssmash_gym.envs.limits import LIMITS
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation import study_run, study_verb
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.evaluation.study import StudyConfig
from ssmash_gym.evaluation.study_rows import KEYS, OF_A_SEA, StudyRows, read_rows
from ssmash_gym.evaluation.study_run import planned, run_study
from tests.evaluation.studies import short_study, untrained

ORDER = ("condition", "policy", "training_seed", "sea")


def run(study: StudyConfig, out: Path, agents: tuple[str, ...] = (), threads: int = 1) -> pl.DataFrame:
    return run_study(planned(study, "short", agents), out, threads=threads, shown=False).sort(ORDER)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a study that was run in one go."""
    out = tmp_path_factory.mktemp("studies") / "whole"
    run(short_study(), out)
    return out


@pytest.fixture(scope="module")
def rows(whole: Path) -> pl.DataFrame:
    return read_rows(whole).sort(ORDER)


def test_rows_have_their_columns(rows: pl.DataFrame) -> None:
    assert rows.columns[: len(KEYS)] == list(KEYS)
    assert rows.height == 2 * 2 * 5 and rows["training_seed"].null_count() == rows.height
    metrics = {"success", "aligned", "scored_peak_kN", "failed", "time_s", "over_limit_s", "lift_offs", "reason"}
    assert metrics | {f"cost_{name}" for name in LIMITS} <= set(rows.columns)


def test_everyone_meets_the_same_seas(rows: pl.DataFrame) -> None:
    of_seas = [rows.filter(policy=name, condition="calm").select("sea", *OF_A_SEA) for name in ("hold", "trapezoid")]
    assert_frame_equal(*of_seas)
    assert of_seas[0]["sea"].to_list() == sorted(short_study().seas)
    soft = rows.filter(policy="hold", condition="soft")
    assert_frame_equal(of_seas[0], soft.select("sea", *OF_A_SEA))
    peak = rows.filter(policy="hold", condition="calm")["peak_probe_kN_no_grace"]
    assert (peak != soft["peak_probe_kN_no_grace"]).all()  # but another probe


def test_rows_are_those_of_the_episodes(rows: pl.DataFrame) -> None:
    study = short_study()
    condition = study.resolved()["soft"]
    policy = make_baseline("trapezoid", condition.task)
    direct = run_episodes(policy, condition.scenario, study.seas, helicopter=condition.helicopter).sort("seed")
    kept = rows.filter(policy="trapezoid", condition="soft")
    assert_frame_equal(kept.select(direct.rename({"seed": "sea"}).columns), direct.rename({"seed": "sea"}))


def test_chunks_and_threads_do_not_change_rows(rows: pl.DataFrame, tmp_path: Path) -> None:
    assert_frame_equal(run(short_study(chunk=5), tmp_path, threads=2), rows)


def test_a_study_that_was_stopped_goes_on_to_the_same_rows(
    rows: pl.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def stopped(*words: Any, **options: Any) -> pl.DataFrame:
        calls.append(len(words[2]))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return run_episodes(*words, **options)

    monkeypatch.setattr(study_run, "run_episodes", stopped)
    with pytest.raises(KeyboardInterrupt):
        run(short_study(), tmp_path)
    kept = read_rows(tmp_path)
    assert kept.height == sum(calls[:3]) == 8
    assert_frame_equal(run(short_study(chunk=2), tmp_path), rows)  # chunked otherwise from there on
    assert sum(calls[4:]) == rows.height - kept.height
    before = len(calls)
    assert_frame_equal(run(short_study(), tmp_path), rows)
    assert len(calls) == before  # nothing was left to do
    assert not [path for path in tmp_path.rglob(".*")]


@pytest.mark.usefixtures("agents_without_training")
def test_agents_come_later_into_the_same_folder(rows: pl.DataFrame, tmp_path: Path) -> None:
    run(short_study(), tmp_path)
    folders = [str(untrained(tmp_path / f"run{seed}", value, seed)) for seed, value in ((0, 0.1), (4, 0.2))]
    found = run(short_study(), tmp_path, (f"mine={folders[0]},{folders[1]}",))
    assert_frame_equal(found.filter(pl.col("policy") != "mine"), rows)
    table = StudyRows.of(found)
    assert table.seeds("calm", "mine") == [0, 4]
    assert table.table("calm", "mine", "final_to_go_m", table.seas("calm", "mine", "hold")).shape == (2, 5)
    again = run(short_study(), tmp_path)  # without them: their rows stay
    assert again.filter(policy="mine").height == 20
    record = json.loads((tmp_path / "study.json").read_text())
    assert record["policies"]["mine"]["kind"] == "agent" and set(record["policies"]["mine"]["seeds"]) == {"0", "4"}


@pytest.mark.usefixtures("agents_without_training")
def test_another_agent_of_the_same_name_is_refused_in_whatever_condition(tmp_path: Path) -> None:
    first, other = (untrained(tmp_path / name, value, 4) for name, value in (("first", 0.2), ("other", 0.3)))
    study, out = short_study(), tmp_path / "out"
    run_study(planned(study, "short", (f"mine={first}",), study.narrowed((), ("calm",), 2)), out, shown=False)
    with pytest.raises(ConfigurationError, match="mine of training seed 4 was another one there"):
        run_study(planned(study, "short", (f"mine={other}",), study.narrowed((), ("soft",), 2)), out, shown=False)


def test_a_study_in_parts_is_recorded_whole(tmp_path: Path, whole: Path) -> None:
    study = short_study()
    for condition in ("soft", "calm"):
        run_study(planned(study, "short", (), study.narrowed(("hold",), (condition,), 2)), tmp_path, shown=False)
    apart, together = (json.loads((out / "study.json").read_text()) for out in (tmp_path, whole))
    assert apart["resolved"] == together["resolved"] and apart["configuration"] == together["configuration"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"seed": 4}, "seed 3, not 4"),
        ({"conditions": {**short_study().model_dump()["conditions"], "soft": {"scenario": "ss6"}}}, "condition soft"),
    ],
)
def test_a_changed_study_refuses_to_mix(whole: Path, rows: pl.DataFrame, changes: dict[str, Any], told: str) -> None:
    before = (whole / "study.json").read_text()
    part = short_study(**changes).narrowed(("hold",), ("calm",), 2)
    with pytest.raises(ConfigurationError, match="must not be mixed") as refused:
        run(part, whole)
    assert told in str(refused.value)
    assert (whole / "study.json").read_text() == before
    assert_frame_equal(read_rows(whole).sort(ORDER), rows)


def test_a_changed_policy_refuses_to_mix(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from ssmash_gym.evaluation import study_entrants

    monkeypatch.setattr(study_entrants, "_made_of", lambda kind: ["other sources"])
    with pytest.raises(ConfigurationError, match="hold was another one there; rows of both must not be mixed"):
        run(short_study(), whole)


@pytest.mark.parametrize(
    ("edited", "touched"), [("planning_search", {"planner"}), ("laws_gains", {"scripted", "planner"})]
)
def test_any_source_of_a_policy_counts(monkeypatch: pytest.MonkeyPatch, edited: str, touched: set[str]) -> None:
    from ssmash_gym.evaluation import study_entrants

    before = {kind: study_entrants._made_of(kind) for kind in ("scripted", "planner")}
    plain = study_entrants._hash
    monkeypatch.setattr(study_entrants, "_hash", lambda path: "new" if path.stem == edited else plain(path))
    assert {kind for kind, hashes in before.items() if study_entrants._made_of(kind) != hashes} == touched


def test_rows_of_other_seas_are_refused(rows: pl.DataFrame) -> None:
    wrong = rows.with_columns(
        sea_hs_m=pl.when(pl.col("policy") == "hold").then(pl.col("sea_hs_m") + 1.0).otherwise(pl.col("sea_hs_m"))
    )
    with pytest.raises(ConfigurationError, match="was not the same sea"):
        StudyRows.of(wrong)


def test_rows_that_stand_twice_or_are_none_are_refused(rows: pl.DataFrame, tmp_path: Path) -> None:
    folder = tmp_path / "rows"
    folder.mkdir()
    for name in ("a", "b"):
        rows.head(3).write_parquet(folder / f"{name}.parquet")
    with pytest.raises(ConfigurationError, match="twice"):
        read_rows(tmp_path)
    rows.drop("sea").write_parquet(folder / "b.parquet")
    with pytest.raises(ConfigurationError, match="column sea"):
        read_rows(tmp_path)


def test_a_policy_is_told_of_the_simulation_before_it_starts() -> None:
    condition = short_study().resolved()["calm"]
    policy: Any = make_baseline("hold", condition.task)
    told: list[Any] = []
    policy.attach = lambda core: told.append(("attach", core.n))
    reset = policy.reset
    policy.reset = lambda count: (told.append(("reset", count)), reset(count))
    run_episodes(policy, condition.scenario, [1, 2])
    assert told == [("attach", 2), ("reset", 2)]


# --- the command ---------------------------------------------------------------------------------------------------


def test_the_command_runs_a_study_and_a_page_is_made_of_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pages: list[tuple[Path, Path]] = []
    monkeypatch.setattr(study_verb, "page_writer", lambda agents, film: lambda folder, out: pages.append((folder, out)))
    file = tmp_path / "mine.yaml"
    file.write_text(write_yaml(short_study(targets={"main": "calm"}).model_dump(mode="json")))
    words = [
        "evaluate",
        "--study",
        str(file),
        "--out",
        str(tmp_path / "out"),
        "--episodes",
        "2",
        "--conditions",
        "calm",
    ]
    assert main([*words, "--report", str(tmp_path / "page")]) == 0
    assert pages == [(tmp_path / "out", tmp_path / "page")]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["study"] == "mine" and list(summary["conditions"]) == ["calm"]
    assert summary["conditions"]["calm"]["policies"]["hold"]["seas"] == 2
    assert "trapezoid" in capsys.readouterr().out


def test_a_comparison_can_have_a_page_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pages: list[Path] = []
    monkeypatch.setattr(study_verb, "page_writer", lambda agents, film: lambda folder, out: pages.append(folder))
    task = tmp_path / "short.yaml"
    task.write_text(write_yaml(short_study().resolved()["calm"].task.model_dump(mode="json")))
    words = ["--against", "hold", "--task", str(task), "--scenario", "calm", "--episodes", "2", "--out", str(tmp_path)]
    assert main(["evaluate", *words, "--report", str(tmp_path / "page")]) == 0
    assert pages == [tmp_path]
    assert read_rows(tmp_path).select("policy", "condition").unique().rows() == [("hold", "calm")]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--study", "smoke", "--seed", "1"], "--seed 1"),
        (["--study", "smoke", "--scenario", "ss5"], "--scenario ss5"),
        (["--study", "smoke", "--against", "tractor"], "'tractor'"),
        (["--study", "smoke", "--conditions", "ss9"], "'ss9'"),
        (["--study", "smoke", "--agent", "nobody"], "'nobody'"),
        (["--study", "nothing"], "nothing"),
        (["--conditions", "calm"], "--conditions"),
        (["--agent", "hold", "--agent", "yield"], "--agent"),
    ],
)
def test_a_mistake_costs_one_sentence_and_nothing_is_written(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["evaluate", *words, "--out", str(tmp_path / "out")]) == 1
    message = capsys.readouterr().err
    assert told in message and message.count("\n") == 1
    assert not (tmp_path / "out").exists()
