"""The report: whole in one file, every number that of the summary, failures and film those of the rows."""

from __future__ import annotations

import base64
import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from rich.console import Console

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.scenario import load_scenario
from ssmash_gym.envs.task import load_task
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation import charts, film_study, page_tables
from ssmash_gym.evaluation.episodes import run_episodes
from ssmash_gym.evaluation.film import film_side_by_side
from ssmash_gym.evaluation.film_study import film, film_of_study
from ssmash_gym.evaluation.page import write_page
from ssmash_gym.evaluation.page_data import flat, read_study
from ssmash_gym.evaluation.page_tables import number
from ssmash_gym.evaluation.policies import make_baseline
from ssmash_gym.evaluation.report import study_tables
from ssmash_gym.evaluation.study_run import planned, run_study
from ssmash_gym.evaluation.study_summary import summarise
from tests.evaluation.studies import short_study
from tests.html_reader import HtmlReader

SHORT = {"horizon_s": 1.0, "grace_s": 0.2, "lead_in": {"duration_s": 5.0, "ramp_s": 5.0}}

CONDITIONS = {
    "ss4": {"scenario": "ss4", "task": SHORT},
    "ss5": {"scenario": "ss5", "task": SHORT},
    "late": {"scenario": "ss5", "task": SHORT | {"claw": {"delay_s": 0.2}}, "description": "late <b>& later</b>"},
}


