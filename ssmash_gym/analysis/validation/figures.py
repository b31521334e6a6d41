"""Figures of section 3.2 in plain data: the thesis' quantities on the thesis' axes; `picture` draws them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

LINE: Final = 1.0e-3  # share of an axis that the line of its frame hides


@dataclass(frozen=True)
class Curve:
    """One curve: the name of a quantity (`ssmash_gym.cases.QUANTITIES`) and its label ("" for the run's own)."""

    quantity: str
    label: str = ""


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Args:
        curves: What is drawn.
        label: Of the vertical axis, as printed.
        limits: Printed limits of the vertical axis.
        step: Between its printed marks.
        title: Of the panel, "" for none.
    """

    curves: tuple[Curve, ...]
    label: str
    limits: tuple[float, float]
    step: float
    title: str = ""

    def holds(self, value: float) -> bool:
        """Whether a value lies within the printed limits; the line of a frame hides a thousandth of the axis."""
        slack = LINE * (self.limits[1] - self.limits[0])
        return self.limits[0] - slack <= value <= self.limits[1] + slack

    @property
    def digits(self) -> int:
        """Decimals in which values of this axis are told: one more than its marks have, and one at least."""
        return max(1, math.ceil(-math.log10(self.step)) + 1)


def panel(quantity: str, label: str, limits: tuple[float, float], step: float, title: str = "") -> Panel:
    """A pair of axes with one curve, see `Panel`."""
    return Panel((Curve(quantity),), label, limits, step, title)


@dataclass(frozen=True)
class Figure:
    """One figure of the thesis.

    Args:
        number: Of the figure, ``3.2``.
        title: What it shows, without the words "versus time for validation case".
        panels: From top to bottom.
        seconds: Printed limits of the time axis.
        seconds_step: Between its marks.
    """

    number: str
    title: str
    panels: tuple[Panel, ...]
    seconds: tuple[float, float]
    seconds_step: float
