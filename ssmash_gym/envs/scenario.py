"""The scenario: what differs from episode to episode. Each quantity is a typed range; a draw is a plain record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from ssmash_gym.envs import motions
from ssmash_gym.envs.loading import load, merged
from ssmash_gym.envs.motions import MotionRanges, RecordedMotions
from ssmash_gym.envs.ranges import Constant, Range, within
from ssmash_gym.envs.seaways import SeawayMotions
from ssmash_gym.envs.winds import WIND, FreeWind, SeaWind, WindRanges, free_by_default
from ssmash_gym.errors import ConfigurationError, refusal, shown
from ssmash_gym.sections import validated
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.seaway import Seaway

_ZERO: Final = Constant(constant=0.0)
_ONE: Final = Constant(constant=1.0)
_SEEDS: Final = 2**53  # exact in JSON whoever reads it


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Start(_Section):
    """Where the helicopter has landed."""

    yaw_deg: Annotated[Range, within(-90.0, 90.0)] = Field(_ZERO, description="heading relative to the track [deg]")
    lateral_m: Range = Field(_ZERO, description="probe and claw from the centre line, starboard positive [m]")
    sink_rate_m_s: Annotated[Range, within(0.0, 10.0)] | None = Field(
        None, description="it is only just being set down, with the probe free: vertical speed at first contact [m/s]"
    )


class Helicopter(_Section):
    """What is not known exactly of the helicopter and its tires."""

    mass_factor: Annotated[Range, within(0.1, 10.0)] = Field(_ONE, description="on body mass and its inertia tensor")
    cg_x_m: Range = Field(_ZERO, description="shift of the body's c.g., forward [m]")
    cg_y_m: Range = Field(_ZERO, description="the same, to starboard [m]")
    cg_z_m: Range = Field(_ZERO, description="the same, down [m]")
    friction_factor: Annotated[Range, within(0.01, 10.0)] = Field(_ONE, description="on all tires' friction: wet deck")
    pressure_factor: Annotated[Range, within(0.1, 10.0)] = Field(_ONE, description="on all tires' gauge pressure")


class Claw(_Section):
    """What is not known exactly of the claw's drive; a key left out takes the task's value."""

    delay_s: Annotated[Range, within(0.0, 2.0)] | None = Field(None, description="command delay [s]")
    ripple_along_m: Annotated[Range, within(0.0, 0.1)] | None = Field(None, description="ripple amplitude, x [m]")
    ripple_across_m: Annotated[Range, within(0.0, 0.1)] | None = Field(None, description="ripple amplitude, y [m]")
    ripple_phase_deg: Range = Field(_ZERO, description="phase of the ripple when the lead-in starts [deg]")
    y_travel_m: Annotated[Range, within(0.001, 10.0)] | None = Field(None, description="lateral travel either way [m]")
    speed_across_m_s: Annotated[Range, within(1e-4, 10.0)] | None = Field(
        None, description="speed across at which the drive saturates [m/s]; commands stay shares of the task's speed"
    )


class Sensors(_Section):
    """Noise and delay of the physical sensors; commands, clocks and goals are known exactly."""

    noise: Annotated[Range, within(0.0, 100.0)] = Field(_ZERO, description="factor on each term's nominal deviation")
    delay_s: Annotated[Range, within(0.0, 2.0)] = Field(
        _ZERO, description="age of a reading [s]; between control instants it is interpolated"
    )


class ScenarioConfig(_Section):
    """A scenario; `load_scenario` makes it from ``configs/scenarios/*.yaml``."""

    description: str = Field("", description="what it stands for, in a sentence")
    motion: MotionRanges = Field(description="deck motion")
    start: Start = Start()
    wind: WindRanges = Field(FreeWind(), description="given by itself, or tied to the sea")
    helicopter: Helicopter = Helicopter()
    claw: Claw = Claw()
    sensors: Sensors = Sensors()

    @field_validator("wind", mode="before")
    @classmethod
    def _free_by_default(cls, given: Any) -> Any:
        return free_by_default(given)

    @model_validator(mode="after")
    def _one_sea(self) -> Self:
        seaway = isinstance(self.motion, SeawayMotions)
        if isinstance(self.wind, SeaWind):
            if not seaway:
                raise ValueError(
                    f"wind.type sea is refused with motion.type {self.motion.type}: only a seaway has a wave height "
                    "and a direction; give the wind by itself ({type: free, ...})"
                )
            return self
        if self.wind.ship_speed_mps is None:
            return self
        speeds = self.wind.ship_speed_mps.bounds
        told = f"wind.ship_speed_mps from {speeds[0]:g} to {speeds[1]:g}"
        if seaway:
            raise ValueError(f"{told} is refused with a seaway: leave it out, the ship's speed is motion.speed_kn")
        if isinstance(self.motion, RecordedMotions) and not self.motion.detrend and any(speeds):
            raise ValueError(_TWICE.format(told))
        return self

    def sample(self, rng: np.random.Generator) -> EpisodeDraw:
        """Draw an episode; takes the same numbers from the generator whatever the ranges are."""
        motion_seed, sensor_seed = (int(s) for s in rng.integers(_SEEDS, size=2))
        numbers = dict(zip(_PLACES, rng.random(_RESERVED).tolist(), strict=False))
        plain: dict[str, Any] = {name.replace(".", "_"): self._value(name, numbers[name]) for name in _DRAWN}
        motion = self.motion.draw(numbers.__getitem__, motion_seed)
        plain |= self.wind.draw(numbers.__getitem__, motion)
        return EpisodeDraw(**plain, motion=motion, motion_seed=motion_seed, sensor_seed=sensor_seed)

    def _value(self, name: str, u: float) -> float | None:
        section, key = name.split(".")
        found = getattr(getattr(self, section), key)
        return None if found is None else float(found.draw(u))

    def bounds(self, name: str) -> tuple[float, float] | None:
        """Least and greatest value of a quantity such as ``sensors.delay_s`` (motion and wind apart).

        None where the task decides.
        """
        section, key = name.split(".")
        found = getattr(getattr(self, section), key)
        return None if found is None else found.bounds


@dataclass(frozen=True)
class EpisodeDraw:
    """Everything that was drawn for one episode, in plain numbers: with it an episode can be started again.

    The fields are the scenario's keys with their section in front. None takes the task's value. `motion` is a section
    for `ssmash_gym.ship.parse_motion`, with the ``start_s`` of a record beside it, and ``lateral_g`` where the wave
    height was solved for that target (`ssmash_gym.envs.motions.plain` takes them apart).
    """

    start_yaw_deg: float
    start_lateral_m: float
    start_sink_rate_m_s: float | None
    wind_speed_mps: float
    wind_from_deg: float
    wind_ship_speed_mps: float
    wind_gust_intensity: float
    helicopter_mass_factor: float
    helicopter_cg_x_m: float
    helicopter_cg_y_m: float
    helicopter_cg_z_m: float
    helicopter_friction_factor: float
    helicopter_pressure_factor: float
    claw_delay_s: float | None
    claw_ripple_along_m: float | None
    claw_ripple_across_m: float | None
    claw_ripple_phase_deg: float
    claw_y_travel_m: float | None
    claw_speed_across_m_s: float | None
    sensors_noise: float
    sensors_delay_s: float
    motion: dict[str, Any]
    motion_seed: int
    sensor_seed: int

    def to_dict(self) -> dict[str, Any]:
        """A copy as a mapping of numbers, texts and mappings, ready for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, record: Mapping[str, Any]) -> EpisodeDraw:
        """The inverse of `to_dict`.

        Raises:
            ConfigurationError: It is no mapping, a key is missing or unknown, or a value is not allowed.
        """
        if not isinstance(record, Mapping):
            raise ConfigurationError(f"draw: {shown(record)} is refused: must be a mapping, as in info['draw'].")
        known = {field.name for field in fields(cls)}
        wrong = sorted(known.symmetric_difference(record))
        if wrong:
            raise ConfigurationError(f"draw: the key {wrong[0]} is {'missing' if wrong[0] in known else 'unknown'}.")
        motion = record["motion"]
        plain: dict[str, Any] = {**record, "motion": dict(motion) if isinstance(motion, Mapping) else motion}
        draw = cls(**plain)
        check_draw(draw)
        return draw


def check_draw(draw: EpisodeDraw) -> None:
    """Refuse a draw that no scenario could have given; what it needs of an environment is `Starter.check`'s.

    Raises:
        ConfigurationError: A value is no finite number, lies beyond what its range may give, or the motion is none.
    """
    sections: dict[str, dict[str, Any]] = {}
    for name in (*_DRAWN, *_WIND):
        section, key = name.split(".")
        field, value = name.replace(".", "_"), getattr(draw, name.replace(".", "_"))
        if value is None and field in _MAY_BE_NONE:
            continue
        if not _finite(value):
            raise refusal("draw", field, value, "must be a finite number")
        sections.setdefault(section, {})[key] = float(value)
    for field in ("motion_seed", "sensor_seed"):
        value = getattr(draw, field)
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
            raise refusal("draw", field, value, "must be a whole number of 0 or more")
    for section, numbers in sections.items():
        validated(_SECTIONS[section], numbers, f"draw: {section}")
    _check_motion(draw)


def _check_motion(draw: EpisodeDraw) -> None:
    """Refuse a motion that is none, or that has a mean speed of its own beside the wind's."""
    if not isinstance(draw.motion, Mapping):
        raise refusal("draw", "motion", draw.motion, "must be a mapping, as in info['draw']")
    motion, besides = motions.plain(draw.motion)
    for key, value in besides.items():
        if not _finite(value):
            raise refusal("draw", f"motion.{key}", value, "must be a finite number")
    source = parse_motion(motion, where="draw: motion")
    speed = draw.wind_ship_speed_mps
    if motion["type"] == "file" and not motion.get("detrend", True) and speed:
        raise ConfigurationError("draw: " + _TWICE.format(f"wind_ship_speed_mps = {speed:g}") + ".")
    if isinstance(source, Seaway) and abs(speed - KNOT * source.speed_kn) > 1e-6:
        own = f"must be the seaway's own, {KNOT * source.speed_kn:.6g} m/s (motion.speed_kn)"
        raise refusal("draw", "wind_ship_speed_mps", speed, own)


def _finite(value: Any) -> bool:
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    return number and bool(np.isfinite(value))


# Places of the random numbers. A new quantity takes a new place at the end, so that the old ones keep theirs.
_PLACES: Final = (
    "start.yaw_deg",
    "start.lateral_m",
    "wind.speed_mps",
    "wind.from_deg",
    "wind.ship_speed_mps",
    "helicopter.mass_factor",
    "helicopter.cg_x_m",
    "helicopter.cg_y_m",
    "helicopter.cg_z_m",
    "helicopter.friction_factor",
    "helicopter.pressure_factor",
    "claw.delay_s",
    "claw.ripple_along_m",
    "claw.ripple_across_m",
    "claw.ripple_phase_deg",
    "sensors.noise",
    "sensors.delay_s",
    *motions.PLACES,
    "wind.gust_intensity",
    "wind.speed_factor",
    "wind.from_waves_deg",
    *motions.LATER,
    "claw.y_travel_m",
    "claw.speed_across_m_s",
    "start.sink_rate_m_s",
)
_DRAWN: Final = tuple(name for name in _PLACES if name.split(".")[0] not in ("motion", "wind"))
_WIND: Final = tuple(field.replace("_", ".", 1) for field in WIND)
_MAY_BE_NONE: Final = (
    "start_sink_rate_m_s",
    "claw_delay_s",
    "claw_ripple_along_m",
    "claw_ripple_across_m",
    "claw_y_travel_m",
    "claw_speed_across_m_s",
)
_SECTIONS: Final[dict[str, type[BaseModel]]] = {
    "start": Start, "wind": FreeWind, "helicopter": Helicopter, "claw": Claw, "sensors": Sensors,
}  # fmt: skip
_TWICE: Final = (
    "{} is refused with a recorded motion and detrend: false: the record keeps its own mean speed, "
    "which would count twice"
)
_RESERVED: Final = 64


def changed_scenario(scenario: ScenarioConfig, changes: Mapping[str, Any] | ScenarioConfig) -> ScenarioConfig:
    """The scenario with changes laid over it, as a mapping changes a file (`loading.merged`).

    Raises:
        ConfigurationError: Unknown key, or a value that is not allowed.
    """
    if isinstance(changes, ScenarioConfig):
        return changes
    return validated(ScenarioConfig, merged(scenario.model_dump(mode="json"), changes), "scenario")


def load_scenario(scenario: str | Path | Mapping[str, Any] | ScenarioConfig = "training") -> ScenarioConfig:
    """Load a scenario: a name in ``configs/scenarios``, a YAML file, or a mapping of changes (key ``base``: to which).

    Raises:
        ConfigurationError: Unknown name or key, or a value that is not allowed; one sentence.
    """
    return load(ScenarioConfig, "scenarios", scenario, "training")
