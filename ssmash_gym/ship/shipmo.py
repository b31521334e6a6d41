"""SHIPMO files: a flight deck's motion in sixteen columns (Léveillé 2013, appendix A, SHIPMO.INP).

Time [s]; roll, pitch, yaw [deg]; velocity x, y, z in the inertial frame [m/s]; roll, pitch, yaw rate [deg/s];
acceleration x, y, z in the inertial frame [m/s2]; roll, pitch, yaw acceleration [deg/s2]. There are no positions.
The last three triples say "rate" and "acceleration" of roll, pitch and yaw without saying of what: `rates: body` (the
default) reads the components of angular velocity and acceleration in ship axes, as (2.20) has them, `rates: euler`
the time derivatives of the angles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from ssmash_gym.columns import number_in, read_text, rows_of
from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import Motion, MotionSource, MotionTable, Signal, pose_of, positive

Rates = Literal["body", "euler"]

COLUMNS: Final = (
    ("time_s", "time [s]"),
    ("roll_deg", "roll [deg]"),
    ("pitch_deg", "pitch [deg]"),
    ("yaw_deg", "yaw [deg]"),
    ("vx_mps", "velocity x [m/s]"),
    ("vy_mps", "velocity y [m/s]"),
    ("vz_mps", "velocity z [m/s]"),
    ("roll_rate_degps", "roll rate [deg/s]"),
    ("pitch_rate_degps", "pitch rate [deg/s]"),
    ("yaw_rate_degps", "yaw rate [deg/s]"),
    ("ax_mps2", "acceleration x [m/s2]"),
    ("ay_mps2", "acceleration y [m/s2]"),
    ("az_mps2", "acceleration z [m/s2]"),
    ("roll_acc_degps2", "roll acceleration [deg/s2]"),
    ("pitch_acc_degps2", "pitch acceleration [deg/s2]"),
    ("yaw_acc_degps2", "yaw acceleration [deg/s2]"),
)
FEWEST_ROWS: Final = 8  # the interpolating spline needs six; two more keep its ends in check
STEP_TOLERANCE: Final = 0.05  # share of the time step by which a printed time may be off (rounding in the file)
BLOCK: Final = 2048  # rows that are worked out at a time: what a half-hour record needs at once stays small


@dataclass(frozen=True, eq=False)
class ShipmoRecord:
    """Columns of a SHIPMO file in SI units, as they stand in it.

    Attributes:
        name: The file, for messages.
        step_s: Time step [s].
        angles: Roll, pitch, yaw [rad], (n, 3).
        velocity: Velocity, N axes [m/s], (n, 3).
        rates: Columns 8-10 [rad/s], (n, 3).
        acceleration: Acceleration, N axes [m/s2], (n, 3).
        rate_derivatives: Columns 14-16 [rad/s2], (n, 3).
    """

    name: str
    step_s: float
    angles: FloatArray
    velocity: FloatArray
    rates: FloatArray
    acceleration: FloatArray
    rate_derivatives: FloatArray


def read_shipmo(path: str | Path) -> ShipmoRecord:
    """Read a record of deck motion.

    Columns are separated by blanks, tabs, commas or semicolons; blank lines, lines that start with ``#``, ``%`` or
    ``!`` and one line of column names before the first row are passed over.

    Args:
        path: The file.

    Raises:
        ConfigurationError: No such file, a malformed row (named by line and column), times that are not evenly
            spaced (named by line), or too few rows.
    """
    file = Path(path)
    try:
        text = read_text(file)
    except OSError as error:
        raise ConfigurationError(f"motion file {file}: cannot be read ({error.strerror or error})") from error
    rows: list[list[float]] = []
    lines: list[int] = []
    names_passed = False
    for number, fields in rows_of(text):
        if not rows and not names_passed and _is_names(fields):
            names_passed = True
            continue
        rows.append(_row(file, number, fields))
        lines.append(number)
    if not rows:
        what = "empty" if not text.strip() else "without a row of numbers"
        raise ConfigurationError(
            f"motion file {file}: it is {what}, allowed are {FEWEST_ROWS} or more rows of {len(COLUMNS)} columns"
        )
    if len(rows) < FEWEST_ROWS:
        raise ConfigurationError(
            f"motion file {file}: it holds {len(rows)} rows of numbers, allowed are {FEWEST_ROWS} or more"
        )
    table = np.array(rows)
    step = _even_step(file, table[:, 0], lines)
    turns = np.radians(table)
    return ShipmoRecord(str(file), step, turns[:, 1:4], table[:, 4:7], turns[:, 7:10], table[:, 10:13], turns[:, 13:16])


def _is_names(fields: list[str]) -> bool:
    """Whether a line holds column names: none of its fields is a number."""
    return all(number_in(field) is None for field in fields)


def _row(file: Path, number: int, fields: list[str]) -> list[float]:
    if len(fields) != len(COLUMNS):
        raise ConfigurationError(
            f"motion file {file}, line {number}: {len(fields)} columns found, allowed are exactly {len(COLUMNS)} "
            f"({COLUMNS[0][1]} to {COLUMNS[-1][1]})"
        )
    row = []
    for column, field in enumerate(fields):
        value = number_in(field)
        if value is None or not math.isfinite(value):
            raise ConfigurationError(
                f"motion file {file}, line {number}, column {column + 1}: expected {COLUMNS[column][1]} as a finite "
                f"number, found {field[:24]!r}"
            )
        row.append(value)
    return row


def _even_step(file: Path, time: FloatArray, lines: list[int]) -> float:
    """The time step, if all steps are the same up to the rounding of printed times."""
    steps = np.diff(time)
    typical = float(np.median(steps))
    if typical <= 0.0:
        where = int(np.argmax(steps <= 0.0)) + 1
        raise ConfigurationError(
            f"motion file {file}, line {lines[where]}: time {time[where]:g} s does not follow {time[where - 1]:g} s, "
            "allowed are evenly rising times"
        )
    uneven = np.abs(steps - typical) > STEP_TOLERANCE * typical
    if uneven.any():
        where = int(np.argmax(uneven)) + 1
        raise ConfigurationError(
            f"motion file {file}, line {lines[where]}: time {time[where]:g} s comes {steps[where - 1]:g} s after the "
            f"row before, allowed is an even step (here {typical:g} s)"
        )
    return float(time[-1] - time[0]) / len(steps)


def write_shipmo(
    path: str | Path,
    motion: MotionTable | MotionSource,
    dt: float,
    duration: float,
    *,
    rates: Rates = "body",
    comments: Sequence[str] = (),
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write a record of deck motion in SHIPMO columns.

    A file whose name ends in ``.csv`` has commas and a line of column names; any other is SHIPMO.INP as the thesis'
    program reads it. The file is written beside its place and then renamed: it is there whole, or not at all.

    Args:
        path: The file; an existing one is replaced.
        motion: A baked table, or a source that needs no drawing or is drawn (realised).
        dt: Time step of the rows [s].
        duration: Length of the record [s]; rows run from 0 to the last multiple of `dt` within it.
        rates: What columns 8-10 and 14-16 hold: angular velocity and its derivative in ship axes, or the derivatives
            of the angles.
        comments: Lines that head the file, each behind a ``#``; the thesis' program does not pass over them.
        progress: Called now and then with the share of the rows that is done, rising to 1; for long records.

    Returns:
        The path.

    Raises:
        ConfigurationError: A step or duration that is not positive, a motion that is shorter, or a folder that
            cannot be written to.
    """
    file = Path(path)
    step = positive("write_shipmo", "dt", dt)
    count = math.floor(positive("write_shipmo", "duration", duration) / step + 1e-9) + 1
    if rates not in ("body", "euler"):
        raise ConfigurationError(f"write_shipmo: rates is {rates!r}, allowed are 'body' and 'euler'")
    if not file.parent.is_dir():  # a folder is not made for a name that may be mistyped
        raise ConfigurationError(f"motion file {file}: cannot be written (there is no folder {file.parent})")
    deck = motion if isinstance(motion, MotionTable) else motion.realise()
    separator = "," if file.suffix.lower() == ".csv" else " "
    lines = [f"# {line}" for line in comments]
    lines += [separator.join(name for name, _ in COLUMNS)] if separator == "," else []
    for first in range(0, count, BLOCK):
        rows = min(BLOCK, count - first)
        time = step * np.arange(first, first + rows, dtype=np.float64)
        columns = _columns(_signal(deck, time, step), rates)
        lines += [
            separator.join([f"{t:.10g}", *(f"{v:.12g}" for v in row)])
            for t, row in zip(time.tolist(), columns.tolist(), strict=True)
        ]
        if progress is not None:
            progress((first + rows) / count)
    try:
        write_text(file, "\n".join(lines) + "\n")
    except OSError as error:
        raise ConfigurationError(f"motion file {file}: cannot be written ({error.strerror or error})") from error
    return file


def _signal(deck: MotionTable | Motion, time: FloatArray, step: float) -> Signal:
    """The motion at evenly spaced times."""
    if isinstance(deck, MotionTable):
        return deck.at(time)
    try:
        return deck.sample(float(time[0]), step, len(time))
    except ConfigurationError:  # a step too wide for a table to be interpolated; a record may have it
        return deck.signal(time)


def _columns(signal: Signal, rates: Rates) -> FloatArray:
    """Columns 2 to 16 (n, 15) of a motion."""
    pose = pose_of(signal)
    w = pose.w_NS_S if rates == "body" else signal.rate[:, 3:]
    wdot = pose.wdot_NS_S if rates == "body" else signal.acceleration[:, 3:]
    angles = signal.position[:, 3:]
    return np.concatenate(
        [np.degrees(angles), pose.v_NS_N, np.degrees(w), pose.a_NS_N, np.degrees(wdot)],
        axis=1,
    )
