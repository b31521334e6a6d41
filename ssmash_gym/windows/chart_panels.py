"""One panel of a figure of windows: every cell once, a bold line where the window ends, a hatch beyond the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ssmash_gym.windows.chart_layout import Layout, Place, Row
from ssmash_gym.windows.chart_looks import Paint, quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

Array = NDArray[np.float64]

THIN: Final[dict[str, Any]] = {"color": "0.45", "linewidth": 0.35, "solid_capstyle": "butt", "zorder": 3}
EDGE: Final = 1.6  # line where the window ends [pt]
WIDE: Final = 0.11  # between the lines of what lies beyond the model's validity, as a share of the panel
SMALL: Final = 6.6  # [pt]
MOST_TICKS: Final = 13


@dataclass(frozen=True)
class Drawing:
    """What a panel shows.

    Attributes:
        paint: Look of a cell from its row.
        inside: Whether a cell is on the inner side of the bold line; None draws no line.
        mark: Matplotlib's marker in the middle of a cell, and whether it is filled; None for none.
    """

    paint: Callable[[Row], Paint]
    inside: Callable[[Row], bool] | None = None
    mark: Callable[[Row], tuple[str, bool] | None] | None = None


def draw_panel(axes: Axes, layout: Layout, panel: int, rows: Mapping[Place, Row], how: Drawing, key: str) -> None:
    """Draw the cells of one panel.

    Args:
        axes: Where to.
        layout: Of the figure.
        panel: Which panel.
        rows: Cells of one stage and policy by their place.
        how: Their look.
        key: Beginning of the cells' identifiers; the cell's number follows.
    """
    own = {(i, j): row for (k, i, j), row in rows.items() if k == panel}
    axes.set_axis_off()
    for (i, j), row in own.items():
        patch, paint = _shape(layout, i, j), how.paint(row)
        patch.set(facecolor=paint.face, edgecolor=paint.ink, linewidth=0.0, zorder=1)
        patch.set(hatch=paint.hatch or None, gid=f"{key}{row['cell']}")
        axes.add_artist(patch)  # as add_patch, without looking for limits of the axes
        patch.set_clip_on(False)  # each clip would be told in the file
    _beyond_model(axes, layout, [place for place, row in own.items() if row.get("valid") is False])
    if layout.polar:
        _rings(axes, layout)
    else:
        _fields(axes, layout)
    if how.inside is not None:
        ends = [
            line for one, other, line in _neighbours(layout)
            if one in own and other in own and how.inside(own[one]) != how.inside(own[other])
        ]  # fmt: skip
        if ends:
            axes.plot(*_joined(ends), color="white", linewidth=EDGE + 1.4, solid_capstyle="round", zorder=4)
            axes.plot(*_joined(ends), color="black", linewidth=EDGE, solid_capstyle="round", zorder=5)
    if how.mark is not None:
        for place, row in own.items():
            _mark(axes, layout, place, how.mark(row))


def _mark(axes: Axes, layout: Layout, place: tuple[int, int], mark: tuple[str, bool] | None) -> None:
    if mark is not None:
        x, y = middle(layout, *place)
        face = "black" if mark[1] else "white"
        size = 2.6 if layout.polar and place[1] == 0 else 3.6
        axes.plot(
            [x],
            [y],
            mark[0],
            color=face,
            markersize=size,
            markeredgecolor="black",
            markeredgewidth=0.2 * size,
            zorder=6,
        )


def _joined(lines: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Several lines as one, with gaps."""
    gap = [np.nan]
    x, y = (np.concatenate([part for line in lines for part in (line[k], gap)]) for k in (0, 1))
    return x, y


def on_circle(angle_deg: Array | float, radius: Array | float) -> tuple[Array, Array]:
    """Place of an angle clockwise from the top [deg] and a radius."""
    angle = np.radians(angle_deg)
    return np.asarray(radius * np.sin(angle)), np.asarray(radius * np.cos(angle))


def middle(layout: Layout, i: int, j: int) -> tuple[float, float]:
    """Middle of a cell."""
    if not layout.polar:
        return i + 0.5, j + 0.5
    share = 0.7 if j == 0 else 0.5  # the innermost sectors are wider outside
    x, y = on_circle(layout.across.values[i], float((1.0 - share) * layout.radii[j] + share * layout.radii[j + 1]))
    return float(x), float(y)


def _shape(layout: Layout, i: int, j: int) -> Patch:
    """Outline of a cell."""
    from matplotlib.patches import Rectangle, Wedge

    if not layout.polar:
        return Rectangle((i, j), 1.0, 1.0)
    first, last = layout.sectors_deg
    inner, outer = layout.radii[j], layout.radii[j + 1]
    return Wedge((0.0, 0.0), outer, 90.0 - last[i], 90.0 - first[i], width=outer - inner)


