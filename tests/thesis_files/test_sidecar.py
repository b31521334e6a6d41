"""What the files cannot hold stands beside them, is named, and gives way to a file that has been edited."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from ssmash_gym.document import read_yaml
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.thesis_files import read_case, read_folder, write_case
from ssmash_gym.thesis_files.defaults import HELICOPTER
from ssmash_gym.thesis_files.folder import SIDECAR
from ssmash_gym.thesis_files.paths import MISSING, expand, get
from ssmash_gym.vehicle import load_helicopter
from tests.thesis_files import rig


def edit(path: Path, number: int, text: str) -> None:
    lines = path.read_text().splitlines()
    lines[number - 1] = text
    path.write_text("\n".join(lines) + "\n")


def sidecar(folder: Path) -> dict[str, Any]:
    return read_yaml((folder / SIDECAR).read_text(), SIDECAR)


def test_everything_beyond_is_named(tmp_path: Path) -> None:
    model = {"friction": "independent"}
    patch = {"x_m": [0.0, 1.0], "y_m": [0.0, 1.0], "friction_factor": 0.3}
    changes = {"stations.right.steer_friction_m": 0.02}
    case = rig.case(name="jump", model=model, patch=patch, held=["u9"], ramp_s=1.0, changes=changes, title="a hop")
    written = write_case(case, tmp_path / "hop")
    assert {"model.friction", "patch", "held", "ramp_s"} <= set(written.beyond)
    assert {"helicopter.surroundings.gravity_mps2", "helicopter.stations.*.steer_decay_spr"} <= set(written.beyond)
    assert "helicopter.stations.right.steer_friction_m" in written.instead
    assert "title" in written.words
    told = sidecar(tmp_path / "hop")
    assert set(told["beyond"]) == {*written.beyond, "name", "title", "helicopter.name", "helicopter.description"}
    assert set(told["instead"]) == set(written.instead)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"model": {"friction": "independent"}}, "model.friction"),
        ({"held": ["u9"]}, "held"),
        ({"ramp_s": 1.0}, "ramp_s"),
        ({"changes": {"stations.right.steer_friction_m": 0.02}}, "helicopter.stations.right.steer_friction_m"),
        ({"changes": {"surroundings.air_density_kgpm3": 1.0}}, "helicopter.surroundings.air_density_kgpm3"),
        ({"deck": {"type": "fixed", "z_m": 1.0}}, "deck.z_m"),
        ({"solution": {"end_s": 0.0, "equilibrium": True}}, "solution.equilibrium"),
    ],
)
def test_without_a_sidecar_what_would_be_lost_is_refused(changes: dict[str, Any], named: str, tmp_path: Path) -> None:
    defaults = {default.path: default for default in HELICOPTER}
    base = rig.document()
    h = base["helicopter"]
    write_case(base, tmp_path / "base")
    (tmp_path / "base" / SIDECAR).unlink()
    bare = read_case(tmp_path / "base")["helicopter"]  # the tricycle with every default
    plain = {path: get(bare, path) for path in (p for d in defaults for p in expand(h, d))}
    sober = {path: value["value"] if isinstance(value, dict) else value for path, value in plain.items()}
    base["changes"] = sober
    written = write_case(base, tmp_path / "alone", sidecar=False)
    assert SIDECAR not in {path.name for path in written.files}
    assert read_case(tmp_path / "alone")["solution"]["end_s"] == 0.2
    case = {**base, **changes, "changes": {**sober, **changes.get("changes", {})}}
    with pytest.raises(ConfigurationError, match=f"alone cannot hold {named.replace('*', '.')};"):
        write_case(case, tmp_path / "refused", sidecar=False)
    assert not (tmp_path / "refused").exists()


def test_an_edited_file_wins(tmp_path: Path) -> None:
    """Mass, spring slope and start are edited: the numbers count, their marks and former forms do not."""
    folder = tmp_path / "hop"
    write_case(rig.case(helicopter="generic_tricycle", start={"type": "drop", "cg_height_m": 2.7}), folder)
    assert read_case(folder)["start"]["type"] == "drop"
    assert read_case(folder)["helicopter"] == "generic_tricycle"
    edit(folder / "heli.inp", 1, "9000.0")
    edit(folder / "initials.inp", 1, "0.0 0.0 -2.9")
    reading = read_folder(folder)
    h = reading.document["helicopter"]
    assert h["mass_kg"] == 9000.0
    assert h["inertia_kgm2"]["origin"] == "assumed"  # not edited: the mark stands
    assert reading.document["start"]["position_m"] == [0.0, 0.0, -2.9]
    told = " ".join(reading.remarks)
    assert "start is taken from the files" in told
    assert "the marks of helicopter.mass_kg are dropped" in told
    assert "they differ from what beyond_thesis.yaml calls it by" in told


def test_an_edited_sidecar_counts(tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    text = (folder / SIDECAR).read_text()
    write_text(folder / SIDECAR, text.replace("gravity_mps2: 9.81", "gravity_mps2: 9.7"))
    assert read_folder(folder).case.vehicle.surroundings.gravity_mps2 == 9.7


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("beyond: 3\n", "beyond = 3 is refused: it must be a mapping"),
        ("beyound: {}\n", "there is no part beyound; allowed are beyond, instead, marks, written_as"),
        ("beyond: {helicopter.weight: 3}\n", "beyond.helicopter.weight is refused: this case has no such key"),
        ("instead: {start: 3}\n", "instead.start = 3 is refused: it must have the keys file and case"),
        ("- 1\n", "the file must hold a mapping"),
        ("beyond: {\n", "this is not valid YAML"),
        ("beyond: {ramp_s: -1}\n", "ramp_s = -1 is refused"),
        ("marks: {helicopter.mass_kg: {value: 1, origin: nowhere}}\n", "origin = 'nowhere' is refused"),
    ],
)
def test_a_malformed_sidecar_is_told(text: str, told: str, tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    (folder / SIDECAR).write_text(text)
    with pytest.raises(ConfigurationError) as caught:
        read_folder(folder)
    assert told in str(caught.value) and str(folder) in str(caught.value)


SAMPLE = Path(__file__).parents[2] / "configs" / "thesis_case"


@pytest.mark.parametrize(
    ("file", "edits", "gone", "path", "value"),
    [
        ("prescribed.inp", {3: "2", 4: "1"}, "deck.rates", "deck.type", "sinusoid"),
        (
            "heli.inp",
            {62: "1 2 2", 63: "1e6 1e4"},
            "helicopter.stations.auxiliary.spring.e1_Npm",
            "helicopter.stations.auxiliary.spring.type",
            "linear_strut",
        ),
        (
            "heli.inp",
            {57: "16*0."},
            "helicopter.stations.auxiliary.tires.1.position_m",
            "helicopter.stations.auxiliary.tires.1",
            MISSING,
        ),
    ],
)
def test_what_the_files_no_longer_have_is_dropped(
    file: str, edits: dict[int, str], gone: str, path: str, value: Any, tmp_path: Path
) -> None:
    folder = tmp_path / "case"
    shutil.copytree(SAMPLE, folder)
    assert not any("dropped from" in remark for remark in read_folder(folder).remarks)
    for number, text in edits.items():
        edit(folder / file, number, text)
    reading = read_folder(folder)
    assert get(reading.document, path) == value
    assert any("dropped from" in remark and gone in remark for remark in reading.remarks)


@pytest.mark.parametrize(
    "path",
    [
        "helicopter.mass_kg",
        "helicopter.inertia_kgm2.0",
        "helicopter.stations.right",
        "helicopter.stations.*.tires.*.pressure_Pa",
        "deck.type",
        "solution",
        "solution.rtol",
        "start",
    ],
)
def test_beyond_does_not_override_the_files(path: str, tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    (folder / SIDECAR).write_text(f"beyond: {{{path}: 6000}}\n")
    with pytest.raises(ConfigurationError, match="is refused: the files hold it; change it there"):
        read_folder(folder)


@pytest.mark.parametrize("line", [23, 24, 25])
def test_an_orientation_that_does_not_count_is_told(line: int, tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    told = f"initials.inp line {line - 19} counts, not heli.inp line {line}"
    assert not any(told in remark for remark in read_folder(folder).remarks)
    edit(folder / "heli.inp", line, "0.9998000066665778 0.0 0.01999866669333308 0.0")
    assert any(told in remark for remark in read_folder(folder).remarks)
    edit(folder / "heli.inp", line, "0.9998000066665778 0.0 0.0 0.01999866669333308")  # a turn about o_z
    assert not any(told in remark for remark in read_folder(folder).remarks)


def test_defaults_are_taken_and_told(tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    assert read_folder(folder).defaults == ()
    (folder / SIDECAR).unlink()
    reading = read_folder(folder)
    for default in HELICOPTER:
        assert any(line.startswith(f"helicopter.{default.path} = {default.shown}") for line in reading.defaults)
    marks = reading.case.vehicle.marks
    assert marks["surroundings.gravity_mps2"].origin == "assumed"
    assert "mass_kg" not in marks  # it stands in the file


def test_the_default_stroke_fits_the_catalogue(tmp_path: Path) -> None:
    """Both helicopters can be read from their bare files, with strokes near their own."""
    for name in ("generic_tricycle", "seahawk_like"):
        folder = tmp_path / name
        write_case(rig.case(helicopter=name), folder)
        (folder / SIDECAR).unlink()
        found, own = read_folder(folder).case.vehicle, load_helicopter(name)
        for one, other in zip(found.station_tuple, own.station_tuple, strict=True):
            assert one.end_stop.stroke_m == pytest.approx(other.end_stop.stroke_m, rel=0.35)


def test_existing_files_are_not_replaced_unasked(tmp_path: Path) -> None:
    folder = tmp_path / "hop"
    write_case(rig.document(), folder)
    with pytest.raises(ConfigurationError, match="is there already; give another folder"):
        write_case(rig.document(), folder)
    write_case(rig.document(name="again"), folder, overwrite=True)
    assert read_case(folder)["name"] == "again"
    (folder / "heli.inp").rename(folder / "HELI.INP")
    with pytest.raises(ConfigurationError, match="under another name"):
        write_case(rig.document(), folder, overwrite=True)


def test_numbers_too_large_for_the_files_are_not_written(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"1e\+30, for line 66 of heli.inp, is refused"):
        write_case(rig.case(changes={"stations.auxiliary.spring.relief_2_N": 1e30}), tmp_path / "hop")
    assert not (tmp_path / "hop").exists()
