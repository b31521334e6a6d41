"""What counts as an exceedance, and how much of each limit is left."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.envs import limits
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import Signal
from ssmash_gym.ship.quiescence import QUANTITIES

FAILURE: Final = "failure"  # the traverse ended otherwise than by its goal or its time: no margin tells it all
JUDGED: Final = (*limits.LIMITS, FAILURE)
SECURED: Final = tuple(name for name in limits.LIMITS if name != "corridor")  # a matter of place, not of the motion
NONE: Final = -1


def judged(
    margins: Mapping[str, FloatArray], failed: NDArray[np.bool_], counted: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Which limit each helicopter has exceeded within an interval, (n,): its place in `JUDGED`, or `NONE`.

    A margin below zero counts once the task's grace is over, a failure always. Of several limits the one that is
    exceeded furthest, in shares of itself, is told.

    Args:
        margins: Margin of each of `envs.limits.LIMITS`, (n,) each.
        failed: Whether the traverse has ended otherwise than by its goal or its time, (n,).
        counted: Whether the grace is over, (n,).
    """
    table = np.stack([margins[name] for name in limits.LIMITS])
    beyond = counted & (np.min(table, axis=0) < 0.0)
    return np.where(beyond, np.argmin(table, axis=0), np.where(failed, JUDGED.index(FAILURE), NONE))


def deck_margins(signal: Signal, deck_limits: Mapping[str, float]) -> dict[str, float]:
    """Least share of each deck limit that was left over some instants.

    Args:
        signal: The motion at those instants, each array (n, 6).
        deck_limits: Limit on the absolute value of each of any `ship.quiescence.QUANTITIES`.
    """
    return {
        f"deck_{name}": 1.0 - float(np.max(np.abs(QUANTITIES[name].value(signal)))) / limit
        for name, limit in deck_limits.items()
    }


def deck_use(nodes: FloatArray, deck_limits: Mapping[str, float]) -> FloatArray:
    """Largest share of a deck limit in use at each node of each future, (k, nodes).

    Args:
        nodes: As of `futures.future_nodes`, (k, nodes, 18).
        deck_limits: As for `deck_margins`.
    """
    signal = Signal(nodes[..., :6], nodes[..., 6:12], nodes[..., 12:])
    shares = [np.abs(QUANTITIES[name].value(signal)) / limit for name, limit in deck_limits.items()]
    return np.asarray(np.max(np.stack(shares), axis=0), dtype=np.float64)
