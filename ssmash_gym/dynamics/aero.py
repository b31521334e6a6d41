"""Wind force on the helicopter body."""

from __future__ import annotations

from typing import Any

from ssmash_gym.dynamics.deck import quintic
from ssmash_gym.dynamics.lane import kernel, load, sqrt
from ssmash_gym.dynamics.layout import Deck, Par
from ssmash_gym.dynamics.vectors import Matrix, Vector, add, apply_t, dot, load3, scale, store3, sub


@kernel
def place_wind(p: Any, gusty: int, c: Any, t: Any, d: Any) -> None:
    """Wind rows of `d`: the mean and, with `gusty`, the gust along its direction.

    `c` holds the gust speed's quintic piece [m/s] and `t` is the time [s] since the piece's first node; without
    `gusty` neither is read.
    """
    mean = load3(p, Par.WIND)
    if gusty:
        speed = quintic(c, 0, t)[0]
        store3(d, Deck.WIND, add(mean, scale(speed, load3(p, Par.GUST))))
    else:
        store3(d, Deck.WIND, mean)


@kernel
def wind(p: Any, wind_N: Vector, R_NH: Matrix, v_NCP_H: Vector) -> Vector:
    """Drag of the relative wind at the centre of pressure.

    Args:
        p: Parameter rows.
        wind_N: True wind (2.196) minus the ship's mean velocity, gust included, N axes [m/s]; rows `Deck.WIND`.
        R_NH: Takes H components to N components.
        v_NCP_H: Velocity of the centre of pressure relative to the steadily translating mean frame N, in H
            axes [m/s], (2.197)-(2.200).

    Returns:
        Force at the centre of pressure, H axes [N].
    """
    relative = sub(apply_t(R_NH, wind_N), v_NCP_H)  # (2.196), (2.201)
    pressure = 0.5 * load(p, Par.AIR_DENSITY) * sqrt(dot(relative, relative))
    area = load3(p, Par.AREA)
    return (
        area[0] * pressure * relative[0],  # (2.202)
        area[1] * pressure * relative[1],
        area[2] * pressure * relative[2],
    )
