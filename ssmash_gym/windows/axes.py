"""The axes of a window: what a cell fixes, and where it goes in the scenario. A new axis is one entry of `AXES`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from ssmash_gym.ship.sea import comes_from_deg

Changes = dict[str, Any]


@dataclass(frozen=True)
class Axis:
    """Something that cells differ in.

    Attributes:
        label: In words, for charts.
        unit: Of its values.
        changes: The changes of the scenario (`scenario.changed_scenario`) for a value.
        stage: The only stage that it means something in; None for all.
    """

    label: str
    unit: str
    changes: Callable[[float], Changes]
    stage: str | None = None


def _sea_state(value: float) -> Changes:
    return {"motion": {"sea_state": int(value), "hs_m": None}}


AXES: Final[Mapping[str, Axis]] = {
    "sea_state": Axis("sea state", "", _sea_state),
    "hs_m": Axis("significant wave height", "m", lambda v: {"motion": {"hs_m": v, "sea_state": None}}),
    "waves_from_deg": Axis(
        "relative direction the waves come from",
        "deg",
        lambda v: {"motion": {"heading_deg": float(comes_from_deg(v))}},
    ),
    "speed_kn": Axis("speed of the ship", "kn", lambda v: {"motion": {"speed_kn": v}}),
    "wind_speed_mps": Axis("true wind", "m/s", lambda v: {"wind": {"speed_mps": v}}),
    "wind_from_deg": Axis(
        "relative direction the true wind comes from",
        "deg",
        lambda v: {"wind": {"from_deg": v}},
    ),
    "friction_factor": Axis("deck friction over dry", "1", lambda v: {"helicopter": {"friction_factor": v}}),
    "mass_factor": Axis("mass of the helicopter over nominal", "1", lambda v: {"helicopter": {"mass_factor": v}}),
    "sink_rate_m_s": Axis("sink rate at touchdown", "m/s", lambda v: {"start": {"sink_rate_m_s": v}}, "touchdown"),
}
WIND: Final = ("wind_speed_mps", "wind_from_deg")  # axes that need a wind given by itself
