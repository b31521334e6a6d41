"""A seaway under the deck, as a scenario says it: ranges of the sea, the ship's way through it and the ship itself.

A draw gives a section of type ``seaway`` in plain numbers. Severity is drawn as a significant wave height, or as the
lateral specific force that the deck shall have: then the wave height is solved for.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from ssmash_gym.envs.ranges import Constant, Extremes, Range, Section, Uniforms, within
from ssmash_gym.ship import parse_motion
from ssmash_gym.ship.sea import GAMMA, SEA_STATES, TP_RANGE_S, check_steepness, period_of_height
from ssmash_gym.ship.seaway import COMPONENTS, FEWEST_COMPONENTS, GREATEST_SHIFT_M, MOST_COMPONENTS

NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Shift = Annotated[Range, within(-GREATEST_SHIFT_M, GREATEST_SHIFT_M)]
GREATEST_SPEED_KN: Final = 25.0
HIGHEST_M: Final = 11.5  # significant height up to which a wind belongs to the sea
_PAIRS: Final = (min(SEA_STATES.values())[0], max(SEA_STATES.values())[0])  # heights that have a period
_ZERO: Final = Constant(constant=0.0)
_ONE: Final = Constant(constant=1.0)
_CLOSE: Final = 0.002  # relative: as near as the solved lateral force comes to what was drawn
_STEPS: Final = 12  # secant and bisection steps at most; five are usual


class _Weights(BaseModel):
    """Chances of named kinds, in any unit; a bare name stands for that kind alone."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _a_bare_name(cls, given: Any) -> Any:
        return {given: 1.0} if isinstance(given, str) else given

    @model_validator(mode="after")
    def _some(self) -> Self:
        if sum(self._all.values()) <= 0.0:
            raise ValueError(f"one of {', '.join(self._all)} must have a weight above 0")
        return self

    @property
    def _all(self) -> dict[str, float]:
        return {name: getattr(self, name) for name in type(self).model_fields}

    @property
    def possible(self) -> list[str]:
        """Kinds that may be drawn."""
        return [name for name, weight in self._all.items() if weight > 0.0]

    def draw(self, u: float) -> str:
        """A kind for a uniform number `u` in [0, 1)."""
        place = u * sum(self._all.values())
        for name in self.possible:
            place -= self._all[name]
            if place < 0.0:
                return name
        return self.possible[-1]  # rounding


class SpectrumWeights(_Weights):
    """Chances of the shapes of the wave spectrum."""

    bretschneider: NotNegative = Field(0.0, description="weight of the Bretschneider spectrum")
    jonswap: NotNegative = Field(0.0, description="weight of the JONSWAP spectrum, peaked by `gamma`")


class SpreadingWeights(_Weights):
    """Chances of the waves' directional spreading."""

    cos2: NotNegative = Field(0.0, description="weight of cosine-squared spreading over +-90 deg: a short-crested sea")
    long_crested: NotNegative = Field(0.0, description="weight of waves that all travel one way")