class Reader(HtmlReader):
    """Collects the rows of tables by folded title, too."""

    def prepare(self) -> None:
        self.tables: dict[str, list[list[str]]] = {}
        self._title = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        super().handle_starttag(tag, attrs)
        if tag == "summary":
            self._title = ""
        if tag == "tr":
            self.tables.setdefault(self._title, []).append([])
        if tag in ("td", "th"):
            self.tables[self._title][-1].append("")

    def handle_endtag(self, tag: str) -> None:
        super().handle_endtag(tag)
        if tag == "details":
            self._title = ""

    def handle_data(self, data: str) -> None:
        super().handle_data(data)
        if "summary" in self.open and "small" not in self.open:
            self._title += data.strip()
        elif {"td", "th"} & set(self.open):
            self.tables[self._title][-1][-1] += data

    def of(self, tag: str, name: str) -> list[str]:
        return [value for one, attribute, value in self.attributes if (one, attribute) == (tag, name)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of eight seas; the rows of the law also stand for two trainings of an agent, one of which has failed."""
    out = tmp_path_factory.mktemp("study")
    study = short_study(
        episodes=8, chunk=8, conditions=CONDITIONS, targets={"main": "ss5"}, roles={"laws": ["yield"]},
        runs=[{"conditions": list(CONDITIONS), "policies": ["trapezoid", "yield", "hold"]}],
    )  # fmt: skip
    run_study(planned(study, "tiny", ()), out, shown=False)
    for path in sorted((out / "rows").glob("yield--*.parquet")):
        for seed in (0, 1):
            frame = pl.read_parquet(path)
            lost = pl.Series(np.arange(frame.height) == 2) & bool(seed)
            frame = frame.with_columns(
                policy=pl.lit("made_up"),
                training_seed=pl.lit(seed, dtype=pl.Int64),
                success=~lost,
                failed=lost,
                reason=pl.when(lost).then(pl.lit("corridor")).otherwise(pl.lit("goal")),
                scored_peak_kN=pl.when(lost).then(75.0).otherwise(0.5 * pl.col("scored_peak_kN")),
            )
            frame.write_parquet(path.with_name(path.name.replace("yield", f"made_up.seed{seed}")))
    record = json.loads((out / "study.json").read_text())
    seeds = {str(seed): {"identity": f"weights{seed}", "steps": 1234567} for seed in (0, 1)}
    record["policies"]["made_up"] = {"kind": "agent", "seeds": seeds}
    (out / "study.json").write_text(json.dumps(record))
    summarise(out, shown=False)
    return out


@pytest.fixture(scope="module")
def text(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    return write_page(folder, tmp_path_factory.mktemp("page") / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text: str) -> Reader:
    return Reader(text)


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "summary.json").read_text()))


@pytest.fixture
def copy(folder: Path, tmp_path: Path) -> Iterator[Path]:
    """The folder, to be changed."""
    yield Path(shutil.copytree(folder, tmp_path / "copy"))


@pytest.fixture
def no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Empty figures, for tests of something else: drawing takes longest."""
    for name in ("distribution", "points", "load_against_time", "by_heading", "dots", "pairs", "differences"):
        monkeypatch.setattr(charts, name, lambda *given, **named: "<svg/>")


def test_the_page_needs_nothing_but_itself(page: Reader, text: str) -> None:
    assert "<script" not in text and "@import" not in text and "url(" not in text
    links = [value for _, name, value in page.attributes if name in ("src", "href", "poster", "data", "srcset")]
    assert all(link.startswith(("data:", "#")) for link in links)
    anchors = {value for _, name, value in page.attributes if name == "id"}
    assert {link[1:] for link in links if link.startswith("#")} <= anchors
    pictures = page.of("img", "src")
    assert len(pictures) >= 8
    for picture in pictures:
        kind, content = picture.split(",", 1)
        assert kind == "data:image/svg+xml;base64"
        assert base64.b64decode(content).startswith(b"<?xml")
    assert len(page.of("img", "alt")) == len(pictures) and all(page.of("img", "alt"))
    assert len(text) < 12_000_000


def test_the_same_folder_gives_the_same_page(folder: Path, text: str, tmp_path: Path) -> None:
    path = write_page(folder, tmp_path / "report")
    assert path == tmp_path / "report" / "index.html"
    assert path.read_text(encoding="utf-8") == text


def test_the_tables_numbers_are_those_of_the_summary(page: Reader, summary: dict[str, Any]) -> None:
    for condition, found in summary["conditions"].items():
        heads, *rows = page.tables[condition]
        names = [head.strip() for head in heads]
        shown = {row[0].strip(): dict(zip(names, row, strict=True)) for row in rows}
        assert set(shown) == set(found["policies"])
        for policy, own in found["policies"].items():
            load = own["peak_probe_kN"]["p95"]
            told = shown[policy]["peak load, P95kN"].split()
            assert told == [number(load["value"]), f"[{number(load['ci'][0])},", f"{number(load['ci'][1])}]"]
            assert shown[policy]["success%"].split()[0] == number(100 * own["success"]["value"])
            assert shown[policy]["timemedian s"].split()[0] == number(own["time_s"]["value"])
            assert shown[policy]["episodes"] == ("2 × 8" if policy == "made_up" else "8")


def test_the_answer_comes_first_and_the_aims_keep_their_verdicts(
    page: Reader, text: str, summary: dict[str, Any]
) -> None:
    own = summary["conditions"]["ss5"]["policies"]["made_up"]
    assert text.index('id="answer"') < text.index("<img")
    told = " ".join(page.texts)
    assert f"{number(100 * own['success']['value'])} %" in told
    assert f"{number(own['peak_probe_kN']['p95']['value'])} kN" in told
    heads, *rows = page.tables[""][: 1 + len(summary["targets"])]
    assert heads[-1] == "verdict"
    for row, check in zip(rows, summary["targets"], strict=True):
        assert check["statement"] in row[0] and check["condition"] in row[0]
        assert row[1] == check["figure"].replace("-", "−")
        assert row[2].strip("✔✘ ") == check["verdict"]


def test_version_configuration_seed_and_what_is_assumed_are_told(page: Reader, folder: Path) -> None:
    record = json.loads((folder / "study.json").read_text())
    told = " ".join(page.texts)
    for fact in (record["configuration"], record["versions"]["ssmash_gym"], record["versions"]["code"], "weights1"):
        assert fact in told
    assert "No operational limit follows" in told and "assumed" in told and "generic_tricycle" in told


def test_words_of_a_study_are_not_taken_for_tags(text: str) -> None:
    assert "late &lt;b&gt;&amp; later&lt;/b&gt;" in text
    assert "<b>& later" not in text


def test_failures_are_listed_with_their_seed_and_a_command(page: Reader, folder: Path) -> None:
    title = next(name for name in page.tables if "episodes without success" in name)
    lost = [row for row in page.tables[title][1:] if row[3] == "corridor"]
    data = read_study(folder)
    sea = data.frame("ss5", "made_up").filter(pl.col("failed"))["sea"].to_list()
    assert len(sea) == 1 and str(sea[0]) in [row[2] for row in lost if row[1] == "ss5"]
    assert all("training seed 1" in row[0] for row in lost) and len(lost) == len(CONDITIONS)
    first = page.tables[title][1]
    command = next(one for one in page.texts if one.startswith("ssmash film"))
    assert f"--sea {first[2]}" in command and "--agent made_up" in command and f"--condition {first[1]}" in command
    assert not any(row[0] == "hold" for row in page.tables[title])  # it cannot succeed


def test_a_long_list_of_failures_says_what_it_leaves_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_tables, "MOST_LISTED", 4)
    found = page_tables.failures(read_study(folder))
    assert len(found.listed.rows) == 4
    assert found.title.startswith("4 of ") and [row.cells[3].text for row in found.listed.rows[:3]] == ["corridor"] * 3


