"""The task: what is to be done, within which limits, and what it is worth. Its numbers stand in the YAML.

No operational source is public for most of them: each is assumed, with its ground in the field's description.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from ssmash_gym.envs.loading import load
from ssmash_gym.errors import shown
from ssmash_gym.simulation.claw import ClawLimits
from ssmash_gym.simulation.parameters import Modes

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
OBSERVATIONS: Final = ("sensors", "full", "forecast", "oracle")  # the named sets


class Section(BaseModel):
    """Part of a task: frozen, and no key but its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Track(Section):
    """The way of the claw."""

    start_x_m: Number = Field(description="claw position at the start, ship axes [m]; assumed: the deck origin")
    goal_x_m: Number = Field(description="claw position to reach, towards the hangar [m]; assumed: 8 m of track")

    @model_validator(mode="after")
    def _forward(self) -> Self:
        if self.goal_x_m <= self.start_x_m:
            raise ValueError(f"goal_x_m = {self.goal_x_m}: must be ahead of start_x_m = {self.start_x_m}")
        return self


class LeadIn(Section):
    """What happens before the task's time starts: the claw is held while the sea comes up."""

    duration_s: NotNegative = Field(description="time with the claw held [s]; assumed: the transients have died out")
    ramp_s: NotNegative = Field(description="time over which the deck motion is brought up [s]; assumed")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.ramp_s > self.duration_s:
            raise ValueError(f"ramp_s = {self.ramp_s}: must not exceed duration_s = {self.duration_s}")
        return self


class Goal(Section):
    """Where the probe must be, and how straight the helicopter must stand."""

    x_tolerance_m: Positive = Field(description="along the track [m]; assumed")
    y_tolerance_m: Positive = Field(description="from the centre line [m]; assumed: without it a one-line law wins")
    yaw_tolerance_deg: Positive = Field(description="heading relative to the track [deg]; assumed, as above")
    hold_s: NotNegative = Field(description="how long all three must hold [s]; assumed")


class Limits(Section):
    """What must not be exceeded. The first four are costs, the fifth ends the episode."""

    probe_in_plane_kN: Positive = Field(
        description="in-plane probe load [kN]; assumed: standing still in sea state 5 just exceeds it (95th percentile)"
    )
    main_vertical_kN: Positive = Field(description="vertical load of a main station [kN]; assumed: above sea state 6")
    lift_off_kN: NotNegative = Field(description="vertical load below which a station counts as lifted [kN]; assumed")
    roll_deg: Positive = Field(description="roll relative to the deck that counts as overturning [deg]; assumed")
    probe_ultimate_kN: Positive = Field(
        description="in-plane probe load that ends the episode, at most the probe's ultimate_load_N [kN]; assumed: "
        "above the worst trapezoid in sea state 6"
    )


class Corridor(Section):
    """How far from the centre line a wheel may be."""

    half_width_m: Positive = Field(description="on the open deck [m]; assumed")
    door_half_width_m: Positive = Field(description="in the hangar door [m]; assumed")
    door_claw_x_m: Number = Field(description="claw position from which the door counts [m]; assumed")


class Reward(Section):
    """Weights of the reward's terms; chosen so that a good return is about 15 and a bad one about -30."""

    progress_per_m: NotNegative = Field(description="for each metre towards the goal [1/m]; assumed")
    alignment: NotNegative = Field(description="potential of being straight and centred near the goal [1]; assumed")
    alignment_yaw_deg: Positive = Field(description="yaw that costs that potential once [deg]; assumed")
    alignment_lateral_m: Positive = Field(description="lateral offset that costs it once [m]; assumed")
    alignment_range_m: Positive = Field(description="distance before the goal from which it counts [m]; assumed")
    load_per_s: NotNegative = Field(description="for an in-plane probe load of twice the soft limit [1/s]; assumed")
    soft_limit_kN: Positive = Field(
        description="in-plane probe load above which the reward falls, with the square of the excess [kN]; assumed"
    )
    load_linear_from: Positive = Field(description="excess, in soft limits, from which it falls linearly [1]; assumed")
    peak: NotNegative = Field(
        description="for each soft limit by which the episode's largest probe load rises above the first one [1]; "
        "assumed"
    )
    command_change: NotNegative = Field(
        description="for the squared change of the applied command; assumed: hunting at 10 Hz is a limit cycle"
    )
    time_per_s: NotNegative = Field(description="for each second after `time_free_s` [1/s]; assumed")
    time_free_s: NotNegative = Field(0.0, description="time that costs nothing [s]; assumed: haste is load")
    success: NotNegative = Field(description="for the goal, held [1]; assumed")
    failure: NotNegative = Field(description="lost with any other termination [1]; assumed")


class History(Section):
    """Past readings that stand in the observation behind the present ones."""

    terms: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="terms of the observation")
    samples: Annotated[int, Field(ge=1, le=100)] = Field(description="readings of each before the present one")
    every_s: Positive = Field(description="time between two of them [s]: whole control intervals")


class Residual(Section):
    """The action is a correction: command = the baseline's + bound * action, clipped to +-1."""

    baseline: str = Field(description="name of a baseline, which acts on the same observation")
    along: Annotated[float, Field(ge=0.0, le=2.0)] = Field(description="bound of the correction along the track [1]")
    across: Annotated[float, Field(ge=0.0, le=2.0)] = Field(description="bound of the correction across [1]")


