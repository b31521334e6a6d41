"""A ship in a seaway: the section of a configuration, and the drawing of a sea that matters to the ship."""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, ValidationInfo, field_validator, model_validator

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.ship.kinematics import FloatArray
from ssmash_gym.ship.response import Response
from ssmash_gym.ship.sea import (
    GAMMA,
    KNOT,
    SEA_STATES,
    Spectrum,
    SpectrumName,
    Spreading,
    SpreadingName,
    named_spectrum,
    period_of_height,
)
from ssmash_gym.ship.seaway_motion import SeawayMotion
from ssmash_gym.ship.seaway_statistics import NOTHING, deck_transfer, severity_powers
from ssmash_gym.ship.ships import Ship, from_folder, load_ship
from ssmash_gym.ship.sources import Number, Section
from ssmash_gym.ship.waves import SeaGrid, Waves, calibrated, draw_waves, sea_grid

COMPONENTS: Final = 96
FEWEST_COMPONENTS: Final = 24
MOST_COMPONENTS: Final = 4096
REMEMBERED: Final = 256  # ships on a course through a sea whose severity is kept: a sweep draws many seeds of each
SEA_SHARE: Final = 0.2  # of the waves are drawn for the sea itself, the others for the ship's motions

LARGEST_MISS: Final = 0.05  # of a variance, relative, of which the user is not told
GREATEST_SHIFT_M: Final = 500.0

NUMBERS: Final = (
    *("sea_state", "hs_m", "tp_s", "gamma", "heading_deg", "speed_kn", "components", "heel_deg", "trim_deg"),
    *("roll_damping_factor", "gm_factor", "deck_shift_m"),
)

# Below half the roll damping the grid misses the roll resonance of short-crested seas by more than 3 %.
Factor = Annotated[float, Field(ge=0.5, le=2.0, allow_inf_nan=False)]
Turn = Annotated[Number, Field(ge=-720.0, le=720.0)]
Shift = Annotated[Number, Field(ge=-GREATEST_SHIFT_M, le=GREATEST_SHIFT_M)]
Lean = Annotated[float, Field(ge=-30.0, le=30.0, allow_inf_nan=False)]

__all__ = ["Seaway", "SeawayMotion", "draw_seaway"]


