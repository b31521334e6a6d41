"""The next quiet window that enough of the futures agree on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S
from ssmash_gym.ship.quiescence import SHORTEST_S


@dataclass(frozen=True)
class QuietWindow:
    """A window that is foreseen.

    Attributes:
        in_s: When it begins, from now on [s].
        length_s: How long it lasts, mean over the futures that are quiet from its begin for the shortest time and more
            [s]; those that are still quiet where the futures end count with the time until there.
        share: Share of the futures that are quiet from its begin for the shortest time and more.
    """

    in_s: float
    length_s: float
    share: float


def next_quiet(
    use: FloatArray, share: float, *, spacing_s: float = DEFAULT_SPACING_S, shortest_s: float = SHORTEST_S
) -> QuietWindow | None:
    """The earliest time from which enough futures stay within the limits for the shortest time; None without one.

    Args:
        use: Largest share of a limit in use, at evenly spaced times from now on, (futures, n).
        share: How many of the futures must agree.
        spacing_s: Time between those times [s].
        shortest_s: Windows shorter than this are of no use [s].
    """
    futures, count = use.shape
    lasts = np.zeros((futures, count))  # how long each future stays within the limits from each time on [s]
    within = use <= 1.0
    lasts[:, -1] = np.where(within[:, -1], 0.0, -spacing_s)
    for k in range(count - 2, -1, -1):
        lasts[:, k] = np.where(within[:, k], lasts[:, k + 1] + spacing_s, -spacing_s)
    long = lasts >= shortest_s - 1e-9
    shares = np.mean(long, axis=0)
    enough = np.flatnonzero(shares >= share)
    if not enough.size:
        return None
    begin = int(enough[0])
    return QuietWindow(begin * spacing_s, float(np.mean(lasts[long[:, begin], begin])), float(shares[begin]))
