"""Which episode comes next, and where its record goes: a free drive here, a session by protocol in `trials.session`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.evaluation.conditions import Condition
from ssmash_gym.trials.files import write_trial
from ssmash_gym.trials.session import Assignment
from ssmash_gym.trials.trial import FREE, Trial


class Programme(Protocol):
    """What the console asks of a free drive or a session."""

    @property
    def condition(self) -> Condition:
        """What is simulated."""

    @property
    def participant(self) -> str:
        """Code of who drives; empty in a free drive."""

    def next(self) -> Assignment | None:
        """The episode to drive now; None when there is none left."""

    def about(self, assignment: Assignment) -> dict[str, Any]:
        """What the episode's record says of it."""

    def begin(self, assignment: Assignment) -> None:
        """Its first control step comes now: from here on its sea has been seen."""

    def keep(self, trial: Trial) -> Path:
        """Write the record of the last assignment's episode."""


@dataclass
class FreeDrive:
    """Sea after sea, as long as somebody likes; every episode is recorded.

    Args:
        condition: What is simulated; may be changed between episodes.
        seed: Of the next episode.
        folder: For the records.

    Raises:
        ConfigurationError: The seed is negative.
    """

    condition: Condition
    seed: int
    folder: Path
    number: int = 1

    participant = ""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigurationError(f"--seed {self.seed} is refused: it must not be negative.")

    def next(self) -> Assignment:
        """The present sea."""
        return Assignment(seed=self.seed, phase=FREE, number=self.number, of=0, attempt=1)

    def about(self, assignment: Assignment) -> dict[str, Any]:
        """Nothing but that it is a free drive."""
        return {"session": {"number": assignment.number, "of": 0, "phase": FREE, "id": ""}}

    def begin(self, assignment: Assignment) -> None:
        """Nothing: a free drive's seas may come as often as one likes."""

    def on(self) -> None:
        """Go on to the next sea."""
        self.seed += 1

    def keep(self, trial: Trial) -> Path:
        """Write the record under the next free number."""
        taken = (path.name.split("-")[1] for path in self.folder.glob("drive-*-seed*.parquet"))
        number = max((int(word) for word in taken if word.isdigit()), default=0) + 1
        path = self.folder / f"drive-{number:04d}-seed{trial.seed}.parquet"
        write_trial(path, trial)
        self.number += 1
        return path
