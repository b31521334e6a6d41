"""Setup and frames: the numbers of the scene, rounded, in the axes and conventions that they name."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from ssmash_gym.console.scene import frame_of, quaternion, setup_of
from ssmash_gym.envs.batch_env import TraverseBatch
from ssmash_gym.envs.pictures import scene_of
from ssmash_gym.envs.rendering.scene import History, rotation
from ssmash_gym.ship import MotionTable
from ssmash_gym.vehicle.geometry import rotation as of_euler_parameters
from tests.console.seas import started

FRAME = {
    "t", "k", "ship", "body", "claw", "probe", "force", "captured", "struts", "tires", "command", "probe_kN",
    "probe_peak_kN", "axial_kN", "load_kN", "yaw_deg", "roll_deg", "pitch_deg", "deck_roll_deg", "deck_pitch_deg",
    "lateral_m", "to_go_m", "held", "peak_kN",
}  # fmt: skip


@pytest.fixture(scope="module", params=["generic_tricycle", "seahawk_like"])
def moving(request: pytest.FixtureRequest) -> TraverseBatch:
    """Two helicopters under way, with rows of their own."""
    batch = started(request.param, n=2)
    for k in range(8):
        batch.step([[0.8, 0.3], [0.2, -0.5 if k % 2 else 0.5]])
    return batch


def numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        return [x for child in value.values() for x in numbers(child)]
    if isinstance(value, list):
        return [x for child in value for x in numbers(child)]
    return [value] if isinstance(value, int | float) else []


@pytest.mark.parametrize("k", [0, 1])
def test_frame_holds_the_scene(moving: TraverseBatch, k: int) -> None:
    scene, frame = scene_of(moving, k, History()), frame_of(moving, k)
    assert set(frame) == FRAME
    assert frame["t"] == pytest.approx(0.8)
    assert frame["k"] == 8
    for key, r, R in (("body", scene.r_SH_S, scene.R_SH), ("ship", scene.r_NS_N, scene.R_NS)):
        np.testing.assert_allclose(frame[key][:3], r, atol=1e-4)
        np.testing.assert_allclose(of_euler_parameters(np.array(frame[key][3:])), R, atol=5e-5)
    np.testing.assert_allclose(frame["claw"], [*scene.r_SC_S, *scene.claw_velocity_S], atol=1e-4)
    np.testing.assert_allclose(frame["probe"], [*scene.r_SA_S, *scene.r_SB_S], atol=1e-4)
    np.testing.assert_allclose(np.array(frame["struts"])[:, :3], scene.wheels.r_SO_S, atol=1e-4)
    np.testing.assert_allclose(np.array(frame["struts"])[:, 3:], scene.wheels.r_SW_S, atol=1e-4)
    tires = np.array(frame["tires"])
    np.testing.assert_allclose(tires[:, :3], scene.wheels.r_ST_S, atol=1e-4)
    np.testing.assert_allclose(tires[:, 3:6], scene.wheels.axle_S, atol=1e-3)
    np.testing.assert_allclose(tires[:, 6], 1e-3 * scene.wheels.load_N, atol=0.01)
    np.testing.assert_allclose(np.linalg.norm(frame["force"]), frame["probe_kN"], atol=0.02)
    assert frame["probe_peak_kN"] >= frame["probe_kN"] > 0.0
    assert frame["to_go_m"] == pytest.approx(8.0 - frame["claw"][0], abs=2e-4)


def test_deck_is_that_of_the_motion_table(moving: TraverseBatch) -> None:
    table = MotionTable(moving.batch.timing.node_spacing_s, moving.batch.nodes[1])
    pose = table.pose(float(moving.batch.time_s[1]))
    frame = frame_of(moving, 1)
    lever_S = np.array([3.0, -2.0, 0.5])
    told = np.array(frame["ship"][:3]) + of_euler_parameters(np.array(frame["ship"][3:])) @ lever_S
    np.testing.assert_allclose(told, pose.r_NS_N + pose.R_NS @ lever_S, atol=3e-4)
    assert abs(frame["deck_roll_deg"]) > 0.05, "the deck must move in this test"


def test_quaternions_turn_as_they_are_named() -> None:
    np.testing.assert_allclose(quaternion(rotation(0.3, 0.0, 0.0)), [np.cos(0.15), np.sin(0.15), 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(quaternion(rotation(0.0, 0.3, 0.0)), [np.cos(0.15), 0.0, np.sin(0.15), 0.0], atol=1e-12)
    np.testing.assert_allclose(quaternion(rotation(0.0, 0.0, 0.3)), [np.cos(0.15), 0.0, 0.0, np.sin(0.15)], atol=1e-12)


def test_every_rotation_has_its_quaternion() -> None:
    rng = np.random.default_rng(1)
    for q in [*rng.normal(size=(200, 4)), [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [1e-9, 1, 1, 1]]:
        R = of_euler_parameters(np.array(q) / np.linalg.norm(q))
        made = quaternion(R)
        assert np.linalg.norm(made) == pytest.approx(1.0)
        assert made[0] >= 0.0
        np.testing.assert_allclose(of_euler_parameters(made), R, atol=1e-9)


def test_messages_are_small_finite_and_json(moving: TraverseBatch) -> None:
    frame, setup = frame_of(moving), setup_of(moving)
    assert len(json.dumps(frame, separators=(",", ":"))) < 1100
    assert len(json.dumps(setup, separators=(",", ":"))) < 64 * 1024
    assert np.isfinite(numbers(frame)).all()
    assert np.isfinite(numbers(setup)).all()
    assert json.loads(json.dumps(setup)) == setup


def test_first_frame_is_before_anything_has_happened() -> None:
    frame = frame_of(started())
    assert frame["k"] == 0
    assert frame["t"] == 0.0
    assert frame["command"] == [0.0, 0.0]
    assert frame["probe_peak_kN"] == frame["probe_kN"]
    assert frame["peak_kN"] == 0.0
    assert frame["yaw_deg"] == pytest.approx(6.0, abs=0.3)


def test_setup_is_that_of_the_task(moving: TraverseBatch) -> None:
    setup, task = setup_of(moving), moving.task
    assert setup["track"]["goal_x_m"] == task.track.goal_x_m
    assert setup["track"]["yaw_tolerance_deg"] == pytest.approx(task.goal.yaw_tolerance_deg)
    assert setup["limits"]["probe_kN"] == pytest.approx(task.limits.probe_in_plane_kN)
    assert setup["limits"]["station_kN"] == pytest.approx(task.limits.main_vertical_kN)
    assert setup["claw"]["speed_along_m_s"] == pytest.approx(task.claw.speed_along_m_s)
    assert setup["claw"]["y_travel_m"] == pytest.approx(task.claw.y_travel_m)
    assert setup["interval_s"] == task.control_interval_s
    assert setup["sea"]["heading_deg"] == 60.0
    assert setup["ship_speed_m_s"] == pytest.approx(12.0 * 1852.0 / 3600.0)
    assert [tire["station"] for tire in setup["tires"]] == [
        int(i) for i in scene_of(moving, 0, History()).wheels.station
    ]


def test_meshes_are_whole_and_turned_outwards(moving: TraverseBatch) -> None:
    meshes = {mesh["name"]: mesh for mesh in setup_of(moving)["meshes"]}
    assert {"body", "claw", "door", "markings"} <= set(meshes)
    for mesh in meshes.values():
        count = len(mesh["indices"]) // 3
        assert max(mesh["indices"]) < len(mesh["positions"]) // 3
        assert len(mesh["colours"]) == 3 * count
        assert len(mesh["two_sided"]) == count
    corners = np.array(meshes["claw"]["positions"]).reshape(-1, 3)[np.array(meshes["claw"]["indices"]).reshape(-1, 3)]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume > 0.05, "seen from outside the corners run counter-clockwise: the volume within is positive"
    paint = np.array(meshes["markings"]["positions"]).reshape(-1, 3)
    a, b, c = (paint[np.array(meshes["markings"]["indices"]).reshape(-1, 3)[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 2] < 0.0).all(), "paint on the deck looks up, which is -z"


def test_scene_needs_no_pygame() -> None:
    code = "import sys; sys.modules['pygame'] = None; import ssmash_gym.console.scene, ssmash_gym.console.runs"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
