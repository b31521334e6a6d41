"""The view of the ship and the helicopter: painter's algorithm on a surface.

Order: sky and sea, hull, deck, shadow, markings, contact patches; then all solid faces sorted by their distance; then,
on top on purpose, the probe and its force.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering import palette
from ssmash_gym.envs.rendering.camera import NEAR_M, Camera, Point
from ssmash_gym.envs.rendering.geometry import (
    Colour,
    Mesh,
    airframe_mesh,
    claw_mesh,
    cylinders,
    merge,
    mesh,
    normals,
    planform,
    unit_cylinder,
)
from ssmash_gym.envs.rendering.scene import Scene
from ssmash_gym.envs.rendering.scenery import backdrop, crests, flat, hull, scenery

if TYPE_CHECKING:
    import pygame

Array = NDArray[np.float64]

WHEEL_CORNERS: Final = 14
ROD_CORNERS: Final = 6
ARROW_M_PER_N: Final = 2.0e-4
ARROW_LONGEST_M: Final = 8.0
_SUN: Final = np.array([-0.42, 0.48, -0.77]) / np.linalg.norm([-0.42, 0.48, -0.77])  # towards it, S axes
_AMBIENT: Final = 0.52


@dataclass(frozen=True)
class Label:
    """Text that belongs to a point of the view; the head-up display writes it.

    Attributes:
        text: What to write.
        place: Pixel of the point, (x, y).
        colour: Of the text.
        beside: Unit direction in which a boxed text lies from the point; None for a text on the point, without a box.
    """

    text: str
    place: Point
    colour: Colour
    beside: Point | None = None


class Backdrop:
    """Sky and sea, painted anew only when the camera turns.

    Args:
        size: Width and height of the view [px].
    """

    def __init__(self, size: tuple[int, int]) -> None:
        import pygame

        self.surface = pygame.Surface(size, 0, 32)
        self._painted_for = b""

    def seen(self, camera_N: Camera) -> pygame.Surface:
        """Sky and sea as this camera sees them; where it is does not matter."""
        import pygame

        turned = camera_N.R_CA.tobytes()
        if turned != self._painted_for:
            for band, colour in backdrop(camera_N, self.surface.get_size()):
                pygame.draw.polygon(self.surface, colour, band)
            self._painted_for = turned
        return self.surface


def paint(surface: pygame.Surface, scene: Scene, camera_N: Camera, distance: pygame.Surface) -> list[Label]:
    """Paint the whole view.

    Args:
        surface: Where; all of it is covered.
        scene: What.
        camera_N: From where, N axes.
        distance: Sky and sea, as large as the view.

    Returns:
        The labels that belong to points of the picture, in its pixels.
    """
    import pygame

    camera_S = camera_N.carried(scene.R_NS.T, -scene.R_NS.T @ scene.r_NS_N)
    ship = scenery(scene.track)
    surface.blit(distance, (0, 0))
    waves = crests(scene.time_s, scene.ship_speed_m_s)
    _faces(surface, camera_N, waves, [palette.FOAM] * len(waves), skip_tiny=True)
    _faces(surface, camera_S, *hull(scene.track, scene.R_NS, scene.r_NS_N))
    _faces(surface, camera_S, ship.plates, ship.plate_colours)
    shadow = planform(scene.airframe) @ scene.R_SH[:2, :2].T + scene.r_SH_S[:2]
    _fill(surface, palette.DECK_SHADOW, camera_S.polygon(flat(shadow)))
    _faces(surface, camera_S, ship.markings, ship.marking_colours)
    _contact_patches(surface, scene, camera_S)
    _solids(surface, _solid_mesh(scene, ship.solids), camera_S)
    for a, b in camera_S.project(ship.wires)[0]:
        pygame.draw.line(surface, (206, 214, 222), a, b, 2)
    labels = [
        Label(text, (float(at[0]), float(at[1])), palette.PAINT)
        for text, at in ((text, camera_S.project(place)[0]) for text, place in ship.ticks)
    ]
    return labels + _probe(surface, scene, camera_S)


def _faces(
    surface: pygame.Surface, camera: Camera, faces: Array, colours: list[Colour], skip_tiny: bool = False
) -> None:
    """Flat faces (k, 4, 3) in the given order."""
    import pygame

    points_C = camera.to_camera(faces)
    pixels = camera.to_pixels(points_C)
    nearest, farthest = points_C[..., 2].min(axis=1), points_C[..., 2].max(axis=1)
    shown = farthest > NEAR_M
    if skip_tiny:
        low, high = pixels.min(axis=1), pixels.max(axis=1)
        shown = (nearest > NEAR_M) & (high > 0.0).all(axis=1) & (low < surface.get_size()).all(axis=1)
    corners = pixels.tolist()
    for k in np.flatnonzero(shown).tolist():
        if nearest[k] > NEAR_M:
            pygame.draw.polygon(surface, colours[k], corners[k])
        else:
            _fill(surface, colours[k], camera.polygon(faces[k]))


def _fill(surface: pygame.Surface, colour: Colour, points: Sequence[Point]) -> None:
    """A polygon of which clipping may have left nothing."""
    import pygame

    if len(points) > 2:
        pygame.draw.polygon(surface, colour, points)


def _contact_patches(surface: pygame.Surface, scene: Scene, camera_S: Camera) -> None:
    """A disc on the deck under each tire, coloured by its station's load; a ring where the load counts as lifted."""
    import pygame

    wheels, limits = scene.wheels, scene.limits
    station = wheels.station_load_N
    angle = 2.0 * np.pi * np.arange(18) / 18
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(18)], axis=1)
    size = np.stack([0.62 * wheels.diameter_m, 0.2 + 0.62 * wheels.width_m, np.zeros(len(wheels.load_N))], axis=1)
    ground = wheels.r_ST_S * (1.0, 1.0, 0.0)
    pixels, depth = camera_S.project(ground[:, None, :] + circle * size[:, None, :])
    for k, points in enumerate(pixels.tolist()):
        load = float(station[wheels.station[k]])
        if depth[k].min() > NEAR_M:
            lifted = load < limits.lift_off_N
            colour = palette.tire_colour(load, limits.station_N, limits.lift_off_N)
            pygame.draw.polygon(surface, colour, points, 3 if lifted else 0)


