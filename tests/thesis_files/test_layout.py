"""The tables are those of appendix A of Léveillé (2013), and agree with the description's own citations."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import State
from ssmash_gym.simulation.telemetry import CHANNELS
from ssmash_gym.thesis_files import conditions
from ssmash_gym.thesis_files.heli_layout import HELI
from ssmash_gym.thesis_files.helicopter import unsteered
from ssmash_gym.thesis_files.layout import Table
from ssmash_gym.thesis_files.output_layout import AUX, RUN, STATE, state_row
from ssmash_gym.thesis_files.page import BEGIN, END, tables
from ssmash_gym.thesis_files.paths import MISSING, expand, get
from ssmash_gym.thesis_files.run_layout import FILES
from ssmash_gym.vehicle import Station, Tire
from ssmash_gym.vehicle.oleo import GasOleo
from ssmash_gym.vehicle.probe import Probe
from tests.thesis_files import rig

PAGE = Path(__file__).parents[2] / "docs" / "guide" / "thesis_files.md"


def test_numbers_of_lines_and_columns() -> None:
    lines = {key: file.content for key, file in FILES.items() if not isinstance(file.content, Table)}
    assert {key: [line.number for line in content] for key, content in lines.items()} == {
        "heli": list(range(1, 69)),
        "initials": list(range(1, 11)),
        "solution": list(range(1, 9)),
        "prescribed": list(range(1, 7)),
    }
    tables_ = {key: len(file.content.columns) for key, file in FILES.items() if isinstance(file.content, Table)}
    assert tables_ == {"claw": 4, "deck": 16}
    assert [len(line.columns) for line in HELI[55:61]] == [16] * 6
    assert [len(line.columns) for line in HELI[65:68]] == [33] * 3
    assert (len(RUN), len(STATE), len(AUX)) == (3, 35, 10)


def test_every_column_of_heli_has_its_value_in_the_description() -> None:
    helicopter: dict[str, Any] = {**rig.plain_helicopter("generic_tricycle")}
    arm: dict[str, Any] = {**rig.plain_helicopter("seahawk_like")}
    for line in HELI:
        for column in line.columns:
            for path in expand(helicopter, column.path):
                known = get(helicopter, path) is not MISSING or path.endswith(("spring.stiffness_Npm", "damping_Nspm"))
                assert known or get(arm, path.replace("auxiliary", "right")) is not MISSING, path


@pytest.mark.parametrize(
    ("part", "prefix", "word"),
    [(Tire, "stations.auxiliary.tires.0", "column"), (GasOleo, "stations.auxiliary.spring", "column")],
)
def test_columns_are_those_that_the_description_cites(part: Any, prefix: str, word: str) -> None:
    line = HELI[55] if part is Tire else HELI[65]
    order = {column.path.removeprefix(prefix + ".").split(".")[0]: k for k, column in enumerate(line.columns, start=1)}
    cited = {
        name: re.search(rf"{word}s? (\d+)(?:-(\d+))?", str(f.description)) for name, f in part.model_fields.items()
    }
    for name, found in cited.items():
        if found:
            assert order[name] == int(found[2] or found[1]), name
    assert {name for name, found in cited.items() if found} == set(order)


@pytest.mark.parametrize(("part", "prefix"), [(Probe, "probe"), (Station, "stations.auxiliary")])
def test_lines_are_those_that_the_description_cites(part: Any, prefix: str) -> None:
    """The first line that a field's description cites is where its first value stands."""
    checked = 0
    for name, field in part.model_fields.items():
        found = re.search(r"lines? (\d+)", str(field.description))
        if not found or name in ("tires", "spring"):
            continue
        paths = [
            line.number
            for line in HELI
            for column in line.columns
            if (column.path.replace("*", "auxiliary") + ".").startswith(f"{prefix}.{name}.")
        ]
        assert paths[0] == int(found[1]), name
        checked += 1
    assert checked >= 10


def test_state_out_is_time_speeds_and_coordinates() -> None:
    assert [state_row(column) for column in STATE[1:]] == list(range(State.U7, State.Q26 + 4))
    assert [column.name for column in STATE[1:13]] == [f"u{k}" for k in range(7, 19)]
    assert [column.name for column in STATE[13:]] == [f"q{k}" for k in range(8, 30)]


def test_aux_out_shows_telemetry() -> None:
    assert all(column.path in CHANNELS for column in AUX[1:])
    assert [CHANNELS[column.path].unit for column in AUX[1:]] == ["N"] * 3 + ["m"] * 3 + ["N"] * 3


def test_the_page_shows_the_tables() -> None:
    """`python -m ssmash_gym.thesis_files.page` writes them there."""
    text = PAGE.read_text(encoding="utf-8")
    assert text.count(BEGIN) == 1 and text.count(END) == 1
    assert text[text.index(BEGIN) : text.index(END) + len(END)] == tables()


@pytest.mark.parametrize(
    ("number", "dof"), [(1, "roll"), (2, "pitch"), (3, "yaw"), (4, "surge"), (5, "sway"), (6, "heave")]
)
def test_a_sinusoid_moves_about_the_orientation_of_line_6(number: int, dof: str) -> None:
    rows = ((2.0,), (0.0, 0.0, 0.0), (2.0,), (float(number),), (1.5, 8.0), (1.0, 2.0, 3.0))
    from ssmash_gym.ship.config import parse_motion

    motion = parse_motion(conditions.deck(rows, "")).realise(np.random.default_rng(0))
    at = motion.signal(np.array([0.0, 2.0])).position  # a quarter of the period later: the amplitude
    channel = ("surge", "sway", "heave", "roll", "pitch", "yaw").index(dof)
    mean = np.array([0.0, 0.0, 0.0, *np.radians([1.0, 2.0, 3.0])])
    amplitude = np.radians(1.5) if number <= 3 else 1.5
    np.testing.assert_allclose(at[0], mean, atol=1e-12)
    np.testing.assert_allclose(at[1] - mean, amplitude * np.eye(6)[channel], atol=1e-12)


def test_a_steered_strut_without_its_steer_angle() -> None:
    from ssmash_gym.vehicle.geometry import rotation

    tilt = np.array([np.cos(0.1), 0.0, np.sin(0.1), 0.0])  # about y by 0.2 rad
    steer = np.array([np.cos(0.4), 0.0, 0.0, np.sin(0.4)])  # about its own z by 0.8 rad
    a0, b0 = tilt[0], steer[0]
    a, b = tilt[1:], steer[1:]
    both = np.array([a0 * b0 - a @ b, *(a0 * b + b0 * a + np.cross(a, b))])
    np.testing.assert_allclose(rotation(tilt) @ rotation(steer), rotation(both), atol=1e-12)
    np.testing.assert_allclose(unsteered(both.tolist()), tilt, atol=1e-12)
