"""Wind force on the helicopter body."""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.lane import kernel, load, sqrt
from ssmash_gym.dynamics.layout import Par
from ssmash_gym.dynamics.vectors import Matrix, Vector, apply_t, dot, load3, sub


@kernel
def wind(p: Any, R_NH: Matrix, v_NCP_H: Vector) -> Vector:
    """Drag of the relative wind at the centre of pressure.

    Args:
        p: Parameter rows; ``WIND`` is the true wind (2.196) minus the ship's mean velocity, in N.
        R_NH: Takes H components to N components.
        v_NCP_H: Velocity of the centre of pressure relative to the steadily translating mean frame N, in H
            axes [m/s], (2.197)-(2.200).

    Returns:
        Force at the centre of pressure, H axes [N].
    """
    relative = sub(apply_t(R_NH, load3(p, Par.WIND)), v_NCP_H)  # (2.196), (2.201)
    pressure = 0.5 * load(p, Par.AIR_DENSITY) * sqrt(dot(relative, relative))
    area = load3(p, Par.AREA)
    return (
        area[0] * pressure * relative[0],  # (2.202)
        area[1] * pressure * relative[1],
        area[2] * pressure * relative[2],
    )
