"""Where each cell of a sweep stands in a figure: sectors of polar charts, or fields of heat maps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.windows.chart_looks import quantity

Array = NDArray[np.float64]
Place = tuple[int, int, int]  # panel, place around (or across), ring (or row)
Row = dict[str, Any]

ROUND: Final = (("waves_from_deg", "speed_kn"), ("wind_from_deg", "wind_speed_mps"))  # angle and radius
FEWEST_SECTORS: Final = 3  # of a polar chart
MOST_PANELS: Final = 24  # of a policy in one figure
MOST_IN_LINE: Final = 6
MIDDLE: Final = (0.45, 0.7)  # hole in the middle, and what the innermost ring is wider than others by: it holds sectors
ALONE: Final = 0.0  # place along an axis that there is not
NEEDED: Final = ("stage", "policy", "cell", "episodes", "share", "low", "high", "verdict", "limiting")


@dataclass(frozen=True)
class Axis:
    """One axis of the sweep: name of its column, label, unit, and the values in order."""

    name: str
    label: str
    unit: str
    values: tuple[float, ...]

    def told(self, value: float) -> str:
        """One value in words."""
        return f"{self.label.split(',')[0]} {quantity(value, self.unit)}"

    @property
    def title(self) -> str:
        """The axis as it is written beside a chart."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class Layout:
    """Figure of a sweep: a panel for each combination of all axes but two.

    Attributes:
        across: Axis of the angle; in a heat map, the horizontal one.
        along: Axis of the radius; in a heat map, the vertical one.
        polar: Whether the panels are polar charts.
        others: The other axes; the last one varies from panel to panel first.
        panels: Values of the other axes, one tuple a panel.
        left_out: Number of combinations that have no panel.
    """

    across: Axis
    along: Axis
    polar: bool
    others: tuple[Axis, ...]
    panels: tuple[tuple[float, ...], ...]
    left_out: int = 0

    @property
    def in_line(self) -> int:
        """Panels in one line."""
        most = len(self.others[-1].values) if self.others else 1
        return min(most, MOST_IN_LINE, len(self.panels)) if most <= MOST_IN_LINE else min(4, len(self.panels))

    @property
    def lines(self) -> int:
        """Lines of panels of one policy."""
        return -(-len(self.panels) // self.in_line)

    def title(self, panel: int) -> str:
        """What a panel stands for."""
        return ", ".join(axis.told(value) for axis, value in zip(self.others, self.panels[panel], strict=True))

    @cached_property
    def _index(self) -> tuple[dict[tuple[float, ...], int], dict[float, int], dict[float, int]]:
        panels = {tuple(map(_key, values)): k for k, values in enumerate(self.panels)}
        across, along = ({_key(value): k for k, value in enumerate(one.values)} for one in (self.across, self.along))
        return panels, across, along

    def place(self, row: Mapping[str, Any]) -> Place | None:
        """Where a row of the table stands; None if its panel is left out or a coordinate is missing."""
        panels, across, along = self._index
        values = [row[axis.name] if axis.name else ALONE for axis in (*self.others, self.across, self.along)]
        if any(value is None for value in values):
            return None
        *panel, i, j = map(_key, values)
        return (panels[tuple(panel)], across[i], along[j]) if tuple(panel) in panels else None

    def places(self, rows: Iterable[Row]) -> dict[Place, Row]:
        """Rows of one stage and policy by their place."""
        return {place: row for row in rows if (place := self.place(row)) is not None}

    @cached_property
    def sectors_deg(self) -> tuple[Array, Array]:
        """First and last angle of each sector [deg], (k,), clockwise from ahead; they meet half way."""
        at = np.array(self.across.values)
        gaps = np.append(np.diff(at), at[0] + 360.0 - at[-1]) if at.size > 1 else np.array([360.0])
        usual = min(float(np.median(gaps)), 90.0)
        half = 0.5 * np.where(gaps > 1.5 * usual, usual, gaps)
        return at - np.roll(half, 1), at + half

    @cached_property
    def radii(self) -> Array:
        """Radii of the rings, (k + 1,), up to 1; a small hole keeps the innermost sectors apart."""
        hole, wider = MIDDLE
        borders = np.concatenate([[hole], hole + wider + 1.0 + np.arange(len(self.along.values))])
        return np.asarray(borders / borders[-1])

    @property
    def closed(self) -> bool:
        """Whether the last sector meets the first one."""
        first, last = self.sectors_deg
        return self.polar and len(self.across.values) > 1 and bool(np.isclose(first[0] + 360.0, last[-1]))


def _key(value: float) -> float:
    return round(float(value), 9)


def checked(cells: pl.DataFrame, document: Mapping[str, Any]) -> None:
    """Check that a table of cells can be drawn.

    Raises:
        ConfigurationError: A column is missing.
    """
    missing = [name for name in (*NEEDED, *document.get("axes", {})) if name not in cells.columns]
    if missing:
        raise ConfigurationError(f"The table of cells has no column {', '.join(missing)}: it cannot be drawn.")
    if not document.get("axes"):
        raise ConfigurationError("The document of the window has no axes: its cells cannot be drawn.")


def axes_of(cells: pl.DataFrame, document: Mapping[str, Any]) -> list[Axis]:
    """The axes of a sweep, in the document's order, with all values that the document or the table knows."""
    found = []
    for name, one in document["axes"].items():
        values = {*map(_key, one.get("values") or ()), *map(_key, cells[name].drop_nulls().unique())}
        found.append(Axis(name, str(one.get("label") or name), str(one.get("unit") or ""), tuple(sorted(values))))
    return found


def layout_of(cells: pl.DataFrame, document: Mapping[str, Any]) -> Layout:
    """Polar charts where the sweep has a direction and a speed; else heat maps of the two longest axes.

    Raises:
        ConfigurationError: A column is missing.
    """
    checked(cells, document)
    axes = axes_of(cells, document)
    named = {axis.name: axis for axis in axes}
    pair = next((pair for pair in ROUND if all(name in named for name in pair)), None)
    polar = pair is not None and len(named[pair[0]].values) >= FEWEST_SECTORS
    if pair is not None and polar:
        across, along = named[pair[0]], named[pair[1]]
    else:
        across, along = _longest(axes)
    rest = sorted((one for one in axes if one not in (across, along)), key=lambda one: len(one.values))
    panels = list(product(*(one.values for one in rest)))
    return Layout(across, along, polar, tuple(rest), tuple(panels[:MOST_PANELS]), max(0, len(panels) - MOST_PANELS))


def _longest(axes: Sequence[Axis]) -> tuple[Axis, Axis]:
    """The two axes with the most values; one without a name where there is only one axis."""
    ordered = sorted(axes, key=lambda one: -len(one.values))
    return ordered[0], ordered[1] if len(ordered) > 1 else Axis("", "", "", (ALONE,))


def ordered_names(document: Mapping[str, Any], key: str, cells: pl.DataFrame, column: str) -> list[str]:
    """Stages or policies of a table, in the document's order."""
    here = cells[column].unique(maintain_order=True).to_list()
    return [*(name for name in document.get(key) or () if name in here),
            *(name for name in here if name not in (document.get(key) or ()))]  # fmt: skip