def test_conditions_are_sorted_out_by_what_they_change(folder: Path) -> None:
    data = read_study(folder)
    assert (data.main, data.first, data.law) == ("ss5", "made_up", "yield")
    assert data.sea_states() == {"ss4": 4, "ss5": 5}
    assert data.delays() == {"ss5": 100, "late": 200}
    assert data.changes("late") == {"task.claw.delay_s": 0.2}
    ranges = {"start": {"yaw_deg": {"uniform": [-8, 8], "choice": None}, "x": {"constant": 2.0}}, "description": "no"}
    assert flat(ranges) == {"start.yaw_deg": "uniform [-8, 8]", "start.x": 2.0}


@pytest.mark.usefixtures("no_figures")
def test_a_training_curve_becomes_a_figure_or_is_refused(copy: Path, tmp_path: Path) -> None:
    curve = tmp_path / "curve.csv"
    curve.write_text("steps,success_rate,peak_probe_kN_mean\n1000,0.5,20\n2000,0.9,10\n")
    page = Reader(write_page(copy, tmp_path / "a.html", curves={"seed 0": curve}).read_text(encoding="utf-8"))
    assert any("seed 0 ends at 90 % success" in words for words in page.of("img", "alt"))
    (copy / "curves").mkdir()
    (copy / "curves" / "broken.csv").write_text("steps\n1\n")
    with pytest.raises(ConfigurationError, match=r"broken\.csv: this training curve"):
        write_page(copy, tmp_path / "b.html")
    assert not (tmp_path / "b.html").exists()


@pytest.mark.parametrize("missing", ["study.json", "summary.json", "rows"])
def test_a_folder_that_is_no_study_costs_one_sentence(missing: str, copy: Path, tmp_path: Path) -> None:
    path = copy / missing
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    with pytest.raises(ConfigurationError, match=missing):
        write_page(copy, tmp_path / "out.html")
    assert not (tmp_path / "out.html").exists()


