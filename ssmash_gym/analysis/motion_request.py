"""What a record of deck motion is asked to be: files, step, length and wind, refused before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np

from ssmash_gym.errors import ConfigurationError
from ssmash_gym.ship.harmonics import Harmonics
from ssmash_gym.ship.motion import Motion
from ssmash_gym.ship.recorded import RecordedMotion
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.seaway import Seaway, SeawayMotion
from ssmash_gym.ship.shipmo import FEWEST_ROWS
from ssmash_gym.ship.ships import load_ship
from ssmash_gym.ship.sources import Irregular, MotionFile
from ssmash_gym.ship.wind import Gust, from_waves, true_wind_of_height, wind_over_deck

DEFAULT_DURATION_S: Final = 600.0
DEFAULT_STEP_S: Final = 0.05
DEFAULT_GUSTS: Final = 0.1
COMPONENTS: Final = (96, 256)  # for records up to that length, and for longer ones, where 96 begin to repeat themselves
MOST_ROWS: Final = 1_000_000
ROWS_PER_PERIOD: Final = 5.0  # of the shortest period that matters (assumed): a spline through the rows follows it
STILL: Final = 1e-6  # rad/s2, m/s2: a channel that is accelerated less does not move
YAML: Final = (".yaml", ".yml")


@dataclass(frozen=True)
class Files:
    """What is to be written: the record, and what is asked for beside it."""

    out: Path
    wind: Path | None
    plot: Path | None
    spectra: Path | None

    @property
    def named(self) -> dict[str, Path]:
        """The files by the option that asks for them."""
        return {f"--{field.name}": path for field in fields(self) if (path := getattr(self, field.name)) is not None}


def check_files(files: Files, source: Any, config: Path | None) -> None:
    """Refuse files that cannot be written, or from which the motion is read.

    Args:
        files: The files.
        source: The motion source.
        config: The file that it was described in.

    Raises:
        ConfigurationError: A folder that does not exist, a picture that is no PNG, one file twice, a file that is
            read, or something that only a seaway has.
    """
    read = {path.resolve() for path in read_files(source, config)}
    seen: dict[Path, str] = {}
    for option, path in files.named.items():
        if not path.parent.is_dir():
            raise ConfigurationError(f"{option} {path} is refused: there is no folder {path.parent}.")
        if path.is_dir():
            raise ConfigurationError(f"{option} {path} is refused: this is a folder, expected a file.")
        if path.resolve() in read:
            raise ConfigurationError(f"{option} {path} is refused: the motion is read from this file.")
        if path.suffix.lower() in YAML:
            raise ConfigurationError(
                f"{option} {path} is refused: YAML describes motions and ships, what is written not."
            )
        if option == "--plot" and path.suffix.lower() != ".png":
            raise ConfigurationError(f"{option} {path} is refused: the picture is a PNG, its name ends in .png.")
        if option in ("--wind", "--spectra") and not isinstance(source, Seaway):
            raise ConfigurationError(f"{option} is refused: only a motion of type seaway has a sea.")
        if path.resolve() in seen:
            raise ConfigurationError(f"{option} {path} is refused: {seen[path.resolve()]} writes the same file.")
        seen[path.resolve()] = option


def read_files(source: Any, config: Path | None) -> Iterator[Path]:
    """The files that a motion is read from: its configuration, its record, its ship's file, table and hull."""
    if config is not None:
        yield config
    if isinstance(source, MotionFile):
        yield source.path
    if not isinstance(source, Seaway):
        return
    if isinstance(source.ship, str) and Path(source.ship).suffix.lower() in YAML:
        yield Path(source.ship)
    ship = load_ship(source.ship).description
    if ship.response is not None:
        yield ship.response.table
    if ship.hull is not None and ship.hull.database.endswith(".npz"):
        yield Path(ship.hull.database)


def checked_step(motion: Motion, step_s: float | None) -> float:
    """Time between rows [s]: what is given, a record's own, or the default.

    Raises:
        ConfigurationError: A step that is not positive, or too wide for the motion.
    """
    own = motion.step_s if isinstance(motion, RecordedMotion) else DEFAULT_STEP_S
    step = own if step_s is None else step_s
    if not (math.isfinite(step) and step > 0.0):
        raise ConfigurationError(f"--dt {step:g} is refused: it must be above 0 s.")
    widest = shortest_period_s(motion) / ROWS_PER_PERIOD
    if isinstance(motion, RecordedMotion):
        widest = max(widest, own)
    if step > widest * (1.0 + 1e-9):
        raise ConfigurationError(
            f"--dt {step:g} is refused: allowed is at most {widest:.3g} s, {ROWS_PER_PERIOD:g} rows in the motion's "
            "shortest period that matters."
        )
    return step


