"""Table 3.1 of Léveillé 2013: every printed value beside the simulation, in time, and the command that shows it.

What the table prints is transcribed here a second time, so that the file of the trials cannot drift from it.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.analysis.verification import report
from ssmash_gym.analysis.verification.table import PrintedRow, load_table
from ssmash_gym.analysis.verification.trials import Result, Verification, run_table
from ssmash_gym.cases import case_from, load_case, quantity, run_case
from ssmash_gym.cli import main
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.vehicle import load_helicopter, with_changes

TABLE = load_table()
PRINTED = {
    "1": {"nose_load_kN": 34.999, "right_load_kN": 33.758, "sum_load_kN": 102.514, "pitch_deg": 0.436,
          "z_m": -2.292, "nose_compression_m": 0.277},
    "2": {"z_m": -2.272, "nose_load_kN": 38.338, "right_load_kN": 36.993, "sum_load_kN": 112.324},
    "3": {"pitch_deg": -0.354, "nose_load_kN": 44.000, "right_load_kN": 29.257, "sum_load_kN": 102.514},
    "4": {"pitch_deg": 0.8084, "nose_load_kN": 31.174, "right_load_kN": 34.475, "sum_load_kN": 102.124},
    "5": {"x_m": -10.613, "yaw_deg": 0.0, "y_m": 0.0},
    "6": {"x_m": -0.022, "yaw_deg": 0.0, "probe_x_kN": 8.936, "probe_y_kN": 0.0},
    "7": {"roll_deg": 2.023, "right_load_kN": 41.185, "left_load_kN": 25.984, "main_sum_load_kN": 67.168},
    "8": {"roll_deg": 0.004, "yaw_deg": 92.4, "steer_deg": -0.871, "y_m": 9.685},
    "9": {"tire_deflection_m": -0.002, "yaw_deg": 1.727, "y_m": 0.155},
    "10": {"yaw_deg": 45.6, "steer_deg": -0.406, "tire_deflection_m": 0.0},
    "11": {"pitch_deg": 0.259, "x_m": 13.726},
    "12": {"roll_deg": 1.7499, "tire_deflection_m": -0.0048, "right_load_kN": 40.550, "yaw_deg": 0.0011},
    "13": {"nose_compression_m": 0.211},
    "14": {"nose_compression_m": 0.347},
    "15": {"nose_compression_m": 0.134},
}  # fmt: skip
FAULTY = {("4", "right_load_kN"), ("9", "y_m"), ("10", "yaw_deg"), ("10", "steer_deg"), ("10", "tire_deflection_m")}
TRENDS = {"8", "9", "10"}  # whose tolerances are not the common ones
COMMON = {"kN": 0.02, "deg": 0.005, "m": 0.0015}
ROWS = [(key, row) for key, trial in TABLE.trials.items() for row in trial.file.rows]
SOUND = [(key, row.quantity) for key, row in ROWS if (key, row.quantity) not in FAULTY]


@pytest.fixture(scope="module")
def verification() -> Verification:
    return run_table(TABLE)


def test_the_file_has_what_the_thesis_prints() -> None:
    assert {
        key: {row.quantity: row.printed for row in trial.file.rows} for key, trial in TABLE.trials.items()
    } == PRINTED


def test_no_tolerance_is_wider_than_promised() -> None:
    for key, row in ROWS:
        if key not in TRENDS:
            assert row.tolerance <= COMMON[row.quantity.rsplit("_", 1)[1]] and not row.why, (key, row.quantity)
        elif row.tolerance > COMMON[row.quantity.rsplit("_", 1)[1]] and row.aim is not None:
            assert row.why, (key, row.quantity)


@pytest.mark.parametrize(("key", "name"), SOUND, ids=[f"{key}-{name}" for key, name in SOUND])
def test_every_sound_value_is_met(verification: Verification, key: str, name: str) -> None:
    result = verification.of(key, name)
    assert result.passed, f"{result.simulated:.6g} instead of {result.row.printed:g} +- {result.row.tolerance:g}"


def test_everything_goes_the_way_the_table_expects(verification: Verification) -> None:
    words = [result for result in verification.results if result.as_expected is not None]
    assert len(words) > 20
    assert [(r.trial, r.row.quantity) for r in words if not r.as_expected] == []


def test_the_reference_is_where_a_drop_ends() -> None:
    """Section 3.2.1: dropped from a c.g. height of 2.7 m, in the air at first; figure 3.3 ends at 0.9 deg of pitch."""
    document = {
        "name": "drop",
        "helicopter": "generic_tricycle",
        "changes": {"stations.*.steering": "locked", "stations.*.rolling": "locked", "probe.active": False},
        "start": {"type": "drop", "cg_height_m": 2.7},
        "solution": {"end_s": 20.0, "output_step_s": 0.02, "substep_s": 0.001},
    }
    history = run_case(case_from(document))
    loads = [history[f"{wheel}_vertical_load"] for wheel in ("auxiliary", "right", "left")]
    assert max(load[0] for load in loads) == 0.0
    assert 0.5 < np.rad2deg(history.peak_max("pitch").max()) < 0.9
    for name in ("z_m", "pitch_deg", "nose_load_kN", "sum_load_kN"):
        row = next(row for row in TABLE.trials["1"].file.rows if row.quantity == name)
        assert quantity(name).of(history)[-1] == pytest.approx(row.printed, abs=row.tolerance), name
    assert abs(np.rad2deg(history["roll"][-1])) < 1e-6


# --- what is wrong with the table ----------------------------------------------------------------------------


def test_faulty_values_say_why(verification: Verification) -> None:
    faulty = [result for result in verification.results if result.row.status == "faulty"]
    assert {(result.trial, result.row.quantity) for result in faulty} == FAULTY
    assert all(len(result.row.reason) > 20 for result in faulty)


def test_case_4_right_is_a_misprint(verification: Verification) -> None:
    result = verification.of("4", "right_load_kN")
    assert abs(result.simulated - 34.475) > 0.9
    assert result.passed and result.simulated == pytest.approx(35.475, abs=0.02)
    total = verification.of("4", "sum_load_kN").simulated
    assert total == pytest.approx(102.514 * np.cos(np.deg2rad(5.0)), abs=0.001)


def test_case_9_contradicts_itself(verification: Verification) -> None:
    """A heading that grows in proportion to the way travelled carries it aside by half the final heading's share."""
    y, yaw = (verification.of("9", name) for name in ("y_m", "yaw_deg"))
    assert y.passed is None  # nothing right to compare with
    way = 0.5 * 9.81 * np.sin(np.deg2rad(5.0)) * 20.0**2
    assert 0.5 * np.deg2rad(yaw.row.printed) * way > 10.0 * y.row.printed
    assert y.simulated > 0.7 * np.deg2rad(yaw.simulated) * way / 2.0


