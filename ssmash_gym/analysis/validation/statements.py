"""What the thesis states in words or by its axes, each beside the numbers that come out.

A statement measures a few named numbers in the runs of a manoeuvre, tells them in a sentence and says whether they
agree with the thesis. A statement that does not hold is shown as such; it is never left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from ssmash_gym.cases import History

Basis = Literal["words", "axis", "expected"]
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Runs:
    """Histories of one manoeuvre.

    Attributes:
        default: As the case file describes it.
        variants: The same manoeuvre with one thing changed, by the variant's name (`manoeuvres.Variant`); only those
            that were asked for.
    """

    default: History
    variants: Mapping[str, History] = field(default_factory=dict)


@dataclass(frozen=True)
class Statement:
    """One statement of the thesis about a manoeuvre, and how it is checked.

    Args:
        thesis: What the thesis says, in words or by the axis it prints.
        source: Section and figure.
        measure: The numbers of the runs that the statement is about, by name, in plotting units.
        words: How the numbers are told: a format string with their names, ``"z {z_m:.4f} m"``.
        holds: Whether these numbers agree with the thesis.
        taken_as: How the words were made checkable: the bounds that `holds` uses; "" where they say it themselves.
        basis: ``words``: the text states it; ``axis``: read off the printed limits of an axis; ``expected``: not in
            the thesis, but what its model implies.
        chosen: What of the reconstruction was chosen with this statement in view, so that its holding is no test;
            "" where nothing was.
        note: What a reader has to know, for example why it does not hold.
        needs: Names of the variants without which the statement is not measured.
    """

    thesis: str
    source: str
    measure: Callable[[Runs], Numbers]
    words: str
    holds: Callable[[Numbers], bool]
    taken_as: str = ""
    basis: Basis = "words"
    chosen: str = ""
    note: str = ""
    needs: tuple[str, ...] = ()

    def check(self, runs: Runs) -> Finding | None:
        """Measure the statement; None when a variant that it needs was not run."""
        if any(name not in runs.variants for name in self.needs):
            return None
        numbers = {name: float(value) for name, value in self.measure(runs).items()}
        return Finding(self, numbers, bool(self.holds(numbers)))


@dataclass(frozen=True)
class Finding:
    """A statement with the numbers that were found and whether it holds."""

    statement: Statement
    numbers: Numbers
    holds: bool

    @property
    def simulated(self) -> str:
        """What is simulated, in words."""
        return self.statement.words.format(**self.numbers)
