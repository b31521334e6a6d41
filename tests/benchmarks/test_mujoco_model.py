"""The MuJoCo model that the benchmark compares with does the same job: same weight on the wheels, same way."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from benchmarks import mujoco_model, mujoco_side
from ssmash_gym.vehicle import load_helicopter

SETTLED_S = 6.0
SUBSTEP_S = 0.002
LOADS = slice(13, 22)  # force sensors of the three stations, after pose and velocities


@pytest.mark.parametrize("name", ["generic_tricycle", "seahawk_like"])
def test_stations_carry_what_they_carry_in_the_engine(name: str) -> None:
    numbers = mujoco_model.model_of(load_helicopter(name))
    model = mujoco.MjModel.from_xml_string(mujoco_model.mjcf(numbers, SUBSTEP_S))
    data = mujoco.MjData(model)
    for _ in range(round(SETTLED_S / SUBSTEP_S)):
        mujoco.mj_step(model, data)
    loads = data.sensordata[LOADS].reshape(3, 3)[:, 2]
    expected = [station.static_load_n for station in numbers.stations]
    np.testing.assert_allclose(loads, expected, rtol=0.06)
    weight = mujoco_model.GRAVITY_MPS2 * (numbers.body_mass_kg + sum(s.carriage_mass_kg for s in numbers.stations))
    np.testing.assert_allclose(loads.sum(), weight, rtol=0.01)


def test_helicopter_is_hauled_along_the_track() -> None:
    assert (
        mujoco_side.traverse(load_helicopter("generic_tricycle"))() > 0.0
    )  # refuses a helicopter that has not arrived
