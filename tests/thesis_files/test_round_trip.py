"""YAML to folder to YAML is the same document, folder to YAML to folder the same numbers."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from ssmash_gym.cases import case_document, case_from, load_case
from ssmash_gym.cli import main
from ssmash_gym.document import read_yaml
from ssmash_gym.thesis_files import read_case, read_folder, write_case
from ssmash_gym.thesis_files.folder import LINED, SIDECAR, read, texts
from ssmash_gym.thesis_files.run_layout import FILES
from tests.thesis_files import rig

MARK = {"origin": "assumed", "note": "heavier"}
PLAY = {"play_rad": 0.01, "stop_stiffness_Nmprad": 1e5, "stop_damping_Nmspr": 100.0}
few = settings(
    max_examples=12,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],  # a drawn case is small enough to be read as it is
)
pytestmark = pytest.mark.filterwarnings("ignore::ssmash_gym.errors.ConfigurationWarning")


def same_files(one: Path, other: Path) -> None:
    assert sorted(p.name for p in one.iterdir()) == sorted(p.name for p in other.iterdir())
    for path in one.iterdir():
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name


@few
@given(rig.documents())
def test_yaml_to_folder_to_yaml_is_identical(document: dict[str, Any]) -> None:
    wanted = case_document(case_from(document))
    with tempfile.TemporaryDirectory() as room:
        write_case(document, Path(room) / "one")
        found = read_case(Path(room) / "one")
        assert found == wanted
        assert list(found) == list(wanted)
        write_case(found, Path(room) / "two")
        same_files(Path(room) / "one", Path(room) / "two")


@few
@given(rig.documents(), st.lists(st.tuples(rig.numbers, rig.numbers, rig.numbers), min_size=9, max_size=9), st.data())
def test_folder_to_yaml_to_folder_keeps_every_number(document: dict[str, Any], odd: list[Any], data: Any) -> None:
    """Lines that are not used hold anything; a folder without a sidecar comes back with the same numbers."""
    with tempfile.TemporaryDirectory() as room:
        one, two = Path(room) / "one", Path(room) / "two"
        write_case(document, one)
        (one / SIDECAR).unlink()
        numbers = dict(read(one).numbers)
        heli, initials, solution, prescribed = (list(numbers[key]) for key in LINED)
        for i in range(3):
            kind, spring = heli[31][i], heli[61][i]
            if kind == 1.0:
                heli[25 + i], heli[28 + i] = odd[i], odd[3 + i]
                if data.draw(st.booleans()):  # the orientation of a steered strut, said by initials.inp alone
                    heli[22 + i], initials[3 + i] = (0.0,) * 4, data.draw(rig.steered)
            unused = 65 + i if spring == 1.0 else 62 + i
            heli[unused] = tuple(data.draw(rig.numbers) for _ in heli[unused])
        solution[2] = (float(data.draw(st.integers(1, 10_000))),)
        solution[3] = (data.draw(st.sampled_from([1.0, -1.0])),)
        solution[7] = (data.draw(st.floats(1e-6, 100.0)),)  # times rtol, at most 0.1
        if prescribed[3] == (0.0,):
            prescribed[4] = odd[6][:2]
        changed = zip(LINED, (heli, initials, solution, prescribed), strict=True)
        numbers |= {key: tuple(lines) for key, lines in changed}
        for key, text in texts(numbers).items():
            (one / FILES[key].name).write_text(text)
        found = read_case(one)
        write_case(found, two)
        again = read(two).numbers
        for key in LINED:
            assert again[key] == numbers[key], key
        assert read_case(two) == found


@pytest.mark.parametrize(
    "changes",
    [
        {"start": {"type": "settled", "yaw_deg": 9.0}},
        {"start": {"type": "drop", "cg_height_m": 2.7, "pitch_deg": 3.0}, "helicopter": "generic_tricycle"},
        {"claw": {"type": "still"}},
        {
            "claw": {
                "type": "points",
                "time_s": [0.0, 0.1, 0.2],
                "x_m": [0.0, 0.1, 0.2],
                "y_m": [0.0, 0.0, 0.1],
                "noise": {"rms_m": 0.001},
            }
        },
        {"deck": {"type": "irregular", "roll": {"rms_deg": 2.0, "period_s": 9.0}}, "seed": 4},
        {"solution": {"end_s": 0.0, "equilibrium": True}},
        {"changes": {"stations.auxiliary.steering": "locked", "stations.auxiliary.steer_play": PLAY}},
        {"helicopter": "generic_tricycle", "changes": {"tire_model": "linear", "mass_kg": {"value": 9e3, **MARK}}},
    ],
    ids=["settled", "drop", "probe", "points", "irregular", "equilibrium", "play", "linear"],
)
def test_what_becomes_numbers_comes_back_as_it_was(changes: dict[str, Any], tmp_path: Path) -> None:
    case = rig.case(**changes)
    write_case(case, tmp_path / "one")
    assert read_case(tmp_path / "one") == case_document(case)
    write_case(read_case(tmp_path / "one"), tmp_path / "two")
    same_files(tmp_path / "one", tmp_path / "two")


def test_records_are_named_from_where_the_case_lies(tmp_path: Path) -> None:
    """A case with its own records: to a folder elsewhere and back beside them, the same text."""
    (tmp_path / "case").mkdir()
    rig.write_deck(tmp_path / "case" / "roll.txt")
    (tmp_path / "case" / "claw.txt").write_text(rig.CLAW_ROWS)
    first, again = tmp_path / "case" / "first.yaml", tmp_path / "case" / "again.yaml"
    document = rig.document(
        helicopter="seahawk_like",
        deck={"type": "file", "path": "roll.txt", "detrend": True, "rates": "euler"},
        claw={"type": "file", "path": "claw.txt", "noise": {"rms_m": 0.002}},
    )
    from ssmash_gym.document import write_yaml

    first.write_text(write_yaml(document))
    assert main(["convert", str(first), str(tmp_path / "files")]) == 0
    assert main(["convert", str(tmp_path / "files"), str(again)]) == 0
    one = case_document(case_from(read_yaml(first.read_text(), "first"), folder=tmp_path / "case"))
    two = case_document(case_from(read_yaml(again.read_text(), "again"), folder=tmp_path / "case"))
    assert one == two
    # Without the original records the folder's own are named.
    (tmp_path / "case" / "roll.txt").unlink()
    elsewhere = tmp_path / "elsewhere.yaml"
    assert main(["convert", str(tmp_path / "files"), str(elsewhere)]) == 0
    named = read_yaml(elsewhere.read_text(), "elsewhere")
    assert named["deck"]["path"] == "files/shipmo.inp"
    assert named["helicopter"] == "seahawk_like"


def test_numbers_that_only_the_files_have_survive_a_case_file(tmp_path: Path) -> None:
    write_case(rig.document(), tmp_path / "one")
    path = tmp_path / "one" / "solution.inp"
    lines = path.read_text().splitlines()
    lines[2], lines[3] = "25", "-1"
    path.write_text("\n".join(lines))
    assert main(["convert", str(tmp_path / "one"), str(tmp_path / "case.yaml")]) == 0
    assert read_yaml((tmp_path / "case.yaml").read_text(), "case")["thesis_files"] == {
        "solution.inp": {"line_3": [25.0], "line_4": [-1.0]}
    }
    assert main(["convert", str(tmp_path / "case.yaml"), str(tmp_path / "two")]) == 0
    assert read(tmp_path / "two").numbers == read(tmp_path / "one").numbers


def test_a_kept_number_does_not_stand_against_a_changed_case(tmp_path: Path) -> None:
    write_case(rig.document(), tmp_path / "one")
    path = tmp_path / "one" / "solution.inp"
    lines = path.read_text().splitlines()
    lines[7] = "0.0123"  # times line 7: an absolute tolerance that has no shorter form
    path.write_text("\n".join(lines))
    reading = read_folder(tmp_path / "one")
    changed = {**reading.document, "thesis_files": {"solution.inp": {"line_8": [0.0123]}}}
    changed["solution"] = {**changed["solution"], "atol": 5.0e-9}
    write_case(changed, tmp_path / "two")
    assert read_case(tmp_path / "two")["solution"]["atol"] == 5.0e-9


@pytest.mark.parametrize("name", ["1d", "2b"])
def test_a_validation_manoeuvre_comes_back_as_it_was(name: str, tmp_path: Path) -> None:
    """A seaway and a claw through points: written as records, read as what they were."""
    case = load_case(name)
    written = write_case(case, tmp_path / name)
    assert {"1d": "shipmo.inp", "2b": "rsd_pos.inp"}[name] in {path.name for path in written.files}
    assert read_case(tmp_path / name) == case_document(case)
