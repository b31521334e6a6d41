"""`ssmash run` and `ssmash convert`: output whole or none, peaks told, nothing half written."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.cases import run_case
from ssmash_gym.cli import INTERRUPTED, main
from ssmash_gym.document import write_yaml
from ssmash_gym.dynamics.layout import State
from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.simulation.recording import read_recording
from ssmash_gym.thesis_files import read_folder, verbs, write_case
from ssmash_gym.thesis_files.folder import SIDECAR
from ssmash_gym.thesis_files.outputs import NAMES
from tests.thesis_files import rig


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    start = {**rig.GIVEN, "velocity_mps": [0.0, 0.0, 1.0]}
    write_case(rig.document(start=start, changes={"probe.active": False}), tmp_path / "hop")
    return tmp_path / "hop"


def edit(path: Path, number: int, text: str) -> None:
    lines = path.read_text().splitlines()
    lines[number - 1] = text
    path.write_text("\n".join(lines) + "\n")


def test_a_run_writes_the_three_files_and_a_recording(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(folder / "solution.inp", 3, "4")
    assert main(["run", str(folder), "--solver", "engine"]) == 0
    out = folder / "out"
    assert sorted(path.name for path in out.iterdir()) == sorted(NAMES)
    state, aux = np.loadtxt(out / "state.out"), np.loadtxt(out / "aux.out")
    history = run_case(read_folder(folder).case)
    assert state.shape == (11, 35) and aux.shape == (11, 10)
    np.testing.assert_allclose(state[:, 0], np.arange(11) * 0.02, atol=1e-12)
    np.testing.assert_allclose(state[:, 1:], history.states[: State.Q26 + 4].T, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(state[0, 13:16], rig.GIVEN["position_m"])
    np.testing.assert_allclose(state[0, 3], 1.0)
    for column, name in ((1, "probe_fx"), (4, "auxiliary_tire_lateral_deflection"), (9, "left_vertical_load")):
        np.testing.assert_allclose(aux[:, column], history[name], rtol=1e-11, atol=1e-9)
    wall, iterations, prints = (float(line) for line in (out / "run.out").read_text().split())
    assert (iterations, prints) == (10.0, 3.0)  # eleven rows in blocks of four
    assert wall > 0.0
    frame, about = read_recording(out / "recording.parquet")
    assert frame.height == 11
    assert about["configuration"]["case"]["name"] == "hop"
    told = capsys.readouterr().out
    assert "case hop: 0 to 0.2 s, a row every 0.02 s, solver engine" in told
    assert "tire vertical load, kN" in told and "run time" in told


def test_a_run_of_a_bare_folder_tells_its_defaults(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / SIDECAR).unlink()
    assert main(["run", str(folder), "--solver", "engine", "--out", str(folder / "there")]) == 0
    told = capsys.readouterr().out
    assert "taken because no file says it:" in told
    assert "helicopter.surroundings.gravity_mps2 = 9.81 m/s2" in told
    assert sorted(path.name for path in (folder / "there").iterdir()) == sorted(NAMES)


@pytest.mark.parametrize(("number", "solver"), [(1, "adams"), (2, "gear"), (3, "automatic")])
def test_line_6_chooses_the_solver(folder: Path, number: int, solver: str) -> None:
    edit(folder / "solution.inp", 6, str(number))
    edit(folder / "solution.inp", 7, "1.0D-5")
    edit(folder / "solution.inp", 8, "1.0D-2")
    (folder / SIDECAR).unlink()
    solution = read_folder(folder).case.solution
    assert (solution.solver, solution.rtol, solution.atol) == (solver, 1e-5, pytest.approx(1e-7))


def test_solvers_of_the_file_agree_with_the_engine(folder: Path) -> None:
    """Peak load and position within what the pages promise of two integrators: 0.5 % and 5 mm."""
    source = read_folder(folder).case.changed({"solution.end_s": 0.3})
    engine = run_case(source)
    for solver in ("adams", "gear", "automatic"):
        other = run_case(source.changed({"solution.solver": solver}))
        assert other.largest("right_vertical_load") == pytest.approx(engine.largest("right_vertical_load"), rel=5e-3)
        np.testing.assert_allclose(other["position_z"], engine["position_z"], atol=5e-3)


def test_a_run_that_is_stopped_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = sorted(path.name for path in folder.iterdir())

    def stopped(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ssmash_gym.thesis_files.outputs._print", stopped)  # in the midst of writing
    assert main(["run", str(folder), "--solver", "engine"]) == INTERRUPTED
    assert sorted(path.name for path in folder.iterdir()) == before


def test_a_run_that_diverges_leaves_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(folder / "initials.inp", 8, "1e9 0 0")
    assert main(["run", str(folder), "--solver", "engine"]) == 1
    assert not (folder / "out").exists()
    told = capsys.readouterr().err
    assert str(folder) in told and "nothing is written" in told


def test_the_bar_follows_a_long_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shares: list[float] = []
    case = read_folder(folder).case.changed({"solution.end_s": 2.0})

    def watched(given: Any, progress: Any) -> Any:
        return run_case(given, lambda share: (shares.append(share), progress(share)))

    monkeypatch.setattr("ssmash_gym.cases.run_case", watched)
    verbs.ended(case, folder)
    assert shares and shares == sorted(shares) and 0.0 <= shares[0] <= shares[-1] <= 1.0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run", "nowhere/at/all"], "expected a folder of the thesis' files or a case file in YAML"),
        (["run", "{folder}", "--out", "{folder}/heli.inp"], "this is a file, expected a folder"),
        (["run", "{folder}", "--out", "{folder}/heli.inp/out"], "heli.inp/out: cannot be written"),
        (["run", "{folder}/none.yaml"], "cannot be read"),
        (["convert", "{folder}", "{folder}/case.txt"], "must end in .yaml, .yml, .json"),
        (["convert", "{folder}", "{folder}/no/case.yaml"], "there is no folder"),
        (["convert", "{folder}/case.yaml", "{folder}/other.yaml"], "cannot be read"),
    ],
)
def test_mistakes_at_the_command_line(
    words: list[str], told: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([word.format(folder=folder) for word in words]) == 1
    assert told in capsys.readouterr().err


def test_a_case_file_runs_as_its_folder_does(folder: Path, tmp_path: Path) -> None:
    case = tmp_path / "hop.yaml"
    assert main(["convert", str(folder), str(case)]) == 0
    assert main(["run", str(case)]) == 0
    assert main(["run", str(folder), "--solver", "engine"]) == 0
    one, other = tmp_path / "hop_out" / "state.out", folder / "out" / "state.out"
    assert one.read_bytes() == other.read_bytes()


def test_the_listing_names_what_goes_where(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", str(folder), str(tmp_path / "hop.yaml")]) == 0
    assert main(["convert", str(tmp_path / "hop.yaml"), str(tmp_path / "again")]) == 0
    told = capsys.readouterr().out
    assert "in beyond_thesis.yaml, for the files have no place:" in told
    assert "  helicopter.surroundings.gravity_mps2\n" in told
    assert "in another form in the files, as it was in beyond_thesis.yaml:" in told
    assert main(["convert", str(tmp_path / "hop.yaml"), str(tmp_path / "bare"), "--no-sidecar"]) == 1
    assert "the thesis' files alone cannot hold" in capsys.readouterr().err
    assert not (tmp_path / "bare").exists()


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("[seven]", "column 1: expected rows .* as an integer, at least 1, .* found 'seven'"),
        ("[-5]", "column 1: expected rows .* as an integer, at least 1, .* found '-5'"),
        ("[5, 6]", "expected one number .*, found 2"),
        ("5", "this is no line of solution.inp"),
    ],
)
def test_kept_lines_of_a_case_file_are_checked(row: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    text = write_yaml(rig.document()) + f"thesis_files: {{solution.inp: {{line_3: {row}}}}}\n"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigurationError, match=rf"case\.yaml: thesis_files\.solution\.inp\.line_3.*{told}"):
        verbs.convert(path, tmp_path / "folder")
    assert not (tmp_path / "folder").exists()


def test_convert_tells_warnings_as_lines(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = verbs.load

    def warned(given: Path) -> Any:
        warnings.warn("a wheel is odd", ConfigurationWarning, stacklevel=1)
        return whole(given)

    monkeypatch.setattr(verbs, "load", warned)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ConfigurationWarning)
        verbs.convert(folder, tmp_path / "case.yaml")
    assert "a wheel is odd" in capsys.readouterr().out.splitlines()
