"""3-vectors and 3x3 matrices as tuples of numbers (lanes, NumPy arrays or floats).

A vector is ``(x, y, z)``; a matrix is nine numbers, row by row. ``R_AB`` takes B components to A components.
"""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, store

Vector = Any  # 3-tuple of numbers; the kernels are generic over the number type
Matrix = Any  # 9-tuple of numbers


@kernel
def add(a: Vector, b: Vector) -> Vector:
    """``a + b``."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a: Vector, b: Vector) -> Vector:
    """``a - b``."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(s: Any, a: Vector) -> Vector:
    """``s a``."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def dot(a: Vector, b: Vector) -> Any:
    """``a . b``."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """``a x b``  # (2.2)"""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def apply(m: Matrix, v: Vector) -> Vector:
    """``M v``: with ``R_AB``, B components to A components."""
    return (
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    )


@kernel
def apply_t(m: Matrix, v: Vector) -> Vector:
    """``M^T v``: with ``R_AB``, A components to B components."""
    return (
        m[0] * v[0] + m[3] * v[1] + m[6] * v[2],
        m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
        m[2] * v[0] + m[5] * v[1] + m[8] * v[2],
    )


@kernel
def matmul(a: Matrix, b: Matrix) -> Matrix:
    """``A B``: ``R_AC = R_AB R_BC``  # (2.6)"""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@kernel
def rotation(e0: Any, e1: Any, e2: Any, e3: Any) -> Matrix:
    """Matrix of unit Euler parameters, rotated frame to non-rotated frame (signs as in the errata)."""
    return (
        2.0 * (e0 * e0 + e1 * e1) - 1.0,  # (2.5)
        2.0 * (e1 * e2 - e0 * e3),
        2.0 * (e1 * e3 + e0 * e2),
        2.0 * (e1 * e2 + e0 * e3),
        2.0 * (e0 * e0 + e2 * e2) - 1.0,
        2.0 * (e2 * e3 - e0 * e1),
        2.0 * (e1 * e3 - e0 * e2),
        2.0 * (e2 * e3 + e0 * e1),
        2.0 * (e0 * e0 + e3 * e3) - 1.0,
    )


@kernel
def load3(block: Any, row: int) -> Vector:
    """Vector in three rows of a block."""
    return (load(block, row), load(block, row + 1), load(block, row + 2))


@kernel
def store3(block: Any, row: int, v: Vector) -> None:
    """Write a vector to three rows of a block."""
    store(block, row, v[0])
    store(block, row + 1, v[1])
    store(block, row + 2, v[2])