class SeawayMotions(BaseModel):
    """A ship on a course through a random sea; what is drawn is a sea of `ssmash_gym.ship.seaway.Seaway`.

    The height is `hs_m`, or that of a `sea_state`; the period belongs to it (STANAG 4194 pairs) times `tp_factor`, or
    is `tp_s`. With `lateral_g` the height is solved for within the bounds of `hs_m`, so that the drawn sea has that
    long-run RMS of the deck's lateral specific force; where no allowed height has it, the nearer bound is taken. The
    draw holds the target as ``lateral_g``; what the sea came to is the episode's metric ``sea_lateral_g``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    type: Literal["seaway"] = "seaway"
    ship: str | dict[str, Any] = Field(
        "frigate", description="name in configs/ships, the path of a YAML file, or a mapping, perhaps with a `base`"
    )
    sea_state: int | None = Field(None, description="NATO sea state, 2 to 6: its significant height and peak period")
    hs_m: Annotated[Range, within(0.01, HIGHEST_M)] | None = Field(None, description="significant wave height [m]")
    tp_s: Annotated[Range, within(*TP_RANGE_S)] | None = Field(
        None, description="peak period [s], instead of the pairs'"
    )
    tp_factor: Annotated[Range, within(0.5, 2.0)] = Field(_ONE, description="factor on the period of the pairs")
    lateral_g: Annotated[Range, within(0.0, 0.5)] | None = Field(
        None, description="target: long-run RMS of the deck's lateral specific force [g]; `hs_m` is then solved for"
    )
    spectrum: SpectrumWeights = Field(SpectrumWeights(bretschneider=1.0), description="a name, or weights of names")
    gamma: Annotated[float, Field(ge=1.0, le=7.0)] = Field(GAMMA, description="peakedness of JONSWAP")
    spreading: SpreadingWeights = Field(SpreadingWeights(cos2=1.0), description="a name, or weights of names")
    heading_deg: Annotated[Range, within(-720.0, 720.0)] = Field(
        description="waves travel: 0 with the ship, 90 from port to starboard, 180 against [deg]"
    )
    speed_kn: Annotated[Range, within(0.0, GREATEST_SPEED_KN)] = Field(description="speed of the ship [kn]")
    roll_damping_factor: Annotated[Range, within(0.5, 2.0)] = Field(_ONE, description="on the ship's roll damping")
    gm_factor: Annotated[Range, within(0.5, 2.0)] = Field(_ONE, description="on the ship's metacentric height")
    deck_shift_x_m: Shift = Field(_ZERO, description="deck point from where the ship has it, forward [m]")
    deck_shift_y_m: Shift = Field(_ZERO, description="the same, to starboard [m]")
    deck_shift_z_m: Shift = Field(_ZERO, description="the same, down [m]")
    heel_deg: Annotated[Range, within(-30.0, 30.0)] = Field(
        _ZERO, description="mean roll, starboard down positive [deg]"
    )
    trim_deg: Annotated[Range, within(-30.0, 30.0)] = Field(_ZERO, description="mean pitch, bow up positive [deg]")
    components: Annotated[int, Field(ge=FEWEST_COMPONENTS, le=MOST_COMPONENTS)] = Field(
        COMPONENTS, description="waves of the sea; 256 for half an hour"
    )

    @field_validator("ship", mode="before")
    @classmethod
    def _ready_for_json(cls, given: Any) -> Any:
        if not isinstance(given, Mapping):
            if isinstance(given, str):
                return given
            raise ValueError(f"{given!r} is no ship; give a name, the path of a YAML file, or a mapping")
        try:
            return json.loads(json.dumps(dict(given), allow_nan=False))
        except (TypeError, ValueError) as error:
            raise ValueError(f"a mapping must hold plain finite numbers, texts and lists ({error})") from None

    @model_validator(mode="after")
    def _one_way_to_say_it(self) -> Self:
        if (self.hs_m is None) == (self.sea_state is None):
            raise ValueError("give hs_m or sea_state, and not both; sea_state: null or hs_m: null takes a base's away")
        if self.sea_state is not None and self.sea_state not in SEA_STATES:
            allowed = ", ".join(str(state) for state in SEA_STATES)
            raise ValueError(f"sea_state = {self.sea_state}: must be one of {allowed} (no other has a source)")
        if self.tp_s is not None and (self.sea_state is not None or self.tp_factor != _ONE):
            raise ValueError(
                "tp_s stands instead of a sea_state's period and of tp_factor: leave one of them out (sea_state: null "
                "and tp_factor: 1 take a base's away)"
            )
        if self.lateral_g is not None and (self.hs_m is None or self.hs_m.bounds[0] == self.hs_m.bounds[1]):
            instead = "" if self.sea_state is None else f", and sea_state: null instead of {self.sea_state}"
            raise ValueError(f"lateral_g needs a range of hs_m, within which the height is solved for{instead}")
        low, high = self._heights
        if self.tp_s is None and not (_PAIRS[0] <= low and high <= _PAIRS[1]):
            raise ValueError(
                f"hs_m from {low:g} to {high:g}: must lie within {_PAIRS[0]:g} to {_PAIRS[1]:g} m, which have a "
                "period; beyond, give tp_s"
            )
        for hs_m, tp_s in self._steepest():
            check_steepness(hs_m, tp_s)
        return self

    @property
    def _heights(self) -> tuple[float, float]:
        """Least and greatest significant wave height [m]."""
        if self.sea_state is not None:
            return SEA_STATES[self.sea_state][0], SEA_STATES[self.sea_state][0]
        assert self.hs_m is not None
        return self.hs_m.bounds

    def _steepest(self) -> Iterator[tuple[float, float]]:
        """Heights [m] with the shortest period [s] that may be drawn with them; one of them is the steepest sea."""
        low, high = self._heights
        if self.tp_s is not None:
            yield high, self.tp_s.bounds[0]
            return
        for hs_m in {low, high, *(pair[0] for pair in SEA_STATES.values() if low < pair[0] < high)}:
            yield hs_m, period_of_height(hs_m) * self.tp_factor.bounds[0]

    def draw(self, u: Uniforms, seed: int) -> Section:
        """A section for `parse_motion` (`ssmash_gym.envs.motions.plain`: without the target ``lateral_g``, if any).

        Args:
            u: Uniform numbers by name.
            seed: Of the episode's motion; with `lateral_g` the height is solved for in the very sea that it gives.
        """
        shift = (self.deck_shift_x_m, self.deck_shift_y_m, self.deck_shift_z_m)
        section: Section = {
            "type": "seaway",
            "ship": self.ship,
            "spectrum": self.spectrum.draw(u("motion.spectrum")),
            "spreading": self.spreading.draw(u("motion.spreading")),
            "heading_deg": self.heading_deg.draw(u("motion.heading_deg")),
            "speed_kn": self.speed_kn.draw(u("motion.speed_kn")),
            "components": self.components,
            "heel_deg": self.heel_deg.draw(u("motion.heel_deg")),
            "trim_deg": self.trim_deg.draw(u("motion.trim_deg")),
            "roll_damping_factor": self.roll_damping_factor.draw(u("motion.roll_damping_factor")),
            "gm_factor": self.gm_factor.draw(u("motion.gm_factor")),
            "deck_shift_m": [
                part.draw(u(f"motion.deck_shift_{axis}_m")) for part, axis in zip(shift, "xyz", strict=True)
            ],
        }
        if section["spectrum"] == "jonswap":
            section["gamma"] = self.gamma
        place = u("motion.tp")

        def with_height(hs_m: float) -> Section:
            tp_s = period_of_height(hs_m) * self.tp_factor.draw(place) if self.tp_s is None else self.tp_s.draw(place)
            return {**section, "hs_m": hs_m, "tp_s": tp_s}

        if self.lateral_g is None:
            return with_height(self._heights[0] if self.hs_m is None else self.hs_m.draw(u("motion.hs_m")))
        target = self.lateral_g.draw(u("motion.lateral_g"))
        height = solved(lambda hs_m: lateral_force_g(with_height(hs_m), seed) - target, *self._heights)
        return {**with_height(height), "lateral_g": target}

    def extremes(self) -> Extremes:
        """Sections that ask most of a table or of the ship, each with the key that is at fault if it is refused."""
        plain = self.model_copy(update={"lateral_g": None})  # nothing to solve for
        section = plain.draw(lambda name: 0.0, 0)
        hs_m, tp_s = min(self._steepest(), key=lambda sea: sea[1] ** 2 / sea[0])
        first, last = self.heading_deg.bounds
        ahead = 180.0 + 360.0 * np.ceil((first - 180.0) / 360.0)  # waves from ahead are met most often
        headings = (first, last) if ahead > last else (float(ahead),)
        spectrum = self.spectrum.possible[-1]
        fastest = {
            **({"gamma": self.gamma} if spectrum == "jonswap" else {}),
            "spectrum": spectrum,
            "hs_m": hs_m,
            "tp_s": tp_s,
            "spreading": self.spreading.possible[-1],
            "heading_deg": min(headings, key=lambda heading: np.cos(np.radians(heading))),
            "speed_kn": self.speed_kn.bounds[1],
        }
        section.pop("gamma", None)
        section["spectrum"] = "bretschneider"
        return [
            ("motion.ship", {**section, "speed_kn": 0.0}),
            ("motion.gm_factor", {**section, "speed_kn": 0.0, "gm_factor": self.gm_factor.bounds[0]}),
            ("motion.speed_kn", {**section, **fastest}),
        ]


def lateral_force_g(section: Section, seed: int) -> float:
    """Long-run RMS of the deck's lateral specific force [g] in the sea that a section and a seed give."""
    motion = parse_motion(section).realise(np.random.default_rng(seed))
    return motion.deck_rms().lateral_specific_force_g


def solved(excess: Callable[[float], float], low: float, high: float) -> float:
    """Where `excess` changes its sign between two bounds; the nearer bound where it does not.

    Regula falsi with the Illinois rule; the number of steps is limited, and the last place is taken.

    Args:
        excess: Function of a place, negative at the lower bound where there is something to solve for.
        low: Lower bound.
        high: Upper bound.
    """
    least, greatest = excess(low), excess(high)
    if least >= 0.0 or greatest <= 0.0:
        return low if abs(least) <= abs(greatest) else high
    kept = 0
    place = high
    close = _CLOSE * (greatest - least)
    for _ in range(_STEPS):
        place = (low * greatest - high * least) / (greatest - least)
        found = excess(place)
        if abs(found) <= close:
            break
        if found < 0.0:
            low, least, greatest = place, found, 0.5 * greatest if kept < 0 else greatest
            kept = -1
        else:
            high, greatest, least = place, found, 0.5 * least if kept > 0 else least
            kept = 1
    return place
