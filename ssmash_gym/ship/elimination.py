"""Small systems of real equations, many at once.

Elementwise NumPy only: no matrix library, whose sums may depend on the number of threads.
"""

from __future__ import annotations

import numpy as np

from ssmash_gym.ship.kinematics import FloatArray


def solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions of symmetric positive definite systems, by elimination without exchange of rows.

    Args:
        matrix: (p, p, columns).
        right: (p, columns).

    Returns:
        (p, columns).
    """
    p = len(matrix)
    rows = np.concatenate([matrix, right[:, np.newaxis]], axis=1)
    rows = np.ascontiguousarray(np.moveaxis(rows, -1, 0))  # columns first: the elementwise loops are long then
    for k in range(p - 1):
        factor = rows[:, k + 1 :, k] / rows[:, k, k, np.newaxis]
        rows[:, k + 1 :, k + 1 :] -= factor[..., np.newaxis] * rows[:, k, np.newaxis, k + 1 :]
    solution = rows[..., p].copy()
    for k in range(p - 1, -1, -1):
        solution[:, k] /= rows[:, k, k]
        solution[:, :k] -= rows[:, :k, k] * solution[:, k, np.newaxis]
    return np.ascontiguousarray(solution.T)
