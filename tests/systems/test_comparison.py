"""One manoeuvre through all systems: curves, refusals, table and picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.cases import Case, History, case_document, case_from, load_case, run_case
from ssmash_gym.dynamics import reference
from ssmash_gym.errors import ConfigurationError, SolverError
from ssmash_gym.systems import (
    cases_of,
    compare,
    label,
    load_system,
    system_names,
    systems_figure,
    systems_table,
    told,
    why_not,
)
from ssmash_gym.systems.comparison import PEAKS, Comparison
from ssmash_gym.systems.verbs import case_called, systems


def brief(**changes: Any) -> Case:
    """Two tenths of a second of the tricycle."""
    solution = {"end_s": 0.2, "output_step_s": 0.02}
    return case_from({"name": "brief", "helicopter": "generic_tricycle", "solution": solution, **changes})


@pytest.fixture(scope="module")
def done(rolling_traverse: Case, runs: dict[str, History]) -> Comparison:
    """The comparison that `compare` makes, of the runs that are there already."""
    systems = {name: load_system(name) for name in system_names()}
    histories = {name: told(system, rolling_traverse, runs[name])[0] for name, system in systems.items()}
    labels = {name: label(system, rolling_traverse) for name, system in systems.items()}
    return Comparison(rolling_traverse, histories, labels, {"none": "none cannot do it."})


def test_a_comparison_runs_what_can_be_run_and_tells_the_rest() -> None:
    case = load_case("1a").changed({"solution.end_s": 0.2})
    shares: list[float] = []
    found = compare(case, ["heliman_like", "dynaface_like", "feldman_scale"], shares.append)
    assert list(found.histories) == ["ssmash", "dynaface_like", "feldman_scale"]
    assert list(found.refusals) == ["heliman_like"]
    np.testing.assert_allclose(found.histories["feldman_scale"].time_s, found.histories["ssmash"].time_s)
    assert shares == sorted(shares) and shares[-1] < 1.0
    with pytest.raises(ConfigurationError, match="There is no system 'nobody'"):
        compare(case, ["nobody"])


def test_a_system_whose_settings_are_refused_leaves_the_others_alone(tmp_path: Path) -> None:
    """Noise of a claw at 4 Hz is 13 Hz at a tenth, more than a claw may have; a file asks for wings."""
    noise = {"rms_m": 0.001, "low_hz": 3.0, "high_hz": 4.0}
    claw = {"type": "points", "time_s": [0, 1], "x_m": [0, 1], "y_m": [0, 0], "noise": noise}
    case = brief(claw=claw)
    mine = tmp_path / "winged.yaml"
    mine.write_text("title: Winged\nsource: this test\nchanges: {wings: 2}\n", encoding="utf-8")
    found = compare(case, ["feldman_scale", str(mine), "heliman_like"])
    assert list(found.histories) == ["ssmash", "heliman_like"]
    assert list(found.refusals) == ["feldman_scale", "winged"]
    for name, words in (
        ("feldman_scale", "scaled 1:10, claw.noise.high_hz = 12.6"),
        ("winged", "changes to generic_tricycle: there is no key wings"),
    ):
        sentence = found.refusals[name]
        assert sentence.startswith(f"{name} cannot do case brief: {words}")
        assert sentence.endswith(".") and not sentence.endswith("..") and "\n" not in sentence
    assert why_not(load_system("feldman_scale"), case) == found.refusals["feldman_scale"]
    assert list(cases_of(case, ["ssmash", str(mine)])) == ["ssmash"]


def test_a_solver_that_gives_up_on_one_system_leaves_the_others_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(case: Case, progress: object = None) -> History:
        if case.deck.type == "fixed":  # that of heliman_like
            raise SolverError("Radau gave up at t = 0.1 s: no reason\nwas given")
        return run_case(case)

    monkeypatch.setattr("ssmash_gym.systems.comparison.run_case", run)
    deck = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 1.0, "period_s": 5.0}
    claw = {"type": "points", "time_s": [0, 1], "x_m": [0, 1], "y_m": [0, 0]}
    found = compare(brief(deck=deck, claw=claw), ["heliman_like", "dynaface_like"])
    assert list(found.histories) == ["ssmash", "dynaface_like"]
    told_so = "heliman_like cannot do case brief: Radau gave up at t = 0.1 s: no reason was given."
    assert found.refusals == {"heliman_like": told_so}


def test_a_solver_that_gives_up_on_all_systems_writes_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(reference, "SPARE_EVALUATIONS", 5)
    monkeypatch.setattr(reference, "EVALUATIONS_PER_S", 0)
    case = brief(solution={"end_s": 0.1, "output_step_s": 0.02, "solver": "dop853"})
    found = compare(case, ["dynaface_like"])
    assert not found.histories and list(found.refusals) == ["ssmash", "dynaface_like"]
    assert "DOP853 gave up" in systems_table(found)
    file = tmp_path / "case.yaml"
    file.write_text(json.dumps(case_document(case)), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=r"^ssmash cannot do case brief: DOP853 gave up .*\.$"):
        systems(str(file), names=("dynaface_like",), out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_case_that_the_full_model_refuses_is_refused(tmp_path: Path) -> None:
    case = brief(claw={"type": "file", "path": str(tmp_path / "none.inp")})
    with pytest.raises(ConfigurationError, match="cannot be read"):
        compare(case, ["dynaface_like"])


def test_no_file_replaces_the_full_model_or_a_system_of_the_catalogue(tmp_path: Path) -> None:
    for name in ("ssmash", "dynaface_like"):
        file = tmp_path / f"{name}.yaml"
        file.write_text("title: Mine\nsource: this test\nprobe: 'off'\n", encoding="utf-8")
        for given in ([str(file)] if name == "ssmash" else [name, str(file)],):
            with pytest.raises(ConfigurationError, match=f"name = '{name}' is refused: another system") as refused:
                compare(brief(), given)
            assert "\n" not in str(refused.value)
    with pytest.raises(ConfigurationError, match="another system"):
        cases_of(brief(), [str(tmp_path / "ssmash.yaml")])
    assert list(compare(brief(), ["ssmash", "dynaface_like", "dynaface_like"]).histories) == ["ssmash", "dynaface_like"]


def test_cases_of_gives_the_same_manoeuvre_by_label(rolling_traverse: Case) -> None:
    found = cases_of(rolling_traverse)
    assert next(iter(found)) == "ssmash"
    assert "heliman_like (deck levelled)" in found
    assert not any("1:10" in name for name in found)  # another clock: `compare` tells it at full scale
    assert found["heliman_like (deck levelled)"].deck.type == "fixed"


def test_the_table_tells_what_each_simplification_costs(done: Comparison) -> None:
    table = systems_table(done)
    lines = table.splitlines()
    assert lines[0].startswith("| system | probe in-plane [kN] |")
    rows = {line.split("|")[1].strip(): line for line in lines[2:] if line.startswith("|")}
    assert set(rows) == set(done.labels.values())
    assert "none" in rows["blackwell_feik (claw held still, not secured)"].split("|")[2]
    assert "%" not in rows["ssmash"] and "%" in rows["dynaface_like (claw held still)"]
    assert table.rstrip().endswith("none cannot do it.")
    peaks = done.peaks()
    probe = PEAKS[0].name
    # Securing alone and manoeuvring alone both miss most of the load of the two together.
    for part in ("dynaface_like", "dynaface_like_linear", "heliman_like"):
        assert peaks[part][probe] < 0.75 * peaks["ssmash"][probe]
    assert np.isnan(peaks["blackwell_feik"][probe])


def test_the_page_shows_what_is_simulated(done: Comparison) -> None:
    """The table of docs/guide/systems.md, number by number: within what two decimals can hold, and 1 %."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "guide" / "systems.md").read_text(encoding="utf-8")
    for name, values in done.peaks().items():
        row = next(line for line in page.splitlines() if line.startswith(f"| {done.labels[name]} |"))
        for cell, value in zip(row.split("|")[2:-1], values.values(), strict=True):
            if np.isnan(value):
                assert cell.strip() == "none"
            else:
                assert float(cell.split()[0]) == pytest.approx(value, rel=0.01, abs=0.006)


