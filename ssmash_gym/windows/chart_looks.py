"""How a cell of a window looks: fill and hatch by verdict and limit, distinct in colour and in grey."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from ssmash_gym.windows.sequential import BEYOND, WITHIN

FIXED: Final = "\N{NO-BREAK SPACE}"
SIGNS: Final = {"above": ">", "below": "<"}  # of what lies beyond a limit


@dataclass(frozen=True)
class Paint:
    """Look of one cell.

    Attributes:
        face: Fill, ``#rrggbb``.
        hatch: Matplotlib's hatch.
        ink: Colour of the hatch.
    """

    face: str
    hatch: str = ""
    ink: str = "#ffffff"


INSIDE: Final = Paint("#dcefe6")  # nearly white in grey; white itself stands for no data
OPEN: Final = Paint("#c6c6c6", "....", "#333333")
# Colours of Okabe and Ito (2008), yellow darkened: all darker in grey than what is not beyond.
LIMITS: Final = (
    Paint("#0072b2"),
    Paint("#d55e00", "////"),
    Paint("#1a1a1a"),
    Paint("#009e73", "\\\\\\\\"),
    Paint("#cc79a7", "xxxx", "#1a1a1a"),
    Paint("#e69f00", "||||", "#1a1a1a"),
    Paint("#56b4e9", "----", "#1a1a1a"),
    Paint("#8a6d00", "++++"),
)
UNNAMED: Final = Paint("#6b6b6b", "oo")  # beyond, but no limit is named


def limit_looks(limits: Iterable[str]) -> dict[str, Paint]:
    """Look of cells that are beyond by each limit, in the order given; from the ninth on the hatches change."""
    hatches = [one.hatch for one in LIMITS if one.hatch]
    looks = {}
    for k, name in enumerate(limits):
        own, turn = LIMITS[k % len(LIMITS)], k // len(LIMITS)
        at = hatches.index(own.hatch) if own.hatch else -1
        looks[name] = Paint(own.face, hatches[(at + turn) % len(hatches)] if turn else own.hatch, own.ink)
    return looks


def verdict_look(row: Mapping[str, Any], looks: Mapping[str, Paint]) -> Paint:
    """Look of a cell by its verdict; of one that is beyond, by the limit that was exceeded most."""
    if row["verdict"] == WITHIN:
        return INSIDE
    return looks.get(row.get("limiting") or "", UNNAMED) if row["verdict"] == BEYOND else OPEN


def limit_words(name: str, limit: Mapping[str, Any], *, note: bool = False) -> str:
    """A limit as it is told: what, above or below which value lies beyond, and on which ground if `note`."""
    told = f"{limit.get('label') or name} {beyond_words(limit)}".rstrip()
    return f"{told} ({limit['note']})" if note and limit.get("note") else told


def beyond_words(limit: Mapping[str, Any]) -> str:
    """What lies beyond a limit: sign, value and unit; nothing for one that has no figure."""
    if limit.get("value") is None:
        return ""
    return f"{SIGNS.get(str(limit.get('sense', 'above')), '>')}{FIXED}{quantity(limit['value'], limit.get('unit'))}"


def quantity(value: object, unit: object = "") -> str:
    """A value with its unit; degrees as their sign."""
    number = (f"{value:g}" if isinstance(value, int | float) else str(value)).replace("-", "−")
    return f"{number}{'' if unit in ('', '1', None) else '°' if unit == 'deg' else f'{FIXED}{unit}'}"


def share_words(share: float) -> str:
    """A share in percent, without needless digits."""
    return f"{100 * share:.3g}{FIXED}%"
