"""Time the MuJoCo model on the same traverse: its own C++ rollout, no Python inside the loop."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.mujoco_model import controls, mjcf, model_of
from benchmarks.scenario import CLAW_SPEED_MPS, DURATION_S, LEAD_IN_S, SUBSTEP_S, motion
from ssmash_gym.vehicle import Helicopter


def traverse(helicopter: Helicopter, seed: int = 0) -> Callable[[], float]:
    """A turn for `timing.cpu_rate`: one whole traverse, every substep's state and sensors recorded.

    Args:
        helicopter: Whose masses, geometry and working point the model takes.
        seed: Which of the benchmark's seas.

    Returns:
        A function that runs the traverse, checks that it arrived, and gives the simulated seconds.
    """
    model = mujoco.MjModel.from_xml_string(mjcf(model_of(helicopter), SUBSTEP_S))
    data = mujoco.MjData(model)
    times = SUBSTEP_S * np.arange(round(DURATION_S / SUBSTEP_S))
    sea = motion(seed).at(times)
    claw = np.zeros((times.size, 2))
    claw[times >= LEAD_IN_S, 0] = CLAW_SPEED_MPS
    control = controls(np.concatenate([sea.position, sea.rate], axis=1), claw)[np.newaxis]
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros((1, mujoco.mj_stateSize(model, kind)))
    mujoco.mj_getState(model, data, start[0], kind)
    expected_m = CLAW_SPEED_MPS * (times[-1] - LEAD_IN_S)

    def turn() -> float:
        _, sensors = rollout.rollout(model, data, start, control)
        travelled_m = sensors[0, -1, 0] - sensors[0, 0, 0]
        if not abs(travelled_m - expected_m) < 0.2:
            raise RuntimeError(f"the MuJoCo helicopter travelled {travelled_m:.2f} m instead of {expected_m:.2f} m")
        return float(times.size * SUBSTEP_S)

    return turn
