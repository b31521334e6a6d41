"""A record of deck motion as one picture: the whole record, two minutes of it, and the spectra (extra ``plot``)."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ssmash_gym.analysis.motion_record import QUANTITIES, Record, Spectra, record_spectrum
from ssmash_gym.errors import require
from ssmash_gym.png import save_png
from ssmash_gym.ship.kinematics import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WINDOW_S: Final = 120.0
LONGER: Final = 1.5  # a record so many times as long as the window has a column of its own
LINE_S: Final = 300.0  # a shorter record's spectrum says nothing beside the long run's
SHOWN: Final = ("roll_deg", "pitch_deg", "vertical_velocity_m_s", "lateral_specific_force_g")
WORST: Final = "lateral_specific_force_g"  # the window is laid about its largest value
STRETCHES: Final = 300  # of the whole record, each drawn from its least to its greatest value
LINE, FILL, LONG_RUN, MARK = "#12344d", "#9db8cc", "#e08e45", "#f6e7d4"
WIDTH_IN: Final = 12.5
LABELS_IN: Final = 0.47  # from the left edge to the end of the labels of the rows
LINE_CHARACTERS: Final = 165  # that fit into the width at the size of the words under the title
NOTED: Final = 0.1  # share of the RMS from which a mean is told
DPI: Final = 100
COLOURS: Final = 128
HIGHEST_RADPS: Final = 2.0  # a ship of a hundred metres does not answer faster waves
QUIET: Final = "0.45"  # grey of what is not data
NEEDS_MATPLOTLIB: Final = '--plot needs Matplotlib: pip install "ssmash_gym[plot]".'


def window_about_worst(record: Record) -> slice:
    """Rows of the two minutes about the largest lateral specific force; all of a shorter record."""
    step = float(record.time_s[1] - record.time_s[0])
    rows = min(round(WINDOW_S / step) + 1, len(record.time_s))
    values = record.series[WORST]
    worst = int(np.argmax(np.abs(values - np.mean(values))))
    first = min(max(0, worst - rows // 2), len(values) - rows)
    return slice(first, first + rows)


def draw_picture(
    path: Path,
    record: Record,
    spectra: Spectra | None,
    long_run: Mapping[str, float],
    words: tuple[str, Sequence[str], str],
    metadata: Mapping[str, str],
) -> None:
    """Draw the picture as PNG.

    Three columns: the whole record, two minutes of it, spectra. A short record has the first two in one.

    Args:
        path: File to write.
        record: The record.
        spectra: Long-run spectra of the seaway; None for a motion that is no seaway.
        long_run: Long-run RMS by the keys of `QUANTITIES` and of ``elevation``, where they are known.
        words: Title, the lines under it, and the caption at the foot.
        metadata: Text that goes into the file.

    Raises:
        ImportError: Matplotlib is missing.
    """
    require("matplotlib", NEEDS_MATPLOTLIB)
    from matplotlib.figure import Figure

    rows = _rows(record)
    under = [part for line in words[1] for part in textwrap.wrap(line, LINE_CHARACTERS)]
    head = 0.72 + 0.175 * len(under)  # [in], as the foot: the words there keep theirs
    height = head + 0.75 + 1.5 * len(rows)
    figure = Figure(figsize=(WIDTH_IN, height))
    # Laid out by hand: finding the places by drawing everything first takes twice as long.
    places = {"left": 0.078, "right": 0.984, "bottom": 0.75 / height, "top": 1.0 - head / height, "wspace": 0.15}
    widths = (2.1, 3.2, 2.1) if has_window(record) else (5.3, 2.1)
    axes = figure.subplots(
        len(rows), len(widths), width_ratios=widths, sharex="col", squeeze=False,
        gridspec_kw={**places, "hspace": 0.16},
    )  # fmt: skip
    for row, places_of_row in zip(rows, axes, strict=True):
        _row(row, places_of_row, record, spectra, long_run)
    _headings(axes, record, spectra)
    left = 0.12 / WIDTH_IN
    figure.text(left, 1.0 - 0.1 / height, words[0], fontsize=13, fontweight="bold", color=LINE, va="top")
    figure.text(left, 1.0 - 0.38 / height, "\n".join(under), fontsize=9, color="0.25", va="top", linespacing=1.4)
    figure.text(left, 0.1 / height, words[2], fontsize=7.5, color=QUIET, va="bottom")
    save_png(figure, path, metadata, dpi=DPI, colours=COLOURS)


def has_window(record: Record) -> bool:
    """Whether the record is so long that two minutes of it are drawn on their own."""
    return bool(record.time_s[-1] > LONGER * WINDOW_S)


def has_line(record: Record, spectra: Spectra | None) -> bool:
    """Whether the record's own spectrum is drawn: a short record has one only where there is nothing better."""
    return spectra is None or bool(record.time_s[-1] >= LINE_S)


