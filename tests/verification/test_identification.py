"""The catalogue's generic tricycle is what `ssmash identify` finds, and what that finding is worth.

Long parts (the search from round guesses, every case left out) are marked slow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.analysis.verification import identification
from ssmash_gym.analysis.verification import refit as refitting
from ssmash_gym.analysis.verification.description import (
    helicopter_text,
    identified,
    identified_inputs,
    inputs_text,
    values_of,
)
from ssmash_gym.analysis.verification.identification import Fit, Problem
from ssmash_gym.analysis.verification.parameters import FREE, HEAD_WIND, ROLLING, guesses, helicopter_changes
from ssmash_gym.analysis.verification.refit import LEFT_OUT, refit, solve, variants
from ssmash_gym.analysis.verification.table import load_table, plain
from ssmash_gym.analysis.verification.trials import run_table
from ssmash_gym.cli import main
from ssmash_gym.vehicle import load_helicopter, with_changes

TABLE = load_table()
TRICYCLE = load_helicopter("generic_tricycle")
VALUES = values_of(TRICYCLE, plain(TABLE.inputs, "inputs"))
# Errors of predictions that an independent implementation with the thesis' lever arm makes, doubled.
AIMS = {
    ("2", "z_m"): 0.0006, ("2", "nose_load_kN"): 0.170, ("2", "right_load_kN"): 0.084,
    ("3", "pitch_deg"): 0.030, ("3", "nose_load_kN"): 0.014, ("3", "right_load_kN"): 0.006,
    ("4", "pitch_deg"): 0.008, ("4", "nose_load_kN"): 0.026, ("4", "right_load_kN"): 0.014,
    ("13", "nose_compression_m"): 0.0036, ("14", "nose_compression_m"): 0.005, ("15", "nose_compression_m"): 0.0136,
}  # fmt: skip
# What the loaded radius as lever arm makes of it (docs/verification_table.md): beyond the aim, and told.
MISSED = {
    ("2", "z_m"): 0.0012, ("3", "nose_load_kN"): 0.12, ("3", "right_load_kN"): 0.06,
    ("4", "nose_load_kN"): 0.09, ("4", "right_load_kN"): 0.045,
}  # fmt: skip


@pytest.fixture(scope="module")
def problem() -> Problem:
    return Problem(TABLE, TRICYCLE)


@pytest.fixture(scope="module")
def fit(problem: Problem) -> Fit:
    return problem.fit(VALUES)


def alike(one: Fit, other: dict[str, float], share: float) -> None:
    for p in one.parameters:
        assert abs(one.values[p.name] - other[p.name]) < share * one.deviations[p.name], p.name


# --- the committed files are the output ----------------------------------------------------------------------


def test_the_catalogue_s_file_is_written_by_the_identification() -> None:
    path = Path(__file__).parents[2] / "configs" / "helicopters" / "generic_tricycle.yaml"
    assert path.read_text(encoding="utf-8") == helicopter_text(TRICYCLE)
    assert TABLE.inputs_path.read_text(encoding="utf-8") == inputs_text(TABLE.inputs)


def test_the_search_stays_at_the_catalogue_s_numbers(fit: Fit) -> None:
    assert fit.evaluations < 10
    alike(fit, VALUES, 0.02)
    assert not fit.at_bounds
    made = identified(TRICYCLE, {**VALUES, **fit.values}, fit.deviations)
    assert made.mass_kg == pytest.approx(TRICYCLE.mass_kg, rel=1e-4)
    assert {m.path: m.origin for m in made.provenance} == {m.path: m.origin for m in TRICYCLE.provenance}


def test_it_is_a_good_fit(fit: Fit) -> None:
    assert fit.chi2 < 15.0  # 22 independent values, 17 free numbers
    assert np.abs(fit.residuals).max() < 2.0
    assert len(fit.rows) == 25 and len(fit.parameters) == 17


def test_the_page_shows_the_identified_numbers(fit: Fit) -> None:
    page = (Path(__file__).parents[2] / "docs" / "verification_table.md").read_text(encoding="utf-8")
    shown = page.split("<!-- ssmash identify --variants --markdown -->")[1].split("<!-- end -->")[0]
    rows = [[cell.strip(" `") for cell in line.strip("| ").split("|")] for line in shown.splitlines()]
    values = {row[0]: (float(row[1]), float(row[2])) for row in rows if row[0] in fit.deviations and len(row) == 5}
    assert len(values) == len(fit.parameters)
    for name, (value, deviation) in values.items():
        assert abs(value - fit.values[name]) < 0.02 * deviation
        assert deviation == pytest.approx(fit.deviations[name], rel=0.1)
    assert f"chi2 {fit.chi2:.1f} of" in shown


def test_a_wrong_number_is_seen(problem: Problem) -> None:
    """Every free number, 5 % off and nothing else moved, makes the fit worse."""
    off = [{**VALUES, p.name: VALUES[p.name] + 0.05 * abs(VALUES[p.name])} for p in FREE]
    residuals = problem.residuals([VALUES, *off], problem.rows)
    squares = (residuals**2).sum(axis=1)
    for p, chi2 in zip(FREE, squares[1:], strict=True):
        assert chi2 > squares[0] + 0.3, p.name


def test_values_go_into_a_description_and_come_back() -> None:
    other = {p.name: 0.5 * (VALUES[p.name] + p.guess) for p in (*FREE, ROLLING, *HEAD_WIND)}
    helicopter = with_changes(TRICYCLE, helicopter_changes(TRICYCLE, other))
    assert helicopter.total_mass_kg == pytest.approx(10450.0)
    back = values_of(helicopter, identified_inputs(other, None))
    assert back == pytest.approx(other, rel=1e-5)


def test_marks_say_what_is_fitted_and_how_well() -> None:
    marks = TRICYCLE.marks
    for path in ("stations.auxiliary.spring.gas_pressure_Pa", "stations.right.mount_m", "probe.small_stiffness_x_Npm"):
        assert marks[path].origin == "fitted" and "sd " in marks[path].note
    for path in ("stations.right.spring.gas_volume_m3", "stations.right.spring.gas_exponent", "inertia_kgm2"):
        assert marks[path].origin == "assumed"
    assert not any("a tenth of it" in mark.note for mark in TRICYCLE.provenance)


def test_the_trials_in_time_fix_rolling_resistance_and_wind() -> None:
    """Solved from somewhere else, they come back to the committed numbers."""
    off = {**VALUES, "rolling_resistance": 1.3 * VALUES["rolling_resistance"]}
    again = solve(TABLE, TRICYCLE, off, (ROLLING,), "5", ("x_m",))
    assert again["rolling_resistance"] == pytest.approx(VALUES["rolling_resistance"], rel=0.02)


# --- rests are where runs in time end ------------------------------------------------------------------------


def test_rests_are_where_the_runs_in_time_end(problem: Problem) -> None:
    run = run_table(TABLE, TRICYCLE, ["1", "4", "6", "7", "12"])
    rest = problem.simulated([VALUES])
    for result in run.results:
        unit = result.row.quantity.rsplit("_", 1)[1]
        value = float(rest[result.trial, result.row.quantity][0])
        assert value == pytest.approx(result.simulated, abs={"kN": 0.001, "deg": 0.001, "m": 0.0001}[unit])


# --- predictions ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_case_13_is_predicted_without_it(problem: Problem) -> None:
    without = problem.fit(VALUES, without="13")
    assert all(key != "13" for key, _ in without.rows) and len(without.rows) == 24
    (prediction,) = problem.predictions("13", without)
    assert abs(prediction.error) < AIMS["13", "nose_compression_m"]
    assert 1e-5 < prediction.deviation < 2e-3


@pytest.mark.slow
def test_the_search_from_round_guesses_comes_to_the_same_numbers(problem: Problem) -> None:
    alike(problem.fit(guesses()), VALUES, 0.05)


@pytest.mark.slow
def test_predictions_of_cases_left_out() -> None:
    found = refit(TABLE, TRICYCLE, VALUES)
    assert {p.trial for p in found.predictions} == set(LEFT_OUT)
    assert {(p.trial, p.row.quantity) for p in found.predictions} == set(AIMS)
    for p in found.predictions:
        key = p.trial, p.row.quantity
        assert abs(p.error) < MISSED.get(key, AIMS[key]), key
        if p.trial == "4":
            assert abs(p.error) < 2.0 * p.deviation  # what case 4 alone knows is the length of the wheelbase


@pytest.mark.slow
def test_an_isothermal_nose_oleo_fits_best(problem: Problem, fit: Fit) -> None:
    adiabatic = next(v for v in variants(TRICYCLE) if v.label == "nose gas exponent 1.4")
    other = Problem(TABLE, with_changes(TRICYCLE, adiabatic.changes)).fit(VALUES)
    assert other.chi2 > 5.0 * fit.chi2


# --- the command ---------------------------------------------------------------------------------------------


def test_a_file_in_the_place_of_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "there").write_text("mine")
    assert main(["identify", "--out", str(tmp_path / "there")]) == 1
    assert "is refused: it is a file" in capsys.readouterr().err
    assert (tmp_path / "there").read_text() == "mine"


def test_the_command_writes_both_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identification, "SEARCHES", 1)
    monkeypatch.setattr(refitting, "solve", lambda _table, _template, values, *_: dict(values))  # has its own test
    assert main(["identify", "--warm", "--no-predictions", "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "Residuals" in shown and "chi2" in shown and "half_track_m" in shown
    again = load_helicopter(tmp_path / "helicopters" / "generic_tricycle.yaml")
    assert again.stations.right.mount_m == pytest.approx(TRICYCLE.stations.right.mount_m, rel=1e-3)
    assert (tmp_path / "verification" / "case_inputs.yaml").is_file()