def test_a_missing_library_names_its_extra(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(ImportError, match=r"ssmash_gym\[report\]"):
        write_page(folder, tmp_path / "out.html")


def test_the_terminal_shows_conditions_and_aims(summary: dict[str, Any]) -> None:
    console = Console(width=200)
    with console.capture() as shown:
        for table in study_tables(summary):
            console.print(table)
    told = shown.get()
    load = summary["conditions"]["late"]["policies"]["yield"]["peak_probe_kN"]["p95"]
    assert f"{load['value']:.1f} [{load['ci'][0]:.1f}, {load['ci'][1]:.1f}], 0" in told
    assert all(check["verdict"] in told for check in summary["targets"])


# --- films ------------------------------------------------------------------------------------------------------


class Planner:
    """Holds still, and wants to know the simulation first."""

    name = "planner"

    def __init__(self) -> None:
        self.task = load_task(SHORT)
        self.told: list[str] = []

    def attach(self, core: TraverseBatch) -> None:
        assert core.book.over.all()  # no episode has begun
        self.told.append("attach")

    def reset(self, count: int) -> None:
        self.told.append("reset")

    def act(self, observations: Any, starts: Any = None) -> Any:
        return np.zeros((len(observations), 2), np.float32)


def test_a_film_side_by_side_shows_the_evaluated_episodes(tmp_path: Path) -> None:
    scenario, planner, law = load_scenario("ss5"), Planner(), make_baseline("trapezoid", load_task(SHORT))
    found = film_side_by_side([planner, law], scenario, 7, tmp_path / "film.mp4")
    assert list(found) == ["planner", "trapezoid"]
    assert planner.told == ["attach", "reset"]
    rows = run_episodes(law, scenario, [7])
    assert found["trapezoid"]["peak_probe_kN"] == rows["peak_probe_kN"][0] > 0.0
    assert found["planner"]["return"] != found["trapezoid"]["return"]
    assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    assert (tmp_path / "film.jpg").read_bytes().startswith(b"\xff\xd8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["film.jpg", "film.mp4"]


def test_a_film_refuses_two_of_a_name_and_too_many(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="same name"):
        film_side_by_side([Planner(), Planner()], load_scenario("ss5"), 7, tmp_path / "film.mp4")
    with pytest.raises(ConfigurationError, match="1 to 6"):
        film_side_by_side([], load_scenario("ss5"), 7, tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("no_figures")
def test_the_film_of_a_study_goes_into_its_page(copy: Path, tmp_path: Path) -> None:
    """Without its folder the agent cannot be filmed; the scripted policies are, in the sea of their rows."""
    assert film_of_study(copy) == copy / "film.mp4"
    credits = json.loads((copy / "film.json").read_text())
    assert list(credits["policies"]) == ["yield", "trapezoid", "hold"]
    rows = read_study(copy).frame("ss5", "yield").filter(sea=credits["sea"])
    assert credits["policies"]["yield"]["peak_probe_kN"] == rows["peak_probe_kN"][0] > 0.0
    page = Reader(write_page(copy, tmp_path / "out.html").read_text(encoding="utf-8"))
    assert page.of("video", "src") == [
        "data:video/mp4;base64," + base64.b64encode((copy / "film.mp4").read_bytes()).decode()
    ]
    assert page.of("video", "poster")[0].startswith("data:image/jpeg;base64,")
    assert any(f"Sea {credits['sea']} of ss5" in words for words in page.texts)


@pytest.fixture
def filmed(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What was to be filmed; nothing is, and every episode has a peak of 9 kN."""
    found: list[dict[str, Any]] = []

    def instead(policies: Any, scenario: Any, seed: int, path: Path, **options: Any) -> dict[str, dict[str, Any]]:
        found.append({"policies": policies, "scenario": scenario, "seed": seed, "path": path} | options)
        return {one.name: {"reason": "time", "time_s": 1.0, "peak_probe_kN": 9.0} for one in policies}

    monkeypatch.setattr(film_study, "film_side_by_side", instead)
    return found


def test_a_film_of_other_episodes_than_the_rows_is_refused(folder: Path, filmed: list[dict[str, Any]]) -> None:
    with pytest.raises(ConfigurationError, match=r"9\.000 kN now .* run the study again"):
        film_of_study(folder)
    assert not (folder / "film.json").exists()


def test_a_sea_of_a_studys_folder_can_be_filmed_again(
    folder: Path, tmp_path: Path, filmed: list[dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    film(7, str(folder), "late", "trapezoid,hold", out=tmp_path / "again.mp4")
    (asked,) = filmed
    assert [one.name for one in asked["policies"]] == ["trapezoid", "hold"]
    assert all(one.task.claw.delay_s == 0.2 for one in asked["policies"])
    assert (asked["seed"], asked["scenario"].motion, asked["helicopter"].name) == (
        7, load_scenario("ss5").motion, "generic_tricycle",
    )  # fmt: skip
    assert "trapezoid: time after 1.0 s, peak 9.0 kN" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "told"),
    [({"condition": "no_such"}, "no_such"), ({"speed": 0.0}, "--speed 0"), ({"policies": "tractor"}, "tractor")],
)
def test_a_film_that_cannot_be_made_costs_one_sentence(
    options: dict[str, Any], told: str, folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(ConfigurationError, match=told):
        film(7, str(folder), out=tmp_path / "film.mp4", **options)
    assert not list(tmp_path.iterdir())
