"""A pinhole camera for whole arrays of points at once, and the clipping that a pinhole needs.

Camera axes: x to the right of the picture, y down, z into it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float]

NEAR_M: Final = 0.3  # nothing nearer than this is drawn
FAR_PX: Final = 2.0e4  # a helicopter far off the ship must not cost the time of filling what nobody sees


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the camera is, which way it looks, and how points become pixels.

    Attributes:
        r_AC_A: Camera position in the frame A that the points are given in [m], (3,).
        R_CA: A components to camera components, (3, 3).
        focal_px: Focal length [px].
        centre_px: Pixel of the optical axis, (x, y).
    """

    r_AC_A: Array
    R_CA: Array
    focal_px: float
    centre_px: Point

    @classmethod
    def looking(cls, r_AC_A: Array, forward_A: Array, focal_px: float, centre_px: Point) -> Camera:
        """A camera at `r_AC_A` that looks along `forward_A` and is upright in a frame A whose z points down."""
        forward = forward_A / np.linalg.norm(forward_A)
        right = np.cross([0.0, 0.0, 1.0], forward)
        right = right / np.linalg.norm(right)
        return cls(np.asarray(r_AC_A), np.array([right, np.cross(forward, right), forward]), focal_px, centre_px)

    def carried(self, R_BA: Array, r_BA_B: Array) -> Camera:
        """The same camera described in frame B.

        Args:
            R_BA: A components to B components, (3, 3).
            r_BA_B: Origin of A from the origin of B, B axes [m], (3,).

        Returns:
            A camera that sees a point given in B where this one sees it given in A.
        """
        return Camera(r_BA_B + R_BA @ self.r_AC_A, self.R_CA @ R_BA.T, self.focal_px, self.centre_px)

    def to_camera(self, points_A: Array) -> Array:
        """Points in camera axes [m], shape as given, (..., 3)."""
        return np.asarray((points_A - self.r_AC_A) @ self.R_CA.T)

    def to_pixels(self, points_C: Array) -> Array:
        """Pixels (..., 2) of points in camera axes.

        A point nearer than `NEAR_M` is taken at `NEAR_M`, one farther off the picture than `FAR_PX` at `FAR_PX`.
        """
        scale = self.focal_px / np.maximum(points_C[..., 2], NEAR_M)
        return np.clip(points_C[..., :2] * scale[..., None] + self.centre_px, -FAR_PX, FAR_PX)

    def project(self, points_A: Array) -> tuple[Array, Array]:
        """Pixels (..., 2) and depth along the optical axis [m] (...,) of points in frame A."""
        points_C = self.to_camera(points_A)
        return self.to_pixels(points_C), points_C[..., 2]

    def polygon(self, points_A: Array) -> list[Point]:
        """Pixels of one polygon of k points, clipped at the near plane; empty if it lies behind the camera."""
        points_C = self.to_camera(points_A)
        if points_C[:, 2].min() < NEAR_M:
            points_C = clip(points_C, points_C[:, 2] - NEAR_M)
        return [(float(x), float(y)) for x, y in self.to_pixels(points_C)]


def clip(points: Array, inside: Array) -> Array:
    """Part of a convex polygon where a linear function is not negative (Sutherland-Hodgman).

    Args:
        points: Corners (k, d).
        inside: The function's value at each corner (k,).

    Returns:
        Corners of the part, (m, d), m = 0 if nothing is left.
    """
    kept: list[Array] = []
    for i in range(len(points)):
        a, b = inside[i - 1], inside[i]
        if (a < 0.0) != (b < 0.0):
            kept.append(points[i - 1] + (points[i] - points[i - 1]) * (a / (a - b)))
        if b >= 0.0:
            kept.append(points[i])
    return np.array(kept) if kept else np.zeros((0, points.shape[1]))


def half_plane(corners: Sequence[Point], a: float, b: float, c: float) -> list[Point]:
    """Part of a convex pixel polygon where ``a x + b y + c >= 0``."""
    points = np.asarray(corners, dtype=np.float64)
    return [(float(x), float(y)) for x, y in clip(points, points @ np.array([a, b]) + c)]
