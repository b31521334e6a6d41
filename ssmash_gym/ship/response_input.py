"""What a ship's response is asked with: numbers and arrays, checked."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.kinematics import FloatArray


def checked(key: str, value: Any, *, above_zero: bool = False) -> float:
    """`value` as a finite float of 0 or more (or above 0); refused with one sentence otherwise."""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not number or not math.isfinite(value) or value < 0.0 or (above_zero and value == 0.0):
        allowed = "above 0" if above_zero else "of 0 or more"
        raise ConfigurationError(f"ship response: {key} is {value!r}, allowed are finite numbers {allowed}")
    return float(value)


def checked_waves(
    omega: npt.ArrayLike, heading: npt.ArrayLike, amplitude: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Frequencies, headings and amplitudes as float arrays of one shape (n,).

    Raises:
        ConfigurationError: Shapes that do not fit, a value that is not finite, or a frequency that is not positive.
    """
    w = np.atleast_1d(np.asarray(omega, dtype=np.float64))
    h, a = np.asarray(heading, dtype=np.float64), np.asarray(amplitude, dtype=np.float64)
    for key, array in (("heading", h), ("amplitude", a)):
        if w.ndim != 1 or array.shape not in ((), (1,), w.shape):
            raise ConfigurationError(
                f"ship response: {key} has shape {array.shape} and omega {w.shape}, allowed are one value for all "
                "or one per frequency"
            )
    if not (np.isfinite(w).all() and np.isfinite(h).all() and np.isfinite(a).all() and (w > 0.0).all()):
        raise ConfigurationError(
            "ship response: allowed are finite frequencies above 0, finite headings and finite amplitudes"
        )
    return w, np.broadcast_to(h, w.shape), np.broadcast_to(a, w.shape)
