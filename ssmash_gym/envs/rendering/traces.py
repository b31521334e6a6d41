"""Traces of the loads over the last seconds, with their limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering import palette
from ssmash_gym.envs.rendering.ink import Ink
from ssmash_gym.envs.rendering.palette import Colour
from ssmash_gym.envs.rendering.scene import STATION_LABELS, STATIONS, Scene

if TYPE_CHECKING:
    import pygame

Array = NDArray[np.float64]
Rect = tuple[int, int, int, int]  # x, y, width, height

WINDOW_S: Final = 30.0
ULTIMATE: Final[Colour] = (200, 90, 220)


@dataclass(frozen=True, eq=False)
class Curve:
    """One line of a trace: its values, colour and name."""

    values: Array
    colour: Colour
    name: str


@dataclass(frozen=True)
class Level:
    """One horizontal limit of a trace."""

    value: float
    colour: Colour
    name: str


def panel(surface: pygame.Surface, rect: Rect) -> None:
    """A dark rectangle with a fine edge."""
    import pygame

    pygame.draw.rect(surface, palette.PANEL, rect)
    pygame.draw.rect(surface, palette.PANEL_EDGE, rect, 1)


def draw_traces(surface: pygame.Surface, ink: Ink, rect: Rect, scene: Scene) -> None:
    """Probe load on the left, tire loads on the right, in kilonewtons."""
    x, y, width, height = rect
    panel(surface, rect)
    limits, history, half = scene.limits, scene.history, width // 2
    levels = [
        Level(limits.probe_soft_N / 1e3, palette.SOFT, "soft"),
        Level(limits.probe_cost_N / 1e3, palette.BAD, "limit"),
        Level(limits.probe_ultimate_N / 1e3, ULTIMATE, "ultimate"),
    ]
    probe = [Curve(history.probe_N / 1e3, palette.PROBE, "probe")]
    plot = _Plot(surface, ink, (x, y, half, height), scene, probe, 1.3 * limits.probe_cost_N / 1e3)
    plot.draw("probe [kN]", levels, [level for level in levels if level.value <= plot.top])
    levels = [
        Level(limits.station_N / 1e3, palette.BAD, "limit"),
        Level(limits.lift_off_N / 1e3, palette.LIFTED, "lift-off"),
    ]
    tires = [Curve(history.station_N[:, i] / 1e3, palette.STATION[i], STATION_LABELS[i]) for i in range(STATIONS)]
    plot = _Plot(surface, ink, (x + half, y, width - half, height), scene, tires, 1.12 * limits.station_N / 1e3)
    plot.draw("tires [kN]", levels, tires)


class _Plot:
    """One plot over the last `WINDOW_S` seconds; the scale grows with what is in the window."""

    def __init__(
        self, surface: pygame.Surface, ink: Ink, rect: Rect, scene: Scene, curves: Sequence[Curve], least_top: float
    ) -> None:
        x, y, width, height = rect
        self.surface, self.ink, self.curves, self.title_y = surface, ink, curves, y + 5
        self.left, self.right = x + 30, x + width - 10
        self.above, self.below = y + ink.height + 5, y + height - ink.small - 3
        self.end = max(scene.time_s, WINDOW_S)
        time = scene.history.time_s
        self.seen = (time >= self.end - WINDOW_S) & (time <= self.end)
        self.time = time[self.seen]
        largest = max((float(c.values[self.seen].max()) for c in curves if len(self.time)), default=0.0)
        self.top = max(least_top, 1.08 * largest)
        self.scale = (self.below - self.above - 2) / self.top

    def draw(self, title: str, levels: Sequence[Level], key: Sequence[Curve | Level]) -> None:
        """Grid, limits, curves, title and the names in `key`."""
        import pygame

        self._grid()
        for level in levels:
            if level.value <= self.top:
                row = self._row(level.value)
                pygame.draw.line(self.surface, level.colour, (self.left, row), (self.right - 1, row))
        columns = self._column(self.time)
        for curve in self.curves:
            if len(columns) > 1:
                rows = np.clip(self.below - 1 - self.scale * curve.values[self.seen], self.above, self.below - 1)
                pygame.draw.lines(self.surface, curve.colour, False, np.stack([columns, rows], axis=1).tolist(), 2)
        self.ink.write(self.surface, title, (self.left, self.title_y), palette.TEXT, self.ink.small)
        at = float(self.right)
        for named in reversed(key):
            place = (at, self.title_y)
            at -= self.ink.write(self.surface, named.name, place, named.colour, self.ink.small, 1.0) + 8

    def _row(self, value: float) -> float:
        return self.below - 1 - self.scale * value

    def _column(self, time: Array) -> Array:
        return np.asarray(self.left + (time - self.end + WINDOW_S) / WINDOW_S * (self.right - self.left - 1))

    def _grid(self) -> None:
        import pygame

        surface, ink, left, right = self.surface, self.ink, self.left, self.right
        pygame.draw.rect(surface, palette.PLOT, (left, self.above, right - left, self.below - self.above))
        step = round_step(self.top)
        for k in range(int(self.top / step) + 1):
            row = self._row(k * step)
            pygame.draw.line(surface, palette.GRID, (left, row), (right - 1, row))
            place = (left - 4, row - ink.small // 2 + 2)
            ink.write(surface, f"{k * step:g}", place, palette.FAINT, ink.small, 1.0)
        first = int(np.ceil((self.end - WINDOW_S) / 10.0)) * 10
        seconds = np.arange(first, int(self.end) + 1, 10, dtype=np.float64)
        for second, column in zip(seconds.tolist(), self._column(seconds).tolist(), strict=True):
            pygame.draw.line(surface, palette.GRID, (column, self.above), (column, self.below - 1))
            place = (min(column, right - 14.0), self.below + 2)
            ink.write(surface, f"{second:g} s", place, palette.FAINT, ink.small, 0.5)


def round_step(top: float) -> float:
    """A round distance between grid lines that makes two to four of them up to `top`."""
    unit = 10.0 ** np.floor(np.log10(top))
    return float(unit * next(s for s in (0.5, 1.0, 2.0, 2.5, 5.0) if top / (unit * s) < 4.5))
