"""The report of a window that has been run, judged by its own limits or by others; films of its episodes."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from ssmash_gym import cli
from ssmash_gym.assets import asset_path
from ssmash_gym.document import write_yaml
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows.config import load_window
from ssmash_gym.windows.criteria import CRITERIA
from ssmash_gym.windows.engines import Threads
from ssmash_gym.windows.film import film_cell
from ssmash_gym.windows.report import CELLS, REPORT, write_report
from ssmash_gym.windows.rows import read_document, read_rows, write_document
from ssmash_gym.windows.sweep import prepared, run_sweep
from ssmash_gym.windows.verdicts import cells_of, judged_rows

DOCUMENT: dict[str, Any] = {
    "description": "A small one.", "seed": 5, "scenario": "ss5", "stages": ["traverse", "secured"],
    "task": {
        "base": "traverse", "horizon_s": 3.0, "grace_s": 0.5, "track": {"goal_x_m": 0.4},
        "lead_in": {"duration_s": 1.0, "ramp_s": 1.0},
    },
    "policies": ["trapezoid", "linear"], "axes": {"sea_state": [3, 6], "waves_from_deg": [0, 90, 180]},
    "limits": {"probe_in_plane_kN": 5.0, "least_station_kN": 2.0}, "must_arrive": False,
    "effort": {"seeds": 3, "most": 3},
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("window")
    run_sweep(prepared(load_window(DOCUMENT), "small"), out, Threads(2), shown=False)
    return out


def test_the_report_stands_on_the_rows_alone(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ssmash_gym.windows.chunks.Worker.run", None)  # nothing is run
    page = write_report(folder).read_text()
    cells = pl.read_csv(folder / REPORT / CELLS)
    assert cells.height == 2 * 6 + 6 and set(cells["verdict"]) <= {"within", "beyond", "undecided"}
    names = {path.name for path in (folder / REPORT).iterdir()}
    assert {"placard_traverse.svg", "placard_secured.svg", "difference_traverse.svg"} <= names
    assert "difference_secured.svg" not in names  # one policy: nothing to compare
    told = read_document(folder)
    assert "ssmash window small --policy trapezoid --policy linear --seeds 3 --most 3 --out DIR" in page
    assert "ss5" in page and "traverse, changed" in page
    assert told["configuration"] in page and not re.search(r"(src|href)=.https?:", page)
    assert write_report(folder).read_text() == page


def test_cells_count_what_rows_say(folder: Path) -> None:
    told = read_document(folder)
    rows = judged_rows(read_rows(folder), told)
    cells = cells_of(rows, told)
    for row in cells.iter_rows(named=True):
        own = rows.filter(
            pl.col("stage") == row["stage"], pl.col("policy") == row["policy"], pl.col("cell") == row["cell"]
        )
        beyond = (own["peak_probe_kN"] > 5.0) | (own["least_station_kN"] < 2.0) | own["failed"]
        assert row["exceeded"] == beyond.sum() and row["episodes"] == 3
        use = own["peak_probe_kN"] / 5.0
        lift = 2.0 - own["least_station_kN"] / 2.0
        gravity = zip(own["failed"], beyond, use, lift, own["seed"], strict=True)
        worst = max(gravity, key=lambda one: (one[0], one[1], max(one[2:4])))
        assert row["worst_use"] == pytest.approx(max(worst[2:4])) and row["worst_seed"] == worst[4]
        assert row["low"] <= row["share"] <= row["high"]


def test_other_limits_judge_the_same_rows(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(write_yaml({**DOCUMENT, "limits": {"probe_in_plane_kN": 1e6}, "acceptance": 0.5}))
    page = write_report(folder, limits=str(other)).read_text()
    cells = pl.read_csv(folder / "report_other" / CELLS)
    assert "over_least_station_kN" not in cells.columns
    lost = read_rows(folder).group_by("stage", "policy", "cell").agg(pl.col("failed").sum())
    assert cells["exceeded"].sum() == lost["failed"].sum()
    assert "Judged by the limits of" in page


def test_the_film_is_the_episode_that_was_judged(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("pygame")
    pytest.importorskip("imageio_ffmpeg")
    path = film_cell(folder, 4, ("linear",), "traverse")
    assert path.read_bytes()[4:8] == b"ftyp"
    stamp = path.stat().st_mtime_ns
    assert film_cell(folder, 4, ("linear",), "traverse") == path and path.stat().st_mtime_ns == stamp
    for words, told in (
        ((99, ("linear",), "traverse"), "--cell 99"),
        ((4, ("hold",), "traverse"), "its policies are"),
        ((4, (), "flying"), "--stage flying"),
        ((None, ("linear",), "traverse"), "needs one --cell"),
        ((4, (), "traverse"), "--film needs --policy"),
        ((4, (), None), "--film needs --stage"),
    ):
        with pytest.raises(ConfigurationError, match=re.escape(told)):
            film_cell(folder, *words)
    changed = read_document(folder)
    changed["policies"]["trapezoid"]["identities"]["traverse"] = "another"
    kept = read_document(folder)
    write_document(folder, changed)
    try:
        with pytest.raises(ConfigurationError, match="trapezoid in traverse cannot be filmed"):
            film_cell(folder, 4, ("trapezoid",), "traverse")
    finally:
        write_document(folder, kept)


def test_a_window_that_was_stopped_says_so(folder: Path, tmp_path: Path) -> None:
    said: list[str] = []
    write_report(folder, tell=said.append)
    assert not said
    shutil.copytree(folder, tmp_path / "stopped")
    for path in list((tmp_path / "stopped" / "rows").iterdir()):
        rows = pl.read_parquet(path).filter(pl.col("cell") != 2)
        rows.write_parquet(path)
    page = write_report(tmp_path / "stopped", tell=said.append).read_text()
    assert len(said) == 1 and "not finished: 3 cells" in said[0]  # of three policies, one of them holding
    assert "not finished" in page


def test_the_lost_are_worse_than_the_loaded() -> None:
    rows = pl.DataFrame(
        {
            "stage": ["traverse"] * 4, "policy": ["a"] * 4, "cell": [0] * 4, "number": range(4), "seed": range(4),
            "sea_state": [5.0] * 4, "peak_probe_kN": [1.0, 0.0, 20.0, 30.0], "failed": [False, True, False, False],
            "success": [True, False, True, True], "within_validity": [True] * 4,
        }
    )  # fmt: skip
    limit = {"value": 15.0, "label": "", "unit": "kN", "sense": "above", "note": ""}
    told = {"limits": {"probe_in_plane_kN": limit}, "must_arrive": True, "acceptance": 0.1, "confidence": 0.95}
    cells = cells_of(judged_rows(rows, {**told, "axes": {"sea_state": {}}}), {**told, "axes": {"sea_state": {}}})
    assert (cells["worst_seed"][0], cells["lost"][0], cells["exceeded"][0]) == (1, 1, 3)


def test_an_agent_of_ones_own_is_found_again_for_its_film(tmp_path: Path) -> None:
    pytest.importorskip("pygame")
    mine = tmp_path / "my agent"
    shutil.copytree(asset_path("agents", "trained", "ppo_traverse"), mine)
    document = {**DOCUMENT, "stages": ["traverse"], "axes": {"sea_state": [6]}}
    out = tmp_path / "window"
    run_sweep(prepared(load_window(document), "small", (f"mine={mine}",)), out, Threads(1), shown=False)
    said: list[str] = []
    page = write_report(out, films=1, tell=said.append).read_text()
    assert not said and "video/mp4" in page
    shutil.rmtree(out / "films")
    shutil.rmtree(mine)
    write_report(out, films=1, tell=said.append)  # a report all the same
    assert len(said) == 1 and "no film of cell 0" in said[0]


def test_what_cannot_be_reported_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write_document(tmp_path, {"name": "empty", "stages": {}, "limits": {}})
    assert cli.main(["window", "--report", str(tmp_path)]) == 1
    assert "no episode has been run there yet" in capfd.readouterr().err
    (tmp_path / "window.json").write_text("{")
    assert cli.main(["window", "--report", str(tmp_path)]) == 1
    assert "this record cannot be read" in capfd.readouterr().err


@pytest.mark.parametrize(
    "name", ["frigate_traverse", "frigate_flight_criteria", "frigate_secured", "frigate_touchdown"]
)
def test_shipped_windows_can_be_run(name: str) -> None:
    config = load_window(name)
    assert set(config.figures) <= set(CRITERIA)
    prepared(config, name)


def test_a_base_is_changed_key_by_key() -> None:
    base, criteria = load_window("frigate_traverse"), load_window("frigate_flight_criteria")
    assert base.figures.items() < criteria.figures.items() and base.axes == criteria.axes