def shortest_period_s(motion: Motion) -> float:
    """Shortest period that matters in a motion [s]; infinite where nothing is known of it, or nothing moves."""
    if isinstance(motion, SeawayMotion):
        return motion.shortest_period_s
    if isinstance(motion, Harmonics):
        fastest = max((float(np.max(c.omega)) for c in motion.components), default=0.0)
        return 2.0 * math.pi / fastest if fastest > 0.0 else math.inf
    if not isinstance(motion, RecordedMotion):
        return math.inf
    time = np.arange(0.0, motion.duration_s, motion.step_s)
    _, rate, acceleration = motion.signal(time)
    speed, change = np.std(rate, axis=0), np.std(acceleration, axis=0)
    moves = change > STILL
    return 2.0 * math.pi * float(np.min(speed[moves] / change[moves])) if moves.any() else math.inf


def checked_length(motion: Motion, duration_s: float | None, step_s: float) -> float:
    """Length of the record [s].

    Raises:
        ConfigurationError: A length that is refused.
    """
    whole = motion.duration_s
    length = (whole if math.isfinite(whole) else DEFAULT_DURATION_S) if duration_s is None else duration_s
    if not (math.isfinite(length) and length > 0.0):
        raise ConfigurationError(f"--duration {length:g} is refused: it must be above 0 s.")
    if length > whole * (1.0 + 1e-9):
        raise ConfigurationError(f"--duration {length:g} is refused: the record lasts {whole:g} s.")
    rows = math.floor(length / step_s + 1e-9) + 1
    if not FEWEST_ROWS <= rows <= MOST_ROWS:
        raise ConfigurationError(
            f"--duration {length:g} with --dt {step_s:g} is refused: it makes {rows} rows, "
            f"allowed are {FEWEST_ROWS} to {MOST_ROWS}."
        )
    return length


def repetition(source: Any, length_s: float) -> list[str]:
    """A warning where a long record is made of few waves."""
    few = isinstance(source, Seaway | Irregular) and source.components < COMPONENTS[True]
    if not (few and length_s > DEFAULT_DURATION_S):
        return []
    return [
        f"components is {source.components}: a record of {length_s:g} s begins to repeat itself, "
        f"{COMPONENTS[True]} waves or more do not"
    ]


def checked_gusts(wind: bool, gusts: float | None) -> float:
    """RMS of the gusts over the mean true wind.

    Raises:
        ConfigurationError: Gusts without a wind, or a share that is not within 0 to 1.
    """
    if gusts is None:
        return DEFAULT_GUSTS
    if not wind:
        raise ConfigurationError(f"--gusts {gusts:g} is refused: it goes with --wind.")
    if not 0.0 <= gusts <= 1.0:
        raise ConfigurationError(f"--gusts {gusts:g} is refused: allowed are shares of the mean wind, 0 to 1.")
    return gusts


def companion_wind(source: Seaway, intensity: float, seed: int) -> tuple[Any, Gust, float]:
    """The wind of a seaway: mean over the deck (3,) [m/s], gusts, and where the true wind comes from [deg].

    Raises:
        ConfigurationError: Waves higher than the table of winds.
    """
    speed = true_wind_of_height(source.sea().hs_m)
    from_deg = from_waves(source.heading_deg)
    rng = np.random.default_rng([seed, 1])  # a stream of its own: the sea is the same with and without its wind
    return wind_over_deck(speed, from_deg, source.speed_kn * KNOT), Gust.draw(speed, intensity, rng), from_deg


def wind_words(source: Seaway, intensity: float) -> str:
    """The companion wind in one line."""
    speed, from_deg = true_wind_of_height(source.sea().hs_m), from_waves(source.heading_deg)
    return (
        f"wind: true wind {speed:.1f} m/s from {from_deg:g} deg (0 ahead, 90 from starboard), gusts of {intensity:g} "
        f"of it RMS; over the deck: minus the ship's {source.speed_kn:g} kn"
    )
