"""A record of deck motion as one picture: the whole record, two minutes of it, and the spectra (extra ``plot``)."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ssmash_gym.analysis.motion_record import QUANTITIES, Record, Spectra, record_spectrum
from ssmash_gym.ship.kinematics import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WINDOW_S: Final = 120.0
SHOWN: Final = ("roll_deg", "pitch_deg", "vertical_velocity_m_s", "lateral_specific_force_g")
WORST: Final = "lateral_specific_force_g"  # the window is laid about its largest value
STRETCHES: Final = 300  # of the whole record, each drawn from its least to its greatest value
LINE, FILL, LONG_RUN, MARK = "#12344d", "#9db8cc", "#e08e45", "#f6e7d4"
WIDTH_IN: Final = 12.5
DPI: Final = 100
COLOURS: Final = 128
HIGHEST_RADPS: Final = 2.0  # a ship of a hundred metres does not answer faster waves
QUIET: Final = "0.45"  # grey of what is not data


def require_matplotlib() -> None:
    """Check that pictures can be made.

    Raises:
        ImportError: Matplotlib is missing; the sentence names the extra.
    """
    try:
        __import__("matplotlib")
    except ImportError:
        raise ImportError('--plot needs Matplotlib: pip install "ssmash_gym[plot]".') from None


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
    words: tuple[str, str, str],
    metadata: Mapping[str, str],
) -> None:
    """Draw the picture as PNG.

    Args:
        path: File to write.
        record: The record.
        spectra: Long-run spectra of the seaway; None for a motion that is no seaway.
        long_run: Long-run RMS by the keys of `QUANTITIES` and of ``elevation``, where they are known.
        words: Title, the line or two under it, and the caption at the foot.
        metadata: Text that goes into the file.

    Raises:
        ImportError: Matplotlib is missing.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    rows = _rows(record)
    window = window_about_worst(record)
    height = 1.45 + 1.5 * len(rows)  # [in], of which the words at the head and the foot keep theirs
    figure = Figure(figsize=(WIDTH_IN, height))
    # Laid out by hand: finding the places by drawing everything first takes twice as long.
    places = {"left": 0.066, "right": 0.988, "bottom": 0.72 / height, "top": 1.0 - 0.95 / height, "wspace": 0.14}
    axes = figure.subplots(
        len(rows), 3, width_ratios=(2.1, 3.2, 2.1), sharex="col", squeeze=False, gridspec_kw={**places, "hspace": 0.16}
    )
    for (key, label, values), (whole, part, spectrum) in zip(rows, axes, strict=True):
        _whole(whole, record.time_s, values, window)
        _part(part, record.time_s[window], values[window])
        _spectrum(spectrum, key, values, record, spectra)
        known = f" (long run {long_run[key]:.3g})" if key in long_run else ""
        place = {"transform": spectrum.transAxes, "ha": "right", "va": "top", "fontsize": 8.5}
        spectrum.text(0.985, 0.95, f"RMS {np.std(values):.3g}{known}", **place)
        whole.set_ylabel(label, fontsize=9)
        whole.yaxis.set_label_coords(-0.125, 0.5)
        whole.sharey(part)
        part.tick_params(labelleft=False)
    _headings(axes, record, spectra)
    left = 0.12 / WIDTH_IN
    figure.text(left, 1.0 - 0.1 / height, words[0], fontsize=13, fontweight="bold", color=LINE, va="top")
    figure.text(left, 1.0 - 0.38 / height, words[1], fontsize=9, color="0.25", va="top", linespacing=1.4)
    figure.text(left, 0.1 / height, words[2], fontsize=7.5, color=QUIET, va="bottom")
    _save(figure, path, metadata)


def _save(figure: Figure, path: Path, metadata: Mapping[str, str]) -> None:
    """As PNG with a palette: a third of the size, and no difference to the eye."""
    from PIL import Image, PngImagePlugin

    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI)
    text = PngImagePlugin.PngInfo()
    for key, value in metadata.items():
        text.add_itxt(key, value)
    with Image.open(drawn) as picture:
        picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(
            path, format="PNG", optimize=True, dpi=(DPI, DPI), pnginfo=text
        )


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
    for sign in (-1.0, 1.0):
        axes.axhline(float(np.mean(values) + sign * np.std(values)), color=LINE, linewidth=0.7, linestyle=(0, (5, 4)))
    axes.set_xlim(time[0], time[-1])
    _plain(axes)


def _part(axes: Axes, time: FloatArray, values: FloatArray) -> None:
    """The window."""
    axes.axhline(0.0, color="0.8", linewidth=0.7)
    axes.plot(time, values, color=LINE, linewidth=1.2)
    axes.set_xlim(time[0], time[-1])
    axes.margins(y=0.1)
    _plain(axes)


def _spectrum(axes: Axes, key: str, values: FloatArray, record: Record, spectra: Spectra | None) -> None:
    """Spectral density over encounter frequency: long run as an area, this record as a line."""
    omega, density = record_spectrum(values, float(record.time_s[1] - record.time_s[0]))
    if spectra is not None:
        long_run = spectra.wave if key == "elevation" else spectra.deck[key]
        axes.fill_between(spectra.omega, long_run, color=LONG_RUN, alpha=0.45, linewidth=0)
        if key == "elevation":
            axes.plot(spectra.omega, spectra.wave_at_rest, color=LONG_RUN, linewidth=1.2, linestyle=(0, (4, 2)))
    axes.plot(omega, density, color=LINE, linewidth=1.1)
    axes.set_ylim(0.0, 1.2 * axes.get_ylim()[1])  # room for the words
    axes.locator_params(axis="y", nbins=4)
    _plain(axes)


def _headings(axes: Any, record: Record, spectra: Spectra | None) -> None:
    """What stands above and below the columns, and the range of frequencies."""
    part = "two minutes about the largest lateral force" if record.time_s[-1] > WINDOW_S else "the record"
    words = ("whole record (dashed: ± RMS)", part, "spectral density [unit² s/rad]")
    for column, heading in zip(axes[0], words, strict=True):
        column.set_title(heading, loc="left", fontsize=9.5)
    frequency = "frequency [rad/s]" if spectra is None else "encounter frequency [rad/s]"
    for column, label in zip(axes[-1], ("time [s]", "time [s]", frequency), strict=True):
        column.set_xlabel(label, fontsize=9)
    axes[-1, 2].set_xlim(0.0, HIGHEST_RADPS)


def _plain(axes: Axes) -> None:
    """No frame but the two axes, a light grid, small figures."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(QUIET)
    axes.tick_params(labelsize=8, color=QUIET)
    axes.grid(alpha=0.25, linewidth=0.6)
