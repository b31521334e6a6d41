"""Many systems of three complex equations at once, in closed form.

Elementwise NumPy only: no matrix library, whose sums may depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

ComplexArray = npt.NDArray[np.complex128]


def determinant(Z: ComplexArray) -> ComplexArray:
    """Determinants (n,) of n matrices of 3 x 3, given as (3, 3, n)."""
    (a, b, c), (d, e, f), (g, h, i) = Z
    return np.asarray(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def solve3(Z: ComplexArray, F: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Solve n systems of three equations by Cramer's rule, elementwise.

    Args:
        Z: Coefficients (3, 3, n).
        F: Right-hand sides (3, n).

    Returns:
        The three unknowns, each (n,).
    """
    (a, b, c), (d, e, f), (g, h, i) = Z
    p, q, r = F
    ei, di, dh = e * i - f * h, d * i - f * g, d * h - e * g
    inverse = 1.0 / (a * ei - b * di + c * dh)
    qi, dr, er = q * i - f * r, d * r - q * g, e * r - h * q
    return (
        (p * ei - b * qi - c * er) * inverse,
        (a * qi - p * di + c * dr) * inverse,
        (a * er - b * dr + p * dh) * inverse,
    )
