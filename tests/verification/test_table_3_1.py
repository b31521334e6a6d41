"""The generic tricycle against the verification trials of Léveillé 2013, Table 3.1.

Tolerances. The table prints loads to 1 N and angles to 0.001 deg, and the thesis' parameters are not public: the
catalogue's set was identified from the table with the lever arm as (2.161) prints it, while the model uses the loaded
radius (docs/errata.md), so loads are asked for within 1 %, heights within 5 mm, pitch within 0.05 deg. What does not
depend on the parameters (sums, the pull of the slope) is asked for to the table's own rounding. Static cases are
settled, for they are equilibria: a simulation creeps towards them as long as the oleos' friction is in motion.
"""

from __future__ import annotations

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import STATION_ROWS, STATIONS, Par, Sta, State
from ssmash_gym.ship import Fixed
from ssmash_gym.simulation.batch import Batch
from ssmash_gym.vehicle import Helicopter, load_helicopter, with_changes

CG_SHIFT_M = 0.49872  # case 3 prints none; identified with the set
WEIGHT_KN = 102.5145  # 10 450 kg at 9.81 m/s2


@pytest.fixture(scope="module")
def tricycle() -> Helicopter:
    return load_helicopter("generic_tricycle")


def constrained(helicopter: Helicopter, *, rolling: bool = False, probe: bool = False) -> Batch:
    """All steering and tire rotations constrained, no wind, probe inactive, unless told otherwise."""
    batch = Batch(helicopter, 1)
    batch.parameters[Par.PROBE_ACTIVE] = float(probe)
    for i in range(STATIONS):
        batch.parameters[Par.STATION + i * STATION_ROWS + Sta.ROLL_LOCK] = float(not rolling)
        batch.parameters[Par.LOCK + State.U14 + 2 * i] = 1.0
    return batch


def settled(batch: Batch, **ship_deg: float) -> dict[str, float]:
    """Equilibrium on the deck at rest in this attitude: loads in kN, angles in degrees, lengths in m."""
    batch.set_motion([Fixed(**ship_deg).bake(1.0, batch.timing.node_spacing_s)])
    assert batch.settle()[0] < 1e-6
    read = batch.evaluate()
    loads = {name: 1e-3 * read[f"{wheel}_vertical_load"][0] for name, wheel in
             (("nose", "auxiliary"), ("right", "right"), ("left", "left"))}  # fmt: skip
    angles = {name: np.rad2deg(read[name][0]) for name in ("roll", "pitch", "yaw")}
    places = {name: batch.state[row, 0] for name, row in (("x", State.Q8), ("y", State.Q9), ("z", State.Q10))}
    probe = {"fx": 1e-3 * read["probe_fx"][0], "fy": 1e-3 * read["probe_fy"][0]}
    return {**loads, **angles, **places, **probe, "sum": sum(loads.values())}


def within_one_percent(got: dict[str, float], **table: float) -> None:
    for name, value in table.items():
        assert got[name] == pytest.approx(value, rel=0.01), name


def test_the_drop_settles_where_the_thesis_does(tricycle: Helicopter) -> None:
    """Section 3.2.1: from a c.g. height of 2.7 m, about 0.2 m clear, to the reference state of Table 3.1."""
    batch = constrained(tricycle)
    batch.state[State.Q10] = -2.7
    first = batch.advance()
    loads = [first.peak_max(f"{wheel}_vertical_load")[0] for wheel in ("auxiliary", "right", "left")]
    assert max(loads) == 0.0  # in the air
    peak = max(batch.advance().peak_max("pitch")[0] for _ in range(59))
    assert 0.6 < np.rad2deg(peak) < 1.5  # it rocks: 0.89 deg with the reference's damping, 1.45 with ten times that
    assert batch.state[State.Q10, 0] == pytest.approx(-2.292, abs=0.005)
    assert np.rad2deg(batch.telemetry["pitch"][0]) == pytest.approx(0.436, abs=0.05)
    assert abs(np.rad2deg(batch.telemetry["roll"][0])) < 1e-6


def test_case_1_reference_state(tricycle: Helicopter) -> None:
    got = settled(constrained(tricycle))
    within_one_percent(got, nose=34.999, right=33.758, left=33.758)
    assert got["sum"] == pytest.approx(102.514, abs=0.001)
    assert got["z"] == pytest.approx(-2.292, abs=0.005)
    assert got["pitch"] == pytest.approx(0.436, abs=0.05)


def test_case_2_a_thousand_kilograms_more(tricycle: Helicopter) -> None:
    got = settled(constrained(with_changes(tricycle, {"mass_kg": tricycle.mass_kg + 1000.0})))
    within_one_percent(got, nose=38.338, right=36.993, left=36.993)
    assert got["sum"] == pytest.approx(112.324, abs=0.001)
    assert got["z"] == pytest.approx(-2.272, abs=0.005)


def test_case_3_centre_of_gravity_forward(tricycle: Helicopter) -> None:
    got = settled(constrained(with_changes(tricycle, {"cg_offset_m": [CG_SHIFT_M, 0.0, 0.0]})))
    within_one_percent(got, nose=44.000, right=29.257, left=29.257)
    assert got["sum"] == pytest.approx(102.514, abs=0.001)
    assert got["pitch"] == pytest.approx(-0.354, abs=0.05)


def test_case_4_ship_pitch(tricycle: Helicopter) -> None:
    """The table's right load of 34.475 is a misprint of 35.475: the sum of 102.124 needs it."""
    got = settled(constrained(tricycle), pitch_deg=5.0)
    within_one_percent(got, nose=31.174, right=35.475, left=35.475)
    assert got["sum"] == pytest.approx(102.124, abs=0.001)
    assert got["sum"] == pytest.approx(WEIGHT_KN * np.cos(np.deg2rad(5.0)), abs=0.001)
    assert got["pitch"] == pytest.approx(0.8084, abs=0.05)


def test_case_6_ship_pitch_held_by_the_probe(tricycle: Helicopter) -> None:
    """Tires free to roll; the claw, at deck level, is where the probe is in the reference state."""
    batch = constrained(tricycle, rolling=True, probe=True)
    batch.place(0.0, 0.0, 0.0)
    start = batch.state[State.Q8, 0]
    got = settled(batch, pitch_deg=5.0)
    within_one_percent(got, fx=8.936)
    slope = WEIGHT_KN * np.sin(np.deg2rad(5.0))  # along the deck; fx is along the helicopter, 0.8 deg from it
    assert got["fx"] * np.cos(np.deg2rad(got["pitch"])) == pytest.approx(slope, rel=1e-4)
    assert got["fy"] == pytest.approx(0.0, abs=1e-6) and got["yaw"] == pytest.approx(0.0, abs=1e-6)
    assert got["x"] - start == pytest.approx(-0.022, abs=0.001)


def test_case_7_ship_roll(tricycle: Helicopter) -> None:
    got = settled(constrained(tricycle), roll_deg=5.0)
    assert got["sum"] == pytest.approx(102.124, abs=0.001)
    assert got["roll"] == pytest.approx(2.023, abs=0.15)
    assert got["right"] + got["left"] == pytest.approx(67.168, rel=0.01)
    within_one_percent(got, right=41.185, left=25.984)