def _discs(centre: Array, rings: Array, colours: Array, bias: float) -> Mesh:
    """Discs (n, k, 3) as fans of k quadrilaterals each about their centres; they face both ways."""
    n, k = rings.shape[:2]
    start = (k + 1) * np.arange(n)[:, None]
    after = start + 1 + (np.arange(0, k, 2) + 2) % k
    first = start + 1 + np.arange(0, k, 2)
    faces = np.stack([np.broadcast_to(start, first.shape), first, first + 1, after], axis=2).reshape(-1, 4)
    vertices = np.concatenate([centre[:, None, :], rings], axis=1).reshape(-1, 3)
    return mesh(vertices, faces, np.repeat(colours, k // 2, axis=0), bias, two_sided=True)


def _wheel_meshes(scene: Scene) -> list[Mesh]:
    """Tires flattened where they meet the deck, rims coloured by load, S axes."""
    wheels, limits, n = scene.wheels, scene.limits, len(scene.wheels.load_N)
    if n == 0:
        return []
    station = wheels.station_load_N[wheels.station]
    rim = np.array([palette.tire_colour(float(load), limits.station_N, limits.lift_off_N) for load in station])
    _, sides = unit_cylinder(WHEEL_CORNERS)
    parts = []
    for radius, width, sidewall, bias in (
        (0.5 * wheels.diameter_m, wheels.width_m, np.tile(np.array(palette.TIRE, dtype=float), (n, 1)), 0.0),
        (0.27 * wheels.diameter_m, wheels.width_m + 0.02, rim, 0.1),
    ):
        vertices = cylinders(wheels.r_ST_S, wheels.axle_S, radius, width, WHEEL_CORNERS)
        vertices[..., 2] = np.minimum(vertices[..., 2], 0.0)
        if bias == 0.0:
            tread = (sides + 2 * WHEEL_CORNERS * np.arange(n)[:, None, None]).reshape(-1, 4)
            parts.append(mesh(vertices.reshape(-1, 3), tread, (52, 56, 62)))
        for sign, ring in ((-0.5, vertices[:, :WHEEL_CORNERS]), (0.5, vertices[:, WHEEL_CORNERS:])):
            hub = wheels.r_ST_S + sign * width[:, None] * wheels.axle_S
            parts.append(_discs(hub, ring, sidewall, bias + 0.02))
    return parts


def _rods(start: Array, end: Array, radius: Array, colour: Colour) -> Mesh:
    axis = end - start
    length = np.maximum(np.linalg.norm(axis, axis=1), 1e-6)
    vertices = cylinders(0.5 * (start + end), axis, radius, length, ROD_CORNERS)
    _, sides = unit_cylinder(ROD_CORNERS)
    faces = (sides + 2 * ROD_CORNERS * np.arange(len(start))[:, None, None]).reshape(-1, 4)
    return mesh(vertices.reshape(-1, 3), faces, colour)


def _solid_mesh(scene: Scene, standing: Mesh) -> Mesh:
    """All solid bodies of the picture, S axes."""
    wheels = scene.wheels
    body = airframe_mesh(scene.airframe)
    placed = Mesh(body.vertices @ scene.R_SH.T + scene.r_SH_S, body.faces, body.colour, body.bias, body.two_sided)
    claw = claw_mesh(-float(scene.r_SC_S[2]))
    upper = 0.45 * wheels.r_SO_S + 0.55 * wheels.r_SW_S
    parts = [
        standing,
        placed,
        Mesh(claw.vertices + scene.r_SC_S * (1.0, 1.0, 0.0), claw.faces, claw.colour, claw.bias, claw.two_sided),
        _rods(wheels.r_SO_S, upper, np.full(len(upper), 0.11), (150, 158, 166)),
        _rods(upper, wheels.r_SW_S, np.full(len(upper), 0.07), palette.STRUT),
        *_wheel_meshes(scene),
    ]
    if len(wheels.load_N):
        carriage = wheels.r_SW_S[wheels.station]
        parts.append(_rods(carriage, wheels.r_ST_S, np.full(len(carriage), 0.05), (150, 158, 166)))
    return merge(parts)


def _solids(surface: pygame.Surface, solid: Mesh, camera_S: Camera) -> None:
    """Faces that look at the camera, farthest first, shaded by the sun."""
    import pygame

    corners = solid.vertices[solid.faces]
    centre = corners.mean(axis=1)
    normal = normals(corners)
    towards = camera_S.r_AC_A - centre
    distance = np.sqrt((towards * towards).sum(axis=1))
    facing = (normal * towards).sum(axis=1)
    normal = np.where(facing[:, None] < 0.0, -normal, normal)
    pixels, depth = camera_S.project(solid.vertices)
    shown = ((facing > 0.0) | solid.two_sided) & (depth[solid.faces].min(axis=1) > NEAR_M)
    light = _AMBIENT + (1.0 - _AMBIENT) * np.maximum(normal @ _SUN, 0.0)
    colours = np.clip(solid.colour * light[:, None], 0.0, 255.0).astype(int)
    order = np.flatnonzero(shown)
    order = order[np.argsort(solid.bias[order] - distance[order], kind="stable")]
    draw: Any = pygame.draw.polygon
    for colour, points in zip(colours[order].tolist(), pixels[solid.faces[order]].tolist(), strict=True):
        draw(surface, colour, points)


def _probe(surface: pygame.Surface, scene: Scene, camera_S: Camera) -> list[Label]:
    """The probe's rod and the in-plane force on the helicopter, on top of everything."""
    import pygame

    load, limits = scene.probe_in_plane_N, scene.limits
    thick = max(2, ceil(camera_S.focal_px / 320.0))
    force = scene.in_plane_force_S * ARROW_M_PER_N
    force = force * min(1.0, ARROW_LONGEST_M / max(float(np.linalg.norm(force)), 1e-9))
    ends, depth = camera_S.project(np.stack([scene.r_SA_S, scene.r_SB_S, scene.r_SB_S + force]))
    if depth.min() < NEAR_M:
        return []
    mount, tip, head = ends
    pygame.draw.line(surface, (20, 24, 30), mount, tip, 3 * thick)
    pygame.draw.line(surface, palette.PROBE, mount, tip, 2 * thick - 1)
    pygame.draw.circle(surface, (20, 24, 30), tip, 2.2 * thick)
    pygame.draw.circle(surface, palette.PROBE if scene.captured else palette.BAD, tip, 1.5 * thick)
    colour = palette.probe_colour(load, limits.probe_soft_N, limits.probe_cost_N)
    reach = float(np.hypot(*(head - tip)))
    if not scene.captured:
        return [Label("probe free", (float(tip[0]), float(tip[1]) - 3.0 * thick), palette.BAD, (0.0, -1.0))]
    along = (head - tip) / reach if reach > 1.0 else np.array([0.0, -1.0])
    if reach > 1.0:
        _arrow(surface, tip, head, along, 1.1 * thick, (16, 20, 26), 1.2)
        _arrow(surface, tip, head, along, 1.1 * thick, colour, 0.0)
    beyond = head + 3.0 * thick * along
    place, beside = (float(beyond[0]), float(beyond[1])), (float(along[0]), float(along[1]))
    return [Label(f"{load / 1e3:.1f} kN", place, colour, beside)]


def _arrow(
    surface: pygame.Surface, tail: Array, head: Array, along: Array, half: float, colour: Colour, rim: float
) -> None:
    """A flat arrow in the picture's plane; `rim` widens it by as many half-widths / 2 for an outline."""
    import pygame

    across = np.array([-along[1], along[0]])
    grown = half * (1.0 + 0.5 * rim)
    tip, neck = head + along * 0.8 * rim * half, head - along * min(5.0 * half, float(np.hypot(*(head - tail))))
    barb, tail = neck - along * 0.4 * rim * half, tail - along * 0.4 * rim * half
    outline = [
        tail + grown * across,
        neck + grown * across,
        barb + (grown + 1.7 * half) * across,
        tip,
        barb - (grown + 1.7 * half) * across,
        neck - grown * across,
        tail - grown * across,
    ]
    pygame.draw.polygon(surface, colour, [(float(x), float(y)) for x, y in outline])
