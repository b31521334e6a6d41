"""The stages of a window: what the helicopter is doing. A new stage is one entry of `STAGES`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

TRAVERSE: Final = "traverse"
SECURED: Final = "secured"
TOUCHDOWN: Final = "touchdown"


@dataclass(frozen=True)
class Stage:
    """What is simulated.

    Attributes:
        meaning: In a sentence.
        task: Changes of the window's task.
        sinks: Sink rate where the scenario has none [m/s]; 0 for a stage that starts on the deck.
        policy: What is at the claw where that is no choice; None: the window's policies.
        arrives: Whether there is a goal to be reached.
    """

    meaning: str
    task: Mapping[str, Any] = field(default_factory=dict)
    sinks: float = 0.0
    policy: str | None = None
    arrives: bool = False


STAGES: Final[Mapping[str, Stage]] = {
    TRAVERSE: Stage("hauled by the claw along the track to the hangar", arrives=True),
    SECURED: Stage(
        "standing where it has landed, wheels locked, held by the claw, which stands still",
        {"wheels": "locked"},
        policy="hold",
    ),
    TOUCHDOWN: Stage(
        "set down on the moving deck with a sink rate, level with the horizon, no rotor thrust, main wheels braked, "
        "the probe not yet held; then ten seconds on its wheels",
        {"wheels": "braked", "horizon_s": 10.0, "substep_s": 0.001},  # a touchdown needs the shorter step
        sinks=1.5,  # assumed
        policy="hold",
    ),
}
