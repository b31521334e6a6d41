"""The wind of a scenario: given by itself, or tied to the sea that is drawn. Both draw the same plain numbers."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from ssmash_gym.envs.ranges import Constant, Range, Section, Uniforms, within
from ssmash_gym.ship.sea import KNOT
from ssmash_gym.ship.wind import from_waves, true_wind_of_height

_ZERO: Final = Constant(constant=0.0)
_ONE: Final = Constant(constant=1.0)
WIND: Final = ("wind_speed_mps", "wind_from_deg", "wind_ship_speed_mps", "wind_gust_intensity")  # what is drawn


class _Wind(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    gust_intensity: Annotated[Range, within(0.0, 1.0)] = Field(
        _ZERO, description="RMS of the gusts over the mean true wind"
    )


class FreeWind(_Wind):
    """True wind given by itself; the helicopter feels it minus the ship's mean velocity."""

    type: Literal["free"] = "free"
    speed_mps: Annotated[Range, within(0.0, 60.0)] = Field(_ZERO, description="mean true wind speed [m/s]")
    from_deg: Range = Field(_ZERO, description="where the true wind comes from: 0 ahead, 90 starboard beam [deg]")
    ship_speed_mps: Annotated[Range, within(0.0, 30.0)] | None = Field(
        None, description="mean speed of the ship [m/s]: 0 where left out; with a seaway always the seaway's own"
    )

    def draw(self, u: Uniforms, motion: Section) -> dict[str, float]:
        """The numbers of `WIND`, for a drawn section of deck motion."""
        own = _ZERO if self.ship_speed_mps is None else self.ship_speed_mps
        return {
            "wind_speed_mps": self.speed_mps.draw(u("wind.speed_mps")),
            "wind_from_deg": self.from_deg.draw(u("wind.from_deg")),
            "wind_ship_speed_mps": seaway_speed_mps(motion, own.draw(u("wind.ship_speed_mps"))),
            "wind_gust_intensity": self.gust_intensity.draw(u("wind.gust_intensity")),
        }


class SeaWind(_Wind):
    """The wind that has raised the sea: its speed goes with the drawn height, its direction with the waves'."""

    type: Literal["sea"] = "sea"
    speed_factor: Annotated[Range, within(0.0, 2.0)] = Field(
        _ONE, description="on the speed that belongs to the height"
    )
    from_waves_deg: Range = Field(
        _ZERO, description="where the wind comes from, clockwise from where the waves come from [deg]"
    )

    def draw(self, u: Uniforms, motion: Section) -> dict[str, float]:
        """The numbers of `WIND`, for a drawn seaway."""
        speed = true_wind_of_height(motion["hs_m"]) * self.speed_factor.draw(u("wind.speed_factor"))
        return {
            "wind_speed_mps": speed,
            "wind_from_deg": from_waves(motion["heading_deg"], self.from_waves_deg.draw(u("wind.from_waves_deg"))),
            "wind_ship_speed_mps": seaway_speed_mps(motion, 0.0),
            "wind_gust_intensity": self.gust_intensity.draw(u("wind.gust_intensity")),
        }


def seaway_speed_mps(motion: Section, otherwise: float) -> float:
    """Speed of the ship [m/s] in a drawn section of deck motion; `otherwise` where that is no seaway."""
    return KNOT * float(motion["speed_kn"]) if motion["type"] == "seaway" else otherwise


def free_by_default(given: Any) -> Any:
    """A wind section without `type` is a free wind."""
    return {"type": "free", **given} if isinstance(given, dict) and "type" not in given else given


WindRanges = Annotated[FreeWind | SeaWind, Field(discriminator="type")]
