"""The manoeuvres of section 3.2: a case file, the thesis' figures and its statements; the table of all seven.

How to plug in:

* a manoeuvre is a `Manoeuvre`; `spatial.SPATIAL` (1A-1D) and `planar.PLANAR` (2A-2C) are the tuples of them;
* a change of one thing that is run beside a manoeuvre is a `Variant`: its `changes` are dotted keys for
  `Case.changed`. ``suspects.SUSPECTS`` maps a manoeuvre's name to its variants; `friction_variant` makes that
  of ``--friction independent``. Statements about a variant name it in their `needs`; they stand with the variant, or
  with the manoeuvre;
* other systems are laid over the manoeuvre's case by `ssmash_gym.systems.apply`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from ssmash_gym.analysis.validation.figures import Figure
from ssmash_gym.analysis.validation.statements import Statement
from ssmash_gym.errors import ConfigurationError


@dataclass(frozen=True)
class Variant:
    """A manoeuvre with one thing changed, run beside it and drawn into the same figures.

    Args:
        name: Short name, as it goes into file names and into `Runs.variants`.
        label: Of its curves.
        changes: Dotted keys and values for `Case.changed`.
        words: What it is and where the thesis suspects it.
        figures: Numbers of the manoeuvre's figures in which it is drawn; empty for all.
        statements: What it is expected to do.
    """

    name: str
    label: str
    changes: Mapping[str, Any]
    words: str = ""
    figures: tuple[str, ...] = ()
    statements: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class Manoeuvre:
    """One validation case of section 3.2.

    Args:
        name: As the thesis calls it, ``1A`` to ``2C``.
        title: Its title.
        figures: The thesis' figures, in their order.
        statements: What the thesis says about them.
        loads: Telemetry channels in whose peaks two integrators are compared.
        case: Name of the case file in ``configs/manoeuvres``; the lower-case name unless given.
    """

    name: str
    title: str
    figures: tuple[Figure, ...]
    statements: tuple[Statement, ...]
    loads: tuple[str, ...] = ("auxiliary_vertical_load", "right_vertical_load", "left_vertical_load")
    case: str = ""

    @property
    def case_name(self) -> str:
        """Name of the case file without its suffix."""
        return self.case or self.name.lower()


def friction_variant(law: str) -> Variant:
    """The manoeuvre with another friction law of the tires (``--friction``)."""
    labels = {
        "independent": "friction of the tires not coupled with twist (thesis)",
        "friction_circle": "friction circle, not coupled with twist",
        "limit_surface": "friction coupled with twist",
    }
    words = {
        "independent": (
            "Longitudinal and lateral force and twist moment of a tire are each limited on their own, as in the "
            "thesis; the default couples them in one limit surface (recommendation 1 of section 4.2)."
        )
    }
    return Variant(law, labels.get(law, law), {"model.friction": law}, words.get(law, ""))


def suspects_of(name: str) -> tuple[Variant, ...]:
    """Variants that show what the thesis suspects behind a manoeuvre's misfits (``--suspects``); none for 1A-1D."""
    from ssmash_gym.analysis.validation.suspects import SUSPECTS

    return SUSPECTS.get(name, ())


def manoeuvres() -> dict[str, Manoeuvre]:
    """All manoeuvres by name, in the order of the thesis."""
    found: list[Manoeuvre] = []
    for module, attribute in (("spatial", "SPATIAL"), ("planar", "PLANAR")):
        found += getattr(import_module(f"ssmash_gym.analysis.validation.{module}"), attribute)
    return {manoeuvre.name: manoeuvre for manoeuvre in found}


def manoeuvre_named(name: str) -> Manoeuvre:
    """The manoeuvre called `name`, whatever its case.

    Raises:
        ConfigurationError: There is none.
    """
    table = manoeuvres()
    if name.upper() not in table:
        raise ConfigurationError(f"There is no manoeuvre {name!r}; there are {', '.join(table)} and all.")
    return table[name.upper()]
