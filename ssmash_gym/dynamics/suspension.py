"""Suspension elements that are not gas oleos: linear strut, end stop, and the geometry of a swing arm."""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.dynamics.lane import fabs, kernel, load, maximum, minimum, sqrt, where
from ssmash_gym.dynamics.layout import Sta
from ssmash_gym.dynamics.vectors import Matrix, Vector, add, apply, dot, load3, scale, sub

STOP_RAMP: Final = 1.0e-3  # travel into the stop over which its damping comes in [m]
LEAST_SPEED: Final = 1.0e-9  # [m/s], keeps secant slopes finite at rest
LEAST_LENGTH: Final = 1.0e-6  # [m], keeps the direction of a strut of no length finite


@kernel
def end_stop(p: Any, base: int, x: Any, v: Any, inverse: Any) -> tuple[Any, Any]:
    """Stop at the end of the stroke: stiff, damped, never pulling (not in the thesis; errata section 4).

    Args:
        p: Parameter rows.
        base: First row of the station.
        x: Compression from full droop [m].
        v: Compression rate [m/s], positive in compression.
        inverse: ``1 / max(|v|, LEAST_SPEED)``.

    Returns:
        ``(F, slope)``: elastic force [N] and the secant slope of the damping [N s/m]; the whole force is
        ``F + slope v``. It is 0 up to ``STROKE``, never negative, and continuous in ``x`` and ``v``.
    """
    travel = maximum(x - load(p, base + Sta.STROKE), 0.0)
    elastic = load(p, base + Sta.STOP_K) * travel
    damping = load(p, base + Sta.STOP_C) * minimum(travel * (1.0 / STOP_RAMP), 1.0)
    # On the way back the damping force can at most undo the elastic force.
    releasing = minimum(damping, elastic * inverse)
    return elastic, where(v < 0.0, releasing, damping)


@kernel
def linear_strut(p: Any, base: int, x: Any, v: Any) -> tuple[Any, Any]:
    """Linear spring and damper with the end stop (appendix A, line 62).

    Args:
        p: Parameter rows.
        base: First row of the station.
        x: Compression from full droop [m].
        v: Compression rate [m/s], positive in compression.

    Returns:
        ``(F, slope)``: total force [N], positive pushing the ends apart, and the secant slope of its
        dissipation [N s/m], never negative.
    """
    stop, stop_slope = end_stop(p, base, x, v, 1.0 / maximum(fabs(v), LEAST_SPEED))
    slope = load(p, base + Sta.LINEAR_C) + stop_slope
    return load(p, base + Sta.LINEAR_K) * x + stop + slope * v, slope


@kernel
def strut_geometry(p: Any, base: int, R_HO: Matrix) -> tuple[Any, Vector, Vector]:
    """Where the strut of a swing arm lies.

    The compression is ``LENGTH - length``. With ``w_HO_H`` the angular velocity of the arm relative to the
    helicopter, the length changes at ``direction . (w_HO_H x r_OP2_H)`` (2.236), (2.237); a strut force ``F``,
    positive in compression, does on a joint axis ``a`` through ``O`` the generalized force
    ``F direction . (a x r_OP2_H)``, which is what (2.238)-(2.241) give.

    Args:
        p: Parameter rows.
        base: First row of the station.
        R_HO: Takes O components to H components.

    Returns:
        ``(length, direction, r_OP2_H)``: distance P1-P2 [m], the unit vector from P1 to P2 in H, and the
        lever from the arm's joint O to P2 in H [m].
    """
    r_OP2_H = apply(R_HO, load3(p, base + Sta.P2))
    r_P1P2_H = sub(add(load3(p, base + Sta.MOUNT), r_OP2_H), load3(p, base + Sta.P1))  # (2.235)
    length = sqrt(dot(r_P1P2_H, r_P1P2_H))
    return length, scale(1.0 / maximum(length, LEAST_LENGTH), r_P1P2_H), r_OP2_H
