"""300 mutated input files: each ends in one clear sentence or in a valid run, none in anything else."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ssmash_gym.cli import main
from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.thesis_files import verbs, write_case
from ssmash_gym.thesis_files.folder import SIDECAR
from ssmash_gym.thesis_files.outputs import NAMES
from tests.thesis_files import rig

COUNT = 300
GROUPS = 10
FILES = ("heli.inp", "initials.inp", "solution.inp", "prescribed.inp", "rsd_pos.inp", "shipmo.inp", SIDECAR)
SHARE = (0.42, 0.13, 0.13, 0.12, 0.08, 0.08, 0.04)
WORDS = (
    "NaN",
    "inf",
    "-1",
    "0",
    "1e308",
    "-1e12",
    "1e12",
    "1e-300",
    "abc",
    "1.0D+02",
    "2",
    "7",
    "0.5",
    "3*1",
    "½",
    "-",
)
Mutation = Callable[[list[str], np.random.Generator], list[str]]


def one_line(lines: list[str], rng: np.random.Generator) -> int:
    return int(rng.integers(len(lines)))


def dropped(lines: list[str], rng: np.random.Generator) -> list[str]:
    k = one_line(lines, rng)
    return lines[:k] + lines[k + 1 :]


def doubled(lines: list[str], rng: np.random.Generator) -> list[str]:
    k = one_line(lines, rng)
    return lines[: k + 1] + lines[k:]


def swapped(lines: list[str], rng: np.random.Generator) -> list[str]:
    a, b = one_line(lines, rng), one_line(lines, rng)
    changed = list(lines)
    changed[a], changed[b] = changed[b], changed[a]
    return changed


def other_word(lines: list[str], rng: np.random.Generator) -> list[str]:
    k = one_line(lines, rng)
    words = lines[k].split("!")[0].split() or ["x"]
    words[int(rng.integers(len(words)))] = str(rng.choice(WORDS))
    return [*lines[:k], " ".join(words), *lines[k + 1 :]]


def scaled(lines: list[str], rng: np.random.Generator) -> list[str]:
    """A number that is still one: of another sign or size."""
    k = one_line(lines, rng)
    words = lines[k].split("!")[0].split() or ["x"]
    j = int(rng.integers(len(words)))
    try:
        words[j] = repr(float(words[j]) * float(rng.choice([-1.0, 0.5, 2.0, 10.0, 1e3, 1e-3, 1e9])))
    except ValueError:
        words[j] = "1.5"
    return [*lines[:k], " ".join(words), *lines[k + 1 :]]


def column_lost(lines: list[str], rng: np.random.Generator) -> list[str]:
    k = one_line(lines, rng)
    words = lines[k].split("!")[0].split()
    return [*lines[:k], " ".join(words[:-1]), *lines[k + 1 :]]


def column_more(lines: list[str], rng: np.random.Generator) -> list[str]:
    k = one_line(lines, rng)
    return [*lines[:k], "1.0 " + lines[k], *lines[k + 1 :]]


def cut(lines: list[str], rng: np.random.Generator) -> list[str]:
    return lines[: one_line(lines, rng)]


def emptied(lines: list[str], rng: np.random.Generator) -> list[str]:
    return []


def clothed(lines: list[str], rng: np.random.Generator) -> list[str]:
    """Harmless: tabs, blank lines, comments, Fortran exponents."""
    k = one_line(lines, rng)
    return [*lines[:k], "", "# nothing", "\t" + lines[k].replace("e-", "D-"), *lines[k + 1 :]]


def torn(lines: list[str], rng: np.random.Generator) -> list[str]:
    text = list("\n".join(lines))
    for _ in range(int(rng.integers(1, 6))):
        text[int(rng.integers(len(text)))] = chr(int(rng.integers(1, 255)))
    return "".join(text).split("\n")


MUTATIONS: tuple[Mutation, ...] = (
    dropped, doubled, swapped, other_word, other_word, scaled, scaled, scaled, column_lost, column_more, cut, emptied,
    clothed, torn,
)  # fmt: skip


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all seven files, near rest on a rolling deck."""
    room = tmp_path_factory.mktemp("sound")
    rig.write_deck(room / "roll.txt")
    (room / "claw.txt").write_text(rig.CLAW_ROWS)
    changes = {"probe.active": False}
    deck = {"type": "file", "path": str(room / "roll.txt"), "detrend": False}
    claw = {"type": "file", "path": str(room / "claw.txt")}
    start = {**rig.GIVEN, "position_m": [0.0, 0.0, -2.45]}
    write_case(rig.document(deck=deck, claw=claw, start=start, changes=changes), room / "case")
    return room / "case"


def mutate(folder: Path, number: int) -> str:
    """Change one file of a folder; the same number makes the same change."""
    rng = np.random.default_rng(number)
    path = folder / str(rng.choice(FILES, p=np.array(SHARE) / sum(SHARE)))
    if rng.random() < 0.04:
        path.write_bytes(rng.bytes(400))
        return f"{path.name} binary"
    mutation = MUTATIONS[int(rng.integers(len(MUTATIONS)))]
    if path.name != SIDECAR and number % 4:
        (folder / SIDECAR).unlink()  # most folders have none
    lines = path.read_text().splitlines()
    path.write_text("\n".join(mutation(lines, rng)) + "\n", encoding="utf-8")
    return f"{path.name} {mutation.__name__}"


@pytest.mark.parametrize("group", range(GROUPS))
def test_every_mutated_folder_ends_well(group: int, sound: Path, tmp_path: Path) -> None:
    accepted = 0
    for number in range(group, COUNT, GROUPS):
        folder = tmp_path / f"m{number}"
        shutil.copytree(sound, folder)
        what = mutate(folder, number)
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConfigurationWarning)
                source = verbs.load(folder)
                solution = source.case.solution
                short = {"solution.end_s": solution.start_s + solution.output_step_s, "solution.solver": "engine"}
                if solution.end_s - solution.start_s <= 1.0 and solution.output_step_s <= 0.1:
                    short.pop("solution.end_s")
                assert solution.output_step_s <= 10.0, what  # else the test would take long
                history = verbs.ended(source.case.changed(short), folder)
        except ConfigurationError as refused:
            text = str(refused)
            assert "\n" not in text, what
            assert str(folder) in text, f"{what}: {text}"
        else:
            accepted += 1
            assert np.isfinite(history.states).all() and np.isfinite(history.outputs).all(), what
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == before, what
        shutil.rmtree(folder)
    assert 2 <= accepted <= COUNT // GROUPS - 2  # neither all harmless nor all refused


@pytest.mark.parametrize("number", range(0, 30, 3))
def test_the_command_leaves_all_or_nothing(number: int, sound: Path, tmp_path: Path) -> None:
    folder = tmp_path / "m"
    shutil.copytree(sound, folder)
    mutate(folder, number)
    status = main(["run", str(folder), "--solver", "engine"])
    found = sorted(path.name for path in (folder / "out").iterdir()) if (folder / "out").exists() else None
    assert (status, found) in ((0, sorted(NAMES)), (1, None))
