"""Attitude, angular velocity and acceleration from yaw-pitch-roll angles, at any angle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ssmash_gym.ship.kinematics import (
    EULER_ORDERS,
    angles_from_rotation,
    angular_acceleration,
    angular_velocity,
    axis_rotation,
    rotation,
)


def smooth_angles(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Three large angles (roll past 180, pitch past 90 degrees) and their exact derivatives."""
    amplitude, omega, phase = np.array([3.5, 2.0, 5.0]), np.array([0.9, 1.3, 0.6]), np.array([0.3, 1.1, 2.0])
    x = np.outer(t, omega) + phase
    return amplitude * np.sin(x), amplitude * omega * np.cos(x), -amplitude * omega**2 * np.sin(x)


def test_bow_up_starboard_down_bow_to_starboard_are_positive() -> None:
    angle = 0.1
    starboard, forward = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    assert (rotation(np.array([angle, 0.0, 0.0])) @ starboard)[2] == pytest.approx(np.sin(angle))  # z is down
    assert (rotation(np.array([0.0, angle, 0.0])) @ forward)[2] == pytest.approx(-np.sin(angle))
    assert (rotation(np.array([0.0, 0.0, angle])) @ forward)[1] == pytest.approx(np.sin(angle))


@pytest.mark.parametrize("order", EULER_ORDERS)
def test_sequences_agree_with_scipy(order: str) -> None:
    angles = np.array([[0.3, -0.7, 1.9], [-2.0, 0.4, 0.2], [0.0, 1.4, -3.0]])
    in_order = angles[:, ["xyz".index(axis) for axis in order]]
    expected = Rotation.from_euler(order.upper(), in_order).as_matrix()  # upper case: intrinsic
    np.testing.assert_allclose(rotation(angles, order), expected, atol=1e-14)


def test_z_y_x_is_the_default_sequence() -> None:
    angles = np.array([0.2, 0.5, -1.1])
    parts = [axis_rotation(axis, angles[axis]) for axis in (2, 1, 0)]
    np.testing.assert_allclose(rotation(angles), parts[0] @ parts[1] @ parts[2], atol=1e-15)


def test_angular_velocity_is_the_skew_part_of_the_matrix_rate() -> None:
    t = np.linspace(0.0, 20.0, 101)
    h = 1e-4
    angles, rates, _ = smooth_angles(t)
    slope = (rotation(smooth_angles(t + h)[0]) - rotation(smooth_angles(t - h)[0])) / (2.0 * h)
    skew = np.einsum("nji,njk->nik", rotation(angles), slope)
    w = angular_velocity(angles, rates)
    np.testing.assert_allclose(np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=-1), w, atol=2e-6)
    assert np.max(np.abs(w - rates)) > 1.0  # Euler rates are not angular velocity: the test would see a mix-up


def test_angular_acceleration_is_the_derivative_of_angular_velocity() -> None:
    t = np.linspace(0.0, 20.0, 101)
    h = 1e-4
    slope = (angular_velocity(*smooth_angles(t + h)[:2]) - angular_velocity(*smooth_angles(t - h)[:2])) / (2.0 * h)
    np.testing.assert_allclose(angular_acceleration(*smooth_angles(t)), slope, atol=2e-6)


angle = st.floats(-3.1, 3.1)


@settings(max_examples=50, deadline=None)
@given(roll=angle, pitch=st.floats(-1.5, 1.5), yaw=angle)
def test_angles_come_back_from_the_matrix(roll: float, pitch: float, yaw: float) -> None:
    angles = np.array([roll, pitch, yaw])
    R = rotation(angles)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(angles_from_rotation(R), angles, atol=1e-12)
