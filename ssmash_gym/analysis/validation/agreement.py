"""Two integrators on the same manoeuvre: how far their peak loads and final positions are apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from ssmash_gym.dynamics.layout import State

if TYPE_CHECKING:
    from ssmash_gym.cases import History

LOADS_APART: Final = 0.005  # of a peak load, relative
ENDS_APART_M: Final = 0.005
SMALL_N: Final = 100.0  # a load that never exceeds this is not compared


@dataclass(frozen=True)
class Agreement:
    """Two runs of one case by different integrators.

    Attributes:
        solver: The integrator that is set beside the case's own.
        peaks: For each load its peak [N] by the case's own integrator and by the other one.
        apart_m: Distance between the final positions of the body's c.g.
        evaluations: Right-hand sides that the other one used.
    """

    solver: str
    peaks: Mapping[str, tuple[float, float]]
    apart_m: float
    evaluations: int

    @property
    def loads_apart(self) -> float:
        """Largest relative difference of a peak load."""
        return max((abs(own - other) / other for own, other in self.peaks.values()), default=0.0)

    @property
    def holds(self) -> bool:
        """Whether peak loads agree within 0.5 % and final positions within 5 mm."""
        return self.loads_apart <= LOADS_APART and self.apart_m <= ENDS_APART_M


def agreement(own: History, other: History, loads: Sequence[str]) -> Agreement:
    """Compare two histories of one case.

    Args:
        own: By the case's own integrator.
        other: By another one.
        loads: Telemetry channels of the loads.
    """
    peaks = {name: (own.largest(name), other.largest(name)) for name in loads}
    rows = slice(State.Q8, State.Q10 + 1)
    apart = float(np.linalg.norm(own.states[rows, -1] - other.states[rows, -1]))
    kept = {name: pair for name, pair in peaks.items() if min(pair) > SMALL_N}
    return Agreement(other.solver, kept, apart, other.evaluations)
