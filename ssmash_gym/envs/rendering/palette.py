"""Colours, and what a load's colour is."""

from __future__ import annotations

from typing import Final

Colour = tuple[int, int, int]

PANEL: Final[Colour] = (17, 23, 31)
PANEL_EDGE: Final[Colour] = (48, 59, 72)
PLOT: Final[Colour] = (24, 32, 42)
GRID: Final[Colour] = (44, 55, 68)
TEXT: Final[Colour] = (226, 232, 240)
FAINT: Final[Colour] = (140, 154, 170)
GOOD: Final[Colour] = (74, 200, 120)
SOFT: Final[Colour] = (244, 190, 60)
BAD: Final[Colour] = (240, 72, 62)
LIFTED: Final[Colour] = (108, 178, 255)
STATION: Final[tuple[Colour, ...]] = ((250, 204, 92), (92, 208, 160), (110, 170, 255))
PROBE: Final[Colour] = (255, 140, 70)

SKY: Final[tuple[Colour, Colour]] = ((92, 138, 184), (206, 222, 234))  # zenith, horizon
SEA: Final[tuple[Colour, Colour]] = ((122, 158, 182), (24, 66, 98))  # horizon, near
FOAM: Final[Colour] = (176, 202, 216)
DECK: Final[Colour] = (92, 99, 106)
DECK_SHADOW: Final[Colour] = (66, 72, 79)
PAINT: Final[Colour] = (226, 228, 224)
HULL: Final[Colour] = (74, 87, 102)
TIRE: Final[Colour] = (40, 43, 48)
RIM: Final[Colour] = (176, 182, 188)
STRUT: Final[Colour] = (206, 212, 218)


def blend(a: Colour, b: Colour, share: float) -> Colour:
    """`a` for a share of 0, `b` for 1."""
    s = min(1.0, max(0.0, share))
    return (
        round(a[0] + s * (b[0] - a[0])),
        round(a[1] + s * (b[1] - a[1])),
        round(a[2] + s * (b[2] - a[2])),
    )


def load_colour(load: float, limit: float) -> Colour:
    """Green up to half the limit, amber at four fifths of it, red from the limit on."""
    share = load / limit
    if share < 0.8:
        return blend(GOOD, SOFT, (share - 0.5) / 0.3)
    return blend(SOFT, BAD, (share - 0.8) / 0.2)


def tire_colour(load: float, limit: float, lift_off: float) -> Colour:
    """Blue while the wheel counts as lifted, else as `load_colour`."""
    return LIFTED if load < lift_off else load_colour(load, limit)


def probe_colour(load: float, soft: float, cost: float) -> Colour:
    """Green below the soft limit, amber up to the cost limit, red above."""
    if load < soft:
        return GOOD
    return SOFT if load < cost else BAD
