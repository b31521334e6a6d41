"""The renderer: a scene in, an array or a window out."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, cast

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from ssmash_gym.envs.rendering.camera import Camera
from ssmash_gym.envs.rendering.scene import Scene

if TYPE_CHECKING:
    import pygame

    from ssmash_gym.envs.rendering.hud import Layout
    from ssmash_gym.envs.rendering.ink import Ink

Mode = Literal["rgb_array", "human"]
Standpoint = Literal["sea", "deck"]

SMALLEST: Final = (480, 360)
FINENESS: Final = 2  # the view is painted this many times larger and then smoothed
# The camera looks from the starboard quarter: degrees off the aft direction towards starboard, degrees above the deck.
QUARTER_DEG: Final = 56.0
ABOVE_DEG: Final = 13.5
DISTANCE_M: Final = 25.0
TARGET_ABOVE_DECK_M: Final = 1.9
AFT_OF_HELICOPTER_M: Final = 1.4
WIDTH_M: Final = 22.5  # shown across the view at the target's distance
WIDEST: Final = 1.66  # width over height up to which that holds


def require_pygame() -> None:
    """Import pygame, or say in one sentence what to install.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
    """
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        import pygame  # noqa: F401
    except ImportError as error:
        raise DependencyNotInstalled('Rendering needs pygame-ce: pip install "ssmash_gym[render]".') from error


class Renderer:
    """Draws scenes off screen, and shows them in a window if asked to.

    The same scene gives the same pixels, whatever was drawn before.

    Args:
        mode: ``"rgb_array"`` returns each picture and opens no window; ``"human"`` shows it in one.
        size: Width and height of the picture [px], at least 480 x 360.
        standpoint: ``"sea"`` keeps the camera level, so that the deck moves before a level horizon; ``"deck"`` carries
            it on the deck, so that the horizon moves.
        pace_hz: Pictures per second to which ``"human"`` slows down; None shows each at once.

    Raises:
        gymnasium.error.DependencyNotInstalled: pygame-ce is not installed.
        ValueError: An unknown mode or standpoint, or too small a picture.
    """

    def __init__(
        self,
        mode: Mode = "rgb_array",
        size: tuple[int, int] = (960, 600),
        *,
        standpoint: Standpoint = "sea",
        pace_hz: float | None = None,
    ) -> None:
        if mode not in ("rgb_array", "human"):
            raise ValueError(f"Renderer mode is {mode!r}; allowed are 'rgb_array' and 'human'.")
        if standpoint not in ("sea", "deck"):
            raise ValueError(f"Renderer standpoint is {standpoint!r}; allowed are 'sea' and 'deck'.")
        if size[0] < SMALLEST[0] or size[1] < SMALLEST[1]:
            raise ValueError(f"Renderer size is {tuple(size)}; allowed is {SMALLEST[0]} x {SMALLEST[1]} or more.")
        require_pygame()
        self.mode = mode
        self.size = (int(size[0]), int(size[1]))
        self.standpoint = standpoint
        self.pace_hz = pace_hz
        self._canvas: _Canvas | None = None
        self._window: pygame.Surface | None = None
        self._clock: pygame.time.Clock | None = None

    def render(self, scene: Scene) -> NDArray[np.uint8] | None:
        """Draw one scene.

        Args:
            scene: What is to be drawn.

        Returns:
            The picture (height, width, 3) as its own uint8 array, or None when it went to the window.
        """
        if self._canvas is None:
            self._canvas = _Canvas(self.size, self.standpoint)
        surface = self._canvas.draw(scene)
        if self.mode == "human":
            self._show(surface)
            return None
        return _pixels(surface)

    def _show(self, surface: pygame.Surface) -> None:
        import pygame

        if self._window is None:
            pygame.display.init()
            pygame.display.set_caption("ssmash_gym")
            self._window = pygame.display.set_mode(self.size)
            self._clock = pygame.time.Clock()
        self._window.blit(surface, (0, 0))
        pygame.event.pump()
        pygame.display.flip()
        if self.pace_hz is not None and self._clock is not None:
            self._clock.tick(self.pace_hz)

    def close(self) -> None:
        """Close the window, if there is one. May be called any number of times; a later `render` opens it again."""
        if self._window is not None:
            import pygame

            pygame.display.quit()
            self._window = None
        self._canvas = None


class _Canvas:
    """Surfaces and fonts of one picture size."""

    def __init__(self, size: tuple[int, int], standpoint: Standpoint) -> None:
        import pygame

        from ssmash_gym.envs.rendering.hud import Layout
        from ssmash_gym.envs.rendering.ink import Ink
        from ssmash_gym.envs.rendering.painter import Backdrop

        self.layout: Layout = Layout.of(*size)
        self.ink: Ink = Ink(self.layout.text)
        self.standpoint = standpoint
        _, _, width, height = self.layout.view
        self.picture = pygame.Surface(size, 0, 32)
        self.view = pygame.Surface((width, height), 0, 32)
        self.fine = pygame.Surface((FINENESS * width, FINENESS * height), 0, 32)
        self.backdrop = Backdrop(self.fine.get_size())

    def draw(self, scene: Scene) -> pygame.Surface:
        """The whole picture."""
        import pygame

        from ssmash_gym.envs.rendering.hud import draw_hud
        from ssmash_gym.envs.rendering.painter import paint

        x, y, width, height = self.layout.view
        camera = view_camera(scene, self.fine.get_size(), self.standpoint)
        found = paint(self.fine, scene, camera, self.backdrop.seen(camera))
        pygame.transform.smoothscale(self.fine, (width, height), self.view)
        self.picture.blit(self.view, (x, y))
        labels = [replace(f, place=(f.place[0] / FINENESS, f.place[1] / FINENESS)) for f in found]
        draw_hud(self.picture, self.ink, self.layout, scene, labels)
        return self.picture


def _pixels(surface: pygame.Surface) -> NDArray[np.uint8]:
    """A copy of a 32-bit surface, (height, width, 3). Three plane copies take a third of a strided one's time."""
    width, height = surface.get_size()
    octets = np.frombuffer(cast(memoryview, surface.get_buffer()), dtype=np.uint8)
    octets = octets.reshape(height, surface.get_pitch() // 4, 4)[:, :width]
    picture = np.empty((height, width, 3), dtype=np.uint8)
    for channel, shift in enumerate(surface.get_shifts()[:3]):
        picture[..., channel] = octets[..., shift // 8]
    return picture


def view_camera(scene: Scene, size: tuple[int, int], standpoint: Standpoint) -> Camera:
    """The camera that follows the helicopter along the track, N axes.

    Args:
        scene: What is to be seen.
        size: Width and height of the view [px].
        standpoint: ``"sea"``: carried along by the deck's mean place only; ``"deck"``: fixed to the deck.

    Returns:
        A camera on the starboard quarter, above the deck.
    """
    quarter, above = np.radians(QUARTER_DEG), np.radians(ABOVE_DEG)
    away = np.array([-np.cos(above) * np.cos(quarter), np.cos(above) * np.sin(quarter), -np.sin(above)])
    target = np.array([scene.r_SH_S[0] - AFT_OF_HELICOPTER_M, 0.4 * scene.r_SH_S[1], -TARGET_ABOVE_DECK_M])
    width, height = size
    shown = min(width, WIDEST * height)  # a wider picture shows more sea, not less of the helicopter
    focal, centre = shown * DISTANCE_M / WIDTH_M, (0.5 * width, 0.6 * height)
    camera = Camera.looking(target + DISTANCE_M * away, -away, focal, centre)
    return camera.carried(scene.R_NS, scene.r_NS_N) if standpoint == "deck" else camera
