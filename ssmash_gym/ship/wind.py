"""The wind over the deck: the true wind that goes with a sea, its direction, and the companion of a motion record.

Directions are where the wind comes from relative to the bow, clockwise: 0 ahead, 90 from starboard. Velocities are in
the axes of the steadily translating mean frame N: x forward, y starboard, z down. Gusts are in `ssmash_gym.ship.gusts`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.files import write_text
from ssmash_gym.ship.gusts import HEIGHT_M, Gust, GustTable, finite
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.motion import positive
from ssmash_gym.ship.sea import KNOT, comes_from_deg

__all__ = [
    "Gust",
    "GustTable",
    "WindRecord",
    "blows_towards",
    "from_waves",
    "read_wind",
    "true_wind_of_height",
    "wind_over_deck",
    "write_wind",
]

# Significant wave height [m] and sustained wind speed [kn] at 19.5 m that goes with it: means of the sea states in the
# open North Atlantic (Bales 1983, secondary source); the first pair is calm itself.
SEA_WINDS: Final = (
    (0.0, 0.0),
    (0.05, 3.0),
    (0.3, 8.5),
    (0.88, 13.5),
    (1.88, 19.0),
    (3.25, 24.5),
    (5.0, 37.5),
    (7.5, 51.5),
    (11.5, 59.5),
)
SEA_WIND_HEIGHT_M: Final = 19.5  # height for which the speeds above are given
PROFILE: Final = 1.0 / 7.0  # exponent by which that source converts them to another height
COLUMNS: Final = ("time_s", "wind_x_mps", "wind_y_mps", "wind_z_mps")  # of a record
COMMENT: Final = "#"
AXES: Final = (  # heads every record
    "wind over the deck: velocity of the air over the frame that moves with the ship's mean velocity [m/s]",
    "axes: x forward, y to starboard, z down; wind_x below 0 comes from ahead, wind_y below 0 from starboard",
)
STEP_TOLERANCE: Final = 0.05  # share of a record's time step by which a printed time may be off (rounding)


def true_wind_of_height(hs_m: float, height_m: float = HEIGHT_M) -> float:
    """Mean true wind speed that goes with a significant wave height in the open ocean.

    Straight lines between the sea states' mean heights and sustained wind speeds in the open North Atlantic (Bales
    1983, secondary source; given at 19.5 m), brought to `height_m` by the one-seventh power of the height as that
    source does. The sea is fully developed: no swell, no short fetch.

    Args:
        hs_m: Significant wave height [m], 0 to 11.5.
        height_m: Height above the sea [m]; the default of 10 m for a helicopter on deck is assumed.

    Returns:
        Speed [m/s], rising with the wave height from 0 at 0.

    Raises:
        ConfigurationError: A wave height beyond the table, or a height that is not positive.
    """
    heights, knots = (np.array(column) for column in zip(*SEA_WINDS, strict=True))
    hs = finite("true_wind_of_height", "hs_m", hs_m)
    if not 0.0 <= hs <= heights[-1]:
        raise ConfigurationError(f"true_wind_of_height: hs_m is {hs:g}, allowed is 0 to {heights[-1]:g} m")
    profile = math.pow(positive("true_wind_of_height", "height_m", height_m) / SEA_WIND_HEIGHT_M, PROFILE)
    return float(np.interp(hs, heights, knots)) * KNOT * profile


def blows_towards(from_deg: float) -> FloatArray:
    """Unit vector along which a wind blows, N axes, (3,): the direction of its gusts (`Par.GUST`).

    Args:
        from_deg: Where it comes from [deg]: 0 ahead, 90 from starboard.
    """
    angle = math.radians(from_deg)
    return np.array([-math.cos(angle), -math.sin(angle), 0.0])


def wind_over_deck(true_speed_mps: float, from_deg: float, ship_speed_mps: float) -> FloatArray:
    """True wind minus the ship's mean velocity, N axes [m/s], (3,): what a body at rest on the mean deck meets.

    Args:
        true_speed_mps: Mean true wind speed [m/s].
        from_deg: Where the true wind comes from [deg]: 0 ahead, 90 from starboard.
        ship_speed_mps: Mean speed of the ship [m/s].
    """
    ahead = np.array([ship_speed_mps, 0.0, 0.0])
    return np.asarray(true_speed_mps * blows_towards(from_deg) - ahead + 0.0)  # no negative zeros


def from_waves(heading_deg: float, offset_deg: float = 0.0) -> float:
    """Where a wind comes from that blows `offset_deg` off the waves.

    Args:
        heading_deg: Direction the waves travel to [deg]: 0 following, 90 towards starboard.
        offset_deg: Where the wind comes from, clockwise from where the waves come from [deg].

    Returns:
        Direction of origin [deg] in [0, 360): 0 ahead, 90 from starboard.
    """
    return float((comes_from_deg(heading_deg) + offset_deg) % 360.0)


# --- records --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class WindRecord:
    """A wind over the deck in time; row k stands at ``t = start_s + k * step_s``.

    Attributes:
        name: The file, for messages.
        start_s: Time of the first row [s].
        step_s: Time step [s].
        wind: Wind relative to the ship's mean velocity, N axes [m/s], (n, 3).
    """

    name: str
    start_s: float
    step_s: float
    wind: FloatArray


def write_wind(
    path: str | Path,
    wind: npt.ArrayLike,
    gusts: GustTable | Gust | None,
    from_deg: float,
    dt: float,
    duration: float,
    *,
    comments: Sequence[str] = (),
) -> Path:
    """Write a record of the wind over the deck; the file is there whole, or not at all.

    Comment lines head it, with axes and signs; then a line of column names and the rows, separated by commas.

    Args:
        path: The file; an existing one is replaced.
        wind: Mean wind relative to the ship's mean velocity, N axes [m/s], (3,): `wind_over_deck`.
        gusts: Speed of the gusts along the true wind; None for a steady wind.
        from_deg: Where the true wind comes from [deg]: 0 ahead, 90 from starboard.
        dt: Time step of the rows [s].
        duration: Length of the record [s]; rows run from 0 to the last multiple of `dt` within it.
        comments: Lines that stand before those on axes and signs, each behind a ``#``.

    Returns:
        The path.

    Raises:
        ConfigurationError: A wind that is not three finite numbers, a step or duration that is not positive, a gust
            table that is shorter, or a folder that cannot be written to.
    """
    mean = np.asarray(wind, dtype=np.float64)
    if mean.shape != (3,) or not np.isfinite(mean).all():
        raise ConfigurationError(f"write_wind: wind is {wind!r}, allowed are three finite numbers [m/s]")
    step = positive("write_wind", "dt", dt)
    count = math.floor(positive("write_wind", "duration", duration) / step + 1e-9) + 1
    time = step * np.arange(count)
    speed = np.zeros(count) if gusts is None else gusts.at(time)[:, 0]
    rows = mean + speed[:, np.newaxis] * blows_towards(from_deg)
    lines = [*(f"{COMMENT} {line}" for line in (*comments, *AXES)), ",".join(COLUMNS)]
    lines += [",".join([f"{t:.10g}", *(f"{v:.12g}" for v in row)]) for t, row in zip(time, rows, strict=True)]
    try:
        write_text(path, "\n".join(lines) + "\n")
    except OSError as error:
        raise ConfigurationError(f"wind file {path}: cannot be written ({error.strerror or error})") from error
    return Path(path)


def read_wind(path: str | Path) -> WindRecord:
    """Read a record of the wind over the deck, as `write_wind` writes it; lines that begin with ``#`` are passed over.

    Args:
        path: The file.

    Raises:
        ConfigurationError: No such file, other columns, a malformed row or times that are not evenly spaced (named by
            line), or fewer than two rows.
    """
    file = Path(path)
    try:
        lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise ConfigurationError(f"wind file {file}: cannot be read ({error.strerror or error})") from error
    told = [(k, line) for k, line in enumerate(lines, start=1) if line.strip() and not line.startswith(COMMENT)]
    number, names = told[0] if told else (1, "")
    if tuple(name.strip() for name in names.split(",")) != COLUMNS:
        raise ConfigurationError(f"wind file {file}, line {number}: expected the columns {','.join(COLUMNS)}")
    numbered = told[1:]
    if len(numbered) < 2:
        raise ConfigurationError(f"wind file {file}: it holds {len(numbered)} rows of numbers, allowed are 2 or more")
    table = np.array([_row(file, k, line) for k, line in numbered])
    steps = np.diff(table[:, 0])
    typical = float(np.median(steps))
    uneven = ~(np.abs(steps - typical) <= STEP_TOLERANCE * typical)
    if typical <= 0.0 or uneven.any():
        where = int(np.argmax(uneven if typical > 0.0 else steps <= 0.0)) + 1
        raise ConfigurationError(
            f"wind file {file}, line {numbered[where][0]}: time {table[where, 0]:g} s comes {steps[where - 1]:g} s "
            "after the row before, allowed is an even, positive step"
        )
    step = float(table[-1, 0] - table[0, 0]) / len(steps)
    return WindRecord(str(file), float(table[0, 0]), step, table[:, 1:])


def _row(file: Path, number: int, line: str) -> list[float]:
    """The numbers of one line."""
    try:
        row = [float(field) for field in line.split(",")]
    except ValueError:
        row = []
    if len(row) != len(COLUMNS) or not all(math.isfinite(value) for value in row):
        raise ConfigurationError(
            f"wind file {file}, line {number}: expected {len(COLUMNS)} finite numbers separated by commas, "
            f"found {line[:40]!r}"
        )
    return row