def draw_seaway(
    ship: Ship,
    spectrum: Spectrum,
    spreading: Spreading,
    heading: float,
    speed_mps: float,
    rng: np.random.Generator,
    *,
    components: int = COMPONENTS,
    heel: float = 0.0,
    trim: float = 0.0,
    roll_damping_factor: float = 1.0,
    gm_factor: float = 1.0,
    deck_shift: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> SeawayMotion:
    """Draw a sea and the motion of a ship's deck point in it.

    The ship first answers a grid over frequency and direction, damped as it rolls there; that tells its long-run
    severity and where it comes from. The waves are drawn in proportion and their energies corrected, so that elevation,
    roll, pitch, vertical displacement, velocity and acceleration and lateral specific force of the deck point have the
    grid's root mean squares for every seed, to a small remainder (see `waves.calibrated`; docs/theory/seaway.md has its
    size), of which a warning tells where it passes 5 % of a variance.

    Args:
        ship: The ship.
        spectrum: Spectrum of the elevation.
        spreading: Distribution of directions.
        heading: Main direction the waves travel to, relative to the ship's heading [rad].
        speed_mps: Ship's speed [m/s].
        rng: Generator; what is taken from it does not depend on anything but `components` (`draw_waves`).
        components: Number of waves.
        heel: Constant roll angle [rad].
        trim: Constant pitch angle [rad].
        roll_damping_factor: Multiplies the ship's roll damping.
        gm_factor: Multiplies the ship's metacentric height.
        deck_shift: Added to the ship's deck point, S axes [m], (3,).

    Raises:
        ConfigurationError: A heading that is not finite, or what the ship's response refuses.
    """
    shift = tuple(np.asarray(deck_shift, dtype=np.float64).tolist())
    way = _Way(ship, heading, speed_mps, heel, trim, roll_damping_factor, gm_factor, shift)
    waves, response = _drawn(spectrum, spreading, way, components, rng)
    return SeawayMotion(waves, response, way.point, way.mean_angles)


@dataclass(frozen=True)
class _Way:
    """A ship on its way through a sea: what `draw_seaway` is given but for the sea and the generator."""

    ship: Ship
    heading: float
    speed_mps: float
    heel: float
    trim: float
    roll_damping_factor: float
    gm_factor: float
    deck_shift: tuple[float, ...]

    @property
    def point(self) -> FloatArray:
        """The deck point from G, S axes [m], (3,)."""
        return np.asarray(self.ship.deck_point_m + np.array(self.deck_shift), dtype=np.float64)

    @property
    def mean_angles(self) -> FloatArray:
        """Heel and trim [rad], (2,)."""
        return np.array([self.heel, self.trim])

    def respond(self, omega: FloatArray, direction: FloatArray, energy: FloatArray) -> tuple[Response, FloatArray]:
        """Response and `severity_powers` of waves of given frequencies [rad/s], directions [rad], energies [m2]."""
        factors = {"roll_damping_factor": self.roll_damping_factor, "gm_factor": self.gm_factor}
        response = self.ship.response.respond(omega, direction, np.sqrt(2.0 * energy), self.speed_mps, **factors)
        deck = deck_transfer(response.omega_e, response.transfer, self.point, self.mean_angles)
        return response, severity_powers(response.omega_e, deck)


@functools.lru_cache(maxsize=REMEMBERED)
def _severity(
    spectrum: Spectrum, spreading: Spreading, way: _Way
) -> tuple[SeaGrid, npt.NDArray[np.bool_], FloatArray, FloatArray]:
    """The sea's grid, what its severities sum up to, and where its waves are drawn: the same for every seed.

    Returns:
        Grid; which of `severity_powers` there are any of, (m,); their totals; importance of each cell, of the grid's
        shape.
    """
    grid = sea_grid(spectrum, spreading)
    sea = grid.energy.ravel()
    _, powers = way.respond(grid.omega.ravel(), way.heading + grid.angle.ravel(), sea)
    contributions = sea[:, np.newaxis] * powers
    totals = np.sum(contributions, axis=0)
    used = totals > NOTHING * totals[0]  # a ship in long-crested head seas does not roll
    importance = _importance(contributions[:, used], totals[used], sea * grid.omega.ravel() ** 2)
    return grid, used, totals[used], importance.reshape(grid.energy.shape)


def _drawn(
    spectrum: Spectrum, spreading: Spreading, way: _Way, components: int, rng: np.random.Generator
) -> tuple[Waves, Response]:
    """Waves of a sea, and the response to them.

    Args:
        spectrum: Spectrum of the elevation.
        spreading: Distribution of directions.
        way: The ship in it.
        components: Number of waves.
        rng: Generator.
    """
    grid, used, totals, importance = _severity(spectrum, spreading, way)
    waves = draw_waves(grid, importance, way.heading, components, rng)
    drawn = 0.5 * waves.amplitude**2
    response, powers = way.respond(waves.omega, waves.heading, drawn)
    if used.any():
        drawn, missed = calibrated(drawn, powers[:, used], totals)
        if missed > LARGEST_MISS:
            warnings.warn(
                f"seaway: {components} waves cannot have the sea's severity, a variance is missed by {missed:.0%}: "
                "take more components",
                ConfigurationWarning,
                stacklevel=3,
            )
        waves = Waves(waves.omega, waves.heading, np.sqrt(2.0 * drawn), waves.phase)
    return waves, response


def _importance(contributions: FloatArray, totals: FloatArray, rates: FloatArray) -> FloatArray:
    """Where the waves are drawn: the mean of the severities' shares, and a fifth for the sea itself.

    Args:
        contributions: Each cell's part of the elevation's variance (first) and of the motions' severities, (n, m).
        totals: Their sums (m,); none at all (m = 0) for a flat sea, which has no place of importance.
        rates: Contribution of each cell to the variance of the elevation's rate, (n,).
    """
    if not len(totals):
        return np.ones(len(contributions))
    shares = contributions / totals
    sea = 0.5 * (shares[:, 0] + rates / np.sum(rates))
    motions = np.mean(shares[:, 1:], axis=1) if len(totals) > 1 else sea
    return SEA_SHARE * sea + (1.0 - SEA_SHARE) * motions


class Seaway(Section):
    """A ship in a sea of given severity, at a given heading and speed.

    The sea is a spectrum (by sea state, or by height and period) spread over directions and drawn as `components` long
    waves; the ship answers linearly at the encounter frequencies. The deck is the ship's deck point. Heights in metres,
    periods in seconds, angles in degrees, speed in knots. Headings say where the waves travel to: 0 following, 90
    towards starboard, 180 head. Sources: STANAG 4194 Annex D (sea states; secondary source), Hasselmann et al. 1973
    (JONSWAP), the ship's own description for its response.
    """

    type: Literal["seaway"] = "seaway"
    ship: str | dict[str, Any] = Field("frigate", description="a ship by name, its file, or its description")
    sea_state: int | None = Field(None, description="2 to 6: the STANAG 4194 pair of height and period")
    hs_m: Number | None = Field(None, description="significant wave height [m], in place of a sea state")
    tp_s: Number | None = Field(None, description="peak period [s]; without it, that of the height (0.3 to 5 m)")
    spectrum: SpectrumName = Field("bretschneider", description="bretschneider, or jonswap for a growing sea")
    gamma: Number | None = Field(None, description="peakedness of jonswap, 1 to 7; 3.3 unless given")
    spreading: SpreadingName = Field("cos2", description="cos2 over 90 degrees to either side, or long_crested")
    heading_deg: Turn = Field(description="where the waves travel to: 0 following, 90 to starboard, 180 head [deg]")
    speed_kn: float = Field(ge=0.0, le=25.0, allow_inf_nan=False, description="ship's speed [kn]")
    components: int = Field(
        COMPONENTS, ge=FEWEST_COMPONENTS, le=MOST_COMPONENTS, description="waves; 256 for half-hour records"
    )
    heel_deg: Lean = Field(0.0, description="constant roll, starboard down positive [deg]")
    trim_deg: Lean = Field(0.0, description="constant pitch, bow up positive [deg]")
    roll_damping_factor: Factor = Field(1.0, description="multiplies the ship's roll damping")
    gm_factor: Factor = Field(1.0, description="multiplies the ship's metacentric height")
    deck_shift_m: tuple[Shift, ...] = Field(
        (0.0, 0.0, 0.0),
        min_length=3,
        max_length=3,
        description="moves the deck point: forward, to starboard, down [m]",
    )

    @field_validator(*NUMBERS, mode="before")
    @classmethod
    def _no_truth_value(cls, value: Any) -> Any:
        if any(isinstance(part, bool) for part in (value if isinstance(value, list | tuple) else (value,))):
            raise ConfigurationError(f"{value!r} is refused, allowed are numbers")
        return value

    @field_validator("ship", mode="before")
    @classmethod
    def _known_ship(cls, ship: Any, info: ValidationInfo) -> Any:
        if not isinstance(ship, str | Mapping):
            raise ConfigurationError(f"{ship!r} is not a ship, allowed is a name, a file or a description")
        folder = (info.context or {}).get("folder")
        if folder is not None and isinstance(ship, str) and Path(ship).suffix in (".yaml", ".yml"):
            ship = str(Path(folder) / ship)  # an absolute path stays as it is
        elif folder is not None and isinstance(ship, Mapping):
            ship = from_folder(ship, folder)
        load_ship(ship)  # refuses what it does not know, before anything is drawn
        return ship

    @model_validator(mode="after")
    def _one_sea(self) -> Seaway:
        if (self.sea_state is None) == (self.hs_m is None):
            raise ConfigurationError("a sea is given by sea_state or by hs_m, one of the two")
        if self.sea_state is not None and self.sea_state not in SEA_STATES:
            raise ConfigurationError(
                f"sea_state is {self.sea_state}, allowed are {', '.join(map(str, SEA_STATES))} "
                "(other seas by hs_m and tp_s)"
            )
        if self.sea_state is not None and self.tp_s is not None:
            raise ConfigurationError(
                f"tp_s is {self.tp_s:g}: sea_state {self.sea_state} has its own, allowed with hs_m"
            )
        if self.gamma is not None and self.spectrum != "jonswap":
            raise ConfigurationError(f"gamma is {self.gamma:g}: only spectrum jonswap has a peakedness")
        self.sea()
        return self

    def sea(self) -> Spectrum:
        """The spectrum of the section's sea.

        Raises:
            ConfigurationError: Too steep a sea, or a number out of range.
        """
        if self.sea_state is not None:
            height, period = SEA_STATES[self.sea_state]
        else:
            height = float(self.hs_m or 0.0)
            period = self.tp_s if self.tp_s is not None else period_of_height(height)
        return named_spectrum(self.spectrum, height, period, GAMMA if self.gamma is None else self.gamma)

    def realise(self, rng: np.random.Generator | None = None) -> SeawayMotion:
        """Draw the sea.

        Two sections with the same number of components and generators in the same state share their random numbers
        whatever the sea, heading, speed and ship (paired comparisons).

        Args:
            rng: Generator that gives frequencies, directions and phases.

        Raises:
            ConfigurationError: No generator.
        """
        if rng is None:
            raise ConfigurationError("motion seaway: it draws its waves, call realise(rng) with a numpy Generator")
        return draw_seaway(
            load_ship(self.ship),
            self.sea(),
            Spreading(self.spreading),
            math.radians(self.heading_deg),
            self.speed_kn * KNOT,
            rng,
            components=self.components,
            heel=math.radians(self.heel_deg),
            trim=math.radians(self.trim_deg),
            roll_damping_factor=self.roll_damping_factor,
            gm_factor=self.gm_factor,
            deck_shift=self.deck_shift_m,
        )
