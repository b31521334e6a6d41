"""The picture: arrays and windows, that it follows the scene, the projection, and the sentence for a missing pygame."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from ssmash_gym.envs.rendering import (
    Airframe,
    History,
    Renderer,
    Scene,
    Track,
    Wheels,
    demo_scene,
    palette,
    rotation,
)
from ssmash_gym.envs.rendering.hud import Layout
from ssmash_gym.envs.rendering.renderer import view_camera
from ssmash_gym.envs.rendering.traces import round_step
from tests.envs.scenes import far

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