def test_case_10_needs_the_other_sign(verification: Verification) -> None:
    printed = next(v for v in verification.varied if v.trial == "10" and "as printed" in v.label)
    assert printed.values["yaw_deg"] > 130.0  # downhill is at 135
    assert verification.of("10", "yaw_deg").passed and verification.of("10", "tire_deflection_m").passed


def test_case_8_is_a_band_and_no_number(verification: Verification) -> None:
    varied = {v.label: v.values for v in verification.varied if v.trial == "8"}
    sides = [values["y_m"] for values in varied.values()]
    assert min(sides) > 0.0 and max(sides) > 20.0 * min(sides)  # of what the thesis leaves open
    own = verification.of("8", "yaw_deg").simulated
    assert varied["one second earlier"]["yaw_deg"] < own - 10.0 < own < varied["one second later"]["yaw_deg"]
    for label in ("initial yaw", "initial steer"):
        less, more = (next(v for k, v in varied.items() if k.startswith(f"{label} {sign}")) for sign in "-+")
        assert less["y_m"] < verification.of("8", "y_m").simulated < more["y_m"]


# --- the report ----------------------------------------------------------------------------------------------


def test_a_wrong_helicopter_fails() -> None:
    helicopter = load_helicopter("generic_tricycle")
    wider = with_changes(helicopter, {"stations.right.mount_m.1": 1.6, "stations.left.mount_m.1": -1.6})
    found = run_table(TABLE, wider, ["1", "7"])
    assert found.of("1", "nose_load_kN").passed
    assert not found.of("7", "roll_deg").passed and not found.of("7", "right_load_kN").passed
    assert report.counts(found)[0] == "fitted: 7 of 10 pass"
    assert " NO " in report.markdown(found)


