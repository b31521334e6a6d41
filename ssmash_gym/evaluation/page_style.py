"""How a policy looks, the same in every figure and in the film: colour, line and marker, distinct in grey as well."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

Rgb = tuple[int, int, int]


@dataclass(frozen=True)
class Style:
    """Look of one policy.

    Attributes:
        colour: On white paper, ``#rrggbb``.
        bright: The same on the dark of the film.
        dash: Matplotlib's line style.
        marker: Matplotlib's marker.
        width: Of lines [pt].
    """

    colour: str
    bright: Rgb
    dash: Any
    marker: str
    width: float = 1.5


# Colours of Okabe and Ito (2008), which nearly everybody tells apart; dash and marker do without colour.
FIRST: Final = Style("#d55e00", (255, 140, 64), "-", "o", 2.4)
OTHERS: Final = (
    Style("#0072b2", (96, 180, 255), (0, (6, 2)), "s"),
    Style("#1a1a1a", (235, 235, 235), (0, (1, 1.2)), "^"),
    Style("#009e73", (70, 214, 160), (0, (6, 2, 1, 2)), "D"),
    Style("#aa5588", (238, 160, 205), (0, (3, 1.5)), "v"),
    Style("#8a6d00", (240, 200, 60), (0, (8, 2, 1, 2, 1, 2)), "P"),
    Style("#3a8fc4", (140, 215, 250), "-", "X"),
    Style("#7a7a7a", (170, 176, 186), (0, (2, 2.5)), "d"),
)


def styles(policies: Iterable[str], first: str | None = None) -> dict[str, Style]:
    """A style for each policy, by name, in the order given; `first` is the one that stands out."""
    found: dict[str, Style] = {}
    for name in policies:
        free = len(found) - (first in found)
        found[name] = FIRST if name == first else OTHERS[free % len(OTHERS)]
    return found


def sample(style: Style) -> str:
    """A piece of a policy's line with its marker, as inline SVG."""
    dash = "" if style.dash == "-" else f' stroke-dasharray="{" ".join(f"{1.5 * one:g}" for one in style.dash[1])}"'
    line = f'<path d="M0 6H34" stroke="{style.colour}" stroke-width="{1.2 * style.width:g}"{dash}/>'
    mark = f'<path d="{MARKS[style.marker]}" fill="{style.colour}"/>'
    return f'<svg class="key" viewBox="0 0 34 12" aria-hidden="true">{line}{mark}</svg>'


# Outlines about (17, 6) of Matplotlib's markers.
MARKS: Final = {
    "o": "M13 6a4 4 0 1 0 8 0a4 4 0 1 0-8 0Z",
    "s": "M13.4 2.4h7.2v7.2h-7.2Z",
    "^": "M17 1.6l4.4 8h-8.8Z",
    "v": "M17 10.4l4.4-8h-8.8Z",
    "D": "M17 1.2L21.8 6L17 10.8L12.2 6Z",
    "d": "M17 1.2L20 6L17 10.8L14 6Z",
    "P": "M15.4 2h3.2v2.4H21v3.2h-2.4V10h-3.2V7.6H13V4.4h2.4Z",
    "X": "M13.4 3.6l1.8-1.8L17 3.6l1.8-1.8l1.8 1.8L18.8 6l1.8 2.4l-1.8 1.8L17 8.4l-1.8 1.8l-1.8-1.8L15.2 6Z",
}
