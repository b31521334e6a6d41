"""About the steer axis of a station: friction, damping, and the free play of a locked steering."""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.dynamics.lane import copysign, fabs, kernel, load, maximum, minimum, where
from ssmash_gym.dynamics.layout import Sta
from ssmash_gym.dynamics.oleo import friction_slope
from ssmash_gym.dynamics.suspension import LEAST_SPEED

PLAY_RAMP: Final = 1.0e-3  # travel into the stop over which its damping comes in [rad]
LEAST_COSINE: Final = 1.0e-12  # square of the least cosine of half the angle: keeps half a turn finite


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


@kernel
def play_moment(p: Any, base: int, e0: Any, e3: Any, rate: Any) -> tuple[Any, Any]:
    """Free play of a locked steering: no moment within it, spring and damper beyond (not in the thesis).

    The angle from the lock is taken as ``2 tan(angle / 2)``: too large by ``angle^3 / 12``, that is by 0.25 % at
    10 deg and 1 % at 20 deg, and growing over the whole half turn, so that the stop always pushes back.

    Args:
        p: Parameter rows.
        base: First row of the station.
        e0: First Euler parameter of the station, O to H.
        e3: Its fourth Euler parameter.
        rate: Steer rate of the carriage about ``o_z``, relative to the helicopter [rad/s].

    Returns:
        ``(M, slope)``: moment on the steer coordinate [N m], towards the lock and 0 within the play, and the secant
        slope of its damping [N m s/rad], never negative. Damping comes in over `PLAY_RAMP`; on the way back it at
        most undoes the spring, so that the stop never holds the wheel.
    """
    c = load(p, base + Sta.STEER_COS)
    s = load(p, base + Sta.STEER_SIN)
    cosine = c * e0 + s * e3
    angle = 2.0 * (c * e3 - s * e0) * cosine / maximum(cosine * cosine, LEAST_COSINE)
    beyond = maximum(fabs(angle) - load(p, base + Sta.STEER_PLAY), 0.0)
    elastic = load(p, base + Sta.STEER_STOP_K) * beyond
    damping = load(p, base + Sta.STEER_STOP_C) * minimum(beyond * (1.0 / PLAY_RAMP), 1.0)
    releasing = minimum(damping, elastic / maximum(fabs(rate), LEAST_SPEED))
    slope = where(angle * rate < 0.0, releasing, damping)
    return -(copysign(elastic, angle) + slope * rate), slope
