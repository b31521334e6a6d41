"""A benchmark from trials to page: what counts, what is refused, what is kept, and what the page says."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from ssmash_gym.benchmark import run, verb
from ssmash_gym.benchmark.admission import only_configuration, read_entries
from ssmash_gym.benchmark.page import _of, write_page
from ssmash_gym.benchmark.page_words import answer, same_seas, taught
from ssmash_gym.benchmark.run import Program, entrants_of
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.evaluation.study_figures import Options
from ssmash_gym.trials.files import read_trial, write_trial
from ssmash_gym.trials.trial import Trial
from tests.benchmark.recorded import SEEDS, drive, session, short, write_session
from tests.html_reader import HtmlReader

OPTIONS = Options(resamples=50)


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two scripted drivers: one drives as the baseline does, the other as the operator model."""
    folder = tmp_path_factory.mktemp("trials")
    write_session(folder, "P01", short(), "trapezoid")
    write_session(folder, "P02", short())
    return folder


@pytest.fixture(scope="module")
def out(trials: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("benchmark")
    made(trials, folder)
    return folder


def made(trials: Path, out: Path) -> dict[str, Any]:
    return verb.run_benchmark(
        [trials], [], ["linear"], "0,100", out, threads=1, options=OPTIONS, command="ssmash benchmark --trials DIR"
    )


@pytest.fixture(scope="module")
def document(out: Path) -> dict[str, Any]:
    return dict(json.loads((out / "benchmark.json").read_text()))


def test_who_is_compared_with_whom(document: dict[str, Any]) -> None:
    recorded = ["scripted P01", "scripted P02", "all scripted operators"]
    programs = ["linear", "linear +100 ms", "trapezoid"]
    assert list(document["drivers"]) == [*recorded, *programs]
    wanted = [(one, other) for one in recorded for other in programs]
    wanted += [("linear", "trapezoid"), ("linear +100 ms", "trapezoid")]
    assert [(one["driver"], one["other"]) for one in document["pairs"]] == wanted
    assert document["seeds"] == sorted(SEEDS)
    assert [one["reason"] for one in document["trials"] if not one["counts"]] == ["practice", "practice"]
    assert document["scores"] == {} and "--bound" in document["no_bound"]


def test_a_driver_that_does_what_a_program_does_has_its_figures(document: dict[str, Any]) -> None:
    """A replayed trial and an episode of a batch are measured by the same eyes."""
    ours, theirs = (dict(document["drivers"][name]) for name in ("scripted P01", "trapezoid"))
    for one in (ours, theirs):
        for key in ("kind", "base", "members"):
            one.pop(key)
    assert ours == theirs
    pair = next(one for one in document["pairs"] if (one["driver"], one["other"]) == ("scripted P01", "trapezoid"))
    assert pair["peak_mean_kN"]["value"] == 0.0 and pair["improvement"]["value"] == 0.5


def test_rows_are_those_of_the_programs_alone(out: Path) -> None:
    rows = pl.read_parquet(out / "rows.parquet").filter(pl.col("driver") == "linear")
    condition = short()
    alone = run_episodes(make_baseline("linear", condition.task), condition.scenario, sorted(SEEDS), threads=1)
    assert rows.select(alone.columns).equals(alone)
    assert pl.read_csv(out / "rows.csv").height == 4 + 4 + 3 * len(SEEDS)


def test_the_learning_curve_holds_practice_and_scored_trials_in_order(document: dict[str, Any]) -> None:
    found = document["learning"]["scripted P01"]
    assert [one["phase"] for one in found] == ["practice", "scored", "scored", "scored"]
    assert [one["trial"] for one in found] == [1, 2, 3, 4]
    assert all(one["scored_peak_kN"] == one["baseline_kN"] for one in found)  # it drives as the baseline does


def test_a_second_run_only_draws_and_gives_the_same_bytes(
    trials: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("index.html", "benchmark.json", "rows.csv", "rows.parquet")
    before = {name: (out / name).read_bytes() for name in names}

    def never(*given: object, **options: object) -> None:
        raise AssertionError("this has been simulated already")

    monkeypatch.setattr(run, "run_episodes", never)
    monkeypatch.setattr(run, "replay", never)
    made(trials, out)
    assert {name: (out / name).read_bytes() for name in names} == before


def test_another_folder_gets_the_same_page(trials: Path, out: Path, tmp_path: Path) -> None:
    made(trials, tmp_path)
    assert (tmp_path / "index.html").read_bytes() == (out / "index.html").read_bytes()


# --- the page --------------------------------------------------------------------------------------------


def test_the_page_needs_nothing_but_itself(out: Path) -> None:
    text = (out / "index.html").read_text(encoding="utf-8")
    page = HtmlReader(text)
    links = [value for _, name, value in page.attributes if name in ("src", "href", "poster", "data", "action")]
    assert links and all(link.startswith(("data:", "#")) for link in links)
    assert not re.search(r"https?://|@import|<script", text)


def test_the_page_holds_the_figures(out: Path, document: dict[str, Any]) -> None:
    text = " ".join(HtmlReader((out / "index.html").read_text(encoding="utf-8")).texts)
    for one in document["drivers"].values():
        for key in ("mean", "iqm", "p95"):
            assert f"{one['peak_probe_kN'][key]['value']:.1f}" in text
    for word in (document["configuration"], document["versions"]["code"], *map(str, SEEDS), "No bound",
                 "arXiv 1903.07008", "ssmash benchmark --trials DIR"):  # fmt: skip
        assert word in text


def test_scripted_drivers_are_called_so_everywhere(out: Path, trials: Path) -> None:
    text = (out / "index.html").read_text(encoding="utf-8")
    page = HtmlReader(text)
    shown = [*page.texts, *(value for _, name, value in page.attributes if name == "alt")]
    for words in shown:
        for place in re.finditer(r"P0[12](?![\w/])", words):
            assert words[: place.start()].lower().endswith("scripted "), words
    assert "No person's data stand behind any figure" in " ".join(page.texts).replace("&#39;", "'")
    assert "human" not in " ".join(page.texts).lower()


def test_a_person_beside_a_script_is_not_called_scripted(out: Path, document: dict[str, Any], tmp_path: Path) -> None:
    changed = json.loads(json.dumps(document))
    changed["drivers"]["scripted P02"]["kind"] = "participant"
    rows = pl.read_parquet(out / "rows.parquet").filter(pl.col("counts").fill_null(True))
    text = write_page(changed, rows, tmp_path / "index.html").read_text(encoding="utf-8")
    assert "were a script in virtual time, no persons" in text and "All recorded trials were driven" not in text


def test_an_agent_that_has_learned_from_these_seas_is_marked(document: dict[str, Any]) -> None:
    assert taught(document) == []
    told = taught({**document, "learned_from": {"clone": [SEEDS[0], SEEDS[1], 999], "other": [999]}})
    assert len(told) == 1 and "clone has learned from recorded episodes of 2 of these 3 seas" in told[0]


# --- what counts -----------------------------------------------------------------------------------------


def reasons(folder: Path) -> dict[str, str]:
    return {one.place: one.reason for one in read_entries([folder])}


def test_trials_that_do_not_count_are_listed_with_the_reason(tmp_path: Path) -> None:
    condition = short(horizon_s=1.0)
    told = {"participant": "P01", "session": session(1)}
    made_of: dict[str, Trial] = {
        "1_good": drive(condition, 11, started_utc="1", **told),
        "2_again": drive(condition, 11, started_utc="2", **told),
        "3_broken": drive(condition, 12, steps=4, started_utc="3", **told),
        "4_late": drive(condition, 13, late=True, started_utc="4", **told),
        "5_free": drive(condition, 14, started_utc="5", participant="P01"),
        "6_policy": drive(condition, 15, driver="linear", started_utc="6", **told),
        "7_person": drive(condition, 11, driver="person", origin="page", started_utc="7", **told),
    }
    for name, trial in made_of.items():
        write_trial(tmp_path / f"{name}.parquet", trial)
    found = {place.partition(".")[0]: reason for place, reason in reasons(tmp_path).items()}
    assert found == {
        "1_good": "",
        "2_again": "the same driver has met this sea before",
        "3_broken": "broken off",
        "4_late": "late steps: 100 % of them, allowed 2 %",
        "5_free": "outside of a session",
        "6_policy": "driven by linear",
        "7_person": "",
    }
    entries = {one.place.partition(".")[0]: one for one in read_entries([tmp_path])}
    assert (entries["1_good"].driver, entries["7_person"].driver) == ("scripted P01", "participant P01")


def test_a_trial_with_nobody_at_the_claw_does_not_count(tmp_path: Path) -> None:
    condition = short(horizon_s=4.0)
    for name, left in (("most", 2), ("some", 3)):  # of 40 steps: 5.0 % and 7.5 %
        trial = drive(condition, 11, driver="person", origin="page", participant=name, session=session(1))
        away = trial.table.with_columns(
            driver=pl.when(pl.col("step") <= left).then(pl.lit("none")).otherwise(pl.col("driver"))
        )
        write_trial(tmp_path / f"{name}.parquet", Trial(away, trial.about))
    assert reasons(tmp_path) == {"most.parquet": "", "some.parquet": "nobody at the claw in 7.5 % of the steps"}


def test_one_session_in_two_folders_is_refused_and_a_folder_named_twice_is_read_once(tmp_path: Path) -> None:
    trial = drive(short(horizon_s=1.0), 11, participant="P01", session=session(1))
    write_trial(tmp_path / "a" / "P01" / "1.parquet", trial)
    assert len(read_entries([tmp_path, tmp_path / "a", tmp_path / "a" / "P01"])) == 1
    write_trial(tmp_path / "b" / "P01" / "1.parquet", trial)
    with pytest.raises(ConfigurationError, match=r"a/P01 and .*b/P01 hold the same session of participant P01"):
        read_entries([tmp_path / "a", tmp_path / "b"])


def test_several_configurations_are_refused(tmp_path: Path) -> None:
    for k, horizon_s in enumerate((1.0, 1.5)):
        trial = drive(short(horizon_s), 11 + k, participant="P01", session=session(k + 1))
        write_trial(tmp_path / f"{k}.parquet", trial)
    with pytest.raises(ConfigurationError, match=r"2 configurations.*only trials of one can be compared"):
        only_configuration(read_entries([tmp_path]))


def test_a_trial_that_does_not_replay_is_refused_before_anything_is_written(trials: Path, tmp_path: Path) -> None:
    """Sealed again after a change: only the replay finds it."""
    trial = read_trial(trials / "P01" / "1.parquet")
    changed = trial.table.with_columns(
        pl.when(pl.col("step") == 7).then(-0.5).otherwise(pl.col("command_along")).alias("command_along")
    )
    write_trial(tmp_path / "trials" / "1.parquet", Trial(changed, trial.about))
    out = tmp_path / "out"
    with pytest.raises(ConfigurationError, match=r"1.parquet: this trial is refused.*does not agree: step 7"):
        made(tmp_path / "trials", out)
    assert not out.exists()


def test_on_another_processor_nearly_the_same_is_enough(trials: Path) -> None:
    """Last bits are promised for one machine; there the same difference is a fault."""
    trial = read_trial(trials / "P01" / "1.parquet")
    other = trial.table.with_columns(state_digest=pl.col("state_digest") ^ 1)
    row = run.retold(Trial(other, {**trial.about, "code": "another processor"}), "1.parquet")
    assert row["agrees"].to_list() == [False] and row["apart_kN"].to_list() == [0.0]
    for changed in (
        {},  # the same machine
        {"code": "another processor", "sources": "others"},
        {"code": "another processor", "metrics": {**(trial.metrics or {}), "reason": "goal"}},
        {"code": "another processor", "metrics": {**(trial.metrics or {}), "peak_probe_kN": 99.0}},
    ):
        with pytest.raises(ConfigurationError, match="this trial is refused"):
            run.retold(Trial(other, {**trial.about, **changed}), "1.parquet")


def test_a_record_whose_configuration_is_another_one_is_refused(trials: Path) -> None:
    trial = read_trial(trials / "P01" / "1.parquet")
    with pytest.raises(ConfigurationError, match="its configuration is called 0123, but what was simulated is"):
        run.retold(Trial(trial.table, {**trial.about, "configuration": "0123"}), "1.parquet")


def test_a_sea_that_was_repeated_is_told(trials: Path, tmp_path: Path) -> None:
    for k in range(4):
        trial = read_trial(trials / "P01" / f"{k}.parquet")
        about = {**trial.about, "session": {**trial.about["session"], "attempt": 2 if k == 3 else 1}}
        write_trial(tmp_path / "trials" / "P01" / f"{k}.parquet", Trial(trial.table, about))
    found = made(tmp_path / "trials", tmp_path / "out")
    own = found["drivers"]["scripted P01"]
    first = [one["scored_peak_kN"] for one in found["learning"]["scripted P01"][1:3]]
    assert own["repeated"] == 1 and own["first_attempts_kN"] == pytest.approx(sum(first) / 2)
    assert any("1 of these trials repeat a sea" in words for words in answer(found))


def test_a_pool_is_drawn_in_the_seas_that_all_have_met(tmp_path: Path) -> None:
    write_session(tmp_path / "trials", "P01", short(), "trapezoid")
    write_session(tmp_path / "trials", "P02", short(), seeds=SEEDS[:2])
    found = made(tmp_path / "trials", tmp_path / "out")
    assert [found["drivers"][f"{name}"]["seas"] for name in ("scripted P01", "scripted P02")] == [3, 2]
    assert "scripted P02 and all scripted operators in fewer" in same_seas(found)
    rows = pl.read_parquet(tmp_path / "out" / "rows.parquet").filter(pl.col("counts").fill_null(True))
    shared = _of(found, rows, "all scripted operators")
    assert shared.height == 4 and set(shared["seed"]) == set(sorted(SEEDS[:2]))


def test_a_report_among_the_trials_is_refused(trials: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"--out .* is refused: it lies in the folder of trials"):
        made(trials, trials / "out")
    assert not (trials / "out").exists()


def test_a_program_called_as_a_recorded_driver_is_refused(trials: Path) -> None:
    entries = read_entries([trials])
    condition = entries[0].trial.condition
    linear = entrants_of([], ["linear"], condition)[0]
    verb._refuse_namesakes(entries, [linear])
    for name in ("scripted P01", "all participants"):
        with pytest.raises(ConfigurationError, match=f"the name '{name}' is a recorded driver's"):
            verb._refuse_namesakes(entries, [replace(linear, name=name)])


@pytest.mark.parametrize("code", ["linear", "trapezoid", "clairvoyant", "all"])
def test_a_participant_may_be_called_as_a_policy_is(code: str, tmp_path: Path) -> None:
    trial = drive(short(1.0), 11, driver="person", origin="page", participant=code, session=session(1))
    write_trial(tmp_path / "1.parquet", trial)
    assert [one.driver for one in read_entries([tmp_path])] == [f"participant {code}"]


def test_what_several_trainings_have_learned_from_is_told_together(trials: Path) -> None:
    condition = read_entries([trials])[0].trial.condition
    one = entrants_of([], ["linear"], condition)[0]
    several = [
        Program(replace(one, training_seed=seed, identity=f"hash {seed}", about={"cloned_from": {"seeds": seeds}}), 0.0)
        for seed, seeds in ((0, [1, 2]), (1, [2, 3]))
    ]
    assert verb._lessons(several) == {"linear": [1, 2, 3]}
    assert verb._identities(several) == {"linear, training seed 0": "hash 0", "linear, training seed 1": "hash 1"}


def test_who_never_arrives_has_no_time(document: dict[str, Any]) -> None:
    """A time limit is no time to the goal: all of these episodes end by it."""
    assert all(one["time_s"]["value"] is None for one in document["drivers"].values())
    assert all("no time, since it never arrived" in words for words in answer(document) if "succeeded" in words)


def test_other_refusals(trials: Path, tmp_path: Path) -> None:
    for trial_folder, policies, words in (
        (tmp_path / "none", ["linear"], "no such folder"),
        (trials, ["nobody"], "no baseline 'nobody'"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            verb.run_benchmark([trial_folder], [], policies, "0", tmp_path / "out")
    with pytest.raises(ConfigurationError, match="--trials is missing"):
        verb.benchmark()
    practice = tmp_path / "practice"
    write_trial(practice / "1.parquet", drive(short(1.0), 11, participant="P01", session=session(1, "practice")))
    with pytest.raises(ConfigurationError, match=r"no trial counts: 1.parquet \(practice\)"):
        only_configuration(read_entries([practice]))
    assert not (tmp_path / "out").exists()