class Models(Section):
    """Which laws are used where the thesis and its corrections differ (errata)."""

    contact: Literal["contact", "centre"] = Field(description="where a tire's travel over the deck is taken")
    friction: Literal["limit_surface", "friction_circle", "independent"] = Field(description="tire friction limit")
    probe_law: Literal["potential", "ellipse", "printed"] = Field(description="in-plane law of the probe")

    def modes(self) -> Modes:
        """The same for a `simulation.Batch`."""
        return Modes(contact=self.contact, friction=self.friction, probe_law=self.probe_law)


OBSERVED: Final = ("observation", "observation_clip")  # keys of a task that say what is observed
OF_AN_AGENT: Final = ("history", "residual")  # and what goes with an agent wherever it acts
PERCEIVED: Final = (*OBSERVED, *OF_AN_AGENT)


class TaskConfig(Section):
    """The task `ssmash/Traverse-v0`; `load_task` makes it from ``configs/tasks/*.yaml``."""

    description: str = Field("", description="what the task is, in a sentence")
    control_interval_s: Positive = Field(description="time between two commands [s]; assumed")
    substep_s: Positive = Field(description="step of the integrator [s]; peaks within 0.5 % of the reference at 2 ms")
    horizon_s: Positive = Field(description="time limit [s]; assumed: at 0.2 m/s the way takes 43 s")
    grace_s: NotNegative = Field(description="probe loads count from here on [s]; assumed: a peak at 0 hides the rest")
    track: Track
    lead_in: LeadIn
    goal: Goal
    claw: ClawLimits
    wheels: Literal["rolling", "braked", "locked"] = Field(
        description="rolling: mains roll, auxiliary castors; braked: the mains do not roll; locked: no castoring"
    )
    limits: Limits
    corridor: Corridor
    reward: Reward
    observation: Literal["sensors", "full", "forecast", "oracle"] | tuple[str, ...] = Field(
        description="a set, or terms"
    )
    observation_clip: Positive = Field(description="bound of every scaled observation [1]")
    history: History | None = Field(None, description="past readings behind the observation; none by default")
    residual: Residual | None = Field(None, description="the action corrects a baseline; none by default")
    models: Models

    @field_validator("observation", mode="before")
    @classmethod
    def _a_set_or_terms(cls, given: Any) -> Any:
        listed = isinstance(given, Sequence) and not isinstance(given, str) and all(isinstance(n, str) for n in given)
        if listed or given in OBSERVATIONS:
            return given
        raise ValueError(f"{shown(given)} is no observation; give {', '.join(OBSERVATIONS)}, or a list of terms' names")

    @model_validator(mode="after")
    def _whole_intervals(self) -> Self:
        for key, value in (
            ("horizon_s", self.horizon_s),
            ("lead_in.duration_s", self.lead_in.duration_s),
            ("goal.hold_s", self.goal.hold_s),
            ("history.every_s", self.history.every_s if self.history else 0.0),
        ):
            ratio = value / self.control_interval_s
            if abs(ratio - round(ratio)) > 1e-6 * max(ratio, 1.0):
                raise ValueError(f"{key} = {value}: must be a whole number of intervals of {self.control_interval_s} s")
        if self.history is not None and self.history.every_s < 0.5 * self.control_interval_s:
            raise ValueError(f"history.every_s = {self.history.every_s}: must be at least {self.control_interval_s} s")
        if self.horizon_s < self.control_interval_s:
            raise ValueError(f"horizon_s = {self.horizon_s}: must be at least {self.control_interval_s} s")
        if not self.claw.x_min_m <= self.track.start_x_m < self.track.goal_x_m <= self.claw.x_max_m:
            raise ValueError(
                f"track from {self.track.start_x_m} to {self.track.goal_x_m} m: must lie within the claw's travel of "
                f"{self.claw.x_min_m} to {self.claw.x_max_m} m"
            )
        return self

    @property
    def horizon_steps(self) -> int:
        """Control intervals until the time limit."""
        return round(self.horizon_s / self.control_interval_s)

    @property
    def lead_in_steps(self) -> int:
        """Control intervals of the lead-in."""
        return round(self.lead_in.duration_s / self.control_interval_s)

    @property
    def grace_steps(self) -> int:
        """Control intervals that start before the grace is over."""
        return math.ceil(self.grace_s / self.control_interval_s - 1e-9)

    @property
    def hold_steps(self) -> int:
        """Control intervals for which the goal must hold."""
        return round(self.goal.hold_s / self.control_interval_s)


def load_task(task: str | Path | Mapping[str, Any] | TaskConfig = "traverse") -> TaskConfig:
    """Load a task: a name in ``configs/tasks``, a YAML file, or a mapping of changes (key ``base``: to which).

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed; one sentence.
    """
    return load(TaskConfig, "tasks", task, "traverse")


def observed_as(task: TaskConfig, other: TaskConfig) -> TaskConfig:
    """The task, observed as the other one is."""
    return task.model_copy(update={key: getattr(other, key) for key in OBSERVED})
