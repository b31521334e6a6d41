"""A patch of other friction on the deck, from a person's numbers to parameter rows."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.dynamics.layout import Par
from ssmash_gym.errors import refusal

Range = tuple[float, float]
DEFAULT_EDGE_M: Final = 0.02


def is_wide(span: Range, edge_m: float) -> bool:
    """Whether a side of the rectangle has room for its two edges."""
    low, high = span
    return math.isfinite(low) and math.isfinite(high) and high - low >= 2.0 * edge_m


def write_patch(
    parameters: NDArray[np.float64], columns: NDArray[np.int64], x_m: Range, y_m: Range, factor: float, edge_m: float
) -> None:
    """Write the rows of a patch into the listed columns of `parameters` (PARAMETER_ROWS, N).

    Raises:
        ConfigurationError: the rectangle is empty or narrower than its two edges, or the factor is negative.
    """
    if not (math.isfinite(factor) and factor >= 0.0):
        raise refusal("patch", "friction_factor", factor, "it must be a number of at least 0")
    if not (math.isfinite(edge_m) and edge_m > 0.0):
        raise refusal("patch", "edge_m", edge_m, "it must be a positive number")
    for key, given in (("x_m", x_m), ("y_m", y_m)):
        if not is_wide(given, edge_m):
            raise refusal(
                "patch", key, given, f"it must go from a smaller number to one larger by two edges, {2.0 * edge_m:g} m"
            )
    parameters[Par.PATCH_X_MIN : Par.PATCH_Y_MAX + 1, columns] = np.array([*x_m, *y_m])[:, None]
    parameters[Par.PATCH_LOSS, columns] = 1.0 - factor
    parameters[Par.PATCH_EDGE, columns] = edge_m
