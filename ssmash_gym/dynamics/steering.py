"""Friction and damping about the steer axis of a station."""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import fabs, kernel, load, maximum
from ssmash_gym.dynamics.layout import Sta
from ssmash_gym.dynamics.oleo import friction_slope
from ssmash_gym.dynamics.suspension import LEAST_SPEED


@kernel
def steer_moment(p: Any, base: int, rate: Any, F_xy: Any) -> tuple[Any, Any]:
    """Moment that resists steering.

    Args:
        p: Parameter rows.
        base: First row of the station.
        rate: Steer rate of the carriage about ``o_z``, relative to the helicopter [rad/s].
        F_xy: Resultant in-plane tire force of the station, ``sqrt(F_tx^2 + F_ty^2)`` [N].

    Returns:
        ``(M, slope)``: moment on the steer coordinate [N m], opposing the rate, and its secant slope
        ``-M / rate`` [N m s/rad], finite at rest and never negative.
    """
    w = maximum(fabs(rate), LEAST_SPEED)
    friction = load(p, base + Sta.STEER_MU) * F_xy  # (2.162), lever and coefficient in one
    slope = friction * friction_slope(load(p, base + Sta.STEER_BETA), w, 1.0 / w)  # (2.163)
    slope = slope + load(p, base + Sta.STEER_C)
    return -(slope * rate), slope  # (2.164)
