"""Files of response tables: what is read, and what is refused in one sentence."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.response_table import ResponseTable

HEADER = "speed_kn,heading_deg,omega_rad_s,heave_m_per_m,heave_phase_deg,roll_deg_per_m,roll_phase_deg"
ROWS = [
    f"0,{beta},{omega},0.9,180,{1.5 * math.sin(math.radians(beta)):.3f},90"
    for beta in range(0, 181, 45)
    for omega in (0.4, 0.6, 0.9)
]


def small(tmp_path: Path) -> ResponseTable:
    return ResponseTable.read(write(tmp_path, [HEADER, *ROWS]), symmetric=True)


def write(tmp_path: Path, lines: list[str]) -> Path:
    file = tmp_path / "table.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_a_missing_degree_of_freedom_is_zero(tmp_path: Path) -> None:
    found = small(tmp_path).respond(np.array([0.5]), np.array([0.7]), np.ones(1), 0.0).transfer[0]
    assert np.all(found[[0, 1, 4, 5]] == 0.0) and abs(found[2]) > 0.5 and abs(found[3]) > 0.0


def test_comments_blank_lines_and_any_order_of_blocks_are_read(tmp_path: Path) -> None:
    plain = small(tmp_path)
    by_frequency = ROWS[0::3] + ROWS[1::3] + ROWS[2::3]  # frequency outermost, headings within
    shuffled = ["# a ship", "", HEADER.replace(",", " , "), *by_frequency[::1], "  ", "# end"]
    np.testing.assert_array_equal(
        ResponseTable.read(write(tmp_path, shuffled), symmetric=True).transfer, plain.transfer
    )
    blocks = ROWS[12:] + ROWS[:12]
    np.testing.assert_array_equal(
        ResponseTable.read(write(tmp_path, [HEADER, *blocks]), symmetric=True).transfer, plain.transfer
    )
    radians = [HEADER.replace("roll_deg_per_m", "roll_rad_per_m")]
    for row in ROWS:
        fields = row.split(",")
        radians.append(",".join([*fields[:5], repr(math.radians(float(fields[5]))), fields[6]]))
    np.testing.assert_allclose(
        ResponseTable.read(write(tmp_path, radians), symmetric=True).transfer, plain.transfer, rtol=1e-14
    )


def with_field(line: int, column: int, value: str) -> list[str]:
    lines = [HEADER, *ROWS]
    fields = lines[line - 1].split(",")
    fields[column] = value
    lines[line - 1] = ",".join(fields)
    return lines


MALFORMED = {
    "only comments": (["# nothing"], ("no line of column names",)),
    "semicolons": ([line.replace(",", ";") for line in [HEADER, *ROWS]], ("no comma", "commas expected", "a point")),
    "tabs": ([line.replace(",", "\t") for line in [HEADER, *ROWS]], ("no comma", "commas expected")),
    "decimal commas": ([HEADER, ROWS[0].replace(".", ",")], ("line 2: 10 columns found, expected are 7", "a point")),
    "no rows": ([HEADER], ("column names and no rows",)),
    "unknown column": ([HEADER + ",colour", *ROWS], ("column 'colour' is not known", "roll_deg_per_m")),
    "column twice": ([HEADER + ",roll_phase_deg", *ROWS], ("column roll_phase_deg stands there twice",)),
    "missing column": (with_field(1, 1, "surge_phase_deg"), ("column heading_deg is missing",)),
    "missing phase": ([HEADER.rsplit(",", 1)[0], *ROWS], ("roll has only one of amplitude and phase",)),
    "no motion": (["speed_kn,heading_deg,omega_rad_s", "0,0,1"], ("no column holds a motion",)),
    "two units": ([HEADER + ",roll_rad_per_m", *ROWS], ("roll stands there in two units",)),
    "short row": ([HEADER, *ROWS[:4], "0,45"], ("line 6", "2 columns found, expected are 7")),
    "word": (with_field(4, 3, "high"), ("line 4, column heave_m_per_m", "finite number", "'high'")),
    "blank": (with_field(4, 3, ""), ("line 4, column heave_m_per_m", "found ''")),
    "nan": (with_field(5, 6, "nan"), ("line 5, column roll_phase_deg", "'nan'")),
    "negative amplitude": (with_field(7, 5, "-1"), ("line 7, column roll_deg_per_m", "-1", "0 or more")),
    "heading": (with_field(7, 1, "400"), ("line 7, column heading_deg", "400", "-180 to 360")),
    "speed": (with_field(7, 0, "-3"), ("line 7, column speed_kn", "-3", "0 to 60 kn")),
    "frequency": (with_field(2, 2, "0"), ("line 2, column omega_rad_s", "above 0")),
    "unsorted": ([HEADER, ROWS[1], ROWS[0], *ROWS[2:]], ("line 3: omega_rad_s = 0.4 comes after a higher one",)),
    "duplicate": ([HEADER, ROWS[0], *ROWS], ("line 3: omega_rad_s = 0.4 stands there twice", "heading_deg = 0")),
    "gap": ([HEADER, *ROWS[:4], *ROWS[5:]], ("a gap", "heading_deg = 45", "omega_rad_s = 0.6", "every frequency")),
    "missing block": (
        [HEADER, *ROWS, *(r.replace("0,", "9,", 1) for r in ROWS[:12])],
        ("a gap", "speed_kn = 9, heading_deg = 180, omega_rad_s = 0.4"),
    ),
    "one frequency": ([HEADER, *ROWS[0::3]], ("omega_rad_s has 1 value", "2 frequencies or more")),
    "same direction": ([HEADER, *ROWS, *(r.replace("0,0,", "0,360,", 1) for r in ROWS[:3])], ("same direction twice",)),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_table_costs_one_sentence(tmp_path: Path, case: str) -> None:
    lines, words = MALFORMED[case]
    file = write(tmp_path, lines)
    with pytest.raises(ConfigurationError) as caught:
        ResponseTable.read(file, symmetric=True)
    message = str(caught.value)
    assert str(file) in message and "\n" not in message
    for word in words:
        assert word in message


def test_missing_empty_and_unreadable_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"nowhere\.csv: cannot be read \(No such file"):
        ResponseTable.read(tmp_path / "nowhere.csv")
    for name in ("empty.csv", "empty.npz"):
        (tmp_path / name).touch()
        with pytest.raises(ConfigurationError, match=f"{name}: it is empty"):
            ResponseTable.read(tmp_path / name)
    for name in ("noise.csv", "noise.npz"):
        (tmp_path / name).write_bytes(b"\xff\xfe\x00\x81" * 9)
        with pytest.raises(ConfigurationError, match=f"{name}: cannot be read as"):
            ResponseTable.read(tmp_path / name)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "folder.csv" / "x").touch()
    with pytest.raises(ConfigurationError, match=r"folder\.csv: cannot be read"):
        ResponseTable.read(tmp_path / "folder.csv")


MALFORMED_ARRAYS = {
    "unknown": ({"colour": np.zeros(3)}, ("array 'colour' is not known",)),
    "missing": ({"speed_kn": None}, ("array speed_kn is missing",)),
    "shape": ({"roll_phase_deg": np.zeros((1, 3, 8))}, ("roll_phase_deg has shape (1, 3, 8)", "allowed is (1, 8, 3)")),
    "scalar": ({"speed_kn": np.array(0.0)}, ("array speed_kn has shape ()", "one dimension")),
    "text": ({"omega_rad_s": np.array(["a", "b", "c"])}, ("omega_rad_s holds <U1, allowed are numbers",)),
    "objects": ({"omega_rad_s": np.array([{}, {}, {}])}, ("cannot be read as npz",)),
    "unsorted": ({"omega_rad_s": np.array([0.4, 0.9, 0.6])}, ("omega_rad_s has 0.6 after 0.9", "rising")),
    "nan": ({"roll_deg_per_m": np.full((1, 8, 3), np.nan)}, ("roll_deg_per_m[0, 0, 0]: nan is refused",)),
    "negative": ({"roll_deg_per_m": -np.ones((1, 8, 3))}, ("roll_deg_per_m[0, 0, 0]: -1 is refused", "0 or more")),
}


@pytest.mark.parametrize("case", MALFORMED_ARRAYS)
def test_malformed_arrays_cost_one_sentence(tmp_path: Path, case: str) -> None:
    change, words = MALFORMED_ARRAYS[case]
    arrays = {
        "speed_kn": np.zeros(1),
        "heading_deg": np.arange(0.0, 360.0, 45.0),
        "omega_rad_s": np.array([0.4, 0.6, 0.9]),
        "roll_deg_per_m": np.ones((1, 8, 3)),
        "roll_phase_deg": np.zeros((1, 8, 3)),
    }
    file = tmp_path / "table.npz"
    np.savez(file, **arrays)
    ResponseTable.read(file)  # whole before it is spoilt
    np.savez(file, **{k: v for k, v in (arrays | change).items() if v is not None})
    with pytest.raises(ConfigurationError) as caught:
        ResponseTable.read(file)
    message = str(caught.value)
    assert str(file) in message and "\n" not in message
    for word in words:
        assert word in message
