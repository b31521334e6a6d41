"""Figures of a study as text: a value, and the interval behind it in brackets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def percent(figure: Mapping[str, Any], *, short: bool = False) -> str:
    """A share in percent, with its interval unless `short`."""
    return number(figure, factor=100.0, short=short)


def number(
    figure: Mapping[str, Any], digits: int = 1, *, factor: float = 1.0, short: bool = False, none: str = "-"
) -> str:
    """A figure with its interval unless `short`.

    Args:
        figure: Its ``value`` and ``ci``, as in ``summary.json``; either may be None.
        digits: Behind the point.
        factor: From the figure's unit to that of the text.
        short: Leave the interval out.
        none: What stands for a figure that there is not.
    """
    if figure["value"] is None:
        return none
    value = f"{factor * figure['value']:.{digits}f}"
    if short or figure["ci"] is None:
        return value
    low, high = (f"{factor * bound:.{digits}f}" for bound in figure["ci"])
    return f"{value} [{low}, {high}]"
