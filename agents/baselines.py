"""The scripted policies that any trained agent is compared with, by name: each makes itself for a task."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from ssmash_gym.agents.laws import (
    ACCELERATION_M_S2,
    CENTRED_AFTER,
    SPEED_M_S,
    Hold,
    Readout,
    Scripted,
    Trapezoid,
    Yield,
)
from ssmash_gym.agents.laws_feedback import Linear, YieldScheduled
from ssmash_gym.agents.operator import Operator
from ssmash_gym.agents.straighten import STRAIGHTEN_BASELINES

from ssmash_gym.envs.task import TaskConfig

_POLICIES: Final[tuple[type[Hold] | type[Trapezoid] | type[Operator], ...]] = (
    Hold, Trapezoid, Yield, YieldScheduled, Linear, Operator,
)  # fmt: skip
BASELINES: Final[dict[str, Callable[[TaskConfig], Scripted]]] = {
    **{policy.name: policy for policy in _POLICIES},
    **STRAIGHTEN_BASELINES,
}
TUNED: Final = (Yield.name, YieldScheduled.name, Linear.name)  # laws whose gains were searched

__all__ = [
    "ACCELERATION_M_S2",
    "BASELINES",
    "CENTRED_AFTER",
    "SPEED_M_S",
    "TUNED",
    "Hold",
    "Linear",
    "Operator",
    "Readout",
    "Scripted",
    "Trapezoid",
    "Yield",
    "YieldScheduled",
]
