"""A rectangle of the deck on which the tires find other friction: a wet, oily or worn patch."""

from __future__ import annotations

from typing import Any, Final

from ssmash_gym.dynamics.lane import kernel, load, maximum, minimum
from ssmash_gym.dynamics.layout import Par

LEAST_EDGE: Final = 1.0e-9  # [m], keeps an edge of no width finite


@kernel
def inside(x: Any, low: Any, high: Any, over_edge: Any) -> Any:
    """0 outside of ``low`` to ``high``, 1 from an edge's width within, a smooth step in between."""
    s = minimum(maximum(minimum(x - low, high - x) * over_edge, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@kernel
def patch_factor(p: Any, x: Any, y: Any) -> Any:
    """Factor of the friction coefficient of a tire whose contact point lies at (x, y).

    1 outside of the rectangle and ``1 - PATCH_LOSS`` from `Par.PATCH_EDGE` inside its border; across the edge it is
    once continuously differentiable in each coordinate. All limits that hang on the friction coefficient shrink by
    this factor: the greatest in-plane force ``mu F_z`` and the greatest twisting moment, in any of the `Friction`
    modes, and the slip angle at which a rolling tire slides. Forces beyond the smaller limit fall to it at once; the
    stored deflections follow at the tire's pull-back rate. Rolling resistance is not affected.

    Args:
        p: Parameter rows.
        x: Contact point along the track, S axes [m].
        y: Contact point across the track, S axes [m].
    """
    over_edge = 1.0 / maximum(load(p, Par.PATCH_EDGE), LEAST_EDGE)
    along = inside(x, load(p, Par.PATCH_X_MIN), load(p, Par.PATCH_X_MAX), over_edge)
    across = inside(y, load(p, Par.PATCH_Y_MIN), load(p, Par.PATCH_Y_MAX), over_edge)
    return 1.0 - load(p, Par.PATCH_LOSS) * along * across
