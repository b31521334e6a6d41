"""Numbers are read however they are written; every mistake is told with file, line, column and what was expected."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.thesis_files import read_case, read_folder, write_case
from ssmash_gym.thesis_files.folder import SIDECAR, read
from ssmash_gym.thesis_files.reading import read_number
from tests.thesis_files import rig


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_case(rig.document(), tmp_path / "hop")
    return tmp_path / "hop"


def edit(path: Path, number: int, change: Callable[[str], str] | str) -> None:
    lines = path.read_text().splitlines()
    lines[number - 1] = change if isinstance(change, str) else change(lines[number - 1])
    path.write_text("\n".join(lines) + "\n")


def refusal(folder: Path) -> str:
    with pytest.raises(ConfigurationError) as caught:
        read_folder(folder)
    text = str(caught.value)
    assert "\n" not in text and text.endswith(".")
    assert text.startswith(str(folder))
    return text.removeprefix(str(folder)).lstrip("/")


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("1", 1.0),
        ("-1.5", -1.5),
        (".5", 0.5),
        ("5.", 5.0),
        ("1.0D+00", 1.0),
        ("2.5d3", 2500.0),
        ("1e-3", 1e-3),
        ("0.25+003", 250.0),
        ("1.0Q2", 100.0),
    ],
)
def test_numbers_of_c_python_and_fortran(word: str, value: float) -> None:
    assert read_number(word) == value


@pytest.mark.parametrize("word", ["", "x", "1_000", "0x10", "1.2.3", "1d", "--1", "1,5", "٣", "1e", "true"])
def test_what_is_no_number(word: str) -> None:
    assert read_number(word) is None


def test_nothing_that_is_not_finite_passes() -> None:
    assert all(math.isnan(read_number(word) or 0.0) for word in ("NaN", "inf", "-Infinity", "nan(0)"))
    assert read_number("1e999") == math.inf


def test_the_same_numbers_in_other_clothes(folder: Path) -> None:
    plain = read(folder).numbers
    heli = folder / "heli.inp"
    lines = heli.read_text().splitlines()
    mass, row = lines[0].split()[0], lines[1].split()[:3]
    lines[0] = f"  {mass.replace('e', 'D')}\t(mass of the helicopter, kg)"
    lines[1] = ",".join(row) + " # first row"
    lines[25] = "3*0.0 unused"
    lines.insert(2, "")
    lines.insert(3, "! a line of words")
    (folder / "HELI.INP").write_bytes(b"\xef\xbb\xbf" + "\r\n".join(lines).encode())
    heli.unlink()
    assert read(folder).numbers == plain


@pytest.mark.parametrize("name", ["RSD_POS.INP", "rsdmo.inp", "RSD POS.INP"])
def test_the_claw_file_goes_by_several_names(folder: Path, name: str) -> None:
    edit(folder / "prescribed.inp", 1, "1")
    assert "there is no rsd_pos.inp" in refusal(folder)
    (folder / name).write_text("! t x y z\n" + rig.CLAW_ROWS)
    (folder / SIDECAR).unlink()
    assert read_case(folder)["claw"]["path"] == str(folder.resolve() / name)


def test_two_files_of_one_name_are_refused(folder: Path) -> None:
    (folder / "Heli.Inp").write_text("")
    assert refusal(folder) == ": Heli.Inp and heli.inp are both there, expected one heli.inp only."


def test_a_missing_file_is_named(folder: Path) -> None:
    (folder / "initials.inp").unlink()
    assert refusal(folder) == ": there is no initials.inp (where it starts)."


@pytest.mark.parametrize(
    ("file", "line", "written", "told"),
    [
        ("heli.inp", 5, "12,5x", "expected one number (auxiliary wheel carriage, mass: mass), found '5x' after them"),
        ("heli.inp", 5, "abc", "column 1: expected mass (auxiliary wheel carriage, mass) as a number [kg]"),
        ("heli.inp", 17, "1 2", "expected 3 numbers (auxiliary suspension, mounting point on the helicopter"),
        ("heli.inp", 17, "1 2 3 4", "found '4' after them"),
        ("heli.inp", 17, "1 nan 3", "column 2: expected y"),
        ("heli.inp", 17, "1 2 1e99", "finite and within 1e+15 of zero, found '1e99'"),
        (
            "heli.inp",
            32,
            "1 1 3",
            "column 3: expected left (type of suspension) as one of 1 = prismatic, 2 = swing_arm",
        ),
        ("heli.inp", 33, "1 0.5 1", "column 2: expected right (lock of the steering) as one of 1 = locked, 0 = free"),
        (
            "heli.inp",
            56,
            "8*0.1 7 6*0.1",
            "expected 16 numbers (first tire of the auxiliary station: x to C_z), found 15",
        ),
        ("heli.inp", 66, "33*1.0 2", "found '2' after them"),
        ("heli.inp", 1, "-5", "column 1: mass_kg = -5.0 is refused: it must be greater than 0"),
        ("heli.inp", 56, lambda s: s.replace(" 7 ", " 5 ", 1), "column 9: expected type (standard type designation)"),
        ("heli.inp", 66, lambda s: "0.0  " + s.split(" ", 1)[1], "column 1: stations.auxiliary.spring.x0_m = 0.0 is"),
        ("initials.inp", 2, "1 1 0 0", "line 2: start.orientation = (1.0, 1.0, 0.0, 0.0) is refused"),
        ("solution.inp", 1, "0 0.013", "solution is refused: end_s - start_s = 0.013 s must be a whole number of"),
        ("solution.inp", 1, "-1 2", "column 1: expected start (time span of the solution) as a number [s], at least 0"),
        ("solution.inp", 3, "1.5", "column 1: expected rows (rows of the solution kept in memory"),
        ("solution.inp", 5, "1", "column 1: expected roots (number of equations whose roots are wanted) as one of 0"),
        ("solution.inp", 6, "4", "as one of 1 = adams, 2 = gear, 3 = automatic, found '4'"),
        ("solution.inp", 8, "0", "line 8, column 1: solution.atol = 0.0 is refused"),
        ("prescribed.inp", 4, "7", "as one of 0 = off, 1 = roll, 2 = pitch, 3 = yaw, 4 = surge, 5 = sway, 6 = heave"),
        ("prescribed.inp", 2, "0 0 0.5", "line 2, column 3: claw.z_m = 0.5 is refused"),
    ],
)
def test_mistakes_are_told_by_place(
    folder: Path, file: str, line: int, written: Callable[[str], str] | str, told: str
) -> None:
    (folder / SIDECAR).unlink()
    edit(folder / file, line, written)
    text = refusal(folder)
    assert text.startswith(file)
    assert told in text
    if "solution is refused" not in text:
        assert text.startswith(f"{file}, line {line}")


def test_a_short_file_says_what_is_missing(folder: Path) -> None:
    lines = (folder / "heli.inp").read_text().splitlines()
    (folder / "heli.inp").write_text("\n".join(lines[:60]))
    told = "heli.inp: the file ends after 60 lines, expected 68; line 61 holds: second tire of the left station."
    assert refusal(folder) == told


def test_a_long_file_says_where_it_should_end(folder: Path) -> None:
    with (folder / "solution.inp").open("a") as file:
        file.write("\n12\n")
    assert refusal(folder) == "solution.inp, line 10: expected the end of the file after its 8 lines, found '12'."


def test_lines_are_counted_in_the_file_and_in_the_appendix(folder: Path) -> None:
    text = (folder / "solution.inp").read_text()
    (folder / "solution.inp").write_text("\n! time and solver\n" + text.replace("\n3  ", "\n9  ", 1))
    told = refusal(folder)
    assert "line 8 (line 6 of appendix A), column 1" in told


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        ("0 0 0\n1 0 0 0\n", "line 1: expected 4 numbers (time x y z), found 3"),
        ("0 0 0 0\n", "1 rows of numbers found, expected 2 or more of 4 columns"),
        ("0 0 0 0\n0 0 0 0\n", "line 2, column 1: expected a time after 0 s, that of the row before, found 0 s"),
        ("0 0 0 0\n1 0 x 0\n", "line 2, column 3: expected y (claw's position, ship axes, y) as a number [m]"),
        ("", "0 rows of numbers found"),
    ],
)
def test_mistakes_in_a_record(folder: Path, rows: str, told: str) -> None:
    edit(folder / "prescribed.inp", 1, "1")
    (folder / "rsd_pos.inp").write_text(rows)
    assert told in refusal(folder)


def test_a_deck_record_starts_at_zero(folder: Path) -> None:
    edit(folder / "prescribed.inp", 3, "1")
    rig.write_deck(folder / "shipmo.inp")
    text = (folder / "shipmo.inp").read_text().splitlines()
    (folder / "shipmo.inp").write_text("\n".join(text[20:]))
    assert "expected a first row at 0 s, where the clock starts, found 1 s" in refusal(folder)


def test_what_is_not_read_is_told(folder: Path) -> None:
    (folder / "rsd_pos.inp").write_text(rig.CLAW_ROWS)
    assert read_folder(folder).remarks == ("rsd_pos.inp is not read: prescribed.inp does not ask for it",)


def test_a_span_of_no_whole_steps_ends_with_the_last_one(folder: Path) -> None:
    (folder / SIDECAR).unlink()
    edit(folder / "solution.inp", 1, "0.1 0.25")
    reading = read_folder(folder)
    assert reading.case.solution.end_s == pytest.approx(0.24)
    assert reading.remarks == ("solution.inp line 1: the last row is at 0.24 s, the last whole step before the end",)
    write_case(reading.document, folder / "again")
    assert read(folder / "again").numbers == read(folder).numbers


def test_rounded_euler_parameters_are_normalised(folder: Path) -> None:
    (folder / SIDECAR).unlink()
    edit(folder / "initials.inp", 2, "0.9962 0 0.0872 0")
    edit(folder / "heli.inp", 24, "0.9999 0.01 0 0")
    reading = read_folder(folder)
    start = reading.document["start"]
    assert sum(e * e for e in start["orientation"]) == pytest.approx(1.0, abs=1e-15)
    assert start["orientation"][2] / start["orientation"][0] == pytest.approx(0.0872 / 0.9962)
    assert len(reading.remarks) == 3 and "norm 1.000009 are normalised" in reading.remarks[1]
    assert reading.remarks[2].startswith("initials.inp line 5 counts, not heli.inp line 24")  # 0.02 rad apart
    write_case(reading.document, folder / "again")
    assert read(folder / "again").numbers == read(folder).numbers
    edit(folder / "initials.inp", 2, "0.99 0 0.0872 0")
    assert "initials.inp, line 2: start.orientation" in refusal(folder)
