"""Meshes: the helicopter's body, wheels and rods, the claw. Quadrilateral faces, outward normals, metres.

Shapes are for the eye only; the places of wheels, struts, claw and probe are those of the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs.rendering.scene import Airframe

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Colour = tuple[int, int, int]
Station = tuple[float, float, float, float, float]  # x, centre y, half width, top z, bottom z of a loft's section

AROUND: Final = 12  # corners of a loft's section
BODY: Final[Colour] = (196, 206, 215)
BELLY: Final[Colour] = (158, 169, 180)
GLASS: Final[Colour] = (38, 54, 72)
ACCENT: Final[Colour] = (232, 118, 44)
DARK: Final[Colour] = (72, 80, 90)
BLADE: Final[Colour] = (84, 92, 102)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Faces of four corners each.

    Attributes:
        vertices: (v, 3) [m].
        faces: Corner numbers (f, 4); a triangle repeats its last corner.
        colour: Base colours (f, 3), 0-255.
        bias: Metres by which a face is taken nearer to the camera when faces are sorted (f,).
        two_sided: Whether a face is seen from behind too (f,).
    """

    vertices: Array
    faces: Indices
    colour: Array
    bias: Array
    two_sided: NDArray[np.bool_]


def mesh(
    vertices: Array,
    faces: Indices | Sequence[Sequence[int]],
    colour: object,
    bias: float = 0.0,
    two_sided: bool = False,
) -> Mesh:
    """A mesh of one bias, with one colour for all faces or one for each."""
    corners = np.asarray(faces, dtype=np.intp)
    n = len(corners)
    colours = np.broadcast_to(np.asarray(colour, dtype=np.float64), (n, 3))
    return Mesh(np.asarray(vertices, dtype=np.float64), corners, colours, np.full(n, bias), np.full(n, two_sided))


def merge(parts: Sequence[Mesh]) -> Mesh:
    """All parts in one mesh."""
    starts = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return Mesh(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + start for p, start in zip(parts, starts, strict=True)]),
        np.concatenate([p.colour for p in parts]),
        np.concatenate([p.bias for p in parts]),
        np.concatenate([p.two_sided for p in parts]),
    )


def normals(corners: Array) -> Array:
    """Unit normals of faces given by their corners (f, 4, 3), (f, 3)."""
    a, b = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    n = cross(a, b)
    return np.asarray(n / np.maximum(np.sqrt((n * n).sum(axis=1, keepdims=True)), 1e-12))


def cross(a: Array, b: Array) -> Array:
    """Cross products of rows (n, 3); a third of the time that ``np.cross`` takes for a few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _outward(vertices: Array, faces: Indices, within: Array) -> Indices:
    """The faces, turned so that each normal points away from its point in `within` (f, 3) or (3,)."""
    corners = vertices[faces]
    inward = ((corners.mean(axis=1) - within) * normals(corners)).sum(axis=1) < 0.0
    return np.where(inward[:, None], faces[:, ::-1], faces)


def block(corners: Array, colour: object, bias: float = 0.0) -> Mesh:
    """A convex body of eight corners: a quadrilateral, and the opposite one in the same order."""
    vertices = np.asarray(corners, dtype=np.float64)
    sides = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    faces = np.array([[0, 1, 2, 3], [4, 5, 6, 7], *sides], dtype=np.intp)
    return mesh(vertices, _outward(vertices, faces, vertices.mean(axis=0)), colour, bias)


def box(low: Sequence[float], high: Sequence[float], colour: object, bias: float = 0.0) -> Mesh:
    """A box between two corners."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    rim = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return block(np.array([(x, y, z0) for x, y in rim] + [(x, y, z1) for x, y in rim]), colour, bias)