def test_a_helicopter_that_falls_over_is_shown_no_further() -> None:
    deck = {"type": "sinusoid", "dof": "roll", "amplitude_deg": 35.0, "period_s": 6.0}
    case = case_from({"name": "heavy", "helicopter": "generic_tricycle", "deck": deck, "solution": {"end_s": 6.0}})
    found = compare(case, ["blackwell_feik"])
    history = found.histories["blackwell_feik"]
    assert history.time_s[-1] < 6.0
    assert history.states.shape[1] == history.outputs.shape[1] == history.time_s.size
    assert f"overturns at {history.time_s[-1]:.1f} s" in found.refusals["blackwell_feik"]


def test_the_picture_is_written_whole(done: Comparison, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    path = tmp_path / "new" / "systems.png"
    systems_figure(done, path)
    with image.open(path) as picture:
        assert picture.width == 1100 and picture.height > 500
        assert "rolling_traverse" in picture.text["Title"]
    assert [p.name for p in path.parent.iterdir()] == ["systems.png"]


def test_the_verb_writes_picture_and_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    case = tmp_path / "drop.yaml"
    case.write_text(
        "name: drop\ntitle: A short drop\nhelicopter: generic_tricycle\nstart: {type: drop, cg_height_m: 2.7}\n"
        "solution: {end_s: 0.1, output_step_s: 0.02}\n",
        encoding="utf-8",
    )
    systems(str(case), names=("heliman_like",), out=tmp_path / "out")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["systems_drop.md", "systems_drop.png"]
    text = (tmp_path / "out" / "systems_drop.md").read_text(encoding="utf-8")
    assert text.startswith("# Case drop: A short drop") and "heliman_like cannot do case drop" in text
    assert "Written:" in capsys.readouterr().out


def test_the_verb_refuses_before_it_writes(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "out"
    with pytest.raises(ConfigurationError, match="There is no case 'x'"):
        systems("x", out=out)
    with pytest.raises(ConfigurationError, match="There is no system 'x'"):
        systems("rolling_traverse", names=("x",), out=out)
    assert not out.exists()
    out.write_text("taken", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="it is a file"):
        systems("rolling_traverse", out=out)
    assert out.read_text(encoding="utf-8") == "taken"
    assert case_called("Rolling_Traverse").name == "rolling_traverse"
