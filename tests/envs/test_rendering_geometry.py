"""The picture's geometry: projection, meshes, the numbers of a scene, the pose from kernel rows."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from ssmash_gym.dynamics.layout import (
    PARAMETER_ROWS,
    STATE_ROWS,
    STATION_COORDINATES,
    STATION_ROWS,
    TIRE_PAR,
    TIRE_ROWS,
    Par,
    Sta,
    State,
    Tir,
)
from ssmash_gym.envs.rendering import (
    Airframe,
    Renderer,
    Scene,
    Track,
    airframe_for,
    demo_scene,
    helicopter_pose,
    rotation,
)
from ssmash_gym.envs.rendering.camera import Camera, clip, half_plane
from ssmash_gym.envs.rendering.geometry import airframe_mesh, bases, claw_mesh, normals
from ssmash_gym.envs.rendering.painter import _wheel_meshes
from ssmash_gym.envs.rendering.renderer import view_camera
from ssmash_gym.envs.rendering.scenery import DECK_ABOVE_SEA, backdrop, hull
from tests.envs.scenes import far

pygame = pytest.importorskip("pygame")


# --- projection and meshes ----------------------------------------------------------------------------------


def test_projection_of_round_numbers():
    camera = Camera.looking(np.array([0.0, 0.0, -2.0]), np.array([1.0, 0.0, 0.0]), 100.0, (50.0, 40.0))
    points = np.array([[10.0, 0.0, -2.0], [10.0, 1.0, -2.0], [10.0, 0.0, -1.0], [20.0, -4.0, -4.0], [5.0, 0.0, 0.0]])
    pixels, depth = camera.project(points)
    # Forward into the picture, starboard to the right, down downwards.
    np.testing.assert_allclose(pixels, [[50, 40], [60, 40], [50, 50], [30, 30], [50, 80]], atol=1e-12)
    np.testing.assert_allclose(depth, [10, 10, 10, 20, 5], atol=1e-12)


def test_a_carried_camera_sees_the_same():
    rng = np.random.default_rng(3)
    camera = Camera.looking(np.array([-9.0, 12.0, -5.0]), np.array([1.0, -1.2, 0.3]), 700.0, (320.0, 200.0))
    R_BA, r_BA_B, points_A = rotation(0.2, -0.1, 0.7), np.array([3.0, -2.0, 0.5]), rng.normal(size=(50, 3))
    pixels, depth = camera.project(points_A)
    carried, carried_depth = camera.carried(R_BA, r_BA_B).project(r_BA_B + points_A @ R_BA.T)
    np.testing.assert_allclose(carried, pixels, atol=1e-9)
    np.testing.assert_allclose(carried_depth, depth, atol=1e-12)


def test_clipping():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    half = clip(square, square[:, 0] - 1.0)
    assert half[:, 0].min() == 1.0 and half[:, 0].max() == 2.0 and len(half) == 4
    assert len(clip(square, -np.ones(4))) == 0
    assert sorted(half_plane([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)], 1.0, 1.0, -6.0)) == [
        (2.0, 4.0),
        (4.0, 2.0),
        (4.0, 4.0),
    ]
    camera = Camera.looking(np.zeros(3), np.array([1.0, 0.0, 0.0]), 100.0, (0.0, 0.0))
    deck = np.array([[-5.0, -1.0, 1.0], [5.0, -1.0, 1.0], [5.0, 1.0, 1.0], [-5.0, 1.0, 1.0]])
    assert max(y for _, y in camera.polygon(deck)) == pytest.approx(100.0 / 0.3)
    assert camera.polygon(deck - (50.0, 0.0, 0.0)) == []


@pytest.mark.parametrize("standpoint", ["sea", "deck"])
def test_bands_of_sky_and_sea_meet_at_the_horizon(standpoint):
    scene = replace(demo_scene(), R_NS=rotation(radians(7.0), radians(-2.0), 0.3))
    camera = view_camera(scene, (800, 600), standpoint)
    areas, sides = [], []
    for band, _ in backdrop(camera, (800.0, 600.0)):
        x, y = np.array(band).T
        areas.append(0.5 * abs(x @ np.roll(y, 1) - y @ np.roll(x, 1)))
        rays = np.stack([x - camera.centre_px[0], y - camera.centre_px[1], np.full(len(x), camera.focal_px)])
        down = camera.R_CA.T[2] @ rays / camera.focal_px
        sides.append(bool(down.mean() > 0.0))
        assert (down > -1e-9).all() if sides[-1] else (down < 1e-9).all()
    assert sides == sorted(sides) and len(set(sides)) == 2  # sky first, then the sea
    assert sum(areas) == pytest.approx(800 * 600)


def test_hull_ends_at_the_sea():
    R_NS, r_NS_N = rotation(0.1, -0.05, 0.3), np.array([0.4, -0.2, 1.1])
    sides, colours = hull(Track(), R_NS, r_NS_N)
    assert len(sides) == len(colours)
    feet = (sides[:2, 2:] @ R_NS.T + r_NS_N)[..., 2]
    np.testing.assert_allclose(feet, DECK_ABOVE_SEA, atol=1e-12)


def test_tires_are_flat_where_they_stand_and_round_where_they_hang():
    scene = demo_scene(motion=0.0)
    treads = [part for part in _wheel_meshes(scene) if not part.two_sided.any()]
    assert len(treads) == 1
    z = treads[0].vertices[:, 2].reshape(6, -1)
    np.testing.assert_array_equal(z.max(axis=1), 0.0)
    lifted = far(scene, np.array([0.0, 0.0, -1.0]))
    z = next(part for part in _wheel_meshes(lifted) if not part.two_sided.any()).vertices[:, 2].reshape(6, -1)
    tall = z.max(axis=1) - z.min(axis=1)
    np.testing.assert_allclose(tall, scene.wheels.diameter_m, rtol=0.03)
    assert (z.max(axis=1) < -0.9).all()


def test_closed_bodies_face_outwards():
    claw = claw_mesh(0.05)
    corners = claw.vertices[claw.faces]
    for first in range(0, len(corners), 6):  # three boxes
        body = corners[first : first + 6]
        assert ((body.mean(axis=1) - body.mean(axis=(0, 1))) * normals(body)).sum(axis=1).min() > 0.0
    hull_faces = airframe_mesh(Airframe())
    corners = hull_faces.vertices[hull_faces.faces]
    side, across = corners.mean(axis=1)[:, 1], normals(corners)[:, 1]
    cabin = (np.abs(side) > 1.0) & (np.abs(side) < 1.14) & (np.abs(across) > 0.9)
    assert cabin.sum() > 10
    assert (np.sign(side[cabin]) == np.sign(across[cabin])).all()


def test_bases_are_right_handed_about_any_axis():
    axes = np.array([[0, 0, 1], [0, 0, -2], [0, 1, 0], [1, 0, 0], [0.3, -0.5, 0.9], [0, 0, 0]], dtype=float)
    found = bases(axes)
    np.testing.assert_allclose(found @ found.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (6, 3, 3)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(found), 1.0)
    np.testing.assert_allclose(found[:5, :, 1], axes[:5] / np.linalg.norm(axes[:5], axis=1, keepdims=True))


def test_airframe_suits_nose_and_tail_wheels():
    tricycle = Airframe.around(
        np.array([[3.77, 0, 2.0], [-1.98, 1.6, 2.0], [-1.98, -1.6, 2.0]]),
        np.array([[3.8, 0, 1.1], [-1.98, 1.6, 1.1], [-1.98, -1.6, 1.1]]),
    )
    tail_wheel = Airframe.around(
        np.array([[-4.3, 0, 1.95], [1.6, 1.35, 1.9], [1.6, -1.35, 1.9]]),
        np.array([[-4.3, 0, 0.9], [0.6, 1.0, 1.1], [0.6, -1.0, 1.1]]),
    )
    for body, foremost in ((tricycle, 3.77), (tail_wheel, 1.6)):
        assert body.nose_x > foremost > body.cabin_aft_x > body.tail_x
        assert body.roof_z < 0.0 < body.floor_z
    assert tail_wheel.tail_x < -4.3 < tail_wheel.cabin_aft_x
    # Only main stations that stand off the cabin have fairings.
    assert len(airframe_mesh(tricycle).faces) > len(airframe_mesh(tail_wheel).faces)


# --- numbers of a scene -------------------------------------------------------------------------------------


def test_scene_numbers():
    scene = replace(demo_scene(motion=0.0), R_SH=rotation(0.1, -0.2, 0.3), R_NS=rotation(-0.05, 0.02, 1.0))
    np.testing.assert_allclose(scene.angles_SH, (0.1, -0.2, 0.3))
    np.testing.assert_allclose(scene.angles_NS, (-0.05, 0.02, 1.0))
    scene = replace(scene, probe_force_S=scene.R_SH @ np.array([3e3, -4e3, 7e3]))
    assert scene.probe_in_plane_N == pytest.approx(5e3)
    assert scene.probe_axial_N == pytest.approx(7e3)
    assert scene.to_go_m == pytest.approx(8.0 - scene.r_SC_S[0])
    assert scene.lateral == scene.r_SB_S[1]
    assert replace(scene, lateral_m=-0.07).lateral == -0.07


def kernel_rows() -> tuple[np.ndarray, np.ndarray]:
    """A helicopter at x = 2 m, yawed by 90 deg, its auxiliary station steered by another 90 deg."""
    state, parameters = np.zeros(STATE_ROWS), np.zeros(PARAMETER_ROWS)
    half = np.sqrt(0.5)
    state[State.Q8 : State.Q8 + 3] = 2.0, 0.0, -2.3
    state[State.Q11 : State.Q11 + 4] = half, 0.0, 0.0, half
    for i, steer in enumerate((half, 0.0, 0.0)):
        joint = State.Q15 + i * STATION_COORDINATES
        state[joint : joint + 5] = 0.8, np.sqrt(1.0 - steer**2), 0.0, 0.0, steer
        station = Par.STATION + i * STATION_ROWS
        parameters[station + Sta.MOUNT : station + Sta.MOUNT + 3] = (
            (4.0, 0, 1.2),
            (-2.0, 1.5, 1.2),
            (-2.0, -1.5, 1.2),
        )[i]
        parameters[station + Sta.DROOP] = -0.05
        for t, y in enumerate((0.2, -0.2)):
            tire = TIRE_PAR + (2 * i + t) * TIRE_ROWS
            parameters[tire + Tir.Y], parameters[tire + Tir.DIAMETER], parameters[tire + Tir.WIDTH] = y, 0.6, 0.2
    parameters[Par.PROBE_MOUNT : Par.PROBE_MOUNT + 3] = 0.5, 0.0, 1.2
    parameters[Par.PROBE_VECTOR : Par.PROBE_VECTOR + 3] = 0.0, 0.0, 1.3
    parameters[Par.CLAW_Z] = -0.1
    return state, parameters


def test_pose_from_the_kernels_rows():
    state, parameters = kernel_rows()
    pose = helicopter_pose(state, parameters, (2, 1, 2), (30e3, 20e3, 40e3))
    wheels = pose["wheels"]
    # Yawed to starboard by 90 deg, the nose lies towards +y and starboard towards -x.
    np.testing.assert_allclose(pose["R_SH"] @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(wheels.r_SO_S, [[2.0, 4.0, -1.1], [0.5, -2.0, -1.1], [3.5, -2.0, -1.1]], atol=1e-12)
    # Steered on to 180 deg in all, the trail of 0.05 m lies towards +x and the axle towards -y.
    np.testing.assert_allclose(wheels.r_SW_S[0], [2.05, 4.0, -0.3], atol=1e-12)
    np.testing.assert_allclose(wheels.r_SW_S[1], [0.5, -2.05, -0.3], atol=1e-12)
    np.testing.assert_allclose(
        wheels.r_ST_S[:3], [[2.05, 3.8, -0.3], [2.05, 4.2, -0.3], [0.3, -2.05, -0.3]], atol=1e-12
    )
    np.testing.assert_allclose(wheels.axle_S[[0, 2]], [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]], atol=1e-12)
    np.testing.assert_array_equal(wheels.station, [0, 0, 1, 2, 2])
    np.testing.assert_allclose(wheels.station_load_N, [30e3, 20e3, 40e3])
    np.testing.assert_allclose(pose["r_SA_S"], [2.0, 0.5, -1.1], atol=1e-12)
    np.testing.assert_allclose(pose["r_SB_S"], [2.0, 0.5, -0.1], atol=1e-12)
    scene = Scene(time_s=1.0, r_SC_S=np.array([2.0, 0.5, -0.1]), airframe=airframe_for(pose), **pose)
    assert Renderer(size=(640, 480)).render(scene).shape == (480, 640, 3)


def test_a_probe_that_is_up_keeps_its_length():
    state, parameters = kernel_rows()
    state[State.Q8 + 2] = -3.0
    pose = helicopter_pose(state, parameters, (1, 1, 1), (0.0, 0.0, 0.0))
    np.testing.assert_allclose(pose["r_SB_S"] - pose["r_SA_S"], [0.0, 0.0, 1.3], atol=1e-12)
