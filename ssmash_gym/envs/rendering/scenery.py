"""What stands still: sea and sky in the inertial frame, deck, markings and hangar in the deck frame.

The hangar is cut away: its starboard wall and its roof are drawn as lines, so that the helicopter is seen inside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering import palette
from ssmash_gym.envs.rendering.camera import Camera, Point, half_plane
from ssmash_gym.envs.rendering.geometry import Colour, Mesh, box, merge
from ssmash_gym.envs.rendering.scene import Track

Array = NDArray[np.float64]

# Proportions of the drawn ship, metres: for the eye only.
HALF_BEAM: Final = 6.4
AFT_X: Final = -15.0
DECK_ABOVE_SEA: Final = 5.5
HANGAR_LENGTH: Final = 11.0
HANGAR_HALF_WIDTH: Final = 5.0
HANGAR_HEIGHT: Final = 6.0
DOOR_HEIGHT: Final = 5.3
DOOR_MARGIN: Final = 0.4  # from the narrow corridor's edge to the door post
HORIZON_BANDS: Final = 14


@dataclass(frozen=True, eq=False)
class Scenery:
    """The ship above the deck edge, S axes.

    Attributes:
        plates: Large faces (k, 4, 3), in the order in which they are painted.
        plate_colours: One colour for each.
        markings: Paint on the deck (m, 4, 3), over the helicopter's shadow.
        marking_colours: One colour for each.
        solids: Door frame, sorted with the helicopter.
        wires: Cut-away edges (w, 2, 3).
        ticks: Text and place of the track's metre marks.
    """

    plates: Array
    plate_colours: list[Colour]
    markings: Array
    marking_colours: list[Colour]
    solids: Mesh
    wires: Array
    ticks: list[tuple[str, Array]]


def _rectangle(x0: float, x1: float, y0: float, y1: float, z: float = 0.0) -> list[list[float]]:
    return [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]


def _dashes(x0: float, x1: float, y: float, half: float) -> list[list[list[float]]]:
    """Dashes of 0.6 m with gaps of 0.4 m."""
    starts = np.arange(x0, x1 - 1e-9, 1.0)
    return [_rectangle(float(x), min(float(x) + 0.6, x1), y - half, y + half) for x in starts]


def _markings(track: Track) -> list[tuple[list[list[float]], Colour]]:
    door, end = track.hangar_door_x_m, track.hangar_door_x_m + HANGAR_LENGTH
    amber, slot = (214, 170, 60), (38, 42, 47)
    paint: list[tuple[list[list[float]], Colour]] = []
    for sign in (-1.0, 1.0):
        paint += [(dash, amber) for dash in _dashes(AFT_X + 2.0, door, sign * track.corridor_m, 0.06)]
        paint += [(dash, amber) for dash in _dashes(door, end, sign * track.door_corridor_m, 0.06)]
        paint.append((_rectangle(AFT_X + 1.0, end, sign * 0.3 - 0.035, sign * 0.3 + 0.035), (178, 182, 184)))
    paint.append((_rectangle(track.start_x_m - 4.0, end - 1.0, -0.09, 0.09), slot))
    goal, wide = track.goal_x_m, track.corridor_m - 0.15
    paint.append((_rectangle(goal - 0.16, goal + 0.16, -wide, wide), (46, 140, 88)))
    paint.append((_rectangle(goal - track.goal_tolerance_m, goal + track.goal_tolerance_m, -wide, wide), palette.GOOD))
    first, last = round(track.start_x_m), round(track.goal_x_m)
    for metre in range(first, last + 1):
        long = 0.4 if metre % 2 == 0 else 0.22
        paint.append(
            (
                _rectangle(metre - 0.04, metre + 0.04, track.corridor_m + 0.1, track.corridor_m + 0.1 + long),
                palette.PAINT,
            )
        )
    return paint


def _plates(track: Track) -> list[tuple[list[list[float]], Colour]]:
    door, end = track.hangar_door_x_m, track.hangar_door_x_m + HANGAR_LENGTH
    side, top, gap = -HANGAR_HALF_WIDTH, -HANGAR_HEIGHT, track.door_corridor_m + DOOR_MARGIN
    bulkhead = [[end, side, 0.0], [end, -side, 0.0], [end, -side, top], [end, side, top]]
    wall = [[door, side, 0.0], [end, side, 0.0], [end, side, top], [door, side, top]]
    face = [[door, side, 0.0], [door, -gap, 0.0], [door, -gap, top], [door, side, top]]
    return [
        (_rectangle(AFT_X, end + 1.0, -HALF_BEAM, HALF_BEAM), palette.DECK),
        (_rectangle(AFT_X + 0.25, door - 0.1, -HALF_BEAM + 0.25, -HALF_BEAM + 0.4), palette.PAINT),
        (_rectangle(AFT_X + 0.25, door - 0.1, HALF_BEAM - 0.4, HALF_BEAM - 0.25), palette.PAINT),
        (_rectangle(AFT_X + 0.25, AFT_X + 0.4, -HALF_BEAM + 0.25, HALF_BEAM - 0.25), palette.PAINT),
        (_rectangle(door, end, -HANGAR_HALF_WIDTH, HANGAR_HALF_WIDTH), (74, 80, 86)),
        (bulkhead, (78, 88, 98)),
        (wall, (92, 103, 113)),
        (face, (112, 124, 135)),
    ]


def _door_frame(track: Track) -> Mesh:
    """Two posts in short pieces, for a good order of painting, and the lintel."""
    door, gap, yellow, black = track.hangar_door_x_m, track.door_corridor_m + DOOR_MARGIN, (236, 190, 62), (52, 56, 62)
    parts = []
    levels = np.linspace(0.0, -DOOR_HEIGHT, 8)
    for side in (-1.0, 1.0):
        y0, y1 = sorted((side * gap, side * (gap + 0.22)))
        for k in range(len(levels) - 1):
            colour = yellow if k % 2 == 0 else black
            parts.append(box((door - 0.12, y0, float(levels[k + 1])), (door + 0.12, y1, float(levels[k])), colour))
    edges = np.linspace(-gap - 0.22, gap + 0.22, 5)
    for left, right in pairwise(edges):
        low, high = (door - 0.12, float(left), -DOOR_HEIGHT - 0.3), (door + 0.12, float(right), -DOOR_HEIGHT)
        parts.append(box(low, high, yellow))
    return merge(parts)


def _wires(track: Track) -> Array:
    door, end = track.hangar_door_x_m, track.hangar_door_x_m + HANGAR_LENGTH
    side, top, gap = HANGAR_HALF_WIDTH, -HANGAR_HEIGHT, track.door_corridor_m + DOOR_MARGIN
    near = [[door, side, 0.0], [door, side, top], [end, side, top], [end, side, 0.0]]
    lines = [[near[i], near[i + 1]] for i in range(3)]
    lines.append([[door, side, 0.0], [end, side, 0.0]])
    lines.append([[door, -side, top], [door, side, top]])
    lines.append([[door, -gap, top], [door, -gap, -DOOR_HEIGHT]])
    return np.array(lines)


@lru_cache(maxsize=8)
def scenery(track: Track) -> Scenery:
    """The ship for one track."""
    plates, markings = _plates(track), _markings(track)
    first, last = round(track.start_x_m), round(track.goal_x_m)
    ticks = [(str(x), np.array([float(x), track.corridor_m + 0.95, 0.0])) for x in range(first, last + 1) if x % 2 == 0]
    return Scenery(
        np.array([face for face, _ in plates]),
        [colour for _, colour in plates],
        np.array([face for face, _ in markings]),
        [colour for _, colour in markings],
        _door_frame(track),
        _wires(track),
        ticks,
    )


def hull(track: Track, R_NS: Array, r_NS_N: Array) -> tuple[Array, list[Colour]]:
    """Sides of the ship from the deck's edge straight down to the sea, S axes, (k, 4, 3).

    The foot of each edge is where the deck's normal through it meets the sea's surface, so the waterline moves over
    the hull as the ship heaves and rolls.
    """
    end = track.hangar_door_x_m + HANGAR_LENGTH + 1.0
    rim = np.array([[AFT_X, -HALF_BEAM, 0.0], [AFT_X, HALF_BEAM, 0.0], [end, HALF_BEAM, 0.0]])
    down_N = R_NS[:, 2]
    height = DECK_ABOVE_SEA - (r_NS_N[2] + rim @ R_NS[2])  # of each corner over the sea
    foot = rim.copy()
    foot[:, 2] += np.maximum(height, 0.0) / down_N[2]
    sides = [[rim[i], rim[i + 1], foot[i + 1], foot[i]] for i in (0, 1)]
    foam = foot - np.array([0.0, 0.0, 0.18])
    waterline = [[foam[i], foam[i + 1], foot[i + 1], foot[i]] for i in (0, 1)]
    return np.array(sides + waterline), [(62, 74, 88), palette.HULL, palette.FOAM, palette.FOAM]


def backdrop(camera_N: Camera, size: Point) -> list[tuple[list[Point], Colour]]:
    """Sky and sea as bands of equal depression under the horizon, each a pixel polygon with its colour.

    The horizon is where a pixel's ray has no vertical part, so it tilts with the camera.
    """
    width, height = size
    down_C, forward_N = camera_N.R_CA[:, 2], camera_N.R_CA[2].copy()
    forward_N[2] = 0.0
    ahead_C = camera_N.R_CA @ (forward_N / np.linalg.norm(forward_N))
    depressions = np.concatenate(
        [[-9.0], -np.geomspace(0.5, 0.01, 8), [0.0], np.geomspace(0.006, 0.8, HORIZON_BANDS), [9.0]]
    )
    screen = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    bands = []
    horizon = 9  # the first band under it
    for k, (low, high) in enumerate(pairwise(depressions)):
        band = screen
        for row in (down_C - low * ahead_C, high * ahead_C - down_C):
            a, b = row[0] / camera_N.focal_px, row[1] / camera_N.focal_px
            c = row[2] - a * camera_N.centre_px[0] - b * camera_N.centre_px[1]
            band = half_plane(band, a, b, c) if len(band) > 2 else []
        sky = palette.blend(*palette.SKY, (k / (horizon - 1)) ** 1.5)
        sea = palette.blend(*palette.SEA, ((k - horizon) / HORIZON_BANDS) ** 0.6) if k >= horizon else sky
        if len(band) > 2:
            bands.append((band, sea))
    return bands


@lru_cache(maxsize=1)
def _wave_field() -> tuple[Array, Array]:
    """Places and lengths of the crests that are drawn on the sea, the same in every picture."""
    rng = np.random.default_rng(20130)
    return rng.uniform((-40.0, -260.0), (300.0, 45.0), (130, 2)), rng.uniform(1.5, 5.0, 130)


def crests(time_s: float, ship_speed_m_s: float) -> Array:
    """Wave crests on the sea's surface, N axes, (k, 4, 3); they stream aft at the ship's speed."""
    place, length = _wave_field()
    x = (place[:, 0] + 40.0 - ship_speed_m_s * time_s) % 340.0 - 40.0
    thick = 0.05 + 0.06 * length
    corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    z = np.full(len(x), DECK_ABOVE_SEA)
    return np.stack([np.stack([x + i * thick, place[:, 1] + j * length, z], axis=1) for i, j in corners], axis=1)


def flat(points: Array | Sequence[Sequence[float]]) -> Array:
    """Points given by x and y, laid on the deck (k, 3)."""
    plane = np.asarray(points, dtype=np.float64)
    return np.concatenate([plane, np.zeros((len(plane), 1))], axis=1)