def test_a_result_is_judged_by_its_tolerance() -> None:
    row = PrintedRow(quantity="roll_deg", printed=2.0, tolerance=0.1, status="predicted", expected="small negative")
    assert Result("7", row, 2.1 - 1e-9, 0.0).passed and not Result("7", row, 2.11, 0.0).passed
    assert Result("7", row, -0.1, 0.0).as_expected and not Result("7", row, 2.0, 0.0).as_expected
    fallen = PrintedRow(quantity="z_m", printed=1.0, tolerance=0.1, status="predicted", expected="decrease")
    assert Result("7", fallen, 0.9, 1.0).as_expected and not Result("7", fallen, 1.1, 1.0).as_expected


def test_json_is_rows_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--json", "--case", "4"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == ["rows"]
    assert [row["quantity"] for row in document["rows"]] == list(PRINTED["4"])
    for row in document["rows"]:
        assert row["case"] == "4" and row["thesis"] == PRINTED["4"][row["quantity"]]
        assert abs(row["difference"]) <= row["tolerance"] and row["pass"] is True
        assert row["status"] in ("fitted", "predicted", "faulty")
        assert row["configuration"] == "configs/verification/table_3_1.yaml: trials.4"
    assert document["rows"][2]["corrected"] == 35.475 and "misprint" in document["rows"][2]["reason"]


def test_the_table_names_cases_and_configurations(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--case", "12", "--cases-to", str(tmp_path)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "40.55" in shown and "configs/verification/table_3_1.yaml" in shown and "fitted: 4 of 4 pass" in shown
    case = load_case(tmp_path / "case_12.yaml")  # whole: helicopter, wind and the reference state it starts from
    assert case.vehicle.aerodynamics.wind_N_mps[1] > 20.0 and case.start.type == "state"


def test_a_case_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--case", "16"]) == 1
    assert "--case 16 is refused: the cases are 1, 2, 3" in capsys.readouterr().err
    assert main(["verify", "--json", "--markdown"]) == 1


def test_the_page_shows_what_the_command_prints(verification: Verification) -> None:
    """To the digits shown, with room for another processor's rounding; sections of words to the letter."""
    page = (Path(__file__).parents[2] / "docs" / "verification_table.md").read_text(encoding="utf-8")
    shown = page.split("<!-- ssmash verify --markdown -->")[1].split("<!-- end -->")[0].strip().splitlines()
    printed = report.markdown(verification).splitlines()
    assert len(shown) == len(printed)
    rows = dict(
        zip(((r.trial, f"`{r.row.quantity}`") for r in verification.results), verification.results, strict=True)
    )
    for there, here in zip(shown, printed, strict=True):
        cells, again = ([cell.strip() for cell in line.strip("| ").split("|")] for line in (there, here))
        if tuple(cells[:2]) in rows:
            result = rows[cells[0], cells[1]]
            digit = 10.0 ** -len(cells[4].partition(".")[2])
            assert abs(float(cells[4]) - result.simulated) <= 0.1 * result.row.tolerance + 0.6 * digit, there
            assert cells[:4] == again[:4] and cells[6:] == again[6:]
        elif not here.startswith("| "):
            assert there == here


# --- the file ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("status: faulty\n        corrected: 35.475", "status: predicted\n        corrected: 35.475", "reason"),
        ("quantity: roll_deg, printed: 2.023", "quantity: rol_deg, printed: 2.023", "there is no quantity 'rol_deg'"),
        ("printed: 2.023, expected: positive, tolerance: 0.005", "printed: 2.023, tolerance: 0.0", "tolerance"),
        ('  "1":\n', '  "one":\n', "trial '1' is the reference"),
        ("overlay: {deck: {type: fixed, roll_deg: 5.0}}", "overlay: {deck: {type: fixed, rol_deg: 5.0}}", "rol_deg"),
        ("inputs: case_inputs.yaml", "inputs: none.yaml", "there is no such file"),
    ],
)
def test_a_broken_file_is_refused_in_a_sentence(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = TABLE.path.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "table.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    (tmp_path / "case_inputs.yaml").write_text(TABLE.inputs_path.read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(ConfigurationError, match=told) as refused:
        load_table(tmp_path / "table.yaml")
    assert "\n" not in str(refused.value)