def loft(sections: Sequence[Station], colour: Colour, under: Colour | None = None, roundness: float = 0.5) -> Mesh:
    """A closed body through rounded sections across x. Faces run along the sections, then round each; two caps last."""
    angle = np.radians(15.0 + 30.0 * np.arange(AROUND))
    across = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** roundness
    down = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** roundness
    rings = [
        np.stack([np.full(AROUND, x), y + w * across, 0.5 * (top + low) + 0.5 * (low - top) * down], axis=1)
        for x, y, w, top, low in sections
    ]
    vertices, n = np.concatenate(rings), AROUND
    around = [
        [s * n + k, s * n + (k + 1) % n, (s + 1) * n + (k + 1) % n, (s + 1) * n + k]
        for s in range(len(sections) - 1)
        for k in range(n)
    ]
    last = (len(sections) - 1) * n
    caps = [
        [first + k, first + k + 1, first + n - 2 - k, first + n - 1 - k]
        for first in (0, last)
        for k in range(n // 2 - 1)
    ]
    faces = np.array(around + caps, dtype=np.intp)
    centres = np.array([ring.mean(axis=0) for ring in rings])
    middle = np.repeat(0.5 * (centres[:-1] + centres[1:]), n, axis=0)
    inner = np.repeat(centres[[1, -2]], n // 2 - 1, axis=0)
    faces = _outward(vertices, faces, np.concatenate([middle, inner]))
    lower = normals(vertices[faces])[:, 2] > 0.4
    return mesh(vertices, faces, np.where(lower[:, None], under or colour, colour))


def _painted(body: Mesh, faces: Sequence[int], colour: Colour) -> Mesh:
    colours = body.colour.copy()
    colours[list(faces)] = colour
    return Mesh(body.vertices, body.faces, colours, body.bias, body.two_sided)


def _fuselage(a: Airframe) -> Mesh:
    """Nose, cabin and tail boom in one loft, with the glass of the cockpit and the band on the boom."""
    n, w, roof, floor, aft, tail = a.nose_x, a.half_width, a.roof_z, a.floor_z, a.cabin_aft_x, a.tail_x
    front = [
        (n, 0.0, 0.22 * w, floor - 0.85, floor - 0.4),
        (n - 0.35, 0.0, 0.62 * w, floor - 1.15, floor - 0.1),
        (n - 1.0, 0.0, 0.85 * w, floor - 1.45, floor),
        (n - 2.0, 0.0, w, roof, floor),
    ]
    cabin = [(float(x), 0.0, w, roof, floor) for x in np.linspace(n - 2.0, aft, 6)[1:]]
    boom = [
        (aft - 1.2, 0.0, 0.78 * w, roof + 0.05, floor - 0.55),
        (aft - 2.4, 0.0, 0.45 * w, roof + 0.12, roof + 1.1),
        (0.5 * (aft - 2.4 + tail), 0.0, 0.34 * w, roof + 0.1, roof + 0.85),
        (tail + 1.9, 0.0, 0.27 * w, roof + 0.05, roof + 0.7),
        (tail + 1.3, 0.0, 0.25 * w, roof + 0.03, roof + 0.65),
        (tail, 0.0, 0.2 * w, roof, roof + 0.5),
    ]
    sections = [*front, *cabin, *boom]
    shell = loft(sections, BODY, BELLY)
    upper = [k for k in range(AROUND) if 4 < k < 12]  # faces from one side over the roof to the other
    glass = [2 * AROUND + k for k in upper] + [3 * AROUND + k for k in (5, 11)]
    band = [(len(sections) - 3) * AROUND + k for k in range(AROUND)]
    return _painted(_painted(shell, glass, GLASS), band, ACCENT)


def _open_below(body: Mesh) -> Mesh:
    """The body without its underside, which stands on something that a sort by distance would let it shine through."""
    up = normals(body.vertices[body.faces])[:, 2] < 0.4
    return Mesh(body.vertices, body.faces[up], body.colour[up], body.bias[up], body.two_sided[up])


def _windows(a: Airframe) -> list[Mesh]:
    y, top, low = 0.992 * a.half_width, a.roof_z + 0.6, a.roof_z + 1.1
    front = np.linspace(a.nose_x - 3.9, a.cabin_aft_x + 1.2, 4)
    return [
        mesh(
            np.array([(x, s * y, top), (x - 0.7, s * y, top), (x - 0.7, s * y, low), (x, s * y, low)]),
            [[3, 2, 1, 0] if s < 0 else [0, 1, 2, 3]],
            GLASS,
            bias=0.4,
        )
        for x in front
        for s in (-1.0, 1.0)
    ]


def _tail(a: Airframe) -> list[Mesh]:
    """Fin, stabiliser and tail rotor."""
    t, z = a.tail_x, a.roof_z
    profile = [(t + 1.0, z + 0.15), (t - 0.05, z + 0.4), (t - 1.3, z - 2.0), (t - 0.65, z - 2.0)]
    fin = block(np.array([(x, y, h) for y in (-0.07, 0.07) for x, h in profile]), BODY)
    tip = [(t - 0.53, z - 1.75), (t - 1.17, z - 1.75), (t - 1.34, z - 2.08), (t - 0.68, z - 2.08)]
    cap = block(np.array([(x, y, h) for y in (-0.08, 0.08) for x, h in tip]), ACCENT, bias=0.2)
    stabiliser = box((t + 0.2, -1.6, z + 0.12), (t + 0.95, 1.6, z + 0.2), BODY)
    hub = np.array([t - 0.85, 0.28, z - 1.35])
    blades = []
    for angle in np.radians([20.0, 110.0]):
        along, chord = (np.array([np.cos(angle + q), 0.0, np.sin(angle + q)]) for q in (0.0, 0.5 * np.pi))
        rim = np.array([hub + i * 1.35 * along + j * 0.11 * chord for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        blades.append(mesh(rim, [[0, 1, 2, 3]], BLADE, bias=0.3, two_sided=True))
    return [fin, cap, stabiliser, *blades]


def _rotor(a: Airframe) -> list[Mesh]:
    """Engine housing, mast, hub and the four main-rotor blades folded aft."""
    x, z, w = a.hub_x, a.roof_z, a.half_width
    housing = [
        (x + 2.3, 0.0, 0.35 * w, z - 0.1, z + 0.06),
        (x + 1.5, 0.0, 0.62 * w, z - 0.55, z + 0.06),
        (x, 0.0, 0.7 * w, z - 0.75, z + 0.06),
        (x - 1.7, 0.0, 0.68 * w, z - 0.65, z + 0.06),
        (x - 3.0, 0.0, 0.4 * w, z - 0.1, z + 0.06),
    ]
    parts = [_open_below(loft(housing, BELLY, roundness=0.3))]
    for side in (-1.0, 1.0):
        inner, outer = sorted((side * 0.45 * w, side * 0.86 * w))
        parts.append(box((x - 2.1, inner, z - 0.5), (x - 1.1, outer, z - 0.12), DARK, bias=0.2))
    parts.append(box((x - 0.13, -0.13, z - 1.35), (x + 0.13, 0.13, z - 0.6), DARK, bias=0.1))
    parts.append(box((x - 0.42, -0.42, z - 1.5), (x + 0.42, 0.42, z - 1.3), DARK, bias=0.2))
    for degrees in (-12.0, -4.5, 4.5, 12.0):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        along, chord = np.array([-c, s, 0.012]), np.array([s, c, 0.0])
        root = np.array([x - 0.3, 0.03 * degrees, z - 1.42])
        rim = [
            root + i * along + j * chord
            for i, j in ((0, -0.24), (a.blade_length, -0.24), (a.blade_length, 0.24), (0, 0.24))
        ]
        parts.append(
            block(np.array([p + np.array([0.0, 0.0, h]) for h in (-0.04, 0.04) for p in rim]), BLADE, bias=0.4)
        )
    return parts


def _sponsons(a: Airframe) -> list[Mesh]:
    """Fairings of main stations that stand off the cabin, and the leg that carries the auxiliary one."""
    x, y, z = a.mounts[0]
    parts = [box((x - 0.14, y - 0.11, a.roof_z + 0.45), (x + 0.14, y + 0.11, max(z, a.roof_z + 0.5)), BELLY)]
    for x, y, z in a.mounts[1:]:
        if abs(y) < 1.1 * a.half_width:
            continue
        z = min(z, a.floor_z - 0.09)
        side, reach = np.sign(y), abs(y) + 0.12
        centre, half = side * 0.5 * (0.6 * a.half_width + reach), 0.5 * (reach - 0.6 * a.half_width)
        sections = [
            (x + 1.5, 0.9 * centre, 0.5 * half, z - 0.25, z + 0.05),
            (x + 0.8, centre, half, z - 0.55, z + 0.12),
            (x - 0.7, centre, half, z - 0.55, z + 0.12),
            (x - 1.7, 0.9 * centre, 0.5 * half, z - 0.3, z - 0.02),
        ]
        parts.append(loft(sections, BODY, BELLY))
    return parts


@lru_cache(maxsize=8)
def airframe_mesh(airframe: Airframe) -> Mesh:
    """The helicopter's body without its landing gear, H axes."""
    parts = [_fuselage(airframe), *_windows(airframe), *_tail(airframe), *_rotor(airframe), *_sponsons(airframe)]
    return merge(parts)


def planform(airframe: Airframe) -> Array:
    """Outline of the body seen from above, H axes, (k, 2) [m]: for its shadow and the plan view."""
    a, w = airframe, airframe.half_width
    half = [
        (a.nose_x, 0.2 * w),
        (a.nose_x - 0.9, 0.8 * w),
        (a.nose_x - 2.0, w),
        (a.cabin_aft_x, w),
        (a.cabin_aft_x - 2.4, 0.42 * w),
        (a.tail_x + 1.0, 0.24 * w),
        (a.tail_x + 1.0, 1.6),
        (a.tail_x + 0.2, 1.6),
        (a.tail_x + 0.2, 0.2 * w),
        (a.tail_x - 1.3, 0.07),
    ]
    return np.array(half + [(x, -y) for x, y in reversed(half)])


@lru_cache(maxsize=4)
def unit_cylinder(corners: int) -> tuple[Array, Indices]:
    """A cylinder about y of radius 1 and length 1: vertices (2 n, 3), y = -1/2 first, and its side faces (n, 4)."""
    angle = 2.0 * np.pi * (np.arange(corners) + 0.5) / corners
    ring = np.stack([np.sin(angle), np.zeros(corners), np.cos(angle)], axis=1)
    k = np.arange(corners)
    after = (k + 1) % corners
    half = np.array([0.0, 0.5, 0.0])
    vertices = np.concatenate([ring - half, ring + half])
    faces = np.stack([k, after, corners + after, corners + k], axis=1)
    return vertices, _outward(vertices, faces, np.zeros(3))


def bases(axis: Array) -> Array:
    """Orthonormal bases (n, 3, 3) whose second column is the unit vector along `axis` (n, 3)."""
    size = np.linalg.norm(axis, axis=1, keepdims=True)
    y = np.where(size > 1e-9, axis / np.maximum(size, 1e-9), np.array([0.0, 1.0, 0.0]))  # a rod of no length: any axis
    # Any vector off the axis will do to start from; one along z serves wheels, one along x upright struts.
    start = np.where(np.abs(y[:, 2:]) < 0.9, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]))
    x = cross(y, start)
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack([x, y, cross(x, y)], axis=2)


def cylinders(centre: Array, axis: Array, radius: Array, length: Array, corners: int) -> Array:
    """Vertices (n, 2 corners, 3) of n cylinders about `axis` (n, 3), ordered as in `unit_cylinder`."""
    unit, _ = unit_cylinder(corners)
    size = np.stack([radius, length, radius], axis=1)
    return np.asarray(np.einsum("nij,nkj->nki", bases(axis), unit * size[:, None, :]) + centre[:, None, :])


@lru_cache(maxsize=8)
def claw_mesh(height: float) -> Mesh:
    """The claw: a carriage on the deck with two jaws beside the probe, from the deck point under its centre, S axes.

    Args:
        height: Of the claw plane over the deck [m].
    """
    top = -max(height, 0.0) - 0.16
    body = box((-0.6, -0.45, top), (0.6, 0.45, 0.0), (196, 64, 52))
    jaws = [
        box((s * 0.3 - 0.14, -0.36, top - 0.14), (s * 0.3 + 0.14, 0.36, top), (244, 190, 60), bias=0.1)
        for s in (-1.0, 1.0)
    ]
    return merge([body, *jaws])
