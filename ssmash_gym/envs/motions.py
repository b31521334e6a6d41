"""What a scenario may say of the deck motion: for each type of source, ranges instead of numbers.

A draw gives a section that `ssmash_gym.ship.parse_motion` understands. Another source joins with a further class here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ssmash_gym.envs.ranges import Constant, Extremes, Range, Section, Uniforms, within
from ssmash_gym.envs.seaways import SeawayMotions
from ssmash_gym.ship.harmonics import HIGHEST
from ssmash_gym.ship.kinematics import EulerOrder
from ssmash_gym.ship.recorded import DETREND
from ssmash_gym.ship.shipmo import Rates

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
DOFS: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")
BESIDES: Final = ("start_s", "lateral_g")  # what a draw's motion tells and no motion source reads
_ZERO: Final = Constant(constant=0.0)
_ONE: Final = Constant(constant=1.0)


def plain(drawn: Mapping[str, Any]) -> tuple[Section, dict[str, Any]]:
    """A drawn section as `parse_motion` reads it, and what the draw tells besides.

    Args:
        drawn: `EpisodeDraw.motion`.

    Returns:
        The section; and of ``start_s`` (time of a record at the start [s]) and ``lateral_g`` (the asked long-run RMS of
        the deck's lateral specific force [g]) those that there are.
    """
    besides = {key: value for key, value in drawn.items() if key in BESIDES}
    return {key: value for key, value in drawn.items() if key not in BESIDES}, besides


def _sine(period_s: float) -> Section:
    return {"type": "sinusoid", "dof": "heave", "amplitude_m": 0.0, "period_s": period_s}


class _Base(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    heel_deg: Range = Field(_ZERO, description="mean roll of the deck, starboard down positive [deg]")
    trim_deg: Range = Field(_ZERO, description="mean pitch of the deck, bow up positive [deg]")

    def _mean(self, u: Uniforms) -> Section:
        return {
            "roll_deg": self.heel_deg.draw(u("motion.heel_deg")),
            "pitch_deg": self.trim_deg.draw(u("motion.trim_deg")),
        }


class FixedMotion(_Base):
    """A deck that stands still, heeled and trimmed."""

    type: Literal["fixed"] = "fixed"

    def draw(self, u: Uniforms, seed: int) -> Section:
        """A section for `parse_motion`; the episode's motion seed is not needed."""
        return {"type": "fixed", **self._mean(u)}

    def extremes(self) -> Extremes:
        """Sections that ask most of a table, each with the key that is at fault if it is refused."""
        return []


class SinusoidMotion(_Base):
    """One degree of freedom moves as a sine."""

    type: Literal["sinusoid"] = "sinusoid"
    dof: Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
    amplitude: Range = Field(description="[deg] for roll, pitch and yaw, [m] for surge, sway and heave")
    period_s: Annotated[Range, within(0.5, 1e6)] = Field(description="period [s]")
    phase_deg: Range = Field(_ZERO, description="phase when the table starts [deg]")

    def draw(self, u: Uniforms, seed: int) -> Section:
        """A section for `parse_motion`; the episode's motion seed is not needed."""
        key = "amplitude_deg" if DOFS.index(self.dof) >= 3 else "amplitude_m"
        return {
            "type": "sinusoid",
            "dof": self.dof,
            key: self.amplitude.draw(u("motion.amplitude")),
            "period_s": self.period_s.draw(u("motion.period_s")),
            "phase_deg": self.phase_deg.draw(u("motion.phase_deg")),
            **self._mean(u),
        }

    def extremes(self) -> Extremes:
        """Sections that ask most of a table, each with the key that is at fault if it is refused."""
        return [("motion.period_s", _sine(self.period_s.bounds[0]))]


class Levels(BaseModel):
    """RMS and peak period of one degree of freedom at each severity level, with scatter about them."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rms: tuple[NotNegative, ...] = Field(description="RMS at each level: [deg] for angles, [m] for positions")
    period_s: tuple[Positive, ...] = Field(description="period of the spectrum's peak at each level [s]")
    scatter: Annotated[Range, within(0.0, 10.0)] = Field(_ONE, description="factor on the RMS: headings, speeds, hulls")
    period_scatter: Annotated[Range, within(0.2, 5.0)] = Field(_ONE, description="factor on the period")


class IrregularMotion(_Base):
    """Irregular motion whose severity is drawn once and sets all degrees of freedom together."""

    type: Literal["irregular"] = "irregular"
    severity: Range = Field(description="on the scale of `levels`, which is interpolated")
    levels: tuple[Number, ...] = Field(min_length=1, description="severities for which the tables below hold")
    surge: Levels | None = None
    sway: Levels | None = None
    heave: Levels | None = None
    roll: Levels | None = None
    pitch: Levels | None = None
    yaw: Levels | None = None
    components: Annotated[int, Field(ge=8, le=4096)] = Field(96, description="sines a degree of freedom")

    @model_validator(mode="after")
    def _of_one_length(self) -> Self:
        if any(b <= a for a, b in zip(self.levels, self.levels[1:], strict=False)):
            raise ValueError(f"levels: {list(self.levels)}: must rise")
        for dof in DOFS:
            part = getattr(self, dof)
            for key in ("rms", "period_s"):
                if part is not None and len(getattr(part, key)) != len(self.levels):
                    raise ValueError(f"{dof}.{key}: must have one number for each of the {len(self.levels)} levels")
        low, high = self.severity.bounds
        if low < self.levels[0] or high > self.levels[-1]:
            raise ValueError(
                f"severity from {low:g} to {high:g}: must lie within the levels {self.levels[0]:g} to "
                f"{self.levels[-1]:g}"
            )
        return self

    def draw(self, u: Uniforms, seed: int) -> Section:
        """A section for `parse_motion`; the episode's motion seed is not needed."""
        severity = self.severity.draw(u("motion.severity"))
        section: Section = {"type": "irregular", "components": self.components, **self._mean(u)}
        for dof in DOFS:
            part = getattr(self, dof)
            if part is not None:
                rms = float(np.interp(severity, self.levels, part.rms)) * part.scatter.draw(u(f"motion.{dof}"))
                period = float(np.interp(severity, self.levels, part.period_s))
                key = "rms_deg" if DOFS.index(dof) >= 3 else "rms_m"
                period *= part.period_scatter.draw(u(f"motion.{dof}.period_s"))
                section[dof] = {key: rms, "period_s": period}
        return section

    def extremes(self) -> Extremes:
        """Sections that ask most of a table, each with the key that is at fault if it is refused.

        They are the fastest sines that each spectrum may hold, whatever is drawn.
        """
        low, high = self.severity.bounds
        knots = [low, *(level for level in self.levels if low < level < high), high]
        found: Extremes = []
        for dof in DOFS:
            part = getattr(self, dof)
            if part is not None and any(part.rms):
                period = float(np.min(np.interp(knots, self.levels, part.period_s))) * part.period_scatter.bounds[0]
                found.append((f"motion.{dof}.period_s", _sine(period / HIGHEST)))
        return found


class RecordedMotions(BaseModel):
    """One of several recorded motions, from a random instant on."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    type: Literal["file"] = "file"
    paths: tuple[str, ...] = Field(min_length=1, description="records in SHIPMO columns, each as likely")
    start_s: Annotated[Range, within(0.0, 1e6)] = Field(_ZERO, description="time of the record at the start [s]")
    rates: Rates = "body"
    euler_order: EulerOrder = "zyx"
    detrend: bool = DETREND

    def draw(self, u: Uniforms, seed: int) -> Section:
        """A section for `parse_motion`, with the start in ``start_s``; the episode's motion seed is not needed."""
        return {
            "type": "file",
            "path": self.paths[int(u("motion.path") * len(self.paths))],
            "rates": self.rates,
            "euler_order": self.euler_order,
            "detrend": self.detrend,
            "start_s": self.start_s.draw(u("motion.start_s")),
        }

    def extremes(self) -> Extremes:
        """Sections that ask most of a table, each with the key that is at fault if it is refused."""
        places = {"motion.start_s": 0.0}
        found: Extremes = []
        for k in range(len(self.paths)):
            places["motion.path"] = (k + 0.5) / len(self.paths)
            section = self.draw(places.__getitem__, 0)
            found.append(("motion.paths", {**section, "start_s": 0.0}))
            found.append(("motion.start_s", {**section, "start_s": self.start_s.bounds[1]}))
        return found


MotionRanges = Annotated[
    FixedMotion | SinusoidMotion | IrregularMotion | RecordedMotions | SeawayMotions, Field(discriminator="type")
]
PLACES: Final = (
    "motion.heel_deg",
    "motion.trim_deg",
    "motion.severity",
    "motion.amplitude",
    "motion.period_s",
    "motion.phase_deg",
    "motion.path",
    "motion.start_s",
    *(f"motion.{dof}" for dof in DOFS),
    *(f"motion.{dof}.period_s" for dof in DOFS),
)
# A new quantity takes a new place at the end, so that the old ones keep their random numbers.
LATER: Final = (
    "motion.hs_m",
    "motion.tp",
    "motion.lateral_g",
    "motion.spectrum",
    "motion.spreading",
    "motion.heading_deg",
    "motion.speed_kn",
    "motion.roll_damping_factor",
    "motion.gm_factor",
    "motion.deck_shift_x_m",
    "motion.deck_shift_y_m",
    "motion.deck_shift_z_m",
)
