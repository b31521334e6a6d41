"""Real time: control steps at fixed instants of the wall clock, and a count of those that came late."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Pace:
    """Instants at which control steps are due.

    A step that is late does not move the next ones, unless it is late by a whole interval: then time has slipped, and
    the schedule starts anew, for a person cannot drive two steps at once. Steps that fell into the lost time count as
    late ones: whoever had to wait for seconds has had seconds to think.

    Attributes:
        interval_s: Between two steps [s].
        late_after_s: How much later than planned a step may be taken [s].
        due_s: When the next step is due, on the caller's clock [s].
        steps, late: Steps that were due so far, and how many of them were taken late or lost.
    """

    interval_s: float
    late_after_s: float
    due_s: float
    steps: int = 0
    late: int = 0

    def take(self, now_s: float) -> bool:
        """A step is taken now; returns whether it is late."""
        behind_s = now_s - self.due_s
        late = behind_s > self.late_after_s
        lost = max(0, int(behind_s // self.interval_s))
        self.steps += 1 + lost
        self.late += late + lost
        self.due_s = now_s + self.interval_s if lost else self.due_s + self.interval_s
        return late
