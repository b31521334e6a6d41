"""Motion sources of a configuration: fixed attitude, one sinusoid, irregular motion, a record.

These are sections of a configuration (frozen, validated, unknown keys refused) and motion sources in one: ``realise``
gives the motion, ``bake`` its table. Degrees here, radians from the realised motion on.
"""

from __future__ import annotations

import math
import warnings
from functools import cached_property
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from ssmash_gym.errors import ConfigurationError, ConfigurationWarning
from ssmash_gym.sections import FilePath
from ssmash_gym.ship.harmonics import Component, Harmonics, irregular_component, spectrum_bins
from ssmash_gym.ship.kinematics import EulerOrder, FloatArray
from ssmash_gym.ship.motion import DEFAULT_SPACING_S, N_CHANNELS, Motion, MotionTable
from ssmash_gym.ship.recorded import DETREND, RecordedMotion
from ssmash_gym.ship.shipmo import Rates, read_shipmo

Dof = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
DOFS: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")  # channels x, y, z, roll, pitch, yaw

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class Section(BaseModel):
    """A section of a configuration that is a motion source."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def realise(self, rng: np.random.Generator | None = None) -> Motion:
        """The motion itself; `rng` is used by sources that draw."""
        raise NotImplementedError

    def bake(
        self,
        duration_s: float,
        spacing_s: float = DEFAULT_SPACING_S,
        *,
        ramp_s: float = 0.0,
        start_s: float = 0.0,
    ) -> MotionTable:
        """Table of the realised motion, see `Motion.bake`; a source that draws is to be realised first."""
        return self.realise().bake(duration_s, spacing_s, ramp_s=ramp_s, start_s=start_s)


class MeanPose(Section):
    """Pose of the deck about which it moves: static heel and trim, heading, position of the origin."""

    roll_deg: Number = Field(0.0, description="mean roll (heel), starboard down positive [deg]")
    pitch_deg: Number = Field(0.0, description="mean pitch (trim), bow up positive [deg]")
    yaw_deg: Number = Field(0.0, description="mean yaw, bow to starboard positive [deg]")
    x_m: Number = Field(0.0, description="mean position of the deck origin, forward [m]")
    y_m: Number = Field(0.0, description="mean position of the deck origin, to starboard [m]")
    z_m: Number = Field(0.0, description="mean position of the deck origin, down [m]")

    def mean(self) -> FloatArray:
        """Mean pose (6,): x, y, z [m], roll, pitch, yaw [rad]."""
        angles = np.radians([self.roll_deg, self.pitch_deg, self.yaw_deg])
        return np.concatenate([[self.x_m, self.y_m, self.z_m], angles])


class Fixed(MeanPose):
    """A deck that stands still in a given pose.

    Angles in degrees in the z-y-x sequence (the sequence of PRESCRIBED.INP line 6 is not stated; yaw-pitch-roll is
    used), position in metres, N axes. Source: Léveillé 2013, appendix A, PRESCRIBED.INP lines 4 (0 = off) and 6.
    """

    type: Literal["fixed"] = "fixed"

    def realise(self, rng: np.random.Generator | None = None) -> Harmonics:
        """The still deck; nothing is drawn."""
        return Harmonics(self.mean())


class Sinusoid(MeanPose):
    """One degree of freedom moves as ``mean + amplitude sin(2 pi t / period + phase)``.

    Amplitude in degrees for roll, pitch and yaw, in metres for surge, sway and heave (heave is positive down);
    period in seconds. Source: Léveillé 2013, appendix A, PRESCRIBED.INP lines 4-6. Without a ramp the motion starts
    at full speed.
    """

    type: Literal["sinusoid"] = "sinusoid"
    dof: Dof = Field(description="the degree of freedom that moves (PRESCRIBED.INP line 4)")
    amplitude_deg: Number | None = Field(None, description="amplitude of roll, pitch or yaw [deg] (line 5)")
    amplitude_m: Number | None = Field(None, description="amplitude of surge, sway or heave [m] (line 5)")
    period_s: Positive = Field(description="period [s] (line 5)")
    phase_deg: Number = Field(0.0, description="phase at t = 0 [deg]")

    @model_validator(mode="after")
    def _one_amplitude(self) -> Sinusoid:
        turns = DOFS.index(self.dof) >= 3
        wanted, other = ("amplitude_deg", "amplitude_m") if turns else ("amplitude_m", "amplitude_deg")
        if getattr(self, wanted) is None or getattr(self, other) is not None:
            raise ValueError(f"dof {self.dof} takes {wanted} and not {other}")
        return self

    def realise(self, rng: np.random.Generator | None = None) -> Harmonics:
        """The sinusoid; nothing is drawn."""
        amplitude = self.amplitude_m if self.amplitude_m is not None else math.radians(self.amplitude_deg or 0.0)
        component = Component(
            channel=DOFS.index(self.dof),
            omega=np.array([2.0 * math.pi / self.period_s]),
            amplitude=np.array([amplitude]),
            phase=np.array([math.radians(self.phase_deg)]),
        )
        return Harmonics(self.mean(), (component,))


class IrregularRotation(BaseModel):
    """Irregular roll, pitch or yaw."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rms_deg: NotNegative = Field(description="long-run root mean square about the mean [deg]")
    period_s: Positive = Field(description="period of the spectrum's peak [s]")


