"""The framework: statements, pictures, pages, and the verb that writes them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from PIL import Image

from ssmash_gym.analysis.validation import verbs
from ssmash_gym.analysis.validation.agreement import Agreement
from ssmash_gym.analysis.validation.figures import Curve, Figure, Panel, panel
from ssmash_gym.analysis.validation.manoeuvres import manoeuvre_named, manoeuvres
from ssmash_gym.analysis.validation.measures import curve, inside_axes, settled_from, span
from ssmash_gym.analysis.validation.picture import sheet_of, two_columns
from ssmash_gym.analysis.validation.report import agreement_table, statement_table
from ssmash_gym.analysis.validation.spatial import SPATIAL
from ssmash_gym.analysis.validation.statements import Runs, Statement
from ssmash_gym.analysis.validation.study import Asked, study
from ssmash_gym.cases import load_case, run_case
from ssmash_gym.cli import main

ROOT = Path(__file__).resolve().parents[2]
ROLL = Figure("9.9", "Roll", (panel("roll_N_deg", "roll angle [deg]", (-2.0, 12.0), 2.0),), (0.0, 6.0), 1.0)


def statement(holds: bool, **words: object) -> Statement:
    return Statement("it does", "here", lambda runs: {"x": 1.0}, "x is {x:.1f}", lambda n: holds, **words)


# --- statements -------------------------------------------------------------------------------------------------


def test_a_statement_that_does_not_hold_is_shown_with_its_numbers_and_reason(studied) -> None:
    runs = studied("1A").runs
    findings = [statement(True).check(runs), statement(False, note="because", chosen="a number").check(runs)]
    table = "\n".join(statement_table(findings))
    assert "| it does | here | x is 1.0 | yes |" in table
    assert "| it does <sup>1, 2</sup> | here | x is 1.0 | **no** |" in table
    assert "<sup>1</sup> Chosen with this in view: a number." in table and "<sup>2</sup> because" in table


def test_a_statement_about_a_variant_waits_for_it(studied) -> None:
    history = studied("1A").runs.default
    about = statement(True, needs=("independent",))
    assert about.check(Runs(history)) is None
    assert about.check(Runs(history, {"independent": history})) is not None


def test_axes_are_held_to_what_is_printed(studied) -> None:
    runs = studied("1B").runs
    assert inside_axes(ROLL).check(runs).holds
    roll = ROLL.panels[0]
    narrow = Figure("9.9", "Roll", (Panel(roll.curves, roll.label, (-2.0, 10.0), 2.0),), (0.0, 6.0), 1.0)
    left = inside_axes(narrow).check(runs)
    peak = span(runs.default, "roll_N_deg")[1]
    assert not left.holds and left.simulated == f"0.0 to {peak:.1f} deg"
    before = Figure("9.9", "Roll", narrow.panels, (0.0, 0.5), 0.1)  # the axis of time counts too
    assert inside_axes(before).check(runs).holds


def test_settling_is_measured_from_the_end(studied) -> None:
    history = studied("1A").runs.default
    assert settled_from(history, "z_N_m", 10.0) == 0.0
    found = settled_from(history, "z_N_m", 0.002)
    z = curve(history, "z_N_m")
    assert np.all(np.abs(z[history.time_s >= found] - z[-1]) <= 0.002)
    assert abs(z[np.flatnonzero(history.time_s < found)[-1]] - z[-1]) > 0.002 and 0.5 < found < 3.0


def test_agreement_is_asked_of_loads_and_places() -> None:
    close = Agreement("dop853", {"a": (100.4e3, 100.0e3)}, 0.004, 9)
    assert close.holds and close.loads_apart == pytest.approx(0.004)
    assert not Agreement("dop853", {"a": (100.6e3, 100.0e3)}, 0.0, 9).holds
    assert not Agreement("dop853", {"a": (1.0, 1.0)}, 0.006, 9).holds
    assert "| 1A | dop853, 9 right-hand sides | 0.400 % | 4.000 mm | yes |" in agreement_table([("1A", close)])


# --- pictures ---------------------------------------------------------------------------------------------------


def test_a_sheet_has_the_printed_axes_whatever_the_curves_do(studied) -> None:
    history = studied("1B").runs.default
    roll = ROLL.panels[0]
    narrow = Figure("9.9", "Roll", (Panel(roll.curves, roll.label, (-2.0, 10.0), 2.0),), (0.0, 6.0), 1.0)
    sheet = sheet_of([ROLL, narrow], {"ssmash_gym": history, "again": history}, ("title", "foot"))
    for axes, figure in zip(sheet.axes, (ROLL, narrow), strict=True):
        assert axes.get_xlim() == figure.seconds and axes.get_ylim() == figure.panels[0].limits
        np.testing.assert_allclose(np.diff(axes.get_yticks()), 2.0)
        assert len(axes.get_lines()) == 2
    said = [[text.get_text() for text in axes.texts] for axes in sheet.axes]
    peak = span(history, "roll_N_deg")[1]
    assert said == [[], [f"beyond the printed axis: 0.0 to {peak:.1f}"]]
    line = sheet.axes[0].get_lines()[0]
    np.testing.assert_array_equal(line.get_ydata(), curve(history, "roll_N_deg"))


def test_several_curves_in_one_panel_are_told_apart(studied) -> None:
    both = Panel((Curve("right_load_kN", "Right"), Curve("left_load_kN", "Left")), "load [kN]", (0.0, 80.0), 20.0)
    sheet = sheet_of([Figure("9.8", "Loads", (both,), (0.0, 6.0), 1.0)], {"a": studied("1B").runs.default}, ("t", "f"))
    assert [text.get_text() for text in sheet.axes[0].get_legend().get_texts()] == ["Right", "Left"]
    assert len({line.get_color() for line in sheet.axes[0].get_lines()}) == 2


def test_columns_are_filled_evenly() -> None:
    for manoeuvre in SPATIAL:
        columns = two_columns(manoeuvre.figures)
        panels = [sum(len(figure.panels) for figure in column) for column in columns]
        assert max(panels) - min(panels) <= 2
        assert {f.number for column in columns for f in column} == {f.number for f in manoeuvre.figures}


# --- the verb ---------------------------------------------------------------------------------------------------


def test_manoeuvres_are_found_by_any_case_and_refused_by_name() -> None:
    assert list(manoeuvres()) == ["1A", "1B", "1C", "1D", "2A", "2B", "2C"]
    assert manoeuvre_named("1a").name == "1A"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["3A"], "There is no manoeuvre '3A'; there are 1A, 1B, 1C, 1D, 2A, 2B, 2C and all."),
        (["1A", "--systems", "linn"], "There is no system 'linn'"),
        (["1A", "--friction", "wet"], "friction"),
        (["1A", "--solver", "euler"], "solver"),
    ],
)
def test_mistakes_cost_one_sentence_and_no_file(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["manoeuvre", *words, "--out", str(tmp_path / "out")]) in (1, 2)
    said = capsys.readouterr().err.strip()
    assert told in said and "\n" not in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_way_is_refused_before_anything_is_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("mine")
    monkeypatch.setattr(verbs, "run_studies", lambda *_: pytest.fail("something was run"))
    assert main(["manoeuvre", "1A", "--out", str(tmp_path / "file" / "out")]) == 1
    assert "is a file, expected a folder" in capsys.readouterr().err


def test_the_verb_writes_figures_summary_recording_and_configuration(tmp_path: Path) -> None:
    out = tmp_path / "out" / "1A"
    assert main(["manoeuvre", "1a", "--friction", "independent", "--out", str(out)]) == 0
    names = {path.name for path in out.iterdir()}
    assert names == {
        *("1A.png", "1A_figure_3.1.png", "1A_figure_3.2.png", "1A_figure_3.3.png", "1A_independent.png"),
        *("1A.parquet", "1A_independent.parquet", "1A.yaml", "summary.md", "summary.json"),
    }
    for path in out.glob("*.png"):
        assert path.stat().st_size < 150_000
        with Image.open(path) as picture:
            assert picture.width >= 700 and len(picture.convert("L").getcolors(256) or ()) > 8
    told = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert told["manoeuvre"] == "1A" and told["holding"] == len(told["statements"])
    page = (out / "summary.md").read_text(encoding="utf-8")
    assert "ssmash manoeuvre 1A --friction independent" in page and "(1A.png)" in page and "(1A.yaml)" in page
    assert all(finding["simulated"] in page for finding in told["statements"])
    again = run_case(load_case(out / "1A.yaml"))  # the configuration that is written makes the recording
    recorded = pl.read_parquet(out / "1A.parquet")
    np.testing.assert_array_equal(again["pitch"], recorded["pitch"].to_numpy())


def test_nothing_is_written_when_a_picture_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, studied) -> None:
    def broken(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr("ssmash_gym.analysis.validation.picture.save_png", broken)
    with pytest.raises(OSError, match="no space"):
        verbs.write([studied("1A")], {"1A": tmp_path / "out"}, "command", None)
    assert not any(path.is_file() for path in tmp_path.rglob("*"))


def test_a_second_integrator_and_other_systems_run_beside() -> None:
    seen: list[tuple[float, str]] = []
    short = manoeuvre_named("1A")
    asked = Asked(solvers=("dop853",), systems=("dynaface_like", "heliman_like"))
    found = study(short, asked, lambda share, words: seen.append((share, words)))
    assert [one.solver for one in found.agreements] == ["dop853"] and found.agreements[0].holds
    assert len(found.systems) == 1 and any("heliman_like cannot do case 1A" in remark for remark in found.remarks)
    shares = [share for share, _ in seen]
    assert shares == sorted(shares) and seen[0] == (0.0, "1A") and "1A solver dop853" in {words for _, words in seen}


# --- the documentation ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["1A", "1B", "1C", "1D", "2A", "2B", "2C"])
def test_the_pages_are_what_the_command_writes(name: str, studied) -> None:
    """Every number on the page of a manoeuvre comes from a run of its configuration as it is now."""
    manoeuvre, findings = manoeuvre_named(name), studied(name).findings
    page = (ROOT / "docs" / "manoeuvres" / f"{name}.md").read_text(encoding="utf-8")
    overview = (ROOT / "docs" / "manoeuvres" / "overview.md").read_text(encoding="utf-8")
    assert "\n".join(statement_table([f for f in findings if not f.statement.needs])) in page
    assert f"[{name} {manoeuvre.title}]" in overview
    assert (ROOT / "docs" / "images" / "manoeuvres" / f"{name}.png").stat().st_size < 150_000
    assert f"configs/manoeuvres/{manoeuvre.case_name}.yaml" in page