def _row(
    row: tuple[str, str, FloatArray],
    places: Any,
    record: Record,
    spectra: Spectra | None,
    long_run: Mapping[str, float],
) -> None:
    """One quantity: against time, and its spectrum with the figures."""
    from matplotlib.transforms import blended_transform_factory

    key, label, values = row
    first, spectrum = places[0], places[-1]
    if has_window(record):
        window = window_about_worst(record)
        _whole(first, record.time_s, values, window)
        _part(places[1], record.time_s[window], values[window])
        first.sharey(places[1])
        places[1].tick_params(labelleft=False)
    else:
        _part(first, record.time_s, values)
        _spread(first, values)
    _spectrum(spectrum, key, values, record, spectra)
    rms, mean = float(np.std(values)), float(np.mean(values))
    told = f"mean {mean:.3g}, " if abs(mean) > NOTED * rms else ""
    known = f" (long run {long_run[key]:.3g})" if key in long_run else ""
    place = {"transform": spectrum.transAxes, "ha": "right", "va": "top", "fontsize": 8.5}
    spectrum.text(0.985, 0.95, f"{told}RMS {rms:.3g}{known}", **place)
    first.set_ylabel(label, fontsize=9, linespacing=1.3)
    across = blended_transform_factory(first.figure.transFigure, first.transAxes)
    first.yaxis.set_label_coords(LABELS_IN / WIDTH_IN, 0.5, transform=across)


def _rows(record: Record) -> list[tuple[str, str, FloatArray]]:
    """Key, label and values of each row of the picture."""
    named = {quantity.key: quantity for quantity in QUANTITIES}
    rows = [(key, f"{named[key].label}\n[{named[key].unit}]", record.series[key]) for key in SHOWN]
    if record.elevation_m is not None:
        rows.insert(0, ("elevation", "sea\n[m]", record.elevation_m))
    return rows


def _whole(axes: Axes, time: FloatArray, values: FloatArray, window: slice) -> None:
    """The whole record, each of its stretches as a bar from its least to its greatest value."""
    ends = np.unique(np.linspace(0, len(values), min(STRETCHES, len(values)) + 1).astype(int))
    low, high = np.minimum.reduceat(values, ends[:-1]), np.maximum.reduceat(values, ends[:-1])
    middle = time[(ends[:-1] + ends[1:] - 1) // 2]
    axes.axvspan(time[window][0], time[window][-1], color=MARK, linewidth=0)
    axes.fill_between(middle, low, high, color=FILL, linewidth=0.8)
    _spread(axes, values)
    axes.set_xlim(time[0], time[-1])
    _plain(axes)


def _spread(axes: Axes, values: FloatArray) -> None:
    """The mean more and less the RMS."""
    for sign in (-1.0, 1.0):
        axes.axhline(float(np.mean(values) + sign * np.std(values)), color=LINE, linewidth=0.7, linestyle=(0, (5, 4)))


def _part(axes: Axes, time: FloatArray, values: FloatArray) -> None:
    """The window."""
    axes.axhline(0.0, color="0.8", linewidth=0.7)
    axes.plot(time, values, color=LINE, linewidth=1.2)
    axes.set_xlim(time[0], time[-1])
    axes.margins(y=0.1)
    _plain(axes)


def _spectrum(axes: Axes, key: str, values: FloatArray, record: Record, spectra: Spectra | None) -> None:
    """Spectral density over encounter frequency: long run as an area, this record as a line."""
    if spectra is not None:
        long_run = spectra.wave if key == "elevation" else spectra.deck[key]
        axes.fill_between(spectra.omega, long_run, color=LONG_RUN, alpha=0.45, linewidth=0)
        if key == "elevation":
            axes.plot(spectra.omega, spectra.wave_at_rest, color=LONG_RUN, linewidth=1.2, linestyle=(0, (4, 2)))
    if has_line(record, spectra):
        omega, density = record_spectrum(values, float(record.time_s[1] - record.time_s[0]))
        axes.plot(omega, density, color=LINE, linewidth=1.1)
    axes.set_ylim(0.0, 1.25 * axes.get_ylim()[1])  # room for the words
    axes.locator_params(axis="y", nbins=4)
    _plain(axes)


def _headings(axes: Any, record: Record, spectra: Spectra | None) -> None:
    """What stands above and below the columns, and the range of frequencies."""
    dashed = "(dashed: mean ± RMS)"
    words = [f"whole record {dashed}", "two minutes about the largest lateral force"]
    words = words if has_window(record) else [f"the record {dashed}"]
    for column, heading in zip(axes[0], [*words, "spectral density [unit² s/rad]"], strict=True):
        column.set_title(heading, loc="left", fontsize=9.5)
    frequency = "frequency [rad/s]" if spectra is None else "encounter frequency [rad/s]"
    for column, label in zip(axes[-1], [*("time [s]" for _ in words), frequency], strict=True):
        column.set_xlabel(label, fontsize=9)
    axes[-1, -1].set_xlim(0.0, HIGHEST_RADPS)
    axes[-1, -1].set_xticks(np.linspace(0.0, HIGHEST_RADPS, 5))


def _plain(axes: Axes) -> None:
    """No frame but the two axes, a light grid, small figures."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(labelsize=8, color=QUIET)
    axes.grid(alpha=0.25, linewidth=0.6)
