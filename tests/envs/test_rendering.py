"""The picture: arrays and windows, that it follows the scene, the projection, and the sentence for a missing pygame."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

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
    History,
    Renderer,
    Scene,
    Track,
    Wheels,
    airframe_for,
    demo_scene,
    helicopter_pose,
    palette,
    rotation,
)
from ssmash_gym.envs.rendering.camera import Camera, clip, half_plane
from ssmash_gym.envs.rendering.geometry import airframe_mesh, bases, claw_mesh, normals
from ssmash_gym.envs.rendering.hud import Layout
from ssmash_gym.envs.rendering.painter import _wheel_meshes
from ssmash_gym.envs.rendering.renderer import view_camera
from ssmash_gym.envs.rendering.scenery import DECK_ABOVE_SEA, backdrop, hull
from ssmash_gym.envs.rendering.traces import round_step

pygame = pytest.importorskip("pygame")

SMALL = (640, 480)


def draw(scene: Scene, **options: str) -> np.ndarray:
    picture = Renderer(size=SMALL, **options).render(scene)
    assert picture is not None
    return picture


def view_of(picture: np.ndarray) -> np.ndarray:
    """The view without the panels, the plan included."""
    _, _, width, height = Layout.of(*SMALL).view
    return picture[:height, :width].astype(int)


@pytest.fixture(scope="module")
def demo_picture() -> np.ndarray:
    return draw(demo_scene())


def count(picture: np.ndarray, colour: tuple[int, int, int], within: int = 6) -> int:
    return int((np.abs(picture.astype(int) - colour).max(axis=-1) <= within).sum())


def with_loads(scene: Scene, load_N: float) -> Scene:
    return replace(scene, wheels=replace(scene.wheels, load_N=np.full(6, 0.5 * load_N)))


# --- arrays -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(960, 600), (640, 480), (480, 360), (1280, 720)])
def test_array_has_the_promised_shape_and_is_not_blank(size):
    picture = Renderer(size=size).render(demo_scene())
    assert picture.shape == (size[1], size[0], 3)
    assert picture.dtype == np.uint8
    assert len(np.unique(picture.astype(int) @ [65536, 256, 1])) > 500
    layout = Layout.of(*size)
    for x, y, width, height in (layout.view, layout.column, layout.strip, layout.plan):
        assert picture[y : y + height, x : x + width].std(axis=(0, 1)).min() > 5.0


def test_default_size_is_960_by_600():
    assert Renderer().render(demo_scene()).shape == (600, 960, 3)


def test_each_picture_is_the_callers_own():
    renderer = Renderer(size=SMALL)
    first = renderer.render(demo_scene(0.1))
    kept = first.copy()
    renderer.render(demo_scene(0.9))[:] = 0
    np.testing.assert_array_equal(first, kept)


@pytest.mark.parametrize("standpoint", ["sea", "deck"])
def test_same_scene_same_pixels_whatever_was_drawn_before(standpoint):
    fresh = draw(demo_scene(0.4), standpoint=standpoint)
    used = Renderer(size=SMALL, standpoint=standpoint)
    for progress in (0.0, 0.7, 1.0):
        used.render(demo_scene(progress))
    np.testing.assert_array_equal(used.render(demo_scene(0.4)), fresh)
    used.close()
    np.testing.assert_array_equal(used.render(demo_scene(0.4)), fresh)


def test_drawing_changes_nothing_in_the_scene():
    scene = demo_scene(0.3)
    before = [a.copy() for a in (scene.r_SH_S, scene.R_SH, scene.wheels.r_ST_S, scene.history.station_N)]
    draw(scene)
    for array, kept in zip(
        (scene.r_SH_S, scene.R_SH, scene.wheels.r_ST_S, scene.history.station_N), before, strict=True
    ):
        np.testing.assert_array_equal(array, kept)


def test_array_needs_no_window_and_no_video_driver(monkeypatch):
    monkeypatch.delenv("SDL_VIDEODRIVER", raising=False)
    pygame.display.quit()
    draw(demo_scene())
    assert not pygame.display.get_init()
    assert pygame.display.get_surface() is None


# --- it follows the scene -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "change",
    [
        {"r_SH_S": np.array([3.6, 0.5, -2.29])},
        {"R_SH": rotation(radians(6.0), 0.0, radians(3.0))},
        {"r_SC_S": np.array([4.1, 0.2, -0.06])},
        {"r_SB_S": np.array([4.1, 0.2, -0.06])},
        {"probe_force_S": np.array([9e3, 9e3, 0.0])},
        {"captured": False},
        {"R_NS": rotation(radians(5.0), 0.0, 0.0)},
        {"r_NS_N": np.array([0.0, 0.0, 1.5])},
        {"track": Track(goal_x_m=6.0)},
        {"airframe": Airframe(nose_x=4.5)},
        {"time_s": 24.0},
    ],
    ids=lambda change: next(iter(change)),
)
def test_view_moves_with_the_state(change, demo_picture):
    moved = np.abs(view_of(draw(replace(demo_scene(), **change))) - view_of(demo_picture)).max(axis=-1) > 20
    assert moved.sum() > 60


@pytest.mark.parametrize(
    "change",
    [
        {"claw_command": np.array([-1.0, 1.0])},
        {"claw_velocity_S": np.array([0.1, 0.1])},
        {"lateral_m": -0.2},
        {"horizon_s": 90.0},
        {"lines": ("another line",)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_column_shows_the_numbers(change, demo_picture):
    x, _, _, _ = Layout.of(*SMALL).column
    after = draw(replace(demo_scene(), **change))
    assert (demo_picture[:, x:] != after[:, x:]).any()
    np.testing.assert_array_equal(view_of(demo_picture), view_of(after))


def test_level_camera_keeps_the_horizon_and_deck_camera_keeps_the_deck():
    still = demo_scene(motion=0.0)
    rolled = replace(still, R_NS=rotation(radians(6.0), radians(2.0), 0.0))
    corner = (slice(0, 60), slice(-180, -100))  # sky, right of the plan and above the hangar
    sea = [view_of(draw(s, standpoint="sea"))[corner] for s in (still, rolled)]
    np.testing.assert_array_equal(sea[0], sea[1])
    deck = [view_of(draw(s, standpoint="deck")) for s in (still, rolled)]
    assert (deck[0][corner] != deck[1][corner]).any()
    deck_pixels = [view_camera(s, (800, 600), "deck").carried(s.R_NS.T, -s.R_NS.T @ s.r_NS_N) for s in (still, rolled)]
    for camera in deck_pixels:
        np.testing.assert_allclose(camera.r_AC_A, deck_pixels[0].r_AC_A, atol=1e-9)
        np.testing.assert_allclose(camera.R_CA, deck_pixels[0].R_CA, atol=1e-12)


def test_force_arrow_points_along_the_force():
    scene = demo_scene(motion=0.0)
    _, _, width, height = Layout.of(*SMALL).view
    left, top, wide, high = Layout.of(*SMALL).plan
    camera = view_camera(scene, (width, height), "sea")
    tip = camera.project(scene.r_SB_S)[0]
    without = view_of(draw(replace(scene, probe_force_S=np.zeros(3))))
    without[top : top + high, left : left + wide] = palette.BAD  # the plan's own line is none of the arrow
    for direction in ([1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]):
        force = 30e3 * np.array([*direction, 0.0])
        view = view_of(draw(replace(scene, probe_force_S=force)))
        red = (np.abs(view - palette.BAD).max(axis=-1) < 12) & (np.abs(without - palette.BAD).max(axis=-1) > 40)
        rows, columns = np.nonzero(red)
        assert len(rows) > 60
        expected = camera.project(scene.r_SB_S + force / 1e4)[0] - tip
        found = np.array([columns.mean(), rows.mean()]) - tip
        assert found @ expected > 0.9 * np.linalg.norm(found) * np.linalg.norm(expected)


def test_loads_change_colours():
    scene = demo_scene(motion=0.0)
    pictures = {load: view_of(draw(with_loads(scene, load))) for load in (1e3, 30e3, 95e3)}
    for load, colour in ((1e3, palette.LIFTED), (30e3, palette.GOOD), (95e3, palette.BAD)):
        seen = {other: count(picture, colour) for other, picture in pictures.items()}
        assert all(seen[load] > seen[other] + 50 for other in seen if other != load)


def test_load_colour_runs_from_green_over_amber_to_red():
    assert palette.load_colour(0.0, 90.0) == palette.load_colour(45.0, 90.0) == palette.GOOD
    assert palette.load_colour(72.0, 90.0) == palette.SOFT
    assert palette.load_colour(90.0, 90.0) == palette.load_colour(500.0, 90.0) == palette.BAD
    reds = [palette.load_colour(load, 90.0)[1] for load in range(45, 91, 5)]
    assert reds == sorted(reds, reverse=True)
    assert palette.tire_colour(1.9e3, 90e3, 2e3) == palette.LIFTED
    assert [palette.probe_colour(f, 6.0, 15.0) for f in (5.9, 6.0, 15.0)] == [palette.GOOD, palette.SOFT, palette.BAD]


def test_end_of_the_run_is_shown_with_its_reason():
    scene = demo_scene()
    running = view_of(draw(scene))
    won = view_of(draw(replace(scene, outcome="goal held for 2 s", success=True)))
    lost = view_of(draw(replace(scene, outcome="corridor left", success=False)))
    assert count(won, (28, 112, 66), 0) > 1000 > count(running, (28, 112, 66), 0)
    assert count(lost, (150, 38, 34), 0) > 1000 > count(running, (150, 38, 34), 0)


def test_traces_show_history_and_grow_with_it():
    scene = demo_scene()
    x, y, width, height = Layout.of(*SMALL).strip
    strips = []
    for factor in (1.0, 12.0):
        history = replace(scene.history, probe_N=factor * scene.history.probe_N)
        strips.append(draw(replace(scene, history=history))[y : y + height, x : x + width // 2])
    empty = draw(replace(scene, history=History()))[y : y + height, x : x + width // 2]
    assert count(strips[0], palette.PROBE) > 100 + count(empty, palette.PROBE)
    purple = (200, 90, 220)  # the ultimate limit comes into sight only with the load
    assert count(strips[1], purple) > 100 > count(strips[0], purple)


@pytest.mark.parametrize("top", [0.3, 1.0, 2.4, 19.5, 87.0, 100.8, 999.0])
def test_grid_lines_are_few_and_round(top):
    step = round_step(top)
    assert 2 <= top / step < 4.5
    assert f"{step:.0e}"[0] in "125" or step / 10 ** np.floor(np.log10(step)) == pytest.approx(2.5)


def far(scene: Scene, where: np.ndarray) -> Scene:
    wheels = scene.wheels
    shift = {name: getattr(wheels, name) + where for name in ("r_ST_S", "r_SO_S", "r_SW_S")}
    return replace(
        scene,
        r_SH_S=scene.r_SH_S + where,
        r_SA_S=scene.r_SA_S + where,
        r_SB_S=scene.r_SB_S + where,
        wheels=replace(wheels, **shift),
    )


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("where", [(0.0, 30.0, 2.0), (0.0, 0.0, -40.0), (-25.0, 6.0, 0.0), (1e9, 1e9, 1e9)])
def test_a_helicopter_that_left_the_deck_is_drawn_without_fuss(where):
    scene = far(demo_scene(), np.array(where))
    scene = replace(scene, R_SH=rotation(2.0, 0.7, -2.0), R_NS=rotation(0.9, -0.6, 0.4), lines=("line",) * 40)
    assert draw(scene).shape == (480, 640, 3)


@pytest.mark.filterwarnings("error")
def test_single_tires_on_their_carriages_and_no_tires_at_all():
    scene = demo_scene()
    w = scene.wheels
    one = Wheels(
        r_ST_S=w.r_SW_S,
        axle_S=w.axle_S[::2],
        diameter_m=w.diameter_m[::2],
        width_m=w.width_m[::2],
        load_N=2.0 * w.load_N[::2],
        station=np.arange(3),
        r_SO_S=w.r_SO_S,
        r_SW_S=w.r_SW_S,
    )
    none = Wheels(
        r_ST_S=np.zeros((0, 3)),
        axle_S=np.zeros((0, 3)),
        diameter_m=np.zeros(0),
        width_m=np.zeros(0),
        load_N=np.zeros(0),
        station=np.zeros(0, dtype=np.intp),
        r_SO_S=w.r_SO_S,
        r_SW_S=w.r_SW_S,
    )
    np.testing.assert_allclose(one.station_load_N, w.station_load_N)
    tires = [count(view_of(draw(replace(scene, wheels=each))), palette.GOOD) for each in (w, one, none)]
    assert tires[0] > tires[1] > tires[2]


# --- the window ---------------------------------------------------------------------------------------------


@pytest.fixture
def dummy_video(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame.display.quit()
    yield
    pygame.display.quit()


def test_window_shows_the_same_picture_and_closes_twice(dummy_video):
    renderer = Renderer("human", SMALL)
    assert not pygame.display.get_init()
    assert renderer.render(demo_scene(0.2)) is None
    window = pygame.display.get_surface()
    assert window.get_size() == SMALL
    shown = pygame.surfarray.array3d(window).swapaxes(0, 1)
    np.testing.assert_array_equal(shown, draw(demo_scene(0.2)))
    renderer.close()
    renderer.close()
    assert not pygame.display.get_init()
    renderer.render(demo_scene(0.2))
    assert pygame.display.get_surface() is not None
    renderer.close()


def test_window_leaves_events_to_whoever_reads_them(dummy_video):
    renderer = Renderer("human", SMALL, pace_hz=1000.0)
    renderer.render(demo_scene())
    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_UP))
    renderer.render(demo_scene())
    assert [e.key for e in pygame.event.get(pygame.KEYDOWN)] == [pygame.K_UP]
    renderer.close()


def test_closing_an_array_renderer_leaves_a_window_alone(dummy_video):
    window, array = Renderer("human", SMALL), Renderer(size=SMALL)
    window.render(demo_scene())
    array.render(demo_scene())
    array.close()
    array.close()
    assert pygame.display.get_surface() is not None
    window.close()


# --- mistakes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"mode": "ansi"}, "Renderer mode is 'ansi'; allowed are 'rgb_array' and 'human'."),
        ({"standpoint": "mast"}, "Renderer standpoint is 'mast'; allowed are 'sea' and 'deck'."),
        ({"size": (320, 480)}, "Renderer size is (320, 480); allowed is 480 x 360 or more."),
    ],
)
def test_a_mistake_costs_one_sentence(arguments, sentence):
    with pytest.raises(ValueError) as caught:
        Renderer(**arguments)
    assert str(caught.value) == sentence


def test_missing_pygame_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(DependencyNotInstalled) as caught:
        Renderer()
    assert str(caught.value) == 'Rendering needs pygame-ce: pip install "ssmash_gym[render]".'


def test_importing_the_package_imports_no_pygame():
    code = "import sys, ssmash_gym.envs.rendering as r; r.demo_scene(); sys.exit('pygame' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


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
    assert draw(scene).shape == (480, 640, 3)


def test_a_probe_that_is_up_keeps_its_length():
    state, parameters = kernel_rows()
    state[State.Q8 + 2] = -3.0
    pose = helicopter_pose(state, parameters, (1, 1, 1), (0.0, 0.0, 0.0))
    np.testing.assert_allclose(pose["r_SB_S"] - pose["r_SA_S"], [0.0, 0.0, 1.3], atol=1e-12)
