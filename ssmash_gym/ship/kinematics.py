"""Attitude, angular velocity and angular acceleration of the deck from its yaw-pitch-roll angles.

Frames: N is the steadily translating mean frame (z down), S the ship frame (x forward, y starboard, z down).
``R_NS`` takes S components to N components. Angles are ``(roll, pitch, yaw)`` [rad] in the z-y-x sequence:
``R_NS = Rz(yaw) Ry(pitch) Rx(roll)``. All functions work on arrays whose last axis holds the three angles.
The formulas hold at any angle, also where the angles themselves are singular (pitch of 90 degrees).
"""

from __future__ import annotations

from typing import Final, Literal, get_args

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
EulerOrder = Literal["zyx", "xyz", "zxy", "yxz", "yzx", "xzy"]
EULER_ORDERS: Final[tuple[str, ...]] = get_args(EulerOrder)


def axis_rotation(axis: int, angle: FloatArray) -> FloatArray:
    """Matrix of a rotation about one coordinate axis, rotated frame to non-rotated frame.

    Args:
        axis: 0, 1 or 2 for x, y or z.
        angle: Angles [rad], shape (...).

    Returns:
        Rotation matrices, shape (..., 3, 3).
    """
    c, s = np.cos(angle), np.sin(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R = np.zeros((*np.shape(angle), 3, 3))
    R[..., axis, axis] = 1.0
    R[..., j, j] = c
    R[..., k, k] = c
    R[..., j, k] = -s
    R[..., k, j] = s
    return R


def rotation(angles: FloatArray, order: EulerOrder = "zyx") -> FloatArray:
    """``R_NS`` from the three angles.

    Args:
        angles: Roll, pitch, yaw [rad], shape (..., 3): rotations about x, y and z whatever the sequence.
        order: Sequence of the intrinsic rotations, first one first; "zyx" is yaw, then pitch, then roll.

    Returns:
        S components to N components, shape (..., 3, 3).
    """
    a = np.asarray(angles, dtype=np.float64)
    first, second, third = ("xyz".index(axis) for axis in order)
    R = axis_rotation(first, a[..., first]) @ axis_rotation(second, a[..., second])
    return np.asarray(R @ axis_rotation(third, a[..., third]), dtype=np.float64)


def angles_from_rotation(R_NS: FloatArray) -> FloatArray:
    """Roll, pitch and yaw of the z-y-x sequence from ``R_NS``.

    Args:
        R_NS: S components to N components, shape (..., 3, 3).

    Returns:
        Angles [rad], shape (..., 3); pitch in [-pi/2, pi/2], roll and yaw in [-pi, pi].
    """
    R = np.asarray(R_NS, dtype=np.float64)
    roll = np.arctan2(R[..., 2, 1], R[..., 2, 2])
    pitch = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 2, 1], R[..., 2, 2]))
    yaw = np.arctan2(R[..., 1, 0], R[..., 0, 0])
    return np.stack([roll, pitch, yaw], axis=-1)


def angular_velocity(angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Angular velocity of the ship in its own axes (u4-u6, Léveillé 2013 (2.20)).

    Args:
        angles: Roll, pitch, yaw [rad], shape (..., 3), z-y-x sequence.
        rates: Their time derivatives [rad/s], shape (..., 3).

    Returns:
        ``w_NS_S`` [rad/s], shape (..., 3).
    """
    s_phi, c_phi = np.sin(angles[..., 0]), np.cos(angles[..., 0])
    s_th, c_th = np.sin(angles[..., 1]), np.cos(angles[..., 1])
    d_phi, d_th, d_psi = rates[..., 0], rates[..., 1], rates[..., 2]
    return np.stack(
        [d_phi - d_psi * s_th, d_th * c_phi + d_psi * c_th * s_phi, d_psi * c_th * c_phi - d_th * s_phi],
        axis=-1,
    )  # (2.20)


def angular_acceleration(angles: FloatArray, rates: FloatArray, accelerations: FloatArray) -> FloatArray:
    """Exact time derivative of `angular_velocity`.

    The components of the vector derivative in N and in S agree, because the two differ by ``w x w = 0``.

    Args:
        angles: Roll, pitch, yaw [rad], shape (..., 3), z-y-x sequence.
        rates: Their time derivatives [rad/s], shape (..., 3).
        accelerations: Their second time derivatives [rad/s2], shape (..., 3).

    Returns:
        ``wdot_NS_S`` [rad/s2], shape (..., 3).
    """
    s_phi, c_phi = np.sin(angles[..., 0]), np.cos(angles[..., 0])
    s_th, c_th = np.sin(angles[..., 1]), np.cos(angles[..., 1])
    d_phi, d_th, d_psi = rates[..., 0], rates[..., 1], rates[..., 2]
    linear = angular_velocity(angles, accelerations)
    product = np.stack(
        [
            -d_psi * c_th * d_th,
            -d_th * s_phi * d_phi + d_psi * (c_th * c_phi * d_phi - s_th * s_phi * d_th),
            -d_th * c_phi * d_phi - d_psi * (s_th * c_phi * d_th + c_th * s_phi * d_phi),
        ],
        axis=-1,
    )
    return np.asarray(linear + product, dtype=np.float64)
