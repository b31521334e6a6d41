"""Deck motion and traverse add up in the probe load: Feldman's finding (Léveillé 2013, section 1.1.1), measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.cases import Case, History, run_case
from ssmash_gym.cases.claw import StillClaw
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.sources import Fixed
from ssmash_gym.systems.models import at_full_scale, scaled_case
from ssmash_gym.systems.overlay import stilled

BOTH: Final = "both"
DECK: Final = "deck motion alone"
CLAW: Final = "traverse alone"


@dataclass(frozen=True)
class Parts:
    """A manoeuvre and its two parts, in the numbers of full scale.

    Attributes:
        case: The manoeuvre.
        scale: Length scale at which it was run.
        histories: By `BOTH`, `DECK` and `CLAW`.
        from_s: Time from which the load is measured, the end of the deck's ramp [s].
    """

    case: Case
    scale: float
    histories: Mapping[str, History]
    from_s: float

    @property
    def peak_kN(self) -> dict[str, float]:
        """Largest in-plane probe load."""
        return {
            name: 1e-3 * float(np.max(history.peak_max("probe_in_plane")[self._late(history)]))
            for name, history in self.histories.items()
        }

    @property
    def rms_kN(self) -> dict[str, float]:
        """Root mean square of the in-plane probe load."""
        return {
            name: 1e-3 * math.sqrt(np.mean(history["probe_in_plane"][self._late(history)] ** 2))
            for name, history in self.histories.items()
        }

    def _late(self, history: History) -> NDArray[np.bool_]:
        return np.asarray(history.time_s >= self.from_s - 1e-9)


def shares(figures: Mapping[str, float]) -> tuple[float, float]:
    """The figure of both over the sum of the parts, and over the root of the sum of their squares."""
    deck, claw = figures[DECK], figures[CLAW]
    return figures[BOTH] / (deck + claw), figures[BOTH] / math.hypot(deck, claw)


def has_parts(case: Case) -> bool:
    """Whether deck and claw both move."""
    return not isinstance(case.claw, StillClaw) and not isinstance(case.deck, Fixed)


def parts_of(case: Case, scale: float = 1.0) -> Parts:
    """Run a manoeuvre, its deck motion alone, and its traverse alone.

    Args:
        case: A case in which the deck and the claw move.
        scale: Length scale to run it at.

    Raises:
        ConfigurationError: Deck or claw do not move, or the case cannot be scaled.
    """
    if not has_parts(case):
        raise ConfigurationError(f"case {case.name} has no two parts: its deck and its claw must both move.")
    cases = {
        BOTH: case,
        DECK: case.changed({"claw": stilled(case)}),
        CLAW: case.changed({"deck": {"type": "fixed"}, "ramp_s": 0.0}),
    }
    histories = {name: at_full_scale(run_case(scaled_case(part, scale)), part, scale) for name, part in cases.items()}
    return Parts(case, scale, histories, case.solution.start_s + case.ramp_s)


def parts_table(parts: Mapping[str, Parts]) -> str:
    """The loads of both and of each part, and what both are of the sum, as Markdown; rows by the titles given."""
    head = ["", DECK, CLAW, BOTH, "both / sum", "both / root of squares"]
    rows = [head, ["---", *("---:" for _ in head[1:])]]
    for title, part in parts.items():
        for name, figures in (("peak [kN]", part.peak_kN), ("RMS [kN]", part.rms_kN)):
            plain, square = shares(figures)
            loads = [f"{figures[key]:.2f}" for key in (DECK, CLAW, BOTH)]
            rows.append([f"{title}, {name}", *loads, f"{plain:.2f}", f"{square:.2f}"])
    return "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"