class IrregularTranslation(BaseModel):
    """Irregular surge, sway or heave of the deck origin."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rms_m: NotNegative = Field(description="long-run root mean square about the mean [m]")
    period_s: Positive = Field(description="period of the spectrum's peak [s]")


class Irregular(MeanPose):
    """Independent irregular motion in any of the six degrees of freedom, each by its RMS and peak period.

    Each degree of freedom is a sum of `components` sines of a Bretschneider-shaped spectrum about its peak (0.5 to
    3 times the peak frequency), with exact bin energy: the long-run RMS is the parameter, whatever the seed. RMS in
    degrees or metres, periods in seconds. The degrees of freedom are not coupled as a ship's are in a seaway: this is
    a motion of stated severity (assumed shape), not a prediction. Source of the sampling: stratified frequencies with
    one jittered frequency a bin, random phases.
    """

    type: Literal["irregular"] = "irregular"
    surge: IrregularTranslation | None = Field(None, description="deck origin, forward")
    sway: IrregularTranslation | None = Field(None, description="deck origin, to starboard")
    heave: IrregularTranslation | None = Field(None, description="deck origin, down")
    roll: IrregularRotation | None = Field(None, description="roll about the mean")
    pitch: IrregularRotation | None = Field(None, description="pitch about the mean")
    yaw: IrregularRotation | None = Field(None, description="yaw about the mean")
    components: int = Field(96, ge=8, le=4096, description="sines a degree of freedom; 256 for half-hour records")

    def realise(self, rng: np.random.Generator | None = None) -> Harmonics:
        """Draw the motion.

        The draws are the same for all six degrees of freedom whichever of them move, so two configurations with the
        same generator state and number of components share their random numbers (paired comparisons).

        Args:
            rng: Generator that gives frequencies and phases.

        Raises:
            ConfigurationError: No generator.
        """
        if rng is None:
            raise ConfigurationError("motion irregular: it draws its phases, call realise(rng) with a numpy Generator")
        jitter = rng.random((N_CHANNELS, self.components))
        phase = 2.0 * np.pi * rng.random((N_CHANNELS, self.components))
        bins = spectrum_bins(self.components)
        components = []
        for k, dof in enumerate(DOFS):
            part = getattr(self, dof)
            if part is None:
                continue
            rms = part.rms_m if isinstance(part, IrregularTranslation) else math.radians(part.rms_deg)
            if rms > 0.0:
                components.append(irregular_component(k, rms, part.period_s, bins, jitter[k], phase[k]))
        return Harmonics(self.mean(), tuple(components))


class MotionFile(Section):
    """A recorded deck motion in SHIPMO columns: degrees, m/s, deg/s, m/s2, deg/s2 (see `shipmo`).

    The angles' sequence is not stated in the source; yaw-pitch-roll (z-y-x) unless `euler_order` says otherwise.
    Positions are the integral of the velocities. Source: Léveillé 2013, appendix A, SHIPMO.INP; conventions: errata.
    """

    type: Literal["file"] = "file"
    path: FilePath = Field(description="the record; a relative path is taken from the configuration file's folder")
    rates: Rates = Field("body", description="columns 8-10, 14-16: angular velocity in ship axes, or angle rates")
    euler_order: EulerOrder = Field("zyx", description="sequence of the angles, first rotation first (intrinsic)")
    detrend: bool = Field(
        DETREND, description="remove mean heading, mean velocity and the drift of the integrated positions"
    )

    @cached_property
    def recorded(self) -> RecordedMotion:
        """The motion, read once; warns where the file's rates disagree with the derivatives of its angles."""
        motion = RecordedMotion(read_shipmo(self.path), self.rates, self.euler_order, detrend=self.detrend)
        if not motion.consistent:
            warnings.warn(motion.report(), ConfigurationWarning, stacklevel=2)
        return motion

    def realise(self, rng: np.random.Generator | None = None) -> RecordedMotion:
        """The recorded motion; nothing is drawn.

        Raises:
            ConfigurationError: The file is missing or malformed.
        """
        return self.recorded
