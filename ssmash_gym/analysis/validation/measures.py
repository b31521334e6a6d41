"""What statements are made of: values, spans and settling of a run's quantities, and the printed axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.analysis.validation.figures import Figure
from ssmash_gym.analysis.validation.statements import Numbers, Runs, Statement

if TYPE_CHECKING:
    from ssmash_gym.cases import History

Array = NDArray[np.float64]


def curve(history: History, name: str) -> Array:
    """A quantity at the rows of a history, in plotting units, (m,)."""
    from ssmash_gym.cases import quantity

    return quantity(name).of(history)


def span(history: History, name: str, from_s: float = -np.inf, to_s: float = np.inf) -> tuple[float, float]:
    """Least and greatest value of a quantity within a time."""
    values = curve(history, name)[(history.time_s >= from_s) & (history.time_s <= to_s)]
    return float(np.min(values)), float(np.max(values))


def swing(history: History, name: str, from_s: float = -np.inf, to_s: float = np.inf) -> float:
    """Greatest less least value of a quantity within a time."""
    least, greatest = span(history, name, from_s, to_s)
    return greatest - least


def value_at(history: History, name: str, time_s: float) -> float:
    """A quantity at one time, linear between the rows."""
    return float(np.interp(time_s, history.time_s, curve(history, name)))


def final(history: History, name: str) -> float:
    """A quantity at the end."""
    return float(curve(history, name)[-1])


def settled_from(history: History, name: str, band: float) -> float:
    """The time [s] from which a quantity stays within `band` of its final value."""
    values = curve(history, name)
    outside = np.flatnonzero(np.abs(values - values[-1]) > band)
    return float(history.time_s[0 if outside.size == 0 else min(outside[-1] + 1, values.size - 1)])


def maxima(history: History, name: str, prominence: float, from_s: float = -np.inf, to_s: float = np.inf) -> Array:
    """Times [s] at which a quantity has a local maximum that stands out by `prominence`, (k,)."""
    from scipy.signal import find_peaks

    inside = (history.time_s >= from_s) & (history.time_s <= to_s)
    rows = find_peaks(curve(history, name)[inside], prominence=prominence)[0]
    return np.asarray(history.time_s[inside][rows])


def inside_axes(figure: Figure, chosen: str = "", note: str = "") -> Statement:
    """The statement that every curve of a figure stays within the limits that the thesis prints.

    The limits were chosen for the thesis' own curves, so a curve that leaves them differs from those; the reverse
    does not follow. Measured are the least and the greatest value of each curve, in the order of panels.

    Args:
        figure: The figure.
        chosen: What was chosen with these axes in view.
        note: What a reader has to know.
    """
    curves = [(one, panel) for panel in figure.panels for one in panel.curves]

    def measure(runs: Runs) -> dict[str, float]:
        numbers = {}
        for k, (one, _) in enumerate(curves):
            numbers[f"least_{k}"], numbers[f"greatest_{k}"] = span(runs.default, one.quantity, *figure.seconds)
        return numbers

    def holds(numbers: Numbers) -> bool:
        return all(
            panel.holds(numbers[f"least_{k}"]) and panel.holds(numbers[f"greatest_{k}"])
            for k, (_, panel) in enumerate(curves)
        )

    printed = dict.fromkeys(f"{panel.limits[0]:g} to {panel.limits[1]:g}" for _, panel in curves)
    unit = figure.panels[0].label.partition("[")[2].rstrip("]")
    names = [(one.label or panel.title) if len(curves) > 1 else "" for one, panel in curves]
    forms = [f"z.{panel.digits}f" for _, panel in curves]  # z: no minus before a zero
    named = enumerate(zip(names, forms, strict=True))
    told = [f"{name} {{least_{k}:{form}}} to {{greatest_{k}:{form}}}".strip() for k, (name, form) in named]
    return Statement(
        thesis=f"{figure.title}: printed axis {', '.join(printed)} {unit}",
        source=f"figure {figure.number}",
        measure=measure,
        words=", ".join(told) + f" {unit}",
        holds=holds,
        basis="axis",
        chosen=chosen,
        note=note,
    )
