"""The head-up display: traces below the view, numbers and gauges beside it, the plan of the alignment in its corner."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering import palette
from ssmash_gym.envs.rendering.camera import FAR_PX
from ssmash_gym.envs.rendering.geometry import planform
from ssmash_gym.envs.rendering.ink import Ink
from ssmash_gym.envs.rendering.painter import Label
from ssmash_gym.envs.rendering.palette import Colour
from ssmash_gym.envs.rendering.scene import STATION_LABELS, Scene
from ssmash_gym.envs.rendering.traces import Rect, draw_traces, panel

if TYPE_CHECKING:
    import pygame

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Layout:
    """Where the parts of the picture lie, pixels.

    Attributes:
        view: The three-dimensional view.
        column: Numbers and gauges at the right.
        strip: Traces below the view.
        plan: View from above, in the view's upper left corner.
        text: Height of the ordinary text.
    """

    view: Rect
    column: Rect
    strip: Rect
    plan: Rect
    text: int

    @classmethod
    def of(cls, width: int, height: int) -> Layout:
        """The layout of a picture of this size."""
        column, strip = max(164, round(0.215 * width)), max(112, round(0.245 * height))
        wide = round(0.37 * (width - column))
        return cls(
            (0, 0, width - column, height - strip),
            (width - column, 0, column, height),
            (0, height - strip, width - column, strip),
            (8, 8, wide, round(0.4 * wide)),
            max(15, round(height / 31.0)),
        )


def draw_hud(surface: pygame.Surface, ink: Ink, layout: Layout, scene: Scene, labels: Sequence[Label]) -> None:
    """Everything but the view itself."""
    _labels(surface, ink, layout, labels)
    _plan(surface, ink, layout.plan, scene)
    draw_traces(surface, ink, layout.strip, scene)
    _column(surface, ink, layout.column, scene)
    if scene.outcome:
        _banner(surface, ink, layout.view, scene)


def _labels(surface: pygame.Surface, ink: Ink, layout: Layout, labels: Sequence[Label]) -> None:
    import pygame

    _, _, width, height = layout.view
    for label in labels:
        word = ink.word(label.text, label.colour, ink.height if label.beside else ink.small)
        x = label.place[0] - 0.5 * word.get_width()
        y = label.place[1] - 0.5 * word.get_height()
        if label.beside:  # the load must stay readable wherever the arrow points
            x += label.beside[0] * (0.5 * word.get_width() + 5.0)
            y += label.beside[1] * (0.5 * word.get_height() + 5.0)
            x = min(max(x, 6.0), width - word.get_width() - 6.0)
            y = min(max(y, 4.0), height - word.get_height() - 4.0)
            under = (round(x) - 4, round(y) - 2, word.get_width() + 8, word.get_height() + 4)
            pygame.draw.rect(surface, palette.PANEL, under, border_radius=3)
        elif not (0.0 < x < width - word.get_width() and 0.0 < y < height - word.get_height()):
            continue
        surface.blit(word, (round(x), round(y)))


def _column(surface: pygame.Surface, ink: Ink, rect: Rect, scene: Scene) -> None:
    x, y, width, height = rect
    panel(surface, rect)
    inner, row = (x + 10, width - 20), ink.height
    limits, track = scene.limits, scene.track
    roll, _, yaw = scene.angles_SH
    deck_roll, deck_pitch, _ = scene.angles_NS
    at = y + 8
    ink.write(surface, f"{scene.time_s:.1f} s", (x + 10, at), palette.TEXT, ink.large)
    ink.write(
        surface, f"of {scene.horizon_s:g} s", (x + width - 10, at + row // 2), palette.FAINT, ink.small, align=1.0
    )
    at += ink.large + 2
    length = max(track.goal_x_m - track.start_x_m, 1e-6)
    there = abs(scene.to_go_m) <= track.goal_tolerance_m
    done = (length - scene.to_go_m) / length
    gap = _Gauge(surface, ink, inner, round(max(row + 11, 0.056 * height)))
    at = gap.bar(at, "to go", f"{scene.to_go_m:z.2f} m", (0.0, 1.0), done, palette.GOOD if there else palette.LIFTED)
    straight = palette.GOOD if abs(yaw) <= track.yaw_tolerance_rad else palette.SOFT
    at = gap.needle(
        at, "yaw", f"{degrees(yaw):+z.1f} deg", 10.0, degrees(yaw), degrees(track.yaw_tolerance_rad), straight
    )
    centred = palette.GOOD if abs(scene.lateral) <= track.lateral_tolerance_m else palette.SOFT
    offset, tolerance = 100.0 * scene.lateral, 100.0 * track.lateral_tolerance_m
    at = gap.needle(at, "lateral", f"{offset:+z.1f} cm", 30.0, offset, tolerance, centred)
    tilt = palette.load_colour(abs(roll), limits.roll_rad)
    at = gap.needle(at, "roll", f"{degrees(roll):+z.1f} deg", degrees(limits.roll_rad), degrees(roll), 0.0, tilt)
    load = scene.probe_in_plane_N
    colour = palette.probe_colour(load, limits.probe_soft_N, limits.probe_cost_N)
    marks = [(limits.probe_soft_N, palette.SOFT), (limits.probe_cost_N, palette.BAD)]
    full = 1.5 * limits.probe_cost_N
    at = gap.bar(at, "probe", f"{load / 1e3:.1f} kN", (0.0, full), load, colour, marks)
    marks = [(limits.lift_off_N, palette.LIFTED), (limits.station_N, palette.BAD)]
    for name, tire in zip(STATION_LABELS, scene.wheels.station_load_N.tolist(), strict=True):
        colour = palette.tire_colour(tire, limits.station_N, limits.lift_off_N)
        at = gap.bar(at, f"{name} tires", f"{tire / 1e3:.1f} kN", (0.0, 1.15 * limits.station_N), tire, colour, marks)
    at = _claw_pad(surface, ink, (x + 10, at + 2, width - 20, round(3.7 * row)), scene)
    notes = [f"deck roll {degrees(deck_roll):+z.1f}  pitch {degrees(deck_pitch):+z.1f} deg", *scene.lines]
    for note in notes:
        if at + ink.small <= y + height - 4:
            ink.write(surface, note, (x + 10, at), palette.FAINT, ink.small)
        at += ink.small + 1


class _Gauge:
    """Rows of a name, a value and a bar."""

    def __init__(self, surface: pygame.Surface, ink: Ink, span: tuple[int, int], pitch: int) -> None:
        self.surface, self.ink, self.span, self.pitch = surface, ink, span, pitch

    def _words(self, at: int, name: str, value: str, colour: Colour) -> tuple[int, int, int, int]:
        left, width = self.span
        self.ink.write(self.surface, name, (left, at), palette.FAINT, self.ink.small)
        self.ink.write(self.surface, value, (left + width, at - 1), colour, align=1.0)
        return (left, at + self.ink.height - 2, width, 6)

    def bar(
        self,
        at: int,
        name: str,
        text: str,
        scale: tuple[float, float],
        value: float,
        colour: Colour,
        marks: Sequence[tuple[float, Colour]] = (),
    ) -> int:
        """A bar from the left end; returns where the next row begins."""
        import pygame

        left, top, width, height = self._words(at, name, text, palette.TEXT)
        pygame.draw.rect(self.surface, palette.GRID, (left, top, width, height))
        share = min(1.0, max(0.0, (value - scale[0]) / (scale[1] - scale[0])))
        pygame.draw.rect(self.surface, colour, (left, top, round(share * width), height))
        for mark, mark_colour in marks:
            column = left + round((mark - scale[0]) / (scale[1] - scale[0]) * width)
            pygame.draw.line(self.surface, mark_colour, (column, top - 2), (column, top + height + 1), 2)
        return at + self.pitch

    def needle(self, at: int, name: str, text: str, end: float, value: float, tolerance: float, colour: Colour) -> int:
        """A needle about the middle, with the tolerated range shaded; returns where the next row begins."""
        import pygame

        left, top, width, height = self._words(at, name, text, palette.TEXT)
        middle = left + width // 2
        pygame.draw.rect(self.surface, palette.GRID, (left, top, width, height))
        half = round(min(1.0, tolerance / end) * width / 2)
        pygame.draw.rect(self.surface, (40, 98, 68), (middle - half, top, 2 * half + 1, height))
        column = middle + round(min(1.0, max(-1.0, value / end)) * (width / 2 - 2))
        pygame.draw.line(self.surface, palette.FAINT, (middle, top), (middle, top + height - 1))
        pygame.draw.rect(self.surface, colour, (column - 2, top - 2, 5, height + 4), border_radius=1)
        return at + self.pitch


def _claw_pad(surface: pygame.Surface, ink: Ink, rect: Rect, scene: Scene) -> int:
    """The command as a dot on a pad (up: forward, right: to starboard) and the claw's speed; returns the next row."""
    import pygame

    left, top, width, height = rect
    side = min(height - 6, width // 2)
    x, y = left + side // 2, top + side // 2
    pygame.draw.rect(surface, palette.PLOT, (left, top, side, side))
    pygame.draw.rect(surface, palette.PANEL_EDGE, (left, top, side, side), 1)
    pygame.draw.line(surface, palette.GRID, (left + 1, y), (left + side - 2, y))
    pygame.draw.line(surface, palette.GRID, (x, top + 1), (x, top + side - 2))
    forward, starboard = (min(1.0, max(-1.0, float(c))) for c in scene.claw_command)
    dot = (x + starboard * (side / 2 - 5), y - forward * (side / 2 - 5))
    pygame.draw.line(surface, palette.PROBE, (x, y), dot, 2)
    pygame.draw.circle(surface, palette.PROBE, dot, 4)
    words, column = ink.small + 2, left + side + 8
    texts = [
        ("claw command", palette.FAINT),
        (f"{float(scene.claw_command[0]):+z.2f}  {float(scene.claw_command[1]):+z.2f}", palette.TEXT),
        ("speed [mm/s]", palette.FAINT),
        (f"{1e3 * float(scene.claw_velocity_S[0]):+z.0f}  {1e3 * float(scene.claw_velocity_S[1]):+z.0f}", palette.TEXT),
    ]
    for k, (text, colour) in enumerate(texts):
        ink.write(surface, text, (column, top + k * words), colour, ink.small)
    return top + max(side, 4 * words) + 6


def _plan(surface: pygame.Surface, ink: Ink, rect: Rect, scene: Scene) -> None:
    """The helicopter on the track from above: forward to the right, starboard down; corridor, goal, tires, force."""
    import pygame

    left, top, width, height = rect
    panel(surface, rect)
    surface.set_clip(rect)  # a helicopter that left the deck must not be drawn over the view
    track = scene.track
    ahead, behind = track.goal_x_m + 6.5, track.start_x_m - 11.0
    scale = min((width - 8) / (ahead - behind), (height - 8) / 6.6)
    origin = np.array([left + 0.5 * width - scale * 0.5 * (ahead + behind), top + 0.5 * height])

    def place(points: Array) -> list[tuple[float, float]]:
        pixels = np.clip(origin + scale * points[:, :2], -FAR_PX, FAR_PX)
        return [(float(a), float(b)) for a, b in pixels]

    def line(x0: float, y0: float, x1: float, y1: float, colour: Colour, thick: int = 1) -> None:
        a, b = place(np.array([[x0, y0], [x1, y1]]))
        pygame.draw.line(surface, colour, a, b, thick)

    door = track.hangar_door_x_m
    body = place(planform(scene.airframe) @ scene.R_SH[:2, :2].T + scene.r_SH_S[:2])
    pygame.draw.polygon(surface, (58, 70, 84), body)
    line(behind, 0.0, ahead, 0.0, palette.FAINT)
    for sign in (-1.0, 1.0):
        line(behind, sign * track.corridor_m, door, sign * track.corridor_m, palette.SOFT)
        line(door, sign * track.corridor_m, door, sign * track.door_corridor_m, palette.SOFT)
        line(door, sign * track.door_corridor_m, ahead, sign * track.door_corridor_m, palette.SOFT)
    line(track.goal_x_m, -1.2, track.goal_x_m, 1.2, palette.GOOD, 2)
    limits, station = scene.limits, scene.wheels.station_load_N
    for at, k in zip(place(scene.wheels.r_ST_S), scene.wheels.station.tolist(), strict=True):
        colour = palette.tire_colour(float(station[k]), limits.station_N, limits.lift_off_N)
        pygame.draw.circle(surface, colour, at, max(2, round(0.22 * scale)))
    claw, tip = place(np.stack([scene.r_SC_S, scene.r_SB_S + 3e-4 * scene.in_plane_force_S]))
    colour = palette.probe_colour(scene.probe_in_plane_N, limits.probe_soft_N, limits.probe_cost_N)
    pygame.draw.line(surface, colour, claw, tip, 2)
    pygame.draw.circle(surface, palette.PROBE, claw, max(3, round(0.3 * scale)))
    surface.set_clip(None)
    pygame.draw.rect(surface, palette.PANEL_EDGE, rect, 1)


def _banner(surface: pygame.Surface, ink: Ink, view: Rect, scene: Scene) -> None:
    import pygame

    word = ink.word(scene.outcome, palette.TEXT, ink.large)
    width, height = word.get_width() + 28, word.get_height() + 14
    x, y = view[0] + (view[2] - width) // 2, view[1] + view[3] - height - 14
    colour = (28, 112, 66) if scene.success else (150, 38, 34)
    pygame.draw.rect(surface, colour, (x, y, width, height), border_radius=5)
    pygame.draw.rect(surface, palette.TEXT, (x, y, width, height), 1, border_radius=5)
    surface.blit(word, (x + 14, y + 7))
