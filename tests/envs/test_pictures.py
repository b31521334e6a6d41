"""The scene that is drawn agrees with the simulation; no window and no pygame are needed for it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import Film
from ssmash_gym.envs.vector import TraverseVectorEnv

TASK: dict[str, Any] = {"horizon_s": 0.5, "lead_in": {"duration_s": 4.0, "ramp_s": 4.0}}


@pytest.mark.parametrize("helicopter", ["generic_tricycle", "seahawk_like"])
def test_wheels_stand_on_the_deck_and_the_probe_is_at_the_claw(helicopter: str) -> None:
    core = TraverseBatch(2, task=TASK, scenario="training", helicopter=helicopter)
    core.reset(seeds=[1, 2])
    film = Film(core, 1, "rgb_array")
    film.note(core.step(np.full((2, 2), 0.5)))
    scene, telemetry = film.scene(), core.telemetry
    deflection = [telemetry[f"{name}_tire_vertical_deflection"][1] for name in ("auxiliary", "right", "left")]
    height = -scene.wheels.r_ST_S[:, 2]
    expected = 0.5 * scene.wheels.diameter_m - np.array(deflection)[scene.wheels.station]
    assert height == pytest.approx(expected, abs=0.01)
    contact = [telemetry[f"{name}_contact_y"][1] for name in ("auxiliary", "right", "left")]
    middle = [np.mean(scene.wheels.r_ST_S[scene.wheels.station == i, 1]) for i in range(3)]
    assert middle == pytest.approx(contact, abs=0.03)
    assert scene.probe_in_plane_N == pytest.approx(telemetry["probe_in_plane"][1], rel=1e-6)
    assert np.linalg.norm(scene.r_SB_S - scene.r_SC_S) < 0.05
    angles = [telemetry[name][1] for name in ("roll", "pitch", "yaw")]
    assert scene.angles_SH == pytest.approx(angles, abs=1e-9)
    assert scene.angles_NS == pytest.approx([telemetry[f"deck_{n}"][1] for n in ("roll", "pitch", "yaw")], abs=1e-9)
    assert scene.history.time_s.tolist() == [0.1]
    assert scene.wheels.station_load_N == pytest.approx(scene.history.station_N[0])


def test_the_end_is_told_and_a_new_episode_starts_a_new_film() -> None:
    core = TraverseBatch(1, task=TASK, scenario="flat")
    core.reset(seeds=[0])
    film = Film(core, 0, "rgb_array")
    while not core.book.over[0]:
        film.note(core.step([[0.0, 0.0]]))
    assert film.scene().outcome == "time is up" and film.scene().success is False
    assert film.scene().history.time_s.size == 5
    film.cut()
    assert film.scene().outcome == "" and film.scene().history.time_s.size == 0


def test_a_batch_has_no_window() -> None:
    with pytest.raises(ValueError, match="rgb_array"):
        TraverseVectorEnv(2, task=TASK, scenario="flat", render_mode="human")


def test_a_batch_gives_a_picture_each() -> None:
    pytest.importorskip("pygame")
    envs = TraverseVectorEnv(2, task=TASK, scenario="flat", render_mode="rgb_array")
    envs.reset(seed=0)
    frames = envs.render()
    assert frames is not None and len(frames) == 2
    assert all(frame is not None and frame.dtype == np.uint8 and frame.shape[2] == 3 for frame in frames)
    envs.close()
    envs.close()
