"""Geometry of the stations at full droop. Frames: H helicopter, O station mount, W carriage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ssmash_gym.vehicle.station import Station

Array = NDArray[np.float64]


def rotation(parameters: tuple[float, float, float, float] | Array) -> Array:
    """Rotation matrix of Euler parameters ``(e0, e1, e2, e3)``, child to parent components, shape (3, 3).

    The parameters are normalised first. Eq. (2.5) as corrected in the errata.
    """
    e0, e1, e2, e3 = np.asarray(parameters, dtype=float) / np.linalg.norm(parameters)
    return np.array(
        [
            [1 - 2 * (e2 * e2 + e3 * e3), 2 * (e1 * e2 - e0 * e3), 2 * (e1 * e3 + e0 * e2)],
            [2 * (e1 * e2 + e0 * e3), 1 - 2 * (e1 * e1 + e3 * e3), 2 * (e2 * e3 - e0 * e1)],
            [2 * (e1 * e3 - e0 * e2), 2 * (e2 * e3 + e0 * e1), 1 - 2 * (e1 * e1 + e2 * e2)],
        ]
    )


def lowest_points(station: Station, R_SH: Array | None = None) -> Array:
    """Lowest point of each tire at full droop, from the reference point of the coordinates.

    Args:
        station: The station.
        R_SH: Takes H components to components in which "down" is z; None for a level helicopter.

    Returns:
        Shape (tires, 3), in those components [m]. A tire is a thin disc about the axle.
    """
    R_SH = np.eye(3) if R_SH is None else R_SH
    R_SO = R_SH @ rotation(station.orientation)
    axle = R_SO[:, 1]
    down = np.array([0.0, 0.0, 1.0]) - axle[2] * axle  # in the wheel's plane
    down /= max(float(np.linalg.norm(down)), 1e-12)
    carriage = R_SH @ np.array(station.mount_m) + R_SO @ np.array(station.droop_m)
    return np.array([carriage + R_SO @ np.array(t.position_m) + 0.5 * t.diameter_m * down for t in station.tires])


def strut_length(station: Station, arm_angle: float = 0.0) -> float:
    """Distance P1-P2 of a swing arm [m], (2.235).

    Args:
        station: A swing-arm station.
        arm_angle: Turn of the arm about ``o_y`` from full droop [rad].

    Raises:
        ValueError: The station has no arm.
    """
    return float(strut_lengths(station, np.array([arm_angle]))[0])


def strut_lengths(station: Station, arm_angles: Array) -> Array:
    """The same as `strut_length` for several angles, shape (n,)."""
    if station.arm is None:
        raise ValueError("a prismatic station has no strut length")
    c, s = np.cos(arm_angles), np.sin(arm_angles)
    x, y, z = station.arm.arm_point_m
    r_OP2_O = np.array([c * x + s * z, np.full_like(c, y), c * z - s * x])  # at full droop's axes, one column an angle
    r_OP1_H = np.array(station.arm.helicopter_point_m) - np.array(station.mount_m)
    lengths: Array = np.linalg.norm(rotation(station.orientation) @ r_OP2_O - r_OP1_H[:, None], axis=0)
    return lengths
