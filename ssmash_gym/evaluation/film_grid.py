"""Pictures of several helicopters in the same sea: a panel each, and their probe loads over time below."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from ssmash_gym.envs.rendering import palette

if TYPE_CHECKING:
    from ssmash_gym.envs.rendering import Scene
    from ssmash_gym.envs.rendering.palette import Colour

WIDTH: Final = 1280  # of the picture [px]
TEXT: Final = 26  # height of the ordinary text [px]: to be read on a telephone
STRIP: Final = 190  # height of the load traces [px]
FINENESS: Final = 2  # a view is painted this many times larger and then smoothed
WIDE: Final = 16.0 / 9.0


@dataclass
class Panel:
    """One helicopter of the picture.

    Attributes:
        name: Of the policy that drives it.
        colour: Of the name and of its trace.
        scene: What is to be seen of it now.
        peak_kN: Largest probe load that counts, so far.
        time_s, load_kN: Its probe load over time, the peak of each interval.
    """

    name: str
    colour: Colour
    scene: Scene
    peak_kN: float = 0.0
    time_s: list[float] = field(default_factory=list)
    load_kN: list[float] = field(default_factory=list)


class Grid:
    """Draws panels side by side.

    Args:
        count: How many panels.
        horizon_s: Right end of the time axis.
        top_kN: Upper end of the axis of the loads, unless a load lies higher.
    """

    def __init__(self, count: int, horizon_s: float, top_kN: float) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        import pygame

        from ssmash_gym.envs.rendering.ink import Ink
        from ssmash_gym.envs.rendering.painter import Backdrop

        self.across = 1 if count == 1 else 2 if count <= 4 else 3
        down = math.ceil(count / self.across)
        wide = WIDTH // self.across // 2 * 2
        self.tile = (wide, round(wide / WIDE) // 2 * 2)
        self.size = (WIDTH, down * self.tile[1] + STRIP)
        self.horizon_s, self.top_kN = horizon_s, top_kN
        self.ink = Ink(TEXT)
        self.picture = pygame.Surface(self.size, 0, 32)
        self.view = pygame.Surface(self.tile, 0, 32)
        self.fine = pygame.Surface((FINENESS * self.tile[0], FINENESS * self.tile[1]), 0, 32)
        self.backdrop = Backdrop(self.fine.get_size())
        self.picture.fill(palette.PANEL)

    def draw(self, panels: Sequence[Panel], changed: Sequence[int]) -> bytes:
        """The picture, with the listed panels drawn anew and the others as they were.

        Args:
            panels: All of them; where one lies follows from its number.
            changed: Numbers of those whose scene is another one than last time.

        Returns:
            Red, green and blue of each pixel, row by row.
        """
        import pygame

        for k in changed:
            place = (k % self.across * self.tile[0], k // self.across * self.tile[1])
            self._view(panels[k])
            self.picture.blit(self.view, place)
            pygame.draw.rect(self.picture, palette.PANEL, (*place, *self.tile), 2)
        self._strip(panels)
        return bytes(pygame.image.tobytes(self.picture, "RGB"))

    def _view(self, panel: Panel) -> None:
        """One helicopter with its name, its loads and how it ended."""
        import pygame

        from ssmash_gym.envs.rendering.painter import paint
        from ssmash_gym.envs.rendering.renderer import view_camera

        scene, ink = panel.scene, self.ink
        camera = view_camera(scene, self.fine.get_size(), "sea")
        paint(self.fine, scene, camera, self.backdrop.seen(camera))
        pygame.transform.smoothscale(self.fine, self.tile, self.view)
        width, height = self.tile
        band = pygame.Surface((width, ink.large + 14), pygame.SRCALPHA)
        band.fill((*palette.PANEL, 205))
        self.view.blit(band, (0, 0))
        pygame.draw.rect(self.view, panel.colour, (0, 0, 8, ink.large + 14))
        ink.write(self.view, panel.name, (18, 14), palette.TEXT)
        limits = scene.limits
        colour = palette.probe_colour(1e3 * panel.peak_kN, limits.probe_soft_N, limits.probe_cost_N)
        drawn = ink.write(self.view, f"{panel.peak_kN:.1f} kN", (width - 12, 7), colour, ink.large, 1.0)
        ink.write(self.view, "peak", (width - 20 - drawn, 18), palette.TEXT, ink.small, 1.0)
        if scene.outcome:
            self._outcome(scene, (width, height))

    def _outcome(self, scene: Scene, size: tuple[int, int]) -> None:
        import pygame

        colour = (28, 112, 66) if scene.success else (150, 38, 34)
        word = self.ink.word(f"{scene.outcome}, {scene.time_s:.1f} s", palette.TEXT)
        place = (12, size[1] - word.get_height() - 16)
        pygame.draw.rect(self.view, colour, (*place, word.get_width() + 24, word.get_height() + 8), border_radius=5)
        self.view.blit(word, (place[0] + 12, place[1] + 6))

    def _strip(self, panels: Sequence[Panel]) -> None:
        """Probe loads of all over time."""
        import pygame

        ink, surface = self.ink, self.picture
        left, right, above, below = 64, WIDTH - 18, self.size[1] - STRIP + 36, self.size[1] - 30
        pygame.draw.rect(surface, palette.PANEL, (0, self.size[1] - STRIP, WIDTH, STRIP))
        pygame.draw.rect(surface, palette.PLOT, (left, above, right - left, below - above))
        limits = panels[0].scene.limits
        top = max(self.top_kN, *(1.05 * max(panel.load_kN, default=0.0) for panel in panels), 0.0)

        def place(time_s: float, load_kN: float) -> tuple[float, float]:
            across = left + time_s / self.horizon_s * (right - left - 1)
            return across, below - 1 - min(load_kN, top) / top * (below - above - 2)

        for k in range(0, int(self.horizon_s) + 1, 10):
            column = place(float(k), 0.0)[0]
            pygame.draw.line(surface, palette.GRID, (column, above), (column, below - 1))
            ink.write(surface, f"{k} s", (min(column, right - 14), below + 4), palette.FAINT, ink.small, 0.5)
        step = 10.0 if top > 25.0 else 5.0
        for k in range(int(top / step) + 1):
            row = place(0.0, k * step)[1]
            pygame.draw.line(surface, palette.GRID, (left, row), (right - 1, row))
            if k % max(1, math.ceil(top / step / 4)) == 0:
                ink.write(surface, f"{k * step:g}", (left - 8, row - 12), palette.FAINT, ink.small, 1.0)
        row = place(0.0, limits.probe_cost_N / 1e3)[1]
        pygame.draw.line(surface, palette.BAD, (left, row), (right - 1, row), 1)
        for panel in reversed(panels):  # the first lies on top
            points = [place(*point) for point in zip(panel.time_s, panel.load_kN, strict=True)]
            if len(points) > 1:
                pygame.draw.lines(surface, panel.colour, False, points, 3)
        at = self.size[1] - STRIP + 9
        now = max(panel.scene.time_s for panel in panels)
        ink.write(surface, f"probe load [kN], {now:.1f} s", (left, at), palette.TEXT, ink.small)
        end = float(right)
        key = [*((panel.name, panel.colour) for panel in panels), ("limit", palette.BAD)]
        for name, colour in reversed(key):
            end -= ink.write(surface, name, (end, at), colour, ink.small, 1.0) + 20