def _neighbours(layout: Layout) -> Iterator[tuple[tuple[int, int], tuple[int, int], tuple[Array, Array]]]:
    """Pairs of neighbouring cells with the line between them."""
    around, rings = len(layout.across.values), len(layout.along.values)
    for i in range(around):
        for j in range(rings):
            if i + 1 < around or layout.closed:
                yield (i, j), ((i + 1) % around, j), _side(layout, i, j)
            if j + 1 < rings:
                yield (i, j), (i, j + 1), _top(layout, i, j)


def _side(layout: Layout, i: int, j: int) -> tuple[Array, Array]:
    """Line between a cell and the next one around."""
    if not layout.polar:
        return np.array([i + 1.0, i + 1.0]), np.array([float(j), j + 1.0])
    return on_circle(layout.sectors_deg[1][i], layout.radii[j : j + 2])


def _top(layout: Layout, i: int, j: int) -> tuple[Array, Array]:
    """Line between a cell and the next one outwards."""
    if not layout.polar:
        return np.array([float(i), i + 1.0]), np.array([j + 1.0, j + 1.0])
    first, last = layout.sectors_deg
    return on_circle(np.linspace(first[i], last[i], 9), layout.radii[j + 1])


def _beyond_model(axes: Axes, layout: Layout, places: list[tuple[int, int]]) -> None:
    """Wide diagonal lines over cells outside the seaway's validity, whatever their look."""
    from matplotlib.collections import LineCollection
    from matplotlib.path import Path
    from matplotlib.transforms import TransformedPath

    if not places:
        return
    shapes = [_shape(layout, i, j) for i, j in places]
    outline = Path.make_compound_path(*(one.get_patch_transform().transform_path(one.get_path()) for one in shapes))
    if layout.polar:
        low, wide, high = -1.0, 2.0, 2.0
    else:
        low, wide, high = 0.0, float(len(layout.across.values)), float(len(layout.along.values))
    starts = np.arange(-1.0, 1.0, WIDE)
    lines = [[(low + s * wide, low), (low + (s + 1.0) * wide, low + high)] for s in starts]
    for colour, width in (("white", 2.6), ("black", 1.1)):
        found = LineCollection(lines, colors=colour, linewidths=width, zorder=2)
        axes.add_collection(found, autolim=False)
        found.set_clip_path(TransformedPath(outline, axes.transData))


def _rings(axes: Axes, layout: Layout) -> None:
    """Outlines and words of a polar panel: ahead at the top, starboard at the right."""
    first, last = layout.sectors_deg
    spans = list(zip(first, last, strict=True))
    arcs = [on_circle(np.linspace(start, end, 9), radius) for start, end in spans for radius in layout.radii]
    rays = [on_circle(angle, layout.radii[[0, -1]]) for span in spans for angle in span]
    axes.plot(*_joined([*arcs, *rays]), **THIN)
    axes.set(xlim=(-1.19, 1.19), ylim=(-1.19, 1.19), aspect="equal")
    for angle, words, turn in ((0, "head 0°", 0), (90, "starboard 90°", -90), (180, "following 180°", 0),
                               (270, "port 270°", 90)):  # fmt: skip
        x, y = on_circle(angle, 1.1)
        axes.text(float(x), float(y), words, rotation=turn, ha="center", va="center", fontsize=SMALL + 0.4)
    for angle in (45, 135, 225, 315):
        x, y = on_circle(angle, 1.12)
        axes.text(float(x), float(y), f"{angle}", ha="center", va="center", fontsize=SMALL - 0.6, color="0.3")
    ray = float(first[np.argmin(np.abs((first - 37.5 + 180.0) % 360.0 - 180.0))])  # a border, aside of the words
    for j, value in enumerate(layout.along.values):
        x, y = on_circle(ray, float(0.5 * (layout.radii[j] + layout.radii[j + 1])))
        axes.text(
            float(x), float(y), f"{value:g}", ha="center", va="center", fontsize=SMALL - 0.6, zorder=7,
            bbox={"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "0.6", "linewidth": 0.3},
        )  # fmt: skip


def _fields(axes: Axes, layout: Layout) -> None:
    """Outlines, values and titles of a heat map."""
    across, along = layout.across, layout.along
    wide, high = len(across.values), len(along.values)
    upright = [(np.array([i, i]), np.array([0, high])) for i in range(wide + 1)]
    level = [(np.array([0, wide]), np.array([j, j])) for j in range(high + 1)]
    axes.plot(*_joined([*upright, *level]), **THIN)
    axes.set_axis_on()
    axes.grid(visible=False)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.tick_params(length=0, labelsize=SMALL, pad=2)
    axes.set(xlim=(-0.02 * wide, 1.02 * wide), ylim=(-0.02 * high, 1.02 * high))
    for axis, set_ticks in ((across, axes.set_xticks), (along, axes.set_yticks)):
        step = -(-len(axis.values) // MOST_TICKS)
        told = range(0, len(axis.values), step)
        set_ticks([k + 0.5 for k in told], [quantity(axis.values[k]) if axis.name else "" for k in told])
    for axis, label in ((across, axes.set_xlabel), (along, axes.set_ylabel)):
        label(axis.title, fontsize=SMALL + 0.4, labelpad=3, parse_math=False)
